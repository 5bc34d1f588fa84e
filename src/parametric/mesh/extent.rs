//! How far a model reaches: farther than its edges where faces bulge.

use std::sync::atomic::AtomicUsize;

use glam::{DVec2, DVec3};
use rayon::prelude::*;
use rustc_hash::FxHashSet;

use super::edges::{Divisions, Lead, Sampled, least_parts, sample};
use super::sizes::SizeField;
use super::{MeshSizes, Parametric, Plan};
use crate::error::Result;
use crate::geometry::Strips;
use crate::parametric::chart::Chart;
use crate::parametric::surface::Surface;
use crate::run::Run;
use crate::spatial::Aabb;

/// Samples along each parameter of a surface.
const SAMPLES: i32 = 16;
/// Surfaces that reach beyond the edges of the model by less than this share of their size are not looked at.
const BEYOND: f64 = 0.002;
/// Edges of the mesh that is looked at otherwise are at most this share of what may be the size,
const LONGEST: f64 = 0.2;
/// and at least this one: a face then has some hundred triangles, whatever its bends.
const SHORTEST: f64 = 0.05;
/// By how much neighbors turn there, radians: chords of it are off by less than a percent of a radius.
const TURN: f64 = 0.25;
/// How often a face is tried, each time with twice as many edges around it.
const ATTEMPTS: usize = 3;

impl Parametric {
    /// The box around the model: of its edges, and of coarse meshes of faces that may reach beyond them.
    pub(super) fn extent(&self, run: &Run) -> Result<Aabb> {
        let edges = self.boxes.iter().fold(Aabb::EMPTY, |a, b| a.union(b));
        let margin = BEYOND * edges.diagonal();
        let sticks_out = |f: usize| {
            let chart = &self.charts[f];
            if is_ruled(&chart.surface) {
                return Aabb::EMPTY;
            }
            let inner = edges.grown(margin);
            let beyond = |range: [[f64; 2]; 2]| {
                let b = sampled(&chart.surface, range);
                if inner.lo.cmple(b.lo).all() && inner.hi.cmpge(b.hi).all() { Aabb::EMPTY } else { b }
            };
            // Of a surface that is trimmed only a part counts.
            let all = beyond(chart.bounds);
            if all.is_empty() { all } else { beyond(self.trimmed(f, chart)) }
        };
        let faces = 0..self.charts.len();
        let far: Vec<Aabb> = run.install(|| faces.into_par_iter().map(sticks_out).collect());
        run.check()?;
        if far.iter().all(Aabb::is_empty) {
            return Ok(edges);
        }
        let most = far.iter().fold(edges, |a, b| a.union(b)).diagonal();
        let by = move |k: f64| (TURN / k.max(1e-300)).clamp(SHORTEST * most, LONGEST * most);
        let sizes = MeshSizes::new(LONGEST * most, SHORTEST * most, &by);
        let far: Vec<usize> = (0..far.len()).filter(|f| !far[*f].is_empty()).collect();
        Ok(edges.union(&self.around(&far, &sizes, run)?))
    }

    /// The box around some faces, meshed by curvature alone.
    fn around(&self, faces: &[usize], sizes: &MeshSizes<'_>, run: &Run) -> Result<Aabb> {
        let count = self.brep.edges.len();
        let mut factor = vec![0; count];
        let edges = |f: usize| self.brep.faces[f].loops.iter().flatten().map(|c| c.edge as usize);
        faces.iter().flat_map(|f| edges(*f)).for_each(|e| factor[e] = 1);
        let of = |i: usize| {
            let edge = &self.brep.edges[i];
            if factor[i] > 0 { sample(edge, &[], sizes, None).0 } else { Sampled::ends_of(edge) }
        };
        let sampled: Vec<Sampled> = run.install(|| (0..count).into_par_iter().map(of).collect());
        factor.fill(1);
        let field = SizeField::everywhere(sizes);
        let (least, leads) = (least_parts(&self.brep), vec![[Lead::default(); 2]; count]);
        let (strips, rings) = (Strips::new(count, Vec::new()), vec![Vec::new(); self.brep.faces.len()]);
        let mut out = Aabb::EMPTY;
        let mut left = faces.to_vec();
        for _ in 0..ATTEMPTS {
            run.check()?;
            let divisions = Divisions { factor: &factor, least: &least, leads: &leads, strips: &strips };
            let borders = self.borders(&sampled, &field, divisions);
            let count = AtomicUsize::new(0);
            let plan = Plan { sizes, field: &field, rings: &rings, borders: &borders, count };
            let fill = |f: &usize| (*f, self.face(*f as u32, &plan, &FxHashSet::default()));
            let made: Vec<_> = run.install(|| left.par_iter().map(fill).collect());
            left.clear();
            for (f, made) in made {
                match made {
                    Ok(made) => out = out.union(&Aabb::around(made.nodes)),
                    Err(_) => left.push(f),
                }
            }
            left.iter().flat_map(|f| edges(*f)).for_each(|e| factor[e] *= 2);
        }
        Ok(out)
    }

    /// The parameters a face may cover: those of its edges, and everything along directions that are periodic or have poles.
    fn trimmed(&self, f: usize, chart: &Chart) -> [[f64; 2]; 2] {
        let edges = self.brep.faces[f].loops.iter().flatten().map(|c| &self.brep.edges[c.edge as usize]);
        let points: Vec<DVec3> = edges
            .flat_map(|e| {
                let t = e.curve.pieces(e.range);
                let middles: Vec<f64> = t.windows(2).map(|w| 0.5 * (w[0] + w[1])).collect();
                t.into_iter().chain(middles).map(|t| e.curve.at(t))
            })
            .collect();
        let uv: Vec<DVec2> = points.iter().map(|p| chart.project(*p)).collect();
        let mut out = chart.bounds;
        for (k, range) in out.iter_mut().enumerate() {
            if chart.periods[k].is_none() && !chart.poles.iter().any(|p| p.axis == k) && !uv.is_empty() {
                let [lo, hi] = *range;
                *range = uv.iter().fold([hi, lo], |r, p| [r[0].min(p[k]), r[1].max(p[k])]);
            }
        }
        out
    }
}

/// Whether a straight line of the surface runs through each of its points: faces reach no farther than their edges then.
fn is_ruled(s: &Surface) -> bool {
    use Surface::{Cone, Cylinder, Extrusion, Plane, Ruled};
    matches!(s, Plane { .. } | Cylinder { .. } | Cone { .. } | Extrusion { .. } | Ruled { .. })
}

/// The box around samples of a surface.
fn sampled(surface: &Surface, [u, v]: [[f64; 2]; 2]) -> Aabb {
    let at = |r: [f64; 2], k: i32| r[0] + (r[1] - r[0]) * f64::from(k) / f64::from(SAMPLES);
    let row = |i: i32| (0..=SAMPLES).map(move |j| surface.at(DVec2::new(at(u, i), at(v, j))));
    Aabb::around((0..=SAMPLES).flat_map(row))
}

/// The box around a surface that has no edges.
pub(super) fn whole(surface: &Surface) -> Aabb {
    sampled(surface, surface.domain().map(|[a, b]| if (b - a).is_finite() { [a, b] } else { [0.0, 1.0] }))
}
