//! Meshes of other programs, which have no fragments and no model: nodes are matched by distance.

use glam::DVec3;
use rayon::prelude::*;
use rustc_hash::{FxHashMap, FxHashSet};
use serde::Serialize;

use crate::error::{Error, Result};
use crate::mesh::{Group, TriMesh};
use crate::run::Run;
use crate::spatial::{Aabb, Bvh, NodeTree};

/// What came of [`join`].
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct JoinReport {
    /// Up to which distance nodes were matched.
    pub within: f64,
    /// Nodes that became one of another mesh.
    pub matched: usize,
    /// The largest distance one of them moved.
    pub farthest: f64,
    /// Meshes that share no node with any other, counted from 0 as given.
    pub alone: Vec<usize>,
    /// Nodes of the result.
    pub nodes: usize,
    /// Triangles of the result.
    pub triangles: usize,
    /// Edges of one triangle.
    pub open_edges: usize,
    /// Edges of more than two triangles, as where a face of one solid lies on one of another.
    pub nonmanifold_edges: usize,
    /// Edges two triangles run through in the same direction: one of two meshes is inside out.
    pub misoriented_edges: usize,
    /// Triangles with the same three nodes as an earlier one.
    pub doubled: usize,
}

/// Meshes joined to one.
#[derive(Debug, Clone, PartialEq)]
pub struct Joined {
    /// The mesh.
    pub mesh: TriMesh,
    /// What was matched, and what the mesh is like.
    pub report: JoinReport,
}

/// Two nodes of different meshes that may be one, numbered over all meshes; the nearest come first.
#[derive(Debug, Clone, Copy, PartialEq)]
struct NodePair {
    distance: f64,
    nodes: [u32; 2],
}

/// Joins meshes to one: a node of one mesh and the node of another that is nearest to it become one where they are no farther apart
/// than `within`, a length. The nearest pairs are joined first.
///
/// *Guarantees*: of each mesh a joined node has one node at most, so no triangle collapses, and triangles keep their order. A
/// joined node stands where the mesh that comes first has it, and no other moves by more than `within`. Faces, and groups, of the
/// same name are one.
/// *Does not guarantee*: a closed surface, or one way of winding; the report counts what is wrong. Nodes within one mesh are not
/// joined, nor are nodes put into edges.
/// *Errors*: [`Error::Usage`] for no meshes and for a length that is negative or not finite; [`Error::Input`] for meshes that are
/// not [valid](TriMesh::validate); cancellation.
pub fn join(meshes: &[TriMesh], within: f64, run: &Run) -> Result<Joined> {
    if meshes.is_empty() || !(within >= 0.0 && within.is_finite()) {
        return Err(Error::Usage(format!("meshes are joined within a finite length of 0 or more, not {within}")));
    }
    meshes.iter().try_for_each(TriMesh::validate)?;
    let firsts: Vec<u32> = starts(meshes)?;
    let nodes: Vec<DVec3> = meshes.iter().flat_map(|m| m.nodes.iter().copied()).collect();
    let pairs = run.install(|| pairs(meshes, &firsts, within, run))?;
    let root = classes(&pairs, &nodes, &firsts, within);
    let mesh = assembled(meshes, &root, nodes.clone());
    let moved: Vec<u32> = (0..nodes.len() as u32).filter(|v| root[*v as usize] != *v).collect();
    let shared: FxHashSet<usize> =
        moved.iter().flat_map(|v| [*v, root[*v as usize]]).map(|v| mesh_of(&firsts, v)).collect();
    let away = |v: &u32| nodes[*v as usize].distance(nodes[root[*v as usize] as usize]);
    let d = mesh.defects();
    let report = JoinReport {
        within,
        matched: moved.len(),
        farthest: moved.iter().map(away).fold(0.0, f64::max),
        alone: (0..meshes.len()).filter(|m| !shared.contains(m)).collect(),
        nodes: mesh.nodes.len(),
        triangles: mesh.triangles.len(),
        open_edges: d.open_edges.len(),
        nonmanifold_edges: d.nonmanifold_edges.len(),
        misoriented_edges: d.misoriented_edges.len(),
        doubled: d.duplicate_triangles.len(),
    };
    Ok(Joined { mesh, report })
}

/// The number of each mesh's first node over all meshes.
fn starts(meshes: &[TriMesh]) -> Result<Vec<u32>> {
    let mut all = 0u64;
    let mut starts = Vec::with_capacity(meshes.len());
    for mesh in meshes {
        starts.push(all as u32);
        all += mesh.nodes.len() as u64;
    }
    if all >= u64::from(u32::MAX) {
        return Err(Error::Usage(format!("the meshes have {all} nodes, more than one mesh can have")));
    }
    Ok(starts)
}

fn mesh_of(firsts: &[u32], node: u32) -> usize {
    firsts.partition_point(|f| *f <= node) - 1
}

/// For the nodes of each mesh the nearest one of each other mesh within the distance, the nearest pairs first.
fn pairs(meshes: &[TriMesh], firsts: &[u32], within: f64, run: &Run) -> Result<Vec<NodePair>> {
    let boxes: Vec<Aabb> =
        meshes.iter().map(|m| Aabb::around(m.nodes.iter().flat_map(|p| [*p - within, *p + within]))).collect();
    let beside = Bvh::new(boxes.clone()).pairs(&|_, _| true);
    let trees: Vec<NodeTree> = meshes.iter().map(|m| NodeTree::new(&m.nodes)).collect::<Result<_>>()?;
    let mut found: Vec<NodePair> = Vec::new();
    for [a, b] in beside.into_iter().flat_map(|[a, b]| [[a, b], [b, a]]).map(|x| x.map(|m| m as usize)) {
        run.check()?;
        let nearest = |(p, v): (&DVec3, u32)| {
            let is_near = boxes[b].overlaps(&Aabb::around([*p]));
            let near = *trees[b].within(*p, if is_near { within } else { -1.0 }).first()?;
            let nodes = [firsts[a] + v, firsts[b] + near.node];
            Some(NodePair { distance: near.distance, nodes: [nodes[0].min(nodes[1]), nodes[0].max(nodes[1])] })
        };
        let count = meshes[a].nodes.len() as u32;
        found.par_extend(meshes[a].nodes.par_iter().zip(0..count).filter_map(nearest));
    }
    found.par_sort_unstable_by(|a, b| a.distance.total_cmp(&b.distance).then(a.nodes.cmp(&b.nodes)));
    found.dedup();
    Ok(found)
}

/// For each node the one it becomes.
fn classes(pairs: &[NodePair], nodes: &[DVec3], firsts: &[u32], within: f64) -> Vec<u32> {
    let mut root: Vec<u32> = (0..nodes.len() as u32).collect();
    let mut members: FxHashMap<u32, Vec<u32>> = FxHashMap::default();
    for NodePair { nodes: pair, .. } in pairs {
        let [a, b] = pair.map(|v| root[v as usize]);
        let of = |r: u32| members.get(&r).cloned().unwrap_or_else(|| vec![r]);
        let mut both = [of(a), of(b)].concat();
        both.sort_unstable();
        let here = nodes[both[0] as usize];
        let one_each = both.windows(2).all(|w| mesh_of(firsts, w[0]) != mesh_of(firsts, w[1]));
        if a == b || !one_each || both.iter().any(|v| !(nodes[*v as usize].distance(here) <= within)) {
            continue;
        }
        both.iter().for_each(|v| root[*v as usize] = both[0]);
        members.remove(&a);
        members.remove(&b);
        members.insert(both[0], both);
    }
    root
}

/// One mesh, of nodes numbered over all meshes that became others.
fn assembled(meshes: &[TriMesh], root: &[u32], nodes: Vec<DVec3>) -> TriMesh {
    let mut new = vec![0u32; nodes.len()];
    let mut kept: Vec<DVec3> = Vec::new();
    // A node becomes one that comes before it.
    for v in 0..nodes.len() {
        let r = root[v] as usize;
        if r == v {
            new[v] = kept.len() as u32;
            kept.push(nodes[v]);
        } else {
            new[v] = new[r];
        }
    }
    let mut out = TriMesh { nodes: kept, ..TriMesh::default() };
    let (mut faces, mut groups) = (FxHashMap::<&str, u32>::default(), FxHashMap::<&str, usize>::default());
    let mut first = 0;
    for mesh in meshes {
        let mut label_of = Vec::with_capacity(mesh.faces.len());
        for name in &mesh.faces {
            label_of.push(*faces.entry(name).or_insert(out.faces.len() as u32));
            if out.faces.len() < faces.len() {
                out.faces.push(name.clone());
            }
        }
        out.labels.extend(mesh.labels.iter().map(|l| label_of[*l as usize]));
        out.triangles.extend(mesh.triangles.iter().map(|t| t.map(|v| new[first + v as usize])));
        for group in &mesh.groups {
            let place = *groups.entry(&group.name).or_insert(out.groups.len());
            if out.groups.len() < groups.len() {
                out.groups.push(Group { name: group.name.clone(), faces: Vec::new() });
            }
            let own = &mut out.groups[place].faces;
            own.extend(group.faces.iter().filter_map(|f| label_of.get(*f as usize)));
            own.sort_unstable();
            own.dedup();
        }
        first += mesh.nodes.len();
    }
    out
}
