//! Exposure: what is decided once for a whole shot, so that a film does not pump.
//!
//! Levels, the threshold between black and white, and the scale of local contrast are surveyed on
//! a few small frames of the shot; whether shadows are cast at all is decided there too.

use crate::appearance::{Channel, Channels};
use crate::knob::{BinaryKnobs, scaled};
use chiaro_image::{Plane, Runs, filter, statistics};

/// What a shot's frames share.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Exposure {
    /// The tone that becomes 0.
    pub low: f32,
    /// The tone that becomes 1.
    pub high: f32,
    /// The stretched tone between black and white, t.
    pub threshold: f32,
    /// The root mean square of the local contrast A'.
    pub contrast: f32,
    /// Whether shadows are cast.
    pub shadows: bool,
    /// What W - B passes from one tone to the next, in palettes of 3 tones, 4, and so on; ascending.
    pub tone_steps: [[f32; MOST_STEPS]; MOST_STEPS - 1],
}

/// The most steps between tones: a palette has one tone more.
pub const MOST_STEPS: usize = 7;

impl Default for Exposure {
    fn default() -> Self {
        Self {
            low: 0.0,
            high: 1.0,
            threshold: 0.5,
            contrast: 0.1,
            shadows: true,
            tone_steps: Default::default(),
        }
    }
}

/// Tones nearer than this are not stretched apart, nor local contrast below its share.
const LEAST_RANGE: f32 = 0.15;

/// Under this share of light that gets through, shadows only darken a closed room.
pub const LEAST_REACH: f32 = 0.15;

/// The tone of a picture before levels where it is covered: the mean of its channels, weighted by
/// their shares.
pub fn mixed_tone(channels: &Channels, covered: &Plane<bool>, knobs: &BinaryKnobs) -> Plane<f32> {
    let parts: Vec<(f32, &Plane<f32>)> = Channel::ALL
        .into_iter()
        .filter_map(|c| Some((c.share(knobs), channels.get(c)?)))
        .filter(|(share, _)| *share > 0.0)
        .collect();
    let total: f32 = parts.iter().map(|(share, _)| share).sum();
    let (w, h) = covered.size();
    if total == 0.0 {
        return Plane::filled(w, h, 0.5);
    }
    Runs::of(covered).plane(0.0, |y, run, tone| {
        for (share, plane) in &parts {
            for (t, v) in tone.iter_mut().zip(&plane.row(y)[run.clone()]) {
                *t += share * v;
            }
        }
        tone.iter_mut().for_each(|t| *t /= total);
    })
}

/// A frame of the survey: its tone before levels, and where there is geometry.
pub struct Sample {
    /// The mixed tone.
    pub tone: Plane<f32>,
    /// Where there is geometry.
    pub covered: Plane<bool>,
}

impl Exposure {
    /// Levels, threshold and contrast of a shot from its surveyed frames.
    pub fn survey(samples: &[Sample], shadows: bool, knobs: &BinaryKnobs) -> Self {
        let (tone, covered) = strip(samples);
        let at = |tone: &Plane<f32>, p: f32| statistics::percentile(tone, &covered, p);
        let (low, high) = (at(&tone, knobs.low), at(&tone, knobs.high));
        let (Some(low), Some(high)) = (low, high) else { return Self::default() };
        let mut exposure = Self { low, high, shadows, ..Self::default() };
        if high - low < LEAST_RANGE {
            // One flat tone: stretching it would show its noise.
            let middle = 0.5 * (low + high);
            (exposure.low, exposure.high) =
                (middle - 0.5 * LEAST_RANGE, middle + 0.5 * LEAST_RANGE);
        }
        let stretched = tone.map(|&t| exposure.stretch(t));
        let (least, most) = (at(&stretched, 35.0), at(&stretched, 60.0));
        let otsu = statistics::otsu(&stretched, &covered);
        exposure.threshold =
            otsu.clamp(least.unwrap_or(0.0), most.unwrap_or(1.0)) + knobs.threshold;
        exposure.contrast = contrast(samples, &exposure, knobs);
        exposure
    }

    /// What W - B passes between `tones` tones, from dark to light; one value less than tones.
    pub fn steps(&self, tones: usize) -> &[f32] {
        match tones {
            0 | 1 => &[],
            2 => &[0.0],
            n => &self.tone_steps[n.min(MOST_STEPS + 1) - 3][..n.min(MOST_STEPS + 1) - 1],
        }
    }

    /// Sets [`Exposure::steps`] for 3 tones or more.
    pub fn set_steps(&mut self, tones: usize, steps: &[f32]) {
        self.tone_steps[tones - 3][..tones - 1].copy_from_slice(steps);
    }

    /// The steps of `tones` tones as shares of the shot from dark to light: alike, but bent so that half of the tones hold
    /// `black`.
    pub(crate) fn shares(tones: usize, black: f32) -> Vec<f32> {
        let bend = black.clamp(0.05, 0.95).ln() / 0.5f32.ln();
        (1..tones).map(|j| (j as f32 / tones as f32).powf(bend)).collect()
    }

    /// A tone after levels, in [0, 1].
    pub fn stretch(&self, tone: f32) -> f32 {
        ((tone - self.low) / (self.high - self.low)).clamp(0.0, 1.0)
    }
}

/// All samples in one plane, one below the other.
pub(crate) fn strip(samples: &[Sample]) -> (Plane<f32>, Plane<bool>) {
    let values: Vec<f32> = samples.iter().flat_map(|s| s.tone.pixels().iter().copied()).collect();
    let covered: Vec<bool> =
        samples.iter().flat_map(|s| s.covered.pixels().iter().copied()).collect();
    let n = values.len();
    (Plane::from_pixels(n, 1, values), Plane::from_pixels(n, 1, covered))
}

/// The root mean square of T minus its local average over the covered pixels of all samples.
fn contrast(samples: &[Sample], exposure: &Exposure, knobs: &BinaryKnobs) -> f32 {
    let (mut sum, mut count) = (0.0f64, 0usize);
    for s in samples {
        let tone = s.tone.map(|&t| exposure.stretch(t));
        let local = local_contrast(&tone, &s.covered, knobs.local_radius);
        for (d, _) in local.pixels().iter().zip(s.covered.pixels()).filter(|(_, c)| **c) {
            sum += f64::from(d * d);
            count += 1;
        }
    }
    ((sum / count.max(1) as f64).sqrt() as f32).max(0.3 * LEAST_RANGE)
}

/// A' (3.4) where pixels are covered: the difference to the normalised Gaussian average (3.3), with h stated at 480 pixels.
/// exp(-r^2 / h^2) has the standard deviation h / sqrt 2.
pub fn local_contrast(plane: &Plane<f32>, covered: &Plane<bool>, h: f32) -> Plane<f32> {
    let mean = local_mean(plane, covered, h);
    plane.zip(&mean, |a, m| a - m).expect("a filter keeps the size")
}

/// The normalised Gaussian average (3.3) where pixels are covered.
pub(crate) fn local_mean(plane: &Plane<f32>, covered: &Plane<bool>, h: f32) -> Plane<f32> {
    let sigma = scaled(h, plane.height()) * std::f32::consts::FRAC_1_SQRT_2;
    filter::gaussian_covered(plane, covered, sigma)
}
