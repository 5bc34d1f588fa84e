//! Functions of the part file that make sheets of free form.

use glam::DVec3;
use ruff_text_size::TextRange;

use super::arguments::{Argument, Bound};
use super::curves::{degree, knots, weights};
use super::edges::{chain, chains, optional, point, recipe, truth};
use super::interpreter::Interpreter;
use super::recipe::{Build, EdgeKind, Edges, Net, SectionRecipe, Sheet};
use super::value::Value;
use crate::error::Result;

/// All functions of this file.
pub(super) const NAMES: [&str; 8] = [
    "bilinear",
    "sectorial",
    "shift",
    "hermite",
    "spline_surface",
    "fillet_surface",
    "bezier_surface",
    "nurbs_surface",
];

type It<'a> = Interpreter<'a>;

/// Straight lines between two sections.
fn straight(sections: [SectionRecipe; 2]) -> Build {
    Build::Loft { sections: sections.to_vec(), ruled: true, round: [false; 2], square: [false; 2], solid: false }
}

/// Chains for a surface that needs so many.
fn family<'a>(it: &It<'a>, b: &Bound<'a>, least: usize) -> Result<Vec<Edges>> {
    let all = chains(it, b, "curves")?;
    if all.len() < least {
        let a = b.need(it, "curves")?;
        return Err(it.error(a.range, format!("\"curves\" must be a list of {least} chains of edges or more")));
    }
    Ok(all)
}

/// Control points: rows of as many points each.
fn net<'a>(it: &It<'a>, b: &Bound<'a>) -> Result<[usize; 2]> {
    let a = b.need(it, "net")?;
    let rows = a.value.items().unwrap_or_default();
    let columns = rows.first().and_then(Value::items).map_or(0, <[_]>::len);
    let even = rows.iter().all(|r| r.items().is_some_and(|r| r.len() == columns));
    if rows.len() < 2 || columns < 2 || !even {
        return Err(
            it.error(a.range, "\"net\" must be two rows or more of control points, as many in each, two or more")
        );
    }
    it.grow(a.range, rows.len() * columns)?;
    Ok([rows.len(), columns])
}

fn net_points<'a>(it: &It<'a>, b: &Bound<'a>) -> Result<Vec<DVec3>> {
    let a = b.need(it, "net")?;
    let mut out = Vec::new();
    for (i, row) in a.value.items().unwrap_or_default().iter().enumerate() {
        for (j, v) in row.items().unwrap_or_default().iter().enumerate() {
            let p = point(v).ok_or_else(|| {
                it.error(a.range, format!("point {j} of row {i} must be two or three finite numbers"))
            })?;
            out.push(p);
        }
    }
    Ok(out)
}

fn net_weights<'a>(it: &It<'a>, b: &Bound<'a>, [rows, columns]: [usize; 2]) -> Result<Option<Vec<f64>>> {
    let Some(a) = b.get("weights") else { return Ok(None) };
    it.grow(a.range, rows * columns)?;
    let lists: Vec<&[Value<'a>]> = a.value.items().unwrap_or_default().iter().filter_map(Value::items).collect();
    let all: Vec<f64> = lists.iter().flat_map(|r| r.iter().filter_map(Value::number)).collect();
    let fits = lists.len() == rows && lists.iter().all(|r| r.len() == columns) && all.len() == rows * columns;
    if !fits || !all.iter().all(|w| *w > 0.0 && w.is_finite()) {
        return Err(it.error(a.range, "weights are rows of positive numbers, one for each control point"));
    }
    Ok(Some(all))
}

pub(super) fn call<'a>(
    it: &It<'a>,
    range: TextRange,
    name: &'static str,
    arguments: Vec<Argument<'a>>,
) -> Result<Value<'a>> {
    it.grow(range, 1)?;
    let bind = |names| Bound::new(it, name, names, arguments, range);
    let build = match name {
        "bilinear" => {
            let b = bind(&["p00", "p10", "p01", "p11"])?;
            let mut p = [DVec3::ZERO; 4];
            for (p, name) in p.iter_mut().zip(["p00", "p10", "p01", "p11"]) {
                b.need(it, name)?;
                *p = b.flat_point(it, name)?;
            }
            if let Some([i, j]) = [[0, 1], [2, 3], [0, 2], [1, 3]].iter().find(|[i, j]| p[*i] == p[*j]) {
                let names = ["p00", "p10", "p01", "p11"];
                let what = format!("{:?} and {:?} are one point", names[*i], names[*j]);
                return Err(it
                    .error(range, what)
                    .with_help("for a triangle take flat_face(polyline([...], closed=True))"));
            }
            let side = |i: usize, j: usize| SectionRecipe::Edges(Edges::one(EdgeKind::Polyline(vec![p[i], p[j]])));
            straight([side(0, 1), side(2, 3)])
        }
        "sectorial" => {
            let b = bind(&["curve", "point"])?;
            b.need(it, "point")?;
            straight([SectionRecipe::Edges(chain(it, &b, "curve")?), SectionRecipe::Point(b.flat_point(it, "point")?)])
        }
        "shift" => {
            let b = bind(&["profile", "path", "offset"])?;
            let offset = optional(it, &b, "offset")?.unwrap_or(DVec3::ZERO);
            Build::Sheet(Sheet::Shift { profile: chain(it, &b, "profile")?, path: chain(it, &b, "path")?, offset })
        }
        "hermite" => {
            let b = bind(&["curves", "closed"])?;
            let closed = truth(it, &b, "closed", false)?;
            let curves = family(it, &b, if closed { 3 } else { 2 })?;
            Build::Sheet(Sheet::Hermite { curves, closed })
        }
        "spline_surface" => {
            let b = bind(&["curves", "degree", "knots", "weights"])?;
            let curves = family(it, &b, 2)?;
            let n = curves.len();
            let degree = degree(it, &b, "degree", n)?;
            let (knots, weights) = (knots(it, &b, "knots", n + degree + 1)?, weights(it, &b, n)?);
            Build::Sheet(Sheet::Spline { curves, degree, knots, weights })
        }
        "fillet_surface" => {
            let b = bind(&["start", "apex", "end"])?;
            let three = [chain(it, &b, "start")?, chain(it, &b, "apex")?, chain(it, &b, "end")?];
            Build::Sheet(Sheet::Fillet(Box::new(three)))
        }
        "bezier_surface" => {
            let b = bind(&["net", "weights"])?;
            let size = net(it, &b)?;
            if let Some(n) = size.iter().find(|n| **n > 26) {
                let a = b.need(it, "net")?;
                return Err(
                    it.error(a.range, format!("a Bézier surface has 26 control points a side at most, not {n}"))
                );
            }
            let (points, weights) = (net_points(it, &b)?, net_weights(it, &b, size)?);
            Build::Sheet(Sheet::Nurbs(Net { points, weights, size, degrees: size.map(|n| n - 1), knots: [None, None] }))
        }
        _ => {
            let b = bind(&["net", "degree_u", "degree_v", "knots_u", "knots_v", "weights"])?;
            let size = net(it, &b)?;
            let (points, weights) = (net_points(it, &b)?, net_weights(it, &b, size)?);
            let degrees = [degree(it, &b, "degree_u", size[0])?, degree(it, &b, "degree_v", size[1])?];
            let knots = [
                knots(it, &b, "knots_u", size[0] + degrees[0] + 1)?,
                knots(it, &b, "knots_v", size[1] + degrees[1] + 1)?,
            ];
            Build::Sheet(Sheet::Nurbs(Net { points, weights, size, degrees, knots }))
        }
    };
    Ok(recipe(it, range, build, 0))
}
