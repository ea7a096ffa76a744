//! Progress: a bar with time left on a terminal, plain lines otherwise, nothing when quiet.

use chiaro_basis::Observer;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::io::{IsTerminal, Write};
use std::sync::Mutex;
use std::time::{Duration, Instant};

/// Someone who shows progress in the way that fits.
pub(crate) fn observer(quiet: bool, verbose: bool) -> Box<dyn Observer> {
    if quiet {
        Box::new(Silence)
    } else if std::io::stderr().is_terminal() {
        Box::new(Bar::new())
    } else {
        Box::new(Lines { verbose, since: Mutex::default() })
    }
}

struct Silence;
impl Observer for Silence {}

fn say(text: &str) {
    // A closed terminal is no reason to stop the work.
    let _ = writeln!(std::io::stderr(), "{text}");
}

/// Warnings, and with `verbose` each stage with its time.
struct Lines {
    verbose: bool,
    since: Mutex<Vec<(&'static str, Instant)>>,
}

impl Observer for Lines {
    fn begin(&self, stage: &'static str, _items: u64) {
        if let Ok(mut since) = self.since.lock() {
            since.push((stage, Instant::now()));
        }
    }

    fn end(&self, stage: &'static str) {
        let Ok(mut since) = self.since.lock() else { return };
        let Some(i) = since.iter().rposition(|(name, _)| *name == stage) else { return };
        let (_, start) = since.remove(i);
        if self.verbose {
            say(&format!("{stage}: {:.3} s", start.elapsed().as_secs_f64()));
        }
    }

    fn warn(&self, text: &str) {
        say(&format!("note: {text}"));
    }
}

/// A spinner that names the stage, and a bar once frames are counted.
struct Bar {
    bar: ProgressBar,
}

impl Bar {
    fn new() -> Self {
        let bar = ProgressBar::with_draw_target(None, ProgressDrawTarget::stderr());
        bar.enable_steady_tick(Duration::from_millis(120));
        Self { bar }
    }
}

impl Observer for Bar {
    fn begin(&self, stage: &'static str, items: u64) {
        if stage == "film" {
            self.bar.set_length(items);
            let style = "{bar:30} {pos}/{len} frames, {eta} left, {msg}";
            if let Ok(style) = ProgressStyle::with_template(style) {
                self.bar.set_style(style);
            }
        } else {
            self.bar.set_message(stage);
        }
    }

    fn end(&self, stage: &'static str) {
        if stage == "write" {
            self.bar.inc(1);
        }
    }

    fn warn(&self, text: &str) {
        self.bar.suspend(|| say(&format!("note: {text}")));
    }
}

impl Drop for Bar {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}
