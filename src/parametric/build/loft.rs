//! Surfaces through sections: smooth (\[KUZ19\] section 2.4.3) or ruled (\[KUZ19\] 34), from contour to contour and to points.

use glam::{DVec3, DVec4};

use super::assembly::{Along, Assembly, BodyChain, Side, side_by_foot};
use super::wire::{Piece, Wire, refuse};
use crate::error::Result;
use crate::numeric::EIGHT_DIGITS;
use crate::parametric::brep::Brep;
use crate::parametric::curve::Curve;
use crate::parametric::frame::Frame;
use crate::parametric::nurbs::{EndSlopes, NurbsCurve, NurbsSurface, compatible};
use crate::parametric::surface::Surface;

/// Slope of a round end: a cubic that starts with this many times its way to the side is next to a quarter of an ellipse.
const ROUND: f64 = 1.656_854_249_492_380_5;

/// What a loft passes through.
#[derive(Debug, Clone, PartialEq)]
pub enum Section {
    /// A chain of edges.
    Wire(Wire),
    /// A point, at an end: the pole of all faces.
    Point(DVec3),
}

impl Section {
    fn wire(&self) -> Option<&Wire> {
        match self {
            Section::Wire(w) => Some(w),
            Section::Point(_) => None,
        }
    }

    fn center(&self) -> DVec3 {
        match self {
            Section::Wire(w) => w.bounds().center(),
            Section::Point(p) => *p,
        }
    }
}

/// How sections are joined.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Loft {
    /// Straight from section to section, with an edge at each, instead of smooth.
    pub ruled: bool,
    /// Whether contours at the ends are closed by flat faces, which makes a solid.
    pub caps: bool,
    /// Whether a point at the start, at the end, is round as the pole of an ellipsoid, not pointed. Smooth lofts only.
    pub round: [bool; 2],
    /// Whether the sides leave a contour at the start, arrive at one at the end, square to its plane. Smooth lofts only.
    pub square: [bool; 2],
}

impl Default for Loft {
    fn default() -> Self {
        Self { ruled: false, caps: true, round: [false; 2], square: [false; 2] }
    }
}

/// Joins sections to a solid or a sheet.
///
/// Sections have the same number of edges each; edge `i` of one goes to edge `i` of the next, so closed ones should start
/// at like places. Closed sections are turned to run the same way round. Faces are called `side` (with a number where there
/// are several; `layer1.side` and so on between sections where `ruled`), `start` and `end`.
///
/// Errors: fewer than two sections, points elsewhere than at the ends or nothing else, sections with different numbers of
/// edges or at one place; with caps, an open section (the gap is named) or one at an end that is not flat.
pub fn loft(sections: &[Section], how: &Loft) -> Result<Brep> {
    let sections = arranged(sections, how.caps)?;
    let mut a = Assembly::default();
    let count = sections.iter().filter_map(Section::wire).map(|w| w.pieces().len()).next().unwrap_or(0);
    let border = |a: &mut Assembly, s: &Section| match s {
        Section::Wire(w) => a.border(w),
        Section::Point(p) => BodyChain { edges: vec![None; count], vertices: vec![a.vertex(*p)] },
    };
    let n = sections.len();
    let first = border(&mut a, &sections[0]);
    let mut last = first.clone();
    if how.ruled {
        for (j, pair) in sections.windows(2).enumerate() {
            let to = border(&mut a, &pair[1]);
            let name = if n == 2 { "side".to_string() } else { format!("layer{}.side", j + 1) };
            straight(&mut a, pair, [&last, &to], &name)?;
            last = to;
        }
    } else {
        last = border(&mut a, &sections[n - 1]);
        smooth(&mut a, &sections, [&first, &last], how)?;
    }
    if how.caps {
        for (s, b, forward, name) in [(&sections[0], first, false, "start"), (&sections[n - 1], last, true, "end")] {
            if let Section::Wire(w) = s {
                a.cap(std::slice::from_ref(w), &[b], forward, name)?;
            }
        }
    }
    Ok(a.body("loft", how.caps))
}

/// The sheet of straight lines between two chains of edges.
pub fn ruled(a: &Wire, b: &Wire) -> Result<Brep> {
    let sections = [Section::Wire(a.clone()), Section::Wire(b.clone())];
    Ok(loft(&sections, &Loft { ruled: true, caps: false, ..Loft::default() })?.named("ruled"))
}

/// Checks sections, and turns closed ones to run counter-clockwise around the way from one to the next.
fn arranged(sections: &[Section], caps: bool) -> Result<Vec<Section>> {
    let n = sections.len();
    if n < 2 {
        return refuse("a loft needs two sections");
    }
    let Some(model) = sections.iter().find_map(Section::wire) else {
        return refuse("a loft needs a section that is not a point");
    };
    let mut out = sections.to_vec();
    for (i, s) in sections.iter().enumerate() {
        let Section::Wire(w) = s else {
            if i > 0 && i + 1 < n {
                return refuse(format!("section {} of the loft is a point, but not at an end", i + 1));
            }
            continue;
        };
        if w.pieces().len() != model.pieces().len() || w.is_closed() != model.is_closed() {
            return refuse(format!(
                "section {} of the loft has {} edges and is {}, others have {} and are {}",
                i + 1,
                w.pieces().len(),
                if w.is_closed() { "closed" } else { "open" },
                model.pieces().len(),
                if model.is_closed() { "closed" } else { "open" },
            ));
        }
        if let (true, Some(gap)) = (caps, w.gap()) {
            return refuse(format!("a solid needs closed contours; section {} has {gap}", i + 1));
        }
        let way = sections[(i + 1).min(n - 1)].center() - sections[i.saturating_sub(1)].center();
        if w.is_closed() && w.area_vector().dot(way) < 0.0 {
            out[i] = Section::Wire(w.reversed());
        }
    }
    Ok(out)
}

/// Piece `i` of every section as NURBS with the same knots; points are pieces that stand still.
fn curves(sections: &[Section], i: usize) -> Result<Vec<NurbsCurve>> {
    let known: Result<Vec<NurbsCurve>> =
        sections.iter().filter_map(Section::wire).map(|w| w.pieces()[i].to_nurbs()).collect();
    let known = compatible(&known?)?;
    let n = known.len();
    let mut out = known.clone();
    if let Section::Point(p) = sections[0] {
        out.insert(0, known[0].map(|_| p));
    }
    if let Some(Section::Point(p)) = sections.last() {
        out.push(known[n - 1].map(|_| *p));
    }
    Ok(out)
}

fn smooth(a: &mut Assembly, sections: &[Section], [from, to]: [&BodyChain; 2], how: &Loft) -> Result<()> {
    let count = from.edges.len();
    let all: Result<Vec<Vec<NurbsCurve>>> = (0..count).map(|i| curves(sections, i)).collect();
    let all = all?;
    // One parameter for all faces: mean distances of control points, from section to section.
    let n = sections.len();
    let mut t = vec![0.0];
    for j in 1..n {
        let gaps = all.iter().flat_map(|c| c[j - 1].control().zip(c[j].control()).collect::<Vec<_>>());
        let (sum, number) = gaps.fold((0.0, 0.0), |(s, n), (p, q)| (s + p.distance(q), n + 1.0));
        t.push(t[j - 1] + sum / number);
        if !(t[j] > t[j - 1]) {
            return refuse(format!("sections {j} and {} of the loft are at one place", j + 1));
        }
    }
    let length = t[n - 1];
    t.iter_mut().for_each(|x| *x /= length);
    t[n - 1] = 1.0;
    let mut surfaces = Vec::new();
    for c in &all {
        let mut slopes: EndSlopes = [None, None];
        for (k, slope) in slopes.iter_mut().enumerate() {
            let (tip, next) = if k == 0 { (0, 1) } else { (n - 1, n - 2) };
            if how.round[k] && matches!(sections[tip], Section::Point(_)) {
                let step = t[next] - t[tip];
                *slope = Some(round(&c[next], sections[tip].center(), sections[next].center(), step));
            }
            if let (true, Section::Wire(w)) = (how.square[k], &sections[tip]) {
                let way = sections[n - 1].center() - sections[0].center();
                let far = sections[next].center().distance(sections[tip].center());
                let normal = w.area_vector().normalize_or_zero();
                let along = normal * normal.dot(way).signum() * (far / (t[next] - t[tip]).abs());
                *slope = Some(c[tip].weighted().iter().map(|p| (along * p.w).extend(0.0)).collect());
            }
        }
        surfaces.push(NurbsSurface::through(c, &t, &slopes)?);
    }
    let rails = rails(a, &surfaces, [from, to])?;
    let sides = surfaces.into_iter().map(|s| Some((Surface::Nurbs(s), true))).collect();
    let Some(model) = sections.iter().find_map(Section::wire) else { return Ok(()) };
    a.strip(model, [from, to], &rails, sides, "side");
    Ok(())
}

/// Slopes that leave a tip to all sides, square to the way to the next section.
fn round(next: &NurbsCurve, tip: DVec3, center: DVec3, step: f64) -> Vec<DVec4> {
    let axis = (center - tip).normalize_or_zero();
    let side = |p: DVec3| {
        let d = p - tip;
        (d - axis * d.dot(axis)) * (ROUND / step)
    };
    next.weighted().iter().map(|p| (side(p.truncate() / p.w) * p.w).extend(0.0)).collect()
}

/// The edges between neighboring faces: the rims of their surfaces.
pub(super) fn rails(a: &mut Assembly, surfaces: &[NurbsSurface], [from, to]: [&BodyChain; 2]) -> Result<Vec<Along>> {
    let count = surfaces.len();
    let corners = from.vertices.len().max(to.vertices.len());
    let closed = corners <= count;
    let mut out = Vec::new();
    for i in 0..corners {
        let rim = if i < count { surfaces[i].rim(0)? } else { surfaces[i - 1].rim(1)? };
        if i > 0 && i < count || closed {
            let other = surfaces[(i + count - 1) % count].rim(1)?;
            let size = crate::spatial::Aabb::around(rim.control()).diagonal();
            let [x, y] = rim.knots.domain();
            for k in 0..=8 {
                let v = x + (y - x) * f64::from(k) / 8.0;
                let (p, q) = (rim.jet(v)[0], other.jet(v)[0]);
                // Rims of neighboring faces may differ by a little.
                if p.distance(q) > EIGHT_DIGITS * size {
                    return refuse(format!(
                        "neighboring faces of the loft part at {p}: the edges' weights differ there"
                    ));
                }
            }
        }
        let range = rim.knots.domain();
        out.push(a.edge(Curve::Nurbs(rim), range, [from.vertex(i), to.vertex(i)]));
    }
    Ok(out)
}

fn straight(a: &mut Assembly, pair: &[Section], [from, to]: [&BodyChain; 2], name: &str) -> Result<()> {
    let corners = from.vertices.len().max(to.vertices.len());
    let rails: Vec<Along> = (0..corners)
        .map(|i| {
            let ends = [from.vertex(i), to.vertex(i)];
            let [p, q] = ends.map(|v| a.brep.vertices[v as usize]);
            a.edge(Curve::segment(p, q), [0.0, 1.0], ends)
        })
        .collect();
    let mut sides: Vec<Side> = Vec::new();
    for i in 0..from.edges.len() {
        let pieces: Vec<&Piece> = pair.iter().filter_map(Section::wire).map(|w| &w.pieces()[i]).collect();
        let lines = pieces.iter().all(|p| matches!(p.curve, Curve::Line { .. }));
        if lines && along_one_line(pair, i) {
            return refuse(format!("edge {} of both sections lies along one line: no face is between", i + 1));
        }
        if let (true, Some(plane)) = (lines, plane(pair, i)) {
            sides.push(plane);
            continue;
        }
        let c = curves(pair, i)?;
        let gap: f64 = c[0].control().zip(c[1].control()).map(|(p, q)| p.distance(q)).fold(0.0, f64::max);
        if !(gap > 0.0) {
            return refuse("two sections of the loft are at one place");
        }
        sides.push(Some((Surface::Nurbs(NurbsSurface::through(&c, &[0.0, 1.0], &[None, None])?), true)));
    }
    let Some(model) = pair.iter().find_map(Section::wire) else { return Ok(()) };
    a.strip(model, [from, to], &rails, sides, name);
    Ok(())
}

/// The ends of edge `i` of a section.
fn ends(s: &Section, i: usize) -> [DVec3; 2] {
    match s {
        Section::Wire(w) => [w.pieces()[i].at(0.0), w.pieces()[i].at(1.0)],
        Section::Point(p) => [*p, *p],
    }
}

/// Whether two straight edges, or one and a point, lie on one line.
fn along_one_line(pair: &[Section], i: usize) -> bool {
    let ([a, b], [c, d]) = (ends(&pair[0], i), ends(&pair[1], i));
    let long = [b - a, c - a, d - a].into_iter().max_by(|x, y| x.length().total_cmp(&y.length())).unwrap_or_default();
    let way = long.normalize_or_zero();
    [b, c, d].iter().all(|p| (*p - a).cross(way).length() <= 1e-12 * long.length())
}

/// The plane through two straight edges, or one and a point, where there is one.
fn plane(pair: &[Section], i: usize) -> Option<Side> {
    let ([a, b], [c, d]) = (ends(&pair[0], i), ends(&pair[1], i));
    let out = (b - a + d - c).cross(c - a + d - b).try_normalize()?;
    let size = crate::spatial::Aabb::around([a, b, c, d]).diagonal();
    let m = 0.25 * (a + b + c + d);
    let flat = [a, b, c, d].iter().all(|p| (*p - m).dot(out).abs() <= 1e-12 * size);
    let x = if a == b { d - c } else { b - a };
    flat.then(|| side_by_foot(Surface::Plane { frame: Frame::new(a, out, Some(x)) }, m, out))
}
