//! From the tree of a solid to signed leaves and one tape.

mod blends;
mod formulas;
mod pairs;
mod smooth;
mod turned;

use std::sync::Arc;

use glam::{DMat3, DVec3};
use rustc_hash::FxHashMap;

use super::expr::Expr;
use super::formula::Formula;
use super::leaf::{Frame, Leaf};
use super::polygon::{EdgeTree, polygon_tree};
use super::shapes::{Scaled, canonical, clean, disk_bounds, ellipsoid, tpms};
use super::solid::{Placement, Primitive, Solid, SolidNode, Tpms};
use super::steps::Within;
use super::tape::{Op, Tape};
use super::turned::{Ring, slab_bounds};
use crate::error::{Error, Place, Result};
use crate::numeric::LAST_PLACES;
use crate::spatial::Aabb;

pub(crate) use formulas::lower;
pub(super) use formulas::lower_within;

/// Nodes visited before a tree is refused: shared subtrees count each time they are met, as each may lie elsewhere.
const MOST_NODES: usize = 4_000_000;

/// The faces of a part: what the mesh's labels refer to.
#[derive(Debug, Clone, PartialEq)]
pub struct FaceInfo {
    /// The name: the primitive's, with the face's own behind a dot where a primitive has several.
    pub name: String,
    /// The mesh size asked for, if any.
    pub size: Option<f64>,
}

/// What lowering makes.
#[derive(Debug, Clone)]
pub(crate) struct Lowered {
    pub(crate) leaves: Vec<Leaf>,
    pub(crate) tape: Tape,
    pub(crate) faces: Vec<FaceInfo>,
    /// A box outside of which there is nothing, as far as the tree's structure tells; may be infinite.
    pub(crate) bounds: Aabb,
    /// Whether some formula has steps that may be taken apart once the part's box is known.
    pub(crate) has_steps: bool,
}

/// A lowered subtree.
#[derive(Clone, Copy)]
struct Part {
    op: u32,
    bounds: Aabb,
}

#[derive(Clone)]
struct Context {
    place: Placement,
    name: Option<Arc<str>>,
    size: Option<f64>,
    negate: bool,
}

enum Work<'a> {
    Visit(&'a Solid, Context),
    Join { and: bool, count: usize },
}

#[derive(Default)]
struct Lowerer {
    leaves: Vec<Leaf>,
    leaf_index: FxHashMap<(u8, i64), Vec<u32>>,
    ops: Vec<Op>,
    op_index: FxHashMap<Op, u32>,
    faces: Vec<FaceInfo>,
    face_index: FxHashMap<String, u32>,
    counts: FxHashMap<&'static str, usize>,
    names: FxHashMap<*const SolidNode, String>,
    blend_depth: usize,
    /// Whether every blend is one leaf.
    one_function: bool,
    visited: usize,
    /// Where steps are taken apart, if that is known.
    within: Option<Within>,
    has_steps: bool,
    /// Whether formulas with steps tell their own bounds though the steps wait to be taken apart.
    trusts: bool,
}

impl Lowerer {
    fn finish(self, root: Part) -> Lowered {
        let has_steps = self.has_steps;
        let tape = extract_tape(&self.ops, root.op);
        Lowered { tape, leaves: self.leaves, faces: self.faces, bounds: root.bounds, has_steps }
    }

    fn tree(&mut self, solid: &Solid, place: Placement) -> Result<Part> {
        self.tree_from(solid, Context { place, name: None, size: None, negate: false })
    }

    fn tree_from(&mut self, solid: &Solid, start: Context) -> Result<Part> {
        let mut work = vec![Work::Visit(solid, start)];
        let mut done: Vec<Part> = Vec::new();
        while let Some(w) = work.pop() {
            self.visited += 1;
            if self.visited > MOST_NODES {
                return Err(Error::input(
                    Place::Unknown,
                    format!("the tree has more than {MOST_NODES} nodes when written out"),
                ));
            }
            match w {
                Work::Join { and, count } => {
                    let parts = done.split_off(done.len() - count);
                    done.push(self.join(and, parts));
                }
                Work::Visit(solid, mut c) => match solid.node() {
                    SolidNode::Primitive(Primitive::Formula(e)) => done.push(self.formula(solid, e, c)?),
                    SolidNode::Primitive(p) => done.push(self.primitive(solid, p, &c)?),
                    SolidNode::And(all) | SolidNode::Or(all) => {
                        let and = matches!(solid.node(), SolidNode::And(_)) != c.negate;
                        work.push(Work::Join { and, count: all.len() });
                        work.extend(all.iter().rev().map(|s| Work::Visit(s, c.clone())));
                    }
                    SolidNode::Not(s) => {
                        c.negate = !c.negate;
                        work.push(Work::Visit(s, c));
                    }
                    SolidNode::Placed(p, s) => {
                        c.place = c.place.after(p);
                        work.push(Work::Visit(s, c));
                    }
                    SolidNode::Named(n, s) => {
                        c.name = Some(n.clone());
                        work.push(Work::Visit(s, c));
                    }
                    SolidNode::Sized(h, s) => {
                        c.size = Some(*h);
                        work.push(Work::Visit(s, c));
                    }
                    SolidNode::Blend(a, b, r) => done.push(self.blend(solid, a, b, *r, &c)?),
                },
            }
        }
        done.pop().ok_or_else(|| Error::Failed("the tree has no root".into()))
    }

    /// Joins parts two by two, so that trees stay shallow.
    fn join(&mut self, and: bool, mut parts: Vec<Part>) -> Part {
        if parts.is_empty() {
            return Part { op: self.op(Op::All(and)), bounds: if and { Aabb::ALL } else { Aabb::EMPTY } };
        }
        while parts.len() > 1 {
            parts = parts
                .chunks(2)
                .map(|pair| match *pair {
                    [a, b] => Part {
                        op: if and { self.min(a.op, b.op) } else { self.max(a.op, b.op) },
                        bounds: if and { a.bounds.intersection(&b.bounds) } else { a.bounds.union(&b.bounds) },
                    },
                    _ => pair[0],
                })
                .collect();
        }
        parts[0]
    }

    fn op(&mut self, op: Op) -> u32 {
        let ops = &mut self.ops;
        *self.op_index.entry(op).or_insert_with(|| {
            ops.push(op);
            (ops.len() - 1) as u32
        })
    }

    fn min(&mut self, a: u32, b: u32) -> u32 {
        match (self.ops[a as usize], self.ops[b as usize]) {
            (Op::All(true), _) | (_, Op::All(false)) => b,
            (_, Op::All(true)) | (Op::All(false), _) => a,
            _ if a == b => a,
            _ => self.op(Op::Min(a, b)),
        }
    }

    fn max(&mut self, a: u32, b: u32) -> u32 {
        match (self.ops[a as usize], self.ops[b as usize]) {
            (Op::All(false), _) | (_, Op::All(true)) => b,
            (_, Op::All(false)) | (Op::All(true), _) => a,
            _ if a == b => a,
            _ => self.op(Op::Max(a, b)),
        }
    }

    /// An occurrence of a leaf, joined with an equal leaf that is already there.
    fn leaf(&mut self, leaf: Leaf, face: u32, negate: bool) -> u32 {
        let (kind, numbers) = leaf.key();
        // a bucket by one number of the right size; neighbors are searched too, so its edges do not matter
        let size = numbers.iter().fold(0.0, |m: f64, v| m.max(v.abs()));
        let mixed: f64 = numbers.iter().enumerate().map(|(i, v)| v * (1.0 + 0.37 * i as f64)).sum();
        let bucket = if size > 0.0 { (mixed / size * 1e9).round() as i64 } else { 0 };
        for near in [bucket, bucket.saturating_sub(1), bucket.saturating_add(1)] {
            for &i in self.leaf_index.get(&(kind, near)).into_iter().flatten() {
                // Leaves whose parameters agree are one leaf: a chain of placements leaves rounding.
                if self.leaves[i as usize].same(&leaf, LAST_PLACES) {
                    return self.op(Op::Leaf { leaf: i, face, negate });
                }
            }
        }
        let i = self.leaves.len() as u32;
        self.leaves.push(leaf);
        self.leaf_index.entry((kind, bucket)).or_default().push(i);
        self.op(Op::Leaf { leaf: i, face, negate })
    }

    /// The name of a solid that has none: its kind and a number.
    fn base_name(&mut self, solid: &Solid, kind: &'static str) -> String {
        let counts = &mut self.counts;
        let make = || {
            let n = counts.entry(kind).or_insert(0);
            *n += 1;
            format!("{kind}{n}")
        };
        self.names.entry(Arc::as_ptr(&solid.0)).or_insert_with(make).clone()
    }

    fn face(&mut self, solid: &Solid, kind: &'static str, sub: &str, c: &Context) -> u32 {
        let base = match &c.name {
            Some(n) => n.to_string(),
            None => self.base_name(solid, kind),
        };
        let name = if sub.is_empty() { base } else { format!("{base}.{sub}") };
        let faces = &mut self.faces;
        let index = *self.face_index.entry(name.clone()).or_insert_with(|| {
            faces.push(FaceInfo { name, size: None });
            (faces.len() - 1) as u32
        });
        if let Some(h) = c.size {
            let f = &mut faces[index as usize];
            f.size = Some(f.size.map_or(h, |old| old.min(h)));
        }
        index
    }

    /// A half-space `normal . p <= d`, normal of any length.
    fn plane(&mut self, normal: DVec3, at: DVec3, face: u32, negate: bool) -> u32 {
        let n = clean(normal.normalize());
        let (m, flip) = canonical(n);
        let d = m.dot(at);
        self.leaf(Leaf::Plane { n: m, d: if d == 0.0 { 0.0 } else { d } }, face, negate != flip)
    }

    fn primitive(&mut self, solid: &Solid, p: &Primitive, c: &Context) -> Result<Part> {
        let place = &c.place;
        let k = place.scale;
        let mut faces: Vec<u32> = Vec::new();
        let (and, bounds);
        macro_rules! face {
            ($kind:expr, $sub:expr) => {
                self.face(solid, $kind, $sub, c)
            };
        }
        match p {
            Primitive::Box { lo, hi } => {
                let tall = lo.z == f64::NEG_INFINITY && hi.z == f64::INFINITY;
                let ends = [*lo, *hi].map(|p| if tall { p.with_z(0.0) } else { p });
                if !(ends.iter().all(|p| p.is_finite()) && lo.cmplt(*hi).all()) {
                    return Err(Error::input(Place::Unknown, format!("a box needs lo < hi, not {lo} and {hi}")));
                }
                for (axis, low, sub) in [
                    (0, true, "xmin"),
                    (0, false, "xmax"),
                    (1, true, "ymin"),
                    (1, false, "ymax"),
                    (2, true, "zmin"),
                    (2, false, "zmax"),
                ] {
                    if tall && axis == 2 {
                        continue;
                    }
                    let n = DVec3::AXES[axis];
                    let f = face!("box", sub);
                    let (n, at) = if low { (-n, ends[0]) } else { (n, ends[1]) };
                    faces.push(self.plane(place.turn(n), place.apply(at), f, c.negate));
                }
                and = true;
                let around = Aabb::around(Aabb::new(ends[0], ends[1]).corners().map(|q| place.apply(q)));
                bounds = if tall { along(around, place.turn(DVec3::Z)) } else { around };
            }
            Primitive::Sphere { r, at } => {
                positive("the radius of a sphere", *r)?;
                let (center, r) = (place.apply(*at), r * k);
                let f = face!("sphere", "");
                faces.push(self.leaf(Leaf::Sphere { c: center, r }, f, c.negate));
                and = true;
                bounds = Aabb::new(center - r, center + r);
            }
            Primitive::Ellipsoid { radii, at } => {
                for i in 0..3 {
                    positive("a radius of an ellipsoid", radii[i])?;
                }
                let f = face!("ellipsoid", "");
                let Scaled { value, sign } = ellipsoid(*radii, *at);
                let formula = Formula::compile(&value, place).with_sign_of(Formula::compile(&sign, place));
                faces.push(self.leaf(Leaf::Formula(formula), f, c.negate));
                and = true;
                let reach = place.rotation * DMat3::from_diagonal(*radii * k);
                let half = DVec3::from_array(std::array::from_fn(|i| reach.row(i).length()));
                let center = place.apply(*at);
                bounds = Aabb::new(center - half, center + half);
            }
            Primitive::Cylinder { r, axis, at, height } => {
                positive("the radius of a cylinder", *r)?;
                let a = direction(place.turn(*axis), "the axis of a cylinder")?;
                let center = place.apply(*at);
                let f = face!("cylinder", if height.is_some() { "side" } else { "" });
                let axis_origin = if height.is_some() { center } else { center - a * a.dot(center) };
                faces.push(self.cylinder(axis_origin, a, r * k, f, c.negate));
                and = true;
                bounds = match height {
                    Some(h) => {
                        positive("the height of a cylinder", *h)?;
                        let half = a * (0.5 * h * k);
                        for (sub, s) in [("bottom", -1.0), ("top", 1.0)] {
                            let f = face!("cylinder", sub);
                            faces.push(self.plane(a * s, center + half * s, f, c.negate));
                        }
                        disk_bounds(center - half, a, r * k).union(&disk_bounds(center + half, a, r * k))
                    }
                    None => {
                        let disk = disk_bounds(center, a, r * k);
                        along(disk, a)
                    }
                };
            }
            Primitive::Cone { r0, r1, height, axis, at } => {
                if !(*r0 >= 0.0 && *r1 >= 0.0 && r0.max(*r1) > 0.0 && r0.is_finite() && r1.is_finite()) {
                    return Err(Error::input(
                        Place::Unknown,
                        format!("a cone needs radii >= 0, one of them positive, not {r0} and {r1}"),
                    ));
                }
                positive("the height of a cone", *height)?;
                let a = direction(place.turn(*axis), "the axis of a cone")?;
                let center = place.apply(*at);
                let half = a * (0.5 * height * k);
                let f = face!("cone", "side");
                let line = [[*r0 * k, -0.5 * height * k], [(*r1 - *r0) * k, height * k]];
                faces.push(self.turned(center, a, line, f, c.negate));
                for (sub, s, r) in [("bottom", -1.0, *r0), ("top", 1.0, *r1)] {
                    let f = face!("cone", sub);
                    if r > 0.0 {
                        faces.push(self.plane(a * s, center + half * s, f, c.negate));
                    }
                }
                and = true;
                bounds = disk_bounds(center - half, a, r0 * k).union(&disk_bounds(center + half, a, r1 * k));
            }
            Primitive::Torus { major, minor, axis, at } => {
                positive("the radius R of a torus", *major)?;
                positive("the radius r of a torus", *minor)?;
                let a = direction(place.turn(*axis), "the axis of a torus")?;
                let center = place.apply(*at);
                let f = face!("torus", "");
                let frame = Frame::about(canonical(a).0);
                faces.push(self.leaf(
                    Leaf::Torus { c: center, frame, major: major * k, minor: minor * k },
                    f,
                    c.negate,
                ));
                and = true;
                bounds = disk_bounds(center, a, major * k).grown(minor * k);
            }
            Primitive::HalfSpace { normal, at } => {
                let n = direction(place.turn(*normal), "the normal of a half-space")?;
                let at = place.apply(*at);
                let f = face!("half_space", "");
                faces.push(self.plane(n, at, f, c.negate));
                and = true;
                let mut b = Aabb::ALL;
                for i in 0..3 {
                    if clean(n).abs() == DVec3::AXES[i] {
                        if n[i] > 0.0 { b.hi[i] = at[i] } else { b.lo[i] = at[i] }
                    }
                }
                bounds = b;
            }
            Primitive::Tpms { kind, period, thickness, at } => {
                positive("the period", *period)?;
                positive("the thickness", *thickness)?;
                let g = tpms(*kind, *period, *at);
                let name = match kind {
                    Tpms::Gyroid => "gyroid",
                    Tpms::SchwarzP => "schwarz_p",
                    Tpms::Diamond => "diamond",
                };
                for (sub, g) in [("plus", Expr::constant(0.5 * thickness) - g.clone()), ("minus", g + 0.5 * *thickness)]
                {
                    let f = face!(name, sub);
                    faces.push(self.leaf(Leaf::Formula(Formula::compile(&g, place)), f, c.negate));
                }
                and = true;
                bounds = Aabb::ALL;
            }
            Primitive::Extrude { polygon, height, at } => {
                let tall = *height == f64::INFINITY;
                let height = if tall { 0.0 } else { *height };
                if !tall {
                    positive("the height of an extrusion", height)?;
                }
                let (corners, tree) = polygon_tree(polygon)?;
                let n = corners.len();
                let mut edges = Vec::with_capacity(n);
                for i in 0..n {
                    let (p, q) = (corners[i], corners[(i + 1) % n]);
                    let f = face!("extrude", &format!("side{}", original_edge(polygon, p, q)));
                    let normal = DVec3::new(q[1] - p[1], p[0] - q[0], 0.0);
                    let on = DVec3::new(p[0], p[1], 0.0) + *at;
                    edges.push(self.plane(place.turn(normal), place.apply(on), f, c.negate));
                }
                faces.push(self.edge_tree(&tree, &edges, c.negate));
                let caps = [("bottom", -1.0), ("top", 1.0)];
                for (sub, s) in caps.into_iter().filter(|_| !tall) {
                    let f = face!("extrude", sub);
                    let on = *at + DVec3::Z * (0.5 * s * height);
                    faces.push(self.plane(place.turn(DVec3::Z * s), place.apply(on), f, c.negate));
                }
                and = true;
                let around = Aabb::around(
                    corners
                        .iter()
                        .flat_map(|p| [-0.5, 0.5].map(|s| place.apply(*at + DVec3::new(p[0], p[1], s * height)))),
                );
                bounds = if tall { along(around, place.turn(DVec3::Z)) } else { around };
            }
            Primitive::Revolve { polygon } => {
                if let Some(i) = polygon.iter().position(|p| !(p[0] >= 0.0)) {
                    return Err(Error::input(
                        Place::Unknown,
                        format!("corner {i} of the turned polygon has a negative radius"),
                    ));
                }
                let part = self.revolve(solid, "revolve", Ring::numbered(polygon.clone()), c)?;
                faces.push(part.op);
                and = true;
                bounds = part.bounds;
            }
            Primitive::Turned(turned) => {
                let part = self.turn(turned, c)?;
                faces.push(part.op);
                and = true;
                bounds = part.bounds;
            }
            Primitive::Slab { height, around } => {
                positive("the height of an extrusion", *height)?;
                let half = 0.5 * height;
                let mut b = Aabb::ALL;
                for (sub, s) in [("bottom", -1.0), ("top", 1.0)] {
                    let f = face!("extrude", sub);
                    let (n, at) = (clean(place.turn(DVec3::Z * s)), place.apply(DVec3::Z * (s * half)));
                    faces.push(self.plane(n, at, f, c.negate));
                    for i in 0..3 {
                        if n.abs() == DVec3::AXES[i] {
                            if n[i] > 0.0 { b.hi[i] = at[i] } else { b.lo[i] = at[i] }
                        }
                    }
                }
                and = true;
                bounds = slab_bounds(around, half, place).unwrap_or(b);
            }
            Primitive::Formula(e) => {
                let f = face!("formula", "");
                let part = self.whole_formula(e, f, c);
                faces.push(part.op);
                and = true;
                bounds = part.bounds;
            }
            Primitive::Smooth(smooth) => {
                let f = face!("formula", "");
                let Some(part) = self.smooth(smooth, f, c) else {
                    return self.primitive(solid, &Primitive::Formula(smooth.whole.clone()), c);
                };
                faces.push(part.op);
                and = true;
                bounds = part.bounds;
            }
            Primitive::Foreign(foreign) => {
                return Err(foreign.refused("has no function, which is asked for here"));
            }
            Primitive::Field(field) => {
                let f = face!("field", "");
                faces.push(self.leaf(Leaf::Field(field.clone(), *place), f, c.negate));
                and = true;
                bounds = Aabb::ALL;
            }
        }
        let parts = faces.into_iter().map(|op| Part { op, bounds: Aabb::ALL }).collect();
        let joined = self.join(and != c.negate, parts);
        Ok(Part { op: joined.op, bounds: if c.negate { Aabb::ALL } else { bounds } })
    }

    fn edge_tree(&mut self, tree: &EdgeTree, edges: &[u32], negate: bool) -> u32 {
        match tree {
            EdgeTree::Edge(i) => edges[*i],
            EdgeTree::And(a, b) | EdgeTree::Or(a, b) => {
                let and = matches!(tree, EdgeTree::And(..)) != negate;
                let (a, b) = (self.edge_tree(a, edges, negate), self.edge_tree(b, edges, negate));
                if and { self.min(a, b) } else { self.max(a, b) }
            }
        }
    }

    fn cylinder(&mut self, at: DVec3, a: DVec3, r: f64, face: u32, negate: bool) -> u32 {
        let a = canonical(clean(a)).0;
        // any point of the axis names it; the one nearest the origin is canonical
        let c = at - a * a.dot(at);
        self.leaf(Leaf::Cylinder { c, frame: Frame::about(a), r }, face, negate)
    }
}

/// The tape with other leaves, joined anew where that makes operations equal.
pub(super) fn replayed(ops: &[Op], leaf: impl Fn(Op) -> Op) -> Tape {
    let mut l = Lowerer::default();
    let mut new: Vec<u32> = Vec::with_capacity(ops.len());
    for &op in ops {
        new.push(match op {
            Op::Min(a, b) => l.min(new[a as usize], new[b as usize]),
            Op::Max(a, b) => l.max(new[a as usize], new[b as usize]),
            op => l.op(leaf(op)),
        });
    }
    extract_tape(&l.ops, new.last().copied().unwrap_or(0))
}

/// The operations the root needs, in order.
fn extract_tape(ops: &[Op], root: u32) -> Tape {
    let mut new = vec![u32::MAX; root as usize + 1];
    new[root as usize] = 0;
    for i in (0..=root as usize).rev() {
        if new[i] != u32::MAX
            && let Op::Min(a, b) | Op::Max(a, b) = ops[i]
        {
            new[a as usize] = 0;
            new[b as usize] = 0;
        }
    }
    let mut out = Vec::new();
    for i in 0..=root as usize {
        if new[i] == u32::MAX {
            continue;
        }
        out.push(match ops[i] {
            Op::Min(a, b) => Op::Min(new[a as usize], new[b as usize]),
            Op::Max(a, b) => Op::Max(new[a as usize], new[b as usize]),
            other => other,
        });
        new[i] = out.len() as u32 - 1;
    }
    Tape { ops: out }
}

/// A box that goes on without end along an axis.
fn along(b: Aabb, axis: DVec3) -> Aabb {
    let free = clean(axis).abs().cmpgt(DVec3::ZERO);
    Aabb::new(DVec3::select(free, DVec3::NEG_INFINITY, b.lo), DVec3::select(free, DVec3::INFINITY, b.hi))
}

fn direction(v: DVec3, what: &str) -> Result<DVec3> {
    v.try_normalize().map(clean).filter(|d| d.is_finite()).ok_or_else(|| {
        Error::input(Place::Unknown, format!("{what} must be a finite vector that is not zero, not {v}"))
    })
}

fn positive(what: &str, v: f64) -> Result<()> {
    if v > 0.0 && v.is_finite() {
        Ok(())
    } else {
        Err(Error::input(Place::Unknown, format!("{what} must be positive, not {v}")))
    }
}

/// The number of the edge as the user listed the corners, either way round.
fn original_edge(polygon: &[[f64; 2]], p: [f64; 2], q: [f64; 2]) -> usize {
    let n = polygon.len();
    (0..n)
        .find(|&i| {
            let (a, b) = (polygon[i], polygon[(i + 1) % n]);
            (a == p && b == q) || (a == q && b == p)
        })
        .unwrap_or(0)
}
