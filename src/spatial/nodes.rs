//! Points by place: which of them are near another one.

use glam::DVec3;
use kiddo::{ImmutableKdTree, SquaredEuclidean};

use super::LARGEST;
use crate::error::{Error, Place, Result};

/// Squared distances of the tree and of this room differ by rounding: the tree is asked for so much more.
const ROUNDING: f64 = 1.0 + 1e-12;

/// One of the points of a [`NodeTree`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NearNode {
    /// Its number, as given.
    pub node: u32,
    /// How far away it is.
    pub distance: f64,
}

/// Points that do not move, in an immutable k-d tree. Results depend on the points and their order alone.
pub struct NodeTree {
    points: Vec<DVec3>,
    tree: Option<ImmutableKdTree<f64, 3>>,
}

impl NodeTree {
    /// A tree over points, which are numbered as given. Points may coincide.
    ///
    /// *Errors*: [`Error::Input`] names a point whose coordinates are not finite or beyond 1e150; [`Error::Failed`] for more than
    /// 2^32 points.
    pub fn new(points: &[DVec3]) -> Result<Self> {
        if let Some(i) = points.iter().position(|p| !(p.abs().max_element() <= LARGEST) || p.is_nan()) {
            let what = format!("its coordinates are not finite or too large: {}", points[i]);
            return Err(Error::input(Place::Item(format!("node {i}")), what));
        }
        let list: Vec<[f64; 3]> = points.iter().map(|p| p.to_array()).collect();
        let tree = match list.is_empty() {
            true => None,
            false => Some(
                ImmutableKdTree::new_from_slice(&list).map_err(|e| Error::Failed(format!("a tree of nodes: {e}")))?,
            ),
        };
        Ok(Self { points: points.to_vec(), tree })
    }

    /// The point nearest to `p`, of several the one with the smallest number. None for a tree of no points or a `p` that is not finite.
    pub fn nearest(&self, p: DVec3) -> Option<NearNode> {
        let tree = self.tree.as_ref().filter(|_| p.is_finite())?;
        let found = tree.query(&p.to_array()).nearest_one::<SquaredEuclidean<f64>>().execute();
        let first = *self.points.get(found.item as usize)?;
        self.within(p, p.distance(first)).first().copied()
    }

    /// The points no farther from `p` than `distance`: the nearest first, of those as near the one with the smallest number.
    pub fn within(&self, p: DVec3, distance: f64) -> Vec<NearNode> {
        let Some(tree) = self.tree.as_ref().filter(|_| p.is_finite() && distance >= 0.0) else { return Vec::new() };
        let limit = distance * distance * ROUNDING;
        let found = tree.query(&p.to_array()).within::<SquaredEuclidean<f64>>(limit).unsorted().execute();
        let away = |node: u32| NearNode { node, distance: self.points[node as usize].distance(p) };
        let mut near: Vec<NearNode> = found.iter().map(|x| away(x.item)).filter(|n| n.distance <= distance).collect();
        near.sort_unstable_by(|a, b| a.distance.total_cmp(&b.distance).then(a.node.cmp(&b.node)));
        near
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Points on a grid of a plane, where many are as near as others, with the last one twice.
    fn grid() -> Vec<DVec3> {
        let mut points: Vec<DVec3> = (0..400).map(|i| DVec3::new((i % 20) as f64, (i / 20) as f64, 0.0)).collect();
        points.push(points[399]);
        points
    }

    #[test]
    fn near_points_are_those_a_look_at_all_finds() {
        let points = grid();
        let tree = NodeTree::new(&points).unwrap();
        for k in 0..200 {
            let p = DVec3::new((k % 14) as f64 * 1.5, (k / 14) as f64 * 1.5, 0.25 * (k % 3) as f64);
            for distance in [0.0, 0.5, 0.75, 1.0, 2.5] {
                let mut all: Vec<NearNode> = (0..points.len() as u32)
                    .map(|node| NearNode { node, distance: points[node as usize].distance(p) })
                    .filter(|n| n.distance <= distance)
                    .collect();
                all.sort_by(|a, b| a.distance.total_cmp(&b.distance).then(a.node.cmp(&b.node)));
                assert_eq!(tree.within(p, distance), all);
            }
            let least = (0..points.len()).min_by(|a, b| points[*a].distance(p).total_cmp(&points[*b].distance(p)));
            assert_eq!(tree.nearest(p).unwrap().node as usize, least.unwrap());
        }
        assert_eq!(tree.within(points[400], 0.0).iter().map(|n| n.node).collect::<Vec<_>>(), [399, 400]);
    }

    #[test]
    fn no_points_and_points_nowhere_are_near_nothing() {
        let none = NodeTree::new(&[]).unwrap();
        assert!(none.nearest(DVec3::ZERO).is_none() && none.within(DVec3::ZERO, 1.0).is_empty());
        let some = NodeTree::new(&grid()).unwrap();
        assert!(some.nearest(DVec3::splat(f64::NAN)).is_none() && some.within(DVec3::ZERO, f64::NAN).is_empty());
        let same = NodeTree::new(&[DVec3::ONE; 1000]).unwrap();
        assert_eq!(same.within(DVec3::ONE, 0.0).len(), 1000);
        for x in [f64::NAN, f64::INFINITY, -1e160] {
            let e = NodeTree::new(&[DVec3::ZERO, DVec3::new(0.0, x, 0.0)]).err().unwrap();
            assert!(e.to_string().contains("node 1"), "{e}");
        }
    }
}
