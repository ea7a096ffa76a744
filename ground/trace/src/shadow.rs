//! Shadows of lamps in a picture: rays where it takes them.
//!
//! In pictures of many rows shadows are sampled at one of 2 x 2 pixels, those of lamps that stand for
//! pieces of shining surfaces at one of 8 x 8, and of 4 x 4 where those differ; in small pictures
//! those alone are sampled, at one of 2 x 2. Where the samples around a pixel lie on its smooth
//! surface and agree on a lamp, the pixel agrees with them. Elsewhere it casts its own ray, so that
//! shadows have their edge to the pixel. Not guaranteed: shadows, or gaps in them, narrower than the
//! samples are apart.

use crate::gbuffer::GBuffer;
use crate::glow::Glow;
use crate::lamps::Lamps;
use crate::light::{Arrival, Lamp};
use crate::occlusion::FINE_ROWS;
use crate::smooth::{Facet, lifted};
use crate::surroundings::{PixelSize, Surroundings};
use crate::tracer::{Ray, Tracer};
use chiaro_basis::math::Vec3;
use chiaro_basis::{Result, Run};
use chiaro_image::Plane;
use std::cell::OnceCell;

/// One bit a lamp: with more than that every pixel casts every ray.
const MOST_LAMPS: usize = u64::BITS as usize;

type Pixel = (usize, usize);

/// Which pixels of a picture lamps do not reach.
pub(crate) struct Shadows<'a> {
    tracer: &'a Tracer<'a>,
    buffer: &'a GBuffer,
    lamps: &'a [Lamp],
    glow: &'a Glow,
    /// The lamps that stand for pieces of surfaces. Only these, each one of many, are known from few
    /// samples.
    pieces: u64,
    /// The lamps that are sampled.
    told: u64,
    /// The finest samples so far.
    samples: Option<Samples>,
    size: PixelSize,
}

/// Which lamps are dark at every `step`th pixel of every `step`th row.
struct Samples {
    step: usize,
    dark: Plane<u64>,
}

/// What is known of the shadows at a pixel.
pub(crate) struct Around<'s, 'a> {
    shadows: &'s Shadows<'a>,
    pixel: Pixel,
    /// The lamps on which the samples around agree, and those that are dark.
    known: u64,
    dark: u64,
    /// Where rays start, once one does.
    start: OnceCell<Vec3>,
}

impl<'a> Shadows<'a> {
    /// Casts the rays of the samples.
    pub(crate) fn sample(
        tracer: &'a Tracer<'a>,
        buffer: &'a GBuffer,
        lamps: &'a Lamps,
        run: &Run,
    ) -> Result<Self> {
        let mut shadows = Self::new(tracer, buffer, lamps);
        let lamps = shadows.lamps;
        let pieces = shadows.pieces;
        let is_fine = buffer.size().1 > FINE_ROWS;
        if lamps.is_empty() || lamps.len() > MOST_LAMPS || !is_fine && pieces == 0 {
            return Ok(shadows);
        }
        let all = u64::MAX >> (MOST_LAMPS - lamps.len());
        let (told, steps): (u64, &[usize]) = match is_fine {
            true => (all, &[8, 4, 2]),
            false => (pieces, &[2]),
        };
        shadows.told = told;
        steps.iter().try_for_each(|step| shadows.refine(*step, run))?;
        Ok(shadows)
    }

    /// Nothing is sampled yet.
    fn new(tracer: &'a Tracer<'a>, buffer: &'a GBuffer, lamps: &'a Lamps) -> Self {
        let (lamps, glow) = (lamps.all(), lamps.glow());
        let pieces = lamps.iter().take(MOST_LAMPS).enumerate().filter(|(_, l)| l.patch.is_some());
        let pieces = pieces.fold(0, |bits, (k, _)| bits | 1 << k);
        Self {
            tracer,
            buffer,
            lamps,
            glow,
            pieces,
            told: 0,
            samples: None,
            size: PixelSize::of(buffer),
        }
    }

    /// Puts samples so many pixels apart in the place of those that are there.
    fn refine(&mut self, step: usize, run: &Run) -> Result<()> {
        let (w, h) = self.buffer.size();
        let dark = Plane::from_fn(w.div_ceil(step), h.div_ceil(step), |i, j| {
            let pixel = (i * step, j * step);
            if !self.buffer.covered[pixel] || run.check().is_err() {
                return 0;
            }
            let around = self.around(pixel);
            let believed = if self.holds(pixel) { u64::MAX } else { self.pieces };
            Around { known: around.known & believed, ..around }.all()
        });
        run.check()?;
        self.samples = Some(Samples { step, dark });
        Ok(())
    }

    /// Whether a pixel is a sample already.
    fn holds(&self, (x, y): Pixel) -> bool {
        let on = |step: usize| x.is_multiple_of(step) && y.is_multiple_of(step);
        self.samples.as_ref().is_some_and(|s| on(s.step))
    }

    /// What the samples around a pixel say.
    pub(crate) fn around(&self, pixel: Pixel) -> Around<'_, 'a> {
        let (known, dark) = self.samples.as_ref().map_or((0, 0), |s| s.agreed(self, pixel));
        Around { shadows: self, pixel, known: known & self.told, dark, start: OnceCell::new() }
    }

    /// Pixels from one sample to the next, in a picture that needs no finer ones for soft shadows.
    pub(crate) fn step(&self) -> usize {
        if self.buffer.size().1 > FINE_ROWS { 2 } else { 1 }
    }
}

impl Samples {
    /// The lamps on which the samples around a pixel agree, and those that are dark; none unless all
    /// lie on its smooth surface.
    fn agreed(&self, shadows: &Shadows<'_>, (x, y): Pixel) -> (u64, u64) {
        let (buffer, step) = (shadows.buffer, self.step);
        let (i, j) = (x / step, y / step);
        let [right, down] = [x, y].map(|p| usize::from(!p.is_multiple_of(step)));
        let here = Surroundings::at(buffer, shadows.size, (x, y), 1.0);
        let (mut all, mut any) = (u64::MAX, 0);
        for at in [(i, j), (i + right, j), (i, j + down), (i + right, j + down)] {
            if at.0 >= self.dark.width() || at.1 >= self.dark.height() {
                return (0, 0);
            }
            let pixel = (at.0 * step, at.1 * step);
            if pixel != (x, y) && !(buffer.covered[pixel] && here.holds(buffer, pixel)) {
                return (0, 0);
            }
            (all, any) = (all & self.dark[at], any | self.dark[at]);
        }
        (!(all ^ any), all)
    }
}

impl Around<'_, '_> {
    /// Whether something stands between the pixel, whose position is given, and a lamp.
    pub(crate) fn is_dark(&self, lamp: usize, position: Vec3) -> bool {
        if lamp < MOST_LAMPS && self.known >> lamp & 1 == 1 {
            return self.dark >> lamp & 1 == 1;
        }
        let arrival = self.shadows.lamps[lamp].arrival(position);
        arrival.is_none_or(|arrival| self.is_in_shadow(lamp, &arrival))
    }

    /// The sampled lamps whose light does not reach the pixel, whichever way bumps turn it.
    fn all(&self) -> u64 {
        let Shadows { buffer, lamps, told, .. } = self.shadows;
        let position = Vec3::from(buffer.position[self.pixel]);
        let smooth = Vec3::from(buffer.smooth_normal[self.pixel]);
        let unknown = |k: &usize| told & !self.known & 1 << k != 0;
        let dark = |k: &usize| !lamps[*k].is_before(position, smooth) || self.is_dark(*k, position);
        let found = (0..lamps.len()).filter(unknown).filter(dark);
        found.fold(self.known & self.dark, |bits, k| bits | 1 << k)
    }

    /// Whether something stands between the pixel's surface and the light. The ray starts on the smooth
    /// surface that the vertex normals span (Hanika 2021), or coarse meshes show saw-tooth
    /// terminators.
    fn is_in_shadow(&self, lamp: usize, arrival: &Arrival) -> bool {
        let Shadows { tracer, buffer, lamps, glow, .. } = self.shadows;
        let smooth = Vec3::from(buffer.smooth_normal[self.pixel]);
        if smooth.dot(arrival.towards) <= 0.0 {
            return true;
        }
        let start = *self.start.get_or_init(|| {
            let facet = Facet::of(tracer, buffer, self.pixel);
            lifted(&facet, buffer, self.pixel) + smooth * tracer.offset()
        });
        if !arrival.from_surface {
            let reach = arrival.distance * (1.0 - 1e-4);
            let ray = Ray { origin: start, direction: arrival.towards, t_max: reach };
            return tracer.occluded(&ray);
        }
        // To the very point, or the surface that shines would stand in its own way.
        let end = Vec3::from(buffer.position[self.pixel]) + arrival.towards * arrival.distance;
        let (direction, length) = (end - start).normalize_and_length();
        let ray = Ray { origin: start, direction, t_max: length * (1.0 - 1e-3) };
        let is_round = lamps[lamp].patch.is_some_and(|p| p.shown.round > 0.0);
        if is_round { !glow.is_free(tracer, &ray, &lamps[lamp]) } else { tracer.occluded(&ray) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surface::Surfaces;
    use crate::view::Framing;
    use chiaro_scene::{Playback, Poser, demo};

    #[test]
    fn shadows_by_samples_are_those_by_all_rays() {
        let scene = demo::scene("courtyard").unwrap();
        let frame = Poser::new(&scene).frame(0.0, &Playback::default());
        let (tracer, surfaces) = (Tracer::new(&scene, &frame), Surfaces::new(&scene));
        let pose = Framing::of(&tracer, std::slice::from_ref(&frame)).view(1.0, 0.0).0;
        let run = Run::default();
        let buffer = GBuffer::trace(&tracer, &surfaces, &pose, (300, 300), &run).unwrap();
        let sun = Lamp::key(&pose);
        let lamps = Lamps::of(vec![sun]);
        let every = Shadows::new(&tracer, &buffer, &lamps);
        let mut few = Shadows { told: 1, ..Shadows::new(&tracer, &buffer, &lamps) };
        [8, 4, 2].into_iter().try_for_each(|step| few.refine(step, &run)).unwrap();
        let (mut all, mut known, mut wrong) = (0u32, 0u32, 0u32);
        for i in (0..90_000).filter(|i| buffer.covered.pixels()[*i]) {
            let pixel = (i % 300, i / 300);
            let position = Vec3::from(buffer.position[pixel]);
            let (truth, guess) = (every.around(pixel), few.around(pixel));
            all += 1;
            known += (guess.known & 1) as u32;
            wrong += u32::from(guess.is_dark(0, position) != truth.is_dark(0, position));
        }
        let [known, wrong] = [known, wrong].map(|n| n as f32 / all as f32);
        assert!(known > 0.7 && wrong < 0.003, "{known} {wrong}");
    }
}
