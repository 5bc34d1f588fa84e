//! Statements of part files: assignments, loops over lists, conditions, functions.

use std::rc::Rc;

use ruff_python_ast::{self as ast, Expr, Stmt};
use ruff_text_size::Ranged;

use super::interpreter::Interpreter;
use super::value::{Function, Value};
use super::{operators, refused};
use crate::error::{Error, Result};
use crate::run::DEEPEST;

/// What comes after a statement.
enum Flow<'a> {
    Next,
    /// The next item of the innermost loop.
    Continue,
    /// What is behind the innermost loop.
    Break,
    Return(Value<'a>),
}

impl<'a> Interpreter<'a> {
    /// Runs a statement of the file itself; `overrides` stand for the numbers that it assigns to these names.
    pub(super) fn statement(
        &mut self,
        s: &'a Stmt,
        overrides: &[(String, f64)],
        numbers: &mut Vec<String>,
    ) -> Result<()> {
        let Stmt::Assign(a) = s else {
            return match self.run(s, 0)? {
                Flow::Next | Flow::Return(_) => Ok(()),
                Flow::Continue | Flow::Break => Err(self.error(s.range(), "there is no loop around this")),
            };
        };
        let assigned = self.eval(&a.value)?;
        for target in &a.targets {
            let mut value = assigned.clone();
            if let (Expr::Name(n), Value::Int(_) | Value::Float(_)) = (target, &value) {
                if !numbers.iter().any(|known| *known == n.id.as_str()) {
                    numbers.push(n.id.to_string());
                }
                if let Some((_, v)) = overrides.iter().rev().find(|(name, _)| *name == n.id.as_str()) {
                    value = if v.fract() == 0.0 && v.abs() < 1e15 { Value::Int(*v as i64) } else { Value::Float(*v) };
                }
            }
            self.assign(target, value)?;
        }
        Ok(())
    }

    /// What a function returns.
    pub(super) fn body(&mut self, f: &'a ast::StmtFunctionDef) -> Result<Value<'a>> {
        match self.block(&f.body, 0)? {
            Flow::Return(value) => Ok(value),
            Flow::Continue | Flow::Break => Err(self.error(f.name.range, "there is no loop around a break in this")),
            Flow::Next => Err(self.error(f.name.range, "a function must return something")),
        }
    }

    fn block(&mut self, statements: &'a [Stmt], depth: usize) -> Result<Flow<'a>> {
        for s in statements {
            match self.run(s, depth)? {
                Flow::Next => {}
                flow => return Ok(flow),
            }
        }
        Ok(Flow::Next)
    }

    fn run(&mut self, s: &'a Stmt, depth: usize) -> Result<Flow<'a>> {
        if depth > DEEPEST {
            return Err(self.error(s.range(), format!("statements are nested too deeply: the limit is {DEEPEST}")));
        }
        match s {
            Stmt::Assign(a) => {
                let value = self.eval(&a.value)?;
                a.targets.iter().try_for_each(|target| self.assign(target, value.clone()))?;
            }
            Stmt::AugAssign(a) => {
                let (left, right) = (self.eval(&a.target)?, self.eval(&a.value)?);
                let value = operators::binary(self, a.range, a.op, left, right)?;
                self.assign(&a.target, value)?;
            }
            Stmt::For(f) => return self.repeated(f, depth),
            Stmt::If(f) => return self.decided(f, depth),
            Stmt::FunctionDef(f) if !self.is_in_function() => self.define(f)?,
            // A string on its own is a comment.
            Stmt::Expr(e) if matches!(&*e.value, Expr::StringLiteral(_)) => {}
            Stmt::Expr(e) => {
                self.eval(&e.value)?;
            }
            Stmt::Import(_) | Stmt::ImportFrom(_) => self.import(s)?,
            Stmt::Pass(_) => {}
            Stmt::Continue(_) => return Ok(Flow::Continue),
            Stmt::Break(_) => return Ok(Flow::Break),
            Stmt::Return(r) if self.is_in_function() => {
                let value = r.value.as_deref().map(|e| self.eval(e)).transpose()?;
                let nothing = || self.error(r.range, "a function must return something");
                return value.ok_or_else(nothing).map(Flow::Return);
            }
            other => return Err(self.refused(other)),
        }
        Ok(Flow::Next)
    }

    fn repeated(&mut self, f: &'a ast::StmtFor, depth: usize) -> Result<Flow<'a>> {
        if f.is_async || !f.orelse.is_empty() {
            return Err(self.error(f.range, "a loop is plain: for item in list: statements"));
        }
        let all = self.eval(&f.iter)?;
        let all = operators::spread(self, f.iter.range(), all)?;
        let Some(items) = all.items() else {
            return Err(self.error(f.iter.range(), format!("a list is needed here, not {}", all.kind())));
        };
        for item in items {
            self.charge(f.range, 1)?;
            self.assign(&f.target, item.clone())?;
            match self.block(&f.body, depth + 1)? {
                Flow::Next | Flow::Continue => {}
                Flow::Break => break,
                flow => return Ok(flow),
            }
        }
        Ok(Flow::Next)
    }

    fn decided(&mut self, f: &'a ast::StmtIf, depth: usize) -> Result<Flow<'a>> {
        let mut clauses = vec![(Some(&*f.test), &f.body)];
        clauses.extend(f.elif_else_clauses.iter().map(|c| (c.test.as_ref(), &c.body)));
        for (test, body) in clauses {
            let holds = match test {
                Some(test) => {
                    let v = self.eval(test)?;
                    self.truth(test.range(), &v)?
                }
                None => true,
            };
            if holds {
                return self.block(body, depth + 1);
            }
        }
        Ok(Flow::Next)
    }

    fn define(&mut self, f: &'a ast::StmtFunctionDef) -> Result<()> {
        let p = &f.parameters;
        let plain = !f.is_async && f.decorator_list.is_empty() && f.type_params.is_none();
        if !plain || p.vararg.is_some() || p.kwarg.is_some() {
            return Err(self.error(f.range, "a function is plain: def name(a, b=1): return expression"));
        }
        if !f.body.iter().any(may_return) {
            return Err(self.error(f.range, "a function must return something"));
        }
        let all = p.posonlyargs.iter().chain(&p.args).chain(&p.kwonlyargs);
        let defaults = all.map(|p| p.default.as_deref().map(|d| self.eval(d)).transpose());
        let defaults = defaults.collect::<Result<_>>()?;
        self.set(f.name.to_string(), Value::Function(Rc::new(Function { definition: f, defaults })));
        Ok(())
    }

    pub(super) fn refused(&self, s: &Stmt) -> Error {
        let (what, help) = refused::statement(s);
        self.error(s.range(), format!("{what} are not part of the part language")).with_help(help)
    }

    fn assign(&mut self, target: &Expr, value: Value<'a>) -> Result<()> {
        let mut names = Vec::new();
        self.unpack(target, value, &mut names)?;
        names.into_iter().for_each(|(name, value)| self.set(name, value));
        Ok(())
    }

    /// Assigns a value to a name, or its items to several.
    pub(super) fn unpack(&self, target: &Expr, value: Value<'a>, out: &mut Vec<(String, Value<'a>)>) -> Result<()> {
        let targets = match target {
            Expr::Name(n) => {
                out.push((n.id.to_string(), value));
                return Ok(());
            }
            Expr::Tuple(t) => &t.elts,
            Expr::List(l) => &l.elts,
            other => return Err(self.error(other.range(), "only names can be assigned to")),
        };
        match value.items() {
            Some(items) if items.len() == targets.len() => {
                targets.iter().zip(items).try_for_each(|(t, v)| self.unpack(t, v.clone(), out))
            }
            Some(items) => Err(self
                .error(target.range(), format!("{} values cannot be given to {} names", items.len(), targets.len()))),
            None => Err(self.error(target.range(), format!("{} cannot be given to several names", value.kind()))),
        }
    }
}

/// Whether a statement may end a function: that none does is told where the function is defined.
fn may_return(s: &Stmt) -> bool {
    matches!(s, Stmt::Return(r) if r.value.is_some()) || matches!(s, Stmt::If(_) | Stmt::For(_))
}
