//! Files of solvers: our own come back, those of others are understood, and damage is named.

use super::*;

fn grouped(mesh: &TriMesh, format: Format, encoding: Encoding, groups: Grouping) -> TriMesh {
    let mut bytes = Vec::new();
    let options = WriteOptions { encoding, groups, ..WriteOptions::default() };
    encode(&mut bytes, mesh, format, &options, &Run::new()).unwrap();
    read_bytes(&bytes, format, Path::new("x")).unwrap()
}

#[test]
fn medit_and_nastran_keep_faces() {
    let mesh = cube();
    let read = grouped(&mesh, Format::Medit, Encoding::Usual, Grouping::Faces);
    assert_eq!(read, TriMesh { groups: vec![], ..mesh.clone() });
    let read = grouped(&mesh, Format::Bdf, Encoding::Usual, Grouping::Faces);
    assert_eq!((&read.triangles, &read.labels, &read.faces), (&mesh.triangles, &mesh.labels, &mesh.faces));
    for (p, q) in read.nodes.iter().zip(&mesh.nodes) {
        assert!((0..3).all(|k| (p[k] / q[k] - 1.0).abs() < 1e-9), "{p} {q}");
    }
}

#[test]
fn abaqus_and_su2_keep_faces_under_plain_names() {
    let mesh = cube();
    let plain = ["bore_1", "F__u_ere_Fl_che_", "F", "F50_25__x_", "a_b", "endsolid"];
    let su2 = grouped(&mesh, Format::Su2, Encoding::Usual, Grouping::Faces);
    assert_eq!((&su2.nodes, &su2.triangles, &su2.labels), (&mesh.nodes, &mesh.triangles, &mesh.labels));
    let inp = grouped(&mesh, Format::Inp, Encoding::Usual, Grouping::All);
    assert_eq!((&inp.triangles, &inp.labels), (&mesh.triangles, &mesh.labels));
    for (p, q) in inp.nodes.iter().zip(&mesh.nodes) {
        assert!((0..3).all(|k| (p[k] / q[k] - 1.0).abs() < 1e-12), "{p} {q}");
    }
    assert_eq!(
        [&su2.faces, &inp.faces]
            .map(|f| f.iter().map(|n| n.chars().filter(|c| *c != '_').collect()).collect::<Vec<String>>()),
        [plain, plain].map(|p| p.map(|n| n.replace('_', "")).to_vec())
    );
    let groups: Vec<(&str, &[u32])> = inp.groups.iter().map(|g| (&g.name[..], &g.faces[..])).collect();
    assert_eq!(groups, [("clamped", &[0, 2][..]), ("a__quoted__one", &[0, 5])]);
}

#[test]
fn vtk_files_keep_faces_and_groups() {
    let mesh = cube();
    for format in [Format::Vtu, Format::Vtp] {
        for encoding in [Encoding::Text, Encoding::Binary] {
            let read = grouped(&mesh, format, encoding, Grouping::All);
            let parts = (&read.nodes, &read.triangles, &read.labels);
            assert_eq!(parts, (&mesh.nodes, &mesh.triangles, &mesh.labels), "{format:?} {encoding:?}");
            // XML holds no line break in a name, and groups without faces leave no trace.
            let names: Vec<String> = mesh.faces.iter().map(|n| n.replace('\n', "_")).collect();
            assert_eq!(read.faces, names, "{format:?} {encoding:?}");
            let full: Vec<Group> = mesh.groups.iter().filter(|g| !g.faces.is_empty()).cloned().collect();
            assert_eq!(read.groups, full, "{format:?} {encoding:?}");
        }
    }
}

/// What a text holds: triangles with the names of their faces, groups with those of theirs, the number of nodes, the area.
struct FoundText {
    faces: Vec<String>,
    groups: Vec<String>,
    nodes: usize,
    area: f64,
}

fn found(bytes: &[u8], format: Format) -> FoundText {
    let mesh = read_bytes(bytes, format, Path::new("x")).unwrap();
    let group = |g: &Group| {
        let faces: Vec<&str> = g.faces.iter().map(|f| &mesh.faces[*f as usize][..]).collect();
        format!("{}: {}", g.name, faces.join(", "))
    };
    FoundText {
        faces: mesh.labels.iter().map(|l| mesh.faces[*l as usize].clone()).collect(),
        groups: mesh.groups.iter().map(group).collect(),
        nodes: mesh.nodes.len(),
        area: mesh.area(),
    }
}

#[test]
fn medit_of_others() {
    let of_gmsh = " MeshVersionFormatted 2\n Dimension\n 3\n Vertices\n 5\n 0 0 0 1\n 1 0 0 1\n 3 3 0 1\n 0 1 0 1\n 0 0 1 4\n\
        Edges\n 1\n 1 2 3\n Triangles\n 1\n 1 2 5 7\n Quadrilaterals\n 1\n 1 2 3 4 -2\n Tetrahedra\n 1\n 1 2 3 5 1\n End\n";
    let f = found(of_gmsh.as_bytes(), Format::Medit);
    assert_eq!((&f.faces[..], f.nodes), (&["ref 7", "ref -2", "ref -2"].map(String::from)[..], 5));
    // The short diagonal of the kite is from (1, 0) to (0, 1).
    let mesh = read_bytes(of_gmsh.as_bytes(), Format::Medit, Path::new("x")).unwrap();
    assert_eq!(mesh.triangles[1..], [[0, 1, 3], [1, 2, 3]]);
    let of_meshio = "MeshVersionFormatted 1\n# Created by meshio v5.3.5\n\nDimension\n3\n\nVertices\n3\n\
        0.0e+00 0.0e+00 0.0e+00 1\n2.0e+00 0 0 1\n0 1.0e+00 0 1\n\nTriangles\n1\n1 2 3 0\n\nEnd\n";
    let f = found(of_meshio.as_bytes(), Format::Medit);
    assert_eq!((&f.faces[..], f.area), (&["surface".to_string()][..], 1.0));
    let flat = of_meshio.replace("Dimension\n3", "Dimension 2").replace("0.0e+00 0.0e+00 0.0e+00", "0 0");
    let flat = flat.replace("2.0e+00 0 0", "2 0").replace("0 1.0e+00 0 1", "0 1 1");
    assert_eq!(found(flat.as_bytes(), Format::Medit).area, 1.0);
}

#[test]
fn abaqus_of_others() {
    let of_gmsh = "*Heading\n a.inp\n*NODE\n1, 0, 0, 0\n2, 1, 0, 0\n3, 1, 1, 0\n4, 0, 1, 0\n5, 0, 0, 1\n\
        ******* E L E M E N T S *************\n*ELEMENT, type=T3D2, ELSET=Line1\n1, 1, 2\n\
        *ELEMENT, type=CPS3, ELSET=Surface1\n7, 1, 2, 3\n8, 1, 3, 4\n*ELEMENT, type=CPS3, ELSET=Surface2\n9, 1, 2, 5\n\
        *ELEMENT, type=C3D4, ELSET=Volume1\n10, 1, 2, 3, 5\n*ELSET,ELSET=floor\n7, 8, \n*ELSET,ELSET=all\n7, 8, 9\n\
        *NSET,NSET=floor\n1, 2, 3, 4\n";
    let f = found(of_gmsh.as_bytes(), Format::Inp);
    assert_eq!((&f.faces[..], f.area), (&["Surface1", "Surface1", "Surface2"].map(String::from)[..], 1.5));
    assert_eq!(f.groups, ["floor: Surface1", "all: Surface1, Surface2"]);
    // Capitals, ranges, lines that go on, sets of sets, numbers of Fortran, and a set that parts a face.
    let by_hand = "** a comment\r\n*heading\r\nwhatever\r\n*Node , nset = N\r\n 1, 0., 0.D0\r\n2, 1.0d+00, 0, 0\r\n3, 1, 1,\r\n4, 0, 1\r\n\
        *Element, Type = s4r,\r\n elset=\"Plate\"\r\n 11, 1, 2,\r\n 3, 4\r\n*ELEMENT,TYPE=S3,ELSET=plate\r\n12, 1, 3, 4\r\n\
        *Elset, elset=odd, GENERATE\r\n1, 99999999999, 2\r\n*Elset, elset=Whole\r\nplate\r\n*Solid Section, elset=plate\r\n1.,\r\n";
    let f = found(by_hand.as_bytes(), Format::Inp);
    assert_eq!(f.faces, ["Plate 1", "Plate 1", "Plate 2"]);
    assert_eq!(f.groups, ["Plate: Plate 1, Plate 2", "odd: Plate 1", "Whole: Plate 1, Plate 2"]);
    assert_eq!((f.nodes, f.area), (4, 1.5));
}

#[test]
fn nastran_of_others() {
    let small = "$ Created by Gmsh\nGRID    1               0.0     0.0     0.0\nGRID    2       0       1.0     0.0     0.0\n\
        GRID    3               1.0     10.-1   .0\nGRID,4,,-1.5-30,1.0E+0,0\n\
        CTRIA3  1       7       1       2       3       \nCTRIA3,2,8,1,3,4\nENDDATA\n";
    let f = found(small.as_bytes(), Format::Bdf);
    assert_eq!((&f.faces[..], f.area), (&["PID 7", "PID 8"].map(String::from)[..], 1.0));
    let large = "SOL 101\nCEND\nGRID of the title\nBEGIN BULK\n$HMNAME COMP                   7\"wing\"\n\
        GRID*   1                               0.0000000000E+000.0000000000E+00*\n*       0.0000000000E+00\n\
        GRID*                  2                              1.              0.*N1     \n*N1                   0.\n\
        GRID*,3,,1.,1.\n*,0.\nGRID\t4\t\t0.\t1.\t0.\t$ tabs\n+\n\
        CBAR    1       1       1       2       0.      0.      1.\n\
        CQUAD4* 10              7               1               2\n*       3               4\nPSHELL  7       1       .1\n\
        +       more\nENDDATA\nGRID after the end\n";
    let f = found(large.as_bytes(), Format::Bdf);
    assert_eq!((&f.faces[..], f.area, f.nodes), (&["wing", "wing"].map(String::from)[..], 1.0, 4));
}

#[test]
fn su2_of_others() {
    let volume = "% a mesh\nNDIME= 3\nNELEM= 1\n10 0 1 2 3 0\nNPOIN= 5 5\n0 0 0 0\n1 0 0 1 % here\n0 1 0 2\n0 0 1 3\n1 1 0 4\n\
        NMARK= 2\nMARKER_TAG= wall\nMARKER_ELEMS= 1\n9 0 1 4 2\nMARKER_TAG = far\nMARKER_ELEMS=1\n5 0 2 3 7\n\
        FFD_NBOX= 1\nFFD_CORNER_POINTS= 1\n0 0 0\n";
    let f = found(volume.as_bytes(), Format::Su2);
    assert_eq!((&f.faces[..], f.area), (&["wall", "wall", "far"].map(String::from)[..], 1.5));
    let flat =
        "NDIME= 2\nNELEM= 1\n5 0 1 2\nNPOIN= 3\n0 0\n1 0\n0 1\nNMARK= 1\nMARKER_TAG= a\nMARKER_ELEMS= 1\n3 0 1\n";
    assert_eq!(found(flat.as_bytes(), Format::Su2).area, 0.5);
}

/// What meshio writes: blocks packed by zlib, here of 32 bytes; a quadrilateral, a triangle and a tetrahedron.
const PACKED: &str = r#"<?xml version="1.0"?>
<VTKFile type="UnstructuredGrid" version="0.1" byte_order="LittleEndian" compressor="vtkZLibDataCompressor">
<!--This file was created by meshio-->
<UnstructuredGrid>
<Piece NumberOfPoints="5" NumberOfCells="3">
<Points>
<DataArray type="Float64" Name="Points" NumberOfComponents="3" format="binary">
BAAAACAAAAAYAAAADgAAAA8AAAAPAAAADgAAAA==eJxjYMAHPtgDAAI/ATB4nGNgwAY+2MNoAA3WAl94nGNgwAY+2MNYAAu3ATB4nGNgwAY+2AMAAjcBMA==
</DataArray>
</Points>
<Cells>
<DataArray type="Int64" Name="connectivity" format="binary">
AwAAACAAAAAYAAAAEwAAABEAAAAQAAAAeJxjYIAARijNBKWZoTQAAHAAB3icY2CAAEYozcKACgAAeAAGeJxjZIAAJijNAqUBAHAACA==
</DataArray>
<DataArray type="Int64" Name="offsets" format="binary">
AQAAACAAAAAYAAAAEAAAAA==eJxjYYAAdijNDaUBAUAAFw==
</DataArray>
<DataArray type="Int64" Name="types" format="binary">
AQAAACAAAAAYAAAAEAAAAA==eJzjZIAAVijNBaUBAZAAGQ==
</DataArray>
</Cells>
<CellData>
<DataArray type="Int32" Name="medit:ref" format="binary">
AQAAACAAAAAMAAAAEQAAAA==eJxjZmBgYAdiRiAGAABsAAw=
</DataArray>
</CellData>
</Piece>
</UnstructuredGrid>
</VTKFile>
"#;

/// What VTK writes: data behind the tree, as base64.
const APPENDED: &str = r#"<VTKFile type="PolyData" version="0.1" byte_order="LittleEndian">
<PolyData>
<Piece NumberOfPoints="4" NumberOfVerts="0" NumberOfLines="0" NumberOfStrips="0" NumberOfPolys="2">
<Points>
<DataArray type="Float32" Name="Points" NumberOfComponents="3" format="appended" offset="0"/>
</Points>
<Polys>
<DataArray type="Int32" Name="connectivity" format="appended" offset="72"/>
<DataArray type="Int32" Name="offsets" format="appended" offset="112"/>
</Polys>
</Piece>
</PolyData>
<AppendedData encoding="base64">
_MAAAAAAAAAAAAAAAAAAAAAAAgD8AAAAAAAAAAAAAgD8AAIA/AAAAAAAAAAAAAIA/AAAAAA==GAAAAAAAAAABAAAAAgAAAAAAAAACAAAAAwAAAA==CAAAAAMAAAAGAAAA
</AppendedData>
</VTKFile>
"#;

#[test]
fn vtk_of_others() {
    let f = found(PACKED.as_bytes(), Format::Vtu);
    let names = ["medit:ref 3", "medit:ref 3", "medit:ref 7"].map(String::from);
    assert_eq!((&f.faces[..], f.area, f.nodes), (&names[..], 1.5, 5));
    let f = found(APPENDED.as_bytes(), Format::Vtp);
    assert_eq!((&f.faces[..], f.area), (&["surface", "surface"].map(String::from)[..], 1.0));
    // The same without base64: each array is a length of four bytes and what it says.
    let mut raw = APPENDED.replace("base64", "raw").split_once("\n_").unwrap().0.as_bytes().to_vec();
    raw.push(b'_');
    let head = String::from_utf8(raw)
        .unwrap()
        .replace("offset=\"72\"", "offset=\"52\"")
        .replace("offset=\"112\"", "offset=\"80\"");
    let mut raw = head.into_bytes();
    raw.extend(48u32.to_le_bytes());
    for x in [0f32, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 1.0, 0.0] {
        raw.extend(x.to_le_bytes());
    }
    for numbers in [&[24u32, 0, 1, 2, 0, 2, 3][..], &[8, 3, 6]] {
        numbers.iter().for_each(|n| raw.extend(n.to_le_bytes()));
    }
    raw.extend(b"\n</AppendedData>\n</VTKFile>\n");
    assert_eq!(found(&raw, Format::Vtp).area, 1.0);
    let lz4 = PACKED.replace("vtkZLib", "vtkLZ4");
    assert!(refusal(lz4.as_bytes(), Format::Vtu).contains("line 2, column 1: data packed by vtkLZ4DataCompressor"));
}

#[test]
fn damage_in_files_of_solvers_is_named_with_its_place() {
    let medit =
        |rest: &str| format!("MeshVersionFormatted 2\nDimension 3\nVertices 3\n0 0 0 1\n1 0 0 1\n0 1 0 1\n{rest}");
    let inp = |rest: &str| format!("*NODE\n1, 0, 0, 0\n2, 1, 0, 0\n3, 0, 1, 0\n{rest}");
    let bdf = |rest: &str| format!("BEGIN BULK\nGRID,1,,0.,0.,0.\nGRID,2,,1.,0.,0.\nGRID,3,,0.,1.,0.\n{rest}ENDDATA\n");
    let su2 = |rest: &str| format!("NDIME= 3\nNPOIN= 3\n0 0 0\n1 0 0\n0 1 0\n{rest}");
    let vtp = |points: &str, corners: &str, ends: &str| {
        let array = |kind: &str, name: &str, text: &str| {
            format!("<DataArray type=\"{kind}\" Name=\"{name}\" format=\"ascii\">{text}</DataArray>")
        };
        format!(
            "<VTKFile type=\"PolyData\"><PolyData>\n<Piece NumberOfPoints=\"3\" NumberOfPolys=\"1\">\n<Points>\n{}</Points>\n\
             <Polys>{}\n{}</Polys></Piece></PolyData></VTKFile>",
            array("Float64", "Points", points),
            array("Int32", "connectivity", corners),
            array("Int32", "offsets", ends)
        )
    };
    let good = "0 0 0 1 0 0 0 1 0";
    assert_eq!(found(vtp(good, "0 1 2", "3").as_bytes(), Format::Vtp).area, 0.5);
    let cases: &[(Format, String, &str)] = &[
        (Format::Medit, "solid".into(), "line 1: a Medit file begins"),
        (Format::Medit, medit("Triangles 1\n1 2 4 0\nEnd\n"), "line 8: element 1: it uses node 4"),
        (Format::Medit, medit("Triangles 1\n1 2 3 x\nEnd\n"), "line 8: the reference is `x`"),
        (Format::Medit, medit("Triangles 99999999999\n1 2 3 0\n"), "line 7: 99999999999 triangles do not fit"),
        (Format::Medit, medit("Triangles 1\n1 2 3 0\n"), "line 9: the file ends here, where `End`"),
        (Format::Medit, medit("TrianglesP2 1\n1 2 3 1 2 3 0\nEnd\n"), "line 7: `TrianglesP2` is no section"),
        (Format::Medit, medit("Tetrahedra 1\n1 2 3 1 0\nEnd\n"), "volume elements and no triangle"),
        (Format::Medit, medit("End\n").replace("1 0 0 1", "1 nan 0 1"), "line 5: y coordinate is NaN"),
        (Format::Inp, "solid".into(), "line 1: an input file begins"),
        (Format::Inp, inp("*INCLUDE, INPUT=b.inp\n"), "line 5: *INCLUDE is not read"),
        (Format::Inp, inp("*ELEMENT, TYPE=S3\n1, 1, 2, 4\n"), "line 6: element 1: it uses node 4"),
        (Format::Inp, inp("*ELEMENT, TYPE=S3\n1, 1, 2\n"), "line 6: an element with 3 nodes has 3 numbers"),
        (Format::Inp, inp("*ELEMENT, TYPE=S8R\n1, 1, 2\n"), "line 5: elements of type `S8R`"),
        (Format::Inp, inp("*ELEMENT, TYPE=C3D4\n1, 1, 2, 3, 1\n"), "volume elements and no triangle"),
        (Format::Inp, inp("*ELSET, ELSET=a\n1, b\n"), "line 6: `b` is no number of an element"),
        (Format::Inp, inp("*NODE\n4, 1, inf\n"), "line 6: y coordinate is inf"),
        (Format::Bdf, bdf("CTRIA3,1,1,1,2,4\n"), "line 5: element 1: it uses node 4"),
        (Format::Bdf, bdf("CTRIA3,1,1,1,2\n"), "line 5: CTRIA3 has `` for a node"),
        (Format::Bdf, bdf("GRID,4,,1.x\n"), "line 5: GRID has `1.x` for x"),
        (Format::Bdf, bdf("GRID,4,2,1.\n"), "line 5: GRID 4 is in the coordinate system `2`"),
        (Format::Bdf, bdf("CTRIA6,1,1,1,2,3,1,2,3\n"), "line 5: CTRIA6 is not read"),
        (Format::Bdf, bdf("CTETRA,1,1,1,2,3,1\n"), "volume elements and no triangle"),
        (Format::Bdf, bdf("INCLUDE 'b.bdf'\n"), "line 5: INCLUDE is not read"),
        (Format::Bdf, bdf("").replace("ENDDATA", ""), "the file ends here, where `ENDDATA`"),
        (Format::Su2, "5 0 1 2\n".into(), "line 1: an SU2 file begins"),
        (Format::Su2, su2("MARKER_TAG= a\nMARKER_ELEMS= 1\n5 0 1 3\n"), "line 8: element 0: it uses node 3"),
        (
            Format::Su2,
            su2("MARKER_TAG= a\nMARKER_ELEMS= 99999999999\n5 0 1 2\n"),
            "line 8: the file ends here, where element 1",
        ),
        (Format::Su2, su2("MARKER_ELEMS= 1\n5 0 1 2\n"), "line 6: no `MARKER_TAG=`"),
        (Format::Su2, su2("NMARK= 2\nMARKER_TAG= a\nMARKER_ELEMS= 1\n5 0 1 2\n"), "line 9: 2 markers were promised"),
        (Format::Su2, su2("MARKER_TAG= a\nMARKER_ELEMS= 1\n22 0 1 2\n"), "line 8: elements of type 22"),
        (Format::Su2, "NDIME= 3\nNPOIN= 99999999999\n0 0 0\n".into(), "line 3: the file ends here, where point 1"),
        (
            Format::Vtp,
            "<a/>".into(),
            "line 1, column 1: a file of this extension begins with <VTKFile type=\"PolyData\">",
        ),
        (Format::Vtp, "<a>".into(), "this is no XML"),
        (Format::Vtp, vtp("0 0 0", "0 1 2", "3"), "line 4, column 1: 3 numbers are not those of 3 points"),
        (Format::Vtp, vtp("0 0 0 1 0 0 0 nan 0", "0 1 2", "3"), "line 4, column 1: point 2 is at"),
        (Format::Vtp, vtp(good, "0 1 3", "3"), "line 2, column 1: cell 0 uses node 3, but there are 3"),
        (Format::Vtp, vtp(good, "0 1 2", "4"), "line 2, column 1: cell 0 ends before it begins"),
        (
            Format::Vtp,
            vtp(good, "0 1 2", "3").replace("NumberOfPolys=\"1\"", "NumberOfStrips=\"1\""),
            "strips of triangles are not read",
        ),
    ];
    for (format, text, wanted) in cases {
        let message = refusal(text.as_bytes(), *format);
        assert!(message.contains(wanted), "{format:?}: {message:?} instead of {wanted:?}\n{text}");
    }
}
