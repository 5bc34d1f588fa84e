//! The table of cell triangulations, each computed when first met: trace the loops, join the loops a tunnel joins,
//! triangulate. Most surfaces meet a few dozen of the hundreds of cases.

use std::sync::{LazyLock, OnceLock};

use super::geometry::{self, Patch, Triangle};
use super::{EDGES, FACE_CORNERS, INTERIOR_NODE, ambiguous_faces};

/// Triangulations of one pair of mask and face decisions.
pub(super) struct Entry {
    /// The case without a tunnel, then one for each tunnel.
    cases: Vec<Patch>,
    /// For each corner its boundary region, by the lowest corner of the region.
    pub(super) region: [u8; 8],
    /// The pairs of regions (by lowest corner, in increasing order) a tunnel can join.
    pub(super) tunnels: Vec<[u8; 2]>,
}

/// All cases. Only [`TABLE`] makes one.
pub(super) struct Table {
    ambiguous: [u8; 256],
    /// Entry of `mask * 64 + faces`, for `faces` with bits of ambiguous faces only.
    entries: Vec<OnceLock<Box<Entry>>>,
}

/// The table of the whole program.
pub(super) static TABLE: LazyLock<Table> = LazyLock::new(|| Table {
    ambiguous: std::array::from_fn(|mask| ambiguous_faces(mask as u8)),
    entries: (0..256 * 64).map(|_| OnceLock::new()).collect(),
});

impl Entry {
    fn new(mask: u8, faces: u8) -> Self {
        let loops = loops(mask, faces);
        let region = regions(mask, faces);
        let joins = joins(mask, faces, &region, &loops);
        let mut cases = vec![triangulate(&loops, None)];
        cases.extend(joins.iter().map(|join| triangulate(&loops, Some(join.loops))));
        Self { cases, region, tunnels: joins.iter().map(|j| j.regions).collect() }
    }
}

impl Table {
    /// The entry of a mask and face decisions; bits of `faces` that belong to unambiguous faces do not matter.
    pub(super) fn entry(&self, mask: u8, faces: u8) -> &Entry {
        let faces = faces & self.ambiguous[usize::from(mask)];
        self.entries[usize::from(mask) * 64 + usize::from(faces)].get_or_init(|| Box::new(Entry::new(mask, faces)))
    }

    /// Triangles and number of interior nodes; a tunnel the entry does not have counts as none.
    pub(super) fn case(&self, mask: u8, faces: u8, tunnel: u8) -> (&[Triangle], u8) {
        let cases = &self.entry(mask, faces).cases;
        let case = cases.get(usize::from(tunnel)).unwrap_or(&cases[0]);
        (&case.triangles, case.interior_nodes)
    }
}

/// The segments of face `f`, directed with the inside on the right as seen from outside the cube.
pub(super) fn face_segments(mask: u8, faces: u8, f: usize) -> Vec<[u8; 2]> {
    let corners = FACE_CORNERS[f];
    let inside = |k: usize| mask >> corners[k % 4] & 1 == 1;
    let edge = |k: usize| edge_between(corners[k % 4], corners[(k + 1) % 4]);
    let enters: Vec<usize> = (0..4).filter(|&k| !inside(k) && inside(k + 1)).collect();
    // Going round, the next way out closes the cut around the inside corners, the previous one that around the outside
    // corners; where there is one way in and one way out both are the same.
    let around_inside = faces >> f & 1 == 0;
    enters
        .iter()
        .map(|&k| {
            let leave = (1..4)
                .map(|d| if around_inside { k + d } else { k + 4 - d })
                .find(|&l| inside(l) && !inside(l + 1))
                .unwrap_or(k);
            [edge(k), edge(leave)]
        })
        .collect()
}

fn edge_between(a: u8, b: u8) -> u8 {
    let key = [a.min(b), a.max(b)];
    EDGES.iter().position(|e| *e == key).unwrap_or(0) as u8
}

/// The closed loops of crossings, each directed so that a disk with this boundary winds as the surface does.
pub(super) fn loops(mask: u8, faces: u8) -> Vec<Vec<u8>> {
    let mut next = [None; 12];
    for f in 0..6 {
        for [from, to] in face_segments(mask, faces, f) {
            next[usize::from(from)] = Some(to);
        }
    }
    let mut loops = Vec::new();
    for start in 0..12 {
        let mut nodes = Vec::new();
        let mut at = start;
        while let Some(to) = next[at].take() {
            nodes.push(at as u8);
            at = usize::from(to);
        }
        if !nodes.is_empty() {
            loops.push(nodes);
        }
    }
    loops
}

/// For each corner the lowest corner reachable through same-signed cube edges and across faces.
pub(super) fn regions(mask: u8, faces: u8) -> [u8; 8] {
    let inside = |c: u8| mask >> c & 1 == 1;
    let mut links: Vec<[u8; 2]> = EDGES.iter().copied().filter(|&[a, b]| inside(a) == inside(b)).collect();
    for (f, c) in FACE_CORNERS.iter().enumerate() {
        if ambiguous_faces(mask) >> f & 1 == 1 {
            let joined = faces >> f & 1 == 1;
            links.push(if inside(c[0]) == joined { [c[0], c[2]] } else { [c[1], c[3]] });
        }
    }
    let mut region: [u8; 8] = std::array::from_fn(|c| c as u8);
    // A region has at most eight corners, so seven sweeps carry the lowest number through it.
    for _ in 0..7 {
        for &[a, b] in &links {
            let low = region[usize::from(a)].min(region[usize::from(b)]);
            region[usize::from(a)] = low;
            region[usize::from(b)] = low;
        }
    }
    region
}

/// A tunnel that can occur: two regions of one sign, and the two loops which the annulus connects.
struct Join {
    regions: [u8; 2],
    loops: [usize; 2],
}

fn joins(mask: u8, faces: u8, region: &[u8; 8], loops: &[Vec<u8>]) -> Vec<Join> {
    // Both sides of a loop, outside first.
    let sides: Vec<[u8; 2]> = loops
        .iter()
        .map(|nodes| {
            let [a, b] = EDGES[usize::from(nodes[0])];
            let (a_side, b_side) = (region[usize::from(a)], region[usize::from(b)]);
            if mask >> a & 1 == 1 { [b_side, a_side] } else { [a_side, b_side] }
        })
        .collect();
    let mut joins = Vec::new();
    for i in 0..loops.len() {
        for j in i + 1..loops.len() {
            for sign in 0..2 {
                let [p, q] = [sides[i][sign], sides[j][sign]];
                if p != q && sides[i][1 - sign] == sides[j][1 - sign] && can_join(mask, faces, region, p, q) {
                    joins.push(Join { regions: [p.min(q), p.max(q)], loops: [i, j] });
                }
            }
        }
    }
    joins
}

/// Whether the signs of the corners let the slices along every axis join the regions `p` and `q` (module docs).
fn can_join(mask: u8, faces: u8, region: &[u8; 8], p: u8, q: u8) -> bool {
    let sign = mask >> p & 1;
    let ambiguous = ambiguous_faces(mask);
    let has = |c: usize| mask >> c & 1 == sign;
    (0..3).all(|axis| {
        let up = 1 << axis;
        let strands = super::strands(axis);
        let touches = |s: usize, r: u8| [s, s | up].into_iter().any(|c| has(c) && region[c] == r);
        (0..2).any(|d| {
            let [a, b, c, e] = [strands[d], strands[d + 1], strands[(d + 2) % 4], strands[(d + 3) % 4]];
            let ends_meet = (touches(a, p) && touches(c, q)) || (touches(a, q) && touches(c, p));
            let walls = [b, e].into_iter().all(|s| !has(s) || !has(s | up));
            // Two strands leaving through one end part for good unless both walls give way there.
            let leave = has(a) != has(a | up) && has(a) == has(c) && has(a | up) == has(c | up);
            let joined = |k: usize| {
                let f = super::side_face(axis, k % 4);
                ambiguous >> f & 1 == 1 && faces >> f & 1 == sign
            };
            let give_way = (joined(d) && joined(d + 3)) || (joined(d + 1) && joined(d + 2));
            let drift = leave && !give_way;
            ends_meet && walls && !drift
        })
    })
}

/// Triangulates all loops, the pair `tunnel` by an annulus and the others by disks.
fn triangulate(loops: &[Vec<u8>], tunnel: Option<[usize; 2]>) -> Patch {
    let mut all = Patch::default();
    let add = |all: &mut Patch, part: Patch| {
        all.triangles.extend(part.triangles);
        all.interior_nodes += part.interior_nodes;
    };
    for (i, nodes) in loops.iter().enumerate() {
        if tunnel.is_none_or(|pair| !pair.contains(&i)) {
            let part = geometry::disk(nodes, INTERIOR_NODE + all.interior_nodes);
            add(&mut all, part);
        }
    }
    if let Some([i, j]) = tunnel {
        let part = geometry::annulus(&loops[i], &loops[j], &all.triangles, INTERIOR_NODE + all.interior_nodes);
        add(&mut all, part);
    }
    all
}
