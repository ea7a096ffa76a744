//! A round table with chairs of bent iron, a jug and cups; lanterns.

use super::super::shape::{Form, Profile, block, curve, hoop, lathe, prism, tube};
use super::super::stage::{Stage, mesh, placed};
use super::Stuff;
use crate::MaterialId;
use chiaro_basis::math::{DQuat, DVec3, Vec3, dvec3, vec3};
use std::f32::consts::TAU;

/// The table at `at`, three chairs round it.
pub(super) fn put(stage: &mut Stage, stuff: &Stuff, at: DVec3) {
    let glaze = stage.material("glaze", 0xe4dcc8, 0.3, 0.0);
    let parts = [(table(), stuff.iron), (top(), stuff.stone), (crockery(), glaze)];
    let table = stage.push_mesh(mesh("table", parts));
    stage.show("table", None, placed(at, DQuat::from_rotation_y(0.3), 1.0), table);
    let chair = stage.push_mesh(mesh("chair", [(iron_chair(), stuff.iron), (seat(), stuff.wood)]));
    for (turn, away) in [(0.5f64, 0.82), (2.5, 0.90), (4.4, 0.98)] {
        let stand = at + dvec3(turn.sin(), 0.0, turn.cos()) * away;
        let facing = DQuat::from_rotation_y(turn + 0.12);
        stage.show("chair", None, placed(stand, facing, 1.0), chair);
    }
}

/// A pillar on three scrolled feet.
fn table() -> Form {
    let pillar = Profile::open(&[
        (0.0, 0.16, 0.0),
        (0.04, 0.16, 0.01),
        (0.028, 0.3, 0.05),
        (0.05, 0.42, 0.03),
        (0.026, 0.5, 0.03),
        (0.03, 0.70, 0.02),
        (0.16, 0.722, 0.005),
        (0.0, 0.735, 0.0),
    ]);
    let foot = [
        vec3(0.0, 0.34, 0.0),
        vec3(0.10, 0.30, 0.0),
        vec3(0.20, 0.12, 0.0),
        vec3(0.32, 0.03, 0.0),
        vec3(0.40, 0.05, 0.0),
        vec3(0.38, 0.10, 0.0),
    ];
    let foot = tube(&curve(&foot, 30), 10, |t| 0.022 - 0.006 * t);
    let feet = (0..3).map(|k| foot.clone().turned_y(120.0 * k as f32));
    lathe(&pillar.refined(0.05), 28).with(Form::joined(feet))
}

fn top() -> Form {
    prism(&Profile::circle(0.46, 64), 0.035, 0.014).at(0.0, 0.728, 0.0)
}

/// A jug and two cups.
fn crockery() -> Form {
    let jug = Profile::curve(
        &[
            (0.0, 0.0),
            (0.055, 0.0),
            (0.085, 0.06),
            (0.075, 0.13),
            (0.045, 0.18),
            (0.058, 0.225),
            (0.05, 0.222),
            (0.036, 0.18),
            (0.0, 0.17),
        ],
        5,
    );
    let handle = [
        vec3(0.046, 0.20, 0.0),
        vec3(0.09, 0.205, 0.0),
        vec3(0.115, 0.15, 0.0),
        vec3(0.07, 0.09, 0.0),
    ];
    let handle = tube(&curve(&handle, 20), 10, |_| 0.009);
    let cup = Profile::open(&[
        (0.0, 0.0, 0.0),
        (0.026, 0.0, 0.005),
        (0.040, 0.06, 0.02),
        (0.042, 0.075, 0.003),
        (0.038, 0.075, 0.003),
        (0.026, 0.012, 0.01),
        (0.0, 0.010, 0.0),
    ]);
    let cup = lathe(&cup.refined(0.02), 28);
    let on = |form: Form, x: f32, z: f32| form.at(x, 0.763, z);
    on(lathe(&jug, 36).with(handle), 0.08, -0.1)
        .with(on(cup.clone(), -0.16, 0.06))
        .with(on(cup, 0.14, 0.2))
}

/// Legs and back of bent rods; the sitter looks along -z.
fn iron_chair() -> Form {
    let rod = |points: &[Vec3], r: f32| tube(&curve(points, 8 * points.len()), 9, move |_| r);
    let mut rods = Vec::new();
    for side in [-1.0, 1.0] {
        let at = |x: f32, y: f32, z: f32| vec3(side * x, y, z);
        rods.push(rod(
            &[at(0.20, 0.0, -0.21), at(0.175, 0.22, -0.18), at(0.16, 0.44, -0.16)],
            0.011,
        ));
        let back = [
            at(0.21, 0.0, 0.23),
            at(0.18, 0.25, 0.19),
            at(0.175, 0.46, 0.17),
            at(0.18, 0.70, 0.20),
            at(0.12, 0.86, 0.235),
            at(0.0, 0.91, 0.245),
        ];
        rods.push(rod(&back, 0.011));
        let scroll = [
            at(0.0, 0.84, 0.235),
            at(0.09, 0.78, 0.22),
            at(0.08, 0.66, 0.20),
            at(0.02, 0.66, 0.20),
            at(0.03, 0.73, 0.21),
            at(0.055, 0.71, 0.205),
        ];
        rods.push(rod(&scroll, 0.007));
        rods.push(rod(&[at(0.0, 0.48, 0.175), at(0.08, 0.56, 0.18), at(0.05, 0.65, 0.195)], 0.007));
        rods.push(rod(&[at(0.175, 0.2, -0.18), at(0.17, 0.2, 0.0), at(0.185, 0.2, 0.195)], 0.007));
    }
    let round = |k: usize| {
        let (s, c) = (TAU * k as f32 / 40.0).sin_cos();
        vec3(0.19 * c, 0.445, 0.19 * s)
    };
    let rim = hoop(&(0..40).map(round).collect::<Vec<_>>(), Vec3::Y, 8, 0.011);
    Form::joined(rods).with(rim)
}

fn seat() -> Form {
    prism(&Profile::circle(0.188, 44).refined(0.03), 0.028, 0.01).at(0.0, 0.448, 0.0)
}

/// A lantern on its chain below the origin: ironwork, glass, a flame.
pub(super) fn lantern(stage: &mut Stage, stuff: &Stuff) -> Vec<(Form, MaterialId)> {
    // By day: flames light nothing.
    let flame = stage.material("flame", 0xf0c070, 0.6, 0.0);
    let link = |k: usize| {
        let point = |i: usize| {
            let (s, c) = (TAU * i as f32 / 12.0).sin_cos();
            let p = vec3(0.016 * c, 0.03 * s, 0.0);
            let p = if k.is_multiple_of(2) { p } else { vec3(0.0, p.y, p.x) };
            p - Vec3::Y * (0.03 + 0.045 * k as f32)
        };
        let across = if k.is_multiple_of(2) { Vec3::Z } else { Vec3::X };
        hoop(&(0..12).map(point).collect::<Vec<_>>(), across, 6, 0.005)
    };
    let chain = Form::joined((0..12).map(link));
    let low = -0.98;
    let lid = Profile::open(&[
        (0.0, 0.30, 0.0),
        (0.15, 0.30, 0.005),
        (0.16, 0.32, 0.005),
        (0.05, 0.41, 0.03),
        (0.03, 0.45, 0.01),
        (0.0, 0.46, 0.0),
    ]);
    let foot = Profile::open(&[
        (0.0, -0.02, 0.0),
        (0.03, -0.02, 0.005),
        (0.10, 0.0, 0.01),
        (0.10, 0.03, 0.005),
        (0.0, 0.035, 0.0),
    ]);
    let bar = |k: usize| {
        let (s, c) = (TAU * (k as f32 + 0.5) / 6.0).sin_cos();
        tube(
            &[
                vec3(0.085 * c, 0.01, 0.085 * s),
                vec3(0.11 * c, 0.16, 0.11 * s),
                vec3(0.135 * c, 0.31, 0.135 * s),
            ],
            6,
            |_| 0.008,
        )
    };
    let ironwork = lathe(&lid, 6).with(lathe(&foot, 6)).with(Form::joined((0..6).map(bar)));
    let glow =
        Profile::curve(&[(0.0, 0.06), (0.03, 0.08), (0.035, 0.13), (0.012, 0.2), (0.0, 0.23)], 5);
    let candle = block(vec3(0.03, 0.06, 0.03), 0.008, 2).at(0.0, 0.06, 0.0);
    let iron = chain.with(ironwork.with(candle).at(0.0, low, 0.0));
    vec![(iron, stuff.iron), (lathe(&glow, 16).at(0.0, low + 0.02, 0.0), flame)]
}
