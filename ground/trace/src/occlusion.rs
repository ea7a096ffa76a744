//! Ambient occlusion: the cosine-weighted share of the hemisphere that is open.
//!
//! 1. A sample is taken at every pixel, in large pictures at every second to fourth of every such row. A set of cosine-weighted
//!    directions, low in discrepancy, is dealt to the 64 samples of an 8 x 8 tile, so that each casts
//!    few rays and no two of a tile cast the same.
//! 2. Samples are averaged over the 8 x 8 window around each, which holds every share of the
//!    deal once: first over 4 x 4, then over four such means. What lies off the sample's plane or is
//!    turned away is left out.
//! 3. Such means are averaged twice more along their gradient ([`Lattice::softened`]).
//! 4. A pixel takes the bilinear mean of the samples around it that lie on its surface. Without any (thin
//!    things in large pictures) it casts its own rays.
//!
//! Rays start on the smooth surface that the vertex normals span, and those that are flatter than
//! facets deviate from it count as open: the facets of a smooth surface do not darken each other.
//!
//! Guaranteed: deterministic, and free of noise on smooth surfaces, since every window holds the
//! whole set. Not guaranteed: on surfaces a few pixels wide, fewer directions are left.

use crate::gbuffer::GBuffer;
use crate::lattice::{Lattice, Softening};
use crate::smooth::{Facet, lifted};
use crate::tracer::{Ray, Tracer};
use chiaro_basis::math::Vec3;
use chiaro_basis::{Result, Run, random};
use chiaro_image::Plane;

/// Samples along a tile's side.
const TILE: usize = 8;
/// How means are averaged once more, and then from farther away.
const NEAR: Softening = Softening { spacing: 4, sloping: 0.2, alike: 0.04 };
const FAR: Softening = Softening { spacing: 8, sloping: 0.2, alike: 0.02 };
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
    let lattice = Lattice::new(buffer, step(buffer.size().1));
    let samples = caster.samples(&lattice, run)?;
    let near = lattice.softened(&windows(&samples, &lattice), &NEAR);
    run.check()?;
    let soft = lattice.softened(&near, &FAR);
    run.check()?;
    let plane = buffer.over_covered(|x, y| {
        if run.check().is_err() {
            return 0.0;
        }
        lattice.between(&soft, 3.0, (x, y)).unwrap_or_else(|| caster.whole((x, y)))
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

    /// Openness at samples, each by its share of the directions.
    fn samples(&self, lattice: &Lattice<'_>, run: &Run) -> Result<Plane<f32>> {
        let samples = lattice.plane(|i, j| match lattice.pixel(i as isize, j as isize) {
            Some(pixel) if run.check().is_ok() => {
                self.openness(pixel, self.deal[j % TILE * TILE + i % TILE].iter())
            }
            _ => 0.0,
        });
        run.check()?;
        Ok(samples)
    }

    /// A pixel that nobody helps, by as many rays as count elsewhere in a quarter of the window.
    fn whole(&self, pixel: (usize, usize)) -> f32 {
        self.openness(pixel, self.deal.iter().step_by(4).flatten())
    }
}

/// At each sample the mean over 8 x 8 samples on its surface: over 4 x 4, and then over four such means.
fn windows(samples: &Plane<f32>, lattice: &Lattice<'_>) -> Plane<f32> {
    let means = lattice.plane(|i, j| {
        let (i, j) = (i as isize, j as isize);
        let Some(at) = lattice.pixel(i, j) else { return 0.0 };
        let patch = lattice.surroundings(at, 2.0);
        let (mut sum, mut count) = (0.0, 0.0);
        for v in j - 2..j + 2 {
            for u in i - 2..i + 2 {
                if lattice.pixel(u, v).is_some_and(|p| patch.holds(lattice.buffer, p)) {
                    sum += samples[(u as usize, v as usize)];
                    count += 1.0;
                }
            }
        }
        // A sample is on its own surface.
        sum / f32::max(count, 1.0)
    });
    lattice.over_surface(3.0, |at, holds| {
        let (mut sum, mut count) = (0.0, 0.0);
        for offset in [(-2, -2), (2, -2), (-2, 2), (2, 2)] {
            if let Some(p) = holds(offset) {
                sum += means[p];
                count += 1.0;
            }
        }
        if count > 0.0 { sum / count } else { means[at] }
    })
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
        let lattice = Lattice::new(&buffer, 1);
        let windows = windows(&caster.samples(&lattice, &run).unwrap(), &lattice);
        let soft = lattice.softened(&lattice.softened(&windows, &NEAR), &FAR);
        // The median bend of the openness over five pixels of one flat face.
        let rough = |plane: &Plane<f32>| {
            let flat = |x: usize, y: usize| {
                let patch = lattice.surroundings((x, y), 0.1);
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
        assert!(after < 0.4 * before, "{before} {after}");
        let moved = windows.pixels().iter().zip(soft.pixels()).map(|(a, b)| (a - b).abs());
        assert!(moved.fold(0.0, f32::max) < NEAR.alike + FAR.alike);
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
