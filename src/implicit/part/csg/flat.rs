//! Plane figures of a `.csg` file, and what raises them to solids.

use glam::{DAffine3, DMat3, DVec2, DVec3};

use super::super::super::lower::lower;
use super::super::super::polygon::{MOST_CORNERS, polygon_tree, segments_meet};
use super::super::super::solid::{Placement, Primitive, Solid};
use super::shapes::{Local, ROOM, SIX_DIGITS, similarity};
use super::tokens::{Token, Value};
use super::{AS_TRIANGLES, Call, FEW_SIDES};
use crate::error::{Error, Result};

/// A plane figure where it was made, before it is placed.
pub(super) enum Figure {
    Square {
        lo: DVec3,
        hi: DVec3,
    },
    Circle {
        r: f64,
    },
    /// A regular polygon in a circle.
    Regular {
        sides: usize,
        r: f64,
    },
    /// Inside of an odd number of these polygons, which do not meet.
    Polygon {
        paths: Vec<Vec<[f64; 2]>>,
    },
}

/// What makes a solid of a figure.
pub(super) enum Raising {
    Linear { height: f64, bottom: f64 },
    Turned,
}

/// A raising in its place: the figure is mapped in its plane before it, what comes of it is placed after it.
pub(super) struct Raise {
    raising: Raising,
    place: Placement,
    name: String,
}

impl Figure {
    pub(super) fn kind(&self) -> &'static str {
        match self {
            Figure::Square { .. } => "square",
            Figure::Circle { .. } | Figure::Regular { .. } => "circle",
            Figure::Polygon { .. } => "polygon",
        }
    }

    /// The figure after an affine map of the plane, with names of borders that begin with `name`.
    pub(super) fn placed(&self, map: &DAffine3, name: &str) -> Solid {
        let like = similarity(&in_space(map));
        let set = |p: Primitive| match like {
            Some(place) if place != Placement::IDENTITY => Solid::from(p).placed(place),
            _ => Solid::from(p),
        };
        let polygon = |points: &[[f64; 2]]| {
            let moved = |p: &[f64; 2]| map.transform_point3(DVec3::new(p[0], p[1], 0.0));
            let polygon = points.iter().map(moved).map(|p| [p.x, p.y]).collect();
            Solid::from(Primitive::Extrude { polygon, height: f64::INFINITY, at: DVec3::ZERO })
        };
        let solid = match self {
            Figure::Square { lo, hi } if like.is_some() => set(Primitive::Box { lo: *lo, hi: *hi }),
            Figure::Square { lo, hi } => polygon(&[[lo.x, lo.y], [hi.x, lo.y], [hi.x, hi.y], [lo.x, hi.y]]),
            Figure::Circle { r } if like.is_some() => {
                set(Primitive::Cylinder { r: *r, axis: DVec3::Z, at: DVec3::ZERO, height: None })
            }
            Figure::Circle { r } => ellipse(map, *r),
            Figure::Regular { sides, r } => {
                let corner = |i: usize| {
                    let (sin, cos) = (std::f64::consts::TAU * i as f64 / *sides as f64).sin_cos();
                    [r * cos, r * sin]
                };
                polygon(&(0..*sides).map(corner).collect::<Vec<_>>())
            }
            Figure::Polygon { paths } => match &paths[..] {
                [one] => polygon(one),
                all => {
                    let one = |i: usize| polygon(&all[i]).name(&format!("{name}.path{i}"));
                    nested(all, &one)
                }
            },
        };
        solid.name(name)
    }
}

/// A map of the plane as one of space that stretches upward as it does in the plane.
fn in_space(map: &DAffine3) -> DAffine3 {
    let m = map.matrix3;
    let up = m.determinant().abs().sqrt();
    DAffine3 { matrix3: DMat3::from_cols(m.x_axis, m.y_axis, DVec3::Z * up), translation: map.translation.with_z(0.0) }
}

/// A circle after a map that makes an ellipse of it. Lines around it tell its bounds, and bound nothing.
fn ellipse(map: &DAffine3, r: f64) -> Solid {
    let half: [f64; 2] = std::array::from_fn(|i| r * map.matrix3.row(i).truncate().length() * (1.0 + ROOM));
    let half = DVec3::new(half[0], half[1], 0.0);
    let mut all = vec![Solid::formula(Local::of(map).quadric(2, r))];
    for axis in [DVec3::X, DVec3::Y] {
        all.push(Solid::half_space(-axis, map.translation - half));
        all.push(Solid::half_space(axis, map.translation + half));
    }
    Solid::intersection(all)
}

/// What is inside of an odd number of polygons that do not meet.
fn nested(paths: &[Vec<[f64; 2]>], one: &dyn Fn(usize) -> Solid) -> Solid {
    let n = paths.len();
    let around = |i: usize| (0..n).filter(move |&k| k != i && holds(&paths[k], paths[i][0]));
    let depth: Vec<usize> = (0..n).map(|i| around(i).count()).collect();
    let outer = (0..n).filter(|&i| depth[i].is_multiple_of(2));
    Solid::union(outer.map(|i| {
        let holes = (0..n).filter(|&k| depth[k] == depth[i] + 1 && holds(&paths[i], paths[k][0]));
        Solid::intersection(std::iter::once(one(i)).chain(holes.map(|k| !one(k))))
    }))
}

/// Whether a point is inside a polygon by the even-odd rule.
fn holds(p: &[[f64; 2]], q: [f64; 2]) -> bool {
    let n = p.len();
    (0..n).fold(false, |inside, i| {
        let (a, b) = (p[i], p[(i + 1) % n]);
        let crosses = (a[1] > q[1]) != (b[1] > q[1]) && q[0] < (b[0] - a[0]) * (q[1] - a[1]) / (b[1] - a[1]) + a[0];
        inside != crosses
    })
}

impl Raise {
    /// The solid of a figure.
    pub(super) fn solid(self, figure: Solid, word: Token<'_>, source: &str) -> Result<Solid> {
        let told = |e: Error| match e {
            Error::Input { message, .. } => word.error(source, message),
            other => other,
        };
        let (solid, shift) = match self.raising {
            Raising::Linear { height, bottom } => {
                (figure.extruded(height).map_err(told)?, DVec3::Z * (bottom + 0.5 * height))
            }
            Raising::Turned => {
                // A figure that is on the other side of the axis altogether makes the same solid as its mirror image.
                let beyond = lower(&figure).map_err(told)?.bounds.hi.x <= 0.0;
                let rotation = DMat3::from_diagonal(DVec3::new(-1.0, 1.0, 1.0));
                let mirrored = Placement { rotation, ..Placement::IDENTITY };
                let figure = if beyond { figure.placed(mirrored) } else { figure };
                (figure.revolved().map_err(told)?, DVec3::ZERO)
            }
        };
        let place = self.place.after(&Placement { shift, ..Placement::IDENTITY });
        let solid = if place == Placement::IDENTITY { solid } else { solid.placed(place) };
        Ok(solid.name(&self.name))
    }
}

/// An orthogonal frame for what a map makes of the plane and its normal: the map in the plane, the stretch of the normal and the
/// placement after both. `None` where the normal does not stay one.
fn split(map: &DAffine3) -> Option<Split> {
    if let Some(place) = similarity(map) {
        return Some(Split { plane: DAffine3::IDENTITY, up: 1.0, place });
    }
    let m = map.matrix3;
    let (z, u) = (m.z_axis.try_normalize()?, m.x_axis.try_normalize()?);
    let aside = |v: DVec3| v.dot(z).abs() > SIX_DIGITS * v.length();
    if aside(m.x_axis) || aside(m.y_axis) {
        return None;
    }
    // Exactly square, where six digits are not.
    let u = (u - z * z.dot(u)).try_normalize()?;
    let v = z.cross(u);
    let column = |c: DVec3| {
        let (a, b) = (u.dot(c), v.dot(c));
        let small = SIX_DIGITS * c.length();
        DVec3::new(if a.abs() < small { 0.0 } else { a }, if b.abs() < small { 0.0 } else { b }, 0.0)
    };
    let matrix3 = DMat3::from_cols(column(m.x_axis), column(m.y_axis), DVec3::Z);
    let plane = DAffine3 { matrix3, translation: DVec3::ZERO };
    let place = Placement { rotation: DMat3::from_cols(u, v, z), scale: 1.0, shift: map.translation };
    Some(Split { plane, up: m.z_axis.length(), place })
}

struct Split {
    plane: DAffine3,
    up: f64,
    place: Placement,
}

impl<'a> Call<'a> {
    /// The plane figure; `None` for other operations.
    pub(super) fn figure(&self) -> Result<Option<Figure>> {
        Ok(Some(match self.word.text {
            "square" => {
                self.only(&["size", "center"])?;
                let size = self.numbers("size", 2)?.unwrap_or(DVec3::ONE).with_z(0.0);
                let lo = if self.centered()? { -0.5 * size } else { DVec3::ZERO };
                let tall = f64::INFINITY;
                Figure::Square { lo: lo.with_z(-tall), hi: (lo + size).with_z(tall) }
            }
            "circle" => {
                self.only(&["r", "d"])?;
                let r = self.radius(&["r"])?;
                match self.number("$fn")? {
                    Some((n, _)) if (3.0..=FEW_SIDES).contains(&n) => Figure::Regular { sides: n as usize, r },
                    _ => Figure::Circle { r },
                }
            }
            "polygon" => {
                self.only(&["points", "paths", "convexity"])?;
                Figure::Polygon { paths: self.paths()? }
            }
            _ => return Ok(None),
        }))
    }

    /// What raises the figures inside, and the map of their plane; `None` for other operations.
    pub(super) fn raise(&self, map: &DAffine3, name: &str) -> Result<Option<(Raise, DAffine3)>> {
        let raising = match self.word.text {
            "linear_extrude" => self.linear()?,
            "rotate_extrude" => self.turn()?,
            _ => return Ok(None),
        };
        let refused = || {
            let what = format!(
                "{}() under a matrix that shears it or makes its circles ellipses cannot be read",
                self.word.text
            );
            self.error(&what).with_help(AS_TRIANGLES)
        };
        let Split { plane, up, place } = split(map).ok_or_else(refused)?;
        let (raising, plane) = match raising {
            Raising::Linear { height, bottom } => (Raising::Linear { height: height * up, bottom: bottom * up }, plane),
            Raising::Turned => {
                // The radius is stretched by one factor all around, and z by another.
                let m = plane.matrix3;
                let (a, b) = (m.x_axis.length(), m.y_axis.length());
                if (a - b).abs() > SIX_DIGITS * a || m.x_axis.dot(m.y_axis).abs() > SIX_DIGITS * a * b {
                    return Err(refused());
                }
                let matrix3 = DMat3::from_diagonal(DVec3::new(a, up, 1.0));
                (Raising::Turned, DAffine3 { matrix3, translation: DVec3::ZERO })
            }
        };
        Ok(Some((Raise { raising, place, name: name.to_string() }, plane)))
    }

    fn linear(&self) -> Result<Raising> {
        self.only(&["height", "h", "v", "center", "convexity", "twist", "slices", "segments", "scale"])?;
        let refused = |a: Token<'a>, what: &str| {
            Err(a.error(self.source, format!("linear_extrude() {what} cannot be read")).with_help(AS_TRIANGLES))
        };
        if let Some((twist, token)) = self.number("twist")?
            && twist != 0.0
        {
            return refused(token, "with a twist");
        }
        if let Some(a) = self.argument("scale")
            && !matches!(&a.value, Value::Number(1.0))
            && !matches!(&a.value, Value::List(all) if all.iter().all(|v| matches!(v, Value::Number(1.0))))
        {
            return refused(a.token, "with a scale other than 1");
        }
        if let Some(a) = self.argument("v")
            && !matches!(&a.value, Value::List(v) if matches!(v[..], [Value::Number(0.0), Value::Number(0.0), Value::Number(z)] if z > 0.0))
        {
            return refused(a.token, "in another direction than z");
        }
        let given = match self.number("height")? {
            Some(found) => Some(("height", found)),
            None => self.number("h")?.map(|found| ("h", found)),
        };
        // OpenSCAD's own height where none is given.
        let height = given.map_or(Ok(100.0), |(name, (v, token))| self.positive(name, v, token))?;
        let bottom = if self.centered()? { -0.5 * height } else { 0.0 };
        Ok(Raising::Linear { height, bottom })
    }

    fn turn(&self) -> Result<Raising> {
        self.only(&["angle", "start", "convexity"])?;
        if let Some((angle, token)) = self.number("angle")?
            && angle.abs() < 360.0
        {
            let e =
                token.error(self.source, format!("rotate_extrude() by {angle} degrees cannot be read, only by 360"));
            return Err(e.with_help(AS_TRIANGLES));
        }
        if let Some((n, token)) = self.number("$fn")?
            && (3.0..=FEW_SIDES).contains(&n)
        {
            let e = token.error(self.source, format!("rotate_extrude() with {n} flat sides cannot be read"));
            return Err(e.with_help("with $fn = 0, or more than 8, it is round"));
        }
        Ok(Raising::Turned)
    }

    /// A number for all of a size, or one for each coordinate.
    pub(super) fn numbers(&self, name: &str, count: usize) -> Result<Option<DVec3>> {
        let Some(a) = self.argument(name) else { return Ok(None) };
        let size = match &a.value {
            Value::Number(v) => DVec3::splat(*v),
            Value::List(all) => match all[..] {
                [Value::Number(x), Value::Number(y), Value::Number(z)] if count == 3 => DVec3::new(x, y, z),
                [Value::Number(x), Value::Number(y)] if count == 2 => DVec3::new(x, y, 1.0),
                _ => return Err(self.no_size(a.token, count)),
            },
            _ => return Err(self.no_size(a.token, count)),
        };
        if size.min_element() <= 0.0 {
            let shown = if count == 2 { format!("{}", size.truncate()) } else { format!("{size}") };
            let what = format!("the sizes of a {} must be positive, not {shown}", self.word.text);
            return Err(a.token.error(self.source, what));
        }
        Ok(Some(size))
    }

    fn no_size(&self, token: Token<'a>, count: usize) -> Error {
        let many = if count == 2 { "two" } else { "three" };
        token.error(self.source, format!("the size of a {} is a number or {many} of them", self.word.text))
    }

    /// The points of an argument, with so many coordinates.
    pub(super) fn points(&self, count: usize) -> Result<(Vec<DVec3>, Token<'a>)> {
        let Some(a) = self.argument("points") else {
            return Err(self.error(&format!("{}() needs points", self.word.text)));
        };
        let point = |v: &Value| match v {
            Value::List(v) => match v[..] {
                [Value::Number(x), Value::Number(y)] if count == 2 => Some(DVec3::new(x, y, 0.0)),
                [Value::Number(x), Value::Number(y), Value::Number(z)] if count == 3 => Some(DVec3::new(x, y, z)),
                _ => None,
            },
            _ => None,
        };
        let found: Option<Vec<DVec3>> = match &a.value {
            Value::List(all) => all.iter().map(point).collect(),
            _ => None,
        };
        match found {
            Some(points) => Ok((points, a.token)),
            None => Err(a.token.error(self.source, format!("points are a list of points of {count} numbers"))),
        }
    }

    /// Lists of numbers of points, as `paths` and `faces` have them.
    pub(super) fn indices(&self, a: &super::Argument<'a>, points: usize) -> Result<Vec<Vec<usize>>> {
        let number = |v: &Value| match v {
            Value::Number(n) if n.fract() == 0.0 && (0.0..points as f64).contains(n) => Some(*n as usize),
            _ => None,
        };
        let list = |v: &Value| match v {
            Value::List(all) => all.iter().map(number).collect::<Option<Vec<usize>>>(),
            _ => None,
        };
        let found = match &a.value {
            Value::List(all) => all.iter().map(list).collect::<Option<Vec<_>>>(),
            _ => None,
        };
        found.ok_or_else(|| {
            let what = format!("{:?} is a list of lists of numbers of points, from 0 to {}", a.name, points.max(1) - 1);
            a.token.error(self.source, what)
        })
    }

    /// The closed lines of a polygon.
    fn paths(&self) -> Result<Vec<Vec<[f64; 2]>>> {
        let (points, token) = self.points(2)?;
        let points: Vec<[f64; 2]> = points.iter().map(|p| DVec2::new(p.x, p.y).to_array()).collect();
        let (paths, token) = match self.argument("paths") {
            Some(a) if !matches!(a.value, Value::Word) => {
                let lists = self.indices(a, points.len())?;
                (lists.into_iter().map(|l| l.into_iter().map(|i| points[i]).collect()).collect(), a.token)
            }
            _ => (vec![points], token),
        };
        let bad = |what: String| Err(token.error(self.source, what));
        let count: usize = paths.iter().map(Vec::len).sum();
        if count > MOST_CORNERS {
            return bad(format!("the polygon has {count} corners: the limit is {MOST_CORNERS}"));
        }
        if paths.is_empty() {
            return bad("a polygon needs at least one path".into());
        }
        for path in &paths {
            if let Err(Error::Input { message, .. }) = polygon_tree(path) {
                return bad(message);
            }
        }
        let edge = |p: &[[f64; 2]], i: usize| [p[i], p[(i + 1) % p.len()]];
        for (k, p) in paths.iter().enumerate() {
            for (l, q) in paths.iter().enumerate().skip(k + 1) {
                let meet = |i: usize| (0..q.len()).any(|j| segments_meet(edge(p, i), edge(q, j)));
                if (0..p.len()).any(meet) {
                    return bad(format!("paths {k} and {l} of the polygon touch or cross"));
                }
            }
        }
        Ok(paths)
    }
}
