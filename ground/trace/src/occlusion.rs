//! Ambient occlusion: the cosine-weighted share of the hemisphere that is open.
//!
//! 1. A sample is taken at every pixel, in large pictures at every second to fourth of every such row. A set of cosine-weighted
//!    directions, low in discrepancy, is dealt to the 64 samples of an 8 x 8 tile, so that each casts
//!    few rays and no two of a tile cast the same.
//! 2. Samples are averaged over the 8 x 8 window around each, which holds every share of the
//!    deal once: first over 4 x 4, then over four such means. What lies off the sample's plane or is
//!    turned away is left out.
//! 3. Where openness changes slowly such means are averaged once more, over those of about the same:
//!    a threshold in a slow gradient shows every hundredth of noise as a tooth of its border.
//! 4. A pixel takes the bilinear mean of the samples around it that lie on its surface. Without any (thin
//!    things in large pictures) it casts its own rays.
//!
//! Rays start on the smooth surface that the vertex normals span, and those that are flatter than
//! facets deviate from it count as open: the facets of a smooth surface do not darken each other.
//!
//! Guaranteed: deterministic, and free of noise on smooth surfaces, since every window holds the
//! whole set. Not guaranteed: on surfaces a few pixels wide, fewer directions are left.

use crate::gbuffer::GBuffer;
use crate::smooth::{Facet, lifted};
use crate::surroundings::Surroundings;
use crate::tracer::{Ray, Tracer};
use chiaro_basis::math::Vec3;
use chiaro_basis::{Result, Run, random};
use chiaro_image::Plane;

/// Samples along a tile's side.
const TILE: usize = 8;
/// Means that are averaged once more, along a side and so many samples apart; none that differs by more.
const SOFT: usize = 5;
const SPACING: isize = 4;
const ALIKE: f32 = 0.06;
/// Pictures with more rows than this have fewer samples than pixels.
pub(crate) const FINE_ROWS: usize = 640;

/// Pixels between samples in a picture of so many rows: openness is smooth, and more than some 500 rows
/// of it show nothing more.
fn step(rows: usize) -> usize {
    1 + [FINE_ROWS, 960, 1920].into_iter().filter(|most| rows > *most).count()
}

/// Openness in [0, 1] within `radius` scene units; `rays` are cast a sample, 64 times as many count.
pub fn ambient_occlusion(
    tracer: &Tracer,
    buffer: &GBuffer,
    radius: f32,
    rays: usize,
    run: &Run,
) -> Result<Plane<f32>> {
    let caster = Caster { tracer, buffer, radius, deal: deal(rays) };
    let samples = Samples::take(&caster, run)?;
    let soft = samples.softened(&samples.windows(&samples.means(buffer), buffer), buffer);
    run.check()?;
    let plane = buffer.over_covered(|x, y| {
        if run.check().is_err() {
            return 0.0;
        }
        samples.between(&soft, buffer, (x, y)).unwrap_or_else(|| caster.whole((x, y)))
    });
    run.check()?;
    Ok(plane)
}

/// Directions around +z for each sample of a tile. Consecutive points of the sequence go to far
/// samples, so that each share is spread as well as the whole.
fn deal(rays: usize) -> Vec<Vec<Vec3>> {
    let place = |i: usize| {
        // Bits of x and y, interleaved and reversed: neighbours start far from each other.
        let (x, y) = (i % TILE, i / TILE);
        (0..TILE.ilog2()).fold(0, |n, bit| n << 2 | ((x ^ y) >> bit & 1) << 1 | (y >> bit & 1))
    };
    (0..TILE * TILE)
        .map(|i| (0..rays).map(|k| cosine_direction(place(i) + k * TILE * TILE)).collect())
        .collect()
}

/// Point `index` of a low-discrepancy, cosine-weighted set on the hemisphere around +z.
fn cosine_direction(index: usize) -> Vec3 {
    let [u, v] = random::r2(index as u64);
    let (r, angle) = (u.sqrt(), std::f32::consts::TAU * v);
    Vec3::new(r * angle.cos(), r * angle.sin(), (1.0 - u).sqrt())
}

/// What rays need.
struct Caster<'a> {
    tracer: &'a Tracer<'a>,
    buffer: &'a GBuffer,
    radius: f32,
    deal: Vec<Vec<Vec3>>,
}

impl Caster<'_> {
    /// The open share of some directions at a pixel.
    fn openness<'d>(
        &self,
        pixel: (usize, usize),
        directions: impl Iterator<Item = &'d Vec3>,
    ) -> f32 {
        let buffer = self.buffer;
        let normal = Vec3::from(buffer.normal[pixel]);
        let side = Vec3::from(buffer.geometric_normal[pixel]);
        let facet = Facet::of(self.tracer, buffer, pixel);
        let origin = lifted(&facet, buffer, pixel) + side * self.tracer.offset();
        let horizon = facet.deviation();
        let (right, up) = normal.any_orthonormal_pair();
        let (mut open, mut all) = (0usize, 0usize);
        for d in directions {
            let direction = right * d.x + up * d.y + normal * d.z;
            all += 1;
            // Below the horizon there is nothing to see but the surface itself.
            let is_open = direction.dot(side) <= horizon
                || !self.tracer.occluded(&Ray { origin, direction, t_max: self.radius });
            open += usize::from(is_open);
        }
        open as f32 / all.max(1) as f32
    }

    /// A pixel that nobody helps, by as many rays as count elsewhere in a quarter of the window.
    fn whole(&self, pixel: (usize, usize)) -> f32 {
        self.openness(pixel, self.deal.iter().step_by(4).flatten())
    }
}

/// Openness at samples.
struct Samples {
    /// Pixels between samples.
    step: usize,
    raw: Plane<f32>,
}

impl Samples {
    fn take(caster: &Caster, run: &Run) -> Result<Self> {
        let (w, h) = caster.buffer.size();
        let step = step(h);
        let raw = Plane::from_fn(w.div_ceil(step), h.div_ceil(step), |i, j| {
            let pixel = (i * step, j * step);
            if !caster.buffer.covered[pixel] || run.check().is_err() {
                return 0.0;
            }
            let share = &caster.deal[j % TILE * TILE + i % TILE];
            caster.openness(pixel, share.iter())
        });
        run.check()?;
        Ok(Self { step, raw })
    }

    /// The pixel of a sample, if it is in the picture and covered.
    fn pixel(&self, buffer: &GBuffer, i: isize, j: isize) -> Option<(usize, usize)> {
        self.raw.at(i, j)?;
        let at = (i as usize * self.step, j as usize * self.step);
        buffer.covered[at].then_some(at)
    }

    /// At each sample the mean over 4 x 4 samples on its surface.
    fn means(&self, buffer: &GBuffer) -> Plane<f32> {
        let (w, h) = self.raw.size();
        Plane::from_fn(w, h, |i, j| {
            let (i, j) = (i as isize, j as isize);
            let Some(at) = self.pixel(buffer, i, j) else { return 0.0 };
            let patch = Surroundings::at(buffer, at, 2.0 * self.step as f32);
            let (mut sum, mut count) = (0.0, 0.0);
            for v in j - 2..j + 2 {
                for u in i - 2..i + 2 {
                    if self.pixel(buffer, u, v).is_some_and(|p| patch.holds(buffer, p)) {
                        sum += self.raw[(u as usize, v as usize)];
                        count += 1.0;
                    }
                }
            }
            // A sample is on its own surface.
            sum / f32::max(count, 1.0)
        })
    }

    /// At each sample the mean over 8 x 8 samples on its surface, from those over 4 x 4.
    fn windows(&self, near: &Plane<f32>, buffer: &GBuffer) -> Plane<f32> {
        self.over_surface(buffer, 3.0, |at, holds| {
            let (mut sum, mut count) = (0.0, 0.0);
            for offset in [(-2, -2), (2, -2), (-2, 2), (2, 2)] {
                if let Some(p) = holds(offset) {
                    sum += near[p];
                    count += 1.0;
                }
            }
            if count > 0.0 { sum / count } else { near[at] }
        })
    }

    /// At each sample the mean of the windows around it that are about as open.
    fn softened(&self, windows: &Plane<f32>, buffer: &GBuffer) -> Plane<f32> {
        // The outer ones by half: their windows overlap by half.
        let share = |k: usize| if k == 0 || k == SOFT - 1 { 0.5 } else { 1.0 };
        self.over_surface(buffer, 4.0, |at, holds| {
            let own = windows[at];
            let (mut sum, mut weights) = (own, 1.0);
            for i in (0..SOFT * SOFT).filter(|i| *i != SOFT * SOFT / 2) {
                let away = |k: usize| SPACING * (k as isize - SOFT as isize / 2);
                let Some(p) = holds((away(i % SOFT), away(i / SOFT))) else { continue };
                let apart = (windows[p] - own) / ALIKE;
                let weight = share(i % SOFT) * share(i / SOFT) * (1.0 - apart * apart).max(0.0);
                sum += weight * windows[p];
                weights += weight;
            }
            sum / weights
        })
    }

    /// A value at each covered sample, from its place and from places by their offsets, in samples, that
    /// lie on its surface within so many samples of its plane.
    fn over_surface(
        &self,
        buffer: &GBuffer,
        reach: f32,
        value: impl Fn((usize, usize), &dyn Fn((isize, isize)) -> Option<(usize, usize)>) -> f32 + Sync,
    ) -> Plane<f32> {
        let (w, h) = self.raw.size();
        Plane::from_fn(w, h, |i, j| {
            let Some(pixel) = self.pixel(buffer, i as isize, j as isize) else { return 0.0 };
            let patch = Surroundings::at(buffer, pixel, reach * self.step as f32);
            value((i, j), &|(u, v)| {
                let (u, v) = (i as isize + u, j as isize + v);
                let on = self.pixel(buffer, u, v).is_some_and(|p| patch.holds(buffer, p));
                on.then_some((u as usize, v as usize))
            })
        })
    }

    /// The bilinear mean of the samples around a pixel that lie on its surface, `None` where none does.
    fn between(&self, soft: &Plane<f32>, buffer: &GBuffer, (x, y): (usize, usize)) -> Option<f32> {
        let (i, j) = (x / self.step, y / self.step);
        let [across, down] = [x, y].map(|p| (p % self.step) as f32 / self.step as f32);
        if across == 0.0 && down == 0.0 {
            return Some(soft[(i, j)]);
        }
        let patch = Surroundings::at(buffer, (x, y), 3.0 * self.step as f32);
        let (mut sum, mut weights) = (0.0, 0.0);
        for (u, v) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
            let along = |far: usize, t: f32| if far == 1 { t } else { 1.0 - t };
            // All around count where those of a row or column do not lie on the surface.
            let weight = (along(u, across) * along(v, down)).max(1e-3);
            let (u, v) = (i + u, j + v);
            let pixel = self.pixel(buffer, u as isize, v as isize);
            if pixel.is_some_and(|p| patch.holds(buffer, p)) {
                sum += weight * soft[(u, v)];
                weights += weight;
            }
        }
        (weights > 0.0).then(|| sum / weights)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surface::Surfaces;
    use crate::view::Framing;
    use chiaro_scene::{Playback, Poser, demo};

    #[test]
    fn slow_gradients_are_smooth_and_keep_their_openness() {
        let scene = demo::scene("cornell-box").unwrap();
        let frame = Poser::new(&scene).frame(0.0, &Playback::default());
        let (tracer, surfaces) = (Tracer::new(&scene, &frame), Surfaces::new(&scene));
        let pose = Framing::of(&tracer, std::slice::from_ref(&frame)).view(1.0, 0.0).0;
        let run = Run::default();
        let buffer = GBuffer::trace(&tracer, &surfaces, &pose, (400, 400), &run).unwrap();
        let caster =
            Caster { tracer: &tracer, buffer: &buffer, radius: 0.6 * buffer.radius, deal: deal(8) };
        let samples = Samples::take(&caster, &run).unwrap();
        let windows = samples.windows(&samples.means(&buffer), &buffer);
        let soft = samples.softened(&windows, &buffer);
        // The median bend of the openness over five pixels of one flat face.
        let rough = |plane: &Plane<f32>| {
            let flat = |x: usize, y: usize| {
                let patch = Surroundings::at(&buffer, (x, y), 0.1);
                (x - 2..=x + 2).all(|u| buffer.covered[(u, y)] && patch.holds(&buffer, (u, y)))
            };
            let places = (0..400).flat_map(|y| (2..398).map(move |x| (x, y)));
            let mut bends: Vec<f32> = places
                .filter(|&(x, y)| flat(x, y))
                .map(|(x, y)| plane[(x - 2, y)] + plane[(x + 2, y)] - 2.0 * plane[(x, y)])
                .map(f32::abs)
                .collect();
            assert!(bends.len() > 10_000);
            bends.sort_by(f32::total_cmp);
            bends[bends.len() / 2]
        };
        let (before, after) = (rough(&windows), rough(&soft));
        assert!(after < 0.7 * before, "{before} {after}");
        let moved = windows.pixels().iter().zip(soft.pixels()).map(|(a, b)| (a - b).abs());
        assert!(moved.fold(0.0, f32::max) < ALIKE);
    }

    #[test]
    fn every_tile_holds_the_whole_cosine_weighted_set() {
        let deal = deal(4);
        let mut all: Vec<Vec3> = deal.into_iter().flatten().collect();
        let mean = all.iter().sum::<Vec3>() / all.len() as f32;
        assert!((mean - Vec3::new(0.0, 0.0, 2.0 / 3.0)).length() < 0.01, "{mean}");
        assert!(all.iter().all(|d| (d.length() - 1.0).abs() < 1e-5 && d.z >= 0.0));
        all.sort_by(|a, b| a.to_array().partial_cmp(&b.to_array()).unwrap());
        all.dedup();
        assert_eq!(all.len(), 256);
    }
}
