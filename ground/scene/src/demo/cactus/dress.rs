//! What the cactus wears: a straw hat with a band, a moustache, a flower.

use super::super::motion::turning;
use super::super::shape::{Form, Profile, ball, between, curve, lathe, stations, tube};
use super::super::stage::{Stage, placed};
use super::{bend, late, lean};
use crate::NodeId;
use chiaro_basis::math::{DQuat, DVec3, Vec3, dvec3, vec3};
use std::f32::consts::{PI, TAU};

/// Where the moustache sits: the front of the body.
const LIP: Vec3 = Vec3::new(0.04, 3.62, 0.86);

/// A hat that tips after the body, below the node at `origin`.
pub(super) fn put_hat(stage: &mut Stage, node: NodeId, origin: DVec3) {
    let straw = stage.material("straw", 0xd9b65f, 0.85, 0.0);
    let ribbon = stage.material("ribbon", 0xa3312c, 0.6, 0.0);
    let at = dvec3(0.03, 5.42, 0.0) - origin;
    let hat = stage.joint("hat", Some(node), placed(at, DQuat::IDENTITY, 1.0));
    let lag = late(1.5, 0.14);
    let tip = |t: f64| {
        [1.6 * (lag[0].at(t) - lean(t)[0]) + 0.05, 1.6 * (lag[1].at(t) - lean(t)[1]) - 0.05]
    };
    stage.animate(hat, turning(|t| bend(tip(t))));
    stage.thing("hat", Some(hat), Default::default(), (straw_hat(), straw));
    stage.thing("hat band", Some(hat), Default::default(), (band(), ribbon));
}

/// A wide brim turned up at the sides, a pinched crown; plaited rings run round it.
fn straw_hat() -> Form {
    // From the crown's inside outwards below the brim, and back over it.
    let profile = Profile::curve(
        &[
            (0.0, 0.80),
            (0.30, 0.85),
            (0.58, 0.80),
            (0.70, 0.42),
            (0.82, 0.0),
            (1.05, -0.05),
            (1.50, -0.06),
            (1.84, 0.06),
            (1.90, 0.12),
            (1.84, 0.11),
            (1.50, 0.01),
            (1.05, 0.03),
            (0.84, 0.10),
            (0.74, 0.45),
            (0.64, 0.86),
            (0.52, 0.96),
            (0.30, 0.92),
            (0.0, 0.86),
        ],
        5,
    );
    lathe(&profile, 128).bent(|p| {
        let r = p.x.hypot(p.z);
        let brim = ((r - 0.8) / 1.1).clamp(0.0, 1.0);
        let up = 0.42 * brim * brim * (p.x / r.max(1e-3)).powi(2);
        let pinch = 0.16 * (-(p.x / 0.16).powi(2)).exp() * ((p.y - 0.5) / 0.45).clamp(0.0, 1.0);
        let plait = 0.012 * (TAU * (r + 0.6 * p.y) / 0.11).sin();
        vec3(p.x, p.y + up - pinch + plait * brim.min(1.0), p.z)
    })
}

fn band() -> Form {
    let outline = Profile::closed(&[
        (0.83, 0.10, 0.015),
        (0.875, 0.10, 0.015),
        (0.835, 0.30, 0.015),
        (0.79, 0.30, 0.015),
    ]);
    lathe(&outline, 96)
}

/// A moustache of tapering locks, and a pair of eyes above it.
pub(super) fn put_moustache(stage: &mut Stage, node: NodeId, origin: DVec3) {
    let hair = stage.material("moustache", 0x2a1c14, 0.7, 0.0);
    let at = LIP.as_dvec3() - origin;
    let lip = stage.joint("lip", Some(node), placed(at, DQuat::IDENTITY, 1.0));
    let lag = late(2.1, 0.12);
    for (name, side) in [("left moustache", -1.0f32), ("right moustache", 1.0)] {
        let flap = |t: f64| f64::from(side) * 2.6 * (lag[1].at(t) - lean(t)[1]);
        let root = stage.joint(name, Some(lip), placed(DVec3::ZERO, DQuat::IDENTITY, 1.0));
        stage.animate(root, turning(|t| DQuat::from_rotation_z(flap(t))));
        let form = Form::joined((0..11).map(|k| lock(side, k)));
        stage.thing(name, Some(root), Default::default(), (form, hair));
    }
    let white = stage.material("eye white", 0xf4efe2, 0.2, 0.0);
    let black = stage.material("pupil", 0x0d0c0b, 0.2, 0.0);
    for side in [-1.0, 1.0] {
        let eye = vec3(0.30 * side, 0.46, -0.02);
        let ball_form = ball(12).scaled(0.17, 0.21, 0.12).at(eye.x, eye.y, eye.z);
        let pupil = ball(8).scaled(0.075, 0.09, 0.05).at(eye.x + 0.05, eye.y - 0.02, eye.z + 0.085);
        stage.thing("eye", Some(lip), Default::default(), (ball_form, white));
        stage.thing("pupil", Some(lip), Default::default(), (pupil, black));
    }
}

/// One lock, from the middle outwards, down and up again.
fn lock(side: f32, k: u64) -> Form {
    let j =
        |seed: u64, reach: f32| between(seed, k + if side > 0.0 { 50 } else { 0 }, -reach, reach);
    let row = k as f32 / 10.0;
    let through = [
        vec3(0.02, 0.02 - 0.10 * row, 0.10),
        vec3(0.22, 0.06 - 0.22 * row, 0.17 + j(111, 0.02)),
        vec3(0.52 + j(112, 0.02), -0.04 - 0.24 * row, 0.10 + j(113, 0.03)),
        vec3(0.82 + j(114, 0.05) - 0.10 * row, -0.10 - 0.16 * row, -0.06),
        vec3(1.06 + j(115, 0.06) - 0.26 * row, 0.10 - 0.20 * row + j(116, 0.04), -0.14),
    ];
    let points = curve(&through.map(|p| p * vec3(side, 1.0, 1.0)), 28);
    tube(&points, 12, |t| 0.012 + 0.062 * (PI * (0.12 + 0.88 * t)).sin().max(0.0))
}

/// A flower of two rings of petals on top of the left arm.
pub(super) fn put_flower(stage: &mut Stage, node: NodeId, origin: DVec3) {
    let pink = stage.material("petals", 0xd7527f, 0.6, 0.0);
    let yellow = stage.material("stamens", 0xe7bf3c, 0.7, 0.0);
    let at = dvec3(-1.885, 4.56, 0.145) - origin;
    let lag = late(1.9, 0.15);
    let flower = stage.joint("flower", Some(node), placed(at, DQuat::IDENTITY, 1.0));
    let nod =
        |t: f64| [2.0 * (lag[0].at(t) - lean(t)[0]), 2.0 * (lag[1].at(t) - lean(t)[1]) + 0.25];
    stage.animate(flower, turning(|t| bend(nod(t))));
    let ring = |count: usize, tilt: f32, length: f32, shift: f32| {
        Form::joined((0..count).map(move |k| {
            let turn = 360.0 * (k as f32 + shift) / count as f32;
            petal(1.5 * length).at(0.03, 0.0, 0.0).turned_z(tilt).turned_y(turn)
        }))
    };
    let petals = ring(11, 22.0, 0.52, 0.0).with(ring(9, 50.0, 0.42, 0.5));
    stage.thing("petals", Some(flower), Default::default(), (petals, pink));
    let stamen = |k: u64| {
        let a = 2.4 * k as f32;
        let out = 0.03 * (k as f32).sqrt();
        let (s, c) = a.sin_cos();
        let top = vec3(1.5 * out * c, 0.30 + 0.03 * (k % 3) as f32, 1.5 * out * s);
        let points = [vec3(out * c, 0.0, out * s), vec3(out * c, 0.15, out * s), top];
        tube(&points, 6, |t| 0.010 + 0.018 * t * t)
    };
    stage.thing(
        "stamens",
        Some(flower),
        Default::default(),
        (Form::joined((1..28).map(stamen)), yellow),
    );
}

/// A petal from the origin along x: thin, closed, hollowed, with a pointed tip.
fn petal(length: f32) -> Form {
    let points: Vec<Vec3> = (0..=14)
        .map(|k| {
            let t = k as f32 / 14.0;
            vec3(length * t, 0.16 * length * (PI * t).sin(), 0.0)
        })
        .collect();
    let list = stations(&points, Vec3::Z);
    let ring = |k: usize| {
        let t = k as f32 / 14.0;
        let half = 0.30 * length * (PI * (0.06 + 0.90 * t)).sin().powf(0.8);
        let spoke = |i: usize| {
            let (s, c) = (TAU * i as f32 / 16.0).sin_cos();
            let x = half * c;
            list[k].across(x, -0.012 * s + 0.5 * x * x / half.max(0.02))
        };
        (0..16).map(spoke).collect::<Vec<_>>()
    };
    let mut rings = vec![vec![points[0]]];
    rings.extend((0..=14).map(ring));
    rings.push(vec![points[14]]);
    let join = super::super::shape::Join { around: true, along: false };
    super::super::shape::loft(&rings, join).outward()
}
