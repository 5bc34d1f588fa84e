//! Edges of a triangle soup and the triangle sides that lie on them.

use crate::numeric::Sets;

/// One side of a triangle on an undirected edge. `half = 3 t + k` runs from corner `k` to corner `k + 1` of triangle `t`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct EdgeSide {
    pub(super) key: u64,
    pub(super) half: u32,
}

impl EdgeSide {
    pub(super) fn triangle(self) -> usize {
        (self.half / 3) as usize
    }
}

/// The undirected edge between two nodes as one number.
pub(super) fn key(a: u32, b: u32) -> u64 {
    u64::from(a.min(b)) << 32 | u64::from(a.max(b))
}

/// Both ends of an edge, the smaller first.
pub(super) fn ends(key: u64) -> [u32; 2] {
    [(key >> 32) as u32, key as u32]
}

/// Start and end of a side, as its triangle runs.
pub(super) fn directed(triangles: &[[u32; 3]], half: u32) -> [u32; 2] {
    let t = triangles[(half / 3) as usize];
    let k = (half % 3) as usize;
    [t[k], t[(k + 1) % 3]]
}

/// All sides, sorted by edge.
#[derive(Debug, Clone, Default)]
pub(super) struct Sides(Vec<EdgeSide>);

impl Sides {
    pub(super) fn of(triangles: &[[u32; 3]]) -> Self {
        let mut s = Vec::with_capacity(3 * triangles.len());
        for (t, tri) in triangles.iter().enumerate() {
            for k in 0..3 {
                s.push(EdgeSide { key: key(tri[k], tri[(k + 1) % 3]), half: (3 * t + k) as u32 });
            }
        }
        s.sort_unstable();
        Self(s)
    }

    /// The sides of each edge, edges ascending.
    pub(super) fn edges(&self) -> impl Iterator<Item = &[EdgeSide]> {
        self.0.chunk_by(|a, b| a.key == b.key)
    }

    /// Sides of edges of one triangle, ascending by edge.
    pub(super) fn open(&self) -> Vec<u32> {
        self.edges().filter(|e| e.len() == 1).map(|e| e[0].half).collect()
    }
}

/// Triangles joined over edges that `joins` accepts: the piece of each triangle, and how many pieces there are.
pub(super) fn pieces(triangles: usize, sides: &Sides, joins: impl Fn(&[EdgeSide]) -> bool) -> (Vec<u32>, usize) {
    let mut sets = Sets::new(triangles);
    for e in sides.edges().filter(|e| joins(e)) {
        for w in e.windows(2) {
            sets.join(w[0].half / 3, w[1].half / 3);
        }
    }
    sets.numbers()
}
