//! What may be written on the command line.

use std::path::PathBuf;

use clap::{Args, Parser, Subcommand, ValueEnum};
use rvachev::DVec3;
use rvachev::io::Grouping;
use rvachev::pipeline::{Method, RSystem, Refinement, Remedy, SizeRequest};
use rvachev::render::{ClipPlane, View};

use super::gates::WrittenOptions;

/// What stands below the help: the numbers the command ends with.
const EXIT_CODES: &str = "Exit codes: 0 good, 1 the result falls short of what was asked, or what was checked is not sound, 2 usage, 3 bad input, \
     4 failed, or a mesh that is not sound was not written, 130 cancelled.";

/// Solids (R-functions) to triangle meshes one can compute on.
#[derive(Debug, Parser)]
#[command(name = "rvachev", version, about, max_term_width = 100, after_help = EXIT_CODES)]
pub struct Cli {
    #[command(subcommand)]
    pub command: Command,
}

#[derive(Debug, Subcommand)]
pub enum Command {
    /// Mesh a part
    Mesh(Mesh),
    /// Mesh a part and write a page that shows it, for a browser, or serve the page and follow the part
    View(ViewPage),
    /// Measure every stage of every method on one part, or all methods on three samples
    Compare(Compare),
    /// Measure a mesh, however it was made, or tell what is wrong with a STEP model
    Check(CheckArguments),
    /// Repair a mesh: close holes, join borders, part what intersects
    Heal(Heal),
    /// Join mesh files to one mesh where their nodes match
    Join(super::join::JoinArguments),
    /// Tell what is in a part
    Info(InfoArguments),
    /// Walk over a mesh from one point to another by the shortest way
    Path(Way),
    /// Evaluate a part's function at points: value, gradient, inside or not, the face that decides
    Eval(Eval),
    /// Sample a part's function on a regular grid, for ParaView or NumPy
    Grid(GridFile),
    /// Write solids built from edges, or read from STEP, as STEP (AP214), and solids of R-functions as a formula
    Convert(Convert),
    /// Draw a mesh
    Render(Render),
    /// Plan a mesh made brick by brick, by several processes or machines
    Plan(super::bricks::PlanArguments),
    /// Make bricks of a plan
    Brick(super::bricks::Brick),
    /// Merge the bricks of a plan to one mesh
    Merge(super::bricks::MergeArguments),
    /// Print the options in the form a shell completes them from
    Completions(super::manual::Completions),
    /// Write man pages
    Man(super::manual::Manual),
}

/// What all commands that work have in common.
#[derive(Debug, Args)]
pub struct CommonArguments {
    /// Threads to use (0: as many as there are); results never depend on it
    #[arg(long, default_value_t = 0, value_name = "N", value_parser = threads)]
    pub threads: usize,
    /// No progress, no summary
    #[arg(short, long)]
    pub quiet: bool,
}

/// A part file and its overrides.
#[derive(Debug, Args)]
pub struct PartFile {
    /// Part file (.py), formula (.vm), level sets (.3mf), OpenSCAD's tree (.csg), STEP file (.step, .stp) or, for `mesh` and `info`, mesh file such as STL
    #[arg(value_name = "PART")]
    pub part: PathBuf,
    /// Override a top-level number of the part file
    #[arg(short = 'D', value_name = "NAME=VALUE", value_parser = definition)]
    pub define: Vec<(String, f64)>,
}

/// How to mesh.
#[derive(Debug, Args)]
pub struct MeshingArguments {
    /// Cell size: a length, or a share of the diagonal such as 2%
    #[arg(long, value_name = "H", value_parser = size)]
    pub size: Option<SizeRequest>,
    /// Place nodes within this share of the diagonal of the surface
    #[arg(long, value_name = "EPS", default_value_t = 1e-12, value_parser = share)]
    pub eps: f64,
    /// On curved parts neighboring edges turn by at most this many degrees
    #[arg(long, value_name = "DEGREES", value_parser = positive)]
    pub angle: Option<f64>,
    /// No triangle farther than this from the surface: a length, or a share of the diagonal such as 0.1% [default: 0.035 of the size, at least diagonal / 5400; none with --angle alone]
    #[arg(long, value_name = "LENGTH", value_parser = size)]
    pub tol: Option<SizeRequest>,
    /// CAD models: mesh until at most this share of the volume lies between triangles and surface, such as 0.001
    #[arg(long, value_name = "SHARE", value_parser = share)]
    pub volume: Option<f64>,
    /// How fast edge lengths may grow per length [default: 0.2, more for STEP where details crowd, 0.3 for triangles that turn by more than 5 degrees from one to the next]
    #[arg(long, value_name = "SLOPE", value_parser = positive)]
    pub grading: Option<f64>,
    /// Curvature, narrow gaps and thin walls make no edges shorter than this: a length, or a share of the diagonal such as 0.2% [default: a quarter of the size, less where an R-function part has smaller features; a 40th for gaps and short edges]
    #[arg(long, value_name = "LENGTH", value_parser = size)]
    pub size_min: Option<SizeRequest>,
    /// CAD models: cut off regions of faces narrower than this length or share of the diagonal; 0 leaves all [default: size / 40, for
    /// the edges of thin walls size / 160, at most half of --tol]
    #[arg(long, value_name = "WIDTH", value_parser = width)]
    pub trim: Option<SizeRequest>,
    /// CAD models: leave out a remedy for troubles of faces, for study: halving (of edges whose contours cross), least-length (in
    /// narrow places), plane (through the border of a face that cannot be filled otherwise), inset (of curvature at poles), trim;
    /// may be given more than once
    #[arg(long, value_name = "REMEDY", value_parser = remedy)]
    pub without: Vec<Remedy>,
    /// No edge longer than this many times the thickness of the wall beneath it (functions, leaf)
    #[arg(long, value_name = "RATIO", value_parser = positive)]
    pub thickness: Option<f64>,
    /// Shorter edges somewhere: box=x0,y0,z0,x1,y1,z1:H, sphere=x,y,z,r:H or face=PATTERN:H; may be given more than once
    #[arg(long, value_name = "PLACE:H", value_parser = refinement, allow_hyphen_values = true)]
    pub refine: Vec<Refinement>,
    /// Refuse a mesh that needs more memory than this, in GiB; of CAD models and triangles by the number of triangles expected
    #[arg(long, value_name = "GIB", default_value_t = 8.0, value_parser = positive)]
    pub memory: f64,
}

/// Which operators run.
#[derive(Debug, Args)]
pub struct Operators {
    /// Run these operators after marching cubes, such as "R_all*2 N*10 N1 classify (R_edge R_regular)*5", in quotes; @FILE reads
    /// them from a text file. Method operators
    #[arg(long, value_name = "OPERATORS")]
    pub sequence: Option<String>,
}

/// How to find a model in triangles.
#[derive(Debug, Args)]
pub struct Triangles {
    /// Triangles: edges are features where the normals beside them differ by more than this; 180 keeps only borders between
    /// labels and open ones
    #[arg(long, value_name = "DEGREES", default_value_t = 40.0, value_parser = positive)]
    pub feature_angle: f64,
    /// Triangles: faces of less area are merged with a neighbor
    #[arg(long, value_name = "AREA", default_value_t = 0.0, value_parser = number)]
    pub min_area: f64,
    /// Triangles: shorter edges that end within a face are dropped, narrower faces merged with a neighbor
    #[arg(long, value_name = "LENGTH", value_parser = number)]
    pub min_length: Option<f64>,
    /// Triangles: about how many nodes the mesh shall have, instead of a size
    #[arg(long, value_name = "N")]
    pub nodes: Option<usize>,
    /// Triangles: close contours of open edges; without this an open surface stays open
    #[arg(long)]
    pub close: bool,
}

#[derive(Debug, Args)]
pub struct Mesh {
    #[command(flatten)]
    pub part: PartFile,
    /// Mesh file to write; the ending tells the format; may be given more than once
    #[arg(short, long, required_unless_present = "dry_run", value_name = "MESH")]
    pub output: Vec<PathBuf>,
    /// Make and write nothing: tell about how many triangles the mesh would have
    #[arg(long, conflicts_with_all = ["output", "watch", "bricks", "png", "html", "report", "remesh"])]
    pub dry_run: bool,
    #[command(flatten)]
    pub how: MeshingArguments,
    #[command(flatten)]
    pub anew: super::remesh::Anew,
    #[command(flatten)]
    pub triangles: Triangles,
    /// leaf: exact edges from the tree; operators: marching cubes, then the
    /// operators of Lisnyak (2014) in an order that was measured; paper: as printed there; cut: creases cut where normals differ,
    /// smoothing, flips; mc: marching cubes alone [default: leaf, with --sequence operators]
    #[arg(long, value_name = "METHOD", value_parser = method)]
    pub method: Option<Method>,
    #[command(flatten)]
    pub operators: Operators,
    /// Mesh brick by brick, so many along x, y and z, as 4x4x2: for meshes that memory does not hold while they are made
    #[arg(long, value_name = "XxYxZ", value_parser = super::bricks::bricks)]
    pub bricks: Option<[u32; 3]>,
    #[command(flatten)]
    pub files: Files,
    /// Write the mesh even if it is not sound (it intersects itself, say); without this nothing is written then
    #[arg(long)]
    pub force: bool,
    /// Write the report here: tables to read (.html), else JSON
    #[arg(long, value_name = "FILE")]
    pub report: Option<PathBuf>,
    /// Write a picture here (PNG)
    #[arg(long, value_name = "FILE")]
    pub png: Option<PathBuf>,
    /// Write a page for a browser here (HTML) that shows the mesh and leads to what it falls short of
    #[arg(long, value_name = "FILE")]
    pub html: Option<PathBuf>,
    /// Tell what was tried and how long it took, on standard error, as it happens
    #[arg(short, long)]
    pub verbose: bool,
    /// Mesh again whenever the part's file, or one that it reads, changes, until Ctrl-C
    #[arg(long)]
    pub watch: bool,
    #[command(flatten)]
    pub common: CommonArguments,
    /// Which options were written, not there by default.
    #[arg(skip)]
    pub given: WrittenOptions,
}

/// A page instead of mesh files.
#[derive(Debug, Args)]
pub struct ViewPage {
    #[command(flatten)]
    pub part: PartFile,
    /// Page to write (HTML) [default: PART with the ending .html]
    #[arg(short, long, value_name = "HTML")]
    pub output: Option<PathBuf>,
    /// Write nothing: serve the page on this machine alone, at the address that is printed, and mesh again whenever the part's file,
    /// or one that it reads, changes, until Ctrl-C. The open page follows
    #[arg(long, conflicts_with = "output")]
    pub serve: bool,
    /// Serve at this port of 127.0.0.1 [default: one that is free]
    #[arg(long, value_name = "N", requires = "serve", value_parser = clap::value_parser!(u16).range(1..))]
    pub port: Option<u16>,
    #[command(flatten)]
    pub how: MeshingArguments,
    #[command(flatten)]
    pub triangles: Triangles,
    /// How edges are made, as for `mesh` [default: leaf, with --sequence operators]
    #[arg(long, value_name = "METHOD", value_parser = method)]
    pub method: Option<Method>,
    #[command(flatten)]
    pub operators: Operators,
    #[command(flatten)]
    pub common: CommonArguments,
    /// Which options were written, not there by default.
    #[arg(skip)]
    pub given: WrittenOptions,
}

impl ViewPage {
    /// The same as options of `mesh`, which writes a page and no mesh, be that sound or not: a picture of what is wrong helps.
    pub fn into_mesh(self) -> Mesh {
        let html = Some(self.output.unwrap_or_else(|| self.part.part.with_extension("html")));
        Mesh {
            part: self.part,
            output: Vec::new(),
            dry_run: false,
            how: self.how,
            anew: Default::default(),
            triangles: self.triangles,
            method: self.method,
            bricks: None,
            operators: self.operators,
            files: Files { groups: Grouping::default(), msh_version: "4.1".into() },
            force: true,
            report: None,
            png: None,
            html,
            verbose: false,
            watch: false,
            common: self.common,
            given: self.given,
        }
    }
}

/// How mesh files are written.
#[derive(Debug, Args)]
pub struct Files {
    /// What triangles are named by. faces: each by its face; user: by the group that holds its face, else by the face,
    /// so that each triangle has one name; all: by its face and all groups, where the format allows it
    #[arg(long, default_value = "user", value_name = "WHICH", value_parser = grouping)]
    pub groups: Grouping,
    /// Version of .msh files: 4.1 or 2.2
    #[arg(long, default_value = "4.1", value_name = "VERSION", value_parser = ["4.1", "2.2"])]
    pub msh_version: String,
}

/// A part file and the R-system its function is taken in.
#[derive(Debug, Args)]
pub struct FunctionOf {
    /// Part file (.py) with a solid of R-functions, formula (.vm), level sets (.3mf) or OpenSCAD's tree (.csg)
    #[arg(value_name = "PART")]
    pub part: PathBuf,
    /// Override a top-level number of the part file
    #[arg(short = 'D', value_name = "NAME=VALUE", value_parser = definition)]
    pub define: Vec<(String, f64)>,
    /// R-system: R0, minmax, Ralpha:A or R0m:M [default: the part's own]
    #[arg(long, value_name = "SYSTEM", value_parser = rsystem)]
    pub rsystem: Option<RSystem>,
}

#[derive(Debug, Args)]
pub struct Eval {
    #[command(flatten)]
    pub of: FunctionOf,
    /// Points: rows x y z with commas, semicolons, tabs or blanks between; a first row may name the columns; - is standard
    /// input
    #[arg(long, value_name = "CSV")]
    pub points: PathBuf,
    /// CSV file to write: x,y,z,value,gx,gy,gz,inside,face,leaf [default: standard output]
    #[arg(short, long, value_name = "CSV")]
    pub output: Option<PathBuf>,
    #[command(flatten)]
    pub common: CommonArguments,
}

/// A regular grid over a part's box.
#[derive(Debug, Args)]
pub struct GridFile {
    #[command(flatten)]
    pub of: FunctionOf,
    /// File to write: .vti (VTK image data) or .npy (values alone, float64 of shape nz, ny, nx)
    #[arg(short, long, value_name = "GRID")]
    pub output: PathBuf,
    /// Cells along the longest side [default: 64]
    #[arg(long, value_name = "N", conflicts_with = "step", value_parser = clap::value_parser!(u32).range(1..))]
    pub cells: Option<u32>,
    /// Distance between neighboring points, in the part's unit
    #[arg(long, value_name = "H", value_parser = positive)]
    pub step: Option<f64>,
    /// Room around the part's box: a length, or a share of the diagonal [default: 5%]
    #[arg(long, value_name = "M", value_parser = width)]
    pub margin: Option<SizeRequest>,
    /// Gradients too
    #[arg(long)]
    pub gradient: bool,
    /// The face that decides too: an index, with names beside it in the file
    #[arg(long)]
    pub faces: bool,
    /// Refuse a grid that needs more memory than this, in GiB
    #[arg(long, value_name = "GIB", default_value_t = 8.0, value_parser = positive)]
    pub memory: f64,
    #[command(flatten)]
    pub common: CommonArguments,
}

#[derive(Debug, Args)]
pub struct Compare {
    /// Part file (.py), formula (.vm), level sets (.3mf), OpenSCAD's tree (.csg), or mesh file such as STL
    #[arg(value_name = "PART", required_unless_present = "samples")]
    pub part: Option<PathBuf>,
    /// Override a top-level number of the part file
    #[arg(short = 'D', value_name = "NAME=VALUE", value_parser = definition)]
    pub define: Vec<(String, f64)>,
    /// Instead of a PART, three cubes with two holes that come with the program: what each method makes of each, in one table
    #[arg(long, conflicts_with_all = ["part", "define", "rsystems"])]
    pub samples: bool,
    /// Compare R-systems instead of methods: how near the function is to a distance on the boundary and beside it. Values are
    /// used by eval, grid and programs that compute with the function. Signs alone are used by the leaf method and the operators,
    /// and by marching cubes but for cells whose signs allow more than one topology
    #[arg(long, conflicts_with = "png")]
    pub rsystems: bool,
    #[command(flatten)]
    pub how: MeshingArguments,
    #[command(flatten)]
    pub operators: Operators,
    #[command(flatten)]
    pub triangles: Triangles,
    /// Write the rows here (JSON)
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,
    /// Write one picture of all stages here (PNG); of samples a row for each, with a column for each method
    #[arg(long, value_name = "FILE")]
    pub png: Option<PathBuf>,
    /// What colors in the picture tell. angle: the smallest angle; class: whether nodes are regular, on creases or corners
    #[arg(long, value_enum, value_name = "BY", default_value = "angle", requires = "png")]
    pub color: StageColor,
    #[command(flatten)]
    pub common: CommonArguments,
}

#[derive(Debug, Args)]
pub struct CheckArguments {
    /// Mesh file, or a STEP model: told where it is open, apart, crossing or too small
    pub mesh: PathBuf,
    /// Part file or STEP file the mesh should be of
    #[arg(long, value_name = "PART")]
    pub against: Option<PathBuf>,
    /// Override a top-level number of the part file
    #[arg(short = 'D', value_name = "NAME=VALUE", value_parser = definition)]
    pub define: Vec<(String, f64)>,
    /// One JSON object instead of a table
    #[arg(long)]
    pub json: bool,
    #[command(flatten)]
    pub common: CommonArguments,
}

#[derive(Debug, Args)]
pub struct Heal {
    /// Mesh file
    pub mesh: PathBuf,
    /// Mesh file to write; the ending tells the format; may be given more than once
    #[arg(short, long, required = true, value_name = "MESH")]
    pub output: Vec<PathBuf>,
    #[command(flatten)]
    pub files: Files,
    /// Leave contours of more open edges than this open
    #[arg(long, value_name = "N")]
    pub max_hole: Option<usize>,
    /// Write a page for a browser here (HTML) that shows the result and leads to what was repaired
    #[arg(long, value_name = "FILE")]
    pub html: Option<PathBuf>,
    /// The report as one JSON object instead of a table
    #[arg(long)]
    pub json: bool,
    #[command(flatten)]
    pub common: CommonArguments,
}

#[derive(Debug, Args)]
pub struct InfoArguments {
    #[command(flatten)]
    pub part: PartFile,
    #[command(flatten)]
    pub triangles: Triangles,
    /// One JSON object instead of a table
    #[arg(long)]
    pub json: bool,
    #[command(flatten)]
    pub common: CommonArguments,
}

/// Two points of a mesh.
#[derive(Debug, Args)]
pub struct Way {
    /// Mesh file
    pub mesh: PathBuf,
    /// Where the way starts: the point of the mesh that is nearest to this one
    #[arg(long, value_name = "X,Y,Z", value_parser = point, allow_hyphen_values = true)]
    pub from: DVec3,
    /// Where it ends, in the same way
    #[arg(long, value_name = "X,Y,Z", value_parser = point, allow_hyphen_values = true)]
    pub to: DVec3,
    /// File to write the way to: a polyline for ParaView (.vtp), or its points as rows x,y,z (.csv)
    #[arg(short, long, value_name = "FILE")]
    pub output: Option<PathBuf>,
    /// The way as one JSON object instead of its length: length, start, end, points
    #[arg(long)]
    pub json: bool,
    #[command(flatten)]
    pub common: CommonArguments,
}

#[derive(Debug, Args)]
pub struct Convert {
    #[command(flatten)]
    pub part: PartFile,
    /// STEP file (.step, .stp) to write, for boundaries, or formula (.vm) or level set (.3mf), for solids of R-functions
    #[arg(short, long, value_name = "STEP")]
    pub output: PathBuf,
    #[command(flatten)]
    pub common: CommonArguments,
}

#[derive(Debug, Args)]
pub struct Render {
    /// Mesh file
    pub mesh: PathBuf,
    /// Picture to write (PNG)
    #[arg(short, long, value_name = "PNG")]
    pub output: PathBuf,
    /// From where: iso, front, back, left, right, top, bottom, or AZIMUTH,ELEVATION in degrees (0,0 is the front, 90,0 the
    /// right, 0,90 the top) [default: three quarters from the front right and above, 38,26]
    #[arg(long, value_name = "VIEW", value_parser = view, allow_hyphen_values = true)]
    pub view: Option<View>,
    /// Cut away one side of a plane, in the mesh's unit: x=0 keeps what is behind the plane as the view sees it, x=0,below and
    /// x=0,above the side they name; may be given more than once
    #[arg(long, value_name = "AXIS=POSITION[,SIDE]", value_parser = clip)]
    pub clip: Vec<ClipPlane>,
    /// What colors tell. face: the face; angle: the smallest angle; edge: the edges' length over the mean; distance: how far
    /// nodes are from the surface of the part given by --against; class: whether nodes are regular, on creases or corners
    #[arg(long, value_enum, value_name = "BY", default_value = "face")]
    pub color: Coloring,
    /// The same as --color angle
    #[arg(long, hide = true, conflicts_with = "color")]
    pub quality: bool,
    /// Part file or STEP file the mesh should be of, for --color distance
    #[arg(long, value_name = "PART")]
    pub against: Option<PathBuf>,
    /// Override a top-level number of the part file of --against
    #[arg(short = 'D', value_name = "NAME=VALUE", value_parser = definition, requires = "against")]
    pub define: Vec<(String, f64)>,
    /// Which edges are drawn. sharp: sharp ones, borders of faces and open ones; all: those of all triangles, too [default:
    /// sharp, and those of triangles where these are large enough in the picture]
    #[arg(long, value_enum, value_name = "WHICH")]
    pub edges: Option<DrawnEdges>,
    /// Width and height in pixels
    #[arg(long, value_name = "WIDTHxHEIGHT", value_parser = pixels, default_value = "1200x900")]
    pub size: [usize; 2],
    /// Transparent background
    #[arg(long)]
    pub transparent: bool,
    #[command(flatten)]
    pub common: CommonArguments,
}

/// What the colors of a picture tell.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Coloring {
    Face,
    Angle,
    Edge,
    Distance,
    Class,
}

/// What the colors of a picture of stages tell.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum StageColor {
    Angle,
    Class,
}

/// The edges in a picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum DrawnEdges {
    None,
    Sharp,
    All,
}

fn view(s: &str) -> Result<View, String> {
    s.parse().map_err(|e: rvachev::Error| e.to_string())
}

fn clip(s: &str) -> Result<ClipPlane, String> {
    s.parse().map_err(|e: rvachev::Error| e.to_string())
}

/// Width and height of a picture.
fn pixels(s: &str) -> Result<[usize; 2], String> {
    rvachev::pipeline::pixels(s).map_err(|e| e.to_string())
}

fn number(s: &str) -> Result<f64, String> {
    s.parse::<f64>().map_err(|_| format!("{s:?} is not a number"))
}

fn point(s: &str) -> Result<DVec3, String> {
    let all: Vec<f64> = s.split(',').map(|x| number(x.trim())).collect::<Result<_, _>>()?;
    match all[..] {
        [x, y, z] if all.iter().all(|x| x.is_finite()) => Ok(DVec3::new(x, y, z)),
        _ => Err(format!("a point is three finite numbers X,Y,Z, not {s:?}")),
    }
}

fn positive(s: &str) -> Result<f64, String> {
    number(s).and_then(|v| if v > 0.0 && v.is_finite() { Ok(v) } else { Err(format!("must be positive, not {s}")) })
}

fn share(s: &str) -> Result<f64, String> {
    positive(s).and_then(|v| if v < 1.0 { Ok(v) } else { Err(format!("must be below 1, not {s}")) })
}

fn threads(s: &str) -> Result<usize, String> {
    s.parse::<usize>().ok().filter(|n| *n <= 1024).ok_or_else(|| format!("must be a whole number up to 1024, not {s}"))
}

fn size(s: &str) -> Result<SizeRequest, String> {
    s.parse().map_err(|e: rvachev::Error| e.to_string())
}

pub(super) fn width(s: &str) -> Result<SizeRequest, String> {
    if s.trim() == "0" { Ok(SizeRequest::Length(0.0)) } else { size(s) }
}

fn remedy(s: &str) -> Result<Remedy, String> {
    s.parse().map_err(|e: rvachev::Error| e.to_string())
}

fn refinement(s: &str) -> Result<Refinement, String> {
    s.parse().map_err(|e: rvachev::Error| e.to_string())
}

fn rsystem(s: &str) -> Result<RSystem, String> {
    s.parse().map_err(|e: rvachev::Error| e.to_string())
}

fn grouping(s: &str) -> Result<Grouping, String> {
    s.parse()
}

fn method(s: &str) -> Result<Method, String> {
    s.parse().map_err(|e: rvachev::Error| e.to_string())
}

fn definition(s: &str) -> Result<(String, f64), String> {
    let (name, value) = s.split_once('=').ok_or_else(|| format!("{s:?} is not NAME=VALUE"))?;
    Ok((name.trim().to_string(), number(value.trim())?))
}
