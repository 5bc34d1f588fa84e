//! Clipping: which triangles stay, where the planes cut them, and how far nodes are from the planes.

use glam::DVec3;

use crate::error::{Error, Result};
use crate::mesh::TriMesh;
use crate::numeric::ROUNDING;

use super::options::{AXES, ClipPlane, KeptHalf};

/// The planes of a picture and what they do to its mesh. Triangles are not cut: samples beyond a plane are left out.
pub(super) struct Clipping<'a> {
    mesh: &'a TriMesh,
    planes: Vec<ClipPlane>,
    /// Whether something of the triangle stays; empty without planes.
    kept: Vec<bool>,
    /// Where the planes cut the surface.
    pub(super) cuts: Vec<[DVec3; 2]>,
}

impl<'a> Clipping<'a> {
    /// Prepares the planes for a camera in direction `towards`. Errors: usage, for two planes that keep the same half of an
    /// axis, a plane that does not cut the mesh, and planes that leave nothing of it.
    pub(super) fn new(mesh: &'a TriMesh, clips: &[ClipPlane], towards: DVec3) -> Result<Self> {
        // The direction counts as along the plane below that share of its length.
        let mut planes: Vec<ClipPlane> = Vec::new();
        for clip in clips {
            if clip.axis > 2 || !clip.position.is_finite() {
                return Err(Error::Usage("a clipping plane needs an axis from 0 to 2 and a finite position".into()));
            }
            let behind = if towards[clip.axis] < -ROUNDING { KeptHalf::Above } else { KeptHalf::Below };
            let plane = ClipPlane { keep: Some(clip.keep.unwrap_or(behind)), ..*clip };
            if planes.iter().any(|p| (p.axis, p.keep) == (plane.axis, plane.keep)) {
                let axis = AXES[plane.axis];
                return Err(Error::Usage(format!(
                    "two clipping planes across {axis} keep the same side: one is enough"
                )));
            }
            refuse_a_miss(mesh, &plane)?;
            planes.push(plane);
        }
        let mut clipping = Self { mesh, planes, kept: Vec::new(), cuts: Vec::new() };
        if !clipping.planes.is_empty() {
            clipping.kept = (0..mesh.triangles.len()).map(|t| clipping.stays(t)).collect();
            clipping.cuts = clipping.find_cuts();
            if clipping.ends().is_empty() {
                return Err(Error::Usage("the clipping planes leave nothing of the mesh".into()));
            }
        }
        Ok(clipping)
    }

    pub(super) fn is_active(&self) -> bool {
        !self.planes.is_empty()
    }

    /// Whether some of the triangle stays.
    pub(super) fn keeps(&self, t: usize) -> bool {
        self.kept.get(t).is_none_or(|k| *k)
    }

    /// For every plane the distances of all nodes on some scale, positive where the mesh stays, exactly 0 on the plane.
    pub(super) fn sides(&self) -> Vec<Vec<f32>> {
        let of_plane = |plane: &ClipPlane| {
            let side: Vec<f64> = self.mesh.nodes.iter().map(|p| side(plane, *p)).collect();
            let scale = side.iter().fold(f64::MIN_POSITIVE, |m, d| m.max(d.abs()));
            side.iter().map(|d| (d / scale) as f32).collect()
        };
        self.planes.iter().map(of_plane).collect()
    }

    /// What stays of a segment.
    pub(super) fn clipped(&self, ends: [DVec3; 2]) -> Option<[DVec3; 2]> {
        self.clipped_but(ends, usize::MAX)
    }

    /// What all planes but one leave of a segment.
    fn clipped_but(&self, ends: [DVec3; 2], but: usize) -> Option<[DVec3; 2]> {
        let others = self.planes.iter().enumerate().filter(|(k, _)| *k != but);
        others.map(|(_, plane)| plane).try_fold(ends, |[a, b], plane| match (side(plane, a), side(plane, b)) {
            (d, e) if d >= 0.0 && e >= 0.0 => Some([a, b]),
            (d, e) if d < 0.0 && e < 0.0 => None,
            (d, _) if d >= 0.0 => Some([a, crossing(plane, a, b)]),
            _ => Some([crossing(plane, a, b), b]),
        })
    }

    /// Points whose hull is that of all that stays.
    pub(super) fn ends(&self) -> Vec<DVec3> {
        let kept = (0..self.mesh.triangles.len()).filter(|t| self.keeps(*t));
        let sides = kept.flat_map(|t| {
            let p = self.mesh.corners(t);
            (0..3).map(move |i| [p[i], p[(i + 1) % 3]])
        });
        sides.filter_map(|side| self.clipped(side)).chain(self.cuts.iter().copied()).flatten().collect()
    }

    /// A triangle in a plane stays if what it bounds does.
    fn stays(&self, t: usize) -> bool {
        let corners = self.mesh.corners(t);
        self.planes.iter().all(|plane| {
            let d = corners.map(|p| side(plane, p));
            let out = self.mesh.normal(t)[plane.axis] * sign(plane);
            d.iter().any(|d| *d > 0.0) || (d == [0.0; 3] && out < 0.0)
        })
    }

    fn find_cuts(&self) -> Vec<[DVec3; 2]> {
        let mut cuts = Vec::new();
        for t in (0..self.mesh.triangles.len()).filter(|t| self.keeps(*t)) {
            let p = self.mesh.corners(t);
            for (k, plane) in self.planes.iter().enumerate() {
                let d = p.map(|p| side(plane, p));
                let on = (0..3).filter(|i| d[*i] == 0.0).map(|i| p[i]);
                let between = (0..3).map(|i| (i, (i + 1) % 3)).filter(|(i, j)| d[*i] * d[*j] < 0.0);
                // From the lower end, so that both triangles of an edge find the same point.
                let across = between.map(|(i, j)| if d[i] < d[j] { (i, j) } else { (j, i) });
                let points: Vec<DVec3> = on.chain(across.map(|(i, j)| crossing(plane, p[i], p[j]))).collect();
                if let [a, b] = points[..] {
                    cuts.extend(self.clipped_but([a, b], k));
                }
            }
        }
        cuts
    }
}

fn refuse_a_miss(mesh: &TriMesh, plane: &ClipPlane) -> Result<()> {
    let at = |v: &u32| mesh.nodes[*v as usize][plane.axis];
    let used = || mesh.triangles.iter().flatten().map(at);
    let (lo, hi) = (used().fold(f64::INFINITY, f64::min), used().fold(f64::NEG_INFINITY, f64::max));
    if lo < plane.position && plane.position < hi {
        return Ok(());
    }
    let (axis, position) = (AXES[plane.axis], plane.position);
    let reach = format!("which lies between {axis} = {lo} and {axis} = {hi}");
    Err(Error::Usage(format!("the clipping plane {axis} = {position} does not cut the mesh, {reach}")))
}

fn sign(plane: &ClipPlane) -> f64 {
    if plane.keep == Some(KeptHalf::Above) { 1.0 } else { -1.0 }
}

/// A quarter of the distance from the plane, positive where the mesh stays: differences of two cannot overflow.
fn side(plane: &ClipPlane, p: DVec3) -> f64 {
    sign(plane) * (0.25 * p[plane.axis] - 0.25 * plane.position)
}

/// The point of a segment on the plane; its ends lie on different sides.
fn crossing(plane: &ClipPlane, a: DVec3, b: DVec3) -> DVec3 {
    let (d, e) = (side(plane, a), side(plane, b));
    let t = (d / (d - e)).clamp(0.0, 1.0);
    let mut point = (1.0 - t) * a + t * b;
    point[plane.axis] = plane.position;
    point
}
