//! Newton's cradle: five balls on threads, the outer ones swinging in turn.

use super::super::motion::turning;
use super::super::shape::{Form, ball, block, tube};
use super::super::stage::{Stage, moved, placed};
use chiaro_basis::math::{DQuat, Vec3, vec3};
use std::f64::consts::TAU;

/// The balls' radius, and how far they hang below the rails.
const RADIUS: f32 = 0.24;
const HANG: f32 = 1.45;
/// The rails' height and half distance.
const RAIL: Vec3 = Vec3::new(1.05, 1.92, 0.55);

/// The toy at `at`, its row along x.
pub(super) fn put(stage: &mut Stage, at: Vec3) {
    let steel = stage.material("polished steel", 0xd5d7da, 0.15, 1.0);
    let frame = stage.material("chrome", 0xb9bcc0, 0.2, 1.0);
    let base_paint = stage.material("ebony", 0x2b2422, 0.35, 0.0);
    let node =
        stage.joint("cradle", None, placed(at.as_dvec3(), DQuat::from_rotation_y(0.35), 1.0));
    let base = block(vec3(2.5, 0.16, 1.5), 0.05, 4).at(0.0, 0.08, 0.0);
    stage.thing("cradle base", Some(node), Default::default(), (base, base_paint));
    stage.thing("cradle frame", Some(node), Default::default(), (rails(), frame));
    let mesh = stage.mesh("hung ball", [(hung(), steel)]);
    for k in 0..5 {
        let x = 2.0 * RADIUS * (k as f32 - 2.0);
        let hinge = moved(f64::from(x), f64::from(RAIL.y), 0.0);
        let ball = stage.show("hung ball", Some(node), hinge, mesh);
        // One outer ball flies through each half of the swing; the others barely stir.
        let share = |t: f64| match k {
            0 => (TAU * t).sin().min(0.0),
            4 => (TAU * t).sin().max(0.0),
            _ => 0.03 * (TAU * t).sin(),
        };
        stage.animate(ball, turning(|t| DQuat::from_rotation_z(0.55 * share(t))));
    }
}

/// Two bent rods from the base up and across.
fn rails() -> Form {
    const BEND: f32 = 0.3;
    let (x, y) = (RAIL.x, RAIL.y);
    let rod = |z: f32| {
        let post = (0..12).map(|k| vec3(-x, 0.1 + (y - BEND - 0.1) * k as f32 / 12.0, z));
        let bend = (0..10).map(|k| {
            let (s, c) = (0.1 * std::f32::consts::FRAC_PI_2 * k as f32).sin_cos();
            vec3(BEND - x - BEND * c, y - BEND + BEND * s, z)
        });
        let half: Vec<Vec3> = post.chain(bend).chain([vec3(BEND - x, y, z)]).collect();
        let other = half.iter().rev().map(|p| *p * vec3(-1.0, 1.0, 1.0));
        let across = (1..12).map(|k| vec3((BEND - x) * (1.0 - k as f32 / 6.0), y, z));
        let points: Vec<Vec3> = half.iter().copied().chain(across).chain(other).collect();
        tube(&points, 14, |_| 0.045)
    };
    rod(RAIL.z).with(rod(-RAIL.z))
}

/// A ball with its two threads, hung from the origin.
fn hung() -> Form {
    let middle = vec3(0.0, -HANG, 0.0);
    let thread = |z: f32| {
        let top = vec3(0.0, 0.0, z);
        let low = middle + 0.8 * RADIUS * (top - middle).normalize();
        tube(&[top, top.lerp(low, 0.5), low], 6, |_| 0.012)
    };
    let eye = ball(6).scaled(0.05, 0.05, 0.05).at(0.0, RADIUS - HANG, 0.0);
    ball(12)
        .scaled(RADIUS, RADIUS, RADIUS)
        .moved(chiaro_basis::math::Affine3A::from_translation(middle))
        .with(thread(RAIL.z))
        .with(thread(-RAIL.z))
        .with(eye)
}
