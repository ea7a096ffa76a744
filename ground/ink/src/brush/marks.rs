//! A brush and a spine to ribbons: lines, double lines, dashes, dots, thorns, hairs.
//!
//! Marks are placed by u: the k-th is at k spacings, moved and sized by the hash of k, so that it
//! travels with the line. Near the ends of a stroke they are smaller, so that none pops; less so where the line goes
//! on as another, where two of them must not touch. Where u falls, as by methods that know no future it may, they are
//! placed part by part.

use super::knob::{Brush, Cap, Grain, Mark, Side};
use super::ribbon::{Rib, Ribbon};
use super::spine::{Knot, Spine};
use super::width::Hand;
use chiaro_basis::math::Vec2;

/// Share of their spacing within which marks are smaller at an end, and where the line goes on.
const SMALLER: [f32; 2] = [0.6, 0.25];
/// Hairs and thorns have this many points after their root.
const JOINTS: usize = 6;
/// Share of its width that each line of a double one keeps everywhere.
const FINEST: f32 = 0.6;
/// Marks on one stroke, at most.
const MOST: i64 = 20_000;

/// The ribbons that a brush leaves along a stroke.
pub fn ribbons(brush: &Brush, spine: &Spine) -> Vec<Ribbon> {
    let fine = spine.clone().smoothed(brush.smooth).refined();
    if fine.knots.len() < 2 || brush.mark == Mark::Nothing {
        return Vec::new();
    }
    let passes = (0..u64::from(brush.repeat.max(1))).map(|pass| {
        let over = brush.overshoot * (1.0 - 0.3 * fine.axis.share(pass as i64, 7));
        fine.clone().overshot(over).wobbled(brush.wobble, f64::from(brush.wobble_length), pass)
    });
    passes
        .flat_map(|spine| {
            let hand = Hand::new(brush, &spine);
            Placing { brush, hand, spine: &spine, turned: false }.marks()
        })
        .collect()
}

/// The line by which a stroke hides others, whatever its marks.
pub(super) fn band(brush: &Brush, spine: &Spine) -> Ribbon {
    let fine = spine.clone().smoothed(brush.smooth).refined();
    if fine.knots.len() < 2 {
        return Ribbon::default();
    }
    let apart = if brush.mark == Mark::Double { 0.5 * brush.gap } else { 0.0 };
    let hand = Hand::new(brush, &fine);
    let placing = Placing { brush, hand, spine: &fine, turned: false };
    Ribbon { round: [false; 2], ..placing.line(|h| h + apart) }
}

/// The band of paper beside a stroke that hides others: on both sides, or on its right alone.
pub fn rim(brush: &Brush, spine: &Spine, right: bool) -> Option<Ribbon> {
    let mut band = band(brush, spine);
    if brush.rim <= 0.0 || band.ribs.len() < 2 {
        return None;
    }
    let tangents = band.tangents();
    for (rib, tangent) in band.ribs.iter_mut().zip(tangents) {
        rib.half += brush.rim;
        if right {
            rib.half *= 0.5;
            rib.at += rib.half * tangent.perp();
        }
    }
    Some(band)
}

/// A brush on its way along a spine.
struct Placing<'a> {
    brush: &'a Brush,
    spine: &'a Spine,
    hand: Hand<'a>,
    /// Whether the spine runs against its line.
    turned: bool,
}

/// A place for a mark.
struct Spot {
    /// By which its hash goes.
    index: i64,
    knot: Knot,
    tangent: Vec2,
    /// In [0, 1]: smaller towards the stroke's ends.
    scale: f32,
}

impl Placing<'_> {
    fn marks(&self) -> Vec<Ribbon> {
        match self.brush.mark {
            Mark::Line => vec![self.line(|h| h)],
            Mark::Double => self.double(),
            Mark::Thorns => std::iter::once(self.line(|h| h)).chain(self.by_parts()).collect(),
            Mark::Dashes | Mark::Dots | Mark::Fur => self.by_parts(),
            Mark::Nothing => Vec::new(),
        }
    }

    /// Marks placed by u, along each part on which it rises.
    fn by_parts(&self) -> Vec<Ribbon> {
        let Some(parts) = self.spine.rising() else { return self.by_u() };
        let part = |(spine, turned): &(Spine, bool)| {
            let hand = self.hand.on(spine);
            Placing { brush: self.brush, hand, spine, turned: *turned }.by_u()
        };
        parts.iter().flat_map(part).collect()
    }

    /// Marks placed by u, which rises.
    fn by_u(&self) -> Vec<Ribbon> {
        let mark = match self.brush.mark {
            Mark::Dots => Self::dot,
            Mark::Thorns => Self::thorn,
            Mark::Fur => Self::hair,
            _ => return self.dashes(),
        };
        self.spots().iter().map(|s| mark(self, s)).collect()
    }

    /// The whole spine, its half widths passed through `half`.
    fn line(&self, half: impl Fn(f32) -> f32) -> Ribbon {
        let rib = |(i, k): (usize, &Knot)| Rib::on(*k, half(self.hand.half(i)));
        self.ribbon(self.spine.knots.iter().enumerate().map(rib).collect(), self.spine.closed)
    }

    fn ribbon(&self, ribs: Vec<Rib>, closed: bool) -> Ribbon {
        // A picture of a stroke has ends of its own.
        let ended = self.brush.grain == Grain::Stretch && !self.brush.picture.is_empty();
        let round = [self.brush.cap == Cap::Round && !ended; 2];
        Ribbon { ribs, closed, round, erases: false, axis: self.spine.axis }
    }

    /// The outer ribbon, and the inner one that is taken away from it. Where a stroke comes to a point the
    /// two lines run into one of nearly their own width: lines much finer would be specks.
    fn double(&self) -> Vec<Ribbon> {
        let line = 0.5 * self.brush.width.max(1e-6);
        let apart = |h: f32| 0.5 * self.brush.gap * (h / line).sqrt();
        let held = |h: f32| h.max(FINEST * line);
        let outer = self.line(|h| held(h) + apart(h));
        let inner = self.line(|h| (apart(h) - held(h)).max(0.0));
        vec![outer, Ribbon { erases: true, ..inner }]
    }

    fn dashes(&self) -> Vec<Ribbon> {
        let long = self.unrolled();
        let b = self.brush;
        let lattice = self.spine.axis.lattice(f64::from(b.spacing));
        let [start, end] = long.ends();
        let piece = |k: i64| {
            let index = lattice.index(k);
            let uneven = |channel| f64::from(b.jitter * self.spine.axis.at(index, channel));
            let full = f64::from(b.dash) * lattice.cell;
            let length = full * (1.0 + 0.5 * uneven(21));
            let from = k as f64 * lattice.cell + 0.25 * uneven(22) * (lattice.cell - full);
            let (from, to) = (from.max(start), (from + length).min(end));
            let piece = (to > from).then(|| long.piece(from, to)).flatten()?;
            Some(self.dash(&piece))
        };
        self.indices(lattice.cell, 1).filter_map(piece).collect()
    }

    /// One dash with the pressure of the stroke and tapers of its own.
    fn dash(&self, piece: &Spine) -> Ribbon {
        let own = self.hand.on(piece);
        let ribs = piece.knots.iter().enumerate().map(|(i, k)| Rib::on(*k, own.half(i)));
        self.ribbon(ribs.collect(), false)
    }

    /// A closed spine with as much of its beginning after its end as a mark may need.
    fn unrolled(&self) -> Spine {
        let mut long = self.spine.clone();
        if let (true, Some(period)) = (long.closed, long.axis.period) {
            let until = long.ends()[0] + 2.0 * f64::from(self.brush.spacing).min(0.5 * period);
            let again = self.spine.knots.iter().skip(1).take_while(|k| k.u <= until);
            long.knots.extend(again.map(|k| Knot { u: k.u + period, ..*k }));
            long.closed = false;
        }
        long
    }

    /// Lattice points on the spine, and `before` it.
    fn indices(&self, cell: f64, before: i64) -> std::ops::Range<i64> {
        let [start, end] = self.spine.ends();
        let first = (start / cell).ceil() as i64;
        let last = (end / cell).ceil() as i64;
        let before = if self.spine.closed { 0 } else { before };
        first.saturating_sub(before)..last.min(first.saturating_add(MOST))
    }

    fn spots(&self) -> Vec<Spot> {
        let lattice = self.spine.axis.lattice(f64::from(self.brush.spacing));
        let lengths = &self.spine.lengths();
        let spot = |k: i64| {
            let index = lattice.index(k);
            let aside = 0.45 * self.brush.jitter * self.spine.axis.at(index, 31);
            let u = (k as f64 + f64::from(aside)) * lattice.cell;
            let [start, end] = self.spine.ends();
            let u = match self.spine.axis.period.filter(|_| self.spine.closed) {
                Some(period) => start + (u - start).rem_euclid(period),
                None => Some(u).filter(|u| (start..=end).contains(u))?,
            };
            let (knot, tangent) = self.spine.at(u)?;
            let length = along(self.spine, lengths, u);
            let full = self.hand.half_at(u, length, tangent) / (0.5 * self.brush.width).max(1e-6);
            let near = self.near(length);
            Some(Spot { index, knot, tangent, scale: full * near * (2.0 - near) })
        };
        self.indices(lattice.cell, 0).filter_map(spot).collect()
    }

    /// Less than 1 near the ends.
    fn near(&self, length: f32) -> f32 {
        if self.spine.closed {
            return 1.0;
        }
        let ends = [length, self.hand.total() - length].into_iter().zip(self.spine.goes_on);
        let share = |(end, goes_on): (f32, bool)| end / SMALLER[usize::from(goes_on)];
        (ends.map(share).fold(f32::INFINITY, f32::min) / self.brush.spacing).min(1.0)
    }

    /// A share in [0, 1] for a mark, near 1 where marks are even.
    fn uneven(&self, spot: &Spot, channel: u64) -> f32 {
        1.0 - self.brush.jitter * self.spine.axis.share(spot.index, channel)
    }

    fn dot(&self, spot: &Spot) -> Ribbon {
        let half = 0.5 * self.brush.size * spot.scale * self.uneven(spot, 41);
        Ribbon { round: [true; 2], ..self.ribbon(vec![Rib::on(spot.knot, half)], false) }
    }

    /// The direction in which a mark stands off the line.
    fn away(&self, spot: &Spot) -> Vec2 {
        let right = match self.brush.side {
            Side::Outside => true,
            Side::Inside => false,
            Side::Both => self.spine.axis.share(spot.index, 51) < 0.5,
        };
        if right != self.turned { spot.tangent.perp() } else { -spot.tangent.perp() }
    }

    /// A spike, wide at its root, bent over as it leans.
    fn thorn(&self, spot: &Spot) -> Ribbon {
        let b = self.brush;
        let length = b.size * spot.scale * self.uneven(spot, 61);
        let lean = b.lean + 0.5 * b.jitter * self.spine.axis.at(spot.index, 62);
        let root = 0.5 * b.base * length;
        self.spike(spot, (length, lean, 2.0), |t| root * (1.0 - t) * (1.0 - 0.35 * t))
    }

    /// A thin hair, bent over more the longer it is.
    fn hair(&self, spot: &Spot) -> Ribbon {
        let b = self.brush;
        let length = b.size * spot.scale * self.uneven(spot, 71);
        let lean = b.lean + b.jitter * self.spine.axis.at(spot.index, 72);
        let half = 0.5 * b.width * spot.scale.min(1.0);
        self.spike(spot, (length, lean, 1.6), |t| half * (1.0 - t * t))
    }

    /// A bent spike off the line: its length, its lean, how late it leans, and its half width.
    fn spike(
        &self,
        spot: &Spot,
        (length, lean, late): (f32, f32, f32),
        half: impl Fn(f32) -> f32,
    ) -> Ribbon {
        let away = self.away(spot);
        let root = spot.knot.at - away * (0.3 * self.brush.width).min(0.2 * length);
        let rib = |i: usize| {
            let t = i as f32 / JOINTS as f32;
            let at = root + length * (t * away + lean * t.powf(late) * spot.tangent);
            Rib { at, ..Rib::on(spot.knot, half(t)) }
        };
        Ribbon { round: [false; 2], ..self.ribbon((0..=JOINTS).map(rib).collect(), false) }
    }
}

/// The length up to where u has a value.
fn along(spine: &Spine, lengths: &[f32], u: f64) -> f32 {
    let k = &spine.knots;
    let i = k.partition_point(|k| k.u <= u).clamp(1, k.len() - 1);
    let (a, b) = (k[i - 1].u, k[i].u);
    let t = if b > a { ((u - a) / (b - a)).clamp(0.0, 1.0) as f32 } else { 0.0 };
    lengths[i - 1] + (lengths[i] - lengths[i - 1]) * t
}
