//! The rules of a boundary representation, and which of them a model breaks.

use std::fmt;

use super::topology::{Loop, Model};

/// A thing of the model, by index.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
#[allow(missing_docs)]
pub enum Item {
    Vertex(u32),
    Edge(u32),
    /// A loop of a face.
    Loop {
        face: u32,
        index: u32,
    },
    Face(u32),
    Shell(u32),
    Solid(u32),
    Name(u32),
    Group(u32),
}

/// How loops run along edges, forward and reversed: how many do, and the last one that did.
struct Runs {
    uses: Vec<[u32; 2]>,
    last: Vec<[u32; 2]>,
    /// Loops so far: the first one has the number 1.
    loops: u32,
}

impl fmt::Display for Item {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Item::Vertex(i) => write!(f, "vertex {i}"),
            Item::Edge(i) => write!(f, "edge {i}"),
            Item::Loop { face, index } => write!(f, "loop {index} of face {face}"),
            Item::Face(i) => write!(f, "face {i}"),
            Item::Shell(i) => write!(f, "shell {i}"),
            Item::Solid(i) => write!(f, "solid {i}"),
            Item::Name(i) => write!(f, "name {i}"),
            Item::Group(i) => write!(f, "group {i}"),
        }
    }
}

/// A broken rule, and where. `at` is the loop in question.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[allow(missing_docs)]
pub enum Violation {
    /// Something refers to a thing that does not exist.
    Missing { of: Item, what: Item },
    /// A loop without coedges. (A face without loops is a closed surface; that is allowed.)
    EmptyLoop { at: Item },
    /// A loop's coedge does not end where the next one begins.
    Gap { at: Item, coedge: u32 },
    /// A loop runs along an edge twice in the same direction. (Once in each direction is a seam.)
    EdgeRepeated { at: Item, edge: u32 },
    /// A closed edge that is no pole is not alone in its loop, and the loop has no seam.
    ClosedEdgeNotAlone { at: Item, edge: u32 },
    /// An edge without length that does not end where it begins, or that more than one loop runs along.
    Pole { edge: u32 },
    /// More than one loop runs along an edge in the same direction.
    EdgeOverused { edge: u32, forward: u32, reversed: u32 },
    /// A face that belongs to no shell, or to several.
    FaceInShells { face: u32, shells: u32 },
    /// A shell that belongs to several solids.
    ShellInSolids { shell: u32, solids: u32 },
    /// A solid's shell is open at this edge.
    OpenSolid { solid: u32, shell: u32, edge: u32 },
    /// A solid without shells.
    EmptySolid { solid: u32 },
}

impl Violation {
    /// Whether fragments on this model cannot be merged. The other rules concern what is done with the result.
    pub fn forbids_merge(&self) -> bool {
        use Violation::*;
        match self {
            Missing { of, .. } => matches!(of, Item::Edge(_) | Item::Loop { .. } | Item::Face(_) | Item::Group(_)),
            EmptyLoop { .. } | Gap { .. } | EdgeRepeated { .. } | ClosedEdgeNotAlone { .. } | Pole { .. } => true,
            EdgeOverused { .. } | FaceInShells { .. } | ShellInSolids { .. } | OpenSolid { .. } | EmptySolid { .. } => {
                false
            }
        }
    }
}

impl fmt::Display for Violation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        use Violation::*;
        match self {
            Missing { of, what } => write!(f, "{of} refers to {what}, which does not exist"),
            EmptyLoop { at } => write!(f, "{at} has no coedges"),
            Gap { at, coedge } => write!(f, "coedge {coedge} of {at} does not end where the next one begins"),
            EdgeRepeated { at, edge } => write!(f, "{at} runs along edge {edge} twice in the same direction"),
            ClosedEdgeNotAlone { at, edge } => write!(f, "edge {edge} is closed, but not alone in {at}"),
            Pole { edge } => write!(f, "edge {edge} is a pole, so it must be closed and on one loop only"),
            EdgeOverused { edge, forward, reversed } => {
                write!(f, "loops run along edge {edge} {forward} times forward and {reversed} times backward")
            }
            FaceInShells { face, shells } => write!(f, "face {face} belongs to {shells} shells, not to one"),
            ShellInSolids { shell, solids } => write!(f, "shell {shell} belongs to {solids} solids"),
            OpenSolid { solid, shell, edge } => write!(f, "shell {shell} of solid {solid} is open at edge {edge}"),
            EmptySolid { solid } => write!(f, "solid {solid} has no shell"),
        }
    }
}

impl<P, C, S> Model<P, C, S> {
    /// Every rule the model breaks, in the order edges, faces with their loops, uses of edges, shells, solids, groups.
    ///
    /// A rule that cannot be asked because something is missing is not reported on top of the missing thing. The time is
    /// proportional to the model.
    pub fn check(&self) -> Vec<Violation> {
        let mut found = Vec::new();
        self.check_edges(&mut found);
        let uses = self.check_faces(&mut found);
        self.check_uses(&uses, &mut found);
        self.check_shells(&mut found);
        self.check_groups(&mut found);
        found
    }

    fn check_edges(&self, found: &mut Vec<Violation>) {
        for (e, edge) in self.edges.iter().enumerate() {
            let e = e as u32;
            for v in edge.ends.into_iter().filter(|v| *v as usize >= self.vertices.len()) {
                found.push(Violation::Missing { of: Item::Edge(e), what: Item::Vertex(v) });
            }
            if edge.pole && !edge.is_closed() {
                found.push(Violation::Pole { edge: e });
            }
        }
    }

    /// Loops of faces; returns how many loops run along each edge forward and backward.
    fn check_faces(&self, found: &mut Vec<Violation>) -> Vec<[u32; 2]> {
        let mut runs = Runs { uses: vec![[0; 2]; self.edges.len()], last: vec![[0; 2]; self.edges.len()], loops: 0 };
        for (f, face) in self.faces.iter().enumerate() {
            if face.label as usize >= self.names.len() {
                found.push(Violation::Missing { of: Item::Face(f as u32), what: Item::Name(face.label) });
            }
            for (index, border) in face.loops.iter().enumerate() {
                runs.loops += 1;
                let at = Item::Loop { face: f as u32, index: index as u32 };
                match border {
                    Loop::Vertex(v) if *v as usize >= self.vertices.len() => {
                        found.push(Violation::Missing { of: at, what: Item::Vertex(*v) });
                    }
                    Loop::Vertex(_) => {}
                    Loop::Edges(list) => {
                        let mut known = true;
                        for c in list.iter().filter(|c| c.edge as usize >= self.edges.len()) {
                            found.push(Violation::Missing { of: at, what: Item::Edge(c.edge) });
                            known = false;
                        }
                        if known {
                            self.check_loop(at, list, &mut runs, found);
                        }
                    }
                }
            }
        }
        runs.uses
    }

    fn check_loop(&self, at: Item, list: &[super::Coedge], runs: &mut Runs, found: &mut Vec<Violation>) {
        let Runs { uses, last, loops } = runs;
        if list.is_empty() {
            found.push(Violation::EmptyLoop { at });
        }
        let mut seam = false;
        for (k, c) in list.iter().enumerate() {
            let next = list[(k + 1) % list.len()];
            if self.ends(*c) != self.begins(next) {
                found.push(Violation::Gap { at, coedge: k as u32 });
            }
            let (e, side) = (c.edge as usize, usize::from(c.reversed));
            if last[e][side] == *loops {
                found.push(Violation::EdgeRepeated { at, edge: c.edge });
            } else {
                uses[e][side] += 1;
            }
            last[e][side] = *loops;
            seam |= last[e][1 - side] == *loops;
        }
        if list.len() > 1 && !seam {
            let ring = |c: &&super::Coedge| {
                let edge = &self.edges[c.edge as usize];
                edge.is_closed() && !edge.pole
            };
            for c in list.iter().filter(ring) {
                found.push(Violation::ClosedEdgeNotAlone { at, edge: c.edge });
            }
        }
    }

    fn check_uses(&self, uses: &[[u32; 2]], found: &mut Vec<Violation>) {
        for (e, [forward, reversed]) in uses.iter().copied().enumerate() {
            let edge = e as u32;
            if forward > 1 || reversed > 1 {
                found.push(Violation::EdgeOverused { edge, forward, reversed });
            }
            if self.edges[e].pole && self.edges[e].is_closed() && forward + reversed > 1 {
                found.push(Violation::Pole { edge });
            }
        }
    }

    fn check_shells(&self, found: &mut Vec<Violation>) {
        let mut shells_of = vec![0u32; self.faces.len()];
        for (s, shell) in self.shells.iter().enumerate() {
            for f in &shell.faces {
                match shells_of.get_mut(*f as usize) {
                    Some(n) => *n += 1,
                    None => found.push(Violation::Missing { of: Item::Shell(s as u32), what: Item::Face(*f) }),
                }
            }
        }
        for (f, shells) in shells_of.into_iter().enumerate().filter(|(_, n)| *n != 1) {
            found.push(Violation::FaceInShells { face: f as u32, shells });
        }
        let mut solids_of = vec![0u32; self.shells.len()];
        for (s, solid) in self.solids.iter().enumerate() {
            if solid.shells.is_empty() {
                found.push(Violation::EmptySolid { solid: s as u32 });
            }
            for shell in &solid.shells {
                match solids_of.get_mut(*shell as usize) {
                    Some(n) => {
                        *n += 1;
                        for edge in self.open_edges(*shell) {
                            found.push(Violation::OpenSolid { solid: s as u32, shell: *shell, edge });
                        }
                    }
                    None => found.push(Violation::Missing { of: Item::Solid(s as u32), what: Item::Shell(*shell) }),
                }
            }
        }
        for (s, solids) in solids_of.into_iter().enumerate().filter(|(_, n)| *n > 1) {
            found.push(Violation::ShellInSolids { shell: s as u32, solids });
        }
    }

    /// Edges of a shell that its faces do not run along once in each direction, ascending; poles are never open.
    ///
    /// The shell must exist; faces and edges that do not are passed over.
    pub fn open_edges(&self, shell: u32) -> Vec<u32> {
        let mut uses = Vec::new();
        for face in self.shells[shell as usize].faces.iter().filter_map(|f| self.faces.get(*f as usize)) {
            uses.extend(face.loops.iter().flat_map(Loop::coedges).map(|c| (c.edge, c.reversed)));
        }
        uses.sort_unstable();
        let whole = |uses: &[(u32, bool)]| matches!(uses, [(_, false), (_, true)]);
        let pole = |e: u32| self.edges.get(e as usize).is_none_or(|e| e.pole);
        uses.chunk_by(|a, b| a.0 == b.0).filter(|u| !whole(u) && !pole(u[0].0)).map(|u| u[0].0).collect()
    }

    fn check_groups(&self, found: &mut Vec<Violation>) {
        for (g, group) in self.groups.iter().enumerate() {
            for name in group.faces.iter().filter(|n| **n as usize >= self.names.len()) {
                found.push(Violation::Missing { of: Item::Group(g as u32), what: Item::Name(*name) });
            }
        }
    }
}
