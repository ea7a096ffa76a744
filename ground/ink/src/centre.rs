//! Centre lines: strokes in pixels to the paths that a pen would follow.
//!
//! 1. Marks are thinned to a pixel's width (Zhang and Suen, "A fast parallel algorithm for thinning
//!    digital patterns", 1984): borders are peeled off in two directions in turn, ends and
//!    connections stay.
//! 2. Pixels with other than two neighbours are nodes; between nodes, and once round where there are
//!    none, pixels make polylines through their centres. A diagonal neighbour that a side neighbour
//!    of both stands beside does not count, so that corners of stairs are no nodes.
//!
//! Guaranteed: every piece of the marks has a line, if only a dot as a line of one point, left out
//! here. Not guaranteed: ends within half a stroke's width of where they were.

use crate::Polyline;
use chiaro_image::Plane;

/// The eight neighbours, clockwise from the north.
const RING: [(isize, isize); 8] =
    [(0, -1), (1, -1), (1, 0), (1, 1), (0, 1), (-1, 1), (-1, 0), (-1, -1)];

/// The centre lines of marks, in pixels, pixel centres at + 0.5.
pub fn centre_lines(marks: &Plane<bool>) -> Vec<Polyline> {
    Skeleton::of(thinned(marks)).lines()
}

fn ring(marks: &Plane<bool>, x: usize, y: usize) -> [bool; 8] {
    RING.map(|(dx, dy)| marks.at(x as isize + dx, y as isize + dy) == Some(&true))
}

/// Marks thinned to the width of a pixel.
fn thinned(marks: &Plane<bool>) -> Plane<bool> {
    let mut marks = marks.clone();
    let (w, h) = marks.size();
    let mut open: Vec<(usize, usize)> =
        (0..h).flat_map(|y| (0..w).map(move |x| (x, y))).filter(|p| marks[*p]).collect();
    loop {
        let before = open.len();
        for odd in [false, true] {
            let peeled = |p: &&(usize, usize)| is_peeled(ring(&marks, p.0, p.1), odd);
            let gone: Vec<(usize, usize)> = open.iter().filter(peeled).copied().collect();
            gone.into_iter().for_each(|p| marks[p] = false);
            open.retain(|p| marks[*p]);
        }
        if open.len() == before {
            return marks;
        }
    }
}

/// Whether a marked pixel with such neighbours is on the border that is peeled, and no end and no
/// connection.
fn is_peeled([n, ne, e, se, s, sw, w, nw]: [bool; 8], odd: bool) -> bool {
    let ring = [n, ne, e, se, s, sw, w, nw];
    let count = ring.iter().filter(|m| **m).count();
    let rises = (0..8).filter(|i| !ring[*i] && ring[(i + 1) % 8]).count();
    let inside = if odd { n && w && (e || s) } else { e && s && (n || w) };
    (2..=6).contains(&count) && rises == 1 && !inside
}

/// Thin marks as a graph of pixels.
struct Skeleton {
    marks: Plane<bool>,
    /// Pixels between nodes that are in a line already.
    used: Plane<bool>,
}

impl Skeleton {
    fn of(marks: Plane<bool>) -> Self {
        let used = marks.map(|_| false);
        Self { marks, used }
    }

    fn beside(&self, (x, y): (usize, usize)) -> Vec<(usize, usize)> {
        let ring = ring(&self.marks, x, y);
        let counts =
            |i: usize| ring[i] && (i.is_multiple_of(2) || !(ring[i - 1] || ring[(i + 1) % 8]));
        let place = |i: usize| (x.wrapping_add_signed(RING[i].0), y.wrapping_add_signed(RING[i].1));
        (0..8).filter(|i| counts(*i)).map(place).collect()
    }

    fn lines(mut self) -> Vec<Polyline> {
        let (w, h) = self.marks.size();
        let marked: Vec<(usize, usize)> =
            (0..h).flat_map(|y| (0..w).map(move |x| (x, y))).filter(|p| self.marks[*p]).collect();
        let is_node = |s: &Self, p: (usize, usize)| s.beside(p).len() != 2;
        let mut lines = Vec::new();
        for &start in &marked {
            if !is_node(&self, start) {
                continue;
            }
            for next in self.beside(start) {
                let first_of_pair = !is_node(&self, next) || next > start;
                if !self.used[next] && first_of_pair {
                    lines.push(self.walk(start, next));
                }
            }
        }
        for &start in &marked {
            if !self.used[start] && !is_node(&self, start) {
                let next = self.beside(start)[0];
                self.used[start] = true;
                lines.push(self.walk(start, next));
            }
        }
        lines
    }

    /// The line from a pixel over the next one to the next node, or back to where it began.
    fn walk(&mut self, start: (usize, usize), next: (usize, usize)) -> Polyline {
        let mut line = vec![start];
        let (mut before, mut at) = (start, next);
        let closed = loop {
            if at == start {
                break true;
            }
            line.push(at);
            let beside = self.beside(at);
            if beside.len() != 2 {
                break false;
            }
            self.used[at] = true;
            let onward = if beside[0] == before { beside[1] } else { beside[0] };
            (before, at) = (at, onward);
        };
        let points = line.into_iter().map(|(x, y)| [x as f32 + 0.5, y as f32 + 0.5]).collect();
        Polyline { points, closed }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lines(rows: &[&str]) -> Vec<Polyline> {
        let marks = Plane::from_fn(rows[0].len(), rows.len(), |x, y| rows[y].as_bytes()[x] == b'#');
        centre_lines(&marks)
    }

    #[test]
    fn a_thick_stroke_has_one_line_along_its_middle() {
        let found = lines(&["............", ".##########.", ".##########.", ".##########."]);
        assert_eq!(found.len(), 1);
        assert!(!found[0].closed);
        assert!(found[0].points.iter().all(|p| (p[1] - 2.5).abs() <= 1.0), "{found:?}");
        let span = found[0].points.iter().map(|p| p[0]);
        assert!(span.clone().fold(f32::MIN, f32::max) - span.fold(f32::MAX, f32::min) >= 6.0);
    }

    #[test]
    fn rings_close_and_crossings_part_lines() {
        let ring = lines(&["......", ".####.", ".#..#.", ".#..#.", ".####.", "......"]);
        assert_eq!((ring.len(), ring[0].closed), (1, true));
        assert!(ring[0].points.len() >= 8);
        let cross = lines(&["..#..", "..#..", "#####", "..#..", "..#.."]);
        assert_eq!(cross.len(), 4, "{cross:?}");
        assert!(lines(&["...", ".#.", "..."]).is_empty());
        assert!(lines(&["..."]).is_empty());
    }
}
