//! Node classes: corner, crease, regular. By curvature alone as \[LIS14\] (14–17) has it, or by the edges marked sharp.

use super::crease::feature_neighbors;
use super::guard::ask_all;
use crate::error::Result;
use crate::mesh::curvature::{NodeCurvature, dihedral, node_curvature};
use crate::mesh::{EditMesh, edit::NONE};
use crate::numeric::kmeans::two_means;
use crate::run::Run;

/// Two clusters mean something only when their centers differ by more than this factor: two-means splits a sphere too.
pub const CONTRAST: f64 = 3.0;

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

/// Classes by curvature, \[LIS14\] (14–17), corrected: corners by two-means of the angle defects, then creases by
/// two-means of `(|k1|, |k2|)` over the other nodes; regular is what is neither. A split is accepted only when its
/// centers differ by more than [`CONTRAST`], and a node only when an edge at it bends by more than `feature_angle`
/// degrees (three such edges, or none of two along one line, for a corner). Bands of crease nodes are thinned: the
/// neighbors along the crease are the ends of the two sharpest edges to other crease or corner nodes that do not turn
/// back on each other.
pub fn classify_by_curvature(mesh: &EditMesh, feature_angle: f64, run: &Run) -> Result<Classes> {
    let angle = feature_angle.to_radians();
    let curvature: Vec<Option<NodeCurvature>> =
        ask_all(run, mesh.node_capacity(), |v| mesh.is_node(v).then(|| node_curvature(mesh, v)))?;
    let bends = ask_all(run, mesh.node_capacity(), |v| {
        mesh.is_node(v).then(|| mesh.outgoing(v).filter(|&h| dihedral(mesh, h) > angle).count())
    })?;
    let nodes: Vec<u32> = mesh.nodes().collect();
    let mut kinds = vec![None; mesh.node_capacity()];
    nodes.iter().for_each(|&v| kinds[v as usize] = Some(Kind::Regular));

    let range = |values: &mut dyn Iterator<Item = f64>| {
        values.fold((f64::INFINITY, 0.0), |(lo, hi): (f64, f64), x| (lo.min(x), hi.max(x)))
    };
    let at = |v: u32| curvature[v as usize].unwrap_or_default();
    let bent = |v: u32| bends[v as usize].unwrap_or(0);

    let (low, high) = range(&mut nodes.iter().map(|&v| at(v).defect));
    let defects: Vec<[f64; 1]> = nodes.iter().map(|&v| [at(v).defect]).collect();
    let corners = two_means(&defects, [high], [low]);
    if corners.contrast() > CONTRAST {
        for (&v, _) in nodes.iter().zip(&corners.is_high).filter(|x| *x.1) {
            if bent(v) >= 3 {
                kinds[v as usize] = Some(Kind::Corner);
            }
        }
    }

    let rest: Vec<u32> = nodes.into_iter().filter(|&v| kinds[v as usize] == Some(Kind::Regular)).collect();
    let (low, high) = range(&mut rest.iter().map(|&v| at(v).principal[0]));
    let (flat, _) = range(&mut rest.iter().map(|&v| at(v).principal[1]));
    let pairs: Vec<[f64; 2]> = rest.iter().map(|&v| at(v).principal).collect();
    let creases = two_means(&pairs, [high, flat], [low, flat]);
    if creases.contrast() > CONTRAST {
        for (&v, _) in rest.iter().zip(&creases.is_high).filter(|x| *x.1) {
            if bent(v) > 0 {
                kinds[v as usize] = Some(Kind::Crease);
            }
        }
    }

    let special = |v: u32| matches!(kinds[v as usize], Some(Kind::Crease | Kind::Corner));
    let along = ask_all(run, mesh.node_capacity(), |v| {
        if !mesh.is_node(v) || kinds[v as usize] != Some(Kind::Crease) {
            return None;
        }
        let mut ends: Vec<(f64, u32)> = mesh
            .outgoing(v)
            .map(|h| (dihedral(mesh, h), mesh.target(h)))
            .filter(|&(bend, x)| bend > angle && special(x))
            .collect();
        ends.sort_by(|x, y| y.0.total_cmp(&x.0).then(x.1.cmp(&y.1)));
        let first = ends.first()?.1;
        let way = |x: u32| mesh.point(x) - mesh.point(v);
        let second = ends.iter().skip(1).find(|x| way(x.1).dot(way(first)) < 0.0)?.1;
        Some([first, second])
    })?;
    Ok(Classes { kinds, along: along.into_iter().map(|x| x.unwrap_or([NONE; 2])).collect() })
}
