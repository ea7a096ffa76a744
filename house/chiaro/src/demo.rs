//! `chiaro demo`: pictures from embedded scenes through every pipeline there is, a short film, and
//! a page that shows them.

use crate::binary::{Job, Look};
use crate::film::Target;
use crate::page::{self, Section};
use crate::project::{Options, Project};
use crate::record::Record;
use crate::style::Style;
use crate::write;
use crate::{light, lines};
use chiaro_basis::{Result, Run};
use chiaro_pbgi::LightKnobs;
use std::path::Path;

/// One still of the demo: scene, style, caption.
const STILLS: [(&str, &str, &str); 8] = [
    (
        "head",
        "ink",
        "A head in the default style: solid blacks, a fine pen, white lines in the black.",
    ),
    ("courtyard", "ink", "A courtyard: borders run along arches, balusters and flags."),
    ("desk", "etched", "A desk, etched: fine detail stays, paper stays white."),
    ("cactus", "ink", "A cactus with a hat: white lines part the spines from the shade."),
    ("bowl", "brush", "A bowl of fruit by brush: hollows filled, heavy lines, much white."),
    ("multipod", "gloss", "Gloss: dark lacquer with bright highlights."),
    ("golf-ball", "etched", "A golf ball, etched: shape from a few hundred dimples."),
    ("head", "noir", "Noir: one hard lamp, white lines in the dark."),
];

/// The film: scene, frames, caption.
const FILM: (&str, u32, &str) = (
    "multipod",
    24,
    "A walk that repeats, cut along the motion: regions move with what they lie on.",
);

/// Makes the demo in `folder`.
pub fn demo(folder: &Path, run: &Run) -> Result<Record> {
    let mut record = Record::new("demo");
    let mut pictures = Vec::new();
    for (scene, style, caption) in STILLS {
        let file = format!("{scene}-{style}.png");
        let options = Options { size: sized(scene), ..Options::default() };
        let outputs = draw(scene, style, options, &folder.join(&file), run)?;
        record.outputs.extend(outputs);
        pictures.push((file, caption.to_owned()));
    }
    let film = "film.apng".to_owned();
    let (scene, frames, caption) = FILM;
    let options = Options {
        size: Some((480, 360)),
        frames: Some((1..=frames).map(|f| 2 * f - 1).collect()),
        fps: 12.0,
        ..Options::default()
    };
    record.outputs.extend(draw(scene, "ink", options, &folder.join(&film), run)?);
    let lines = line_pictures(folder, &mut record, run)?;
    let lit = light_pictures(folder, &mut record, run)?;
    let sections = [
        Section {
            title: "Binary shading".into(),
            text: "Black and white from a minimal cut over the image: appearance pulls each pixel \
                   to black or white, geometry says where a border may run."
                .into(),
            pictures,
        },
        Section {
            title: "Animated lines".into(),
            text: "Silhouettes and sharp edges, found on one surface for all frames and followed \
                   through the film, drawn with brushes whose marks go with the line."
                .into(),
            pictures: lines,
        },
        Section {
            title: "Light".into(),
            text: "Direct light, shadows, and light that surfaces pass on to each other, gathered \
                   from points: no noise, and the same bytes every time."
                .into(),
            pictures: lit,
        },
        Section {
            title: "A short film".into(),
            text: "One exposure holds for the whole shot.".into(),
            pictures: vec![(film, caption.into())],
        },
    ];
    let intro = "Scenes built in code, drawn by this program. Every picture carries the recipe that made it.";
    let html = page::html("chiaro", intro, &sections);
    record.outputs.push(write::whole(&folder.join("index.html"), html.as_bytes())?);
    Ok(record)
}

/// A line drawing of the demo.
struct LineDrawing {
    scene: &'static str,
    style: &'static str,
    sets: &'static [&'static str],
    /// What is left out.
    without: &'static [&'static str],
    frames: u32,
    file: &'static str,
    caption: &'static str,
}

const LINES: [LineDrawing; 6] = [
    LineDrawing {
        scene: "cactus",
        style: "cactus",
        sets: &[],
        without: &["spines"],
        frames: 1,
        file: "cactus-lines.png",
        caption: "A cactus whose lines say what it is made of: thorns, hair, straw.",
    },
    LineDrawing {
        scene: "head",
        style: "pencil",
        sets: &["suggestive=yes"],
        without: &[],
        frames: 1,
        file: "head-lines.png",
        caption: "A head in pencil, with suggestive contours.",
    },
    LineDrawing {
        scene: "desk",
        style: "comic",
        sets: &[],
        without: &[],
        frames: 1,
        file: "desk-comic.png",
        caption: "Comic: lines over binary shading, near ones parting those behind.",
    },
    LineDrawing {
        scene: "bowl",
        style: "charcoal",
        sets: &[],
        without: &[],
        frames: 1,
        file: "bowl-lines.png",
        caption: "A bowl of fruit in charcoal.",
    },
    LineDrawing {
        scene: "multipod",
        style: "brush",
        sets: &[],
        without: &[],
        frames: 24,
        file: "strokes.apng",
        caption: "A walk by brush: what varies along a stroke goes with it.",
    },
    LineDrawing {
        scene: "bumpy-torus",
        style: "pen",
        sets: &["colour=id"],
        without: &[],
        frames: 24,
        file: "lines.apng",
        caption: "A turning torus: one colour a line.",
    },
];

/// Draws the line drawings: files with their captions.
fn line_pictures(folder: &Path, record: &mut Record, run: &Run) -> Result<Vec<(String, String)>> {
    let mut pictures = Vec::new();
    for drawing in &LINES {
        let count = drawing.frames;
        let options = Options {
            size: (count > 1).then_some((480, 360)),
            frames: Some((1..=count).collect()),
            fps: 12.0,
            without: drawing.without.iter().map(|w| (*w).to_owned()).collect(),
            ..Options::default()
        };
        let project = Project::open(&format!("demo:{}", drawing.scene), options, run)?;
        let style = Style::of_lines(drawing.style)?;
        let mut look = lines::Look::of(&style)?;
        drawing.sets.iter().try_for_each(|set| look.set(set))?;
        let target = Target::parse(&folder.join(drawing.file), count as usize)?;
        let job = lines::Job { project: &project, look, target, measure: false, check: false };
        record.outputs.extend(job.run(run)?.outputs);
        pictures.push((drawing.file.to_owned(), drawing.caption.to_owned()));
    }
    Ok(pictures)
}

/// Scenes under full light: scene, file, caption.
const LIGHT: [(&str, &str, &str); 2] = [
    ("bowl", "bowl-light.png", "A bowl of fruit in the sun: colours pass from fruit to fruit."),
    ("cornell-box", "box-light.png", "A box lit by its lamp alone, and by what the walls pass on."),
];

/// Lights the scenes: files with their captions.
fn light_pictures(folder: &Path, record: &mut Record, run: &Run) -> Result<Vec<(String, String)>> {
    let mut pictures = Vec::new();
    for (scene, file, caption) in LIGHT {
        let options = Options { size: Some((640, 480)), ..Options::default() };
        let project = Project::open(&format!("demo:{scene}"), options, run)?;
        let job = light::Job {
            project: &project,
            knobs: &LightKnobs::default(),
            method: light::Method::default(),
            env: None,
            check: light::Check::Nothing,
            bake: None,
            tree: None,
            book: None,
            memory: None,
            backdrop: None,
            target: Target::parse(&folder.join(file), 1)?,
        };
        record.outputs.extend(job.run(run)?.outputs);
        pictures.push((file.to_owned(), caption.to_owned()));
    }
    Ok(pictures)
}

/// The pixels of a still, where the default would take long.
fn sized(scene: &str) -> Option<(usize, usize)> {
    (scene == "courtyard").then_some((800, 600))
}

fn draw(
    scene: &str,
    style: &str,
    options: Options,
    path: &Path,
    run: &Run,
) -> Result<Vec<crate::record::Output>> {
    let style = Style::find(style)?;
    let project = Project::open(&format!("demo:{scene}"), options, run)?;
    let target = Target::parse(path, project.frames().len())?;
    let job = Job { project: &project, look: Look::of(&style), target, dump_graph: None };
    Ok(job.run(run)?.outputs)
}
