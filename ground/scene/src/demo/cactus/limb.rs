//! Ribbed limbs, and the tufts of spines along their ribs.

use super::super::shape::{Form, Join, Station, ball, between, curve, loft, stations};
use super::Joint;
use chiaro_basis::math::{Affine3A, Quat, Vec3, vec3};
use std::f32::consts::{FRAC_PI_2, TAU};

/// Rings along a unit of length.
const FINE: f32 = 11.0;
/// Points round a rib.
const ROUND: usize = 8;

/// A limb along joints, rounded at its end.
pub(super) struct Limb {
    pub(super) joints: &'static [Joint],
    pub(super) ribs: usize,
    /// The depth of furrows in parts of the radius.
    pub(super) depth: f32,
    /// Tufts along a rib.
    pub(super) areoles: usize,
    pub(super) seed: u64,
}

/// A woolly cushion with spines.
pub(super) struct Tuft {
    /// Where it sits.
    pub(super) root: Vec3,
    /// Outwards, and along the rib.
    out: Vec3,
    along: Vec3,
    size: f32,
    seed: u64,
}

impl Limb {
    /// Frames along the axis with the radius at each, evenly spaced, and the dome at the end.
    fn axis(&self) -> Vec<(Station, f32)> {
        let points: Vec<Vec3> = self.joints.iter().map(|j| j.0).collect();
        let length: f32 = points.windows(2).map(|w| w[0].distance(w[1])).sum();
        let count = (length * FINE) as usize;
        let radius = |t: f32| {
            let x = t * (self.joints.len() - 1) as f32;
            let i = (x as usize).min(self.joints.len() - 2);
            let s = x - i as f32;
            let s = s * s * (3.0 - 2.0 * s);
            self.joints[i].1 * (1.0 - s) + self.joints[i + 1].1 * s
        };
        let list = stations(&curve(&points, count), Vec3::Z);
        let of = |(k, s): (usize, Station)| (s, radius(k as f32 / count as f32));
        let mut axis: Vec<_> = list.into_iter().enumerate().map(of).collect();
        let (last, wide) = axis[axis.len() - 1];
        axis.extend((1..=9).map(|k| {
            let (up, out) = (FRAC_PI_2 * k as f32 / 9.0).sin_cos();
            (Station { at: last.at + last.along * (0.85 * wide * up), ..last }, wide * out)
        }));
        axis
    }

    /// The radius at an angle: rounded ribs, narrow furrows.
    fn rib(&self, angle: f32) -> f32 {
        let furrow = (0.5 * self.ribs as f32 * angle).cos().abs();
        1.0 - self.depth * (1.0 - furrow.powf(0.8))
    }

    /// The skin, closed.
    pub(super) fn skin(&self) -> Form {
        let axis = self.axis();
        let n = self.ribs * ROUND;
        let ring = |(s, r): &(Station, f32)| {
            let spoke = |i: usize| {
                let a = TAU * i as f32 / n as f32;
                let r = r * self.rib(a);
                s.across(r * a.cos(), r * a.sin())
            };
            (0..n).map(spoke).collect::<Vec<_>>()
        };
        let mut rings = vec![vec![axis[0].0.at]];
        let (tip, body) = axis.split_last().map_or((None, &axis[..]), |(t, b)| (Some(t), b));
        rings.extend(body.iter().map(ring));
        rings.extend(tip.map(|t| vec![t.0.at - t.0.along * (0.10 * self.joints[0].1)]));
        loft(&rings, Join { around: true, along: false }).outward()
    }

    /// The tufts along the crests, those near the root left out.
    pub(super) fn tufts(&self) -> Vec<Tuft> {
        let axis = self.axis();
        let first = axis.len() / 7;
        let place = |rib: usize, k: usize| {
            let seed = self.seed * 10_000 + (rib * 100 + k) as u64;
            let span = (axis.len() - 3 - first) as f32;
            let stagger = if rib.is_multiple_of(2) { 0.0 } else { 0.5 };
            let jitter = between(91, seed, -0.12, 0.12);
            let at =
                first as f32 + span * (k as f32 + stagger + jitter + 0.15) / self.areoles as f32;
            let i = (at.max(0.0) as usize).min(axis.len() - 3);
            let (s, r) = axis[i];
            let slope = (axis[i + 1].1 - r) / axis[i].0.at.distance(axis[i + 1].0.at).max(1e-4);
            let a = TAU * rib as f32 / self.ribs as f32;
            let side = s.across(a.cos(), a.sin()) - s.at;
            let along = (s.along + side * slope).normalize();
            let out = (side - s.along * slope).normalize();
            let size = (0.55 + 0.45 * (r / 0.4).min(1.0)) * between(92, seed, 0.85, 1.15);
            Tuft { root: s.at + side * (0.995 * r), out, along, size, seed }
        };
        (0..self.ribs).flat_map(|rib| (0..self.areoles).map(move |k| place(rib, k))).collect()
    }
}

impl Tuft {
    /// The cushion.
    pub(super) fn wool(&self) -> Form {
        let turn = Quat::from_rotation_arc(Vec3::Y, self.out);
        let flat = Affine3A::from_scale(vec3(0.05, 0.028, 0.05) * self.size);
        ball(1).moved(Affine3A::from_rotation_translation(turn, self.root) * flat)
    }

    /// A star of five spines and a longer one in its middle.
    pub(super) fn spines(&self) -> Form {
        let across = self.out.cross(self.along).normalize_or(self.out.any_orthonormal_vector());
        let spine = |k: usize| {
            let seed = self.seed * 8 + k as u64;
            let turn = TAU * (k as f32 + between(93, seed, -0.25, 0.25)) / 5.0 + 0.3;
            let (s, c) = turn.sin_cos();
            let spread = if k == 5 { 0.12 } else { between(94, seed, 0.85, 1.35) };
            let length = if k == 5 { 0.34 } else { between(95, seed, 0.16, 0.25) };
            let way = (self.out + (self.along * c + across * s) * spread).normalize();
            cone(self.root, way, length * self.size, 0.013 * self.size)
        };
        Form::joined((0..6).map(spine))
    }
}

/// A closed cone of five sides from `root` along `way`.
fn cone(root: Vec3, way: Vec3, length: f32, wide: f32) -> Form {
    const SIDES: u32 = 5;
    let turn = Quat::from_rotation_arc(Vec3::Y, way);
    let corner = |i: u32| {
        let (s, c) = (TAU * i as f32 / SIDES as f32).sin_cos();
        turn * vec3(c, 0.0, s)
    };
    let mut cone =
        Form { positions: vec![root + way * length], normals: vec![way], ..Form::default() };
    for i in 0..SIDES {
        cone.positions.push(root + corner(i) * wide);
        cone.normals.push((corner(i) - 0.3 * way).normalize());
    }
    for i in 0..SIDES {
        let (a, b) = (1 + i, 1 + (i + 1) % SIDES);
        cone.triangles.push([0, b, a]);
        if i > 0 && i + 1 < SIDES {
            cone.triangles.push([1, a, b]);
        }
    }
    cone
}
