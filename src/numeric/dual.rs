//! Forward-mode differentiation: a value and its gradient by x, y, z.

use std::ops;

use glam::DVec3;

/// A value with its gradient.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Dual {
    /// The value.
    pub v: f64,
    /// The gradient.
    pub g: DVec3,
}

impl Dual {
    /// A constant.
    pub fn constant(v: f64) -> Self {
        Self { v, g: DVec3::ZERO }
    }

    /// A value with its gradient.
    pub fn new(v: f64, g: DVec3) -> Self {
        Self { v, g }
    }

    /// Chain rule: value `v` and derivative `d` of a function of `self`.
    pub fn chain(self, v: f64, d: f64) -> Self {
        // an undefined derivative of a function whose argument does not vary is no derivative at all
        Self { v, g: if self.g == DVec3::ZERO { DVec3::ZERO } else { self.g * d } }
    }
}

impl ops::Neg for Dual {
    type Output = Self;
    fn neg(self) -> Self {
        Self { v: -self.v, g: -self.g }
    }
}

impl ops::Add for Dual {
    type Output = Self;
    fn add(self, o: Self) -> Self {
        Self { v: self.v + o.v, g: self.g + o.g }
    }
}

impl ops::Sub for Dual {
    type Output = Self;
    fn sub(self, o: Self) -> Self {
        Self { v: self.v - o.v, g: self.g - o.g }
    }
}

impl ops::Mul for Dual {
    type Output = Self;
    fn mul(self, o: Self) -> Self {
        Self { v: self.v * o.v, g: self.g * o.v + o.g * self.v }
    }
}

impl ops::Div for Dual {
    type Output = Self;
    fn div(self, o: Self) -> Self {
        let v = self.v / o.v;
        Self { v, g: (self.g - o.g * v) / o.v }
    }
}
