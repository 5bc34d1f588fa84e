//! Solids as trees: primitives, set operations, placement, names. The tree is what a part file describes and what a
//! program may build directly; lowering turns it into leaves and a tape.

use std::ops;
use std::path::PathBuf;
use std::sync::Arc;

use glam::{DMat3, DVec3};

use super::expr::Expr;
use super::field::Field;
use super::part::recipe::Recipe;
use super::turned::Turned;
use super::valued::Smooth;
use crate::error::{Error, Place};
use crate::spatial::Aabb;

/// The triply periodic minimal surfaces on offer, as sheets of finite thickness.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Tpms {
    /// sin x cos y + sin y cos z + sin z cos x
    Gyroid,
    /// cos x + cos y + cos z (Schwarz P)
    SchwarzP,
    /// Schwarz D: sin x sin y sin z + sin x cos y cos z + cos x sin y cos z + cos x cos y sin z
    Diamond,
}

/// A primitive solid. Directions need not be unit vectors; lengths must be positive.
#[derive(Debug, Clone)]
pub enum Primitive {
    /// Faces `xmin xmax ymin ymax zmin zmax`. Between infinite z both ways it has no `zmin zmax`.
    Box {
        /// Smallest coordinates.
        lo: DVec3,
        /// Largest coordinates.
        hi: DVec3,
    },
    /// One face.
    Sphere {
        /// Radius.
        r: f64,
        /// Center.
        at: DVec3,
    },
    /// One face.
    Ellipsoid {
        /// The three half axes.
        radii: DVec3,
        /// Center.
        at: DVec3,
    },
    /// Faces `side`, and with a height `bottom` and `top`.
    Cylinder {
        /// Radius.
        r: f64,
        /// Direction of the axis.
        axis: DVec3,
        /// Center.
        at: DVec3,
        /// Length along the axis; infinite if `None`.
        height: Option<f64>,
    },
    /// A truncated cone centered at `at`: radius `r0` at the bottom, `r1` at the top (one may be 0). Faces `side bottom top`.
    Cone {
        /// Radius at the bottom.
        r0: f64,
        /// Radius at the top.
        r1: f64,
        /// Length along the axis.
        height: f64,
        /// Direction of the axis, from bottom to top.
        axis: DVec3,
        /// Center, halfway up.
        at: DVec3,
    },
    /// One face.
    Torus {
        /// Radius of the center circle.
        major: f64,
        /// Radius of the tube.
        minor: f64,
        /// Direction of the axis.
        axis: DVec3,
        /// Center.
        at: DVec3,
    },
    /// The side of a plane its normal points away from. One face.
    HalfSpace {
        /// Outward normal.
        normal: DVec3,
        /// A point on the plane.
        at: DVec3,
    },
    /// |g(2 pi (p - at) / period)| period / 2 pi < thickness / 2. Faces `plus` and `minus`.
    Tpms {
        /// Which surface.
        kind: Tpms,
        /// Length of one period.
        period: f64,
        /// Thickness of the sheet, close to a length.
        thickness: f64,
        /// Origin of the pattern.
        at: DVec3,
    },
    /// A polygon in the xy plane, extruded along z: from -height/2 to height/2 about `at`.
    /// Faces `side0 side1 ...` in the polygon's order, `bottom`, `top`.
    Extrude {
        /// The polygon's corners in order, either orientation; must be simple.
        polygon: Vec<[f64; 2]>,
        /// Length along z; with an infinite one there is no `bottom` and no `top`.
        height: f64,
        /// Shift of the whole.
        at: DVec3,
    },
    /// A polygon of points (radius, z), radius >= 0, turned about the z axis. Faces `side0 side1 ...`.
    Revolve {
        /// The polygon's corners in order, either orientation; must be simple.
        polygon: Vec<[f64; 2]>,
    },
    /// Between `z = -height / 2` and `height / 2`. Faces `bottom` and `top`. [`Solid::extruded`] cuts figures with it.
    Slab {
        /// Length along z.
        height: f64,
        /// The box around the figure that is cut with it, as far as known, which becomes the box around both. Its z counts for
        /// nothing, and infinite is not known.
        around: Aabb,
    },
    /// A primitive of the plane turned about the z axis, with the faces it has there. [`Solid::revolved`] makes these.
    Turned(Turned),
    /// Inside where the formula is positive. One face.
    Formula(Expr),
    /// A formula that rounds off what has edges, by its pieces. Formulas fall into these when a model is made of them.
    Smooth(Arc<Smooth>),
    /// Inside where the field is positive. One face.
    Field(Arc<dyn Field>),
    /// Inside a boundary that is no R-function. Only the pipeline makes meshes of such solids; everything that needs a function
    /// refuses them.
    Foreign(Arc<Foreign>),
}

/// A solid given by its boundary, which takes part in set operations with solids of R-functions.
#[derive(Debug, Clone)]
pub struct Foreign {
    /// Where the boundary is.
    pub source: Boundary,
    /// Where the part file says so.
    pub place: Place,
}

/// Where a boundary is.
#[derive(Debug, Clone)]
pub enum Boundary {
    /// In a file of triangles; a relative path starts at the part file's folder.
    Mesh(PathBuf),
    /// In a STEP file, likewise.
    Step(PathBuf),
    /// In edges.
    Built(Box<Recipe>),
}

impl Foreign {
    /// What to call it in a message.
    pub fn kind(&self) -> &'static str {
        match self.source {
            Boundary::Mesh(_) => "a mesh",
            Boundary::Step(_) => "a STEP model",
            Boundary::Built(_) => "a solid built from edges",
        }
    }

    /// The error for what needs a function, or `what` else this solid cannot do, at its place in the part file.
    pub fn refused(&self, what: &str) -> Error {
        let message = format!("{} {what}", self.kind());
        Error::input(self.place.clone(), message)
            .with_help("it takes part in & | - and ~, and `rvachev mesh` makes a mesh of the part")
    }
}

/// A similarity: `p -> scale * rotation * p + shift`. `rotation` is orthogonal and may reflect.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Placement {
    /// Orthogonal matrix.
    pub rotation: DMat3,
    /// Positive factor.
    pub scale: f64,
    /// Translation, applied last.
    pub shift: DVec3,
}

impl Placement {
    /// Leaves everything where it is.
    pub const IDENTITY: Placement = Placement { rotation: DMat3::IDENTITY, scale: 1.0, shift: DVec3::ZERO };

    /// Where the point goes.
    pub fn apply(&self, p: DVec3) -> DVec3 {
        self.rotation * p * self.scale + self.shift
    }

    /// Where the direction goes (not scaled).
    pub fn turn(&self, d: DVec3) -> DVec3 {
        self.rotation * d
    }

    /// First `inner`, then `self`.
    pub fn after(&self, inner: &Placement) -> Placement {
        Placement {
            rotation: self.rotation * inner.rotation,
            scale: self.scale * inner.scale,
            shift: self.apply(inner.shift),
        }
    }
}

/// A node of a solid's tree.
#[derive(Debug, Clone)]
pub enum SolidNode {
    /// A primitive.
    Primitive(Primitive),
    /// R-conjunction of all (everything, if none).
    And(Vec<Solid>),
    /// R-disjunction of all (nothing, if none).
    Or(Vec<Solid>),
    /// Complement.
    Not(Solid),
    /// Smooth union: the faces of both, joined by a fillet of the given radius. One smooth leaf.
    Blend(Solid, Solid, f64),
    /// A moved, turned, scaled or mirrored solid.
    Placed(Placement, Solid),
    /// Names the faces below; the innermost name wins.
    Named(Arc<str>, Solid),
    /// Asks for a mesh size on the faces below; the innermost one wins.
    Sized(f64, Solid),
}

/// A solid: a cheap handle to a shared tree. `a & b`, `a | b`, `!a` and `a - b` are the set operations.
#[derive(Debug, Clone)]
pub struct Solid(pub(crate) Arc<SolidNode>);

impl Solid {
    /// Wraps a node.
    pub fn new(node: SolidNode) -> Self {
        Solid(Arc::new(node))
    }

    /// The node at the root.
    pub fn node(&self) -> &SolidNode {
        &self.0
    }

    /// A box by its two extreme corners.
    pub fn cuboid(lo: DVec3, hi: DVec3) -> Self {
        Primitive::Box { lo, hi }.into()
    }

    /// A sphere.
    pub fn sphere(r: f64, at: DVec3) -> Self {
        Primitive::Sphere { r, at }.into()
    }

    /// A cylinder, infinite without `height`.
    pub fn cylinder(r: f64, axis: DVec3, at: DVec3, height: Option<f64>) -> Self {
        Primitive::Cylinder { r, axis, at, height }.into()
    }

    /// The side of a plane its normal points away from.
    pub fn half_space(normal: DVec3, at: DVec3) -> Self {
        Primitive::HalfSpace { normal, at }.into()
    }

    /// Inside where the formula is positive.
    pub fn formula(expr: Expr) -> Self {
        Primitive::Formula(expr).into()
    }

    /// Inside where the field is positive: how an analysis code brings its own function.
    pub fn field(field: impl Field + 'static) -> Self {
        Primitive::Field(Arc::new(field)).into()
    }

    /// Union of all.
    pub fn union(all: impl IntoIterator<Item = Solid>) -> Self {
        Solid::new(SolidNode::Or(all.into_iter().collect()))
    }

    /// Intersection of all.
    pub fn intersection(all: impl IntoIterator<Item = Solid>) -> Self {
        Solid::new(SolidNode::And(all.into_iter().collect()))
    }

    /// Union with a fillet: where `a` and `b`, the functions of the two, are both above `-radius`, it reaches out to
    /// `(radius + a)^2 + (radius + b)^2 = radius^2`. That is a circle where two planes meet at a right angle. The edges of both
    /// solids remain, and so do their faces; the fillets are a face named as the blend. Two solids of one smooth face each
    /// become one smooth face. Nested blends have a fillet for each pair of their faces; beyond 2048 pairs edges are
    /// rounded off at the size of the triangles, with a warning.
    pub fn blend(self, other: Solid, radius: f64) -> Self {
        Solid::new(SolidNode::Blend(self, other, radius))
    }

    /// The solid after a similarity.
    pub fn placed(self, placement: Placement) -> Self {
        Solid::new(SolidNode::Placed(placement, self))
    }

    /// Names the faces.
    pub fn name(self, name: &str) -> Self {
        Solid::new(SolidNode::Named(name.into(), self))
    }

    /// Asks for a mesh size on the faces.
    pub fn size(self, h: f64) -> Self {
        Solid::new(SolidNode::Sized(h, self))
    }
}

impl From<Primitive> for Solid {
    fn from(p: Primitive) -> Self {
        Solid::new(SolidNode::Primitive(p))
    }
}

impl ops::BitAnd for Solid {
    type Output = Solid;
    fn bitand(self, other: Solid) -> Solid {
        Solid::new(SolidNode::And(vec![self, other]))
    }
}

impl ops::BitOr for Solid {
    type Output = Solid;
    fn bitor(self, other: Solid) -> Solid {
        Solid::new(SolidNode::Or(vec![self, other]))
    }
}

impl ops::Not for Solid {
    type Output = Solid;
    fn not(self) -> Solid {
        Solid::new(SolidNode::Not(self))
    }
}

impl ops::Sub for Solid {
    type Output = Solid;
    fn sub(self, other: Solid) -> Solid {
        self & !other
    }
}

/// Takes the tree apart without recursion: a tree may be millions of nodes deep.
impl Drop for Solid {
    fn drop(&mut self) {
        thread_local! {
            static NOTHING: Arc<SolidNode> = Arc::new(SolidNode::Or(Vec::new()));
        }
        fn children(node: &mut SolidNode, stack: &mut Vec<Solid>) {
            match node {
                SolidNode::Primitive(_) => {}
                SolidNode::And(all) | SolidNode::Or(all) => stack.append(all),
                SolidNode::Not(s) | SolidNode::Placed(_, s) | SolidNode::Named(_, s) | SolidNode::Sized(_, s) => {
                    stack.push(std::mem::replace(s, Solid(NOTHING.with(Arc::clone))));
                }
                SolidNode::Blend(a, b, _) => {
                    stack.push(std::mem::replace(a, Solid(NOTHING.with(Arc::clone))));
                    stack.push(std::mem::replace(b, Solid(NOTHING.with(Arc::clone))));
                }
            }
        }
        let Some(node) = Arc::get_mut(&mut self.0) else { return };
        let mut stack = Vec::new();
        children(node, &mut stack);
        while let Some(mut s) = stack.pop() {
            if let Some(node) = Arc::get_mut(&mut s.0) {
                children(node, &mut stack);
            }
        }
    }
}
