//! Curves and surfaces of STEP files (ISO 10303-42).

use glam::DVec3;

use super::values::{Args, Lookup, Read, note};
use crate::io::step::{Record, Value};
use crate::parametric::basis::Knots;
use crate::parametric::curve::Curve;
use crate::parametric::frame::Frame;
use crate::parametric::nurbs::{NurbsCurve, NurbsSurface};
use crate::parametric::surface::Surface;

/// Curves and surfaces may refer to others this many times in a row.
const DEEPEST: usize = 8;

/// What to do with the arguments of simple records, which start with a name, and of parts of complex ones, which do not.
fn shifted<'a>(record: &'a Record, part: &str) -> Option<Args<'a>> {
    let values = record.part(part)?;
    let skip = usize::from(record.parts.len() == 1);
    Some(Args { record, values: values.get(skip..)? })
}

/// Knots repeated as often as they count.
fn knots(a: &Args<'_>, counts: usize, values: usize) -> Read<Vec<f64>> {
    let (times, values) = (a.numbers(counts)?, a.numbers(values)?);
    if times.len() != values.len() || times.iter().any(|t| !(*t >= 0.0 && *t <= 64.0)) {
        return a.bad(counts, "a list of multiplicities");
    }
    Ok(values.iter().zip(&times).flat_map(|(v, t)| std::iter::repeat_n(*v, *t as usize)).collect())
}

/// Knots of the kinds of splines that have none in the file.
fn implied(record: &Record, degree: usize, points: usize) -> Option<Vec<f64>> {
    let has = |n: &str| record.parts.iter().any(|p| p.0.starts_with(n));
    let ends = |v: f64| std::iter::repeat_n(v, degree + 1);
    let spans = points.checked_sub(degree).filter(|s| *s > 0)?;
    if has("QUASI_UNIFORM") {
        let inner = (1..spans).map(|i| i as f64);
        return Some(ends(0.0).chain(inner).chain(ends(spans as f64)).collect());
    }
    if has("BEZIER") {
        let pieces = (points - 1) / degree.max(1);
        let inner = (1..pieces).flat_map(|i| std::iter::repeat_n(i as f64, degree));
        return Some(ends(0.0).chain(inner).chain(ends(pieces as f64)).collect());
    }
    has("UNIFORM").then(|| (0..points + degree + 1).map(|i| i as f64 - degree as f64).collect())
}

impl Lookup<'_> {
    fn points(&self, ids: &[u64]) -> Read<Vec<DVec3>> {
        ids.iter().map(|p| self.point(*p)).collect()
    }

    /// The curve in space that record `id` stands for.
    pub(super) fn curve(&self, id: u64) -> Read<Curve> {
        self.curve_at(id, 0)
    }

    fn curve_at(&self, id: u64, depth: usize) -> Read<Curve> {
        let record = self.record(id)?;
        if depth > DEEPEST {
            return note(record, "curves refer to each other without end");
        }
        if record.parts.iter().any(|p| p.0.contains("CURVE") && is_spline(&p.0)) {
            return self.spline(record);
        }
        let Some((name, values)) = record.parts.first() else { return note(record, "an empty record") };
        let a = Args { record, values };
        let frame = |i: usize| -> Read<Frame> { self.frame(a.reference(i)?) };
        Ok(match name.as_str() {
            "LINE" => {
                let direction = self.vector(a.reference(2)?)?;
                if !(direction.length() > 0.0) {
                    return a.bad(2, "a direction");
                }
                Curve::Line { origin: self.point(a.reference(1)?)?, direction }
            }
            "CIRCLE" => Curve::circle(frame(1)?, a.positive(2)?),
            "ELLIPSE" => Curve::Ellipse { frame: frame(1)?, a: a.positive(2)?, b: a.positive(3)? },
            "PARABOLA" => Curve::Parabola { frame: frame(1)?, focal: a.positive(2)? },
            "HYPERBOLA" => Curve::Hyperbola { frame: frame(1)?, a: a.positive(2)?, b: a.positive(3)? },
            "POLYLINE" => match NurbsCurve::polyline(&self.points(&a.references(1)?)?) {
                Ok(c) => Curve::Nurbs(c),
                Err(e) => return note(record, e.to_string()),
            },
            "SURFACE_CURVE" | "SEAM_CURVE" | "INTERSECTION_CURVE" | "BOUNDED_SURFACE_CURVE" | "TRIMMED_CURVE" => {
                self.curve_at(a.reference(1)?, depth + 1)?
            }
            _ => return note(record, format!("curves of the kind {name} are not known")),
        })
    }

    fn spline(&self, record: &Record) -> Read<Curve> {
        let main =
            ["B_SPLINE_CURVE", "B_SPLINE_CURVE_WITH_KNOTS", "BEZIER_CURVE", "QUASI_UNIFORM_CURVE", "UNIFORM_CURVE"];
        let Some(a) = main.iter().find_map(|n| shifted(record, n)) else {
            return note(record, "a spline without points");
        };
        let degree = a.count(0)?;
        let points = self.points(&a.references(1)?)?;
        let knots = match shifted(record, "B_SPLINE_CURVE_WITH_KNOTS") {
            Some(k) if record.parts.len() == 1 => knots(&k, 5, 6)?,
            Some(k) => knots(&k, 0, 1)?,
            None => match implied(record, degree, points.len()) {
                Some(k) => k,
                None => return note(record, "a spline without knots"),
            },
        };
        let weights = shifted(record, "RATIONAL_B_SPLINE_CURVE").map(|w| w.numbers(0)).transpose()?;
        match NurbsCurve::new(degree, knots, &points, weights.as_deref()) {
            Ok(c) => Ok(Curve::Nurbs(c)),
            Err(e) => note(record, e.to_string()),
        }
    }

    /// The surface that record `id` stands for; `angle` is the file's unit of angles in radians.
    pub(super) fn surface(&self, id: u64, angle: f64) -> Read<Surface> {
        self.surface_at(id, angle, 0)
    }

    fn surface_at(&self, id: u64, angle: f64, depth: usize) -> Read<Surface> {
        let record = self.record(id)?;
        if depth > DEEPEST {
            return note(record, "surfaces refer to each other without end");
        }
        if record.parts.iter().any(|p| p.0.contains("SURFACE") && is_spline(&p.0)) {
            return self.net(record);
        }
        let Some((name, values)) = record.parts.first() else { return note(record, "an empty record") };
        let a = Args { record, values };
        let frame = |i: usize| -> Read<Frame> { self.frame(a.reference(i)?) };
        Ok(match name.as_str() {
            "PLANE" => Surface::Plane { frame: frame(1)? },
            "CYLINDRICAL_SURFACE" => Surface::Cylinder { frame: frame(1)?, radius: a.positive(2)? },
            "CONICAL_SURFACE" => {
                let slope = (a.number(3)? * angle).tan();
                if slope == 0.0 || !slope.is_finite() {
                    return a.bad(3, "the half angle of a cone");
                }
                Surface::Cone { frame: frame(1)?, radius: a.number(2)?, slope }
            }
            "SPHERICAL_SURFACE" => Surface::Sphere { frame: frame(1)?, radius: a.positive(2)? },
            "TOROIDAL_SURFACE" | "DEGENERATE_TOROIDAL_SURFACE" => {
                if a.truth(4).is_ok_and(|outer| !outer) {
                    return note(record, "the inner part of a torus is not known");
                }
                Surface::Torus { frame: frame(1)?, major: a.number(2)?.abs(), minor: a.positive(3)? }
            }
            "SURFACE_OF_LINEAR_EXTRUSION" => {
                let (curve, direction) = (self.curve(a.reference(1)?)?, self.vector(a.reference(2)?)?);
                if !(direction.length() > 0.0) {
                    return a.bad(2, "a direction");
                }
                match curve {
                    Curve::Line { origin, direction: x } if x.cross(direction).length() > 0.0 => {
                        Surface::Plane { frame: Frame::new(origin, x.cross(direction), Some(x)) }
                    }
                    curve => Surface::Extrusion { curve, direction },
                }
            }
            "SURFACE_OF_REVOLUTION" => Surface::Revolution { curve: self.curve(a.reference(1)?)?, frame: frame(2)? },
            "OFFSET_SURFACE" => {
                let base = self.surface_at(a.reference(1)?, angle, depth + 1)?;
                Surface::Offset { base: Box::new(base), distance: a.number(2)? }
            }
            "RECTANGULAR_TRIMMED_SURFACE" | "CURVE_BOUNDED_SURFACE" => {
                self.surface_at(a.reference(1)?, angle, depth + 1)?
            }
            _ => return note(record, format!("surfaces of the kind {name} are not known")),
        })
    }

    fn net(&self, record: &Record) -> Read<Surface> {
        let main = [
            "B_SPLINE_SURFACE",
            "B_SPLINE_SURFACE_WITH_KNOTS",
            "BEZIER_SURFACE",
            "QUASI_UNIFORM_SURFACE",
            "UNIFORM_SURFACE",
        ];
        let Some(a) = main.iter().find_map(|n| shifted(record, n)) else {
            return note(record, "a spline without points");
        };
        let (p, q) = (a.count(0)?, a.count(1)?);
        let one = |v: &Value| if let Value::Ref(id) = v { Some(*id) } else { None };
        let rows = a.rows(2, one)?;
        let (nu, nv) = (rows.len(), rows.first().map_or(0, Vec::len));
        let points = self.points(&rows.concat())?;
        let (ku, kv) = match shifted(record, "B_SPLINE_SURFACE_WITH_KNOTS") {
            Some(k) if record.parts.len() == 1 => (knots(&k, 7, 9)?, knots(&k, 8, 10)?),
            Some(k) => (knots(&k, 0, 2)?, knots(&k, 1, 3)?),
            None => match (implied(record, p, nu), implied(record, q, nv)) {
                (Some(u), Some(v)) => (u, v),
                _ => return note(record, "a spline without knots"),
            },
        };
        let weights =
            shifted(record, "RATIONAL_B_SPLINE_SURFACE").map(|w| w.rows(0, super::values::number)).transpose()?;
        let weights = weights.map(|w| w.concat());
        let made = Knots::new(p, ku, nu)
            .and_then(|u| Ok((u, Knots::new(q, kv, nv)?)))
            .and_then(|(u, v)| NurbsSurface::new(u, v, &points, weights.as_deref()));
        match made {
            Ok(s) => Ok(Surface::Nurbs(s)),
            Err(e) => note(record, e.to_string()),
        }
    }
}

fn is_spline(name: &str) -> bool {
    name.starts_with("B_SPLINE_") || name.starts_with("BEZIER_") || name.contains("UNIFORM_")
}
