//! Sheets of free form (\[KUZ19\] 33, 38-47, 61): patches with four borders, surfaces over a family of chains, surfaces of shift.

use glam::{DVec3, DVec4};

use super::assembly::{Along, Assembly};
use super::sew::sew;
use super::wire::{Wire, refuse};
use crate::error::Result;
use crate::numeric::{ROUNDING, SEVEN_DIGITS};
use crate::parametric::basis::Knots;
use crate::parametric::brep::{Brep, Coedge};
use crate::parametric::curve::Curve;
use crate::parametric::family::{Family, Shift};
use crate::parametric::nurbs::{NurbsCurve, NurbsSurface, compatible};
use crate::parametric::surface::Surface;
use crate::run::Run;
use crate::spatial::Aabb;

/// Steps along and across at which a patch is looked at.
const STEPS: u32 = 16;

/// How a sheet runs across a family of chains.
#[derive(Debug, Clone, PartialEq)]
pub enum Across {
    /// Through all of them, by cubics with slopes from the neighbors (\[KUZ19\] 38-40).
    Hermite {
        /// Whether it goes on from the last to the first.
        closed: bool,
    },
    /// As a rational B-spline with the chains for control points (\[KUZ19\] 61).
    Spline {
        /// The degree across.
        degree: usize,
        /// Knots; at equal distances, so that the sheet ends at the first and the last chain, where left out.
        knots: Option<Vec<f64>>,
        /// A factor to the weights of every chain; all 1 where left out.
        weights: Option<Vec<f64>>,
    },
    /// By arcs of circles from the first chain to the third, with the second where their tangents meet (\[KUZ19\] 47).
    Fillet,
}

/// A NURBS surface as a sheet; faces are called `side`, with a number where creases divide it.
///
/// Errors: knots at which the surface falls apart; a surface without area; cancellation.
pub fn patch(surface: NurbsSurface, run: &Run) -> Result<Brep> {
    sheet(vec![SheetPatch::whole(surface)?], run)
}

/// A sheet over chains of edges: edge `i` of all chains makes face `i`. Chains run the same way.
///
/// Errors: chains with different numbers of edges, or open and closed ones; too few for the way across; weights or knots that
/// do not fit; legs of a fillet that differ; a surface without area; cancellation.
pub fn over_chains(wires: &[Wire], across: &Across, run: &Run) -> Result<Brep> {
    let Some(first) = wires.first() else { return refuse("a surface over curves needs two of them") };
    if let Some(i) =
        wires.iter().position(|w| w.pieces().len() != first.pieces().len() || w.is_closed() != first.is_closed())
    {
        return refuse(format!(
            "chain {} has other edges than the first: as many are needed, all open or closed",
            i + 1
        ));
    }
    let mut patches = Vec::new();
    for i in 0..first.pieces().len() {
        run.check()?;
        let curves: Result<Vec<NurbsCurve>> = wires.iter().map(|w| w.pieces()[i].to_nurbs()).collect();
        let curves = compatible(&curves?)?;
        patches.push(match across {
            Across::Spline { degree, knots, weights } => {
                let n = curves.len();
                let v = match knots {
                    Some(k) => Knots::new(*degree, k.clone(), n)?,
                    None => Knots::uniform(*degree, n)?,
                };
                let weight = weights.clone().unwrap_or_else(|| vec![1.0; n]);
                if weight.len() != n {
                    return refuse("weights must be positive, one for each curve");
                }
                let count = curves[0].weighted().len();
                let points: Vec<DVec4> =
                    (0..count * n).map(|k| curves[k % n].weighted()[k / n] * weight[k % n]).collect();
                SheetPatch::whole(NurbsSurface::from_weighted(curves[0].knots.clone(), v, &points)?)?
            }
            Across::Hermite { closed } => {
                let ends = [curves[0].clone(), curves[if *closed { 0 } else { curves.len() - 1 }].clone()];
                SheetPatch::over(Family::hermite(ranged(curves), *closed)?, ends)?
            }
            Across::Fillet => fillet(curves)?,
        });
    }
    sheet(patches, run)
}

/// The sheet a chain sweeps that is shifted along another without turning (\[KUZ19\] 33), exact as NURBS. `offset` is how far the
/// profile is taken back from where it is. Errors: a surface without area; cancellation.
pub fn shift_edges(profile: &Wire, path: &Wire, offset: DVec3, run: &Run) -> Result<Brep> {
    let mut patches = Vec::new();
    for c in profile.pieces() {
        for g in path.pieces() {
            run.check()?;
            let way = Curve::Nurbs(g.to_nurbs()?);
            let back = path.start() - g.at(0.0) + offset;
            let profile = (Curve::Nurbs(c.to_nurbs()?), [0.0, 1.0]);
            let s = Shift { profile, path: (way, [0.0, 1.0]), offset: back };
            patches.push(SheetPatch::whole(Surface::Shift(Box::new(s)).to_nurbs()?)?);
        }
    }
    sheet(patches, run)
}

fn ranged(curves: Vec<NurbsCurve>) -> Vec<(Curve, [f64; 2])> {
    curves.into_iter().map(|c| (Curve::Nurbs(c), [0.0, 1.0])).collect()
}

fn fillet(curves: Vec<NurbsCurve>) -> Result<SheetPatch> {
    let [from, apex, to] = &curves[..] else { return refuse("a fillet has three chains: from, apex and to") };
    for k in 0..=STEPS {
        let u = f64::from(k) / f64::from(STEPS);
        let [p, q, r] = [from, apex, to].map(|c| c.jet(u)[0]);
        let (one, two, chord) = (p.distance(q), q.distance(r), p.distance(r));
        // The legs of a fillet are equally long up to this.
        if !((one - two).abs() <= SEVEN_DIGITS * (one + two) && chord > SEVEN_DIGITS * (one + two)) {
            return refuse(format!(
                "no arc touches both legs of the fillet at {q}: they must be of one length and not fall together, \
                 and are {one} and {two} long"
            ));
        }
    }
    let ends = [from.clone(), to.clone()];
    let mut all = ranged(curves).into_iter();
    let (Some(a), Some(b), Some(c)) = (all.next(), all.next(), all.next()) else {
        return refuse("a fillet has three chains: from, apex and to");
    };
    SheetPatch::over(Family::fillet([a, b, c])?, ends)
}

/// Faces of one surface.
struct SheetPatch {
    faces: Vec<(Surface, [NurbsCurve; 4])>,
}

impl SheetPatch {
    fn whole(s: NurbsSurface) -> Result<Self> {
        let s = NurbsSurface::from_weighted(s.u.clone().whole()?, s.v.clone().whole()?, s.weighted())?;
        let mut faces = Vec::new();
        for p in s.smooth_parts()? {
            let rims = p.rims()?;
            faces.push((Surface::Nurbs(p), rims));
        }
        Ok(Self { faces })
    }

    /// Over curves: as NURBS where that is exact, as it is where not.
    fn over(f: Family, [start, end]: [NurbsCurve; 2]) -> Result<Self> {
        let rims = [start, f.rim(1)?, end, f.rim(0)?];
        let s = Surface::Family(Box::new(f));
        match s.to_nurbs() {
            Ok(n) => Self::whole(n),
            Err(_) => Ok(Self { faces: vec![(s, rims)] }),
        }
    }
}

fn sheet(patches: Vec<SheetPatch>, run: &Run) -> Result<Brep> {
    let faces: Vec<_> = patches.into_iter().flat_map(|p| p.faces).collect();
    let several = faces.len() > 1;
    let mut all = Vec::with_capacity(faces.len());
    for (i, (surface, rims)) in faces.into_iter().enumerate() {
        run.check()?;
        let name = if several { format!("side{}", i + 1) } else { "side".to_string() };
        all.push(face(surface, rims, name)?);
    }
    match <[Brep; 1]>::try_from(all) {
        Ok([one]) => Ok(one),
        Err(all) => sew(all, None, false, run),
    }
}

fn face(surface: Surface, rims: [NurbsCurve; 4], name: String) -> Result<Brep> {
    let [u, v] = surface.domain();
    let at = |r: [f64; 2], k: u32| r[0] + (r[1] - r[0]) * (f64::from(k) + 0.5) / f64::from(STEPS);
    let cell = (u[1] - u[0]) * (v[1] - v[0]) / f64::from(STEPS * STEPS);
    let (mut area, mut bounds) = (0.0, Aabb::around(rims.iter().flat_map(NurbsCurve::control)));
    for i in 0..STEPS {
        for j in 0..STEPS {
            let [p, su, sv, ..] = surface.jet(at(u, i), at(v, j));
            area += su.cross(sv).length() * cell;
            bounds = bounds.union(&Aabb::around([p]));
        }
    }
    let size = bounds.diagonal();
    // A patch with less area is a line.
    if !(size.is_finite() && area > ROUNDING * size * size) {
        return refuse("the surface has no area: its points or curves lie along one line");
    }
    // Corners nearer to each other are one: as near as borders that are points.
    let mut a = Assembly { touch: Some(SEVEN_DIGITS * size), ..Assembly::default() };
    let poles = surface.poles();
    let closed = surface.periods().map(|p| p.is_some());
    let sides = [(1, v[0]), (0, u[1]), (1, v[1]), (0, u[0])];
    let mut edges: Vec<Along> = Vec::with_capacity(4);
    for (k, (rim, (axis, value))) in rims.into_iter().zip(sides).enumerate() {
        // Across a seam both borders are one edge.
        let twin = k.checked_sub(2).filter(|_| closed[axis]);
        if let Some(t) = twin {
            edges.push(edges[t]);
            continue;
        }
        if poles.iter().any(|p| p.axis == axis && p.value == value) {
            edges.push(None);
            continue;
        }
        let range = rim.knots.domain();
        let ends = range.map(|t| a.vertex(rim.jet(t)[0]));
        edges.push(a.edge(Curve::Nurbs(rim), range, ends));
    }
    let back = |c: Along| c.map(|c| Coedge { forward: !c.forward, ..c });
    let round = [edges[0], edges[1], back(edges[2]), back(edges[3])];
    a.face(surface, true, vec![round.into_iter().flatten().collect()], name);
    Ok(a.body("sheet", false))
}
