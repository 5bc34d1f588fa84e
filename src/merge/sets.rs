//! Sets in functional form (\[LAZ\] section 2): an element is computed from its number.
//!
//! What the merge needs of the paper's four operations keeps within one kind of set: numbers in arithmetic progression,
//! and unions of them. `Reverse` and `ExcludeBounds` of a progression are progressions, so is the selection of one from
//! another, and a union looks up the part an element falls into.

use std::hint::select_unpredictable;

/// The numbers `first`, `first + step`, ...: `len` of them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Progression {
    /// The first number.
    pub first: u32,
    /// How many there are.
    pub len: u32,
    /// 1 for numbers in a row, -1 for numbers in reverse, 0 for one number again and again (the nodes of a pole).
    pub step: i32,
}

impl Progression {
    /// `first..first + len`.
    pub fn ascending(first: u32, len: u32) -> Self {
        Self { first, len, step: 1 }
    }

    /// Element `i`; beyond the end the progression goes on.
    #[inline]
    pub fn get(self, i: u32) -> u32 {
        self.first.wrapping_add((self.step as u32).wrapping_mul(i))
    }

    /// `Reverse`: the same elements from the last to the first.
    pub fn reverse(self) -> Self {
        Self { first: self.get(self.len.wrapping_sub(1)), len: self.len, step: -self.step }
    }

    /// `ExcludeBounds`: without the first and the last; nothing is left of two or fewer.
    pub fn exclude_bounds(self) -> Self {
        Self { first: self.get(1), len: self.len.saturating_sub(2), step: self.step }
    }

    /// Selection: the elements whose numbers `which` holds.
    pub fn select(self, which: Progression) -> Self {
        Self { first: self.get(which.first), len: which.len, step: self.step.wrapping_mul(which.step) }
    }
}

/// One progression of a [`Union`], and which number its first element has there.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Part {
    begin: u32,
    first: u32,
    step: i32,
}

/// Many unions of progressions, kept one after the other.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Unions {
    parts: Vec<Part>,
    /// For each union where its parts end, and how many elements it has.
    ends: Vec<(u32, u32)>,
    growing: u32,
}

impl Unions {
    /// Joins a progression to the union that is being built.
    pub fn join(&mut self, set: Progression) {
        if set.len > 0 {
            self.parts.push(Part { begin: self.growing, first: set.first, step: set.step });
            self.growing += set.len;
        }
    }

    /// Ends the union that is being built; the next [`join`](Self::join) begins another.
    pub fn finish(&mut self) {
        self.ends.push((self.parts.len() as u32, self.growing));
        self.growing = 0;
    }

    /// Forgets all unions and keeps the memory.
    pub fn clear(&mut self) {
        (self.growing, _) = (0, (self.parts.clear(), self.ends.clear()));
    }

    #[inline]
    fn parts(&self, union: usize) -> &[Part] {
        let begin = if union == 0 { 0 } else { self.ends[union - 1].0 as usize };
        &self.parts[begin..self.ends[union].0 as usize]
    }

    /// Element `i` of a union, which must be there.
    #[inline]
    pub fn get(&self, union: usize, i: u32) -> u32 {
        let mut parts = self.parts(union);
        while parts.len() > 1 {
            let (low, high) = parts.split_at(parts.len() / 2);
            // not a branch: which way a search turns cannot be predicted
            parts = select_unpredictable(high[0].begin <= i, high, low);
        }
        let part = &parts[0];
        part.first.wrapping_add((part.step as u32).wrapping_mul(i.wrapping_sub(part.begin)))
    }

    /// How many elements a union has.
    pub fn len(&self, union: usize) -> usize {
        self.ends[union].1 as usize
    }

    /// Replaces the contents of `list` by the elements of a union.
    pub fn list(&self, union: usize, list: &mut Vec<u32>) {
        list.clear();
        let parts = self.parts(union);
        for (k, part) in parts.iter().enumerate() {
            let end = parts.get(k + 1).map_or(self.ends[union].1, |next| next.begin);
            let set = Progression { first: part.first, len: end - part.begin, step: part.step };
            list.extend((0..set.len).map(|i| set.get(i)));
        }
    }
}
