//! Progress as it is shown: a bar on a terminal, a line now and then in a log.

use std::io::IsTerminal;
use std::sync::{Arc, Condvar, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressState, ProgressStyle};
use rvachev::run::Progress;

use super::console::visible;

/// How often a log gets a line; shorter runs leave none.
const EVERY: Duration = Duration::from_secs(10);

/// Time left is told of stages that took this long,
const LONG: Duration = Duration::from_secs(3);
/// of which at least this share is done,
const STARTED: f64 = 0.05;
/// and whose share has grown this often: one that jumps tells no speed.
const GROWN: usize = 5;

/// Where a run is.
#[derive(Debug, Clone)]
struct Whereabouts {
    stage: String,
    done: f64,
    triangles: Option<usize>,
    /// About how many there will be.
    expected: Option<usize>,
    /// How often the share has grown.
    grown: usize,
    since: Instant,
    /// When the share grew last.
    last: Instant,
}

impl Whereabouts {
    fn new() -> Self {
        let now = Instant::now();
        Self { stage: String::new(), done: 0.0, triangles: None, expected: None, grown: 0, since: now, last: now }
    }

    fn reported(&mut self, stage: &str, done: f64) {
        if self.stage != stage {
            *self = Self { stage: stage.to_string(), expected: self.expected, ..Self::new() };
        }
        if done > self.done {
            (self.done, self.grown, self.last) = (done, self.grown + 1, Instant::now());
        }
    }

    /// Seconds until the stage ends, if it goes on as it did.
    fn left(&self, now: Instant) -> Option<f64> {
        let took = self.last.duration_since(self.since);
        if took < LONG || self.done < STARTED || self.done >= 1.0 || self.grown < GROWN {
            return None;
        }
        let passed = now.duration_since(self.last).as_secs_f64();
        let left = took.as_secs_f64() * (1.0 - self.done) / self.done - passed;
        // A stage that has stopped growing has no speed any more.
        (left > 0.0).then_some(left)
    }

    /// What stands behind the share: triangles, seconds of the whole run, and seconds left.
    fn rest(&self, elapsed: f64, now: Instant) -> String {
        let mut out = String::new();
        if let Some(n) = self.triangles {
            out.push_str(&format!("{n} triangles, "));
        }
        if let Some(n) = self.expected {
            out.push_str(&format!("about {n} in the end, "));
        }
        out.push_str(&time(elapsed));
        if let Some(left) = self.left(now) {
            out.push_str(&format!(", stage ends in {}", time(left)));
        }
        out
    }
}

/// A time as people say it.
fn time(seconds: f64) -> String {
    let s = seconds.round() as u64;
    match (s / 3600, s / 60 % 60, s % 60) {
        (0, 0, s) => format!("{s} s"),
        (0, m, s) => format!("{m} min {s} s"),
        (h, m, _) => format!("{h} h {m} min"),
    }
}

/// Shows the progress of one command until it is dropped.
pub struct Teller {
    now: Arc<Mutex<Whereabouts>>,
    bar: Option<ProgressBar>,
    log: Option<Log>,
    notes: bool,
}

impl Teller {
    /// With `progress` a bar on a terminal, elsewhere lines that begin with the command; with `notes` notes, as they come.
    pub fn new(command: &'static str, progress: bool, notes: bool) -> Self {
        let now = Arc::new(Mutex::new(Whereabouts::new()));
        let terminal = std::io::stderr().is_terminal();
        let bar = (progress && terminal).then(|| bar(&now));
        let log = (progress && !terminal).then(|| Log::new(command, &now)).flatten();
        Self { now, bar, log, notes }
    }
}

impl Progress for Teller {
    fn report(&self, stage: &str, done: f64) {
        let mut now = self.now.lock().unwrap_or_else(PoisonError::into_inner);
        let another = now.stage != stage;
        now.reported(stage, done);
        let done = now.done;
        // The bar asks for the same lock when it is drawn.
        drop(now);
        if let Some(bar) = &self.bar {
            if another {
                bar.set_message(stage.to_string());
            }
            bar.set_position((done * 100.0) as u64);
        }
    }

    fn triangles(&self, count: usize) {
        self.now.lock().unwrap_or_else(PoisonError::into_inner).triangles = Some(count);
    }

    fn expected(&self, triangles: usize) {
        self.now.lock().unwrap_or_else(PoisonError::into_inner).expected = Some(triangles);
    }

    fn note(&self, kind: &str, line: &str) {
        if !self.notes {
            return;
        }
        let line = format!("{kind}: {}", visible(line));
        match &self.bar {
            Some(bar) => bar.suspend(|| eprintln!("{line}")),
            None => eprintln!("{line}"),
        }
    }
}

impl Drop for Teller {
    fn drop(&mut self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
        // The log's thread ends with it.
        drop(self.log.take());
    }
}

fn bar(now: &Arc<Mutex<Whereabouts>>) -> ProgressBar {
    let (bar, shown) = (ProgressBar::new(100), now.clone());
    let rest = move |state: &ProgressState, out: &mut dyn std::fmt::Write| {
        let now = shown.lock().unwrap_or_else(PoisonError::into_inner).clone();
        // What cannot be written is not shown.
        let _ = out.write_str(&now.rest(state.elapsed().as_secs_f64(), Instant::now()));
    };
    if let Ok(style) = ProgressStyle::with_template("{msg:>12} [{bar:12}] {pos:>3} %  {rest}") {
        bar.set_style(style.progress_chars("=> ").with_key("rest", rest));
    }
    // Seconds go on where nothing is reported.
    bar.enable_steady_tick(Duration::from_millis(500));
    bar
}

/// A thread that writes a line every ten seconds.
struct Log {
    stop: Arc<(Mutex<bool>, Condvar)>,
    thread: Option<JoinHandle<()>>,
}

impl Log {
    /// Nothing where the machine has no thread to spare: it is only told less.
    fn new(command: &'static str, now: &Arc<Mutex<Whereabouts>>) -> Option<Self> {
        let stop = Arc::new((Mutex::new(false), Condvar::new()));
        let (told, now, start) = (stop.clone(), now.clone(), Instant::now());
        let work = move || {
            let mut next = EVERY;
            let mut stopped = told.0.lock().unwrap_or_else(PoisonError::into_inner);
            while !*stopped {
                let wait = next.saturating_sub(start.elapsed());
                stopped = told.1.wait_timeout(stopped, wait).unwrap_or_else(PoisonError::into_inner).0;
                if *stopped || start.elapsed() < next {
                    continue;
                }
                next += EVERY;
                let now = now.lock().unwrap_or_else(PoisonError::into_inner).clone();
                let rest = now.rest(start.elapsed().as_secs_f64(), Instant::now());
                match now.stage.as_str() {
                    "" => eprintln!("{command}: {rest}"),
                    stage => eprintln!("{command}: {stage} {:.0} %, {rest}", 100.0 * now.done),
                }
            }
        };
        let thread = std::thread::Builder::new().name("log".into()).spawn(work).ok()?;
        Some(Self { stop, thread: Some(thread) })
    }
}

impl Drop for Log {
    fn drop(&mut self) {
        *self.stop.0.lock().unwrap_or_else(PoisonError::into_inner) = true;
        self.stop.1.notify_all();
        // A thread that has panicked has nothing more to say.
        let _ = self.thread.take().map(JoinHandle::join);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_abs_diff_eq;

    #[test]
    fn time_left_is_told_of_stages_that_go_on_steadily() {
        let start = Instant::now();
        let mut at = Whereabouts::new();
        at.reported("remesh", 0.0);
        for k in 1..=5 {
            at.reported("remesh", 0.1 * f64::from(k));
        }
        (at.since, at.last) = (start, start + Duration::from_secs(20));
        // Half of it took 20 s, and 4 s have passed.
        let left = at.left(start + Duration::from_secs(24)).unwrap();
        assert_abs_diff_eq!(left, 16.0, epsilon = 1e-6);
        assert_eq!(at.rest(130.0, start + Duration::from_secs(24)), "2 min 10 s, stage ends in 16 s");
        at.triangles = Some(7);
        assert_eq!(at.rest(24.0, start + Duration::from_secs(41)), "7 triangles, 24 s");
        // A share that jumped once tells nothing.
        at.reported("check", 0.5);
        (at.since, at.last) = (start, start + Duration::from_secs(20));
        assert_eq!(at.rest(24.0, start + Duration::from_secs(24)), "24 s");
    }
}
