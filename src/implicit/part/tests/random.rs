//! Whatever the text, the answer is a part or an error.

use proptest::prelude::*;

use super::*;

/// Evaluations, items and nodes are bounded, but a random text may still ask for more than a test has time for.
const SHORT: usize = 400;

/// The language's own words, and some that are not.
const WORDS: &[&str] = &[
    "x",
    "y",
    "z",
    "pi",
    "a",
    "b",
    "f",
    "i",
    "0",
    "1",
    "2",
    "-1",
    "0.5",
    "1e300",
    "9223372036854775807",
    "'x'",
    "''",
    "f'{a}'",
    "\"",
    "'",
    "True",
    "None",
    "sqrt",
    "log",
    "min",
    "abs",
    "box",
    "sphere",
    "cylinder",
    "cone",
    "torus",
    "half_space",
    "gyroid",
    "polygon",
    "extrude",
    "revolve",
    "solid",
    "union",
    "blend",
    "units",
    "part",
    "group",
    "faces",
    "mesh",
    "range",
    "len",
    "sum",
    "zip",
    "int",
    "round",
    "str",
    "list",
    ".move",
    ".rotate",
    ".scale",
    ".mirror",
    ".name",
    ".size",
    "(",
    ")",
    "(",
    ")",
    "[",
    "]",
    "{",
    "}",
    ",",
    ",",
    ":",
    "=",
    "==",
    ">=",
    "<",
    "+",
    "-",
    "*",
    "**",
    "/",
    "//",
    "%",
    "&",
    "|",
    "~",
    "@",
    ".",
    ";",
    "\n",
    "\n",
    "\n    ",
    "\t",
    "\\\n",
    "#",
    " if ",
    " else ",
    " for ",
    " in ",
    " and ",
    " or ",
    "not ",
    "def f(a):\n    return ",
    "lambda a: ",
    "import ",
    "while ",
    "yield ",
    "part(sphere(1))\n",
    "a = ",
    "ä",
    "\u{feff}",
    "\0",
    "\r",
];

/// Reads a text and, if it is a part, makes the model ready.
fn survives(source: &str) {
    if let Ok(p) = parse(source, &[]) {
        let _ = model(&p);
    }
}

fn number() -> impl Strategy<Value = String> {
    prop_oneof![
        4 => (-30i32..30).prop_map(|v| format!("{:?}", f64::from(v) / 10.0)),
        1 => prop::sample::select(vec!["0", "1", "-1", "pi", "1e-9", "1e9", "1e150", "1e-150", "1e308", "5e-324"])
            .prop_map(String::from),
    ]
}

fn vector() -> impl Strategy<Value = String> {
    (number(), number(), number()).prop_map(|(a, b, c)| format!("({a}, {b}, {c})"))
}

fn formula() -> impl Strategy<Value = String> {
    let leaf = prop_oneof![prop::sample::select(vec!["x", "y", "z"]).prop_map(String::from), number()];
    leaf.prop_recursive(5, 30, 3, |f| {
        let one = prop::sample::select(vec!["sqrt", "exp", "log", "sin", "cos", "tan", "abs", "-", "+"]);
        let two = prop::sample::select(vec!["+", "-", "*", "/", "**"]);
        let named = prop::sample::select(vec!["atan2", "hypot", "pow", "min", "max"]);
        prop_oneof![
            (one, f.clone()).prop_map(|(o, a)| format!("{o}({a})")),
            (f.clone(), two, f.clone()).prop_map(|(a, o, b)| format!("({a} {o} {b})")),
            (named, f.clone(), f.clone()).prop_map(|(o, a, b)| format!("{o}({a}, {b})")),
            (f.clone(), f.clone(), f.clone()).prop_map(|(a, b, c)| format!("({a} if {b} > {c} else {a})")),
        ]
    })
}

fn primitive() -> impl Strategy<Value = String> {
    let axis = prop_oneof![prop::sample::select(vec!["'x'", "'y'", "'z'"]).prop_map(String::from), vector()].boxed();
    let points = prop::collection::vec((number(), number()), 3..7)
        .prop_map(|p| p.iter().map(|(a, b)| format!("({a}, {b}), ")).collect::<String>())
        .boxed();
    prop_oneof![
        vector().prop_map(|v| format!("box({v})")),
        (vector(), vector()).prop_map(|(a, b)| format!("box(lo={a}, hi={b})")),
        (number(), vector()).prop_map(|(r, v)| format!("sphere({r}, {v})")),
        vector().prop_map(|v| format!("ellipsoid({v})")),
        (number(), axis.clone(), vector()).prop_map(|(r, a, v)| format!("cylinder({r}, {a}, {v})")),
        (number(), axis.clone(), number()).prop_map(|(r, a, h)| format!("cylinder({r}, {a}, height={h})")),
        (number(), number(), number(), axis.clone()).prop_map(|(r, s, h, a)| format!("cone({r}, {s}, {h}, {a})")),
        (number(), number(), axis.clone()).prop_map(|(r, s, a)| format!("torus({r}, {s}, {a})")),
        (axis, vector()).prop_map(|(a, v)| format!("half_space({a}, {v})")),
        (number(), number()).prop_map(|(p, t)| format!("diamond({p}, {t})")),
        (points.clone(), number()).prop_map(|(p, h)| format!("extrude([{p}], {h})")),
        points.prop_map(|p| format!("revolve([{p}])")),
        (formula(), formula()).prop_map(|(a, b)| format!("solid({a} >= {b} + 0 * x)")),
    ]
}

fn solid() -> impl Strategy<Value = String> {
    primitive().prop_recursive(5, 16, 3, |s| {
        prop_oneof![
            (s.clone(), prop::sample::select(vec!["&", "|", "-"]), s.clone())
                .prop_map(|(a, o, b)| format!("({a} {o} {b})")),
            s.clone().prop_map(|a| format!("(~{a})")),
            (s.clone(), vector()).prop_map(|(a, v)| format!("{a}.move({v})")),
            (s.clone(), number(), vector()).prop_map(|(a, d, v)| format!("{a}.rotate({d}, {v}).name('n').size(1)")),
            (s.clone(), number()).prop_map(|(a, k)| format!("{a}.scale({k})")),
            (s.clone(), vector()).prop_map(|(a, v)| format!("{a}.mirror({v}, at={v})")),
            (s.clone(), s.clone(), number()).prop_map(|(a, b, r)| format!("blend({a}, {b}, {r})")),
            (s.clone(), s.clone()).prop_map(|(a, b)| format!("union([s for s in ({a}, {b})])")),
            (s.clone(), s).prop_map(|(a, b)| format!("intersection({a}, {b})")),
        ]
    })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 300, ..ProptestConfig::default() })]

    #[test]
    fn bytes_are_read_or_refused(bytes in prop::collection::vec(any::<u8>(), 0..SHORT)) {
        survives(&String::from_utf8_lossy(&bytes));
    }

    #[test]
    fn words_are_read_or_refused(words in prop::collection::vec(prop::sample::select(WORDS), 0..60)) {
        survives(&words.concat());
        survives(&format!("{}\npart(sphere(1))\n", words.join(" ")));
    }

    #[test]
    fn broken_texts_are_read_or_refused(at in 0usize..2_000, word in prop::sample::select(WORDS), cut in 0usize..40) {
        let source = include_str!("../../../../data/bracket.py");
        let at = (0..=at % source.len()).rev().find(|i| source.is_char_boundary(*i)).unwrap_or(0);
        let end = (at + cut..=source.len()).find(|i| source.is_char_boundary(*i)).unwrap_or(source.len());
        survives(&format!("{}{word}{}", &source[..at], &source[end..]));
    }

    #[test]
    fn trees_are_lowered_or_refused(s in solid(), domain: bool, rsystem in 0usize..4) {
        let rsystem = ["'R0'", "'minmax'", "('Ralpha', -0.5)", "('R0m', 3)"][rsystem];
        let domain = if domain { ", domain=((-2, -2, -2), (2, 2, 2))" } else { "" };
        let source = format!("part({s}, {rsystem}{domain})");
        match parse(&source, &[]) {
            Err(e) => prop_assert!(matches!(e, Error::Input { place: Place::Text { line: 1, .. }, .. }), "{}", e),
            Ok(p) => {
                if let Ok(m) = model(&p) {
                    let c = m.bounds().center();
                    let _ = (m.inside(c), m.value(c), m.gradient(c));
                }
            }
        }
    }
}
