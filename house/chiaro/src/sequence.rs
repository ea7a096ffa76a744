//! Numbered files: a film as others hand it over.

use chiaro_basis::{Error, Result};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// The numbered files of a folder or of a pattern.
pub(crate) fn numbered(path: &Path) -> Result<BTreeMap<u32, PathBuf>> {
    let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let pattern = name.contains('#');
    let (folder, before, after) = if pattern {
        let folder = path.parent().filter(|p| !p.as_os_str().is_empty());
        let first = name.find('#').unwrap_or(0);
        let last = name.rfind('#').unwrap_or(0);
        (folder.unwrap_or(Path::new(".")), name[..first].to_owned(), name[last + 1..].to_owned())
    } else {
        (path, String::new(), String::new())
    };
    let entries = std::fs::read_dir(folder)
        .map_err(|e| Error::input(folder.display().to_string(), "", e.to_string()))?;
    let mut files = BTreeMap::new();
    for file in entries.filter_map(|e| Some(e.ok()?.path())).filter(|p| p.is_file()) {
        let name = file.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let number = if pattern {
            name.strip_prefix(&before).and_then(|n| n.strip_suffix(&after)).map(str::to_owned)
        } else {
            let stem = file.file_stem().unwrap_or_default().to_string_lossy().into_owned();
            let digits = stem.len() - stem.bytes().rev().take_while(u8::is_ascii_digit).count();
            Some(stem[digits..].to_owned())
        };
        if let Some(n) = number.and_then(|n| n.parse().ok()) {
            files.insert(n, file);
        }
    }
    match files.is_empty() {
        true => {
            let why = "no numbered file there; name a folder of frames, or a pattern with #";
            Err(Error::input(path.display().to_string(), "", why))
        }
        false => Ok(files),
    }
}
