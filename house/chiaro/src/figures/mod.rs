//! `chiaro figures`: figures of the thesis, remade on our scenes as contact sheets.
//!
//! Each figure is rows of cells; all cells of a row share one view of a scene and differ in knobs.

mod books;
mod brushes;
mod chapter3;
mod chapter4;
mod chart;
mod comparisons;
mod diffusion;
mod films;
mod front;
mod lessons;
mod light;
mod measured;
mod methods;
mod overview;
mod painting;
mod plate;
mod quantized;
mod spacetime;
mod strokes;
mod swept;

use crate::page::{self, Section};
use crate::record::{Output, Record};
use crate::style::Style;
use crate::write;
use chiaro_basis::{Error, Result, Run, nearest};
use chiaro_image::codec;
use chiaro_image::sheet::Sheet;
use plate::Plate;
use serde_json::json;
use std::path::Path;

/// A figure: what it is called, what it shows, and how it is drawn.
struct Figure {
    name: &'static str,
    title: &'static str,
    message: &'static str,
    columns: usize,
    draw: fn(&mut Sheet, &Run) -> Result<()>,
}

/// The figures, in the thesis's order.
fn all() -> impl Iterator<Item = &'static Figure> {
    let chapter3 = (chapter3::FIGURES.iter().chain(&painting::FIGURES))
        .chain(comparisons::FIGURES.iter().chain(&films::FIGURES));
    let mut chapter3: Vec<&Figure> = chapter3.collect();
    let number = |f: &&Figure| f.name.strip_prefix("3.").and_then(|n| n.parse::<u32>().ok());
    chapter3.sort_by_key(|f| number(f).unwrap_or(u32::MAX));
    let chapter4 = chapter4::FIGURES
        .iter()
        .chain(&spacetime::FIGURES)
        .chain(&swept::FIGURES)
        .chain(&strokes::FIGURES);
    let lines =
        chapter3.into_iter().chain(chapter4).chain(&diffusion::FIGURES).chain(&brushes::FIGURES);
    lines.chain(&overview::FIGURES)
}

/// The figures that take scenes: every baseline beside ours, and the flicker of films.
const BASELINES: &str = "baselines";
const FLICKER: &str = "flicker";
/// All ways to parameterize lines.
const METHODS: &str = "methods";
/// All codes of lobes beside each other.
const RATE: &str = "6.rate";
/// Books of other scenes.
const BOOKS: &str = "6.books";
/// Films of strokes in several styles at once.
const STROKES: &str = "strokes";
/// Resident memory over time.
const MEMORY: &str = "6.6";
/// Indirect light: its rules left out in turn, and error over time.
const LIGHT: &str = "light";
const TAKING: [&str; 5] = [BASELINES, FLICKER, METHODS, STROKES, LIGHT];

/// Scenes that those are drawn on when none is named.
const BASELINE_SCENES: [&str; 3] = ["demo:head", "demo:bumpy-torus", "demo:rocks"];
const FLICKER_SCENES: [&str; 2] = ["demo:head", "demo:bumpy-torus"];
const STROKE_SCENES: [&str; 3] = ["demo:bumpy-torus", "demo:multipod", "demo:cactus"];

/// Makes the figures called `names`, or all of the thesis's and the baselines, in `folder`, with a
/// page that shows them. `scenes` are those of the figures that take some.
pub fn figures(names: &[String], scenes: &[String], folder: &Path, run: &Run) -> Result<Record> {
    let mut record = Record::new("figures");
    let mut sections = Vec::new();
    let (taking, plain): (Vec<&String>, Vec<&String>) =
        names.iter().partition(|n| TAKING.contains(&n.as_str()) || is_measured(n));
    let figures = match (names.is_empty(), scenes.is_empty()) {
        (true, true) => all().collect(),
        _ => chosen(&plain)?,
    };
    let named = |name: &str| taking.iter().any(|n| *n == name);
    let of_all = |name: &str| names.is_empty() && ![RATE, BOOKS].contains(&name);
    let measured = || quantized::all().filter(|f| named(f.name) || of_all(f.name));
    // What other figures gave back to the process would be taken unseen: this one comes first.
    let mut memory = measured()
        .find(|f| f.name == MEMORY)
        .map(|figure| measured_figure(figure, scenes, folder, &mut record, run))
        .transpose()?;
    for figure in figures {
        run.check()?;
        let title = format!("{}: {}", numbered(figure.name), figure.title);
        let mut sheet = Sheet::new(figure.columns).title(title.clone());
        (figure.draw)(&mut sheet, run)?;
        let file = format!("figure-{}.png", figure.name);
        record.outputs.push(write_sheet(&folder.join(&file), &sheet, run)?);
        sections.push(Section {
            title,
            text: figure.message.into(),
            pictures: vec![(file, figure.title.into())],
        });
    }
    for figure in measured() {
        run.check()?;
        sections.push(match (figure.name, memory.take()) {
            (MEMORY, Some(section)) => section,
            (_, kept) => {
                memory = kept;
                measured_figure(figure, scenes, folder, &mut record, run)?
            }
        });
    }
    if named(BASELINES) || names.is_empty() {
        sections.push(baselines(scenes, folder, &mut record, run)?);
    }
    if named(FLICKER) {
        sections.push(flicker(scenes, folder, &mut record, run)?);
    }
    if named(METHODS) {
        sections.push(methods(scenes, folder, &mut record, run)?);
    }
    if named(STROKES) {
        sections.push(stroke_films(scenes, folder, &mut record, run)?);
    }
    if named(LIGHT) {
        sections.push(lights(scenes, folder, &mut record, run)?);
    }
    let intro = "Figures of chapters 3 to 6 of Buchholz (2012), remade.";
    let html = page::html("Figures", intro, &sections);
    record.outputs.push(write::whole(&folder.join("index.html"), html.as_bytes())?);
    Ok(record)
}

fn some_or(scenes: &[String], defaults: &[&str]) -> Vec<String> {
    match scenes {
        [] => defaults.iter().map(|s| (*s).to_owned()).collect(),
        some => some.to_vec(),
    }
}

fn is_measured(name: &str) -> bool {
    quantized::all().any(|f| f.name == name)
}

/// What the thesis calls a figure or a table.
fn numbered(name: &str) -> String {
    match name.strip_prefix("table-") {
        Some(number) => format!("Table {number}"),
        None => format!("Figure {name}"),
    }
}

/// A figure that takes scenes, and its measures in the record.
fn measured_figure(
    figure: &quantized::Measured,
    scenes: &[String],
    folder: &Path,
    record: &mut Record,
    run: &Run,
) -> Result<Section> {
    let title = format!("{}: {}", numbered(figure.name), figure.title);
    let mut sheet = Sheet::new(figure.columns).title(title.clone());
    let rows = (figure.draw)(&some_or(scenes, figure.scenes), &mut sheet, run)?;
    let file = format!("figure-{}.png", figure.name);
    record.outputs.push(write_sheet(&folder.join(&file), &sheet, run)?);
    record.count(figure.name, rows);
    Ok(Section { title, text: figure.message.into(), pictures: vec![(file, figure.title.into())] })
}

/// The sheet of all methods, and their measures in the record.
fn baselines(scenes: &[String], folder: &Path, record: &mut Record, run: &Run) -> Result<Section> {
    let scenes = some_or(scenes, &BASELINE_SCENES);
    let mut sheet = Sheet::new(5).title("baselines").thumbnails(420, 420);
    let rows = comparisons::baselines(&mut sheet, &scenes, run)?;
    let file = "figure-baselines.png".to_owned();
    record.outputs.push(write_sheet(&folder.join(&file), &sheet, run)?);
    let text = |r: &comparisons::Row| {
        json!({
            "scene": r.scene, "method": r.method, "features_beyond_chance": r.share,
            "islands_under_30px": r.islands,
        })
    };
    record.count("baselines", rows.iter().map(text).collect::<Vec<_>>());
    Ok(Section {
        title: "Baselines".into(),
        text: "Eight other ways to two colours beside ours, with the share of the border on \
               features beyond chance, (s - c) / (1 - c), and the islands under 30 pixels."
            .into(),
        pictures: vec![(file, "baselines".into())],
    })
}

/// The sheet of consecutive frames by three methods, and their measures in the record.
fn flicker(scenes: &[String], folder: &Path, record: &mut Record, run: &Run) -> Result<Section> {
    let scenes = some_or(scenes, &FLICKER_SCENES);
    let mut sheet = Sheet::new(6).title("flicker");
    let rows = films::flicker(&mut sheet, &scenes, run)?;
    let file = "figure-flicker.png".to_owned();
    record.outputs.push(write_sheet(&folder.join(&file), &sheet, run)?);
    record.count("flicker", rows);
    Ok(Section {
        title: "Flicker".into(),
        text:
            "Consecutive frames of scenes that turn, that play, and whose light turns: each frame \
               by its own cut, the blurred weights thresholded, and the film cut along the motion."
                .into(),
        pictures: vec![(file, "flicker".into())],
    })
}

/// Slide over stretch of every way to parameterize lines, and the table in the record.
fn methods(scenes: &[String], folder: &Path, record: &mut Record, run: &Run) -> Result<Section> {
    let scenes = some_or(scenes, &methods::SCENES);
    let mut sheet = Sheet::new(2).title("methods");
    let rows = methods::methods(&mut sheet, &scenes, run)?;
    let file = "figure-methods.png".to_owned();
    record.outputs.push(write_sheet(&folder.join(&file), &sheet, run)?);
    record.count("methods", rows);
    Ok(Section {
        title: "Methods".into(),
        text:
            "Sliding (up, 95th percentile, logarithmic) and stretch (right) of textures. What is at \
               0.6 octaves stretches by more, or folds."
                .into(),
        pictures: vec![(file, "methods".into())],
    })
}

/// The rules of the gather and the curves of error over time, and their numbers in the record.
fn lights(scenes: &[String], folder: &Path, record: &mut Record, run: &Run) -> Result<Section> {
    let (mut pictures, mut rows) = (Vec::new(), Vec::new());
    let mut curves = Sheet::new(2).title("error over processor seconds");
    for scene in some_or(scenes, &light::SCENES) {
        run.check()?;
        let name = scene.rsplit(['/', ':']).next().unwrap_or(&scene).to_owned();
        let mut sheet = Sheet::new(4).title(format!("rules of the gather: {name}"));
        rows.extend(light::rules(&mut sheet, &scene, run)?);
        let file = format!("figure-light-{}.png", pictures.len() + 1);
        record.outputs.push(write_sheet(&folder.join(&file), &sheet, run)?);
        pictures.push((file, name));
        rows.extend(light::curves(&mut curves, &scene, run)?);
    }
    let file = "figure-light-curves.png".to_owned();
    record.outputs.push(write_sheet(&folder.join(&file), &curves, run)?);
    pictures.push((file, "error over processor seconds".into()));
    record.count("light", rows);
    Ok(Section {
        title: "Indirect light".into(),
        text: "Irradiance by one bounce against the path-traced truth: every rule of the gather, each \
               left out in turn; then error (up, 1 to 100 %) over processor seconds (right, 0.1 to \
               100), both logarithmic, of shared gathers and of plain path tracing."
            .into(),
        pictures,
    })
}

/// Films of strokes, one a scene.
fn stroke_films(
    scenes: &[String],
    folder: &Path,
    record: &mut Record,
    run: &Run,
) -> Result<Section> {
    let mut pictures = Vec::new();
    for film in brushes::films(&some_or(scenes, &STROKE_SCENES), run)? {
        record.outputs.push(write::whole(&folder.join(&film.file), &film.bytes)?);
        pictures.push((film.file, film.caption));
    }
    Ok(Section {
        title: "Films of strokes".into(),
        text:
            "The same frames in six styles at once, then dashes by the four ways to parameterize \
               lines: where u follows the surface, so do dashes, thorns, grain and pressure."
                .into(),
        pictures,
    })
}

fn chosen(names: &[&String]) -> Result<Vec<&'static Figure>> {
    let find = |name: &&String| {
        all().find(|f| f.name == name.as_str()).ok_or_else(|| {
            let measured = quantized::all().map(|f| f.name);
            let known: Vec<&str> = all().map(|f| f.name).chain(measured).chain(TAKING).collect();
            let hint = nearest(name, known.iter().copied());
            let hint = hint.map(|n| format!("; did you mean {n}?")).unwrap_or_default();
            Error::setting("figure", name, format!("one of {}{hint}", known.join(", ")))
        })
    };
    names.iter().map(find).collect()
}

fn write_sheet(path: &Path, sheet: &Sheet, run: &Run) -> Result<Output> {
    run.stage("write", 1, || write::whole(path, &codec::write_png_rgb(&sheet.draw(), None)?))
}

/// Scenes that a style must suit: a face, many small things, a creature, a small pattern.
const STYLE_SCENES: [&str; 4] = ["head", "desk", "multipod", "golf-ball"];

/// Draws thumbnails of every style into one sheet.
pub fn style_sheet(path: &Path, run: &Run) -> Result<Record> {
    let mut record = Record::new("style");
    let mut sheet = Sheet::new(STYLE_SCENES.len()).title("styles").thumbnails(300, 300);
    for style in Style::all()?.into_iter().filter(Style::has_regions) {
        for scene in STYLE_SCENES {
            let plate = Plate::of(scene, 480, &style.binary, run)?;
            sheet.add(plate.ink(&style.binary, run)?, format!("{}: {scene}", style.name));
        }
    }
    brushes::thumbnails(&mut sheet, &STYLE_SCENES, run)?;
    record.outputs.push(write_sheet(path, &sheet, run)?);
    Ok(record)
}
