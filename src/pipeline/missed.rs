//! What a mesh or an arrangement does not come near to, and where to look for it.

use glam::DVec3;
use rustc_hash::{FxHashMap, FxHashSet};

use crate::implicit::{Arranged, SurfacePoint};
use crate::mesh::TriMesh;
use crate::spatial::{Aabb, Bvh, triangle_distance_squared};

/// Those of some things at some place that a mesh does not come near to. They are few beside the triangles: the tree is theirs.
pub(super) fn far<T: Copy>(mesh: &TriMesh, things: &[T], place: impl Fn(&T) -> DVec3, reach: f64) -> Vec<T> {
    if things.is_empty() {
        return Vec::new();
    }
    let places: Vec<DVec3> = things.iter().map(place).collect();
    let tree = Bvh::new(places.iter().map(|p| Aabb::new(*p, *p).grown(reach)).collect());
    let mut away = vec![true; things.len()];
    for t in 0..mesh.triangles.len() {
        let corners = mesh.corners(t);
        tree.overlapping(&Aabb::around(corners), |k| {
            let k = k as usize;
            away[k] = away[k] && triangle_distance_squared(places[k], corners) > reach * reach;
        });
    }
    things.iter().zip(away).filter(|x| x.1).map(|x| *x.0).collect()
}

/// Points of faces that no triangle of the same face comes near to. The reach is many triangles wide, so there is a tree of those of
/// each face.
pub(super) fn far_from_own(mesh: &TriMesh, points: &[SurfacePoint], reach: f64) -> Vec<SurfacePoint> {
    let mut by_face: FxHashMap<u32, Vec<usize>> = points.iter().map(|x| (x.face, Vec::new())).collect();
    for (t, label) in mesh.labels.iter().enumerate() {
        if let Some(own) = by_face.get_mut(label) {
            own.push(t);
        }
    }
    let tree = |own: &Vec<usize>| Bvh::new(own.iter().map(|t| Aabb::around(mesh.corners(*t))).collect());
    let trees: FxHashMap<u32, Bvh> = by_face.iter().map(|(face, own)| (*face, tree(own))).collect();
    let is_far = |x: &SurfacePoint| {
        let distance = |i: u32| triangle_distance_squared(x.at, mesh.corners(by_face[&x.face][i as usize]));
        trees[&x.face].nearest(x.at, reach, distance).is_none()
    };
    points.iter().copied().filter(is_far).collect()
}

/// Boxes a `side` wide around cells that are not proved and touch each other, from where some points are: a wire that is too thin for the
/// cells is missed, or found, all along.
pub(super) fn unproved_around(arranged: &Arranged, points: &[SurfacePoint], side: f64) -> Vec<Aabb> {
    let at = |p: DVec3| (p / side).floor().to_array().map(|x| x as i64);
    let beside = |c: [i64; 3]| (0..27).map(move |k| [c[0] + k % 3 - 1, c[1] + k / 3 % 3 - 1, c[2] + k / 9 - 1]);
    let mut left: FxHashSet<[i64; 3]> = arranged.unproved.iter().map(|u| at(u.cell.center())).collect();
    let mut reached: Vec<[i64; 3]> = points.iter().map(|x| at(x.at)).collect();
    let mut next = 0;
    while let Some(c) = reached.get(next).copied() {
        next += 1;
        reached.extend(beside(c).filter(|b| left.remove(b)));
    }
    let corner = |c: [i64; 3]| DVec3::from_array(c.map(|x| x as f64)) * side;
    let cells = reached.into_iter().map(|c| Aabb::new(corner(c), corner(c) + side));
    cells.chain(points.iter().map(|x| Aabb::new(x.at, x.at).grown(side))).collect()
}
