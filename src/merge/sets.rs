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

impl Part {
    #[inline]
    fn after_head(self, i: u32) -> u32 {
        self.offset.wrapping_add((self.step as u32).wrapping_mul(i))
    }
}

/// Parts up to which looking at each of them is quicker than a search.
const FEW: usize = 8;

/// Many unions, kept one after the other. Each is a union of pairs: a single element (where an edge of a loop begins), and
/// a progression (what is inside that edge); and at last of one progression more.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Unions {
    parts: Vec<Part>,
    /// For each union where its parts end.
    ends: Vec<u32>,
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

    /// Ends the union that is being built by the numbers from `rest` on, as many as anybody asks for; the next
    /// [`join`](Self::join) begins another. Returns how many elements came before.
    pub fn finish(&mut self, rest: u32) -> u32 {
        let begin = self.growing;
        self.parts.push(Part { begin, head: rest, offset: rest.wrapping_sub(begin), step: 1 });
        self.ends.push(self.parts.len() as u32);
        self.growing = 0;
        begin
    }

    /// Forgets all unions and keeps the memory.
    pub fn clear(&mut self) {
        (self.growing, _) = (0, (self.parts.clear(), self.ends.clear()));
    }

    /// Where the parts of a union stand among all, for [`get_of`](Self::get_of).
    pub(super) fn span(&self, union: usize) -> [u32; 2] {
        [if union == 0 { 0 } else { self.ends[union - 1] }, self.ends[union]]
    }

    #[inline]
    fn parts(&self, [begin, end]: [u32; 2]) -> &[Part] {
        &self.parts[begin as usize..end as usize]
    }

    /// Element `i` of a union.
    #[inline]
    pub fn get(&self, union: usize, i: u32) -> u32 {
        self.get_of(self.span(union), i)
    }

    /// Element `i` of the union that stands at a [`span`](Self::span).
    #[inline]
    pub(super) fn get_of(&self, span: [u32; 2], i: u32) -> u32 {
        let mut parts = self.parts(span);
        // not branches: which way a search turns cannot be predicted
        while parts.len() > FEW {
            let (low, high) = parts.split_at(parts.len() / 2);
            parts = select_unpredictable(high[0].begin <= i, high, low);
        }
        let Some((_, later)) = parts.split_first() else { return 0 };
        let found = parts[later.iter().map(|part| usize::from(part.begin <= i)).sum::<usize>()];
        select_unpredictable(i == found.begin, found.head, found.after_head(i))
    }

    /// Replaces the contents of `list` by the elements of a union, without the last progression.
    #[inline]
    pub fn list(&self, union: usize, list: &mut Vec<u32>) {
        let Some((last, parts)) = self.parts(self.span(union)).split_last() else { return list.clear() };
        list.resize(last.begin as usize, 0);
        let mut left = &mut list[..];
        for (k, part) in parts.iter().enumerate() {
            let end = parts.get(k + 1).unwrap_or(last).begin;
            let (own, rest) = left.split_at_mut((end - part.begin) as usize);
            left = rest;
            for (x, i) in own.iter_mut().zip(part.begin..) {
                *x = part.after_head(i);
            }
            if let Some(first) = own.first_mut() {
                *first = part.head;
            }
        }
    }
}
