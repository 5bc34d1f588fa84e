//! How a patchwork is remeshed, as whoever hands it over says.

use super::judge::Judge;

/// How patches are filled with nodes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Filling {
    /// A packing, evened out and mended.
    #[default]
    Mended,
    /// The front of nodes alone, as frontal methods leave it: flips, nothing is moved.
    Front,
    /// Nodes at random that keep apart, and flips.
    Random,
}

/// What the triangles of a patchwork are like.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Incoming {
    /// About as large as they shall be.
    #[default]
    Sized,
    /// Of any size and shape. Long edges are halved before anything else.
    Raw,
    /// Raw, but they tell how the surface bends within the lengths wanted: they may be collapsed to about these at first.
    RawFine,
}

/// How a patchwork is remeshed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Policy {
    /// How patches are filled with nodes.
    pub filling: Filling,
    /// How triangles are judged; raw ones by their angles once they are packed.
    pub judge: Judge,
    /// What they are like.
    pub incoming: Incoming,
    /// Whether narrow gaps between borders, short borders, bends of borders and, where [asked for](super::RemeshOptions::thickness), thin walls make
    /// edges shorter. Else whoever made the patchwork has seen to that.
    pub narrow: bool,
    /// Whether borders are divided by [`sizes`](super::Patchwork::sizes) already, which then are what nodes want.
    pub spaced: bool,
    /// Whether the surface goes on beyond open edges, in other meshes that know the nodes there: these stay, and are no border.
    pub goes_on: bool,
    /// Up to so many edges from open edges triangles are made anew by whoever takes the mesh, from these but whatever their angles.
    pub made_anew: usize,
    /// Whether what is frozen is put right at last, as far as that makes no triangles cross.
    pub thaws: bool,
}

impl Policy {
    /// For surfaces of functions that were cut along the borders of their pieces.
    pub fn of_functions() -> Self {
        Self { narrow: true, ..Self::default() }
    }

    /// For faces of boundary representations that were triangulated with edges as long as they shall be.
    pub fn of_faces() -> Self {
        Self { judge: Judge::Angles, spaced: true, ..Self::default() }
    }

    /// For triangles of any size and shape; `fine` where they tell how the surface bends within the lengths wanted.
    pub fn of_triangles(fine: bool) -> Self {
        Self { incoming: if fine { Incoming::RawFine } else { Incoming::Raw }, ..Self::default() }
    }

    /// The same for a part of the patchwork, once triangles are about as large as they shall be.
    pub(super) fn of_part(&self) -> Self {
        let Self { filling, judge, made_anew, .. } = *self;
        Self { filling, judge, made_anew, ..Self::default() }
    }

    /// Whether triangles may have any size and shape.
    pub(super) fn is_raw(&self) -> bool {
        self.incoming != Incoming::Sized
    }

    /// Whether triangles are judged by angles on a smooth surface: between the nodes of raw triangles its normals are as rough as these.
    pub(super) fn is_smooth_by_angles(&self) -> bool {
        self.judge.is_by_angles() && !self.is_raw()
    }
}
