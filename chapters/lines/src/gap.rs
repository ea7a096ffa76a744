//! [`Gap`]: what is not drawn of a line between two strokes of it.

use crate::path::{Kind, Path, Place};
use crate::stroke::Stroke;
use crate::visibility::Run;
use std::collections::BTreeMap;

/// Places on a chain that differ by less are one.
const SAME: f64 = 1e-6;
/// A line is seen to go on where it takes no longer way than so many times the distance, and these pixels.
const DETOUR: (f64, f64) = (1.5, 4.0);

/// A stretch of a line that is hidden, or left out, between the end of one stroke and the start of another.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gap {
    /// The line's kind.
    pub kind: Kind,
    /// Its chain, in this frame.
    pub chain: u32,
    /// Where on the chain a stroke ends, and where one starts, as [`crate::Sample::on_chain`] has it.
    pub on_chain: [f64; 2],
    /// Its picture length, pixels.
    pub length: f64,
    /// Picture length of the whole line, hidden parts too, pixels, where it closes: somewhere it has a seam.
    pub around: Option<f64>,
}

/// A gap and the strokes of its frame that it lies between.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Between {
    /// What ends and what starts, by index.
    pub(crate) strokes: [usize; 2],
    /// The gap's length, pixels.
    pub(crate) length: f64,
    /// As [`Gap::around`] has it.
    pub(crate) around: Option<f64>,
}

/// A run of a path that is a stroke, or a part of one.
#[derive(Clone, Copy)]
pub(crate) struct Shown {
    pub(crate) path: usize,
    pub(crate) run: Run,
    /// Whether the stroke starts, and whether it ends here.
    pub(crate) is_end: [bool; 2],
}

/// The gaps between what is `shown` of some paths. What leaves the picture on its way is none, nor is what
/// nobody would take for one line: outlines that turn back behind what they are of. Where a line closes one of its gaps
/// may be its seam: which, is told by u over the film, not by how long they are in one frame.
pub(crate) fn gaps(paths: &[Path], mut shown: Vec<Shown>) -> Vec<Gap> {
    shown.sort_by(|a, b| a.path.cmp(&b.path).then(a.run.start.total_cmp(&b.run.start)));
    let mut gaps = Vec::new();
    for own in shown.chunk_by(|a, b| a.path == b.path) {
        let path = &paths[own[0].path];
        let around = path.closed.then_some((own[own.len() - 1], own[0], true));
        let pairs = own.windows(2).map(|p| (p[0], p[1], false)).chain(around);
        let ends = pairs.filter(|(a, b, _)| a.is_end[1] && b.is_end[0]);
        gaps.extend(ends.filter_map(|(a, b, around)| gap(path, [a.run.end, b.run.start], around)));
    }
    gaps
}

/// The strokes of a frame between which gaps lie.
pub(crate) fn between<'a>(strokes: impl Iterator<Item = &'a Stroke>, gaps: &[Gap]) -> Vec<Between> {
    let mut ends: BTreeMap<(Kind, u32, bool), Vec<(f64, usize)>> = BTreeMap::new();
    for (i, stroke) in strokes.enumerate().filter(|(_, s)| !s.closed) {
        for sample in [(stroke.samples.first(), true), (stroke.samples.last(), false)] {
            if let (Some(sample), starts) = sample {
                let of_chain = ends.entry((stroke.kind, sample.chain, starts)).or_default();
                of_chain.push((sample.on_chain, i));
            }
        }
    }
    let at = |gap: &Gap, starts: bool| {
        let place = gap.on_chain[usize::from(starts)];
        let of_chain = ends.get(&(gap.kind, gap.chain, starts))?;
        of_chain.iter().find(|end| (end.0 - place).abs() <= SAME).map(|end| end.1)
    };
    let between = |gap: &Gap| {
        let strokes = [at(gap, false)?, at(gap, true)?];
        Some(Between { strokes, length: gap.length, around: gap.around })
    };
    gaps.iter().filter_map(between).collect()
}

/// The gap between two places of a path, or past its last point where it is closed.
fn gap(path: &Path, [from, to]: [Place; 2], around: bool) -> Option<Gap> {
    let n = path.segments.len() as f64;
    let once = |place: Place| if place > n { place - n } else { place };
    let (pieces, turn) = match around {
        true if from <= n => ([[from, n], [0.0, to]], path.total()),
        true => ([[from - n, to], [to, to]], path.total()),
        false => ([[from, to], [to, to]], 0.0),
    };
    let is_inside = pieces.iter().all(|[from, to]| {
        let segments = (*from as usize)..(to.ceil() as usize).min(path.segments.len());
        segments.into_iter().all(|k| path.seen[k].is_some() && !path.segments[k].outside)
    });
    let length = path.length_around(to) + turn - path.length_around(from);
    let on_chain = [from, to].map(|place| path.point(once(place)).on_chain);
    let around = path.closed.then(|| path.total());
    let whole = Gap { kind: path.kind, chain: path.chain, on_chain, length, around };
    let ends = path.seen_at(from).zip(path.seen_at(to));
    let (times, more) = DETOUR;
    let goes_on = ends.is_some_and(|(a, b)| length <= times * a.at.distance(b.at) + more);
    (is_inside && goes_on && length >= 0.0).then_some(whole)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::path::{Point, Segment};
    use crate::view::View;
    use chiaro_basis::math::{DVec3, Vec3};
    use chiaro_scene::{Pose, Projection};

    #[test]
    fn gaps_go_round_closed_paths() {
        let projection = Projection::Orthographic { half_height: 50.0 };
        let pose = Pose::look_at(Vec3::Z * 10.0, Vec3::ZERO, Vec3::Y, projection);
        let view = View::new(pose, (100, 100));
        let corners = [[-20.0, -20.0], [20.0, -20.0], [20.0, 20.0], [-20.0, 20.0], [-20.0, -20.0]];
        let point = |(k, p): (usize, &[f64; 2])| {
            let world = DVec3::new(p[0], p[1], 0.0);
            Point { world, next: None, pushed: world, on_chain: k as f64 }
        };
        let points: Vec<Point> = corners.iter().enumerate().map(point).collect();
        let plain = Segment::of([0; 2]);
        let path = Path::new(Kind::Silhouette, 3, true, &points, &[plain; 4], &view, 0.0);
        let shown =
            |start: f64, end: f64| Shown { path: 0, run: Run { start, end }, is_end: [true; 2] };
        let paths = [path];
        let rounded = |x: f64| (1e6 * x).round() / 1e6;
        let of = |shown: &[Shown]| -> Vec<([f64; 2], f64)> {
            let gaps = gaps(&paths, shown.to_vec());
            gaps.iter().map(|g| (g.on_chain.map(rounded), rounded(g.length))).collect()
        };
        let side = 40.0;
        // Past the first point.
        assert_eq!(of(&[shown(3.5, 3.8), shown(0.1, 1.0)]), [([3.8, 0.1], 0.3 * side)]);
        // All round, and where a run is past it.
        let round = [([3.0, 3.5], 0.5 * side), ([0.5, 1.2], 0.7 * side)];
        assert_eq!(of(&[shown(1.2, 3.0), shown(3.5, 4.5)]), round);
        let round = [([3.0, 3.9], 0.9 * side), ([1.1, 1.5], 0.4 * side)];
        assert_eq!(of(&[shown(1.5, 3.0), shown(3.9, 5.1)]), round);
        let whole = gaps(&paths, vec![shown(1.2, 3.0), shown(3.5, 4.5)]);
        assert!(whole.iter().all(|g| g.around.is_some_and(|a| (a - 4.0 * side).abs() < 1e-6)));
        // Nobody takes what comes back after three sides for the same line.
        assert_eq!(of(&[shown(0.2, 0.4), shown(0.5, 0.6)]), [([0.4, 0.5], 0.1 * side)]);
        let joined = Shown { is_end: [true, false], ..shown(0.5, 1.0) };
        assert_eq!(of(&[joined, shown(1.5, 3.0)]), [([3.0, 0.5], 1.5 * side)]);
    }
}
