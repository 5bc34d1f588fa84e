//! What merging allocates: as much as there are fragments, whatever the number of nodes and cells.

#![allow(unsafe_code)]

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

use rvachev::DVec3;
use rvachev::merge::Merged;
use rvachev::mesh::{MeshView, TriMesh};
use rvachev::model::from_mesh;

/// Counts this thread's bytes in use, their largest number, and allocations.
struct Counting;

thread_local! {
    static COUNT: Cell<[usize; 3]> = const { Cell::new([0; 3]) };
}

// Safety: hands everything on to the system's allocator.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        let _ = COUNT.try_with(|c| {
            let [now, most, times] = c.get();
            let now = now.wrapping_add(layout.size());
            c.set([now, if now < usize::MAX / 2 { most.max(now) } else { most }, times + 1]);
        });
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, p: *mut u8, layout: Layout) {
        let _ = COUNT.try_with(|c| {
            let [now, most, times] = c.get();
            c.set([now.wrapping_sub(layout.size()), most, times]);
        });
        unsafe { System.dealloc(p, layout) }
    }
}

#[global_allocator]
static COUNTING: Counting = Counting;

/// A torus of 25 by 10 faces with `n` by `n` quadrilaterals each, in two triangles.
fn torus(n: u32) -> (TriMesh, Vec<u32>) {
    let (a, b) = (25 * n, 10 * n);
    let turn = |i: u32, of: u32| (std::f64::consts::TAU * f64::from(i) / f64::from(of)).sin_cos();
    let mut mesh = TriMesh::default();
    for i in 0..a {
        for j in 0..b {
            let ((su, cu), (sv, cv)) = (turn(i, a), turn(j, b));
            mesh.nodes.push(DVec3::new((10.0 + 3.0 * cv) * cu, (10.0 + 3.0 * cv) * su, 3.0 * sv));
            let at = |i: u32, j: u32| i % a * b + j % b;
            let [p, q, r, s] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            mesh.triangles.extend([[p, q, r], [p, r, s]]);
            mesh.labels.extend([i / n * 10 + j / n; 2]);
        }
    }
    mesh.faces = (0..250).map(|f| f.to_string()).collect();
    (mesh, (0..25).flat_map(|i| (0..10).map(move |j| i * n * b + j * n)).collect())
}

#[test]
fn merging_allocates_per_fragment_and_never_per_node_or_cell() {
    // [bytes kept, most bytes at a time, allocations] for meshes of 8 thousand and 200 thousand cells
    let costs = [4, 20].map(|n| {
        let (mesh, corners) = torus(n);
        let cut = from_mesh(&mesh, &[], &corners).unwrap();
        let before = COUNT.get();
        COUNT.set([before[0], before[0], 0]);
        let view = Merged::new(cut.model, cut.fragments).unwrap();
        let after = COUNT.get();
        assert_eq!((view.node_count(), view.cell_count()), (mesh.nodes.len(), mesh.triangles.len()));
        // looking at all of it allocates a block, however many there are
        let (mut nodes, mut cells) = (0, 0);
        let most = COUNT.get()[0];
        COUNT.set([most, most, 0]);
        let mut node_run = |run: &[DVec3]| {
            nodes += run.len();
            Ok(())
        };
        view.read_nodes(0..view.node_count(), &mut node_run).unwrap();
        let mut cell_run = |run: rvachev::mesh::CellRun| {
            cells += run.corners().len() / 3;
            Ok(())
        };
        view.read_cells(0..view.cell_count(), &mut cell_run).unwrap();
        let [_, peak, times] = COUNT.get();
        assert_eq!((nodes, cells), (view.node_count(), view.cell_count()));
        assert!(peak - most < 32 << 10 && times < 10, "{} bytes, {times} allocations", peak - most);
        [after[0] - before[0], after[1] - before[0], after[2]]
    });
    assert!(costs.iter().all(|[kept, most, _]| *kept <= 256 << 10 && *most <= 256 << 10), "{costs:?}");
    // the guides into prefix sums are powers of two long: up to twice as long as others
    let [few, many] = costs;
    assert_eq!(few[2], many[2], "{costs:?}");
    assert!(few[1].abs_diff(many[1]) < 16 << 10, "{costs:?}");
}
