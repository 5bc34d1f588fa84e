//! The guard every move passes: no triangle is turned over or squeezed flat, or the move is shortened, or undone.

use glam::DVec3;
use rayon::prelude::*;

use crate::error::Result;
use crate::geometry::SurfaceOracle;
use crate::mesh::EditMesh;
use crate::run::Run;

/// No move may leave a triangle with a smaller angle than this (degrees), unless it was smaller before: below it normals
/// of triangles, which every operator here relies on, lose their digits.
pub const FLOOR_ANGLE: f64 = 5.0;
/// How often a refused move is halved before it is given up.
pub const BACKTRACKS: usize = 4;
/// Where the surface's normal under a triangle is known, a move may not turn the triangle more than 60 degrees away
/// from it (cosine): half of the way to turning it over.
pub const FACING: f64 = 0.5;

/// What an operator that moves nodes did.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Moves {
    /// Nodes that were moved, shortened moves included.
    pub moved: usize,
    /// Of those, how many moved less than the operator wanted.
    pub shortened: usize,
    /// Nodes that stayed, because every length tried would have turned over or squeezed a triangle.
    pub rejected: usize,
    /// Nodes for which the oracle found no foot.
    pub missed: usize,
    /// The longest move, in the part's unit.
    pub largest: f64,
}

impl Moves {
    /// Adds another pass: counts add up, the longest move is kept.
    pub fn add(&mut self, other: Moves) {
        self.moved += other.moved;
        self.shortened += other.shortened;
        self.rejected += other.rejected;
        self.missed += other.missed;
        self.largest = self.largest.max(other.largest);
    }
}

/// Cosine of the smallest angle of a triangle: 0.5 for the best one, 1 for a degenerate one.
pub fn sharpest_cosine([a, b, c]: [DVec3; 3]) -> f64 {
    let (u, v, w) = (b - a, c - b, a - c);
    let (uu, vv, ww) = (u.length_squared(), v.length_squared(), w.length_squared());
    // The smallest angle faces the shortest side.
    let (dot, product) = if uu <= vv && uu <= ww {
        (-v.dot(w), vv * ww)
    } else if vv <= ww {
        (-u.dot(w), uu * ww)
    } else {
        (-u.dot(v), uu * vv)
    };
    if product > 0.0 { dot / product.sqrt() } else { 1.0 }
}

/// Cosine of [`FLOOR_ANGLE`].
fn floor_cosine() -> f64 {
    FLOOR_ANGLE.to_radians().cos()
}

/// Twice the area vector.
pub(super) fn area_vector([a, b, c]: [DVec3; 3]) -> DVec3 {
    (b - a).cross(c - a)
}

/// Whether a triangle may be replaced by one at `new`: it does not turn over against its old self, nor against the
/// surface's normal `m` where that is known (not zero), and its smallest angle stays above the smaller of its old one
/// and [`FLOOR_ANGLE`]. A triangle that faces the wrong way already may move in any way that mends it.
pub fn accepts(old: [DVec3; 3], new: [DVec3; 3], m: DVec3) -> bool {
    let (o, n) = (area_vector(old), area_vector(new));
    let facing = |v: DVec3| v.normalize_or_zero().dot(m);
    if m != DVec3::ZERO {
        let (was, is) = (facing(o), facing(n));
        if is < FACING && is <= was {
            return false;
        }
        if was > 0.0 && is <= 0.0 {
            return false;
        }
    } else if n.dot(o) <= 0.0 && o != DVec3::ZERO {
        return false;
    }
    sharpest_cosine(new) <= sharpest_cosine(old).max(floor_cosine())
}

/// Whether node `v` may go to `p`.
pub fn may_move(mesh: &EditMesh, v: u32, p: DVec3) -> bool {
    p.is_finite()
        && mesh.outgoing(v).all(|h| {
            let (b, c) = (mesh.point(mesh.target(h)), mesh.point(mesh.apex(h)));
            accepts([mesh.point(v), b, c], [p, b, c], mesh.normal(h / 3))
        })
}

/// Where `v` comes to be on its way to `target`, and after how many refusals: at `target`, or, when the guard refuses, at what `settle`
/// makes of the points half, a quarter, ... of the way.
fn way(
    mesh: &EditMesh,
    v: u32,
    target: DVec3,
    settle: impl Fn(&EditMesh, DVec3) -> Option<DVec3>,
) -> Option<(DVec3, usize)> {
    let mut to = target;
    for k in 0..=BACKTRACKS {
        if may_move(mesh, v, to) {
            return Some((to, k));
        }
        to = settle(mesh, mesh.point(v).lerp(target, 0.5f64.powi(k as i32 + 1)))?;
    }
    None
}

/// Moves `v` to `target` or part of the [way].
pub(super) fn relocate(
    mesh: &mut EditMesh,
    v: u32,
    target: DVec3,
    moves: &mut Moves,
    settle: impl Fn(&EditMesh, DVec3) -> Option<DVec3>,
) {
    let Some((to, refused)) = way(mesh, v, target, settle) else {
        moves.rejected += 1;
        return;
    };
    moves.largest = moves.largest.max(to.distance(mesh.point(v)));
    mesh.set_point(v, to);
    moves.moved += 1;
    moves.shortened += usize::from(refused > 0);
}

/// [Moves](relocate) nodes to the targets found for them, by number: none for nodes that stay, a `None` where a foot was missed.
pub(super) fn relocate_all(
    mesh: &mut EditMesh,
    oracle: &dyn SurfaceOracle,
    run: &Run,
    targets: Vec<Option<Option<DVec3>>>,
    settle: impl Fn(&EditMesh, u32, DVec3) -> Option<DVec3> + Sync,
) -> Result<Moves> {
    let mut moves = Moves::default();
    let asked = targets.iter().flatten().count();
    let due: Vec<(u32, DVec3)> = (0..).zip(targets).filter_map(|(v, t)| Some((v, t??))).collect();
    moves.missed = asked - due.len();
    for k in 0..due.len() {
        let frozen = &*mesh;
        ahead(oracle, run, &due, k, |&(v, p)| {
            way(frozen, v, p, |m, p| settle(m, v, p));
        })?;
        let (v, p) = due[k];
        relocate(mesh, v, p, &mut moves, |m, p| settle(m, v, p));
    }
    Ok(moves)
}

/// Asks `ask` for every id below `count` on the run's threads; answers are placed by id. What it asks of the oracle is asked for
/// together where that is cheaper.
pub(super) fn ask_all<T: Send>(
    oracle: &dyn SurfaceOracle,
    run: &Run,
    count: usize,
    ask: impl Fn(u32) -> Option<T> + Sync,
) -> Result<Vec<Option<T>>> {
    // Four parts for each thread, as some take longer than others. Where points wait for each other one call for each must do.
    let parts = if oracle.remembers() { 1 } else { 4 };
    in_parts(run, count, parts, ask, |count, question| oracle.in_turn(count, question))
}

/// Answers for every id below `count`, of what no oracle is asked for.
pub fn find_all<T: Send>(run: &Run, count: usize, find: impl Fn(u32) -> Option<T> + Sync) -> Result<Vec<Option<T>>> {
    in_parts(run, count, 4, find, |count, question| (0..count).for_each(question))
}

/// Answers for every id below `count`, in so many parts for each thread; `turn` puts so many questions by number.
fn in_parts<T: Send>(
    run: &Run,
    count: usize,
    parts: usize,
    ask: impl Fn(u32) -> Option<T> + Sync,
    turn: impl Fn(usize, &mut dyn FnMut(usize)) + Sync,
) -> Result<Vec<Option<T>>> {
    /// Questions at a time: few enough to notice a cancellation within milliseconds, enough to hide the scheduling.
    const BLOCK: usize = 256;
    /// Questions that wait for each other take memory until the last is answered: no portion has more.
    const MOST: usize = 1 << 14;
    run.check()?;
    let mut answers: Vec<Option<T>> = (0..count).map(|_| None).collect();
    run.install(|| {
        let portion = (count / (parts * rayon::current_num_threads())).clamp(BLOCK, MOST);
        answers.par_chunks_mut(portion).enumerate().for_each(|(k, part)| {
            turn(part.len(), &mut |i| {
                let id = k * portion + i;
                part[i] = if id.is_multiple_of(BLOCK) && run.is_cancelled() { None } else { ask(id as u32) };
            });
        });
    });
    run.check()?;
    Ok(answers)
}

/// How many things of a list are looked at ahead: edits spoil what was asked for later ones.
const AHEAD: usize = 2048;

/// Before the things of a list are done one after the other: asks what the next ones will ask, so that an oracle that remembers
/// knows it by then. To be called before each of them with its number.
pub(super) fn ahead<T: Sync>(
    oracle: &dyn SurfaceOracle,
    run: &Run,
    list: &[T],
    k: usize,
    ask: impl Fn(&T) + Sync,
) -> Result<()> {
    if !oracle.remembers() || !k.is_multiple_of(AHEAD) {
        return Ok(());
    }
    let next = &list[k..list.len().min(k + AHEAD)];
    let asked = |i: u32| {
        ask(&next[i as usize]);
        None::<()>
    };
    ask_all(oracle, run, next.len(), asked)?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_abs_diff_eq;

    const BASE: [DVec3; 3] = [DVec3::ZERO, DVec3::X, DVec3::new(0.5, 0.8, 0.0)];

    fn apex_at(x: f64, y: f64) -> [DVec3; 3] {
        [DVec3::ZERO, DVec3::X, DVec3::new(x, y, 0.0)]
    }

    #[test]
    fn the_smallest_angle_is_found_whichever_corner_it_sits_at() {
        let t = [DVec3::ZERO, DVec3::new(4.0, 0.0, 0.0), DVec3::new(4.0, 1.0, 0.0)];
        for k in 0..3 {
            let turned = [t[k], t[(k + 1) % 3], t[(k + 2) % 3]];
            assert_abs_diff_eq!(sharpest_cosine(turned), 4.0 / 17f64.sqrt(), epsilon = 1e-15);
        }
        assert_eq!(sharpest_cosine([DVec3::X; 3]), 1.0);
    }

    #[test]
    fn turning_over_and_squeezing_are_refused_with_and_without_a_known_normal() {
        for m in [DVec3::ZERO, DVec3::Z] {
            assert!(accepts(BASE, apex_at(0.4, 0.3), m));
            assert!(!accepts(BASE, apex_at(0.5, -0.8), m));
            assert!(!accepts(BASE, apex_at(0.5, 0.04), m));
            // Already squeezed: may grow fatter, not thinner.
            assert!(accepts(apex_at(0.5, 0.03), apex_at(0.5, 0.035), m));
            assert!(!accepts(apex_at(0.5, 0.03), apex_at(0.5, 0.02), m));
        }
        // Already turned over: may turn back when the surface's normal is known.
        assert!(accepts(apex_at(0.5, -0.8), BASE, DVec3::Z));
        assert!(!accepts(apex_at(0.5, -0.8), BASE, DVec3::ZERO));
    }
}
