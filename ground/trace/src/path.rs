//! The reference: path tracing of (5.1) with next-event estimation.
//!
//! 1. A path starts where a ray from the eye meets the scene, and goes on in directions of cosine
//!    density about the shading normal.
//! 2. At every vertex light samples are taken ([`Lights::irradiance`]); what shines and what a
//!    path meets by itself is weighed against them by the balance heuristic.
//! 3. Where a path starts, light is also reflected specularly, if that is asked for: by samples of its lobe
//!    and of lights, weighed by the same heuristic (`glossy`). Behind it everything is Lambertian.
//! 4. Samples of a pixel are points of one scrambled (0, 2) sequence, in batches whose scramblings
//!    are independent, so that the error can be told from their spread.
//!
//! Guaranteed: unbiased up to the chosen number of bounces (beyond the
//! fourth vertex by Russian roulette); the same bits for any number of threads. Not guaranteed:
//! energy where normal textures turn reflected light below the surface; such directions are black.

mod glossy;

use crate::gbuffer::GBuffer;
use crate::gloss::Gloss;
use crate::lights::{LightNumbers, Lights};
use crate::sample::Sequence;
use crate::surface::Surfaces;
use crate::tracer::{Ray, Sides, Tracer};
use crate::vertex::Vertex;
use chiaro_basis::math::Vec3;
use chiaro_basis::random;
use chiaro_basis::{Result, Run};
use chiaro_image::Plane;
use chiaro_scene::Pose;
use std::f32::consts::FRAC_1_PI;

/// A lit scene, ready for paths.
#[derive(Clone, Copy)]
pub struct PathTracer<'a> {
    /// Rays.
    pub tracer: &'a Tracer<'a>,
    /// Textures.
    pub surfaces: &'a Surfaces<'a>,
    /// Light.
    pub lights: &'a Lights,
    /// Bounces of indirect light; 0 is direct light alone.
    pub bounces: u32,
    /// Whether what is seen is glossy as its material says; else it is Lambertian.
    pub glossy: bool,
}

/// Radiance towards the eye, in its two parts.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Split {
    /// Emitted, and reflected once.
    pub direct: [f32; 3],
    /// Reflected more often, the last time diffusely.
    pub indirect: [f32; 3],
    /// Reflected towards the eye specularly.
    pub specular: [f32; 3],
}

/// A picture in the making: sums over samples.
#[derive(Clone, Debug)]
pub struct PathImage {
    sums: Plane<Pixel>,
    batches: u32,
    samples: u32,
}

/// A pixel's sums.
#[derive(Clone, Copy, Debug, Default)]
struct Pixel {
    light: Split,
    /// Samples that met geometry.
    covered: u32,
    /// Background radiance.
    beyond: [f32; 3],
    /// Sum of squares of the batches' mean indirect grey.
    squares: f64,
}

/// Where the samples of a pixel go.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Aim {
    /// All through its centre, as a [`GBuffer`]'s: to compare with other methods.
    Centre,
    /// Spread over its square: a picture without jagged edges.
    Spread,
}

impl PathImage {
    /// A picture without samples.
    pub fn new(width: usize, height: usize) -> Self {
        Self { sums: Plane::filled(width, height, Pixel::default()), batches: 0, samples: 0 }
    }

    /// Samples a pixel so far.
    pub fn samples(&self) -> u32 {
        self.samples
    }

    /// Mean direct light.
    pub fn direct(&self) -> Plane<[f32; 3]> {
        self.mean(|p| p.light.direct)
    }

    /// Mean indirect light.
    pub fn indirect(&self) -> Plane<[f32; 3]> {
        self.mean(|p| p.light.indirect)
    }

    /// Mean light that was reflected towards the eye specularly.
    pub fn specular(&self) -> Plane<[f32; 3]> {
        self.mean(|p| p.light.specular)
    }

    /// Mean background radiance, weighted by the share that is not covered.
    pub fn beyond(&self) -> Plane<[f32; 3]> {
        self.mean(|p| p.beyond)
    }

    /// The share of samples that met geometry.
    pub fn coverage(&self) -> Plane<f32> {
        self.sums.map(|p| p.covered as f32 / self.samples.max(1) as f32)
    }

    fn mean(&self, f: impl Fn(&Pixel) -> [f32; 3] + Sync + Send) -> Plane<[f32; 3]> {
        let scale = 1.0 / self.samples.max(1) as f32;
        self.sums.map(|p| f(p).map(|v| v * scale))
    }

    /// The standard error of the mean indirect grey, root mean square over the pixels of `mask`,
    /// over the mean there; `None` before the second batch or where there is no light.
    pub fn relative_error(&self, mask: &Plane<bool>) -> Option<f64> {
        if self.batches < 2 {
            return None;
        }
        let n = f64::from(self.batches);
        let (mut variance, mut mean, mut count) = (0.0, 0.0, 0.0);
        for (p, _) in self.sums.pixels().iter().zip(mask.pixels()).filter(|(_, m)| **m) {
            let m = f64::from(grey(p.light.indirect)) / f64::from(self.samples);
            variance += ((p.squares / n - m * m) / (n - 1.0)).max(0.0);
            mean += m;
            count += 1.0;
        }
        (mean > 0.0).then(|| (variance / count).sqrt() / (mean / count))
    }
}

fn grey(c: [f32; 3]) -> f32 {
    (c[0] + c[1] + c[2]) / 3.0
}

impl PathTracer<'_> {
    /// Adds a batch of `samples` to every pixel.
    pub fn add(
        &self,
        image: &mut PathImage,
        pose: &Pose,
        samples: u32,
        aim: Aim,
        run: &Run,
    ) -> Result<()> {
        let (width, height) = image.sums.size();
        let batch = image.batches;
        let fresh = Plane::from_fn(width, height, |x, y| {
            if run.check().is_err() {
                return Pixel::default();
            }
            let index = (y * width + x) as u64;
            let seed = random::hash(random::hash(run.seed, index), u64::from(batch));
            self.pixel(pose, (x, y), (width, height), samples, aim, &Sequence::new(seed))
        });
        run.check()?;
        for (sum, p) in image.sums.pixels_mut().iter_mut().zip(fresh.pixels()) {
            for i in 0..3 {
                sum.light.direct[i] += p.light.direct[i];
                sum.light.indirect[i] += p.light.indirect[i];
                sum.light.specular[i] += p.light.specular[i];
                sum.beyond[i] += p.beyond[i];
            }
            sum.covered += p.covered;
            sum.squares += f64::from(grey(p.light.indirect) / samples as f32).powi(2);
        }
        image.batches += 1;
        image.samples += samples;
        Ok(())
    }

    fn pixel(
        &self,
        pose: &Pose,
        (x, y): (usize, usize),
        (width, height): (usize, usize),
        samples: u32,
        aim: Aim,
        sequence: &Sequence,
    ) -> Pixel {
        let mut sum = Pixel::default();
        let (w, h) = (width as f32, height as f32);
        let mut first = None;
        for index in 0..samples {
            let [dx, dy] = match aim {
                Aim::Centre => [0.5; 2],
                Aim::Spread => sequence.point(index, 0),
            };
            if first.is_none() || aim == Aim::Spread {
                let (origin, direction) = pose.ray(x as f32 + dx, y as f32 + dy, w, h);
                first = Some((self.seen(pose, origin, direction, h), direction));
            }
            match first {
                Some((Some((vertex, gloss)), _)) => {
                    let mut light = self.path(vertex, sequence, index);
                    if let Some(gloss) = &gloss {
                        light.specular = self.specular(&vertex, gloss, sequence, index);
                    }
                    for i in 0..3 {
                        sum.light.direct[i] += light.direct[i];
                        sum.light.indirect[i] += light.indirect[i];
                        sum.light.specular[i] += light.specular[i];
                    }
                    sum.covered += 1;
                }
                Some((None, direction)) => {
                    let beyond = self.lights.sky.as_ref().map(|s| s.backdrop(direction));
                    (0..3).for_each(|i| sum.beyond[i] += beyond.unwrap_or_default()[i]);
                }
                None => {}
            }
        }
        sum
    }

    /// What a ray from the eye meets, and its gloss.
    fn seen(
        &self,
        pose: &Pose,
        origin: Vec3,
        direction: Vec3,
        height: f32,
    ) -> Option<(Vertex, Option<Gloss>)> {
        let start = pose.near / direction.dot(pose.forward);
        let ray = Ray { origin: origin + direction * start, direction, t_max: f32::INFINITY };
        let hit = self.tracer.seen(&ray)?;
        let depth = (start + hit.t) * direction.dot(pose.forward);
        let footprint = pose.pixel_size(depth, height);
        let surface = self.surfaces.at(self.tracer, &hit, direction, footprint);
        let vertex = Vertex::of_surface(self.tracer, &hit, &surface, direction);
        let gloss = Gloss::of_surface(self.tracer, &surface, direction);
        if !self.glossy || gloss.is_dull() {
            return Some((vertex, None));
        }
        Some((Vertex { albedo: gloss.diffuse, ..vertex }, Some(gloss)))
    }

    /// The light that leaves a first vertex towards the eye, by sample `index` of a sequence.
    pub fn path(&self, first: Vertex, sequence: &Sequence, index: u32) -> Split {
        let mut split = Split { direct: first.emission, ..Split::default() };
        self.walk(first, 0, (sequence, index, 0), |k, light| {
            let part = if k == 0 { &mut split.direct } else { &mut split.indirect };
            (0..3).for_each(|i| part[i] += light[i]);
        });
        split
    }

    /// Follows a path from its vertex number `start`, with numbers from a pair of dimensions on; `add` is told
    /// which vertex light was reflected at, and how much of it leaves the first.
    fn walk(
        &self,
        mut vertex: Vertex,
        start: u32,
        (sequence, index, pairs): (&Sequence, u32, u32),
        mut add: impl FnMut(u32, [f32; 3]),
    ) {
        let mut throughput = [1.0f32; 3];
        for k in start..=self.bounces {
            let numbers = numbers(sequence, index, (k, pairs));
            let e = self.lights.irradiance(self.tracer, self.surfaces, &vertex, &numbers, true);
            (0..3).for_each(|i| throughput[i] *= vertex.albedo[i]);
            add(k, std::array::from_fn(|i| throughput[i] * FRAC_1_PI * e[i]));
            if !survives(&mut throughput, k, (sequence, index, pairs)) {
                break;
            }
            let next = self.step(&vertex, sequence.point(index, pairs + 4 * k + 4));
            let Some(next) = next else { break };
            add(k, std::array::from_fn(|i| throughput[i] * next.light[i]));
            let Some(v) = next.vertex else { break };
            vertex = v;
        }
    }

    /// Goes on from a vertex; the light that is met counts by its weight.
    fn step(&self, from: &Vertex, numbers: [f32; 2]) -> Option<Step> {
        let direction = from.cosine_direction(numbers);
        let cosine = from.normal.dot(direction);
        if from.side.dot(direction) <= 0.0 || cosine <= 0.0 {
            return None;
        }
        let Some(hit) = self.tracer.met(&from.ray(direction, f32::INFINITY), Sides::Both) else {
            let sky = self.lights.sky.as_ref()?;
            let weight = self.lights.ray_weight_to_sky(direction, cosine);
            return Some(Step { light: sky.radiance(direction).map(|l| l * weight), vertex: None });
        };
        let footprint = SPREAD * hit.t;
        let vertex = Vertex::of(self.tracer, self.surfaces, &hit, direction, footprint);
        let mut light = vertex.emission;
        if light != [0.0; 3] {
            let weight = self.lights.ray_weight_to_surface(&hit, from, direction);
            light = light.map(|l| l * weight);
        }
        Some(Step { light, vertex: Some(vertex) })
    }
}

/// The width of a diffusely reflected ray, radians: what textures are averaged over.
pub const SPREAD: f32 = 0.05;

/// A step of a path: light met, weighted, and where the path goes on.
struct Step {
    light: [f32; 3],
    vertex: Option<Vertex>,
}

/// The numbers for light samples at vertex `k`.
fn numbers(sequence: &Sequence, index: u32, (k, pairs): (u32, u32)) -> LightNumbers {
    let point = |i: u32| sequence.point(index, pairs + 4 * k + i);
    let ([u, v], [choice, lamp]) = (point(1), point(2));
    LightNumbers { glow: [choice, u, v], sky: point(3), choice: lamp }
}

/// Russian roulette from the fourth bounce on.
fn survives(
    throughput: &mut [f32; 3],
    k: u32,
    (sequence, index, pairs): (&Sequence, u32, u32),
) -> bool {
    let most = throughput.iter().copied().fold(0.0, f32::max);
    if k < 4 {
        return most > 0.0;
    }
    let chance = most.min(0.95);
    let [number, _] = sequence.point(index, pairs + 0x1000 + k);
    *throughput = throughput.map(|t| t / chance.max(1e-9));
    number < chance
}

/// Radiance of direct and indirect light through the pixel centres of a buffer: the reference that
/// other methods are measured by. Stops when the relative error is below `target` or `most`
/// samples are reached.
pub fn reference(
    paths: &PathTracer,
    buffer: &GBuffer,
    target: f64,
    most: u32,
    run: &Run,
) -> Result<(PathImage, Option<f64>)> {
    let (width, height) = buffer.size();
    let mut image = PathImage::new(width, height);
    const BATCH: u32 = 16;
    loop {
        paths.add(&mut image, &buffer.pose, BATCH, Aim::Centre, run)?;
        let error = image.relative_error(&buffer.covered);
        if image.samples() + BATCH > most || error.is_some_and(|e| e <= target) {
            return Ok((image, error));
        }
    }
}
