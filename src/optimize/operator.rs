//! The operators by name.

use std::fmt;

#[cfg(doc)]
use super::{
    align_normals, classify_by_curvature, classify_by_edges, collapse_short, cut_creases, densify, flip_for_angles,
    flip_for_normals, project, relax_worst, remove_degenerate, settle_creases, smooth_all, smooth_edges,
    smooth_regular, snap_to_planes, survey,
};
use crate::error::{Error, Result, nearest};

/// An operator by name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Operator {
    /// Nodes to their feet on the surface: [`project`].
    Project,
    /// `R_all` (12, 13): [`smooth_all`].
    SmoothAll,
    /// One pass of `N` (4–7), damped by [`DAMPING`](super::normal::DAMPING): [`align_normals`].
    AlignNormals,
    /// `N1` (8–11): [`snap_to_planes`]. Edges that then lie on a crease of the surface are marked sharp.
    SnapToPlanes,
    /// Classes by two-means of curvature (14–17): [`classify_by_curvature`].
    ClassifyByCurvature,
    /// Classes by the edges marked sharp: [`classify_by_edges`].
    ClassifyByEdges,
    /// `R_regular` (18): [`smooth_regular`].
    SmoothRegular,
    /// `R_edge` (19, 20): [`smooth_edges`].
    SmoothEdges,
    /// Densification by size, curvature and chord: [`densify`].
    Densify,
    /// The shortest edges of the extraction: [`collapse_short`] at three tenths of the size.
    CollapseTiny,
    /// Edges shorter than four fifths of the size: [`collapse_short`].
    CollapseShort,
    /// Needles and caps: [`remove_degenerate`].
    RemoveDegenerate,
    /// Flips for angles: [`flip_for_angles`].
    FlipForAngles,
    /// Flips for normals: [`flip_for_normals`]. Edges that then lie on a crease of the surface are marked sharp.
    FlipForNormals,
    /// Creases become edges: [`cut_creases`].
    CutCreases,
    /// Nodes back onto their creases: [`settle_creases`].
    SettleCreases,
    /// Smallest angles, one node at a time: [`relax_worst`].
    RelaxWorst,
    /// Labels and normals from the oracle: [`survey`].
    Survey,
}

/// Every operator with its name.
const NAMES: [(Operator, &str); 18] = [
    (Operator::Project, "project"),
    (Operator::SmoothAll, "R_all"),
    (Operator::AlignNormals, "N"),
    (Operator::SnapToPlanes, "N1"),
    (Operator::ClassifyByCurvature, "classify"),
    (Operator::ClassifyByEdges, "classes-edges"),
    (Operator::SmoothRegular, "R_regular"),
    (Operator::SmoothEdges, "R_edge"),
    (Operator::Densify, "densify"),
    (Operator::CollapseTiny, "collapse-tiny"),
    (Operator::CollapseShort, "collapse"),
    (Operator::RemoveDegenerate, "degenerate"),
    (Operator::FlipForAngles, "flip-angles"),
    (Operator::FlipForNormals, "flip-normals"),
    (Operator::CutCreases, "cut"),
    (Operator::SettleCreases, "settle"),
    (Operator::RelaxWorst, "relax"),
    (Operator::Survey, "survey"),
];

impl Operator {
    /// All operators.
    pub fn all() -> impl Iterator<Item = Operator> {
        NAMES.into_iter().map(|(op, _)| op)
    }

    /// The operator whose name takes the fewest edits to be this one.
    pub fn nearest(name: &str) -> Option<Operator> {
        let near = nearest(name, NAMES.into_iter().map(|x| x.1))?;
        Operator::all().find(|o| o.name() == near)
    }

    /// The operator's short name, the paper's where it has one.
    pub fn name(self) -> &'static str {
        NAMES.into_iter().find(|x| x.0 == self).map_or("", |x| x.1)
    }
}

impl fmt::Display for Operator {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl std::str::FromStr for Operator {
    type Err = Error;

    /// Reads a name as [`name`](Operator::name) gives it; [`Error::Usage`] lists them all.
    fn from_str(text: &str) -> Result<Self> {
        NAMES.into_iter().find(|x| x.1 == text).map(|x| x.0).ok_or_else(|| {
            let names: Vec<&str> = NAMES.into_iter().map(|x| x.1).collect();
            Error::Usage(format!("unknown operator '{text}'; there are {}", names.join(", ")))
        })
    }
}
