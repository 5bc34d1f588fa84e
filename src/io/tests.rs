//! Round trips, foreign spellings and damage of every format.

mod solvers;

use approx::assert_abs_diff_eq;
use glam::DVec3;
use proptest::prelude::*;

use super::*;
use crate::mesh::Group;
use crate::run::CancelToken;

/// A unit cube with six faces, coordinates no short decimal holds, awkward names and groups.
fn cube() -> TriMesh {
    let p = |i: u32| {
        let bit = |b: u32| if i >> b & 1 == 1 { 1.0 / 3.0 } else { -std::f64::consts::PI };
        DVec3::new(bit(0), bit(1) * 1e-7, bit(2) * 1e9)
    };
    let quads = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    let mut mesh = TriMesh { nodes: (0..8).map(p).collect(), ..Default::default() };
    for (face, [a, b, c, d]) in quads.into_iter().enumerate() {
        mesh.triangles.extend([[a, b, c], [a, c, d]]);
        mesh.labels.extend([face as u32; 2]);
    }
    mesh.faces = ["bore 1", "  äußere Fläche\n", "", "50%25 \"x\"", "a#b", "endsolid"].map(String::from).to_vec();
    mesh.groups = vec![
        Group { name: "clamped".into(), faces: vec![0, 2] },
        Group { name: "nothing".into(), faces: vec![] },
        Group { name: "a \"quoted\" one".into(), faces: vec![0, 5] },
    ];
    mesh
}

fn encoded(encoding: Encoding) -> WriteOptions {
    WriteOptions { encoding, ..WriteOptions::default() }
}

fn bytes_of(mesh: &TriMesh, format: Format, encoding: Encoding) -> Vec<u8> {
    let mut bytes = Vec::new();
    encode(&mut bytes, mesh, format, &encoded(encoding), &Run::new()).unwrap();
    bytes
}

fn again(mesh: &TriMesh, format: Format, encoding: Encoding) -> TriMesh {
    read_bytes(&bytes_of(mesh, format, encoding), format, Path::new("x")).unwrap()
}

fn refusal(bytes: &[u8], format: Format) -> String {
    let error = read_bytes(bytes, format, Path::new("x")).unwrap_err();
    assert!(matches!(error, Error::Input { .. }), "{error:?}");
    assert_eq!(error.exit_code(), 3);
    error.to_string()
}

const READABLE: [(Format, Encoding); 17] = [
    (Format::ThreeMf, Encoding::Usual),
    (Format::StlBinary, Encoding::Usual),
    (Format::StlAscii, Encoding::Usual),
    (Format::Obj, Encoding::Usual),
    (Format::Ply, Encoding::Binary),
    (Format::Ply, Encoding::Text),
    (Format::Off, Encoding::Usual),
    (Format::Msh, Encoding::Text),
    (Format::Msh, Encoding::Binary),
    (Format::Medit, Encoding::Usual),
    (Format::Inp, Encoding::Usual),
    (Format::Bdf, Encoding::Usual),
    (Format::Su2, Encoding::Usual),
    (Format::Vtp, Encoding::Text),
    (Format::Vtp, Encoding::Binary),
    (Format::Vtu, Encoding::Text),
    (Format::Vtu, Encoding::Binary),
];

#[test]
fn msh_and_ply_keep_everything() {
    let mut mesh = cube();
    // Triangles out of the order of their faces, a node of no triangle and a face without triangles must stay as well.
    mesh.triangles.swap(0, 7);
    mesh.labels.swap(0, 7);
    mesh.nodes.insert(3, DVec3::new(-0.0, 5e-324, f64::MAX));
    mesh.triangles.iter_mut().flatten().for_each(|v| *v += u32::from(*v >= 3));
    mesh.faces.push("empty face".into());
    for format in [Format::Msh, Format::Ply] {
        for encoding in [Encoding::Text, Encoding::Binary] {
            let read = again(&mesh, format, encoding);
            assert_eq!(read, mesh, "{format:?} {encoding:?}");
            assert!(read.nodes[3].x.is_sign_negative());
        }
    }
}

#[test]
fn obj_keeps_nodes_faces_and_labels() {
    let mesh = cube();
    let read = again(&mesh, Format::Obj, Encoding::Usual);
    assert_eq!(read, TriMesh { groups: vec![], ..mesh });
}

#[test]
fn threemf_keeps_nodes_faces_and_labels() {
    let mesh = cube();
    let read = again(&mesh, Format::ThreeMf, Encoding::Usual);
    assert_eq!(read, TriMesh { groups: vec![], ..mesh });
}

#[test]
fn ascii_stl_keeps_faces_and_places() {
    let mesh = cube();
    let read = again(&mesh, Format::StlAscii, Encoding::Usual);
    assert_eq!((&read.faces, &read.labels, read.nodes.len()), (&mesh.faces, &mesh.labels, 8));
    for t in 0..12 {
        assert_eq!(read.corners(t), mesh.corners(t));
    }
}

#[test]
fn binary_stl_rounds_to_the_nearest_f32() {
    let mesh = cube();
    let read = again(&mesh, Format::StlBinary, Encoding::Usual);
    assert_eq!(read.nodes.len(), 8);
    for t in 0..12 {
        assert_eq!(read.corners(t), mesh.corners(t).map(|p| p.as_vec3().as_dvec3()));
    }
    let mut huge = cube();
    huge.nodes[2].x = 1e39;
    let error = encode(&mut Vec::new(), &huge, Format::StlBinary, &WriteOptions::default(), &Run::new()).unwrap_err();
    assert!(error.to_string().contains("node 2"), "{error}");
}

#[test]
fn off_keeps_nodes_and_triangles() {
    let mesh = cube();
    let read = again(&mesh, Format::Off, Encoding::Usual);
    assert_eq!((read.nodes, read.triangles), (mesh.nodes, mesh.triangles));
}

#[test]
fn every_truncation_is_refused_or_whole() {
    let mesh = cube();
    for (format, encoding) in READABLE {
        let bytes = bytes_of(&mesh, format, encoding);
        for n in 0..bytes.len() {
            match read_bytes(&bytes[..n], format, Path::new("x")) {
                // A prefix of OBJ or INP, or some solids of an ASCII STL, are files of their own. Elsewhere only the very end may
                // go: a blank, or digits of the last number.
                Ok(short) => match format {
                    Format::Obj | Format::Inp => {}
                    Format::StlAscii => assert_eq!(short.triangles.len() % 2, 0, "cut at {n}"),
                    _ => assert!(
                        short.triangles.len() == 12 && n + 6 > bytes.len(),
                        "{format:?} {encoding:?} cut at {n}"
                    ),
                },
                Err(error) => assert!(matches!(error, Error::Input { .. }), "{format:?} cut at {n}: {error:?}"),
            }
        }
    }
}

#[test]
fn stl_spellings() {
    let tetra = |separator: &str, upper: bool| {
        let corners = ["0 0 0", "1.0E+00 0 0", "\t0 +1e0 0", "0 0 1."];
        let mut text = String::from("\t solid two words\n");
        for f in [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]] {
            text += "facet normal nan 0 0 \n\touter loop\n";
            f.iter().for_each(|v: &usize| text += &format!("  vertex  {}\n", corners[*v]));
            text += "endloop foo\n\n endfacet bar\n";
        }
        text += "endsolid blah\n";
        let text = if upper { text.to_uppercase() } else { text };
        text.replace('\n', separator)
    };
    for separator in ["\n", "\r\n", "\r"] {
        for upper in [false, true] {
            for hint in [Format::StlBinary, Format::StlAscii] {
                let mesh = read_bytes(tetra(separator, upper).as_bytes(), hint, Path::new("x")).unwrap();
                assert_eq!((mesh.nodes.len(), mesh.triangles.len()), (4, 4));
                assert_abs_diff_eq!(mesh.volume(), 1.0 / 6.0, epsilon = 1e-15);
                assert_eq!(mesh.faces[0].to_lowercase(), "two words");
            }
        }
    }
    let mut misleading = bytes_of(&cube(), Format::StlBinary, Encoding::Usual);
    misleading[..6].copy_from_slice(b"solid ");
    assert_eq!(read_bytes(&misleading, Format::StlAscii, Path::new("x")).unwrap().triangles.len(), 12);
    let two = format!("{}{}", tetra("\n", false), tetra("\n", true));
    let mesh = read_bytes(two.as_bytes(), Format::StlBinary, Path::new("x")).unwrap();
    assert_eq!((mesh.faces.len(), mesh.labels), (2, vec![0, 0, 0, 0, 1, 1, 1, 1]));
}

#[test]
fn damage_is_named_with_its_place() {
    let mut stl = bytes_of(&cube(), Format::StlBinary, Encoding::Usual);
    assert!(refusal(&stl[..stl.len() - 1], Format::StlBinary).contains("within triangle 12"));
    stl[80..84].copy_from_slice(&u32::MAX.to_le_bytes());
    assert!(refusal(&stl, Format::StlBinary).contains("promises 4294967295"));
    stl[80..84].copy_from_slice(&12u32.to_le_bytes());
    stl[96..100].copy_from_slice(&f32::NAN.to_le_bytes());
    assert!(refusal(&stl, Format::StlBinary).contains("byte 96: corner 1 of triangle 1"));

    let cases: &[(Format, &str, &str)] = &[
        (Format::StlAscii, "solid a\nfacet\nouter loop\nvertex 0 0 nan\n", "line 4: z coordinate is NaN"),
        (
            Format::StlAscii,
            "solid a\nfacet\nvertex 0 0 0\nendfacet\n",
            "line 4: the facet that ends here has 1 corners",
        ),
        (Format::StlAscii, "solid a\nendsolid a\n", "no triangle"),
        (Format::StlAscii, "", "empty"),
        (Format::StlBinary, "what is this", "line 1: `what is this`"),
        (Format::Obj, "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n", "line 4: the face uses node 4, but the file has 3"),
        (Format::Obj, "v 0 0 0\nf 1 1 0\n", "line 2: node indices begin at 1"),
        (Format::Obj, "v 0 0 0\nf -1 -1 -2\n", "line 2: index -2 reaches back"),
        (Format::Obj, "v 0 0 0\nf 1 1\n", "line 2: the face has 2 corners"),
        (Format::Obj, "v 0 inf 0\n", "line 1: y coordinate is inf"),
        (Format::Obj, "v 0 zero 0\n", "line 1: y coordinate is `zero`"),
        (Format::Obj, "v 0 0 0\n", "no triangle"),
        (Format::Off, "OFF\n3 1 0\n0 0 0\n1 0 0\n0 NaN 0\n3 0 1 2\n", "line 5: y coordinate is NaN"),
        (Format::Off, "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 3\n", "line 6: face 0 uses node 3"),
        (Format::Off, "OFF\n4000000000 9000000000 0\n0 0 0\n", "line 3: the file ends here, where node 1"),
        (Format::Off, "4OFF\n", "line 1: `4OFF`"),
        (Format::Off, "garbage", "line 1: an OFF file begins"),
        (Format::Ply, "ply\nformat ascii 1.0\nelement vertex 4000000000\nproperty float x\n", "`end_header`"),
        (Format::Ply, "plyx\n", "line 1: a PLY file"),
        (Format::Msh, "$MeshFormat\n3.0 0 8\n", "line 2: gmsh version 3.0"),
        (Format::Msh, "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Nodes\n1 1 1 1\n2 1 0 1\n1\n0 0 nan\n", "line 8: node 1"),
        (Format::Msh, "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Nodes\n1 9 1 9\n2 1 0 999999999999\n1\n", "line 6: 9999"),
    ];
    for (format, text, wanted) in cases {
        let message = refusal(text.as_bytes(), *format);
        assert!(message.contains(wanted), "{format:?}: {message:?} instead of {wanted:?}");
    }
}

#[test]
fn foreign_spellings() {
    let area = |text: &str, format| read_bytes(text.as_bytes(), format, Path::new("x")).unwrap().area();
    // A polygon before some of its nodes, a wild texture index, a continued line, colors and weights behind coordinates.
    let obj = "mtllib a.mtl\nv 0 0 0 1 0 0\nv 1 0 0 0.5\nvt 0 0\nvn 0 0 1\nusemtl red\n\
               f 1/999999999999/1 -1//1 \\\n 3 4/1/1 # square\nl 1 2\nv 1 1 0\nv 0 1 0\n";
    assert_eq!(area(obj, Format::Obj), 1.0);
    let square = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\no part\ng left side\nf 1/9/9 2/9 3//9\ng right\nf -4 -2 -1\n";
    let mesh = read_bytes(square.as_bytes(), Format::Obj, Path::new("x")).unwrap();
    assert_eq!((mesh.nodes.len(), mesh.area(), mesh.faces), (4, 1.0, vec!["left side".into(), "right".into()]));
    assert_eq!(
        area(
            "# hi\nCOFF 4 1 0 # counts\n0 0 0 9 9 9 9\n\n1 0 0 1 1 1 1\n1 1 0\n0 1 0\n4 0 1 2 3 255 0 0\n",
            Format::Off
        ),
        1.0
    );
    let ply = "ply\r\nformat ascii 1.0\r\ncomment x\r\nelement vertex 4\r\nproperty float x\r\nproperty float y\r\n\
        property double z\r\nproperty uchar red\r\nelement face 1\r\nproperty list uchar int vertex_index\r\n\
        end_header\r\n0 0 0 1 1 0 0 1 1 1 0 1 0 1 0 1 4 0 1 2 3\r\n";
    assert_eq!(area(ply, Format::Ply), 1.0);
    let old = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n1\n2 7 \"top\"\n$EndPhysicalNames\n$Nodes\n4\n\
        10 0 0 0\n20 1 0 0\n30 1 1 0\n40 0 1 0\n$EndNodes\n$Elements\n3\n1 15 2 0 1 10\n2 2 2 7 1 10 20 30\n\
        3 2 2 0 2 10 30 40\n$EndElements\n";
    let mesh = read_bytes(old.as_bytes(), Format::Msh, Path::new("x")).unwrap();
    assert_eq!((mesh.area(), &mesh.labels[..]), (1.0, &[0, 1][..]));
    assert_eq!(mesh.faces, ["top", "surface 2"].map(String::from));
    // The first triangle again, as a member of a second physical surface.
    let again = old.replace("$Elements\n3\n", "$Elements\n4\n").replace("$EndE", "9 2 2 8 1 10 20 30\n$EndE");
    let mesh = read_bytes(again.as_bytes(), Format::Msh, Path::new("x")).unwrap();
    assert_eq!((mesh.area(), mesh.triangles.len(), &mesh.faces[0][..]), (1.0, 2, "top"));
    assert_eq!(mesh.groups, [Group { name: "physical 8".into(), faces: vec![0] }]);
}

#[test]
fn big_endian_ply() {
    let mut bytes = b"ply\nformat binary_big_endian 1.0\nelement vertex 3\nproperty float x\nproperty short y\n\
        property double z\nelement face 1\nproperty list ushort uint vertex_indices\nend_header\n"
        .to_vec();
    for [x, y, z] in [[0.0, 0.0, 0.5], [2.0, 0.0, 0.5], [0.0, 3.0, 0.5]] {
        bytes.extend((x as f32).to_be_bytes());
        bytes.extend((y as i16).to_be_bytes());
        bytes.extend(f64::to_be_bytes(z));
    }
    bytes.extend(3u16.to_be_bytes());
    (0..3u32).for_each(|v| bytes.extend(v.to_be_bytes()));
    let mesh = read_bytes(&bytes, Format::Ply, Path::new("x")).unwrap();
    assert_eq!((mesh.area(), mesh.nodes[1]), (3.0, DVec3::new(2.0, 0.0, 0.5)));
}

#[test]
fn formats_by_extension() {
    for (extension, format) in Format::EXTENSIONS {
        assert_eq!(Format::from_path(Path::new(&format!("a.b.{}", extension.to_uppercase()))).unwrap(), format);
    }
    for bad in ["a", "a.step", ".stl", "stl"] {
        let message = Format::from_path(Path::new(bad)).unwrap_err().to_string();
        assert!(
            message.contains(
                ".stl, .stla, .ast, .obj, .ply, .off, .vtu, .msh, .geo, .inp, .bdf, .nas, .med, .mesh, .su2, .emesh, .vtp, .svg, .3mf, .glb, .xdmf"
            ),
            "{message}"
        );
    }
}

#[test]
fn files_appear_whole_or_not_at_all() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("cube.msh");
    let files = || std::fs::read_dir(folder.path()).unwrap().count();
    let token = CancelToken::new();
    token.cancel();
    let cancelled = write(&path, &cube(), &WriteOptions::default(), &Run::new().with_cancel(token)).unwrap_err();
    assert!(matches!(cancelled, Error::Cancelled) && files() == 0);
    let failed = write_atomic(&path, |out| {
        out.write_all(b"half").unwrap();
        Err(Error::Failed("no".into()))
    });
    assert!(failed.is_err() && files() == 0);
    write(&path, &cube(), &WriteOptions::default(), &Run::new()).unwrap();
    assert_eq!((read(&path, &Run::new()).unwrap(), files()), (cube(), 1));
    assert!(write(&path, &TriMesh::default(), &WriteOptions::default(), &Run::new()).is_err());
    assert_eq!(read(&path, &Run::new()).unwrap(), cube());

    let missing = folder.path().join("nowhere").join("a.stl");
    for message in [check_writable(&missing), write(&missing, &cube(), &WriteOptions::default(), &Run::new()).map(drop)]
        .map(|r| r.unwrap_err().to_string())
    {
        assert!(message.contains("nowhere does not exist"), "{message}");
    }
    check_writable(&path).unwrap();
    assert!(matches!(read(&missing, &Run::new()), Err(Error::Io { action: "read", .. })));
}

#[test]
fn meshes_no_reader_takes_are_not_written() {
    type Break = fn(&mut TriMesh);
    let breaks: [(Break, &str); 5] = [
        (|m| m.nodes[5].y = f64::NAN, "node 5"),
        (|m| m.triangles[3][1] = 8, "triangle 3"),
        (|m| m.labels[2] = 6, "triangle 2"),
        (|m| m.labels.truncate(3), "3 labels for 12"),
        (|m| m.groups[0].faces.push(6), "clamped"),
    ];
    for (damage, wanted) in breaks {
        let mut mesh = cube();
        damage(&mut mesh);
        let error = encode(&mut Vec::new(), &mesh, Format::Obj, &WriteOptions::default(), &Run::new()).unwrap_err();
        assert!(error.to_string().contains(wanted), "{error}");
    }
}

#[test]
fn vtu_text_holds_the_arrays() {
    let text = String::from_utf8(bytes_of(&cube(), Format::Vtu, Encoding::Text)).unwrap();
    assert!(text.contains("NumberOfPoints=\"8\" NumberOfCells=\"12\""));
    assert!(text.contains("Name=\"face\" format=\"ascii\">\n0 0 1 1 2 2 3 3 4 4 5 5\n"));
    assert!(text.contains("Name=\"group clamped\" format=\"ascii\">\n1 1 0 0 1 1 0 0 0 0 0 0\n"));
    let binary = String::from_utf8(bytes_of(&cube(), Format::Vtu, Encoding::Binary)).unwrap();
    // Twelve bytes of value 5 after their count.
    assert!(binary.contains("DAAAAAAAAAAFBQUFBQUFBQUFBQU="), "{binary}");
}

#[test]
fn xdmf_holds_names_faces_and_groups() {
    let mut mesh = cube();
    mesh.faces[4] = "]]>&".into();
    let text = String::from_utf8(bytes_of(&mesh, Format::Xdmf, Encoding::Usual)).unwrap();
    let names = "<map key=\"bore 1\" dim=\"2\">0</map>";
    assert!(text.contains(names) && text.contains("key=\"]]&gt;&amp;\"") && text.matches("]]>").count() == 1, "{text}");
    assert!(text.contains("TopologyType=\"Triangle\" NumberOfElements=\"12\""));
    let column = |numbers: &str| format!("Dimensions=\"12\" Format=\"XML\">\n{}\n</", numbers.replace(' ', "\n"));
    assert!(text.contains(&column("0 0 1 1 2 2 3 3 4 4 5 5")), "{text}");
    let group = "<Attribute Name=\"group clamped\" AttributeType=\"Scalar\" Center=\"Cell\">";
    let behind = text.split_once(group).unwrap().1;
    assert!(behind.split_once("</Attribute>").unwrap().0.contains(&column("1 1 0 0 1 1 0 0 0 0 0 0")), "{text}");
    assert!(text.contains("<Attribute Name=\"group a %22quoted%22 one\""), "{text}");
}

/// What must hold for all files of a folder, whoever wrote them.
#[test]
#[ignore = "reads the folder RVACHEV_FOREIGN_MESHES names"]
fn a_folder_of_foreign_files_is_read_or_refused() {
    let folder = std::env::var_os("RVACHEV_FOREIGN_MESHES").expect("RVACHEV_FOREIGN_MESHES names a folder");
    let mut paths: Vec<_> = std::fs::read_dir(folder).unwrap().map(|f| f.unwrap().path()).collect();
    paths.sort();
    for path in paths {
        match read(&path, &Run::new()) {
            Ok(mesh) => {
                build::check_mesh(&mesh).unwrap();
                println!("{}\t{}\t{}", path.file_name().unwrap().display(), mesh.triangles.len(), mesh.nodes.len());
            }
            Err(error) => {
                assert!(matches!(error, Error::Input { .. }), "{error:?}");
                println!("{error}");
            }
        }
    }
}

proptest! {
    #[test]
    fn names_survive(name in ".{0,12}") {
        let escaped = text::escape(&name);
        prop_assert!(!escaped.chars().any(|c| c.is_control() || c == '"'));
        prop_assert!(escaped.trim() == escaped && !escaped.is_empty());
        prop_assert_eq!(text::unescape(&escaped), name);
    }

    #[test]
    fn random_bytes_never_panic(bytes in prop::collection::vec(any::<u8>(), 0..300), pick in 0usize..READABLE.len()) {
        let _ = read_bytes(&bytes, READABLE[pick].0, Path::new("x"));
    }

    #[test]
    fn mutated_files_never_panic(
        pick in 0usize..READABLE.len(),
        edits in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>(), 0u8..4), 1..6),
    ) {
        let (format, encoding) = READABLE[pick];
        let mut bytes = bytes_of(&cube(), format, encoding);
        for (place, value, what) in edits {
            let i = place.index(bytes.len());
            match what {
                0 => bytes[i] = value,
                1 => bytes[i] = b"0123456789-$.e \n"[value as usize % 16],
                2 => drop(bytes.remove(i)),
                _ => bytes.insert(i, value),
            }
        }
        if let Ok(mesh) = read_bytes(&bytes, format, Path::new("x")) {
            prop_assert!(build::check_mesh(&mesh).is_ok());
        }
    }
}
