//! Pages: what they hold, what they refuse to run, and how they behave in a browser.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::Command;

use rvachev::mesh::{Group, TriMesh};
use rvachev::page::{PageKind, PageLine, PageText, decode, page};
use rvachev::{DVec3, Run};
use serde_json::Value;

/// Names and texts that would run or break out if they were taken for HTML.
const NASTY: &str = "</script><script>document.title='hurt'</script><img src=x onerror=\"document.title='hurt'\"><!--";

/// A cube from 0 to 1 with a face per side and `n` squares along an edge.
fn cube(n: u32) -> TriMesh {
    let mut known: BTreeMap<[u32; 3], u32> = BTreeMap::new();
    let mut mesh = TriMesh::default();
    for side in 0..6u32 {
        let (axis, high) = ((side / 2) as usize, side % 2 == 1);
        let mut node = |i: u32, j: u32| {
            let mut p = [0; 3];
            (p[axis], p[(axis + 1) % 3], p[(axis + 2) % 3]) = (if high { n } else { 0 }, i, j);
            *known.entry(p).or_insert_with(|| {
                mesh.nodes.push(DVec3::from(p.map(f64::from)) / f64::from(n));
                mesh.nodes.len() as u32 - 1
            })
        };
        for (i, j) in (0..n).flat_map(|i| (0..n).map(move |j| (i, j))) {
            let [a, b, c, d] = [node(i, j), node(i + 1, j), node(i + 1, j + 1), node(i, j + 1)];
            let turned = |t: [u32; 3]| if high { t } else { [t[0], t[2], t[1]] };
            mesh.triangles.extend([turned([a, b, c]), turned([a, c, d])]);
            mesh.labels.extend([side; 2]);
        }
        mesh.faces.push(if side == 5 { NASTY.into() } else { format!("side {side}") });
    }
    mesh.groups = vec![Group { name: "x".into(), faces: vec![0, 1] }];
    mesh
}

fn text() -> PageText {
    let lines = vec![
        PageLine::at(PageKind::Shortfall, NASTY, vec![[1.0, 0.25, 0.75], [0.0, 0.0, 0.0]]),
        PageLine::new(PageKind::Warning, "something near (0.500000, 0.500000, 1.000000)"),
        PageLine::new(PageKind::Warning, "nowhere in particular"),
    ];
    PageText { title: NASTY.into(), size: Some(0.1), sound: Some(true), lines, ..PageText::default() }
}

fn command() -> Command {
    Command::new(env!("CARGO_BIN_EXE_rvachev"))
}

fn data(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("data").join(name)
}

/// What becomes of a page in a browser, as HTML.
fn browsed(html: &Path, hash: &str, more: &[&str]) -> String {
    let home = tempfile::tempdir().unwrap();
    let out = Command::new("chromium")
        .args(["--headless", "--no-sandbox", "--disable-gpu", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"])
        .args(["--disable-quic", "--no-first-run", "--disable-background-networking", "--disable-component-update"])
        .args(["--disable-sync", "--window-size=900,600", "--virtual-time-budget=20000", "--dump-dom"])
        .args(more)
        .arg(format!("--user-data-dir={}", home.path().display()))
        .arg(format!("file://{}{hash}", html.canonicalize().unwrap().display()))
        .output()
        .expect("this test needs a browser: install it with `apt-get install -y chromium`");
    String::from_utf8_lossy(&out.stdout).into_owned()
}

/// What a page says of itself after it tried everything on itself.
fn selftest(html: &Path) -> Value {
    let dom = browsed(html, "#selftest", &[]);
    let found = dom.rsplit_once("<pre id=\"selftest\">").and_then(|(_, after)| after.split_once("</pre>"));
    let (json, _) = found.unwrap_or_else(|| panic!("the page did not get through its test: {} bytes", dom.len()));
    let json = json.replace("&lt;", "<").replace("&gt;", ">").replace("&amp;", "&");
    let mut told: Value = serde_json::from_str(&json).unwrap();
    let title = dom.split_once("<title>").and_then(|(_, after)| after.split_once("</title>")).unwrap().0;
    told["title"] = title.into();
    told
}

fn number(told: &Value, name: &str) -> f64 {
    told[name].as_f64().unwrap_or_else(|| panic!("no {name} in {told}"))
}

#[test]
fn a_page_holds_its_mesh_and_nothing_that_runs() {
    let mesh = cube(20);
    let html = page(&mesh, &text(), &Run::new()).unwrap();
    let back = decode(&html).unwrap();
    assert_eq!((&back.triangles, &back.labels), (&mesh.triangles, &mesh.labels));
    let step = 1.0 / f64::from((1 << 21) - 1);
    for (rounded, p) in back.nodes.iter().zip(&mesh.nodes) {
        let q = DVec3::from(rounded.map(f64::from)) * step;
        assert!((q - *p).abs().max_element() <= 0.5001 * step, "{p} is {q}");
    }
    assert_eq!(back.nodes.len(), mesh.nodes.len());
    // twelve edges of twenty pieces each
    assert_eq!(back.edges.len(), 12 * 20);
    // three scripts, opened and closed: what names and texts hold opens and closes none
    for mark in ["<script", "</script"] {
        assert_eq!(html.matches(mark).count(), 3, "{mark}");
    }
    assert!(!html.contains("<img") && !html.contains("http://") && !html.contains("https://"));
}

#[test]
fn any_mesh_has_a_page_and_what_is_none_is_refused() {
    let run = Run::new();
    let empty = page(&TriMesh::default(), &PageText::default(), &run).unwrap();
    assert!(decode(&empty).unwrap().triangles.is_empty());
    // a single point, a huge box, an open fan
    for scale in [0.0, 1e-300, 1e300] {
        let nodes = vec![DVec3::ZERO, scale * DVec3::X, scale * DVec3::Y];
        let html = page(&TriMesh::new(nodes, vec![[0, 1, 2]]), &PageText::default(), &run).unwrap();
        assert_eq!(decode(&html).unwrap().triangles, [[0, 1, 2]]);
    }
    assert!(page(&TriMesh::new(vec![DVec3::ZERO], vec![[0, 1, 2]]), &PageText::default(), &run).is_err());
    assert!(page(&TriMesh::new(vec![DVec3::NAN; 3], vec![[0, 1, 2]]), &PageText::default(), &run).is_err());
}

#[test]
fn a_hundred_thousand_triangles_take_less_than_three_megabytes() {
    // 12 n^2 triangles; numbers of nodes and triangles shuffled are the worst there is
    let mut mesh = cube(92);
    let count = mesh.nodes.len();
    let place: Vec<usize> = (0..count).map(|i| i * 7919 % count).collect();
    assert_eq!(place.iter().collect::<std::collections::BTreeSet<_>>().len(), count);
    let plain = page(&mesh, &text(), &Run::new()).unwrap().len();
    let old = mesh.nodes.clone();
    place.iter().zip(&old).for_each(|(to, p)| mesh.nodes[*to] = *p);
    mesh.triangles.iter_mut().flatten().for_each(|v| *v = place[*v as usize] as u32);
    let shuffled = page(&mesh, &text(), &Run::new()).unwrap().len();
    assert!(mesh.triangles.len() > 100_000 && plain < 3_000_000 && shuffled < 3_000_000, "{plain} and {shuffled}");
}

#[test]
fn the_command_writes_the_same_page_for_any_threads() {
    let folder = tempfile::tempdir().unwrap();
    let write = |threads: &str| {
        let to = folder.path().join(format!("{threads}.html"));
        let mesh = folder.path().join("a.off");
        let out = command()
            .args(["mesh", "--size", "4%", "-q", "--threads", threads])
            .arg(data("bracket.py"))
            .arg("-o")
            .arg(&mesh)
            .arg("--html")
            .arg(&to)
            .output()
            .unwrap();
        assert!(out.status.success(), "{}", String::from_utf8_lossy(&out.stderr));
        std::fs::read_to_string(to).unwrap()
    };
    let page = write("1");
    assert!(page == write("2"), "pages differ between one thread and two");
    let written = rvachev::io::read(&folder.path().join("a.off"), &Run::new()).unwrap();
    assert_eq!(decode(&page).unwrap().triangles.len(), written.triangles.len());
}

#[test]
fn a_page_works_in_a_browser() {
    let folder = tempfile::tempdir().unwrap();
    let html = folder.path().join("cube.html");
    std::fs::write(&html, page(&cube(6), &text(), &Run::new()).unwrap()).unwrap();
    let told = selftest(&html);
    assert_eq!(told["error"], 0, "{told}");
    assert_eq!((number(&told, "triangles"), number(&told, "edges")), (432.0, 72.0));
    let (pixels, canvas) = (number(&told, "pixels"), number(&told, "canvas"));
    assert!(0.1 * canvas < pixels && pixels < 0.9 * canvas, "{told}");
    // with all boxes off nothing is left; with that of the side in the middle, which is one of three seen, some of it
    assert_eq!((number(&told, "none"), number(&told, "all")), (0.0, pixels), "{told}");
    assert!((0.1 * pixels..0.7 * pixels).contains(&number(&told, "one")), "{told}");
    assert_eq!((number(&told, "angle"), number(&told, "length")), (pixels, pixels), "{told}");
    assert!(number(&told, "cut") < 0.95 * pixels, "{told}");
    assert!(told["tip"].as_str().is_some_and(|t| t.contains("triangle")), "{told}");
    let inks = &told["inks"];
    assert!(number(inks, "with") > 100.0 + number(inks, "without"), "{told}");
    // the place the first line speaks of is in the middle, and marked
    let target: Vec<f64> = told["target"].as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect();
    assert!(target.iter().zip([1.0, 0.25, 0.75]).all(|(a, b)| (a - b).abs() < 1e-5), "{told}");
    assert!(number(&told, "marks_before") == 0.0 && number(&told, "marks") > 50.0, "{told}");
    // the nasty title is text, and nothing it holds has run
    assert!(told["title"].as_str().is_some_and(|t| t.starts_with("&lt;/script&gt;")), "{told}");
}

#[test]
fn where_nothing_can_be_drawn_the_page_says_so() {
    let folder = tempfile::tempdir().unwrap();
    let html = folder.path().join("cube.html");
    std::fs::write(&html, page(&cube(2), &text(), &Run::new()).unwrap()).unwrap();
    let dom = browsed(&html, "", &["--disable-3d-apis"]);
    assert!(dom.contains("<p id=\"trouble\">The mesh cannot be drawn here"), "{} bytes", dom.len());
}

#[test]
fn every_kind_of_input_has_a_page_that_draws() {
    let folder = tempfile::tempdir().unwrap();
    for part in ["cube_with_holes.py", "step/torus.step", "soups/bored_block.off"] {
        let to = folder.path().join("a.html");
        let out = command().args(["view", "--size", "5%", "-q"]).arg(data(part)).arg("-o").arg(&to).output().unwrap();
        assert!(out.status.success(), "{part}: {}", String::from_utf8_lossy(&out.stderr));
        let told = selftest(&to);
        assert!(told["error"] == 0 && number(&told, "pixels") > 0.05 * number(&told, "canvas"), "{part}: {told}");
    }
}

#[test]
fn what_is_not_sound_is_shown_and_healing_too() {
    let folder = tempfile::tempdir().unwrap();
    let (off, html) = (folder.path().join("open.off"), folder.path().join("open.html"));
    // a tetrahedron without a side
    std::fs::write(&off, "OFF\n4 3 0\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 0 3 2\n").unwrap();
    let healed = folder.path().join("healed.off");
    let out = command().args(["heal", "-q", "-o"]).arg(&healed).arg(&off).arg("--html").arg(&html).output().unwrap();
    assert!(out.status.success(), "{}", String::from_utf8_lossy(&out.stderr));
    let told = selftest(&html);
    // the line about the hole leads there: a sound place is within the part's box
    let target = told["target"].as_array().unwrap();
    assert!(target.iter().all(|x| (-0.01..=1.01).contains(&x.as_f64().unwrap())), "{told}");
    assert!(number(&told, "marks") > 50.0, "{told}");
}
