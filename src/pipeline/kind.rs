//! The kinds of parts, each of which is meshed in a way of its own.

use super::boolean::{holds_foreign, is_foreign_alone};
use crate::implicit::part::Part;

/// What a part is made of.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum PartKind {
    /// A solid of R-functions.
    Functions,
    /// A plane figure.
    Figure,
    /// Solids built from edges.
    Built,
    /// Solids built from edges beside one of R-functions.
    BuiltBesideFunctions,
    /// Set operations of meshes, CAD models and solids built from edges.
    Joined,
    /// Set operations of these with R-functions.
    JoinedFunctions,
}

/// The kind of a part.
pub fn part_kind(part: &Part) -> PartKind {
    match &part.solid {
        _ if part.plane => PartKind::Figure,
        None => PartKind::Built,
        Some(_) if !part.built.is_empty() => PartKind::BuiltBesideFunctions,
        Some(solid) if !holds_foreign(solid) => PartKind::Functions,
        // The box of a domain is one of R-functions.
        Some(solid) if part.domain.is_none() && is_foreign_alone(solid) => PartKind::Joined,
        Some(_) => PartKind::JoinedFunctions,
    }
}
