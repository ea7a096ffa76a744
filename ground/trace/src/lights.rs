//! [`Lights`]: everything that lights a frame, and the irradiance that a point receives from it.
//!
//! The irradiance of (5.1)'s direct part is estimated by next-event estimation: every lamp, one
//! point of what shines, one direction of the sky. Where the caller also follows rays to what
//! shines, the two are combined by the balance heuristic (Veach and Guibas 1995).

mod specular;

pub use specular::LightSample;

use crate::glow::Glow;
use crate::light::Lamp;
use crate::sky::Sky;
use crate::surface::Surfaces;
use crate::tracer::{Hit, Ray, Tracer};
use crate::vertex::Vertex;
use chiaro_basis::math::Vec3;
use chiaro_image::colour::luminance;
use std::f32::consts::FRAC_1_PI;
use std::sync::Arc;

/// Everything that lights a frame.
#[derive(Clone, Debug, Default)]
pub struct Lights {
    /// Lamps of no size.
    pub lamps: Vec<Lamp>,
    /// Surfaces that shine.
    pub glow: Glow,
    /// Light from all around.
    pub sky: Option<Arc<Sky>>,
}

/// Numbers in [0, 1) that choose light samples.
#[derive(Clone, Copy, Debug)]
pub struct LightNumbers {
    /// Which shining triangle, and where on it.
    pub glow: [f32; 3],
    /// Which direction of the sky.
    pub sky: [f32; 2],
    /// Which lamp, where there are many; which of all kinds.
    pub choice: f32,
}

/// Lamps up to this number are all visited; of more, one is chosen.
const ALL_LAMPS: usize = 4;

/// Unshadowed irradiance and the ray that must be free for it.
struct Candidate {
    irradiance: [f32; 3],
    ray: Ray,
}

impl Candidate {
    fn times(self, weight: f32) -> Self {
        Self { irradiance: self.irradiance.map(|e| e * weight), ..self }
    }
}

impl Lights {
    /// Whether there is no light at all.
    pub fn is_empty(&self) -> bool {
        self.lamps.is_empty()
            && self.glow.is_empty()
            && self.sky.as_ref().is_none_or(|s| s.is_black())
    }

    /// Irradiance at a vertex, one sample of each kind of light; `shared` when the caller's rays
    /// also meet what shines and the sky, and weigh it by [`Lights::ray_weight_to_surface`] and
    /// [`Lights::ray_weight_to_sky`].
    pub fn irradiance(
        &self,
        tracer: &Tracer,
        surfaces: &Surfaces,
        at: &Vertex,
        numbers: &LightNumbers,
        shared: bool,
    ) -> [f32; 3] {
        let lamps = self.lamp_irradiance(tracer, at, numbers.choice);
        let glow = self.glow_irradiance(tracer, surfaces, at, numbers, shared);
        let sky = self.sky_candidate(at, numbers.sky, shared).into_iter();
        plus(plus(lamps, glow), arriving(tracer, sky))
    }

    /// Irradiance at a vertex by the lamps, or where there are many by one that a number chooses.
    pub fn lamp_irradiance(&self, tracer: &Tracer, at: &Vertex, choice: f32) -> [f32; 3] {
        let all = self.lamps.iter().filter_map(|l| from_lamp(l, at));
        if self.lamps.len() <= ALL_LAMPS {
            return arriving(tracer, all);
        }
        let mut chosen = Reservoir::new(choice);
        all.for_each(|c| chosen.offer(c));
        let weight = chosen.weight();
        arriving(tracer, chosen.kept.map(|c| c.times(weight)).into_iter())
    }

    /// Irradiance at a vertex by one point of what shines.
    pub fn glow_irradiance(
        &self,
        tracer: &Tracer,
        surfaces: &Surfaces,
        at: &Vertex,
        numbers: &LightNumbers,
        shared: bool,
    ) -> [f32; 3] {
        let glow = self.glow_candidate(tracer, surfaces, at, numbers.glow, shared);
        arriving(tracer, glow.into_iter())
    }

    /// Irradiance at a vertex by one direction of the sky, and what it would be if nothing hid it.
    pub fn sky_irradiance(
        &self,
        tracer: &Tracer,
        at: &Vertex,
        numbers: [f32; 2],
    ) -> ([f32; 3], [f32; 3]) {
        let Some(sky) = self.sky_candidate(at, numbers, false) else { return Default::default() };
        let open = sky.irradiance;
        (arriving(tracer, std::iter::once(sky)), open)
    }

    /// Irradiance at a vertex by what shines and by the sky, one sample of each.
    pub fn soft_irradiance(
        &self,
        tracer: &Tracer,
        surfaces: &Surfaces,
        at: &Vertex,
        numbers: &LightNumbers,
    ) -> [f32; 3] {
        let (sky, _) = self.sky_irradiance(tracer, at, numbers.sky);
        plus(self.glow_irradiance(tracer, surfaces, at, numbers, false), sky)
    }

    /// Irradiance at a vertex by one shadow ray, to one sample chosen by what it would give, of the `sky` as well or
    /// of the scene alone.
    pub fn irradiance_by_one_ray(
        &self,
        tracer: &Tracer,
        surfaces: &Surfaces,
        at: &Vertex,
        numbers: &LightNumbers,
        sky: bool,
    ) -> [f32; 3] {
        let mut chosen = Reservoir::new(numbers.choice);
        self.lamps.iter().filter_map(|l| from_lamp(l, at)).for_each(|c| chosen.offer(c));
        let glow = self.glow_candidate(tracer, surfaces, at, numbers.glow, false);
        let sky = self.sky_candidate(at, numbers.sky, false).filter(|_| sky);
        glow.into_iter().chain(sky).for_each(|c| chosen.offer(c));
        let weight = chosen.weight();
        match chosen.kept {
            Some(c) if !tracer.occluded(&c.ray) => c.irradiance.map(|e| e * weight),
            _ => [0.0; 3],
        }
    }

    /// A point of what shines, chosen by what it would give.
    fn glow_candidate(
        &self,
        tracer: &Tracer,
        surfaces: &Surfaces,
        at: &Vertex,
        numbers: [f32; 3],
        shared: bool,
    ) -> Option<Candidate> {
        let point = self.glow.point_seen(at.position, at.normal, numbers)?;
        let triangle = &self.glow.triangles()[point.triangle];
        let offset = point.position - at.position;
        let (towards, distance) = offset.normalize_and_length();
        let cosine = at.normal.dot(towards);
        let outward = -triangle.normal.dot(towards);
        let outward = if triangle.two_sided { outward.abs() } else { outward };
        if !(cosine > 0.0 && outward > 0.0) {
            return None;
        }
        let ray = at.ray_to(point.position)?;
        let density = point.density * distance * distance / outward;
        let other = if shared { cosine * FRAC_1_PI } else { 0.0 };
        let factor = cosine / (density + other);
        let hit = Hit { t: 0.0, object: triangle.object, face: triangle.face, b: point.b };
        let radiance = if triangle.textured {
            surfaces.emission(tracer, &hit, 0.0)
        } else {
            triangle.radiance
        };
        Some(Candidate { irradiance: radiance.map(|l| l * factor), ray })
    }

    fn sky_candidate(&self, at: &Vertex, numbers: [f32; 2], shared: bool) -> Option<Candidate> {
        let s = self.sky.as_ref()?.sample(numbers)?;
        let cosine = at.normal.dot(s.towards);
        if cosine <= 0.0 {
            return None;
        }
        let ray = at.ray_along(s.towards, f32::INFINITY)?;
        let other = if shared { cosine * FRAC_1_PI } else { 0.0 };
        let factor = cosine / (s.density + other);
        Some(Candidate { irradiance: s.radiance.map(|l| l * factor), ray })
    }

    /// The weight of emission met by a ray of cosine density from a vertex.
    pub fn ray_weight_to_surface(&self, hit: &Hit, at: &Vertex, direction: Vec3) -> f32 {
        let Some(index) = self.glow.find(hit) else { return 1.0 };
        let outward = self.glow.triangles()[index].normal.dot(direction).abs();
        let own = at.normal.dot(direction) * FRAC_1_PI;
        let density = self.glow.density_seen(index, (at.position, at.normal), (direction, hit.t));
        let other = density * hit.t * hit.t / outward.max(1e-9);
        own / (own + other)
    }

    /// The weight of the sky met by such a ray.
    pub fn ray_weight_to_sky(&self, direction: Vec3, cosine: f32) -> f32 {
        let own = cosine * FRAC_1_PI;
        own / (own + self.sky.as_ref().map_or(0.0, |s| s.density(direction)))
    }
}

/// What arrives of candidates.
fn arriving(tracer: &Tracer, all: impl Iterator<Item = Candidate>) -> [f32; 3] {
    all.filter(|c| !tracer.occluded(&c.ray)).fold([0.0; 3], |sum, c| plus(sum, c.irradiance))
}

fn plus(a: [f32; 3], b: [f32; 3]) -> [f32; 3] {
    std::array::from_fn(|c| a[c] + b[c])
}

fn from_lamp(lamp: &Lamp, at: &Vertex) -> Option<Candidate> {
    let arrival = lamp.arrival(at.position)?;
    let cosine = at.normal.dot(arrival.towards);
    if cosine <= 0.0 {
        return None;
    }
    let ray = match lamp.patch {
        Some(_) => at.ray_to(lamp.position)?,
        None => at.ray_along(arrival.towards, arrival.distance)?,
    };
    Some(Candidate { irradiance: lamp.colour.map(|c| c * arrival.strength * cosine), ray })
}

/// The unshadowed irradiance from a lamp, and the ray that must be free for it.
pub(crate) fn lamp_at(lamp: &Lamp, at: &Vertex) -> Option<([f32; 3], Ray)> {
    from_lamp(lamp, at).map(|c| (c.irradiance, c.ray))
}

/// Keeps one of the candidates it is offered, each with a probability that grows with its light.
struct Reservoir {
    kept: Option<Candidate>,
    kept_value: f32,
    total: f32,
    number: f32,
}

impl Reservoir {
    fn new(number: f32) -> Self {
        Self { kept: None, kept_value: 0.0, total: 0.0, number }
    }

    fn offer(&mut self, candidate: Candidate) {
        let value = luminance(candidate.irradiance);
        if !(value > 0.0 && value.is_finite()) {
            return;
        }
        self.total += value;
        let share = value / self.total;
        // The number is stretched to [0, 1) again, so that one suffices for all.
        if self.number < share {
            self.number /= share;
            (self.kept, self.kept_value) = (Some(candidate), value);
        } else {
            self.number = (self.number - share) / (1.0 - share).max(1e-9);
        }
    }

    fn weight(&self) -> f32 {
        if self.kept_value > 0.0 { self.total / self.kept_value } else { 0.0 }
    }
}
