//! [`Shot`]: what the pictures of a shot share: camera, light, exposure.

use super::indirect::Reflections;
use super::picture::{Picture, draw};
use crate::camera::Camera;
use crate::colours::Colours;
use crate::lighting::Lighting;
use crate::painting::Painting;
use crate::project::Project;
use chiaro_basis::{Result, Run};
use chiaro_binary::{
    BinaryKnobs, Channel, Channels, Exposure, LEAST_REACH, Lesson, Lit, Paint, Palette, View,
    expose,
};
use chiaro_scene::Frame;
use chiaro_trace::{GBuffer, Surfaces};
use serde_json::{Map, Value, json};

/// Frames that a shot's exposure is surveyed on, at most, and their height in pixels.
const SURVEY_FRAMES: usize = 5;
pub(crate) const SURVEY_HEIGHT: usize = 240;

/// Pixels that a survey must see before it says that a place is without light: a sliver may lie in one shadow.
const LEAST_SEEN: usize = 2000;

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
    /// Light that surfaces send each other, if a style mixes it in.
    reflections: Option<Reflections>,
    painting: Option<Painting>,
    /// What strokes teach over a shot of several frames.
    lesson: Option<Lesson>,
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
        let knobs = knobs.resolved();
        let reflections = Channel::Indirect
            .is_used(&knobs)
            .then(|| Reflections::of(&project.scene, &frames[0], &knobs));
        let mut shot = Self {
            project,
            knobs,
            camera,
            exposure: Exposure::default(),
            lighting,
            surfaces,
            reflections,
            painting: None,
            lesson: None,
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
        let covered = lit.iter().flat_map(|v| v.buffer.covered.pixels());
        let seen = covered.filter(|c| **c).count();
        if reach >= LEAST_REACH || seen < LEAST_SEEN {
            return expose(&lit, true, &self.knobs, run);
        }
        run.warn("hardly any light gets in: shadows are left out");
        expose(&views(false)?, false, &self.knobs, run)
    }

    /// Takes strokes up. In a film they teach on small frames, those that they are on.
    pub(crate) fn paint(&mut self, painting: Option<Painting>, run: &Run) -> Result<()> {
        let shot = self.project.shot();
        self.painting = painting;
        let Some(painting) = self.painting.as_ref().filter(|_| shot.len() > 1) else {
            return Ok(());
        };
        let poser = self.project.poser();
        let small = self.camera.at_height(SURVEY_HEIGHT.min(self.camera.size.1)).size;
        let mut lesson = Lesson::default();
        for number in painting.lessons(&shot, &self.project.sampled_shot(SURVEY_FRAMES)) {
            let frame = self.project.pose(&poser, number, run);
            let view = self.view(&frame, number, small, self.exposure.shadows, run)?;
            painting.teach(&mut lesson, &view, number);
        }
        self.lesson = Some(lesson);
        Ok(())
    }

    /// What strokes do to a frame.
    pub(super) fn painted(&self, view: &View, number: u32) -> Option<Paint> {
        let painting = self.painting.as_ref()?;
        Some(match &self.lesson {
            Some(lesson) => painting.taught(view, number, lesson),
            None => painting.paint(view, number),
        })
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
        let lit = Lit { tracer: &tracer, surfaces: &self.surfaces, buffer: &buffer, lamps: &lamps };
        let occlusion = wanted(Channel::Occlusion);
        let rendered = |c| wanted(c) && (c != Channel::Occlusion || self.reflections.is_none());
        let mut channels = run.stage("channels", pixels, || {
            Channels::render(&lit, rendered, &self.knobs, shadows, run)
        })?;
        if let Some(reflections) = &self.reflections {
            reflections.put(&lit, &mut channels, occlusion, run)?;
        }
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
        let mut view = self.view(frame, number, size, self.exposure.shadows, run)?;
        if !matches!(self.palette(colours)?, Palette::Spots(_)) {
            view.buffer.forget_light();
        }
        let paint = self.painted(&view, number);
        draw((view, None), &self.exposure, &self.knobs, (colours, paint.as_ref()), run)
    }

    /// The palette of its pictures.
    pub(crate) fn palette(&self, colours: &Colours) -> Result<Palette> {
        Palette::parse(&self.knobs.palette, colours.ink, colours.paper)
    }
}

/// An exposure, for recipes.
pub(crate) fn exposure_settings(exposure: &Exposure) -> Value {
    json!({
        "low": exposure.low, "high": exposure.high, "threshold": exposure.threshold,
        "contrast": exposure.contrast, "shadows": exposure.shadows,
    })
}
