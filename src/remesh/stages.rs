//! The stages a patchwork goes through: lengths, borders, filling, polish, mending, and what is told of it.

use super::judge::{Judge, plain_shape};
use super::open::polish_beyond_ends;
use super::policy::Filling;
use super::remesher::{Rank, Remesher, SHORT};
use super::{Observer, RemeshReport, RemeshedMesh};
use crate::error::Result;
use crate::mesh::edit::{ChangeReader, NONE};
use crate::mesh::{EditMesh, TriMesh, intersecting_triangles};
use crate::sizing::TINY;
use crate::spatial::Aabb;

/// How often borders are spaced: what is in the way of a node at first may be gone later.
const SPACINGS: usize = 3;
/// Nodes are taken out and put in for the sake of even angles where too many of a patch's triangles have a shape below this, that of 45
/// degrees between equal sides: packing leaves fewer where there is room.
const EVEN: f64 = 0.93;
/// Too many are more than this share.
const UNEVEN: f64 = 0.025;
/// Rounds of flips and relaxation after packing, and of those across borders after that.
pub(super) const LAST: usize = 2;
/// The same where places were refined; also the passes of mending triangles one by one.
pub(super) const POLISH: usize = 4;
/// Shapes below this are what cutting and spacing leave where things are tight: 7 degrees.
const POOR: f64 = 0.2;
/// A triangle of a smaller shape than this is flat: its height is below 3 % of its length. Once borders of raw triangles are spaced only such
/// ones are mended: packing leaves few of the others.
pub(super) const FLAT: f64 = 0.05;
/// Rounds of split, collapse, flip and relaxation where a packing folds.
const PLAIN: usize = 3;
/// Edges around folds up to which they are.
const FOLDED: usize = 4;
/// Shapes below this are mended one by one: 45 degrees.
pub(super) const MEND: f64 = 0.95;
/// Shapes below this that are left then take more than one step to mend: 35 degrees.
pub(super) const STUCK: f64 = 0.8;
/// Shapes below this are mended once more: 20 degrees.
pub(super) const SLIM: f64 = 0.55;
/// How often they are.
const SLIM_ROUNDS: usize = 2;
/// How often the surroundings of triangles that intersect are refined.
const REPAIRS: usize = 4;
/// Edges around such places up to which nodes are looked at.
pub(super) const AROUND: usize = 2;
/// Surroundings are not refined when more than one triangle in this many intersects others. Where packing left some folded, each counts as
/// so many: where more are, lengths do not fit the surface, as on a rim far narrower than the least size. Of a ribbon around a helix one in
/// seven was folded, and mending them took a minute in vain.
const FEW: usize = 4;
/// Refinement of such places stops at this share of the size.
const LEAST: f64 = 1.0 / 16.0;

/// How far the work is.
#[derive(Clone, Copy)]
pub(super) enum Reached {
    /// Nothing is done.
    Start,
    /// Lengths are known.
    Sizes,
    /// What the cut folded is untangled.
    Untangled,
    /// Nodes of borders are in their places.
    Borders,
    /// Patches are packed.
    Packed,
    /// What is poor has been mended.
    Polished,
}

impl Reached {
    /// The share of the time that has passed, roughly.
    pub(super) fn share(self) -> f64 {
        match self {
            Reached::Start => 0.0,
            Reached::Sizes => 0.1,
            Reached::Untangled => 0.2,
            Reached::Borders => 0.3,
            Reached::Packed => 0.75,
            Reached::Polished => 0.95,
        }
    }
}

/// A mesh as it is, and the triangles of it that intersect others, ascending.
#[derive(Clone)]
struct Tested {
    mesh: TriMesh,
    bad: Vec<u32>,
    /// Whether lengths do not fit the surface: nothing of it is worth being worked on.
    is_hopeless: bool,
}

/// Whether so few of all triangles are at fault that they are worth being worked on.
fn is_few(faults: usize, all: usize) -> bool {
    FEW * faults <= all
}

impl Tested {
    fn of(names: &TriMesh, r: &Remesher<'_>) -> Result<Self> {
        let mesh = finish(names, r);
        let bad = intersecting_triangles(&mesh, r.run)?;
        Ok(Self { mesh, bad, is_hopeless: false })
    }

    /// Whether some triangles intersect others, so few that their surroundings are worth being refined.
    fn is_few(&self) -> bool {
        !self.is_hopeless && !self.bad.is_empty() && is_few(self.bad.len(), self.mesh.triangles.len())
    }
}

/// Remeshes a patchwork, stage after stage; `names` lends the names of faces.
pub(super) fn remesh<'a>(
    names: &TriMesh,
    mut r: Remesher<'a>,
    mut observer: Option<&mut Observer<'_>>,
) -> Result<(RemeshedMesh, Remesher<'a>)> {
    let mut show = |name: &str, r: &Remesher<'_>| {
        if let Some(o) = &mut observer {
            o(name, &finish(names, r));
        }
    };
    prepare(&mut r, &mut show)?;
    tell(&r, Reached::Borders);
    match r.work.policy.filling {
        Filling::Mended => r.each_part(remesh_patch)?,
        Filling::Front => r.each_patch(|r| r.pack())?,
        Filling::Random => r.each_patch(|r| r.scatter())?,
    }
    show("pack", &r);
    tell(&r, Reached::Packed);
    let tested = polished(names, &mut r)?;
    tell(&r, Reached::Polished);
    let mut report = RemeshReport::default();
    let mut tested = refined(names, &mut r, tested, &mut report)?;
    if r.work.policy.thaws && tested.bad.is_empty() && !r.work.frozen.is_empty() {
        report.off = r.thaw()?;
        tested = Tested::of(names, &r)?;
    }
    show("mend", &r);
    tell_faults(&r, &tested, &mut report);
    let mesh = tested.mesh;
    let (seams, corners) = topology(&mesh, &r);
    let m = &r.work.mesh;
    let pieces = m.triangles().map(|t| r.work.patches[m.label(t) as usize].piece).collect();
    Ok((RemeshedMesh { mesh, seams, corners, pieces, report }, r))
}

/// Asks for lengths, and puts borders where they belong.
fn prepare(r: &mut Remesher<'_>, show: &mut dyn FnMut(&str, &Remesher<'_>)) -> Result<()> {
    let policy = r.work.policy;
    r.merge_doubles();
    tell(r, Reached::Start);
    r.ask_sizes(policy.narrow)?;
    tell(r, Reached::Sizes);
    show("cut", r);
    if policy.is_raw() {
        r.even_sizes()?;
        show("even", r);
    }
    if !policy.spaced {
        if !policy.goes_on {
            r.run.expect(r.expected_triangles())?;
        }
        prepare_borders(r, show)?;
    }
    r.look_everywhere();
    Ok(())
}

/// Makes the shapes of packed triangles better, and divides what is too far from the surface.
fn polished(names: &TriMesh, r: &mut Remesher<'_>) -> Result<Tested> {
    let policy = r.work.policy;
    if policy.filling != Filling::Mended {
        return Ok(Tested { mesh: finish(names, r), bad: Vec::new(), is_hopeless: false });
    }
    // From here on triangles lie as near to the surface as their size lets them.
    if policy.is_raw() {
        r.work.policy.judge = Judge::Angles;
        r.work.mesh.set_all_changed();
    }
    let folded = r.folded().len();
    if folded > 0 {
        let tested = Tested::of(names, r)?;
        if !is_few(FEW * folded.max(tested.bad.len()), r.work.mesh.triangle_count()) {
            return Ok(Tested { is_hopeless: true, ..tested });
        }
    }
    polish_beyond_ends(r)?;
    let mut tested = None;
    if let Some(limit) = r.options.distance {
        tested = nearer(names, r, limit)?;
    }
    if policy.is_raw() {
        tested = mend_slim(names, r)?;
    }
    if let Some(known) = tested {
        return Ok(known);
    }
    let mut tested = Tested::of(names, r)?;
    if policy.goes_on {
        tested.bad = away_from_ends(r, tested.bad);
    }
    Ok(tested)
}

/// Refines the surroundings of triangles that intersect others, where these are few, as long as fewer are left. Chords that cross come apart by
/// that; where the surfaces themselves lie on each other each round makes more.
fn refined(names: &TriMesh, r: &mut Remesher<'_>, mut tested: Tested, report: &mut RemeshReport) -> Result<Tested> {
    let is_raw = r.work.policy.is_raw();
    let first = is_raw.then(|| (r.clone(), tested.clone()));
    while tested.is_few() && report.repairs < REPAIRS {
        let nodes: Vec<u32> = r.work.mesh.nodes().collect();
        let corners = tested.bad.iter().flat_map(|t| tested.mesh.triangles[*t as usize]);
        let mut around: Vec<u32> = corners.map(|v| nodes[v as usize]).collect();
        around.sort_unstable();
        around.dedup();
        if !refine_around(r, &around)? {
            break;
        }
        report.repairs += 1;
        let before = tested.bad.len();
        tested = Tested::of(names, r)?;
        if tested.bad.len() >= before {
            break;
        }
    }
    // Who gives raw triangles can give them again with other sizes, and needs to know where it began.
    if let Some((then, known)) = first.filter(|_| !tested.bad.is_empty()) {
        (*r, tested) = (then, known);
    }
    Ok(tested)
}

/// Makes edges around some nodes shorter; what is good elsewhere stays as it is. Whether any were.
fn refine_around(r: &mut Remesher<'_>, around: &[u32]) -> Result<bool> {
    let before = r.want.clone();
    if !r.refine(around, LEAST * r.options.sizing.size)? {
        return Ok(false);
    }
    let mut focus: Vec<bool> = r.want.iter().zip(&before).map(|(now, then)| now < then).collect();
    around.iter().for_each(|&v| focus[v as usize] = true);
    r.look_around(focus, AROUND);
    r.split_long()?;
    r.flip()?;
    r.relax()?;
    polish(r, POLISH)?;
    r.look_everywhere();
    Ok(true)
}

/// Puts into the report what is at fault, and where.
fn tell_faults(r: &Remesher<'_>, tested: &Tested, report: &mut RemeshReport) {
    let (policy, m) = (r.work.policy, &r.work.mesh);
    if policy.narrow {
        report.astray = r.astray();
    }
    // What stays as it is was not folded here.
    let folded: Vec<u32> = r.folded().into_iter().filter(|t| !r.work.is_frozen(*t)).collect();
    (report.self_intersections, report.inverted) = (tested.bad.len(), folded.len());
    report.faults = tested.bad.iter().map(|t| Aabb::around(tested.mesh.corners(*t as usize))).collect();
    report.faults.extend(folded.iter().map(|t| Aabb::around(m.corner_points(*t))));
    if policy.is_raw() {
        let inside = |t: u32| m.corners(t).into_iter().all(|v| r.rank[v as usize] == Rank::Face);
        let slim = m.triangles().filter(|&t| plain_shape(m.corner_points(t)) < SLIM && inside(t));
        report.slim = slim.map(|t| Aabb::around(m.corner_points(t))).collect();
    }
}

/// Tells how much of the remesher's work is done, and how many triangles there are.
fn tell(r: &Remesher<'_>, reached: Reached) {
    r.run.progress("remesh", reached.share());
    r.run.triangles(r.work.mesh.triangle_count());
}

/// Puts the nodes of borders that cutting left anywhere where they belong.
fn prepare_borders(r: &mut Remesher<'_>, show: &mut dyn FnMut(&str, &Remesher<'_>)) -> Result<()> {
    let narrow = r.work.policy.narrow;
    // Inside the patches packing will put everything right.
    r.look_at_borders();
    r.collapse_short(TINY)?;
    for _ in 0..2 {
        r.flip()?;
        r.mend_worst(POOR, 1)?;
    }
    r.join_alike();
    show("untangle", r);
    tell(r, Reached::Untangled);
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
    r.work.mesh.set_none_seen(ChangeReader::Mending);
    for _ in 0..SPACINGS {
        r.look_everywhere();
        let left = r.space_curves()?;
        r.join_alike();
        r.look_at_borders();
        r.flip()?;
        let limit = if r.work.policy.is_raw() { FLAT } else { POOR };
        for _ in 0..POLISH {
            if r.mend_changed(limit)? == 0 {
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
    if now > folded && is_few(FEW * now, r.work.mesh.triangle_count()) {
        r.mend_worst(POOR, POLISH)?;
        r.flip_and_move(POOR)?;
        if r.folded().len() > folded {
            mend_folds(r)?;
        }
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

pub(super) fn polish(r: &mut Remesher<'_>, rounds: usize) -> Result<()> {
    // Old nodes that found no way out.
    if r.work.policy.is_raw() {
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

/// Divides what is too far from the surface; taken back where triangles intersect then. What was tested, where anything was divided.
fn nearer(names: &TriMesh, r: &mut Remesher<'_>, limit: f64) -> Result<Option<Tested>> {
    let list = r.beyond(limit);
    if list.is_empty() {
        return Ok(None);
    }
    let before = r.clone();
    if r.come_near(limit, list)? == 0 {
        return Ok(None);
    }
    let tested = Tested::of(names, r)?;
    if !tested.bad.is_empty() {
        *r = before;
        return Ok(None);
    }
    Ok(Some(tested))
}

/// Mends the worst triangles once more; taken back where more of them intersect then, as in a crevice they may. What was
/// tested, where anything was mended.
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
    let mut now = Tested::of(names, r)?;
    if !now.bad.is_empty() {
        let then = Tested::of(names, &before)?;
        if then.bad.len() < now.bad.len() {
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

/// The mesh with faces as labels.
pub(super) fn finish(input: &TriMesh, r: &Remesher<'_>) -> TriMesh {
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
