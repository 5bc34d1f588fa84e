//! Functions of the part file that make arcs of conics, polynomials and NURBS curves.

use glam::{DVec2, DVec3};
use ruff_text_size::TextRange;

use super::arguments::{Argument, Bound};
use super::edges::{edge, point, points};
use super::interpreter::Interpreter;
use super::recipe::EdgeKind;
use super::value::Value;
use crate::error::Result;

/// All functions of this file.
pub(super) const NAMES: [&str; 6] = ["parabola", "hyperbola", "conic", "polynomial", "lagrange", "nurbs"];

type It<'a> = Interpreter<'a>;

/// A list of finite numbers; `None` where it was left out.
pub(super) fn numbers<'a>(it: &It<'a>, b: &Bound<'a>, name: &str) -> Result<Option<Vec<f64>>> {
    let Some(a) = b.get(name) else { return Ok(None) };
    let items = a.value.items().unwrap_or_default();
    it.grow(a.range, items.len())?;
    let list: Vec<f64> = items.iter().filter_map(Value::number).filter(|x| x.is_finite()).collect();
    if list.is_empty() || list.len() != items.len() {
        return Err(it.error(a.range, format!("{name:?} must be a list of finite numbers")));
    }
    Ok(Some(list))
}

/// Positive weights, one for each of `count` things.
pub(super) fn weights<'a>(it: &It<'a>, b: &Bound<'a>, count: usize) -> Result<Option<Vec<f64>>> {
    let Some(a) = b.get("weights") else { return Ok(None) };
    match numbers(it, b, "weights")? {
        Some(w) if w.len() == count && w.iter().all(|w| *w > 0.0) => Ok(Some(w)),
        _ => Err(it.error(a.range, format!("weights are positive numbers, one for each of {count}"))),
    }
}

/// A degree for `count` control points: cubic, or what they allow, where it was left out.
pub(super) fn degree<'a>(it: &It<'a>, b: &Bound<'a>, name: &str, count: usize) -> Result<usize> {
    let Some(a) = b.get(name) else { return Ok(count.saturating_sub(1).clamp(1, 3)) };
    match a.value.number() {
        Some(d) if d >= 1.0 && d.fract() == 0.0 && d < count as f64 && d <= 25.0 => Ok(d as usize),
        _ => Err(it.error(
            a.range,
            format!("{name:?} must be a whole number from 1 to 25 and below the number of control points, {count}"),
        )),
    }
}

/// Knots for `count` control points.
pub(super) fn knots<'a>(it: &It<'a>, b: &Bound<'a>, name: &str, needed: usize) -> Result<Option<Vec<f64>>> {
    let Some(a) = b.get(name) else { return Ok(None) };
    match numbers(it, b, name)? {
        Some(k) if k.len() == needed && k.windows(2).all(|w| w[0] <= w[1]) => Ok(Some(k)),
        Some(k) => Err(it.error(
            a.range,
            format!(
                "{name:?} must be {needed} numbers that do not fall (control points + degree + 1), not {}",
                k.len()
            ),
        )),
        None => Ok(None),
    }
}

/// A list of pairs of a parameter and a point or direction; empty where it was left out.
fn at_parameters<'a>(it: &It<'a>, b: &Bound<'a>, name: &str) -> Result<Vec<(f64, DVec3)>> {
    let Some(a) = b.get(name) else { return Ok(Vec::new()) };
    let items = a.value.items().unwrap_or_default();
    it.grow(a.range, items.len())?;
    let pair = |v: &Value<'a>| match v.items()? {
        [t, p] => Some((t.number().filter(|t| t.is_finite())?, point(p)?)),
        _ => None,
    };
    let list: Vec<(f64, DVec3)> = items.iter().filter_map(pair).collect();
    if list.is_empty() || list.len() != items.len() {
        return Err(it.error(a.range, format!("{name:?} must be a list of pairs (parameter, (x, y, z))")));
    }
    Ok(list)
}

fn flat(it: &It<'_>, b: &Bound<'_>, name: &str) -> Result<Option<DVec2>> {
    let Some(a) = b.get(name) else { return Ok(None) };
    let n: Vec<f64> = a.value.items().unwrap_or_default().iter().filter_map(Value::number).collect();
    match n[..] {
        [x, y] if x.is_finite() && y.is_finite() => Ok(Some(DVec2::new(x, y))),
        _ => Err(it.error(a.range, format!("{name:?} must be a point (x, y)"))),
    }
}

/// The arc's ends across the axis, which must differ.
fn across<'a>(it: &It<'a>, b: &Bound<'a>) -> Result<[f64; 2]> {
    let ends = [b.number(it, "start")?, b.number(it, "end")?];
    if ends[0] == ends[1] {
        return Err(it.error(b.need(it, "end")?.range, "the arc starts and ends at one place"));
    }
    Ok(ends)
}

pub(super) fn call<'a>(
    it: &It<'a>,
    range: TextRange,
    name: &'static str,
    arguments: Vec<Argument<'a>>,
) -> Result<Value<'a>> {
    it.grow(range, 1)?;
    let bind = |names| Bound::new(it, name, names, arguments, range);
    let x = |b: &Bound<'a>| -> Result<Option<DVec3>> { b.get("x").is_some().then(|| b.axis(it, "x")).transpose() };
    match name {
        "parabola" => {
            let b = bind(&["focal", "start", "end", "at", "axis", "x"])?;
            let (focal, across) = (b.positive(it, "focal")?, across(it, &b)?);
            edge(EdgeKind::Parabola {
                at: b.flat_point(it, "at")?,
                axis: b.axis(it, "axis")?,
                x: x(&b)?,
                focal,
                across,
            })
        }
        "hyperbola" => {
            let b = bind(&["a", "b", "start", "end", "at", "axis", "x"])?;
            let radii = [b.positive(it, "a")?, b.positive(it, "b")?];
            let across = across(it, &b)?;
            edge(EdgeKind::Hyperbola {
                at: b.flat_point(it, "at")?,
                axis: b.axis(it, "axis")?,
                x: x(&b)?,
                radii,
                across,
            })
        }
        "conic" => {
            let b = bind(&["coefficients", "start", "end"])?;
            let a = b.need(it, "coefficients")?;
            let Some(Ok(coefficients)) = numbers(it, &b, "coefficients")?.map(<[f64; 6]>::try_from) else {
                return Err(it.error(
                    a.range,
                    "coefficients are six numbers A, B, C, D, E, F of A x^2 + B x y + C y^2 + D x + E y + F = 0",
                ));
            };
            let ends = match (flat(it, &b, "start")?, flat(it, &b, "end")?) {
                (Some(s), Some(e)) => Some([s, e]),
                (None, None) => None,
                _ => return Err(it.error(range, "a conic has both a start and an end, or none and is whole")),
            };
            edge(EdgeKind::Conic { coefficients, ends })
        }
        "polynomial" => {
            let b = bind(&["coefficients", "start", "end"])?;
            let coefficients = points(it, &b, "coefficients")?;
            let ends = [b.number(it, "start")?, b.number(it, "end")?];
            if !(ends[0] < ends[1]) {
                return Err(it.error(b.need(it, "end")?.range, "the parameter must rise from \"start\" to \"end\""));
            }
            edge(EdgeKind::Polynomial { coefficients, range: ends })
        }
        "lagrange" => {
            let b = bind(&["points", "parameters"])?;
            let list = points(it, &b, "points")?;
            let parameters = numbers(it, &b, "parameters")?;
            if let (Some(t), Some(a)) = (&parameters, b.get("parameters"))
                && (t.len() != list.len() || t.windows(2).any(|w| !(w[0] < w[1])))
            {
                return Err(it.error(a.range, "parameters are ascending numbers, one for each point"));
            }
            let parameters = parameters.unwrap_or_else(|| (0..list.len()).map(|i| i as f64).collect());
            edge(EdgeKind::Lagrange { points: list, parameters })
        }
        _ => {
            let b = bind(&["points", "degree", "knots", "weights", "through", "tangents"])?;
            let list = points(it, &b, "points")?;
            let n = list.len();
            let degree = degree(it, &b, "degree", n)?;
            let (knots, weights) = (knots(it, &b, "knots", n + degree + 1)?, weights(it, &b, n)?);
            let (through, tangents) = (at_parameters(it, &b, "through")?, at_parameters(it, &b, "tangents")?);
            edge(EdgeKind::Nurbs { points: list, degree, knots, weights, through, tangents })
        }
    }
}
