//! The way of a pen: strokes joined, ordered and reversed for little travel with the pen up.
//!
//! 1. Open strokes whose ends lie within a given distance are joined, at each end to the stroke
//!    that goes on most nearly straight.
//! 2. From the page's corner on, the pen goes to the nearest end of a stroke that is left; a closed
//!    stroke is entered at its nearest point.
//! 3. Runs of strokes are reversed as long as that saves travel (2-opt within a window).
//!
//! Deterministic; not the shortest tour, but within some percent of what 2-opt finds.

use crate::drawing::Travel;
use crate::path::distance;
use crate::{Path, Point, Segment};
use std::collections::HashMap;

/// Strokes in the order in which they are drawn.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    /// The strokes.
    pub paths: Vec<Path>,
    /// How far the pen goes.
    pub travel: Travel,
}

/// Joins, orders and reverses strokes.
pub fn plan(paths: Vec<Path>, join: f64) -> Plan {
    let (routed, travel) = route(joined(paths, join));
    Plan { paths: routed.into_iter().map(|(_, path)| path).collect(), travel }
}

/// Orders and reverses strokes without joining any; each comes with its index in `paths`.
pub fn route(paths: Vec<Path>) -> (Vec<(usize, Path)>, Travel) {
    let paths = untangled(ordered(paths));
    let mut at = [0.0; 2];
    let mut travel = Travel::default();
    for (_, path) in &paths {
        travel.up += distance(at, path.start);
        travel.down += path.length();
        at = path.end();
    }
    (paths, travel)
}

/// An end of a stroke: its number, and whether it is the last point.
type End = (usize, bool);

/// Ends of strokes by the cell of a grid that they lie in.
struct Grid {
    cell: f64,
    cells: HashMap<(i64, i64), Vec<End>>,
}

impl Grid {
    fn new(cell: f64) -> Self {
        Self { cell, cells: HashMap::new() }
    }

    fn key(&self, p: Point) -> (i64, i64) {
        ((p[0] / self.cell).floor() as i64, (p[1] / self.cell).floor() as i64)
    }

    fn insert(&mut self, at: Point, end: End) {
        self.cells.entry(self.key(at)).or_default().push(end);
    }

    fn remove(&mut self, at: Point, end: End) {
        if let Some(ends) = self.cells.get_mut(&self.key(at)) {
            ends.retain(|e| *e != end);
        }
    }

    /// Ends in the cells at exactly `ring` cells' distance from a point's own.
    fn ring(&self, at: Point, ring: i64) -> impl Iterator<Item = End> + '_ {
        let (cx, cy) = self.key(at);
        let edge = move |d: i64| if d.abs() == ring { 1 } else { 2 * ring };
        (-ring..=ring)
            .flat_map(move |dy| {
                let step = edge(dy).max(1) as usize;
                (-ring..=ring).step_by(step).map(move |dx| (cx + dx, cy + dy))
            })
            .filter_map(|key| self.cells.get(&key))
            .flatten()
            .copied()
    }
}

/// Open strokes whose ends lie within `join` of each other, joined to longer ones and to closed
/// ones.
pub fn joined(paths: Vec<Path>, join: f64) -> Vec<Path> {
    if join <= 0.0 {
        return paths;
    }
    let mut grid = Grid::new(join);
    let mut left: Vec<Option<Path>> = paths.into_iter().map(Some).collect();
    for (i, path) in left.iter().enumerate() {
        if let Some(path) = path.as_ref().filter(|p| !p.closed) {
            grid.insert(path.start, (i, false));
            grid.insert(path.end(), (i, true));
        }
    }
    let mut out = Vec::new();
    for i in 0..left.len() {
        let Some(mut path) = take(&mut left, &mut grid, i) else { continue };
        if !path.closed {
            for _ in 0..2 {
                while let Some((next, from_end)) = continuation(&path, &left, &grid, join) {
                    let other =
                        take(&mut left, &mut grid, next).expect("the grid holds what is left");
                    path.extend(&if from_end { other.reversed() } else { other });
                }
                path = path.reversed();
            }
            path.closed = path.segments.len() > 2 && distance(path.start, path.end()) <= join;
        }
        out.push(path);
    }
    out
}

fn take(left: &mut [Option<Path>], grid: &mut Grid, i: usize) -> Option<Path> {
    let path = left[i].take()?;
    grid.remove(path.start, (i, false));
    grid.remove(path.end(), (i, true));
    Some(path)
}

/// The stroke that goes on from a path's end most nearly straight, and whether by its end.
fn continuation(path: &Path, left: &[Option<Path>], grid: &Grid, join: f64) -> Option<End> {
    let at = path.end();
    let back = heading(path, true);
    let turn = |&(i, last): &End| {
        let other = left[i].as_ref()?;
        let from = if last { other.end() } else { other.start };
        (distance(at, from) <= join).then(|| {
            let on = heading(other, last);
            // Headings point into each stroke: straight on is opposite.
            on[0] * back[0] + on[1] * back[1]
        })
    };
    let near = (0..=1).flat_map(|r| grid.ring(at, r));
    let ends = near.filter_map(|end| Some((turn(&end)?, end)));
    ends.min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1))).map(|(_, end)| end)
}

/// The unit direction in which a path leaves its start, or its end.
fn heading(path: &Path, from_end: bool) -> Point {
    let (from, controls) = if from_end { leaving_end(path) } else { leaving_start(path) };
    let far = |p: &Point| distance(*p, from) > 1e-9;
    let target = controls.into_iter().find(far).unwrap_or([from[0] + 1.0, from[1]]);
    let length = distance(target, from);
    [(target[0] - from[0]) / length, (target[1] - from[1]) / length]
}

fn leaving_start(path: &Path) -> (Point, [Point; 3]) {
    let first = path.segments.first().copied().unwrap_or(Segment::Line(path.start));
    match first {
        Segment::Line(p) => (path.start, [p; 3]),
        Segment::Cubic(a, b, p) => (path.start, [a, b, p]),
    }
}

fn leaving_end(path: &Path) -> (Point, [Point; 3]) {
    let before = path.segments.iter().rev().nth(1).map_or(path.start, Segment::end);
    match path.segments.last().copied().unwrap_or(Segment::Line(path.start)) {
        Segment::Line(p) => (p, [before; 3]),
        Segment::Cubic(a, b, p) => (p, [b, a, before]),
    }
}

/// Nearest end next.
fn ordered(paths: Vec<Path>) -> Vec<(usize, Path)> {
    let cell = cell_size(&paths);
    let mut grid = Grid::new(cell);
    for (i, path) in paths.iter().enumerate() {
        grid.insert(path.start, (i, false));
        if !path.closed {
            grid.insert(path.end(), (i, true));
        }
    }
    let reach = reach(&paths, cell);
    let mut out: Vec<(usize, Path)> = Vec::with_capacity(paths.len());
    let mut at = [0.0; 2];
    while let Some((i, last)) = nearest(&grid, &paths, at, reach) {
        let path = &paths[i];
        grid.remove(path.start, (i, false));
        if !path.closed {
            grid.remove(path.end(), (i, true));
        }
        let path = if last { path.reversed() } else { entered_near(path, at) };
        at = path.end();
        out.push((i, path));
    }
    out
}

/// Cells that hold about two ends each.
fn cell_size(paths: &[Path]) -> f64 {
    let far = paths.iter().flat_map(|p| p.start).fold(1.0, |a: f64, b| a.max(b.abs()));
    far / (paths.len() as f64).sqrt().max(1.0)
}

/// Rings of cells that surely hold everything.
fn reach(paths: &[Path], cell: f64) -> i64 {
    let all = paths.iter().flat_map(|p| [p.start, p.end()]).flatten();
    let far = all.fold(0.0, |a: f64, b| a.max(b.abs()));
    (2.0 * far / cell).ceil() as i64 + 2
}

fn nearest(grid: &Grid, paths: &[Path], at: Point, reach: i64) -> Option<End> {
    let place = |(i, last): End| if last { paths[i].end() } else { paths[i].start };
    let mut best: Option<(f64, End)> = None;
    for ring in 0..=reach {
        // What lies in this ring is at least ring - 1 cells away.
        if best.is_some_and(|(d, _)| d <= (ring - 1) as f64 * grid.cell) {
            break;
        }
        for end in grid.ring(at, ring) {
            let candidate = (distance(at, place(end)), end);
            if best.is_none_or(|b| candidate < b) {
                best = Some(candidate);
            }
        }
    }
    best.map(|(_, end)| end)
}

/// A closed path begun at its joint nearest to a point.
fn entered_near(path: &Path, at: Point) -> Path {
    if !path.closed || path.segments.is_empty() {
        return path.clone();
    }
    let mut segments = path.segments.clone();
    if distance(path.segments[segments.len() - 1].end(), path.start) > 1e-9 {
        segments.push(Segment::Line(path.start));
    }
    let near = |i: &usize| distance(segments[*i].end(), at);
    let best = (0..segments.len()).min_by(|a, b| near(a).total_cmp(&near(b)));
    let first = best.map_or(0, |i| i + 1) % segments.len();
    segments.rotate_left(first);
    let start = segments[segments.len() - 1].end();
    Path { start, segments, closed: true }
}

/// How far apart in the order two strokes are tried, and how often at most.
const WINDOW: usize = 120;
const ROUNDS: usize = 12;

/// 2-opt: reverses runs of strokes while that shortens the way.
fn untangled(paths: Vec<(usize, Path)>) -> Vec<(usize, Path)> {
    // The two ends of each stroke as drawn now, and its number, negative when reversed.
    let mut ends: Vec<(Point, Point)> = paths.iter().map(|(_, p)| (p.start, p.end())).collect();
    let mut order: Vec<(usize, bool)> = (0..paths.len()).map(|i| (i, false)).collect();
    for _ in 0..ROUNDS {
        let mut changed = false;
        for i in 0..order.len() {
            let before = if i == 0 { [0.0; 2] } else { ends[i - 1].1 };
            for j in i..(i + WINDOW).min(order.len()) {
                let after = ends.get(j + 1).map(|e| e.0);
                let (first, last) = (ends[i].0, ends[j].1);
                let way = |a: Point, b: Point| {
                    distance(before, a) + after.map_or(0.0, |c| distance(b, c))
                };
                if way(last, first) < way(first, last) - 1e-9 {
                    order[i..=j].reverse();
                    ends[i..=j].reverse();
                    order[i..=j].iter_mut().for_each(|o| o.1 = !o.1);
                    ends[i..=j].iter_mut().for_each(|e| *e = (e.1, e.0));
                    changed = true;
                }
            }
        }
        if !changed {
            break;
        }
    }
    let drawn = |(i, back): (usize, bool)| match back {
        true => (paths[i].0, paths[i].1.reversed()),
        false => paths[i].clone(),
    };
    order.into_iter().map(drawn).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use chiaro_basis::random;

    fn line(a: Point, b: Point) -> Path {
        Path::through(&[a, b], false).unwrap()
    }

    #[test]
    fn strokes_that_meet_become_one() {
        let parts = vec![
            line([0.0, 0.0], [1.0, 0.0]),
            line([3.0, 0.0], [2.0, 0.05]),
            line([1.05, 0.0], [2.0, 0.0]),
        ];
        let plan = plan(parts, 0.1);
        assert_eq!(plan.paths.len(), 1);
        assert!(plan.travel.up < 1e-9 && (plan.travel.down - 3.0).abs() < 0.11);
    }

    #[test]
    fn crossing_strokes_are_joined_straight_on() {
        let parts = vec![
            line([0.0, 5.0], [5.0, 5.0]),
            line([5.0, 5.0], [5.0, 9.0]),
            line([5.0, 5.0], [9.0, 5.0]),
            line([5.0, 1.0], [5.0, 5.0]),
        ];
        let plan = plan(parts, 0.1);
        assert_eq!(plan.paths.len(), 2);
        let straight = |p: &Path| p.start[0] == p.end()[0] || p.start[1] == p.end()[1];
        assert!(plan.paths.iter().all(straight));
    }

    #[test]
    fn four_sides_close_to_a_square() {
        let corners = [[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [0.0, 4.0]];
        let sides = (0..4).map(|i| line(corners[i], corners[(i + 1) % 4])).collect();
        let plan = plan(sides, 0.1);
        assert_eq!(plan.paths.len(), 1);
        assert!(plan.paths[0].closed && (plan.travel.down - 16.0).abs() < 1e-9);
    }

    #[test]
    fn nothing_is_lost_and_little_is_travelled() {
        let at = |i: u64| [100.0 * random::unit(1, i), 100.0 * random::unit(2, i)].map(f64::from);
        let paths: Vec<Path> = (0..400).map(|i| line(at(i), at(i).map(|x| x + 2.0))).collect();
        let drawn: f64 = paths.iter().map(Path::length).sum();
        let mut before = 0.0;
        let mut pen = [0.0; 2];
        for p in &paths {
            before += distance(pen, p.start);
            pen = p.end();
        }
        let plan = plan(paths, 0.0);
        assert_eq!(plan.paths.len(), 400);
        assert!((plan.travel.down - drawn).abs() < 1e-6);
        assert!(plan.travel.up < 0.06 * before, "{} of {before}", plan.travel.up);
    }

    #[test]
    fn a_route_keeps_every_stroke_and_says_which_it_is() {
        let paths: Vec<Path> = (0..40)
            .map(|i| {
                let x = f64::from(i * 17 % 40);
                if i % 3 == 0 { line([x, 9.0], [x, 0.0]) } else { line([x, 0.0], [x, 9.0]) }
            })
            .collect();
        let before: f64 = paths.windows(2).map(|p| distance(p[0].end(), p[1].start)).sum();
        let (routed, travel) = route(paths.clone());
        assert!(travel.up < 0.2 * before, "{} of {before}", travel.up);
        let mut seen: Vec<usize> = routed.iter().map(|r| r.0).collect();
        seen.sort_unstable();
        assert_eq!(seen, (0..40).collect::<Vec<_>>());
        for (i, path) in routed {
            assert!(path == paths[i] || path == paths[i].reversed());
        }
    }

    #[test]
    fn closed_strokes_are_entered_where_the_pen_is() {
        let far = Path::through(&[[90.0, 90.0], [10.0, 90.0], [1.0, 1.0]], true).unwrap();
        let plan = plan(vec![far], 0.1);
        assert_eq!(plan.paths[0].start, [1.0, 1.0]);
        assert!(plan.paths[0].closed);
    }
}
