//! scratch
use rvachev::implicit::*;
use rvachev::{DVec3, Run};
use std::time::Instant;
fn main() {
    let n: f64 = std::env::args().nth(1).map_or(64.0, |s| s.parse().unwrap());
    let which = std::env::args().nth(2).unwrap_or("a".into());
    let h = 2.0 * 1.237 / n;
    let s = if which == "a" {
        let cube = Solid::cuboid(-DVec3::ONE, DVec3::ONE).name("body");
        cube - Solid::cylinder(0.4, DVec3::X, DVec3::ZERO, None) - Solid::cylinder(0.4, DVec3::Z, DVec3::ZERO, None)
    } else if which == "gy" {
        Solid::from(Primitive::Tpms { kind: Tpms::Gyroid, period: 2.0, thickness: 0.3, at: DVec3::ZERO })
            & Solid::cuboid(-DVec3::ONE, DVec3::ONE)
    } else {
        let k: usize = which.parse().unwrap();
        let mut st = 12345u64;
        let mut r = move || {
            st = st.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (st >> 11) as f64 / (1u64 << 53) as f64
        };
        let sc = 0.6 * (k as f64).powf(-1.0 / 3.0);
        Solid::union(
            (0..k)
                .map(|i| {
                    let c = DVec3::new(r(), r(), r()) * 1.8 - 0.9;
                    let rad = sc * (0.5 + 0.5 * r());
                    let a = DVec3::new(r() - 0.5, r() - 0.5, r() - 0.5).normalize();
                    if i % 2 == 0 {
                        Solid::sphere(rad, c)
                    } else {
                        Solid::cylinder(0.7 * rad, a, c, Some(2.0 * rad * (0.7 + 0.8 * r())))
                    }
                })
                .collect::<Vec<_>>(),
        )
    };
    let run = Run::new().with_threads(1).unwrap();
    let t = Instant::now();
    let m = Implicit::new(&s, RSystem::R0, None).unwrap();
    println!(
        "lower {:.4} s {:?} {} leaves {} ops",
        t.elapsed().as_secs_f64(),
        m.bounds(),
        m.leaf_count(),
        m.tree_size()
    );
    let check = std::env::args().nth(3).is_some();
    for _ in 0..if check { 1 } else { 3 } {
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
        if !check {
            println!(
                "{}",
                std::fs::read_to_string("/proc/self/status").unwrap().lines().find(|l| l.starts_with("VmHWM")).unwrap()
            );
            continue;
        }
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
}
