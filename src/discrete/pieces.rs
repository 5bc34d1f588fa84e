//! A soup as a model whose faces and edges answer for themselves.

use std::sync::OnceLock;

use glam::DVec3;
use rayon::prelude::*;
use rustc_hash::FxHashMap;

use super::features::{bridge_gaps, chains, drop_islands, drop_noise, flood, mark_feature_edges, mark_vertices};
use super::needles::mend_needles;
use super::sheet::{FaceSheet, FaceTriangle, SegmentLine};
use super::simplify::{Limits, Removed, Torn, drop_crowded, simplify, torn_nodes};
use super::sizes::{curvatures, divide_features, is_smooth};
use crate::error::Result;
use crate::geometry::{Foot, Pieces, SurfaceOracle};
use crate::mesh::edit::NONE;
use crate::mesh::{EditMesh, Group, TriMesh, self_intersections};
use crate::model::{Cut, from_mesh};
use crate::run::Run;
use crate::spatial::{Aabb, Bvh, triangle_foot};

/// Rounding of single precision, in which most files of triangles are written: nodes are known to a few times this share
/// of their coordinates.
const SINGLE: f64 = 4.0 * f32::EPSILON as f64;

/// Curvature that shows only within this share of the scale is noise.
const NOISE: f64 = 0.15;

/// Faces between torn features are noise that are smaller than a square of this share of the scale,
const TORN_AREA: f64 = 0.5;
/// or narrower than this share of it.
pub(crate) const TORN_WIDTH: f64 = 0.3;

/// Passes of dropping noise.
const NOISE_PASSES: usize = 4;

/// How a soup is understood.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DiscreteOptions {
    /// Edges whose triangles' normals differ by more degrees are features; \[GUO\] 2.1 has 40.
    pub feature_angle: f64,
    /// A geometric edge that turns by more degrees at a node has a vertex there.
    pub turn: f64,
    /// What is simplified away.
    pub limits: Limits,
    /// The edge length the model will be meshed with: features with rough sides that do not show at half of it are noise. 0
    /// where every edge counts.
    pub scale: f64,
}

impl Default for DiscreteOptions {
    fn default() -> Self {
        Self { feature_angle: 40.0, turn: 60.0, limits: Limits::default(), scale: 0.0 }
    }
}

/// A triangle mesh with the faces, edges and vertices found in it.
///
/// Pieces are numbered: the faces first, then lines that do not part two faces: creases that end within a face, and open
/// borders.
pub struct Discrete {
    /// The input's triangles: labels are faces, geometric edges are sharp, vertices pinned.
    pub mesh: EditMesh,
    /// Whether the triangles are fine enough to tell how the surface bends within the length of an edge.
    pub smooth: bool,
    /// Features that were simplified away.
    pub removed: Vec<Removed>,
    names: Vec<String>,
    groups: Vec<Group>,
    bounds: Aabb,
    pub(super) sheets: Vec<FaceSheet>,
    lines: Vec<SegmentLine>,
    /// The line where two faces meet, by their numbers, the smaller first.
    between: FxHashMap<[u32; 2], u32>,
    /// Creases and open borders: the line of each, and the pieces of nodes on them.
    creases: Vec<u32>,
    crease_at: FxHashMap<u32, Vec<u32>>,
    /// Made when it is asked for.
    pub(super) everything: OnceLock<Bvh>,
    pub(super) order: Vec<u32>,
    /// The larger magnitude of the principal curvatures at each node, on whichever face.
    pub(super) bends: Vec<f64>,
}

impl Discrete {
    /// Finds the model in an oriented 2-manifold, open or closed.
    ///
    /// Names of faces: a label whose triangles form one face gives it its name; where they form several these are numbered,
    /// and the label becomes a group of them. Groups of the input hold the faces of their labels.
    ///
    /// # Errors
    /// Those of [`EditMesh::new`]; cancellation.
    pub fn new(input: &TriMesh, options: &DiscreteOptions, run: &Run) -> Result<Self> {
        run.progress("features", 0.0);
        let mut mesh = EditMesh::new(input)?;
        let bounds = Aabb::around(mesh.nodes().map(|v| mesh.point(v)));
        let largest = [bounds.lo, bounds.hi].map(|p| p.abs().max_element()).into_iter().fold(0.0, f64::max);
        let precision = SINGLE * largest;
        let before = mesh.clone();
        let changed = mend_needles(&mut mesh, precision, run)?;
        // What healing parted by a small gap may be less apart than single precision.
        if changed > 0 && !self_intersections(&mesh.to_mesh(), run)?.is_empty() {
            mesh = before;
        }
        mark_feature_edges(&mut mesh, options.feature_angle);
        let torn = (options.scale > 0.0).then(|| Torn {
            nodes: torn_nodes(&mesh),
            limits: Limits {
                area: options.limits.area.max((TORN_AREA * options.scale).powi(2)),
                width: options.limits.width.max(TORN_WIDTH * options.scale),
                ..options.limits
            },
        });
        if options.scale > 0.0 {
            bridge_gaps(&mut mesh, options.feature_angle, options.scale);
            // What is gone no longer parts the averages of what is left.
            for _ in 0..NOISE_PASSES {
                if drop_noise(&mut mesh, options.feature_angle, 0.5 * options.scale, run)? == 0 {
                    break;
                }
            }
            drop_islands(&mut mesh, 0.5 * options.scale);
            if let Some(torn) = &torn {
                // Torn features nearer to a longer one leave no room for triangles, either: 20 degrees beside edges of the scale.
                drop_crowded(&mut mesh, torn, TORN_WIDTH * options.scale);
            }
        }
        let removed = simplify(&mut mesh, &options.limits, torn.as_ref(), run)?;
        // What features parted may be an island now.
        drop_islands(&mut mesh, 0.5 * options.scale);
        mesh.compact();
        mark_vertices(&mut mesh, options.turn);
        let (face, count) = flood(&mesh);
        let (names, groups) = name_faces(input, &mesh, &face, count);
        for t in 0..face.len() as u32 {
            let n = mesh.area_vector(t).normalize_or_zero();
            mesh.set_surface(t, face[t as usize], n);
        }
        if options.scale > 0.0 {
            divide_features(&mut mesh, options.scale);
        }
        let normals = corner_normals(&mesh);
        let smooth = is_smooth(&mesh);
        let curvatures = curvatures(&mesh, &normals, NOISE * options.scale, smooth);
        let mut bends = vec![0.0f64; mesh.node_capacity()];
        for h in mesh.triangles().flat_map(|t| 3 * t..3 * t + 3) {
            let most = &mut bends[mesh.origin(h) as usize];
            *most = most.max(curvatures[h as usize]);
        }
        let mut this = Self {
            smooth,
            bends,
            sheets: run.install(|| {
                sheets(&mesh, &normals, &curvatures, count, |f| FaceSheet::new(f, precision, options.scale, smooth))
            }),
            everything: OnceLock::new(),
            order: mesh.triangles().collect(),
            mesh,
            removed,
            names,
            groups,
            bounds,
            lines: Vec::new(),
            between: FxHashMap::default(),
            creases: Vec::new(),
            crease_at: FxHashMap::default(),
        };
        this.find_lines();
        Ok(this)
    }

    fn find_lines(&mut self) {
        let mut common: Vec<([u32; 2], [DVec3; 2])> = Vec::new();
        for chain in chains(&self.mesh) {
            let m = &self.mesh;
            let o = m.opposite(chain.edges[0]);
            let own = m.label(chain.edges[0] / 3);
            let segments = chain.nodes.windows(2).map(|w| [m.point(w[0]), m.point(w[1])]);
            if o != NONE && m.label(o / 3) != own {
                let other = m.label(o / 3);
                let key = [own.min(other), own.max(other)];
                common.extend(segments.map(|s| (key, s)));
            } else {
                let piece = (self.sheets.len() + self.creases.len()) as u32;
                self.creases.push(self.lines.len() as u32);
                self.lines.push(SegmentLine::new(segments.collect()));
                for v in chain.nodes {
                    let list = self.crease_at.entry(v).or_default();
                    if !list.contains(&piece) {
                        list.push(piece);
                    }
                }
            }
        }
        // Stable: segments of one pair keep the order of their chains.
        common.sort_by_key(|s| s.0);
        for group in common.chunk_by(|a, b| a.0 == b.0) {
            self.between.insert(group[0].0, self.lines.len() as u32);
            self.lines.push(SegmentLine::new(group.iter().map(|s| s.1).collect()));
        }
    }

    /// The box around all triangles.
    pub fn bounds(&self) -> Aabb {
        self.bounds
    }

    /// How many faces there are; pieces from this number on are lines within a face.
    pub fn face_count(&self) -> usize {
        self.sheets.len()
    }

    /// The names of the faces, by their numbers.
    pub fn face_names(&self) -> &[String] {
        &self.names
    }

    /// The lines within a face, by their numbers, that pass a point no farther than `near` away.
    pub fn creases_near(&self, face: u32, p: DVec3, near: f64) -> Vec<u32> {
        let first = self.sheets.len() as u32;
        let passes =
            |piece: &u32| self.line([face, *piece]).and_then(|l| l.foot(p)).is_some_and(|q| q.distance(p) <= near);
        (first..first + self.creases.len() as u32).filter(passes).collect()
    }

    /// The pieces a node of [`mesh`](Self::mesh) lies on, lines first.
    pub fn pieces_at(&self, v: u32) -> Vec<u32> {
        let mut out = self.crease_at.get(&v).cloned().unwrap_or_default();
        for h in self.mesh.outgoing(v) {
            let f = self.mesh.label(h / 3);
            if !out.contains(&f) {
                out.push(f);
            }
        }
        out
    }

    /// The input's triangles with the faces found as labels, named; and the groups.
    pub fn named(&self) -> TriMesh {
        let mut mesh = self.mesh.to_mesh();
        (mesh.faces, mesh.groups) = (self.names.clone(), self.groups.clone());
        mesh
    }

    /// The model: vertices, edges, faces and who borders on whom (the relation graph of \[GUO\] 3), with the input's
    /// triangles as fragments.
    ///
    /// # Errors
    /// Those of [`from_mesh`].
    pub fn model(&self) -> Result<Cut> {
        let m = &self.mesh;
        let mut number = vec![NONE; m.node_capacity()];
        m.nodes().enumerate().for_each(|(k, v)| number[v as usize] = k as u32);
        let sharp = m.edges().filter(|&h| m.is_sharp(h));
        let borders: Vec<[u32; 2]> = sharp.map(|h| [m.origin(h), m.target(h)].map(|v| number[v as usize])).collect();
        let corners: Vec<u32> = m.nodes().filter(|&v| m.is_pinned(v)).map(|v| number[v as usize]).collect();
        from_mesh(&self.named(), &borders, &corners)
    }

    fn line(&self, pieces: [u32; 2]) -> Option<&SegmentLine> {
        let [a, b] = [pieces[0].min(pieces[1]), pieces[0].max(pieces[1])];
        let k = match (b as usize).checked_sub(self.sheets.len()) {
            Some(crease) => *self.creases.get(crease)?,
            None => *self.between.get(&[a, b])?,
        };
        self.lines.get(k as usize)
    }
}

/// Names for faces, and groups of them.
fn name_faces(input: &TriMesh, mesh: &EditMesh, face: &[u32], count: usize) -> (Vec<String>, Vec<Group>) {
    let mut label = vec![0; count];
    mesh.triangles().for_each(|t| label[face[t as usize] as usize] = mesh.label(t));
    let mut of_label: Vec<Vec<u32>> = vec![Vec::new(); input.faces.len()];
    label.iter().enumerate().for_each(|(f, l)| of_label[*l as usize].push(f as u32));
    let mut names = vec![String::new(); count];
    let mut groups: Vec<Group> = Vec::new();
    for (name, faces) in input.faces.iter().zip(&of_label) {
        if let [one] = faces[..] {
            names[one as usize].clone_from(name);
            continue;
        }
        for (k, f) in faces.iter().enumerate() {
            names[*f as usize] = format!("{name}.{}", k + 1);
        }
        if !faces.is_empty() && input.faces.len() > 1 {
            groups.push(Group { name: name.clone(), faces: faces.clone() });
        }
    }
    for g in &input.groups {
        let faces = g.faces.iter().filter_map(|l| of_label.get(*l as usize)).flatten().copied().collect();
        groups.push(Group { name: g.name.clone(), faces });
    }
    (names, groups)
}

/// Calls `f` with the outgoing half-edges of each sector of a node: those that hang together without a geometric edge
/// between.
pub(super) fn each_sector(mesh: &EditMesh, v: u32, mut f: impl FnMut(&[u32])) {
    let mut ring: Vec<u32> = mesh.outgoing(v).collect();
    if let Some(first) = ring.iter().position(|&h| mesh.is_sharp(h)) {
        ring.rotate_left(first);
        ring.chunk_by(|_, &h| !mesh.is_sharp(h)).for_each(f);
    } else {
        f(&ring);
    }
}

/// For each half-edge the normal at its origin: the average over its sector, weighted by angles.
fn corner_normals(mesh: &EditMesh) -> Vec<DVec3> {
    let mut normals = vec![DVec3::ZERO; 3 * mesh.triangle_capacity()];
    for v in mesh.nodes() {
        each_sector(mesh, v, |sector| {
            let at = |h: u32| {
                let [p, q, r] = [mesh.origin(h), mesh.target(h), mesh.apex(h)].map(|x| mesh.point(x));
                let (u, w) = (q - p, r - p);
                u.cross(w).normalize_or_zero() * u.cross(w).length().atan2(u.dot(w))
            };
            let unit = sector.iter().map(|&h| at(h)).sum::<DVec3>().normalize_or_zero();
            sector.iter().for_each(|&h| normals[h as usize] = unit);
        });
    }
    normals
}

/// The triangles of every face, with normals and curvatures at their corners.
fn sheets(
    mesh: &EditMesh,
    normals: &[DVec3],
    bends: &[f64],
    count: usize,
    sheet: impl Fn(Vec<FaceTriangle>) -> FaceSheet + Sync + Send,
) -> Vec<FaceSheet> {
    let mut parts: Vec<Vec<FaceTriangle>> = vec![Vec::new(); count];
    let mut number = vec![NONE; mesh.triangle_capacity()];
    let mut counts = vec![0; count];
    for t in mesh.triangles() {
        let n = &mut counts[mesh.label(t) as usize];
        number[t as usize] = *n;
        *n += 1;
    }
    let beside = |h: u32| {
        let o = mesh.opposite(h);
        if o == NONE || mesh.label(o / 3) != mesh.label(h / 3) { NONE } else { number[(o / 3) as usize] }
    };
    for t in mesh.triangles() {
        let around = [3 * t, 3 * t + 1, 3 * t + 2].map(|h| h as usize);
        parts[mesh.label(t) as usize].push(FaceTriangle {
            corners: mesh.corner_points(t),
            normals: around.map(|h| normals[h]),
            bends: around.map(|h| bends[h]),
            beside: around.map(|h| beside(h as u32)),
        });
    }
    parts.into_par_iter().map(sheet).collect()
}

impl Discrete {
    pub(super) fn everything(&self) -> &Bvh {
        let boxes = || self.order.iter().map(|t| Aabb::around(self.mesh.corner_points(*t))).collect();
        self.everything.get_or_init(|| Bvh::new(boxes()))
    }

    /// The triangle nearest to a point and the nearest point of it.
    fn nearest(&self, p: DVec3, reach: f64) -> Option<(u32, DVec3)> {
        let at = |k: u32| {
            let c = self.mesh.corner_points(self.order[k as usize]);
            let w = triangle_foot(p, c);
            c[0] * w[0] + c[1] * w[1] + c[2] * w[2]
        };
        let k = self.everything().nearest(p, reach, |k| p.distance_squared(at(k)))?.0;
        Some((self.order[k as usize], at(k)))
    }
}

impl SurfaceOracle for Discrete {
    fn project(&self, p: DVec3, reach: f64) -> Option<Foot> {
        let (t, point) = self.nearest(p, reach)?;
        let face = self.mesh.label(t);
        Some(Foot { point, normal: self.sheets[face as usize].normal(point)?, face })
    }

    fn project_along(&self, p: DVec3, direction: DVec3, reach: f64) -> Option<Foot> {
        let ends = Aabb::around([p - reach * direction, p + reach * direction]);
        let mut best: Option<(f64, u32)> = None;
        self.everything().overlapping(&ends, |k| {
            let t = self.order[k as usize];
            let [a, b, c] = self.mesh.corner_points(t);
            let (u, v) = (b - a, c - a);
            let (w, n) = (p - a, u.cross(v));
            let slope = direction.dot(n);
            if slope == 0.0 {
                return;
            }
            let s = -w.dot(n) / slope;
            let q = w + s * direction;
            let area = n.length_squared();
            let (y, z) = (u.cross(q).dot(n) / area, q.cross(v).dot(n) / area);
            let inside = y >= 0.0 && z >= 0.0 && y + z <= 1.0;
            if inside && s.abs() <= reach && best.is_none_or(|b| (s.abs(), t) < (b.0.abs(), b.1)) {
                best = Some((s, t));
            }
        });
        let (s, t) = best?;
        let (point, face) = (p + s * direction, self.mesh.label(t));
        Some(Foot { point, normal: self.sheets[face as usize].normal(point)?, face })
    }

    fn curvatures(&self, foot: &Foot) -> Option<[f64; 2]> {
        self.curvature(foot.face, foot.point).map(|k| [k, 0.0])
    }
}

impl Pieces for Discrete {
    fn piece_at(&self, p: DVec3) -> Option<u32> {
        self.nearest(p, f64::INFINITY).map(|n| self.mesh.label(n.0))
    }

    fn near(&self, p: DVec3) -> Vec<u32> {
        let reach = DVec3::splat(0.01 * self.bounds.diagonal());
        let mut out = Vec::new();
        self.everything().overlapping(&Aabb::new(p - reach, p + reach), |k| {
            out.push(self.mesh.label(self.order[k as usize]));
        });
        out.sort_unstable();
        out.dedup();
        out
    }

    fn meet(&self, pieces: &[u32], p: DVec3, reach: f64) -> Option<DVec3> {
        let q = match *pieces {
            [face] => self.sheets.get(face as usize)?.foot(p)?,
            [a, b] => self.line([a, b])?.foot(p)?,
            _ => return None,
        };
        (q.distance(p) <= reach).then_some(q)
    }

    fn foot_facing(&self, piece: u32, p: DVec3, normal: DVec3, reach: f64) -> Option<(DVec3, Option<DVec3>)> {
        self.sheets.get(piece as usize)?.foot_facing(p, normal, reach)
    }

    fn direction(&self, piece: u32, p: DVec3) -> Option<DVec3> {
        self.sheets.get(piece as usize)?.normal(p)
    }

    fn plane(&self, piece: u32) -> Option<(DVec3, f64)> {
        self.sheets.get(piece as usize)?.plane
    }

    fn curvature(&self, piece: u32, p: DVec3) -> Option<f64> {
        self.sheets.get(piece as usize)?.bend(p)
    }

    fn bounds(&self, _pieces: &[u32], _p: DVec3) -> bool {
        true
    }

    fn apexes(&self) -> Vec<(u32, DVec3)> {
        Vec::new()
    }

    fn face_at(&self, piece: u32, _p: DVec3) -> Option<u32> {
        Some(piece)
    }
}
