//! [`Texel`]: what covers it, nearest first, and what is seen behind that.

use crate::cut::Splat;
use chiaro_basis::math::{Vec3, smoothstep};

/// One texel.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Texel {
    /// Radiance times coverage.
    pub light: [f32; 3],
    /// The share that is covered, in [0, 1].
    pub coverage: f32,
    /// Distance times coverage.
    pub distance: f32,
    /// Mean normal times coverage.
    pub axis: Vec3,
    /// Where in it what is covered lies, from its middle, in texels, times coverage.
    pub place: [f32; 2],
    /// The share in which something nearer than the near field's radius is.
    pub near: f32,
    /// Of all that, what lies far behind the rest.
    pub back: Back,
}

/// What a texel shows through the gaps between splats, or beside what is nearer.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Back {
    /// Radiance times coverage.
    pub light: [f32; 3],
    /// The share that is covered.
    pub coverage: f32,
    /// Distance times coverage.
    pub distance: f32,
}

/// What is so many times as far as the rest lies behind it.
const BEHIND: f32 = 1.5;
/// What is free before it, less than which is ever less of a gap: splats that fill a texel leave cracks.
const CRACK: [f32; 2] = [0.0, 0.4];

impl Texel {
    /// Covers a share of it with a splat behind all that are there, at a place from its middle in texels.
    pub(super) fn cover(&mut self, splat: &Splat, share: f32, place: [f32; 2]) {
        if splat.marks {
            self.near = (self.near + share).min(1.0);
            return;
        }
        let behind = splat.distance * self.coverage > BEHIND * self.distance;
        let free = if behind { self.gap() - self.back.coverage } else { 1.0 - self.coverage };
        let share = share.min(free);
        if share > 0.0 {
            if behind {
                self.back.coverage += share;
                self.back.distance += share * splat.distance;
                (0..3).for_each(|c| self.back.light[c] += share * splat.radiance[c]);
            }
            self.coverage += share;
            self.distance += share * splat.distance;
            self.axis += splat.axis * share;
            (0..2).for_each(|i| self.place[i] += share * place[i]);
            (0..3).for_each(|c| self.light[c] += share * splat.radiance[c]);
        }
    }

    /// The share through which what lies far behind is seen.
    fn gap(&self) -> f32 {
        let free = 1.0 - (self.coverage - self.back.coverage);
        free * smoothstep(CRACK, free)
    }

    /// The mean normal of what is there; nothing where nothing is.
    pub fn mean_axis(&self) -> Vec3 {
        if self.coverage > 0.0 { self.axis / self.coverage } else { Vec3::ZERO }
    }

    /// The mean distance of what is there; infinite where nothing is.
    pub fn mean_distance(&self) -> f32 {
        if self.coverage > 0.0 { self.distance / self.coverage } else { f32::INFINITY }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cracks_show_nothing_and_openings_show_what_lies_behind() {
        let seen = |share: f32| {
            let mut texel = Texel::default();
            for (share, distance, light) in [(share, 1.0, 1.0), (1.0, 9.0, 100.0)] {
                let (direction, axis) = (Vec3::Z, Vec3::NEG_Z);
                let radiance = [light; 3];
                let splat = Splat { direction, distance, radiance, axis, ..Splat::default() };
                texel.cover(&splat, share, [0.0; 2]);
            }
            texel.light[0] / texel.coverage
        };
        assert!(seen(0.95) < 1.5, "{}", seen(0.95));
        assert!((seen(0.6) / 40.6 - 1.0).abs() < 1e-4, "{}", seen(0.6));
        assert!((1..100).all(|k| seen(0.01 * k as f32) < seen(0.01 * (k - 1) as f32)));
    }
}
