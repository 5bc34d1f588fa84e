//! What is taken apart is the same solid, in so many leaves.

use glam::DVec3;

use super::*;
use crate::implicit::{Implicit, RSystem};
use crate::spatial::Aabb;

fn abs(e: Expr) -> Expr {
    Expr::unary(Unary::Abs, e)
}

fn sqrt(e: Expr) -> Expr {
    Expr::unary(Unary::Sqrt, e)
}

fn square(e: Expr) -> Expr {
    e.clone() * e
}

fn hypot(a: Expr, b: Expr) -> Expr {
    Expr::binary(Binary::Hypot, a, b)
}

fn r_and(f: Expr, g: Expr, alpha: f64) -> Expr {
    let under = square(f.clone()) + square(g.clone()) - f.clone() * (g.clone() * (2.0 * alpha));
    (f + g - sqrt(under)) / (1.0 + alpha)
}

fn r_or(f: Expr, g: Expr, alpha: f64) -> Expr {
    -r_and(-f, -g, alpha)
}

fn angle(y: Expr, x: Expr) -> Expr {
    Expr::binary(Binary::Atan2, y, x)
}

/// How far an angle is from a whole number of turns.
fn wave(t: Expr) -> Expr {
    abs(angle(Expr::unary(Unary::Sin, t.clone()), Expr::unary(Unary::Cos, t)))
}

#[test]
fn what_is_split_is_the_same_solid() {
    let (x, y, z) = (Expr::x(), Expr::y(), Expr::z());
    let max = |a: Expr, b: Expr| Expr::binary(Binary::Max, a, b);
    let (radius, turn) = (hypot(x.clone(), y.clone()), angle(y.clone(), x.clone()) * 3.0 - z.clone() * 2.0);
    let (zero, min) = (Expr::constant(0.0), |a: Expr, b: Expr| Expr::binary(Binary::Min, a, b));
    let far = [abs(x.clone()) - 0.8, abs(y.clone()) - 0.5, abs(z.clone()) - 0.4];
    let boxed = max(far[0].clone(), max(far[1].clone(), far[2].clone()));
    let over = |e: &Expr| max(e.clone(), Expr::constant(0.0));
    let arc = angle(Expr::unary(Unary::Sin, turn.clone()), Expr::unary(Unary::Cos, turn)) / -3.0 * radius.clone() * 0.9;
    let cases = [
        (-max(abs(x.clone()), max(abs(y.clone()), abs(z.clone()))) + 0.7, 6),
        ((abs(x.clone()) * -2.0 + 1.0) / 3.0 - y.clone() * y.clone(), 2),
        (Expr::select(x.clone(), y.clone() - 0.2, z.clone() + 0.1), 3),
        (Expr::constant(0.5) - abs(abs(z.clone()) - 0.6), 4),
        (Expr::constant(0.9) - (abs(x.clone()) + abs(y.clone()) + abs(z.clone()) * 2.0), 8),
        (Expr::constant(0.5) - Expr::unary(Unary::Sqrt, abs(x.clone())), 2),
        (x.clone() * (abs(y.clone()) - 0.3), 3),
        (r_and(x.clone() + 0.3, r_or(y.clone() - 0.2, z.clone() + 0.1, 0.0), 0.0), 3),
        // Distances as they are commonly written, to a box and to a cylinder.
        (-(min(boxed.clone(), zero.clone()) + hypot(hypot(over(&far[0]), over(&far[1])), over(&far[2]))), 6),
        (
            min(max(radius.clone() - 0.6, far[2].clone()), zero.clone()) * -2.0
                - sqrt(square(over(&(radius.clone() - 0.6))) + square(over(&far[2]))) * 3.0,
            3,
        ),
        // The same, walked on inward, and a step outward: there what is beyond the faces is smooth.
        (-(min(boxed.clone(), zero.clone()) + hypot(hypot(over(&far[0]), over(&far[1])), over(&far[2]))) - 0.1, 6),
        (-(min(boxed, zero) + hypot(hypot(over(&far[0]), over(&far[1])), over(&far[2]))) + 0.1, 1),
        // A square beside a number is two planes.
        (r_and(r_or(x.clone() + 0.3, y.clone() * 2.0 - 0.2, 0.5), z.clone() * z.clone() - 0.1, -0.3) / 0.7, 4),
        (-r_or(x.clone() * y.clone() - 0.3, z.clone(), 0.0) * 2.0, 2),
        (r_and(x.clone(), y.clone(), 0.0) * sqrt(square(x.clone()) + square(y.clone())), 2),
        (hypot(x.clone(), y.clone()) + x.clone() + y.clone(), 2),
        (-hypot(x.clone(), y.clone()) - 0.3 + (x.clone() + y.clone()) + 0.3, 2),
        // Weighted: a wedge between two other planes, as 2 x + 2 y >= sqrt(x^2 + y^2) and kin.
        ((x.clone() + y.clone()) * 2.0 - sqrt(square(x.clone()) + square(y.clone())), 2),
        (x.clone() * 0.3 + y.clone() * 0.2 + sqrt(square(x.clone()) * 2.0 + square(y.clone()) * 3.0), 1),
        (x.clone() * 3.0 - y.clone() + sqrt(square(x.clone()) + square(y.clone()) * 0.5), 2),
        // Values near an R-operation matter, not only its sign: it stays whole.
        (r_and(x.clone(), y.clone(), 0.0) + 0.1, 1),
        // The cone around three axes is smooth: no R-operation of three.
        (x.clone() + y.clone() + z.clone() - sqrt(square(x.clone()) + square(y.clone()) + square(z.clone())), 1),
        // Angles without sign: sectors, triangle waves, both ways round.
        (Expr::constant(0.5) - abs(angle(y.clone(), x.clone())), 4),
        (abs(angle(y.clone(), x.clone())) - 1.9 + z.clone() * z.clone(), 4),
        (Expr::constant(0.4) - wave(z.clone() * 7.0) * 0.2 - square(x.clone()) - square(y.clone()), 4),
        (wave(x.clone() * 5.0 - angle(y.clone(), x.clone()) * 3.0) * 0.2 + z.clone() - 0.3, 4),
        // The width of spiral arms is an arc.
        (Expr::constant(0.2) - abs(arc), 4),
        // The absolute value alone stands beside the radius.
        (Expr::constant(0.2) - wave(z.clone() * 5.0 - angle(y.clone(), x.clone())) * hypot(x.clone(), y.clone()), 4),
        (Expr::constant(0.3) - abs(z.clone()) * sqrt(square(x.clone()) + 0.2), 2),
        // By what is never negative.
        (Expr::constant(0.2) - abs(angle(y.clone(), x.clone()) - 0.3) * square(z.clone()) * 0.6, 6),
        (z.clone() - (abs(x.clone()) - abs(y.clone()) * 0.5) / (square(z.clone()) + 1.0), 4),
        (abs(x.clone()) * abs(y.clone()) + max(x.clone(), z.clone()) - (abs(y.clone()) - 0.2), 10),
        // Deep inside.
        (abs(x.clone()) * abs(y.clone()) + x.clone() - 0.5, 4),
        // Creases that no zeros come near to are none of the surface.
        (abs(x.clone()) * abs(y.clone()) - 0.5, 1),
        (Expr::constant(0.5) - square(abs(x.clone()) - 0.6) - square(y.clone()) - square(z.clone()), 3),
        (Expr::constant(0.9) - square(Expr::select(y.clone(), z.clone(), x.clone() * 2.0)) - square(x.clone()), 5),
        // A wall without an end in sight.
        (square(Expr::select(x.clone(), Expr::constant(1.0), Expr::constant(0.2))) - 0.5 + y.clone() * 0.1, 3),
        (z.clone() - 0.2 + square(max(x.clone(), y.clone()) * 0.7 + 0.3), 3),
    ];
    let domain = Aabb::new(DVec3::splat(-1.1), DVec3::splat(1.2));
    for (e, leaves) in cases {
        let whole = Implicit::new(&Solid::formula(e.clone()), RSystem::R0, Some(domain)).unwrap();
        let model = match split(&e) {
            Some(parts) => Implicit::new(&parts, RSystem::R0, Some(domain)).unwrap(),
            None => whole.clone(),
        };
        assert_eq!(model.leaf_count(), whole.leaf_count(), "{e:?}");
        // Six are the domain's walls.
        let found = model.leaf_count() - 6;
        assert!(found <= leaves && (found > 1 || leaves == 1), "{found} leaves: {e:?}");
        let n = 13;
        for i in 0..n * n * n {
            let p = DVec3::new(f64::from(i % n), f64::from(i / n % n), f64::from(i / n / n)) / 6.07 - 1.0;
            let f = |p: DVec3| {
                let c = crate::implicit::formula::Formula::compile(&e, &crate::implicit::Placement::IDENTITY);
                c.gradient(p).v
            };
            assert_eq!(model.inside(p), f(p) >= 0.0, "{e:?} {p}");
        }
    }
    // Nothing to take apart, or nothing that can be.
    assert!(split(&(x.clone() * y.clone() - 1.0)).is_none());
    assert!(split(&(Expr::unary(Unary::Sqrt, x.clone() * x.clone() + y.clone() * y.clone()) - 0.5)).is_none());
    // What is not defined on the other side of its crease.
    assert!(split(&(Expr::binary(Binary::Pow, abs(x), Expr::constant(0.8)) * y - 0.5)).is_none());
}

#[test]
fn odd_powers_of_sizes_have_no_crease() {
    // Superellipsoids: |u|^3 is written |u| * u^2, whose slope is none where u is zero. |u| * v^2 has a crease.
    let size = |e: Expr, a: f64| Expr::unary(Unary::Abs, e / a);
    for power in [3.0, 5.0] {
        let of = |e: Expr, a: f64| Expr::binary(Binary::Pow, size(e, a), Expr::constant(power));
        let body = Expr::constant(1.0) - of(Expr::x(), 2.0) - of(Expr::y(), 1.5) - of(Expr::z(), 1.0);
        let model = Implicit::new(&Solid::formula(body), RSystem::MinMax, None).unwrap();
        assert_eq!(model.leaf_count(), 1, "{power}");
        for (p, inside) in [([1.9, 0.0, 0.0], true), ([1.8, 1.3, 0.9], false), ([0.0, -1.45, -0.3], true)] {
            assert_eq!(model.inside(DVec3::from_array(p)), inside, "{p:?}");
        }
    }
    let creased = Expr::constant(1.0) - size(Expr::x(), 1.0) * (Expr::y() * Expr::y() + 1.0) - Expr::y() * Expr::y();
    let creased = creased - Expr::z() * Expr::z();
    assert_eq!(Implicit::new(&Solid::formula(creased), RSystem::MinMax, None).unwrap().leaf_count(), 2);
    // So has what is inside of a power: both sides, and the plane between them.
    let inside = Expr::binary(Binary::Pow, abs(abs(Expr::x()) - 0.5), Expr::constant(3.0));
    let waist = Expr::constant(0.2) - inside - square(Expr::y()) - square(Expr::z());
    assert_eq!(Implicit::new(&Solid::formula(waist), RSystem::MinMax, None).unwrap().leaf_count(), 3);
}
