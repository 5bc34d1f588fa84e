//! What is wrong with a mesh, as data.

use crate::error::{Error, Place, Result};
use crate::numeric::Sets;

use super::sides::{TriangleSide, sides};
use super::trimesh::TriMesh;

/// Everything that keeps a mesh from being a closed, oriented 2-manifold. All lists are ascending.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Defects {
    /// Edges of one triangle.
    pub open_edges: Vec<[u32; 2]>,
    /// Edges of more than two triangles.
    pub nonmanifold_edges: Vec<[u32; 2]>,
    /// Edges two triangles run through in the same direction.
    pub misoriented_edges: Vec<[u32; 2]>,
    /// Nodes whose triangles form more than one fan.
    pub nonmanifold_nodes: Vec<u32>,
    /// Triangles that name a node twice or have exactly no area.
    pub degenerate_triangles: Vec<u32>,
    /// Triangles with the same three nodes as an earlier one.
    pub duplicate_triangles: Vec<u32>,
    /// Nodes no triangle uses.
    pub unused_nodes: Vec<u32>,
}

impl Defects {
    /// Whether every edge has an even number of triangles, at least two.
    pub fn is_closed(&self) -> bool {
        self.open_edges.is_empty()
    }

    /// Whether no edge has more than two triangles, and the triangles around every node form one fan.
    pub fn is_manifold(&self) -> bool {
        self.nonmanifold_edges.is_empty() && self.nonmanifold_nodes.is_empty()
    }

    /// Whether neighbors run through their edge in opposite directions.
    pub fn is_oriented(&self) -> bool {
        self.misoriented_edges.is_empty()
    }
}

/// Counts that describe the surface as a whole.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Topology {
    /// Pieces not joined by an edge or node.
    pub components: usize,
    /// Nodes in use - edges + triangles.
    pub euler: i64,
    /// Handles, summed over the components; only for closed, manifold, oriented meshes.
    pub genus: Option<i64>,
}

impl TriMesh {
    /// Refuses what no question can be asked about: node numbers out of range, coordinates that are not finite, labels
    /// that do not fit.
    pub fn validate(&self) -> Result<()> {
        let n = self.nodes.len();
        let item = |text: String, message: String| Err(Error::input(Place::Item(text), message));
        if let Some(i) = self.nodes.iter().position(|p| !p.is_finite()) {
            return item(format!("node {i}"), format!("its coordinates are not finite: {}", self.nodes[i]));
        }
        if let Some(t) = self.triangles.iter().position(|t| t.iter().any(|v| *v as usize >= n)) {
            return item(format!("triangle {t}"), format!("it names node {:?} of {n}", self.triangles[t].iter().max()));
        }
        if self.labels.len() != self.triangles.len() {
            return item(
                "labels".into(),
                format!("{} labels for {} triangles", self.labels.len(), self.triangles.len()),
            );
        }
        if let Some(t) = self.labels.iter().position(|l| *l as usize >= self.faces.len()) {
            return item(
                format!("triangle {t}"),
                format!("its label {} names none of {} faces", self.labels[t], self.faces.len()),
            );
        }
        Ok(())
    }

    /// Finds all defects. The mesh must be [valid](Self::validate).
    pub fn defects(&self) -> Defects {
        let mut d = Defects::default();
        for (t, tri) in self.triangles.iter().enumerate() {
            let [a, b, c] = *tri;
            if a == b || b == c || c == a || self.area_vector(t) == glam::DVec3::ZERO {
                d.degenerate_triangles.push(t as u32);
            }
        }
        let sides = sides(self);
        // Triangles with the same nodes share every edge, so their nodes' sums differ if anything does.
        let sum = |s: &TriangleSide| self.triangles[s.triangle() as usize].iter().map(|v| u64::from(*v)).sum::<u64>();
        for group in sides.chunk_by(|a, b| a.key == b.key).filter(|g| g.len() > 1) {
            if let [a, b] = group
                && (sum(a) != sum(b) || a.triangle() == b.triangle())
            {
                continue;
            }
            let mut seen: Vec<(u64, u32)> = group.iter().map(|s| (sum(s), s.triangle())).collect();
            seen.sort_unstable();
            let twice = seen.windows(2).filter(|w| w[0].0 == w[1].0 && w[0].1 != w[1].1);
            d.duplicate_triangles.extend(twice.map(|w| w[1].1));
        }
        d.duplicate_triangles.sort_unstable();
        d.duplicate_triangles.dedup();
        // corners of the triangles around a node, joined across edges of exactly two triangles
        let mut fans = Sets::new(3 * self.triangles.len());
        let corner = |t: u32, v: u32| {
            let tri = self.triangles[t as usize];
            3 * t + (0..3).find(|k| tri[*k as usize] == v).unwrap_or(0)
        };
        for group in sides.chunk_by(|a, b| a.key == b.key) {
            let e = group[0].edge();
            match group {
                [_] => d.open_edges.push(e),
                [a, b] => {
                    if a.forward == b.forward {
                        d.misoriented_edges.push(e);
                    }
                    for v in e {
                        fans.join(corner(a.triangle(), v), corner(b.triangle(), v));
                    }
                }
                _ => d.nonmanifold_edges.push(e),
            }
        }
        let mut fan_of = vec![u32::MAX; self.nodes.len()];
        let mut twice = vec![false; self.nodes.len()];
        for (t, tri) in self.triangles.iter().enumerate() {
            for (k, v) in tri.iter().enumerate() {
                let fan = fans.find(3 * t as u32 + k as u32);
                let slot = &mut fan_of[*v as usize];
                if *slot == u32::MAX {
                    *slot = fan;
                } else if *slot != fan {
                    twice[*v as usize] = true;
                }
            }
        }
        d.nonmanifold_nodes = (0..self.nodes.len() as u32).filter(|v| twice[*v as usize]).collect();
        d.unused_nodes = (0..self.nodes.len() as u32).filter(|v| fan_of[*v as usize] == u32::MAX).collect();
        d
    }

    /// Components, Euler characteristic, genus. The mesh must be [valid](Self::validate).
    pub fn topology(&self, defects: &Defects) -> Topology {
        let paired = defects.is_closed() && defects.nonmanifold_edges.is_empty();
        let edges = if paired {
            3 * self.triangles.len() as i64 / 2
        } else {
            sides(self).chunk_by(|a, b| a.key == b.key).count() as i64
        };
        let mut sets = Sets::new(self.nodes.len());
        for [a, b, c] in &self.triangles {
            sets.join(*a, *b);
            sets.join(*b, *c);
        }
        let unused: Vec<u32> = defects.unused_nodes.clone();
        let roots = (0..self.nodes.len() as u32).filter(|v| sets.find(*v) == *v).count();
        let components = roots - unused.len();
        let nodes = (self.nodes.len() - unused.len()) as i64;
        let euler = nodes - edges + self.triangles.len() as i64;
        let good = defects.is_closed() && defects.is_manifold() && defects.is_oriented() && !self.triangles.is_empty();
        Topology { components, euler, genus: good.then_some((2 * components as i64 - euler) / 2) }
    }

    /// For each triangle a number of the body it is of: triangles joined by nodes have the same.
    pub fn bodies(&self) -> Vec<u32> {
        let mut sets = Sets::new(self.nodes.len());
        for [a, b, c] in &self.triangles {
            sets.join(*a, *b);
            sets.join(*a, *c);
        }
        self.triangles.iter().map(|t| sets.find(t[0])).collect()
    }

    /// Edges of exactly two triangles: their ends and the two triangles, ascending by ends.
    pub fn inner_edges(&self) -> Vec<([u32; 2], [u32; 2])> {
        sides(self)
            .chunk_by(|a, b| a.key == b.key)
            .filter(|g| g.len() == 2)
            .map(|g| (g[0].edge(), [g[0].triangle(), g[1].triangle()]))
            .collect()
    }

    /// Ends of the edges at which the normals of the two triangles differ by more than `angle` degrees.
    pub fn sharp_edges(&self, angle: f64) -> Vec<[u32; 2]> {
        let limit = angle.to_radians();
        let bent = |t: [u32; 2]| {
            let (a, b) = (self.area_vector(t[0] as usize), self.area_vector(t[1] as usize));
            a != glam::DVec3::ZERO && b != glam::DVec3::ZERO && a.cross(b).length().atan2(a.dot(b)) > limit
        };
        self.inner_edges().into_iter().filter(|(_, t)| bent(*t)).map(|(e, _)| e).collect()
    }
}
