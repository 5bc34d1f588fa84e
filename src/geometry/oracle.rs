//! What a stage may ask the surface.

use glam::DVec3;

/// Steps of Newton's method onto a surface, at most: it squares the error with each, so that what takes more does not settle.
pub(crate) const NEWTON_STEPS: usize = 20;

/// A point on the surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Foot {
    /// The point.
    pub point: DVec3,
    /// Outward unit normal there, of the face the point lies on.
    pub normal: DVec3,
    /// The face the point lies on: an index into the mesh's face names.
    pub face: u32,
}

/// The surface, as seen by stages that do not know where it came from.
///
/// On a sharp edge or corner several faces meet; the oracle then answers with one of them, always the same one for the
/// same point. All answers are deterministic and may be asked for from many threads at once.
pub trait SurfaceOracle: Sync {
    /// A surface point near `p`, at most `reach` away: the foot of `p` on the face that is active near `p`, or the nearest
    /// point of a sharp edge when that foot lies outside the face. `None` when nothing is found within `reach`.
    ///
    /// The foot is a local minimum of the distance; it is the global one where `p` is nearer to the surface than the
    /// local feature size.
    fn project(&self, p: DVec3, reach: f64) -> Option<Foot>;

    /// [`project`](Self::project) of many points on this thread, in their order: the same answers, cheaper where a source is better
    /// asked for many points at once.
    fn project_all(&self, points: &[DVec3], reach: f64) -> Vec<Option<Foot>> {
        points.iter().map(|p| self.project(*p, reach)).collect()
    }

    /// Puts questions to the caller by number, on this thread: each may ask this oracle, and depends on nothing that the others
    /// change. Where a source is better asked for many points at once a question is put again and again until all it asks is known;
    /// then what it found the last time is the answer, and the same as alone.
    fn in_turn(&self, count: usize, question: &mut dyn FnMut(usize)) {
        (0..count).for_each(question);
    }

    /// Whether what was asked once is known from then on, so that it pays to ask for much [in turn](Self::in_turn) ahead of a use.
    fn remembers(&self) -> bool {
        false
    }

    /// The crossing of the line `p + t * direction`, `|t| <= reach`, with the surface that is nearest to `p`.
    /// `direction` must be a unit vector. `None` when there is no crossing within `reach`.
    ///
    /// Sources that know no sides have Newton's method on the line, against the tangent planes of the feet, which may find
    /// a crossing farther away than the nearest.
    fn project_along(&self, p: DVec3, direction: DVec3, reach: f64) -> Option<Foot> {
        // Newton's method on the line, against the tangent planes of the feet.
        let mut t: f64 = 0.0;
        for _ in 0..NEWTON_STEPS {
            let foot = self.project(p + t * direction, reach)?;
            let slope = direction.dot(foot.normal);
            let gap = (foot.point - p - t * direction).dot(foot.normal);
            if !(slope.abs() > 1e-3) {
                return None;
            }
            t += gap / slope;
            if t.abs() > reach {
                return None;
            }
            if gap.abs() <= 1e-14 * (p.length() + reach) {
                break;
            }
        }
        self.project(p + t * direction, reach)
    }

    /// Principal curvatures of the foot's face at a surface point, larger magnitude first; positive where the solid is
    /// convex. `None` where the face has none (an apex) or the source cannot tell.
    fn curvatures(&self, foot: &Foot) -> Option<[f64; 2]>;
}
