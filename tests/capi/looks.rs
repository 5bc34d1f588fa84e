//! Pictures, curvatures, what triangles are made of, and comparisons, in all three languages alike.

use super::*;

/// What one of the programs printed is true.
fn holds(text: &str, png: &Path) {
    // A ball of half the radius of what is in focus, which fills the height but for margins of 5 pixels.
    let circle = PI * 22.5f64.powi(2);
    assert!(text.contains("picture width 120 height 100 "), "{text}");
    let covered = number(text, "picture", "covered");
    assert!(near(covered, circle, 0.03), "{text}");
    assert!(near(number(text, "half", "covered"), 0.5 * circle, 0.05), "{text}");
    assert_eq!(number(text, "half", "covered"), number(text, "far", "covered"), "{text}");
    let mut reader = png::Decoder::new(std::io::BufReader::new(fs::File::open(png).unwrap())).read_info().unwrap();
    let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
    let frame = reader.next_frame(&mut bytes).unwrap();
    assert_eq!((frame.width, frame.height, bytes.len()), (120, 100, 4 * 120 * 100));
    let written: f64 = bytes.chunks_exact(4).map(|p| f64::from(p[3]) / 255.0).sum();
    assert!(abs_diff_eq!(written, covered, epsilon = 1e-3), "{written} in the file, {text}");

    assert_eq!(number(text, "bends", "nodes"), number(text, "bends", "of"), "{text}");
    assert!(near(number(text, "bends", "mean"), 0.5, 0.02), "{text}");
    assert!(number(text, "bends", "order") == 1.0 && number(text, "bends", "most") < 0.75, "{text}");
    assert!(near(number(text, "bends", "sum"), 4.0 * PI, 1e-7), "{text}");
    assert!(number(text, "bends", "far") < 1e-9, "{text}");
    assert_eq!(number(text, "classes", "corners"), 8.0, "{text}");
    // Each of the cube's 12 edges has some seven of length 0.3, with six nodes between its corners; each side has some 45 inside.
    let [creases, regular] = ["creases", "regular"].map(|word| number(text, "classes", word));
    assert!(creases > 48.0 && creases < 120.0 && regular > 6.0 * 16.0, "{text}");

    let (_, info) = told(text, "info ");
    assert_eq!([&info["vertices"], &info["edges"], &info["closed"]], [&json!(8), &json!(12), &json!(true)]);
    let faces = info["faces"].as_array().unwrap();
    assert!(faces.len() == 6 && faces.iter().all(|f| near(f["area"].as_f64().unwrap(), 4.0, 1e-12)), "{info}");
    let (_, named) = told(text, "info_file");
    let names: Vec<&str> = named["faces"].as_array().unwrap().iter().filter_map(|f| f["name"].as_str()).collect();
    assert_eq!(names, ["floor", "roof", "wall.1", "wall.2", "wall.3", "wall.4"]);
    for word in ["soup ", "soup_file"] {
        let (_, compared) = told(text, word);
        let rows = compared["rows"].as_array().unwrap();
        let methods: Vec<&str> = rows.iter().filter_map(|r| r["method"].as_str()).collect();
        assert_eq!(methods, ["input", "poisson", "frontal", "triangles"]);
        assert!(rows.iter().all(|r| near(r["check"]["volume"].as_f64().unwrap(), 8.0, 1e-9)), "{compared}");
    }
    let (_, samples) = told(text, "samples");
    let rows = samples["rows"].as_array().unwrap();
    assert_eq!((rows.len(), &rows[0]["sample"], &rows[14]["method"]), (15, &json!("centered"), &json!("leaf")));
    let (_, systems) = told(text, "rsystems");
    let rows = systems["rows"].as_array().unwrap();
    assert_eq!((&rows[0]["rsystem"], &rows[0]["moved_nodes"]), (&json!("minmax"), &json!(0)));
    // Under min / max the function of planes and cylinders has slopes of 1 everywhere on the boundary.
    assert!(rows.len() == 5 && rows[0]["boundary"]["max"].as_f64().unwrap() < 1e-9, "{systems}");
}

#[test]
fn meshes_are_drawn_and_looked_at() {
    for (language, name, sources) in [
        (C, "looks_c", vec!["tests/capi/looks.c"]),
        (CPP, "looks_cpp", vec!["tests/capi/looks.cpp"]),
        (FORTRAN, "looks_fortran", vec!["capi/fortran/rvachev.f90", "tests/capi/looks.f90"]),
    ] {
        let program = language.program(name, &sources);
        let folder = program.parent().unwrap();
        let [cube, bores, png] = ["cube.obj", "bores.py", "ball.png"].map(|n| folder.join(n));
        write_cube(&cube);
        fs::write(&bores, CUBE).unwrap();
        let _ = fs::remove_file(&png);
        holds(&said(Command::new(&program).args([&cube, &bores, &png])), &png);
    }
}
