//! Where a part file makes which solid: errors that are known only of the whole solid point at the operand at fault.

use std::sync::Arc;

use ruff_text_size::TextRange;
use rustc_hash::FxHashMap;

use super::{Part, place};
use crate::error::{Error, NoBody, Place};
use crate::implicit::solid::{Solid, SolidNode};
use crate::implicit::{Implicit, RSystem};

/// How many solids are looked at for the one at fault: each is lowered with all that it is made of.
const LOOKS: usize = 64;

/// The ranges of a part file's text that made solids.
#[derive(Debug, Clone, Default)]
pub(crate) struct Origins {
    source: Arc<str>,
    /// By the address of a node, with the solid, which keeps the node there.
    known: FxHashMap<usize, (Solid, TextRange)>,
    /// Where `part(...)` stands.
    part: Place,
}

fn address(s: &Solid) -> usize {
    Arc::as_ptr(&s.0) as usize
}

impl Origins {
    pub(super) fn add(&mut self, s: &Solid, range: TextRange) {
        self.known.entry(address(s)).or_insert_with(|| (s.clone(), range));
    }

    pub(super) fn finish(mut self, source: &str, part: Place) -> Arc<Self> {
        (self.source, self.part) = (source.into(), part);
        Arc::new(self)
    }

    fn of(&self, s: &Solid) -> Option<Place> {
        let (_, range) = self.known.get(&address(s))?;
        Some(place(&self.source, range.start().to_usize(), range.end().to_usize()))
    }
}

/// The operand at fault.
struct Culprit {
    place: Option<Place>,
    /// More about it, to go on with the message.
    why: String,
}

struct OperandSearch<'a> {
    origins: &'a Origins,
    rsystem: RSystem,
    looks: usize,
}

impl OperandSearch<'_> {
    fn model(&mut self, s: &Solid) -> Option<Result<Implicit, Error>> {
        self.looks = self.looks.checked_sub(1)?;
        Some(Implicit::new(s, self.rsystem, None))
    }

    /// Whether a solid by itself is empty, or has no end.
    fn is(&mut self, s: &Solid, kind: NoBody) -> bool {
        matches!(self.model(s), Some(Err(Error::Input { place: Place::Solid(found), .. })) if found == kind)
    }

    /// The innermost solid that makes the whole one empty, or endless.
    fn find(&mut self, whole: &Solid, kind: NoBody) -> Culprit {
        let (mut at, mut place) = (whole.clone(), None);
        loop {
            place = self.origins.of(&at).or(place);
            let candidates: Vec<Solid> = match at.node() {
                SolidNode::Placed(_, s) | SolidNode::Named(_, s) | SolidNode::Sized(_, s) => vec![s.clone()],
                SolidNode::And(all) if kind == NoBody::Empty => all.clone(),
                SolidNode::Or(all) if kind == NoBody::Endless => all.clone(),
                SolidNode::Blend(a, b, _) if kind == NoBody::Endless => vec![a.clone(), b.clone()],
                _ => Vec::new(),
            };
            match candidates.iter().find(|s| self.is(s, kind)) {
                Some(next) => at = next.clone(),
                None => break,
            }
        }
        if let SolidNode::And(all) = at.node()
            && kind == NoBody::Empty
            && let Some((first, why)) = self.apart(all)
        {
            return Culprit { place: Some(first), why };
        }
        Culprit { place, why: String::new() }
    }

    /// Two operands whose boxes have nothing in common: the place of one, and a word about the other.
    fn apart(&mut self, all: &[Solid]) -> Option<(Place, String)> {
        let mut boxes = Vec::new();
        for s in all.iter().filter(|s| !matches!(s.node(), SolidNode::Not(_))) {
            if let (Some(place), Some(Ok(model))) = (self.origins.of(s), self.model(s)) {
                boxes.push((place, model.bounds()));
            }
        }
        let pairs = boxes.iter().enumerate().flat_map(|(i, a)| boxes[i + 1..].iter().map(move |b| (a, b)));
        let (a, b) = pairs.into_iter().find(|(a, b)| a.1.intersection(&b.1).is_empty())?;
        let other = b.0.to_string();
        Some((a.0.clone(), format!("; this and the solid at {} have nothing in common", other.trim_end_matches(": "))))
    }
}

impl Part {
    /// An error that is known only of the whole solid, with the place of the operand at fault, else that of `part(...)`. Other errors
    /// and those of parts that no file describes stay as they are.
    pub(crate) fn located(&self, e: Error) -> Error {
        let (Error::Input { place: Place::Solid(kind), .. }, Some(origins)) = (&e, &self.origins) else {
            return e;
        };
        let kind = *kind;
        let mut search = OperandSearch { origins, rsystem: self.rsystem, looks: LOOKS };
        let found = match &self.solid {
            Some(s) if search.is(s, kind) || kind == NoBody::Endless => search.find(s, kind),
            Some(_) if self.domain.is_some() => Culprit { place: None, why: "; the domain holds none of it".into() },
            _ => Culprit { place: None, why: String::new() },
        };
        match e {
            Error::Input { file, message, help, .. } => {
                let place = found.place.unwrap_or_else(|| origins.part.clone());
                Error::Input { file, place, message: message + &found.why, help }
            }
            other => other,
        }
    }
}
