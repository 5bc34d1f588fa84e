//! Options of meshing, by the names the command has for them.

use std::ffi::c_int;
use std::path::PathBuf;
use std::str::FromStr;
use std::sync::{Mutex, PoisonError};

use rvachev::Error;
use rvachev::io::Grouping;
use rvachev::pipeline::{
    Coloring, GridOptions, GridSpacing, HealOptions, MeshOptions, Method, PictureOptions, PictureSheet, SizeRequest,
    SoupOptions,
};

use crate::errors::{ErrorOut, Failure, GOOD, entry, given, release, slot, usage};
use crate::pass::{Chars, Out};
use crate::work::RvRun;

/// All options there are.
/// Those of pictures but `against` are [`PictureOptions::NAMES`].
const NAMES: [&str; 33] = [
    "size",
    "method",
    "sequence",
    "angle",
    "tol",
    "volume",
    "grading",
    "size-min",
    "trim",
    "without",
    "thickness",
    "refine",
    "eps",
    "memory",
    "measure",
    "feature-angle",
    "min-area",
    "min-length",
    "nodes",
    "close",
    "max-hole",
    "cells",
    "step",
    "margin",
    "gradient",
    "within",
    "groups",
    "msh-version",
    "threads",
    "force",
    "define",
    "against",
    "png",
];

/// Threads, at most.
const MOST_THREADS: usize = 1024;

/// What a caller asked for.
#[derive(Clone)]
pub struct Asked {
    /// Of every gate.
    pub mesh: MeshOptions,
    /// Of soups.
    pub soup: SoupOptions,
    /// Of healing.
    pub heal: HealOptions,
    /// Of grids; the memory is that of meshing.
    grid: GridOptions,
    /// Up to which distance nodes of different meshes are one.
    pub within: SizeRequest,
    /// The method that was said.
    pub method: Option<Method>,
    /// Threads; 0 for as many as there are cores.
    pub threads: usize,
    /// A mesh that is not sound is given all the same.
    pub force: bool,
    /// Numbers of a part file to be replaced.
    pub define: Vec<(String, f64)>,
    /// Which sets files are given.
    pub groups: Grouping,
    /// gmsh files as version 2.2.
    pub old_msh: bool,
    /// Of pictures.
    pub picture: PictureOptions,
    /// The file whose surface a mesh should be of.
    pub against: Option<PathBuf>,
    /// The file a comparison is drawn into.
    png: Option<PathBuf>,
    /// The color that was said.
    color: Option<Coloring>,
    /// What cancels and watches.
    pub run: Option<RvRun>,
}

impl Default for Asked {
    fn default() -> Self {
        Asked {
            mesh: MeshOptions { timed: true, ..MeshOptions::default() },
            soup: SoupOptions::default(),
            heal: HealOptions::default(),
            grid: GridOptions::default(),
            // Some ten times what single precision leaves of a coordinate, as for the command.
            within: SizeRequest::Share(1e-6),
            method: None,
            threads: 0,
            force: false,
            define: Vec::new(),
            groups: Grouping::default(),
            old_msh: false,
            picture: PictureOptions::default(),
            against: None,
            png: None,
            color: None,
            run: None,
        }
    }
}

/// Options, as a handle.
#[derive(Default)]
pub struct RvOptions(Mutex<Asked>);

/// What the options say at the moment; the defaults for NULL.
pub fn asked(options: Option<&RvOptions>) -> Asked {
    options.map_or_else(Asked::default, |o| o.0.lock().unwrap_or_else(PoisonError::into_inner).clone())
}

fn number<T: FromStr>(v: &str, name: &str, what: &str) -> Result<T, Failure> {
    v.trim().parse().map_err(|_| usage(format!("{name} must be {what}, not {v:?}")))
}

fn positive(v: &str, name: &str) -> Result<f64, Failure> {
    let x: f64 = number(v, name, "a positive number")?;
    if x > 0.0 && x.is_finite() { Ok(x) } else { Err(usage(format!("{name} must be a positive number, not {v:?}"))) }
}

fn share(v: &str, name: &str) -> Result<f64, Failure> {
    let x = positive(v, name)?;
    if x < 1.0 { Ok(x) } else { Err(usage(format!("{name} must be below 1, not {v:?}"))) }
}

/// A length or a share, which may be 0.
fn width(v: &str) -> Result<SizeRequest, Failure> {
    Ok(if v.trim() == "0" { SizeRequest::Length(0.0) } else { v.parse()? })
}

fn not_negative(v: &str, name: &str) -> Result<f64, Failure> {
    let x: f64 = number(v, name, "a number")?;
    if x >= 0.0 && x.is_finite() { Ok(x) } else { Err(usage(format!("{name} must not be negative, not {v:?}"))) }
}

fn switch(v: &str, name: &str) -> Result<bool, Failure> {
    match v.trim() {
        "1" | "true" | "yes" | "on" => Ok(true),
        "0" | "false" | "no" | "off" => Ok(false),
        other => Err(usage(format!("{name} is \"true\" or \"false\", not {other:?}"))),
    }
}

impl Asked {
    /// The options of grids.
    pub fn for_grid(&self) -> GridOptions {
        GridOptions { memory: self.mesh.memory, ..self.grid }
    }

    /// The picture of a comparison, if one is wanted.
    pub fn sheet(&self) -> Result<Option<PictureSheet>, Failure> {
        Ok(self.png.as_ref().map(|path| PictureSheet::new(path, self.color)).transpose()?)
    }

    fn set(&mut self, name: &str, v: &str) -> Result<(), Failure> {
        let known = name.replace('_', "-");
        let known = known.trim_start_matches('-');
        let whole = "a whole number";
        let m = &mut self.mesh;
        match known {
            "size" => m.size = Some(v.parse()?),
            "method" => {
                m.method = v.trim().parse()?;
                self.method = Some(m.method);
            }
            "sequence" => m.sequence = Some(v.parse().map_err(|e: Error| usage(format!("sequence: {e}")))?),
            "angle" => m.angle = Some(positive(v, known)?),
            "tol" => m.tolerance = Some(v.parse()?),
            "volume" => m.volume = Some(share(v, known)?),
            "grading" => m.grading = Some(positive(v, known)?),
            "size-min" => m.least = Some(v.parse()?),
            "trim" => m.trim = Some(width(v)?),
            "without" => m.without.push(v.parse().map_err(|e: Error| usage(e.to_string()))?),
            "thickness" => m.thickness = Some(positive(v, known)?),
            "refine" => m.refinements.push(v.parse()?),
            "eps" => m.root_tolerance = share(v, known)?,
            "memory" => m.memory = (positive(v, known)? * (1u64 << 30) as f64) as u64,
            "measure" => m.measure = switch(v, known)?,
            "feature-angle" => self.soup.feature_angle = positive(v, known)?,
            "min-area" => self.soup.min_area = not_negative(v, known)?,
            "min-length" => self.soup.min_length = Some(not_negative(v, known)?),
            "nodes" => self.soup.nodes = Some(number(v, known, whole)?),
            "close" => self.soup.close = switch(v, known)?,
            "max-hole" => self.heal.max_hole = Some(number(v, known, whole)?),
            "cells" => {
                let n = Some(number(v, known, whole)?).filter(|n| *n > 0);
                self.grid.spacing = GridSpacing::Cells(n.ok_or_else(|| usage("cells must be at least 1"))?);
            }
            "step" => self.grid.spacing = GridSpacing::Step(positive(v, known)?),
            "margin" => self.grid.margin = width(v)?,
            "gradient" => self.grid.gradients = switch(v, known)?,
            "within" => self.within = width(v)?,
            "groups" => self.groups = v.trim().parse().map_err(usage)?,
            "msh-version" => {
                self.old_msh = match v.trim() {
                    "4.1" => false,
                    "2.2" => true,
                    other => return Err(usage(format!("msh-version is \"4.1\" or \"2.2\", not {other:?}"))),
                }
            }
            "threads" => {
                self.threads = Some(number(v, known, whole)?)
                    .filter(|n| *n <= MOST_THREADS)
                    .ok_or_else(|| usage(format!("threads must be at most {MOST_THREADS}, not {v:?}")))?;
            }
            "force" => self.force = switch(v, known)?,
            "define" => {
                let wrong = || usage(format!("define is NAME=VALUE, not {v:?}"));
                let (name, value) = v.split_once('=').ok_or_else(wrong)?;
                self.define.push((name.trim().to_string(), value.trim().parse().map_err(|_| wrong())?));
            }
            "against" => self.against = Some(PathBuf::from(v)),
            "png" => self.png = Some(PathBuf::from(v)),
            _ if PictureOptions::NAMES.contains(&known) => {
                self.picture.set(known, v)?;
                if known == "color" {
                    self.color = Some(self.picture.coloring);
                }
            }
            _ => {
                let all = [&NAMES[..], &PictureOptions::NAMES].concat().join(", ");
                return Err(usage(format!("there is no option {name:?}; there are: {all}")));
            }
        }
        Ok(())
    }
}

/// Makes options, none of them said yet.
#[unsafe(no_mangle)]
pub extern "C" fn rv_options_new(options: Out<'_, *mut RvOptions>, error: ErrorOut<'_>) -> c_int {
    entry(error, || {
        slot(options, std::ptr::null_mut(), "options")?.write(Box::into_raw(Box::default()));
        Ok(GOOD)
    })
}

/// Says one option.
#[unsafe(no_mangle)]
pub extern "C" fn rv_options_set(options: Option<&RvOptions>, name: Chars, value: Chars, error: ErrorOut<'_>) -> c_int {
    entry(error, || {
        let options = given(options, "options")?;
        let (name, value) = (name.text("name")?, value.text("value")?);
        options.0.lock().unwrap_or_else(PoisonError::into_inner).set(name, value)?;
        Ok(GOOD)
    })
}

/// Says which handle cancels and watches; none for NULL.
#[unsafe(no_mangle)]
pub extern "C" fn rv_options_set_run(options: Option<&RvOptions>, run: Option<&RvRun>, error: ErrorOut<'_>) -> c_int {
    entry(error, || {
        let options = given(options, "options")?;
        options.0.lock().unwrap_or_else(PoisonError::into_inner).run = run.cloned();
        Ok(GOOD)
    })
}

/// Frees options.
#[unsafe(no_mangle)]
pub extern "C" fn rv_options_free(options: Option<Box<RvOptions>>) {
    release(options);
}
