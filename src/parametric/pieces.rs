//! The faces of a boundary representation as the pieces stages ask: each goes on beyond its borders as its surface does,
//! and where two meet, their common edges are the curve.

use glam::DVec3;

use super::chart::Chart;
use super::curve::PARTS;
use super::mesh::Parametric;
use super::surface::Surface;
use crate::geometry::{Foot, Pieces, SurfaceOracle};

/// Cosine of the angle up to which edges go on smoothly from one to the next, and normals across a seam: 10 degrees.
const SMOOTH: f64 = 0.985;

impl Parametric {
    /// The face of a piece: pieces beyond the faces are sheets of them.
    pub fn face_of(&self, piece: u32) -> u32 {
        let beyond = (piece as usize).checked_sub(self.brep.faces.len());
        beyond.and_then(|k| self.sheets.get(k)).map_or(piece, |s| s.0)
    }

    /// How many pieces there are: faces and sheets.
    pub fn piece_count(&self) -> u32 {
        (self.brep.faces.len() + self.sheets.len()) as u32
    }

    fn chart(&self, piece: u32) -> Option<&Chart> {
        let piece = piece as usize;
        self.charts.get(piece).or_else(|| self.sheets.get(piece.checked_sub(self.charts.len())?).map(|s| &s.1))
    }

    /// Unit normal of a piece's surface near a point, to the side of Su x Sv.
    fn normal_near(&self, face: u32, p: DVec3) -> Option<DVec3> {
        self.chart(face)?.normal_near(p)
    }

    /// The point of a piece's surface nearest to `p`; the surface is taken as a whole, without its borders.
    pub fn foot(&self, face: u32, p: DVec3) -> Option<DVec3> {
        let q = self.chart(face)?.foot(p);
        q.is_finite().then_some(q)
    }

    /// The distance of `p` to a piece's surface if that is more than `known`, else a number that is not; 0 where it has no
    /// foot. The surface is taken as a whole, without its borders.
    pub fn distance_beyond(&self, face: u32, p: DVec3, known: f64) -> f64 {
        let away = self.chart(face).map_or(0.0, |c| c.distance_beyond(p, known));
        if away.is_finite() { away } else { 0.0 }
    }

    /// The point nearest to `p` on an edge.
    fn on_edge(&self, edge: u32, p: DVec3) -> DVec3 {
        let (e, samples) = (&self.brep.edges[edge as usize], &self.samples[edge as usize]);
        // Between the neighbors of the nearest sample the curve turns little: Newton's method finds the foot there.
        let near = samples.iter().map(|s| s.1.distance_squared(p)).enumerate().min_by(|a, b| a.1.total_cmp(&b.1));
        let t = near.map(|n| samples[n.0].0);
        e.curve.at(e.curve.project(p, e.range, t))
    }

    /// The point nearest to `p` on the edges two faces share.
    fn on_common_edge(&self, faces: [u32; 2], p: DVec3) -> Option<DVec3> {
        let key = [faces[0].min(faces[1]), faces[0].max(faces[1])];
        let edges = self.between.get(&key)?;
        let near: Vec<u32> = match edges[..] {
            [_] => edges.clone(),
            // Edges whose boxes are far away need no projection.
            _ => {
                let far = |e: u32| {
                    self.edge_boxes[e as usize].corners().map(|c| c.distance_squared(p)).into_iter().fold(0.0, f64::max)
                };
                let bound = edges.iter().map(|e| far(*e)).fold(f64::INFINITY, f64::min);
                edges.iter().copied().filter(|e| self.edge_boxes[*e as usize].distance_squared(p) <= bound).collect()
            }
        };
        near.into_iter()
            .map(|e| self.on_edge(e, p))
            .min_by(|a, b| a.distance_squared(p).total_cmp(&b.distance_squared(p)))
    }

    /// Points along the edges of faces that `of` picks, several on each of their smooth pieces.
    pub fn edge_points(&self, of: impl Fn(u32) -> bool) -> Vec<DVec3> {
        let mut out = Vec::new();
        for (e, faces) in self.brep.edges.iter().zip(&self.faces_of) {
            if faces.iter().any(|f| of(*f)) {
                for w in e.curve.pieces(e.range).windows(2) {
                    let at = |k: usize| e.curve.at(w[0] + (w[1] - w[0]) * k as f64 / PARTS as f64);
                    out.extend((0..PARTS).map(at));
                }
            }
        }
        out
    }

    /// Nodes' places that no remesher may move: see the source for the rule.
    ///
    /// A vertex between the same two faces on both sides, with edges that go on smoothly, is no corner; every other
    /// vertex is. The flag is per vertex.
    pub fn corners(&self) -> Vec<bool> {
        let uses = self.brep.uses();
        let mut at: Vec<Vec<(u32, DVec3)>> = vec![Vec::new(); self.brep.vertices.len()];
        for (i, e) in self.brep.edges.iter().enumerate() {
            if self.faces_of[i].len() == 1 && uses[i] == 2 {
                // A seam: nothing in space.
                continue;
            }
            let [a, b] = e.range.map(|t| e.curve.jet(t)[1].normalize_or_zero());
            at[e.ends[0] as usize].push((i as u32, a));
            at[e.ends[1] as usize].push((i as u32, -b));
        }
        at.iter()
            .map(|list| match list[..] {
                [] => false,
                [(e, a), (f, b)] => {
                    let same = self.faces_of[e as usize] == self.faces_of[f as usize];
                    !same || a.dot(-b) < SMOOTH || self.faces_of[e as usize].len() != 2
                }
                _ => true,
            })
            .collect()
    }

    /// Which edges are seams at which the surface has a crease: a closed profile with a corner where it closes.
    pub fn creased_seams(&self) -> Vec<bool> {
        let uses = self.brep.uses();
        let creased = |i: usize| -> Option<bool> {
            let ([f], 2) = (&self.faces_of[i][..], uses[i]) else { return None };
            let chart = &self.charts[*f as usize];
            let e = &self.brep.edges[i];
            let uv = chart.wrapped(chart.project(e.curve.at(0.5 * (e.range[0] + e.range[1]))));
            let axis = (0..2).find(|&k| {
                let [a, b] = chart.bounds[k];
                chart.periods[k].is_some_and(|p| (uv[k] - a).abs().min((uv[k] - b).abs()) < 1e-6 * p)
            })?;
            let side = |v: f64| {
                let mut uv = uv;
                uv[axis] = v;
                chart.surface.normal(uv)
            };
            let [a, b] = chart.bounds[axis];
            Some(side(a)?.dot(side(b)?) < SMOOTH)
        };
        (0..self.brep.edges.len()).map(|i| creased(i).unwrap_or(false)).collect()
    }

    /// Whether a face has creases inside, or bends as sharp as these: between them it is meshed in sheets.
    pub fn has_creases(&self, face: u32) -> bool {
        let creased = self.creased_seams();
        self.sheets.iter().any(|s| s.0 == face)
            || self.faces_of.iter().zip(creased).any(|(faces, creased)| creased && faces.contains(&face))
    }

    /// Points of faces without a normal: tips of cones, and poles of swept and free-form surfaces.
    pub fn tips(&self) -> Vec<(u32, DVec3)> {
        let mut out = Vec::new();
        for (f, chart) in self.charts.iter().enumerate() {
            if !matches!(chart.surface, Surface::Sphere { .. }) {
                out.extend(chart.poles.iter().map(|p| (f as u32, p.point)));
            }
        }
        out
    }
}

impl SurfaceOracle for Parametric {
    fn project(&self, p: DVec3, reach: f64) -> Option<Foot> {
        let face = self.piece_at(p)?;
        let point = self.foot(face, p).filter(|q| q.distance(p) <= reach)?;
        let sign = if self.brep.faces[face as usize].outward { 1.0 } else { -1.0 };
        Some(Foot { point, normal: sign * self.normal_near(face, point)?, face })
    }

    fn curvatures(&self, foot: &Foot) -> Option<[f64; 2]> {
        self.curvature(foot.face, foot.point).map(|k| [k, 0.0])
    }
}

impl Pieces for Parametric {
    fn piece_at(&self, p: DVec3) -> Option<u32> {
        let distance = |f: usize| self.foot(f as u32, p).map_or(f64::INFINITY, |q| q.distance_squared(p));
        let all = (0..self.charts.len()).map(|f| (distance(f), f));
        all.min_by(|a, b| a.0.total_cmp(&b.0)).map(|x| x.1 as u32)
    }

    fn near(&self, p: DVec3) -> Vec<u32> {
        let reach = 0.01 * self.bounds().diagonal();
        (0..self.charts.len() as u32).filter(|f| self.foot(*f, p).is_some_and(|q| q.distance(p) <= reach)).collect()
    }

    fn meet(&self, pieces: &[u32], p: DVec3, reach: f64) -> Option<DVec3> {
        let q = match *pieces {
            [face] => self.foot(face, p)?,
            [a, b] => self.on_common_edge([a, b].map(|x| self.face_of(x)), p)?,
            _ => return None,
        };
        (q.distance(p) <= reach).then_some(q)
    }

    fn foot_facing(&self, piece: u32, p: DVec3, _normal: DVec3, reach: f64) -> Option<(DVec3, Option<DVec3>)> {
        let (q, n) = self.chart(piece)?.foot_and_normal(p);
        (q.distance(p) <= reach).then_some((q, n))
    }

    fn direction(&self, piece: u32, p: DVec3) -> Option<DVec3> {
        self.normal_near(piece, p)
    }

    fn plane(&self, piece: u32) -> Option<(DVec3, f64)> {
        match &self.chart(piece)?.surface {
            Surface::Plane { frame } => Some((frame.z(), frame.z().dot(frame.origin))),
            _ => None,
        }
    }

    fn curvature(&self, piece: u32, p: DVec3) -> Option<f64> {
        let chart = self.chart(piece)?;
        chart.curvature(chart.project_roughly(p))
    }

    fn bounds(&self, _pieces: &[u32], _p: DVec3) -> bool {
        true
    }

    fn apexes(&self) -> Vec<(u32, DVec3)> {
        self.tips()
    }

    fn face_at(&self, piece: u32, _p: DVec3) -> Option<u32> {
        Some(self.face_of(piece))
    }
}
