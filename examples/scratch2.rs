//! scratch
use rvachev::geometry::*;
use rvachev::implicit::*;
use rvachev::{DVec3, Run};
use std::time::Instant;
fn main() {
    let cube = Solid::cuboid(-DVec3::ONE, DVec3::ONE).name("body");
    let s =
        cube - Solid::cylinder(0.4, DVec3::X, DVec3::ZERO, None) - Solid::cylinder(0.4, DVec3::Z, DVec3::ZERO, None);
    let run = Run::new();
    let m = Implicit::new(&s, RSystem::R0, None).unwrap();
    let h = 2.0 * 1.237 / 64.0;
    let t = Instant::now();
    let f = features(&m, h, &run).unwrap();
    println!(
        "features {:.4}s length {} ({} at 40) corners {}",
        t.elapsed().as_secs_f64(),
        f.length(-1.0),
        f.length(40.0),
        f.corners.len()
    );
    let e = extract(&m, &ExtractOptions::new(h), &run).unwrap();
    let o = ImplicitOracle::new(&m, &e);
    let t = Instant::now();
    let (mut none, mut far, mut along_none, mut dmax) = (0, 0, 0, 0.0f64);
    for i in 0..e.mesh.triangles.len() {
        let c = e.mesh.centroid(i);
        match o.project(c, 4.0 * h) {
            None => none += 1,
            Some(f) => {
                let d = f.point.distance(c);
                dmax = dmax.max(d);
                if d > 0.5 * h {
                    far += 1
                }
            }
        }
    }
    println!(
        "project {:.3} us none {none} far {far} dmax/h {}",
        t.elapsed().as_secs_f64() * 1e6 / e.mesh.triangles.len() as f64,
        dmax / h
    );
    let t = Instant::now();
    for i in 0..e.mesh.triangles.len() {
        let c = e.mesh.centroid(i);
        if o.project_along(c, e.mesh.normal(i), h).is_none() {
            along_none += 1
        }
    }
    println!("along {:.3} us none {along_none}", t.elapsed().as_secs_f64() * 1e6 / e.mesh.triangles.len() as f64);
    let f = o.project(DVec3::new(0.7, 0.4, 0.1), 0.2).unwrap();
    println!("{f:?} {:?} {}", o.curvatures(&f), e.mesh.faces[f.face as usize]);
    for p in [
        DVec3::new(1.1, 1.1, 0.5),
        DVec3::new(1.1, 1.2, 1.3),
        DVec3::new(0.95, 0.9, 0.9),
        DVec3::new(1.02, 0.38, 0.05),
        DVec3::new(0.9, 0.9, 0.0),
    ] {
        println!("{p} -> {:?}", o.project(p, 1.0));
    }
}
