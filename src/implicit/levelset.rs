//! A solid written as a level set of a 3MF model: a graph of nodes within a box.

use std::fmt::Write;

use super::model::Implicit;
use super::written::{Operation, Operations, Words, around, solid};
use crate::error::{Error, Result};
use crate::io::threemf::{Scaled, escaped, packed, unit_of};
use crate::spatial::Aabb;

/// The operations as they are called here, as a 3MF node is, and how many operands they have.
const NODES: [(&str, &str, usize); 24] = [
    ("add", "addition", 2),
    ("sub", "subtraction", 2),
    ("mul", "multiplication", 2),
    ("div", "division", 2),
    ("min", "min", 2),
    ("max", "max", 2),
    ("pow", "pow", 2),
    ("mod", "mod", 2),
    ("atan2", "arctan2", 2),
    ("abs", "abs", 1),
    ("sqrt", "sqrt", 1),
    ("sin", "sin", 1),
    ("cos", "cos", 1),
    ("tan", "tan", 1),
    ("asin", "arcsin", 1),
    ("acos", "arccos", 1),
    ("exp", "exp", 1),
    ("ln", "log", 1),
    ("floor", "floor", 1),
    ("sign", "sign", 1),
    ("sinh", "sinh", 1),
    ("cosh", "cosh", 1),
    ("tanh", "tanh", 1),
    ("select", "select", 4),
];

/// Triangles of a box whose corners are numbered by the bits of x, y and z.
const SIDES: [[u32; 3]; 12] = [
    [0, 2, 1],
    [1, 2, 3],
    [4, 5, 6],
    [5, 7, 6],
    [0, 1, 4],
    [1, 5, 4],
    [2, 6, 3],
    [3, 6, 7],
    [0, 4, 2],
    [2, 4, 6],
    [1, 3, 5],
    [3, 7, 5],
];

/// The solid as a 3MF package: its formula, negative inside, as an implicit function, and a level set of it in a box with some room.
/// `unit` is one that a part file knows; without one it is millimeters.
///
/// Errors: an [`Error::Input`] for a solid with a program's function, values on a grid or blends, which have no formula here.
pub fn write_3mf(model: &Implicit, name: &str, unit: Option<&str>) -> Result<Vec<u8>> {
    let mut list = Operations::new(Words::Many);
    let root = solid(model, &mut list)?;
    let root = list.line("neg", &[root]);
    let Scaled { unit, transform } = unit_of(unit)?;
    let name = escaped(name);
    let mut text = format!(
        r#"<?xml version="1.0" encoding="UTF-8"?>
<model unit="{unit}" xml:lang="en-US" xmlns="http://schemas.microsoft.com/3dmanufacturing/core/2015/02" xmlns:v="http://schemas.3mf.io/3dmanufacturing/volumetric/2022/01" xmlns:i="http://schemas.3mf.io/3dmanufacturing/implicit/2023/12" requiredextensions="v i">
<resources>
<i:implicitfunction id="1" displayname="{name}">
<i:in><i:vector identifier="pos" displayname="pos"/></i:in>
"#
    );
    nodes(&list, &mut text)?;
    // Writing to a string does not fail.
    let _ = write!(
        text,
        r#"<i:out><i:scalarref identifier="shape" displayname="shape" ref="{}"/></i:out>
</i:implicitfunction>
<object id="2" type="model" name="{name} box">
"#,
        reference(&list, root)
    );
    box_mesh(&around(model), &mut text);
    let _ = write!(
        text,
        r#"</object>
<object id="3" type="model" name="{name}">
<v:levelset functionid="1" channel="shape" meshid="2" meshbboxonly="true" minfeaturesize="0" fallbackvalue="0"/>
</object>
</resources>
<build><item objectid="3"{transform}/></build>
</model>
"#
    );
    packed(&text)
}

fn nodes(list: &Operations, text: &mut String) -> Result<()> {
    let uses = |words: &[&str]| list.all.iter().any(|o| matches!(o, Operation::Of(word, _) if words.contains(word)));
    if list.all.iter().any(|o| matches!(o, Operation::Coordinate(_))) {
        node(text, "decomposevector", "p", &[("A", "inputs.pos".into())]);
    }
    for (used, name, value) in [(uses(&["neg", "select"]), "zero", 0.0), (uses(&["recip"]), "one", 1.0)] {
        if used {
            constant(text, name, value);
        }
    }
    for (i, one) in list.all.iter().enumerate() {
        let own = format!("n{i}");
        let (word, operands) = match one {
            Operation::Coordinate(_) => continue,
            Operation::Constant(bits) => {
                constant(text, &own, f64::from_bits(*bits));
                continue;
            }
            Operation::Of(word, operands) => (*word, operands),
        };
        let at = |k: usize| operands.get(k).map_or_else(String::new, |o| reference(list, *o));
        let (zero, ready) = (|| "zero.value".to_string(), |a, b| vec![a, b]);
        let (word, inputs) = match word {
            "neg" => ("sub", ready(zero(), at(0))),
            "recip" => ("div", ready("one.value".into(), at(0))),
            "square" => ("mul", ready(at(0), at(0))),
            // The third input where the first is less than the second.
            "select" => ("select", vec![at(0), zero(), at(2), at(1)]),
            word => (word, (0..operands.len()).map(at).collect()),
        };
        let Some((_, element, _)) = NODES.iter().find(|n| n.0 == word && n.2 == inputs.len()) else {
            return Err(Error::Failed(format!("3MF has no node for {word:?}")));
        };
        let inputs: Vec<_> = ["A", "B", "C", "D"].into_iter().zip(inputs).collect();
        node(text, element, &own, &inputs);
    }
    Ok(())
}

/// The output that holds the value of an operation.
fn reference(list: &Operations, i: u32) -> String {
    match list.all.get(i as usize) {
        Some(Operation::Coordinate(axis)) => format!("p.{}", ["x", "y", "z"][axis % 3]),
        Some(Operation::Constant(_)) => format!("n{i}.value"),
        _ => format!("n{i}.result"),
    }
}

fn constant(text: &mut String, name: &str, value: f64) {
    let _ = writeln!(
        text,
        r#"<i:constant identifier="{name}" displayname="{name}" value="{value:?}"><i:out><i:scalar identifier="value" displayname="value"/></i:out></i:constant>"#
    );
}

fn node(text: &mut String, element: &str, name: &str, inputs: &[(&str, String)]) {
    let _ = write!(text, r#"<i:{element} identifier="{name}" displayname="{name}"><i:in>"#);
    let vector = element == "decomposevector";
    let kind = if vector { "vectorref" } else { "scalarref" };
    for (input, from) in inputs {
        let _ = write!(text, r#"<i:{kind} identifier="{input}" displayname="{input}" ref="{from}"/>"#);
    }
    text.push_str("</i:in><i:out>");
    let outputs: &[&str] = if vector { &["x", "y", "z"] } else { &["result"] };
    for output in outputs {
        let _ = write!(text, r#"<i:scalar identifier="{output}" displayname="{output}"/>"#);
    }
    let _ = writeln!(text, "</i:out></i:{element}>");
}

fn box_mesh(bounds: &Aabb, text: &mut String) {
    text.push_str("<mesh>\n<vertices>\n");
    for i in 0..8 {
        let at = |axis: usize| if i >> axis & 1 == 1 { bounds.hi[axis] } else { bounds.lo[axis] };
        let _ = writeln!(text, r#"<vertex x="{:?}" y="{:?}" z="{:?}"/>"#, at(0), at(1), at(2));
    }
    text.push_str("</vertices>\n<triangles>\n");
    for [a, b, c] in SIDES {
        let _ = writeln!(text, r#"<triangle v1="{a}" v2="{b}" v3="{c}"/>"#);
    }
    text.push_str("</triangles>\n</mesh>\n");
}
