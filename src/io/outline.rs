//! The borders of a plane figure: closed polylines along the open edges of a flat mesh, each edge with its name.

use std::collections::BTreeMap;

use super::inp::LONGEST_NAME;
use super::regions::{Grouping, clean};

/// A closed polyline.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct ClosedLine {
    /// Its nodes, each once, with the figure on the left: outer borders run counter-clockwise, those of holes clockwise.
    pub nodes: Vec<u32>,
    /// For each node the border that the edge from it to the next one is of: an index into [`Outline::names`].
    pub borders: Vec<u32>,
}

/// The borders of a plane figure.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Outline {
    /// Names of borders.
    pub names: Vec<String>,
    /// For each border the names of the groups that hold it.
    pub groups: Vec<Vec<String>>,
    /// The polylines.
    pub contours: Vec<ClosedLine>,
    /// The unit of length.
    pub units: Option<String>,
}

/// Edges of one name in a file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct BorderSet {
    pub(super) name: String,
    pub(super) edges: Vec<[u32; 2]>,
}

impl ClosedLine {
    /// Its edges, with the border of each.
    pub fn edges(&self) -> impl Iterator<Item = ([u32; 2], u32)> + '_ {
        let next = self.nodes.iter().cycle().skip(1);
        self.nodes.iter().zip(next).zip(&self.borders).map(|((a, b), border)| ([*a, *b], *border))
    }
}

impl Outline {
    /// What a border is called in a file.
    pub(super) fn name(&self, border: u32, grouping: Grouping) -> String {
        match self.groups.get(border as usize) {
            Some(groups) if grouping == Grouping::User && !groups.is_empty() => groups.join("+"),
            _ => self.names[border as usize].clone(),
        }
    }

    /// Edges by name, in the order of the borders. Every edge is in one set.
    pub(super) fn sets(&self, grouping: Grouping) -> Vec<BorderSet> {
        let mut sets: Vec<BorderSet> = Vec::new();
        let mut of_name: BTreeMap<String, usize> = BTreeMap::new();
        let mut of_border = Vec::with_capacity(self.names.len());
        for border in 0..self.names.len() as u32 {
            let name = self.name(border, grouping);
            of_border.push(*of_name.entry(name.clone()).or_insert_with(|| {
                sets.push(BorderSet { name, edges: Vec::new() });
                sets.len() - 1
            }));
        }
        for (edge, border) in self.contours.iter().flat_map(ClosedLine::edges) {
            sets[of_border[border as usize]].edges.push(edge);
        }
        sets.retain(|set| !set.edges.is_empty());
        sets
    }

    /// The same with names of letters, digits and `_`.
    pub(super) fn clean_sets(&self, grouping: Grouping) -> Vec<BorderSet> {
        let mut sets = self.sets(grouping);
        let names = clean(sets.iter().map(|set| &set.name[..]), LONGEST_NAME).names;
        sets.iter_mut().zip(names).for_each(|(set, name)| set.name = name);
        sets
    }
}
