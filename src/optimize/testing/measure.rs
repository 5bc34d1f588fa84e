//! Measures of a mesh against a test part.

use glam::DVec3;

use super::TestPart;
use crate::geometry::SurfaceOracle;
use crate::mesh::{EditMesh, TriMesh, edit::NONE};
use crate::spatial::segment_foot;

/// What [`measure`] finds.
#[derive(Debug, Clone, Copy)]
pub struct Measure {
    pub triangles: usize,
    pub euler: i64,
    pub closed: bool,
    pub inverted: usize,
    pub recall: f64,
    pub precision: f64,
    pub corners: usize,
    pub corners_found: usize,
    pub normal: f64,
    pub min_angle: f64,
    pub p05_angle: f64,
    pub below_20: f64,
    pub node_error: f64,
}

/// Measures `mesh` against `part`: features within 5 % of `h`, as truth those sharper than 40 degrees.
pub fn measure(mesh: &TriMesh, part: &TestPart, h: f64) -> Measure {
    let edit = EditMesh::new(mesh).expect("an oriented manifold");
    let near = 0.05 * h;
    let sharp: Vec<(DVec3, DVec3)> = edit
        .edges()
        .filter(|&e| edit.opposite(e) != NONE)
        .filter(|&e| {
            mesh.normal((e / 3) as usize).angle_between(mesh.normal((edit.opposite(e) / 3) as usize)).to_degrees()
                > 30.0
        })
        .map(|e| (edit.point(edit.origin(e)), edit.point(edit.target(e))))
        .collect();
    let (mut good, mut all) = (0.0, 0.0);
    for &(a, b) in &sharp {
        for k in 0..4 {
            let p = a.lerp(b, (f64::from(k) + 0.5) / 4.0);
            all += a.distance(b);
            if part.crease_distance(p, 2.0) < near {
                good += a.distance(b);
            }
        }
    }
    let (curve, corners) = part.creases(0.9 * h, 40.0);
    let cell = 4.0 * h;
    let key = |p: DVec3| (p / cell).floor().as_i64vec3();
    let mut grid: rustc_hash::FxHashMap<glam::I64Vec3, Vec<usize>> = Default::default();
    for (i, &(a, b)) in sharp.iter().enumerate() {
        let (lo, hi) = (key(a.min(b) - near), key(a.max(b) + near));
        for x in lo.x..=hi.x {
            for y in lo.y..=hi.y {
                for z in lo.z..=hi.z {
                    grid.entry(glam::I64Vec3::new(x, y, z)).or_default().push(i);
                }
            }
        }
    }
    let found = |p: &&DVec3| {
        let candidates = grid.get(&key(**p)).map_or(&[][..], |v| v);
        candidates.iter().any(|&i| p.distance(segment_foot(**p, [sharp[i].0, sharp[i].1])) < near)
    };
    let recall = curve.iter().filter(found).count() as f64 / curve.len().max(1) as f64;
    let corners_found = corners.iter().filter(|c| mesh.nodes.iter().any(|p| p.distance(**c) < near)).count();
    let (mut sum, mut area, mut flipped) = (0.0, 0.0, 0);
    let mut angles: Vec<f64> = Vec::new();
    for t in 0..mesh.triangles.len() {
        let [a, b, c] = mesh.corners(t);
        let angle = |p: DVec3, q: DVec3, r: DVec3| (q - p).angle_between(r - p).to_degrees();
        angles.push(angle(a, b, c).min(angle(b, c, a)).min(angle(c, a, b)));
        let facing = part.project(mesh.centroid(t), h).map_or(0.0, |f| f.normal.dot(mesh.normal(t)));
        let w = mesh.area_vector(t).length();
        flipped += usize::from(facing <= 0.0);
        sum += w * (1.0 - facing * facing);
        area += w;
    }
    angles.sort_by(f64::total_cmp);
    Measure {
        triangles: mesh.triangles.len(),
        euler: edit.nodes().count() as i64 - edit.edges().count() as i64 + mesh.triangles.len() as i64,
        closed: edit.edges().all(|e| edit.opposite(e) != NONE),
        inverted: flipped,
        recall,
        precision: if all > 0.0 { good / all } else { 1.0 },
        corners: corners.len(),
        corners_found,
        normal: sum / area,
        min_angle: angles[0],
        p05_angle: angles[angles.len() / 20],
        below_20: angles.iter().filter(|&&x| x < 20.0).count() as f64 / angles.len() as f64,
        node_error: mesh.nodes.iter().map(|&p| part.value(p).abs()).fold(0.0, f64::max),
    }
}
