//! [`Plate`]: one view of a demo scene, ready to be drawn with many settings.

use crate::binary::{Shot, counts, draw};
use crate::colours::Colours;
use crate::project::{Options, Project};
use chiaro_basis::{Result, Run};
use chiaro_binary::{
    BinaryKnobs, Border, Channel, Exposure, FeaturePairs, Lines, Marks, Method, Model, Steps, View,
    compose, expose, image_bonds, mixed_tone, neighbour_factors, shade, weigh,
};
use chiaro_image::colour::to_byte;
use chiaro_image::{Plane, filter};
use std::time::Instant;

/// A view of a scene with every channel.
pub(super) struct Plate {
    view: View,
    shadows: bool,
}

impl Plate {
    /// The default view of a demo scene, `height` pixels high; `knobs` say how channels are rendered.
    pub(super) fn of(scene: &str, height: usize, knobs: &BinaryKnobs, run: &Run) -> Result<Self> {
        Self::open(&format!("demo:{scene}"), height, knobs, run)
    }

    /// The default view of any scene.
    pub(super) fn open(scene: &str, height: usize, knobs: &BinaryKnobs, run: &Run) -> Result<Self> {
        let project = Project::open(scene, Options::default(), run)?;
        let shot = Shot::survey(&project, knobs, run)?.at_height(height);
        let frame = project.pose(&project.poser(), 1, run);
        let view = shot.everything(&frame, 1, run)?;
        Ok(Self { view, shadows: shot.exposure.shadows })
    }

    fn exposure(&self, knobs: &BinaryKnobs, run: &Run) -> Result<Exposure> {
        expose(std::slice::from_ref(&self.view), self.shadows, knobs, run)
    }

    fn steps(&self, knobs: &BinaryKnobs, run: &Run) -> Result<Steps> {
        shade(&self.view, &self.exposure(knobs, run)?, knobs, true, run)
    }

    /// Black and white by these knobs.
    pub(super) fn ink(&self, knobs: &BinaryKnobs, run: &Run) -> Result<Plane<[u8; 3]>> {
        let knobs = &knobs.resolved();
        Ok(self.picture(&self.steps(knobs, run)?, knobs))
    }

    /// [`Plate::ink`] with its share of border on features beyond chance, and its islands.
    pub(super) fn ours(
        &self,
        knobs: &BinaryKnobs,
        run: &Run,
    ) -> Result<(Plane<[u8; 3]>, [f64; 2])> {
        let steps = self.steps(knobs, run)?;
        let islands = islands(&steps.white, &self.view.buffer.covered);
        Ok((self.picture(&steps, knobs), [steps.border.beyond_chance(), islands]))
    }

    /// The same by a baseline.
    pub(super) fn baseline(
        &self,
        method: Method,
        knobs: &BinaryKnobs,
        run: &Run,
    ) -> Result<(Plane<[u8; 3]>, [f64; 2])> {
        let covered = &self.view.buffer.covered;
        let white = method.regions(&self.view, &self.exposure(knobs, run)?, knobs)?;
        let pairs = FeaturePairs::of(&neighbour_factors(&self.view.buffer, knobs));
        let border = Border::measure(&white, covered, &pairs);
        let lines = method.lines(&self.view, &white, true);
        let region = white.map(|w| f32::from(u8::from(*w)));
        let plain = BinaryKnobs { smooth: 0.0, ..knobs.clone() };
        let marks = compose(&region, covered, &lines, &plain);
        Ok((grey(&marks), [border.beyond_chance(), islands(&white, covered)]))
    }

    /// The tone after levels.
    pub(super) fn tone(&self, knobs: &BinaryKnobs, run: &Run) -> Result<Plane<[u8; 3]>> {
        let exposure = self.exposure(knobs, run)?;
        let covered = &self.view.buffer.covered;
        let tone = mixed_tone(&self.view.channels, covered, knobs);
        let value = |t: &f32, c: &bool| [if *c { to_byte(exposure.stretch(*t)) } else { 255 }; 3];
        tone.zip(covered, value)
    }

    /// The sum of each pixel's neighbour weights as grey, from the tone's own steps or geometry.
    pub(super) fn bonds(
        &self,
        knobs: &BinaryKnobs,
        of_image: bool,
        run: &Run,
    ) -> Result<Plane<[u8; 3]>> {
        let covered = &self.view.buffer.covered;
        let factors = if of_image {
            let exposure = self.exposure(knobs, run)?;
            let tone = mixed_tone(&self.view.channels, covered, knobs);
            image_bonds(&tone.map(|t| exposure.stretch(*t)), covered)
        } else {
            neighbour_factors(&self.view.buffer, knobs)
        };
        let value = |f: &[f32; 4], c: &bool| {
            [if *c { to_byte(0.25 * f.iter().sum::<f32>()) } else { 255 }; 3]
        };
        factors.zip(covered, value)
    }

    /// Lines on white.
    pub(super) fn lines_alone(&self, run: &Run) -> Result<Plane<[u8; 3]>> {
        run.check()?;
        let (knobs, covered) = (BinaryKnobs::default(), &self.view.buffer.covered);
        let lines = Lines::find(&self.view.buffer, &covered.map(|_| true), true, &knobs);
        Ok(grey(&compose(&covered.map(|_| 1.0), covered, &lines, &knobs)))
    }

    /// In the colours of the knobs' palette.
    pub(super) fn coloured(&self, knobs: &BinaryKnobs, run: &Run) -> Result<Plane<[u8; 3]>> {
        let colours = Colours::default();
        let exposure = self.exposure(knobs, run)?;
        Ok(draw(&self.view, &exposure, knobs, (&colours, None), run)?.displayed(&colours))
    }

    /// Seconds for the weights and for the cut, the best of three.
    pub(super) fn seconds(&self, knobs: &BinaryKnobs, run: &Run) -> Result<[f64; 2]> {
        let mut best = [f64::INFINITY; 2];
        for _ in 0..3 {
            let start = Instant::now();
            let weights = weigh(&self.view, &Exposure::default(), knobs, run)?;
            let filled = Instant::now();
            weights.graph.solve()?;
            let parts = [(filled - start).as_secs_f64(), filled.elapsed().as_secs_f64()];
            best = [best[0].min(parts[0]), best[1].min(parts[1])];
        }
        Ok(best)
    }

    /// Covered pixels.
    pub(super) fn nodes(&self) -> usize {
        self.view.buffer.covered.pixels().iter().filter(|c| **c).count()
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
        grey(&compose(&steps.region, &self.view.buffer.covered, &steps.lines, knobs))
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

/// Marks over white.
fn grey(marks: &Marks) -> Plane<[u8; 3]> {
    let value = |w: &f32, o: &f32| [to_byte(w * o + 1.0 - o); 3];
    marks.white.zip(&marks.opacity, value).expect("both have the picture's size")
}

/// Pieces under 30 pixels at 480 that touch the other colour.
fn islands(white: &Plane<bool>, covered: &Plane<bool>) -> f64 {
    counts::shape(white, covered)["islands_under_30px"].as_f64().unwrap_or(0.0)
}
