//! Solids: read from text or made by calls, set operations, placements, names.

use std::ffi::c_int;
use std::mem::MaybeUninit;

use rvachev::DVec3;
use rvachev::implicit::part::{Part, recipe::Recipe};
use rvachev::implicit::{Solid, SolidNode};

use crate::errors::{ErrorOut, Failure, GOOD, entry, given, input, release, slot};
use crate::pass::{Chars, Items, Out, finite, point};
use crate::text::{quoted, read_within};

/// What a solid is made of.
#[derive(Clone)]
pub enum Kind {
    /// R-functions.
    Functions(Solid),
    /// Edges. It stands apart in a part, and takes no part in set operations.
    Built {
        /// How it is built.
        recipes: Vec<Recipe>,
        /// What a part file would say.
        text: String,
    },
}

/// A solid, as a handle.
pub struct RvSolid(pub Kind);

type SolidOut<'a> = Out<'a, *mut RvSolid>;

/// Gives a solid to the caller.
pub fn solid_out(solid: Solid, out: &mut MaybeUninit<*mut RvSolid>) -> Result<c_int, Failure> {
    put(Kind::Functions(solid), out)
}

fn put(kind: Kind, out: &mut MaybeUninit<*mut RvSolid>) -> Result<c_int, Failure> {
    out.write(Box::into_raw(Box::new(RvSolid(kind))));
    Ok(GOOD)
}

/// The one solid a text of a part file stands for.
fn read(text: &str) -> Result<Kind, Failure> {
    let Part { solid, built, .. } = read_within("part(", text, ")")?;
    match (solid, built.len()) {
        (Some(solid), 0) => Ok(Kind::Functions(solid)),
        (None, 1) => Ok(Kind::Built { recipes: built, text: text.to_string() }),
        _ => Err(input("the text stands for several solids", "union([a, b]) makes one of several")),
    }
}

/// What methods of part files, such as `move((1, 0, 0)).name("a")`, make of a solid.
fn applied(kind: &Kind, methods: &str) -> Result<Kind, Failure> {
    match kind {
        Kind::Built { text, .. } => read(&format!("({text}).{methods}")),
        Kind::Functions(inner) => {
            let part = read_within("part(sphere(1).", methods, ")")?;
            let made = part.solid.ok_or_else(|| input("the text is no placement and no name", ""))?;
            Ok(Kind::Functions(around(&made, inner)?))
        }
    }
}

/// The same placements, names and sizes around another solid.
fn around(made: &Solid, inner: &Solid) -> Result<Solid, Failure> {
    Ok(match made.node() {
        SolidNode::Placed(placement, rest) => around(rest, inner)?.placed(*placement),
        SolidNode::Named(name, rest) => around(rest, inner)?.name(name),
        SolidNode::Sized(h, rest) => around(rest, inner)?.size(*h),
        SolidNode::Primitive(_) => inner.clone(),
        _ => return Err(input("only placements, names and sizes are applied", "move((1, 0, 0)).name(\"a\")")),
    })
}

fn functions<'a>(solid: Option<&'a RvSolid>, name: &str) -> Result<&'a Solid, Failure> {
    match &given(solid, name)?.0 {
        Kind::Functions(s) => Ok(s),
        Kind::Built { .. } => Err(input(
            "solids built from edges take no part in set operations",
            "rv_part_new takes several that stand apart",
        )),
    }
}

fn vector(v: DVec3) -> String {
    format!("({:?}, {:?}, {:?})", v.x, v.y, v.z)
}

/// A point or direction as an argument of a part file; left out for NULL.
fn argument(name: &str, of: &Items<f64>) -> Result<String, Failure> {
    Ok(match of.optional(3, name)? {
        Some(_) => format!(", {name}={}", vector(point(of, name)?)),
        None => String::new(),
    })
}

/// Reads what a call made: places in it mean nothing to the caller.
fn made(text: &str, out: &mut MaybeUninit<*mut RvSolid>) -> Result<c_int, Failure> {
    put(read(text).map_err(placeless)?, out)
}

fn placeless(e: Failure) -> Failure {
    match e {
        Failure::Library(rvachev::Error::Input { file, message, help, .. }) => {
            Failure::Library(rvachev::Error::Input { file, place: rvachev::Place::Unknown, message, help })
        }
        other => other,
    }
}

/// Two ends as the axis, height and middle of a cylinder or cone.
fn between(from: &Items<f64>, to: &Items<f64>) -> Result<String, Failure> {
    let (a, b) = (point(from, "from")?, point(to, "to")?);
    if a == b {
        return Err(input("the two ends are one point", ""));
    }
    Ok(format!("height={:?}, axis={}, at={}", (b - a).length(), vector(b - a), vector(0.5 * (a + b))))
}

/// Reads a solid as part files have it: `box(size=(2, 2, 2)) - cylinder(0.4)`, `solid(x**2 + y**2 + z**2 <= 1)`.
#[unsafe(no_mangle)]
pub extern "C" fn rv_solid_parse(text: Chars, solid: SolidOut<'_>, error: ErrorOut<'_>) -> c_int {
    entry(error, || {
        let out = slot(solid, std::ptr::null_mut(), "solid")?;
        put(read(text.text("text")?)?, out)
    })
}

/// A box between two corners. Its faces are `box.xmin` to `box.zmax`.
#[unsafe(no_mangle)]
pub extern "C" fn rv_solid_box(lo: Items<f64>, hi: Items<f64>, solid: SolidOut<'_>, error: ErrorOut<'_>) -> c_int {
    entry(error, || {
        let out = slot(solid, std::ptr::null_mut(), "solid")?;
        let (lo, hi) = (vector(point(&lo, "lo")?), vector(point(&hi, "hi")?));
        made(&format!("box(lo={lo}, hi={hi})"), out)
    })
}

/// A ball; about the origin where `at` is NULL.
#[unsafe(no_mangle)]
pub extern "C" fn rv_solid_sphere(radius: f64, at: Items<f64>, solid: SolidOut<'_>, error: ErrorOut<'_>) -> c_int {
    entry(error, || {
        let out = slot(solid, std::ptr::null_mut(), "solid")?;
        let r = finite(radius, "radius")?;
        made(&format!("sphere({r:?}{})", argument("at", &at)?), out)
    })
}

/// A cylinder between the centers of its ends.
#[unsafe(no_mangle)]
pub extern "C" fn rv_solid_cylinder(
    radius: f64,
    from: Items<f64>,
    to: Items<f64>,
    solid: SolidOut<'_>,
    error: ErrorOut<'_>,
) -> c_int {
    entry(error, || {
        let out = slot(solid, std::ptr::null_mut(), "solid")?;
        let r = finite(radius, "radius")?;
        made(&format!("cylinder({r:?}, {})", between(&from, &to)?), out)
    })
}

/// A cone between the centers of its ends, with a radius at each of them, of which one may be 0.
#[unsafe(no_mangle)]
pub extern "C" fn rv_solid_cone(
    radii: Items<f64>,
    from: Items<f64>,
    to: Items<f64>,
    solid: SolidOut<'_>,
    error: ErrorOut<'_>,
) -> c_int {
    entry(error, || {
        let out = slot(solid, std::ptr::null_mut(), "solid")?;
        let r = radii.slice(2, "radii")?;
        let (r0, r1) = (finite(r[0], "radii")?, finite(r[1], "radii")?);
        made(&format!("cone({r0:?}, {r1:?}, {})", between(&from, &to)?), out)
    })
}

/// A torus: the radius of its ring and that of its tube; about z for NULL as axis, about the origin for NULL as `at`.
#[unsafe(no_mangle)]
pub extern "C" fn rv_solid_torus(
    radii: Items<f64>,
    axis: Items<f64>,
    at: Items<f64>,
    solid: SolidOut<'_>,
    error: ErrorOut<'_>,
) -> c_int {
    entry(error, || {
        let out = slot(solid, std::ptr::null_mut(), "solid")?;
        let r = radii.slice(2, "radii")?;
        let (ring, tube) = (finite(r[0], "radii")?, finite(r[1], "radii")?);
        made(&format!("torus({ring:?}, {tube:?}{}{})", argument("axis", &axis)?, argument("at", &at)?), out)
    })
}

/// The side of a plane its outward normal points away from; through the origin where `at` is NULL.
#[unsafe(no_mangle)]
pub extern "C" fn rv_solid_half_space(
    normal: Items<f64>,
    at: Items<f64>,
    solid: SolidOut<'_>,
    error: ErrorOut<'_>,
) -> c_int {
    entry(error, || {
        let out = slot(solid, std::ptr::null_mut(), "solid")?;
        let n = vector(point(&normal, "normal")?);
        made(&format!("half_space({n}{})", argument("at", &at)?), out)
    })
}

/// Solids of R-functions among handles.
fn several(solids: &Items<Option<&RvSolid>>, count: usize) -> Result<Vec<Solid>, Failure> {
    let all = solids.slice(count, "solids")?;
    if all.is_empty() {
        return Err(input("a set operation needs at least one solid", ""));
    }
    all.iter().map(|s| functions(*s, "a solid").cloned()).collect()
}

/// The union of solids.
#[unsafe(no_mangle)]
pub extern "C" fn rv_solid_union(
    solids: Items<Option<&RvSolid>>,
    count: usize,
    solid: SolidOut<'_>,
    error: ErrorOut<'_>,
) -> c_int {
    entry(error, || {
        let out = slot(solid, std::ptr::null_mut(), "solid")?;
        solid_out(Solid::union(several(&solids, count)?), out)
    })
}

/// The intersection of solids.
#[unsafe(no_mangle)]
pub extern "C" fn rv_solid_intersection(
    solids: Items<Option<&RvSolid>>,
    count: usize,
    solid: SolidOut<'_>,
    error: ErrorOut<'_>,
) -> c_int {
    entry(error, || {
        let out = slot(solid, std::ptr::null_mut(), "solid")?;
        solid_out(Solid::intersection(several(&solids, count)?), out)
    })
}

/// The first solid without the second.
#[unsafe(no_mangle)]
pub extern "C" fn rv_solid_difference(
    a: Option<&RvSolid>,
    b: Option<&RvSolid>,
    solid: SolidOut<'_>,
    error: ErrorOut<'_>,
) -> c_int {
    entry(error, || {
        let out = slot(solid, std::ptr::null_mut(), "solid")?;
        solid_out(functions(a, "a")?.clone() - functions(b, "b")?.clone(), out)
    })
}

/// All that is not in the solid.
#[unsafe(no_mangle)]
pub extern "C" fn rv_solid_complement(a: Option<&RvSolid>, solid: SolidOut<'_>, error: ErrorOut<'_>) -> c_int {
    entry(error, || {
        let out = slot(solid, std::ptr::null_mut(), "solid")?;
        solid_out(!functions(a, "a")?.clone(), out)
    })
}

/// The union of two solids with a fillet between their faces.
#[unsafe(no_mangle)]
pub extern "C" fn rv_solid_blend(
    a: Option<&RvSolid>,
    b: Option<&RvSolid>,
    radius: f64,
    solid: SolidOut<'_>,
    error: ErrorOut<'_>,
) -> c_int {
    entry(error, || {
        let out = slot(solid, std::ptr::null_mut(), "solid")?;
        let (a, b) = (functions(a, "a")?.clone(), functions(b, "b")?.clone());
        if !(radius > 0.0 && radius.is_finite()) {
            return Err(input(format!("the radius of a blend must be positive, not {radius}"), ""));
        }
        solid_out(a.blend(b, radius), out)
    })
}

/// What a method of a part file, or a chain of them, makes of a solid: `rotate(90, axis="x", at=(1, 0, 0)).name("arm")`.
#[unsafe(no_mangle)]
pub extern "C" fn rv_solid_apply(
    a: Option<&RvSolid>,
    methods: Chars,
    solid: SolidOut<'_>,
    error: ErrorOut<'_>,
) -> c_int {
    entry(error, || {
        let out = slot(solid, std::ptr::null_mut(), "solid")?;
        put(applied(&given(a, "a")?.0, methods.text("methods")?.trim().trim_start_matches('.'))?, out)
    })
}

/// Applies a method made here.
fn changed(a: Option<&RvSolid>, method: &str, out: SolidOut<'_>) -> Result<c_int, Failure> {
    let out = slot(out, std::ptr::null_mut(), "solid")?;
    put(applied(&given(a, "a")?.0, method).map_err(placeless)?, out)
}

/// The solid moved.
#[unsafe(no_mangle)]
pub extern "C" fn rv_solid_move(
    a: Option<&RvSolid>,
    by: Items<f64>,
    solid: SolidOut<'_>,
    error: ErrorOut<'_>,
) -> c_int {
    entry(error, || changed(a, &format!("move({})", vector(point(&by, "by")?)), solid))
}

/// The solid turned about an axis through the origin, counter-clockwise seen from where the axis points to.
#[unsafe(no_mangle)]
pub extern "C" fn rv_solid_rotate(
    a: Option<&RvSolid>,
    degrees: f64,
    axis: Items<f64>,
    solid: SolidOut<'_>,
    error: ErrorOut<'_>,
) -> c_int {
    entry(error, || {
        let degrees = finite(degrees, "degrees")?;
        changed(a, &format!("rotate({degrees:?}, axis={})", vector(point(&axis, "axis")?)), solid)
    })
}

/// The solid scaled about the origin by a positive factor.
#[unsafe(no_mangle)]
pub extern "C" fn rv_solid_scale(a: Option<&RvSolid>, factor: f64, solid: SolidOut<'_>, error: ErrorOut<'_>) -> c_int {
    entry(error, || changed(a, &format!("scale({:?})", finite(factor, "factor")?), solid))
}

/// The solid with its faces named; the innermost name wins.
#[unsafe(no_mangle)]
pub extern "C" fn rv_solid_name(a: Option<&RvSolid>, name: Chars, solid: SolidOut<'_>, error: ErrorOut<'_>) -> c_int {
    entry(error, || changed(a, &format!("name({})", quoted(name.text("name")?)), solid))
}

/// The solid with a wish for edges of that length on its faces; the innermost one wins.
#[unsafe(no_mangle)]
pub extern "C" fn rv_solid_size(a: Option<&RvSolid>, length: f64, solid: SolidOut<'_>, error: ErrorOut<'_>) -> c_int {
    entry(error, || changed(a, &format!("size({:?})", finite(length, "length")?), solid))
}

/// Frees a solid. What was made of it stays.
#[unsafe(no_mangle)]
pub extern "C" fn rv_solid_free(solid: Option<Box<RvSolid>>) {
    release(solid);
}
