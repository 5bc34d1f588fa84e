//! What the part language says, refuses, and stands.

mod errors;
mod random;
mod solids;

use std::fs;

use glam::DVec3;

use super::*;
use crate::implicit::Implicit;
use crate::sizing::SizeRequest;

/// Marks the place an error must name; not part of the text.
const MARK: char = '¦';

fn part(source: &str) -> Part {
    parse(source, &[]).unwrap_or_else(|e| panic!("{source}\n{e}"))
}

fn model(part: &Part) -> Result<Implicit> {
    Implicit::new(part.solid.as_ref().unwrap(), part.rsystem, part.domain)
}

fn inside(model: &Implicit, p: [f64; 3]) -> bool {
    let p = DVec3::from_array(p);
    assert_eq!(model.inside(p), model.value(p) > 0.0, "sign and value disagree at {p}");
    model.inside(p)
}

/// Parses texts with [`MARK`] in them and expects errors there that say what stands beside them.
fn fail<S: AsRef<str>>(cases: &[(S, S)]) {
    let wrong: Vec<String> = cases.iter().filter_map(|(m, s)| fails(m.as_ref(), s.as_ref()).err()).collect();
    assert!(wrong.is_empty(), "{} of {}:\n\n{}", wrong.len(), cases.len(), wrong.join("\n\n"));
}

fn fails(marked: &str, says: &str) -> std::result::Result<(), String> {
    let head: String = marked.chars().take(200).collect();
    let (before, after) = marked.split_once(MARK).ok_or_else(|| format!("{head}\nhas no mark"))?;
    let wanted = (
        1 + before.matches('\n').count(),
        1 + before.rsplit('\n').next().unwrap_or_default().chars().count(),
        before.len(),
    );
    match parse(&format!("{before}{after}"), &[]) {
        Err(e @ Error::Input { place: Place::Text { line, column, offset, .. }, .. }) => {
            let text = message(&e);
            if (line, column, offset) != wanted {
                return Err(format!("{head}\nat {line}:{column} ({offset}), not {wanted:?}: {text}"));
            }
            if text.contains(says) { Ok(()) } else { Err(format!("{head}\nsays {text:?}, not {says:?}")) }
        }
        other => Err(format!("{head}\ngives {:?}", other.map(|_| ()))),
    }
}

/// The message and the help.
fn message(e: &Error) -> String {
    match e {
        Error::Input { message, help, .. } => format!("{message}\n{}", help.as_deref().unwrap_or_default()),
        other => other.to_string(),
    }
}

#[test]
fn sizes_are_lengths_or_shares() {
    for (text, wanted) in [
        ("0.1", Some(SizeRequest::Length(0.1))),
        (" 3 ", Some(SizeRequest::Length(3.0))),
        ("1e-3", Some(SizeRequest::Length(1e-3))),
        ("2%", Some(SizeRequest::Share(0.02))),
        (" 2.5 % ", Some(SizeRequest::Share(0.025))),
        ("-1", None),
        ("-1%", None),
        ("0", None),
        ("0%", None),
        ("nan", None),
        ("inf", None),
        ("inf%", None),
        ("", None),
        ("%", None),
        ("2%%", None),
        ("2 mm", None),
    ] {
        match (text.parse::<SizeRequest>(), wanted) {
            (Ok(v), Some(w)) => assert_eq!(v, w, "{text}"),
            (Err(Error::Usage(m)), None) => assert!(m.contains(&format!("{text:?}")), "{m}"),
            (other, _) => panic!("{text}: {other:?}"),
        }
    }
}

#[test]
fn patterns_fit_names() {
    for (pattern, fit, not) in [
        ("body.xmin", &["body.xmin"][..], &["body.xmax", "body", ""][..]),
        ("bolt_*", &["bolt_", "bolt_1", "bolt_*"], &["a_bolt_1", "bolt"]),
        ("*", &["", "a", "äö.x"], &[]),
        ("*.zm?n", &["a.zmin", ".zmun", "a.b.zmin"], &["a.zmn", "zmin", "a.zminn"]),
        ("a*b*c", &["abc", "aXbYc", "abcbc"], &["ab", "acb", "xabc"]),
        ("?", &["ä"], &["", "ab"]),
        ("**a**", &["a", "bab"], &["b", ""]),
        ("", &[""], &["a"]),
        ("[ab]", &["[ab]"], &["a"]),
    ] {
        fit.iter().for_each(|n| assert!(glob(pattern, n), "{pattern} {n}"));
        not.iter().for_each(|n| assert!(!glob(pattern, n), "{pattern} {n}"));
    }
    // many stars must not take exponential time
    assert!(!glob(&"a*".repeat(30), &"a".repeat(29)));
    assert!(!glob(&format!("{}b", "*a".repeat(200)), &"a".repeat(5_000)));
}

#[test]
fn overrides_replace_numbers_at_top_level() {
    let source = "a = b = 1\nc = 2.5\nc = 4\nname = 'n'\nflag = True\nt = (1, 2)\np, q = 1, 2\n\
                  def f(r):\n    return r\ns = [i for i in range(3)]\npart(sphere(a).move((10 * b, 100 * c, 0)))\n";
    let center = |overrides: &[(&str, f64)]| {
        let all: Vec<(String, f64)> = overrides.iter().map(|(n, v)| (n.to_string(), *v)).collect();
        let b = model(&parse(source, &all).unwrap()).unwrap().bounds();
        let (c, s) = (b.center(), b.size());
        [0.5 * s.x, c.x, c.y].map(|v| v.round())
    };
    assert_eq!(center(&[]), [1.0, 10.0, 400.0]);
    assert_eq!(center(&[("a", 2.0)]), [2.0, 10.0, 400.0]);
    assert_eq!(center(&[("b", 2.0)]), [1.0, 20.0, 400.0]);
    // every assignment of the name is replaced, and of two overrides the last one counts
    assert_eq!(center(&[("c", 7.0), ("c", 9.0)]), [1.0, 10.0, 900.0]);
    for name in ["nobody", "name", "flag", "t", "p", "f", "r", "i", "s", "pi", "x", "sphere", ""] {
        let e = parse(source, &[(name.to_string(), 1.0)]).unwrap_err();
        assert!(matches!(e, Error::Usage(_)) && e.exit_code() == 2, "{name}: {e}");
        let text = e.to_string();
        assert!(text.contains(&format!("-D {name}:")) && text.contains("there are: a, b, c"), "{text}");
    }
    for v in [f64::NAN, f64::INFINITY] {
        let e = parse(source, &[("a".to_string(), v)]).unwrap_err();
        assert!(matches!(&e, Error::Usage(m) if m.contains("finite")), "{e}");
    }
    let e = parse("part(sphere(1))", &[("a".to_string(), 1.0)]).unwrap_err();
    assert!(e.to_string().contains("there are none"), "{e}");
}

#[test]
fn an_override_by_a_whole_number_counts_things() {
    let n = [("n".to_string(), 3.0)];
    let p = parse("n = 1\npart(union([sphere(1, at=(3 * i, 0, 0)) for i in range(n)]))", &n).unwrap();
    assert!(inside(&model(&p).unwrap(), [6.0, 0.0, 0.0]));
    let e = parse("n = 1\npart(union([sphere(1) for i in range(n)]))", &[("n".to_string(), 1.5)]).unwrap_err();
    assert!(e.to_string().contains("whole numbers"), "{e}");
}

#[test]
fn sample_parts_can_be_read() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/data");
    let mut count = 0;
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_some_and(|e| e == "py") {
            let p = part(&fs::read_to_string(&path).unwrap());
            count += 1;
            if p.solid.is_none() {
                assert!(!p.built.is_empty(), "{}", path.display());
                continue;
            }
            if p.plane {
                // A figure goes on along z; what is meshed is a slab of it.
                assert!(model(&p).is_err(), "{}", path.display());
                continue;
            }
            if path.ends_with("bored_ball.py") {
                // It joins a STEP model, which has no function.
                assert!(model(&p).is_err(), "{}", path.display());
                continue;
            }
            let m = model(&p).unwrap();
            assert!(m.bounds().is_finite() && !m.faces().is_empty(), "{}", path.display());
        }
    }
    assert!(count >= 10, "{count}");
}

#[test]
fn loops_conditions_and_imports_make_what_is_written_without() {
    let pairs = [
        ("a = sphere(1)\nfor i in range(3):\n    a -= sphere(0.1, at=(i, 0, 0))", {
            "a = sphere(1) - sphere(0.1, at=(0, 0, 0)) - sphere(0.1, at=(1, 0, 0)) - sphere(0.1, at=(2, 0, 0))"
        }),
        (
            "n = 0\nfor i, c in enumerate('abcd'):\n    if c == 'b':\n        continue\n    if i > 2:\n        break\n    n += i\na = sphere(n)",
            "a = sphere(2)",
        ),
        (
            "def f(k):\n    d = 1\n    for i in range(k):\n        d = 2*d\n        if d > 10:\n            return d\n    return -d\na = solid(x >= f(2) + f(9))",
            "a = solid(x >= 12)",
        ),
        (
            "def f(k):\n    if k < 0:\n        return 1\n    elif k == 0:\n        return 2\n    else:\n        return 3\na = solid(x >= 100*f(-1) + 10*f(0) + f(1))",
            "a = solid(x >= 123)",
        ),
        (
            "i = 7\ndef f():\n    for i in range(3):\n        pass\n    return i\nj = f()\na = sphere(i + j)",
            "a = sphere(9)",
        ),
        ("for i in range(3):\n    pass\na = sphere(i)", "a = sphere(2)"),
        (
            "s = []\nfor i in range(4):\n    if i not in (1, 'a'):\n        s.append(sphere(i + 1))\ns.extend([sphere(9)])\na = union(s)",
            "a = union([sphere(1), sphere(3), sphere(4), sphere(9)])",
        ),
        (
            "def f(n):\n    s = []\n    for i in range(n):\n        s.append((i, 'k'))\n    return s\na = sphere(1 if (2, 'k') in f(3) and 'd' in 'abcd' else 2)",
            "a = sphere(1)",
        ),
        (
            "import math\nfrom rvachev import *\na = solid(math.sqrt(x) >= math.e)",
            "a = solid(sqrt(x) >= 2.718281828459045)",
        ),
        (
            "import numpy as np, rvachev as rv\na = rv.solid(np.arctan2(rv.y, x) >= np.pi)",
            "a = solid(atan2(y, x) >= pi)",
        ),
        (
            "from math import *\nfrom numpy import maximum as m\na = solid(m(fabs(x), tau) >= 7)",
            "a = solid(max(abs(x), 2*pi) >= 7)",
        ),
    ];
    for (loops, plain) in pairs {
        let [p, q] = [loops, plain].map(|s| parse(&format!("{s}\npart(a)"), &[]).unwrap());
        assert_eq!(format!("{:?}", p.solid), format!("{:?}", q.solid), "{loops}");
    }
}
