//! `chiaro binary`: from a project to black and white, one picture or a film.
//!
//! 1. Once for the shot: the camera, the key light if the scene has none, and the exposure, found on
//!    a few small frames.
//! 2. A frame at a time: rays, channels, weights, cut, lines, and the file, written whole.

use crate::camera::Camera;
use crate::dump;
use crate::film::{self, Target};
use crate::lighting::Lighting;
use crate::painting::Painting;
use crate::plates::{Plates, uses_paper};
use crate::project::Project;
use crate::record::{Output, Record};
use crate::reel::{self, Labelling};
use crate::style::Style;
use crate::vector::Print;
use crate::write;
use chiaro_basis::{Knobs, Result, Run};
use chiaro_binary::{
    BinaryKnobs, Border, Channel, Channels, Coloured, Exposure, Features, Graph, LEAST_REACH,
    Labels, Lines, Lit, Marks, Paint, Palette, REFERENCE_HEIGHT, Steps, View, colour_regions,
    compose, expose, is_light, one_bit, outline, shade_painted, tint,
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
pub(crate) const SURVEY_HEIGHT: usize = 240;

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
    /// For recipes.
    pub(crate) fn settings(&self) -> Value {
        json!({ "ink": self.ink, "paper": self.paper, "background": self.background })
    }

    /// Whether what has no geometry is nearer to paper than to ink.
    pub(crate) fn paper_is_white(&self) -> bool {
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
    pub(crate) project: &'a Project,
    /// The knobs, macros worked in.
    pub(crate) knobs: BinaryKnobs,
    /// The camera.
    pub camera: Camera,
    /// The exposure.
    pub exposure: Exposure,
    pub(crate) lighting: Lighting,
    surfaces: Surfaces<'a>,
    painting: Option<Painting>,
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
            knobs: knobs.resolved(),
            camera,
            exposure: Exposure::default(),
            lighting,
            surfaces,
            painting: None,
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

    pub(crate) fn view(
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
        let paint = self.painting.as_ref().map(|p| p.paint(&view, number));
        draw(&view, &self.exposure, &self.knobs, (colours, paint.as_ref()), run)
    }

    /// The palette of its pictures.
    pub(crate) fn palette(&self, colours: &Colours) -> Result<Palette> {
        Palette::parse(&self.knobs.palette, colours.ink, colours.paper)
    }
}

/// Draws one view: weights, cut, lines, colours.
pub(crate) fn draw(
    view: &View,
    exposure: &Exposure,
    knobs: &BinaryKnobs,
    (colours, paint): (&Colours, Option<&Paint>),
    run: &Run,
) -> Result<Picture> {
    let covered = &view.buffer.covered;
    let paper = colours.paper_is_white();
    let mut steps = shade_painted(view, exposure, knobs, paint, paper, run)?;
    let palette = Palette::parse(&knobs.palette, colours.ink, colours.paper)?;
    let mut labels = None;
    let tint = match &palette {
        Palette::Two => None,
        palette => {
            let coloured = run.stage("cut", covered.len() as u64, || {
                colour_regions(palette, view, &steps.graph, exposure, knobs)
            })?;
            let tint = tinted(&coloured, palette, view, &mut steps, (knobs, colours), run);
            labels = Some(coloured.labels);
            Some(tint)
        }
    };
    let marks = run.stage("draw", covered.len() as u64, || {
        compose(&steps.region, covered, &steps.lines, knobs)
    });
    let counts = measures(&steps);
    let Steps { white, lines, graph, labels: cut, .. } = steps;
    Ok(Picture {
        covered: covered.clone(),
        labels: labels.unwrap_or_else(|| white.map(|w| u8::from(*w))),
        palette: palette.colours().iter().map(|&[r, g, b]| [r, g, b, 1.0]).collect(),
        white,
        lines,
        marks,
        tint,
        graph,
        cut,
        counts,
    })
}

/// A labelled picture in its palette's colours with lines drawn. Regions become white where their
/// colour is light.
fn tinted(
    coloured: &Coloured,
    palette: &Palette,
    view: &View,
    steps: &mut Steps,
    (knobs, colours): (&BinaryKnobs, &Colours),
    run: &Run,
) -> Plane<[f32; 3]> {
    let covered = &view.buffer.covered;
    run.stage("draw", covered.len() as u64, || {
        let light = is_light(palette);
        steps.white = coloured.labels.map(|l| light[usize::from(*l)]);
        let features = Features::find(&view.buffer, knobs);
        let paper = colours.paper_is_white();
        (steps.region, steps.lines) = outline(&features, &steps.white, covered, paper, knobs);
        let (w, h) = covered.size();
        let over =
            |white: f32| compose(&Plane::filled(w, h, white), covered, &steps.lines, knobs).white;
        let (on_white, on_black) = (over(1.0), over(0.0));
        let tint = tint(coloured, covered, palette, knobs);
        Plane::from_fn(w, h, |x, y| {
            let (one, zero, t) = (on_white[(x, y)], on_black[(x, y)], tint[(x, y)]);
            std::array::from_fn(|c| {
                colours.ink[c] * (1.0 - one) + t[c] * (one - zero) + colours.paper[c] * zero
            })
        })
    })
}

/// A finished frame: all that files are made of.
pub struct Picture {
    /// Where there is geometry.
    pub covered: Plane<bool>,
    /// The regions: white where true.
    pub white: Plane<bool>,
    /// The lines on top.
    pub lines: Lines,
    /// Regions and lines, antialiased.
    pub marks: Marks,
    /// The place of each pixel's colour in the palette; of ink and paper, 1 where white.
    pub labels: Plane<u8>,
    /// The palette's colours where they are more than ink and paper.
    pub palette: Vec<[f32; 4]>,
    /// Its colours where the palette is more than ink and paper, lines drawn, sRGB-encoded.
    pub tint: Option<Plane<[f32; 3]>>,
    /// The graph that was cut.
    pub graph: Graph,
    /// That graph's own minimal cut.
    pub cut: Labels,
    /// The measures of the record.
    pub counts: Map<String, Value>,
}

impl Picture {
    /// What a screen shows, transparency left out.
    pub fn displayed(&self, colours: &Colours) -> Plane<[u8; 3]> {
        colour(self, colours).map(|[r, g, b, _]| [*r, *g, *b])
    }
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
    /// Strokes, if any.
    pub painting: Option<Painting>,
    /// A folder for the graph, if wanted.
    pub dump_graph: Option<PathBuf>,
}

impl Job<'_> {
    /// Renders and writes every frame that is not there yet.
    pub fn run(&self, run: &Run) -> Result<Record> {
        dump::check(self.dump_graph.as_deref())?;
        let mut record = Record::new("binary");
        let mut shot = Shot::survey(self.project, self.knobs, run)?;
        shot.painting = self.painting.clone();
        let shot = &shot;
        let mut out = Out::new(self, shot)?;
        let missing = out.missing(self.project.frames());
        let mut film = Map::new();
        let palette = shot.palette(&self.colours)?;
        let holds = self.project.shot().len() > 1 && self.knobs.coherence > 0.0;
        if holds && self.painting.is_some() {
            run.warn("painted strokes: each frame is on its own");
        }
        if holds && palette != Palette::Two {
            run.warn("a palette of more colours: each frame is on its own");
        }
        let two = palette == Palette::Two;
        if two && self.painting.is_none() && self.project.shot().len() > 1 {
            let mut deliver = |number: u32, picture: Picture| out.put(number, picture, run);
            let how = (missing.as_slice(), Labelling::of(&shot.knobs));
            film = reel::shoot(shot, &self.colours, how, &mut deliver, run)?;
        } else {
            let poser = self.project.poser();
            for number in missing {
                run.check()?;
                let frame = self.project.pose(&poser, number, run);
                out.put(number, shot.picture(&frame, number, &self.colours, run)?, run)?;
            }
        }
        let counts = out.finish(&mut record, run)?;
        record.settings = self.settings(shot);
        record.counts = match <[Map<_, _>; 1]>::try_from(counts) {
            Ok([only]) => only,
            Err(frames) => {
                let frames: Vec<Value> = frames.into_iter().map(Value::Object).collect();
                Map::from_iter([("frames".into(), frames.into())])
            }
        };
        record.counts.extend(film);
        Ok(record)
    }

    fn settings(&self, shot: &Shot<'_>) -> Map<String, Value> {
        let mut s = shot.view_settings();
        s.insert("style".into(), self.style.name.clone().into());
        s.insert("colours".into(), self.colours.settings());
        s.insert("exposure".into(), exposure_settings(&shot.exposure));
        if let Some(painting) = &self.painting {
            s.insert("painting".into(), painting.settings());
        }
        if uses_paper(&self.target) {
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

/// Where finished pictures go.
struct Out<'a> {
    job: &'a Job<'a>,
    shot: &'a Shot<'a>,
    encode: Encoding,
    outputs: Vec<(u32, Output)>,
    /// Pictures of an animation, which is written at the end.
    pictures: Vec<Plane<[u8; 4]>>,
    counts: Vec<Map<String, Value>>,
}

impl<'a> Out<'a> {
    fn new(job: &'a Job<'a>, shot: &'a Shot<'a>) -> Result<Self> {
        let encode = Encoding::of(&job.target)?;
        let (outputs, pictures, counts) = Default::default();
        Ok(Self { job, shot, encode, outputs, pictures, counts })
    }

    /// Those of the frames whose files are not there yet.
    fn missing(&mut self, numbers: Vec<u32>) -> Vec<u32> {
        let (Target::Pattern(_), None) = (&self.job.target, &self.job.dump_graph) else {
            return numbers;
        };
        let is_missing = |number: &u32| {
            let recipe = self.job.recipe(self.shot, *number);
            match film::finished(&self.job.target.file(*number), &recipe) {
                Some(output) => {
                    self.outputs.push((*number, output));
                    false
                }
                None => true,
            }
        };
        numbers.into_iter().filter(is_missing).collect()
    }

    fn put(&mut self, number: u32, picture: Picture, run: &Run) -> Result<()> {
        let job = self.job;
        let mut counts = picture.counts.clone();
        if let Some(folder) = &job.dump_graph {
            let folder = dump::folder(folder, &job.target, number);
            let files =
                run.stage("write", 1, || dump::graph(&folder, &picture.graph, &picture.cut))?;
            self.outputs.extend(files.into_iter().map(|output| (number, output)));
        }
        if let Target::Animation(_) = job.target {
            self.pictures.push(colour(&picture, &job.colours));
            self.counts.push(counts);
            return Ok(());
        }
        let (recipe, file) = (job.recipe(self.shot, number), job.target.file(number));
        let output = run.stage("write", 1, || {
            let title = format!("{} {number}", job.project.file_name());
            let plates = Plates {
                colours: &job.colours,
                knobs: job.knobs,
                print: &job.print,
                title: &title,
                recipe: &recipe,
            };
            let bytes = plates.bytes(self.encode, &picture, &mut counts)?;
            match job.target {
                Target::Pattern(_) => film::write_frame(&file, &bytes, &recipe),
                _ => write::whole(&file, &bytes),
            }
        })?;
        self.outputs.push((number, output));
        self.counts.push(counts);
        Ok(())
    }

    /// Writes what is written at the end; the measures of the pictures that were made.
    fn finish(mut self, record: &mut Record, run: &Run) -> Result<Vec<Map<String, Value>>> {
        let job = self.job;
        if let Target::Animation(path) = &job.target {
            let first = job.project.frames()[0];
            let recipe = job.recipe(self.shot, first);
            let fps = job.project.options.fps;
            let bytes = codec::write_apng(&self.pictures, fps, Some(&recipe))?;
            self.outputs.push((first, run.stage("write", 1, || write::whole(path, &bytes))?));
        }
        self.outputs.sort_by_key(|(number, _)| *number);
        record.outputs.extend(self.outputs.into_iter().map(|(_, output)| output));
        Ok(self.counts)
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

/// An exposure, for recipes.
pub(crate) fn exposure_settings(exposure: &Exposure) -> Value {
    json!({
        "low": exposure.low, "high": exposure.high, "threshold": exposure.threshold,
        "contrast": exposure.contrast, "shadows": exposure.shadows,
    })
}

/// Whether a binary job can write such a file.
pub fn check_target(target: &Target) -> Result<()> {
    Encoding::of(target).map(drop)
}

/// How a frame becomes bytes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Encoding {
    Png,
    Pbm,
    Tiff,
    Svg,
}

impl Encoding {
    pub(crate) fn of(target: &Target) -> Result<Self> {
        match target.extension().as_str() {
            "png" | "apng" => Ok(Self::Png),
            "pbm" => Ok(Self::Pbm),
            "tif" | "tiff" => Ok(Self::Tiff),
            "svg" => Ok(Self::Svg),
            other => Err(chiaro_basis::Error::setting(
                "-o",
                format!(".{other}"),
                "a file name that ends in .png, .apng, .svg, .pbm or .tif",
            )),
        }
    }

    pub(crate) fn encode(
        self,
        picture: &Picture,
        colours: &Colours,
        recipe: &str,
    ) -> Result<Vec<u8>> {
        match self {
            Self::Pbm => Ok(codec::write_pbm(&one_bit(&picture.marks, colours.paper_is_white()))),
            Self::Svg | Self::Tiff => unreachable!("made with their paper in mind"),
            Self::Png if colours.are_grey() && picture.tint.is_none() => {
                let grey = colour(picture, colours).map(|p| p[0]);
                codec::write_png_grey(&grey, Some(recipe))
            }
            Self::Png => codec::write_png_rgba(&colour(picture, colours), Some(recipe)),
        }
    }
}

/// Ink and paper over the background, sRGB-encoded bytes. Shares are mixed as displayed: ink has no
/// light of its own, and lines keep their optical width.
fn colour(picture: &Picture, colours: &Colours) -> Plane<[u8; 4]> {
    let mix = |a: f32, b: f32, t: f32| a + (b - a) * t;
    let (w, h) = picture.covered.size();
    Plane::from_fn(w, h, |x, y| {
        let (white, o) = (picture.marks.white[(x, y)], picture.marks.opacity[(x, y)]);
        let over: [f32; 4] = match &picture.tint {
            Some(tint) => {
                let [r, g, b] = tint[(x, y)];
                [r, g, b, 1.0]
            }
            None => std::array::from_fn(|i| mix(colours.ink[i], colours.paper[i], white)),
        };
        let alpha = mix(colours.background[3], over[3], o);
        let channel = |i: usize| {
            let back = colours.background[i] * colours.background[3] * (1.0 - o);
            to_byte((back + over[i] * over[3] * o) / alpha.max(1e-6))
        };
        [channel(0), channel(1), channel(2), to_byte(alpha)]
    })
}

/// The measures of a picture for the record.
fn measures(steps: &Steps) -> Map<String, Value> {
    counts(&steps.white, &steps.graph, &steps.labels, steps.island_energy, &steps.border)
}

/// The measures of a labelled frame: its regions, its graph and that graph's own cut, what the
/// labels cost beyond it, and their border.
pub(crate) fn counts(
    white: &Plane<bool>,
    graph: &Graph,
    cut: &Labels,
    beyond: f64,
    border: &Border,
) -> Map<String, Value> {
    let mut counts = shape_counts(white, &graph.mask);
    let mut put = |name: &str, value: Value| counts.insert(name.into(), value);
    put("flow", json!(cut.flow));
    put("cut", json!(cut.cut));
    put("capacity_units", json!(graph.scale));
    put("island_energy", json!(beyond));
    put("boundary_px", json!(border.pairs));
    put("feature_share", json!(border.on_features));
    put("feature_share_by_chance", json!(border.by_chance));
    counts
}

/// What is counted on the regions alone.
pub(crate) fn shape_counts(white: &Plane<bool>, covered: &Plane<bool>) -> Map<String, Value> {
    let nodes = covered.pixels().iter().filter(|c| **c).count();
    let whites = white.pixels().iter().filter(|w| **w).count();
    let pieces = components(white, covered).pieces;
    let small = 30.0 * (covered.height() as f32 / REFERENCE_HEIGHT).powi(2);
    let islands = pieces.iter().filter(|p| p.touches_other && (p.area as f32) < small).count();
    let share = if nodes == 0 { 0.0 } else { whites as f64 / nodes as f64 };
    let mut counts = Map::new();
    let mut put = |name: &str, value: Value| counts.insert(name.into(), value);
    put("pixels", json!(covered.len()));
    put("nodes", json!(nodes));
    put("white_fraction", json!(share));
    put("components", json!(pieces.len()));
    put("islands_under_30px", json!(islands));
    counts
}
