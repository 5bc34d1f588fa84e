//! Which options which kind of input knows: one that would do nothing is a mistake, and says so.

use std::fmt;
use std::path::Path;

use clap::ArgMatches;
use clap::parser::ValueSource;
use rvachev::pipeline;
use rvachev::{Error, Result};

/// What an input file holds, as far as its ending tells.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Gate {
    /// Solids of R-functions, or solids built from edges.
    Part,
    Cad,
    Triangles,
}

impl fmt::Display for Gate {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Gate::Part => "parts of functions",
            Gate::Cad => "CAD models",
            Gate::Triangles => "triangles",
        })
    }
}

/// Options that not all kinds of input know, as they are called in the code and on the command line, and the kinds that do.
const KNOWN: [(&str, &str, &[Gate]); 15] = [
    ("define", "-D", &[Gate::Part]),
    ("eps", "--eps", &[Gate::Part]),
    ("memory", "--memory", &[Gate::Part, Gate::Cad, Gate::Triangles]),
    ("thickness", "--thickness", &[Gate::Part]),
    ("method", "--method", &[Gate::Part]),
    ("sequence", "--sequence", &[Gate::Part]),
    ("bricks", "--bricks", &[Gate::Part]),
    ("trim", "--trim", &[Gate::Part, Gate::Cad]),
    ("volume", "--volume", &[Gate::Part, Gate::Cad]),
    ("without", "--without", &[Gate::Part, Gate::Cad]),
    ("feature_angle", "--feature-angle", &[Gate::Triangles]),
    ("min_area", "--min-area", &[Gate::Triangles]),
    ("min_length", "--min-length", &[Gate::Triangles]),
    ("nodes", "--nodes", &[Gate::Triangles]),
    ("close", "--close", &[Gate::Triangles]),
];

/// Refuses options of a command that its input does not know: [`Error::Usage`] names the kinds of input that do.
pub fn check(matches: &ArgMatches) -> Result<()> {
    let Some((_, given)) = matches.subcommand() else { return Ok(()) };
    let samples = matches!(given.try_get_one::<bool>("samples"), Ok(Some(true)));
    let path: &Path = match given.try_get_one::<std::path::PathBuf>("part") {
        Ok(Some(path)) => path,
        // They are part files, which are not given.
        _ if samples => Path::new("--samples"),
        _ => return Ok(()),
    };
    let gate = if pipeline::is_step(path) {
        Gate::Cad
    } else if pipeline::is_mesh(path) {
        Gate::Triangles
    } else {
        Gate::Part
    };
    for (id, name, gates) in KNOWN {
        let is_given = given.try_contains_id(id).is_ok() && given.value_source(id) == Some(ValueSource::CommandLine);
        if is_given && !gates.contains(&gate) {
            let all: Vec<String> = gates.iter().map(Gate::to_string).collect();
            let what = format!("{name} is for {}, and {} is none of these", all.join(" and "), path.display());
            return Err(Error::Usage(what));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use clap::CommandFactory;

    use super::super::arguments::Cli;
    use super::*;

    #[test]
    fn every_option_is_known_to_the_kinds_of_input_it_says_and_refused_by_the_others() {
        let inputs = [("a.py", Gate::Part), ("a.step", Gate::Cad), ("a.stl", Gate::Triangles)];
        let value = |id: &str| match id {
            "define" => Some("a=1"),
            "method" => Some("leaf"),
            "sequence" => Some("N"),
            "bricks" => Some("1x1x1"),
            "without" => Some("plane"),
            "close" => None,
            _ => Some("1e-3"),
        };
        for (id, name, gates) in KNOWN {
            for (path, gate) in inputs {
                let mut words = vec!["rvachev", "mesh", path, "-o", "a.off", name];
                words.extend(if id == "nodes" { Some("500") } else { value(id) });
                let matches = Cli::command().try_get_matches_from(&words).unwrap();
                assert_eq!(check(&matches).is_ok(), gates.contains(&gate), "{words:?}");
            }
        }
        for (words, good) in [(&["--sequence", "N"][..], true), (&["--nodes", "500"], false), (&["--close"], false)] {
            let all = ["rvachev", "compare", "--samples"].iter().chain(words);
            assert_eq!(check(&Cli::command().try_get_matches_from(all).unwrap()).is_ok(), good, "{words:?}");
        }
        // What is not given is not refused, nor what a command does not have.
        for words in [&["rvachev", "mesh", "a.stl", "-o", "a.off"][..], &["rvachev", "render", "a.stl", "-o", "a.png"]]
        {
            assert!(check(&Cli::command().try_get_matches_from(words).unwrap()).is_ok());
        }
    }
}
