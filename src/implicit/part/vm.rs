//! Formulas as `.vm` text, the form fidget and libfive exchange: one operation a line, negative inside.
//!
//! `_3 add _1 _2` gives the name `_3` to the sum of what `_1` and `_2` name; the last line is the result. Its sign is turned
//! round here, as a solid of this crate is where its function is positive.

use rustc_hash::FxHashMap;

use super::super::expr::{Binary, Expr, ExprNode, Unary};
use super::super::solid::Solid;
use super::csg::MOST_BYTES;
use super::{Part, place};
use crate::error::{Error, Place, Result, nearest};

/// Operations with the number of their operands, for messages.
const OPERATIONS: [(&str, usize); 32] = [
    ("const", 1),
    ("var-x", 0),
    ("var-y", 0),
    ("var-z", 0),
    ("neg", 1),
    ("abs", 1),
    ("square", 1),
    ("sqrt", 1),
    ("recip", 1),
    ("sin", 1),
    ("cos", 1),
    ("tan", 1),
    ("asin", 1),
    ("acos", 1),
    ("atan", 1),
    ("exp", 1),
    ("ln", 1),
    ("floor", 1),
    ("ceil", 1),
    ("round", 1),
    ("not", 1),
    ("const-var", 1),
    ("add", 2),
    ("sub", 2),
    ("mul", 2),
    ("div", 2),
    ("min", 2),
    ("max", 2),
    ("pow", 2),
    ("nth-root", 2),
    ("atan2", 2),
    ("mod", 2),
];

/// Operations of two operands that are made of several of ours.
const COMPOSED: [(&str, usize); 3] = [("compare", 2), ("and", 2), ("or", 2)];

fn operations() -> impl Iterator<Item = &'static (&'static str, usize)> {
    OPERATIONS.iter().chain(&COMPOSED)
}

/// Reads a formula file. The part is where the formula of its last line is negative; all of its surface is one face.
///
/// Chains of `min` or `max` become balanced trees, which have the same values, so that their edges are found however long they
/// are.
///
/// Errors: [`Error::Input`] with line and column for anything wrong in the text, and for a result that is the same everywhere.
pub fn parse_vm(source: &str) -> Result<Part> {
    if source.len() > MOST_BYTES {
        let what = format!("the file has {} bytes: the limit is {MOST_BYTES}", source.len());
        return Err(Error::input(Place::Line(1), what));
    }
    let lines = lines(source)?;
    let Some(last) = lines.last() else {
        return Err(Error::input(place(source, 0, 0), "there is no operation in the file").with_help(EXAMPLE));
    };
    let mut uses = vec![0usize; lines.len()];
    for used in lines.iter().flat_map(|l| l.operands.iter().flatten()) {
        uses[*used] += 1;
    }
    let mut made: Vec<Made> = Vec::with_capacity(lines.len());
    for line in &lines {
        let one = match line.meaning {
            Meaning::Chain(op) => {
                let [Some(a), Some(b)] = line.operands else {
                    return Err(line.error(source, "two operands are missing"));
                };
                let mut take = |i: usize| made[i].links(op, uses[i] == 1);
                let (mut some, mut more) = (take(a), take(b));
                if some.len() < more.len() {
                    std::mem::swap(&mut some, &mut more);
                }
                some.append(&mut more);
                Made::Chain(op, some)
            }
            Meaning::Value(value) => Made::Value(Expr::constant(value)),
            Meaning::Coordinate(axis) => Made::Value([Expr::x(), Expr::y(), Expr::z()][axis % 3].clone()),
            Meaning::Other(name) => {
                let operands = line.operands.map(|i| i.map(|i| made[i].value()));
                let value = applied(name, operands).ok_or_else(|| line.error(source, "the operation is not known"))?;
                if value.as_constant().is_some_and(|c| !c.is_finite()) {
                    return Err(line.error(source, "the result of this operation is not a finite number"));
                }
                Made::Value(value)
            }
        };
        made.push(one);
    }
    let root = made.pop().map(|mut m| m.value()).unwrap_or_else(|| Expr::constant(0.0));
    if root.as_constant().is_some() {
        let what = "the result is the same number everywhere: it does not depend on x, y, z";
        return Err(last.error(source, what).with_help("the last line of the file is its result"));
    }
    Ok(Part::from_solid(crowd(&root).unwrap_or_else(|| Solid::formula(-root))))
}

/// Formulas of more parts than this are taken apart here; lowering does so with fewer.
const MANY: usize = 128;

/// Formulas that would have more parts than this, written out, stay whole.
const MOST_PARTS: usize = 1 << 18;

/// Where a formula is negative, if it is a `min` and `max` of many: as set operations of those, whose surface is one face.
pub(super) fn crowd(root: &Expr) -> Option<Solid> {
    // For each subformula and sign: the solid, and how many parts it has.
    let mut known: FxHashMap<(*const ExprNode, bool), (Solid, usize)> = FxHashMap::default();
    // Without recursion: formulas may be as deep as the file is long.
    let mut stack = vec![(root, true, false)];
    while let Some((e, negative, ready)) = stack.pop() {
        let key = |e: &Expr, negative: bool| (std::ptr::from_ref(e.node()), negative);
        if known.contains_key(&key(e, negative)) {
            continue;
        }
        let (operands, turned): (&[&Expr], bool) = match e.node() {
            ExprNode::Unary(Unary::Neg, a) => (&[a], true),
            ExprNode::Binary(Binary::Min | Binary::Max, a, b) => (&[a, b], false),
            _ => (&[], false),
        };
        if !ready && !operands.is_empty() {
            stack.push((e, negative, true));
            stack.extend(operands.iter().rev().map(|a| (*a, negative != turned, false)));
            continue;
        }
        let below: Vec<_> = operands.iter().filter_map(|a| known.get(&key(a, negative != turned)).cloned()).collect();
        let parts = below.iter().map(|b| b.1).sum::<usize>().max(1);
        if parts > MOST_PARTS {
            return None;
        }
        let mut below = below.into_iter().map(|b| b.0);
        let solid = match (below.next(), below.next(), e.node()) {
            (Some(a), Some(b), ExprNode::Binary(op, ..)) if (*op == Binary::Min) != negative => a & b,
            (Some(a), Some(b), _) => a | b,
            (Some(a), None, _) => a,
            _ => Solid::formula(if negative { -e.clone() } else { e.clone() }),
        };
        known.insert(key(e, negative), (solid, parts));
    }
    let (solid, parts) = known.remove(&(std::ptr::from_ref(root.node()), true))?;
    (parts > MANY).then(|| solid.name("formula1"))
}

/// What a file looks like.
const EXAMPLE: &str =
    "each line is a name, an operation and its operands, as in `_2 add _0 _1`; the last one is the result";

/// What a line says.
struct Line<'a> {
    /// Where the operation's word stands in the file.
    at: usize,
    word: &'a str,
    meaning: Meaning<'a>,
    /// Numbers of the lines its operands are.
    operands: [Option<usize>; 2],
}

impl Line<'_> {
    fn error(&self, source: &str, what: &str) -> Error {
        Error::input(place(source, self.at, self.at + self.word.len()), format!("{:?}: {what}", self.word))
    }
}

#[derive(Clone, Copy)]
enum Meaning<'a> {
    Value(f64),
    Coordinate(usize),
    /// `min` or `max`.
    Chain(Binary),
    Other(&'a str),
}

/// What a line has become.
enum Made {
    Value(Expr),
    /// Operands of a `min` or a `max` that are still to be joined.
    Chain(Binary, Vec<Expr>),
}

impl Made {
    /// The formula.
    fn value(&mut self) -> Expr {
        if let Made::Chain(op, all) = self {
            *self = Made::Value(balanced(*op, std::mem::take(all)));
        }
        match self {
            Made::Value(e) => e.clone(),
            Made::Chain(..) => Expr::constant(0.0),
        }
    }

    /// The operands it brings into a chain; its own where it is such a chain that nobody else uses.
    fn links(&mut self, op: Binary, only_here: bool) -> Vec<Expr> {
        match self {
            Made::Chain(own, all) if only_here && *own == op => std::mem::take(all),
            _ => vec![self.value()],
        }
    }
}

/// The operands joined two by two; there is one at least.
fn balanced(op: Binary, mut all: Vec<Expr>) -> Expr {
    while all.len() > 1 {
        let mut next = Vec::with_capacity(all.len().div_ceil(2));
        let mut rest = all.into_iter();
        while let Some(a) = rest.next() {
            next.push(match rest.next() {
                Some(b) => Expr::binary(op, a, b),
                None => a,
            });
        }
        all = next;
    }
    all.pop().unwrap_or_else(|| Expr::constant(0.0))
}

/// The same formula with chains of `min` or `max` as balanced trees, which have the same values, so that edges are found however
/// long they are.
pub(super) fn balanced_chains(root: &Expr) -> Expr {
    let key = |e: &Expr| std::ptr::from_ref(e.node());
    let operands = |e: &Expr| -> Option<(Binary, [Expr; 2])> {
        match e.node() {
            ExprNode::Binary(op @ (Binary::Min | Binary::Max), a, b) => Some((*op, [a.clone(), b.clone()])),
            _ => None,
        }
    };
    // Only what the root is a min and max of: there the edges are.
    let (mut uses, mut stack) = (FxHashMap::<_, usize>::default(), vec![root.clone()]);
    while let Some(e) = stack.pop() {
        let count = uses.entry(key(&e)).or_default();
        *count += 1;
        if *count == 1 {
            match e.node() {
                ExprNode::Unary(Unary::Neg, a) => stack.push(a.clone()),
                _ => stack.extend(operands(&e).into_iter().flat_map(|o| o.1)),
            }
        }
    }
    let mut done: FxHashMap<*const ExprNode, Made> = FxHashMap::default();
    let mut stack = vec![(root.clone(), false)];
    while let Some((e, ready)) = stack.pop() {
        if done.contains_key(&key(&e)) {
            continue;
        }
        let below = match e.node() {
            ExprNode::Unary(Unary::Neg, a) => vec![a.clone()],
            _ => operands(&e).map_or_else(Vec::new, |o| o.1.to_vec()),
        };
        if !ready && !below.is_empty() {
            stack.push((e, true));
            stack.extend(below.into_iter().rev().map(|a| (a, false)));
            continue;
        }
        let mut value = |a: &Expr| done.get_mut(&key(a)).map_or_else(|| a.clone(), Made::value);
        let made = match (e.node(), operands(&e)) {
            (ExprNode::Unary(Unary::Neg, a), _) => Made::Value(-value(a)),
            (_, Some((op, both))) => {
                let mut links = both.iter().map(|a| {
                    let only_here = uses.get(&key(a)) == Some(&1);
                    done.get_mut(&key(a)).map_or_else(|| vec![a.clone()], |m| m.links(op, only_here))
                });
                let (mut some, mut more) = (links.next().unwrap_or_default(), links.next().unwrap_or_default());
                if some.len() < more.len() {
                    std::mem::swap(&mut some, &mut more);
                }
                some.append(&mut more);
                Made::Chain(op, some)
            }
            _ => Made::Value(e.clone()),
        };
        done.insert(key(&e), made);
    }
    done.get_mut(&key(root)).map_or_else(|| root.clone(), Made::value)
}

/// All lines with an operation.
fn lines(source: &str) -> Result<Vec<Line<'_>>> {
    let mut names: FxHashMap<&str, usize> = FxHashMap::default();
    let mut lines = Vec::new();
    let mut start = 0;
    for text in source.split_inclusive('\n') {
        let words = words(text, start);
        start += text.len();
        let Some((name, rest)) = words.split_first() else { continue };
        let line = line(source, *name, rest, &names)?;
        if let Some(first) = names.insert(name.text, lines.len()) {
            let Line { at, .. } = &lines[first];
            let what = match place(source, *at, *at) {
                Place::Text { line, .. } => format!("{:?} is already the name of line {line}", name.text),
                _ => format!("{:?} is already a name", name.text),
            };
            return Err(name.error(source, what).with_help("give each line a name of its own"));
        }
        lines.push(line);
    }
    Ok(lines)
}

#[derive(Clone, Copy)]
struct Word<'a> {
    at: usize,
    text: &'a str,
}

impl Word<'_> {
    fn error(&self, source: &str, what: impl Into<String>) -> Error {
        Error::input(place(source, self.at, self.at + self.text.len()), what)
    }
}

/// The words of a line that starts at an offset, up to a comment.
fn words(line: &str, start: usize) -> Vec<Word<'_>> {
    let code = line.split('#').next().unwrap_or_default().trim_start_matches('\u{feff}');
    // A mark of the order of bytes stands at the start of some files.
    let skipped = if line.starts_with('\u{feff}') { line.len() - line.trim_start_matches('\u{feff}').len() } else { 0 };
    let offset = |text: &str| start + skipped + (text.as_ptr() as usize - code.as_ptr() as usize);
    code.split_whitespace().map(|text| Word { at: offset(text), text }).collect()
}

fn line<'a>(source: &str, name: Word<'a>, rest: &[Word<'a>], names: &FxHashMap<&str, usize>) -> Result<Line<'a>> {
    let Some((op, operands)) = rest.split_first() else {
        return Err(name.error(source, format!("no operation follows the name {:?}", name.text)).with_help(EXAMPLE));
    };
    let Some((word, wanted)) = operations().find(|(word, _)| *word == op.text) else {
        let known: Vec<_> = operations().map(|o| o.0).collect();
        let help = match nearest(op.text, known.iter().copied()) {
            Some(near) if !op.text.starts_with("var-") => format!("is it {near:?}? Known are {}", known.join(", ")),
            _ => "variables are var-x, var-y and var-z alone".into(),
        };
        return Err(op.error(source, format!("unknown operation {:?}", op.text)).with_help(help));
    };
    if operands.len() != *wanted {
        let plural = if *wanted == 1 { "" } else { "s" };
        let what = format!("{word} takes {wanted} operand{plural}, not {}", operands.len());
        // What is too much is pointed at; what is missing would stand behind the operation.
        return Err(operands.get(*wanted).unwrap_or(op).error(source, what).with_help(EXAMPLE));
    }
    let mut numbers = [None; 2];
    let meaning = match *word {
        "const" => Meaning::Value(number(source, operands)?),
        "var-x" => Meaning::Coordinate(0),
        "var-y" => Meaning::Coordinate(1),
        "var-z" => Meaning::Coordinate(2),
        "min" => Meaning::Chain(Binary::Min),
        "max" => Meaning::Chain(Binary::Max),
        word => Meaning::Other(word),
    };
    if !matches!(meaning, Meaning::Value(_)) {
        for (number, operand) in numbers.iter_mut().zip(operands) {
            *number = Some(*names.get(operand.text).ok_or_else(|| {
                let what = format!("{:?} is used before a line has this name", operand.text);
                operand.error(source, what).with_help("operands are names of lines above; numbers are lines with const")
            })?);
        }
    }
    Ok(Line { at: op.at, word: op.text, meaning, operands: numbers })
}

fn number(source: &str, operands: &[Word<'_>]) -> Result<f64> {
    let Some(word) = operands.first() else {
        return Err(Error::input(place(source, 0, 0), "a number is missing"));
    };
    match word.text.parse::<f64>() {
        Ok(v) if v.is_finite() => Ok(v),
        Ok(_) => Err(word.error(source, format!("a number must be finite, not {}", word.text))),
        Err(_) => Err(word.error(source, format!("{:?} is not a number", word.text)).with_help("as in `_0 const 1.5`")),
    }
}

/// The operation on formulas; `None` for one that is not known, or with operands that are missing.
fn applied(name: &str, operands: [Option<Expr>; 2]) -> Option<Expr> {
    let un = Expr::unary;
    Some(match operands {
        [Some(a), None] => match name {
            "neg" => -a,
            "abs" => un(Unary::Abs, a),
            "square" => Expr::binary(Binary::Pow, a, Expr::constant(2.0)),
            "sqrt" => un(Unary::Sqrt, a),
            "recip" => Expr::constant(1.0) / a,
            "sin" => un(Unary::Sin, a),
            "cos" => un(Unary::Cos, a),
            "tan" => un(Unary::Tan, a),
            "asin" => un(Unary::Asin, a),
            "acos" => un(Unary::Acos, a),
            "atan" => Expr::binary(Binary::Atan2, a, Expr::constant(1.0)),
            "exp" => un(Unary::Exp, a),
            "ln" => un(Unary::Log, a),
            "floor" => un(Unary::Floor, a),
            "ceil" => a.ceil(),
            "round" => match a.as_constant() {
                Some(c) => Expr::constant(c.round()),
                None => a.round(),
            },
            "not" => Expr::constant(1.0) - is_not_zero(a),
            "const-var" => a,
            _ => return None,
        },
        [Some(a), Some(b)] => match name {
            "add" => a + b,
            "sub" => a - b,
            "mul" => a * b,
            "div" => a / b,
            "pow" => Expr::binary(Binary::Pow, a, b),
            "nth-root" => root(a, b),
            "atan2" => Expr::binary(Binary::Atan2, a, b),
            // The remainder that is not negative.
            "mod" => Expr::binary(Binary::Mod, a, un(Unary::Abs, b)),
            "compare" => un(Unary::Sign, a - b),
            "and" => Expr::select(is_not_zero(a) - 0.5, b, Expr::constant(0.0)),
            "or" => Expr::select(is_not_zero(a.clone()) - 0.5, a, b),
            _ => return None,
        },
        _ => return None,
    })
}

/// 1 where a formula is not zero, else 0.
fn is_not_zero(a: Expr) -> Expr {
    Expr::unary(Unary::Abs, Expr::unary(Unary::Sign, a))
}

/// The root of some degree; an odd one has the sign of its radicand.
fn root(a: Expr, degree: Expr) -> Expr {
    let odd = degree.as_constant().is_some_and(|n| n.rem_euclid(2.0) == 1.0);
    let power = Expr::constant(1.0) / degree;
    if odd {
        let size = Expr::binary(Binary::Pow, Expr::unary(Unary::Abs, a.clone()), power);
        return Expr::unary(Unary::Sign, a) * size;
    }
    Expr::binary(Binary::Pow, a, power)
}
