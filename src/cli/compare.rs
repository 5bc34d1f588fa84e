//! The command that compares methods: on a part stage by stage, on triangles, and on the samples side by side.

use std::path::Path;

use rvachev::pipeline::{self, Coloring, MeshOptions, Method, PictureSheet};
use rvachev::{Error, Result, Run};

use super::arguments::{Compare, StageColor};
use super::commands::{options, sequence, soup_options, write_json};
use super::console::{picture, run, say, writable};
use super::sample::function_part;

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
    sheet(a)?.iter().try_for_each(|s| s.stages(&c, run))?;
    a.json.iter().try_for_each(|p| write_json(p, &c))?;
    Ok(c.to_string())
}

/// Compares on the samples, and writes what is asked for. The table.
fn of_samples(a: &Compare, how: &MeshOptions, run: &Run) -> Result<String> {
    let c = pipeline::compare_samples(how, run)?;
    sheet(a)?.iter().try_for_each(|s| s.samples(&c, run))?;
    a.json.iter().try_for_each(|p| write_json(p, &c))?;
    Ok(c.to_string())
}

/// The picture that is asked for.
fn sheet(a: &Compare) -> Result<Option<PictureSheet>> {
    let color = match a.color {
        StageColor::Angle => Coloring::Angle,
        StageColor::Class => Coloring::Class,
    };
    a.png.as_ref().map(|path| PictureSheet::new(path, Some(color))).transpose()
}
