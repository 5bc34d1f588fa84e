//! Fidget and rvachev on the same parts, in one process, on one thread.
//!
//!     cargo run --release --manifest-path benches/fidget/Cargo.toml [-- FILTER...] [--reps N]
//!     cargo run --release --manifest-path benches/fidget/Cargo.toml -- mesh PART N OUT.off [--reps N]
//!
//! The second writes fidget's mesh of one part, for other programs to go on with, and prints its CPU seconds.
//! Times are seconds of this process's CPU, the least of N repetitions, the two programs taking turns. They run from the
//! finished description of a solid to the finished mesh: fidget's shape, octree and dual contouring; our lowering, octree
//! and marching cubes. Cells have the same size on both sides. Fidget works in f32 with machine code made on the spot,
//! on min and max of exact signed distances; we in f64 on a tree of R-functions, whose signs are min and max of its leaves: values of
//! R-functions are needed in few cells, so R0 and min/max cost about the same.

mod ours;
mod part;
mod theirs;

use std::process::Command;

use cpu_time::ProcessTime;
use part::Part;
use rvachev::implicit::RSystem;

/// The least CPU time of several runs, and what the last one made.
struct Timed {
    seconds: f64,
    triangles: usize,
}

fn timed(best: &mut Option<Timed>, run: impl FnOnce() -> usize) {
    let start = ProcessTime::now();
    let triangles = run();
    let seconds = start.elapsed().as_secs_f64().min(best.as_ref().map_or(f64::INFINITY, |b| b.seconds));
    *best = Some(Timed { seconds, triangles });
}

/// Runs each contender in turn, `reps` rounds.
fn race(reps: usize, contenders: &mut [&mut dyn FnMut() -> usize]) -> Vec<Timed> {
    let mut best: Vec<Option<Timed>> = contenders.iter().map(|_| None).collect();
    for _ in 0..reps {
        for (contender, best) in contenders.iter_mut().zip(&mut best) {
            timed(best, contender);
        }
    }
    best.into_iter().map(|b| b.expect("at least one round")).collect()
}

struct Options {
    filters: Vec<String>,
    reps: usize,
}

impl Options {
    fn wants(&self, title: &str) -> bool {
        self.filters.is_empty() || self.filters.iter().any(|f| title.contains(f.as_str()))
    }
}

fn options(arguments: &[String]) -> Option<Options> {
    let mut options = Options { filters: Vec::new(), reps: 3 };
    let mut rest = arguments.iter();
    while let Some(a) = rest.next() {
        match a.as_str() {
            "--reps" => options.reps = rest.next()?.parse().ok().filter(|n| *n > 0)?,
            a if a.starts_with('-') => return None,
            a => options.filters.push(a.to_string()),
        }
    }
    Some(options)
}

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    if arguments == ["peak-memory"] {
        ours::mesh(&part::cube_with_holes(), 512, RSystem::R0);
        println!("{}", peak_mib().unwrap_or(f64::NAN));
        return;
    }
    let Some(options) = options(&arguments) else {
        eprintln!("usage: fidget-bench [FILTER...] [--reps N]\n       fidget-bench mesh PART N OUT.off [--reps N]");
        std::process::exit(2);
    };
    if let [command, part, n, out] = &options.filters[..]
        && command == "mesh"
    {
        if let Err(why) = write_theirs(part, n, out, options.reps) {
            eprintln!("{why}");
            std::process::exit(2);
        }
        return;
    }
    against_fidget(&options);
    against_ourselves(&options);
    growth(&options);
    memory(&options);
}

/// Fidget's mesh of one part as an OFF file; its least CPU seconds on the standard output. The writing is not timed.
fn write_theirs(name: &str, n: &str, out: &str, reps: usize) -> Result<(), String> {
    let parts = [part::cube_with_holes(), part::rotated_cube_with_holes(), part::bracket(), part::gyroid_block()];
    let known = parts.each_ref().map(|p| p.name.as_str()).join(", ");
    let part = parts.iter().find(|p| p.name == name).ok_or(format!("no part `{name}`; there are {known}"))?;
    let cells = n.parse::<u32>().ok().filter(|n| n.is_power_of_two());
    let cells = cells.ok_or(format!("the cells to the side are a power of two, not `{n}`"))?;
    let tree = theirs::tree(&part.shape);
    let mut mesh = None;
    let mut run = || mesh.insert(theirs::mesh(&tree, part.half, cells)).triangles.len();
    let times = race(reps, &mut [&mut run]);
    let mesh = mesh.expect("at least one round");
    let mut text = format!("OFF\n{} {} 0\n", mesh.vertices.len(), mesh.triangles.len());
    mesh.vertices.iter().for_each(|v| text += &format!("{} {} {}\n", v.x, v.y, v.z));
    mesh.triangles.iter().for_each(|t| text += &format!("3 {} {} {}\n", t.x, t.y, t.z));
    std::fs::write(out, text).map_err(|e| format!("{out}: {e}"))?;
    println!("{}", times[0].seconds);
    Ok(())
}

fn against_fidget(options: &Options) {
    let rows: Vec<(Part, &[u32])> = vec![
        (part::cube_with_holes(), &[64, 256]),
        (part::rotated_cube_with_holes(), &[64, 256]),
        (part::bracket(), &[64, 128, 256]),
        (part::many(1000), &[64]),
    ];
    heading("fidget min/max", "ours R0", "ours / fidget");
    for (part, sizes) in rows {
        for &n in sizes.iter().filter(|n| options.wants(&title(&part, **n))) {
            let tree = theirs::tree(&part.shape);
            let times = race(
                options.reps,
                &mut [&mut || theirs::mesh(&tree, part.half, n).triangles.len(), &mut || {
                    ours::mesh(&part, n, RSystem::R0)
                }],
            );
            row(&title(&part, n), &times);
        }
    }
    println!();
}

fn against_ourselves(options: &Options) {
    heading("ours min/max", "ours R0", "R0 / min/max");
    for (part, n) in
        [(part::cube_with_holes(), 256), (part::bracket(), 256), (part::many(1000), 64), (part::many(10_000), 64)]
    {
        if options.wants(&title(&part, n)) {
            let times = race(
                options.reps,
                &mut [&mut || ours::mesh(&part, n, RSystem::MinMax), &mut || ours::mesh(&part, n, RSystem::R0)],
            );
            row(&title(&part, n), &times);
        }
    }
    println!();
}

fn growth(options: &Options) {
    heading("ours N / 2", "ours N", "per doubling");
    for part in [part::cube_with_holes(), part::bracket()] {
        for n in [256, 512] {
            if options.wants(&title(&part, n)) {
                let times = race(
                    options.reps,
                    &mut [&mut || ours::mesh(&part, n / 2, RSystem::R0), &mut || ours::mesh(&part, n, RSystem::R0)],
                );
                row(&title(&part, n), &times);
            }
        }
    }
    println!();
}

/// A process of its own, for its peak is its own.
fn memory(options: &Options) {
    let title = title(&part::cube_with_holes(), 512);
    if !options.wants(&title) {
        return;
    }
    let out = std::env::current_exe().and_then(|exe| Command::new(exe).arg("peak-memory").output());
    let text = out.map(|o| String::from_utf8_lossy(&o.stdout).trim().to_string()).unwrap_or_default();
    match text.parse::<f64>() {
        Ok(mib) if mib.is_finite() => println!("{title}: peak of {mib:.0} MiB, ours R0"),
        _ => println!("{title}: peak memory is not known on this system"),
    }
}

/// The most memory this process has held, where the system tells.
fn peak_mib() -> Option<f64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|l| l.starts_with("VmHWM"))?;
    Some(line.split_whitespace().nth(1)?.parse::<f64>().ok()? / 1024.0)
}

fn title(part: &Part, n: u32) -> String {
    format!("{}, N={n}", part.name)
}

fn heading(first: &str, second: &str, ratio: &str) {
    println!("{:<32}{first:>18}{second:>14}{ratio:>16}{:>26}", "CPU seconds", "triangles");
}

fn row(title: &str, times: &[Timed]) {
    let [a, b] = times else { unreachable!("two contenders") };
    println!(
        "{title:<32}{:>18.4}{:>14.4}{:>16.2}{:>13}{:>13}",
        a.seconds,
        b.seconds,
        b.seconds / a.seconds,
        a.triangles,
        b.triangles
    );
}
