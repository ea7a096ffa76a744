//! Fruit and their leaves: shapes with a stalk, each a mesh that stands on y = 0 when upright.
//!
//! One unit is a decimetre. Skins are closed; stalks and leaves are buried in them.

use super::shape::{Form, Profile, ball, curve, lathe, noise, stations, tube};
use super::stage::{Stage, mesh};
use crate::{MaterialId, MeshId};
use chiaro_basis::math::{Vec3, vec3};
use std::f32::consts::{PI, TAU};

/// The materials of fruit.
pub(super) struct Paints {
    red: MaterialId,
    green: MaterialId,
    orange: MaterialId,
    yellow: MaterialId,
    violet: MaterialId,
    leaf: MaterialId,
    stalk: MaterialId,
}

impl Paints {
    /// Adds them to a stage.
    pub(super) fn new(stage: &mut Stage) -> Self {
        Self {
            red: stage.material("apple", 0xb5382c, 0.35, 0.0),
            green: stage.material("pear", 0xa9b04a, 0.5, 0.0),
            orange: stage.material("orange", 0xe08a2c, 0.5, 0.0),
            yellow: stage.material("lemon", 0xe3c64b, 0.45, 0.0),
            violet: stage.material("grape", 0x4d2f57, 0.35, 0.0),
            leaf: stage.material("leaf", 0x4c7a3a, 0.6, 0.0),
            stalk: stage.material("stalk", 0x5f4a33, 0.8, 0.0),
        }
    }
}

/// An apple with five faint lobes, a stalk and a leaf; about 0.8 wide.
pub(super) fn apple(stage: &mut Stage, paints: &Paints) -> MeshId {
    let outline = Profile::curve(
        &[
            (0.0, 0.09),
            (0.07, 0.03),
            (0.16, 0.0),
            (0.31, 0.10),
            (0.41, 0.36),
            (0.37, 0.60),
            (0.22, 0.73),
            (0.09, 0.70),
            (0.0, 0.58),
        ],
        5,
    );
    let skin = lathe(&outline, 72).bent(|p| {
        let lobes = (5.0 * p.z.atan2(p.x)).cos() * p.x.hypot(p.z);
        vec3(p.x, p.y - 0.05 * lobes * (1.0 - 1.6 * p.y), p.z) * (1.0 + 0.04 * lobes)
    });
    let stem = [vec3(0.0, 0.55, 0.0), vec3(0.01, 0.72, 0.0), vec3(0.05, 0.90, 0.02)];
    let stem = tube(&curve(&stem, 10), 10, |t| 0.018 + 0.012 * t * t);
    let leaf = leaf(0.42, 0.20).turned_z(24.0).turned_y(40.0).at(0.02, 0.76, 0.01);
    mesh_of(stage, "apple", [(skin, paints.red), (stem, paints.stalk), (leaf, paints.leaf)])
}

/// A pear, leaning a little; about 0.7 wide and 1.1 high.
pub(super) fn pear(stage: &mut Stage, paints: &Paints) -> MeshId {
    let outline = Profile::curve(
        &[
            (0.0, 0.05),
            (0.10, 0.0),
            (0.28, 0.10),
            (0.37, 0.34),
            (0.30, 0.60),
            (0.19, 0.82),
            (0.13, 0.98),
            (0.06, 1.04),
            (0.0, 1.01),
        ],
        6,
    );
    let lean = |p: Vec3| vec3(p.x + 0.10 * p.y * p.y, p.y, p.z);
    let skin = lathe(&outline, 64).bent(lean);
    let stem = [vec3(0.0, 0.98, 0.0), vec3(0.0, 1.12, 0.0), vec3(-0.05, 1.27, 0.0)];
    let stem = tube(&curve(&stem, 10), 10, |t| 0.022 + 0.01 * t).bent(lean);
    mesh_of(stage, "pear", [(skin, paints.green), (stem, paints.stalk)])
}

/// An orange with pores; about 0.76 wide.
pub(super) fn orange(stage: &mut Stage, paints: &Paints) -> MeshId {
    let skin = ball(28).swollen(|p, _| {
        let poles = (-(p.x * p.x + p.z * p.z) / 0.02).exp();
        0.02 * noise(81, p * 13.0) + 0.012 * noise(82, p * 2.0) - 0.05 * poles
    });
    let button = ball(6).scaled(0.045, 0.03, 0.045).at(0.0, 0.735, 0.0);
    let skin = skin.scaled(0.38, 0.37, 0.38).at(0.0, 0.37, 0.0);
    mesh_of(stage, "orange", [(skin, paints.orange), (button, paints.stalk)])
}

/// A lemon lying along x; about 0.85 long.
pub(super) fn lemon(stage: &mut Stage, paints: &Paints) -> MeshId {
    let outline = Profile::curve(
        &[
            (0.0, -0.46),
            (0.05, -0.44),
            (0.08, -0.38),
            (0.20, -0.27),
            (0.28, 0.0),
            (0.21, 0.25),
            (0.08, 0.35),
            (0.05, 0.38),
            (0.0, 0.39),
        ],
        6,
    );
    let bumps = |p: Vec3, _: Vec3| 0.009 * noise(83, p * 22.0);
    let skin = lathe(&outline, 64).swollen(bumps).turned_z(90.0).at(0.0, 0.28, 0.0);
    mesh_of(stage, "lemon", [(skin, paints.yellow)])
}

/// A banana on its back; about 1.6 long.
pub(super) fn banana(stage: &mut Stage, paints: &Paints) -> MeshId {
    let point = |k: usize| {
        let a = -1.15 + 2.3 * k as f32 / 40.0;
        vec3(0.95 * a.sin(), 0.95 - 0.95 * a.cos() + 0.17, 0.0)
    };
    let points: Vec<Vec3> = (0..=40).map(point).collect();
    let list = stations(&points, Vec3::Z);
    let ring = |k: usize| {
        let t = k as f32 / 40.0;
        let ends = (t / 0.14).min((1.0 - t) / 0.10).min(1.0);
        let wide = 0.045 + 0.125 * (0.5 - 0.5 * (PI * ends).cos()).powf(0.8);
        let spoke = |i: usize| {
            let a = TAU * i as f32 / 40.0;
            let r = wide * (1.0 + 0.05 * (5.0 * a).cos());
            list[k].across(r * a.cos(), r * a.sin())
        };
        (0..40).map(spoke).collect::<Vec<_>>()
    };
    let mut rings = vec![vec![points[0]]];
    rings.extend((0..=40).map(ring));
    rings.push(vec![points[40]]);
    let join = super::shape::Join { around: true, along: false };
    let skin = super::shape::loft(&rings, join).outward();
    let tip = points[40] - points[39];
    let cap = tube(&[points[39], points[40], points[40] + 2.2 * tip], 12, |t| 0.05 - 0.012 * t);
    mesh_of(stage, "banana", [(skin, paints.yellow), (cap, paints.stalk)])
}

/// A bunch of grapes hanging down from its stalk at y = 0.
pub(super) fn grapes(stage: &mut Stage, paints: &Paints) -> MeshId {
    let berry = ball(7).scaled(0.125, 0.138, 0.125);
    let mut bunch = Form::default();
    for k in 0..34 {
        let y = -0.12 - 0.92 * k as f32 / 34.0;
        let wide = 0.34 * (1.0 - ((y + 0.42) / 0.78).powi(2)).max(0.05).sqrt();
        let (s, c) = (2.4 * k as f32).sin_cos();
        bunch = bunch.with(berry.clone().turned_z(17.0 * k as f32).at(wide * c, y, wide * s));
    }
    let stem =
        [vec3(0.0, -0.9, 0.0), vec3(0.0, -0.2, 0.0), vec3(0.03, 0.08, 0.0), vec3(0.10, 0.16, 0.0)];
    let stem = tube(&curve(&stem, 16), 8, |_| 0.025);
    mesh_of(stage, "grapes", [(bunch, paints.violet), (stem, paints.stalk)])
}

/// A pointed leaf from the origin along x, thin but closed, with a bent midrib.
pub(super) fn leaf(length: f32, width: f32) -> Form {
    super::shape::pointed(24, 20, |u, v| {
        // Sections of a flat ellipse; the blade droops and folds along its rib.
        let (s, c) = (TAU * u).sin_cos();
        let x = length * v;
        let half = 0.5 * width * (PI * v.powf(0.8)).sin().max(0.0).powf(0.9);
        let z = half * c;
        let fold = 0.45 * z.abs();
        let thick = 0.02 * width.min(0.3) * (4.0 * v * (1.0 - v)).max(0.0).sqrt() + 0.004 * half;
        let droop = 0.35 * length * v * v;
        vec3(x, fold - droop + 0.5 * thick.max(0.003) * s, z)
    })
}

fn mesh_of(
    stage: &mut Stage,
    name: &str,
    parts: impl IntoIterator<Item = (Form, MaterialId)>,
) -> MeshId {
    stage.push_mesh(mesh(name, parts))
}
