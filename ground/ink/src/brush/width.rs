//! [`Hand`]: how wide a line is along a stroke: pressure, tapers, swell, light, nib.
//!
//! Pressure is noise in u, so it moves with the line; tapers and swell are measured in the picture,
//! from the ends that are seen.

use super::knob::Brush;
use super::spine::Spine;
use chiaro_basis::math::Vec2;

/// Shares of a stroke's length that both tapers may take.
const TAPERED: f32 = 0.9;

/// The width of a brush along one spine.
pub(super) struct Hand<'a> {
    brush: &'a Brush,
    spine: &'a Spine,
    lengths: Vec<f32>,
    /// Lengths of the tapers at both ends.
    tapers: [f32; 2],
    /// Of the width, on a short stroke.
    short: f32,
}

impl<'a> Hand<'a> {
    pub(super) fn new(brush: &'a Brush, spine: &'a Spine) -> Self {
        let lengths = spine.lengths();
        let total = lengths.last().copied().unwrap_or(0.0);
        let wanted = [brush.taper, brush.taper * brush.taper_end];
        let fits = (TAPERED * total / (wanted[0] + wanted[1]).max(1e-6)).min(1.0);
        let tapers = if spine.closed { [0.0; 2] } else { wanted.map(|t| t * fits) };
        let short = (total / (brush.slender * brush.width).max(1e-6)).min(1.0);
        Self { brush, spine, lengths, tapers, short }
    }

    /// The same hand on a piece of its spine, with tapers of the piece's own.
    pub(super) fn on<'b>(&self, piece: &'b Spine) -> Hand<'b>
    where
        'a: 'b,
    {
        Hand { short: self.short, ..Hand::new(self.brush, piece) }
    }

    /// The whole length in pixels.
    pub(super) fn total(&self) -> f32 {
        self.lengths.last().copied().unwrap_or(0.0)
    }

    /// Half the width at point `i` of the spine, pixels.
    pub(super) fn half(&self, i: usize) -> f32 {
        self.half_at(self.spine.knots[i].u, self.lengths[i], self.spine.tangent(i))
    }

    /// The same for any point: its u, its length from the start, and the direction there.
    pub(super) fn half_at(&self, u: f64, length: f32, tangent: Vec2) -> f32 {
        let b = self.brush;
        0.5 * self.short
            * b.width
            * self.pressure(u)
            * self.ends(length)
            * self.light(tangent)
            * self.nib(tangent)
    }

    fn pressure(&self, u: f64) -> f32 {
        let b = self.brush;
        let wave = self.spine.axis.wave(u, f64::from(b.pressure_length), 1);
        1.0 - b.pressure * (0.5 - 0.5 * wave)
    }

    /// Tapers and swell.
    fn ends(&self, length: f32) -> f32 {
        if self.spine.closed {
            return 1.0;
        }
        let b = self.brush;
        let total = self.total();
        let ramp = |from_end: f32, taper: f32| match taper > 0.0 {
            true => {
                let t = (from_end / taper).clamp(0.0, 1.0);
                b.tip + (1.0 - b.tip) * t * (2.0 - t)
            }
            false => 1.0,
        };
        let middle = (std::f32::consts::PI * length / total.max(1e-6)).sin().max(0.0);
        let swell = 1.0 - b.swell * (1.0 - middle);
        ramp(length, self.tapers[0]).min(ramp(total - length, self.tapers[1])) * swell
    }

    /// Heavier where the outside, on the right of the line, looks away from the light.
    fn light(&self, tangent: Vec2) -> f32 {
        let b = self.brush;
        let light = Vec2::from_angle(-b.shade_angle.to_radians());
        let away = 0.5 - 0.5 * tangent.perp().dot(light);
        1.0 - b.shade * (1.0 - away * away * (3.0 - 2.0 * away))
    }

    fn nib(&self, tangent: Vec2) -> f32 {
        let b = self.brush;
        let edge = Vec2::from_angle(-b.nib_angle.to_radians());
        let across = tangent.perp_dot(edge).abs();
        1.0 - b.nib * (1.0 - across)
    }
}
