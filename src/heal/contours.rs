//! Contours of open edges, by the iteration of \[BOR20\] ("Formation and closing of open contours").

use glam::DVec3;
use rustc_hash::FxHashMap;

use super::sides::{Sides, directed, pieces};
use crate::mesh::TriMesh;

/// A closed chain of open edges. Its nodes follow the open sides of the triangles, so a filling triangle runs against them.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct OpenContour {
    /// The nodes in order; the last is joined to the first.
    pub(super) nodes: Vec<u32>,
    /// Found by our continuation, not by the iteration of the paper.
    pub(super) continued: bool,
}

/// A chain of open sides between two branching nodes.
#[derive(Debug, Clone)]
struct OpenChain {
    nodes: Vec<u32>,
    /// The piece of the surface its triangles belong to.
    pieces: Vec<u32>,
}

impl OpenChain {
    fn start(&self) -> u32 {
        self.nodes[0]
    }

    fn end(&self) -> u32 {
        self.nodes[self.nodes.len() - 1]
    }
}

/// All contours of an oriented mesh.
///
/// The paper's two steps are repeated: chains that are split at nodes of more than two open edges and start and end at one
/// node are contours; then a pair of chains between the same two nodes is a contour if it is the only pair there and no path
/// over triangles leads from one chain to the other. Where neither finds anything the paper stops; we go on with the
/// closed sequence of chains that spans the smallest area, and mark it. What is left, if anything, closes in no direction.
pub(super) fn contours(mesh: &TriMesh) -> Vec<OpenContour> {
    let sides = Sides::of(&mesh.triangles);
    let open = sides.open();
    if open.is_empty() {
        return Vec::new();
    }
    let (piece, _) = pieces(mesh.triangles.len(), &sides, |e| e.len() == 2);
    let mut steps: Vec<([u32; 2], u32)> =
        open.iter().map(|h| (directed(&mesh.triangles, *h), piece[(*h / 3) as usize])).collect();
    steps.sort_unstable();
    let mut found = Vec::new();
    while !steps.is_empty() {
        let (chains, closed) = chains(&steps);
        found.extend(closed.into_iter().map(|nodes| OpenContour { nodes, continued: false }));
        let mut used = vec![false; chains.len()];
        for (i, c) in chains.iter().enumerate() {
            if c.start() == c.end() {
                used[i] = true;
                found.push(OpenContour { nodes: c.nodes[1..].to_vec(), continued: false });
            }
        }
        // second step: unique pairs that no path over triangles joins
        if !used.iter().any(|u| *u) {
            let mut between: FxHashMap<[u32; 2], Vec<usize>> = FxHashMap::default();
            for (i, c) in chains.iter().enumerate() {
                between.entry([c.start().min(c.end()), c.start().max(c.end())]).or_default().push(i);
            }
            for i in 0..chains.len() {
                let c = &chains[i];
                let pair = &between[&[c.start().min(c.end()), c.start().max(c.end())]];
                if let [a, b] = pair[..]
                    && a == i
                    && chains[a].start() == chains[b].end()
                    && !chains[a].pieces.iter().any(|p| chains[b].pieces.contains(p))
                {
                    (used[a], used[b]) = (true, true);
                    found.push(OpenContour { nodes: ring(&[&chains[a], &chains[b]]), continued: false });
                }
            }
        }
        if !used.iter().any(|u| *u) {
            let Some(cycle) = smallest_cycle(mesh, &chains) else { break };
            cycle.iter().for_each(|i| used[*i] = true);
            let members: Vec<&OpenChain> = cycle.iter().map(|i| &chains[*i]).collect();
            found.push(OpenContour { nodes: ring(&members), continued: true });
        }
        steps = chains
            .iter()
            .zip(&used)
            .filter(|(_, used)| !**used)
            .flat_map(|(c, _)| c.nodes.windows(2).zip(&c.pieces).map(|(w, p)| ([w[0], w[1]], *p)))
            .collect();
        steps.sort_unstable();
    }
    found.into_iter().flat_map(simple).collect()
}

/// Parts a contour at nodes it passes twice, so that each part is simple.
fn simple(contour: OpenContour) -> Vec<OpenContour> {
    let mut out = Vec::new();
    let mut stack: Vec<u32> = Vec::new();
    let mut at: FxHashMap<u32, usize> = FxHashMap::default();
    for v in contour.nodes {
        if let Some(&i) = at.get(&v) {
            let part: Vec<u32> = stack.drain(i..).collect();
            part.iter().for_each(|w| {
                at.remove(w);
            });
            out.push(OpenContour { nodes: part, continued: contour.continued });
        }
        at.insert(v, stack.len());
        stack.push(v);
    }
    out.push(OpenContour { nodes: stack, continued: contour.continued });
    out
}

fn ring(chains: &[&OpenChain]) -> Vec<u32> {
    chains.iter().flat_map(|c| c.nodes[..c.nodes.len() - 1].iter().copied()).collect()
}

/// Splits the steps into chains at nodes with more than two of them (or whose steps do not continue); closed chains
/// without such a node come separately.
fn chains(steps: &[([u32; 2], u32)]) -> (Vec<OpenChain>, Vec<Vec<u32>>) {
    let from = |v: u32| {
        let lo = steps.partition_point(|s| s.0[0] < v);
        let hi = steps.partition_point(|s| s.0[0] <= v);
        lo..hi
    };
    let mut coming: FxHashMap<u32, u32> = FxHashMap::default();
    steps.iter().for_each(|s| *coming.entry(s.0[1]).or_default() += 1);
    let passes = |v: u32| from(v).len() == 1 && coming.get(&v) == Some(&1);
    let mut used = vec![false; steps.len()];
    let walk = |first: usize, used: &mut Vec<bool>| {
        let mut chain = OpenChain { nodes: vec![steps[first].0[0]], pieces: Vec::new() };
        let mut i = first;
        loop {
            used[i] = true;
            chain.nodes.push(steps[i].0[1]);
            chain.pieces.push(steps[i].1);
            let v = steps[i].0[1];
            if !passes(v) {
                break;
            }
            i = from(v).start;
            if used[i] {
                break;
            }
        }
        chain
    };
    let mut out = Vec::new();
    for i in 0..steps.len() {
        if !used[i] && !passes(steps[i].0[0]) {
            out.push(walk(i, &mut used));
        }
    }
    let mut closed = Vec::new();
    for i in 0..steps.len() {
        if !used[i] {
            closed.push(walk(i, &mut used).nodes[1..].to_vec());
        }
    }
    (out, closed)
}

/// The closed sequence of chains that spans the smallest area: pairs first, then the shortest cycles through each chain.
fn smallest_cycle(mesh: &TriMesh, chains: &[OpenChain]) -> Option<Vec<usize>> {
    let mut leaving: FxHashMap<u32, Vec<usize>> = FxHashMap::default();
    for (i, c) in chains.iter().enumerate() {
        leaving.entry(c.start()).or_default().push(i);
    }
    let none: Vec<usize> = Vec::new();
    let after = |v: u32| leaving.get(&v).unwrap_or(&none);
    let area = |cycle: &[usize]| {
        let members: Vec<&OpenChain> = cycle.iter().map(|i| &chains[*i]).collect();
        spanned(mesh, &ring(&members))
    };
    let mut best: Option<(f64, Vec<usize>)> = None;
    let mut offer = |cycle: Vec<usize>| {
        let a = area(&cycle);
        if best.as_ref().is_none_or(|b| a < b.0) {
            best = Some((a, cycle));
        }
    };
    for (i, c) in chains.iter().enumerate() {
        for &j in after(c.end()) {
            if j > i && chains[j].end() == c.start() {
                offer(vec![i, j]);
            }
        }
    }
    if best.is_none() {
        // fewest chains back to the start of chain i
        for i in 0..chains.len() {
            let mut came: FxHashMap<u32, usize> = FxHashMap::default();
            let mut queue = std::collections::VecDeque::from([chains[i].end()]);
            while let Some(v) = queue.pop_front() {
                for &j in after(v) {
                    let w = chains[j].end();
                    if w != chains[i].end() && !came.contains_key(&w) {
                        came.insert(w, j);
                        queue.push_back(w);
                    }
                }
            }
            let (mut cycle, mut v) = (vec![], chains[i].start());
            while v != chains[i].end() {
                let Some(&j) = came.get(&v) else { break };
                cycle.push(j);
                v = chains[j].start();
            }
            if v == chains[i].end() {
                cycle.push(i);
                cycle.reverse();
                best = Some((0.0, cycle));
                break;
            }
        }
    }
    best.map(|b| b.1)
}

/// Size of the area a ring of nodes spans, by its vector area.
pub(super) fn spanned(mesh: &TriMesh, nodes: &[u32]) -> f64 {
    let p = |i: usize| mesh.nodes[nodes[i % nodes.len()] as usize];
    let o = p(0);
    0.5 * (0..nodes.len()).map(|i| (p(i) - o).cross(p(i + 1) - o)).sum::<DVec3>().length()
}
