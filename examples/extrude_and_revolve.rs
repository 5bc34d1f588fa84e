//! Edges extruded and revolved as the thesis [KUZ19] does: a segment, a polyline and a spline, with the end scales 0.01, 1
//! and 2, and around axes in several directions; sheets first, then a solid of each kind, its mesh, its STEP file.
//!
//! What is printed is what the thesis prints of a part: faces with their surfaces, parameters, areas and boxes, counts, and
//! whether it is sewn.

use rvachev::{
    Axis, Brep, DVec3, Extrusion, MeshOptions, Result, Run, SizeRequest, SplineEnds, Wire, brep_info, extrude_edges,
    mesh_step, revolve_edges, write_step,
};

fn at(points: &[[f64; 3]]) -> Vec<DVec3> {
    points.iter().map(|p| DVec3::from_array(*p)).collect()
}

fn main() -> Result<()> {
    let run = Run::new();
    let segment = Wire::polyline(&at(&[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]]))?;
    let corners = [[0.0, 1.0, 0.0], [2.0, 0.0, 0.0], [4.0, 2.0, 0.0], [4.0, -1.0, 0.0], [6.0, 1.0, 0.0]];
    let polyline = Wire::polyline(&at(&corners))?;
    let through = [[0.0, 0.0, 0.0], [2.0, 2.0, 0.0], [4.0, -1.0, 0.0], [6.0, 1.0, 0.0], [7.0, 0.0, 0.0]];
    let spline = Wire::spline(&at(&through), SplineEnds::Natural)?;

    let mut open = 0;
    let mut tell = |what: String, b: Brep| -> Result<()> {
        let info = brep_info(b.into(), Some("m"), &run)?;
        open += usize::from(!info.sewn);
        println!("---- {what}\n{info}");
        Ok(())
    };
    for (name, wire, direction) in
        [("segment", &segment, DVec3::Y), ("polyline", &polyline, DVec3::Z), ("spline", &spline, DVec3::Z)]
    {
        for scale in [0.01, 1.0, 2.0] {
            let how = Extrusion { scale, caps: false, ..Extrusion::new(direction, 1.0) };
            tell(format!("{name} extruded, end scale {scale}"), extrude_edges(std::slice::from_ref(wire), &how)?)?;
        }
    }
    let around = |direction| Axis { origin: DVec3::ZERO, direction };
    tell("segment around z".into(), revolve_edges(&segment, &around(DVec3::Z), 360.0, false)?)?;
    let slanted = around(DVec3::new(3.0, 1.0, 2.0));
    tell("segment around (3, 1, 2)".into(), revolve_edges(&segment, &slanted, 360.0, false)?)?;
    tell("polyline around y".into(), revolve_edges(&polyline, &around(DVec3::Y), 360.0, false)?)?;
    tell("spline around y, 200 degrees".into(), revolve_edges(&spline, &around(DVec3::Y), 200.0, false)?)?;

    // An open contour makes no solid, and the gap is named.
    match extrude_edges(std::slice::from_ref(&polyline), &Extrusion::new(DVec3::Z, 1.0)) {
        Err(e) => println!("---- as a solid: {e}"),
        Ok(_) => return Err(rvachev::Error::Failed("an open contour was taken for a closed one".into())),
    }
    // Closed by straight edges it does.
    let rest = Wire::polyline(&at(&[[7.0, 0.0, 0.0], [7.0, -3.0, 0.0], [0.0, -3.0, 0.0], [0.0, 0.0, 0.0]]))?;
    let contour = Wire::joined(&[spline, rest])?;
    for scale in [0.01, 1.0, 2.0] {
        let b = extrude_edges(std::slice::from_ref(&contour), &Extrusion { scale, ..Extrusion::new(DVec3::Z, 2.0) })?;
        println!("---- solid, end scale {scale}: {} bytes as STEP", write_step(&b, "solid", "m")?.len());
        let how = MeshOptions { size: Some(SizeRequest::Share(0.03)), ..MeshOptions::default() };
        let made = mesh_step(b.into(), &how, &run)?;
        let sound = made.report.check.as_ref().is_some_and(|c| c.certificate.is_sound());
        println!("{} triangles, sound: {sound}", made.mesh.triangles.len());
        if !sound {
            let why: Vec<String> = made.report.shortfalls.iter().map(ToString::to_string).collect();
            return Err(rvachev::Error::Failed(why.join("; ")));
        }
    }
    println!("{open} sheets with open edges");
    Ok(())
}
