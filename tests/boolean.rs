//! Set operations on meshes, STEP models, bodies built from edges and solids of R-functions, against closed forms.

use std::f64::consts::PI;
use std::path::{Path, PathBuf};

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
    assert!((mesh.volume() - (32.0 - 2.0 * PI)).abs() < 0.02 * 32.0, "{}", mesh.volume());
    let area = 2.0 * (16.0 - PI) + 4.0 * 8.0 + 2.0 * PI * r * 2.0;
    assert!((mesh.area() - area).abs() < 0.01 * area, "{} {area}", mesh.area());
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
    assert!((made.mesh.volume() - 2.0 * PI).abs() < 0.02 * 2.0 * PI);
    assert_eq!(made.mesh.faces.len(), 3);
    let pin = "cylinder(1, axis='z', height=4).name('pin')";
    let made = sound(&at, &format!("part(mesh('block.off') | {pin})\nmesh(size=0.4)\n"));
    assert!((made.mesh.volume() - (32.0 + 2.0 * PI)).abs() < 0.02 * 32.0);
    assert!(names(&made.mesh).contains(&"pin.side") && names(&made.mesh).contains(&"pin.top"));
    assert!(matches!(meshed(&at, &format!("part(mesh('block.off') | {bore})")), Err(Error::Input { .. })));
}
