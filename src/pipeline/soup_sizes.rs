//! How long edges of a remeshed soup shall be: by curvature, and by what features close to each other ask for.

use super::discrete::SoupOptions;
use super::mesh::MeshOptions;
use super::report::Report;
use crate::discrete::Discrete;
use crate::optimize::Sizing;

/// Without a wish for it, curvature makes edges at most this many times shorter than the size.
const LEAST_SHARE: f64 = 4.0;
/// Without a tolerance edges stay within this share of the size of the surface.
const CHORD: f64 = 0.08;
/// Where that makes more than this many times the triangles that the size alone would, up to so many times that share.
const CROWDED: f64 = 1.12;
const RELAXED: [f64; 6] = [1.0, 1.25, 1.5, 2.0, 2.5, 3.0];
/// Edges stay within this share of the size of the features they are on, however crowded: a circle of radius 1 gets edges of 0.75.
const LINE: f64 = 0.043;
/// Features close to each other make edges at most this many times shorter than the size.
const LEAST_FEATURE: f64 = 20.0;
/// Where features alone ask for this many times the nodes that the area does, and for `MOST_NODES` more, they are too many to
/// be resolved.
const MOST_FEATURES: f64 = 2.0;
const MOST_NODES: f64 = 5e3;

pub(super) fn sizing(size: f64, options: &MeshOptions) -> Sizing {
    Sizing {
        size,
        nodes_per_radius: options.angle.map(|a| 1.0 / a.to_radians()),
        chord: Some(options.tolerance.unwrap_or(CHORD * size)),
        least: options.least.unwrap_or(size / LEAST_SHARE),
    }
}

/// Where the surface bends nearly everywhere so much that the size would mean little, edges may get farther from it, unless a
/// tolerance was asked for.
pub(super) fn relaxed(sizing: Sizing, options: &MeshOptions, soup: &SoupOptions, solid: &Discrete) -> Sizing {
    let simplified = soup.min_area > 0.0 || soup.min_length.is_some();
    if options.tolerance.is_some() || simplified {
        return sizing;
    }
    let at = |times: f64| Sizing { chord: sizing.chord.map(|c| times * c), ..sizing };
    let few = |s: &Sizing| solid.crowding(|k| s.at(k)) <= CROWDED;
    RELAXED.into_iter().map(at).find(few).unwrap_or(at(RELAXED[RELAXED.len() - 1]))
}

/// What features close to each other ask for; less where they are so many that a mesh would be made of little else.
pub(super) fn feature_sizes(
    solid: &Discrete,
    sizing: &Sizing,
    tolerance: Option<f64>,
    report: &mut Report,
) -> Vec<f64> {
    let (m, size) = (&solid.mesh, sizing.size);
    // Not where features had to be dropped: what is left of them is blurred, too.
    let designed = solid.removed.is_empty();
    let line = tolerance.unwrap_or(LINE * size);
    let bows = designed.then(|| solid.bow_sizes(size, sizing.least.min(size), line));
    let all = |least: f64| {
        let mut sizes = solid.feature_sizes(size, least);
        sizes.iter_mut().zip(bows.iter().flatten()).for_each(|(s, bow)| *s = s.min(*bow));
        sizes
    };
    let sizes = all(sizing.least.min(size / LEAST_FEATURE));
    let steps = |h: u32| {
        let want = sizes[m.origin(h) as usize].min(sizes[m.target(h) as usize]).min(size);
        m.edge_length(h) / want
    };
    let along: f64 = m.edges().filter(|&h| m.is_sharp(h)).map(steps).sum();
    let area: f64 = m.triangles().map(|t| 0.5 * m.area_vector(t).length()).sum();
    let within = area / (0.5 * 3f64.sqrt() * size * size);
    if along <= MOST_FEATURES * within + MOST_NODES {
        return sizes;
    }
    report
        .warnings
        .push("too many features close to each other to be resolved: triangles there are longer than wide".into());
    all(sizing.least.max(size / LEAST_SHARE))
}
