//! One part under several R-systems: how near its function is to a distance, and whether the mesh notices.

use std::fmt;

use glam::DVec3;
use serde::Serialize;

use super::groups::check_groups;
use super::mesh::Ready;
use super::options::MeshOptions;
use crate::error::{Error, Place, Result};
use crate::heal::SAMPLES;
use crate::implicit::part::Part;
use crate::implicit::{ExtractOptions, Implicit, RSystem, Sampling, evaluate, extract};
use crate::mesh::TriMesh;
use crate::run::Run;

/// The systems every comparison shows; the first is what the others are compared with. The part's own is added.
const SYSTEMS: [RSystem; 5] =
    [RSystem::MinMax, RSystem::R0, RSystem::RAlpha(-0.5), RSystem::RAlpha(0.5), RSystem::R0m(2)];

/// How far from the boundary the function is looked at, as shares of the size, on both sides.
const DEPTHS: [f64; 2] = [0.1, 0.5];

/// The share of points that are no worse than what is told as `p95`.
const MOST: f64 = 0.95;

/// A measure over points: 0 would be ideal.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Spread {
    /// The mean.
    pub mean: f64,
    /// What 95 of 100 points do not exceed.
    pub p95: f64,
    /// The worst.
    pub max: f64,
}

impl Spread {
    fn of(mut all: Vec<f64>) -> Self {
        all.sort_by(f64::total_cmp);
        let at = |share: f64| all.get(((all.len() as f64 - 1.0) * share) as usize).copied().unwrap_or(0.0);
        Spread { mean: all.iter().sum::<f64>() / all.len().max(1) as f64, p95: at(MOST), max: at(1.0) }
    }
}

/// The function at a distance from the boundary.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Depth {
    /// The distance along the normal, in the part's unit.
    pub distance: f64,
    /// `| |value| / distance - 1 |` there, on both sides of the boundary.
    pub value: Spread,
    /// `| |gradient| - 1 |` there.
    pub gradient: Spread,
    /// Where the value differs most from that under min / max, and by which share of the distance.
    pub differs: f64,
    /// Where that is.
    pub differs_at: [f64; 3],
}

/// One R-system.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SystemRow {
    /// The system, as `--rsystem` takes it.
    pub rsystem: String,
    /// Whether it is the part's own.
    pub own: bool,
    /// `| |gradient| - 1 |` on the boundary.
    pub boundary: Spread,
    /// Farther in and out.
    pub depths: Vec<Depth>,
    /// How many nodes of the mesh by marching cubes are elsewhere than under min / max; `None` where the triangles differ.
    pub moved_nodes: Option<usize>,
}

/// The rows of a comparison of R-systems, in order.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SystemComparison {
    /// Cell size, in the part's unit.
    pub size: f64,
    /// How many points of the boundary were looked at.
    pub points: usize,
    /// One row a system.
    pub rows: Vec<SystemRow>,
}

/// Compares R-systems on a part, in points of its boundary and beside it.
///
/// Guarantees: the same for any number of threads.
///
/// Errors: those of [`mesh_part`](super::mesh_part) by marching cubes.
pub fn compare_rsystems(part: &Part, options: &MeshOptions, run: &Run) -> Result<SystemComparison> {
    options.comparable()?;
    let ready = Ready::new(part, options.size)?;
    let options = &options.resolved(ready.model.bounds().diagonal());
    check_groups(part, ready.model.faces().iter().map(|f| &f.name[..]))?;
    let mut systems = SYSTEMS.to_vec();
    if !systems.contains(&part.rsystem) {
        systems.push(part.rsystem);
    }
    // What is meshed here is the solid of R-functions alone.
    let no_solid = || Error::input(Place::Unknown, "the part has no solid of R-functions");
    let solid = part.solid.as_ref().ok_or_else(no_solid)?;
    let model = |system: &RSystem| Implicit::new(solid, *system, part.domain).map_err(|e| part.located(e));
    let models: Vec<Implicit> = systems.iter().map(model).collect::<Result<_>>()?;
    let first = ready.extract(ready.size, options, run)?.mesh;
    let how = ExtractOptions { size: ready.size, root_tolerance: options.root_tolerance, memory: options.memory };
    // Points of the boundary that are looked at: enough for the shares told, and no time.
    let on: Vec<DVec3> = first.nodes.iter().step_by(first.nodes.len().div_ceil(SAMPLES).max(1)).copied().collect();
    let normals: Vec<DVec3> = {
        let found = evaluate(&models[0], &on, Sampling { gradients: true, faces: false }, run)?;
        found.gradients.iter().map(|g| g.normalize_or_zero()).collect()
    };
    let beside = |distance: f64| -> Vec<DVec3> {
        [distance, -distance].iter().flat_map(|d| on.iter().zip(&normals).map(move |(p, n)| *p + *n * *d)).collect()
    };
    let mut least: Option<Vec<Vec<f64>>> = None;
    let mut reference: Option<TriMesh> = None;
    let mut rows = Vec::with_capacity(systems.len());
    for (system, model) in systems.iter().zip(&models) {
        let gradients = Sampling { gradients: true, faces: false };
        let steep = |list: &[DVec3]| Spread::of(list.iter().map(|g| (g.length() - 1.0).abs()).collect());
        let boundary = steep(&evaluate(model, &on, gradients, run)?.gradients);
        let (mut depths, mut values) = (Vec::new(), Vec::new());
        for (i, share) in DEPTHS.iter().enumerate() {
            let distance = share * ready.size;
            let places = beside(distance);
            let found = evaluate(model, &places, gradients, run)?;
            let value = Spread::of(found.values.iter().map(|v| (v.abs() / distance - 1.0).abs()).collect());
            let other = least.as_ref().map_or(&found.values, |all: &Vec<Vec<f64>>| &all[i]);
            let off = |k: usize| (found.values[k] - other[k]).abs() / distance;
            let worst = (0..places.len()).max_by(|a, b| off(*a).total_cmp(&off(*b)).then(b.cmp(a))).unwrap_or(0);
            depths.push(Depth {
                distance,
                value,
                gradient: steep(&found.gradients),
                differs: off(worst),
                differs_at: places[worst].to_array(),
            });
            values.push(found.values);
        }
        least.get_or_insert(values);
        let mesh = extract(model, &how, run)?.mesh;
        let base = reference.get_or_insert_with(|| mesh.clone());
        let moved_nodes = (base.triangles == mesh.triangles && base.nodes.len() == mesh.nodes.len())
            .then(|| base.nodes.iter().zip(&mesh.nodes).filter(|(a, b)| a != b).count());
        let own = *system == part.rsystem;
        rows.push(SystemRow { rsystem: system.to_string(), own, boundary, depths, moved_nodes });
    }
    Ok(SystemComparison { size: ready.size, points: on.len(), rows })
}

impl fmt::Display for SystemComparison {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let depths: Vec<f64> =
            self.rows.first().map(|r| r.depths.iter().map(|d| d.distance).collect()).unwrap_or_default();
        write!(f, "{:<13} {:^26}", "", "boundary: ||g|-1|")?;
        for d in &depths {
            write!(f, " | {:^44}", format!("{d:.4} in and out"))?;
        }
        writeln!(f)?;
        write!(f, "{:<13} {:>8} {:>8} {:>8}", "R-system", "mean", "p95", "max")?;
        for _ in &depths {
            write!(f, " | {:>8} {:>8} {:>8} {:>8} {:>8}", "value", "p95", "||g|-1|", "p95", "differs")?;
        }
        writeln!(f, " | marching cubes")?;
        for r in &self.rows {
            let name = format!("{}{}", r.rsystem, if r.own { " *" } else { "" });
            write!(f, "{name:<13} {:>8.1e} {:>8.1e} {:>8.1e}", r.boundary.mean, r.boundary.p95, r.boundary.max)?;
            for d in &r.depths {
                let (v, g) = (&d.value, &d.gradient);
                write!(f, " | {:>8.1e} {:>8.1e} {:>8.1e} {:>8.1e} {:>8.1e}", v.mean, v.p95, g.mean, g.p95, d.differs)?;
            }
            match r.moved_nodes {
                Some(0) => writeln!(f, " | same")?,
                Some(n) => writeln!(f, " | {n} nodes elsewhere")?,
                None => writeln!(f, " | other triangles")?,
            }
        }
        writeln!(
            f,
            "{} points of the boundary; * is the part's own system; 0 would be a distance function",
            self.points
        )?;
        writeln!(f, "value: | |value| / distance - 1 | along the normal, which beside an edge is no distance")?;
        writeln!(f, "differs: the largest difference to the value under minmax, as a share of the distance")?;
        write!(
            f,
            "Values are used by eval, grid and whatever computes with the function. Meshes are made of the signs and of the leaves' \
             own gradients, which no R-system changes; values count only where marching cubes have a choice of topology."
        )
    }
}
