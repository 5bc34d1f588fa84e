//! A finished mesh edited face by face, as a preprocessor does while its user works: one face meshed anew, one taken away and put back.
//!
//! cargo run --release --example fragments

use rvachev::{Addition, Cut, DVec3, Merged, MeshOptions, MeshView, Part, Result, Run, SizeRequest, Solid, mesh_part};

fn main() -> Result<()> {
    let run = Run::new();
    let bore = Solid::cylinder(0.5, DVec3::Z, DVec3::ZERO, None).name("bore");
    let cube = Solid::cuboid(-DVec3::ONE, DVec3::ONE).name("cube") - bore;
    let options = MeshOptions { size: Some(SizeRequest::Length(0.2)), ..MeshOptions::default() };
    let mut made = mesh_part(&Part::from_solid(cube), &options, &run)?;
    println!("meshed:       {} nodes, {} triangles", made.mesh.nodes.len(), made.mesh.triangles.len());
    made.remesh_face("bore", 0.08, &run)?;
    println!("bore anew:    {} nodes, {} triangles", made.mesh.nodes.len(), made.mesh.triangles.len());

    let Cut { model, fragments, .. } = made.model()?;
    let mut merged = Merged::new(model, fragments)?;
    let tell = |what: &str, merged: &Merged| {
        let [vertices, edges, faces] = merged.fragments().counts();
        println!(
            "{what} {} nodes, {} triangles on {faces} faces, {edges} edges, {vertices} vertices",
            merged.node_count(),
            merged.cell_count()
        );
    };
    tell("merged:      ", &merged);
    let away = merged.remove(0)?;
    tell("one taken:   ", &merged);
    merged.insert(Addition { faces: vec![(away.face, away.fragment)], ..Addition::default() })?;
    tell("and put back:", &merged);
    Ok(())
}
