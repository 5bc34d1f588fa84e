//! Why a mesh is not sound, or falls short of what was asked: as types, from which the messages are made last.

use std::fmt;

use glam::DVec3;
use serde::{Serialize, Serializer};

use crate::spatial::Aabb;

/// How many places a fault lists.
pub(super) const LISTED: usize = 5;

/// One reason why a mesh is not sound, or falls short of what was asked.
///
/// Lengths are in the mesh's unit. `Display` makes the message. Written as JSON it is an object with the reason in snake case as
/// `kind`, the fields, and the `message`.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(remote = "Self", tag = "kind", rename_all = "snake_case")]
pub enum Fault {
    /// Edges have one triangle only; none if there are no triangles at all.
    Open {
        /// How many.
        edges: usize,
        /// Middles of the first ones.
        places: Vec<[f64; 3]>,
    },
    /// Edges have more than two triangles, or nodes more than one fan of them.
    NonManifold {
        /// How many edges and nodes.
        count: usize,
        /// Where the first ones are.
        places: Vec<[f64; 3]>,
    },
    /// Neighbors disagree on which side is out.
    NotOriented {
        /// Across how many edges.
        edges: usize,
        /// Middles of the first ones.
        places: Vec<[f64; 3]>,
    },
    /// A closed surface that has its outside inside, or nothing inside.
    Inverted {
        /// The volume, which is not positive.
        volume: f64,
    },
    /// Triangles pass through others.
    Crossing {
        /// How many do.
        triangles: usize,
        /// Whether only those of their own body were asked about.
        own_body: bool,
        /// Centroids of the first ones, where they were looked for.
        places: Vec<[f64; 3]>,
    },
    /// Triangles face away from the true surface.
    FacingAway {
        /// How many do.
        triangles: usize,
        /// The middle of the one that is farthest from it, where that was measured.
        places: Vec<[f64; 3]>,
    },
    /// The mesh and the true surface are farther from each other than they may be.
    Far {
        /// The largest distance that was measured.
        distance: f64,
        /// The largest that is allowed.
        limit: f64,
        /// How many triangles are beyond it, where they were counted.
        #[serde(skip_serializing_if = "Option::is_none")]
        triangles: Option<usize>,
    },
    /// More volume lies between mesh and surface than may be lost.
    VolumeLost {
        /// The share of the mesh's volume, at most.
        share: f64,
        /// The share that is allowed.
        limit: f64,
    },
    /// Part of the surface is not in the mesh.
    SurfaceMissing {
        /// Its face.
        face: String,
        /// A point of it.
        at: [f64; 3],
        /// How many more points are known not to be there.
        more: usize,
    },
    /// A face is smaller than the cells somewhere: the mesh passes over it with other faces.
    FaceMissing {
        /// The face.
        face: String,
        /// A point of it.
        at: [f64; 3],
    },
    /// A group holds no triangle, though it names faces of the part.
    EmptyGroup {
        /// The group.
        group: String,
        /// The faces it names.
        faces: Vec<String>,
    },
    /// Edges between faces were not found.
    EdgesMissing {
        /// At how many places.
        count: usize,
        /// The first ones.
        places: Vec<[f64; 3]>,
    },
    /// Operators left sharp edges or corners cut off.
    CreasesCutOff {
        /// The share of the length of sharp edges that is there.
        recall: f64,
        /// How many corners are there.
        corners: usize,
        /// Of how many.
        of: usize,
    },
    /// The solid, or a gap, is thinner than the cells.
    Thin {
        /// Where.
        at: [f64; 3],
    },
    /// A wall below a face is thinner than the cells: the mesh may have torn it.
    ThinWall {
        /// The face.
        face: String,
        /// Where.
        at: [f64; 3],
        /// How thin it is.
        thickness: f64,
        /// The cells' size.
        size: f64,
    },
    /// With exact edges triangles intersected others; they were mended as those of a damaged mesh are.
    Mended {
        /// How many.
        triangles: usize,
        /// Where the first ones were.
        places: Vec<[f64; 3]>,
    },
    /// The mesh is made by another method than the one asked for.
    OtherMethod {
        /// How many triangles intersected others by the method asked for.
        crossing: usize,
        /// How many were turned over.
        inverted: usize,
        /// The method that stands in.
        method: &'static str,
    },
    /// A record of a file was not understood, and what it describes is not there.
    NotRead {
        /// The record's number.
        record: u64,
        /// Its line.
        line: usize,
        /// What is wrong with it.
        reason: String,
    },
    /// A face of a boundary representation has no triangles.
    NoMesh {
        /// The face.
        face: String,
        /// The number of the record that made it, in a file.
        source: u64,
        /// The kind of its surface, where that may be to blame.
        #[serde(skip_serializing_if = "Option::is_none")]
        surface: Option<&'static str>,
        /// Why.
        reason: String,
    },
    /// A body is as it was first triangulated.
    FirstTriangulation {
        /// Why.
        reason: String,
    },
    /// A soup is as it was.
    NotRemeshed,
    /// Triangles of a soup stay as they were, where the surface comes too close to itself.
    Kept {
        /// How many.
        triangles: usize,
        /// The first one's centroid.
        at: [f64; 3],
    },
    /// Surfaces of two operands of a set operation are tangent or all but coincide: they have no exact border there.
    Tangent {
        /// At how many nodes.
        count: usize,
        /// The first ones.
        places: Vec<[f64; 3]>,
    },
    /// Triangles touch others where healing found no room to part them.
    Touching {
        /// How many.
        triangles: usize,
    },
}

impl Serialize for Fault {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        struct Kind<'a>(&'a Fault);
        impl Serialize for Kind<'_> {
            fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
                Fault::serialize(self.0, serializer)
            }
        }
        #[derive(Serialize)]
        struct FaultText<'a> {
            #[serde(flatten)]
            kind: Kind<'a>,
            message: String,
        }
        FaultText { kind: Kind(self), message: self.to_string() }.serialize(serializer)
    }
}

impl Fault {
    /// How much it weighs where two meshes are compared by what they lack: places without an edge count each, up to as many as
    /// are listed and one for the rest.
    pub(crate) fn weight(&self) -> usize {
        if let Fault::EdgesMissing { count, .. } = self { (*count).min(LISTED + 1) } else { 1 }
    }

    /// Whether the mesh may be open for it: something of the model is not there.
    pub(crate) fn leaves_open(&self) -> bool {
        matches!(self, Fault::NotRead { .. } | Fault::NoMesh { .. } | Fault::FirstTriangulation { .. })
    }

    /// The places it names; none where it is about the mesh as a whole.
    pub fn places(&self) -> Vec<[f64; 3]> {
        match self {
            Fault::Open { places, .. }
            | Fault::NonManifold { places, .. }
            | Fault::NotOriented { places, .. }
            | Fault::Crossing { places, .. }
            | Fault::FacingAway { places, .. }
            | Fault::Mended { places, .. }
            | Fault::Tangent { places, .. }
            | Fault::EdgesMissing { places, .. } => places.clone(),
            Fault::SurfaceMissing { at, .. }
            | Fault::FaceMissing { at, .. }
            | Fault::Thin { at }
            | Fault::ThinWall { at, .. }
            | Fault::Kept { at, .. } => vec![*at],
            Fault::Inverted { .. }
            | Fault::EmptyGroup { .. }
            | Fault::CreasesCutOff { .. }
            | Fault::Far { .. }
            | Fault::VolumeLost { .. }
            | Fault::OtherMethod { .. }
            | Fault::NotRead { .. }
            | Fault::NoMesh { .. }
            | Fault::FirstTriangulation { .. }
            | Fault::NotRemeshed
            | Fault::Touching { .. } => Vec::new(),
        }
    }

    /// Places without exact edges.
    pub(crate) fn edges_missing(at: &[DVec3]) -> Self {
        Fault::EdgesMissing { count: at.len(), places: first(at.iter().copied()) }
    }

    /// Nodes where surfaces that are joined have no border.
    pub(crate) fn tangent(at: &[DVec3]) -> Self {
        Fault::Tangent { count: at.len(), places: first(at.iter().copied()) }
    }

    /// So many triangles, in some boxes, that are mended.
    pub(crate) fn mended(triangles: usize, boxes: &[Aabb]) -> Self {
        Fault::Mended { triangles, places: first(boxes.iter().map(Aabb::center)) }
    }
}

/// The first few of some places.
pub(super) fn first(places: impl Iterator<Item = DVec3>) -> Vec<[f64; 3]> {
    places.take(LISTED).map(|p| p.to_array()).collect()
}

fn point([x, y, z]: &[f64; 3]) -> String {
    format!("({x:.6}, {y:.6}, {z:.6})")
}

/// What is wrong, and with how many things.
fn counted(what: &str, count: usize, things: &str) -> String {
    if count > 0 { format!("{what}: {count} {things}") } else { what.into() }
}

/// What is wrong with the mesh as such, and where.
fn what(f: &mut fmt::Formatter<'_>, what: &str, places: &[[f64; 3]]) -> fmt::Result {
    f.write_str(what)?;
    places.first().map_or(Ok(()), |p| write!(f, ", the first near {}", point(p)))
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Fault::Open { edges, places } => what(f, &counted("the mesh is not closed", *edges, "open edges"), places),
            Fault::NonManifold { count, places } => {
                what(f, &counted("the mesh is not a manifold", *count, "edges and nodes"), places)
            }
            Fault::NotOriented { edges, places } => {
                what(f, &counted("the mesh is not consistently oriented", *edges, "edges"), places)
            }
            Fault::Inverted { .. } => f.write_str("the mesh encloses no positive volume"),
            Fault::Crossing { triangles, own_body, places } => {
                let others = if *own_body { "others of their body" } else { "others" };
                what(f, &format!("{triangles} triangles intersect {others}"), places)
            }
            Fault::FacingAway { triangles, places } => {
                what(f, &format!("{triangles} triangles face away from the surface"), places)
            }
            Fault::Far { distance, triangles: Some(n), .. } => {
                let asked = "triangles are farther from the surface than asked for";
                write!(f, "{n} {asked}: the farthest by {distance:.4e}")
            }
            Fault::Far { distance, limit, triangles: None } => {
                write!(f, "mesh and surface are {distance:.4e} apart somewhere, more than the size of {limit:.4e}")
            }
            Fault::VolumeLost { share, limit } => {
                write!(f, "up to {share:.4e} of the volume lies between mesh and surface, more than {limit:.4e}")
            }
            Fault::SurfaceMissing { face, at, more } => {
                write!(
                    f,
                    "the surface near {} on {face} is not in the mesh, nor are {more} more points of it",
                    point(at)
                )
            }
            Fault::FaceMissing { face, at } => {
                write!(f, "{face} is smaller than the cells near {} and is not in the mesh there", point(at))
            }
            Fault::EmptyGroup { group, faces } => {
                let names = faces.iter().take(LISTED).map(String::as_str).collect::<Vec<_>>().join(", ");
                let more = faces.len().saturating_sub(LISTED);
                let more = if more > 0 { format!(" and {more} more") } else { String::new() };
                write!(f, "group {group:?} holds no triangle: its faces {names}{more} are not in the mesh")
            }
            Fault::EdgesMissing { count, places } => {
                let near = places.iter().map(point).collect::<Vec<_>>().join(" and ");
                write!(f, "no exact edge found near {near}: two faces come too close there")?;
                let more = count.saturating_sub(places.len());
                if more > 0 { write!(f, ", and at {more} more places") } else { Ok(()) }
            }
            Fault::CreasesCutOff { recall, corners, of } => {
                write!(
                    f,
                    "creases are cut off: {:.1} % of the sharp edges and {corners} of {of} corners are there",
                    100.0 * recall
                )
            }
            Fault::Thin { at } => write!(f, "the solid, or a gap, is thinner than the cells near {}", point(at)),
            Fault::ThinWall { face, at, thickness, size } => {
                write!(f, "thickness {thickness:.6} at {} on {face} is below the cell size {size:.6}", point(at))
            }
            Fault::Mended { triangles, places } => {
                let near = places.first().map_or(String::new(), |p| format!(", the first near {}", point(p)));
                write!(f, "with exact edges {triangles} triangles intersect others: mended there{near}")
            }
            Fault::OtherMethod { crossing, inverted, method } => {
                let found = [(*crossing, "intersect others"), (*inverted, "are turned over")];
                let found = found.iter().filter(|f| f.0 > 0).map(|(n, what)| format!("{n} {what}"));
                let found = found.collect::<Vec<_>>().join(" and ");
                write!(f, "with exact edges, of the triangles {found}: made by {method} instead")
            }
            Fault::NotRead { record, line, reason } => write!(f, "#{record} (line {line}): {reason}"),
            Fault::NoMesh { face, source, surface, reason } => {
                let kind = surface.map_or_else(String::new, |s| format!(", {s}"));
                write!(f, "face {face} (#{source}{kind}) has no mesh: {reason}")
            }
            Fault::FirstTriangulation { reason } => {
                write!(f, "a body is left as it was first triangulated: {reason}")
            }
            Fault::NotRemeshed => f.write_str("left as it was: remeshing made it intersect itself"),
            Fault::Kept { triangles, at } => {
                let why = "the surface comes too close to itself there";
                write!(f, "{triangles} triangles stay as they were, at {} and elsewhere: {why}", point(at))
            }
            Fault::Tangent { count, places } => {
                let why = "surfaces that are joined touch or all but coincide: they have no exact border";
                what(f, &counted(why, *count, "nodes"), places)
            }
            Fault::Touching { triangles } => {
                write!(f, "{triangles} triangles touch others where healing found no room to part them")
            }
        }
    }
}
