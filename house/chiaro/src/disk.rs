//! Files beside a scene, and no others.

use chiaro_basis::{Error, Result};
use chiaro_scene::load::Source;
use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

/// The largest scene file, in bytes.
const LARGEST: u64 = 8 << 30;

/// A scene's folder. Links that lead out of it are not followed.
pub(crate) struct Folder {
    root: PathBuf,
    /// Files that were read.
    read: Mutex<Vec<PathBuf>>,
}

impl Folder {
    /// The folder that holds `scene`.
    pub(crate) fn of(scene: &Path) -> Self {
        let parent = scene.parent().filter(|p| !p.as_os_str().is_empty());
        Self { root: parent.unwrap_or(Path::new(".")).to_path_buf(), read: Mutex::default() }
    }

    /// The files that were read.
    pub(crate) fn into_read(self) -> Vec<PathBuf> {
        self.read.into_inner().unwrap_or_else(PoisonError::into_inner)
    }

    fn resolve(&self, path: &str) -> std::result::Result<PathBuf, String> {
        let root = self.root.canonicalize().map_err(|e| e.to_string())?;
        let full = self.find(&root, path).canonicalize().map_err(|_| {
            "not found; put it beside the scene or export the scene with its files".to_owned()
        })?;
        if full.starts_with(&root) {
            Ok(full)
        } else {
            Err("leads outside the scene's folder; copy the file itself there".to_owned())
        }
    }

    /// The path itself, or the same with other letter case, as scenes from other systems have it.
    fn find(&self, root: &Path, path: &str) -> PathBuf {
        let exact = root.join(path);
        if exact.exists() {
            return exact;
        }
        let mut at = root.to_path_buf();
        for part in path.split('/') {
            at = match entry_like(&at, part) {
                Some(entry) => entry,
                None => return exact,
            };
        }
        at
    }
}

/// The least directory entry whose name differs from `name` in letter case at most.
fn entry_like(folder: &Path, name: &str) -> Option<PathBuf> {
    let entries = std::fs::read_dir(folder).ok()?.filter_map(|e| Some(e.ok()?.file_name()));
    let like = entries.filter(|n| n.to_string_lossy().eq_ignore_ascii_case(name));
    Some(folder.join(like.min()?))
}

impl Source for Folder {
    fn read(&self, path: &str, limit: u64) -> Result<Vec<u8>> {
        let full = self.resolve(path).map_err(|why| Error::input(path, "", why))?;
        let bytes = read_file(&full, path, limit)?;
        self.read.lock().unwrap_or_else(PoisonError::into_inner).push(full);
        Ok(bytes)
    }
}

/// The bytes of the file that a user named.
pub(crate) fn read(path: &Path) -> Result<Vec<u8>> {
    read_file(path, &path.display().to_string(), LARGEST)
}

/// Reads at most `limit` bytes of a regular file, whatever its length claims.
fn read_file(path: &Path, name: &str, limit: u64) -> Result<Vec<u8>> {
    let file = File::open(path).map_err(|e| Error::input(name, "", reason(&e)))?;
    let meta = file.metadata().map_err(|e| Error::input(name, "", reason(&e)))?;
    if meta.is_dir() {
        return Err(Error::input(name, "", "is a folder; name the scene file in it"));
    }
    if !meta.is_file() {
        return Err(Error::input(name, "", "is no regular file; copy it to disk first"));
    }
    if meta.len() > limit {
        return Err(Error::limit(name, format!("{} bytes", meta.len()), format!("{limit} bytes")));
    }
    let mut bytes = Vec::with_capacity(meta.len() as usize);
    file.take(limit).read_to_end(&mut bytes).map_err(|e| Error::input(name, "", reason(&e)))?;
    Ok(bytes)
}

/// What the system said, with the remedy where there is one.
pub(crate) fn reason(error: &std::io::Error) -> String {
    use std::io::ErrorKind as K;
    match error.kind() {
        K::NotFound => "not found; check the path".into(),
        K::PermissionDenied => "permission denied; check the file's owner and mode".into(),
        K::StorageFull => "the disk is full; free some space and run again".into(),
        K::IsADirectory => "is a folder; name a file".into(),
        K::NotADirectory => "a part of the path is a file, not a folder".into(),
        K::ReadOnlyFilesystem => "the file system is read-only; choose another folder".into(),
        _ => error.to_string(),
    }
}
