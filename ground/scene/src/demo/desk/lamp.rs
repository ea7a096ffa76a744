//! The lamp: a heavy foot, two arms of paired rods with springs, and a shade on a ball joint.

use super::super::motion::{follow, turning};
use super::super::shape::{Form, Profile, ball, block, lathe, tube};
use super::super::stage::{Stage, facing, placed};
use crate::{LightKind, Material, NodeId};
use chiaro_basis::math::{DQuat, DVec3, Vec3, dvec3, vec3};
use std::f64::consts::TAU;

/// The lengths of the arms.
const LOWER: f32 = 3.4;
const UPPER: f32 = 3.3;

/// The lamp with its foot at `at`, reaching to the right and the front.
pub(super) fn put(stage: &mut Stage, at: Vec3) {
    let paint = stage.material("lamp paint", 0x2f5d50, 0.35, 0.0);
    let steel = stage.material("steel", 0xb4b6b8, 0.3, 1.0);
    let bulb = stage.push_material(Material {
        name: "bulb".into(),
        base_colour: [0.9, 0.9, 0.9, 1.0],
        // Seen to shine; the light below lights.
        emissive: [2.0, 1.7, 1.2],
        double_sided: false,
        ..Material::default()
    });
    let yaw = DQuat::from_rotation_y(-0.42);
    let base = stage.joint("lamp", None, placed(at.as_dvec3(), yaw, 1.0));
    stage.thing("lamp foot", Some(base), Default::default(), (foot(), paint));
    stage.thing("cable", Some(base), Default::default(), (cable(), paint));
    let sway = |t: f64| (TAU * t).sin();
    let lower = joint(stage, "lower arm", base, dvec3(0.0, 0.42, 0.0), |t| 0.20 + 0.05 * sway(t));
    let upper = joint(stage, "upper arm", lower, dvec3(0.0, f64::from(LOWER), 0.0), |t| {
        -1.46 - 0.09 * sway(t + 0.08)
    });
    let late = follow(|t| 0.05 * sway(t) - 0.09 * sway(t + 0.08), 1.7, 0.12);
    let shade = joint(stage, "shade", upper, dvec3(0.0, f64::from(UPPER), 0.0), |t| {
        -1.38 - 1.6 * late.at(t)
    });
    for (node, length) in [(lower, LOWER), (upper, UPPER)] {
        stage.thing("rods", Some(node), Default::default(), (rods(length), steel));
        stage.thing("hinges", Some(node), Default::default(), (hinges(length), paint));
        stage.thing("springs", Some(node), Default::default(), (springs(length), steel));
    }
    stage.thing("shade", Some(shade), Default::default(), (bell(), paint));
    stage.thing("bulb", Some(shade), Default::default(), (bulb_form(), bulb));
    let toward = facing(vec3(0.0, 1.42, 0.0), vec3(0.0, 3.0, 0.01));
    let light = stage.joint("light", Some(shade), toward);
    let cone = LightKind::Spot { inner: 0.5, outer: 1.0 };
    stage.lamp(light, cone, [1.0, 0.84, 0.62], 42.0);
}

/// A hinge that turns about z.
fn joint(
    stage: &mut Stage,
    name: &str,
    parent: NodeId,
    at: DVec3,
    angle: impl Fn(f64) -> f64,
) -> NodeId {
    let node = stage.joint(name, Some(parent), placed(at, DQuat::IDENTITY, 1.0));
    stage.animate(node, turning(|t| DQuat::from_rotation_z(angle(t))));
    node
}

fn foot() -> Form {
    let outline = Profile::open(&[
        (0.0, 0.0, 0.0),
        (1.02, 0.0, 0.03),
        (1.02, 0.12, 0.05),
        (0.86, 0.22, 0.08),
        (0.22, 0.27, 0.06),
        (0.15, 0.44, 0.05),
        (0.0, 0.46, 0.0),
    ]);
    lathe(&outline.refined(0.2), 56)
}

/// Over the back edge of the desk.
fn cable() -> Form {
    let through = [
        vec3(-0.92, 0.08, -0.1),
        vec3(-1.25, 0.06, -0.35),
        vec3(-1.3, 0.06, -0.9),
        vec3(-1.0, 0.05, -1.4),
        vec3(-1.1, -0.2, -1.86),
        vec3(-1.05, -1.6, -1.75),
    ];
    tube(&super::super::shape::curve(&through, 40), 10, |_| 0.045)
}

/// Two parallel rods up from the pivot.
fn rods(length: f32) -> Form {
    let rod = |z: f32| {
        let points: Vec<Vec3> = (0..=6).map(|k| vec3(0.0, length * k as f32 / 6.0, z)).collect();
        tube(&points, 14, |_| 0.05)
    };
    rod(0.13).with(rod(-0.13))
}

/// Discs at the ends of an arm.
fn hinges(length: f32) -> Form {
    let disc = Profile::open(&[
        (0.0, -0.24, 0.0),
        (0.10, -0.24, 0.02),
        (0.11, -0.19, 0.02),
        (0.19, -0.19, 0.03),
        (0.19, 0.19, 0.03),
        (0.11, 0.19, 0.02),
        (0.10, 0.24, 0.02),
        (0.0, 0.24, 0.0),
    ]);
    let disc = lathe(&disc, 24).turned_x(90.0);
    let brace = block(vec3(0.09, 0.22, 0.34), 0.03, 2).at(0.0, 0.72, 0.0);
    disc.clone().with(disc.at(0.0, length, 0.0)).with(brace)
}

/// Two springs beside the rods.
fn springs(length: f32) -> Form {
    const TURNS: f32 = 17.0;
    let coil = |z: f32| {
        let point = |k: i32| {
            let t = k as f32 / 204.0;
            let (s, c) = (std::f32::consts::TAU * TURNS * t).sin_cos();
            let wide = 0.062 * (12.0 * t.min(1.0 - t)).min(1.0);
            vec3(-0.13 + wide * c, 0.72 + (0.52 * length) * t, z + wide * s)
        };
        tube(&(0..=204).map(point).collect::<Vec<_>>(), 6, |_| 0.014)
    };
    let stay = |z: f32| {
        tube(&[vec3(-0.13, 0.7, z), vec3(-0.06, 0.71, z), vec3(0.0, 0.72, z)], 8, |_| 0.03)
    };
    let tie = |z: f32| {
        let y = 0.72 + 0.52 * length;
        let through = [vec3(-0.13, y, z), vec3(-0.13, 0.8 * length, z), vec3(0.0, 0.9 * length, z)];
        tube(&through, 8, |_| 0.016)
    };
    let one = |z: f32| coil(z).with(stay(z)).with(tie(z));
    one(0.13).with(one(-0.13))
}

/// The shade opens along +y.
fn bell() -> Form {
    let outline = Profile::open(&[
        (0.0, -0.16, 0.0),
        (0.20, -0.16, 0.05),
        (0.27, -0.02, 0.03),
        (0.29, 0.42, 0.05),
        (0.40, 0.60, 0.10),
        (0.62, 0.86, 0.12),
        (0.98, 1.46, 0.05),
        (1.04, 1.50, 0.02),
        (1.04, 1.56, 0.02),
        (0.96, 1.54, 0.03),
        (0.58, 0.90, 0.12),
        (0.34, 0.62, 0.10),
        (0.0, 0.58, 0.0),
    ]);
    let rib = |y: f32| {
        let ring = Profile::circle(0.026, 10);
        let moved = ring.points.iter().map(|(p, n)| (*p + chiaro_basis::math::vec2(0.285, y), *n));
        lathe(&Profile { points: moved.collect(), closed: true }, 44)
    };
    lathe(&outline.refined(0.14), 84).with(rib(0.12)).with(rib(0.24)).with(rib(0.36))
}

fn bulb_form() -> Form {
    let glass = ball(12).scaled(0.30, 0.33, 0.30).at(0.0, 1.02, 0.0);
    let neck =
        Profile::open(&[(0.0, 0.5, 0.0), (0.17, 0.5, 0.02), (0.17, 0.8, 0.06), (0.0, 0.84, 0.0)]);
    glass.with(lathe(&neck, 32))
}
