//! Fillings too small to be faces of their own.

use rustc_hash::FxHashMap;

use super::holes::FILLED;
use super::sides::{EdgeSide, Sides, directed, pieces};
use crate::mesh::TriMesh;

/// What is known of a filling.
#[derive(Default)]
struct FillingState {
    area: f64,
    /// Length of its border with each other face, open edges left out.
    borders: FxHashMap<u32, f64>,
    perimeter: f64,
}

/// Gives fillings of less than an area, or narrower than a width (twice their area over their perimeter), to the face with
/// which they share the longest border: a mesh of edges about as long has no room for their own. Those that border on no
/// other face stay. Returns how many fillings that were.
pub fn absorb_fillings(mesh: &mut TriMesh, area: f64, width: f64) -> usize {
    let Some(filled) = mesh.faces.iter().position(|f| f == FILLED).map(|f| f as u32) else { return 0 };
    let sides = Sides::of(&mesh.triangles);
    let label = |s: &EdgeSide| mesh.labels[s.triangle()];
    let (piece, count) = pieces(mesh.triangles.len(), &sides, |e| e.iter().all(|s| label(s) == filled));
    let mut found: Vec<FillingState> = (0..count).map(|_| FillingState::default()).collect();
    for (t, p) in piece.iter().enumerate() {
        found[*p as usize].area += 0.5 * mesh.area_vector(t).length();
    }
    for e in sides.edges().filter(|e| e.len() == 1 || e.iter().any(|s| label(s) != filled)) {
        let [a, b] = directed(&mesh.triangles, e[0].half).map(|v| mesh.nodes[v as usize]);
        let length = a.distance(b);
        for s in e.iter().filter(|s| label(s) == filled) {
            let f = &mut found[piece[s.triangle()] as usize];
            f.perimeter += length;
            for other in e.iter().map(label).filter(|l| *l != filled) {
                *f.borders.entry(other).or_default() += length;
            }
        }
    }
    let to: Vec<Option<u32>> = found
        .iter()
        .map(|f| {
            if f.area >= area && 2.0 * f.area >= width * f.perimeter {
                return None;
            }
            let longest = f.borders.iter().max_by(|x, y| x.1.total_cmp(y.1).then(y.0.cmp(x.0)));
            longest.map(|(label, _)| *label)
        })
        .collect();
    for (t, p) in piece.iter().enumerate() {
        if let Some(label) = to[*p as usize] {
            mesh.labels[t] = label;
        }
    }
    to.into_iter().flatten().count()
}
