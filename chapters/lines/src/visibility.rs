//! Which parts of the paths of a frame are seen.
//!
//! 1. Paths are cut where their convexity changes and where a nearer silhouette or border passes
//!    in front of them in the picture: there, and where bodies run into each other, visibility can
//!    change.
//! 2. The samples of a stretch between two cuts vote ([`Sight`]). If they all but agree, the stretch
//!    has one label; else each keeps its own, and changes are found to a tenth of a pixel by
//!    bisection.
//! 3. Gaps too short to be seen are bridged, silhouettes that go on with each other joined ([`Line`]), lines
//!    too short, or beside a stronger one, left out ([`Limits`]).
//!
//! Nothing is carried over from other frames: it would only delay true changes.

use crate::beside::Beside;
use crate::bit::Bits;
use crate::crossing::crossings;
use crate::join::{Line, joined};
use crate::path::{Kind, Path, Place, Segment};
use crate::sight::Sight;
use crate::surface::NONE;
use crate::view::{Seen, View};
use chiaro_basis::math::DVec2;
use std::collections::HashSet;

/// Pixels between the samples that vote.
const SPACING: f64 = 3.0;
/// Most votes of a stretch.
const VOTES: usize = 400;
/// Least votes that decide a stretch if all agree, and the samples of each.
const PROBES: [usize; 2] = [7, 4];
/// Votes in a row that are never outvoted.
const ROW: usize = 4;
/// Share of votes that decides a stretch.
const AGREE: f64 = 0.85;
/// Silhouettes below so many times the shortest are left out where another runs beside them.
const SHORT: f64 = 3.0;
/// Share of each part of a line that must run beside another, or what of it in all may not, pixels.
const MOSTLY: f64 = 0.7;
const BARE: f64 = 3.0;
/// Depth by which a face must be nearer to hide a point, in parts of the depth.
const SLACK: f64 = 1e-6;
/// The same for edges, which lie in their faces' planes and touch their neighbours.
const EDGE_SLACK: f64 = 1e-4;
/// Gaps of creases below this are filled in where silhouettes are too short to be drawn, pixels.
const VACANT: f64 = 16.0;

/// What is too short to matter, in pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    /// Hidden gaps below this are bridged.
    pub gap: f64,
    /// Visible lines below this are dropped.
    pub run: f64,
    /// Lines nearer than this to a stronger one are left out.
    pub beside: f64,
}

/// A visible part of a path; on closed paths `end` may lie beyond the last point, and a whole loop
/// is as long as the path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Run {
    /// Where it begins.
    pub start: Place,
    /// Where it ends.
    pub end: Place,
}

/// The parts that are seen, and how many stretches had to be split.
#[derive(Clone, Debug, Default)]
pub struct Visible {
    /// Runs of each path, rising.
    pub runs: Vec<Vec<Run>>,
    /// The same runs as lines, in the order of the paths.
    pub lines: Vec<Line>,
    /// What of each path is left out because another line runs beside it, and what is in holes: neither is
    /// hidden.
    pub beside: Vec<Vec<Run>>,
    /// Stretches that voted.
    pub stretches: u64,
    /// Stretches whose samples did not agree.
    pub split: u64,
}

/// The visible parts of the paths of one frame. Lines of kinds that are not `drawn` never stand in
/// for others.
pub fn visible(
    paths: &[Path],
    sight: &Sight<'_>,
    view: &View,
    limits: &Limits,
    drawn: &dyn Fn(Kind) -> bool,
) -> Visible {
    let buried: Vec<Vec<bool>> = paths.iter().map(|p| buried(p, sight)).collect();
    let mut cuts = crossings(paths, &buried, view);
    let mut visible = Visible::default();
    let mut taken = HashSet::new();
    let mut look = |i: usize, taken: &HashSet<EdgeKey>, visible: &mut Visible| {
        let looker = Looker { path: &paths[i], buried: &buried[i], sight, view };
        let labels = looker.labels(std::mem::take(&mut cuts[i]), visible);
        runs(&paths[i], labels, limits.gap, taken)
    };
    // Silhouettes first: creases give way to them, and fill in where they are too short.
    let (outlines, mut others): (Vec<usize>, Vec<usize>) =
        (0..paths.len()).partition(|&i| paths[i].kind == Kind::Silhouette);
    others.sort_by_key(|&i| strength(paths[i].kind));
    let seen = outlines
        .into_iter()
        .flat_map(|i| look(i, &taken, &mut visible).into_iter().map(move |run| (i, run)))
        .collect();
    let mut beside = Beside::new(limits.beside);
    let outlines = joined(paths, seen, limits.gap, view);
    let all = outlines.iter().flat_map(|l| l.parts.iter().copied()).collect();
    let bits = Bits::of(paths, view, limits.run, all);
    let mut gone = Vec::new();
    let drawn_beside = drawn(Kind::Silhouette).then_some(&mut beside);
    visible.lines = kept(paths, outlines, &bits, drawn_beside, &mut gone);
    let parts = visible.lines.iter().flat_map(|l| &l.parts);
    if drawn(Kind::Silhouette) {
        taken.extend(parts.flat_map(|(i, r)| edges(&paths[*i], r.start, r.end)));
    }
    visible.beside = vec![Vec::new(); paths.len()];
    gone.into_iter().for_each(|(i, run)| visible.beside[i].push(run));
    for (path, beside) in paths.iter().zip(&mut visible.beside) {
        beside.extend(absent(path, sight));
    }
    for i in others {
        let all = look(i, &taken, &mut visible);
        let bits = Bits::of(paths, view, limits.run, all.iter().map(|r| (i, *r)).collect());
        for run in all {
            let (left, gone) = beside.parted(&paths[i], run);
            visible.beside[i].extend(gone.iter().map(|g| Run { start: g[0], end: g[1] }));
            for run in left.into_iter().filter(|r| bits.is_drawn(i, *r)) {
                visible.lines.push(Line::single(i, run));
                if drawn(paths[i].kind) {
                    beside.tell(&paths[i], run);
                }
            }
        }
    }
    visible.runs = vec![Vec::new(); paths.len()];
    for (i, run) in visible.lines.iter().flat_map(|l| &l.parts) {
        visible.runs[*i].push(*run);
    }
    visible.runs.iter_mut().for_each(|r| r.sort_by(|a, b| a.start.total_cmp(&b.start)));
    visible.lines.sort_by(|a, b| {
        let (a, b) = (a.parts[0], b.parts[0]);
        a.0.cmp(&b.0).then(a.1.start.total_cmp(&b.1.start))
    });
    visible
}

/// For each segment of a path, whether it is surely hidden, ends and middle; empty where nothing tells
/// without votes.
fn buried(path: &Path, sight: &Sight<'_>) -> Vec<bool> {
    if !sight.is_covered() {
        return Vec::new();
    }
    let hidden = |s: &Option<Seen>| s.is_some_and(|s| sight.surely_hidden(s.at, s.depth));
    let ends: Vec<bool> = path.seen.iter().map(hidden).collect();
    let middle = |k: usize| hidden(&path.seen_at(k as f64 + 0.5));
    (0..path.segments.len()).map(|k| ends[k] && ends[k + 1] && middle(k)).collect()
}

/// The parts of a path that are where masks leave nothing of its faces, to a pixel.
fn absent(path: &Path, sight: &Sight<'_>) -> Vec<Run> {
    let mut absent: Vec<Run> = Vec::new();
    let masked = |k: &usize| !path.fringe && sight.is_masked(&path.segments[*k].own);
    for k in (0..path.segments.len()).filter(masked) {
        let parts = (path.length[k + 1] - path.length[k]).ceil().max(1.0);
        for part in 0..parts as usize {
            let [start, end] = [part, part + 1].map(|p| k as f64 + p as f64 / parts);
            let middle = path.seen_at(0.5 * (start + end));
            if !middle.is_some_and(|s| sight.in_hole(s.at, &path.segments[k].own)) {
                continue;
            }
            match absent.last_mut() {
                Some(last) if last.end == start => last.end = end,
                _ => absent.push(Run { start, end }),
            }
        }
    }
    absent
}

/// Which of two lines side by side is drawn: the lower.
fn strength(kind: Kind) -> usize {
    Kind::ALL.iter().rev().position(|k| *k == kind).unwrap_or(0)
}

/// Lines without those that are too short, or short and beside a longer one, and without what of them is beside a
/// longer one, which is added to `gone`.
fn kept(
    paths: &[Path],
    mut lines: Vec<Line>,
    bits: &Bits<'_>,
    beside: Option<&mut Beside>,
    gone: &mut Vec<(usize, Run)>,
) -> Vec<Line> {
    let shortest = bits.shortest;
    let seen = |l: &Line| {
        l.total(paths) >= shortest || l.parts.iter().any(|(i, run)| bits.is_drawn(*i, *run))
    };
    let Some(beside) = beside else { return lines.into_iter().filter(seen).collect() };
    let long = |l: &Line| l.total(paths) >= SHORT * shortest;
    lines.retain(seen);
    // Sorting is stable: among equals the first stays first.
    lines.sort_by(|a, b| b.total(paths).total_cmp(&a.total(paths)));
    let mut kept = Vec::new();
    for line in lines {
        let share = |(i, run): &(usize, Run)| {
            let share = beside.share(&paths[*i], *run);
            (share, (1.0 - share) * paths[*i].run_length(*run))
        };
        let shares: Vec<(f64, f64)> = line.parts.iter().map(share).collect();
        let mostly = shares.iter().all(|s| s.0 >= MOSTLY);
        if !long(&line) && (mostly || shares.iter().map(|s| s.1).sum::<f64>() <= BARE) {
            continue;
        }
        for line in beside.parted_line(paths, line, gone).into_iter().filter(seen) {
            line.parts.iter().for_each(|(i, run)| beside.tell(&paths[*i], *run));
            kept.push(line);
        }
    }
    kept
}

/// A crease as the pair of faces beside it.
pub(crate) type EdgeKey = [u32; 2];

/// The creases along which a path runs between two places.
fn edges(path: &Path, from: Place, to: Place) -> impl Iterator<Item = EdgeKey> {
    let n = path.segments.len().max(1);
    let segments = (from as usize..to.ceil() as usize).map(move |k| path.segments[k % n]);
    let key = |s: Segment| [s.own[0].min(s.own[1]), s.own[0].max(s.own[1])];
    segments.filter(|s| s.own[0] != NONE && s.own[1] != NONE).map(key)
}

/// Whether a gap in a crease is there for silhouettes that are not drawn.
fn vacant(path: &Path, from: Place, to: Place, taken: &HashSet<EdgeKey>) -> bool {
    path.kind == Kind::Crease
        && path.length_at(to) - path.length_at(from) < VACANT
        && (from as usize..(to.ceil() as usize).min(path.segments.len()))
            .all(|k| path.segments[k].buried && !path.segments[k].outside)
        && edges(path, from, to).all(|e| !taken.contains(&e))
}

/// A part of a path with one label.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Label {
    pub(crate) start: Place,
    pub(crate) end: Place,
    pub(crate) seen: bool,
}

struct Looker<'a> {
    path: &'a Path,
    /// Segments that are surely hidden; empty where that is not known.
    buried: &'a [bool],
    sight: &'a Sight<'a>,
    view: &'a View,
}

impl Looker<'_> {
    /// Labels from the first point to the last.
    fn labels(&self, mut cuts: Vec<Place>, counts: &mut Visible) -> Vec<Label> {
        let segments = &self.path.segments;
        cuts.extend([0.0, segments.len() as f64]);
        let side = |k: usize| (segments[k].buried, segments[k].back);
        let changes = (1..segments.len()).filter(|&k| side(k) != side(k - 1));
        cuts.extend(changes.map(|k| k as f64));
        let changes = (1..self.buried.len()).filter(|&k| self.buried[k] != self.buried[k - 1]);
        cuts.extend(changes.map(|k| k as f64));
        cuts.sort_by(f64::total_cmp);
        let mut labels = Vec::new();
        for pair in cuts.windows(2).filter(|p| p[0] < p[1]) {
            let middle = ((0.5 * (pair[0] + pair[1])) as usize).min(segments.len() - 1);
            let within = pair[0] as usize..(pair[1].ceil() as usize).min(segments.len());
            let gone = self.buried.get(within).is_some_and(|b| b.iter().all(|b| *b));
            if segments[middle].buried || gone {
                labels.push(Label { start: pair[0], end: pair[1], seen: false });
            } else {
                self.stretch(pair[0], pair[1], &mut labels, counts);
            }
        }
        labels
    }

    fn stretch(&self, start: Place, end: Place, labels: &mut Vec<Label>, counts: &mut Visible) {
        let (from, to) = (self.path.length_at(start), self.path.length_at(end));
        let count = (((to - from) / SPACING).ceil() as usize).clamp(3, VOTES);
        let at = |i: usize| from + (to - from) * (i as f64 + 0.5) / count as f64;
        counts.stretches += 1;
        let sees = |i: usize| self.sees(self.path.place_at(at(i)));
        // Most stretches are of one mind: a few votes tell.
        let probes = PROBES[0].max(count / PROBES[1]);
        if count > probes {
            let probe = |k: usize| sees((2 * k + 1) * count / (2 * probes));
            let first = probe(0);
            if (1..probes).all(|k| probe(k) == first) {
                labels.push(Label { start, end, seen: first });
                return;
            }
        }
        let votes: Vec<bool> = (0..count).map(sees).collect();
        let share = votes.iter().filter(|v| **v).count() as f64 / count as f64;
        let agree = share >= AGREE || share <= 1.0 - AGREE;
        let most = share > 0.5;
        // Few that stand together are right, few that are scattered are not.
        let rows = || votes.chunk_by(|a, b| a == b);
        let firm = rows().any(|r| r[0] != most && r.len() >= ROW);
        if (agree && !firm) || to - from < 2.0 * SPACING {
            labels.push(Label { start, end, seen: most });
            return;
        }
        counts.split += 1;
        let short = |r: &[bool]| agree && r[0] != most && r.len() < ROW;
        let votes: Vec<bool> = rows()
            .flat_map(|r| std::iter::repeat_n(if short(r) { most } else { r[0] }, r.len()))
            .collect();
        self.split(start, end, &votes, at, labels);
    }

    /// Labels sample by sample, lone ones outvoted by their neighbours; changes are bisected.
    fn split(
        &self,
        start: Place,
        end: Place,
        votes: &[bool],
        at: impl Fn(usize) -> f64,
        labels: &mut Vec<Label>,
    ) {
        let n = votes.len();
        let calm: Vec<bool> = (0..n)
            .map(|i| {
                let (a, b) = (votes[i.saturating_sub(1)], votes[(i + 1).min(n - 1)]);
                if a == b { a } else { votes[i] }
            })
            .collect();
        let mut since = start;
        for i in 1..n {
            if calm[i] != calm[i - 1] {
                let change = self.change(at(i - 1), at(i), calm[i - 1]);
                labels.push(Label { start: since, end: change, seen: calm[i - 1] });
                since = change;
            }
        }
        labels.push(Label { start: since, end, seen: calm[n - 1] });
    }

    fn change(&self, mut from: f64, mut to: f64, seen: bool) -> Place {
        while to - from > 0.1 {
            let middle = 0.5 * (from + to);
            let side =
                if self.sees(self.path.place_at(middle)) == seen { &mut from } else { &mut to };
            *side = middle;
        }
        self.path.place_at(0.5 * (from + to))
    }

    fn sees(&self, place: Place) -> bool {
        let point = self.path.point(place);
        let (Some(seen), Some(plain)) = (self.view.see(point.pushed), self.view.see(point.world))
        else {
            return false;
        };
        let k = (place as usize).min(self.path.segments.len() - 1);
        let own = &self.path.segments[k].own;
        let met = self.path.kind == Kind::Intersection;
        let slack = if met || point.pushed == point.world { EDGE_SLACK } else { SLACK };
        (self.path.fringe || !self.sight.in_hole(seen.at, own))
            && !self.sight.hidden([seen, plain], slack * seen.depth, own)
    }
}

/// Labels to visible runs, gaps below `limit` pixels bridged; on closed paths across the first point
/// too.
pub(crate) fn runs(
    path: &Path,
    labels: Vec<Label>,
    limit: f64,
    taken: &HashSet<EdgeKey>,
) -> Vec<Run> {
    let mut runs: Vec<Run> = Vec::new();
    for label in labels.iter().filter(|l| l.seen) {
        match runs.last_mut() {
            Some(last)
                if bridged(path, last.end, label.start, limit)
                    || vacant(path, last.end, label.start, taken) =>
            {
                last.end = label.end;
            }
            _ => runs.push(Run { start: label.start, end: label.end }),
        }
    }
    let n = path.segments.len() as f64;
    if path.closed && !runs.is_empty() {
        let (first, last) = (runs[0], runs[runs.len() - 1]);
        let gap = path.total() - path.length_at(last.end) + path.length_at(first.start);
        let drawn = [last.end, n, 0.0, first.start];
        if gap < limit && continuous(path, &drawn) {
            if runs.len() == 1 {
                runs[0].end = runs[0].start + n;
            } else {
                runs.pop();
                runs[0] = Run { start: last.start, end: first.end + n };
                runs.rotate_left(1);
            }
        }
    }
    runs
}

/// The parts of a path inside the picture that its visible runs leave; those below `shortest`
/// pixels left out, and those that are a silhouette's.
pub(crate) fn hidden<'a>(
    path: &Path,
    runs: impl Iterator<Item = &'a Run>,
    shortest: f64,
) -> Vec<Run> {
    let n = path.segments.len() as f64;
    let mut covered: Vec<[Place; 2]> = Vec::new();
    for run in runs {
        covered.push([run.start, run.end.min(n)]);
        if run.end > n {
            covered.push([0.0, run.end - n]);
        }
    }
    let outside = |k: &usize| path.segments[*k].outside || path.segments[*k].shared;
    let outside = (0..path.segments.len()).filter(outside);
    covered.extend(outside.map(|k| [k as f64, (k + 1) as f64]));
    covered.push([n, n]);
    covered.sort_by(|a, b| a[0].total_cmp(&b[0]));
    let mut from = 0.0;
    let mut hidden = Vec::new();
    for [start, end] in covered {
        let run = Run { start: from, end: start };
        if start > from && path.run_length(run) >= shortest {
            hidden.push(run);
        }
        from = end.max(from);
    }
    hidden
}

/// Whether nothing between two places lies outside the picture.
fn continuous(path: &Path, places: &[Place]) -> bool {
    places.chunks(2).all(|p| {
        let range = (p[0] as usize)..(p[1].ceil() as usize).min(path.segments.len());
        range.into_iter().all(|k| path.seen[k].is_some() && !path.segments[k].outside)
    })
}

fn bridged(path: &Path, from: Place, to: Place, limit: f64) -> bool {
    from == to
        || (path.length_at(to) - path.length_at(from) < limit
            && continuous(path, &[from, to])
            && straight(path, from, to) < limit)
}

/// Distance in the picture between two places.
fn straight(path: &Path, from: Place, to: Place) -> f64 {
    let at = |p: Place| {
        let k = (p as usize).min(path.seen.len() - 1);
        path.seen[k].map_or(DVec2::INFINITY, |s| s.at)
    };
    at(from).distance(at(to))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::path::Point;
    use chiaro_basis::math::{DVec3, Vec3};
    use chiaro_scene::{Pose, Projection};

    #[test]
    fn a_short_line_that_is_all_but_beside_a_long_one_is_left_out() {
        let projection = Projection::Orthographic { half_height: 50.0 };
        let pose = Pose::look_at(Vec3::Z * 10.0, Vec3::ZERO, Vec3::Y, projection);
        let view = View::new(pose, (100, 100));
        let path = |a: [f64; 2], b: [f64; 2]| {
            let point = |[x, y]: [f64; 2]| {
                let world = DVec3::new(x, y, 0.0);
                Point { world, next: None, pushed: world, on_chain: 0.0 }
            };
            let plain = Segment::of([0; 2]);
            Path::new(Kind::Silhouette, 0, false, &[point(a), point(b)], &[plain], &view, 8.0)
        };
        // An edge, and the ends of two tiles before it; a corner that leaves it.
        let paths = [
            path([-40.0, 0.0], [40.0, 0.0]),
            path([0.0, 0.5], [4.8, 0.5]),
            path([4.8, 0.5], [4.8, 1.0]),
            path([4.8, 1.0], [9.6, 1.0]),
            path([20.0, 0.5], [24.0, 0.5]),
            path([24.0, 0.5], [24.0, 14.5]),
        ];
        let part = |i: usize| (i, Run { start: 0.0, end: 1.0 });
        let line = |parts: &[usize]| {
            let parts = parts.iter().copied().map(part).collect();
            Line { parts, closed: false }
        };
        let bits = Bits::of(&paths, &view, 10.0, (0..6).map(part).collect());
        let mut beside = Beside::new(1.5);
        let lines = vec![line(&[0]), line(&[1, 2, 3]), line(&[4, 5])];
        let kept = kept(&paths, lines, &bits, Some(&mut beside), &mut Vec::new());
        assert_eq!(kept, [line(&[0]), line(&[4, 5])]);
    }
}
