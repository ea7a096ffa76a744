//! [`Frames`]: the pictures of a job on their way to files.
//!
//! 1. Frames of a pattern that are there already, made by the same recipe, are told apart from those
//!    that are missing.
//! 2. A finished frame becomes a file of its own, or a part of the one animation.
//! 3. At the end the record has all files and measures, in the order of the frames.

use crate::film::{self, Target};
use crate::movie::{Container, Movie};
use crate::record::{Output, Record};
use crate::write;
use chiaro_basis::{Result, Run};
use chiaro_image::Plane;
use chiaro_image::codec::Packed;
use serde_json::{Map, Value};
use std::path::PathBuf;

/// Files and measures of a job's frames; `recipe` is that of a frame.
pub(crate) struct Frames<'a> {
    target: &'a Target,
    /// Files a frame, where it is more than one.
    parts: usize,
    recipe: &'a dyn Fn(u32) -> String,
    outputs: Vec<(u32, Output)>,
    pictures: Vec<(u32, Packed)>,
    counts: Vec<(u32, Map<String, Value>)>,
}

impl<'a> Frames<'a> {
    pub(crate) fn new(target: &'a Target, recipe: &'a dyn Fn(u32) -> String) -> Self {
        let (outputs, pictures, counts) = Default::default();
        Self { target, parts: 1, recipe, outputs, pictures, counts }
    }

    /// The same with so many files a frame: `name-1.png`, `name-2.png`, and so on.
    pub(crate) fn in_parts(self, parts: usize) -> Self {
        Self { parts, ..self }
    }

    /// The files of a frame.
    fn files(&self, number: u32) -> Vec<PathBuf> {
        let file = self.target.file(number);
        match self.parts {
            1 => vec![file],
            parts => (1..=parts).map(|part| film::part_of(&file, part)).collect(),
        }
    }

    /// Those of the frames whose files are not there yet.
    pub(crate) fn missing(&mut self, numbers: Vec<u32>) -> Vec<u32> {
        let Target::Pattern(_) = self.target else { return numbers };
        let is_missing = |number: &u32| {
            let recipe = (self.recipe)(*number);
            let files = self.files(*number);
            let there: Vec<_> =
                files.iter().map_while(|file| film::finished(file, &recipe)).collect();
            let missing = there.len() < files.len();
            self.outputs.extend(there.into_iter().filter(|_| !missing).map(|o| (*number, o)));
            missing
        };
        numbers.into_iter().filter(is_missing).collect()
    }

    /// Whether frames become parts of an animation.
    pub(crate) fn are_one_file(&self) -> bool {
        self.target.is_animation()
    }

    /// Keeps a frame of an animation, packed, so that long films need not be in memory as pixels.
    pub(crate) fn keep(&mut self, number: u32, picture: Plane<[u8; 4]>) {
        self.pictures.push((number, Packed::of(picture)));
    }

    /// Writes a frame's own file.
    pub(crate) fn write(&mut self, number: u32, bytes: &[u8], run: &Run) -> Result<()> {
        self.write_parts(number, &[bytes], run)
    }

    /// Writes a frame's own files.
    pub(crate) fn write_parts<B: AsRef<[u8]>>(
        &mut self,
        number: u32,
        parts: &[B],
        run: &Run,
    ) -> Result<()> {
        for (file, bytes) in self.files(number).iter().zip(parts) {
            let bytes = bytes.as_ref();
            let output = run.stage("write", 1, || match self.target {
                Target::Pattern(_) => film::write_frame(file, bytes, &(self.recipe)(number)),
                _ => write::whole(file, bytes),
            })?;
            self.outputs.push((number, output));
        }
        Ok(())
    }

    /// Writes a file of its own that is made piece by piece.
    pub(crate) fn stream(
        &mut self,
        number: u32,
        make: impl FnOnce(&mut dyn std::io::Write) -> std::io::Result<()>,
    ) -> Result<()> {
        self.outputs.push((number, write::streamed(&self.target.file(number), make)?));
        Ok(())
    }

    /// Remembers files that were written beside a frame's.
    pub(crate) fn beside(&mut self, number: u32, outputs: Vec<Output>) {
        self.outputs.extend(outputs.into_iter().map(|output| (number, output)));
    }

    /// Remembers what was measured on a frame.
    pub(crate) fn measured(&mut self, number: u32, counts: Map<String, Value>) {
        self.counts.push((number, counts));
    }

    /// Writes the animation and fills in the record: the measures of one frame as they are, those of
    /// several as a list.
    pub(crate) fn finish(mut self, fps: f64, record: &mut Record, run: &Run) -> Result<()> {
        self.pictures.sort_by_key(|(number, _)| *number);
        if let (Target::Animation(path), Some((first, _))) = (self.target, self.pictures.first()) {
            let (first, recipe) = (*first, (self.recipe)(*first));
            let pictures: Vec<_> = self.pictures.into_iter().map(|(_, picture)| picture).collect();
            let container = Container::of(&self.target.extension()).unwrap_or(Container::Apng);
            let movie = Movie { frames: &pictures, fps, recipe: &recipe };
            let written = run.stage("write", 1, || container.write(path, &movie, run))?;
            self.outputs.push((first, written));
        }
        self.outputs.sort_by_key(|(number, _)| *number);
        record.outputs.extend(self.outputs.into_iter().map(|(_, output)| output));
        self.counts.sort_by_key(|(number, _)| *number);
        let mut counts: Vec<_> = self.counts.into_iter().map(|(_, counts)| counts).collect();
        match counts.len() {
            1 => record.counts.append(&mut counts[0]),
            _ => record.count("frames", counts),
        }
        Ok(())
    }
}
