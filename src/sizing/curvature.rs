//! How long edges should be: the size asked for, made smaller where the surface curves.

/// What edge length is wanted where.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sizing {
    /// Edge length on flat parts.
    pub size: f64,
    /// Nodes per radius of curvature: no edge longer than radius / this.
    pub nodes_per_radius: Option<f64>,
    /// Largest distance between an edge and the surface.
    pub chord: Option<f64>,
    /// No edge is asked to be shorter than this, whatever the curvature.
    pub least: f64,
}

impl Sizing {
    /// `size` everywhere.
    pub fn uniform(size: f64) -> Self {
        Self { size, nodes_per_radius: None, chord: None, least: size }
    }

    /// The length wanted where the larger principal curvature has magnitude `curvature`: R/n for n nodes per radius R, and
    /// 2√(2εR − ε²) for a chord that stays within ε.
    pub fn at(&self, curvature: f64) -> f64 {
        let radius = 1.0 / curvature.max(f64::MIN_POSITIVE);
        let by_count = self.nodes_per_radius.map_or(f64::INFINITY, |n| radius / n);
        let by_chord = self.chord.map_or(f64::INFINITY, |e| {
            if e >= radius { 2.0 * radius } else { 2.0 * (2.0 * e * radius - e * e).sqrt() }
        });
        self.size.min(by_count).min(by_chord).max(self.least.min(self.size))
    }

    /// Whether the size depends on the place.
    pub fn varies(&self) -> bool {
        self.nodes_per_radius.is_some() || self.chord.is_some()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_abs_diff_eq;

    #[test]
    fn sizes_by_count_and_by_chord() {
        let s = Sizing { size: 1.0, nodes_per_radius: Some(4.0), chord: None, least: 0.01 };
        assert_eq!((s.at(0.0), s.at(1.0), s.at(100.0)), (1.0, 0.25, 0.01));
        let s = Sizing { size: 9.0, nodes_per_radius: None, chord: Some(0.1), least: 0.01 };
        // The sagitta of the chord of this length on a unit circle is 0.1.
        let c = s.at(1.0);
        assert_abs_diff_eq!(1.0 - (1.0 - 0.25 * c * c).sqrt(), 0.1, epsilon = 1e-12);
        assert_eq!(s.at(20.0), 0.1);
        assert_eq!(Sizing::uniform(2.0).at(1e9), 2.0);
    }
}
