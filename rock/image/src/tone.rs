//! Tone mapping: linear light of any brightness to what a display can show.

use chiaro_basis::choice;

choice! {
    /// A tone curve.
    pub enum Tone {
        /// Khronos PBR Neutral (2024): base colours come out as they are, highlights roll off and
        /// lose their hue only when they must.
        #[default]
        Neutral = "neutral",
        /// None: what is over 1 is cut off.
        Linear = "linear",
    }
}

impl Tone {
    /// A linear colour, 1 being display white, to a linear colour in [0, 1].
    pub fn map(self, colour: [f32; 3]) -> [f32; 3] {
        let finite = colour.map(|c| if c > 0.0 { c.min(1e9) } else { 0.0 });
        match self {
            Self::Neutral => neutral(finite),
            Self::Linear => finite.map(|c| c.min(1.0)),
        }
    }
}

/// The curve as its specification has it.
fn neutral(colour: [f32; 3]) -> [f32; 3] {
    const START: f32 = 0.8 - 0.04;
    const DESATURATION: f32 = 0.15;
    let least = colour.iter().copied().fold(f32::INFINITY, f32::min);
    let offset = if least < 0.08 { least - 6.25 * least * least } else { 0.04 };
    let colour = colour.map(|c| c - offset);
    let peak = colour.iter().copied().fold(0.0, f32::max);
    if peak < START {
        return colour;
    }
    let d = 1.0 - START;
    let new_peak = 1.0 - d * d / (peak + d - START);
    let t = 1.0 - 1.0 / (DESATURATION * (peak - new_peak) + 1.0);
    colour.map(|c| {
        let c = c * new_peak / peak;
        c + (new_peak - c) * t
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_curve_is_monotone_and_ends_below_one() {
        let mut before = -1.0;
        for i in 0..4000 {
            let v = neutral([1e-3 * 1.005f32.powi(i); 3])[0];
            assert!(v >= before && v <= 1.0, "{i}: {v}");
            before = v;
        }
        assert!(before > 0.99);
    }

    #[test]
    fn middle_tones_lose_only_the_offset_and_broken_values_are_black() {
        let [r, g, b] = Tone::Neutral.map([0.5, 0.3, 0.2]);
        assert!((r - 0.46).abs() < 1e-6 && (g - 0.26).abs() < 1e-6 && (b - 0.16).abs() < 1e-6);
        assert_eq!(Tone::Neutral.map([f32::NAN, -1.0, 0.0]), [0.0; 3]);
        assert!(Tone::Neutral.map([f32::INFINITY; 3]).iter().all(|c| *c <= 1.0));
        assert_eq!(Tone::Linear.map([2.0, 0.5, 0.0]), [1.0, 0.5, 0.0]);
    }
}
