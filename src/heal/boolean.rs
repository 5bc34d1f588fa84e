//! Set operations on closed meshes, exactly: their triangles are cut along their intersections, and those stay that part inside
//! from outside.

use glam::DVec3;

use super::arrange::{Complex, MOST_BODIES, Uses, arrange, merge_near};
use super::levels::{Copy, build, join};
use super::sides::{Sides, directed, pieces};
use super::winding::{Patches, behind};
use crate::error::{Error, Result};
use crate::mesh::TriMesh;
use crate::run::Run;
use crate::spatial::Aabb;

/// What came of a set operation.
#[derive(Debug, Clone, Default)]
pub struct Joined {
    /// Closed and oriented, with a manifold's connectivity; it has no faces. Where parts of the inside touch each has nodes of its
    /// own.
    pub mesh: TriMesh,
    /// For each triangle the one of the bodies it is part of: they are numbered one body after the other. Where triangles of
    /// several bodies coincide it is the first one's.
    pub from: Vec<u32>,
    /// Whether each triangle winds against that one.
    pub turned: Vec<bool>,
    /// For each node the one of the bodies that it is, numbered likewise; `u32::MAX` for one on an intersection.
    pub node: Vec<u32>,
    /// Where parts of the inside touch.
    pub touching: Vec<DVec3>,
}

/// The boundary of what `inside` says of the bodies that a point is in, one truth value each.
///
/// *Guarantees*: the bodies' surfaces are cut where they meet, by exact predicates; where they coincide each place counts once.
/// Points of intersection are rounded to doubles. Same bytes for any number of threads.
///
/// `None` where rounding keeps the triangles from fitting together.
///
/// # Errors
/// [`Error::Usage`] for more than [`MOST_BODIES`] bodies, or if `inside` holds outside of all: the result has no end then;
/// [`Error::Cancelled`].
pub fn boolean(bodies: &[&TriMesh], inside: &dyn Fn(&[bool]) -> bool, run: &Run) -> Result<Option<Joined>> {
    if bodies.len() > MOST_BODIES {
        let what = format!("{} bodies: a set operation takes {MOST_BODIES} at most", bodies.len());
        return Err(Error::Usage(what));
    }
    if inside(&vec![false; bodies.len()]) {
        return Err(Error::Usage("the result of the set operations has no end".into()));
    }
    let mut nodes: Vec<DVec3> = Vec::new();
    let mut triangles: Vec<([u32; 3], Uses)> = Vec::new();
    for (b, body) in bodies.iter().enumerate() {
        let start = nodes.len() as u32;
        nodes.extend(body.nodes.iter().copied());
        for t in &body.triangles {
            let mut uses = Uses { along: 1, label: triangles.len() as u32, ..Uses::default() };
            uses.jumps[b] = 1;
            triangles.push((t.map(|v| v + start), uses));
        }
    }
    let (known, original) = (nodes.len() as u32, triangles.iter().map(|t| t.0).collect::<Vec<_>>());
    let diagonal = Aabb::around(nodes.iter().copied()).diagonal();
    let mut complex = Complex::new(nodes, triangles);
    // Nodes of several bodies at one place are one.
    merge_near(&mut complex, 0.0);
    let Some(complex) = arrange(complex, diagonal, run)? else { return Ok(None) };
    run.check()?;
    let sides = Sides::of(&complex.triangles);
    let (of, count) = pieces(complex.triangles.len(), &sides, |e| {
        let [a, b] = e else { return false };
        let (u, v) = (&complex.uses[a.triangle()], &complex.uses[b.triangle()]);
        let turned = directed(&complex.triangles, a.half) == directed(&complex.triangles, b.half);
        !turned && u.jumps == v.jumps
    });
    let patches = Patches { of: &of, count };
    let mut numbers: Vec<Vec<i32>> = Vec::with_capacity(bodies.len());
    for b in 0..bodies.len() {
        numbers.push(behind(&complex, &sides, &patches, &|u| i32::from(u.jumps[b]), run)?);
    }
    let mut copies = Vec::new();
    let mut state = vec![false; bodies.len()];
    for (t, uses) in complex.uses.iter().enumerate() {
        let mut at = |front: bool| {
            for (b, s) in state.iter_mut().enumerate() {
                *s = numbers[b][t] - if front { i32::from(uses.jumps[b]) } else { 0 } > 0;
            }
            inside(&state)
        };
        let (back, front) = (at(false), at(true));
        if back != front {
            copies.push(Copy { triangle: t as u32, turned: front, level: 1, plate: false });
        }
    }
    let Some(fans) = join(&complex, &sides, &copies) else { return Ok(None) };
    let (mut mesh, origin) = build(&complex, &copies, &fans, &[]);
    let from = std::mem::take(&mut mesh.labels);
    // Rounding may have moved nodes by a last place, but hardly turned a triangle around.
    let area = |t: [u32; 3]| {
        let [a, b, c] = t.map(|v| complex.nodes[v as usize]);
        (b - a).cross(c - a)
    };
    let along = |c: &Copy, from: u32| {
        let now = area(complex.triangles[c.triangle as usize]);
        now.dot(area(original[from as usize])) >= 0.0
    };
    let turned = copies.iter().zip(&from).map(|(c, f)| c.turned == along(c, *f)).collect();
    mesh.labels = vec![0; mesh.triangles.len()];
    let mut seen = vec![false; complex.nodes.len()];
    let mut touching = Vec::new();
    for v in &origin {
        if std::mem::replace(&mut seen[*v as usize], true) {
            touching.push(complex.nodes[*v as usize]);
        }
    }
    let node = origin.into_iter().map(|v| if v < known { v } else { u32::MAX }).collect();
    Ok(Some(Joined { mesh, from, turned, node, touching }))
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::abs_diff_eq;

    /// A box of twelve triangles.
    fn cuboid(lo: [f64; 3], hi: [f64; 3]) -> TriMesh {
        let at = |k: usize| DVec3::from_array(std::array::from_fn(|i| if k >> i & 1 == 1 { hi[i] } else { lo[i] }));
        let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let triangles = quads.iter().flat_map(|q| [[q[0], q[1], q[2]], [q[0], q[2], q[3]]]).collect();
        TriMesh::new((0..8).map(at).collect(), triangles)
    }

    fn is_sound(m: &TriMesh) -> bool {
        let d = m.defects();
        d.is_closed() && d.is_manifold() && d.is_oriented()
    }

    #[test]
    fn boxes_have_the_volumes_and_areas_of_their_set_operations() {
        let a = cuboid([0.0; 3], [2.0; 3]);
        type Inside = fn(&[bool]) -> bool;
        let all: [(Inside, usize); 3] = [(|i| i[0] || i[1], 0), (|i| i[0] && i[1], 1), (|i| i[0] && !i[1], 2)];
        // Across a corner; flush with a side; on a side from outside; within; the same box.
        let cases = [
            (cuboid([1.0; 3], [3.0; 3]), [15.0, 1.0, 7.0], [42.0, 6.0, 24.0]),
            (cuboid([1.0, 0.5, 0.5], [2.0, 1.5, 1.5]), [8.0, 1.0, 7.0], [24.0, 6.0, 28.0]),
            (cuboid([2.0, 0.5, 0.5], [3.0, 1.5, 1.5]), [9.0, 0.0, 8.0], [28.0, 0.0, 24.0]),
            (cuboid([2.0, 0.0, 0.0], [4.0, 2.0, 2.0]), [16.0, 0.0, 8.0], [40.0, 0.0, 24.0]),
            (cuboid([0.5; 3], [1.5; 3]), [8.0, 1.0, 7.0], [24.0, 6.0, 30.0]),
            (cuboid([0.0; 3], [2.0; 3]), [8.0, 8.0, 0.0], [24.0, 24.0, 0.0]),
        ];
        for (b, volumes, areas) in &cases {
            for (inside, k) in all {
                let made = boolean(&[&a, b], &inside, &Run::new()).unwrap().unwrap();
                assert!(abs_diff_eq!(made.mesh.volume(), volumes[k], epsilon = 1e-12), "{b:?} {k}");
                assert!(abs_diff_eq!(made.mesh.area(), areas[k], epsilon = 1e-12), "{b:?} {k}");
                assert!(made.mesh.triangles.is_empty() || is_sound(&made.mesh));
                assert!(made.touching.is_empty());
            }
        }
    }

    #[test]
    fn boxes_that_touch_along_an_edge_get_nodes_of_their_own() {
        let (a, b) = (cuboid([0.0; 3], [1.0; 3]), cuboid([1.0, 1.0, 0.0], [2.0, 2.0, 1.0]));
        let made = boolean(&[&a, &b], &|i| i[0] || i[1], &Run::new()).unwrap().unwrap();
        assert!(is_sound(&made.mesh) && made.mesh.nodes.len() == 16 && made.touching.len() == 2);
    }

    #[test]
    fn what_has_no_end_and_too_many_bodies_are_refused() {
        let a = cuboid([0.0; 3], [1.0; 3]);
        assert!(boolean(&[&a], &|i| !i[0], &Run::new()).is_err());
        assert!(boolean(&[&a; MOST_BODIES + 1], &|i| i[0], &Run::new()).is_err());
    }
}
