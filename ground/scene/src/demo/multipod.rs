//! The multipod: a creature of one smooth skin that walks in place on six legs, its eyes on stalks,
//! its tail held high.
//!
//! The skin is an implicit shape, polygonised once at rest and bent by bones, so that vertices and
//! triangles are the same at every time while limbs pass before one another. Legs reach for their
//! footholds; stalks and tail lag behind the body. One unit is the body's half length.

use super::motion::{follow, moving, turning};
use super::rig::{Rig, arc, knee};
use super::shape::field::{carve, ellipsoid, merge};
use super::shape::{Bundle, Form, isosurface, polished, strand};
use super::stage::{Stage, mesh};
use crate::{Bounds, Node, Projection, Scene};
use chiaro_basis::math::{DQuat, DVec3, Quat, Vec3, dvec3, vec3};
use std::f64::consts::TAU;

/// A point with the radius of the limb there.
type Joint = (Vec3, f32);

/// The middle of the body at rest.
const BODY: Vec3 = Vec3::new(0.0, 1.34, 0.0);
/// The middle of the left eye at rest, and its radius.
const EYE: Joint = (Vec3::new(1.22, 2.20, 0.34), 0.165);
/// Where the eyes look at rest.
const GAZE: Vec3 = Vec3::new(0.80, 0.14, 0.50);

/// A leg at rest, ready to walk.
struct Leg {
    /// Hip, knee, ankle and the tips of its toes.
    hip: Joint,
    knee: Joint,
    ankle: Joint,
    toes: [Joint; 3],
    /// When in the walk it lifts.
    phase: f64,
}

/// The walking creature.
pub(super) fn multipod() -> Scene {
    let mut stage = Stage::default();
    let hide = stage.material("hide", 0xc98f5a, 0.55, 0.0);
    let legs = legs();
    let mut rig = Rig::new(0.34);
    let trunk = [(BODY - 0.42 * Vec3::X, 0.52), (BODY + 0.40 * Vec3::X, 0.50)];
    let body = rig.bone("body", None, trunk);
    let limbs: Vec<Vec<usize>> = legs
        .iter()
        .map(|l| {
            let toe = l.toes[0];
            let sole = (vec3(toe.0.x, 0.02, toe.0.z), 0.12);
            rig.limb("leg", Some(body), &[l.hip, l.knee, l.ankle, sole])
        })
        .collect();
    let stalks = [1.0, -1.0].map(|side| rig.limb("stalk", Some(body), &stalk(side)));
    let tail = rig.limb("tail", Some(body), &tail());
    let form = form(&legs);
    let bones = rig.put(&mut stage, None);
    let mut skin = mesh("multipod", [(form, hide)]);
    skin.influences = rig.influences(skin.positions.iter().copied());
    let skin = stage.push_mesh(skin);
    let name = "multipod".into();
    stage.push_node(Node { name, mesh: Some(skin), skin: Some(bones.skin), ..Node::default() });

    let turn = |t: f64| {
        let wave = |times: f64, shift: f64| (TAU * (times * t + shift)).sin();
        DQuat::from_rotation_y(0.07 * wave(1.0, 0.1))
            * DQuat::from_rotation_z(0.035 * wave(2.0, 0.0))
            * DQuat::from_rotation_x(0.06 * wave(1.0, 0.35))
    };
    let rise =
        |t: f64| dvec3(0.03 * (2.0 * TAU * t).cos(), 0.055 * (2.0 * TAU * (t + 0.06)).sin(), 0.0);
    let origin = rig.origin(body);
    stage.animate(bones.nodes[body], turning(turn));
    stage.animate(bones.nodes[body], moving(|t| origin + rise(t)));
    for (leg, limb) in legs.iter().zip(&limbs) {
        let pose = |t: f64| leg.pose(t, origin, turn(t), rise(t));
        stage.animate(bones.nodes[limb[0]], turning(|t| turn(t).inverse() * pose(t)[0]));
        stage.animate(bones.nodes[limb[1]], turning(|t| pose(t)[0].inverse() * pose(t)[1]));
        stage.animate(bones.nodes[limb[2]], turning(|t| pose(t)[1].inverse() * pose(t)[2]));
    }
    let sway = |t: f64| turn(t).to_scaled_axis();
    for (k, chain) in stalks.iter().chain([&tail]).enumerate() {
        let (frequency, gain) = if k == 2 { (0.8, 0.5) } else { (1.4, 0.55) };
        let nod = follow(|t| 2.2 * rise(t).y + sway(t).z, frequency, 0.16);
        let swing = follow(|t| sway(t).y - sway(t).x, frequency, 0.2);
        for (i, &bone) in chain.iter().enumerate() {
            let late = 0.03 * i as f64;
            let bend = |t: f64| {
                DQuat::from_rotation_z(gain * nod.at(t - late))
                    * DQuat::from_rotation_y(gain * swing.at(t - late))
            };
            stage.animate(bones.nodes[bone], turning(bend));
        }
    }
    let projection = Projection::Perspective { fov_y: 26f32.to_radians() };
    stage.camera(vec3(5.4, 3.4, 6.7), vec3(0.0, 1.08, 0.0), projection, 4.0 / 3.0);
    stage.finish()
}

impl Leg {
    /// World rotations of thigh, shin and foot at a phase, for a body at `origin` that is turned
    /// by `turn` and moved by `rise`.
    fn pose(&self, t: f64, origin: DVec3, turn: DQuat, rise: DVec3) -> [DQuat; 3] {
        let [hip, bend, ankle] = [self.hip, self.knee, self.ankle].map(|j| j.0.as_dvec3());
        let (step, tip) = self.step(t);
        let here = origin + rise + turn * (hip - origin);
        let there = ankle + step;
        let pole = bend - 0.5 * (hip + ankle);
        let at = knee(here, there, hip.distance(bend), bend.distance(ankle), pole);
        [arc(bend - hip, at - here), arc(ankle - bend, there - at), DQuat::from_rotation_z(tip)]
    }

    /// The ankle's way from its place at rest, and how far the toes hang: half of the time on the
    /// ground and backwards, half of it lifted and forwards.
    fn step(&self, t: f64) -> (DVec3, f64) {
        const STRIDE: f64 = 0.52;
        let u = (t + self.phase).rem_euclid(1.0);
        if u < 0.5 {
            return (dvec3(STRIDE * (0.5 - 2.0 * u), 0.0, 0.0), 0.0);
        }
        let s = 2.0 * u - 1.0;
        // Leaves and meets the ground at its speed.
        let ease = s * s * (3.0 - 2.0 * s) - s * (1.0 - s) * (1.0 - 2.0 * s);
        let lift = (0.5 * TAU * s).sin().powi(2);
        (dvec3(STRIDE * (ease - 0.5), 0.40 * lift, 0.0), -0.45 * (TAU * s).sin() * lift.sqrt())
    }
}

/// Three legs a side; neighbours lift at opposite times.
fn legs() -> Vec<Leg> {
    let leg = |k: usize| {
        let (row, side) = (k % 3, if k < 3 { 1.0 } else { -1.0 });
        // From hip to foot, seen from above.
        let out = [vec3(0.62, 0.0, 0.78), vec3(-0.06, 0.0, 1.0), vec3(-0.72, 0.0, 0.70)][row];
        let mirrored = |p: Vec3| vec3(p.x, p.y, side * p.z);
        let hip = BODY
            + [vec3(0.46, -0.12, 0.36), vec3(-0.02, -0.16, 0.46), vec3(-0.50, -0.12, 0.36)][row];
        let at = |away: f32, y: f32| vec3(hip.x, 0.0, hip.z) + out * away + Vec3::Y * y;
        let toe = |turn: f32| {
            let forward = Quat::from_rotation_y(turn) * out;
            (mirrored(at(1.16, 0.085) + forward * 0.25), 0.062)
        };
        Leg {
            hip: (mirrored(hip), 0.24),
            knee: (mirrored(at(0.66, 1.56)), 0.15),
            ankle: (mirrored(at(1.10, 0.20)), 0.105),
            toes: [0.0, 0.85, -0.85].map(toe),
            phase: if k.is_multiple_of(2) { 0.0 } else { 0.5 } + 0.04 * row as f64,
        }
    };
    (0..6).map(leg).collect()
}

/// An eye's stalk from the body up.
fn stalk(side: f32) -> [Joint; 4] {
    let row = [
        (vec3(0.66, 1.62, 0.17), 0.13),
        (vec3(0.92, 1.86, 0.24), 0.085),
        (vec3(1.08, 2.06, 0.30), 0.078),
        (EYE.0, EYE.1),
    ];
    row.map(|(p, r)| (vec3(p.x, p.y, side * p.z), r))
}

/// The tail from the body up to its tip.
fn tail() -> [Joint; 6] {
    [
        (vec3(-0.78, 1.48, 0.0), 0.27),
        (vec3(-1.16, 1.62, 0.0), 0.19),
        (vec3(-1.40, 1.92, 0.0), 0.145),
        (vec3(-1.38, 2.26, 0.0), 0.115),
        (vec3(-1.12, 2.44, 0.0), 0.10),
        (vec3(-0.90, 2.33, 0.0), 0.12),
    ]
}

/// The skin at rest.
fn form(legs: &[Leg]) -> Form {
    const CELL: f32 = 0.062;
    let field = |fine: &Skin, p: Vec3| fine.at(p);
    let skin = Skin::new(legs);
    let at = |p: Vec3| field(&skin, p);
    let bounds = Bounds { min: vec3(-2.3, -0.25, -2.3), max: vec3(2.3, 2.9, 2.3) };
    let form = isosurface(bounds, CELL, &at);
    let zones: Vec<Joint> = skin.fine.clone();
    let fine = |p: Vec3| zones.iter().any(|(c, r)| p.distance_squared(*c) < r * r);
    let form = form.refined(|p| if fine(p) { 0.026 } else { f32::INFINITY });
    polished(form, &at, 0.008, 3, fine).with_gradient_normals(&at, 0.004)
}

/// The skin as a field.
struct Skin {
    limbs: Bundle,
    ridge: Bundle,
    /// Balls round what needs fine triangles.
    fine: Vec<Joint>,
}

impl Skin {
    fn new(legs: &[Leg]) -> Self {
        let mut strands = Vec::new();
        let mut fine = Vec::new();
        for leg in legs {
            let sole = (leg.toes[0].0.with_y(0.10).lerp(leg.ankle.0.with_y(0.10), 0.75), 0.115);
            let bent = leg.hip.0.lerp(leg.knee.0, 0.55) + Vec3::Y * 0.10;
            let calf = leg.knee.0.lerp(leg.ankle.0, 0.42) * vec3(1.03, 1.0, 1.03);
            strands.push(strand(
                &[leg.hip, (bent, 0.165), leg.knee, (calf, 0.155), (leg.ankle.0, 0.085), sole],
                5,
            ));
            strands.extend(leg.toes.map(|toe| vec![(sole.0, 0.08), toe]));
            fine.push((sole.0, 0.42));
        }
        for side in [1.0, -1.0] {
            let row = stalk(side);
            strands.push(strand(&[row[0], row[1], row[2], (row[3].0, 0.07)], 5));
            strands.push(vec![row[3], (row[3].0 + 0.001 * Vec3::X, row[3].1)]);
            fine.push((row[3].0, 0.34));
        }
        strands.push(strand(&tail(), 6));
        // Knobs along the back and rings round the tail.
        let knob = |k: usize| {
            let x = 0.62 - 0.21 * k as f32;
            let y = BODY.y + 0.60 * (1.0 - (x / 1.10).powi(2)).max(0.0).sqrt();
            vec![(vec3(x, y - 0.02, 0.0), 0.075), (vec3(x - 0.03, y + 0.10, 0.0), 0.045)]
        };
        strands.extend((0..7).map(knob));
        let groove = |side: f32| {
            let row =
                [(0.86, 1.20, 0.30), (0.45, 1.02, 0.52), (-0.1, 1.0, 0.58), (-0.62, 1.10, 0.46)];
            strand(&row.map(|(x, y, z)| (vec3(x, y, side * z), 0.03)), 6)
        };
        Self {
            limbs: Bundle::new(&strands, 0.16),
            ridge: Bundle::new(&[groove(1.0), groove(-1.0)], 0.10),
            fine,
        }
    }

    fn at(&self, p: Vec3) -> f32 {
        let trunk = ellipsoid(p, BODY, vec3(1.08, 0.60, 0.68));
        let chest = ellipsoid(p, BODY + vec3(0.56, 0.10, 0.0), vec3(0.52, 0.50, 0.56));
        let d = merge(trunk, chest, 0.25);
        let d = -self.ridge.merged(p, -d);
        let d = self.limbs.merged(p, d);
        let eye = vec3(EYE.0.x, EYE.0.y, EYE.0.z * p.z.signum());
        let pupil = eye + GAZE.normalize() * (EYE.1 + 0.03);
        carve(d, p.distance(pupil) - 0.08, 0.02)
    }
}
