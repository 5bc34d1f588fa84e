//! Both tables of [LAZ] section 5, its comparison with plain arrays, and merging by distance: `cargo bench --bench merge`.
//!
//! A torus cut into node-matched patches stands for the paper's parts: as many faces, about as many cells. Everything is
//! measured on one thread (`-- --threads N` for the parallel rows) in one run, so ratios mean something on any machine.
//! `-- --python PATH` names a Python that has vtk and numpy; without it that row is skipped.

use std::hint::black_box;
use std::path::Path;
use std::process::Command;
use std::sync::atomic::Ordering;
use std::time::Instant;

use kiddo::{ImmutableKdTree, SquaredEuclidean};
use rayon::prelude::*;
use rvachev::merge::{Merged, Replacement};
use rvachev::mesh::view::par_ranges;
use rvachev::mesh::{CellRun, MeshView, TriMesh};
use rvachev::model::{BorderNodes, Cells, FaceFragment, Fragments, Model, from_mesh};
use rvachev::{DVec3, Run};

#[path = "../tests/common/counting.rs"]
mod counting;
use counting::{MOST, NOW};

/// Seconds, and bytes: kept afterwards, and at most while it ran.
struct Cost {
    seconds: f64,
    kept: usize,
    most: usize,
}

/// The least time of `times` runs, and the memory of the last.
fn cost<T>(times: usize, mut work: impl FnMut() -> T) -> (T, Cost) {
    let mut seconds = f64::INFINITY;
    for k in 0.. {
        let before = NOW.load(Ordering::Relaxed);
        MOST.store(before, Ordering::Relaxed);
        let start = Instant::now();
        let result = black_box(work());
        seconds = seconds.min(start.elapsed().as_secs_f64());
        let (now, most) = (NOW.load(Ordering::Relaxed), MOST.load(Ordering::Relaxed));
        if k + 1 >= times {
            return (result, Cost { seconds, kept: now.saturating_sub(before), most: most - before });
        }
    }
    unreachable!()
}

/// A torus of `faces[0]` by `faces[1]` patches of `cells[0]` by `cells[1]` quadrilaterals, two triangles each, cut into
/// one fragment per patch.
fn composite(faces: [usize; 2], cells: [usize; 2]) -> (Model, Fragments) {
    let [n, m] = [faces[0] * cells[0], faces[1] * cells[1]];
    let turn = |i: usize, n: usize| (std::f64::consts::TAU * i as f64 / n as f64).sin_cos();
    let mut mesh = TriMesh::default();
    for i in 0..n {
        for j in 0..m {
            let ((su, cu), (sv, cv)) = (turn(i, n), turn(j, m));
            mesh.nodes.push(DVec3::new((10.0 + 3.0 * cv) * cu, (10.0 + 3.0 * cv) * su, 3.0 * sv));
            let at = |i: usize, j: usize| (i % n * m + j % m) as u32;
            let [p, q, r, s] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            mesh.triangles.extend([[p, q, r], [p, r, s]]);
            mesh.labels.extend([(i / cells[0] * faces[1] + j / cells[1]) as u32; 2]);
        }
    }
    mesh.faces = (0..faces[0] * faces[1]).map(|f| format!("face {f}")).collect();
    let corner = |i: usize, j: usize| (i * cells[0] * m + j * cells[1]) as u32;
    let corners: Vec<u32> = (0..faces[0]).flat_map(|i| (0..faces[1]).map(move |j| corner(i, j))).collect();
    let cut = from_mesh(&mesh, &[], &corners).expect("a torus can be cut");
    (cut.model, cut.fragments)
}

/// Nodes that stand in more than one fragment, counted each time but the first.
fn duplicates(fragments: &Fragments, view: &dyn MeshView) -> usize {
    fragments.faces().map(|f| f.border().len() + f.inner().len()).sum::<usize>() - view.node_count()
}

/// Merges `times` times: the merged mesh, and what merging costs.
fn merged((mut model, mut fragments): (Model, Fragments), times: usize) -> (Merged, Cost) {
    let mut least = f64::INFINITY;
    for k in 0.. {
        let mut parts = Some((model, fragments));
        let (view, mut cost) = cost(1, || {
            let (model, fragments) = parts.take().expect("merged once");
            Merged::new(model, fragments).expect("fragments are node-matched")
        });
        least = least.min(cost.seconds);
        if k + 1 >= times {
            cost.seconds = least;
            return (view, cost);
        }
        (model, fragments) = view.into_parts();
    }
    unreachable!()
}

// -------------------------------------------------------------------------------------------------- what readers do

fn bits(nodes: &[DVec3]) -> u64 {
    nodes.iter().flat_map(|p| p.to_array()).fold(0, |sum, x| sum.wrapping_add(x.to_bits()))
}

fn numbers(corners: &[u32]) -> u32 {
    corners.iter().fold(0, |sum, v| sum.wrapping_add(*v))
}

/// A checksum that depends on the order of the corners, so that they are looked at one by one, as a writer does.
fn in_order(sum: u32, corners: &[u32]) -> u32 {
    corners.iter().fold(sum, |sum, v| (sum ^ v).wrapping_mul(0x0100_0193))
}

fn read_nodes(view: &dyn MeshView, range: std::ops::Range<usize>) -> u64 {
    let mut sum = 0u64;
    let _ = view.read_nodes(range, &mut |nodes| {
        sum = sum.wrapping_add(bits(nodes));
        Ok(())
    });
    sum
}

fn read_corners(view: &dyn MeshView, range: std::ops::Range<usize>) -> u32 {
    let mut sum = 0;
    let _ = view.read_cells(range, &mut |run: CellRun| {
        sum = in_order(sum, run.corners());
        Ok(())
    });
    sum
}

fn read_cells(view: &dyn MeshView, range: std::ops::Range<usize>) -> u32 {
    let mut sum = 0u32;
    let _ = view.read_cells(range, &mut |run: CellRun| {
        sum = sum.wrapping_add(numbers(run.corners()));
        Ok(())
    });
    sum
}

/// Numbers below `count` in an order no cache foresees.
fn scattered(count: usize, length: usize) -> Vec<u32> {
    let mut x = 0x2545_f491_4f6c_dd1du64;
    let mut next = || {
        x ^= x << 13;
        x ^= x >> 7;
        x ^= x << 17;
        (x % count as u64) as u32
    };
    (0..length).map(|_| next()).collect()
}

fn mega(count: usize, seconds: f64) -> f64 {
    count as f64 / seconds / 1e6
}

/// The sum and the cost of looking at cells one by one.
fn each(cells: &[u32], one: impl Fn(usize) -> u32) -> (u32, Cost) {
    cost(1, || cells.iter().fold(0u32, |s, j| s.wrapping_add(one(*j as usize))))
}

/// Random accesses measured at a time.
const WINDOW: usize = 1 << 14;

fn access(view: &Merged) {
    let plain = TriMesh::from_view(view);
    let (n, m) = (view.node_count(), view.cell_count());
    let times = (40_000_000 / m).clamp(20, 400);
    let row = |what: &str, count: usize, ours: f64, array: f64| {
        println!(
            "  {what:<28} {:>8.0} M/s of {:>6.0} M/s from arrays: {:.2}",
            mega(count, ours),
            mega(count, array),
            array / ours
        );
    };
    let (a, ours) = cost(times, || read_nodes(view, 0..n));
    let (b, array) = cost(times, || bits(black_box(&plain.nodes)));
    assert_eq!(a, b);
    row("nodes one after the other", n, ours.seconds, array.seconds);
    let (a, ours) = cost(times / 4, || read_corners(view, 0..m));
    let (b, array) = cost(times / 4, || in_order(0, black_box(&plain.triangles).as_flattened()));
    assert_eq!(a, b);
    row("cells one after the other", m, ours.seconds, array.seconds);
    let (a, ours) = cost(times, || read_cells(view, 0..m));
    let (b, array) = cost(times, || numbers(black_box(&plain.triangles).as_flattened()));
    assert_eq!(a, b);
    row("the same, only added up", m, ours.seconds, array.seconds);
    // Windows of one long order: short enough not to be interrupted, and never the same nodes twice.
    let order = scattered(n, 1 << 20);
    let mut sums = [0u64; 2];
    let (mut ours, mut array) = (f64::INFINITY, f64::INFINITY);
    for window in order.chunks(WINDOW) {
        let (a, x) = cost(1, || window.iter().fold(0u64, |s, i| s.wrapping_add(bits(&[view.node(*i as usize)]))));
        let (b, y) = cost(1, || window.iter().fold(0u64, |s, i| s.wrapping_add(bits(&[plain.nodes[*i as usize]]))));
        (ours, array) = (ours.min(x.seconds), array.min(y.seconds));
        (sums[0], sums[1]) = (sums[0].wrapping_add(a), sums[1].wrapping_add(b));
    }
    assert_eq!(sums[0], sums[1]);
    row("nodes at random", WINDOW, ours, array);
    let order = scattered(m, 1 << 20);
    let windows: Vec<&[u32]> = order.chunks(WINDOW).collect();
    let mut list = Vec::new();
    let (mut sums, mut least) = ([0u32; 4], [f64::INFINITY; 4]);
    for k in 0..windows.len() {
        // in turns, each at a window of its own: none finds in the cache what another left there
        let window = |way: usize| windows[(k + way * windows.len() / 4) % windows.len()];
        let found = [
            each(window(0), |j| numbers(&plain.triangles[j])),
            each(window(1), |j| numbers(&view.triangle(j).unwrap_or_default())),
            each(window(2), |j| view.cell(j).fold(0, u32::wrapping_add)),
            cost(1, || {
                view.triangles_at(window(3), &mut list);
                numbers(list.as_flattened())
            }),
        ];
        for (way, (sum, cost)) in found.into_iter().enumerate() {
            (sums[way], least[way]) = (sums[way].wrapping_add(sum), least[way].min(cost.seconds));
        }
    }
    assert!(sums.iter().all(|s| *s == sums[0]));
    row("cells at random", WINDOW, least[1], least[0]);
    row("cells of any kind at random", WINDOW, least[2], least[0]);
    row("cells at random, by lists", WINDOW, least[3], least[0]);
    let (_, copy) = cost(5, || TriMesh::from_view(view));
    println!("  copied to arrays in {:.2} ms", 1e3 * copy.seconds);
}

// --------------------------------------------------------------------------------------------------- merging by distance

/// Fragments as a program without topology has them: every fragment's nodes and triangles one after the other.
fn soup(fragments: &Fragments) -> (Vec<DVec3>, Vec<[u32; 3]>) {
    let (mut nodes, mut triangles) = (Vec::new(), Vec::new());
    for face in fragments.faces() {
        let first = nodes.len() as u32;
        nodes.extend(face.nodes());
        for j in 0..face.cells().len() {
            let corners = face.cells().corners(j);
            triangles.push([0, 1, 2].map(|k| corners.as_ref()[k] + first));
        }
    }
    (nodes, triangles)
}

/// Keeps the nodes that represent themselves and renumbers triangles.
fn compact(nodes: &[DVec3], triangles: &[[u32; 3]], same_as: &[u32]) -> (Vec<DVec3>, Vec<[u32; 3]>) {
    let mut new = vec![0u32; nodes.len()];
    let mut kept = Vec::new();
    for (i, p) in nodes.iter().enumerate() {
        if same_as[i] == i as u32 {
            new[i] = kept.len() as u32;
            kept.push(*p);
        } else {
            new[i] = new[same_as[i] as usize];
        }
    }
    (kept, triangles.iter().map(|t| t.map(|v| new[v as usize])).collect())
}

/// Lengths below this are no distance: far above rounding, far below the shortest edge.
const TOLERANCE: f64 = 1e-9;

fn by_kd_tree(nodes: &[DVec3], triangles: &[[u32; 3]]) -> (Vec<DVec3>, Vec<[u32; 3]>) {
    let points: Vec<[f64; 3]> = nodes.iter().map(|p| p.to_array()).collect();
    let tree = ImmutableKdTree::new_from_slice(&points).expect("a tree of points");
    let near = |p: &[f64; 3]| {
        let found = tree.query(p).within::<SquaredEuclidean<f64>>(TOLERANCE * TOLERANCE).unsorted().execute();
        found.iter().map(|x| x.item).min().expect("at least itself")
    };
    let same_as: Vec<u32> = points.iter().map(near).collect();
    compact(nodes, triangles, &same_as)
}

fn by_sorting(nodes: &[DVec3], triangles: &[[u32; 3]]) -> (Vec<DVec3>, Vec<[u32; 3]>) {
    let key = |p: &DVec3| (*p / (100.0 * TOLERANCE)).round().to_array().map(|x| x as i64);
    let mut keys: Vec<([i64; 3], u32)> = nodes.iter().enumerate().map(|(i, p)| (key(p), i as u32)).collect();
    keys.sort_unstable();
    let mut same_as = vec![0; nodes.len()];
    for group in keys.chunk_by(|a, b| a.0 == b.0) {
        group.iter().for_each(|(_, i)| same_as[*i as usize] = group[0].1);
    }
    compact(nodes, triangles, &same_as)
}

/// vtkStaticCleanPolyData in a process of its own, its arrays loaded before the clock starts.
fn by_vtk(python: &str, nodes: &[DVec3], triangles: &[[u32; 3]]) -> Result<(f64, f64, usize), String> {
    const SCRIPT: &str = r#"
import sys, time, numpy as np, vtk
from vtk.util.numpy_support import numpy_to_vtk, numpy_to_vtkIdTypeArray
def peak():
    return [int(l.split()[1]) * 1024 for l in open("/proc/self/status") if l.startswith("VmHWM")][0]
V = np.fromfile(sys.argv[1] + "/nodes").reshape(-1, 3)
T = np.fromfile(sys.argv[1] + "/triangles", np.uint32).astype(np.int64)
vtk.vtkSMPTools.Initialize(1)
pd = vtk.vtkPolyData(); p = vtk.vtkPoints(); p.SetData(numpy_to_vtk(V)); pd.SetPoints(p)
c = vtk.vtkCellArray(); c.SetData(numpy_to_vtkIdTypeArray(np.arange(0, len(T) + 1, 3)), numpy_to_vtkIdTypeArray(T))
pd.SetPolys(c)
best = 1e9
for _ in range(3):
    f = vtk.vtkStaticCleanPolyData(); f.SetInputData(pd); f.ToleranceIsAbsoluteOn(); f.SetAbsoluteTolerance(1e-9)
    try: open("/proc/self/clear_refs", "w").write("5")
    except OSError: pass
    m = peak(); t = time.perf_counter(); f.Update(); best = min(best, time.perf_counter() - t); m = peak() - m
print(best, m, f.GetOutput().GetNumberOfPoints())
"#;
    let folder = tempfile::tempdir().map_err(|e| e.to_string())?;
    let save = |name: &str, bytes: Vec<u8>| std::fs::write(folder.path().join(name), bytes).map_err(|e| e.to_string());
    save("nodes", nodes.iter().flat_map(|p| p.to_array()).flat_map(f64::to_le_bytes).collect())?;
    save("triangles", triangles.as_flattened().iter().flat_map(|v| v.to_le_bytes()).collect())?;
    let run = Command::new(python).args(["-c", SCRIPT]).arg(folder.path()).output().map_err(|e| e.to_string())?;
    let text = String::from_utf8_lossy(&run.stdout).into_owned();
    let mut words = text.split_whitespace().map(str::parse::<f64>);
    match (words.next(), words.next(), words.next()) {
        (Some(Ok(seconds)), Some(Ok(bytes)), Some(Ok(count))) => Ok((seconds, bytes, count as usize)),
        _ => Err(String::from_utf8_lossy(&run.stderr).trim().lines().last().unwrap_or("no output").to_owned()),
    }
}

// --------------------------------------------------------------------------------------------------------------- tables

/// Rows of table 1: faces, and thousands of cells.
const TABLE_1: [([usize; 2], f64); 6] = [
    ([103, 1], 51.364),
    ([103, 1], 393.254),
    ([47, 4], 36.480),
    ([47, 4], 67.968),
    ([47, 2], 40.404),
    ([47, 2], 245.733),
];

/// Rows of table 2: thousands of cells and of duplicate nodes, on 250 faces.
const TABLE_2: [[f64; 2]; 10] = [
    [17.5, 3.7],
    [32.6, 8.7],
    [53.4, 12.3],
    [115.5, 18.6],
    [195.6, 24.8],
    [338.2, 34.7],
    [507.1, 44.6],
    [755.4, 56.7],
    [1002.4, 66.6],
    [2481.5, 107.0],
];

/// Sides of patches with about this many cells and duplicate nodes each: `2 a b` and `a + b + 1`.
fn sides(cells: f64, duplicates: f64) -> [usize; 2] {
    let (product, sum) = (cells / 2.0, duplicates - 1.0);
    let half = sum / 2.0;
    let a = (half - (half * half - product).max(0.0).sqrt()).round().max(2.0);
    [a as usize, (product / a).round() as usize]
}

fn main() {
    let arguments: Vec<String> = std::env::args().collect();
    let value = |name: &str| arguments.iter().position(|a| a == name).and_then(|i| arguments.get(i + 1));
    let threads = value("--threads").and_then(|t| t.parse().ok()).unwrap_or(2);
    let run = |n| Run::new().with_threads(n).expect("threads");
    run(1).install(|| {
        table_1();
        let largest = table_2();
        let (view, merging) = largest;
        println!("\nAccess, {} nodes, {} cells, 250 faces", view.node_count(), view.cell_count());
        access(&view);
        parallel(&view, &run(threads), threads);
        editing(view.clone());
        many();
        by_distance(&view, &merging, value("--python").map(String::as_str));
    });
}

fn table_1() {
    println!(
        "Table 1. Merging, and reading all nodes / cells / cells only added up 100 times (100 times the quickest)"
    );
    println!("faces | nodes / cells | merged in, ms | read, s | from arrays, s | arrays / ours");
    for (faces, thousands) in TABLE_1 {
        let product = thousands * 1e3 / (2 * faces[0] * faces[1]) as f64;
        let a = product.sqrt().round().max(2.0);
        let (view, merging) = merged(composite(faces, [a as usize, (product / a).round() as usize]), 5);
        let plain = TriMesh::from_view(&view);
        let (n, m) = (view.node_count(), view.cell_count());
        let hundred = |work: &dyn Fn() -> u64| 100.0 * cost(100, work).1.seconds;
        let ours = [
            hundred(&|| read_nodes(&view, 0..n)),
            hundred(&|| u64::from(read_corners(&view, 0..m))),
            hundred(&|| u64::from(read_cells(&view, 0..m))),
        ];
        let array = [
            hundred(&|| bits(black_box(&plain.nodes))),
            hundred(&|| u64::from(in_order(0, black_box(&plain.triangles).as_flattened()))),
            hundred(&|| u64::from(numbers(black_box(&plain.triangles).as_flattened()))),
        ];
        println!(
            "{:>5} | {n} / {m} | {:.3} | {} | {} | {}",
            faces[0] * faces[1],
            1e3 * merging.seconds,
            ours.map(|s| format!("{s:.4}")).join(" / "),
            array.map(|s| format!("{s:.4}")).join(" / "),
            [0, 1, 2].map(|k| format!("{:.2}", array[k] / ours[k])).join(" / ")
        );
    }
}

fn table_2() -> (Merged, Cost) {
    println!("\nTable 2. Merging on 250 faces");
    println!(
        "nodes / cells, thousands | duplicate nodes, thousands | merged in, ms | before, MB | after, MB | increment, KB (most while merging)"
    );
    let mut last = None;
    for [cells, doubles] in TABLE_2 {
        let before = NOW.load(Ordering::Relaxed);
        let cut = composite([25, 10], sides(cells * 4.0, doubles * 4.0));
        let size = (NOW.load(Ordering::Relaxed) - before) as f64;
        let (view, cost) = merged(cut, 5);
        println!(
            "{:.1} / {:.1} | {:.1} | {:.3} | {:.3} | {:.3} | {:.0} ({:.0})",
            view.node_count() as f64 / 1e3,
            view.cell_count() as f64 / 1e3,
            duplicates(view.fragments(), &view) as f64 / 1e3,
            1e3 * cost.seconds,
            size / 1e6,
            (size + cost.kept as f64) / 1e6,
            cost.kept as f64 / 1e3,
            cost.most as f64 / 1e3,
        );
        last = Some((view, cost));
    }
    last.expect("the table has rows")
}

fn parallel(view: &Merged, run: &Run, threads: usize) {
    /// Short enough that some of them find all cores free.
    const TIMES: usize = 300;
    let plain = TriMesh::from_view(view);
    let gain = |view: &dyn MeshView| {
        let (n, m) = (view.node_count(), view.cell_count());
        let nodes = || par_ranges(n).map(|r| read_nodes(view, r)).reduce(|| 0, u64::wrapping_add);
        let cells = || par_ranges(m).map(|r| read_cells(view, r)).reduce(|| 0, u32::wrapping_add);
        let both = || [cost(TIMES, nodes).1.seconds, cost(TIMES, cells).1.seconds];
        let (one, many) = (both(), run.install(both));
        [one[0] / many[0], one[1] / many[1]]
    };
    let (ours, arrays) = (gain(view), gain(&plain));
    println!(
        "  on {threads} threads instead of 1: nodes {:.2} times as fast (arrays {:.2}), cells {:.2} times (arrays {:.2})",
        ours[0], arrays[0], ours[1], arrays[1]
    );
}

fn editing(mut view: Merged) {
    let face = view.fragments().face(100);
    let Cells::ShortTriangles([cells @ .., _]) = face.cells() else { return };
    let segments: Vec<u32> = face.stretches().collect();
    let border = BorderNodes::First(face.border().len() as u32);
    let other = FaceFragment::new(face.nodes().copied().collect(), Cells::ShortTriangles(cells), &border, &[segments]);
    let face = face.to_fragment();
    let (_, moved) = cost(20, || view.move_inner(100, |p| p.z += 1e-3));
    let mut replace = |with: FaceFragment| {
        let mut with = Some(Replacement { faces: vec![(100, with)], ..Replacement::default() });
        cost(20, || with = view.replace(with.take().expect("what was replaced")).ok()).1.seconds
    };
    let [same, other] = [replace(face), replace(other.expect("a cell less is good"))];
    println!(
        "  one face: inner nodes moved in {:.2} us, replaced in {:.2} us, by one with another number of cells in {:.2} us",
        1e6 * moved.seconds,
        1e6 * same,
        1e6 * other
    );
}

fn many() {
    let (view, cost) = merged(composite([100, 100], [10, 10]), 3);
    println!(
        "\n10 000 faces, {} nodes, {} cells: merged in {:.2} ms, {:.0} KB",
        view.node_count(),
        view.cell_count(),
        1e3 * cost.seconds,
        cost.kept as f64 / 1e3
    );
    access(&view);
}

fn by_distance(view: &Merged, merging: &Cost, python: Option<&str>) {
    let (nodes, triangles) = soup(view.fragments());
    println!("\nMerging the same fragments otherwise: {} nodes to {}", nodes.len(), view.node_count());
    println!("method | s | times as long | memory, MB | times as much");
    let row = |method: &str, seconds: f64, bytes: f64, count: usize| {
        assert_eq!(count, view.node_count(), "{method}");
        println!(
            "{method} | {seconds:.6} | {:.0} | {:.3} | {:.0}",
            seconds / merging.seconds,
            bytes / 1e6,
            bytes / merging.most as f64
        );
    };
    row("functional", merging.seconds, merging.most as f64, view.node_count());
    let (copy, cost_of_copy) = cost(3, || TriMesh::from_view(view));
    row(
        "functional, copied to arrays",
        merging.seconds + cost_of_copy.seconds,
        cost_of_copy.most as f64,
        copy.nodes.len(),
    );
    let (found, sorting) = cost(3, || by_sorting(&nodes, &triangles));
    row("sort and unique", sorting.seconds, sorting.most as f64, found.0.len());
    let (found, tree) = cost(3, || by_kd_tree(&nodes, &triangles));
    row("kd-tree (kiddo)", tree.seconds, tree.most as f64, found.0.len());
    match python.filter(|p| Path::new(p).exists()).map(|p| by_vtk(p, &nodes, &triangles)) {
        Some(Ok((seconds, bytes, count))) => row("vtkStaticCleanPolyData", seconds, bytes, count),
        Some(Err(why)) => println!("vtkStaticCleanPolyData | skipped: {why}"),
        None => println!("vtkStaticCleanPolyData | skipped: no Python with vtk, see --python"),
    }
}
