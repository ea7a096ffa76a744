//! `--watch`: when what a command reads has changed on disk.
//!
//! A state holds time and length of every file that the arguments name and of the files around a
//! scene that scenes may refer to. What the command itself wrote is left out. Files are looked at
//! twice a second; nothing of the system's own notices is needed.

use chiaro_basis::{Cancel, Error, Result};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};

/// Endings of files that a scene may refer to.
const ENDINGS: [&str; 12] =
    ["gltf", "glb", "bin", "obj", "mtl", "ply", "stl", "png", "jpg", "jpeg", "hdr", "exr"];

/// Folders below the scene's that are looked into, and files in all, at most.
const DEPTH: usize = 3;
const MOST: usize = 4096;

type State = BTreeMap<PathBuf, (Option<SystemTime>, u64)>;

/// What a command reads, as it was when the command began.
pub(crate) struct Watch {
    named: Vec<PathBuf>,
    folder: Option<PathBuf>,
    before: State,
}

impl Watch {
    /// Remembers the files that `arguments` name, and those around `scene`.
    pub(crate) fn new(scene: &str, arguments: impl Iterator<Item = String>) -> Self {
        let named = arguments.map(PathBuf::from).filter(|p| p.is_file()).collect();
        let scene = Path::new(scene);
        let parent = scene.parent().filter(|p| !p.as_os_str().is_empty());
        let folder = scene.is_file().then(|| parent.unwrap_or(Path::new(".")).to_path_buf());
        let mut watch = Self { named, folder, before: State::new() };
        watch.before = watch.look();
        watch
    }

    /// Waits until a file other than `outputs` differs; [`Error::Cancelled`] on a stop.
    pub(crate) fn wait(&mut self, outputs: &[PathBuf], cancel: &Cancel) -> Result<()> {
        let written: BTreeSet<&PathBuf> = outputs.iter().collect();
        let read = |state: State| -> State {
            state.into_iter().filter(|(path, _)| !written.contains(path)).collect()
        };
        let before = read(std::mem::take(&mut self.before));
        loop {
            if cancel.is_cancelled() {
                return Err(Error::Cancelled);
            }
            self.before = self.look();
            if read(self.before.clone()) != before {
                // Programs write a file in several steps: begin when it has come to rest.
                std::thread::sleep(Duration::from_millis(200));
                self.before = self.look();
                return Ok(());
            }
            std::thread::sleep(Duration::from_millis(500));
        }
    }

    fn look(&self) -> State {
        let mut state = State::new();
        for path in &self.named {
            note(path, &mut state);
        }
        if let Some(folder) = &self.folder {
            around(folder, &mut state);
        }
        state
    }
}

/// Notes the files of a folder and of those below it that a scene may refer to.
fn around(folder: &Path, state: &mut State) {
    let mut folders = vec![(folder.to_path_buf(), 0)];
    while let Some((folder, depth)) = folders.pop() {
        let Ok(entries) = std::fs::read_dir(&folder) else { continue };
        for entry in entries.filter_map(|e| e.ok()) {
            let hidden = entry.file_name().to_string_lossy().starts_with('.');
            let Ok(kind) = entry.file_type() else { continue };
            if kind.is_dir() && !hidden && depth < DEPTH {
                folders.push((entry.path(), depth + 1));
            } else if kind.is_file() && !hidden && state.len() < MOST && may_be_read(&entry.path())
            {
                note(&entry.path(), state);
            }
        }
    }
}

fn may_be_read(path: &Path) -> bool {
    let ending = path.extension().unwrap_or_default().to_string_lossy().to_ascii_lowercase();
    ENDINGS.contains(&ending.as_str())
}

fn note(path: &Path, state: &mut State) {
    let meta = std::fs::metadata(path);
    let (time, length) = meta.map_or((None, 0), |m| (m.modified().ok(), m.len()));
    // One file under one name, so that an output is known however it was named.
    let path = path.canonicalize().unwrap_or_else(|_| path.to_path_buf());
    state.insert(path, (time, length));
}
