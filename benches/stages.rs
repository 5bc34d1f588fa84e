//! Each stage of the road from a file to a mesh alone, on small inputs: `cargo bench --bench stages`, quickly with `-- --quick`.
//!
//! Everything runs on one thread. Stages that no function stands for are timed by what a whole mesh tells of its progress. Two
//! commits are compared by `benches/compare.py`.

use std::collections::BTreeMap;
use std::fs;
use std::hint::black_box;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use criterion::{Criterion, criterion_group, criterion_main};
use rvachev::heal::{HealOptions, heal};
use rvachev::implicit::part::parse;
use rvachev::implicit::{ExtractOptions, Implicit, RSystem, Sampling, evaluate, extract};
use rvachev::io::{self, Format, WriteOptions};
use rvachev::merge::{Merged, join};
use rvachev::mesh::{TriMesh, self_intersections};
use rvachev::model::from_mesh;
use rvachev::pipeline::{self, MeshOptions, Meshed, Part, SizeRequest, SoupOptions};
use rvachev::quality::{Expectation, check};
use rvachev::render::{RenderOptions, render};
use rvachev::run::Progress;
use rvachev::{DVec3, Run};

// ------------------------------------------------------------------------------------------------------------- inputs

/// A file of the repository's samples.
fn sample(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("data").join(name)
}

fn text(name: &str) -> String {
    fs::read_to_string(sample(name)).expect("a sample")
}

fn part(name: &str) -> Part {
    pipeline::load_part(&sample(name), &[]).expect("a sample")
}

fn implicit(name: &str) -> Implicit {
    let part = part(name);
    let solid = part.solid.as_ref().expect("a part with a solid");
    Implicit::new(solid, RSystem::default(), None).expect("a bounded solid")
}

fn one_thread() -> Run {
    Run::new().with_threads(1).expect("one thread")
}

fn options(share: f64) -> MeshOptions {
    MeshOptions { size: Some(SizeRequest::Share(share)), ..MeshOptions::default() }
}

/// The cube with two crossing bores, meshed with edges of a share of its diagonal.
fn cube(share: f64) -> Meshed {
    pipeline::mesh_part(&part("cube_with_holes.py"), &options(share), &one_thread()).expect("a mesh")
}

fn encoded(mesh: &TriMesh, format: Format) -> Vec<u8> {
    let mut bytes = Vec::new();
    io::encode(&mut bytes, mesh, format, &WriteOptions::default(), &Run::new()).expect("a mesh that can be written");
    bytes
}

/// Points in the box of a solid, in an order that repeats.
fn points(model: &Implicit, count: usize) -> Vec<DVec3> {
    let bounds = model.bounds();
    let (low, sides) = (bounds.lo, bounds.hi - bounds.lo);
    let mut state = 0x2545_f491_4f6c_dd1du64;
    let mut next = || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state >> 11) as f64 / (1u64 << 53) as f64
    };
    (0..count).map(|_| low + sides * DVec3::new(next(), next(), next())).collect()
}

/// A mesh in two halves that share the nodes of their border only by place.
fn halves(mesh: &TriMesh) -> [TriMesh; 2] {
    [false, true].map(|right| {
        let mut new = vec![u32::MAX; mesh.nodes.len()];
        let (mut nodes, mut triangles) = (Vec::new(), Vec::new());
        for (t, corners) in mesh.triangles.iter().enumerate() {
            if (mesh.centroid(t).x > 0.0) == right {
                triangles.push(corners.map(|v| {
                    if new[v as usize] == u32::MAX {
                        new[v as usize] = nodes.len() as u32;
                        nodes.push(mesh.nodes[v as usize]);
                    }
                    new[v as usize]
                }));
            }
        }
        TriMesh::new(nodes, triangles)
    })
}

/// A mesh with every hundredth triangle taken out, and a copy of it moved so that both cross.
fn dirty(mesh: &TriMesh) -> TriMesh {
    let count = mesh.nodes.len() as u32;
    let moved = mesh.nodes.iter().map(|p| *p + DVec3::new(1.3, 0.7, 0.4));
    let nodes = mesh.nodes.iter().copied().chain(moved).collect();
    let twice = mesh.triangles.iter().copied().chain(mesh.triangles.iter().map(|t| t.map(|v| v + count)));
    TriMesh::new(nodes, twice.enumerate().filter(|(i, _)| i % 100 != 0).map(|(_, t)| t).collect())
}

// ------------------------------------------------------------------------------------------- stages of a whole mesh

/// How long each stage took that a run told of: the time from its report to the next one.
#[derive(Default)]
struct Stopwatch(Mutex<Laps>);

#[derive(Default)]
struct Laps {
    last: Option<(String, Instant)>,
    took: BTreeMap<String, Duration>,
}

impl Laps {
    fn end(&mut self) {
        if let Some((stage, start)) = self.last.take() {
            *self.took.entry(stage).or_default() += start.elapsed();
        }
    }
}

impl Progress for Stopwatch {
    fn report(&self, stage: &str, _done: f64) {
        let mut laps = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        laps.end();
        laps.last = Some((stage.into(), Instant::now()));
    }
}

/// How long `stage` lasts within the work. A stage that is not told of is a mistake here, not one that takes no time.
fn lap(stage: &str, work: impl FnOnce(&Run)) -> Duration {
    let watch = Arc::new(Stopwatch::default());
    work(&one_thread().with_progress(watch.clone()));
    let mut laps = watch.0.lock().unwrap_or_else(PoisonError::into_inner);
    laps.end();
    let told: Vec<&String> = laps.took.keys().collect();
    *laps.took.get(stage).unwrap_or_else(|| panic!("no stage {stage:?} was told of, only {told:?}"))
}

/// Measures one stage of a work.
fn staged(c: &mut Criterion, name: &str, stage: &str, work: impl Fn(&Run)) {
    c.bench_function(name, |b| b.iter_custom(|times| (0..times).map(|_| lap(stage, &work)).sum()));
}

// ------------------------------------------------------------------------------------------------------------- stages

/// How often small things are done, so that they last some milliseconds together.
const PARTS: usize = 20;

fn reading(c: &mut Criterion) {
    let source = text("aircraft.py");
    c.bench_function("read/part", |b| {
        b.iter(|| (0..PARTS).for_each(|_| drop(black_box(parse(&source, &[])))));
    });
    let solid = part("bracket.py").solid.expect("a part with a solid");
    c.bench_function("read/lower", |b| {
        b.iter(|| (0..PARTS).for_each(|_| drop(black_box(Implicit::new(&solid, RSystem::default(), None)))));
    });
    let step = text("step/cylinder_without_seam.step");
    let run = one_thread();
    c.bench_function("read/step", |b| {
        b.iter(|| {
            for _ in 0..10 * PARTS {
                let file = io::step::parse_step(step.as_bytes()).expect("a sample");
                black_box(rvachev::parametric::step::interpret(&file, &run).expect("a sample"));
            }
        });
    });
    let stl = encoded(&cube(0.006).mesh, Format::StlBinary);
    c.bench_function("read/stl", |b| b.iter(|| io::read_bytes(&stl, Format::StlBinary, Path::new("a.stl"))));
}

fn functions(c: &mut Criterion) {
    let run = one_thread();
    let bracket = implicit("bracket.py");
    let many = points(&bracket, 1 << 17);
    c.bench_function("function/values", |b| b.iter(|| evaluate(&bracket, &many, Sampling::default(), &run)));
    let wanted = Sampling { gradients: true, faces: true };
    c.bench_function("function/gradients", |b| b.iter(|| evaluate(&bracket, &many[..1 << 14], wanted, &run)));
    // Cells are found by intervals alone.
    let gyroid = implicit("gyroid_ball.py");
    let options = ExtractOptions::new(0.03);
    staged(c, "function/intervals", "cells", |run| drop(black_box(extract(&gyroid, &options, run))));
}

fn solids(c: &mut Criterion) {
    let run = one_thread();
    let cube = implicit("cube_with_holes.py");
    let options_of_cells = ExtractOptions::new(0.02);
    c.bench_function("solid/march", |b| b.iter(|| extract(&cube, &options_of_cells, &run)));
    let part = part("cube_with_holes.py");
    for (name, stage) in [("solid/cells", "cells"), ("solid/arrange", "arrange"), ("solid/remesh", "remesh")] {
        staged(c, name, stage, |run| drop(black_box(pipeline::mesh_part(&part, &options(0.03), run))));
    }
    c.bench_function("solid/whole", |b| b.iter(|| pipeline::mesh_part(&part, &options(0.04), &run)));
}

fn boundaries(c: &mut Criterion) {
    let run = one_thread();
    let path = sample("step/cylinder_without_seam.step");
    let model = || pipeline::load_step(&path, &run).expect("a sample");
    c.bench_function("step/whole", |b| b.iter(|| pipeline::mesh_step(model(), &options(0.03), &run)));
}

fn triangles(c: &mut Criterion) {
    let run = one_thread();
    let mesh = cube(0.02).mesh;
    let bad = dirty(&cube(0.08).mesh);
    c.bench_function("triangles/heal", |b| b.iter(|| heal(&bad, &HealOptions::default(), &run)));
    staged(c, "triangles/remesh", "remesh", |run| {
        drop(black_box(pipeline::mesh_soup(&mesh, &options(0.03), &SoupOptions::default(), run)));
    });
}

fn merging(c: &mut Criterion) {
    let run = one_thread();
    let meshed = cube(0.006);
    let halves = halves(&meshed.mesh);
    c.bench_function("merge/join", |b| b.iter(|| join(&halves, 1e-9, &run)));
    c.bench_function("merge/fragments", |b| {
        b.iter(|| {
            let cut = from_mesh(&meshed.mesh, &meshed.seams, &meshed.corners).expect("a mesh that can be cut");
            Merged::new(cut.model, cut.fragments).map(|_| ())
        });
    });
}

fn checking(c: &mut Criterion) {
    let run = one_thread();
    let (fine, mesh) = (cube(0.012).mesh, cube(0.02).mesh);
    c.bench_function("check/crossings", |b| b.iter(|| self_intersections(&fine, &run)));
    c.bench_function("check/quality", |b| b.iter(|| check(&fine, Expectation::default(), None, &run)));
    let part = part("cube_with_holes.py");
    c.bench_function("check/against", |b| b.iter(|| pipeline::against(&mesh, &part, &run)));
}

fn writing(c: &mut Criterion) {
    let run = one_thread();
    let meshed = cube(0.015);
    let options =
        WriteOptions { seams: meshed.seams.clone(), corners: meshed.corners.clone(), ..WriteOptions::default() };
    let folder = tempfile::tempdir().expect("a folder");
    let mut seen = Vec::new();
    for (ending, format) in Format::EXTENSIONS {
        // An SVG is of a plane figure, which this mesh is none of.
        if format == Format::Svg || seen.contains(&format) {
            continue;
        }
        seen.push(format);
        let path = folder.path().join(format!("a.{ending}"));
        c.bench_function(&format!("write/{ending}"), |b| {
            b.iter(|| io::write(&path, &meshed.mesh, &options, &run).expect("a mesh that can be written"));
        });
    }
}

fn drawing(c: &mut Criterion) {
    let run = one_thread();
    let mesh = cube(0.02).mesh;
    let options = RenderOptions { width: 600, height: 450, ..RenderOptions::default() };
    c.bench_function("draw/picture", |b| b.iter(|| render(&mesh, &options, &run)));
    let picture = render(&mesh, &options, &run).expect("a picture");
    c.bench_function("draw/png", |b| b.iter(|| picture.png_bytes()));
}

/// Ten samples in a second for each stage: rounds of `benches/compare.py` give the rest.
fn config() -> Criterion {
    Criterion::default()
        .sample_size(10)
        .warm_up_time(Duration::from_millis(300))
        .measurement_time(Duration::from_secs(1))
        .without_plots()
}

criterion_group! {
    name = stages;
    config = config();
    targets = reading, functions, solids, boundaries, triangles, merging, checking, writing, drawing
}
criterion_main!(stages);
