//! [`Sky`]: light from all around, a picture in latitude and longitude.
//!
//! The picture's middle lies along -z, its right edge follows x, its top is +y. Each texel is a
//! patch of constant radiance, for evaluation as for sampling, so that both agree exactly;
//! directions are drawn in proportion to luminance times solid angle.

mod blur;

pub use blur::BlurredSky;

use chiaro_basis::math::Vec3;
use chiaro_image::Plane;
use chiaro_image::colour::luminance;
use std::f32::consts::{PI, TAU};

/// Light from all around.
#[derive(Clone, Debug)]
pub struct Sky {
    radiance: Plane<[f32; 3]>,
    /// For each row the share of power up to and including each texel; all zero in black rows.
    within_rows: Plane<f32>,
    /// The share of power up to and including each row.
    rows: Vec<f32>,
    /// Luminance integrated over the sphere.
    power: f32,
}

/// A direction drawn from a sky.
#[derive(Clone, Copy, Debug)]
pub struct SkySample {
    /// Unit vector to the sky.
    pub towards: Vec3,
    /// Radiance from there.
    pub radiance: [f32; 3],
    /// Probability density per solid angle.
    pub density: f32,
}

impl Sky {
    /// From a picture of linear radiance; what is negative or no number counts as black.
    pub fn new(radiance: Plane<[f32; 3]>) -> Self {
        let finite = |c: f32| if c.is_finite() { c.clamp(0.0, 1e12) } else { 0.0 };
        let radiance = radiance.map(|p| p.map(finite));
        let (width, height) = radiance.size();
        let mut within_rows = Plane::filled(width, height, 0.0);
        let mut rows = Vec::with_capacity(height);
        let mut total = 0.0f64;
        for y in 0..height {
            let solid_angle = texel_solid_angle(y, (width, height));
            let mut sum = 0.0f64;
            for x in 0..width {
                sum += f64::from(luminance(radiance[(x, y)]));
                within_rows[(x, y)] = sum as f32;
            }
            if sum > 0.0 {
                (0..width).for_each(|x| within_rows[(x, y)] /= sum as f32);
            }
            total += sum * f64::from(solid_angle);
            rows.push(total);
        }
        let rows = rows.iter().map(|r| (r / total.max(f64::MIN_POSITIVE)) as f32).collect();
        Self { radiance, within_rows, rows, power: total as f32 }
    }

    /// Whether it gives no light at all.
    pub fn is_black(&self) -> bool {
        self.power <= 0.0
    }

    /// Luminance integrated over the sphere.
    pub fn power(&self) -> f32 {
        self.power
    }

    /// Radiance from a direction.
    pub fn radiance(&self, towards: Vec3) -> [f32; 3] {
        self.radiance[self.texel(towards)]
    }

    /// Radiance from a direction, smooth between the texels: for a backdrop that is seen, where
    /// [`Sky::radiance`] is for estimates that [`Sky::density`] weighs.
    pub fn backdrop(&self, towards: Vec3) -> [f32; 3] {
        let (width, height) = self.radiance.size();
        let [u, v] = Self::place(towards);
        let (x, y) =
            (u * width as f32 - 0.5, (v * height as f32 - 0.5).clamp(0.0, height as f32 - 1.0));
        let (column, row) = (x.floor(), y.floor());
        let (s, t) = (x - column, y - row);
        let columns =
            [column, column + 1.0].map(|c| (c as isize).rem_euclid(width as isize) as usize);
        let rows = [row as usize, (row as usize + 1).min(height - 1)];
        let [a, b] = rows.map(|y| columns.map(|x| self.radiance[(x, y)]));
        std::array::from_fn(|c| {
            let [above, below] = [a, b].map(|[left, right]| left[c] + (right[c] - left[c]) * s);
            above + (below - above) * t
        })
    }

    /// Direction, radiance and solid angle of every texel.
    pub fn texels(&self) -> impl Iterator<Item = (Vec3, [f32; 3], f32)> {
        let (width, height) = self.radiance.size();
        (0..height).flat_map(move |y| {
            let (sine, cosine) = (PI * (y as f32 + 0.5) / height as f32).sin_cos();
            let solid_angle = texel_solid_angle(y, (width, height));
            (0..width).map(move |x| {
                let longitude = TAU * ((x as f32 + 0.5) / width as f32 - 0.5);
                let towards = Vec3::new(sine * longitude.sin(), cosine, -sine * longitude.cos());
                (towards, self.radiance[(x, y)], solid_angle)
            })
        })
    }

    /// The density with which [`Sky::sample`] finds a direction, per solid angle.
    pub fn density(&self, towards: Vec3) -> f32 {
        if self.is_black() { 0.0 } else { luminance(self.radiance(towards)) / self.power }
    }

    /// A direction for two numbers in [0, 1); `None` from a black sky.
    pub fn sample(&self, [u, v]: [f32; 2]) -> Option<SkySample> {
        if self.is_black() {
            return None;
        }
        let (width, height) = self.radiance.size();
        let (y, v) = invert(&self.rows, v);
        let (x, u) = invert(self.within_rows.row(y), u);
        // Uniform in the texel's solid angle: in longitude and in the cosine of latitude.
        let edge = |y: usize| (PI * y as f32 / height as f32).cos();
        let cosine = edge(y) + (edge(y + 1) - edge(y)) * v;
        let longitude = TAU * ((x as f32 + u) / width as f32 - 0.5);
        let sine = (1.0 - cosine * cosine).max(0.0).sqrt();
        let towards = Vec3::new(sine * longitude.sin(), cosine, -sine * longitude.cos());
        let radiance = self.radiance[(x, y)];
        Some(SkySample { towards, radiance, density: luminance(radiance) / self.power })
    }

    /// Where a direction lies on the picture, both in [0, 1].
    fn place(towards: Vec3) -> [f32; 2] {
        let u = towards.x.atan2(-towards.z) / TAU + 0.5;
        [u, towards.y.clamp(-1.0, 1.0).acos() / PI]
    }

    fn texel(&self, towards: Vec3) -> (usize, usize) {
        let (width, height) = self.radiance.size();
        let [u, v] = Self::place(towards);
        let place = |t: f32, n: usize| ((t * n as f32) as usize).min(n - 1);
        (place(u, width), place(v, height))
    }
}

fn texel_solid_angle(y: usize, (width, height): (usize, usize)) -> f32 {
    let edge = |y: usize| (PI * y as f32 / height as f32).cos();
    TAU / width as f32 * (edge(y) - edge(y + 1))
}

/// The index whose share of a cumulative distribution holds `t`, and the place in it, in [0, 1).
fn invert(cumulative: &[f32], t: f32) -> (usize, f32) {
    let mut index = cumulative.partition_point(|c| *c <= t).min(cumulative.len() - 1);
    // Rounding may leave `t` past the last entry with any share.
    while index > 0 && cumulative[index] <= cumulative[index - 1] {
        index -= 1;
    }
    let below = if index == 0 { 0.0 } else { cumulative[index - 1] };
    let width = cumulative[index] - below;
    (index, if width > 0.0 { ((t - below) / width).clamp(0.0, 0.999_999) } else { 0.0 })
}

#[cfg(test)]
mod tests {
    use super::*;
    use chiaro_basis::random::r2;

    fn spotted() -> Sky {
        Sky::new(Plane::from_fn(32, 16, |x, y| match (x, y) {
            (20, 4) => [50.0, 40.0, 30.0],
            (_, 0..8) => [0.2, 0.3, 0.5],
            _ => [0.0; 3],
        }))
    }

    #[test]
    fn samples_estimate_the_irradiance_that_quadrature_finds() {
        let sky = spotted();
        let n = 20_000;
        let up = |d: Vec3| d.y.max(0.0);
        let sampled: f32 = (0..n)
            .filter_map(|i| sky.sample(r2(i)))
            .map(|s| s.radiance[0] * up(s.towards) / s.density / n as f32)
            .sum();
        let quadrature: f32 = (0..n)
            .map(|i| {
                let [u, v] = r2(i);
                let (y, a) = (1.0 - 2.0 * u, TAU * v);
                let r = (1.0 - y * y).sqrt();
                let d = Vec3::new(r * a.cos(), y, r * a.sin());
                sky.radiance(d)[0] * up(d) * 4.0 * PI / n as f32
            })
            .sum();
        assert!((sampled / quadrature - 1.0).abs() < 0.03, "{sampled} {quadrature}");
    }

    #[test]
    fn samples_fall_where_their_density_says() {
        let sky = spotted();
        for i in 0..2000 {
            let s = sky.sample(r2(i)).unwrap();
            assert!((s.towards.length() - 1.0).abs() < 1e-4);
            assert!(s.density > 0.0 && s.towards.y > -1e-4);
        }
        let density: f32 = (0..20_000)
            .map(|i| {
                let [u, v] = r2(i);
                let (y, a) = (1.0 - 2.0 * u, TAU * v);
                let r = (1.0 - y * y).sqrt();
                sky.density(Vec3::new(r * a.cos(), y, r * a.sin())) * 4.0 * PI / 20_000.0
            })
            .sum();
        assert!((density - 1.0).abs() < 0.05, "{density}");
    }

    #[test]
    fn a_backdrop_is_the_texel_at_its_centre_and_the_mean_between_two() {
        let sky = Sky::new(Plane::from_fn(8, 4, |x, y| [x as f32, y as f32, 1.0]));
        let towards = |u: f32, v: f32| {
            let (longitude, latitude) = (TAU * (u - 0.5), PI * v);
            let sine = latitude.sin();
            Vec3::new(sine * longitude.sin(), latitude.cos(), -sine * longitude.cos())
        };
        let near = |a: [f32; 3], b: [f32; 3]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-4);
        assert!(near(sky.backdrop(towards(2.5 / 8.0, 1.5 / 4.0)), [2.0, 1.0, 1.0]));
        assert!(near(sky.backdrop(towards(3.0 / 8.0, 2.0 / 4.0)), [2.5, 1.5, 1.0]));
        // Once round: between the last column and the first.
        assert!(near(sky.backdrop(towards(0.0, 1.5 / 4.0)), [3.5, 1.0, 1.0]));
        assert!(near(sky.backdrop(Vec3::Y), [sky.backdrop(Vec3::Y)[0], 0.0, 1.0]));
    }

    #[test]
    fn black_and_broken_skies_give_nothing() {
        let sky = Sky::new(Plane::filled(4, 2, [f32::NAN, -1.0, 0.0]));
        assert!(sky.is_black() && sky.sample([0.5; 2]).is_none());
        assert_eq!(sky.radiance(Vec3::Y), [0.0; 3]);
    }
}
