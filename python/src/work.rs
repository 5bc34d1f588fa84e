//! Long work with the interpreter free: signals, progress and cancellation while it runs, exceptions of callbacks after it.

use std::cell::RefCell;
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::sync::{Arc, Mutex};
use std::time::Duration;

use pyo3::prelude::*;
use pyo3::types::PyBool;
use rvachev::run::{CancelToken, Progress};
use rvachev::{Error, Result, Run};

use crate::errors::{raise, stopped};

/// How often signals and listeners are looked after: Ctrl-C is answered within a tenth of a second.
const POLL: Duration = Duration::from_millis(20);

/// What callbacks of one run share.
#[derive(Default)]
pub struct Watched {
    /// Stops the run.
    pub token: CancelToken,
    /// The first exception a callback raised.
    raised: Mutex<Option<PyErr>>,
}

impl Watched {
    /// Keeps the first exception and stops the run.
    pub fn fail(&self, e: PyErr) {
        if let Ok(mut slot) = self.raised.lock() {
            slot.get_or_insert(e);
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
struct Latest(Mutex<Option<(String, f64)>>);

impl Progress for Latest {
    fn report(&self, stage: &str, done: f64) {
        if let Ok(mut latest) = self.0.lock() {
            match &mut *latest {
                Some((name, share)) if name == stage => *share = share.max(done),
                other => *other = Some((stage.to_string(), done)),
            }
        }
    }
}

/// Who is told of a run, and who may stop it.
#[derive(Default)]
pub struct Listeners {
    /// `True` for a line on standard error, or a function of a stage's name and the share of it that is done.
    pub progress: Option<Py<PyAny>>,
    /// An object with `is_set()`, as `threading.Event`: the run stops when it is.
    pub cancel: Option<Py<PyAny>>,
    /// Threads; 0 for as many as there are cores.
    pub threads: usize,
}

impl Listeners {
    /// Tells what is new. Errors are what a handler of a signal, or a listener, raised.
    fn look(&self, py: Python<'_>, latest: Option<(String, f64)>, cancel: &CancelToken) -> PyResult<()> {
        py.check_signals()?;
        if let Some(event) = &self.cancel
            && event.bind(py).call_method0("is_set")?.is_truthy()?
        {
            cancel.cancel();
        }
        let (Some(listener), Some((stage, done))) = (&self.progress, latest) else { return Ok(()) };
        listener.bind(py).call1((stage, done))?;
        Ok(())
    }

    fn is_listening(&self, py: Python<'_>) -> bool {
        self.progress.as_ref().is_some_and(|p| p.bind(py).is_truthy().unwrap_or(true))
    }

    /// Does the work with the interpreter free.
    ///
    /// Errors: what a callback raised; what a signal's handler or a listener raised; what the library says.
    pub fn work<T: Send>(mut self, py: Python<'_>, job: impl FnOnce(&Run) -> Result<T> + Send) -> PyResult<T> {
        if !self.is_listening(py) {
            self.progress = None;
        }
        let watched = Arc::new(Watched::default());
        let latest = Arc::new(Latest::default());
        let mut run = Run::new().with_cancel(watched.token.clone());
        // A pool of its own: a callback that calls in here again never waits for the pool it is on.
        run = run.with_threads(self.threads).map_err(|e| raise(py, &e))?;
        let mut bar = None;
        if self.progress.as_ref().is_some_and(|p| p.bind(py).is_instance_of::<PyBool>()) {
            let made = py.import("rvachev._progress")?.call_method0("bar")?;
            self.progress = Some(made.getattr("line")?.unbind());
            bar = Some(made);
        }
        let bar = bar.map(Bound::unbind);
        if self.progress.is_some() {
            run = run.with_progress(latest.clone());
        }
        let (result, stop) = py.detach(|| self.watch(&run, &watched, &latest, job));
        if let Some(bar) = bar {
            bar.call_method0(py, "done")?;
        }
        if let Some(e) = watched.raised.lock().ok().and_then(|mut slot| slot.take()) {
            return Err(e);
        }
        match stop {
            Some(e) => Err(stopped(py, e)),
            None => result.map_err(|e| raise(py, &e)),
        }
    }

    /// The work in a thread, this one watching. Also what a signal's handler or a listener raised.
    fn watch<T: Send>(
        &self,
        run: &Run,
        watched: &Arc<Watched>,
        latest: &Latest,
        job: impl FnOnce(&Run) -> Result<T> + Send,
    ) -> (Result<T>, Option<PyErr>) {
        let (done, is_done) = channel::<()>();
        let work = move || {
            let _done = done;
            run.install(|| {
                rayon::broadcast(|_| WATCHED.with(|w| *w.borrow_mut() = Some(watched.clone())));
                job(run)
            })
        };
        std::thread::scope(|scope| {
            let worker = match std::thread::Builder::new().spawn_scoped(scope, work) {
                Ok(worker) => worker,
                Err(e) => return (Err(Error::Failed(format!("cannot start a thread: {e}"))), None),
            };
            let mut stop = None;
            while stop.is_none() && is_done.recv_timeout(POLL) == Err(RecvTimeoutError::Timeout) {
                let news = latest.0.lock().ok().and_then(|mut latest| latest.take());
                stop = Python::attach(|py| self.look(py, news, &watched.token)).err();
            }
            if stop.is_some() {
                watched.token.cancel();
            }
            let panicked = || Err(Error::Failed("the library failed where it should not: please report this".into()));
            (worker.join().unwrap_or_else(|_| panicked()), stop)
        })
    }
}
