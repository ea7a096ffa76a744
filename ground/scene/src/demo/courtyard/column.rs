//! Columns: a plinth, a moulded base, a fluted shaft with a swelling, a capital of leaves.

use super::super::shape::{Form, Join, Profile, block, lathe, loft, stations};
use super::{BEAM, FLOOR, SPRING, UPPER};
use chiaro_basis::math::{Vec3, vec3};
use std::f32::consts::{PI, TAU};

/// A column of the arcade, from the gallery's floor to where arches spring.
pub(super) fn column() -> Form {
    let (low, high) = (FLOOR + 0.36, SPRING - 0.62);
    let plinth = block(vec3(0.70, 0.16, 0.70), 0.02, 2).at(0.0, FLOOR + 0.08, 0.0);
    let base = Profile::open(&[
        (0.0, 0.14, 0.0),
        (0.34, 0.14, 0.045),
        (0.34, 0.235, 0.045),
        (0.285, 0.245, 0.01),
        (0.275, 0.285, 0.02),
        (0.30, 0.295, 0.025),
        (0.30, 0.35, 0.025),
        (0.26, 0.37, 0.02),
        (0.0, 0.37, 0.0),
    ]);
    let base = lathe(&base, 40).at(0.0, FLOOR, 0.0);
    let capital = capital(0.245, 0.62).at(0.0, high, 0.0);
    Form::joined([plinth, base, shaft(low, high + 0.03, 0.25, 0.215, 20), capital])
}

/// A slender column of the upper gallery on its pedestal.
pub(super) fn colonnette() -> Form {
    let pedestal = block(vec3(0.42, 0.95, 0.42), 0.02, 2).at(0.0, UPPER + 0.475, 0.0);
    let panel = block(vec3(0.26, 0.62, 0.44), 0.02, 1).at(0.0, UPPER + 0.47, 0.0);
    let cap = block(vec3(0.50, 0.09, 0.50), 0.025, 2).at(0.0, UPPER + 0.96, 0.0);
    let (low, high) = (UPPER + 1.0, BEAM);
    let turned = Profile::open(&[
        (0.0, low, 0.0),
        (0.19, low, 0.03),
        (0.19, low + 0.08, 0.03),
        (0.14, low + 0.12, 0.03),
        (0.135, low + 0.5, 0.2),
        (0.115, high - 0.32, 0.2),
        (0.14, high - 0.30, 0.012),
        (0.14, high - 0.26, 0.012),
        (0.12, high - 0.24, 0.02),
        (0.20, high - 0.09, 0.05),
        (0.0, high - 0.07, 0.0),
    ]);
    let abacus = block(vec3(0.44, 0.10, 0.44), 0.02, 2).at(0.0, high - 0.045, 0.0);
    Form::joined([pedestal, panel, cap, lathe(&turned, 28), abacus])
}

/// A square pier with a moulded foot and head, from the ground to the upper beam.
pub(super) fn pier() -> Form {
    let stone = |width: f32, low: f32, high: f32| {
        let size = vec3(width, high - low, width);
        block(size, 0.02, 2).at(0.0, 0.5 * (low + high), 0.0)
    };
    Form::joined([
        stone(0.86, 0.0, FLOOR + 0.24),
        stone(0.78, FLOOR + 0.2, FLOOR + 0.34),
        stone(0.66, FLOOR + 0.3, BEAM + 0.3),
        stone(0.76, SPRING - 0.24, SPRING - 0.12),
        stone(0.84, SPRING - 0.13, SPRING),
        stone(0.80, UPPER - 0.05, UPPER + 0.1),
        stone(0.76, BEAM - 0.12, BEAM),
    ])
}

/// A shaft with rounded flutes that end below its rims.
fn shaft(low: f32, high: f32, foot: f32, neck: f32, flutes: usize) -> Form {
    const LEVELS: usize = 16;
    let n = 4 * flutes;
    let ring = |k: usize| {
        let t = k as f32 / LEVELS as f32;
        let swell = foot + (neck - foot) * t.powf(1.6);
        let fade = (14.0 * t.min(1.0 - t)).min(1.0);
        let spoke = |i: usize| {
            let a = TAU * i as f32 / n as f32;
            let groove = (0.5 * flutes as f32 * a).sin().abs();
            let r = swell * (1.0 - 0.075 * fade * groove);
            vec3(r * a.cos(), low + (high - low) * t, r * a.sin())
        };
        (0..n).map(spoke).collect::<Vec<_>>()
    };
    let mut rings = vec![vec![vec3(0.0, low, 0.0)]];
    rings.extend((0..=LEVELS).map(ring));
    rings.push(vec![vec3(0.0, high, 0.0)]);
    loft(&rings, Join { around: true, along: false }).outward()
}

/// A bell with two rows of curling leaves below a square slab, from y = 0 to `height`.
fn capital(neck: f32, height: f32) -> Form {
    let bell = Profile::open(&[
        (0.0, -0.02, 0.0),
        (neck, -0.02, 0.02),
        (neck + 0.02, 0.03, 0.02),
        (neck - 0.02, 0.08, 0.02),
        (neck + 0.02, 0.3, 0.2),
        (neck + 0.12, height - 0.14, 0.05),
        (0.0, height - 0.10, 0.0),
    ]);
    let ring = |count: usize, tall: f32, shift: f32| {
        let one = leaf(tall);
        Form::joined((0..count).map(move |k| {
            one.clone()
                .at(neck - 0.03, 0.06, 0.0)
                .turned_y(360.0 * (k as f32 + shift) / count as f32)
        }))
    };
    let slab = block(vec3(0.76, 0.12, 0.76), 0.025, 2).at(0.0, height - 0.06, 0.0);
    Form::joined([lathe(&bell, 32), ring(8, 0.24, 0.0), ring(8, 0.42, 0.5), slab])
}

/// A leaf that rises from the origin and curls outwards along +x.
fn leaf(tall: f32) -> Form {
    const ALONG: usize = 9;
    let points: Vec<Vec3> = (0..=ALONG)
        .map(|k| {
            let t = k as f32 / ALONG as f32;
            let curl = (1.15 * PI * (t - 0.45).max(0.0)).sin();
            let over = (t - 0.8).max(0.0) * 5.0;
            vec3(0.02 + 0.22 * tall * curl + 0.05 * t, tall * (t - 0.17 * over * over), 0.0)
        })
        .collect();
    let list = stations(&points, Vec3::Z);
    let ring = |k: usize| {
        let t = k as f32 / ALONG as f32;
        let half = 0.095 * (1.0 - 0.55 * t) * (1.0 + 0.12 * (5.0 * PI * t).cos());
        let spoke = |i: usize| {
            let (s, c) = (TAU * i as f32 / 10.0).sin_cos();
            list[k].across(half * c, 0.016 * s - 0.03 * c * c)
        };
        (0..10).map(spoke).collect::<Vec<_>>()
    };
    let mut rings = vec![vec![list[0].across(0.0, -0.012)]];
    rings.extend((0..=ALONG).map(ring));
    rings.push(vec![list[ALONG].across(0.0, -0.012)]);
    loft(&rings, Join { around: true, along: false }).outward()
}
