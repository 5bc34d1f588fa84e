//! The Python package's Rust half, `rvachev._rvachev`: what `rvachev` re-exports and describes in its stubs.
//!
//! The interpreter is free while the library works; it is taken for callbacks only.

mod arrays;
mod bricks;
mod edges;
mod errors;
mod expr;
mod field;
mod look;
mod mesh;
mod model;
mod options;
mod over;
mod part;
mod pickle;
mod prisms;
mod solid;
mod text;
mod work;

use pyo3::prelude::*;
use rvachev::implicit::Expr;

#[pymodule]
fn _rvachev(m: &Bound<'_, PyModule>) -> PyResult<()> {
    m.add_class::<expr::PyExpr>()?;
    m.add_class::<solid::PySolid>()?;
    m.add_class::<edges::Edges>()?;
    m.add_class::<edges::Built>()?;
    m.add_class::<part::PyPart>()?;
    m.add_class::<mesh::PyMesh>()?;
    m.add_class::<prisms::PyPrisms>()?;
    m.add_class::<prisms::PyHexahedra>()?;
    m.add_class::<bricks::PyTask>()?;
    m.add_class::<bricks::PyPiece>()?;
    for (name, expr) in [("x", Expr::x()), ("y", Expr::y()), ("z", Expr::z())] {
        m.add(name, expr::PyExpr { expr })?;
    }
    m.add_function(wrap_pyfunction!(solid::made, m)?)?;
    m.add_function(wrap_pyfunction!(solid::extruded, m)?)?;
    m.add_function(wrap_pyfunction!(solid::revolved, m)?)?;
    m.add_function(wrap_pyfunction!(solid::solid, m)?)?;
    m.add_function(wrap_pyfunction!(solid::union, m)?)?;
    m.add_function(wrap_pyfunction!(solid::intersection, m)?)?;
    m.add_function(wrap_pyfunction!(solid::blend, m)?)?;
    m.add_function(wrap_pyfunction!(field::field, m)?)?;
    m.add_function(wrap_pyfunction!(field::grid, m)?)?;
    m.add_function(wrap_pyfunction!(part::mesh, m)?)?;
    m.add_function(wrap_pyfunction!(part::expected_triangles, m)?)?;
    m.add_function(wrap_pyfunction!(part::remesh, m)?)?;
    m.add_function(wrap_pyfunction!(part::heal, m)?)?;
    m.add_function(wrap_pyfunction!(part::check, m)?)?;
    m.add_function(wrap_pyfunction!(part::evaluate, m)?)?;
    m.add_function(wrap_pyfunction!(mesh::read_triangles, m)?)?;
    m.add_function(wrap_pyfunction!(over::carry, m)?)?;
    m.add_function(wrap_pyfunction!(over::shortest_path, m)?)?;
    m.add_function(wrap_pyfunction!(over::join, m)?)?;
    m.add_function(wrap_pyfunction!(model::step_check, m)?)?;
    m.add_function(wrap_pyfunction!(model::step_info, m)?)?;
    m.add_function(wrap_pyfunction!(model::compare, m)?)?;
    m.add_function(wrap_pyfunction!(model::compare_rsystems, m)?)?;
    m.add_function(wrap_pyfunction!(model::compare_samples, m)?)?;
    m.add_function(wrap_pyfunction!(model::compare_triangles, m)?)?;
    m.add_function(wrap_pyfunction!(model::triangles_info, m)?)?;
    m.add_function(wrap_pyfunction!(look::picture, m)?)?;
    m.add_function(wrap_pyfunction!(look::curvature, m)?)?;
    m.add_function(wrap_pyfunction!(look::node_classes, m)?)?;
    m.add_function(wrap_pyfunction!(look::distances, m)?)?;
    m.add_function(wrap_pyfunction!(pickle::mesh_again, m)?)?;
    m.add_function(wrap_pyfunction!(pickle::part_again, m)?)?;
    m.add_function(wrap_pyfunction!(bricks::plan, m)?)?;
    m.add_function(wrap_pyfunction!(bricks::mesh_brick, m)?)?;
    m.add_function(wrap_pyfunction!(bricks::merge, m)?)?;
    m.add_function(wrap_pyfunction!(bricks::task_again, m)?)?;
    m.add_function(wrap_pyfunction!(bricks::piece_again, m)?)?;
    m.add("__version__", env!("CARGO_PKG_VERSION"))?;
    Ok(())
}
