//! More bounces: surfels are receivers of each other's light.
//!
//! Each living side casts a fixed set of cosine-weighted rays once and remembers the surfels that
//! they meet; then a bounce is a sum over those. The thesis gathers at every surfel by the tree;
//! rays cost less there, and the sum over many surfels leaves no noise that could be seen.

use crate::grid::SurfelGrid;
use crate::surfel::{Lit, Surfels};
use chiaro_basis::{Result, Run};
use chiaro_trace::{Ray, Sequence, Sides, cosine_direction};
use rayon::prelude::*;
use std::f32::consts::PI;

/// Irradiance by light that was reflected before, of each surfel's two sides.
pub type Indirect = Vec<[[f32; 3]; 2]>;

/// Nothing met.
const NONE: u32 = u32::MAX;

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
    let met = links(lit, surfels, grid, rays, run)?;
    let mut last: Vec<[[f32; 3]; 2]> = surfels.all.iter().map(|s| s.radiance).collect();
    for _ in 0..times {
        run.check()?;
        let irradiance: Indirect =
            met.par_chunks(2 * rays as usize).map(|links| gathered(links, &last, rays)).collect();
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

/// For each surfel and side the sides that its rays meet: twice the surfel's index plus the side.
fn links(
    lit: &Lit,
    surfels: &Surfels,
    grid: &SurfelGrid,
    rays: u32,
    run: &Run,
) -> Result<Vec<u32>> {
    let mut met = vec![NONE; surfels.all.len() * 2 * rays as usize];
    met.par_chunks_mut(2 * rays as usize).enumerate().try_for_each(|(index, links)| {
        run.check()?;
        let surfel = &surfels.all[index];
        let sequence = Sequence::new(0x5000_0000 + index as u64);
        for side in (0..2).filter(|s| surfel.alive[*s]) {
            let normal = if side == 0 { surfel.normal } else { -surfel.normal };
            let origin = surfel.position + normal * lit.tracer.offset();
            for k in 0..rays {
                let direction = cosine_direction(normal, sequence.point(k, side as u32));
                let ray = Ray { origin, direction, t_max: f32::INFINITY };
                let Some(hit) = lit.tracer.hit(&ray, Sides::Both) else { continue };
                let [a, b, c] = lit.tracer.corners(hit.object, hit.face);
                let face = (b - a).cross(c - a).normalize_or_zero();
                let facing = if face.dot(direction) > 0.0 { -face } else { face };
                let point = origin + direction * hit.t;
                if let Some((k2, s2)) = grid.nearest(surfels, point, facing) {
                    links[side * rays as usize + k as usize] = 2 * k2 + s2 as u32;
                }
            }
        }
        Ok(())
    })?;
    Ok(met)
}

/// Irradiance of a surfel's two sides: pi times the mean radiance that their rays meet.
fn gathered(links: &[u32], radiance: &[[[f32; 3]; 2]], rays: u32) -> [[f32; 3]; 2] {
    let mut sum = [[0.0; 3]; 2];
    for (k, &link) in links.iter().enumerate().filter(|(_, l)| **l != NONE) {
        let from = radiance[link as usize / 2][link as usize % 2];
        let side = k / rays as usize;
        (0..3).for_each(|c| sum[side][c] += PI / rays as f32 * from[c]);
    }
    sum
}
