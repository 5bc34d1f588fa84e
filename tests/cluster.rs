//! Bricks by SLURM's array jobs, for real: daemons of one machine, started as root by the script that users read. It is run by
//! `cargo test --release --test cluster -- --ignored`, as root and where SLURM is installed.

use std::fs;
use std::path::Path;
use std::process::Command;

#[test]
#[ignore = "starts SLURM's daemons: needs root and Debian's slurm-wlm and munge"]
fn array_jobs_of_slurm_give_the_bytes_of_one_process() {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("slurm");
    let _ = fs::remove_dir_all(&folder);
    fs::create_dir_all(&folder).unwrap();
    let (part, alone) = (folder.join("part.py"), folder.join("alone.stl"));
    fs::write(&part, "part(box(size=(2, 2, 2)) - cylinder(0.4, axis='x') - cylinder(0.4, axis='z'))\n").unwrap();
    let rvachev = env!("CARGO_BIN_EXE_rvachev");
    let made = Command::new(rvachev)
        .args(["mesh", "--size", "0.05", "--bricks", "2x2x1", "-q", "-o"])
        .args([&alone, &part])
        .output()
        .unwrap();
    assert!(made.status.success(), "{}", String::from_utf8_lossy(&made.stderr));
    // A socket's path may be 107 bytes long.
    let job = tempfile::tempdir().unwrap();
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/cluster/slurm.sh");
    let out = Command::new("timeout")
        .args(["-s", "TERM", "300", "bash"])
        .arg(script)
        .args([rvachev, part.to_str().unwrap(), "0.05", "2x2x1", "3", job.path().to_str().unwrap()])
        .output()
        .unwrap();
    let said = String::from_utf8_lossy(&out.stdout).into_owned() + &String::from_utf8_lossy(&out.stderr);
    assert!(out.status.success(), "{said}");
    assert_eq!(fs::read(job.path().join("merged.stl")).unwrap(), fs::read(alone).unwrap(), "{said}");
}
