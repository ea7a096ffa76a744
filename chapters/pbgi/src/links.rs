//! [`Links`]: the sides of surfels that each side sees, by rays cast once for all bounces.
//!
//! Most sides are told enough by a few rays and by the mean of those around. Where a small bright thing is seen, one
//! ray in a hundred meets it, and the side of which one of sixteen does is six times too bright: on steps and ledges,
//! where few lie in one plane, it would stand out. There all near one whose rays tell too little cast more,
//! whether theirs met it or not, so that what is seen by chance does not decide alone.

use crate::bounce::likeness;
use crate::estimate::Estimate;
use crate::grid::SurfelGrid;
use crate::surfel::{Lit, Surfel, Surfels};
use chiaro_basis::{Result, Run};
use chiaro_image::colour::luminance;
use chiaro_trace::{Ray, Sequence, Sides, cosine_direction};
use rayon::prelude::*;
use std::f32::consts::{FRAC_1_PI, PI};
use std::ops::Range;

/// What leaves each surfel's two sides, linear RGB.
pub(crate) type Radiance = [[[f32; 3]; 2]];

/// For each surfel and side the sides that its rays meet: twice the surfel's index plus the side.
pub(crate) struct Links {
    /// Of each surfel, side by side.
    few: Vec<u32>,
    /// Of those that cast more.
    more: Vec<u32>,
    /// Which of those a surfel is; [`NONE`] of others.
    more_from: Vec<u32>,
    rays: usize,
}

/// Nothing met.
const NONE: u32 = u32::MAX;
/// Rays tell too little of a side whose estimate deviates by a larger share of all that it reflects.
const UNSURE: f32 = 0.35;
/// The mean of fewer than about so many sides is not sure either.
const LONELY: f32 = 5.0;
/// So many times as many rays are cast then.
const MORE: usize = 8;

impl Links {
    /// Casts rays from each living side, and more where few tell too little of a radiance.
    pub(crate) fn of(
        lit: &Lit,
        surfels: &Surfels,
        grid: &SurfelGrid,
        (radiance, rays): (&Radiance, u32),
        run: &Run,
    ) -> Result<Self> {
        let rays = rays as usize;
        let all: Vec<usize> = (0..surfels.all.len()).collect();
        let few = cast((lit, surfels, grid), &all, 0..rays, run)?;
        let mut links = Self { few, more: Vec::new(), more_from: vec![NONE; all.len()], rays };
        let unsure = links.unsure(surfels, grid, radiance);
        for (k, index) in unsure.iter().enumerate() {
            links.more_from[*index] = k as u32;
        }
        links.more = cast((lit, surfels, grid), &unsure, rays..MORE * rays, run)?;
        Ok(links)
    }

    /// What a surfel's sides receive of a radiance: pi times what their rays meet, on the mean.
    pub(crate) fn estimate(&self, index: usize, radiance: &Radiance) -> Estimate {
        let mut all = Estimate::default();
        let from = |&link: &u32| match link {
            NONE => [0.0; 3],
            met => radiance[met as usize / 2][met as usize % 2].map(|r| PI * r),
        };
        for side in 0..2 {
            let (few, more) = self.sides(index, side);
            let irradiance: Vec<[f32; 3]> = few.iter().chain(more).map(from).collect();
            all.set(side, irradiance.iter().map(|e| (*e, *e)));
        }
        all
    }

    /// The links of a surfel's side.
    fn sides(&self, index: usize, side: usize) -> (&[u32], &[u32]) {
        let start = (2 * index + side) * self.rays;
        let few = &self.few[start..start + self.rays];
        let each = (MORE - 1) * self.rays;
        match self.more_from[index] {
            NONE => (few, &[]),
            k => (few, &self.more[(2 * k as usize + side) * each..][..each]),
        }
    }

    /// The surfels near one of which few rays tell too little, as far as few lie in one plane with them.
    fn unsure(&self, surfels: &Surfels, grid: &SurfelGrid, radiance: &Radiance) -> Vec<usize> {
        let all = || (0..surfels.all.len()).into_par_iter();
        let is_unsure = |index: usize| {
            let estimate = self.estimate(index, radiance);
            let reflects = luminance(surfels.all[index].albedo) * FRAC_1_PI;
            (0..2).any(|side| {
                let [mean, deviation] = estimate.luminance(side).map(|e| reflects * e);
                deviation > UNSURE * (luminance(radiance[index][side]) + mean)
            })
        };
        let unsure: Vec<bool> = all().map(is_unsure).collect();
        let is_lonely = |index: &usize| {
            let own = &surfels.all[*index];
            let (mut any, mut sum, mut squares) = (false, 0.0, 0.0);
            grid.each_near(own.position, |other, distance2| {
                any |= unsure[other];
                let weight = likeness(own, &surfels.all[other], distance2, grid.reach());
                (sum, squares) = (sum + weight, squares + weight * weight);
            });
            any && sum * sum < LONELY * squares
        };
        all().filter(is_lonely).collect()
    }
}

/// What the rays of these numbers of some surfels' sides meet.
fn cast(
    (lit, surfels, grid): (&Lit, &Surfels, &SurfelGrid),
    of: &[usize],
    numbers: Range<usize>,
    run: &Run,
) -> Result<Vec<u32>> {
    let mut met = vec![NONE; 2 * numbers.len() * of.len()];
    met.par_chunks_mut((2 * numbers.len()).max(1)).zip(of).try_for_each(|(links, &index)| {
        run.check()?;
        let surfel = &surfels.all[index];
        let sequence = Sequence::new(0x5000_0000 + index as u64);
        for (side, links) in links.chunks_mut(numbers.len()).enumerate() {
            if surfel.alive[side] {
                for (link, k) in links.iter_mut().zip(numbers.clone()) {
                    let point = sequence.point(k as u32, side as u32);
                    *link = meet((lit, surfels, grid), surfel, side, point).unwrap_or(NONE);
                }
            }
        }
        Ok(())
    })?;
    Ok(met)
}

/// What the ray of a side by two numbers meets.
fn meet(
    (lit, surfels, grid): (&Lit, &Surfels, &SurfelGrid),
    surfel: &Surfel,
    side: usize,
    point: [f32; 2],
) -> Option<u32> {
    let normal = if side == 0 { surfel.normal } else { -surfel.normal };
    let origin = surfel.position + normal * lit.tracer.offset();
    let direction = cosine_direction(normal, point);
    let hit = lit.tracer.hit(&Ray { origin, direction, t_max: f32::INFINITY }, Sides::Both)?;
    let [a, b, c] = lit.tracer.corners(hit.object, hit.face);
    let face = (b - a).cross(c - a).normalize_or_zero();
    let facing = if face.dot(direction) > 0.0 { -face } else { face };
    let (index, side) = grid.nearest(surfels, origin + direction * hit.t, facing)?;
    Some(2 * index + side as u32)
}

#[cfg(test)]
mod tests {
    use super::*;
    use chiaro_basis::math::vec3;
    use chiaro_basis::random::{r2, unit};

    const RAYS: usize = 16;

    /// Surfels of a floor and of a narrow step above it; of the rays of all one in forty meets the last, which is bright.
    fn stairs() -> (Surfels, Links, Vec<[[f32; 3]; 2]>) {
        let place = |i: u64| match r2(i) {
            [u, v] if i < 2000 => vec3(u, 0.0, v),
            [u, _] => vec3(u, 0.5, 2.0),
        };
        let surfel = |position| Surfel {
            position,
            normal: chiaro_basis::math::Vec3::Y,
            alive: [true; 2],
            albedo: [1.0; 3],
            ..Surfel::default()
        };
        let mut all: Vec<Surfel> = (0..2060).map(|i| surfel(place(i))).collect();
        all.push(surfel(vec3(9.0, 9.0, 9.0)));
        let met = |i: usize| if unit(3, i as u64) < 0.025 { 2 * 2060 } else { 0 };
        let few = (0..2 * RAYS * all.len()).map(met).collect();
        let more_from = vec![NONE; all.len()];
        let mut radiance = vec![[[0.01; 3]; 2]; all.len()];
        radiance[2060] = [[1.0; 3]; 2];
        let spacing = (1.0f32 / 2000.0).sqrt();
        let surfels = Surfels { all, spacing, uneven: false, covered: Vec::new() };
        (surfels, Links { few, more: Vec::new(), more_from, rays: RAYS }, radiance)
    }

    #[test]
    fn rays_are_added_on_a_step_where_few_met_something_bright() {
        let (surfels, links, mut radiance) = stairs();
        let grid = SurfelGrid::new(&surfels);
        let unsure = links.unsure(&surfels, &grid, &radiance);
        let on_step = unsure.iter().filter(|i| (2000..2060).contains(*i)).count();
        assert!(on_step > 45, "{on_step}");
        assert!(unsure.len() - on_step < 2000 * on_step / 60, "{} {on_step}", unsure.len());
        radiance[2060] = radiance[0];
        assert!(links.unsure(&surfels, &grid, &radiance).is_empty());
    }

    #[test]
    fn an_estimate_is_the_mean_of_few_and_more() {
        let (_, mut links, radiance) = stairs();
        links.few[3 * 2 * RAYS..4 * 2 * RAYS].fill(0);
        let few = links.estimate(3, &radiance).irradiance()[1][0];
        links.more_from[3] = 0;
        links.more = vec![2 * 2060; 2 * (MORE - 1) * RAYS];
        let both = links.estimate(3, &radiance).irradiance()[1][0];
        assert!((few - 0.01 * PI).abs() < 1e-6, "{few}");
        assert!((both - PI * (0.01 + (MORE - 1) as f32) / MORE as f32).abs() < 1e-4, "{both}");
    }
}
