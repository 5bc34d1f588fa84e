//! **rvachev** turns solids into triangle surface meshes an engineer can compute on: closed, oriented, free of
//! self-intersections by exact predicates, with a named face for every triangle and a report that says what is known.
//!
//! Three gates lead in.
//!
//! # Solids of R-functions
//!
//! A [`Solid`] is a tree of primitives, formulas, closures and set operations, which V. L. Rvachev's functions make one
//! function of: inside is `f > 0`. Edges between the leaves of the tree are exact.
//!
//! ```
//! use rvachev::{DVec3, MeshOptions, Part, Run, SizeRequest, Solid, mesh_part};
//!
//! let cube = Solid::cuboid(DVec3::splat(-1.0), DVec3::splat(1.0)).name("cube");
//! let dent = Solid::field(|p: DVec3| 0.8 - p.distance(DVec3::ONE)).name("dent");
//! let options = MeshOptions { size: Some(SizeRequest::Length(0.2)), ..MeshOptions::default() };
//! let made = mesh_part(&Part::from_solid(cube - dent), &options, &Run::new())?;
//!
//! assert!(made.report.shortfalls.is_empty());
//! // A cube of side 2 without an eighth of a ball.
//! let volume = 8.0 - std::f64::consts::PI / 6.0 * 0.8f64.powi(3);
//! assert!((made.mesh.volume() - volume).abs() < 0.002 * volume);
//! assert!(made.mesh.faces.iter().any(|name| name == "dent"));
//! # Ok::<(), rvachev::Error>(())
//! ```
//!
//! The same as a text, in the language of part files (`docs/parts.md`); [`load_part`] reads it from a file.
//!
//! ```
//! use std::path::Path;
//! use rvachev::{Run, MeshOptions, expected_triangles, mesh_part, parse_part};
//!
//! let text = "r = 3\nplate = box(lo=(0, 0, 0), hi=(30, 20, 4)).name('plate')\n\
//!     bore = cylinder(r, at=(10, 10, 0)).name('bore')\npart(plate - bore)\ngroup('load', faces('bore'))\nmesh(size=2)\n";
//! let part = parse_part(Path::new("plate.py"), text, &[("r".into(), 4.0)])?;
//! let made = mesh_part(&part, &MeshOptions::default(), &Run::new())?;
//! let load = &made.mesh.groups[0];
//! let wall: f64 = (0..made.mesh.triangles.len())
//!     .filter(|t| load.faces.contains(&made.mesh.labels[*t]))
//!     .map(|t| made.mesh.area_vector(t).length() / 2.0)
//!     .sum();
//! assert!((wall - std::f64::consts::TAU * 4.0 * 4.0).abs() < 1.0);
//! # Ok::<(), rvachev::Error>(())
//! ```
//!
//! # CAD models
//!
//! [`load_step`] reads STEP files. A [`Wire`] extruded or revolved is such a model, too.
//!
//! ```
//! use rvachev::{DVec3, Extrusion, MeshOptions, Run, Wire, extrude_edges, mesh_step};
//!
//! let corners = [DVec3::ZERO, DVec3::new(4.0, 0.0, 0.0), DVec3::new(0.0, 3.0, 0.0)];
//! let wedge = extrude_edges(&[Wire::polygon(&corners)?], &Extrusion::new(DVec3::Z, 2.0))?;
//! let made = mesh_step(wedge.into(), &MeshOptions::default(), &Run::new())?;
//! assert!((made.mesh.volume() - 12.0).abs() < 1e-9);
//! # Ok::<(), rvachev::Error>(())
//! ```
//!
//! # Triangles
//!
//! [`load_mesh`] reads STL and other files of triangles, [`heal`] mends them, and [`mesh_soup`] makes a mesh of them whose edges are
//! where theirs are sharp. Meshes are written by [`write`](fn@write) in some twenty formats.
//!
//! ```
//! use rvachev::{MeshOptions, Run, SoupOptions, WriteOptions, load_mesh, mesh_part, mesh_soup, parse_part, write};
//!
//! let run = Run::new();
//! let part = parse_part("ball.py".as_ref(), "part(sphere(1) & half_space((0, 0, 1)))\n", &[])?;
//! let made = mesh_part(&part, &MeshOptions::default(), &run)?;
//! let path = std::env::temp_dir().join(format!("rvachev-{}.stl", std::process::id()));
//! write(&path, &made.mesh, &WriteOptions::default(), &run)?;
//!
//! let again = mesh_soup(&load_mesh(&path, &run)?, &MeshOptions::default(), &SoupOptions::default(), &run)?;
//! assert!((again.mesh.volume() - made.mesh.volume()).abs() < 0.01);
//! assert_eq!(again.mesh.faces.len(), 2);
//! # std::fs::remove_file(path).unwrap();
//! # Ok::<(), rvachev::Error>(())
//! ```
//!
//! # Ends that are not good
//!
//! Bad input is an [`Error`] with its [`Place`]. A mesh that falls short of what is promised is given all the same, and its
//! [`Report`] says in `shortfalls` how and where. A [`Run`] carries cancellation, progress and threads; results are the same, byte for
//! byte, for any number of them. The library prints nothing and keeps nothing global.
//!
//! ```
//! use rvachev::{Error, MeshOptions, Place, Run, mesh_part, parse_part};
//!
//! let name = "bolt.py".as_ref();
//! let Err(Error::Input { place: Place::Text { line, .. }, .. }) = parse_part(name, "part(\nspere(1))\n", &[]) else {
//!     panic!("there is no such primitive");
//! };
//! assert_eq!(line, 2);
//!
//! let run = Run::new();
//! run.cancel_token().cancel();
//! let part = parse_part(name, "part(sphere(1))\n", &[])?;
//! assert!(matches!(mesh_part(&part, &MeshOptions::default(), &run), Err(Error::Cancelled)));
//! # Ok::<(), Error>(())
//! ```
//!
//! # What is stable
//!
//! The names listed here keep their meaning from one minor version to the next. The rooms they come from (`rvachev::implicit`,
//! `rvachev::optimize` and so on, described in `ARCHITECTURE.md`) are public for the study of single operators, but hidden from this page:
//! they may change in any version. A room imports only rooms listed above it there, which `tests/tidy.rs` enforces.
//!
//! Conventions that hold everywhere: the outward normal is `-grad f / |grad f|`, triangles wind counter-clockwise seen from outside,
//! lengths are in the part's own unit, angles are in degrees.

#[doc(hidden)]
pub mod error;
#[doc(hidden)]
pub mod run;

#[doc(hidden)]
pub mod numeric;

#[doc(hidden)]
pub mod spatial;

#[doc(hidden)]
pub mod planar;

#[doc(hidden)]
pub mod mesh;

#[doc(hidden)]
pub mod geometry;

#[doc(hidden)]
pub mod model;

#[doc(hidden)]
pub mod quality;
#[doc(hidden)]
pub mod sizing;

#[doc(hidden)]
pub mod io;
#[doc(hidden)]
pub mod page;
#[doc(hidden)]
pub mod render;

#[doc(hidden)]
pub mod discrete;
#[doc(hidden)]
pub mod implicit;
#[doc(hidden)]
pub mod parametric;

#[doc(hidden)]
pub mod heal;

#[doc(hidden)]
pub mod merge;

#[doc(hidden)]
pub mod optimize;

#[doc(hidden)]
pub mod remesh;

#[doc(hidden)]
pub mod pipeline;

// What everything needs.
pub use error::{Error, Place, Result};
pub use glam::DVec3;
pub use run::{CancelToken, Progress, Run};
pub use spatial::Aabb;

// Solids of R-functions.
pub use implicit::{Expr, Field, Implicit, Placement, RSystem, Samples, Sampling, Solid, evaluate};
pub use pipeline::{Part, SizeRequest, function, load_part, parse_part};

// Models of curves and surfaces.
pub use parametric::brep::Brep;
pub use parametric::build::{Axis, Extrusion, Wire, extrude_edges, revolve_edges};
pub use parametric::nurbs::SplineEnds;
pub use parametric::step::{StepModel, write_step};
pub use pipeline::{BrepInfo, brep_info, load_step};

// Meshing.
pub use optimize::Sequence;
pub use pipeline::{
    Attempt, MeshOptions, Meshed, Method, Refinement, Report, SoupOptions, UnprovedPlace, expected_triangles,
    load_mesh, mesh_part, mesh_soup, mesh_step,
};

// Meshes.
pub use io::{Encoding, Format, WriteOptions, read, write};
pub use merge::{Addition, Merged};
pub use mesh::{Group, MeshView, Prisms, TriMesh};
pub use model::Cut;
pub use pipeline::{HealOptions, Healed, Joined, heal, join};

// What is known of them.
pub use pipeline::{PictureOptions, picture, write_picture};
pub use quality::{Certificate, Check, Expectation, Fault, Quality, check};

/// The snippets of the README compile and run with the documentation's tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
