//! Motion that loops over two seconds: 48 frames at 24 a second, one key a frame.
//!
//! Everything is a function of the phase in [0, 1]; the last key shows what the first does, so that
//! films loop. [`follow`] gives secondary motion: what hangs on something lags and overshoots.

use crate::{Interpolation, Property, Track};
use chiaro_basis::math::{DQuat, DVec3};

/// A property over time, before it has a node.
pub(crate) struct Motion {
    /// What moves.
    pub(crate) property: Property,
    /// Its keys.
    pub(crate) track: Track,
}

/// Frames of a loop.
pub(crate) const FRAMES: usize = 48;
/// Frames a second.
const RATE: f64 = 24.0;
/// Seconds of a loop.
pub(crate) const SECONDS: f64 = FRAMES as f64 / RATE;

/// A rotation for every phase.
pub(crate) fn turning(at: impl Fn(f64) -> DQuat) -> Motion {
    keyed(Property::Rotation, |t| at(t).to_array())
}

/// A translation for every phase.
pub(crate) fn moving(at: impl Fn(f64) -> DVec3) -> Motion {
    keyed(Property::Translation, |t| at(t).to_array())
}

/// Morph weights (cos, sin) that turn `times` in a loop: the two shapes make a travelling wave.
pub(crate) fn waving(times: u32) -> Motion {
    let angle = |t: f64| std::f64::consts::TAU * f64::from(times) * t;
    keyed(Property::Weights, |t| [angle(t).cos(), angle(t).sin()])
}

fn keyed<const N: usize>(property: Property, at: impl Fn(f64) -> [f64; N]) -> Motion {
    let times = (0..=FRAMES).map(|k| (k as f64 / RATE) as f32).collect();
    let value = |k: usize| at(k as f64 / FRAMES as f64).map(|x| x as f32);
    let values = (0..=FRAMES).flat_map(value).collect();
    Motion {
        property,
        track: Track { times, values, width: N, interpolation: Interpolation::Linear },
    }
}

/// A signal with one value a frame, read at any phase.
pub(crate) struct Signal(Vec<f64>);

impl Signal {
    /// The value at a phase, linear between frames.
    pub(crate) fn at(&self, phase: f64) -> f64 {
        let x = phase.rem_euclid(1.0) * FRAMES as f64;
        let (i, t) = (x as usize % FRAMES, x.fract());
        self.0[i] + (self.0[(i + 1) % FRAMES] - self.0[i]) * t
    }
}

/// What a mass on a spring makes of a lead: it lags and overshoots. `frequency` is its own, in
/// hertz, `damping` the share of critical damping. Some loops pass first, so that it repeats.
pub(crate) fn follow(lead: impl Fn(f64) -> f64, frequency: f64, damping: f64) -> Signal {
    const STEPS: usize = 64;
    const SETTLE: usize = 12;
    let omega = std::f64::consts::TAU * frequency;
    let step = SECONDS / (FRAMES * STEPS) as f64;
    let (mut x, mut v) = (lead(0.0), 0.0);
    let mut frames = vec![0.0; FRAMES];
    for i in 0..(SETTLE + 1) * FRAMES * STEPS {
        if i % STEPS == 0 {
            frames[i / STEPS % FRAMES] = x;
        }
        let phase = (i % (FRAMES * STEPS)) as f64 / (FRAMES * STEPS) as f64;
        v += step * (omega * omega * (lead(phase) - x) - 2.0 * damping * omega * v);
        x += step * v;
    }
    Signal(frames)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    #[test]
    fn a_follower_lags_as_a_driven_oscillator_does() {
        let lead = |t: f64| (TAU * t).sin();
        let (frequency, damping) = (1.0, 0.4);
        let signal = follow(lead, frequency, damping);
        // The closed form: a lead of 1/SECONDS hertz through a second-order low pass.
        let r = 1.0 / SECONDS / frequency;
        let (re, im) = (1.0 - r * r, 2.0 * damping * r);
        let (gain, lag) = (1.0 / re.hypot(im), im.atan2(re));
        for k in 0..FRAMES {
            let t = k as f64 / FRAMES as f64;
            let expected = gain * (TAU * t - lag).sin();
            assert!((signal.at(t) - expected).abs() < 5e-3, "{k}: {} {expected}", signal.at(t));
        }
    }

    #[test]
    fn loops_close() {
        let motion = moving(|t| DVec3::new((TAU * t).cos(), 0.0, 0.0));
        let v = &motion.track.values;
        assert!((v[0] - v[3 * FRAMES]).abs() < 1e-6);
        assert_eq!(motion.track.times.len() * 3, v.len());
        assert_eq!(*motion.track.times.last().unwrap(), 2.0);
    }
}
