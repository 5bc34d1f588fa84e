//! Values at the nodes of one mesh, carried to points of another.

use std::ops::{Add, Mul};

use glam::DVec3;
use rayon::prelude::*;

use super::TriMesh;
use crate::error::{Error, Place, Result};
use crate::run::Run;
use crate::spatial::{Aabb, Bvh, triangle_distance_squared, triangle_foot};

/// What came of [`carry`], an entry for each point.
#[derive(Debug, Clone, PartialEq)]
pub struct Carried<V> {
    /// The value.
    pub values: Vec<V>,
    /// How far the point is from the mesh that has the values.
    pub distances: Vec<f64>,
}

/// Carries values at a mesh's nodes to points, such as the nodes of a finer mesh of the same part. A point has the value at the
/// nearest point of the mesh, linear within each triangle. Values are numbers or vectors.
///
/// *Guarantees*: at a node of the mesh its value, bit by bit; linear functions are carried exactly to points of the mesh, but for
/// rounding; of triangles as near the one with the smallest number counts; the same for any number of threads. `distances` tell
/// which points are not on the mesh: no point is refused for being far away.
/// *Errors*: [`Error::Input`] for a mesh that is not [valid](TriMesh::validate) or has no triangles, for another number of values
/// than nodes, and for a point that is not finite; cancellation.
pub fn carry<V>(from: &TriMesh, values: &[V], to: &[DVec3], run: &Run) -> Result<Carried<V>>
where
    V: Copy + Add<Output = V> + Mul<f64, Output = V> + Send + Sync,
{
    from.validate()?;
    if values.len() != from.nodes.len() {
        let what = format!("{} values for {} nodes", values.len(), from.nodes.len());
        return Err(Error::input(Place::Item("values".into()), what));
    }
    if from.triangles.is_empty() {
        return Err(Error::input(Place::Unknown, "a mesh without triangles has no values to carry"));
    }
    let boxes = (0..from.triangles.len()).map(|t| Aabb::around(from.corners(t))).collect();
    let tree = run.install(|| Bvh::new(boxes));
    let one = |(i, p): (usize, &DVec3)| -> Result<(V, f64)> {
        run.check()?;
        let nearest = tree.nearest(*p, f64::INFINITY, |t| triangle_distance_squared(*p, from.corners(t as usize)));
        let Some((t, squared)) = nearest.filter(|_| p.is_finite()) else {
            return Err(Error::input(
                Place::Item(format!("point {i}")),
                format!("its coordinates are not finite: {p}"),
            ));
        };
        let [a, b, c] = from.triangles[t as usize].map(|v| values[v as usize]);
        let [u, v, w] = triangle_foot(*p, from.corners(t as usize));
        // At a corner nothing is added, so that its value stays as it is, and no other one that may not be finite counts.
        let parts = [(a, u), (b, v), (c, w)].into_iter().filter(|part| part.1 != 0.0);
        let value = parts.map(|(x, s)| if s == 1.0 { x } else { x * s }).reduce(|x, y| x + y);
        Ok((value.unwrap_or(a), squared.sqrt()))
    };
    let found: Vec<(V, f64)> = run.install(|| to.par_iter().enumerate().map(one).collect::<Result<_>>())?;
    let (values, distances) = found.into_iter().unzip();
    Ok(Carried { values, distances })
}

#[cfg(test)]
mod tests {
    use approx::assert_abs_diff_eq;

    use super::*;

    /// A square of two triangles in a slanted plane.
    fn square() -> TriMesh {
        let nodes = [[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]].map(|[x, y]| DVec3::new(x, y, 0.5 * x));
        TriMesh::new(nodes.to_vec(), vec![[0, 1, 2], [0, 2, 3]])
    }

    #[test]
    fn linear_functions_are_carried_exactly_and_nodes_keep_their_values() {
        let from = square();
        let linear = |p: &DVec3| 3.0 * p.x - 2.0 * p.y + 0.25 * p.z + 1.0;
        let values: Vec<f64> = from.nodes.iter().map(linear).collect();
        let to: Vec<DVec3> =
            (0..49).map(|i| DVec3::new((i % 7) as f64 / 3.0, (i / 7) as f64 / 3.0, (i % 7) as f64 / 6.0)).collect();
        let carried = carry(&from, &values, &to, &Run::new()).unwrap();
        for (p, (value, distance)) in to.iter().zip(carried.values.iter().zip(&carried.distances)) {
            assert_abs_diff_eq!(*value, linear(p), epsilon = 1e-13);
            assert_abs_diff_eq!(*distance, 0.0, epsilon = 1e-15);
        }
        let same = carry(&from, &values, &from.nodes, &Run::new()).unwrap();
        assert_eq!((same.values, same.distances), (values, vec![0.0; 4]));
        // Vectors, too; beyond the border the nearest point of it counts.
        let places = carry(&from, &from.nodes, &[DVec3::new(1.0, 5.0, 0.5)], &Run::new()).unwrap();
        assert_abs_diff_eq!(places.values[0].distance(DVec3::new(1.0, 2.0, 0.5)), 0.0, epsilon = 1e-15);
        assert_abs_diff_eq!(places.distances[0], 3.0, epsilon = 1e-15);
    }

    #[test]
    fn what_cannot_be_carried_is_refused() {
        let from = square();
        let refused = |mesh: &TriMesh, values: &[f64], to: &[DVec3]| {
            carry(mesh, values, to, &Run::new()).err().unwrap().to_string()
        };
        assert!(refused(&from, &[1.0; 3], &[]).contains("3 values for 4 nodes"));
        assert!(refused(&TriMesh::default(), &[], &[]).contains("without triangles"));
        assert!(refused(&from, &[1.0; 4], &[DVec3::ZERO, DVec3::NAN]).contains("point 1"));
    }
}
