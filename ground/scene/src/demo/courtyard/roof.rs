//! Roofs: four slopes that fall towards the court and meet at the corners, tiled.

use super::super::shape::{Form, between, ribbon, slab, tube};
use super::super::stage::{Stage, placed};
use super::{BAY, BEAM, DEPTH, Side, Stuff, row};
use crate::Transform;
use chiaro_basis::math::{DQuat, Vec3, dvec3, vec3};
use std::f32::consts::PI;

/// The angle of the slopes.
pub(super) const SLOPE: f32 = 0.38;
/// How far eaves stand over the court, and how far roofs reach behind the wall.
const EAVE: f32 = 0.55;
const BACK: f32 = 0.35;
/// A tile's width and the length that shows.
const TILE: [f32; 2] = [BAY / 12.0, 0.40];

/// A point of a slope; z is 0 over the columns.
fn on(x: f32, z: f32) -> Vec3 {
    vec3(x, BEAM + 0.46 - z * SLOPE.tan(), z)
}

/// Slopes, tiles and hips.
pub(super) fn put(stage: &mut Stage, stuff: &Stuff, sides: &[Side; 4]) {
    for pair in 0..2 {
        let side = &sides[pair];
        let places: Vec<Transform> =
            [pair, pair + 2].iter().map(|&k| sides[k].stand(0, Default::default())).collect();
        let slope = stage.mesh("slope", [(slope(side.count), stuff.wood)]);
        stage.copies("slope", slope, places);
    }
    let tile = stage.mesh("tile", [(tile(), stuff.tile)]);
    stage.copies("tile", tile, sides.iter().flat_map(tiles).collect());
    let hip = stage.mesh("hip", [(hip(), stuff.tile)]);
    let corners = sides.iter().map(|s| s.stand(0, Default::default())).collect();
    stage.copies("hip", hip, corners);
}

/// The boards below the tiles of a side of `count` bays.
fn slope(count: usize) -> Form {
    let length = BAY * count as f32;
    let line = |z: f32| row(on(z, z), on(length - z, z), 1);
    slab(&line(EAVE), &line(-DEPTH - BACK), vec3(0.0, -0.07, 0.0))
}

/// All tiles of a side, those past the hips left out.
fn tiles(side: &Side) -> Vec<Transform> {
    let length = BAY * side.count as f32;
    let rows = ((EAVE + DEPTH + BACK) / (TILE[1] * SLOPE.cos())) as usize;
    let lean = DQuat::from_rotation_x(f64::from(SLOPE + 0.035));
    let mut places = Vec::new();
    for r in 0..rows {
        let z = EAVE - (r as f32 + 0.35) * TILE[1] * SLOPE.cos();
        let first = ((z + 0.02) / TILE[0]).ceil() as i32;
        let last = ((length - z - 0.02) / TILE[0]).floor() as i32;
        for c in first..last {
            let x = (c as f32 + 0.5) * TILE[0];
            let seed = (r as u64) << 32 | (c + 100_000) as u64;
            let jitter = |k: u64, reach: f32| f64::from(between(131 + k, seed, -reach, reach));
            let at = on(x, z).as_dvec3() + dvec3(jitter(0, 0.006), 0.045 + jitter(1, 0.006), 0.0);
            let turn = side.turn * DQuat::from_rotation_y(jitter(2, 0.02)) * lean;
            places.push(placed(side.place(0, at), turn, 1.0));
        }
    }
    places
}

/// A half-round tile along z, its wide end to the front; thick and closed.
fn tile() -> Form {
    const ARC: usize = 8;
    let ring = |z: f32, r: f32| -> Vec<Vec3> {
        let at = |k: usize, r: f32| {
            let (s, c) = (PI * k as f32 / ARC as f32).sin_cos();
            vec3(r * c, 0.85 * r * s, z)
        };
        let outer = (0..=ARC).map(|k| at(k, r));
        outer.chain((0..=ARC).rev().map(|k| at(k, r - 0.018))).collect()
    };
    let (front, back) = (ring(0.24, 0.135), ring(-0.24, 0.112));
    // Each face by itself: tiles have crisp rims.
    let face = |from: usize, to: usize| {
        let pick = |ring: &[Vec3]| (from..=to).map(|k| ring[k % ring.len()]).collect::<Vec<_>>();
        ribbon(pick(&back), pick(&front))
    };
    let cap = |ring: &[Vec3], turned: bool| {
        let (a, mut b) = (ring[..=ARC].to_vec(), ring[ARC + 1..].to_vec());
        b.reverse();
        if turned { ribbon(b, a) } else { ribbon(a, b) }
    };
    Form::joined([
        face(0, ARC),
        face(ARC, ARC + 1),
        face(ARC + 1, 2 * ARC + 1),
        face(2 * ARC + 1, 2 * ARC + 2),
        cap(&front, false),
        cap(&back, true),
    ])
}

/// Round tiles over the line where two slopes meet, from the first bay's corner outwards.
fn hip() -> Form {
    let (a, b) = (on(EAVE, EAVE), on(-DEPTH - BACK, -DEPTH - BACK));
    let count = 11;
    let piece = |k: usize| {
        let at = |t: f32| a.lerp(b, (t / count as f32).min(1.0)) + vec3(0.0, 0.05, 0.0);
        let points = [at(k as f32), at(k as f32 + 0.6), at(k as f32 + 1.15)];
        tube(&points, 14, |t| 0.15 - 0.03 * t)
    };
    Form::joined((0..count).map(piece))
}
