//! Colors: of faces, of qualities, of everything drawn on top; and the legend that explains them.

use rustc_hash::FxHashSet;

use crate::mesh::TriMesh;

use super::ColorBy;
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

/// Light, distinct at equal brightness, and none of them like [`ALARM`] or [`INSIDE`].
const FACES: [Rgb; 12] = [
    [0.49, 0.67, 0.87], // sky
    [0.96, 0.72, 0.45], // apricot
    [0.57, 0.79, 0.56], // leaf
    [0.78, 0.64, 0.86], // lilac
    [0.95, 0.86, 0.50], // straw
    [0.48, 0.79, 0.79], // teal
    [0.94, 0.66, 0.70], // rose
    [0.77, 0.69, 0.58], // sand
    [0.66, 0.83, 0.93], // ice
    [0.77, 0.85, 0.47], // lime
    [0.62, 0.63, 0.88], // iris
    [0.87, 0.62, 0.81], // orchid
];

/// The scale of smallest angles: degrees and color. 20° and 30° are what analysts ask for; 60° is the best there is.
const QUALITIES: [(f32, Rgb); 5] = [
    (0.0, [0.75, 0.05, 0.15]),
    (10.0, [0.95, 0.45, 0.20]),
    (20.0, [0.99, 0.85, 0.45]),
    (30.0, [0.62, 0.84, 0.58]),
    (60.0, [0.25, 0.52, 0.80]),
];

/// The most faces a legend lists.
const LEGEND_FACES: usize = 16;
/// The most characters of a name a legend shows.
const LEGEND_CHARS: usize = 22;
/// Free pixels between the parts of a legend.
const PAD: usize = 8;
/// Pixels of a legend's line.
const LINE: usize = TEXT_HEIGHT + PAD;

/// The color of every triangle before shading.
pub(super) struct Look {
    faces: Vec<Rgb>,
    by: ColorBy,
}

impl Look {
    pub(super) fn new(mesh: &TriMesh, by: ColorBy) -> Self {
        Self { faces: face_colors(mesh), by }
    }

    pub(super) fn color(&self, mesh: &TriMesh, t: usize) -> Rgb {
        match self.by {
            ColorBy::Face => self.faces[mesh.labels[t] as usize],
            ColorBy::Quality => quality_color(smallest_angle(mesh, t)),
        }
    }

    /// The legend, if there is something to explain and it fits the height.
    pub(super) fn legend(&self, mesh: &TriMesh, height: usize) -> Option<Legend> {
        let lines: Vec<(Rgb, String)> = match self.by {
            ColorBy::Face => {
                let mut used = vec![false; mesh.faces.len()];
                mesh.labels.iter().for_each(|l| used[*l as usize] = true);
                let shown = (0..mesh.faces.len()).filter(|f| used[*f]);
                shown.map(|f| (self.faces[f], shortened(&mesh.faces[f], LEGEND_CHARS))).collect()
            }
            ColorBy::Quality => {
                let marks = [60.0, 50.0, 40.0, 30.0, 20.0, 10.0, 0.0];
                marks.iter().map(|a| (quality_color(*a), format!("{a} deg"))).collect()
            }
        };
        // A single face explains itself.
        let fits = lines.len() > 1 && lines.len() <= LEGEND_FACES && lines.len() * LINE + 2 * PAD <= height;
        let text = lines.iter().map(|l| text_width(&l.1)).max()?;
        fits.then(|| Legend { width: text + TEXT_HEIGHT + 3 * PAD, lines })
    }
}

/// Colored squares with a text each.
pub(super) struct Legend {
    /// Pixels it takes from the picture's width.
    pub(super) width: usize,
    lines: Vec<(Rgb, String)>,
}

impl Legend {
    /// Draws it from column `x` on, centered in height.
    pub(super) fn draw(&self, picture: &mut Picture, x: usize) {
        let top = picture.height.saturating_sub(self.lines.len() * LINE) / 2;
        for (i, (color, text)) in self.lines.iter().enumerate() {
            let y = top + i * LINE;
            picture.fill(x, y, TEXT_HEIGHT, TEXT_HEIGHT, INK);
            picture.fill(x + 1, y + 1, TEXT_HEIGHT - 2, TEXT_HEIGHT - 2, *color);
            picture.text(x + TEXT_HEIGHT + PAD, y + 2, text, INK);
        }
    }
}

/// Colors by name: each name asks for the color its letters add up to and gets the first from there on that no touching
/// face has, and that no other face has as long as there are enough. Names are served in alphabetical order, so that
/// numbering does not matter and a part looks alike in all stages of a comparison.
fn face_colors(mesh: &TriMesh) -> Vec<Rgb> {
    let mut order: Vec<usize> = (0..mesh.faces.len()).collect();
    order.sort_by(|a, b| (&mesh.faces[*a], a).cmp(&(&mesh.faces[*b], b)));
    let mut touching = vec![Vec::new(); mesh.faces.len()];
    for (a, b) in touching_faces(mesh) {
        touching[a as usize].push(b as usize);
        touching[b as usize].push(a as usize);
    }
    let mut chosen: Vec<Option<usize>> = vec![None; mesh.faces.len()];
    let mut uses = [0usize; FACES.len()];
    let mut previous: Option<usize> = None;
    for face in order {
        let same = previous.filter(|p| mesh.faces[*p] == mesh.faces[face]).and_then(|p| chosen[p]);
        let wish = mesh.faces[face].bytes().fold(0usize, |sum, b| (31 * sum + b as usize) % 65_521);
        let taken: Vec<usize> = touching[face].iter().filter_map(|n| chosen[*n]).collect();
        let color = same.unwrap_or_else(|| {
            let candidates = (0..FACES.len()).map(|i| (wish + i) % FACES.len());
            candidates.min_by_key(|c| (taken.iter().filter(|t| *t == c).count(), uses[*c])).unwrap_or(0)
        });
        uses[color] += 1;
        chosen[face] = Some(color);
        previous = Some(face);
    }
    chosen.into_iter().map(|c| FACES[c.unwrap_or(0)]).collect()
}

/// Pairs of faces that share a node, sorted.
fn touching_faces(mesh: &TriMesh) -> Vec<(u32, u32)> {
    const NONE: u32 = u32::MAX;
    let mut first = vec![NONE; mesh.nodes.len()];
    let mut pairs = FxHashSet::default();
    for (corners, &label) in mesh.triangles.iter().zip(&mesh.labels) {
        for v in corners {
            let other = &mut first[*v as usize];
            if *other == NONE {
                *other = label;
            } else if *other != label {
                pairs.insert((label.min(*other), label.max(*other)));
            }
        }
    }
    let mut pairs: Vec<_> = pairs.into_iter().collect();
    pairs.sort_unstable();
    pairs
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

fn quality_color(angle: f32) -> Rgb {
    let above = QUALITIES.iter().position(|q| angle < q.0).unwrap_or(QUALITIES.len() - 1).max(1);
    let ((lo, a), (hi, b)) = (QUALITIES[above - 1], QUALITIES[above]);
    mix(a, b, ((angle - lo) / (hi - lo)).clamp(0.0, 1.0))
}

/// `a` covered by a share `t` of `b`.
pub(super) fn mix(a: Rgb, b: Rgb, t: f32) -> Rgb {
    std::array::from_fn(|i| a[i] + t * (b[i] - a[i]))
}
