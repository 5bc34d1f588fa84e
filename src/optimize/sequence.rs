//! The default sequence of operators.

use super::classify::classify_by_edges;
use super::crease::*;
use super::density::*;
use super::dual::snap_to_planes;
use super::flips::*;
use super::size::Sizing;
use super::smooth::*;
use super::surface::*;
use crate::error::Result;
use crate::geometry::SurfaceOracle;
use crate::mesh::*;
use crate::run::Run;

/// x
#[derive(Debug, Clone, Copy)]
pub struct Options {
    /// size
    pub size: f64,
    /// feature
    pub feature_angle: f64,
    /// n1
    pub n1: usize,
    /// rounds
    pub rounds: usize,
}

/// x
pub fn improve(mesh: &mut TriMesh, oracle: &dyn SurfaceOracle, o: &Options, run: &Run, see: &mut dyn FnMut(&str, &TriMesh)) -> Result<()> {
    let h = o.size;
    let mut m = EditMesh::new(mesh)?;
    let sizing = Sizing::uniform(h);
    let mut field = sizing.field(&m, oracle, h, run)?;
    macro_rules! stage { ($name:expr, $e:expr) => {{ let t = std::time::Instant::now(); let r = $e; let dt = t.elapsed(); see(&format!("{} {:?} {:.0}ms", $name, r, dt.as_secs_f64()*1e3), &m.to_mesh()); }} }
    stage!("mc", 0);
    stage!("collapse", collapse_short(&mut m, oracle, &field, 0.3, h, run)?);
    stage!("flip", flip_for_angles(&mut m, 10.0, run)?);
    for _ in 0..2 {
        stage!("R_all", smooth_all(&mut m, oracle, h, run)?);
        stage!("flip", flip_for_angles(&mut m, 10.0, run)?);
    }
    for _ in 0..o.n1 {
        stage!("N1", snap_to_planes(&mut m, oracle, h, 0.0, run)?);
    }
    for _ in 0..2 {
        stage!("cut", cut_creases(&mut m, oracle, h, o.feature_angle, run)?);
    }
    field.resize(m.node_capacity(), h);
    stage!("survey", survey(&mut m, oracle, h, run)?);
    for _ in 0..o.rounds {
        stage!("collapse", collapse_short(&mut m, oracle, &field, SHORT*0.9, h, run)?);
        stage!("flip", flip_for_angles(&mut m, 10.0, run)?);
        stage!("split", densify(&mut m, oracle, &mut field, h, run)?);
        stage!("flip", flip_for_angles(&mut m, 10.0, run)?);
        let classes = classify_by_edges(&m);
        stage!("R_edge", smooth_edges(&mut m, oracle, &classes, ALONG, h, run)?);
        stage!("R_regular", smooth_regular(&mut m, oracle, &classes, h, run)?);
    }
    stage!("flip", flip_for_angles(&mut m, 10.0, run)?);
    stage!("degenerate", remove_degenerate(&mut m, oracle, 20.0, h, run)?);
    stage!("relax", relax_worst(&mut m, oracle, 35.0, h, run)?);
    stage!("flip", flip_for_angles(&mut m, 10.0, run)?);
    stage!("settle", settle_creases(&mut m, oracle, h, run)?);
    stage!("survey", survey(&mut m, oracle, h, run)?);
    if let Err(e) = m.check() { return Err(crate::Error::Failed(e)); }
    *mesh = m.to_mesh();
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use super::super::testing::*;
    #[test]
    fn probe() {
        use glam::DVec3;
        let n: usize = std::env::var("N").map_or(16, |s| s.parse().unwrap());
        let part = if std::env::var("PART").as_deref() == Ok("b") { Part::cube_corner_sphere() } else if std::env::var("PART").as_deref() == Ok("a") { Part::cube_with_holes(glam::DMat3::IDENTITY) } else if std::env::var("PART").as_deref() == Ok("ar") { Part::cube_with_holes(Part::generic_turn()) } else { Part::plain_cube(Part::generic_turn()) };
        let h = 2.0 * part.half / n as f64;
        let mesh = march(&part, n);
        let mut m = EditMesh::new(&mesh).unwrap();
        let run = Run::new();
        let field = vec![h; m.node_capacity()];
        println!("{:?}", collapse_short(&mut m, &part, &field, 0.3, h, &run).unwrap());
        let env = |k: &str| std::env::var(k).map_or(0, |s| s.parse::<usize>().unwrap());
        if env("TRACE") > 0 { for v in [6u32, 13] { println!("start {v} {} {:?}", part.crease_distance(m.point(v), 5.0) / h, part.project(m.point(v), h)); } }
        if env("DEG") > 0 { println!("{:?}", remove_degenerate(&mut m, &part, env("DEG") as f64, h, &run).unwrap()); }
        flip_for_angles(&mut m, 10.0, &run).unwrap();
        for _ in 0..env("RALL") { println!("{:?}", smooth_all(&mut m, &part, h, &run).unwrap()); flip_for_angles(&mut m, 10.0, &run).unwrap(); }
        for _ in 0..env("FN") { println!("{:?}", flip_for_normals(&mut m, &part, h, 20.0, &run).unwrap()); }
        let before = m.clone();
        println!("{:?}", cut_creases(&mut m, &part, h, 20.0, &run).unwrap());
        println!("{:?}", survey(&mut m, &part, h, &run).unwrap());
        for _ in 0..env("P2") {
        println!("flips {:?}", flip_for_normals(&mut m, &part, h, 20.0, &run).unwrap());
        println!("{:?}", survey(&mut m, &part, h, &run).unwrap());
        println!("{:?}", cut_creases(&mut m, &part, h, 20.0, &run).unwrap());
        println!("{:?}", survey(&mut m, &part, h, &run).unwrap());
        }
        let (_, corners) = part.creases(0.9 * h, 40.0);
        for c in corners {
            let near: Vec<u32> = m.nodes().filter(|&v| m.point(v).distance(c) < 0.05 * h).collect();
            if near.is_empty() {
                println!("corner {c} missed");
                for t in before.triangles() {
                    if before.centroid(t).distance(c) < 1.5 * h && { let f = before.corners(t).map(|v| part.project(before.point(v), h).unwrap().face); f[0]!=f[1]&&f[1]!=f[2]&&f[2]!=f[0] } {
                        let f = before.corners(t).map(|v| part.project(before.point(v), h).unwrap().face);
                        println!("   t{t} {:?} faces {f:?} d {:?}", before.corners(t), before.corner_points(t).map(|p| (p.distance(c) / h * 100.0).round()));
                    }
                }
                for v in m.nodes() {
                    let p: DVec3 = m.point(v);
                    if p.distance(c) < 1.2 * h && v as usize >= before.node_capacity() { println!("   new node {v} at {}", p.distance(c) / h); }
                }
            }
        }
        for v in m.nodes() { if !m.is_pinned(v) && crate::optimize::classify::kind_by_edges(&m, v) == crate::optimize::classify::Kind::Corner {
            println!("odd {v} at {} crease distance {:.3} ring {:?} degree {} ", m.point(v), part.crease_distance(m.point(v), 5.0) / h, m.outgoing(v).map(|h| (m.target(h), m.is_sharp(h), m.label(h/3))).collect::<Vec<_>>(), m.outgoing(v).filter(|&h| m.is_sharp(h)).count());
        } }
        for t in m.triangles() {
            let f = m.area_vector(t).normalize_or_zero().dot(m.normal(t));
            if f < 0.8 {
                println!("t{t} facing {f:.3} label {} {:?} new from {} angle {:.2}", m.label(t), m.corners(t).map(|v| (v, crate::optimize::classify::kind_by_edges(&m, v), part.project(m.point(v), h).unwrap().face)), before.node_capacity(), crate::optimize::guard::sharpest_cosine(m.corner_points(t)).acos().to_degrees());
            }
        }
    }
    #[test]
    fn explore() {
        let n: usize = std::env::var("N").map_or(64, |s| s.parse().unwrap());
        let what = std::env::var("PART").unwrap_or("a".into());
        let part = match what.as_str() { "a" => Part::cube_with_holes(glam::DMat3::IDENTITY), "ar" => Part::cube_with_holes(Part::generic_turn()), "s" => Part::sphere(1.0), "c" => Part::plain_cube(Part::generic_turn()), _ => Part::cube_corner_sphere() };
        let n1 = std::env::var("N1").map_or(1, |s| s.parse().unwrap());
        let all = std::env::var("ALL").is_ok();
        let mut m = march(&part, n);
        let h = 2.0 * part.half / n as f64;
        let o = Options { size: h, feature_angle: 20.0, n1, rounds: 5 };
        println!("h {h}");
        let run = Run::new().with_threads(1).unwrap();
        improve(&mut m, &part, &o, &run, &mut |name, m| {
            if all { println!("{name}\n    {:?}", measure(m, &part, h)); } else { println!("{name}"); }
        }).unwrap();
        println!("{:?}", measure(&m, &part, h));
        // write off
        let mut s = format!("OFF\n{} {} 0\n", m.nodes.len(), m.triangles.len());
        for p in &m.nodes { s += &format!("{:?} {:?} {:?}\n", p.x, p.y, p.z); }
        for t in &m.triangles { s += &format!("3 {} {} {}\n", t[0], t[1], t[2]); }
        std::fs::write(format!("/tmp/opt_{what}.off"), s).unwrap();
    }
}
