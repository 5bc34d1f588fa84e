//! From a triangle soup to a mesh: what is damaged is healed, a model is found in the triangles, its faces are remeshed.

use std::borrow::Cow;
use std::fmt;
use std::path::Path;

use serde::Serialize;

use super::faults::{Places, Touching, keep_shells};
use super::heal::told;
use super::history::{Attempt, Clock, Tried, add_attempt};
use super::load::is_3mf;
use super::mesh::{MeshOptions, Meshed};
use super::refine::Wishes;
use super::report::Report;
use super::soup_sizes::{self, feature_sizes, relaxed, sizing};
use super::wish::{DEFAULT_SIZE, Wish};
use crate::discrete::{Discrete, DiscreteOptions, Limits};
use crate::error::{Error, Result};
use crate::heal::{HealOptions, absorb_fillings, heal};
use crate::implicit::part::SizeRequest;
use crate::io::threemf::has_levelset;
use crate::io::{self, Format};
use crate::mesh::edit::NONE;
use crate::mesh::{EditMesh, TriMesh, self_intersections};
use crate::optimize::exact::{ExactMesh, ExactOptions, Patch, Patchwork, PieceSet, remesh_patchwork};
use crate::quality::{Against, Expectation, Fault, check_tested};
use crate::run::Run;

/// How many things of one kind a report names.
const NAMED: usize = 20;
/// A mesh farther from the surface is not taken if it is folded or more than one triangle in this many is slim within a face.
const SLIM: usize = 500;
/// How often edges are halved around places where the result intersects itself; up to which attempt triangles of the input are
/// kept around them; and the attempt that keeps all connected parts with such places as they are.
const HALVINGS: usize = 4;
const ATTEMPTS: usize = 7;
const LAST: usize = 8;
/// How often they are halved around folds and slim triangles alone.
const FOLDED: usize = 2;
/// Where healing left more than one triangle in this many that touches others, all stay.
const TOUCHED: usize = 200;
/// Where more than one triangle in this many stays from the beginning, all connected parts do on which some stay.
const MUCH: usize = 4;
/// Around such places edges may get as short as this share of what curvature may make them.
const LEAST_BESIDE: f64 = 0.125;
/// Where more than one triangle in this many intersects others it is no matter of sizes. Thin parts of coarse meshes may well be a
/// tenth of all.
const FEW: usize = 3;
/// Where a mesh whose edges may be farther from the surface than else is at fault, they may still be so many times as far: what would
/// have to be nearer is noise. An armadillo gets three times the triangles with 1.
const STRICT: f64 = 2.5;
/// How often a mesh is made to come to a number of nodes, and how near to it is near enough.
const TRIALS: usize = 5;
const NEAR: f64 = 0.03;
/// Fillings of less area than this many squares of the size, or narrower than this many sizes, are no faces of their own.
const LEAST_FILLING: f64 = 1.0;
const LEAST_WIDTH: f64 = 0.3;
/// Geometric edges that end within a face and are shorter than this many sizes are noise to a mesh of that size.
const STUB: f64 = 2.0;
/// The same for edges that end within a face on both sides.
const ISOLATED: f64 = 6.0;

/// What a soup is asked for, beyond [`MeshOptions`].
#[derive(Debug, Clone, PartialEq)]
pub struct SoupOptions {
    /// Edges are features where the triangles' normals differ by more degrees.
    pub feature_angle: f64,
    /// Faces of less area are merged with a neighbor.
    pub min_area: f64,
    /// Edges shorter than this that end within a face are dropped, faces narrower than this merged with a neighbor. Without
    /// a wish edges shorter than the size are dropped, and no faces.
    pub min_length: Option<f64>,
    /// About how many nodes the mesh shall have, instead of a size.
    pub nodes: Option<usize>,
    /// Whether contours of open edges are closed, too. Otherwise an open surface stays open, unless it is damaged.
    pub close: bool,
}

impl Default for SoupOptions {
    fn default() -> Self {
        let d = DiscreteOptions::default();
        Self { feature_angle: d.feature_angle, min_area: 0.0, min_length: None, nodes: None, close: false }
    }
}

/// What was found in a soup.
#[derive(Debug, Clone, Serialize)]
pub struct SoupInfo {
    /// Triangles as read.
    pub triangles: usize,
    /// What healing did before anything else; nothing where the triangles were sound.
    pub healed: Vec<String>,
    /// Whether there is no open border.
    pub closed: bool,
    /// Smallest coordinates of the box around the triangles.
    pub lo: [f64; 3],
    /// Largest coordinates.
    pub hi: [f64; 3],
    /// Connected parts.
    pub shells: usize,
    /// Geometric vertices.
    pub vertices: usize,
    /// Geometric edges.
    pub edges: usize,
    /// Geometric faces.
    pub faces: Vec<FaceInfo>,
    /// Names of groups.
    pub groups: Vec<String>,
}

/// One face found in a soup.
#[derive(Debug, Clone, Serialize)]
pub struct FaceInfo {
    /// Its name.
    pub name: String,
    /// Its area.
    pub area: f64,
    /// Triangles of the input on it.
    pub triangles: usize,
    /// Whether it is a plane to the precision of its nodes.
    pub plane: bool,
    /// Its neighbors in the relation graph, by name.
    pub neighbors: Vec<String>,
}

/// Whether a path is that of a mesh file that can be read. A 3MF package is one unless it has a level set, for which it is looked at.
pub fn is_mesh(path: &Path) -> bool {
    if is_3mf(path) {
        return std::fs::read(path).is_ok_and(|bytes| !has_levelset(&bytes));
    }
    Format::from_path(path).is_ok_and(|f| f != Format::Vtu)
}

/// Reads a mesh file. Errors name the file.
pub fn load_mesh(path: &Path, run: &Run) -> Result<TriMesh> {
    io::read(path, run)
}

/// A soup that the discrete gate can work on.
pub(super) struct Prepared {
    pub(super) mesh: TriMesh,
    healed: Vec<String>,
}

impl Prepared {
    /// What a mesh of edges of a length is made from: fillings that would be smaller than its triangles belong to faces beside
    /// them.
    pub(super) fn at(&self, size: f64) -> Cow<'_, TriMesh> {
        let mut mesh = Cow::Borrowed(&self.mesh);
        if !self.healed.is_empty() {
            absorb_fillings(mesh.to_mut(), LEAST_FILLING * size * size, LEAST_WIDTH * size);
        }
        mesh
    }
}

/// Whether a mesh is an oriented manifold, open or closed, without degenerate triangles, that does not intersect itself.
fn is_sound(mesh: &TriMesh, run: &Run) -> Result<bool> {
    let d = mesh.defects();
    Ok(d.is_manifold()
        && d.is_oriented()
        && d.degenerate_triangles.is_empty()
        && d.duplicate_triangles.is_empty()
        && self_intersections(mesh, run)?.is_empty())
}

/// Heals what needs it: nothing, then what can be healed without closing contours, then everything.
pub(super) fn prepare(input: &TriMesh, close: bool, run: &Run) -> Result<Prepared> {
    input.validate()?;
    run.progress("look", 0.0);
    let closed = |m: &TriMesh| m.defects().is_closed();
    let outward = |m: &TriMesh| !closed(m) || m.volume() > 0.0;
    if is_sound(input, run)? && outward(input) && (!close || closed(input)) {
        let mut mesh = input.clone();
        mesh.drop_unused_nodes();
        return Ok(Prepared { mesh, healed: Vec::new() });
    }
    if !close
        && let Ok(gentle) = heal(input, &HealOptions { max_hole: Some(0) }, run)
        && is_sound(&gentle.mesh, run)?
    {
        return Ok(Prepared { healed: told(&gentle.report), mesh: gentle.mesh });
    }
    let full = heal(input, &HealOptions::default(), run)?;
    let mut healed = told(&full.report);
    healed.extend(full.report.shortfalls.iter().cloned());
    Ok(Prepared { healed, mesh: full.mesh })
}

pub(super) fn discrete_options(soup: &SoupOptions, size: f64) -> DiscreteOptions {
    let limits = Limits {
        area: soup.min_area,
        width: soup.min_length.unwrap_or(0.0),
        length: soup.min_length.unwrap_or(STUB * size),
        isolated: soup.min_length.unwrap_or(ISOLATED * size),
    };
    DiscreteOptions { feature_angle: soup.feature_angle, limits, scale: size, ..DiscreteOptions::default() }
}

pub(super) fn length(size: Option<SizeRequest>, mesh: &TriMesh) -> f64 {
    match size.unwrap_or(DEFAULT_SIZE) {
        SizeRequest::Length(h) => h,
        SizeRequest::Share(s) => s * mesh.bounds().diagonal(),
    }
}

/// Meshes a triangle soup.
///
/// Guarantees: nodes on features lie on the input's features, others on its triangles; the same bytes for any number of
/// threads; what was healed or simplified away is in the report's `warnings`. Where remeshing makes the surface intersect
/// itself and the input does not, the input's triangles around are kept, at last all of them, and the report's `shortfalls`
/// say so.
///
/// Errors: what [`heal`] refuses; [`Error::Usage`] for fewer than four nodes or a sequence of operators; cancellation.
pub fn mesh_soup(input: &TriMesh, options: &MeshOptions, soup: &SoupOptions, run: &Run) -> Result<Meshed> {
    options.for_any_solid()?;
    options.for_boundary()?;
    let options = &options.resolved(input.bounds().diagonal());
    let prepared = prepare(input, soup.close, run)?;
    let Some(nodes) = soup.nodes else {
        return mesh_prepared(&prepared, length(options.size, &prepared.mesh), options, soup, run);
    };
    if nodes < 4 {
        return Err(Error::Usage(format!("a mesh needs at least four nodes, not {nodes}")));
    }
    // A closed surface of even triangles has two to a node.
    let mut size = (prepared.mesh.area() / (2.0 * nodes as f64) / (3f64.sqrt() / 4.0)).sqrt();
    let mut best: Option<(f64, Meshed)> = None;
    for _ in 0..TRIALS {
        let made = mesh_prepared(&prepared, size, options, soup, run)?;
        let off = (made.mesh.nodes.len() as f64 / nodes as f64).ln();
        if best.as_ref().is_none_or(|b| off.abs() < b.0) {
            best = Some((off.abs(), made));
        }
        if off.abs() < NEAR {
            break;
        }
        size *= (0.5 * off).exp().clamp(0.4, 2.5);
    }
    let (off, mut made) = best.ok_or(Error::Cancelled)?;
    if off >= NEAR {
        made.report.warnings.push(format!("{} nodes, not {nodes}: features ask for them", made.mesh.nodes.len()));
    }
    Ok(made)
}

fn mesh_prepared(
    prepared: &Prepared,
    size: f64,
    options: &MeshOptions,
    soup: &SoupOptions,
    run: &Run,
) -> Result<Meshed> {
    mesh_counted(prepared, size, options, soup, run).map(|made| made.0)
}

/// A mesh, and how many of its triangles are turned over or slim within a face.
fn mesh_counted(
    prepared: &Prepared,
    size: f64,
    options: &MeshOptions,
    soup: &SoupOptions,
    run: &Run,
) -> Result<(Meshed, usize)> {
    let mut report = Report::of("triangles", size, None);
    report.warnings.clone_from(&prepared.healed);
    let mut timer = Clock::new(options.timed);
    let mesh = &prepared.at(size);
    let found = |scale: f64| match Discrete::new(mesh, &DiscreteOptions { scale, ..discrete_options(soup, size) }, run)
    {
        Ok(solid) => Ok(solid),
        Err(Error::Cancelled) => Err(Error::Cancelled),
        Err(e) => Err(Error::Failed(format!("not remeshed: {e}"))),
    };
    let mut solid = found(size)?;
    let mut touching = Touching::default();
    if !prepared.healed.is_empty() {
        touching = Touching::of(&solid.named(), run)?;
    }
    // Where healing left hardly any room even nodes that are put on edges may be in the way.
    if !touching.is_empty() {
        solid = found(0.0)?;
        touching = Touching::of(&solid.named(), run)?;
    }
    tell_removed(&solid, &mut report);
    let sizing = relaxed(sizing(size, solid.bounds().diagonal(), options), options, soup, &solid);
    // What is left as it was is not divided.
    let named = solid.named();
    // What touches is known by its triangles.
    if touching.is_empty() {
        solid.divide_walls(|k| sizing.at(k), sizing.least.min(size), run)?;
    }
    let open = !named.defects().is_closed();
    let wishes = Wishes::new(&options.refinements, mesh.bounds().diagonal(), named.faces.iter().map(String::as_str))?;
    let (face_sizes, regions) = (wishes.faces, wishes.regions);
    let wish = Wish::new(size, solid.bounds().diagonal(), options);
    let plain = soup_sizes::exact(sizing, options, &solid);
    let exact = ExactOptions { face_sizes, regions, ..plain };
    let mut sizes = feature_sizes(&solid, &sizing, wish.chord(), &mut report);
    let walls = solid.walls(|k| sizing.at(k), sizing.least.min(size), run)?;
    sizes.iter_mut().zip(walls.sizes).for_each(|(s, wall)| *s = s.min(wall));
    let mut kept = walls.tight;
    touching.keep(&mut kept, &solid);
    // Where healing laid sheets side by side everywhere there is nothing to gain in between.
    if TOUCHED * touching.len() > kept.len() {
        kept.fill(true);
    }
    if !touching.is_empty() || MUCH * kept.iter().filter(|k| **k).count() > kept.len() {
        keep_shells(&mut kept, &solid);
    }
    let mut attempt = if touching.is_empty() { 0 } else { ATTEMPTS };
    // The best that does not intersect itself, though it may be folded.
    let mut whole: Option<ExactMesh> = None;
    let mut left = false;
    let flaws = |m: &ExactMesh| m.report.inverted + m.report.slim.len();
    let mut clock = Clock::new(options.timed);
    let mut attempts: Vec<Attempt> = Vec::new();
    let made = loop {
        if kept.iter().all(|k| *k) {
            break None;
        }
        let work = patchwork(&solid, sizes.clone(), &kept, LEAST_BESIDE * sizing.least.min(size));
        let made = remesh_patchwork(work, &named, &solid, &exact, run, None)?;
        let bad = match made.report.self_intersections {
            0 => Vec::new(),
            _ => touching.others(&made.mesh, run)?,
        };
        let flawed = bad.len() + made.report.inverted;
        let attempt_made = Attempt::new(Tried::Soup, size, made.mesh.triangles.len(), flawed, &mut clock);
        add_attempt(&mut attempts, attempt_made, run);
        if FEW * bad.len() > made.mesh.triangles.len() {
            attempt = attempt.max(HALVINGS);
        }
        // Nothing is kept for the sake of folds.
        let mut folds = Vec::new();
        if attempt < HALVINGS {
            folds.extend_from_slice(&made.report.faults[made.report.self_intersections..]);
            folds.extend_from_slice(&made.report.slim);
        }
        let reach = if attempt < HALVINGS { 0.5 } else { (attempt + 1 - HALVINGS) as f64 };
        let places = Places::new(&bad, &folds, &made.mesh, reach);
        let poor = made.report.inverted > 0 || SLIM * made.report.slim.len() > made.mesh.triangles.len();
        // Nearer to the surface there may be no need for more.
        let plain = self::sizing(size, solid.bounds().diagonal(), options);
        let near = sizing.chord <= plain.chord.map(|c| STRICT * c);
        if !near && !bad.is_empty() {
            let options = MeshOptions { tolerance: Some(STRICT * wish.tolerance), ..options.clone() };
            let mut strict = mesh_counted(prepared, size, &options, soup, run)?;
            strict.0.report.attempts.splice(0..0, attempts);
            return Ok(strict);
        }
        if bad.is_empty() {
            if whole.as_ref().is_none_or(|w| flaws(&made) < flaws(w)) {
                whole = Some(made);
            }
            if poor && attempt >= FOLDED && !near {
                let options = MeshOptions { tolerance: Some(STRICT * wish.tolerance), ..options.clone() };
                let mut strict = mesh_counted(prepared, size, &options, soup, run)?;
                if whole.as_ref().is_none_or(|w| strict.1 < flaws(w)) {
                    strict.0.report.attempts.splice(0..0, attempts);
                    return Ok(strict);
                }
            }
            if !poor || attempt >= FOLDED {
                break whole;
            }
        } else if whole.is_some() {
            break whole;
        }
        attempt += 1;
        let more = if attempt <= HALVINGS {
            places.halve(&mut sizes, &solid, LEAST_BESIDE * sizing.least.min(size))
        } else if attempt <= LAST {
            let more = places.keep(&mut kept, &solid);
            if attempt == LAST {
                keep_shells(&mut kept, &solid);
            }
            more || attempt == LAST
        } else {
            false
        };
        if more || attempt < LAST {
            continue;
        }
        report.shortfalls.push(Fault::NotRemeshed);
        left = true;
        break None;
    };
    let intersecting = made.as_ref().map(|m| m.report.self_intersections);
    let count = made.as_ref().map_or(usize::MAX, flaws);
    let ExactMesh { mesh, seams, corners, .. } = made.unwrap_or(ExactMesh { mesh: named, ..ExactMesh::default() });
    if let Some(first) = kept.iter().position(|k| *k).filter(|_| !left) {
        let count = kept.iter().filter(|k| **k).count();
        let at = solid.mesh.centroid(first as u32).to_array();
        report.shortfalls.push(Fault::Kept { triangles: count, at });
    }
    // The best is the one with as many triangles, of those the last.
    if let Some(a) = attempts.iter_mut().rev().find(|a| !left && a.triangles == mesh.triangles.len()) {
        a.kept = true;
    }
    report.attempts = attempts;
    report.stage("mesh", mesh.triangles.len(), &mut timer, run);
    run.progress("check", 0.0);
    let against = options.measure.then(|| Against::new(&solid));
    let expected = Expectation { open, touching: false };
    let measured = check_tested(&mesh, intersecting, expected, against, run)?;
    if open {
        report.warnings.push("the surface is open: its border is kept".into());
    }
    if !touching.is_empty() {
        report.shortfalls.push(Fault::Touching { triangles: touching.len() });
    }
    report.judge(measured);
    report.stage("check", mesh.triangles.len(), &mut timer, run);
    Ok((Meshed { mesh, seams, corners, outline: None, report, solid: None }, count))
}

fn tell_removed(solid: &Discrete, report: &mut Report) {
    for r in solid.removed.iter().take(NAMED) {
        let [x, y, z] = r.at;
        let of = if r.what == "face" { "area" } else { "length" };
        report.warnings.push(format!("not kept: {} of {of} {:.4e} at ({x:.6}, {y:.6}, {z:.6})", r.what, r.size));
    }
    if solid.removed.len() > NAMED {
        report.warnings.push(format!("and {} more features not kept", solid.removed.len() - NAMED));
    }
}

/// The triangles with what the remesher needs; those that stay are patches of their own, beside which edges are as long as
/// theirs, but not shorter than `least`.
pub(super) fn patchwork(solid: &Discrete, mut sizes: Vec<f64>, kept: &[bool], least: f64) -> Patchwork {
    let mut mesh: EditMesh = solid.mesh.clone();
    let sets = (0..mesh.node_capacity() as u32).map(|v| PieceSet::of(&solid.pieces_at(v))).collect();
    let faces = solid.face_count() as u32;
    let mut patches: Vec<Patch> = (0..faces)
        .map(|f| Patch { piece: f, outward: 1.0, plane: crate::geometry::Pieces::plane(solid, f), face: u32::MAX })
        .collect();
    let mut frozen_as = vec![u32::MAX; patches.len()];
    for t in solid.mesh.triangles().filter(|t| kept[*t as usize]) {
        let face = mesh.label(t) as usize;
        if frozen_as[face] == u32::MAX {
            frozen_as[face] = patches.len() as u32;
            patches.push(patches[face]);
        }
        let normal = mesh.area_vector(t).normalize_or_zero();
        mesh.set_surface(t, frozen_as[face], normal);
        // Sizes grow from what stays.
        for h in 3 * t..3 * t + 3 {
            for v in [mesh.origin(h), mesh.target(h)] {
                sizes[v as usize] = sizes[v as usize].min(mesh.edge_length(h).max(least));
            }
        }
    }
    let borders: Vec<u32> = mesh
        .edges()
        .filter(|&h| mesh.opposite(h) != NONE && mesh.label(h / 3) != mesh.label(mesh.opposite(h) / 3))
        .collect();
    borders.into_iter().for_each(|h| mesh.set_sharp(h, true));
    let frozen = (faces..patches.len() as u32).collect();
    Patchwork {
        lines_from: faces,
        sizes,
        frozen,
        raw: true,
        fine: solid.smooth,
        ..Patchwork::new(mesh, sets, patches.into())
    }
}

/// Finds the model in a soup, as [`mesh_soup`] does, and tells what it is made of.
///
/// Errors: those of [`mesh_soup`].
pub fn soup_info(input: &TriMesh, options: &MeshOptions, soup: &SoupOptions, run: &Run) -> Result<SoupInfo> {
    let prepared = prepare(input, soup.close, run)?;
    let size = length(options.size, &prepared.mesh);
    let solid = Discrete::new(&prepared.at(size), &discrete_options(soup, size), run)?;
    let named = solid.named();
    let model = solid.model()?.model;
    let mut faces: Vec<FaceInfo> = named
        .faces
        .iter()
        .enumerate()
        .map(|(f, name)| FaceInfo {
            name: name.clone(),
            area: 0.0,
            triangles: 0,
            plane: crate::geometry::Pieces::plane(&solid, f as u32).is_some(),
            neighbors: Vec::new(),
        })
        .collect();
    for (t, l) in named.labels.iter().enumerate() {
        faces[*l as usize].triangles += 1;
        faces[*l as usize].area += 0.5 * named.area_vector(t).length();
    }
    for around in model.faces_of_edges() {
        for f in &around {
            for g in around.iter().filter(|g| *g != f) {
                let [a, b] = [f, g].map(|x| model.faces[*x as usize].label as usize);
                let name = named.faces[b].clone();
                if a != b && !faces[a].neighbors.contains(&name) {
                    faces[a].neighbors.push(name);
                }
            }
        }
    }
    let b = solid.bounds();
    Ok(SoupInfo {
        triangles: input.triangles.len(),
        healed: prepared.healed,
        closed: named.defects().is_closed(),
        lo: b.lo.to_array(),
        hi: b.hi.to_array(),
        shells: model.shells.len(),
        vertices: model.vertices.len(),
        edges: model.edges.len(),
        faces,
        groups: named.groups.iter().map(|g| g.name.clone()).collect(),
    })
}

impl fmt::Display for SoupInfo {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let closed = if self.closed { "closed" } else { "open" };
        writeln!(f, "{} triangles, {closed}, {} shell(s)", self.triangles, self.shells)?;
        writeln!(f, "box from {:?} to {:?}", self.lo, self.hi)?;
        self.healed.iter().try_for_each(|h| writeln!(f, "{h}"))?;
        writeln!(f, "{} vertices, {} edges, {} faces:", self.vertices, self.edges, self.faces.len())?;
        for face in &self.faces {
            let plane = if face.plane { ", plane" } else { "" };
            let next = if face.neighbors.is_empty() { "nothing".into() } else { face.neighbors.join(", ") };
            writeln!(f, "  {}: area {:.6}, {} triangles{plane}; beside {next}", face.name, face.area, face.triangles)?;
        }
        write!(f, "groups: {}", if self.groups.is_empty() { "none".into() } else { self.groups.join(", ") })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::DVec3;
    use crate::pipeline::wish::GRADING;

    /// A bumpy square of n x n nodes, open.
    fn square(n: u32) -> TriMesh {
        let at = |i: u32, j: u32| {
            let [x, y] = [i, j].map(|k| f64::from(k) / f64::from(n - 1));
            DVec3::new(x, y, 0.05 * (5.0 * x).sin() * (4.0 * y).cos())
        };
        let nodes = (0..n * n).map(|k| at(k % n, k / n)).collect();
        let cell = |k: u32| {
            let a = k / (n - 1) * n + k % (n - 1);
            [[a, a + 1, a + n + 1], [a, a + n + 1, a + n]]
        };
        TriMesh::new(nodes, (0..(n - 1) * (n - 1)).flat_map(cell).collect())
    }

    #[test]
    fn triangles_that_are_kept_stay_as_they_are_and_the_rest_is_remeshed() {
        let (run, size) = (Run::new(), 0.04);
        let solid = Discrete::new(&square(40), &discrete_options(&SoupOptions::default(), size), &run).unwrap();
        let centers: Vec<DVec3> = (0..solid.mesh.triangle_capacity() as u32).map(|t| solid.mesh.centroid(t)).collect();
        let kept: Vec<bool> = centers.iter().map(|c| c.distance(DVec3::new(0.5, 0.5, 0.0)) < 0.2).collect();
        let work = patchwork(&solid, vec![f64::INFINITY; solid.mesh.node_capacity()], &kept, 0.0);
        let exact = ExactOptions::new(sizing(size, 1.0, &MeshOptions::default()), GRADING);
        let made = remesh_patchwork(work, &solid.named(), &solid, &exact, &run, None).unwrap();
        assert_eq!(made.report.self_intersections, 0);
        let now: std::collections::BTreeSet<[u64; 3]> =
            (0..made.mesh.triangles.len()).map(|t| made.mesh.centroid(t).to_array().map(f64::to_bits)).collect();
        let is_there = |t: usize| now.contains(&centers[t].to_array().map(f64::to_bits));
        let (mut stayed, mut others) = (0, 0);
        for t in 0..kept.len() {
            if kept[t] { stayed += usize::from(is_there(t)) } else { others += usize::from(is_there(t)) }
        }
        assert!(stayed > 300 && stayed == kept.iter().filter(|k| **k).count());
        assert!(others < kept.len() / 20 && made.mesh.triangles.len() < kept.len());
        assert_eq!(made.mesh.labels.iter().max(), Some(&0));
    }
}
