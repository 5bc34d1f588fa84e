//! Functions of a 3MF model as formulas: graphs of nodes, and calls from one to another.

use rustc_hash::FxHashMap;

use super::super::super::expr::{Binary, Expr, Unary};
use super::super::limits::{CALLS, NODES};
use super::values::{Value, by_component, cross, dot, inputs_of, inverse, moved, transposed};
use crate::error::{Error, Result, nearest};
use crate::io::threemf::{Model, Xml, attribute, child, children, finite, number, place_of, real, wrong};

/// The nodes that are read, beside those that work on each number by itself.
const OTHERS: [&str; 18] = [
    "constant",
    "constvec",
    "constmat",
    "constresourceid",
    "composevector",
    "vectorfromscalar",
    "decomposevector",
    "composematrix",
    "matrixfromcolumns",
    "matrixfromrows",
    "dot",
    "cross",
    "matvecmultiplication",
    "transpose",
    "inverse",
    "length",
    "functioncall",
    "mod",
];

/// Values by the names of outputs.
type Named<'a> = FxHashMap<&'a str, Value>;

/// Turns functions into formulas.
pub(super) struct Graphs<'m, 'a> {
    model: &'m Model<'a>,
    /// The functions that are being called, from outside in.
    calls: Vec<u64>,
    nodes: usize,
}

/// One function while it is computed.
struct Function<'a> {
    id: u64,
    inputs: Named<'a>,
    nodes: Vec<Xml<'a>>,
    by_name: FxHashMap<&'a str, usize>,
    done: Vec<Option<Named<'a>>>,
}

impl<'m, 'a> Graphs<'m, 'a> {
    pub(super) fn new(model: &'m Model<'a>) -> Self {
        Graphs { model, calls: Vec::new(), nodes: 0 }
    }

    /// The values of some outputs of a function; `from` is what calls it.
    pub(super) fn call(&mut self, id: u64, from: Xml<'a>, inputs: Named<'a>, wanted: &[&'a str]) -> Result<Named<'a>> {
        let node = self.model.resource(id, from)?;
        let word = node.tag_name().name();
        if word != "implicitfunction" {
            let e = wrong(from, format!("function {id} is <{word}>, which is not read"));
            return Err(e.with_help("functions that are graphs of nodes are read: <implicitfunction>"));
        }
        if self.calls.contains(&id) {
            return Err(wrong(from, format!("function {id} calls itself")));
        }
        if self.calls.len() >= CALLS {
            return Err(wrong(from, format!("functions call each other more than {CALLS} deep")));
        }
        for input in child(node, "in").into_iter().flat_map(children) {
            let name = attribute(input, "identifier")?;
            let Some(given) = inputs.get(name) else { continue };
            let fits = match given {
                Value::Scalar(_) => "scalar",
                Value::Vector(_) => "vector",
                Value::Matrix(_) => "matrix",
                Value::Resource(_) => "resourceid",
            };
            if input.tag_name().name() != fits {
                let what = format!("input {name:?} of function {id} is a {}", input.tag_name().name());
                return Err(wrong(from, format!("{what}, not {}", given.kind())));
            }
        }
        self.calls.push(id);
        let found = self.outputs(Function::new(id, node, inputs)?, node, wanted, from);
        self.calls.pop();
        found
    }

    fn outputs(&mut self, mut f: Function<'a>, node: Xml<'a>, wanted: &[&'a str], from: Xml<'a>) -> Result<Named<'a>> {
        let mut found = Named::default();
        for name in wanted {
            let outputs: Vec<_> = child(node, "out").into_iter().flat_map(children).collect();
            let Some(output) = outputs.iter().find(|o| o.attribute("identifier") == Some(name)) else {
                let all: Vec<_> = outputs.iter().filter_map(|o| o.attribute("identifier")).collect();
                let e = wrong(from, format!("function {} has no output {name:?}", f.id));
                return Err(e.with_help(format!("its outputs are {}", all.join(", "))));
            };
            self.compute(&mut f, *output)?;
            let value = f.get(*output)?.ok_or_else(|| wrong(*output, "this is not computed"))?;
            found.insert(*name, value);
        }
        Ok(found)
    }

    /// Computes the node that a reference names, and all it needs. Without recursion: chains may be as long as the file.
    fn compute(&mut self, f: &mut Function<'a>, reference: Xml<'a>) -> Result<()> {
        let Some(first) = f.target(reference)? else { return Ok(()) };
        // Whether a node is on the way from the first to the one that is looked at.
        let mut open = vec![false; f.nodes.len()];
        let mut stack = vec![(first, false, reference)];
        while let Some((i, ready, by)) = stack.pop() {
            if f.done[i].is_some() {
                continue;
            }
            let node = f.nodes[i];
            if ready {
                open[i] = false;
                let results = self.node(f, node)?;
                f.done[i] = Some(results);
                continue;
            }
            if open[i] {
                return Err(wrong(by, format!("the nodes form a circle through {:?}", name_of(node))));
            }
            self.nodes += 1;
            if self.nodes > NODES {
                return Err(wrong(node, format!("the functions have more than {NODES} nodes: that is the limit")));
            }
            open[i] = true;
            stack.push((i, true, by));
            for input in child(node, "in").into_iter().flat_map(children) {
                if let Some(k) = f.target(input)? {
                    stack.push((k, false, input));
                }
            }
        }
        Ok(())
    }

    /// The outputs of a node whose inputs are there.
    fn node(&mut self, f: &Function<'a>, node: Xml<'a>) -> Result<Named<'a>> {
        let word = node.tag_name().name();
        if word == "functioncall" {
            return self.function_call(f, node);
        }
        let (output, value) = match inputs_of(word) {
            Some(names) => {
                let all = names.iter().map(|n| f.input(node, n)).collect::<Result<Vec<_>>>()?;
                let value = by_component(word, &all).ok_or_else(|| {
                    let kinds: Vec<_> = all.iter().map(Value::kind).collect();
                    wrong(node, format!("<{word}> does not take {}", kinds.join(", ")))
                })?;
                ("result", value)
            }
            None => other(f, node)?,
        };
        if value.parts().iter().any(|e| e.as_constant().is_some_and(|c| !c.is_finite())) {
            return Err(wrong(node, format!("the result of <{word}> is not a finite number")));
        }
        let mut all = Named::default();
        if word == "decomposevector" {
            for (name, e) in ["x", "y", "z"].into_iter().zip(value.parts()) {
                all.insert(name, Value::Scalar(e.clone()));
            }
        } else {
            // Some programs, and the specification's own examples, give the one output another name.
            let given = child(node, "out").into_iter().flat_map(children).next();
            if let Some(name) = given.and_then(|n| n.attribute("identifier")) {
                all.insert(name, value.clone());
            }
            all.insert(output, value);
        }
        Ok(all)
    }

    fn function_call(&mut self, f: &Function<'a>, node: Xml<'a>) -> Result<Named<'a>> {
        let mut inputs = Named::default();
        let mut id = None;
        for input in child(node, "in").into_iter().flat_map(children) {
            let name = attribute(input, "identifier")?;
            let value = f.get(input)?.ok_or_else(|| wrong(input, "this is not computed"))?;
            match value {
                Value::Resource(number) if name.eq_ignore_ascii_case("functionID") => id = Some(number),
                value => drop(inputs.insert(name, value)),
            }
        }
        let Some(id) = id else {
            return Err(wrong(node, "<functioncall> has no input \"functionID\" that is a resource"));
        };
        let outputs = child(node, "out").into_iter().flat_map(children);
        let wanted = outputs.map(|o| attribute(o, "identifier")).collect::<Result<Vec<_>>>()?;
        self.call(id, node, inputs, &wanted)
    }
}

fn name_of<'a>(node: Xml<'a>) -> &'a str {
    node.attribute("identifier").unwrap_or_default()
}

impl<'a> Function<'a> {
    fn new(id: u64, node: Xml<'a>, inputs: Named<'a>) -> Result<Self> {
        let nodes: Vec<_> = children(node).filter(|n| !matches!(n.tag_name().name(), "in" | "out")).collect();
        let mut by_name = FxHashMap::default();
        for (i, one) in nodes.iter().enumerate() {
            let name = attribute(*one, "identifier")?;
            if by_name.insert(name, i).is_some() {
                return Err(wrong(*one, format!("two nodes of function {id} are called {name:?}")));
            }
        }
        let done = vec![None; nodes.len()];
        Ok(Function { id, inputs, nodes, by_name, done })
    }

    /// The node a reference is to; `None` for an input of the function.
    fn target(&self, reference: Xml<'a>) -> Result<Option<usize>> {
        let text = attribute(reference, "ref")?;
        let name = text.split('.').next().unwrap_or_default();
        if name == "inputs" {
            return Ok(None);
        }
        let found = self.by_name.get(name).copied().map(Some);
        found.ok_or_else(|| wrong(reference, format!("function {} has no node {name:?}", self.id)))
    }

    /// The value a reference is to; `None` if it is not computed yet.
    fn get(&self, reference: Xml<'a>) -> Result<Option<Value>> {
        let text = attribute(reference, "ref")?;
        let output = text.split_once('.').map_or("", |(_, output)| output);
        let from = match self.target(reference)? {
            Some(i) => match &self.done[i] {
                Some(all) => all,
                None => return Ok(None),
            },
            None => &self.inputs,
        };
        let value = from.get(output).ok_or_else(|| {
            let what = if text.starts_with("inputs.") {
                format!("function {} is called without an input {output:?}", self.id)
            } else {
                format!("{text:?} is no output of a node")
            };
            wrong(reference, what)
        })?;
        let fits = match reference.tag_name().name() {
            "scalarref" => matches!(value, Value::Scalar(_)),
            "vectorref" => matches!(value, Value::Vector(_)),
            "matrixref" => matches!(value, Value::Matrix(_)),
            "resourceref" => matches!(value, Value::Resource(_)),
            other => return Err(wrong(reference, format!("<{other}> is no reference to a value"))),
        };
        if !fits {
            return Err(wrong(reference, format!("{text:?} is {}", value.kind())));
        }
        Ok(Some(value.clone()))
    }

    /// The input of a node that has some name.
    fn input(&self, node: Xml<'a>, name: &str) -> Result<Value> {
        let mut inputs = child(node, "in").into_iter().flat_map(children);
        let input = inputs.find(|n| n.attribute("identifier") == Some(name));
        let word = node.tag_name().name();
        let input = input.ok_or_else(|| wrong(node, format!("<{word}> has no input {name:?}")))?;
        self.get(input)?.ok_or_else(|| wrong(input, "this is not computed"))
    }

    fn scalar(&self, node: Xml<'a>, name: &str) -> Result<Expr> {
        let value = self.input(node, name)?;
        value.scalar().ok_or_else(|| wrong(node, format!("input {name:?} is {}, not a scalar", value.kind())))
    }

    fn vector(&self, node: Xml<'a>, name: &str) -> Result<[Expr; 3]> {
        let value = self.input(node, name)?;
        value.vector().ok_or_else(|| wrong(node, format!("input {name:?} is {}, not a vector", value.kind())))
    }

    fn matrix(&self, node: Xml<'a>, name: &str) -> Result<[Expr; 16]> {
        let value = self.input(node, name)?;
        value.matrix().ok_or_else(|| wrong(node, format!("input {name:?} is {}, not a matrix", value.kind())))
    }

    fn scalars<const N: usize>(&self, node: Xml<'a>, name: impl Fn(usize) -> String) -> Result<[Expr; N]> {
        let all = (0..N).map(|k| self.scalar(node, &name(k))).collect::<Result<Vec<_>>>()?;
        all.try_into().map_err(|_| wrong(node, "inputs are missing"))
    }
}

/// Nodes that do not work on each number by itself: the name of the output and its value.
fn other<'a>(f: &Function<'a>, node: Xml<'a>) -> Result<(&'static str, Value)> {
    let matrix = |all: [Expr; 16]| Value::Matrix(Box::new(all));
    let four = || ["A", "B", "C", "D"].iter().map(|n| f.vector(node, n)).collect::<Result<Vec<_>>>();
    let value = match node.tag_name().name() {
        "constant" => return Ok(("value", Value::Scalar(Expr::constant(real(node, "value")?)))),
        "constvec" => {
            let [x, y, z] = [real(node, "x")?, real(node, "y")?, real(node, "z")?].map(Expr::constant);
            return Ok(("vector", Value::Vector([x, y, z])));
        }
        "constmat" => {
            let text = attribute(node, "matrix")?;
            let all: Option<Vec<f64>> = text.split_whitespace().map(finite).collect();
            let all = all.and_then(|all| <[f64; 16]>::try_from(all).ok());
            let all = all.ok_or_else(|| wrong(node, "matrix is no list of 16 finite numbers"))?;
            return Ok(("matrix", matrix(all.map(Expr::constant))));
        }
        "constresourceid" | "resourceid" => return Ok(("value", Value::Resource(number(node, "value")?))),
        "composevector" => Value::Vector(f.scalars(node, |k| ["x", "y", "z"][k].to_string())?),
        "vectorfromscalar" => {
            let a = f.scalar(node, "A")?;
            Value::Vector([a.clone(), a.clone(), a])
        }
        "decomposevector" => Value::Vector(f.vector(node, "A")?),
        "composematrix" => matrix(f.scalars(node, |k| format!("m{}{}", k / 4, k % 4))?),
        word @ ("matrixfromcolumns" | "matrixfromrows") => {
            let lines = four()?;
            let last = |k: usize| Expr::constant(if k == 3 { 1.0 } else { 0.0 });
            // Each line with a fourth number; columns are rows of the other matrix.
            let rows = std::array::from_fn(|i| lines[i / 4].get(i % 4).cloned().unwrap_or_else(|| last(i / 4)));
            matrix(if word == "matrixfromrows" { rows } else { transposed(&rows) })
        }
        "dot" => Value::Scalar(dot(&f.vector(node, "A")?, &f.vector(node, "B")?)),
        "cross" => Value::Vector(cross(&f.vector(node, "A")?, &f.vector(node, "B")?)),
        "matvecmultiplication" | "matrixvectormultiplication" => {
            Value::Vector(moved(&f.matrix(node, "A")?, &f.vector(node, "B")?))
        }
        "transpose" => matrix(transposed(&f.matrix(node, "A")?)),
        "inverse" => matrix(inverse(&f.matrix(node, "A")?)),
        "length" => {
            let [x, y, z] = f.vector(node, "A")?.map(|e| Expr::binary(Binary::Pow, e, Expr::constant(2.0)));
            Value::Scalar(Expr::unary(Unary::Sqrt, x + y + z))
        }
        word => return Err(unread(node, word)),
    };
    Ok(("result", value))
}

/// The error for a node that has no formula.
fn unread(node: Xml<'_>, word: &str) -> Error {
    let place = place_of(node);
    let known = OTHERS.iter().copied();
    match word {
        "mesh" | "unsignedmesh" => {
            Error::input(place, format!("the node <{word}> is the distance to a mesh, which has no formula"))
        }
        _ => {
            let e = Error::input(place, format!("the node <{word}> is not known"));
            match nearest(word, known) {
                Some(near) => e.with_help(format!("is it <{near}>?")),
                None => e,
            }
        }
    }
}
