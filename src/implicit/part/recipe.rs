//! What a part file says of edges and of the solids to be built from them. Only said here: another gate builds them.

use std::sync::Arc;

use glam::{DVec2, DVec3};

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
        /// Whether the second derivative stays the same over the first and over the last piece.
        parabolic: bool,
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
    /// An arc of a parabola.
    Parabola {
        /// Its vertex.
        at: DVec3,
        /// The normal of its plane.
        axis: DVec3,
        /// The direction it opens to.
        x: Option<DVec3>,
        /// The distance of the focus from the vertex.
        focal: f64,
        /// Where it starts and ends, across the direction it opens to.
        across: [f64; 2],
    },
    /// An arc of a branch of a hyperbola.
    Hyperbola {
        /// Its center.
        at: DVec3,
        /// The normal of its plane.
        axis: DVec3,
        /// The direction from the center to the branch.
        x: Option<DVec3>,
        /// The half axes, along and across that direction.
        radii: [f64; 2],
        /// Where it starts and ends, across that direction.
        across: [f64; 2],
    },
    /// An arc of the curve `A x^2 + B x y + C y^2 + D x + E y + F = 0`.
    Conic {
        /// A, B, C, D, E and F.
        coefficients: [f64; 6],
        /// Where it starts and ends; all of an ellipse where left out.
        ends: Option<[DVec2; 2]>,
    },
    /// A polynomial by powers of its parameter.
    Polynomial {
        /// Factors of the powers, from 0 on.
        coefficients: Vec<DVec3>,
        /// The parameter's range.
        range: [f64; 2],
    },
    /// The polynomial through points.
    Lagrange {
        /// The points.
        points: Vec<DVec3>,
        /// The parameters at which it passes through them.
        parameters: Vec<f64>,
    },
    /// A NURBS curve.
    Nurbs {
        /// Control points.
        points: Vec<DVec3>,
        /// Its degree.
        degree: usize,
        /// Knots; at equal distances where left out.
        knots: Option<Vec<f64>>,
        /// Weights, one for each point, where they differ.
        weights: Option<Vec<f64>>,
        /// Points it passes through besides, each with its parameter,
        through: Vec<(f64, DVec3)>,
        /// and directions it has.
        tangents: Vec<(f64, DVec3)>,
    },
}

/// A chain of edges: kinds of edges, each with its place, in any order.
#[derive(Debug, Clone, PartialEq)]
pub struct Edges {
    /// Its parts.
    pub parts: Vec<(Arc<EdgeKind>, Placement)>,
}

impl Edges {
    /// Edges of one kind, where they are.
    pub fn one(kind: EdgeKind) -> Self {
        Self { parts: vec![(Arc::new(kind), Placement::IDENTITY)] }
    }
}

/// A net of control points.
#[derive(Debug, Clone, PartialEq)]
pub struct Net {
    /// The points, row after row.
    pub points: Vec<DVec3>,
    /// Weights, one for each point, where they differ.
    pub weights: Option<Vec<f64>>,
    /// How many rows, and how many points in each.
    pub size: [usize; 2],
    /// Degrees along the rows' numbers and within a row.
    pub degrees: [usize; 2],
    /// Knots likewise; at equal distances where left out.
    pub knots: [Option<Vec<f64>>; 2],
}

/// A sheet of free form.
#[derive(Debug, Clone, PartialEq)]
pub enum Sheet {
    /// A profile shifted along a path without turning.
    Shift {
        /// The profile.
        profile: Edges,
        /// The path.
        path: Edges,
        /// How far the profile is taken back from where it is.
        offset: DVec3,
    },
    /// Smooth through chains, with slopes from their neighbors.
    Hermite {
        /// The chains.
        curves: Vec<Edges>,
        /// Whether it goes on from the last to the first.
        closed: bool,
    },
    /// A NURBS surface with chains for control points.
    Spline {
        /// The chains.
        curves: Vec<Edges>,
        /// The degree across.
        degree: usize,
        /// Knots across; at equal distances where left out.
        knots: Option<Vec<f64>>,
        /// Weights, one for each chain, where they differ.
        weights: Option<Vec<f64>>,
    },
    /// Arcs from the first chain to the last, whose tangents meet on the second.
    Fillet(Box<[Edges; 3]>),
    /// A NURBS surface by its net.
    Nurbs(Net),
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
    /// A solid made so many times as large about its own center of mass.
    AboutMass {
        /// The solid.
        part: Box<Recipe>,
        /// The factor.
        scale: f64,
    },
    /// A sheet of free form.
    Sheet(Sheet),
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
