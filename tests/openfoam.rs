//! A part in a wind tunnel, meshed by OpenFOAM through the script that users read: patches have the names of the part's faces, and
//! their areas, edges and the room around the part are as they should be.
//!
//! Needs OpenFOAM (Debian: `apt install --no-install-recommends openfoam`). Where it is missing the test fails, saying so.

use std::collections::BTreeMap;
use std::f64::consts::PI;
use std::fs;
use std::path::Path;
use std::process::Command;

use approx::{assert_relative_eq, relative_eq};
use rvachev::DVec3;

/// A case's mesh: its points, and the faces of each patch, which look out of the cells.
struct Case {
    points: Vec<DVec3>,
    patches: BTreeMap<String, Vec<Vec<usize>>>,
}

/// The text of a file below its head.
fn body(folder: &Path, name: &str) -> String {
    let text = fs::read_to_string(folder.join("constant/polyMesh").join(name)).unwrap();
    text.split_once("* //\n").unwrap_or_else(|| panic!("{name} has no head:\n{text}")).1.to_owned()
}

/// Entries of a list, one a line in brackets, without their brackets.
fn entries(text: &str) -> impl Iterator<Item = &str> {
    text.lines().filter_map(|line| line.trim().strip_suffix(')')?.split_once('(').map(|(_, inside)| inside))
}

impl Case {
    fn read(folder: &Path) -> Self {
        let (points, faces) = (body(folder, "points"), body(folder, "faces"));
        let points = entries(&points).map(|row| {
            let c: Vec<f64> = row.split(' ').map(|w| w.parse().unwrap()).collect();
            DVec3::new(c[0], c[1], c[2])
        });
        let faces: Vec<Vec<usize>> =
            entries(&faces).map(|row| row.split(' ').map(|w| w.parse().unwrap()).collect()).collect();
        let mut patches = BTreeMap::new();
        let boundary = body(folder, "boundary");
        for block in boundary.split('}') {
            let Some((before, inside)) = block.split_once('{') else { continue };
            let value = |key: &str| -> usize {
                let words: Vec<&str> = inside.split(|c: char| c.is_whitespace() || c == ';').collect();
                let at = words.iter().position(|w| *w == key).unwrap_or_else(|| panic!("no {key} in {inside}"));
                words[at..].iter().find_map(|w| w.parse().ok()).unwrap()
            };
            let name = before.split_whitespace().last().unwrap();
            let start = value("startFace");
            patches.insert(name.to_owned(), faces[start..start + value("nFaces")].to_vec());
        }
        Self { points: points.collect(), patches }
    }

    /// Twice the area and the center of each triangle that the faces of a patch fall into around their first point.
    fn triangles(&self, patch: &str) -> Vec<(DVec3, DVec3)> {
        let of_face = |face: &Vec<usize>| {
            let at: Vec<DVec3> = face.iter().map(|&v| self.points[v]).collect();
            (1..at.len() - 1)
                .map(|k| ((at[k] - at[0]).cross(at[k + 1] - at[0]), (at[0] + at[k] + at[k + 1]) / 3.0))
                .collect::<Vec<_>>()
        };
        self.patches[patch].iter().flat_map(of_face).collect()
    }

    fn area(&self, patch: &str) -> f64 {
        self.triangles(patch).iter().map(|(normal, _)| normal.length() / 2.0).sum()
    }

    /// Of all cells, by the divergence theorem over all patches.
    fn volume(&self) -> f64 {
        let of_patch = |patch: &String| self.triangles(patch).iter().map(|(n, c)| n.dot(*c) / 6.0).sum::<f64>();
        self.patches.keys().map(of_patch).sum()
    }

    fn points_of(&self, patch: &str) -> Vec<DVec3> {
        self.patches[patch].iter().flatten().map(|&v| self.points[v]).collect()
    }

    /// The ends of edges that two patches share.
    fn edges_between(&self, a: &str, b: &str) -> Vec<[DVec3; 2]> {
        let edges = |patch: &str| -> Vec<[usize; 2]> {
            let of_face = |face: &Vec<usize>| {
                let next = face.iter().cycle().skip(1);
                face.iter().zip(next).map(|(&u, &v)| [u.min(v), u.max(v)]).collect::<Vec<_>>()
            };
            self.patches[patch].iter().flat_map(of_face).collect()
        };
        let others = edges(b);
        edges(a).into_iter().filter(|e| others.contains(e)).map(|e| e.map(|v| self.points[v])).collect()
    }
}

#[test]
fn patches_of_a_wind_tunnel_are_the_faces_of_the_part() {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("openfoam");
    let _ = fs::remove_dir_all(&folder);
    fs::create_dir_all(&folder).unwrap();
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/openfoam/run.sh");
    let out = Command::new("bash").arg(script).arg(env!("CARGO_BIN_EXE_rvachev")).arg(&folder).output().unwrap();
    let said = String::from_utf8_lossy(&[out.stdout, out.stderr].concat()).into_owned();
    assert!(out.status.success() && said.contains("Mesh OK"), "{said}");

    let case = Case::read(&folder);
    let sides = ["xmin", "xmax", "ymin", "ymax", "zmin", "zmax"].map(|side| format!("part_block.{side}"));
    let mut names: Vec<&str> = sides.iter().map(String::as_str).collect();
    names.extend(["part_bore", "inlet", "outlet", "walls"]);
    names.sort_unstable();
    assert_eq!(case.patches.keys().collect::<Vec<_>>(), names);

    // A block of side one with a bore of radius 0.3, in a tunnel of 6 by 3 by 3. Chords of the part's own mesh, about two dozen around the
    // bore, take a hundredth of the hole's area and a few thousandths of the bore's.
    let hole = 0.09 * PI;
    for (patch, truth, share) in [
        ("inlet", 9.0, 1e-6),
        ("outlet", 9.0, 1e-6),
        ("walls", 72.0, 1e-6),
        ("part_block.xmin", 1.0 - hole, 5e-3),
        ("part_block.xmax", 1.0 - hole, 5e-3),
        ("part_block.ymin", 1.0, 1e-6),
        ("part_block.ymax", 1.0, 1e-6),
        ("part_block.zmin", 1.0, 1e-6),
        ("part_block.zmax", 1.0, 1e-6),
        ("part_bore", 0.6 * PI, 5e-3),
    ] {
        let area = case.area(patch);
        assert!(relative_eq!(area, truth, epsilon = 0.0, max_relative = share), "{patch}: {area}, in truth {truth}");
    }
    let (volume, truth) = (case.volume(), 54.0 - 1.0 + hole);
    assert_relative_eq!(volume, truth, epsilon = 0.0, max_relative = 2e-4);

    // Points of a patch are on its face: on the bore as far inside as the middle of such a chord.
    let radius = |p: &DVec3| p.y.hypot(p.z);
    let most = |list: Vec<f64>| list.into_iter().map(f64::abs).fold(0.0, f64::max);
    let flat = most(case.points_of("part_block.ymax").iter().map(|p| p.y - 0.5).collect());
    let round: Vec<f64> = case.points_of("part_bore").iter().map(|p| radius(p) - 0.3).collect();
    assert!(flat < 1e-6 && most(round) < 3e-3, "{flat}");
    // Cells that do not know the edges of the part cut rims by a sixth and edges by a fiftieth.
    for (a, b, truth) in [
        ("part_block.xmin", "part_bore", 0.6 * PI),
        ("part_block.xmax", "part_bore", 0.6 * PI),
        ("part_block.ymin", "part_block.zmax", 1.0),
        ("part_block.xmax", "part_block.zmax", 1.0),
    ] {
        let edges = case.edges_between(a, b);
        let length: f64 = edges.iter().map(|[p, q]| p.distance(*q)).sum();
        assert!(
            relative_eq!(length, truth, epsilon = 0.0, max_relative = 5e-3),
            "{a} and {b}: {length}, in truth {truth}"
        );
    }
}
