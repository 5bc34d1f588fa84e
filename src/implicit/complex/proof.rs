//! Whether the leaves in a box are arranged as planes are, shown by intervals.

use super::super::deciding::idle;
use super::super::fillet::touching;
use super::super::leaf::Leaf;
use super::super::newton::leaves_of;
use super::super::slopes::Slopes;
use super::super::tape::Tape;
use super::differences::Differences;
use super::shared::{Shared, common};
use super::twins::Twins;
use crate::numeric::{Dual, Interval, vector};
use crate::spatial::Aabb;
use std::fmt;

use glam::DVec3;
use serde::Serialize;

/// The gradients of a leaf in a box turn away from that in the middle by an angle of which this is the cosine at most: less than
/// a right angle, so that its zero set is a graph over the box, and less by as much as lets its nodes move to it.
const GRAPH: f64 = 0.3;
/// Gradients shorter than that are enough where all are within 45 degrees of the one in the middle, whose cosine this is.
const NEAR: f64 = 0.7;
/// Still they are no more than about ten times shorter, as none is more than [`STEEPEST`] times longer: nodes of linear functions would be
/// far from where they go.
const SHORTEST: f64 = 0.1;
/// The largest partial derivatives together are no more than so many times longer than the gradient in the middle.
const STEEPEST: f64 = 11.0;
/// Sides of a wall that are shown not to meet bend away from planes, at the corners of a box, by less than so many times the distance
/// between them: there they bend three times as far as within a tetrahedron, and flat triangles of one may not pass through the other.
const FLAT: f64 = 2.5;
/// The sine of the angle between two surfaces that cross is at least this.
const CROSSING: f64 = 0.02;

/// Boxes with more leaves than this are halved unseen: their pairs and triples would be many, and hardly any box of so many is
/// simple.
const MOST_TOGETHER: usize = 16;

/// What was not shown of a box.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Unproved {
    /// A leaf may bend back, or be singular.
    Bent,
    /// Two leaves may touch.
    Touching,
    /// Three leaves may have a curve in common, or meet more than once.
    Dependent,
    /// More than three leaves may meet in a point.
    Crowded,
}

impl fmt::Display for Unproved {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Unproved::Bent => "a surface may bend back",
            Unproved::Touching => "two surfaces may touch",
            Unproved::Dependent => "three surfaces may meet more than once",
            Unproved::Crowded => "more than three surfaces may meet",
        })
    }
}

/// A leaf in a box, scaled so that its gradient in the middle has length 1: value there, and bounds of the gradient.
struct Local {
    value: f64,
    gradient: [Interval; 3],
    middle: DVec3,
    /// What the leaf was multiplied by.
    scale: f64,
}

fn dot(g: &[Interval; 3], d: DVec3) -> Interval {
    g[0].scale(d.x) + g[1].scale(d.y) + g[2].scale(d.z)
}

fn local(slopes: Option<Slopes>, duals: impl Fn(&[DVec3]) -> Vec<Dual>, cell: &Aabb) -> Local {
    let mut points = vec![cell.center()];
    if slopes.is_none() {
        points.extend(cell.corners());
    }
    let seen = duals(&points);
    let d = seen[0];
    let gradient = match slopes {
        Some(s) => s.gradient,
        None => {
            // Seen, not shown: the gradients at the corners.
            let mut g = d.g.to_array().map(Interval::point);
            for q in &seen[1..] {
                g = std::array::from_fn(|k| g[k].hull(Interval::point(q.g[k])));
            }
            g
        }
    };
    let scale = 1.0 / d.g.length().max(f64::MIN_POSITIVE);
    Local { value: d.v * scale, gradient: gradient.map(|g| g.scale(scale)), middle: d.g * scale, scale }
}

/// Whether all gradients in the box are near that in the middle: along it by much, or in their direction though some are short. So a
/// steep wall that goes over into a flatter one is a graph as a plane is.
fn is_graph(l: &Local) -> bool {
    let along = dot(&l.gradient, l.middle).lo;
    let near = |g: DVec3| g.dot(l.middle) > NEAR * g.length();
    // What this is greater by is a concave function of the gradient: the least value is at a corner of the bounds.
    let corner = |k: usize, axis: usize| if k >> axis & 1 == 1 { l.gradient[axis].hi } else { l.gradient[axis].lo };
    let all_near = || (0..8).all(|k| near(DVec3::from_array([0, 1, 2].map(|i| corner(k, i)))));
    along > GRAPH || (along > SHORTEST && all_near())
}

/// How far a leaf differs from a linear function at the corners of the box: this is seen, not shown.
fn sag(leaf: &Leaf, l: &Local, cell: &Aabb) -> f64 {
    let corners = cell.corners();
    let linear = |p: DVec3| l.value + l.middle.dot(p - cell.center());
    let seen = leaf.duals(&corners);
    corners.iter().zip(seen).map(|(p, d)| (d.v * l.scale - linear(*p)).abs()).fold(0.0, f64::max)
}

/// Whether a sum of leaves with factors has no zero in the box.
fn apart(all: &[(&Local, f64)], half: DVec3) -> bool {
    let value: f64 = all.iter().map(|(l, k)| l.value * k).sum();
    let mut reach = 0.0;
    for axis in 0..3 {
        let g = all.iter().fold(Interval::point(0.0), |g, (l, k)| g + l.gradient[axis].scale(*k));
        reach += g.lo.abs().max(g.hi.abs()) * half[axis];
    }
    value.abs() > reach
}

fn cross(a: &[Interval; 3], b: &[Interval; 3]) -> [Interval; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// What vanishes on the surface of the first of two leaves where the second does: the second, unless they touch there.
fn across<'a>(ends: &'a [(usize, usize, Local)], here: &'a [Local], [on, other]: [usize; 2]) -> &'a Local {
    let pair = (on.min(other), on.max(other));
    ends.iter().find(|e| (e.0, e.1) == pair).map_or(&here[other], |e| &e.2)
}

/// What is known of the leaves in a box.
#[derive(Debug, Clone)]
pub(super) struct Judged {
    /// What is not shown, if anything.
    pub(super) unproved: Option<Unproved>,
    /// The curves that three leaves share there. They are seen, not shown.
    pub(super) shared: Vec<Shared>,
}

/// A box with what is asked of it.
pub(super) struct Asked<'a> {
    pub(super) leaves: &'a [Leaf],
    pub(super) twins: &'a Twins,
    pub(super) differences: &'a Differences,
    pub(super) cell: Aabb,
    /// The size of the part.
    pub(super) scale: f64,
    /// In larger boxes corners show nothing of a leaf without bounds of its gradient.
    pub(super) seen: f64,
    /// Whether the first thing that is not shown ends it; curves that come after it are not looked for.
    pub(super) briefly: bool,
}

/// Whether the leaves of a tape are shown to be arranged simply in a box.
pub(super) fn judged(tape: &Tape, asked: &Asked<'_>) -> Judged {
    let Asked { leaves, twins, differences, cell, seen, briefly, .. } = asked;
    let half = cell.size() * 0.5;
    let mut all = Judged { unproved: None, shared: Vec::new() };
    let mut here: Vec<Local> = Vec::new();
    let mut numbers: Vec<u32> = Vec::new();
    let passing = leaves_of(tape);
    if passing.len() > MOST_TOGETHER {
        return Judged { unproved: Some(Unproved::Crowded), ..all };
    }
    let idle = idle(tape, &passing);
    for number in passing {
        if idle.contains(&number) {
            continue;
        }
        let leaf = &leaves[number as usize];
        if !leaf.range(cell).contains(0.0) {
            continue;
        }
        let slopes = leaf.slopes(cell);
        if slopes.is_some_and(|s| !s.value.contains(0.0)) {
            continue;
        }
        // Half a cell more is rounding.
        if slopes.is_none() && cell.size().max_element() > 1.5 * seen {
            all.unproved = Some(Unproved::Bent);
            if *briefly {
                return all;
            }
        }
        let l = local(slopes, |p| leaf.duals(p), cell);
        if apart(&[(&l, 1.0)], half) {
            continue;
        }
        let largest = l.gradient.iter().map(|g| g.lo.abs().max(g.hi.abs())).fold(0.0, |s, g| s + g * g).sqrt();
        // A line along the gradient in the middle that crosses the surface twice would come back to its other side between: that it
        // rises on the surface is enough.
        let rises = || match leaf {
            Leaf::Fillet(f) => f.least_rise(cell, l.middle).is_some_and(|x| x * l.scale > GRAPH),
            _ => false,
        };
        if !(largest < STEEPEST && (is_graph(&l) || rises())) {
            all.unproved = Some(Unproved::Bent);
            if *briefly {
                return all;
            }
        }
        here.push(l);
        numbers.push(number);
    }
    let n = here.len();
    let mut meet = vec![false; n * n];
    // A fillet touches the surfaces that it ends in: what tells it from one of them crosses that.
    let mut ends: Vec<(usize, usize, Local)> = Vec::new();
    for i in 0..n {
        for j in i + 1..n {
            let is_apart = |a: &Local, b: &Local| {
                let s = vector::hypot(a.value, b.value);
                let ways = [(a.value / s, b.value / s), (1.0, 1.0), (1.0, -1.0)];
                ways.iter().any(|(x, y)| apart(&[(a, *x), (b, *y)], half))
            };
            let pair = [numbers[i], numbers[j]];
            if is_apart(&here[i], &here[j]) || twins.are_one(leaves, pair, cell) {
                continue;
            }
            let flat = |sign: f64| {
                let between = here[i].value + sign * here[j].value;
                let sag = [i, j].map(|k| sag(&leaves[numbers[k] as usize], &here[k], cell));
                sag[0] + sag[1] < FLAT * between.abs()
            };
            if differences.apart(leaves, pair, cell).is_some_and(flat) {
                continue;
            }
            if let Some(between) = touching(leaves, numbers[i], numbers[j]) {
                let l = local(between.slopes(cell), |p| p.iter().map(|p| between.gradient(*p)).collect(), cell);
                if apart(&[(&l, 1.0)], half) || is_apart(&here[i], &l) {
                    continue;
                }
                // In larger cells the two would cross elsewhere: their distance is a square.
                if half.max_element() > 0.75 * seen {
                    all.unproved = all.unproved.or(Some(Unproved::Touching));
                    if *briefly {
                        return all;
                    }
                }
                ends.push((i, j, l));
            }
            let (a, b) = (&here[i], across(&ends, &here, [i, j]));
            let t = a.middle.cross(b.middle);
            if !(t.length() > CROSSING) || !(dot(&cross(&a.gradient, &b.gradient), t / t.length()).lo > 0.0) {
                all.unproved = all.unproved.or(Some(Unproved::Touching));
                if *briefly {
                    return all;
                }
                continue;
            }
            meet[i * n + j] = true;
        }
    }
    let mut triples: Vec<[usize; 3]> = Vec::new();
    let mut bundles: Vec<(Vec<usize>, DVec3)> = Vec::new();
    for i in 0..n {
        for j in (i + 1..n).filter(|j| meet[i * n + j]) {
            for k in (j + 1..n).filter(|k| meet[i * n + k] && meet[j * n + k]) {
                let ended = |x: usize, y: usize| ends.iter().any(|e| (e.0, e.1) == (x.min(y), x.max(y)));
                let turns = [[i, j, k], [j, i, k], [k, i, j]];
                let count = |t: &[usize; 3]| usize::from(ended(t[0], t[1])) + usize::from(ended(t[0], t[2]));
                let most = turns.iter().map(count).max().unwrap_or(0);
                let three = |t: &[usize; 3]| {
                    Three::seen(
                        [&here[t[0]], across(&ends, &here, [t[0], t[1]]), across(&ends, &here, [t[0], t[2]])],
                        half,
                    )
                };
                // Where all of them touch, what tells two of them from the third may touch, too, but not from each other.
                let seen = turns.iter().filter(|t| count(t) == most).map(three).min().unwrap_or(Three::Dependent);
                match seen {
                    Three::Apart => continue,
                    Three::Crossing => {
                        triples.push([i, j, k]);
                        continue;
                    }
                    Three::Dependent => {}
                }
                let crossing = most == 0;
                match common(asked, [i, j, k].map(|x| numbers[x])).filter(|_| crossing) {
                    Some(at) => {
                        // More than three have a curve in common if two of it are in two threes.
                        let fits = |b: &&mut (Vec<usize>, DVec3)| {
                            let has = |x: usize| b.0.contains(&x);
                            let crosses = |x: usize| has(x) || b.0.iter().all(|y| meet[x.min(*y) * n + x.max(*y)]);
                            [i, j, k].into_iter().filter(|x| has(*x)).count() >= 2 && [i, j, k].into_iter().all(crosses)
                        };
                        match bundles.iter_mut().find(fits) {
                            Some(b) => [i, j, k].into_iter().for_each(|x| {
                                if !b.0.contains(&x) {
                                    b.0.push(x);
                                }
                            }),
                            None => bundles.push((vec![i, j, k], at)),
                        }
                    }
                    None => all.unproved = all.unproved.or(Some(Unproved::Dependent)),
                }
                if *briefly && all.unproved.is_some() {
                    return all;
                }
            }
        }
    }
    let bundled = |which: [usize; 3]| bundles.iter().any(|b| which.iter().all(|x| b.0.contains(x)));
    if !briefly {
        let curve = |b: &(Vec<usize>, DVec3)| Shared::new(asked, b.0.iter().map(|x| numbers[*x]).collect(), b.1);
        all.shared = bundles.iter().map(curve).collect();
    }
    for (m, [i, j, k]) in triples.iter().enumerate() {
        for other in &triples[m + 1..] {
            if other[0] == *i && other[1] == *j && triples.contains(&[*i, *k, other[2]]) {
                if bundled([*j, *k, other[2]]) {
                    continue;
                }
                let four = [*i, *j, *k, other[2]].map(|x| &here[x]);
                let s = four.iter().map(|l| l.value * l.value).sum::<f64>().sqrt();
                let ways: Vec<(&Local, f64)> = four.iter().map(|l| (*l, l.value / s)).collect();
                if !apart(&ways, half) {
                    all.unproved = all.unproved.or(Some(Unproved::Crowded));
                    return all;
                }
            }
        }
    }
    all
}

/// How three surfaces lie, as far as that is shown; what is known more of comes first.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Three {
    Apart,
    /// They meet in one point at most.
    Crossing,
    Dependent,
}

impl Three {
    /// Of three functions that are all zero where the surfaces meet, in a box of this half size.
    fn seen([a, b, c]: [&Local; 3], half: DVec3) -> Self {
        let v = DVec3::new(a.value, b.value, c.value);
        let mut ways = vec![v / v.length(), weights(a, b, c)];
        ways.extend([(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)].map(|(x, y)| DVec3::new(1.0, x, y)));
        if ways.iter().any(|w| apart(&[(a, w.x), (b, w.y), (c, w.z)], half)) {
            return Self::Apart;
        }
        let det = cross(&a.gradient, &b.gradient);
        let det = det[0] * c.gradient[0] + det[1] * c.gradient[1] + det[2] * c.gradient[2];
        if det.contains(0.0) { Self::Dependent } else { Self::Crossing }
    }
}

/// Factors with which the gradients in the middle cancel best.
fn weights(a: &Local, b: &Local, c: &Local) -> DVec3 {
    let w = DVec3::new(
        b.middle.cross(c.middle).length(),
        c.middle.cross(a.middle).length(),
        a.middle.cross(b.middle).length(),
    );
    let mut best = (f64::INFINITY, DVec3::X);
    for (x, y) in [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)] {
        let u = w * DVec3::new(1.0, x, y);
        let left = (a.middle * u.x + b.middle * u.y + c.middle * u.z).length() / u.length();
        if left < best.0 {
            best = (left, u / u.length());
        }
    }
    best.1
}

#[cfg(test)]
mod tests {
    use super::super::super::formula::Formula;
    use super::super::super::tape::Op;
    use super::*;
    use crate::implicit::Placement;
    use crate::implicit::expr::{Expr, Unary};

    #[test]
    fn steepness_that_varies_bends_nothing_and_a_surface_that_comes_back_is_bent() {
        let exp = |k: f64| Expr::unary(Unary::Exp, Expr::x() * k);
        // Planes y = 0, times what grows 16 fold along the box; two sheets.
        let cases = [
            (exp(4.0) * Expr::y(), true),
            (exp(-4.0) * (Expr::y() - 0.002) / 3.0, true),
            (Expr::x() * Expr::x() - Expr::y() * Expr::y() + 1e-5, false),
            // It is steep in the middle and comes back on both sides.
            (Expr::unary(Unary::Sin, Expr::x() * 9.0) - Expr::y() * 0.1, false),
        ];
        let cell = Aabb::new(DVec3::new(-0.35, -0.01, -0.01), DVec3::new(0.35, 0.01, 0.01));
        for (e, simple) in cases {
            let leaves = [Leaf::Formula(Formula::compile(&e, &Placement::IDENTITY))];
            let tape = Tape { ops: vec![Op::Leaf { leaf: 0, face: 0, negate: false }] };
            let (twins, differences) = (Twins::new(&leaves), Differences::default());
            let asked = Asked {
                leaves: &leaves,
                twins: &twins,
                differences: &differences,
                cell,
                scale: 1.0,
                seen: 1.0,
                briefly: true,
            };
            assert_eq!(judged(&tape, &asked).unproved.is_none(), simple, "{e:?}");
        }
    }
}
