//! Where a user asks for shorter edges: boxes, spheres and faces by name.

use std::str::FromStr;

use glam::DVec3;

use crate::error::{Error, Result, nearest};
use crate::implicit::part::glob;
use crate::sizing::{Region, RegionShape, SizeRequest};
use crate::spatial::Aabb;

/// What a refinement is about.
#[derive(Debug, Clone, PartialEq)]
pub enum Place {
    /// A part of space, in the part's unit.
    Region(RegionShape),
    /// Faces whose names fit a pattern with `*` and `?`.
    Faces(String),
}

/// A wish for an edge length somewhere. Written as `box=x0,y0,z0,x1,y1,z1:H`, `sphere=x,y,z,r:H` or `face=PATTERN:H`, H a
/// length or a share of the diagonal.
#[derive(Debug, Clone, PartialEq)]
pub struct Refinement {
    /// Where.
    pub place: Place,
    /// The edge length.
    pub size: SizeRequest,
}

impl FromStr for Refinement {
    type Err = Error;

    fn from_str(s: &str) -> Result<Self> {
        let bad = || {
            let forms = "box=x0,y0,z0,x1,y1,z1:H, sphere=x,y,z,r:H or face=PATTERN:H";
            Error::Usage(format!("a refinement is {forms}, not {s:?}"))
        };
        let (what, size) = s.rsplit_once(':').ok_or_else(bad)?;
        let (kind, value) = what.split_once('=').ok_or_else(bad)?;
        let size = size.parse()?;
        let numbers = || -> Result<Vec<f64>> {
            let one = |x: &str| x.trim().parse::<f64>().ok().filter(|x| x.is_finite()).ok_or_else(bad);
            value.split(',').map(one).collect()
        };
        let place = match kind.trim() {
            "face" => Place::Faces(value.to_string()),
            "box" => match numbers()?[..] {
                [a, b, c, d, e, f] => {
                    let (p, q) = (DVec3::new(a, b, c), DVec3::new(d, e, f));
                    Place::Region(RegionShape::Box(Aabb::new(p.min(q), p.max(q))))
                }
                _ => return Err(bad()),
            },
            "sphere" => match numbers()?[..] {
                [x, y, z, radius] if radius > 0.0 => {
                    Place::Region(RegionShape::Sphere { center: DVec3::new(x, y, z), radius })
                }
                _ => return Err(bad()),
            },
            _ => return Err(bad()),
        };
        Ok(Self { place, size })
    }
}

/// Refinements as lengths.
#[derive(Debug, Clone, Default)]
pub(super) struct Wishes {
    pub(super) regions: Vec<Region>,
    /// By face; empty where there is no such wish.
    pub(super) faces: Vec<Option<f64>>,
}

impl Wishes {
    /// Wishes for a part of some size with some faces.
    ///
    /// Errors: a pattern that fits no face, with the name nearest to it.
    pub(super) fn new<'a>(
        list: &[Refinement],
        diagonal: f64,
        names: impl Iterator<Item = &'a str> + Clone,
    ) -> Result<Self> {
        let mut out = Self::default();
        for r in list {
            let size = r.size.length(diagonal);
            match &r.place {
                Place::Region(shape) => out.regions.push(Region { shape: *shape, size }),
                Place::Faces(pattern) => {
                    let hit: Vec<bool> = names.clone().map(|n| glob(pattern, n)).collect();
                    if !hit.contains(&true) {
                        let near = nearest(pattern, names.clone());
                        let near = near.map_or(String::new(), |n| format!("; the nearest name is {n:?}"));
                        return Err(Error::Usage(format!("refinement: no face is called {pattern:?}{near}")));
                    }
                    out.faces.resize(hit.len(), None);
                    for (f, _) in out.faces.iter_mut().zip(hit).filter(|x| x.1) {
                        *f = Some(f.map_or(size, |s: f64| s.min(size)));
                    }
                }
            }
        }
        Ok(out)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_written_is_understood_or_refused() {
        let r: Refinement = "box=1,2,3,0,0,0:0.5".parse().unwrap();
        let b = Aabb::new(DVec3::ZERO, DVec3::new(1.0, 2.0, 3.0));
        assert_eq!(r, Refinement { place: Place::Region(RegionShape::Box(b)), size: SizeRequest::Length(0.5) });
        let r: Refinement = "face=a:b*:1%".parse().unwrap();
        assert_eq!(r, Refinement { place: Place::Faces("a:b*".into()), size: SizeRequest::Share(0.01) });
        for s in ["", "box=1,2,3:1", "sphere=0,0,0,-1:1", "sphere=0,0,0,1", "ball=0,0,0,1:1", "box=a,0,0,1,1,1:1"] {
            assert!(s.parse::<Refinement>().is_err(), "{s}");
        }
    }

    #[test]
    fn faces_are_found_by_pattern_and_missing_ones_told() {
        let names = ["wing.tip", "wing.skin", "nose"].into_iter();
        let list = ["face=wing*:1", "face=*tip:0.5"].map(|s| s.parse().unwrap());
        let w = Wishes::new(&list, 1.0, names.clone()).unwrap();
        assert_eq!(w.faces, [Some(0.5), Some(1.0), None]);
        let e = Wishes::new(&["face=wing.tap:1".parse().unwrap()], 1.0, names).unwrap_err().to_string();
        assert!(e.contains("\"wing.tap\"") && e.contains("\"wing.tip\""), "{e}");
    }
}
