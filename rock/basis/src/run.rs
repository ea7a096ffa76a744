//! [`Run`]: what every long computation takes.

use crate::{Error, Result};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// A flag that anyone may raise to stop a run; clones share it.
#[derive(Clone, Debug, Default)]
pub struct Cancel(Arc<AtomicBool>);

impl Cancel {
    /// Asks the run to stop at its next check.
    pub fn cancel(&self) {
        self.0.store(true, Ordering::Relaxed);
    }

    /// Whether someone asked.
    pub fn is_cancelled(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}

/// Someone who watches a run: a progress bar, a stopwatch, a test.
pub trait Observer: Send + Sync {
    /// A stage begins; `items` counts what it will work on (pixels, rays, frames).
    fn begin(&self, _stage: &'static str, _items: u64) {}
    /// The stage has ended.
    fn end(&self, _stage: &'static str) {}
    /// Something the user should know: what was missing, and what stands in for it.
    fn warn(&self, _text: &str) {}
}

struct Nobody;
impl Observer for Nobody {}

/// Seed, cancellation and observer of a computation. Threads are those of the ambient pool.
#[derive(Clone)]
pub struct Run {
    /// The seed of all randomness.
    pub seed: u64,
    /// Raised to stop.
    pub cancel: Cancel,
    observer: Arc<dyn Observer>,
}

impl Default for Run {
    fn default() -> Self {
        Self { seed: 0, cancel: Cancel::default(), observer: Arc::new(Nobody) }
    }
}

impl Run {
    /// A run with seed 0 that reports to `observer` and stops when `cancel` is raised.
    pub fn new(cancel: Cancel, observer: Arc<dyn Observer>) -> Self {
        Self { seed: 0, cancel, observer }
    }

    /// [`Error::Cancelled`] once someone asked to stop. Long loops call it every few milliseconds.
    pub fn check(&self) -> Result<()> {
        if self.cancel.is_cancelled() { Err(Error::Cancelled) } else { Ok(()) }
    }

    /// Runs `work` as the stage named `stage` on `items` things.
    pub fn stage<T>(&self, stage: &'static str, items: u64, work: impl FnOnce() -> T) -> T {
        self.observer.begin(stage, items);
        let value = work();
        self.observer.end(stage);
        value
    }

    /// Tells the user something: what was missing, what was chosen instead.
    pub fn warn(&self, text: impl AsRef<str>) {
        self.observer.warn(text.as_ref());
    }
}
