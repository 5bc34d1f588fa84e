//! scratch
use rvachev::implicit::*;
use rvachev::{DVec3, Run};
use std::time::Instant;
fn main() {
    let n: f64 = std::env::args().nth(1).map_or(64.0, |s| s.parse().unwrap());
    let h = 2.0 * 1.237 / n;
    let cube = Solid::cuboid(-DVec3::ONE, DVec3::ONE).name("body");
    let s =
        cube - Solid::cylinder(0.4, DVec3::X, DVec3::ZERO, None) - Solid::cylinder(0.4, DVec3::Z, DVec3::ZERO, None);
    let run = Run::new().with_threads(1).unwrap();
    let m = Implicit::new(&s, RSystem::R0, None).unwrap();
    println!("{:?} {} leaves {} ops", m.bounds(), m.leaf_count(), m.tree_size());
    for _ in 0..3 {
        let t = Instant::now();
        let e = extract(&m, &ExtractOptions::new(h), &run).unwrap();
        println!(
            "{:.4} s  {} nodes {} triangles volume {} area {}",
            t.elapsed().as_secs_f64(),
            e.mesh.nodes.len(),
            e.mesh.triangles.len(),
            e.mesh.volume(),
            e.mesh.area()
        );
        let mut c = std::collections::HashMap::new();
        for t in &e.mesh.triangles {
            for i in 0..3 {
                *c.entry((t[i], t[(i + 1) % 3])).or_insert(0) += 1;
            }
        }
        let bad = c.iter().filter(|(k, v)| **v != 1 || c.get(&(k.1, k.0)) != Some(&1)).count();
        println!(
            "bad edges {bad}  euler {}",
            e.mesh.nodes.len() as i64 - c.len() as i64 / 2 + e.mesh.triangles.len() as i64
        );
    }
    println!(
        "{}",
        std::fs::read_to_string("/proc/self/status").unwrap().lines().find(|l| l.starts_with("VmHWM")).unwrap()
    );
}
