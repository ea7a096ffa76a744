//! What a specular lobe reflects of light from everywhere, by the angle of view and its width: F0 A + F90 B,
//! tabulated once (Karis 2013).

use super::{Gloss, LEAST_COSINE};
use chiaro_basis::math::Vec3;
use chiaro_basis::random::r2;
use std::sync::LazyLock;

/// Entries along cosine and along the root of alpha, and directions for each.
const SIDE: usize = 24;
const DIRECTIONS: u64 = 256;

static TABLE: LazyLock<Vec<[f32; 2]>> = LazyLock::new(|| {
    let at = |i: usize| i as f32 / (SIDE - 1) as f32;
    (0..SIDE * SIDE).map(|i| entry(at(i % SIDE), at(i / SIDE))).collect()
});

/// A and B at a cosine and a roughness.
fn entry(cosine: f32, roughness: f32) -> [f32; 2] {
    let cosine = cosine.max(0.02);
    let to_eye = Vec3::new((1.0 - cosine * cosine).max(0.0).sqrt(), 0.0, cosine);
    let alpha = roughness.powi(2).max(super::LEAST_ALPHA);
    let lobe = |f0: f32, f90: f32| Gloss {
        normal: Vec3::Z,
        to_eye,
        alpha,
        f0: [f0; 3],
        f90,
        diffuse: [0.0; 3],
    };
    [lobe(1.0, 0.0), lobe(0.0, 1.0)].map(|lobe| {
        let one = |i| {
            let towards = lobe.sample(r2(i));
            let density = lobe.density(towards);
            if density > 0.0 { lobe.value(towards)[0] / density } else { 0.0 }
        };
        (0..DIRECTIONS).map(one).sum::<f32>() / DIRECTIONS as f32
    })
}

/// The share that is reflected.
pub(super) fn reflected(cosine: f32, alpha: f32, f0: f32, f90: f32) -> f32 {
    if f0 == 0.0 && f90 == 0.0 {
        return 0.0;
    }
    let place = |t: f32| t.clamp(0.0, 1.0) * (SIDE - 1) as f32;
    let (x, y) = (place(cosine.max(LEAST_COSINE)), place(alpha.sqrt()));
    let (i, j) = ((x as usize).min(SIDE - 2), (y as usize).min(SIDE - 2));
    let (s, t) = (x - i as f32, y - j as f32);
    let at = |i: usize, j: usize| {
        let [a, b] = TABLE[j * SIDE + i];
        f0 * a + f90 * b
    };
    let low = at(i, j) + (at(i + 1, j) - at(i, j)) * s;
    let high = at(i, j + 1) + (at(i + 1, j + 1) - at(i, j + 1)) * s;
    (low + (high - low) * t).clamp(0.0, 1.0)
}
