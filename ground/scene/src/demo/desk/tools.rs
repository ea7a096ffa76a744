//! A cup of pencils, a ruler and a brush, and the mug.

use super::super::shape::{Form, Profile, block, curve, lathe, loft, tube};
use super::super::stage::{Stage, mesh, placed};
use crate::MeshId;
use chiaro_basis::math::{DQuat, DVec3, Vec3, dvec3, vec3};
use std::f32::consts::TAU;

/// The cup at the back, the mug on the right.
pub(super) fn put(stage: &mut Stage) {
    put_cup(stage, dvec3(-2.55, 0.0, -2.35));
    put_mug(stage, dvec3(5.75, 0.0, 1.2));
}

fn put_cup(stage: &mut Stage, at: DVec3) {
    let clay = stage.material("cup", 0x9fb3b0, 0.4, 0.0);
    let outline = Profile::open(&[
        (0.0, 0.0, 0.0),
        (0.44, 0.0, 0.05),
        (0.45, 0.20, 0.02),
        (0.42, 0.24, 0.02),
        (0.42, 0.82, 0.02),
        (0.45, 0.86, 0.02),
        (0.46, 1.05, 0.03),
        (0.40, 1.05, 0.03),
        (0.38, 0.09, 0.06),
        (0.0, 0.08, 0.0),
    ]);
    stage.thing(
        "cup",
        None,
        placed(at, DQuat::IDENTITY, 1.0),
        (lathe(&outline.refined(0.14), 56), clay),
    );
    let colours = [0xd9a520, 0xa8322a, 0x2d5f8a, 0x3f6f45, 0x222222];
    for (k, colour) in colours.into_iter().enumerate() {
        let pencil = pencil(stage, colour);
        leaning(stage, pencil, at, 1.1 + 1.26 * k as f64, 0.20 + 0.035 * (k % 2) as f64);
    }
    let wood = stage.material("ruler", 0xcfa463, 0.6, 0.0);
    let ruler = block(vec3(0.34, 2.6, 0.04), 0.012, 2).at(0.0, 1.3, 0.0);
    let ticks = (0..24).map(|k| {
        let long = if k % 5 == 0 { 0.14 } else { 0.08 };
        block(vec3(long, 0.014, 0.012), 0.004, 1).at(0.17 - 0.5 * long, 0.15 + 0.1 * k as f32, 0.02)
    });
    let ruler = stage.mesh("ruler", [(ruler.with(Form::joined(ticks)), wood)]);
    leaning(stage, ruler, at, 0.35, 0.17);
    let brush = brush(stage);
    leaning(stage, brush, at, 2.4, 0.12);
}

/// Something long in the cup, its foot at one side of the bottom, leaning to the other.
fn leaning(stage: &mut Stage, mesh: MeshId, cup: DVec3, heading: f64, lean: f64) {
    let turn = DQuat::from_rotation_y(heading);
    let foot = cup + turn * dvec3(0.16, 0.10, 0.0);
    stage.show("tool", None, placed(foot, turn * DQuat::from_rotation_z(lean), 1.0), mesh);
}

/// A sharpened pencil, point up, 1.75 long.
pub(super) fn pencil(stage: &mut Stage, colour: u32) -> MeshId {
    let lacquer = stage.material(&format!("pencil {colour:06x}"), colour, 0.4, 0.0);
    let wood = stage.material("pencil wood", 0xd8b483, 0.8, 0.0);
    let lead = stage.material("lead", 0x2c2c2e, 0.4, 0.0);
    let hexagon = |y: f32, r: f32| -> Vec<Vec3> {
        let outline = Profile::closed(&std::array::from_fn::<_, 6, _>(|k| {
            let (s, c) = (TAU * k as f32 / 6.0).sin_cos();
            (c * r, s * r, 0.22 * r)
        }));
        outline.points.iter().map(|(p, _)| vec3(p.x, y, -p.y)).collect()
    };
    let whole = |rings: Vec<Vec<Vec3>>| {
        loft(&rings, super::super::shape::Join { around: true, along: false }).outward()
    };
    let end = |y: f32| vec![vec3(0.0, y, 0.0)];
    let shaft = whole(vec![
        end(0.0),
        hexagon(0.0, 0.105),
        hexagon(0.012, 0.12),
        hexagon(0.4, 0.12),
        hexagon(0.9, 0.12),
        hexagon(1.36, 0.12),
        hexagon(1.372, 0.114),
        end(1.372),
    ]);
    let cone = Profile::open(&[
        (0.0, 1.34, 0.0),
        (0.108, 1.34, 0.01),
        (0.036, 1.63, 0.005),
        (0.0, 1.64, 0.0),
    ]);
    let tip = Profile::open(&[
        (0.0, 1.60, 0.0),
        (0.038, 1.60, 0.005),
        (0.010, 1.74, 0.006),
        (0.0, 1.75, 0.0),
    ]);
    let parts = [(shaft, lacquer), (lathe(&cone, 24), wood), (lathe(&tip, 20), lead)];
    stage.push_mesh(mesh("pencil", parts))
}

fn brush(stage: &mut Stage) -> MeshId {
    let handle = stage.material("handle", 0x7a2f25, 0.3, 0.0);
    let metal = stage.material("ferrule", 0xc0c2c4, 0.25, 1.0);
    let hair = stage.material("bristle", 0x3b2c20, 0.8, 0.0);
    let grip = Profile::curve(
        &[(0.0, 0.0), (0.03, 0.02), (0.06, 0.5), (0.10, 1.2), (0.06, 1.6), (0.0, 1.62)],
        6,
    );
    let band =
        Profile::open(&[(0.0, 1.5, 0.0), (0.072, 1.5, 0.01), (0.085, 1.9, 0.01), (0.0, 1.9, 0.0)]);
    let tuft =
        Profile::curve(&[(0.0, 1.86), (0.07, 1.88), (0.12, 2.1), (0.08, 2.36), (0.0, 2.52)], 6);
    let flutes = |p: Vec3| {
        let a = (14.0 * p.z.atan2(p.x)).cos();
        vec3(p.x * (1.0 + 0.05 * a), p.y, p.z * (1.0 + 0.05 * a))
    };
    let parts = [
        (lathe(&grip, 24), handle),
        (lathe(&band, 32), metal),
        (lathe(&tuft, 84).bent(flutes), hair),
    ];
    stage.push_mesh(mesh("brush", parts))
}

fn put_mug(stage: &mut Stage, at: DVec3) {
    let glaze = stage.material("glaze", 0xe6dcc6, 0.25, 0.0);
    let coffee = stage.material("coffee", 0x2a170d, 0.1, 0.0);
    let band = stage.material("band", 0x33566e, 0.3, 0.0);
    let place = placed(at, DQuat::from_rotation_y(-0.5), 1.0);
    let outline = Profile::open(&[
        (0.0, 0.03, 0.0),
        (0.30, 0.03, 0.01),
        (0.32, 0.0, 0.015),
        (0.40, 0.0, 0.03),
        (0.46, 0.14, 0.10),
        (0.47, 1.0, 0.05),
        (0.49, 1.06, 0.025),
        (0.43, 1.06, 0.025),
        (0.41, 0.18, 0.12),
        (0.0, 0.10, 0.0),
    ]);
    let body = lathe(&outline.refined(0.15), 60);
    let through = [
        vec3(0.44, 0.86, 0.0),
        vec3(0.62, 0.90, 0.0),
        vec3(0.82, 0.76, 0.0),
        vec3(0.80, 0.44, 0.0),
        vec3(0.62, 0.26, 0.0),
        vec3(0.44, 0.24, 0.0),
    ];
    let handle = tube(&curve(&through, 40), 18, |_| 0.062).bent(|p| vec3(p.x, p.y, 1.35 * p.z));
    stage.thing("mug", None, place, (body.with(handle), glaze));
    let level = Profile::open(&[
        (0.0, 0.80, 0.0),
        (0.435, 0.80, 0.0),
        (0.445, 0.84, 0.01),
        (0.432, 0.83, 0.02),
        (0.0, 0.83, 0.0),
    ]);
    stage.thing("coffee", None, place, (lathe(&level, 40), coffee));
    let ring = |y: f32| {
        let o = Profile::closed(&[
            (0.462, y, 0.006),
            (0.484, y, 0.006),
            (0.484, y + 0.06, 0.006),
            (0.462, y + 0.06, 0.006),
        ]);
        lathe(&o, 56)
    };
    stage.thing("stripes", None, place, (ring(0.55).with(ring(0.66)), band));
}
