//! [`Growing`]: a file written piece by piece that appears whole or not at all.
//!
//! A run that is killed leaves a hidden file beside; the next run that makes the same file removes it.

use crate::disk::reason;
use crate::record::Output;
use crate::write;
use chiaro_basis::{Error, Result};
use sha2::{Digest, Sha256};
use std::fs::{self, File};
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

/// A file beside the one that it will be; gone again unless it is finished.
pub(crate) struct Growing {
    path: PathBuf,
    beside: PathBuf,
    file: BufWriter<File>,
    hash: Sha256,
    bytes: u64,
}

impl Growing {
    /// Begins a file that will be at `path`. Missing folders are made.
    pub(crate) fn create(path: &Path) -> Result<Self> {
        let fail = |e: std::io::Error| Error::output(path.display().to_string(), reason(&e));
        if path.is_dir() {
            let why = "is a folder; name a file in it";
            return Err(Error::output(path.display().to_string(), why));
        }
        if let Some(parent) = path.parent().filter(|p| !p.as_os_str().is_empty()) {
            fs::create_dir_all(parent).map_err(fail)?;
        }
        sweep(path);
        let beside = write::beside(path);
        let file = BufWriter::new(File::create(&beside).map_err(fail)?);
        Ok(Self { path: path.to_path_buf(), beside, file, hash: Sha256::new(), bytes: 0 })
    }

    /// Adds bytes.
    pub(crate) fn write(&mut self, bytes: &[u8]) -> Result<()> {
        self.hash.update(bytes);
        self.bytes += bytes.len() as u64;
        self.file
            .write_all(bytes)
            .map_err(|e| Error::output(self.path.display().to_string(), reason(&e)))
    }

    /// Flushes the file and gives it its name.
    pub(crate) fn finish(mut self) -> Result<Output> {
        let named = self
            .file
            .flush()
            .and_then(|()| self.file.get_ref().sync_all())
            .and_then(|()| fs::rename(&self.beside, &self.path));
        named.map_err(|e| Error::output(self.path.display().to_string(), reason(&e)))?;
        let hash = std::mem::take(&mut self.hash).finalize();
        let sha256 = hash.iter().map(|b| format!("{b:02x}")).collect();
        Ok(Output { path: self.path.clone(), bytes: self.bytes, sha256 })
    }
}

impl Drop for Growing {
    fn drop(&mut self) {
        // Renamed when it was finished; then there is nothing to remove.
        let _ = fs::remove_file(&self.beside);
    }
}

/// Removes what runs that were killed left beside the file that they were making.
fn sweep(path: &Path) {
    let (Some(name), Some(folder)) = (path.file_name(), path.parent()) else { return };
    let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let start = format!(".{}.", name.to_string_lossy());
    let Ok(entries) = fs::read_dir(folder) else { return };
    for entry in entries.filter_map(|e| e.ok()) {
        let name = entry.file_name().to_string_lossy().into_owned();
        let middle = name.strip_prefix(&start).and_then(|rest| rest.strip_suffix(".part"));
        let process = middle.and_then(|m| m.split_once('-')?.0.parse::<u32>().ok());
        if process.is_some_and(|id| id != std::process::id() && !lives(id, &entry)) {
            // Another run may sweep at the same time.
            let _ = fs::remove_file(entry.path());
        }
    }
}

/// Whether a process may still be writing its file; where the system does not tell, for a day.
fn lives(id: u32, entry: &fs::DirEntry) -> bool {
    if Path::new("/proc/self").exists() {
        return Path::new("/proc").join(id.to_string()).exists();
    }
    let age = entry.metadata().and_then(|m| m.modified()).ok().and_then(|t| t.elapsed().ok());
    age.is_none_or(|age| age.as_secs() < 86_400)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[cfg(target_os = "linux")]
    #[test]
    fn what_a_killed_run_left_is_swept_and_what_others_write_is_not() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("tree.pbgi");
        // No process has the highest number, and the first always lives.
        let of = |id: u32| dir.path().join(format!(".tree.pbgi.{id}-old.part"));
        for id in [u32::MAX, 1, std::process::id()] {
            fs::write(of(id), b"half").unwrap();
        }
        fs::write(dir.path().join(".other.pbgi.4294967295-0.part"), b"half").unwrap();
        drop(Growing::create(&path).unwrap());
        assert!(!of(u32::MAX).exists());
        assert!(of(1).exists() && of(std::process::id()).exists());
        assert!(dir.path().join(".other.pbgi.4294967295-0.part").exists());
    }

    #[test]
    fn a_growing_file_appears_when_it_is_finished_and_leaves_nothing_otherwise() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("new/tree");
        let mut file = Growing::create(&path).unwrap();
        file.write(b"in").unwrap();
        assert!(!path.exists());
        drop(file);
        assert_eq!(fs::read_dir(dir.path().join("new")).unwrap().count(), 0);
        let mut file = Growing::create(&path).unwrap();
        file.write(b"in").unwrap();
        file.write(b"k").unwrap();
        let output = file.finish().unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"ink");
        assert_eq!(output.sha256, write::sha256(b"ink"));
        assert_eq!(fs::read_dir(dir.path().join("new")).unwrap().count(), 1);
    }
}
