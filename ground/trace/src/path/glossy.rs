//! Specular reflection where a path starts: its lobe and the lights are sampled, each weighed against the
//! other by the balance heuristic.

use super::{PathTracer, SPREAD, numbers};
use crate::gloss::Gloss;
use crate::lights::LightSample;
use crate::sample::Sequence;
use crate::tracer::Sides;
use crate::vertex::Vertex;

/// Pairs of dimensions of what is seen in reflections.
const PAIRS: u32 = 0x2000;

impl PathTracer<'_> {
    /// The light that a vertex reflects towards the eye specularly, by sample `index` of a sequence.
    pub fn specular(
        &self,
        at: &Vertex,
        gloss: &Gloss,
        sequence: &Sequence,
        index: u32,
    ) -> [f32; 3] {
        let mut sum = self.specular_of_lights(at, gloss, sequence, index);
        let towards = gloss.sample(sequence.point(index, PAIRS));
        let density = gloss.density(towards);
        if !(density > 0.0 && towards.dot(at.side) > 0.0) {
            return sum;
        }
        let weight = gloss.value(towards).map(|v| v / density);
        let mut add = |light: [f32; 3]| (0..3).for_each(|i| sum[i] += weight[i] * light[i]);
        let Some(hit) = self.tracer.met(&at.ray(towards, f32::INFINITY), Sides::Both) else {
            if let Some(sky) = &self.lights.sky {
                let own = density / (density + sky.density(towards));
                add(sky.radiance(towards).map(|l| l * own));
            }
            return sum;
        };
        let met = Vertex::of(self.tracer, self.surfaces, &hit, towards, SPREAD * hit.t);
        if met.emission != [0.0; 3] {
            let own = density / (density + self.lights.glow_density(&hit, towards));
            add(met.emission.map(|l| l * own));
        }
        if self.bounces > 0 {
            self.walk(met, 1, (sequence, index, PAIRS), |_, light| add(light));
        }
        sum
    }

    /// Lamps, one point of what shines, one direction of the sky.
    fn specular_of_lights(
        &self,
        at: &Vertex,
        gloss: &Gloss,
        sequence: &Sequence,
        index: u32,
    ) -> [f32; 3] {
        let mut sum = self.lights.specular_of_lamps(self.tracer, at, gloss);
        let numbers = numbers(sequence, index, (0, PAIRS + 0x800));
        let glow = self.lights.glow_sample(self.tracer, self.surfaces, at, numbers.glow);
        let sky = self.lights.sky_sample(at, numbers.sky);
        for LightSample { ray, radiance, density, .. } in glow.into_iter().chain(sky) {
            let value = gloss.value(ray.direction);
            if value == [0.0; 3] || ray.direction.dot(at.side) <= 0.0 || self.tracer.occluded(&ray)
            {
                continue;
            }
            let scale = 1.0 / (density + gloss.density(ray.direction));
            (0..3).for_each(|i| sum[i] += value[i] * radiance[i] * scale);
        }
        sum
    }
}
