//! Corners at one place are one node, where more than three pieces meet in a point and each three of them made one; and borders that go
//! back on themselves are put straight.

use super::joints::Pieced;
use super::patchwork::PieceSet;
use crate::mesh::EditMesh;
use crate::numeric::ROUNDING;

/// Corners at one place are looked for along so many edges of the border between them.
const STEPS: usize = 6;

impl Pieced<'_> {
    /// Makes one node of corners at one place, and of what is between them, on the pieces of all, where the mesh stays a manifold.
    pub(super) fn join_corners(&mut self) {
        let corner = |v: &u32| self.sets[*v as usize].len() > 2 && !self.stays(*v);
        let mut corners: Vec<u32> = self.mesh.nodes().filter(corner).collect();
        let x = |m: &EditMesh, v: u32| m.point(v).x;
        corners.sort_by(|a, b| x(self.mesh, *a).total_cmp(&x(self.mesh, *b)).then(a.cmp(b)));
        for (k, &a) in corners.iter().enumerate() {
            for &b in &corners[k + 1..] {
                // Nodes that lie on pieces to rounding are at one place when they are this near to each other: cells are far larger.
                if !self.mesh.is_node(a) || x(self.mesh, b) - x(self.mesh, a) > ROUNDING * self.cell {
                    break;
                }
                if self.mesh.is_node(b) && self.mesh.point(a).distance(self.mesh.point(b)) <= ROUNDING * self.cell {
                    self.join(a, b);
                }
            }
        }
    }

    /// Draws what is between two corners into the first, then the second one.
    fn join(&mut self, a: u32, b: u32) {
        let p = self.mesh.point(a);
        while let Some(between) = self.way(a, b) {
            for v in between {
                let Some(h) = self.mesh.outgoing(v).find(|h| self.mesh.target(*h) == a) else { return };
                if !self.mesh.merge(h, p) {
                    return;
                }
            }
        }
        let all = self.sets[a as usize].union(&self.sets[b as usize]);
        if let Some(h) = self.mesh.outgoing(b).find(|h| self.mesh.target(*h) == a)
            && self.mesh.merge(h, p)
        {
            self.sets[a as usize] = all;
        }
    }

    /// The nodes between two corners: one beside both, on no other pieces, where an edge passes them; else those along the border, if it
    /// leads from one to the other in a few steps.
    fn way(&self, a: u32, b: u32) -> Option<Vec<u32>> {
        let all = self.sets[a as usize].union(&self.sets[b as usize]);
        if self.mesh.edge_between(a, b).is_none() {
            let m = &self.mesh;
            let away = |v: u32| m.point(v).distance_squared(m.point(a));
            let lies =
                |v: &u32| self.sets[*v as usize].len() == 2 && self.sets[*v as usize].within(&all) && !self.stays(*v);
            let beside = m.neighbors(a).filter(lies).filter(|v| m.edge_between(*v, b).is_some());
            if let Some(v) = beside.min_by(|x, y| away(*x).total_cmp(&away(*y)).then(x.cmp(y))) {
                return Some(vec![v]);
            }
        }
        let m = &self.mesh;
        let next = |from: u32, before: u32| {
            let lies = |v: u32| self.sets[v as usize].len() == 2 && !self.stays(v);
            m.outgoing(from)
                .filter(|h| self.is_border(*h))
                .map(|h| m.target(h))
                .find(|v| *v != before && (*v == b || lies(*v)))
        };
        m.outgoing(a).filter(|h| self.is_border(*h)).map(|h| m.target(h)).find_map(|first| {
            if first == b || self.sets[first as usize].len() != 2 || self.stays(first) {
                return None;
            }
            let mut way = vec![first];
            let mut before = a;
            while way.len() < STEPS {
                let last = way[way.len() - 1];
                let v = next(last, before)?;
                if v == b {
                    return Some(way);
                }
                before = last;
                way.push(v);
            }
            None
        })
    }
}

/// A border that goes back on itself turns by more than this, as a cosine: 160 degrees. True borders do that in cusps only, which are
/// corners.
const BACK: f64 = -0.94;

/// Takes out nodes at which a border goes back on itself: where pieces touch, nodes a cell apart may come out in another order along
/// the curve on which they touch.
pub(super) fn straighten_borders(mesh: &mut EditMesh, sets: &[PieceSet]) {
    let mut queue: Vec<u32> = mesh.nodes().filter(|v| sets[*v as usize].len() == 2).collect();
    while let Some(v) = queue.pop() {
        if !mesh.is_node(v) || mesh.is_pinned(v) || mesh.is_boundary(v) || sets[v as usize].len() != 2 {
            continue;
        }
        let mut along = mesh.sharp_neighbors(v);
        let (Some(a), Some(b), None) = (along.next(), along.next(), along.next()) else { continue };
        let [to_a, to_b] = [a, b].map(|x| mesh.point(x) - mesh.point(v));
        if !(-to_a.dot(to_b) < BACK * to_a.length() * to_b.length()) {
            continue;
        }
        let near = if to_a.length_squared() <= to_b.length_squared() { a } else { b };
        drop(along);
        let Some(h) = mesh.outgoing(v).find(|h| mesh.target(*h) == near) else { continue };
        if mesh.collapse(h, mesh.point(near)) {
            queue.extend([a, b]);
        }
    }
}
