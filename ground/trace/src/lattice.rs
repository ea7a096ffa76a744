//! [`Lattice`]: values known at every so many pixels of every so many rows, made smooth along surfaces.
//!
//! A threshold in a slow gradient shows every hundredth of noise as a tooth of its border. So a value
//! is averaged with those around it on its surface, each moved to its place along the gradient that
//! they have in common: slopes stay as steep as they are, and noise and small steps wane. What is
//! far from that plane of values, as at the edge of a shadow or in a hollow, is left out, and edges
//! stay.

use crate::gbuffer::GBuffer;
use crate::surroundings::{PixelSize, Surroundings};
use chiaro_image::Plane;

type Pixel = (usize, usize);

/// Values along a side of the square that are averaged.
const SIDE: usize = 5;
const MIDDLE: usize = SIDE * SIDE / 2;

/// How values are averaged.
pub(crate) struct Softening {
    /// Samples from one value to the next.
    pub(crate) spacing: isize,
    /// Differences from the middle that count for the gradient.
    pub(crate) sloping: f32,
    /// Differences from that gradient that are averaged.
    pub(crate) alike: f32,
}

/// Samples at every `step`th pixel of every `step`th row.
#[derive(Clone, Copy)]
pub(crate) struct Lattice<'a> {
    pub(crate) step: usize,
    pub(crate) buffer: &'a GBuffer,
    size: PixelSize,
}

/// A value beside another: its offset in spacings, by how much it is more, and its weight.
#[derive(Clone, Copy, Default)]
struct Beside {
    x: f32,
    y: f32,
    more: f32,
    weight: f32,
}

impl<'a> Lattice<'a> {
    /// That of a picture.
    pub(crate) fn new(buffer: &'a GBuffer, step: usize) -> Self {
        Self { step, buffer, size: PixelSize::of(buffer) }
    }

    /// What a pixel shares its surface with, which may leave its plane by so many samples.
    pub(crate) fn surroundings(&self, pixel: Pixel, reach: f32) -> Surroundings {
        Surroundings::at(self.buffer, self.size, pixel, reach * self.step as f32)
    }

    /// A value for each sample.
    pub(crate) fn plane<T: Send>(&self, value: impl Fn(usize, usize) -> T + Sync) -> Plane<T> {
        let (w, h) = self.buffer.size();
        Plane::from_fn(w.div_ceil(self.step), h.div_ceil(self.step), value)
    }

    /// The pixel of a sample, if it is in the picture and covered.
    pub(crate) fn pixel(&self, i: isize, j: isize) -> Option<Pixel> {
        let at = (
            usize::try_from(i).ok()?.checked_mul(self.step)?,
            usize::try_from(j).ok()?.checked_mul(self.step)?,
        );
        let (w, h) = self.buffer.size();
        (at.0 < w && at.1 < h && self.buffer.covered[at]).then_some(at)
    }

    /// A value at each covered sample, from its place and from places by their offsets, in samples, that
    /// lie on its surface within so many samples of its plane.
    pub(crate) fn over_surface(
        &self,
        reach: f32,
        value: impl Fn(Pixel, &dyn Fn((isize, isize)) -> Option<Pixel>) -> f32 + Sync,
    ) -> Plane<f32> {
        self.plane(|i, j| {
            let Some(pixel) = self.pixel(i as isize, j as isize) else { return 0.0 };
            let patch = self.surroundings(pixel, reach);
            value((i, j), &|(u, v)| {
                let (u, v) = (i as isize + u, j as isize + v);
                let on = self.pixel(u, v).is_some_and(|p| patch.holds(self.buffer, p));
                on.then_some((u as usize, v as usize))
            })
        })
    }

    /// Values averaged with those around them. NaN is no value, and stays.
    pub(crate) fn softened(&self, values: &Plane<f32>, by: &Softening) -> Plane<f32> {
        // The outer ones by half, so that none comes or goes at once.
        let share = |k: usize| if k == 0 || k == SIDE - 1 { 0.5 } else { 1.0 };
        let away = |k: usize| k as isize - SIDE as isize / 2;
        self.over_surface(by.spacing as f32, |at, holds| {
            let own = values[at];
            if self.is_even(values, at, by.spacing) {
                return own;
            }
            let mut all = [Beside::default(); SIDE * SIDE];
            let mut count = 0;
            for i in (0..SIDE * SIDE).filter(|i| *i != MIDDLE) {
                let (x, y) = (away(i % SIDE), away(i / SIDE));
                let Some(p) = holds((by.spacing * x, by.spacing * y)) else { continue };
                let weight = share(i % SIDE) * share(i / SIDE);
                let beside = Beside { x: x as f32, y: y as f32, more: values[p] - own, weight };
                if !beside.more.is_nan() {
                    all[count] = beside;
                    count += 1;
                }
            }
            let all = &all[..count];
            let slope = slope(all, by.sloping);
            let (mut sum, mut weights) = (0.0, 1.0);
            let (mut low, mut high) = (0.0f32, 0.0f32);
            for beside in all {
                (low, high) = (low.min(beside.more), high.max(beside.more));
                let off = beside.more - slope[0] * beside.x - slope[1] * beside.y;
                let weight = beside.weight * near(off / by.alike);
                sum += weight * off;
                weights += weight;
            }
            own + (sum / weights).clamp(low, high)
        })
    }

    /// Whether all values that one would be averaged with are the same.
    fn is_even(&self, values: &Plane<f32>, (i, j): Pixel, spacing: isize) -> bool {
        let reach = (SIDE / 2) as isize;
        let places = (-reach..=reach).flat_map(|y| (-reach..=reach).map(move |x| (x, y)));
        let mut beside = places
            .filter_map(|(x, y)| values.at(i as isize + spacing * x, j as isize + spacing * y));
        beside.all(|v| *v == values[(i, j)] || v.is_nan())
    }

    /// The bilinear mean of the samples around a pixel that lie on its surface within so many samples
    /// of its plane, `None` where none does.
    pub(crate) fn between(&self, values: &Plane<f32>, reach: f32, (x, y): Pixel) -> Option<f32> {
        let step = self.step;
        let (i, j) = (x / step, y / step);
        let [across, down] = [x, y].map(|p| (p % step) as f32 / step as f32);
        if across == 0.0 && down == 0.0 {
            return Some(values[(i, j)]).filter(|v| !v.is_nan());
        }
        let patch = self.surroundings((x, y), reach);
        let (mut sum, mut weights) = (0.0, 0.0);
        for (u, v) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
            let along = |far: usize, t: f32| if far == 1 { t } else { 1.0 - t };
            // All around count where those of a row or column do not lie on the surface.
            let weight = (along(u, across) * along(v, down)).max(1e-3);
            let at = (i + u, j + v);
            let pixel = self.pixel(at.0 as isize, at.1 as isize);
            if pixel.is_some_and(|p| patch.holds(self.buffer, p) && !values[at].is_nan()) {
                sum += weight * values[at];
                weights += weight;
            }
        }
        (weights > 0.0).then(|| sum / weights)
    }
}

/// How fast values grow along x and y, by least squares over those that differ by less than `most`.
fn slope(all: &[Beside], most: f32) -> [f32; 2] {
    // The middle is one of them; flat is likelier than steep.
    let (mut w, mut x, mut y, mut v) = (1.0, 0.0, 0.0, 0.0);
    let (mut xx, mut xy, mut yy, mut vx, mut vy) = (1.0, 0.0, 1.0, 0.0, 0.0);
    for b in all {
        let weight = b.weight * near(b.more / most);
        let (wx, wy) = (weight * b.x, weight * b.y);
        (w, x, y, v) = (w + weight, x + wx, y + wy, v + weight * b.more);
        (xx, xy, yy) = (xx + wx * b.x, xy + wx * b.y, yy + wy * b.y);
        (vx, vy) = (vx + wx * b.more, vy + wy * b.more);
    }
    let (xx, xy, yy) = (xx - x * x / w, xy - x * y / w, yy - y * y / w);
    let (vx, vy) = (vx - v * x / w, vy - v * y / w);
    let scale = 1.0 / (xx * yy - xy * xy);
    [scale * (vx * yy - vy * xy), scale * (vy * xx - vx * xy)]
}

/// 1 for no difference, 0 from 1 on.
fn near(difference: f32) -> f32 {
    (1.0 - difference * difference).max(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use chiaro_basis::math::Vec3;
    use chiaro_basis::random::unit;
    use chiaro_scene::{Pose, Projection};

    /// A wall that fills the picture, before another on its right.
    fn wall(side: usize) -> GBuffer {
        let half_height = 0.5 * side as f32;
        let projection = Projection::Orthographic { half_height };
        let pose = Pose::look_at(Vec3::Z, Vec3::ZERO, Vec3::Y, projection);
        let mut buffer = GBuffer::empty(&pose, half_height, (side, side));
        buffer.covered = Plane::filled(side, side, true);
        let depth = |x: usize| if 4 * x < 3 * side { 0.0 } else { 9.0 };
        buffer.position =
            Plane::from_fn(side, side, |x, y| [x as f32, side as f32 - y as f32, -depth(x)]);
        buffer.smooth_normal = Plane::filled(side, side, [0.0, 0.0, 1.0]);
        buffer
    }

    #[test]
    fn noise_and_stairs_become_slopes_and_edges_stay() {
        let buffer = wall(160);
        let lattice = Lattice::new(&buffer, 1);
        let by = Softening { spacing: 4, sloping: 1.5, alike: 0.25 };
        let far = Softening { spacing: 8, ..by };
        let noise = |x, y| 0.02 * (unit(3, (y * 160 + x) as u64) - 0.5);
        let stair = |x: usize| (x / 10).min(11) as f32 / 12.0;
        let noisy = Plane::from_fn(160, 160, |x, y| stair(x) + noise(x, y));
        let soft = lattice.softened(&lattice.softened(&noisy, &by), &far);
        for (x, y) in (20..100).map(|x| (x, 2 * x - 40)) {
            let line = (x as f32 - 4.5) / 120.0;
            assert!((soft[(x, y)] - line).abs() < 0.012, "{x}: {} {line}", soft[(x, y)]);
        }
        let edge = Plane::from_fn(160, 160, |x, y| if x + y < 130 { 0.0 } else { 1.0 });
        let soft = lattice.softened(&edge, &by);
        assert!(soft.pixels().iter().zip(edge.pixels()).all(|(a, b)| (a - b).abs() < 0.1));
        // What lies on another surface does not count, however alike it is.
        let apart = Plane::from_fn(160, 160, |x, _| if x < 120 { 0.5 } else { 0.6 });
        let soft = lattice.softened(&apart, &by);
        assert!(soft.pixels().iter().zip(apart.pixels()).all(|(a, b)| (a - b).abs() < 1e-6));
    }

    #[test]
    fn pixels_lie_between_samples_of_their_surface() {
        let buffer = wall(160);
        let lattice = Lattice::new(&buffer, 4);
        let values = lattice.plane(|i, j| if (i, j) == (5, 5) { f32::NAN } else { i as f32 });
        assert_eq!(lattice.between(&values, 1.0, (10, 9)), Some(2.5));
        assert_eq!(lattice.between(&values, 1.0, (20, 20)), None);
        // Half a sample from the missing one, and before the edge of the wall behind.
        assert!((lattice.between(&values, 1.0, (22, 20)).unwrap() - 6.0).abs() < 0.01);
        assert!((lattice.between(&values, 1.0, (118, 9)).unwrap() - 29.0).abs() < 1e-3);
    }
}
