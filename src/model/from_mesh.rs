//! From a triangle mesh with known borders to a model and its fragments.
//!
//! Borders cut the mesh apart. What hangs together around a node after the cut is a *sector* of it: a whole disk for an
//! inner node, one per side for a node on a border. Each sector becomes a node of its own in the fragment of its face, so
//! a border both sides of which are the same face (a seam, a slit) needs no special care, and neither does a mesh that is
//! not a manifold: wherever more or fewer than two triangles meet, there is a border.

use crate::error::{Error, Place, Result};
use crate::mesh::TriMesh;
use crate::mesh::sides::sides;
use crate::numeric::NONE;

use super::cells::{BorderNodes, Cells};
use super::fragment::{EdgeFragment, FaceFragment};
use super::pool::Fragments;
use super::topology::{Coedge, Edge, Face, Loop, Model, Shell, Vertex};

/// What [`from_mesh`] makes of a mesh.
#[derive(Debug, Clone, PartialEq)]
pub struct Cut {
    /// Topology, names and groups. It has no solids: the mesh does not tell which shell is inside which.
    pub model: Model,
    /// The nodes and triangles.
    pub fragments: Fragments,
    /// For every node of the merged mesh, the number it has in the mesh that was cut.
    pub nodes: Vec<u32>,
    /// For every triangle of the merged mesh, the number it has in the mesh that was cut.
    pub triangles: Vec<u32>,
}

/// Cuts a mesh into fragments along its borders.
///
/// Borders are: edges between triangles with different labels, edges that do not have exactly two triangles running
/// through them in opposite directions, and the mesh edges in `borders` (pairs of nodes in either order; pairs that are no
/// edge of the mesh are passed over). Vertices are: nodes where other than two border edges meet, nodes at which more
/// than two sides of borders meet, and the nodes in `corners`. A closed border without any of these gets a vertex at its
/// node of least number.
///
/// Faces are the parts that remain connected over edges, in the order of their first triangles, each with the label of its
/// triangles; [`Model::names`] and groups are those of the mesh. Shells are faces connected over edges. Fragments have
/// their border nodes first, and keep the order of the mesh's triangles.
///
/// # Errors
/// [`Error::Input`] for a mesh that is not [valid](TriMesh::validate), and for a triangle that names a node twice.
pub fn from_mesh(mesh: &TriMesh, borders: &[[u32; 2]], corners: &[u32]) -> Result<Cut> {
    mesh.validate()?;
    if 3 * mesh.triangles.len() >= NONE as usize {
        return Err(Error::input(Place::Unknown, format!("{} triangles are too many", mesh.triangles.len())));
    }
    if let Some(t) = mesh.triangles.iter().position(|[a, b, c]| a == b || b == c || c == a) {
        return Err(Error::input(Place::Item(format!("triangle {t}")), "it names a node twice"));
    }
    let mut cutter = FragmentCutter::new(mesh, borders);
    cutter.find_sectors();
    cutter.find_vertices(corners);
    cutter.find_chains();
    cutter.find_faces();
    let loops = cutter.find_loops();
    cutter.assemble(loops)
}

/// Sides are numbered `3 t + k`: side `k` of triangle `t` runs from its corner `k` to the next. The corner has that number
/// too.
struct FragmentCutter<'a> {
    mesh: &'a TriMesh,
    /// For each side the side of the neighbor across it; [`NONE`] where there is a border.
    twin: Vec<u32>,
    /// Border edges, ascending, and how they are found from a border side.
    rims: Vec<[u32; 2]>,
    rim_of: Vec<u32>,
    /// For each corner its sector; for each sector the border side it begins with ([`NONE`] if it is a whole disk).
    sector: Vec<u32>,
    opens: Vec<u32>,
    /// For each node its vertex, or [`NONE`].
    vertex_of: Vec<u32>,
    vertices: Vec<u32>,
    /// Chains of nodes between vertices; for each border edge its chain and whether it runs along it in ascending order.
    chains: Vec<Vec<u32>>,
    chain_of: Vec<(u32, bool)>,
    /// For each triangle its face; for each face its triangles.
    face_of: Vec<u32>,
    faces: Vec<Vec<u32>>,
}

/// A loop as border sides, first at a vertex, or a single vertex.
enum BorderLoop {
    Sides(Vec<u32>),
    /// The vertex, and a corner at it.
    Vertex(u32, u32),
}

fn next(side: u32) -> u32 {
    side - side % 3 + (side + 1) % 3
}

fn before(side: u32) -> u32 {
    side - side % 3 + (side + 2) % 3
}

fn key(a: u32, b: u32) -> [u32; 2] {
    [a.min(b), a.max(b)]
}

impl<'a> FragmentCutter<'a> {
    fn new(mesh: &'a TriMesh, borders: &[[u32; 2]]) -> Self {
        let mut marked: Vec<[u32; 2]> = borders.iter().map(|[a, b]| key(*a, *b)).collect();
        marked.sort_unstable();
        let n = 3 * mesh.triangles.len() as u32;
        let sides = sides(mesh);
        let mut twin = vec![NONE; n as usize];
        let mut rim_of = vec![NONE; n as usize];
        let mut rims = Vec::new();
        for group in sides.chunk_by(|a, b| a.key == b.key) {
            if let [a, b] = group
                && a.forward != b.forward
                && mesh.labels[a.triangle() as usize] == mesh.labels[b.triangle() as usize]
                && marked.binary_search(&a.edge()).is_err()
            {
                (twin[a.number as usize], twin[b.number as usize]) = (b.number, a.number);
                continue;
            }
            for s in group {
                rim_of[s.number as usize] = rims.len() as u32;
            }
            rims.push(group[0].edge());
        }
        Self {
            mesh,
            twin,
            rims,
            rim_of,
            sector: vec![NONE; n as usize],
            opens: Vec::new(),
            vertex_of: vec![NONE; mesh.nodes.len()],
            vertices: Vec::new(),
            chains: Vec::new(),
            chain_of: Vec::new(),
            face_of: vec![NONE; mesh.triangles.len()],
            faces: Vec::new(),
        }
    }

    fn from(&self, side: u32) -> u32 {
        self.mesh.triangles[side as usize / 3][side as usize % 3]
    }

    fn find_sectors(&mut self) {
        for corner in 0..self.twin.len() as u32 {
            if self.sector[corner as usize] != NONE {
                continue;
            }
            // clockwise to where the sector begins, or once around
            let mut first = corner;
            while self.twin[first as usize] != NONE {
                first = next(self.twin[first as usize]);
                if first == corner {
                    break;
                }
            }
            let number = self.opens.len() as u32;
            self.opens.push(if self.twin[first as usize] == NONE { first } else { NONE });
            let mut c = first;
            while c != NONE && self.sector[c as usize] == NONE {
                self.sector[c as usize] = number;
                c = self.twin[before(c) as usize];
            }
        }
    }

    /// A node stays within a chain or a face only if nothing about it is special; see [`from_mesh`].
    fn find_vertices(&mut self, corners: &[u32]) {
        let n = self.mesh.nodes.len();
        let mut edges = vec![0u32; n];
        for v in self.rims.iter().flatten() {
            edges[*v as usize] += 1;
        }
        let mut special = vec![false; n];
        for v in corners {
            if let Some(s) = special.get_mut(*v as usize) {
                *s = true;
            }
        }
        let mut sectors = vec![0u32; n];
        let mut closing = vec![NONE; self.opens.len()];
        for s in 0..self.twin.len() as u32 {
            if self.twin[before(s) as usize] == NONE {
                closing[self.sector[s as usize] as usize] = before(s);
            }
        }
        let mut seen = vec![false; self.opens.len()];
        for c in 0..self.twin.len() as u32 {
            let sector = self.sector[c as usize] as usize;
            if std::mem::replace(&mut seen[sector], true) {
                continue;
            }
            let v = self.from(c) as usize;
            sectors[v] += 1;
            if self.opens[sector] == NONE {
                special[v] |= edges[v] > 0 || sectors[v] > 1;
            } else {
                let [a, b] = [self.opens[sector], closing[sector]].map(|s| self.rim_of[s as usize]);
                special[v] |= edges[v] != 2 || a == b;
            }
        }
        for v in 0..n as u32 {
            if special[v as usize] && sectors[v as usize] > 0 {
                self.vertex_of[v as usize] = self.vertices.len() as u32;
                self.vertices.push(v);
            }
        }
    }

    fn find_chains(&mut self) {
        let mut at: Vec<[u32; 2]> = Vec::with_capacity(2 * self.rims.len());
        for (r, [a, b]) in self.rims.iter().enumerate() {
            at.extend([[*a, r as u32], [*b, r as u32]]);
        }
        at.sort_unstable();
        let around = |v: u32| {
            let begin = at.partition_point(|x| x[0] < v);
            at[begin..].iter().take_while(move |x| x[0] == v).map(|x| x[1])
        };
        self.chain_of = vec![(NONE, false); self.rims.len()];
        let (mut k, mut whole) = (0, 0);
        let mut starts = self.vertices.clone();
        loop {
            while let Some(&start) = starts.get(k) {
                for rim in around(start) {
                    if self.chain_of[rim as usize].0 == NONE {
                        self.trace(start, rim, &around);
                    }
                }
                k += 1;
            }
            // What is left has no vertex: closed borders, each with its least node first in order.
            let Some(r) = self.chain_of[whole..].iter().position(|c| c.0 == NONE) else { break };
            whole += r;
            let v = self.rims[whole][0];
            self.vertex_of[v as usize] = self.vertices.len() as u32;
            self.vertices.push(v);
            starts.push(v);
        }
    }

    fn trace<I: Iterator<Item = u32>>(&mut self, start: u32, rim: u32, around: &impl Fn(u32) -> I) {
        let number = self.chains.len() as u32;
        let (mut chain, mut rim) = (vec![start], rim);
        loop {
            let here = chain[chain.len() - 1];
            let [a, b] = self.rims[rim as usize];
            self.chain_of[rim as usize] = (number, here == a);
            let there = if here == a { b } else { a };
            chain.push(there);
            if self.vertex_of[there as usize] != NONE {
                break;
            }
            match around(there).find(|r| self.chain_of[*r as usize].0 == NONE) {
                Some(on) => rim = on,
                None => break,
            }
        }
        self.chains.push(chain);
    }

    fn find_faces(&mut self) {
        let mut stack = Vec::new();
        for t in 0..self.face_of.len() as u32 {
            if self.face_of[t as usize] != NONE {
                continue;
            }
            let face = self.faces.len() as u32;
            let mut list = Vec::new();
            self.face_of[t as usize] = face;
            stack.push(t);
            while let Some(t) = stack.pop() {
                list.push(t);
                for side in 3 * t..3 * t + 3 {
                    let other = self.twin[side as usize] / 3;
                    if self.twin[side as usize] != NONE && self.face_of[other as usize] == NONE {
                        self.face_of[other as usize] = face;
                        stack.push(other);
                    }
                }
            }
            list.sort_unstable();
            self.faces.push(list);
        }
    }

    /// The loops of each face. A closed chain that is not alone in its loop gets a second vertex, so none is.
    fn find_loops(&mut self) -> Vec<Vec<BorderLoop>> {
        let mut loops: Vec<Vec<BorderLoop>> = self.faces.iter().map(|_| Vec::new()).collect();
        let mut done = vec![false; self.twin.len()];
        let mut apart = vec![false; self.chains.len()];
        for corner in 0..self.twin.len() as u32 {
            let vertex = self.vertex_of[self.from(corner) as usize];
            let (face, sector) = (self.face_of[corner as usize / 3], self.sector[corner as usize]);
            if vertex == NONE || done[corner as usize] {
                continue;
            }
            if self.opens[sector as usize] == NONE {
                let mut c = corner;
                while !std::mem::replace(&mut done[c as usize], true) {
                    c = self.twin[before(c) as usize];
                }
                loops[face as usize].push(BorderLoop::Vertex(vertex, corner));
                continue;
            }
            if self.twin[corner as usize] != NONE {
                continue;
            }
            let mut sides = Vec::new();
            let mut side = corner;
            while !std::mem::replace(&mut done[side as usize], true) {
                sides.push(side);
                side = self.opens[self.sector[next(side) as usize] as usize];
            }
            let chain = |s: u32| self.chain_of[self.rim_of[s as usize] as usize].0 as usize;
            let starts = sides.iter().filter(|s| self.vertex_of[self.from(**s) as usize] != NONE).count();
            if starts > 1 {
                for s in &sides {
                    let list = &self.chains[chain(*s)];
                    apart[chain(*s)] |= list[0] == list[list.len() - 1];
                }
            }
            loops[face as usize].push(BorderLoop::Sides(sides));
        }
        for c in (0..apart.len()).filter(|c| apart[*c]) {
            self.split(c);
        }
        loops
    }

    /// Gives chain `c` a vertex at its middle node; what follows it becomes a chain of its own.
    fn split(&mut self, c: usize) {
        let middle = self.chains[c].len() / 2;
        let rest = self.chains[c].split_off(middle);
        let v = rest[0];
        self.chains[c].push(v);
        if self.vertex_of[v as usize] == NONE {
            self.vertex_of[v as usize] = self.vertices.len() as u32;
            self.vertices.push(v);
        }
        for pair in rest.windows(2) {
            if let Ok(r) = self.rims.binary_search(&key(pair[0], pair[1])) {
                self.chain_of[r].0 = self.chains.len() as u32;
            }
        }
        self.chains.push(rest);
    }

    fn assemble(self, loops: Vec<Vec<BorderLoop>>) -> Result<Cut> {
        let mesh = self.mesh;
        let point = |v: u32| mesh.nodes[v as usize];
        let mut model = Model { names: mesh.faces.clone(), groups: mesh.groups.clone(), ..Model::default() };
        model.vertices = vec![Vertex::default(); self.vertices.len()];
        let mut fragments = Fragments::new(self.vertices.iter().map(|v| point(*v)).collect());
        let mut nodes = self.vertices.clone();
        for chain in &self.chains {
            let ends = [chain[0], chain[chain.len() - 1]].map(|v| self.vertex_of[v as usize]);
            model.edges.push(Edge { ends, ..Edge::default() });
            fragments.push_edge(&EdgeFragment::new(chain.iter().map(|v| point(*v)).collect())?)?;
            nodes.extend(&chain[1..chain.len() - 1]);
        }
        let mut local = vec![NONE; self.opens.len()];
        for (f, borders) in loops.into_iter().enumerate() {
            let mut own: Vec<u32> = Vec::new();
            let mut face = Face { label: mesh.labels[self.faces[f][0] as usize], ..Face::default() };
            let mut segments: Vec<Vec<u32>> = Vec::new();
            for border in borders {
                let corners = match border {
                    BorderLoop::Sides(sides) => {
                        let (coedges, counts) = self.coedges(&sides);
                        face.loops.push(Loop::Edges(coedges));
                        segments.push(counts);
                        sides
                    }
                    BorderLoop::Vertex(v, corner) => {
                        face.loops.push(Loop::Vertex(v));
                        segments.push(Vec::new());
                        vec![corner]
                    }
                };
                for c in corners {
                    local[self.sector[c as usize] as usize] = own.len() as u32;
                    own.push(self.from(c));
                }
            }
            let border = own.len();
            let mut triangles = Vec::with_capacity(self.faces[f].len());
            for t in &self.faces[f] {
                triangles.push([0, 1, 2].map(|k| {
                    let slot = &mut local[self.sector[(3 * t + k) as usize] as usize];
                    if *slot == NONE {
                        *slot = own.len() as u32;
                        own.push(self.from(3 * t + k));
                    }
                    *slot
                }));
            }
            nodes.extend(&own[border..]);
            let points = own.iter().map(|v| point(*v)).collect();
            let boundary = BorderNodes::First(border as u32);
            fragments.push_face(&FaceFragment::new(points, Cells::Triangles(&triangles), &boundary, &segments)?)?;
            model.faces.push(face);
        }
        model.shells = shells(&model);
        Ok(Cut { model, fragments, nodes, triangles: self.faces.into_iter().flatten().collect() })
    }

    /// Border sides, the first from a vertex, as coedges with the number of sides of each.
    fn coedges(&self, sides: &[u32]) -> (Vec<Coedge>, Vec<u32>) {
        let (mut coedges, mut counts) = (Vec::new(), Vec::new());
        for s in sides {
            let rim = self.rim_of[*s as usize] as usize;
            if self.vertex_of[self.from(*s) as usize] != NONE || counts.is_empty() {
                let (edge, ascending) = self.chain_of[rim];
                let along = (self.from(*s) == self.rims[rim][0]) == ascending;
                coedges.push(Coedge { edge, reversed: !along });
                counts.push(0);
            }
            if let Some(n) = counts.last_mut() {
                *n += 1;
            }
        }
        (coedges, counts)
    }
}

/// Faces connected over edges, in the order of their first faces.
fn shells(model: &Model) -> Vec<Shell> {
    let faces_of = model.faces_of_edges();
    let mut done = vec![false; model.faces.len()];
    let mut shells = Vec::new();
    for f in 0..model.faces.len() as u32 {
        let (mut faces, mut stack) = (Vec::new(), vec![f]);
        while let Some(f) = stack.pop() {
            if !std::mem::replace(&mut done[f as usize], true) {
                faces.push(f);
                let coedges = model.faces[f as usize].loops.iter().flat_map(Loop::coedges);
                stack.extend(coedges.flat_map(|c| &faces_of[c.edge as usize]));
            }
        }
        if !faces.is_empty() {
            faces.sort_unstable();
            shells.push(Shell { faces });
        }
    }
    shells
}
