//! From irradiance at pixel centres to radiance without jagged edges.
//!
//! A pixel whose neighbours lie on the same smooth surface is its albedo times its irradiance. Any
//! other is the mean over a grid of samples inside it, each with a ray, an albedo and an emission of
//! its own; the irradiance, which costs, is taken from those of the 3 x 3 centres around that lie on
//! the sample's surface, and scaled where a crevice is narrower than a pixel (`crevice`).

use crate::crevice::Crevices;
use crate::surfel::{Lit, numbers};
use chiaro_basis::math::Vec3;
use chiaro_basis::{Result, Run};
use chiaro_image::Plane;
use chiaro_image::colour::luminance;
use chiaro_trace::{Direct, GBuffer, Gloss, Ray, Sequence, Vertex, albedo, lamp_irradiance};
use std::f32::consts::FRAC_1_PI;

/// A pixel's light towards the eye.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Seen {
    /// Emitted, and reflected once.
    pub direct: [f32; 3],
    /// Reflected more often, the last time diffusely.
    pub indirect: [f32; 3],
    /// Reflected towards the eye specularly.
    pub specular: [f32; 3],
    /// Radiance from beyond the scene, times the share that is not covered.
    pub beyond: [f32; 3],
    /// The share that shows geometry.
    pub coverage: f32,
}

/// Irradiance at the pixel centres of a buffer.
#[derive(Clone, Copy)]
pub struct Irradiance<'a> {
    /// By direct light.
    pub direct: &'a Direct,
    /// By reflected light.
    pub indirect: &'a Plane<[f32; 3]>,
    /// Radiance towards the eye by specular reflection; without it all is Lambertian.
    pub specular: Option<&'a Plane<[f32; 3]>>,
}

/// Light samples for a sample that no centre around shares its surface with.
const OWN_SAMPLES: u32 = 16;

/// The light of each pixel, from `side` x `side` samples where there are edges.
pub fn resolve(
    lit: &Lit,
    buffer: &GBuffer,
    irradiance: &Irradiance,
    side: u32,
    run: &Run,
) -> Result<Plane<Seen>> {
    let (width, height) = buffer.size();
    let crevices = (side > 1).then(|| Crevices::find(lit, buffer));
    let plane = Plane::from_fn(width, height, |x, y| {
        if run.check().is_err() {
            return Seen::default();
        }
        match &crevices {
            Some(found) if is_edge(buffer, (x, y)) || is_shadow_edge(irradiance, (x, y)) => {
                samples(lit, buffer, (irradiance, found), (x, y), side)
            }
            _ => centre(lit, buffer, irradiance, (x, y)),
        }
    });
    run.check()?;
    Ok(plane)
}

/// What is seen through a pixel's centre alone.
pub fn centre(lit: &Lit, buffer: &GBuffer, irradiance: &Irradiance, pixel: (usize, usize)) -> Seen {
    if !buffer.covered[pixel] {
        let (w, h) = buffer.size();
        let (x, y) = (pixel.0 as f32 + 0.5, pixel.1 as f32 + 0.5);
        let (_, direction) = buffer.pose.ray(x, y, w as f32, h as f32);
        return Seen { beyond: beyond(lit, direction), ..Seen::default() };
    }
    let gloss = irradiance.specular.map(|_| Gloss::of_pixel(lit.tracer, buffer, pixel));
    let albedo = gloss.as_ref().map_or(albedo(buffer.base_colour[pixel]), |g| g.diffuse);
    let matt = gloss.as_ref().map_or([0.0; 3], matt);
    let specular = irradiance.specular.map_or([0.0; 3], |s| s[pixel]);
    let (hard, soft) = (irradiance.direct.hard[pixel], irradiance.direct.soft[pixel]);
    let i = irradiance.indirect[pixel];
    let d: [f32; 3] = std::array::from_fn(|c| hard[c] + soft[c]);
    Seen {
        direct: std::array::from_fn(|c| buffer.emissive[pixel][c] + albedo[c] * FRAC_1_PI * d[c]),
        indirect: std::array::from_fn(|c| albedo[c] * FRAC_1_PI * i[c]),
        specular: std::array::from_fn(|c| specular[c] + matt[c] * (soft[c] + i[c])),
        beyond: [0.0; 3],
        coverage: 1.0,
    }
}

/// What a lobe that is taken for diffuse reflects of an irradiance.
fn matt(gloss: &Gloss) -> [f32; 3] {
    let share = FRAC_1_PI * gloss.matt_share();
    if share > 0.0 { gloss.reflectance().map(|r| share * r) } else { [0.0; 3] }
}

fn beyond(lit: &Lit, direction: Vec3) -> [f32; 3] {
    lit.lights.sky.as_ref().map(|s| s.backdrop(direction)).unwrap_or_default()
}

/// Whether a pixel and its neighbours do not show one smooth surface of one material.
fn is_edge(buffer: &GBuffer, (x, y): (usize, usize)) -> bool {
    let own = buffer.covered[(x, y)];
    let normal = Vec3::from(buffer.normal[(x, y)]);
    let position = Vec3::from(buffer.position[(x, y)]);
    let (_, height) = buffer.size();
    let tolerance = buffer.pose.pixel_size(buffer.depth[(x, y)], height as f32);
    let differs = |dx: isize, dy: isize| {
        let (u, v) = (x as isize + dx, y as isize + dy);
        let Some(covered) = buffer.covered.at(u, v) else { return false };
        let at = (u as usize, v as usize);
        if !own || !covered {
            return own != *covered;
        }
        buffer.material[at] != buffer.material[(x, y)]
            || Vec3::from(buffer.normal[at]).dot(normal) < 0.95
            || (Vec3::from(buffer.position[at]) - position).dot(normal).abs() > tolerance
    };
    (-1..=1).any(|dy| (-1..=1).any(|dx| differs(dx, dy)))
}

/// Whether sharp shadows end between a pixel and its neighbours.
fn is_shadow_edge(irradiance: &Irradiance, (x, y): (usize, usize)) -> bool {
    let hard = &irradiance.direct.hard;
    let own = luminance(hard[(x, y)]);
    let differs = |dx: isize, dy: isize| {
        let other = hard.at(x as isize + dx, y as isize + dy).map_or(own, |e| luminance(*e));
        (other - own).abs() > 0.1 * other.max(own)
    };
    (-1..=1).any(|dy| (-1..=1).any(|dx| differs(dx, dy)))
}

/// The mean over a grid of samples in a pixel.
fn samples(
    lit: &Lit,
    buffer: &GBuffer,
    (irradiance, crevices): (&Irradiance, &Crevices),
    (x, y): (usize, usize),
    side: u32,
) -> Seen {
    let (w, h) = buffer.size();
    let mut sum = Seen::default();
    let share = 1.0 / (side * side) as f32;
    for k in 0..side * side {
        let at = |i: u32| (i as f32 + 0.5) / side as f32;
        let (px, py) = (x as f32 + at(k % side), y as f32 + at(k / side));
        let (origin, direction) = buffer.pose.ray(px, py, w as f32, h as f32);
        let start = buffer.pose.near / direction.dot(buffer.pose.forward);
        let ray = Ray { origin: origin + direction * start, direction, t_max: f32::INFINITY };
        let Some(hit) = lit.tracer.seen(&ray) else {
            let sky = beyond(lit, direction);
            (0..3).for_each(|c| sum.beyond[c] += share * sky[c]);
            continue;
        };
        let depth = (start + hit.t) * direction.dot(buffer.pose.forward);
        let footprint = buffer.pose.pixel_size(depth, h as f32);
        let surface = lit.surfaces.at(lit.tracer, &hit, direction, footprint);
        let vertex = Vertex::of_surface(lit.tracer, &hit, &surface, direction);
        let gloss = irradiance.specular.map(|_| Gloss::of_surface(lit.tracer, &surface, direction));
        let albedo = gloss.as_ref().map_or(vertex.albedo, |g| g.diffuse);
        let matt = gloss.as_ref().map_or([0.0; 3], matt);
        let known = (irradiance, crevices);
        let [soft, i, s] = around(lit, buffer, known, (x, y), (k, &vertex, footprint));
        let hard = lamp_irradiance((lit.tracer, &lit.lights.glow), &vertex, &lit.lights.lamps);
        for c in 0..3 {
            let reflected = share * albedo[c] * FRAC_1_PI;
            sum.direct[c] += share * vertex.emission[c] + reflected * (hard[c] + soft[c]);
            sum.indirect[c] += reflected * i[c];
            sum.specular[c] += share * (s[c] + matt[c] * (soft[c] + i[c]));
        }
        sum.coverage += share;
    }
    sum
}

/// Soft direct and indirect irradiance of a sample, and its specular reflection, from the centres around it.
fn around(
    lit: &Lit,
    buffer: &GBuffer,
    (irradiance, crevices): (&Irradiance, &Crevices),
    (x, y): (usize, usize),
    (index, vertex, footprint): (u32, &Vertex, f32),
) -> [[f32; 3]; 3] {
    let (mut direct, mut indirect, mut total, mut open) = ([0.0; 3], [0.0; 3], 0.0, 0.0);
    let mut specular = [0.0; 3];
    let shining = |at| irradiance.specular.map_or([0.0; 3], |s| s[at]);
    let ratio = |open: f32| crevices.ratio(lit, (x, y), vertex, footprint, (index, open));
    // As a last resort, the centre whose normal is most alike.
    let mut likest = (-2.0, (x, y));
    for dy in -1..=1isize {
        for dx in -1..=1isize {
            let (u, v) = (x as isize + dx, y as isize + dy);
            if buffer.covered.at(u, v) != Some(&true) {
                continue;
            }
            let at = (u as usize, v as usize);
            let offset = Vec3::from(buffer.position[at]) - vertex.position;
            let cosine = Vec3::from(buffer.normal[at]).dot(vertex.normal);
            if cosine > likest.0 {
                likest = (cosine, at);
            }
            let off_plane = offset.dot(vertex.normal).abs() / footprint;
            let apart = offset.length_squared() / (footprint * footprint);
            let weight =
                cosine.max(0.0).powi(16) * (-2.0 * off_plane * off_plane - 0.5 * apart).exp();
            total += weight;
            open += weight * crevices.open(at);
            let s = shining(at);
            (0..3).for_each(|c| {
                direct[c] += weight * irradiance.direct.soft[at][c];
                indirect[c] += weight * irradiance.indirect[at][c];
                specular[c] += weight * s[c];
            });
        }
    }
    if total > 0.02 {
        let scale = ratio(open / total) / total;
        let lit = [direct, indirect].map(|e| e.map(|e| e * scale));
        return [lit[0], lit[1], specular.map(|s| s / total)];
    }
    let sequence = Sequence::new((y * buffer.size().0 + x) as u64);
    let mut own = [0.0; 3];
    for k in 0..OWN_SAMPLES {
        let numbers = numbers(lit.lights, &sequence, index * OWN_SAMPLES + k, 2);
        let e = lit.lights.soft_irradiance(lit.tracer, lit.surfaces, vertex, &numbers);
        (0..3).for_each(|c| own[c] += e[c] / OWN_SAMPLES as f32);
    }
    let scale = ratio(crevices.open(likest.1));
    [own, irradiance.indirect[likest.1].map(|e| e * scale), shining(likest.1)]
}
