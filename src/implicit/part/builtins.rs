//! Functions and constants every part file knows.

use std::rc::Rc;

use glam::DVec3;
use ruff_text_size::TextRange;

use super::super::expr::Expr;
use super::super::polygon::polygon_tree;
use super::super::rfunction::RSystem;
use super::super::solid::{Primitive, Solid, Tpms};
use super::PartGroup;
use super::arguments::{Argument, Bound};
use super::curves;
use super::edges;
use super::figures;
use super::foreign;
use super::functions::function;
use super::interpreter::{Declared, Interpreter};
use super::operators;
use super::recipe::Recipe;
use super::sheets;
use super::value::{Value, condition_solid};
use crate::error::Result;
use crate::sizing::SizeRequest;
use crate::spatial::Aabb;

/// All names, for suggestions.
pub(super) const NAMES: [&str; 65] = [
    "x",
    "y",
    "z",
    "pi",
    "sqrt",
    "exp",
    "log",
    "sin",
    "cos",
    "tan",
    "atan2",
    "abs",
    "min",
    "max",
    "hypot",
    "clamp",
    "box",
    "sphere",
    "ellipsoid",
    "cylinder",
    "cone",
    "torus",
    "half_space",
    "gyroid",
    "schwarz_p",
    "diamond",
    "polygon",
    "extrude",
    "revolve",
    "solid",
    "union",
    "intersection",
    "blend",
    "units",
    "part",
    "group",
    "faces",
    "mesh",
    "step",
    "range",
    "len",
    "sum",
    "enumerate",
    "zip",
    "int",
    "float",
    "round",
    "str",
    "list",
    "tuple",
    "pow",
    "degrees",
    "radians",
    "floor",
    "ceil",
    "mod",
    "fmod",
    "asin",
    "acos",
    "atan",
    "sinh",
    "cosh",
    "tanh",
    "sign",
    "trunc",
];

/// Units of length a part may be in.
const UNITS: [&str; 7] = ["m", "dm", "cm", "mm", "um", "in", "ft"];

/// The value of a name that is not the user's.
pub(super) fn constant<'a>(name: &str) -> Option<Value<'a>> {
    match name {
        "x" => Some(Value::Formula(Expr::x())),
        "y" => Some(Value::Formula(Expr::y())),
        "z" => Some(Value::Formula(Expr::z())),
        "pi" => Some(Value::Float(std::f64::consts::PI)),
        _ => names().find(|n| *n == name).map(Value::Builtin),
    }
}

/// The names of all that is built in.
pub(super) fn names() -> impl Iterator<Item = &'static str> {
    NAMES.iter().chain(&edges::NAMES).chain(&curves::NAMES).chain(&sheets::NAMES).chain(&figures::NAMES).copied()
}

/// Steps a tuple in a list counts for: as many as it takes to write one.
const PAIR: usize = 4;

type It<'a> = Interpreter<'a>;

pub(super) fn call<'a>(
    it: &mut It<'a>,
    range: TextRange,
    name: &'static str,
    arguments: Vec<Argument<'a>>,
) -> Result<Value<'a>> {
    match name {
        "sqrt" | "exp" | "log" | "sin" | "cos" | "tan" | "abs" | "atan2" | "hypot" | "clamp" | "pow" | "min"
        | "max" | "mod" | "fmod" | "asin" | "acos" | "atan" | "sinh" | "cosh" | "tanh" | "sign" => {
            function(it, range, name, arguments)
        }
        "round" | "floor" | "ceil" | "trunc" if matches!(&arguments[..], [a] if matches!(a.value, Value::Formula(_))) => {
            function(it, range, name, arguments)
        }
        "step" => foreign::file(it, range, name, arguments),
        "mesh" if foreign::is_file(&arguments) => foreign::file(it, range, name, arguments),
        "units" | "part" | "group" | "faces" | "mesh" => declaration(it, range, name, arguments),
        "range" | "len" | "sum" | "enumerate" | "zip" | "int" | "float" | "round" | "str" | "list" | "tuple"
        | "degrees" | "radians" | "floor" | "ceil" | "trunc" => plain(it, range, name, arguments),
        _ if edges::NAMES.contains(&name) => edges::call(it, range, name, arguments),
        _ if curves::NAMES.contains(&name) => curves::call(it, range, name, arguments),
        _ if sheets::NAMES.contains(&name) => sheets::call(it, range, name, arguments),
        _ if figures::NAMES.contains(&name) => figures::call(it, range, name, arguments),
        _ => shape(it, range, name, arguments),
    }
}

/// Solids.
fn shape<'a>(it: &It<'a>, range: TextRange, name: &'static str, arguments: Vec<Argument<'a>>) -> Result<Value<'a>> {
    it.grow(range, 8)?;
    let bind = |names| Bound::new(it, name, names, arguments.clone(), range);
    let primitive = match name {
        "box" => {
            let b = bind(&["size", "at", "lo", "hi"])?;
            if b.get("size").is_some() {
                if b.get("lo").is_some() || b.get("hi").is_some() {
                    return Err(it.error(range, "box() takes size (and at), or lo and hi, not both"));
                }
                let (size, at) = (b.vector(it, "size")?, b.point(it, "at")?);
                if size.min_element() <= 0.0 {
                    return Err(it.error(
                        b.need(it, "size")?.range,
                        format!("the three sizes of a box must be positive, not {size}"),
                    ));
                }
                Primitive::Box { lo: at - 0.5 * size, hi: at + 0.5 * size }
            } else {
                let (lo, hi) = (b.vector(it, "lo")?, b.vector(it, "hi")?);
                if !lo.cmplt(hi).all() {
                    return Err(
                        it.error(range, format!("a box needs lo < hi in all three coordinates, not {lo} and {hi}"))
                    );
                }
                Primitive::Box { lo, hi }
            }
        }
        "sphere" => {
            let b = bind(&["r", "at"])?;
            Primitive::Sphere { r: b.positive(it, "r")?, at: b.point(it, "at")? }
        }
        "ellipsoid" => {
            let b = bind(&["radii", "at"])?;
            let radii = b.vector(it, "radii")?;
            if radii.min_element() <= 0.0 {
                return Err(it.error(
                    b.need(it, "radii")?.range,
                    format!("the radii of an ellipsoid must be positive, not {radii}"),
                ));
            }
            Primitive::Ellipsoid { radii, at: b.point(it, "at")? }
        }
        "cylinder" => {
            let b = bind(&["r", "axis", "at", "height"])?;
            let height = if b.get("height").is_some() { Some(b.positive(it, "height")?) } else { None };
            Primitive::Cylinder { r: b.positive(it, "r")?, axis: b.axis(it, "axis")?, at: b.point(it, "at")?, height }
        }
        "cone" => {
            let b = bind(&["r0", "r1", "height", "axis", "at"])?;
            let (r0, r1) = (b.not_negative(it, "r0")?, b.not_negative(it, "r1")?);
            if r0 == 0.0 && r1 == 0.0 {
                return Err(it.error(range, "a cone needs one radius that is not zero"));
            }
            Primitive::Cone {
                r0,
                r1,
                height: b.positive(it, "height")?,
                axis: b.axis(it, "axis")?,
                at: b.point(it, "at")?,
            }
        }
        "torus" => {
            let b = bind(&["R", "r", "axis", "at"])?;
            Primitive::Torus {
                major: b.positive(it, "R")?,
                minor: b.positive(it, "r")?,
                axis: b.axis(it, "axis")?,
                at: b.point(it, "at")?,
            }
        }
        "half_space" => {
            let b = bind(&["normal", "at"])?;
            b.need(it, "normal")?;
            Primitive::HalfSpace { normal: b.axis(it, "normal")?, at: b.point(it, "at")? }
        }
        "gyroid" | "schwarz_p" | "diamond" => {
            let b = bind(&["period", "thickness", "at"])?;
            let kind = match name {
                "gyroid" => Tpms::Gyroid,
                "schwarz_p" => Tpms::SchwarzP,
                _ => Tpms::Diamond,
            };
            Primitive::Tpms {
                kind,
                period: b.positive(it, "period")?,
                thickness: b.positive(it, "thickness")?,
                at: b.point(it, "at")?,
            }
        }
        "polygon" => {
            let b = bind(&["points"])?;
            let points = b.polygon(it, "points")?;
            it.at(b.need(it, "points")?.range, polygon_tree(&points))?;
            it.grow(range, points.len())?;
            return Ok(Value::Polygon(Rc::new(points)));
        }
        "extrude" | "revolve" => return figures::raised(it, range, name, arguments),
        "solid" => {
            let b = bind(&["condition"])?;
            let a = b.need(it, "condition")?;
            return match &a.value {
                Value::Condition(all) => Ok(Value::Solid(condition_solid(all))),
                Value::Formula(e) => Ok(Value::Solid(Primitive::Formula(e.clone()).into())),
                Value::Solid(s) => Ok(Value::Solid(s.clone())),
                Value::Bool(_) => Err(it.error(a.range, "the condition does not depend on x, y, z")),
                other => Err(it
                    .error(
                        a.range,
                        format!("solid() takes a formula or a comparison of formulas, not {}", other.kind()),
                    )
                    .with_help("solid(f >= 0) is where f is not negative")),
            };
        }
        "union" | "intersection" => {
            let mut all = Vec::new();
            let items = |a: &Argument<'a>| a.value.items().map_or_else(|| vec![a.value.clone()], <[_]>::to_vec);
            let values: Vec<Value<'a>> = arguments.iter().flat_map(items).collect();
            if let Some(all) = figures::joined(it, range, &values)? {
                it.grow(range, all.len())?;
                return Ok(Value::Region(if name == "union" { Solid::union(all) } else { Solid::intersection(all) }));
            }
            for a in &arguments {
                let items = a.value.items().unwrap_or_else(|| std::slice::from_ref(&a.value));
                for v in items {
                    all.push(
                        foreign::operand(v)
                            .ok_or_else(|| it.error(a.range, format!("{name}() takes solids, not {}", v.kind())))?,
                    );
                }
            }
            if all.is_empty() {
                return Err(it.error(range, format!("{name}() needs at least one solid")));
            }
            it.grow(range, all.len())?;
            return Ok(Value::Solid(if name == "union" { Solid::union(all) } else { Solid::intersection(all) }));
        }
        "blend" => {
            let b = bind(&["a", "b", "radius"])?;
            let pair = [b.need(it, "a")?.value.clone(), b.need(it, "b")?.value.clone()];
            if let Some(pair) = figures::joined(it, range, &pair)?
                && let [first, second] = &pair[..]
            {
                return Ok(Value::Region(first.clone().blend(second.clone(), b.positive(it, "radius")?)));
            }
            return Ok(Value::Solid(b.solid(it, "a")?.blend(b.solid(it, "b")?, b.positive(it, "radius")?)));
        }
        other => return Err(it.error(range, format!("{other:?} cannot be called"))),
    };
    Ok(Value::Solid(primitive.into()))
}

/// Plain Python.
fn plain<'a>(it: &It<'a>, range: TextRange, name: &'static str, arguments: Vec<Argument<'a>>) -> Result<Value<'a>> {
    if let Some(k) = arguments.iter().find(|a| a.keyword.is_some()) {
        return Err(it.error(k.range, format!("{name}() takes no keywords here")));
    }
    let values: Vec<&Value<'a>> = arguments.iter().map(|a| &a.value).collect();
    let ints: Vec<i64> = values.iter().filter_map(|v| if let Value::Int(i) = v { Some(*i) } else { None }).collect();
    let list = |v: Vec<Value<'a>>| it.fits(range, v.len()).map(|()| Value::List(Rc::new(v)));
    match (name, &values[..]) {
        ("range", v) if (1..=3).contains(&v.len()) && ints.len() == v.len() => {
            let (start, stop, step) = match ints[..] {
                [stop] => (0, stop, 1),
                [start, stop] => (start, stop, 1),
                _ => (ints[0], ints[1], ints[2]),
            };
            if step == 0 {
                return Err(it.error(range, "the step of a range must not be zero"));
            }
            let span =
                if step > 0 { i128::from(stop) - i128::from(start) } else { i128::from(start) - i128::from(stop) };
            let width = i128::from(step).abs();
            let count = if span <= 0 { 0 } else { (span + width - 1) / width };
            it.fits(range, usize::try_from(count).unwrap_or(usize::MAX))?;
            list((0..count as i64).map(|i| Value::Int(start + i * step)).collect())
        }
        ("range", _) => Err(it.error(range, "range() takes one to three whole numbers")),
        ("len", [v]) => match v {
            Value::Str(s) => Ok(Value::Int(s.chars().count() as i64)),
            v => match v.items() {
                Some(items) => Ok(Value::Int(items.len() as i64)),
                None => Err(it.error(range, format!("{} has no length", v.kind()))),
            },
        },
        ("sum", [v]) => {
            let Some(items) = v.items() else {
                return Err(it.error(range, format!("sum() takes a list, not {}", v.kind())));
            };
            it.charge(range, items.len())?;
            items.iter().try_fold(Value::Int(0), |s, v| {
                operators::binary(it, range, ruff_python_ast::Operator::Add, s, v.clone())
            })
        }
        ("enumerate", [v]) => match operators::spread(it, range, (*v).clone())?.items() {
            Some(items) => it.charge(range, PAIR * items.len()).and_then(|()| {
                list(
                    items
                        .iter()
                        .enumerate()
                        .map(|(i, v)| Value::Tuple(Rc::new(vec![Value::Int(i as i64), v.clone()])))
                        .collect(),
                )
            }),
            None => Err(it.error(range, format!("enumerate() takes a list, not {}", v.kind()))),
        },
        ("zip", v) if !v.is_empty() => {
            let v: Vec<Value<'a>> =
                v.iter().map(|v| operators::spread(it, range, (*v).clone())).collect::<Result<_>>()?;
            let lists: Option<Vec<&[Value<'a>]>> = v.iter().map(|v| v.items()).collect();
            let Some(lists) = lists else { return Err(it.error(range, "zip() takes lists")) };
            let n = lists.iter().map(|l| l.len()).min().unwrap_or(0);
            it.fits(range, n.saturating_mul(lists.len()))?;
            it.charge(range, PAIR * n)?;
            list((0..n).map(|i| Value::Tuple(Rc::new(lists.iter().map(|l| l[i].clone()).collect()))).collect())
        }
        ("list" | "tuple", [v]) => match operators::spread(it, range, (*v).clone())?.items() {
            Some(items) if name == "list" => list(items.to_vec()),
            Some(items) => it.fits(range, items.len()).map(|()| Value::Tuple(Rc::new(items.to_vec()))),
            None => Err(it.error(range, format!("{name}() takes a list, not {}", v.kind()))),
        },
        ("str", [v]) => it.display(range, v).and_then(|s| it.string(range, s)),
        ("float", [v]) if v.number().is_some() => Ok(Value::Float(v.number().unwrap_or(0.0))),
        ("int" | "round" | "floor" | "ceil" | "trunc", [v]) if v.number().is_some() => {
            let f = v.number().unwrap_or(0.0);
            let f = match name {
                "int" | "trunc" => f.trunc(),
                "round" => f.round_ties_even(),
                "floor" => f.floor(),
                _ => f.ceil(),
            };
            if f.abs() < 9e18 {
                Ok(Value::Int(f as i64))
            } else {
                Err(it.error(range, format!("{f} is too large for a whole number")))
            }
        }
        ("round", [v, Value::Int(digits)]) if v.number().is_some() && (0..=15).contains(digits) => {
            let k = 10f64.powi(*digits as i32);
            it.finite(range, (v.number().unwrap_or(0.0) * k).round_ties_even() / k)
        }
        ("degrees", [v]) if v.number().is_some() => it.finite(range, v.number().unwrap_or(0.0).to_degrees()),
        ("radians", [v]) if v.number().is_some() => Ok(Value::Float(v.number().unwrap_or(0.0).to_radians())),
        (_, v) => {
            let kinds: Vec<&str> = v.iter().take(5).map(|v| v.kind()).collect();
            Err(it.error(range, format!("{name}() cannot be used on ({})", kinds.join(", "))))
        }
    }
}

/// What is said about the part, not part of any expression.
fn declaration<'a>(
    it: &mut It<'a>,
    range: TextRange,
    name: &'static str,
    arguments: Vec<Argument<'a>>,
) -> Result<Value<'a>> {
    match name {
        "units" => {
            let b = Bound::new(it, name, &["unit"], arguments, range)?;
            let unit = b.text(it, "unit")?;
            if !UNITS.contains(&unit.as_str()) {
                return Err(it
                    .error(range, format!("unknown unit {unit:?}"))
                    .with_help(format!("known: {}", UNITS.join(", "))));
            }
            if it.units.is_some() {
                return Err(it.error(range, "units() is said twice"));
            }
            it.units = Some(unit);
        }
        "faces" => {
            let mut patterns = Vec::new();
            for a in &arguments {
                match &a.value {
                    Value::Str(s) => patterns.push(s.to_string()),
                    other => {
                        return Err(
                            it.error(a.range, format!("faces() takes names and patterns, not {}", other.kind()))
                        );
                    }
                }
            }
            return Ok(Value::Faces(Rc::new(patterns)));
        }
        "group" => {
            let b = Bound::new(it, name, &["name", "faces"], arguments, range)?;
            let group = b.text(it, "name")?;
            let a = b.need(it, "faces")?;
            let patterns = match &a.value {
                Value::Faces(f) => f.to_vec(),
                Value::Str(s) => vec![s.to_string()],
                other => return Err(it.error(a.range, format!("a group is made of faces(...), not {}", other.kind()))),
            };
            it.charge(range, it.groups.len())?;
            if it.groups.iter().any(|g| g.name == group) {
                return Err(it.error(range, format!("there is a group {group:?} already")));
            }
            it.groups.push(PartGroup { name: group, patterns, place: it.place(range) });
        }
        "mesh" => {
            let b = Bound::new(it, name, &["size", "size_min", "sequence"], arguments, range)?;
            let length = |name: &str| {
                let Some(a) = b.get(name) else { return Ok(None) };
                match &a.value {
                    Value::Str(s) => it.at(a.range, s.parse()).map(Some),
                    _ => Ok(Some(SizeRequest::Length(b.positive(it, name)?))),
                }
            };
            let (size, least) = (length("size")?, length("size_min")?);
            it.mesh.size = size.or(it.mesh.size);
            it.mesh.least = least.or(it.mesh.least);
            if let Some(a) = b.get("sequence") {
                it.mesh.sequence = Some((b.text(it, "sequence")?, it.place(a.range)));
            }
        }
        _ => {
            let b = Bound::new(it, name, &["solid", "rsystem", "domain"], arguments, range)?;
            if it.declared.is_some() {
                return Err(it.error(range, "part() is said twice: a file describes one part"));
            }
            let figure = match &b.need(it, "solid")?.value {
                Value::Region(s) => Some(s.clone()),
                _ => None,
            };
            let plane = figure.is_some();
            let (solid, built) = if plane { (figure, Vec::new()) } else { solids(it, &b)? };
            let rsystem = match b.get("rsystem") {
                None => RSystem::default(),
                Some(a) => it.at(a.range, rsystem(it, a).and_then(RSystem::checked))?,
            };
            let domain = match b.get("domain") {
                None => None,
                Some(a) if plane => Some(figures::domain(it, a)?),
                Some(a) => Some(domain(it, a)?),
            };
            it.declared = Some(Declared { solid, built, plane, rsystem, domain, place: it.place(range) });
        }
    }
    Ok(Value::None)
}

/// What a part is made of: a solid, ones built from edges, or a list of such.
fn solids<'a>(it: &It<'a>, b: &Bound<'a>) -> Result<(Option<Solid>, Vec<Recipe>)> {
    let a = b.need(it, "solid")?;
    let (mut solid, mut built) = (None, Vec::new());
    let items = a.value.items().unwrap_or_else(|| std::slice::from_ref(&a.value));
    for v in items {
        match v {
            Value::Built(r) => built.push((**r).clone()),
            v if v.solid().is_some() && solid.is_some() => {
                return Err(it
                    .error(a.range, "a part is made of one solid of R-functions at most")
                    .with_help("union([...]) makes one of several"));
            }
            v if v.solid().is_some() => solid = v.solid(),
            _ if items.len() == 1 && a.value.items().is_none() => {
                return b.solid(it, "solid").map(|s| (Some(s), built));
            }
            v => {
                let e = it.error(a.range, format!("a part is made of solids, not of {}", v.kind()));
                let flat = matches!(v, Value::Region(_));
                return Err(if flat {
                    e.with_help("part(region(...)) is one plane figure, and nothing else")
                } else {
                    e
                });
            }
        }
    }
    if solid.is_none() && built.is_empty() {
        return Err(it.error(a.range, "a part needs a solid"));
    }
    it.grow(a.range, built.len())?;
    Ok((solid, built))
}

fn rsystem<'a>(it: &It<'a>, a: &Argument<'a>) -> Result<RSystem> {
    let wrong = || it.error(a.range, "rsystem is \"R0\", \"minmax\", (\"Ralpha\", a) or (\"R0m\", m)");
    match &a.value {
        Value::Str(s) if &**s == "R0" => Ok(RSystem::R0),
        Value::Str(s) if &**s == "minmax" => Ok(RSystem::MinMax),
        Value::Tuple(t) => match &t[..] {
            [Value::Str(s), v] if &**s == "Ralpha" => v.number().map(RSystem::RAlpha).ok_or_else(wrong),
            [Value::Str(s), Value::Int(m)] if &**s == "R0m" => Ok(RSystem::R0m(u32::try_from(*m).unwrap_or(u32::MAX))),
            _ => Err(wrong()),
        },
        _ => Err(wrong()),
    }
}

fn domain<'a>(it: &It<'a>, a: &Argument<'a>) -> Result<Aabb> {
    let point = |v: &Value<'a>| -> Option<DVec3> {
        let n: Vec<f64> = v.items()?.iter().filter_map(Value::number).filter(|v| v.is_finite()).collect();
        (n.len() == 3 && v.items()?.len() == 3).then(|| DVec3::new(n[0], n[1], n[2]))
    };
    let ends = match a.value.items() {
        Some([lo, hi]) => point(lo).zip(point(hi)),
        _ => None,
    };
    match ends {
        Some((lo, hi)) if lo.cmplt(hi).all() => Ok(Aabb::new(lo, hi)),
        Some((lo, hi)) => {
            Err(it.error(a.range, format!("a domain needs lo < hi in all three coordinates, not {lo} and {hi}")))
        }
        None => Err(it.error(a.range, "a domain is two points: ((x0, y0, z0), (x1, y1, z1))")),
    }
}
