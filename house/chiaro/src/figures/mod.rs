//! `chiaro figures`: figures of the thesis, remade on our scenes as contact sheets.
//!
//! Each figure is rows of cells; all cells of a row share one view of a scene and differ in knobs.

mod chapter3;
mod plate;

use crate::page::{self, Section};
use crate::record::{Output, Record};
use crate::style::Style;
use crate::write;
use chiaro_basis::{Error, Result, Run, nearest};
use chiaro_image::codec;
use chiaro_image::sheet::Sheet;
use plate::Plate;
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
const FIGURES: [Figure; 6] = chapter3::FIGURES;

/// Makes the figures called `names`, or all, in `folder`, with a page that shows them.
pub fn figures(names: &[String], folder: &Path, run: &Run) -> Result<Record> {
    let mut record = Record::new("figures");
    let mut sections = Vec::new();
    for figure in chosen(names)? {
        run.check()?;
        let mut sheet =
            Sheet::new(figure.columns).title(format!("{} {}", figure.name, figure.title));
        (figure.draw)(&mut sheet, run)?;
        let file = format!("figure-{}.png", figure.name);
        record.outputs.push(write_sheet(&folder.join(&file), &sheet, run)?);
        sections.push(Section {
            title: format!("Figure {}: {}", figure.name, figure.title),
            text: figure.message.into(),
            pictures: vec![(file, figure.title.into())],
        });
    }
    let intro = "Figures of chapter 3 of Buchholz (2012), remade on scenes built in code.";
    let html = page::html("Figures", intro, &sections);
    record.outputs.push(write::whole(&folder.join("index.html"), html.as_bytes())?);
    Ok(record)
}

fn chosen(names: &[String]) -> Result<Vec<&'static Figure>> {
    if names.is_empty() {
        return Ok(FIGURES.iter().collect());
    }
    let find = |name: &String| {
        FIGURES.iter().find(|f| f.name == name).ok_or_else(|| {
            let known: Vec<&str> = FIGURES.iter().map(|f| f.name).collect();
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

/// Scenes that a style must suit: a face, a relief, a room, a small pattern.
const STYLE_SCENES: [&str; 4] = ["head", "rocks", "cornell-box", "golf-ball"];

/// Draws thumbnails of every style into one sheet.
pub fn style_sheet(path: &Path, run: &Run) -> Result<Record> {
    let mut record = Record::new("style");
    let mut sheet = Sheet::new(STYLE_SCENES.len()).title("styles").thumbnails(300, 300);
    for style in Style::all()? {
        for scene in STYLE_SCENES {
            let plate = Plate::of(scene, 480, &style.binary, run)?;
            sheet.add(plate.ink(&style.binary, run)?, format!("{}: {scene}", style.name));
        }
    }
    record.outputs.push(write_sheet(path, &sheet, run)?);
    Ok(record)
}
