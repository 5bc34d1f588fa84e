//! The commands that ask a part's function: at points, on a grid.

use std::fs::File;
use std::io::{BufRead, BufReader, BufWriter, Write};
use std::path::Path;

use rvachev::io::{self, GridFormat, PointRows};
use rvachev::pipeline::{self, GridOptions, GridSpacing, Part};
use rvachev::{Error, Place, Result};

use super::arguments::{Eval, FunctionOf, GridFile};
use super::console::{note, run, say, writable};

/// Bytes read and written at a time.
const BUFFER: usize = 1 << 18;

/// A part whose R-functions are asked for. STEP files and meshes have none.
pub fn function_part(path: &Path, define: &[(String, f64)]) -> Result<Part> {
    if pipeline::is_step(path) || pipeline::is_mesh(path) {
        let what = "only parts of R-functions have a function, and this is a boundary";
        return Err(Error::input(Place::Unknown, what).in_file(path));
    }
    pipeline::load_part(path, define)
}

/// A part whose function is asked for at points: of a boundary it is the distance to that.
fn asked(of: &FunctionOf) -> Result<Part> {
    if pipeline::is_step(&of.part) || pipeline::is_mesh(&of.part) {
        return Ok(pipeline::boundary_part(&of.part));
    }
    pipeline::load_part(&of.part, &of.define)
}

pub fn eval(a: &Eval) -> Result<bool> {
    a.output.iter().try_for_each(|p| writable(p))?;
    let part = asked(&a.of)?;
    let run = run(&a.common, "eval")?;
    let model = pipeline::function(&part, a.of.rsystem, &run).map_err(|e| e.in_file(&a.of.part))?;
    let (from, name): (Box<dyn BufRead>, &str) = if a.points.as_os_str() == "-" {
        (Box::new(std::io::stdin().lock()), "standard input")
    } else {
        let file = File::open(&a.points).map_err(|e| Error::io("read", &a.points, e))?;
        (Box::new(BufReader::with_capacity(BUFFER, file)), "")
    };
    let name = if name.is_empty() { a.points.as_path() } else { Path::new(name) };
    let mut rows = PointRows::new(from, name);
    let mut summary = pipeline::EvalSummary::default();
    match &a.output {
        Some(path) => io::write_atomic(path, |out| {
            summary = pipeline::eval_points(&model, &mut rows, out, &run)?;
            Ok(())
        })?,
        None => {
            let mut out = BufWriter::with_capacity(BUFFER, std::io::stdout().lock());
            let done = pipeline::eval_points(&model, &mut rows, &mut out, &run);
            // A closed pipe is not an error, what else keeps rows from being written is.
            let flushed = out.flush();
            summary = done.map_err(named)?;
            if let Err(e) =
                flushed.or_else(|e| if e.kind() == std::io::ErrorKind::BrokenPipe { Ok(()) } else { Err(e) })
            {
                return Err(Error::io("write", "standard output", e));
            }
        }
    }
    drop(run);
    if a.output.is_some() && !a.common.quiet {
        say(&format!("{} points, {} of them inside", summary.points, summary.inside));
    }
    if let Some(line) = summary.first_not_finite {
        let n = summary.not_finite;
        note(
            "falls short",
            &[format!("at {n} points the value or gradient is not a finite number, first in line {line}")],
        );
    }
    Ok(summary.not_finite == 0)
}

/// Gives standard output its name in an error of writing.
fn named(e: Error) -> Error {
    match e {
        Error::Io { path, action: "write", source } if path.as_os_str().is_empty() => {
            Error::io("write", "standard output", source)
        }
        other => other,
    }
}

pub fn grid(a: &GridFile) -> Result<bool> {
    if GridFormat::from_path(&a.output)? == GridFormat::Npy && (a.gradient || a.faces) {
        return Err(Error::Usage("an .npy file holds values alone; write gradients and faces to a .vti file".into()));
    }
    let part = asked(&a.of)?;
    let run = run(&a.common, "grid")?;
    let model = pipeline::function(&part, a.of.rsystem, &run).map_err(|e| e.in_file(&a.of.part))?;
    let usual = GridOptions::default();
    let spacing = match (a.cells, a.step) {
        (Some(n), _) => GridSpacing::Cells(n),
        (None, Some(h)) => GridSpacing::Step(h),
        (None, None) => usual.spacing,
    };
    let options = GridOptions {
        spacing,
        margin: a.margin.unwrap_or(usual.margin),
        gradients: a.gradient,
        faces: a.faces,
        memory: (a.memory * (1u64 << 30) as f64) as u64,
    };
    let grid = pipeline::sample_grid(&model, &options, &run)?;
    io::write_grid(&a.output, &grid, &run)?;
    drop(run);
    if !a.common.quiet {
        let [x, y, z] = grid.nodes;
        let o = grid.origin;
        say(&format!("{x} x {y} x {z} points from ({}, {}, {}), step {}", o.x, o.y, o.z, grid.step));
    }
    let Some((count, first)) = grid.not_finite() else { return Ok(true) };
    let at = format!("({:.6}, {:.6}, {:.6})", first.x, first.y, first.z);
    note("falls short", &[format!("at {count} points the value or gradient is not a finite number, first at {at}")]);
    Ok(false)
}
