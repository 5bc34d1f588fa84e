//! What is refused: where, and by which words.

use super::*;

/// Constructs of Python that are not part of the language.
const REFUSED: &[(&str, &str)] = &[
    ("¦import os", "imports than math, numpy and rvachev are not part"),
    ("a = 1\n¦from os import path", "rvachev are not part"),
    ("¦from . import a", "rvachev are not part"),
    ("import math\na = math.¦gamma(2)", "part files know no \"gamma\" of math"),
    ("from numpy import ¦array", "part files know no \"array\" of numpy"),
    ("import math\na = ¦math + 1", ""),
    ("¦while True:\n    pass", "endless loops are not part"),
    ("¦for i in range(3):\n    pass\nelse:\n    pass", "a loop is plain"),
    ("for i in ¦3:\n    pass", "a list is needed here"),
    ("for i in range(3):\n    ¦a[0] = 1", "only names can be assigned to"),
    ("s = []\nt = s\n¦s.append(1)", "the list s has another name"),
    ("s = [1]\nfor i in s:\n    ¦s.append(1)", "or a loop goes through it"),
    ("s = []\ns.¦pop()", "methods of lists: append, extend"),
    ("s = []\n¦s.append(1, 2)", ".append() takes 1 argument"),
    ("s = []\ns.extend(¦1)", "a list is needed here, not a number"),
    ("a = ¦1 in 2", "a number is in a list, not in a number"),
    ("a = 1 if ¦x in [1] else 2", "a formula cannot be looked for"),
    ("if ¦x:\n    pass", "a truth value is needed here"),
    ("¦break", "there is no loop around this"),
    ("if True:\n    ¦return 1", "returns outside of functions are not part"),
    ("for i in range(2):\n    ¦while True:\n        pass", "endless loops are not part"),
    ("¦class A:\n    pass", "classes are not part"),
    ("f = ¦lambda a: a", "lambda functions are not part"),
    ("¦try:\n    a = 1\nexcept E:\n    pass", "try statements are not part"),
    ("¦raise 1", "raise statements are not part"),
    ("¦with box((1, 1, 1)) as b:\n    pass", "with statements are not part"),
    ("a = 1\n¦del a", "del statements are not part"),
    ("¦global a", "global statements are not part"),
    ("¦assert 1 < 2", "assertions are not part"),
    ("¦match 1:\n    case 1:\n        pass", "match statements are not part"),
    ("¦type A = 1", "type aliases are not part"),
    ("¦return 1", "returns outside of functions are not part"),
    ("¦a += 1", "nothing is called \"a\""),
    ("a = 'b'\n¦a -= 1", "has no meaning"),
    ("¦a: int = 1", "annotations are not part"),
    ("¦async def f():\n    return 1", "a function is plain"),
    ("¦@cache\ndef f():\n    return 1", "a function is plain"),
    ("¦def f(*a):\n    return 1", "a function is plain"),
    ("¦def f(**k):\n    return 1", "a function is plain"),
    ("¦def f[T](a):\n    return 1", "a function is plain"),
    ("def f():\n    ¦def g():\n        return 1\n    return g()\na = f()", "functions inside functions are not part"),
    ("def ¦f(a):\n    if a > 1:\n        return 1\nb = f(2) + f(1)", "must return something"),
    ("def ¦f():\n    for i in range(3):\n        pass\n    break\nb = f()", "no loop around"),
    ("¦def f():\n    a = 1", "must return something"),
    ("def f():\n    a = 1\n    return a\nf()\nsphere(¦a)", "nothing is called \"a\""),
    ("a = ¦clamp(x, 1)", "takes 3 arguments"),
    ("a = ¦where(x > 0, 1, 2)", "nothing is called \"where\""),
    ("¦def f():\n    'nothing else'", "must return something"),
    ("¦def f():\n    return", "must return something"),
    ("def f(a):\n    if a:\n        ¦return\n    return 1\nf(True)", "must return something"),
    ("def f():\n    return (¦yield 1)\na = f()", "yield expressions are not part"),
    ("a = [(¦b := 1)]", "assignments inside expressions are not part"),
    ("a = ¦{1: 2}", "dictionaries are not part"),
    ("a = ¦{i: i for i in range(3)}", "dictionaries are not part"),
    ("a = ¦{1, 2}", "sets are not part"),
    ("a = ¦b'bytes'", "byte strings are not part"),
    ("a = ¦t'{1}'", "template strings are not part"),
    ("a = ¦...", "ellipses are not part"),
    ("a = ¦1j", "complex numbers are not part"),
    ("a = [¦*range(3), 1]", "starred expressions are not part"),
    ("¦*a, b = 1, 2", "only names can be assigned to"),
    ("a = [1]\n¦a[0] = 2", "only names can be assigned to"),
    ("a = sphere(1)\n¦a.r = 2", "only names can be assigned to"),
    ("a = [i for ¦l[0] in range(3)]", "only names can be assigned to"),
    ("a = sphere(1).¦__class__", "there is no method \"__class__\""),
    ("a = ().__class__.¦__bases__", "there is no method \"__bases__\""),
    ("a = sphere(1).¦__init__()", "there is no method \"__init__\""),
    ("a = sphere(1).¦move", "can only be called: .move(...)"),
    ("a = 'a'.¦upper()", "there is no method \"upper\""),
    ("a = 'a'.¦move((1, 0, 0))", "is a method of solids, not of a string"),
    ("¦open('/etc/passwd')", "nothing is called \"open\""),
    ("¦eval('1')", "nothing is called \"eval\""),
    ("¦exec('a = 1')", "nothing is called \"exec\""),
    ("¦print(1)", "nothing is called \"print\""),
    ("a = ¦__builtins__", "nothing is called \"__builtins__\""),
    ("a = f'¦{1:3}'", "formats inside braces are not part"),
    ("a = f'¦{1=}'", "formats inside braces are not part"),
    ("sphere(¦**1)", "** arguments are not part"),
    ("sphere(¦*1)", "a list is needed behind *, not a number"),
    ("a = ¦1 is 1", "is is not part"),
    ("a = ¦1 << 2", "a number << a number has no meaning"),
    ("a = ¦1 | 2", "a number | a number has no meaning"),
    ("a = ¦~1", "~a number has no meaning"),
];

#[test]
fn what_is_not_part_of_the_language_is_refused_where_it_stands() {
    fail(REFUSED);
}

/// Mistakes in files that hold nothing they may not hold.
const MISTAKES: &[(&str, &str)] = &[
    // text
    ("part(sphere(1)¦", "syntax error"),
    ("a = ¦= 1", "syntax error"),
    ("a = 1\n¦  b = 2", "syntax error"),
    ("a = ¦'abc\nb = 1", "syntax error: this string is not closed"),
    ("a = f'{1¦'", "syntax error"),
    ("a = f'{1¦)}'", "syntax error: nothing opens this bracket"),
    ("a = \"ä\" + ¦spher", "nothing is called \"spher\""),
    ("¦", "the file declares no part"),
    ("# nothing\n¦", "the file declares no part"),
    // names
    ("part(¦spher(1))", "did you mean \"sphere\"?"),
    ("radius = 1\npart(sphere(¦raduis))", "did you mean \"radius\"?"),
    ("a = ¦completely_unknown", "nothing is called \"completely_unknown\""),
    ("a = ¦q", "nothing is called \"q\"\n"),
    ("a = 1\n¦a(2)", "a number cannot be called"),
    ("def f():\n    return ¦i\na = [f() for i in [1]]", "nothing is called \"i\""),
    // arguments
    ("a = ¦sphere()", "sphere() needs \"r\"; it has: r, at"),
    ("a = sphere(1, (0, 0, 0), ¦3)", "sphere() takes at most 2 arguments: r, at"),
    ("a = sphere(radius=¦1)", "sphere() has no parameter \"radius\"; it has: r, at"),
    ("a = sphere(1, r=¦2)", "sphere() is given \"r\" twice"),
    ("a = sphere(1).move(by=(0, 0, 0), at=¦1)", "move() has no parameter \"at\""),
    ("a = ¦sphere(1).move()", "move() needs \"by\""),
    ("a = ¦sphere(1).mirror()", "mirror() needs \"axis\""),
    ("a = ¦half_space()", "half_space() needs \"normal\""),
    ("a = ¦box()", "box() needs \"lo\""),
    ("a = ¦box((1, 1, 1), lo=(0, 0, 0))", "or lo and hi, not both"),
    ("a = ¦sin()", "sin() takes 1 argument, not 0"),
    ("a = ¦sin(1, 2)", "sin() takes 1 argument, not 2"),
    ("a = ¦atan2(1)", "atan2() takes 2 arguments, not 1"),
    ("a = ¦min()", "min() takes at least 1, not 0"),
    ("a = sin(x=¦1)", "sin() takes no keywords"),
    ("a = len(a=¦1)", "len() takes no keywords"),
    ("def f(a):\n    return a\nb = ¦f()", "f() needs \"a\""),
    ("def f(a):\n    return a\nb = f(1, ¦2)", "f() takes 1 arguments"),
    ("def f(a):\n    return a\nb = f(1, a=¦2)", "f() is given \"a\" twice"),
    ("def f(a):\n    return a\nb = f(b=¦2)", "f() has no parameter \"b\""),
    ("def f(a, *, b):\n    return a\nc = f(1, ¦2)", "f() takes 1 arguments"),
    ("def f(a=¦nobody):\n    return a", "nothing is called \"nobody\""),
    // numbers
    ("a = sphere(¦-1)", "\"r\" of sphere() must be positive, not -1"),
    ("a = sphere(¦0)", "must be positive, not 0"),
    ("a = sphere(¦'1')", "\"r\" of sphere() must be a number, not a string"),
    ("a = sphere(¦x)", "must be a number, not a formula"),
    ("a = ellipsoid(¦(1, 0, 1))", "radii of an ellipsoid must be positive"),
    ("a = cylinder(1, height=¦-1)", "\"height\" of cylinder() must be positive"),
    ("a = cone(¦-1, 1, 1)", "\"r0\" of cone() must not be negative"),
    ("a = ¦cone(0, 0, 1)", "one radius that is not zero"),
    ("a = torus(1, ¦0)", "\"r\" of torus() must be positive"),
    ("a = gyroid(1, ¦0)", "\"thickness\" of gyroid() must be positive"),
    ("a = box(¦(1, -1, 1))", "sizes of a box must be positive"),
    ("a = ¦box(lo=(0, 0, 0), hi=(1, 0, 1))", "lo < hi in all three coordinates"),
    ("a = ¦box(lo=(2, 0, 0), hi=(1, 1, 1))", "lo < hi in all three coordinates"),
    ("a = box(¦(1, 1))", "three finite numbers (x, y, z)"),
    ("a = box(¦1)", "must be a tuple of three numbers, not a number"),
    ("a = sphere(1).scale(¦0)", "\"k\" of scale() must be positive"),
    ("a = sphere(1).scale(¦(1, 2, 3))", "must be a number, not a tuple"),
    ("a = sphere(1).size(¦0)", "\"h\" of size() must be positive"),
    ("a = sphere(1).name(¦1)", "must be a string"),
    ("a = ¦sphere(1).name('')", "at least one character"),
    ("a = ¦sphere(1).name('a\\n')", "no control characters"),
    ("a = cylinder(1, ¦'w')", "an axis is \"x\", \"y\", \"z\" or a vector, not \"w\""),
    ("a = cylinder(1, ¦(0, 0, 0))", "must not be the zero vector"),
    ("a = sphere(1).rotate(¦'90')", "\"degrees\" of rotate() must be a number"),
    ("a = blend(sphere(1), ¦1, 1)", "\"b\" of blend() must be a solid, not a number"),
    ("a = blend(sphere(1), sphere(2), ¦0)", "\"radius\" of blend() must be positive"),
    // polygons
    ("a = polygon(¦[(0, 0), (1, 0)])", "at least 3 different corners"),
    ("a = polygon(¦[(0, 0), (1, 1), (1, 0), (0, 1)])", "edges 0 and 2 of the polygon touch or cross"),
    ("a = extrude(¦[(0, 0), (1, 1), (1, 0), (0, 1)], 1)", "touch or cross"),
    ("a = extrude([(0, 0), (1, 1), (0, 1)], ¦0)", "\"height\" of extrude() must be positive"),
    ("a = polygon(¦[(0, 0), (1, 1), 3])", "point 2 of the polygon must be two finite numbers"),
    ("a = polygon(¦3)", "a polygon or a list of points"),
    ("a = revolve(¦[(-1, 0), (1, 0), (0, 1)])", "point 0 of the turned polygon has a negative radius"),
    // arithmetic
    ("a = ¦1 / 0", "division by zero"),
    ("a = ¦1 // 0", "division by zero"),
    ("a = ¦1 % 0", "division by zero"),
    ("a = ¦1.5 / (1 - 1)", "division by zero"),
    ("a = ¦x / 0", "division by zero"),
    ("a = ¦0 ** -1", "is not a finite number"),
    ("a = ¦(-8) ** (1 / 3)", "is not a finite number"),
    ("a = ¦1e300 * 1e300", "is not a finite number"),
    ("a = ¦1e999", "this number is too large"),
    ("a = int(¦1E400)", "this number is too large"),
    ("a = ¦sqrt(-1)", "sqrt() is not a finite number here"),
    ("a = ¦log(0)", "log() is not a finite number here"),
    ("a = ¦degrees(1e308)", "this number is too large"),
    ("a = ¦round(1e300, 15)", "this number is too large"),
    ("a = ¦int(1e300)", "too large for a whole number"),
    // kinds
    ("a = ¦sphere(1) + 1", "a solid + a number has no meaning"),
    ("a = ¦sphere(1) + sphere(2)", "solids are joined by & | - and ~"),
    ("a = ¦sphere(1) & x", "make a solid of the formula"),
    ("a = ¦-sphere(1)", "the complement is ~a"),
    ("a = ¦'a' + 1", "a string + a number has no meaning"),
    ("a = ¦[1] + (1,)", "a list + a tuple has no meaning"),
    ("a = ¦(1, 2) * 2.0", "a tuple * a number has no meaning"),
    ("a = ¦x % '2'", "has no meaning"),
    ("a = ¦x // 0", "division by zero"),
    ("a = ¦'a' < 'b'", "a string and a string cannot be compared"),
    ("a = ¦x == 1", "formulas are compared by >= <= > <"),
    ("a = ¦x < 'a'", "a formula and a string cannot be compared"),
    ("a = 1 if ¦'a' else 2", "a truth value is needed here, not a string"),
    ("a = ¦x > 0 and y > 0", "a truth value is needed here, not a condition on formulas"),
    ("a = ¦sphere(1) if x > 0 else sphere(2)", "chooses between formulas"),
    ("a = solid(¦'x')", "takes a formula or a comparison of formulas, not a string"),
    ("a = solid(¦1 < 2)", "does not depend on x, y, z"),
    ("a = ¦union([])", "union() needs at least one solid"),
    ("a = union(¦[1])", "union() takes solids, not a number"),
    ("a = sin(¦sphere(1))", "sin() takes numbers and formulas, not a solid"),
    ("a = ¦len(1)", "a number has no length"),
    ("a = ¦sum(1)", "sum() takes a list, not a number"),
    ("a = ¦sum([1, 'a'])", "a number + a string has no meaning"),
    ("a = ¦str([1])", "a list has no text"),
    ("a = f'¦{[1]}'", "a list has no text"),
    ("a = ¦range(1.5)", "one to three whole numbers"),
    ("a = ¦range(1, 2, 0)", "the step of a range must not be zero"),
    ("a = ¦float('1')", "float() cannot be used on (a string)"),
    ("a = ¦zip(1)", "zip() takes lists"),
    ("a = [1]\nb = ¦a[1]", "index 1 is out of range: there are 1 items"),
    ("a = [1]\nb = ¦a[-2]", "index -2 is out of range"),
    ("a = ¦[1][0.0]", "an index is a whole number, not a number"),
    ("a = ¦1[0]", "a number has no items"),
    ("a = ¦[1][::0]", "the step of a slice must not be zero"),
    ("a = ¦[1]['a':]", "slices are bounded by whole numbers"),
    ("¦a, b = 1, 2, 3", "3 values cannot be given to 2 names"),
    ("¦a, b = 1", "a number cannot be given to several names"),
    ("a = [i for i in ¦3]", "a list is needed here, not a number"),
    // declarations
    ("¦units('parsec')", "unknown unit \"parsec\""),
    ("units('mm')\n¦units('mm')", "units() is said twice"),
    ("units(¦1)", "must be a string"),
    ("part(sphere(1))\n¦part(sphere(1))", "part() is said twice"),
    ("part(¦1)", "\"solid\" of part() must be a solid, not a number"),
    ("¦part()", "part() needs \"solid\""),
    ("part(sphere(1), ¦'R7')", "rsystem is \"R0\""),
    ("part(sphere(1), ¦('Ralpha', 2))", "Ralpha needs -1 < alpha <= 1, not 2"),
    ("part(sphere(1), ¦('Ralpha', -1))", "Ralpha needs"),
    ("part(sphere(1), ¦('R0m', 0))", "R0m needs 1 <= m <= 8"),
    ("part(sphere(1), ¦('R0m', -5))", "R0m needs"),
    ("part(sphere(1), ¦('R0m', 1.5))", "rsystem is"),
    ("part(sphere(1), domain=¦((0, 0, 0), (1, 0, 1)))", "a domain needs lo < hi"),
    ("part(sphere(1), domain=¦((0, 0, 0), (1, 1)))", "a domain is two points"),
    ("part(sphere(1), domain=¦1)", "a domain is two points"),
    ("mesh(size=¦0)", "\"size\" of mesh() must be positive"),
    ("mesh(size=¦-0.1)", "must be positive, not -0.1"),
    ("mesh(size=¦'-1')", "a size is a positive length or a share"),
    ("mesh(size=¦'2 percent')", "a size is a positive length or a share"),
    ("mesh(method=¦'mc')", "mesh() has no parameter \"method\""),
    ("group('a', ¦1)", "a group is made of faces(...), not a number"),
    ("group('a', faces(¦1))", "faces() takes names and patterns, not a number"),
    ("group('a', 'b')\n¦group('a', 'c')", "there is a group \"a\" already"),
    ("¦group('a')", "group() needs \"faces\""),
];

#[test]
fn mistakes_are_named_where_they_stand() {
    fail(MISTAKES);
}

#[test]
fn limits_are_met_with_an_error_that_names_them() {
    let n = |count: usize, text: &str| text.repeat(count);
    let most = |what: &str, limit: usize| format!("{what}: the limit is {limit}");
    let (deep, chain) = ("brackets are nested too deeply", "too many operators in one expression");
    let (long, nodes) = ("the list is too long", "the part has too many nodes");
    let million = "l = range(1000000)\n";
    fail(&[
        (format!("¦{}", n(limits::SOURCE_BYTES / 2 + 1, "#\n")), most("bytes", limits::SOURCE_BYTES)),
        (format!("a = {}¦(1", n(limits::NESTING, "[")), most(deep, limits::NESTING)),
        (format!("a = {}¦{{1", n(limits::NESTING / 2, "f'{[")), most(deep, limits::NESTING)),
        (format!("a ={}¦- 1", n(limits::CHAIN - 1, "-")), most(chain, limits::CHAIN)),
        (format!("a = 1{} ¦or 1", n(limits::CHAIN - 1, " and 1")), most(chain, limits::CHAIN)),
        (format!("a = f'{{{}¦-1}}'", n(limits::CHAIN, "-")), most(chain, limits::CHAIN)),
        (format!("a = f\"{{'' \"\" {}¦-1}}\"", n(limits::CHAIN, "-")), most(chain, limits::CHAIN)),
        (
            format!("a = {}¦lambda b, c: 1", n(limits::NESTING, "lambda b, c: ")),
            most("too many lambda functions", limits::NESTING),
        ),
        ("def f(n):\n    return ¦f(n + 1)\na = f(0)".into(), most("calls are nested too deeply", limits::CALLS)),
        ("a = ¦range(1000001)".into(), most(long, limits::ITEMS)),
        (format!("{million}a = ¦l + [1]"), most(long, limits::ITEMS)),
        ("a = ¦[1, 2] * 500001".into(), most(long, limits::ITEMS)),
        ("l = range(1001)\na = ¦[1 for i in l for j in l]".into(), most(long, limits::ITEMS)),
        ("l = range(1001)\na = ¦zip(*[l for i in l])".into(), most(long, limits::ITEMS)),
        (format!("{million}a = union(*l, ¦*l)"), most(long, limits::ITEMS)),
        (format!("a = ¦'{}'", n(limits::TEXT + 1, "a")), most("the string is too long", limits::TEXT)),
        (format!("a = '{}'\nb = ¦a + a", n(limits::TEXT / 2 + 1, "a")), most("too long", limits::TEXT)),
        (format!("a = '{}'\nb = ¦f'{{a}}{{a}}'", n(limits::TEXT / 2 + 1, "a")), most("too long", limits::TEXT)),
        ("a = polygon(¦[(i, i * i) for i in range(4001)])".into(), most("4001 corners", 4_000)),
        (format!("{million}a = sum([x for i in l])\nb = sum([y for i in l])\nc = ¦x + y"), most(nodes, limits::NODES)),
    ]);
}

/// Each of these would run for hours, or fill the memory, if only expressions were counted.
#[test]
fn work_is_counted_where_it_is_done() {
    let long = "a".repeat(9_000);
    let steps = format!("takes too long: the limit is {} evaluations", limits::STEPS);
    let nodes = format!("too many nodes: the limit is {}", limits::NODES);
    let cases: Vec<(String, String)> = [
        ("[¦range(1000000) for i in l]", &steps),
        ("[¦sum(l) for i in l]", &steps),
        ("[¦l[1:] for i in l]", &steps),
        ("[¦tuple(l) for i in l]", &steps),
        ("[¦enumerate(l) for i in l]", &steps),
        ("[¦s + 'b' for i in l]", &steps),
        ("[¦min(l) for i in l]", &nodes),
        ("[¦union(b) for i in l]", &nodes),
        ("[¦group(str(i), 'a') for i in l]", &steps),
    ]
    .iter()
    .map(|(text, says)| {
        (format!("l = range(1000000)\ns = '{long}'\nb = [sphere(1)] * 1000000\na = {text}"), says.to_string())
    })
    .collect();
    fail(&cases);
}

#[test]
fn what_the_limits_allow_is_read() {
    let deep = |open: &str, close: &str| {
        let mut all = String::from("a = ");
        for _ in 0..limits::NESTING - 1 {
            all += &"-".repeat(limits::CHAIN - 3);
            all += open;
        }
        all += "1";
        all += &close.repeat(limits::NESTING - 1);
        all + "\npart(sphere(1))\n"
    };
    part(&deep("(", ")"));
    part(&deep("abs(", ")"));
    let e = parse(&deep("[", "]"), &[]).unwrap_err();
    assert!(e.to_string().contains("has no meaning"));
    // lines that go on behind a backslash are one expression, whatever ends them
    for end in ["\n", "\r\n"] {
        let e = parse(&format!("a = {}1", format!("-\\{end}").repeat(limits::CHAIN)), &[]).unwrap_err();
        assert!(e.to_string().contains("too many operators"), "{e}");
        part(&format!("{}part(sphere(1))", format!("a = 1 + 1  # -\\{end}").repeat(2 * limits::CHAIN)));
    }
    // words and signs in strings and comments do not count
    let text = "- ( [ { lambda if ".repeat(1_000);
    part(&format!("# {text}\n'''{text}'''\na = f'{{1}}{}'\npart(sphere(1))", "-{{(".repeat(2_000)));
    part("a = f\"{'{'}{1}\" if'a'=='a'else\"b\"\npart(sphere(1).name(a))");
}

#[test]
fn recursion_through_deep_expressions_ends_with_an_error() {
    let minus = "-".repeat(limits::CHAIN - 8);
    let (open, close) = (format!("({minus}").repeat(90), ")".repeat(90));
    let source = format!("def f(n):\n    return 1 if n == 0 else {open}f(n - 1){close}\na = f(60)\npart(sphere(1))\n");
    let e = parse(&source, &[]).unwrap_err();
    assert!(e.to_string().contains(&format!("nested too deeply: the limit is {}", limits::DEPTH)), "{e}");
}

#[test]
fn large_trees_are_lowered_or_refused() {
    // a comb, whose formula is as deep as it has teeth, and a long sum
    let comb = "p = [(i, i % 2 * 5) for i in range(3998)] + [(3997, -1), (0, -1)]\npart(extrude(p, 1))";
    model(&part(comb)).unwrap();
    let e = model(&part("part(solid(sum([abs(x) + i for i in range(100000)]) <= -1) & sphere(2))")).unwrap_err();
    assert!(e.to_string().contains("empty"), "{e}");
    let doubled = |join: &str| format!("s = sphere(1)\n{}part(s)", format!("s = {join}\n").repeat(31));
    for join in ["(s | s.move((1, 0, 0)))", "blend(s, s.move((1, 0, 0)), 0.1)"] {
        let e = model(&part(&doubled(join))).unwrap_err();
        assert!(e.to_string().contains("more than 4000000 nodes"), "{e}");
    }
    let e = model(&part(&format!("s = sphere(1)\n{}part(s)", "s = blend(s, sphere(1), 1)\n".repeat(40)))).unwrap_err();
    assert!(e.to_string().contains("nested more than 32 deep"), "{e}");
}

#[test]
fn numbers_near_the_largest_one_are_no_panic() {
    for text in
        ["box((1, 1, 1)).move((0, 1e308, 0))", "sphere(1e308).scale(1e308)", "torus(1e308, 1e308, at=(1e308, 0, 0))"]
    {
        let e = model(&part(&format!("part(cylinder(0.1, 'x', height=1).move((0, 1e308, 0)) | {text})"))).err();
        assert!(e.is_none_or(|e| matches!(e, Error::Input { .. })), "{text}");
    }
}
