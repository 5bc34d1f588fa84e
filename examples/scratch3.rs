//! scratch
use rvachev::implicit::*;
use rvachev::{DVec3, Run};
fn main() {
    let cube = Solid::cuboid(-DVec3::ONE, DVec3::ONE).name("body");
    let s =
        cube - Solid::cylinder(0.4, DVec3::X, DVec3::ZERO, None) - Solid::cylinder(0.4, DVec3::Z, DVec3::ZERO, None);
    let m = Implicit::new(&s, RSystem::R0, None).unwrap();
    let e = extract(&m, &ExtractOptions::new(2.0 * 1.237 / 64.0), &Run::new()).unwrap().mesh;
    use std::io::Write;
    let mut f = std::io::BufWriter::new(std::fs::File::create("/tmp/a.off").unwrap());
    writeln!(f, "OFF\n{} {} 0", e.nodes.len(), e.triangles.len()).unwrap();
    for p in &e.nodes {
        writeln!(f, "{} {} {}", p.x, p.y, p.z).unwrap();
    }
    for t in &e.triangles {
        writeln!(f, "3 {} {} {}", t[0], t[1], t[2]).unwrap();
    }
}
