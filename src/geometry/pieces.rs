//! Surfaces known as pieces: what lets a mesh's edges and corners be placed exactly.

use glam::DVec3;

use super::SurfaceOracle;

/// A surface that is made of smooth pieces, each of which goes on beyond its own borders: the leaves of an R-function
/// tree, the surfaces of a boundary representation. Where two pieces meet there is an edge, where three do a corner.
///
/// All answers are deterministic and may be asked for from many threads at once.
pub trait Pieces: SurfaceOracle {
    /// The piece a point of the surface lies on: on an edge or corner one of those that meet there.
    fn piece_at(&self, p: DVec3) -> Option<u32>;

    /// The pieces that may pass near a point, ascending: all that do within the source's own resolution, perhaps more.
    fn near(&self, p: DVec3) -> Vec<u32>;

    /// A point near `p` at which all of `pieces` (one to three) meet, to rounding: for one piece the foot of `p` on it, for
    /// two the nearest point of their curve. `None` when Newton's method finds none within `reach`.
    ///
    /// Says nothing about whether the point is on the surface; see [`bounds`](Self::bounds).
    fn meet(&self, pieces: &[u32], p: DVec3, reach: f64) -> Option<DVec3>;

    /// Like [`meet`](Self::meet) for one piece, but where sheets of the piece lie close to each other the point is on one that
    /// faces the way of `normal`. Comes with the piece's [`direction`](Self::direction) there.
    fn foot_facing(&self, piece: u32, p: DVec3, _normal: DVec3, reach: f64) -> Option<(DVec3, Option<DVec3>)> {
        let q = self.meet(&[piece], p, reach)?;
        Some((q, self.direction(piece, q)))
    }

    /// Unit normal of a piece at a point on it, to the side where the piece's own function grows. `None` at an apex.
    fn direction(&self, piece: u32, p: DVec3) -> Option<DVec3>;

    /// Unit normal `n` and offset `d` of a piece that is a plane `n . p = d`, the normal to the side [`direction`] points
    /// to.
    ///
    /// [`direction`]: Self::direction
    fn plane(&self, piece: u32) -> Option<(DVec3, f64)>;

    /// The larger magnitude of the principal curvatures of a piece at a point on it. `None` where it has none.
    fn curvature(&self, piece: u32, p: DVec3) -> Option<f64>;

    /// Whether every one of `pieces` bounds the solid at `p`, a point where they meet.
    fn bounds(&self, pieces: &[u32], p: DVec3) -> bool;

    /// Points of the surface without a normal, such as apexes of cones, each with the piece that has it.
    fn apexes(&self) -> Vec<(u32, DVec3)>;

    /// The face (an index into the mesh's face names) that a piece makes at a point of the surface.
    fn face_at(&self, piece: u32, p: DVec3) -> Option<u32>;
}
