//! What was found in a mesh and what was done about it.

use glam::DVec3;
use serde::Serialize;

/// Kinds of defects.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Defect {
    /// Nodes at one place.
    CoincidentNodes,
    /// Triangles that name a node twice or lie on a line.
    DegenerateTriangle,
    /// Triangles with the nodes of another one.
    DuplicateTriangle,
    /// Borders that run side by side closer than a tolerance.
    NearBorders,
    /// A node on an edge it is not part of.
    TJunction,
    /// Neighbors that disagree on which side is out, or a body that is inside out.
    Orientation,
    /// Triangles hanging on an edge of other triangles.
    Fin,
    /// A piece too small to mean anything, which stays all the same.
    StrayPiece,
    /// A contour of open edges.
    Hole,
    /// Edges of more than two triangles, nodes of more than one fan.
    NonManifold,
    /// Triangles that pass through each other.
    SelfIntersection,
    /// A surface that bounds nothing.
    OpenSheet,
}

/// What was done about a defect.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Action {
    /// Made one.
    Merged,
    /// Taken away.
    Removed,
    /// An edge got the node.
    Split,
    /// Turned over.
    Flipped,
    /// Closed by ear cutting.
    Filled,
    /// Closed by another triangulation, since ear cutting intersected.
    FilledOtherwise,
    /// The contour was found by our continuation of the iteration of \[BOR20\], then filled.
    FilledByContinuation,
    /// Taken out with its surroundings and closed again.
    Refilled,
    /// Nodes were drawn back to where a membrane between their neighbors would hang.
    DrawnBack,
    /// Crossing sheets were cut along their crossing and joined anew, a narrow gap apart.
    Uncrossed,
    /// Given a small thickness.
    Thickened,
    /// The surface was made anew at a resolution, from the winding number.
    Rebuilt,
    /// New nodes were moved to the surface they stand for.
    Projected,
    /// Left as it is.
    Left,
}

/// One entry of the report: a defect, what was done, and where.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Repair {
    /// What was wrong.
    pub defect: Defect,
    /// What was done.
    pub action: Action,
    /// How many nodes, triangles or edges it concerned.
    pub count: usize,
    /// Where: the center of the first one.
    pub place: [f64; 3],
    /// How far it reaches from there.
    pub extent: f64,
}

/// The report of one healing. Lengths are in the mesh's unit.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct HealReport {
    /// Everything found, in the order it was dealt with.
    pub repairs: Vec<Repair>,
    /// Whether the result is closed.
    pub closed: bool,
    /// Whether the result is a manifold.
    pub manifold: bool,
    /// Whether neighbors agree on which side is out.
    pub oriented: bool,
    /// Triangles of the result that pass through another one, by exact predicates.
    pub self_intersections: usize,
    /// Places at which surfaces of the result touch in a common node, where no gap fits between them.
    pub touching: usize,
    /// Share of the input's area that is in the result, or within the gap of it.
    pub kept: f64,
    /// What the result falls short of.
    pub shortfalls: Vec<String>,
}

impl HealReport {
    /// Whether the result is closed, a manifold, oriented and free of self-intersections.
    pub fn is_sound(&self) -> bool {
        self.closed && self.manifold && self.oriented && self.self_intersections == 0
    }

    /// Adds an entry over the points; nothing if there are none.
    pub(super) fn add(&mut self, defect: Defect, action: Action, count: usize, points: &[DVec3]) {
        if count == 0 || points.is_empty() {
            return;
        }
        let center = points.iter().sum::<DVec3>() / points.len() as f64;
        let extent = points.iter().map(|p| p.distance(center)).fold(0.0, f64::max);
        self.repairs.push(Repair { defect, action, count, place: center.to_array(), extent });
    }
}

impl std::fmt::Display for HealReport {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let yes = |b: bool| if b { "yes" } else { "NO" };
        writeln!(
            f,
            "closed {}, manifold {}, oriented {}, {} self-intersecting triangles, {:.2} % of the area kept",
            yes(self.closed),
            yes(self.manifold),
            yes(self.oriented),
            self.self_intersections,
            100.0 * self.kept
        )?;
        for r in &self.repairs {
            let [x, y, z] = r.place;
            let words = |s: String| {
                s.chars().fold(String::new(), |mut t, c| {
                    if c.is_uppercase() && !t.is_empty() {
                        t.push(' ');
                    }
                    t.push(c.to_ascii_lowercase());
                    t
                })
            };
            let (what, done) = (words(format!("{:?}", r.defect)), words(format!("{:?}", r.action)));
            writeln!(f, "  {what}: {} {done}, at ({x:.6}, {y:.6}, {z:.6}) within {:.3e}", r.count, r.extent)?;
        }
        Ok(())
    }
}
