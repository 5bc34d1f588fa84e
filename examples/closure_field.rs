//! A function of an analysis code as a solid: two warm blobs, everything above a threshold, cut flat below.
//!
//! Shows a closure as a leaf beside ordinary primitives, and a finished mesh as flat arrays of nodes and triangles, the
//! form other codes take.

use rvachev::{Aabb, DVec3, MeshOptions, Part, Result, Run, SizeRequest, Solid, mesh_part};

fn main() -> Result<()> {
    let heat = |p: DVec3| {
        let sources = [DVec3::new(-0.6, 0.0, 0.0), DVec3::new(0.6, 0.0, 0.2)];
        sources.iter().map(|s| (-2.0 * p.distance_squared(*s)).exp()).sum::<f64>() - 0.5
    };
    let warm = Solid::field(heat).name("warm");
    let floor = Solid::half_space(DVec3::NEG_Z, DVec3::ZERO).name("floor");

    let mut part = Part::from_solid(warm & floor);
    // Nothing is known of a closure, so the box to look in must be given.
    part.domain = Some(Aabb::new(DVec3::splat(-2.0), DVec3::splat(2.0)));
    let options = MeshOptions { size: Some(SizeRequest::Length(0.08)), ..MeshOptions::default() };
    let mesh = mesh_part(&part, &options, &Run::new())?.mesh;

    let coordinates: Vec<f64> = mesh.nodes.iter().flat_map(|p| p.to_array()).collect();
    let triangles: Vec<u32> = mesh.triangles.iter().flatten().copied().collect();
    println!("{} nodes in {} numbers", mesh.nodes.len(), coordinates.len());
    println!("{} triangles in {} numbers", mesh.triangles.len(), triangles.len());
    for (face, name) in mesh.faces.iter().enumerate() {
        let count = mesh.labels.iter().filter(|label| **label as usize == face).count();
        println!("face {name}: {count} triangles");
    }

    let farthest = mesh.nodes.iter().map(|p| heat(*p).min(p.z).abs()).fold(0.0, f64::max);
    println!("no node is farther than {farthest:.1e} from where the field vanishes or the floor is");
    assert!(farthest < 1e-6);
    Ok(())
}
