//! The commands. Each returns whether what was asked for was reached.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use rvachev::io::{self, Format, Names, Renamed, WriteOptions};
use rvachev::mesh::{MeshView, TriMesh};
use rvachev::page::{self, PageKind, PageLine, PageText};
use rvachev::pipeline::{self, MeshOptions, Meshed, Method, PictureOptions, Sequence, SoupOptions, TrueSurface};
use rvachev::quality;
use rvachev::render::{self as draw, RenderOptions};
use rvachev::{Error, Place, Result, Run};
use serde::Serialize;

use super::arguments::{
    CheckArguments, Coloring, Convert, DrawnEdges, Files, Heal, InfoArguments, Mesh, MeshingArguments, Operators,
    Render, Triangles,
};
use super::console::{distinct, note, picture, run, say, unwatched, watched, writable};
use super::sample::function_part;

pub(super) fn options(how: &MeshingArguments, method: Method, measure: bool) -> MeshOptions {
    MeshOptions {
        size: how.size,
        method,
        sequence: None,
        root_tolerance: how.eps,
        memory: (how.memory * (1u64 << 30) as f64) as u64,
        angle: how.angle,
        tolerance: how.tol,
        volume: how.volume,
        grading: how.grading,
        least: how.size_min,
        trim: how.trim,
        without: how.without.clone(),
        thickness: how.thickness,
        refinements: how.refine.clone(),
        measure,
        timed: false,
    }
}

/// The operators that are asked for. Errors: mistakes in them, by line and column; a file that cannot be read.
pub(super) fn sequence(asked: &Operators) -> Result<Option<Sequence>> {
    let Some(text) = &asked.sequence else { return Ok(None) };
    let Some(path) = text.strip_prefix('@') else {
        // No file is at fault: it is the option.
        return text.parse().map(Some).map_err(|e: Error| match e {
            Error::Input { place, message, help, .. } => {
                let help = help.map_or_else(String::new, |h| format!(" ({h})"));
                Error::Usage(format!("--sequence: {place}{message}{help}"))
            }
            other => other,
        });
    };
    let path = Path::new(path);
    let text = std::fs::read_to_string(path).map_err(|e| Error::io("read", path, e))?;
    text.parse().map(Some).map_err(|e: Error| e.in_file(path))
}

pub(super) fn soup_options(t: &Triangles) -> SoupOptions {
    SoupOptions {
        feature_angle: t.feature_angle,
        min_area: t.min_area,
        min_length: t.min_length,
        nodes: t.nodes,
        close: t.close,
    }
}

pub(super) fn to_json(value: &impl Serialize) -> Result<String> {
    serde_json::to_string_pretty(value).map_err(|e| Error::Failed(format!("cannot write JSON: {e}")))
}

pub(super) fn write_json(path: &Path, value: &impl Serialize) -> Result<()> {
    write_bytes(path, format!("{}\n", to_json(value)?).as_bytes())
}

fn write_bytes(path: &Path, bytes: &[u8]) -> Result<()> {
    io::write_atomic(path, |out| out.write_all(bytes).map_err(|e| Error::io("write", path, e)))
}

fn write_page(path: &Path, mesh: &TriMesh, text: &PageText, run: &Run) -> Result<()> {
    write_bytes(path, page::page(mesh, text, run)?.as_bytes())
}

/// What a page tells of a mesh and of the files it was written to.
pub(super) fn shown(made: &Meshed, of: &Path, told: &Told) -> PageText {
    let mut text = pipeline::shown(made, &title(of));
    text.lines.extend(told.shortfalls.iter().map(|l| PageLine::new(PageKind::Shortfall, l)));
    text.lines.extend(told.warnings.iter().map(|l| PageLine::new(PageKind::Warning, l)));
    text
}

/// The report as tables to read where the file's ending says HTML, else as JSON.
pub(super) fn write_report(path: &Path, made: &Meshed, text: &PageText) -> Result<()> {
    let ending = path.extension().and_then(|e| e.to_str()).unwrap_or_default().to_ascii_lowercase();
    match ending.as_str() {
        "html" | "htm" => write_bytes(path, page::tables(text, &pipeline::report_tables(made)).as_bytes()),
        _ => write_json(path, &made.report),
    }
}

/// The title of a page: the name of the file it is of.
pub(super) fn title(path: &Path) -> String {
    path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned()
}

pub(super) fn written_as(files: &Files) -> WriteOptions {
    WriteOptions { groups: files.groups, old_msh: files.msh_version == "2.2", ..WriteOptions::default() }
}

/// What is to be told of files that were written.
#[derive(Default)]
pub(super) struct Told {
    pub(super) warnings: Vec<String>,
    pub(super) shortfalls: Vec<String>,
}

/// Writes the files, and beside each that names sets of triangles a list of the names, one list for files of one
/// stem.
pub(super) fn write_meshes(paths: &[PathBuf], mesh: &dyn MeshView, options: &WriteOptions, run: &Run) -> Result<Told> {
    let mut told = Told::default();
    let mut lists: BTreeMap<PathBuf, Vec<Renamed>> = BTreeMap::new();
    for path in paths {
        let written = io::write(path, mesh, options, run)?;
        if Format::from_path(path)?.has_sets() {
            let file = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
            let list = lists.entry(path.with_extension("names.json")).or_default();
            for [name, written] in &written.renamed {
                list.push(Renamed { file: file.clone(), name: name.clone(), written: written.clone() });
            }
        }
        if !written.renamed.is_empty() {
            let changes: Vec<_> = written.renamed.iter().map(|[name, now]| format!("{name} is {now}")).collect();
            told.warnings.push(format!("names that {} cannot hold: {}", path.display(), changes.join(", ")));
        }
        told.warnings.extend(written.warnings);
        told.shortfalls.extend(written.shortfalls);
    }
    if !lists.is_empty() {
        let names = io::names(mesh, options)?;
        for (path, renamed) in lists {
            write_json(&path, &Names { renamed, ..names.clone() })?;
        }
    }
    // Files of one mesh have the same to tell.
    let mut seen = BTreeSet::new();
    for list in [&mut told.warnings, &mut told.shortfalls] {
        list.retain(|line| seen.insert(line.clone()));
    }
    Ok(told)
}

/// Refuses files that hold plane figures alone, before anything is computed.
fn no_figure(paths: &[PathBuf]) -> Result<()> {
    for path in paths {
        if Format::from_path(path)? == Format::Svg {
            let what = "an SVG file holds plane figures, and the part is a solid: part(region(...)) is a figure";
            return Err(Error::Usage(format!("{}: {what}", path.display())));
        }
    }
    Ok(())
}

/// What `mesh` does, and `view` without a server.
pub fn mesh(a: &Mesh) -> Result<bool> {
    if a.watch {
        return super::watch::watch(a);
    }
    if a.dry_run {
        let run = run(&a.common, "mesh")?;
        let about = pipeline::expected_triangles(&run, |run| made(a, run))?;
        drop(run);
        say(&format!("about {about} triangles"));
        return Ok(true);
    }
    if let Some(n) = a.bricks {
        return super::bricks::mesh(a, n);
    }
    io::check_all_writable(&a.output, &written_as(&a.files))?;
    a.report.iter().chain(&a.html).try_for_each(|p| writable(p))?;
    a.png.iter().try_for_each(|p| picture(p))?;
    distinct(a.output.iter().chain(&a.report).chain(&a.png).chain(&a.html))?;
    mesh_once(a, &unwatched(&a.common)?)
}

/// The mesh that is asked for, of any kind of input. It may fall short, and be unsound.
pub(super) fn made(a: &Mesh, run: &Run) -> Result<Meshed> {
    // The leaf method measures always; the others fall short of what they are not measured for.
    let soup = pipeline::is_step(&a.part.part) || pipeline::is_mesh(&a.part.part);
    let mut how = options(&a.how, a.method.unwrap_or_default(), true);
    how.sequence = sequence(&a.operators)?;
    how.measure = a.report.is_some() || a.html.is_some() || !a.common.quiet;
    how.timed = a.report.is_some() || a.verbose;
    if soup {
        no_figure(&a.output)?;
    }
    let made = if pipeline::is_step(&a.part.part) {
        pipeline::mesh_step(pipeline::load_step(&a.part.part, run)?, &how, run)
    } else if pipeline::is_mesh(&a.part.part) {
        pipeline::mesh_soup(&pipeline::load_mesh(&a.part.part, run)?, &how, &soup_options(&a.triangles), run)
    } else {
        let part = pipeline::load_part(&a.part.part, &a.part.define)?;
        if !part.plane {
            no_figure(&a.output)?;
        }
        how = how.for_part(&part, a.method);
        a.given.known_to_part(pipeline::part_kind(&part), how.method, &a.part.part)?;
        how.measure |= !how.method.is_exact();
        pipeline::mesh_part(&part, &how, run)
    };
    let mut made = made.map_err(|e| e.in_file(&a.part.part))?;
    a.anew.apply(&mut made, run)?;
    if a.verbose {
        // All others were told as they ended, and so was this one, but not that it stands.
        made.report.attempts.iter().filter(|a| a.kept).for_each(|a| run.note("kept", || a.named()));
    }
    Ok(made)
}

/// Makes the mesh and writes what is asked for. `base` is a run nobody watches.
pub(super) fn mesh_once(a: &Mesh, base: &Run) -> Result<bool> {
    let run = watched(base.clone(), &a.common, "mesh", a.verbose);
    let made = made(a, &run)?;
    if let Some(refusal) = refused(&made, a.force) {
        let text = shown(&made, &a.part.part, &Told::default());
        if let Some(path) = &a.report {
            write_report(path, &made, &text)?;
        }
        // Like the report: it is no mesh, and it shows where the faults are.
        if let Some(path) = &a.html {
            write_page(path, &made.mesh, &text, &run)?;
        }
        drop(run);
        note("falls short", &made.report.shortfalls);
        return Err(refusal);
    }
    let mut drawn = RenderOptions::default();
    if made.outline.is_some() {
        drawn.view.towards = rvachev::DVec3::Z;
    }
    let picture = a.png.as_ref().map(|_| draw::render(&made.mesh, &drawn, &run)).transpose()?;
    let mut told = Told::default();
    if !a.output.is_empty() {
        let merged = made.merged()?;
        let (seams, corners) = (made.seams.clone(), made.corners.clone());
        told = write_meshes(
            &a.output,
            &merged,
            &WriteOptions {
                seams,
                corners,
                outline: made.outline.clone(),
                unit: made.report.units.clone(),
                ..written_as(&a.files)
            },
            &run,
        )?;
    }
    if let (Some(path), Some(picture)) = (&a.png, &picture) {
        pipeline::write_picture(path, picture)?;
    }
    let text = shown(&made, &a.part.part, &told);
    if let Some(path) = &a.html {
        write_page(path, &made.mesh, &text, &run)?;
    }
    if let Some(path) = &a.report {
        write_report(path, &made, &text)?;
    }
    drop(run);
    Ok(ended(&made, &told, a.common.quiet))
}

/// Why a mesh that is not sound is not written, unless that is forced.
pub(super) fn refused(made: &Meshed, force: bool) -> Option<Error> {
    let certificate = made.report.check.as_ref().map(|c| &c.certificate).filter(|c| !c.is_sound() && !force)?;
    let what = format!("the mesh is not sound and is not written ({certificate}); --force writes it");
    Some(Error::Failed(what))
}

/// Tells what came of a mesh and its files. Whether that is what was asked for.
pub(super) fn ended(made: &Meshed, told: &Told, quiet: bool) -> bool {
    if !quiet {
        if let Some(check) = &made.report.check {
            say(&check.to_string());
        }
        if let Some(figure) = &made.report.figure {
            say(&figure.to_string());
        }
        if let Some(distance) = &made.report.distance {
            say(&distance.to_string());
        }
        if let Some(volume) = &made.report.volume {
            say(&volume.to_string());
        }
        note("warning", &made.report.warnings);
        note("warning", &told.warnings);
    }
    note("falls short", &made.report.shortfalls);
    note("falls short", &told.shortfalls);
    made.report.shortfalls.is_empty() && told.shortfalls.is_empty()
}

pub fn check(a: &CheckArguments) -> Result<bool> {
    if pipeline::is_step(&a.mesh) {
        return check_model(a);
    }
    match &a.against {
        None if !a.define.is_empty() => {
            return Err(Error::Usage("-D overrides numbers of the part of --against, which is not given".into()));
        }
        Some(path) if pipeline::is_step(path) && !a.define.is_empty() => {
            return Err(Error::Usage("-D overrides numbers of part files; a STEP file has none".into()));
        }
        _ => {}
    }
    let run = run(&a.common, "check")?;
    let mesh = io::read(&a.mesh, &run)?;
    let check = match &a.against {
        Some(path) if pipeline::is_step(path) => {
            pipeline::against_step(&mesh, pipeline::load_step(path, &run)?, &run).map_err(|e| e.in_file(path))?
        }
        Some(path) => {
            let part = pipeline::load_part(path, &a.define)?;
            pipeline::against(&mesh, &part, &run).map_err(|e| e.in_file(path))?
        }
        None => quality::check(&mesh, quality::Expectation::default(), None, &run).map_err(|e| e.in_file(&a.mesh))?,
    };
    drop(run);
    say(&if a.json { to_json(&check)? } else { check.to_string() });
    Ok(check.closed && check.manifold && check.oriented && check.self_intersections == 0)
}

/// What is wrong with a CAD model.
fn check_model(a: &CheckArguments) -> Result<bool> {
    if a.against.is_some() || !a.define.is_empty() {
        return Err(Error::Usage("--against and -D are for meshes; a STEP model is checked by itself".into()));
    }
    let run = run(&a.common, "check")?;
    let model = pipeline::load_step(&a.mesh, &run)?;
    let found = pipeline::diagnose_step(&model, &run).map_err(|e| e.in_file(&a.mesh))?;
    drop(run);
    say(&if a.json { to_json(&found)? } else { found.to_string() });
    Ok(found.sound)
}

pub fn heal(a: &Heal) -> Result<bool> {
    io::check_all_writable(&a.output, &written_as(&a.files))?;
    a.html.iter().try_for_each(|p| writable(p))?;
    let run = run(&a.common, "heal")?;
    let mesh = io::read(&a.mesh, &run)?;
    let options = pipeline::HealOptions { max_hole: a.max_hole };
    let healed = pipeline::heal(&mesh, &options, &run).map_err(|e| e.in_file(&a.mesh))?;
    let told = write_meshes(&a.output, &healed.mesh, &written_as(&a.files), &run)?;
    if let Some(path) = &a.html {
        let text = pipeline::shown_healed(&healed, &title(&a.mesh), &run)?;
        write_page(path, &healed.mesh, &text, &run)?;
    }
    drop(run);
    if a.json {
        say(&to_json(&healed.report)?);
    } else if !a.common.quiet {
        say(&healed.report.to_string());
        note("warning", &told.warnings);
    }
    note("falls short", &healed.report.shortfalls);
    note("falls short", &told.shortfalls);
    Ok(healed.report.shortfalls.is_empty() && told.shortfalls.is_empty())
}

pub fn info(a: &InfoArguments) -> Result<bool> {
    let path = &a.part.part;
    let run = run(&a.common, "info")?;
    let show = |text: String, json: Result<String>| -> Result<()> {
        say(&if a.json { json? } else { text });
        Ok(())
    };
    if pipeline::is_mesh(path) {
        let mesh = pipeline::load_mesh(path, &run)?;
        let found = pipeline::soup_info(&mesh, &MeshOptions::default(), &soup_options(&a.triangles), &run);
        let info = found.map_err(|e| e.in_file(path))?;
        drop(run);
        show(info.to_string(), to_json(&info))?;
        return Ok(true);
    }
    if pipeline::is_step(path) {
        let model = pipeline::load_step(path, &run)?;
        let good = model.notes.is_empty();
        let info = pipeline::brep_info(model, Some("mm"), &run)?;
        drop(run);
        show(info.to_string(), to_json(&info))?;
        return Ok(good);
    }
    let part = pipeline::load_part(path, &a.part.define)?;
    if let Some(brep) = pipeline::build(&part, &run).map_err(|e| e.in_file(path))? {
        let info = pipeline::brep_info(brep.into(), part.units.as_deref(), &run)?;
        show(info.to_string(), to_json(&info))?;
        if part.solid.is_none() {
            return Ok(true);
        }
    }
    let info = pipeline::info(&part, &run).map_err(|e| e.in_file(path))?;
    drop(run);
    show(info.to_string(), to_json(&info))?;
    Ok(true)
}

pub fn convert(a: &Convert) -> Result<bool> {
    let path = &a.part.part;
    if pipeline::is_vm(&a.output) {
        writable(&a.output)?;
        let part = function_part(path, &a.part.define)?;
        let text = pipeline::vm_text(&part).map_err(|e| e.in_file(path))?;
        write_bytes(&a.output, text.as_bytes())?;
        return Ok(true);
    }
    if pipeline::is_3mf(&a.output) {
        writable(&a.output)?;
        let part = function_part(path, &a.part.define)?;
        let name = path.file_stem().unwrap_or_default().to_string_lossy();
        let bytes = pipeline::levelset_bytes(&part, &name).map_err(|e| e.in_file(path))?;
        write_bytes(&a.output, &bytes)?;
        return Ok(true);
    }
    if !pipeline::is_step(&a.output) {
        return Err(Error::Usage(format!(
            "convert writes .step, .stp, .vm and .3mf files, not {}",
            a.output.display()
        )));
    }
    writable(&a.output)?;
    let run = run(&a.common, "convert")?;
    if pipeline::is_step(path) {
        let model = pipeline::load_step(path, &run)?;
        pipeline::save_step(&a.output, &model.brep, None)?;
        drop(run);
        note("falls short", &model.notes.iter().map(ToString::to_string).collect::<Vec<_>>());
        return Ok(model.notes.is_empty());
    }
    let part = pipeline::load_part(path, &a.part.define)?;
    let Some(brep) = pipeline::build(&part, &run).map_err(|e| e.in_file(path))? else {
        let what = "STEP files hold solids built from edges; a solid of R-functions can only be meshed";
        return Err(Error::input(Place::Unknown, what).in_file(path));
    };
    pipeline::save_step(&a.output, &brep, part.units.as_deref())?;
    drop(run);
    if part.solid.is_some() {
        note("falls short", &["the part's solid of R-functions is not in the file".to_string()]);
    }
    Ok(part.solid.is_none())
}

pub fn render(a: &Render) -> Result<bool> {
    match (a.color, &a.against) {
        (Coloring::Distance, None) => {
            return Err(Error::Usage("--color distance needs the part the mesh should be of: --against PART".into()));
        }
        (Coloring::Distance, Some(path)) if pipeline::is_step(path) && !a.define.is_empty() => {
            return Err(Error::Usage("-D overrides numbers of part files; a STEP file has none".into()));
        }
        (Coloring::Distance, _) | (_, None) => {}
        (_, Some(_)) => return Err(Error::Usage("--against is for --color distance alone".into())),
    }
    picture(&a.output)?;
    let run = run(&a.common, "render")?;
    let mesh = io::read(&a.mesh, &run)?;
    let usual = RenderOptions::default();
    let (wireframe, sharp_angle) = match a.edges {
        None => (usual.wireframe, usual.sharp_angle),
        Some(DrawnEdges::None) => (Some(false), None),
        Some(DrawnEdges::Sharp) => (Some(false), usual.sharp_angle),
        Some(DrawnEdges::All) => (Some(true), usual.sharp_angle),
    };
    let coloring = match a.color {
        _ if a.quality => pipeline::Coloring::Angle,
        Coloring::Face => pipeline::Coloring::Face,
        Coloring::Angle => pipeline::Coloring::Angle,
        Coloring::Edge => pipeline::Coloring::Edge,
        Coloring::Distance => pipeline::Coloring::Distance,
        Coloring::Class => pipeline::Coloring::Class,
    };
    let [width, height] = a.size;
    let options = PictureOptions {
        render: RenderOptions {
            width,
            height,
            view: a.view.unwrap_or(usual.view),
            clips: a.clip.clone(),
            wireframe,
            sharp_angle,
            transparent: a.transparent,
            ..usual
        },
        coloring,
        against: a.against.as_ref().map(|path| TrueSurface::File { path: path.clone(), overrides: a.define.clone() }),
    };
    pipeline::write_picture(&a.output, &pipeline::picture(&mesh, &options, &run).map_err(|e| e.in_file(&a.mesh))?)?;
    Ok(true)
}
