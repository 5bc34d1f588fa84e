//! The rasterizer: bands of pixel rows, each with its own depth samples, drawn in parallel.

use glam::{DVec3, Vec2, Vec3};
use rayon::prelude::*;

use crate::error::Result;
use crate::mesh::TriMesh;
use crate::numeric::NONE;
use crate::run::Run;
use crate::spatial::Aabb;

use super::RenderOptions;
use super::clip::Clipping;
use super::edges::{self, DrawnLine};
use super::palette::{ALARM, BACKGROUND, INK, INSIDE, Rgb, TriangleColors, mix};
use super::picture::Picture;

/// Pixel rows of a band: few enough that its samples stay in the cache, many enough that few triangles lie in two.
const BAND: usize = 16;
/// How bright a triangle is that the light grazes; the rest up to 1 goes with the cosine.
const AMBIENT: f32 = 0.5;
/// Lets sides that face the camera rather than the light keep the clean color of the legend.
const EXPOSURE: f32 = 1.1;
/// The share of ink on the edges of large triangles.
const WIRE_STRENGTH: f32 = 0.30;
/// Mean triangle edges, in pixels, from which on edges begin to show by themselves,
const WIRE_FROM: f32 = 5.0;
/// and from which on they are fully drawn.
const WIRE_FULL: f32 = 14.0;

/// Half the width in pixels and the color of a line, and how much it covers.
fn style(line: DrawnLine) -> (f32, Rgb, f32) {
    match line {
        DrawnLine::Alarm => (1.5, ALARM, 1.0),
        DrawnLine::Sharp => (1.0, INK, 0.95),
        DrawnLine::Border => (0.6, INK, 0.6),
        DrawnLine::Cut => (1.0, INK, 0.95),
    }
}

/// A line on the picture, ends in pixels and depth.
struct Segment {
    ends: [Vec3; 2],
    line: DrawnLine,
}

/// What is drawn, and how.
pub(super) struct Shot<'a> {
    pub(super) mesh: &'a TriMesh,
    pub(super) options: &'a RenderOptions,
    /// Unit vectors to the right, upwards and towards the camera.
    pub(super) axes: [DVec3; 3],
    pub(super) clipping: &'a Clipping<'a>,
    pub(super) look: &'a TriangleColors<'a>,
}

/// Red, green and blue times opacity, and opacity.
type Paint = [f32; 4];

/// A mesh projected to pixels (x right, y down, depth towards the camera), with everything sorted into bands.
pub(super) struct Scene<'a> {
    mesh: &'a TriMesh,
    samples: usize,
    room: usize,
    ground: Paint,
    points: Vec<Vec3>,
    /// For each clipping plane the distances of all nodes, not negative where the mesh stays.
    sides: Vec<Vec<f32>>,
    colors: Vec<Rgb>,
    segments: Vec<Segment>,
    wire: f32,
    triangles_of_band: Vec<Vec<u32>>,
    segments_of_band: Vec<Vec<u32>>,
}

impl<'a> Scene<'a> {
    /// Prepares a picture whose left `room` columns show the mesh.
    pub(super) fn new(shot: &Shot<'a>, room: usize, run: &Run) -> Result<Self> {
        let Shot { mesh, options, axes, clipping, look } = *shot;
        let camera = Camera::new(shot, room);
        let points: Vec<Vec3> = mesh.nodes.par_iter().map(|p| camera.place(*p)).collect();
        run.check()?;
        // From above the camera's left shoulder, so that the three sides of a box differ.
        let light = (axes[2] + 0.45 * axes[1] - 0.35 * axes[0]).normalize();
        let colors = (0..mesh.triangles.len()).into_par_iter().map(|t| shade(mesh, t, look, light, axes[2])).collect();
        run.check()?;
        let lines = options.sharp_angle.map_or_else(Vec::new, |angle| edges::lines(mesh, angle));
        run.check()?;
        let place = |v: u32| points[v as usize];
        let segments: Vec<_> = if clipping.is_active() {
            let ends = |a: u32, b: u32| [mesh.nodes[a as usize], mesh.nodes[b as usize]];
            let left = lines.into_iter().filter_map(|(a, b, line)| Some((clipping.clipped(ends(a, b))?, line)));
            let cuts =
                clipping.cuts.iter().filter(|_| options.sharp_angle.is_some()).map(|ends| (*ends, DrawnLine::Cut));
            let all = left.chain(cuts);
            all.map(|(ends, line)| Segment { ends: ends.map(|p| camera.place(p)), line }).collect()
        } else {
            lines.into_iter().map(|(a, b, line)| Segment { ends: [place(a), place(b)], line }).collect()
        };

        let bands = options.height.div_ceil(BAND);
        let mut triangles_of_band = vec![Vec::new(); bands];
        let mut edge_length = 0.0;
        for (t, corners) in mesh.triangles.iter().enumerate() {
            let p = corners.map(place);
            edge_length += (0..3).map(|i| f64::from((p[i] - p[(i + 1) % 3]).truncate().length())).sum::<f64>();
            let (lo, hi) = (p[0].y.min(p[1].y).min(p[2].y), p[0].y.max(p[1].y).max(p[2].y));
            if clipping.keeps(t) {
                bands_between(lo, hi, bands).for_each(|b| triangles_of_band[b].push(t as u32));
            }
        }
        let mut segments_of_band = vec![Vec::new(); bands];
        for (i, Segment { ends: [a, b], line }) in segments.iter().enumerate() {
            let reach = style(*line).0;
            bands_between(a.y.min(b.y) - reach, a.y.max(b.y) + reach, bands)
                .for_each(|b| segments_of_band[b].push(i as u32));
        }
        let mean = (edge_length / (3 * mesh.triangles.len()) as f64) as f32;
        let wire = match options.wireframe {
            Some(true) => WIRE_STRENGTH,
            Some(false) => 0.0,
            None => WIRE_STRENGTH * ((mean - WIRE_FROM) / (WIRE_FULL - WIRE_FROM)).clamp(0.0, 1.0),
        };
        let samples = options.samples;
        let ground = if options.transparent { [0.0; 4] } else { solid(BACKGROUND) };
        let sides = clipping.sides();
        Ok(Self {
            mesh,
            samples,
            room,
            ground,
            points,
            sides,
            colors,
            segments,
            wire,
            triangles_of_band,
            segments_of_band,
        })
    }

    /// Draws the scene into the left part of the picture.
    pub(super) fn draw(&self, picture: &mut Picture, run: &Run) -> Result<()> {
        let row = picture.width;
        let bands = picture.rgb.par_chunks_mut(3 * row * BAND).enumerate();
        let work = |band: usize, pixels: &mut [u8], alpha: &mut [u8]| {
            run.check()?;
            self.draw_band(band, row, pixels, alpha);
            Ok(())
        };
        match &mut picture.alpha {
            Some(alpha) => bands.zip(alpha.par_chunks_mut(row * BAND)).try_for_each(|((i, p), a)| work(i, p, a)),
            None => bands.try_for_each(|(i, p)| work(i, p, &mut [])),
        }
    }

    /// Draws rows of `row` pixels each, with their opacities where the picture has some.
    fn draw_band(&self, number: usize, row: usize, pixels: &mut [u8], alpha: &mut [u8]) {
        let n = self.samples;
        let (columns, rows) = (self.room * n, pixels.len() / (3 * row) * n);
        let top = number * BAND * n;
        let band = Band { top, columns, rows };
        let mut depth = vec![f32::NEG_INFINITY; columns * rows];
        let mut owner = vec![NONE; columns * rows];
        for &t in &self.triangles_of_band[number] {
            self.cover(t, &band, &mut depth, &mut owner);
        }
        let mut color: Vec<Paint> = owner
            .iter()
            .enumerate()
            .map(|(i, t)| match *t {
                NONE => self.ground,
                t => {
                    let ink = self.wire_at(t, self.sample(i % columns, top + i / columns));
                    solid(mix(self.colors[t as usize], INK, ink))
                }
            })
            .collect();
        // Alarms come last: nothing may cover them.
        for alarms in [false, true] {
            for segment in self.segments_of_band[number].iter().map(|i| &self.segments[*i as usize]) {
                if (segment.line == DrawnLine::Alarm) == alarms {
                    self.cover_line(segment, &band, &depth, &mut color);
                }
            }
        }
        let byte = |c: f32| c.round().clamp(0.0, 255.0) as u8;
        let share = 255.0 / (n * n) as f32;
        for (y, line) in pixels.chunks_mut(3 * row).enumerate() {
            for (x, pixel) in line.chunks_mut(3).take(self.room).enumerate() {
                let mut sum = [0.0; 4];
                for sy in 0..n {
                    let start = (y * n + sy) * columns + x * n;
                    for c in &color[start..start + n] {
                        (0..4).for_each(|k| sum[k] += c[k]);
                    }
                }
                if let Some(alpha) = alpha.get_mut(y * row + x) {
                    *alpha = byte(sum[3] * share);
                    let whole = if sum[3] > 0.0 { 255.0 / sum[3] } else { 0.0 };
                    (0..3).for_each(|k| pixel[k] = byte(sum[k] * whole));
                } else {
                    (0..3).for_each(|k| pixel[k] = byte(sum[k] * share));
                }
            }
        }
    }

    /// Where a sample lies, in pixels.
    fn sample(&self, column: usize, row: usize) -> Vec2 {
        Vec2::new(column as f32 + 0.5, row as f32 + 0.5) / self.samples as f32
    }

    /// The samples from `lo` to `hi` (pixels) of `count` that begin at sample `first`.
    fn range(&self, lo: f32, hi: f32, first: usize, count: usize) -> std::ops::Range<usize> {
        let n = self.samples as f32;
        let from = (lo * n - 0.5 - first as f32).ceil().max(0.0) as usize;
        let to = ((hi * n - 0.5 - first as f32).floor() + 1.0).max(0.0) as usize;
        from.min(count)..to.min(count)
    }

    fn cover(&self, t: u32, band: &Band, depth: &mut [f32], owner: &mut [u32]) {
        let Band { top, columns, rows } = *band;
        let [a, b, c] = self.mesh.triangles[t as usize].map(|v| self.points[v as usize]);
        let (p, q, r) = (a.truncate(), b.truncate(), c.truncate());
        let area = (q - p).perp_dot(r - p);
        if area == 0.0 {
            return;
        }
        let (lo, hi) = (p.min(q).min(r), p.max(q).max(r));
        let across = self.range(lo.x, hi.x, 0, columns);
        let stays = |u: f32, v: f32, w: f32| {
            self.sides.iter().all(|side| {
                let [d, e, f] = self.mesh.triangles[t as usize].map(|v| side[v as usize]);
                u * d + v * e + w * f >= 0.0
            })
        };
        for row in self.range(lo.y, hi.y, top, rows) {
            for column in across.clone() {
                let s = self.sample(column, top + row);
                let u = (r - q).perp_dot(s - q) / area;
                let v = (p - r).perp_dot(s - r) / area;
                let w = (q - p).perp_dot(s - p) / area;
                if u >= 0.0 && v >= 0.0 && w >= 0.0 {
                    let z = u * a.z + v * b.z + w * c.z;
                    let i = row * columns + column;
                    if z > depth[i] && stays(u, v, w) {
                        depth[i] = z;
                        owner[i] = t;
                    }
                }
            }
        }
    }

    /// How much ink the edges of the triangle put on a sample inside it.
    fn wire_at(&self, t: u32, s: Vec2) -> f32 {
        /// Half the width of an edge in pixels; each of its two triangles draws one half.
        const HALF: f32 = 0.45;
        if self.wire == 0.0 {
            return 0.0;
        }
        let p = self.mesh.triangles[t as usize].map(|v| self.points[v as usize].truncate());
        let near = (0..3).any(|i| {
            let (a, d) = (p[i], p[(i + 1) % 3] - p[i]);
            d.perp_dot(s - a).abs() < HALF * d.length()
        });
        if near { self.wire } else { 0.0 }
    }

    fn cover_line(&self, segment: &Segment, band: &Band, depth: &[f32], color: &mut [Paint]) {
        let Band { top, columns, rows } = *band;
        let (half, ink, strength) = style(segment.line);
        let [a, b] = segment.ends;
        let (p, d) = (a.truncate(), b.truncate() - a.truncate());
        let squared = d.length_squared();
        let (lo, hi) = (p.min(p + d) - half, p.max(p + d) + half);
        let across = self.range(lo.x, hi.x, 0, columns);
        // Depth is in pixels too: a surface may rise by so much over the line's own width before it hides the line.
        let bias = 2.5 * half;
        for row in self.range(lo.y, hi.y, top, rows) {
            for column in across.clone() {
                let s = self.sample(column, top + row);
                let along = if squared > 0.0 { ((s - p).dot(d) / squared).clamp(0.0, 1.0) } else { 0.0 };
                if (p + along * d).distance_squared(s) > half * half {
                    continue;
                }
                let i = row * columns + column;
                if a.z + along * (b.z - a.z) + bias >= depth[i] {
                    color[i] = mix(color[i], solid(ink), strength);
                }
            }
        }
    }
}

fn solid([r, g, b]: Rgb) -> Paint {
    [r, g, b, 1.0]
}

/// Rows of samples that are drawn together: the first one, and how many there are across and down.
#[derive(Clone, Copy)]
struct Band {
    top: usize,
    columns: usize,
    rows: usize,
}

/// Turns points to pixels: fitted into the room with the margin, y downwards, depth in pixels as well.
struct Camera {
    axes: [DVec3; 3],
    scale: f64,
    center: DVec3,
    fit: f64,
    middle: DVec3,
}

impl Camera {
    fn new(shot: &Shot, room: usize) -> Self {
        let Shot { mesh, options, axes, clipping, .. } = *shot;
        // Coordinates are first brought to the order of 1, so that no difference of huge ones overflows.
        let scale = mesh.nodes.iter().fold(f64::MIN_POSITIVE, |m, p| m.max(p.abs().max_element()));
        let mut camera = Self { axes, scale, center: DVec3::ZERO, fit: 1.0, middle: DVec3::ZERO };
        let bounds = match options.view.focus {
            Some((center, radius)) => {
                let (c, r) = (camera.turned(center), DVec3::splat(radius / scale));
                Aabb::new(c - r, c + r)
            }
            None if clipping.is_active() => Aabb::around(clipping.ends().into_iter().map(|p| camera.turned(p))),
            None => Aabb::around(mesh.triangles.iter().flatten().map(|v| camera.turned(mesh.nodes[*v as usize]))),
        };
        let (width, height) = (room as f64, options.height as f64);
        let free = 1.0 - 2.0 * options.view.margin;
        let size = bounds.size();
        let fit = (free * width / size.x).min(free * height / size.y);
        // A single point has no size to fit.
        camera.fit = if fit.is_finite() { fit } else { 1.0 };
        camera.center = bounds.center();
        camera.middle = DVec3::new(0.5 * width, 0.5 * height, 0.0);
        camera
    }

    fn turned(&self, p: DVec3) -> DVec3 {
        let p = p / self.scale;
        DVec3::new(self.axes[0].dot(p), -self.axes[1].dot(p), self.axes[2].dot(p))
    }

    fn place(&self, p: DVec3) -> Vec3 {
        ((self.turned(p) - self.center) * self.fit + self.middle).as_vec3()
    }
}

fn shade(mesh: &TriMesh, t: usize, look: &TriangleColors, light: DVec3, towards: DVec3) -> Rgb {
    let n = mesh.normal(t);
    let (base, n) = if n.dot(towards) < 0.0 { (INSIDE, -n) } else { (look.color(mesh, t), n) };
    let bright = AMBIENT + (1.0 - AMBIENT) * n.dot(light).max(0.0) as f32;
    base.map(|c| (c * bright * EXPOSURE).min(1.0))
}

/// The bands that the rows from `lo` to `hi` touch.
fn bands_between(lo: f32, hi: f32, bands: usize) -> std::ops::Range<usize> {
    let from = (lo / BAND as f32).floor().max(0.0) as usize;
    let to = ((hi / BAND as f32).floor() + 1.0).max(0.0) as usize;
    from.min(bands)..to.min(bands)
}
