//! Arguments of records as the things they stand for.

use glam::DVec3;

use crate::io::step::{Record, StepFile, Value};
use crate::parametric::brep::Note;
use crate::parametric::frame::Frame;
use crate::spatial::LARGEST;

/// A value, or what is wrong with the record that should hold it.
pub(super) type Read<T> = std::result::Result<T, Note>;

/// What a number is to be that is beyond [`LARGEST`].
const TOO_LARGE: &str = "within 1e150, and what is larger cannot be measured";

/// Looks things up in a file.
#[derive(Clone, Copy)]
pub(super) struct Lookup<'a> {
    pub(super) file: &'a StepFile,
}

/// One part of a record and where it stands.
#[derive(Clone, Copy)]
pub(super) struct Args<'a> {
    pub(super) record: &'a Record,
    pub(super) values: &'a [Value],
}

pub(super) fn note<T>(record: &Record, message: impl Into<String>) -> Read<T> {
    Err(Note { id: record.id, line: record.line, message: message.into(), lost: false })
}

impl<'a> Lookup<'a> {
    pub(super) fn record(&self, id: u64) -> Read<&'a Record> {
        self.file.get(id).ok_or_else(|| Note {
            id,
            line: self.file.line_that_misses(id),
            message: "is referred to but not there".into(),
            lost: false,
        })
    }

    /// The first part of one of these names; the arguments of simple records start with the entity's name.
    pub(super) fn args(&self, id: u64, names: &[&str]) -> Read<Args<'a>> {
        let record = self.record(id)?;
        for n in names {
            if let Some(values) = record.part(n) {
                return Ok(Args { record, values });
            }
        }
        note(record, format!("{} where {} was expected", record.name(), names.join(" or ")))
    }

    pub(super) fn point(&self, id: u64) -> Read<DVec3> {
        self.args(id, &["CARTESIAN_POINT"])?.triple(1)
    }

    pub(super) fn direction(&self, id: u64) -> Read<DVec3> {
        self.args(id, &["DIRECTION"])?.triple(1)
    }

    /// Direction times magnitude.
    pub(super) fn vector(&self, id: u64) -> Read<DVec3> {
        let a = self.args(id, &["VECTOR"])?;
        let d = self.direction(a.reference(1)?)?;
        Ok(d.normalize_or_zero() * a.number(2)?)
    }

    /// A placement with two axes or one.
    pub(super) fn frame(&self, id: u64) -> Read<Frame> {
        let a = self.args(id, &["AXIS2_PLACEMENT_3D", "AXIS1_PLACEMENT"])?;
        let origin = self.point(a.reference(1)?)?;
        let z = a.optional(2).map(|d| self.direction(d)).transpose()?.unwrap_or(DVec3::Z);
        let x = a.optional(3).map(|d| self.direction(d)).transpose()?;
        // Without a reference direction the standard takes the x axis.
        Ok(Frame::new(origin, z, Some(x.unwrap_or(DVec3::X))))
    }
}

impl Args<'_> {
    pub(super) fn bad<T>(&self, i: usize, what: &str) -> Read<T> {
        note(self.record, format!("{}: argument {} is not {what}", self.record.name(), i + 1))
    }

    pub(super) fn reference(&self, i: usize) -> Read<u64> {
        match self.values.get(i) {
            Some(Value::Ref(id)) => Ok(*id),
            _ => self.bad(i, "a reference"),
        }
    }

    pub(super) fn optional(&self, i: usize) -> Option<u64> {
        match self.values.get(i) {
            Some(Value::Ref(id)) => Some(*id),
            _ => None,
        }
    }

    pub(super) fn number(&self, i: usize) -> Read<f64> {
        match self.values.get(i).and_then(number) {
            Some(x) if !(x.abs() <= LARGEST) => self.bad(i, TOO_LARGE),
            Some(x) => Ok(x),
            None => self.bad(i, "a number"),
        }
    }

    pub(super) fn positive(&self, i: usize) -> Read<f64> {
        match self.number(i)? {
            x if x > 0.0 => Ok(x),
            _ => self.bad(i, "a positive number"),
        }
    }

    pub(super) fn count(&self, i: usize) -> Read<usize> {
        match self.number(i)? {
            x if (0.0..=1e9).contains(&x) && x.fract() == 0.0 => Ok(x as usize),
            _ => self.bad(i, "a whole number"),
        }
    }

    /// A truth value; `.U.` counts as true.
    pub(super) fn truth(&self, i: usize) -> Read<bool> {
        match self.values.get(i) {
            Some(Value::Word(w)) => Ok(w != "F"),
            _ => self.bad(i, "a truth value"),
        }
    }

    pub(super) fn text(&self, i: usize) -> &str {
        match self.values.get(i) {
            Some(Value::Text(t)) => t.trim(),
            _ => "",
        }
    }

    pub(super) fn list(&self, i: usize) -> Read<&[Value]> {
        match self.values.get(i) {
            Some(Value::List(l)) => Ok(l),
            _ => self.bad(i, "a list"),
        }
    }

    pub(super) fn references(&self, i: usize) -> Read<Vec<u64>> {
        let one = |v: &Value| if let Value::Ref(id) = v { Some(*id) } else { None };
        match self.list(i)?.iter().map(one).collect() {
            Some(ids) => Ok(ids),
            None => self.bad(i, "a list of references"),
        }
    }

    pub(super) fn numbers(&self, i: usize) -> Read<Vec<f64>> {
        match self.list(i)?.iter().map(number).collect::<Option<Vec<f64>>>() {
            Some(x) if !x.iter().all(|x| x.abs() <= LARGEST) => self.bad(i, TOO_LARGE),
            Some(x) => Ok(x),
            None => self.bad(i, "a list of numbers"),
        }
    }

    /// Three coordinates; missing ones are 0.
    pub(super) fn triple(&self, i: usize) -> Read<DVec3> {
        let x = self.numbers(i)?;
        let at = |k: usize| x.get(k).copied().unwrap_or(0.0);
        Ok(DVec3::new(at(0), at(1), at(2)))
    }

    /// A list of lists.
    pub(super) fn rows<T>(&self, i: usize, one: impl Fn(&Value) -> Option<T>) -> Read<Vec<Vec<T>>> {
        let row = |v: &Value| if let Value::List(l) = v { l.iter().map(&one).collect() } else { None };
        match self.list(i)?.iter().map(row).collect() {
            Some(rows) => Ok(rows),
            None => self.bad(i, "a list of lists"),
        }
    }
}

/// A number, bare or with its type's name.
pub(super) fn number(v: &Value) -> Option<f64> {
    match v {
        Value::Number(x) => Some(*x),
        Value::Typed(_, inner) => inner.first().and_then(number),
        _ => None,
    }
}
