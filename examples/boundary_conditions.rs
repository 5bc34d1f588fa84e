//! Named groups of faces as the places of boundary conditions: lists of triangles and nodes, areas, forces.
//!
//! A bracket arm is clamped at one end; a pin pushes in its bore with a given total force, spread evenly over the area.

use rvachev::{DVec3, MeshOptions, Result, Run, mesh_part, parse_part};

const ARM: &str = r#"
length = 60

units("mm")

bar = box(lo=(0, -10, -4), hi=(length, 10, 4)).name("bar")
eye = cylinder(14, at=(length, 0, 0), height=8).name("eye")
pin = cylinder(7, at=(length, 0, 0)).name("pin")

part((bar | eye) - pin)
mesh(size=1.5)

group("clamp", faces("bar.xmin"))
group("load", faces("pin*"))
"#;

fn main() -> Result<()> {
    let part = parse_part("arm.py".as_ref(), ARM, &[("length".into(), 80.0)])?;
    let meshed = mesh_part(&part, &MeshOptions::default(), &Run::new())?;
    let mesh = &meshed.mesh;
    let force = DVec3::new(0.0, 0.0, -150.0);

    for group in &mesh.groups {
        let triangles: Vec<usize> =
            (0..mesh.triangles.len()).filter(|t| group.faces.contains(&mesh.labels[*t])).collect();
        let area: f64 = triangles.iter().map(|t| 0.5 * mesh.area_vector(*t).length()).sum();
        let mut nodes: Vec<u32> = triangles.iter().flat_map(|t| mesh.triangles[*t]).collect();
        nodes.sort_unstable();
        nodes.dedup();
        println!("{}: {} triangles, {} nodes, {area:.3} mm^2", group.name, triangles.len(), nodes.len());
        assert!(!triangles.is_empty());

        if group.name == "load" {
            // A third of a triangle's share goes to each of its nodes.
            let mut loads = vec![DVec3::ZERO; mesh.nodes.len()];
            for t in &triangles {
                let share = 0.5 * mesh.area_vector(*t).length() / area;
                mesh.triangles[*t].iter().for_each(|v| loads[*v as usize] += force * share / 3.0);
            }
            let total: DVec3 = loads.iter().sum();
            println!("nodal forces on {} nodes add up to {:.6} N", nodes.len(), total.z);
            assert!((total - force).length() < 1e-9);
            // The bore's wall: circumference times thickness.
            let wall = std::f64::consts::TAU * 7.0 * 8.0;
            assert!((area - wall).abs() < 0.01 * wall);
        }
    }
    for warning in &meshed.report.warnings {
        println!("warning: {warning}");
    }
    Ok(())
}
