//! Films side by side: figure 3.15, and the measures of flicker on three kinds of motion.

use super::Figure;
use crate::binary::reel::{Labelling, shoot};
use crate::binary::{Picture, Shot};
use crate::colours::Colours;
use crate::lighting::Lighting;
use crate::project::{Options, Project};
use chiaro_basis::{Result, Run};
use chiaro_binary::BinaryKnobs;
use chiaro_image::Plane;
use chiaro_image::sheet::Sheet;
use serde_json::{Map, Value};

pub(super) const FIGURES: [Figure; 1] = [Figure {
    name: "3.15",
    title: "animation",
    message: "Every other frame of a turning head and of a turning torus, each frame on its own and, \
              below, the film cut along the motion. Regions that turn edge-on are the thesis's failure \
              case: red is what a frame on its own has otherwise than the film.",
    columns: 6,
    draw: animation,
}];

/// Frames shown of each film.
const SHOWN: u32 = 6;

fn animation(sheet: &mut Sheet, run: &Run) -> Result<()> {
    for scene in ["demo:head", "demo:bumpy-torus"] {
        let turning = Sequence::turning(scene, 96, 2 * SHOWN);
        let [alone, film] =
            [Labelling::Alone, Labelling::Windows].map(|how| turning.film(how, run));
        let (alone, film) = (alone?.pictures, film?.pictures);
        for ((number, picture), (_, other)) in alone.iter().zip(&film).step_by(2) {
            let marked = picture.zip(other, |p, q| reddened(*p, *q))?;
            sheet.add(marked, format!("{} {number}, alone", short(scene)));
        }
        for (number, picture) in film.into_iter().step_by(2) {
            sheet.add(picture, format!("{} {number}, film", short(scene)));
        }
    }
    Ok(())
}

/// A pixel, red where another picture has it otherwise: dark where it is black, pale where white.
fn reddened([r, g, b]: [u8; 3], other: [u8; 3]) -> [u8; 3] {
    if r.abs_diff(other[0]) < 128 {
        return [r, g, b];
    }
    [160 + r / 3, 20 + g / 2, 20 + b / 2]
}

/// Width and height of the films.
const SIZE: (usize, usize) = (360, 360);

/// Frames that flicker is measured on, and of those shown.
const MEASURED: u32 = 32;
const STRIP: std::ops::Range<usize> = 10..16;

/// Flicker of each frame alone, of blur and threshold, and of the film cut along the motion, on
/// scenes that turn, that play, and whose light turns: consecutive frames, and the measures.
pub(super) fn flicker(sheet: &mut Sheet, scenes: &[String], run: &Run) -> Result<Vec<Value>> {
    let mut rows = Vec::new();
    for scene in scenes {
        for sequence in [
            Sequence::turning(scene, 120, MEASURED),
            Sequence::playing(scene, "playing", 0.0, MEASURED),
            Sequence::playing(scene, "moving light", 60.0, MEASURED),
        ] {
            let methods = [
                (Labelling::Alone, "alone"),
                (Labelling::Blurred, "blur and threshold"),
                (Labelling::Windows, "film"),
            ];
            let mut alone = None;
            for (labelling, method) in methods {
                let made = sequence.film(labelling, run)?;
                let number = |name: &str| made.measures[name].as_f64().unwrap_or(0.0);
                let reversals = number("reversals_per_pixel");
                let untrue = reversals - number("tone_reversals_per_pixel");
                let [all, untrue_alone] =
                    *alone.get_or_insert([reversals.max(1e-12), untrue.max(1e-12)]);
                let (ratio, untrue) = (reversals / all, untrue / untrue_alone);
                let caption = format!(
                    "{}, {}, {method}: reversals x {untrue:.2} (x {ratio:.2} with the tone's \
                     own), energy +{:.1} % over the frames' pictures (+{:.1} over their cuts), \
                     lag {:.2} px, pops {} px",
                    short(scene),
                    sequence.motion,
                    100.0 * number("coherence_excess"),
                    100.0 * number("energy_excess"),
                    number("lag_px"),
                    made.measures["pop_p99_px"],
                );
                for (i, (_, picture)) in made.pictures.into_iter().enumerate() {
                    if STRIP.contains(&i) {
                        let first = i == STRIP.start;
                        sheet.add(picture, if first { caption.clone() } else { String::new() });
                    }
                }
                let mut row = made.measures;
                row.insert("scene".into(), scene.clone().into());
                row.insert("motion".into(), sequence.motion.into());
                row.insert("method".into(), method.into());
                row.insert("reversals_against_alone".into(), ratio.into());
                row.insert("untrue_reversals_against_alone".into(), untrue.into());
                rows.push(Value::Object(row));
            }
        }
    }
    Ok(rows)
}

fn short(scene: &str) -> &str {
    scene.rsplit(['/', ':']).next().unwrap_or(scene)
}

/// A short film of a scene.
struct Sequence {
    motion: &'static str,
    scene: String,
    options: Options,
    /// Degrees a second that the light turns.
    light: f32,
}

/// What a labelling made of a sequence.
struct Made {
    pictures: Vec<(u32, Plane<[u8; 3]>)>,
    measures: Map<String, Value>,
}

impl Sequence {
    /// `count` frames of a camera that goes once round in `round` frames.
    fn turning(scene: &str, round: u32, count: u32) -> Self {
        let options = Options {
            shot: Some((1..=round).collect()),
            frames: Some((1..=count).collect()),
            size: Some(SIZE),
            turntable: true,
            ..Options::default()
        };
        Self { motion: "turning", scene: scene.into(), options, light: 0.0 }
    }

    /// The scene's own animation before a still camera, the light still or turning.
    fn playing(scene: &str, motion: &'static str, light: f32, count: u32) -> Self {
        let frames: Vec<u32> = (1..=count).collect();
        let options = Options {
            shot: Some(frames.clone()),
            frames: Some(frames),
            size: Some(SIZE),
            looped: true,
            ..Options::default()
        };
        Self { motion, scene: scene.into(), options, light }
    }

    fn film(&self, labelling: Labelling, run: &Run) -> Result<Made> {
        let project = Project::open(&self.scene, self.options.clone(), run)?;
        let mut shot = Shot::survey(&project, &BinaryKnobs::default(), run)?;
        if let (Lighting::Sun(sun), true) = (&shot.lighting, self.light != 0.0) {
            shot.lighting = Lighting::Turning(*sun, self.light);
        }
        let colours = Colours::default();
        let mut pictures = Vec::new();
        let mut deliver = |number: u32, picture: Picture| {
            pictures.push((number, picture.displayed(&colours)));
            Ok(())
        };
        let frames = project.frames();
        let measures = shoot(&shot, &colours, (&frames, labelling), &mut deliver, run)?;
        Ok(Made { pictures, measures })
    }
}
