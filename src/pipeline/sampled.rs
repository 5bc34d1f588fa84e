//! A part's function at points of a table, and on a regular grid.

use std::io::{BufRead, Write};
use std::path::Path;
use std::sync::Arc;

use glam::DVec3;
use rayon::prelude::*;
use serde::Serialize;

use super::SizeRequest;
use super::boolean::{as_functions, holds_foreign};
use super::brep::is_step;
use super::figure::no_figure;
use crate::error::{Error, Place, Result};
use crate::implicit::part::Part;
use crate::implicit::{Boundary, Foreign, Implicit, Primitive, RSystem, Sampling, Solid, evaluate};
use crate::io::{PointRows, PointSample, SampledGrid, no_rows, write_rows};
use crate::numeric::ROUNDING;
use crate::run::{GIB, Run};

/// Rows read before they are evaluated and written: some megabytes, and enough for all threads.
const ROWS: usize = 1 << 16;

/// Rows of one piece of text.
const TEXT_ROWS: usize = 1 << 12;

/// Nodes of a grid evaluated at a time.
const NODES: usize = 1 << 17;

/// Cells along the longest side of a grid without a wish for it.
const CELLS: u32 = 64;

/// The room around a part's box without a wish for it, as a share of the diagonal.
const MARGIN: f64 = 0.05;

/// A part that is the solid in a STEP file or inside closed triangles, whose faces keep their names. Nothing is read yet.
pub fn boundary_part(path: &Path) -> Part {
    let path = path.to_path_buf();
    let source = if is_step(&path) { Boundary::Step(path) } else { Boundary::Mesh(path) };
    let foreign = Foreign { source, place: Place::Unknown };
    Part::from_solid(Solid::from(Primitive::Foreign(Arc::new(foreign))).name(""))
}

/// The solid of a part, with those that are built from edges.
fn whole(part: &Part) -> Option<Solid> {
    let built = part.built.iter().map(|recipe| {
        let foreign = Foreign { source: Boundary::Built(Box::new(recipe.clone())), place: recipe.place.clone() };
        Solid::from(Primitive::Foreign(Arc::new(foreign)))
    });
    let all: Vec<Solid> = part.solid.iter().cloned().chain(built).collect();
    (!all.is_empty()).then(|| if all.len() == 1 { all[0].clone() } else { Solid::union(all) })
}

/// The function of a part, in its own R-system or the given one. Meshes, STEP models and solids built from edges that are joined with
/// others, or alone, are leaves, too: their value is the distance to the boundary, positive inside, and faces are theirs. That is exact to
/// rounding but on edges of curved faces: there to a 250th of the solid.
///
/// Errors: the part has no solid of R-functions; see [`Implicit::new`]; boundaries that cannot be read or are not closed, at their place in
/// the part file; cancellation.
pub fn function(part: &Part, rsystem: Option<RSystem>, run: &Run) -> Result<Implicit> {
    no_figure(part, "its function")?;
    let Some(solid) = whole(part) else {
        return Err(Error::input(Place::Unknown, "the part has no solid, and so no function"));
    };
    lowered(part, &solid, rsystem.unwrap_or(part.rsystem), run)
}

/// A solid of a part made ready, with boundaries as distances.
pub(super) fn lowered(part: &Part, solid: &Solid, rsystem: RSystem, run: &Run) -> Result<Implicit> {
    let functions = holds_foreign(solid).then(|| as_functions(part, solid, run)).transpose()?;
    Implicit::new(functions.as_ref().unwrap_or(solid), rsystem, part.domain).map_err(|e| part.located(e))
}

/// What was met in evaluating a table of points.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
pub struct EvalSummary {
    /// Points evaluated.
    pub points: u64,
    /// How many of them are inside.
    pub inside: u64,
    /// At how many of them the value or the gradient is NaN or infinite.
    pub not_finite: u64,
    /// The line of the first of those.
    pub first_not_finite: Option<usize>,
}

/// Evaluates a function at the points of a table and writes a row for each, see [`PointSample`]. The table is read, evaluated and
/// written in blocks, so its length does not matter.
///
/// Guarantees: the same bytes for any number of threads. Where the other end of a pipe was closed nothing more is done.
///
/// Errors: a bad row, or none; what cannot be read or written; cancellation. Rows before a bad one may have been written.
pub fn eval_points<R: BufRead>(
    model: &Implicit,
    rows: &mut PointRows<R>,
    out: &mut dyn Write,
    run: &Run,
) -> Result<EvalSummary> {
    let mut summary = EvalSummary::default();
    let (mut points, mut lines) = (Vec::new(), Vec::new());
    loop {
        rows.read(ROWS, &mut points, &mut lines)?;
        if points.is_empty() {
            break;
        }
        let found = evaluate(model, &points, Sampling { gradients: true, faces: true }, run)?;
        let finite = |i: &usize| found.values[*i].is_finite() && found.gradients[*i].is_finite();
        let bad: Vec<usize> = (0..points.len()).filter(|i| !finite(i)).collect();
        summary.not_finite += bad.len() as u64;
        summary.first_not_finite = summary.first_not_finite.or(bad.first().map(|i| lines[*i]));
        summary.inside += found.inside.iter().filter(|i| **i).count() as u64;
        let text = |block: usize| {
            let mut text = Vec::new();
            for i in block * TEXT_ROWS..((block + 1) * TEXT_ROWS).min(points.len()) {
                let face = found.faces[i].and_then(|f| model.faces().get(f as usize));
                let row = PointSample {
                    point: points[i],
                    value: found.values[i],
                    gradient: found.gradients[i],
                    inside: found.inside[i],
                    face: face.map_or("", |f| &f.name),
                    leaf: found.leaves[i],
                };
                row.write(&mut text);
            }
            text
        };
        let blocks = points.len().div_ceil(TEXT_ROWS);
        let texts: Vec<Vec<u8>> = run.install(|| (0..blocks).into_par_iter().map(text).collect());
        if summary.points == 0 && !write_rows(out, PointSample::HEADER.as_bytes())? {
            return Ok(summary);
        }
        summary.points += points.len() as u64;
        for text in &texts {
            if !write_rows(out, text)? {
                return Ok(summary);
            }
        }
    }
    if summary.points == 0 {
        return Err(no_rows().in_file(rows.name()));
    }
    Ok(summary)
}

/// How finely a grid is spaced.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum GridSpacing {
    /// This many cells along the longest side.
    Cells(u32),
    /// This distance between neighboring nodes, in the part's unit.
    Step(f64),
}

/// What is sampled on a grid, and where.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GridOptions {
    /// How finely.
    pub spacing: GridSpacing,
    /// Room around the part's box, on each side.
    pub margin: SizeRequest,
    /// Gradients too.
    pub gradients: bool,
    /// Labels of faces too.
    pub faces: bool,
    /// Bytes the samples may take.
    pub memory: u64,
}

impl Default for GridOptions {
    fn default() -> Self {
        GridOptions {
            spacing: GridSpacing::Cells(CELLS),
            margin: SizeRequest::Share(MARGIN),
            gradients: false,
            faces: false,
            memory: 8 << 30,
        }
    }
}

/// Samples a function on a regular grid over the part's box and a margin. Cells are cubes; the grid has the box's center.
///
/// Guarantees: what stands at a node is what [`evaluate`] finds there; the same for any number of threads.
///
/// Errors: [`Error::Usage`] for a spacing that is not positive, and for more nodes than memory was allowed for; cancellation.
pub fn sample_grid(model: &Implicit, options: &GridOptions, run: &Run) -> Result<SampledGrid> {
    let bounds = model.bounds();
    let margin = options.margin.length(bounds.diagonal());
    let side = bounds.hi - bounds.lo + 2.0 * margin;
    let step = match options.spacing {
        GridSpacing::Cells(n) => side.max_element() / f64::from(n),
        GridSpacing::Step(h) => h,
    };
    if !(step > 0.0 && step.is_finite() && margin >= 0.0) {
        return Err(Error::Usage(format!(
            "a grid needs a positive step and a margin of at least 0, not {step} and {margin}"
        )));
    }
    // Sides may be a little longer than whole steps without another cell: what rounding makes of a side that fits.
    let cells = (side / step * (1.0 - ROUNDING)).ceil().max(DVec3::ONE);
    let count = (cells + 1.0).element_product();
    let each = 8 + if options.gradients { 24 } else { 0 } + if options.faces { 4 } else { 0 };
    let needed = count * f64::from(each);
    if needed > options.memory as f64 || cells.max_element() > f64::from(i32::MAX) {
        return Err(Error::Usage(format!(
            "a grid with step {step:e} has {count:.3e} points and needs {:.3} GiB of memory, more than the {:.3} allowed",
            needed / GIB,
            options.memory as f64 / GIB
        )));
    }
    let nodes = cells.to_array().map(|n| n as usize + 1);
    let origin = bounds.center() - 0.5 * step * cells;
    let all = nodes.iter().product::<usize>();
    let mut grid = SampledGrid {
        origin,
        step,
        nodes,
        values: Vec::with_capacity(all),
        gradients: options.gradients.then(|| Vec::with_capacity(all)),
        faces: options.faces.then(|| Vec::with_capacity(all)),
        names: model.faces().iter().map(|f| f.name.clone()).collect(),
    };
    let wanted = Sampling { gradients: options.gradients, faces: options.faces };
    let mut points = Vec::new();
    for first in (0..all).step_by(NODES) {
        run.progress("grid", first as f64 / all as f64);
        points.clear();
        points.extend((first..(first + NODES).min(all)).map(|i| grid.node(i)));
        let found = evaluate(model, &points, wanted, run)?;
        grid.values.extend(found.values);
        if let Some(list) = &mut grid.gradients {
            list.extend(found.gradients);
        }
        if let Some(list) = &mut grid.faces {
            list.extend(found.faces.iter().map(|f| f.map_or(-1, |f| f as i32)));
        }
    }
    Ok(grid)
}
