//! Remedies for troubles of faces [BOR20]: for each there is a model that meshes well with it, and worse or not at all without.

use std::path::{Path, PathBuf};

use approx::assert_relative_eq;
use assert_cmd::Command;
use predicates::prelude::*;
use predicates::str::contains;
use rvachev::pipeline::{MeshOptions, Meshed, Remedy, Rung, SizeRequest, load_part, load_step, mesh_part, mesh_step};
use rvachev::quality::Fault;
use rvachev::{Error, Run};

fn trouble(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("data/troubles").join(name)
}

/// A model of the troubles with all remedies, and without one.
fn both(name: &str, remedy: Remedy, options: &MeshOptions) -> [Meshed; 2] {
    let run = Run::new();
    [vec![], vec![remedy]].map(|without| {
        let how = MeshOptions { without, ..options.clone() };
        let path = trouble(name);
        if name.ends_with(".step") {
            mesh_step(load_step(&path, &run).unwrap(), &how, &run).unwrap()
        } else {
            mesh_part(&load_part(&path, &[]).unwrap(), &how, &run).unwrap()
        }
    })
}

fn sound(made: &Meshed) {
    assert!(made.report.shortfalls.is_empty(), "{:?}", made.report.shortfalls);
    assert!(made.report.check.as_ref().unwrap().certificate.is_sound());
}

fn has_rung(made: &Meshed, rung: Rung) -> bool {
    made.report.ladder.iter().any(|s| s.rung == rung)
}

fn lacks_faces(made: &Meshed) -> usize {
    made.report.shortfalls.iter().filter(|f| matches!(f, Fault::NoMesh { .. })).count()
}

/// The least and the largest angle.
fn angles(made: &Meshed) -> [f64; 2] {
    let q = &made.report.check.as_ref().unwrap().quality;
    [q.min_angle, q.max_angle]
}

#[test]
fn contours_that_cross_need_halving() {
    let [with, without] = both("crossing_contours.py", Remedy::Halving, &MeshOptions::default());
    sound(&with);
    assert!(has_rung(&with, Rung::FinerEdges) && !has_rung(&without, Rung::FinerEdges));
    assert_eq!(lacks_faces(&without), 2, "{:?}", without.report.shortfalls);
}

/// The narrow faces are 0.042 wide; edges along them are to be 0.5 long, but for a few beside their short ends.
#[test]
fn narrow_faces_need_the_least_length() {
    let [with, without] = both("least_length.py", Remedy::LeastLength, &MeshOptions::default());
    sound(&with);
    for made in [&with, &without] {
        assert_relative_eq!(made.mesh.volume(), 3200.0 - 8.0 * 0.03 * 0.03, epsilon = 0.0, max_relative = 1e-12);
    }
    let bevels = |made: &Meshed| {
        let narrow = |t: &usize| {
            let n = made.mesh.area_vector(*t).normalize();
            n.x > 0.5 && n.y.abs() > 0.5
        };
        (0..made.mesh.triangles.len()).filter(narrow).count()
    };
    // Two strips as long as 8: edges of 0.5 make 32 triangles of each, edges hardly longer than the width many more.
    assert!(bevels(&with) <= 100 && bevels(&without) > 500, "{} {}", bevels(&with), bevels(&without));
    let [few, many] = [&with, &without].map(|m| m.mesh.triangles.len());
    assert!(many > 3 * few, "{few} {many}");
}

#[test]
fn a_surface_that_ends_before_its_pole_needs_the_plane() {
    let [with, without] = both("open_pole.step", Remedy::Plane, &MeshOptions::default());
    sound(&with);
    assert!(has_rung(&with, Rung::Plane) && with.report.check.as_ref().unwrap().closed);
    assert_eq!(lacks_faces(&without), 1, "{:?}", without.report.shortfalls);
}

#[test]
fn curvatures_of_tips_need_the_inset() {
    let how = MeshOptions { tolerance: Some(SizeRequest::Length(0.1)), ..MeshOptions::default() };
    let [with, without] = both("wide_tip.py", Remedy::Inset, &how).map(|m| {
        assert!(m.report.check.as_ref().unwrap().closed);
        angles(&m)
    });
    assert!(with[0] > 30.0 && with[1] < 100.0 && without[0] < 1.0 && without[1] > 175.0, "{with:?} {without:?}");
}

#[test]
fn narrow_necks_need_trimming() {
    let [with, without] = both("narrow_neck.py", Remedy::Trim, &MeshOptions::default());
    sound(&with);
    assert!(has_rung(&with, Rung::Trimmed) && !has_rung(&without, Rung::Trimmed));
    let [with, without] = [angles(&with), angles(&without)];
    assert!(with[0] > 35.0 && without[0] < 1.0 && without[1] > 175.0, "{with:?} {without:?}");
}

#[test]
fn remedies_are_known_by_name_and_to_boundaries_alone() {
    for r in Remedy::ALL {
        assert_eq!(r.to_string().parse::<Remedy>().unwrap(), r);
    }
    let dir = tempfile::TempDir::new().unwrap();
    let rvachev = |part: &Path, more: &[&str]| {
        let mut c = Command::cargo_bin("rvachev").unwrap();
        c.current_dir(&dir).arg("mesh").arg(part).args(["-o", "a.off", "--without"]).args(more).assert()
    };
    let names = "halving, least-length, plane, inset, trim";
    rvachev(&trouble("seam.py"), &["hope"]).code(2).stderr(contains("hope").and(contains(names)));
    rvachev(&trouble("narrow_neck.py"), &["trim", "--trim", "0.1"]).code(2).stderr(contains("trim"));
    rvachev(Path::new("a.stl"), &["plane"]).code(2).stderr(contains("CAD models"));
    std::fs::write(dir.path().join("ball.py"), "part(sphere(1))\n").unwrap();
    rvachev(Path::new("ball.py"), &["plane"]).code(2).stderr(contains("CAD models"));
    assert!(!dir.path().join("a.off").exists());
    let run = Run::new();
    let how = MeshOptions { without: vec![Remedy::Plane], ..MeshOptions::default() };
    let ball = load_part(&dir.path().join("ball.py"), &[]).unwrap();
    assert!(matches!(mesh_part(&ball, &how, &run), Err(Error::Usage(_))));
}
