//! Meshes brick by brick: plan, bricks, merge, and all of it at once.

use std::path::{Path, PathBuf};

use clap::Args;
use rvachev::io::{self, Format, WriteOptions};
use rvachev::pipeline::{self, BrickPlan, MergedBricks, Method, PlanSource, ROUNDS, Share};
use rvachev::{Error, Result};

use super::arguments::{CommonArguments, Files, Mesh, MeshingArguments, PartFile};
use super::commands::{Told, ended, options, refused, shown, write_meshes, write_report, written_as};
use super::console::{note, run, say, unwatched, watched, writable};

#[derive(Debug, Args)]
pub struct PlanArguments {
    #[command(flatten)]
    pub part: PartFile,
    /// How many bricks along x, y and z, as 4x4x2; fewer where they would be narrower than 24 edges
    #[arg(long, value_name = "XxYxZ", value_parser = bricks)]
    pub bricks: [u32; 3],
    /// Folder for the plan and the pieces
    #[arg(short, long, value_name = "FOLDER")]
    pub output: PathBuf,
    #[command(flatten)]
    pub how: MeshingArguments,
    #[command(flatten)]
    pub common: CommonArguments,
}

#[derive(Debug, Args)]
pub struct Brick {
    /// Folder of the plan
    #[arg(value_name = "FOLDER")]
    pub folder: PathBuf,
    /// Which bricks: the Kth of N shares, from 1. What is there already is not made again
    #[arg(long, value_name = "K/N", default_value = "1/1", value_parser = share)]
    pub share: Share,
    /// Which of the three rounds; each needs the one before [default: all, for one share of all]
    #[arg(long, value_name = "ROUND", value_parser = clap::value_parser!(u32).range(1..=ROUNDS as i64))]
    pub round: Option<u32>,
    #[command(flatten)]
    pub common: CommonArguments,
}

#[derive(Debug, Args)]
pub struct MergeArguments {
    /// Folder of the plan and its pieces
    #[arg(value_name = "FOLDER")]
    pub folder: PathBuf,
    /// Mesh file to write; the ending tells the format; may be given more than once
    #[arg(short, long, required = true, value_name = "MESH")]
    pub output: Vec<PathBuf>,
    #[command(flatten)]
    pub files: Files,
    /// Write the mesh even if it is not sound (it intersects itself, say); without this nothing is written then
    #[arg(long)]
    pub force: bool,
    /// Write the report here: tables to read (.html), else JSON
    #[arg(long, value_name = "FILE")]
    pub report: Option<PathBuf>,
    #[command(flatten)]
    pub common: CommonArguments,
}

/// Three numbers with an x between them.
pub fn bricks(s: &str) -> std::result::Result<[u32; 3], String> {
    let numbers: Vec<u32> =
        s.split('x').filter_map(|n| n.trim().parse().ok()).filter(|n| (1..=1024).contains(n)).collect();
    match numbers[..] {
        [a, b, c] if s.split('x').count() == 3 => Ok([a, b, c]),
        _ => Err(format!("{s:?} is not three numbers from 1 to 1024 such as 4x4x2")),
    }
}

fn share(s: &str) -> std::result::Result<Share, String> {
    let (k, n) = s.split_once('/').ok_or_else(|| format!("{s:?} is not K/N"))?;
    let number = |x: &str| x.trim().parse::<u32>().map_err(|_| format!("{s:?} is not K/N"));
    let share = Share { number: number(k)?, of: number(n)? };
    if share.number >= 1 && share.number <= share.of { Ok(share) } else { Err(format!("there is no share {s}")) }
}

pub fn plan(a: &PlanArguments) -> Result<bool> {
    let run = run(&a.common, "plan")?;
    let plan = plan_of(&a.part, &a.how, a.bricks, &run)?;
    plan.save(&a.output)?;
    drop(run);
    if !a.common.quiet {
        let [x, y, z] = plan.bricks();
        let [first, second, third] = plan.rounds();
        say(&format!("{x} x {y} x {z} bricks of {first}, {second} and {third} in the three rounds"));
        let folder = a.output.display();
        say("on one machine:");
        say(&format!("  rvachev brick {folder} && rvachev merge {folder} -o part.vtu"));
        say("with SLURM, 64 shares:");
        let array = |round: u32, after: &str| {
            format!(
                "  R{round}=$(sbatch --parsable --array=1-64{after} --wrap='rvachev brick {folder} --round {round} --share $SLURM_ARRAY_TASK_ID/64')"
            )
        };
        say(&array(1, ""));
        say(&array(2, " --dependency=afterok:$R1"));
        say(&array(3, " --dependency=afterok:$R2"));
        say(&format!(
            "  sbatch --dependency=afterok:$R3 --wrap='rvachev merge {folder} -o part.vtu --report part.json'"
        ));
    }
    Ok(true)
}

fn plan_of(part: &PartFile, how: &MeshingArguments, bricks: [u32; 3], run: &rvachev::Run) -> Result<BrickPlan> {
    if pipeline::is_step(&part.part) || pipeline::is_mesh(&part.part) {
        let what = format!("bricks are for solids of R-functions, {} is none", part.part.display());
        return Err(Error::Usage(what));
    }
    let source = PlanSource::read(&part.part, &part.define)?;
    BrickPlan::new(source, &options(how, Method::default(), false), bricks, run)
}

pub fn brick(a: &Brick) -> Result<bool> {
    let run = run(&a.common, "brick")?;
    let plan = BrickPlan::load(&a.folder)?;
    if a.round.is_none() && a.share != Share::ALL {
        return Err(Error::Usage(
            "a share is of one round: give --round 1, 2 or 3, each when all shares of the one before are done".into(),
        ));
    }
    let made = pipeline::make_bricks(&plan, &a.folder, a.share, a.round.map(|r| r as usize - 1), &run)?;
    drop(run);
    if !a.common.quiet {
        say(&format!("{made} pieces made"));
    }
    Ok(true)
}

pub fn merge(a: &MergeArguments) -> Result<bool> {
    io::check_all_writable(&a.output, &written_as(&a.files))?;
    a.report.iter().try_for_each(|p| writable(p))?;
    let run = run(&a.common, "merge")?;
    let plan = BrickPlan::load(&a.folder)?;
    let merged = pipeline::merge_on_disk(&plan, &a.folder, a.report.is_some(), &run)?;
    let to = Outputs { of: &a.folder, meshes: &a.output, files: &a.files, report: a.report.as_deref(), force: a.force };
    finish(&merged, &to, &a.common, run)
}

/// `mesh --bricks`: the pieces lie beside the first output while it takes.
pub fn mesh(a: &Mesh, bricks: [u32; 3]) -> Result<bool> {
    if a.png.is_some() || a.html.is_some() || a.method.is_some_and(|m| m != Method::default()) {
        return Err(Error::Usage("--bricks goes with mesh files and --report only, and has no other --method".into()));
    }
    let run = watched(unwatched(&a.common)?, &a.common, "mesh", a.verbose);
    let plan = plan_of(&a.part, &a.how, bricks, &run)?;
    let mut folder = a.output[0].clone().into_os_string();
    folder.push(format!(".{}-bricks", std::process::id()));
    let folder = Folder(PathBuf::from(folder));
    plan.save(&folder.0)?;
    let merged = pipeline::mesh_bricks(&plan, &folder.0, a.report.is_some() || a.verbose, &run)?;
    if a.verbose {
        let attempts = merged.made.report.attempts.iter();
        attempts.filter(|a| a.kept).for_each(|a| run.note("kept", || a.named()));
    }
    let to =
        Outputs { of: &a.part.part, meshes: &a.output, files: &a.files, report: a.report.as_deref(), force: a.force };
    finish(&merged, &to, &a.common, run)
}

/// A folder that goes when it is no longer needed.
struct Folder(PathBuf);

impl Drop for Folder {
    fn drop(&mut self) {
        // A folder that refuses to go harms nobody.
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

/// What is written of a merged mesh.
struct Outputs<'a> {
    /// The part or the folder it is of.
    of: &'a Path,
    meshes: &'a [PathBuf],
    files: &'a Files,
    report: Option<&'a Path>,
    force: bool,
}

fn finish(merged: &MergedBricks<'_>, to: &Outputs<'_>, common: &CommonArguments, run: rvachev::Run) -> Result<bool> {
    let MergedBricks { mesh, made } = merged;
    if let Some(path) = to.report {
        write_report(path, made, &shown(made, to.of, &Told::default()))?;
    }
    if let Some(refusal) = refused(made, to.force) {
        drop(run);
        note("falls short", &made.report.shortfalls);
        return Err(refusal);
    }
    let how = WriteOptions { unit: made.report.units.clone(), ..written_as(to.files) };
    let mut whole = Vec::new();
    for path in to.meshes {
        whole.extend((!Format::from_path(path)?.is_streamed()).then(|| path.display().to_string()));
    }
    let told = if whole.is_empty() {
        write_meshes(to.meshes, mesh, &how, &run)?
    } else {
        let mut told = write_meshes(to.meshes, &mesh.collected()?, &how, &run)?;
        let what = "takes all of the mesh into memory; STL, OBJ, PLY, OFF, VTU and XDMF files do not";
        told.warnings.extend(whole.iter().map(|name| format!("{name}: this format {what}")));
        told
    };
    drop(run);
    Ok(ended(made, &told, common.quiet))
}
