//! Smooth noise along a stroke, a function of u and a seed alone.
//!
//! Values at the points of a lattice, hashed from their index, with a smooth curve between them. On
//! a closed stroke the lattice is stretched a little, so that a whole number of its cells fits once
//! round and nothing shows where the stroke closes.

use chiaro_basis::random::unit;

/// The u axis of a stroke, in pixels.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Axis {
    /// Tells strokes apart: the same number, the same noise.
    pub seed: u64,
    /// Once round, of a closed stroke.
    pub period: Option<f64>,
}

/// A lattice on the axis: cells of even length, the first one again after a period.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Lattice {
    /// Length of a cell in pixels.
    pub(super) cell: f64,
    /// Cells once round.
    count: Option<i64>,
}

impl Axis {
    /// The lattice whose cells are as near to `length` as the period lets them.
    pub(super) fn lattice(&self, length: f64) -> Lattice {
        let length = length.max(1e-3);
        match self.period.filter(|p| *p > 0.0) {
            None => Lattice { cell: length, count: None },
            Some(period) => {
                let count = (period / length).round().max(1.0);
                Lattice { cell: period / count, count: Some(count as i64) }
            }
        }
    }

    /// Noise in [-1, 1] whose features are some `length` pixels long; `channel` makes it another.
    pub(super) fn wave(&self, u: f64, length: f64, channel: u64) -> f32 {
        let lattice = self.lattice(length);
        let x = u / lattice.cell;
        let (i, t) = (x.floor() as i64, (x - x.floor()) as f32);
        let value = |k: i64| self.at(lattice.index(k), channel);
        let (a, b, c, d) = (
            value(i.wrapping_sub(1)),
            value(i),
            value(i.wrapping_add(1)),
            value(i.wrapping_add(2)),
        );
        (1.15 * spline([a, b, c, d], t)).clamp(-1.0, 1.0)
    }

    /// A number in [-1, 1) for an index.
    pub(super) fn at(&self, index: i64, channel: u64) -> f32 {
        2.0 * self.share(index, channel) - 1.0
    }

    /// A number in [0, 1) for an index.
    pub(super) fn share(&self, index: i64, channel: u64) -> f32 {
        unit(self.seed.wrapping_add(channel.wrapping_mul(0x51_7C_C1_B7)), index as u64)
    }
}

impl Lattice {
    /// The index by which a point's hash goes.
    pub(super) fn index(&self, k: i64) -> i64 {
        self.count.map_or(k, |n| k.rem_euclid(n))
    }
}

/// The uniform cubic B-spline through four control values: no kink, no overshoot.
fn spline([a, b, c, d]: [f32; 4], t: f32) -> f32 {
    let s = 1.0 - t;
    let (t2, t3, s2) = (t * t, t * t * t, s * s);
    (s2 * s * a
        + (3.0 * t3 - 6.0 * t2 + 4.0) * b
        + (1.0 + 3.0 * t + 3.0 * t2 - 3.0 * t3) * c
        + t3 * d)
        * 1.5
        / 6.0
}

/// Noise in [0, 1] over a plane, `x` and `y` in cells; `count` cells along x come again.
pub(super) fn cloud(seed: u64, x: f64, y: f64, count: Option<i64>) -> f32 {
    let (i, j) = (x.floor() as i64, y.floor() as i64);
    let (next, below) = (i.wrapping_add(1), j.wrapping_add(1));
    let ease = |t: f64| (t * t * (3.0 - 2.0 * t)) as f32;
    let (s, t) = (ease(x - x.floor()), ease(y - y.floor()));
    let value = |i: i64, j: i64| {
        let i = count.map_or(i, |n| i.rem_euclid(n));
        unit(seed, (i as u64).wrapping_mul(0x1_0000_0001).wrapping_add((j as u64) << 17))
    };
    let (top, bottom) =
        (mix(value(i, j), value(next, j), s), mix(value(i, below), value(next, below), s));
    mix(top, bottom, t)
}

/// [`cloud`] along an axis: cells `along` pixels of u long, over `y` in cells.
pub(super) fn cloud_on(axis: &Axis, channel: u64, u: f64, along: f64, y: f64) -> f32 {
    let lattice = axis.lattice(along);
    cloud(axis.seed.wrapping_add(channel), u / lattice.cell, y, lattice.count)
}

fn mix(a: f32, b: f32, t: f32) -> f32 {
    a + (b - a) * t
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn noise_is_smooth_and_bounded() {
        let axis = Axis { seed: 5, period: None };
        let values: Vec<f32> = (0..4000).map(|i| axis.wave(f64::from(i) * 0.1, 20.0, 3)).collect();
        assert!(values.iter().all(|v| v.abs() <= 1.0));
        assert!(values.windows(2).all(|w| (w[0] - w[1]).abs() < 0.03));
        let (low, high) = values.iter().fold((0f32, 0f32), |(l, h), &v| (l.min(v), h.max(v)));
        assert!(low < -0.4 && high > 0.4, "{low} {high}");
    }

    #[test]
    fn noise_closes_where_the_stroke_does() {
        let axis = Axis { seed: 9, period: Some(101.7) };
        for i in 0..50 {
            let u = f64::from(i) * 3.3 - 20.0;
            assert!((axis.wave(u, 30.0, 0) - axis.wave(u + 101.7, 30.0, 0)).abs() < 1e-4);
            let cloud = |u: f64| cloud_on(&axis, 1, u, 2.0, 0.4);
            assert!((cloud(u) - cloud(u + 101.7)).abs() < 1e-4);
        }
    }
}
