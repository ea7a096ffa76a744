//! [`Estimate`]: what a surfel's sides receive by a few rays, and how it is smoothed.
//!
//! A few rays tell little of light of which little is seen: under arcades one in thirty finds the sky, and single
//! surfels would be thirty times too bright. So each side takes the mean of those around that face the same way, as
//! far as their samples may come from the same light: a floor on both sides of a wall is not smoothed across.

use crate::bounce::{Indirect, smoothed};
use crate::grid::SurfelGrid;
use crate::surfel::Surfels;
use chiaro_image::colour::luminance;

/// Means over what is around, one after the other.
const SMOOTHINGS: u32 = 2;
/// Sides differ when their irradiances do by more than so many standard deviations of the difference.
const DIFFERENT: f32 = 2.0;

/// Irradiance of both sides of a surfel, by a few rays each.
#[derive(Clone, Copy, Debug, Default)]
pub struct Estimate {
    irradiance: [[f32; 3]; 2],
    /// Standard deviations of its luminance.
    deviation: [f32; 2],
}

impl Estimate {
    /// Takes the samples of a side: what arrives, and what would if nothing hid it.
    pub(crate) fn set(
        &mut self,
        side: usize,
        samples: impl ExactSizeIterator<Item = ([f32; 3], [f32; 3])>,
    ) {
        let count = samples.len().max(1) as f32;
        let (mut sum, mut squares, mut open) = ([0.0; 3], 0.0, 0.0);
        for (arrives, unhidden) in samples {
            (0..3).for_each(|c| sum[c] += arrives[c]);
            squares += luminance(arrives).powi(2);
            open += luminance(unhidden);
        }
        let mean = sum.map(|s| s / count);
        let variance = (squares / count - luminance(mean).powi(2)).max(0.0) / count;
        // Where all or none arrives the next sample may differ.
        let least = open / (count * count);
        self.irradiance[side] = mean;
        self.deviation[side] = variance.sqrt().max(least);
    }

    /// Linear RGB of both sides.
    pub fn irradiance(&self) -> [[f32; 3]; 2] {
        self.irradiance
    }

    /// Which sides it reaches.
    pub(crate) fn is_lit(&self) -> [bool; 2] {
        self.irradiance.map(|e| e != [0.0; 3])
    }

    /// The luminance of a side's irradiance and its standard deviation.
    pub(crate) fn luminance(&self, side: usize) -> [f32; 2] {
        [luminance(self.irradiance[side]), self.deviation[side]]
    }

    fn may_equal(&self, side: usize, other: &Self, its: usize) -> bool {
        let difference = luminance(self.irradiance[side]) - luminance(other.irradiance[its]);
        let variance = self.deviation[side].powi(2) + other.deviation[its].powi(2);
        difference * difference <= DIFFERENT * DIFFERENT * variance
    }
}

/// What the sides of surfels receive without its noise; nothing of no estimates.
pub fn settled(surfels: &Surfels, grid: &SurfelGrid, all: &[Estimate]) -> Indirect {
    if all.is_empty() {
        return Vec::new();
    }
    let own: Indirect = all.iter().map(Estimate::irradiance).collect();
    let alike = |a: (usize, usize), b: (usize, usize)| all[a.0].may_equal(a.1, &all[b.0], b.1);
    (0..SMOOTHINGS).fold(own, |e, _| smoothed(surfels, grid, &e, alike))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surfel::Surfel;
    use chiaro_basis::math::Vec3;
    use chiaro_basis::random::{r2, unit};

    const SAMPLES: u64 = 16;

    /// Estimate of which so much arrives, by rays that are each free or not.
    fn seen(share: f32, number: u64) -> Estimate {
        let mut sky = Estimate::default();
        let sample = |k| if unit(k, number) < share { [1.0; 3] } else { [0.0; 3] };
        let samples: Vec<_> = (0..SAMPLES).map(|k| (sample(k), [1.0; 3])).collect();
        (0..2).for_each(|side| sky.set(side, samples.iter().copied()));
        sky
    }

    /// A floor of one unit with so much of the sky at each x.
    fn settled_floor(share: impl Fn(f32) -> f32) -> Vec<(f32, f32, f32)> {
        let position = |i| Vec3::new(r2(i)[0], 0.0, r2(i)[1]);
        let surfel = |i| Surfel {
            position: position(i),
            normal: Vec3::Y,
            alive: [true; 2],
            ..Surfel::default()
        };
        let all: Vec<Surfel> = (0..4000).map(surfel).collect();
        let surfels =
            Surfels { all, spacing: (1.0f32 / 4000.0).sqrt(), uneven: false, covered: Vec::new() };
        let sky: Vec<Estimate> = (0..4000).map(|i| seen(share(position(i).x), i)).collect();
        let after = settled(&surfels, &SurfelGrid::new(&surfels), &sky);
        let told = |i: usize| (position(i as u64).x, sky[i].irradiance[0][0], after[i][0][0]);
        (0..4000).map(told).collect()
    }

    #[test]
    fn single_surfels_that_found_a_gap_do_not_stand_out_and_no_light_is_lost() {
        let floor = settled_floor(|_| 0.03);
        let deviation = |of: fn(&(f32, f32, f32)) -> f32| {
            (floor.iter().map(|f| (of(f) - 0.03).powi(2)).sum::<f32>() / 4000.0).sqrt()
        };
        assert!(deviation(|f| f.2) < 0.4 * deviation(|f| f.1), "{}", deviation(|f| f.2));
        let total = |of: fn(&(f32, f32, f32)) -> f32| floor.iter().map(of).sum::<f32>();
        assert!((total(|f| f.2) / total(|f| f.1) - 1.0).abs() < 0.05);
    }

    #[test]
    fn what_lies_under_a_roof_is_not_lit_by_what_lies_beside_it() {
        for (x, _, after) in settled_floor(|x| if x < 0.5 { 0.0 } else { 0.9 }) {
            assert!(if x < 0.5 { after == 0.0 } else { after > 0.6 }, "{x}: {after}");
        }
    }
}
