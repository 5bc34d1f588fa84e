//! How long edges of a remeshed soup shall be: by curvature, and by what features close to each other ask for.

use super::discrete::SoupOptions;
use super::options::MeshOptions;
use super::report::Report;
use crate::discrete::Discrete;
use crate::remesh::RemeshOptions;
use crate::sizing::{GRADING, LEAST_SHARE, Sizing, Wish};

/// Where bends of others make more than this many times the triangles that the size alone would, edges may be farther from the surface.
const CROWDED: f64 = 1.12;
/// How many times as far as else, at most: the first that is enough is taken.
const RELAXED: [f64; 9] = [1.0, 1.25, 1.5, 2.0, 2.5, 3.0, 4.0, 5.5, 7.5];
/// Lengths grow by this much per length where bends may be noise: with a fifth an armadillo gets 13 % more triangles, between bends
/// that say little.
const ROUGH_GRADING: f64 = 0.3;
/// Features close to each other make edges at most this many times shorter than the size.
const LEAST_FEATURE: f64 = 20.0;
/// Where features alone ask for this many times the nodes that the area does, and for [`MOST_NODES`] more, they are too many to
/// be resolved.
const MOST_FEATURES: f64 = 2.0;
/// Nodes that are few enough to be made in any case: small meshes resolve all of their features.
const MOST_NODES: f64 = 5e3;

pub(super) fn sizing(size: f64, diagonal: f64, options: &MeshOptions) -> Sizing {
    Wish::new(size, diagonal, options.asked()).sizing(options.least_length().unwrap_or(size / LEAST_SHARE))
}

/// Where facets are too coarse to tell noise from bends these ask for no number of edges; and where they bend nearly everywhere so much
/// that the size would mean little, edges may get farther from the surface, unless a tolerance was asked for.
pub(super) fn relaxed(sizing: Sizing, options: &MeshOptions, soup: &SoupOptions, solid: &Discrete) -> Sizing {
    if options.angle.is_some() || solid.smooth {
        return sizing;
    }
    let sizing = Sizing { nodes_per_radius: None, ..sizing };
    let simplified = soup.min_area > 0.0 || soup.min_length.is_some();
    if options.tolerance_length().is_some() || simplified {
        return sizing;
    }
    let at = |times: f64| Sizing { chord: sizing.chord.map(|c| times * c), ..sizing };
    let few = |s: &Sizing| solid.crowding(|k| s.at(k)) <= CROWDED;
    RELAXED.into_iter().map(at).find(few).unwrap_or(at(RELAXED[RELAXED.len() - 1]))
}

/// What the remesher aims at. Where facets are too coarse to tell noise from bends lengths grow faster, unless asked otherwise.
pub(super) fn exact(sizing: Sizing, options: &MeshOptions, solid: &Discrete) -> RemeshOptions {
    let grading = if solid.smooth { GRADING } else { ROUGH_GRADING };
    RemeshOptions::new(sizing, options.grading.unwrap_or(grading))
}

/// What features close to each other ask for, and bends that leave edges by more than `line`; less where they are so many that a
/// mesh would be made of little else.
pub(super) fn feature_sizes(solid: &Discrete, sizing: &Sizing, line: f64, report: &mut Report) -> Vec<f64> {
    let (m, size) = (&solid.mesh, sizing.size);
    // Not where features had to be dropped: what is left of them is blurred, too.
    let designed = solid.removed.is_empty();
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
