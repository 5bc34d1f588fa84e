//! A field of lengths that grows from its sources at a bounded slope.

use glam::DVec3;

use super::Aabb;

/// Sources in a leaf.
const LEAF: usize = 8;

#[derive(Debug, Clone, Copy, PartialEq)]
struct Node {
    bounds: Aabb,
    /// The smallest value below.
    least: f64,
    /// First source of a leaf, or index of the right child (the left one follows its parent).
    start: u32,
    /// Sources of a leaf, 0 for an inner node.
    count: u32,
}

/// The largest function that is at most `h` at each source `(p, h)` and grows by at most `slope` per length:
/// f(x) = min over sources of h + slope |x - p|. Being a minimum it does not depend on the order of the sources.
#[derive(Debug, Clone, PartialEq)]
pub struct Graded {
    sources: Vec<(DVec3, f64)>,
    nodes: Vec<Node>,
    slope: f64,
}

impl Graded {
    /// The field of some sources. Those that others make superfluous are dropped.
    pub fn new(sources: Vec<(DVec3, f64)>, slope: f64) -> Self {
        let all = Self::built(sources, slope);
        let keep: Vec<(DVec3, f64)> = (0..all.sources.len())
            .filter(|&i| {
                let (p, h) = all.sources[i];
                // Another source that is smaller here, or as small and comes first, does the work of this one.
                !all.any_below(p, h, i)
            })
            .map(|i| all.sources[i])
            .collect();
        Self::built(keep, slope)
    }

    /// The field with more sources.
    pub fn with(mut self, more: Vec<(DVec3, f64)>) -> Self {
        self.sources.extend(more);
        Self::new(self.sources, self.slope)
    }

    fn built(mut sources: Vec<(DVec3, f64)>, slope: f64) -> Self {
        let mut nodes = Vec::with_capacity(2 * sources.len().div_ceil(LEAF) + 1);
        if !sources.is_empty() {
            build(&mut sources, 0, &mut nodes);
        }
        Self { sources, nodes, slope }
    }

    /// The value at a place, `most` where no source makes it smaller.
    pub fn at(&self, p: DVec3, most: f64) -> f64 {
        let mut best = most;
        let mut stack = [(0u32, f64::NEG_INFINITY); 64];
        let mut top = usize::from(!self.nodes.is_empty());
        while top > 0 {
            top -= 1;
            let (at, bound) = stack[top];
            if bound >= best {
                continue;
            }
            let node = &self.nodes[at as usize];
            if node.count > 0 {
                for (q, h) in &self.sources[node.start as usize..(node.start + node.count) as usize] {
                    best = best.min(h + self.slope * q.distance(p));
                }
            } else {
                let [a, b] = [at + 1, node.start].map(|n| (n, self.bound(&self.nodes[n as usize], p)));
                (stack[top], stack[top + 1]) = if a.1 <= b.1 { (b, a) } else { (a, b) };
                top += 2;
            }
        }
        best
    }

    /// How many sources count.
    pub fn len(&self) -> usize {
        self.sources.len()
    }

    /// Whether the field has no sources.
    pub fn is_empty(&self) -> bool {
        self.sources.is_empty()
    }

    fn bound(&self, node: &Node, p: DVec3) -> f64 {
        node.least + self.slope * node.bounds.distance_squared(p).sqrt()
    }

    fn any_below(&self, p: DVec3, h: f64, own: usize) -> bool {
        let mut stack = [0u32; 64];
        let mut top = 1;
        while top > 0 {
            top -= 1;
            let at = stack[top];
            let node = &self.nodes[at as usize];
            if self.bound(node, p) > h {
                continue;
            }
            if node.count == 0 {
                (stack[top], stack[top + 1]) = (node.start, at + 1);
                top += 2;
                continue;
            }
            for j in node.start as usize..(node.start + node.count) as usize {
                let (q, k) = self.sources[j];
                if (k < h || (k == h && j < own)) && k + self.slope * q.distance(p) <= h {
                    return true;
                }
            }
        }
        false
    }
}

fn build(sources: &mut [(DVec3, f64)], start: usize, nodes: &mut Vec<Node>) {
    let bounds = Aabb::around(sources.iter().map(|s| s.0));
    let least = sources.iter().fold(f64::INFINITY, |m, s| m.min(s.1));
    let at = nodes.len();
    nodes.push(Node { bounds, least, start: start as u32, count: sources.len() as u32 });
    if sources.len() <= LEAF {
        return;
    }
    let size = bounds.size();
    let axis = (0..3).max_by(|&a, &b| size[a].total_cmp(&size[b])).unwrap_or(0);
    let mid = sources.len() / 2;
    let key = |s: &(DVec3, f64)| (s.0[axis], s.0.x, s.0.y, s.0.z, s.1);
    sources.select_nth_unstable_by(mid, |a, b| {
        let (a, b) = (key(a), key(b));
        a.0.total_cmp(&b.0)
            .then(a.1.total_cmp(&b.1))
            .then(a.2.total_cmp(&b.2))
            .then(a.3.total_cmp(&b.3))
            .then(a.4.total_cmp(&b.4))
    });
    let (left, right) = sources.split_at_mut(mid);
    build(left, start, nodes);
    nodes[at].start = nodes.len() as u32;
    nodes[at].count = 0;
    build(right, start + mid, nodes);
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn the_field_is_the_minimum_over_all_sources(
            raw in prop::collection::vec((prop::array::uniform3(-1.0f64..1.0), 0.01f64..0.5), 0..120),
            q in prop::array::uniform3(-1.5f64..1.5), slope in 0.05f64..1.0,
        ) {
            let mut sources: Vec<(DVec3, f64)> = raw.iter().map(|(p, h)| (DVec3::from_array(*p), *h)).collect();
            // Equal sources must not drop each other.
            sources.extend(sources.first().copied());
            let q = DVec3::from_array(q);
            let truth = sources.iter().map(|(p, h)| h + slope * p.distance(q)).fold(0.6, f64::min);
            let field = Graded::new(sources.clone(), slope);
            prop_assert!((field.at(q, 0.6) - truth).abs() < 1e-12);
            prop_assert!(field.len() <= sources.len() && field.is_empty() == sources.is_empty());
            prop_assert!(sources.iter().all(|(p, h)| field.at(*p, 9.0) <= h + 1e-12));
        }
    }
}
