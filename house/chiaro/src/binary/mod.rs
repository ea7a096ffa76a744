//! `chiaro binary`: from a project to black and white, one picture or a film.
//!
//! 1. Once for the shot: the camera, the key light if the scene has none, and the exposure, found on
//!    a few small frames ([`Shot`]).
//! 2. A frame at a time: rays, channels, weights, cut, lines, and the file, written whole. Films are
//!    cut along the motion of what is seen.

pub(crate) mod counts;
mod dump;
mod indirect;
mod picture;
mod plates;
pub(crate) mod reel;
mod shot;
mod stencil;

use crate::colours::Colours;
use crate::film::Target;
use crate::frames::Frames;
use crate::painting::Painting;
use crate::project::Project;
use crate::record::{Record, frame_recipe, knob_settings};
use crate::style::Style;
use crate::vector::Print;
use chiaro_basis::{Result, Run};
use chiaro_binary::{BinaryKnobs, Exposure};
use chiaro_ink::Sheet;
use reel::Labelling;
use serde_json::{Map, Value};
use std::path::PathBuf;

pub use picture::Picture;
pub(crate) use picture::draw;
pub(crate) use plates::{Encoding, Plates, plate};
pub use shot::Shot;
pub(crate) use shot::{SURVEY_HEIGHT, exposure_settings};
pub use stencil::Cutting;

/// How a view becomes a picture, and a picture a sheet.
pub struct Look<'a> {
    /// The style.
    pub style: &'a Style,
    /// The knobs, `--set` applied.
    pub knobs: &'a BinaryKnobs,
    /// The colours.
    pub colours: Colours,
    /// How vectors and print sizes lie on paper.
    pub print: Print,
    /// Strokes, if any.
    pub painting: Option<Painting>,
    /// A stencil instead of the picture.
    pub stencil: Option<Cutting>,
}

impl<'a> Look<'a> {
    /// A style as it is.
    pub fn of(style: &'a Style) -> Self {
        let (colours, print) = (style.colours(), Print::default());
        Self { style, knobs: &style.binary, colours, print, painting: None, stencil: None }
    }

    /// For recipes, with the exposure that was found.
    pub(crate) fn settings(&self, exposure: &Exposure, encoding: Encoding) -> Map<String, Value> {
        let mut s = Map::new();
        s.insert("style".into(), self.style.name.clone().into());
        s.insert("colours".into(), self.colours.settings());
        s.insert("exposure".into(), exposure_settings(exposure));
        if let Some(painting) = &self.painting {
            s.insert("painting".into(), painting.settings());
        }
        if let Some(stencil) = &self.stencil {
            s.insert("stencil".into(), stencil.settings());
        }
        if encoding.uses_paper() || self.stencil.is_some() {
            s.insert("print".into(), self.print.settings());
        }
        s.extend(knob_settings(self.knobs));
        s
    }
}

/// A binary job.
pub struct Job<'a> {
    /// The scene and its film.
    pub project: &'a Project,
    /// What pictures look like.
    pub look: Look<'a>,
    /// Where the picture goes.
    pub target: Target,
    /// A folder for the graph, if wanted.
    pub dump_graph: Option<PathBuf>,
}

/// The paper that a picture without a size is to fill, if its file holds dots for a print.
///
/// # Errors
/// [`chiaro_basis::Error::Setting`] where a binary job cannot write such a file.
pub fn printed(target: &Target, print: &Print) -> Result<Option<Sheet>> {
    Ok(Encoding::of(target)?.fills(print))
}

impl Job<'_> {
    /// Renders and writes every frame that is not there yet.
    pub fn run(&self, run: &Run) -> Result<Record> {
        dump::check(self.dump_graph.as_deref())?;
        let encoding = Encoding::of(&self.target)?;
        self.target.spares(&self.project.frames(), self.project.files.iter().cloned())?;
        let mut record = Record::new("binary");
        let mut shot = Shot::survey(self.project, self.look.knobs, run)?;
        shot.paint(self.look.painting.clone(), run)?;
        let mut settings = shot.view_settings();
        settings.extend(self.look.settings(&shot.exposure, encoding));
        let recipe = |number| frame_recipe("binary", settings.clone(), number);
        let mut frames = Frames::new(&self.target, &recipe).in_parts(self.look.parts(encoding)?);
        let numbers = self.project.frames();
        // A graph is wanted even where the picture is there.
        let missing = if self.dump_graph.is_some() { numbers } else { frames.missing(numbers) };
        let mut deliver = |number: u32, picture: Picture| {
            self.deliver(&mut frames, (number, picture), (encoding, &recipe(number)), run)
        };
        let film = shoot(&shot, &self.look.colours, &missing, &mut deliver, run)?;
        frames.finish(self.project.options.fps, &mut record, run)?;
        record.settings = settings;
        record.counts.extend(film);
        Ok(record)
    }

    /// Hands a finished picture over to its file, and its graph to the folder of graphs.
    fn deliver(
        &self,
        frames: &mut Frames<'_>,
        (number, picture): (u32, Picture),
        (encoding, recipe): (Encoding, &str),
        run: &Run,
    ) -> Result<()> {
        if let Some(folder) = &self.dump_graph {
            let folder = dump::folder(folder, &self.target, number);
            let write = || dump::graph(&folder, &picture.graph, &picture.cut);
            frames.beside(number, run.stage("write", 1, write)?);
        }
        let title = format!("{} {number}", self.project.file_name());
        let text = (title.as_str(), recipe.to_owned());
        hand_over(frames, (number, &picture), (encoding, &self.look), text, run)
    }
}

/// Hands a finished picture over to its files, or to the animation that it is a part of. The `text`
/// is its title and its recipe.
pub(crate) fn hand_over(
    frames: &mut Frames<'_>,
    (number, picture): (u32, &Picture),
    (encoding, look): (Encoding, &Look<'_>),
    (title, recipe): (&str, String),
    run: &Run,
) -> Result<()> {
    let mut counts = picture.counts.clone();
    if frames.are_one_file() {
        let plates = Plates { look, title: "", recipe: "" };
        let shown = run.stage("draw", 1, || plates.shown(picture, &mut counts))?;
        frames.keep(number, shown);
    } else {
        let plates = Plates { look, title, recipe: &recipe };
        let files = run.stage("draw", 1, || plates.files(encoding, picture, &mut counts))?;
        frames.write_parts(number, &files, run)?;
    }
    frames.measured(number, counts);
    Ok(())
}

/// Makes the frames `numbers` of a shot one after the other; the measures of the film.
pub(crate) fn shoot(
    shot: &Shot<'_>,
    colours: &Colours,
    numbers: &[u32],
    deliver: &mut dyn FnMut(u32, Picture) -> Result<()>,
    run: &Run,
) -> Result<Map<String, Value>> {
    if shot.project.shot().len() > 1 {
        let labelling = Labelling::of(&shot.knobs);
        return reel::shoot(shot, colours, (numbers, labelling), deliver, run);
    }
    let poser = shot.project.poser();
    for &number in numbers {
        run.check()?;
        let frame = shot.project.pose(&poser, number, run);
        deliver(number, shot.picture(&frame, number, colours, run)?)?;
    }
    Ok(Map::new())
}
