//! One face of a finished mesh made anew at another size, between the borders it has.

use std::sync::Arc;

use glam::DVec3;
use rustc_hash::{FxHashMap, FxHashSet};

use super::bricks::{fans_apart, open_nodes};
use super::history::Clock;
use super::mesh::{Meshed, too_far};
use super::source::{Measured, MeshOrigin, cell, of_faces, of_functions, of_triangles};
use crate::discrete::Discrete;
use crate::error::{Error, Place, Result, nearest};
use crate::geometry::Pieces;
use crate::implicit::{Implicit, ImplicitOracle};
use crate::mesh::TriMesh;
use crate::mesh::sides::sides;
use crate::numeric::{NONE, Sets};
use crate::parametric::Parametric;
use crate::quality::Fault;
use crate::remesh::{InPieces, Judge, RemeshOptions, RemeshedMesh, patch_open_pieces, remesh_open};
use crate::run::Run;
use crate::spatial::{Aabb, NodeTree};

/// A size that asks for more triangles than this on one face is in another unit: no memory would hold what comes of it.
const MOST: f64 = 2e7;
/// A node lies on a surface if it is nearer to it than this share of the diagonal: where surfaces touch nodes are known to the root of the
/// rounding only, and nodes where a solid touches itself are drawn back by a billionth.
const ON: f64 = 1e-7;

fn bits(p: DVec3) -> [u64; 3] {
    p.to_array().map(f64::to_bits)
}

fn key(a: u32, b: u32) -> [u32; 2] {
    [a.min(b), a.max(b)]
}

impl Meshed {
    /// Meshes one face anew with edges of length `size`, in the part's unit, and leaves all others as they are.
    ///
    /// Curvature, and the lengths of the edges on the face's border, may ask for shorter edges, as they do in
    /// [`mesh_part`](super::mesh_part). A size the part asks for on the face is passed over.
    ///
    /// The surface is that of what was meshed: leaves of a solid of R-functions, faces of a CAD model or of a solid built from edges,
    /// faces that were found in triangles, which are the input's triangles there.
    ///
    /// *Guarantees*: nodes and triangles of other faces keep their places bit by bit and their order; so do the nodes and edges
    /// of the face's border. Inner nodes and triangles of the face come last. Every new node lies on the face's own surfaces, to
    /// rounding. Names and groups stay; the report's check is made anew, of what it was made of before. The answer does not
    /// depend on the number of threads. On error nothing has changed.
    /// *Does not guarantee*: that triangles do not intersect those of other faces: the report tells. Creases within a face of
    /// triangles need not keep their nodes: new ones lie on the same creases.
    ///
    /// # Errors
    /// [`Error::Usage`] for a name no face has, with the nearest one and all there are; for a size that is not positive, or far too
    /// small; for meshes that were healed, joined of several solids or made brick by brick, and for plane figures.
    /// [`Error::Input`] for a face that does not lie on one surface between its borders, as by methods without exact edges, and for
    /// a face of a CAD model with creases inside. [`Error::Failed`] where the border could not be kept; [`Error::Cancelled`].
    ///
    /// *Source*: the fragments of \[LAZ\], which change one by one.
    pub fn remesh_face(&mut self, name: &str, size: f64, run: &Run) -> Result<()> {
        let Some(face) = self.mesh.faces.iter().position(|f| f == name) else {
            let known = || self.mesh.faces.iter().map(String::as_str);
            let near = nearest(name, known()).map_or_else(String::new, |n| format!("; the nearest name is {n:?}"));
            let names = self.mesh.faces.join(", ");
            return Err(Error::Usage(format!("no face is called {name:?}{near}; there are {names}")));
        };
        let source = self.source.clone();
        if let MeshOrigin::Unknown(what) = &source {
            let what = format!("a face is meshed anew on the surface of what was meshed, and this mesh {what}");
            return Err(Error::Usage(what));
        }
        let alone = Alone::new(self, face as u32)?;
        let asked = alone.mesh.area() / (size * size);
        if !(size.is_finite() && size > 0.0 && asked < MOST) {
            let what = format!(
                "edges of length {size} cannot be had on the face {name:?}: it has an area of {}",
                alone.mesh.area()
            );
            return Err(Error::Usage(what));
        }
        let (made, alone) = match &source {
            MeshOrigin::Functions(solid) => self.on_functions(alone, solid, size, run),
            MeshOrigin::Faces(solid) => self.on_faces(alone, solid, size, run),
            MeshOrigin::Triangles(solid) => self.on_triangles(alone, solid, size, run),
            MeshOrigin::Unknown(_) => return Err(Error::Failed("a mesh of nothing".into())),
        }?;
        let put = alone.put_back(self, &made, face as u32)?;
        let measured = source.measured(&put.mesh, &self.report, &self.mesh.nodes, run)?;
        self.report_anew(measured, size, run);
        (self.mesh, self.seams, self.corners) = (put.mesh, put.seams, put.corners);
        Ok(())
    }

    fn on_functions(
        &self,
        mut alone: Alone,
        solid: &Arc<Implicit>,
        size: f64,
        run: &Run,
    ) -> Result<(RemeshedMesh, Alone)> {
        let diagonal = solid.bounds().diagonal();
        let cell = cell(solid, self.report.size);
        let around = Aabb::around(alone.mesh.nodes.iter().copied()).grown(2.0 * cell);
        let nodes = NodeTree::new(&alone.mesh.nodes)?;
        let is_mine = |p: DVec3| nodes.nearest(p).is_some_and(|n| n.distance <= ON * diagonal);
        let oracle = ImplicitOracle::within(solid, cell, around, &is_mine, run)?;
        let on = alone.lay(&self.seams, &oracle, ON * diagonal).map_err(|at| {
            let (name, method) = (&alone.mesh.faces[0], self.report.method);
            let what =
                format!("the face {name:?} does not lie on one surface between its borders, by the method {method}");
            Error::input(Place::Point(at), what).with_help("the method leaf puts borders where surfaces meet")
        })?;
        let made = alone.remesh(&OnPieces { on, ..OnPieces::default() }, &oracle, &of_functions(solid, size)?, run)?;
        Ok((made, alone))
    }

    fn on_faces(&self, mut alone: Alone, solid: &Parametric, size: f64, run: &Run) -> Result<(RemeshedMesh, Alone)> {
        let name = &alone.mesh.faces[0];
        let Some(piece) = solid.brep.faces.iter().position(|f| f.name == *name) else {
            return Err(Error::Failed(format!("no face of the model is called {name:?}")));
        };
        if solid.has_creases(piece as u32) {
            let what = format!("the face {name:?} has creases inside, between which its surface is meshed in parts");
            return Err(Error::input(Place::Point(alone.mesh.centroid(0)), what));
        }
        let on = alone.lay_on(piece as u32);
        let made = alone.remesh(
            &OnPieces { on, judge: Judge::Angles, ..OnPieces::default() },
            solid,
            &of_faces(solid, size),
            run,
        )?;
        // This gate tells no seams and corners beyond the faces.
        let made = RemeshedMesh { seams: Vec::new(), corners: Vec::new(), ..made };
        Ok((made, alone))
    }

    fn on_triangles(&self, mut alone: Alone, solid: &Discrete, size: f64, run: &Run) -> Result<(RemeshedMesh, Alone)> {
        let name = &alone.mesh.faces[0];
        let Some(piece) = solid.face_names().iter().position(|f| f == name) else {
            return Err(Error::Failed(format!("no face of the triangles is called {name:?}")));
        };
        let mut on = alone.lay_on(piece as u32);
        let creases = alone.creases(&self.seams);
        let near = ON * solid.bounds().diagonal();
        for v in creases.iter().flatten() {
            on[*v as usize].extend(solid.creases_near(piece as u32, alone.mesh.nodes[*v as usize], near));
            on[*v as usize].sort_unstable();
            on[*v as usize].dedup();
        }
        let ends: FxHashSet<u32> = self.corners.iter().copied().collect();
        let corners = (0..alone.from.len() as u32).filter(|v| ends.contains(&alone.from[*v as usize])).collect();
        let laid =
            OnPieces { on, creases, corners, lines_from: Some(solid.face_count() as u32), judge: Judge::Normals };
        let made = alone.remesh(&laid, solid, &of_triangles(solid, size), run)?;
        Ok((made, alone))
    }

    /// Puts what was measured in the place of what was before, with the shortfalls that come of it.
    fn report_anew(&mut self, measured: Measured, size: f64, run: &Run) {
        let is_of_functions = matches!(self.source, MeshOrigin::Functions(_));
        let report = &mut self.report;
        let before = report.check.take();
        let known = before.as_ref().map_or(&[][..], |c| &c.certificate.faults);
        let is_measured =
            |f: &Fault| matches!(f, Fault::FacingAway { .. } | Fault::Far { .. } | Fault::VolumeLost { .. });
        report.shortfalls.retain(|f| !known.contains(f) && !is_measured(f));
        report.shortfalls.extend(measured.faults());
        let Measured { check, distance, volume } = measured;
        (report.distance, report.volume) = (distance, volume);
        if is_of_functions {
            report.shortfalls.extend(too_far(&check, size.max(report.size)));
        }
        let triangles = check.triangles;
        report.judge(check, 0.0);
        let timed = report.stages.iter().any(|s| s.seconds.is_some());
        report.stage("remesh face", triangles, &mut Clock::new(timed), run);
    }
}

/// How the triangles of one face lie on the pieces of a surface.
#[derive(Default)]
struct OnPieces {
    /// The pieces of each node.
    on: Vec<Vec<u32>>,
    /// Edges within one piece that bend, as pairs of nodes.
    creases: Vec<[u32; 2]>,
    /// Nodes that are not moved, beside those that other triangles have, too.
    corners: Vec<u32>,
    /// Pieces from this number on are lines within a piece.
    lines_from: Option<u32>,
    /// How triangles are judged.
    judge: Judge,
}

/// The triangles of one face as a mesh of their own.
struct Alone {
    /// Its only name is the face's.
    mesh: TriMesh,
    /// For each of its nodes the one it is in the whole mesh.
    from: Vec<u32>,
    /// Its nodes that other triangles have, too, or none beyond an open edge: they stay.
    stays: Vec<bool>,
}

/// The whole mesh with the face in it.
struct Put {
    mesh: TriMesh,
    seams: Vec<[u32; 2]>,
    corners: Vec<u32>,
}

impl Alone {
    fn new(whole: &Meshed, face: u32) -> Result<Self> {
        let all = &whole.mesh;
        all.validate()?;
        let mut mesh = TriMesh { faces: vec![all.faces[face as usize].clone()], ..TriMesh::default() };
        let (mut number, mut from) = (vec![NONE; all.nodes.len()], Vec::new());
        let mut known_to_others = vec![false; all.nodes.len()];
        for (t, label) in all.triangles.iter().zip(&all.labels) {
            if *label != face {
                t.iter().for_each(|v| known_to_others[*v as usize] = true);
                continue;
            }
            mesh.triangles.push(t.map(|v| {
                let slot = &mut number[v as usize];
                if *slot == NONE {
                    *slot = from.len() as u32;
                    from.push(v);
                    mesh.nodes.push(all.nodes[v as usize]);
                }
                *slot
            }));
            mesh.labels.push(0);
        }
        if mesh.triangles.is_empty() {
            return Err(Error::Usage(format!("the face {:?} has no triangles", mesh.faces[0])));
        }
        let copies = fans_apart(&mut mesh);
        from.extend(copies.iter().map(|v| from[*v as usize]).collect::<Vec<_>>());
        let mut stays: Vec<bool> = from.iter().map(|v| known_to_others[*v as usize]).collect();
        open_nodes(&mesh).into_iter().for_each(|v| stays[v as usize] = true);
        // A node with several fans is one place for all of them.
        copies.iter().enumerate().for_each(|(k, v)| {
            let copy = stays.len() - copies.len() + k;
            (stays[*v as usize], stays[copy]) = (true, true);
        });
        Ok(Self { mesh, from, stays })
    }

    /// Finds the piece of the surface each triangle lies on, which becomes its label; seams are where pieces meet within the
    /// face. Returns the pieces of each node, or a place where there is none.
    fn lay(&mut self, seams: &[[u32; 2]], surface: &ImplicitOracle<'_>, near: f64) -> Result<Vec<Vec<u32>>, DVec3> {
        let seams: FxHashSet<[u32; 2]> = seams.iter().map(|[a, b]| key(*a, *b)).collect();
        let mut sets = Sets::new(self.mesh.triangles.len());
        for ([a, b], [t, u]) in self.mesh.inner_edges() {
            if !seams.contains(&key(self.from[a as usize], self.from[b as usize])) {
                sets.join(t, u);
            }
        }
        let (part, count) = sets.numbers();
        let mut parts: Vec<Vec<usize>> = vec![Vec::new(); count];
        part.iter().enumerate().for_each(|(t, k)| parts[*k as usize].push(t));
        let mut on: Vec<Vec<u32>> = vec![Vec::new(); self.mesh.nodes.len()];
        for list in parts {
            let piece = self.piece_under(&list, surface, near).ok_or(self.mesh.centroid(list[0]))?;
            for t in list {
                self.mesh.labels[t] = piece;
                self.mesh.triangles[t].iter().for_each(|v| on[*v as usize].push(piece));
            }
        }
        for pieces in &mut on {
            pieces.sort_unstable();
            pieces.dedup();
        }
        Ok(on)
    }

    /// Lays all triangles on one piece. Returns the pieces of each node.
    fn lay_on(&mut self, piece: u32) -> Vec<Vec<u32>> {
        self.mesh.labels.fill(piece);
        vec![vec![piece]; self.mesh.nodes.len()]
    }

    /// Edges between two triangles of the face that are among some edges of the whole mesh.
    fn creases(&self, seams: &[[u32; 2]]) -> Vec<[u32; 2]> {
        let seams: FxHashSet<[u32; 2]> = seams.iter().map(|[a, b]| key(*a, *b)).collect();
        let whole = |[a, b]: &[u32; 2]| key(self.from[*a as usize], self.from[*b as usize]);
        self.mesh.inner_edges().into_iter().map(|e| e.0).filter(|e| seams.contains(&whole(e))).collect()
    }

    /// The piece that all nodes of some triangles lie on; of several the one nearest to the triangles' middles.
    fn piece_under(&self, list: &[usize], surface: &ImplicitOracle<'_>, near: f64) -> Option<u32> {
        let apexes = surface.apexes();
        let is_apex = |piece: u32, p: DVec3| apexes.iter().any(|(k, a)| *k == piece && a.distance(p) <= near);
        let off = |piece: u32, p: DVec3, reach: f64| {
            surface.meet(&[piece], p, reach).map_or(f64::INFINITY, |q| q.distance(p))
        };
        let corners = || list.iter().flat_map(|t| self.mesh.corners(*t));
        let holds = |piece: &u32| corners().all(|p| off(*piece, p, near) <= near || is_apex(*piece, p));
        let chords = |piece: u32| list.iter().map(|t| off(piece, self.mesh.centroid(*t), f64::INFINITY)).sum::<f64>();
        let all = surface.near(corners().next()?).into_iter().filter(holds).map(|k| (chords(k), k));
        all.min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1))).map(|x| x.1)
    }

    /// For each node the largest edge length it may want: on the border that of the edges there, so that rows beside them fit.
    fn sizes(&self) -> Vec<f64> {
        let mut sums = vec![(0.0, 0u32); self.mesh.nodes.len()];
        for e in sides(&self.mesh).chunk_by(|x, y| x.key == y.key).filter(|e| e.len() == 1) {
            let [a, b] = e[0].edge().map(|v| v as usize);
            let length = self.mesh.nodes[a].distance(self.mesh.nodes[b]);
            for v in [a, b] {
                sums[v] = (sums[v].0 + length, sums[v].1 + 1);
            }
        }
        sums.into_iter().map(|(sum, n)| if n > 0 { sum / f64::from(n) } else { f64::INFINITY }).collect()
    }

    fn remesh(
        &self,
        laid: &OnPieces,
        surface: &dyn Pieces,
        options: &RemeshOptions,
        run: &Run,
    ) -> Result<RemeshedMesh> {
        let names = TriMesh { faces: self.mesh.faces.clone(), ..TriMesh::default() };
        let faces = vec![0; self.mesh.triangles.len()];
        let given = InPieces { mesh: &self.mesh, on: &laid.on, faces: &faces, stays: &[] };
        let mut work = patch_open_pieces(&given, surface, self.mesh.mean_edge_length())?;
        work.sizes = self.sizes();
        work.policy.judge = laid.judge;
        work.lines_from = laid.lines_from.unwrap_or(work.lines_from);
        for [a, b] in &laid.creases {
            if let Some(h) = work.mesh.edge_between(*a, *b) {
                work.mesh.set_sharp(h, true);
            }
        }
        let stay = (0..self.stays.len() as u32).filter(|v| self.stays[*v as usize]);
        for v in stay.chain(laid.corners.iter().copied()) {
            work.mesh.set_pinned(v, true);
        }
        Ok(remesh_open(work, &names, surface, options, run)?.0)
    }

    /// Puts the face, as it was made, between the others.
    fn put_back(&self, whole: &Meshed, made: &RemeshedMesh, face: u32) -> Result<Put> {
        let old = &whole.mesh;
        let lost = |p: DVec3| {
            let what = format!(
                "the border of the face {:?} could not be kept near ({}, {}, {})",
                self.mesh.faces[0], p.x, p.y, p.z
            );
            Error::Failed(what)
        };
        let mut places: FxHashMap<[u64; 3], u32> = FxHashMap::default();
        for v in (0..self.from.len()).filter(|v| self.stays[*v]) {
            let p = self.mesh.nodes[v];
            if places.insert(bits(p), self.from[v]).is_some_and(|other| other != self.from[v]) {
                return Err(lost(p));
            }
        }
        let mut gone = vec![false; old.nodes.len()];
        for (v, stays) in self.from.iter().zip(&self.stays) {
            gone[*v as usize] = !stays;
        }
        let mut mesh = TriMesh { faces: old.faces.clone(), groups: old.groups.clone(), ..TriMesh::default() };
        let mut number = vec![NONE; old.nodes.len()];
        for (v, p) in old.nodes.iter().enumerate().filter(|(v, _)| !gone[*v]) {
            number[v] = mesh.nodes.len() as u32;
            mesh.nodes.push(*p);
        }
        let kept = mesh.nodes.len();
        let mut found = vec![false; old.nodes.len()];
        let own: Vec<u32> = made
            .mesh
            .nodes
            .iter()
            .map(|p| match places.get(&bits(*p)) {
                Some(v) => {
                    found[*v as usize] = true;
                    number[*v as usize]
                }
                None => {
                    mesh.nodes.push(*p);
                    mesh.nodes.len() as u32 - 1
                }
            })
            .collect();
        if let Some(v) = places.values().filter(|v| !found[**v as usize]).min() {
            return Err(lost(old.nodes[*v as usize]));
        }
        // The border must be the very same edges, in the same direction.
        let before = open_edges(&self.mesh, |v| number[self.from[v as usize] as usize]);
        let after = open_edges(&made.mesh, |v| own[v as usize]);
        if let Some(e) = first_apart(&before, &after) {
            return Err(lost(mesh.nodes[e[0] as usize]));
        }
        for (t, label) in old.triangles.iter().zip(&old.labels).filter(|x| *x.1 != face) {
            mesh.triangles.push(t.map(|v| number[v as usize]));
            mesh.labels.push(*label);
        }
        for t in &made.mesh.triangles {
            mesh.triangles.push(t.map(|v| own[v as usize]));
            mesh.labels.push(face);
        }
        let inner: FxHashSet<[u32; 2]> = self
            .mesh
            .inner_edges()
            .into_iter()
            .map(|([a, b], _)| key(self.from[a as usize], self.from[b as usize]))
            .collect();
        let stay = whole.seams.iter().filter(|[a, b]| !inner.contains(&key(*a, *b)));
        let mut seams: Vec<[u32; 2]> = stay.map(|e| e.map(|v| number[v as usize])).collect();
        seams.extend(made.seams.iter().map(|e| e.map(|v| own[v as usize])));
        let mut corners: Vec<u32> = whole.corners.iter().map(|v| number[*v as usize]).filter(|v| *v != NONE).collect();
        // The remesher calls all nodes that stay corners.
        corners.extend(made.corners.iter().map(|v| own[*v as usize]).filter(|v| *v as usize >= kept));
        Ok(Put { mesh, seams, corners })
    }
}

/// Edges with one triangle as it runs along them, ascending, in other numbers.
fn open_edges(mesh: &TriMesh, number: impl Fn(u32) -> u32) -> Vec<[u32; 2]> {
    let all = sides(mesh);
    let open = all.chunk_by(|x, y| x.key == y.key).filter(|e| e.len() == 1);
    let along = open.map(|e| {
        let [a, b] = e[0].edge();
        if e[0].forward { [number(a), number(b)] } else { [number(b), number(a)] }
    });
    let mut edges: Vec<[u32; 2]> = along.collect();
    edges.sort_unstable();
    edges
}

/// An edge that one of two ascending lists has and the other lacks.
fn first_apart(a: &[[u32; 2]], b: &[[u32; 2]]) -> Option<[u32; 2]> {
    let k = a.iter().zip(b).position(|(x, y)| x != y).unwrap_or(a.len().min(b.len()));
    match (a.get(k), b.get(k)) {
        (Some(x), Some(y)) => Some(*x.min(y)),
        (x, y) => x.or(y).copied(),
    }
}
