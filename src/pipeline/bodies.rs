//! Remeshing the bodies of a boundary representation: faces keep their borders.

use rustc_hash::FxHashMap;

use super::body_ladder::{BodyLadder, BodyTrial, Ways};
use super::first_faces::First;
use super::ladder::Attempts;
use super::report::{FaceStep, Report, Rung};
use crate::error::Result;
use crate::geometry::Pieces;
use crate::mesh::{EditMesh, TriMesh};
use crate::numeric::{ROUNDING, Sets};
use crate::parametric::Parametric;
use crate::parametric::mesh::{FaceMeshes, Place};
use crate::quality::Fault;
use crate::remesh::{Patchwork, PiecePatch, PieceSet, Policy, RemeshOptions, asked_triangles};
use crate::run::Run;

/// How many things of one kind a report names.
pub(super) const NAMED: usize = 20;

/// With more triangles than this the time of remeshing counts: faces that have got [`CROWDED`] times as many as their size
/// asks for then stay as they are.
const MANY: usize = 400_000;
/// Tubes thinner than a tenth of the size have so many.
const CROWDED: f64 = 16.0;
/// Nodes of borders want edges of no less than this share of what was asked for there: edges that are followed, and parts of
/// longer ones, are that long at least.
const WHOLE: f64 = 0.5;
/// The area of a triangle with sides of length one.
pub(super) const EQUILATERAL: f64 = 0.433;

/// Bodies, put together.
pub(super) struct Bodies {
    pub(super) mesh: TriMesh,
    /// How many triangles cross others, where that is known.
    pub(super) crossing: Option<usize>,
    pub(super) report: Report,
    /// The attempts they are of.
    pub(super) numbers: Vec<usize>,
}

/// Remeshes every body of what was triangulated, within a distance from the faces, and puts them together.
pub(super) fn remeshed(
    solid: &Parametric,
    first: First,
    limit: f64,
    attempts: &mut Attempts,
    run: &Run,
) -> Result<Bodies> {
    let options = RemeshOptions { distance: Some(limit), ..RemeshOptions::new(first.sizing, first.grading) };
    let First { made, mut report, number, .. } = first;
    let FaceMeshes { mut mesh, pieces, mut places, mut sizes, fans, .. } = made;
    mesh.labels = pieces;
    split_fans(&mut mesh, &mut places, &mut sizes);
    let of = |t: usize| asked_triangles(mesh.area_vector(t).length(), mesh.triangles[t].map(|v| sizes[v as usize]));
    run.expect((0..mesh.triangles.len()).map(of).sum::<f64>())?;
    let marks = Marks::new(solid, fans, crowded(solid, &mesh, options.sizing.size));
    let crowded = &marks.still;
    // Bodies that do not touch in any node know nothing of each other: whether they overlap is the model's affair.
    let parts = components(&mesh);
    let names = mesh.faces;
    drop((mesh.nodes, mesh.triangles, mesh.labels));
    let trial = |(part, nodes): (TriMesh, Vec<u32>)| {
        let places: Vec<Place> = nodes.iter().map(|v| places[*v as usize]).collect();
        let sizes: Vec<f64> = nodes.iter().map(|v| sizes[*v as usize]).collect();
        BodyTrial::new(part, places, sizes, crowded)
    };
    let bodies: Vec<BodyTrial> = parts.into_iter().map(trial).collect();
    let count = bodies.len();
    let ways = Ways { solid, marks: &marks, options: &options };
    let results = BodyLadder::new(ways, report.size, bodies).remeshed(attempts, run)?;
    let mut all = TriMesh { faces: names, ..TriMesh::default() };
    let mut kept: Vec<u32> = Vec::new();
    let mut numbers = vec![number];
    let (mut crossing, mut stayed) = (None, 0);
    for part in results {
        crossing = (count == 1 && part.sound).then_some(0);
        numbers.push(part.number);
        if let Some(reason) = part.shortfall {
            let fault = Fault::FirstTriangulation { reason };
            let why = fault.to_string();
            let mut faces = part.mesh.labels.clone();
            faces.sort_unstable();
            faces.dedup();
            report
                .ladder
                .extend(faces.into_iter().map(|f| FaceStep::of(solid, f, Rung::FirstTriangulation, why.clone())));
            report.shortfalls.push(fault);
        }
        for f in part.dropped {
            let face = &solid.brep.faces[f as usize];
            let why = "however it is triangulated its triangles cross others, or double their edges";
            let (name, source, reason) = (face.name.clone(), face.source, why.to_string());
            report.shortfalls.push(Fault::NoMesh { face: name, source, surface: None, reason });
            report.ladder.push(FaceStep::of(solid, f, Rung::None, why.into()));
        }
        kept.extend(part.kept);
        stayed += part.stayed;
        let start = all.nodes.len() as u32;
        all.nodes.extend(part.mesh.nodes);
        all.triangles.extend(part.mesh.triangles.iter().map(|t| t.map(|v| v + start)));
        all.labels.extend(part.mesh.labels);
    }
    kept.sort_unstable();
    kept.dedup();
    kept.retain(|f| crowded.binary_search(f).is_err());
    if !crowded.is_empty() {
        let why = "too thin for its size: remeshing its triangles would take too long";
        report
            .warnings
            .push(format!("{} faces are left as first triangulated: there are too many triangles", crowded.len()));
        report.ladder.extend(crowded.iter().map(|f| FaceStep::of(solid, *f, Rung::FirstTriangulation, why.into())));
    }
    if stayed > 0 {
        report
            .warnings
            .push(format!("{stayed} triangles stay as first triangulated: remeshed they would cross others"));
    }
    if !kept.is_empty() {
        let names: Vec<&str> = kept.iter().take(NAMED).map(|f| all.faces[*f as usize].as_str()).collect();
        let names = names.join(", ");
        report.warnings.push(format!("{} faces are left as first triangulated: {names}", kept.len()));
        let why = "remeshed, its triangles intersect others";
        report.ladder.extend(kept.iter().map(|f| FaceStep::of(solid, *f, Rung::FirstTriangulation, why.into())));
    }
    all.drop_unused_nodes();
    numbers.sort_unstable();
    numbers.dedup();
    Ok(Bodies { mesh: all, crossing, report, numbers })
}

/// Faces that make a mesh far larger than the size asks for, where it is a large one, ascending.
fn crowded(solid: &Parametric, mesh: &TriMesh, size: f64) -> Vec<u32> {
    if mesh.triangles.len() < MANY {
        return Vec::new();
    }
    let mut sums = vec![(0usize, 0.0); solid.brep.faces.len()];
    for (t, l) in mesh.labels.iter().enumerate() {
        let sum = &mut sums[solid.face_of(*l) as usize];
        *sum = (sum.0 + 1, sum.1 + 0.5 * mesh.area_vector(t).length());
    }
    let many = |s: &(usize, f64)| s.0 as f64 > CROWDED * s.1 / (EQUILATERAL * size * size);
    (0..sums.len() as u32).filter(|f| many(&sums[*f as usize])).collect()
}

/// The sizes, at nodes of borders those the border was divided by: whole numbers of parts make edges up to half as long
/// again as asked for, or as short, and rows beside them shall fit. Edges of the model too short to be followed are one part
/// that is shorter still: rows that fit them would be many, and end at needles all the same.
fn as_spaced(part: &TriMesh, sizes: &[f64]) -> Vec<f64> {
    // Sum of lengths and number of the edges of borders at every node, each edge seen from both sides.
    let mut sums = vec![(0.0, 0u32); part.nodes.len()];
    let mut faces: FxHashMap<[u32; 2], u32> = FxHashMap::default();
    for (t, l) in part.triangles.iter().zip(&part.labels) {
        for k in 0..3 {
            let (a, b) = (t[k], t[(k + 1) % 3]);
            let other = faces.insert([a.min(b), a.max(b)], *l);
            if other.is_some_and(|o| o != *l) {
                let length = part.nodes[a as usize].distance(part.nodes[b as usize]);
                for v in [a, b] {
                    sums[v as usize].0 += length;
                    sums[v as usize].1 += 1;
                }
            }
        }
    }
    let own = |(h, s): (&f64, &(f64, u32))| if s.1 > 0 { (s.0 / f64::from(s.1)).max(WHOLE * h) } else { *h };
    sizes.iter().zip(&sums).map(own).collect()
}

/// The connected parts of a mesh, each with the old numbers of its nodes.
pub(super) fn components(mesh: &TriMesh) -> Vec<(TriMesh, Vec<u32>)> {
    let body = mesh.bodies();
    let mut number = vec![u32::MAX; mesh.nodes.len()];
    let mut place = vec![u32::MAX; mesh.nodes.len()];
    let mut parts: Vec<(TriMesh, Vec<u32>)> = Vec::new();
    for ((t, label), l) in mesh.triangles.iter().zip(&mesh.labels).zip(body) {
        let l = l as usize;
        if number[l] == u32::MAX {
            number[l] = parts.len() as u32;
            parts.push((TriMesh { faces: mesh.faces.clone(), ..TriMesh::default() }, Vec::new()));
        }
        let (part, nodes) = &mut parts[number[l] as usize];
        for v in t {
            if place[*v as usize] == u32::MAX {
                place[*v as usize] = nodes.len() as u32;
                nodes.push(*v);
                part.nodes.push(mesh.nodes[*v as usize]);
            }
        }
        part.triangles.push(t.map(|v| place[v as usize]));
        part.labels.push(*label);
    }
    parts
}

/// What holds nodes and edges in their places.
pub(super) struct Marks {
    corners: Vec<bool>,
    seams: Vec<bool>,
    tips: FxHashMap<u32, Vec<glam::DVec3>>,
    /// Tips whose triangles stay.
    fans: FxHashMap<u32, Vec<glam::DVec3>>,
    near: f64,
    /// Faces that are not remeshed at all, ascending.
    pub(super) still: Vec<u32>,
}

impl Marks {
    fn new(solid: &Parametric, fans: Vec<(u32, glam::DVec3)>, still: Vec<u32>) -> Self {
        let by_face = |list: Vec<(u32, glam::DVec3)>| {
            let mut out: FxHashMap<u32, Vec<glam::DVec3>> = FxHashMap::default();
            list.into_iter().for_each(|(f, p)| out.entry(f).or_default().push(p));
            out
        };
        let (tips, fans) = (by_face(solid.tips()), by_face(fans));
        // A node this near to a point without a normal is on it.
        let near = ROUNDING * solid.bounds().diagonal();
        Self { corners: solid.corners(), seams: solid.creased_seams(), tips, fans, near, still }
    }
}

/// A body before remeshing.
#[derive(Default)]
pub(super) struct FirstBody {
    pub(super) part: TriMesh,
    /// Where on the model each node is,
    pub(super) places: Vec<Place>,
    /// and the edge length it wants.
    pub(super) sizes: Vec<f64>,
}

/// What of a body stays as it was first triangulated.
#[derive(Clone, Copy)]
pub(super) struct Untouched<'a> {
    /// Faces, ascending,
    pub(super) faces: &'a [u32],
    /// and whether each triangle does.
    pub(super) triangles: &'a [bool],
}

/// The mesh with what the remesher needs: borders are sharp, corners pinned, every node knows its faces.
pub(super) fn patchwork(
    solid: &Parametric,
    marks: &Marks,
    mut mesh: EditMesh,
    body: &FirstBody,
    untouched: Untouched<'_>,
) -> Patchwork {
    let FirstBody { part: from, places, sizes } = body;
    let sizes = as_spaced(from, sizes);
    let Untouched { faces: kept, triangles: stays } = untouched;
    let mut sets = vec![PieceSet::default(); from.nodes.len()];
    for (t, l) in from.triangles.iter().zip(&from.labels) {
        for v in t {
            sets[*v as usize] = sets[*v as usize].union(&PieceSet::one(*l));
        }
    }
    let is_at = |tips: &FxHashMap<u32, Vec<glam::DVec3>>, piece: u32, v: usize| {
        let of_face = tips.get(&solid.face_of(piece));
        of_face.is_some_and(|l| l.iter().any(|p| p.distance(from.nodes[v]) <= marks.near))
    };
    // Patches beyond the pieces are fans and other triangles of theirs that stay.
    let count = solid.piece_count();
    let some = !marks.fans.is_empty() || stays.contains(&true);
    if some {
        for (t, (nodes, l)) in from.triangles.iter().zip(&from.labels).enumerate() {
            if stays[t] || nodes.iter().any(|v| is_at(&marks.fans, *l, *v as usize)) {
                mesh.set_surface(t as u32, count + l, glam::DVec3::ZERO);
            }
        }
    }
    for h in 0..3 * mesh.triangle_capacity() as u32 {
        let o = mesh.opposite(h);
        if o == crate::mesh::edit::NONE || mesh.label(h / 3) != mesh.label(o / 3) {
            mesh.set_sharp(h, true);
        }
    }
    let on_seam = |v: u32| match places[v as usize] {
        Place::Edge(e) => marks.seams[e as usize].then_some(e),
        _ => None,
    };
    let ends = |v: u32, e: u32| match places[v as usize] {
        Place::Edge(f) => e == f,
        Place::Vertex(x) => solid.brep.edges[e as usize].ends.contains(&x),
        Place::Face(_) => false,
    };
    for h in 0..3 * mesh.triangle_capacity() as u32 {
        let (a, b) = (mesh.origin(h), mesh.target(h));
        if on_seam(a).or(on_seam(b)).is_some_and(|e| ends(a, e) && ends(b, e)) {
            mesh.set_sharp(h, true);
            mesh.set_pinned(a, true);
            mesh.set_pinned(b, true);
        }
    }
    for (v, place) in places.iter().enumerate() {
        let pinned = match *place {
            Place::Vertex(x) => {
                marks.corners[x as usize] || sets[v].as_slice().iter().any(|f| is_at(&marks.tips, *f, v))
            }
            Place::Face(f) => is_at(&marks.tips, f, v),
            Place::Edge(_) => false,
        };
        if pinned {
            mesh.set_pinned(v as u32, true);
        }
    }
    let patches = (0..count * if some { 2 } else { 1 })
        .map(|f| f % count)
        .map(|f| PiecePatch {
            piece: f,
            outward: if solid.brep.faces[solid.face_of(f) as usize].outward { 1.0 } else { -1.0 },
            plane: solid.plane(f),
            face: u32::MAX,
        })
        .collect();
    let is_kept = |piece: u32| kept.binary_search(&solid.face_of(piece)).is_ok();
    for (t, l) in from.triangles.iter().zip(&from.labels) {
        if is_kept(*l) {
            t.iter().for_each(|v| mesh.set_pinned(*v, true));
        }
    }
    let mut frozen: Vec<u32> = (0..count).filter(|p| is_kept(*p)).collect();
    if some {
        frozen.extend(count..2 * count);
    }
    Patchwork { sizes, policy: Policy::of_faces(), frozen, ..Patchwork::new(mesh, sets, patches) }
}

/// Gives every fan of triangles around a node a node of its own: solids may touch themselves in a vertex.
pub(super) fn split_fans(mesh: &mut TriMesh, places: &mut Vec<Place>, sizes: &mut Vec<f64>) {
    // Triangles of a node that share an edge at it are of one fan: union-find over corners.
    let corners = 3 * mesh.triangles.len();
    let mut fans = Sets::new(corners);
    let mut seen: FxHashMap<[u32; 2], [u32; 2]> = FxHashMap::default();
    for (t, nodes) in mesh.triangles.iter().enumerate() {
        for k in 0..3 {
            let (i, j) = (3 * t + k, 3 * t + (k + 1) % 3);
            let (a, b) = (nodes[k], nodes[(k + 1) % 3]);
            // Corners at the smaller and the larger node.
            let own = if a < b { [i as u32, j as u32] } else { [j as u32, i as u32] };
            match seen.get(&[a.min(b), a.max(b)]) {
                Some(other) => {
                    fans.join(own[0], other[0]);
                    fans.join(own[1], other[1]);
                }
                None => {
                    seen.insert([a.min(b), a.max(b)], own);
                }
            }
        }
    }
    let mut first: Vec<u32> = vec![u32::MAX; mesh.nodes.len()];
    let mut copy: FxHashMap<u32, u32> = FxHashMap::default();
    for c in 0..corners {
        let l = fans.find(c as u32);
        let v = mesh.triangles[c / 3][c % 3];
        if first[v as usize] == u32::MAX {
            first[v as usize] = l;
        }
        if first[v as usize] != l {
            let new = *copy.entry(l).or_insert_with(|| {
                mesh.nodes.push(mesh.nodes[v as usize]);
                places.push(places[v as usize]);
                sizes.push(sizes[v as usize]);
                mesh.nodes.len() as u32 - 1
            });
            mesh.triangles[c / 3][c % 3] = new;
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::optimize::size::GRADATION;
    use crate::parametric::Frame;
    use crate::parametric::build::{Extrusion, Wire, extrude_edges};
    use crate::parametric::mesh::MeshSizes;
    use crate::pipeline::body_ladder::stay_around;
    use crate::remesh::{RemeshTarget, remesh_patchwork};
    use crate::sizing::Sizing;
    use crate::spatial::Aabb;

    #[test]
    fn triangles_that_stay_do_and_the_rest_of_their_faces_is_remeshed() {
        let run = Run::new();
        let circle = Wire::circle(Frame::WORLD, 1.0).unwrap();
        let solid = Parametric::new(extrude_edges(&[circle], &Extrusion::new(DVec3::Z, 2.0)).unwrap(), &run).unwrap();
        let size = 0.2f64;
        let by = move |k: f64| size.min(0.35 / k.max(1e-300));
        let FaceMeshes { mesh: mut part, pieces, places, sizes, fans, .. } =
            solid.mesh(&MeshSizes::new(size, size / 4.0, &by), &run).unwrap();
        part.labels = pieces;
        // As if one triangle of the wall crossed others.
        let wall = |t: &usize| part.centroid(*t).distance(DVec3::new(1.0, 0.0, 1.0)) < 0.3;
        let bad = (0..part.triangles.len()).find(wall).unwrap() as u32;
        let at = [Aabb::around(part.corners(bad as usize))];
        let mut stays = vec![false; part.triangles.len()];
        assert!(stay_around(&mut stays, &at, &part, 1.0) && stays[bad as usize]);
        assert!(!stay_around(&mut stays.clone(), &at, &part, 1.0), "there are no more of them");
        assert!(!stay_around(&mut stays.clone(), &at, &part, 100.0), "there are too many");

        let marks = Marks::new(&solid, fans, Vec::new());
        let edit = EditMesh::new(&part).unwrap();
        let body = FirstBody { part, places, sizes };
        let work = patchwork(&solid, &marks, edit, &body, Untouched { faces: &[], triangles: &stays });
        let part = body.part;
        let sizing = Sizing { size, nodes_per_radius: None, chord: None, least: size / 4.0 };
        let options = RemeshOptions::new(sizing, GRADATION);
        let target = RemeshTarget { surface: &solid, names: &part };
        let made = remesh_patchwork(work, target, &options, &run, None).unwrap();
        assert_eq!(made.report.self_intersections, 0);
        let d = made.mesh.defects();
        assert!(d.is_closed() && d.is_manifold() && d.is_oriented());
        let key = |m: &TriMesh, t: usize| {
            let mut c = m.corners(t).map(|p| p.to_array().map(f64::to_bits));
            c.sort_unstable();
            c
        };
        let now: std::collections::BTreeSet<_> = (0..made.mesh.triangles.len()).map(|t| key(&made.mesh, t)).collect();
        let mut moved = 0;
        for t in 0..part.triangles.len() {
            let there = now.contains(&key(&part, t));
            assert!(there || !stays[t]);
            moved += usize::from(!there);
        }
        assert!(2 * moved > part.triangles.len(), "{moved} of {}", part.triangles.len());
        let worst = (0..made.mesh.triangles.len())
            .map(|t| made.mesh.corners(t))
            .map(|c| crate::optimize::guard::sharpest_cosine(c).acos().to_degrees())
            .fold(f64::INFINITY, f64::min);
        assert!(worst > 20.0, "{worst}");
    }
}
