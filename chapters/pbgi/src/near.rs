//! The near field: rays on the triangles, and the light of what they meet.

use crate::bounce::Indirect;
use crate::grid::SurfelGrid;
use crate::surfel::{Lit, Surfels, numbers};
use chiaro_basis::math::Vec3;
use chiaro_trace::{Hit, Sequence, Vertex, path::SPREAD};
use std::f32::consts::FRAC_1_PI;

/// What near rays need to know of the surfels: the light that was reflected before, by place.
pub struct Reflected {
    /// Surfels by place.
    pub grid: SurfelGrid,
    /// Irradiance by reflected light of each surfel's sides; empty when there is none.
    pub irradiance: Indirect,
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
/// reflected light of the nearest surfel.
pub fn shade(
    lit: &Lit,
    surfels: &Surfels,
    reflected: &Reflected,
    hit: &Hit,
    direction: Vec3,
    sequence: &Sequence,
    index: u32,
) -> NearHit {
    let (at, mut e) = self::lit(lit, hit, direction, sequence, index);
    if !reflected.irradiance.is_empty()
        && let Some((k, side)) = reflected.grid.nearest(surfels, at.position, at.side)
    {
        let more = reflected.irradiance[k as usize][side];
        (0..3).for_each(|c| e[c] += more[c]);
    }
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
    let at = Vertex::of(lit.tracer, lit.surfaces, hit, direction, SPREAD * hit.t);
    let numbers = numbers(lit.lights, sequence, index, 1);
    (at, lit.lights.irradiance_by_one_ray(lit.tracer, lit.surfaces, &at, &numbers))
}

/// Radiance of a Lambertian surface under an irradiance.
pub(crate) fn radiance(at: &Vertex, irradiance: [f32; 3]) -> [f32; 3] {
    std::array::from_fn(|c| at.albedo[c] * FRAC_1_PI * irradiance[c])
}
