//! Scalar formulas in `x`, `y`, `z`: the raw material of formula leaves.

use std::f64::consts::{FRAC_PI_2, PI, TAU};
use std::ops;
use std::sync::Arc;

use rustc_hash::FxHashSet;

use crate::numeric::vector;

/// Operations of one argument.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Unary {
    /// `-a`
    Neg,
    /// `|a|`
    Abs,
    /// Square root; NaN below 0.
    Sqrt,
    /// `e^a`
    Exp,
    /// Natural logarithm; NaN below 0.
    Log,
    /// Sine, radians.
    Sin,
    /// Cosine, radians.
    Cos,
    /// Tangent, radians.
    Tan,
    /// The angle less whole turns, from -pi to pi, radians: what `atan2(sin(a), cos(a))` is.
    Wrap,
    /// The angle less whole turns up to 5/6 pi either way, and from there back to 0 at half a turn: without a jump, radians.
    Swing,
    /// The angle less whole turns, from -150 to 210 degrees, radians: it goes on upward where [`Wrap`](Self::Wrap) jumps.
    Upward,
    /// The angle less whole turns, from -210 to 150 degrees, radians: it goes on downward where [`Wrap`](Self::Wrap) jumps.
    Downward,
    /// The distance of an angle from whole turns, 0 to pi, radians: continuous, with creases at both ends.
    Fold,
    /// `a`, but three times that where it is negative.
    Steepened,
    /// Inverse sine in radians; NaN outside of -1 to 1.
    Asin,
    /// Inverse cosine in radians; NaN outside of -1 to 1.
    Acos,
    /// Hyperbolic sine.
    Sinh,
    /// Hyperbolic cosine.
    Cosh,
    /// Hyperbolic tangent.
    Tanh,
    /// The largest whole number that is not above.
    Floor,
    /// -1, 0 or 1.
    Sign,
}

/// Operations of two arguments.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Binary {
    /// `a + b`
    Add,
    /// `a - b`
    Sub,
    /// `a * b`
    Mul,
    /// `a / b`
    Div,
    /// `a ** b`
    Pow,
    /// The smaller one.
    Min,
    /// The larger one.
    Max,
    /// `atan2(a, b)`: angle of the point (b, a).
    Atan2,
    /// `sqrt(a*a + b*b)`
    Hypot,
    /// `a - b * floor(a / b)`: the remainder with the sign of `b`.
    Mod,
}

/// A node of a formula. Shared subformulas are shared nodes.
#[derive(Debug, Clone, PartialEq)]
pub enum ExprNode {
    /// A number.
    Const(f64),
    /// A coordinate: 0 for x, 1 for y, 2 for z.
    Coordinate(u8),
    /// An operation of one argument.
    Unary(Unary, Expr),
    /// An operation of two arguments.
    Binary(Binary, Expr, Expr),
    /// `if condition >= 0 { a } else { b }`
    Select(Expr, Expr, Expr),
}

/// A formula in `x`, `y`, `z`. Cloning is cheap.
#[derive(Debug, Clone)]
pub struct Expr(pub(crate) Arc<ExprNode>);

/// The operands of a node.
pub(super) fn operands(e: &Expr) -> Vec<&Expr> {
    match e.node() {
        ExprNode::Const(_) | ExprNode::Coordinate(_) => Vec::new(),
        ExprNode::Unary(_, a) => vec![a],
        ExprNode::Binary(_, a, b) => vec![a, b],
        ExprNode::Select(a, b, c) => vec![a, b, c],
    }
}

/// Whether a formula has a node that is asked for.
pub(super) fn holds(e: &Expr, mut is_one: impl FnMut(&Expr) -> bool) -> bool {
    let mut seen = FxHashSet::default();
    let mut stack = vec![e];
    while let Some(e) = stack.pop() {
        if seen.insert(Arc::as_ptr(&e.0)) {
            if is_one(e) {
                return true;
            }
            stack.extend(operands(e));
        }
    }
    false
}

/// A node with others in the place of its operands.
pub(super) fn with_operands(e: &Expr, of: impl Fn(&Expr) -> Expr) -> Expr {
    match e.node() {
        ExprNode::Const(_) | ExprNode::Coordinate(_) => e.clone(),
        ExprNode::Unary(op, a) => Expr::unary(*op, of(a)),
        ExprNode::Binary(op, a, b) => Expr::binary(*op, of(a), of(b)),
        ExprNode::Select(a, b, c) => Expr::select(of(a), of(b), of(c)),
    }
}

/// Whether both are written alike. The same node is like itself.
impl PartialEq for Expr {
    fn eq(&self, other: &Self) -> bool {
        // Each pair of nodes once: written out, formulas that share nodes are exponentially long.
        let mut seen = FxHashSet::default();
        let mut stack = vec![(self, other)];
        while let Some((a, b)) = stack.pop() {
            if Arc::ptr_eq(&a.0, &b.0) || !seen.insert((Arc::as_ptr(&a.0), Arc::as_ptr(&b.0))) {
                continue;
            }
            let alike = match (a.node(), b.node()) {
                (ExprNode::Const(p), ExprNode::Const(q)) => p == q,
                (ExprNode::Coordinate(p), ExprNode::Coordinate(q)) => p == q,
                (ExprNode::Unary(p, _), ExprNode::Unary(q, _)) => p == q,
                (ExprNode::Binary(p, ..), ExprNode::Binary(q, ..)) => p == q,
                (ExprNode::Select(..), ExprNode::Select(..)) => true,
                _ => false,
            };
            if !alike {
                return false;
            }
            stack.extend(operands(a).into_iter().zip(operands(b)));
        }
        true
    }
}

impl Expr {
    /// A number.
    pub fn constant(value: f64) -> Self {
        Expr(Arc::new(ExprNode::Const(value)))
    }

    /// The coordinate x.
    pub fn x() -> Self {
        Expr(Arc::new(ExprNode::Coordinate(0)))
    }

    /// The coordinate y.
    pub fn y() -> Self {
        Expr(Arc::new(ExprNode::Coordinate(1)))
    }

    /// The coordinate z.
    pub fn z() -> Self {
        Expr(Arc::new(ExprNode::Coordinate(2)))
    }

    /// The node at the root.
    pub fn node(&self) -> &ExprNode {
        &self.0
    }

    /// The value, if the formula is a plain number.
    pub fn as_constant(&self) -> Option<f64> {
        match *self.0 {
            ExprNode::Const(c) => Some(c),
            _ => None,
        }
    }

    /// Applies `op`; numbers are folded.
    pub fn unary(op: Unary, a: Expr) -> Self {
        match a.as_constant() {
            Some(a) => Expr::constant(op.apply(a)),
            None => Expr(Arc::new(ExprNode::Unary(op, a))),
        }
    }

    /// Applies `op`; numbers are folded, and so is the angle of a point on the circle, `atan2(sin(a), cos(a))` and its kin.
    pub fn binary(op: Binary, a: Expr, b: Expr) -> Self {
        match (a.as_constant(), b.as_constant()) {
            (Some(a), Some(b)) => Expr::constant(op.apply(a, b)),
            _ if op == Binary::Atan2
                && let Some(angle) = angle_on_circle(&a, &b) =>
            {
                Expr::unary(Unary::Wrap, angle)
            }
            _ => Expr(Arc::new(ExprNode::Binary(op, a, b))),
        }
    }

    /// The nearest whole number; halves go up.
    pub fn round(self) -> Self {
        match self.as_constant() {
            Some(a) => Expr::constant(a.round_ties_even()),
            None => Expr::unary(Unary::Floor, self + 0.5),
        }
    }

    /// The smallest whole number that is not below.
    pub fn ceil(self) -> Self {
        -Expr::unary(Unary::Floor, -self)
    }

    /// The whole number next to it in the direction of zero.
    pub fn trunc(self) -> Self {
        let below = Expr::unary(Unary::Floor, self.clone());
        Expr::select(self.clone(), below, self.ceil())
    }

    /// The remainder with the sign of the first operand, as `fmod` in C.
    pub fn fmod(self, b: Expr) -> Self {
        if let (Some(a), Some(b)) = (self.as_constant(), b.as_constant()) {
            return Expr::constant(a % b);
        }
        let size = Expr::unary(Unary::Abs, b);
        let rest = |a: Expr| Expr::binary(Binary::Mod, a, size.clone());
        Expr::select(self.clone(), rest(self.clone()), -rest(-self))
    }

    /// `if condition >= 0 { a } else { b }`
    pub fn select(condition: Expr, a: Expr, b: Expr) -> Self {
        match condition.as_constant() {
            Some(c) if c >= 0.0 => a,
            Some(_) => b,
            None => Expr(Arc::new(ExprNode::Select(condition, a, b))),
        }
    }
}

/// How many times steeper [`Unary::Steepened`] is below zero.
pub(crate) const STEEPENED: f64 = 3.0;

/// How far [`Unary::Upward`] and [`Unary::Downward`] go on beyond half a turn. Less than 150 degrees to the side they are the same, so that
/// one can follow the other at 121 degrees, and cells fit between there and where either jumps, but next to the origin.
pub(crate) const BEYOND: f64 = PI / 6.0;

/// Where [`Unary::Swing`] turns back. Leaves go on 36 degrees beyond their creases, and as many are left from there to
/// where they turn back: a thread takes two thirds of the cells that it takes with a turn at 150 degrees.
pub(crate) const SWING: f64 = 17.0 * PI / 18.0;
/// How steeply it does: from there to half a turn, a 17th of the way, it comes back to zero.
pub(crate) const SWUNG_BACK: f64 = 17.0;

/// Formulas with more nodes than this are not compared.
const MOST_COMPARED: usize = 256;

/// Whether two formulas are the same, node by node; large ones only if they are one object.
fn same(a: &Expr, b: &Expr) -> bool {
    let (mut stack, mut seen) = (vec![(a, b)], 0);
    while let Some((a, b)) = stack.pop() {
        if Arc::ptr_eq(&a.0, &b.0) {
            continue;
        }
        seen += 1;
        match (a.node(), b.node()) {
            _ if seen > MOST_COMPARED => return false,
            (ExprNode::Const(p), ExprNode::Const(q)) if p.to_bits() == q.to_bits() => {}
            (ExprNode::Coordinate(p), ExprNode::Coordinate(q)) if p == q => {}
            (ExprNode::Unary(p, a), ExprNode::Unary(q, b)) if p == q => stack.push((a, b)),
            (ExprNode::Binary(p, a, c), ExprNode::Binary(q, b, d)) if p == q => stack.extend([(a, b), (c, d)]),
            (ExprNode::Select(a, c, e), ExprNode::Select(b, d, f)) => stack.extend([(a, b), (c, d), (e, f)]),
            _ => return false,
        }
    }
    true
}

/// The angle of the point (x, y) up to whole turns, if one of them is the sine of some angle or its opposite, and the other the
/// cosine of the same.
fn angle_on_circle(y: &Expr, x: &Expr) -> Option<Expr> {
    /// A sine or cosine, its sign, and its angle.
    fn part(e: &Expr) -> Option<(Unary, bool, &Expr)> {
        match e.node() {
            ExprNode::Unary(op @ (Unary::Sin | Unary::Cos), t) => Some((*op, false, t)),
            ExprNode::Unary(Unary::Neg, e) => match e.node() {
                ExprNode::Unary(op @ (Unary::Sin | Unary::Cos), t) => Some((*op, true, t)),
                _ => None,
            },
            _ => None,
        }
    }
    let ((of_y, y_negative, t), (of_x, x_negative, u)) = (part(y)?, part(x)?);
    if of_x == of_y || !same(t, u) {
        return None;
    }
    let t = t.clone();
    Some(match (of_y, y_negative, x_negative) {
        (Unary::Sin, false, false) => t,
        (Unary::Sin, true, false) => -t,
        (Unary::Sin, false, true) => -t + PI,
        (Unary::Sin, true, true) => t - PI,
        (_, false, false) => -t + FRAC_PI_2,
        (_, true, false) => t - FRAC_PI_2,
        (_, false, true) => t + FRAC_PI_2,
        (_, true, true) => -t - FRAC_PI_2,
    })
}

impl Unary {
    /// Whether it is an angle beyond half a turn.
    pub(crate) fn goes_on(self) -> bool {
        matches!(self, Unary::Upward | Unary::Downward)
    }

    /// The operation on numbers.
    pub fn apply(self, a: f64) -> f64 {
        match self {
            Unary::Neg => -a,
            Unary::Abs => a.abs(),
            Unary::Sqrt => a.sqrt(),
            Unary::Exp => vector::exp(a),
            Unary::Log => vector::ln(a),
            Unary::Sin => vector::sin(a),
            Unary::Cos => vector::cos(a),
            Unary::Tan => a.tan(),
            Unary::Wrap => a - TAU * (a / TAU).round(),
            Unary::Fold => Unary::Wrap.apply(a).abs(),
            Unary::Steepened => {
                if a < 0.0 {
                    a * STEEPENED
                } else {
                    a
                }
            }
            Unary::Swing => {
                let w = Unary::Wrap.apply(a);
                if w.abs() > SWING { (PI - w.abs()).copysign(w) * SWUNG_BACK } else { w }
            }
            Unary::Upward => a - TAU * ((a - BEYOND) / TAU).round(),
            Unary::Downward => a - TAU * ((a + BEYOND) / TAU).round(),
            Unary::Asin => a.asin(),
            Unary::Acos => a.acos(),
            Unary::Sinh => a.sinh(),
            Unary::Cosh => a.cosh(),
            Unary::Tanh => a.tanh(),
            Unary::Floor => a.floor(),
            Unary::Sign if a == 0.0 => 0.0,
            Unary::Sign if a.is_nan() => a,
            Unary::Sign => a.signum(),
        }
    }
}

impl Binary {
    /// Whether a power is made of products.
    pub(crate) fn is_whole_power(exponent: f64) -> bool {
        exponent.fract() == 0.0 && exponent.abs() <= 64.0
    }

    /// The operation on numbers. `Min` and `Max` return NaN if either argument is NaN.
    pub fn apply(self, a: f64, b: f64) -> f64 {
        match self {
            Binary::Add => a + b,
            Binary::Sub => a - b,
            Binary::Mul => a * b,
            Binary::Div => a / b,
            Binary::Pow => {
                if Self::is_whole_power(b) {
                    vector::powi(a, b as i32)
                } else {
                    a.powf(b)
                }
            }
            Binary::Min => {
                if a.is_nan() || a < b {
                    a
                } else {
                    b
                }
            }
            Binary::Max => {
                if a.is_nan() || a > b {
                    a
                } else {
                    b
                }
            }
            Binary::Atan2 => vector::atan2(a, b),
            Binary::Hypot => vector::hypot(a, b),
            // What rounding makes of a quotient just below a whole number stays between 0 and b.
            Binary::Mod => {
                let rest = a - b * (a / b).floor();
                if rest.is_nan() || b == 0.0 { f64::NAN } else { rest.clamp(b.min(0.0), b.max(0.0)) }
            }
        }
    }
}

impl From<f64> for Expr {
    fn from(value: f64) -> Self {
        Expr::constant(value)
    }
}

macro_rules! operator {
    ($trait:ident, $method:ident, $op:ident) => {
        impl ops::$trait for Expr {
            type Output = Expr;
            fn $method(self, other: Expr) -> Expr {
                Expr::binary(Binary::$op, self, other)
            }
        }
        impl ops::$trait<f64> for Expr {
            type Output = Expr;
            fn $method(self, other: f64) -> Expr {
                Expr::binary(Binary::$op, self, Expr::constant(other))
            }
        }
    };
}
operator!(Add, add, Add);
operator!(Sub, sub, Sub);
operator!(Mul, mul, Mul);
operator!(Div, div, Div);

impl ops::Neg for Expr {
    type Output = Expr;
    fn neg(self) -> Expr {
        Expr::unary(Unary::Neg, self)
    }
}

/// Takes the tree apart without recursion: a formula may be millions of nodes deep.
impl Drop for Expr {
    fn drop(&mut self) {
        fn children(node: &mut ExprNode, stack: &mut Vec<Expr>) {
            let leaf = || Expr(LEAF.with(Arc::clone));
            match node {
                ExprNode::Const(_) | ExprNode::Coordinate(_) => {}
                ExprNode::Unary(_, a) => stack.push(std::mem::replace(a, leaf())),
                ExprNode::Binary(_, a, b) => {
                    stack.push(std::mem::replace(a, leaf()));
                    stack.push(std::mem::replace(b, leaf()));
                }
                ExprNode::Select(a, b, c) => {
                    stack.push(std::mem::replace(a, leaf()));
                    stack.push(std::mem::replace(b, leaf()));
                    stack.push(std::mem::replace(c, leaf()));
                }
            }
        }
        thread_local! {
            static LEAF: Arc<ExprNode> = Arc::new(ExprNode::Const(0.0));
        }
        let Some(node) = Arc::get_mut(&mut self.0) else { return };
        if matches!(node, ExprNode::Const(_) | ExprNode::Coordinate(_)) {
            return;
        }
        let mut stack = Vec::new();
        children(node, &mut stack);
        while let Some(mut e) = stack.pop() {
            if let Some(node) = Arc::get_mut(&mut e.0) {
                children(node, &mut stack);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn formulas_that_share_nodes_are_compared_node_by_node() {
        // Written out, each has 2^200 nodes.
        let chain = |first: f64| (0..200).fold(Expr::x() + first, |e, _| e.clone() * e);
        assert!(chain(1.0) == chain(1.0));
        assert!(chain(1.0) != chain(2.0));
        assert!(chain(1.0) != chain(1.0) + Expr::y());
        // No recursion.
        let deep = |last: f64| (0..1_000_000).fold(Expr::y() * last, |e, _| Expr::unary(Unary::Sin, e));
        assert!(deep(2.0) == deep(2.0) && deep(2.0) != deep(3.0));
    }
}
