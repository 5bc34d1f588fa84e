//! The header for C, compared with the one cbindgen makes of the library's source, and the Fortran module with the header.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use cbindgen::{Builder, Config, Language, Style};
use rvachev::{Error, Place};

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// What a name stands for.
#[derive(Clone, Debug, PartialEq)]
enum Meaning {
    /// A struct whose fields are the library's business.
    Handle,
    /// A struct; a field as in C, without blanks that need not be.
    Struct(Vec<String>),
    /// A function: what it returns, then its arguments.
    Function(Vec<String>),
    /// Another name for a type; so is a pointer to a function.
    Alias(String),
    /// A number.
    Number(String),
}

type Header = BTreeMap<String, Meaning>;

/// `RvMesh` as `rv_mesh`; constants have their prefix in C only. Other names stay.
fn renamed(word: &str) -> String {
    if !word.starts_with("Rv") {
        return word.to_string();
    }
    let mut out = String::new();
    for c in word.chars() {
        if c.is_uppercase() && !out.is_empty() {
            out.push('_');
        }
        out.extend(c.to_lowercase());
    }
    out
}

/// Words and marks, without comments and lines for the preprocessor; what is for C++ alone is left out.
fn words(text: &str) -> Vec<String> {
    let mut bare = String::new();
    for part in text.split("/*") {
        bare.push_str(part.split_once("*/").map_or(part, |(_, after)| after));
    }
    let mut all: Vec<String> = Vec::new();
    let mut for_cpp = false;
    for line in bare.lines() {
        let line = line.trim();
        for_cpp = line == "#ifdef __cplusplus" || for_cpp && line != "#endif";
        if line.starts_with('#') || for_cpp {
            continue;
        }
        let mut inside = false;
        for c in line.chars() {
            let letter = c.is_alphanumeric() || c == '_';
            match all.last_mut() {
                Some(last) if letter && inside => last.push(c),
                _ if c.is_whitespace() => {}
                _ => all.push(c.to_string()),
            }
            inside = letter;
        }
    }
    all.iter().map(|w| renamed(w)).collect()
}

/// Splits at a mark outside of brackets; empty pieces are left out.
fn split<'a>(words: &'a [String], mark: &str) -> Vec<&'a [String]> {
    let mut depth = 0;
    let at = |w: &String| {
        match w.as_str() {
            "(" | "{" | "[" => depth += 1,
            ")" | "}" | "]" => depth -= 1,
            _ => {}
        }
        depth == 0 && w == mark
    };
    words.split(at).filter(|piece| !piece.is_empty()).collect()
}

fn joined(words: &[String]) -> String {
    let mut out = String::new();
    for w in words {
        let letter = |c: char| c.is_alphanumeric() || c == '_';
        if out.ends_with(letter) && w.starts_with(letter) || out.ends_with('*') && w.starts_with(letter) {
            out.push(' ');
        }
        out.push_str(w);
    }
    out
}

/// What is between the first bracket of a kind and the last of the other.
fn between<'a>(words: &'a [String], open: &str, close: &str) -> Option<&'a [String]> {
    let (from, to) = (words.iter().position(|w| w == open)?, words.iter().rposition(|w| w == close)?);
    words.get(from + 1..to)
}

fn pieces(words: &[String], mark: &str) -> Vec<String> {
    split(words, mark).into_iter().map(joined).filter(|p| p != "void").collect()
}

/// What the name is that a declaration is about, in its words.
fn named(declaration: &[String]) -> usize {
    let pointer = declaration.windows(2).position(|w| w[0] == "(" && w[1] == "*").map(|i| i + 2);
    let function = || declaration.iter().position(|w| w == "(").map(|i| i - 1);
    pointer.or_else(function).unwrap_or(declaration.len() - 1)
}

/// A header, read. Names that only the source has are put in place of themselves.
fn read(text: &str) -> Header {
    let mut all = Header::new();
    for line in text.lines() {
        let mut parts = line.split_whitespace();
        if let (Some("#define"), Some(name), Some(value)) = (parts.next(), parts.next(), parts.next()) {
            all.insert(format!("RV_{name}"), Meaning::Number(value.to_string()));
        }
    }
    let mut own: BTreeMap<String, Vec<String>> = BTreeMap::new();
    for statement in split(&words(text), ";") {
        let mut plain = Vec::new();
        for w in statement {
            match own.get(w) {
                Some(meant) => plain.extend(meant.iter().cloned()),
                None => plain.push(w.clone()),
            }
        }
        let (name, meaning) = match (plain[0].as_str(), between(&plain, "{", "}")) {
            ("enum", Some(numbers)) => {
                for number in split(numbers, ",") {
                    all.insert(number[0].clone(), Meaning::Number(joined(&number[2..])));
                }
                continue;
            }
            ("typedef", Some(fields)) => (plain.len() - 1, Meaning::Struct(pieces(fields, ";"))),
            ("typedef", None) if plain[1] == "struct" && plain.len() == 4 => (3, Meaning::Handle),
            ("typedef", None) => {
                let name = named(&plain);
                let kind = [&plain[1..name], &plain[name + 1..]].concat();
                if !statement[named(statement)].starts_with("rv_") {
                    own.insert(plain[name].clone(), kind);
                    continue;
                }
                (name, Meaning::Alias(joined(&kind)))
            }
            _ => {
                let name = named(&plain);
                let mut whole = vec![joined(&plain[..name])];
                whole.extend(pieces(between(&plain, "(", ")").unwrap_or(&[]), ","));
                (name, Meaning::Function(whole))
            }
        };
        let name = plain[name].clone();
        assert!(all.insert(name.clone(), meaning).is_none(), "{name} twice");
    }
    all
}

fn committed() -> Header {
    read(&fs::read_to_string(root().join("capi/include/rvachev.h")).unwrap())
}

/// What cbindgen makes of the source, and the statuses of errors, which are the exit codes of the command.
fn made() -> Header {
    let config = Config { language: Language::C, style: Style::Type, usize_is_size_t: true, ..Config::default() };
    let builder = Builder::new().with_config(config).with_src(root().join("capi/src/lib.rs"));
    let mut text = Vec::new();
    builder.generate().unwrap_or_else(|e| panic!("cbindgen: {e}")).write(&mut text);
    let mut all = read(&String::from_utf8(text).unwrap());
    let [usage, failed] = [Error::Usage, Error::Failed].map(|e| e(String::new()));
    let input = Error::input(Place::Unknown, "");
    for (name, e) in
        [("RV_USAGE", usage), ("RV_INPUT", input), ("RV_FAILED", failed), ("RV_CANCELLED", Error::Cancelled)]
    {
        all.insert(name.to_string(), Meaning::Number(e.exit_code().to_string()));
    }
    all
}

/// Whether the header may say the one where the source has the other. Handles change inside by locks of their own, so the source
/// lends them all to be read: that a call changes one is for the reader to know.
fn fits(said: &Meaning, has: &Meaning) -> bool {
    let (Meaning::Function(said), Meaning::Function(has)) = (said, has) else { return said == has };
    let lent = |said: &str, has: &str| has.strip_prefix("const ") == Some(said) && said.matches('*').count() == 1;
    let handle = |t: &str| t.starts_with("rv_");
    said.len() == has.len() && said.iter().zip(has).all(|(s, h)| s == h || handle(s) && lent(s, h))
}

/// What two headers have in which they differ.
fn differences(header: &Header, source: &Header) -> Vec<String> {
    let mut all = Vec::new();
    for (name, has) in source {
        match header.get(name) {
            None => all.push(format!("{name} is in the source only: {has:?}")),
            Some(said) if !fits(said, has) => {
                all.push(format!("{name} is {said:?} in the header and {has:?} in the source"))
            }
            Some(_) => {}
        }
    }
    let only = header.iter().filter(|(name, _)| !source.contains_key(*name));
    all.extend(only.map(|(name, said)| format!("{name} is in the header only: {said:?}")));
    all
}

#[test]
fn header_says_what_cbindgen_makes_of_the_source() {
    let (header, source) = (committed(), made());
    let count = |wanted: fn(&Meaning) -> bool| source.values().filter(|m| wanted(m)).count();
    let functions = count(|m| matches!(m, Meaning::Function(_)));
    let structs = count(|m| matches!(m, Meaning::Struct(_)));
    let handles = count(|m| matches!(m, Meaning::Handle));
    let numbers = count(|m| matches!(m, Meaning::Number(_)));
    assert!(
        functions > 120 && structs >= 5 && handles >= 10 && numbers >= 7,
        "only {functions} functions, {structs} structs, {handles} handles and {numbers} numbers were found"
    );
    let found = differences(&header, &source);
    assert!(found.is_empty(), "{}", found.join("\n"));
}

#[test]
fn differences_between_headers_are_named() {
    let text = fs::read_to_string(root().join("capi/include/rvachev.h")).unwrap();
    let good = read(&text);
    for (from, to, name) in [
        ("double lipschitz;", "float lipschitz;", "rv_field"),
        ("    int has_gradient;", "    int concurrent_too;", "rv_field"),
        ("RV_FAILED = 4", "RV_FAILED = 6", "RV_FAILED"),
        ("const double *by,", "double *by,", "rv_solid_move"),
        ("double radius, const double *at", "double size, const double *at", "rv_solid_sphere"),
        ("size_t rv_error_line", "int rv_error_line", "rv_error_line"),
        ("typedef struct rv_text rv_text;", "", "rv_text"),
        ("(size_t n, const double *xyz", "(const double *xyz, size_t n", "rv_function"),
        ("void rv_run_free(rv_run *run);", "", "rv_run_free"),
    ] {
        assert!(text.contains(from), "{from}");
        let found = differences(&read(&text.replacen(from, to, 1)), &good);
        assert!(found.len() == 1 && found[0].starts_with(&format!("{name} ")), "{from}: {found:?}");
    }
}

#[test]
fn every_handle_has_a_free() {
    let header = committed();
    for name in header.iter().filter(|(_, m)| **m == Meaning::Handle).map(|(name, _)| name) {
        let free = header.get(&format!("{name}_free"));
        let Some(Meaning::Function(whole)) = free else { panic!("{name}_free is {free:?}") };
        assert!(whole.len() == 2 && whole[0] == "void" && apart(&whole[1]).1 == format!("{name}*"), "{whole:?}");
    }
}

#[test]
fn every_call_stops_panics() {
    let mut calls = 0;
    for file in fs::read_dir(root().join("capi/src")).unwrap() {
        let text = fs::read_to_string(file.unwrap().path()).unwrap();
        for part in text.split("pub extern \"C\" fn ").skip(1) {
            let (head, rest) = part.split_once('(').unwrap();
            let body = rest.split_once("\n}\n").unwrap().0;
            // What only reads an error or the version has nothing to panic.
            let reads = head.starts_with("rv_error_") || head == "rv_version";
            // `lend` is `entry` for arrays.
            let stopped = ["entry(error, ||", "lend(", "release("].iter().any(|way| body.contains(way));
            assert!(stopped || reads, "{head} goes through neither `entry` nor `release`");
            calls += 1;
        }
    }
    let functions = committed().values().filter(|m| matches!(m, Meaning::Function(_))).count();
    assert_eq!(calls, functions);
}

/// How Fortran declares what C passes or has in a struct, without a name. A pointer may be a `c_ptr` by value, or what it points to.
fn by_value(kind: &str) -> Option<&'static str> {
    match kind {
        _ if kind.contains('*') => None,
        "int" => Some("integer(c_int)"),
        "size_t" => Some("integer(c_size_t)"),
        "uint32_t" => Some("integer(c_int32_t)"),
        "double" => Some("real(c_double)"),
        "rv_function" | "rv_release" => Some("type(c_funptr)"),
        other => panic!("what is {other:?} in Fortran?"),
    }
}

/// The name a declaration of C ends with, and the type before it.
fn apart(declaration: &str) -> (&str, &str) {
    let end = declaration.rfind(|c: char| !c.is_alphanumeric() && c != '_').map_or(0, |i| i + 1);
    (declaration[end..].trim(), declaration[..end].trim())
}

/// What the Fortran module binds, by name: what is in brackets after the name, and what is declared inside.
fn bound(text: &str) -> BTreeMap<String, (Vec<String>, BTreeMap<String, String>)> {
    let mut all = BTreeMap::new();
    let mut lines = text.lines().map(str::trim);
    while let Some(line) = lines.next() {
        let begins = ["subroutine ", "function ", "type, bind(c) :: "];
        let head = begins.iter().find_map(|b| line.strip_prefix(b)).filter(|_| line.contains("bind(c)"));
        let Some(head) = head else { continue };
        let name: String = head.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect();
        let inside = head[name.len()..].strip_prefix('(').and_then(|rest| rest.split_once(')'));
        let arguments = inside.map_or("", |(arguments, _)| arguments).split(',').map(str::trim);
        let arguments = arguments.filter(|a| !a.is_empty()).map(String::from).collect();
        let declared = lines.by_ref().take_while(|l| !l.starts_with("end ")).filter_map(|l| {
            let (kind, name) = l.split_once(" :: ")?;
            let name = name.split([' ', '(']).next()?;
            Some((name.to_string(), kind.to_string()))
        });
        all.insert(name, (arguments, declared.collect()));
    }
    all
}

#[test]
fn fortran_module_says_what_the_header_has() {
    let text = fs::read_to_string(root().join("capi/fortran/rvachev.f90")).unwrap();
    let bound = bound(&text);
    let mut left: Vec<&String> = bound.keys().filter(|name| name.starts_with("rv_")).collect();
    for (name, meaning) in &committed() {
        match meaning {
            Meaning::Function(whole) => {
                left.retain(|n| *n != name);
                let (arguments, declared) = bound.get(name).unwrap_or_else(|| panic!("no {name} in Fortran"));
                let said: Vec<_> = whole[1..].iter().map(|a| apart(a)).collect();
                assert!(arguments.iter().eq(said.iter().map(|(n, _)| n)), "{name}: {arguments:?} are {said:?}");
                for (argument, kind) in said {
                    let found = declared[argument].as_str();
                    let fits = match by_value(kind) {
                        Some(wanted) => found == format!("{wanted}, value"),
                        None => found == "type(c_ptr), value" || found.contains("intent("),
                    };
                    assert!(fits, "{argument} of {name}: {kind} in C, {found} in Fortran");
                }
            }
            Meaning::Struct(fields) => {
                let (_, declared) =
                    bound.get(&name.replacen("rv_", "c_", 1)).unwrap_or_else(|| panic!("no {name} in Fortran"));
                assert_eq!(declared.len(), fields.len(), "{name}");
                for (field, kind) in fields.iter().map(|f| apart(f)) {
                    assert_eq!(declared[field], by_value(kind).unwrap_or("type(c_ptr)"), "{field} of {name}");
                }
            }
            Meaning::Number(value) => {
                let line = text.lines().find(|l| l.contains("rv_good = ")).unwrap();
                let said = format!("{} = {value}", name.to_lowercase());
                assert!(line.split([',', ':']).any(|p| p.trim() == said), "{said} in Fortran");
            }
            Meaning::Handle | Meaning::Alias(_) => {}
        }
    }
    assert!(left.is_empty(), "in Fortran only: {left:?}");
}
