//! What the command hands over besides meshes: reports as tables, completions, man pages, meshes that follow their part.

use std::fs;
use std::path::Path;

use approx::assert_abs_diff_eq;
use assert_cmd::Command;
use predicates::prelude::*;
use predicates::str::contains;
use tempfile::TempDir;

const COMMANDS: [&str; 17] = [
    "mesh",
    "view",
    "compare",
    "check",
    "heal",
    "join",
    "info",
    "eval",
    "grid",
    "convert",
    "render",
    "path",
    "plan",
    "brick",
    "merge",
    "completions",
    "man",
];

fn rvachev(dir: &Path, args: &[&str]) -> assert_cmd::assert::Assert {
    Command::cargo_bin("rvachev").unwrap().current_dir(dir).args(args).assert()
}

fn said(dir: &Path, args: &[&str]) -> String {
    String::from_utf8(rvachev(dir, args).success().get_output().stdout.clone()).unwrap()
}

#[test]
fn completions_know_every_command_and_its_options() {
    let dir = TempDir::new().unwrap();
    for shell in ["bash", "zsh", "fish", "powershell", "elvish"] {
        let script = said(dir.path(), &["completions", shell]);
        for what in COMMANDS.iter().copied().chain(["feature-angle", "rsystem", "msh-version", "max-hole"]) {
            assert!(script.contains(what), "{shell} does not know {what}");
        }
    }
    rvachev(dir.path(), &["completions", "tcsh"]).code(2).stderr(contains("bash"));
}

#[test]
fn every_command_has_a_man_page() {
    let dir = TempDir::new().unwrap();
    said(dir.path(), &["man", "-o", "man/man1"]);
    let mut pages: Vec<_> =
        fs::read_dir(dir.path().join("man/man1")).unwrap().map(|e| e.unwrap().file_name()).collect();
    pages.sort();
    let mut wanted: Vec<std::ffi::OsString> = COMMANDS.iter().map(|c| format!("rvachev-{c}.1").into()).collect();
    wanted.push("rvachev.1".into());
    wanted.sort();
    assert_eq!(pages, wanted);
    let read = |name: &str| fs::read_to_string(dir.path().join("man/man1").join(name)).unwrap();
    let whole = said(dir.path(), &["man"]);
    for command in COMMANDS {
        let page = read(&format!("rvachev-{command}.1"));
        assert!(page.contains(&format!(".TH rvachev-{command} 1")), "{page}");
        assert!(read("rvachev.1").contains(&format!("rvachev\\-{command}(1)")), "{command}");
        assert!(whole.contains(&page), "{command}");
    }
    assert!(read("rvachev-mesh.1").contains("\\-\\-feature\\-angle"));
    rvachev(dir.path(), &["man", "-o", "man/man1/rvachev.1"]).code(4).stderr(contains("rvachev.1"));
}

/// A cube whose sides have names that mean something to a browser, to print as ASCII STL.
fn hostile() -> String {
    let corner = |k: usize| format!("{} {} {}", k & 1, k >> 1 & 1, k >> 2 & 1);
    let sides = [
        ("<script>alert(1)</script>", [0, 4, 6, 2]),
        ("\"><img src=x onerror=alert(2)>", [1, 3, 7, 5]),
        ("</td></table>&amp;'", [0, 1, 5, 4]),
        ("back\u{202e}wards", [2, 6, 7, 3]),
        ("low", [0, 2, 3, 1]),
        ("high", [4, 5, 7, 6]),
    ];
    let mut out = String::new();
    for (name, [a, b, c, d]) in sides {
        out += &format!("solid {name}\n");
        for t in [[a, b, c], [a, c, d]] {
            let [a, b, c] = t.map(corner);
            out += &format!("facet normal 0 0 0\nouter loop\nvertex {a}\nvertex {b}\nvertex {c}\nendloop\nendfacet\n");
        }
        out += "endsolid\n";
    }
    out
}

#[test]
fn a_report_as_html_has_tables_and_names_in_it_are_only_text() {
    let dir = TempDir::new().unwrap();
    fs::write(dir.path().join("cube.stl"), hostile()).unwrap();
    let args = ["mesh", "cube.stl", "-o", "a.off", "--size", "0.25", "-q", "--report"];
    rvachev(dir.path(), &[&args[..], &["a.html", "--html", "b.html", "--png", "c.png"]].concat()).success();
    let page = fs::read_to_string(dir.path().join("a.html")).unwrap();
    // Nothing of a name is markup, and nothing runs or is loaded.
    for bad in ["<script", "<img", "\u{202e}", "http:", "https:", "src="] {
        assert!(!page.replace("img src=x", "").contains(bad), "{bad}: {page}");
    }
    for name in [
        "<td>&lt;script&gt;alert(1)&lt;/script&gt;</td>",
        "<td>&quot;&gt;&lt;img src=x onerror=alert(2)&gt;</td>",
        "<td>&lt;/td&gt;&lt;/table&gt;&amp;amp;&#39;</td>",
        "<td>back\\u202ewards</td>",
    ] {
        assert!(page.contains(name), "{name}: {page}");
    }
    for title in
        ["Certificate", "Figures", "Faces", "Attempts, in the order of time", "Stages of the mesh that was kept"]
    {
        assert!(page.contains(&format!("<h2>{title}</h2>")), "{title}");
    }
    for tag in ["table", "thead", "tbody", "tr", "td", "section", "ul", "li"] {
        let opened = page.matches(&format!("<{tag}>")).count() + page.matches(&format!("<{tag} ")).count();
        assert!(opened > 0 && opened == page.matches(&format!("</{tag}>")).count(), "{tag}");
    }
    // Each side of the cube has an area of one.
    assert_eq!(page.matches("<td class=\"number\">1.000000</td>").count(), 7, "{page}");
    assert!(page.contains("The mesh is sound; it falls short of nothing"), "{page}");
    assert!(fs::read(dir.path().join("c.png")).unwrap().starts_with(b"\x89PNG"));
    assert!(fs::read_to_string(dir.path().join("b.html")).unwrap().contains("<canvas"));
    // Other endings are JSON.
    rvachev(dir.path(), &[&args[..], &["a.txt"]].concat()).success();
    assert!(fs::read_to_string(dir.path().join("a.txt")).unwrap().starts_with('{'));
    // One file does not hold two things.
    rvachev(dir.path(), &[&args[..], &["d.html", "--html", "d.html"]].concat())
        .code(2)
        .stderr(contains("written twice"));
    assert!(!dir.path().join("d.html").exists());
}

#[test]
fn shortfalls_are_in_the_report_with_their_places() {
    let dir = TempDir::new().unwrap();
    let source = "part(sphere(1) | cylinder(0.004, height=4))\n";
    fs::write(dir.path().join("part.py"), source).unwrap();
    let args = ["mesh", "part.py", "-o", "a.off", "--size", "0.3", "--method", "mc", "-q", "--report", "a.html"];
    rvachev(dir.path(), &args).code(1);
    let page = fs::read_to_string(dir.path().join("a.html")).unwrap();
    let wanted = contains("<td>falls short</td>").and(contains("apart somewhere, more than the size of 3.0000e-1"));
    assert!(
        wanted.eval(&page) && page.contains("<p class=\"verdict bad\">The mesh is sound; it falls short"),
        "{page}"
    );
}

#[test]
fn pictures_are_png_and_say_so() {
    let dir = TempDir::new().unwrap();
    fs::write(dir.path().join("cube.stl"), hostile()).unwrap();
    for args in [
        &["render", "cube.stl", "-o", "a.jpg"][..],
        &["mesh", "cube.stl", "-o", "a.off", "--png", "a.jpeg"],
        &["compare", "cube.stl", "--png", "a.svg"],
    ] {
        rvachev(dir.path(), args).code(2).stderr(contains("should end in .png"));
    }
    rvachev(dir.path(), &["render", "cube.stl", "-o", "a.PNG", "--size", "32x32"]).success();
    assert!(fs::read(dir.path().join("a.PNG")).unwrap().starts_with(b"\x89PNG"));
    assert_eq!(fs::read_dir(&dir).unwrap().count(), 2);
}

#[cfg(unix)]
#[test]
fn a_watched_part_is_meshed_again_when_it_changes() {
    use std::io::{BufRead, BufReader};
    use std::process::{Command, Stdio};
    use std::sync::mpsc::channel;
    use std::time::Duration;
    let dir = TempDir::new().unwrap();
    let write = |text: &str| fs::write(dir.path().join("part.py"), text).unwrap();
    write("part(sphere(1))\n");
    let mut child = Command::new(env!("CARGO_BIN_EXE_rvachev"))
        .current_dir(&dir)
        .args(["mesh", "part.py", "-o", "out.off", "--size", "0.3", "--watch"])
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let (send, lines) = channel();
    let from = BufReader::new(child.stderr.take().unwrap());
    let reader = std::thread::spawn(move || from.lines().map_while(Result::ok).try_for_each(|l| send.send(l)));
    // Lines are waited for, so a slow machine only takes longer.
    let mut wait_for = |what: &str| {
        let mut before = Vec::new();
        loop {
            match lines.recv_timeout(Duration::from_secs(60)) {
                Ok(line) if line.starts_with(what) => return,
                Ok(line) => before.push(line),
                Err(e) => {
                    let _ = child.kill();
                    panic!("{what:?} is not told ({e}): {before:?}");
                }
            }
        }
    };
    // All nodes are on the ball, so the first one tells its radius.
    let radius = || {
        let text = fs::read_to_string(dir.path().join("out.off")).unwrap();
        let first = text.lines().nth(2).unwrap().split_whitespace().map(|x| x.parse::<f64>().unwrap());
        first.map(|x| x * x).sum::<f64>().sqrt()
    };
    wait_for("watching: part.py");
    assert_abs_diff_eq!(radius(), 1.0, epsilon = 1e-9);
    // A mistake is told, the mesh stays, and the watch goes on.
    write("part(spher(1.5))\n");
    wait_for("error: part.py: line 1, column 6");
    wait_for("watching: part.py");
    assert_abs_diff_eq!(radius(), 1.0, epsilon = 1e-9);
    write("part(sphere(1.5))\n\n");
    wait_for("watching: part.py");
    assert_abs_diff_eq!(radius(), 1.5, epsilon = 1e-9);
    let killed = Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap();
    assert!(killed.success());
    assert_eq!(child.wait().unwrap().code(), Some(130));
    reader.join().unwrap().unwrap();
}

#[test]
fn a_watch_that_cannot_begin_ends() {
    let dir = TempDir::new().unwrap();
    rvachev(dir.path(), &["mesh", "none.py", "-o", "a.off", "--watch"]).code(3).stderr(contains("none.py"));
    fs::write(dir.path().join("part.py"), "part(sphere(1))\n").unwrap();
    rvachev(dir.path(), &["mesh", "part.py", "-o", "a.xyz", "--watch"]).code(2);
    let bricks = ["mesh", "part.py", "-o", "a.off", "--watch", "--bricks", "1x1x1"];
    rvachev(dir.path(), &bricks).code(2).stderr(contains("--bricks"));
}
