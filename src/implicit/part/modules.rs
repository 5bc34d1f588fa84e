//! What part files may import: `math`, `numpy` for its functions of numbers, and this package, all of which are known without.
//!
//! A file that says so runs in Python, too, and formulas come from programs that say so.

use ruff_python_ast::{self as ast, Stmt};
use ruff_text_size::TextRange;

use super::builtins;
use super::interpreter::Interpreter;
use super::value::Value;
use crate::error::Result;

/// A module of Python.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Module {
    Math,
    Numpy,
    Own,
}

/// Names of `math` that are the same here.
const MATH: [&str; 22] = [
    "pi", "sqrt", "exp", "log", "sin", "cos", "tan", "asin", "acos", "atan", "atan2", "sinh", "cosh", "tanh", "hypot",
    "pow", "floor", "ceil", "trunc", "fmod", "degrees", "radians",
];

/// Names of `numpy` that are the same here.
const NUMPY: [&str; 21] = [
    "pi", "sqrt", "exp", "log", "sin", "cos", "tan", "sinh", "cosh", "tanh", "hypot", "floor", "ceil", "trunc", "fmod",
    "mod", "sign", "abs", "degrees", "radians", "round",
];

/// Names that are others here.
const OTHERS: [(&str, &str); 11] = [
    ("fabs", "abs"),
    ("absolute", "abs"),
    ("arcsin", "asin"),
    ("arccos", "acos"),
    ("arctan", "atan"),
    ("arctan2", "atan2"),
    ("minimum", "min"),
    ("maximum", "max"),
    ("clip", "clamp"),
    ("power", "pow"),
    ("remainder", "mod"),
];

impl Module {
    fn named(name: &str) -> Option<Self> {
        match name {
            "math" => Some(Module::Math),
            "numpy" => Some(Module::Numpy),
            "rvachev" => Some(Module::Own),
            _ => None,
        }
    }

    fn name(self) -> &'static str {
        match self {
            Module::Math => "math",
            Module::Numpy => "numpy",
            Module::Own => "rvachev",
        }
    }

    /// What the module calls by a name.
    fn member<'a>(self, name: &str) -> Option<Value<'a>> {
        let own = match self {
            Module::Own => return builtins::constant(name),
            Module::Math => MATH.contains(&name),
            Module::Numpy => NUMPY.contains(&name),
        };
        match name {
            "e" => return Some(Value::Float(std::f64::consts::E)),
            "tau" if self == Module::Math => return Some(Value::Float(std::f64::consts::TAU)),
            _ => {}
        }
        let other = || OTHERS.iter().find(|o| o.0 == name && (self == Module::Numpy || name == "fabs")).map(|o| o.1);
        other().or(own.then_some(name)).and_then(builtins::constant)
    }
}

impl<'a> Interpreter<'a> {
    /// Gives names to what is imported.
    ///
    /// Errors: another module, a name that it does not have here.
    pub(super) fn import(&mut self, s: &'a Stmt) -> Result<()> {
        match s {
            Stmt::Import(i) => {
                for alias in &i.names {
                    let Some(module) = Module::named(alias.name.as_str()) else { return Err(self.refused(s)) };
                    let name = alias.asname.as_ref().unwrap_or(&alias.name);
                    self.set(name.to_string(), Value::Module(module));
                }
            }
            Stmt::ImportFrom(i) => {
                let module = i.module.as_ref().filter(|_| i.level == 0).and_then(|m| Module::named(m.as_str()));
                let Some(module) = module else { return Err(self.refused(s)) };
                i.names.iter().try_for_each(|alias| self.import_from(module, alias))?;
            }
            _ => {}
        }
        Ok(())
    }

    fn import_from(&mut self, module: Module, alias: &'a ast::Alias) -> Result<()> {
        if alias.name.as_str() != "*" {
            let value = self.member(module, alias.name.as_str(), alias.range)?;
            self.set(alias.asname.as_ref().unwrap_or(&alias.name).to_string(), value);
            return Ok(());
        }
        // What has the same name is known without.
        for name in ["e", "tau"].into_iter().chain(OTHERS.iter().map(|o| o.0)) {
            if let Some(value) = module.member(name).filter(|_| module != Module::Own) {
                self.set(name.to_string(), value);
            }
        }
        Ok(())
    }

    /// What a module calls by a name.
    pub(super) fn member(&self, module: Module, name: &str, range: TextRange) -> Result<Value<'a>> {
        module
            .member(name)
            .ok_or_else(|| self.error(range, format!("part files know no {name:?} of {}", module.name())))
    }
}
