//! Which operands a part's tree joins, and how: parts of it that are R-functions alone are one operand each.

use std::collections::BTreeSet;
use std::path::PathBuf;
use std::sync::Arc;

use rustc_hash::FxHashSet;

use crate::error::{Error, Place, Result};
use crate::implicit::{Boundary, Foreign, Placement, Primitive, Solid, SolidNode};
use crate::spatial::Aabb;

/// Set operations within set operations above solids given by boundaries, at most: what is deeper would need more stack than a
/// thread has. Chains of one operation count as one.
const DEEPEST: usize = 200;

/// How operands are joined.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum OperandTree {
    /// The operand of this number.
    Operand(usize),
    And(Vec<OperandTree>),
    Or(Vec<OperandTree>),
    Not(Box<OperandTree>),
}

/// What is joined.
#[derive(Debug, Clone)]
pub(super) enum Operand {
    Functions(Solid),
    Foreign(BoundarySolid),
}

/// A solid given by its boundary, with what the tree above says of it.
#[derive(Debug, Clone)]
pub(super) struct BoundarySolid {
    pub(super) solid: Arc<Foreign>,
    pub(super) placement: Placement,
    pub(super) name: Option<Arc<str>>,
    pub(super) size: Option<f64>,
}

impl OperandTree {
    /// Whether a point is inside, given the operands that it is in.
    pub(super) fn holds(&self, state: &[bool]) -> bool {
        match self {
            OperandTree::Operand(k) => state.get(*k).copied().unwrap_or(false),
            OperandTree::And(all) => all.iter().all(|t| t.holds(state)),
            OperandTree::Or(all) => all.iter().any(|t| t.holds(state)),
            OperandTree::Not(t) => !t.holds(state),
        }
    }

    /// The solid that is joined so of solids in the place of the operands.
    pub(super) fn of(&self, operands: &[Solid]) -> Solid {
        let all = |list: &[OperandTree]| list.iter().map(|t| t.of(operands)).collect::<Vec<_>>();
        match self {
            OperandTree::Operand(k) => operands.get(*k).cloned().unwrap_or_else(|| Solid::union([])),
            OperandTree::And(list) => Solid::intersection(all(list)),
            OperandTree::Or(list) => Solid::union(all(list)),
            OperandTree::Not(t) => !t.of(operands),
        }
    }

    /// A box around what is inside, or around what is outside, given boxes around the operands.
    fn extent(&self, bounds: &[Aabb], inside: bool) -> Aabb {
        let common = |all: &[OperandTree]| all.iter().fold(Aabb::ALL, |b, t| b.intersection(&t.extent(bounds, inside)));
        let together = |all: &[OperandTree]| {
            let boxes = all.iter().map(|t| t.extent(bounds, inside)).filter(|b| !b.is_empty());
            boxes.fold(Aabb::EMPTY, |b, x| b.union(&x))
        };
        match self {
            OperandTree::Operand(k) if inside => bounds.get(*k).copied().unwrap_or(Aabb::ALL),
            OperandTree::Operand(_) => Aabb::ALL,
            OperandTree::Not(t) => t.extent(bounds, !inside),
            OperandTree::And(all) if inside => common(all),
            OperandTree::Or(all) if !inside => common(all),
            OperandTree::And(all) | OperandTree::Or(all) => together(all),
        }
    }

    /// A box around where it makes a difference whether a point is in the operand of this number, given boxes around all operands:
    /// where what it is intersected with is, and where what it is united with is not.
    pub(super) fn matters(&self, operand: usize, bounds: &[Aabb]) -> Aabb {
        match self {
            OperandTree::Operand(k) if *k == operand => Aabb::ALL,
            OperandTree::Operand(_) => Aabb::EMPTY,
            OperandTree::Not(t) => t.matters(operand, bounds),
            OperandTree::And(all) | OperandTree::Or(all) => {
                let inside = matches!(self, OperandTree::And(_));
                let found = all.iter().map(|t| t.matters(operand, bounds)).enumerate().find(|x| !x.1.is_empty());
                let Some((holder, own)) = found else { return Aabb::EMPTY };
                let others = all.iter().enumerate().filter(|x| x.0 != holder);
                others.fold(own, |b, (_, t)| b.intersection(&t.extent(bounds, inside)))
            }
        }
    }
}

fn children(node: &SolidNode) -> Vec<&Solid> {
    match node {
        SolidNode::Primitive(_) => Vec::new(),
        SolidNode::And(all) | SolidNode::Or(all) => all.iter().collect(),
        SolidNode::Not(s) | SolidNode::Placed(_, s) | SolidNode::Named(_, s) | SolidNode::Sized(_, s) => vec![s],
        SolidNode::Blend(a, b, _) => vec![a, b],
    }
}

type Holders = FxHashSet<*const SolidNode>;

/// The nodes that hold a solid given by its boundary.
fn holders(solid: &Solid) -> Holders {
    let (mut seen, mut found) = (Holders::default(), Holders::default());
    let mut stack = vec![(solid, false)];
    while let Some((s, left)) = stack.pop() {
        let key: *const SolidNode = s.node();
        if left {
            if children(s.node()).iter().any(|c| found.contains(&std::ptr::from_ref(c.node()))) {
                found.insert(key);
            }
            continue;
        }
        if !seen.insert(key) {
            continue;
        }
        if matches!(s.node(), SolidNode::Primitive(Primitive::Foreign(_))) {
            found.insert(key);
        }
        stack.push((s, true));
        stack.extend(children(s.node()).into_iter().map(|c| (c, false)));
    }
    found
}

/// Whether a tree holds a solid given by its boundary.
pub(in crate::pipeline) fn holds_foreign(solid: &Solid) -> bool {
    !holders(solid).is_empty()
}

/// Whether a tree holds solids given by their boundaries alone, and none of R-functions.
pub(in crate::pipeline) fn is_foreign_alone(solid: &Solid) -> bool {
    let (mut seen, mut stack) = (Holders::default(), vec![solid]);
    while let Some(s) = stack.pop() {
        if !seen.insert(std::ptr::from_ref(s.node())) {
            continue;
        }
        if matches!(s.node(), SolidNode::Primitive(p) if !matches!(p, Primitive::Foreign(_))) {
            return false;
        }
        stack.extend(children(s.node()));
    }
    true
}

/// Paths of the files that solids of a tree are read from, as the part file has them, each once.
pub(in crate::pipeline) fn files_of(solid: &Solid) -> BTreeSet<PathBuf> {
    let (mut seen, mut stack, mut found) = (FxHashSet::default(), vec![solid], BTreeSet::new());
    while let Some(s) = stack.pop() {
        if !seen.insert(std::ptr::from_ref(s.node())) {
            continue;
        }
        if let SolidNode::Primitive(Primitive::Foreign(f)) = s.node()
            && let Boundary::Mesh(path) | Boundary::Step(path) = &f.source
        {
            found.insert(path.clone());
        }
        stack.extend(children(s.node()));
    }
    found
}

#[derive(Clone)]
struct Above {
    placement: Placement,
    name: Option<Arc<str>>,
    size: Option<f64>,
}

impl Above {
    fn put_on(&self, solid: Solid) -> Solid {
        let mut s = solid;
        if self.placement != Placement::IDENTITY {
            s = s.placed(self.placement);
        }
        if let Some(name) = &self.name {
            s = s.name(name);
        }
        match self.size {
            Some(h) => s.size(h),
            None => s,
        }
    }
}

struct TreeReader {
    holders: Holders,
    operands: Vec<Operand>,
}

/// The tree of a solid above its operands.
///
/// Errors: a solid given by its boundary in a blend, at its place in the part file; a tree that is too deep.
pub(super) fn read(solid: &Solid) -> Result<(OperandTree, Vec<Operand>)> {
    let mut reader = TreeReader { holders: holders(solid), operands: Vec::new() };
    let tree = reader.read(solid, Above { placement: Placement::IDENTITY, name: None, size: None }, 0)?;
    Ok((tree, reader.operands))
}

impl TreeReader {
    fn holds(&self, s: &Solid) -> bool {
        self.holders.contains(&std::ptr::from_ref(s.node()))
    }

    fn operand(&mut self, o: Operand) -> OperandTree {
        self.operands.push(o);
        OperandTree::Operand(self.operands.len() - 1)
    }

    fn read(&mut self, solid: &Solid, mut above: Above, depth: usize) -> Result<OperandTree> {
        if depth > DEEPEST {
            let what = format!("set operations on boundaries are nested more than {DEEPEST} deep");
            return Err(Error::input(Place::Unknown, what));
        }
        let mut solid = solid;
        loop {
            if !self.holds(solid) {
                return Ok(self.operand(Operand::Functions(above.put_on(solid.clone()))));
            }
            match solid.node() {
                SolidNode::Placed(p, s) => {
                    above.placement = above.placement.after(p);
                    solid = s;
                }
                SolidNode::Named(n, s) => {
                    above.name = Some(n.clone());
                    solid = s;
                }
                SolidNode::Sized(h, s) => {
                    above.size = Some(*h);
                    solid = s;
                }
                SolidNode::Not(s) => return Ok(OperandTree::Not(Box::new(self.read(s, above, depth + 1)?))),
                SolidNode::Primitive(Primitive::Foreign(f)) => {
                    let Above { placement, name, size } = above;
                    return Ok(self.operand(Operand::Foreign(BoundarySolid {
                        solid: f.clone(),
                        placement,
                        name,
                        size,
                    })));
                }
                SolidNode::And(_) | SolidNode::Or(_) => return self.chain(solid, &above, depth),
                SolidNode::Blend(..) => return Err(refuse_blend(solid)),
                SolidNode::Primitive(_) => return Err(Error::Failed("a function was taken for a boundary".into())),
            }
        }
    }

    /// A chain of one operation: all its R-functions are one operand.
    fn chain(&mut self, solid: &Solid, above: &Above, depth: usize) -> Result<OperandTree> {
        let and = matches!(solid.node(), SolidNode::And(_));
        let (mut functions, mut parts) = (Vec::new(), Vec::new());
        let mut stack = vec![solid];
        while let Some(s) = stack.pop() {
            match s.node() {
                _ if !self.holds(s) => functions.push(s.clone()),
                SolidNode::And(all) if and => stack.extend(all.iter().rev()),
                SolidNode::Or(all) if !and => stack.extend(all.iter().rev()),
                _ => parts.push(self.read(s, above.clone(), depth + 1)?),
            }
        }
        if !functions.is_empty() {
            let one = if and { Solid::intersection(functions) } else { Solid::union(functions) };
            parts.push(self.operand(Operand::Functions(above.put_on(one))));
        }
        Ok(if and { OperandTree::And(parts) } else { OperandTree::Or(parts) })
    }
}

/// The error for a blend with a solid given by its boundary.
fn refuse_blend(blend: &Solid) -> Error {
    let mut stack = vec![blend];
    while let Some(s) = stack.pop() {
        if let SolidNode::Primitive(Primitive::Foreign(f)) = s.node() {
            return f.refused("cannot be blended");
        }
        stack.extend(children(s.node()));
    }
    Error::Failed("a blend holds no boundary".into())
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::implicit::part::parse;

    fn tree(text: &str) -> Result<(OperandTree, Vec<Operand>)> {
        read(&parse(text, &[]).unwrap().solid.unwrap())
    }

    #[test]
    fn functions_of_a_chain_are_one_operand() {
        let (t, o) =
            tree("part(mesh('a.stl') - sphere(1) - sphere(2, at=(1, 0, 0)) - (step('b.step') | box(size=(1, 1, 1))))")
                .unwrap();
        assert_eq!(o.len(), 4);
        assert!(matches!(&o[3], Operand::Functions(_)));
        let OperandTree::And(parts) = &t else { panic!("{t:?}") };
        assert_eq!(parts.len(), 3);
        // In the mesh, outside of the others: all functions hold at once.
        assert!(t.holds(&[true, false, false, true]) && !t.holds(&[true, true, false, true]));
        assert!(!t.holds(&[true, false, false, false]));
    }

    #[test]
    fn an_operand_matters_where_what_it_is_joined_with_lets_it() {
        let at = |x: f64| Aabb::new(DVec3::new(x, 0.0, 0.0), DVec3::new(x + 1.0, 1.0, 1.0));
        let bounds = [at(0.0), at(10.0), Aabb::ALL];
        let [a, b, endless] = [0, 1, 2].map(OperandTree::Operand);
        let either = || OperandTree::Or(vec![a.clone(), b.clone()]);
        let without = OperandTree::Not(Box::new(endless.clone()));
        assert_eq!(OperandTree::And(vec![a.clone(), endless.clone()]).matters(2, &bounds), at(0.0));
        assert_eq!(OperandTree::And(vec![either(), without.clone()]).matters(2, &bounds), at(0.0).union(&at(10.0)));
        assert_eq!(
            OperandTree::Or(vec![OperandTree::And(vec![a.clone(), without]), b.clone()]).matters(2, &bounds),
            at(0.0)
        );
        assert_eq!(OperandTree::Or(vec![a.clone(), endless.clone()]).matters(2, &bounds), Aabb::ALL);
        // Outside of a union is in none of them.
        let none =
            OperandTree::Not(Box::new(OperandTree::Or(vec![OperandTree::Not(Box::new(b.clone())), endless.clone()])));
        assert_eq!(none.matters(2, &bounds), at(10.0));
        assert!(OperandTree::And(vec![a, b, endless]).matters(2, &bounds).is_empty());
    }

    #[test]
    fn blends_and_deep_trees_are_refused() {
        let e = tree("part(blend(mesh('a.stl'), sphere(1), 0.1))").unwrap_err().to_string();
        assert!(e.starts_with("line 1") && e.contains("cannot be blended"), "{e}");
        let deep = format!("def f(s): return sphere(1) - s\ns = mesh('a.stl')\n{}part(s)", "s = f(s)\n".repeat(500));
        assert!(tree(&deep).is_err());
    }
}
