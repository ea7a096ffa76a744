//! Polygons to triangles: ears are cut in the polygon's own plane.
//!
//! Guaranteed: n - 2 triangles for n corners, whatever their places; for simple polygons, concave
//! ones included, none overlap. Not guaranteed: anything sensible for polygons that cross
//! themselves.

use chiaro_basis::math::{Vec2, Vec3};

/// Corner numbers of the triangles of a polygon with at least three corners.
pub(super) fn triangulate(points: &[Vec3]) -> Vec<[usize; 3]> {
    match points.len() {
        3 => vec![[0, 1, 2]],
        4 => quad(points),
        // Cutting ears is quadratic; what has this many corners is no drawing of a face.
        n if n > 4096 => (1..n - 1).map(|i| [0, i, i + 1]).collect(),
        _ => cut_ears(&flat(points)),
    }
}

/// The two halves of a quad: across the corner that is not convex, or the shorter diagonal.
fn quad(p: &[Vec3]) -> Vec<[usize; 3]> {
    let normal = |i: usize, j: usize, k: usize| (p[j] - p[i]).cross(p[k] - p[i]);
    let first = normal(0, 1, 2).dot(normal(0, 2, 3));
    let second = normal(0, 1, 3).dot(normal(1, 2, 3));
    let across_02 = match (first > 0.0, second > 0.0) {
        (true, false) => true,
        (false, true) => false,
        // A tie goes to the fan, as most programs have it.
        _ => p[0].distance_squared(p[2]) <= p[1].distance_squared(p[3]) * 1.0001,
    };
    if across_02 { vec![[0, 1, 2], [0, 2, 3]] } else { vec![[0, 1, 3], [1, 2, 3]] }
}

/// The points in the plane of Newell's normal, counter-clockwise.
fn flat(points: &[Vec3]) -> Vec<Vec2> {
    let mut normal = Vec3::ZERO;
    for (i, a) in points.iter().enumerate() {
        let b = points[(i + 1) % points.len()];
        normal += (*a - points[0]).cross(b - points[0]);
    }
    let (x, y) = normal.normalize_or(Vec3::Z).any_orthonormal_pair();
    points.iter().map(|p| Vec2::new(p.dot(x), p.dot(y))).collect()
}

fn turn(a: Vec2, b: Vec2, c: Vec2) -> f32 {
    (b - a).perp_dot(c - a)
}

fn cut_ears(p: &[Vec2]) -> Vec<[usize; 3]> {
    let mut left: Vec<usize> = (0..p.len()).collect();
    let mut triangles = Vec::with_capacity(p.len() - 2);
    while left.len() > 3 {
        let n = left.len();
        let corner = |i: usize| [left[(i + n - 1) % n], left[i], left[(i + 1) % n]];
        // Without an ear, as where corners coincide, any corner will do.
        let ear = (0..n).find(|&i| is_ear(p, &left, corner(i))).unwrap_or(0);
        triangles.push(corner(ear));
        left.remove(ear);
    }
    triangles.push([left[0], left[1], left[2]]);
    triangles
}

fn is_ear(p: &[Vec2], left: &[usize], [a, b, c]: [usize; 3]) -> bool {
    let (pa, pb, pc) = (p[a], p[b], p[c]);
    if turn(pa, pb, pc) <= 0.0 {
        return false;
    }
    let inside =
        |q: Vec2| turn(pa, pb, q) >= 0.0 && turn(pb, pc, q) >= 0.0 && turn(pc, pa, q) >= 0.0;
    !left.iter().any(|&i| {
        i != a && i != b && i != c && p[i] != pa && p[i] != pb && p[i] != pc && inside(p[i])
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn area(points: &[Vec3], triangles: &[[usize; 3]]) -> f32 {
        let one = |t: &[usize; 3]| {
            let [a, b, c] = t.map(|i| points[i]);
            0.5 * (b - a).cross(c - a).z
        };
        assert!(triangles.iter().all(|t| one(t) >= 0.0), "no triangle is turned over");
        triangles.iter().map(one).sum()
    }

    #[test]
    fn concave_polygons_are_covered_once() {
        let l = [(0.0, 0.0), (3.0, 0.0), (3.0, 1.0), (1.0, 1.0), (1.0, 3.0), (0.0, 3.0)];
        let points = l.map(|(x, y)| Vec3::new(x, y, 0.0));
        let triangles = triangulate(&points);
        assert_eq!(triangles.len(), 4);
        assert!((area(&points, &triangles) - 5.0).abs() < 1e-5);
    }

    #[test]
    fn a_dart_is_cut_at_its_hollow_corner() {
        let dart = [(0.0, 0.0), (2.0, 1.0), (0.0, 2.0), (0.5, 1.0)];
        for shift in 0..4 {
            let points: Vec<Vec3> =
                (0..4).map(|i| dart[(i + shift) % 4]).map(|(x, y)| Vec3::new(x, y, 0.0)).collect();
            assert!((area(&points, &triangulate(&points)) - 1.5).abs() < 1e-5);
        }
    }

    #[test]
    fn coinciding_corners_still_give_triangles() {
        assert_eq!(triangulate(&[Vec3::ONE; 7]).len(), 5);
    }
}
