//! The true sharp edges and corners of a solid, as samples: what a mesh's features are measured against.

use glam::DVec3;

/// A short straight piece of a true sharp edge.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FeatureSample {
    /// A point on the edge.
    pub point: DVec3,
    /// Unit tangent of the edge there.
    pub tangent: DVec3,
    /// The length of edge this sample stands for.
    pub length: f64,
    /// Angle between the outward normals of the two faces, degrees (0 where they are tangent).
    pub angle: f64,
    /// The two pieces of the surface that meet there, see [`Pieces`](super::Pieces).
    pub pieces: [u32; 2],
}

/// The true sharp edges and corners of a solid.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Features {
    /// Samples of the edges; their lengths add up to the total length.
    pub samples: Vec<FeatureSample>,
    /// Points where sharp edges end or meet.
    pub corners: Vec<DVec3>,
}

impl Features {
    /// Total length of the edges whose normals differ by more than `angle` degrees.
    pub fn length(&self, angle: f64) -> f64 {
        self.samples.iter().filter(|s| s.angle > angle).map(|s| s.length).fold(0.0, |all, x| all + x)
    }
}
