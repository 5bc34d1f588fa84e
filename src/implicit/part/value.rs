//! What an expression of a part file may be.

use std::rc::Rc;

use ruff_python_ast::StmtFunctionDef;

use super::super::expr::Expr;
use super::super::solid::{Primitive, Solid};
use super::modules::Module;
use super::recipe::{Edges, Recipe};

/// A value.
#[derive(Clone)]
pub(super) enum Value<'a> {
    None,
    Bool(bool),
    Int(i64),
    Float(f64),
    Str(Rc<str>),
    List(Rc<Vec<Value<'a>>>),
    Tuple(Rc<Vec<Value<'a>>>),
    /// A formula in x, y, z.
    Formula(Expr),
    /// Where all these formulas are not negative.
    Condition(Rc<Vec<Expr>>),
    Solid(Solid),
    /// A figure of the plane, as a solid that goes on along z without end.
    Region(Solid),
    Polygon(Rc<Vec<[f64; 2]>>),
    /// A chain of edges in space.
    Edges(Rc<Edges>),
    /// A solid or sheet to be built from edges.
    Built(Rc<Recipe>),
    /// Patterns of face names.
    Faces(Rc<Vec<String>>),
    Function(Rc<Function<'a>>),
    Builtin(&'static str),
    /// What was imported whole.
    Module(Module),
}

/// A function of the part file.
pub(super) struct Function<'a> {
    pub(super) definition: &'a StmtFunctionDef,
    /// What parameters that are left out are, one for each parameter.
    pub(super) defaults: Vec<Option<Value<'a>>>,
}

impl Value<'_> {
    /// What to call it in a message.
    pub(super) fn kind(&self) -> &'static str {
        match self {
            Value::None => "None",
            Value::Bool(_) => "a truth value",
            Value::Int(_) | Value::Float(_) => "a number",
            Value::Str(_) => "a string",
            Value::List(_) => "a list",
            Value::Tuple(_) => "a tuple",
            Value::Formula(_) => "a formula",
            Value::Condition(_) => "a condition on formulas",
            Value::Solid(_) => "a solid",
            Value::Region(_) => "a plane figure",
            Value::Polygon(_) => "a polygon",
            Value::Edges(_) => "a chain of edges",
            Value::Built(_) => "a solid built from edges",
            Value::Faces(_) => "a set of faces",
            Value::Function(_) | Value::Builtin(_) => "a function",
            Value::Module(_) => "a module",
        }
    }

    pub(super) fn number(&self) -> Option<f64> {
        match self {
            Value::Int(i) => Some(*i as f64),
            Value::Float(f) => Some(*f),
            Value::Bool(b) => Some(f64::from(u8::from(*b))),
            _ => None,
        }
    }

    /// As a formula; numbers are formulas too.
    pub(super) fn formula(&self) -> Option<Expr> {
        match self {
            Value::Formula(e) => Some(e.clone()),
            Value::Bool(_) => None,
            other => other.number().map(Expr::constant),
        }
    }

    /// As a solid; a condition is the solid where it holds.
    pub(super) fn solid(&self) -> Option<Solid> {
        match self {
            Value::Solid(s) => Some(s.clone()),
            Value::Condition(all) => Some(condition_solid(all)),
            _ => None,
        }
    }

    pub(super) fn items(&self) -> Option<&[Self]> {
        match self {
            Value::List(v) | Value::Tuple(v) => Some(v),
            _ => None,
        }
    }

    /// A formula that is a plain number becomes one.
    pub(super) fn from_formula(e: Expr) -> Self {
        match e.as_constant() {
            Some(c) => Value::Float(c),
            None => Value::Formula(e),
        }
    }
}

pub(super) fn condition_solid(all: &[Expr]) -> Solid {
    let mut solids = all.iter().map(|e| Solid::from(Primitive::Formula(e.clone())));
    match (solids.next(), all.len()) {
        (Some(one), 1) => one,
        (first, _) => Solid::intersection(first.into_iter().chain(solids)),
    }
}
