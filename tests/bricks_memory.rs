//! What merging bricks allocates: a few pieces and what they share, not the mesh.

#![allow(unsafe_code)]

use std::alloc::{GlobalAlloc, Layout, System};
use std::fs;
use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};

use rvachev::Run;
use rvachev::io::{WriteOptions, write};
use rvachev::mesh::MeshView;
use rvachev::pipeline::{BrickPlan, MeshOptions, PlanSource, Share, SizeRequest, make_bricks, merge_on_disk};

/// Counts all threads' bytes in use, and their largest number.
struct Counting;

static NOW: AtomicUsize = AtomicUsize::new(0);
static MOST: AtomicUsize = AtomicUsize::new(0);

// Safety: hands everything on to the system's allocator.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        let now = NOW.fetch_add(layout.size(), Ordering::Relaxed) + layout.size();
        MOST.fetch_max(now, Ordering::Relaxed);
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, p: *mut u8, layout: Layout) {
        NOW.fetch_sub(layout.size(), Ordering::Relaxed);
        unsafe { System.dealloc(p, layout) }
    }
}

#[global_allocator]
static COUNTING: Counting = Counting;

#[test]
fn merging_holds_a_few_pieces_and_never_the_mesh() {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("bricks_memory");
    let _ = fs::remove_dir_all(&folder);
    fs::create_dir_all(&folder).unwrap();
    let part = folder.join("part.py");
    fs::write(&part, "part(box(size=(2, 2, 2)) - cylinder(0.4, axis='x') - cylinder(0.4, axis='z'))\n").unwrap();
    let run = Run::new();
    // [triangles, most bytes at a time] for a mesh, and for one of four times as many triangles in pieces of the same size
    let costs = [(0.04, 2), (0.02, 4)].map(|(size, n)| {
        let options = MeshOptions { size: Some(SizeRequest::Length(size)), ..MeshOptions::default() };
        let plan = BrickPlan::new(PlanSource::read(&part, &[]).unwrap(), &options, [n; 3], &run).unwrap();
        let job = folder.join(n.to_string());
        plan.save(&job).unwrap();
        make_bricks(&plan, &job, Share::ALL, None, &run).unwrap();
        let before = NOW.load(Ordering::Relaxed);
        MOST.store(before, Ordering::Relaxed);
        let merged = merge_on_disk(&plan, &job, &run).unwrap();
        for name in ["a.vtu", "a.stl", "a.ply"] {
            write(&folder.join(name), &merged.mesh, &WriteOptions::default(), &run).unwrap();
        }
        [merged.mesh.cell_count(), MOST.load(Ordering::Relaxed) - before]
    });
    println!("{costs:?}");
    let [few, many] = costs;
    assert!(many[0] > 7 * few[0] / 2, "{costs:?}");
    assert!(many[1] < 60 * many[0], "{costs:?}");
    fs::remove_dir_all(folder).unwrap();
}
