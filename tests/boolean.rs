//! Set operations on meshes, STEP models, bodies built from edges and solids of R-functions, against closed forms.

use std::f64::consts::PI;
use std::path::{Path, PathBuf};

use approx::{abs_diff_eq, assert_abs_diff_eq, assert_relative_eq};
use rvachev::mesh::TriMesh;
use rvachev::pipeline::{self, MeshOptions, Meshed};
use rvachev::{DVec3, Error, Result, Run};

/// A folder of this test's own.
fn folder(name: &str) -> PathBuf {
    let path = std::env::temp_dir().join(format!("rvachev-boolean-{}-{name}", std::process::id()));
    std::fs::create_dir_all(&path).unwrap();
    path
}

/// The corners and triangles of a box, wound outwards.
fn cuboid(lo: [f64; 3], hi: [f64; 3]) -> String {
    let mut off = String::from("OFF\n8 12 0\n");
    for k in 0..8 {
        let p: Vec<String> = (0..3).map(|i| if k >> i & 1 == 1 { hi[i] } else { lo[i] }.to_string()).collect();
        off += &format!("{}\n", p.join(" "));
    }
    for q in [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]] {
        off += &format!("3 {} {} {}\n3 {} {} {}\n", q[0], q[1], q[2], q[0], q[2], q[3]);
    }
    off
}

fn meshed(folder: &Path, text: &str) -> Result<Meshed> {
    let path = folder.join("part.py");
    std::fs::write(&path, text).unwrap();
    let part = pipeline::load_part(&path, &[])?;
    pipeline::mesh_part(&part, &MeshOptions::default(), &Run::new())
}

/// Sound, without anything that falls short.
fn sound(folder: &Path, text: &str) -> Meshed {
    let made = meshed(folder, text).unwrap_or_else(|e| panic!("{text}: {e}"));
    let check = made.report.check.as_ref().unwrap();
    assert!(check.certificate.is_sound(), "{text}: {}", check.certificate);
    assert!(made.report.shortfalls.is_empty(), "{text}: {:?}", made.report.shortfalls);
    made
}

/// Nodes between two faces.
fn border(mesh: &TriMesh, a: &str, b: &str) -> Vec<DVec3> {
    let on = |name: &str| {
        let mut on = vec![false; mesh.nodes.len()];
        for (t, l) in mesh.triangles.iter().zip(&mesh.labels).filter(|x| mesh.faces[*x.1 as usize] == name) {
            assert!((*l as usize) < mesh.faces.len());
            t.iter().for_each(|v| on[*v as usize] = true);
        }
        on
    };
    let (a, b) = (on(a), on(b));
    (0..mesh.nodes.len()).filter(|v| a[*v] && b[*v]).map(|v| mesh.nodes[v]).collect()
}

fn names(mesh: &TriMesh) -> Vec<&str> {
    let mut names: Vec<&str> = mesh.faces.iter().map(String::as_str).collect();
    names.sort_unstable();
    names
}

#[test]
fn a_box_of_triangles_and_a_cylinder_have_an_exact_border() {
    let at = folder("cylinder");
    std::fs::write(at.join("block.off"), cuboid([-2.0, -2.0, -1.0], [2.0, 2.0, 1.0])).unwrap();
    let r = 1.0;
    let bore = "cylinder(1, axis='z').name('bore')";
    let made = sound(&at, &format!("part(mesh('block.off') - {bore})\nmesh(size=0.4)\n"));
    let mesh = &made.mesh;
    assert_abs_diff_eq!(mesh.volume(), 32.0 - 2.0 * PI, epsilon = 0.02 * 32.0);
    let area = 2.0 * (16.0 - PI) + 4.0 * 8.0 + 2.0 * PI * r * 2.0;
    assert_relative_eq!(mesh.area(), area, epsilon = 0.0, max_relative = 0.01);
    assert_eq!(mesh.faces.len(), 7);
    assert!(names(mesh).contains(&"bore"));
    let mut rims = 0;
    for f in mesh.faces.clone().iter().filter(|f| *f != "bore") {
        for p in border(mesh, "bore", f) {
            assert!((p.truncate().length() - r).abs() < 1e-9 && (p.z.abs() - 1.0).abs() < 1e-9, "{p}");
            rims += 1;
        }
    }
    assert!(rims >= 36, "{rims}");
    let made = sound(&at, &format!("part(mesh('block.off') & {bore})\nmesh(size=0.4)\n"));
    assert_abs_diff_eq!(made.mesh.volume(), 2.0 * PI, epsilon = 0.02 * 2.0 * PI);
    assert_eq!(made.mesh.faces.len(), 3);
    let pin = "cylinder(1, axis='z', height=4).name('pin')";
    let made = sound(&at, &format!("part(mesh('block.off') | {pin})\nmesh(size=0.4)\n"));
    assert_abs_diff_eq!(made.mesh.volume(), 32.0 + 2.0 * PI, epsilon = 0.02 * 32.0);
    assert!(names(&made.mesh).contains(&"pin.side") && names(&made.mesh).contains(&"pin.top"));
    assert!(matches!(meshed(&at, &format!("part(mesh('block.off') | {bore})")), Err(Error::Input { .. })));
}

#[test]
fn meshes_are_joined_also_where_faces_coincide() {
    let at = folder("meshes");
    std::fs::write(at.join("a.off"), cuboid([0.0; 3], [4.0, 4.0, 2.0])).unwrap();
    std::fs::write(at.join("b.off"), cuboid([2.0, 2.0, 1.0], [6.0, 6.0, 3.0])).unwrap();
    std::fs::write(at.join("flush.off"), cuboid([1.0, 1.0, 1.0], [3.0, 3.0, 2.0])).unwrap();
    std::fs::write(at.join("half.off"), cuboid([4.0, 0.0, 0.0], [6.0, 4.0, 2.0])).unwrap();
    for (text, volume, area) in [
        ("mesh('a.off') | mesh('b.off')", 60.0, 112.0),
        ("mesh('a.off') & mesh('b.off')", 4.0, 16.0),
        ("mesh('a.off') - mesh('b.off')", 28.0, 64.0),
        ("mesh('a.off') - mesh('flush.off')", 28.0, 72.0),
        ("mesh('a.off') | mesh('half.off')", 48.0, 88.0),
        ("mesh('a.off') - box(lo=(1, 1, 1), hi=(3, 3, 2)).name('pocket')", 28.0, 72.0),
        ("mesh('a.off').mirror('x') | mesh('half.off').move((-4, 0, 0)).scale(0.5)", 32.0 + 2.0, 64.0 + 2.0 * 4.0),
    ] {
        let made = sound(&at, &format!("part({text})\nmesh(size=0.5)\n"));
        assert!(abs_diff_eq!(made.mesh.volume(), volume, epsilon = 1e-9), "{text}: {}", made.mesh.volume());
        assert!(text.contains("mirror") || (made.mesh.area() - area).abs() < 1e-9, "{text}: {}", made.mesh.area());
    }
}

#[test]
fn step_models_and_what_is_built_from_edges_are_operands() {
    let at = folder("step");
    let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("data/step");
    for f in ["sphere.step", "cone_with_apex.step"] {
        std::fs::copy(data.join(f), at.join(f)).unwrap();
    }
    let made = sound(&at, "part(step('sphere.step') - cylinder(1, axis='z').name('bore'))\nmesh(size=0.2)\n");
    // What a bore of radius 1 leaves of a ball of radius 2 is a ring of height 2 sqrt(3).
    let ring = PI / 6.0 * (2.0 * 3f64.sqrt()).powi(3);
    assert_abs_diff_eq!(made.mesh.volume(), ring, epsilon = 0.02 * ring);
    let rim = border(&made.mesh, "sphere.all", "bore");
    assert!(rim.len() >= 36);
    for p in rim {
        assert!((p.length() - 2.0).abs() < 1e-9 && (p.truncate().length() - 1.0).abs() < 1e-9, "{p}");
    }
    let made = sound(&at, "part(step('cone_with_apex.step') & cylinder(1, axis='z').name('turned'))\nmesh(size=0.2)\n");
    let volume = PI * (2.0 + 2.0 / 3.0);
    assert_abs_diff_eq!(made.mesh.volume(), volume, epsilon = 0.02 * volume);
    let square = "extrude_edges(polyline([(0, 0, 0), (4, 0, 0), (4, 4, 0), (0, 4, 0)], closed=True), (0, 0, 1), 2)";
    let made = sound(&at, &format!("part({square} - sphere(1, at=(4, 4, 2)).name('scoop'))\nmesh(size=0.4)\n"));
    let volume = 32.0 - PI / 6.0;
    assert_abs_diff_eq!(made.mesh.volume(), volume, epsilon = 0.03);
}

#[test]
fn what_cannot_be_joined_is_refused_at_its_place() {
    let at = folder("refused");
    let whole = cuboid([0.0; 3], [4.0, 4.0, 2.0]);
    let open: Vec<&str> = whole.trim_end().lines().collect();
    std::fs::write(at.join("a.off"), &whole).unwrap();
    std::fs::write(at.join("open.off"), open[..open.len() - 1].join("\n").replace("8 12 0", "8 11 0")).unwrap();
    let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("data/step/sphere.step");
    std::fs::copy(data, at.join("ball.step")).unwrap();
    for (text, words) in [
        ("\npart(mesh('open.off') - sphere(1))", ["line 2", "open edges"]),
        ("\n\npart(mesh('none.off') - sphere(1))", ["line 3", "none.off"]),
        ("part(blend(mesh('a.off'), sphere(1), 0.1))", ["line 1", "cannot be blended"]),
        ("part(mesh('ball.step') - sphere(1))", ["line 1", "is a STEP file"]),
        ("part(~mesh('a.off'))", ["infinite", "no end"]),
        ("part(step('ball.step') - sphere(2).name('x'))", ["at (", "coincide"]),
    ] {
        let e = meshed(&at, text).err().unwrap_or_else(|| panic!("{text} is meshed"));
        assert!(e.exit_code() == 3 && words.iter().all(|w| e.to_string().contains(w)), "{text}: {e}");
    }
    // What needs a formula refuses a boundary by its line.
    let part = pipeline::parse_part(Path::new("p.py"), "\npart(mesh('a.off') - sphere(1))", &[]).unwrap();
    let e = pipeline::vm_text(&part).err().unwrap().to_string();
    assert!(e.contains("line 2") && e.contains("has no function"), "{e}");
}

#[test]
fn what_has_no_end_is_cut_by_all_that_has_one_and_made_only_where_it_matters() {
    let at = folder("endless");
    std::fs::write(at.join("a.off"), cuboid([0.0; 3], [4.0, 4.0, 2.0])).unwrap();
    // A box of R-functions far from every boundary is cut, too.
    let below = "half_space(normal=(0, 0, 1), at=(0, 0, 1)).name('cut')";
    let far = "box(lo=(20, 0, 0), hi=(22, 2, 2)).name('far')";
    let made = sound(&at, &format!("part((mesh('a.off') | {far}) & {below})\nmesh(size=0.5)\n"));
    assert_abs_diff_eq!(made.mesh.volume(), 16.0 + 4.0, epsilon = 1e-9);
    let made = sound(&at, &format!("part((mesh('a.off') | {far}) - {below})\nmesh(size=0.5)\n"));
    assert_abs_diff_eq!(made.mesh.volume(), 16.0 + 4.0, epsilon = 1e-9);
    // What stands beside has no part in how much of an endless solid is made.
    let bored = "mesh('a.off') - cylinder(0.3, axis='x', at=(0, 2, 1)).name('bore')";
    let alone = sound(&at, &format!("part({bored})\nmesh(size=0.5)\n"));
    let beside = sound(&at, &format!("part(({bored}) | mesh('a.off').name('b').move((30, 0, 0)))\nmesh(size=0.5)\n"));
    assert_eq!(alone.report.attempts[0].triangles, beside.report.attempts[0].triangles);
    // It is in the way of nothing where it does not reach.
    let made = sound(&at, "part(mesh('a.off') - cylinder(0.3, axis='x', at=(0, 9, 1)).name('bore'))\nmesh(size=0.5)\n");
    assert_abs_diff_eq!(made.mesh.volume(), 32.0, epsilon = 1e-9);
}

#[test]
fn narrow_faces_and_borders_that_bend_are_heeded() {
    let at = folder("narrow");
    std::fs::write(at.join("a.off"), cuboid([0.0; 3], [4.0, 4.0, 2.0])).unwrap();
    let thin = 0.04;
    let slice = format!("box(lo=(-1, -1, 0.5), hi=(5, 5, {})).name('slice')", 0.5 + thin);
    let made = sound(&at, &format!("part(mesh('a.off') & {slice})\nmesh(size=0.4)\n"));
    assert_abs_diff_eq!(made.mesh.volume(), 16.0 * thin, epsilon = 1e-9);
    // Strips a tenth of the size high have triangles of their width.
    let quality = &made.report.check.as_ref().unwrap().quality;
    assert!(quality.min_angle > 25.0 && quality.p05_angle > 40.0, "{quality:?}");
    // Two cylinders of one radius touch in two points, towards which all faces narrow: what is left has two halves.
    let pin = "extrude_edges(circle(1), 'z', 3)";
    let made =
        meshed(&at, &format!("part({pin} - cylinder(1, axis='x', height=4, at=(0, 0, 1.5)))\nmesh(size='4%')\n"));
    let made = made.unwrap();
    let check = made.report.check.as_ref().unwrap();
    assert!(check.certificate.is_sound(), "{}", check.certificate);
    let volume = 3.0 * PI - 16.0 / 3.0;
    assert_abs_diff_eq!(made.mesh.volume(), volume, epsilon = 0.01 * volume);
}

#[test]
fn what_has_an_end_is_made_only_where_it_matters() {
    let at = folder("kept");
    std::fs::write(at.join("a.off"), cuboid([0.0; 3], [1.0; 3])).unwrap();
    let triangles = |made: &Meshed| made.report.attempts[0].triangles;
    // Sheets a quarter thick, two to a unit, in a box that is 8 times as long as the mesh.
    let sheets = "solid(0.25 - mod(x + 0.125, 0.5)).name('sheets')";
    let text = |lo: i32, hi: i32, op: &str, domain: &str| {
        let all = format!("box(lo=({lo}, {lo}, {lo}), hi=({hi}, {hi}, {hi})).name('hull') & {sheets}");
        format!("part(mesh('a.off') {op} ({all}){domain})\nmesh(size=0.25)\n")
    };
    for (op, volume) in [("&", 0.5), ("-", 0.5)] {
        let small = sound(&at, &text(-1, 2, op, ""));
        let large = sound(&at, &text(-4, 5, op, ""));
        assert_abs_diff_eq!(large.mesh.volume(), volume, epsilon = 1e-9);
        assert_abs_diff_eq!(large.mesh.area(), small.mesh.area(), epsilon = 1e-9);
        assert!(names(&large.mesh).iter().all(|n| *n == "sheets" || n.starts_with('a')), "{:?}", names(&large.mesh));
        assert!(triangles(&large) <= 2 * triangles(&small), "{} {}", triangles(&large), triangles(&small));
        assert!(large.report.warnings.is_empty(), "{:?}", large.report.warnings);
    }
    // A ball much larger than the mesh, with a domain larger than both: one corner of the mesh is outside of it.
    let ball = "sphere(4, at=(-3, 0.5, 0.5)).name('ball')";
    let cut = sound(&at, &format!("part(mesh('a.off') & {ball}, domain=((-9, -9, -9), (9, 9, 9)))\nmesh(size=0.1)\n"));
    let rest = sound(&at, &format!("part(mesh('a.off') - {ball}, domain=((-9, -9, -9), (9, 9, 9)))\nmesh(size=0.1)\n"));
    assert_abs_diff_eq!(cut.mesh.volume() + rest.mesh.volume(), 1.0, epsilon = 1e-3);
    assert!(triangles(&cut) < 4000, "{}", triangles(&cut));
    // A union shows all of it.
    let whole = sound(&at, "part(mesh('a.off') | sphere(4, at=(-3, 0.5, 0.5)).name('ball'))\nmesh(size=0.5)\n");
    assert_relative_eq!(whole.mesh.volume(), 256.0 / 3.0 * PI + rest.mesh.volume(), max_relative = 0.01);
}

#[test]
fn cylinders_of_one_radius_meet_in_two_ellipses() {
    let at = folder("steinmetz");
    let r = 1.0_f64;
    let (pin, bar) = ("extrude_edges(circle(1), 'z', 4)", "cylinder(1, axis='x', height=4, at=(0, 0, 2))");
    let (each, common) = (4.0 * PI * r.powi(2), 16.0 / 3.0 * r.powi(3));
    for (op, volume) in [("&", common), ("|", 2.0 * each - common), ("-", each - common)] {
        let made = sound(&at, &format!("part({pin} {op} {bar})\nmesh(size='4%')\n"));
        assert_relative_eq!(made.mesh.volume(), volume, epsilon = 0.0, max_relative = 0.01);
    }
}

#[test]
fn surfaces_that_are_tangent_along_a_curve_are_told() {
    let at = folder("inside");
    let (pin, ball) = ("extrude_edges(circle(1), 'z', 4)", "sphere(1, at=(0, 0, 2)).name('ball')");
    for (op, volume) in [("&", 4.0 / 3.0 * PI), ("|", 4.0 * PI)] {
        let made = meshed(&at, &format!("part({pin} {op} {ball})\nmesh(size='7%')\n")).unwrap();
        let told: Vec<String> = made.report.shortfalls.iter().map(ToString::to_string).collect();
        assert!(told.iter().any(|f| f.contains("near (")), "{op}: {told:?}");
        assert_relative_eq!(made.mesh.volume(), volume, epsilon = 0.0, max_relative = 0.02);
    }
}
