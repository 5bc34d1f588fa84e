//! Functions of the part file that make edges, and say how solids are built from them.

use std::rc::Rc;

use glam::{DMat3, DVec3};
use ruff_text_size::TextRange;

use super::super::solid::Placement;
use super::arguments::{Argument, Bound};
use super::interpreter::Interpreter;
use super::methods;
use super::recipe::{Build, DEEPEST, EdgeKind, Edges, Recipe, SectionRecipe};
use super::value::Value;
use crate::error::Result;

/// All functions of this file.
pub(super) const NAMES: [&str; 14] = [
    "polyline",
    "spline",
    "bezier",
    "arc",
    "circle",
    "ellipse",
    "chain",
    "extrude_edges",
    "revolve_edges",
    "loft",
    "ruled",
    "sweep_edges",
    "flat_face",
    "sew",
];

type It<'a> = Interpreter<'a>;

pub(super) fn point(v: &Value<'_>) -> Option<DVec3> {
    let items = v.items()?;
    let n: Vec<f64> = items.iter().filter_map(Value::number).filter(|x| x.is_finite()).collect();
    match n[..] {
        [x, y] if items.len() == 2 => Some(DVec3::new(x, y, 0.0)),
        [x, y, z] if items.len() == 3 => Some(DVec3::new(x, y, z)),
        _ => None,
    }
}

pub(super) fn points<'a>(it: &It<'a>, b: &Bound<'a>, name: &str) -> Result<Vec<DVec3>> {
    let a = b.need(it, name)?;
    let Some(items) = a.value.items() else {
        return Err(it.error(a.range, format!("{name:?} must be a list of points (x, y, z), not {}", a.value.kind())));
    };
    it.grow(a.range, items.len())?;
    let one = |(i, v): (usize, &Value<'a>)| {
        point(v).ok_or_else(|| it.error(a.range, format!("point {i} must be two or three finite numbers")))
    };
    items.iter().enumerate().map(one).collect()
}

pub(super) fn truth(it: &It<'_>, b: &Bound<'_>, name: &str, default: bool) -> Result<bool> {
    match b.get(name) {
        None => Ok(default),
        Some(Argument { value: Value::Bool(t), .. }) => Ok(*t),
        Some(a) => Err(it.error(a.range, format!("{name:?} must be True or False, not {}", a.value.kind()))),
    }
}

pub(super) fn optional<'a>(it: &It<'a>, b: &Bound<'a>, name: &str) -> Result<Option<DVec3>> {
    b.get(name).is_some().then(|| b.vector(it, name)).transpose()
}

fn number<'a>(it: &It<'a>, b: &Bound<'a>, name: &str, default: f64) -> Result<f64> {
    if b.get(name).is_some() { b.number(it, name) } else { Ok(default) }
}

/// One chain of edges.
pub(super) fn chain<'a>(it: &It<'a>, b: &Bound<'a>, name: &str) -> Result<Edges> {
    let a = b.need(it, name)?;
    match &a.value {
        Value::Edges(e) => Ok((**e).clone()),
        other => Err(it
            .error(a.range, format!("{name:?} must be edges, not {}", other.kind()))
            .with_help("edges are made by polyline, spline, bezier, nurbs, arc, circle, ellipse and others; chain([...]) joins them")),
    }
}

/// One chain of edges, or a list of them: the first is the outer border, the others are holes.
pub(super) fn chains<'a>(it: &It<'a>, b: &Bound<'a>, name: &str) -> Result<Vec<Edges>> {
    let a = b.need(it, name)?;
    let Some(items) = a.value.items() else { return Ok(vec![chain(it, b, name)?]) };
    it.grow(a.range, items.len())?;
    let one = |v: &Value<'a>| match v {
        Value::Edges(e) => Ok((**e).clone()),
        other => Err(it.error(a.range, format!("{name:?} must be a list of edges, not of {}", other.kind()))),
    };
    items.iter().map(one).collect()
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
        "polyline" => {
            let b = bind(&["points", "closed"])?;
            let mut list = points(it, &b, "points")?;
            if truth(it, &b, "closed", false)? && list.first() != list.last() {
                list.extend(list.first().copied());
            }
            return edge(EdgeKind::Polyline(list));
        }
        "spline" => {
            let b = bind(&["points", "closed", "start", "end", "ends"])?;
            let (list, closed) = (points(it, &b, "points")?, truth(it, &b, "closed", false)?);
            let ends = match (optional(it, &b, "start")?, optional(it, &b, "end")?) {
                (Some(s), Some(e)) if !closed => Some([s, e]),
                (None, None) => None,
                _ => {
                    return Err(
                        it.error(range, "a spline has derivatives at both ends or at none, and a closed one none")
                    );
                }
            };
            let parabolic = match b.get("ends") {
                None => false,
                Some(a) => match &a.value {
                    Value::Str(s) if &**s == "natural" => false,
                    Value::Str(s) if &**s == "parabolic" && ends.is_none() && !closed => true,
                    _ => {
                        return Err(it.error(
                            a.range,
                            "\"ends\" is \"natural\", or \"parabolic\" for an open spline without derivatives at its ends",
                        ));
                    }
                },
            };
            return edge(EdgeKind::Spline { points: list, closed, ends, parabolic });
        }
        "bezier" => {
            let b = bind(&["points", "weights"])?;
            let list = points(it, &b, "points")?;
            let weights = match b.get("weights") {
                None => None,
                Some(a) => {
                    let w: Vec<f64> = a.value.items().unwrap_or_default().iter().filter_map(Value::number).collect();
                    if w.len() != list.len() || !w.iter().all(|w| *w > 0.0 && w.is_finite()) {
                        return Err(it.error(a.range, "weights are positive numbers, one for each point"));
                    }
                    Some(w)
                }
            };
            return edge(EdgeKind::Bezier { points: list, weights });
        }
        "arc" => {
            let b = bind(&["start", "through", "end"])?;
            return edge(EdgeKind::Arc([b.vector(it, "start")?, b.vector(it, "through")?, b.vector(it, "end")?]));
        }
        "circle" => {
            let b = bind(&["r", "at", "axis"])?;
            let r = b.positive(it, "r")?;
            let (at, axis) = (b.flat_point(it, "at")?, b.axis(it, "axis")?);
            return edge(EdgeKind::Ellipse { at, axis, x: None, radii: [r, r] });
        }
        "ellipse" => {
            let b = bind(&["a", "b", "at", "axis", "x"])?;
            let radii = [b.positive(it, "a")?, b.positive(it, "b")?];
            let x = b.get("x").is_some().then(|| b.axis(it, "x")).transpose()?;
            return edge(EdgeKind::Ellipse { at: b.flat_point(it, "at")?, axis: b.axis(it, "axis")?, x, radii });
        }
        "chain" => {
            let b = bind(&["edges"])?;
            let parts: Vec<_> = chains(it, &b, "edges")?.into_iter().flat_map(|e| e.parts).collect();
            it.grow(range, parts.len())?;
            return Ok(Value::Edges(Rc::new(Edges { parts })));
        }
        "extrude_edges" => {
            let b = bind(&["edges", "direction", "distance", "scale", "center", "hole_scale", "solid"])?;
            b.need(it, "direction")?;
            Build::Extrude {
                edges: chains(it, &b, "edges")?,
                direction: b.axis(it, "direction")?,
                distance: b.positive(it, "distance")?,
                scale: if b.get("scale").is_some() { b.positive(it, "scale")? } else { 1.0 },
                center: optional(it, &b, "center")?,
                hole_scale: b.get("hole_scale").is_some().then(|| b.positive(it, "hole_scale")).transpose()?,
                solid: truth(it, &b, "solid", true)?,
            }
        }
        "revolve_edges" => {
            let b = bind(&["edges", "axis", "at", "degrees", "solid"])?;
            Build::Revolve {
                edges: chain(it, &b, "edges")?,
                axis: b.axis(it, "axis")?,
                at: b.point(it, "at")?,
                degrees: number(it, &b, "degrees", 360.0)?,
                solid: truth(it, &b, "solid", true)?,
            }
        }
        "loft" => {
            let b = bind(&["sections", "ruled", "round", "square", "solid"])?;
            Build::Loft {
                sections: sections(it, &b)?,
                ruled: truth(it, &b, "ruled", false)?,
                round: pair(it, &b, "round")?,
                square: pair(it, &b, "square")?,
                solid: truth(it, &b, "solid", true)?,
            }
        }
        "flat_face" => Build::Flat(chains(it, &bind(&["edges"])?, "edges")?),
        "sew" => {
            let b = bind(&["parts", "tolerance", "solid"])?;
            let tolerance = b.get("tolerance").is_some().then(|| b.positive(it, "tolerance")).transpose()?;
            Build::Sew { parts: recipes(it, &b)?, tolerance, solid: truth(it, &b, "solid", true)? }
        }
        "ruled" => {
            let b = bind(&["a", "b"])?;
            let pair = [chain(it, &b, "a")?, chain(it, &b, "b")?].map(SectionRecipe::Edges);
            Build::Loft { sections: pair.to_vec(), ruled: true, round: [false; 2], square: [false; 2], solid: false }
        }
        _ => {
            let b = bind(&["edges", "path", "solid"])?;
            let edges = chains(it, &b, "edges")?;
            Build::Sweep { edges, path: chain(it, &b, "path")?, solid: truth(it, &b, "solid", true)? }
        }
    };
    let depth = match &build {
        Build::Sew { parts, .. } => 1 + parts.iter().map(|p| p.depth).max().unwrap_or(0),
        _ => 0,
    };
    if depth > DEEPEST {
        return Err(it.error(range, format!("sheets are sewn to sheets that are sewn: the limit is {DEEPEST} times")));
    }
    Ok(recipe(it, range, build, depth))
}

/// What is to be built, as a value.
pub(super) fn recipe<'a>(it: &It<'a>, range: TextRange, build: Build, depth: usize) -> Value<'a> {
    let (placement, place) = (Placement::IDENTITY, it.place(range));
    Value::Built(Rc::new(Recipe { build, placement, name: None, without: Vec::new(), depth, place }))
}

pub(super) fn edge<'a>(kind: EdgeKind) -> Result<Value<'a>> {
    Ok(Value::Edges(Rc::new(Edges::one(kind))))
}

/// A truth value, or one for the start and one for the end.
fn pair(it: &It<'_>, b: &Bound<'_>, name: &str) -> Result<[bool; 2]> {
    let Some(a) = b.get(name) else { return Ok([false; 2]) };
    match (&a.value, a.value.items()) {
        (Value::Bool(t), _) => Ok([*t; 2]),
        (_, Some([Value::Bool(s), Value::Bool(e)])) => Ok([*s, *e]),
        _ => Err(it.error(a.range, format!("{name:?} is True, False or a pair of them"))),
    }
}

/// Things to sew together.
fn recipes<'a>(it: &It<'a>, b: &Bound<'a>) -> Result<Vec<Recipe>> {
    let a = b.need(it, "parts")?;
    let items = a.value.items().unwrap_or_else(|| std::slice::from_ref(&a.value));
    let one = |v: &Value<'a>| match v {
        Value::Built(r) => Ok((**r).clone()),
        other => Err(it.error(a.range, format!("sew() takes what is built from edges, not {}", other.kind()))),
    };
    it.grow(a.range, items.len())?;
    items.iter().map(one).collect()
}

fn sections<'a>(it: &It<'a>, b: &Bound<'a>) -> Result<Vec<SectionRecipe>> {
    let a = b.need(it, "sections")?;
    let Some(items) = a.value.items() else {
        return Err(it.error(a.range, format!("sections are a list of edges and points, not {}", a.value.kind())));
    };
    it.grow(a.range, items.len())?;
    let one = |v: &Value<'a>| match v {
        Value::Edges(e) => Ok(SectionRecipe::Edges((**e).clone())),
        other => point(other).map(SectionRecipe::Point).ok_or_else(|| {
            it.error(a.range, format!("a section is made of edges, or is a point (x, y, z), not {}", other.kind()))
        }),
    };
    items.iter().map(one).collect()
}

/// First `first`, then `then`.
fn after(then: &Placement, first: &Placement) -> Placement {
    Placement {
        rotation: then.rotation * first.rotation,
        scale: then.scale * first.scale,
        shift: then.apply(first.shift),
    }
}

/// Methods of edges and of what is built from them.
pub(super) fn method<'a>(
    it: &It<'a>,
    range: TextRange,
    object: &Value<'a>,
    method: &'static str,
    arguments: Vec<Argument<'a>>,
) -> Result<Value<'a>> {
    if matches!(method, "mirror" | "size") || method == "name" && matches!(object, Value::Edges(_)) {
        return Err(it.error(range, format!(".{method}() is not for {}", object.kind())));
    }
    if method == "name" {
        let Value::Built(r) = object else { return Err(it.error(range, "nothing to name")) };
        let name = Some(methods::name_of(it, Bound::new(it, "name", &["name"], arguments, range)?)?);
        return Ok(Value::Built(Rc::new(Recipe { name, ..(**r).clone() })));
    }
    if method == "without" {
        let Value::Built(r) = object else {
            return Err(it.error(range, format!(".without() is not for {}", object.kind())));
        };
        let mut all = (**r).clone();
        for a in &arguments {
            match &a.value {
                Value::Str(s) => all.without.push(s.to_string()),
                other => return Err(it.error(a.range, format!("faces are left out by name, not by {}", other.kind()))),
            }
        }
        it.grow(range, all.without.len())?;
        return Ok(Value::Built(Rc::new(all)));
    }
    let by = match method {
        "move" => {
            let b = Bound::new(it, "move", &["by"], arguments, range)?;
            b.need(it, "by")?;
            Placement { shift: b.flat_point(it, "by")?, ..Placement::IDENTITY }
        }
        "rotate" => {
            let b = Bound::new(it, "rotate", &["degrees", "axis", "at"], arguments, range)?;
            let rotation: DMat3 = methods::rotation(b.axis(it, "axis")?, b.number(it, "degrees")?);
            let at = b.point(it, "at")?;
            Placement { rotation, scale: 1.0, shift: at - rotation * at }
        }
        _ => {
            let b = Bound::new(it, "scale", &["k", "about"], arguments, range)?;
            let k = b.positive(it, "k")?;
            match b.get("about").map(|a| (&a.value, a.range)) {
                Some((Value::Str(s), at)) => {
                    if **s != *"mass" {
                        return Err(it.error(at, "\"about\" is a point, or \"mass\" for the center of mass"));
                    }
                    let Value::Built(r) = object else {
                        return Err(it.error(at, "edges have no center of mass; give a point"));
                    };
                    let mut inner = (**r).clone();
                    let name = inner.name.take();
                    let depth = inner.depth + 1;
                    if depth > DEEPEST {
                        let what = format!("solids are scaled inside each other: the limit is {DEEPEST} times");
                        return Err(it.error(range, what));
                    }
                    let made = recipe(it, range, Build::AboutMass { part: Box::new(inner), scale: k }, depth);
                    let Value::Built(r) = made else { return Ok(made) };
                    return Ok(Value::Built(Rc::new(Recipe { name, ..(*r).clone() })));
                }
                Some(_) => {
                    let at = b.flat_point(it, "about")?;
                    Placement { scale: k, shift: at - k * at, ..Placement::IDENTITY }
                }
                None => Placement { scale: k, ..Placement::IDENTITY },
            }
        }
    };
    match object {
        Value::Edges(e) => {
            it.grow(range, e.parts.len())?;
            let parts = e.parts.iter().map(|(k, p)| (k.clone(), after(&by, p))).collect();
            Ok(Value::Edges(Rc::new(Edges { parts })))
        }
        Value::Built(r) => Ok(Value::Built(Rc::new(Recipe { placement: after(&by, &r.placement), ..(**r).clone() }))),
        other => Err(it.error(range, format!(".{method}() is not for {}", other.kind()))),
    }
}
