//! Formulas as leaves: taken apart first where they have switches and steps.

use super::{Context, Lowered, Lowerer, Op, Part, Primitive, Result, Solid};
use crate::implicit::expr::Expr;
use crate::implicit::formula::Formula;
use crate::implicit::jumps::beside_jump;
use crate::implicit::leaf::Leaf;
use crate::implicit::model::Implicit;
use crate::implicit::solid::Placement;
use crate::implicit::steps::{Within, has_steps, taken_apart};
use crate::spatial::Aabb;

/// Lowers a solid. Steps in formulas are taken apart where the rest of the tree tells a box around everything.
pub(crate) fn lower(solid: &Solid) -> Result<Lowered> {
    let mut l = Lowerer::default();
    let mut root = l.tree(solid, Placement::IDENTITY)?;
    if l.has_steps && root.bounds.is_finite() && !root.bounds.is_empty() {
        return lower_within(solid, Within { bounds: root.bounds, closed: true });
    }
    if l.has_steps {
        // What formulas say of their own bounds holds for them whole.
        l = Lowerer { trusts: true, ..Lowerer::default() };
        root = l.tree(solid, Placement::IDENTITY)?;
    }
    Ok(l.finish(root))
}

/// Lowers a solid with steps in formulas taken apart.
pub(in crate::implicit) fn lower_within(solid: &Solid, within: Within) -> Result<Lowered> {
    let mut l = Lowerer { within: Some(within), ..Lowerer::default() };
    let root = l.tree(solid, Placement::IDENTITY)?;
    l.has_steps = false;
    Ok(l.finish(root))
}

impl Lowerer {
    pub(super) fn formula(&mut self, solid: &Solid, e: &Expr, mut c: Context) -> Result<Part> {
        let Some(parts) = taken_apart(e, &c.place, self.within.as_ref()).or_else(|| beside_jump(e)) else {
            return self.primitive(solid, &Primitive::Formula(e.clone()), &c);
        };
        // All parts are one face to the user.
        if c.name.is_none() {
            c.name = Some(self.base_name(solid, "formula").into());
        }
        let whole = Leaf::Formula(Formula::compile(e, &c.place));
        // Steps wait in what is cut off, too.
        let waits = self.waits(e);
        let known = if c.negate || waits { None } else { Implicit::box_of(whole) };
        // Steps that are left in the parts stay there.
        let within = self.within.take();
        let part = self.tree_from(&parts, c);
        self.within = within;
        let mut part = part?;
        part.bounds = part.bounds.intersection(&known.unwrap_or(Aabb::ALL));
        Ok(part)
    }

    /// A formula as one leaf.
    pub(super) fn whole_formula(&mut self, e: &Expr, face: u32, c: &Context) -> Part {
        if let Some(v) = e.as_constant() {
            return Part { op: self.op(Op::All((v >= 0.0) != c.negate)), bounds: Aabb::ALL };
        }
        let leaf = Leaf::Formula(Formula::compile(e, &c.place));
        let known = if self.waits(e) || c.negate { None } else { Implicit::box_of(leaf.clone()) };
        Part { op: self.leaf(leaf, face, c.negate), bounds: known.unwrap_or(Aabb::ALL) }
    }

    /// Whether a formula has steps that wait for a box to be taken apart in: what it says of its own bounds does not count then.
    pub(super) fn waits(&mut self, e: &Expr) -> bool {
        let waits = self.within.is_none() && has_steps(e);
        self.has_steps |= waits;
        waits && !self.trusts
    }
}
