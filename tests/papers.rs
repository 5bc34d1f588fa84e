//! Reads `docs/papers.md`: what its rows name must be there, and every number of a paper must have a row.
//!
//! Only text is read. A function is there if its module's file declares it, a test if it stands below `#[test]`, an example
//! or a data file if the file exists, a command if `Command` in `src/cli/arguments.rs` has it and its options.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

/// The papers, and how many equations, figures and tables each has. Our copy of [GUO] has lost its numbers.
const PAPERS: &[(&str, [u32; 3])] = &[
    ("[LIS14]", [20, 6, 0]),
    ("[BOR20]", [0, 22, 0]),
    ("[LAZ]", [0, 2, 2]),
    ("[GUO]", [0, 0, 0]),
    ("[KUZ19]", [61, 37, 3]),
];

/// What is numbered, as rows call it.
const KINDS: [&str; 3] = ["eq.", "fig.", "table"];

/// How a row begins that has nothing to show, with its reason.
const NOT_HERE: &str = "not here: ";

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn read(path: &str) -> Option<String> {
    fs::read_to_string(root().join(path)).ok()
}

/// A row of the table.
#[derive(Debug, Clone, PartialEq)]
struct Row {
    /// Its 1-based line in the page.
    line: usize,
    paper: String,
    number: String,
    place: String,
    see: String,
}

/// The rows of the table, and what is wrong with lines that should be some.
fn rows(text: &str) -> (Vec<Row>, Vec<String>) {
    let (mut rows, mut wrong) = (Vec::new(), Vec::new());
    for (i, line) in text.lines().enumerate().filter(|(_, line)| line.starts_with('|')) {
        let cells: Vec<&str> = line.trim().trim_matches('|').split('|').map(str::trim).collect();
        let [paper, number, says, place, see] = cells[..] else {
            wrong.push(format!("line {}: {} cells instead of 5", i + 1, cells.len()));
            continue;
        };
        if paper == "paper" || paper.starts_with("---") {
            continue;
        }
        if number.is_empty() || says.is_empty() || place.is_empty() {
            wrong.push(format!("line {}: an empty cell", i + 1));
        }
        let [paper, number, place, see] = [paper, number, place, see].map(String::from);
        rows.push(Row { line: i + 1, paper, number, place, see });
    }
    (rows, wrong)
}

/// What stands between backticks.
fn spans(cell: &str) -> impl Iterator<Item = &str> {
    cell.split('`').skip(1).step_by(2)
}

fn is_name(c: char) -> bool {
    c.is_alphanumeric() || c == '_'
}

/// Whether `word` follows one of `before` in the text, and ends there.
fn declares(text: &str, before: &[&str], word: &str) -> bool {
    before.iter().any(|b| {
        let whole = format!("{b}{word}");
        text.match_indices(&whole).any(|(at, _)| {
            let free = !text[..at].ends_with(is_name);
            free && !text[at + whole.len()..].starts_with(is_name)
        })
    })
}

/// Whether a file implements something for a type of this name.
fn implements(text: &str, name: &str) -> bool {
    text.lines()
        .filter(|line| line.starts_with("impl"))
        .any(|line| line.split(|c: char| !is_name(c)).any(|w| w == name))
}

/// Whether a line of the file begins with a variant of this name.
fn has_variant(text: &str, name: &str) -> bool {
    let ends = |rest: &str| rest.is_empty() || rest.starts_with([',', '(', ' ']);
    text.lines().filter_map(|line| line.trim_start().strip_prefix(name)).any(ends)
}

/// The file of a module and the names that follow it: the longest path that is one counts.
fn module<'a>(path: &[&'a str]) -> Option<(String, Vec<&'a str>)> {
    (1..path.len()).rev().find_map(|n| {
        let folder = path[..n].join("/");
        let files = [format!("src/{folder}.rs"), format!("src/{folder}/mod.rs")];
        files.into_iter().find_map(|f| Some((read(&f)?, path[n..].to_vec())))
    })
}

/// What is wrong with a path such as `room::module::Type::function`.
fn wrong_path(path: &str) -> Option<String> {
    let parts: Vec<&str> = path.split("::").collect();
    let Some((text, names)) = module(&parts) else { return Some(format!("no module of `{path}`")) };
    let code = text.split("\n#[cfg(test)]\nmod tests {").next().unwrap_or_default();
    for (i, name) in names.iter().enumerate() {
        let capital = name.starts_with(char::is_uppercase);
        let there = if !capital {
            declares(code, &["fn "], name)
        } else if i > 0 {
            has_variant(code, name)
        } else {
            declares(code, &["struct ", "enum ", "trait ", "type ", "const "], name) || implements(code, name)
        };
        if !there {
            return Some(format!("`{path}`: no {name}"));
        }
    }
    None
}

/// Whether a text has a test of this name: the lines above its function, up to one that is neither an attribute nor a
/// comment, hold `#[test]`.
fn has_test(text: &str, name: &str) -> bool {
    let lines: Vec<&str> = text.lines().map(str::trim_start).collect();
    let head = format!("fn {name}(");
    let is_above = |line: &&&str| line.starts_with("#[") || line.starts_with("//");
    let tested = |i: usize| lines[..i].iter().rev().take_while(is_above).any(|line| line.starts_with("#[test]"));
    lines.iter().enumerate().any(|(i, line)| line.starts_with(&head) && tested(i))
}

/// The commands of the binary, in small letters.
fn commands(arguments: &str) -> BTreeSet<String> {
    let body =
        arguments.split("pub enum Command {").nth(1).and_then(|rest| rest.split("\n}").next()).unwrap_or_default();
    let variants = body.lines().map(str::trim).filter(|line| line.starts_with(char::is_uppercase));
    variants.map(|line| line.split(|c: char| !is_name(c)).next().unwrap_or_default().to_lowercase()).collect()
}

/// What is wrong with a command line such as `rvachev mesh data/a.py -o a.stl --size 3%`.
fn wrong_command(line: &str, arguments: &str) -> Option<String> {
    let mut words = line.split_whitespace().skip(1);
    let verb = words.next().unwrap_or_default();
    if !commands(arguments).contains(verb) {
        return Some(format!("`{line}`: no command {verb}"));
    }
    words.find_map(|word| {
        let option = word.strip_prefix("--").map(|o| o.replace('-', "_"));
        if option.is_some_and(|o| !declares(arguments, &["pub "], &o)) {
            return Some(format!("`{line}`: no option {word}"));
        }
        let file = word.starts_with("data/") && !root().join(word).exists();
        file.then(|| format!("`{line}`: no file {word}"))
    })
}

/// What is wrong with one way to see a row, and whether it is a test or an example.
fn look(span: &str, arguments: &str) -> (Option<String>, bool) {
    if let Some((file, test)) = span.split_once(' ').filter(|(file, _)| file.ends_with(".rs")) {
        let there = read(file).is_some_and(|text| has_test(&text, test));
        return ((!there).then(|| format!("no test {test} in {file}")), true);
    }
    if span.starts_with("rvachev ") {
        return (wrong_command(span, arguments), false);
    }
    let known = ["examples/", "benches/"].iter().any(|folder| span.starts_with(folder));
    let there = known && root().join(span).is_file();
    ((!there).then(|| format!("`{span}` is no test, example or command")), span.starts_with("examples/"))
}

/// All that is wrong with a row by itself.
fn wrong_row(row: &Row, arguments: &str) -> Vec<String> {
    let mut wrong = Vec::new();
    if !PAPERS.iter().any(|(paper, _)| *paper == row.paper) {
        wrong.push(format!("no paper {}", row.paper));
    }
    if let Some(reason) = row.place.strip_prefix(NOT_HERE) {
        if reason.len() < 10 || !row.see.is_empty() {
            wrong.push("what is not here has a reason and nothing to see".into());
        }
    } else {
        let paths: Vec<&str> = spans(&row.place).filter(|s| s.contains("::")).collect();
        if paths.is_empty() {
            wrong.push("no function is named".into());
        }
        wrong.extend(paths.into_iter().filter_map(wrong_path));
        let seen: Vec<_> = spans(&row.see).map(|s| look(s, arguments)).collect();
        if !seen.iter().any(|(_, runs)| *runs) {
            wrong.push("no test and no example runs it".into());
        }
        wrong.extend(seen.into_iter().filter_map(|(why, _)| why));
    }
    wrong.into_iter().map(|why| format!("line {}: {} {}: {why}", row.line, row.paper, row.number)).collect()
}

/// The numbers of each kind that a cell such as `eq. 7-12; fig. 2` names.
fn numbers(cell: &str) -> [BTreeSet<u32>; 3] {
    let mut out: [BTreeSet<u32>; 3] = Default::default();
    for part in cell.split(';').map(str::trim) {
        let Some((kind, rest)) = KINDS.iter().enumerate().find_map(|(k, kind)| Some((k, part.strip_prefix(kind)?)))
        else {
            continue;
        };
        for word in rest.split([',', ' ']) {
            let (first, last) = word.split_once('-').unwrap_or((word, word));
            if let (Ok(first), Ok(last)) = (first.parse::<u32>(), last.parse::<u32>()) {
                out[kind].extend(first..=last);
            }
        }
    }
    out
}

/// Numbers of the papers without a row, and rows with a number that the paper does not have.
fn wrong_numbers(rows: &[Row]) -> Vec<String> {
    let mut wrong = Vec::new();
    for (paper, counts) in PAPERS {
        let named: Vec<[BTreeSet<u32>; 3]> =
            rows.iter().filter(|r| r.paper == *paper).map(|r| numbers(&r.number)).collect();
        if named.is_empty() {
            wrong.push(format!("no row of {paper}"));
        }
        for (k, count) in counts.iter().enumerate() {
            let found: BTreeSet<u32> = named.iter().flat_map(|n| n[k].iter().copied()).collect();
            let wanted: BTreeSet<u32> = (1..=*count).collect();
            let kind = KINDS[k];
            wrong.extend(wanted.difference(&found).map(|n| format!("{paper} {kind} {n} has no row")));
            wrong.extend(found.difference(&wanted).map(|n| format!("{paper} has no {kind} {n}")));
        }
    }
    wrong
}

fn assert_none(wrong: &[String]) {
    assert!(wrong.is_empty(), "\n{}\n", wrong.join("\n"));
}

fn page() -> String {
    read("docs/papers.md").expect("docs/papers.md")
}

fn arguments() -> String {
    read("src/cli/arguments.rs").expect("src/cli/arguments.rs")
}

#[test]
fn what_rows_name_is_there() {
    let (rows, mut wrong) = rows(&page());
    let arguments = arguments();
    wrong.extend(rows.iter().flat_map(|row| wrong_row(row, &arguments)));
    assert!(rows.len() > 100, "the table was not found");
    assert_none(&wrong);
}

#[test]
fn every_number_of_the_papers_has_a_row() {
    assert_none(&wrong_numbers(&rows(&page()).0));
}

#[test]
fn a_row_is_done_or_not_here() {
    let undecided = ["partly", "partially", "in part,", "to do", "planned"];
    let (rows, _) = rows(&page());
    let text = |r: &Row| format!("{} {}", r.place, r.see).to_lowercase();
    assert_none(&rows.iter().map(text).filter(|t| undecided.iter().any(|u| t.contains(u))).collect::<Vec<_>>());
}

// ------------------------------------------------------------------------------------------- the checker, checked

#[test]
fn rows_that_name_nothing_are_seen() {
    let good = "`optimize::normal::align_normals` | `tests/operators.rs a_sequence_is_read_as_it_is_written`";
    let rest = "| `tests/operators.rs a_sequence_is_read_as_it_is_written`";
    for (cells, word) in [
        (good.to_string(), ""),
        (format!("`optimize::normal::align_normal` {rest}"), "no align_normal"),
        (format!("`optimize::normals::align_normals` {rest}"), "no normals"),
        (format!("`optimise::normal::align_normals` {rest}"), "no module"),
        (format!("`parametric::surface::Surface::Extrusion` {rest}"), ""),
        (format!("`parametric::surface::Surface::Extruded` {rest}"), "no Extruded"),
        (format!("`parametric::surface::Surfaces::jet` {rest}"), "no Surfaces"),
        (format!("`parametric::family::Surface::bilinear`, `parametric::mesh::HALVINGS` {rest}"), ""),
        (format!("normals {rest}"), "no function"),
        ("`optimize::normal::align_normals` |".into(), "no test and no example"),
        (format!("{good}, `rvachev mesh data/cube_with_holes.py -o a.stl --size 3%`"), ""),
        (format!("{good}, `rvachev march data/cube_with_holes.py`"), "no command march"),
        (format!("{good}, `rvachev mesh data/no_cube.py`"), "no file"),
        (format!("{good}, `rvachev mesh data/cube_with_holes.py --soze 3%`"), "no option --soze"),
        (format!("{good}, `tests/operators.rs stages`"), "no test stages"),
        (format!("{good}, `tests/operator.rs stages`"), "no test stages"),
        (format!("{good}, `examples/class.rs`"), "is no test"),
        ("not here: nothing to compute |".into(), ""),
        (format!("not here: nothing to compute {rest}"), "nothing to see"),
        ("not here: no |".into(), "has a reason"),
    ] {
        let (rows, wrong) = rows(&format!("| [LIS14] | eq. 1 | says | {cells} |"));
        assert_none(&wrong);
        let wrong = wrong_row(&rows[0], &arguments());
        assert_eq!(wrong.len(), usize::from(!word.is_empty()), "{cells}: {wrong:?}");
        assert!(wrong.iter().all(|w| w.contains(word)), "{cells}: {wrong:?}");
    }
    assert_eq!(rows("| [LIS14] | eq. 1 | says |").1.len(), 1);
}

#[test]
fn numbers_are_read_and_missing_ones_seen() {
    let [eq, fig, table] = numbers("eq. 7-9, 12; fig. 1 a, b; table 3; sec. 4");
    assert_eq!((eq, fig, table), ([7, 8, 9, 12].into(), [1].into(), [3].into()));
    let row = |number: &str| Row {
        line: 1,
        paper: "[LAZ]".into(),
        number: number.into(),
        place: String::new(),
        see: String::new(),
    };
    let of_laz = |all: &[Row]| wrong_numbers(all).into_iter().filter(|w| w.contains("[LAZ]")).collect::<Vec<_>>();
    assert_eq!(of_laz(&[row("fig. 1, 2"), row("table 1-2")]), Vec::<String>::new());
    assert_eq!(of_laz(&[row("fig. 1-3; table 2")]), ["[LAZ] has no fig. 3", "[LAZ] table 1 has no row"]);
}

#[test]
fn commands_and_tests_are_read() {
    let text = "pub enum Command {\n    /// Mesh a part\n    Mesh(Mesh),\n    View(ViewPage),\n}\npub struct Other {\n    A,\n}\n";
    assert_eq!(commands(text), ["mesh".to_string(), "view".to_string()].into());
    let text = "#[test]\n/// Says what.\nfn a() {\n}\n\nfn b() {\n}\nproptest! {\n    #[test]\n    fn c(\n        x in 0..1,\n    ) {}\n}\n";
    assert_eq!(["a", "b", "c", "d"].map(|name| has_test(text, name)), [true, false, true, false]);
}
