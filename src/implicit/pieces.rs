//! The leaves of a part as the pieces of its surface.

use glam::DVec3;

use super::leaf::Leaf;
use super::newton::{bounds_solid, leaves_of, nearest};
use super::oracle::ImplicitOracle;
use super::tape::Op;
use crate::geometry::Pieces;

impl Pieces for ImplicitOracle<'_> {
    fn piece_at(&self, p: DVec3) -> Option<u32> {
        let leaf = self.tape(p).active(self.leaves(), p).leaf;
        (leaf != u32::MAX).then_some(leaf)
    }

    fn near(&self, p: DVec3) -> Vec<u32> {
        leaves_of(self.tape(p))
    }

    fn meet(&self, pieces: &[u32], p: DVec3, reach: f64) -> Option<DVec3> {
        let known = pieces.iter().all(|i| (*i as usize) < self.leaves().len());
        if known { nearest(self.leaves(), pieces, p, reach, self.scale()) } else { None }
    }

    fn direction(&self, piece: u32, p: DVec3) -> Option<DVec3> {
        self.leaves().get(piece as usize)?.slope(p).try_normalize()
    }

    fn plane(&self, piece: u32) -> Option<(DVec3, f64)> {
        match *self.leaves().get(piece as usize)? {
            Leaf::Plane { n, d } => Some((-n, -d)),
            _ => None,
        }
    }

    fn curvature(&self, piece: u32, p: DVec3) -> Option<f64> {
        let outward = self.direction(piece, p)?;
        self.leaf_curvatures(piece, p, outward).map(|k| k[0].abs())
    }

    fn bounds(&self, pieces: &[u32], p: DVec3) -> bool {
        let (tape, leaves) = (self.tape(p), self.leaves());
        match *pieces {
            [i] => bounds_solid(tape, leaves, i, p).is_some(),
            [i, j] => self.meeting(p).edge(i, j, p).is_some(),
            [i, j, k] => self.meeting(p).corner([i, j, k], p),
            _ => false,
        }
    }

    fn apexes(&self) -> Vec<(u32, DVec3)> {
        self.own_apexes()
    }

    fn face_at(&self, piece: u32, p: DVec3) -> Option<u32> {
        let tape = self.tape(p);
        let mut faces = tape.ops.iter().filter_map(|op| match *op {
            Op::Leaf { leaf, face, .. } if leaf == piece => Some(face),
            _ => None,
        });
        let first = faces.next()?;
        if faces.next().is_none() {
            return Some(first);
        }
        // the same surface under several names: the tree decides
        let active = tape.active(self.leaves(), p);
        Some(if active.leaf == piece { active.face } else { first })
    }
}
