//! Questions side by side, so that what they ask of fields is asked together.
//!
//! A search, such as Newton's method for a node, asks a field for one point at a time, and the next point follows from the answer.
//! Of many searches each goes on until it asks for what is not known; then all such points are asked for in one call, and the
//! searches begin again with what is known by then. They are cheap beside a call into another language. A search gives the same
//! bits as alone, and no point is asked for twice.

use std::cell::RefCell;
use std::sync::Arc;

use glam::DVec3;
use rayon::prelude::*;
use rustc_hash::FxHashMap;

use super::field::{Between, Field, UNBOUNDED};
use super::leaf::Leaf;
use crate::spatial::Aabb;

/// Questions of one thread that wait for each other: with a point each, batches are twice the 512 points with which calls of numpy
/// are cheap. More would leave threads without work on small meshes.
const MANY: usize = 1024;

/// Where nothing waits threads share the work in such portions.
const FEW: usize = 64;

thread_local! {
    /// What the questions of this thread wait for, while there are some.
    static ROUND: RefCell<Option<Round>> = const { RefCell::new(None) };
}

/// Answers for keys; `None` where the answer is yet to come.
struct Answers<K, Q, A> {
    known: FxHashMap<K, Option<A>>,
    open: Vec<(K, Q)>,
}

impl<K, Q, A> Default for Answers<K, Q, A> {
    fn default() -> Self {
        Self { known: FxHashMap::default(), open: Vec::new() }
    }
}

impl<K: Copy + Eq + std::hash::Hash, Q, A: Copy> Answers<K, Q, A> {
    /// The answer if there is one; else it is to come.
    fn ask(&mut self, key: K, question: Q) -> Option<A> {
        match self.known.get(&key) {
            Some(known) => *known,
            None => {
                self.known.insert(key, None);
                self.open.push((key, question));
                None
            }
        }
    }

    /// Has all open questions answered at once.
    fn settle(&mut self, answer: impl FnOnce(Vec<Q>) -> Vec<A>) {
        if self.open.is_empty() {
            return;
        }
        let (keys, questions): (Vec<K>, Vec<Q>) = std::mem::take(&mut self.open).into_iter().unzip();
        for (key, a) in keys.into_iter().zip(answer(questions)) {
            self.known.insert(key, Some(a));
        }
    }
}

type Bits = [u64; 3];

fn bits(p: DVec3) -> Bits {
    p.to_array().map(f64::to_bits)
}

/// What is asked of one field.
struct Asked {
    field: Arc<dyn Field>,
    values: Answers<Bits, DVec3, f64>,
    slopes: Answers<Bits, DVec3, (f64, DVec3)>,
    ranges: Answers<[Bits; 2], Aabb, Between>,
}

impl Asked {
    fn settle(&mut self) {
        let field = &self.field;
        self.values.settle(|points| {
            let mut out = vec![f64::NAN; points.len()];
            field.values(&points, &mut out);
            out
        });
        self.slopes.settle(|points| {
            let (mut v, mut g) = (vec![f64::NAN; points.len()], vec![DVec3::NAN; points.len()]);
            field.gradients(&points, &mut v, &mut g);
            v.into_iter().zip(g).collect()
        });
        self.ranges.settle(|cells| {
            let mut out = vec![UNBOUNDED; cells.len()];
            field.ranges(&cells, &mut out);
            out
        });
    }
}

/// What is known and asked so far.
#[derive(Default)]
struct Round {
    fields: Vec<Asked>,
    /// Whether the question at hand asked for what is not known: it is then over, and nothing more is asked for its sake.
    missing: bool,
}

impl Round {
    fn of(&mut self, field: &Arc<dyn Field>) -> &mut Asked {
        let k = self.fields.iter().position(|a| Arc::ptr_eq(&a.field, field)).unwrap_or_else(|| {
            let (values, slopes, ranges) = (Answers::default(), Answers::default(), Answers::default());
            self.fields.push(Asked { field: field.clone(), values, slopes, ranges });
            self.fields.len() - 1
        });
        &mut self.fields[k]
    }
}

/// Whether the question at hand found something for want of an answer: that is to be dropped.
pub(super) fn is_missing() -> bool {
    ROUND.with_borrow(|round| round.as_ref().is_some_and(|r| r.missing))
}

/// Asks what a round knows; `None` where there is no round or the field is not asked in batches.
fn in_round<T>(field: &Arc<dyn Field>, lost: T, ask: impl FnOnce(&mut Asked) -> Option<T>) -> Option<T> {
    if !field.in_batches() {
        return None;
    }
    ROUND.with_borrow_mut(|round| {
        let round = round.as_mut()?;
        if round.missing {
            return Some(lost);
        }
        let found = ask(round.of(field));
        round.missing = found.is_none();
        Some(found.unwrap_or(lost))
    })
}

/// [`Field::values`]; in a round, NaN where they are yet to come.
pub(super) fn values(field: &Arc<dyn Field>, points: &[DVec3], out: &mut [f64]) {
    let found = in_round(field, false, |asked| {
        let mut all = Some(true);
        for (v, p) in out.iter_mut().zip(points) {
            match asked.values.ask(bits(*p), *p) {
                Some(known) => *v = known,
                None => all = None,
            }
        }
        all
    });
    match found {
        Some(true) => {}
        Some(false) => out.fill(f64::NAN),
        None => field.values(points, out),
    }
}

/// [`Field::value`]; in a round, NaN where it is yet to come.
pub(super) fn value(field: &Arc<dyn Field>, p: DVec3) -> f64 {
    let known = in_round(field, f64::NAN, |asked| asked.values.ask(bits(p), p));
    known.unwrap_or_else(|| field.value(p))
}

/// [`Field::gradients`]; in a round, NaN where they are yet to come.
pub(super) fn slopes(field: &Arc<dyn Field>, points: &[DVec3], values: &mut [f64], gradients: &mut [DVec3]) {
    let found = in_round(field, false, |asked| {
        let mut all = Some(true);
        for (k, p) in points.iter().enumerate() {
            match asked.slopes.ask(bits(*p), *p) {
                Some(known) => (values[k], gradients[k]) = known,
                None => all = None,
            }
        }
        all
    });
    match found {
        Some(true) => {}
        Some(false) => {
            values.fill(f64::NAN);
            gradients.fill(DVec3::NAN);
        }
        None => field.gradients(points, values, gradients),
    }
}

/// [`Field::range`]; in a round, no bounds where they are yet to come.
pub(super) fn range(field: &Arc<dyn Field>, cell: &Aabb) -> Between {
    let key = [bits(cell.lo), bits(cell.hi)];
    in_round(field, UNBOUNDED, |asked| asked.ranges.ask(key, *cell)).unwrap_or_else(|| field.range(cell))
}

/// Takes the round away whatever happens.
struct Ends;

impl Drop for Ends {
    fn drop(&mut self) {
        ROUND.set(None);
    }
}

/// Answers questions by number on this thread, fields asked for all of them together.
///
/// A question must depend on nothing but its number, and must not hand work to other threads. What it gives where a field gave
/// NaN for want of an answer is dropped.
pub(crate) fn together<R>(count: usize, mut question: impl FnMut(usize) -> R) -> Vec<R> {
    // Within a question the round at hand goes on.
    if count < 2 || ROUND.with_borrow(Option::is_some) {
        return (0..count).map(question).collect();
    }
    let ends = Ends;
    let mut out: Vec<Option<R>> = (0..count).map(|_| None).collect();
    let mut waiting: Vec<usize> = (0..count).collect();
    let mut round = Round::default();
    while !waiting.is_empty() {
        round.missing = false;
        ROUND.set(Some(round));
        waiting.retain(|i| {
            let found = question(*i);
            let waits = ROUND.with_borrow_mut(|r| r.as_mut().is_some_and(|r| std::mem::take(&mut r.missing)));
            if !waits {
                out[*i] = Some(found);
            }
            waits
        });
        // Fields may themselves be made of what has rounds.
        round = ROUND.take().unwrap_or_default();
        round.fields.iter_mut().for_each(Asked::settle);
    }
    drop(ends);
    out.into_iter().flatten().collect()
}

/// Answers a question for each item, on all threads, in the order of the items; what [waits](Leaf::waits) is asked for together.
pub(crate) fn each<I: Sync, R: Send>(leaves: &[Leaf], items: &[I], question: impl Fn(&I) -> R + Sync) -> Vec<R> {
    each_with(leaves, items, |(), i| question(i))
}

/// The same with memory that is kept from one item to the next.
pub(crate) fn each_with<S: Default, I: Sync, R: Send>(
    leaves: &[Leaf],
    items: &[I],
    question: impl Fn(&mut S, &I) -> R + Sync,
) -> Vec<R> {
    let portion = if leaves.iter().any(Leaf::waits) { MANY } else { FEW };
    let answers = |some: &[I]| {
        let mut kept = S::default();
        together(some.len(), |i| question(&mut kept, &some[i]))
    };
    let parts: Vec<Vec<R>> = items.par_chunks(portion).map(answers).collect();
    parts.into_iter().flatten().collect()
}
