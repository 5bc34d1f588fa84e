//! Small files, read whole.

use std::path::Path;

use approx::assert_abs_diff_eq;

use super::*;
use crate::io::step::{parse_step, read_step};
use crate::parametric::Surface;

fn model(name: &str) -> StepModel {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("data/step").join(name);
    interpret(&read_step(&path).unwrap(), &Run::new()).unwrap()
}

fn text(name: &str) -> String {
    std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("data/step").join(name)).unwrap()
}

#[test]
fn faces_names_colors_and_units_are_read() {
    let m = model("cylinder_without_seam.step");
    assert!(m.notes.is_empty(), "{:?}", m.notes);
    let b = &m.brep;
    assert_eq!((b.vertices.len(), b.edges.len(), b.faces.len(), b.bodies.len()), (2, 2, 3, 1));
    let names: Vec<&str> = b.faces.iter().map(|f| f.name.as_str()).collect();
    assert_eq!(names, ["side", "bottom", "top"]);
    assert_eq!((b.bodies[0].name.as_str(), b.bodies[0].solid), ("rod", true));
    assert_eq!(b.faces[0].color, Some([1.0, 0.0, 0.0]));
    // The file is in inches.
    assert!(matches!(b.faces[0].surface, Surface::Cylinder { radius, .. } if (radius - 50.8).abs() < 1e-12));
    assert_abs_diff_eq!(b.vertices[1].z, 76.2, epsilon = 1e-12);
    assert_eq!(b.uses(), [2, 2]);
    assert_eq!([b.faces[0].outward, b.faces[1].outward, b.faces[2].outward], [true, false, true]);
}

#[test]
fn what_is_not_understood_is_named_by_record_and_line() {
    let broken = text("cylinder_without_seam.step").replace("CYLINDRICAL_SURFACE", "MOEBIUS_SURFACE");
    let m = interpret(&parse_step(broken.as_bytes()).unwrap(), &Run::new()).unwrap();
    assert_eq!(m.brep.faces.len(), 2);
    assert_eq!(m.notes.len(), 1);
    assert_eq!(m.notes[0].id, 20);
    assert!(m.notes[0].line > 10 && m.notes[0].message.contains("MOEBIUS_SURFACE"), "{}", m.notes[0]);
}

#[test]
fn a_curve_that_is_not_understood_between_two_vertices_is_a_straight_edge() {
    let broken = text("cylinder_without_seam.step").replace("CIRCLE('',#17,2.)", "CLOTHOID('',#17,2.)");
    let m = interpret(&parse_step(broken.as_bytes()).unwrap(), &Run::new()).unwrap();
    // A closed edge cannot be straight: both its faces are named.
    assert_eq!((m.brep.faces.len(), m.notes.len()), (1, 2));
}

#[test]
fn references_that_lead_nowhere_or_in_circles_end() {
    let whole = text("cone_with_apex.step");
    for (from, to) in
        [("#18=CIRCLE('',#7,2.)", "#18=SURFACE_CURVE('',#18,(),$)"), ("#4=CARTESIAN_POINT", "#400=CARTESIAN_POINT")]
    {
        assert!(whole.contains(from));
        let r = interpret(&parse_step(whole.replace(from, to).as_bytes()).unwrap(), &Run::new());
        assert!(r.is_err(), "{to}");
    }
}

#[test]
fn records_that_are_missed_are_told_with_the_line_that_asks_for_them() {
    let torn = text("cone_with_apex.step").replace("#34=PLANE", "#340=PLANE");
    let asks = 1 + torn.lines().position(|l| l.contains("#31),#34,")).unwrap();
    let m = interpret(&parse_step(torn.as_bytes()).unwrap(), &Run::new()).unwrap();
    assert_eq!((m.brep.faces.len(), m.notes.len()), (1, 1));
    let told = m.notes[0].to_string();
    assert!(told.contains(&format!("#34 (line {asks}): is referred to but not there")), "{told}");
}

#[test]
fn assemblies_place_their_parts() {
    // The cone twice: where it is, and moved by (0, 0, 10) through a mapped item.
    let whole = text("cone_with_apex.step").replace(
        "(#7,#10),#3)",
        "(#7,#10),#3);\n#70=CARTESIAN_POINT('',(0.,0.,10.));\n\
        #71=AXIS2_PLACEMENT_3D('',#70,#5,#6);\n#72=REPRESENTATION_MAP(#7,#8);\n#73=MAPPED_ITEM('',#72,#7);\n\
        #74=MAPPED_ITEM('',#72,#71);\n#75=SHAPE_REPRESENTATION('',(#73,#74),#3)",
    );
    let m = interpret(&parse_step(whole.as_bytes()).unwrap(), &Run::new()).unwrap();
    assert_eq!((m.brep.bodies.len(), m.brep.faces.len(), m.notes.len()), (2, 4, 0));
    let z: Vec<f64> = m.brep.vertices.iter().map(|v| v.z).collect();
    assert_eq!(z, [0.0, 10.0]);
    let names: std::collections::BTreeSet<&str> = m.brep.faces.iter().map(|f| f.name.as_str()).collect();
    assert_eq!(names.len(), 4);
}
