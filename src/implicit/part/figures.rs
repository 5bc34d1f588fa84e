//! Plane figures: `region(...)`, `rectangle(...)`, and what else is one where set operations ask for it.

use glam::DVec3;
use ruff_python_ast::Operator;
use ruff_text_size::TextRange;

use super::super::expr::Expr;
use super::super::plane::check_plane;
use super::super::polygon::polygon_tree;
use super::super::solid::{Placement, Primitive, Solid, SolidNode};
use super::arguments::{Argument, Bound};
use super::interpreter::Interpreter;
use super::methods;
use super::recipe::{EdgeKind, Edges};
use super::value::Value;
use crate::error::Result;
use crate::spatial::Aabb;

/// All functions of this file.
pub(super) const NAMES: [&str; 2] = ["region", "rectangle"];

/// The circle that stands for the size of an ellipse is this many times as wide.
const ROOM: f64 = 1.25;

type It<'a> = Interpreter<'a>;

/// The figure a value is, if it is one: a region, the inside of a polygon, of a circle or an ellipse in the plane.
pub(super) fn figure(v: &Value<'_>) -> Option<Solid> {
    match v {
        Value::Region(s) => Some(s.clone()),
        Value::Polygon(p) => {
            Some(Primitive::Extrude { polygon: p.to_vec(), height: f64::INFINITY, at: DVec3::ZERO }.into())
        }
        Value::Edges(e) => inside(e),
        _ => None,
    }
}

/// The inside of a whole circle or ellipse that lies in a plane of constant z.
fn inside(edges: &Edges) -> Option<Solid> {
    let [(kind, placement)] = &edges.parts[..] else { return None };
    let EdgeKind::Ellipse { at, axis, x, radii } = &**kind else { return None };
    let solid: Solid = if radii[0] == radii[1] {
        Primitive::Cylinder { r: radii[0], axis: *axis, at: *at, height: None }.into()
    } else {
        // Half axes in the plane; without a direction of its own the first one is along x.
        let u = x.unwrap_or(DVec3::X).with_z(0.0).try_normalize()?;
        let (dx, dy) = (Expr::x() - at.x, Expr::y() - at.y);
        let along = dx.clone() * u.x + dy.clone() * u.y;
        let across = dy * u.x - dx * u.y;
        let square = |e: Expr, r: f64| (e.clone() * e) * (1.0 / (r * r));
        if axis.normalize_or_zero().cross(DVec3::Z).length() > 1e-12 {
            return None;
        }
        let formula = Expr::constant(1.0) - square(along, radii[0]) - square(across, radii[1]);
        // Intervals find no box around a turned ellipse; a circle well outside of it gives one, and bounds nothing.
        let r = ROOM * radii[0].max(radii[1]);
        let around = Primitive::Cylinder { r, axis: DVec3::Z, at: *at, height: None };
        Solid::intersection([Primitive::Formula(formula).into(), around.into()])
    };
    let solid = if *placement == Placement::IDENTITY { solid } else { solid.placed(*placement) };
    check_plane(&solid).ok().map(|()| solid)
}

/// As a figure, where a solid or a condition does as well if it is the same at every z.
fn flat<'a>(it: &It<'a>, range: TextRange, v: &Value<'a>) -> Result<Solid> {
    if let Some(s) = figure(v) {
        return Ok(s);
    }
    let Some(s) = v.solid() else {
        return Err(it
            .error(range, format!("a plane figure is not made of {}", v.kind()))
            .with_help("figures are made by circle, ellipse, rectangle, polygon, and solid(formula of x and y)"));
    };
    it.at(range, check_plane(&s))?;
    Ok(s)
}

/// The figures to be joined, if one of the values is a figure: then all must be.
pub(super) fn joined<'a>(it: &It<'a>, range: TextRange, values: &[Value<'a>]) -> Result<Option<Vec<Solid>>> {
    if !values.iter().any(|v| figure(v).is_some()) {
        return Ok(None);
    }
    values.iter().map(|v| flat(it, range, v)).collect::<Result<_>>().map(Some)
}

/// The operands of a set operation, if one of them is a figure.
pub(super) fn operands<'a>(
    it: &It<'a>,
    range: TextRange,
    op: Operator,
    values: [&Value<'a>; 2],
) -> Result<Option<[Solid; 2]>> {
    let known = matches!(op, Operator::BitAnd | Operator::BitOr | Operator::Sub);
    let other = |v: &Value<'a>| figure(v).is_some() || v.solid().is_some();
    if !known || !values.iter().any(|v| figure(v).is_some()) || !values.iter().all(|v| other(v)) {
        return Ok(None);
    }
    Ok(Some([flat(it, range, values[0])?, flat(it, range, values[1])?]))
}

pub(super) fn call<'a>(
    it: &It<'a>,
    range: TextRange,
    name: &'static str,
    arguments: Vec<Argument<'a>>,
) -> Result<Value<'a>> {
    it.grow(range, 8)?;
    if name == "rectangle" {
        let b = Bound::new(it, name, &["size", "at"], arguments, range)?;
        let a = b.need(it, "size")?;
        let numbers: Option<Vec<f64>> = a.value.items().and_then(|v| v.iter().map(Value::number).collect());
        let half = match numbers.as_deref() {
            Some([x, y]) if *x > 0.0 && *y > 0.0 && x.is_finite() && y.is_finite() => {
                DVec3::new(0.5 * x, 0.5 * y, f64::INFINITY)
            }
            _ => return Err(it.error(a.range, "\"size\" of rectangle() must be two positive numbers (a, b)")),
        };
        let at = b.flat_point(it, "at")?.with_z(0.0);
        return Ok(Value::Region(Primitive::Box { lo: at - half, hi: at + half }.into()));
    }
    let b = Bound::new(it, name, &["figure"], arguments, range)?;
    let a = b.need(it, "figure")?;
    region(it, a).map(Value::Region)
}

/// The figure that an argument is, where a formula is one, too.
fn region<'a>(it: &It<'a>, a: &Argument<'a>) -> Result<Solid> {
    match &a.value {
        Value::Formula(e) => flat(it, a.range, &Value::Solid(Primitive::Formula(e.clone()).into())),
        v => flat(it, a.range, v),
    }
}

/// `extrude(figure, height, at)` and `revolve(figure)`; a list of points is a figure, too.
pub(super) fn raised<'a>(
    it: &It<'a>,
    range: TextRange,
    name: &'static str,
    mut arguments: Vec<Argument<'a>>,
) -> Result<Value<'a>> {
    // Polygons alone have names of faces of their own, and may be called what they are.
    for a in &mut arguments {
        if a.keyword.as_deref() == Some("polygon") {
            a.keyword = Some("figure".into());
        }
    }
    let names: &'static [&'static str] = if name == "extrude" { &["figure", "height", "at"] } else { &["figure"] };
    let b = Bound::new(it, name, names, arguments, range)?;
    let a = b.need(it, "figure")?;
    if !matches!(a.value, Value::Polygon(_)) && a.value.items().is_none() {
        let figure = region(it, a)?;
        it.grow(range, 8)?;
        if name == "revolve" {
            let turned = it.at(a.range, figure.written_turned())?;
            it.grow(range, turned.nodes)?;
            return Ok(Value::Solid(turned.solid));
        }
        let (height, at) = (b.positive(it, "height")?, b.point(it, "at")?);
        let solid = it.at(a.range, figure.extruded(height))?;
        return Ok(Value::Solid(if at == DVec3::ZERO { solid } else { solid.placed(shifted(at)) }));
    }
    let polygon = b.polygon(it, "figure")?;
    it.at(a.range, polygon_tree(&polygon))?;
    it.grow(range, polygon.len())?;
    let primitive = if name == "extrude" {
        Primitive::Extrude { polygon, height: b.positive(it, "height")?, at: b.point(it, "at")? }
    } else {
        if let Some(i) = polygon.iter().position(|p| p[0] < 0.0) {
            return Err(it.error(a.range, format!("point {i} of the turned polygon has a negative radius")));
        }
        Primitive::Revolve { polygon }
    };
    Ok(Value::Solid(primitive.into()))
}

fn shifted(by: DVec3) -> Placement {
    Placement { shift: by, ..Placement::IDENTITY }
}

/// Methods of figures: those of solids, as long as they keep the plane.
pub(super) fn method<'a>(
    it: &It<'a>,
    range: TextRange,
    s: Solid,
    method: &'static str,
    arguments: Vec<Argument<'a>>,
) -> Result<Value<'a>> {
    if method == "move" {
        let b = Bound::new(it, method, &["by"], arguments, range)?;
        b.need(it, "by")?;
        let shift = b.flat_point(it, "by")?;
        it.grow(range, 1)?;
        return Ok(Value::Region(s.placed(shifted(shift))));
    }
    let made = methods::placed(it, range, s, method, arguments)?;
    if let SolidNode::Placed(p, _) = made.node()
        && p.turn(DVec3::Z).cross(DVec3::Z).length() > 1e-12
    {
        return Err(it.error(range, format!(".{method}() would take the figure out of its plane")));
    }
    Ok(Value::Region(made))
}

/// Where a figure is cut off: two points of the plane, or of space, whose z does not matter.
pub(super) fn domain<'a>(it: &It<'a>, a: &Argument<'a>) -> Result<Aabb> {
    let point = |v: &Value<'a>| -> Option<DVec3> {
        let n: Vec<f64> = v.items()?.iter().map(Value::number).collect::<Option<_>>()?;
        let [x, y] = n.get(..2)? else { return None };
        (n.len() <= 3 && n.iter().all(|x| x.is_finite())).then(|| DVec3::new(*x, *y, 0.0))
    };
    let ends = match a.value.items() {
        Some([lo, hi]) => point(lo).zip(point(hi)),
        _ => None,
    };
    match ends {
        Some((lo, hi)) if lo.x < hi.x && lo.y < hi.y => Ok(Aabb::new(lo - DVec3::Z, hi + DVec3::Z)),
        Some(_) => Err(it.error(a.range, "a domain needs lo < hi in both coordinates")),
        None => Err(it.error(a.range, "the domain of a plane figure is two points: ((x0, y0), (x1, y1))")),
    }
}
