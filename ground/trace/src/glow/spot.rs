//! [`Spot`]s: the points on what shines that small lamps stand for.
//!
//! Where textures shine, points are drawn anew by what the texture shows there: a screen's bright half has the more of
//! them, and each its own colour.

use super::Glow;
use crate::surface::Surfaces;
use crate::tracer::{Hit, Tracer};
use chiaro_basis::math::Vec3;
use chiaro_basis::random;
use chiaro_image::colour::luminance;

/// Points that are drawn at most, and points that are looked at in textures for each.
pub(super) const MOST: usize = 8192;
const LOOKED_AT: usize = 4;
/// Strips of a triangle.
const STRIPS: f32 = 64.0;

/// A point on what shines; all have the same power.
#[derive(Clone, Copy, Debug)]
pub(super) struct Spot {
    pub(super) position: Vec3,
    /// Index of its triangle.
    pub(super) triangle: usize,
    /// Radiance over its luminance.
    pub(super) colour: [f32; 3],
}

/// The spots of textures.
#[derive(Clone, Debug)]
pub(super) struct Textured {
    spots: Vec<Spot>,
    /// Power of all of them over that by the triangles' mean radiance.
    scale: f32,
}

impl Textured {
    /// Those of what shines, if any of it is textured.
    pub(super) fn of(glow: &Glow, tracer: &Tracer, surfaces: &Surfaces) -> Option<Self> {
        if !glow.triangles.iter().any(|t| t.textured) {
            return None;
        }
        let area: f32 = glow.triangles.iter().map(|t| t.area).sum();
        let footprint = (area / MOST as f32).sqrt();
        let look = |i: usize| {
            let [u, v] = random::r2(i as u64);
            let point = glow.point([(i as f32 + 0.5) / (MOST * LOOKED_AT) as f32, u, v])?;
            let t = &glow.triangles[point.triangle];
            let hit = Hit { t: 0.0, object: t.object, face: t.face, b: point.b };
            let radiance = match t.textured {
                true => surfaces.emission(tracer, &hit, footprint),
                false => t.radiance,
            };
            let weight = luminance(radiance) / luminance(t.radiance);
            let strip = (point.triangle, (point.b[0] * STRIPS) as u32);
            Some((strip, point.b[1], Spot::of(point.position, point.triangle, radiance), weight))
        };
        let mut looked: Vec<_> = (0..MOST * LOOKED_AT).filter_map(look).collect();
        // Side by side in strips they differ little, so that each colour has its share of the drawn.
        looked.sort_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)));
        let looked: Vec<(Spot, f32)> = looked.into_iter().map(|(_, _, s, w)| (s, w)).collect();
        let total: f64 = looked.iter().map(|(_, w)| f64::from(*w)).sum();
        let scale = (total / looked.len().max(1) as f64) as f32;
        (total > 0.0).then(|| Self { spots: resampled(&looked, total), scale })
    }
}

/// One of every so much weight, in order.
fn resampled(looked: &[(Spot, f32)], total: f64) -> Vec<Spot> {
    let step = total / MOST as f64;
    let (mut spots, mut sum) = (Vec::with_capacity(MOST), 0.0);
    for (spot, weight) in looked {
        sum += f64::from(*weight);
        while spots.len() < MOST && (spots.len() as f64 + 0.5) * step < sum {
            spots.push(*spot);
        }
    }
    spots
}

impl Spot {
    fn of(position: Vec3, triangle: usize, radiance: [f32; 3]) -> Self {
        let y = luminance(radiance).max(f32::MIN_POSITIVE);
        Self { position, triangle, colour: radiance.map(|c| c / y) }
    }
}

impl Glow {
    /// So many points, spread by power, and the power of one.
    pub(super) fn spots(&self, count: usize) -> (Vec<Spot>, f32) {
        let share = (self.power / count as f64) as f32;
        if let Some(textured) = &self.texture_spots {
            let spots = textured.spots.iter().step_by(MOST / count).copied().collect();
            return (spots, textured.scale * share);
        }
        let spot = |i: usize| {
            let [u, v] = random::r2(i as u64);
            let point = self.point([(i as f32 + 0.5) / count as f32, u, v])?;
            let radiance = self.triangles[point.triangle].radiance;
            Some(Spot::of(point.position, point.triangle, radiance))
        };
        ((0..count).filter_map(spot).collect(), share)
    }
}
