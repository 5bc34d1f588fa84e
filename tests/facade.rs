//! What the library shows of itself: some seventy names at its root; the rooms behind them are hidden from its documentation.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use syn::{Item, UseTree, Visibility};

/// A reader can look through so many names at once.
const MOST_NAMES: usize = 75;
/// Programs that study single operators, which no facade can hold.
const STUDIES: [&str; 3] = ["operators.rs", "classes.rs", "figures.rs"];

fn file(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(path)
}

fn names_in(tree: &UseTree, into: &mut BTreeSet<String>) {
    match tree {
        UseTree::Path(p) => names_in(&p.tree, into),
        UseTree::Name(n) => assert!(into.insert(n.ident.to_string()), "{} is there twice", n.ident),
        UseTree::Group(g) => g.items.iter().for_each(|t| names_in(t, into)),
        UseTree::Rename(r) => panic!("{} has another name in the library", r.rename),
        UseTree::Glob(_) => panic!("a glob shows what nobody chose"),
    }
}

/// The names of the facade; every room must be hidden.
fn facade() -> BTreeSet<String> {
    let text = fs::read_to_string(file("src/lib.rs")).unwrap();
    let mut names = BTreeSet::new();
    for item in syn::parse_file(&text).unwrap().items {
        match item {
            Item::Mod(m) if matches!(m.vis, Visibility::Public(_)) => {
                let hidden = m.attrs.iter().any(|a| {
                    a.path().is_ident("doc") && a.parse_args::<syn::Ident>().is_ok_and(|word| word == "hidden")
                });
                assert!(hidden, "the room `{}` is shown", m.ident);
            }
            Item::Use(u) if matches!(u.vis, Visibility::Public(_)) => names_in(&u.tree, &mut names),
            _ => {}
        }
    }
    names
}

/// What follows `rvachev::` in a text of Rust: a name, or several in braces.
fn asked_of_the_library(text: &str) -> Vec<String> {
    let word = |s: &str| s.trim().chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect::<String>();
    let mut asked = Vec::new();
    for (at, _) in text.match_indices("rvachev::") {
        let rest = &text[at + "rvachev::".len()..];
        match rest.strip_prefix('{') {
            Some(group) => {
                let end = group.find('}').unwrap_or(group.len());
                asked.extend(group[..end].split(',').map(word).filter(|w| !w.is_empty()));
            }
            None => asked.push(word(rest)),
        }
    }
    asked
}

fn snippets(markdown: &str) -> String {
    markdown.split("```rust").skip(1).filter_map(|s| s.split("```").next()).collect::<Vec<_>>().join("\n")
}

#[test]
fn the_facade_can_be_read_at_once() {
    let names = facade();
    assert!((60..=MOST_NAMES).contains(&names.len()), "{} names: {names:?}", names.len());
    let documented = fs::read_to_string(file("src/lib.rs")).unwrap();
    for gate in ["Solid", "load_part", "load_step", "Wire", "load_mesh", "heal", "mesh_soup", "write", "Run", "Error"] {
        assert!(names.contains(gate), "{gate} is missing");
        assert!(documented.contains(&format!("[`{gate}`]")), "{gate} is not on the tour");
    }
}

#[test]
fn programs_shown_to_users_need_the_facade_alone() {
    let names = facade();
    let mut texts = vec![("README.md".to_string(), snippets(&fs::read_to_string(file("README.md")).unwrap()))];
    for entry in fs::read_dir(file("examples")).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        if name.ends_with(".rs") && !STUDIES.contains(&&name[..]) {
            texts.push((name, fs::read_to_string(path).unwrap()));
        }
    }
    assert!(texts.len() > 4, "{} programs", texts.len());
    for (name, text) in texts {
        let asked = asked_of_the_library(&text);
        assert!(!asked.is_empty(), "{name} asks nothing of the library");
        for word in asked {
            assert!(names.contains(&word), "{name}: `rvachev::{word}` is not of the facade");
        }
    }
}
