//! Films of pictures that others made: numbered files, labelled along their own motion vectors.
//!
//! 1. Once for the shot: the exposure, and what strokes teach, on a few of its files.
//! 2. A file at a time becomes a view; its motion vectors say which pixel of the frame before shows the
//!    same point. It counts where the object is the same and, where the file before knows where its
//!    points go, where that comes back to within a pixel and a half; else where the depth is about
//!    the same.
//! 3. The film is cut along these links like one of a scene. Without motion vectors each frame is on
//!    its own, by the exposure of all.

use super::layers::Motion;
use super::view::view;
use super::{Given, Maps, ending, surveyed};
use crate::binary::reel::{self, Labelling, Setting, Source, Take};
use crate::binary::{Encoding, Look, Picture, hand_over};
use crate::disk;
use crate::film::{Target, numbered as with_number};
use crate::frames::Frames;
use crate::record::{Record, frame_recipe};
use crate::sequence::numbered;
use crate::write;
use chiaro_basis::{Error, Result, Run};
use chiaro_binary::{BinaryKnobs, Exposure, Lesson, Palette, View, expose};
use chiaro_image::Plane;
use chiaro_trace::UNLINKED;
use serde_json::{Map, Value, json};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Files that a shot's exposure is surveyed on, at most.
const SURVEY_FRAMES: usize = 5;
/// How far from a pixel a point may come back to, in pixels.
const CLOSE: f32 = 1.5;
/// Share of a depth within which another counts as the same surface.
const SAME_DEPTH: f32 = 0.05;

/// Whether `name` is a pattern of pictures, such as `frames/####.exr`.
pub fn is_sequence(name: &str) -> bool {
    let ending = ending(Path::new(name));
    name.contains('#') && ["png", "jpg", "jpeg", "exr"].contains(&ending.as_str())
}

/// Numbered pictures, and maps with the same numbers.
pub struct Sequence {
    pattern: String,
    files: BTreeMap<u32, PathBuf>,
    maps: Maps,
    shot: Vec<u32>,
    frames: Vec<u32>,
}

impl Sequence {
    /// Looks for the files of a pattern. Without `frames` all are made, without `shot` the frames
    /// are the shot. Names of maps may hold `#` too.
    ///
    /// # Errors
    /// [`Error::Input`] where no file is found, [`Error::Setting`] for a frame without a file.
    pub fn open(
        pattern: &str,
        maps: Maps,
        frames: Option<Vec<u32>>,
        shot: Option<Vec<u32>>,
    ) -> Result<Self> {
        let files = numbered(Path::new(pattern))?;
        let frames = frames.unwrap_or_else(|| files.keys().copied().collect());
        let shot = shot.unwrap_or_else(|| frames.clone());
        if let Some(missing) = shot.iter().chain(&frames).find(|n| !files.contains_key(n)) {
            let numbers = || files.keys().copied();
            let [first, last] = [numbers().min(), numbers().max()].map(Option::unwrap_or_default);
            let range = format!("frames that {pattern} has, from {first} to {last}");
            return Err(Error::setting("--frames", missing, range));
        }
        Ok(Self { pattern: pattern.into(), files, maps, shot, frames })
    }

    /// The frames to be made.
    pub fn frames(&self) -> &[u32] {
        &self.frames
    }

    fn given(&self, number: u32, run: &Run) -> Result<Given> {
        let map = |path: &Option<PathBuf>| {
            path.as_ref().map(|p| {
                let name = p.file_name().unwrap_or_default().to_string_lossy();
                p.with_file_name(with_number(&name, number))
            })
        };
        let maps = Maps {
            normals: map(&self.maps.normals),
            normals_y_down: self.maps.normals_y_down,
            depth: map(&self.maps.depth),
            discontinuity: map(&self.maps.discontinuity),
        };
        Given::open(&self.files[&number].display().to_string(), &maps, run)
    }

    /// At most a few frames of the shot, spread evenly.
    fn sampled(&self) -> Vec<u32> {
        let n = self.shot.len().min(SURVEY_FRAMES);
        (0..n).map(|i| self.shot[i * self.shot.len() / n]).collect()
    }

    /// One hash of all the shot's files.
    fn hash(&self) -> Result<String> {
        let mut hashes = String::new();
        for number in &self.shot {
            hashes += &write::sha256(&disk::read(&self.files[number])?);
        }
        Ok(write::sha256(hashes.as_bytes()))
    }
}

/// A job on numbered pictures.
pub struct Film<'a> {
    /// The pictures.
    pub sequence: &'a Sequence,
    /// What frames look like.
    pub look: Look<'a>,
    /// Where they go.
    pub target: Target,
    /// Frames a second, for animations in one file.
    pub fps: f64,
}

impl Film<'_> {
    /// Shades and writes every frame that is not there yet.
    pub fn run(&self, run: &Run) -> Result<Record> {
        let encoding = Encoding::of(&self.target)?;
        self.target.spares(&self.sequence.frames, self.sequence.files.values().cloned())?;
        let mut record = Record::new("binary");
        let knobs = &self.look.knobs.resolved();
        let survey = self.survey(knobs, run)?;
        let settings = self.settings(&survey, encoding)?;
        let recipe = |number| frame_recipe("binary", settings.clone(), number);
        let mut frames = Frames::new(&self.target, &recipe).in_parts(self.look.parts(encoding)?);
        let missing = frames.missing(self.sequence.frames.clone());
        let is_wanted: Vec<bool> = self.sequence.shot.iter().map(|n| missing.contains(n)).collect();
        let colours = &self.look.colours;
        let setting = Setting {
            knobs,
            exposure: &survey.exposure,
            colours,
            palette: Palette::parse(&knobs.palette, colours.ink, colours.paper)?,
        };
        let labelling = match Labelling::of(knobs) {
            Labelling::Windows if survey.moves => Labelling::Windows,
            Labelling::Windows => {
                run.warn(
                    "no motion vectors (in Blender the pass Vector): each frame is on its own",
                );
                Labelling::Alone
            }
            alone => alone,
        };
        let mut reader = Reader { film: self, survey: &survey, before: None };
        let mut deliver = |number: u32, picture: Picture| {
            let title = format!("{} {number}", self.file_name());
            let text = (title.as_str(), recipe(number));
            hand_over(&mut frames, (number, &picture), (encoding, &self.look), text, run)
        };
        let counts =
            reel::label(&mut reader, &setting, (&is_wanted, labelling), &mut deliver, run)?;
        frames.finish(self.fps, &mut record, run)?;
        record.settings = settings;
        record.counts.extend(counts);
        Ok(record)
    }

    fn survey(&self, knobs: &BinaryKnobs, run: &Run) -> Result<Survey> {
        let sampled = self.sequence.sampled();
        let (mut views, mut moves, mut size) = (Vec::new(), false, (0, 0));
        for number in &sampled {
            let layers = self.sequence.given(*number, run)?.layers;
            moves |= layers.motion.is_some();
            size = layers.size;
            views.push(surveyed(&layers, knobs));
        }
        let mut lesson = Lesson::default();
        if let Some(painting) = &self.look.painting {
            for number in painting.lessons(&self.sequence.shot, &sampled) {
                let view = surveyed(&self.sequence.given(number, run)?.layers, knobs);
                painting.teach(&mut lesson, &view, number);
            }
        }
        let exposure = expose(&views, true, knobs, run)?;
        Ok(Survey { exposure, lesson, moves, size })
    }

    fn settings(&self, survey: &Survey, encoding: Encoding) -> Result<Map<String, Value>> {
        let mut s = Map::new();
        s.insert("input".into(), self.file_name().into());
        s.insert("input_sha256".into(), self.sequence.hash()?.into());
        s.insert("size".into(), json!([survey.size.0, survey.size.1]));
        s.insert("shot".into(), json!(self.sequence.shot));
        let maps = &self.sequence.maps;
        let all = [
            ("normals", &maps.normals),
            ("depth", &maps.depth),
            ("discontinuity", &maps.discontinuity),
        ];
        for (name, map) in all {
            let file = map.as_ref().and_then(|m| m.file_name()).map(|n| n.to_string_lossy());
            s.insert(name.into(), json!(file));
        }
        s.insert("normals_y_down".into(), maps.normals_y_down.into());
        s.extend(self.look.settings(&survey.exposure, encoding));
        Ok(s)
    }

    fn file_name(&self) -> String {
        let name = Path::new(&self.sequence.pattern).file_name();
        name.unwrap_or_default().to_string_lossy().into_owned()
    }
}

/// What is decided once for a shot.
struct Survey {
    exposure: Exposure,
    lesson: Lesson,
    /// Whether the files hold motion vectors.
    moves: bool,
    size: (usize, usize),
}

/// Reads the files of a shot in order.
struct Reader<'a> {
    film: &'a Film<'a>,
    survey: &'a Survey,
    before: Option<(usize, Before)>,
}

/// What a frame's links need of the one before.
struct Before {
    covered: Plane<bool>,
    object: Plane<u32>,
    depth: Plane<f32>,
    forth: Option<Plane<[f32; 2]>>,
}

impl Source for Reader<'_> {
    fn take(&mut self, index: usize, setting: &Setting<'_>, run: &Run) -> Result<Take> {
        run.check()?;
        let sequence = self.film.sequence;
        let number = sequence.shot[index];
        let given = sequence.given(number, run)?;
        let (size, layers) = (given.layers.size, given.layers);
        if size != self.survey.size {
            let ((w, h), (u, v)) = (size, self.survey.size);
            let why = format!("is {w} x {h} pixels, but others of its film are {u} x {v}");
            return Err(Error::input(sequence.files[&number].display().to_string(), "", why));
        }
        let pixels = (size.0 * size.1) as u64;
        let view = run.stage("channels", pixels, || view(&layers, setting.knobs));
        let before = self.before.take().filter(|(i, _)| i + 1 == index);
        let links = run.stage("track", pixels, || match (&before, &layers.motion) {
            (Some((_, before)), Some(motion)) => links(motion, &view, before),
            _ => view.buffer.covered.map(|_| UNLINKED),
        });
        let painting = self.film.look.painting.as_ref();
        let paint = painting.map(|p| p.taught(&view, number, &self.survey.lesson));
        let seen = (&view, layers.lines);
        let take = setting.take(number, seen, [links.clone(), links], paint, run)?;
        let before = Before {
            covered: view.buffer.covered,
            object: view.buffer.object,
            depth: view.buffer.depth,
            forth: layers.motion.and_then(|m| m.forth),
        };
        self.before = Some((index, before));
        Ok(take)
    }
}

/// For each pixel the pixel of the frame before that shows the same point.
fn links(motion: &Motion, view: &View, before: &Before) -> Plane<u32> {
    let buffer = &view.buffer;
    let (w, h) = buffer.covered.size();
    let place = |x: usize, y: usize| {
        let [u, v] = motion.back[(x, y)];
        let (u, v) = (x as f32 + 0.5 + u, y as f32 + 0.5 + v);
        let inside = u >= 0.0 && v >= 0.0 && u < w as f32 && v < h as f32;
        let at = (inside && buffer.covered[(x, y)]).then_some((u as usize, v as usize))?;
        let same = before.covered[at] && before.object[at] == buffer.object[(x, y)];
        let returns = match &before.forth {
            Some(forth) => {
                let [s, t] = forth[at];
                let off = (at.0 as f32 + s - x as f32).hypot(at.1 as f32 + t - y as f32);
                off <= CLOSE
            }
            None => {
                let (here, there) = (buffer.depth[(x, y)], before.depth[at]);
                (here - there).abs() <= SAME_DEPTH * here.abs()
            }
        };
        (same && returns).then_some((at.1 * w + at.0) as u32)
    };
    Plane::from_fn(w, h, |x, y| place(x, y).unwrap_or(UNLINKED))
}
