//! A portrait bust: the head, carved eyes, brows, locks of hair, earrings, a socle.
//!
//! Head and hair are implicit shapes (one decimetre a unit, the face towards +z, the chin at y = 0),
//! polygonised finely where the features are. The bust turns on its socle; the eyes lead, the
//! earrings swing after.

mod ear;
mod eye;
mod face;
mod hair;

use super::motion::{follow, turning};
use super::shape::{Form, Profile, isosurface, lathe, polished};
use super::stage::{Stage, moved, placed};
use crate::{Bounds, NodeId, Projection, Scene};
use chiaro_basis::math::{DQuat, Vec3, dvec3, vec3};
use std::f64::consts::TAU;

/// The bust on its socle.
pub(super) fn head() -> Scene {
    let mut stage = Stage::default();
    let skin = stage.material("skin", 0xd9a98a, 0.6, 0.0);
    let dark = stage.material("hair", 0x3d2619, 0.5, 0.0);
    let marble = stage.material("marble", 0xb9b4aa, 0.3, 0.0);
    let gold = stage.material("gold", 0xd8a83a, 0.25, 1.0);
    let yaw = |t: f64| 0.30 * (TAU * t).sin();
    stage.thing("socle", None, moved(0.0, 0.0, -0.28), (socle(), marble));
    let bust = stage.joint("bust", None, moved(0.0, 0.0, 0.0));
    stage.animate(bust, turning(|t| DQuat::from_rotation_y(yaw(t))));
    stage.thing("head", Some(bust), moved(0.0, 0.0, 0.0), (bust_form(), skin));
    stage.thing("hair", Some(bust), moved(0.0, 0.0, 0.0), (hair_form(), dark));
    stage.thing("brows", Some(bust), moved(0.0, 0.0, 0.0), (brow_forms(), dark));
    eye::put_eyes(&mut stage, bust, yaw);
    put_earrings(&mut stage, bust, gold, yaw);
    let projection = Projection::Perspective { fov_y: 24f32.to_radians() };
    stage.camera(vec3(3.9, 1.37, 7.9), vec3(0.02, 0.54, -0.1), projection, 0.8);
    stage.finish()
}

/// Skin: features finer than shoulders, eyelids finest.
fn bust_form() -> Form {
    const CELL: f32 = 0.06;
    let bounds = Bounds { min: vec3(-1.5, -1.95, -1.35), max: vec3(1.5, 2.5, 1.35) };
    let bust = face::Bust::new();
    let field = |p: Vec3| bust.at(p);
    let mut form = isosurface(bounds, CELL, &field);
    for (zone, longest) in [(FEATURES, 0.036), (FEATURES, 0.030), (FINE, 0.019), (FINEST, 0.012)] {
        let inside =
            |p: Vec3| zone.iter().any(|(c, r)| vec3(p.x.abs(), p.y, p.z).distance(*c) < *r);
        form = form.refined(|p| if inside(p) { longest } else { f32::INFINITY });
        form = polished(form, &field, 0.3 * longest, 2, inside);
    }
    form.with_gradient_normals(&field, 0.004)
}

/// Spheres round what needs fine triangles, on the left side: eye, nose, mouth and ear.
const FEATURES: &[(Vec3, f32)] = &[
    (Vec3::new(0.30, 1.13, 0.76), 0.28),
    (Vec3::new(0.0, 0.85, 0.90), 0.28),
    (Vec3::new(0.05, 0.50, 0.80), 0.28),
    (Vec3::new(0.76, 0.99, -0.14), 0.38),
];
/// Spheres round what needs fine triangles, and the finest.
const FINE: &[(Vec3, f32)] = &[
    (Vec3::new(0.30, 1.13, 0.72), 0.22),
    (Vec3::new(0.0, 0.50, 0.85), 0.20),
    (Vec3::new(0.13, 0.50, 0.78), 0.14),
    (Vec3::new(0.06, 0.76, 0.92), 0.11),
];
const FINEST: &[(Vec3, f32)] = &[(Vec3::new(0.30, 1.125, 0.72), 0.20)];

fn hair_form() -> Form {
    const CELL: f32 = 0.056;
    let bounds = Bounds { min: vec3(-1.1, 0.3, -1.7), max: vec3(1.1, 2.6, 0.9) };
    let hair = hair::Hair::new();
    isosurface(bounds, CELL, &|p| hair.at(p))
}

fn brow_forms() -> Form {
    let bounds = Bounds { min: vec3(0.03, 1.2, 0.4), max: vec3(0.75, 1.6, 1.1) };
    let bust = face::Bust::new();
    let left = isosurface(bounds, 0.025, &|p| face::brow(&bust, p));
    left.clone().with(left.scaled(-1.0, 1.0, 1.0))
}

/// A turned foot beneath the bust.
fn socle() -> Form {
    let outline = Profile::open(&[
        (0.0, -2.75, 0.0),
        (0.78, -2.75, 0.02),
        (0.78, -2.58, 0.02),
        (0.70, -2.56, 0.01),
        (0.68, -2.46, 0.06),
        (0.36, -2.36, 0.14),
        (0.30, -2.0, 0.2),
        (0.40, -1.84, 0.06),
        (0.48, -1.80, 0.02),
        (0.48, -1.72, 0.02),
        (0.0, -1.70, 0.0),
    ]);
    lathe(&outline.refined(0.06), 96)
}

/// Pendants below the lobes that swing after the head.
fn put_earrings(
    stage: &mut Stage,
    bust: NodeId,
    gold: crate::MaterialId,
    yaw: impl Fn(f64) -> f64,
) {
    let swing = follow(&yaw, 1.1, 0.18);
    let drop = Profile::curve(
        &[
            (0.0, -0.34),
            (0.075, -0.27),
            (0.05, -0.15),
            (0.018, -0.06),
            (0.028, -0.02),
            (0.0, 0.015),
        ],
        6,
    );
    let mesh = stage.mesh("earring", [(lathe(&drop, 32), gold)]);
    for (name, sign) in [("left earring", 1.0), ("right earring", -1.0)] {
        let at = ear::LOBE.as_dvec3() * dvec3(sign, 1.0, 1.0);
        let node = stage.show(name, Some(bust), placed(at, DQuat::IDENTITY, 1.0), mesh);
        let lag = |t: f64| 1.2 * (swing.at(t) - yaw(t));
        stage.animate(node, turning(|t| DQuat::from_rotation_x(-sign * lag(t))));
    }
}
