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

/// Pieces whose beginnings are compared at a time.
const LANES: usize = 8;

/// Numbers on a line: element `i` of the union is `offset + step i`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct NumberLine {
    offset: u32,
    /// 1, -1 or 0, to wrap around.
    step: u32,
}

impl NumberLine {
    /// The line of a progression whose first element is number `begin` of the union.
    fn new(s: Progression, begin: u32) -> Self {
        let step = s.step as u32;
        Self { offset: s.first.wrapping_sub(step.wrapping_mul(begin)), step }
    }

    #[inline]
    fn get(self, i: u32) -> u32 {
        self.offset.wrapping_add(self.step.wrapping_mul(i))
    }
}

/// Where a union's pieces stand among those of all.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct Place {
    /// The lanes its beginnings are in.
    lanes: [u32; 2],
    line: u32,
}

/// Many unions, kept one after the other. Each is a union of pairs: a single element (where an edge of a loop begins), and
/// a progression (what is inside that edge); and at last of one progression more.
///
/// A face of four edges has nine pieces, and where all but the first begin fits into half a line of the cache: they are
/// compared all at once, without a branch that nobody could predict.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Unions {
    /// Where the pieces of a union begin, but for the first, filled up with the largest number.
    begins: Vec<[u32; LANES]>,
    lines: Vec<NumberLine>,
    /// For each union where its lanes and its lines end.
    ends: Vec<[u32; 2]>,
    growing: u32,
    /// Pieces of the union that is being built.
    pieces: usize,
}

impl Unions {
    fn push(&mut self, piece: Progression) {
        if let Some(k) = self.pieces.checked_sub(1) {
            if k.is_multiple_of(LANES) {
                self.begins.push([u32::MAX; LANES]);
            }
            if let Some(lanes) = self.begins.last_mut() {
                lanes[k % LANES] = self.growing;
            }
        }
        self.lines.push(NumberLine::new(piece, self.growing));
        self.pieces += 1;
        self.growing += piece.len;
    }

    /// Joins an element and a progression to the union that is being built.
    pub fn join(&mut self, head: u32, tail: Progression) {
        self.push(Progression { first: head, len: 1, step: 0 });
        self.push(tail);
    }

    /// Ends the union that is being built by the numbers from `rest` on, as many as anybody asks for; the next
    /// [`join`](Self::join) begins another. Returns how many elements came before.
    pub fn finish(&mut self, rest: u32) -> u32 {
        let begin = self.growing;
        self.push(Progression::ascending(rest, 0));
        self.ends.push([self.begins.len() as u32, self.lines.len() as u32]);
        (self.growing, self.pieces) = (0, 0);
        begin
    }

    /// Forgets all unions and keeps the memory.
    pub fn clear(&mut self) {
        (self.growing, self.pieces) = (0, 0);
        self.begins.clear();
        self.lines.clear();
        self.ends.clear();
    }

    /// Where a union stands among all, for [`get_of`](Self::get_of).
    pub(super) fn place(&self, union: usize) -> Place {
        let [first, line] = if union == 0 { [0; 2] } else { self.ends[union - 1] };
        Place { lanes: [first, self.ends[union][0]], line }
    }

    /// Element `i` of a union.
    #[inline]
    pub fn get(&self, union: usize, i: u32) -> u32 {
        self.get_of(self.place(union), i)
    }

    /// Element `i` of the union that stands at a [`place`](Self::place).
    #[inline]
    pub(super) fn get_of(&self, Place { lanes: [begin, end], line }: Place, i: u32) -> u32 {
        let mut lanes = &self.begins[begin as usize..end as usize];
        let mut found = line as usize;
        // not branches: which way a search turns cannot be predicted
        while lanes.len() > 1 {
            let half = lanes.len() / 2;
            let (low, high) = lanes.split_at(half);
            let later = high[0][0] <= i;
            lanes = select_unpredictable(later, high, low);
            found += select_unpredictable(later, LANES * half, 0);
        }
        if let [lanes] = lanes {
            found += lanes.iter().map(|begin| u32::from(*begin <= i)).sum::<u32>() as usize;
        }
        self.lines[found].get(i)
    }

    /// Puts the elements of a union, without the last progression, where `list` begins, which becomes as long as that takes
    /// and a little longer. Returns how many there are.
    #[inline]
    pub(super) fn fill(&self, union: usize, list: &mut Vec<u32>) -> usize {
        let Place { lanes: [first, last], line } = self.place(union);
        let lines = &self.lines[line as usize..self.ends[union][1] as usize];
        let begins = self.begins[first as usize..last as usize].as_flattened();
        let Some(border) = lines.len().checked_sub(2).map(|k| begins[k] as usize) else { return 0 };
        if list.len() < border + LANES {
            list.resize(border + LANES, 0);
        }
        let mut begin = 0;
        for (line, end) in lines.iter().zip(begins) {
            // beyond the end of the piece, too: the next one follows
            let mut at = begin;
            while at < *end as usize {
                let value = line.get(at as u32);
                if let Some(eight) = list[at..].first_chunk_mut::<LANES>() {
                    *eight = std::array::from_fn(|k| value.wrapping_add(line.step.wrapping_mul(k as u32)));
                }
                at += LANES;
            }
            begin = *end as usize;
            if begin == border {
                break;
            }
        }
        border
    }

    /// Replaces the contents of `list` by the elements of a union, without the last progression.
    pub fn list(&self, union: usize, list: &mut Vec<u32>) {
        let count = self.fill(union, list);
        list.truncate(count);
    }
}
