//! OpenSCAD's normalized trees (`.csg`): set operations, matrices and primitives, with spheres and cylinders that are round.
//!
//! `openscad -o a.csg a.scad` writes them: all variables, loops and modules are gone, each placement is a matrix.

mod flat;
mod polyhedron;
mod shapes;
mod tokens;

use std::collections::BTreeMap;

use glam::{DAffine3, DMat3, DVec3};

use super::super::solid::Solid;
use super::{Part, place};
use crate::error::{Error, Place, Result, nearest};
use crate::numeric::ROUNDING;
use flat::Raise;
use shapes::{Round, SIX_DIGITS, Shape};
use tokens::{Argument, Token, Tokens, Value};

/// Bytes of a file that is read.
pub(super) const MOST_BYTES: usize = 64 << 20;

/// Cylinders with a `$fn` up to this are meant to have flat sides: nuts, triangles, square posts.
const FEW_SIDES: f64 = 8.0;

/// The operations that are read.
const KNOWN: [&str; 16] = [
    "group",
    "union",
    "difference",
    "intersection",
    "multmatrix",
    "color",
    "render",
    "cube",
    "sphere",
    "cylinder",
    "polyhedron",
    "linear_extrude",
    "rotate_extrude",
    "square",
    "circle",
    "polygon",
];

/// What is a solid.
const SOLIDS: [&str; 6] = ["cube", "sphere", "cylinder", "polyhedron", "linear_extrude", "rotate_extrude"];
/// What is a figure of the plane.
const FIGURES: [&str; 3] = ["square", "circle", "polygon"];

/// Operations of OpenSCAD that are not read here.
const REFUSED: [&str; 8] = ["hull", "minkowski", "text", "import", "surface", "offset", "projection", "resize"];

/// What to do with a tree that cannot be read.
const AS_TRIANGLES: &str =
    "let OpenSCAD write triangles (openscad -o a.stl a.scad) and mesh those; or write this as a part file (.py)";

/// Reads a tree as OpenSCAD writes it. Solids side by side are one union; primitives are called `box1`, `cylinder1` and so on in
/// the order they stand in.
///
/// Spheres, cylinders and cones are round whatever `$fn` says, but for cylinders and cones with a `$fn` from 3 to 8, which are
/// prisms and pyramids as OpenSCAD makes them. What is drawn only (`%`) or switched off (`*`) is passed over. As in OpenSCAD, a
/// group of nothing is empty: nothing remains of what is intersected with it. Plane figures are read in `linear_extrude` without a
/// twist or scale and in `rotate_extrude` by 360 degrees; circles are round likewise. A polyhedron must be convex.
///
/// Errors: [`Error::Input`] with line and column for anything wrong in the text, and for operations that cannot be read.
pub fn parse_csg(source: &str) -> Result<Part> {
    if source.len() > MOST_BYTES {
        let what = format!("the file has {} bytes: the limit is {MOST_BYTES}", source.len());
        return Err(Error::input(Place::Line(1), what));
    }
    let mut reader = Reader { source, tokens: Tokens::new(source), counts: BTreeMap::new(), open: Vec::new() };
    let solid = reader.read()?;
    if reader.counts.is_empty() {
        return Err(Error::input(place(source, 0, 0), "there is no solid in the file").with_help(
            "openscad -o a.csg a.scad writes such a file; it holds cube(), sphere(), cylinder() and operations on them",
        ));
    }
    Ok(Part::from_solid(solid))
}

/// How the solids in a block are joined.
#[derive(Clone, Copy, PartialEq)]
enum Join {
    Union,
    Intersection,
    Difference,
}

/// A block that is not closed yet.
struct Block<'a> {
    join: Join,
    /// From here to the whole.
    map: DAffine3,
    solids: Vec<Solid>,
    /// Whether nothing of it is part of the solid.
    idle: bool,
    /// Whether it ends with its first solid, as without braces.
    single: bool,
    /// Whether it holds figures of the plane.
    flat: bool,
    /// What makes a solid of them.
    raise: Option<Raise>,
    word: Token<'a>,
}

impl Block<'_> {
    fn solid(mut self, source: &str) -> Result<Solid> {
        let raise = self.raise.take();
        let (word, empty) = (self.word, self.solids.is_empty());
        let joined = self.joined();
        match raise {
            Some(raise) if !empty => raise.solid(joined, word, source),
            _ => Ok(joined),
        }
    }

    fn joined(self) -> Solid {
        let mut solids = self.solids;
        match self.join {
            _ if solids.is_empty() => Solid::union([]),
            _ if solids.len() == 1 => solids.swap_remove(0),
            Join::Union => Solid::union(solids),
            Join::Intersection => Solid::intersection(solids),
            Join::Difference => {
                let rest = solids.split_off(1);
                solids.extend(rest.into_iter().map(|s| !s));
                Solid::intersection(solids)
            }
        }
    }
}

struct Reader<'a> {
    source: &'a str,
    tokens: Tokens<'a>,
    /// How many primitives there are of each kind.
    counts: BTreeMap<&'static str, usize>,
    /// Without recursion: blocks may be nested as deep as the file is long.
    open: Vec<Block<'a>>,
}

impl<'a> Reader<'a> {
    fn read(&mut self) -> Result<Solid> {
        let start = Token { at: 0, text: "" };
        let top = |solids| Block {
            join: Join::Union,
            map: DAffine3::IDENTITY,
            solids,
            idle: false,
            single: false,
            flat: false,
            raise: None,
            word: start,
        };
        self.open.push(top(Vec::new()));
        while let Some(token) = self.tokens.peek()? {
            match token.text {
                ";" => self.tokens.expect(";")?,
                "}" => {
                    self.tokens.expect("}")?;
                    if self.open.len() == 1 || self.open.last().is_some_and(|b| b.single) {
                        return Err(token.error(self.source, "nothing is open that this brace could close"));
                    }
                    self.close()?;
                }
                _ => self.statement()?,
            }
        }
        match self.open.pop() {
            Some(block) if self.open.is_empty() => block.solid(self.source),
            Some(block) => {
                Err(block.word.error(self.source, format!("the braces of {} are not closed", block.word.text)))
            }
            None => Ok(Solid::union([])),
        }
    }

    /// Joins the solids of the innermost block, and those around it that end with it.
    fn close(&mut self) -> Result<()> {
        while self.open.len() > 1 {
            let Some(block) = self.open.pop() else { break };
            let idle = block.idle;
            let solid = block.solid(self.source)?;
            if self.put(solid, idle) {
                break;
            }
        }
        Ok(())
    }

    /// Puts a solid into the innermost block; whether that goes on.
    fn put(&mut self, solid: Solid, idle: bool) -> bool {
        let Some(block) = self.open.last_mut() else { return true };
        if !idle {
            block.solids.push(solid);
        }
        !block.single
    }

    fn statement(&mut self) -> Result<()> {
        let (map, mut idle, flat) =
            self.open.last().map_or((DAffine3::IDENTITY, false, false), |b| (b.map, b.idle, b.flat));
        let mut word = self.tokens.next("an operation")?;
        while matches!(word.text, "%" | "*" | "#" | "!") {
            if word.text == "!" {
                let e = word.error(self.source, "\"!\" shows one part of the tree alone, which is not read");
                return Err(e.with_help("take the mark out of the model"));
            }
            idle |= word.text != "#";
            word = self.tokens.next("an operation")?;
        }
        if !word.is_word() {
            return Err(word.error(self.source, format!("an operation should stand here, not {:?}", word.text)));
        }
        let arguments = self.tokens.arguments()?;
        let call = Call { source: self.source, word, arguments };
        if !idle {
            call.fits(flat)?;
            if let Some(solid) = self.primitive(&call, &map)? {
                self.tokens.expect(";")?;
                return if self.put(solid, false) { Ok(()) } else { self.close() };
            }
        }
        let join = match word.text {
            "difference" => Join::Difference,
            "intersection" => Join::Intersection,
            _ => Join::Union,
        };
        let mut map = map;
        let mut raise = None;
        if !idle {
            if word.text == "multmatrix" {
                map *= if flat { call.matrix_of_plane()? } else { call.matrix()? };
            }
            if word.text.ends_with("_extrude") {
                let name = self.name("extrude");
                if let Some((made, plane)) = call.raise(&map, &name)? {
                    (raise, map) = (Some(made), plane);
                }
            }
        }
        let single = !self.tokens.accept("{")?;
        let flat = flat || raise.is_some();
        self.open.push(Block { join, map, solids: Vec::new(), idle, single, flat, raise, word });
        if single && self.tokens.accept(";")? {
            self.close()?;
        }
        Ok(())
    }

    /// The next name for a kind of solid.
    fn name(&mut self, kind: &'static str) -> String {
        let count = self.counts.entry(kind).or_default();
        *count += 1;
        format!("{kind}{count}")
    }

    /// A primitive in its place; `None` for operations on others.
    fn primitive(&mut self, call: &Call<'a>, map: &DAffine3) -> Result<Option<Solid>> {
        if let Some(figure) = call.figure()? {
            let name = self.name(figure.kind());
            return Ok(Some(figure.placed(map, &name)));
        }
        if let Some(polyhedron) = call.polyhedron()? {
            let name = self.name("polyhedron");
            return Ok(Some(polyhedron.placed(map, &name)));
        }
        let Some(shape) = call.shape()? else { return Ok(None) };
        let name = self.name(shape.kind());
        Ok(Some(shape.placed(map, &name)))
    }
}

/// An operation with its arguments.
struct Call<'a> {
    source: &'a str,
    word: Token<'a>,
    arguments: Vec<Argument<'a>>,
}

impl<'a> Call<'a> {
    /// Refuses solids among figures of the plane, and figures among solids.
    fn fits(&self, flat: bool) -> Result<()> {
        let word = self.word.text;
        if flat && SOLIDS.contains(&word) {
            let e = self.error(&format!("{word}() is a solid, where plane figures should stand"));
            return Err(e.with_help(format!("plane figures are {}", FIGURES.map(|f| format!("{f}()")).join(", "))));
        }
        if !flat && FIGURES.contains(&word) {
            let e = self.error(&format!("{word}() is a plane figure, where solids should stand"));
            return Err(e.with_help("linear_extrude() and rotate_extrude() make solids of plane figures"));
        }
        Ok(())
    }

    /// The primitive; `None` for operations on others.
    fn shape(&self) -> Result<Option<Shape>> {
        Ok(Some(match self.word.text {
            "cube" => {
                self.only(&["size", "center"])?;
                let size = self.numbers("size", 3)?.unwrap_or(DVec3::ONE);
                let shift = if self.centered()? { -0.5 * size } else { DVec3::ZERO };
                Shape::Cube { lo: shift, hi: shift + size }
            }
            "sphere" => {
                self.only(&["r", "d"])?;
                Shape::Sphere { r: self.radius(&["r"])? }
            }
            "cylinder" => {
                self.only(&["h", "r1", "r2", "center", "r", "d"])?;
                let height = self.number("h")?.map_or(Ok(1.0), |(v, t)| self.positive("h", v, t))?;
                let (r1, r2) = (self.radius(&["r1", "r"])?, self.radius(&["r2", "r"])?);
                if r1 == 0.0 && r2 == 0.0 {
                    return Err(self.error("a cylinder needs a radius that is not zero"));
                }
                let bottom = if self.centered()? { -0.5 * height } else { 0.0 };
                let round = Round { r1, r2, bottom, height };
                match self.number("$fn")? {
                    Some((n, _)) if (3.0..=FEW_SIDES).contains(&n) => Shape::Prism { sides: n as usize, round },
                    _ => Shape::Cylinder(round),
                }
            }
            word if KNOWN.contains(&word) => return Ok(None),
            word if REFUSED.contains(&word) => {
                return Err(self.error(&format!("{word}() cannot be read")).with_help(AS_TRIANGLES));
            }
            word => {
                let near = nearest(word, KNOWN.into_iter()).unwrap_or_default();
                let help = format!("is it {near}()? Known are {}", KNOWN.join(", "));
                return Err(self.error(&format!("unknown operation {word:?}")).with_help(help));
            }
        }))
    }

    fn error(&self, what: &str) -> Error {
        self.word.error(self.source, what)
    }

    /// The argument by name, or by its place among `cube(size, center)` and the like.
    fn argument(&self, name: &str) -> Option<&Argument<'a>> {
        let order: &[&str] = match self.word.text {
            "cube" => &["size", "center"],
            "sphere" => &["r"],
            "cylinder" => &["h", "r1", "r2", "center"],
            "square" => &["size", "center"],
            "circle" => &["r"],
            "polygon" => &["points", "paths"],
            "polyhedron" => &["points", "faces"],
            "linear_extrude" => &["height", "center"],
            "rotate_extrude" => &["angle"],
            _ => &["m"],
        };
        let unnamed = self.arguments.iter().filter(|a| a.name.is_empty());
        let by_place = order.iter().zip(unnamed).find(|(n, _)| **n == name).map(|(_, a)| a);
        self.arguments.iter().find(|a| a.name == name).or(by_place)
    }

    /// Refuses other arguments than these and those that tell how round things are drawn.
    fn only(&self, known: &[&str]) -> Result<()> {
        match self.arguments.iter().find(|a| !(a.name.is_empty() || a.name.starts_with('$') || known.contains(&a.name)))
        {
            Some(a) => Err(a.token.error(self.source, format!("{}() has no argument {:?}", self.word.text, a.name))),
            None => Ok(()),
        }
    }

    fn number(&self, name: &str) -> Result<Option<(f64, Token<'a>)>> {
        match self.argument(name).map(|a| (&a.value, a.token)) {
            None => Ok(None),
            Some((Value::Number(v), token)) => Ok(Some((*v, token))),
            Some((_, token)) => Err(token.error(self.source, format!("{name:?} must be a number"))),
        }
    }

    fn positive(&self, name: &str, value: f64, token: Token<'a>) -> Result<f64> {
        if value > 0.0 {
            Ok(value)
        } else {
            Err(token.error(self.source, format!("{name:?} must be positive, not {value}")))
        }
    }

    /// A radius by the first of the names that is there; half of `d`, or 1, where none is.
    fn radius(&self, names: &[&str]) -> Result<f64> {
        for name in names {
            match self.number(name)? {
                // The end of a cone may be a tip.
                Some((0.0, _)) if self.word.text == "cylinder" => return Ok(0.0),
                Some((v, token)) => return self.positive(name, v, token),
                None => {}
            }
        }
        self.number("d")?.map_or(Ok(1.0), |(v, token)| self.positive("d", v, token).map(|d| 0.5 * d))
    }

    fn centered(&self) -> Result<bool> {
        match self.argument("center").map(|a| (&a.value, a.token)) {
            None => Ok(false),
            Some((Value::Bool(b), _)) => Ok(*b),
            Some((_, token)) => Err(token.error(self.source, "\"center\" must be true or false")),
        }
    }

    /// The map a matrix stands for in the plane: what it does along z does not matter there.
    fn matrix_of_plane(&self) -> Result<DAffine3> {
        let map = self.matrix()?;
        let m = map.matrix3;
        let aside = |v: DVec3| v.z.abs() > SIX_DIGITS * v.length();
        if aside(m.x_axis) || aside(m.y_axis) {
            return Err(self.error("this matrix takes plane figures out of their plane").with_help(AS_TRIANGLES));
        }
        let matrix3 = DMat3::from_cols(m.x_axis.with_z(0.0), m.y_axis.with_z(0.0), DVec3::Z);
        Ok(DAffine3 { matrix3, translation: map.translation.with_z(0.0) })
    }

    /// The map a matrix of four rows stands for.
    fn matrix(&self) -> Result<DAffine3> {
        let Some(a) = self.argument("m") else {
            return Err(self.error("multmatrix() needs a matrix"));
        };
        let wrong = |what: &str| Err(a.token.error(self.source, what.to_string()));
        let mut m = [[0.0, 0.0, 0.0, 0.0], [0.0, 0.0, 0.0, 0.0], [0.0, 0.0, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0]];
        let Value::List(rows) = &a.value else { return wrong("a matrix is a list of four rows") };
        if !(3..=4).contains(&rows.len()) {
            return wrong("a matrix has four rows of four numbers");
        }
        for (to, row) in m.iter_mut().zip(rows) {
            match row {
                Value::List(row) => match row[..] {
                    [Value::Number(x), Value::Number(y), Value::Number(z), Value::Number(w)] => *to = [x, y, z, w],
                    _ => return wrong("a matrix has four rows of four numbers"),
                },
                _ => return wrong("a matrix has four rows of four numbers"),
            }
        }
        if m[3] != [0.0, 0.0, 0.0, 1.0] {
            return wrong("the last row of a matrix must be [0, 0, 0, 1]");
        }
        let column = |k: usize| DVec3::new(m[0][k], m[1][k], m[2][k]);
        let matrix3 = DMat3::from_cols(column(0), column(1), column(2));
        // What flattens to six digits may do so by rounding alone.
        let lengths = column(0).length() * column(1).length() * column(2).length();
        // A matrix flattens if the volume of its columns is next to nothing of that of a box of their lengths.
        if !(matrix3.determinant().abs() > ROUNDING * lengths) {
            return wrong("this matrix makes everything flat");
        }
        Ok(DAffine3 { matrix3, translation: column(3) })
    }
}
