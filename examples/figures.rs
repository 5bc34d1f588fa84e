//! Figures 2 and 5 of [LIS14] on a cube with two crossing holes: the dual mesh, and smoothing along a crease.
//!
//! `cargo run --release --example figures -- FOLDER` writes `fig2.png` and `fig5.png` into the folder, else into `target/figures`.
//! Before it draws, it asserts what the figures show: dual nodes lie on the surface, and so do nodes on both surfaces of their crease.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use rvachev::implicit::{ExtractOptions, Implicit, ImplicitOracle, RSystem, Solid, extract};
use rvachev::mesh::{EditMesh, TriMesh};
use rvachev::optimize::classify::{classify_by_edges, kind_by_edges};
use rvachev::optimize::surface::project;
use rvachev::optimize::{CreaseStep, Kind, Moves, Options, dual_nodes, improve, mark_sharp, smooth_edges};
use rvachev::render::{ClipPlane, ColorBy, KeptHalf, Picture, RenderOptions, View, render, sheet};
use rvachev::{DVec3, Error, Result, Run, write_picture};

/// Half of the cube's side, and the radius of both holes, which run along x and z.
const HALF: f64 = 1.0;
const RADIUS: f64 = 0.4;
/// Cell sizes of the figures: single triangles can be seen at them.
const COARSE: f64 = 0.22;
const FINE: f64 = 0.12;
/// Creases are where normals differ by more degrees than this.
const CREASE: f64 = 20.0;
/// What the operators do in front of `R_edge`: nodes come onto creases.
const ONTO_CREASES: &str =
    "collapse-tiny flip-angles (R_all flip-angles)*2 N*5 (N1 flip-normals degenerate flip-angles)*3 survey";
/// The constant c of (19), and how often `R_edge` runs.
const ALONG: f64 = 0.5;
const ROUNDS: usize = 40;
/// Rounding leaves less than this between a node and the surface.
const EXACT: f64 = 1e-9;
/// Width and height of one picture; two of them stand side by side.
const CELL: [usize; 2] = [680, 570];

fn main() -> Result<()> {
    let folder = std::env::args().nth(1).map_or_else(|| PathBuf::from("target/figures"), PathBuf::from);
    std::fs::create_dir_all(&folder).map_err(|e| Error::io("create", &folder, e))?;
    let run = Run::new();
    let cube = Solid::cuboid(DVec3::splat(-HALF), DVec3::splat(HALF));
    let holes = [DVec3::X, DVec3::Z].map(|axis| Solid::cylinder(RADIUS, axis, DVec3::ZERO, None));
    let model = Implicit::new(&(cube - Solid::union(holes)), RSystem::R0, None)?;
    dual_mesh(&model, &folder.join("fig2.png"), &run)?;
    along_a_crease(&model, &folder.join("fig5.png"), &run)
}

/// Distances of a point from the eight surfaces of the part, the least first.
fn distances(p: DVec3) -> Vec<f64> {
    let planes = p.to_array().into_iter().flat_map(|x| [x - HALF, x + HALF]);
    let walls = [p.y.hypot(p.z) - RADIUS, p.x.hypot(p.y) - RADIUS];
    let mut all: Vec<f64> = planes.chain(walls).map(f64::abs).collect();
    all.sort_by(f64::total_cmp);
    all
}

/// Figure 2: a mesh of marching cubes, projected, and its dual mesh.
fn dual_mesh(model: &Implicit, path: &Path, run: &Run) -> Result<()> {
    let extracted = extract(model, &ExtractOptions::new(COARSE), run)?;
    let oracle = ImplicitOracle::new(model, &extracted);
    let mut mesh = EditMesh::new(&extracted.mesh)?;
    project(&mut mesh, &oracle, COARSE, run)?;

    let feet = dual_nodes(&mesh, &oracle, COARSE, run)?;
    let nodes: Vec<DVec3> = mesh.triangles().filter_map(|t| feet[t as usize].as_ref().map(|f| f.point)).collect();
    assert_eq!(nodes.len(), mesh.triangle_count(), "each triangle has its dual node");
    let farthest = nodes.iter().map(|p| distances(*p)[0]).fold(0.0, f64::max);
    println!("{} triangles, dual nodes at most {farthest:.1e} from the surface", nodes.len());
    assert!(farthest < EXACT);

    let dual = cells(&mesh, &nodes);
    assert_eq!(dual.faces.len(), mesh.nodes().count(), "each node has its dual cell");
    assert!(dual.defects().is_manifold());
    let [mesh, dual] = [(mesh.to_mesh(), true), (dual, false)].map(|(mesh, triangles)| {
        let classes = vec![0; mesh.nodes.len()];
        picture(&mesh, classes, RenderOptions { wireframe: Some(triangles), ..look() }, run)
    });
    let both = [("a mesh of marching cubes".to_string(), mesh?), ("its dual mesh".to_string(), dual?)];
    write_picture(path, &sheet(&both, 2))
}

/// The dual mesh: around each node a face of its own, as a fan of triangles between the node and the dual nodes around it.
fn cells(mesh: &EditMesh, dual: &[DVec3]) -> TriMesh {
    let number: BTreeMap<u32, u32> = mesh.triangles().zip(0..).collect();
    let mut cells = TriMesh { nodes: dual.to_vec(), ..TriMesh::default() };
    for v in mesh.nodes() {
        let ring: Vec<u32> = mesh.outgoing(v).map(|h| number[&(h / 3)]).collect();
        let middle = ring.iter().map(|t| dual[*t as usize]).sum::<DVec3>() / ring.len() as f64;
        let center = cells.nodes.len() as u32;
        cells.nodes.push(middle);
        for (k, t) in ring.iter().enumerate() {
            cells.triangles.push([center, *t, ring[(k + 1) % ring.len()]]);
            cells.labels.push(cells.faces.len() as u32);
        }
        cells.faces.push(format!("cell {v}"));
    }
    cells
}

/// Figure 5: nodes on the edge of a hole, as `N1` left them and when they have moved along it.
fn along_a_crease(model: &Implicit, path: &Path, run: &Run) -> Result<()> {
    let extracted = extract(model, &ExtractOptions::new(FINE), run)?;
    let oracle = ImplicitOracle::new(model, &extracted);
    let mut made = extracted.mesh.clone();
    let options = Options { sequence: ONTO_CREASES.parse()?, retries: 0, ..Options::new(FINE) };
    improve(&mut made, &oracle, &options, run)?;
    let mut mesh = EditMesh::new(&made)?;
    mark_sharp(&mut mesh, &oracle, FINE, CREASE, run)?;

    let before = rim(&mesh);
    let drawn_before = crease_picture(&mesh, run)?;
    let mut last = Moves::default();
    for _ in 0..ROUNDS {
        let classes = classify_by_edges(&mesh);
        last = smooth_edges(&mut mesh, &oracle, CreaseStep { classes: &classes, c: ALONG }, FINE, run)?;
    }
    let after = rim(&mesh);
    let drawn_after = crease_picture(&mesh, run)?;

    // The second least distance is that from the other surface of the crease.
    let off = |v: u32| distances(mesh.point(v))[1];
    let on_creases: Vec<u32> = mesh.nodes().filter(|&v| kind_by_edges(&mesh, v) == Kind::Crease).collect();
    // A node stays beside its crease only where each way onto it would turn a triangle over.
    let (exact, beside): (Vec<u32>, Vec<u32>) = on_creases.iter().partition(|&&v| off(v) < EXACT);
    println!("{} nodes on both surfaces of their crease, {} beside it", exact.len(), beside.len());
    assert!(beside.len() <= last.rejected && 100 * beside.len() <= exact.len());
    let [uneven, even] = [&before, &after].map(|edges| {
        let longest = edges.iter().copied().fold(0.0, f64::max);
        longest / edges.iter().copied().fold(f64::INFINITY, f64::min)
    });
    println!(
        "{} edges of a rim, the longest {uneven:.3} times the shortest, after R_edge {even:.3} times",
        after.len()
    );
    assert!(before.len() == after.len() && after.len() > 12);
    assert!(even < 1.2 && uneven > 1.5 * even);
    let both =
        [("nodes on a crease".to_string(), drawn_before), (format!("after R_edge, {ROUNDS} times"), drawn_after)];
    write_picture(path, &sheet(&both, 2))
}

/// Lengths of the edges where the hole along x meets the side x = 1.
fn rim(mesh: &EditMesh) -> Vec<f64> {
    // Far less than an edge, more than `N1` is off.
    let near = 0.2 * FINE;
    let on = |v: u32| {
        let p = mesh.point(v);
        (p.x - HALF).abs() < near && (p.y.hypot(p.z) - RADIUS).abs() < near
    };
    let edges = mesh.edges().filter(|&h| mesh.is_sharp(h) && on(mesh.origin(h)) && on(mesh.target(h)));
    edges.map(|h| mesh.edge_length(h)).collect()
}

/// The edge of the hole along x, its nodes in the colors of their classes.
fn crease_picture(mesh: &EditMesh, run: &Run) -> Result<Picture> {
    let drawn = mesh.to_mesh();
    // Nodes of the mesh that is drawn have the order of those that live.
    let class = |v: u32| match kind_by_edges(mesh, v) {
        Kind::Regular => 0,
        Kind::Crease => 1,
        Kind::Corner => 2,
    };
    let classes: Vec<u8> = mesh.nodes().map(class).collect();
    let upper = DVec3::new(HALF, 0.0, 0.45 * RADIUS);
    let view =
        View { towards: DVec3::new(1.0, -0.25, 0.15), focus: Some((upper, RADIUS)), margin: 0.0, ..View::default() };
    // Behind it the holes cross, which is another matter.
    let clips = vec![ClipPlane { axis: 0, position: HALF - 0.5 * RADIUS, keep: Some(KeptHalf::Above) }];
    let options = RenderOptions { view, clips, wireframe: Some(true), sharp_angle: Some(30.0), ..look() };
    picture(&drawn, classes, options, run)
}

/// What all pictures have in common: no edge is drawn for its angle alone, but borders of faces are.
fn look() -> RenderOptions {
    let [width, height] = CELL;
    RenderOptions { width, height, sharp_angle: Some(180.0), legend: false, ..RenderOptions::default() }
}

fn picture(mesh: &TriMesh, classes: Vec<u8>, options: RenderOptions, run: &Run) -> Result<Picture> {
    render(mesh, &RenderOptions { color_by: ColorBy::Class(classes), ..options }, run)
}
