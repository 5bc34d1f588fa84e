//! The plan: all that a brick is a function of.

use std::path::{Path, PathBuf};

use glam::DVec3;
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use super::super::cells::ARRANGED;
use super::super::groups::check_groups;
use super::super::load::{parse_part, part_text};
use super::super::mesh::Ready;
use super::super::method::Method;
use super::super::options::MeshOptions;
use super::blocks::BrickLayout;
use crate::error::{Error, Place, Result};
use crate::implicit::part::Part;
use crate::implicit::{cells_along, origin, undecided_in};
use crate::io::write_atomic;
use crate::run::Run;
use crate::sizing::SizeRequest;

/// The file a plan is kept in.
const PLAN: &str = "plan.json";

/// The version of the layout of a plan and of pieces. It grows when either changes.
const LAYOUT: u32 = 2;

/// A brick is no narrower than this many cells, of two edges each: what is handed on reaches three edges of ragged wall and four
/// more, which must be less than the six cells to the next round's walls.
const NARROWEST: u32 = 12;

/// What of the options of a mesh a plan knows.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PlanOptions {
    /// Wanted edge length, in the part's unit.
    pub size: f64,
    /// See [`MeshOptions::angle`].
    pub angle: Option<f64>,
    /// See [`MeshOptions::tolerance`].
    pub tolerance: Option<f64>,
    /// See [`MeshOptions::grading`].
    pub grading: Option<f64>,
    /// See [`MeshOptions::least`].
    pub least: Option<f64>,
    /// See [`MeshOptions::memory`]; for each brick.
    pub memory: u64,
}

/// What every brick of a mesh is a function of: the part's text, what is wanted, one grid, and how it is cut.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct BrickPlan {
    /// The version of this layout.
    layout: u32,
    /// The version of the program that made it: no other may work on it.
    version: String,
    /// The name of the part's file; its ending tells the language.
    name: PathBuf,
    /// The part's text, so that a change of the file changes nothing here.
    text: String,
    /// Numbers that override the text's.
    overrides: Vec<(String, f64)>,
    /// What is wanted.
    pub options: PlanOptions,
    /// The corner of the first cell of the grid.
    origin: [f64; 3],
    /// The side of a cell.
    cell: f64,
    /// Cells along each axis.
    cells: [u32; 3],
    /// Bricks along each axis.
    bricks: [u32; 3],
    /// For each brick of the first round how many regions of 8 by 8 by 8 cells may hold some of the surface: what it costs, about.
    pub costs: Vec<u32>,
}

impl BrickPlan {
    /// A plan for a part, with so many bricks along each axis at most.
    ///
    /// Errors: those of reading the part; a part that is not one solid of R-functions; options that bricks do not heed.
    pub fn new(source: PlanSource, options: &MeshOptions, bricks: [u32; 3], run: &Run) -> Result<Self> {
        let path = source.path.clone();
        Self::of(source, options, bricks, run).map_err(|e| e.in_file(path))
    }

    fn of(source: PlanSource, options: &MeshOptions, bricks: [u32; 3], run: &Run) -> Result<Self> {
        if !options.refinements.is_empty() || options.thickness.is_some() || options.trim.is_some() {
            return Err(Error::Usage("bricks heed no --refine, --thickness and --trim".into()));
        }
        if options.method != Method::default() || options.sequence.is_some() {
            return Err(Error::Usage("bricks are made by the method leaf, without a sequence".into()));
        }
        let PlanSource { path, text, overrides } = source;
        let part = parse_part(&path, &text, &overrides)?;
        let ready = ready_of(&part, options.size)?;
        check_groups(&part, ready.model.faces().iter().map(|f| &f.name[..]))?;
        let cell = ARRANGED * ready.size;
        let bounds = ready.model.bounds();
        let cells = cells_along(&bounds, cell);
        let bricks = std::array::from_fn(|k| bricks[k].clamp(1, (cells[k] / NARROWEST).max(1)));
        let blocks = BrickLayout { origin: origin(&bounds, cell), cell, cells, bricks };
        let regions = undecided_in(&ready.model, cell, options.memory, run)?;
        let mut costs = vec![0; blocks.count(0) as usize];
        regions.into_iter().for_each(|p| costs[blocks.holding(0, p) as usize] += 1);
        options.for_any_solid()?;
        let options = MeshOptions { least: options.least.or(part.mesh.least), ..options.clone() };
        let options = options.resolved(bounds.diagonal());
        let (tolerance, least) = (options.tolerance_length(), options.least_length());
        let MeshOptions { angle, grading, memory, .. } = options;
        Ok(Self {
            layout: LAYOUT,
            version: env!("CARGO_PKG_VERSION").into(),
            name: PathBuf::from(path.file_name().unwrap_or_default()),
            text,
            overrides,
            options: PlanOptions { size: ready.size, angle, tolerance, grading, least, memory },
            origin: blocks.origin.to_array(),
            cell,
            cells,
            bricks,
            costs,
        })
    }

    /// The plan as text, and back by [`parse`](Self::parse).
    pub fn to_json(&self) -> Result<String> {
        serde_json::to_string_pretty(self).map_err(|e| Error::Failed(format!("cannot write JSON: {e}")))
    }

    /// A plan from its text.
    ///
    /// Errors: damage, a plan of another version of this program.
    pub fn parse(text: &str) -> Result<Self> {
        let bad = |what: String| Error::input(Place::Unknown, what);
        let plan: Self = serde_json::from_str(text).map_err(|e| bad(format!("this is no plan: {e}")))?;
        let version = env!("CARGO_PKG_VERSION");
        if plan.layout != LAYOUT || plan.version != version {
            return Err(bad(format!("a plan of version {}, this is {version}: make it anew", plan.version)));
        }
        let sizes = plan.cells.iter().zip(&plan.bricks).all(|(c, b)| *b >= 1 && *c >= *b && *c < 1 << 20);
        if !sizes || plan.costs.len() != plan.blocks().count(0) as usize || !(plan.cell > 0.0) {
            return Err(bad("the numbers of bricks and cells do not fit together".into()));
        }
        Ok(plan)
    }

    /// How many bricks each round has: of the plain grid, shifted by half, and by a quarter.
    pub fn rounds(&self) -> [u32; super::ROUNDS] {
        std::array::from_fn(|r| self.blocks().count(r))
    }

    /// Bricks along each axis in the first round.
    pub fn bricks(&self) -> [u32; 3] {
        self.bricks
    }

    /// What tells this plan from all others: its digest by SHA-256.
    pub fn digest(&self) -> [u8; 32] {
        Sha256::digest(serde_json::to_vec(self).unwrap_or_default()).into()
    }

    /// Writes the plan into a folder, which is made if it is missing. Another plan there is an error: its pieces would not fit.
    pub fn save(&self, folder: &Path) -> Result<()> {
        std::fs::create_dir_all(folder).map_err(|e| Error::io("create", folder, e))?;
        let path = folder.join(PLAN);
        if path.exists() && Self::load(folder)? != *self {
            return Err(Error::Usage(format!("{} holds another plan: choose another folder", folder.display())));
        }
        let text = self.to_json()?;
        write_atomic(&path, |out| out.write_all(text.as_bytes()).map_err(|e| Error::io("write", &path, e)))
    }

    /// Reads the plan of a folder.
    ///
    /// Errors: no such file, damage, a plan of another version of this program.
    pub fn load(folder: &Path) -> Result<Self> {
        let path = folder.join(PLAN);
        let text = std::fs::read_to_string(&path).map_err(|e| Error::io("read", &path, e))?;
        Self::parse(&text).map_err(|e| e.in_file(&path))
    }

    pub(super) fn blocks(&self) -> BrickLayout {
        let Self { cell, cells, bricks, .. } = *self;
        BrickLayout { origin: DVec3::from_array(self.origin), cell, cells, bricks }
    }

    pub(super) fn cell(&self) -> f64 {
        self.cell
    }

    pub(super) fn part(&self) -> Result<Part> {
        parse_part(&self.name, &self.text, &self.overrides)
    }

    /// The part made ready for meshing.
    pub(super) fn ready(&self, part: &Part) -> Result<Ready> {
        let ready = ready_of(part, Some(SizeRequest::Length(self.options.size)))?;
        let here = origin(&ready.model.bounds(), self.cell);
        if here.to_array() != self.origin || cells_along(&ready.model.bounds(), self.cell) != self.cells {
            let what = "the part's bounds are not those of the plan: it was made by another program";
            return Err(Error::input(Place::Unknown, what));
        }
        Ok(ready)
    }

    pub(super) fn mesh_options(&self) -> MeshOptions {
        let PlanOptions { size, angle, tolerance, grading, least, memory } = self.options;
        let size = Some(SizeRequest::Length(size));
        let (tolerance, least) = (tolerance.map(SizeRequest::Length), least.map(SizeRequest::Length));
        MeshOptions { size, angle, tolerance, grading, least, memory, ..MeshOptions::default() }
    }
}

/// The text of a part, which a plan holds.
#[derive(Debug, Clone, PartialEq)]
pub struct PlanSource {
    /// The file; its ending tells the language, and errors name it.
    pub path: PathBuf,
    /// What is in it.
    pub text: String,
    /// Numbers that override the text's.
    pub overrides: Vec<(String, f64)>,
}

impl PlanSource {
    /// Reads a file.
    pub fn read(path: &Path, overrides: &[(String, f64)]) -> Result<Self> {
        Ok(Self { path: path.into(), text: part_text(path)?, overrides: overrides.to_vec() })
    }
}

fn ready_of(part: &Part, size: Option<SizeRequest>) -> Result<Ready> {
    if !part.built.is_empty() {
        return Err(Error::input(
            Place::Unknown,
            "bricks are for solids of R-functions, not for those built from edges",
        ));
    }
    Ready::new(part, size)
}
