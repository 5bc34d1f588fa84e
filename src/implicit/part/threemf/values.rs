//! What nodes of a 3MF function compute: numbers, vectors and matrices of formulas.

use std::f64::consts::{LN_2, LN_10};
use std::sync::Arc;

use super::super::super::expr::{Binary, Expr, Unary};

/// The value of an output.
#[derive(Debug, Clone)]
pub(super) enum Value {
    Scalar(Expr),
    Vector([Expr; 3]),
    /// Row by row.
    Matrix(Box<[Expr; 16]>),
    /// The number of a resource.
    Resource(u64),
}

impl Value {
    /// What it is called in a message.
    pub(super) fn kind(&self) -> &'static str {
        match self {
            Value::Scalar(_) => "a scalar",
            Value::Vector(_) => "a vector",
            Value::Matrix(_) => "a matrix",
            Value::Resource(_) => "a resource",
        }
    }

    /// Its formulas.
    pub(super) fn parts(&self) -> &[Expr] {
        match self {
            Value::Scalar(e) => std::slice::from_ref(e),
            Value::Vector(all) => all,
            Value::Matrix(all) => &all[..],
            Value::Resource(_) => &[],
        }
    }

    pub(super) fn scalar(&self) -> Option<Expr> {
        if let Value::Scalar(e) = self { Some(e.clone()) } else { None }
    }

    pub(super) fn vector(&self) -> Option<[Expr; 3]> {
        if let Value::Vector(v) = self { Some(v.clone()) } else { None }
    }

    pub(super) fn matrix(&self) -> Option<[Expr; 16]> {
        if let Value::Matrix(m) = self { Some((**m).clone()) } else { None }
    }
}

/// Inputs of operations that work on each number by itself; `None` for other operations.
pub(super) fn inputs_of(word: &str) -> Option<&'static [&'static str]> {
    Some(match word {
        "sin" | "cos" | "tan" | "arcsin" | "arccos" | "arctan" | "asin" | "acos" | "atan" | "abs" | "sqrt" | "exp"
        | "log" | "log2" | "log10" | "cosh" | "sinh" | "tanh" | "round" | "ceil" | "floor" | "sign" | "fract" => &["A"],
        "addition" | "subtraction" | "multiplication" | "division" | "min" | "max" | "fmod" | "mod" | "pow"
        | "arctan2" | "atan2" => &["A", "B"],
        "clamp" => &["A", "min", "max"],
        "select" => &["A", "B", "C", "D"],
        _ => return None,
    })
}

/// The operation on each number by itself; `None` for kinds of values that do not go together.
pub(super) fn by_component(word: &str, operands: &[Value]) -> Option<Value> {
    let first = operands.first()?;
    let count = first.parts().len();
    let same = |v: &Value| std::mem::discriminant(v) == std::mem::discriminant(first);
    if count == 0 || !operands.iter().all(same) {
        return None;
    }
    let mut results = (0..count).map(|k| {
        let all: Vec<Expr> = operands.iter().map(|v| v.parts()[k].clone()).collect();
        applied(word, all)
    });
    let mut next = || results.next().flatten();
    Some(match first {
        Value::Scalar(_) => Value::Scalar(next()?),
        Value::Vector(_) => Value::Vector([next()?, next()?, next()?]),
        _ => Value::Matrix(Box::new(results.collect::<Option<Vec<_>>>()?.try_into().ok()?)),
    })
}

fn applied(word: &str, operands: Vec<Expr>) -> Option<Expr> {
    let mut operands = operands.into_iter();
    let a = operands.next()?;
    let un = |op: Unary, a: Expr| Some(Expr::unary(op, a));
    match word {
        "sin" => un(Unary::Sin, a),
        "cos" => un(Unary::Cos, a),
        "tan" => un(Unary::Tan, a),
        "arcsin" | "asin" => un(Unary::Asin, a),
        "arccos" | "acos" => un(Unary::Acos, a),
        "arctan" | "atan" => Some(Expr::binary(Binary::Atan2, a, Expr::constant(1.0))),
        "abs" => un(Unary::Abs, a),
        "sqrt" => un(Unary::Sqrt, a),
        "exp" => un(Unary::Exp, a),
        "log" => un(Unary::Log, a),
        "log2" => Some(a.as_constant().map_or_else(|| Expr::unary(Unary::Log, a) / LN_2, |c| Expr::constant(c.log2()))),
        "log10" => {
            Some(a.as_constant().map_or_else(|| Expr::unary(Unary::Log, a) / LN_10, |c| Expr::constant(c.log10())))
        }
        "cosh" => un(Unary::Cosh, a),
        "sinh" => un(Unary::Sinh, a),
        "tanh" => un(Unary::Tanh, a),
        "round" => Some(match a.as_constant() {
            Some(c) => Expr::constant(c.round()),
            None => a.round(),
        }),
        "ceil" => Some(a.ceil()),
        "floor" => un(Unary::Floor, a),
        "sign" => un(Unary::Sign, a),
        "fract" => Some(a.clone() - Expr::unary(Unary::Floor, a)),
        _ => more(word, a, operands.collect()),
    }
}

/// Operations of two and more operands.
fn more(word: &str, a: Expr, rest: Vec<Expr>) -> Option<Expr> {
    let b = rest.first()?.clone();
    Some(match (word, &rest[1..]) {
        ("addition", []) => a + b,
        // How formulas are turned round where there is no operation for it.
        ("subtraction", []) if a.as_constant() == Some(0.0) => -b,
        ("subtraction", []) => a - b,
        ("multiplication", []) if Arc::ptr_eq(&a.0, &b.0) => Expr::binary(Binary::Pow, a, Expr::constant(2.0)),
        ("multiplication", []) if a.as_constant() == Some(-1.0) => -b,
        ("multiplication", []) if b.as_constant() == Some(-1.0) => -a,
        ("multiplication", []) => a * b,
        ("division", []) => a / b,
        ("min", []) => Expr::binary(Binary::Min, a, b),
        ("max", []) => Expr::binary(Binary::Max, a, b),
        ("fmod", []) => a.fmod(b),
        ("mod", []) => Expr::binary(Binary::Mod, a, b),
        ("pow", []) => Expr::binary(Binary::Pow, a, b),
        ("arctan2" | "atan2", []) => Expr::binary(Binary::Atan2, a, b),
        ("clamp", [most]) => Expr::binary(Binary::Max, b, Expr::binary(Binary::Min, a, most.clone())),
        ("select", [c, d]) => Expr::select(a - b, d.clone(), c.clone()),
        _ => return None,
    })
}

/// The sum of products.
pub(super) fn dot(a: &[Expr], b: &[Expr]) -> Expr {
    let products = a.iter().zip(b).map(|(a, b)| times(a, b));
    products.reduce(plus).unwrap_or_else(|| Expr::constant(0.0))
}

/// A product; matrices are full of zeros and ones.
fn times(a: &Expr, b: &Expr) -> Expr {
    match (a.as_constant(), b.as_constant()) {
        (Some(0.0), _) | (_, Some(0.0)) => Expr::constant(0.0),
        (Some(1.0), _) => b.clone(),
        (_, Some(1.0)) => a.clone(),
        _ if Arc::ptr_eq(&a.0, &b.0) => Expr::binary(Binary::Pow, a.clone(), Expr::constant(2.0)),
        _ => a.clone() * b.clone(),
    }
}

fn plus(a: Expr, b: Expr) -> Expr {
    match (a.as_constant(), b.as_constant()) {
        (Some(0.0), _) => b,
        (_, Some(0.0)) => a,
        _ => a + b,
    }
}

fn minus(a: Expr, b: Expr) -> Expr {
    if b.as_constant() == Some(0.0) { a } else { a - b }
}

pub(super) fn cross(a: &[Expr; 3], b: &[Expr; 3]) -> [Expr; 3] {
    let of = |i: usize, j: usize| minus(times(&a[i], &b[j]), times(&a[j], &b[i]));
    [of(1, 2), of(2, 0), of(0, 1)]
}

/// The matrix times the point, whose fourth coordinate is 1.
pub(super) fn moved(m: &[Expr; 16], p: &[Expr; 3]) -> [Expr; 3] {
    std::array::from_fn(|row| plus(dot(&m[4 * row..4 * row + 3], p), m[4 * row + 3].clone()))
}

pub(super) fn transposed(m: &[Expr; 16]) -> [Expr; 16] {
    std::array::from_fn(|i| m[4 * (i % 4) + i / 4].clone())
}

/// The inverse by cofactors.
pub(super) fn inverse(m: &[Expr; 16]) -> [Expr; 16] {
    let cofactors: [Expr; 16] = std::array::from_fn(|i| {
        let others = |skip: usize| -> [usize; 3] { std::array::from_fn(|k| k + usize::from(k >= skip)) };
        let (rows, columns) = (others(i / 4), others(i % 4));
        let line = |k: usize| -> [Expr; 3] { std::array::from_fn(|c| m[4 * rows[k] + columns[c]].clone()) };
        let minor = dot(&line(0), &cross(&line(1), &line(2)));
        if (i / 4 + i % 4) % 2 == 1 { -minor } else { minor }
    });
    let determinant = dot(&m[..4], &cofactors[..4]);
    transposed(&cofactors).map(|c| c / determinant.clone())
}
