//! The job: frames in, lit pictures out.

use super::baked::{self, TreeFiles};
use super::book;
use super::cap::{Cap, shown};
use super::check;
use super::coded::{self, Gathered};
use super::layers::{Backdrop, Layers};
use super::shot::Shot;
use crate::film::Target;
use crate::frames::Frames;
use crate::project::Project;
use crate::record::{Record, frame_recipe, knob_settings};
use chiaro_basis::{Error, Result, Run, choice};
use chiaro_image::{Plane, codec};
use chiaro_pbgi::resolve::{Irradiance, Seen, resolve};
use chiaro_pbgi::surfel::Lit;
use chiaro_pbgi::{LightKnobs, Openings, Wanted};
use chiaro_scene::Frame;
use chiaro_trace::path::{Aim, PathImage, PathTracer};
use chiaro_trace::{GBuffer, ambient_occlusion, direct_irradiance};
use serde_json::{Map, Value, json};
use std::path::PathBuf;
use std::sync::{Mutex, PoisonError};

choice! {
    /// How light is transported.
    pub enum Method {
        /// Point-based: no noise.
        #[default]
        Pbgi = "pbgi",
        /// Path tracing: the reference.
        Path = "path",
    }
}

choice! {
    /// Against what a picture is measured.
    pub enum Check {
        /// Nothing.
        #[default]
        Nothing = "nothing",
        /// The path-traced reference.
        Path = "path",
        /// The same tree before it was coded.
        Exact = "exact",
    }
}

/// Paths a pixel between two looks at the clock and at Ctrl-C.
const BATCH: u32 = 64;
/// Rays of the occlusion layer beside paths.
const OCCLUSION_RAYS: usize = 8;

/// What a method finds of a frame: light, openness and from where, measures.
type Found = (Plane<Seen>, (Plane<f32>, Option<Openings>), Map<String, Value>);

/// A light job.
pub struct Job<'a> {
    /// The scene and its film.
    pub project: &'a Project,
    /// The knobs, `--set` applied.
    pub knobs: &'a LightKnobs,
    /// How light is transported.
    pub method: Method,
    /// A picture of the surroundings in latitude and longitude.
    pub env: Option<PathBuf>,
    /// Against what errors are measured.
    pub check: Check,
    /// Where the coded tree is written.
    pub bake: Option<PathBuf>,
    /// A tree that was written so, used in every frame.
    pub tree: Option<PathBuf>,
    /// A book that is read, or made where it is not there yet.
    pub book: Option<PathBuf>,
    /// The most memory that may be used, in bytes.
    pub memory: Option<u64>,
    /// What stands behind the scene.
    pub backdrop: Option<[f32; 4]>,
    /// Where the picture goes.
    pub target: Target,
}

/// Whether a light job can write such a file.
pub fn check_target(target: &Target) -> Result<()> {
    match target.extension().as_str() {
        _ if target.is_animation() => Ok(()),
        "png" | "exr" => Ok(()),
        other => Err(Error::setting(
            "-o",
            format!(".{other}"),
            "a file name that ends in .png, .apng, .gif, .mp4, .webm or .exr",
        )),
    }
}

impl Job<'_> {
    /// Renders and writes every frame that is not there yet.
    pub fn run(&self, run: &Run) -> Result<Record> {
        check_target(&self.target)?;
        self.target.spares(&self.project.frames(), self.project.files.iter().cloned())?;
        if !self.knobs.is_compact() && self.knobs.surfels > LightKnobs::MOST_EXACT {
            let most =
                format!("at most {}, or --set tree=compact beside it", LightKnobs::MOST_EXACT);
            return Err(Error::setting("surfels", self.knobs.surfels, most));
        }
        let mut record = Record::new("light");
        let poser = self.project.poser();
        let mut shot = Shot::survey(self.project, self.knobs, self.env.as_deref(), run)?;
        shot.files = self.tree_files(&shot, run)?;
        record.settings = self.settings(&shot);
        let recipe = |number| frame_recipe("light", self.settings(&shot), number);
        let mut frames = Frames::new(&self.target, &recipe);
        for number in frames.missing(self.project.frames()) {
            run.check()?;
            let frame = self.project.pose(&poser, number, run);
            let (layers, measures) = self.frame(&shot, &frame, number, run)?;
            frames.measured(number, measures);
            let pixels = layers.seen.len() as u64;
            let displayed = || layers.displayed(self.knobs.tone, self.backdrop());
            if frames.are_one_file() {
                frames.keep(number, run.stage("tone", pixels, displayed));
                continue;
            }
            let bytes = run.stage("tone", pixels, || match self.target.extension().as_str() {
                "exr" => layers.exr(&recipe(number)),
                _ => codec::write_png_rgba(&displayed(), Some(&recipe(number))),
            })?;
            frames.write(number, &bytes, run)?;
        }
        frames.finish(self.project.options.fps, &mut record, run)?;
        let mut written = shot.files.written.lock().unwrap_or_else(PoisonError::into_inner);
        record.outputs.append(&mut written);
        drop(written);
        if let Some(cap) = self.memory {
            let peak = crate::record::peak_bytes();
            if peak > cap {
                run.warn(format!("the peak of memory was {}, over the cap", shown(peak)));
            }
        }
        Ok(record)
    }

    fn tree_files(&self, shot: &Shot, run: &Run) -> Result<TreeFiles> {
        if self.bake.is_some() && self.project.frames().len() > 1 {
            let why = "one frame; the tree of one frame may then serve a film with --tree";
            return Err(Error::setting("--bake", "several frames", why));
        }
        let origin = baked::origin(self.project, self.knobs, shot.env_hash.as_deref());
        let cap = self.memory.map(Cap::new);
        let open = |path| baked::open(path, &origin, cap.as_ref(), run);
        let baked = self.tree.as_deref().map(open).transpose()?;
        let (mut book, mut written) = (None, Vec::new());
        if self.knobs.is_compact() && baked.is_none() {
            let (taught, output) =
                book::of_shot(self.project, shot, self.knobs, self.book.as_deref(), run)?;
            (book, written) = (taught, output.into_iter().collect());
        }
        let written = Mutex::new(written);
        Ok(TreeFiles { baked, bake: self.bake.clone(), origin, book, cap, written })
    }

    pub(super) fn backdrop(&self) -> Backdrop {
        self.backdrop.map_or(Backdrop::Sky, Backdrop::Colour)
    }

    /// One frame's layers and measures.
    pub(super) fn frame(
        &self,
        shot: &Shot,
        frame: &Frame,
        number: u32,
        run: &Run,
    ) -> Result<(Layers, Map<String, Value>)> {
        let size = shot.camera.size;
        let pixels = (size.0 * size.1) as u64;
        let pose = shot.camera.pose(frame, number);
        let (tracer, buffer) = run.stage("trace", pixels, || {
            let tracer = self.project.tracer(frame);
            let buffer = GBuffer::trace(&tracer, &shot.surfaces, &pose, size, run);
            (tracer, buffer)
        });
        let buffer = buffer?;
        let lights = shot.lights(&tracer);
        let lit = Lit { tracer: &tracer, surfaces: &shot.surfaces, lights: &lights };
        let (seen, (openness, openings), measures) = match self.method {
            Method::Pbgi => self.by_points(shot, &lit, &buffer, run)?,
            Method::Path => self.by_paths(&lit, &buffer, run)?,
        };
        let scale = |v: [f32; 3]| v.map(|c| c * shot.exposure);
        let seen = seen.map(|s| Seen {
            direct: scale(s.direct),
            indirect: scale(s.indirect),
            specular: scale(s.specular),
            beyond: scale(s.beyond),
            coverage: s.coverage,
        });
        // A white dome in the place of a sky has no unit.
        let unit = if lights.sky.is_some() { shot.exposure } else { 1.0 };
        let openings =
            openings.map(|o| Openings { dome: o.dome.map(|l| l.map(|c| c * unit)), ..o });
        Ok((Layers { seen, openness, openings, buffer }, measures))
    }

    fn by_points(&self, shot: &Shot, lit: &Lit, buffer: &GBuffer, run: &Run) -> Result<Found> {
        let pixels = buffer.covered.len() as u64;
        let direct = run
            .stage("channels", pixels, || direct_irradiance(lit.tracer, buffer, lit.lights, run))?;
        let oracle = self.check == Check::Exact;
        let Gathered { found, exact, mut counts } =
            coded::gather(shot, lit, buffer, self.knobs, (self.wanted(), oracle), run)?;
        let specular = found.specular.as_ref();
        let irradiance = Irradiance { direct: &direct, indirect: &found.irradiance, specular };
        let side = self.knobs.edges;
        let seen = run.stage("draw", pixels, || resolve(lit, buffer, &irradiance, side, run))?;
        let receivers = buffer.covered.pixels().iter().filter(|c| **c).count();
        counts.insert("receivers".into(), json!(receivers));
        counts.insert("bounces".into(), json!(self.knobs.bounces));
        if self.check == Check::Path {
            let measured = check::against_paths(shot, lit, buffer, &irradiance, self.knobs, run)?;
            counts.extend(measured);
        }
        if let Some(exact) = exact {
            let irradiance = Irradiance { direct: &direct, indirect: &exact.irradiance, specular };
            let truth = resolve(lit, buffer, &irradiance, side, run)?;
            counts.extend(check::against_exact(shot, &seen, &truth, self.knobs)?);
        }
        Ok((seen, (found.openness, found.openings), counts))
    }

    /// What only layers need.
    fn wanted(&self) -> Wanted {
        let openings = self.target.extension() == "exr" && self.knobs.bounces > 0;
        Wanted { openings, specular: self.knobs.glossy }
    }

    fn by_paths(&self, lit: &Lit, buffer: &GBuffer, run: &Run) -> Result<Found> {
        let (width, height) = buffer.size();
        let paths = PathTracer {
            tracer: lit.tracer,
            surfaces: lit.surfaces,
            lights: lit.lights,
            bounces: self.knobs.bounces,
            glossy: self.knobs.glossy,
        };
        let mut image = PathImage::new(width, height);
        while image.samples() < self.knobs.samples {
            let count = BATCH.min(self.knobs.samples - image.samples());
            run.stage("gather", (width * height) as u64, || {
                paths.add(&mut image, &buffer.pose, count, Aim::Spread, run)
            })?;
        }
        let (direct, indirect) = (image.direct(), image.indirect());
        let (beyond, coverage, specular) = (image.beyond(), image.coverage(), image.specular());
        let seen = Plane::from_fn(width, height, |x, y| Seen {
            direct: direct[(x, y)],
            indirect: indirect[(x, y)],
            specular: specular[(x, y)],
            beyond: beyond[(x, y)],
            coverage: coverage[(x, y)],
        });
        let mut counts = Map::new();
        counts.insert("samples".into(), json!(image.samples()));
        counts.insert("bounces".into(), json!(self.knobs.bounces));
        counts.insert("reference_error".into(), json!(image.relative_error(&buffer.covered)));
        let openness = match self.target.extension().as_str() {
            "exr" => run.stage("channels", (width * height) as u64, || {
                let reach = self.knobs.occlusion * buffer.radius;
                ambient_occlusion(lit.tracer, buffer, reach, OCCLUSION_RAYS, run)
            })?,
            _ => Plane::filled(width, height, 1.0),
        };
        Ok((seen, (openness, None), counts))
    }

    pub(super) fn settings(&self, shot: &Shot) -> Map<String, Value> {
        let mut s = shot.camera.settings(self.project);
        s.insert("sun".into(), json!(self.project.options.sun));
        s.insert("method".into(), self.method_word().into());
        s.insert("env_sha256".into(), json!(shot.env_hash));
        s.insert("backdrop".into(), json!(self.backdrop));
        let baked = shot.files.baked.as_ref().map(|b| crate::write::sha256(b.origin.as_bytes()));
        s.insert("baked_from".into(), json!(baked));
        let book = shot
            .files
            .book
            .as_ref()
            .map(|b| crate::write::sha256(&chiaro_pbgi::file::book_bytes(&b.book)));
        s.insert("book_sha256".into(), json!(book));
        s.insert("exposure_factor".into(), json!(shot.exposure));
        s.extend(knob_settings(self.knobs));
        s
    }

    fn method_word(&self) -> &'static str {
        Method::WORDS[self.method as usize]
    }
}
