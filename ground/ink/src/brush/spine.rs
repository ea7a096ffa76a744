//! [`Spine`]: the middle of a stroke, with u, made ready for a brush: smoothed, refined, drawn past
//! its ends, wobbled, cut into pieces by u.

use super::noise::Axis;
use chiaro_basis::math::{Vec2, smoothstep};

/// A turn by more than this is kept when a line is smoothed, radians.
const CORNER: f32 = 0.7;
/// Pixels between the points of a refined line, about.
const FINE: f32 = 1.5;

/// A point of a spine.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Knot {
    /// In the picture, pixels, y down.
    pub at: Vec2,
    /// Texture parameter in pixels, rising along the stroke.
    pub u: f64,
    /// Distance from the eye in pixels of that distance; 0 where nothing hides anything.
    pub depth: f32,
}

/// Spines that go on into each other have less and less noise of their own within this length of where they
/// meet, pixels.
const MEETING: f32 = 24.0;

/// Where u falls by more than so many times the length, it leaps.
const LEAP: f64 = 4.0;

/// How u goes from one point to the next.
#[derive(Clone, Copy, PartialEq)]
enum Way {
    Rises,
    Falls,
    Leaps,
}

/// The middle line of a stroke.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Spine {
    /// Its points; the first of a closed one is repeated at the end, a period on in u.
    pub knots: Vec<Knot>,
    /// Whether its end is joined to its start.
    pub closed: bool,
    /// Whose noise it has.
    pub axis: Axis,
    /// Whether the line goes on as another spine before its start and past its end: there it does not taper.
    pub goes_on: [bool; 2],
}

impl Spine {
    /// Points without repetition at one place. At least two are needed for anything to be drawn.
    pub fn new(knots: Vec<Knot>, closed: bool, axis: Axis) -> Self {
        let mut spine = Self { knots, closed, axis, goes_on: [false; 2] };
        spine.knots.dedup_by(|b, a| a.at.distance_squared(b.at) < 1e-6);
        spine.closed &= spine.knots.len() > 3;
        spine
    }

    /// Picture length up to each point.
    pub(super) fn lengths(&self) -> Vec<f32> {
        let mut total = 0.0;
        let steps = self.knots.windows(2).map(|w| w[0].at.distance(w[1].at));
        std::iter::once(0.0)
            .chain(steps.map(|d| {
                total += d;
                total
            }))
            .collect()
    }

    /// How much of what noise does is left at a length from the start of `total`, in [0, 1]: none where the line goes
    /// on as another spine with noise of its own, so that both meet.
    pub(super) fn own(&self, length: f32, total: f32) -> f32 {
        let from_ends = [length, total - length].into_iter().zip(self.goes_on);
        let near = from_ends.filter(|e| e.1).map(|e| e.0).fold(f32::INFINITY, f32::min);
        smoothstep([0.0, MEETING], near)
    }

    /// The whole length in pixels.
    pub fn length(&self) -> f32 {
        self.knots.windows(2).map(|w| w[0].at.distance(w[1].at)).sum()
    }

    /// The direction at point `i`, of length 1; the mean of both sides' where there are two.
    pub(super) fn tangent(&self, i: usize) -> Vec2 {
        let (before, after) = self.around(i);
        let here = self.knots[i].at;
        let side = |d: Vec2| d.normalize_or_zero();
        let (a, b) = (before.map(|p| side(here - p)), after.map(|p| side(p - here)));
        let sum = a.unwrap_or_default() + b.unwrap_or_default();
        sum.try_normalize().or(a).or(b).unwrap_or(Vec2::X)
    }

    /// The points before and after point `i`, across the join of a closed spine.
    fn around(&self, i: usize) -> (Option<Vec2>, Option<Vec2>) {
        let last = self.knots.len() - 1;
        let at = |i: usize| self.knots.get(i).map(|k| k.at);
        let before = if i > 0 { at(i - 1) } else { self.closed.then(|| self.knots[last - 1].at) };
        let after = if i < last { at(i + 1) } else { self.closed.then(|| self.knots[1].at) };
        (before, after)
    }

    /// The line smoothed by a Gaussian of `sigma` pixels; corners and ends stay where they are.
    pub(super) fn smoothed(mut self, sigma: f32) -> Self {
        let n = self.knots.len();
        if sigma <= 0.0 || n < 3 {
            return self;
        }
        let step = self.length() / (n - 1) as f32;
        // Binomial passes, each of variance step^2 / 2.
        let passes = (2.0 * (sigma / step.max(0.1)).powi(2)).round().clamp(1.0, 200.0) as usize;
        let kept: Vec<bool> = (0..n).map(|i| self.is_corner(i)).collect();
        for _ in 0..passes {
            let old: Vec<Vec2> = self.knots.iter().map(|k| k.at).collect();
            for i in (0..n).filter(|i| !kept[*i]) {
                let before = if i > 0 { old[i - 1] } else { old[n - 2] };
                let after = if i + 1 < n { old[i + 1] } else { old[1] };
                self.knots[i].at = 0.25 * (before + after) + 0.5 * old[i];
            }
        }
        self
    }

    /// Whether the line ends or turns sharply at point `i`, seen over two points each way.
    fn is_corner(&self, i: usize) -> bool {
        let n = self.knots.len();
        if !self.closed && (i == 0 || i + 1 == n) {
            return true;
        }
        let at = |k: isize| {
            let k =
                if self.closed { k.rem_euclid(n as isize - 1) } else { k.clamp(0, n as isize - 1) };
            self.knots[k as usize].at
        };
        let i = i as isize;
        let (a, b) = (at(i) - at(i - 2), at(i + 2) - at(i));
        let turn = a.angle_to(b).abs();
        let near = at(i) - at(i - 1);
        let sharp = near.angle_to(at(i + 1) - at(i)).abs();
        turn > CORNER && sharp > 0.6 * turn
    }

    /// The line through the same points with more between them, on Catmull and Rom's curve; corners
    /// stay sharp.
    pub(super) fn refined(self) -> Self {
        let n = self.knots.len();
        if n < 3 {
            return self;
        }
        let corner: Vec<bool> = (0..n).map(|i| self.is_corner(i)).collect();
        let slope = |i: usize, other: usize| {
            let chord = self.knots[other].at - self.knots[i].at;
            let chord = if other > i { chord } else { -chord };
            match (corner[i], self.around(i)) {
                (false, (Some(a), Some(b))) => 0.5 * (b - a).clamp_length_max(2.0 * chord.length()),
                _ => chord,
            }
        };
        let mut knots = Vec::with_capacity(3 * n);
        for i in 0..n - 1 {
            let (a, b) = (self.knots[i], self.knots[i + 1]);
            let parts = (a.at.distance(b.at) / FINE).ceil().clamp(1.0, 64.0) as usize;
            let (p, q) = (slope(i, i + 1), slope(i + 1, i));
            knots.extend((0..parts).map(|k| {
                let t = k as f32 / parts as f32;
                Knot { at: hermite([a.at, b.at], [p, q], t), ..between(a, b, t) }
            }));
        }
        knots.push(self.knots[n - 1]);
        Self { knots, ..self }
    }

    /// Drawn on past both ends by `length` pixels, as the line was heading.
    pub(super) fn overshot(mut self, length: f32) -> Self {
        if length <= 0.0 || self.closed || self.knots.len() < 2 {
            return self;
        }
        let n = self.knots.len();
        let heading = |end: usize, back: usize| {
            let d = self.knots[end].at - self.knots[back].at;
            d.normalize_or_zero()
        };
        let reach = 4.min(n - 1);
        let (start, end) = (heading(0, reach), heading(n - 1, n - 1 - reach));
        let beyond = |k: Knot, d: Vec2, by: f32| Knot {
            at: k.at + d * by.abs(),
            u: k.u + f64::from(by),
            ..k
        };
        let steps = (length / FINE).ceil() as usize;
        let by = |i: usize| length * i as f32 / steps as f32;
        let [before, after] = self.goes_on.map(|goes_on| if goes_on { 0 } else { steps });
        let first = self.knots[0];
        let before = (1..=before).rev().map(|i| beyond(first, start, -by(i)));
        let last = self.knots[n - 1];
        let after: Vec<Knot> = (1..=after).map(|i| beyond(last, end, by(i))).collect();
        self.knots = before.chain(self.knots.iter().copied()).chain(after).collect();
        self
    }

    /// Moved aside by `amount` pixels times noise of `length`; another `pass` goes another way.
    pub(super) fn wobbled(mut self, amount: f32, length: f64, pass: u64) -> Self {
        if amount <= 0.0 || self.knots.len() < 2 {
            return self;
        }
        let lengths = self.lengths();
        let total = lengths[lengths.len() - 1];
        let moved: Vec<Vec2> = (0..self.knots.len())
            .map(|i| {
                let amount = amount * self.own(lengths[i], total);
                let k = self.knots[i];
                let aside = self.axis.wave(k.u, length, 11 + 2 * pass);
                let ahead = self.axis.wave(k.u, length, 12 + 2 * pass);
                let t = self.tangent(i);
                k.at + amount * (aside * t.perp() + 0.4 * ahead * t)
            })
            .collect();
        self.knots.iter_mut().zip(moved).for_each(|(k, at)| k.at = at);
        self
    }

    /// The point where u has a value between its ends.
    pub(super) fn at(&self, u: f64) -> Option<(Knot, Vec2)> {
        let k = &self.knots;
        let i = k.partition_point(|k| k.u <= u).clamp(1, k.len().max(2) - 1);
        let (a, b) = (*k.get(i - 1)?, *k.get(i)?);
        let t = if b.u > a.u { ((u - a.u) / (b.u - a.u)).clamp(0.0, 1.0) as f32 } else { 0.0 };
        let tangent = self.tangent(i - 1).lerp(self.tangent(i), t);
        Some((between(a, b, t), tangent.try_normalize().unwrap_or(Vec2::X)))
    }

    /// The piece between two values of u, open.
    pub(super) fn piece(&self, from: f64, to: f64) -> Option<Self> {
        let (first, _) = self.at(from)?;
        let (last, _) = self.at(to)?;
        let inner = self.knots.iter().filter(|k| k.u > from && k.u < to).copied();
        let knots = std::iter::once(first).chain(inner).chain(std::iter::once(last)).collect();
        Some(Self::new(knots, false, self.axis)).filter(|s| s.knots.len() > 1)
    }

    /// Where u does not rise all along, the parts along which it rises, and whether each is turned round to do so;
    /// where it leaps back there is none.
    pub(super) fn rising(&self) -> Option<Vec<(Self, bool)>> {
        let way = |w: &[Knot]| match w[1].u - w[0].u {
            rise if rise >= 0.0 => Way::Rises,
            fall if -fall <= LEAP * f64::from(w[0].at.distance(w[1].at)) => Way::Falls,
            _ => Way::Leaps,
        };
        let ways: Vec<Way> = self.knots.windows(2).map(way).collect();
        if ways.iter().all(|w| *w == Way::Rises) {
            return None;
        }
        let (mut parts, mut from) = (Vec::new(), 0);
        for run in ways.chunk_by(|a, b| a == b) {
            let to = from + run.len();
            let inside = [from > 0, to < ways.len()].map(|inside| inside || self.closed);
            let mut goes_on = [0, 1].map(|end| inside[end] || self.goes_on[end]);
            let mut knots = self.knots[from..=to].to_vec();
            if run[0] == Way::Falls {
                knots.reverse();
                goes_on.reverse();
            }
            if run[0] != Way::Leaps {
                let part = Self { knots, closed: false, axis: self.axis, goes_on };
                parts.push((part, run[0] == Way::Falls));
            }
            from = to;
        }
        Some(parts)
    }

    /// u at both ends.
    pub(super) fn ends(&self) -> [f64; 2] {
        let u = |k: Option<&Knot>| k.map_or(0.0, |k| k.u);
        [u(self.knots.first()), u(self.knots.last())]
    }
}

fn between(a: Knot, b: Knot, t: f32) -> Knot {
    Knot {
        at: a.at.lerp(b.at, t),
        u: a.u + (b.u - a.u) * f64::from(t),
        depth: a.depth + (b.depth - a.depth) * t,
    }
}

fn hermite([a, b]: [Vec2; 2], [p, q]: [Vec2; 2], t: f32) -> Vec2 {
    let (t2, t3) = (t * t, t * t * t);
    a * (2.0 * t3 - 3.0 * t2 + 1.0)
        + p * (t3 - 2.0 * t2 + t)
        + b * (3.0 * t2 - 2.0 * t3)
        + q * (t3 - t2)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn circle(radius: f32, points: usize) -> Spine {
        let knot = |i: usize| {
            let a = std::f32::consts::TAU * i as f32 / points as f32;
            Knot { at: radius * Vec2::from_angle(a), u: f64::from(radius * a), depth: 0.0 }
        };
        let period = f64::from(radius * std::f32::consts::TAU);
        let axis = Axis { seed: 1, period: Some(period) };
        Spine::new((0..=points).map(knot).collect(), true, axis)
    }

    #[test]
    fn a_refined_circle_is_rounder() {
        let fine = circle(20.0, 24).refined();
        assert!(fine.knots.len() > 70);
        let worst = fine.knots.iter().map(|k| (k.at.length() - 20.0).abs()).fold(0.0, f32::max);
        assert!(worst < 0.02, "{worst}");
    }

    #[test]
    fn smoothing_keeps_corners_and_ends() {
        let knot = |x: f32, y: f32, u: f64| Knot { at: Vec2::new(x, y), u, depth: 0.0 };
        let mut knots: Vec<Knot> = (0..10)
            .map(|i| knot(3.0 * i as f32, 0.2 * (i % 2) as f32, 3.0 * f64::from(i)))
            .collect();
        knots.extend((1..10).map(|i| knot(27.0, 3.0 * i as f32, 27.0 + 3.0 * f64::from(i))));
        let spine = Spine::new(knots.clone(), false, Axis::default()).smoothed(4.0);
        assert_eq!(spine.knots[0].at, knots[0].at);
        assert!(spine.knots.iter().any(|k| k.at.distance(Vec2::new(27.0, 0.2)) < 0.3));
        assert!(spine.knots[1..8].windows(2).all(|w| (w[0].at.y - w[1].at.y).abs() < 0.15));
    }

    #[test]
    fn parts_rise_and_leaps_are_left_out() {
        assert!(circle(20.0, 60).rising().is_none());
        // u rises to 30, falls to 12, rises to 60, leaps back to 0 and rises.
        let u = (0..=10).map(|i| 3.0 * i as f64).chain((1..=6).map(|i| 30.0 - 3.0 * i as f64));
        let u = u.chain((1..=16).map(|i| 12.0 + 3.0 * i as f64)).chain((0..=5).map(|i| i as f64));
        let knot = |(i, u)| Knot { at: Vec2::new(3.0 * i as f32, 0.0), u, depth: 0.0 };
        let spine = Spine::new(u.enumerate().map(knot).collect(), false, Axis::default());
        let parts = spine.rising().unwrap();
        let ends: Vec<([f64; 2], bool)> = parts.iter().map(|p| (p.0.ends(), p.1)).collect();
        let of = |a: f64, b: f64, turned: bool| ([a, b], turned);
        let wanted = [
            of(0.0, 30.0, false),
            of(12.0, 30.0, true),
            of(12.0, 60.0, false),
            of(0.0, 5.0, false),
        ];
        assert_eq!(ends, wanted);
        assert_eq!(parts[0].0.goes_on, [false, true]);
        assert_eq!(parts[3].0.goes_on, [true, false]);
    }

    #[test]
    fn pieces_begin_and_end_where_u_says() {
        let spine = circle(20.0, 60);
        let piece = spine.piece(10.0, 31.0).unwrap();
        assert!((piece.length() - 21.0).abs() < 0.1);
        let [from, to] = piece.ends();
        assert!((from - 10.0).abs() < 1e-6 && (to - 31.0).abs() < 1e-6);
    }
}
