//! The function itself at points: values, gradients, which face decides, inside or not; many points at once.

use std::cell::Cell;

use glam::DVec3;
use rayon::prelude::*;

use super::joined::{self, Connective};
use super::leaf::Leaf;
use super::model::Implicit;
use super::tape::{EVERYTHING, Op};
use crate::error::Result;
use crate::numeric::NONE;
use crate::run::Run;

/// Points a thread evaluates before it looks whether the run goes on. No result depends on it.
pub(super) const BATCH: usize = 256;

/// Registers of a batch are kept within this many numbers, so that they stay in the cache.
const REGISTERS: usize = 1 << 15;

/// What is asked for beyond values and insides.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Sampling {
    /// Gradients.
    pub gradients: bool,
    /// Faces and leaves.
    pub faces: bool,
}

/// What a solid's function is at points, in the order of the points.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Samples {
    /// Values of the R-function tree, in the part's unit where its leaves are normalized: positive inside. A leaf that is exactly
    /// zero counts as the smallest normal number, positive on the leaf's own side, so signs are never in doubt. NaN where a formula
    /// or field is.
    pub values: Vec<f64>,
    /// Gradients, where asked for. They point inwards and have no unit. Where there is none they are those of min / max.
    pub gradients: Vec<DVec3>,
    /// Indices into [`Implicit::faces`], where asked for: the face whose leaf decides min / max of all leaves.
    pub faces: Vec<Option<u32>>,
    /// The numbers of these leaves, where faces are asked for: below [`Implicit::leaf_count`].
    pub leaves: Vec<Option<u32>>,
    /// Whether a point is inside, by the signs of the leaves alone.
    pub inside: Vec<bool>,
}

impl Samples {
    fn with_capacity(n: usize, wanted: Sampling) -> Self {
        let some = |is: bool| if is { n } else { 0 };
        Samples {
            values: Vec::with_capacity(n),
            gradients: Vec::with_capacity(some(wanted.gradients)),
            faces: Vec::with_capacity(some(wanted.faces)),
            leaves: Vec::with_capacity(some(wanted.faces)),
            inside: Vec::with_capacity(n),
        }
    }

    /// Adds the samples of further points.
    pub fn append(&mut self, mut more: Samples) {
        self.values.append(&mut more.values);
        self.gradients.append(&mut more.gradients);
        self.faces.append(&mut more.faces);
        self.leaves.append(&mut more.leaves);
        self.inside.append(&mut more.inside);
    }
}

/// Evaluates the function of a solid at points, in parallel batches.
///
/// Guarantees: values are bit by bit those of [`Implicit::value`], insides those of [`Implicit::inside`], for any number of
/// threads and whatever else is asked for. Fields are asked for many values and gradients at once. At most 256 points are
/// evaluated on the calling thread.
///
/// Errors: cancellation.
pub fn evaluate(model: &Implicit, points: &[DVec3], wanted: Sampling, run: &Run) -> Result<Samples> {
    run.check()?;
    if points.len() <= BATCH {
        thread_local! {
            static KEPT: Cell<Registers> = Cell::default();
        }
        // taken, not lent, for a field of a program may come back here
        let mut registers = KEPT.take();
        let found = registers.batch(model, points, wanted);
        KEPT.set(registers);
        return Ok(found);
    }
    let parts: Vec<Samples> = run.install(|| {
        points
            .par_chunks(BATCH)
            .map_init(Registers::default, |registers, some| {
                run.check()?;
                Ok(registers.batch(model, some, wanted))
            })
            .collect::<Result<_>>()
    })?;
    let mut all = Samples::with_capacity(points.len(), wanted);
    parts.into_iter().for_each(|part| all.append(part));
    Ok(all)
}

/// Results of all operations of a tape at the points of a batch, kept between batches.
#[derive(Default)]
struct Registers {
    /// The points' coordinates.
    at: [Vec<f64>; 3],
    /// The R-functions.
    values: Vec<f64>,
    /// The companion, by min and max.
    signs: Vec<f64>,
    /// The operations, all of them leaves, that decide the companion.
    deciding: Vec<u32>,
    /// Derivatives of the root by each operation.
    weights: Vec<f64>,
    /// What an operation adds to the weights of its operands.
    by: [Vec<f64>; 2],
    /// What a leaf is asked for.
    asked: LeafGradients,
}

/// Where a leaf matters, and its gradients and values there.
#[derive(Default)]
struct LeafGradients {
    points: Vec<usize>,
    at: [Vec<f64>; 3],
    slopes: [Vec<f64>; 4],
}

impl LeafGradients {
    /// Gradients of a leaf at the points where its weight is not zero; gives whether these are all. Else they are
    /// [`points`](Self::points).
    fn ask(&mut self, leaf: &Leaf, at: &[Vec<f64>; 3], weights: &[f64]) -> bool {
        let n = weights.len();
        let all = weights.iter().all(|w| *w != 0.0);
        self.points.clear();
        if !all {
            self.points.extend((0..n).filter(|k| weights[*k] != 0.0));
        }
        let m = if all { n } else { self.points.len() };
        for slopes in &mut self.slopes {
            slopes.resize(n.max(slopes.len()), 0.0);
        }
        for (every, some) in at.iter().zip(&mut self.at).filter(|_| !all) {
            some.clear();
            some.extend(self.points.iter().map(|k| every[*k]));
        }
        let at = if all { at } else { &self.at };
        leaf.gradients(at.each_ref().map(|list| &list[..]), self.slopes.each_mut().map(|list| &mut list[..m]));
        all
    }
}

impl Registers {
    fn batch(&mut self, model: &Implicit, points: &[DVec3], wanted: Sampling) -> Samples {
        let mut out = Samples::with_capacity(points.len(), wanted);
        let lanes = (REGISTERS / model.tape.ops.len()).clamp(4, BATCH);
        for some in points.chunks(lanes) {
            self.forward(model, some, wanted.faces);
            let last = (model.tape.ops.len() - 1) * some.len();
            out.values.extend_from_slice(&self.values[last..]);
            out.inside.extend(self.signs[last..].iter().map(|v| *v > 0.0));
            if wanted.faces {
                let decided = |k: usize| model.tape.ops.get(self.deciding[last + k] as usize);
                for (k, p) in some.iter().enumerate() {
                    let found = match decided(k) {
                        Some(Op::Leaf { leaf, face, .. }) => Some((*leaf, model.face_at(*leaf, *face, *p))),
                        _ => None,
                    };
                    out.leaves.push(found.map(|f| f.0));
                    out.faces.push(found.map(|f| f.1));
                }
            }
            if wanted.gradients {
                self.backward(model, some, &mut out.gradients);
            }
        }
        out
    }

    /// Values of all operations, each from those before it.
    fn forward(&mut self, model: &Implicit, points: &[DVec3], faces: bool) {
        let (n, count, system) = (points.len(), model.tape.ops.len(), model.rsystem());
        for (axis, list) in self.at.iter_mut().enumerate() {
            list.clear();
            list.extend(points.iter().map(|p| p[axis]));
        }
        let [x, y, z] = &self.at;
        // whatever is in them: each operation writes its own before another reads it
        for list in [&mut self.values, &mut self.signs] {
            list.resize(n * count, 0.0);
        }
        self.deciding.clear();
        self.deciding.resize(if faces { n * count } else { 0 }, NONE);
        for (i, op) in model.tape.ops.iter().enumerate() {
            let (values, here) = self.values.split_at_mut(i * n);
            let (signs, sign) = self.signs.split_at_mut(i * n);
            let (here, sign) = (&mut here[..n], &mut sign[..n]);
            let (a, b, larger) = match *op {
                Op::All(inside) => {
                    let side = if inside { 1.0 } else { -1.0 };
                    here.fill(side * EVERYTHING.sqrt());
                    sign.fill(side * EVERYTHING);
                    continue;
                }
                Op::Leaf { leaf, negate, .. } => {
                    joined::leaf(&model.leaves[leaf as usize], negate, [x, y, z], here);
                    sign.copy_from_slice(here);
                    if faces {
                        self.deciding[i * n..][..n].fill(i as u32);
                    }
                    continue;
                }
                Op::Min(a, b) => (a as usize * n, b as usize * n, false),
                Op::Max(a, b) => (a as usize * n, b as usize * n, true),
            };
            joined::values(Connective { system, larger }, [&values[a..][..n], &values[b..][..n]], here);
            joined::signs(larger, [&signs[a..][..n], &signs[b..][..n]], sign);
            if faces {
                for k in 0..n {
                    let from = if (signs[a + k] < signs[b + k]) != larger { a } else { b };
                    self.deciding[i * n + k] = self.deciding[from + k];
                }
            }
        }
    }

    /// Gradients of the root: its derivatives by the operations from the last to the first, then by the leaves' own gradients.
    /// Leaves that do not matter at a point are not asked there.
    fn backward(&mut self, model: &Implicit, points: &[DVec3], out: &mut Vec<DVec3>) {
        let (n, count, system) = (points.len(), model.tape.ops.len(), model.rsystem());
        self.weights.clear();
        self.weights.resize(n * count, 0.0);
        self.weights[(count - 1) * n..].fill(1.0);
        self.by.iter_mut().for_each(|list| list.resize(n, 0.0));
        let start = out.len();
        out.resize(start + n, DVec3::ZERO);
        for (i, op) in model.tape.ops.iter().enumerate().rev() {
            let (weights, here) = self.weights.split_at_mut(i * n);
            let (a, b, larger) = match *op {
                Op::All(_) => continue,
                Op::Leaf { leaf, negate, .. } => {
                    let leaf = &model.leaves[leaf as usize];
                    let here = &here[..n];
                    let all = self.asked.ask(leaf, &self.at, here);
                    let side = if negate { -1.0 } else { 1.0 };
                    let LeafGradients { points, slopes: [x, y, z, _], .. } = &self.asked;
                    let slopes = x.iter().zip(y).zip(z).map(|((x, y), z)| DVec3::new(*x, *y, *z));
                    if all {
                        let weighed = here.iter().zip(slopes).map(|(w, g)| g * (side * w));
                        out[start..].iter_mut().zip(weighed).for_each(|(sum, g)| *sum += g);
                    } else {
                        points.iter().zip(slopes).for_each(|(k, g)| out[start + k] += g * (side * here[*k]));
                    }
                    continue;
                }
                Op::Min(a, b) => (a as usize * n, b as usize * n, false),
                Op::Max(a, b) => (a as usize * n, b as usize * n, true),
            };
            let operands = [a, b].map(|a| &self.values[a..][..n]);
            joined::weights(
                Connective { system, larger },
                operands,
                &here[..n],
                self.by.each_mut().map(|list| &mut list[..]),
            );
            for (a, by) in [a, b].into_iter().zip(&self.by) {
                weights[a..][..n].iter_mut().zip(by).for_each(|(sum, w)| *sum += w);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::implicit::RSystem;
    use crate::implicit::Solid;

    #[test]
    fn batches_are_bit_by_bit_what_single_points_are() {
        let ball = |x: f64| Solid::sphere(0.8, DVec3::new(x, 0.1, -0.2));
        let drill = Solid::cylinder(0.3, DVec3::new(1.0, 2.0, 3.0), DVec3::ZERO, None);
        let solid = ((ball(0.0) | ball(0.7)) - drill) | Solid::cuboid(DVec3::splat(-0.9), DVec3::splat(-0.1));
        let mut state = 1u64;
        let mut unit = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1u64 << 53) as f64
        };
        let mut points: Vec<DVec3> = (0..3000).map(|_| DVec3::new(unit(), unit(), unit()) * 3.0 - 1.5).collect();
        // On faces, edges and corners of the box.
        points.extend([DVec3::splat(-0.9), DVec3::new(-0.9, -0.9, -0.5), DVec3::new(-0.9, -0.3, -0.5)]);
        let wanted = Sampling { gradients: true, faces: true };
        for system in [RSystem::MinMax, RSystem::R0, RSystem::RAlpha(-0.5), RSystem::R0m(2)] {
            let model = Implicit::new(&solid, system, None).unwrap();
            let found = evaluate(&model, &points, wanted, &Run::new()).unwrap();
            for (i, p) in points.iter().enumerate() {
                assert_eq!(found.values[i].to_bits(), model.value(*p).to_bits(), "{system:?} {p}");
                assert_eq!(found.inside[i], model.inside(*p), "{system:?} {p}");
                assert_eq!(found.faces[i], Some(model.tape.active(&model.leaves, *p).face), "{system:?} {p}");
                let gradient = model.gradient(*p).1;
                let off = (found.gradients[i] - gradient).length();
                assert!(off <= 1e-13 * (1.0 + gradient.length()), "{system:?} {p}: {off}");
            }
        }
    }
}
