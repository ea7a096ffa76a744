//! [`Lamps`]: what lights a picture in black and white.
//!
//! Lamps without size, and small lamps that stand for what shines. Near what shines, and near bulbs, these give
//! too little or too much, in blots: there its illuminance has a closed form, and the small lamps tell how much of it
//! arrives.

use crate::glow::{Cluster, Glow};
use crate::light::Lamp;
use chiaro_basis::math::Vec3;
use chiaro_image::colour::luminance;

/// Surfaces that shine stand as so many small lamps, at most.
const PATCHES: usize = 24;
/// They are left out beside lamps that are this many times as strong.
const OUTSHONE: f32 = 1000.0;

/// The lamps of a picture.
#[derive(Clone, Debug, Default)]
pub struct Lamps {
    /// Those without size, then those that stand for what shines.
    all: Vec<Lamp>,
    /// How many have no size.
    single: usize,
    /// What shines.
    glow: Glow,
    /// Its parts that the small lamps stand for.
    parts: Vec<Cluster>,
}

impl Lamps {
    /// Lamps without size alone.
    pub fn of(all: Vec<Lamp>) -> Self {
        Self { single: all.len(), all, ..Self::default() }
    }

    /// The same, and what shines, unless they outshine it.
    pub fn with(self, glow: Glow) -> Self {
        let strongest = self.all.iter().map(|l| l.strength).fold(0.0, f32::max);
        let mut parts = glow.clusters(PATCHES);
        parts.retain(|c| c.lamp.strength * OUTSHONE > strongest);
        let glow = if parts.is_empty() { Glow::default() } else { glow };
        let all = self.all.into_iter().chain(parts.iter().map(|c| c.lamp)).collect();
        Self { all, glow, parts, ..self }
    }

    /// All of them.
    pub fn all(&self) -> &[Lamp] {
        &self.all
    }

    /// Those without size.
    pub fn single(&self) -> &[Lamp] {
        &self.all[..self.single]
    }

    /// What shines; empty if it is outshone.
    pub fn glow(&self) -> &Glow {
        &self.glow
    }

    /// Illuminance by what shines if nothing stands between, lux, where the small lamps are not enough; and how far
    /// they are not, from 0 to 1.
    pub(crate) fn beside(&self, point: Vec3, normal: Vec3) -> Option<(f32, f32)> {
        let share = self.parts.iter().map(|c| c.nearness(point)).fold(0.0, f32::max);
        let open = (share > 0.0).then(|| self.glow.open_irradiance(point, normal))??;
        Some((luminance(open), share))
    }
}
