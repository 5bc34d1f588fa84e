//! The command that joins mesh files.

use std::path::PathBuf;

use clap::Args;
use rvachev::pipeline::{self, JoinReport, SizeRequest};
use rvachev::{Result, io};

use super::arguments::{CommonArguments, Files, width};
use super::commands::{to_json, write_meshes, written_as};
use super::console::{note, run, say};

/// Meshes to join.
#[derive(Debug, Args)]
pub struct JoinArguments {
    /// Mesh files, two or more; where nodes match, those of the first one stay where they are
    #[arg(required = true, num_args = 2.., value_name = "MESH")]
    pub meshes: Vec<PathBuf>,
    /// Mesh file to write; the ending tells the format; may be given more than once
    #[arg(short, long, required = true, value_name = "MESH")]
    pub output: Vec<PathBuf>,
    /// Nodes no farther apart than this are one: a length, or a share of the diagonal such as 0.01%; 0 matches only the same coordinates [default: 0.0001%]
    #[arg(long, value_name = "LENGTH", value_parser = width)]
    pub within: Option<SizeRequest>,
    #[command(flatten)]
    pub files: Files,
    /// The report as one JSON object instead of a table
    #[arg(long)]
    pub json: bool,
    #[command(flatten)]
    pub common: CommonArguments,
}

fn told(r: &JoinReport) -> String {
    format!(
        "{} nodes matched within {:.3e}, moved by at most {:.3e}\n{} nodes, {} triangles; {} open edges",
        r.matched, r.within, r.farthest, r.nodes, r.triangles, r.open_edges
    )
}

/// What is not wrong by itself, but may not be meant.
fn warnings(r: &JoinReport) -> Vec<String> {
    [
        (
            r.misoriented_edges,
            "edges are run through in one direction from both sides: a mesh is inside out, heal turns it",
        ),
        (r.nonmanifold_edges, "edges have more than two triangles"),
        (r.doubled, "triangles lie on another one with the same nodes"),
    ]
    .into_iter()
    .filter(|(count, _)| *count > 0)
    .map(|(count, what)| format!("{count} {what}"))
    .collect()
}

pub fn join(a: &JoinArguments) -> Result<bool> {
    let how = written_as(&a.files);
    io::check_all_writable(&a.output, &how)?;
    let run = run(&a.common, "join")?;
    let joined = pipeline::join_files(&a.meshes, a.within, &run)?;
    let mut told_of = write_meshes(&a.output, &joined.mesh, &how, &run)?;
    drop(run);
    for i in &joined.report.alone {
        told_of.shortfalls.push(format!("{} has no node in common with the others", a.meshes[*i].display()));
    }
    if a.json {
        say(&to_json(&joined.report)?);
    } else if !a.common.quiet {
        say(&told(&joined.report));
        note("warning", &[warnings(&joined.report), told_of.warnings].concat());
    }
    note("falls short", &told_of.shortfalls);
    Ok(told_of.shortfalls.is_empty())
}
