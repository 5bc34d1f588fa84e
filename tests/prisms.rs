//! Volumes swept by a face of a finished mesh, as prisms: volumes, areas and names against closed forms, and what is refused.

use std::collections::{BTreeMap, BTreeSet};
use std::f64::consts::PI;
use std::fs;

use rvachev::implicit::part::parse;
use rvachev::io::{Encoding, WriteOptions, write_prisms};
use rvachev::mesh::{Prisms, TriMesh};
use rvachev::pipeline::{MeshOptions, SizeRequest, mesh_part};
use rvachev::{DVec3, Run};

/// The plate is 2 by 2 by 1, with a bore through it.
const RADIUS: f64 = 0.5;
const AREA: f64 = 4.0 - PI * RADIUS * RADIUS;
const TOP: &str = "plate.zmax";
const BOTTOM: &str = "plate.zmin";

/// The whole mesh, read out of its merged fragments.
fn plate() -> TriMesh {
    let text = "part(box((2, 2, 1)).name(\"plate\") - cylinder(0.5, \"z\").name(\"bore\"))\n";
    let options = MeshOptions { size: Some(SizeRequest::Length(0.2)), ..MeshOptions::default() };
    let made = mesh_part(&parse(text, &[]).unwrap(), &options, &Run::new()).unwrap();
    TriMesh::from_view(&made.merged().unwrap())
}

fn label(mesh: &TriMesh, face: &str) -> u32 {
    mesh.faces.iter().position(|f| f == face).unwrap() as u32
}

fn area(mesh: &TriMesh, face: &str) -> f64 {
    let own = label(mesh, face);
    let list = (0..mesh.triangles.len()).filter(|t| mesh.labels[*t] == own);
    list.map(|t| 0.5 * mesh.area_vector(t).length()).sum()
}

fn edges([a, b, c]: [u32; 3]) -> [[u32; 2]; 3] {
    [[a, b], [b, c], [c, a]]
}

/// A solid whose bottom is its top moved: the triangles of the plate's top, the same one below with numbers in reverse, and walls of
/// two triangles along each edge, with the names beside the top.
fn walled(plate: &TriMesh, height: f64) -> TriMesh {
    let top = label(plate, TOP);
    let mut mesh = TriMesh { faces: plate.faces.clone(), ..TriMesh::default() };
    let mut beside = BTreeMap::new();
    for (t, l) in plate.triangles.iter().zip(&plate.labels) {
        edges(*t).into_iter().for_each(|e| _ = beside.insert(e, *l));
    }
    let count = plate.nodes.len() as u32;
    let under = |v: u32| 2 * count - 1 - v;
    mesh.nodes = plate.nodes.clone();
    mesh.nodes.extend(plate.nodes.iter().rev().map(|p| *p - height * DVec3::Z));
    let mut add = |t: [u32; 3], l: u32| {
        mesh.triangles.push(t);
        mesh.labels.push(l);
    };
    for (t, _) in plate.triangles.iter().zip(&plate.labels).filter(|x| *x.1 == top) {
        add(*t, top);
        for [a, b] in edges(*t) {
            let wall = beside[&[b, a]];
            if wall != top {
                add([b, a, under(a)], wall);
                add([b, under(a), under(b)], wall);
            }
        }
    }
    for (t, _) in plate.triangles.iter().zip(&plate.labels).rev().filter(|x| *x.1 == top) {
        add([t[1], t[0], t[2]].map(under), label(plate, BOTTOM));
    }
    mesh.drop_unused_nodes();
    let defects = mesh.defects();
    assert!(defects.is_closed() && defects.is_manifold() && defects.is_oriented());
    mesh
}

/// The boundary as triangles, quadrilaterals cut in two.
fn boundary(prisms: &Prisms) -> TriMesh {
    let mut mesh = TriMesh { nodes: prisms.nodes.clone(), faces: prisms.names.clone(), ..TriMesh::default() };
    for outer in &prisms.outer {
        let corners: Vec<u32> = prisms.corners(outer).collect();
        for k in 2..corners.len() {
            mesh.triangles.push([corners[0], corners[k - 1], corners[k]]);
            mesh.labels.push(outer.label);
        }
    }
    mesh.drop_unused_nodes();
    mesh
}

/// Every side has two prisms or is on the boundary, and the boundary is closed and looks outward.
fn sound(prisms: &Prisms) {
    let mut sides: BTreeMap<Vec<u32>, usize> = BTreeMap::new();
    let sorted = |mut side: Vec<u32>| {
        side.sort_unstable();
        side
    };
    for &[a, b, c, d, e, f] in &prisms.cells {
        for side in [vec![a, b, c], vec![d, e, f], vec![a, b, d, e], vec![b, c, e, f], vec![c, a, f, d]] {
            *sides.entry(sorted(side)).or_default() += 1;
        }
    }
    assert!(sides.values().all(|n| *n <= 2));
    let once: BTreeSet<Vec<u32>> = sides.into_iter().filter(|x| x.1 == 1).map(|x| x.0).collect();
    let outer: Vec<Vec<u32>> = prisms.outer.iter().map(|o| sorted(prisms.corners(o).collect())).collect();
    assert_eq!(outer.len(), once.len());
    assert_eq!(outer.into_iter().collect::<BTreeSet<_>>(), once);
    let skin = boundary(prisms);
    let defects = skin.defects();
    assert!(defects.is_closed() && defects.is_manifold() && defects.is_oriented());
    assert!((skin.volume() - prisms.volume()).abs() < 1e-12);
    assert!((0..prisms.cells.len()).all(|j| prisms.volume_of(j) > 0.0));
}

/// Walls have the area of their length at the top times the height.
fn walls_are_named(prisms: &Prisms, height: f64) {
    let skin = boundary(prisms);
    for side in ["plate.xmin", "plate.xmax", "plate.ymin", "plate.ymax"] {
        assert!((area(&skin, side) - 2.0 * height).abs() < 1e-12, "{side}");
    }
    let round = 2.0 * PI * RADIUS * height;
    let bore = area(&skin, "bore");
    assert!(bore < round && bore > 0.98 * round, "{bore}");
}

#[test]
fn a_swept_face_has_the_volume_of_its_area_times_the_way() {
    let mesh = plate();
    let face = area(&mesh, TOP);
    // Chords leave a little of the bore.
    assert!(face > AREA && face < AREA + 0.02);
    let own = label(&mesh, TOP);
    let triangles = mesh.labels.iter().filter(|l| **l == own).count();
    // Away from the solid, into it, and slanted.
    for along in [DVec3::new(0.0, 0.0, 3.0), DVec3::new(0.0, 0.0, -3.0), DVec3::new(1.0, 2.0, 3.0)] {
        for layers in [1, 4] {
            let prisms = Prisms::swept(&mesh, TOP, along, layers).unwrap();
            sound(&prisms);
            assert_eq!(prisms.cells.len(), triangles * layers as usize);
            assert!((prisms.volume() - 3.0 * face).abs() < 1e-12);
            assert!((prisms.volume() - 3.0 * AREA).abs() < 3.0 * 0.02);
            assert_eq!(prisms.names[..2], [TOP, "opposite"]);
            assert_eq!(prisms.names.iter().collect::<BTreeSet<_>>().len(), 7);
            if along.x == 0.0 {
                walls_are_named(&prisms, 3.0);
            }
            let skin = boundary(&prisms);
            assert!((area(&skin, TOP) - face).abs() < 1e-12 && (area(&skin, "opposite") - face).abs() < 1e-12);
        }
    }
}

#[test]
fn prisms_between_two_faces_fill_the_solid() {
    let plate = plate();
    let mesh = walled(&plate, 1.0);
    let bits = |p: &DVec3| p.to_array().map(f64::to_bits);
    let places: BTreeSet<_> = mesh.nodes.iter().map(bits).collect();
    for (from, to) in [(BOTTOM, TOP), (TOP, BOTTOM)] {
        let prisms = Prisms::between(&mesh, from, to, 3).unwrap();
        sound(&prisms);
        assert!((prisms.volume() - area(&plate, TOP)).abs() < 1e-12);
        assert!((prisms.volume() - mesh.volume()).abs() < 1e-12);
        assert_eq!(prisms.names[..2], [from, to]);
        walls_are_named(&prisms, 1.0);
        // The ends are the surface's own nodes.
        let ends = prisms.outer.iter().filter(|o| o.side < 2).flat_map(|o| prisms.corners(o));
        assert!(ends.into_iter().all(|v| places.contains(&bits(&prisms.nodes[v as usize]))));
        assert_eq!(boundary(&prisms).bounds(), mesh.bounds());
    }
}

#[test]
fn faces_that_do_not_match_are_refused_by_place() {
    let mesh = walled(&plate(), 1.0);
    let told = |mesh: &TriMesh| {
        let error = Prisms::between(mesh, BOTTOM, TOP, 2).unwrap_err();
        assert_eq!(error.exit_code(), 3);
        error.to_string()
    };
    let top = |mesh: &TriMesh| mesh.labels.iter().position(|l| *l == label(mesh, TOP)).unwrap();
    let mut other = mesh.clone();
    let v = other.triangles[top(&mesh)][0] as usize;
    other.nodes[v].z += 1e-3;
    assert!(told(&other).contains("no node of \"plate.zmax\" is across"), "{}", told(&other));

    // The other diagonal of two triangles.
    other = mesh.clone();
    let [a, b, c] = mesh.triangles[top(&mesh)];
    let touches = |t: &usize| edges([a, b, c]).iter().any(|[p, q]| edges(mesh.triangles[*t]).contains(&[*q, *p]));
    let list = (0..mesh.triangles.len()).filter(|t| mesh.labels[*t] == label(&mesh, TOP));
    let second = list.into_iter().find(touches).unwrap();
    let [p, q] = edges([a, b, c]).into_iter().find(|[p, q]| edges(mesh.triangles[second]).contains(&[*q, *p])).unwrap();
    let apart = |t: [u32; 3]| t.into_iter().find(|v| *v != p && *v != q).unwrap();
    let (r, s) = (apart([a, b, c]), apart(mesh.triangles[second]));
    (other.triangles[top(&mesh)], other.triangles[second]) = ([p, s, r], [s, q, r]);
    assert!(told(&other).contains("no triangle of \"plate.zmax\" is across"), "{}", told(&other));

    // A top that is finer.
    other = mesh.clone();
    let center = other.centroid(top(&mesh));
    other.nodes.push(center);
    let new = other.nodes.len() as u32 - 1;
    other.triangles[top(&mesh)] = [a, b, new];
    other.triangles.extend([[b, c, new], [c, a, new]]);
    other.labels.extend([label(&mesh, TOP); 2]);
    assert!(told(&other).contains("faces do not match: \"plate.zmin\" has"), "{}", told(&other));
}

#[test]
fn walls_that_do_not_match_are_refused_by_place() {
    let mesh = walled(&plate(), 1.0);
    let told = |mesh: &TriMesh| Prisms::between(mesh, BOTTOM, TOP, 2).unwrap_err().to_string();
    let bore = label(&mesh, "bore");
    let at_xmax = mesh.labels.iter().position(|l| *l == label(&mesh, "plate.xmax")).unwrap();
    let mut other = mesh.clone();
    other.labels[at_xmax] = bore;
    let said = told(&other);
    assert!(said.starts_with("at (1.0") && said.contains("beside the bottom here"), "{said}");

    // A wall that goes on elsewhere.
    other = mesh.clone();
    let first = other.nodes.len() as u32;
    other.nodes.extend([DVec3::splat(7.0), DVec3::splat(8.0), DVec3::new(7.0, 8.0, 9.0)]);
    other.triangles.push([first, first + 1, first + 2]);
    other.labels.push(bore);
    assert!(told(&other).contains("open here, or go on"), "{}", told(&other));

    // A wall that is pulled out between its rims.
    other = mesh.clone();
    let [p, q, r] = mesh.triangles[at_xmax];
    other.nodes.push(mesh.centroid(at_xmax) + 2.0 * DVec3::X);
    let new = other.nodes.len() as u32 - 1;
    other.triangles[at_xmax] = [p, q, new];
    other.triangles.extend([[q, r, new], [r, p, new]]);
    other.labels.extend([mesh.labels[at_xmax]; 2]);
    assert!(told(&other).contains("not straight"), "{}", told(&other));
}

#[test]
fn what_cannot_be_swept_is_refused() {
    let mesh = walled(&plate(), 1.0);
    let code =
        |face: &str, along: DVec3, layers: u32| Prisms::swept(&mesh, face, along, layers).unwrap_err().exit_code();
    assert_eq!(code(TOP, DVec3::Z, 0), 2);
    assert_eq!(code(TOP, DVec3::ZERO, 1), 2);
    assert_eq!(code(TOP, DVec3::new(f64::NAN, 0.0, 1.0), 1), 2);
    assert_eq!(code("lid", DVec3::Z, 1), 2);
    assert_eq!(code(TOP, DVec3::Z, u32::MAX), 4);
    // Along itself a face sweeps nothing, and a bore sweeps to both sides.
    assert_eq!(code(TOP, DVec3::X, 1), 3);
    assert_eq!(code("bore", DVec3::X, 1), 3);
    assert_eq!(Prisms::between(&mesh, TOP, TOP, 1).unwrap_err().exit_code(), 2);
    let mut broken = mesh.clone();
    broken.triangles[0][0] = u32::MAX;
    assert_eq!(Prisms::swept(&broken, TOP, DVec3::Z, 1).unwrap_err().exit_code(), 3);
    // Three triangles at an edge are no sheet.
    broken = mesh.clone();
    let [a, b, _] = mesh.triangles[0];
    broken.nodes.push(DVec3::splat(5.0));
    broken.triangles.push([a, b, broken.nodes.len() as u32 - 1]);
    broken.labels.push(mesh.labels[0]);
    let said = Prisms::swept(&broken, TOP, DVec3::Z, 1).unwrap_err().to_string();
    assert!(said.contains("do not form a sheet"), "{said}");
}

#[test]
fn files_that_cannot_be_written_are_not_there() {
    let folder = tempfile::tempdir().unwrap();
    let prisms = Prisms::swept(&walled(&plate(), 1.0), TOP, DVec3::Z, 2).unwrap();
    let options = WriteOptions { encoding: Encoding::Text, ..WriteOptions::default() };
    let code = |name: &str, prisms: &Prisms| {
        let path = folder.path().join(name);
        let error = write_prisms(&path, prisms, &options, &Run::new()).unwrap_err();
        assert!(!path.exists(), "{name}");
        error.exit_code()
    };
    assert_eq!(code("a.stl", &prisms), 2);
    assert_eq!(code("a.msh", &Prisms::default()), 3);
    let broken = |change: fn(&mut Prisms)| {
        let mut other = prisms.clone();
        change(&mut other);
        other
    };
    assert_eq!(code("a.vtu", &broken(|p| p.cells[3][5] = u32::MAX)), 3);
    assert_eq!(code("a.vtu", &broken(|p| p.outer[3].side = 5)), 3);
    assert_eq!(code("a.vtu", &broken(|p| p.outer[3].label = 100)), 3);
    assert_eq!(code("a.vtu", &broken(|p| p.nodes[0].x = f64::INFINITY)), 3);
    // Sides are numbered as Abaqus and CalculiX do: the bottom S1, the top S2.
    let path = folder.path().join("a.inp");
    let written = write_prisms(&path, &prisms, &options, &Run::new()).unwrap();
    assert!(written.renamed.contains(&[TOP.to_string(), "plate_zmax".to_string()]));
    let text = fs::read_to_string(path).unwrap();
    let surface = |name: &str| {
        let begin = format!("*SURFACE, NAME={name}, TYPE=ELEMENT\n");
        text.split(&begin).nth(1).unwrap().split('*').next().unwrap().lines().map(str::to_owned).collect::<Vec<_>>()
    };
    let half = prisms.cells.len() / 2;
    assert_eq!(surface("plate_zmax"), (1..=half).map(|j| format!("{j}, S1")).collect::<Vec<_>>());
    assert_eq!(surface("opposite"), (half + 1..=2 * half).map(|j| format!("{j}, S2")).collect::<Vec<_>>());
    let cell = format!("\n1, {}\n", prisms.cells[0].map(|v| (v + 1).to_string()).join(", "));
    assert!(text.contains("*ELEMENT, TYPE=C3D6, ELSET=volume\n") && text.contains(&cell));
}
