//! Walks the syntax tree. Only what is listed here is allowed.

use std::cell::Cell;
use std::path::PathBuf;
use std::rc::Rc;

use ruff_python_ast::{self as ast, Expr, FStringPart, InterpolatedStringElement, Number};
use ruff_python_parser::{Mode, ParseOptions};
use ruff_text_size::{Ranged, TextRange};
use rustc_hash::FxHashMap;

use super::arguments::Argument;
use super::builtins;
use super::lists;
use super::methods;
use super::modules::Module;
use super::operators;
use super::origins::Origins;
use super::recipe::Recipe;
use super::refused;
use super::value::{Function, Value};
use super::{MeshDefaults, Part, PartGroup, limits, place};
use crate::error::{Error, Place, Result};
use crate::implicit::RSystem;
use crate::implicit::solid::Solid;
use crate::spatial::Aabb;

/// What `part(...)` said.
pub(super) struct Declared {
    pub(super) solid: Option<Solid>,
    pub(super) built: Vec<Recipe>,
    pub(super) plane: bool,
    pub(super) rsystem: RSystem,
    pub(super) domain: Option<Aabb>,
    pub(super) place: Place,
}

/// The state of one evaluation.
pub(super) struct Interpreter<'a> {
    source: &'a str,
    globals: FxHashMap<String, Value<'a>>,
    /// Names of functions' parameters and comprehensions' variables, innermost last.
    locals: Vec<(String, Value<'a>)>,
    /// Where the names visible in the running function begin.
    frame: usize,
    calls: usize,
    depth: usize,
    steps: Cell<usize>,
    nodes: Cell<usize>,
    pub(super) declared: Option<Declared>,
    pub(super) units: Option<String>,
    pub(super) groups: Vec<PartGroup>,
    pub(super) mesh: MeshDefaults,
    origins: Origins,
}

/// Parses and evaluates a part file.
pub(super) fn run(source: &str, overrides: &[(String, f64)]) -> Result<Part> {
    // the newest syntax, so that what is refused is refused by us and not by a version of Python
    let options = ParseOptions::from(Mode::Module).with_target_version(ast::PythonVersion::latest());
    let parsed = ruff_python_parser::parse(source, options).map_err(|e| {
        let (start, end) = (e.location.start().to_usize(), e.location.end().to_usize());
        Error::input(place(source, start, end), format!("syntax error: {}", e.error))
    })?;
    if let Some(e) = parsed.unsupported_syntax_errors().first() {
        return Err(Error::input(
            place(source, e.range.start().to_usize(), e.range.end().to_usize()),
            format!("syntax error: {e}"),
        ));
    }
    let Some(parsed) = parsed.try_into_module() else {
        return Err(Error::Failed("the parser read no module".into()));
    };
    let mut it = Interpreter {
        source,
        globals: FxHashMap::default(),
        locals: Vec::new(),
        frame: 0,
        calls: 0,
        depth: 0,
        steps: Cell::new(0),
        nodes: Cell::new(0),
        declared: None,
        units: None,
        groups: Vec::new(),
        mesh: MeshDefaults::default(),
        origins: Origins::default(),
    };
    let mut numbers = Vec::new();
    for s in &parsed.syntax().body {
        it.statement(s, overrides, &mut numbers)?;
    }
    if let Some((name, _)) = overrides.iter().find(|(n, _)| !numbers.contains(n)) {
        let known = if numbers.is_empty() {
            "there are none".to_string()
        } else {
            format!("there are: {}", numbers.join(", "))
        };
        return Err(Error::Usage(format!(
            "-D {name}: no number is assigned to {name:?} at the top level of the part file; {known}"
        )));
    }
    let Some(d) = it.declared.take() else {
        return Err(Error::input(place(source, source.len(), source.len()), "the file declares no part")
            .with_help("end it with part(solid)"));
    };
    let Declared { solid, built, plane, rsystem, domain, place } = d;
    Ok(Part {
        solid,
        built,
        plane,
        rsystem,
        domain,
        units: it.units,
        groups: it.groups,
        mesh: it.mesh,
        folder: PathBuf::new(),
        origins: Some(it.origins.finish(source, place)),
    })
}

impl<'a> Interpreter<'a> {
    pub(super) fn place(&self, range: TextRange) -> Place {
        place(self.source, range.start().to_usize(), range.end().to_usize())
    }

    pub(super) fn error(&self, range: TextRange, message: impl Into<String>) -> Error {
        Error::input(self.place(range), message)
    }

    /// Gives an error without place the place of an expression.
    pub(super) fn at<T>(&self, range: TextRange, r: Result<T>) -> Result<T> {
        r.map_err(|e| match e {
            Error::Input { place: Place::Unknown, message, help, file } => {
                Error::Input { file, place: self.place(range), message, help }
            }
            Error::Usage(message) => self.error(range, message),
            other => other,
        })
    }

    /// Counts nodes of formulas and solids.
    pub(super) fn grow(&self, range: TextRange, nodes: usize) -> Result<()> {
        self.nodes.set(self.nodes.get() + nodes);
        if self.nodes.get() > limits::NODES {
            return Err(self.error(range, format!("the part has too many nodes: the limit is {}", limits::NODES)));
        }
        Ok(())
    }

    /// Counts work: a step is about an expression evaluated or an item made.
    pub(super) fn charge(&self, range: TextRange, steps: usize) -> Result<()> {
        self.steps.set(self.steps.get().saturating_add(steps));
        if self.steps.get() > limits::STEPS {
            return Err(
                self.error(range, format!("the part file takes too long: the limit is {} evaluations", limits::STEPS))
            );
        }
        Ok(())
    }

    pub(super) fn is_in_function(&self) -> bool {
        self.calls > 0
    }

    /// Gives a name its value, within the running function if there is one.
    pub(super) fn set(&mut self, name: String, value: Value<'a>) {
        if !self.is_in_function() {
            self.globals.insert(name, value);
            return;
        }
        let visible = &mut self.locals[self.frame..];
        match visible.iter_mut().find(|known| known.0 == name) {
            Some(known) => known.1 = value,
            None => self.locals.push((name, value)),
        }
    }

    /// The module that a name stands for.
    fn module(&self, e: &Expr) -> Option<Module> {
        let Expr::Name(n) = e else { return None };
        match self.lookup(n.id.as_str(), n.range) {
            Ok(Value::Module(module)) => Some(module),
            _ => None,
        }
    }

    /// The value of a name that the file gave one.
    pub(super) fn variable(&mut self, name: &str) -> Option<&mut Value<'a>> {
        match self.locals[self.frame..].iter().rposition(|(n, _)| n == name) {
            Some(k) => self.locals.get_mut(self.frame + k).map(|(_, v)| v),
            None => self.globals.get_mut(name),
        }
    }

    fn lookup(&self, name: &str, range: TextRange) -> Result<Value<'a>> {
        if let Some((_, v)) = self.locals[self.frame..].iter().rev().find(|(n, _)| n == name) {
            return Ok(v.clone());
        }
        if let Some(v) = self.globals.get(name) {
            return Ok(v.clone());
        }
        if let Some(v) = builtins::constant(name) {
            return Ok(v);
        }
        let e = self.error(range, format!("nothing is called {name:?}"));
        if let Some(help) = refused::name(name) {
            return Err(e.with_help(help));
        }
        let known = self.globals.keys().map(String::as_str).chain(builtins::names().map(|n| -> &str { n }));
        let mut near: Vec<(usize, &str)> = known.map(|k| (crate::error::edit_distance(k, name), k)).collect();
        near.sort_unstable();
        Err(match near.first() {
            Some((d, k)) if *d <= 2 && *d < name.chars().count() => e.with_help(format!("did you mean {k:?}?")),
            _ => e,
        })
    }

    /// Evaluates an expression.
    pub(super) fn eval(&mut self, e: &'a Expr) -> Result<Value<'a>> {
        let range = e.range();
        self.charge(range, 1)?;
        self.depth += 1;
        if self.depth > limits::DEPTH {
            return Err(self.error(range, format!("expressions are nested too deeply: the limit is {}", limits::DEPTH)));
        }
        let r = self.evaluate(e, range);
        if let Ok(Value::Solid(s) | Value::Region(s)) = &r {
            self.origins.add(s, range);
        }
        self.depth -= 1;
        r
    }

    fn evaluate(&mut self, e: &'a Expr, range: TextRange) -> Result<Value<'a>> {
        match e {
            Expr::NumberLiteral(n) => match &n.value {
                Number::Int(i) => {
                    let text = i.to_string();
                    match text.parse::<i64>() {
                        Ok(i) => Ok(Value::Int(i)),
                        Err(_) => self.finite(range, text.parse().unwrap_or(f64::INFINITY)),
                    }
                }
                Number::Float(f) => self.finite(range, *f),
                Number::Complex { .. } => Err(self.error(range, "complex numbers are not part of the part language")),
            },
            Expr::StringLiteral(s) => self.string(range, s.value.to_str().to_string()),
            Expr::BooleanLiteral(b) => Ok(Value::Bool(b.value)),
            Expr::NoneLiteral(_) => Ok(Value::None),
            Expr::Name(n) => self.lookup(n.id.as_str(), range),
            Expr::Tuple(t) => Ok(Value::Tuple(Rc::new(self.all(&t.elts)?))),
            Expr::List(l) => Ok(Value::List(Rc::new(self.all(&l.elts)?))),
            Expr::BinOp(b) => {
                let (l, r) = (self.eval(&b.left)?, self.eval(&b.right)?);
                operators::binary(self, range, b.op, l, r)
            }
            Expr::UnaryOp(u) => {
                let v = self.eval(&u.operand)?;
                operators::unary(self, range, u.op, v)
            }
            Expr::BoolOp(b) => {
                let stop = b.op == ast::BoolOp::Or;
                let mut last = Value::Bool(!stop);
                for e in &b.values {
                    last = self.eval(e)?;
                    if self.truth(e.range(), &last)? == stop {
                        break;
                    }
                }
                Ok(last)
            }
            Expr::Compare(c) => {
                let mut values = vec![self.eval(&c.left)?];
                values.extend(self.all(&c.comparators)?);
                operators::compare(self, range, &c.ops, &values)
            }
            Expr::If(i) => {
                let test = self.eval(&i.test)?;
                if let Value::Condition(all) = &test {
                    let (a, b) = (self.eval(&i.body)?, self.eval(&i.orelse)?);
                    return operators::select(self, range, all, &a, &b);
                }
                if self.truth(i.test.range(), &test)? { self.eval(&i.body) } else { self.eval(&i.orelse) }
            }
            Expr::ListComp(c) => self.comprehension(range, &c.elt, &c.generators),
            Expr::Generator(c) => self.comprehension(range, &c.elt, &c.generators),
            Expr::FString(f) => {
                let mut text = String::new();
                for part in f.value.iter() {
                    match part {
                        FStringPart::Literal(l) => text.push_str(l.as_str()),
                        FStringPart::FString(f) => {
                            for e in &f.elements {
                                self.format_element(e, &mut text)?;
                                if text.len() > limits::TEXT {
                                    break;
                                }
                            }
                        }
                    }
                    if text.len() > limits::TEXT {
                        break;
                    }
                }
                self.string(range, text)
            }
            Expr::Subscript(s) => {
                let v = self.eval(&s.value)?;
                if let Expr::Slice(slice) = &*s.slice {
                    let mut bound = |e: &'a Option<Box<Expr>>| e.as_ref().map(|e| self.eval(e)).transpose();
                    let bounds = [bound(&slice.lower)?, bound(&slice.upper)?, bound(&slice.step)?];
                    return operators::slice(self, range, &v, &bounds);
                }
                let i = self.eval(&s.slice)?;
                operators::index(self, range, &v, &i)
            }
            Expr::Call(c) => self.call(c),
            Expr::Attribute(a) => {
                let name = a.attr.as_str();
                if let Some(module) = self.module(&a.value) {
                    return self.member(module, name, a.attr.range);
                }
                let e = if methods::NAMES.contains(&name) {
                    self.error(a.attr.range, format!("{name:?} can only be called: .{name}(...)"))
                } else {
                    self.error(a.attr.range, format!("there is no method {name:?}"))
                };
                Err(e.with_help(format!("methods of solids: {}", methods::NAMES.join(", "))))
            }
            other => {
                let what = refused::expression(other);
                Err(self.error(range, format!("{what} are not part of the part language")))
            }
        }
    }

    fn format_element(&mut self, e: &'a InterpolatedStringElement, text: &mut String) -> Result<()> {
        match e {
            InterpolatedStringElement::Literal(l) => text.push_str(&l.value),
            InterpolatedStringElement::Interpolation(i) => {
                if i.format_spec.is_some() || i.debug_text.is_some() {
                    return Err(self.error(i.range, "formats inside braces are not part of the part language"));
                }
                let v = self.eval(&i.expression)?;
                text.push_str(&self.display(i.range, &v)?);
            }
        }
        Ok(())
    }

    /// A number or string as text.
    pub(super) fn display(&self, range: TextRange, v: &Value<'a>) -> Result<String> {
        match v {
            Value::Str(s) => Ok(s.to_string()),
            Value::Int(i) => Ok(i.to_string()),
            Value::Float(f) => Ok(format!("{f:?}")),
            Value::Bool(b) => Ok(if *b { "True" } else { "False" }.into()),
            other => Err(self.error(range, format!("{} has no text", other.kind()))),
        }
    }

    pub(super) fn string(&self, range: TextRange, text: String) -> Result<Value<'a>> {
        if text.len() > limits::TEXT {
            return Err(self.error(range, format!("the string is too long: the limit is {} characters", limits::TEXT)));
        }
        self.charge(range, text.len() / 8)?;
        Ok(Value::Str(text.into()))
    }

    fn all(&mut self, list: &'a [Expr]) -> Result<Vec<Value<'a>>> {
        list.iter().map(|e| self.eval(e)).collect()
    }

    /// The truth of a value that has one.
    pub(super) fn truth(&self, range: TextRange, v: &Value<'a>) -> Result<bool> {
        match v {
            Value::Bool(b) => Ok(*b),
            Value::Int(i) => Ok(*i != 0),
            Value::Float(f) => Ok(*f != 0.0),
            other => Err(self.error(range, format!("a truth value is needed here, not {}", other.kind()))),
        }
    }

    fn comprehension(
        &mut self,
        range: TextRange,
        elt: &'a Expr,
        generators: &'a [ast::Comprehension],
    ) -> Result<Value<'a>> {
        let mut out = Vec::new();
        let depth = self.locals.len();
        let r = self.generate(range, elt, generators, &mut out);
        self.locals.truncate(depth);
        r.map(|()| Value::List(Rc::new(out)))
    }

    fn generate(
        &mut self,
        range: TextRange,
        elt: &'a Expr,
        generators: &'a [ast::Comprehension],
        out: &mut Vec<Value<'a>>,
    ) -> Result<()> {
        let Some((g, rest)) = generators.split_first() else {
            let v = self.eval(elt)?;
            out.push(v);
            return if out.len() > limits::ITEMS { self.fits(range, out.len()) } else { Ok(()) };
        };
        if g.is_async {
            return Err(self.error(g.range, "asynchronous comprehensions are not part of the part language"));
        }
        let iter = self.eval(&g.iter)?;
        let iter = operators::spread(self, g.iter.range(), iter)?;
        let Some(items) = iter.items() else {
            return Err(self.error(g.iter.range(), format!("a list is needed here, not {}", iter.kind())));
        };
        for item in items {
            let depth = self.locals.len();
            let mut names = Vec::new();
            self.unpack(&g.target, item.clone(), &mut names)?;
            self.locals.extend(names);
            let mut keep = true;
            for test in &g.ifs {
                let v = self.eval(test)?;
                keep &= self.truth(test.range(), &v)?;
            }
            if keep {
                self.generate(range, elt, rest, out)?;
            }
            self.locals.truncate(depth);
        }
        Ok(())
    }

    /// A number, unless it is too large to be one.
    pub(super) fn finite(&self, range: TextRange, v: f64) -> Result<Value<'a>> {
        if v.is_finite() { Ok(Value::Float(v)) } else { Err(self.error(range, "this number is too large")) }
    }

    /// Counts the items of a list that is to be made, and refuses one that is too long.
    pub(super) fn fits(&self, range: TextRange, items: usize) -> Result<()> {
        if items > limits::ITEMS {
            return Err(self.error(range, format!("the list is too long: the limit is {} items", limits::ITEMS)));
        }
        self.charge(range, items)
    }

    fn call(&mut self, c: &'a ast::ExprCall) -> Result<Value<'a>> {
        let range = c.range();
        if let Expr::Attribute(a) = &*c.func
            && self.module(&a.value).is_none()
        {
            if let Some(grown) = lists::grown(self, c)? {
                return Ok(grown);
            }
            let object = self.eval(&a.value)?;
            let arguments = self.arguments(c)?;
            return methods::call(self, range, object, &a.attr, arguments);
        }
        let f = self.eval(&c.func)?;
        let arguments = self.arguments(c)?;
        match f {
            Value::Builtin(name) => builtins::call(self, range, name, arguments),
            Value::Function(f) => self.call_function(range, &f, arguments),
            other => Err(self.error(c.func.range(), format!("{} cannot be called", other.kind()))),
        }
    }

    pub(super) fn arguments(&mut self, c: &'a ast::ExprCall) -> Result<Vec<Argument<'a>>> {
        let mut out = Vec::new();
        for e in &c.arguments.args {
            if let Expr::Starred(s) = e {
                let v = self.eval(&s.value)?;
                let Some(items) = v.items() else {
                    return Err(self.error(s.range, format!("a list is needed behind *, not {}", v.kind())));
                };
                self.fits(s.range, out.len() + items.len())?;
                out.extend(items.iter().map(|v| Argument { keyword: None, value: v.clone(), range: s.range }));
                continue;
            }
            let value = self.eval(e)?;
            out.push(Argument { keyword: None, value, range: e.range() });
        }
        for k in &c.arguments.keywords {
            let Some(name) = &k.arg else {
                return Err(self.error(k.range, "** arguments are not part of the part language"));
            };
            let value = self.eval(&k.value)?;
            out.push(Argument { keyword: Some(name.to_string()), value, range: k.value.range() });
        }
        Ok(out)
    }

    fn call_function(
        &mut self,
        range: TextRange,
        function: &Function<'a>,
        arguments: Vec<Argument<'a>>,
    ) -> Result<Value<'a>> {
        let f = function.definition;
        if self.calls >= limits::CALLS {
            return Err(self.error(range, format!("calls are nested too deeply: the limit is {}", limits::CALLS)));
        }
        let name = f.name.as_str();
        let p = &f.parameters;
        let parameters: Vec<_> = p.posonlyargs.iter().chain(&p.args).chain(&p.kwonlyargs).collect();
        let positional = p.posonlyargs.len() + p.args.len();
        let mut found: Vec<Option<Value<'a>>> = vec![None; parameters.len()];
        for (i, a) in arguments.into_iter().enumerate() {
            let slot = match &a.keyword {
                None if i < positional => i,
                None => return Err(self.error(a.range, format!("{name}() takes {positional} arguments"))),
                Some(k) => parameters
                    .iter()
                    .position(|p| p.parameter.name.as_str() == k)
                    .ok_or_else(|| self.error(a.range, format!("{name}() has no parameter {k:?}")))?,
            };
            if found[slot].replace(a.value).is_some() {
                return Err(self.error(
                    a.range,
                    format!("{name}() is given {:?} twice", parameters[slot].parameter.name.as_str()),
                ));
            }
        }
        let mut bound = Vec::with_capacity(parameters.len());
        for ((p, v), default) in parameters.iter().zip(found).zip(&function.defaults) {
            let n = p.parameter.name.to_string();
            let Some(v) = v.or_else(|| default.clone()) else {
                return Err(self.error(range, format!("{name}() needs {n:?}")));
            };
            bound.push((n, v));
        }
        let (frame, depth) = (self.frame, self.locals.len());
        self.frame = depth;
        self.locals.extend(bound);
        self.calls += 1;
        let r = self.body(f);
        self.calls -= 1;
        self.locals.truncate(depth);
        self.frame = frame;
        r
    }
}
