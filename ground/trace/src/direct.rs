//! Direct light at the pixels of a buffer, free of noise.
//!
//! 1. Lamps without size are visited one by one. What shines and the sky stand as a fixed set of
//!    small lamps, the same for every pixel.
//! 2. The small lamps are dealt to the 16 pixels of a 4 x 4 tile, a sixteenth to each; then every
//!    pixel takes the mean of the 4 x 4 window around it, which holds the whole set once.
//! 3. Where the window does not lie on one smooth surface, the pixel visits the set by itself.
//!
//! Guaranteed: deterministic, and smooth on smooth surfaces. Not guaranteed: shadows of small lamps
//! a few pixels wide are softened by the window.

use crate::gbuffer::GBuffer;
use crate::light::Lamp;
use crate::lights::{Lights, lamp_at};
use crate::tracer::Tracer;
use crate::vertex::Vertex;
use chiaro_basis::math::Vec3;
use chiaro_basis::{Result, Run, random};
use chiaro_image::Plane;
use chiaro_image::colour::luminance;

/// Pixels along a tile's side, and in a tile.
const TILE: usize = 4;
const DEAL: usize = TILE * TILE;
/// Small lamps for what shines, and for the sky: so many for each pixel of a tile.
const GLOW_SHARE: usize = 4;
const SKY_SHARE: usize = 8;
/// A pixel by itself visits every so many of the small lamps.
const ALONE: usize = 2;

/// The fixed lamps of a frame.
struct Fixed {
    hard: Vec<Lamp>,
    soft: Vec<Lamp>,
}

impl Fixed {
    fn of(lights: &Lights) -> Self {
        let mut soft = lights.glow.lamps(DEAL * GLOW_SHARE);
        // The sky's few brightest texels may hold most of its light: a low-discrepancy set finds
        // them in proportion.
        if let Some(sky) = &lights.sky {
            let count = DEAL * SKY_SHARE;
            soft.extend((0..count).filter_map(|i| {
                let s = sky.sample(random::r2(i as u64))?;
                let y = luminance(s.radiance);
                Some(Lamp {
                    strength: y / s.density / count as f32,
                    colour: s.radiance.map(|c| c / y),
                    ..Lamp::sun(-s.towards)
                })
            }));
        }
        Self { hard: lights.lamps.clone(), soft }
    }
}

/// Irradiance by direct light at each covered pixel, linear RGB.
#[derive(Clone, Debug)]
pub struct Direct {
    /// From lamps without size: its shadows have sharp edges.
    pub hard: Plane<[f32; 3]>,
    /// From what shines and from the sky.
    pub soft: Plane<[f32; 3]>,
}

impl Direct {
    /// Both together.
    pub fn whole(&self) -> Plane<[f32; 3]> {
        let sum = |a: &[f32; 3], b: &[f32; 3]| std::array::from_fn(|i| a[i] + b[i]);
        self.hard.zip(&self.soft, sum).expect("both have the picture's size")
    }
}

/// Direct light at the covered pixels of a buffer.
pub fn direct_irradiance(
    tracer: &Tracer,
    buffer: &GBuffer,
    lights: &Lights,
    run: &Run,
) -> Result<Direct> {
    let fixed = Fixed::of(lights);
    let raw = buffer.over_covered(|x, y| {
        if run.check().is_err() {
            return ([0.0; 3], [0.0; 3]);
        }
        let at = Vertex::of_pixel(tracer, buffer, (x, y));
        let hard = sum(tracer, &at, fixed.hard.iter());
        let own = fixed.soft.iter().skip(place(x, y)).step_by(DEAL);
        (hard, sum(tracer, &at, own).map(|e| e * DEAL as f32))
    });
    run.check()?;
    let soft = buffer.over_covered(|x, y| {
        if run.check().is_err() {
            return [0.0; 3];
        }
        match window(buffer, &raw, (x, y)) {
            _ if fixed.soft.is_empty() => [0.0; 3],
            Some(mean) => mean,
            None => {
                let at = Vertex::of_pixel(tracer, buffer, (x, y));
                let some = fixed.soft.iter().step_by(ALONE);
                sum(tracer, &at, some).map(|e| e * ALONE as f32)
            }
        }
    });
    run.check()?;
    Ok(Direct { hard: raw.map(|r| r.0), soft })
}

/// Each pixel's place in the deal, far from its neighbours'.
fn place(x: usize, y: usize) -> usize {
    const ORDER: [usize; DEAL] = [0, 8, 2, 10, 12, 4, 14, 6, 3, 11, 1, 9, 15, 7, 13, 5];
    ORDER[(y % TILE) * TILE + x % TILE]
}

/// Irradiance at a vertex from lamps, each with a shadow ray.
pub fn lamp_irradiance(tracer: &Tracer, at: &Vertex, lamps: &[Lamp]) -> [f32; 3] {
    sum(tracer, at, lamps.iter())
}

fn sum<'a>(tracer: &Tracer, at: &Vertex, lamps: impl Iterator<Item = &'a Lamp>) -> [f32; 3] {
    lamps
        .filter_map(|l| lamp_at(l, at))
        .filter(|(_, ray)| !tracer.occluded(ray))
        .fold([0.0; 3], |s, (e, _)| std::array::from_fn(|i| s[i] + e[i]))
}

/// The mean over the window, if all of it lies on the pixel's smooth surface.
fn window(
    buffer: &GBuffer,
    raw: &Plane<([f32; 3], [f32; 3])>,
    (x, y): (usize, usize),
) -> Option<[f32; 3]> {
    let (_, height) = buffer.size();
    let normal = Vec3::from(buffer.normal[(x, y)]);
    let position = Vec3::from(buffer.position[(x, y)]);
    let tolerance = 2.0 * buffer.pose.pixel_size(buffer.depth[(x, y)], height as f32);
    let mut sum = [0.0; 3];
    for dy in -2..2isize {
        for dx in -2..2isize {
            let (u, v) = (x as isize + dx, y as isize + dy);
            if buffer.covered.at(u, v) != Some(&true) {
                return None;
            }
            let at = (u as usize, v as usize);
            let off_plane = (Vec3::from(buffer.position[at]) - position).dot(normal).abs();
            if off_plane > tolerance || Vec3::from(buffer.normal[at]).dot(normal) < 0.97 {
                return None;
            }
            (0..3).for_each(|i| sum[i] += raw[at].1[i]);
        }
    }
    Some(sum.map(|s| s / DEAL as f32))
}
