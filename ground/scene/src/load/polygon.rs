//! Polygons to triangles: ears are cut in the polygon's own plane.
//!
//! 1. Quads are halved across the diagonal that both halves agree on, the shorter one if both do.
//! 2. Other polygons are laid flat along Newell's normal, the mean plane of what need not be plane.
//! 3. A corner is an ear when it is convex and its triangle holds no hollow corner (Meisters 1975);
//!    ears are cut in turn around the polygon, so that slivers are rare.
//!
//! Guaranteed: n - 2 triangles for n corners, whatever their places; for simple polygons, hollow
//! ones included, none overlap; time in proportion to the corners, but for [`PATIENCE`] once. Not
//! guaranteed: anything sensible for polygons that cross themselves.

use chiaro_basis::math::{DVec2, DVec3, Vec3};

/// Corner tests that all polygons of a file may take together beyond a few for each corner: some
/// seconds. Cutting ears is quadratic; what is left after that is fanned out.
const PATIENCE: u64 = 1 << 29;

/// Corner tests that each corner brings along.
const TESTS_PER_CORNER: u64 = 64;

/// Cuts the polygons of one file, in memory that is used again.
pub(super) struct Triangulator {
    patience: u64,
    flat: Vec<DVec2>,
    next: Vec<usize>,
    previous: Vec<usize>,
    hollow: Vec<usize>,
}

impl Default for Triangulator {
    fn default() -> Self {
        let (flat, next, previous, hollow) = Default::default();
        Self { patience: PATIENCE, flat, next, previous, hollow }
    }
}

impl Triangulator {
    /// Appends the corner numbers of the triangles of a polygon with at least three corners.
    pub(super) fn cut(&mut self, points: &[Vec3], triangles: &mut Vec<[usize; 3]>) {
        match points {
            [_, _, _] => triangles.push([0, 1, 2]),
            [a, b, c, d] => triangles.extend(quad([*a, *b, *c, *d])),
            _ => self.ears(points, triangles),
        }
    }

    fn ears(&mut self, points: &[Vec3], triangles: &mut Vec<[usize; 3]>) {
        let n = points.len();
        self.patience += TESTS_PER_CORNER * n as u64;
        flatten(points, &mut self.flat);
        self.next.clear();
        self.next.extend((1..n).chain([0]));
        self.previous.clear();
        self.previous.extend([n - 1].into_iter().chain(0..n - 1));
        self.hollow.clear();
        let mut hollow = std::mem::take(&mut self.hollow);
        hollow.extend((0..n).filter(|&i| self.turn(i) <= 0.0));
        self.hollow = hollow;
        let (mut corner, mut left, mut misses) = (0, n, 0);
        while left > 3 && self.patience > 0 {
            if self.is_ear(corner) || (misses >= left && self.is_flat_or_last(corner, misses, left))
            {
                triangles.push([self.previous[corner], corner, self.next[corner]]);
                self.drop(corner);
                (left, misses) = (left - 1, 0);
                // The corner after next has its turn: cutting side by side makes slivers.
                corner = self.next[self.next[corner]];
            } else {
                misses += 1;
                corner = self.next[corner];
            }
        }
        let first = corner;
        for _ in 2..left {
            corner = self.next[corner];
            triangles.push([first, corner, self.next[corner]]);
        }
    }

    /// Without an ear, as where sides cross or corners coincide, a corner without area goes first;
    /// after another round any corner will do.
    fn is_flat_or_last(&mut self, corner: usize, misses: usize, left: usize) -> bool {
        self.patience = self.patience.saturating_sub(1);
        misses >= 2 * left || self.turn(corner) == 0.0
    }

    fn drop(&mut self, corner: usize) {
        let (before, after) = (self.previous[corner], self.next[corner]);
        self.next[before] = after;
        self.previous[after] = before;
        let was_hollow = self.hollow.iter().position(|&i| i == corner);
        was_hollow.into_iter().for_each(|i| {
            self.hollow.swap_remove(i);
        });
        for neighbour in [before, after] {
            // Corners only ever become convex, but for rounding.
            if self.turn(neighbour) > 0.0 {
                self.hollow.retain(|&i| i != neighbour);
            }
        }
        self.patience = self.patience.saturating_sub(self.hollow.len() as u64);
    }

    /// Twice the area of the triangle at a corner, positive where it is convex.
    fn turn(&self, corner: usize) -> f64 {
        turn(self.flat[self.previous[corner]], self.flat[corner], self.flat[self.next[corner]])
    }

    fn is_ear(&mut self, corner: usize) -> bool {
        let ear = [self.previous[corner], corner, self.next[corner]];
        let [a, b, c] = ear.map(|i| self.flat[i]);
        self.patience = self.patience.saturating_sub(1);
        if turn(a, b, c) <= 0.0 || turn(a, b, c).is_nan() {
            return false;
        }
        let inside =
            |q: DVec2| turn(a, b, q) >= 0.0 && turn(b, c, q) >= 0.0 && turn(c, a, q) >= 0.0;
        self.patience = self.patience.saturating_sub(self.hollow.len() as u64);
        // Bridges to holes visit a place twice: corners at those of the ear are not inside it.
        !self.hollow.iter().any(|&i| {
            let q = self.flat[i];
            !ear.contains(&i) && q != a && q != b && q != c && inside(q)
        })
    }
}

/// The two halves of a quad.
fn quad(points: [Vec3; 4]) -> [[usize; 3]; 2] {
    let p = points.map(Vec3::as_dvec3);
    let normal = |i: usize, j: usize, k: usize| (p[j] - p[i]).cross(p[k] - p[i]);
    let first = normal(0, 1, 2).dot(normal(0, 2, 3)) > 0.0;
    let second = normal(0, 1, 3).dot(normal(1, 2, 3)) > 0.0;
    let is_fan = match (first, second) {
        (true, false) => true,
        (false, true) => false,
        // A tie goes to the fan, as most programs have it.
        _ => p[0].distance_squared(p[2]) <= p[1].distance_squared(p[3]) * 1.0001,
    };
    if is_fan { [[0, 1, 2], [0, 2, 3]] } else { [[0, 1, 3], [1, 2, 3]] }
}

/// The points in the plane of Newell's normal, counter-clockwise, the first at the origin.
fn flatten(points: &[Vec3], flat: &mut Vec<DVec2>) {
    let origin = points[0].as_dvec3();
    let from_origin = |p: &Vec3| p.as_dvec3() - origin;
    let sides = points.iter().zip(points.iter().cycle().skip(1));
    let normal: DVec3 = sides.map(|(a, b)| from_origin(a).cross(from_origin(b))).sum();
    let (x, y) = normal.normalize_or(DVec3::Z).any_orthonormal_pair();
    flat.clear();
    flat.extend(points.iter().map(from_origin).map(|p| DVec2::new(p.dot(x), p.dot(y))));
}

fn turn(a: DVec2, b: DVec2, c: DVec2) -> f64 {
    (b - a).perp_dot(c - a)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn triangulate(points: &[Vec3]) -> Vec<[usize; 3]> {
        let mut triangles = Vec::new();
        Triangulator::default().cut(points, &mut triangles);
        triangles
    }

    /// The area covered, each triangle being the right way round.
    fn area(points: &[Vec3], triangles: &[[usize; 3]]) -> f32 {
        let one = |t: &[usize; 3]| {
            let [a, b, c] = t.map(|i| points[i]);
            0.5 * (b - a).cross(c - a).z
        };
        assert!(triangles.iter().all(|t| one(t) >= -1e-6), "no triangle is turned over");
        triangles.iter().map(one).sum()
    }

    fn plane(points: &[(f32, f32)]) -> Vec<Vec3> {
        points.iter().map(|&(x, y)| Vec3::new(x, y, 0.0)).collect()
    }

    #[test]
    fn hollow_polygons_are_covered_once() {
        let l = plane(&[(0.0, 0.0), (3.0, 0.0), (3.0, 1.0), (1.0, 1.0), (1.0, 3.0), (0.0, 3.0)]);
        assert_eq!(triangulate(&l).len(), 4);
        assert!((area(&l, &triangulate(&l)) - 5.0).abs() < 1e-5);
        // A comb with ten teeth.
        let mut comb = vec![(0.0, 0.0), (20.0, 0.0)];
        for i in (0..10).rev() {
            let x = 2.0 * i as f32;
            comb.extend([(x + 2.0, 5.0), (x + 1.0, 5.0), (x + 1.0, 1.0), (x, 1.0)]);
        }
        let comb = plane(&comb);
        assert!((area(&comb, &triangulate(&comb)) - 60.0).abs() < 1e-4);
    }

    #[test]
    fn a_hole_on_a_bridge_stays_open() {
        let ring = plane(&[
            (0.0, 0.0),
            (4.0, 0.0),
            (4.0, 4.0),
            (0.0, 4.0),
            (0.0, 0.0),
            (1.0, 1.0),
            (1.0, 3.0),
            (3.0, 3.0),
            (3.0, 1.0),
            (1.0, 1.0),
        ]);
        assert!((area(&ring, &triangulate(&ring)) - 12.0).abs() < 1e-5);
    }

    #[test]
    fn a_dart_is_cut_at_its_hollow_corner() {
        let dart = [(0.0, 0.0), (2.0, 1.0), (0.0, 2.0), (0.5, 1.0)];
        for shift in 0..4 {
            let points = plane(&std::array::from_fn::<_, 4, _>(|i| dart[(i + shift) % 4]));
            assert!((area(&points, &triangulate(&points)) - 1.5).abs() < 1e-5);
        }
    }

    #[test]
    fn far_from_the_origin_nothing_is_lost() {
        let far = |p: &Vec3| *p + Vec3::new(8192.0, -4096.0, 2048.0);
        let l = plane(&[(0.0, 0.0), (3.0, 0.0), (3.0, 1.0), (1.0, 1.0), (1.0, 3.0), (0.0, 3.0)]);
        let moved: Vec<Vec3> = l.iter().map(far).collect();
        assert_eq!(triangulate(&moved), triangulate(&l));
    }

    #[test]
    fn whatever_the_corners_there_are_two_triangles_less() {
        for points in [vec![Vec3::ONE; 7], vec![Vec3::NAN; 9]] {
            assert_eq!(triangulate(&points).len(), points.len() - 2);
        }
        let star: Vec<Vec3> = (0..101)
            .map(|i| (i as f32 * 40.0 / 101.0 * std::f32::consts::TAU).sin_cos())
            .map(|(x, y)| Vec3::new(x, y, 0.0))
            .collect();
        assert_eq!(triangulate(&star).len(), 99);
    }

    #[test]
    fn patience_ends() {
        // Hollow on one side everywhere, so that few corners are ears and each test is long.
        let saw: Vec<Vec3> = (0..100_000)
            .map(|i| {
                let a = i as f32 * std::f32::consts::TAU / 100_000.0;
                Vec3::new(a.cos(), a.sin(), 0.0) * if i % 2 == 0 { 1.0 } else { 0.99 }
            })
            .collect();
        let mut triangles = Vec::new();
        let mut triangulator = Triangulator { patience: 1000, ..Triangulator::default() };
        triangulator.cut(&saw, &mut triangles);
        assert_eq!(triangles.len(), saw.len() - 2);
    }
}
