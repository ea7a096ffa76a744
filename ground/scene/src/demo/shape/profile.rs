//! [`Profile`]: the outline of a turned or drawn-out thing, corners rounded, with exact normals.

use chiaro_basis::math::{Vec2, vec2};
use std::f32::consts::PI;

/// Points along an outline with the unit normal to the right of its direction.
#[derive(Clone, Debug)]
pub(crate) struct Profile {
    /// Points in order, each with its normal.
    pub(crate) points: Vec<(Vec2, Vec2)>,
    /// Whether the last point joins the first.
    pub(crate) closed: bool,
}

/// Segments of a quarter turn of a rounded corner.
const CORNER: f32 = 4.0;

impl Profile {
    /// An open outline through corners (x, y, radius of the rounding).
    pub(crate) fn open(corners: &[(f32, f32, f32)]) -> Self {
        let n = corners.len();
        let at = |i: usize| vec2(corners[i].0, corners[i].1);
        let mut points = vec![(at(0), right(at(1) - at(0)))];
        let inner = |i: usize| rounded(at(i - 1), at(i), at(i + 1), corners[i].2);
        points.extend((1..n - 1).flat_map(inner));
        points.push((at(n - 1), right(at(n - 1) - at(n - 2))));
        Self { points, closed: false }
    }

    /// A closed outline through corners (x, y, radius of the rounding).
    pub(crate) fn closed(corners: &[(f32, f32, f32)]) -> Self {
        let n = corners.len();
        let at = |i: usize| vec2(corners[i % n].0, corners[i % n].1);
        let corner = |i: usize| rounded(at(i + n - 1), at(i), at(i + 1), corners[i].2);
        Self { points: (0..n).flat_map(corner).collect(), closed: true }
    }

    /// A rectangle about the origin with rounded corners, counter-clockwise.
    pub(crate) fn rectangle(width: f32, height: f32, radius: f32) -> Self {
        let (x, y) = (0.5 * width, 0.5 * height);
        Self::closed(&[(x, -y, radius), (x, y, radius), (-x, y, radius), (-x, -y, radius)])
    }

    /// A circle about the origin, counter-clockwise.
    pub(crate) fn circle(radius: f32, segments: usize) -> Self {
        let turn = |i| Vec2::from_angle(2.0 * PI * i as f32 / segments as f32);
        Self { points: (0..segments).map(|i| (radius * turn(i), turn(i))).collect(), closed: true }
    }

    /// A smooth open curve through points (Catmull and Rom 1974), `steps` to a span.
    pub(crate) fn curve(through: &[(f32, f32)], steps: usize) -> Self {
        let last = through.len() - 1;
        let at = |i: isize| {
            let (x, y) = through[i.clamp(0, last as isize) as usize];
            vec2(x, y)
        };
        let mut points = Vec::new();
        for i in 0..=last * steps {
            let (span, t) = ((i / steps).min(last - 1), i as f32 / steps as f32);
            let t = t - span as f32;
            let s = span as isize;
            let [a, b, c, d] = [at(s - 1), at(s), at(s + 1), at(s + 2)];
            points.push((cubic([a, b, c, d], t), right(cubic_slope([a, b, c, d], t))));
        }
        Self { points, closed: false }
    }

    /// With further points on straights longer than `step`.
    pub(crate) fn refined(self, step: f32) -> Self {
        let n = self.points.len();
        let mut points = Vec::new();
        for i in 0..n {
            let (p, np) = self.points[i];
            points.push((p, np));
            if i + 1 == n && !self.closed {
                break;
            }
            let (q, nq) = self.points[(i + 1) % n];
            let pieces = (p.distance(q) / step).ceil().max(1.0) as usize;
            for k in 1..pieces {
                let t = k as f32 / pieces as f32;
                points.push((p.lerp(q, t), np.lerp(nq, t).normalize_or(np)));
            }
        }
        Self { points, closed: self.closed }
    }
}

fn right(v: Vec2) -> Vec2 {
    vec2(v.y, -v.x).normalize_or(Vec2::X)
}

/// The arc that rounds corner `b` between its neighbours, or the corner itself, once with each
/// side's normal, when the radius is 0.
fn rounded(a: Vec2, b: Vec2, c: Vec2, radius: f32) -> Vec<(Vec2, Vec2)> {
    let (from, to) = ((b - a).normalize_or_zero(), (c - b).normalize_or_zero());
    let turn = from.perp_dot(to).atan2(from.dot(to));
    if radius <= 0.0 || turn.abs() < 1e-3 {
        return vec![(b, (right(from) + right(to)).normalize_or(right(from)))];
    }
    let tangent = radius * (0.5 * turn.abs()).tan();
    let tangent = tangent.min(0.499 * a.distance(b)).min(0.499 * b.distance(c));
    let radius = tangent / (0.5 * turn.abs()).tan();
    let side = turn.signum();
    let centre = b - from * tangent - right(from) * (radius * side);
    let steps = (turn.abs() / (0.5 * PI) * CORNER).ceil().max(1.0) as usize;
    let arc = |k: usize| {
        let n = Vec2::from_angle(turn * k as f32 / steps as f32).rotate(right(from));
        (centre + n * (radius * side), n)
    };
    (0..=steps).map(arc).collect()
}

fn cubic([a, b, c, d]: [Vec2; 4], t: f32) -> Vec2 {
    let (p, q) = (2.0 * a - 5.0 * b + 4.0 * c - d, 3.0 * b - a - 3.0 * c + d);
    0.5 * (2.0 * b + t * ((c - a) + t * (p + t * q)))
}

fn cubic_slope([a, b, c, d]: [Vec2; 4], t: f32) -> Vec2 {
    let (p, q) = (2.0 * a - 5.0 * b + 4.0 * c - d, 3.0 * b - a - 3.0 * c + d);
    0.5 * ((c - a) + t * (2.0 * p + 3.0 * t * q))
}
