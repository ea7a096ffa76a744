//! A hundred dented balls on a plane under one sun: 512 002 triangles, flat or smooth, for light
//! that bounces between many rough things.

use super::shape::{Form, ball, between, noise, rotation, sheet};
use super::stage::{Stage, moved};
use crate::{Projection, Scene};
use chiaro_basis::math::{Affine3A, Vec3, vec3};
use chiaro_basis::random::unit;
use rayon::prelude::*;

/// With a normal a face.
pub(super) fn flat() -> Scene {
    field(Form::faceted)
}

/// With a normal a vertex.
pub(super) fn smooth() -> Scene {
    field(|form| form)
}

fn field(finish: impl Fn(Form) -> Form + Sync) -> Scene {
    const SIDE: u64 = 10;
    let mut stage = Stage::default();
    let ground = stage.matt("ground", 0xd8d2c4);
    let paints = [0xc8553d, 0xe0a458, 0x6a994e, 0x4a7fa7, 0xdfd9cf, 0x8d6a9f]
        .map(|colour| stage.matt(&format!("{colour:06x}"), colour));
    let floor = sheet(1, 1, |u, v| vec3(60.0 * (u - 0.5), 0.0, 60.0 * (0.5 - v)));
    stage.thing("plane", None, Default::default(), (floor, ground));
    let forms: Vec<(f32, Form)> = (0..SIDE * SIDE).into_par_iter().map(dented).collect();
    for (i, (radius, form)) in forms.into_iter().enumerate() {
        let index = i as u64;
        let place = |k: u64, cell: u64| {
            f64::from(cell as f32 - 4.5 + between(51 + k, index, -0.14, 0.14)) * 0.96
        };
        let at = moved(place(0, index % SIDE), f64::from(radius) * 0.93, place(1, index / SIDE));
        let paint = paints[(unit(53, index) * paints.len() as f32) as usize];
        stage.thing(&format!("ball {i}"), None, at, (finish(form), paint));
    }
    stage.sun(vec3(0.45, -0.8, -0.4), 3.0);
    let camera = Projection::Perspective { fov_y: 36f32.to_radians() };
    stage.camera(vec3(4.2, 7.0, 7.6), vec3(0.0, 0.0, 0.35), camera, 4.0 / 3.0);
    stage.finish()
}

/// A dented ball about its centre, with its radius: 5120 triangles.
fn dented(index: u64) -> (f32, Form) {
    let radius = between(54, index, 0.3, 0.5);
    let (coarse, fine) = (between(55, index, 0.10, 0.24), between(56, index, 0.02, 0.06));
    let offset = Vec3::splat(17.0 * index as f32);
    let height =
        |p: Vec3| coarse * noise(57, p * 1.7 + offset) + fine * noise(58, p * 5.0 + offset);
    let turn = Affine3A::from_quat(rotation(59, index)) * Affine3A::from_scale(Vec3::splat(radius));
    (radius, ball(16).swollen(|p, _| height(p)).moved(turn))
}
