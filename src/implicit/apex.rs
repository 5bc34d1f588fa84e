//! Apexes: points of cones, and of tori that meet themselves on their axis, without a normal.

use std::f64::consts::TAU;

use glam::DVec3;

use super::leaf::{Frame, Leaf};
use super::model::Implicit;
use super::newton::bounds_solid;

/// The cone is looked at this far from its apex, as a share of the part's size.
const LOOK: f64 = 1e-6;

/// Directions it is looked at in; with eight, no other surface through the apex can hide between them unless it nearly
/// touches the cone.
const SIDES: usize = 8;

/// The apexes that are points of the solid's surface with the leaf all around them, each with its leaf.
pub(super) fn apexes(model: &Implicit) -> Vec<(u32, DVec3)> {
    apexes_of(model, &|_| true)
}

/// Those of some places. No others are looked at, each of which takes as long as all of the tree.
pub(super) fn apexes_of(model: &Implicit, is_asked: &dyn Fn(DVec3) -> bool) -> Vec<(u32, DVec3)> {
    let scale = model.bounds().diagonal();
    let mut found = Vec::new();
    for (i, leaf) in model.leaves.iter().enumerate() {
        let Some((frame, tips)) = tips(leaf) else { continue };
        for Tip { at: apex, slope } in tips {
            if !apex.is_finite() || !is_asked(apex) {
                continue;
            }
            let step = LOOK * scale;
            let around = (0..SIDES).all(|n| {
                let (s, c) = (0.1 + TAU * n as f64 / SIDES as f64).sin_cos();
                let p = apex + (frame.u * c + frame.v * s) * step + frame.a * (slope * step);
                bounds_solid(&model.tape, &model.leaves, i as u32, p).is_some()
            });
            if around {
                found.push((i as u32, apex));
            }
        }
    }
    found
}

/// A point of an axis that a surface ends in, and how much higher along the axis it is at one unit of distance from the axis.
struct Tip {
    at: DVec3,
    slope: f64,
}

/// Where a leaf's surface ends in points of its axis.
fn tips(leaf: &Leaf) -> Option<(&Frame, Vec<Tip>)> {
    match leaf {
        // Both nappes have k rho + m t = d; the one with rho >= 0 lies where m t < d.
        Leaf::Cone { c, frame, k, m, d } if *m != 0.0 => {
            Some((frame, vec![Tip { at: c + frame.a * (d / m), slope: -k / m }]))
        }
        // Near its axis it has t^2 = minor^2 - major^2 + 2 major rho.
        Leaf::Torus { c, frame, major, minor } if major.abs() < *minor && *major != 0.0 => {
            let height = (minor * minor - major * major).sqrt();
            let tip = |t: f64| Tip { at: c + frame.a * t, slope: major / t };
            Some((frame, vec![tip(-height), tip(height)]))
        }
        _ => None,
    }
}
