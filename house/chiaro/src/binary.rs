//! `chiaro binary`: from a project to black and white, one picture or a film.
//!
//! 1. Once for the shot: the camera, the key light if the scene has none, and the exposure, found on
//!    a few small frames.
//! 2. A frame at a time: rays, channels, weights, cut, lines, and the file, written whole.

use crate::camera::Camera;
use crate::dump;
use crate::film::{self, Target};
use crate::lighting::Lighting;
use crate::project::Project;
use crate::record::{Output, Record};
use crate::style::Style;
use crate::vector::{self, Plate, Print};
use crate::write;
use chiaro_basis::{Knobs, Result, Run};
use chiaro_binary::{
    BinaryKnobs, Channel, Channels, Exposure, LEAST_REACH, Lit, Marks, REFERENCE_HEIGHT, Steps,
    View, compose, expose, one_bit, shade,
};
use chiaro_image::colour::to_byte;
use chiaro_image::labels::components;
use chiaro_image::{Plane, codec};
use chiaro_scene::Frame;
use chiaro_trace::{GBuffer, Surfaces};
use serde_json::{Map, Value, json};
use std::path::PathBuf;

/// Frames that a shot's exposure is surveyed on, at most, and their height in pixels.
const SURVEY_FRAMES: usize = 5;
const SURVEY_HEIGHT: usize = 240;

/// Colours of the picture, sRGB-encoded RGBA.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Colours {
    /// Black regions and lines.
    pub ink: [f32; 4],
    /// White regions and lines.
    pub paper: [f32; 4],
    /// Where there is no geometry; may be transparent.
    pub background: [f32; 4],
}

impl Default for Colours {
    fn default() -> Self {
        Self { ink: [0.0, 0.0, 0.0, 1.0], paper: [1.0; 4], background: [1.0; 4] }
    }
}

impl Colours {
    /// Whether what has no geometry is nearer to paper than to ink.
    fn paper_is_white(&self) -> bool {
        let lightness = |c: [f32; 4]| 0.299 * c[0] + 0.587 * c[1] + 0.114 * c[2];
        self.background[3] < 0.5
            || lightness(self.background) >= 0.5 * (lightness(self.ink) + lightness(self.paper))
    }

    fn are_grey(&self) -> bool {
        [self.ink, self.paper, self.background]
            .iter()
            .all(|c| c[0] == c[1] && c[1] == c[2] && c[3] == 1.0)
    }
}

/// What does not change over a shot.
pub struct Shot<'a> {
    project: &'a Project,
    knobs: BinaryKnobs,
    /// The camera.
    pub camera: Camera,
    /// The exposure.
    pub exposure: Exposure,
    lighting: Lighting,
    surfaces: Surfaces<'a>,
}

impl<'a> Shot<'a> {
    /// Decides what a shot shares.
    pub fn survey(project: &'a Project, knobs: &BinaryKnobs, run: &Run) -> Result<Self> {
        let poser = project.poser();
        let numbers = project.sampled_shot(SURVEY_FRAMES);
        let frames: Vec<Frame> = numbers.iter().map(|&n| project.pose(&poser, n, run)).collect();
        let camera = Camera::choose(project, &frames, run)?;
        let surfaces = Surfaces::new(&project.scene);
        let lighting =
            Lighting::choose(project, &surfaces, &camera, (&frames[0], numbers[0]), run)?;
        let mut shot = Self {
            project,
            knobs: knobs.clone(),
            camera,
            exposure: Exposure::default(),
            lighting,
            surfaces,
        };
        shot.exposure = shot.expose(&numbers, &frames, run)?;
        Ok(shot)
    }

    fn expose(&self, numbers: &[u32], frames: &[Frame], run: &Run) -> Result<Exposure> {
        let small = self.camera.at_height(SURVEY_HEIGHT);
        let views = |shadows: bool| -> Result<Vec<View>> {
            let pairs = numbers.iter().zip(frames);
            pairs.map(|(&n, f)| self.view(f, n, small.size, shadows, run)).collect()
        };
        let lit = views(true)?;
        let reach = lit.iter().map(|v| v.channels.reach).fold(0.0, f32::max);
        if reach >= LEAST_REACH {
            return expose(&lit, true, &self.knobs, run);
        }
        run.warn("hardly any light gets in: shadows are left out");
        expose(&views(false)?, false, &self.knobs, run)
    }

    /// The same shot in pictures `height` pixels high.
    pub fn at_height(mut self, height: usize) -> Self {
        self.camera = self.camera.at_height(height);
        self
    }

    /// One frame with every channel, for files that other programs read.
    pub fn everything(&self, frame: &Frame, number: u32, run: &Run) -> Result<View> {
        self.render(frame, number, self.camera.size, self.exposure.shadows, |_| true, run)
    }

    fn view(
        &self,
        frame: &Frame,
        number: u32,
        size: (usize, usize),
        shadows: bool,
        run: &Run,
    ) -> Result<View> {
        self.render(frame, number, size, shadows, |c| c.is_used(&self.knobs), run)
    }

    fn render(
        &self,
        frame: &Frame,
        number: u32,
        size: (usize, usize),
        shadows: bool,
        wanted: impl Fn(Channel) -> bool,
        run: &Run,
    ) -> Result<View> {
        let pixels = (size.0 * size.1) as u64;
        let pose = self.camera.pose(frame, number);
        let (tracer, buffer) = run.stage("trace", pixels, || {
            let tracer = self.project.tracer(frame);
            let buffer = GBuffer::trace(&tracer, &self.surfaces, &pose, size, run);
            (tracer, buffer)
        });
        let buffer = buffer?;
        let lamps = self.lighting.lamps(&tracer, &self.surfaces);
        let channels = run.stage("channels", pixels, || {
            let lit =
                Lit { tracer: &tracer, surfaces: &self.surfaces, buffer: &buffer, lamps: &lamps };
            Channels::render(&lit, wanted, &self.knobs, shadows, run)
        })?;
        Ok(View { buffer, channels })
    }

    /// What decides the view and the light, for recipes.
    pub fn view_settings(&self) -> Map<String, Value> {
        let mut s = self.camera.settings(self.project);
        s.insert("sun".into(), json!(self.project.options.sun));
        s
    }

    /// One frame of the shot, in full.
    pub fn picture(
        &self,
        frame: &Frame,
        number: u32,
        colours: &Colours,
        run: &Run,
    ) -> Result<Picture> {
        let size = self.camera.size;
        let view = self.view(frame, number, size, self.exposure.shadows, run)?;
        let steps = shade(&view, &self.exposure, &self.knobs, colours.paper_is_white(), run)?;
        let marks = run.stage("draw", (size.0 * size.1) as u64, || {
            compose(&steps.white, &view.buffer.covered, &steps.lines, &self.knobs)
        });
        Ok(Picture { view, steps, marks })
    }
}

/// A finished frame with everything on the way to it.
pub struct Picture {
    /// Geometry and appearance.
    pub view: View,
    /// Weights, cut, islands, lines.
    pub steps: Steps,
    /// Regions and lines, antialiased.
    pub marks: Marks,
}

/// A binary job.
pub struct Job<'a> {
    /// The scene and its film.
    pub project: &'a Project,
    /// The style.
    pub style: &'a Style,
    /// The knobs, `--set` applied.
    pub knobs: &'a BinaryKnobs,
    /// The colours.
    pub colours: Colours,
    /// How vectors and print sizes lie on paper.
    pub print: Print,
    /// Where the picture goes.
    pub target: Target,
    /// A folder for the graph, if wanted.
    pub dump_graph: Option<PathBuf>,
}

impl Job<'_> {
    /// Renders and writes every frame that is not there yet.
    pub fn run(&self, run: &Run) -> Result<Record> {
        let encode = Encoding::of(&self.target)?;
        dump::check(self.dump_graph.as_deref())?;
        let mut record = Record::new("binary");
        let mut counts = Vec::new();
        let mut pictures = Vec::new();
        let poser = self.project.poser();
        let shot = &Shot::survey(self.project, self.knobs, run)?;
        for number in self.project.frames() {
            run.check()?;
            let recipe = self.recipe(shot, number);
            let file = self.target.file(number);
            if let (Target::Pattern(_), None, Some(output)) =
                (&self.target, &self.dump_graph, film::finished(&file, &recipe))
            {
                record.outputs.push(output);
                continue;
            }
            let frame = self.project.pose(&poser, number, run);
            let picture = shot.picture(&frame, number, &self.colours, run)?;
            counts.push((number, measures(&picture)));
            let graph = run.stage("write", 1, || self.dump(number, &picture.steps))?;
            if let Target::Animation(_) = self.target {
                pictures.push(colour(&picture.marks, &self.colours));
                record.outputs.extend(graph);
                continue;
            }
            let output = run.stage("write", 1, || {
                let bytes = match encode {
                    Encoding::Svg => self.svg(&picture, number, &recipe, &mut counts)?,
                    _ => encode.encode(&picture, &self.colours, &recipe)?,
                };
                match self.target {
                    Target::Pattern(_) => film::write_frame(&file, &bytes, &recipe),
                    _ => write::whole(&file, &bytes),
                }
            })?;
            record.outputs.push(output);
            record.outputs.extend(graph);
        }
        if let Target::Animation(path) = &self.target {
            let recipe = self.recipe(shot, self.project.frames()[0]);
            let bytes = codec::write_apng(&pictures, self.project.options.fps, Some(&recipe))?;
            record.outputs.push(run.stage("write", 1, || write::whole(path, &bytes))?);
        }
        self.describe(&mut record, shot, counts);
        Ok(record)
    }

    fn dump(&self, number: u32, steps: &Steps) -> Result<Vec<Output>> {
        match &self.dump_graph {
            Some(folder) => dump::graph(&dump::folder(folder, &self.target, number), steps),
            None => Ok(Vec::new()),
        }
    }

    fn svg(
        &self,
        picture: &Picture,
        frame: u32,
        recipe: &str,
        counts: &mut [(u32, Value)],
    ) -> Result<Vec<u8>> {
        let plate = Plate {
            labels: &picture.steps.white.map(|w| u8::from(*w)),
            covered: &picture.view.buffer.covered,
            colours: &[self.colours.ink, self.colours.paper],
            lines: &picture.steps.lines,
            scheme: &self.colours,
        };
        let title = format!("{} {frame}", self.project.file_name());
        let (svg, travel) = vector::draw(&plate, self.knobs, &self.print, &title, recipe)?;
        if let Some((_, count)) = counts.last_mut() {
            count["pen_down_mm"] = json!(travel.down);
            count["pen_up_mm"] = json!(travel.up);
        }
        Ok(svg.into_bytes())
    }

    fn describe(&self, record: &mut Record, shot: &Shot<'_>, counts: Vec<(u32, Value)>) {
        record.settings = self.settings(shot);
        match counts.as_slice() {
            [(_, Value::Object(only))] => record.counts = only.clone(),
            _ => {
                let frames: Vec<Value> = counts.into_iter().map(|(_, c)| c).collect();
                record.count("frames", frames);
            }
        }
    }

    fn settings(&self, shot: &Shot<'_>) -> Map<String, Value> {
        let mut s = shot.view_settings();
        s.insert("style".into(), self.style.name.clone().into());
        s.insert(
            "colours".into(),
            json!({
                "ink": self.colours.ink, "paper": self.colours.paper,
                "background": self.colours.background,
            }),
        );
        s.insert(
            "exposure".into(),
            json!({
                "low": shot.exposure.low, "high": shot.exposure.high,
                "threshold": shot.exposure.threshold, "contrast": shot.exposure.contrast,
                "shadows": shot.exposure.shadows,
            }),
        );
        if self.target.extension() == "svg" {
            s.insert("print".into(), self.print.settings());
        }
        for (knob, value) in self.knobs.values() {
            s.insert(knob.name.into(), json_of(&value));
        }
        s
    }

    /// The recipe of a frame: everything that changes its pixels, and nothing else.
    fn recipe(&self, shot: &Shot<'_>, frame: u32) -> String {
        let mut settings = self.settings(shot);
        settings.insert("frame".into(), frame.into());
        json!({
            "program": "chiaro", "version": env!("CARGO_PKG_VERSION"), "command": "binary",
            "settings": settings,
        })
        .to_string()
    }
}

pub(crate) fn json_of(value: &chiaro_basis::Value) -> Value {
    match value {
        chiaro_basis::Value::Number(x) => json!(x),
        chiaro_basis::Value::Count(n) => json!(n),
        chiaro_basis::Value::Switch(b) => json!(b),
        chiaro_basis::Value::Word(w) => json!(w),
    }
}

/// Whether a binary job can write such a file.
pub fn check_target(target: &Target) -> Result<()> {
    Encoding::of(target).map(drop)
}

/// How a frame becomes bytes.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Encoding {
    Png,
    Pbm,
    Svg,
}

impl Encoding {
    fn of(target: &Target) -> Result<Self> {
        match target.extension().as_str() {
            "png" | "apng" => Ok(Self::Png),
            "pbm" => Ok(Self::Pbm),
            "svg" => Ok(Self::Svg),
            other => Err(chiaro_basis::Error::setting(
                "-o",
                format!(".{other}"),
                "a file name that ends in .png, .apng, .pbm or .svg",
            )),
        }
    }

    fn encode(self, picture: &Picture, colours: &Colours, recipe: &str) -> Result<Vec<u8>> {
        match self {
            Self::Pbm => Ok(codec::write_pbm(&one_bit(&picture.marks, colours.paper_is_white()))),
            Self::Svg => unreachable!("vectors are drawn, not encoded"),
            Self::Png if colours.are_grey() => {
                let grey = colour(&picture.marks, colours).map(|p| p[0]);
                codec::write_png_grey(&grey, Some(recipe))
            }
            Self::Png => codec::write_png_rgba(&colour(&picture.marks, colours), Some(recipe)),
        }
    }
}

/// Ink and paper over the background, sRGB-encoded bytes. Shares are mixed as displayed: ink has no
/// light of its own, and lines keep their optical width.
fn colour(marks: &Marks, colours: &Colours) -> Plane<[u8; 4]> {
    let mix = |a: f32, b: f32, t: f32| a + (b - a) * t;
    marks
        .white
        .zip(&marks.opacity, |&w, &o| {
            let over: [f32; 4] = std::array::from_fn(|i| mix(colours.ink[i], colours.paper[i], w));
            let alpha = mix(colours.background[3], over[3], o);
            let channel = |i: usize| {
                let back = colours.background[i] * colours.background[3] * (1.0 - o);
                (back + over[i] * over[3] * o) / alpha.max(1e-6)
            };
            [to_byte(channel(0)), to_byte(channel(1)), to_byte(channel(2)), to_byte(alpha)]
        })
        .expect("both have the picture's size")
}

/// The measures of a picture for the record.
pub fn measures(picture: &Picture) -> Value {
    let steps = &picture.steps;
    let covered = &picture.view.buffer.covered;
    let height = covered.height() as f32;
    let pixels = covered.len();
    let nodes = covered.pixels().iter().filter(|c| **c).count();
    let white = steps.white.pixels().iter().filter(|w| **w).count();
    let pieces = components(&steps.white, covered);
    let small = 30.0 * (height / REFERENCE_HEIGHT).powi(2);
    let islands =
        pieces.pieces.iter().filter(|p| p.touches_other && (p.area as f32) < small).count();
    json!({
        "pixels": pixels,
        "nodes": nodes,
        "flow": steps.labels.flow,
        "cut": steps.labels.cut,
        "capacity_units": steps.graph.scale,
        "white_fraction": if nodes == 0 { 0.0 } else { white as f64 / nodes as f64 },
        "components": pieces.pieces.len(),
        "islands_under_30px": islands,
        "island_energy": steps.island_energy,
        "boundary_px": steps.border.pairs,
        "feature_share": steps.border.on_features,
        "feature_share_by_chance": steps.border.by_chance,
    })
}
