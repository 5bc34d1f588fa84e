//! Boundary representations from STEP files (AP203, AP214, AP242): what the records mean. Lengths become millimeters.
//!
//! Parameter curves (`PCURVE`) are not used: parameters are found again by projection, so files without them, or with
//! wrong ones, read alike. What is not understood is listed by record and line; nothing is left out in silence.

mod geometry;
mod topology;
mod values;
mod write;

pub use write::write_step;

use rustc_hash::{FxHashMap, FxHashSet};

use super::brep::{Brep, Note};
use super::frame::Similarity;
use crate::error::{Error, Place, Result};
use crate::io::step::{Record, StepFile, Value};
use crate::numeric::Sets;
use crate::run::{DEEPEST, Run};
use topology::{BODIES, BodyBuilder, Units};
use values::{Args, Lookup, Read, note};

/// No more placed bodies than this are made: small files can ask for any number.
const MOST_BODIES: usize = 100_000;
/// Millimeters in a meter.
const METER: f64 = 1000.0;

/// What reading gave.
#[derive(Debug, Clone, Default)]
pub struct StepModel {
    /// The model, in millimeters.
    pub brep: Brep,
    /// What was not understood, or had to be put right.
    pub notes: Vec<Note>,
    /// Points nearer to each other than this are one, in millimeters, where the file says so.
    pub tolerance: Option<f64>,
}

impl From<Brep> for StepModel {
    fn from(brep: Brep) -> Self {
        Self { brep, ..Self::default() }
    }
}

/// Interprets a file.
///
/// *Guarantees*: indices are in range; edges of a loop follow each other; names of faces are unique.
/// *Does not guarantee*: that faces are sound, or that edges lie on the surfaces they bound.
/// *Errors*: [`Error::Input`] when there is no face; cancellation.
pub fn interpret(file: &StepFile, run: &Run) -> Result<StepModel> {
    let look = Lookup { file };
    let mut b = BodyBuilder { look, brep: Brep::default(), notes: Vec::new(), colors: colors(look) };
    for (line, what) in &file.unreadable {
        b.notes.push(Note { id: 0, line: *line, message: what.clone(), lost: false });
    }
    let tree = Tree::new(look, &mut b.notes);
    // Roots that are products come first; other representations may list the same bodies again.
    let mut placed: FxHashMap<u64, Vec<Similarity>> = FxHashMap::default();
    let (mut products, mut others): (Vec<usize>, Vec<usize>) = tree.roots().partition(|g| tree.is_product(*g));
    if products.is_empty() {
        std::mem::swap(&mut products, &mut others);
    }
    for root in products {
        tree.place(root, Similarity::IDENTITY, &mut Placing { b: &mut b, placed: &mut placed, again: true, run }, 0)?;
    }
    for root in others {
        tree.place(root, Similarity::IDENTITY, &mut Placing { b: &mut b, placed: &mut placed, again: false, run }, 0)?;
    }
    // Bodies no representation leads to.
    for name in &BODIES[..5] {
        for r in file.of(name) {
            if placed.contains_key(&r.id) {
                continue;
            }
            placed.insert(r.id, Vec::new());
            let units = tree.units.first().map_or(Units { length: 1.0, angle: 1.0 }, |u| u.1);
            b.body(r.id, Similarity::scaled(units.length), units, None, "body");
        }
    }
    let tolerance = tree.tolerance();
    let BodyBuilder { mut brep, notes, .. } = b;
    if brep.faces.is_empty() {
        let why = notes.iter().take(3).map(|n| format!("; {n}")).collect::<String>();
        return Err(Error::input(Place::Unknown, format!("the file has no face that is understood{why}")));
    }
    name_faces(&mut brep);
    Ok(StepModel { brep, notes, tolerance })
}

/// Gives every face a name of its own: its own where it has one, else that of its body and a number.
fn name_faces(brep: &mut Brep) {
    let mut body_names = FxHashSet::default();
    for i in 0..brep.bodies.len() {
        let own = brep.bodies[i].name.clone();
        let base = if own.is_empty() { "body".to_string() } else { own };
        brep.bodies[i].name = unique(base, &mut body_names);
    }
    let mut names = FxHashSet::default();
    let several = brep.bodies.len() > 1;
    for body in &brep.bodies {
        for (k, f) in body.faces.iter().enumerate() {
            let face = &mut brep.faces[*f as usize];
            let own = if face.name.is_empty() { format!("face{}", k + 1) } else { face.name.clone() };
            // Names that tell their body already stay.
            let told = own.strip_prefix(&body.name).is_some_and(|rest| rest.starts_with('.'));
            let full = if several && !told { format!("{}.{own}", body.name) } else { own };
            face.name = unique(full, &mut names);
        }
    }
}

fn unique(base: String, used: &mut FxHashSet<String>) -> String {
    let mut name = base.clone();
    let mut k = 2;
    while !used.insert(name.clone()) {
        name = format!("{base}~{k}");
        k += 1;
    }
    name
}

/// Colors of faces, shells and bodies.
fn colors(look: Lookup<'_>) -> FxHashMap<u64, [f64; 3]> {
    let mut out = FxHashMap::default();
    for kind in ["STYLED_ITEM", "OVER_RIDING_STYLED_ITEM"] {
        for record in look.file.of(kind) {
            let Some(values) = record.part(kind) else { continue };
            let a = Args { record, values };
            let (Ok(styles), Some(item)) = (a.references(1), a.optional(2)) else { continue };
            if let Some(c) = styles.iter().find_map(|s| color(look, *s, 0)) {
                out.insert(item, c);
            }
        }
    }
    out
}

fn color(look: Lookup<'_>, id: u64, depth: usize) -> Option<[f64; 3]> {
    let record = look.file.get(id).filter(|_| depth < 8)?;
    if let Some(values) = record.part("COLOUR_RGB") {
        let a = Args { record, values };
        return Some([a.number(1).ok()?, a.number(2).ok()?, a.number(3).ok()?]);
    }
    if record.name().contains("CURVE_STYLE") {
        return None;
    }
    refs(record).find_map(|r| color(look, r, depth + 1))
}

/// All references of a record, one list deep.
fn refs(record: &Record) -> impl Iterator<Item = u64> + '_ {
    record.parts.iter().flat_map(|p| &p.1).flat_map(|v| match v {
        Value::Ref(id) => vec![*id],
        Value::List(l) => l.iter().filter_map(|v| if let Value::Ref(id) = v { Some(*id) } else { None }).collect(),
        _ => Vec::new(),
    })
}

/// What is carried along while bodies are placed.
struct Placing<'p, 'a> {
    b: &'p mut BodyBuilder<'a>,
    /// Bodies that have been placed, and where.
    placed: &'p mut FxHashMap<u64, Vec<Similarity>>,
    /// Whether a body may stand in several places.
    again: bool,
    run: &'p Run,
}

/// Representations, what is in them, and which stand in which.
struct Tree<'a> {
    look: Lookup<'a>,
    /// Every representation with the group of equal ones it belongs to, in the file's order.
    group: FxHashMap<u64, usize>,
    members: Vec<Vec<u64>>,
    /// Children of each group.
    children: Vec<Vec<(usize, Similarity)>>,
    is_child: Vec<bool>,
    names: FxHashMap<u64, String>,
    units: Vec<(u64, Units)>,
}

impl<'a> Tree<'a> {
    fn new(look: Lookup<'a>, notes: &mut Vec<Note>) -> Self {
        let mut this = Tree {
            look,
            group: FxHashMap::default(),
            members: Vec::new(),
            children: Vec::new(),
            is_child: Vec::new(),
            names: FxHashMap::default(),
            units: Vec::new(),
        };
        let mut reps: Vec<u64> = Vec::new();
        for r in &look.file.records {
            let is = r.parts.len() == 1 && r.parts[0].0.ends_with("REPRESENTATION") && r.parts[0].1.len() >= 3;
            if is && matches!(r.parts[0].1[1], Value::List(_)) {
                this.group.insert(r.id, reps.len());
                reps.push(r.id);
            }
        }
        // Plain relationships say that two representations are of the same thing.
        let mut sets = Sets::new(reps.len());
        for r in look.file.of("SHAPE_REPRESENTATION_RELATIONSHIP").filter(|r| r.parts.len() == 1) {
            let a = Args { record: r, values: &r.parts[0].1 };
            if let (Some(x), Some(y)) = (a.optional(2), a.optional(3))
                && let (Some(&x), Some(&y)) = (this.group.get(&x), this.group.get(&y))
            {
                sets.join(x as u32, y as u32);
            }
        }
        this.members = vec![Vec::new(); reps.len()];
        for (i, rep) in reps.iter().enumerate() {
            let l = sets.find(i as u32) as usize;
            this.group.insert(*rep, l);
            this.members[l].push(*rep);
        }
        this.children = vec![Vec::new(); reps.len()];
        this.is_child = vec![false; reps.len()];
        for rep in &reps {
            match this.units_of(*rep) {
                Ok(u) => this.units.push((*rep, u)),
                Err(n) => notes.push(n),
            }
        }
        this.name_products();
        this.link(notes);
        for rep in reps {
            if let Err(n) = this.link_mapped(rep) {
                notes.push(n);
            }
        }
        this
    }

    fn name_products(&mut self) {
        for r in self.look.file.of("SHAPE_DEFINITION_REPRESENTATION") {
            let a = Args { record: r, values: &r.parts[0].1 };
            let (Some(mut at), Some(rep)) = (a.optional(0), a.optional(1)) else { continue };
            // From the property over the definition and its formation to the product.
            for _ in 0..6 {
                let Some(record) = self.look.file.get(at) else { break };
                if let Some(values) = record.part("PRODUCT") {
                    let a = Args { record, values };
                    let text = if a.text(0).is_empty() { a.text(1) } else { a.text(0) };
                    self.names.insert(rep, text.to_string());
                    break;
                }
                let Some((_, values)) = record.parts.first() else { break };
                let next = Args { record, values };
                let Some(i) = next.optional(2).or_else(|| next.optional(3)) else { break };
                at = i;
            }
        }
    }

    fn units(&self, rep: u64) -> Units {
        let found = self.units.iter().find(|u| u.0 == rep);
        found.map_or(Units { length: 1.0, angle: 1.0 }, |u| u.1)
    }

    /// Children by relationships with a transformation.
    fn link(&mut self, notes: &mut Vec<Note>) {
        let look = self.look;
        let assemblies = self.assemblies();
        for r in look.file.of("REPRESENTATION_RELATIONSHIP_WITH_TRANSFORMATION") {
            if let Err(n) = self.link_one(r, &assemblies) {
                notes.push(n);
            }
        }
    }

    /// For each placement (by its record) a representation of the assembly that is placed into, where the file tells.
    fn assemblies(&self) -> FxHashMap<u64, u64> {
        let look = self.look;
        let argument = |id: u64, names: &[&str], i: usize| look.args(id, names).ok().and_then(|a| a.optional(i));
        // Representations of product definitions.
        let mut shape: FxHashMap<u64, u64> = FxHashMap::default();
        for r in look.file.of("SHAPE_DEFINITION_REPRESENTATION") {
            let a = Args { record: r, values: &r.parts[0].1 };
            let (Some(property), Some(rep)) = (a.optional(0), a.optional(1)) else { continue };
            if let Some(definition) = argument(property, &["PRODUCT_DEFINITION_SHAPE"], 2) {
                shape.insert(definition, rep);
            }
        }
        let mut out = FxHashMap::default();
        for r in look.file.of("CONTEXT_DEPENDENT_SHAPE_REPRESENTATION") {
            let a = Args { record: r, values: &r.parts[0].1 };
            let (Some(relation), Some(property)) = (a.optional(0), a.optional(1)) else { continue };
            let usage = argument(property, &["PRODUCT_DEFINITION_SHAPE"], 2);
            let names = ["NEXT_ASSEMBLY_USAGE_OCCURRENCE"];
            if let Some(rep) = usage.and_then(|u| argument(u, &names, 3)).and_then(|p| shape.get(&p)) {
                out.insert(relation, *rep);
            }
        }
        out
    }

    fn link_one(&mut self, record: &Record, assemblies: &FxHashMap<u64, u64>) -> Read<()> {
        let (Some(pair), Some(by)) = (
            record.part("REPRESENTATION_RELATIONSHIP"),
            record.part("REPRESENTATION_RELATIONSHIP_WITH_TRANSFORMATION"),
        ) else {
            return note(record, "a placement without representations");
        };
        let pair = Args { record, values: pair };
        let by = Args { record, values: by }.reference(0)?;
        let (mut child, mut parent) = (pair.reference(2)?, pair.reference(3)?);
        let t = self.look.args(by, &["ITEM_DEFINED_TRANSFORMATION"])?;
        let (mut from, mut to) = (t.reference(2)?, t.reference(3)?);
        // Some systems name the assembly first; the usage of the product tells which is which.
        if let Some(assembly) = assemblies.get(&record.id)
            && self.group.get(assembly) == self.group.get(&child)
        {
            (child, parent) = (parent, child);
            (from, to) = (to, from);
        }
        let (Some(&c), Some(&p)) = (self.group.get(&child), self.group.get(&parent)) else {
            return note(record, "a placement of something that is no representation");
        };
        let frame = |id: u64, rep: u64| -> Read<_> {
            let scale = Similarity::scaled(self.units(rep).length);
            Ok(scale.frame(&self.look.frame(id)?))
        };
        let place = Similarity::between(&frame(from, child)?, &frame(to, parent)?);
        if c != p {
            self.children[p].push((c, place));
            self.is_child[c] = true;
        }
        Ok(())
    }

    /// Children by mapped items.
    fn link_mapped(&mut self, rep: u64) -> Read<()> {
        let items = self.items(rep)?;
        for item in items {
            let Some(record) = self.look.file.get(item) else { continue };
            let Some(values) = record.part("MAPPED_ITEM") else { continue };
            let a = Args { record, values };
            let (map, target) = (a.reference(1)?, a.reference(2)?);
            let m = self.look.args(map, &["REPRESENTATION_MAP"])?;
            let (origin, child) = (m.reference(0)?, m.reference(1)?);
            let (Some(&c), Some(&p)) = (self.group.get(&child), self.group.get(&rep)) else { continue };
            let of = |id: u64, rep: u64| -> Read<_> {
                Ok(Similarity::scaled(self.units(rep).length).frame(&self.look.frame(id)?))
            };
            let place = Similarity::between(&of(origin, child)?, &of(target, rep)?);
            if c != p {
                self.children[p].push((c, place));
                self.is_child[c] = true;
            }
        }
        Ok(())
    }

    fn items(&self, rep: u64) -> Read<Vec<u64>> {
        let record = self.look.record(rep)?;
        Args { record, values: &record.parts[0].1 }.references(1)
    }

    fn roots(&self) -> impl Iterator<Item = usize> + '_ {
        (0..self.members.len()).filter(|&g| !self.members[g].is_empty() && !self.is_child[g])
    }

    /// Whether a product definition leads to the group.
    fn is_product(&self, group: usize) -> bool {
        self.members[group].iter().any(|r| self.names.contains_key(r))
    }

    /// Adds all bodies of a group and of what stands in it.
    fn place(&self, group: usize, place: Similarity, at: &mut Placing<'_, '_>, depth: usize) -> Result<()> {
        at.run.check()?;
        if depth > DEEPEST || at.b.brep.bodies.len() > MOST_BODIES {
            let message = "the assembly is too deep or too large: parts of it are left out".into();
            at.b.notes.push(Note { id: self.members[group][0], line: 0, message, lost: true });
            return Ok(());
        }
        let product = self.members[group].iter().find_map(|r| self.names.get(r)).cloned().unwrap_or_default();
        // Representations that are said to be equal may both list a body.
        let mut here = FxHashSet::default();
        for &rep in &self.members[group] {
            let units = self.units(rep);
            let moved = place.after(&Similarity::scaled(units.length));
            for item in self.items(rep).unwrap_or_default() {
                let Some(record) = self.look.file.get(item) else { continue };
                let Some((_, values)) = record.parts.iter().find(|p| BODIES.contains(&p.0.as_str())) else { continue };
                let places = at.placed.entry(item).or_default();
                if !here.insert(item) || (!places.is_empty() && !at.again) || places.contains(&moved) {
                    continue;
                }
                places.push(moved);
                let own = Args { record, values }.text(0).to_string();
                let own = if own.eq_ignore_ascii_case("none") { String::new() } else { own };
                let name = if own.is_empty() { product.clone() } else { own };
                let color = at.b.colors.get(&rep).copied();
                at.b.body(item, moved, units, color, &name);
            }
        }
        for (child, by) in &self.children[group] {
            self.place(*child, place.after(by), at, depth + 1)?;
        }
        Ok(())
    }

    /// The units of a representation's context.
    fn units_of(&self, rep: u64) -> Read<Units> {
        let record = self.look.record(rep)?;
        let mut out = Units { length: 1.0, angle: 1.0 };
        let Some(context) = (Args { record, values: &record.parts[0].1 }).optional(2) else { return Ok(out) };
        let record = self.look.record(context)?;
        let Some(values) = record.part("GLOBAL_UNIT_ASSIGNED_CONTEXT") else { return Ok(out) };
        for unit in (Args { record, values }).references(0)? {
            let record = self.look.record(unit)?;
            if record.part("LENGTH_UNIT").is_some() {
                out.length = self.unit(record, 0)? * METER;
            } else if record.part("PLANE_ANGLE_UNIT").is_some() {
                out.angle = self.unit(record, 0)?;
            }
        }
        Ok(out)
    }

    /// The largest length the file gives as its accuracy, in millimeters.
    fn tolerance(&self) -> Option<f64> {
        let given = |record: &Record| {
            let a = Args { record, values: record.part("UNCERTAINTY_MEASURE_WITH_UNIT")? };
            let unit = self.look.file.get(a.optional(1)?)?;
            unit.part("LENGTH_UNIT")?;
            Some(a.positive(0).ok()? * self.unit(unit, 0).ok()? * METER)
        };
        self.look.file.of("UNCERTAINTY_MEASURE_WITH_UNIT").filter_map(given).max_by(f64::total_cmp)
    }

    /// A unit in meters or radians.
    fn unit(&self, record: &Record, depth: usize) -> Read<f64> {
        if let Some(v) = record.part("SI_UNIT") {
            return match v.first() {
                Some(Value::Word(prefix)) => match si_prefix(prefix) {
                    Some(f) => Ok(f),
                    None => note(record, format!("the prefix {prefix} is not known")),
                },
                _ => Ok(1.0),
            };
        }
        let Some(values) = record.part("CONVERSION_BASED_UNIT").filter(|_| depth < 4) else {
            return note(record, "a unit that is not known");
        };
        let by = Args { record, values }.reference(1)?;
        let record = self.look.record(by)?;
        let Some((_, values)) = record.parts.iter().find(|p| p.1.len() >= 2) else {
            return note(record, "a measure without a unit");
        };
        let a = Args { record, values };
        let base = self.look.record(a.reference(1)?)?;
        Ok(a.positive(0)? * self.unit(base, depth + 1)?)
    }
}

fn si_prefix(word: &str) -> Option<f64> {
    Some(match word {
        "KILO" => 1e3,
        "HECTO" => 1e2,
        "DECA" => 1e1,
        "DECI" => 1e-1,
        "CENTI" => 1e-2,
        "MILLI" => 1e-3,
        "MICRO" => 1e-6,
        "NANO" => 1e-9,
        _ => return None,
    })
}

#[cfg(test)]
mod tests;
