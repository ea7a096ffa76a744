//! The chiaro command line.
//!
//! Arguments as typed ([`args`]) are turned once into what is meant, the facade does the work, and
//! this program prints, watches for Ctrl-C and chooses the exit code: 0 done, 1 an input, a setting
//! or an output that does not do, 2 wrong usage, 130 stopped.

mod args;
mod command;
mod progress;
mod spared;
mod watch;

use args::{Cli, Command};
use chiaro::Stopwatch;
use chiaro::record::Record;
use chiaro_basis::{Cancel, Error, Result, Run};
use clap::Parser;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Arc;
use watch::Watch;

fn main() -> ExitCode {
    let cli = Cli::parse();
    match run(&cli) {
        Ok(()) => ExitCode::SUCCESS,
        Err(Error::Cancelled) => {
            say_error("stopped; files that were begun are not there, finished ones stay");
            ExitCode::from(130)
        }
        Err(error) => {
            say_error(&error.to_string());
            ExitCode::from(1)
        }
    }
}

fn say_error(text: &str) {
    // Nobody is left to tell when even this fails.
    let _ = writeln!(std::io::stderr(), "chiaro: {text}");
}

fn run(cli: &Cli) -> Result<()> {
    let common = cli.command.common();
    let threads = common.map_or(0, |c| c.threads.unwrap_or(0));
    // The pool is built once, before anything uses it.
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build_global();
    pool.map_err(|e| Error::setting("--threads", threads, e.to_string()))?;
    let cancel = watch_for_ctrl_c()?;
    match cli.command.scene().filter(|s| s.watch) {
        Some(scene) => again_and_again(cli, &scene.scene, &cancel),
        None => once(cli, &cancel).map(drop),
    }
}

/// Runs the command; the files that it wrote.
fn once(cli: &Cli, cancel: &Cancel) -> Result<Vec<PathBuf>> {
    let common = cli.command.common();
    let quiet = common.is_none_or(|c| c.quiet);
    let verbose = common.is_some_and(|c| c.verbose);
    let watch = Arc::new(Stopwatch::new(progress::observer(quiet, verbose)));
    let run = Run::new(cancel.clone(), watch.clone());
    let Some(mut record) = command::run(&cli.command, &run)? else { return Ok(Vec::new()) };
    record.finish(&watch);
    report(&cli.command, &record)?;
    Ok(record.outputs.into_iter().map(|o| o.path).collect())
}

/// Runs the command whenever what it reads has changed. What is wrong with a file now may be right
/// the next time: only a stop ends it.
fn again_and_again(cli: &Cli, scene: &str, cancel: &Cancel) -> Result<()> {
    let mut watch = Watch::new(scene, std::env::args().skip(1));
    let json = cli.command.common().and_then(|c| c.json.as_deref());
    let mut outputs = Vec::new();
    loop {
        match once(cli, cancel) {
            Ok(written) => outputs.extend(written.iter().filter_map(|p| p.canonicalize().ok())),
            Err(Error::Cancelled) => return Err(Error::Cancelled),
            Err(error) => say_error(&error.to_string()),
        }
        outputs.extend(json.and_then(|p| Path::new(p).canonicalize().ok()));
        watch.wait(&outputs, cancel)?;
    }
}

fn watch_for_ctrl_c() -> Result<Cancel> {
    let cancel = Cancel::default();
    let raised = cancel.clone();
    let handler = move || {
        if raised.is_cancelled() {
            // Asked twice: go at once; parts of files are under names that nobody reads.
            std::process::exit(130);
        }
        raised.cancel();
    };
    ctrlc::set_handler(handler).map_err(|e| Error::output("the signal handler", e))?;
    Ok(cancel)
}

/// Prints what a command found out, as JSON where asked.
fn report(command: &Command, record: &Record) -> Result<()> {
    let json = command.common().and_then(|c| c.json.as_deref());
    let text = serde_json::to_string_pretty(record).map_err(|e| Error::output("--json", e))?;
    match json {
        Some("-") => print(&format!("{text}\n")),
        Some(path) => {
            chiaro::write::whole(path.as_ref(), format!("{text}\n").as_bytes())?;
            print(&command::summary(command, record))
        }
        None => print(&command::summary(command, record)),
    }
}

/// Prints to standard output; a closed pipe is no error.
fn print(text: &str) -> Result<()> {
    match std::io::stdout().write_all(text.as_bytes()) {
        Err(e) if e.kind() != std::io::ErrorKind::BrokenPipe => {
            Err(Error::output("standard output", e))
        }
        _ => Ok(()),
    }
}
