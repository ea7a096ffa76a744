//! Tubes: a section drawn along a curve in space without twisting.
//!
//! Frames are carried along by double reflection (Wang, Jüttler, Zheng and Liu 2008), which turns
//! no more than the curve does.

use super::form::Form;
use super::loft::{Join, Ring, loft};
use chiaro_basis::math::{Vec3, vec3};
use std::f32::consts::{FRAC_PI_2, TAU};

/// A frame on a curve: where, and the two directions across.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Station {
    /// The point.
    pub(crate) at: Vec3,
    /// Unit direction of the curve.
    pub(crate) along: Vec3,
    /// Unit vector across it.
    pub(crate) side: Vec3,
}

impl Station {
    /// The point at (`x`, `y`) across the curve.
    pub(crate) fn across(&self, x: f32, y: f32) -> Vec3 {
        self.at + self.side * x + self.along.cross(self.side) * y
    }
}

/// Frames along points; `side` is roughly the first frame's side.
pub(crate) fn stations(points: &[Vec3], side: Vec3) -> Vec<Station> {
    let last = points.len() - 1;
    let along =
        |i: usize| (points[(i + 1).min(last)] - points[i.saturating_sub(1)]).normalize_or(Vec3::Y);
    let first =
        (side - along(0) * side.dot(along(0))).normalize_or(along(0).any_orthonormal_vector());
    let mut list = vec![Station { at: points[0], along: along(0), side: first }];
    for i in 1..=last {
        let before = list[i - 1];
        let step = points[i] - before.at;
        let mirrored = |v: Vec3, axis: Vec3| {
            v - axis * (2.0 * axis.dot(v) / axis.length_squared().max(f32::MIN_POSITIVE))
        };
        let (side, tangent) = (mirrored(before.side, step), mirrored(before.along, step));
        let side = mirrored(side, along(i) - tangent);
        let side = (side - along(i) * side.dot(along(i))).normalize_or(before.side);
        list.push(Station { at: points[i], along: along(i), side });
    }
    list
}

/// `count` + 1 points of a curve through `through` (Catmull and Rom 1974), evenly in its parameter.
pub(crate) fn curve(through: &[Vec3], count: usize) -> Vec<Vec3> {
    let spans = through.len() - 1;
    let at = |i: isize| through[i.clamp(0, spans as isize) as usize];
    let point = |k: usize| {
        let t = k as f32 / count as f32 * spans as f32;
        let span = (t as usize).min(spans - 1);
        let (t, s) = (t - span as f32, span as isize);
        let [a, b, c, d] = [at(s - 1), at(s), at(s + 1), at(s + 2)];
        let (p, q) = (2.0 * a - 5.0 * b + 4.0 * c - d, 3.0 * b - a - 3.0 * c + d);
        0.5 * (2.0 * b + t * ((c - a) + t * (p + t * q)))
    };
    (0..=count).map(point).collect()
}

/// A round tube along `points` with half-round ends; `radius` of the share of the way, in [0, 1].
pub(crate) fn tube(points: &[Vec3], segments: usize, radius: impl Fn(f32) -> f32) -> Form {
    let list = stations(points, vec3(0.3, 1.0, 0.2));
    let last = list.len() - 1;
    let ring = |s: &Station, r: f32| -> Ring {
        let spoke = |i: usize| {
            let (y, x) = (TAU * i as f32 / segments as f32).sin_cos();
            s.across(r * x, r * y)
        };
        (0..segments).map(spoke).collect()
    };
    let cap = (segments / 4).max(2);
    let dome = |s: &Station, r: f32, k: usize, sign: f32| {
        let (y, x) = (FRAC_PI_2 * k as f32 / cap as f32).sin_cos();
        let moved = Station { at: s.at + s.along * (sign * r * x), ..*s };
        if k == 0 { vec![moved.at] } else { ring(&moved, r * y) }
    };
    let mut rings: Vec<Ring> = (0..cap).map(|k| dome(&list[0], radius(0.0), k, -1.0)).collect();
    rings.extend(list.iter().enumerate().map(|(i, s)| ring(s, radius(i as f32 / last as f32))));
    rings.extend((0..cap).rev().map(|k| dome(&list[last], radius(1.0), k, 1.0)));
    loft(&rings, Join { around: true, along: false }).outward()
}

/// A round tube along a closed flat curve; `across` is the normal of its plane.
pub(crate) fn hoop(points: &[Vec3], across: Vec3, segments: usize, radius: f32) -> Form {
    let n = points.len();
    let ring = |k: usize| -> Ring {
        let along = (points[(k + 1) % n] - points[(k + n - 1) % n]).normalize();
        let frame = Station { at: points[k], along, side: across };
        let spoke = |i: usize| {
            let (y, x) = (TAU * i as f32 / segments as f32).sin_cos();
            frame.across(radius * x, radius * y)
        };
        (0..segments).map(spoke).collect()
    };
    let rings: Vec<Ring> = (0..n).map(ring).collect();
    loft(&rings, Join { around: true, along: true }).outward()
}
