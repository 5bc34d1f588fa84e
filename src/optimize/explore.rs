use super::testing::*;
use super::*;
use crate::Run;
#[test]
fn explore() {
    let n: usize = std::env::var("N").map_or(64, |s| s.parse().unwrap());
    let what = std::env::var("PART").unwrap_or("a".into());
    let part = match what.as_str() {
        "a" => Part::cube_with_holes(glam::DMat3::IDENTITY),
        "ar" => Part::cube_with_holes(Part::generic_turn()),
        "s" => Part::sphere(1.0),
        "c" => Part::plain_cube(Part::generic_turn()),
        _ => Part::cube_corner_sphere(),
    };
    let mut m = march(&part, n);
    let h = 2.0 * part.half / n as f64;
    let mut o = Options::new(h);
    if std::env::var("PAPER").is_ok() {
        o.sequence = paper_sequence();
    }
    if let Ok(s) = std::env::var("SEQ") {
        o.sequence = s.split(',').map(|x| x.parse().unwrap()).collect();
    }
    if let Ok(s) = std::env::var("NPR") {
        o.nodes_per_radius = Some(s.parse().unwrap());
    }
    let run = Run::new().with_threads(1).unwrap();
    let all = std::env::var("ALL").is_ok();
    let start = std::time::Instant::now();
    let mut last = start;
    let r = improve_with(&mut m, &part, &o, &run, &mut |name, m| {
        println!("  {name} {:.0} ms", last.elapsed().as_secs_f64() * 1e3);
        if all {
            println!("{:?}", measure(m, &part, h));
        }
        last = std::time::Instant::now();
    })
    .unwrap();
    println!("TIME {:.3}", start.elapsed().as_secs_f64());
    for (a, b) in &r.stages {
        println!("  {a}: {b}");
    }
    println!("{:?}", measure(&m, &part, h));
    let mut s = format!("OFF\n{} {} 0\n", m.nodes.len(), m.triangles.len());
    for p in &m.nodes {
        s += &format!("{:?} {:?} {:?}\n", p.x, p.y, p.z);
    }
    for t in &m.triangles {
        s += &format!("3 {} {} {}\n", t[0], t[1], t[2]);
    }
    std::fs::write(format!("/tmp/opt_{what}.off"), s).unwrap();
}
