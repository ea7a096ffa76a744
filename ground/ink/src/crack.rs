//! Cracks: edges between neighbouring pixels, chained to polylines.
//!
//! 1. A crack is the unit segment between two pixels; its ends are pixel corners.
//! 2. Connected cracks shorter in all than a limit are dropped.
//! 3. Walks between corners where not just two cracks meet, then around what is left, make chains.
//! 4. A chain becomes the polyline of its cracks' middles, smoothed by binomial weights, and then the
//!    few curves that stay within half a pixel of it: a line is known no better than that, and the
//!    stairs of slanted ones are gone. Ends, junctions and corners stay.

use crate::fit::{Fit, fit};
use crate::join::{Piece, joined};
use crate::path::Point;
use chiaro_basis::Sets;
use chiaro_image::Plane;

/// How lines are fitted, in pixels.
const LINES: Fit =
    Fit { tolerance: 0.45, corner: std::f64::consts::FRAC_PI_4, blur: 1.5, rounds: 0 };

/// Marked cracks of a picture.
#[derive(Clone, Debug)]
pub struct Cracks {
    /// Per pixel: whether the crack to its right neighbour, and the one to its lower neighbour,
    /// are marked.
    marks: Plane<[bool; 2]>,
}

/// A line in pixel coordinates.
#[derive(Clone, Debug, PartialEq)]
pub struct Polyline {
    /// Its points; the first is not repeated at the end of a closed line.
    pub points: Vec<[f32; 2]>,
    /// Whether it closes.
    pub closed: bool,
}

/// A pixel corner, x in 0..=width, y in 0..=height.
type Corner = (usize, usize);

impl Cracks {
    /// Marks cracks of a `width` x `height` picture: `marked(x, y, 0)` is asked of the crack between
    /// (x, y) and (x + 1, y), `marked(x, y, 1)` of the one between (x, y) and (x, y + 1).
    pub fn mark(
        width: usize,
        height: usize,
        marked: impl Fn(usize, usize, usize) -> bool + Sync,
    ) -> Self {
        let marks = Plane::from_fn(width, height, |x, y| {
            [x + 1 < width && marked(x, y, 0), y + 1 < height && marked(x, y, 1)]
        });
        Self { marks }
    }

    /// The lines that the cracks make, those of connected cracks under `shortest` pixels left out,
    /// smoothed `rounds` times.
    pub fn polylines(&self, shortest: f32, rounds: usize) -> Vec<Polyline> {
        self.pieces(shortest, rounds).into_iter().map(|p| p.line).collect()
    }

    /// The same, after lines that go on past a gap of at most `gap` pixels were joined: then their
    /// lengths count together. Cracks connected over fewer than `least` pixels take no part.
    pub fn joined(&self, least: f32, gap: f32, shortest: f32, rounds: usize) -> Vec<Polyline> {
        let lines = joined(self.pieces(least, rounds), gap).into_iter();
        lines.filter(|p| p.length >= shortest).map(|p| p.line).collect()
    }

    fn pieces(&self, shortest: f32, rounds: usize) -> Vec<Piece> {
        let mut walk = Walk::new(&self.marks);
        let chains = walk.chains();
        let lengths = component_lengths(&chains, walk.corners_wide());
        let long = chains.into_iter().zip(lengths).filter(|(_, length)| *length >= shortest);
        long.map(|(chain, length)| Piece { line: smoothed(&chain, rounds), length }).collect()
    }
}

/// Corners in order; closed when first and last agree.
type Chain = Vec<Corner>;

struct Walk<'a> {
    marks: &'a Plane<[bool; 2]>,
    /// Cracks already walked, indexed like `marks`.
    done: Plane<[bool; 2]>,
}

/// A crack as (x, y, axis), indexed like the marks.
type Crack = (usize, usize, usize);

impl<'a> Walk<'a> {
    fn new(marks: &'a Plane<[bool; 2]>) -> Self {
        let (w, h) = marks.size();
        Self { marks, done: Plane::filled(w, h, [false; 2]) }
    }

    fn corners_wide(&self) -> usize {
        self.marks.width() + 1
    }

    /// The marked cracks at a corner with their other ends: up, left, down, right.
    fn around(&self, (x, y): Corner) -> impl Iterator<Item = (Crack, Corner)> + '_ {
        let (w, h) = self.marks.size();
        let up = (x >= 1 && y >= 1).then(|| ((x - 1, y - 1, 0), (x, y - 1)));
        let left = (x >= 1 && y >= 1).then(|| ((x - 1, y - 1, 1), (x - 1, y)));
        let down = (x >= 1 && y < h).then(|| ((x - 1, y, 0), (x, y + 1)));
        let right = (y >= 1 && x < w).then(|| ((x, y - 1, 1), (x + 1, y)));
        [up, left, down, right]
            .into_iter()
            .flatten()
            .filter(|&((u, v, axis), _)| self.marks[(u, v)][axis])
    }

    fn chains(&mut self) -> Vec<Chain> {
        let corners = self.corners();
        let mut chains = Vec::new();
        for corner in &corners {
            if self.around(*corner).count() != 2 {
                self.leave(*corner, &mut chains);
            }
        }
        for corner in corners {
            self.leave(corner, &mut chains);
        }
        chains
    }

    /// The ends of all marked cracks, in reading order.
    fn corners(&self) -> Vec<Corner> {
        let mut ends: Vec<(usize, usize)> = Vec::new();
        for y in 0..self.marks.height() {
            for (x, [right, below]) in self.marks.row(y).iter().enumerate() {
                if *right {
                    ends.extend([(y, x + 1), (y + 1, x + 1)]);
                }
                if *below {
                    ends.extend([(y + 1, x), (y + 1, x + 1)]);
                }
            }
        }
        ends.sort_unstable();
        ends.dedup();
        ends.into_iter().map(|(y, x)| (x, y)).collect()
    }

    /// Walks along every crack at a corner that was not walked yet.
    fn leave(&mut self, corner: Corner, chains: &mut Vec<Chain>) {
        let starts: Vec<_> = self.around(corner).collect();
        for (crack, next) in starts {
            if !self.is_done(crack) {
                chains.push(self.follow(corner, crack, next));
            }
        }
    }

    fn is_done(&self, (x, y, axis): Crack) -> bool {
        self.done[(x, y)][axis]
    }

    /// From a corner along a crack to the next end or junction, or once round.
    fn follow(&mut self, from: Corner, crack: Crack, next: Corner) -> Chain {
        let (mut crack, mut at) = (crack, next);
        let mut chain = vec![from];
        loop {
            self.done[(crack.0, crack.1)][crack.2] = true;
            chain.push(at);
            if at == from || self.around(at).count() != 2 {
                return chain;
            }
            let Some((c, n)) = self.around(at).find(|&(c, _)| !self.is_done(c)) else {
                return chain;
            };
            (crack, at) = (c, n);
        }
    }
}

/// For each chain, the cracks in all chains that it is connected with.
fn component_lengths(chains: &[Chain], wide: usize) -> Vec<f32> {
    let ends: Vec<[usize; 2]> =
        chains.iter().map(|c| [c[0], c[c.len() - 1]].map(|(x, y)| y * wide + x)).collect();
    let mut corners: Vec<usize> = ends.iter().flatten().copied().collect();
    corners.sort_unstable();
    corners.dedup();
    let index = |corner: usize| corners.binary_search(&corner).expect("every end is listed");
    let mut sets = Sets::new(corners.len());
    for [a, b] in &ends {
        sets.join(index(*a), index(*b));
    }
    let mut totals = vec![0.0f32; corners.len()];
    for (chain, [a, _]) in chains.iter().zip(&ends) {
        totals[sets.root(index(*a))] += (chain.len() - 1) as f32;
    }
    ends.iter().map(|[a, _]| totals[sets.root(index(*a))]).collect()
}

fn smoothed(chain: &Chain, rounds: usize) -> Polyline {
    let closed = chain.len() > 3 && chain[0] == chain[chain.len() - 1];
    let corner = |c: Corner| [c.0 as f32, c.1 as f32];
    let mut points: Vec<[f32; 2]> =
        chain.windows(2).map(|s| middle(corner(s[0]), corner(s[1]))).collect();
    if !closed {
        points.insert(0, corner(chain[0]));
        points.push(corner(chain[chain.len() - 1]));
    }
    for _ in 0..rounds {
        points = binomial(&points, closed);
    }
    if rounds > 0 { fitted(&points, closed) } else { Polyline { points, closed } }
}

/// Curves within half a pixel, as points again.
fn fitted(points: &[[f32; 2]], closed: bool) -> Polyline {
    let fine: Vec<Point> = points.iter().map(|p| p.map(f64::from)).collect();
    let Some(path) = fit(&fine, closed, &LINES) else { return Polyline { points: vec![], closed } };
    let mut points: Vec<[f32; 2]> = path.points(0.02).iter().map(|p| p.map(|x| x as f32)).collect();
    if closed && points.len() > 1 {
        points.pop();
    }
    let source: Vec<[f32; 2]> = fine.iter().map(|p| p.map(|x| x as f32)).collect();
    if strays(&points, &source) {
        Polyline { points: source, closed }
    } else {
        Polyline { points, closed }
    }
}

/// Whether a fitted line leaves the points that it was fitted to by more than two pixels: a fit
/// that ran away.
fn strays(line: &[[f32; 2]], source: &[[f32; 2]]) -> bool {
    let n = source.len();
    let apart = |p: &[f32; 2], i: usize| {
        let q = source[i % n];
        (p[0] - q[0]).hypot(p[1] - q[1])
    };
    let nearest = |p: &[f32; 2], mut among: std::ops::Range<usize>| {
        let first = among.next().unwrap_or(0);
        among.fold(first, |best, i| if apart(p, i) < apart(p, best) { i } else { best })
    };
    let Some(first) = line.first() else { return false };
    let mut at = nearest(first, 0..n);
    line.windows(2).any(|pair| {
        // Curves are drawn by few points: look as far ahead as the step is long.
        let step = (pair[1][0] - pair[0][0]).hypot(pair[1][1] - pair[0][1]);
        at = nearest(&pair[1], at..at + 4 + 3 * step as usize);
        apart(&pair[1], at) > 2.0
    })
}

fn middle(a: [f32; 2], b: [f32; 2]) -> [f32; 2] {
    [0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1])]
}

/// One round of (1, 2, 1) / 4.
fn binomial(points: &[[f32; 2]], closed: bool) -> Vec<[f32; 2]> {
    let n = points.len();
    (0..n)
        .map(|i| {
            if !closed && (i == 0 || i == n - 1) {
                return points[i];
            }
            let (a, b, c) = (points[(i + n - 1) % n], points[i], points[(i + 1) % n]);
            middle(middle(a, b), middle(b, c))
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn outline(
        width: usize,
        height: usize,
        inside: impl Fn(usize, usize) -> bool + Sync,
    ) -> Cracks {
        Cracks::mark(width, height, |x, y, axis| {
            let (u, v) = if axis == 0 { (x + 1, y) } else { (x, y + 1) };
            inside(x, y) != inside(u, v)
        })
    }

    #[test]
    fn the_outline_of_a_square_is_one_closed_line() {
        let lines =
            outline(8, 8, |x, y| (2..5).contains(&x) && (2..6).contains(&y)).polylines(0.0, 0);
        assert_eq!(lines.len(), 1);
        assert!(lines[0].closed);
        assert_eq!(lines[0].points.len(), 14);
    }

    #[test]
    fn crossing_lines_are_cut_where_they_meet() {
        let lines = outline(9, 9, |x, y| (x < 4) != (y < 4)).polylines(0.0, 2);
        assert!(lines.iter().all(|l| l.points.len() == 2));
        assert_eq!(lines.len(), 4);
        assert!(lines.iter().all(|l| !l.closed));
    }

    #[test]
    fn slanted_lines_have_no_stairs() {
        for slope in [0.1f32, 0.3, 0.5, 0.77] {
            let line = |x: usize| 20.0 + slope * (x as f32 - 40.0);
            let lines = outline(80, 60, |x, y| (y as f32 + 0.5) < line(x)).polylines(8.0, 4);
            assert_eq!(lines.len(), 1);
            let turns = lines[0].points.windows(3).map(|w| {
                let (a, b) = (
                    [w[1][0] - w[0][0], w[1][1] - w[0][1]],
                    [w[2][0] - w[1][0], w[2][1] - w[1][1]],
                );
                (a[0] * b[1] - a[1] * b[0]).atan2(a[0] * b[0] + a[1] * b[1]).abs()
            });
            assert!(turns.sum::<f32>() < 0.6, "slope {slope}: {:?}", lines[0].points);
        }
    }

    #[test]
    fn a_line_that_leaves_its_points_is_found_out() {
        let source: Vec<[f32; 2]> = (0..60).map(|i| [i as f32, 0.2 * (i % 2) as f32]).collect();
        assert!(!strays(&[[0.0, 0.0], [30.0, 0.5], [59.0, 0.0]], &source));
        assert!(strays(&[[0.0, 0.0], [30.0, 9.0], [59.0, 0.0]], &source));
        assert!(strays(&[[0.0, 0.0], [-20.0, -20.0]], &source));
    }

    #[test]
    fn short_lines_are_dropped_by_their_connected_length() {
        let cracks = outline(20, 20, |x, y| (x, y) == (3, 3) || (x > 9 && y > 9));
        assert_eq!(cracks.polylines(0.0, 0).len(), 2);
        assert_eq!(cracks.polylines(5.0, 0).len(), 1);
    }
}
