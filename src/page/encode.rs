//! The mesh as a page holds it: rounded coordinates and differences of numbers, deflated, in base64.
//!
//! The stream is one row of numbers of seven bits a byte, low ones first, the eighth telling that more follow. It holds
//! the differences of the nodes' first coordinates, of the second, of the third; those of the triangles' corners;
//! runs of labels; and the edges to be drawn. Differences have their sign in the lowest bit.

use miniz_oxide::deflate::compress_to_vec;
use miniz_oxide::inflate::decompress_to_vec;
use serde::Serialize;

use crate::error::{Error, Place, Result};
use crate::mesh::TriMesh;
use crate::mesh::sides::sides;
use crate::numeric::base64::from_base64;
use crate::quality::SHARP_MESH;
use crate::run::Run;

/// Steps along the longest side of the box: a rounded coordinate has 21 bits.
const STEPS: f64 = ((1 << 21) - 1) as f64;

/// How hard to deflate. Higher levels take twice as long and save less than a twentieth.
const LEVEL: u8 = 6;

/// What the reader has to know of the stream.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub(super) struct StreamLayout {
    /// How many nodes.
    node_count: usize,
    /// How many triangles.
    triangle_count: usize,
    /// How many edges are drawn.
    edge_count: usize,
    /// Where coordinates begin.
    lo: [f64; 3],
    /// How long a step is.
    step: f64,
}

/// Why an edge is drawn. The page knows the same numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum DrawnAs {
    Sharp = 0,
    Border = 1,
    Open = 2,
    Branching = 3,
}

/// A mesh as it is read back from a page.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Pictured {
    /// Rounded nodes, in steps.
    pub nodes: Vec<[u32; 3]>,
    /// Corners.
    pub triangles: Vec<[u32; 3]>,
    /// The face of each triangle.
    pub labels: Vec<u32>,
    /// Nodes of the edges that are drawn.
    pub edges: Vec<[u32; 2]>,
}

struct Stream(Vec<u8>);

impl Stream {
    fn number(&mut self, mut n: u64) {
        while n >= 128 {
            self.0.push(n as u8 | 128);
            n >>= 7;
        }
        self.0.push(n as u8);
    }

    /// The difference to the last one, which this becomes.
    fn step(&mut self, n: u32, last: &mut u32) {
        let d = i64::from(n) - i64::from(*last);
        self.number(((d << 1) ^ (d >> 63)) as u64);
        *last = n;
    }
}

pub(super) fn encode(mesh: &TriMesh, run: &Run) -> Result<(StreamLayout, Vec<u8>)> {
    let (lo, side) = if mesh.nodes.is_empty() {
        (glam::DVec3::ZERO, 0.0)
    } else {
        let b = mesh.bounds();
        (b.lo, (b.hi - b.lo).max_element())
    };
    let step = if side > 0.0 && side.is_finite() { side / STEPS } else { 1.0 };
    let mut out = Stream(Vec::with_capacity(10 * mesh.triangles.len()));
    for axis in 0..3 {
        let mut last = 0;
        for p in &mesh.nodes {
            out.step(((p[axis] - lo[axis]) / step).round().clamp(0.0, STEPS) as u32, &mut last);
        }
    }
    run.check()?;
    let mut last = 0;
    for v in mesh.triangles.iter().flatten() {
        out.step(*v, &mut last);
    }
    for labels in mesh.labels.chunk_by(|a, b| a == b) {
        out.number(u64::from(labels[0]));
        out.number(labels.len() as u64);
    }
    run.check()?;
    let edge_count = edges(mesh, &mut out);
    run.check()?;
    let layout = StreamLayout {
        node_count: mesh.nodes.len(),
        triangle_count: mesh.triangles.len(),
        edge_count,
        lo: lo.to_array(),
        step,
    };
    Ok((layout, compress_to_vec(&out.0, LEVEL)))
}

/// Writes the edges that are drawn: both nodes, the faces beside them and why. Returns how many there are.
fn edges(mesh: &TriMesh, out: &mut Stream) -> usize {
    let cosine = SHARP_MESH.to_radians().cos();
    let (mut count, mut last) = (0, 0);
    let all = sides(mesh);
    for group in all.chunk_by(|a, b| a.key == b.key) {
        let (first, other) = (group[0].triangle() as usize, group[group.len() - 1].triangle() as usize);
        let [f, g] = [first, other].map(|t| mesh.labels[t]);
        let why = match group.len() {
            1 => DrawnAs::Open,
            2 if mesh.normal(first).dot(mesh.normal(other)) < cosine => DrawnAs::Sharp,
            2 if f != g => DrawnAs::Border,
            2 => continue,
            _ => DrawnAs::Branching,
        };
        let [a, b] = group[0].edge();
        out.step(a, &mut last);
        out.step(b, &mut last);
        out.number(u64::from(f));
        out.number(u64::from(g));
        out.number(why as u64);
        count += 1;
    }
    count
}

/// Reads the mesh back out of a page.
///
/// # Errors
/// [`Error::Input`] where the text is no page, or not a whole one.
pub fn decode(html: &str) -> Result<Pictured> {
    read_back(html).ok_or_else(|| Error::input(Place::Unknown, "this is no page with a mesh"))
}

/// What the element of this name holds.
fn element<'a>(html: &'a str, id: &str) -> Option<&'a str> {
    let (_, after) = html.split_once(&format!(" id=\"{id}\">"))?;
    Some(after.split_once("</script>")?.0)
}

fn read_back(html: &str) -> Option<Pictured> {
    let told: serde_json::Value = serde_json::from_str(element(html, "told")?).ok()?;
    let count = |name: &str| told.get(name)?.as_u64().and_then(|n| u32::try_from(n).ok());
    let bytes = decompress_to_vec(&from_base64(element(html, "mesh")?)?).ok()?;
    let mut left = bytes.iter();
    let mut number = || -> Option<u64> {
        let mut n = 0u64;
        for shift in (0..63).step_by(7) {
            let byte = *left.next()?;
            n |= u64::from(byte & 127) << shift;
            if byte < 128 {
                return Some(n);
            }
        }
        None
    };
    let signed = |n: u64, last: &mut u32| -> Option<u32> {
        *last = u32::try_from(i64::from(*last) + ((n >> 1) as i64 ^ -((n & 1) as i64))).ok()?;
        Some(*last)
    };
    let mut out = Pictured::default();
    for axis in 0..3 {
        let mut last = 0;
        for i in 0..count("node_count")? as usize {
            if axis == 0 {
                out.nodes.push([0; 3]);
            }
            out.nodes[i][axis] = signed(number()?, &mut last)?;
        }
    }
    let triangles = count("triangle_count")? as usize;
    let mut last = 0;
    for _ in 0..triangles {
        let mut corners = [0; 3];
        for v in &mut corners {
            *v = signed(number()?, &mut last)?;
        }
        out.triangles.push(corners);
    }
    while out.labels.len() < triangles {
        let (label, run) = (u32::try_from(number()?).ok()?, usize::try_from(number()?).ok()?);
        if run == 0 || run > triangles - out.labels.len() {
            return None;
        }
        out.labels.resize(out.labels.len() + run, label);
    }
    let mut last = 0;
    for _ in 0..count("edge_count")? {
        let a = signed(number()?, &mut last)?;
        out.edges.push([a, signed(number()?, &mut last)?]);
        for _ in 0..3 {
            number()?;
        }
    }
    Some(out)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_no_page_is_refused() {
        assert!(decode("").is_err());
        assert!(decode("<script id=\"told\">{}</script><script id=\"mesh\">AAAA</script>").is_err());
    }
}
