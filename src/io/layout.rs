//! A mesh as points, curves, surfaces and solids: what formats with entities are written from.

use std::collections::BTreeMap;

use glam::DVec3;

use crate::error::Result;
use crate::mesh::{MeshView, TriMesh};
use crate::model::{Cut, from_mesh};
use crate::spatial::Aabb;

use super::WriteOptions;

/// Which entity a node stands with.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum NodeOwner {
    Point(u32),
    Curve(u32),
    Surface(u32),
}

/// A chain of mesh edges between two surfaces.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct CurveEntity {
    /// Its nodes, from the first point to the last.
    pub(super) nodes: Vec<u32>,
    /// Points at its ends.
    pub(super) ends: [u32; 2],
    /// Labels of the faces beside it, ascending, each once.
    pub(super) labels: Vec<u32>,
    /// The border of a plane figure it is part of: an index into [`Layout::rims`].
    pub(super) rim: Option<u32>,
}

/// A connected piece of a face.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct SurfaceEntity {
    pub(super) label: u32,
    /// Numbers of its cells, ascending.
    pub(super) cells: Vec<u32>,
    /// Curves along it, ascending.
    pub(super) curves: Vec<u32>,
    pub(super) bounds: Aabb,
}

/// A closed shell and the shells of its voids, as lists of surfaces.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct SolidEntity {
    /// The outer shell first.
    pub(super) shells: Vec<Vec<u32>>,
    /// Labels of its faces, ascending.
    pub(super) labels: Vec<u32>,
    /// Its volume, voids taken off.
    pub(super) volume: f64,
}

/// The entities of a mesh.
#[derive(Debug, Clone, Default)]
pub(super) struct Layout {
    pub(super) points: Vec<u32>,
    pub(super) curves: Vec<CurveEntity>,
    pub(super) surfaces: Vec<SurfaceEntity>,
    /// For each node where it stands.
    pub(super) owners: Vec<NodeOwner>,
    pub(super) solids: Vec<SolidEntity>,
    /// How many shells are not closed.
    pub(super) open_shells: usize,
    /// Names of the borders of a plane figure.
    pub(super) rims: Vec<String>,
    /// For each face name its triangles and their area.
    pub(super) sizes: Vec<(usize, f64)>,
}

impl Layout {
    /// Cuts the mesh along borders between faces and along the seams of the options. A mesh that cannot be cut (a triangle
    /// names a node twice) gets one surface per face, no curves and no solids.
    pub(super) fn new(view: &dyn MeshView, options: &WriteOptions) -> Result<Self> {
        let mesh = TriMesh::from_view(view);
        let mut cell_of = Vec::with_capacity(mesh.triangles.len());
        view.read_cells(0..view.cell_count(), &mut |run| {
            for (k, cell) in run.iter().enumerate() {
                cell_of.extend(std::iter::repeat_n((run.first + k) as u32, cell.len() - 2));
            }
            Ok(())
        })?;
        let mut layout = match from_mesh(&mesh, &options.seams, &options.corners) {
            Ok(cut) => Self::of_cut(&mesh, &cell_of, &cut),
            Err(_) => Self::of_labels(&mesh, &cell_of),
        };
        if let Some(outline) = &options.outline {
            let sets = outline.sets(options.groups);
            let mut border_of = BTreeMap::new();
            for (k, set) in (0u32..).zip(&sets) {
                border_of.extend(set.edges.iter().map(|[a, b]| ([*a.min(b), *a.max(b)], k)));
            }
            for curve in &mut layout.curves {
                let first = [curve.nodes[0], curve.nodes[1]];
                curve.rim = border_of.get(&[first[0].min(first[1]), first[0].max(first[1])]).copied();
            }
            layout.rims = sets.into_iter().map(|set| set.name).collect();
        }
        layout.sizes = vec![(0, 0.0); mesh.faces.len()];
        for (t, label) in mesh.labels.iter().enumerate() {
            let size = &mut layout.sizes[*label as usize];
            *size = (size.0 + 1, size.1 + 0.5 * mesh.area_vector(t).length());
        }
        Ok(layout)
    }

    /// Names of faces that have cells.
    pub(super) fn is_used(&self, face: u32) -> bool {
        self.sizes[face as usize].0 > 0
    }

    fn of_labels(mesh: &TriMesh, cell_of: &[u32]) -> Self {
        let mut lists: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
        (0u32..).zip(&mesh.labels).for_each(|(t, label)| lists.entry(*label).or_default().push(t));
        let mut layout = Self { owners: vec![NodeOwner::Surface(0); mesh.nodes.len()], ..Self::default() };
        for (label, triangles) in lists {
            layout.add_surface(mesh, cell_of, label, &triangles);
        }
        layout
    }

    fn add_surface(&mut self, mesh: &TriMesh, cell_of: &[u32], label: u32, triangles: &[u32]) {
        let number = self.surfaces.len() as u32;
        let mut cells: Vec<u32> = triangles.iter().map(|t| cell_of[*t as usize]).collect();
        cells.sort_unstable();
        cells.dedup();
        let corners = || triangles.iter().flat_map(|t| mesh.triangles[*t as usize]);
        corners().for_each(|v| self.owners[v as usize] = NodeOwner::Surface(number));
        let bounds = Aabb::around(corners().map(|v| mesh.nodes[v as usize]));
        self.surfaces.push(SurfaceEntity { label, cells, curves: Vec::new(), bounds });
    }

    fn of_cut(mesh: &TriMesh, cell_of: &[u32], cut: &Cut) -> Self {
        let mut layout = Self { owners: vec![NodeOwner::Surface(0); mesh.nodes.len()], ..Self::default() };
        let mut next = 0;
        for (f, face) in cut.model.faces.iter().enumerate() {
            let count = cut.fragments.face(f).cells().len();
            layout.add_surface(mesh, cell_of, face.label, &cut.triangles[next..next + count]);
            next += count;
            let curves = &mut layout.surfaces[f].curves;
            curves.extend(face.loops.iter().flat_map(|l| l.coedges()).map(|c| c.edge));
            curves.sort_unstable();
            curves.dedup();
        }
        let points = cut.fragments.vertices().len();
        layout.points = cut.nodes[..points].to_vec();
        let mut next = points;
        for (e, edge) in cut.model.edges.iter().enumerate() {
            let count = cut.fragments.edge_inner(e).len();
            let [first, last] = edge.ends.map(|v| layout.points[v as usize]);
            let inner = &cut.nodes[next..next + count];
            next += count;
            inner.iter().for_each(|v| layout.owners[*v as usize] = NodeOwner::Curve(e as u32));
            let nodes = [first].into_iter().chain(inner.iter().copied()).chain([last]).collect();
            layout.curves.push(CurveEntity { nodes, ends: edge.ends, labels: Vec::new(), rim: None });
        }
        for (p, v) in layout.points.iter().enumerate() {
            layout.owners[*v as usize] = NodeOwner::Point(p as u32);
        }
        for surface in &layout.surfaces {
            for c in &surface.curves {
                let labels = &mut layout.curves[*c as usize].labels;
                labels.push(surface.label);
            }
        }
        for curve in &mut layout.curves {
            curve.labels.sort_unstable();
            curve.labels.dedup();
        }
        layout.find_solids(mesh, cut);
        layout
    }

    fn find_solids(&mut self, mesh: &TriMesh, cut: &Cut) {
        let mut first = vec![0];
        for f in 0..cut.model.faces.len() {
            first.push(first[f] + cut.fragments.face(f).cells().len());
        }
        let mut shells = Vec::new();
        for s in 0..cut.model.shells.len() {
            if !cut.model.open_edges(s as u32).is_empty() {
                self.open_shells += 1;
                continue;
            }
            let faces = cut.model.shells[s].faces.clone();
            let triangles = faces.iter().map(|f| *f as usize).flat_map(|f| &cut.triangles[first[f]..first[f + 1]]);
            let triangles = triangles.copied().collect();
            shells.push(ClosedShell::new(mesh, faces, triangles));
        }
        let outer: Vec<usize> = (0..shells.len()).filter(|s| shells[*s].volume >= 0.0).collect();
        let mut homes: Vec<Vec<usize>> = vec![Vec::new(); shells.len()];
        for (s, shell) in shells.iter().enumerate().filter(|(_, shell)| shell.volume < 0.0) {
            let p = mesh.corners(shell.triangles[0] as usize)[0];
            let around = outer.iter().copied().filter(|o| shells[*o].bounds.contains(p) && shells[*o].holds(mesh, p));
            let home = around.min_by(|a, b| shells[*a].volume.total_cmp(&shells[*b].volume));
            // A shell turned inside out that is in nothing is a solid of its own.
            homes[home.unwrap_or(s)].push(s);
        }
        for (s, shell) in shells.iter().enumerate() {
            if shell.volume < 0.0 && !homes[s].contains(&s) {
                continue;
            }
            let voids = homes[s].iter().filter(|v| **v != s);
            let parts: Vec<&ClosedShell> = [shell].into_iter().chain(voids.map(|v| &shells[*v])).collect();
            let faces = parts.iter().flat_map(|p| &p.faces);
            let mut labels: Vec<u32> = faces.map(|f| self.surfaces[*f as usize].label).collect();
            labels.sort_unstable();
            labels.dedup();
            let volume = parts.iter().map(|p| p.volume).sum();
            self.solids.push(SolidEntity { shells: parts.iter().map(|p| p.faces.clone()).collect(), labels, volume });
        }
    }
}

/// A closed shell.
struct ClosedShell {
    faces: Vec<u32>,
    triangles: Vec<u32>,
    volume: f64,
    bounds: Aabb,
}

impl ClosedShell {
    fn new(mesh: &TriMesh, faces: Vec<u32>, triangles: Vec<u32>) -> Self {
        let bounds = Aabb::around(triangles.iter().flat_map(|t| mesh.corners(*t as usize)));
        let o = (bounds.lo + bounds.hi) / 2.0;
        let six = |t: &u32| {
            let [a, b, c] = mesh.corners(*t as usize).map(|p| p - o);
            a.dot(b.cross(c))
        };
        let volume = triangles.iter().map(six).sum::<f64>() / 6.0;
        Self { faces, triangles, volume, bounds }
    }

    /// Whether a point is inside: the solid angles of the triangles seen from there add up to a whole sphere, or to
    /// nothing.
    fn holds(&self, mesh: &TriMesh, p: DVec3) -> bool {
        let angle = |t: &u32| {
            let [a, b, c] = mesh.corners(*t as usize).map(|q| q - p);
            let [la, lb, lc] = [a, b, c].map(DVec3::length);
            let below = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
            2.0 * a.dot(b.cross(c)).atan2(below)
        };
        self.triangles.iter().map(angle).sum::<f64>().abs() > 2.0 * std::f64::consts::PI
    }
}
