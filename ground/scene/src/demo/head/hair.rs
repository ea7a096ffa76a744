//! The hair as masses: locks combed back from the hairline into a coiled bun.

use super::super::shape::field::{carve, ellipsoid, merge};
use super::super::shape::{Bundle, between};
use chiaro_basis::math::{Vec3, vec3};
use std::f32::consts::{PI, TAU};

/// The middle and half-sizes of the skull that hair lies on.
const SKULL: (Vec3, Vec3) = (Vec3::new(0.0, 1.42, -0.12), Vec3::new(0.735, 0.870, 0.945));
/// The middle of the bun.
const BUN: Vec3 = Vec3::new(0.0, 1.28, -1.24);

/// The hairline of one side, from the parting down to the nape.
const HAIRLINE: [Vec3; 9] = [
    Vec3::new(0.02, 1.82, 0.71),
    Vec3::new(0.19, 1.79, 0.70),
    Vec3::new(0.38, 1.68, 0.63),
    Vec3::new(0.53, 1.50, 0.50),
    Vec3::new(0.61, 1.34, 0.35),
    Vec3::new(0.66, 1.23, 0.16),
    Vec3::new(0.70, 1.22, -0.26),
    Vec3::new(0.56, 0.86, -0.55),
    Vec3::new(0.22, 0.62, -0.80),
];

/// Points and radii along a lock.
type Lock = Vec<(Vec3, f32)>;

/// All locks.
pub(super) struct Hair {
    locks: Bundle,
}

impl Hair {
    /// Combs the hair.
    pub(super) fn new() -> Self {
        const LOCKS: usize = 22;
        let combed_lock = |i: usize| {
            let (k, left) = (i / 2, i.is_multiple_of(2));
            let share = (k as f32 + if left { 0.0 } else { 0.5 }) / LOCKS as f32;
            combed(if left { 1.0 } else { -1.0 }, share, i as u64)
        };
        let mut locks: Vec<Lock> = (0..2 * LOCKS).map(combed_lock).collect();
        locks.extend((0..5).map(|k| coiled(k as f32 / 5.0)));
        locks.extend([1.0, -1.0].map(tendril));
        Self { locks: Bundle::new(&locks, 0.035) }
    }

    /// The field: a cap that fills the gaps, and the locks.
    pub(super) fn at(&self, p: Vec3) -> f32 {
        let (middle, half) = SKULL;
        let q = vec3(p.x.abs(), p.y, p.z);
        let face = ellipsoid(q, vec3(0.0, 0.98, 0.95), vec3(0.76, 0.96, 0.98));
        let neck = ellipsoid(q, vec3(0.0, 0.0, 0.2), vec3(1.4, 1.08, 0.78));
        let nape = ellipsoid(q, vec3(0.0, -0.35, -0.4), vec3(1.4, 1.0, 1.4));
        let ear = ellipsoid(q, vec3(0.80, 0.85, 0.04), vec3(0.34, 0.56, 0.46));
        let mut d = ellipsoid(p, middle, half + 0.03);
        for hole in [face, neck, nape, ear] {
            d = carve(d, hole, 0.06);
        }
        d = carve(d, ellipsoid(p, middle, half - 0.10), 0.03);
        d = merge(d, ellipsoid(p, BUN, vec3(0.24, 0.24, 0.17)), 0.06);
        self.locks.merged(p, d)
    }
}

fn through(count: usize, joint: impl Fn(f32) -> (Vec3, f32)) -> Lock {
    (0..=count).map(|k| joint(k as f32 / count as f32)).collect()
}

/// A lock from a share of the hairline, over the skull and into the bun.
fn combed(side: f32, share: f32, index: u64) -> Lock {
    let start = along(&HAIRLINE, share) * vec3(side, 1.0, 1.0);
    let (middle, half) = SKULL;
    let from = (start - middle) / half;
    let to = (BUN + vec3(0.05 * side, 0.02, 0.20) - middle) / half;
    let (phase, swing) = (between(64, index, 0.0, TAU), between(65, index, 0.02, 0.05));
    let (thick, lift) = (between(66, index, 0.072, 0.098), between(67, index, 0.0, 0.05));
    let turn = from.normalize().cross(to.normalize()).normalize_or(Vec3::X);
    through(16, |t| {
        let u = from.normalize().slerp(to.normalize(), t);
        let wave = swing * (TAU * 1.3 * t + phase).sin() * (PI * t).sin();
        let size = from.length() * (1.0 - t) + to.length() * t;
        let on = (u + turn * wave).normalize() * size.max(1.0);
        let lift = 1.0 + 0.01 + lift * (PI * t).sin();
        let taper = (0.45 + 1.9 * t).min(1.0) * (1.0 - 0.45 * t);
        (middle + half * on * lift, thick * taper)
    })
}

/// A turn of the bun.
fn coiled(phase: f32) -> Lock {
    through(24, |t| {
        let (s, c) = (TAU * (phase + 0.75 * t)).sin_cos();
        let out = 0.25 - 0.20 * t;
        let at = BUN + vec3(out * c, out * s, -0.02 - 0.16 * t);
        (at, 0.085 * (1.0 - 0.35 * t))
    })
}

/// A curl before an ear.
fn tendril(side: f32) -> Lock {
    through(24, |t| {
        let (s, c) = (TAU * 1.1 * t + 0.4).sin_cos();
        let curl = 0.02 + 0.04 * t;
        let at = vec3(0.655 + 0.2 * curl * c, 1.36 - 0.62 * t, 0.20 + curl * s);
        (at * vec3(side, 1.0, 1.0), 0.048 * (1.0 - 0.55 * t))
    })
}

/// A point of a polyline, by its share of the corners.
fn along(line: &[Vec3], share: f32) -> Vec3 {
    let x = share * (line.len() - 1) as f32;
    let i = (x as usize).min(line.len() - 2);
    line[i].lerp(line[i + 1], x - i as f32)
}
