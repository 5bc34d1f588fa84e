//! Volumes swept by a face of a finished mesh, as prisms and hexahedra: volumes, areas and names against closed forms, and what is refused.

use std::collections::{BTreeMap, BTreeSet};
use std::f64::consts::PI;
use std::fs;

use approx::{abs_diff_eq, assert_abs_diff_eq};
use rvachev::implicit::part::parse;
use rvachev::io::{Encoding, WriteOptions, write_prisms};
use rvachev::mesh::{Hexahedra, OuterSide, Prisms, TriMesh};
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
    assert_abs_diff_eq!(skin.volume(), prisms.volume(), epsilon = 1e-12);
    assert!((0..prisms.cells.len()).all(|j| prisms.volume_of(j) > 0.0));
}

/// Walls have the area of their length at the top times the height.
fn walls_are_named(prisms: &Prisms, height: f64) {
    let skin = boundary(prisms);
    for side in ["plate.xmin", "plate.xmax", "plate.ymin", "plate.ymax"] {
        assert!(abs_diff_eq!(area(&skin, side), 2.0 * height, epsilon = 1e-12), "{side}");
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
            assert_abs_diff_eq!(prisms.volume(), 3.0 * face, epsilon = 1e-12);
            assert_abs_diff_eq!(prisms.volume(), 3.0 * AREA, epsilon = 3.0 * 0.02);
            assert_eq!(prisms.names[..2], [TOP, "opposite"]);
            assert_eq!(prisms.names.iter().collect::<BTreeSet<_>>().len(), 7);
            if along.x == 0.0 {
                walls_are_named(&prisms, 3.0);
            }
            let skin = boundary(&prisms);
            assert_abs_diff_eq!(area(&skin, TOP), face, epsilon = 1e-12);
            assert_abs_diff_eq!(area(&skin, "opposite"), face, epsilon = 1e-12);
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
        assert_abs_diff_eq!(prisms.volume(), area(&plate, TOP), epsilon = 1e-12);
        assert_abs_diff_eq!(prisms.volume(), mesh.volume(), epsilon = 1e-12);
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

/// The determinant of the map from the unit cube to a hexahedron, linear along each of the cube's edges, at a place in the cube.
fn jacobian(p: &[DVec3; 8], at: [f64; 3]) -> f64 {
    let mut columns = [DVec3::ZERO; 3];
    for (k, corner) in p.iter().enumerate() {
        let ends = [[0, 1, 1, 0][k % 4], [0, 0, 1, 1][k % 4], k / 4];
        let share = |d: usize| if ends[d] == 1 { at[d] } else { 1.0 - at[d] };
        for (d, column) in columns.iter_mut().enumerate() {
            let slope = if ends[d] == 1 { 1.0 } else { -1.0 };
            *column += *corner * slope * share((d + 1) % 3) * share((d + 2) % 3);
        }
    }
    columns[0].cross(columns[1]).dot(columns[2])
}

/// The integral of the determinant over the cube, in which it has degree two along each edge: two places of Gauss are exact. It must be
/// positive at the corners and at the places.
fn hexahedron(mesh: &Hexahedra, cell: &[u32; 8]) -> f64 {
    let p = cell.map(|v| mesh.nodes[v as usize]);
    let eight =
        |low: f64| (0..8).map(move |k| [k & 1, k >> 1 & 1, k >> 2].map(|x| if x == 0 { low } else { 1.0 - low }));
    let at = |low: f64| eight(low).map(|at| jacobian(&p, at)).collect::<Vec<_>>();
    let [corners, inside] = [0.0, 0.5 - 0.5 / 3f64.sqrt()].map(at);
    assert!(corners.iter().chain(&inside).all(|x| *x > 0.0), "{corners:?} {inside:?}");
    inside.iter().sum::<f64>() / 8.0
}

/// Cells have positive volumes with this sum. Every side has two cells with the same corners there, or is on the boundary once. No side
/// of four corners lies on triangles. The boundary is closed, looks outward and holds the volume. Returns it cut into triangles.
fn sound_hexahedra(mesh: &Hexahedra, volume: f64) -> TriMesh {
    let prisms = Prisms { nodes: mesh.nodes.clone(), cells: mesh.prisms.clone(), ..Prisms::default() };
    let mut all: Vec<f64> = mesh.hexahedra.iter().map(|c| hexahedron(mesh, c)).collect();
    all.extend((0..mesh.prisms.len()).map(|j| prisms.volume_of(j)));
    assert!(all.iter().all(|v| *v > 0.0));
    let sum: f64 = all.iter().sum();
    assert_abs_diff_eq!(sum, volume, epsilon = 1e-12 * volume.max(1.0));

    let sorted = |mut side: Vec<u32>| {
        side.sort_unstable();
        side
    };
    let mut sides: BTreeMap<Vec<u32>, usize> = BTreeMap::new();
    let cells = mesh.hexahedra.len();
    for cell in 0..all.len() as u32 {
        for side in 0..if (cell as usize) < cells { 6 } else { 5 } {
            *sides.entry(sorted(mesh.corners(&OuterSide { cell, side, label: 0 }).collect())).or_default() += 1;
        }
    }
    assert!(sides.values().all(|n| *n <= 2));
    for side in sides.keys().filter(|s| s.len() == 4) {
        assert!((0..4).all(|left| {
            let three: Vec<u32> = (0..4).filter(|k| *k != left).map(|k| side[k]).collect();
            !sides.contains_key(&three)
        }));
    }
    let once: BTreeSet<Vec<u32>> = sides.into_iter().filter(|x| x.1 == 1).map(|x| x.0).collect();
    let outer: Vec<Vec<u32>> = mesh.outer.iter().map(|o| sorted(mesh.corners(o).collect())).collect();
    assert_eq!(outer.len(), once.len());
    assert_eq!(outer.into_iter().collect::<BTreeSet<_>>(), once);

    let mut skin = TriMesh { nodes: mesh.nodes.clone(), faces: mesh.names.clone(), ..TriMesh::default() };
    for o in &mesh.outer {
        let corners: Vec<u32> = mesh.corners(o).collect();
        for k in 2..corners.len() {
            skin.triangles.push([corners[0], corners[k - 1], corners[k]]);
            skin.labels.push(o.label);
        }
    }
    skin.drop_unused_nodes();
    let defects = skin.defects();
    assert!(defects.is_closed() && defects.is_manifold() && defects.is_oriented());
    assert_abs_diff_eq!(skin.volume(), volume, epsilon = 1e-12 * volume.max(1.0));
    skin
}

/// Unit squares, `n` by `n`, cut in two along one diagonal or the other, and bent.
fn squares(n: usize, bend: f64) -> TriMesh {
    let mut face = TriMesh::new(Vec::new(), Vec::new());
    let node = |k: usize| [k % (n + 1), k / (n + 1)].map(|x| x as f64);
    face.nodes =
        (0..(n + 1) * (n + 1)).map(node).map(|[x, y]| DVec3::new(x, y, bend * (x * x - 0.5 * x * y))).collect();
    for k in 0..n * n {
        let [a, b, c, d] = [0, 1, n + 2, n + 1].map(|s| (k / n * (n + 1) + k % n + s) as u32);
        let two = if k % 3 == 0 { [[a, b, c], [a, c, d]] } else { [[b, c, d], [b, d, a]] };
        face.triangles.extend(two);
        face.labels.extend([0, 0]);
    }
    face
}

/// Two triangles with a common edge of length 1 along y, each with its third corner beside the edge's middle.
fn two_triangles(third: [DVec3; 2]) -> TriMesh {
    TriMesh::new(vec![DVec3::ZERO, DVec3::Y, third[0], third[1]], vec![[1, 0, 2], [0, 1, 3]])
}

#[test]
fn squares_cut_in_two_become_cubes_again() {
    let n = 6;
    // Away from the face and into the room behind it, straight and slanted; what is bent and shifted along z holds as much as if flat.
    for (bend, along) in [
        (0.0, DVec3::new(0.0, 0.0, 3.0)),
        (0.0, DVec3::new(0.0, 0.0, -3.0)),
        (0.0, DVec3::new(1.0, 2.0, 3.0)),
        (0.02, DVec3::new(0.0, 0.0, 3.0)),
        (0.02, DVec3::new(0.0, 0.0, -3.0)),
    ] {
        let prisms = Prisms::swept(&squares(n, bend), "surface", along, 2).unwrap();
        let mesh = prisms.hexahedra(45.0).unwrap();
        assert_eq!((mesh.hexahedra.len(), mesh.prisms.len()), (2 * n * n, 0));
        assert!(mesh.hexahedra.iter().all(|c| (hexahedron(&mesh, c) - 1.5).abs() < 1e-12));
        let skin = sound_hexahedra(&mesh, 3.0 * (n * n) as f64);
        assert_eq!(mesh.names, ["surface", "opposite", "side"]);
        if bend == 0.0 {
            assert!(["surface", "opposite"].iter().all(|end| (area(&skin, end) - (n * n) as f64).abs() < 1e-12));
        }
        // Nothing is as near to a right angle as less than nothing.
        let none = prisms.hexahedra(-1.0).unwrap();
        assert_eq!((none.hexahedra.len(), &none.prisms, &none.outer), (0, &prisms.cells, &prisms.outer));
        assert_eq!(prisms.hexahedra(f64::NAN).unwrap(), none);
    }
}

#[test]
fn pairs_of_prisms_become_hexahedra_and_what_is_left_stays() {
    let plate = plate();
    let face = area(&plate, TOP);
    for layers in [1, 4] {
        let prisms = Prisms::swept(&plate, TOP, DVec3::new(0.0, 0.0, -3.0), layers).unwrap();
        let mesh = prisms.hexahedra(45.0).unwrap();
        assert_eq!(2 * mesh.hexahedra.len() + mesh.prisms.len(), prisms.cells.len());
        assert!(mesh.hexahedra.len() > 2 * mesh.prisms.len(), "{} {}", mesh.hexahedra.len(), mesh.prisms.len());
        let skin = sound_hexahedra(&mesh, 3.0 * face);
        for side in ["plate.xmin", "plate.xmax", "plate.ymin", "plate.ymax"] {
            assert!(abs_diff_eq!(area(&skin, side), 2.0 * 3.0, epsilon = 1e-12), "{side}");
        }
        assert!([TOP, "opposite"].iter().all(|end| (area(&skin, end) - face).abs() < 1e-12));
        let walls = boundary(&prisms);
        assert_abs_diff_eq!(area(&skin, "bore"), area(&walls, "bore"), epsilon = 1e-12);
        // As many degrees as asked for, and not more.
        for cell in &mesh.hexahedra {
            let p = [0, 1, 2, 3].map(|k| mesh.nodes[cell[k] as usize]);
            let angle = |k: usize| (p[(k + 1) % 4] - p[k]).angle_between(p[(k + 3) % 4] - p[k]).to_degrees();
            assert!((0..4).all(|k| (angle(k) - 90.0).abs() <= 45.0 + 1e-9));
        }
    }
    // Between two faces that are there already.
    let walled = walled(&plate, 1.0);
    let prisms = Prisms::between(&walled, BOTTOM, TOP, 2).unwrap();
    let mesh = prisms.hexahedra(45.0).unwrap();
    assert!(mesh.hexahedra.len() > 2 * mesh.prisms.len());
    let skin = sound_hexahedra(&mesh, face);
    assert!([TOP, BOTTOM].iter().all(|end| (area(&skin, end) - face).abs() < 1e-12));
}

#[test]
fn only_good_quadrilaterals_become_hexahedra() {
    let count = |face: &TriMesh, along: DVec3, off: f64| {
        Prisms::swept(face, "surface", along, 1).unwrap().hexahedra(off).unwrap().hexahedra.len()
    };
    // Equilateral triangles have angles of 60 and 120 degrees together.
    let height = 0.75f64.sqrt();
    let even = two_triangles([-height, height].map(|x| DVec3::new(x, 0.5, 0.0)));
    assert_eq!([29.999, 30.001].map(|off| count(&even, DVec3::Z, off)), [0, 1]);
    // An angle of 180 degrees and one of more, whatever may be.
    for y in [1.0, 1.5] {
        let flat = two_triangles([DVec3::new(-1.0, 1.0, 0.0), DVec3::new(1.0, y, 0.0)]);
        assert_eq!(count(&flat, DVec3::Z, 1000.0), 0);
    }
    // Folded by a right angle.
    let folded = two_triangles([DVec3::new(0.0, 0.5, 1.0), DVec3::new(1.0, 0.5, 0.0)]);
    assert_eq!([45.0, 89.9, 90.1].map(|off| count(&folded, DVec3::new(1.0, 0.0, 1.0), off)), [0, 0, 1]);
    // The middle two of a row of four make a square, but then the outer two have no partners.
    let places = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0], [-1.0, 0.0], [2.0, 1.0]];
    let nodes = places.map(|[x, y]| DVec3::new(x, y, 0.0)).to_vec();
    let row = TriMesh::new(nodes, vec![[0, 1, 2], [0, 2, 3], [0, 3, 4], [1, 5, 2]]);
    assert_eq!([10.0, 60.0].map(|off| count(&row, DVec3::Z, off)), [1, 2]);
    for off in [10.0, 60.0] {
        sound_hexahedra(&Prisms::swept(&row, "surface", DVec3::Z, 3).unwrap().hexahedra(off).unwrap(), 2.0);
    }
    // Two names at the bottom or at the top keep two sides there.
    let prisms = Prisms::swept(&squares(1, 0.0), "surface", DVec3::Z, 2).unwrap();
    assert_eq!(prisms.hexahedra(1.0).unwrap().hexahedra.len(), 2);
    for outer in [0, 2] {
        let mut named = prisms.clone();
        named.outer[outer].label = 2;
        assert_eq!(named.hexahedra(1.0).unwrap().outer, named.outer);
    }
}

#[test]
fn prisms_that_are_not_in_layers_make_no_hexahedra() {
    let prisms = Prisms::swept(&squares(2, 0.0), "surface", DVec3::Z, 3).unwrap();
    let changes: [fn(&mut Prisms); 9] = [
        |p| p.cells.clear(),
        |p| p.cells.truncate(p.cells.len() - 1),
        |p| p.cells.swap(3, 20),
        |p| p.cells[3][5] = u32::MAX,
        |p| p.outer.clear(),
        |p| p.outer[0].cell = 23,
        |p| p.outer[1].cell = 0,
        |p| p.outer.last_mut().unwrap().side = 5,
        |p| p.outer.last_mut().unwrap().label = 3,
    ];
    for (k, change) in changes.iter().enumerate() {
        let mut broken = prisms.clone();
        change(&mut broken);
        assert_eq!(broken.hexahedra(45.0).unwrap_err().exit_code(), 3, "{k}");
    }
    let broken = Prisms { cells: vec![[0; 6]; 3], ..Prisms::default() };
    assert_eq!(broken.hexahedra(45.0).unwrap_err().exit_code(), 3);
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
