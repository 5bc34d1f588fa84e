//! Whether fragments are node-matched on their model.

use std::fmt;

use super::fragment::print;
use super::pool::Fragments;
use super::topology::{Loop, Model};

/// Why fragments do not belong together. Loops and coedges are counted from 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[allow(missing_docs)]
pub enum Mismatch {
    /// Not one fragment per vertex, edge and face: how many of each the model has, and how many there are.
    Counts { model: [usize; 3], fragments: [usize; 3] },
    /// The edge's chain does not begin or end at the node of its vertex.
    EdgeEnd { edge: u32, vertex: u32 },
    /// The face has another number of loops, or of coedges in this loop, than its fragment.
    Loop { face: u32, index: u32 },
    /// The face has another number of segments along the edge than the edge has.
    Segments { face: u32, edge: u32, of_face: u32, of_edge: u32 },
    /// The nodes of face and edge are as many, but not at the same places.
    Nodes { face: u32, edge: u32 },
    /// The loop that is a vertex is not at the vertex's node.
    LoopVertex { face: u32, vertex: u32 },
}

impl fmt::Display for Mismatch {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Mismatch::Counts { model: [v, e, c], fragments: [a, b, d] } => write!(
                f,
                "the model has {v} vertices, {e} edges and {c} faces, but there are fragments for {a}, {b} and {d}"
            ),
            Mismatch::EdgeEnd { edge, vertex } => {
                write!(f, "edge {edge} does not begin and end at the nodes of its vertices (vertex {vertex})")
            }
            Mismatch::Loop { face, index } => {
                write!(f, "the fragment of face {face} has other coedges than the face in loop {index}")
            }
            Mismatch::Segments { face, edge, of_face, of_edge } => write!(
                f,
                "face {face} is not node-matched along edge {edge}: {of_face} segments of the face, {of_edge} of the edge"
            ),
            Mismatch::Nodes { face, edge } => {
                write!(f, "face {face} is not node-matched along edge {edge}: nodes are at different places")
            }
            Mismatch::LoopVertex { face, vertex } => {
                write!(f, "face {face} is not node-matched at vertex {vertex}: nodes are at different places")
            }
        }
    }
}

impl Fragments {
    /// Everything that keeps the fragments from being node-matched on the model, in the model's order.
    ///
    /// The model must have no [`Violation`](super::Violation) that [forbids merging](super::Violation::forbids_merge).
    /// The time is proportional to the model, whatever the number of nodes.
    pub fn mismatches<P, C, S>(&self, model: &Model<P, C, S>) -> Vec<Mismatch> {
        let counts = [model.vertices.len(), model.edges.len(), model.faces.len()];
        let there = self.counts();
        if counts != there {
            return vec![Mismatch::Counts { model: counts, fragments: there }];
        }
        let mut found = Vec::new();
        for e in 0..model.edges.len() as u32 {
            self.mismatch_of_edge(model, e, &mut found);
        }
        for f in 0..model.faces.len() as u32 {
            self.mismatch_of_face(model, f, &mut found);
        }
        found
    }

    /// [`mismatches`](Self::mismatches) of one edge with its vertices. There must be a fragment for each.
    pub fn mismatch_of_edge<P, C, S>(&self, model: &Model<P, C, S>, edge: u32, found: &mut Vec<Mismatch>) {
        for (v, p) in model.edges[edge as usize].ends.into_iter().zip(self.edge_ends(edge as usize)) {
            if self.vertices()[v as usize] != p {
                found.push(Mismatch::EdgeEnd { edge, vertex: v });
                return;
            }
        }
    }

    /// [`mismatches`](Self::mismatches) of one face with its edges. There must be a fragment for each.
    pub fn mismatch_of_face<P, C, S>(&self, model: &Model<P, C, S>, face: u32, found: &mut Vec<Mismatch>) {
        let fragment = self.face(face as usize);
        let loops = &model.faces[face as usize].loops;
        if loops.len() != fragment.loops.len() {
            let index = loops.len().min(fragment.loops.len()) as u32;
            found.push(Mismatch::Loop { face, index });
            return;
        }
        let mut first = 0;
        for (index, (border, end)) in loops.iter().zip(fragment.loops).enumerate() {
            let stretches = &fragment.stretches[first..*end as usize];
            first = *end as usize;
            match border {
                Loop::Vertex(v) => {
                    let p = &self.vertices()[*v as usize];
                    // a loop of one node is followed by itself
                    if stretches[0].print != print([p, p].into_iter()) || stretches.len() > 1 || stretches[0].nodes > 1
                    {
                        found.push(Mismatch::LoopVertex { face, vertex: *v });
                    }
                }
                Loop::Edges(list) if list.len() != stretches.len() => {
                    found.push(Mismatch::Loop { face, index: index as u32 });
                }
                Loop::Edges(list) => {
                    for (c, stretch) in list.iter().zip(stretches) {
                        let e = c.edge as usize;
                        let (of_face, of_edge) = (stretch.nodes, self.edge_span(e)[1] + 1);
                        if of_face != of_edge {
                            found.push(Mismatch::Segments { face, edge: c.edge, of_face, of_edge });
                        } else if stretch.print != self.prints(e)[usize::from(c.reversed)] {
                            found.push(Mismatch::Nodes { face, edge: c.edge });
                        }
                    }
                }
            }
        }
    }
}
