//! How a picture is made: view, clipping, colors, edges, size.

use std::str::FromStr;

use glam::DVec3;

use crate::error::{Error, Result};

/// The largest width and height of a picture, in pixels: four bytes per pixel stay within 1 GiB.
pub const MAX_SIDE: usize = 16_384;

/// Where the mesh is seen from; always orthographic.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct View {
    /// From the mesh towards the camera; any length but 0.
    pub towards: DVec3,
    /// The direction that points up in the picture as far as `towards` allows; z takes its place when both are parallel,
    /// and y when that is parallel as well.
    pub up: DVec3,
    /// The share of the picture kept free on every side, in 0..0.5.
    pub margin: f64,
    /// The ball (center and radius) that fills the picture; `None`: the whole mesh does.
    pub focus: Option<(DVec3, f64)>,
}

impl Default for View {
    /// Three quarters from the front right and above, z up.
    fn default() -> Self {
        Self { towards: DVec3::new(1.0, -1.3, 0.8), up: DVec3::Z, margin: 0.05, focus: None }
    }
}

/// Views with a name: azimuth and elevation in degrees. Of `iso` the sines and cosines are exact roots only to rounding.
const NAMED_VIEWS: [(&str, f64, f64); 7] = [
    ("iso", 45.0, 35.264_389_682_754_654),
    ("front", 0.0, 0.0),
    ("back", 180.0, 0.0),
    ("left", -90.0, 0.0),
    ("right", 90.0, 0.0),
    ("top", 0.0, 90.0),
    ("bottom", 0.0, -90.0),
];

impl View {
    /// A view by angles in degrees. Azimuth 0 looks from the front, against y; 90 from the right, where x points.
    /// Elevation 90 looks from above, -90 from below, the front at the picture's lower and upper side then.
    ///
    /// Multiples of 90 degrees are exact.
    pub fn from_angles(azimuth: f64, elevation: f64) -> Self {
        let ((s, c), (up, flat)) = (sin_cos(azimuth), sin_cos(elevation));
        let from = DVec3::new(s, -c, 0.0);
        Self { towards: flat * from + up * DVec3::Z, up: flat * DVec3::Z - up * from, ..Self::default() }
    }

    /// Unit vectors to the right, upwards and towards the camera.
    pub(super) fn axes(&self) -> Option<[DVec3; 3]> {
        let towards = self.towards.try_normalize()?;
        let up = [self.up, DVec3::Z, DVec3::Y];
        // Closer to parallel than a thousandth, the picture's tilt would hang on rounding.
        let right = up.iter().map(|u| u.normalize_or_zero().cross(towards)).find(|r| r.length() > 1e-3)?.normalize();
        Some([right, towards.cross(right), towards])
    }
}

/// Sine and cosine of an angle in degrees, exact for right angles.
fn sin_cos(degrees: f64) -> (f64, f64) {
    let turn = degrees.rem_euclid(360.0);
    match turn {
        0.0 | 360.0 => (0.0, 1.0),
        90.0 => (1.0, 0.0),
        180.0 => (0.0, -1.0),
        270.0 => (-1.0, 0.0),
        _ => turn.to_radians().sin_cos(),
    }
}

impl FromStr for View {
    type Err = Error;

    /// A name (`iso`, `front`, `back`, `left`, `right`, `top`, `bottom`) or `AZIMUTH,ELEVATION` in degrees, as
    /// [`from_angles`](View::from_angles) takes them. Errors: usage.
    fn from_str(s: &str) -> Result<Self> {
        let text = s.trim();
        if let Some((_, azimuth, elevation)) = NAMED_VIEWS.iter().find(|v| v.0 == text) {
            return Ok(Self::from_angles(*azimuth, *elevation));
        }
        let angle = |t: &str| t.trim().parse::<f64>().ok().filter(|a| a.is_finite());
        let angles = text.split_once(',').and_then(|(a, e)| Some((angle(a)?, angle(e)?)));
        match angles.filter(|(_, elevation)| elevation.abs() <= 90.0) {
            Some((azimuth, elevation)) => Ok(Self::from_angles(azimuth, elevation)),
            None => Err(Error::Usage(format!(
                "a view is {} or AZIMUTH,ELEVATION in degrees with an elevation from -90 to 90, not {s:?}",
                NAMED_VIEWS.map(|v| v.0).join(", ")
            ))),
        }
    }
}

/// One of the two halves a plane across an axis leaves.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum KeptHalf {
    /// Where the coordinate is smaller than the plane's.
    Below,
    /// Where the coordinate is larger than the plane's.
    Above,
}

/// A plane across an axis that cuts away what lies on one side of it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ClipPlane {
    /// The axis the plane is perpendicular to: 0 for x, 1 for y, 2 for z.
    pub axis: usize,
    /// Where on the axis, in the mesh's unit.
    pub position: f64,
    /// What stays; `None`: the half away from the camera, and the one below where the view runs along the plane.
    pub keep: Option<KeptHalf>,
}

/// The axes' names.
pub(super) const AXES: [&str; 3] = ["x", "y", "z"];

impl FromStr for ClipPlane {
    type Err = Error;

    /// `AXIS=POSITION`, with `,below` or `,above` after it for the half that stays. Errors: usage.
    fn from_str(s: &str) -> Result<Self> {
        let parsed = || {
            let (axis, rest) = s.split_once('=')?;
            let axis = AXES.iter().position(|a| *a == axis.trim())?;
            let (position, keep) = match rest.split_once(',') {
                None => (rest, None),
                Some((position, "below")) => (position, Some(KeptHalf::Below)),
                Some((position, "above")) => (position, Some(KeptHalf::Above)),
                Some(_) => return None,
            };
            let position = position.trim().parse::<f64>().ok().filter(|p| p.is_finite())?;
            Some(Self { axis, position, keep })
        };
        parsed().ok_or_else(|| {
            let forms = "AXIS=POSITION, AXIS=POSITION,below or AXIS=POSITION,above with x, y or z as axis";
            Error::Usage(format!("a clipping plane is {forms}, such as x=0 or z=1.5,above, not {s:?}"))
        })
    }
}

/// What the colors of triangles tell.
#[derive(Debug, Clone, PartialEq, Default)]
pub enum ColorBy {
    /// The face: equal names have equal colors, faces that touch have different ones as long as 12 colors suffice.
    #[default]
    Face,
    /// The triangle's smallest angle, from red (0°) to blue (60°).
    Angle,
    /// The mean of the triangle's three edges over that of all edges, from blue (a quarter) over pale to red (four times).
    Edge,
    /// A distance of each node of the mesh; the largest of a triangle's three, from blue (0) to red (the largest of all
    /// that are finite). Triangles with a node whose distance is not finite have a color of their own.
    Distance(Vec<f64>),
    /// A class of each node of the mesh: 0 regular, 1 on a crease, 2 (and more) a corner; a triangle has the color of its node with the
    /// highest class.
    Class(Vec<u8>),
}

/// How a picture is made.
#[derive(Debug, Clone, PartialEq)]
pub struct RenderOptions {
    /// Width in pixels.
    pub width: usize,
    /// Height in pixels.
    pub height: usize,
    /// The point of view.
    pub view: View,
    /// What is cut away before the mesh is drawn; at most one plane for each half of an axis.
    pub clips: Vec<ClipPlane>,
    /// Samples per pixel along each axis, 1..=8.
    pub samples: usize,
    /// What the colors tell.
    pub color_by: ColorBy,
    /// Whether triangle edges are drawn; `None`: when triangles are larger than a few pixels.
    pub wireframe: Option<bool>,
    /// Edges whose triangles' normals differ by more than this many degrees are drawn thick; `None`: no edges on top at
    /// all, neither sharp ones nor borders, boundaries and the outlines of cuts.
    pub sharp_angle: Option<f64>,
    /// Whether a legend stands at the right: names of up to 16 faces, or a scale.
    pub legend: bool,
    /// Whether the background is transparent; without this it is nearly white.
    pub transparent: bool,
}

impl Default for RenderOptions {
    fn default() -> Self {
        Self {
            width: 1200,
            height: 900,
            view: View::default(),
            clips: Vec::new(),
            samples: 3,
            color_by: ColorBy::Face,
            wireframe: None,
            sharp_angle: Some(30.0),
            legend: true,
            transparent: false,
        }
    }
}
