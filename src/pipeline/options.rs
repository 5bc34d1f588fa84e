//! What a mesh is asked for.

use super::method::Method;
use super::refine::Refinement;
use crate::error::{Error, Result};
use crate::implicit::ExtractOptions;
use crate::implicit::part::Part;
use crate::optimize::Sequence;
use crate::parametric::mesh::Remedy;
use crate::sizing::{SizeRequest, SizingOptions};

/// What [`mesh_part`](super::mesh_part) is asked for.
#[derive(Debug, Clone, PartialEq)]
pub struct MeshOptions {
    /// Cell size, before the part's own wish and the default of 2 % of the diagonal.
    pub size: Option<SizeRequest>,
    /// How.
    pub method: Method,
    /// The operators that [`Method::Operators`] runs, before the part's own wish and [`operators_sequence`](crate::optimize::operators_sequence);
    /// it is an error with any other method.
    pub sequence: Option<Sequence>,
    /// See [`ExtractOptions::root_tolerance`].
    pub root_tolerance: f64,
    /// What a mesh may take while it is made, in bytes; 8 GiB. Of solids of R-functions see [`ExtractOptions::memory`]; what is made of
    /// boundaries is refused once more triangles are expected than that holds, at 500 bytes each.
    pub memory: u64,
    /// On curved parts neighboring edges turn by at most this many degrees; 20 without a wish. The methods without exact edges have
    /// nine nodes to a radius where neither this nor `tolerance` is asked for.
    pub angle: Option<f64>,
    /// No triangle is to be farther than this from the surface: edges are made to stay within 0.45 of it. Without it
    /// 0.035 of the size, at least a 5400th of the diagonal; nothing where only an angle is asked for.
    pub tolerance: Option<SizeRequest>,
    /// At most this share of the solid's volume is to lie between triangles and surface (CAD models and solids built from edges).
    pub volume: Option<f64>,
    /// How fast edge lengths may grow per length. Without it a fifth; for boundary representations up to 0.45 where details make most
    /// of the triangles, 0.3 for soups of coarse facets.
    pub grading: Option<f64>,
    /// Curvature, narrow gaps and thin walls make no edges shorter than this.
    pub least: Option<SizeRequest>,
    /// Regions of a CAD model's faces narrower than this are cut off; none for 0. Without it those narrower than a fortieth of
    /// the size are, at the edges of thin walls and grooves those too narrow for anything but needles.
    pub trim: Option<SizeRequest>,
    /// Remedies for troubles of faces that are left out, for study (CAD models and solids built from edges).
    pub without: Vec<Remedy>,
    /// No edge is longer than this many times the solid's thickness beneath it (solids of R-functions, leaf method).
    pub thickness: Option<f64>,
    /// Where edges shall be shorter; the methods without exact edges do not heed this.
    pub refinements: Vec<Refinement>,
    /// Whether to measure distances and features too, not only what makes a mesh sound. The mesh is the same without: the leaf
    /// method measures distances always, as it does something about them.
    pub measure: bool,
    /// Whether the report tells how long attempts and stages took. Reports are the same every time without.
    pub timed: bool,
}

impl Default for MeshOptions {
    fn default() -> Self {
        let extract = ExtractOptions::new(1.0);
        Self {
            size: None,
            method: Method::default(),
            sequence: None,
            root_tolerance: extract.root_tolerance,
            memory: extract.memory,
            angle: None,
            tolerance: None,
            volume: None,
            grading: None,
            least: None,
            trim: None,
            without: Vec::new(),
            thickness: None,
            refinements: Vec::new(),
            measure: true,
            timed: false,
        }
    }
}

impl MeshOptions {
    /// Errors: usage, for what methods are not compared with.
    pub(super) fn comparable(&self) -> Result<()> {
        if self.volume.is_some() || !self.without.is_empty() {
            return Err(Error::Usage("methods are compared with neither volume nor without".into()));
        }
        Ok(())
    }

    /// With lengths in place of shares, for a part whose box has a diagonal.
    pub(super) fn resolved(&self, diagonal: f64) -> Self {
        let length = |asked: SizeRequest| SizeRequest::Length(asked.length(diagonal));
        Self { tolerance: self.tolerance.map(length), least: self.least.map(length), ..self.clone() }
    }

    /// What of [`resolved`](Self::resolved) options lengths of edges follow from.
    pub(super) fn asked(&self) -> SizingOptions {
        SizingOptions { angle: self.angle, tolerance: self.tolerance_length(), grading: self.grading }
    }

    /// The tolerance of [`resolved`](Self::resolved) options.
    pub(super) fn tolerance_length(&self) -> Option<f64> {
        self.tolerance.and_then(known)
    }

    /// The least length of edges of [`resolved`](Self::resolved) options.
    pub(super) fn least_length(&self) -> Option<f64> {
        self.least.and_then(known)
    }

    /// The options for a part, by the method that was said. Where none was, a sequence of operators, these options' or the part's own,
    /// is run by the method that runs sequences.
    pub fn for_part(&self, part: &Part, said: Option<Method>) -> Self {
        let by_sequence = self.sequence.is_some() || part.mesh.sequence.is_some();
        let method = said.unwrap_or(if by_sequence { Method::Operators } else { self.method });
        Self { method, ..self.clone() }
    }

    /// Refuses what only solids of R-functions know.
    pub(super) fn for_boundary(&self) -> Result<()> {
        match self.sequence {
            Some(_) => Err(Error::Usage("a sequence of operators: that is for solids of R-functions alone".into())),
            None => Ok(()),
        }
    }

    /// Refuses what only boundary representations know.
    pub(super) fn for_any_solid(&self) -> Result<()> {
        let refused =
            [(!self.without.is_empty(), "remedies to leave out"), (self.volume.is_some(), "a volume to lose")];
        match refused.iter().find(|r| r.0) {
            Some((_, what)) => {
                Err(Error::Usage(format!("{what}: that is for CAD models and solids built from edges alone")))
            }
            None => Ok(()),
        }
    }
}

fn known(asked: SizeRequest) -> Option<f64> {
    match asked {
        SizeRequest::Length(h) => Some(h),
        SizeRequest::Share(_) => None,
    }
}
