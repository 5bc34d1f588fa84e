//! Faces that decide at points, pictures of comparisons, and what is told of parts built from edges, in all three languages alike.

use super::*;

/// The part the programs write, as a file.
const BORED: &str = "part(box(size=(2, 2, 2)).name('body') - cylinder(0.4, axis='x').name('bore'))\n";

/// What one of the programs printed is true.
fn holds(text: &str) {
    // Near the middles of two sides, in the bore, beyond the roof, and on the floor.
    assert!(text.contains("\nat body.xmin at body.ymax at bore at body.zmax at body.zmin\n"), "{text}");
    assert_eq!(number(text, "faces", "faces"), 7.0, "{text}");
    let (_, bar) = told(text, "bar ");
    assert_eq!([&bar["vertices"], &bar["edges"], &bar["open_edges"]], [&json!(8), &json!(12), &json!(0)], "{bar}");
    assert_eq!([&bar["units"], &bar["sewn"]], [&json!("mm"), &json!(true)]);
    let faces = bar["faces"].as_array().unwrap();
    assert!(faces.len() == 6 && faces.iter().all(|f| near(f["area"].as_f64().unwrap(), 4.0, 1e-9)), "{bar}");
    assert!(near(bar["bodies"][0]["volume"].as_f64().unwrap(), 8.0, 1e-9), "{bar}");
    assert!(near(bar["bounds"]["size"][2].as_f64().unwrap(), 2.0, 1e-9), "{bar}");
}

/// The picture that the command makes of a comparison.
fn drawn(what: &[&str], png: &Path) -> Vec<u8> {
    said(
        Command::new(env!("CARGO_BIN_EXE_rvachev")).arg("compare").args(what).args(["--size", "0.4", "--png"]).arg(png),
    );
    fs::read(png).unwrap()
}

#[test]
fn faces_comparisons_and_built_parts_are_told_of() {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("capi");
    fs::create_dir_all(&folder).unwrap();
    let [cube, bored, png] = ["told.obj", "told.py", "told.png"].map(|n| folder.join(n));
    write_cube(&cube);
    fs::write(&bored, BORED).unwrap();
    let truth = [
        drawn(&[bored.to_str().unwrap()], &png),
        drawn(&[cube.to_str().unwrap(), "--color", "class"], &png),
        drawn(&["--samples"], &png),
    ];
    assert!(truth.iter().all(|t| t.starts_with(b"\x89PNG") && t.len() > 10_000));
    for (language, name, sources) in [
        (C, "told_c", vec!["tests/capi/told.c"]),
        (CPP, "told_cpp", vec!["tests/capi/told.cpp"]),
        (FORTRAN, "told_fortran", vec!["capi/fortran/rvachev.f90", "tests/capi/told.f90"]),
    ] {
        let program = language.program(name, &sources);
        let made = ["a.png", "b.png", "c.png"].map(|n| program.with_file_name(n));
        made.iter().for_each(|m| drop(fs::remove_file(m)));
        holds(&said(Command::new(&program).arg(&cube).args(&made)));
        for (made, truth) in made.iter().zip(&truth) {
            assert!(fs::read(made).unwrap() == *truth, "{} is another picture", made.display());
        }
    }
}
