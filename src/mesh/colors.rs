//! Colors by which faces are told apart, in pictures and in files.

use rustc_hash::FxHashSet;

use super::TriMesh;
use crate::numeric::NONE;

/// Light and distinct at equal brightness; none is like the colors pictures warn by or show the inside in.
const FACES: [[f32; 3]; 12] = [
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

/// A color for each face, red, green and blue in 0..=1, sRGB: the ones of pictures.
///
/// Each name asks for the color its letters add up to and gets the first from there on that no touching
/// face has, and that no other face has as long as there are enough. Names are served in alphabetical order, so that
/// numbering does not matter and a part looks alike in all stages of a comparison.
pub(crate) fn face_colors(mesh: &TriMesh) -> Vec<[f32; 3]> {
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
