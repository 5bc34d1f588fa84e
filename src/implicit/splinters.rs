//! Splinters: where two faces make a sharp edge, a grid node between them may be parted from the rest, and marching cubes
//! makes a closed surface of its own around it, though solid (or gap) joins both.

use glam::DVec3;

use super::extract::Extracted;
use super::model::Implicit;
use crate::numeric::Sets;
use crate::spatial::{Aabb, Bvh};

/// A component this many cells across, at most, may be a splinter.
const LARGEST: f64 = 4.0;
/// What a splinter belongs to is no farther from it than this many cells.
const REACH: f64 = 3.0;
/// Nodes of other components that are tried, nearest first.
const TRIES: usize = 12;
/// Points of a way that are looked at.
const POINTS: usize = 16;

/// Takes the splinters out of an extracted mesh: small closed parts from whose middle a straight way leads, all inside the
/// solid (all outside, for a void), to a larger part. Their nodes stay, in no triangle: they lie on the surface. Returns
/// the middles.
pub(crate) fn drop_splinters(extracted: &mut Extracted, model: &Implicit, cell: f64) -> Vec<DVec3> {
    let mesh = &extracted.mesh;
    let (order, starts) = components(mesh.nodes.len(), &mesh.triangles);
    let parts: Vec<&[u32]> = starts.windows(2).map(|w| &order[w[0]..w[1]]).filter(|p| !p.is_empty()).collect();
    if parts.len() < 2 {
        return Vec::new();
    }
    let bounds = |part: &[u32]| Aabb::around(part.iter().flat_map(|t| mesh.corners(*t as usize)));
    let small: Vec<bool> = parts.iter().map(|p| bounds(p).diagonal() <= LARGEST * cell).collect();
    let mut large: Vec<u32> =
        parts.iter().zip(&small).filter(|(_, s)| !**s).flat_map(|(p, _)| p.iter().copied()).collect();
    large.sort_unstable();
    let tree = Bvh::new(large.iter().map(|t| Aabb::around(mesh.corners(*t as usize))).collect());
    let mut middles = Vec::new();
    let mut gone = vec![false; mesh.triangles.len()];
    for part in parts.iter().zip(&small).filter(|(_, s)| **s).map(|(p, _)| *p) {
        let corners = || part.iter().flat_map(|t| mesh.corners(*t as usize));
        let middle = corners().sum::<DVec3>() / (3 * part.len()) as f64;
        let volume: f64 =
            part.iter().map(|t| mesh.corners(*t as usize).map(|p| p - middle)).map(|[a, b, c]| a.dot(b.cross(c))).sum();
        let solid = volume > 0.0;
        let same = |p: DVec3| (extracted.tape_at(model, p).value(&model.leaves, p) > 0.0) == solid;
        let mut near: Vec<(f64, u32)> = Vec::new();
        tree.overlapping(&Aabb::around([middle]).grown(REACH * cell), |i| {
            near.extend(
                mesh.triangles[large[i as usize] as usize].map(|v| (mesh.nodes[v as usize].distance(middle), v)),
            );
        });
        near.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        near.dedup();
        let joined = near.iter().take(TRIES).any(|(_, v)| {
            let q = mesh.nodes[*v as usize];
            (0..POINTS).all(|k| same(middle.lerp(q, k as f64 / POINTS as f64)))
        });
        if joined {
            middles.push(middle);
            part.iter().for_each(|t| gone[*t as usize] = true);
        }
    }
    let mesh = &mut extracted.mesh;
    let mut keep = gone.iter().map(|g| !g);
    mesh.triangles.retain(|_| keep.next() == Some(true));
    let mut keep = gone.iter().map(|g| !g);
    mesh.labels.retain(|_| keep.next() == Some(true));
    middles
}

/// The triangles component by component, and where each component begins, and the last ends, among them.
pub(super) fn components(nodes: usize, triangles: &[[u32; 3]]) -> (Vec<u32>, Vec<usize>) {
    let mut sets = Sets::new(nodes);
    for &[a, b, c] in triangles {
        sets.join(a, b);
        sets.join(b, c);
    }
    let (set, count) = sets.numbers();
    let of = |t: &[u32; 3]| set[t[0] as usize] as usize;
    let mut starts = vec![0; count + 1];
    triangles.iter().for_each(|t| starts[of(t) + 1] += 1);
    (0..count).for_each(|k| starts[k + 1] += starts[k]);
    let (mut fill, mut order) = (starts.clone(), vec![0; triangles.len()]);
    for (k, t) in (0..).zip(triangles) {
        order[fill[of(t)]] = k;
        fill[of(t)] += 1;
    }
    (order, starts)
}
