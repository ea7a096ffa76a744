//! Pictures that others made, in: a colour image with maps of normals, depth and discontinuities
//! (RGBN, section 3.9), or the layers of an EXR file by any renderer.
//!
//! What the file does not bring is missing, never made up: without normals the geometry is that of
//! the depth, without either there are no features; occlusion and reflection are there only as
//! layers. For the camera see `camera`, for names of layers see `layers`.

mod camera;
mod layers;
mod view;

use crate::binary::{self, Colours, Encoding, Picture};
use crate::disk;
use crate::film::{self, Target};
use crate::painting::Painting;
use crate::plates::{Plates, uses_paper};
use crate::record::Record;
use crate::style::Style;
use crate::vector::Print;
use crate::write;
use chiaro_basis::{Error, Knobs, Result, Run};
use chiaro_binary::{BinaryKnobs, Exposure, expose, scaled};
use chiaro_image::codec::{Format, Limits, read_colour, read_components, read_exr};
use chiaro_image::{Plane, filter};
use layers::Layers;
use serde_json::{Map, Value, json};
use std::path::{Path, PathBuf};

/// Maps beside a colour image.
#[derive(Clone, Debug, Default)]
pub struct Maps {
    /// Normals: n = 2 c - 1, x right, z to the viewer.
    pub normals: Option<PathBuf>,
    /// Whether their y points down.
    pub normals_y_down: bool,
    /// Depth, growing with distance.
    pub depth: Option<PathBuf>,
    /// Dark, or bright on dark, where lines are drawn.
    pub discontinuity: Option<PathBuf>,
}

impl Maps {
    /// Whether any map is given.
    pub fn any(&self) -> bool {
        self.normals.is_some() || self.depth.is_some() || self.discontinuity.is_some()
    }
}

/// Whether `name` is a picture, not a scene: by its first bytes, or by its ending where there is no
/// such file.
pub fn is_picture(name: &str) -> bool {
    let path = Path::new(name);
    let mut start = [0u8; 8];
    let read = std::fs::File::open(path).and_then(|mut f| std::io::Read::read(&mut f, &mut start));
    match read {
        Ok(n) => Format::of(&start[..n]).is_some(),
        Err(_) => ["png", "jpg", "jpeg", "exr"].contains(&ending(path).as_str()),
    }
}

fn ending(path: &Path) -> String {
    path.extension().unwrap_or_default().to_string_lossy().to_ascii_lowercase()
}

/// A picture with its layers.
pub struct Given {
    name: String,
    hash: String,
    maps: Map<String, Value>,
    layers: Layers,
}

impl Given {
    /// Opens a picture and its maps.
    ///
    /// # Errors
    /// [`Error::Input`] for a file that is missing, damaged, of another size, or an EXR file without
    /// colours, normals and depth.
    pub fn open(name: &str, maps: &Maps, run: &Run) -> Result<Self> {
        let bytes = disk::read(Path::new(name))?;
        let mut given = Self {
            name: name.into(),
            hash: write::sha256(&bytes),
            maps: Map::new(),
            layers: run.stage("load", 1, || read_layers(name, &bytes))?,
        };
        if let Some(path) = &maps.normals {
            let picture = given.map("normals", path)?;
            given.layers.normal = Some(layers::decode_normals(&picture, !maps.normals_y_down));
            given.maps.insert("normals_y_down".into(), maps.normals_y_down.into());
        }
        if let Some(path) = &maps.depth {
            given.layers.depth = Some(given.map("depth", path)?.map(|p| p[0]));
        }
        if let Some(path) = &maps.discontinuity {
            let grey = given.map("discontinuity", path)?.map(|p| (p[0] + p[1] + p[2]) / 3.0);
            given.layers.lines = Some(discontinuities(&grey));
        }
        if given.layers.normal.is_none() && given.layers.depth.is_none() {
            run.warn(
                "no normals and no depth: borders follow the picture alone; give --normals or --depth",
            );
        }
        Ok(given)
    }

    /// A map of the picture's size; its hash goes into the recipe.
    fn map(&mut self, option: &str, path: &Path) -> Result<Plane<[f32; 4]>> {
        let name = path.display().to_string();
        let bytes = disk::read(path)?;
        let picture = if Format::of(&bytes) == Some(Format::Exr) {
            read_colour(&bytes, &name, &Limits::default())?
        } else {
            read_components(&bytes, &name, &Limits::default())?
        };
        if picture.size() != self.layers.size {
            let ((w, h), (u, v)) = (picture.size(), self.layers.size);
            let why =
                format!("is {w} x {h} pixels, but {} is {u} x {v}; scale it to that", self.name);
            return Err(Error::input(name, format!("--{option}"), why));
        }
        self.maps.insert(format!("{option}_sha256"), write::sha256(&bytes).into());
        Ok(picture)
    }

    fn file_name(&self) -> String {
        let name = Path::new(&self.name).file_name();
        name.map_or_else(|| self.name.clone(), |n| n.to_string_lossy().into_owned())
    }
}

fn read_layers(name: &str, bytes: &[u8]) -> Result<Layers> {
    if Format::of(bytes) == Some(Format::Exr) {
        let image = read_exr(bytes, name, &Limits::default())?;
        let layers = Layers::of_exr(&image);
        if layers.colour.is_none() && layers.normal.is_none() && layers.depth.is_none() {
            let why = "holds neither colours nor normals nor depth; in Blender choose OpenEXR \
                       MultiLayer and the passes Combined, Z and Normal";
            return Err(Error::input(name, "", why));
        }
        return Ok(layers);
    }
    let colour = read_colour(bytes, name, &Limits::default())?;
    Ok(Layers { size: colour.size(), colour: Some(colour), ..Layers::default() })
}

/// A map of discontinuities, median filtered, over half: dark lines on bright, or bright on dark,
/// whichever leaves less ink.
fn discontinuities(grey: &Plane<f32>) -> Plane<bool> {
    let everywhere = grey.map(|_| true);
    let bright = filter::median3(grey, &everywhere).map(|v| *v >= 0.5);
    let count = bright.pixels().iter().filter(|b| **b).count();
    let bright_lines = 2 * count < bright.len();
    bright.map(|b| *b == bright_lines)
}

/// A job on one picture.
pub struct Job<'a> {
    /// The picture.
    pub given: &'a Given,
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
    /// Where the picture goes.
    pub target: Target,
}

impl Job<'_> {
    /// Shades and writes the picture.
    pub fn run(&self, run: &Run) -> Result<Record> {
        let encoding = Encoding::of(&self.target)?;
        let mut record = Record::new("binary");
        let (picture, exposure) = self.picture(run)?;
        record.settings = self.settings(&exposure);
        let recipe = json!({
            "program": "chiaro", "version": env!("CARGO_PKG_VERSION"), "command": "binary",
            "settings": record.settings,
        })
        .to_string();
        let mut counts = picture.counts.clone();
        let plates = Plates {
            colours: &self.colours,
            knobs: self.knobs,
            print: &self.print,
            title: &self.given.file_name(),
            recipe: &recipe,
        };
        let file = self.target.file(1);
        let output = run.stage("write", 1, || {
            let bytes = plates.bytes(encoding, &picture, &mut counts)?;
            match self.target {
                Target::Pattern(_) => film::write_frame(&file, &bytes, &recipe),
                _ => write::whole(&file, &bytes),
            }
        })?;
        record.outputs.push(output);
        record.counts = counts;
        Ok(record)
    }

    fn picture(&self, run: &Run) -> Result<(Picture, Exposure)> {
        let layers = &self.given.layers;
        let pixels = (layers.size.0 * layers.size.1) as u64;
        let exposure = self.exposure(run)?;
        let view = run.stage("channels", pixels, || view::view(layers, self.knobs));
        let paint = self.painting.as_ref().map(|p| p.paint(&view, 1));
        let how = (&self.colours, paint.as_ref());
        let mut picture = binary::draw(&view, &exposure, self.knobs, how, run)?;
        if let Some(lines) = &layers.lines {
            picture.marks.draw_map(lines, 0.5 * scaled(self.knobs.smooth, layers.size.1));
        }
        Ok((picture, exposure))
    }

    /// The exposure, surveyed on every few pixels.
    fn exposure(&self, run: &Run) -> Result<Exposure> {
        let height = self.given.layers.size.1;
        let step = (height / binary::SURVEY_HEIGHT).max(1);
        let small = view::view(&self.given.layers.thinned(step), self.knobs);
        expose(&[small], true, self.knobs, run)
    }

    fn settings(&self, exposure: &Exposure) -> Map<String, Value> {
        let mut s = Map::new();
        s.insert("input".into(), self.given.file_name().into());
        s.insert("input_sha256".into(), self.given.hash.clone().into());
        s.insert("size".into(), json!([self.given.layers.size.0, self.given.layers.size.1]));
        s.insert("maps".into(), Value::Object(self.given.maps.clone()));
        s.insert("style".into(), self.style.name.clone().into());
        s.insert("colours".into(), self.colours.settings());
        s.insert("exposure".into(), binary::exposure_settings(exposure));
        if let Some(painting) = &self.painting {
            s.insert("painting".into(), painting.settings());
        }
        if uses_paper(&self.target) {
            s.insert("print".into(), self.print.settings());
        }
        for (knob, value) in self.knobs.values() {
            s.insert(knob.name.into(), binary::json_of(&value));
        }
        s
    }
}

#[cfg(test)]
mod tests;
