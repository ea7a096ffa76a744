//! [`Track`]: one animated property over time, and the [`Clip`]s that group them.

use crate::NodeId;

/// A named animation of a file.
#[derive(Clone, Debug, Default)]
pub struct Clip {
    /// The name in the file, or empty.
    pub name: String,
    /// What it moves.
    pub channels: Vec<Channel>,
}

/// One property of one node, moved by one track.
#[derive(Clone, Debug)]
pub struct Channel {
    /// Which node.
    pub node: NodeId,
    /// Which of its properties.
    pub property: Property,
    /// The keys.
    pub track: Track,
}

/// What a channel moves.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Property {
    /// Three numbers a key.
    Translation,
    /// Four numbers a key: a unit quaternion x, y, z, w.
    Rotation,
    /// Three numbers a key.
    Scale,
    /// One number a morph target and key.
    Weights,
}

/// How values between keys are found (glTF 2.0, appendix C).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Interpolation {
    /// The value of the key before.
    Step,
    /// Linear, spherical for rotations.
    Linear,
    /// Hermite splines: each key holds in-tangent, value, out-tangent.
    CubicSpline,
}

/// Keys over time.
#[derive(Clone, Debug)]
pub struct Track {
    /// Key times in seconds, rising; at least one.
    pub times: Vec<f32>,
    /// `width` numbers a key (three times as many for cubic splines).
    pub values: Vec<f32>,
    /// Numbers in a value.
    pub width: usize,
    /// Between keys.
    pub interpolation: Interpolation,
}

impl Track {
    /// The value at `time`, `width` numbers: held before the first key and after the last.
    /// Rotations interpolate on the sphere.
    pub fn sample(&self, time: f64, rotation: bool) -> Vec<f32> {
        let last = self.times.len() - 1;
        let after = self.times.partition_point(|&t| f64::from(t) <= time);
        if after == 0 || last == 0 {
            return self.key(0, 1);
        }
        if after > last {
            return self.key(last, 1);
        }
        let before = after - 1;
        let (t0, t1) = (f64::from(self.times[before]), f64::from(self.times[after]));
        let span = t1 - t0;
        let s = if span > 0.0 { ((time - t0) / span) as f32 } else { 1.0 };
        match self.interpolation {
            Interpolation::Step => self.key(before, 1),
            Interpolation::Linear if rotation => {
                slerp(&self.key(before, 1), &self.key(after, 1), s)
            }
            Interpolation::Linear => {
                let (a, b) = (self.key(before, 1), self.key(after, 1));
                a.iter().zip(&b).map(|(a, b)| a + (b - a) * s).collect()
            }
            Interpolation::CubicSpline => self.hermite(before, span as f32, s),
        }
    }

    /// The `part`-th third of a key: in-tangent 0, value 1, out-tangent 2; other interpolations have
    /// the value alone.
    fn key(&self, key: usize, part: usize) -> Vec<f32> {
        let w = self.width;
        let start = match self.interpolation {
            Interpolation::CubicSpline => (3 * key + part) * w,
            _ => key * w,
        };
        self.values[start..start + w].to_vec()
    }

    /// The cubic through keys `k` and `k + 1` with their tangents (glTF 2.0, appendix C.5).
    fn hermite(&self, k: usize, span: f32, s: f32) -> Vec<f32> {
        let (s2, s3) = (s * s, s * s * s);
        let weights = [
            2.0 * s3 - 3.0 * s2 + 1.0,
            span * (s3 - 2.0 * s2 + s),
            3.0 * s2 - 2.0 * s3,
            span * (s3 - s2),
        ];
        let parts = [self.key(k, 1), self.key(k, 2), self.key(k + 1, 1), self.key(k + 1, 0)];
        (0..self.width).map(|i| (0..4).map(|j| weights[j] * parts[j][i]).sum()).collect()
    }
}

/// The shorter way round between two quaternions.
fn slerp(a: &[f32], b: &[f32], s: f32) -> Vec<f32> {
    use chiaro_basis::math::Quat;
    let quat = |q: &[f32]| Quat::from_xyzw(q[0], q[1], q[2], q[3]);
    let unit = |q: Quat| if q.length_squared() > 0.0 { q.normalize() } else { Quat::IDENTITY };
    unit(quat(a)).slerp(unit(quat(b)), s).to_array().to_vec()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn track(interpolation: Interpolation, values: &[f32], width: usize) -> Track {
        Track { times: vec![1.0, 3.0], values: values.to_vec(), width, interpolation }
    }

    #[test]
    fn steps_hold_and_lines_join() {
        let step = track(Interpolation::Step, &[2.0, 6.0], 1);
        let line = track(Interpolation::Linear, &[2.0, 6.0], 1);
        for (time, held, linear) in [
            (0.0, 2.0, 2.0),
            (1.5, 2.0, 3.0),
            (2.999, 2.0, 5.998),
            (3.0, 6.0, 6.0),
            (9.0, 6.0, 6.0),
        ] {
            assert_eq!(step.sample(time, false), [held]);
            assert!((line.sample(time, false)[0] - linear).abs() < 1e-5);
        }
    }

    #[test]
    fn a_cubic_spline_reproduces_a_cubic() {
        let f = |t: f32| t * t * t - t;
        let d = |t: f32| 3.0 * t * t - 1.0;
        let values = [0.0, f(1.0), d(1.0), d(3.0), f(3.0), 0.0];
        let spline = track(Interpolation::CubicSpline, &values, 1);
        for t in [1.0f32, 1.3, 2.0, 2.7] {
            assert!((spline.sample(f64::from(t), false)[0] - f(t)).abs() < 1e-4);
        }
    }

    #[test]
    fn rotations_take_the_shorter_way() {
        let h = std::f32::consts::FRAC_1_SQRT_2;
        // A quarter turn about y, given with the opposite sign.
        let t = track(Interpolation::Linear, &[0.0, 0.0, 0.0, 1.0, 0.0, -h, 0.0, -h], 4);
        let q = t.sample(2.0, true);
        let eighth = std::f32::consts::FRAC_PI_8;
        assert!(
            (q[1].abs() - eighth.sin()).abs() < 1e-5 && (q[3].abs() - eighth.cos()).abs() < 1e-5
        );
    }
}
