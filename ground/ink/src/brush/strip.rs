//! A ribbon as pieces whose borders are mitred, each of which knows how much of a pixel it covers.
//!
//! Neighbouring pieces meet at the bisector of their corner, so that u and width run on across it
//! and no pixel is claimed twice in a bend; outside a corner the distance to its point rounds it.
//! The piece nearest to a pixel always claims it, so that there is no gap. Turns back on itself are
//! cut, with a round end on either side.

use super::ribbon::{Rib, Ribbon};
use chiaro_basis::math::Vec2;

/// Corners whose cosine is below this are cut.
const BACK: f32 = -0.3;

/// A straight piece of a ribbon.
#[derive(Clone, Copy, Debug)]
pub(super) struct Piece {
    ends: [Rib; 2],
    along: Vec2,
    length: f32,
    /// Normals of the lines that bound it, both along it.
    bounds: [Vec2; 2],
    caps: [End; 2],
    /// Of a pixel of distance from a slanting border.
    slant: f32,
}

/// What is beyond the end of a piece.
#[derive(Clone, Copy, Debug, PartialEq)]
enum End {
    /// Another piece.
    Joined,
    /// Nothing; half a disc is drawn.
    Round,
    /// Nothing.
    Flat,
}

/// A pixel on a piece.
#[derive(Clone, Copy, Debug)]
pub(super) struct Hit {
    /// Distance from the middle, the left negative.
    pub(super) across: f32,
    /// Half the width there.
    pub(super) half: f32,
    /// Texture parameter.
    pub(super) u: f64,
    /// Depth there.
    pub(super) depth: f32,
    /// What a flat end leaves of it.
    pub(super) end: f32,
    slant: f32,
}

impl Hit {
    /// How far inside the border of a line it is whose half width is `change` more than the ribbon's;
    /// within a pixel of a flat end no farther than from that.
    pub(super) fn inside(&self, change: f32) -> f32 {
        let edge = (self.half + change - self.across.abs()) * self.slant;
        if self.end < 1.0 { edge.min(self.end - 0.5) } else { edge }
    }

    /// How much of the pixel a line covers whose half width is `change` more than the ribbon's. One
    /// thinner than a pixel covers its width's share.
    pub(super) fn cover(&self, change: f32) -> f32 {
        let half = self.half + change;
        let edge = (half - self.across.abs()) * self.slant + 0.5;
        edge.clamp(0.0, (2.0 * half).clamp(0.0, 1.0)) * self.end
    }
}

/// The pieces of a ribbon, in order; a single point is one piece of no length.
pub(super) fn pieces(ribbon: &Ribbon) -> Vec<Piece> {
    let ribs: Vec<Rib> = distinct(&ribbon.ribs);
    let [start, end] = ribbon.round.map(|round| if round { End::Round } else { End::Flat });
    match ribs.as_slice() {
        [] => return Vec::new(),
        [one] => return vec![piece([*one, *one], End::Round)],
        _ => {}
    }
    let mut pieces: Vec<Piece> =
        ribs.windows(2).map(|w| piece([w[0], w[1]], End::Joined)).collect();
    let n = pieces.len();
    for i in 1..n {
        let (before, after) = pieces.split_at_mut(i);
        join(&mut before[i - 1], &mut after[0]);
    }
    if ribbon.closed && n > 2 {
        let (mut last, mut first) = (pieces[n - 1], pieces[0]);
        join(&mut last, &mut first);
        (pieces[n - 1], pieces[0]) = (last, first);
    } else {
        pieces[0].caps[0] = start;
        pieces[n - 1].caps[1] = end;
    }
    pieces
}

fn distinct(ribs: &[Rib]) -> Vec<Rib> {
    let mut kept = ribs.to_vec();
    kept.dedup_by(|b, a| a.at.distance_squared(b.at) < 1e-8);
    kept
}

fn piece(ends: [Rib; 2], cap: End) -> Piece {
    let across = ends[1].at - ends[0].at;
    let length = across.length();
    let along = across.try_normalize().unwrap_or(Vec2::X);
    let slope = if length > 0.0 { (ends[1].half - ends[0].half) / length } else { 0.0 };
    let slant = 1.0 / (1.0 + slope * slope).sqrt();
    Piece { ends, along, length, bounds: [along; 2], caps: [cap; 2], slant }
}

fn join(a: &mut Piece, b: &mut Piece) {
    if a.along.dot(b.along) < BACK {
        (a.caps[1], b.caps[0]) = (End::Round, End::Round);
        return;
    }
    let bisector = (a.along + b.along).normalize();
    (a.bounds[1], b.bounds[0]) = (bisector, bisector);
}

impl Piece {
    /// The pixels that may be within `reach` of its border, as lowest and highest corner.
    pub(super) fn bounds(&self, reach: f32) -> [Vec2; 2] {
        let [a, b] = self.ends;
        let r = a.half.max(b.half) + reach + 1.0;
        [a.at.min(b.at) - r, a.at.max(b.at) + r]
    }

    /// Where `p` is on the piece, if it is the piece's and within `reach` of its border.
    pub(super) fn hit(&self, p: Vec2, reach: f32) -> Option<Hit> {
        let [a, b] = &self.ends;
        let (before, after) = ((p - a.at).dot(self.bounds[0]), (b.at - p).dot(self.bounds[1]));
        let mut end = 1.0;
        for (inside, cap) in [before, after].into_iter().zip(self.caps) {
            match cap {
                End::Joined if inside < 0.0 => return None,
                End::Flat if inside < -0.5 => return None,
                End::Flat => end *= (inside + 0.5).min(1.0),
                _ => {}
            }
        }
        let t = match before + after {
            sum if sum > 1e-9 => (before / sum).clamp(0.0, 1.0),
            _ => 0.5,
        };
        let half = a.half + (b.half - a.half) * t;
        let off = p - a.at;
        let nearest = off.dot(self.along).clamp(0.0, self.length);
        let away = off - nearest * self.along;
        let distance = away.length();
        if distance > half + reach + 0.75 {
            return None;
        }
        Some(Hit {
            across: distance.copysign(self.along.perp_dot(off)),
            half,
            u: a.u + (b.u - a.u) * f64::from(t),
            depth: a.depth + (b.depth - a.depth) * t,
            end,
            slant: self.slant,
        })
    }
}
