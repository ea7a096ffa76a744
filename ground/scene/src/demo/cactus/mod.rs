//! The cactus: ribbed body and arms with spines, hat, moustache and flower, in a pot.
//!
//! Limbs are closed ribbed tubes whose roots are buried in one another, bent by one rig together
//! with every spine, which moves as the place it grows from. The cactus sways; arms, hat and
//! moustache lag behind. One unit is a decimetre, the soil is at y = 0.

mod dress;
mod limb;
mod pot;

use super::motion::{Signal, follow, turning};
use super::rig::Rig;
use super::stage::{Stage, mesh};
use crate::{Node, NodeId, Projection, Scene};
use chiaro_basis::math::{DQuat, Vec3, vec3};
use limb::Limb;
use std::f64::consts::TAU;

/// A place on a limb with its radius.
type Joint = (Vec3, f32);

/// The bones of the body, from the soil up.
const BODY: [Joint; 6] = [
    (Vec3::new(0.0, -0.3, 0.0), 0.80),
    (Vec3::new(0.0, 0.9, 0.0), 0.86),
    (Vec3::new(0.02, 2.1, 0.0), 0.90),
    (Vec3::new(0.04, 3.3, 0.0), 0.88),
    (Vec3::new(0.04, 4.4, 0.0), 0.84),
    (Vec3::new(0.03, 5.35, 0.0), 0.80),
];
/// The arms: on the left and high, on the right and lower.
const LEFT: [Joint; 6] = [
    (Vec3::new(-0.45, 2.15, 0.05), 0.34),
    (Vec3::new(-1.15, 2.10, 0.12), 0.37),
    (Vec3::new(-1.68, 2.35, 0.18), 0.40),
    (Vec3::new(-1.92, 2.95, 0.20), 0.41),
    (Vec3::new(-1.95, 3.65, 0.18), 0.40),
    (Vec3::new(-1.90, 4.25, 0.15), 0.38),
];
const RIGHT: [Joint; 5] = [
    (Vec3::new(0.45, 1.50, 0.10), 0.30),
    (Vec3::new(1.10, 1.42, 0.20), 0.33),
    (Vec3::new(1.55, 1.70, 0.28), 0.35),
    (Vec3::new(1.72, 2.25, 0.30), 0.35),
    (Vec3::new(1.72, 2.80, 0.28), 0.33),
];

/// The cactus in its pot.
pub(super) fn cactus() -> Scene {
    let mut stage = Stage::default();
    pot::put(&mut stage);
    let green = stage.material("cactus", 0x5d8a52, 0.6, 0.0);
    let wool = stage.material("areoles", 0xd9d0b4, 0.9, 0.0);
    let thorn = stage.material("spines", 0xe9dcae, 0.5, 0.0);
    let mut rig = Rig::new(0.7);
    let body = rig.limb("body", None, &BODY);
    let left = rig.limb("left arm", Some(body[1]), &LEFT);
    let right = rig.limb("right arm", Some(body[1]), &RIGHT);
    let limbs = [
        Limb { joints: &BODY, ribs: 15, depth: 0.11, areoles: 11, seed: 1 },
        Limb { joints: &LEFT, ribs: 10, depth: 0.12, areoles: 10, seed: 2 },
        Limb { joints: &RIGHT, ribs: 10, depth: 0.12, areoles: 8, seed: 3 },
    ];
    let mut skin = mesh("cactus", limbs.iter().map(|l| (l.skin(), green)));
    let bones = rig.put(&mut stage, None);
    // None grows under the hat.
    let bare = |t: &limb::Tuft| t.root.y > 5.0 && t.root.x.abs() < 1.0;
    let tufts: Vec<_> = limbs.iter().flat_map(Limb::tufts).filter(|t| !bare(t)).collect();
    let pieces = tufts.iter().flat_map(|t| [(t.wool(), wool), (t.spines(), thorn)]);
    let mut spines = mesh("spines", pieces);
    // All of a tuft moves as its root.
    let count = |t: &limb::Tuft| t.wool().positions.len() + t.spines().positions.len();
    let anchors: Vec<Vec3> = tufts.iter().flat_map(|t| vec![t.root; count(t)]).collect();
    skin.influences = rig.influences(skin.positions.iter().copied());
    spines.influences = rig.influences(anchors);
    for (name, mesh) in [("cactus", skin), ("spines", spines)] {
        let mesh = Some(stage.push_mesh(mesh));
        let (name, skin) = (name.into(), Some(bones.skin));
        stage.push_node(Node { name, mesh, skin, ..Node::default() });
    }
    sway(&mut stage, &bones.nodes, [&body, &left, &right]);
    let face = bones.nodes[body[3]];
    dress::put_moustache(&mut stage, face, rig.origin(body[3]));
    dress::put_hat(&mut stage, bones.nodes[body[4]], rig.origin(body[4]));
    dress::put_flower(&mut stage, bones.nodes[left[4]], rig.origin(left[4]));
    let projection = Projection::Perspective { fov_y: 26f32.to_radians() };
    stage.camera(vec3(5.6, 5.8, 20.6), vec3(-0.05, 1.82, 0.0), projection, 0.8);
    stage.finish()
}

/// How far the body leans to its left and to the front, per bone.
fn lean(t: f64) -> [f64; 2] {
    [0.055 * (TAU * t).sin(), 0.030 * (TAU * (2.0 * t + 0.1)).sin()]
}

/// The same at a phase, late as a spring of some frequency.
fn late(frequency: f64, damping: f64) -> [Signal; 2] {
    [0, 1].map(|k| follow(|t| lean(t)[k], frequency, damping))
}

fn bend([side, front]: [f64; 2]) -> DQuat {
    DQuat::from_rotation_z(side) * DQuat::from_rotation_x(front)
}

/// Body bones lean one after the other; arms swing with what they lag.
fn sway(stage: &mut Stage, nodes: &[NodeId], [body, left, right]: [&[usize]; 3]) {
    for (k, &bone) in body.iter().enumerate() {
        let wait = 0.025 * k as f64;
        stage.animate(nodes[bone], turning(|t| bend(lean(t - wait))));
    }
    for (arm, frequency, side) in [(left, 1.1, 1.0), (right, 1.4, -1.0)] {
        let lag = late(frequency, 0.18);
        for (k, &bone) in arm.iter().enumerate() {
            let wait = 0.03 * k as f64;
            let swing = |t: f64| {
                let t = t - wait;
                let now = lean(t);
                let wave = 0.045 * (TAU * (t + 0.2)).sin() * side;
                [1.5 * (lag[0].at(t) - now[0]) + wave, 1.4 * (lag[1].at(t) - now[1])]
            };
            stage.animate(nodes[bone], turning(|t| bend(swing(t))));
        }
    }
}
