//! [`Beside`]: lines that run beside a stronger one, so close that the two are one line on paper.
//!
//! A bevel's creases under its outline, a crease of a scan along its rim: a pen would draw the same
//! line twice. So it would where a rod is thinner than the pen: its outline comes back beside itself. Lines are
//! told in the order of their strength; each is asked against those before, and against what it was itself
//! some pixels ago.

use crate::join::Line;
use crate::path::{Path, Place};
use crate::visibility::Run;
use chiaro_basis::math::DVec2;
use std::collections::{HashMap, VecDeque};

/// Cosine of the greatest angle between lines that run beside each other.
const ALONG: f64 = 0.87;
/// Pixels between the places at which lines are compared.
const STEP: f64 = 1.0;
/// Lines that only cross others are beside them for less than this, pixels.
const CROSSING: f64 = 5.0;
/// Places in a row that are not beside a line before it counts as left.
const LAPSE: usize = 3;

/// Places that are between a place and those that it is asked against on its own line.
const AGO: usize = 12;
/// Least side of a square, pixels.
const CELL: f64 = 4.0;

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
        let c = (p / self.near.max(CELL)).floor();
        (c.x as i32, c.y as i32)
    }

    /// Tells a line that is drawn.
    pub(crate) fn tell(&mut self, path: &Path, run: Run) {
        if self.near <= 0.0 {
            return;
        }
        for (_, at, along) in places(path, run) {
            self.put(at, along);
        }
    }

    fn put(&mut self, at: DVec2, along: DVec2) {
        self.cells.entry(self.cell(at)).or_default().push((at, along));
    }

    fn holds(&self, at: DVec2, along: DVec2) -> bool {
        let [(x0, y0), (x1, y1)] = [-self.near, self.near].map(|d| self.cell(at + d));
        (y0..=y1).flat_map(|y| (x0..=x1).map(move |x| (x, y))).any(|cell| {
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
        self.parted_after(path, run, &mut Past::new(self.near))
    }

    /// The same for a run that goes on a line of which some is past.
    fn parted_after(&self, path: &Path, run: Run, past: &mut Past) -> (Vec<Run>, Vec<[Place; 2]>) {
        let (mut left, mut gone) = (Vec::new(), Vec::new());
        if self.near <= 0.0 {
            return (vec![run], gone);
        }
        let mut since: Option<Place> = None;
        // Where a line was left, and for how many places.
        let mut lapse: Option<(Place, usize)> = None;
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
            let held = self.holds(at, along) || past.own.holds(at, along);
            past.tell(at, along, held);
            match (held, since) {
                (true, None) => since = Some(place),
                (true, Some(_)) => lapse = None,
                (false, Some(_)) => {
                    let (left, count) = lapse.map_or((place, 1), |l| (l.0, l.1 + 1));
                    lapse = Some((left, count)).filter(|_| count < LAPSE);
                    if count == LAPSE {
                        close(since.take(), left, &mut start);
                    }
                }
                (false, None) => {}
            }
        }
        close(since, lapse.map_or(run.end, |l| l.0), &mut start);
        if start < run.end {
            left.push(Run { start, end: run.end });
        }
        let n = path.segments.len() as f64;
        if path.closed && !gone.is_empty() {
            // A whole loop goes on from its end to its start.
            let around = run.end - run.start >= n && left.len() > 1;
            if around && left[0].start == run.start && left[left.len() - 1].end == run.end {
                let first = left.remove(0);
                left.last_mut().expect("there is one").end = first.end + n;
            }
            let wrapped = |r: Run| match r.start >= n {
                true => Run { start: r.start - n, end: r.end - n },
                false => r,
            };
            left = left.into_iter().map(wrapped).collect();
            gone.iter_mut().filter(|g| g[0] >= n).for_each(|g| *g = g.map(|p| p - n));
        }
        (left, gone)
    }

    /// What is left of a line of several parts, in pieces; what is not is added to `gone`.
    pub(crate) fn parted_line(
        &self,
        paths: &[Path],
        line: Line,
        gone: &mut Vec<(usize, Run)>,
    ) -> Vec<Line> {
        let mut past = Past::new(self.near);
        let parts = line.parts.iter().map(|(i, run)| {
            let parted = self.parted_after(&paths[*i], *run, &mut past);
            (*i, *run, parted)
        });
        let parts: Vec<_> = parts.collect();
        if parts.iter().all(|p| p.2.1.is_empty()) {
            return vec![line];
        }
        let mut lines: Vec<Vec<(usize, Run)>> = vec![Vec::new()];
        for (i, run, (left, lost)) in parts {
            gone.extend(lost.iter().map(|[start, end]| (i, Run { start: *start, end: *end })));
            if left.first().is_none_or(|l| l.start != run.start) {
                lines.push(Vec::new());
            }
            for (k, piece) in left.iter().enumerate() {
                if k > 0 {
                    lines.push(Vec::new());
                }
                lines.last_mut().expect("there is one").push((i, *piece));
            }
            if left.last().is_some_and(|l| l.end != run.end) {
                lines.push(Vec::new());
            }
        }
        if line.closed && lines.len() > 1 {
            let mut last = lines.pop().expect("there are two");
            last.append(&mut lines[0]);
            lines[0] = last;
        }
        lines.retain(|l| !l.is_empty());
        lines.into_iter().map(|parts| Line { parts, closed: false }).collect()
    }
}

/// What a line was itself, some places ago.
struct Past {
    own: Beside,
    recent: VecDeque<(DVec2, DVec2, bool)>,
}

impl Past {
    fn new(near: f64) -> Self {
        Self { own: Beside::new(near), recent: VecDeque::new() }
    }

    /// Tells the next place; one that is left out hides nothing later.
    fn tell(&mut self, at: DVec2, along: DVec2, held: bool) {
        self.recent.push_back((at, along, held));
        if self.recent.len() > AGO {
            let gone = self.recent.pop_front().filter(|r| !r.2);
            gone.into_iter().for_each(|r| self.own.put(r.0, r.1));
        }
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
