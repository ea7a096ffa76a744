//! Pictures that others made, in: a colour image with maps of normals, depth and discontinuities
//! (RGBN, section 3.9), or the layers of an EXR file by any renderer.
//!
//! What the file does not bring is missing, never made up: without normals the geometry is that of
//! the depth, without either there are no features; occlusion and reflection are there only as
//! layers. For the camera see `camera`, for names of layers see `layers`.

mod backdrop;
mod camera;
mod film;
mod layers;
mod view;

use crate::binary::{self, Encoding, Look, Picture, hand_over};
use crate::disk;
use crate::film::Target;
use crate::frames::Frames;
use crate::record::{Record, recipe};
use crate::write;
use chiaro_basis::{Error, Result, Run};
use chiaro_binary::{BinaryKnobs, Exposure, View, expose};
use chiaro_image::codec::{Format, Limits, read_colour, read_components, read_exr};
use chiaro_image::{Plane, filter};
use layers::Layers;
use serde_json::{Map, Value, json};
use std::path::{Path, PathBuf};

pub use film::{Film, Sequence, is_sequence};

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

/// Whether `name` is a picture, not a scene: by its first bytes or its ending.
pub fn is_picture(name: &str) -> bool {
    let path = Path::new(name);
    let mut start = [0u8; 8];
    let read = std::fs::File::open(path).and_then(|mut f| std::io::Read::read(&mut f, &mut start));
    let is_named = || ["png", "jpg", "jpeg", "exr"].contains(&ending(path).as_str());
    read.is_ok_and(|n| Format::of(&start[..n]).is_some()) || is_named()
}

fn ending(path: &Path) -> String {
    path.extension().unwrap_or_default().to_string_lossy().to_ascii_lowercase()
}

/// A picture with its layers.
pub struct Given {
    name: String,
    /// All files that were read.
    files: Vec<PathBuf>,
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
            files: vec![name.into()],
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
        if Format::of(&bytes) != Some(Format::Exr) {
            given.leave_backdrop_out(run);
        }
        if given.layers.normal.is_none() && given.layers.depth.is_none() {
            run.warn(
                "no normals and no depth: borders follow the picture alone; give --normals or --depth",
            );
        }
        Ok(given)
    }

    /// Makes the plain backdrop of a photograph transparent.
    fn leave_backdrop_out(&mut self, run: &Run) {
        let normals = self.layers.normal.as_ref();
        let Some(colour) = &mut self.layers.colour else { return };
        if let Some(backdrop) = backdrop::backdrop(colour, normals) {
            *colour = colour
                .zip(&backdrop, |p, b| if *b { [0.0; 4] } else { *p })
                .expect("a backdrop has the picture's size");
            run.warn("a plain backdrop is left out; give the picture an alpha channel to say what counts");
        }
    }

    /// A map of the picture's size; its hash goes into the recipe.
    fn map(&mut self, option: &str, path: &Path) -> Result<Plane<[f32; 4]>> {
        let name = path.display().to_string();
        let bytes = disk::read(path)?;
        self.files.push(path.into());
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

/// A colour image with its normals and a map of discontinuities, as planes (RGBN, section 3.9), shaded.
/// `colour` is linear and multiplied by its alpha, `normal` has x right, y up, z to the viewer.
pub(crate) fn rgbn(
    colour: Plane<[f32; 4]>,
    normal: Plane<[f32; 3]>,
    discontinuity: &Plane<f32>,
    look: &Look<'_>,
    run: &Run,
) -> Result<Picture> {
    let layers = Layers {
        size: colour.size(),
        colour: Some(colour),
        normal: Some(normal),
        lines: Some(discontinuities(discontinuity)),
        ..Layers::default()
    };
    Ok(shaded(&layers, look, run)?.0)
}

/// Layers as a picture, and the exposure that was found.
fn shaded(layers: &Layers, look: &Look<'_>, run: &Run) -> Result<(Picture, Exposure)> {
    let pixels = (layers.size.0 * layers.size.1) as u64;
    let knobs = &look.knobs.resolved();
    let exposure = expose(&[surveyed(layers, knobs)], true, knobs, run)?;
    let view = run.stage("channels", pixels, || view::view(layers, knobs));
    let paint = look.painting.as_ref().map(|p| p.paint(&view, 1));
    let how = (&look.colours, paint.as_ref());
    let seen = (view, layers.lines.as_ref());
    Ok((binary::draw(seen, &exposure, knobs, how, run)?, exposure))
}

/// Every few pixels, for surveys.
fn surveyed(layers: &Layers, knobs: &BinaryKnobs) -> View {
    let step = (layers.size.1 / binary::SURVEY_HEIGHT).max(1);
    view::view(&layers.thinned(step), knobs)
}

/// A job on one picture.
pub struct Job<'a> {
    /// The picture.
    pub given: &'a Given,
    /// What the picture looks like.
    pub look: Look<'a>,
    /// Where the picture goes.
    pub target: Target,
}

impl Job<'_> {
    /// Shades and writes the picture.
    pub fn run(&self, run: &Run) -> Result<Record> {
        let encoding = Encoding::of(&self.target)?;
        self.target.spares(&[1], self.given.files.iter().cloned())?;
        let mut record = Record::new("binary");
        let (picture, exposure) = self.picture(run)?;
        let settings = self.settings(&exposure, encoding);
        let recipe = |_| recipe("binary", settings.clone());
        let mut frames = Frames::new(&self.target, &recipe).in_parts(self.look.parts(encoding)?);
        let title = self.given.file_name();
        let text = (title.as_str(), recipe(1));
        hand_over(&mut frames, (1, &picture), (encoding, &self.look), text, run)?;
        frames.finish(1.0, &mut record, run)?;
        record.settings = settings;
        Ok(record)
    }

    fn picture(&self, run: &Run) -> Result<(Picture, Exposure)> {
        shaded(&self.given.layers, &self.look, run)
    }

    fn settings(&self, exposure: &Exposure, encoding: Encoding) -> Map<String, Value> {
        let mut s = Map::new();
        s.insert("input".into(), self.given.file_name().into());
        s.insert("input_sha256".into(), self.given.hash.clone().into());
        s.insert("size".into(), json!([self.given.layers.size.0, self.given.layers.size.1]));
        s.insert("maps".into(), Value::Object(self.given.maps.clone()));
        s.extend(self.look.settings(exposure, encoding));
        s
    }
}

#[cfg(test)]
mod tests;
