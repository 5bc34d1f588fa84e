//! Gradients of formulas at many points beside those at each point alone.

use rvachev::implicit::expr::{Binary, Unary};
use rvachev::implicit::{Expr, Implicit, RSystem, Sampling, Solid, evaluate};
use rvachev::{DVec3, Run};

fn formulas() -> Vec<Expr> {
    let [x, y, z] = [Expr::x, Expr::y, Expr::z].map(|f| f());
    let one = |op: Unary, e: &Expr| Expr::unary(op, e.clone());
    let two = |op: Binary, a: &Expr, b: &Expr| Expr::binary(op, a.clone(), b.clone());
    let square = x.clone() * x.clone() + y.clone() * y.clone();
    vec![
        Expr::constant(1.1) - square.clone() - z.clone() * z.clone() * z.clone() * z.clone(),
        one(Unary::Sqrt, &square) * -0.7 + one(Unary::Exp, &-(z.clone() * z.clone())),
        one(Unary::Sin, &(x.clone() * 2.0)) * one(Unary::Cos, &y) + one(Unary::Cos, &(x.clone() * 2.0)) * z.clone(),
        two(Binary::Hypot, &x, &z) * -1.0 + two(Binary::Atan2, &y, &(square.clone() + 0.3)) + 0.9,
        x.clone() / (square.clone() + 0.4) - two(Binary::Pow, &z, &Expr::constant(3.0)) + 0.2,
        one(Unary::Log, &(square + 0.1)) - two(Binary::Pow, &(z.clone() * z.clone() + 0.2), &x) + 0.7,
        one(Unary::Tanh, &(x.clone() * y.clone())) - one(Unary::Asin, &(z.clone() * 0.3)) - one(Unary::Abs, &-(y + x)),
    ]
}

#[test]
fn gradients_at_many_points_are_those_at_each_and_slopes_of_values() {
    let mut state = 1u64;
    let mut unit = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1u64 << 53) as f64
    };
    let points: Vec<DVec3> = (0..400).map(|_| DVec3::new(unit(), unit(), unit()) * 3.0 - 1.5).collect();
    for (number, f) in formulas().into_iter().enumerate() {
        let solid = Solid::formula(f) & Solid::sphere(2.9, DVec3::ZERO);
        let model = Implicit::new(&solid, RSystem::MinMax, None).unwrap();
        let wanted = Sampling { gradients: true, faces: false };
        let found = evaluate(&model, &points, wanted, &Run::new()).unwrap();
        let mut compared = 0;
        for (p, g) in points.iter().zip(&found.gradients) {
            assert_eq!(*g, model.gradient(*p).1, "{number} {p}");
            let h = 1e-6;
            let [slope, wider] = [h, 2.0 * h].map(|h| {
                DVec3::from(DVec3::AXES.map(|e| (model.value(p + e * h) - model.value(p - e * h)) / (2.0 * h)))
            });
            // not where pieces meet
            if (slope - wider).length() < 1e-7 * (1.0 + slope.length()) {
                assert!((*g - slope).length() < 1e-6 * (1.0 + g.length()), "{number} {p}: {g} {slope}");
                compared += 1;
            }
        }
        assert!(compared > 200, "{number}: {compared}");
    }
}
