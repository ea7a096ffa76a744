//! `chiaro lines`: from a project to strokes, one frame or a film.
//!
//! The lines of the whole shot are found and tracked first, since identities are decided over the
//! shot; then every frame that is not there yet is written.

mod document;
pub(crate) mod picture;
mod svg;

use crate::binary::Colours;
use crate::camera::Camera;
use crate::film::{self, Target};
use crate::project::Project;
use crate::record::Record;
use crate::write;
use chiaro_basis::{Error, Knobs, Result, Run};
use chiaro_image::codec;
use chiaro_ink::Sheet;
use chiaro_lines::{Film, LinesKnobs, Reel, View};
use chiaro_scene::Frame;
use serde_json::{Map, Value, json};

/// Frames on which the default view is framed, at most.
const FRAMING: usize = 5;

/// A lines job.
pub struct Job<'a> {
    /// The scene and its film.
    pub project: &'a Project,
    /// The knobs, `--set` applied.
    pub knobs: &'a LinesKnobs,
    /// Ink and background.
    pub colours: Colours,
    /// The paper that SVG files are drawn on.
    pub sheet: Sheet,
    /// The pen's width in millimetres, for SVG; `None`: the strokes' own.
    pub pen: Option<f64>,
    /// Where the lines go.
    pub target: Target,
}

/// What a file holds.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Encoding {
    Png,
    Svg,
    Json,
}

/// Where lines go: a JSON file may hold a whole film.
pub fn target(path: &std::path::Path, frames: usize) -> Result<Target> {
    let json = path.extension().is_some_and(|e| e.eq_ignore_ascii_case("json"));
    let target = Target::parse(path, if json { 1 } else { frames })?;
    Encoding::of(&target)?;
    Ok(target)
}

impl Encoding {
    fn of(target: &Target) -> Result<Self> {
        match target.extension().as_str() {
            "png" | "apng" => Ok(Self::Png),
            "svg" => Ok(Self::Svg),
            "json" => Ok(Self::Json),
            other => Err(Error::setting(
                "-o",
                format!(".{other}"),
                "a file name that ends in .png, .apng, .svg or .json",
            )),
        }
    }
}

/// A shot's camera and tracked lines.
pub struct Shot {
    /// The camera.
    pub camera: Camera,
    /// The frames of the shot.
    pub numbers: Vec<u32>,
    /// Their lines, in the same order.
    pub film: Film,
}

impl Shot {
    /// Finds and tracks the lines of a project's shot.
    pub fn track(project: &Project, camera: Camera, knobs: &LinesKnobs, run: &Run) -> Result<Self> {
        let numbers = project.shot();
        let poser = project.poser();
        let at = |i: usize| {
            let frame = poser.frame(project.time(numbers[i]), &project.playback);
            let view = View::new(camera.pose(&frame, numbers[i]), camera.size);
            (frame, view)
        };
        let reel = Reel { scene: &project.scene, count: numbers.len(), at: &at };
        let film = Film::of(&reel, knobs, run)?;
        for note in &film.notes {
            run.warn(note);
        }
        Ok(Self { camera, numbers, film })
    }
}

/// The camera of a shot.
pub fn camera(project: &Project, run: &Run) -> Result<Camera> {
    let poser = project.poser();
    let numbers = project.sampled_shot(FRAMING);
    let frames: Vec<Frame> = numbers.iter().map(|&n| project.pose(&poser, n, run)).collect();
    Camera::choose(project, &frames, run)
}

impl Job<'_> {
    /// Finds the lines and writes every frame that is not there yet.
    pub fn run(&self, run: &Run) -> Result<Record> {
        let encoding = Encoding::of(&self.target)?;
        let mut record = Record::new("lines");
        let camera = camera(self.project, run)?;
        record.settings = self.settings(&camera);
        let frames = self.project.frames();
        let there = |n: &u32| film::finished(&self.target.file(*n), &self.recipe(&camera, *n));
        if let Target::Pattern(_) = self.target {
            let done: Vec<_> = frames.iter().filter_map(there).collect();
            if done.len() == frames.len() {
                record.outputs = done;
                return Ok(record);
            }
        }
        let shot = Shot::track(self.project, camera, self.knobs, run)?;
        match (&self.target, encoding) {
            (Target::Pattern(_), _) => self.write_frames(&shot, encoding, &mut record, run)?,
            (Target::Single(path), Encoding::Json) => {
                let text = document::document(&shot, &frames);
                record.outputs.push(run.stage("write", 1, || write::whole(path, text.as_bytes()))?);
            }
            (Target::Single(path), _) => {
                let bytes = self.encode(&shot, frames[0], encoding, run)?;
                record.outputs.push(run.stage("write", 1, || write::whole(path, &bytes))?);
            }
            (Target::Animation(path), _) => {
                let draw = |n: &u32| picture::picture(&shot, *n, self.knobs, &self.colours);
                let pictures: Vec<_> =
                    run.stage("draw", frames.len() as u64, || frames.iter().map(draw).collect());
                let recipe = self.recipe(&shot.camera, frames[0]);
                let bytes = codec::write_apng(&pictures, self.project.options.fps, Some(&recipe))?;
                record.outputs.push(run.stage("write", 1, || write::whole(path, &bytes))?);
            }
        }
        count(&shot, &mut record);
        Ok(record)
    }

    fn write_frames(
        &self,
        shot: &Shot,
        encoding: Encoding,
        record: &mut Record,
        run: &Run,
    ) -> Result<()> {
        for number in self.project.frames() {
            run.check()?;
            let (file, recipe) = (self.target.file(number), self.recipe(&shot.camera, number));
            let output = match film::finished(&file, &recipe) {
                Some(output) => output,
                None => {
                    let bytes = self.encode(shot, number, encoding, run)?;
                    run.stage("write", 1, || film::write_frame(&file, &bytes, &recipe))?
                }
            };
            record.outputs.push(output);
        }
        Ok(())
    }

    fn encode(&self, shot: &Shot, number: u32, encoding: Encoding, run: &Run) -> Result<Vec<u8>> {
        let recipe = self.recipe(&shot.camera, number);
        run.stage("draw", 1, || match encoding {
            Encoding::Json => Ok(document::document(shot, &[number]).into_bytes()),
            Encoding::Svg => Ok(svg::svg(shot, number, self, recipe)?.into_bytes()),

            Encoding::Png => {
                let picture = picture::picture(shot, number, self.knobs, &self.colours);
                codec::write_png_rgba(&picture, Some(&recipe))
            }
        })
    }

    fn settings(&self, camera: &Camera) -> Map<String, Value> {
        let mut s = camera.settings(self.project);
        let colours = json!({ "ink": self.colours.ink, "background": self.colours.background });
        s.insert("colours".into(), colours);
        let (paper, turns, margin) = (self.sheet.paper, self.sheet.turns, self.sheet.margin);
        let sheet = json!({ "paper": paper, "turns": turns, "margin": margin, "pen": self.pen });
        s.insert("sheet".into(), sheet);
        for (knob, value) in self.knobs.values() {
            s.insert(knob.name.into(), crate::binary::json_of(&value));
        }
        s
    }

    /// Everything that changes a frame's lines, and nothing else.
    fn recipe(&self, camera: &Camera, frame: u32) -> String {
        let mut settings = self.settings(camera);
        settings.insert("frame".into(), frame.into());
        json!({
            "program": "chiaro", "version": env!("CARGO_PKG_VERSION"), "command": "lines",
            "settings": settings,
        })
        .to_string()
    }
}

/// The record's measures of a film.
fn count(shot: &Shot, record: &mut Record) {
    for (name, value) in chiaro_lines::measure(&shot.film).named() {
        record.count(name, value);
    }
}
