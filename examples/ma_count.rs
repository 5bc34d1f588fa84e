//! scratch
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::collections::HashMap;
use std::sync::Mutex;
use rvachev::implicit::part::{Part, SizeRequest};
use rvachev::implicit::{Field, Solid};
use rvachev::pipeline::{MeshOptions, mesh_part};
use rvachev::spatial::Aabb;
use rvachev::{DVec3, Run};

#[derive(Default)]
struct Count { calls: AtomicUsize, points: AtomicUsize, tiny: AtomicUsize, seen: Mutex<HashMap<String, (usize, usize)>> }
struct F(Arc<Count>, String, bool, bool);
fn smin(k: &str, a: f64, b: f64) -> f64 { if k == "r0" { a + b - (a * a + b * b).sqrt() } else { a.min(b) } }
fn f(k: &str, p: DVec3) -> f64 {
    if k == "ball" { return 1.0 - p.length(); }
    let q = p.abs();
    let b = smin(k, smin(k, 1.0 - q.x, 1.0 - q.y), 1.0 - q.z);
    let c1 = p.x.hypot(p.y) - 0.5;
    let c2 = p.y.hypot(p.z) - 0.4;
    smin(k, b, smin(k, c1, c2))
}
impl F {
    fn trace(&self, n: usize) {
        let c = self.0.calls.fetch_add(1, Ordering::Relaxed);
        self.0.points.fetch_add(n, Ordering::Relaxed);
        if n < 100 { self.0.tiny.fetch_add(1, Ordering::Relaxed); }
        if !self.3 || (n < 100 && c % 200 != 0) { return; }
        let bt = std::backtrace::Backtrace::force_capture().to_string();
        let names: Vec<&str> = bt.lines().map(str::trim).filter(|l| l.contains(": ") && l.contains("rvachev::")).map(|l| l.split_once(": ").unwrap().1)
            .filter(|l| !l.contains("leaf::") && !l.contains("rayon") ).take(7).collect();
        let key = format!("{} {}", if n < 100 { "tiny*200" } else { "big" }, names.join(" < "));
        let mut seen = self.0.seen.lock().unwrap();
        let e = seen.entry(key).or_default();
        e.0 += 1; e.1 += n;
    }
}
impl Field for F {
    fn value(&self, p: DVec3) -> f64 { self.trace(1); f(&self.1, p) }
    fn values(&self, p: &[DVec3], out: &mut [f64]) {
        self.trace(p.len());
        for (o, p) in out.iter_mut().zip(p) { *o = f(&self.1, *p); }
    }
    fn lipschitz(&self) -> Option<f64> { self.2.then_some(1.0) }
}
fn main() {
    let a: Vec<String> = std::env::args().collect();
    let n = Arc::new(Count::default());
    let mut part = Part::from_solid(Solid::field(F(n.clone(), a[1].clone(), a[3] == "L", a.get(4).is_some_and(|x| x == "trace"))).name("f"));
    part.domain = Some(Aabb::new(DVec3::splat(-1.5), DVec3::splat(1.5)));
    let options = MeshOptions { size: Some(SizeRequest::Length(a[2].parse().unwrap())), method: std::env::var("M").map_or(Default::default(), |m| m.parse().unwrap()), ..MeshOptions::default() };
    let threads: usize = std::env::var("T").map_or(2, |t| t.parse().unwrap());
    let t = std::time::Instant::now();
    let made = mesh_part(&part, &options, &Run::new().with_threads(threads).unwrap()).unwrap();
    let s = t.elapsed().as_secs_f64();
    let (c, p) = (n.calls.load(Ordering::Relaxed), n.points.load(Ordering::Relaxed));
    let off = made.mesh.nodes.iter().map(|q| f("min", *q).abs()).fold(0.0, f64::max);
    let mut all: Vec<_> = n.seen.lock().unwrap().clone().into_iter().collect();
    all.sort_by_key(|x| std::cmp::Reverse(x.1.0));
    for (k, v) in all.iter().take(25) { println!("{} calls {} points: {}", v.0, v.1, k); }
    let node = |v: u32| made.mesh.nodes[v as usize];
    let mut h = 0u64;
    for q in &made.mesh.nodes { for x in q.to_array() { h = h.rotate_left(5) ^ x.to_bits().wrapping_mul(0x9E37_79B9_7F4A_7C15); } }
    for q in &made.mesh.triangles { for x in q { h = h.rotate_left(5) ^ u64::from(*x).wrapping_mul(0x9E37_79B9_7F4A_7C15); } }
    // Edges against truth: straight edges of the cube, and circles of the holes.
    let truth = |q: DVec3| -> Vec<f64> {
        let w = q.abs();
        let m = |a: f64, b: f64| (1.0 - a).hypot(1.0 - b);
        vec![m(w.x, w.y), m(w.y, w.z), m(w.x, w.z), (w.z - 1.0).hypot(q.x.hypot(q.y) - 0.5), (w.x - 1.0).hypot(q.y.hypot(q.z) - 0.4),
            (q.x.hypot(q.y) - 0.5).hypot(q.y.hypot(q.z) - 0.4)]
    };
    let mut sides: HashMap<(u32, u32), Vec<usize>> = HashMap::new();
    for (i, t) in made.mesh.triangles.iter().enumerate() {
        for k in 0..3 { let (a, b) = (t[k], t[(k + 1) % 3]); sides.entry((a.min(b), a.max(b))).or_default().push(i); }
    }
    let (mut sharp, mut on, mut on_len) = (0, 0, 0.0);
    let mut lens = [0.0; 6];
    for ((a, b), ts) in &sides {
        let d: Vec<f64> = truth(node(*a)).into_iter().zip(truth(node(*b))).zip(truth(0.5 * (node(*a) + node(*b)))).map(|((x, y), m)| x.max(y).max(m)).collect();
        let n = |i: usize| { let [a, b, c] = made.mesh.triangles[i].map(node); (b - a).cross(c - a).normalize_or_zero() };
        if ts.len() == 2 && n(ts[0]).dot(n(ts[1])) < 0.8 {
            sharp += 1;
            let (k, best) = d.iter().enumerate().min_by(|a, b| a.1.total_cmp(b.1)).unwrap();
            if *best < 3e-3 { on += 1; on_len += (node(*a) - node(*b)).length(); lens[k] += (node(*a) - node(*b)).length(); }
        }
    }
    let corners = (0..8).filter(|k| { let c = DVec3::new(if k & 1 == 0 { 1.0 } else { -1.0 }, if k & 2 == 0 { 1.0 } else { -1.0 }, if k & 4 == 0 { 1.0 } else { -1.0 });
        made.mesh.nodes.iter().any(|q| (*q - c).length() < 1e-7) }).count();
    println!("sharp {sharp} on truth {on} length {on_len:.4} by curve {lens:?} (truth 8 8 8 {:.3} {:.3} ?) corners {corners}", 4.0 * 3.14159265 * 0.5, 4.0 * 3.14159265 * 0.4);
    println!("{} {} {}: {} triangles, {c} calls ({} tiny), {p} points, {s:.2} s, {:.0} tri/s, off {off:.1e}, hash {h:x}, min angle {:?} shortfalls {:?}", a[1], a[2], a[3], made.mesh.triangles.len(), n.tiny.load(Ordering::Relaxed), made.mesh.triangles.len() as f64 / s, 0, made.report.shortfalls.iter().map(|s| format!("{s:?}")).collect::<Vec<_>>());
}
