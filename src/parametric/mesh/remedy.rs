//! Remedies for troubles of faces, by name: each can be switched off, to see what it is good for.

use std::fmt;
use std::str::FromStr;

use super::Parametric;
use crate::error::{Error, Place};

/// What is done about a trouble of a boundary representation (\[BOR20\]), and can be left undone for study.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Remedy {
    /// Edges whose contours cross are divided more finely.
    Halving,
    /// Narrow places of faces ask for no edges shorter than the least length.
    LeastLength,
    /// Faces that cannot be filled in their own domain are filled on a plane through their border.
    Plane,
    /// The curvature of a pole is that of a point a little inside.
    Inset,
    /// Narrow regions of faces are cut off.
    Trim,
}

impl Remedy {
    /// All of them.
    pub const ALL: [Self; 5] = [Self::Halving, Self::LeastLength, Self::Plane, Self::Inset, Self::Trim];

    /// What it is called on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Halving => "halving",
            Self::LeastLength => "least-length",
            Self::Plane => "plane",
            Self::Inset => "inset",
            Self::Trim => "trim",
        }
    }
}

impl fmt::Display for Remedy {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for Remedy {
    type Err = Error;

    /// The remedy of a name. Errors: [`Error::Input`] lists the names there are.
    fn from_str(s: &str) -> Result<Self, Error> {
        let name = s.trim();
        Self::ALL.into_iter().find(|r| r.name() == name).ok_or_else(|| {
            let all = Self::ALL.map(Self::name).join(", ");
            Error::input(Place::Unknown, format!("there is no remedy {name:?}; there are {all}"))
        })
    }
}

impl Parametric {
    /// The same without some remedies, for study. [`Remedy::LeastLength`] and [`Remedy::Trim`] are no affair of this: they are in
    /// the sizes asked for, and in the model.
    pub fn without(mut self, remedies: &[Remedy]) -> Self {
        self.without = remedies.to_vec();
        let inset = !remedies.contains(&Remedy::Inset);
        self.charts.iter_mut().chain(self.sheets.iter_mut().map(|s| &mut s.1)).for_each(|c| c.inset = inset);
        self
    }
}
