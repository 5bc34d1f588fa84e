//! What merging bricks allocates: a few pieces and what they share, not the mesh.

use std::fs;
use std::path::Path;
use std::sync::atomic::Ordering;

use rvachev::Run;
use rvachev::io::{WriteOptions, write};
use rvachev::mesh::MeshView;
use rvachev::pipeline::{BrickPlan, MeshOptions, PlanSource, Share, SizeRequest, make_bricks, merge_on_disk};

#[path = "common/counting.rs"]
mod counting;
use counting::{MOST, NOW};

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
        let merged = merge_on_disk(&plan, &job, false, &run).unwrap();
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
