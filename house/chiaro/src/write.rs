//! Whole files or none: write beside, flush, rename.

use crate::disk::reason;
use crate::record::Output;
use chiaro_basis::{Error, Result};
use sha2::{Digest, Sha256};
use std::fs::{self, File};
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};

static COUNTER: AtomicU64 = AtomicU64::new(0);

/// Writes `bytes` to `path` so that it appears whole or not at all. Missing folders are made. A
/// device or a pipe (`/dev/stdout`) is written to, and not replaced.
pub fn whole(path: &Path, bytes: &[u8]) -> Result<Output> {
    streamed(path, |sink| sink.write_all(bytes))
}

/// The same for what is made piece by piece and need not be in memory as a whole: `make` writes it.
pub fn streamed(
    path: &Path,
    make: impl FnOnce(&mut dyn Write) -> std::io::Result<()>,
) -> Result<Output> {
    let fail = |e: &std::io::Error| Error::output(path.display().to_string(), reason(e));
    if path.is_dir() {
        return Err(Error::output(path.display().to_string(), "is a folder; name a file in it"));
    }
    if fs::metadata(path).is_ok_and(|m| !m.is_file()) {
        let device = File::options().write(true).open(path).map_err(|e| fail(&e))?;
        return Counted::fill(device, make).map_err(|e| fail(&e)).map(|c| c.output(path));
    }
    if let Some(parent) = path.parent().filter(|p| !p.as_os_str().is_empty()) {
        fs::create_dir_all(parent).map_err(|e| fail(&e))?;
    }
    let beside = beside(path);
    let write = || {
        let counted = Counted::fill(File::create(&beside)?, make)?;
        counted.file.sync_all()?;
        fs::rename(&beside, path)?;
        Ok(counted)
    };
    write().map(|c| c.output(path)).map_err(|e| {
        // The original error is the one to tell.
        let _ = fs::remove_file(&beside);
        fail(&e)
    })
}

/// A file that counts and hashes what is written to it.
struct Counted {
    file: File,
    bytes: u64,
    hash: Sha256,
}

impl Counted {
    fn fill(
        file: File,
        make: impl FnOnce(&mut dyn Write) -> std::io::Result<()>,
    ) -> std::io::Result<Self> {
        let mut sink = BufWriter::new(Self { file, bytes: 0, hash: Sha256::new() });
        make(&mut sink)?;
        sink.into_inner().map_err(std::io::IntoInnerError::into_error)
    }

    fn output(self, path: &Path) -> Output {
        let sha256 = hexadecimal(&self.hash.finalize());
        Output { path: path.to_path_buf(), bytes: self.bytes, sha256 }
    }
}

impl Write for Counted {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        let count = self.file.write(bytes)?;
        self.hash.update(&bytes[..count]);
        self.bytes += count as u64;
        Ok(count)
    }

    fn flush(&mut self) -> std::io::Result<()> {
        self.file.flush()
    }
}

/// A name in the same folder that no other process and no other call uses.
pub(crate) fn beside(path: &Path) -> PathBuf {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let count = COUNTER.fetch_add(1, Ordering::Relaxed);
    path.with_file_name(format!(".{name}.{}-{count}.part", std::process::id()))
}

/// The hash of some bytes, in hexadecimal.
pub fn sha256(bytes: &[u8]) -> String {
    hexadecimal(&Sha256::digest(bytes))
}

fn hexadecimal(bytes: &[u8]) -> String {
    bytes.iter().map(|b| format!("{b:02x}")).collect()
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
    fn pieces_make_the_same_file_as_the_whole() {
        let dir = tempfile::tempdir().unwrap();
        let [one, many] = ["one", "many"].map(|name| dir.path().join(name));
        let text = "a line of ink\n".repeat(5000);
        let pieces = |sink: &mut dyn Write| text.lines().try_for_each(|l| writeln!(sink, "{l}"));
        let written = streamed(&many, pieces).unwrap();
        let expected = whole(&one, text.as_bytes()).unwrap();
        assert_eq!(fs::read(&many).unwrap(), text.as_bytes());
        assert_eq!((written.bytes, written.sha256), (expected.bytes, expected.sha256));
        let cut = |sink: &mut dyn Write| {
            sink.write_all(text.as_bytes())?;
            Err(std::io::Error::other("it ends here"))
        };
        assert!(streamed(&many, cut).is_err());
        assert_eq!(fs::read(&many).unwrap(), text.as_bytes(), "half a file replaces nothing");
        assert_eq!(fs::read_dir(dir.path()).unwrap().count(), 2);
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
