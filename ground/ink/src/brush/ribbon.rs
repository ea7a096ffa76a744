//! [`Ribbon`]: a line of varying width, what every brush's marks are made of; and its outline.

use super::noise::Axis;
use super::spine::Knot;
use crate::Point;
use chiaro_basis::math::Vec2;

/// A point in the middle of a ribbon.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rib {
    /// In the picture, pixels, y down.
    pub at: Vec2,
    /// Half the width, pixels.
    pub half: f32,
    /// Texture parameter in pixels.
    pub u: f64,
    /// Distance from the eye, as a spine has it.
    pub depth: f32,
}

/// A line of varying width.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Ribbon {
    /// Its points; the first of a closed one is repeated at the end. A single one is a disc.
    pub ribs: Vec<Rib>,
    /// Whether its end is joined to its start.
    pub closed: bool,
    /// Whether its start and its end are round.
    pub round: [bool; 2],
    /// Whether it takes away what the ribbons of its stroke before it have drawn.
    pub erases: bool,
    /// Whose grain it has.
    pub axis: Axis,
}

impl Rib {
    /// A point of a spine with a width.
    pub(super) fn on(knot: Knot, half: f32) -> Self {
        Self { at: knot.at, half, u: knot.u, depth: knot.depth }
    }
}

impl Ribbon {
    /// Its mean width, weighed by length.
    pub fn mean_width(&self) -> f32 {
        let (mut area, mut length) = (0.0, 0.0);
        for w in self.ribs.windows(2) {
            let d = w[0].at.distance(w[1].at);
            area += d * (w[0].half + w[1].half);
            length += d;
        }
        match length > 0.0 {
            true => area / length,
            false => self.ribs.first().map_or(0.0, |r| 2.0 * r.half),
        }
    }

    /// The direction at each point.
    pub(super) fn tangents(&self) -> Vec<Vec2> {
        let r = &self.ribs;
        let n = r.len();
        let step = |a: usize, b: usize| (r[b].at - r[a].at).normalize_or_zero();
        (0..n)
            .map(|i| {
                let before = if i > 0 {
                    step(i - 1, i)
                } else if self.closed {
                    step(n - 2, n - 1)
                } else {
                    Vec2::ZERO
                };
                let after = if i + 1 < n {
                    step(i, i + 1)
                } else if self.closed {
                    step(0, 1)
                } else {
                    Vec2::ZERO
                };
                (before + after).try_normalize().unwrap_or(if after == Vec2::ZERO {
                    before
                } else {
                    after
                })
            })
            .collect()
    }

    /// Its border as closed polygons, to be filled by the nonzero rule: one, or two around a closed
    /// ribbon.
    pub fn outlines(&self) -> Vec<Vec<Point>> {
        let point = |p: Vec2| [f64::from(p.x), f64::from(p.y)];
        if let [only] = self.ribs.as_slice() {
            return vec![arc(only.at, only.half, 0.0, std::f32::consts::TAU).map(point).collect()];
        }
        let tangents = self.tangents();
        let side = |sign: f32| {
            let place = move |(r, t): (&Rib, &Vec2)| r.at + sign * r.half * t.perp();
            self.ribs.iter().zip(&tangents).map(place)
        };
        if self.closed {
            let n = self.ribs.len() - 1;
            let left: Vec<Point> = side(-1.0).take(n).map(point).collect();
            let mut right: Vec<Point> = side(1.0).take(n).map(point).collect();
            right.reverse();
            return vec![left, right];
        }
        let (first, last) = (self.ribs[0], self.ribs[self.ribs.len() - 1]);
        let cap = |r: Rib, t: Vec2, round: bool| {
            let start = (-t.perp()).to_angle();
            let wanted = round && r.half > 0.15;
            arc(r.at, r.half, start, std::f32::consts::PI).skip(1).filter(move |_| wanted)
        };
        let (head, tail) = (tangents[0], tangents[tangents.len() - 1]);
        let mut outline: Vec<Point> = side(-1.0).map(point).collect();
        outline.extend(cap(last, tail, self.round[1]).map(point));
        let mut right: Vec<Point> = side(1.0).map(point).collect();
        right.reverse();
        outline.extend(right);
        outline.extend(cap(first, -head, self.round[0]).map(point));
        vec![outline]
    }
}

/// Points of an arc, its last one left out.
fn arc(middle: Vec2, radius: f32, from: f32, turn: f32) -> impl Iterator<Item = Vec2> {
    let parts = (4.0 + 3.0 * radius.sqrt()).ceil() as usize;
    (0..parts)
        .map(move |i| middle + radius * Vec2::from_angle(from + turn * i as f32 / parts as f32))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn area(polygon: &[Point]) -> f64 {
        let next = polygon.iter().skip(1).chain(&polygon[..1]);
        0.5 * polygon.iter().zip(next).map(|(a, b)| a[0] * b[1] - a[1] * b[0]).sum::<f64>()
    }

    fn ribbon(round: bool) -> Ribbon {
        let rib = |i: usize| Rib {
            at: Vec2::new(2.0 * i as f32, 0.0),
            half: 3.0,
            u: 2.0 * i as f64,
            depth: 0.0,
        };
        Ribbon { ribs: (0..=10).map(rib).collect(), round: [round; 2], ..Ribbon::default() }
    }

    #[test]
    fn outlines_enclose_the_ribbon() {
        let flat = area(&ribbon(false).outlines()[0]).abs();
        assert!((flat - 120.0).abs() < 1e-3, "{flat}");
        let round = area(&ribbon(true).outlines()[0]).abs();
        assert!((round - 120.0 - 28.27).abs() < 1.5, "{round}");
        assert!((ribbon(true).mean_width() - 6.0).abs() < 1e-5);
    }

    #[test]
    fn a_ring_has_a_hole() {
        let rib = |i: usize| {
            let a = std::f32::consts::TAU * (i % 60) as f32 / 60.0;
            Rib { at: 20.0 * Vec2::from_angle(a), half: 1.0, u: 0.0, depth: 0.0 }
        };
        let ring = Ribbon { ribs: (0..=60).map(rib).collect(), closed: true, ..Ribbon::default() };
        let total: f64 = ring.outlines().iter().map(|o| area(o)).sum();
        assert!((total.abs() - std::f64::consts::TAU * 40.0).abs() < 3.0, "{total}");
    }
}
