//! A bowl of fruit that rocks on its foot, on a cloth-covered round table.
//!
//! The bowl leans round in a circle; the fruit in it follow late, each by its own weight. One unit is
//! a decimetre; the table's top is at y = 0.

use super::fruit::{self, Paints};
use super::motion::{Signal, follow, turning};
use super::shape::{Form, Profile, lathe, tube};
use super::stage::{Stage, mesh, placed};
use crate::{MeshId, NodeId, Projection, Scene};
use chiaro_basis::math::{DQuat, DVec3, Vec3, dvec3, vec3};
use std::f32::consts::{PI, TAU as TURN};
use std::f64::consts::TAU;

/// The greatest lean of the bowl, radians.
const LEAN: f64 = 0.075;

/// The bowl, what is in it and what stands by.
pub(super) fn bowl() -> Scene {
    let mut stage = Stage::default();
    let paints = Paints::new(&mut stage);
    let glaze = stage.material("glaze", 0x5b86a3, 0.3, 0.0);
    let lace = stage.material("cloth", 0xe6dfd0, 0.9, 0.0);
    stage.thing("cloth", None, Default::default(), (cloth(), lace));
    let rock = stage.joint("bowl", None, placed(DVec3::ZERO, DQuat::IDENTITY, 1.0));
    stage.animate(rock, turning(|t| leaning(round(t))));
    stage.thing("bowl", Some(rock), Default::default(), (dish(), glaze));
    fill(&mut stage, rock, &paints);
    put_beside(&mut stage, &paints);
    let projection = Projection::Perspective { fov_y: 26f32.to_radians() };
    stage.camera(vec3(2.9, 4.5, 8.4), vec3(0.05, 0.66, 0.1), projection, 4.0 / 3.0);
    stage.finish()
}

/// The lean of the bowl at a phase, about x and z.
fn round(t: f64) -> [f64; 2] {
    [LEAN * (TAU * t).cos(), LEAN * (TAU * t).sin()]
}

fn leaning([x, z]: [f64; 2]) -> DQuat {
    DQuat::from_scaled_axis(dvec3(x, 0.0, z))
}

/// A fluted bowl on a foot, its lip scalloped.
fn dish() -> Form {
    let profile = Profile::curve(
        &[
            (0.0, 0.05),
            (0.55, 0.05),
            (0.66, 0.0),
            (0.74, 0.02),
            (0.76, 0.12),
            (0.86, 0.24),
            (1.22, 0.42),
            (1.58, 0.74),
            (1.80, 1.14),
            (1.90, 1.26),
            (1.93, 1.33),
            (1.86, 1.33),
            (1.74, 1.20),
            (1.50, 0.82),
            (1.14, 0.52),
            (0.60, 0.30),
            (0.0, 0.26),
        ],
        6,
    );
    lathe(&profile, 144).bent(|p| {
        let (r, a) = (p.x.hypot(p.z), p.z.atan2(p.x));
        let high = ((p.y - 0.25) / 1.1).clamp(0.0, 1.0);
        let flute = (24.0 * a).cos();
        let side = 1.0 + 0.022 * flute * (high * (1.0 - 0.3 * high)).min(1.0) * (r / 0.9).min(1.0);
        vec3(p.x * side, p.y + 0.05 * high.powi(4) * (12.0 * a).cos(), p.z * side)
    })
}

/// What lies in the bowl: kind, place, turn about the vertical, lean.
fn fill(stage: &mut Stage, rock: NodeId, paints: &Paints) {
    let [apple, pear, orange, lemon, banana, grapes] = meshes(stage, paints);
    let heap: [(MeshId, [f64; 3], f64, [f64; 2]); 12] = [
        (apple, [0.62, 0.62, 0.62], 0.4, [0.25, -0.2]),
        (orange, [-0.30, 0.55, 0.75], 1.1, [0.5, 0.3]),
        (apple, [-0.95, 0.66, 0.10], 2.0, [-0.2, 0.35]),
        (pear, [0.98, 0.74, -0.18], 2.6, [0.2, -0.75]),
        (orange, [0.12, 0.50, -0.10], 0.2, [0.8, 0.1]),
        (lemon, [-0.62, 0.70, -0.72], 0.9, [0.2, 0.1]),
        (apple, [0.28, 0.68, -0.92], 4.0, [-0.35, -0.1]),
        (pear, [-0.28, 1.05, -0.28], 0.6, [-0.15, 0.35]),
        (lemon, [0.20, 1.10, 0.55], 2.2, [0.1, -0.2]),
        (banana, [-0.55, 1.02, 0.42], 2.45, [0.95, 0.25]),
        (banana, [-0.28, 1.16, 0.52], 2.20, [0.85, 0.2]),
        (grapes, [1.32, 1.42, 0.62], 5.6, [0.15, 0.85]),
    ];
    for (k, (mesh, [x, y, z], turn, lean)) in heap.into_iter().enumerate() {
        let lag = late(1.1 + 0.17 * (k % 5) as f64);
        let rest = DQuat::from_rotation_y(turn);
        let tip = DQuat::from_scaled_axis(dvec3(lean[0], 0.0, lean[1]));
        let node = stage.show("fruit", Some(rock), placed(dvec3(x, y, z), tip * rest, 1.0), mesh);
        let behind = |t: f64| [0, 1].map(|i| 1.4 * (lag[i].at(t) - round(t)[i]));
        stage.animate(node, turning(|t| leaning(behind(t)) * tip * rest));
    }
}

fn late(frequency: f64) -> [Signal; 2] {
    [0, 1].map(|k| follow(|t| round(t)[k], frequency, 0.22))
}

fn meshes(stage: &mut Stage, paints: &Paints) -> [MeshId; 6] {
    [
        fruit::apple(stage, paints),
        fruit::pear(stage, paints),
        fruit::orange(stage, paints),
        fruit::lemon(stage, paints),
        fruit::banana(stage, paints),
        fruit::grapes(stage, paints),
    ]
}

/// A pear and an apple on the cloth, and a fruit knife.
fn put_beside(stage: &mut Stage, paints: &Paints) {
    let apple = fruit::apple(stage, paints);
    let lemon = fruit::lemon(stage, paints);
    let on = |x: f64, z: f64, turn: DQuat| placed(dvec3(x, 0.03, z), turn, 1.0);
    stage.show("apple", None, on(2.25, 1.15, DQuat::from_rotation_y(0.6)), apple);
    stage.show("lemon", None, on(-1.75, 1.75, DQuat::from_rotation_y(0.5)), lemon);
    let steel = stage.material("blade", 0xc9ccd0, 0.2, 1.0);
    let horn = stage.material("handle", 0x4b3122, 0.4, 0.0);
    let parts = [(blade(), steel), (handle(), horn)];
    let knife = stage.push_mesh(mesh("knife", parts));
    let lying = placed(dvec3(0.35, 0.075, 2.45), DQuat::from_rotation_y(0.12), 1.0);
    stage.show("knife", None, lying, knife);
}

/// A blade from the origin along +x, thinner to its edge at +z.
fn blade() -> Form {
    super::shape::pointed(28, 30, |u, v| {
        let (s, c) = (TURN * u).sin_cos();
        let x = 1.45 * v;
        let tip = ((1.0 - v) / 0.35).min(1.0);
        let wide = 0.17 * (1.0 - (1.0 - tip).powi(2)).max(0.0).sqrt() * (v / 0.04).min(1.0);
        let back = 0.17 - wide;
        vec3(x, 0.018 * s * (0.6 - 0.4 * c) * (v / 0.04).min(1.0), wide * c - 0.6 * back)
    })
}

fn handle() -> Form {
    let points: Vec<Vec3> =
        (0..=16).map(|k| vec3(0.02 - 1.15 * k as f32 / 16.0, 0.0, 0.0)).collect();
    tube(&points, 20, |t| 0.075 + 0.03 * (PI * (1.4 * t + 0.2)).sin().powi(2))
        .scaled(1.0, 0.72, 1.25)
}

/// A round cloth whose edge hangs in folds over the table; thin and closed.
fn cloth() -> Form {
    const AROUND: usize = 180;
    const OUT: usize = 36;
    let height = |r: f32, a: f32| {
        let hang = ((r - 2.9) / 0.9).max(0.0);
        let folds = (17.0 * a).sin() + 0.5 * (11.0 * a + 1.0).sin();
        let weave = 0.006 * (7.0 * r).sin() * (9.0 * a).sin();
        (-(1.35 * hang).powf(1.6) + weave, 1.0 + 0.035 * folds * hang.min(1.4))
    };
    let at = |k: usize, i: usize, up: f32| {
        let r = 3.75 * k as f32 / OUT as f32;
        let a = TURN * i as f32 / AROUND as f32;
        let (y, wide) = height(r, a);
        // Past the table's edge the cloth falls rather than spreads.
        let reach = if r < 2.9 { r } else { 2.9 + 0.42 * (1.0 - (-(r - 2.9) / 0.42).exp()) };
        vec3(reach * wide * a.cos(), y + up, reach * wide * a.sin())
    };
    let ring = |k: usize, up: f32| -> Vec<Vec3> {
        if k == 0 { vec![at(0, 0, up)] } else { (0..AROUND).map(|i| at(k, i, up)).collect() }
    };
    let above = (0..=OUT).map(|k| ring(k, 0.0));
    let below = (0..=OUT).rev().map(|k| ring(k, -0.03));
    let rings: Vec<Vec<Vec3>> = above.chain(below).collect();
    super::shape::loft(&rings, super::shape::Join { around: true, along: false }).outward()
}
