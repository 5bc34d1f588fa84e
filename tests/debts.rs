//! What the house still owes its rules, counted: long lists of arguments, tuples handed about, one name in two rooms, types spread over
//! many files, constants. None of these may grow, and where one shrinks its number here shrinks with it.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

use syn::visit::{self, Visit};
use syn::{Attribute, FnArg, ReturnType, Signature, Type};

/// Arguments of a function, the receiver left out.
const MOST_ARGUMENTS: usize = 5;
/// Files over which the methods of one type may be spread.
const MOST_FILES: usize = 3;

/// How many of each there are.
#[derive(Debug, Default, PartialEq, Eq)]
struct Debts {
    /// Functions with more than [`MOST_ARGUMENTS`].
    long_lists: usize,
    /// Functions that return a tuple,
    tuples_returned: usize,
    /// and arguments that are one.
    tuples_taken: usize,
    /// Names of types in more than one room.
    names_in_rooms: usize,
    /// Types with methods of their own in more than [`MOST_FILES`].
    spread: usize,
    /// Constants,
    constants: usize,
    /// and those without a word on what they are.
    bare_constants: usize,
}

/// What there is today.
const OWED: Debts = Debts {
    long_lists: 0,
    tuples_returned: 70,
    tuples_taken: 0,
    names_in_rooms: 18,
    spread: 5,
    constants: 1046,
    bare_constants: 0,
};

/// What is found in files that are read one after the other, tests left out.
#[derive(Default)]
struct Reader {
    file: String,
    debts: Debts,
    /// Rooms by the name of a type,
    rooms: BTreeMap<String, BTreeSet<String>>,
    /// and files by that of one with methods.
    files: BTreeMap<String, BTreeSet<String>>,
}

fn is_for_tests(attributes: &[Attribute]) -> bool {
    attributes.iter().any(|a| {
        let is_cfg = a.path().is_ident("cfg") && a.parse_args::<syn::Ident>().is_ok_and(|word| word == "test");
        is_cfg || a.path().is_ident("test")
    })
}

fn is_tuple(of: &Type) -> bool {
    match of {
        Type::Tuple(t) => !t.elems.is_empty(),
        Type::Reference(r) => is_tuple(&r.elem),
        _ => false,
    }
}

impl Reader {
    fn room(&self) -> String {
        self.file.split('/').next().unwrap_or_default().trim_end_matches(".rs").into()
    }

    fn names(&mut self, name: &syn::Ident) {
        let room = self.room();
        self.rooms.entry(name.to_string()).or_default().insert(room);
    }

    fn constant(&mut self, attributes: &[Attribute]) {
        self.debts.constants += 1;
        self.debts.bare_constants += usize::from(!attributes.iter().any(|a| a.path().is_ident("doc")));
    }

    fn finish(mut self) -> Debts {
        self.debts.names_in_rooms = self.rooms.values().filter(|rooms| rooms.len() > 1).count();
        self.debts.spread = self.files.values().filter(|files| files.len() > MOST_FILES).count();
        self.debts
    }
}

impl<'a> Visit<'a> for Reader {
    fn visit_item_mod(&mut self, item: &'a syn::ItemMod) {
        if !is_for_tests(&item.attrs) {
            visit::visit_item_mod(self, item);
        }
    }

    fn visit_item_fn(&mut self, item: &'a syn::ItemFn) {
        if !is_for_tests(&item.attrs) {
            visit::visit_item_fn(self, item);
        }
    }

    fn visit_signature(&mut self, signature: &'a Signature) {
        let arguments = signature.inputs.iter().filter_map(|a| match a {
            FnArg::Typed(a) => Some(&a.ty),
            FnArg::Receiver(_) => None,
        });
        let debts = &mut self.debts;
        debts.tuples_taken += arguments.clone().filter(|a| is_tuple(a)).count();
        debts.long_lists += usize::from(arguments.count() > MOST_ARGUMENTS);
        debts.tuples_returned += usize::from(matches!(&signature.output, ReturnType::Type(_, t) if is_tuple(t)));
        visit::visit_signature(self, signature);
    }

    fn visit_item_struct(&mut self, item: &'a syn::ItemStruct) {
        self.names(&item.ident);
        visit::visit_item_struct(self, item);
    }

    fn visit_item_enum(&mut self, item: &'a syn::ItemEnum) {
        self.names(&item.ident);
        visit::visit_item_enum(self, item);
    }

    fn visit_item_trait(&mut self, item: &'a syn::ItemTrait) {
        self.names(&item.ident);
        visit::visit_item_trait(self, item);
    }

    fn visit_item_impl(&mut self, item: &'a syn::ItemImpl) {
        if let (Type::Path(path), None) = (&*item.self_ty, &item.trait_)
            && let Some(last) = path.path.segments.last()
        {
            let name = format!("{} {}", self.room(), last.ident);
            self.files.entry(name).or_default().insert(self.file.clone());
        }
        visit::visit_item_impl(self, item);
    }

    fn visit_item_const(&mut self, item: &'a syn::ItemConst) {
        self.constant(&item.attrs);
        visit::visit_item_const(self, item);
    }

    fn visit_impl_item_const(&mut self, item: &'a syn::ImplItemConst) {
        self.constant(&item.attrs);
        visit::visit_impl_item_const(self, item);
    }
}

/// Source files below a folder by their paths below it, those that hold tests alone left out.
fn sources(folder: &Path, out: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_stem().unwrap().to_string_lossy().into_owned();
        if path.is_dir() {
            sources(&path, out);
        } else if path.extension().is_some_and(|e| e == "rs") && !name.ends_with("tests") {
            out.push(path);
        }
    }
}

fn debts(files: &[(&str, &str)]) -> Debts {
    let mut reader = Reader::default();
    for (file, text) in files {
        reader.file = (*file).into();
        reader.visit_file(&syn::parse_file(text).unwrap_or_else(|e| panic!("{file}: {e}")));
    }
    reader.finish()
}

#[test]
fn debts_do_not_grow() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut paths = Vec::new();
    sources(&root, &mut paths);
    paths.sort();
    let name = |p: &PathBuf| p.strip_prefix(&root).unwrap().to_string_lossy().replace('\\', "/");
    let files: Vec<(String, String)> = paths.iter().map(|p| (name(p), fs::read_to_string(p).unwrap())).collect();
    let files: Vec<(&str, &str)> = files.iter().map(|(file, text)| (&file[..], &text[..])).collect();
    assert_eq!(debts(&files), OWED, "on the left what there is: more is a debt, less is to be written down");
}

#[test]
fn debts_are_counted() {
    let first = "
        const BARE: f64 = 1.0;
        /// With a word.
        const TOLD: f64 = 1.0;
        struct Shared;
        impl Shared {
            const OWN: usize = 3;
            fn few(&self, a: u8, b: u8, c: u8, d: u8, e: u8) {}
            fn many(a: u8, b: u8, c: u8, d: u8, e: u8, f: u8) {}
        }
        fn pair(at: (u8, u8), of: &(u8, u8)) -> (u8, u8) { at }
        fn nothing() -> () {}
        #[cfg(test)]
        mod tests {
            struct Other;
            const IN_TESTS: u8 = 1;
            fn many(a: u8, b: u8, c: u8, d: u8, e: u8, f: u8) {}
        }
    ";
    let again = "impl Shared { fn more(&self) {} }";
    let files = [
        ("mesh/first.rs", first),
        ("mesh/second.rs", again),
        ("mesh/third.rs", again),
        ("mesh/fourth.rs", again),
        ("io.rs", "enum Shared {} struct Other;"),
    ];
    let expected = Debts {
        long_lists: 1,
        tuples_returned: 1,
        tuples_taken: 2,
        names_in_rooms: 1,
        spread: 1,
        constants: 3,
        bare_constants: 2,
    };
    assert_eq!(debts(&files), expected);
}
