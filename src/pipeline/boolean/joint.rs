//! The surfaces of several operands as one set of pieces: where pieces of different operands meet is found by Newton's method on
//! both.

use glam::{DMat3, DVec3};

use crate::geometry::{Foot, Pieces, SurfaceOracle};

/// Steps of Newton's method on the tangent planes of several surfaces. Smooth ones take five; where one is made of triangles
/// its planes change from step to step.
const STEPS: usize = 24;
/// Steps from surface to surface where that does not end.
const MORE: usize = 200;
/// A point lies on surfaces that are this share of the size away: rounding of a few steps in coordinates.
const ON: f64 = 1e-14;
/// Where no surface is nearer a point may lie on those this share of the size away: well below what the border is asked for.
const NEARLY: f64 = 1e-11;
/// Sine of the angle below which two surfaces have no curve in common: Newton's method loses more than half of its digits.
pub(super) const TANGENT: f64 = 1e-4;

/// Pieces of several operands, numbered one operand after the other: first what is a face of each, then the lines within faces.
pub(super) struct OperandPieces<'a> {
    pub(super) operands: Vec<&'a dyn Pieces>,
    /// The operand of each piece, and its number there.
    pub(super) home: Vec<(u32, u32)>,
    /// The diagonal of a box around everything.
    pub(super) scale: f64,
}

impl<'a> OperandPieces<'a> {
    /// Its own plane, which goes on beyond the borders of a face, as triangles do not.
    fn flat(&self, piece: u32, p: DVec3) -> Option<DVec3> {
        let (n, d) = self.plane(piece)?;
        Some(p - n * (n.dot(p) - d))
    }

    fn of(&self, piece: u32) -> Option<(&'a dyn Pieces, u32)> {
        let (operand, own) = *self.home.get(piece as usize)?;
        Some((*self.operands.get(operand as usize)?, own))
    }

    /// The sine of the angle between two pieces at a point of both.
    pub(super) fn angle(&self, [a, b]: [u32; 2], p: DVec3) -> Option<f64> {
        Some(self.direction(a, p)?.cross(self.direction(b, p)?).length())
    }

    /// Pieces by operand; planes each by itself.
    fn groups(&self, pieces: &[u32]) -> Option<Vec<(&'a dyn Pieces, Vec<u32>)>> {
        let mut out: Vec<(u32, Vec<u32>)> = Vec::new();
        for p in pieces {
            let (operand, own) = *self.home.get(*p as usize)?;
            let alone = self.plane(*p).is_some();
            let curved = |g: &&mut (u32, Vec<u32>)| {
                g.0 == operand && self.operands.get(operand as usize).is_some_and(|o| o.plane(g.1[0]).is_none())
            };
            match out.iter_mut().find(curved).filter(|_| !alone) {
                Some(g) => g.1.push(own),
                None => out.push((operand, vec![own])),
            }
        }
        out.into_iter().map(|(o, own)| Some((*self.operands.get(o as usize)?, own))).collect()
    }

    fn newton(&self, groups: &[(&dyn Pieces, Vec<u32>)], p: DVec3, reach: f64) -> Option<DVec3> {
        let near = |x: DVec3| x.distance(p) <= reach;
        let (mut x, mut best) = (p, (f64::INFINITY, p));
        for step in 0..STEPS + MORE {
            let mut planes: Vec<(DVec3, f64)> = Vec::with_capacity(4);
            let (mut worst, mut last) = (0.0f64, x);
            for (operand, own) in groups {
                // Once Newton's method goes in circles each surface is asked from the foot on the one before.
                let from = if step < STEPS { x } else { last };
                let q = foot(*operand, own, from)?;
                worst = worst.max(q.distance(from));
                last = q;
                for piece in own {
                    let n = operand.plane(*piece).map(|k| k.0).or_else(|| operand.direction(*piece, q))?;
                    planes.push((n, n.dot(q - x)));
                }
            }
            if step < STEPS && worst < best.0 && near(x) {
                best = (worst, x);
            }
            if worst <= ON * self.scale {
                break;
            }
            let next = if step < STEPS { x + least_step(&planes)? } else { last };
            if !next.is_finite() || next.distance(p) > 4.0 * reach {
                return (best.0 <= NEARLY * self.scale).then_some(best.1);
            }
            if step >= STEPS {
                let off = groups.iter().filter_map(|(o, own)| Some(foot(*o, own, next)?.distance(next)));
                let off = off.fold(0.0, f64::max);
                if off < best.0 && near(next) {
                    best = (off, next);
                }
            }
            x = next;
        }
        (best.0 <= NEARLY * self.scale).then_some(best.1)
    }
}

/// The foot of a point on one piece, or on the curve of two; on more, that of the first two.
fn foot(operand: &dyn Pieces, own: &[u32], p: DVec3) -> Option<DVec3> {
    if let [one] = *own
        && let Some((n, d)) = operand.plane(one)
    {
        return Some(p - n * (n.dot(p) - d));
    }
    operand.meet(own, p, f64::INFINITY).or_else(|| operand.meet(own.get(..2)?, p, f64::INFINITY))
}

/// The shortest step onto two planes, or onto the point of the first three that meet in one; each is a unit normal and a distance.
fn least_step(planes: &[(DVec3, f64)]) -> Option<DVec3> {
    let ((m, a), (n, b)) = (planes.first()?, planes.get(1)?);
    let along = m.cross(*n);
    if along.length() <= TANGENT {
        return None;
    }
    if let Some(third) = planes[2..].iter().find(|k| k.0.dot(along).abs() > TANGENT * along.length()) {
        let rows = DMat3::from_cols(*m, *n, third.0).transpose();
        return Some(rows.inverse() * DVec3::new(*a, *b, third.1));
    }
    let c = m.dot(*n);
    let det = 1.0 - c * c;
    Some(*m * ((a - c * b) / det) + *n * ((b - c * a) / det))
}

impl SurfaceOracle for OperandPieces<'_> {
    fn project(&self, p: DVec3, reach: f64) -> Option<Foot> {
        let feet = self.operands.iter().filter_map(|o| o.project(p, reach));
        feet.min_by(|a, b| a.point.distance_squared(p).total_cmp(&b.point.distance_squared(p)))
    }

    fn curvatures(&self, _foot: &Foot) -> Option<[f64; 2]> {
        None
    }
}

impl Pieces for OperandPieces<'_> {
    fn piece_at(&self, _p: DVec3) -> Option<u32> {
        None
    }

    fn near(&self, _p: DVec3) -> Vec<u32> {
        Vec::new()
    }

    fn meet(&self, pieces: &[u32], p: DVec3, reach: f64) -> Option<DVec3> {
        if let [one] = *pieces {
            if let Some(q) = self.flat(one, p) {
                return (q.distance(p) <= reach).then_some(q);
            }
            let (operand, own) = self.of(one)?;
            return operand.meet(&[own], p, reach);
        }
        let first = self.home.get(*pieces.first()? as usize)?.0;
        if pieces.iter().all(|k| self.home.get(*k as usize).is_some_and(|h| h.0 == first)) {
            let own: Vec<u32> = pieces.iter().filter_map(|k| Some(self.of(*k)?.1)).collect();
            return self.operands.get(first as usize)?.meet(&own, p, reach);
        }
        self.newton(&self.groups(pieces)?, p, reach)
    }

    fn foot_facing(&self, piece: u32, p: DVec3, normal: DVec3, reach: f64) -> Option<(DVec3, Option<DVec3>)> {
        let (operand, own) = self.of(piece)?;
        operand.foot_facing(own, p, normal, reach)
    }

    fn direction(&self, piece: u32, p: DVec3) -> Option<DVec3> {
        if let Some((n, _)) = self.plane(piece) {
            return Some(n);
        }
        let (operand, own) = self.of(piece)?;
        operand.direction(own, p)
    }

    fn plane(&self, piece: u32) -> Option<(DVec3, f64)> {
        let (operand, own) = self.of(piece)?;
        operand.plane(own)
    }

    fn curvature(&self, piece: u32, p: DVec3) -> Option<f64> {
        let (operand, own) = self.of(piece)?;
        operand.curvature(own, p)
    }

    fn bounds(&self, _pieces: &[u32], _p: DVec3) -> bool {
        true
    }

    fn apexes(&self) -> Vec<(u32, DVec3)> {
        let mut out = Vec::new();
        for (o, operand) in self.operands.iter().enumerate() {
            for (own, p) in operand.apexes() {
                let found = self.home.iter().position(|h| *h == (o as u32, own));
                out.extend(found.map(|k| (k as u32, p)));
            }
        }
        out
    }

    fn face_at(&self, _piece: u32, _p: DVec3) -> Option<u32> {
        None
    }
}
