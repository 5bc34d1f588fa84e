//! The surface of an R-function part as the shared stages see it.

use glam::DVec3;

use super::apex::{apexes, apexes_of};
use super::extract::Extracted;
use super::leaf::Leaf;
use super::lockstep;
use super::model::Implicit;
use super::newton::{Meeting, bounds_solid, bounds_together, leaves_of, nearest};
use super::octree::Bricks;
use super::tape::{Active, Op, Tape};
use crate::error::Result;
use crate::geometry::{Foot, SurfaceOracle};
use crate::numeric::{Bracket, LAST_PLACES};
use crate::run::Run;
use crate::spatial::Aabb;

/// Steps a line is sampled with on each side when the straight guess fails.
const LINE_STEPS: usize = 8;

/// Where the crossing of a line is sought first: this share of the guessed distance to both sides of the guess.
const GUESS_WIDTH: f64 = 0.02;

/// The distance to a leaf is estimated by its value and gradient; curvature makes the estimate too large by less than this
/// factor within the reaches in use.
const NEARER: f64 = 1.5;

/// The oracle of an R-function part. Normals, curvatures and projections come from the active leaf, never from the
/// R-function's own gradient, which is not normalized away from the surface.
///
/// Works near the surface, where it uses the pruned tapes of the extraction's cells; elsewhere it asks the whole tree.
#[derive(Debug)]
pub struct ImplicitOracle<'a> {
    model: &'a Implicit,
    bricks: Bricks,
    scale: f64,
    /// The apexes that count, if not all do.
    apexes: Option<Vec<(u32, DVec3)>>,
}

impl<'a> ImplicitOracle<'a> {
    /// An oracle that shares the cells of an extraction.
    pub fn new(model: &'a Implicit, extracted: &Extracted) -> Self {
        let mut bricks = extracted.bricks.clone();
        bricks.add(&extracted.undecided);
        Self { model, bricks, scale: model.bounds().diagonal(), apexes: None }
    }

    /// An oracle of what lies in a box: it has cells there only, and only the apexes that `is_mine` says.
    pub(crate) fn within(
        model: &'a Implicit,
        size: f64,
        bounds: Aabb,
        is_mine: &dyn Fn(DVec3) -> bool,
        run: &Run,
    ) -> Result<Self> {
        let bricks = Bricks::build_within(model, &bounds, size, u64::MAX, run)?;
        let apexes = Some(apexes_of(model, is_mine));
        Ok(Self { model, bricks, scale: model.bounds().diagonal(), apexes })
    }

    /// The apexes that count, with their leaves.
    pub(super) fn own_apexes(&self) -> Vec<(u32, DVec3)> {
        self.apexes.clone().unwrap_or_else(|| apexes(self.model))
    }

    /// An oracle with cells of its own, of about the given size.
    pub fn with_cells(model: &'a Implicit, size: f64, run: &Run) -> Result<Self> {
        let bricks = Bricks::build(model, size, u64::MAX, run)?;
        Ok(Self { model, bricks, scale: model.bounds().diagonal(), apexes: None })
    }

    pub(super) fn tape(&self, p: DVec3) -> &Tape {
        self.bricks.tape_at(&self.model.tape, p)
    }

    pub(super) fn leaves(&self) -> &[Leaf] {
        &self.model.leaves
    }

    /// For each face whether it has a leaf of some kind.
    pub(super) fn faces_with(&self, kind: impl Fn(&Leaf) -> bool) -> Vec<bool> {
        let mut faces = vec![false; self.model.faces().len()];
        for op in &self.model.tape.ops {
            if let Op::Leaf { leaf, face, .. } = op {
                faces[*face as usize] |= kind(&self.model.leaves[*leaf as usize]);
            }
        }
        faces
    }

    /// The surroundings of a point.
    pub(super) fn meeting(&self, q: DVec3) -> Meeting<'_> {
        self.meeting_by(self.tape(q))
    }

    /// The surroundings of a point at which a tape is valid.
    fn meeting_by<'t>(&'t self, tape: &'t Tape) -> Meeting<'t> {
        let (whole, leaves) = (&self.model.tape, self.leaves());
        Meeting { tape, holds: Aabb::EMPTY, bricks: &self.bricks, whole, leaves, scale: self.scale }
    }

    /// The foot of a point on the surface within `reach`, where a tape is valid wherever that leads.
    pub(super) fn project_by(&self, tape: &Tape, p: DVec3, reach: f64) -> Option<Foot> {
        Look { oracle: self, tape, valid: true, p, reach, best: None }.foot()
    }

    pub(super) fn model(&self) -> &Implicit {
        self.model
    }

    pub(super) fn scale(&self) -> f64 {
        self.scale
    }

    /// The foot at a point known to lie on `leaf`, of which the `inside` may be known.
    fn foot(&self, q: DVec3, tape: &Tape, leaf: u32, inside: Option<bool>) -> Option<Foot> {
        let here = occurrence(tape, leaf)?;
        // on an edge or corner the other leaves' signs are those of rounding: there the occurrence tells the side
        let inside = inside.or_else(|| bounds_solid(tape, self.leaves(), leaf, q)).unwrap_or(!here.negate);
        let n = self.leaves()[leaf as usize].slope(q).try_normalize()?;
        Some(Foot { point: q, normal: if inside { -n } else { n }, face: here.face })
    }

    /// Principal curvatures of a leaf at a point on it, as seen from the side of `outward`.
    pub(super) fn leaf_curvatures(&self, leaf: u32, q: DVec3, outward: DVec3) -> Option<[f64; 2]> {
        let leaf = &self.leaves()[leaf as usize];
        let slope = leaf.slope(q);
        let length = slope.length();
        if !(length > 0.0) {
            return None;
        }
        // curvature of the surface seen from the side the foot's normal points to
        let side = if slope.dot(outward) < 0.0 { 1.0 } else { -1.0 };
        let h = leaf.hessian(q, self.scale);
        let apply = |v: DVec3| h[0] * v.x + h[1] * v.y + h[2] * v.z;
        let (u, v) = outward.any_orthonormal_pair();
        let k = -side / length;
        let (a, b, c) = (k * u.dot(apply(u)), k * 0.5 * (u.dot(apply(v)) + v.dot(apply(u))), k * v.dot(apply(v)));
        let (mean, half) = (0.5 * (a + c), (0.5 * (a - c)).hypot(b));
        let (x, y) = (mean + half, mean - half);
        let both = if x.abs() >= y.abs() { [x, y] } else { [y, x] };
        both.iter().all(|k| k.is_finite()).then_some(both)
    }

    /// The tape that lists the leaves worth trying near a point: its cell's, else that of a neighboring cell.
    fn tape_near(&self, p: DVec3) -> &Tape {
        let Some(at) = self.bricks.grid.brick_of(p) else { return &self.model.tape };
        if let Some(i) = self.bricks.find(at) {
            return &self.bricks.cells[i].tape;
        }
        let mut best: Option<(f64, usize)> = None;
        let width = self.bricks.grid.h * super::octree::BRICK as f64;
        for d in 0..27u32 {
            let shift = [d % 3, d / 3 % 3, d / 9];
            let n: [u32; 3] = std::array::from_fn(|k| (at[k] + shift[k]).wrapping_sub(1));
            if let Some(i) = self.bricks.find(n) {
                let center =
                    self.bricks.grid.origin + (DVec3::new(n[0].into(), n[1].into(), n[2].into()) + 0.5) * width;
                let d = center.distance_squared(p);
                if best.is_none_or(|b| d < b.0) {
                    best = Some((d, i));
                }
            }
        }
        best.map_or(&self.model.tape, |(_, i)| &self.bricks.cells[i].tape)
    }
}

/// The best surface point so far.
struct Best<'t> {
    q: DVec3,
    /// The tape that is valid there.
    tape: &'t Tape,
    leaf: u32,
    distance: f64,
    /// Which side of the leaf is inside, where that was asked.
    inside: Option<bool>,
}

/// The search for the surface point nearest to `p`.
struct Look<'t> {
    oracle: &'t ImplicitOracle<'t>,
    /// Lists the leaves worth trying.
    tape: &'t Tape,
    /// Whether `tape` is valid wherever `reach` leads, so that no other needs to be asked.
    valid: bool,
    p: DVec3,
    reach: f64,
    best: Option<Best<'t>>,
}

impl<'t> Look<'t> {
    /// The foot of the nearest point there is.
    fn foot(mut self) -> Option<Foot> {
        let only = if let [Op::Leaf { leaf, .. }] = self.tape.ops[..] { Some(leaf) } else { None };
        let first = only.unwrap_or_else(|| self.tape.active(self.oracle.leaves(), self.p).leaf);
        let first = (first != u32::MAX).then_some(first);
        let sure = first.is_some_and(|leaf| self.offer(&[leaf]));
        if !(sure && only.is_some()) {
            self.look_around(first, sure);
        }
        let best = self.best?;
        self.oracle.foot(best.q, best.tape, best.leaf, best.inside)
    }

    /// Tries the nearest point of the leaves `which`.
    fn offer(&mut self, which: &[u32]) -> bool {
        let (oracle, leaves) = (self.oracle, self.oracle.leaves());
        let limit = self.best.as_ref().map_or(self.reach, |b| b.distance.min(self.reach));
        let Some(q) = nearest(leaves, which, self.p, limit, oracle.scale) else { return false };
        let tape = if self.valid { self.tape } else { oracle.tape(q) };
        let mut inside = None;
        let valid = match which {
            [i] => {
                inside =
                    bounds_solid(tape, leaves, *i, q).or_else(|| bounds_together(tape, leaves, *i, q, oracle.scale));
                inside.is_some()
            }
            [i, j] => oracle.meeting_by(tape).edge(*i, *j, q).is_some(),
            [i, j, k] => oracle.meeting_by(tape).corner([*i, *j, *k], q),
            _ => false,
        };
        if valid {
            self.best = Some(Best { q, tape, leaf: which[0], distance: q.distance(self.p), inside });
        }
        valid
    }

    /// No leaf whose distance is estimated to be more can have a surface point nearer than what there is.
    fn limit(&self) -> f64 {
        NEARER * self.best.as_ref().map_or(self.reach, |b| b.distance)
    }

    /// Looks for a surface point nearer than what there is: on the other leaves, then, if some leaf's nearest point is not on
    /// the boundary, on the edges and corners they make.
    fn look_around(&mut self, first: Option<u32>, sure: bool) {
        let farthest = self.limit();
        if sure && !self.any_nearer(first, farthest) {
            return;
        }
        let mut near: Vec<(f64, u32)> = leaves_of(self.tape)
            .into_iter()
            .map(|i| {
                let d = self.oracle.leaves()[i as usize].gradient(self.p);
                let l = d.g.length();
                (if l > 0.0 { d.v.abs() / l } else { 0.0 }, i)
            })
            .filter(|(d, _)| !(*d > farthest))
            .collect();
        near.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let mut missed = !sure;
        for (d, i) in &near {
            if Some(*i) != first && *d <= self.limit() {
                missed |= !self.offer(&[*i]);
            }
        }
        if !missed {
            return;
        }
        // an edge or corner is no nearer than any of its leaves
        for (n, (d, j)) in near.iter().enumerate() {
            if *d > self.limit() {
                break;
            }
            for (_, i) in &near[..n] {
                self.offer(&[*i, *j]);
            }
        }
        for (n, (d, k)) in near.iter().enumerate() {
            if *d > self.limit() {
                break;
            }
            for (m, (_, j)) in near[..n].iter().enumerate() {
                for (_, i) in &near[..m] {
                    self.offer(&[*i, *j, *k]);
                }
            }
        }
    }

    /// Whether a leaf other than `first` may be within `farthest` of the point.
    fn any_nearer(&self, first: Option<u32>, farthest: f64) -> bool {
        self.tape.ops.iter().any(|op| match *op {
            Op::Leaf { leaf, .. } if Some(leaf) != first => {
                let d = self.oracle.leaves()[leaf as usize].gradient(self.p);
                !(d.v.abs() > farthest * d.g.length())
            }
            _ => false,
        })
    }
}

/// The first occurrence of a leaf in a tape.
fn occurrence(tape: &Tape, leaf: u32) -> Option<Active> {
    tape.ops.iter().find_map(|op| match *op {
        Op::Leaf { leaf: l, face, negate } if l == leaf => Some(Active { leaf, face, negate, value: 0.0 }),
        _ => None,
    })
}

impl SurfaceOracle for ImplicitOracle<'_> {
    fn project(&self, p: DVec3, reach: f64) -> Option<Foot> {
        Look { oracle: self, tape: self.tape_near(p), valid: false, p, reach, best: None }.foot()
    }

    fn project_all(&self, points: &[DVec3], reach: f64) -> Vec<Option<Foot>> {
        lockstep::together(points.len(), |i| self.project(points[i], reach))
    }

    fn in_turn(&self, count: usize, question: &mut dyn FnMut(usize)) {
        lockstep::together(count, question);
    }

    fn project_along(&self, p: DVec3, direction: DVec3, reach: f64) -> Option<Foot> {
        let value = |t: f64| {
            let q = p + direction * t;
            self.tape(q).value(self.leaves(), q)
        };
        let start = self.tape(p).active(self.leaves(), p);
        let f0 = start.value;
        let slope = start.gradient(self.leaves(), p).g.dot(direction);
        let mut found = None;
        let guess = -f0 / slope;
        if guess.abs() < reach {
            let width = (GUESS_WIDTH * guess.abs()).max(1e-9 * reach);
            let (a, b) = (guess - width, guess + width);
            let (fa, fb) = (value(a), value(b));
            let near_side = if guess >= 0.0 { fa } else { fb };
            if (fa > 0.0) != (fb > 0.0) && (near_side > 0.0) == (f0 > 0.0) {
                found = Some((a, fa, b, fb));
            }
        }
        if found.is_none() {
            let step = reach / LINE_STEPS as f64;
            let mut last = [(0.0, f0); 2];
            'search: for i in 1..=LINE_STEPS {
                for (side, sign) in [1.0, -1.0].into_iter().enumerate() {
                    let t = sign * step * i as f64;
                    let f = value(t);
                    let (s, fs) = last[side];
                    if (f > 0.0) != (fs > 0.0) {
                        found = Some((s, fs, t, f));
                        break 'search;
                    }
                    last[side] = (t, f);
                }
            }
        }
        let (a, fa, b, fb) = found?;
        let width = (b - a).abs();
        let mut bracket = Bracket::new(fa, fb, LAST_PLACES * self.scale / width);
        while !bracket.done() {
            let x = bracket.probe();
            bracket.update(x, value(a + (b - a) * x));
        }
        let q = p + direction * (a + (b - a) * bracket.root());
        let tape = self.tape(q);
        let leaf = tape.active(self.leaves(), q).leaf;
        self.leaves().get(leaf as usize)?;
        self.foot(q, tape, leaf, None)
    }

    fn curvatures(&self, foot: &Foot) -> Option<[f64; 2]> {
        let q = foot.point;
        let tape = self.tape(q);
        let leaf = tape
            .ops
            .iter()
            .filter_map(|op| match op {
                Op::Leaf { leaf, face, .. } if *face == foot.face => Some(*leaf),
                _ => None,
            })
            .min_by(|a, b| {
                let f = |i: &u32| self.leaves()[*i as usize].value(q).abs();
                f(a).total_cmp(&f(b))
            })?;
        self.leaf_curvatures(leaf, q, foot.normal)
    }
}
