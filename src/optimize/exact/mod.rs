//! Meshes with exact edges and corners, for surfaces known as [pieces](InPieces): cut the extracted mesh along the borders
//! of the pieces, put every node where its pieces meet, and remesh each patch between its borders.

mod angles;
mod apexes;
mod climb;
mod concurrent;
mod curves;
mod fans;
mod field;
mod flat;
mod flips;
mod frozen;
mod gaps;
mod grid;
mod join;
mod joints;
mod moves;
mod near;
mod open;
mod pack;
mod patches;
mod patchwork;
mod pieced;
mod pointed;
mod remesh;
mod scatter;
mod strips;
mod thaw;
mod tips;

pub use field::asked_triangles;
use open::polish_beyond_ends;
pub use open::{Laid, remesh_open};
pub(crate) use patches::BAND;
pub use patchwork::{ExactTarget, Filling, Patchwork, PiecePatch, PieceSet};
pub use pieced::{InPieces, patch_open_pieces, patch_pieces};
pub use thaw::Off;

use glam::DVec3;

use super::region::Region;
use super::sequence::TINY;
use super::size::Sizing;
use crate::error::{Error, Result};
use crate::mesh::edit::NONE;
use crate::mesh::{EditMesh, TriMesh, self_intersections};
use crate::run::Run;
use crate::spatial::{Aabb, Graded};
use patchwork::plain_shape;
use remesh::{Rank, Remesher, SHORT};

/// How often borders are spaced: what is in the way of a node at first may be gone later.
const SPACINGS: usize = 3;
/// Nodes are taken out and put in for the sake of even angles where too many of a patch's triangles have a shape below this, that of 45
/// degrees between equal sides: packing leaves fewer where there is room.
const EVEN: f64 = 0.93;
/// Too many are more than this share.
const UNEVEN: f64 = 0.025;
/// Rounds of flips and relaxation after packing, and of those across borders after that.
const LAST: usize = 2;
/// The same where places were refined; also the passes of mending triangles one by one.
const POLISH: usize = 4;
/// Shapes below this are what cutting and spacing leave where things are tight: 7 degrees.
const POOR: f64 = 0.2;
/// A triangle of a smaller shape than this is flat: its height is below 3 % of its length. Once borders of raw triangles are spaced only such
/// ones are mended: packing leaves few of the others.
const FLAT: f64 = 0.05;
/// Rounds of split, collapse, flip and relaxation where a packing folds.
const PLAIN: usize = 3;
/// Edges around folds up to which they are.
const FOLDED: usize = 4;
/// Shapes below this are mended one by one: 45 degrees.
const MEND: f64 = 0.95;
/// Shapes below this that are left then take more than one step to mend: 35 degrees.
const STUCK: f64 = 0.8;
/// Shapes below this are mended once more: 20 degrees.
const SLIM: f64 = 0.55;
/// How often they are.
const SLIM_ROUNDS: usize = 2;
/// How often the surroundings of triangles that intersect are refined.
const REPAIRS: usize = 4;
/// Edges around such places up to which nodes are looked at.
const AROUND: usize = 2;
/// Surroundings are not refined when more than one triangle in this many intersects others.
const FEW: usize = 4;
/// Refinement ends when there are this many times more triangles than before: what intersects is then no matter of size.
const MOST_REPAIRED: usize = 3;
/// Refinement of such places stops at this share of the size.
const LEAST: f64 = 1.0 / 16.0;
/// Shares of the remesher's time that have passed, roughly: when lengths are known,
const SIZED: f64 = 0.1;
/// when what the cut folded is untangled,
const UNTANGLED: f64 = 0.2;
/// when nodes of borders are in their places,
const BORDERED: f64 = 0.3;
/// when patches are packed,
const PACKED: f64 = 0.75;
/// and when what is poor has been mended.
const POLISHED: f64 = 0.95;

/// A mesh and the triangles of it that intersect others.
type Tested = (TriMesh, Vec<u32>);

/// Sees the mesh after a stage, with the stage's name.
pub type Observer<'a> = dyn FnMut(&str, &TriMesh) + Send + 'a;

/// What [`remesh_patches`] aims at.
#[derive(Debug, Clone, PartialEq)]
pub struct ExactOptions {
    /// Wanted edge lengths.
    pub sizing: Sizing,
    /// Wanted edge lengths on single faces, by index of the face.
    pub face_sizes: Vec<Option<f64>>,
    /// Wanted edge lengths in parts of space; with borders that are spaced already there is no need for them.
    pub regions: Vec<Region>,
    /// Wanted edge lengths at places, and how they grow from there.
    pub finer: Graded,
    /// How fast edge lengths may grow per length.
    pub grading: f64,
    /// Gaps between borders and short borders are followed down to this edge length.
    pub narrowest: f64,
    /// No edge is longer than this many times the solid's thickness beneath it ([`remesh_patches`] only).
    pub thickness: Option<f64>,
    /// Where only few triangles come out farther from the surface than this they are divided.
    pub distance: Option<f64>,
}

impl ExactOptions {
    /// The same wish everywhere.
    pub fn new(sizing: Sizing, grading: f64) -> Self {
        let narrowest = sizing.least;
        Self {
            sizing,
            face_sizes: Vec::new(),
            regions: Vec::new(),
            finer: Graded::new(Vec::new(), grading),
            grading,
            narrowest,
            thickness: None,
            distance: None,
        }
    }
}

/// What [`remesh_patches`] met.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ExactReport {
    /// Triangles that intersect others.
    pub self_intersections: usize,
    /// Triangles that face away from their piece.
    pub inverted: usize,
    /// The boxes around these triangles.
    pub faults: Vec<Aabb>,
    /// The boxes around triangles with an angle below about 20 degrees of which no node lies on a border; of raw ones only.
    pub slim: Vec<Aabb>,
    /// Middles of edges on borders that the border's curve does not come near: it goes another way, as where cells joined what
    /// lies apart in a neck.
    pub astray: Vec<DVec3>,
    /// How often surroundings of intersecting triangles were refined.
    pub repairs: usize,
    /// Nodes that are not on their surfaces, as triangles would cross if they were.
    pub off: Vec<Off>,
}

/// A mesh with exact borders, and what its topology is beyond the faces' names.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ExactMesh {
    /// The mesh.
    pub mesh: TriMesh,
    /// Edges of the mesh at which two pieces of one face meet, as pairs of nodes.
    pub seams: Vec<[u32; 2]>,
    /// Nodes where borders end or meet, and apexes.
    pub corners: Vec<u32>,
    /// The piece of each triangle; `u32::MAX` for those on none.
    pub pieces: Vec<u32>,
    /// What was met.
    pub report: ExactReport,
}

impl ExactReport {
    /// Whether every border is exact and every triangle sound.
    pub fn is_clean(&self) -> bool {
        self.self_intersections == 0 && self.inverted == 0
    }
}

/// Remeshes the patchwork of a solid's pieces to the sizes asked for, narrow places and walls heeded; `observer` sees the mesh after each stage.
///
/// *Guarantees*: a closed, oriented manifold stays one; every node lies on all pieces it belongs to, to rounding; labels are faces.
/// *Does not guarantee*: that no two triangles intersect: the report tells.
/// *Errors*: [`Error::Usage`] for senseless options, [`Error::Cancelled`].
pub fn remesh_patches(
    mut work: Patchwork,
    target: ExactTarget<'_>,
    options: &ExactOptions,
    run: &Run,
    observer: Option<&mut Observer<'_>>,
) -> Result<ExactMesh> {
    check_options(options)?;
    let Sizing { size, least, .. } = options.sizing;
    let least = least.min(size);
    if let Some(share) = options.thickness {
        work.sizes = gaps::through_solid(&work, share, size, least, run)?;
    }
    let r = Remesher::new(work, target.surface, options, run)?;
    Ok(run.install(|| remesh(target.names, r, true, ExactReport::default(), observer))?.0)
}

/// Remeshes a patchwork made of something else, such as the faces of a boundary representation.
///
/// Guarantees and errors are those of [`remesh_patches`]; borders that are open stay as they are.
pub fn remesh_patchwork(
    work: Patchwork,
    target: ExactTarget<'_>,
    options: &ExactOptions,
    run: &Run,
    observer: Option<&mut Observer<'_>>,
) -> Result<ExactMesh> {
    check_options(options)?;
    let r = Remesher::new(work, target.surface, options, run)?;
    Ok(run.install(|| remesh(target.names, r, false, ExactReport::default(), observer))?.0)
}

fn check_options(options: &ExactOptions) -> Result<()> {
    let positive = |x: f64| x.is_finite() && x > 0.0;
    if ![options.sizing.size, options.grading, options.thickness.unwrap_or(1.0)].into_iter().all(positive) {
        return Err(Error::Usage("size, grading and thickness must be positive".into()));
    }
    Ok(())
}

fn remesh<'a>(
    mesh: &TriMesh,
    mut r: Remesher<'a>,
    narrow: bool,
    mut report: ExactReport,
    observer: Option<&mut Observer<'_>>,
) -> Result<(ExactMesh, Remesher<'a>)> {
    let (options, run) = (r.options, r.run);
    let spaced = r.work.spaced;
    r.merge_doubles();
    tell(&r, 0.0);
    r.ask_sizes(narrow)?;
    tell(&r, SIZED);
    let mut observer = observer;
    let mut show = |name: &str, r: &Remesher<'_>| {
        if let Some(o) = &mut observer {
            o(name, &finish(mesh, r));
        }
    };
    show("cut", &r);
    if r.work.raw {
        r.even_sizes()?;
        show("even", &r);
    }
    if !spaced && !r.work.goes_on {
        run.expect(r.expected_triangles())?;
    }
    if !spaced {
        prepare_borders(&mut r, narrow, &mut show)?;
    }
    r.look_everywhere();
    tell(&r, BORDERED);
    let filling = r.work.filling;
    match filling {
        Filling::Mended => r.each_part(remesh_patch)?,
        Filling::Front => r.each_patch(|r| r.pack())?,
        Filling::Random => r.each_patch(|r| r.scatter())?,
    }
    show("pack", &r);
    tell(&r, PACKED);
    let mut tested = None;
    if filling == Filling::Mended {
        // From here on triangles lie as near to the surface as their size lets them.
        if r.work.raw {
            r.work.by_angles = true;
            r.work.mesh.set_all_changed();
        }
        polish_beyond_ends(&mut r)?;
        if let Some(limit) = options.distance {
            tested = nearer(mesh, &mut r, limit)?;
        }
        if r.work.raw {
            tested = mend_slim(mesh, &mut r)?;
        }
    }
    tell(&r, POLISHED);
    let (mut out, mut bad) = match tested {
        Some(known) => known,
        None => {
            let out = finish(mesh, &r);
            let mut bad = if filling == Filling::Mended { intersecting(&out, run)? } else { Vec::new() };
            if r.work.goes_on {
                bad = away_from_ends(&r, bad);
            }
            (out, bad)
        }
    };
    let most = MOST_REPAIRED * r.work.mesh.triangle_count();
    // Refinement ends, too, where it makes twice as many of them.
    let least = 2 * bad.len();
    let few = |bad: &[u32], out: &TriMesh| FEW * bad.len() <= out.triangles.len() && bad.len() <= least;
    let first = (r.work.raw && !bad.is_empty()).then(|| (r.clone(), out.clone(), bad.clone()));
    while !bad.is_empty() && few(&bad, &out) && report.repairs < REPAIRS && r.work.mesh.triangle_count() <= most {
        let nodes: Vec<u32> = r.work.mesh.nodes().collect();
        let mut around: Vec<u32> =
            bad.iter().flat_map(|t| out.triangles[*t as usize]).map(|v| nodes[v as usize]).collect();
        around.sort_unstable();
        around.dedup();
        let before = r.want.clone();
        if !r.refine(&around, LEAST * options.sizing.size)? {
            break;
        }
        // What is good elsewhere stays as it is.
        let mut focus: Vec<bool> = r.want.iter().zip(&before).map(|(now, then)| now < then).collect();
        around.iter().for_each(|&v| focus[v as usize] = true);
        r.look_around(focus, AROUND);
        r.split_long()?;
        r.flip()?;
        r.relax()?;
        polish(&mut r, POLISH)?;
        r.look_everywhere();
        report.repairs += 1;
        out = finish(mesh, &r);
        bad = intersecting(&out, run)?;
    }
    // Who gives raw triangles can give them again with other sizes, and needs to know where it began.
    if let Some(first) = first.filter(|_| !bad.is_empty()) {
        (r, out, bad) = first;
    }
    if r.work.thaws && bad.is_empty() && !r.work.frozen.is_empty() {
        report.off = r.thaw()?;
        out = finish(mesh, &r);
        bad = intersecting(&out, run)?;
    }
    show("mend", &r);
    if narrow {
        report.astray = r.astray();
    }
    // What stays as it is was not folded here.
    let folded: Vec<u32> = r.folded().into_iter().filter(|t| !r.work.is_frozen(*t)).collect();
    (report.self_intersections, report.inverted) = (bad.len(), folded.len());
    report.faults = bad.iter().map(|t| Aabb::around(out.corners(*t as usize))).collect();
    report.faults.extend(folded.iter().map(|t| Aabb::around(r.work.mesh.corner_points(*t))));
    if r.work.raw {
        let m = &r.work.mesh;
        let inside = |t: u32| m.corners(t).into_iter().all(|v| r.rank[v as usize] == Rank::Face);
        let slim = m.triangles().filter(|&t| plain_shape(m.corner_points(t)) < SLIM && inside(t));
        report.slim = slim.map(|t| Aabb::around(m.corner_points(t))).collect();
    }
    let (seams, corners) = topology(&out, &r);
    let m = &r.work.mesh;
    let pieces = m.triangles().map(|t| r.work.patches[m.label(t) as usize].piece).collect();
    Ok((ExactMesh { mesh: out, seams, corners, pieces, report }, r))
}

/// Tells how much of the remesher's work is done, and how many triangles there are.
fn tell(r: &Remesher<'_>, done: f64) {
    r.run.progress("remesh", done);
    r.run.triangles(r.work.mesh.triangle_count());
}

/// Puts the nodes of borders that cutting left anywhere where they belong.
fn prepare_borders(r: &mut Remesher<'_>, narrow: bool, show: &mut dyn FnMut(&str, &Remesher<'_>)) -> Result<()> {
    // Inside the patches packing will put everything right.
    r.look_at_borders();
    r.collapse_short(TINY)?;
    for _ in 0..2 {
        r.flip()?;
        r.mend_worst(POOR, 1)?;
    }
    r.join_alike();
    show("untangle", r);
    tell(r, UNTANGLED);
    if narrow {
        // While there are nodes enough to see them by.
        r.look_at_bends()?;
    }
    space_borders(r)?;
    // Once: where leaves touch, each look finds something smaller.
    if narrow && r.look_at_borders_again()? {
        space_borders(r)?;
    }
    r.heed_tips()?;
    show("curves", r);
    Ok(())
}

fn space_borders(r: &mut Remesher<'_>) -> Result<()> {
    for _ in 0..SPACINGS {
        r.look_everywhere();
        let left = r.space_curves()?;
        r.join_alike();
        r.look_at_borders();
        r.flip()?;
        let limit = if r.work.raw { FLAT } else { POOR };
        for _ in 0..POLISH {
            if r.mend_worst(limit, 1)? == 0 {
                break;
            }
            r.flip()?;
        }
        if left == 0 {
            break;
        }
    }
    Ok(())
}

/// Borders inside faces and the corners of all borders, in the numbers of the finished mesh.
fn topology(out: &TriMesh, r: &Remesher<'_>) -> (Vec<[u32; 2]>, Vec<u32>) {
    let m = &r.work.mesh;
    let mut number = vec![NONE; m.node_capacity()];
    let mut corners = Vec::new();
    for (k, v) in m.nodes().enumerate() {
        number[v as usize] = k as u32;
        if r.rank[v as usize] == Rank::Corner {
            corners.push(k as u32);
        }
    }
    let mut order = vec![0; m.triangle_capacity()];
    m.triangles().enumerate().for_each(|(k, t)| order[t as usize] = k);
    let face = |h: u32| out.labels[order[(h / 3) as usize]];
    let seams = m
        .edges()
        .filter(|&h| m.is_sharp(h) && m.opposite(h) != NONE && face(h) == face(m.opposite(h)))
        .map(|h| [m.origin(h), m.target(h)].map(|v| number[v as usize]))
        .collect();
    (seams, corners)
}

/// Packs a patch; where that folds it, as near the tip of a cone, the nodes that are there are evened out instead.
fn remesh_patch(r: &mut Remesher<'_>) -> Result<()> {
    let before = r.clone();
    r.pack()?;
    even_out(r)?;
    let now = r.folded().len();
    let folded = if now > 0 { before.folded().len() } else { 0 };
    // A crease that nobody marked folds a few triangles only.
    if now > folded {
        r.mend_worst(POOR, POLISH)?;
        r.flip_and_move(POOR)?;
    }
    if r.folded().len() > folded {
        mend_folds(r)?;
    }
    if r.folded().len() > folded {
        *r = before;
        for _ in 0..PLAIN {
            r.collapse_short(SHORT)?;
            r.split_long()?;
            even_out(r)?;
        }
    }
    Ok(())
}

/// Evens out the nodes around what a packing folded; the rest of it stays.
fn mend_folds(r: &mut Remesher<'_>) -> Result<()> {
    let m = &r.work.mesh;
    let mut focus = vec![false; m.node_capacity()];
    r.folded().iter().flat_map(|t| m.corners(*t)).for_each(|v| focus[v as usize] = true);
    r.look_around(focus, FOLDED);
    for _ in 0..PLAIN {
        r.collapse_short(SHORT)?;
        r.split_long()?;
        r.flip()?;
        r.relax()?;
        r.mend_worst(POOR, POLISH)?;
    }
    r.look_everywhere();
    Ok(())
}

fn even_out(r: &mut Remesher<'_>) -> Result<()> {
    for _ in 0..LAST {
        r.flip_evenly()?;
        r.relax()?;
    }
    r.look_beyond_ends();
    for _ in 0..LAST {
        if r.share_below(EVEN) < UNEVEN || r.even_fans()? == 0 {
            break;
        }
        r.flip_evenly()?;
        r.relax()?;
    }
    r.look_everywhere();
    Ok(())
}

fn polish(r: &mut Remesher<'_>, rounds: usize) -> Result<()> {
    // Old nodes that found no way out.
    if r.work.raw {
        r.collapse_short(TINY)?;
    }
    for _ in 0..rounds {
        r.flip()?;
        r.relax()?;
    }
    r.mend_worst(MEND, POLISH)?;
    r.flip_and_move(STUCK)?;
    r.raise_angles()
}

/// Divides what is too far from the surface; taken back where triangles intersect then. Returns the mesh then and the triangles
/// of it that intersect others, where anything was divided.
fn nearer(names: &TriMesh, r: &mut Remesher<'_>, limit: f64) -> Result<Option<Tested>> {
    let list = r.beyond(limit);
    if list.is_empty() {
        return Ok(None);
    }
    let before = r.clone();
    if r.come_near(limit, list)? == 0 {
        return Ok(None);
    }
    let out = finish(names, r);
    let bad = intersecting(&out, r.run)?;
    if !bad.is_empty() {
        *r = before;
        return Ok(None);
    }
    Ok(Some((out, bad)))
}

/// Mends the worst triangles once more; taken back where more of them intersect then, as in a crevice they may. Returns the mesh
/// then and the triangles of it that intersect others, where that was looked at.
fn mend_slim(names: &TriMesh, r: &mut Remesher<'_>) -> Result<Option<Tested>> {
    let seen = r.seen();
    if r.worse_than(SLIM, &seen).is_empty() {
        return Ok(None);
    }
    let before = r.clone();
    let mend = |r: &mut Remesher<'_>| -> Result<()> {
        for _ in 0..SLIM_ROUNDS {
            r.mend_worst(SLIM, POLISH)?;
            r.flip_and_move(SLIM)?;
        }
        Ok(())
    };
    mend(r)?;
    if r.free_beside(SLIM) > 0 {
        mend(r)?;
    }
    let tested = |r: &Remesher<'_>| {
        let out = finish(names, r);
        intersecting(&out, r.run).map(|bad| (out, bad))
    };
    let mut now = tested(r)?;
    if !now.1.is_empty() {
        let then = tested(&before)?;
        if then.1.len() < now.1.len() {
            (*r, now) = (before, then);
        }
    }
    Ok(Some(now))
}

/// Those of some triangles that have no node at an open edge: where nodes stay, smaller edges help nothing.
fn away_from_ends(r: &Remesher<'_>, bad: Vec<u32>) -> Vec<u32> {
    let m = &r.work.mesh;
    let all: Vec<u32> = m.triangles().collect();
    bad.into_iter().filter(|t| !m.corners(all[*t as usize]).into_iter().any(|v| m.is_boundary(v))).collect()
}

/// Triangles that intersect others, ascending.
fn intersecting(mesh: &TriMesh, run: &Run) -> Result<Vec<u32>> {
    let mut bad: Vec<u32> = self_intersections(mesh, run)?.into_iter().flatten().collect();
    bad.sort_unstable();
    bad.dedup();
    Ok(bad)
}

/// The mesh with faces as labels.
fn finish(input: &TriMesh, r: &Remesher<'_>) -> TriMesh {
    let work: &EditMesh = &r.work.mesh;
    let mut out = work.to_mesh();
    out.labels = (0..out.triangles.len())
        .map(|t| {
            let p = out.centroid(t);
            let patch = &r.work.patches[out.labels[t] as usize];
            if patch.face != NONE {
                return patch.face;
            }
            let own = Some(patch.piece).filter(|&k| k != NONE);
            own.or_else(|| r.surface.piece_at(p)).and_then(|k| r.surface.face_at(k, p)).unwrap_or(0)
        })
        .collect();
    out.faces = input.faces.clone();
    out.groups = input.groups.clone();
    out
}
