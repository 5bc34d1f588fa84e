//! Operators on values: arithmetic, set operations, comparisons, indexing.

use std::rc::Rc;

use ruff_python_ast::{CmpOp, Operator, UnaryOp};
use ruff_text_size::TextRange;

use super::super::expr::{Binary, Expr, Unary};
use super::super::solid::{Solid, SolidNode};
use super::figures;
use super::foreign;
use super::interpreter::Interpreter;
use super::lists;
use super::value::Value;
use crate::error::Result;

type It<'a> = Interpreter<'a>;

/// What is gone through one by one: of a string its characters.
pub(super) fn spread<'a>(it: &It<'a>, range: TextRange, v: Value<'a>) -> Result<Value<'a>> {
    let Value::Str(s) = v else { return Ok(v) };
    it.fits(range, s.len())?;
    Ok(Value::List(Rc::new(s.chars().map(|c| Value::Str(c.to_string().into())).collect())))
}

pub(super) fn binary<'a>(it: &It<'a>, range: TextRange, op: Operator, l: Value<'a>, r: Value<'a>) -> Result<Value<'a>> {
    let mismatch = || {
        let e = it.error(range, format!("{} {} {} has no meaning", l.kind(), op.as_str(), r.kind()));
        let mixed = matches!((&l, &r), (Value::Solid(_), Value::Formula(_)) | (Value::Formula(_), Value::Solid(_)));
        if mixed { e.with_help("make a solid of the formula: solid(f >= 0)") } else { e }
    };
    // set operations
    if let Some(pair) = figures::operands(it, range, op, [&l, &r])? {
        let [a, b] = pair;
        it.grow(range, 2)?;
        return Ok(Value::Region(match op {
            Operator::BitAnd => a & b,
            Operator::BitOr => a | b,
            _ => a - b,
        }));
    }
    let is_solid = |v: &Value<'a>| matches!(v, Value::Solid(_) | Value::Condition(_) | Value::Built(_));
    if is_solid(&l) || is_solid(&r) {
        let (Some(a), Some(b)) = (foreign::operand(&l), foreign::operand(&r)) else { return Err(mismatch()) };
        it.grow(range, 2)?;
        return Ok(Value::Solid(match op {
            Operator::BitAnd => a & b,
            Operator::BitOr => a | b,
            Operator::Sub => a - b,
            _ => return Err(mismatch().with_help("solids are joined by & | - and ~")),
        }));
    }
    match (&l, &r, op) {
        (Value::Str(a), Value::Str(b), Operator::Add) => return it.string(range, format!("{a}{b}")),
        (Value::List(a), Value::List(b), Operator::Add) => {
            it.fits(range, a.len() + b.len())?;
            return Ok(Value::List(Rc::new(a.iter().chain(b.iter()).cloned().collect())));
        }
        (Value::Tuple(a), Value::Tuple(b), Operator::Add) => {
            it.fits(range, a.len() + b.len())?;
            return Ok(Value::Tuple(Rc::new(a.iter().chain(b.iter()).cloned().collect())));
        }
        (Value::List(a), Value::Int(n), Operator::Mult) => {
            let n = (*n).max(0) as usize;
            it.fits(range, a.len().saturating_mul(n))?;
            return Ok(Value::List(Rc::new((0..n).flat_map(|_| a.iter().cloned()).collect())));
        }
        (Value::Faces(a), Value::Faces(b), Operator::BitOr | Operator::Add) => {
            return Ok(Value::Faces(Rc::new(a.iter().chain(b.iter()).cloned().collect())));
        }
        _ => {}
    }
    if let (Value::Int(a), Value::Int(b)) = (&l, &r) {
        let exact = match op {
            Operator::Add => a.checked_add(*b),
            Operator::Sub => a.checked_sub(*b),
            Operator::Mult => a.checked_mul(*b),
            Operator::FloorDiv if *b != 0 => {
                a.checked_div_euclid(*b).map(|q| if *b < 0 && a.rem_euclid(*b) != 0 { q - 1 } else { q })
            }
            Operator::Mod if *b != 0 => {
                a.checked_rem(*b).map(|m| if m != 0 && (m < 0) != (*b < 0) { m + b } else { m })
            }
            Operator::Pow if *b >= 0 => u32::try_from(*b).ok().and_then(|e| a.checked_pow(e)),
            _ => None,
        };
        if let Some(v) = exact {
            return Ok(Value::Int(v));
        }
    }
    if let (Some(a), Some(b)) = (l.number(), r.number()) {
        let v = match op {
            Operator::Add => a + b,
            Operator::Sub => a - b,
            Operator::Mult => a * b,
            Operator::Div | Operator::FloorDiv | Operator::Mod if b == 0.0 => {
                return Err(it.error(range, "division by zero"));
            }
            Operator::Div => a / b,
            Operator::FloorDiv => (a / b).floor(),
            Operator::Mod => a - b * (a / b).floor(),
            Operator::Pow => Binary::Pow.apply(a, b),
            _ => return Err(mismatch()),
        };
        return if v.is_finite() {
            Ok(Value::Float(v))
        } else {
            Err(it.error(range, format!("{a} {} {b} is not a finite number", op.as_str())))
        };
    }
    let (Some(a), Some(b)) = (l.formula(), r.formula()) else { return Err(mismatch()) };
    let floored = op == Operator::FloorDiv;
    let op = match op {
        Operator::Add => Binary::Add,
        Operator::Sub => Binary::Sub,
        Operator::Mult => Binary::Mul,
        Operator::Div if b.as_constant() == Some(0.0) => return Err(it.error(range, "division by zero")),
        Operator::Div => Binary::Div,
        Operator::Pow => Binary::Pow,
        Operator::FloorDiv | Operator::Mod if b.as_constant() == Some(0.0) => {
            return Err(it.error(range, "division by zero"));
        }
        Operator::FloorDiv => Binary::Div,
        Operator::Mod => Binary::Mod,
        _ => return Err(mismatch()),
    };
    it.grow(range, 1 + usize::from(floored))?;
    let made = Expr::binary(op, a, b);
    Ok(Value::from_formula(if floored { Expr::unary(Unary::Floor, made) } else { made }))
}

pub(super) fn unary<'a>(it: &It<'a>, range: TextRange, op: UnaryOp, v: Value<'a>) -> Result<Value<'a>> {
    match (op, &v) {
        (UnaryOp::Not, _) => it.truth(range, &v).map(|b| Value::Bool(!b)),
        (UnaryOp::Invert, Value::Solid(_) | Value::Condition(_)) => {
            it.grow(range, 1)?;
            v.solid().map(|s| Value::Solid(Solid::new(SolidNode::Not(s)))).ok_or_else(|| it.error(range, "no solid"))
        }
        (UnaryOp::Invert, Value::Region(_) | Value::Polygon(_) | Value::Edges(_)) => {
            it.grow(range, 1)?;
            let inside = figures::figure(&v).ok_or_else(|| it.error(range, format!("~{} has no meaning", v.kind())))?;
            Ok(Value::Region(Solid::new(SolidNode::Not(inside))))
        }
        (UnaryOp::UAdd, Value::Int(_) | Value::Float(_) | Value::Formula(_)) => Ok(v),
        (UnaryOp::USub, Value::Int(i)) => Ok(i.checked_neg().map_or(Value::Float(-(*i as f64)), Value::Int)),
        (UnaryOp::USub, Value::Float(f)) => Ok(Value::Float(-f)),
        (UnaryOp::USub, Value::Formula(e)) => {
            it.grow(range, 1)?;
            Ok(Value::Formula(-e.clone()))
        }
        (UnaryOp::USub, Value::Solid(_)) => {
            Err(it.error(range, "-a has no meaning for a solid").with_help("the complement is ~a"))
        }
        (op, v) => Err(it.error(range, format!("{}{} has no meaning", op.as_str(), v.kind()))),
    }
}

/// Comparisons: of numbers and strings at once, of formulas as a condition.
pub(super) fn compare<'a>(it: &It<'a>, range: TextRange, ops: &[CmpOp], values: &[Value<'a>]) -> Result<Value<'a>> {
    let formulas = values.iter().any(|v| matches!(v, Value::Formula(_)));
    let mut truth = true;
    let mut conditions = Vec::new();
    for (op, pair) in ops.iter().zip(values.windows(2)) {
        let (a, b) = (&pair[0], &pair[1]);
        if matches!(op, CmpOp::In | CmpOp::NotIn) {
            truth &= lists::held(it, range, *op, a, b)?;
            continue;
        }
        if formulas {
            let (Some(a), Some(b)) = (a.formula(), b.formula()) else {
                return Err(it.error(range, format!("{} and {} cannot be compared", a.kind(), b.kind())));
            };
            it.grow(range, 2)?;
            let zero = |e: &Expr| e.as_constant() == Some(0.0);
            conditions.push(match op {
                CmpOp::GtE | CmpOp::Gt if zero(&b) => a,
                CmpOp::LtE | CmpOp::Lt if zero(&a) => b,
                CmpOp::GtE | CmpOp::Gt => a - b,
                CmpOp::LtE | CmpOp::Lt => b - a,
                _ => return Err(it.error(range, "formulas are compared by >= <= > <")),
            });
            continue;
        }
        truth &= match (a, b, op) {
            (Value::Str(a), Value::Str(b), CmpOp::Eq) => a == b,
            (Value::Str(a), Value::Str(b), CmpOp::NotEq) => a != b,
            _ => {
                let (Some(x), Some(y)) = (a.number(), b.number()) else {
                    return Err(it.error(range, format!("{} and {} cannot be compared", a.kind(), b.kind())));
                };
                match op {
                    CmpOp::Eq => x == y,
                    CmpOp::NotEq => x != y,
                    CmpOp::Lt => x < y,
                    CmpOp::LtE => x <= y,
                    CmpOp::Gt => x > y,
                    CmpOp::GtE => x >= y,
                    _ => return Err(it.error(range, format!("{} is not part of the part language", op.as_str()))),
                }
            }
        };
    }
    Ok(if formulas { Value::Condition(Rc::new(conditions)) } else { Value::Bool(truth) })
}

/// `a if condition else b` with a condition on formulas.
pub(super) fn select<'a>(
    it: &It<'a>,
    range: TextRange,
    all: &[Expr],
    a: &Value<'a>,
    b: &Value<'a>,
) -> Result<Value<'a>> {
    let (Some(x), Some(y)) = (a.formula(), b.formula()) else {
        return Err(it
            .error(range, "a condition on formulas chooses between formulas")
            .with_help("solids are chosen by (c & a) | (~c & b)"));
    };
    it.grow(range, all.len())?;
    let condition = all.iter().cloned().reduce(|a, b| Expr::binary(Binary::Min, a, b));
    Ok(condition.map_or(Value::from_formula(x.clone()), |c| Value::from_formula(Expr::select(c, x, y))))
}

fn whole(v: &Value<'_>) -> Option<i64> {
    match v {
        Value::Int(i) => Some(*i),
        _ => None,
    }
}

pub(super) fn index<'a>(it: &It<'a>, range: TextRange, v: &Value<'a>, i: &Value<'a>) -> Result<Value<'a>> {
    let Some(items) = v.items() else { return Err(it.error(range, format!("{} has no items", v.kind()))) };
    let Some(i) = whole(i) else {
        return Err(it.error(range, format!("an index is a whole number, not {}", i.kind())));
    };
    let n = items.len() as i64;
    let at = if i < 0 { i.saturating_add(n) } else { i };
    usize::try_from(at)
        .ok()
        .and_then(|at| items.get(at))
        .cloned()
        .ok_or_else(|| it.error(range, format!("index {i} is out of range: there are {n} items")))
}

pub(super) fn slice<'a>(
    it: &It<'a>,
    range: TextRange,
    v: &Value<'a>,
    bounds: &[Option<Value<'a>>; 3],
) -> Result<Value<'a>> {
    let Some(items) = v.items() else { return Err(it.error(range, format!("{} has no items", v.kind()))) };
    let mut b = [None; 3];
    for (slot, v) in b.iter_mut().zip(bounds) {
        if let Some(v) = v {
            *slot = Some(whole(v).ok_or_else(|| it.error(range, "slices are bounded by whole numbers"))?);
        }
    }
    let n = items.len() as i64;
    let step = b[2].unwrap_or(1);
    if step == 0 {
        return Err(it.error(range, "the step of a slice must not be zero"));
    }
    let (low, high) = if step > 0 { (0, n) } else { (-1, n - 1) };
    let clamp = |i: i64| (if i < 0 { i.saturating_add(n) } else { i }).clamp(low, high);
    let (start, stop) = if step > 0 {
        (b[0].map_or(0, clamp), b[1].map_or(n, clamp))
    } else {
        (b[0].map_or(n - 1, clamp), b[1].map_or(-1, clamp))
    };
    let mut out = Vec::new();
    let mut i = start;
    while (step > 0 && i < stop) || (step < 0 && i > stop) {
        out.push(items[i as usize].clone());
        i = i.saturating_add(step);
    }
    it.fits(range, out.len())?;
    Ok(if matches!(v, Value::Tuple(_)) { Value::Tuple(Rc::new(out)) } else { Value::List(Rc::new(out)) })
}
