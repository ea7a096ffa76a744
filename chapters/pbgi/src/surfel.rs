//! [`Surfels`]: sites of a frame with their light (thesis, 6.3.2, Storing Reflected Light).
//!
//! A surfel is a flat two-sided piece of surface. Each side has an area, 0 when it is dead, and
//! sends the same radiance everywhere: albedo / pi times its irradiance. What a surface emits is
//! not among it: light from what shines is direct light.

use crate::estimate::Estimate;
use crate::knob::LightKnobs;
use crate::side;
use crate::site::Site;
use chiaro_basis::math::Vec3;
use chiaro_basis::{Result, Run};
use chiaro_trace::{Hit, LightNumbers, Lights, Sequence, Surfaces, Tracer, Vertex};
use rayon::prelude::*;
use std::f32::consts::FRAC_1_PI;

/// A frame with its light, ready for rays.
#[derive(Clone, Copy)]
pub struct Lit<'a> {
    /// Rays.
    pub tracer: &'a Tracer<'a>,
    /// Textures.
    pub surfaces: &'a Surfaces<'a>,
    /// Light.
    pub lights: &'a Lights,
}

/// A piece of surface. Side 0 is the front.
#[derive(Clone, Copy, Debug, Default)]
pub struct Surfel {
    /// World position.
    pub position: Vec3,
    /// Unit normal of the front.
    pub normal: Vec3,
    /// In scene units squared, whichever sides live.
    pub area: f32,
    /// Which sides live.
    pub alive: [bool; 2],
    /// Linear RGB.
    pub albedo: [f32; 3],
    /// Radiance that leaves each side.
    pub radiance: [[f32; 3]; 2],
}

/// The surfels of a frame.
#[derive(Clone, Debug, Default)]
pub struct Surfels {
    /// In the order of their sites.
    pub all: Vec<Surfel>,
    /// Mean distance between neighbours: the root of area over number.
    pub spacing: f32,
    /// Whether their areas differ.
    pub uneven: bool,
    /// Which sides lie in a narrow gap, where light and eyes do not reach: none, or one of each surfel.
    pub covered: Vec<[bool; 2]>,
}

/// A surfel's area over the mean from which on areas differ.
const UNEVEN: f32 = 1.2;
/// Light samples a side of what shines, and the least and the most of the sky.
const GLOW_SAMPLES: u32 = 4;
const SKY_SAMPLES: [u32; 2] = [4, 16];
/// Up to so many surfels have the most samples of the sky; of more, as many in all.
const FEW: usize = 100_000;

impl Surfel {
    /// The area of a side that lives, or 0.
    pub fn side_area(&self, side: usize) -> f32 {
        if self.alive[side] { self.area } else { 0.0 }
    }

    /// Adds what both sides reflect of an irradiance.
    pub(crate) fn add(&mut self, irradiance: &[[f32; 3]; 2]) {
        for (radiance, e) in self.radiance.iter_mut().zip(irradiance) {
            (0..3).for_each(|c| radiance[c] += self.albedo[c] * FRAC_1_PI * e[c]);
        }
    }
}

impl Surfels {
    /// Lights the sites of a frame directly, and finds the dead sides.
    pub fn light(lit: &Lit, sites: &[Site], knobs: &LightKnobs, run: &Run) -> Result<Self> {
        let (mut surfels, sky) = Self::light_apart(lit, sites, knobs, run)?;
        surfels.all.par_iter_mut().zip(&sky).for_each(|(s, sky)| s.add(&sky.irradiance()));
        Ok(surfels)
    }

    /// The same without the light of the sky, which is told apart: noisy, one of each surfel; none without a sky.
    pub fn light_apart(
        lit: &Lit,
        sites: &[Site],
        knobs: &LightKnobs,
        run: &Run,
    ) -> Result<(Self, Vec<Estimate>)> {
        let mut all: Vec<Surfel> = run.stage("surfels", sites.len() as u64, || {
            sites.par_iter().map(|s| place(lit.tracer, s)).collect()
        });
        let area: f64 = all.iter().map(|s| f64::from(s.area)).sum();
        let spacing = (area / all.len().max(1) as f64).sqrt() as f32;
        let uneven = all.iter().any(|s| s.area > UNEVEN * spacing * spacing);
        let bounds = lit.tracer.frame.bounds();
        let near = (spacing, side::close(lit, &bounds, spacing));
        let [least, most] = SKY_SAMPLES;
        let of_sky =
            (most as usize * FEW / sites.len().max(1)).clamp(least as usize, most as usize);
        let of_sky = of_sky as u32;
        let sky = run.stage("direct", sites.len() as u64, || {
            let one = |(index, surfel): (usize, &mut Surfel)| {
                run.check()?;
                let sky = light(lit, &sites[index], surfel, (index as u64, of_sky));
                let by_sky = sky.is_lit();
                let covered = match knobs.side_rays {
                    0 => [false; 2],
                    rays => side::test((lit, by_sky), &bounds, surfel, near, (rays, index as u64)),
                };
                Ok((sky, covered))
            };
            all.par_iter_mut().enumerate().map(one).collect::<Result<Vec<_>>>()
        })?;
        let (sky, covered): (Vec<_>, Vec<_>) = sky.into_iter().unzip();
        let sky = if lit.lights.sky.is_some() { sky } else { Vec::new() };
        Ok((Self { all, spacing, uneven, covered }, sky))
    }

    /// How many sides are dead.
    pub fn dead_sides(&self) -> usize {
        self.all.iter().flat_map(|s| s.alive).filter(|a| !a).count()
    }
}

/// A surfel without light.
pub(crate) fn place(tracer: &Tracer, site: &Site) -> Surfel {
    let [a, b, c] = tracer.corners(site.object, site.face);
    let cross = (b - a).cross(c - a);
    let mirrored = tracer.frame.objects[site.object as usize].mirrored;
    Surfel {
        position: a + (b - a) * site.b[0] + (c - a) * site.b[1],
        normal: if mirrored { -cross } else { cross }.normalize_or(Vec3::Y),
        area: 0.5 * cross.length() * site.share,
        alive: [true; 2],
        ..Surfel::default()
    }
}

/// Light by what is in the scene; and by the sky.
fn light(lit: &Lit, site: &Site, surfel: &mut Surfel, (index, of_sky): (u64, u32)) -> Estimate {
    let hit = Hit { t: 0.0, object: site.object, face: site.face, b: site.b };
    let footprint = surfel.area.sqrt();
    let sequence = Sequence::new(index);
    let Lit { tracer, surfaces, lights } = *lit;
    let of_glow = if lights.glow.is_empty() { 0 } else { GLOW_SAMPLES };
    let of_sky = if lights.sky.is_some() { of_sky } else { 0 };
    let mut sky = Estimate::default();
    for side in 0..2 {
        let inward = if side == 0 { -surfel.normal } else { surfel.normal };
        let at = Vertex::of(tracer, surfaces, &hit, inward, footprint);
        surfel.albedo = at.albedo;
        let numbers = |k: u32| numbers(lights, &sequence, k, side as u32);
        let mut sum = lights.lamp_irradiance(tracer, &at, numbers(0).choice);
        for k in 0..of_glow {
            let e = lights.glow_irradiance(tracer, surfaces, &at, &numbers(k), false);
            (0..3).for_each(|i| sum[i] += e[i] / of_glow as f32);
        }
        let samples = (0..of_sky).map(|k| lights.sky_irradiance(tracer, &at, numbers(k).sky));
        sky.set(side, samples);
        surfel.radiance[side] = std::array::from_fn(|i| at.albedo[i] * FRAC_1_PI * sum[i]);
    }
    sky
}

/// The numbers for light sample `index`; `set` tells uses apart. Those that nothing asks for are not made.
pub(crate) fn numbers(lights: &Lights, sequence: &Sequence, index: u32, set: u32) -> LightNumbers {
    let point = |wanted: bool, pair: u32| match wanted {
        true => sequence.point(index, 3 * set + pair),
        false => [0.0; 2],
    };
    let [u, v] = point(!lights.glow.is_empty(), 0);
    let [triangle, choice] = sequence.point(index, 3 * set + 1);
    let sky = point(lights.sky.is_some(), 2);
    LightNumbers { glow: [triangle, u, v], sky, choice }
}
