//! Triangles and lines into a buffer of samples with depth.

use glam::{DVec2, DVec3};

/// Samples of a band of rows: the nearest depth and its color.
pub(super) struct Band {
    pub(super) width: usize,
    /// First sample row.
    pub(super) top: usize,
    pub(super) rows: usize,
    pub(super) depth: Vec<f32>,
    pub(super) color: Vec<[f32; 3]>,
}

impl Band {
    pub(super) fn new(width: usize, top: usize, rows: usize, background: impl Fn(usize) -> [f32; 3]) -> Self {
        let color = (0..rows).flat_map(|r| std::iter::repeat_n(background(top + r), width)).collect();
        Self { width, top, rows, depth: vec![f32::INFINITY; width * rows], color }
    }

    fn span(&self, lo: f64, hi: f64) -> std::ops::Range<usize> {
        let first = (lo - 0.5).ceil().max(self.top as f64) as usize;
        let last = ((hi - 0.5).floor() + 1.0).clamp(0.0, (self.top + self.rows) as f64) as usize;
        first..last.max(first)
    }

    /// Fills a triangle given in sample coordinates, `z` away from the viewer.
    pub(super) fn triangle(&mut self, [a, b, c]: [DVec3; 3], color: [f32; 3]) {
        let (p, q) = ((b - a).truncate(), (c - a).truncate());
        let area = p.perp_dot(q);
        if area == 0.0 || !area.is_finite() {
            return;
        }
        let (ylo, yhi) = (a.y.min(b.y).min(c.y), a.y.max(b.y).max(c.y));
        let (xlo, xhi) = (a.x.min(b.x).min(c.x), a.x.max(b.x).max(c.x));
        for y in self.span(ylo, yhi) {
            let first = (xlo - 0.5).ceil().max(0.0) as usize;
            let last = ((xhi - 0.5).floor() + 1.0).clamp(0.0, self.width as f64) as usize;
            for x in first..last {
                let r = DVec2::new(x as f64 + 0.5, y as f64 + 0.5) - a.truncate();
                let (v, w) = (r.perp_dot(q) / area, p.perp_dot(r) / area);
                if v < 0.0 || w < 0.0 || v + w > 1.0 {
                    continue;
                }
                let z = (a.z + v * (b.z - a.z) + w * (c.z - a.z)) as f32;
                let at = (y - self.top) * self.width + x;
                if z < self.depth[at] {
                    self.depth[at] = z;
                    self.color[at] = color;
                }
            }
        }
    }

    /// Draws a line of the given width where it is not behind what is there by more than `bias`, mixing its color in.
    pub(super) fn line(&mut self, a: DVec3, b: DVec3, width: f64, bias: f64, color: [f32; 3], share: f32) {
        let r = 0.5 * width;
        let d = (b - a).truncate();
        let length = d.length_squared();
        for y in self.span(a.y.min(b.y) - r, a.y.max(b.y) + r) {
            let first = (a.x.min(b.x) - r - 0.5).ceil().max(0.0) as usize;
            let last = ((a.x.max(b.x) + r - 0.5).floor() + 1.0).clamp(0.0, self.width as f64) as usize;
            for x in first..last {
                let p = DVec2::new(x as f64 + 0.5, y as f64 + 0.5) - a.truncate();
                let t = if length > 0.0 { (p.dot(d) / length).clamp(0.0, 1.0) } else { 0.0 };
                if (p - d * t).length_squared() > r * r {
                    continue;
                }
                let z = (a.z + t * (b.z - a.z) - bias) as f32;
                let at = (y - self.top) * self.width + x;
                if z < self.depth[at] {
                    for k in 0..3 {
                        self.color[at][k] += (color[k] - self.color[at][k]) * share;
                    }
                }
            }
        }
    }
}
