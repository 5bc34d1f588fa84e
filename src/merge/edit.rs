//! Faces that come and go while a mesh is being made: the merged mesh is numbered anew from its fragments, whatever they hold.
//!
//! *Source.* \[LAZ\], which has fragments of a composite mesh edited one by one; how faces are added and removed is not described
//! there.

use glam::DVec3;

use crate::error::{Error, Place as Where, Result};
use crate::model::{Edge, EdgeFragment, Face, FaceFragment, Loop, Model, Shell, Vertex};

use super::view::{Merged, refuse, refuse_model};

/// Faces to be added, with the edges, vertices and names they bring along.
///
/// What is new is numbered on from what is there: where a model has four vertices, the first new one is vertex 4.
#[derive(Debug, Clone, PartialEq)]
pub struct Addition<P = (), C = (), S = ()> {
    /// Names for [`Face::label`].
    pub names: Vec<String>,
    /// Vertices, each with its node.
    pub vertices: Vec<(Vertex<P>, DVec3)>,
    /// Edges, each with its chain.
    pub edges: Vec<(Edge<C>, EdgeFragment)>,
    /// Faces, each with its mesh.
    pub faces: Vec<(Face<S>, FaceFragment)>,
}

impl<P, C, S> Default for Addition<P, C, S> {
    fn default() -> Self {
        Self { names: Vec::new(), vertices: Vec::new(), edges: Vec::new(), faces: Vec::new() }
    }
}

/// A face that was taken away.
#[derive(Debug, Clone, PartialEq)]
pub struct Detached<S = ()> {
    /// Its place in the topology.
    pub face: Face<S>,
    /// Its mesh.
    pub fragment: FaceFragment,
}

impl<P, C, S> Merged<P, C, S> {
    /// Adds faces after those there are, with what they bring along.
    ///
    /// The cost is that of the new fragments, and of a few additions and comparisons per fragment that is there. A new face joins the shell
    /// of the first face it shares an edge with, or makes one of its own.
    ///
    /// # Errors
    /// As [`new`](Self::new), about what is added; then nothing has changed.
    pub fn insert(&mut self, what: Addition<P, C, S>) -> Result<()> {
        let (names, counts) = (self.model.names.len(), self.fragments.counts());
        match self.add(what).and_then(|()| self.renumber()) {
            Ok(()) => {
                join_shells(&mut self.model, counts[2]);
                Ok(())
            }
            Err(error) => {
                let [vertices, edges, faces] = counts;
                self.model.names.truncate(names);
                self.model.vertices.truncate(vertices);
                self.model.edges.truncate(edges);
                self.model.faces.truncate(faces);
                while self.fragments.counts()[2] > faces {
                    self.fragments.pop_face();
                }
                self.fragments.keep(&vec![true; vertices], &vec![true; edges]);
                // as it was, so it can be numbered
                let _ = self.renumber();
                Err(error)
            }
        }
    }

    /// Puts everything in its place, unless it does not fit there.
    fn add(&mut self, what: Addition<P, C, S>) -> Result<()> {
        let [_, edges, faces] = self.fragments.counts();
        self.model.names.extend(what.names);
        let (vertices, nodes): (Vec<_>, Vec<_>) = what.vertices.into_iter().unzip();
        let (curves, chains): (Vec<_>, Vec<_>) = what.edges.into_iter().unzip();
        let (parts, meshes): (Vec<_>, Vec<_>) = what.faces.into_iter().unzip();
        self.model.vertices.extend(vertices);
        self.model.edges.extend(curves);
        self.model.faces.extend(parts);
        if let Some(broken) = self.model.check().iter().find(|v| v.forbids_merge()) {
            return Err(refuse_model(broken));
        }
        self.fragments.push_vertices(&nodes)?;
        chains.iter().try_for_each(|chain| self.fragments.push_edge(chain))?;
        meshes.iter().try_for_each(|mesh| self.fragments.push_face(mesh))?;
        let mut found = Vec::new();
        for e in edges..self.model.edges.len() {
            self.fragments.mismatch_of_edge(&self.model, e as u32, &mut found);
        }
        for f in faces..self.model.faces.len() {
            self.fragments.mismatch_of_face(&self.model, f as u32, &mut found);
        }
        found.first().map_or(Ok(()), |mismatch| Err(refuse(mismatch)))
    }

    /// Takes a face away; those after it move up by one. Its name, edges and vertices stay, for another face to take its place:
    /// [`drop_unused`](Self::drop_unused) takes away edges and vertices that nobody needs.
    ///
    /// The cost is that of copying the fragment, and of a few additions per fragment.
    ///
    /// # Errors
    /// [`Error::Input`] for a face that does not exist; then nothing has changed.
    pub fn remove(&mut self, face: u32) -> Result<Detached<S>> {
        let f = face as usize;
        if f >= self.model.faces.len() {
            return Err(Error::input(Where::Item(format!("face {face}")), "there is none to remove"));
        }
        let fragment = self.fragments.remove_face(f);
        let removed = Detached { face: self.model.faces.remove(f), fragment };
        for shell in &mut self.model.shells {
            shell.faces.retain(|x| *x != face);
            shell.faces.iter_mut().filter(|x| **x > face).for_each(|x| *x -= 1);
        }
        self.renumber()?;
        Ok(removed)
    }

    /// Takes away the edges no face runs along, and the vertices neither an edge nor a loop has. Those after them move up.
    /// Returns how many went.
    ///
    /// The cost is that of a few additions per fragment.
    ///
    /// # Errors
    /// [`Error::Failed`] where what is left cannot be numbered, which what was there could.
    pub fn drop_unused(&mut self) -> Result<usize> {
        let model = &mut self.model;
        let (mut vertices, mut edges) = (vec![false; model.vertices.len()], vec![false; model.edges.len()]);
        for border in model.faces.iter().flat_map(|f| &f.loops) {
            if let Loop::Vertex(v) = border {
                vertices[*v as usize] = true;
            }
            border.coedges().iter().for_each(|c| edges[c.edge as usize] = true);
        }
        let used = model.edges.iter().zip(&edges).filter(|x| *x.1).flat_map(|x| x.0.ends);
        used.for_each(|v| vertices[v as usize] = true);
        let (new_vertex, new_edge) = (numbers(&vertices), numbers(&edges));
        retain(&mut model.vertices, &vertices);
        retain(&mut model.edges, &edges);
        model.edges.iter_mut().for_each(|e| e.ends = e.ends.map(|v| new_vertex[v as usize]));
        for border in model.faces.iter_mut().flat_map(|f| &mut f.loops) {
            match border {
                Loop::Vertex(v) => *v = new_vertex[*v as usize],
                Loop::Edges(list) => list.iter_mut().for_each(|c| c.edge = new_edge[c.edge as usize]),
            }
        }
        self.fragments.keep(&vertices, &edges);
        self.renumber()?;
        Ok(vertices.iter().chain(&edges).filter(|used| !**used).count())
    }
}

/// The number each has among those that are marked.
fn numbers(marks: &[bool]) -> Vec<u32> {
    let mut next = 0;
    let number = |marked: &bool| {
        let own = next;
        next += u32::from(*marked);
        own
    };
    marks.iter().map(number).collect()
}

fn retain<T>(list: &mut Vec<T>, marks: &[bool]) {
    let mut marks = marks.iter();
    list.retain(|_| marks.next().is_some_and(|m| *m));
}

/// Puts the faces from one on into shells.
fn join_shells<P, C, S>(model: &mut Model<P, C, S>, first: usize) {
    let of_edges = model.faces_of_edges();
    let mut shell_of: Vec<Option<usize>> = vec![None; model.faces.len()];
    for (s, shell) in model.shells.iter().enumerate() {
        for f in &shell.faces {
            if let Some(slot) = shell_of.get_mut(*f as usize) {
                slot.get_or_insert(s);
            }
        }
    }
    for f in first..model.faces.len() {
        let beside = model.faces[f].loops.iter().flat_map(Loop::coedges).flat_map(|c| &of_edges[c.edge as usize]);
        let known = beside.filter(|x| shell_of[**x as usize].is_some()).min();
        let shell = known.and_then(|x| shell_of[*x as usize]).unwrap_or_else(|| {
            model.shells.push(Shell::default());
            model.shells.len() - 1
        });
        shell_of[f] = Some(shell);
        model.shells[shell].faces.push(f as u32);
    }
}
