//! A relief of rocks, pebbles and cracks that fills the whole picture: no background, detail at
//! every scale, for minimal cuts at any size.

use super::shape::{cells, layers, ridges, sheet};
use super::stage::Stage;
use crate::{Projection, Scene};
use chiaro_basis::math::{Vec2, Vec3, vec2, vec3};
use chiaro_basis::random::unit;

/// Half the width and height of the relief; the camera sees a height of 2.
const HALF: Vec2 = Vec2::new(2.2, 1.1);

/// The relief; about 12 000 `size`² triangles.
pub(super) fn rocks(size: u32) -> Scene {
    let mut stage = Stage::default();
    let stone = stage.matt("stone", 0x9a938a);
    let (nx, ny) = (110 * size as usize, 55 * size as usize);
    let form = sheet(nx, ny, |u, v| {
        let p = (vec2(u, v) * 2.0 - 1.0) * HALF;
        p.extend(height(p))
    });
    stage.thing("rocks", None, Default::default(), (form, stone));
    let camera = Projection::Orthographic { half_height: 1.0 };
    stage.camera(vec3(0.0, 0.0, 4.0), Vec3::ZERO, camera, 4.0 / 3.0);
    stage.finish()
}

/// The relief's height above the plane.
fn height(p: Vec2) -> f32 {
    let warp = |seed: u64| layers(seed, vec3(p.x * 1.5, p.y * 1.5, 0.3), 3);
    let bent = p + 0.16 * vec2(warp(11), warp(12));
    let boulders = stones(21, bent * 1.9 + 7.3, 0.34) / 1.5 + 0.07;
    let cobbles = stones(22, bent * 4.6 + 3.1, 0.40) / 3.8 - 0.02;
    let pebbles = stones(23, bent * 11.0 + 1.7, 0.5) / 9.0 - 0.03;
    let ground = boulders.max(cobbles).max(pebbles);
    let grain = 0.02 * layers(31, p.extend(0.0) * 6.0, 4);
    let chipped = 0.05 * ridges(32, p.extend(0.5) * 2.2, 4);
    ground + grain + chipped - crack(p)
}

/// Domes with flattened, tilted tops over jittered cells, in units of a cell.
fn stones(seed: u64, p: Vec2, tallness: f32) -> f32 {
    let c = cells(seed, p.x, p.y, 0.85);
    let lot = |k: u64| unit(seed + 90 + k, c.id);
    // Some stones are missing, and show what lies beneath.
    let sunk = if lot(0) < 0.25 { 0.5 } else { 0.3 * lot(1) };
    let rim = (c.border / 0.3).clamp(0.0, 1.0);
    let dome = (rim * (2.0 - rim)).sqrt();
    let tilt = Vec2::from(c.from).dot(vec2(lot(2) - 0.5, lot(3) - 0.5));
    tallness * (dome - 1.0) + 0.55 * tilt - sunk * tallness
}

/// The depth of thin cracks through everything.
fn crack(p: Vec2) -> f32 {
    let warp = |seed: u64| layers(seed, vec3(p.x * 3.0, p.y * 3.0, 0.7), 3);
    let bent = p + 0.12 * vec2(warp(13), warp(14));
    let c = cells(41, bent.x * 1.1, bent.y * 1.1, 0.9);
    0.06 * (1.0 - c.border / 0.03).clamp(0.0, 1.0)
}
