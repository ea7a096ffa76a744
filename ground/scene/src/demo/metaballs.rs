//! Metaballs: drops that fly through one another, part and join.
//!
//! The surface is where a soft minimum of the distances to all drops is zero (after Blinn 1982). It
//! is polygonised anew at every time, so that its topology may change; vertices and triangles of
//! different times have nothing to do with each other ([`crate::Remake`]). The flight repeats after
//! two seconds.

use super::motion::SECONDS;
use super::shape::{Form, isosurface};
use super::stage::{Stage, mesh, moved};
use crate::{Bounds, MaterialId, Mesh, Remake, Scene};
use chiaro_basis::math::{Vec3, vec3};
use std::f32::consts::TAU;
use std::sync::Arc;

/// How far drops reach for one another: the softness of the minimum, in units.
const SOFT: f32 = 0.085;

/// A drop on a closed path: its radius, the reach of its path, whole turns along each axis in a
/// loop, and where on them it begins.
struct Drop {
    radius: f32,
    reach: Vec3,
    turns: [i32; 3],
    start: [f32; 3],
}

const DROPS: [Drop; 9] = [
    drop(0.52, [0.12, 0.08, 0.12], [1, 1, 1], [0.0, 0.3, 0.6]),
    drop(0.36, [1.10, 0.34, 0.55], [1, 1, 1], [0.0, 0.05, 0.25]),
    drop(0.33, [0.95, 0.62, 0.62], [1, 1, 1], [0.52, 0.18, 0.80]),
    drop(0.28, [0.50, 0.98, 0.72], [1, 1, 1], [0.30, 0.55, 0.05]),
    drop(0.26, [0.86, 0.80, 0.34], [1, -1, 1], [0.72, 0.40, 0.30]),
    drop(0.24, [0.62, 0.92, 0.86], [-1, 1, 1], [0.15, 0.85, 0.50]),
    drop(0.20, [1.20, 0.55, 0.80], [1, 2, -1], [0.85, 0.0, 0.62]),
    drop(0.18, [0.70, 1.12, 0.50], [2, 1, 1], [0.40, 0.70, 0.92]),
    drop(0.16, [0.98, 0.98, 0.90], [-1, 1, 2], [0.60, 0.95, 0.10]),
];

const fn drop(radius: f32, reach: [f32; 3], turns: [i32; 3], start: [f32; 3]) -> Drop {
    Drop { radius, reach: Vec3::from_array(reach), turns, start }
}

/// Drops in flight.
pub(super) fn metaballs() -> Scene {
    let mut stage = Stage::default();
    let quicksilver = stage.material("quicksilver", 0xaab4bd, 0.3, 0.0);
    let at = move |seconds: f64| surface(seconds, quicksilver);
    let mut first = at(0.0);
    first.remake = Some(Remake(Arc::new(at)));
    let drops = stage.push_mesh(first);
    stage.show("metaballs", None, moved(0.0, 0.0, 0.0), drops);
    stage.finish()
}

/// The surface at a time.
fn surface(seconds: f64, material: MaterialId) -> Mesh {
    const CELL: f32 = 0.052;
    let drops = drops_at((seconds / SECONDS).rem_euclid(1.0) as f32);
    let bounds = Bounds { min: Vec3::splat(-1.85), max: Vec3::splat(1.85) };
    let form: Form = isosurface(bounds, CELL, &|p| field(&drops, p));
    mesh("metaballs", [(form, material)])
}

fn drops_at(phase: f32) -> [(Vec3, f32); DROPS.len()] {
    DROPS.each_ref().map(|d| {
        let along = |k: usize| (TAU * (d.turns[k] as f32 * phase + d.start[k])).sin();
        (d.reach * vec3(along(0), along(1), along(2)), d.radius)
    })
}

/// A soft minimum of the distances to the drops: negative inside, and nowhere steeper than 1.
fn field(drops: &[(Vec3, f32)], p: Vec3) -> f32 {
    let distance = |(c, r): &(Vec3, f32)| p.distance(*c) - r;
    let least = drops.iter().map(distance).fold(f32::INFINITY, f32::min);
    let sum: f32 = drops.iter().map(|d| ((least - distance(d)) / SOFT).exp()).sum();
    least - SOFT * sum.ln()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_flight_repeats_and_its_topology_changes() {
        let at = |t: f64| surface(t, MaterialId::new(0));
        assert_eq!(at(0.25).positions, at(0.25 + SECONDS).positions);
        let chi = |m: Mesh| m.positions.len() as i64 - m.triangles.len() as i64 / 2;
        let chis: Vec<i64> = (0..8).map(|k| chi(at(0.25 * f64::from(k)))).collect();
        assert!(chis.iter().any(|&c| c != chis[0]), "{chis:?}");
    }
}
