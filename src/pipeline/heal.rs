//! Healing, for those who may not know the stages, and of what the stages left.
//!
//! Each gate comes here: soups before a model is looked for in them, solids of R-functions and boundary representations when
//! their mesh came out open, no manifold, or intersecting itself.

use rustc_hash::FxHashMap;

use crate::error::{Error, Result};
use crate::geometry::SurfaceOracle;
pub use crate::heal::{Action, Defect, HealOptions, HealReport, Healed, Repair, heal};
use crate::heal::{ENOUGH, heal_onto};
use crate::mesh::TriMesh;
use crate::run::Run;

/// Heals a mesh the stages left open, no manifold, or intersecting itself (`intersecting`: how many triangles do, where that
/// is known), and brings what it fills holes with to the oracle's surface; without an oracle no hole is filled, only borders
/// that nearly meet are joined. `None` where nothing was wrong, and where healing would not set it right.
pub(super) fn heal_made(
    mesh: &TriMesh,
    intersecting: Option<usize>,
    oracle: Option<&dyn SurfaceOracle>,
    run: &Run,
) -> Result<Option<Healed>> {
    let d = mesh.defects();
    if intersecting == Some(0) && d.is_closed() && d.is_manifold() && d.is_oriented() {
        return Ok(None);
    }
    let options = HealOptions { max_hole: if oracle.is_some() { None } else { Some(0) } };
    match heal_onto(mesh, &options, oracle, run) {
        Err(Error::Cancelled) => Err(Error::Cancelled),
        Err(_) => Ok(None),
        Ok(h) => {
            let r = &h.report;
            Ok((!r.repairs.is_empty() && r.is_sound() && r.kept >= ENOUGH).then_some(h))
        }
    }
}

/// What a report says of healing, a line for each repair.
pub(super) fn told(report: &HealReport) -> Vec<String> {
    report.to_string().lines().skip(1).map(|l| format!("healed: {}", l.trim())).collect()
}

/// For each node of a mesh the number of the node at the same place in another one.
pub(super) fn same_places(from: &TriMesh, to: &TriMesh) -> Vec<Option<u32>> {
    let place = |p: &glam::DVec3| p.to_array().map(|x| (x + 0.0).to_bits());
    let at: FxHashMap<[u64; 3], u32> = to.nodes.iter().map(place).zip(0..).collect();
    from.nodes.iter().map(|p| at.get(&place(p)).copied()).collect()
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::geometry::Foot;

    /// A sphere around the origin.
    struct Ball(f64);

    impl SurfaceOracle for Ball {
        fn project(&self, p: DVec3, reach: f64) -> Option<Foot> {
            let normal = p.try_normalize()?;
            let point = self.0 * normal;
            (point.distance(p) <= reach).then_some(Foot { point, normal, face: 0 })
        }

        fn curvatures(&self, _: &Foot) -> Option<[f64; 2]> {
            None
        }
    }

    /// A sphere of radius 1, by latitude and longitude.
    fn ball(n: u32) -> TriMesh {
        let ring = |j: u32| {
            let (y, r) = (std::f64::consts::PI * f64::from(j) / f64::from(n)).sin_cos();
            (0..2 * n).map(move |i| {
                let (s, c) = (std::f64::consts::PI * f64::from(i) / f64::from(n)).sin_cos();
                DVec3::new(y * c, y * s, r)
            })
        };
        let nodes = [DVec3::Z].into_iter().chain((1..n).flat_map(ring)).chain([-DVec3::Z]).collect();
        let at = |i: u32, j: u32| if j == 0 { 0 } else { 1 + (j - 1) * 2 * n + i % (2 * n) };
        let last = 1 + (n - 1) * 2 * n;
        let mut triangles = Vec::new();
        for i in 0..2 * n {
            triangles.push([0, at(i, 1), at(i + 1, 1)]);
            for j in 1..n - 1 {
                triangles.push([at(i, j), at(i, j + 1), at(i + 1, j + 1)]);
                triangles.push([at(i, j), at(i + 1, j + 1), at(i + 1, j)]);
            }
            triangles.push([at(i, n - 1), last, at(i + 1, n - 1)]);
        }
        TriMesh::new(nodes, triangles)
    }

    #[test]
    fn what_stages_left_is_healed_onto_the_surface_or_left() {
        let (whole, run) = (ball(16), Run::new());
        let heal = |mesh: &TriMesh, oracle: Option<&dyn SurfaceOracle>| heal_made(mesh, None, oracle, &run).unwrap();
        assert!(heal(&whole, Some(&Ball(1.0))).is_none(), "nothing was wrong");
        let mut open = whole.clone();
        let far = |t: &[u32; 3]| t.iter().all(|v| whole.nodes[*v as usize].distance(DVec3::X) > 0.5);
        open.triangles.retain(far);
        open.labels.truncate(open.triangles.len());
        let healed = heal(&open, Some(&Ball(1.0))).unwrap();
        let off = healed.mesh.nodes.iter().map(|p| (p.length() - 1.0).abs()).fold(0.0, f64::max);
        assert!(healed.report.is_sound() && off < 1e-12, "{off} {}", healed.report);
        let lines = told(&healed.report);
        assert!(
            lines.len() == 2 && lines[0].starts_with("healed: hole: ") && lines[1].contains("projected"),
            "{lines:?}"
        );
        let places = same_places(&open, &healed.mesh);
        assert!(open.triangles.iter().flatten().all(|v| places[*v as usize].is_some()), "no node moved");
        // without an oracle a hole is no gap
        assert!(heal(&open, None).is_none());
        // most of it is lost: that would be another mesh
        let mut scraps = open.clone();
        scraps.triangles.truncate(3);
        scraps.triangles.push([0, 0, 1]);
        scraps.labels.truncate(4);
        assert!(heal(&scraps, None).is_none());
    }
}
