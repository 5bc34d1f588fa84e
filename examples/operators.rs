//! The operators one at a time, each a function of a mesh and an oracle, on a cube with two crossing holes.
//!
//! After each the normal deviation (equation 5 of [LIS14]) is printed, with the triangles that are inverted. The same
//! functions take any mesh with any oracle.

use rvachev::implicit::{ExtractOptions, Implicit, ImplicitOracle, RSystem, Solid, extract};
use rvachev::mesh::EditMesh;
use rvachev::optimize::classify::{classify_by_curvature, classify_by_edges};
use rvachev::optimize::crease::{cut_creases, settle_creases};
use rvachev::optimize::dual::snap_to_planes;
use rvachev::optimize::normal::align_normals;
use rvachev::optimize::smooth::{CreaseStep, smooth_all, smooth_edges, smooth_regular};
use rvachev::optimize::surface::{normal_deviation, survey};
use rvachev::{DVec3, Result, Run};

/// Cell size, and so how far an operator looks for the surface.
const SIZE: f64 = 0.06;
/// Creases are where normals differ by more degrees than this.
const CREASE: f64 = 20.0;

fn main() -> Result<()> {
    let run = Run::new();
    let cube = Solid::cuboid(DVec3::splat(-1.0), DVec3::splat(1.0));
    let holes = [DVec3::X, DVec3::Z].map(|axis| Solid::cylinder(0.4, axis, DVec3::ZERO, None));
    let model = Implicit::new(&(cube - Solid::union(holes)), RSystem::R0, None)?;
    let extracted = extract(&model, &ExtractOptions::new(SIZE), &run)?;
    let oracle = ImplicitOracle::new(&model, &extracted);

    let mut mesh = EditMesh::new(&extracted.mesh)?;
    let say = |what: &str, mesh: &EditMesh| -> Result<f64> {
        let d = normal_deviation(mesh, &oracle, SIZE, &run)?;
        println!("{what:<46} normal deviation {:.2e}, {} inverted", d.normal, d.inverted);
        Ok(d.normal)
    };
    let first = say("marching cubes", &mesh)?;

    smooth_all(&mut mesh, &oracle, SIZE, &run)?;
    say("R_all: every node to its neighbors' middle", &mesh)?;
    align_normals(&mut mesh, &oracle, SIZE, 1.0, &run)?;
    say("N: triangles into tangent planes", &mesh)?;
    snap_to_planes(&mut mesh, &oracle, SIZE, 0.0, &run)?;
    say("N1: nodes to where tangent planes meet", &mesh)?;

    let classes = classify_by_curvature(&mesh, CREASE, &run)?;
    let [regular, edge, corner] = classes.counts();
    println!("two-means of curvature: {regular} regular nodes, {edge} on creases, {corner} corners");

    let report = cut_creases(&mut mesh, &oracle, SIZE, CREASE, &run)?;
    println!("creases cut into the mesh: {} edges of it lie on them", report.sharp);
    survey(&mut mesh, &oracle, SIZE, &run)?;
    say("creases cut", &mesh)?;
    for _ in 0..3 {
        let classes = classify_by_edges(&mesh);
        smooth_edges(&mut mesh, &oracle, CreaseStep { classes: &classes, c: 1.0 }, SIZE, &run)?;
        smooth_regular(&mut mesh, &oracle, &classes, SIZE, &run)?;
    }
    say("R_edge and R_regular, three times", &mesh)?;
    settle_creases(&mut mesh, &oracle, SIZE, &run)?;
    let last = say("nodes settled on their creases", &mesh)?;

    assert!(last < 0.1 * first);
    let finished = mesh.to_mesh();
    let euler = finished.topology(&finished.defects()).euler;
    println!("Euler characteristic {euler}");
    assert_eq!(euler, -4);
    Ok(())
}
