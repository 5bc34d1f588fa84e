//! The Python package: built, installed beside pinned packages into a virtual environment below `target/python-env`, and tested by
//! `python/tests` with pytest.
//!
//! Needs Python 3.10 or newer with `venv`, and the package index at the first use. What is missing fails, saying so.

use std::collections::hash_map::DefaultHasher;
use std::fs;
use std::hash::{Hash, Hasher};
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// The first Python that is new enough, and what it calls itself.
fn find_python() -> Result<(&'static str, String), String> {
    let mut found = Vec::new();
    for name in ["python3", "python"] {
        let Ok(out) = Command::new(name).args(["-c", "import sys; print(*sys.version_info[:2])"]).output() else {
            continue;
        };
        let text = String::from_utf8_lossy(&out.stdout).trim().to_string();
        let numbers: Vec<u32> = text.split(' ').filter_map(|w| w.parse().ok()).collect();
        if numbers.len() == 2 && numbers >= vec![3, 10] {
            return Ok((name, format!("Python {}.{}", numbers[0], numbers[1])));
        }
        found.push(format!("`{name}` is {text:?}"));
    }
    Err(format!(
        "Python 3.10 or newer is needed on the path; {}",
        if found.is_empty() { "there is none".into() } else { found.join(", ") }
    ))
}

/// Runs to the end; all it printed if it failed.
fn done(command: &mut Command) -> Result<Output, String> {
    let out = command.output().map_err(|e| format!("{command:?}: {e}"))?;
    if out.status.success() {
        return Ok(out);
    }
    let said = [&out.stdout[..], &out.stderr[..]].concat();
    Err(format!("{command:?}: {}\n{}", out.status, String::from_utf8_lossy(&said)))
}

/// A virtual environment with the pinned packages; its Python and its folder of programs.
fn environment(package: &Path) -> Result<(PathBuf, PathBuf), String> {
    let requirements = package.join("tests/requirements.txt");
    let (system, version) = find_python()?;
    let mut hash = DefaultHasher::new();
    (fs::read_to_string(&requirements).map_err(|e| e.to_string())?, &version).hash(&mut hash);
    let all = Path::new(env!("CARGO_TARGET_TMPDIR")).with_file_name("python-env");
    let folder = all.join(format!("{:016x}", hash.finish()));
    let programs = folder.join(if cfg!(windows) { "Scripts" } else { "bin" });
    let python = programs.join(if cfg!(windows) { "python.exe" } else { "python" });
    let ready = folder.join("ready");
    fs::create_dir_all(&all).map_err(|e| format!("cannot create {}: {e}", all.display()))?;
    // Two test runs at once must not fill the same folder.
    let lock = fs::File::create(all.join("lock")).map_err(|e| e.to_string())?;
    lock.lock().map_err(|e| e.to_string())?;
    if !ready.exists() {
        let _ = fs::remove_dir_all(&folder);
        done(Command::new(system).args(["-m", "venv"]).arg(&folder)).map_err(|e| {
            format!("{version} cannot make a virtual environment (Debian: apt install python3-venv)\n{e}")
        })?;
        done(Command::new(&python).args(["-m", "pip", "install", "--quiet", "-r"]).arg(&requirements))
            .map_err(|e| format!("pip could not install {}\n{e}", requirements.display()))?;
        fs::write(&ready, &version).map_err(|e| e.to_string())?;
    }
    Ok((python, programs))
}

fn tested() -> Result<String, String> {
    let package = Path::new(env!("CARGO_MANIFEST_DIR")).join("python");
    let (python, programs) = environment(&package)?;
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
