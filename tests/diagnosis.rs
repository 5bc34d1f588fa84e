//! What is told of CAD models: sizes, centers of mass, tolerances, and every fault with its place.

use std::fs;
use std::path::Path;

use approx::{assert_abs_diff_eq, assert_relative_eq};
use assert_cmd::Command;
use predicates::str::contains;
use rvachev::implicit::part::parse;
use rvachev::parametric::brep::Brep;
use rvachev::pipeline::{BrepInfo, brep_info, build, diagnose_brep, diagnose_step, load_step, save_step};
use rvachev::{Error, Run};
use serde_json::Value;
use tempfile::TempDir;

const SQUARE: &str = "polyline([(0, 0), (4, 0), (4, 2), (0, 2)], closed=True)";

fn built(text: &str) -> Result<Brep, Error> {
    build(&parse(text, &[])?, &Run::new()).map(Option::unwrap_or_default)
}

fn told(text: &str) -> BrepInfo {
    brep_info(built(text).unwrap_or_else(|e| panic!("{text}: {e}")).into(), None, &Run::new()).unwrap()
}

#[test]
fn info_tells_sizes_bodies_centers_and_tolerance() {
    let text = format!("a = extrude_edges({SQUARE}, 'z', 6)\npart([a.name('a'), a.move((10, 0, 0)).name('b')])");
    let i = told(&text);
    assert_eq!(i.bounds.size, [14.0, 2.0, 6.0]);
    assert!(i.tolerance.is_none() && i.mesh_triangles > 20 && i.mesh_nodes > 10);
    for (b, x) in i.bodies.iter().zip([2.0, 12.0]) {
        let c = b.center.unwrap();
        assert!(c.iter().zip([x, 1.0, 3.0]).all(|(c, t)| (c - t).abs() < 1e-9), "{c:?}");
    }
    assert!(i.faces.iter().all(|f| f.name.starts_with(f.body.as_deref().unwrap())));
    // A half ball: its center of mass is 3/8 of the radius from the middle.
    let half = told(
        "part(revolve_edges(chain([polyline([(0, 0, 0), (2, 0, 0)]), arc((2, 0, 0), (2**0.5, 0, 2**0.5), (0, 0, 2))]), 'z'))",
    );
    let c = half.bodies[0].center.unwrap();
    assert_abs_diff_eq!(c[0], 0.0, epsilon = 1e-5);
    assert_abs_diff_eq!(c[1], 0.0, epsilon = 1e-5);
    assert_abs_diff_eq!(c[2], 0.75, epsilon = 1e-5);
    let dir = TempDir::new().unwrap();
    let path = dir.path().join("a.step");
    save_step(&path, &built(&text).unwrap(), Some("cm")).unwrap();
    let back = load_step(&path, &Run::new()).unwrap();
    let size = (140.0_f64.powi(2) + 20.0_f64.powi(2) + 60.0_f64.powi(2)).sqrt();
    assert_relative_eq!(back.tolerance.unwrap(), 1e-8 * size, epsilon = 0.0, max_relative = 1e-6);
    let i = brep_info(back, Some("mm"), &Run::new()).unwrap();
    assert!(i.to_string().contains("size 140 x 20 x 60 mm") && i.to_string().contains("tolerance "), "{i}");
}

#[test]
fn solids_are_scaled_about_points_and_their_center_of_mass() {
    let solid = format!("extrude_edges({SQUARE}, 'z', 6).move((10, 0, 0))");
    for (about, lo) in
        [("", [20.0, 0.0, 0.0]), (", about=(10, 0, 0)", [10.0, 0.0, 0.0]), (", about='mass'", [8.0, -1.0, -3.0])]
    {
        let i = told(&format!("part(({solid}).name('bar').scale(2{about}))"));
        assert!(i.bounds.lo.iter().zip(lo).all(|(a, b)| (a - b).abs() < 1e-4), "{about}: {:?}", i.bounds);
        assert_relative_eq!(i.bodies[0].volume.unwrap(), 384.0, epsilon = 0.0, max_relative = 1e-9);
        assert_eq!(i.bodies[0].name, "bar");
    }
    for (call, says) in [
        ("extrude_edges(circle(1), 'z', 1, solid=False).scale(2, about='mass')", "a sheet has no mass"),
        ("extrude_edges(circle(1).scale(2, about='mass'), 'z', 1)", "edges have no center of mass"),
        ("extrude_edges(circle(1), 'z', 1).scale(2, about='middle')", "center of mass"),
    ] {
        let e = built(&format!("part({call})")).unwrap_err();
        assert!(e.to_string().contains(says), "{e}");
        assert!(matches!(e, Error::Input { place: rvachev::Place::Text { line: 1, .. }, .. }), "{e:?}");
    }
}

fn rvachev(dir: &Path, args: &[&str]) -> assert_cmd::assert::Assert {
    Command::cargo_bin("rvachev").unwrap().current_dir(dir).args(args).assert()
}

#[test]
fn models_are_checked_and_faults_have_their_places() {
    let dir = TempDir::new().unwrap();
    let data = |n: &str| Path::new(env!("CARGO_MANIFEST_DIR")).join("data/step").join(n).to_string_lossy().into_owned();
    for name in ["torus.step", "sphere.step", "cone_with_apex.step"] {
        rvachev(dir.path(), &["check", &data(name)]).success().stdout(contains("sound yes"));
    }
    let bar = built(&format!("part(extrude_edges([{SQUARE}, circle(0.5).move((2, 1))], 'z', 6).name('bar'))")).unwrap();
    let good = dir.path().join("good.step");
    save_step(&good, &bar, Some("mm")).unwrap();
    rvachev(dir.path(), &["check", "good.step"]).success().stdout(contains("closed"));
    // The first face is taken out of its shell.
    let text = fs::read_to_string(&good).unwrap();
    let shell = text.find("CLOSED_SHELL(").unwrap();
    let list = shell + text[shell..].find("(#").unwrap() + 1;
    let comma = list + text[list..].find(',').unwrap();
    fs::write(dir.path().join("open.step"), format!("{}{}", &text[..list], &text[comma + 1..])).unwrap();
    rvachev(dir.path(), &["check", "open.step"]).failure().stdout(contains("edge with a face on one side only"));
    let out = rvachev(dir.path(), &["check", "open.step", "--json"]).failure().get_output().stdout.clone();
    let found: Value = serde_json::from_slice(&out).unwrap();
    assert_eq!((found["sound"].as_bool(), found["bodies"][0]["closed"].as_bool()), (Some(false), Some(false)));
    let faults = found["faults"].as_array().unwrap();
    assert_eq!(faults.len() as u64, found["bodies"][0]["open_edges"].as_u64().unwrap());
    assert!(
        faults
            .iter()
            .all(|f| f["kind"] == "open_edge" && f["source"].as_u64().unwrap() > 0 && !f["faces"][0].is_null())
    );
    rvachev(dir.path(), &["check", "good.step", "--against", "good.step"]).code(2).stderr(contains("for meshes"));
    rvachev(dir.path(), &["check", "none.step"]).code(3);
    fs::write(dir.path().join("bad.step"), "not a model").unwrap();
    rvachev(dir.path(), &["check", "bad.step"]).code(3);
    // In a library call: what is apart by more than the tolerance that is given.
    let mut off = bar;
    off.vertices[0].z += 0.01;
    let run = Run::new();
    let strict = diagnose_brep(&off, Some(1e-3), &run).unwrap();
    assert!(!strict.sound && strict.faults.iter().all(|f| (f.length.unwrap() - 0.01).abs() < 1e-9), "{strict}");
    assert!(diagnose_brep(&off, Some(0.02), &run).unwrap().sound);
    assert!(diagnose_step(&load_step(&good, &run).unwrap(), &run).unwrap().own_tolerance);
}
