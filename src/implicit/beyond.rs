//! Distances to boxes, cylinders and their like as they are commonly written: `min(max(a, b), 0) + hypot(max(a, 0), max(b, 0))`. Inside
//! that is the greater of the distances to both faces, outside the distance to what they share. Its sign is that of `max(a, b)`. The
//! lengths in such distances may be of more than two formulas, and are taken apart here, too.

use super::expr::{Binary, Expr, ExprNode, Unary};
use super::roperation::{Terms, never_negative};
use super::steps::rewritten;

/// Sums, products and multiples are followed this deep, and products have no more factors than this: it bounds the stack.
pub(super) const DEEPEST: usize = 32;

/// A formula of the same sign as a sum, and the sign it is to be taken with.
pub(super) struct Sign {
    pub(super) of: Expr,
    pub(super) factor: f64,
}

/// The sign of a sum of `min(max(a, b), 0)`, of what is zero where `a` and `b` are both at most zero and positive elsewhere, and of a
/// number: a distance to walk on from the faces. Outside only what is beyond them counts, inside only the greatest.
pub(super) fn sign_of_distance(e: &Expr, terms: &mut Terms) -> Option<Sign> {
    let (numbers, mut addends): (Vec<_>, Vec<_>) =
        terms.addends(e).into_iter().partition(|(a, _)| a.as_constant().is_some());
    let within = addends.iter().position(|(a, _)| beside_zero(a, Binary::Min).is_some())?;
    let (within, factor) = addends.swap_remove(within);
    let greatest = beside_zero(&within, Binary::Min)?;
    let mut beyond = Vec::new();
    for (a, k) in &addends {
        (k * factor > 0.0).then_some(())?;
        is_beyond(a, terms, &mut beyond, 0)?;
    }
    let mut faces = Vec::new();
    faces_of(greatest, terms, &mut faces, 0)?;
    for list in [&mut beyond, &mut faces] {
        list.sort_unstable();
        list.dedup();
    }
    (beyond == faces).then_some(())?;
    let number: f64 = numbers.iter().map(|(a, k)| a.as_constant().unwrap_or(0.0) * k).sum::<f64>() / factor;
    let of = if number < 0.0 {
        let away = addends.into_iter().map(|(a, k)| a * (k / factor)).reduce(|a, b| a + b)?;
        away + number
    } else if number == 0.0 {
        greatest.clone()
    } else {
        greatest.clone() + number
    };
    Some(Sign { of, factor: factor.signum() })
}

/// The formulas of which the greatest, `max(a, b)`, is the value where none is positive, and the length of the positive ones elsewhere, if
/// this is such a sum: a distance to what has these faces.
pub(super) fn distance_to_faces(e: &Expr, terms: &mut Terms) -> Option<Vec<Expr>> {
    let ExprNode::Binary(Binary::Add, ..) = e.node() else { return None };
    let Displaced { faces, factor, others } = displaced(e, terms)?;
    (factor == 1.0 && others.is_empty()).then_some(faces)
}

/// A distance to faces, times a factor, with other terms beside it.
pub(super) struct Displaced {
    pub(super) faces: Vec<Expr>,
    pub(super) factor: f64,
    /// With their own factors.
    pub(super) others: Vec<(Expr, f64)>,
}

/// The distance among the terms of a sum, if there is one.
pub(super) fn displaced(e: &Expr, terms: &mut Terms) -> Option<Displaced> {
    let mut others = terms.addends(e);
    let within = others.iter().position(|(a, _)| beside_zero(a, Binary::Min).is_some())?;
    let (within, factor) = others.swap_remove(within);
    let mut numbers = Vec::new();
    let greatest = beside_zero(&within, Binary::Min)?;
    if has_number(greatest, 0) {
        return None;
    }
    faces_of(greatest, terms, &mut numbers, 0)?;
    numbers.sort_unstable();
    for k in 0..others.len() {
        let mut beyond = Vec::new();
        if others[k].1 != factor || parts_of_length(&others[k].0, &mut beyond, 0).is_none() {
            continue;
        }
        let faces: Vec<Expr> = beyond.iter().filter_map(|part| beside_zero(part, Binary::Max).cloned()).collect();
        let mut found: Vec<u32> = faces.iter().map(|f| terms.number(f)).collect();
        found.sort_unstable();
        if faces.len() == beyond.len() && faces.len() > 1 && numbers == found {
            others.swap_remove(k);
            return Some(Displaced { faces, factor, others });
        }
    }
    None
}

/// Notes what a length is of.
fn parts_of_length(e: &Expr, parts: &mut Vec<Expr>, depth: usize) -> Option<()> {
    (depth < DEEPEST).then_some(())?;
    match e.node() {
        ExprNode::Binary(Binary::Hypot, a, b) => {
            for side in [a, b] {
                if parts_of_length(side, parts, depth + 1).is_none() {
                    parts.push(side.clone());
                }
            }
            Some(())
        }
        ExprNode::Unary(Unary::Sqrt, sum) => squares_of(sum, parts, depth + 1),
        _ => None,
    }
}

fn squares_of(e: &Expr, parts: &mut Vec<Expr>, depth: usize) -> Option<()> {
    (depth < DEEPEST).then_some(())?;
    match e.node() {
        ExprNode::Binary(Binary::Add, a, b) => {
            squares_of(a, parts, depth + 1)?;
            squares_of(b, parts, depth + 1)
        }
        ExprNode::Binary(Binary::Mul, a, b) if a == b => {
            parts.push(a.clone());
            Some(())
        }
        ExprNode::Binary(Binary::Pow, a, n) if n.as_constant() == Some(2.0) => {
            parts.push(a.clone());
            Some(())
        }
        _ => None,
    }
}

/// The same formula with lengths of lengths as roots of sums of squares. `hypot(hypot(a, b), c)` has no slope where `a` and `b` are zero,
/// as an operation on the first length; the sum has.
pub(super) fn without_nested_lengths(e: &Expr) -> Expr {
    let square = |e: &Expr| e.clone() * e.clone();
    let squared = |e: &Expr| match e.node() {
        ExprNode::Binary(Binary::Hypot, a, b) => Some(square(a) + square(b)),
        ExprNode::Unary(Unary::Sqrt, a) if never_negative(a) => Some(a.clone()),
        _ => None,
    };
    rewritten(e, |e| {
        let ExprNode::Binary(Binary::Hypot, a, b) = e.node() else { return None };
        let of = match (squared(a), squared(b)) {
            (None, None) => return None,
            (p, q) => p.unwrap_or_else(|| square(a)) + q.unwrap_or_else(|| square(b)),
        };
        Some(Expr::unary(Unary::Sqrt, of))
    })
}

/// `a` of `op(a, 0)`
fn beside_zero(e: &Expr, op: Binary) -> Option<&Expr> {
    let ExprNode::Binary(own, a, b) = e.node() else { return None };
    let is_zero = |e: &Expr| e.as_constant() == Some(0.0);
    match (is_zero(a), is_zero(b)) {
        _ if *own != op => None,
        (false, true) => Some(a),
        (true, false) => Some(b),
        _ => None,
    }
}

/// Whether a formula is the greatest of a number and others.
fn has_number(e: &Expr, depth: usize) -> bool {
    match e.node() {
        ExprNode::Binary(Binary::Max, a, b) if depth < DEEPEST => has_number(a, depth + 1) || has_number(b, depth + 1),
        _ => e.as_constant().is_some(),
    }
}

/// Notes the numbers of what a formula is the greatest of. A constant below zero is no face: it bounds the depth inside, as where a
/// coordinate of a box is a number.
fn faces_of(e: &Expr, terms: &mut Terms, faces: &mut Vec<u32>, depth: usize) -> Option<()> {
    (depth < DEEPEST).then_some(())?;
    if let ExprNode::Binary(Binary::Max, a, b) = e.node() {
        faces_of(a, terms, faces, depth + 1)?;
        return faces_of(b, terms, faces, depth + 1);
    }
    if e.as_constant().is_none_or(|c| c >= 0.0) {
        faces.push(terms.number(e));
    }
    Some(())
}

/// Notes the numbers of the formulas that are all at most zero exactly where this one is zero, if it is positive elsewhere.
fn is_beyond(e: &Expr, terms: &mut Terms, beyond: &mut Vec<u32>, depth: usize) -> Option<()> {
    (depth < DEEPEST).then_some(())?;
    if e.as_constant() == Some(0.0) {
        return Some(());
    }
    if let Some(a) = beside_zero(e, Binary::Max) {
        return faces_of(a, terms, beyond, depth + 1);
    }
    let positive = |e: &Expr| e.as_constant().is_some_and(|k| k > 0.0 && k.is_finite());
    match e.node() {
        ExprNode::Binary(Binary::Hypot | Binary::Add, a, b) => {
            is_beyond(a, terms, beyond, depth + 1)?;
            is_beyond(b, terms, beyond, depth + 1)
        }
        // A square is the product of one formula with itself; both have the same zeros.
        ExprNode::Binary(Binary::Mul, a, b) if positive(a) => is_beyond(b, terms, beyond, depth + 1),
        ExprNode::Binary(Binary::Mul | Binary::Div, a, b) if positive(b) => is_beyond(a, terms, beyond, depth + 1),
        ExprNode::Binary(Binary::Mul, a, b) if terms.number(a) == terms.number(b) => {
            is_beyond(a, terms, beyond, depth + 1)
        }
        ExprNode::Binary(Binary::Pow, a, n) if positive(n) => is_beyond(a, terms, beyond, depth + 1),
        ExprNode::Unary(Unary::Sqrt, a) => is_beyond(a, terms, beyond, depth + 1),
        _ => None,
    }
}
