//! Whole files or none: write beside, flush, rename.

use crate::disk::reason;
use crate::record::Output;
use chiaro_basis::{Error, Result};
use sha2::{Digest, Sha256};
use std::fs::{self, File};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};

static COUNTER: AtomicU64 = AtomicU64::new(0);

/// Writes `bytes` to `path` so that it appears whole or not at all. Missing folders are made. A
/// device or a pipe (`/dev/stdout`) is written to, and not replaced.
pub fn whole(path: &Path, bytes: &[u8]) -> Result<Output> {
    let fail = |e: &std::io::Error| Error::output(path.display().to_string(), reason(e));
    if path.is_dir() {
        return Err(Error::output(path.display().to_string(), "is a folder; name a file in it"));
    }
    if fs::metadata(path).is_ok_and(|m| !m.is_file()) {
        let written = File::options().write(true).open(path).and_then(|mut f| f.write_all(bytes));
        written.map_err(|e| fail(&e))?;
        return Ok(Output {
            path: path.to_path_buf(),
            bytes: bytes.len() as u64,
            sha256: sha256(bytes),
        });
    }
    if let Some(parent) = path.parent().filter(|p| !p.as_os_str().is_empty()) {
        fs::create_dir_all(parent).map_err(|e| fail(&e))?;
    }
    let beside = beside(path);
    let written = write_and_flush(&beside, bytes).and_then(|()| fs::rename(&beside, path));
    if let Err(e) = written {
        // The original error is the one to tell.
        let _ = fs::remove_file(&beside);
        return Err(fail(&e));
    }
    Ok(Output { path: path.to_path_buf(), bytes: bytes.len() as u64, sha256: sha256(bytes) })
}

/// A name in the same folder that no other process and no other call uses.
pub(crate) fn beside(path: &Path) -> PathBuf {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let count = COUNTER.fetch_add(1, Ordering::Relaxed);
    path.with_file_name(format!(".{name}.{}-{count}.part", std::process::id()))
}

fn write_and_flush(path: &Path, bytes: &[u8]) -> std::io::Result<()> {
    let mut file = File::create(path)?;
    file.write_all(bytes)?;
    file.sync_all()
}

/// The hash of some bytes, in hexadecimal.
pub fn sha256(bytes: &[u8]) -> String {
    Sha256::digest(bytes).iter().map(|b| format!("{b:02x}")).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_appear_whole_and_leave_nothing_beside() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("new/folder/a.txt");
        let output = whole(&path, b"ink").unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"ink");
        assert_eq!(output.bytes, 3);
        assert_eq!(fs::read_dir(path.parent().unwrap()).unwrap().count(), 1);
    }

    #[test]
    fn what_cannot_be_written_is_one_sentence() {
        let dir = tempfile::tempdir().unwrap();
        let error = whole(dir.path(), b"ink").unwrap_err().to_string();
        assert!(error.contains("is a folder"), "{error}");
        let file = dir.path().join("file");
        fs::write(&file, "x").unwrap();
        assert!(whole(&file.join("a.png"), b"ink").is_err());
        #[cfg(target_os = "linux")]
        {
            let error = whole(Path::new("/dev/full"), b"ink").unwrap_err().to_string();
            assert!(error.contains("disk is full"), "{error}");
        }
        assert_eq!(fs::read(&file).unwrap(), b"x");
    }
}
