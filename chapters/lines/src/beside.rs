//! [`Beside`]: lines that run beside a stronger one, so close that the two are one line on paper.
//!
//! A bevel's creases under its outline, a crease of a scan along its rim: a pen would draw the same
//! line twice. Lines are told in the order of their strength; each is asked against those before.

use crate::path::{Path, Place};
use crate::visibility::Run;
use chiaro_basis::math::DVec2;
use std::collections::HashMap;

/// Cosine of the greatest angle between lines that run beside each other.
const ALONG: f64 = 0.87;
/// Pixels between the places at which lines are compared.
const STEP: f64 = 1.0;
/// Lines that only cross others are beside them for less than this, pixels.
const CROSSING: f64 = 5.0;

/// The lines told so far, in squares of the picture.
pub(crate) struct Beside {
    near: f64,
    cells: HashMap<(i32, i32), Vec<(DVec2, DVec2)>>,
}

impl Beside {
    /// For lines within `near` pixels.
    pub(crate) fn new(near: f64) -> Self {
        Self { near, cells: HashMap::new() }
    }

    fn cell(&self, p: DVec2) -> (i32, i32) {
        let c = (p / self.near.max(1.0)).floor();
        (c.x as i32, c.y as i32)
    }

    /// Tells a line that is drawn.
    pub(crate) fn tell(&mut self, path: &Path, run: Run) {
        if self.near <= 0.0 {
            return;
        }
        for (_, at, along) in places(path, run) {
            self.cells.entry(self.cell(at)).or_default().push((at, along));
        }
    }

    fn holds(&self, at: DVec2, along: DVec2) -> bool {
        let (x, y) = self.cell(at);
        (y - 1..=y + 1).flat_map(|y| (x - 1..=x + 1).map(move |x| (x, y))).any(|cell| {
            self.cells.get(&cell).is_some_and(|there| {
                there.iter().any(|(p, d)| {
                    p.distance_squared(at) <= self.near * self.near && d.dot(along).abs() >= ALONG
                })
            })
        })
    }

    /// The share of a run that has another line beside it.
    pub(crate) fn share(&self, path: &Path, run: Run) -> f64 {
        let (mut count, mut all) = (0, 0);
        for (_, at, along) in places(path, run) {
            all += 1;
            count += usize::from(self.holds(at, along));
        }
        if all > 0 { f64::from(count as u32) / f64::from(all) } else { 0.0 }
    }

    /// What is left of a run, and what is not.
    pub(crate) fn parted(&self, path: &Path, run: Run) -> (Vec<Run>, Vec<[Place; 2]>) {
        let (mut left, mut gone) = (Vec::new(), Vec::new());
        let mut since: Option<Place> = None;
        let mut start = run.start;
        let mut close = |since: Option<Place>, end: Place, start: &mut Place| {
            let Some(from) = since else { return };
            if path.length_around(end) - path.length_around(from) < CROSSING {
                return;
            }
            if from > *start {
                left.push(Run { start: *start, end: from });
            }
            gone.push([from, end]);
            *start = end;
        };
        for (place, at, along) in places(path, run) {
            match (self.holds(at, along), since) {
                (true, None) => since = Some(place),
                (false, Some(_)) => close(since.take(), place, &mut start),
                _ => {}
            }
        }
        close(since, run.end, &mut start);
        if start < run.end {
            left.push(Run { start, end: run.end });
        }
        (left, gone)
    }
}

/// Places along a run, evenly, with where they are and the way along.
fn places(path: &Path, run: Run) -> impl Iterator<Item = (Place, DVec2, DVec2)> + '_ {
    let (from, to) = (path.length_around(run.start), path.length_around(run.end));
    let count = ((to - from) / STEP).ceil().max(1.0);
    (0..=count as usize).filter_map(move |i| {
        let length = from + (to - from) * i as f64 / count;
        let at = |l: f64| path.seen_at(path.place_around(l.clamp(from, to))).map(|s| s.at);
        let (here, a, b) = (at(length)?, at(length - 1.5)?, at(length + 1.5)?);
        let place = if i == 0 { run.start } else { path.place_around(length) };
        Some((place, here, (b - a).normalize_or_zero()))
    })
}
