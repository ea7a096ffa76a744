//! Samples of specular light, shared by the pixels of a block.
//!
//! Densities are per solid angle over the squared distance: per area over the cosine of what is there,
//! which is the same for all pixels that look at a point.

use super::{Glossy, Sample};
use crate::pool::{SIDE, weight_at};
use chiaro_basis::math::Vec3;

const LANES: usize = SIDE * SIDE;
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
                p.at.position.distance(first.at.position) < NEAR * p.footprint.max(first.footprint)
            })
        };
        // The first is near itself unless its footprint is nothing.
        let (mut some, rest): (Vec<usize>, Vec<usize>) = left.iter().partition(|i| near(i));
        if some.is_empty() {
            some.push(left[0]);
            left.remove(0);
        } else {
            left = rest;
        }
        share(pixels, &some, &mut block);
    }
    block
}

fn share(pixels: &[Option<&Glossy>; LANES], some: &[usize], block: &mut Block) {
    let members = || some.iter().filter_map(|&i| pixels[i].map(|p| (i, p)));
    for sample in members().flat_map(|(_, p)| &p.samples) {
        if sample.light == [0.0; 3] {
            continue;
        }
        let mut seen = [(Vec3::ZERO, 0.0); LANES];
        let mut found = 0.0;
        for (k, (_, pixel)) in members().enumerate() {
            let (towards, square) = direction(sample, pixel);
            let density = pixel.gloss.density(towards) / square;
            let looks = if density > 0.0 { density + sample.other } else { 0.0 };
            found += pixel.rays as f32 * looks;
            seen[k] = (towards, square);
        }
        if !(found > 0.0 && found.is_finite()) {
            continue;
        }
        for (k, (i, pixel)) in members().enumerate() {
            let (towards, square) = seen[k];
            if towards.dot(pixel.at.side) <= 0.0 {
                continue;
            }
            let value = pixel.gloss.value(towards);
            let scale = 1.0 / (square * found);
            (0..3).for_each(|c| block[i].1[c] += value[c] * sample.light[c] * scale);
        }
    }
}

/// The direction in which a pixel sees a sample, and the squared distance.
fn direction(sample: &Sample, pixel: &Glossy) -> (Vec3, f32) {
    if sample.is_far {
        return (sample.place, 1.0);
    }
    let offset = sample.place - pixel.at.position;
    let square = offset.length_squared().max(f32::MIN_POSITIVE);
    (offset / square.sqrt(), square)
}
