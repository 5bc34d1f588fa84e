//! A picture of a mesh with options by name, and what its colors need: classes of nodes, or distances to the surface of a part.

use std::path::{Path, PathBuf};

use glam::DVec3;

use super::brep::{is_step, load_step};
use super::brep_info::distances_to_step;
use super::compare::node_classes;
use super::load::load_part;
use super::mesh::distances_to;
use crate::error::{Error, Place, Result};
use crate::implicit::part::Part;
use crate::io::write_atomic;
use crate::mesh::TriMesh;
use crate::render::{ColorBy, MAX_SIDE, Picture, RenderOptions, View, render};
use crate::run::Run;

/// Smaller pictures show nothing.
const MIN_SIDE: usize = 16;

/// What the colors of a picture tell.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Coloring {
    /// The face.
    #[default]
    Face,
    /// The triangle's smallest angle.
    Angle,
    /// The edges' length over the mean.
    Edge,
    /// How far nodes are from the true surface.
    Distance,
    /// Whether nodes are regular, on creases or corners.
    Class,
}

/// The surface that a mesh should be of.
#[derive(Debug, Clone)]
pub enum TrueSurface {
    /// That of a part.
    Part(Box<Part>),
    /// That of a part file or a STEP file.
    File {
        /// The file.
        path: PathBuf,
        /// Numbers of a part file that are replaced.
        overrides: Vec<(String, f64)>,
    },
}

impl TrueSurface {
    /// The distance of every node from the surface, as [`distances_to`] has it.
    ///
    /// Errors: those of reading the file; input where no node is near the surface; cancelled.
    fn distances(&self, mesh: &TriMesh, run: &Run) -> Result<Vec<f64>> {
        let located = |e: Error| match self {
            TrueSurface::Part(_) => e,
            TrueSurface::File { path, .. } => e.in_file(path),
        };
        let found = match self {
            TrueSurface::Part(part) => distances_to(mesh, part, run),
            TrueSurface::File { path, overrides } if is_step(path) => step_distances(mesh, path, overrides, run),
            TrueSurface::File { path, overrides } => {
                load_part(path, overrides).and_then(|part| distances_to(mesh, &part, run))
            }
        };
        let found = found.map_err(located)?;
        // A picture of one color would tell nothing.
        if found.iter().all(|d| d.is_infinite()) {
            let what = "its surface is nowhere near the mesh";
            return Err(located(Error::input(Place::Unknown, what).with_help("are both in the same unit?")));
        }
        Ok(found)
    }
}

fn step_distances(mesh: &TriMesh, path: &Path, overrides: &[(String, f64)], run: &Run) -> Result<Vec<f64>> {
    if !overrides.is_empty() {
        return Err(Error::Usage("numbers of part files are overridden; a STEP file has none".into()));
    }
    distances_to_step(mesh, load_step(path, run)?, run)
}

/// How a picture is made, with options that are said as text.
#[derive(Debug, Clone, Default)]
pub struct PictureOptions {
    /// All but what the colors tell: `color_by` is passed over.
    pub render: RenderOptions,
    /// What the colors tell.
    pub coloring: Coloring,
    /// The surface that distances are measured to.
    pub against: Option<TrueSurface>,
}

impl PictureOptions {
    /// Names of the options that are said as text.
    pub const NAMES: [&str; 8] = ["view", "focus", "clip", "color", "edges", "pixels", "transparent", "legend"];

    /// Says one option as the command has it: `view`, `clip` (each adds a plane), `color`, `edges`, `transparent`; `pixels` is
    /// `WIDTHxHEIGHT`, `focus` the ball that fills the picture as `X,Y,Z,RADIUS`, `legend` `false` for none.
    ///
    /// # Errors
    /// [`Error::Usage`] for another name and for what is no value.
    pub fn set(&mut self, name: &str, value: &str) -> Result<()> {
        let r = &mut self.render;
        match name {
            "view" => {
                // What is in focus stays there from wherever it is seen.
                r.view = View { focus: r.view.focus, ..value.parse()? };
            }
            "focus" => r.view.focus = Some(ball(value)?),
            "clip" => r.clips.push(value.parse()?),
            "color" => self.coloring = coloring(value)?,
            "edges" => {
                let drawn = edges(value)?;
                (r.wireframe, r.sharp_angle) = (Some(drawn.triangles), drawn.sharp);
            }
            "pixels" => [r.width, r.height] = pixels(value)?,
            "transparent" => r.transparent = switch(name, value)?,
            "legend" => r.legend = switch(name, value)?,
            _ => {
                let known = Self::NAMES.join(", ");
                return Err(Error::Usage(format!("there is no option {name:?} of pictures; there are: {known}")));
            }
        }
        Ok(())
    }
}

/// Width and height of a picture, said as `WIDTHxHEIGHT`.
///
/// # Errors
/// [`Error::Usage`] for anything else, and for sides that are too short or too long.
pub fn pixels(s: &str) -> Result<[usize; 2]> {
    let side = |t: &str| t.trim().parse::<usize>().ok().filter(|n| (MIN_SIDE..=MAX_SIDE).contains(n));
    let sides = s.split_once('x').and_then(|(width, height)| Some([side(width)?, side(height)?]));
    sides.ok_or_else(|| {
        Error::Usage(format!(
            "a picture is WIDTHxHEIGHT with whole numbers of pixels from {MIN_SIDE} to {MAX_SIDE}, not {s:?}"
        ))
    })
}

fn ball(s: &str) -> Result<(DVec3, f64)> {
    let all: Option<Vec<f64>> = s.split(',').map(|n| n.trim().parse().ok().filter(|x: &f64| x.is_finite())).collect();
    match all.as_deref() {
        Some([x, y, z, r]) if *r > 0.0 => Ok((DVec3::new(*x, *y, *z), *r)),
        _ => Err(Error::Usage(format!("a focus is X,Y,Z,RADIUS with a positive radius, not {s:?}"))),
    }
}

fn coloring(s: &str) -> Result<Coloring> {
    Ok(match s.trim() {
        "face" => Coloring::Face,
        "angle" => Coloring::Angle,
        "edge" => Coloring::Edge,
        "distance" => Coloring::Distance,
        "class" => Coloring::Class,
        _ => return Err(Error::Usage(format!("color is face, angle, edge, distance or class, not {s:?}"))),
    })
}

/// Which edges are drawn.
struct Drawn {
    triangles: bool,
    sharp: Option<f64>,
}

fn edges(s: &str) -> Result<Drawn> {
    let sharp = RenderOptions::default().sharp_angle;
    match s.trim() {
        "none" => Ok(Drawn { triangles: false, sharp: None }),
        "sharp" => Ok(Drawn { triangles: false, sharp }),
        "all" => Ok(Drawn { triangles: true, sharp }),
        _ => Err(Error::Usage(format!("edges are none, sharp or all, not {s:?}"))),
    }
}

fn switch(name: &str, s: &str) -> Result<bool> {
    match s.trim() {
        "1" | "true" | "yes" | "on" => Ok(true),
        "0" | "false" | "no" | "off" => Ok(false),
        _ => Err(Error::Usage(format!("{name} is \"true\" or \"false\", not {s:?}"))),
    }
}

/// Draws a mesh, as `rvachev render` does.
///
/// # Errors
/// [`Error::Usage`] for distances without a surface, and a surface without distances; those of [`render`], of [`node_classes`] for classes,
/// and of reading the part for distances.
pub fn picture(mesh: &TriMesh, options: &PictureOptions, run: &Run) -> Result<Picture> {
    let color_by = match (options.coloring, &options.against) {
        (Coloring::Distance, None) => {
            let what = "distances are told from the surface of a part: say which one the mesh should be of";
            return Err(Error::Usage(what.into()));
        }
        (Coloring::Distance, Some(surface)) => ColorBy::Distance(surface.distances(mesh, run)?),
        (_, Some(_)) => return Err(Error::Usage("a part to measure against is for the color distance alone".into())),
        (Coloring::Face, None) => ColorBy::Face,
        (Coloring::Angle, None) => ColorBy::Angle,
        (Coloring::Edge, None) => ColorBy::Edge,
        (Coloring::Class, None) => ColorBy::Class(node_classes(mesh, run)?),
    };
    render(mesh, &RenderOptions { color_by, ..options.render.clone() }, run)
}

/// Refuses names of pictures that promise another format than PNG.
///
/// # Errors
/// [`Error::Usage`] for another extension than `png`.
pub fn check_picture_name(path: &Path) -> Result<()> {
    match path.extension() {
        Some(e) if !e.eq_ignore_ascii_case("png") => {
            Err(Error::Usage(format!("pictures are PNG files: {} should end in .png", path.display())))
        }
        _ => Ok(()),
    }
}

/// Writes a picture as a PNG file, whole or not at all.
///
/// # Errors
/// Those of [`check_picture_name`]; [`Error::Io`] for what cannot be written.
pub fn write_picture(path: &Path, picture: &Picture) -> Result<()> {
    check_picture_name(path)?;
    let bytes = picture.png_bytes()?;
    write_atomic(path, |out| out.write_all(&bytes).map_err(|e| Error::io("write", path, e)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::implicit::part::parse;
    use crate::pipeline::{MeshOptions, SizeRequest, mesh_part};

    fn ball_mesh() -> (Part, TriMesh) {
        let part = parse("part(sphere(1).name(\"ball\"))", &[]).unwrap();
        let how = MeshOptions { size: Some(SizeRequest::Length(0.4)), ..MeshOptions::default() };
        let mesh = mesh_part(&part, &how, &Run::new()).unwrap().mesh;
        (part, mesh)
    }

    #[test]
    fn options_are_said_by_name() {
        let mut o = PictureOptions::default();
        for (name, value) in [
            ("focus", "0, 0, 1, 2"),
            ("view", "top"),
            ("clip", "x=0"),
            ("clip", "y=1,above"),
            ("color", "angle"),
            ("edges", "none"),
            ("pixels", "64x32"),
            ("transparent", "true"),
            ("legend", "false"),
        ] {
            o.set(name, value).unwrap();
        }
        assert_eq!(o.render.view.focus, Some((DVec3::Z, 2.0)));
        assert_eq!(o.render.view.towards, DVec3::Z);
        assert_eq!((o.render.clips.len(), o.coloring), (2, Coloring::Angle));
        assert_eq!((o.render.wireframe, o.render.sharp_angle), (Some(false), None));
        assert_eq!([o.render.width, o.render.height], [64, 32]);
        assert!(o.render.transparent && !o.render.legend);
        for (name, value) in [
            ("zoom", "2"),
            ("view", "up"),
            ("focus", "0,0,0"),
            ("focus", "0,0,0,-1"),
            ("clip", "w=1"),
            ("color", "blue"),
            ("edges", "some"),
            ("pixels", "8x8"),
            ("legend", "maybe"),
        ] {
            assert!(matches!(o.set(name, value), Err(Error::Usage(_))), "{name} {value}");
        }
    }

    #[test]
    fn a_ball_fills_what_the_view_gives_it() {
        let (part, mesh) = ball_mesh();
        let mut o = PictureOptions::default();
        for (name, value) in [
            ("pixels", "100x100"),
            ("transparent", "true"),
            ("legend", "false"),
            ("focus", "0,0,0,2"),
            ("edges", "none"),
        ] {
            o.set(name, value).unwrap();
        }
        let run = Run::new();
        let covered = |p: &Picture| p.alpha.as_ref().unwrap().iter().map(|a| f64::from(*a) / 255.0).sum::<f64>();
        // A ball of half the radius of the one in focus, which fills all but the margins of 5 pixels: a circle of radius 22.5.
        let wanted = std::f64::consts::PI * 22.5f64.powi(2);
        let whole = covered(&picture(&mesh, &o, &run).unwrap());
        assert!((whole / wanted - 1.0).abs() < 0.05, "{whole} of {wanted}");
        o.set("view", "front").unwrap();
        o.set("clip", "x=0,above").unwrap();
        let half = covered(&picture(&mesh, &o, &run).unwrap());
        assert!((half / wanted - 0.5).abs() < 0.03, "{half} of {wanted}");
        o.set("color", "distance").unwrap();
        assert!(matches!(picture(&mesh, &o, &run), Err(Error::Usage(_))));
        o.against = Some(TrueSurface::Part(Box::new(part)));
        let far = picture(&mesh, &o, &run).unwrap();
        o.set("color", "face").unwrap();
        assert!(matches!(picture(&mesh, &o, &run), Err(Error::Usage(_))));
        o.against = None;
        assert_ne!(far.rgb, picture(&mesh, &o, &run).unwrap().rgb);
    }
}
