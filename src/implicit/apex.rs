//! Apexes of cones: points of the surface without a normal.

use std::f64::consts::TAU;

use glam::DVec3;

use super::leaf::Leaf;
use super::model::Implicit;
use super::newton::bounds_solid;

/// The cone is looked at this far from its apex, as a share of the part's size.
const LOOK: f64 = 1e-6;

/// Directions it is looked at in; with eight, no other surface through the apex can hide between them unless it nearly
/// touches the cone.
const SIDES: usize = 8;

/// The apexes that are points of the solid's surface with the cone all around them, each with its leaf.
pub(super) fn apexes(model: &Implicit) -> Vec<(u32, DVec3)> {
    apexes_of(model, &|_| true)
}

/// Those of some places. No others are looked at, each of which takes as long as all of the tree.
pub(super) fn apexes_of(model: &Implicit, is_asked: &dyn Fn(DVec3) -> bool) -> Vec<(u32, DVec3)> {
    let scale = model.bounds().diagonal();
    let mut found = Vec::new();
    for (i, leaf) in model.leaves.iter().enumerate() {
        let Leaf::Cone { c, frame, k, m, d } = leaf else { continue };
        if *m == 0.0 {
            continue;
        }
        let apex = c + frame.a * (d / m);
        if !apex.is_finite() || !is_asked(apex) {
            continue;
        }
        let step = LOOK * scale;
        // Both nappes have k rho + m t = d; the one with rho >= 0 lies where m t < d.
        let around = (0..SIDES).all(|n| {
            let (s, c) = (0.1 + TAU * n as f64 / SIDES as f64).sin_cos();
            let p = apex + (frame.u * c + frame.v * s) * step - frame.a * (k * step / m);
            bounds_solid(&model.tape, &model.leaves, i as u32, p).is_some()
        });
        if around {
            found.push((i as u32, apex));
        }
    }
    found
}
