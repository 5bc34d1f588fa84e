//! What the leaves contribute, sewn together: along an edge the two leaves that make it have each their own points, which
//! become one chain.

use std::collections::BTreeMap;

use glam::DVec3;
use rustc_hash::FxHashMap;

use super::super::leaf::Leaf;
use super::super::model::Implicit;
use super::super::newton::nearest;
use super::arrange::Part;
use super::crowds::Crowd;
use super::strands::Strand;
use super::{Trimmed, Unfit};
use crate::mesh::TriMesh;
use crate::spatial::{Aabb, Bvh, segment_foot};

/// Points of the two chains nearer than this share of a cell are one.
const ONE: f64 = 0.2;
/// Corners of the same leaves nearer than this share of a cell are one;
const SAME: f64 = 1e-4;
/// those of different leaves, of which more than three meet there, if they are nearer than this share of the part's size.
const CROWDED: f64 = 1e-12;
/// Chains farther from each other than this many cells are different edges.
const APART: f64 = 1.0;
/// Where borders do not fit is where they are at least this share of the largest distance apart.
const WORST: f64 = 0.5;
const NONE: u32 = u32::MAX;

/// A border of a part from corner to corner, or closed.
struct Chain {
    part: usize,
    /// Corners at its ends, [`NONE`] where it is closed.
    ends: [u32; 2],
    /// Points of the part; the first of a closed chain is not repeated.
    points: Vec<u32>,
}

impl Chain {
    fn is_closed(&self) -> bool {
        self.ends[0] == NONE
    }
}

struct Sewer<'a> {
    model: &'a Implicit,
    parts: &'a [&'a Part],
    cell: f64,
    refined: bool,
    nodes: Vec<DVec3>,
    leaves: Vec<Vec<u32>>,
    /// For each part the node each point has become.
    node_of: Vec<Vec<u32>>,
    /// For each part what lies on a side of its border, in the side's direction.
    between: Vec<FxHashMap<(u32, u32), Vec<u32>>>,
    /// What became of the chains.
    strands: Vec<Strand>,
}

/// Joins the parts; `refined` where some sheets are finer than the cells. `known` are points that
/// all their leaves' sheets have as nodes; `crowded` takes up others like them. *Errors*: the places where their borders do not fit.
pub(super) fn sew(
    model: &Implicit,
    parts: &[&Part],
    cell: f64,
    refined: bool,
    known: &[Crowd],
    crowded: &mut Vec<Crowd>,
) -> Result<(Trimmed, Vec<Strand>), Unfit> {
    let mut sewer = Sewer {
        model,
        parts,
        cell,
        refined,
        nodes: Vec::new(),
        leaves: Vec::new(),
        node_of: parts.iter().map(|p| vec![NONE; p.points.len()]).collect(),
        between: vec![FxHashMap::default(); parts.len()],
        strands: Vec::new(),
    };
    for crowd in known {
        sewer.node(crowd.at, crowd.leaves.clone());
    }
    sewer.gather((0..known.len() as u32).collect());
    sewer.join_corners();
    // Fillets that meet end in each other there: what is beyond their ends is not cut by them.
    let is_fillet = |l: &u32| matches!(model.leaves[*l as usize], Leaf::Fillet(_));
    let is_crowd = |on: &Vec<u32>| on.len() > 3 && !on.iter().any(is_fillet);
    let corners = known.len() as u32..sewer.nodes.len() as u32;
    let many: Vec<u32> = corners.filter(|v| is_crowd(&sewer.leaves[*v as usize])).collect();
    let crowd =
        |v: &u32| Crowd { at: sewer.nodes[*v as usize], leaves: sewer.leaves[*v as usize].clone(), touching: false };
    crowded.extend(many.iter().map(crowd));
    sewer.gather(many);
    let scale = model.bounds().diagonal();
    let mut edges: BTreeMap<[u32; 4], [Vec<Chain>; 2]> = BTreeMap::new();
    for (p, part) in parts.iter().enumerate() {
        for (chain, other) in sewer.chains(p, part)? {
            let [a, b] = chain.ends;
            // Corners at one place, where more than three leaves meet, have nothing between them.
            let first = sewer.point(p, chain.points[0]);
            if a == b && a != NONE && chain.points.iter().all(|v| sewer.point(p, *v).distance(first) <= CROWDED * scale)
            {
                continue;
            }
            let key = [part.leaf.min(other), part.leaf.max(other), a.min(b), a.max(b)];
            edges.entry(key).or_default()[usize::from(part.leaf > other)].push(chain);
        }
    }
    let mut unfit = Vec::new();
    for [own, mut others] in edges.into_values() {
        if own.len() != others.len() {
            unfit.extend(sewer.mismatch(&own, &others));
            continue;
        }
        for chain in own {
            let away = |c: &Chain| sewer.away(&chain, c);
            let found = (0..others.len()).map(|k| (k, away(&others[k]))).min_by(|x, y| x.1.total_cmp(&y.1));
            let Some((at, _)) = found.filter(|x| x.1 <= APART * cell) else {
                unfit.extend(sewer.mismatch(&[chain], &others));
                break;
            };
            let other = others.swap_remove(at);
            if sewer.join(&chain, &other).is_none() {
                unfit.extend(sewer.mismatch(&[chain], &[other]));
            }
        }
    }
    if unfit.is_empty() { sewer.finish() } else { Err(unfit) }
}

/// The loops a ring consists of that meets itself in some nodes; those of fewer than three nodes are nothing.
fn loops(ring: Vec<u32>) -> Vec<Vec<u32>> {
    let mut found = Vec::new();
    let mut open: Vec<u32> = Vec::with_capacity(ring.len());
    for v in ring {
        if let Some(k) = open.iter().position(|w| *w == v) {
            found.push(open.drain(k..).collect());
        }
        open.push(v);
    }
    found.push(open);
    found.retain(|l: &Vec<u32>| l.len() > 2);
    found
}

impl Sewer<'_> {
    fn node(&mut self, p: DVec3, leaves: Vec<u32>) -> u32 {
        self.nodes.push(p);
        self.leaves.push(leaves);
        self.nodes.len() as u32 - 1
    }

    fn point(&self, part: usize, v: u32) -> DVec3 {
        self.parts[part].points[v as usize]
    }

    /// Gives corners of different parts at one place one node.
    fn join_corners(&mut self) {
        let scale = self.model.bounds().diagonal();
        let mut corners: Vec<(DVec3, usize, u32)> = Vec::new();
        for (p, part) in self.parts.iter().enumerate() {
            let own = (0..part.points.len()).filter(|v| part.on[*v].len() > 2 && self.node_of[p][*v] == NONE);
            corners.extend(own.map(|v| (part.points[v], p, v as u32)));
        }
        corners.sort_by(|a, b| a.0.x.total_cmp(&b.0.x).then((a.1, a.2).cmp(&(b.1, b.2))));
        for i in 0..corners.len() {
            let (at, p, v) = corners[i];
            let on = self.parts[p].on[v as usize].clone();
            let near = |x: &&(DVec3, usize, u32)| {
                let same = self.parts[x.1].on[x.2 as usize] == on;
                x.0.distance(at) <= if same { SAME * self.cell } else { CROWDED * scale }
            };
            let mut before = corners[..i].iter().rev().take_while(|x| at.x - x.0.x <= SAME * self.cell);
            let known = before.find(near).map(|&(_, q, w)| self.node_of[q][w as usize]);
            let id = match known {
                Some(id) => {
                    let set = &mut self.leaves[id as usize];
                    set.extend(on);
                    set.sort_unstable();
                    set.dedup();
                    id
                }
                None => self.node(at, on),
            };
            self.node_of[p][v as usize] = id;
        }
    }

    /// Takes all points of parts that lie at one of some nodes, and on a leaf of it, as that node: the arrangement may have
    /// made several there, with sides of no length between them.
    fn gather(&mut self, crowded: Vec<u32>) {
        let near = CROWDED * self.model.bounds().diagonal();
        let places = crowded.iter().map(|v| self.nodes[*v as usize]).map(|p| Aabb::new(p, p).grown(near));
        let tree = Bvh::new(places.collect());
        for (part, nodes) in self.parts.iter().zip(&mut self.node_of) {
            for (p, node) in part.points.iter().zip(nodes).filter(|x| *x.1 == NONE && x.0.is_finite()) {
                tree.overlapping(&Aabb::new(*p, *p), |k| {
                    let v = crowded[k as usize];
                    if self.leaves[v as usize].contains(&part.leaf) {
                        *node = v;
                    }
                });
            }
        }
    }

    /// The chains of a part's border, each with the leaf beyond it.
    fn chains(&self, p: usize, part: &Part) -> Result<Vec<(Chain, u32)>, Unfit> {
        let mut next: Vec<(u32, u32)> = vec![(NONE, NONE); part.points.len()];
        part.border.iter().for_each(|(a, b, j)| next[*a as usize] = (*b, *j));
        let mut seen = vec![false; part.points.len()];
        let is_corner = |v: u32| self.node_of[p][v as usize] != NONE;
        let mut chains = Vec::new();
        for corners in [true, false] {
            for &(a, _, leaf) in &part.border {
                if corners != is_corner(a) || std::mem::replace(&mut seen[a as usize], true) {
                    continue;
                }
                let mut points = vec![a];
                let mut v = next[a as usize].0;
                while v != a && !is_corner(v) {
                    if v == NONE || next[v as usize].1 != leaf || std::mem::replace(&mut seen[v as usize], true) {
                        return Err(points.last().map(|v| part.points[*v as usize]).into_iter().collect());
                    }
                    points.push(v);
                    v = next[v as usize].0;
                }
                let ends = if corners {
                    points.push(v);
                    [a, v].map(|v| self.node_of[p][v as usize])
                } else if v == a {
                    [NONE; 2]
                } else {
                    return Err(vec![part.points[v as usize]]);
                };
                chains.push((Chain { part: p, ends, points }, leaf));
            }
        }
        Ok(chains)
    }

    /// Where chains of two leaves, or of the other two, are farthest from all of the other kind.
    fn mismatch(&self, own: &[Chain], others: &[Chain]) -> Unfit {
        let mut away: Vec<(f64, DVec3)> = Vec::new();
        for (these, those) in [(own, others), (others, own)] {
            for c in these {
                for p in c.points.iter().map(|v| self.point(c.part, *v)) {
                    let d = those.iter().map(|o| self.locate(o, p, None).1).fold(self.cell, f64::min);
                    away.push((d, p));
                }
            }
        }
        let most = away.iter().map(|x| x.0).fold(0.0, f64::max);
        away.into_iter().filter(|x| x.0 >= WORST * most).map(|x| x.1).collect()
    }

    /// How far the middle of a chain is from another.
    fn away(&self, chain: &Chain, other: &Chain) -> f64 {
        let k = chain.points.len() / 2;
        let at = |k: usize| self.point(chain.part, chain.points[k]);
        let middle = if chain.points.len() == 2 { at(0).midpoint(at(1)) } else { at(k) };
        self.locate(other, middle, None).1
    }

    /// The place on a chain nearest to a point, in sides from its start, and its distance; of the sides that run some way, if
    /// that is given.
    fn locate(&self, chain: &Chain, p: DVec3, way: Option<DVec3>) -> (f64, f64) {
        let n = chain.points.len();
        let sides = if chain.is_closed() { n } else { n - 1 };
        let mut best = (0.0, f64::INFINITY);
        for k in 0..sides {
            let [a, b] = [k, (k + 1) % n].map(|i| self.point(chain.part, chain.points[i]));
            if way.is_some_and(|w| w.dot(b - a) < 0.0) {
                continue;
            }
            let foot = segment_foot(p, [a, b]);
            let (along, away) = (foot.distance(a), p.distance(foot));
            if away < best.1 {
                best = (k as f64 + if along > 0.0 { (along / b.distance(a)).min(1.0) } else { 0.0 }, away);
            }
        }
        best
    }

    /// The inner points of a chain in the direction of one it runs against, each with its place there; `None` where those are not
    /// in order. Where strands of a chain are close, the nearest may be the one that runs the other way: `way` rules that out.
    fn placed(&self, own: &Chain, other: &Chain, way: bool) -> Option<Vec<(f64, u32)>> {
        let (closed, m) = (own.is_closed(), other.points.len());
        let at = |k: usize| self.point(other.part, other.points[k % m]);
        let inner = if closed { 0..m } else { 1..m - 1 };
        let place = |k: usize| self.locate(own, at(k), way.then(|| at(k + m - 1) - at(k + 1))).0;
        let mut placed: Vec<(f64, u32)> = inner.rev().map(|k| (place(k), other.points[k])).collect();
        if closed {
            let first = (0..placed.len()).min_by(|a, b| placed[*a].0.total_cmp(&placed[*b].0))?;
            placed.rotate_left(first);
        }
        for k in 1..placed.len() {
            let before = placed[k - 1].0;
            if placed[k].0 < before - 1.0 {
                return None;
            }
            placed[k].0 = placed[k].0.max(before);
        }
        Some(placed)
    }

    /// The length of the longest of a side of a chain and those next to it.
    fn longest_beside(&self, chain: &Chain, k: usize) -> f64 {
        let n = chain.points.len();
        let at = |k: usize| self.point(chain.part, chain.points[k % n]);
        (k + n - 1..k + n + 2).map(|k| at(k).distance(at(k + 1))).fold(0.0, f64::max)
    }

    /// Makes one chain of two that run against each other.
    fn join(&mut self, own: &Chain, other: &Chain) -> Option<()> {
        if own.ends[0] != other.ends[1] || own.ends[1] != other.ends[0] {
            return None;
        }
        let closed = own.is_closed();
        let leaves = {
            let mut both = vec![self.parts[own.part].leaf, self.parts[other.part].leaf];
            both.sort_unstable();
            both
        };
        for (k, &v) in own.points.iter().enumerate() {
            if closed || (k > 0 && k + 1 < own.points.len()) {
                let p = self.point(own.part, v);
                self.node_of[own.part][v as usize] = self.node(p, leaves.clone());
            }
        }
        // The other's points in this one's direction, each with its place.
        let placed = self.placed(own, other, false).or_else(|| self.placed(own, other, true))?;
        let n = own.points.len();
        let sides = if closed { n } else { n - 1 };
        let mut order: Vec<u32> = Vec::new();
        let mut rest = placed.into_iter().peekable();
        let mut taken = usize::MAX;
        let mut inserted: Vec<Vec<u32>> = vec![Vec::new(); sides];
        for (k, inserted) in inserted.iter_mut().enumerate() {
            order.push(self.node_of[own.part][own.points[k] as usize]);
            while let Some((s, v)) = rest.next_if(|x| x.0 < (k + 1) as f64 || k + 1 == sides) {
                let at = self.point(other.part, v);
                let next = (k + 1) % n;
                // Points of the other chain that are next to one of this one's, in order, become that one.
                let free = |end: usize| end != taken && (closed || (end > 0 && end < n - 1));
                let one = if self.refined { ONE * self.cell.min(self.longest_beside(own, k)) } else { ONE * self.cell };
                let near = |end: usize| self.point(own.part, own.points[end]).distance(at) <= one;
                let end = if inserted.is_empty() && s - k as f64 <= 0.5 && free(k) && near(k) {
                    Some(k)
                } else if rest.peek().is_none_or(|x| x.0 >= (k + 1) as f64)
                    && (next != 0 || !closed)
                    && free(next)
                    && near(next)
                {
                    Some(next)
                } else {
                    None
                };
                let id = match end {
                    Some(end) => {
                        taken = end;
                        self.node_of[own.part][own.points[end] as usize]
                    }
                    None => {
                        let id = self.node(at, leaves.clone());
                        inserted.push(id);
                        order.push(id);
                        id
                    }
                };
                self.node_of[other.part][v as usize] = id;
            }
        }
        if !closed {
            order.push(own.ends[1]);
        }
        for (k, list) in inserted.into_iter().enumerate().filter(|x| !x.1.is_empty()) {
            self.between[own.part].insert((own.points[k], own.points[(k + 1) % n]), list);
        }
        // What lies between neighboring points of the other chain, seen in its direction.
        let mut place: FxHashMap<u32, usize> = FxHashMap::default();
        order.iter().enumerate().for_each(|(k, id)| {
            place.insert(*id, k);
        });
        let m = other.points.len();
        for k in 0..if closed { m } else { m - 1 } {
            let (a, b) = (other.points[k], other.points[(k + 1) % m]);
            let at = |v: u32| place.get(&self.node_of[other.part][v as usize]).copied();
            // An edge from a corner back to it has that corner at both ends.
            let (from, to) = if closed {
                (at(a)?, at(b)?)
            } else {
                (if k == 0 { order.len() - 1 } else { at(a)? }, if k + 2 == m { 0 } else { at(b)? })
            };
            let list: Vec<u32> = if closed {
                let count = (from + order.len() - to) % order.len();
                (1..count).map(|d| order[(from + order.len() - d) % order.len()]).collect()
            } else {
                (to + 1..from).rev().map(|i| order[i]).collect()
            };
            if !list.is_empty() {
                self.between[other.part].insert((a, b), list);
            }
        }
        self.strands.push(Strand { nodes: order, closed, leaves: [leaves[0], leaves[1]] });
        Some(())
    }

    /// The polygons of every part with all nodes on their sides, each with its part.
    fn rings(&mut self) -> Vec<(usize, Vec<u32>)> {
        let parts = self.parts;
        let mut rings = Vec::new();
        for (p, part) in parts.iter().enumerate() {
            for polygon in &part.polygons {
                let mut ring: Vec<u32> = Vec::with_capacity(polygon.len());
                for k in 0..polygon.len() {
                    let (a, b) = (polygon[k], polygon[(k + 1) % polygon.len()]);
                    if self.node_of[p][a as usize] == NONE {
                        self.node_of[p][a as usize] = self.node(part.points[a as usize], vec![part.leaf]);
                    }
                    ring.push(self.node_of[p][a as usize]);
                    ring.extend(self.between[p].get(&(a, b)).into_iter().flatten());
                }
                rings.extend(loops(ring).into_iter().map(|ring| (p, ring)));
            }
        }
        rings
    }

    /// The node of one leaf nearest to the middle of some.
    fn middle(&mut self, leaf: u32, of: &[u32]) -> u32 {
        let middle = of.iter().map(|v| self.nodes[*v as usize]).sum::<DVec3>() / of.len() as f64;
        let found = nearest(&self.model.leaves, &[leaf], middle, self.cell, self.model.bounds().diagonal());
        self.node(found.unwrap_or(middle), vec![leaf])
    }

    /// Chords of a part from border to border get a node in their middle where another part has the same chord.
    fn split_shared_chords(&mut self, rings: &mut [(usize, Vec<u32>)]) {
        let mut sides: Vec<((u32, u32), usize, usize)> = Vec::new();
        for (i, (p, ring)) in rings.iter().enumerate() {
            for k in 0..ring.len() {
                let (a, b) = (ring[k], ring[(k + 1) % ring.len()]);
                if self.leaves[a as usize].len() > 1 && self.leaves[b as usize].len() > 1 {
                    sides.push(((a.min(b), a.max(b)), *p, i));
                }
            }
        }
        sides.sort_unstable();
        for group in sides.chunk_by(|x, y| x.0 == y.0).filter(|g| g.len() > 2) {
            for own in group.chunk_by(|x, y| x.1 == y.1).filter(|g| g.len() > 1) {
                let ((a, b), p, _) = own[0];
                let c = self.middle(self.parts[p].leaf, &[a, b]);
                for (_, _, i) in own {
                    let ring = &mut rings[*i].1;
                    let n = ring.len();
                    let side = |k: &usize| [(a, b), (b, a)].contains(&(ring[*k], ring[(k + 1) % n]));
                    if let Some(k) = (0..n).find(side) {
                        ring.insert(k + 1, c);
                    }
                }
            }
        }
    }

    /// Polygons become triangles; what is more than a quadrangle gets a node in its middle.
    fn finish(mut self) -> Result<(Trimmed, Vec<Strand>), Unfit> {
        let mut rings = self.rings();
        self.split_shared_chords(&mut rings);
        let mut triangles = Vec::new();
        let mut labels = Vec::new();
        for (p, ring) in &rings {
            let leaf = self.parts[*p].leaf;
            let at = |k: usize| self.nodes[ring[k] as usize];
            match ring.len() {
                3 => triangles.push([ring[0], ring[1], ring[2]]),
                4 => {
                    let k = usize::from(at(0).distance(at(2)) > at(1).distance(at(3)));
                    triangles.push([ring[k], ring[k + 1], ring[k + 2]]);
                    triangles.push([ring[k + 2], ring[(k + 3) % 4], ring[k]]);
                }
                n => {
                    let c = self.middle(leaf, ring);
                    triangles.extend((0..n).map(|k| [ring[k], ring[(k + 1) % n], c]));
                }
            }
            labels.resize(triangles.len(), leaf);
        }
        let mesh = TriMesh { nodes: self.nodes, triangles, labels, ..TriMesh::default() };
        let defects = mesh.defects();
        let sound = defects.is_closed() && defects.is_manifold() && defects.is_oriented();
        if sound {
            return if mesh.triangles.is_empty() {
                Err(Vec::new())
            } else {
                Ok((Trimmed { mesh, leaves: self.leaves, faces: Vec::new() }, self.strands))
            };
        }
        let edges = [&defects.open_edges, &defects.nonmanifold_edges, &defects.misoriented_edges];
        let nodes = edges.into_iter().flatten().flatten().chain(&defects.nonmanifold_nodes);
        Err(nodes.map(|v| mesh.nodes[*v as usize]).collect())
    }
}
