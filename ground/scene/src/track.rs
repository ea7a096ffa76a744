//! [`Track`]: one animated property over time, and the [`Clip`]s that group them.

use crate::NodeId;
use chiaro_basis::math::{DQuat, Quat};

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
    /// Writes the value at `time` seconds into `out`, as many numbers as both have room for.
    ///
    /// Before the first key and after the last the value holds. Rotations take the shorter way on
    /// the sphere and come out as unit quaternions. Of keys at one time the last counts; a track
    /// without keys, or with fewer values than its keys ask for, leaves `out` as it is.
    pub fn sample(&self, time: f64, property: Property, out: &mut [f64]) {
        let Some(span) = self.span(time) else { return };
        let rotates = property == Property::Rotation && self.width == 4 && out.len() == 4;
        match self.interpolation {
            Interpolation::Step => self.hold(&span, out),
            Interpolation::Linear if rotates => self.turn(&span, out),
            Interpolation::Linear => self.line(&span, out),
            Interpolation::CubicSpline => self.spline(&span, out),
        }
        if rotates {
            out.copy_from_slice(&unit(DQuat::from_slice(out)).to_array());
        }
    }

    /// Where `time` falls between keys, or `None` without keys.
    fn span(&self, time: f64) -> Option<Span> {
        let last = self.times.len().checked_sub(1)?;
        let passed = self.times.partition_point(|&t| f64::from(t) <= time);
        let (before, after) = (passed.saturating_sub(1), passed.min(last));
        let (start, end) = (f64::from(self.times[before]), f64::from(self.times[after]));
        let seconds = end - start;
        // Keys out of order or at one time leave no way to go: the value before holds.
        if seconds > 0.0 {
            let along = ((time - start) / seconds).clamp(0.0, 1.0);
            Some(Span { before, after, along, seconds })
        } else {
            Some(Span { before, after: before, along: 0.0, seconds: 0.0 })
        }
    }

    /// One part of a key: splines hold in-tangent, value and out-tangent, the others a value alone.
    fn part(&self, key: usize, part: Part) -> Option<&[f32]> {
        let index = match self.interpolation {
            Interpolation::CubicSpline => 3 * key + part as usize,
            _ => key,
        };
        self.values.get(index * self.width..(index + 1) * self.width)
    }

    fn hold(&self, span: &Span, out: &mut [f64]) {
        let Some(value) = self.part(span.before, Part::Value) else { return };
        out.iter_mut().zip(value).for_each(|(o, &v)| *o = v.into());
    }

    fn line(&self, span: &Span, out: &mut [f64]) {
        let ends = [span.before, span.after].map(|key| self.part(key, Part::Value));
        let [Some(a), Some(b)] = ends else { return };
        for (o, (&a, &b)) in out.iter_mut().zip(a.iter().zip(b)) {
            let (a, b) = (f64::from(a), f64::from(b));
            *o = a + (b - a) * span.along;
        }
    }

    /// The shorter way between two rotations.
    fn turn(&self, span: &Span, out: &mut [f64]) {
        let ends = [span.before, span.after].map(|key| self.part(key, Part::Value));
        let [Some(a), Some(b)] = ends else { return };
        let [a, b] = [a, b].map(|q| unit(Quat::from_slice(q).as_dquat()));
        out.copy_from_slice(&a.slerp(b, span.along).to_array());
    }

    /// The cubic through two keys with their tangents (glTF 2.0, appendix C.5).
    fn spline(&self, span: &Span, out: &mut [f64]) {
        let parts = [
            self.part(span.before, Part::Value),
            self.part(span.before, Part::Out),
            self.part(span.after, Part::Value),
            self.part(span.after, Part::In),
        ];
        let [Some(p0), Some(m0), Some(p1), Some(m1)] = parts else { return };
        let [h0, g0, h1, g1] = hermite(span.along, span.seconds);
        for (i, o) in out.iter_mut().enumerate().take(self.width) {
            let [p0, m0, p1, m1] = [p0[i], m0[i], p1[i], m1[i]].map(f64::from);
            *o = h0 * p0 + g0 * m0 + h1 * p1 + g1 * m1;
        }
    }
}

/// A stretch between two keys.
struct Span {
    before: usize,
    after: usize,
    /// From 0 at `before` to 1 at `after`.
    along: f64,
    /// Its length.
    seconds: f64,
}

/// The parts of a spline's key, in the order of the file.
#[derive(Clone, Copy)]
enum Part {
    In,
    Value,
    Out,
}

/// Weights of value and tangent at the start, value and tangent at the end; tangents are per second.
fn hermite(s: f64, seconds: f64) -> [f64; 4] {
    let (s2, s3) = (s * s, s * s * s);
    [
        2.0 * s3 - 3.0 * s2 + 1.0,
        seconds * (s3 - 2.0 * s2 + s),
        3.0 * s2 - 2.0 * s3,
        seconds * (s3 - s2),
    ]
}

/// The unit quaternion along `q`; no turn at all where there is none.
fn unit(q: DQuat) -> DQuat {
    let length = q.length();
    if length > 0.0 && length.is_finite() { q / length } else { DQuat::IDENTITY }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn track(interpolation: Interpolation, values: &[f32], width: usize) -> Track {
        Track { times: vec![1.0, 3.0], values: values.to_vec(), width, interpolation }
    }

    fn number(track: &Track, time: f64) -> f64 {
        let mut out = [f64::NAN];
        track.sample(time, Property::Weights, &mut out);
        out[0]
    }

    fn rotation(track: &Track, time: f64) -> DQuat {
        let mut out = [f64::NAN; 4];
        track.sample(time, Property::Rotation, &mut out);
        DQuat::from_array(out)
    }

    #[test]
    fn steps_hold_and_lines_join() {
        let step = track(Interpolation::Step, &[2.0, 6.0], 1);
        let line = track(Interpolation::Linear, &[2.0, 6.0], 1);
        for (time, held, linear) in
            [(0.0, 2.0, 2.0), (1.5, 2.0, 3.0), (2.75, 2.0, 5.5), (3.0, 6.0, 6.0), (9.0, 6.0, 6.0)]
        {
            assert_eq!(number(&step, time), held);
            assert_eq!(number(&line, time), linear);
        }
    }

    #[test]
    fn a_cubic_spline_reproduces_a_cubic_over_a_span_of_any_length() {
        let f = |t: f32| t * t * t - t;
        let d = |t: f32| 3.0 * t * t - 1.0;
        let values = [7.0, f(1.0), d(1.0), d(3.0), f(3.0), 7.0];
        let spline = track(Interpolation::CubicSpline, &values, 1);
        for t in [0.0f32, 1.0, 1.25, 2.0, 2.75, 3.0, 4.0] {
            let held = t.clamp(1.0, 3.0);
            assert!((number(&spline, t.into()) - f64::from(f(held))).abs() < 1e-12, "{t}");
        }
    }

    #[test]
    fn rotations_take_the_shorter_way_evenly() {
        let end = Quat::from_rotation_y(2.0).to_array().map(|x| -x);
        let values = [[0.0, 0.0, 0.0, 1.0], end].concat();
        let turn = track(Interpolation::Linear, &values, 4);
        for step in 0..=8 {
            let along = f64::from(step) / 8.0;
            let q = rotation(&turn, 1.0 + 2.0 * along);
            let want = DQuat::from_rotation_y(2.0 * along);
            assert!(q.dot(want).abs() > 1.0 - 1e-12, "{q} is not {want}");
        }
    }

    #[test]
    fn rotations_come_out_as_unit_quaternions() {
        let spline: Vec<f32> = (0..24).map(|i| (i * 7 % 5) as f32 - 1.5).collect();
        let line = [[0.0; 4], [3.0, 0.0, 0.0, 4.0]].concat();
        for t in
            [track(Interpolation::CubicSpline, &spline, 4), track(Interpolation::Linear, &line, 4)]
        {
            for time in [0.0, 1.1, 2.0, 2.9, 3.0] {
                assert!((rotation(&t, time).length() - 1.0).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn four_weights_are_no_rotation() {
        let values = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0]].concat();
        let mut out = [0.0; 4];
        track(Interpolation::Linear, &values, 4).sample(2.0, Property::Weights, &mut out);
        assert_eq!(out, [0.5, 0.5, 0.0, 0.0]);
    }

    #[test]
    fn broken_tracks_survive() {
        let with = |times: &[f32], values: &[f32], interpolation| Track {
            times: times.to_vec(),
            values: values.to_vec(),
            width: 1,
            interpolation,
        };
        use Interpolation::{CubicSpline, Linear, Step};
        for interpolation in [Step, Linear, CubicSpline] {
            for time in [-1.0, 0.0, 0.5, 1.0, 2.0, f64::INFINITY, f64::NAN] {
                assert!(number(&with(&[], &[], interpolation), time).is_nan(), "left alone");
                assert!(number(&with(&[0.0, 1.0], &[], interpolation), time).is_nan());
                let values: Vec<f32> = (0..12).map(|i| i as f32).collect();
                for times in [[0.0, 1.0, 1.0, 2.0], [2.0, 1.0, 0.5, 0.0], [f32::NAN; 4]] {
                    let got = number(&with(&times, &values, interpolation), time);
                    assert!((-2.0..=13.0).contains(&got), "{times:?} at {time}: {got}");
                }
            }
        }
        // Of two keys at one time the first ends what came before, the second begins what follows.
        let jump = with(&[0.0, 1.0, 1.0, 2.0], &[0.0, 1.0, 5.0, 6.0], Linear);
        assert_eq!([0.5, 1.0, 1.5].map(|t| number(&jump, t)), [0.5, 5.0, 5.5]);
    }
}
