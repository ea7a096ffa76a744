//! Films: output patterns, and which frames are already there.
//!
//! A film's frames are files of a pattern (`frames/####.png`). Beside them a folder `.chiaro` holds
//! one small receipt a frame: the hash of the recipe and the hash of the file. A frame is done when
//! its receipt names this very recipe and the file still has that hash; mere existence proves
//! nothing. Receipts are files of their own, so that two processes on one folder do not spoil each
//! other's.

use crate::movie::Container;
use crate::record::Output;
use crate::write;
use chiaro_basis::{Error, Result};
use serde::{Deserialize, Serialize};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// Where frames go.
#[derive(Clone, Debug, PartialEq)]
pub enum Target {
    /// One picture.
    Single(PathBuf),
    /// A file a frame; `#` signs stand for the frame number.
    Pattern(PathBuf),
    /// All frames in one file: an animated PNG or GIF, MP4 or WebM.
    Animation(PathBuf),
}

impl Target {
    /// Reads an output path: `####` makes a pattern, a folder holds `####.png`, `.apng`, `.gif`,
    /// `.mp4` and `.webm` are animations (the latter two where this machine has ffmpeg), anything
    /// else is one picture, of which several frames cannot be made.
    pub fn parse(path: &Path, frames: usize) -> Result<Self> {
        let text = path.to_string_lossy();
        let fail = |range: &str| Err(Error::setting("-o", &text, range));
        if text.is_empty() {
            return fail("a file name, as in out.png");
        }
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        if let Some(container) = Container::of(&extension(path)) {
            container.check(path)?;
            return Ok(Self::Animation(path.into()));
        }
        if name.contains('#') {
            return Ok(Self::Pattern(path.into()));
        }
        if path.is_dir() || text.ends_with('/') {
            return Ok(Self::Pattern(path.join("####.png")));
        }
        if frames > 1 {
            return fail(
                "a pattern with # for the digits of the frame, as in frames/####.png, a folder, or an .apng, .gif, .mp4 or .webm",
            );
        }
        Ok(Self::Single(path.into()))
    }

    /// The file of a frame.
    pub fn file(&self, frame: u32) -> PathBuf {
        match self {
            Self::Single(path) | Self::Animation(path) => path.clone(),
            Self::Pattern(path) => {
                let name = path.file_name().unwrap_or_default().to_string_lossy();
                path.with_file_name(numbered(&name, frame))
            }
        }
    }

    /// An error if some of the frames would be written over a file that is read for them.
    pub fn spares(&self, frames: &[u32], read: impl IntoIterator<Item = PathBuf>) -> Result<()> {
        spare(frames.iter().map(|f| ("-o", self.file(*f))), read)
    }

    /// Whether frames become parts of one file.
    pub fn is_animation(&self) -> bool {
        matches!(self, Self::Animation(_))
    }

    /// The file's ending, in lower case.
    pub fn extension(&self) -> String {
        match self {
            Self::Single(p) | Self::Pattern(p) | Self::Animation(p) => extension(p),
        }
    }
}

/// An error if a file that an option names to write is one of those that are read.
pub fn spare<'a>(
    written: impl IntoIterator<Item = (&'a str, PathBuf)>,
    read: impl IntoIterator<Item = PathBuf>,
) -> Result<()> {
    let same = |path: &Path| path.canonicalize().ok();
    let read: BTreeSet<PathBuf> = read.into_iter().filter_map(|p| same(&p)).collect();
    match written.into_iter().find(|(_, p)| same(p).is_some_and(|p| read.contains(&p))) {
        Some((option, path)) => {
            let spared = "another file: this one is read, and would be written over";
            Err(Error::setting(option, path.display(), spared))
        }
        None => Ok(()),
    }
}

fn extension(path: &Path) -> String {
    path.extension().unwrap_or_default().to_string_lossy().to_ascii_lowercase()
}

/// The name with its first run of `#` replaced by the number, padded with zeros.
pub(crate) fn numbered(name: &str, frame: u32) -> String {
    let Some(start) = name.find('#') else { return name.into() };
    let digits = name[start..].chars().take_while(|c| *c == '#').count();
    format!("{}{frame:0digits$}{}", &name[..start], &name[start + digits..])
}

/// The file of a part of a frame: its name with the part's number before the ending.
pub(crate) fn part_of(file: &Path, part: usize) -> PathBuf {
    let stem = file.file_stem().unwrap_or_default().to_string_lossy();
    let ending = file.extension().unwrap_or_default().to_string_lossy();
    file.with_file_name(format!("{stem}-{part}.{ending}"))
}

/// What is known of a finished frame.
#[derive(Serialize, Deserialize, PartialEq)]
struct Receipt {
    recipe: String,
    bytes: u64,
    sha256: String,
}

fn receipt_path(file: &Path) -> PathBuf {
    let name = file.file_name().unwrap_or_default().to_string_lossy();
    file.with_file_name(".chiaro").join(format!("{name}.json"))
}

/// The output of a frame that was already made by this recipe and is still whole.
pub fn finished(file: &Path, recipe: &str) -> Option<Output> {
    let receipt: Receipt = serde_json::from_slice(&std::fs::read(receipt_path(file)).ok()?).ok()?;
    if receipt.recipe != write::sha256(recipe.as_bytes()) {
        return None;
    }
    let bytes = std::fs::read(file).ok()?;
    let sha256 = write::sha256(&bytes);
    (sha256 == receipt.sha256).then(|| Output {
        path: file.into(),
        bytes: bytes.len() as u64,
        sha256,
    })
}

/// Writes a frame and then its receipt.
pub fn write_frame(file: &Path, bytes: &[u8], recipe: &str) -> Result<Output> {
    let output = write::whole(file, bytes)?;
    let receipt = Receipt {
        recipe: write::sha256(recipe.as_bytes()),
        bytes: output.bytes,
        sha256: output.sha256.clone(),
    };
    let text = serde_json::to_vec(&receipt).expect("a receipt is plain data");
    write::whole(&receipt_path(file), &text)?;
    Ok(output)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn patterns_number_their_frames() {
        let target = Target::parse(Path::new("out/a_####.png"), 3).unwrap();
        assert_eq!(target.file(7), Path::new("out/a_0007.png"));
        assert_eq!(target.file(12345), Path::new("out/a_12345.png"));
        assert_eq!(target.extension(), "png");
        assert!(Target::parse(Path::new("a.png"), 2).is_err());
        assert!(matches!(Target::parse(Path::new("a.apng"), 2).unwrap(), Target::Animation(_)));
    }

    #[test]
    fn what_is_read_is_not_written_over() {
        let dir = tempfile::tempdir().unwrap();
        let read = dir.path().join("0003.png");
        std::fs::write(&read, b"picture").unwrap();
        let target = Target::parse(&dir.path().join("./####.png"), 4).unwrap();
        let error = target.spares(&[1, 2, 3], [read.clone()]).unwrap_err().to_string();
        assert!(error.contains("0003.png") && error.contains("written over"), "{error}");
        assert!(target.spares(&[1, 2], [read]).is_ok());
        assert!(target.spares(&[1, 2, 3], [dir.path().join("other.png")]).is_ok());
    }

    #[test]
    fn a_frame_is_finished_only_with_its_recipe_and_its_bytes() {
        let dir = tempfile::tempdir().unwrap();
        let file = dir.path().join("0001.png");
        assert!(finished(&file, "a").is_none());
        write_frame(&file, b"picture", "a").unwrap();
        assert!(finished(&file, "a").is_some());
        assert!(finished(&file, "b").is_none());
        std::fs::write(&file, b"pict").unwrap();
        assert!(finished(&file, "a").is_none());
    }
}
