//! The book of a shot: one for all frames, so that nothing flickers, and for several scenes with
//! `--book FILE`.
//!
//! It is learned from sparse surfels on a few frames of the shot (the same ones whichever frames are
//! written), or read from a file that an earlier run made. A picture alone learns from its own frame, as the
//! tree is built. `--set book=frame` makes a film do so too, to see what it costs.

use super::shot::Shot;
use crate::disk;
use crate::project::Project;
use crate::record::Output;
use crate::write;
use chiaro_basis::{Result, Run};
use chiaro_pbgi::code::Book;
use chiaro_pbgi::packed::Record;
use chiaro_pbgi::stream::Lesson;
use chiaro_pbgi::surfel::Lit;
use chiaro_pbgi::{LightKnobs, Spread, Teaching, chosen, file, prepare, sites, stream};
use serde_json::{Map, Value, json};
use std::path::Path;

/// Frames of a film from which its book is learned, and surfels of each.
const FRAMES: usize = 3;
const SURFELS: u32 = 40_000;

/// Nodes of a size by which a book from a file is examined, and the error that is told.
const EXAMINED: usize = 512;
const MISFIT: f64 = 0.1;

/// A book, and what is told of it.
#[derive(Clone)]
pub(crate) struct Taught {
    pub(crate) book: Book,
    pub(crate) counts: Map<String, Value>,
    /// Whether it comes from a file, and perhaps from another scene.
    pub(crate) foreign: bool,
}

/// The book that the shot's frames share, and its file where one was written; `None` where each frame learns its own.
pub(crate) fn of_shot(
    project: &Project,
    shot: &Shot,
    knobs: &LightKnobs,
    path: Option<&Path>,
    run: &Run,
) -> Result<(Option<Taught>, Option<Output>)> {
    if let Some(path) = path.filter(|p| p.exists()) {
        let bytes = run.stage("load", 1, || disk::read(path))?;
        let book = file::read_book(&bytes, &path.display().to_string())?;
        return Ok((Some(Taught { foreign: true, ..told(book, None) }), None));
    }
    let film = project.shot().len() > 1 && knobs.book == Teaching::Film;
    if path.is_none() && !film {
        return Ok((None, None));
    }
    let numbers = project.sampled_shot(if film { FRAMES } else { 1 });
    let poser = project.poser();
    let mut lessons = Vec::new();
    for number in numbers {
        run.check()?;
        let frame = project.pose(&poser, number, run);
        let tracer = project.tracer(&frame);
        let lights = shot.lights(&tracer);
        let lit = Lit { tracer: &tracer, surfaces: &shot.surfaces, lights: &lights };
        let count = knobs.surfels.min(SURFELS);
        let few = LightKnobs { surfels: count, ..knobs.clone() };
        let places = sites(&project.scene, &frame, count as usize);
        let points = prepare(lit, &places, &few, run)?;
        let spread = Spread::of(&project.scene, &frame, count.into());
        let records = stream::sorted(&points.surfels.all, &stream::cube(&lit, &spread));
        lessons.extend(stream::lessons(&records, knobs.lessons()));
    }
    let taught = taught(&lessons, knobs, run)?;
    let output = match path {
        Some(path) => {
            let bytes = file::book_bytes(&taught.book);
            Some(run.stage("write", 1, || write::whole(path, &bytes))?)
        }
        None => None,
    };
    Ok((Some(taught), output))
}

/// The book that lessons teach: the knobs' recipe, or the smallest that keeps their bound.
pub(crate) fn taught(lessons: &[Lesson], knobs: &LightKnobs, run: &Run) -> Result<Taught> {
    run.stage("book", lessons.len() as u64, || {
        if knobs.max_error > 0.0 {
            let found = chosen::smallest(lessons, knobs.max_error.into(), run)?;
            return Ok(told(found.book, Some(found.error)));
        }
        Ok(told(stream::taught(lessons, &knobs.recipe(), run)?, None))
    })
}

impl Taught {
    /// Tells how a book from a file suits a scene's records; a warning where it does not.
    pub(crate) fn examine(&mut self, records: &[Record], run: &Run) {
        let lessons = stream::lessons(records, EXAMINED);
        let error = chosen::error(&self.book, lessons.iter());
        self.counts.insert("book_error".into(), json!(error));
        if error > MISFIT {
            run.warn(format!(
                "the book was learned elsewhere, and its error here is {:.0} %: colours may be wrong; \
                 name another file, and a book is learned from this scene",
                100.0 * error
            ));
        }
    }
}

fn told(book: Book, error: Option<f64>) -> Taught {
    let mut counts = Map::new();
    counts.insert("code_bytes".into(), json!(book.recipe.bytes()));
    counts.insert("lut_entries".into(), json!(book.words()));
    if let Some(error) = error {
        counts.insert("book_error".into(), json!(error));
    }
    Taught { book, counts, foreign: false }
}
