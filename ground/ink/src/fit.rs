//! Points along a border to few smooth curves, sharp corners kept.
//!
//! 1. Where points still follow the steps of pixels, these are taken out first (`relax.rs`).
//! 2. A corner is where two straight pieces meet at an angle over a limit; smoothing has rounded
//!    it, so it is put back where the pieces' lines cross.
//! 3. Between corners a uniform cubic B-spline runs along the points; its control points are moved
//!    against the (1, 4, 1) / 6 by which it smooths, so that bends do not shrink.
//! 4. The spline becomes straight lines where it is straight within the tolerance, and otherwise
//!    the cubics that `kurbo` fits to it by area and moment (Levien).
//!
//! The ends of an open run of points stay exactly where they are.

use crate::path::{distance, distance_to_segment};
use crate::relax::relaxed;
use crate::{Path, Point, Segment};
use kurbo::simplify::SimplifyBezPath;
use kurbo::{BezPath, ParamCurve, PathEl, PathSeg};

/// How curves are fitted. Lengths are in the unit of the points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fit {
    /// How far curves may be from the spline.
    pub tolerance: f64,
    /// The turn, in radians, from which on a bend is a corner; pi or more: none is.
    pub corner: f64,
    /// How far from a corner smoothing has moved points.
    pub blur: f64,
    /// Rounds that take steps of pixels out of points along borders; 0 where they are smooth.
    pub rounds: u32,
}

/// Fits a path to `points`; `None` without any. The first point is not repeated at the end of a
/// closed run.
pub fn fit(points: &[Point], closed: bool, how: &Fit) -> Option<Path> {
    if points.len() < 3 {
        return Path::through(points, closed);
    }
    let points = &relaxed(points, closed, how.rounds);
    let track = Track::new(points, closed);
    let corners = track.corners(how);
    let mut path = Path { start: points[0], segments: Vec::new(), closed };
    let runs = track.runs(&corners, how);
    if closed && corners.is_empty() {
        return Some(fit_loop(&runs[0], how));
    }
    path.start = runs[0][0];
    for run in &runs {
        fit_run(&mut path.segments, run, how);
    }
    Some(path)
}

/// Points with their places along the way.
struct Track<'a> {
    points: &'a [Point],
    closed: bool,
    /// Length up to each point, and of the whole for a closed track.
    along: Vec<f64>,
}

/// A corner: the place along the track, and where it is put.
struct Corner {
    along: f64,
    at: Point,
}

impl<'a> Track<'a> {
    fn new(points: &'a [Point], closed: bool) -> Self {
        let mut along = vec![0.0];
        let next = points.iter().skip(1).chain(closed.then_some(&points[0]));
        for (a, b) in points.iter().zip(next) {
            along.push(along[along.len() - 1] + distance(*a, *b));
        }
        Self { points, closed, along }
    }

    fn length(&self) -> f64 {
        self.along[self.along.len() - 1]
    }

    /// The point at a length along the track; past the ends of an open one, its ends.
    fn at(&self, s: f64) -> Point {
        let s = if self.closed { s.rem_euclid(self.length()) } else { s.clamp(0.0, self.length()) };
        let i = self.along.partition_point(|a| *a <= s).clamp(1, self.along.len() - 1) - 1;
        let (a, b) = (self.points[i], self.points[(i + 1) % self.points.len()]);
        let span = self.along[i + 1] - self.along[i];
        let t = if span > 0.0 { (s - self.along[i]) / span } else { 0.0 };
        [a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1])]
    }

    /// Corners in order along the track.
    fn corners(&self, how: &Fit) -> Vec<Corner> {
        let reach = 4.0 * how.blur;
        if how.corner >= std::f64::consts::PI || self.length() < 2.0 * reach || how.blur <= 0.0 {
            return Vec::new();
        }
        let found = |i: usize| Some((self.turn(self.along[i], how)?, i));
        let turns: Vec<Option<(f64, usize)>> = (0..self.points.len()).map(found).collect();
        let sharpest = |&(turn, i): &(f64, usize)| {
            // Sharper than everything near it; of equals the first.
            let rivals = turns.iter().flatten().filter(|(_, j)| self.apart(i, *j) < reach);
            rivals.into_iter().all(|&(t, j)| t < turn || (t == turn && j >= i))
        };
        let near: Vec<(f64, usize)> = turns.iter().flatten().copied().collect();
        near.iter().filter(|c| sharpest(c)).filter_map(|&(_, i)| self.corner(i, how)).collect()
    }

    fn apart(&self, i: usize, j: usize) -> f64 {
        let d = (self.along[i] - self.along[j]).abs();
        if self.closed { d.min(self.length() - d) } else { d }
    }

    /// The straight pieces before and after a place, as two points each, nearest first; `None`
    /// where the track bends or ends.
    fn sides(&self, s: f64, blur: f64) -> Option<[[Point; 2]; 2]> {
        let (near, far) = (1.5 * blur, 4.0 * blur);
        if !self.closed && (s < far || s > self.length() - far) {
            return None;
        }
        let side = |sign: f64| {
            let (a, b) = (self.at(s + sign * near), self.at(s + sign * far));
            let bend = (1..6).map(|k| near + (far - near) * f64::from(k) / 6.0);
            let straight = bend
                .into_iter()
                .all(|r| distance_to_segment(self.at(s + sign * r), a, b) < 0.07 * blur);
            straight.then_some([a, b])
        };
        Some([side(-1.0)?, side(1.0)?])
    }

    /// The turn at a place, if it is one of a corner.
    fn turn(&self, s: f64, how: &Fit) -> Option<f64> {
        let [[a, b], [c, d]] = self.sides(s, how.blur)?;
        let (u, v) = ([a[0] - b[0], a[1] - b[1]], [d[0] - c[0], d[1] - c[1]]);
        let turn = (u[0] * v[1] - u[1] * v[0]).atan2(u[0] * v[0] + u[1] * v[1]).abs();
        (turn > how.corner).then_some(turn)
    }

    /// Where the lines of the two sides cross, if that is near the track.
    fn corner(&self, i: usize, how: &Fit) -> Option<Corner> {
        let along = self.along[i];
        let [[a, b], [c, d]] = self.sides(along, how.blur)?;
        let (u, v) = ([a[0] - b[0], a[1] - b[1]], [c[0] - d[0], c[1] - d[1]]);
        let cross = u[0] * v[1] - u[1] * v[0];
        let t = ((c[0] - a[0]) * v[1] - (c[1] - a[1]) * v[0]) / cross;
        let at = [a[0] + t * u[0], a[1] + t * u[1]];
        let near =
            at.iter().all(|x| x.is_finite()) && distance(at, self.points[i]) < 2.0 * how.blur;
        near.then_some(Corner { along, at })
    }

    /// The points between corners, each run with its ends.
    fn runs(&self, corners: &[Corner], how: &Fit) -> Vec<Vec<Point>> {
        let n = self.points.len();
        let Some(first) = corners.first() else { return vec![self.points.to_vec()] };
        // From which length to which, and what stands at the two ends.
        let last = &corners[corners.len() - 1];
        let mut spans: Vec<(f64, f64, Option<Point>, Option<Point>)> = corners
            .windows(2)
            .map(|w| (w[0].along, w[1].along, Some(w[0].at), Some(w[1].at)))
            .collect();
        if self.closed {
            spans.push((last.along, first.along + self.length(), Some(last.at), Some(first.at)));
        } else {
            spans.insert(0, (f64::NEG_INFINITY, first.along, None, Some(first.at)));
            spans.push((last.along, f64::INFINITY, Some(last.at), None));
        }
        let margin = 1.5 * how.blur;
        let run = |&(from, to, start, end): &(f64, f64, Option<Point>, Option<Point>)| {
            let inside = |s: f64| s > from + margin && s < to - margin;
            let around = (0..n).map(|i| (self.along[i], self.points[i]));
            let again = (0..n).map(|i| (self.along[i] + self.length(), self.points[i]));
            let again = again.filter(|_| self.closed);
            let middle = around.chain(again).filter(|(s, _)| inside(*s)).map(|(_, p)| p);
            start.into_iter().chain(middle).chain(end).collect()
        };
        spans.iter().map(run).collect()
    }
}

/// Appends the curves of one run between corners.
fn fit_run(out: &mut Vec<Segment>, run: &[Point], how: &Fit) {
    let (Some(&start), Some(&end)) = (run.first(), run.last()) else { return };
    if run.iter().all(|p| distance_to_segment(*p, start, end) < how.tolerance) {
        out.push(Segment::Line(end));
        return;
    }
    let inner = (1..run.len() - 1).map(|i| sharpened(&run[i - 1..i + 2]));
    let run: Vec<Point> = std::iter::once(start).chain(inner).chain(std::iter::once(end)).collect();
    let phantom = |a: Point, b: Point| [2.0 * a[0] - b[0], 2.0 * a[1] - b[1]];
    let mut control = vec![phantom(start, run[1])];
    control.extend_from_slice(&run);
    control.push(phantom(end, run[run.len() - 2]));
    append(out, &spline(&control), how, end);
}

/// Fits a closed run without corners.
fn fit_loop(run: &[Point], how: &Fit) -> Path {
    let n = run.len();
    let near = |i: usize| [run[(i + n - 1) % n], run[i], run[(i + 1) % n]];
    let run: Vec<Point> = (0..n).map(|i| sharpened(&near(i))).collect();
    let control: Vec<Point> = (0..n + 3).map(|i| run[(i + n - 1) % n]).collect();
    let spline = spline(&control);
    let start = knot(&control[..3]);
    let mut segments = Vec::new();
    append(&mut segments, &spline, how, start);
    Path { start, segments, closed: true }
}

/// The uniform cubic B-spline of control points, as Bézier curves.
fn spline(control: &[Point]) -> BezPath {
    let point = |p: Point| kurbo::Point::new(p[0], p[1]);
    let third = |a: Point, b: Point| point(std::array::from_fn(|i| (2.0 * a[i] + b[i]) / 3.0));
    let mut path = BezPath::new();
    path.move_to(point(knot(&control[..3])));
    for c in control.windows(4) {
        path.curve_to(third(c[1], c[2]), third(c[2], c[1]), point(knot(&c[1..])));
    }
    path
}

/// The middle one of three points, moved against the spline's smoothing.
fn sharpened(p: &[Point]) -> Point {
    let passed = knot(p);
    std::array::from_fn(|i| 2.0 * p[1][i] - passed[i])
}

/// Where the spline passes the middle one of three control points.
fn knot(c: &[Point]) -> Point {
    std::array::from_fn(|i| (c[0][i] + 4.0 * c[1][i] + c[2][i]) / 6.0)
}

/// Fits few cubics to a spline and ends them exactly at `end`. Where a fit leaves the spline, as happens
/// at cusps, the spline's own cubics stand.
fn append(out: &mut Vec<Segment>, spline: &BezPath, how: &Fit, end: Point) {
    let source = SimplifyBezPath::new(spline.iter());
    let fitted = kurbo::fit_to_bezpath(&source, how.tolerance);
    let from = out.len();
    out.extend(segments(if stays(&fitted, spline, how) { &fitted } else { spline }));
    match out[from..].last_mut() {
        Some(Segment::Line(p) | Segment::Cubic(_, _, p)) => *p = end,
        None => out.push(Segment::Line(end)),
    }
}

fn segments(path: &BezPath) -> impl Iterator<Item = Segment> + '_ {
    let point = |p: kurbo::Point| [p.x, p.y];
    path.elements().iter().filter_map(move |element| match *element {
        PathEl::LineTo(p) => Some(Segment::Line(point(p))),
        PathEl::CurveTo(a, b, p) => Some(Segment::Cubic(point(a), point(b), point(p))),
        _ => None,
    })
}

/// Whether curves fitted to a spline stay near it. Only those with long handles are looked at: others
/// cannot leave their ends by much.
fn stays(fitted: &BezPath, spline: &BezPath, how: &Fit) -> bool {
    let mut way: Option<Vec<kurbo::Point>> = None;
    fitted.segments().all(|segment| {
        let PathSeg::Cubic(c) = segment else { return true };
        let chord = (c.p3 - c.p0).hypot();
        let handle = (c.p1 - c.p0).hypot().max((c.p3 - c.p2).hypot());
        if handle <= chord {
            return handle.is_finite();
        }
        let way = way.get_or_insert_with(|| passed(spline));
        let limit = 4.0 * how.tolerance + 0.25 * how.blur;
        (1..16).map(|i| c.eval(f64::from(i) / 16.0)).all(|p| {
            let near = |w: &[kurbo::Point]| {
                distance_to_segment([p.x, p.y], [w[0].x, w[0].y], [w[1].x, w[1].y]) <= limit
            };
            way.windows(2).any(near)
        })
    })
}

/// Points on a spline, close to each other.
fn passed(spline: &BezPath) -> Vec<kurbo::Point> {
    let steps = |s: PathSeg| (0..=4).map(move |i| s.eval(f64::from(i) / 4.0));
    spline.segments().flat_map(steps).collect()
}

/// `points` without those that the rest stands for within `tolerance` (Douglas and Peucker); the
/// ends stay. Without recursion.
pub fn simplified(points: &[Point], tolerance: f64) -> Vec<Point> {
    let mut keep = vec![false; points.len()];
    let mut spans = vec![(0, points.len().saturating_sub(1))];
    while let Some((a, b)) = spans.pop() {
        if a < points.len() {
            keep[a] = true;
            keep[b] = true;
        }
        let off = |i: &usize| distance_to_segment(points[*i], points[a], points[b]);
        let farthest = (a + 1..b).max_by(|i, j| off(i).total_cmp(&off(j)));
        if let Some(i) = farthest.filter(|i| off(i) > tolerance) {
            spans.extend([(a, i), (i, b)]);
        }
    }
    points.iter().zip(keep).filter_map(|(p, k)| k.then_some(*p)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const HOW: Fit = Fit { tolerance: 0.1, corner: 0.7, blur: 1.5, rounds: 0 };

    fn circle(radius: f64) -> Vec<Point> {
        let n = (radius * 6.0) as usize;
        let at = |i: usize| std::f64::consts::TAU * i as f64 / n as f64;
        (0..n).map(|i| [50.0 + radius * at(i).cos(), 50.0 + radius * at(i).sin()]).collect()
    }

    #[test]
    fn a_circle_becomes_few_round_curves() {
        for radius in [6.0, 14.0, 40.0] {
            let path = fit(&circle(radius), true, &HOW).unwrap();
            assert!(path.closed && path.segments.len() <= 12, "{}", path.segments.len());
            for p in path.points(0.01) {
                let off = (p[0] - 50.0).hypot(p[1] - 50.0) - radius;
                assert!(off.abs() < 0.2, "radius {radius}: off by {off}");
            }
        }
    }

    #[test]
    fn a_rounded_square_gets_its_corners_back() {
        // The square's outline, smoothed as labels are.
        let mut points: Vec<Point> = Vec::new();
        let sides = [[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0]];
        let mut at = [10.0, 10.0];
        for d in sides {
            for _ in 0..30 {
                points.push(at);
                at = [at[0] + d[0], at[1] + d[1]];
            }
        }
        for _ in 0..2 {
            let n = points.len();
            let mean = |i: usize| {
                let (a, b, c) = (points[(i + n - 1) % n], points[i], points[(i + 1) % n]);
                std::array::from_fn(|k| 0.25 * a[k] + 0.5 * b[k] + 0.25 * c[k])
            };
            points = (0..n).map(mean).collect();
        }
        let path = fit(&points, true, &HOW).unwrap();
        assert_eq!(path.segments.len(), 4, "{path:?}");
        for corner in [[10.0, 10.0], [40.0, 10.0], [40.0, 40.0], [10.0, 40.0]] {
            let near = path.segments.iter().map(|s| distance(s.end(), corner));
            assert!(near.fold(9.0, f64::min) < 0.1, "{corner:?} in {path:?}");
        }
    }

    #[test]
    fn open_runs_keep_their_ends() {
        let wave = |i: usize| [i as f64, 4.0 * (i as f64 * 0.2).sin()];
        let points: Vec<Point> = (0..60).map(wave).collect();
        let path = fit(&points, false, &HOW).unwrap();
        assert_eq!((path.start, path.end()), (points[0], points[59]));
        assert!(path.segments.len() < 16);
        let off = |p: &Point| (p[1] - 4.0 * (p[0] * 0.2).sin()).abs();
        assert!(path.points(0.01).iter().all(|p| off(p) < 0.25));
    }

    #[test]
    fn simplifying_keeps_shape_and_ends() {
        let points: Vec<Point> =
            (0..100).map(|i| [i as f64, if i < 50 { 0.01 } else { 5.0 }]).collect();
        let few = simplified(&points, 0.05);
        assert_eq!(few.len(), 4);
        assert_eq!((few[0], few[3]), (points[0], points[99]));
        assert!(simplified(&[], 0.1).is_empty());
        assert_eq!(simplified(&points[..1], 0.1).len(), 1);
    }

    #[test]
    fn curves_never_leave_what_they_are_fitted_to() {
        // Walks of short steps that turn back on themselves now and then, as outlines of a pen do.
        let mut state = 1u64;
        let mut random = move || {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (state >> 40) as f64 / (1u64 << 24) as f64
        };
        for walk in 0..400 {
            let (mut at, mut heading) = ([50.0, 50.0], 6.3 * random());
            let mut points = vec![at];
            for _ in 0..12 {
                heading +=
                    if random() < 0.2 { std::f64::consts::PI } else { 0.3 * (random() - 0.5) };
                let step = if random() < 0.3 { 0.001 } else { 0.1 };
                at = [at[0] + step * heading.cos(), at[1] + step * heading.sin()];
                points.push(at);
            }
            let how = Fit { tolerance: 0.02, corner: 0.785, blur: 0.4, rounds: 0 };
            let Some(path) = fit(&points, walk % 2 == 0, &how) else { continue };
            for p in path.points(0.01) {
                let off = points.iter().map(|q| distance(p, *q)).fold(f64::INFINITY, f64::min);
                assert!(off < 0.3, "walk {walk}: {off} off");
            }
        }
    }
}
