//! Visible runs of silhouettes joined end to end.
//!
//! Where a surface is noisy or coarse its outline changes from loop to loop: one goes under, and within a
//! pixel or two another comes out and runs on. Runs whose ends meet so, in the picture and in depth, are
//! one line; so are those of which one ends beside the other's first pixels. Nearest ends are joined first, each
//! once; what overlaps is cut off.

use crate::path::Path;
use crate::view::View;
use crate::visibility::Run;
use chiaro_basis::math::DVec2;

/// Length over which the direction of an end is measured, pixels.
const REACH: f64 = 4.0;
/// Cosine of the greatest turn at a joint.
const TURN: f64 = 0.5;
/// How far to the side a line may go on, pixels.
const ASIDE: f64 = 2.0;
/// Greatest difference in depth, in pixels of that depth.
const BEHIND: f64 = 30.0;
/// How far a line may have begun, and run beside another, where that ends, pixels.
const LAP: f64 = 16.0;

/// A line as it is drawn: runs of paths, one after the other.
#[derive(Clone, Debug, PartialEq)]
pub struct Line {
    /// Each a path, by index, and a run of it.
    pub parts: Vec<(usize, Run)>,
    /// Whether the last part goes on with the first.
    pub closed: bool,
}

impl Line {
    /// A run by itself.
    pub fn single(path: usize, run: Run) -> Self {
        Self { parts: vec![(path, run)], closed: false }
    }

    /// Its picture length, pixels; gaps left out.
    pub fn total(&self, paths: &[Path]) -> f64 {
        self.parts.iter().map(|(p, run)| paths[*p].run_length(*run)).sum()
    }
}

/// One end of a run.
#[derive(Clone, Copy)]
struct End {
    at: DVec2,
    /// The way along the run there.
    along: DVec2,
    depth: f64,
}

/// An end that may go on with a start.
struct Joint {
    cost: f64,
    from: usize,
    to: usize,
    /// What the start loses, pixels.
    overlap: f64,
}

/// Joins runs whose ends are within `reach` pixels.
pub(crate) fn joined(
    paths: &[Path],
    mut runs: Vec<(usize, Run)>,
    reach: f64,
    view: &View,
) -> Vec<Line> {
    let mut next: Vec<Option<usize>> = vec![None; runs.len()];
    let mut before = next.clone();
    for joint in joints(paths, &runs, reach, view) {
        if next[joint.from].is_none() && before[joint.to].is_none() {
            next[joint.from] = Some(joint.to);
            before[joint.to] = Some(joint.from);
            let (path, run) = &mut runs[joint.to];
            let path = &paths[*path];
            run.start = path.place_around(path.length_around(run.start) + joint.overlap);
            let n = path.segments.len() as f64;
            if run.start >= n {
                *run = Run { start: run.start - n, end: run.end - n };
            }
        }
    }
    let mut done = vec![false; runs.len()];
    let heads = (0..runs.len()).filter(|&i| before[i].is_none());
    let starts: Vec<usize> = heads.chain(0..runs.len()).collect();
    let mut lines = Vec::new();
    for start in starts {
        let mut parts = Vec::new();
        let mut at = Some(start);
        while let Some(i) = at.filter(|i| !done[*i]) {
            done[i] = true;
            parts.push(runs[i]);
            at = next[i];
        }
        if !parts.is_empty() {
            lines.push(Line { parts, closed: at == Some(start) });
        }
    }
    lines.sort_by(|a, b| {
        let key = |l: &Line| l.parts[0];
        key(a).0.cmp(&key(b).0).then(key(a).1.start.total_cmp(&key(b).1.start))
    });
    lines
}

/// What may be joined, best first.
fn joints(paths: &[Path], runs: &[(usize, Run)], reach: f64, view: &View) -> Vec<Joint> {
    let ends: Vec<Option<[End; 2]>> = runs.iter().map(|(p, run)| ends(&paths[*p], *run)).collect();
    let mut starts: Vec<(f64, usize)> =
        ends.iter().enumerate().filter_map(|(i, e)| e.map(|e| (e[0].at.x, i))).collect();
    starts.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    let mut joints = Vec::new();
    for (from, end) in ends.iter().enumerate() {
        let Some([_, end]) = end else { continue };
        let wide = if reach > 0.0 { reach.max(LAP) } else { 0.0 };
        let first = starts.partition_point(|s| s.0 < end.at.x - wide);
        for &(_, to) in starts[first..].iter().take_while(|s| s.0 <= end.at.x + wide) {
            let Some([start, _]) = &ends[to] else { continue };
            let length = paths[runs[to].0].run_length(runs[to].1);
            let fits = |j: &Joint| {
                length > j.overlap + 1.0 && (from != to || length > REACH * reach.max(REACH))
            };
            let meets = joint((from, end), (to, start), reach, view);
            let laps = || lap(paths, (from, end, runs[from]), (to, start, runs[to]), view);
            joints.extend(meets.or_else(laps).filter(fits));
        }
    }
    joints.sort_by(|a, b| a.cost.total_cmp(&b.cost).then((a.from, a.to).cmp(&(b.from, b.to))));
    joints
}

fn joint(
    (from, end): (usize, &End),
    (to, start): (usize, &End),
    reach: f64,
    view: &View,
) -> Option<Joint> {
    let step = start.at - end.at;
    let (distance, turn) = (step.length(), end.along.dot(start.along));
    let ahead = step.dot(end.along);
    let aside = (step - end.along * ahead).length();
    let behind = (start.depth - end.depth).abs() / view.pixel(end.depth.min(start.depth));
    let fits = distance <= reach && turn >= TURN && aside <= ASIDE && behind <= BEHIND;
    let cost = distance + REACH * (1.0 - turn);
    fits.then(|| Joint { cost, from, to, overlap: (-ahead).max(0.0) })
}

/// The joint of a run with one that begins before its end and runs beside it from there.
fn lap(
    paths: &[Path],
    (from, end, old): (usize, &End, (usize, Run)),
    (to, start, new): (usize, &End, (usize, Run)),
    view: &View,
) -> Option<Joint> {
    let back = end.at - start.at;
    let overlap = back.dot(end.along);
    if from == to || overlap <= 0.0 || back.length() > LAP {
        return None;
    }
    let at = |(path, run): (usize, Run), length: f64| {
        let path = &paths[path];
        let all = path.run_length(run);
        let first = path.length_around(if length < 0.0 { run.end } else { run.start });
        let seen = |l: f64| path.seen_at(path.place_around(first + l));
        (length.abs() + REACH < all).then(|| seen(length).zip(seen(length + 1.0))).flatten()
    };
    // The new line where the old one ends, and the old one where the new one starts.
    let ((here, ahead), (there, _)) = (at(new, overlap)?, at(old, -overlap)?);
    let along = (ahead.at - here.at).normalize_or_zero();
    let aside = here.at.distance(end.at).max(there.at.distance(start.at));
    let behind = (here.depth - end.depth).abs() / view.pixel(end.depth.min(here.depth));
    let fits = along.dot(end.along) >= TURN && aside <= ASIDE && behind <= BEHIND;
    let cost = LAP + overlap + REACH * (1.0 - along.dot(end.along));
    fits.then_some(Joint { cost, from, to, overlap })
}

/// Start and end of a run; `None` for whole loops.
fn ends(path: &Path, run: Run) -> Option<[End; 2]> {
    let n = path.segments.len() as f64;
    if path.closed && run.end - run.start >= n {
        return None;
    }
    let (from, to) = (path.length_around(run.start), path.length_around(run.end));
    let some = REACH.min(to - from);
    let at = |length: f64| path.seen_at(path.place_around(length));
    // The ends themselves by their places: where a path leaves the picture and comes back, both have one length.
    let [a, d] = [path.seen_at(run.start)?, path.seen_at(run.end)?];
    let [b, c] = [at(from + some)?, at(to - some)?];
    let end = |s: crate::view::Seen, along: DVec2| End {
        at: s.at,
        along: along.normalize_or_zero(),
        depth: s.depth,
    };
    Some([end(a, b.at - a.at), end(d, d.at - c.at)])
}
