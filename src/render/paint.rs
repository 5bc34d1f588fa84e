//! A mesh as a picture: orthographic, faces in colors, sharp edges in dark lines.

use glam::DVec3;
use rayon::prelude::*;

use super::font::{text, text_width};
use super::picture::Picture;
use super::raster::Band;
use crate::error::{Error, Result};
use crate::mesh::TriMesh;
use crate::quality::shape;
use crate::run::Run;

/// Samples along each side of a pixel.
const SAMPLES: usize = 3;

/// Rows of pixels a task paints.
const BAND: usize = 32;

/// Triangle edges are drawn when they are longer than this on average, in pixels.
const WIREFRAME_PIXELS: f64 = 5.0;

/// Most faces a legend lists.
const LEGEND: usize = 24;

/// What the colors of triangles tell.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum ColorBy {
    /// The face.
    #[default]
    Face,
    /// The smallest angle, from red (0 degrees) over yellow (30) to blue (60).
    Quality,
}

/// How to draw.
#[derive(Debug, Clone, PartialEq)]
pub struct RenderOptions {
    /// Pixels in a row, 16..=16384.
    pub width: u32,
    /// Rows, 16..=16384.
    pub height: u32,
    /// From the mesh toward the viewer.
    pub from: DVec3,
    /// What the colors tell.
    pub color_by: ColorBy,
    /// Edges whose triangles' normals differ by more than this are drawn dark, degrees.
    pub sharp_angle: f64,
    /// Whether to draw the triangles' edges where they are large enough to see.
    pub wireframe: bool,
    /// Whether to list the faces' names at the side.
    pub legend: bool,
}

impl Default for RenderOptions {
    fn default() -> Self {
        Self {
            width: 1400,
            height: 1000,
            from: DVec3::new(1.0, -1.45, 0.85),
            color_by: ColorBy::Face,
            sharp_angle: 30.0,
            wireframe: true,
            legend: true,
        }
    }
}

/// A pleasing color for face number `i`: hues a golden turn apart, so that neighbors in number are far apart in color.
fn face_color(i: u32) -> [f32; 3] {
    let hue = (0.58 + f64::from(i) * 0.381_966).fract();
    let tone = [0.86, 0.74, 0.93][(i as usize / 5) % 3];
    from_hue(hue, 0.42, tone)
}

fn from_hue(hue: f64, saturation: f64, value: f64) -> [f32; 3] {
    [0.0, 2.0, 1.0].map(|shift: f64| {
        let h = (hue * 6.0 + shift * 2.0).rem_euclid(6.0);
        let ramp = (h - 3.0).abs() - 1.0;
        (value * (1.0 - saturation + saturation * ramp.clamp(0.0, 1.0))) as f32
    })
}

fn quality_color(angle: f64) -> [f32; 3] {
    from_hue(0.61 * (angle / 60.0).clamp(0.0, 1.0), 0.55, 0.92)
}

fn background(row: usize, rows: usize) -> [f32; 3] {
    let t = row as f32 / rows.max(1) as f32;
    [0.985 - 0.055 * t, 0.988 - 0.045 * t, 0.995 - 0.03 * t]
}

/// A line to draw: ends, width in pixels, color, share.
type Line = (DVec3, DVec3, f64, [f32; 3], f32);

/// Draws a mesh: the same bytes for any number of threads.
///
/// Errors: a mesh that is not [valid](TriMesh::validate); a size out of range; cancellation.
pub fn render(mesh: &TriMesh, options: &RenderOptions, run: &Run) -> Result<Picture> {
    let (width, height) = (options.width as usize, options.height as usize);
    if !(16..=16384).contains(&width) || !(16..=16384).contains(&height) {
        return Err(Error::Usage(format!("a picture of {width} by {height} pixels cannot be drawn")));
    }
    mesh.validate()?;
    run.progress("picture", 0.0);
    let legend_width =
        if options.legend && options.color_by == ColorBy::Face { legend_space(mesh, height) } else { 0.0 };
    let back = options.from.try_normalize().unwrap_or(DVec3::Z);
    let right = DVec3::Z.cross(back).try_normalize().unwrap_or(DVec3::X);
    let up = back.cross(right);
    let view = |p: DVec3| DVec3::new(p.dot(right), -p.dot(up), -p.dot(back));
    let flat: Vec<DVec3> = mesh.nodes.iter().map(|p| view(*p)).collect();
    let bounds = crate::spatial::Aabb::around(flat.iter().copied());
    let samples = SAMPLES as f64;
    let room = (0.92 * (width as f64 - legend_width), 0.92 * height as f64);
    let size = bounds.size();
    let scale = if bounds.is_empty() { 1.0 } else { (room.0 / size.x.max(1e-300)).min(room.1 / size.y.max(1e-300)) };
    let scale = if scale.is_finite() { scale * samples } else { 1.0 };
    let middle = DVec3::new(0.5 * (width as f64 - legend_width) * samples, 0.5 * height as f64 * samples, 0.0);
    let center = if bounds.is_empty() { DVec3::ZERO } else { bounds.center() };
    let points: Vec<DVec3> = flat.iter().map(|p| (*p - center) * scale + middle).collect();

    // light from the viewer's upper left shoulder, and a little from everywhere
    let light = (back + 0.45 * up - 0.35 * right).normalize();
    let colors: Vec<[f32; 3]> = (0..mesh.triangles.len())
        .map(|t| {
            let n = mesh.normal(t);
            let facing = if n.dot(back) < 0.0 { -n } else { n };
            let shade = (0.42 + 0.58 * facing.dot(light).max(0.0)) as f32;
            let base = match options.color_by {
                ColorBy::Face => face_color(mesh.labels[t]),
                ColorBy::Quality => quality_color(shape(mesh.corners(t)).min_angle),
            };
            // the inside shows only through holes: gray it
            let base = if n.dot(back) < 0.0 { base.map(|c| 0.35 + 0.25 * c) } else { base };
            base.map(|c| c * shade)
        })
        .collect();

    let mut lines: Vec<Line> = Vec::new();
    let mean = mesh.mean_edge_length() * scale / samples;
    if options.wireframe && mean > WIREFRAME_PIXELS {
        let share = ((mean - WIREFRAME_PIXELS) / 20.0).clamp(0.12, 0.4) as f32;
        for ([a, b], _) in mesh.inner_edges() {
            lines.push((points[a as usize], points[b as usize], 0.8, [0.05, 0.08, 0.12], share));
        }
    }
    run.check()?;
    let dark = [0.07, 0.09, 0.13];
    for [a, b] in mesh.sharp_edges(options.sharp_angle) {
        lines.push((points[a as usize], points[b as usize], 2.0, dark, 0.95));
    }
    for [a, b] in mesh.defects().open_edges {
        lines.push((points[a as usize], points[b as usize], 2.6, [0.85, 0.1, 0.1], 1.0));
    }
    run.check()?;

    let bias = 0.35 * mean.min(4.0) * samples;
    let bands = height.div_ceil(BAND);
    let (by_band, lines_by_band) = (bin(bands, mesh.triangles.iter().map(|t| t.map(|v| points[v as usize].y))), {
        bin(
            bands,
            lines
                .iter()
                .map(|l| [l.0.y - 2.0 * l.2 * samples, l.1.y + 2.0 * l.2 * samples, l.0.y.max(l.1.y) + l.2 * samples]),
        )
    });
    let painted: Vec<Vec<u8>> = run.install(|| {
        (0..bands)
            .into_par_iter()
            .map(|b| {
                if run.is_cancelled() {
                    return Vec::new();
                }
                let rows = BAND.min(height - b * BAND);
                let mut band =
                    Band::new(width * SAMPLES, b * BAND * SAMPLES, rows * SAMPLES, |r| background(r, height * SAMPLES));
                for t in &by_band[b] {
                    let t = *t as usize;
                    band.triangle(mesh.triangles[t].map(|v| points[v as usize]), colors[t]);
                }
                for l in &lines_by_band[b] {
                    let (from, to, thick, color, share) = lines[*l as usize];
                    band.line(from, to, thick * samples, bias, color, share);
                }
                shrink(&band, width, rows)
            })
            .collect()
    });
    run.check()?;
    let mut picture = Picture { width: options.width, height: options.height, rgb: painted.concat() };
    if legend_width > 0.0 {
        legend(mesh, &mut picture, legend_width);
    }
    Ok(picture)
}

/// Which items touch which band, by the sample rows they cover.
fn bin(bands: usize, rows: impl Iterator<Item = [f64; 3]>) -> Vec<Vec<u32>> {
    let mut out = vec![Vec::new(); bands];
    let step = (BAND * SAMPLES) as f64;
    for (i, y) in rows.enumerate() {
        let lo = y.iter().copied().fold(f64::INFINITY, f64::min);
        let hi = y.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let first = (lo / step).floor().max(0.0) as usize;
        let last = (hi / step).floor().clamp(-1.0, bands as f64 - 1.0);
        if last >= 0.0 {
            (first..=last as usize).for_each(|b| out[b].push(i as u32));
        }
    }
    out
}

/// Averages the samples of every pixel.
fn shrink(band: &Band, width: usize, rows: usize) -> Vec<u8> {
    let mut out = Vec::with_capacity(3 * width * rows);
    for y in 0..rows {
        for x in 0..width {
            let mut sum = [0.0f32; 3];
            for j in 0..SAMPLES {
                for i in 0..SAMPLES {
                    let c = band.color[(y * SAMPLES + j) * band.width + x * SAMPLES + i];
                    (0..3).for_each(|k| sum[k] += c[k]);
                }
            }
            out.extend(sum.map(|c| (255.0 * c / (SAMPLES * SAMPLES) as f32).round().clamp(0.0, 255.0) as u8));
        }
    }
    out
}

/// Size of the legend's letters in pixels.
fn letter(height: usize) -> f64 {
    (height as f64 / 62.0).clamp(11.0, 22.0)
}

/// The faces a legend lists: those with triangles, unless there are too many.
fn listed(mesh: &TriMesh) -> Vec<u32> {
    let mut used = vec![false; mesh.faces.len()];
    mesh.labels.iter().for_each(|l| used[*l as usize] = true);
    let all: Vec<u32> = (0..mesh.faces.len() as u32).filter(|i| used[*i as usize]).collect();
    if (2..=LEGEND).contains(&all.len()) { all } else { Vec::new() }
}

fn legend_space(mesh: &TriMesh, height: usize) -> f64 {
    let h = letter(height);
    let widest = listed(mesh).iter().map(|i| text_width(&mesh.faces[*i as usize], h)).fold(0.0, f64::max);
    if widest > 0.0 { widest.min(30.0 * h) + 4.0 * h } else { 0.0 }
}

fn legend(mesh: &TriMesh, picture: &mut Picture, space: f64) {
    let h = letter(picture.height as usize);
    let left = f64::from(picture.width) - space + h;
    for (row, i) in listed(mesh).into_iter().enumerate() {
        let top = (1.5 + 1.7 * row as f64) * h;
        let color = face_color(i).map(|c| (255.0 * c) as u8);
        for y in 0..(1.1 * h) as i64 {
            for x in 0..(1.1 * h) as i64 {
                picture.mix(left as i64 + x, top as i64 + y, color, 1.0);
            }
        }
        text(picture, &mesh.faces[i as usize], left + 1.8 * h, top + 0.05 * h, h, [40, 44, 52]);
    }
}
