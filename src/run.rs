//! What every stage is handed: the right to be cancelled, a place to report progress to, and the threads it may use.
//!
//! Nothing here is global. A stage calls [`Run::check`] at least every few milliseconds of work and [`Run::progress`]
//! as it goes; both cost one atomic load when nobody listens.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Instant;

use crate::error::{Error, Result};

/// A flag that many holders may raise and every stage looks at.
#[derive(Debug, Clone, Default)]
pub struct CancelToken {
    raised: Arc<AtomicBool>,
    /// Raised with this one, too.
    of: Option<Arc<CancelToken>>,
}

impl CancelToken {
    /// A token that has not been cancelled.
    pub fn new() -> Self {
        Self::default()
    }

    /// Asks every run that holds this token to stop. Safe to call from a signal handler thread.
    pub fn cancel(&self) {
        self.raised.store(true, Ordering::Relaxed);
    }

    /// A token that is cancelled with this one, and can be cancelled alone.
    pub fn child(&self) -> Self {
        Self { raised: Arc::default(), of: Some(Arc::new(self.clone())) }
    }

    /// Whether [`cancel`](Self::cancel) was called.
    pub fn is_cancelled(&self) -> bool {
        self.raised.load(Ordering::Relaxed) || self.of.as_ref().is_some_and(|t| t.is_cancelled())
    }
}

/// Receives progress. Called from worker threads.
pub trait Progress: Send + Sync {
    /// `stage` is a short name, `done` the share of it that is finished, in 0..=1, never falling within a stage.
    fn report(&self, stage: &str, done: f64);

    /// So many triangles there are at this point of the stage that was reported last. Not every stage knows.
    fn triangles(&self, _count: usize) {}

    /// About so many triangles the mesh will have, told once lengths of edges are known and again where they change: within a tenth as
    /// a rule, more where borders turn out to be closer than seemed.
    fn expected(&self, _triangles: usize) {}

    /// A line about something that has just ended, such as an attempt at a mesh, without an end of line. `kind` is a word: `attempt`,
    /// `stage`. What is told this way is also in the result's report, which a run that is cancelled never gives.
    fn note(&self, _kind: &str, _line: &str) {}
}

/// How long a stage took.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct StageSeconds {
    /// Its name, as progress is told with.
    pub(crate) name: String,
    /// Its seconds, of all times it was gone through.
    pub(crate) seconds: f64,
}

/// Stages that progress was told of, with the time between one and the next.
#[derive(Debug)]
struct StageClock {
    ended: Vec<StageSeconds>,
    current: String,
    since: Instant,
}

impl StageClock {
    fn new() -> Self {
        Self { ended: Vec::new(), current: String::new(), since: Instant::now() }
    }

    /// Ends the current stage, and begins another one.
    fn begin(&mut self, name: &str) {
        let now = Instant::now();
        let seconds = now.duration_since(self.since).as_secs_f64();
        match self.ended.iter_mut().find(|s| s.name == self.current) {
            Some(stage) => stage.seconds += seconds,
            None if self.current.is_empty() => {}
            None => self.ended.push(StageSeconds { name: std::mem::take(&mut self.current), seconds }),
        }
        (self.current, self.since) = (name.to_string(), now);
    }
}

/// What a triangle takes while its mesh is made, in bytes: measured at the peak of remeshing, of CAD models and of triangles.
const BYTES_PER_TRIANGLE: f64 = 500.0;
/// What files nest deeper than this is refused: no text can then exhaust the stack, and nothing that people write is as deep.
pub(crate) const DEEPEST: usize = 64;
/// Things a thread works on between two looks at the cancel flag: milliseconds of work at most, enough to hide what handing out costs.
pub(crate) const PORTION: usize = 512;
/// Bytes of a gibibyte.
pub(crate) const GIB: f64 = (1u64 << 30) as f64;

/// Cancellation, progress and threads of one run.
#[derive(Clone, Default)]
pub struct Run {
    cancel: CancelToken,
    progress: Option<Arc<dyn Progress>>,
    pool: Option<Arc<rayon::ThreadPool>>,
    /// Whether what is made is a part of the mesh, of which nothing is expected.
    partial: bool,
    /// How many bytes a mesh may take while it is made.
    memory: Option<u64>,
    /// Which stages take how long, where that is asked for.
    stages: Option<Arc<Mutex<StageClock>>>,
}

impl std::fmt::Debug for Run {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Run").field("cancel", &self.cancel).field("threads", &self.threads()).finish_non_exhaustive()
    }
}

impl Run {
    /// A run nobody watches, on rayon's default threads.
    pub fn new() -> Self {
        Self::default()
    }

    /// Stops when `token` is cancelled.
    pub fn with_cancel(mut self, token: CancelToken) -> Self {
        self.cancel = token;
        self
    }

    /// The token that stops this run, for runs within it.
    pub fn cancel_token(&self) -> CancelToken {
        self.cancel.clone()
    }

    /// Reports to `progress`.
    pub fn with_progress(mut self, progress: Arc<dyn Progress>) -> Self {
        self.progress = Some(progress);
        self
    }

    /// Uses exactly `threads` worker threads (0: as many as the machine has). Results never depend on it.
    pub fn with_threads(mut self, threads: usize) -> Result<Self> {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .map_err(|e| Error::Failed(format!("cannot start {threads} threads: {e}")))?;
        self.pool = Some(Arc::new(pool));
        Ok(self)
    }

    /// How many threads parallel loops use.
    pub fn threads(&self) -> usize {
        self.pool.as_ref().map_or_else(rayon::current_num_threads, |p| p.current_num_threads())
    }

    /// [`Error::Cancelled`] once the token is raised.
    pub fn check(&self) -> Result<()> {
        if self.cancel.is_cancelled() { Err(Error::Cancelled) } else { Ok(()) }
    }

    /// Whether the token is raised, for loops that cannot return an error.
    pub fn is_cancelled(&self) -> bool {
        self.cancel.is_cancelled()
    }

    /// Tells the listener, if any, that `done` (0..=1) of `stage` is finished.
    pub fn progress(&self, stage: &str, done: f64) {
        if let Some(stages) = &self.stages {
            let mut clock = stages.lock().unwrap_or_else(PoisonError::into_inner);
            if clock.current != stage {
                clock.begin(stage);
            }
        }
        if let Some(p) = &self.progress {
            p.report(stage, done.clamp(0.0, 1.0));
        }
    }

    /// Tells the listener, if any, how many triangles there are.
    pub fn triangles(&self, count: usize) {
        if let Some(p) = &self.progress {
            p.triangles(count);
        }
    }

    /// Tells the listener, if any, about how many triangles the mesh will have.
    pub fn expected(&self, triangles: usize) {
        if let Some(p) = self.progress.as_ref().filter(|_| !self.partial) {
            p.expected(triangles);
        }
    }

    /// Refuses meshes that need more than so many bytes while they are made: see [`expect`](Self::expect).
    pub(crate) fn with_memory(mut self, bytes: u64) -> Self {
        self.memory = Some(bytes);
        self
    }

    /// How many triangles the memory holds that is allowed, if there is a limit.
    pub(crate) fn most_triangles(&self) -> Option<usize> {
        // Numbers too large for the type become its largest.
        self.memory.map(|m| (m as f64 / BYTES_PER_TRIANGLE) as usize)
    }

    /// [`expected`](Self::expected), where the memory allowed holds so many triangles.
    ///
    /// Errors: [`Error::Usage`] where it does not, also of a part of the mesh.
    pub(crate) fn expect(&self, triangles: f64) -> Result<()> {
        // Numbers too large for the type, and infinity, become its largest.
        self.expected(triangles as usize);
        match self.memory {
            Some(m) if triangles * BYTES_PER_TRIANGLE > m as f64 => Err(self.too_many(triangles, "about")),
            _ => Ok(()),
        }
    }

    /// Why a mesh of `how` (about, or more than) so many triangles is refused.
    pub(crate) fn too_many(&self, triangles: f64, how: &str) -> Error {
        let count = if triangles < 1e9 { format!("{triangles:.0}") } else { format!("{triangles:.3e}") };
        let (needed, allowed) = (triangles * BYTES_PER_TRIANGLE / GIB, self.memory.unwrap_or(u64::MAX) as f64 / GIB);
        Error::Usage(format!(
            "{how} {count} triangles are expected, which need {needed:.3} GiB of memory, more than the {allowed:.3} allowed: \
             longer edges (--size, --size-min) need less, and --memory allows more"
        ))
    }

    /// Measures how long stages take, if `timed`: see [`stage_seconds`](Self::stage_seconds).
    pub(crate) fn timed(mut self, timed: bool) -> Self {
        self.stages = timed.then(|| Arc::new(Mutex::new(StageClock::new())));
        self
    }

    /// How long each stage took since this was asked last, in the order they began; nothing where that is not measured.
    pub(crate) fn stage_seconds(&self) -> Vec<StageSeconds> {
        let Some(stages) = &self.stages else { return Vec::new() };
        let mut clock = stages.lock().unwrap_or_else(PoisonError::into_inner);
        clock.begin("");
        std::mem::take(&mut clock.ended)
    }

    /// The listener, if any.
    pub(crate) fn listener(&self) -> Option<Arc<dyn Progress>> {
        self.progress.clone()
    }

    /// Tells the listener, if any, a line: see [`Progress::note`].
    pub fn note(&self, kind: &str, line: impl FnOnce() -> String) {
        if let Some(p) = &self.progress {
            p.note(kind, &line());
        }
    }

    /// The same run for something that the mesh is made of, how many triangles of which tell nothing of the mesh.
    pub(crate) fn for_a_part(&self) -> Self {
        Self { partial: true, ..self.clone() }
    }

    /// The same run with nobody listening, for parts of a stage whose shares are not those of the stage.
    pub(crate) fn unwatched(&self) -> Self {
        Self { progress: None, ..self.clone() }
    }

    /// Runs `work` on this run's threads: rayon loops inside use them.
    pub fn install<R: Send>(&self, work: impl FnOnce() -> R + Send) -> R {
        match &self.pool {
            Some(pool) => pool.install(work),
            None => work(),
        }
    }
}
