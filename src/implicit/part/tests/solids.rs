//! Every word of the language gives the solid it says.

use super::*;
use crate::implicit::RSystem;
use approx::abs_diff_eq;

type Points = &'static [[f64; 3]];

/// The origin.
const O: [f64; 3] = [0.0; 3];

/// Solids, with points inside and outside of them.
const SOLIDS: &[(&str, Points, Points)] = &[
    ("box((2, 4, 6))", &[[0.9, 1.9, 2.9], [-0.9, -1.9, -2.9]], &[[1.1, 0.0, 0.0], [0.0, 2.1, 0.0], [0.0, 0.0, -3.1]]),
    ("box(size=[2, 2, 2], at=(3, 0, 0))", &[[2.1, 0.0, 0.0], [3.9, 0.9, 0.9]], &[O, [1.9, 0.0, 0.0]]),
    ("box(lo=(0, 0, 0), hi=(1, 2, 3))", &[[0.1, 0.1, 0.1], [0.9, 1.9, 2.9]], &[[-0.1, 1.0, 1.0], [0.5, 0.5, 3.1]]),
    ("sphere(2)", &[O, [1.9, 0.0, 0.0]], &[[2.1, 0.0, 0.0], [1.3, 1.3, 1.3]]),
    ("sphere(r=1, at=(0, 0, 5))", &[[0.0, 0.0, 5.9]], &[O, [0.0, 0.0, 6.1]]),
    ("ellipsoid((1, 2, 3))", &[[0.9, 0.0, 0.0], [0.0, 0.0, 2.9]], &[[1.1, 0.0, 0.0], [0.0, 2.1, 0.0]]),
    ("ellipsoid(radii=(1, 2, 3), at=(4, 0, 0))", &[[4.0, 1.9, 0.0]], &[O, [5.1, 0.0, 0.0]]),
    ("cylinder(1)", &[[0.9, 0.0, 8.0], [0.0, 0.0, -8.0]], &[[1.1, 0.0, 0.0]]),
    ("cylinder(1, axis='x', at=(0, 3, 0), height=4)", &[[1.9, 3.0, 0.9]], &[[2.1, 3.0, 0.0], [0.0, 1.9, 0.0]]),
    ("cylinder(1, (1, 1, 0))", &[[5.0, 5.0, 0.9]], &[[5.0, 0.0, 0.0], [5.0, 5.0, 1.1]]),
    ("cylinder(1, axis='y', height=None)", &[[0.0, 8.0, 0.9]], &[[0.0, 8.0, 1.1]]),
    ("cone(2, 1, 4)", &[[1.9, 0.0, -1.99], [0.9, 0.0, 1.9], [1.4, 0.0, 0.0]], &[[1.6, 0.0, 0.0], [0.0, 0.0, 2.1]]),
    ("cone(0, 2, 2, axis='x', at=(5, 0, 0))", &[[5.9, 1.8, 0.0], [4.1, 0.0, 0.0]], &[[4.1, 0.2, 0.0], [3.9, 0.0, 0.0]]),
    ("torus(3, 1)", &[[3.9, 0.0, 0.0], [0.0, -2.1, 0.0], [3.0, 0.0, 0.9]], &[O, [4.1, 0.0, 0.0], [3.0, 0.0, 1.1]]),
    ("torus(R=3, r=1, axis='x', at=(1, 0, 0))", &[[1.9, 0.0, 3.0]], &[[3.0, 0.0, 0.0], [2.1, 0.0, 3.0]]),
    ("half_space('x', at=(1, 0, 0))", &[[0.9, 5.0, 5.0]], &[[1.1, 0.0, 0.0]]),
    ("half_space((1, 1, 0))", &[[-1.0, 0.0, 0.0]], &[[1.0, 0.0, 0.0], [-1.0, 1.1, 0.0]]),
    ("gyroid(4, 0.5)", &[O, [2.0, 0.0, 0.0]], &[[1.0, 0.0, 0.0]]),
    ("gyroid(4, 0.5, at=(1, 0, 0))", &[[1.0, 0.0, 0.0]], &[O]),
    ("schwarz_p(period=4, thickness=0.5)", &[[1.0, 1.0, 1.0]], &[O, [2.0, 2.0, 2.0]]),
    ("diamond(4, 0.5)", &[O], &[[0.5, 0.5, 0.5]]),
    ("extrude([(0, 0), (2, 0), (0, 2)], 2)", &[[0.9, 0.9, 0.9], [0.1, 0.1, -0.9]], &[[1.1, 1.1, 0.0], [0.5, 0.5, 1.1]]),
    ("extrude(polygon([(0, 0), (0, 2), (2, 0)]), height=2, at=(1, 0, 4))", &[[1.9, 0.9, 4.9]], &[[0.9, 0.5, 4.0]]),
    (
        // the corner (1, 1) is reflex
        "extrude([(0, 0), (3, 0), (3, 1), (1, 1), (1, 3), (0, 3)], 2)",
        &[[2.9, 0.9, 0.0], [0.9, 2.9, 0.0]],
        &[[1.1, 1.1, 0.0], [2.0, 2.0, 0.0]],
    ),
    (
        "revolve([(1, 0), (2, 0), (2, 1), (1, 1)])",
        &[[0.0, 1.5, 0.5], [-1.9, 0.0, 0.9]],
        &[[0.0, 0.0, 0.5], [0.0, 1.5, -0.1]],
    ),
    ("revolve(polygon=[(0, 0), (2, 0), (0, 2)])", &[[0.0, 0.0, 1.9], [1.8, 0.0, 0.1]], &[[1.1, 0.0, 1.0]]),
    ("solid(1 - x * x - y * y - z * z >= 0)", &[[0.9, 0.0, 0.0]], &[[1.1, 0.0, 0.0]]),
    ("solid(hypot(x, y) <= 1)", &[[0.0, 0.9, 5.0]], &[[0.8, 0.8, 0.0]]),
    ("solid(0 <= x <= 1)", &[[0.5, 0.0, 0.0]], &[[-0.1, 0.0, 0.0], [1.1, 0.0, 0.0]]),
    (
        "solid(-1 < x < 2 > y > -3)",
        &[[1.9, 1.9, 0.0], [0.0, -2.9, 0.0]],
        &[[2.1, 0.0, 0.0], [0.0, 2.1, 0.0], [0.0, -3.1, 0.0]],
    ),
    ("solid(0 < 1 < x)", &[[1.1, 0.0, 0.0]], &[[0.9, 0.0, 0.0]]),
    ("solid(sphere(1))", &[O], &[[1.1, 0.0, 0.0]]),
    ("sphere(1) & (x >= 0)", &[[0.5, 0.0, 0.0]], &[[-0.5, 0.0, 0.0]]),
    ("(x > 1) | (x < -1)", &[[1.1, 0.0, 0.0], [-1.1, 0.0, 0.0]], &[O]),
    ("~(x > 1)", &[O], &[[1.1, 0.0, 0.0]]),
    ("solid((x if y >= 0 else -x) >= 1)", &[[1.1, 1.0, 0.0], [-1.1, -1.0, 0.0]], &[[-1.1, 1.0, 0.0], [1.1, -1.0, 0.0]]),
    ("solid((1 if 0 <= x <= 2 else -1) >= 0)", &[[1.0, 0.0, 0.0]], &[[-0.1, 0.0, 0.0], [2.1, 0.0, 0.0]]),
    ("sphere(1) | sphere(1, at=(5, 0, 0))", &[O, [5.0, 0.0, 0.0]], &[[2.5, 0.0, 0.0]]),
    ("sphere(2) & sphere(2, at=(2, 0, 0))", &[[1.0, 0.0, 0.0]], &[[-0.5, 0.0, 0.0], [2.5, 0.0, 0.0]]),
    ("sphere(2) - sphere(1)", &[[1.5, 0.0, 0.0]], &[O, [2.5, 0.0, 0.0]]),
    ("~sphere(2)", &[[2.1, 0.0, 0.0]], &[O]),
    ("~(sphere(1) | ~sphere(2))", &[[1.5, 0.0, 0.0]], &[O, [2.5, 0.0, 0.0]]),
    (
        "union([sphere(1, at=(3 * i, 0, 0)) for i in range(3)])",
        &[O, [6.0, 0.0, 0.0]],
        &[[1.5, 0.0, 0.0], [9.0, 0.0, 0.0]],
    ),
    ("union(sphere(1, at=(3 * i, 0, 0)) for i in [0, 2])", &[O, [6.0, 0.0, 0.0]], &[[3.0, 0.0, 0.0]]),
    ("union(sphere(1), [sphere(1, at=(3, 0, 0))], x > 8)", &[O, [3.0, 0.0, 0.0], [8.5, 0.0, 0.0]], &[[6.0, 0.0, 0.0]]),
    (
        "intersection(half_space(a) for (i, a) in enumerate('xyz') if i > 0)",
        &[[1.0, -1.0, -1.0]],
        &[[-1.0, 1.0, -1.0], [-1.0, -1.0, 1.0]],
    ),
    (
        "union(sphere(1, at=p).name(a) for (a, p) in zip('ab', [(0, 0, 0), (3, 0, 0)]) for b in list(a))",
        &[O, [3.0, 0.0, 0.0]],
        &[[1.5, 0.0, 0.0]],
    ),
    ("union(*[sphere(i) for i in (1, 2)])", &[[1.5, 0.0, 0.0]], &[[2.5, 0.0, 0.0]]),
    (
        "intersection([half_space(a) for a in ('x', 'y', 'z')])",
        &[[-1.0, -1.0, -1.0]],
        &[[1.0, -1.0, -1.0], [-1.0, -1.0, 1.0]],
    ),
    (
        "blend(sphere(1), sphere(1, at=(2.1, 0, 0)), 0.5)",
        &[O, [2.1, 0.0, 0.0], [1.05, 0.0, 0.0]],
        &[[1.05, 1.2, 0.0], [-1.1, 0.0, 0.0]],
    ),
    ("box((2, 2, 2)).move((5, 0, 0))", &[[5.9, 0.0, 0.0]], &[O]),
    ("box((2, 2, 2)).move(by=[0, 5, 0]).move((0, 0, 3))", &[[0.0, 5.0, 3.0]], &[O, [0.0, 5.0, 0.0]]),
    // counter-clockwise seen against the axis
    ("box((2, 2, 2), at=(5, 0, 0)).rotate(90)", &[[0.0, 5.0, 0.0]], &[[0.0, -5.0, 0.0], [5.0, 0.0, 0.0]]),
    ("box((2, 2, 2), at=(5, 0, 0)).rotate(-90, axis='y')", &[[0.0, 0.0, 5.0]], &[[0.0, 0.0, -5.0]]),
    ("box((2, 2, 2), at=(0, 5, 0)).rotate(90, 'x')", &[[0.0, 0.0, 5.0]], &[[0.0, 0.0, -5.0]]),
    (
        "box((2, 2, 2), at=(5, 0, 0)).rotate(120, axis=(1, 1, 1))",
        &[[0.0, 5.0, 0.0]],
        &[[0.0, 0.0, 5.0], [5.0, 0.0, 0.0]],
    ),
    (
        "box((2, 2, 2), at=(5, 0, 0)).rotate(180, at=(3, 0, 0))",
        &[[1.0, 0.0, 0.0]],
        &[[5.0, 0.0, 0.0], [-5.0, 0.0, 0.0]],
    ),
    ("box((2, 2, 2)).rotate(45)", &[[1.3, 0.0, 0.0]], &[[0.8, 0.8, 0.0]]),
    ("sphere(1, at=(2, 0, 0)).scale(2)", &[[5.9, 0.0, 0.0], [2.1, 0.0, 0.0]], &[[1.9, 0.0, 0.0]]),
    ("solid(x >= 1).scale(k=3)", &[[3.1, 0.0, 0.0]], &[[2.9, 0.0, 0.0]]),
    ("sphere(1, at=(2, 1, 0)).mirror('x')", &[[-2.0, 1.0, 0.0]], &[[2.0, 1.0, 0.0], [-2.0, -1.0, 0.0]]),
    ("sphere(1, at=(2, 0, 0)).mirror((1, 1, 0), at=(0, 0, 0))", &[[0.0, -2.0, 0.0]], &[[2.0, 0.0, 0.0]]),
    ("sphere(1, at=(2, 0, 0)).mirror(axis='x', at=(3, 0, 0))", &[[4.0, 0.0, 0.0]], &[[2.0, 0.0, 0.0]]),
    ("gyroid(4, 0.5).rotate(90).move((0, 1, 0))", &[[0.0, 1.0, 0.0]], &[[0.0, 2.0, 0.0]]),
    ("(x > 1).move((2, 0, 0)).name('wall').size(0.1)", &[[3.1, 0.0, 0.0]], &[[2.9, 0.0, 0.0]]),
];

#[test]
fn solids_are_where_they_should_be() {
    for rsystem in ["'R0'", "'minmax'", "('Ralpha', 0.5)", "('R0m', 2)"] {
        for (text, yes, no) in SOLIDS {
            let p = part(&format!("part({text}, {rsystem}, domain=((-9, -9, -9), (9, 9, 9)))"));
            let m = model(&p).unwrap_or_else(|e| panic!("{text}: {e}"));
            yes.iter().for_each(|q| assert!(inside(&m, *q), "{text} should hold {q:?}"));
            no.iter().for_each(|q| assert!(!inside(&m, *q), "{text} should not hold {q:?}"));
        }
    }
}

/// Expressions and their values, written as literals.
const VALUES: &[(&str, &str)] = &[
    ("1 + 2 * 3 - 4", "3"),
    ("7 / 2", "3.5"),
    ("6 / 2", "3.0"),
    ("[7 // 2, -7 // 2, 7 // -2, -7 // -2]", "[3, -4, -4, 3]"),
    ("[7 % 3, -7 % 3, 7 % -3, -7 % -3]", "[1, 2, -2, -1]"),
    ("[7.5 // 2, -7.5 // 2, 7.5 % 2, -7.5 % 2]", "[3.0, -4.0, 1.5, 0.5]"),
    ("2 ** 10", "1024"),
    ("2 ** -1", "0.5"),
    ("2 ** 0.5 * 2 ** 0.5 - 2 < 1e-9", "True"),
    ("-2 ** 2", "-4"),
    ("9223372036854775807 + 1", "9.223372036854775807e18"),
    ("abs(10 ** 30 / 1e30 - 1) < 1e-12", "True"),
    ("123456789012345678901234567890", "1.2345678901234568e29"),
    ("True + 0.5", "1.5"),
    ("not 0 and not 0.0 and not False", "True"),
    ("0 or 3", "3"),
    ("2 and 3", "3"),
    // what is behind the deciding value is not looked at
    ("1 or 1 / 0", "1"),
    ("0 and 1 / 0", "0"),
    ("3 if 1 < 2 <= 2 != 3 == 3 >= 3 else 1 / 0", "3"),
    ("'a' == 'a' and 'a' != 'b'", "True"),
    ("(1, 2) + (3,)", "(1, 2, 3)"),
    ("([1] + [2, 3]) * 2", "[1, 2, 3, 1, 2, 3]"),
    ("[1] * -1", "[]"),
    ("(1, 2, 3)[1] + [4, 5][-1]", "7"),
    ("[1, 2, 3, 4, 5][1:4]", "[2, 3, 4]"),
    ("[1, 2, 3, 4, 5][::-2]", "[5, 3, 1]"),
    ("[1, 2, 3, 4, 5][-2:] + [1, 2, 3][:-1] + [1, 2, 3][5:] + [1, 2, 3][-9:1]", "[4, 5, 1, 2, 1]"),
    ("(1, 2, 3)[::-1]", "(3, 2, 1)"),
    ("[1, 2][9223372036854775807::-9223372036854775807]", "[2]"),
    ("range(3)", "[0, 1, 2]"),
    ("range(1, 3)", "[1, 2]"),
    ("range(7, 1, -3)", "[7, 4]"),
    ("range(3, 1)", "[]"),
    ("len([1, 2]) + len((1,)) + len('häh') + len(range(0))", "6"),
    ("sum([1, 2, 3])", "6"),
    ("sum([0.5, 1])", "1.5"),
    ("list(enumerate('a' + 'b' for i in range(1)))", "[(0, 'ab')]"),
    ("zip([1, 2, 3], (4, 5))", "[(1, 4), (2, 5)]"),
    ("tuple([1, 2])", "(1, 2)"),
    ("list((1, 2))", "[1, 2]"),
    ("[int(2.9), int(-2.9), round(2.5), round(3.5), floor(-0.5), ceil(0.5)]", "[2, -2, 2, 4, -1, 1]"),
    ("round(3.14159, 2)", "3.14"),
    ("float(2)", "2.0"),
    ("str(2) + str(2.5) + str(True) + str('a')", "'22.5Truea'"),
    ("f'{1 + 1}-{2.5}-{{{\"q\"}}}' 'tail'", "'2-2.5-{q}tail'"),
    ("f'a' 'b' f\"{f'{1}'}\"", "'ab1'"),
    ("degrees(pi)", "180.0"),
    ("radians(180) == pi", "True"),
    ("[min(2, 1, 3), max([2, 1, 3]), abs(-2), min((1, 2))]", "[1, 3, 2, 1]"),
    ("[min(2, 1.5), max(1, 2.5), abs(-2.5)]", "[1.5, 2.5, 2.5]"),
    ("[sqrt(4), exp(0), log(1), sin(0), cos(0), tan(0)]", "[2.0, 1.0, 0.0, 0.0, 1.0, 0.0]"),
    ("[atan2(0, 1), hypot(3, 4), pow(2, 3)]", "[0.0, 5.0, 8.0]"),
    ("[i * j for i in range(3) if i for j in (i, 10) if j > 1]", "[10, 4, 20]"),
    ("[a + b for a, (b, c) in [(1, (2, 3)), (4, (5, 6))]]", "[3, 9]"),
    ("[[j for j in range(i)] for i in range(3)]", "[[], [0], [0, 1]]"),
    ("1 if True else nobody", "1"),
];

/// The elements of nested lists side by side: `str` knows no lists.
fn assert_same(value: &str, wanted: &str) {
    let source = format!(
        "def same(a, b):\n    return str(a) == str(b)\n\
         v = [{value}]\nw = [{wanted}]\nok = len(v) == len(w)\n\
         part(sphere(1 if {} else -1))\n",
        compare(wanted, "v[0]", "w[0]")
    );
    parse(&source, &[]).unwrap_or_else(|e| panic!("{value} is not {wanted}: {e}"));
}

/// A comparison of two values of the shape that `wanted` has.
fn compare(wanted: &str, v: &str, w: &str) -> String {
    let Some(inner) = wanted.strip_prefix(['[', '(']) else { return format!("same({v}, {w})") };
    let (mut depth, mut items) = (0, usize::from(!inner.starts_with([']', ')'])));
    let mut starts = vec![0];
    for (i, c) in inner.char_indices().take(inner.len() - 1) {
        match c {
            '[' | '(' => depth += 1,
            ']' | ')' if depth == 0 => break,
            ']' | ')' => depth -= 1,
            ',' if depth == 0 && !inner[i + 1..].starts_with(')') => {
                items += 1;
                starts.push(i + 1);
            }
            _ => {}
        }
    }
    let mut all = format!("len({v}) == {items} and len({w}) == {items}");
    for i in 0..items {
        all +=
            &format!(" and {}", compare(inner[starts[i]..].trim_start(), &format!("{v}[{i}]"), &format!("{w}[{i}]")));
    }
    all
}

#[test]
fn expressions_have_the_values_of_python() {
    for (value, wanted) in VALUES {
        assert_same(value, wanted);
    }
}

#[test]
fn functions_see_their_parameters_and_the_globals() {
    for (source, radius) in [
        ("def f(a, b=2):\n    return a * b\nr = f(3)", 6),
        ("def f(a, b=2):\n    return a * b\nr = f(b=4, a=3)", 12),
        ("def f(a, *, b):\n    'doc'\n    return a - b\nr = f(7, b=2)", 5),
        ("def f(a, b):\n    return a - b\nr = f(*(7, 3))", 4),
        ("k = 2\ndef f(a):\n    return a * k\nk = 5\nr = f(1)", 5),
        // a default is what it was when the function was written, not what the caller calls by that name
        ("a = 1\ndef f(b=a):\n    return b\ndef g(a):\n    return f()\na = 9\nr = g(5)", 1),
        // the caller's names are not seen
        ("a = 3\ndef f():\n    return a\nr = [f() for a in [7]][0]", 3),
        ("def f(n):\n    return 1 if n == 0 else n * f(n - 1)\nr = f(4)", 24),
        ("i = 4\nl = [i for i in range(3)]\nr = i", 4),
        ("a, (b, c) = 1, [2, 3]\n[d, e] = (4, 5)\nr = a + b + c + d + e", 15),
        ("r = q = 3; pass\n'a string is a comment'\n\"\"\"so is\nthis\"\"\"", 3),
        ("r = (1 +\n     2)  # as long as brackets are open", 3),
    ] {
        let m = model(&part(&format!("{source}\npart(sphere(r))"))).unwrap();
        assert!(
            abs_diff_eq!(m.bounds().size().x, 2.0 * f64::from(radius), epsilon = 0.5),
            "{source}: {:?}",
            m.bounds()
        );
    }
}

#[test]
fn formulas_have_the_values_of_their_functions() {
    let (x, y, z) = (0.7f64, 0.4f64, -0.3f64);
    for (text, v) in [
        ("sqrt(x)", x.sqrt()),
        ("exp(x) - log(y)", x.exp() - y.ln()),
        ("sin(x) + cos(y) * tan(z)", x.sin() + y.cos() * z.tan()),
        ("atan2(y, z)", y.atan2(z)),
        ("hypot(x, z)", x.hypot(z)),
        ("abs(z) + min(x, y, z) - max([x, y])", -x),
        ("pow(x, 3) + y ** 2 + x ** y + 2 ** z", x.powi(3) + y * y + x.powf(y) + 2f64.powf(z)),
        ("-x / y + +z", -x / y + z),
        ("sum([x, y, 1])", x + y + 1.0),
        ("2 * (x if z < 0 else y)", 2.0 * x),
        ("x if x > y > z else y", x),
        ("x if y > x > z else y", y),
    ] {
        let above = |shift: f64| {
            let p = part(&format!(
                "part(solid(({text}) - {v:?} >= {shift:?}), domain=((0.6, 0.3, -0.4), (0.8, 0.5, -0.2)))"
            ));
            model(&p).is_ok_and(|m| inside(&m, [x, y, z]))
        };
        assert!(above(-1e-9) && !above(1e-9), "{text} is not {v}");
    }
}

#[test]
fn names_sizes_and_groups_are_kept() {
    let p = part(
        "units('mm')\nmesh(size='3%')\nmesh()\n\
         a = (box((2, 2, 2)).name('body').size(0.2) - cylinder(0.3).name('bore')).name('outer')\n\
         b = sphere(1, at=(9, 0, 0)).size(0.1).size(0.3)\n\
         part(solid=a | b | sphere(1, at=(0, 9, 0)) | extrude([(5, 5), (6, 5), (5, 6)], 1).name('e'))\n\
         group('all', faces('body.*', 'bore'))\ngroup(name='one', faces='body.xmin')\ngroup('two', faces('a') | faces('b') + faces(\"c\"))\n",
    );
    assert_eq!((p.units.as_deref(), p.mesh.size), (Some("mm"), Some(SizeRequest::Share(0.03))));
    let groups: Vec<(&str, Vec<&str>)> =
        p.groups.iter().map(|g| (g.name.as_str(), g.patterns.iter().map(String::as_str).collect())).collect();
    assert_eq!(groups, [("all", vec!["body.*", "bore"]), ("one", vec!["body.xmin"]), ("two", vec!["a", "b", "c"])]);
    assert!(matches!(p.groups[1].place, Place::Text { line: 8, column: 1, .. }), "{:?}", p.groups[1].place);
    let m = model(&p).unwrap();
    let size = |name: &str| {
        m.faces().iter().find(|f| f.name == name).unwrap_or_else(|| panic!("{name} in {:?}", m.faces())).size
    };
    for sub in ["xmin", "xmax", "ymin", "ymax", "zmin", "zmax"] {
        assert_eq!(size(&format!("body.{sub}")), Some(0.2));
    }
    // the innermost size and name win, and what has no name is called by its kind
    assert_eq!((size("bore"), size("sphere1"), size("sphere2")), (None, Some(0.1), None));
    for sub in ["side0", "side1", "side2", "bottom", "top"] {
        size(&format!("e.{sub}"));
    }
    assert_eq!(m.faces().len(), 6 + 1 + 2 + 5);
}

#[test]
fn what_a_part_is_told_is_kept() {
    for (text, wanted) in [
        ("'R0'", RSystem::R0),
        ("None", RSystem::R0),
        ("'minmax'", RSystem::MinMax),
        ("('Ralpha', 1)", RSystem::RAlpha(1.0)),
        ("('R0m', 8)", RSystem::R0m(8)),
    ] {
        assert_eq!(part(&format!("part(sphere(1), rsystem={text})")).rsystem, wanted);
    }
    for unit in ["m", "dm", "cm", "mm", "um", "in", "ft"] {
        assert_eq!(part(&format!("units({unit:?})\npart(sphere(1))")).units.as_deref(), Some(unit));
    }
    assert_eq!(part("mesh(size=1/4)\npart(sphere(1))").mesh.size, Some(SizeRequest::Length(0.25)));
    let p = part("part(cylinder(1), domain=[[-2, -2, -3], (2, 2, 4)])");
    assert_eq!(p.domain, Some(Aabb::new(DVec3::new(-2.0, -2.0, -3.0), DVec3::new(2.0, 2.0, 4.0))));
    let m = model(&p).unwrap();
    assert!(m.faces().iter().any(|f| f.name == "domain.zmax"));
    assert!(inside(&m, [0.0, 0.0, 3.9]) && !inside(&m, [0.0, 0.0, 4.1]));
    // no name is taken: a file may call its own things what it likes
    assert!(inside(&model(&part("box = sphere(1)\nx = 2\npart(box.move((x, 0, 0)))")).unwrap(), [2.5, 0.0, 0.0]));
}
