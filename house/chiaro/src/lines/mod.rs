//! `chiaro lines`: from a project to strokes, one frame or a film.
//!
//! The lines of the whole shot are found and tracked first, since identities are decided over the
//! shot; then every frame that is not there yet is drawn with the brushes of its style, over nothing,
//! over binary shading, or over pictures, and written.

pub(crate) mod beneath;
mod document;
mod owners;
pub(crate) mod picture;
pub(crate) mod ready;
pub(crate) mod style;
mod svg;

use crate::camera::Camera;
use crate::colours::Colours;
use crate::film::Target;
use crate::frames::Frames;
use crate::light::Under;
use crate::project::Project;
use crate::record::{Record, frame_recipe};
use crate::style::Style;
use crate::vector::Print;
pub use beneath::Over;
use beneath::{Beneath, Regions};
use chiaro_basis::{Error, Result, Run};
use chiaro_binary::BinaryKnobs;
use chiaro_image::codec;
use chiaro_image::colour::srgb_encode;
use chiaro_ink::Travel;
use chiaro_lines::check::check;
use chiaro_lines::parameter::{Solved, parameterize};
use chiaro_lines::{Film, LinesKnobs, Reel, View};
use chiaro_pbgi::LightKnobs;
use chiaro_scene::Frame;
use ready::Names;
use serde_json::{Map, Value};
use std::cell::Cell;
use std::path::PathBuf;
pub use style::LineStyle;

/// Frames on which the default view is framed, at most.
const FRAMING: usize = 5;

/// What lines look like, and what they lie on.
pub struct Look<'a> {
    /// The style.
    pub style: &'a Style,
    /// Its lines, `--set` applied.
    pub lines: LineStyle,
    /// Its regions, `--set` applied.
    pub binary: BinaryKnobs,
    /// What is beneath.
    pub over: Over,
    /// How it is lit, where that is the scene in its light.
    pub light: LightKnobs,
    /// Ink, paper and background.
    pub colours: Colours,
    /// The paper that SVG files are drawn on, and the pen's width where strokes are drawn by one.
    pub print: Print,
}

impl<'a> Look<'a> {
    /// A style as it is.
    pub fn of(style: &'a Style) -> Result<Self> {
        let (lines, mut binary) = (style.lines.clone(), style.binary.clone());
        let over = Over::parse(&style.over)?;
        // Strokes take the place of the lines that the regions have without them.
        binary.lines &= over != Over::Binary;
        let (colours, print, light) = (style.colours(), Print::default(), LightKnobs::default());
        Ok(Self { style, lines, binary, over, light, colours, print })
    }

    /// Sets a knob of lines, of brushes, or, as in `binary.global` and `light.bounces`, of what is
    /// beneath.
    pub fn set(&mut self, text: &str) -> Result<()> {
        let text = text.trim();
        match (text.strip_prefix("binary."), text.strip_prefix("light.")) {
            (Some(rest), _) => crate::style::set(&mut self.binary, rest),
            (_, Some(rest)) => crate::style::set(&mut self.light, rest),
            _ => self.lines.set(text),
        }
    }
}

/// A lines job.
pub struct Job<'a> {
    /// The scene and its film.
    pub project: &'a Project,
    /// What lines look like.
    pub look: Look<'a>,
    /// Where the lines go.
    pub target: Target,
    /// Whether the record needs the measures even of films that are there already.
    pub measure: bool,
    /// Whether visibility is compared with that on a surface sixteen times finer.
    pub check: bool,
}

/// What a file holds.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Encoding {
    Png,
    Svg,
    Json,
}

/// Where lines go: a JSON file may hold a whole film.
pub fn target(path: &std::path::Path, frames: usize) -> Result<Target> {
    let json = path.extension().is_some_and(|e| e.eq_ignore_ascii_case("json"));
    let target = Target::parse(path, if json { 1 } else { frames })?;
    Encoding::of(&target)?;
    Ok(target)
}

impl Encoding {
    fn of(target: &Target) -> Result<Self> {
        match target.extension().as_str() {
            _ if target.is_animation() => Ok(Self::Png),
            "png" => Ok(Self::Png),
            "svg" => Ok(Self::Svg),
            "json" => Ok(Self::Json),
            other => Err(Error::setting(
                "-o",
                format!(".{other}"),
                "a file name that ends in .png, .apng, .gif, .mp4, .webm, .svg or .json",
            )),
        }
    }
}

/// A shot's camera and tracked lines.
pub struct Shot {
    /// The camera.
    pub camera: Camera,
    /// The frames of the shot.
    pub numbers: Vec<u32>,
    /// Their lines, in the same order.
    pub film: Film,
    /// What objects are called.
    pub(crate) names: Names,
    /// What their parameters took.
    pub solved: Solved,
}

impl Shot {
    /// Finds, tracks and parameterizes the lines of a project's shot.
    pub fn track(project: &Project, camera: Camera, knobs: &LinesKnobs, run: &Run) -> Result<Self> {
        let numbers = project.shot();
        let mut film = with_reel(project, &camera, |reel| Film::of(reel, knobs, run))?;
        let seconds = |n: &[u32]| f64::from(n[1].abs_diff(n[0])) / project.options.fps;
        let spacing: Vec<f64> = numbers.windows(2).map(seconds).collect();
        let solved = parameterize(&mut film, &spacing, knobs, run)?;
        for note in &film.notes {
            run.warn(note);
        }
        Ok(Self { camera, numbers, film, solved, names: names(project) })
    }

    /// Whether no frame has a line, seen or hidden.
    fn is_empty(&self) -> bool {
        self.film.frames.iter().all(|f| f.strokes.is_empty() && f.hidden.is_empty())
    }
}

/// What the objects of a project's frames are called.
fn names(project: &Project) -> Names {
    let scene = &project.scene;
    let frame = project.poser().frame(0.0, &project.playback);
    let object = |o: &chiaro_scene::Object| scene.nodes[o.node.index()].name.clone();
    let encoded = |m: &chiaro_scene::Material| {
        let [r, g, b, _] = m.base_colour;
        [r, g, b].map(srgb_encode)
    };
    Names {
        objects: frame.objects.iter().map(object).collect(),
        materials: scene.materials.iter().map(|m| m.name.clone()).collect(),
        colours: scene.materials.iter().map(encoded).collect(),
    }
}

/// Works on a project's shot as lines see it.
fn with_reel<T>(project: &Project, camera: &Camera, work: impl FnOnce(&Reel<'_>) -> T) -> T {
    let numbers = project.shot();
    let poser = project.poser();
    let at = |i: usize| {
        let frame = poser.frame(project.time(numbers[i]), &project.playback);
        let view = View::new(camera.pose(&frame, numbers[i]), camera.size);
        (frame, view)
    };
    work(&Reel { scene: &project.scene, count: numbers.len(), at: &at })
}

/// The camera of a shot.
pub fn camera(project: &Project, run: &Run) -> Result<Camera> {
    let poser = project.poser();
    let numbers = project.sampled_shot(FRAMING);
    let frames: Vec<Frame> = numbers.iter().map(|&n| project.pose(&poser, n, run)).collect();
    Camera::choose(project, &frames, run)
}

impl Job<'_> {
    /// Finds the lines and writes every frame that is not there yet.
    pub fn run(&self, run: &Run) -> Result<Record> {
        let encoding = Encoding::of(&self.target)?;
        if self.project.scene.meshes.iter().any(chiaro_scene::Mesh::is_cloud) {
            let why = "points have no edges to draw; use light or binary, or reconstruct a surface";
            return Err(Error::input(&self.project.name, "", why));
        }
        let mut record = Record::new("lines");
        let numbers = self.project.frames();
        self.target.spares(&numbers, self.read(&numbers))?;
        let camera = camera(self.project, run)?;
        let regions = self.regions(encoding, run)?;
        let light = self.light(encoding, run)?;
        let settings = self.settings(&camera, regions.as_ref(), light.as_ref());
        let recipe = |number| {
            let mut settings = settings.clone();
            settings.insert("over".into(), self.look.over.settings(number));
            frame_recipe("lines", settings, number)
        };
        let mut frames = Frames::new(&self.target, &recipe);
        let missing = frames.missing(numbers);
        let knobs = &self.look.lines.knobs;
        if self.check {
            let errors = with_reel(self.project, &camera, |reel| check(reel, knobs, run))?;
            record.counts.extend(counts(errors.named()));
        }
        if !missing.is_empty() || self.measure {
            let shot = Shot::track(self.project, camera, knobs, run)?;
            self.look.lines.unmet(&shot.names).into_iter().for_each(|note| run.warn(note));
            if shot.is_empty() {
                run.warn("no line of the scene is in the picture: --from, --look-at and --camera turn the eye");
            }
            let job = Writing {
                job: self,
                shot: &shot,
                encoding,
                light: light.as_ref(),
                recipe: &recipe,
                travel: Cell::default(),
            };
            match &regions {
                Some(regions) => {
                    let deliver =
                        &mut |number, beneath| job.page(&[number], Some(beneath), &mut frames, run);
                    record.counts.extend(regions.shoot(&missing, deliver, run)?);
                }
                None => job.pages(&missing, &mut frames, run)?,
            }
            let mut measures = measures(&shot);
            if encoding == Encoding::Svg && !missing.is_empty() {
                measures.extend(pen_way(job.travel.get()));
            }
            frames.measured(missing.first().copied().unwrap_or(0), measures);
        }
        frames.finish(self.project.options.fps, &mut record, run)?;
        record.settings = settings;
        Ok(record)
    }

    /// The files that are read for some frames.
    fn read(&self, frames: &[u32]) -> impl Iterator<Item = PathBuf> + '_ {
        let scene = self.project.files.iter().cloned();
        let beneath = match &self.look.over {
            Over::Pictures(pictures) => frames.iter().map(|f| pictures.file(*f)).collect(),
            _ => Vec::new(),
        };
        let style = [PathBuf::from(&self.look.style.name)];
        self.look.lines.picture_files().chain(beneath).chain(style).chain(scene)
    }

    /// The binary shading beneath, where there is some and the file shows it.
    fn regions(&self, encoding: Encoding, run: &Run) -> Result<Option<Regions<'_>>> {
        let look = &self.look;
        match (&look.over, encoding) {
            (Over::Binary, Encoding::Png | Encoding::Svg) => {
                let (how, on) = ((look.style, &look.binary), (look.colours, look.print));
                Regions::survey(self.project, how, on, encoding == Encoding::Svg, run).map(Some)
            }
            _ => Ok(None),
        }
    }

    /// The lit pictures beneath, where there are some and the file shows them.
    fn light(&self, encoding: Encoding, run: &Run) -> Result<Option<Under<'_>>> {
        let look = &self.look;
        if look.over != Over::Light || encoding == Encoding::Json {
            return Ok(None);
        }
        // White paper is no backdrop: the sky of the scene is.
        let own = look.colours.background;
        let backdrop = Some(own).filter(|c| *c != [1.0; 4]);
        Under::survey(self.project, &look.light, backdrop, run).map(Some)
    }

    fn settings(
        &self,
        camera: &Camera,
        regions: Option<&Regions<'_>>,
        light: Option<&Under<'_>>,
    ) -> Map<String, Value> {
        let mut s = camera.settings(self.project);
        let look = &self.look;
        s.insert("style".into(), look.style.name.clone().into());
        s.insert("colours".into(), look.colours.settings());
        s.insert("print".into(), look.print.settings());
        s.extend(look.lines.settings());
        if let Some(regions) = regions {
            s.insert("regions".into(), Value::Object(regions.settings()));
        }
        if let Some(light) = light {
            s.insert("light".into(), Value::Object(light.settings()));
        }
        s
    }
}

/// Frames on their way to files.
struct Writing<'a> {
    job: &'a Job<'a>,
    shot: &'a Shot,
    encoding: Encoding,
    light: Option<&'a Under<'a>>,
    recipe: &'a dyn Fn(u32) -> String,
    /// The pen's way over all frames so far.
    travel: Cell<Travel>,
}

impl Writing<'_> {
    /// Whether one file holds every frame.
    fn holds_all(&self) -> bool {
        matches!((&self.job.target, self.encoding), (Target::Single(_), Encoding::Json))
    }

    /// The frames by file: one each, but a single file of strokes holds a whole film.
    fn pages(&self, numbers: &[u32], frames: &mut Frames<'_>, run: &Run) -> Result<()> {
        for page in numbers.chunks(if self.holds_all() { numbers.len().max(1) } else { 1 }) {
            let beneath = match (self.encoding, self.light) {
                (Encoding::Json, _) => None,
                (_, Some(light)) => Some(Beneath::of(&light.picture(page[0], run)?)),
                _ => self.job.look.over.picture(page[0], self.shot.camera.size)?,
            };
            self.page(page, beneath, frames, run)?;
        }
        Ok(())
    }

    /// Draws and writes some frames; only JSON holds more than one.
    fn page(
        &self,
        page: &[u32],
        beneath: Option<Beneath>,
        frames: &mut Frames<'_>,
        run: &Run,
    ) -> Result<()> {
        run.check()?;
        let (number, look) = (page[0], &self.job.look);
        let draw =
            |beneath| picture::picture(self.shot, number, &look.lines, &look.colours, beneath);
        if frames.are_one_file() {
            frames.keep(number, run.stage("draw", 1, || draw(beneath)));
            return Ok(());
        }
        let json = |sink: &mut dyn std::io::Write| document::write(self.shot, page, look, sink);
        if self.holds_all() {
            return run.stage("write", page.len() as u64, || frames.stream(number, json));
        }
        let recipe = (self.recipe)(number);
        let bytes = run.stage("draw", page.len() as u64, || match self.encoding {
            Encoding::Json => {
                let mut text = Vec::new();
                json(&mut text).map_err(|e| Error::output("memory", e.to_string()))?;
                Ok(text)
            }
            Encoding::Svg => {
                let (svg, way) = svg::svg((self.shot, number), self.job, beneath, recipe)?;
                self.travel.set(self.travel.get() + way);
                Ok(svg.into_bytes())
            }
            Encoding::Png => codec::write_png_rgba(&draw(beneath), Some(&recipe)),
        })?;
        frames.write(number, &bytes, run)
    }
}

/// The measures of a shot, for the record.
fn measures(shot: &Shot) -> Map<String, Value> {
    let mut named = chiaro_lines::measure(&shot.film).named();
    named.extend(chiaro_lines::quality(&shot.film).named());
    let solved = &shot.solved;
    named.push(("unknowns", solved.unknowns as f64));
    named.push(("links", solved.links as f64));
    named.push(("cut_links", solved.cut as f64));
    named.push(("mended_folds", solved.mended as f64));
    counts(named)
}

/// The way of a pen, down and up, for the record.
fn pen_way(travel: Travel) -> Map<String, Value> {
    counts(vec![("pen_down_mm", travel.down), ("pen_up_mm", travel.up)])
}

fn counts(named: Vec<(&'static str, f64)>) -> Map<String, Value> {
    named.into_iter().map(|(name, value)| (name.to_owned(), value.into())).collect()
}
