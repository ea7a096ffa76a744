//! Files that a command reads are not written over by it.

use crate::args::Command;
use chiaro_basis::{Error, Result};
use std::path::Path;

/// An error where an option names a file to write that another one names to read.
pub(crate) fn check(command: &Command) -> Result<()> {
    let same = |path: &Path| path.canonicalize().ok();
    let read: Vec<_> = read(command).into_iter().filter_map(same).collect();
    let lost = |path: &Path| same(path).is_some_and(|p| read.contains(&p));
    match written(command).into_iter().find(|(_, path)| lost(path)) {
        Some((option, path)) => {
            let range = "another file: this one is read, and would be written over";
            Err(Error::setting(option, path.display(), range))
        }
        None => Ok(()),
    }
}

fn read(command: &Command) -> Vec<&Path> {
    let mut read: Vec<&Path> = command.scene().map(|s| Path::new(&s.scene)).into_iter().collect();
    match command {
        Command::Light { light, .. } => {
            read.extend([&light.env, &light.tree].into_iter().flatten().map(|p| p.as_path()));
        }
        Command::Compare { a, b, .. } => read.extend([a.as_path(), b.as_path()]),
        Command::Mincut { file, .. } => read.push(file),
        _ => {}
    }
    read
}

fn written(command: &Command) -> Vec<(&'static str, &Path)> {
    let json = command.common().and_then(|c| c.json.as_deref()).filter(|j| *j != "-");
    let mut written: Vec<_> = json.map(|j| ("--json", Path::new(j))).into_iter().collect();
    match command {
        Command::Gbuffer { output, .. }
        | Command::Binary { output, .. }
        | Command::Lines { output, .. } => written.push(("-o", output)),
        Command::Light { output, light, .. } => {
            written.push(("-o", output));
            written.extend(light.bake.as_deref().map(|p| ("--bake", p)));
        }
        Command::Mincut { output, .. } => {
            written.extend(output.as_deref().map(|p| ("-o", p)));
        }
        _ => {}
    }
    written
}
