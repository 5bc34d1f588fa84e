//! Places of things in space: right-handed frames, and the similarities that move them.

use glam::{DMat3, DVec2, DVec3};

/// An origin and three orthonormal, right-handed axes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Frame {
    /// The origin.
    pub origin: DVec3,
    /// The axes, as columns.
    pub axes: DMat3,
}

impl Frame {
    /// The frame of the coordinates themselves.
    pub const WORLD: Frame = Frame { origin: DVec3::ZERO, axes: DMat3::IDENTITY };

    /// A frame with the given z axis, its x axis as near to `x` as it can be. Where `x` is missing or along `z`, any
    /// will do; a `z` of length 0 counts as (0, 0, 1).
    pub fn new(origin: DVec3, z: DVec3, x: Option<DVec3>) -> Self {
        let z = z.try_normalize().unwrap_or(DVec3::Z);
        let x = x.and_then(|x| {
            let x = x.try_normalize()?;
            let flat = x - z * x.dot(z);
            if flat.length() > 1e-9 { flat.try_normalize() } else { None }
        });
        let x = x.unwrap_or_else(|| if z.z.abs() > 0.9 { DVec3::X } else { DVec3::Z.cross(z) });
        let y = z.cross(x).normalize();
        Self { origin, axes: DMat3::from_cols(y.cross(z), y, z) }
    }

    /// The z axis.
    pub fn z(&self) -> DVec3 {
        self.axes.z_axis
    }

    /// A point given in the frame.
    pub fn point(&self, local: DVec3) -> DVec3 {
        self.origin + self.axes * local
    }

    /// A point's coordinates in the frame.
    pub fn local(&self, p: DVec3) -> DVec3 {
        self.axes.transpose() * (p - self.origin)
    }

    /// The unit vector at an angle from the x axis in the xy plane, and the one a quarter turn on.
    pub fn turned(&self, angle: f64) -> (DVec3, DVec3) {
        let (s, c) = angle.sin_cos();
        (c * self.axes.x_axis + s * self.axes.y_axis, c * self.axes.y_axis - s * self.axes.x_axis)
    }

    /// Angle of a local point around the z axis, in 0..2 pi.
    pub fn angle(local: DVec2) -> f64 {
        let a = local.y.atan2(local.x);
        if a < 0.0 { a + std::f64::consts::TAU } else { a }
    }
}

/// A rotation, a uniform scale and a translation: p becomes `scale * (rotation * p) + translation`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Similarity {
    /// The scale.
    pub scale: f64,
    /// The rotation.
    pub rotation: DMat3,
    /// The translation.
    pub translation: DVec3,
}

impl Similarity {
    /// Nothing moves.
    pub const IDENTITY: Similarity = Similarity { scale: 1.0, rotation: DMat3::IDENTITY, translation: DVec3::ZERO };

    /// A change of the unit of length.
    pub fn scaled(scale: f64) -> Self {
        Self { scale, ..Self::IDENTITY }
    }

    /// What carries the frame `from` into the frame `to`.
    pub fn between(from: &Frame, to: &Frame) -> Self {
        let rotation = to.axes * from.axes.transpose();
        Self { scale: 1.0, rotation, translation: to.origin - rotation * from.origin }
    }

    /// First `first`, then this.
    pub fn after(&self, first: &Self) -> Self {
        Self {
            scale: self.scale * first.scale,
            rotation: self.rotation * first.rotation,
            translation: self.point(first.translation),
        }
    }

    /// A point moved.
    pub fn point(&self, p: DVec3) -> DVec3 {
        self.scale * (self.rotation * p) + self.translation
    }

    /// A difference of points moved.
    pub fn vector(&self, v: DVec3) -> DVec3 {
        self.scale * (self.rotation * v)
    }

    /// A frame moved.
    pub fn frame(&self, f: &Frame) -> Frame {
        Frame { origin: self.point(f.origin), axes: self.rotation * f.axes }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn frames_are_orthonormal_and_similarities_compose(
            z in prop::array::uniform3(-1.0f64..1.0), x in prop::array::uniform3(-1.0f64..1.0),
            p in prop::array::uniform3(-5.0f64..5.0),
        ) {
            let (z, x, p) = (DVec3::from_array(z), DVec3::from_array(x), DVec3::from_array(p));
            for f in [Frame::new(p, z, Some(x)), Frame::new(p, z, None), Frame::new(p, z, Some(z)), Frame::new(p, DVec3::ZERO, Some(x))] {
                prop_assert!((f.axes * f.axes.transpose() - DMat3::IDENTITY).to_cols_array().iter().all(|v| v.abs() < 1e-12));
                prop_assert!((f.axes.determinant() - 1.0).abs() < 1e-12);
                prop_assert!(f.point(f.local(x)).distance(x) < 1e-12);
                let g = Frame::new(x, p, Some(z));
                let m = Similarity::between(&f, &g);
                prop_assert!(m.point(f.origin).distance(g.origin) < 1e-12 && m.vector(f.z()).distance(g.z()) < 1e-12);
                let twice = Similarity::scaled(2.0).after(&m);
                prop_assert!(twice.point(p).distance(2.0 * m.point(p)) < 1e-12);
                prop_assert!(m.frame(&f).axes.z_axis.distance(g.z()) < 1e-12);
            }
        }
    }
}
