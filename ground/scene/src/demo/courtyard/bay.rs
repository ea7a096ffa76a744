//! One bay: arch, cornice, balustrade, vault, steps, beams, the wall behind with door and window.

use super::super::shape::{Form, Placed, Profile, block, lathe, prism, ribbon, sheet, slab, swept};
use super::{BAY, BEAM, DEPTH, FLOOR, SPRING, UPPER, WALL, row};
use chiaro_basis::math::{Vec2, Vec3, vec2, vec3};
use std::f32::consts::PI;

/// The arch's radius, and half the thickness of the wall that it carries.
const ARCH: f32 = 0.5 * BAY - 0.33;
const HALF: f32 = 0.24;

/// The wall over the arch, up to the upper floor.
pub(super) fn front() -> Form {
    let arc = (0..=28).map(|k| {
        let (s, c) = (PI * k as f32 / 28.0).sin_cos();
        vec3(0.5 * BAY - ARCH * c, SPRING + ARCH * s, HALF)
    });
    let low: Vec<Vec3> = std::iter::once(vec3(0.0, SPRING, HALF))
        .chain(arc)
        .chain([vec3(BAY, SPRING, HALF)])
        .collect();
    let high: Vec<Vec3> = low.iter().map(|p| vec3(p.x, UPPER, HALF)).collect();
    // A keystone, and a round boss on either side of the arch.
    let key = block(vec3(0.24, 0.5, 2.0 * HALF + 0.16), 0.03, 2);
    let key = key.bent(|p| vec3(p.x * (1.0 + 0.5 * p.y), p.y, p.z));
    let boss = Profile::open(&[
        (0.0, 0.0, 0.0),
        (0.26, 0.0, 0.0),
        (0.26, 0.05, 0.02),
        (0.19, 0.05, 0.02),
        (0.17, 0.02, 0.02),
        (0.12, 0.03, 0.04),
        (0.0, 0.10, 0.0),
    ]);
    let boss = lathe(&boss, 32).turned_x(90.0).at(0.0, 4.55, HALF - 0.01);
    slab(&low, &high, vec3(0.0, 0.0, -2.0 * HALF))
        .with(key.at(0.5 * BAY, SPRING + ARCH + 0.16, 0.0))
        .with(boss.clone().at(0.30, 0.0, 0.0))
        .with(boss.at(BAY - 0.30, 0.0, 0.0))
}

/// A moulding round the arch, on the court's side.
pub(super) fn archivolt() -> Form {
    let outline = Profile::closed(&[
        (0.26, -0.02, 0.0),
        (0.26, 0.09, 0.02),
        (0.20, 0.09, 0.02),
        (0.18, 0.045, 0.01),
        (0.11, 0.045, 0.01),
        (0.09, 0.07, 0.01),
        (0.0, 0.07, 0.015),
        (0.0, -0.02, 0.0),
    ]);
    let path: Vec<Placed> = (0..=36)
        .map(|k| {
            let (s, c) = (PI * k as f32 / 36.0).sin_cos();
            let x = vec3(-c, s, 0.0);
            let at = vec3(0.5 * BAY, SPRING, HALF) + ARCH * x;
            Placed { at, x, y: Vec3::Z }
        })
        .collect();
    swept(&outline, vec2(0.14, 0.0), &path)
}

/// An outline drawn along the bay at the court's side; x is towards the court.
fn along(outline: &Profile, heart: Vec2, y: f32, z: f32) -> Form {
    let place = |p: Vec3| Placed { at: p, x: Vec3::Z, y: Vec3::Y };
    let path: Vec<Placed> =
        row(vec3(0.0, y, z), vec3(BAY, y, z), 1).into_iter().map(place).collect();
    swept(outline, heart, &path)
}

/// The cornice below the upper floor, with dentils.
pub(super) fn cornice() -> Form {
    let outline = Profile::closed(&[
        (-0.02, 0.0, 0.0),
        (0.04, 0.0, 0.01),
        (0.05, 0.08, 0.01),
        (0.10, 0.12, 0.03),
        (0.10, 0.22, 0.01),
        (0.26, 0.23, 0.01),
        (0.27, 0.30, 0.01),
        (0.33, 0.37, 0.04),
        (0.33, 0.42, 0.01),
        (-0.02, 0.42, 0.0),
    ]);
    let band = along(&outline, vec2(0.004, 0.405), UPPER - 0.40, HALF);
    let dentil = |k: usize| {
        let x = BAY * (k as f32 + 0.5) / 16.0;
        block(vec3(0.11, 0.10, 0.12), 0.008, 1).at(x, UPPER - 0.225, HALF + 0.14)
    };
    band.with(Form::joined((0..16).map(dentil)))
}

/// Balusters between two rails.
pub(super) fn balustrade() -> Form {
    let baluster = Profile::open(&[
        (0.0, 0.0, 0.0),
        (0.075, 0.0, 0.005),
        (0.075, 0.05, 0.005),
        (0.04, 0.07, 0.01),
        (0.05, 0.10, 0.02),
        (0.088, 0.22, 0.06),
        (0.035, 0.50, 0.10),
        (0.055, 0.56, 0.015),
        (0.035, 0.60, 0.01),
        (0.07, 0.63, 0.01),
        (0.07, 0.68, 0.005),
        (0.0, 0.68, 0.0),
    ]);
    let baluster = lathe(&baluster, 10).at(0.0, UPPER + 0.12, 0.0);
    let one = |k: usize| baluster.clone().at(BAY * (k as f32 + 1.0) / 10.0, 0.0, 0.0);
    let rail = |y: f32, tall: f32, deep: f32| {
        block(vec3(BAY - 0.02, tall, deep), 0.02, 2).at(0.5 * BAY, y, 0.0)
    };
    Form::joined((0..9).map(one)).with(rail(UPPER + 0.07, 0.13, 0.26)).with(rail(
        UPPER + 0.86,
        0.15,
        0.30,
    ))
}

/// A groin vault over `width` x `depth` of the gallery, its top flat.
pub(super) fn vault(width: f32, depth: f32) -> Form {
    const N: usize = 20;
    let rise = UPPER - SPRING - 0.25;
    let barrel = |t: f32| rise * (1.0 - (2.0 * t - 1.0).powi(2)).max(0.0).sqrt();
    let ease = |t: f32| 0.5 - 0.5 * (PI * t).cos();
    let under = |u: f32, v: f32| {
        // The same bits for the same place, whichever way it is reached.
        let [u, v] = [u, v].map(|t| ease((t * N as f32).round() / N as f32));
        vec3(width * u, SPRING + barrel(u).max(barrel(v)), -depth * v)
    };
    let top = |p: Vec3| vec3(p.x, UPPER, p.z);
    let edge = |f: &dyn Fn(f32) -> Vec3| -> Vec<Vec3> {
        (0..=N).map(|k| f(k as f32 / N as f32)).collect()
    };
    let wall = |line: Vec<Vec3>| {
        let above: Vec<Vec3> = line.iter().map(|p| top(*p)).collect();
        ribbon(line, above)
    };
    Form::joined([
        sheet(N, N, |u, v| under(u, 1.0 - v)),
        sheet(N, N, |u, v| top(under(u, v))),
        wall(edge(&|t| under(t, 0.0))),
        wall(edge(&|t| under(1.0, t))),
        wall(edge(&|t| under(1.0 - t, 1.0))),
        wall(edge(&|t| under(0.0, 1.0 - t))),
    ])
}

/// Two steps from the court up to the gallery.
pub(super) fn steps() -> Form {
    let step = |high: f32, out: f32, back: f32| {
        let size = vec3(BAY, high, out + back);
        block(size, 0.02, 2).at(0.5 * BAY, 0.5 * high, 0.5 * (out - back))
    };
    step(0.5 * FLOOR, 0.72, 0.4).with(step(FLOOR, 0.42, 0.5))
}

/// The beam on the colonnettes, and rafters over the gallery.
pub(super) fn beams() -> Form {
    let beam = block(vec3(BAY, 0.28, 0.30), 0.02, 2).at(0.5 * BAY, BEAM + 0.14, 0.0);
    let slope = super::roof::SLOPE;
    let rafter = |k: usize| {
        let long = (DEPTH + 0.7) / slope.cos();
        let rafter = block(vec3(0.10, 0.14, long), 0.015, 1).turned_x(slope.to_degrees());
        let x = BAY * (k as f32 + 0.5) / 6.0;
        rafter.at(x, BEAM + 0.34 + (0.5 * DEPTH - 0.12) * slope.tan(), -0.5 * DEPTH + 0.22)
    };
    beam.with(Form::joined((0..6).map(rafter)))
}

/// The wall behind the gallery, `width` long.
pub(super) fn wall(width: f32) -> Form {
    let size = vec3(width, WALL, 0.3);
    block(size, 0.01, 1).at(0.5 * width, 0.5 * WALL, -DEPTH - 0.15)
}

/// Frames of the door below and the window above.
pub(super) fn frames() -> Form {
    let frame = |low: f32, high: f32, half: f32, sill: bool| {
        let post = |side: f32| {
            let x = 0.5 * BAY + side * (half + 0.09);
            block(vec3(0.18, high - low, 0.14), 0.02, 2).at(x, 0.5 * (low + high), -DEPTH + 0.05)
        };
        let lintel = block(vec3(2.0 * half + 0.60, 0.22, 0.22), 0.025, 2);
        let lintel = lintel.at(0.5 * BAY, high + 0.10, -DEPTH + 0.08);
        let foot = block(vec3(2.0 * half + 0.6, 0.12, 0.30), 0.025, 2);
        let foot = foot.at(0.5 * BAY, low - if sill { 0.05 } else { -0.04 }, -DEPTH + 0.1);
        Form::joined([post(1.0), post(-1.0), lintel, foot])
    };
    frame(FLOOR, 2.7, 0.62, false).with(frame(UPPER + 0.95, 7.5, 0.5, true))
}

/// The door of planks with panels, and shutters of slats.
pub(super) fn leaves() -> Form {
    let panel = |x: f32, y: f32, w: f32, h: f32, z: f32| {
        block(vec3(w, h, 0.06), 0.018, 1).at(0.5 * BAY + x, y, -DEPTH + z)
    };
    let mut leaves = panel(-0.31, 1.5, 0.60, 2.38, 0.0).with(panel(0.31, 1.5, 0.60, 2.38, 0.0));
    for x in [-0.31, 0.31] {
        for (y, h) in [(0.75, 0.6), (1.5, 0.62), (2.25, 0.62)] {
            leaves = leaves.with(panel(x, y, 0.42, h, 0.025));
        }
        let knob = prism(&Profile::circle(0.035, 12), 0.05, 0.012).turned_x(90.0);
        leaves = leaves.with(knob.at(0.5 * BAY + 0.2 * x, 1.35, -DEPTH + 0.03));
    }
    let (low, high) = (UPPER + 0.98, 7.5);
    for x in [-0.75f32, -0.25, 0.25, 0.75] {
        let (x, z) = if x.abs() > 0.5 { (x * 1.02, 0.03) } else { (x, -0.02) };
        leaves = leaves.with(panel(x, 0.5 * (low + high), 0.48, high - low, z));
        for k in 0..9 {
            let y = low + (high - low) * (k as f32 + 0.5) / 9.0;
            leaves = leaves.with(panel(x, y, 0.38, 0.07, z + 0.03));
        }
    }
    leaves
}
