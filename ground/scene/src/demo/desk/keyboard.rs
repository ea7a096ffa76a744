//! The keyboard: a wedge with hollowed caps in rows; some go down as if someone typed.

use super::super::motion::moving;
use super::super::shape::{Form, Profile, block, prism, tube};
use super::super::stage::{Stage, moved, placed};
use crate::{MeshId, Transform};
use chiaro_basis::math::{DQuat, DVec3, Vec3, dvec3, vec3};

/// The distance of the caps' middles.
const PITCH: f32 = 0.27;
/// Widths of the caps of each row, front row last; a row is 14 wide.
const ROWS: [&[f32]; 5] = [
    &[1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 2.0],
    &[1.5, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.5],
    &[1.75, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 2.25],
    &[2.25, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 2.75],
    &[1.25, 1.25, 1.25, 6.5, 1.25, 1.25, 1.25],
];
/// Which caps go down, and when: row, place, phase.
const TYPED: [(usize, usize, f64); 8] = [
    (1, 4, 0.02),
    (2, 8, 0.14),
    (3, 5, 0.25),
    (2, 2, 0.37),
    (4, 3, 0.50),
    (1, 9, 0.62),
    (2, 4, 0.73),
    (3, 8, 0.86),
];

/// The keyboard with its middle at `at`.
pub(super) fn put(stage: &mut Stage, at: Vec3) {
    let shell = stage.material("shell", 0xcfcac0, 0.5, 0.0);
    let caps = stage.material("caps", 0x4a4d52, 0.55, 0.0);
    let tilt = DQuat::from_rotation_y(-0.10) * DQuat::from_rotation_x(0.09);
    let base = stage.joint("keyboard", None, placed((at + 0.13 * Vec3::Y).as_dvec3(), tilt, 1.0));
    let tray =
        block(vec3(14.0 * PITCH + 0.22, 0.22, 5.0 * PITCH + 0.22), 0.07, 4).at(0.0, 0.02, 0.0);
    let through = [
        vec3(0.6, 0.02, -0.7),
        vec3(0.62, -0.1, -1.0),
        vec3(0.9, -0.20, -1.3),
        vec3(1.7, -0.34, -1.55),
    ];
    let cable = tube(&super::super::shape::curve(&through, 24), 8, |_| 0.035);
    stage.thing("tray", Some(base), Default::default(), (tray.with(cable), shell));
    let mut kinds: Vec<(f32, MeshId)> = Vec::new();
    for (r, row) in ROWS.iter().enumerate() {
        let mut x = -7.0;
        for (c, &width) in row.iter().enumerate() {
            let kind = kinds.iter().find(|k| k.0 == width).map(|k| k.1);
            let kind = kind.unwrap_or_else(|| {
                kinds.push((width, stage.mesh("cap", [(cap(width), caps)])));
                kinds[kinds.len() - 1].1
            });
            let place = dvec3(
                f64::from((x + 0.5 * width) * PITCH),
                0.12,
                f64::from((r as f32 - 2.0) * PITCH),
            );
            let node = stage.show("cap", Some(base), at_rest(place), kind);
            if let Some(typed) = TYPED.iter().find(|t| (t.0, t.1) == (r, c)) {
                stage.animate(node, moving(|t| place - DVec3::Y * 0.07 * pressed(t - typed.2)));
            }
            x += width;
        }
    }
}

fn at_rest(p: DVec3) -> Transform {
    moved(p.x, p.y, p.z)
}

/// Quickly down and up again, in [0, 1], from phase 0 on.
fn pressed(phase: f64) -> f64 {
    let t = phase.rem_euclid(1.0) / 0.14;
    if t < 1.0 { (std::f64::consts::PI * t).sin().powf(0.7) } else { 0.0 }
}

/// A cap of `width` pitches, tapered, its top hollowed along z.
fn cap(width: f32) -> Form {
    let (w, d) = (width * PITCH - 0.03, PITCH - 0.03);
    let outline = Profile::rectangle(w, d, 0.035).refined(0.2);
    prism(&outline, 0.17, 0.03).bent(move |p| {
        let up = p.y / 0.17;
        let inset = 1.0 - 0.035 * up / (0.5 * d);
        let x = p.x * (1.0 - 0.035 * up / (0.5 * w));
        vec3(x, p.y - 0.02 * up * (1.0 - (p.z / (0.5 * d)).powi(2)), p.z * inset)
    })
}
