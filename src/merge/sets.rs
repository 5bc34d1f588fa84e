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

/// One element and a progression after it, and which number the element has in its union.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Part {
    begin: u32,
    head: u32,
    /// What element `i` of the union would be if `i` were after the head: `offset + step i`.
    offset: u32,
    step: i32,
}

/// Parts up to which looking at each of them is quicker than a search.
const FEW: usize = 6;

/// Many unions, kept one after the other. Each is a union of pairs: a single element (where an edge of a loop begins), and
/// a progression (what is inside that edge).
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Unions {
    parts: Vec<Part>,
    /// For each union where its parts end, and how many elements it has.
    ends: Vec<(u32, u32)>,
    growing: u32,
}

impl Unions {
    /// Joins an element and a progression to the union that is being built.
    pub fn join(&mut self, head: u32, tail: Progression) {
        let begin = self.growing;
        let offset = tail.first.wrapping_sub((tail.step as u32).wrapping_mul(begin.wrapping_add(1)));
        self.parts.push(Part { begin, head, offset, step: tail.step });
        self.growing += 1 + tail.len;
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

    /// Element `i` of a union; beyond the end it is something, of an empty union 0.
    #[inline]
    pub fn get(&self, union: usize, i: u32) -> u32 {
        let mut parts = self.parts(union);
        // not branches: which way a search turns cannot be predicted
        while parts.len() > FEW {
            let (low, high) = parts.split_at(parts.len() / 2);
            parts = select_unpredictable(high[0].begin <= i, high, low);
        }
        let Some((_, later)) = parts.split_first() else { return 0 };
        let found = parts[later.iter().map(|part| usize::from(part.begin <= i)).sum::<usize>()];
        let in_tail = found.offset.wrapping_add((found.step as u32).wrapping_mul(i));
        select_unpredictable(i == found.begin, found.head, in_tail)
    }

    /// How many elements a union has.
    pub fn len(&self, union: usize) -> usize {
        self.ends[union].1 as usize
    }

    /// Replaces the contents of `list` by the elements of a union.
    #[inline]
    pub fn list(&self, union: usize, list: &mut Vec<u32>) {
        list.clear();
        let parts = self.parts(union);
        for (k, part) in parts.iter().enumerate() {
            let end = parts.get(k + 1).map_or(self.ends[union].1, |next| next.begin);
            list.push(part.head);
            list.extend((part.begin + 1..end).map(|i| part.offset.wrapping_add((part.step as u32).wrapping_mul(i))));
        }
    }
}
