//! Glossy receivers: what visible points reflect specularly (`chiaro_trace::Gloss`).
//!
//! 1. Lamps of no size are seen in closed form, each with a shadow ray.
//! 2. A glossy pixel casts a few rays by its lobe, well spread over the pixel and over blocks of 4 x 4
//!    pixels; as many shadow rays go to points of what shines, but from sharp lobes. A ray that meets nothing sees the sky, blurred over the
//!    cone that the ray stands for.
//! 3. What a ray meets is Lambertian. Where the ray's cone is wider than surfels are apart, it sends the light of the nearest
//!    surfel; a narrower one sees it lit where it was met (`met`), so that mirrors are sharp.
//! 4. Samples are pooled over blocks of 4 x 4 pixels (`shared`): every pixel weighs those of all by its own lobe over
//!    the sum of the densities with which they were looked for (the balance heuristic). Sharp
//!    lobes that do not overlap share nothing, wide ones share all.
//!
//! A wide, faint lobe needs no rays: it reflects what diffuse reflection receives ([`Gloss::matt_share`], `resolve`).
//! Lobes are widened by how normals vary over a pixel, so that curved mirrors neither flicker nor
//! sparkle. Guaranteed: deterministic, the same for any number of threads, no energy gained. Not guaranteed:
//! reflections of reflections (what is met is matt), and detail of reflections under a pixel.

mod met;
mod shared;

use crate::cluster::Pixel;
use crate::hierarchy::Hierarchy;
use crate::indirect::Prepared;
use crate::pool::STEP;
use crate::receiver::Lattice;
use chiaro_basis::math::Vec3;
use chiaro_basis::{Result, Run};
use chiaro_image::Plane;
use chiaro_trace::{BlurredSky, GBuffer, Gloss, Sides, Vertex};
use met::Seer;
use rayon::prelude::*;
use shared::{Block, shared};
use std::collections::VecDeque;

/// Rays of a pixel: of a sharp or faint lobe, and of others.
const FEW: u32 = 4;
const MANY: u32 = 16;
/// Lobes narrower than this are sharp.
const SHARP: f32 = 0.012;
/// What reflects less is faint.
const FAINT: f32 = 0.12;
/// The part of the lattice for lobes, for places on lights, and for which light.
const LOBE: usize = 0;
const PLACE: usize = 1;
const CHOICE: usize = 2;
/// Variance of a lobe's slope at most, by how normals vary.
const MOST_VARIANCE: f32 = 0.04;
/// Rows of pixels done together; even, as blocks begin at every second.
const ROWS: usize = 16;

/// Light from a point or, at infinity, from a direction.
#[derive(Clone, Copy, Default)]
struct Sample {
    /// Where; a unit vector when it is far.
    place: Vec3,
    is_far: bool,
    /// Whether a ray by the lobe found it: the reflected light and the sky count.
    by_lobe: bool,
    light: [f32; 3],
    /// What shines there.
    glow: [f32; 3],
    /// The density with which light samples find it: per area over the cosine of what is there.
    other: f32,
}

/// A glossy pixel with its samples.
struct Glossy {
    at: Vertex,
    gloss: Gloss,
    /// The width of a pixel here, scene units.
    footprint: f32,
    /// Rays by the lobe, and to what shines.
    rays: u32,
    lights: u32,
    samples: Vec<Sample>,
    /// What is reflected of lamps.
    lamps: [f32; 3],
}

/// What all pixels share.
struct Caster<'a, 'b, T: Hierarchy> {
    scene: &'a Prepared<'b, T>,
    buffer: &'a GBuffer,
    lattice: Lattice,
    sky: Option<BlurredSky>,
    seer: Seer<'a, 'b, T>,
}

/// Radiance towards the eye by specular reflection at the covered pixels.
pub(crate) fn specular<T: Hierarchy>(
    scene: &Prepared<T>,
    buffer: &GBuffer,
    run: &Run,
) -> Result<Plane<[f32; 3]>> {
    let (width, height) = buffer.size();
    let ends: &[u32] = &[FEW, MANY];
    let caster = Caster {
        scene,
        buffer,
        lattice: Lattice::new(&[ends, ends, ends], 0x6105 + scene.shift),
        sky: scene.lit.lights.sky.as_deref().map(BlurredSky::new),
        seer: Seer::new(scene),
    };
    let mut found = Plane::filled(width, height, [0.0; 3]);
    let mut rows: VecDeque<Vec<Option<Glossy>>> = VecDeque::new();
    let (mut first, mut done) = (0, 0);
    for top in (0..height).step_by(ROWS) {
        let end = (top + ROWS).min(height);
        let cast = |y: usize| {
            run.check()?;
            Ok((0..width).map(|x| caster.pixel((x, y))).collect())
        };
        let fresh: Vec<Vec<Option<Glossy>>> =
            (top..end).into_par_iter().map(cast).collect::<Result<_>>()?;
        rows.extend(fresh);
        let until = if end == height { height } else { end - STEP };
        settle(&rows, first, done..until, &mut found);
        while first + STEP < until {
            rows.pop_front();
            first += 1;
        }
        done = until;
    }
    Ok(found)
}

/// Writes what some rows reflect; `rows` begin with row `first` of the picture.
fn settle(
    rows: &VecDeque<Vec<Option<Glossy>>>,
    first: usize,
    range: std::ops::Range<usize>,
    found: &mut Plane<[f32; 3]>,
) {
    let width = found.width();
    let at = |x: isize, y: isize| {
        let row = rows.get(usize::try_from(y - first as isize).ok()?)?;
        row.get(usize::try_from(x).ok()?)?.as_ref()
    };
    let step = STEP as isize;
    let columns = width.div_ceil(STEP) + 1;
    let start = range.start as isize / step - 1;
    let count = (range.end as isize - 1).div_euclid(step) - start + 1;
    let block = |i: usize| {
        let (x, y) =
            ((i % columns) as isize * step - step, (start + (i / columns) as isize) * step);
        shared(&std::array::from_fn(|k| at(x + k as isize % 4, y + k as isize / 4)))
    };
    let blocks: Vec<Block> = (0..count as usize * columns).into_par_iter().map(block).collect();
    for (x, y) in range.flat_map(|y| (0..width).map(move |x| (x, y))) {
        if let Some(one) = at(x as isize, y as isize) {
            let pooled = crate::band::mean(&blocks, columns, start, (x, y));
            let share = 1.0 - one.gloss.matt_share();
            found[(x, y)] = std::array::from_fn(|c| one.lamps[c] + share * pooled[c]);
        }
    }
}

impl<T: Hierarchy> Caster<'_, '_, T> {
    /// A pixel with its samples, if it is glossy.
    fn pixel(&self, pixel: Pixel) -> Option<Glossy> {
        let (lit, buffer) = (&self.scene.lit, self.buffer);
        if !buffer.covered[pixel] {
            return None;
        }
        let gloss = Gloss::of_pixel(lit.tracer, buffer, pixel);
        if gloss.is_dull() {
            return None;
        }
        let gloss = gloss.widened(variance(buffer, pixel));
        let matt = gloss.matt_share();
        let at = Vertex::of_pixel(lit.tracer, buffer, pixel);
        let faint = gloss.reflectance().into_iter().fold(0.0, f32::max) < FAINT;
        let rays = match matt < 1.0 {
            true if faint || gloss.alpha < SHARP => FEW,
            true => MANY,
            false => 0,
        };
        let lights = match lit.lights.glow.is_empty() || gloss.alpha < SHARP {
            true => 0,
            false => rays,
        };
        let mut one = Glossy {
            at,
            gloss,
            footprint: buffer.pose.pixel_size(buffer.depth[pixel], buffer.size().1 as f32),
            rays,
            lights,
            samples: Vec::with_capacity(2 * rays as usize),
            lamps: lit.lights.specular_of_lamps(lit.tracer, &at, &gloss),
        };
        self.cast(&mut one, pixel);
        self.light(&mut one, pixel);
        Some(one)
    }

    /// Rays by the lobe.
    fn cast(&self, one: &mut Glossy, pixel: Pixel) {
        let (lit, at) = (&self.scene.lit, one.at);
        let mut seen = self.seer.looking(pixel, one.gloss.alpha);
        for k in 0..one.rays {
            let towards = one.gloss.sample(self.lattice.point(LOBE, k, pixel));
            let density = one.gloss.density(towards);
            if !(density > 0.0 && towards.dot(at.side) > 0.0) {
                continue;
            }
            let cone = 1.0 / (one.rays as f32 * density);
            let Some(hit) = lit.tracer.hit(&at.ray(towards, f32::INFINITY), Sides::Both) else {
                let light = self.sky.as_ref().map_or([0.0; 3], |s| s.radiance(towards, cone));
                let far = Sample { place: towards, is_far: true, ..Sample::default() };
                one.samples.push(Sample { by_lobe: true, light, ..far });
                continue;
            };
            let (place, light, glow) = seen.met(&hit, towards, cone, k);
            let square = (place - at.position).length_squared().max(f32::MIN_POSITIVE);
            let shines = glow != [0.0; 3];
            let other = if shines { lit.lights.glow_density(&hit, towards) / square } else { 0.0 };
            one.samples.push(Sample { place, is_far: false, by_lobe: true, light, glow, other });
        }
    }

    /// Shadow rays to what shines.
    fn light(&self, one: &mut Glossy, pixel: Pixel) {
        let (lit, at) = (&self.scene.lit, one.at);
        for k in 0..one.lights {
            let [u, v] = self.lattice.point(PLACE, k, pixel);
            let [choice, _] = self.lattice.point(CHOICE, k, pixel);
            let numbers = [choice, u, v];
            let Some(s) = lit.lights.glow_sample(lit.tracer, lit.surfaces, &at, numbers) else {
                continue;
            };
            if one.gloss.density(s.ray.direction) <= 0.0 || lit.tracer.occluded(&s.ray) {
                continue;
            }
            let square = (s.position - at.position).length_squared().max(f32::MIN_POSITIVE);
            let (place, glow, other) = (s.position, s.radiance, s.density / square);
            one.samples.push(Sample { place, glow, other, ..Sample::default() });
        }
    }
}

/// How much slopes vary over a pixel: by the normals of the neighbours on its surface.
fn variance(buffer: &GBuffer, (x, y): Pixel) -> f32 {
    let (normal, position) =
        (Vec3::from(buffer.normal[(x, y)]), Vec3::from(buffer.position[(x, y)]));
    let (_, height) = buffer.size();
    let footprint = buffer.pose.pixel_size(buffer.depth[(x, y)], height as f32);
    let change = |dx: isize, dy: isize| {
        let (u, v) = (x as isize + dx, y as isize + dy);
        if buffer.covered.at(u, v) != Some(&true) {
            return f32::INFINITY;
        }
        let at = (u as usize, v as usize);
        let apart = (Vec3::from(buffer.position[at]) - position).length();
        let alike = buffer.object[at] == buffer.object[(x, y)] && apart < 20.0 * footprint;
        if alike {
            (Vec3::from(buffer.normal[at]) - normal).length_squared()
        } else {
            f32::INFINITY
        }
    };
    let along = |a: f32, b: f32| if a.min(b).is_finite() { a.min(b) } else { 0.0 };
    let sum = along(change(-1, 0), change(1, 0)) + along(change(0, -1), change(0, 1));
    // A pixel's square has a variance of a twelfth of its side squared; alpha squared is twice that of slopes.
    (sum / 6.0).min(MOST_VARIANCE)
}
