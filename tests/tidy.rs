//! Rules that are tests: which room may import which, a head on every file, no file too long to read, links that lead somewhere.
//!
//! The rooms are those of `ARCHITECTURE.md`. Code is read as tokens, so comments, documentation links and strings are
//! not imports. What is found: `crate::room`, `use crate::{room, other::thing}`, chains of `super` that climb out of
//! their room, the crate's own name, and all of these inside functions, tests and nested groups.
//!
//! Not found: paths put together by macros.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

/// The rooms of the library. A room may import the rows above its own; rooms in one row do not know each other.
const ROOMS: &[&[&str]] = &[
    &["error"],
    &["run"],
    &["numeric"],
    &["spatial"],
    &["planar"],
    &["mesh"],
    &["geometry"],
    &["model"],
    &["quality", "sizing"],
    &["io", "render", "page"],
    &["implicit", "parametric", "discrete"],
    &["merge", "heal", "optimize"],
    &["remesh"],
    &["pipeline"],
];

/// What the command may use: the pipeline, and what it takes to read options, report and draw. No gate, no stage.
const COMMAND: &[&str] = &["error", "run", "mesh", "quality", "io", "render", "page", "pipeline"];

/// Names the crate's root lends, and the rooms they come from.
const ROOT_NAMES: &[(&str, Option<&str>)] = &[
    ("Error", Some("error")),
    ("Place", Some("error")),
    ("Result", Some("error")),
    ("Run", Some("run")),
    ("DVec3", None),
];

/// Lines of a source file without its tests: what one sitting can read.
const MOST_LINES: usize = 600;

fn row(room: &str) -> Option<usize> {
    ROOMS.iter().position(|row| row.contains(&room))
}

// ---------------------------------------------------------------------------------------------------------- reading

#[derive(Debug, Clone, PartialEq)]
enum Token {
    Word(String),
    /// `::`
    Colons,
    Sign(char),
}

/// Tokens with their 1-based lines; comments, literals and lifetimes are left out.
fn tokens(text: &str) -> Vec<(Token, usize)> {
    let c: Vec<char> = text.chars().collect();
    let (mut i, mut line, mut out) = (0, 1, Vec::new());
    let at = |i: usize| c.get(i).copied().unwrap_or('\0');
    while i < c.len() {
        let start = i;
        match c[i] {
            '/' if at(i + 1) == '/' => i += c[i..].iter().take_while(|&&x| x != '\n').count(),
            '/' if at(i + 1) == '*' => {
                let mut depth = 1;
                i += 2;
                while i < c.len() && depth > 0 {
                    match (c[i], at(i + 1)) {
                        ('/', '*') => (depth, i) = (depth + 1, i + 2),
                        ('*', '/') => (depth, i) = (depth - 1, i + 2),
                        _ => i += 1,
                    }
                }
            }
            '"' => i = after_quoted(&c, i, '"'),
            // A character ends with a quote one or more places on; a lifetime has none.
            '\'' if at(i + 1) == '\\' || at(i + 2) == '\'' => i = after_quoted(&c, i, '\''),
            '\'' => i += 1 + word_length(&c[i + 1..]),
            x if x.is_alphanumeric() || x == '_' => {
                let n = word_length(&c[i..]);
                let word: String = c[i..i + n].iter().collect();
                i += n;
                let hashes = c[i..].iter().take_while(|&&x| x == '#').count();
                if matches!(word.as_str(), "r" | "br" | "cr") && at(i + hashes) == '"' {
                    i += hashes + 1;
                    let closes = |i: usize| at(i) == '"' && (1..=hashes).all(|k| at(i + k) == '#');
                    while i < c.len() && !closes(i) {
                        i += 1;
                    }
                    i += hashes + 1;
                } else if !x.is_numeric() {
                    out.push((Token::Word(word), line));
                }
            }
            ':' if at(i + 1) == ':' => {
                out.push((Token::Colons, line));
                i += 2;
            }
            x => {
                if !x.is_whitespace() {
                    out.push((Token::Sign(x), line));
                }
                i += 1;
            }
        }
        line += c[start..i.min(c.len())].iter().filter(|&&x| x == '\n').count();
    }
    out
}

fn word_length(c: &[char]) -> usize {
    c.iter().take_while(|x| x.is_alphanumeric() || **x == '_').count()
}

/// The place after a literal that opens at `i` and closes at the next `quote` without a backslash.
fn after_quoted(c: &[char], mut i: usize, quote: char) -> usize {
    i += 1;
    while i < c.len() && c[i] != quote {
        i += if c[i] == '\\' { 2 } else { 1 };
    }
    i + 1
}

/// What a file reaches for in the root of a crate: the first name of each path, and the line it stands in.
#[derive(Debug, Default, PartialEq)]
struct Reached {
    /// Through `crate` and `super`.
    here: Vec<(String, usize)>,
    /// Through the name `rvachev`.
    by_name: Vec<(String, usize)>,
}

/// `depth` is how many modules deep the file sits: 0 for the root, 1 for `src/run.rs` and `src/mesh/mod.rs`.
fn reached(text: &str, depth: usize) -> Reached {
    let t = tokens(text);
    let word = |i: usize| match t.get(i) {
        Some((Token::Word(w), _)) => w.as_str(),
        _ => "",
    };
    let is = |i: usize, what: Token| t.get(i).is_some_and(|(x, _)| *x == what);
    let mut found = Reached::default();
    let mut braces: Vec<bool> = Vec::new();
    let mut i = 0;
    while i < t.len() {
        let opens_path = !is(i.wrapping_sub(1), Token::Colons);
        let depth = depth + braces.iter().filter(|module| **module).count();
        match &t[i].0 {
            Token::Sign('{') => braces.push(i >= 2 && word(i - 2) == "mod"),
            Token::Sign('}') => {
                braces.pop();
            }
            // `use crate as root` would hide what follows.
            Token::Word(w) if w == "crate" && word(i + 1) == "as" => found.here.push(("*".into(), t[i].1)),
            Token::Word(w) if opens_path && is(i + 1, Token::Colons) => match w.as_str() {
                "crate" => heads(&t, i + 2, 0, &mut found.here),
                "self" => heads(&t, i + 2, depth, &mut found.here),
                "super" => heads(&t, i, depth, &mut found.here),
                "rvachev" => heads(&t, i + 2, 0, &mut found.by_name),
                _ => {}
            },
            _ => {}
        }
        i += 1;
    }
    found
}

/// Adds the names a path or group at `i` takes from the root; `up` is how many levels the root is above.
fn heads(t: &[(Token, usize)], i: usize, up: usize, found: &mut Vec<(String, usize)>) {
    match t.get(i) {
        Some((Token::Word(w), _)) if w == "super" && t.get(i + 1).is_some_and(|x| x.0 == Token::Colons) => {
            heads(t, i + 2, up.saturating_sub(1), found);
        }
        Some((Token::Word(w), line)) if up == 0 => found.push((w.clone(), *line)),
        Some((Token::Sign('*'), line)) if up == 0 => found.push(("*".into(), *line)),
        Some((Token::Sign('{'), _)) => {
            heads(t, i + 1, up, found);
            let mut depth = 0;
            for (k, (token, _)) in t.iter().enumerate().skip(i) {
                match token {
                    Token::Sign('{') => depth += 1,
                    Token::Sign('}') => depth -= 1,
                    Token::Sign(',') if depth == 1 => heads(t, k + 1, up, found),
                    _ => {}
                }
                if depth == 0 {
                    break;
                }
            }
        }
        _ => {}
    }
}

// ------------------------------------------------------------------------------------------------------------ rules

/// Where a file below `src` belongs: its room (or `cli`, or none for the root) and how deep it sits.
fn place(path: &str) -> (Option<&str>, usize) {
    let stem = path.strip_suffix(".rs").unwrap_or(path);
    let parts: Vec<&str> = stem.split('/').filter(|p| *p != "mod").collect();
    match parts[..] {
        ["lib"] => (None, 0),
        ["main"] => (Some("cli"), 0),
        _ => (Some(parts[0]), parts.len()),
    }
}

/// What is wrong with the imports of the file at `path` (below `src`).
fn wrong_imports(path: &str, text: &str) -> Vec<String> {
    let (Some(room), depth) = place(path) else {
        return Vec::new();
    };
    if room != "cli" && row(room).is_none() {
        return vec![format!("src/{path}: `{room}` is not a room of the table")];
    }
    let reached = reached(text, depth);
    let mut wrong = Vec::new();
    let mut say = |line: usize, what: String| wrong.push(format!("src/{path}:{line}: {what}"));
    for (name, line) in reached.here.iter().chain(&reached.by_name) {
        let name = match ROOT_NAMES.iter().find(|n| n.0 == name) {
            Some((_, None)) => continue,
            Some((_, Some(from))) => from,
            None => name.as_str(),
        };
        if room == "cli" {
            if row(name).is_some() && !COMMAND.contains(&name) {
                say(*line, format!("the command calls the pipeline, not `{name}`"));
            }
        } else if name != room {
            match row(name) {
                None if name == "*" => say(*line, "takes everything from the root: name the room".into()),
                None => say(*line, format!("`{name}` is not a room of the table")),
                Some(r) if Some(r) == row(room) => say(*line, format!("`{room}` and `{name}` are siblings")),
                Some(r) if Some(r) > row(room) => say(*line, format!("`{name}` is below `{room}`")),
                Some(_) => {}
            }
        }
    }
    if room != "cli" {
        for (name, line) in &reached.by_name {
            say(*line, format!("the library calls itself by name: `rvachev::{name}`"));
        }
    }
    wrong
}

/// Lines before the tests that close a file; all of them where none do.
fn lines_without_tests(text: &str) -> usize {
    let lines: Vec<&str> = text.lines().collect();
    let opens_tests = |i: usize| {
        lines[i].trim() == "#[cfg(test)]"
            && lines.get(i + 1).is_some_and(|l| l.trim_start().starts_with("mod ") && l.ends_with('{'))
    };
    (0..lines.len()).find(|&i| opens_tests(i)).unwrap_or(lines.len())
}

/// Modules a file declares for tests only, `#[cfg(test)] mod name;`.
fn test_modules(text: &str) -> Vec<String> {
    let t = tokens(text);
    let words: Vec<&str> = t.iter().map(|x| if let Token::Word(w) = &x.0 { w.as_str() } else { "" }).collect();
    (0..t.len())
        .filter(|&i| words[i] == "cfg" && words.get(i + 2) == Some(&"test"))
        .filter_map(|i| {
            let k = (i..t.len()).take(12).find(|&k| words[k] == "mod")?;
            (t.get(k + 2)?.0 == Token::Sign(';')).then(|| words[k + 1].to_string())
        })
        .collect()
}

// ------------------------------------------------------------------------------------------------------------ files

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// All `.rs` files below a folder, by their path below it, sorted; nothing if the folder is not there.
fn rust_files(folder: &Path) -> Vec<(String, String)> {
    fn walk(folder: &Path, out: &mut Vec<PathBuf>) {
        for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
            let path = entry.path();
            if path.is_dir() && path.file_name().is_some_and(|n| n != "target") {
                walk(&path, out);
            } else if path.extension().is_some_and(|e| e == "rs") {
                out.push(path);
            }
        }
    }
    let mut paths = Vec::new();
    walk(folder, &mut paths);
    paths.sort();
    let name = |p: &Path| p.strip_prefix(folder).unwrap().to_string_lossy().replace('\\', "/");
    paths.iter().map(|p| (name(p), fs::read_to_string(p).unwrap())).collect()
}

fn assert_none(wrong: Vec<String>) {
    assert!(wrong.is_empty(), "\n{}\n", wrong.join("\n"));
}

#[test]
fn rooms_import_only_rooms_above() {
    let files = rust_files(&root().join("src"));
    assert!(files.len() > 10, "the sources were not found");
    assert_none(files.iter().flat_map(|(path, text)| wrong_imports(path, text)).collect());
}

#[test]
fn every_room_of_the_table_is_described() {
    let text = fs::read_to_string(root().join("ARCHITECTURE.md")).unwrap();
    let lines: Vec<usize> = ROOMS
        .iter()
        .flat_map(|row| row.iter())
        .map(|room| {
            let line = text.lines().position(|l| l.starts_with('|') && l.contains(&format!("`{room}`")));
            line.unwrap_or_else(|| panic!("ARCHITECTURE.md has no row for `{room}`"))
        })
        .collect();
    assert!(lines.is_sorted(), "the rows of ARCHITECTURE.md stand in another order than this table");
}

#[test]
fn every_file_says_what_it_holds() {
    let wrong = ["src", "tests", "examples", "benches"].iter().flat_map(|folder| {
        let files = rust_files(&root().join(folder));
        let bare = files.into_iter().filter(|(_, text)| !text.starts_with("//! "));
        bare.map(move |(path, _)| format!("{folder}/{path}: does not start with `//! `"))
    });
    assert_none(wrong.collect());
}

#[test]
fn no_source_file_is_too_long() {
    let files = rust_files(&root().join("src"));
    let tests: BTreeSet<String> = files
        .iter()
        .flat_map(|(path, text)| {
            let folder = match path.strip_suffix("mod.rs") {
                Some(folder) => folder.to_string(),
                None if place(path).1 == 0 => String::new(),
                None => format!("{}/", path.strip_suffix(".rs").unwrap()),
            };
            test_modules(text).into_iter().map(move |m| format!("{folder}{m}"))
        })
        .collect();
    let only_tests = |path: &str| tests.iter().any(|t| path == format!("{t}.rs") || path.starts_with(&format!("{t}/")));
    let wrong = files.iter().filter(|(path, _)| !only_tests(path)).filter_map(|(path, text)| {
        let n = lines_without_tests(text);
        (n > MOST_LINES).then(|| format!("src/{path}: {n} lines without tests, {MOST_LINES} are allowed"))
    });
    assert_none(wrong.collect());
}

/// All Markdown files of the project, by their path from its root, sorted. Folders that others fill are left out.
fn documents() -> Vec<(PathBuf, String)> {
    fn walk(folder: &Path, out: &mut Vec<PathBuf>) {
        for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
            let (path, name) = (entry.path(), entry.file_name());
            if path.is_dir() && name != "target" && !name.to_string_lossy().starts_with('.') {
                walk(&path, out);
            } else if path.extension().is_some_and(|e| e == "md") {
                out.push(path);
            }
        }
    }
    let mut paths = Vec::new();
    walk(root(), &mut paths);
    paths.sort();
    paths.into_iter().map(|p| (p.strip_prefix(root()).unwrap().into(), fs::read_to_string(&p).unwrap())).collect()
}

/// Lines of a Markdown text outside of blocks of code.
fn prose(text: &str) -> impl Iterator<Item = &str> {
    let mut code = false;
    text.lines().filter(move |line| {
        let fence = line.trim_start().starts_with("```");
        code ^= fence;
        !code && !fence
    })
}

/// What the links of a text lead to: `[...](here)`. Pages of others are left out.
fn links(text: &str) -> Vec<String> {
    let ends = prose(text).flat_map(|line| line.split("](").skip(1));
    let targets = ends.filter_map(|rest| rest.split(')').next());
    targets.filter(|t| !t.contains("://") && !t.contains([' ', '`'])).map(String::from).collect()
}

/// Names of the headings of a text, as links call them.
fn headings(text: &str) -> BTreeSet<String> {
    let name = |line: &str| -> String {
        let line = line.trim_start_matches('#').trim().to_lowercase();
        let kept = line.chars().filter(|c| c.is_alphanumeric() || matches!(c, ' ' | '-' | '_'));
        kept.map(|c| if c == ' ' { '-' } else { c }).collect()
    };
    prose(text).filter(|line| line.starts_with('#')).map(name).collect()
}

#[test]
fn documents_link_to_what_is_there() {
    let mut wrong = Vec::new();
    let mut count = 0;
    for (path, text) in documents() {
        for link in links(&text) {
            count += 1;
            let (file, part) = link.split_once('#').unwrap_or((&link, ""));
            let to = if file.is_empty() { path.clone() } else { path.parent().unwrap().join(file) };
            let there = root().join(&to);
            let named = || fs::read_to_string(&there).is_ok_and(|t| headings(&t).contains(part));
            if !there.exists() || !part.is_empty() && !named() {
                wrong.push(format!("{}: nothing is at {link}", path.display()));
            }
        }
    }
    assert!(count > 20, "the links were not found");
    assert_none(wrong);
}

/// Places in the pipeline that may look into a text: names, not messages.
const LOOKS_INTO_NAMES: &[(&str, &str)] = &[("pipeline/groups.rs", "f.starts_with(\"domain.\")")];

/// Lines of a file of the pipeline, its tests left out, that look for words in a text. Messages are made last, from types: what
/// hangs on one hangs on its wording.
fn looks_into_texts(path: &str, text: &str) -> Vec<String> {
    if place(path).0 != Some("pipeline") {
        return Vec::new();
    }
    let looks = [".contains(\"", ".starts_with(\"", ".ends_with(\"", ".find(\""];
    let lines = text.lines().take(lines_without_tests(text)).enumerate();
    let found = lines.filter(|(_, line)| looks.iter().any(|l| line.contains(l)));
    let found =
        found.filter(|(_, line)| !LOOKS_INTO_NAMES.iter().any(|(file, what)| *file == path && line.contains(what)));
    found.map(|(i, line)| format!("src/{path}:{}: looks for words in a text: {}", i + 1, line.trim())).collect()
}

#[test]
fn nothing_is_decided_by_a_message() {
    let files = rust_files(&root().join("src"));
    assert_none(files.iter().flat_map(|(path, text)| looks_into_texts(path, text)).collect());
}

/// Words that join a sentence to the one before it. Each sentence of a comment is to be readable alone.
const JOINING: &[&str] = &["And", "Or", "Nor", "But"];

/// What a line holds after `//`, `///` or `//!`, if that is all that stands on it.
fn comment(line: &str) -> Option<&str> {
    let rest = line.trim_start().strip_prefix("//")?;
    Some(rest.strip_prefix(['/', '!']).unwrap_or(rest).trim())
}

/// Lines of comments in which a sentence begins with a joining word: first in a block of comments or a paragraph of it, or after the
/// end of another sentence. Comments beside code are not looked at.
fn joined_sentences(path: &str, text: &str) -> Vec<String> {
    let ends = |word: &str| word.trim_end_matches([')', '"', '`', '*']).ends_with(['.', '?', '!']);
    let mut begins = true;
    let mut wrong = Vec::new();
    for (i, line) in text.lines().enumerate() {
        let words = comment(line).unwrap_or("");
        // Code and empty lines end a sentence, whatever they hold.
        begins |= words.is_empty();
        for word in words.split_whitespace() {
            if begins && JOINING.contains(&word) {
                wrong.push(format!("src/{path}:{}: a sentence begins with `{word}`: {}", i + 1, line.trim()));
            }
            // Marks of lists stand before a sentence.
            begins = ends(word) || begins && matches!(word, "-" | "*");
        }
    }
    wrong
}

#[test]
fn sentences_of_comments_stand_alone() {
    let files = rust_files(&root().join("src"));
    assert_none(files.iter().flat_map(|(path, text)| joined_sentences(path, text)).collect());
}

// ------------------------------------------------------------------------------------------- the checker, checked

#[test]
fn joined_sentences_are_seen() {
    for (text, line) in [
        ("/// And more.\nfn f() {}", 1),
        ("fn f() {\n    // Nor here.\n}", 2),
        ("//! Some. But\n//! others.", 1),
        ("/// It is so (always).\n/// Or not.", 2),
        ("/// A list:\n///\n/// - And this.", 3),
        ("/// One thing\nconst A: u8 = 1;\n/// And another.\nconst B: u8 = 2;", 3),
    ] {
        let wrong = joined_sentences("mesh/edit.rs", text);
        assert_eq!(wrong.len(), 1, "{text}: {wrong:?}");
        assert!(wrong[0].starts_with(&format!("src/mesh/edit.rs:{line}: a sentence begins")), "{text}: {wrong:?}");
    }
    for text in [
        "/// One thing,\n/// And here a name; and, or, nor.",
        "/// Android is no joining word. Order neither.",
        "fn f() { let s = \"a. And b\"; } // And beside code.",
        "const BUT: &str = \"But\";",
    ] {
        assert_eq!(joined_sentences("mesh/edit.rs", text), Vec::<String>::new(), "{text}");
    }
}

#[test]
fn looking_into_a_message_is_seen() {
    let decides = "fn f() {\n    faults.retain(|f| !f.contains(\"closed\"));\n}\n#[cfg(test)]\nmod tests {\n    fn g() { x.contains(\"y\") }\n}\n";
    let wrong = looks_into_texts("pipeline/brep.rs", decides);
    assert!(wrong.len() == 1 && wrong[0].starts_with("src/pipeline/brep.rs:2:"), "{wrong:?}");
    assert_eq!(looks_into_texts("io/stl.rs", decides), Vec::<String>::new());
    assert_eq!(
        looks_into_texts("pipeline/brep.rs", "let x = list.contains(&3) && name.starts_with('x');"),
        Vec::<String>::new()
    );
    let name = "all.filter(|f| f.starts_with(\"domain.\"))";
    assert_eq!(
        (looks_into_texts("pipeline/groups.rs", name).len(), looks_into_texts("pipeline/leaf.rs", name).len()),
        (0, 1)
    );
}

#[test]
fn links_and_headings_are_read() {
    let text =
        "# A `--tol` [x](a.md#b)\n```md\n[y](no.md)\n# no\n```\n![p](q.png) [z](https://x.org/y.md)\n## What holds?\n";
    assert_eq!(links(text), ["a.md#b", "q.png"]);
    let names: Vec<String> = headings(text).into_iter().collect();
    assert_eq!(names, ["a---tol-xamdb", "what-holds"]);
}

#[test]
fn imports_from_above_pass() {
    for (path, text) in [
        ("mesh/edit.rs", "use crate::spatial::Aabb; use crate::{error::Result, run::Run, numeric::{Svd, roots}};"),
        ("mesh/edit.rs", "use super::TriMesh; use super::super::spatial::Aabb; use crate::mesh::TriMesh;"),
        ("mesh/mod.rs", "mod edit; pub(crate) fn f(); pub(in crate::mesh) fn g(); use self::edit::X;"),
        (
            "mesh/edit.rs",
            "// crate::pipeline\n/* use crate::pipeline; /* nested */ crate::io */ fn f<'a>(x: &'a str) {}",
        ),
        (
            "mesh/edit.rs",
            "/// See [`x`](crate::pipeline).\nconst A: &str = \"crate::pipeline::x\"; const B: char = '\"';",
        ),
        ("mesh/edit.rs", "const A: &str = r#\"\" crate::io \"#; const B: &str = \"\\\" crate::io\"; use crate::Error;"),
        ("mesh/edit.rs", "mod tests { use super::*; use super::super::TriMesh; use super::super::super::run::Run; }"),
        ("optimize/mod.rs", "use crate::{DVec3, Result, Run, geometry::SurfaceOracle, quality};"),
        ("main.rs", "mod cli; use cli::Args; use rvachev::{Run, pipeline::{self, Method}, io};"),
        ("cli/mesh.rs", "use super::Args; use crate::cli::bar; use rvachev::pipeline;"),
        ("lib.rs", "pub mod pipeline; pub use pipeline::mesh_part;"),
    ] {
        assert_eq!(wrong_imports(path, text), Vec::<String>::new(), "{path}: {text}");
    }
}

#[test]
fn every_way_to_break_the_table_is_seen() {
    for (path, text, line, word) in [
        ("mesh/edit.rs", "\nuse crate::quality::Certificate;", 2, "`quality` is below"),
        ("mesh/edit.rs", "use crate::{\n spatial::Aabb,\n io::{stl, obj},\n};", 3, "`io` is below"),
        ("mesh/edit.rs", "fn f() { let x = crate::pipeline::run(); }", 1, "`pipeline` is below"),
        ("mesh/edit.rs", "mod tests { use super::*;\n use crate::implicit::Solid; }", 2, "`implicit` is below"),
        ("mesh/edit.rs", "use super::super::geometry::Features;", 1, "`geometry` is below"),
        ("mesh/edit.rs", "use super::{TriMesh, super::geometry::Features};", 1, "`geometry` is below"),
        ("mesh/edit.rs", "use self::super::super::geometry;", 1, "`geometry` is below"),
        ("mesh/edit.rs", "mod tests { use super::super::super::io::stl; }", 1, "`io` is below"),
        ("mesh/mod.rs", "use super::geometry::Features;", 1, "`geometry` is below"),
        ("run.rs", "use super::spatial::Aabb;", 1, "`spatial` is below"),
        ("error.rs", "use crate::Run;", 1, "`run` is below"),
        ("io/stl.rs", "use crate::render::draw;", 1, "siblings"),
        ("implicit/lower.rs", "use crate::discrete::Soup;", 1, "siblings"),
        ("optimize/mod.rs", "use crate::{mesh::{TriMesh, edit}, heal::*};", 1, "siblings"),
        ("mesh/edit.rs", "use crate::*;", 1, "takes everything"),
        ("mesh/edit.rs", "use crate as all;", 1, "takes everything"),
        ("mesh/edit.rs", "use crate::util::thing;", 1, "not a room"),
        ("util/thing.rs", "", 0, "not a room"),
        ("mesh/edit.rs", "use rvachev::spatial::Aabb;", 1, "by name"),
        ("main.rs", "use rvachev::{io, optimize::n};", 1, "not `optimize`"),
        ("cli/mesh.rs", "use rvachev::implicit::extract;", 1, "not `implicit`"),
    ] {
        let wrong = wrong_imports(path, text);
        assert_eq!(wrong.len(), 1, "{path}: {text}: {wrong:?}");
        assert!(wrong[0].contains(word), "{path}: {text}: {wrong:?}");
        assert!(line == 0 || wrong[0].starts_with(&format!("src/{path}:{line}:")), "{path}: {text}: {wrong:?}");
    }
}

#[test]
fn every_pair_of_rooms_is_decided() {
    let all: Vec<&str> = ROOMS.iter().flat_map(|r| r.iter().copied()).collect();
    for a in &all {
        for b in &all {
            let wrong = wrong_imports(&format!("{a}/x.rs"), &format!("use crate::{b}::x;"));
            assert_eq!(wrong.is_empty(), a == b || row(b) < row(a), "{a} imports {b}: {wrong:?}");
        }
    }
}

#[test]
fn lines_are_counted_up_to_the_tests() {
    assert_eq!(lines_without_tests("//! a\nfn f() {}\n#[cfg(test)]\nmod tests {\n}\n"), 2);
    assert_eq!(lines_without_tests("//! a\n#[cfg(test)]\nmod tests;\nfn f() {}\n"), 4);
    assert_eq!(lines_without_tests("//! a\n#[cfg(test)]\nuse x::y;\nfn f() {}\n"), 4);
}

#[test]
fn modules_for_tests_are_known() {
    assert_eq!(
        test_modules("mod a;\n#[cfg(test)]\nmod tests;\n#[cfg(test)]\npub(crate) mod testing;"),
        ["tests", "testing"]
    );
    assert_eq!(test_modules("#[cfg(test)]\nmod tests { use super::*; }\nmod b;"), Vec::<String>::new());
}
