//! A mesh that comes in portions: each fits into memory, and the whole need not.

use glam::DVec3;
use rustc_hash::{FxHashMap, FxHashSet};

use super::intersect::intersections_among;
use super::sides::sides;
use super::trimesh::TriMesh;
use crate::error::Result;
use crate::numeric::Sets;
use crate::run::Run;
use crate::spatial::Aabb;

/// Some triangles of a larger mesh, with node numbers of their own. All triangles at a node that is not shared are among them.
#[derive(Debug, Clone, Default)]
pub(crate) struct Portion {
    /// The triangles; every node is used.
    pub(crate) mesh: TriMesh,
    /// For each node its number in the larger mesh.
    pub(crate) nodes: Vec<u32>,
    /// For each node whether triangles of other portions may use it.
    pub(crate) shared: Vec<bool>,
    /// The first triangle's number in the larger mesh; the others follow.
    pub(crate) first: u32,
}

impl Portion {
    /// An edge by the numbers of the larger mesh, the smaller first.
    pub(crate) fn named(&self, edge: [u32; 2]) -> [u32; 2] {
        let [a, b] = edge.map(|v| self.nodes[v as usize]);
        [a.min(b), a.max(b)]
    }

    /// Whether other portions may have triangles at an edge.
    pub(crate) fn is_shared(&self, edge: [u32; 2]) -> bool {
        edge.iter().all(|v| self.shared[*v as usize])
    }

    fn placed(&self, edge: [u32; 2]) -> PlacedEdge {
        let nodes = self.named(edge);
        let [a, b] = edge.map(|v| self.mesh.nodes[v as usize]);
        PlacedEdge { nodes, ends: if nodes[0] == self.nodes[edge[0] as usize] { [a, b] } else { [b, a] } }
    }

    /// Sharp edges, by the numbers of the larger mesh, that are shared or that are not.
    pub(crate) fn sharp_edges(&self, angle: f64, shared: bool) -> FxHashSet<[u32; 2]> {
        let all = self.mesh.sharp_edges(angle).into_iter();
        all.filter(|e| self.is_shared(*e) == shared).map(|e| self.named(e)).collect()
    }
}

/// An edge of the larger mesh, the smaller node first, and where its ends are.
#[derive(Debug, Clone, Copy)]
pub(crate) struct PlacedEdge {
    pub(crate) nodes: [u32; 2],
    pub(crate) ends: [DVec3; 2],
}

impl PlacedEdge {
    pub(crate) fn middle(&self) -> DVec3 {
        0.5 * (self.ends[0] + self.ends[1])
    }
}

/// What is known of the whole of some portions: what [`Defects`](super::Defects) and [`Topology`](super::Topology) tell of a mesh.
#[derive(Debug, Default)]
pub(crate) struct PortionsWhole {
    pub(crate) open: Vec<PlacedEdge>,
    pub(crate) nonmanifold: Vec<PlacedEdge>,
    pub(crate) misoriented: Vec<PlacedEdge>,
    /// Nodes of more than one fan, and where they are.
    pub(crate) pinched: Vec<(u32, DVec3)>,
    pub(crate) nodes: usize,
    pub(crate) triangles: usize,
    pub(crate) components: usize,
    /// Triangles that edges have beyond two, less what they lack.
    excess: i64,
}

impl PortionsWhole {
    pub(crate) fn is_manifold(&self) -> bool {
        self.nonmanifold.is_empty() && self.pinched.is_empty()
    }

    /// Nodes - edges + triangles.
    pub(crate) fn euler(&self) -> i64 {
        let edges = (3 * self.triangles as i64 - self.excess) / 2;
        self.nodes as i64 - edges + self.triangles as i64
    }

    /// Adds the defects at edges that are shared or that are not, and at such nodes.
    fn add(&mut self, p: &Portion, shared: bool) {
        let d = p.mesh.defects();
        let here = |list: &[[u32; 2]]| -> Vec<PlacedEdge> {
            list.iter().filter(|e| p.is_shared(**e) == shared).map(|e| p.placed(*e)).collect()
        };
        let (open, nonmanifold) = (here(&d.open_edges), here(&d.nonmanifold_edges));
        self.excess -= open.len() as i64;
        if !nonmanifold.is_empty() {
            let all = sides(&p.mesh);
            let crowded =
                all.chunk_by(|x, y| x.key == y.key).filter(|e| e.len() > 2 && p.is_shared(e[0].edge()) == shared);
            self.excess += crowded.map(|e| e.len() as i64 - 2).sum::<i64>();
        }
        self.open.extend(open);
        self.nonmanifold.extend(nonmanifold);
        self.misoriented.extend(here(&d.misoriented_edges));
        let pinched = d.nonmanifold_nodes.iter().map(|v| *v as usize).filter(|v| p.shared[*v] == shared);
        self.pinched.extend(pinched.map(|v| (p.nodes[v], p.mesh.nodes[v])));
    }
}

/// Portions on their way to a whole. It keeps the triangles at shared nodes and nothing else.
#[derive(Default)]
pub(crate) struct Joining {
    whole: PortionsWhole,
    /// All triangles that have a shared node.
    rim: Portion,
    /// For each node of the rim, by its number in the larger mesh, its number there.
    number: FxHashMap<u32, u32>,
    /// For each shared node one of the pieces, connected within their portion, that have it.
    pieces: FxHashMap<u32, u32>,
    /// How many such pieces there are.
    count: usize,
    /// Pieces that have a node in common.
    links: Vec<[u32; 2]>,
}

impl Joining {
    pub(crate) fn add(&mut self, p: &Portion) {
        self.whole.add(p, false);
        self.whole.triangles += p.mesh.triangles.len();
        let mut sets = Sets::new(p.mesh.nodes.len());
        for [a, b, c] in &p.mesh.triangles {
            sets.join(*a, *b);
            sets.join(*a, *c);
        }
        let (piece, count) = sets.numbers();
        for v in 0..p.nodes.len() {
            if !p.shared[v] {
                self.whole.nodes += 1;
                continue;
            }
            let mine = self.count as u32 + piece[v];
            let other = *self.pieces.entry(p.nodes[v]).or_insert(mine);
            if other != mine {
                self.links.push([other, mine]);
            }
        }
        self.count += count;
        for t in p.mesh.triangles.iter().filter(|t| t.iter().any(|v| p.shared[*v as usize])) {
            let corners = t.map(|v| self.rim_node(p, v as usize));
            self.rim.mesh.triangles.push(corners);
        }
    }

    fn rim_node(&mut self, p: &Portion, v: usize) -> u32 {
        let rim = &mut self.rim;
        *self.number.entry(p.nodes[v]).or_insert_with(|| {
            rim.mesh.nodes.push(p.mesh.nodes[v]);
            rim.nodes.push(p.nodes[v]);
            rim.shared.push(p.shared[v]);
            rim.nodes.len() as u32 - 1
        })
    }

    /// What the portions give together, and the shared edges above an angle.
    pub(crate) fn finish(self, sharp: f64) -> Joined {
        let Self { mut whole, rim, pieces, count, links, .. } = self;
        whole.add(&rim, true);
        whole.nodes += pieces.len();
        let mut sets = Sets::new(count);
        links.iter().for_each(|[a, b]| sets.join(*a, *b));
        whole.components = sets.numbers().1;
        for list in [&mut whole.open, &mut whole.nonmanifold, &mut whole.misoriented] {
            list.sort_unstable_by_key(|e| e.nodes);
        }
        whole.pinched.sort_unstable_by_key(|v| v.0);
        Joined { whole, sharp: rim.sharp_edges(sharp, true) }
    }
}

/// A whole and its sharp edges between shared nodes.
pub(crate) struct Joined {
    pub(crate) whole: PortionsWhole,
    pub(crate) sharp: FxHashSet<[u32; 2]>,
}

/// Triangles of two portions that intersect one of the other portion, by their places there.
#[derive(Debug, Default)]
pub(crate) struct PortionMeeting {
    pub(crate) one: Vec<u32>,
    pub(crate) other: Vec<u32>,
}

/// Where two portions [intersect](super::self_intersections), exactly.
pub(crate) fn intersections_between(one: &Portion, other: &Portion, run: &Run) -> Result<PortionMeeting> {
    let both = one.mesh.bounds().intersection(&other.mesh.bounds());
    let mut mesh = TriMesh::default();
    let mut number: FxHashMap<u32, u32> = FxHashMap::default();
    let mut from: Vec<u32> = Vec::new();
    let mut first = 0;
    for p in [one, other] {
        first = from.len();
        let near = |t: &u32| Aabb::around(p.mesh.corners(*t as usize)).overlaps(&both);
        for t in (0..p.mesh.triangles.len() as u32).filter(near) {
            let corners = p.mesh.triangles[t as usize].map(|v| {
                *number.entry(p.nodes[v as usize]).or_insert_with(|| {
                    mesh.nodes.push(p.mesh.nodes[v as usize]);
                    mesh.nodes.len() as u32 - 1
                })
            });
            mesh.triangles.push(corners);
            from.push(t);
        }
    }
    if first == 0 {
        return Ok(PortionMeeting::default());
    }
    let asked: Vec<u32> = (first as u32..from.len() as u32).collect();
    let mut meeting = PortionMeeting::default();
    for [t, u] in intersections_among(&mesh, &asked, run)? {
        if (t as usize) < first {
            meeting.one.push(from[t as usize]);
            meeting.other.push(from[u as usize]);
        }
    }
    Ok(meeting)
}
