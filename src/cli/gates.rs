//! Which options which way of meshing knows: one that would do nothing is a mistake, and says so.

use std::fmt;
use std::path::{Path, PathBuf};

use clap::ArgMatches;
use clap::parser::ValueSource;
use rvachev::io::Format;
use rvachev::pipeline::{self, Method, PartKind};
use rvachev::{Error, Result};

/// What is meshed, and how, as far as that decides what an option does.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Gate {
    /// Solids of R-functions by the method leaf,
    Leaf,
    /// by operators in an order that may be said,
    Operators,
    /// by the sequences of the methods paper and cut,
    Fixed,
    /// by marching cubes alone,
    MarchingCubes,
    /// or by pieces.
    Bricks,
    Figure,
    Built,
    /// Set operations with solids given by boundaries,
    Joined,
    /// and what they know besides where R-functions take part.
    JoinedFunctions,
    /// How R-systems are compared.
    Systems,
    Cad,
    Triangles,
}

use Gate::{
    Bricks, Built, Cad, Figure, Fixed, Joined, JoinedFunctions, Leaf, MarchingCubes, Operators, Systems, Triangles,
};

/// The ways that have a method.
const METHODS: [Gate; 4] = [Leaf, Operators, Fixed, MarchingCubes];
/// The ways a part file may go.
const PARTS: [Gate; 8] = [Leaf, Operators, Fixed, MarchingCubes, Figure, Built, Joined, JoinedFunctions];

impl Gate {
    fn of(method: Method) -> Self {
        match method {
            Method::Leaf => Leaf,
            Method::Operators => Operators,
            Method::Paper | Method::Cut => Fixed,
            Method::MarchingCubes => MarchingCubes,
        }
    }

    /// What it is called beside `METHODS`.
    fn by(self) -> &'static str {
        match self {
            Leaf => "leaf",
            Operators => "operators",
            Fixed => "paper, cut",
            _ => "mc",
        }
    }
}

/// Several ways, for a message.
struct WayNames<'a>(&'a [Gate]);

impl fmt::Display for WayNames<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let by: Vec<&str> = METHODS.iter().filter(|g| self.0.contains(g)).map(|g| g.by()).collect();
        let mut all: Vec<String> = Vec::new();
        if !by.is_empty() {
            let how = if by.len() < METHODS.len() { format!(" by {}", by.join(", ")) } else { String::new() };
            all.push(format!("solids of functions{how}"));
        }
        for gate in self.0 {
            all.extend(match gate {
                Leaf | Operators | Fixed | MarchingCubes => None,
                Bricks => Some("bricks of solids of functions".into()),
                Figure => Some("plane figures".into()),
                Built => Some("solids built from edges".into()),
                Joined => Some("set operations with meshes or CAD models".into()),
                JoinedFunctions if self.0.contains(&Joined) => None,
                JoinedFunctions => Some("set operations of functions with meshes or CAD models".into()),
                Systems => Some("comparisons of R-systems".into()),
                Cad => Some("CAD models".into()),
                Triangles => Some("triangles".into()),
            });
        }
        f.write_str(&all.join("; "))
    }
}

/// Options that not all ways know, as they are called in the code and on the command line, and the ways that do.
const KNOWN: [(&str, &str, &[Gate]); 20] = [
    ("define", "-D", &[Leaf, Operators, Fixed, MarchingCubes, Bricks, Figure, Built, Joined, Systems]),
    ("eps", "--eps", &[Leaf, Operators, Fixed, MarchingCubes, Figure, JoinedFunctions, Systems]),
    ("angle", "--angle", &[Leaf, Operators, Fixed, Bricks, Figure, Built, Joined, Cad, Triangles]),
    ("tol", "--tol", &[Leaf, Operators, Fixed, Bricks, Figure, Built, Joined, Cad, Triangles]),
    ("size_min", "--size-min", &[Leaf, Operators, Fixed, Bricks, Figure, Built, Joined, Cad, Triangles]),
    ("grading", "--grading", &[Leaf, Bricks, Figure, Built, Joined, Cad, Triangles]),
    ("refine", "--refine", &[Leaf, Figure, Built, Joined, Cad, Triangles]),
    ("remesh", "--remesh", &[Leaf, Built, Cad, Triangles]),
    ("thickness", "--thickness", &[Leaf]),
    ("method", "--method", &[Leaf, Operators, Fixed, MarchingCubes, Bricks, Figure, Joined]),
    ("sequence", "--sequence", &[Operators]),
    ("bricks", "--bricks", &[Bricks]),
    ("trim", "--trim", &[Built, Cad]),
    ("volume", "--volume", &[Built, Cad]),
    ("without", "--without", &[Built, Cad]),
    ("feature_angle", "--feature-angle", &[Triangles]),
    ("min_area", "--min-area", &[Triangles]),
    ("min_length", "--min-length", &[Triangles]),
    ("nodes", "--nodes", &[Triangles]),
    ("close", "--close", &[Triangles]),
];

/// The options above that the user wrote, by the names the code has for them: what is there by default is not asked for.
#[derive(Debug, Clone, Default)]
pub struct WrittenOptions(Vec<&'static str>);

fn is_given(matches: &ArgMatches, id: &str) -> bool {
    matches.try_contains_id(id).is_ok() && matches.value_source(id) == Some(ValueSource::CommandLine)
}

impl WrittenOptions {
    fn of(matches: &ArgMatches) -> Self {
        Self(KNOWN.iter().map(|k| k.0).filter(|id| is_given(matches, id)).collect())
    }

    /// Refuses what none of the ways a file may go knows: [`Error::Usage`] names the ways that do.
    fn known_to(&self, ways: &[Gate], path: &Path) -> Result<()> {
        for (id, name, gates) in KNOWN {
            if self.0.contains(&id) && !gates.iter().any(|g| ways.contains(g)) {
                let (good, path) = (WayNames(gates), path.display());
                // Where much may be asked for yet there is only the file's name to tell.
                let bad =
                    if ways.len() > 2 { String::new() } else { format!(", which is meshed as {}", WayNames(ways)) };
                return Err(Error::Usage(format!("{name} is for {good}; not for {path}{bad}")));
            }
        }
        Ok(())
    }

    /// Refuses what the way a part goes does not know, now that its file is read.
    pub fn known_to_part(&self, kind: PartKind, method: Method, path: &Path) -> Result<()> {
        let functions = Gate::of(method);
        let ways = match kind {
            PartKind::Functions => vec![functions],
            PartKind::Figure => vec![Figure],
            PartKind::Built => vec![Built],
            PartKind::BuiltBesideFunctions => vec![Built, functions],
            PartKind::Joined => vec![Joined],
            PartKind::JoinedFunctions => vec![Joined, JoinedFunctions],
        };
        self.known_to(&ways, path)
    }
}

/// Refuses options of a command that its input does not know, as far as the file's ending tells, and options of files that no file
/// written heeds. What the user gave, for [`WrittenOptions::known_to_part`].
pub fn check(matches: &ArgMatches) -> Result<WrittenOptions> {
    let Some((command, matches)) = matches.subcommand() else { return Ok(WrittenOptions::default()) };
    check_files(matches)?;
    let given = WrittenOptions::of(matches);
    let flag = |id: &str| matches!(matches.try_get_one::<bool>(id), Ok(Some(true)));
    let path: &Path = match matches.try_get_one::<PathBuf>("part") {
        Ok(Some(path)) => path,
        // They are part files, which are not given.
        _ if flag("samples") => Path::new("--samples"),
        _ => return Ok(given),
    };
    let ways = if pipeline::is_step(path) {
        vec![Cad]
    } else if pipeline::is_mesh(path) {
        vec![Triangles]
    } else if command == "plan" || is_given(matches, "bricks") {
        vec![Bricks]
    } else if flag("rsystems") {
        vec![Systems]
    } else if command == "compare" {
        METHODS.into()
    } else {
        let said = matches.try_get_one::<Method>("method").ok().flatten().map(|m| Gate::of(*m));
        PARTS.into_iter().filter(|g| said.is_none_or(|said| *g == said || !METHODS.contains(g))).collect()
    };
    given.known_to(&ways, path)?;
    Ok(given)
}

/// An option of mesh files: its name in the code and on the command line, and the files that heed it.
struct FileOption {
    id: &'static str,
    name: &'static str,
    heeds: fn(Format) -> bool,
    which: &'static str,
}

/// Refuses options of mesh files where none that is written heeds them.
fn check_files(matches: &ArgMatches) -> Result<()> {
    let Ok(Some(outputs)) = matches.try_get_many::<PathBuf>("output") else { return Ok(()) };
    // An ending that is not known is told later.
    let formats: Vec<Format> = outputs.filter_map(|p| Format::from_path(p).ok()).collect();
    let heeds = [
        FileOption {
            id: "msh_version",
            name: "--msh-version",
            heeds: |f| matches!(f, Format::Msh | Format::Geo),
            which: ".msh and .geo",
        },
        FileOption {
            id: "groups",
            name: "--groups",
            heeds: Format::heeds_groups,
            which: ".msh, .geo, .inp, .bdf, .nas, .med, .mesh, .su2, .vtp and .glb",
        },
    ];
    for FileOption { id, name, heeds, which } in heeds {
        if is_given(matches, id) && !formats.is_empty() && !formats.iter().any(|f| heeds(*f)) {
            return Err(Error::Usage(format!("{name} is for {which} files, and none of these is written")));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use clap::CommandFactory;

    use super::super::arguments::Cli;
    use super::*;

    fn value(id: &str) -> Option<&'static str> {
        match id {
            "define" => Some("a=1"),
            "method" => Some("leaf"),
            "sequence" => Some("N"),
            "bricks" => Some("1x1x1"),
            "without" => Some("plane"),
            "refine" => Some("sphere=0,0,0,1:0.1"),
            "remesh" => Some("top=0.1"),
            "nodes" => Some("500"),
            "close" => None,
            _ => Some("1e-3"),
        }
    }

    fn checked(words: &[&str]) -> Result<WrittenOptions> {
        check(&Cli::command().try_get_matches_from(words).unwrap())
    }

    #[test]
    fn every_option_is_known_to_the_kinds_of_input_it_says_and_refused_by_the_others() {
        let inputs = [("a.py", &PARTS[..]), ("a.step", &[Cad]), ("a.stl", &[Triangles])];
        for (id, name, gates) in KNOWN {
            for (path, ways) in inputs {
                let mut words = vec!["rvachev", "mesh", path, "-o", "a.off", name];
                words.extend(value(id));
                let good = ways.iter().any(|g| gates.contains(g)) || id == "bricks" && path == "a.py";
                assert_eq!(checked(&words).is_ok(), good, "{words:?}");
            }
        }
        for (words, good) in [
            (&["--sequence", "N"][..], true),
            (&["--nodes", "500"], false),
            (&["--close"], false),
            (&["--trim", "1"], false),
        ] {
            let all = ["rvachev", "compare", "--samples"].iter().chain(words).copied().collect::<Vec<_>>();
            assert_eq!(checked(&all).is_ok(), good, "{words:?}");
        }
        // What is not given is not refused, nor what a command does not have.
        for words in [&["rvachev", "mesh", "a.stl", "-o", "a.off"][..], &["rvachev", "render", "a.stl", "-o", "a.png"]]
        {
            assert!(checked(words).is_ok());
        }
    }

    #[test]
    fn options_of_files_are_for_files_that_heed_them() {
        for (output, version, groups) in [("a.msh", true, true), ("a.geo", true, true), ("a.off", false, false)]
            .into_iter()
            .chain([("a.inp", false, true), ("a.glb", false, true), ("a.vtu", false, false), ("a.svg", false, false)])
        {
            for (option, good) in [(["--msh-version", "2.2"], version), (["--groups", "all"], groups)] {
                for command in [&["mesh", "a.py"][..], &["heal", "a.stl"], &["join", "a.stl", "b.stl"], &["merge", "a"]]
                {
                    let words: Vec<&str> = [&["rvachev"][..], command, &["-o", output], &option].concat();
                    assert_eq!(checked(&words).is_ok(), good, "{words:?}");
                }
            }
        }
        assert!(checked(&["rvachev", "mesh", "a.py", "-o", "a.off", "-o", "a.msh", "--groups", "all"]).is_ok());
    }

    /// What the table says is what the parts of each kind take: see tests/idle_options.rs.
    #[test]
    fn messages_name_the_ways_that_know_an_option() {
        let told = |e: Error| e.to_string();
        let words = ["rvachev", "mesh", "a.py", "-o", "a.off", "--method", "mc", "--grading", "0.3"];
        let given = checked(&words).unwrap();
        let refused = given.known_to_part(PartKind::Functions, Method::MarchingCubes, Path::new("a.py")).unwrap_err();
        let refused = told(refused);
        assert!(refused.contains("--grading is for solids of functions by leaf; "), "{refused}");
        assert!(refused.contains("not for a.py, which is meshed as solids of functions by mc"), "{refused}");
        assert!(given.known_to_part(PartKind::Figure, Method::Leaf, Path::new("a.py")).is_ok());
        let refused = told(checked(&["rvachev", "mesh", "a.stl", "-o", "a.off", "--volume", "0.1"]).unwrap_err());
        assert!(refused.contains("--volume is for solids built from edges; CAD models; not for a.stl"), "{refused}");
    }
}
