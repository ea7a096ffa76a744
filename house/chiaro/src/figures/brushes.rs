//! Lines with style: figures 2.3 and 4.10 to 4.12, every style on every kind of shape, a
//! skinned character in three styles.

use super::Figure;
use crate::binary;
use crate::lines::beneath::Beneath;
use crate::lines::{Look, Over, Shot, camera, picture};
use crate::project::{Options, Project};
use crate::style::Style;
use chiaro_basis::{Result, Run};
use chiaro_image::Plane;
use chiaro_image::sheet::Sheet;
use chiaro_ink::brush::Texture;
use chiaro_lines::Method;

const SIZE: (usize, usize) = (560, 420);

pub(super) const FIGURES: [Figure; 7] = [
    Figure {
        name: "2.3",
        title: "expressive lines",
        message: "The same cactus with even lines; with brushes that say what things are made of: \
                  thorny skin, a hairy moustache, a straw hat; and those lines over binary shading.",
        columns: 3,
        draw: expressive,
    },
    Figure {
        name: "4.textures",
        title: "a picture of a stroke, and a pattern",
        message: "One line set, four frames. Above, one picture of a brush stroke laid along each \
                  line once, its ends unstretched; below, a pattern of even length, repeated.",
        columns: 4,
        draw: stretched_and_repeated,
    },
    Figure {
        name: "4.10",
        title: "a desk",
        message: "Four frames of a desk, in pencil and with a brush.",
        columns: 4,
        draw: desk,
    },
    Figure {
        name: "4.11",
        title: "a bowl with several objects",
        message: "Four frames of a bowl of fruit, in charcoal and in diluted ink.",
        columns: 4,
        draw: bowl,
    },
    Figure {
        name: "4.12",
        title: "the cactus",
        message: "Four frames of the cactus: lines alone, and lines over binary shading.",
        columns: 4,
        draw: cactus,
    },
    Figure {
        name: "4.character",
        title: "a skinned character in three styles",
        message: "The same four frames of a walk each time: what is drawn keeps its place on the legs.",
        columns: 4,
        draw: character,
    },
    Figure {
        name: "4.styles",
        title: "every style of lines",
        message: "The styles that chiaro style list shows, on a smooth shape, a face, small things \
                  and a creature.",
        columns: 4,
        draw: styles,
    },
];

/// A shot of a demo scene, and what draws it.
pub(super) struct Scene {
    project: Project,
}

impl Scene {
    pub(super) fn open(
        name: &str,
        frames: &[u32],
        without: &[&str],
        size: (usize, usize),
        run: &Run,
    ) -> Result<Self> {
        let options = Options {
            size: Some(size),
            frames: Some(frames.to_vec()),
            shot: Some((frames[0]..=frames[frames.len() - 1]).collect()),
            without: without.iter().map(|w| (*w).to_owned()).collect(),
            ..Options::default()
        };
        Ok(Self { project: Project::open(name, options, run)? })
    }

    /// Every frame by a look.
    pub(super) fn drawn(&self, look: &Look<'_>, run: &Run) -> Result<Vec<Plane<[u8; 3]>>> {
        let shot = Shot::track(&self.project, camera(&self.project, run)?, &look.lines.knobs, run)?;
        let numbers = self.project.frames();
        let finish = |number, beneath| {
            let drawn = picture::picture(&shot, number, &look.lines, &look.colours, beneath);
            drawn.map(|[r, g, b, _]| [*r, *g, *b])
        };
        if look.over == Over::Nothing {
            return Ok(numbers.iter().map(|n| finish(*n, None)).collect());
        }
        let mut pictures = Vec::new();
        let regions = binary::Shot::survey(&self.project, &look.binary, run)?;
        let deliver = &mut |number, picture: binary::Picture| {
            let beneath = Beneath::of(&picture.coloured(&look.colours));
            pictures.push(finish(number, Some(beneath)));
            Ok(())
        };
        binary::shoot(&regions, &look.colours, &numbers, deliver, run)?;
        Ok(pictures)
    }
}

/// A named style, with some knobs set.
pub(super) fn look<'a>(style: &'a Style, sets: &[&str]) -> Result<Look<'a>> {
    let mut look = Look::of(style)?;
    sets.iter().try_for_each(|set| look.set(set))?;
    Ok(look)
}

/// Adds the frames of a scene in a style.
fn row(sheet: &mut Sheet, scene: &Scene, (name, sets): (&str, &[&str]), run: &Run) -> Result<()> {
    let style = Style::of_lines(name)?;
    let frames = scene.project.frames();
    for (picture, number) in scene.drawn(&look(&style, sets)?, run)?.into_iter().zip(frames) {
        sheet.add(picture, format!("{name}, frame {number}"));
    }
    Ok(())
}

fn expressive(sheet: &mut Sheet, run: &Run) -> Result<()> {
    let scene = Scene::open("demo:cactus", &[1], &["spines"], (560, 640), run)?;
    let plain = Style::of_lines("pen")?;
    let even = look(&plain, &["pressure=0", "shade=0", "taper=0", "width=2"])?;
    let style = Style::of_lines("cactus")?;
    let brushes = Look::of(&style)?;
    let comic = Style::of_lines("comic")?;
    let together =
        Look { over: Over::Binary, binary: comic.binary.clone(), ..look(&style, &["rim=2.5"])? };
    let captions = ["even lines", "brushes that say what it is made of", "over binary shading"];
    for (look, caption) in [even, brushes, together].iter().zip(captions) {
        for picture in scene.drawn(look, run)? {
            sheet.add(picture, caption);
        }
    }
    Ok(())
}

/// A brush stroke, 512 x 64: loaded at its start, split and dry at its end.
fn stroke_picture() -> Texture {
    let picture = Plane::from_fn(512, 64, |x, y| {
        let (s, v) = (x as f32 / 511.0, (y as f32 - 31.5) / 32.0);
        let end = (1.0 - s).powf(0.6);
        let body = (s / 0.05).min(1.0).sqrt() * (0.3 + 0.75 * end).min(0.95);
        let streak = (11.0 * v + 1.5 * (2.0 * v + 4.0 * s).sin()).sin();
        let dry = (s - 0.4).max(0.0) * 2.6;
        let inside = ((body - v.abs()) * 12.0).clamp(0.0, 1.0);
        let ink = inside * (1.6 - dry * (1.0 + 1.6 * streak)).clamp(0.0, 1.0);
        [0, 0, 0, (255.0 * ink) as u8]
    });
    Texture::of(&picture)
}

fn stretched_and_repeated(sheet: &mut Sheet, run: &Run) -> Result<()> {
    let scene = Scene::open("demo:bumpy-torus", &[1, 9, 17, 25], &[], SIZE, run)?;
    let style = Style::of_lines("pen")?;
    let once = [
        "texture=stretched",
        "grain=stretch",
        "picture=stroke",
        "width=13",
        "taper=0",
        "pressure=0",
        "shade=0",
    ];
    let mut stretched = look(&style, &once)?;
    stretched.lines.add_texture("stroke", stroke_picture());
    let dashes = Style::of_lines("dashes")?;
    let repeated = look(&dashes, &["width=4", "spacing=24"])?;
    for (look, caption) in [(stretched, "stretched"), (repeated, "repeated")] {
        let frames = scene.project.frames();
        for (picture, number) in scene.drawn(&look, run)?.into_iter().zip(frames) {
            sheet.add(picture, format!("{caption}, frame {number}"));
        }
    }
    Ok(())
}

fn desk(sheet: &mut Sheet, run: &Run) -> Result<()> {
    let scene = Scene::open("demo:desk", &[1, 9, 17, 25], &[], SIZE, run)?;
    row(sheet, &scene, ("pencil", &[]), run)?;
    row(sheet, &scene, ("brush", &["width=6"]), run)
}

fn bowl(sheet: &mut Sheet, run: &Run) -> Result<()> {
    let scene = Scene::open("demo:bowl", &[1, 7, 13, 19], &[], SIZE, run)?;
    row(sheet, &scene, ("charcoal", &[]), run)?;
    row(sheet, &scene, ("wash", &[]), run)
}

fn cactus(sheet: &mut Sheet, run: &Run) -> Result<()> {
    let scene = Scene::open("demo:cactus", &[1, 9, 17, 25], &["spines"], (480, 560), run)?;
    row(sheet, &scene, ("cactus", &[]), run)?;
    let scene = Scene::open("demo:cactus", &[1, 9, 17, 25], &[], (480, 560), run)?;
    row(sheet, &scene, ("comic", &[]), run)
}

fn character(sheet: &mut Sheet, run: &Run) -> Result<()> {
    let scene = Scene::open("demo:multipod", &[1, 7, 13, 19], &[], SIZE, run)?;
    for name in ["brush", "fur", "dots"] {
        row(sheet, &scene, (name, &[]), run)?;
    }
    Ok(())
}

fn styles(sheet: &mut Sheet, run: &Run) -> Result<()> {
    for style in Style::all()?.into_iter().filter(Style::has_lines) {
        for name in ["bumpy-torus", "head", "desk", "multipod"] {
            let scene = Scene::open(&format!("demo:{name}"), &[1], &[], (400, 320), run)?;
            for picture in scene.drawn(&Look::of(&style)?, run)? {
                sheet.add(picture, format!("{}: {name}", style.name));
            }
        }
    }
    Ok(())
}

/// Thumbnails of the styles of lines, for the sheet of all styles.
pub(super) fn thumbnails(sheet: &mut Sheet, scenes: &[&str], run: &Run) -> Result<()> {
    for style in Style::all()?.into_iter().filter(Style::has_lines) {
        for name in scenes {
            let scene = Scene::open(&format!("demo:{name}"), &[1], &[], (480, 480), run)?;
            for picture in scene.drawn(&Look::of(&style)?, run)? {
                sheet.add(picture, format!("lines {}: {name}", style.name));
            }
        }
    }
    Ok(())
}

/// A film with its methods or styles side by side: file, caption, bytes.
pub(super) struct SideBySide {
    pub(super) file: String,
    pub(super) caption: String,
    pub(super) bytes: Vec<u8>,
}

/// A style, and knobs set on top.
type Way<'a> = (&'a str, Vec<&'a str>);

/// Films of strokes: the same frames in several styles at once, and by all methods at once.
pub(super) fn films(scenes: &[String], run: &Run) -> Result<Vec<SideBySide>> {
    let frames: Vec<u32> = (1..=24).collect();
    let mut films = Vec::new();
    for name in scenes {
        let scene = Scene::open(name, &frames, &[], (360, 270), run)?;
        let short = scene.project.file_name().replace("demo:", "");
        let stem = short.split('.').next().unwrap_or("film");
        let methods: Vec<String> = Method::WORDS.iter().map(|m| format!("method={m}")).collect();
        let ways: [(&str, Vec<Way<'_>>); 2] = [
            ("styles", FILM_STYLES.map(|style| (style, Vec::new())).to_vec()),
            ("methods", methods.iter().map(|m| ("dashes", vec![m.as_str(), "width=4"])).collect()),
        ];
        for (what, ways) in ways {
            let mut columns = Vec::new();
            for (style, sets) in &ways {
                run.check()?;
                let found = Style::of_lines(style)?;
                let caption = sets.first().map_or(*style, |s| s.trim_start_matches("method="));
                columns.push((caption, scene.drawn(&look(&found, sets)?, run)?));
            }
            let captions: Vec<&str> = columns.iter().map(|c| c.0).collect();
            films.push(SideBySide {
                file: format!("strokes-{stem}-{what}.png"),
                caption: format!("{short}: {}", captions.join(", ")),
                bytes: together(&columns, if what == "styles" { 3 } else { 2 })?,
            });
        }
    }
    Ok(films)
}

/// Styles that films show side by side.
const FILM_STYLES: [&str; 6] = ["pen", "brush", "charcoal", "dashes", "thorns", "double"];

/// Columns of frames with their captions as one animation.
fn together(columns: &[(&str, Vec<Plane<[u8; 3]>>)], across: usize) -> Result<Vec<u8>> {
    let count = columns.iter().map(|(_, c)| c.len()).min().unwrap_or(0);
    let frame = |i: usize| {
        let mut sheet = Sheet::new(across);
        for (caption, frames) in columns {
            sheet.add(frames[i].clone(), *caption);
        }
        sheet.draw().map(|[r, g, b]| [*r, *g, *b, 255])
    };
    let frames: Vec<Plane<[u8; 4]>> = (0..count).map(frame).collect();
    chiaro_image::codec::write_apng(&frames, 24.0, None)
}
