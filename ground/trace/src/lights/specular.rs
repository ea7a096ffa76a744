//! Lights as a glossy point sees them: lamps in closed form, points of what shines and directions of the
//! sky with their densities.

use super::{Lights, lamp_at};
use crate::gloss::Gloss;
use crate::light::Lamp;
use crate::surface::Surfaces;
use crate::tracer::{Hit, Ray, Tracer};
use crate::vertex::Vertex;
use chiaro_basis::math::Vec3;
use chiaro_image::colour::luminance;

/// A point that shines, as another point sees it.
#[derive(Clone, Copy, Debug)]
pub struct LightSample {
    /// The ray that must be free.
    pub ray: Ray,
    /// Where it is; for a sky meaningless.
    pub position: Vec3,
    /// Linear RGB.
    pub radiance: [f32; 3],
    /// With which it was found, per solid angle.
    pub density: f32,
}

/// What is reflected less than this share of what a white diffuse surface would reflect is left out.
const FAINT: f32 = 1e-3;

impl Lights {
    /// What a point reflects of the lamps of no size, each with a shadow ray.
    pub fn specular_of_lamps(&self, tracer: &Tracer, at: &Vertex, gloss: &Gloss) -> [f32; 3] {
        let mut sum = [0.0; 3];
        for lamp in &self.lamps {
            let Some((value, ray)) = specular(lamp, at, gloss) else { continue };
            if !tracer.occluded(&ray) {
                (0..3).for_each(|i| sum[i] += value[i]);
            }
        }
        sum
    }

    /// A point of what shines for three numbers in [0, 1).
    pub fn glow_sample(
        &self,
        tracer: &Tracer,
        surfaces: &Surfaces,
        at: &Vertex,
        numbers: [f32; 3],
    ) -> Option<LightSample> {
        let point = self.glow.point(numbers)?;
        let triangle = &self.glow.triangles()[point.triangle];
        let (towards, distance) = (point.position - at.position).normalize_and_length();
        let outward = -triangle.normal.dot(towards);
        let outward = if triangle.two_sided { outward.abs() } else { outward };
        if outward <= 0.0 || outward.is_nan() {
            return None;
        }
        let ray = at.ray_to(point.position)?;
        let density = point.density * distance * distance / outward;
        let hit = Hit { t: 0.0, object: triangle.object, face: triangle.face, b: point.b };
        let radiance = match triangle.textured {
            true => surfaces.emission(tracer, &hit, 0.0),
            false => triangle.radiance,
        };
        Some(LightSample { ray, position: point.position, radiance, density })
    }

    /// A direction of the sky for two numbers in [0, 1).
    pub fn sky_sample(&self, at: &Vertex, numbers: [f32; 2]) -> Option<LightSample> {
        let s = self.sky.as_ref()?.sample(numbers)?;
        let ray = at.ray_along(s.towards, f32::INFINITY)?;
        Some(LightSample { ray, position: s.towards, radiance: s.radiance, density: s.density })
    }

    /// The density, per solid angle, with which [`Lights::glow_sample`] finds what a ray hit.
    pub fn glow_density(&self, hit: &Hit, direction: Vec3) -> f32 {
        let Some(index) = self.glow.find(hit) else { return 0.0 };
        let outward = self.glow.triangles()[index].normal.dot(direction).abs();
        self.glow.density(index) * hit.t * hit.t / outward.max(1e-9)
    }
}

/// What is reflected of a lamp if nothing is in the way, and the ray that must be free.
fn specular(lamp: &Lamp, at: &Vertex, gloss: &Gloss) -> Option<([f32; 3], Ray)> {
    let (_, ray) = lamp_at(lamp, at)?;
    let arrival = lamp.arrival(at.position)?;
    let value = gloss.value(arrival.towards);
    let strong = luminance(value) > FAINT * gloss.normal.dot(arrival.towards);
    let strength = lamp.colour.map(|c| c * arrival.strength);
    strong.then(|| (std::array::from_fn(|i| value[i] * strength[i]), ray))
}
