//! Node classes: corner, crease, regular. By curvature alone as \[LIS14\] (14–17) has it, or by the edges marked sharp.

use super::crease::feature_neighbors;
use super::guard::find_all;
use super::sheets::{SheetsAround, around, best_corners};
use crate::error::Result;
use crate::mesh::{EditMesh, edit::NONE};
use crate::numeric::COS_60;
use crate::run::Run;

/// What a node is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// Inside a smooth face.
    Regular,
    /// On a crease.
    Crease,
    /// Where creases end or meet.
    Corner,
}

/// The class of every node and, for nodes on a crease, the neighbors along it.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Classes {
    kinds: Vec<Option<Kind>>,
    along: Vec<[u32; 2]>,
}

impl Classes {
    /// The node's class; a node born after the classification is regular.
    pub fn kind(&self, v: u32) -> Kind {
        self.kinds.get(v as usize).copied().flatten().unwrap_or(Kind::Regular)
    }

    /// The two neighbors of a crease node along its crease, where there are two.
    pub fn along(&self, v: u32) -> Option<[u32; 2]> {
        self.along.get(v as usize).copied().filter(|x| x[1] != NONE)
    }

    /// How many nodes are regular, on creases, corners.
    pub fn counts(&self) -> [usize; 3] {
        let count = |k| self.kinds.iter().filter(|x| **x == Some(k)).count();
        [count(Kind::Regular), count(Kind::Crease), count(Kind::Corner)]
    }
}

/// The class of one node by the feature edges (sharp or boundary) that meet there: two make a crease, none a regular
/// node, all else a corner, and so does a pin.
pub fn kind_by_edges(mesh: &EditMesh, v: u32) -> Kind {
    if mesh.is_pinned(v) {
        return Kind::Corner;
    }
    let sharp = mesh.outgoing(v).filter(|&h| mesh.is_feature(h)).count() + usize::from(mesh.is_boundary(v));
    match sharp {
        0 => Kind::Regular,
        2 => Kind::Crease,
        _ => Kind::Corner,
    }
}

/// Classes from the edges marked sharp ([`mark_sharp`](super::crease::mark_sharp)): what the default sequence uses.
pub fn classify_by_edges(mesh: &EditMesh) -> Classes {
    let mut out = Classes { kinds: vec![None; mesh.node_capacity()], along: vec![[NONE; 2]; mesh.node_capacity()] };
    for v in mesh.nodes() {
        let kind = kind_by_edges(mesh, v);
        out.kinds[v as usize] = Some(kind);
        if kind == Kind::Crease
            && let [a, b] = feature_neighbors(mesh, v)[..]
        {
            out.along[v as usize] = [a, b];
        }
    }
    out
}

/// Classes by curvature, \[LIS14\] (14–17), corrected: not of one ring but of a disc of 1.6 edges around the node, and with k-means of
/// normals in place of curvatures, so that a curved face does not count as bent and the number of clusters can be tested.
///
/// Around every node the normals of the triangles form one, two, three or four clusters; clusters are sheets of the surface when
/// it bends by more than `feature_angle` degrees where they touch, and at once. A node is on a crease when it lies
/// on two sheets. Where three meet, the nearest node is the corner, and no other one within an edge. Of the band of
/// nodes that is left the neighbors along a crease are those that its direction meets best, one ahead and one back.
///
/// *Guarantees*: every crease node lies within a tenth of an edge of the planes of two sheets of the mesh; the answer does not
/// depend on the number of threads. *Does not guarantee*: corners with no node within half an edge, and faces narrower than an edge.
pub fn classify_by_curvature(mesh: &EditMesh, feature_angle: f64, run: &Run) -> Result<Classes> {
    let angle = feature_angle.to_radians();
    let seen = find_all(run, mesh.node_capacity(), |v| mesh.is_node(v).then(|| around(mesh, v, angle)))?;
    let kind = |a: &SheetsAround| if a.crease.is_some() { Kind::Crease } else { Kind::Regular };
    let mut kinds: Vec<Option<Kind>> = seen.iter().map(|a| a.as_ref().map(kind)).collect();
    for v in best_corners(mesh, &seen) {
        kinds[v as usize] = Some(Kind::Corner);
    }
    let special = |v: u32| matches!(kinds[v as usize], Some(Kind::Crease | Kind::Corner));
    let along = find_all(run, mesh.node_capacity(), |v| {
        let crease = seen[v as usize].as_ref()?.crease.filter(|_| kinds[v as usize] == Some(Kind::Crease))?;
        let ahead = |sign: f64| {
            let way = |x: u32| sign * (mesh.point(x) - mesh.point(v)).normalize_or_zero().dot(crease);
            // A neighbor along a crease is that near to its direction: half of the way to turning back.
            let ends = mesh.neighbors(v).filter(|&x| special(x) && way(x) > COS_60);
            ends.max_by(|&x, &y| way(x).total_cmp(&way(y)).then(y.cmp(&x)))
        };
        Some([ahead(1.0)?, ahead(-1.0)?])
    })?;
    Ok(Classes { kinds, along: along.into_iter().map(|x| x.unwrap_or([NONE; 2])).collect() })
}
