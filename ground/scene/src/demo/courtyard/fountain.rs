//! The fountain: an eight-sided basin, a pillar with a bowl, water that ripples and falls.

use super::super::motion::waving;
use super::super::shape::{Form, Join, Profile, ball, curve, lathe, loft, tube};
use super::super::stage::{Stage, mesh, moved};
use super::Stuff;
use crate::Morph;
use chiaro_basis::math::{Vec3, vec3};
use std::f32::consts::TAU;

/// How high water stands in the basin and in the bowl, and how wide.
const BASIN: [f32; 2] = [0.52, 1.52];
const BOWL: [f32; 2] = [1.52, 0.70];

/// The fountain about the origin.
pub(super) fn put(stage: &mut Stage, stuff: &Stuff) {
    let water = stage.material("water", 0x6f9aa6, 0.08, 0.0);
    let stone = basin().with(pillar()).with(bowl()).with(finial());
    stage.thing("fountain", None, moved(0.0, 0.0, 0.0), (stone, stuff.stone));
    let falling = Form::joined((0..8).map(|k| jet(k as f32 / 8.0)));
    stage.thing("jets", None, moved(0.0, 0.0, 0.0), (falling, water));
    for (name, [y, radius], height) in [("pool", BASIN, 0.018), ("bowl water", BOWL, 0.008)] {
        let (level, morphs) = pool(y, radius, height);
        let mut pool = mesh(name, [(level, water)]);
        pool.morphs = morphs;
        let pool = stage.push_mesh(pool);
        let node = stage.show(name, None, moved(0.0, 0.0, 0.0), pool);
        stage.animate(node, waving(3));
    }
}

/// An eight-sided wall with a moulded foot and rim.
fn basin() -> Form {
    let corners: [(f32, f32, f32); 8] = std::array::from_fn(|k| {
        let (s, c) = (TAU * (k as f32 + 0.5) / 8.0).sin_cos();
        (c, s, 0.05)
    });
    let outline = Profile::closed(&corners);
    let section = Profile::closed(&[
        (1.96, 0.0, 0.0),
        (1.96, 0.12, 0.03),
        (1.84, 0.18, 0.03),
        (1.78, 0.44, 0.05),
        (1.92, 0.50, 0.03),
        (1.94, 0.60, 0.03),
        (1.60, 0.60, 0.03),
        (1.62, 0.2, 0.03),
        (0.3, 0.2, 0.0),
        (0.3, 0.0, 0.0),
    ]);
    let ring = |p: &(chiaro_basis::math::Vec2, chiaro_basis::math::Vec2)| -> Vec<Vec3> {
        outline.points.iter().map(|(q, _)| vec3(q.x * p.0.x, p.0.y, -q.y * p.0.x)).collect()
    };
    let section = section.refined(0.2);
    let rings: Vec<Vec<Vec3>> = section.points.iter().map(ring).collect();
    loft(&rings, Join { around: true, along: true }).outward()
}

fn pillar() -> Form {
    let outline = Profile::open(&[
        (0.0, 0.15, 0.0),
        (0.46, 0.15, 0.03),
        (0.46, 0.30, 0.04),
        (0.30, 0.40, 0.06),
        (0.18, 0.62, 0.10),
        (0.26, 0.86, 0.10),
        (0.13, 1.12, 0.08),
        (0.20, 1.20, 0.03),
        (0.20, 1.26, 0.03),
        (0.0, 1.28, 0.0),
    ]);
    lathe(&outline.refined(0.06), 64).bent(fluted(16.0, 0.04, 0.45, 1.1))
}

/// A map that flutes what turns round y between two heights.
fn fluted(count: f32, depth: f32, low: f32, high: f32) -> impl Fn(Vec3) -> Vec3 {
    move |p| {
        let inside = ((p.y - low) / 0.06).clamp(0.0, 1.0) * ((high - p.y) / 0.06).clamp(0.0, 1.0);
        let r = 1.0 + depth * inside * (count * p.z.atan2(p.x)).cos();
        vec3(p.x * r, p.y, p.z * r)
    }
}

fn bowl() -> Form {
    let outline = Profile::curve(
        &[
            (0.0, 1.22),
            (0.20, 1.24),
            (0.50, 1.32),
            (0.74, 1.46),
            (0.84, 1.56),
            (0.80, 1.60),
            (0.74, 1.55),
            (0.50, 1.44),
            (0.0, 1.38),
        ],
        6,
    );
    lathe(&outline, 96).bent(fluted(24.0, 0.02, 1.28, 1.56))
}

fn finial() -> Form {
    let stem = Profile::open(&[
        (0.0, 1.35, 0.0),
        (0.12, 1.35, 0.02),
        (0.07, 1.60, 0.05),
        (0.12, 1.74, 0.02),
        (0.0, 1.76, 0.0),
    ]);
    // A cone of scales.
    let cone = ball(20).swollen(|p, _| {
        let a = p.z.atan2(p.x);
        let rows = 7.0 * p.y;
        let turn = if (rows.floor() as i32).rem_euclid(2) == 0 { 0.0 } else { 0.5 };
        let scale = ((9.0 * a / TAU + turn) * TAU).cos() * (TAU * rows).sin().abs().sqrt();
        0.06 * scale * (1.0 - p.y * p.y)
    });
    lathe(&stem, 32).with(cone.scaled(0.13, 0.20, 0.13).at(0.0, 1.92, 0.0))
}

/// Water over the bowl's lip into the basin.
fn jet(share: f32) -> Form {
    let through = [
        vec3(0.66, 1.545, 0.0),
        vec3(0.80, 1.60, 0.0),
        vec3(0.93, 1.56, 0.0),
        vec3(1.05, 1.30, 0.0),
        vec3(1.13, 0.9, 0.0),
        vec3(1.17, 0.48, 0.0),
    ];
    let wide = |t: f32| 0.020 + 0.010 * (1.0 - t) + 0.005 * (19.0 * t).sin();
    tube(&curve(&through, 36), 12, wide).turned_y(360.0 * share)
}

/// A round body of water, and two shapes whose swinging sum makes rings run outwards.
fn pool(y: f32, radius: f32, height: f32) -> (Form, Vec<Morph>) {
    let outline = Profile::open(&[
        (0.0, y - 0.05, 0.0),
        (radius, y - 0.05, 0.0),
        (radius, y, 0.01),
        (0.0, y, 0.0),
    ]);
    let form = lathe(&outline.refined(0.03), 96);
    let wave = |quarter: f32| {
        let lift = |p: &Vec3| {
            let r = p.x.hypot(p.z);
            let calm =
                (1.0 - r / radius).clamp(0.0, 1.0).powf(0.4) * f32::from(u8::from(p.y > y - 0.02));
            let (s, c) = (TAU * (2.2 * r / radius.min(1.0) - quarter)).sin_cos();
            let slope = -s * TAU * 2.2 / radius.min(1.0);
            let out = vec3(p.x, 0.0, p.z).normalize_or_zero();
            (height * calm * c * Vec3::Y, -height * calm * slope * out)
        };
        let (positions, normals) = form.positions.iter().map(lift).unzip();
        Morph { positions, normals, tangents: Vec::new() }
    };
    let morphs = vec![wave(0.0), wave(0.25)];
    (form, morphs)
}
