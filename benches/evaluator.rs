//! Values of functions at many points, beside the same functions written by hand as one loop: `cargo bench --bench evaluator`.
//!
//! Everything runs on one thread in one run, in batches of 4096 points, so ratios mean something on any machine. The loops by
//! hand are compiled for the same processors as the library and call the system's sine, exponential and so on.

use std::hint::black_box;
use std::time::Instant;

use multiversion::multiversion;
use rvachev::DVec3;
use rvachev::Run;
use rvachev::implicit::expr::{Binary, Unary};
use rvachev::implicit::{Expr, Implicit, RSystem, Sampling, Solid, evaluate};

const BATCH: usize = 4096;
const BATCHES: usize = 16;

/// Points in the cube of half side 2.
struct Points {
    x: Vec<f64>,
    y: Vec<f64>,
    z: Vec<f64>,
}

impl Points {
    fn new() -> Self {
        let mut state = 0x2545_f491_4f6c_dd1du64;
        let mut next = || {
            state ^= state << 13;
            state ^= state >> 7;
            state ^= state << 17;
            4.0 * (state >> 11) as f64 / (1u64 << 53) as f64 - 2.0
        };
        let mut list = || (0..BATCH * BATCHES).map(|_| next()).collect::<Vec<f64>>();
        Points { x: list(), y: list(), z: list() }
    }
}

/// Values at many points.
type Batch<'a> = &'a dyn Fn([&[f64]; 3], &mut [f64]);

/// Millions of points a second, the best of many passes, and the values of the last: so many lists of them for each batch.
fn speed(points: &Points, width: usize, work: Batch) -> (f64, Vec<f64>) {
    let mut out = vec![0.0; width * BATCH];
    let mut all = Vec::new();
    let mut least = f64::INFINITY;
    let begin = Instant::now();
    while begin.elapsed().as_secs_f64() < 0.5 {
        for k in 0..BATCHES {
            let range = k * BATCH..(k + 1) * BATCH;
            let p = [&points.x[range.clone()], &points.y[range.clone()], &points.z[range]];
            for _ in 0..4 {
                let start = Instant::now();
                work(black_box(p), &mut out);
                least = least.min(start.elapsed().as_secs_f64());
            }
            black_box(&out);
        }
    }
    for k in 0..BATCHES {
        let range = k * BATCH..(k + 1) * BATCH;
        work([&points.x[range.clone()], &points.y[range.clone()], &points.z[range]], &mut out);
        all.extend_from_slice(&out);
    }
    (BATCH as f64 / least / 1e6, all)
}

fn row(points: &Points, what: &str, solid: &Solid, by_hand: Batch, gradient_by_hand: Option<Batch>) {
    let model = Implicit::new(solid, RSystem::default(), None).expect("a bounded solid");
    let (ours, values) = speed(points, 1, &|[x, y, z], out| model.companion(x, y, z, out));
    let (fused, expected) = speed(points, 1, by_hand);
    for (a, b) in values.iter().zip(&expected) {
        // the same solid, though its leaves may be other functions than the one by hand
        assert!(a * b > 0.0 || b.abs() < 1e-12, "{what}: {a} is not {b}");
    }
    println!(
        "{what:<28} {:>3} operations {ours:>8.1} M/s of {fused:>8.1} M/s by hand: {:.2}",
        model.tree_size(),
        ours / fused,
    );
    let model = Implicit::new(solid, RSystem::MinMax, None).expect("a bounded solid");
    let alone = speed(points, 1, &|[x, y, z], out| {
        for i in 0..out.len() {
            out[i] = model.gradient(DVec3::new(x[i], y[i], z[i])).1.x;
        }
    });
    let (ours, gradients) = gradients_in_batches(points, &model);
    print!("{:<28} gradients alone {:>6.1} M/s, in batches {ours:>7.1} M/s", "", alone.0);
    if let Some(by_hand) = gradient_by_hand {
        let (fused, expected) = speed(points, 3, by_hand);
        // a tree of more than one leaf may be another function of the same solid
        for (k, g) in gradients.iter().enumerate().filter(|_| model.tree_size() == 1) {
            let from = k / BATCH * 3 * BATCH + k % BATCH;
            let h = DVec3::new(expected[from], expected[from + BATCH], expected[from + 2 * BATCH]);
            assert!((*g - h).abs().max_element() <= 1e-9 * (1.0 + h.length()), "{what}: {g} is not {h}");
        }
        print!(" of {fused:>8.1} M/s by hand: {:.2}", ours / fused);
    }
    println!();
}

/// Millions of points a second, the best of many passes, and the gradients.
fn gradients_in_batches(points: &Points, model: &Implicit) -> (f64, Vec<DVec3>) {
    let at: Vec<DVec3> = (0..points.x.len()).map(|i| DVec3::new(points.x[i], points.y[i], points.z[i])).collect();
    let (run, wanted) = (Run::new(), Sampling { gradients: true, faces: false });
    // so few are evaluated on this thread
    let work = |some: &[DVec3]| evaluate(model, some, wanted, &run).expect("nobody cancels").gradients;
    let mut least = f64::INFINITY;
    let begin = Instant::now();
    while begin.elapsed().as_secs_f64() < 0.5 {
        for batch in at.chunks(BATCH) {
            let start = Instant::now();
            for some in batch.chunks(256) {
                black_box(work(black_box(some)));
            }
            least = least.min(start.elapsed().as_secs_f64());
        }
    }
    (BATCH as f64 / least / 1e6, at.chunks(256).flat_map(work).collect())
}

macro_rules! gradient_by_hand {
    ($name:ident, $f:expr) => {
        #[multiversion(targets("x86_64+avx512f+avx512dq+avx512vl", "x86_64+avx2", "aarch64+neon"))]
        fn $name(p: [&[f64]; 3], out: &mut [f64]) {
            let n = out.len() / 3;
            let [xs, ys, zs] = [&p[0][..n], &p[1][..n], &p[2][..n]];
            let (dx, rest) = out.split_at_mut(n);
            let (dy, dz) = rest.split_at_mut(n);
            let f = $f;
            for i in 0..n {
                [dx[i], dy[i], dz[i]] = f(xs[i], ys[i], zs[i]);
            }
        }
    };
}

macro_rules! by_hand {
    ($name:ident, $f:expr) => {
        #[multiversion(targets("x86_64+avx512f+avx512dq+avx512vl", "x86_64+avx2", "aarch64+neon"))]
        fn $name(p: [&[f64]; 3], out: &mut [f64]) {
            let n = out.len();
            let [xs, ys, zs] = [&p[0][..n], &p[1][..n], &p[2][..n]];
            let f = $f;
            for i in 0..n {
                out[i] = f(xs[i], ys[i], zs[i]);
            }
        }
    };
}

by_hand!(quartic_by_hand, |x: f64, y: f64, z: f64| {
    let s = x * x + y * y + z * z + 0.91;
    4.0 * (x * x + y * y) - s * s
});

gradient_by_hand!(quartic_gradient, |x: f64, y: f64, z: f64| {
    let s = x * x + y * y + z * z + 0.91;
    let flat = 8.0 - 4.0 * s;
    [x * flat, y * flat, -4.0 * s * z]
});

fn quartic() -> Solid {
    let (x, y, z) = (Expr::x(), Expr::y(), Expr::z());
    let flat = x.clone() * x + y.clone() * y;
    let s = flat.clone() + z.clone() * z + 0.91;
    Solid::formula(flat * 4.0 - s.clone() * s)
}

by_hand!(sextic_by_hand, |x: f64, y: f64, z: f64| {
    let (a, b, c) = (x * x, y * y, z * z);
    1.0 + 2.0 * (a * b * c) - (a * a * a + b * b * b + c * c * c)
});

gradient_by_hand!(sextic_gradient, |x: f64, y: f64, z: f64| {
    let (a, b, c) = (x * x, y * y, z * z);
    [
        2.0 * x * (2.0 * (b * c) - 3.0 * (a * a)),
        2.0 * y * (2.0 * (a * c) - 3.0 * (b * b)),
        2.0 * z * (2.0 * (a * b) - 3.0 * (c * c)),
    ]
});

/// A rounded cube.
fn sextic() -> Solid {
    let [a, b, c] = [Expr::x(), Expr::y(), Expr::z()].map(|x| x.clone() * x);
    let cubed = |a: &Expr| a.clone() * a.clone() * a.clone();
    let sum = cubed(&a) + cubed(&b) + cubed(&c);
    Solid::formula(Expr::constant(1.0) + a * b * c * 2.0 - sum)
}

fn ball(x: f64, y: f64, z: f64, r: f64) -> f64 {
    (r * r - (x * x + y * y + z * z)) * (0.5 / r)
}

by_hand!(gyroid_by_hand, |x: f64, y: f64, z: f64| {
    let (a, b, c) = (x * 3.0, y * 3.0, z * 3.0);
    let g = a.sin() * b.cos() + b.sin() * c.cos() + c.sin() * a.cos();
    (0.3 - g * g).min(ball(x, y, z, 1.9))
});

/// The gradient of the lesser of a value with a gradient and the ball.
fn in_ball(v: f64, g: [f64; 3], [x, y, z]: [f64; 3]) -> [f64; 3] {
    if v < ball(x, y, z, 1.9) { g } else { [-x / 1.9, -y / 1.9, -z / 1.9] }
}

gradient_by_hand!(gyroid_gradient, |x: f64, y: f64, z: f64| {
    let ((sa, ca), (sb, cb), (sc, cc)) = ((x * 3.0).sin_cos(), (y * 3.0).sin_cos(), (z * 3.0).sin_cos());
    let g = sa * cb + sb * cc + sc * ca;
    let k = -6.0 * g;
    in_ball(0.3 - g * g, [k * (ca * cb - sc * sa), k * (cb * cc - sa * sb), k * (cc * ca - sb * sc)], [x, y, z])
});

fn gyroid() -> Solid {
    let [a, b, c] = [Expr::x(), Expr::y(), Expr::z()].map(|e| e * 3.0);
    let sin = |e: &Expr| Expr::unary(Unary::Sin, e.clone());
    let cos = |e: &Expr| Expr::unary(Unary::Cos, e.clone());
    let g = sin(&a) * cos(&b) + sin(&b) * cos(&c) + sin(&c) * cos(&a);
    Solid::formula(Expr::constant(0.3) - g.clone() * g) & Solid::sphere(1.9, DVec3::ZERO)
}

by_hand!(thread_by_hand, |x: f64, y: f64, z: f64| {
    let r = (x * x + y * y).sqrt();
    let turn = z * 6.0 - y.atan2(x);
    (1.0 + 0.1 * turn.sin() + 0.2 * (-(z * z)).exp() - r).min(ball(x, y, z, 1.9))
});

gradient_by_hand!(thread_gradient, |x: f64, y: f64, z: f64| {
    let square = x * x + y * y;
    let r = square.sqrt();
    let (sin, cos) = (z * 6.0 - y.atan2(x)).sin_cos();
    let waist = 0.2 * (-(z * z)).exp();
    let turn = 0.1 * cos / square;
    in_ball(1.0 + 0.1 * sin + waist - r, [turn * y - x / r, -turn * x - y / r, 0.6 * cos - 2.0 * z * waist], [x, y, z])
});

/// A round thread on a bar with a waist.
fn thread() -> Solid {
    let (x, y, z) = (Expr::x(), Expr::y(), Expr::z());
    let r = Expr::unary(Unary::Sqrt, x.clone() * x.clone() + y.clone() * y.clone());
    let turn = z.clone() * 6.0 - Expr::binary(Binary::Atan2, y, x);
    let waist = Expr::unary(Unary::Exp, -(z.clone() * z));
    let f = Expr::constant(1.0) + Expr::constant(0.1) * Expr::unary(Unary::Sin, turn) + Expr::constant(0.2) * waist - r;
    Solid::formula(f) & Solid::sphere(1.9, DVec3::ZERO)
}

fn bar(x: f64, y: f64, r: f64) -> f64 {
    (r * r - (x * x + y * y)) * (0.5 / r)
}

/// Where the bracket's holes are, and how large they are.
const HOLES: [[f64; 3]; 8] = [
    [-1.5, -0.5, 0.1],
    [-1.5, 0.5, 0.12],
    [1.5, -0.5, 0.1],
    [1.5, 0.5, 0.12],
    [-0.9, -0.5, 0.2],
    [-0.9, 0.5, 0.2],
    [0.9, -0.5, 0.2],
    [0.9, 0.5, 0.2],
];

/// Where the bracket's walls are.
const WALLS: [f64; 3] = [-1.2, 0.0, 1.2];

by_hand!(bracket_by_hand, |x: f64, y: f64, z: f64| {
    let smaller = |a: f64, b: f64| if a < b { a } else { b };
    let larger = |a: f64, b: f64| if a > b { a } else { b };
    let slab = |x: f64, lo: f64, hi: f64| smaller(x - lo, hi - x);
    let mut f = smaller(smaller(slab(x, -1.8, 1.8), slab(y, -0.8, 0.8)), slab(z, -0.2, 0.2));
    for at in WALLS {
        let wall = smaller(smaller(slab(x, at - 0.1, at + 0.1), slab(y, -0.6, 0.6)), slab(z, -0.1, 1.0));
        f = larger(f, smaller(wall, -bar(y, z - 0.6, 0.2)));
    }
    for [at_x, at_y, r] in HOLES {
        f = smaller(f, -bar(x - at_x, y - at_y, r));
    }
    smaller(larger(f, ball(x, y, z - 0.3, 0.4)), -ball(x, y, z - 0.3, 0.3))
});

/// Four boxes, eleven bores and a hollow ball.
fn bracket() -> Solid {
    let slab = |x: [f64; 2], y: [f64; 2], z: [f64; 2]| {
        Solid::cuboid(DVec3::new(x[0], y[0], z[0]), DVec3::new(x[1], y[1], z[1]))
    };
    let mut all = slab([-1.8, 1.8], [-0.8, 0.8], [-0.2, 0.2]);
    for at in WALLS {
        let wall = slab([at - 0.1, at + 0.1], [-0.6, 0.6], [-0.1, 1.0]);
        all = all | (wall - Solid::cylinder(0.2, DVec3::X, DVec3::new(0.0, 0.0, 0.6), None));
    }
    for [x, y, r] in HOLES {
        all = all - Solid::cylinder(r, DVec3::Z, DVec3::new(x, y, 0.0), None);
    }
    let at = DVec3::new(0.0, 0.0, 0.3);
    (all | Solid::sphere(0.4, at)) - Solid::sphere(0.3, at)
}

fn main() {
    let points = Points::new();
    row(&points, "quartic of a torus", &quartic(), &quartic_by_hand, Some(&quartic_gradient));
    row(&points, "sextic of a rounded cube", &sextic(), &sextic_by_hand, Some(&sextic_gradient));
    row(&points, "gyroid: sin, cos", &gyroid(), &gyroid_by_hand, Some(&gyroid_gradient));
    row(&points, "thread: atan2, exp, sqrt, sin", &thread(), &thread_by_hand, Some(&thread_gradient));
    row(&points, "bracket of 20 primitives", &bracket(), &bracket_by_hand, None);
}
