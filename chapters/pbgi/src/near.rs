//! The near field: rays on the triangles, and the light of what they meet.
//!
//! One shadow ray tells too little of the sky, which may be seen through a gap. Its light is asked of surfels, as
//! that which was reflected before.

use crate::bounce::Indirect;
use crate::grid::SurfelGrid;
use crate::surfel::{Lit, Surfels, numbers};
use chiaro_basis::math::Vec3;
use chiaro_trace::{Hit, Sequence, Vertex, path::SPREAD};
use std::f32::consts::FRAC_1_PI;

/// What near rays need to know of the surfels: the light of the sky and that which was reflected before, by place.
pub struct Reflected {
    /// Surfels by place.
    pub grid: SurfelGrid,
    /// Irradiance by reflected light of each surfel's sides; empty when there is none.
    pub irradiance: Indirect,
    /// Irradiance by the sky of each surfel's sides; empty when there is none.
    pub sky: Indirect,
}

impl Reflected {
    /// The light of the sky, if it is known, and that which was reflected before, by the nearest surfel.
    fn at(&self, surfels: &Surfels, at: &Vertex) -> Option<[f32; 3]> {
        if self.irradiance.is_empty() && self.sky.is_empty() {
            return None;
        }
        let (k, side) = self.grid.nearest(surfels, at.position, at.side)?;
        let of = |all: &Indirect| all.get(k as usize).map_or([0.0; 3], |e| e[side]);
        let (reflected, sky) = (of(&self.irradiance), of(&self.sky));
        Some(std::array::from_fn(|c| reflected[c] + sky[c]))
    }
}

/// A point that a near ray met.
#[derive(Clone, Copy, Debug)]
pub struct NearHit {
    /// World position.
    pub position: Vec3,
    /// Radiance that leaves it.
    pub radiance: [f32; 3],
}

/// The light that leaves what a near ray met: texture, one shadow ray to one light sample, and the
/// light of the sky and of reflection by the nearest surfel.
pub fn shade(
    lit: &Lit,
    surfels: &Surfels,
    reflected: &Reflected,
    hit: &Hit,
    direction: Vec3,
    sequence: &Sequence,
    index: u32,
) -> NearHit {
    let at = vertex(lit, hit, direction);
    let more = reflected.at(surfels, &at);
    let by_ray = reflected.sky.is_empty() || more.is_none();
    let mut e = irradiance(lit, &at, (sequence, index), by_ray);
    more.into_iter().for_each(|more| (0..3).for_each(|c| e[c] += more[c]));
    NearHit { position: at.position, radiance: radiance(&at, e) }
}

/// What a ray met, and its irradiance by one shadow ray to one light sample.
pub(crate) fn lit(
    lit: &Lit,
    hit: &Hit,
    direction: Vec3,
    sequence: &Sequence,
    index: u32,
) -> (Vertex, [f32; 3]) {
    let at = vertex(lit, hit, direction);
    (at, irradiance(lit, &at, (sequence, index), true))
}

fn vertex(lit: &Lit, hit: &Hit, direction: Vec3) -> Vertex {
    Vertex::of(lit.tracer, lit.surfaces, hit, direction, SPREAD * hit.t)
}

fn irradiance(lit: &Lit, at: &Vertex, (sequence, index): (&Sequence, u32), sky: bool) -> [f32; 3] {
    let numbers = numbers(lit.lights, sequence, index, 1);
    lit.lights.irradiance_by_one_ray(lit.tracer, lit.surfaces, at, &numbers, sky)
}

/// Radiance of a Lambertian surface under an irradiance.
pub(crate) fn radiance(at: &Vertex, irradiance: [f32; 3]) -> [f32; 3] {
    std::array::from_fn(|c| at.albedo[c] * FRAC_1_PI * irradiance[c])
}
