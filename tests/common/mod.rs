//! Python with pinned packages, for the tests that ask other programs.
//!
//! The first use of a name makes a virtual environment below the target folder; that needs Python 3.10 or newer with `venv`, and
//! the package index.

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
pub fn done(command: &mut Command) -> Result<Output, String> {
    let out = command.output().map_err(|e| format!("{command:?}: {e}"))?;
    if out.status.success() {
        return Ok(out);
    }
    let said = [&out.stdout[..], &out.stderr[..]].concat();
    Err(format!("{command:?}: {}\n{}", out.status, String::from_utf8_lossy(&said)))
}

/// The Python of a virtual environment with the packages of a file of requirements. Environments of one name lie in
/// `target/NAME`, one for each version of Python and of the requirements.
pub fn environment(name: &str, requirements: &Path) -> Result<PathBuf, String> {
    let (system, version) = find_python()?;
    let mut hash = DefaultHasher::new();
    (fs::read_to_string(requirements).map_err(|e| e.to_string())?, &version).hash(&mut hash);
    let all = Path::new(env!("CARGO_TARGET_TMPDIR")).with_file_name(name);
    let folder = all.join(format!("{:016x}", hash.finish()));
    let python = folder.join(if cfg!(windows) { "Scripts/python.exe" } else { "bin/python" });
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
        done(Command::new(&python).args(["-m", "pip", "install", "--quiet", "-r"]).arg(requirements))
            .map_err(|e| format!("pip could not install {}\n{e}", requirements.display()))?;
        fs::write(&ready, &version).map_err(|e| e.to_string())?;
    }
    Ok(python)
}
