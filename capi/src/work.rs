//! Runs: cancellation and progress from any thread, codes of fields' functions after them.

use std::cell::RefCell;
use std::ffi::{c_char, c_int};
use std::sync::{Arc, Mutex};

use rvachev::run::{CancelToken, Progress};
use rvachev::{Error, Run};

use crate::errors::{ErrorOut, Failure, GOOD, entry, given, release, slot, usage};
use crate::pass::Out;

/// What the functions of one run share.
#[derive(Default)]
pub struct Watched {
    /// Stops the run.
    pub token: CancelToken,
    /// The first code a function returned, and whose function it was.
    stopped: Mutex<Option<(c_int, usize)>>,
}

impl Watched {
    /// Keeps the first code and stops the run.
    pub fn stop(&self, code: c_int, user: usize) {
        if let Ok(mut slot) = self.stopped.lock() {
            slot.get_or_insert((code, user));
        }
        self.token.cancel();
    }
}

thread_local! {
    /// The run this thread works for.
    static WATCHED: RefCell<Option<Arc<Watched>>> = const { RefCell::new(None) };
}

/// The run this thread works for, if it works for one.
pub fn watched() -> Option<Arc<Watched>> {
    WATCHED.with(|w| w.borrow().clone())
}

/// The latest stage and the share of it that is done.
#[derive(Default)]
struct Latest(Mutex<(String, f64)>);

impl Progress for Latest {
    fn report(&self, stage: &str, done: f64) {
        if let Ok(mut latest) = self.0.lock() {
            if latest.0 == stage {
                latest.1 = latest.1.max(done);
            } else {
                *latest = (stage.to_string(), done);
            }
        }
    }
}

/// What cancels and watches a run.
#[derive(Clone, Default)]
pub struct RvRun {
    token: CancelToken,
    latest: Arc<Latest>,
}

/// Does the work on threads of its own (0: as many as there are cores).
///
/// Errors: the code of a field's function; what the library says.
pub fn work<T: Send>(
    watcher: Option<&RvRun>,
    threads: usize,
    job: impl FnOnce(&Run) -> Result<T, Failure> + Send,
) -> Result<T, Failure> {
    let mut watched = Watched::default();
    if let Some(w) = watcher {
        watched.token = w.token.clone();
    }
    let watched = Arc::new(watched);
    // A pool of its own: nothing is global, and a function that calls in here again never waits for the pool it is on.
    let mut run = Run::new().with_cancel(watched.token.clone()).with_threads(threads)?;
    if let Some(w) = watcher {
        run = run.with_progress(w.latest.clone());
    }
    let all = || {
        run.install(|| {
            rayon::broadcast(|_| WATCHED.with(|w| *w.borrow_mut() = Some(watched.clone())));
            run.check()?;
            job(&run)
        })
    };
    // A thread of another run that waits in `install` would take up work of that run meanwhile, within a call of a field's function
    // it has not left. So it waits outside of its pool.
    let result = if self::watched().is_some() {
        std::thread::scope(|scope| {
            let worker = std::thread::Builder::new().spawn_scoped(scope, all);
            let worker = worker.map_err(|e| Error::Failed(format!("cannot start a thread: {e}")))?;
            worker.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic))
        })
    } else {
        all()
    };
    told(&watched, result)
}

/// Does work that takes no time on the thread that is here.
pub fn work_here<T>(job: impl FnOnce() -> Result<T, Failure>) -> Result<T, Failure> {
    /// Gives the thread back to the run it came from, also when a panic goes through.
    struct Back(Option<Arc<Watched>>);
    impl Drop for Back {
        fn drop(&mut self) {
            WATCHED.with(|w| *w.borrow_mut() = self.0.take());
        }
    }
    let watched = Arc::new(Watched::default());
    let before = WATCHED.with(|w| w.borrow_mut().replace(watched.clone()));
    let back = Back(before);
    let result = job();
    drop(back);
    told(&watched, result)
}

/// The code of a field's function goes before everything else.
fn told<T>(watched: &Watched, result: Result<T, Failure>) -> Result<T, Failure> {
    match watched.stopped.lock().ok().and_then(|mut slot| slot.take()) {
        Some((code, user)) => Err(Failure::Stopped { code, user }),
        None => result,
    }
}

/// Makes a handle to cancel and watch a call with.
#[unsafe(no_mangle)]
pub extern "C" fn rv_run_new(run: Out<'_, *mut RvRun>, error: ErrorOut<'_>) -> c_int {
    entry(error, || {
        slot(run, std::ptr::null_mut(), "run")?.write(Box::into_raw(Box::default()));
        Ok(GOOD)
    })
}

/// Asks the calls that hold this run to stop. From any thread.
#[unsafe(no_mangle)]
pub extern "C" fn rv_run_cancel(run: Option<&RvRun>, error: ErrorOut<'_>) -> c_int {
    entry(error, || {
        given(run, "run")?.token.cancel();
        Ok(GOOD)
    })
}

/// The stage at the moment, copied into `stage` (cut to `capacity` bytes, its zero among them), and the share of it that is done.
#[unsafe(no_mangle)]
pub extern "C" fn rv_run_progress(
    run: Option<&RvRun>,
    stage: *mut c_char,
    capacity: usize,
    done: Out<'_, f64>,
    error: ErrorOut<'_>,
) -> c_int {
    entry(error, || {
        let done = slot(done, 0.0, "done")?;
        let run = given(run, "run")?;
        let latest = run.latest.0.lock().map(|l| l.clone()).unwrap_or_default();
        done.write(latest.1);
        if capacity > 0 {
            if stage.is_null() {
                return Err(usage(format!("stage is NULL, but a capacity of {capacity} is announced")));
            }
            let mut n = latest.0.len().min(capacity - 1);
            while !latest.0.is_char_boundary(n) {
                n -= 1;
            }
            // SAFETY: not NULL; the header asks for room for `capacity` bytes, of which n and a zero are used.
            unsafe {
                std::ptr::copy(latest.0.as_ptr(), stage.cast(), n);
                stage.add(n).write(0);
            }
        }
        Ok(GOOD)
    })
}

/// Frees a run. Calls that hold it go on.
#[unsafe(no_mangle)]
pub extern "C" fn rv_run_free(run: Option<Box<RvRun>>) {
    release(run);
}
