//! Orange trees in pots: a stem with branches, leaves and fruit about their ends.

use super::super::motion::{follow, turning};
use super::super::shape::{Form, Profile, ball, between, curve, lathe, spiral, tube};
use super::super::stage::{Stage, mesh, placed};
use chiaro_basis::math::{Affine3A, DQuat, DVec3, Quat, Vec3, dvec3, vec3};
use chiaro_basis::random::unit;
use std::f32::consts::{PI, TAU};

/// A tree at each place; crowns stir in the wind, one after the other.
pub(super) fn put(stage: &mut Stage, places: &[DVec3]) {
    let clay = stage.matt("terracotta", 0xb86c45);
    let earth = stage.matt("earth", 0x4a3728);
    let bark = stage.matt("bark", 0x6b5642);
    let green = stage.material("foliage", 0x4f7a3c, 0.6, 0.0);
    let orange = stage.material("fruit", 0xe0862c, 0.5, 0.0);
    let pot = stage.push_mesh(mesh("pot", [(pot(), clay), (soil(), earth)]));
    let (wood, leaves, fruit) = crown();
    let parts = [(wood, bark), (leaves, green), (fruit, orange)];
    let crown = stage.push_mesh(mesh("tree", parts));
    for (k, &at) in places.iter().enumerate() {
        let turn = DQuat::from_rotation_y(2.4 * k as f64);
        let stand = stage.joint("stand", None, placed(at, turn, 1.0));
        stage.show("pot", Some(stand), Default::default(), pot);
        let tree = stage.show(
            "tree",
            Some(stand),
            placed(dvec3(0.0, 0.6, 0.0), DQuat::IDENTITY, 1.0),
            crown,
        );
        let start = 0.37 * k as f64;
        let gust = |t: f64| 0.022 * (std::f64::consts::TAU * (t + start)).sin();
        let lag = follow(gust, 1.3, 0.2);
        stage.animate(tree, turning(|t| DQuat::from_scaled_axis(dvec3(lag.at(t), 0.0, gust(t)))));
    }
}

fn pot() -> Form {
    let outline = Profile::open(&[
        (0.0, 0.0, 0.0),
        (0.26, 0.0, 0.02),
        (0.30, 0.06, 0.02),
        (0.40, 0.50, 0.10),
        (0.46, 0.52, 0.02),
        (0.47, 0.64, 0.02),
        (0.41, 0.64, 0.02),
        (0.36, 0.48, 0.05),
        (0.25, 0.10, 0.03),
        (0.0, 0.10, 0.0),
    ]);
    lathe(&outline.refined(0.08), 48).bent(|p| {
        let swag = (-((p.y - 0.36) / 0.05).powi(2)).exp() * (6.0 * p.z.atan2(p.x)).cos().abs();
        let r = 1.0 + 0.05 * swag;
        vec3(p.x * r, p.y, p.z * r)
    })
}

fn soil() -> Form {
    let outline = Profile::open(&[
        (0.0, 0.45, 0.0),
        (0.37, 0.45, 0.0),
        (0.385, 0.56, 0.02),
        (0.0, 0.60, 0.0),
    ]);
    lathe(&outline, 32)
}

/// Stem and branches, leaves, fruit, from the soil at the origin.
fn crown() -> (Form, Form, Form) {
    let middle = vec3(0.0, 1.42, 0.0);
    let stem = [vec3(0.0, -0.08, 0.0), vec3(0.03, 0.4, 0.02), vec3(-0.02, 0.9, -0.02), middle];
    let mut wood = tube(&curve(&stem, 18), 12, |t| 0.055 - 0.02 * t);
    let (mut leaves, mut fruit) = (Form::default(), Form::default());
    let one = leaf();
    for (k, way) in spiral(46).enumerate() {
        let seed = k as u64;
        let size = vec3(0.62, 0.56, 0.62);
        let end = middle + way * size * between(141, seed, 0.72, 1.05);
        if k % 4 == 0 {
            let start = middle - Vec3::Y * (0.25 + 0.2 * unit(142, seed));
            let bend = start.lerp(end, 0.5) + 0.06 * Vec3::Y;
            wood = wood.with(tube(&curve(&[start, bend, end], 8), 7, |t| 0.022 - 0.014 * t));
        }
        for j in 0..5 {
            let lot = |s: u64, low: f32, high: f32| between(143 + s, 10 * seed + j, low, high);
            let root = end + vec3(lot(0, -0.13, 0.13), lot(1, -0.12, 0.12), lot(2, -0.13, 0.13));
            let aim =
                (way + vec3(lot(3, -0.8, 0.8), lot(4, -0.6, 0.5), lot(5, -0.8, 0.8))).normalize();
            let turn =
                Quat::from_rotation_arc(Vec3::X, aim) * Quat::from_rotation_x(lot(6, 0.0, TAU));
            let scale = Vec3::splat(lot(7, 0.8, 1.25));
            let by = Affine3A::from_scale_rotation_translation(scale, turn, root);
            leaves = leaves.with(one.clone().moved(by));
        }
        if k % 5 == 2 {
            let at = end + way * 0.04 - Vec3::Y * 0.05;
            fruit = fruit.with(ball(4).scaled(0.055, 0.053, 0.055).at(at.x, at.y, at.z));
        }
    }
    (wood, leaves, fruit)
}

/// A leaf along x: two-sided, a few triangles thick.
fn leaf() -> Form {
    super::super::shape::pointed(8, 6, |u, v| {
        let (s, c) = (TAU * u).sin_cos();
        let half = 0.042 * (PI * v.powf(0.85)).sin().max(0.0);
        vec3(0.17 * v, 0.5 * half * c * c - 0.05 * v * v + (0.003 + 0.08 * half) * s, half * c)
    })
}
