//! What is in a triangle soup: its faces, edges and vertices, and which are beside which.

use std::fmt;

use serde::Serialize;

use super::discrete::{SoupOptions, discrete_options, length, prepare};
use super::options::MeshOptions;
use crate::discrete::Discrete;
use crate::error::Result;
use crate::mesh::TriMesh;
use crate::model::Cut;
use crate::run::Run;

/// Edges a table lists: a screen or two.
const LISTED: usize = 60;

/// What was found in a soup.
#[derive(Debug, Clone, Serialize)]
pub struct SoupInfo {
    /// Triangles as read.
    pub triangles: usize,
    /// What healing did before anything else; nothing where the triangles were sound.
    pub healed: Vec<String>,
    /// Whether there is no open border.
    pub closed: bool,
    /// Smallest coordinates of the box around the triangles.
    pub lo: [f64; 3],
    /// Largest coordinates.
    pub hi: [f64; 3],
    /// Connected parts.
    pub shells: usize,
    /// Geometric vertices.
    pub vertices: usize,
    /// Geometric edges.
    pub edges: usize,
    /// The edges themselves, in the order in which loops count them.
    pub graph: Vec<EdgeInfo>,
    /// Geometric faces.
    pub faces: Vec<SoupFace>,
    /// Names of groups.
    pub groups: Vec<String>,
}

/// One face found in a soup.
#[derive(Debug, Clone, Serialize)]
pub struct SoupFace {
    /// Its name.
    pub name: String,
    /// Its area.
    pub area: f64,
    /// Triangles of the input on it.
    pub triangles: usize,
    /// Whether it is a plane to the precision of its nodes.
    pub plane: bool,
    /// Its neighbors in the relation graph, by name.
    pub neighbors: Vec<String>,
    /// Its borders: numbers of the edges each runs along, counted from 0; of a border that is a single vertex there are none.
    pub loops: Vec<Vec<u32>>,
}

/// One edge found in a soup.
#[derive(Debug, Clone, Serialize)]
pub struct EdgeInfo {
    /// The vertices it begins and ends at, counted from 0; the same one for a closed edge.
    pub ends: [u32; 2],
    /// Where these are.
    pub places: [[f64; 3]; 2],
    /// Its length.
    pub length: f64,
    /// The faces beside it, by name: one along an open border, one twice where a face meets itself.
    pub faces: Vec<String>,
}

/// The borders of a face as the edges they run along.
fn loops(all: &[Vec<u32>]) -> String {
    let one = |l: &Vec<u32>| if l.is_empty() { "a vertex".to_string() } else { format!("{l:?}") };
    match all {
        [] => "no border".into(),
        [l] => format!("loop {}", one(l)),
        _ => format!("loops {}", all.iter().map(one).collect::<Vec<_>>().join(" ")),
    }
}

/// Finds the model in a soup, as [`mesh_soup`](super::mesh_soup) does, and tells what it is made of.
///
/// Errors: those of [`mesh_soup`](super::mesh_soup).
pub fn soup_info(input: &TriMesh, options: &MeshOptions, soup: &SoupOptions, run: &Run) -> Result<SoupInfo> {
    let prepared = prepare(input, soup.close, run)?;
    let size = length(options.size, &prepared.mesh);
    let solid = Discrete::new(&prepared.at(size), &discrete_options(soup, size), run)?;
    let named = solid.named();
    let Cut { model, fragments, .. } = solid.model()?;
    let mut faces: Vec<SoupFace> = named
        .faces
        .iter()
        .enumerate()
        .map(|(f, name)| SoupFace {
            name: name.clone(),
            area: 0.0,
            triangles: 0,
            plane: crate::geometry::Pieces::plane(&solid, f as u32).is_some(),
            neighbors: Vec::new(),
            loops: Vec::new(),
        })
        .collect();
    for (t, l) in named.labels.iter().enumerate() {
        faces[*l as usize].triangles += 1;
        faces[*l as usize].area += 0.5 * named.area_vector(t).length();
    }
    for face in &model.faces {
        let loops = face.loops.iter().map(|l| l.coedges().iter().map(|c| c.edge).collect());
        faces[face.label as usize].loops.extend(loops);
    }
    let beside = model.faces_of_edges();
    for around in &beside {
        for f in around {
            for g in around.iter().filter(|g| *g != f) {
                let [a, b] = [f, g].map(|x| model.faces[*x as usize].label as usize);
                let name = named.faces[b].clone();
                if a != b && !faces[a].neighbors.contains(&name) {
                    faces[a].neighbors.push(name);
                }
            }
        }
    }
    let name = |f: &u32| named.faces[model.faces[*f as usize].label as usize].clone();
    let edge = |(e, around): (usize, &Vec<u32>)| EdgeInfo {
        ends: model.edges[e].ends,
        places: fragments.edge_ends(e).map(|p| p.to_array()),
        length: fragments.edge(e).nodes().windows(2).map(|w| w[0].distance(w[1])).sum(),
        faces: around.iter().map(name).collect(),
    };
    let graph = beside.iter().enumerate().map(edge).collect();
    let b = solid.bounds();
    Ok(SoupInfo {
        triangles: input.triangles.len(),
        healed: prepared.healed,
        closed: named.defects().is_closed(),
        lo: b.lo.to_array(),
        hi: b.hi.to_array(),
        shells: model.shells.len(),
        vertices: model.vertices.len(),
        edges: model.edges.len(),
        graph,
        faces,
        groups: named.groups.iter().map(|g| g.name.clone()).collect(),
    })
}

impl fmt::Display for SoupInfo {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let closed = if self.closed { "closed" } else { "open" };
        writeln!(f, "{} triangles, {closed}, {} shell(s)", self.triangles, self.shells)?;
        writeln!(f, "box from {:?} to {:?}", self.lo, self.hi)?;
        self.healed.iter().try_for_each(|h| writeln!(f, "{h}"))?;
        writeln!(f, "{} vertices, {} edges, {} faces:", self.vertices, self.edges, self.faces.len())?;
        for face in &self.faces {
            let plane = if face.plane { ", plane" } else { "" };
            let next = if face.neighbors.is_empty() { "nothing".into() } else { face.neighbors.join(", ") };
            write!(f, "  {}: area {:.6}, {} triangles{plane}; beside {next}; ", face.name, face.area, face.triangles)?;
            writeln!(f, "{}", loops(&face.loops))?;
        }
        for (e, edge) in self.graph.iter().take(LISTED).enumerate() {
            let [a, b] = edge.ends;
            let [p, q] = edge.places.map(|p| format!("({:.6}, {:.6}, {:.6})", p[0], p[1], p[2]));
            let way = if a == b { format!("closed at vertex {a} {p}") } else { format!("vertex {a} {p} to {b} {q}") };
            writeln!(f, "  edge {e}: {way}, length {:.6}; between {}", edge.length, edge.faces.join(" and "))?;
        }
        if self.graph.len() > LISTED {
            writeln!(f, "  and {} more edges: --json lists all", self.graph.len() - LISTED)?;
        }
        write!(f, "groups: {}", if self.groups.is_empty() { "none".into() } else { self.groups.join(", ") })
    }
}
