//! [`Near`]: the segments of a frame's strokes in a grid, asked for the nearest one.

use crate::stroke::Stroke;
use crate::view::View;
use chiaro_basis::math::DVec2;

/// Side of a cell, pixels.
const CELL: f64 = 16.0;

/// A segment between two samples of a stroke, or the one that closes it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Segment {
    /// The stroke's index.
    pub(crate) stroke: u32,
    /// Its first sample.
    pub(crate) first: u32,
    /// Whether it is the last of an open stroke.
    pub(crate) last: bool,
    /// Whether the stroke is open.
    pub(crate) open: bool,
    /// Its ends in the picture.
    pub(crate) ends: [DVec2; 2],
    /// Their depths.
    pub(crate) depths: [f64; 2],
}

/// The nearest place.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Hit {
    /// The segment.
    pub(crate) segment: Segment,
    /// Where on it, 0 to 1.
    pub(crate) share: f64,
    /// How far the position lies beyond the stroke's end along the line, pixels.
    pub(crate) beyond: f64,
    /// How far away, pixels.
    pub(crate) distance: f64,
}

/// The segments of a frame.
pub(crate) struct Near {
    segments: Vec<Segment>,
    cells: Vec<Vec<u32>>,
    size: (usize, usize),
}

impl Segment {
    /// Its direction.
    pub(crate) fn direction(&self) -> DVec2 {
        (self.ends[1] - self.ends[0]).normalize_or_zero()
    }

    /// The depth at a share of it.
    pub(crate) fn depth(&self, share: f64) -> f64 {
        self.depths[0] + (self.depths[1] - self.depths[0]) * share
    }

    fn hit(&self, at: DVec2) -> Hit {
        let d = self.ends[1] - self.ends[0];
        let t = (at - self.ends[0]).dot(d) / d.length_squared();
        let t = if t.is_finite() { t } else { 0.5 };
        let share = t.clamp(0.0, 1.0);
        let over = (t - share) * d.length();
        let at_end = self.open && ((over < 0.0 && self.first == 0) || (over > 0.0 && self.last));
        let beyond = if at_end { over.abs() } else { 0.0 };
        let distance = at.distance(self.ends[0] + d * share);
        Hit { segment: *self, share, beyond, distance }
    }
}

impl Near {
    /// The segments of some strokes.
    pub(crate) fn of<'a>(strokes: impl Iterator<Item = &'a Stroke>, view: &View) -> Self {
        let cells = |n: usize| (n as f64 / CELL).ceil() as usize + 2;
        let size = (cells(view.size.0), cells(view.size.1));
        let mut near =
            Self { segments: Vec::new(), cells: vec![Vec::new(); size.0 * size.1], size };
        strokes.enumerate().for_each(|(i, stroke)| near.add(i as u32, stroke));
        near
    }

    fn add(&mut self, index: u32, stroke: &Stroke) {
        let s = &stroke.samples;
        let count = if stroke.closed { s.len() } else { s.len().saturating_sub(1) };
        for k in 0..count {
            let (a, b) = (&s[k], &s[(k + 1) % s.len()]);
            let segment = Segment {
                stroke: index,
                first: k as u32,
                last: !stroke.closed && k + 1 == count,
                open: !stroke.closed,
                ends: [a.at, b.at],
                depths: [a.depth, b.depth],
            };
            let (low, high) = (self.cell(a.at.min(b.at)), self.cell(a.at.max(b.at)));
            for y in low.1..=high.1 {
                for x in low.0..=high.0 {
                    self.cells[y * self.size.0 + x].push(self.segments.len() as u32);
                }
            }
            self.segments.push(segment);
        }
    }

    /// The cell of a position; what lies outside is in the outermost ones.
    fn cell(&self, at: DVec2) -> (usize, usize) {
        let index = |x: f64, n: usize| ((x / CELL + 1.0).max(0.0) as usize).min(n - 1);
        (index(at.x, self.size.0), index(at.y, self.size.1))
    }

    /// The nearest accepted place within `reach` pixels; `handicap` makes a place seem further, or
    /// refuses it. Ties go to the lower index.
    pub(crate) fn nearest(
        &self,
        at: DVec2,
        reach: f64,
        handicap: impl Fn(&Hit) -> Option<f64>,
    ) -> Option<Hit> {
        let (low, high) = (self.cell(at - reach), self.cell(at + reach));
        let mut best: Option<(f64, u32, Hit)> = None;
        for y in low.1..=high.1 {
            for x in low.0..=high.0 {
                for &i in &self.cells[y * self.size.0 + x] {
                    let hit = self.segments[i as usize].hit(at);
                    if hit.distance > reach {
                        continue;
                    }
                    let Some(more) = handicap(&hit) else { continue };
                    let key = hit.distance + more;
                    if best.as_ref().is_none_or(|b| (key, i) < (b.0, b.1)) {
                        best = Some((key, i, hit));
                    }
                }
            }
        }
        best.map(|b| b.2)
    }
}
