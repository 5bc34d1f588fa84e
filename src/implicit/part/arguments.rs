//! Arguments of a call: binding them to names, turning them into what a builtin needs.

use glam::DVec3;
use ruff_text_size::TextRange;

use super::super::solid::Solid;
use super::interpreter::Interpreter;
use super::value::Value;
use crate::error::Result;

/// One argument.
#[derive(Clone)]
pub(super) struct Argument<'a> {
    pub(super) keyword: Option<String>,
    pub(super) value: Value<'a>,
    pub(super) range: TextRange,
}

/// The arguments of a call to a builtin or method, by name.
pub(super) struct Bound<'a> {
    function: &'static str,
    names: &'static [&'static str],
    found: Vec<Option<Argument<'a>>>,
    pub(super) range: TextRange,
}

impl<'a> Bound<'a> {
    /// Binds arguments to parameter names, in order or by keyword.
    pub(super) fn new(
        it: &Interpreter<'a>,
        function: &'static str,
        names: &'static [&'static str],
        arguments: Vec<Argument<'a>>,
        range: TextRange,
    ) -> Result<Self> {
        let mut found: Vec<Option<Argument<'a>>> = names.iter().map(|_| None).collect();
        for (i, a) in arguments.into_iter().enumerate() {
            let slot = match &a.keyword {
                None => i,
                Some(k) => names.iter().position(|n| n == k).ok_or_else(|| {
                    it.error(a.range, format!("{function}() has no parameter {k:?}; it has: {}", names.join(", ")))
                })?,
            };
            match found.get_mut(slot) {
                None => {
                    return Err(it.error(
                        a.range,
                        format!("{function}() takes at most {} arguments: {}", names.len(), names.join(", ")),
                    ));
                }
                Some(Some(_)) => {
                    return Err(it.error(a.range, format!("{function}() is given {:?} twice", names[slot])));
                }
                Some(s) => *s = Some(a),
            }
        }
        Ok(Bound { function, names, found, range })
    }

    /// The argument, unless it was left out or is `None`.
    pub(super) fn get(&self, name: &str) -> Option<&Argument<'a>> {
        let i = self.names.iter().position(|n| *n == name)?;
        self.found[i].as_ref().filter(|a| !matches!(a.value, Value::None))
    }

    pub(super) fn need(&self, it: &Interpreter<'a>, name: &str) -> Result<&Argument<'a>> {
        self.get(name).ok_or_else(|| {
            it.error(self.range, format!("{}() needs {name:?}; it has: {}", self.function, self.names.join(", ")))
        })
    }

    fn wrong<T>(&self, it: &Interpreter<'a>, a: &Argument<'a>, name: &str, what: &str) -> Result<T> {
        Err(it.error(a.range, format!("{:?} of {}() must be {what}, not {}", name, self.function, a.value.kind())))
    }

    pub(super) fn number(&self, it: &Interpreter<'a>, name: &str) -> Result<f64> {
        let a = self.need(it, name)?;
        match a.value.number() {
            Some(v) if v.is_finite() => Ok(v),
            Some(v) => Err(it.error(a.range, format!("{:?} of {}() must be finite, not {v}", name, self.function))),
            None => self.wrong(it, a, name, "a number"),
        }
    }

    pub(super) fn positive(&self, it: &Interpreter<'a>, name: &str) -> Result<f64> {
        let v = self.number(it, name)?;
        if v > 0.0 {
            return Ok(v);
        }
        Err(it
            .error(self.need(it, name)?.range, format!("{:?} of {}() must be positive, not {v}", name, self.function)))
    }

    pub(super) fn not_negative(&self, it: &Interpreter<'a>, name: &str) -> Result<f64> {
        let v = self.number(it, name)?;
        if v >= 0.0 {
            return Ok(v);
        }
        Err(it.error(
            self.need(it, name)?.range,
            format!("{:?} of {}() must not be negative, not {v}", name, self.function),
        ))
    }

    pub(super) fn vector(&self, it: &Interpreter<'a>, name: &str) -> Result<DVec3> {
        let a = self.need(it, name)?;
        let numbers: Option<Vec<f64>> = a.value.items().map(|v| v.iter().filter_map(Value::number).collect());
        match (numbers.as_deref(), a.value.items().map(<[_]>::len)) {
            (Some([x, y, z]), Some(3)) if x.is_finite() && y.is_finite() && z.is_finite() => Ok(DVec3::new(*x, *y, *z)),
            (Some(_), Some(_)) => Err(
                it.error(a.range, format!("{:?} of {}() must be three finite numbers (x, y, z)", name, self.function))
            ),
            _ => self.wrong(it, a, name, "a tuple of three numbers"),
        }
    }

    /// A point; the origin if left out.
    pub(super) fn point(&self, it: &Interpreter<'a>, name: &str) -> Result<DVec3> {
        if self.get(name).is_some() { self.vector(it, name) } else { Ok(DVec3::ZERO) }
    }

    /// A point of two or three numbers, where z is 0 if left out; the origin if all of it is.
    pub(super) fn flat_point(&self, it: &Interpreter<'a>, name: &str) -> Result<DVec3> {
        let numbers = self.get(name).and_then(|a| a.value.items()).unwrap_or_default();
        match numbers.iter().map(Value::number).collect::<Option<Vec<f64>>>().as_deref() {
            Some([x, y]) if x.is_finite() && y.is_finite() => Ok(DVec3::new(*x, *y, 0.0)),
            _ => self.point(it, name),
        }
    }

    /// A direction: a letter or a vector; z if left out.
    pub(super) fn axis(&self, it: &Interpreter<'a>, name: &str) -> Result<DVec3> {
        let Some(a) = self.get(name) else { return Ok(DVec3::Z) };
        if let Value::Str(s) = &a.value {
            return match &**s {
                "x" => Ok(DVec3::X),
                "y" => Ok(DVec3::Y),
                "z" => Ok(DVec3::Z),
                other => Err(it.error(a.range, format!("an axis is \"x\", \"y\", \"z\" or a vector, not {other:?}"))),
            };
        }
        let v = self.vector(it, name)?;
        match v.try_normalize() {
            Some(_) => Ok(v),
            None => Err(it.error(a.range, "a direction must not be the zero vector".to_string())),
        }
    }

    pub(super) fn text(&self, it: &Interpreter<'a>, name: &str) -> Result<String> {
        let a = self.need(it, name)?;
        match &a.value {
            Value::Str(s) => Ok(s.to_string()),
            _ => self.wrong(it, a, name, "a string"),
        }
    }

    pub(super) fn solid(&self, it: &Interpreter<'a>, name: &str) -> Result<Solid> {
        let a = self.need(it, name)?;
        match a.value.solid() {
            Some(s) => Ok(s),
            None => self.wrong(it, a, name, "a solid"),
        }
    }

    pub(super) fn polygon(&self, it: &Interpreter<'a>, name: &str) -> Result<Vec<[f64; 2]>> {
        let a = self.need(it, name)?;
        if let Value::Polygon(p) = &a.value {
            return Ok(p.to_vec());
        }
        let Some(items) = a.value.items() else {
            return self.wrong(it, a, name, "a polygon or a list of points (x, y)");
        };
        let mut points = Vec::with_capacity(items.len());
        for (i, v) in items.iter().enumerate() {
            let pair: Option<Vec<f64>> = v.items().map(|v| v.iter().filter_map(Value::number).collect());
            match pair.as_deref() {
                Some([x, y]) if x.is_finite() && y.is_finite() && v.items().map(<[_]>::len) == Some(2) => {
                    points.push([*x, *y])
                }
                _ => {
                    return Err(
                        it.error(a.range, format!("point {i} of the polygon must be two finite numbers (x, y)"))
                    );
                }
            }
        }
        Ok(points)
    }
}
