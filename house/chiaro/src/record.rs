//! The machine-readable record of a job, and the stopwatch that times its stages.

use chiaro_basis::{Knobs, Observer};
use serde::Serialize;
use serde_json::{Map, Value, json};
use std::path::PathBuf;
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Instant;

/// A file that a job wrote.
#[derive(Clone, Debug, Serialize)]
pub struct Output {
    /// Where.
    pub path: PathBuf,
    /// How long.
    pub bytes: u64,
    /// Its hash, in hexadecimal.
    pub sha256: String,
}

/// A stage's time.
#[derive(Clone, Debug, Serialize)]
pub struct Stage {
    /// Which stage.
    pub name: &'static str,
    /// Seconds of wall-clock time, summed over the job.
    pub seconds: f64,
    /// Things it worked on, summed over the job.
    pub items: u64,
}

/// What a job did, one object of `--json`. Keys stay; more may come.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Record {
    /// The command.
    pub command: String,
    /// The program's version.
    pub version: String,
    /// All knobs and options as used.
    pub settings: Map<String, Value>,
    /// The seed of all randomness.
    pub seed: u64,
    /// Threads.
    pub threads: usize,
    /// Files written.
    pub outputs: Vec<Output>,
    /// Time by stage.
    pub stages: Vec<Stage>,
    /// The most memory the process held, in bytes; 0 where the system does not say.
    pub peak_bytes: u64,
    /// What the user should know.
    pub warnings: Vec<String>,
    /// Measures of the result.
    pub counts: Map<String, Value>,
}

impl Record {
    /// An empty record for a command.
    pub fn new(command: &str) -> Self {
        Self {
            command: command.into(),
            version: env!("CARGO_PKG_VERSION").into(),
            threads: rayon::current_num_threads(),
            ..Self::default()
        }
    }

    /// Sets a measure.
    pub fn count(&mut self, name: &str, value: impl Into<Value>) {
        self.counts.insert(name.into(), value.into());
    }

    /// Sets a setting.
    pub fn setting(&mut self, name: &str, value: impl Into<Value>) {
        self.settings.insert(name.into(), value.into());
    }

    /// Fills in what the stopwatch and the system know at the end.
    pub fn finish(&mut self, watch: &Stopwatch) {
        let state = watch.state();
        self.stages = state.stages.clone();
        for warning in &state.warnings {
            if !self.warnings.contains(warning) {
                self.warnings.push(warning.clone());
            }
        }
        self.peak_bytes = peak_bytes();
    }
}

/// The recipe of a picture, which its file carries: everything that changes it, and nothing else.
pub(crate) fn recipe(command: &str, settings: Map<String, Value>) -> String {
    json!({
        "program": "chiaro", "version": env!("CARGO_PKG_VERSION"), "command": command,
        "settings": settings,
    })
    .to_string()
}

/// The recipe of frame `number`.
pub(crate) fn frame_recipe(command: &str, mut settings: Map<String, Value>, number: u32) -> String {
    settings.insert("frame".into(), number.into());
    recipe(command, settings)
}

/// All knobs of a table as settings.
pub(crate) fn knob_settings(knobs: &impl Knobs) -> impl Iterator<Item = (String, Value)> {
    knobs.values().into_iter().map(|(knob, value)| {
        let value = match value {
            chiaro_basis::Value::Number(x) => json!(x),
            chiaro_basis::Value::Count(n) => json!(n),
            chiaro_basis::Value::Switch(b) => json!(b),
            chiaro_basis::Value::Word(w) => json!(w),
        };
        (knob.name.to_owned(), value)
    })
}

/// Times stages and collects warnings; hands both on to another observer, such as a progress bar.
pub struct Stopwatch {
    next: Box<dyn Observer>,
    state: Mutex<State>,
}

#[derive(Default)]
struct State {
    stages: Vec<Stage>,
    running: Vec<(&'static str, Instant)>,
    warnings: Vec<String>,
}

impl Stopwatch {
    /// A stopwatch in front of `next`.
    pub fn new(next: Box<dyn Observer>) -> Self {
        Self { next, state: Mutex::default() }
    }

    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Observer for Stopwatch {
    fn begin(&self, stage: &'static str, items: u64) {
        let mut state = self.state();
        state.running.push((stage, Instant::now()));
        match state.stages.iter_mut().find(|s| s.name == stage) {
            Some(s) => s.items += items,
            None => state.stages.push(Stage { name: stage, seconds: 0.0, items }),
        }
        drop(state);
        self.next.begin(stage, items);
    }

    fn end(&self, stage: &'static str) {
        let mut state = self.state();
        if let Some(i) = state.running.iter().rposition(|(name, _)| *name == stage) {
            let (_, start) = state.running.remove(i);
            if let Some(s) = state.stages.iter_mut().find(|s| s.name == stage) {
                s.seconds += start.elapsed().as_secs_f64();
            }
        }
        drop(state);
        self.next.end(stage);
    }

    fn warn(&self, text: &str) {
        let mut state = self.state();
        let fresh = !state.warnings.iter().any(|w| w == text);
        if fresh {
            state.warnings.push(text.into());
        }
        drop(state);
        if fresh {
            self.next.warn(text);
        }
    }
}

/// The most memory the process held, from the system's own books.
pub(crate) fn peak_bytes() -> u64 {
    of_status("VmHWM:")
}

/// The memory that the process holds now; 0 where the system does not say.
pub(crate) fn resident_bytes() -> u64 {
    // The shorter file is far faster to read; it counts in pages, whose size the longer one tells.
    static PAGE: std::sync::OnceLock<u64> = std::sync::OnceLock::new();
    let pages = || {
        let text = std::fs::read_to_string("/proc/self/statm").unwrap_or_default();
        text.split(' ').nth(1).and_then(|p| p.parse::<u64>().ok()).unwrap_or(0)
    };
    // A power of two; both files may be of slightly different moments.
    let about = || 3 * of_status("VmRSS:") / (4 * pages().max(1));
    let page = PAGE.get_or_init(|| about().next_power_of_two());
    pages() * page
}

fn of_status(name: &str) -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|l| l.strip_prefix(name));
    let kilobytes = line.and_then(|l| l.trim().strip_suffix(" kB")?.trim().parse::<u64>().ok());
    kilobytes.unwrap_or(0) * 1024
}
