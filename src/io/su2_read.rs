//! SU2 meshes in: triangles and quadrilaterals of markers and of elements, markers as faces.
//!
//! Volumes are passed over: their boundary is in the markers. A mesh of two dimensions lies in the plane z = 0.

use std::borrow::Cow;

use crate::error::Result;
use crate::mesh::TriMesh;
use crate::run::Run;

use super::CHECK_EVERY;
use super::build::reserve;
use super::numbered::{Element, Numbered};
use super::text::{Lines, at, count, ended, point, quote};

/// VTK's numbers of elements, which SU2 uses, with how many nodes they have: line, triangle, quadrilateral, tetrahedron,
/// hexahedron, prism, pyramid.
const KINDS: [(usize, usize); 7] = [(3, 2), (5, 3), (9, 4), (10, 4), (12, 8), (13, 6), (14, 5)];

struct ZoneReader<'a> {
    lines: Lines<'a>,
    axes: usize,
    raw: Numbered,
}

/// The next line that holds something besides a comment.
fn next<'a>(lines: &mut Lines<'a>) -> Option<(usize, Cow<'a, str>)> {
    loop {
        let (number, line) = lines.next_filled()?;
        let text = line.split('%').next().unwrap_or_default().trim();
        if !text.is_empty() {
            return Some((number, Cow::Owned(text.to_owned())));
        }
    }
}

pub(super) fn read(bytes: &[u8], run: &Run) -> Result<TriMesh> {
    let mut r = ZoneReader { lines: Lines::new(bytes), axes: 0, raw: Numbered::default() };
    let (mut promised, mut came) = (None, 0);
    let mut tag: Option<String> = None;
    while let Some((number, line)) = next(&mut r.lines) {
        run.check()?;
        let Some((key, value)) = line.split_once('=') else {
            // Control boxes of free-form deformation stand behind keywords of their own.
            if r.axes == 0 {
                return Err(at(number, format!("an SU2 file begins with `NDIME=`, not {}", quote(&line))));
            }
            continue;
        };
        let (key, value) = (key.trim(), value.trim());
        let first = |what: &str| count(&mut value.split_whitespace(), number, what);
        match key {
            "NZONE" if first("the count of zones")? > 1 => {
                return Err(at(number, "files of several zones are not read"));
            }
            "NDIME" => {
                r.axes = first("the dimension")?;
                if !matches!(r.axes, 2 | 3) {
                    return Err(at(number, format!("the dimension is {}, and must be 2 or 3", r.axes)));
                }
            }
            "NELEM" | "NPOIN" | "MARKER_ELEMS" if r.axes == 0 => {
                return Err(at(number, format!("`NDIME=` must stand before `{key}=`")));
            }
            "NELEM" => {
                let n = first("the count of elements")?;
                let entity = r.raw.entity(&[]);
                r.elements(n, entity, run)?;
            }
            "NPOIN" => {
                let n = first("the count of points")?;
                r.points(n, run)?;
            }
            "NMARK" => promised = Some(first("the count of markers")?),
            "MARKER_TAG" => tag = Some(value.to_owned()),
            "MARKER_ELEMS" => {
                let n = first("the count of the marker's elements")?;
                let name = tag.take().ok_or_else(|| at(number, "no `MARKER_TAG=` stands before these elements"))?;
                let set = r.raw.set(&name, || name.clone());
                let entity = r.raw.entity(&[set]);
                r.elements(n, entity, run)?;
                came += 1;
            }
            _ => {}
        }
    }
    if let Some(promised) = promised.filter(|n| *n != came) {
        return Err(at(r.lines.number(), format!("{promised} markers were promised, {came} came")));
    }
    r.raw.finish()
}

impl ZoneReader<'_> {
    fn points(&mut self, n: usize, run: &Run) -> Result<()> {
        // A digit and a blank for each coordinate, the last of which may be the end of the file.
        self.raw.nodes.reserve(reserve(n, 2 * self.axes - 1, self.lines.rest().len()));
        for i in 0..n {
            if i % CHECK_EVERY == 0 {
                run.check()?;
            }
            let (number, line) =
                next(&mut self.lines).ok_or_else(|| ended(self.lines.number(), &format!("point {i} of {n}")))?;
            let words: Vec<&str> = line.split_whitespace().collect();
            let mut coordinates = words[..words.len().min(self.axes)].to_vec();
            if coordinates.len() == self.axes {
                coordinates.resize(3, "0");
            }
            let p = point(&mut coordinates.into_iter(), number)?;
            // Without a number, points are counted.
            let tag = match words.get(self.axes) {
                Some(_) => count(&mut words[self.axes..].iter().copied(), number, "the number of the point")?,
                None => i,
            };
            self.raw.nodes.push((tag as u64, p));
        }
        Ok(())
    }

    fn elements(&mut self, n: usize, entity: i32, run: &Run) -> Result<()> {
        for i in 0..n {
            if i % CHECK_EVERY == 0 {
                run.check()?;
            }
            let (number, line) =
                next(&mut self.lines).ok_or_else(|| ended(self.lines.number(), &format!("element {i} of {n}")))?;
            let mut words = line.split_whitespace();
            let kind = count(&mut words, number, "the type of the element")?;
            let Some((_, nodes)) = KINDS.iter().find(|k| k.0 == kind) else {
                // A vertex, as markers of periodic borders have it.
                if kind == 1 {
                    continue;
                }
                return Err(at(number, format!("elements of type {kind} are not read"))
                    .with_help("triangles (5) and quadrilaterals (9) are; lines and volumes are passed over"));
            };
            if !matches!(kind, 5 | 9) {
                self.raw.pass_over(kind > 9);
                continue;
            }
            let mut corners = [0; 4];
            for v in &mut corners[..*nodes] {
                *v = count(&mut words, number, "a node of the element")? as u64;
            }
            self.raw.elements.push(Element::new(self.raw.elements.len() as u64, entity, number, &corners[..*nodes]));
        }
        Ok(())
    }
}
