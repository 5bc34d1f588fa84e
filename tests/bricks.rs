//! Meshes made brick by brick: sound, the same bytes whoever makes them, and nothing wrong merged.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use approx::{assert_relative_eq, relative_eq};
use glam::DVec3;
use rvachev::Run;
use rvachev::io::{WriteOptions, write};
use rvachev::mesh::{MeshView, TriMesh};
use rvachev::pipeline::{
    BrickPlan, MeshOptions, Meshed, PlanSource, Share, SizeRequest, make_bricks, merge_bricks, merge_on_disk,
};
use rvachev::quality::{Check, Expectation, check};

/// A cube with two bores that cross, the size of 70 edges along its side.
const HOLES: &str = "part(box(size=(2, 2, 2)).name('body') - cylinder(0.4, axis='x') - cylinder(0.4, axis='z'))\n";

fn folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("bricks").join(name);
    let _ = fs::remove_dir_all(&folder);
    fs::create_dir_all(&folder).unwrap();
    folder
}

fn planned(text: &str, size: f64, bricks: [u32; 3], folder: &Path) -> BrickPlan {
    let path = folder.join("part.py");
    fs::write(&path, text).unwrap();
    let options = MeshOptions { size: Some(SizeRequest::Length(size)), ..MeshOptions::default() };
    let plan = BrickPlan::new(PlanSource::read(&path, &[]).unwrap(), &options, bricks, &Run::new()).unwrap();
    plan.save(folder).unwrap();
    plan
}

fn made(text: &str, size: f64, bricks: [u32; 3], name: &str) -> (TriMesh, Check) {
    let folder = folder(name);
    let plan = planned(text, size, bricks, &folder);
    assert_eq!(plan.bricks(), bricks);
    make_bricks(&plan, &folder, Share::ALL, None, &Run::new()).unwrap();
    let Meshed { mesh, report, .. } = merge_bricks(&plan, &folder, &Run::new()).unwrap();
    assert_eq!(report.shortfalls, Vec::new(), "{name}");
    fs::remove_dir_all(folder).unwrap();
    (mesh, report.check.unwrap())
}

/// The volume of a cube of side 2 less two cylinders of radius 0.4 that cross, by Steinmetz, and the area of what is left.
fn holes() -> [f64; 2] {
    let (r, pi) = (0.4f64, std::f64::consts::PI);
    [8.0 - 4.0 * pi * r * r + 16.0 / 3.0 * r.powi(3), 24.0 - 4.0 * pi * r * r + 8.0 * pi * r - 16.0 * r * r]
}

#[test]
fn a_cube_with_holes_is_as_good_in_bricks_as_in_one() {
    let size = 0.025;
    let [volume, area] = holes();
    for bricks in [[1, 1, 1], [2, 2, 2], [3, 3, 3], [1, 3, 2]] {
        let (mesh, c) = made(HOLES, size, bricks, &format!("holes{}{}{}", bricks[0], bricks[1], bricks[2]));
        assert!(c.certificate.is_sound() && c.euler == -4, "{bricks:?}: {:?}", c.certificate);
        assert!(
            relative_eq!(c.volume.unwrap(), volume, epsilon = 0.0, max_relative = 3e-4),
            "{bricks:?}: {:?} {volume}",
            c.volume
        );
        assert!(relative_eq!(c.area, area, epsilon = 0.0, max_relative = 3e-4), "{bricks:?}: {} {area}", c.area);
        for corner in [DVec3::splat(1.0), DVec3::splat(-1.0), DVec3::new(1.0, -1.0, 1.0)] {
            assert!(mesh.nodes.iter().any(|p| p.distance(corner) < 1e-12), "{bricks:?}: {corner}");
        }
        // Where the bores touch edges are short, and a wall may pass there: one triangle in ten thousand may be worse.
        let q = c.quality;
        assert!(q.min_angle > 8.0 && q.below_20 < 1e-4 && q.p05_angle > 49.5, "{bricks:?}: {q:?}");
    }
}

#[test]
fn shares_in_any_order_give_the_same_bytes_in_8_and_27_and_64_bricks() {
    let [volume, area] = holes();
    for n in [2, 3, 4] {
        let made = |shares: u32| {
            let name = format!("shares{n}-{shares}");
            let folder = folder(&name);
            let plan = planned(HOLES, 0.02, [n; 3], &folder);
            assert_eq!(plan.bricks(), [n; 3]);
            for round in 0..3 {
                for number in (1..=shares).rev() {
                    make_bricks(&plan, &folder, Share { number, of: shares }, Some(round), &Run::new()).unwrap();
                }
            }
            let Meshed { mesh, report, .. } = merge_bricks(&plan, &folder, &Run::new()).unwrap();
            fs::remove_dir_all(folder).unwrap();
            (mesh, report.check.unwrap())
        };
        let (one, c) = made(1);
        assert!(c.certificate.is_sound() && c.euler == -4, "{n}: {:?}", c.certificate);
        assert!(
            relative_eq!(c.volume.unwrap(), volume, epsilon = 0.0, max_relative = 2e-4),
            "{n}: {:?} {volume}",
            c.volume
        );
        assert!(relative_eq!(c.area, area, epsilon = 0.0, max_relative = 2e-4), "{n}: {} {area}", c.area);
        for shares in [2, 7] {
            let (other, same) = made(shares);
            assert_eq!((&one.nodes, &one.triangles, &one.labels), (&other.nodes, &other.triangles, &other.labels));
            assert_eq!(same, c);
        }
    }
}

#[test]
fn a_mesh_on_disk_is_the_one_in_memory_in_its_bytes_and_its_measures() {
    let folder = folder("on_disk");
    let text = format!("group('all', faces('*'))\n{HOLES}");
    let plan = planned(&text, 0.03, [2, 3, 2], &folder);
    make_bricks(&plan, &folder, Share::ALL, None, &Run::new()).unwrap();
    let on_disk = merge_on_disk(&plan, &folder, false, &Run::new()).unwrap();
    let Meshed { mesh, report, .. } = merge_bricks(&plan, &folder, &Run::new()).unwrap();
    let truth = check(&mesh, Expectation::default(), None, &Run::new()).unwrap();
    assert_eq!((on_disk.made.report.check.as_ref(), report.check.as_ref()), (Some(&truth), Some(&truth)));
    assert_eq!(truth.groups.last().map(|g| (&*g.name, g.triangles)), Some(("all", mesh.triangles.len())));
    assert!(on_disk.made.mesh.triangles.is_empty());
    let bytes = |name: &str, view: &dyn MeshView| {
        let path = folder.join(name);
        write(&path, view, &WriteOptions::default(), &Run::new()).unwrap();
        fs::read(path).unwrap()
    };
    for ending in ["vtu", "stl", "stla", "ply", "obj", "off", "msh", "inp"] {
        let name = format!("a.{ending}");
        assert!(bytes(&name, &on_disk.mesh) == bytes(&name, &mesh), "{ending}");
    }
    // What goes while it is read is named, and no file is left.
    fs::remove_file(folder.join("round1").join("000000.piece")).unwrap();
    let gone = write(&folder.join("b.vtu"), &on_disk.mesh, &WriteOptions::default(), &Run::new()).unwrap_err();
    assert!(gone.to_string().contains("brick 0 of round 1"), "{gone}");
    assert!(!folder.join("b.vtu").exists());
    fs::remove_dir_all(folder).unwrap();
}

/// The volume of the box of [`a_wall_beside_the_point_where_bores_touch`] below both bores, by the midpoint rule on its base.
fn below_bores(at: [f64; 2]) -> f64 {
    let (n, half, r) = (600, 0.3, 0.4f64);
    let middle = |c: f64, k: usize| c - half + 2.0 * half * (k as f64 + 0.5) / n as f64;
    let height = |x: f64, z: f64| 0.75 + (-(r * r - (x * x).min(z * z)).sqrt()).min(-0.25);
    let row = |i: usize| (0..n).map(|k| height(middle(at[0], i), middle(at[1], k))).sum::<f64>();
    (0..n).map(row).sum::<f64>() * (2.0 * half / n as f64).powi(2)
}

#[test]
fn a_wall_beside_the_point_where_bores_touch() {
    // Four creases meet in (0, -0.4, 0), where both bores go the same way. Walls pass it at less than half an edge: it has one node, and
    // the brick beyond the wall draws nothing to it.
    for at in [[-0.00998, -0.00996], [-0.00908, -0.01766]] {
        let [x, z] = at;
        let text = format!(
            "part(box(at=({x}, -0.5, {z}), size=(0.6, 0.5, 0.6)) - cylinder(0.4, axis='x') - cylinder(0.4, axis='z'))\n"
        );
        let (mesh, c) = made(&text, 0.01, [2, 1, 2], &format!("touching{x}"));
        assert!(c.certificate.is_sound() && c.euler == 2, "{at:?}: {:?}", c.certificate);
        assert_relative_eq!(c.volume.unwrap(), below_bores(at), epsilon = 0.0, max_relative = 1e-4);
        let joint = DVec3::new(0.0, -0.4, 0.0);
        assert_eq!(mesh.nodes.iter().filter(|p| p.distance(joint) < 1e-6).count(), 1, "{at:?}");
    }
}

#[test]
fn parts_smaller_than_a_brick_walls_along_its_wall_and_an_edge_in_it_come_out() {
    // The grid's middle wall is near x = 0: a thin wall on both sides of it, and one that it halves lengthwise; small balls.
    let text = "body = box(size=(2, 2, 2)) - box(at=(0.02, 0, 0.4), size=(0.03, 1.2, 1.4)) - box(at=(-0.03, 0, 0.4), size=(0.03, 1.2, 1.4))\n\
                balls = union(sphere(0.03, at=(1.3, 0.3 * k, 0.05)) for k in range(-3, 4))\n\
                part(body | balls)\n";
    let (_, c) = made(text, 0.03, [2, 2, 2], "thin");
    let volume = 8.0 - 2.0 * 0.03 * 1.2 * 1.3 + 7.0 * 4.0 / 3.0 * std::f64::consts::PI * 0.03f64.powi(3);
    assert!(c.certificate.is_sound() && c.components == 8, "{:?}", c.certificate);
    assert_relative_eq!(c.volume.unwrap(), volume, epsilon = 0.0, max_relative = 1e-4);
}

#[test]
fn a_lattice_of_hundreds_of_bars_has_its_holes_and_its_volume() {
    // Bars of a square section between the points of a grid: its tree is larger than what a brick is asked to look at.
    let text = "n, w = 6, 0.3\n\
                cells = [(i, j, k) for i in range(n - 1) for j in range(n) for k in range(n)]\n\
                along = [box(at=(i + 0.5, j, k), size=(1 + w, w, w)) for i, j, k in cells]\n\
                across = [box(at=(j, i + 0.5, k), size=(w, 1 + w, w)) for i, j, k in cells]\n\
                up = [box(at=(j, k, i + 0.5), size=(w, w, 1 + w)) for i, j, k in cells]\n\
                part(union(along + across + up))\n";
    let (_, c) = made(text, 0.1, [2, 2, 2], "lattice");
    let (n, w) = (6.0f64, 0.3f64);
    let (points, bars) = (n.powi(3), 3.0 * n * n * (n - 1.0));
    let volume = points * w.powi(3) + bars * w * w * (1.0 - w);
    let area = bars * 4.0 * w * (1.0 - w) + (6.0 * points - 2.0 * bars) * w * w;
    assert!(c.certificate.is_sound() && c.components == 1, "{:?}", c.certificate);
    // As many handles as the graph has loops.
    assert_eq!(c.euler as f64, 2.0 * (points - bars));
    assert_relative_eq!(c.volume.unwrap(), volume, epsilon = 0.0, max_relative = 1e-9);
    assert_relative_eq!(c.area, area, epsilon = 0.0, max_relative = 1e-9);
}

/// Where the walls between bricks of the first round are, along each axis.
fn walls(plan: &BrickPlan) -> [Vec<f64>; 3] {
    let json: serde_json::Value = serde_json::from_str(&plan.to_json().unwrap()).unwrap();
    let whole = |name: &str, k: usize| json[name][k].as_u64().unwrap();
    let cell = json["cell"].as_f64().unwrap();
    std::array::from_fn(|k| {
        let (cells, n) = (whole("cells", k), whole("bricks", k));
        (1..n).map(|i| json["origin"][k].as_f64().unwrap() + cell * (cells * i / n) as f64).collect()
    })
}

#[test]
fn faces_edges_and_corners_in_the_walls_of_bricks_come_out() {
    // All of these have the bounds of the cube, and so its walls.
    let plate =
        |x: f64| format!("(box(lo=(-2, -2, 0), hi=({x:?}, 2, 2)) | box(lo=({:?}, -2, 0), hi=(2, 2, 2)))", x + 0.015);
    let aside = folder("walls");
    let [x, y, z] = walls(&planned("part(box(size=(2, 2, 2)))\n", 0.03, [2, 2, 2], &aside)).map(|w| w[0]);
    fs::remove_dir_all(aside).unwrap();
    let cases = [
        // Three faces in walls, and their corner where all walls meet.
        (
            "corner",
            format!("box(lo=({x:?}, {y:?}, {z:?}), hi=(2, 2, 2))"),
            (1.0 - x) * (1.0 - y) * (1.0 - z),
            [2, 2, 2],
        ),
        // An edge in a wall whose faces are not.
        (
            "oblique",
            format!("(half_space((1, 0, -1), at=({x:?}, 0, 0.5)) & half_space((-1, 0, -1), at=({x:?}, 0, 0.5)))"),
            0.5,
            [2, 2, 2],
        ),
        // A face in a wall, and the edge below it.
        ("face", format!("box(lo=({x:?}, -2, {z:?}), hi=(2, 2, 2))"), (1.0 - x) * 2.0 * (1.0 - z), [2, 1, 1]),
        // A plate half as thick as an edge is long beside the wall, one of its faces in it.
        ("plate", plate(x), 2.0 * (2.0 - 0.015), [2, 1, 1]),
        // And nearly in it where walls cross.
        ("near", plate(x + 1e-4), 2.0 * (2.0 - 0.015), [2, 2, 2]),
    ];
    for (name, less, volume, bricks) in cases {
        let (_, c) = made(&format!("part(box(size=(2, 2, 2)) - {less})\n"), 0.03, bricks, name);
        assert!(c.certificate.is_sound() && c.euler == 2 && c.components == 1, "{name}: {:?}", c.certificate);
        let left = 8.0 - volume;
        assert!(
            relative_eq!(c.volume.unwrap(), left, epsilon = 0.0, max_relative = 1e-9),
            "{name}: {:?} {left}",
            c.volume
        );
    }
    // Where a face goes through points of the grid and through a wall across it names run out: refused, with what helps.
    let folder = folder("grid");
    let (part, out) = (folder.join("part.py"), folder.join("a.stl"));
    fs::write(&part, format!("part(box(size=(2, 2, 2)) - {})\n", plate(x))).unwrap();
    let [part, out] = [&part, &out].map(|p| p.to_str().unwrap());
    fails(&["mesh", part, "--size", "0.03", "--bricks", "2x2x2", "-o", out], 3, "a size that is a little different");
    assert!(command(&["mesh", part, "--size", "0.0299", "--bricks", "2x2x2", "-o", out]).status.success());
}

#[test]
fn what_cannot_be_proved_is_named_by_the_brick_it_is_in() {
    let folder = folder("unproved");
    // Two cylinders of one radius whose axes meet: their surfaces touch in (0.5, +-0.3, 0), which is in the second brick.
    let text = "part(cylinder(0.3, at=(0.5, 0, 0), height=2) | cylinder(0.3, axis='x', height=2))\n";
    let plan = planned(text, 0.04, [2, 1, 1], &folder);
    make_bricks(&plan, &folder, Share::ALL, None, &Run::new()).unwrap();
    let report = merge_bricks(&plan, &folder, &Run::new()).unwrap().report;
    fs::remove_dir_all(folder).unwrap();
    let proof = report.attempts[0].proof.as_ref().unwrap();
    let [b] = proof.bricks[..] else { panic!("{proof:?}") };
    assert!(b.brick == 1 && b.unproved == proof.unproved && b.cells < proof.cells, "{proof:?}");
    let near = DVec3::new(0.5, 0.3 * b.first.at[1].signum(), 0.0);
    assert!(DVec3::from_array(b.first.at).distance(near) < 0.04, "{proof:?}");
}

#[test]
fn a_fillet_goes_through_the_walls_of_bricks() {
    let text = "foot = box(lo=(-1, -1, -1), hi=(1, 1, 0))\nboss = cylinder(0.4, at=(0.1, 0, 0.3), height=1)\n\
                part(blend(foot, boss, 0.2).name('root'))\n";
    let (_, c) = made(text, 0.04, [2, 2, 2], "fillet");
    let (big, high, r, pi) = (0.4, 0.8, 0.2, std::f64::consts::PI);
    // By Pappus and Guldinus: what lies between a quarter of a circle and its tangents at both ends, around the axis.
    let root = 2.0 * pi * ((1.0 - pi / 4.0) * r * r * big + (5.0 / 6.0 - pi / 4.0) * r * r * r);
    let volume = 4.0 + pi * big * big * high + root;
    let around = pi * pi * r * (big + r) - 2.0 * pi * r * r;
    let area = 16.0 - pi * (big + r) * (big + r) + pi * big * big + 2.0 * pi * big * (high - r) + around;
    assert!(c.certificate.is_sound(), "{:?}", c.certificate);
    assert_relative_eq!(c.volume.unwrap(), volume, epsilon = 0.0, max_relative = 1e-3);
    assert_relative_eq!(c.area, area, epsilon = 0.0, max_relative = 1e-3);
}

fn command(args: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_rvachev")).args(args).output().unwrap()
}

fn fails(args: &[&str], code: i32, says: &str) {
    let out = command(args);
    let text = String::from_utf8_lossy(&out.stderr);
    assert_eq!(out.status.code(), Some(code), "{args:?}: {text}");
    assert!(text.contains(says), "{args:?}: {text}");
}

#[test]
fn what_is_missing_damaged_or_of_another_plan_is_named_and_not_merged() {
    let folder = folder("faults");
    let job = folder.join("job");
    let part = folder.join("part.py");
    fs::write(&part, HOLES).unwrap();
    let (part, job) = (part.to_str().unwrap(), job.to_str().unwrap());
    let out = folder.join("a.stl");
    let out = out.to_str().unwrap();
    fails(&["plan", part, "--bricks", "2x2", "-o", job], 2, "three numbers");
    fails(&["plan", part, "--bricks", "2x2x2", "--refine", "sphere=0,0,0,1:0.1", "-o", job], 2, "--refine");
    assert!(command(&["plan", part, "--bricks", "2x1x1", "--size", "0.03", "-o", job]).status.success());
    fails(&["merge", job, "-o", out], 3, "not made: brick 0 of round 1");
    fails(&["brick", job, "--share", "2/1"], 2, "there is no share");
    fails(&["brick", job, "--share", "1/2"], 2, "--round");
    fails(&["brick", job, "--round", "2"], 3, "brick 0 of round 1 is missing");
    assert!(command(&["brick", job]).status.success());
    // Nothing is left to do, and the part's file may change or go: the plan holds its text.
    fs::write(part, "part(sphere(1))\n").unwrap();
    let again = command(&["brick", job]);
    assert!(String::from_utf8_lossy(&again.stdout).contains("0 pieces made"));
    assert!(command(&["merge", job, "-o", out, "-q"]).status.success());
    let whole = fs::read(out).unwrap();
    fs::remove_file(out).unwrap();
    // A file cut short, one with a byte changed, one of another brick, one of another plan: each is named.
    let piece = Path::new(job).join("round1").join("000001.piece");
    let good = fs::read(&piece).unwrap();
    let mut flipped = good.clone();
    flipped[good.len() / 2] ^= 1;
    let other = fs::read(Path::new(job).join("round1").join("000000.piece")).unwrap();
    for (bytes, says) in
        [(&good[..good.len() / 3], "damaged"), (&flipped, "damaged"), (&other, "another brick's"), (&[], "cut short")]
    {
        fs::write(&piece, bytes).unwrap();
        fails(&["merge", job, "-o", out], 3, says);
        assert!(!Path::new(out).exists());
    }
    let job2 = folder.join("job2");
    let job2 = job2.to_str().unwrap();
    assert!(command(&["plan", part, "--bricks", "2x1x1", "--size", "0.1", "-o", job2]).status.success());
    fails(&["plan", part, "--bricks", "1x1x1", "--size", "0.2", "-o", job2], 2, "another plan");
    fs::write(&piece, &good).unwrap();
    fs::copy(Path::new(job2).join("plan.json"), Path::new(job).join("plan.json")).unwrap();
    fails(&["merge", job, "-o", out], 3, "another plan");
    fs::write(Path::new(job).join("plan.json"), "{").unwrap();
    fails(&["merge", job, "-o", out], 3, "no plan");
    // Made again from the first plan the mesh has the same bytes, in one process, too.
    fs::write(part, HOLES).unwrap();
    let report = folder.join("r.json");
    let told = ["--report", report.to_str().unwrap(), "-v"];
    let made = command(&[&["mesh", part, "--bricks", "2x1x1", "--size", "0.03", "-o", out, "-q"][..], &told].concat());
    assert!(made.status.success());
    assert_eq!(fs::read(out).unwrap(), whole);
    // The rounds are stages; all triangles that stay are there after the last one.
    let report: serde_json::Value = serde_json::from_slice(&fs::read(report).unwrap()).unwrap();
    let stages = report["stages"].as_array().unwrap();
    let names: Vec<&str> = stages.iter().map(|s| s["name"].as_str().unwrap()).collect();
    assert_eq!(names, ["round 1", "round 2", "round 3", "merge", "check"]);
    let counts: Vec<u64> = stages.iter().map(|s| s["triangles"].as_u64().unwrap()).collect();
    assert!(0 < counts[0] && counts[0] < counts[1] && counts[1] <= counts[2], "{counts:?}");
    assert_eq!(counts[2..], [report["check"]["triangles"].as_u64().unwrap(); 3]);
    assert!(stages.iter().chain(report["attempts"].as_array().unwrap()).all(|s| s["seconds"].as_f64() > Some(0.0)));
    let said = String::from_utf8_lossy(&made.stderr).into_owned();
    for what in ["stage: round 1: ", "attempt: arrange at size ", "stage: check: ", "kept: arrange at size "] {
        assert!(said.contains(what), "{what}: {said}");
    }
    assert_eq!(
        fs::read_dir(&folder)
            .unwrap()
            .filter(|e| e.as_ref().unwrap().path().to_string_lossy().contains("-bricks"))
            .count(),
        0
    );
}

/// Plans the cube with bores in 12 bricks, at `folder`/job.
fn job_of_12(folder: &Path) -> PathBuf {
    let job = folder.join("job");
    fs::create_dir_all(&job).unwrap();
    planned(HOLES, 0.04, [3, 2, 2], &job);
    job
}

/// Bytes of the merged mesh of a job; none if something lacks, which must be named.
fn merged(job: &Path) -> Option<Vec<u8>> {
    let out = job.with_file_name("merged.stl");
    let said = command(&["merge", job.to_str().unwrap(), "-o", out.to_str().unwrap(), "-q"]);
    let text = String::from_utf8_lossy(&said.stderr);
    if said.status.success() {
        let bytes = fs::read(&out).unwrap();
        fs::remove_file(out).unwrap();
        return Some(bytes);
    }
    assert!(said.status.code() == Some(3) && text.contains("not made: brick "), "{text}");
    assert!(!out.exists());
    None
}

/// Pieces that are there, of all rounds, and files of pieces not finished.
fn pieces(job: &Path) -> [usize; 2] {
    let mut count = [0, 0];
    for round in ["round1", "round2", "round3"] {
        for file in fs::read_dir(job.join(round)).into_iter().flatten() {
            count[usize::from(file.unwrap().path().extension().is_none_or(|e| e != "piece"))] += 1;
        }
    }
    count
}

/// Makes all that is missing, and says what the command said.
fn finished(job: &Path) -> String {
    let out = command(&["brick", job.to_str().unwrap()]);
    assert!(out.status.success(), "{}", String::from_utf8_lossy(&out.stderr));
    String::from_utf8_lossy(&out.stdout).trim().into()
}

#[test]
fn workers_that_are_killed_or_run_twice_at_once_leave_what_one_makes() {
    let folder = folder("killed");
    let job = job_of_12(&folder);
    finished(&job);
    let [all, _] = pieces(&job);
    let whole = merged(&job).unwrap();
    fs::remove_dir_all(&job).unwrap();
    let job = job_of_12(&folder);
    let start = || Command::new(env!("CARGO_BIN_EXE_rvachev")).args(["brick", "-q"]).arg(&job).spawn().unwrap();
    // Killed again and again, each time when there is a piece more at least.
    loop {
        let mut worker = start();
        let [before, _] = pieces(&job);
        let done = loop {
            if let Some(status) = worker.try_wait().unwrap() {
                assert!(status.success());
                break true;
            }
            if pieces(&job)[0] > before {
                worker.kill().unwrap();
                worker.wait().unwrap();
                break false;
            }
            std::thread::yield_now();
        };
        let [after, _] = pieces(&job);
        if done || after == all {
            break;
        }
        assert_eq!(merged(&job), None);
    }
    assert_eq!(finished(&job), "0 pieces made");
    assert!(merged(&job).unwrap() == whole);
    // What lacks is made again, and only that.
    fs::remove_file(job.join("round1").join("000003.piece")).unwrap();
    assert_eq!(merged(&job), None);
    assert_eq!(finished(&job), "1 pieces made");
    assert!(merged(&job).unwrap() == whole);
    // Two workers at all of it, at once.
    fs::remove_dir_all(&job).unwrap();
    let job = job_of_12(&folder);
    let workers = [start(), start()];
    for mut w in workers {
        assert!(w.wait().unwrap().success());
    }
    assert_eq!(pieces(&job), [all, 0]);
    assert!(merged(&job).unwrap() == whole);
    fs::remove_dir_all(folder).unwrap();
}

#[test]
fn a_plan_read_back_is_the_plan_to_the_last_bit() {
    let folder = folder("read_back");
    for percent in (1..40).map(|k| 2.0 + 0.1 * f64::from(k)) {
        let size = percent / 100.0 * 12f64.sqrt();
        let job = folder.join(percent.to_string());
        fs::create_dir_all(&job).unwrap();
        let plan = planned(HOLES, size, [1, 1, 1], &job);
        let again = BrickPlan::load(&job).unwrap();
        assert_eq!((&again, again.digest()), (&plan, plan.digest()), "{percent}");
    }
    fs::remove_dir_all(folder).unwrap();
}

/// A limit to the size of files stands for a full disk: writing more fails in the same way.
#[cfg(unix)]
#[test]
fn a_full_disk_is_an_error_that_leaves_nothing_behind() {
    let folder = folder("full");
    let job = job_of_12(&folder);
    let full = |blocks: u32, args: &[&str]| {
        let limited = format!("trap '' XFSZ; ulimit -f {blocks}; exec \"$0\" \"$@\"");
        let out = Command::new("sh").args(["-c", &limited, env!("CARGO_BIN_EXE_rvachev")]).args(args).output().unwrap();
        let text = String::from_utf8_lossy(&out.stderr).into_owned();
        assert_eq!(out.status.code(), Some(4), "{args:?}: {text}");
        text
    };
    let (part, out) = (job.join("part.py"), folder.join("full.stl"));
    let [part, out, job_] = [&part, &out, &job].map(|p| p.to_str().unwrap());
    let said = full(16, &["brick", job_]);
    assert!(said.contains(".piece"), "{said}");
    let [_, unfinished] = pieces(&job);
    assert_eq!(unfinished, 0);
    assert_eq!(merged(&job), None);
    finished(&job);
    let whole = merged(&job).unwrap();
    let said = full(16, &["merge", job_, "-o", out]);
    assert!(said.contains("full.stl"), "{said}");
    let before = fs::read_dir(&folder).unwrap().count();
    for blocks in [16, 600] {
        full(blocks, &["mesh", part, "--size", "0.04", "--bricks", "3x2x2", "-o", out]);
    }
    // No mesh, no part of one, no folder of pieces.
    assert_eq!(fs::read_dir(&folder).unwrap().count(), before);
    assert!(!Path::new(out).exists());
    assert!(merged(&job).unwrap() == whole);
    fs::remove_dir_all(folder).unwrap();
}

#[test]
fn a_plan_of_another_version_is_refused_by_all() {
    let folder = folder("version");
    let job = job_of_12(&folder);
    let path = job.join("plan.json");
    let text = fs::read_to_string(&path).unwrap();
    let other = text.replace(concat!("\"", env!("CARGO_PKG_VERSION"), "\""), "\"0.0.1\"");
    assert_ne!(other, text);
    fs::write(&path, other).unwrap();
    let (job, out, part) = (job.to_str().unwrap(), folder.join("a.stl"), job.join("part.py"));
    let (out, part) = (out.to_str().unwrap(), part.to_str().unwrap());
    fails(&["brick", job], 3, "a plan of version 0.0.1");
    fails(&["merge", job, "-o", out], 3, "a plan of version 0.0.1");
    fails(&["plan", part, "--size", "0.04", "--bricks", "3x2x2", "-o", job], 3, "a plan of version 0.0.1");
    assert_eq!(pieces(Path::new(job)), [0, 0]);
    fs::remove_dir_all(folder).unwrap();
}

#[test]
fn formats_that_take_the_mesh_into_memory_say_so() {
    let folder = folder("formats");
    let job = job_of_12(&folder);
    finished(&job);
    let said = |name: &str| {
        let out = command(&["merge", job.to_str().unwrap(), "-o", folder.join(name).to_str().unwrap()]);
        assert!(out.status.success());
        String::from_utf8_lossy(&out.stderr).contains("all of the mesh into memory")
    };
    for name in ["a.stl", "a.obj", "a.ply", "a.off", "a.vtu", "a.xdmf"] {
        assert!(!said(name), "{name}");
    }
    for name in ["a.msh", "a.inp", "a.bdf", "a.mesh", "a.su2", "a.vtp", "a.3mf", "a.glb", "a.med"] {
        assert!(said(name), "{name}");
    }
    fs::remove_dir_all(folder).unwrap();
}
