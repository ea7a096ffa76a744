//! `chiaro lines`: from a project to strokes, one frame or a film.
//!
//! The lines of the whole shot are found and tracked first, since identities are decided over the
//! shot; then every frame that is not there yet is written.

mod document;
pub(crate) mod picture;
mod svg;

use crate::camera::Camera;
use crate::colours::Colours;
use crate::film::Target;
use crate::frames::Frames;
use crate::project::Project;
use crate::record::{Record, frame_recipe, knob_settings};
use crate::vector::Print;
use chiaro_basis::{Error, Result, Run};
use chiaro_image::codec;
use chiaro_lines::check::check;
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
    /// The paper that SVG files are drawn on, and the pen's width where it is not the strokes' own.
    pub print: Print,
    /// Where the lines go.
    pub target: Target,
    /// Whether the record needs the measures even of films that are there already.
    pub measure: bool,
    /// Whether visibility is compared with that on a surface sixteen times finer.
    pub check: bool,
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
        let film = with_reel(project, &camera, |reel| Film::of(reel, knobs, run))?;
        for note in &film.notes {
            run.warn(note);
        }
        Ok(Self { camera, numbers, film })
    }
}

/// Works on a project's shot as lines see it.
fn with_reel<T>(project: &Project, camera: &Camera, work: impl FnOnce(&Reel<'_>) -> T) -> T {
    let numbers = project.shot();
    let poser = project.poser();
    let at = |i: usize| {
        let frame = poser.frame(project.time(numbers[i]), &project.playback);
        let view = View::new(camera.pose(&frame, numbers[i]), camera.size);
        (frame, view)
    };
    work(&Reel { scene: &project.scene, count: numbers.len(), at: &at })
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
        let settings = self.settings(&camera);
        let recipe = |number| frame_recipe("lines", settings.clone(), number);
        let mut frames = Frames::new(&self.target, &recipe);
        let missing = frames.missing(self.project.frames());
        if self.check {
            let errors = with_reel(self.project, &camera, |reel| check(reel, self.knobs, run))?;
            record.counts.extend(counts(errors.named()));
        }
        if !missing.is_empty() || self.measure {
            let shot = Shot::track(self.project, camera, self.knobs, run)?;
            self.write(&shot, &missing, (encoding, &recipe), &mut frames, run)?;
            frames.measured(missing.first().copied().unwrap_or(0), measures(&shot));
        }
        frames.finish(self.project.options.fps, &mut record, run)?;
        record.settings = settings;
        Ok(record)
    }

    fn write(
        &self,
        shot: &Shot,
        numbers: &[u32],
        (encoding, recipe): (Encoding, &dyn Fn(u32) -> String),
        frames: &mut Frames<'_>,
        run: &Run,
    ) -> Result<()> {
        for page in self.pages(numbers, encoding) {
            run.check()?;
            let number = page[0];
            if frames.are_one_file() {
                let draw = || picture::picture(shot, number, self.knobs, &self.colours);
                frames.keep(number, run.stage("draw", 1, draw));
            } else {
                let encode = || self.encode(shot, page, encoding, &recipe(number));
                let bytes = run.stage("draw", page.len() as u64, encode)?;
                frames.write(number, &bytes, run)?;
            }
        }
        Ok(())
    }

    /// The frames by file: one each, but a single file of strokes holds a whole film.
    fn pages<'n>(&self, numbers: &'n [u32], encoding: Encoding) -> std::slice::Chunks<'n, u32> {
        match (&self.target, encoding) {
            (Target::Single(_), Encoding::Json) => numbers.chunks(numbers.len()),
            _ => numbers.chunks(1),
        }
    }

    /// The bytes of a file of some frames; only JSON holds more than one.
    fn encode(
        &self,
        shot: &Shot,
        page: &[u32],
        encoding: Encoding,
        recipe: &str,
    ) -> Result<Vec<u8>> {
        match encoding {
            Encoding::Json => Ok(document::document(shot, page).into_bytes()),
            Encoding::Svg => Ok(svg::svg(shot, page[0], self, recipe.to_owned())?.into_bytes()),
            Encoding::Png => {
                let picture = picture::picture(shot, page[0], self.knobs, &self.colours);
                codec::write_png_rgba(&picture, Some(recipe))
            }
        }
    }

    fn settings(&self, camera: &Camera) -> Map<String, Value> {
        let mut s = camera.settings(self.project);
        let colours = json!({ "ink": self.colours.ink, "background": self.colours.background });
        s.insert("colours".into(), colours);
        s.insert("print".into(), self.print.settings());
        s.extend(knob_settings(self.knobs));
        s
    }
}

/// The measures of a shot, for the record.
fn measures(shot: &Shot) -> Map<String, Value> {
    counts(chiaro_lines::measure(&shot.film).named())
}

fn counts(named: Vec<(&'static str, f64)>) -> Map<String, Value> {
    named.into_iter().map(|(name, value)| (name.to_owned(), value.into())).collect()
}
