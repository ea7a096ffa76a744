//! Points along a border to few smooth curves, sharp corners kept.
//!
//! 1. Where points still follow the steps of pixels, these are taken out first (`relax.rs`).
//! 2. A corner is where two straight pieces meet at an angle over a limit; smoothing has rounded
//!    it, so it is put back where the pieces' lines cross.
//! 3. Between corners a uniform cubic B-spline runs along the points; its control points are moved
//!    against the (1, 4, 1) / 6 by which it smooths, so that bends do not shrink.
//! 4. The spline becomes straight lines where it is straight within the tolerance, and otherwise
//!    the cubics that `kurbo` fits to runs of it by area and moment (Levien), halved until they fit.
//!
//! The ends of an open run of points stay exactly where they are.

use crate::path::{distance, distance_to_segment};
use crate::relax::relaxed;
use crate::{Path, Point, Segment};
use kurbo::simplify::SimplifyBezPath;
use kurbo::{BezPath, CubicBez, ParamCurve, ParamCurveDeriv, ParamCurveFit};
use std::ops::Range;

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
    let points = &distinct(points, closed, how.tolerance);
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

/// Fits few cubics to a spline and ends them exactly at `end`. A run of the spline that one cubic does
/// not stand for is halved; one that is no longer than a cubic of the spline stands for itself, so that
/// this always ends.
fn append(out: &mut Vec<Segment>, spline: &BezPath, how: &Fit, end: Point) {
    let cubics: Vec<CubicBez> = spline.segments().map(|s| s.to_cubic()).collect();
    let source = SimplifyBezPath::new(spline.iter());
    let run = Run { source: &source, cubics: &cubics };
    let mut fitted: Vec<CubicBez> = Vec::new();
    let mut left = vec![0.0..cubics.len() as f64];
    while let Some(range) = left.pop() {
        match run.fitted(&range, how) {
            Some(one) => fitted.push(one),
            None if range.end - range.start <= 1.0 => fitted.extend(run.within(&range)),
            None => {
                let middle = 0.5 * (range.start + range.end);
                left.extend([middle..range.end, range.start..middle]);
            }
        }
    }
    let point = |p: kurbo::Point| [p.x, p.y];
    let last = fitted.len().saturating_sub(1);
    out.extend(fitted.iter().enumerate().map(|(i, c)| {
        Segment::Cubic(point(c.p1), point(c.p2), if i == last { end } else { point(c.p3) })
    }));
    if fitted.is_empty() {
        out.push(Segment::Line(end));
    }
}

/// A spline as its cubics and as what `kurbo` fits to. Places on it are counted in cubics.
struct Run<'a> {
    source: &'a SimplifyBezPath,
    cubics: &'a [CubicBez],
}

impl Run<'_> {
    /// One cubic near a part of the spline.
    fn fitted(&self, part: &Range<f64>, how: &Fit) -> Option<CubicBez> {
        let n = self.cubics.len() as f64;
        let range = part.start / n..part.end / n;
        if n < 1.0 {
            return None;
        }
        // Where it turns sharply, `kurbo` searches by arc length, which may not end.
        let cubic = match self.bends_softly(&range) {
            true => kurbo::fit_to_cubic(self.source, range, how.tolerance)?.0,
            false => least_squares(self.source, range, how.tolerance)?,
        };
        let whole = part.start.floor() as usize..part.end.ceil() as usize;
        stays(cubic, &self.cubics[whole], how).then_some(cubic)
    }

    /// The spline's own cubics in a part of it.
    fn within(&self, part: &Range<f64>) -> impl Iterator<Item = CubicBez> + use<'_> {
        let Range { start, end } = *part;
        (start.floor() as usize..end.ceil() as usize).map(move |i| {
            let at = |t: f64| (t - i as f64).clamp(0.0, 1.0);
            self.cubics[i].subsegment(at(start)..at(end))
        })
    }

    /// Whether tangents hardly turn from sample to sample, at the places at which `kurbo` looks.
    fn bends_softly(&self, range: &Range<f64>) -> bool {
        let step = (range.end - range.start) * (1.0 / 21.0);
        let tangent =
            |i: u32| self.source.sample_pt_tangent(range.start + f64::from(i) * step, 1.0).tangent;
        let tangents: Vec<kurbo::Vec2> = (0..22).map(tangent).collect();
        tangents.windows(2).all(|w| w[1].cross(w[0]).abs() <= 0.2 * w[1].dot(w[0]))
    }
}

/// The cubic with the ends of a part of a curve, and its tangents there, that is nearest to places on it
/// at shares of its length, moved to where the cubic is nearest to them (Schneider 1990).
fn least_squares(source: &SimplifyBezPath, range: Range<f64>, tolerance: f64) -> Option<CubicBez> {
    const PLACES: usize = 40;
    const ROUNDS: usize = 20;
    let place = |i: usize| {
        let t = range.start + (range.end - range.start) * i as f64 / PLACES as f64;
        source.sample_pt_tangent(t, if i == PLACES { -1.0 } else { 1.0 })
    };
    let places: Vec<kurbo::Point> = (0..=PLACES).map(|i| place(i).p).collect();
    let unit = |v: kurbo::Vec2| Some(v / v.hypot()).filter(|v| v.is_finite());
    let (out, back) = (unit(place(0).tangent)?, unit(-place(PLACES).tangent)?);
    let mut length = 0.0;
    let mut shares = vec![0.0];
    for w in places.windows(2) {
        length += (w[1] - w[0]).hypot();
        shares.push(length);
    }
    shares.iter_mut().for_each(|s| *s /= length);
    let (start, end) = (places[0], places[PLACES]);
    for _ in 0..ROUNDS {
        let [p, q] = handles(&places, &shares, [out, back])?;
        if !(p > 0.0 && q > 0.0 && p.max(q) < length) {
            return None;
        }
        let cubic = CubicBez::new(start, start + p * out, end + q * back, end);
        for (share, place) in shares.iter_mut().zip(&places) {
            *share = nearer(cubic, *place, *share);
        }
        let off = shares.iter().zip(&places).map(|(t, p)| (cubic.eval(*t) - *p).hypot());
        if off.fold(0.0, f64::max) <= tolerance {
            return Some(cubic);
        }
    }
    None
}

/// The lengths of both handles for which the cubic is nearest to places at shares of it.
fn handles(
    places: &[kurbo::Point],
    shares: &[f64],
    [out, back]: [kurbo::Vec2; 2],
) -> Option<[f64; 2]> {
    let (start, end) = (places[0].to_vec2(), places[places.len() - 1].to_vec2());
    let (mut a, mut b, mut c, mut x, mut y) = (0.0, 0.0, 0.0, 0.0, 0.0);
    for (&t, place) in shares.iter().zip(places) {
        let s = 1.0 - t;
        let (first, second) = (3.0 * s * s * t, 3.0 * s * t * t);
        let (p, q) = (first * out, second * back);
        let rest = place.to_vec2() - (s * s * s + first) * start - (t * t * t + second) * end;
        (a, b, c) = (a + p.dot(p), b + p.dot(q), c + q.dot(q));
        (x, y) = (x + p.dot(rest), y + q.dot(rest));
    }
    let scale = a * c - b * b;
    let found = [(x * c - y * b) / scale, (a * y - b * x) / scale];
    found.iter().all(|f| f.is_finite()).then_some(found)
}

/// The share of a cubic nearest to a place, from one near it by a step of Newton's.
fn nearer(cubic: CubicBez, place: kurbo::Point, share: f64) -> f64 {
    let (off, first) = (cubic.eval(share) - place, cubic.deriv().eval(share).to_vec2());
    let second = cubic.deriv().deriv().eval(share).to_vec2();
    let step = off.dot(first) / (first.dot(first) + off.dot(second));
    if step.is_finite() { (share - step).clamp(0.0, 1.0) } else { share }
}

/// Whether a cubic stays near those that it stands for. Only one with long handles is looked at: another
/// cannot leave its ends by much.
fn stays(c: CubicBez, run: &[CubicBez], how: &Fit) -> bool {
    let chord = (c.p3 - c.p0).hypot();
    let handle = (c.p1 - c.p0).hypot().max((c.p3 - c.p2).hypot());
    if handle <= chord || !handle.is_finite() {
        return handle.is_finite();
    }
    let steps = |s: &CubicBez| [0.0, 0.25, 0.5, 0.75, 1.0].map(|t| s.eval(t));
    let way: Vec<kurbo::Point> = run.iter().flat_map(steps).collect();
    let limit = 4.0 * how.tolerance + 0.25 * how.blur;
    (1..16).map(|i| c.eval(f64::from(i) / 16.0)).all(|p| {
        let near = |w: &[kurbo::Point]| {
            distance_to_segment([p.x, p.y], [w[0].x, w[0].y], [w[1].x, w[1].y]) <= limit
        };
        way.windows(2).any(near)
    })
}

/// Points that are apart, by a hundredth of the tolerance at least.
fn distinct(points: &[Point], closed: bool, tolerance: f64) -> Vec<Point> {
    let near = |a: Point, b: Point| {
        let apart = distance(a, b) > 0.01 * tolerance;
        !apart
    };
    let mut kept = points.to_vec();
    kept.dedup_by(|b, a| near(*a, *b));
    while closed && kept.len() > 1 && near(kept[0], kept[kept.len() - 1]) {
        kept.pop();
    }
    if let (false, true, Some(end)) = (closed, kept.len() > 1, points.last()) {
        let last = kept.len() - 1;
        kept[last] = *end;
    }
    kept
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

    #[test]
    fn it_ends_whatever_the_points() {
        // Repeated, doubled back, all in one place, nearly so, far apart, not numbers at all.
        let places = [0.0, 1e-13, 1e-4, 0.02, 0.5, 3.0, 1e9, f64::NAN];
        let mut state = 9u64;
        let mut random = move |n: usize| {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (state >> 33) as usize % n
        };
        for walk in 0..4000 {
            let (n, few) = (random(40), 1 + random(places.len() - usize::from(walk % 8 != 0)));
            let mut points: Vec<Point> =
                (0..n).map(|_| [places[random(few)], places[random(few)]]).collect();
            for i in 1..n {
                match random(4) {
                    0 => points[i] = points[i - 1],
                    1 => points[i] = points[i.saturating_sub(2)],
                    _ => {}
                }
            }
            let how = Fit { tolerance: 0.02, corner: 0.7, blur: 0.15, rounds: 0 };
            let path = fit(&points, walk % 2 == 0, &how);
            assert_eq!(path.is_none(), n == 0);
            // No more pieces than steps, corners counted twice.
            assert!(path.is_none_or(|p| p.segments.len() <= 2 * n + 3));
        }
    }
}
