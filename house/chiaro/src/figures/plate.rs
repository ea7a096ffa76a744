//! [`Plate`]: one view of a demo scene, ready to be drawn with many settings.

use crate::binary::Shot;
use crate::project::{Options, Project};
use chiaro_basis::{Result, Run};
use chiaro_binary::{BinaryKnobs, Channel, Exposure, Model, Steps, View, compose, expose, shade};
use chiaro_image::colour::to_byte;
use chiaro_image::{Plane, filter};

/// A view of a scene with every channel.
pub(super) struct Plate {
    view: View,
    shadows: bool,
}

impl Plate {
    /// The default view of a demo scene, `height` pixels high; `knobs` say how channels are rendered.
    pub(super) fn of(scene: &str, height: usize, knobs: &BinaryKnobs, run: &Run) -> Result<Self> {
        let project = Project::open(&format!("demo:{scene}"), Options::default(), run)?;
        let shot = Shot::survey(&project, knobs, run)?.at_height(height);
        let frame = project.pose(&project.poser(), 1, run);
        let view = shot.everything(&frame, 1, run)?;
        Ok(Self { view, shadows: shot.exposure.shadows })
    }

    /// Black and white by these knobs.
    pub(super) fn ink(&self, knobs: &BinaryKnobs, run: &Run) -> Result<Plane<[u8; 3]>> {
        let views = std::slice::from_ref(&self.view);
        let exposure = expose(views, self.shadows, knobs, run)?;
        let steps = shade(&self.view, &exposure, knobs, true, run)?;
        Ok(self.picture(&steps, knobs))
    }

    /// The thesis's model, nothing but what the knobs say: no lines, no islands removed.
    pub(super) fn thesis(
        &self,
        set: impl Fn(&mut BinaryKnobs),
        run: &Run,
    ) -> Result<Plane<[u8; 3]>> {
        let mut knobs = BinaryKnobs {
            model: Model::Thesis,
            lines: false,
            island: 0.0,
            smooth: 0.0,
            floor: 0.0,
            ..BinaryKnobs::default()
        };
        set(&mut knobs);
        let steps = shade(&self.view, &Exposure::default(), &knobs, true, run)?;
        Ok(self.picture(&steps, &knobs))
    }

    fn picture(&self, steps: &Steps, knobs: &BinaryKnobs) -> Plane<[u8; 3]> {
        let marks = compose(&steps.white, &self.view.buffer.covered, &steps.lines, knobs);
        let value = |w: &f32, o: &f32| [to_byte(w * o + 1.0 - o); 3];
        marks.white.zip(&marks.opacity, value).expect("both have the picture's size")
    }

    /// A channel as grey.
    pub(super) fn channel(&self, channel: Channel) -> Plane<[u8; 3]> {
        let plane = self.view.channels.get(channel).expect("a plate has every channel");
        let grey = |v: &f32, c: &bool| [if *c { to_byte(*v) } else { 255 }; 3];
        plane.zip(&self.view.buffer.covered, grey).expect("channels have the picture's size")
    }

    /// Diffuse light thresholded at one half, after a Gaussian of `sigma` pixels.
    pub(super) fn threshold(&self, sigma: f32) -> Plane<[u8; 3]> {
        let covered = &self.view.buffer.covered;
        let plane = self.view.channels.get(Channel::Diffuse).expect("a plate has every channel");
        let soft = filter::gaussian_masked(plane, covered, sigma);
        let ink = |v: &f32, c: &bool| [if *c && *v < 0.5 { 0 } else { 255 }; 3];
        soft.zip(covered, ink).expect("channels have the picture's size")
    }
}
