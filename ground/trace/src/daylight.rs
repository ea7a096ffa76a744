//! Daylight for scenes that bring no light: a sun, and the clear sky that belongs to it.
//!
//! The sky is Preetham's model ("A Practical Analytic Model for Daylight", SIGGRAPH 1999) at
//! turbidity 3, over a grey ground that both light; the sun is parallel light of the illuminance
//! that such a sky goes with. Only ratios matter, since exposure is automatic.

use crate::light::Lamp;
use crate::sky::Sky;
use chiaro_basis::math::Vec3;
use chiaro_image::Plane;
use chiaro_image::colour::luminance;
use std::f32::consts::{FRAC_1_PI, PI, TAU};

const TURBIDITY: f32 = 3.0;
/// Columns and rows of the sky's picture.
const SIZE: (usize, usize) = (128, 64);
/// The sun's illuminance, facing it, over the sky's on level ground.
const SUN_OVER_SKY: f32 = 4.0;
/// The ground's albedo.
const GROUND: f32 = 0.2;

/// The sun in the direction `towards`, and its sky.
pub fn daylight(towards: Vec3) -> (Lamp, Sky) {
    let (sun, sky) = clear(towards);
    (sun, Sky::new(sky))
}

/// The clear sky that goes with a parallel lamp taken for the sun.
pub fn sky_of_sun(lamp: &Lamp) -> Sky {
    let (sun, sky) = clear(-lamp.direction);
    let scale = lamp.strength * luminance(lamp.colour) / sun.strength;
    Sky::new(sky.map(|c| c.map(|v| v * scale)))
}

/// A sun and the picture of its sky.
fn clear(towards: Vec3) -> (Lamp, Plane<[f32; 3]>) {
    let mut sun = towards.normalize_or(Vec3::Y);
    sun.y = sun.y.max(0.05);
    let sun = sun.normalize();
    let model = Preetham::new(sun);
    let (w, h) = SIZE;
    let upper = Plane::from_fn(w, h, |x, y| {
        let latitude = PI * (y as f32 + 0.5) / h as f32;
        let longitude = TAU * ((x as f32 + 0.5) / w as f32 - 0.5);
        let (r, up) = latitude.sin_cos();
        let d = Vec3::new(r * longitude.sin(), up, -r * longitude.cos());
        if d.y > 0.0 { model.radiance(d) } else { [0.0; 3] }
    });
    let level = integral(&upper, |cosine| cosine.max(0.0));
    let strength = SUN_OVER_SKY * luminance(level);
    let lamp = Lamp { strength, colour: sun_colour(sun.y), ..Lamp::sun(-sun) };
    let ground = ground(level, &lamp);
    (lamp, upper.map(|c| if *c == [0.0; 3] { ground } else { *c }))
}

/// Warm near the horizon, nearly white above; of luminance 1.
fn sun_colour(height: f32) -> [f32; 3] {
    let t = (height / 0.6).clamp(0.0, 1.0);
    let c = [1.0, 0.55 + 0.38 * t, 0.2 + 0.62 * t];
    c.map(|v| v / luminance(c))
}

/// Sum of `value` over the texels' solid angles.
fn integral(sky: &Plane<[f32; 3]>, weight: impl Fn(f32) -> f32) -> [f32; 3] {
    let (w, h) = sky.size();
    let mut sum = [0.0; 3];
    for y in 0..h {
        let latitude = PI * (y as f32 + 0.5) / h as f32;
        let share = weight(latitude.cos()) * latitude.sin() * PI / h as f32 * TAU / w as f32;
        for c in sky.row(y) {
            (0..3).for_each(|i| sum[i] += c[i] * share);
        }
    }
    sum
}

/// Radiance of level ground under a sky of this illuminance and a sun.
fn ground(level: [f32; 3], sun: &Lamp) -> [f32; 3] {
    let cosine = -sun.direction.y;
    std::array::from_fn(|i| GROUND * (level[i] + sun.strength * sun.colour[i] * cosine) * FRAC_1_PI)
}

/// The model's coefficients for one place of the sun.
struct Preetham {
    sun: Vec3,
    /// For Y, x and y: the five coefficients of Perez's formula, the zenith's value, and the
    /// formula's value at the zenith.
    channels: [([f32; 5], f32, f32); 3],
}

impl Preetham {
    fn new(sun: Vec3) -> Self {
        let t = TURBIDITY;
        let theta = sun.y.clamp(0.0, 1.0).acos();
        let coefficients = [
            [
                0.1787 * t - 1.4630,
                -0.3554 * t + 0.4275,
                -0.0227 * t + 5.3251,
                0.1206 * t - 2.5771,
                -0.0670 * t + 0.3703,
            ],
            [
                -0.0193 * t - 0.2592,
                -0.0665 * t + 0.0008,
                -0.0004 * t + 0.2125,
                -0.0641 * t - 0.8989,
                -0.0033 * t + 0.0452,
            ],
            [
                -0.0167 * t - 0.2608,
                -0.0950 * t + 0.0092,
                -0.0079 * t + 0.2102,
                -0.0441 * t - 1.6537,
                -0.0109 * t + 0.0529,
            ],
        ];
        let chi = (4.0 / 9.0 - t / 120.0) * (PI - 2.0 * theta);
        let zenith = [
            (4.0453 * t - 4.9710) * chi.tan() - 0.2155 * t + 2.4192,
            zenith_chroma(
                theta,
                [
                    [0.00166, -0.00375, 0.00209, 0.0],
                    [-0.02903, 0.06377, -0.03202, 0.00394],
                    [0.11693, -0.21196, 0.06052, 0.25886],
                ],
            ),
            zenith_chroma(
                theta,
                [
                    [0.00275, -0.00610, 0.00317, 0.0],
                    [-0.04214, 0.08970, -0.04153, 0.00516],
                    [0.15346, -0.26756, 0.06670, 0.26688],
                ],
            ),
        ];
        let channel = |i: usize| {
            let c = coefficients[i];
            (c, zenith[i], perez(&c, 1.0, theta))
        };
        Self { sun, channels: [channel(0), channel(1), channel(2)] }
    }

    fn radiance(&self, d: Vec3) -> [f32; 3] {
        let gamma = d.dot(self.sun).clamp(-1.0, 1.0).acos();
        let [lum, x, y] =
            self.channels.map(|(c, zenith, at)| zenith * perez(&c, d.y.max(0.02), gamma) / at);
        from_xyy(x, y, lum.max(0.0))
    }
}

/// Perez's formula for the cosine to the zenith and the angle to the sun.
fn perez(c: &[f32; 5], cosine: f32, gamma: f32) -> f32 {
    let near_sun = 1.0 + c[2] * (c[3] * gamma).exp() + c[4] * gamma.cos().powi(2);
    (1.0 + c[0] * (c[1] / cosine).exp()) * near_sun
}

/// A chromaticity at the zenith: quadratic in turbidity, cubic in the sun's angle.
fn zenith_chroma(theta: f32, rows: [[f32; 4]; 3]) -> f32 {
    let cubic = |r: [f32; 4]| ((r[0] * theta + r[1]) * theta + r[2]) * theta + r[3];
    (cubic(rows[0]) * TURBIDITY + cubic(rows[1])) * TURBIDITY + cubic(rows[2])
}

fn from_xyy(x: f32, y: f32, lum: f32) -> [f32; 3] {
    let (cx, cz) = (x / y * lum, (1.0 - x - y) / y * lum);
    [
        3.2406 * cx - 1.5372 * lum - 0.4986 * cz,
        -0.9689 * cx + 1.8758 * lum + 0.0415 * cz,
        0.0557 * cx - 0.2040 * lum + 1.0570 * cz,
    ]
    .map(|c| c.max(0.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sky_is_blue_above_and_brighter_near_the_sun() {
        let towards = Vec3::new(0.5, 0.6, 0.3).normalize();
        let (sun, sky) = daylight(towards);
        let [r, _, b] = sky.radiance(Vec3::Y);
        assert!(b > 1.5 * r, "{r} {b}");
        let across = Vec3::new(-0.5, 0.6, -0.3).normalize();
        assert!(luminance(sky.radiance(towards)) > 2.0 * luminance(sky.radiance(across)));
        assert!(sun.strength > 0.0 && (luminance(sun.colour) - 1.0).abs() < 1e-4);
    }

    #[test]
    fn a_sun_below_the_horizon_is_lifted() {
        let (sun, sky) = daylight(-Vec3::Y);
        assert!(sun.direction.y < 0.0 && !sky.is_black());
    }
}
