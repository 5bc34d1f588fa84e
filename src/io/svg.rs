//! SVG of plane figures: the area as one path, and on it the borders, a path for each stretch of one name.
//!
//! Coordinates are those of the mesh, digit by digit, and y goes up: a transform of the whole turns it over. Lengths in mm, cm
//! and in are true to scale where a viewer heeds them.

use std::io::Write;

use glam::DVec3;

use crate::error::{Error, Result};
use crate::mesh::MeshView;
use crate::spatial::Aabb;

use super::WriteOptions;
use super::atomic::write_failed;
use super::line::WrittenLine;
use super::outline::ClosedLine;
use super::vtu::attribute;

/// Room around the figure, as a share of its diagonal.
const MARGIN: f64 = 0.02;
/// Units of length that SVG knows.
const UNITS: [&str; 3] = ["mm", "cm", "in"];

pub(super) fn write(out: &mut dyn Write, mesh: &dyn MeshView, options: &WriteOptions) -> Result<()> {
    let Some(outline) = &options.outline else {
        return Err(Error::Failed("an SVG file holds plane figures, and this mesh is none".into()));
    };
    let at = |v: &u32| mesh.node(*v as usize);
    let b = Aabb::around(outline.contours.iter().flat_map(|c| &c.nodes).map(at));
    let b = b.grown(MARGIN * b.diagonal());
    let size = b.hi - b.lo;
    let unit = outline.units.as_deref().filter(|u| UNITS.contains(u)).unwrap_or("");
    let mut line = WrittenLine::default();
    let mut text = |text: &str| writeln!(out, "{text}").map_err(write_failed);
    text("<?xml version=\"1.0\" encoding=\"UTF-8\"?>")?;
    text(&format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" version=\"1.1\" width=\"{}{unit}\" height=\"{}{unit}\" viewBox=\"{} {} {} {}\">",
        size.x, size.y, b.lo.x, -b.hi.y, size.x, size.y
    ))?;
    text("<g transform=\"scale(1 -1)\">")?;
    text("<path id=\"region\" fill=\"#c8d4e0\" fill-rule=\"evenodd\" stroke=\"none\" d=\"")?;
    for c in &outline.contours {
        polyline(out, &mut line, c.nodes.iter().map(at), true)?;
    }
    let mut text = |text: &str| writeln!(out, "{text}").map_err(write_failed);
    text("\"/>")?;
    text("<g id=\"borders\" fill=\"none\" stroke=\"#202020\" stroke-linejoin=\"round\">")?;
    for c in &outline.contours {
        for stretch in stretches(c) {
            let BorderPath { border, nodes, closed } = stretch;
            let name = attribute(&outline.names[border as usize]);
            let groups = outline.groups.get(border as usize).map_or(String::new(), |g| g.join(" "));
            let groups = if groups.is_empty() { groups } else { format!(" data-groups=\"{}\"", attribute(&groups)) };
            writeln!(out, "<path vector-effect=\"non-scaling-stroke\" data-name=\"{name}\"{groups} d=\"")
                .map_err(write_failed)?;
            polyline(out, &mut line, nodes.iter().map(at), closed)?;
            writeln!(out, "\"/>").map_err(write_failed)?;
        }
    }
    writeln!(out, "</g>\n</g>\n</svg>").map_err(write_failed)
}

fn polyline(
    out: &mut dyn Write,
    line: &mut WrittenLine,
    points: impl Iterator<Item = DVec3>,
    closed: bool,
) -> Result<()> {
    for (k, p) in points.enumerate() {
        write!(out, "{}", if k == 0 { "M " } else { "L " }).map_err(write_failed)?;
        line.real(p.x).real(p.y).end(out)?;
    }
    if closed { writeln!(out, "Z").map_err(write_failed) } else { Ok(()) }
}

/// Nodes along edges of one border that follow each other.
struct BorderPath {
    border: u32,
    nodes: Vec<u32>,
    closed: bool,
}

fn stretches(c: &ClosedLine) -> Vec<BorderPath> {
    let n = c.nodes.len();
    let Some(start) = (0..n).find(|k| c.borders[*k] != c.borders[(k + n - 1) % n]) else {
        return c
            .borders
            .first()
            .map(|b| BorderPath { border: *b, nodes: c.nodes.clone(), closed: true })
            .into_iter()
            .collect();
    };
    let mut all: Vec<BorderPath> = Vec::new();
    for k in (start..start + n).map(|k| k % n) {
        let (border, next) = (c.borders[k], c.nodes[(k + 1) % n]);
        match all.last_mut().filter(|s| s.border == border) {
            Some(s) => s.nodes.push(next),
            None => all.push(BorderPath { border, nodes: vec![c.nodes[k], next], closed: false }),
        }
    }
    all
}
