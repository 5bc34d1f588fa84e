//! Solids whose remeshed triangles would cross: those of the arrangement stay there, and are put right without crossing any.

use rvachev::Run;
use rvachev::implicit::part::parse;
use rvachev::mesh::self_intersections;
use rvachev::pipeline::{Change, MeshOptions, Meshed, mesh_part};

/// A quartic blended to a box. The radius is one of the function's, so the fillet is a 30th of it wide where the quartic is steep.
const BLENDED: &str = "
a = solid((x - 0.82)**4 + (y - 0.3)**4 + z**4 <= 0.747).name(\"quartic\")
b = box(size=(2.2, 2.2, 1.2), at=(1.4, 1.5, 0.25)).name(\"box\")
part(blend(a, b, 0.05))
mesh(size=0.25)
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
    assert_eq!((kept, report.attempts.len()), (vec![Change::KeepHere], 2), "{:?}", report.attempts);
    assert_eq!(report.shortfalls, Vec::new());
    assert_eq!(self_intersections(&made.mesh, &Run::new()).unwrap(), Vec::<[u32; 2]>::new());
    let check = report.check.as_ref().unwrap();
    let (d, f) = (check.deviation.unwrap(), check.features.unwrap());
    assert!(check.certificate.is_sound() && check.euler == 2, "{:?}", check.certificate);
    assert!(d.inverted == 0 && d.max < 0.035 * 0.25 && d.from_surface.unwrap() < 0.035 * 0.25, "{d:?}");
    assert!(f.recall > 0.99 && f.precision > 0.99 && f.corners_found == f.corners_true, "{f:?}");
    // Nodes that are not on their surfaces are told.
    assert!(report.warnings.iter().any(|w| w.contains("nodes are not on their surfaces")), "{:?}", report.warnings);
    assert!(check.quality.min_angle > 1.0 && check.quality.p05_angle > 25.0, "{:?}", check.quality);
}

#[test]
fn threads_make_no_difference_where_triangles_stay() {
    assert_eq!(meshed(1).mesh, meshed(2).mesh);
}
