//! Disjoint sets of numbers (R. Tarjan 1975), with halved paths.

/// Sets that are joined step by step; the smallest member stands for its set.
#[derive(Debug, Clone)]
pub(crate) struct Sets(Vec<u32>);

impl Sets {
    /// Every member of `n` in a set of its own.
    pub(crate) fn new(n: usize) -> Self {
        Self((0..n as u32).collect())
    }

    /// The smallest member of the set of one.
    pub(crate) fn find(&mut self, mut i: u32) -> u32 {
        while self.0[i as usize] != i {
            self.0[i as usize] = self.0[self.0[i as usize] as usize];
            i = self.0[i as usize];
        }
        i
    }

    /// Makes one set of those of two members.
    pub(crate) fn join(&mut self, a: u32, b: u32) {
        let (a, b) = (self.find(a), self.find(b));
        self.0[a.max(b) as usize] = a.min(b);
    }

    /// For each member the number of its set, counted from 0 in the order of their smallest members; and how many there are.
    pub(crate) fn numbers(&mut self) -> (Vec<u32>, usize) {
        let mut out = vec![u32::MAX; self.0.len()];
        let mut count = 0;
        for i in 0..self.0.len() as u32 {
            let root = self.find(i) as usize;
            if root == i as usize {
                out[root] = count;
                count += 1;
            }
            out[i as usize] = out[root];
        }
        (out, count as usize)
    }
}
