//! The pot on its saucer, with soil and pebbles.

use super::super::shape::{Form, Profile, ball, between, lathe, layers, rotation};
use super::super::stage::Stage;
use chiaro_basis::math::{Affine3A, Vec3, vec3};
use std::f32::consts::TAU;

/// The pot; its rim is a little above the soil.
pub(super) fn put(stage: &mut Stage) {
    let clay = stage.material("terracotta", 0xb5653f, 0.8, 0.0);
    let earth = stage.material("soil", 0x4a3426, 0.95, 0.0);
    let stone = stage.material("pebbles", 0xb8b0a2, 0.7, 0.0);
    stage.thing("pot", None, Default::default(), (pot(), clay));
    stage.thing("saucer", None, Default::default(), (saucer(), clay));
    stage.thing("soil", None, Default::default(), (soil(), earth));
    stage.thing("pebbles", None, Default::default(), (pebbles(), stone));
}

fn pot() -> Form {
    let outline = Profile::open(&[
        (0.0, -2.55, 0.0),
        (1.12, -2.55, 0.06),
        (1.46, -0.40, 0.05),
        (1.66, -0.40, 0.05),
        (1.74, 0.22, 0.07),
        (1.56, 0.22, 0.07),
        (1.44, -0.45, 0.05),
        (1.10, -2.35, 0.10),
        (0.0, -2.35, 0.0),
    ]);
    let grooved = |p: Vec3| {
        // Two turned lines below the rim.
        let line = |y: f32| (-((p.y - y) / 0.035).powi(2)).exp();
        let r = 1.0 - 0.022 * (line(-0.72) + line(-0.84));
        vec3(p.x * r, p.y, p.z * r)
    };
    lathe(&outline.refined(0.09), 96).bent(grooved)
}

fn saucer() -> Form {
    let outline = Profile::open(&[
        (0.0, -2.74, 0.0),
        (1.45, -2.74, 0.05),
        (1.72, -2.40, 0.05),
        (1.62, -2.36, 0.04),
        (1.38, -2.56, 0.06),
        (0.0, -2.58, 0.0),
    ]);
    lathe(&outline.refined(0.12), 96)
}

fn soil() -> Form {
    let outline =
        Profile::open(&[(0.0, -0.5, 0.0), (1.45, -0.5, 0.1), (1.52, -0.06, 0.08), (0.0, 0.0, 0.0)]);
    lathe(&outline.refined(0.07), 90).swollen(|p, n| 0.05 * n.y.max(0.0) * layers(101, p * 4.0, 3))
}

fn pebbles() -> Form {
    let pebble = |k: u64| {
        let (r, a) = (between(102, k, 0.88, 1.46), TAU * between(103, k, 0.0, 1.0));
        let size = between(104, k, 0.06, 0.17) * (1.6 - r).clamp(0.3, 1.0).sqrt();
        let shape = vec3(1.0, 0.62, 0.8) * size;
        let place = vec3(r * a.cos(), 0.02, r * a.sin());
        let turn = chiaro_basis::math::Quat::from_rotation_y(rotation(105, k).x * 9.0);
        let by = Affine3A::from_scale_rotation_translation(shape, turn, place);
        ball(4).swollen(|p, _| 0.16 * layers(106 + k, p * 1.4, 2)).moved(by)
    };
    Form::joined((0..54).map(pebble))
}
