//! What a part file says of edges and of the solids to be built from them. Only said here: another gate builds them.

use std::sync::Arc;

use glam::DVec3;

use crate::error::Place;
use crate::implicit::solid::Placement;

/// One kind of edges, as the part file gives it.
#[derive(Debug, Clone, PartialEq)]
pub enum EdgeKind {
    /// Straight from point to point.
    Polyline(Vec<DVec3>),
    /// One cubic spline through points.
    Spline {
        /// The points.
        points: Vec<DVec3>,
        /// Whether it goes on from the last to the first.
        closed: bool,
        /// Derivatives at the ends; neither or both.
        ends: Option<[DVec3; 2]>,
    },
    /// A Bézier curve, rational with weights.
    Bezier {
        /// Control points.
        points: Vec<DVec3>,
        /// Weights, one for each, where they differ.
        weights: Option<Vec<f64>>,
    },
    /// A part of a circle through three points.
    Arc([DVec3; 3]),
    /// A whole ellipse; a circle where both half axes are equal.
    Ellipse {
        /// Its center.
        at: DVec3,
        /// The normal of its plane.
        axis: DVec3,
        /// The direction of the first half axis.
        x: Option<DVec3>,
        /// The half axes.
        radii: [f64; 2],
    },
}

/// A chain of edges: kinds of edges, each with its place, in any order.
#[derive(Debug, Clone, PartialEq)]
pub struct Edges {
    /// Its parts.
    pub parts: Vec<(Arc<EdgeKind>, Placement)>,
}

/// A section of a loft.
#[derive(Debug, Clone, PartialEq)]
pub enum SectionRecipe {
    /// A chain of edges.
    Edges(Edges),
    /// A point.
    Point(DVec3),
}

/// How edges become faces.
#[derive(Debug, Clone, PartialEq)]
pub enum Build {
    /// Along a direction.
    Extrude {
        /// The outer border, then holes.
        edges: Vec<Edges>,
        /// Where to.
        direction: DVec3,
        /// How far.
        distance: f64,
        /// Size of the far end.
        scale: f64,
        /// Size of the far ends of holes, about their own middles.
        hole_scale: Option<f64>,
        /// What stays in place when the end is scaled.
        center: Option<DVec3>,
        /// Whether it is a solid.
        solid: bool,
    },
    /// Around an axis.
    Revolve {
        /// The profile.
        edges: Edges,
        /// A point of the axis.
        at: DVec3,
        /// Its direction.
        axis: DVec3,
        /// By how much.
        degrees: f64,
        /// Whether it is a solid.
        solid: bool,
    },
    /// Through sections.
    Loft {
        /// The sections, in order.
        sections: Vec<SectionRecipe>,
        /// Straight from one to the next.
        ruled: bool,
        /// Whether points at the start, at the end, are round.
        round: [bool; 2],
        /// Whether sides are square to contours at the start, at the end.
        square: [bool; 2],
        /// Whether it is a solid.
        solid: bool,
    },
    /// Along a path.
    Sweep {
        /// The outer border, then holes.
        edges: Vec<Edges>,
        /// The path.
        path: Edges,
        /// Whether it is a solid.
        solid: bool,
    },
    /// A flat sheet.
    Flat(Vec<Edges>),
    /// Others sewn together.
    Sew {
        /// The sheets.
        parts: Vec<Recipe>,
        /// Points nearer than this are one.
        tolerance: Option<f64>,
        /// Whether it is a solid.
        solid: bool,
    },
}

/// Recipes inside recipes, at most.
pub const DEEPEST: usize = 32;

/// A solid or a sheet to be built.
#[derive(Debug, Clone, PartialEq)]
pub struct Recipe {
    /// How.
    pub build: Build,
    /// Where it is put then.
    pub placement: Placement,
    /// What it is called.
    pub name: Option<String>,
    /// Patterns of names of faces to leave out.
    pub without: Vec<String>,
    /// How many recipes are inside each other.
    pub depth: usize,
    /// Where the part file says so.
    pub place: Place,
}
