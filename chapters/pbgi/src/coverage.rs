//! How well surfels cover what they stand for: the share of places on the surface that lie in some
//! disc, one and a half times as wide as its surfel's area.

use crate::grid::SurfelGrid;
use crate::site::sites;
use crate::surfel::{Lit, Surfels, place};
use std::f32::consts::PI;

/// Places that are looked at.
const PROBES: usize = 4096;
/// A disc's radius over that of its surfel's area.
const WIDE: f32 = 1.5;

/// The share of the surface in [0, 1]; 1 where there is none.
pub fn coverage(lit: &Lit, surfels: &Surfels, grid: &SurfelGrid) -> f64 {
    let probes = sites(lit.tracer.scene, lit.tracer.frame, PROBES);
    let covered = probes.iter().filter(|site| {
        let probe = place(lit.tracer, site);
        let near = grid.nearest_of_any(surfels, probe.position, probe.normal);
        near.is_some_and(|s| {
            let surfel = &surfels.all[s as usize];
            surfel.position.distance(probe.position) <= WIDE * (surfel.area / PI).sqrt()
        })
    });
    match probes.len() {
        0 => 1.0,
        n => covered.count() as f64 / n as f64,
    }
}
