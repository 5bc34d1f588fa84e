//! Classes of nodes (regular, crease, corner) on cubes with holes, against the truth that the leaves know.
//!
//! The mesh is the one [LIS14] classifies: marching cubes, projection, `R_all`, `N`, `N1`. For each part, number of cells
//! and orientation one line tells what was found. A node is on a crease within a twentieth of a cell, and off all
//! creases beyond a quarter of one; between the two either class is right.

use glam::{DMat3, DQuat};
use rvachev::geometry::{Features, Pieces};
use rvachev::implicit::{ExtractOptions, Implicit, ImplicitOracle, Placement, RSystem, Solid, extract, features};
use rvachev::mesh::EditMesh;
use rvachev::optimize::{Kind, Operator, Options, classify_by_curvature, improve, paper_sequence};
use rvachev::{DVec3, Result, Run};

/// Creases are where normals differ by more degrees than this.
const CREASE: f64 = 20.0;

fn main() -> Result<()> {
    let hole = |axis, at| Solid::cylinder(0.4, axis, at, None);
    let cube = || Solid::cuboid(DVec3::splat(-1.0), DVec3::ONE);
    let (x, z, o) = (DVec3::X, DVec3::Z, DVec3::ZERO);
    let parts = [
        ("one hole", cube() - hole(z, o)),
        ("two crossing", cube() - hole(x, o) - hole(z, o)),
        ("through edges", cube() - hole(x, DVec3::new(0.0, 0.9, 0.9)) - hole(z, DVec3::new(-0.9, -0.9, 0.0))),
        ("wedge", cube() - hole(x, DVec3::new(0.0, 0.8, 0.8)) - hole(z, DVec3::new(0.2, 0.1, 0.0))),
        ("three crossing", cube() - hole(x, o) - hole(z, o) - hole(DVec3::Y, o)),
        ("unequal", cube() - hole(x, o) - Solid::cylinder(0.3, z, o, None)),
        ("notched", cube() - Solid::sphere(0.8, DVec3::ONE)),
        ("sphere", Solid::sphere(0.8, o)),
    ];
    // cargo run --release --example classes -- 32 64 128
    let asked: Vec<usize> = std::env::args().skip(1).filter_map(|a| a.parse().ok()).collect();
    let cells = if asked.is_empty() { vec![32] } else { asked };
    println!(
        "part            turned   N   nodes |  corners true/near/right/called | crease nodes  found   share | false between"
    );
    for (name, solid) in parts {
        for turned in [false, true] {
            for &n in &cells {
                line(name, &solid, turned, n)?;
            }
        }
    }
    Ok(())
}

fn line(name: &str, solid: &Solid, turned: bool, n: usize) -> Result<()> {
    let run = Run::new();
    let size = 2.0 * 1.237 / n as f64;
    let rotation = DMat3::from_quat(DQuat::from_xyzw(0.298, -0.274, -0.891, 0.201).normalize());
    let rotation = if turned { rotation } else { DMat3::IDENTITY };
    let solid = solid.clone().placed(Placement { rotation, scale: 1.0, shift: DVec3::ZERO });
    let model = Implicit::new(&solid, RSystem::default(), None)?;
    let extracted = extract(&model, &ExtractOptions::new(size), &run)?;
    let oracle = ImplicitOracle::new(&model, &extracted);
    let mut mesh = extracted.mesh.clone();
    let mut options = Options::new(size);
    options.sequence =
        paper_sequence().operators().into_iter().take_while(|o| *o != Operator::ClassifyByCurvature).collect();
    options.retries = 0;
    improve(&mut mesh, &oracle, &options, &run)?;
    let truth = features(&model, 0.25 * size, &run)?;
    let mesh = EditMesh::new(&mesh)?;
    let start = std::time::Instant::now();
    let classes = classify_by_curvature(&mesh, CREASE, &run)?;
    let seconds = start.elapsed().as_secs_f64();

    let near = distances(&mesh, &truth, &oracle, size);
    let (mut on, mut found, mut wrong, mut between) = (0, 0, 0, 0);
    for v in mesh.nodes() {
        let (d, angle, _) = near[v as usize];
        let special = classes.kind(v) != Kind::Regular;
        if d <= 0.05 && angle > CREASE {
            on += 1;
            found += usize::from(special);
        } else if special && d > 0.25 {
            wrong += 1;
        } else if special && d > 0.05 {
            between += 1;
        }
    }
    let near_corner = |v: u32| truth.corners.iter().position(|c| c.distance(mesh.point(v)) <= 0.5 * size);
    let exists =
        truth.corners.iter().filter(|c| mesh.nodes().any(|v| mesh.point(v).distance(**c) <= 0.05 * size)).count();
    let called: Vec<u32> = mesh.nodes().filter(|&v| classes.kind(v) == Kind::Corner).collect();
    let mut right: Vec<usize> = called.iter().filter_map(|&v| near_corner(v)).collect();
    right.sort_unstable();
    right.dedup();
    println!(
        "{name:<15} {:<6} {n:>4} {:>7} | {:>3} {:>3} {:>3} {:>3} | {on:>6} {found:>6} {:>7.2}% | {wrong:>4} {between:>4}  {seconds:.2} s",
        if turned { "yes" } else { "no" },
        mesh.nodes().count(),
        truth.corners.len(),
        exists,
        right.len(),
        called.len(),
        100.0 * found as f64 / (on as f64).max(1.0),
    );
    Ok(())
}

/// For every node: the distance to the nearest true crease as a share of the cell (infinite beyond two cells), the
/// angle there, and the number of the sample.
fn distances(mesh: &EditMesh, truth: &Features, oracle: &ImplicitOracle<'_>, size: f64) -> Vec<(f64, f64, usize)> {
    let cell = |p: DVec3| (p / (2.0 * size)).floor().as_i64vec3();
    let mut cells = std::collections::HashMap::<glam::I64Vec3, Vec<usize>>::new();
    for (k, s) in truth.samples.iter().enumerate() {
        cells.entry(cell(s.point)).or_default().push(k);
    }
    let mut out = vec![(f64::INFINITY, 0.0, usize::MAX); mesh.node_capacity()];
    for v in mesh.nodes() {
        let p = mesh.point(v);
        let at = cell(p);
        let mut best = (f64::INFINITY, 0.0, usize::MAX);
        for i in 0..27 {
            let near = at + glam::I64Vec3::new(i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1);
            for &k in cells.get(&near).into_iter().flatten() {
                let s = &truth.samples[k];
                let along = (p - s.point).dot(s.tangent).clamp(-0.6 * s.length, 0.6 * s.length);
                let d = p.distance(s.point + along * s.tangent) / size;
                if d < best.0 {
                    best = (d, s.angle, k);
                }
            }
        }
        if best.0 < 0.5 {
            let s = &truth.samples[best.2];
            if let Some(q) = oracle.meet(&s.pieces, p, size) {
                best.0 = best.0.min(q.distance(p) / size);
            }
        }
        out[v as usize] = best;
    }
    out
}
