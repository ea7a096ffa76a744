//! Ambient occlusion: the cosine-weighted share of the hemisphere that is open.
//!
//! 1. A sample is taken at every pixel, in large pictures at every second to fourth of every such row. A set of cosine-weighted
//!    directions, low in discrepancy, is dealt to the 64 samples of an 8 x 8 tile, so that each casts
//!    few rays and no two of a tile cast the same.
//! 2. Samples are averaged over the 8 x 8 window around each pixel, which holds every share of the
//!    deal once: first over 4 x 4, then over four such means. What lies off the pixel's plane or is
//!    turned away is left out. Between samples the window slides on by fractions.
//! 3. A pixel without a sample on its surface (thin things in large pictures) casts its own rays.
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
    let near = samples.means(buffer);
    run.check()?;
    let plane = buffer.over_covered(|x, y| {
        if run.check().is_err() {
            return 0.0;
        }
        samples.spread(&near, buffer, (x, y)).unwrap_or_else(|| caster.whole((x, y)))
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
        (0..3).fold(0, |n, bit| n << 2 | ((x ^ y) >> bit & 1) << 1 | (y >> bit & 1))
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

    /// The mean of means around a pixel, `None` where none is on its surface.
    fn spread(&self, near: &Plane<f32>, buffer: &GBuffer, (x, y): (usize, usize)) -> Option<f32> {
        let patch = Surroundings::at(buffer, (x, y), 3.0 * self.step as f32);
        let along = |p: usize| {
            let (cell, part) = ((p / self.step) as isize, (p % self.step) as f32);
            let t = part / self.step as f32;
            [(cell - 2, 1.0 - t), (cell - 1, t), (cell + 2, 1.0 - t), (cell + 3, t)]
        };
        let (mut sum, mut weights) = (0.0, 0.0);
        for (j, wy) in along(y) {
            for (i, wx) in along(x) {
                let weight = wx * wy;
                if weight > 0.0 && self.pixel(buffer, i, j).is_some_and(|p| patch.holds(buffer, p))
                {
                    sum += weight * near[(i as usize, j as usize)];
                    weights += weight;
                }
            }
        }
        // Off the four means' places, the pixel's own surroundings may still be there.
        if weights > 0.0 { Some(sum / weights) } else { self.own(near, buffer, &patch, (x, y)) }
    }

    /// The mean at the nearest sample on the same surface.
    fn own(
        &self,
        near: &Plane<f32>,
        buffer: &GBuffer,
        patch: &Surroundings,
        (x, y): (usize, usize),
    ) -> Option<f32> {
        let (i, j) = ((x / self.step) as isize, (y / self.step) as isize);
        let around = [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(u, v)| (i + u, j + v));
        around.into_iter().find_map(|(u, v)| {
            let p = self.pixel(buffer, u, v)?;
            patch.holds(buffer, p).then(|| near[(u as usize, v as usize)])
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
