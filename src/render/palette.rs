//! Colors: of faces, of measures, of everything drawn on top; and the legend that explains them.

use crate::mesh::{TriMesh, face_colors};

use super::ColorBy;
use super::clip::Clipping;
use super::picture::{Picture, TEXT_HEIGHT, shortened, text_width};

/// Red, green and blue in 0..=1, sRGB.
pub(super) type Rgb = [f32; 3];

/// Behind everything.
pub(super) const BACKGROUND: Rgb = [0.965, 0.97, 0.98];
/// Text and sharp edges.
pub(super) const INK: Rgb = [0.10, 0.12, 0.16];
/// Open boundaries and edges of more than two triangles.
pub(super) const ALARM: Rgb = [0.86, 0.08, 0.12];
/// Triangles seen from behind: no face color, so that a hole or a flipped triangle strikes the eye.
pub(super) const INSIDE: Rgb = [0.55, 0.50, 0.50];

/// A color at a value; a scale goes straight from one to the next.
type Stop = (f32, Rgb);

/// The scale of smallest angles in degrees. 20° and 30° are what analysts ask for; 60° is the best there is.
const ANGLES: [Stop; 5] = [
    (0.0, [0.75, 0.05, 0.15]),
    (10.0, [0.95, 0.45, 0.20]),
    (20.0, [0.99, 0.85, 0.45]),
    (30.0, [0.62, 0.84, 0.58]),
    (60.0, [0.25, 0.52, 0.80]),
];

/// The scale of edge lengths: the binary logarithm of their ratio to the mean.
const LENGTHS: [Stop; 5] = [
    (-2.0, [0.18, 0.35, 0.72]),
    (-1.0, [0.45, 0.68, 0.88]),
    (0.0, [0.90, 0.90, 0.80]),
    (1.0, [0.96, 0.62, 0.38]),
    (2.0, [0.72, 0.12, 0.20]),
];

/// The scale of distances, as shares of the largest.
const DISTANCES: [Stop; 5] = [
    (0.0, [0.25, 0.52, 0.80]),
    (0.25, [0.55, 0.80, 0.66]),
    (0.5, [0.97, 0.88, 0.50]),
    (0.75, [0.95, 0.52, 0.26]),
    (1.0, [0.72, 0.08, 0.18]),
];

/// Regular nodes, nodes on creases, corners.
const CLASSES: [Rgb; 3] = [[0.80, 0.84, 0.88], [0.96, 0.65, 0.30], [0.75, 0.08, 0.16]];

/// Triangles with a node near which there is no surface.
const LOST: Rgb = [0.85, 0.25, 0.85];

/// The most faces a legend lists.
const LEGEND_FACES: usize = 16;
/// The most characters of a name a legend shows.
const LEGEND_CHARS: usize = 22;
/// Where there is room for fewer characters of a name than this there is no legend.
const LEGEND_LEAST: usize = 5;
/// The most a legend takes from the picture's width, as a share.
const LEGEND_SHARE: f32 = 0.4;
/// Free pixels between the parts of a legend.
const PAD: usize = 8;
/// Pixels of a legend's line.
const LINE: usize = TEXT_HEIGHT + PAD;

/// The color of every triangle before shading.
pub(super) struct TriangleColors<'a> {
    faces: Vec<Rgb>,
    by: &'a ColorBy,
    /// The mean edge length, or the largest finite distance.
    unit: f64,
}

impl<'a> TriangleColors<'a> {
    pub(super) fn new(mesh: &TriMesh, by: &'a ColorBy) -> Self {
        let (faces, unit) = match by {
            ColorBy::Face => (face_colors(mesh), 1.0),
            ColorBy::Angle | ColorBy::Class(_) => (Vec::new(), 1.0),
            ColorBy::Edge => (Vec::new(), mesh.mean_edge_length()),
            ColorBy::Distance(d) => {
                let used = mesh.triangles.iter().flatten().map(|v| d[*v as usize]);
                (Vec::new(), used.filter(|d| d.is_finite()).fold(0.0, f64::max))
            }
        };
        Self { faces, by, unit }
    }

    pub(super) fn color(&self, mesh: &TriMesh, t: usize) -> Rgb {
        match self.by {
            ColorBy::Face => self.faces[mesh.labels[t] as usize],
            ColorBy::Angle => on_scale(&ANGLES, smallest_angle(mesh, t)),
            ColorBy::Edge => {
                let [a, b, c] = mesh.corners(t);
                let ratio = (a.distance(b) + b.distance(c) + c.distance(a)) / (3.0 * self.unit);
                on_scale(&LENGTHS, if ratio.is_nan() { 0.0 } else { ratio.log2() as f32 })
            }
            ColorBy::Class(classes) => {
                let highest = mesh.triangles[t].iter().map(|v| classes[*v as usize]).max().unwrap_or(0);
                CLASSES[usize::from(highest.min(2))]
            }
            ColorBy::Distance(d) => {
                let [a, b, c] = mesh.triangles[t].map(|v| d[v as usize]);
                if !(a.is_finite() && b.is_finite() && c.is_finite()) {
                    return LOST;
                }
                let largest = a.max(b).max(c);
                on_scale(&DISTANCES, if self.unit > 0.0 { (largest / self.unit) as f32 } else { 0.0 })
            }
        }
    }

    /// The legend of what is left of the mesh, if there is something to explain and it fits a picture of that width and height.
    pub(super) fn legend(&self, mesh: &TriMesh, clipping: &Clipping, [width, height]: [usize; 2]) -> Option<Legend> {
        let lines = height.saturating_sub(2 * PAD) / LINE;
        let beside = TEXT_HEIGHT + 3 * PAD;
        let chars = ((LEGEND_SHARE * width as f32) as usize).saturating_sub(beside) / text_width("m");
        let mut entries = match self.by {
            ColorBy::Face => self.names(mesh, clipping, lines, chars.min(LEGEND_CHARS))?,
            _ => self.scale(mesh),
        };
        if clipping.is_active() && entries.len() < lines {
            entries.push((Some(INSIDE), "inside".into()));
        }
        let longest = entries.iter().map(|l| l.1.chars().count()).max()?;
        (entries.len() <= lines && longest <= chars)
            .then(|| Legend { width: longest * text_width("m") + beside, lines: entries })
    }

    fn names(&self, mesh: &TriMesh, clipping: &Clipping, lines: usize, chars: usize) -> Option<Vec<LegendLine>> {
        let mut used = vec![false; mesh.faces.len()];
        let kept = mesh.labels.iter().enumerate().filter(|(t, _)| clipping.keeps(*t));
        kept.for_each(|(_, l)| used[*l as usize] = true);
        let used: Vec<usize> = (0..mesh.faces.len()).filter(|f| used[*f]).collect();
        let most = lines.min(LEGEND_FACES);
        // A single face explains itself.
        if used.len() < 2 || most < 2 || chars < LEGEND_LEAST {
            return None;
        }
        let shown = if used.len() > most { most - 1 } else { used.len() };
        let entry = |f: &usize| (Some(self.faces[*f]), shortened(&mesh.faces[*f], chars));
        let mut entries: Vec<LegendLine> = used[..shown].iter().map(entry).collect();
        if shown < used.len() {
            let more = used.len() - shown;
            let text = format!("and {more} more");
            entries.push((None, if text.len() <= chars { text } else { shortened(&format!("+{more}"), chars) }));
        }
        Some(entries)
    }

    fn scale(&self, mesh: &TriMesh) -> Vec<LegendLine> {
        let title = |text: &str| (None, text.to_string());
        match self.by {
            ColorBy::Face => Vec::new(),
            ColorBy::Angle => {
                let marks = [60.0, 50.0, 40.0, 30.0, 20.0, 10.0, 0.0];
                let marks = marks.iter().map(|a| (Some(on_scale(&ANGLES, *a)), format!("{a} deg")));
                [title("smallest angle")].into_iter().chain(marks).collect()
            }
            ColorBy::Edge => {
                let marks = [(2.0, "4 or more"), (1.0, "2"), (0.0, "1"), (-1.0, "0.5"), (-2.0, "0.25 or less")];
                let marks = marks.iter().map(|(l, text)| (Some(on_scale(&LENGTHS, *l)), text.to_string()));
                let mean = (None, format!("mean {}", brief(self.unit)));
                [title("edge / mean")].into_iter().chain(marks).chain([mean]).collect()
            }
            ColorBy::Class(_) => {
                let marks = ["regular", "crease", "corner"].into_iter().zip(CLASSES);
                [title("nodes")].into_iter().chain(marks.map(|(n, c)| (Some(c), n.to_string()))).collect()
            }
            ColorBy::Distance(d) => {
                let shares = [1.0, 0.75, 0.5, 0.25, 0.0];
                // Where all distances are 0 one color is all there is.
                let shares = if self.unit > 0.0 { &shares[..] } else { &shares[4..] };
                let marks = shares.iter().map(|s| (Some(on_scale(&DISTANCES, *s)), brief(f64::from(*s) * self.unit)));
                let lost = mesh.triangles.iter().flatten().any(|v| !d[*v as usize].is_finite());
                let lost = lost.then(|| (Some(LOST), "unknown".to_string()));
                [title("distance")].into_iter().chain(marks).chain(lost).collect()
            }
        }
    }
}

/// A number with three digits that count.
fn brief(x: f64) -> String {
    let digits = 2 - (x.abs().log10().floor().clamp(-1e3, 1e3) as i32);
    match digits {
        _ if x == 0.0 => "0".into(),
        0..=5 => format!("{x:.*}", digits as usize),
        -2..0 => format!("{x:.0}"),
        _ => format!("{x:.2e}"),
    }
}

/// A color, where the text has one, and the text.
type LegendLine = (Option<Rgb>, String);

/// Colored squares with a text each.
pub(super) struct Legend {
    /// Pixels it takes from the picture's width.
    pub(super) width: usize,
    pub(super) lines: Vec<LegendLine>,
}

impl Legend {
    /// Draws it from column `x` on, centered in height.
    pub(super) fn draw(&self, picture: &mut Picture, x: usize) {
        let top = picture.height.saturating_sub(self.lines.len() * LINE) / 2;
        for (i, (color, text)) in self.lines.iter().enumerate() {
            let y = top + i * LINE;
            if let Some(color) = color {
                picture.fill(x, y, TEXT_HEIGHT, TEXT_HEIGHT, INK);
                picture.fill(x + 1, y + 1, TEXT_HEIGHT - 2, TEXT_HEIGHT - 2, *color);
                picture.text(x + TEXT_HEIGHT + PAD, y + 2, text, INK);
            } else {
                picture.text(x, y + 2, text, INK);
            }
        }
    }
}

/// The smallest angle of a triangle in degrees, 0 for a degenerate one.
fn smallest_angle(mesh: &TriMesh, t: usize) -> f32 {
    let p = mesh.corners(t);
    let angle = |i: usize| {
        let (u, v) = (p[(i + 1) % 3] - p[i], p[(i + 2) % 3] - p[i]);
        u.cross(v).length().atan2(u.dot(v))
    };
    let smallest = (0..3).map(angle).fold(f64::INFINITY, f64::min).to_degrees();
    let degenerate = mesh.area_vector(t).length() == 0.0;
    if degenerate { 0.0 } else { smallest as f32 }
}

fn on_scale(stops: &[Stop], value: f32) -> Rgb {
    let above = stops.iter().position(|s| value < s.0).unwrap_or(stops.len() - 1).max(1);
    let ((lo, a), (hi, b)) = (stops[above - 1], stops[above]);
    mix(a, b, ((value - lo) / (hi - lo)).clamp(0.0, 1.0))
}

/// `a` covered by a share `t` of `b`.
pub(super) fn mix<const N: usize>(a: [f32; N], b: [f32; N], t: f32) -> [f32; N] {
    std::array::from_fn(|i| a[i] + t * (b[i] - a[i]))
}
