//! Apexes of cones get a node, also where the tip is too narrow for the cells and was cut off.

use glam::DVec3;

use super::patchwork::PieceSet;
use crate::geometry::Pieces;
use crate::mesh::{EditMesh, edit::NONE, edit::next};
use crate::numeric::COS_60;

/// An apex this many cells from the nearest node of its piece gets that node;
const REACH: f64 = 2.0;
/// one farther away, up to this many cells, only if what is made so faces the way the piece does: the tip of a cone of two
/// degrees is thinner than a cell for this long.
const FAR: f64 = 30.0;
/// A tip is closed by no more triangles than this.
const MOST: usize = 64;
/// Where the triangles around an apex have smaller angles there than this, radians, they get rings of nodes: the remesher splits
/// no needle.
const NARROW: f64 = 0.5;
/// Rings go down to this share of a cell from the apex, and are no nearer to each other.
const INNERMOST: f64 = 0.25;

/// Moves to every apex the node of its piece that is nearest, and pins it there. New nodes are noted in `sets`, new triangles in
/// `of_triangle`.
pub(super) fn put_apexes(
    mesh: &mut EditMesh,
    sets: &mut Vec<PieceSet>,
    of_triangle: &mut Vec<u32>,
    surface: &dyn Pieces,
    cell: f64,
) {
    for (piece, apex) in surface.apexes() {
        let tip = PieceApex { piece, apex, surface, cell };
        let own = |v: &u32| {
            let free = !mesh.is_pinned(*v) && !mesh.is_boundary(*v);
            free && sets[*v as usize] == PieceSet::one(piece) && tip.is_free(mesh, of_triangle, *v)
        };
        let away = |v: &u32| mesh.point(*v).distance_squared(apex);
        let nearest = mesh.nodes().filter(own).min_by(|a, b| away(a).total_cmp(&away(b)).then(a.cmp(b)));
        let Some(v) = nearest.filter(|v| away(v) <= FAR * FAR * cell * cell) else { continue };
        let before = (away(&v) > REACH * REACH * cell * cell).then(|| mesh.clone());
        let good = tip.put(mesh, of_triangle, v);
        match before {
            Some(before) if !good => *mesh = before,
            _ => {
                mesh.set_pinned(v, true);
                tip.put_rings(mesh, v);
                sets.resize(mesh.node_capacity(), PieceSet::one(piece));
                of_triangle.resize(mesh.triangle_capacity(), piece);
            }
        }
    }
}

/// An apex, and the piece it is on.
struct PieceApex<'a> {
    piece: u32,
    apex: DVec3,
    surface: &'a dyn Pieces,
    cell: f64,
}

impl PieceApex<'_> {
    fn is_own(&self, of_triangle: &[u32], h: u32) -> bool {
        h != NONE && of_triangle[(h / 3) as usize] == self.piece
    }

    fn is_free(&self, mesh: &EditMesh, of_triangle: &[u32], v: u32) -> bool {
        mesh.outgoing(v).all(|h| self.is_own(of_triangle, h))
    }

    /// Twice the area of a triangle, as seen along the normal of the piece there.
    fn facing(&self, mesh: &EditMesh, t: u32) -> f64 {
        self.surface.direction(self.piece, mesh.centroid(t)).map_or(0.0, |n| mesh.area_vector(t).dot(n))
    }

    /// Moves a node to the apex, and what closed the tip below it into its fan. Whether all of the fan faces the way its
    /// surroundings do.
    fn put(&self, mesh: &mut EditMesh, of: &[u32], v: u32) -> bool {
        let around: Vec<u32> = mesh.neighbors(v).collect();
        let wide = around.iter().flat_map(|w| mesh.outgoing(*w)).filter(|h| self.is_own(of, *h));
        let side = wide.map(|h| self.facing(mesh, h / 3)).sum::<f64>().signum();
        mesh.set_point(v, self.apex);
        // Triangles that turn by more than this from their piece close a tip that was cut off.
        let closes = |m: &EditMesh, t: u32| side * self.facing(m, t) < COS_60 * m.area_vector(t).length();
        for _ in 0..MOST {
            let rim: Vec<u32> = mesh.outgoing(v).map(next).collect();
            let taken = rim.into_iter().any(|h| {
                let o = mesh.opposite(h);
                self.is_own(of, o) && closes(mesh, o / 3) && mesh.flip(h)
            });
            if !taken && !self.swallow(mesh, of, v, &closes) {
                break;
            }
        }
        mesh.outgoing(v).all(|h| side * self.facing(mesh, h / 3) > 0.0)
    }

    /// Takes a neighbor of the apex into it, all of whose triangles would close the tip.
    fn swallow(&self, mesh: &mut EditMesh, of: &[u32], v: u32, closes: &impl Fn(&EditMesh, u32) -> bool) -> bool {
        // Half-edges to the apex.
        let mut inward = mesh.outgoing(v).map(|h| mesh.opposite(h)).filter(|o| *o != NONE);
        let inner = inward.find(|o| {
            let w = mesh.origin(*o);
            self.is_free(mesh, of, w) && mesh.outgoing(w).all(|x| closes(mesh, x / 3)) && mesh.can_collapse(*o)
        });
        inner.is_some_and(|o| mesh.collapse(o, self.apex))
    }

    /// Rings of nodes around the apex of a narrow cone, as far from each other as their nodes are.
    fn put_rings(&self, mesh: &mut EditMesh, v: u32) {
        let spokes = mesh.valence(v) as f64;
        let angle =
            mesh.outgoing(v).map(|h| self.toward(mesh, mesh.target(h)).angle_between(self.toward(mesh, mesh.apex(h))));
        let angle = angle.sum::<f64>() / spokes;
        if !(angle < NARROW) {
            return;
        }
        let mut length = mesh.neighbors(v).map(|w| self.toward(mesh, w).length()).sum::<f64>() / spokes;
        let least = INNERMOST * self.cell;
        while length > 2.0 * least {
            let inward = 1.0 - angle.max(least / length);
            for w in mesh.neighbors(v).collect::<Vec<u32>>() {
                let Some(h) = mesh.edge_between(v, w) else { continue };
                let x = self.apex + inward * self.toward(mesh, w);
                mesh.split_edge(h, self.surface.meet(&[self.piece], x, least).unwrap_or(x));
            }
            length *= inward;
        }
    }

    fn toward(&self, mesh: &EditMesh, w: u32) -> DVec3 {
        mesh.point(w) - self.apex
    }
}
