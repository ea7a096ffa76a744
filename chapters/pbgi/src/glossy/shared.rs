//! Samples of specular light, shared by the pixels of a block.
//!
//! 1. A sample weighs f / sum of N p: a pixel's own reflection over the densities with which all pixels of the
//!    block look that way (the balance heuristic). Densities are per solid angle over the squared
//!    distance: per area over the cosine of what is there, which is the same for all.
//! 2. What is reflected or comes from the sky is the weighted mean times the lobe's whole reflectance, so that
//!    even surroundings look even however few rays there are.
//! 3. What shines is a sum, for light samples look for it too; sharp lobes, which cast none, take it into their mean.

use super::{Glossy, Sample};
use crate::pool::{SIDE, weight_at};
use std::f32::consts::FRAC_1_PI;

const LANES: usize = SIDE * SIDE;
type Lanes = [f32; LANES];
/// Pixels share within so many footprints.
const NEAR: f32 = 12.0;

/// What each pixel of a block reflects, by row and column, and the weight of the block there.
pub(super) type Block = [(f32, [f32; 3]); LANES];

/// What the pixels of a block reflect by the samples of all.
pub(super) fn shared(pixels: &[Option<&Glossy>; LANES]) -> Block {
    let mut block = [(0.0, [0.0; 3]); LANES];
    block.iter_mut().enumerate().for_each(|(i, b)| b.0 = weight_at(i));
    let mut left: Vec<usize> = (0..LANES).filter(|&i| pixels[i].is_some()).collect();
    while let Some(first) = left.first().and_then(|&i| pixels[i]) {
        let near = |i: &usize| {
            pixels[*i].is_some_and(|p| {
                p.at.position.distance(first.at.position) <= NEAR * p.footprint.max(first.footprint)
            })
        };
        let (some, rest): (Vec<usize>, Vec<usize>) = left.iter().partition(|i| near(i));
        share(pixels, &some, &mut block);
        left = rest;
    }
    block
}

fn share(pixels: &[Option<&Glossy>; LANES], some: &[usize], block: &mut Block) {
    let mut group = Group::default();
    let members = || some.iter().filter_map(|&i| pixels[i].map(|p| (i, p)));
    members().enumerate().for_each(|(k, (_, pixel))| group.add(k, pixel));
    let mut sums = Sums::default();
    for sample in members().flat_map(|(_, p)| &p.samples) {
        let seen = group.seen(sample);
        if sample.by_lobe {
            let weights = seen.weights(&group, 0.0);
            sums.mean.add(&weights, sample.light);
            if sample.glow != [0.0; 3] {
                sums.met.add(&weights, sample.glow);
            }
        }
        if sample.glow != [0.0; 3] {
            sums.glow.add(&seen.weights(&group, sample.other), sample.glow);
        }
    }
    for (k, (i, pixel)) in members().enumerate() {
        let gloss = &pixel.gloss;
        let whole = gloss.reflectance();
        block[i].1 = std::array::from_fn(|c| {
            let of = |[a, b]: [f32; 2]| gloss.f0[c] * a + gloss.f90 * b;
            let weight = of(sums.mean.weight.map(|w| w[k]));
            let mean = |sum: &Sum| match weight > 0.0 {
                true => whole[c] * of(sum.light[c].map(|w| w[k])) / weight,
                false => 0.0,
            };
            let glow = match pixel.lights > 0 {
                true => of(sums.glow.light[c].map(|w| w[k])),
                false => mean(&sums.met),
            };
            mean(&sums.mean) + glow
        });
    }
}

/// Sums of a group over samples: of weights and of weighted light, in the part that goes with F0 and the part
/// that goes with F90.
#[derive(Default)]
struct Sum {
    weight: [Lanes; 2],
    light: [[Lanes; 2]; 3],
}

#[derive(Default)]
struct Sums {
    /// What is reflected or comes from the sky.
    mean: Sum,
    /// What shines, as rays by lobes met it.
    met: Sum,
    /// What shines, as both strategies found it.
    glow: Sum,
}

impl Sum {
    #[allow(clippy::needless_range_loop, reason = "lanes are vectors of the processor")]
    fn add(&mut self, weights: &[Lanes; 2], light: [f32; 3]) {
        for part in 0..2 {
            for k in 0..LANES {
                self.weight[part][k] += weights[part][k];
            }
            for c in 0..3 {
                for k in 0..LANES {
                    self.light[c][part][k] += weights[part][k] * light[c];
                }
            }
        }
    }
}

/// Pixels that share, side by side; unused lanes have no rays and see nothing.
#[derive(Default)]
struct Group {
    position: [Lanes; 3],
    normal: [Lanes; 3],
    side: [Lanes; 3],
    eye: [Lanes; 3],
    rays: Lanes,
    lights: Lanes,
    /// alpha squared, n.v, L(n.v).
    square: Lanes,
    cosine: Lanes,
    slope: Lanes,
}

/// How the pixels of a group see a sample.
struct Seen {
    /// Densities over squared distances.
    density: Lanes,
    /// f times the cosine over squared distances, for F = 1, in the part of F0 and that of F90.
    value: [Lanes; 2],
}

impl Group {
    fn add(&mut self, k: usize, pixel: &Glossy) {
        let g = &pixel.gloss;
        for c in 0..3 {
            self.position[c][k] = pixel.at.position[c];
            self.normal[c][k] = g.normal[c];
            self.side[c][k] = pixel.at.side[c];
            self.eye[c][k] = g.to_eye[c];
        }
        self.rays[k] = pixel.rays as f32;
        self.lights[k] = pixel.lights as f32;
        self.square[k] = g.alpha * g.alpha;
        self.cosine[k] = g.normal.dot(g.to_eye);
        self.slope[k] = slope(self.square[k], self.cosine[k]);
    }

    /// The model of `chiaro_trace::Gloss` for all lanes.
    #[allow(clippy::needless_range_loop, reason = "lanes are vectors of the processor")]
    fn seen(&self, sample: &Sample) -> Seen {
        let zero = [0.0; LANES];
        let mut seen = Seen { density: zero, value: [zero; 2] };
        let near = if sample.is_far { 0.0 } else { 1.0 };
        let [px, py, pz] = sample.place.to_array();
        for k in 0..LANES {
            let (x, y, z) = (
                px - near * self.position[0][k],
                py - near * self.position[1][k],
                pz - near * self.position[2][k],
            );
            let distance2 = (x * x + y * y + z * z).max(f32::MIN_POSITIVE);
            let scale = 1.0 / distance2.sqrt();
            let (x, y, z) = (x * scale, y * scale, z * scale);
            let (nx, ny, nz) = (self.normal[0][k], self.normal[1][k], self.normal[2][k]);
            let (ex, ey, ez) = (self.eye[0][k], self.eye[1][k], self.eye[2][k]);
            let nl = nx * x + ny * y + nz * z;
            let above = self.side[0][k] * x + self.side[1][k] * y + self.side[2][k] * z;
            let (hx, hy, hz) = (x + ex, y + ey, z + ez);
            let half2 = (hx * hx + hy * hy + hz * hz).max(1e-12);
            let nh = nx * hx + ny * hy + nz * hz;
            // By the cross product: one less the squared cosine would lose all of a sharp lobe.
            let (cx, cy, cz) = (ny * hz - nz * hy, nz * hx - nx * hz, nx * hy - ny * hx);
            let across = cx * cx + cy * cy + cz * cz;
            let square = self.square[k];
            let d = (across + square * nh * nh) / half2;
            let visible = nl > 0.0 && above > 0.0;
            let lobe = if visible { FRAC_1_PI * square / (d * d).max(1e-30) } else { 0.0 };
            let lobe = lobe / distance2;
            let nv = self.cosine[k];
            seen.density[k] = 0.5 * lobe / (nv + self.slope[k]).max(1e-9);
            let shadowed = nl * self.slope[k] + nv * slope(square, nl);
            let value = 0.5 * lobe * nl / shadowed.max(1e-9);
            let along = (ex * hx + ey * hy + ez * hz) / half2.sqrt();
            let low = (1.0 - along).max(0.0);
            let grazing = low * low * low * low * low;
            seen.value[0][k] = value * (1.0 - grazing);
            seen.value[1][k] = value * grazing;
        }
        seen
    }
}

impl Seen {
    /// What a sample weighs for each pixel, if `other` is the density with which light samples find it.
    fn weights(&self, group: &Group, other: f32) -> [Lanes; 2] {
        let looks = |k: usize| match self.density[k] > 0.0 {
            true => group.rays[k] * self.density[k] + group.lights[k] * other,
            false => 0.0,
        };
        let found: f32 = (0..LANES).map(looks).sum();
        let scale = if found > 0.0 && found.is_finite() { 1.0 / found } else { 0.0 };
        self.value.map(|lanes| lanes.map(|v| v * scale))
    }
}

fn slope(square: f32, cosine: f32) -> f32 {
    (square + (1.0 - square) * cosine * cosine).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use chiaro_basis::math::Vec3;
    use chiaro_trace::{Gloss, Vertex};

    fn glossy(alpha: f32) -> Glossy {
        let gloss = Gloss {
            normal: Vec3::new(0.1, 0.0, 1.0).normalize(),
            to_eye: Vec3::new(0.3, -0.4, 0.7).normalize(),
            alpha,
            f0: [0.3, 0.6, 0.9],
            f90: 1.0,
            diffuse: [0.0; 3],
        };
        let at = Vertex {
            position: Vec3::new(1.0, 2.0, 3.0),
            lifted: Vec3::new(1.0, 2.0, 3.0),
            side: Vec3::Z,
            smooth: Vec3::Z,
            normal: Vec3::Z,
            albedo: [0.0; 3],
            emission: [0.0; 3],
            offset: 0.0,
        };
        Glossy {
            at,
            gloss,
            footprint: 0.1,
            rays: 4,
            lights: 0,
            samples: Vec::new(),
            lamps: [0.0; 3],
        }
    }

    #[test]
    fn lanes_are_the_model() {
        for alpha in [0.002, 0.1, 1.0] {
            let pixel = glossy(alpha);
            let mut group = Group::default();
            group.add(3, &pixel);
            let mirror = pixel.gloss.normal * (2.0 * pixel.gloss.normal.dot(pixel.gloss.to_eye))
                - pixel.gloss.to_eye;
            for (aside, distance) in [(0.0, 2.0), (0.5 * alpha, 1.0), (0.3, 7.0)] {
                let towards = (mirror + Vec3::Y * aside).normalize();
                let place = pixel.at.position + towards * distance;
                let sample = Sample { place, ..Sample::default() };
                let seen = group.seen(&sample);
                let square = distance * distance;
                let near = |a: f32, b: f32| (a / b - 1.0).abs() < 0.02;
                assert!(near(seen.density[3] * square, pixel.gloss.density(towards)), "{alpha}");
                let value = pixel.gloss.value(towards);
                for c in 0..3 {
                    let own = pixel.gloss.f0[c] * seen.value[0][3] + seen.value[1][3];
                    assert!(near(own * square, value[c]), "{alpha} {own} {value:?}");
                }
                assert!(seen.density.iter().enumerate().all(|(k, d)| k == 3 || *d == 0.0));
            }
        }
    }

    #[test]
    fn even_surroundings_are_reflected_evenly_and_what_shines_in_its_measure() {
        let mut pixel = glossy(0.3);
        pixel.rays = 64;
        for i in 0..64 {
            let towards = pixel.gloss.sample(chiaro_basis::random::r2(i));
            let is_up = towards.z > 0.7;
            let glow = if is_up { [1.0; 3] } else { [0.0; 3] };
            let light = if is_up { [0.0; 3] } else { [1.0; 3] };
            if towards.z > 0.0 {
                let sample =
                    Sample { place: towards, is_far: true, light, glow, ..Sample::default() };
                pixel.samples.push(Sample { by_lobe: true, ..sample });
            }
        }
        let mut pixels = [None; LANES];
        pixels[5] = Some(&pixel);
        let block = shared(&pixels);
        let whole = pixel.gloss.reflectance();
        for c in 0..3 {
            assert!((block[5].1[c] / whole[c] - 1.0).abs() < 0.1, "{:?} {whole:?}", block[5].1);
        }
        assert_eq!(block[4].1, [0.0; 3]);
    }
}
