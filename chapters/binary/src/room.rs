//! Where a labelled picture has room for lines of some width.
//!
//! 1. A region narrower than the line counts as its other side, so that lines do not thin out or break
//!    where a sliver would stand for them.
//! 2. A region that a line would all but fill, or cut a sliver off, gets none.

use crate::bridge::{DRAWN, OPEN};
use chiaro_image::Plane;

/// How far from the middle of a line a region must reach on either side, in widths of the line.
const ROOM: f32 = 1.25;

type Pixel = (usize, usize);

/// A picture in two labels, for lines of a width.
pub(crate) struct Ground<'a> {
    pub(crate) white: &'a Plane<bool>,
    pub(crate) covered: &'a Plane<bool>,
    pub(crate) paper_is_white: bool,
    /// Of the lines, pixels.
    pub(crate) width: f32,
}

impl Ground<'_> {
    /// How a feature between a pixel and the next one along an axis is marked in this label's regions: drawn
    /// where there is room for a line, open where it is an outline against paper, else 0.
    pub(crate) fn mark(&self, p: Pixel, axis: usize, side: bool) -> u8 {
        let q = next(p, axis);
        let is_side = self.is_side(p, side) && self.is_side(q, side);
        match is_side && self.has_room(p, axis, side) {
            true => DRAWN,
            false if self.is_on_paper(p, q, side) => OPEN,
            false => 0,
        }
    }

    /// Whether of two pixels one is paper and the other of paper's label, in this label.
    fn is_on_paper(&self, p: Pixel, q: Pixel, side: bool) -> bool {
        self.covered[p] != self.covered[q] && self.label(p) == side && self.label(q) == side
    }

    fn label(&self, p: Pixel) -> bool {
        if self.covered[p] { self.white[p] } else { self.paper_is_white }
    }

    fn is_side(&self, p: Pixel, side: bool) -> bool {
        let other = |p: Pixel| self.label(p) != side;
        self.label(p) == side || is_narrow(self.white.size(), p, self.width, other)
    }

    /// Whether a region reaches far enough on each side of what is between a pixel and the next one, unless
    /// that side is not the region's own.
    fn has_room(&self, (x, y): Pixel, axis: usize, side: bool) -> bool {
        let (w, h) = self.white.size();
        let least = (ROOM * self.width).ceil() as usize;
        let (at, end) = if axis == 0 { (x, w) } else { (y, h) };
        let holds = |i: usize| self.label(if axis == 0 { (i, y) } else { (x, i) }) == side;
        let mut before = at.saturating_sub(least - 1)..=at;
        let mut after = at + 1..(at + 1 + least).min(end);
        (!holds(at) || before.all(holds)) && (!holds(at + 1) || after.all(holds))
    }
}

/// The next pixel to the right or below.
pub(crate) fn next((x, y): Pixel, axis: usize) -> Pixel {
    if axis == 0 { (x + 1, y) } else { (x, y + 1) }
}

/// Whether what holds at a pixel holds less far than `width` pixels, across or down.
fn is_narrow((w, h): Pixel, p: Pixel, width: f32, holds: impl Fn(Pixel) -> bool) -> bool {
    let most = width.ceil() as usize;
    let run = |at: usize, end: usize, holds: &dyn Fn(usize) -> bool| {
        let after = (at + 1..end).take(most).take_while(|i| holds(*i)).count();
        let before = (0..at).rev().take(most).take_while(|i| holds(*i)).count();
        // What goes on beyond the picture is wide.
        let leaves = at + after + 1 == end || before == at;
        if leaves { most } else { 1 + before + after }
    };
    let across = run(p.0, w, &|x| holds((x, p.1)));
    let down = run(p.1, h, &|y| holds((p.0, y)));
    (across.min(down) as f32) < width
}
