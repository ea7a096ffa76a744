//! Blocks: boxes and prisms with truly rounded edges, and superellipsoids.
//!
//! The roundings are arcs with exact normals; flats stay flat in shading, too.

use super::form::Form;
use super::loft::{Join, Ring, loft_with_normals, pointed};
use super::profile::Profile;
use chiaro_basis::math::{Vec3, vec3};
use std::collections::BTreeMap;
use std::f32::consts::{FRAC_PI_2, FRAC_PI_4, PI, TAU};

/// A box about the origin with the given full sizes, edges and corners rounded by `radius` in
/// `steps` segments (at least 1).
pub(crate) fn block(size: Vec3, radius: f32, steps: usize) -> Form {
    let radius = radius.min(0.499 * size.min_element());
    let core = 0.5 * size - Vec3::splat(radius);
    let top = 2 * steps + 1;
    // Lattice coordinate 0..=top along each axis: `steps` of arc, the flat, `steps` of arc.
    let slope = |i: usize| {
        let half = if i <= steps { i as f32 - steps as f32 } else { (i - steps - 1) as f32 };
        (FRAC_PI_4 * half / steps as f32).tan()
    };
    let sign = |i: usize| if i <= steps { -1.0 } else { 1.0 };
    let mut form = Form::default();
    let mut known: BTreeMap<[usize; 3], u32> = BTreeMap::new();
    for axis in 0..3 {
        for end in [0, top] {
            for cell in 0..top * top {
                let (i, j) = (cell % top, cell / top);
                let [a, b, c, d] =
                    [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)].map(|(i, j)| {
                        let mut key = [0; 3];
                        key[axis] = end;
                        key[(axis + 1) % 3] = i;
                        key[(axis + 2) % 3] = j;
                        *known.entry(key).or_insert_with(|| {
                            let n = Vec3::from(key.map(slope)).normalize();
                            form.positions.push(core * Vec3::from(key.map(sign)) + radius * n);
                            form.normals.push(n);
                            form.positions.len() as u32 - 1
                        })
                    });
                let quad = if end == 0 { [[a, c, b], [a, d, c]] } else { [[a, b, c], [a, c, d]] };
                form.triangles.extend(quad);
            }
        }
    }
    form
}

/// A closed outline in (x, z), star-shaped about the origin, drawn up from y = 0 to `height`, its
/// upper and lower edges rounded by `radius`.
pub(crate) fn prism(outline: &Profile, height: f32, radius: f32) -> Form {
    const STEPS: usize = 4;
    let (mut rings, mut normals): (Vec<Ring>, Vec<Ring>) =
        (vec![vec![Vec3::ZERO]], vec![vec![Vec3::NEG_Y]]);
    let mut ring = |angle: f32, y: f32| {
        let (up, out) = angle.sin_cos();
        let inset = radius * (1.0 - out);
        let normal = |n: chiaro_basis::math::Vec2| vec3(n.x * out, up, -n.y * out);
        rings.push(
            outline
                .points
                .iter()
                .map(|(p, n)| vec3(p.x - n.x * inset, y + radius * up, -p.y + n.y * inset))
                .collect(),
        );
        normals.push(outline.points.iter().map(|(_, n)| normal(*n)).collect());
    };
    for k in 0..=STEPS {
        ring(-FRAC_PI_2 * (1.0 - k as f32 / STEPS as f32), radius);
    }
    for k in 0..=STEPS {
        ring(FRAC_PI_2 * k as f32 / STEPS as f32, height - radius);
    }
    rings.push(vec![vec3(0.0, height, 0.0)]);
    normals.push(vec![Vec3::Y]);
    loft_with_normals(&rings, &normals, Join { around: true, along: false })
}

/// A superellipsoid (Barr 1981) with half-sizes `half`; exponents of 1 give an ellipsoid, towards 0
/// a box, above 1 a pinched star; `east` shapes the horizontal section, `north` the vertical one.
pub(crate) fn superellipsoid(half: Vec3, north: f32, east: f32, segments: usize) -> Form {
    let power = |x: f32, e: f32| x.signum() * x.abs().powf(e);
    pointed(segments, segments / 2, |u, v| {
        let ((sv, cv), (su, cu)) = ((PI * (v - 0.5)).sin_cos(), (TAU * u).sin_cos());
        let ring = power(cv.max(0.0), north);
        half * vec3(ring * power(cu, east), power(sv, north), ring * power(su, east))
    })
}
