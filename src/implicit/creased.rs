//! Creases that run inside one formula, of which the tree knows nothing: seen on the finished mesh.

use glam::DVec3;

use super::leaf::Leaf;
use super::lockstep;
use super::newton::nearest;
use super::oracle::ImplicitOracle;
use crate::geometry::Pieces;
use crate::mesh::TriMesh;
use crate::run::Run;

/// Triangles whose normal is off from their formula's own by more than this cut off a crease: 25 degrees as a cosine. What
/// bends by as much as sizes allow is off by a few degrees.
const OFF: f64 = 0.906;

/// The middles of triangles that cut off what bends too much for them: a crease inside a formula or a blend, or a bend that is
/// tighter than the least size. Leaves of one smooth surface are not looked at.
pub fn creased(mesh: &TriMesh, oracle: &ImplicitOracle<'_>, run: &Run) -> Vec<DVec3> {
    cutting_off(mesh, oracle, run).into_iter().map(|t| mesh.centroid(t as usize)).collect()
}

/// The triangles with these middles.
pub(crate) fn cutting_off(mesh: &TriMesh, oracle: &ImplicitOracle<'_>, run: &Run) -> Vec<u32> {
    if !oracle.leaves().iter().any(Leaf::is_user) {
        return Vec::new();
    }
    let faces = oracle.faces_with(Leaf::is_user);
    let cut_off = |t: usize| {
        let (p, n, label) = (mesh.centroid(t), mesh.normal(t), mesh.labels[t]);
        if faces.get(label as usize) != Some(&true) {
            return None;
        }
        let leaf = oracle.piece_at(p).filter(|leaf| oracle.leaves().get(*leaf as usize).is_some_and(Leaf::is_user))?;
        // What only divides a face from itself, as cases of formulas do, has no direction there, and where another face's surface is
        // nearer than its own, it is of the other one's direction that nothing is known. Both take longer to ask than the direction.
        let off = n != DVec3::ZERO && oracle.direction(leaf, p)?.dot(n).abs() < OFF;
        (off && oracle.face_at(leaf, p) == Some(label) && oracle.bounds(&[leaf], p)).then_some(t as u32)
    };
    let all: Vec<usize> = (0..mesh.triangles.len()).collect();
    let found = run.install(|| lockstep::each(oracle.leaves(), &all, |t| cut_off(*t)));
    found.into_iter().flatten().collect()
}

/// How often the place where a direction turns is halved: to a 256th of a triangle, where a bend as tight as a triangle turns by less than
/// a degree.
const HALVINGS: usize = 8;

/// Of triangles that cut something off, those within which the direction of their leaf jumps. Elsewhere the leaf bends, too tightly for them.
/// Directions are those on the surface: away from it an R-function bends where on it it has an edge.
pub(crate) fn with_jumps(mesh: &TriMesh, oracle: &ImplicitOracle<'_>, which: &[u32], run: &Run) -> Vec<u32> {
    let jumps = |t: &u32| {
        let leaf = oracle.piece_at(mesh.centroid(*t as usize))?;
        let [a, b, c] = mesh.corners(*t as usize);
        let reach = a.distance(b).max(b.distance(c)).max(c.distance(a));
        let seen = |p: DVec3| {
            let q = nearest(oracle.leaves(), &[leaf], p, reach, oracle.scale()).unwrap_or(p);
            Some((q, oracle.direction(leaf, q)?))
        };
        let (a, b, c) = (seen(a)?, seen(b)?, seen(c)?);
        let apart = |x: &(DVec3, DVec3), y: &(DVec3, DVec3)| x.1.dot(y.1);
        let mut ends =
            [(a, b), (b, c), (c, a)].into_iter().min_by(|s, t| apart(&s.0, &s.1).total_cmp(&apart(&t.0, &t.1)))?;
        for _ in 0..HALVINGS {
            let middle = seen((ends.0.0 + ends.1.0) * 0.5)?;
            ends = if apart(&ends.0, &middle) < apart(&middle, &ends.1) { (ends.0, middle) } else { (middle, ends.1) };
        }
        Some(apart(&ends.0, &ends.1) < OFF)
    };
    let found = run.install(|| lockstep::each(oracle.leaves(), which, jumps));
    which.iter().zip(found).filter(|x| x.1 == Some(true)).map(|x| *x.0).collect()
}
