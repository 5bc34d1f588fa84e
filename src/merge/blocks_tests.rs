//! A block of hexahedra split at random into blocks on structured faces, and put together again.

use glam::DVec3;
use proptest::prelude::*;
use rustc_hash::FxHashMap;

use super::*;
use crate::mesh::MeshView;
use crate::model::{Coedge, Edge, EdgeFragment, Face, FaceFragment, Fragments, Loop, Model, Vertex};
use crate::run::Run;

/// A box of cells split at `cuts` along each direction: lattice coordinates of the planes, the first and last included.
struct Split {
    cuts: [Vec<u32>; 3],
}

fn key(p: DVec3) -> [u64; 3] {
    p.to_array().map(f64::to_bits)
}

impl Split {
    /// Nowhere regular, so that no node takes another's place.
    fn point(&self, at: [u32; 3]) -> DVec3 {
        let [x, y, z] = at.map(f64::from);
        DVec3::new(x + 0.1 * (y * 1.3 + z).sin(), y + 0.1 * (z * 0.7 + x).sin(), z + 0.1 * (x * 1.1 - y).sin())
    }

    /// The model with fragments and blocks; `turn` says how each face's grid lies, `back` which way each edge runs.
    fn build(
        &self,
        turn: impl Fn(usize) -> u8,
        back: impl Fn(usize) -> bool,
    ) -> (Model, Fragments, Vec<HexahedraBlock>) {
        let n = [0, 1, 2].map(|d| self.cuts[d].len());
        let plane = |d: usize, c: usize| self.cuts[d][c];
        let mut model = Model { names: vec!["face".into()], ..Model::default() };
        let all =
            |n: [usize; 3]| (0..n[2]).flat_map(move |k| (0..n[1]).flat_map(move |j| (0..n[0]).map(move |i| [i, j, k])));
        let vertex = |c: [usize; 3]| (c[0] + n[0] * (c[1] + n[1] * c[2])) as u32;
        let mut fragments = Fragments::new(all(n).map(|c| self.point([0, 1, 2].map(|d| plane(d, c[d])))).collect());
        model.vertices = vec![Vertex::default(); n[0] * n[1] * n[2]];
        // edges along d from corner c to the next
        let mut edges: FxHashMap<(usize, [usize; 3]), (u32, bool)> = FxHashMap::default();
        for d in 0..3 {
            for c in all(n).filter(|c| c[d] + 1 < n[d]) {
                let mut next = c;
                next[d] += 1;
                let number = model.edges.len();
                let mut chain: Vec<DVec3> = (plane(d, c[d])..=plane(d, next[d]))
                    .map(|x| {
                        let mut at = [0, 1, 2].map(|d| plane(d, c[d]));
                        at[d] = x;
                        self.point(at)
                    })
                    .collect();
                let mut ends = [vertex(c), vertex(next)];
                if back(number) {
                    chain.reverse();
                    ends.reverse();
                }
                model.edges.push(Edge { ends, ..Edge::default() });
                fragments.push_edge(&EdgeFragment::new(chain).unwrap()).unwrap();
                edges.insert((d, c), (number as u32, back(number)));
            }
        }
        // faces across d, first direction d + 1, second d + 2, then turned
        let mut faces: FxHashMap<(usize, [usize; 3]), u32> = FxHashMap::default();
        for d in 0..3 {
            let (a, b) = ((d + 1) % 3, (d + 2) % 3);
            for c in all(n).filter(|c| c[a] + 1 < n[a] && c[b] + 1 < n[b]) {
                let number = model.faces.len();
                let side = |along: usize, far: bool| {
                    let mut c = c;
                    c[a + b - along] += usize::from(far);
                    edges[&(along, c)]
                };
                let size = [a, b].map(|x| plane(x, c[x] + 1) - plane(x, c[x]));
                let t = turn(number);
                let (swap, flip) = (t & 4 > 0, [t & 1 > 0, t & 2 > 0]);
                // the grid's own (i, j) on the lattice
                let grid = if swap { [size[1], size[0]] } else { size };
                let axes = if swap { [b, a] } else { [a, b] };
                let mut nodes = Vec::new();
                for j in 0..=grid[1] {
                    for i in 0..=grid[0] {
                        let ij = [if flip[0] { grid[0] - i } else { i }, if flip[1] { grid[1] - j } else { j }];
                        let mut at = [0, 1, 2].map(|d| plane(d, c[d]));
                        at[axes[0]] += ij[0];
                        at[axes[1]] += ij[1];
                        nodes.push(self.point(at));
                    }
                }
                // around the grid: along its first direction at the second's start, and so on
                let coedge = |(edge, back): (u32, bool), along: bool| Coedge { edge, reversed: back == along };
                let list = vec![
                    coedge(side(axes[0], flip[1]), !flip[0]),
                    coedge(side(axes[1], !flip[0]), !flip[1]),
                    coedge(side(axes[0], !flip[1]), flip[0]),
                    coedge(side(axes[1], flip[0]), flip[1]),
                ];
                model.faces.push(Face { loops: vec![Loop::Edges(list)], ..Face::default() });
                let segments = [grid[0], grid[1], grid[0], grid[1]];
                fragments.push_face(&FaceFragment::grid(grid, nodes, &segments).unwrap()).unwrap();
                faces.insert((d, c), number as u32);
            }
        }
        let mut blocks = Vec::new();
        for c in all(n).filter(|c| (0..3).all(|d| c[d] + 1 < n[d])) {
            let (lo, hi) = ([0, 1, 2].map(|d| plane(d, c[d])), [0, 1, 2].map(|d| plane(d, c[d] + 1)));
            let mut nodes = Vec::new();
            for z in lo[2]..=hi[2] {
                for y in lo[1]..=hi[1] {
                    nodes.extend((lo[0]..=hi[0]).map(|x| self.point([x, y, z])));
                }
            }
            let face = |s: usize| {
                let mut c = c;
                c[s / 2] += s % 2;
                faces[&(s / 2, c)]
            };
            let faces = [0, 1, 2, 3, 4, 5].map(face);
            blocks.push(HexahedraBlock { cells: [0, 1, 2].map(|d| hi[d] - lo[d]), nodes, faces });
        }
        (model, fragments, blocks)
    }
}

fn cuts(size: u32, inner: &[u32]) -> Vec<u32> {
    let mut all: Vec<u32> = inner.iter().map(|c| 1 + c % size.max(2).saturating_sub(1)).filter(|c| *c < size).collect();
    all.extend([0, size]);
    all.sort_unstable();
    all.dedup();
    all
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn random_blocks_give_the_identical_mesh(
        size in prop::array::uniform3(1u32..7),
        inner in prop::array::uniform3(prop::collection::vec(0u32..9, 0..3)),
        turns in prop::collection::vec(0u8..8, 200),
        backs in prop::collection::vec(any::<bool>(), 200),
    ) {
        let split = Split { cuts: [0, 1, 2].map(|d| cuts(size[d], &inner[d])) };
        let (model, fragments, blocks) = split.build(|f| turns[f % 200], |e| backs[e % 200]);
        let surface = Merged::new(model, fragments).unwrap();
        // the faces' quadrilaterals are those of the planes, each once
        let quads: usize = (0..3).map(|d| {
            split.cuts[d].len() * (size[(d + 1) % 3] * size[(d + 2) % 3]) as usize
        }).sum();
        prop_assert_eq!(surface.cell_count(), quads);
        let merged = Blocks::new(surface, blocks).unwrap();
        let [a, b, c] = size;
        prop_assert_eq!(merged.node_count() as u32, (a + 1) * (b + 1) * (c + 1));
        prop_assert_eq!(merged.cell_count() as u32, a * b * c);
        let mut lattice = FxHashMap::default();
        for z in 0..=c { for y in 0..=b { for x in 0..=a {
            lattice.insert(key(split.point([x, y, z])), [x, y, z]);
        }}}
        let at: Vec<[u32; 3]> = (0..merged.node_count()).map(|i| lattice[&key(merged.node(i))]).collect();
        let mut once = at.clone();
        once.sort_unstable();
        once.dedup();
        prop_assert_eq!(once.len(), at.len());
        let mut cells: Vec<[[u32; 3]; 8]> =
            (0..merged.cell_count()).map(|j| merged.cell(j).map(|v| at[v as usize])).collect();
        cells.sort_unstable();
        let mut expected = Vec::new();
        for z in 0..c { for y in 0..b { for x in 0..a {
            let corners = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]];
            expected.push(corners.map(|[i, j, k]: [u32; 3]| [x + i, y + j, z + k]));
        }}}
        expected.sort_unstable();
        prop_assert_eq!(cells, expected);
        let surface = merged.hexahedra().surface();
        prop_assert_eq!(surface.triangles.len() as u32, 4 * (a * b + b * c + c * a));
        surface.validate().unwrap();
        let check = crate::quality::check(&surface, crate::quality::Expectation::default(), None, &Run::new()).unwrap();
        prop_assert!(check.closed && check.manifold && check.oriented && check.self_intersections == 0, "{check:?}");
        prop_assert!(check.volume.is_some_and(|v| (v - f64::from(a * b * c)).abs() < 0.5 * f64::from(a * b * c)), "{check:?}");
    }
}

#[test]
fn blocks_are_written_and_drawn() {
    let split = Split { cuts: [vec![0, 2, 4], vec![0, 3], vec![0, 2]] };
    let (model, fragments, blocks) = split.build(|_| 0, |_| false);
    let blocks = Blocks::new(Merged::new(model, fragments).unwrap(), blocks).unwrap().hexahedra();
    let (dir, run) = (tempfile::TempDir::new().unwrap(), Run::new());
    let options = crate::io::WriteOptions::default();
    for (file, says) in [("blocks.vtu", "NumberOfCells=\"76\""), ("blocks.msh", "$Elements"), ("blocks.inp", "C3D8")] {
        let path = dir.path().join(file);
        crate::io::write_hexahedra(&path, &blocks, &options, &run).unwrap();
        let text = String::from_utf8_lossy(&std::fs::read(path).unwrap()).into_owned();
        assert!(text.contains(says), "{file}");
    }
    // Two blocks side by side: what lies between them is not seen, nor among the 52 sides beside the 24 hexahedra.
    let surface = blocks.surface();
    assert_eq!(surface.triangles.len(), 4 * (4 * 3 + 3 * 2 + 2 * 4));
    let options = crate::render::RenderOptions { width: 64, height: 64, ..Default::default() };
    let picture = crate::render::render(&surface, &options, &run).unwrap();
    assert!(picture.rgb.iter().any(|c| *c < 200));
}

#[test]
fn blocks_that_do_not_fit_are_refused() {
    let split = Split { cuts: [vec![0, 2, 4], vec![0, 3], vec![0, 2]] };
    let (model, fragments, blocks) = split.build(|_| 0, |_| false);
    let surface = || Merged::new(model.clone(), fragments.clone()).unwrap();
    let refused = |change: &dyn Fn(&mut Vec<HexahedraBlock>)| {
        let mut blocks = blocks.clone();
        change(&mut blocks);
        Blocks::new(surface(), blocks).unwrap_err().to_string()
    };
    let moved = refused(&|b| b[1].nodes[0].x += 1e-9);
    assert!(moved.starts_with("block 1: it is not node-matched with face"), "{moved}");
    assert!(refused(&|b| b[0].faces[2] = 99).contains("face 99"));
    assert!(refused(&|b| b[0].nodes.truncate(5)).contains("5 nodes"));
    assert!(refused(&|b| b[0].cells = [0, 3, 2]).contains("nodes"));
    assert_eq!(Blocks::new(surface(), blocks.clone()).unwrap().cell_count(), 24);
}
