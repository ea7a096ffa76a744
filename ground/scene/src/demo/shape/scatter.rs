//! Points spread evenly: on spheres, and where shapes are dropped.

use chiaro_basis::math::{Quat, Vec3, vec3};
use chiaro_basis::random::unit;
use std::f32::consts::TAU;

/// `count` directions spread evenly over the sphere: the golden spiral (Swinbank and Purser 2006).
pub(crate) fn spiral(count: usize) -> impl Iterator<Item = Vec3> {
    let turn = TAU * (2.0 - 0.5 * (1.0 + 5f32.sqrt()));
    (0..count).map(move |i| {
        let y = 1.0 - (2 * i + 1) as f32 / count as f32;
        let (s, c) = (turn * i as f32).sin_cos();
        let r = (1.0 - y * y).sqrt();
        vec3(c * r, y, s * r)
    })
}

/// A number in [`low`, `high`) from a seed and an index.
pub(crate) fn between(seed: u64, index: u64, low: f32, high: f32) -> f32 {
    low + (high - low) * unit(seed, index)
}

/// A rotation drawn evenly from all rotations (Shoemake 1992).
pub(crate) fn rotation(seed: u64, index: u64) -> Quat {
    let u = |k: u64| unit(seed + k, index);
    let (a, b) = ((1.0 - u(0)).sqrt(), u(0).sqrt());
    let ((s1, c1), (s2, c2)) = ((TAU * u(1)).sin_cos(), (TAU * u(2)).sin_cos());
    Quat::from_xyzw(a * s1, a * c1, b * s2, b * c2)
}
