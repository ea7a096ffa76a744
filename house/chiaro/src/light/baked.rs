//! `--bake` and `--tree`: trees in files.
//!
//! A tree file is mapped, not read: pages come from the disk when a gather asks for them and go
//! when memory is short, so that a tree may be larger than memory, and renders at the same time share one copy.
//! It is opened once for a film; all of its bytes are checked then.

use super::book::Taught;
use super::cap::{Cap, TOUCHES};
use crate::disk::reason;
use crate::project::Project;
use crate::record::Output;
use chiaro_basis::{Error, Knobs, Result, Run};
use chiaro_pbgi::compact::{Bytes, Compact};
use chiaro_pbgi::packed::Packed;
use chiaro_pbgi::{LightKnobs, OwnSky, file};
use memmap2::Mmap;
use serde_json::{Map, Value, json};
use std::fs::File;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::{Arc, Mutex};

/// Where a shot's coded trees come from and go to.
#[derive(Default)]
pub(crate) struct TreeFiles {
    /// A tree that was baked before.
    pub(crate) baked: Option<Baked>,
    /// Where a tree is to be baked.
    pub(crate) bake: Option<PathBuf>,
    /// What the tree is made from.
    pub(crate) origin: String,
    /// The book that all frames share.
    pub(crate) book: Option<Taught>,
    /// The most memory that may be used.
    pub(crate) cap: Option<Cap>,
    /// Files that were written.
    pub(crate) written: Mutex<Vec<Output>>,
}

/// A tree from a file.
pub(crate) struct Baked {
    pub(crate) tree: Packed<Compact>,
    /// What it was made from.
    pub(crate) origin: String,
}

/// What a tree is made from, as its file says.
pub(crate) fn origin(project: &Project, knobs: &LightKnobs, env_hash: Option<&str>) -> String {
    json!({
        "program": "chiaro", "input_sha256": project.hash, "surfels": knobs.surfels,
        "bounces": knobs.bounces, "clusters": knobs.clusters, "max_error": knobs.max_error,
        "sun": project.options.sun, "env_sha256": env_hash, "own_sky": knobs.sky == OwnSky::Auto,
    })
    .to_string()
}

/// Maps a tree file and checks it; a warning when it was made from another scene or other light.
pub(crate) fn open(path: &Path, expected: &str, cap: Option<&Cap>, run: &Run) -> Result<Baked> {
    let (name, map) = mapped(path)?;
    if let Some(cap) = cap {
        cap.keeps(&map);
    }
    let touched = AtomicU32::new(0);
    let bytes: Bytes = Arc::new(Mapped { map, cap: cap.cloned(), touched });
    let pause = || cap.into_iter().for_each(Cap::relieve);
    let (tree, origin) = run.stage("load", 1, || file::open(bytes, &name, &pause))?;
    if origin != expected {
        let made = differences(&origin, expected);
        run.warn(format!("{name} was baked from {made}; far light comes from there"));
    }
    Ok(Baked { tree, origin })
}

/// What a tree file knows of how it was made, by the names of knobs.
const MADE_WITH: [&str; 4] = ["surfels", "bounces", "clusters", "max_error"];

/// Sets knobs as those of the tree in a file were, but for those that the user has `said`.
pub fn adopt(path: &Path, knobs: &mut LightKnobs, said: impl Fn(&str) -> bool) -> Result<()> {
    let (name, map) = mapped(path)?;
    let made = file::origin(&map, &name)?;
    let made = serde_json::from_str::<Map<String, Value>>(&made).unwrap_or_default();
    for knob in MADE_WITH.into_iter().filter(|knob| !said(knob)) {
        if let Some(value) = made.get(knob).filter(|value| value.is_number()) {
            knobs.set(knob, &value.to_string())?;
        }
    }
    Ok(())
}

/// How what a tree was made from differs from what is expected, in words.
fn differences(made: &str, expected: &str) -> String {
    let read = |origin| serde_json::from_str::<Map<String, Value>>(origin).unwrap_or_default();
    let (made, expected) = (read(made), read(expected));
    let differ = expected.keys().filter(|k| made.get(*k) != expected.get(*k));
    let mut words: Vec<String> = differ
        .map(|key| match (key.as_str(), made.get(key)) {
            ("input_sha256" | "program", _) => "another scene".into(),
            ("env_sha256", _) => "another environment".into(),
            ("sun" | "own_sky", _) => "another sun or sky".into(),
            (key, Some(value)) => format!("{key} = {value} (here {})", expected[key]),
            (key, None) => format!("another {key}"),
        })
        .collect();
    words.dedup();
    if words.is_empty() { "something else".into() } else { words.join(", ") }
}

/// A map that is shared with who keeps the cap.
struct Mapped {
    map: Arc<Mmap>,
    cap: Option<Cap>,
    touched: AtomicU32,
}

impl AsRef<[u8]> for Mapped {
    fn as_ref(&self) -> &[u8] {
        if let Some(cap) = &self.cap
            && self.touched.fetch_add(1, Ordering::Relaxed).is_multiple_of(TOUCHES)
        {
            cap.relieve();
        }
        &self.map
    }
}

/// The bytes of a tree file, which is not empty, and its name.
fn mapped(path: &Path) -> Result<(String, Arc<Mmap>)> {
    let name = path.display().to_string();
    let fail = |e: std::io::Error| Error::input(name.clone(), "", reason(&e));
    let opened = File::open(path).map_err(fail)?;
    if opened.metadata().map_err(fail)?.len() == 0 {
        return Err(Error::input(name, "", "is empty; make one with chiaro light --bake"));
    }
    let map = map(&opened).map_err(fail)?;
    Ok((name, map))
}

/// The bytes of a file where they lie.
#[allow(unsafe_code)]
pub(crate) fn map(file: &File) -> std::io::Result<Arc<Mmap>> {
    // SAFETY: the map is read only. Were the file changed while it is mapped, other numbers would
    // be read; every number from it is clamped to what there is, and tree files are replaced by
    // renaming, never rewritten. The safe twin, reading it all, needs the memory this is to spare.
    Ok(Arc::new(unsafe { Mmap::map(file)? }))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_no_tree_file_is_one_sentence() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.pbgi");
        let told = || match open(&path, "", None, &Run::default()) {
            Ok(_) => String::new(),
            Err(e) => e.to_string(),
        };
        assert!(told().contains("a.pbgi"));
        std::fs::write(&path, b"").unwrap();
        assert!(told().contains("is empty"));
        std::fs::write(&path, b"ink").unwrap();
        assert!(told().contains("is no tree file"));
    }

    #[test]
    fn what_a_tree_was_made_from_is_told_where_it_differs() {
        let of = |surfels: u32, sha: &str| {
            json!({ "surfels": surfels, "input_sha256": sha }).to_string()
        };
        let told = differences(&of(50_000, "a"), &of(200_000, "a"));
        assert_eq!(told, "surfels = 50000 (here 200000)");
        assert_eq!(differences(&of(1, "a"), &of(1, "b")), "another scene");
        assert_eq!(differences("", &of(1, "b")), "another surfels, another scene");
        assert_eq!(differences("{", "{}"), "something else");
    }

    #[test]
    fn a_mapped_file_has_the_bytes_of_one_that_was_read() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a");
        std::fs::write(&path, b"some bytes").unwrap();
        let map = map(&File::open(&path).unwrap()).unwrap();
        assert_eq!(map[..], std::fs::read(&path).unwrap());
    }
}
