//! Options of meshing, by name.

use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyString};
use rvachev::pipeline::{HealOptions, MeshOptions, Method, SizeRequest, SoupOptions};

use crate::errors::{input, raise};
use crate::work::Listeners;

/// All options there are.
const NAMES: [&str; 26] = [
    "size",
    "method",
    "sequence",
    "angle",
    "tol",
    "volume",
    "grading",
    "size_min",
    "trim",
    "without",
    "thickness",
    "refine",
    "eps",
    "memory",
    "measure",
    "feature_angle",
    "min_area",
    "min_length",
    "nodes",
    "close",
    "max_hole",
    "progress",
    "cancel",
    "threads",
    "force",
    "define",
];

/// What a caller asked for.
#[derive(Default)]
pub struct Options {
    /// Of every gate.
    pub mesh: MeshOptions,
    /// Of soups.
    pub soup: SoupOptions,
    /// Of healing.
    pub heal: HealOptions,
    /// The method that was said.
    pub method: Option<Method>,
    /// Of the run.
    pub listeners: Listeners,
    /// A mesh that is not sound is given all the same.
    pub force: bool,
    /// Numbers of a part file to be replaced.
    pub define: Vec<(String, f64)>,
}

/// A length, or a share such as "2%".
pub fn size(v: &Bound<'_, PyAny>) -> PyResult<SizeRequest> {
    length(v, "size")
}

fn length(v: &Bound<'_, PyAny>, name: &str) -> PyResult<SizeRequest> {
    if let Ok(s) = v.cast::<PyString>() {
        return s.to_str()?.parse().map_err(|e| raise(v.py(), &e));
    }
    Ok(SizeRequest::Length(positive(v, name)?))
}

/// A share below 1.
fn share(v: &Bound<'_, PyAny>, name: &str) -> PyResult<f64> {
    let x = positive(v, name)?;
    if x < 1.0 { Ok(x) } else { Err(raise(v.py(), &input(format!("{name} must be below 1, not {x}"), ""))) }
}

/// One text, or a list of them.
fn texts(v: &Bound<'_, PyAny>) -> PyResult<Vec<String>> {
    if v.is_instance_of::<PyString>() { Ok(vec![v.extract()?]) } else { v.extract() }
}

/// A positive number.
pub fn positive(v: &Bound<'_, PyAny>, name: &str) -> PyResult<f64> {
    let x: f64 = v.extract()?;
    if x > 0.0 && x.is_finite() {
        return Ok(x);
    }
    Err(raise(v.py(), &input(format!("{name} must be a positive number, not {x}"), "")))
}

impl Options {
    /// Reads options; those with the value `None` are not said. `allowed` narrows what makes sense.
    pub fn new(options: Option<&Bound<'_, PyDict>>, allowed: &[&str]) -> PyResult<Self> {
        let mut out = Options { mesh: MeshOptions { timed: true, ..MeshOptions::default() }, ..Options::default() };
        for (name, v) in options.into_iter().flat_map(|o| o.iter()) {
            let name: String = name.extract()?;
            if !NAMES.contains(&name.as_str()) || !(allowed.is_empty() || allowed.contains(&name.as_str())) {
                let known = if allowed.is_empty() { &NAMES[..] } else { allowed };
                return Err(PyTypeError::new_err(format!(
                    "there is no option {name:?}; there are: {}",
                    known.join(", ")
                )));
            }
            if !v.is_none() {
                out.set(&name, &v)?;
            }
        }
        Ok(out)
    }

    fn set(&mut self, name: &str, v: &Bound<'_, PyAny>) -> PyResult<()> {
        let py = v.py();
        let m = &mut self.mesh;
        match name {
            "size" => m.size = Some(size(v)?),
            "method" => {
                m.method = v.extract::<String>()?.parse().map_err(|e| raise(py, &e))?;
                self.method = Some(m.method);
            }
            "sequence" => m.sequence = Some(v.extract::<String>()?.parse().map_err(|e| raise(py, &e))?),
            "angle" => m.angle = Some(positive(v, name)?),
            "tol" => m.tolerance = Some(length(v, name)?),
            "volume" => m.volume = Some(share(v, name)?),
            "without" => {
                let list = texts(v)?.iter().map(|s| s.parse()).collect::<rvachev::Result<Vec<_>>>();
                m.without = list.map_err(|e| raise(py, &e))?;
            }
            "grading" => m.grading = Some(positive(v, name)?),
            "size_min" => m.least = Some(length(v, name)?),
            "trim" => {
                let none = v.extract::<f64>().is_ok_and(|x| x == 0.0);
                m.trim = Some(if none { SizeRequest::Length(0.0) } else { length(v, name)? });
            }
            "thickness" => m.thickness = Some(positive(v, name)?),
            "refine" => {
                let list = texts(v)?.iter().map(|s| s.parse()).collect::<rvachev::Result<Vec<_>>>();
                m.refinements = list.map_err(|e| raise(py, &e))?;
            }
            "eps" => m.root_tolerance = positive(v, name)?,
            "memory" => m.memory = (positive(v, name)? * (1u64 << 30) as f64) as u64,
            "measure" => m.measure = v.extract()?,
            "feature_angle" => self.soup.feature_angle = positive(v, name)?,
            "min_area" => self.soup.min_area = v.extract()?,
            "min_length" => self.soup.min_length = Some(v.extract()?),
            "nodes" => self.soup.nodes = Some(v.extract()?),
            "close" => self.soup.close = v.extract()?,
            "max_hole" => self.heal.max_hole = Some(v.extract()?),
            "progress" => {
                if !v.is_callable() && !v.is_instance_of::<pyo3::types::PyBool>() {
                    return Err(PyTypeError::new_err("progress is True, or a function of a name and a share"));
                }
                self.listeners.progress = Some(v.clone().unbind());
            }
            "cancel" => self.listeners.cancel = Some(v.clone().unbind()),
            "threads" => self.listeners.threads = v.extract()?,
            "force" => self.force = v.extract()?,
            "define" => {
                self.define = v
                    .cast::<PyDict>()?
                    .iter()
                    .map(|(k, v)| Ok((k.extract()?, v.extract()?)))
                    .collect::<PyResult<_>>()?
            }
            other => return Err(PyValueError::new_err(format!("no option {other}"))),
        }
        Ok(())
    }
}
