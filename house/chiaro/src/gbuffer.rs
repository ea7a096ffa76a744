//! `chiaro gbuffer`: geometry and appearance as named layers of one EXR file a frame.

use crate::binary::Shot;
use crate::film::Target;
use crate::frames::Frames;
use crate::project::Project;
use crate::record::{Record, frame_recipe};
use chiaro_basis::{Error, Result, Run};
use chiaro_binary::{BinaryKnobs, Channel, View};
use chiaro_image::Plane;
use chiaro_image::codec::{ExrChannel, ExrImage, write_exr};
use chiaro_scene::Frame;
use chiaro_trace::motion;

/// A G-buffer job.
pub struct Job<'a> {
    /// The scene and its film.
    pub project: &'a Project,
    /// Where the layers go.
    pub target: Target,
}

impl Job<'_> {
    /// Renders and writes every frame that is not there yet.
    pub fn run(&self, run: &Run) -> Result<Record> {
        if self.target.extension() != "exr" {
            let got = format!(".{}", self.target.extension());
            return Err(Error::setting("-o", got, "a file name that ends in .exr"));
        }
        self.target.spares(&self.project.frames(), self.project.files.iter().cloned())?;
        let mut record = Record::new("gbuffer");
        let knobs = BinaryKnobs::default();
        let poser = self.project.poser();
        let shot = Shot::survey(self.project, &knobs, run)?;
        record.settings = shot.view_settings();
        let recipe = |number| frame_recipe("gbuffer", shot.view_settings(), number);
        let mut frames = Frames::new(&self.target, &recipe);
        for number in frames.missing(self.project.frames()) {
            run.check()?;
            let frame = self.project.pose(&poser, number, run);
            let before = self.project.pose(&poser, number.saturating_sub(1).max(1), run);
            let view = shot.everything(&frame, number, run)?;
            let flow = self.motion(&shot, &view, (&frame, number), &before);
            let bytes = write_exr(&layers(&view, &flow, &recipe(number)))?;
            frames.write(number, &bytes, run)?;
            let covered = view.buffer.covered.pixels().iter().filter(|c| **c).count();
            let counts = [("covered", covered), ("pixels", view.buffer.covered.len())];
            frames
                .measured(number, counts.map(|(k, v)| (k.into(), v.into())).into_iter().collect());
        }
        frames.finish(self.project.options.fps, &mut record, run)?;
        Ok(record)
    }

    fn motion(
        &self,
        shot: &Shot<'_>,
        view: &View,
        (frame, number): (&Frame, u32),
        before: &Frame,
    ) -> Plane<[f32; 2]> {
        let pose = shot.camera.pose(before, number.saturating_sub(1).max(1));
        motion(&view.buffer, &self.project.scene, frame, before, &pose)
    }
}

/// The layers of a frame under their standard names.
fn layers(view: &View, flow: &Plane<[f32; 2]>, recipe: &str) -> ExrImage {
    let b = &view.buffer;
    let headlamp = view.channels.get(Channel::Headlamp);
    let mut layers: Vec<(String, ExrChannel)> = Vec::new();
    let mut push =
        |name: &str, plane: Plane<f32>| layers.push((name.into(), ExrChannel::F32(plane)));
    let shade = |x: &f32, c: &[f32; 3], i: usize| x * c[i];
    for (i, name) in ["R", "G", "B"].into_iter().enumerate() {
        if let Some(light) = headlamp {
            let lit = light.zip(&b.base_colour, |x, c| shade(x, c, i));
            push(name, lit.expect("channels have the picture's size"));
        }
    }
    push("A", b.covered.map(|c| if *c { 1.0 } else { 0.0 }));
    push(
        "depth.Z",
        b.depth.zip(&b.covered, |d, c| if *c { *d } else { f32::INFINITY }).expect("one size"),
    );
    for (name, plane) in [
        ("normal", &b.normal),
        ("smooth_normal", &b.smooth_normal),
        ("geometric_normal", &b.geometric_normal),
        ("position", &b.position),
    ] {
        for (i, axis) in ["X", "Y", "Z"].into_iter().enumerate() {
            push(&format!("{name}.{axis}"), plane.map(|v| v[i]));
        }
    }
    for (i, axis) in ["R", "G", "B"].into_iter().enumerate() {
        push(&format!("albedo.{axis}"), b.base_colour.map(|v| v[i]));
    }
    push("motion.X", flow.map(|m| m[0]));
    push("motion.Y", flow.map(|m| m[1]));
    for channel in Channel::ALL {
        if let Some(plane) = view.channels.get(channel) {
            let name = if channel == Channel::Occlusion { "ao.A" } else { channel.name() };
            push(name, plane.clone());
        }
    }
    layers.push(("object.ID".into(), ExrChannel::U32(b.object.clone())));
    layers.push(("material.ID".into(), ExrChannel::U32(b.material.clone())));
    let attributes = [("chiaro".to_owned(), recipe.to_owned())].into();
    ExrImage { size: b.size(), layers, attributes }
}
