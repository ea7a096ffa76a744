//! Plateaus: thresholds that would cut through one flat tone.
//!
//! A flat face in perspective has nearly one tone. A threshold inside it draws a border where there
//! is nothing to see, and where the cut, unguided, runs in facets. So the threshold is moved off
//! tones that too much of the picture shares, as little as possible and as far as the share of
//! black stays near the style's band.

use crate::exposure::Exposure;
use crate::knob::BinaryKnobs;
use crate::shade::View;
use crate::terminal::terminal;

/// Half the width of tones that count as one.
const HALF_WIDTH: f32 = 0.03;
/// The share of a picture that may lie so close to the threshold for nothing.
const FREE: f32 = 0.2;
/// What more costs, in shares of black outside the band.
const PRICE: f32 = 1.5;
/// What moving the threshold by 1 costs, in the same.
const MOVE: f32 = 0.3;

/// The exposure with its threshold moved off plateaus.
pub(crate) fn off_plateaus(views: &[View], exposure: Exposure, knobs: &BinaryKnobs) -> Exposure {
    let g = knobs.global;
    if g <= 0.0 {
        return exposure;
    }
    // A pixel leans to black where g (T - t) + local < 0, so where this is under t.
    let neutral = Exposure { threshold: 0.0, ..exposure };
    let mut lean: Vec<f32> = Vec::new();
    for view in views {
        let covered = &view.buffer.covered;
        let difference = terminal(&view.channels, covered, &neutral, knobs);
        let pairs = difference.pixels().iter().zip(covered.pixels());
        lean.extend(pairs.filter(|(_, c)| **c).map(|(d, _)| d / g));
    }
    lean.sort_unstable_by(f32::total_cmp);
    let threshold = settled(&lean, exposure.threshold, [knobs.black_min, knobs.black_max]);
    Exposure { threshold, ..exposure }
}

/// The best threshold near `start` for sorted tones.
fn settled(tones: &[f32], start: f32, [least, most]: [f32; 2]) -> f32 {
    let share = |t: f32| tones.partition_point(|x| *x < t) as f32 / tones.len().max(1) as f32;
    let cost = |t: f32| {
        let black = share(t);
        let outside = (least - black).max(0.0) + (black - most).max(0.0);
        let near = share(t + HALF_WIDTH) - share(t - HALF_WIDTH);
        outside + PRICE * (near - FREE).max(0.0) + MOVE * (t - start).abs()
    };
    let mut best = start;
    for step in 1..=25 {
        for sign in [-1.0, 1.0] {
            let t = start + sign * 0.02 * step as f32;
            if cost(t) < cost(best) {
                best = t;
            }
        }
    }
    best
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_flat_tone_is_not_cut_in_two() {
        // Three faces of a box: 25 % dark, 70 % of nearly one light tone, 5 % bright.
        let mut tones = vec![0.1; 250];
        tones.extend((0..700).map(|i| 0.6 + 0.00005 * i as f32));
        tones.extend(vec![0.9; 50]);
        let t = settled(&tones, 0.61, [0.35, 0.6]);
        let black = tones.iter().filter(|x| **x < t).count();
        assert_eq!(black, 250, "{t}");
    }

    #[test]
    fn an_even_spread_of_tones_keeps_its_threshold() {
        let tones: Vec<f32> = (0..1000).map(|i| i as f32 / 1000.0).collect();
        assert_eq!(settled(&tones, 0.45, [0.35, 0.6]), 0.45);
    }
}
