//! A corner-table mesh that can be edited: flips, splits, collapses, with a face label and a surface normal carried by
//! each triangle and a sharpness flag by each edge.
//!
//! ```text
//!           c                half-edge 3t+k runs from corner k to corner k+1 of triangle t:
//!          / \               3t = a->b, 3t+1 = b->c, 3t+2 = c->a; seen from outside the triangle lies to its left.
//!         / t \              opposite(3t) is b->a in the neighbor, NONE on a boundary.
//!        a-----b             The apex of half-edge a->b is c.
//! ```
//!
//! *Guarantees*: a mesh that was an oriented 2-manifold (with or without boundary) stays one under every edit; an edit
//! that would break it returns `false` and changes nothing. Ids of living nodes and triangles never change.
//! *Does not guarantee*: anything about geometry. Whether an edit folds the surface is the caller's question.
//!
//! The link condition of collapses is that of T. Dey, H. Edelsbrunner et al., "Topology preserving edge contraction"
//! (1999), for surfaces.

mod changes;
mod opposites;
mod part;
mod store;

pub use changes::ChangeReader;
pub use part::{PartMesh, Regions};

use glam::DVec3;

use super::{Group, TriMesh};
use crate::error::{Error, Place, Result};
pub use crate::numeric::NONE;

/// The half-edge that follows `h` around its triangle.
pub fn next(h: u32) -> u32 {
    if h % 3 == 2 { h - 2 } else { h + 1 }
}

/// The half-edge that precedes `h` around its triangle.
pub fn prev(h: u32) -> u32 {
    if h.is_multiple_of(3) { h + 2 } else { h - 1 }
}

/// An oriented 2-manifold triangle mesh under edit. See the module's head for numbering and guarantees.
#[derive(Debug, Clone)]
pub struct EditMesh {
    points: Vec<DVec3>,
    corners: Vec<u32>,
    opposite: Vec<u32>,
    sharp: Vec<bool>,
    /// One outgoing half-edge per node: on a boundary node the one without opposite. NONE for a dead node.
    out: Vec<u32>,
    pinned: Vec<bool>,
    /// Which readers have not seen what changed around the node, one bit for each.
    changed: Vec<u8>,
    labels: Vec<u32>,
    normals: Vec<DVec3>,
    faces: Vec<String>,
    groups: Vec<Group>,
    dead_triangles: usize,
}

impl EditMesh {
    /// Reads a mesh. Fails with [`Error::Input`], naming the place, when an index is out of range, a triangle repeats a
    /// node, an edge is used twice in one direction, or the triangles around a node form more than one fan.
    pub fn new(mesh: &TriMesh) -> Result<Self> {
        let nodes = mesh.nodes.len();
        if mesh.triangles.len() >= (NONE / 3) as usize || nodes >= NONE as usize {
            return Err(Error::input(Place::Unknown, "the mesh has too many triangles for 32-bit ids"));
        }
        let mut this = Self {
            points: mesh.nodes.clone(),
            corners: mesh.triangles.iter().flatten().copied().collect(),
            opposite: vec![NONE; 3 * mesh.triangles.len()],
            sharp: vec![false; 3 * mesh.triangles.len()],
            out: vec![NONE; nodes],
            pinned: vec![false; nodes],
            changed: vec![u8::MAX; nodes],
            labels: mesh.labels.clone(),
            normals: vec![DVec3::ZERO; mesh.triangles.len()],
            faces: mesh.faces.clone(),
            groups: mesh.groups.clone(),
            dead_triangles: 0,
        };
        this.labels.resize(mesh.triangles.len(), 0);
        for t in 0..mesh.triangles.len() {
            let [a, b, c] = mesh.triangles[t];
            let place = || Place::Item(format!("triangle {t}"));
            if [a, b, c].iter().any(|&v| v as usize >= nodes) {
                return Err(Error::input(place(), "a node index is out of range"));
            }
            if a == b || b == c || c == a {
                return Err(Error::input(place(), "a node is used twice"));
            }
        }
        this.match_opposites()?;
        let mut corners_at = vec![0u32; nodes];
        this.corners.iter().for_each(|&v| corners_at[v as usize] += 1);
        for v in 0..nodes as u32 {
            if this.out[v as usize] != NONE && this.outgoing(v).count() != corners_at[v as usize] as usize {
                let message = "the triangles around the node form more than one fan: not a manifold";
                return Err(Error::input(Place::Item(format!("node {v}")), message));
            }
        }
        Ok(this)
    }

    /// One more than the largest node id ever used; dead nodes count.
    pub fn node_capacity(&self) -> usize {
        self.points.len()
    }

    /// One more than the largest triangle id ever used; dead triangles count.
    pub fn triangle_capacity(&self) -> usize {
        self.labels.len()
    }

    /// How many triangles live.
    pub fn triangle_count(&self) -> usize {
        self.labels.len() - self.dead_triangles
    }

    /// Ids of the living nodes that some triangle uses.
    pub fn nodes(&self) -> impl Iterator<Item = u32> + '_ {
        (0..self.points.len() as u32).filter(|&v| self.out[v as usize] != NONE)
    }

    /// Ids of the living triangles.
    pub fn triangles(&self) -> impl Iterator<Item = u32> + '_ {
        (0..self.labels.len() as u32).filter(|&t| self.is_triangle(t))
    }

    /// Whether the triangle lives.
    pub fn is_triangle(&self, t: u32) -> bool {
        self.corners[3 * t as usize] != NONE
    }

    /// Whether some triangle uses the node.
    pub fn is_node(&self, v: u32) -> bool {
        self.out[v as usize] != NONE
    }

    /// Where the node is.
    pub fn point(&self, v: u32) -> DVec3 {
        self.points[v as usize]
    }

    /// Puts the node elsewhere.
    pub fn set_point(&mut self, v: u32, p: DVec3) {
        self.points[v as usize] = p;
        self.changed[v as usize] = u8::MAX;
    }

    /// Whether the node must stay where it is and must not be collapsed away.
    pub fn is_pinned(&self, v: u32) -> bool {
        self.pinned[v as usize]
    }

    /// Pins or frees the node.
    pub fn set_pinned(&mut self, v: u32, pinned: bool) {
        self.pinned[v as usize] = pinned;
    }

    /// Whether both ends of the edge are pinned: such an edge is neither flipped nor split by the operators.
    pub fn is_pinned_edge(&self, h: u32) -> bool {
        self.is_pinned(self.origin(h)) && self.is_pinned(self.target(h))
    }

    /// The node a half-edge starts at.
    pub fn origin(&self, h: u32) -> u32 {
        self.corners[h as usize]
    }

    /// The node a half-edge ends at.
    pub fn target(&self, h: u32) -> u32 {
        self.corners[next(h) as usize]
    }

    /// The third node of the half-edge's triangle.
    pub fn apex(&self, h: u32) -> u32 {
        self.corners[prev(h) as usize]
    }

    /// The same edge seen from the other triangle, NONE on a boundary.
    pub fn opposite(&self, h: u32) -> u32 {
        self.opposite[h as usize]
    }

    /// Whether the edge is marked sharp.
    pub fn is_sharp(&self, h: u32) -> bool {
        self.sharp[h as usize]
    }

    /// Marks the edge, on both sides.
    pub fn set_sharp(&mut self, h: u32, sharp: bool) {
        self.sharp[h as usize] = sharp;
        let o = self.opposite[h as usize];
        if o != NONE {
            self.sharp[o as usize] = sharp;
        }
    }

    /// Whether the edge is a feature: marked sharp or on a boundary.
    pub fn is_feature(&self, h: u32) -> bool {
        self.sharp[h as usize] || self.opposite[h as usize] == NONE
    }

    /// Node ids of a triangle.
    pub fn corners(&self, t: u32) -> [u32; 3] {
        let k = 3 * t as usize;
        [self.corners[k], self.corners[k + 1], self.corners[k + 2]]
    }

    /// Corner points of a triangle.
    pub fn corner_points(&self, t: u32) -> [DVec3; 3] {
        self.corners(t).map(|v| self.points[v as usize])
    }

    /// Centroid of a triangle.
    pub fn centroid(&self, t: u32) -> DVec3 {
        let [a, b, c] = self.corner_points(t);
        (a + b + c) / 3.0
    }

    /// Twice the area vector of a triangle.
    pub fn area_vector(&self, t: u32) -> DVec3 {
        let [a, b, c] = self.corner_points(t);
        (b - a).cross(c - a)
    }

    /// Index of the face the triangle lies on.
    pub fn label(&self, t: u32) -> u32 {
        self.labels[t as usize]
    }

    /// Outward unit normal of the surface under the triangle, as last asked of the oracle; zero if it never was.
    pub fn normal(&self, t: u32) -> DVec3 {
        self.normals[t as usize]
    }

    /// Records what lies under the triangle.
    pub fn set_surface(&mut self, t: u32, label: u32, normal: DVec3) {
        self.labels[t as usize] = label;
        self.normals[t as usize] = normal;
    }

    /// The half-edges that start at a node, counter-clockwise. On a boundary node the first has no opposite.
    pub fn outgoing(&self, v: u32) -> Outgoing<'_> {
        let first = self.out[v as usize];
        Outgoing { mesh: self, first, at: first }
    }

    /// Whether the node lies on a boundary.
    pub fn is_boundary(&self, v: u32) -> bool {
        let h = self.out[v as usize];
        h != NONE && self.opposite[h as usize] == NONE
    }

    /// The nodes joined to `v` by an edge, counter-clockwise.
    pub fn neighbors(&self, v: u32) -> impl Iterator<Item = u32> + '_ {
        let mut last = NONE;
        self.outgoing(v).flat_map(move |h| {
            // Around a boundary node the last triangle's far edge has no outgoing half-edge of its own.
            if self.opposite[prev(h) as usize] == NONE {
                last = self.apex(h);
            }
            [Some(self.target(h)), Some(last).filter(|&x| x != NONE)].into_iter().flatten()
        })
    }

    /// The nodes joined to `v` by a sharp edge.
    pub fn sharp_neighbors(&self, v: u32) -> impl Iterator<Item = u32> + '_ {
        // The last edge of a boundary node runs towards it.
        let last = self.outgoing(v).last().map(prev).filter(|&h| self.opposite(h) == NONE && self.is_sharp(h));
        self.outgoing(v).filter(|&h| self.is_sharp(h)).map(|h| self.target(h)).chain(last.map(|h| self.origin(h)))
    }

    /// How many nodes are joined to `v`.
    pub fn valence(&self, v: u32) -> usize {
        self.outgoing(v).count() + usize::from(self.is_boundary(v))
    }

    /// The half-edge from `a` to `b`, or the one from `b` to `a` when only that exists; `None` when they are not joined.
    pub fn edge_between(&self, a: u32, b: u32) -> Option<u32> {
        let forward = self.outgoing(a).find(|&h| self.target(h) == b);
        forward.or_else(|| self.outgoing(a).map(prev).find(|&h| self.origin(h) == b))
    }

    /// Ids of one half-edge per living edge: the smaller of the two.
    pub fn edges(&self) -> impl Iterator<Item = u32> + '_ {
        (0..self.corners.len() as u32).filter(|&h| self.is_edge(h))
    }

    /// Whether `h` lives and is the half-edge that stands for its edge in [`edges`](Self::edges).
    pub fn is_edge(&self, h: u32) -> bool {
        self.corners[h as usize] != NONE && h < self.opposite[h as usize]
    }

    /// Length of an edge.
    pub fn edge_length(&self, h: u32) -> f64 {
        self.point(self.origin(h)).distance(self.point(self.target(h)))
    }

    fn join(&mut self, h: u32, o: u32) {
        if h != NONE {
            self.opposite[h as usize] = o;
        }
        if o != NONE {
            self.opposite[o as usize] = h;
        }
    }

    /// Makes `h` (outgoing) the entry of its origin, turned clockwise to the boundary if there is one.
    fn enter(&mut self, h: u32) {
        let v = self.origin(h) as usize;
        self.out[v] = self.first_of_fan(h);
    }

    /// Whether [`flip`](Self::flip) would succeed.
    pub fn can_flip(&self, h: u32) -> bool {
        let o = self.opposite[h as usize];
        if o == NONE || self.sharp[h as usize] {
            return false;
        }
        let (c, d) = (self.apex(h), self.apex(o));
        c != d && self.edge_between(c, d).is_none()
    }

    /// Replaces the edge between two triangles by the other diagonal. Refused on boundary and sharp edges,
    /// and where the diagonal exists already. Both triangles keep their ids; `h` afterwards is an edge of the new pair's rim.
    pub fn flip(&mut self, h: u32) -> bool {
        if !self.can_flip(h) {
            return false;
        }
        let o = self.opposite[h as usize];
        let (a, b, c, d) = (self.origin(h), self.target(h), self.apex(h), self.apex(o));
        let rim = [next(o), prev(h), prev(o), next(h)].map(|r| (self.opposite[r as usize], self.sharp[r as usize]));
        let (t0, t1) = (h - h % 3, o - o % 3);
        self.write(t0, [a, d, c]);
        self.write(t1, [d, b, c]);
        self.sharp[t0 as usize + 1] = false;
        self.sharp[t1 as usize + 2] = false;
        self.join(t0 + 1, t1 + 2);
        for (slot, (opposite, sharp)) in [t0, t0 + 2, t1, t1 + 1].into_iter().zip(rim) {
            self.join(slot, opposite);
            self.sharp[slot as usize] = sharp;
        }
        for slot in [t0, t1 + 1, t0 + 2, t1] {
            self.enter(slot);
        }
        self.note([a, b, c, d]);
        true
    }

    fn write(&mut self, first: u32, nodes: [u32; 3]) {
        let k = first as usize;
        self.corners[k..k + 3].copy_from_slice(&nodes);
    }

    fn add_triangle(&mut self, like: u32, nodes: [u32; 3]) -> u32 {
        let first = self.corners.len() as u32;
        self.corners.extend(nodes);
        self.opposite.extend([NONE; 3]);
        self.sharp.extend([false; 3]);
        self.labels.push(self.labels[like as usize]);
        self.normals.push(self.normals[like as usize]);
        first
    }

    fn add_node(&mut self, p: DVec3) -> u32 {
        self.points.push(p);
        self.out.push(NONE);
        self.pinned.push(false);
        self.changed.push(u8::MAX);
        self.points.len() as u32 - 1
    }

    /// Puts a new node at `p` into the edge; both its triangles are halved, and the halves of the edge keep its mark.
    /// The new node's id is returned. Half-edge `h` afterwards runs from its old origin to the new node.
    pub fn split_edge(&mut self, h: u32, p: DVec3) -> u32 {
        let m = self.add_node(p);
        let o = self.opposite[h as usize];
        let far = self.halve(h, m);
        if o == NONE {
            self.join(far, NONE);
        } else {
            let back = self.halve(o, m);
            self.join(h, back);
            self.join(far, o);
        }
        for x in [h, far] {
            for side in [x, self.opposite[x as usize]] {
                if side != NONE {
                    for e in [side, next(side), prev(side)] {
                        self.enter(e);
                    }
                }
            }
        }
        m
    }

    /// Cuts the triangle of `h` = a->b from `m` to its apex: it becomes (a, m, c), the returned half-edge is m->b.
    fn halve(&mut self, h: u32, m: u32) -> u32 {
        let (b, c) = (self.target(h), self.apex(h));
        self.note([self.origin(h), b, c]);
        let far = self.add_triangle(h / 3, [m, b, c]);
        let (outer, mark) = (self.opposite[next(h) as usize], self.sharp[next(h) as usize]);
        self.join(far + 1, outer);
        self.sharp[far as usize + 1] = mark;
        self.sharp[far as usize] = self.sharp[h as usize];
        self.corners[next(h) as usize] = m;
        self.sharp[next(h) as usize] = false;
        self.join(next(h), far + 2);
        far
    }

    /// Puts a new node at `p` into the triangle, which becomes three. The new node's id is returned.
    pub fn split_triangle(&mut self, t: u32, p: DVec3) -> u32 {
        let [a, b, c] = self.corners(t);
        self.note([a, b, c]);
        let m = self.add_node(p);
        let first = 3 * t;
        let rim = [first + 1, first + 2].map(|h| (self.opposite[h as usize], self.sharp[h as usize]));
        let u = self.add_triangle(t, [b, c, m]);
        let w = self.add_triangle(t, [c, a, m]);
        self.write(first, [a, b, m]);
        for (slot, (outer, mark)) in [u, w].into_iter().zip(rim) {
            self.join(slot, outer);
            self.sharp[slot as usize] = mark;
        }
        self.sharp[first as usize + 1] = false;
        self.sharp[first as usize + 2] = false;
        self.join(first + 1, u + 2);
        self.join(u + 1, w + 2);
        self.join(w + 1, first + 2);
        for h in [first, u, w, first + 2] {
            self.enter(h);
        }
        m
    }

    /// Whether [`collapse`](Self::collapse) would succeed: the link condition, and no feature would be torn or doubled.
    pub fn can_collapse(&self, h: u32) -> bool {
        let torn = |side: u32| side != NONE && self.sharp[next(side) as usize] && self.sharp[prev(side) as usize];
        !torn(h) && !torn(self.opposite[h as usize]) && self.can_merge(h)
    }

    /// Whether [`merge`](Self::merge) would succeed: the link condition alone.
    pub fn can_merge(&self, h: u32) -> bool {
        let o = self.opposite[h as usize];
        let (a, b) = (self.origin(h), self.target(h));
        if self.pinned[a as usize] {
            return false;
        }
        let (c, d) = (self.apex(h), if o == NONE { NONE } else { self.apex(o) });
        if c == d || (o != NONE && self.is_boundary(a) && self.is_boundary(b)) {
            return false;
        }
        // A rim of three edges would fold into two.
        for (apex, side) in [(c, h), (d, o)] {
            if apex == NONE {
                continue;
            }
            let (e, f) = (self.opposite[next(side) as usize], self.opposite[prev(side) as usize]);
            if e == NONE && f == NONE {
                return false;
            }
            if !self.is_boundary(apex) && self.valence(apex) <= 3 {
                return false;
            }
        }
        // Link condition: the ends share exactly the apexes.
        let mut around = [NONE; 32];
        let mut count = 0;
        for x in self.neighbors(b) {
            if count < around.len() {
                around[count] = x;
            }
            count += 1;
        }
        let joined = |x: u32| match around.get(..count) {
            Some(around) => around.contains(&x),
            None => self.edge_between(x, b).is_some(),
        };
        self.neighbors(a).all(|x| x == b || x == c || x == d || !joined(x))
    }

    /// Merges the half-edge's origin into its target, which moves to `p`; the edge's two triangles die, and the rim edges
    /// that fall together stay sharp if one of them was. Refused when [`can_collapse`](Self::can_collapse) says no.
    pub fn collapse(&mut self, h: u32, p: DVec3) -> bool {
        self.can_collapse(h) && self.merge(h, p)
    }

    /// Like [`collapse`](Self::collapse), but two features may fall together: for edges of no length.
    pub fn merge(&mut self, h: u32, p: DVec3) -> bool {
        if !self.can_merge(h) {
            return false;
        }
        let o = self.opposite[h as usize];
        let (a, b) = (self.origin(h), self.target(h));
        let around: Vec<u32> = self.outgoing(a).collect();
        for &x in &around {
            self.note([self.target(x), self.apex(x)]);
        }
        for x in around {
            self.corners[x as usize] = b;
        }
        self.out[a as usize] = NONE;
        let mut live = Vec::with_capacity(4);
        for side in [h, o] {
            if side == NONE {
                continue;
            }
            let (x, y) = (next(side), prev(side));
            let (ox, oy) = (self.opposite[x as usize], self.opposite[y as usize]);
            let mark = self.sharp[x as usize] || self.sharp[y as usize];
            self.join(ox, oy);
            if ox == NONE {
                self.join(oy, NONE);
            }
            for e in [ox, oy] {
                if e != NONE {
                    self.sharp[e as usize] = mark;
                    live.extend([e, next(e)]);
                }
            }
        }
        for side in [h, o] {
            if side != NONE {
                let first = (side - side % 3) as usize;
                self.corners[first..first + 3].fill(NONE);
                self.opposite[first..first + 3].fill(NONE);
                self.dead_triangles += 1;
            }
        }
        for e in live {
            if self.corners[e as usize] != NONE {
                self.enter(e);
            }
        }
        self.set_point(b, p);
        true
    }
}

/// See [`EditMesh::outgoing`].
#[derive(Debug, Clone)]
pub struct Outgoing<'a> {
    mesh: &'a EditMesh,
    first: u32,
    at: u32,
}

impl Iterator for Outgoing<'_> {
    type Item = u32;

    fn next(&mut self) -> Option<u32> {
        let h = self.at;
        if h == NONE {
            return None;
        }
        let o = self.mesh.opposite[prev(h) as usize];
        self.at = if o == self.first { NONE } else { o };
        Some(h)
    }
}

#[cfg(test)]
mod tests;
