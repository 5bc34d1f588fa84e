//! The command that compares methods: on a part stage by stage, on triangles, and on the samples side by side.

use std::path::{Path, PathBuf};

use rvachev::mesh::TriMesh;
use rvachev::pipeline::{self, Comparison, MeshOptions, Method, Sample, SampleComparison};
use rvachev::render::{self as draw, ColorBy, Picture, RenderOptions, View};
use rvachev::{Error, Result, Run};

use super::arguments::{Compare, StageColor};
use super::commands::{options, sequence, soup_options, write_json};
use super::console::{picture, run, say, writable};
use super::sample::function_part;

/// Pictures of a comparison stand in rows of this many.
const SHEET_COLUMNS: usize = 6;

/// Width and height of one picture of a comparison.
const SHEET_CELL: (usize, usize) = (420, 360);

/// The radius of what a picture of a comparison shows, in cells: near enough to see single triangles.
const SHEET_FOCUS: f64 = 9.0;

/// Width and height of one picture of a sample: the longest caption has 46 characters, 12 pixels each.
const SAMPLE_CELL: (usize, usize) = (560, 520);

pub fn compare(a: &Compare) -> Result<bool> {
    a.json.iter().try_for_each(|p| writable(p))?;
    a.png.iter().try_for_each(|p| picture(p))?;
    let run = run(&a.common, "compare")?;
    let how = MeshOptions { sequence: sequence(&a.operators)?, ..options(&a.how, Method::default(), true) };
    if how.volume.is_some() || !how.without.is_empty() {
        let what = "compare takes neither --volume nor --without";
        return Err(Error::Usage(what.into()));
    }
    let text = match &a.part {
        None => of_samples(a, &MeshOptions { timed: true, ..how }, &run)?,
        Some(part) if a.rsystems => {
            let of = function_part(part, &a.define)?;
            let c = pipeline::compare_rsystems(&of, &how, &run).map_err(|e| e.in_file(part))?;
            a.json.iter().try_for_each(|p| write_json(p, &c))?;
            c.to_string()
        }
        Some(part) => of_part(part, a, &how, &run)?,
    };
    drop(run);
    if !a.common.quiet {
        say(&text);
    }
    Ok(true)
}

/// Compares on one part or mesh, and writes what is asked for. The table.
fn of_part(part: &Path, a: &Compare, how: &MeshOptions, run: &Run) -> Result<String> {
    let c = if pipeline::is_mesh(part) {
        let mesh = pipeline::load_mesh(part, run)?;
        pipeline::compare_soup(&mesh, how, &soup_options(&a.triangles), run)
    } else {
        pipeline::compare(&pipeline::load_part(part, &a.define)?, how, run)
    };
    let c = c.map_err(|e| e.in_file(part))?;
    written(a, &c, || stages(&c, a.color, run))?;
    Ok(c.to_string())
}

/// Compares on the samples, and writes what is asked for. The table.
fn of_samples(a: &Compare, how: &MeshOptions, run: &Run) -> Result<String> {
    let c = pipeline::compare_samples(how, run)?;
    written(a, &c, || samples(&c, a.color, run))?;
    Ok(c.to_string())
}

fn written(a: &Compare, rows: &impl serde::Serialize, drawn: impl FnOnce() -> Result<Picture>) -> Result<()> {
    let png: Option<&PathBuf> = a.png.as_ref();
    if let Some(path) = png {
        pipeline::write_picture(path, &drawn()?)?;
    }
    a.json.iter().try_for_each(|p| write_json(p, rows))
}

/// All stages of all methods, near one place.
fn stages(c: &Comparison, color: StageColor, run: &Run) -> Result<Picture> {
    let view = View { focus: c.focus.map(|p| (p, SHEET_FOCUS * c.size)), margin: 0.0, ..View::default() };
    let cell = |row: &pipeline::Row| {
        Ok((format!("{}: {}", row.method, row.stage), drawn(&row.mesh, SHEET_CELL, view, color, run)?))
    };
    Ok(draw::sheet(&c.rows.iter().map(cell).collect::<Result<Vec<_>>>()?, SHEET_COLUMNS))
}

/// A row of pictures for each sample, a column for each method.
fn samples(c: &SampleComparison, color: StageColor, run: &Run) -> Result<Picture> {
    let cell = |row: &pipeline::SampleRow| {
        let found = row.check.features.as_ref().map_or_else(String::new, |f| {
            format!(", recall {:.3}, {}/{} corners", f.recall, f.corners_found, f.corners_true)
        });
        let caption = format!("{}: {}{found}", row.sample, row.method);
        let sample = Sample::ALL.into_iter().find(|s| s.name == row.sample);
        let view = sample.map_or_else(View::default, |s| View::from_angles(s.view[0], s.view[1]));
        Ok((caption, drawn(&row.mesh, SAMPLE_CELL, view, color, run)?))
    };
    Ok(draw::sheet(&c.rows.iter().map(cell).collect::<Result<Vec<_>>>()?, Method::ALL.len()))
}

fn drawn(mesh: &TriMesh, cell: (usize, usize), view: View, color: StageColor, run: &Run) -> Result<Picture> {
    let color_by = match color {
        StageColor::Angle => ColorBy::Angle,
        StageColor::Class => match pipeline::node_classes(mesh, run) {
            // A stage may leave a mesh that is no manifold, whose nodes have no classes.
            Err(Error::Input { .. }) => ColorBy::Class(vec![0; mesh.nodes.len()]),
            classes => ColorBy::Class(classes?),
        },
    };
    let (width, height) = cell;
    draw::render(mesh, &RenderOptions { width, height, view, color_by, legend: false, ..RenderOptions::default() }, run)
}
