//! Vertices of a face at one place are made one.

use crate::numeric::ROUNDING;
use crate::parametric::brep::{Brep, Edge};
use crate::spatial::Aabb;

/// Makes vertices of one face that lie at one place one: contours that touch there are joined (\[BOR20\]).
pub(super) fn join_vertices(brep: &mut Brep) {
    let mut leader: Vec<u32> = (0..brep.vertices.len() as u32).collect();
    for f in &brep.faces {
        let mut own: Vec<u32> = f.loops.iter().flatten().flat_map(|c| brep.edges[c.edge as usize].ends).collect();
        own.sort_unstable();
        own.dedup();
        let at = |v: u32| brep.vertices[v as usize];
        let middle = |e: &Edge| e.curve.at(0.5 * (e.range[0] + e.range[1]));
        let middles = f.loops.iter().flatten().map(|c| middle(&brep.edges[c.edge as usize]));
        // Vertices of a face this near to each other are one.
        let near = ROUNDING * Aabb::around(own.iter().map(|v| at(*v)).chain(middles)).diagonal();
        own.sort_by(|a, b| at(*a).x.total_cmp(&at(*b).x).then(a.cmp(b)));
        for (i, &a) in own.iter().enumerate() {
            for &b in own[i + 1..].iter().take_while(|b| at(**b).x - at(a).x <= near) {
                if at(a).distance(at(b)) <= near {
                    let (x, y) = (first(&leader, a), first(&leader, b));
                    leader[x.max(y) as usize] = x.min(y);
                }
            }
        }
    }
    for e in &mut brep.edges {
        e.ends = e.ends.map(|v| first(&leader, v));
    }
}

fn first(leader: &[u32], mut v: u32) -> u32 {
    while leader[v as usize] != v {
        v = leader[v as usize];
    }
    v
}
