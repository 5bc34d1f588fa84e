//! The methods by name, and the sequence of operators each runs.

use std::str::FromStr;

use crate::error::{Error, Result, nearest};
use crate::optimize::{Sequence, cut_sequence, operators_sequence, paper_sequence};

/// How a mesh is made.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Method {
    /// Marching cubes with the topology of MC33, nothing else.
    MarchingCubes,
    /// Marching cubes, then [`paper_sequence`]: what \[LIS14\] prints, misprints corrected. It is for study.
    Paper,
    /// Marching cubes, then [`operators_sequence`]: the operators of \[LIS14\] in an order that was found by measuring, or
    /// any other sequence, see [`MeshOptions::sequence`](super::MeshOptions::sequence).
    Operators,
    /// Marching cubes, then [`cut_sequence`]: creases are cut where normals differ, the rest smooths, divides and flips.
    Cut,
    /// Edges and corners exactly where the tree's leaves meet, from their arrangement on an adaptive grid, and a remesher that keeps them:
    /// [`remesh`](crate::remesh).
    #[default]
    Leaf,
}

impl Method {
    /// All methods, in the order they are compared in.
    pub const ALL: [Method; 5] = [Method::MarchingCubes, Method::Paper, Method::Operators, Method::Cut, Method::Leaf];

    /// The name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Method::MarchingCubes => "mc",
            Method::Paper => "paper",
            Method::Operators => "operators",
            Method::Cut => "cut",
            Method::Leaf => "leaf",
        }
    }

    /// Whether edges and corners come from the tree.
    pub fn is_exact(self) -> bool {
        matches!(self, Method::Leaf)
    }

    /// The operators it runs after marching cubes, if that is how it works.
    pub fn sequence(self) -> Option<Sequence> {
        match self {
            Method::Paper => Some(paper_sequence()),
            Method::Operators => Some(operators_sequence()),
            Method::Cut => Some(cut_sequence()),
            Method::MarchingCubes | Method::Leaf => None,
        }
    }
}

impl FromStr for Method {
    type Err = Error;

    /// Errors: [`Error::Usage`] with all names and the nearest one.
    fn from_str(s: &str) -> Result<Self> {
        Method::ALL.into_iter().find(|m| m.name() == s).ok_or_else(|| {
            let known = Method::ALL.map(Method::name);
            let near = nearest(s, known.into_iter()).unwrap_or_default();
            Error::Usage(format!("unknown method {s}; known: {}; the nearest is {near}", known.join(", ")))
        })
    }
}
