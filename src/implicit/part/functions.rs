//! Functions of numbers and formulas that every part file knows.

use ruff_text_size::TextRange;

use super::super::expr::{Binary, Expr, Unary};
use super::arguments::Argument;
use super::interpreter::Interpreter;
use super::value::Value;
use crate::error::Result;

type It<'a> = Interpreter<'a>;

/// Functions of numbers and formulas.
pub(super) fn function<'a>(
    it: &It<'a>,
    range: TextRange,
    name: &'static str,
    arguments: Vec<Argument<'a>>,
) -> Result<Value<'a>> {
    if let Some(k) = arguments.iter().find(|a| a.keyword.is_some()) {
        return Err(it.error(k.range, format!("{name}() takes no keywords")));
    }
    let mut formulas = Vec::new();
    let mut ints = Vec::new();
    let mut add = |v: &Value<'a>, r: TextRange| -> Result<()> {
        if let Value::Int(i) = v {
            ints.push(*i);
        }
        formulas.push(
            v.formula().ok_or_else(|| it.error(r, format!("{name}() takes numbers and formulas, not {}", v.kind())))?,
        );
        Ok(())
    };
    for a in &arguments {
        match a.value.items() {
            Some(items) if matches!(name, "min" | "max") => items.iter().try_for_each(|v| add(v, a.range))?,
            _ => add(&a.value, a.range)?,
        }
    }
    it.grow(range, formulas.len())?;
    let count = formulas.len();
    if matches!(name, "mod" | "fmod") && formulas.get(1).and_then(Expr::as_constant) == Some(0.0) {
        return Err(it.error(range, "division by zero"));
    }
    let all_ints = ints.len() == count;
    if let Some(made) = composed(name, &formulas) {
        return match made.as_constant() {
            Some(c) if all_ints && name == "clamp" => Ok(Value::Int(c as i64)),
            _ => finite(it, range, name, made),
        };
    }
    let unary = match name {
        "asin" => Some(Unary::Asin),
        "acos" => Some(Unary::Acos),
        // With one argument only `floor` comes here; the others are composed.
        "floor" | "atan" | "round" | "ceil" | "trunc" => Some(Unary::Floor),
        "sinh" => Some(Unary::Sinh),
        "cosh" => Some(Unary::Cosh),
        "tanh" => Some(Unary::Tanh),
        "sign" => Some(Unary::Sign),
        "sqrt" => Some(Unary::Sqrt),
        "exp" => Some(Unary::Exp),
        "log" => Some(Unary::Log),
        "sin" => Some(Unary::Sin),
        "cos" => Some(Unary::Cos),
        "tan" => Some(Unary::Tan),
        "abs" => Some(Unary::Abs),
        _ => None,
    };
    let binary = match name {
        "atan2" => Some(Binary::Atan2),
        "pow" => Some(Binary::Pow),
        "mod" | "fmod" => Some(Binary::Mod),
        "min" => Some(Binary::Min),
        "max" => Some(Binary::Max),
        _ => None,
    };
    let made = match (unary, binary) {
        (Some(op), _) if count == 1 => formulas.into_iter().next().map(|f| Expr::unary(op, f)),
        (_, Some(op @ (Binary::Min | Binary::Max))) => formulas.into_iter().reduce(|a, b| Expr::binary(op, a, b)),
        (_, Some(op)) if count == 2 => formulas.into_iter().reduce(|a, b| Expr::binary(op, a, b)),
        _ => None,
    };
    let Some(made) = made else {
        let wants = if unary.is_some() {
            "1 argument"
        } else if matches!(name, "min" | "max" | "hypot") {
            "at least 1"
        } else if name == "clamp" {
            "3 arguments: a value, the least and the greatest"
        } else {
            "2 arguments"
        };
        return Err(it.error(range, format!("{name}() takes {wants}, not {count}")));
    };
    match made.as_constant() {
        Some(c) if c.is_finite() && all_ints && matches!(name, "min" | "max" | "abs" | "mod" | "sign") => {
            Ok(Value::Int(c as i64))
        }
        _ => finite(it, range, name, made),
    }
}

fn finite<'a>(it: &It<'a>, range: TextRange, name: &str, made: Expr) -> Result<Value<'a>> {
    match made.as_constant() {
        Some(c) if !c.is_finite() => Err(it.error(range, format!("{name}() is not a finite number here"))),
        _ => Ok(Value::from_formula(made)),
    }
}

/// Functions that are made of several operations; `None` for others, and for a wrong number of arguments.
fn composed(name: &str, arguments: &[Expr]) -> Option<Expr> {
    match (name, arguments) {
        ("atan", [a]) => Some(Expr::binary(Binary::Atan2, a.clone(), Expr::constant(1.0))),
        ("round", [a]) => Some(a.clone().round()),
        ("ceil", [a]) => Some(a.clone().ceil()),
        ("trunc", [a]) => Some(a.clone().trunc()),
        ("fmod", [a, b]) => Some(a.clone().fmod(b.clone())),
        ("clamp", [a, low, high]) => {
            let above = Expr::binary(Binary::Max, a.clone(), low.clone());
            Some(Expr::binary(Binary::Min, above, high.clone()))
        }
        ("hypot", [a]) => Some(Expr::unary(Unary::Abs, a.clone())),
        ("hypot", all) => all.iter().cloned().reduce(|a, b| Expr::binary(Binary::Hypot, a, b)),
        _ => None,
    }
}
