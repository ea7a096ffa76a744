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
        let mut wanted = [brush.taper, brush.taper * brush.taper_end];
        wanted.iter_mut().zip(spine.goes_on).filter(|w| w.1).for_each(|w| *w.0 = 0.0);
        let fits = (TAPERED * total / (wanted[0] + wanted[1]).max(1e-6)).min(1.0);
        let tapers = if spine.closed { [0.0; 2] } else { wanted.map(|t| t * fits) };
        let whole = if spine.goes_on == [false; 2] { total } else { f32::INFINITY };
        let short = (whole / (brush.slender * brush.width).max(1e-6)).min(1.0);
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
            * self.pressure(u, self.spine.own(length, self.total()))
            * self.ends(length)
            * self.light(tangent)
            * self.nib(tangent)
    }

    /// Where `own` is less than 1, nearer to the middle of what it may be.
    fn pressure(&self, u: f64, own: f32) -> f32 {
        let b = self.brush;
        let wave = own * self.spine.axis.wave(u, f64::from(b.pressure_length), 1);
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

#[cfg(test)]
mod tests {
    use super::super::noise::Axis;
    use super::super::spine::Knot;
    use super::*;

    #[test]
    fn nothing_tapers_where_a_line_goes_on() {
        let knot =
            |i: usize| Knot { at: Vec2::new(4.0 * i as f32, 0.0), u: 4.0 * i as f64, depth: 0.0 };
        let spine = Spine::new((0..=20).map(knot).collect(), false, Axis::default());
        let brush = Brush { taper: 20.0, taper_end: 1.0, tip: 0.1, ..Brush::default() };
        let ends = |goes_on: [bool; 2]| {
            let spine = Spine { goes_on, ..spine.clone() };
            let hand = Hand::new(&brush, &spine);
            [hand.ends(0.0), hand.ends(40.0), hand.ends(80.0)]
        };
        assert_eq!(ends([false; 2]), [0.1, 1.0, 0.1]);
        assert_eq!(ends([true, false]), [1.0, 1.0, 0.1]);
        assert_eq!(ends([true; 2]), [1.0; 3]);
        // Spines of different noise meet in one width.
        let half = |seed: u64| {
            let axis = Axis { seed, period: None };
            let spine = Spine { goes_on: [false, true], axis, ..spine.clone() };
            let brush = Brush { pressure: 0.8, ..brush.clone() };
            let hand = Hand::new(&brush, &spine);
            [hand.half(10), hand.half(20)]
        };
        let [a, b] = [half(1), half(2)];
        assert!((a[0] - b[0]).abs() > 0.01 && a[1] == b[1], "{a:?} {b:?}");
    }
}
