//! 3MF packages with level sets: implicit functions, negative inside, each within the box or the convex body of a mesh.

mod domain;
mod fallback;
mod graph;
mod values;

use std::collections::BTreeMap;

use glam::DAffine3;
use rustc_hash::FxHashMap;

use super::super::expr::Expr;
use super::super::solid::Solid;
use super::vm::{balanced_chains, crowd};
use super::{MeshDefaults, Part};
use crate::error::{Error, Place, Result};
use crate::io::threemf::{Model, Placed, attribute, model_text, number, parsed, real, transform, wrong};
use crate::sizing::SizeRequest;
use domain::within;
use fallback::with_fallback;
use graph::Graphs;
use values::Value;

/// Bytes of a package that is read.
const MOST_BYTES: usize = 1 << 30;

/// Reads a 3MF package whose build has level sets. The part is the union of all that is built, where functions are negative;
/// what an object's function bounds is one face with the object's name. The least `minfeaturesize` is the part's least length of
/// edges, where every level set has one.
///
/// Errors: [`Error::Input`] with line and column in the model for anything wrong, for nodes and functions that have no formula,
/// and for a build that has meshes beside level sets.
pub fn parse_3mf(bytes: &[u8]) -> Result<Part> {
    if bytes.len() > MOST_BYTES {
        let what = format!("the file has {} bytes: the limit is {MOST_BYTES}", bytes.len());
        return Err(Error::input(Place::Byte(MOST_BYTES as u64), what));
    }
    parse_model(&model_text(bytes)?)
}

/// Reads the model of a package, which is XML, as [`parse_3mf`] does.
pub fn parse_model(text: &str) -> Result<Part> {
    let xml = parsed(text)?;
    let model = Model::new(&xml)?;
    let placed = model.placed()?;
    let mut counts: BTreeMap<String, usize> = BTreeMap::new();
    let mut solids = Vec::new();
    let mut least: Option<f64> = Some(f64::INFINITY);
    for one in &placed {
        if !one.is_levelset() {
            let what = format!("object {} is a mesh, and others of the build are level sets", one.id);
            let help = "write meshes and level sets to files of their own, and join them in a part file";
            return Err(wrong(one.shape, what).with_help(help));
        }
        let name = one.name().unwrap_or_else(|| format!("object{}", one.id));
        let count = counts.entry(name.clone()).or_default();
        *count += 1;
        let name = if *count == 1 { name } else { format!("{name}#{count}") };
        least = least.zip(feature_size(one)?).map(|(a, b)| a.min(b));
        solids.push(levelset(&model, one, &name)?);
    }
    let solid = if solids.len() == 1 { solids.remove(0) } else { Solid::union(solids) };
    let mesh =
        MeshDefaults { least: least.filter(|l| l.is_finite()).map(SizeRequest::Length), ..MeshDefaults::default() };
    Ok(Part { units: Some(model.unit.into()), mesh, ..Part::from_solid(solid) })
}

/// The size in the build below which nothing of a level set counts; none where it says 0, as writers do that know none.
fn feature_size(placed: &Placed<'_>) -> Result<Option<f64>> {
    let name = "minfeaturesize";
    if placed.shape.attribute(name).is_none() {
        return Ok(None);
    }
    let size = real(placed.shape, name)?;
    if size < 0.0 {
        return Err(wrong(placed.shape, format!("{name} is {size}, and no size is less than 0")));
    }
    let size = size * placed.map.matrix3.determinant().abs().cbrt();
    Ok(Some(size).filter(|s| s.is_finite() && *s > 0.0))
}

/// What stands for the function where it has no value. None where that is 0, which is neither inside nor outside.
fn fallback_value(placed: &Placed<'_>) -> Result<Option<f64>> {
    let name = "fallbackvalue";
    if placed.shape.attribute(name).is_none() {
        return Ok(None);
    }
    let value = real(placed.shape, name)?;
    Ok(Some(value).filter(|v| *v != 0.0))
}

/// The solid of a level set where it is placed.
fn levelset<'a>(model: &Model<'a>, placed: &Placed<'a>, name: &str) -> Result<Solid> {
    let shape = placed.shape;
    let id = number(shape, "functionid")?;
    let channel = attribute(shape, "channel")?;
    // From the build's coordinates to the function's.
    let map = transform(shape)? * placed.map.inverse();
    if !map.is_finite() {
        return Err(wrong(shape, "its transform is flat or overflows"));
    }
    let inputs = FxHashMap::from_iter([("pos", Value::Vector(mapped(&map)))]);
    let found = Graphs::new(model).call(id, shape, inputs, &[channel])?;
    let Some(formula) = found.get(channel).and_then(Value::scalar) else {
        return Err(wrong(shape, format!("the output {channel:?} of function {id} is no scalar")));
    };
    let formula = balanced_chains(&match fallback_value(placed)? {
        Some(value) => with_fallback(&formula, value),
        None => formula,
    });
    let inside = match formula.as_constant() {
        Some(c) if c >= 0.0 => {
            return Err(wrong(shape, format!("function {id} is nowhere negative: the level set is empty")));
        }
        Some(_) => None,
        None => Some(crowd(&formula).unwrap_or_else(|| Solid::formula(-formula))),
    };
    let around = within(model, placed)?.name(&format!("{name}.box"));
    Ok(match inside {
        Some(solid) => solid.name(name) & around,
        None => around,
    })
}

/// The coordinates after a map, as formulas of those before it.
fn mapped(map: &DAffine3) -> [Expr; 3] {
    std::array::from_fn(|k| {
        let row = map.matrix3.row(k);
        let mut sum: Option<Expr> = None;
        for (x, c) in [Expr::x(), Expr::y(), Expr::z()].into_iter().zip(row.to_array()) {
            let term = match c {
                0.0 => continue,
                1.0 => x,
                _ => x * c,
            };
            sum = Some(sum.map_or(term.clone(), |s| s + term));
        }
        let shift = map.translation[k];
        match sum {
            Some(sum) if shift == 0.0 => sum,
            Some(sum) => sum + shift,
            None => Expr::constant(shift),
        }
    })
}
