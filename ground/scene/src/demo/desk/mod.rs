//! A writing desk: lamp, books, papers, a cup of pencils, keyboard, mug, and a toy of swinging balls.
//!
//! One unit is a decimetre; the top is at y = 0, its front towards +z. The lamp nods and its shade
//! swings after, the toy's outer balls swing in turn, keys go down as if someone typed.

mod books;
mod cradle;
mod keyboard;
mod lamp;
mod papers;
mod tools;

use super::shape::{Form, Profile, block, lathe, layers};
use super::stage::{Stage, boxed, mesh, moved};
use crate::{MaterialId, Projection, Scene};
use chiaro_basis::math::{Vec2, Vec3, vec2, vec3};

/// Half the top's width and depth, and its thickness.
const TOP: Vec3 = Vec3::new(7.2, 0.34, 3.7);
/// Where the floor is.
const FLOOR: f32 = -7.3;

/// The desk with everything on it.
pub(super) fn desk() -> Scene {
    let mut stage = Stage::default();
    put_desk(&mut stage);
    lamp::put(&mut stage, vec3(-5.0, 0.0, -2.0));
    books::put(&mut stage);
    papers::put(&mut stage);
    tools::put(&mut stage);
    keyboard::put(&mut stage, vec3(2.5, 0.0, 1.75));
    cradle::put(&mut stage, vec3(0.1, 0.0, -1.35));
    stage.sun(vec3(0.62, -0.86, -0.55), 2.6);
    let projection = Projection::Perspective { fov_y: 27f32.to_radians() };
    stage.camera(vec3(3.5, 8.6, 18.2), vec3(0.38, 0.75, -0.3), projection, 4.0 / 3.0);
    stage.finish()
}

/// Wood of two tones along u, in sRGB.
fn wood(dark: [f32; 3], light: [f32; 3]) -> impl Fn(f32, f32) -> [f32; 3] + Sync {
    move |u, v| {
        // On a circle, so that the picture repeats.
        let turn = Vec2::from_angle(std::f32::consts::TAU * v);
        let p = vec3(1.6 * (u - 0.5).abs(), 1.5 * turn.x, 1.5 * turn.y);
        let grain = layers(71, p, 3);
        let ring = (9.0 * grain + 2.0 * turn.y).sin();
        let fibre = layers(72, vec3(2.0 * (u - 0.5).abs(), 22.0 * turn.x, 22.0 * turn.y), 2);
        let t = (0.5 + 0.32 * ring + 0.35 * fibre).clamp(0.0, 1.0);
        std::array::from_fn(|k| dark[k] + (light[k] - dark[k]) * t)
    }
}

fn put_desk(stage: &mut Stage) {
    let oak = wood([0.42, 0.26, 0.14], [0.64, 0.43, 0.25]);
    let oak = stage.painted("oak", 0.5, [512, 256], oak);
    let brass = stage.material("brass", 0xb08d4a, 0.3, 1.0);
    let top = block(vec3(2.0 * TOP.x, TOP.y, 2.0 * TOP.z), 0.07, 4).at(0.0, -0.5 * TOP.y, 0.0);
    wooden(stage, "top", top, oak);
    for side in [-1.0, 1.0] {
        let x = side * 5.1;
        let height = -FLOOR - TOP.y;
        let carcass = block(vec3(3.2, height - 0.5, 6.6), 0.05, 3);
        wooden(stage, "pedestal", carcass.at(x, FLOOR + 0.5 * (height + 0.5), 0.0), oak);
        let plinth = block(vec3(3.0, 0.56, 6.3), 0.04, 2);
        wooden(stage, "plinth", plinth.at(x, FLOOR + 0.27, 0.0), oak);
        let mut y = -TOP.y - 0.28;
        for tall in [1.15, 1.75, 2.75] {
            let front = drawer_front(2.8, tall).at(x, y - 0.5 * tall, 3.3);
            wooden(stage, "drawer", front, oak);
            stage.thing(
                "knob",
                None,
                moved(f64::from(x), f64::from(y - 0.5 * tall), 3.42),
                (knob(), brass),
            );
            y -= tall + 0.22;
        }
    }
    let rail = block(vec3(7.2, 1.3, 0.22), 0.04, 2).at(0.0, -TOP.y - 0.62, 2.7);
    wooden(stage, "rail", rail, oak);
    let back = block(vec3(7.2, 4.6, 0.2), 0.04, 2).at(0.0, -TOP.y - 2.3, -2.9);
    wooden(stage, "back", back, oak);
}

/// A wooden thing with the grain along its sides.
fn wooden(stage: &mut Stage, name: &str, form: Form, wood: MaterialId) {
    let form = mesh(name, [(form, wood)]).mapped(boxed(vec2(0.09, 0.21)));
    let form = stage.push_mesh(form);
    stage.show(name, None, moved(0.0, 0.0, 0.0), form);
}

/// A board with a raised field, facing +z.
fn drawer_front(width: f32, height: f32) -> Form {
    let board = block(vec3(width, height, 0.16), 0.05, 3);
    board.with(block(vec3(width - 0.5, height - 0.5, 0.12), 0.05, 3).at(0.0, 0.0, 0.06))
}

/// A turned knob towards +z.
fn knob() -> Form {
    let outline = Profile::curve(
        &[(0.0, -0.06), (0.09, -0.06), (0.07, 0.1), (0.17, 0.2), (0.15, 0.3), (0.0, 0.33)],
        5,
    );
    lathe(&outline, 20).turned_x(90.0)
}
