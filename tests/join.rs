//! Meshes without descriptors, joined where their nodes match: against cuboids whose volumes are known.

use std::fs;
use std::path::Path;

use approx::assert_relative_eq;
use assert_cmd::Command;
use predicates::str::contains;
use rvachev::io::{Format, read_bytes};
use rvachev::mesh::TriMesh;
use rvachev::pipeline::join;
use rvachev::{DVec3, Run};
use serde_json::Value;
use tempfile::TempDir;

/// The triangles of a cuboid's sides of an axis, counted 0 to 5 as low and high of x, y and z, each divided `n` by `n` times.
fn sides(lo: DVec3, hi: DVec3, which: &[usize], n: usize) -> TriMesh {
    let mut mesh = TriMesh::new(Vec::new(), Vec::new());
    for side in which {
        let (axis, high) = (side / 2, side % 2);
        let first = mesh.nodes.len();
        for k in 0..(n + 1) * (n + 1) {
            let mut at = [0.0; 3];
            at[axis] = high as f64;
            at[(axis + 1) % 3] = (k % (n + 1)) as f64 / n as f64;
            at[(axis + 2) % 3] = (k / (n + 1)) as f64 / n as f64;
            mesh.nodes.push(lo + (hi - lo) * DVec3::from(at));
        }
        for k in 0..n * n {
            let a = first + k / n * (n + 1) + k % n;
            for t in [[a, a + 1, a + n + 2], [a, a + n + 2, a + n + 1]] {
                let [a, b, c] = t.map(|v| v as u32);
                mesh.triangles.push(if high == 1 { [a, b, c] } else { [a, c, b] });
                mesh.labels.push(0);
            }
        }
    }
    mesh
}

fn unit(which: &[usize]) -> TriMesh {
    sides(DVec3::ZERO, DVec3::new(1.0, 2.0, 3.0), which, 5)
}

/// Moves nodes by at most `by` along each axis, each in another way, and those of each mesh in another one.
fn shaken(mut mesh: TriMesh, by: f64) -> TriMesh {
    let own = mesh.bounds().center();
    for (i, p) in mesh.nodes.iter_mut().enumerate() {
        let i = i as f64 + own.x + 2.0 * own.y + 4.0 * own.z + 1.0;
        *p += by * DVec3::new(i.sin(), (2.0 * i).sin(), (3.0 * i).sin());
    }
    mesh
}

#[test]
fn six_sides_become_a_closed_cuboid_whatever_single_precision_left_of_them() {
    let parts: Vec<TriMesh> = (0..6).map(|s| shaken(unit(&[s]), 1e-7)).collect();
    let joined = join(&parts, 1e-6, &Run::new()).unwrap();
    // Of 6 x 36 nodes an edge's four inner ones stand twice, a corner's three times.
    assert_eq!(joined.report.matched, 12 * 4 + 8 * 2);
    assert_eq!((joined.report.nodes, joined.report.triangles), (216 - 64, 300));
    assert_eq!((joined.report.open_edges, joined.report.misoriented_edges, joined.report.alone.len()), (0, 0, 0));
    assert!(joined.report.farthest <= 2e-7 * 3f64.sqrt() && joined.report.farthest > 0.0);
    assert_relative_eq!(joined.mesh.volume(), 6.0, max_relative = 1e-6);
    assert!(joined.mesh.defects().is_manifold());
    // Nodes of the first mesh stay where they are.
    assert_eq!(joined.mesh.nodes[..36], parts[0].nodes);
    // Too short a distance matches nothing, and the same bytes come of any number of threads.
    assert_eq!(join(&parts, 1e-12, &Run::new()).unwrap().report.matched, 0);
    for threads in [1, 3] {
        assert_eq!(join(&parts, 1e-6, &Run::new().with_threads(threads).unwrap()).unwrap(), joined);
    }
}

#[test]
fn no_triangle_collapses_however_far_nodes_are_matched() {
    let parts = [unit(&[0, 2, 4]), shaken(unit(&[1, 3, 5]), 1e-3)];
    for within in [0.01, 0.5, 10.0] {
        let joined = join(&parts, within, &Run::new()).unwrap();
        assert_eq!(joined.report.triangles, 300, "{within}");
        assert!(joined.mesh.triangles.iter().all(|[a, b, c]| a != b && b != c && c != a), "{within}");
        assert!(joined.report.farthest <= within);
    }
    // Parts of three sides have nodes of their own along edges between these, which stay apart.
    assert!(join(&parts, 0.01, &Run::new()).unwrap().report.open_edges > 0);
}

#[test]
fn two_solids_that_touch_share_the_nodes_of_the_face_between_them() {
    let all = [0, 1, 2, 3, 4, 5];
    let whole = |x: f64| {
        let parts: Vec<TriMesh> =
            all.iter().map(|s| sides(DVec3::new(x, 0.0, 0.0), DVec3::new(x + 1.0, 1.0, 1.0), &[*s], 3)).collect();
        join(&parts, 1e-9, &Run::new()).unwrap().mesh
    };
    let joined = join(&[whole(0.0), whole(1.0)], 1e-9, &Run::new()).unwrap();
    assert_eq!((joined.report.matched, joined.report.doubled), (16, 18));
    assert_eq!(joined.report.nonmanifold_edges, 33, "all edges of the face between them, of 3 by 3 squares");
    assert_relative_eq!(joined.mesh.volume(), 2.0, max_relative = 1e-12);
}

#[test]
fn names_and_groups_of_equal_names_are_one() {
    let mut parts = [unit(&[0]), unit(&[1]), unit(&[2])];
    for (mesh, name) in parts.iter_mut().zip(["wall", "lid", "wall"]) {
        mesh.faces = vec![name.into()];
        mesh.groups = vec![rvachev::mesh::Group { name: "all".into(), faces: vec![0] }];
    }
    let mesh = join(&parts, 0.0, &Run::new()).unwrap().mesh;
    assert_eq!(mesh.faces, ["wall", "lid"]);
    assert_eq!(mesh.labels, [[0; 50], [1; 50], [0; 50]].concat());
    assert_eq!((mesh.groups.len(), &mesh.groups[0].faces), (1, &vec![0, 1]));
}

#[test]
fn what_cannot_be_joined_is_refused_and_meshes_of_nothing_are_alone() {
    let parts = [unit(&[0]), TriMesh::default(), unit(&[2]), TriMesh::default()];
    let joined = join(&parts, 1e-9, &Run::new()).unwrap();
    assert_eq!((joined.report.matched, joined.report.alone), (6, vec![1, 3]));
    assert_eq!(join(&[TriMesh::default()], 1.0, &Run::new()).unwrap().report.nodes, 0);
    for (parts, within) in [(&parts[..0], 1.0), (&parts[..], -1.0), (&parts[..], f64::NAN), (&parts[..], f64::INFINITY)]
    {
        assert_eq!(join(parts, within, &Run::new()).unwrap_err().exit_code(), 2);
    }
    let mut broken = unit(&[1]);
    broken.nodes[3].y = f64::NAN;
    assert!(join(&[unit(&[0]), broken], 1.0, &Run::new()).unwrap_err().to_string().contains("node 3"));
}

fn off(mesh: &TriMesh) -> String {
    let mut out = format!("OFF\n{} {} 0\n", mesh.nodes.len(), mesh.triangles.len());
    mesh.nodes.iter().for_each(|p| out += &format!("{} {} {}\n", p.x, p.y, p.z));
    mesh.triangles.iter().for_each(|[a, b, c]| out += &format!("3 {a} {b} {c}\n"));
    out
}

fn rvachev(dir: &Path, args: &[&str]) -> assert_cmd::assert::Assert {
    Command::cargo_bin("rvachev").unwrap().current_dir(dir).args(args).assert()
}

#[test]
fn the_command_joins_files_and_tells_what_does_not_fit() {
    let dir = TempDir::new().unwrap();
    let at = dir.path();
    for s in 0..6 {
        fs::write(at.join(format!("side{s}.off")), off(&shaken(unit(&[s]), 1e-7))).unwrap();
    }
    fs::write(at.join("far.off"), off(&sides(DVec3::splat(9.0), DVec3::splat(10.0), &[0], 2))).unwrap();
    let files = ["side0.off", "side1.off", "side2.off", "side3.off", "side4.off", "side5.off"];
    let done = rvachev(at, &[&["join"], &files[..], &["-o", "a.msh", "-o", "a.stl", "--json"]].concat()).success();
    let told: Value = serde_json::from_slice(&done.get_output().stdout).unwrap();
    assert_eq!((told["matched"].as_u64(), told["open_edges"].as_u64()), (Some(64), Some(0)));
    let mesh = read_bytes(&fs::read(at.join("a.msh")).unwrap(), Format::Msh, Path::new("a.msh")).unwrap();
    assert_relative_eq!(mesh.volume(), 6.0, max_relative = 1e-6);
    assert_eq!(mesh.faces[..2], ["side0.surface", "side1.surface"]);
    rvachev(at, &["check", "a.stl"]).success();
    // What has nothing to do with the others is named.
    rvachev(at, &["join", "side0.off", "side2.off", "far.off", "-o", "b.off"])
        .code(1)
        .stderr(contains("far.off has no node in common"));
    rvachev(at, &["join", "side0.off", "side2.off", "-o", "c.off", "--within", "0"]).code(1);
    rvachev(at, &["join", "side0.off", "side2.off", "-o", "c.off", "--within", "0.01%"])
        .success()
        .stdout(contains("6 nodes matched"));
    rvachev(at, &["join", "side0.off", "-o", "c.off"]).code(2);
    rvachev(at, &["join", "side0.off", "none.off", "-o", "c.off"]).code(3).stderr(contains("none.off"));
    fs::write(at.join("bad.off"), "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 7\n").unwrap();
    rvachev(at, &["join", "side0.off", "bad.off", "-o", "d.off"]).code(3).stderr(contains("bad.off"));
    assert!(!at.join("d.off").exists());
}
