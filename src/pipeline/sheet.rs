//! Pictures of comparisons: every stage or sample drawn alike, one beside the other.

use std::path::{Path, PathBuf};

use super::compare::{Comparison, Row, node_classes};
use super::method::Method;
use super::picture::{Coloring, check_picture_name, write_picture};
use super::samples::{Sample, SampleComparison, SampleRow};
use crate::error::{Error, Result};
use crate::mesh::TriMesh;
use crate::render::{ColorBy, Picture, RenderOptions, View, render, sheet};
use crate::run::Run;

/// Pictures of a comparison stand in rows of this many.
const COLUMNS: usize = 6;

/// Width and height of one picture of a comparison.
const CELL: [usize; 2] = [420, 360];

/// The radius of what a picture of a comparison shows, in cells: near enough to see single triangles.
const FOCUS: f64 = 9.0;

/// Width and height of one picture of a sample: the longest caption has 46 characters, 12 pixels each.
const SAMPLE_CELL: [usize; 2] = [560, 520];

/// A picture of a comparison, as `rvachev compare --png` writes it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PictureSheet {
    path: PathBuf,
    color: Coloring,
}

impl PictureSheet {
    /// A picture for a file, whose colors tell angles unless another color is said.
    ///
    /// # Errors
    /// [`Error::Usage`] for another color than angle and class, and for another extension than `png`.
    pub fn new(path: &Path, color: Option<Coloring>) -> Result<Self> {
        check_picture_name(path)?;
        let color = color.unwrap_or(Coloring::Angle);
        if !matches!(color, Coloring::Angle | Coloring::Class) {
            return Err(Error::Usage("the color of a comparison is angle or class".into()));
        }
        Ok(PictureSheet { path: path.to_path_buf(), color })
    }

    /// Draws all stages of all methods near one place, and writes the file.
    ///
    /// # Errors
    /// [`Error::Io`] for what cannot be written; those of [`render`].
    pub fn stages(&self, c: &Comparison, run: &Run) -> Result<()> {
        let view = View { focus: c.focus.map(|p| (p, FOCUS * c.size)), margin: 0.0, ..View::default() };
        let cell = |row: &Row| Ok((format!("{}: {}", row.method, row.stage), self.drawn(&row.mesh, CELL, view, run)?));
        self.written(&c.rows.iter().map(cell).collect::<Result<Vec<_>>>()?, COLUMNS)
    }

    /// Draws a row of pictures for each sample, with a column for each method, and writes the file.
    ///
    /// # Errors
    /// As [`Self::stages`].
    pub fn samples(&self, c: &SampleComparison, run: &Run) -> Result<()> {
        let cell = |row: &SampleRow| {
            let found = row.check.features.as_ref().map_or_else(String::new, |f| {
                format!(", recall {:.3}, {}/{} corners", f.recall, f.corners_found, f.corners_true)
            });
            let caption = format!("{}: {}{found}", row.sample, row.method);
            let sample = Sample::ALL.into_iter().find(|s| s.name == row.sample);
            let view = sample.map_or_else(View::default, |s| View::from_angles(s.view[0], s.view[1]));
            Ok((caption, self.drawn(&row.mesh, SAMPLE_CELL, view, run)?))
        };
        self.written(&c.rows.iter().map(cell).collect::<Result<Vec<_>>>()?, Method::ALL.len())
    }

    fn written(&self, cells: &[(String, Picture)], columns: usize) -> Result<()> {
        write_picture(&self.path, &sheet(cells, columns))
    }

    fn drawn(&self, mesh: &TriMesh, cell: [usize; 2], view: View, run: &Run) -> Result<Picture> {
        let color_by = match self.color {
            Coloring::Class => match node_classes(mesh, run) {
                // A stage may leave a mesh that is no manifold, whose nodes have no classes.
                Err(Error::Input { .. }) => ColorBy::Class(vec![0; mesh.nodes.len()]),
                classes => ColorBy::Class(classes?),
            },
            _ => ColorBy::Angle,
        };
        let [width, height] = cell;
        render(mesh, &RenderOptions { width, height, view, color_by, legend: false, ..RenderOptions::default() }, run)
    }
}
