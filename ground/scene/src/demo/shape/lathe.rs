//! Turned things: a profile of (radius, height) swept round the y axis.

use super::form::Form;
use super::loft::{Join, Ring, loft_with_normals};
use super::profile::Profile;
use chiaro_basis::math::{Vec2, Vec3, vec3};
use std::f32::consts::TAU;

/// A profile turned round the y axis. Its points are (radius, height); an end of radius 0 is a
/// pole, so that profiles from axis to axis and closed profiles give closed forms.
pub(crate) fn lathe(profile: &Profile, segments: usize) -> Form {
    let turned = |p: Vec2, count: usize| -> Ring {
        let ray = |i: usize| {
            let (s, c) = (TAU * i as f32 / segments as f32).sin_cos();
            vec3(c * p.x, p.y, s * p.x)
        };
        (0..count).map(ray).collect()
    };
    let last = profile.points.len() - 1;
    let (mut rings, mut normals) = (Vec::new(), Vec::new());
    for (i, &(p, n)) in profile.points.iter().enumerate() {
        let pole = !profile.closed && (i == 0 || i == last) && p.x.abs() < 1e-6;
        rings.push(turned(p, if pole { 1 } else { segments }));
        normals.push(if pole { vec![Vec3::Y * n.y.signum()] } else { turned(n, segments) });
    }
    loft_with_normals(&rings, &normals, Join { around: true, along: profile.closed })
}
