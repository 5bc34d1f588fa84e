//! Random set operations of random primitives, with the coincidences, tangencies, thin walls and tiny features that real
//! trees have: every one comes out as a sound mesh, or is refused with a reason.

use std::sync::atomic::{AtomicU64, Ordering};

use glam::{DMat3, DVec3};
use rvachev::implicit::{Placement, Primitive, Solid};
use rvachev::pipeline::{MeshOptions, Part, SizeRequest, mesh_part};
use rvachev::{Error, Run};

/// SplitMix64 (G. Steele, D. Lea, C. Flood 2014): the same trees on every machine.
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    fn unit(&mut self) -> f64 {
        (self.next() >> 11) as f64 / (1u64 << 53) as f64
    }

    fn between(&mut self, lo: f64, hi: f64) -> f64 {
        lo + (hi - lo) * self.unit()
    }

    fn below(&mut self, n: u64) -> u64 {
        self.next() % n
    }

    /// Lengths and places are often multiples of a tenth, so that faces coincide and touch.
    fn length(&mut self, lo: f64, hi: f64) -> f64 {
        let x = self.between(lo, hi);
        if self.below(2) == 0 { (10.0 * x).round().max(1.0) / 10.0 } else { x }
    }

    fn place(&mut self) -> DVec3 {
        let one = |r: &mut Self| {
            let x = r.between(-0.6, 0.6);
            if r.below(2) == 0 { (10.0 * x).round() / 10.0 } else { x }
        };
        DVec3::new(one(self), one(self), one(self))
    }

    fn axis(&mut self) -> DVec3 {
        if self.below(3) > 0 {
            return DVec3::AXES[self.below(3) as usize];
        }
        loop {
            let v = DVec3::new(self.between(-1.0, 1.0), self.between(-1.0, 1.0), self.between(-1.0, 1.0));
            if v.length() > 0.1 {
                return v.normalize();
            }
        }
    }

    fn primitive(&mut self) -> Solid {
        let (at, axis) = (self.place(), self.axis());
        match self.below(7) {
            0 | 1 => {
                let half = DVec3::new(self.length(0.1, 0.6), self.length(0.1, 0.6), self.length(0.05, 0.6));
                let cuboid = Solid::cuboid(at - half, at + half);
                if self.below(3) > 0 {
                    return cuboid;
                }
                let rotation = DMat3::from_axis_angle(axis, self.between(0.0, 3.0));
                cuboid.placed(Placement { rotation, scale: 1.0, shift: DVec3::ZERO })
            }
            2 => Solid::sphere(self.length(0.1, 0.6), at),
            3 | 4 => Solid::cylinder(self.length(0.05, 0.4), axis, at, Some(self.length(0.1, 1.4))),
            5 => {
                let (r0, height) = (self.length(0.1, 0.5), self.length(0.2, 1.0));
                let r1 = if self.below(3) == 0 { 0.0 } else { self.length(0.1, 0.3) };
                Primitive::Cone { r0, r1, height, axis, at }.into()
            }
            _ => Primitive::Torus { major: self.length(0.3, 0.5), minor: self.length(0.05, 0.2), axis, at }.into(),
        }
    }

    fn tree(&mut self, depth: u64) -> Solid {
        if depth == 0 || self.below(8) == 0 {
            return self.primitive();
        }
        let (a, b) = (self.tree(depth - 1), self.tree(depth - 1));
        match self.below(5) {
            0 | 1 => a | b,
            2 | 3 => a - b,
            _ => a & b,
        }
    }
}

/// What came of one tree.
#[derive(Clone, Copy, PartialEq)]
enum Outcome {
    Exact,
    Sound,
    Refused,
}

fn outcome(seed: u64) -> Outcome {
    let mut random = Random(seed);
    let depth = 1 + random.below(3);
    let part = Part::from_solid(random.tree(depth));
    let options = MeshOptions { size: Some(SizeRequest::Share(0.04)), measure: false, ..MeshOptions::default() };
    match mesh_part(&part, &options, &Run::new().with_threads(1).unwrap()) {
        Ok(made) => {
            let c = made.report.check.as_ref().unwrap();
            assert!(c.certificate.is_sound(), "seed {seed}: {:?}", c.certificate.faults);
            let (method, short) = (made.report.method, &made.report.shortfalls);
            // Whatever is not as it should be has its place in the report.
            assert!(method == "leaf" || !short.is_empty(), "seed {seed}: {method} without a reason");
            if method == "leaf" && short.is_empty() {
                return Outcome::Exact;
            }
            println!("seed {seed}: {method}, {}", short[0]);
            Outcome::Sound
        }
        Err(Error::Input { message, .. }) => {
            assert!(message.contains("empty") || message.contains("thinner"), "seed {seed}: {message}");
            Outcome::Refused
        }
        Err(e) => panic!("seed {seed}: {e}"),
    }
}

/// `RVACHEV_TREES` sets how many trees, `RVACHEV_FIRST` the first seed.
#[test]
fn random_trees_are_meshed_soundly_or_refused_with_a_reason() {
    let number = |name: &str, default: u64| std::env::var(name).ok().and_then(|n| n.parse().ok()).unwrap_or(default);
    let (count, first) = (number("RVACHEV_TREES", 1000), number("RVACHEV_FIRST", 0));
    let next = AtomicU64::new(first);
    let workers = std::thread::available_parallelism().map_or(1, usize::from);
    let all: Vec<Outcome> = std::thread::scope(|scope| {
        let work = || {
            let mut done = Vec::new();
            loop {
                let seed = next.fetch_add(1, Ordering::Relaxed);
                if seed >= first + count {
                    return done;
                }
                done.push(outcome(seed));
            }
        };
        let running: Vec<_> = (0..workers).map(|_| scope.spawn(work)).collect();
        running.into_iter().flat_map(|w| w.join().expect("a tree failed")).collect()
    });
    let of = |o: Outcome| all.iter().filter(|x| **x == o).count();
    let [exact, sound, refused] = [Outcome::Exact, Outcome::Sound, Outcome::Refused].map(of);
    println!("{count} trees: {exact} exact, {sound} sound with a reason why not exact, {refused} refused");
    assert!(count < 100 || exact * 20 > 19 * (exact + sound), "{exact} of {}", exact + sound);
}
