//! A solid made ready: leaves, tape, faces and bounds, and the questions one may ask of it at a point.

use std::cmp::Ordering;
use std::collections::{BTreeSet, BinaryHeap};
use std::sync::Arc;

use glam::DVec3;

use super::alike::unified;
use super::leaf::{Leaf, unplace};
use super::lockstep;
use super::lower::{FaceInfo, lower, lower_within};
use super::rfunction::RSystem;
use super::solid::Solid;
use super::steps::Within;
use super::tape::{Op, Pruned, Scratch, Tape};
use crate::error::{Error, NoBody, Place, Result};
use crate::spatial::Aabb;

/// Bounds are tightened on a grid of this many halvings: within 1/32 of the side they come out of the tree with.
const TIGHTEN_LEVELS: usize = 5;
/// Cells that are halved at once where calls for many points are cheap: their parts are 512 points, with which calls of numpy are.
const AHEAD: usize = 64;

/// The outermost shell that is looked at for what is inside reaches from half of two to this power to all of it. Lengths are less, in any unit.
const FARTHEST: i32 = 30;
/// At least so many shells in a row, each twice as large as the next, must be shown empty: what is farther off would not be seen.
const SHELLS: i32 = 12;
/// Smaller ones than of two to this power are not looked at.
const NEAREST: i32 = -20;
/// Shells are halved so often for it: to a 1024th, so that a function counts as negative where its greatest terms cancel to about a 100th. One that
/// is not negative is given up after as many cells.
const SHELL_LEVELS: usize = 10;

/// A cell that waits to be looked at; those that reach furthest come first.
struct Waiting {
    key: f64,
    cell: Aabb,
    level: usize,
    tape: Arc<Tape>,
    /// What holds in the cell, where that is known beforehand.
    pruned: Option<Pruned>,
}

impl Ord for Waiting {
    fn cmp(&self, other: &Self) -> Ordering {
        self.key.total_cmp(&other.key).then(self.level.cmp(&other.level))
    }
}

impl PartialOrd for Waiting {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Waiting {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Waiting {}

/// A bounded solid: the zero set of an R-function tree, positive inside.
#[derive(Debug, Clone)]
pub struct Implicit {
    pub(crate) leaves: Vec<Leaf>,
    pub(crate) tape: Arc<Tape>,
    faces: Vec<FaceInfo>,
    /// Leaves with several faces.
    several: Vec<Several>,
    rsystem: RSystem,
    bounds: Aabb,
}

/// A leaf that knows faces of its own: the first is `face`, the `count` others follow each other from `others`.
#[derive(Debug, Clone, Copy)]
struct Several {
    leaf: u32,
    face: u32,
    others: u32,
    count: u32,
}

/// A box with the sides of another that are finite, and the others at powers of two, the smallest beyond which a function is negative by its
/// greatest values in slabs; infinite where that is not seen.
fn finite_sides(bounds: &Aabb, greatest: &dyn Fn(&Aabb) -> f64) -> Aabb {
    let mut found = *bounds;
    for k in 0..3 {
        for high in [false, true] {
            let known = if high { bounds.hi[k] } else { bounds.lo[k] };
            if known.is_finite() {
                continue;
            }
            let is_empty_beyond = |r: &f64| {
                let mut slab = *bounds;
                if high {
                    slab.lo[k] = *r
                } else {
                    slab.hi[k] = -r
                }
                greatest(&slab) < 0.0
            };
            let Some(r) = (-20..60).map(|n| 2f64.powi(n)).find(is_empty_beyond) else { continue };
            if high { found.hi[k] = r } else { found.lo[k] = -r }
        }
    }
    found
}

/// A box outside of which a function is negative by its greatest values in slabs, if such a box is found.
pub(super) fn box_around(greatest: &dyn Fn(&Aabb) -> f64) -> Option<Aabb> {
    let found = finite_sides(&Aabb::ALL, greatest);
    found.is_finite().then_some(found)
}

impl Implicit {
    /// Lowers a solid and finds a box around it.
    ///
    /// `domain` cuts the solid off: its walls become faces `domain.xmin` ... `domain.zmax` where the solid may reach them.
    /// Without it the box comes from the tree's structure and from interval arithmetic.
    ///
    /// Errors: a bad primitive; a solid that is empty; one without finite bounds and without `domain`.
    pub fn new(solid: &Solid, rsystem: RSystem, domain: Option<Aabb>) -> Result<Self> {
        let rsystem = rsystem.checked()?;
        let mut solid = solid.clone();
        let mut low = lower(&solid)?;
        if let Some(d) = domain {
            if d.is_empty() || !d.is_finite() {
                return Err(Error::input(Place::Unknown, "the domain must be a finite box with lo < hi"));
            }
            let walls = Solid::cuboid(d.lo, d.hi).name("domain");
            solid = walls & solid;
            low = lower(&solid)?;
        }
        let mut model = Implicit {
            leaves: low.leaves,
            tape: Arc::new(low.tape),
            faces: low.faces,
            several: Vec::new(),
            rsystem,
            bounds: low.bounds,
        };
        if !model.bounds.is_empty() && !model.bounds.is_finite() {
            model.bounds = model.find_bounds().ok_or_else(|| {
                let what = "the solid may be infinite: no finite box around it can be proved";
                Error::input(Place::Solid(NoBody::Endless), what).with_help(
                    "give part(..., domain=((x0, y0, z0), (x1, y1, z1))); a .vm file ends with the max of it and a box",
                )
            })?;
        }
        for _ in 0..2 {
            model.bounds = model.tightened(&model.bounds);
        }
        if low.has_steps && !model.bounds.is_empty() {
            let apart = lower_within(&solid, Within { bounds: model.bounds, closed: false })?;
            (model.leaves, model.tape, model.faces) = (apart.leaves, Arc::new(apart.tape), apart.faces);
        }
        if model.bounds.is_empty() {
            return Err(Error::input(Place::Solid(NoBody::Empty), "the solid is empty: nothing is inside anywhere"));
        }
        if let Some(tape) = unified(&model.leaves, &model.tape, &model.bounds) {
            model.tape = Arc::new(tape);
        }
        model.name_faces_of_fields();
        Ok(model)
    }

    /// Lists the faces that fields know of themselves.
    fn name_faces_of_fields(&mut self) {
        for op in &self.tape.ops {
            let Op::Leaf { leaf, face, .. } = *op else { continue };
            let Leaf::Field(field, _) = &self.leaves[leaf as usize] else { continue };
            let mut names = field.faces().into_iter();
            let known = self.several.iter().any(|s| s.leaf == leaf);
            let Some(first) = names.next().filter(|_| !known) else { continue };
            let (others, count) = (self.faces.len() as u32, names.len() as u32);
            self.several.push(Several { leaf, face, others, count });
            let size = self.faces[face as usize].size;
            self.faces[face as usize].name = first;
            self.faces.extend(names.map(|name| FaceInfo { name, size }));
        }
    }

    /// The face at a point where this leaf decides, whose face is `alone` if it has but one.
    pub(super) fn face_at(&self, leaf: u32, alone: u32, p: DVec3) -> u32 {
        let Some(several) = self.several.iter().find(|s| s.leaf == leaf) else { return alone };
        match &self.leaves[leaf as usize] {
            Leaf::Field(field, placed) => match field.face_at(unplace(placed, p)) {
                0 => several.face,
                k => several.others + k - 1,
            },
            _ => alone,
        }
    }

    /// The numbers of the leaves of each face, ascending.
    pub fn leaves_by_face(&self) -> Vec<Vec<u32>> {
        let mut found = vec![BTreeSet::new(); self.faces.len()];
        for op in &self.tape.ops {
            if let Op::Leaf { leaf, face, .. } = op
                && let Some(of) = found.get_mut(*face as usize)
            {
                of.insert(*leaf);
            }
        }
        for s in &self.several {
            for face in std::iter::once(s.face).chain(s.others..s.others + s.count) {
                if let Some(of) = found.get_mut(face as usize) {
                    *of = BTreeSet::from([s.leaf]);
                }
            }
        }
        found.into_iter().map(|of| of.into_iter().collect()).collect()
    }

    /// A box around the inside of one leaf, if one can be proved: a formula may show what its parts do not.
    pub(super) fn box_of(leaf: Leaf) -> Option<Aabb> {
        let tape = Tape { ops: vec![Op::Leaf { leaf: 0, face: 0, negate: false }] };
        let (tape, rsystem) = (Arc::new(tape), RSystem::default());
        Implicit { leaves: vec![leaf], tape, faces: Vec::new(), several: Vec::new(), rsystem, bounds: Aabb::ALL }
            .find_bounds()
    }

    /// A box outside of which the sign is negative everywhere: the structure's finite sides, the others at powers of two, the smallest
    /// that interval arithmetic proves.
    fn find_bounds(&self) -> Option<Aabb> {
        let found = finite_sides(&self.bounds, &|slab| self.tape.range(&self.leaves, slab).hi);
        if found.is_finite() { Some(found) } else { self.bounds_by_shells(&found) }
    }

    /// A box beyond which nothing is inside in shells up to very far away, each shown in parts: bounds of a formula over
    /// all of space may be without end where those over parts of it are not.
    fn bounds_by_shells(&self, known: &Aabb) -> Option<Aabb> {
        let cube = |k: i32| Aabb::new(DVec3::splat(-(2f64.powi(k))), DVec3::splat(2f64.powi(k)));
        let mut k = FARTHEST;
        while k > NEAREST && self.is_empty_between(&cube(k - 1), &known.intersection(&cube(k))) {
            k -= 1;
        }
        (FARTHEST - k >= SHELLS).then(|| known.intersection(&cube(k)))
    }

    /// Whether nothing is inside in a box and outside of another one.
    fn is_empty_between(&self, inner: &Aabb, outer: &Aabb) -> bool {
        let mut scratch = Scratch::default();
        let mut waiting = vec![(*outer, 0, self.tape.clone())];
        while let Some((cell, level, tape)) = waiting.pop() {
            if cell.is_empty() || (inner.lo.cmple(cell.lo).all() && cell.hi.cmple(inner.hi).all()) {
                continue;
            }
            let tape = match tape.prune(&self.leaves, &cell, &mut scratch) {
                Pruned::Outside => continue,
                Pruned::Inside => return false,
                Pruned::Same => tape,
                Pruned::Smaller(t) => Arc::new(t),
            };
            if level == SHELL_LEVELS || tape.value(&self.leaves, cell.center()) > 0.0 && !inner.contains(cell.center())
            {
                return false;
            }
            waiting.extend(cell.octants().map(|sub| (sub, level + 1, tape.clone())));
        }
        true
    }

    /// The box around the cells of a coarse octree that may hold some of the inside.
    fn tightened(&self, bounds: &Aabb) -> Aabb {
        let mut out = *bounds;
        if bounds.is_empty() {
            return out;
        }
        for axis in 0..3 {
            for high in [false, true] {
                match self.reach(bounds, axis, high) {
                    Some(x) if high => out.hi[axis] = x,
                    Some(x) => out.lo[axis] = x,
                    None => return Aabb::EMPTY,
                }
            }
        }
        out
    }

    /// How far the cells that may hold some of the inside reach along an axis, the outermost looked at first. `None` if there
    /// are none.
    fn reach(&self, bounds: &Aabb, axis: usize, high: bool) -> Option<f64> {
        let outermost = |cell: &Aabb| if high { cell.hi[axis] } else { -cell.lo[axis] };
        let mut scratch = Scratch::default();
        // Some of these would never be asked about, but what waits is asked in one call. Which are halved beforehand does not matter to
        // the outermost one that is the last.
        let ahead = self.leaves.iter().any(Leaf::waits);
        let most = if ahead { AHEAD } else { 1 };
        let first = Waiting { key: outermost(bounds), cell: *bounds, level: 0, tape: self.tape.clone(), pruned: None };
        let mut waiting = BinaryHeap::from([first]);
        while !waiting.is_empty() {
            let some: Vec<Waiting> = std::iter::from_fn(|| waiting.pop()).take(most).collect();
            let mut open = Vec::with_capacity(some.len());
            for Waiting { key, cell, level, tape, pruned } in some {
                let pruned = pruned.unwrap_or_else(|| tape.prune(&self.leaves, &cell, &mut scratch));
                let is_last = level == TIGHTEN_LEVELS || matches!(pruned, Pruned::Inside);
                let tape = match pruned {
                    Pruned::Outside => continue,
                    Pruned::Inside | Pruned::Same => tape,
                    Pruned::Smaller(t) => Arc::new(t),
                };
                match is_last {
                    true if open.is_empty() => return Some(if high { key } else { -key }),
                    true => waiting.push(Waiting { key, cell, level, tape, pruned: Some(Pruned::Inside) }),
                    false => open.extend(cell.octants().map(|part| (part, level + 1, tape.clone()))),
                }
            }
            let known = if ahead {
                let prune = |k: usize| {
                    let (cell, _, tape): &(Aabb, usize, Arc<Tape>) = &open[k];
                    Some(tape.prune(&self.leaves, cell, &mut scratch))
                };
                lockstep::together(open.len(), prune)
            } else {
                open.iter().map(|_| None).collect()
            };
            for ((cell, level, tape), pruned) in open.into_iter().zip(known) {
                waiting.push(Waiting { key: outermost(&cell), cell, level, tape, pruned });
            }
        }
        None
    }

    /// A box around the solid.
    pub fn bounds(&self) -> Aabb {
        self.bounds
    }

    /// The faces a mesh of this solid may have; labels of its triangles are indices into this list.
    pub fn faces(&self) -> &[FaceInfo] {
        &self.faces
    }

    /// The R-system values are taken in.
    pub fn rsystem(&self) -> RSystem {
        self.rsystem
    }

    /// How many different surfaces the tree is made of.
    pub fn leaf_count(&self) -> usize {
        // Leaves for which another stands (see `unified`) are kept, but nothing refers to them.
        let named = self.tape.ops.iter().filter_map(|op| match op {
            Op::Leaf { leaf, .. } => Some(*leaf),
            _ => None,
        });
        named.collect::<BTreeSet<u32>>().len()
    }

    /// Whether some leaf is known point by point only: intervals say nothing of creases inside it.
    pub(crate) fn has_black_boxes(&self) -> bool {
        self.leaves.iter().any(|l| matches!(l, Leaf::Field(..) | Leaf::Blend(_) | Leaf::Fillet(_)))
    }

    /// Whether there are leaves by functions of the user's own, which may have creases that nothing but their values shows.
    pub(crate) fn has_fields(&self) -> bool {
        self.leaves.iter().any(Leaf::has_field)
    }

    /// How many operations the tree has, leaves and R-operations.
    pub fn tree_size(&self) -> usize {
        self.tape.ops.len()
    }

    /// The value of the R-function tree: positive inside, zero on the boundary.
    pub fn value(&self, p: DVec3) -> f64 {
        self.tape.r_value(&self.leaves, self.rsystem, p)
    }

    /// Values of the sign companion, for the bench of the evaluator.
    #[doc(hidden)]
    pub fn companion(&self, x: &[f64], y: &[f64], z: &[f64], out: &mut [f64]) {
        self.tape.eval(&self.leaves, [x, y, z], out, &mut Scratch::default());
    }

    /// Value and gradient of the R-function tree.
    pub fn gradient(&self, p: DVec3) -> (f64, DVec3) {
        let d = self.tape.r_gradient(&self.leaves, self.rsystem, p);
        (d.v, d.g)
    }

    /// Whether a point is inside, by the sign companion.
    pub fn inside(&self, p: DVec3) -> bool {
        self.tape.value(&self.leaves, p) > 0.0
    }
}
