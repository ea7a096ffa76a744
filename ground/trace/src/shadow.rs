//! Shadows of lamps in a picture: rays where it takes them.
//!
//! In pictures of many rows shadows are sampled at one of 2 x 2 pixels, those of lamps that stand for
//! pieces of shining surfaces at one of 8 x 8, and of 4 x 4 where those differ; in small pictures
//! those alone are sampled, at one of 2 x 2. Where the samples around a pixel lie on its smooth
//! surface and agree on a lamp, the pixel agrees with them; elsewhere it casts its own ray. So every
//! shadow has its edge to the pixel. Not guaranteed: shadows, or gaps in them, narrower than the
//! samples are apart.

use crate::gbuffer::GBuffer;
use crate::light::{Arrival, Lamp};
use crate::occlusion::FINE_ROWS;
use crate::smooth::{Facet, lifted};
use crate::surroundings::Surroundings;
use crate::tracer::{Ray, Tracer};
use chiaro_basis::math::Vec3;
use chiaro_basis::{Result, Run};
use chiaro_image::Plane;

/// One bit a lamp: with more than that every pixel casts every ray.
const MOST_LAMPS: usize = u64::BITS as usize;

type Pixel = (usize, usize);

/// Which pixels of a picture lamps do not reach.
pub(crate) struct Shadows<'a> {
    tracer: &'a Tracer<'a>,
    buffer: &'a GBuffer,
    lamps: &'a [Lamp],
    /// The finest samples so far, and of which lamps they tell all.
    samples: Option<Samples>,
    told: u64,
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
}

impl<'a> Shadows<'a> {
    /// Casts the rays of the samples.
    pub(crate) fn sample(
        tracer: &'a Tracer<'a>,
        buffer: &'a GBuffer,
        lamps: &'a [Lamp],
        run: &Run,
    ) -> Result<Self> {
        let mut shadows = Self { tracer, buffer, lamps, samples: None, told: 0 };
        if lamps.len() > MOST_LAMPS {
            return Ok(shadows);
        }
        if buffer.size().1 > FINE_ROWS {
            shadows.take_samples(&[8, 4, 2], run)?;
            shadows.told = u64::MAX;
        } else if shadows.pieces() != 0 {
            shadows.take_samples(&[2], run)?;
            shadows.told = shadows.pieces();
        }
        Ok(shadows)
    }

    /// The lamps that stand for pieces of surfaces. Only these, each one of many, are known from few
    /// samples.
    fn pieces(&self) -> u64 {
        let pieces = self.lamps.iter().enumerate().filter(|(_, l)| l.patch.is_some());
        pieces.fold(0, |bits, (k, _)| bits | 1 << k)
    }

    /// Samples so many pixels apart, finer and finer, the last ones where they are to be.
    fn take_samples(&mut self, steps: &[usize], run: &Run) -> Result<()> {
        let pieces = self.pieces();
        steps.iter().try_for_each(|step| self.refine(*step, pieces, run))
    }

    /// Puts samples in the place of those that are there, which are believed of some lamps.
    fn refine(&mut self, step: usize, believed: u64, run: &Run) -> Result<()> {
        let (w, h) = self.buffer.size();
        let dark = Plane::from_fn(w.div_ceil(step), h.div_ceil(step), |i, j| {
            let pixel = (i * step, j * step);
            if !self.buffer.covered[pixel] || run.check().is_err() {
                return 0;
            }
            let around = self.surrounded(pixel);
            let believed = if self.holds(pixel) { u64::MAX } else { believed };
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

    /// What is known of a pixel from the samples around it.
    pub(crate) fn around(&self, pixel: Pixel) -> Around<'_, 'a> {
        let around = self.surrounded(pixel);
        let told = if self.holds(pixel) { u64::MAX } else { self.told };
        Around { known: around.known & told, ..around }
    }

    /// What the samples around a pixel say.
    fn surrounded(&self, pixel: Pixel) -> Around<'_, 'a> {
        let [known, dark] = self.samples.as_ref().map_or([0; 2], |s| s.agreed(self.buffer, pixel));
        Around { shadows: self, pixel, known, dark }
    }
}

impl Samples {
    /// The lamps on which the samples around a pixel agree, and those that are dark.
    fn agreed(&self, buffer: &GBuffer, (x, y): Pixel) -> [u64; 2] {
        let step = self.step;
        let (i, j) = (x / step, y / step);
        let [across, down] = [x, y].map(|p| usize::from(!p.is_multiple_of(step)));
        if (across, down) == (0, 0) {
            return [u64::MAX, self.dark[(i, j)]];
        }
        if i + across >= self.dark.width() || j + down >= self.dark.height() {
            return [0; 2];
        }
        let here = Surroundings::at(buffer, (x, y), step as f32);
        let (mut all, mut any) = (u64::MAX, 0);
        for (u, v) in [(0, 0), (across, 0), (0, down), (across, down)] {
            let at = (i + u, j + v);
            let pixel = (at.0 * step, at.1 * step);
            if !buffer.covered[pixel] || !here.holds(buffer, pixel) {
                return [0; 2];
            }
            all &= self.dark[at];
            any |= self.dark[at];
        }
        [!(all ^ any), all]
    }
}

impl Around<'_, '_> {
    /// Whether something stands between the pixel, whose position is given, and a lamp.
    pub(crate) fn is_dark(&self, lamp: usize, position: Vec3) -> bool {
        if lamp < MOST_LAMPS && self.known >> lamp & 1 == 1 {
            return self.dark >> lamp & 1 == 1;
        }
        let Shadows { tracer, buffer, lamps, .. } = self.shadows;
        let arrival = lamps[lamp].arrival(position);
        arrival.is_none_or(|arrival| in_shadow(tracer, buffer, self.pixel, &arrival))
    }

    /// The lamps whose light does not reach the pixel, whichever way bumps turn it.
    fn all(&self) -> u64 {
        let position = Vec3::from(self.shadows.buffer.position[self.pixel]);
        let unknown = |k: &usize| self.known >> k & 1 == 0;
        let smooth = Vec3::from(self.shadows.buffer.smooth_normal[self.pixel]);
        let dark = |k: &usize| {
            let lamp = &self.shadows.lamps[*k];
            !lamp.is_before(position, smooth) || self.is_dark(*k, position)
        };
        let found = (0..self.shadows.lamps.len()).filter(unknown).filter(dark);
        found.fold(self.known & self.dark, |bits, k| bits | 1 << k)
    }
}

/// Whether something stands between a pixel's surface and the light. The ray starts on the smooth
/// surface that the vertex normals span (Hanika 2021), or coarse meshes show saw-tooth
/// terminators.
fn in_shadow(tracer: &Tracer, buffer: &GBuffer, pixel: (usize, usize), arrival: &Arrival) -> bool {
    let smooth = Vec3::from(buffer.smooth_normal[pixel]);
    if smooth.dot(arrival.towards) <= 0.0 {
        return true;
    }
    let lift = lifted(&Facet::of(tracer, buffer, pixel), buffer, pixel);
    let start = lift + smooth * tracer.offset();
    if !arrival.from_surface {
        let reach = arrival.distance * (1.0 - 1e-4);
        return tracer.occluded(&Ray { origin: start, direction: arrival.towards, t_max: reach });
    }
    // To the very point, or the surface that shines would stand in its own way.
    let end = Vec3::from(buffer.position[pixel]) + arrival.towards * arrival.distance;
    let (direction, length) = (end - start).normalize_and_length();
    tracer.occluded(&Ray { origin: start, direction, t_max: length * (1.0 - 1e-3) })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::light::Patch;
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
        let lamps =
            [sun, Lamp { patch: Some(Patch { area: 1.0, two_sided: false, object: 0 }), ..sun }];
        let every =
            Shadows { tracer: &tracer, buffer: &buffer, lamps: &lamps, samples: None, told: 0 };
        let mut few = Shadows { samples: None, told: u64::MAX, ..every };
        few.take_samples(&[8, 4, 2], &run).unwrap();
        let [mut all, mut known, mut wrong] = [[0u32; 2]; 3];
        for i in (0..90_000).filter(|i| buffer.covered.pixels()[*i]) {
            let pixel = (i % 300, i / 300);
            let (truth, guess) = (every.around(pixel).all(), few.around(pixel));
            for lamp in 0..2 {
                all[lamp] += 1;
                known[lamp] += (guess.known >> lamp & 1) as u32;
                wrong[lamp] += ((guess.all() ^ truth) >> lamp & 1) as u32;
            }
        }
        let share = |n: [u32; 2]| [0, 1].map(|l| n[l] as f32 / all[l] as f32);
        let (known, wrong) = (share(known), share(wrong));
        assert!(
            known.iter().all(|k| *k > 0.7) && wrong[0] < 0.003 && wrong[1] < 0.01,
            "{known:?} {wrong:?}"
        );
    }
}
