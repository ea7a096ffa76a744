//! [`Plate`]: one view of a demo scene, ready to be drawn with many settings.

use crate::binary::{Look, Shot, counts, draw};
use crate::colours::Colours;
use crate::given;
use crate::project::{Options, Project};
use crate::style::Style;
use chiaro_basis::math::Vec3;
use chiaro_basis::{Result, Run};
use chiaro_binary::{
    BinaryKnobs, Border, Channel, Channels, Exposure, FeaturePairs, Lines, Marks, Method, Model,
    Paint, Steps, Strokes, View, compose, expose, image_bonds, mixed_tone, neighbour_factors,
    prepare, shade, weigh,
};
use chiaro_image::colour::{srgb_encode, to_byte};
use chiaro_image::{Plane, filter};
use std::borrow::Cow;
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
        let picture = draw((self.view.clone(), None), &exposure, knobs, (&colours, None), run)?;
        Ok(picture.displayed(&colours))
    }

    /// Black and white with strokes painted: with what share of the weights learned from them.
    pub(super) fn painted(
        &self,
        strokes: &Strokes,
        blend: f32,
        knobs: &BinaryKnobs,
        run: &Run,
    ) -> Result<Plane<[u8; 3]>> {
        let (view, covered) = (&self.view, &self.view.buffer.covered);
        let drawn = strokes.drawn(covered.size(), 1);
        // Strokes teach by what the style looks at; the plate holds every channel there is.
        let mut channels = Channels::default();
        for channel in Channel::ALL.into_iter().filter(|c| c.is_used(knobs)) {
            if let Some(plane) = view.channels.get(channel) {
                channels.set(channel, plane.clone());
            }
        }
        let paint = Paint::learn(drawn, &channels, covered, blend);
        let exposure = self.exposure(knobs, run)?;
        let prepared = prepare(Cow::Borrowed(view), &exposure, knobs, Some(&paint), run)?;
        let steps = prepared.cut(Some(&paint), true, knobs, run)?;
        Ok(self.picture(&steps, knobs))
    }

    /// Strokes over a picture of this plate: green where they make white, blue where black.
    pub(super) fn under_strokes(
        &self,
        picture: &Plane<[u8; 3]>,
        strokes: &Strokes,
    ) -> Result<Plane<[u8; 3]>> {
        let drawn = strokes.drawn(picture.size(), 1);
        let over = |p: &[u8; 3], d: &Option<bool>| match d {
            Some(true) => [40, 190, 70],
            Some(false) => [50, 80, 220],
            None => p.map(|v| 128 + v / 2),
        };
        picture.zip(&drawn, over)
    }

    /// The view as a colour image with normals in the camera's axes and a map of its depth steps: the
    /// input of [`given::rgbn`], shaded.
    pub(super) fn rgbn(&self, knobs: &BinaryKnobs, run: &Run) -> Result<[Plane<[u8; 3]>; 3]> {
        let buffer = &self.view.buffer;
        let light = self.view.channels.get(Channel::Half).expect("a plate has every channel");
        let (w, h) = buffer.size();
        let colour = Plane::from_fn(w, h, |x, y| {
            let at = (x, y);
            let [r, g, b] = buffer.base_colour[at].map(|c| c * light[at]);
            if buffer.covered[at] { [r, g, b, 1.0] } else { [0.0; 4] }
        });
        let pose = &buffer.pose;
        let normal = Plane::from_fn(w, h, |x, y| {
            let n = Vec3::from(buffer.normal[(x, y)]);
            [n.dot(pose.right), n.dot(pose.up), -n.dot(pose.forward)]
        });
        let steps = BinaryKnobs { line_crease: 181.0, line_width: 3.0, ..BinaryKnobs::default() };
        let lines = Lines::find(buffer, &buffer.covered.map(|_| true), true, &steps);
        let map = chiaro_ink::draw(&lines.black, (w, h), lines.width);
        let shown = [
            colour.map(|[r, g, b, a]| [*r, *g, *b].map(|v| to_byte(srgb_encode(v) * a + 1.0 - a))),
            normal.zip(&buffer.covered, |n, c| {
                n.map(|v| if *c { to_byte(0.5 * v + 0.5) } else { 255 })
            })?,
        ];
        let mut style = Style::find("ink")?;
        style.binary = knobs.clone();
        let picture = given::rgbn(colour, normal, &map, &Look::of(&style), run)?;
        let [a, b] = shown;
        Ok([a, b, picture.displayed(&Colours::default())])
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
        let soft = filter::gaussian_covered(plane, covered, sigma);
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
