//! How `benches/compare.py` judges times, and what it answers to bad input.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

fn python(args: &[&str]) -> Output {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("benches");
    Command::new("python3").arg("-B").args(args).current_dir(folder).output().expect("python3 is on the path")
}

/// What the script makes of the seconds of three rounds: its line, and whether the stage is slower.
fn judged(base: &str, head: &str) -> String {
    let script = format!("import compare; print(*compare.row('a', {base}, {head}, 1.1))");
    let out = python(&["-c", &script]);
    assert!(out.status.success(), "{}", String::from_utf8_lossy(&out.stderr));
    String::from_utf8_lossy(&out.stdout).trim().to_string()
}

#[test]
fn a_stage_is_slower_where_the_ratio_is_large_and_no_round_says_otherwise() {
    for (base, head, line) in [
        ("[1, 1.1, 1.2]", "[1.5, 1.65, 1.8]", "| a | 1100.00 | 1650.00 | 1.500 | 1.500 to 1.500 | **slower** | True"),
        // A large ratio, though one round of the head is as fast as the base.
        ("[1, 1, 1]", "[1.3, 1.3, 1]", "| a | 1000.00 | 1300.00 | 1.300 | 1.000 to 1.300 |  | False"),
        // Slower in each round, by less than is asked about.
        ("[1, 1, 1]", "[1.05, 1.05, 1.05]", "| a | 1000.00 | 1050.00 | 1.050 | 1.050 to 1.050 |  | False"),
        ("[2, 2, 2]", "[1, 1, 1]", "| a | 2000.00 | 1000.00 | 0.500 | 0.500 to 0.500 | faster | False"),
        ("[]", "[1, 1, 1]", "| a | | | only in head | | | False"),
    ] {
        assert_eq!(judged(base, head), line);
    }
}

#[test]
fn bad_input_is_code_2_and_named() {
    for (args, says) in [
        (&["compare.py", "no-such-commit", "HEAD"][..], "'no-such-commit' is no commit"),
        (&["compare.py", "HEAD", "--end-of-options"][..], "required: head"),
        (&["compare.py", "HEAD"][..], "required: head"),
        (&["compare.py", "HEAD", "HEAD", "--rounds", "0"][..], "--rounds must be at least 1"),
        (&["compare.py", "HEAD", "HEAD", "--slower", "nan"][..], "--slower positive"),
        (&["compare.py", "HEAD", "HEAD", "--bench", "../a"][..], "is no name of a bench"),
    ] {
        let out = python(args);
        let err = String::from_utf8_lossy(&out.stderr);
        assert_eq!(out.status.code(), Some(2), "{args:?}: {err}");
        assert!(err.contains(says), "{args:?}: {err}");
    }
}

/// A repository with the script, and a crate whose bench writes what criterion would: known times.
struct Repository(tempfile::TempDir);

impl Repository {
    fn new() -> Self {
        let new = Self(tempfile::tempdir().unwrap());
        fs::create_dir_all(new.path("benches")).unwrap();
        fs::create_dir_all(new.path("src")).unwrap();
        let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("benches/compare.py");
        fs::copy(script, new.path("benches/compare.py")).unwrap();
        fs::write(new.path(".gitignore"), "/target\nCargo.lock\n").unwrap();
        fs::write(new.path("src/lib.rs"), "//! Nothing.\n").unwrap();
        fs::write(new.path("Cargo.toml"), "[package]\nname = \"small\"\nversion = \"0.0.0\"\nedition = \"2024\"\n")
            .unwrap();
        new.git(&["init", "-q"]);
        new.commit("none");
        new
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn git(&self, args: &[&str]) {
        let who = ["-c", "user.name=a", "-c", "user.email=a@b", "-c", "commit.gpgsign=false"];
        let out =
            Command::new("git").args(who).args(args).current_dir(self.0.path()).output().expect("git is on the path");
        assert!(out.status.success(), "{}", String::from_utf8_lossy(&out.stderr));
    }

    fn commit(&self, tag: &str) {
        self.git(&["add", "-A"]);
        self.git(&["commit", "-q", "-m", tag]);
        self.git(&["tag", tag]);
    }

    /// A bench whose stages take so many nanoseconds, in a commit of its own.
    fn bench(&self, tag: &str, stages: &[(&str, u32)]) {
        let program = format!(
            r#"//! Known times.
fn main() {{
    let home = std::path::PathBuf::from(std::env::var_os("CRITERION_HOME").unwrap());
    for (name, time) in {stages:?} {{
        let to = home.join(name).join("new");
        std::fs::create_dir_all(&to).unwrap();
        std::fs::write(to.join("benchmark.json"), format!("{{{{\"full_id\": \"{{name}}\"}}}}")).unwrap();
        std::fs::write(to.join("estimates.json"), format!("{{{{\"median\": {{{{\"point_estimate\": {{time}}}}}}}}}}")).unwrap();
    }}
}}
"#
        );
        fs::write(self.path("benches/stages.rs"), program).unwrap();
        let manifest = fs::read_to_string(self.path("Cargo.toml")).unwrap();
        if !manifest.contains("[[bench]]") {
            fs::write(self.path("Cargo.toml"), manifest + "\n[[bench]]\nname = \"stages\"\nharness = false\n").unwrap();
        }
        self.commit(tag);
    }

    fn compare(&self, base: &str, head: &str) -> (Option<i32>, String) {
        let args = ["-B", "benches/compare.py", base, head, "--rounds", "2"];
        let out =
            Command::new("python3").args(args).current_dir(self.0.path()).output().expect("python3 is on the path");
        let said = [out.stdout, out.stderr].concat();
        (out.status.code(), String::from_utf8_lossy(&said).into_owned())
    }
}

#[test]
fn commits_are_built_and_their_times_compared() {
    let repository = Repository::new();
    repository.bench("plain", &[("read", 2_000_000), ("mesh", 10_000_000)]);
    repository.bench("slow", &[("read", 1_000_000), ("mesh", 12_500_000)]);
    let (code, said) = repository.compare("plain", "slow");
    assert_eq!(code, Some(1), "{said}");
    for line in [
        "| mesh | 10.00 | 12.50 | 1.250 | 1.250 to 1.250 | **slower** |",
        "| read | 2.00 | 1.00 | 0.500 | 0.500 to 0.500 | faster |",
        "1 of 2 stages are slower by more than a factor of 1.1.",
    ] {
        assert!(said.contains(line), "{said}\nlacks {line}");
    }
    // A base without the bench gets that of the head, and is told to.
    let (code, said) = repository.compare("none", "slow");
    assert_eq!(code, Some(0), "{said}");
    assert!(said.contains("none has no benches/stages.rs: that of slow is used for both."), "{said}");
    assert!(said.contains("| mesh | 12.50 | 12.50 | 1.000 |"), "{said}");
    let (code, said) = repository.compare("slow", "none");
    assert_eq!(code, Some(2), "{said}");
    assert!(said.contains("none has no benches/stages.rs"), "{said}");
    // Worktrees are gone.
    assert!(!repository.path("target/compare/base/tree").exists());
}
