//! Strokes from a file, for a job: what is painted, and how much of it is learned.

use crate::disk;
use crate::write;
use chiaro_basis::{Error, Result};
use chiaro_binary::{Lesson, Paint, Strokes, View};
use serde_json::{Value, json};
use std::path::Path;

/// Strokes of a job.
#[derive(Clone, Debug)]
pub struct Painting {
    strokes: Strokes,
    hash: String,
    blend: f32,
}

impl Painting {
    /// Reads a stroke file; `blend` is the share of what it teaches in the weights.
    ///
    /// # Errors
    /// [`Error::Input`] for a file that is missing, no text, or wrong in a line.
    pub fn open(path: &Path, blend: f32) -> Result<Self> {
        let name = path.display().to_string();
        let bytes = disk::read(path)?;
        let hash = write::sha256(&bytes);
        let text = String::from_utf8(bytes).map_err(|_| {
            Error::input(
                &name,
                "",
                "is no text; a stroke file has lines such as white 6 120,80 140,90",
            )
        })?;
        Ok(Self { strokes: Strokes::parse(&name, &text)?, hash, blend })
    }

    /// The frames of a shot that strokes are on, of those that all frames' strokes are on the
    /// `sampled`.
    pub(crate) fn lessons(&self, shot: &[u32], sampled: &[u32]) -> Vec<u32> {
        let (mut frames, everywhere) = self.strokes.frames();
        frames.retain(|frame| shot.contains(frame));
        if everywhere {
            frames.extend(sampled);
        }
        frames.sort_unstable();
        frames.dedup();
        frames
    }

    /// Adds what the strokes of a frame teach.
    pub(crate) fn teach(&self, lesson: &mut Lesson, view: &View, frame: u32) {
        let covered = &view.buffer.covered;
        lesson.add(&self.strokes.drawn(covered.size(), frame), &view.channels, covered);
    }

    /// What the strokes of a frame do to its view, where nothing was learned elsewhere.
    pub fn paint(&self, view: &View, frame: u32) -> Paint {
        let mut lesson = Lesson::default();
        self.teach(&mut lesson, view, frame);
        self.taught(view, frame, &lesson)
    }

    /// What the strokes of a frame, and a lesson, do to its view.
    pub(crate) fn taught(&self, view: &View, frame: u32, lesson: &Lesson) -> Paint {
        let covered = &view.buffer.covered;
        let drawn = self.strokes.drawn(covered.size(), frame);
        Paint::taught(drawn, lesson, (&view.channels, covered), self.blend)
    }

    /// For recipes.
    pub fn settings(&self) -> Value {
        json!({ "strokes_sha256": self.hash, "blend": self.blend })
    }
}
