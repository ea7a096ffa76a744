//! Papers: loose sheets with a curled corner, the top one with a drawing, a pencil, spectacles.

use super::super::shape::{Form, curve, hoop, tube};
use super::super::stage::{Stage, mesh, placed};
use super::tools;
use chiaro_basis::math::{DQuat, Vec2, Vec3, dvec3, vec2, vec3};
use std::f32::consts::TAU;

/// Half a sheet's width and height.
const HALF: Vec2 = Vec2::new(1.05, 1.48);

/// Everything between lamp and keyboard.
pub(super) fn put(stage: &mut Stage) {
    let plain = stage.matt("paper", 0xefe9dc);
    let drawn = stage.painted("drawing", 0.9, [512, 724], drawing);
    for (k, (x, z, turn)) in
        [(-2.3, 0.85, 0.32), (-1.75, 1.05, -0.14), (-2.0, 0.9, 0.10)].into_iter().enumerate()
    {
        let top = k == 2;
        let form = sheet_form(0.008 + 0.022 * k as f32, if top { 1.0 } else { 0.35 });
        let paper = mesh("sheet", [(form, if top { drawn } else { plain })])
            .mapped(|p, _| (vec2(p.x, p.z) + HALF) / (2.0 * HALF));
        let paper = stage.push_mesh(paper);
        stage.show(
            "sheet",
            None,
            placed(dvec3(x, 0.0, z), DQuat::from_rotation_y(turn), 1.0),
            paper,
        );
    }
    let pencil = tools::pencil(stage, 0xd9a520);
    let lying = DQuat::from_rotation_y(0.75) * DQuat::from_rotation_z(-1.558);
    stage.show("pencil", None, placed(dvec3(-2.35, 0.125, 1.75), lying, 1.0), pencil);
    put_spectacles(stage);
}

/// A sheet as a thin closed slab at height `y`, its far right corner curled up.
fn sheet_form(y: f32, curl: f32) -> Form {
    const N: usize = 28;
    let lift = |p: Vec2| {
        let far = ((p.x / HALF.x - p.y / HALF.y) - 1.05).max(0.0);
        0.42 * curl * far * far + 0.004 * (3.0 * p.x).sin() * (2.0 * p.y).cos()
    };
    let at = |i: usize, j: usize, up: f32| {
        let share = |k: usize| 2.0 * k as f32 / N as f32 - 1.0;
        let p = vec2(share(i), share(j)) * HALF;
        vec3(p.x, y + lift(p) + up, p.y)
    };
    // Round the slab's section, from one edge to the other.
    let ring = |j: usize| {
        let below = (0..=N).map(|i| at(i, j, -0.004));
        let above = (0..=N).rev().map(|i| at(i, j, 0.004));
        below.chain(above).collect::<Vec<_>>()
    };
    let mut rings = vec![vec![at(N / 2, 0, 0.0)]];
    rings.extend((0..=N).map(ring));
    rings.push(vec![at(N / 2, N, 0.0)]);
    let join = super::super::shape::Join { around: true, along: false };
    super::super::shape::loft(&rings, join).outward()
}

/// A sketch of a peanut-like figure between ruled lines, in sRGB.
fn drawing(u: f32, v: f32) -> [f32; 3] {
    let paper = [0.94, 0.92, 0.86];
    let p = vec2(u - 0.5, (v - 0.36) * 1.414);
    // Cassini's oval as in the peanut, and its shading.
    let (a, b) = (p - vec2(0.13, 0.02), p + vec2(0.13, -0.02));
    let oval = a.length() * b.length();
    let outline = (oval - 0.0245).abs() < 0.0028;
    let hatch = oval < 0.0245 && p.x + 0.6 * p.y > 0.03 && ((p.x - p.y) * 120.0).sin() > 0.3;
    let row = (v * 30.0).fract();
    let line = (v * 30.0) as i32;
    let written = (20..27).contains(&line) && (0.12..0.88 - 0.04 * (line % 3) as f32).contains(&u);
    let wave = 0.5 + 0.28 * (u * 170.0 + line as f32).sin() * (u * 31.0 + 2.0 * line as f32).cos();
    let word = (u * 19.0 + line as f32 * 0.37).fract() > 0.16;
    let ink = written && word && (row - wave).abs() < 0.14;
    if outline || hatch || ink { [0.16, 0.16, 0.2] } else { paper }
}

fn put_spectacles(stage: &mut Stage) {
    let horn = stage.material("horn", 0x33251c, 0.3, 0.0);
    let lens = |side: f32| -> Form {
        let point = |k: usize| {
            let (s, c) = (TAU * k as f32 / 48.0).sin_cos();
            vec3(side * 0.36 + 0.28 * c, 0.25 + 0.23 * s, 0.0)
        };
        hoop(&(0..48).map(point).collect::<Vec<_>>(), Vec3::Z, 10, 0.03)
    };
    let temple = |side: f32| {
        let through = [
            vec3(0.63, 0.33, 0.0),
            vec3(0.66, 0.335, -0.42),
            vec3(0.66, 0.31, -0.86),
            vec3(0.63, 0.08, -1.24),
        ];
        tube(&curve(&through.map(|p| p * vec3(side, 1.0, 1.0)), 24), 8, |_| 0.024)
    };
    let bridge = [vec3(-0.1, 0.30, 0.0), vec3(0.0, 0.36, 0.02), vec3(0.1, 0.30, 0.0)];
    let bridge = tube(&curve(&bridge, 12), 10, |_| 0.03);
    let form = Form::joined([lens(1.0), lens(-1.0), temple(1.0), temple(-1.0), bridge]);
    let place = placed(dvec3(-3.9, 0.0, 1.9), DQuat::from_rotation_y(0.5), 1.0);
    stage.thing("spectacles", None, place, (form, horn));
}
