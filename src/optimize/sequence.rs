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
    for _ in 0..o.n1 {
        stage!("N1", snap_to_planes(&mut m, oracle, h, 0.0, run)?);
    }
    stage!("cut", cut_creases(&mut m, oracle, h, o.feature_angle, run)?);
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
