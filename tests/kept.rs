//! Solids whose remeshed triangles would cross: those of the arrangement stay there, and are put right without crossing any.

use rvachev::Run;
use rvachev::implicit::part::parse;
use rvachev::mesh::self_intersections;
use rvachev::pipeline::{Change, MeshOptions, Meshed, mesh_part};

/// Two blocks with a fillet that ends in a slanted face, a tenth as wide as the size: where it ends the surfaces touch, and interpolants of them
/// cross each other.
const BLENDED: &str = "
block = box(lo=(-1, 0, -1), hi=(1, 1.75, 1.5)).name(\"block\")
bar = box(size=(1.82, 0.74, 0.92), at=(0.47, 1.4, -0.19)).rotate(17, axis=\"x\").name(\"bar\")
part(blend(block, bar, 0.1))
mesh(size=0.5)
";

fn meshed(threads: usize) -> Meshed {
    let run = Run::new().with_threads(threads).unwrap();
    mesh_part(&parse(BLENDED, &[]).unwrap(), &MeshOptions::default(), &run).unwrap()
}

#[test]
fn no_triangles_cross_where_those_of_the_arrangement_stay() {
    let made = meshed(2);
    let report = &made.report;
    let kept: Vec<Change> = report.attempts.iter().filter(|a| a.kept).map(|a| a.change).collect();
    assert_eq!(kept, vec![Change::KeepHere], "{:?}", report.attempts);
    assert_eq!(report.shortfalls, Vec::new());
    assert_eq!(self_intersections(&made.mesh, &Run::new()).unwrap(), Vec::<[u32; 2]>::new());
    let check = report.check.as_ref().unwrap();
    let (d, f) = (check.deviation.unwrap(), check.features.unwrap());
    assert!(check.certificate.is_sound() && check.euler == 2, "{:?}", check.certificate);
    assert!(d.inverted == 0 && d.max < 0.035 * 0.5 && d.from_surface.unwrap() < 0.035 * 0.5, "{d:?}");
    assert!(f.recall > 0.99 && f.precision > 0.99 && f.corners_found + 1 >= f.corners_true, "{f:?}");
    // Nodes that are not on their surfaces are told.
    assert!(report.warnings.iter().any(|w| w.contains("nodes are not on their surfaces")), "{:?}", report.warnings);
    assert!(check.quality.p05_angle > 24.0, "{:?}", check.quality);
}

#[test]
fn threads_make_no_difference_where_triangles_stay() {
    assert_eq!(meshed(1).mesh, meshed(2).mesh);
}
