//! More bounces: surfels are receivers of each other's light.
//!
//! Each living side casts cosine-weighted rays once and remembers the surfels that
//! they meet; then a bounce is a sum over those, and a mean over the surfels around. The thesis gathers at every
//! surfel by the tree; rays cost less there, and the sum over many surfels leaves no noise that could be seen. Along
//! creases near rays see one or two surfels alone: there the mean keeps single surfels from being seen.

use crate::estimate::{Estimate, settled};
use crate::grid::SurfelGrid;
use crate::links::Links;
use crate::surfel::{Lit, Surfel, Surfels};
use chiaro_basis::{Result, Run};
use rayon::prelude::*;
use std::f32::consts::PI;

/// Irradiance by light that was reflected before, of each surfel's two sides.
pub type Indirect = Vec<[[f32; 3]; 2]>;

/// Cosine between normals below which surfels do not face the same way.
const ALIGNED: f32 = 0.9;
/// Distance from a surfel's plane, in the grid's reach, from which on others lie in another surface.
const ASIDE: f32 = 0.25;

/// Adds the light of up to `times` further reflections to the surfels' radiance; returns the
/// irradiance that it came from.
pub fn bounce(
    lit: &Lit,
    surfels: &mut Surfels,
    grid: &SurfelGrid,
    times: u32,
    rays: u32,
    run: &Run,
) -> Result<Indirect> {
    let mut total: Indirect = vec![[[0.0; 3]; 2]; surfels.all.len()];
    if times == 0 {
        return Ok(total);
    }
    let mut last: Vec<[[f32; 3]; 2]> = surfels.all.iter().map(|s| s.radiance).collect();
    let links = Links::of(lit, surfels, grid, (&last, rays), run)?;
    for _ in 0..times {
        run.check()?;
        let all = (0..last.len()).into_par_iter();
        let own: Vec<Estimate> = all.map(|index| links.estimate(index, &last)).collect();
        let irradiance = settled(surfels, grid, &own);
        last = surfels
            .all
            .par_iter()
            .zip(&irradiance)
            .map(|(s, e)| e.map(|e| std::array::from_fn(|c| s.albedo[c] * e[c] / PI)))
            .collect();
        for (i, surfel) in surfels.all.iter_mut().enumerate() {
            for side in 0..2 {
                for c in 0..3 {
                    surfel.radiance[side][c] += last[i][side][c];
                    total[i][side][c] += irradiance[i][side][c];
                }
            }
        }
    }
    Ok(total)
}

/// How much a surfel so far away, squared, counts in the mean over what is around another: nothing where it does not lie
/// in the same plane.
pub(crate) fn likeness(own: &Surfel, other: &Surfel, distance2: f32, reach: f32) -> f32 {
    let cosine = other.normal.dot(own.normal);
    let aside = (other.position - own.position).dot(own.normal).abs();
    (1.0 - distance2 / reach.powi(2))
        * ((cosine.abs() - ALIGNED) / (1.0 - ALIGNED)).max(0.0)
        * (1.0 - aside / (ASIDE * reach)).max(0.0)
}

/// The mean over the living sides around each, as far as they face the same way and `alike` has it of both, each a
/// surfel and its side.
pub(crate) fn smoothed(
    surfels: &Surfels,
    grid: &SurfelGrid,
    irradiance: &Indirect,
    alike: impl Fn((usize, usize), (usize, usize)) -> bool + Sync,
) -> Indirect {
    let around = |(index, own): (usize, &Surfel)| {
        let (mut sums, mut weights) = ([[0.0; 3]; 2], [0.0; 2]);
        grid.each_near(own.position, |other, distance2| {
            let s = &surfels.all[other];
            let weight = likeness(own, s, distance2, grid.reach());
            let cosine = s.normal.dot(own.normal);
            for side in 0..2 {
                let its = if cosine < 0.0 { 1 - side } else { side };
                if weight > 0.0 && s.alive[its] && alike((index, side), (other, its)) {
                    weights[side] += weight;
                    (0..3).for_each(|c| sums[side][c] += weight * irradiance[other][its][c]);
                }
            }
        });
        std::array::from_fn(|side| match own.alive[side] && weights[side] > 0.0 {
            true => sums[side].map(|s| s / weights[side]),
            false => irradiance[index][side],
        })
    };
    surfels.all.par_iter().enumerate().map(around).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use chiaro_basis::math::vec3;
    use chiaro_basis::random::{r2, unit};

    #[test]
    fn single_surfels_of_a_corner_are_smoothed_on_their_own_wall_and_side() {
        let surfel = |i: u64| {
            let [u, v] = r2(i / 2);
            let (position, normal) = if i.is_multiple_of(2) {
                (vec3(u, 0.0, v), vec3(0.0, 1.0, 0.0))
            } else {
                (vec3(u, v, 0.0), vec3(0.0, 0.0, 1.0))
            };
            Surfel { position, normal, alive: [true; 2], ..Surfel::default() }
        };
        let all: Vec<Surfel> = (0..4000).map(surfel).collect();
        let surfels =
            Surfels { all, spacing: (2.0f32 / 4000.0).sqrt(), uneven: false, covered: Vec::new() };
        let grid = SurfelGrid::new(&surfels);
        // Floor 1, wall 3, with noise; their backs 10.
        let mean = |i: usize| if i.is_multiple_of(2) { 1.0 } else { 3.0 };
        let noisy = |i: usize| [[mean(i) + unit(9, i as u64) - 0.5; 3], [10.0; 3]];
        let own: Indirect = (0..4000).map(noisy).collect();
        let after = smoothed(&surfels, &grid, &own, |_, _| true);
        let deviation = |e: &Indirect| {
            let squares = e.iter().enumerate().map(|(i, e)| (e[0][0] - mean(i)).powi(2));
            (squares.sum::<f32>() / 4000.0).sqrt()
        };
        assert!(deviation(&after) < 0.5 * deviation(&own), "{}", deviation(&after));
        let total = |e: &Indirect| e.iter().map(|e| e[0][0]).sum::<f32>();
        assert!((total(&after) / total(&own) - 1.0).abs() < 0.005);
        assert!(after.iter().all(|e| (e[1][0] - 10.0).abs() < 1e-4));
    }
}
