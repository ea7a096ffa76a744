//! Which files a command names to read and to write: none is to be both.

use crate::args::Command;
use chiaro::film::spare;
use chiaro_basis::Result;
use std::path::{Path, PathBuf};

/// An error where an option names a file to write that another one names to read.
pub(crate) fn check(command: &Command) -> Result<()> {
    spare(written(command), read(command))
}

fn read(command: &Command) -> Vec<PathBuf> {
    let mut read: Vec<PathBuf> =
        command.scene().map(|s| s.scene.clone().into()).into_iter().collect();
    match command {
        Command::Light { light, .. } => {
            read.extend([&light.env, &light.tree].into_iter().flatten().cloned())
        }
        Command::Compare { a, b, .. } => read.extend([a.clone(), b.clone()]),
        Command::Mincut { file, .. } => read.push(file.clone()),
        _ => {}
    }
    read
}

fn written(command: &Command) -> Vec<(&'static str, PathBuf)> {
    let json = command.common().and_then(|c| c.json.as_deref()).filter(|j| *j != "-");
    let (output, bake): (Option<&Path>, Option<&Path>) = match command {
        Command::Gbuffer { output, .. }
        | Command::Binary { output, .. }
        | Command::Lines { output, .. } => (Some(output), None),
        Command::Light { output, light, .. } => (Some(output), light.bake.as_deref()),
        Command::Mincut { output, .. } => (output.as_deref(), None),
        _ => (None, None),
    };
    let named = [("--json", json.map(Path::new)), ("-o", output), ("--bake", bake)];
    named.into_iter().filter_map(|(option, path)| Some((option, path?.to_path_buf()))).collect()
}
