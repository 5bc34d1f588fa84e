//! Strips: two edges of a face that lie across from each other along their whole length get nodes that go together.

use std::collections::VecDeque;

/// Of two edges with nodes that go together one may be so many times longer than the other, or want so many times more parts.
pub(crate) const ALIKE: f64 = 1.3;
/// Edges across from each other along this share of their lengths go together.
pub(crate) const ALONG: f64 = 0.7;
/// Edges at most this many wanted lengths apart have one row of triangles between them.
pub(crate) const WIDEST: f64 = 1.3;
/// The way across a strip leads into the face from both of its borders: this is the least cosine of its angle with the normal of a
/// border within the face, some 70 degrees.
pub(crate) const INTO: f64 = 0.3;
/// The first node of an edge whose nodes lie between those of the other one, in parts: half a part would leave short edges beside
/// long ones at corners.
pub(crate) const FIRST: f64 = 0.75;
/// Fewer parts than this have nothing between them.
const FEWEST: usize = 2;

/// Two edges across from each other.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Pair {
    pub(crate) edges: [u32; 2],
    pub(crate) length: f64,
}

/// What an edge takes over from the one across.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Like {
    /// The number of its parts.
    parts: Option<usize>,
    /// Whether nodes shall lie between its nodes.
    between: bool,
}

impl Like {
    /// The number of parts of an edge that would like to have `own`.
    pub(crate) fn parts(&self, own: usize, least: usize) -> usize {
        let fits = |n: &usize| (*n as f64) < ALIKE * own as f64 + 1.0 && (own as f64) < ALIKE * *n as f64 + 1.0;
        self.parts.filter(fits).unwrap_or(own).max(least)
    }

    /// Where the nodes between the ends of an edge lie, in parts.
    pub(crate) fn places(&self, parts: usize) -> Vec<f64> {
        if !self.between || parts < FEWEST {
            return (1..parts).map(|k| k as f64).collect();
        }
        let first = FIRST.min(parts as f64 / 3.0);
        let place = |k: usize| (k as f64 + 0.5).clamp(first, parts as f64 - first);
        (0..parts).map(place).collect()
    }
}

/// Which edges go together: a forest in which every other edge has its nodes between those of its neighbors.
#[derive(Debug, Clone, Default)]
pub(crate) struct Strips {
    /// Edges, each after the one it follows.
    order: Vec<u32>,
    follows: Vec<Option<u32>>,
    /// The tree of every edge, and whether its nodes lie between those of its neighbors there.
    tree: Vec<u32>,
    between: Vec<bool>,
}

impl Strips {
    /// Of pairs that cannot all have their nodes between each other's, as three around a prism, the longer ones count.
    pub(crate) fn new(edges: usize, mut pairs: Vec<Pair>) -> Self {
        pairs.sort_by(|a, b| b.length.total_cmp(&a.length).then(a.edges.cmp(&b.edges)));
        let mut sets = crate::numeric::Sets::new(edges);
        let mut beside: Vec<Vec<u32>> = vec![Vec::new(); edges];
        for Pair { edges: [a, b], .. } in &pairs {
            if sets.find(*a) != sets.find(*b) {
                sets.join(*a, *b);
                beside[*a as usize].push(*b);
                beside[*b as usize].push(*a);
            }
        }
        let mut out = Self {
            order: Vec::with_capacity(edges),
            follows: vec![None; edges],
            tree: vec![u32::MAX; edges],
            between: vec![false; edges],
        };
        for e in 0..edges as u32 {
            if out.tree[e as usize] != u32::MAX {
                continue;
            }
            let mut queue = VecDeque::from([e]);
            out.tree[e as usize] = e;
            while let Some(a) = queue.pop_front() {
                out.order.push(a);
                for &b in &beside[a as usize] {
                    if out.tree[b as usize] == u32::MAX {
                        out.tree[b as usize] = e;
                        out.follows[b as usize] = Some(a);
                        out.between[b as usize] = !out.between[a as usize];
                        queue.push_back(b);
                    }
                }
            }
        }
        out
    }

    /// Whether the nodes of two edges lie between each other.
    pub(crate) fn holds(&self, [a, b]: [u32; 2]) -> bool {
        let (a, b) = (a as usize, b as usize);
        a != b && self.tree[a] == self.tree[b] && self.between[a] != self.between[b]
    }

    /// All edges, each after the one it follows, if any, and whether its nodes lie between those of that one where it does.
    pub(crate) fn order(&self) -> impl Iterator<Item = (u32, Option<u32>, bool)> {
        self.order.iter().map(|&e| (e, self.follows[e as usize], self.between[e as usize]))
    }

    /// Divides all edges: `divide` gives the parameters of an edge's nodes and, where it may be followed, the number of its parts.
    pub(crate) fn divided(&self, divide: impl Fn(u32, Like) -> (Vec<f64>, Option<usize>)) -> Vec<Vec<f64>> {
        let mut out = vec![Vec::new(); self.order.len()];
        let mut parts: Vec<Option<usize>> = vec![None; self.order.len()];
        for &e in &self.order {
            let known = self.follows[e as usize].and_then(|f| parts[f as usize]);
            // Where the one it follows goes its own way there is nothing to lie between.
            let between = self.between[e as usize] && known.is_some();
            (out[e as usize], parts[e as usize]) = divide(e, Like { parts: known, between });
        }
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn neighbors_along_a_chain_of_strips_alternate_and_have_as_many_parts() {
        let pair = |a, b, length| Pair { edges: [a, b], length };
        // Three strips side by side, and a prism of three, whose shortest pair cannot go together.
        let s =
            Strips::new(8, vec![pair(0, 2, 1.0), pair(2, 1, 1.0), pair(4, 5, 2.0), pair(5, 6, 2.0), pair(4, 6, 1.0)]);
        assert!(s.holds([0, 2]) && s.holds([1, 2]) && !s.holds([0, 1]));
        assert!(s.holds([4, 5]) && s.holds([5, 6]) && !s.holds([4, 6]));
        assert!(!s.holds([3, 7]) && !s.holds([3, 3]) && !s.holds([0, 4]));
        let wish = |e: u32| 5 + e as usize;
        let made = s.divided(|e, like| {
            let parts = like.parts(wish(e), 1);
            (like.places(parts), Some(parts))
        });
        assert_eq!(made[0], [1.0, 2.0, 3.0, 4.0]);
        assert_eq!(made[2], [0.75, 1.5, 2.5, 3.5, 4.25]);
        assert_eq!((made[1].len(), made[3].len(), made[7].len()), (4, 7, 11));
    }

    #[test]
    fn an_edge_goes_its_own_way_where_the_other_has_far_more_parts() {
        let like = Like { parts: Some(20), between: false };
        assert_eq!((like.parts(18, 1), like.parts(9, 1), like.parts(19, 30)), (20, 9, 30));
        assert_eq!(Like { parts: Some(1), between: true }.places(1), [] as [f64; 0]);
        assert_eq!(Like { parts: Some(2), between: true }.places(2), [2.0 / 3.0, 2.0 - 2.0 / 3.0]);
    }
}
