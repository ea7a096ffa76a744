//! Steps of pixels taken out of a run of points along their borders.
//!
//! Each round puts a point at the mean (1, 2, 1) / 4 of its neighbours and itself: n rounds are a
//! Gaussian of variance n / 2 along the run, in points. No point ends farther than 0.45 from where
//! it was, so that borders in cells of pixels stay in them, thin regions stay open, and the centres
//! of pixels stay on their side; where a run turns back, at the end of a region a pixel wide, none
//! farther than 0.1, so that thin regions keep their length. The ends of open runs stay.

use crate::Point;

/// How far a point may move, in pixels.
const FARTHEST: f64 = 0.45;
/// How far one at the end of a thin region may.
const FARTHEST_AT_TIPS: f64 = 0.1;

/// `points` after so many rounds.
pub(crate) fn relaxed(points: &[Point], closed: bool, rounds: u32) -> Vec<Point> {
    let n = points.len();
    let mut run = points.to_vec();
    if n < 3 {
        return run;
    }
    for _ in 0..rounds {
        let mean = |i: usize| {
            if !closed && (i == 0 || i + 1 == n) {
                return run[i];
            }
            let (a, b, c) = (run[(i + n - 1) % n], run[i], run[(i + 1) % n]);
            std::array::from_fn(|k| 0.25 * a[k] + 0.5 * b[k] + 0.25 * c[k])
        };
        run = (0..n).map(mean).collect();
    }
    let farthest =
        |i: usize| match (0..3).any(|k| is_tip(points, closed, (i + n + k).wrapping_sub(1))) {
            true => FARTHEST_AT_TIPS,
            false => FARTHEST,
        };
    (0..n).map(|i| near(points[i], run[i], farthest(i))).collect()
}

/// Whether a run turns back around a point, by more than a right angle within two points.
fn is_tip(points: &[Point], closed: bool, i: usize) -> bool {
    let n = points.len();
    let i = i % n;
    if n < 5 || !closed && (i < 2 || i + 2 >= n) {
        return false;
    }
    let (a, b, c) = (points[(i + n - 2) % n], points[i], points[(i + 2) % n]);
    (b[0] - a[0]) * (c[0] - b[0]) + (b[1] - a[1]) * (c[1] - b[1]) < -1e-9
}

/// The point on the way from one to the other that is not too far.
fn near(from: Point, to: Point, farthest: f64) -> Point {
    let way = [to[0] - from[0], to[1] - from[1]];
    let share = (farthest / way[0].hypot(way[1])).min(1.0);
    [from[0] + share * way[0], from[1] + share * way[1]]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The turns of a run, added up, in radians.
    fn turning(points: &[Point]) -> f64 {
        let turn = |w: &[Point]| {
            let (u, v) =
                ([w[1][0] - w[0][0], w[1][1] - w[0][1]], [w[2][0] - w[1][0], w[2][1] - w[1][1]]);
            (u[0] * v[1] - u[1] * v[0]).atan2(u[0] * v[0] + u[1] * v[1]).abs()
        };
        points.windows(3).map(turn).sum()
    }

    /// The middles of the sides of pixels along a slanted border.
    fn stairs(across: usize) -> Vec<Point> {
        let (mut points, mut y) = (Vec::new(), 0.0);
        for x in 0..60 {
            points.push([x as f64 + 0.5, y]);
            if x % across == across - 1 {
                points.push([x as f64 + 1.0, y + 0.5]);
                y += 1.0;
            }
        }
        points
    }

    #[test]
    fn stairs_become_slopes() {
        for across in [1, 2, 3] {
            let (before, after) = (stairs(across), relaxed(&stairs(across), false, 3));
            assert_eq!((before[0], before.last()), (after[0], after.last()));
            assert!(turning(&after) < 0.2 * turning(&before).max(5.0), "{across}");
        }
    }

    #[test]
    fn thin_regions_keep_their_length() {
        // A bar a pixel wide and six long, by the middles of the sides of its pixels.
        let sides = |y: f64| (0..6).map(move |x| [f64::from(x) + 0.5, y]);
        let mut points: Vec<Point> = sides(0.0).collect();
        points.push([6.0, 0.5]);
        points.extend(sides(1.0).collect::<Vec<_>>().into_iter().rev());
        points.push([0.0, 0.5]);
        let after = relaxed(&points, true, 3);
        let ends = after.iter().fold((9.0f64, 0.0f64), |(l, h), p| (l.min(p[0]), h.max(p[0])));
        assert!(ends.0 < 0.11 && ends.1 > 5.89, "{ends:?}");
    }

    #[test]
    fn nothing_moves_far() {
        let spike: [Point; 4] = [[0.0, 0.0], [9.0, 0.0], [0.0, 1.0], [9.0, 2.0]];
        for (from, to) in spike.iter().zip(relaxed(&spike, true, 20)) {
            assert!((from[0] - to[0]).hypot(from[1] - to[1]) < FARTHEST + 1e-9);
        }
        assert!(relaxed(&[], true, 3).is_empty());
    }
}
