//! Areas for pens: parallel strokes and inset outlines that keep half a pen from every border.
//!
//! A hatch line is cut where it crosses the area's outline; of what lies inside, everything nearer
//! than half a pen to a border is taken away, which is where the line crosses a border's capsule.
//! What must stay free (lines left in the paper's colour) is taken away the same way. Exact for the
//! outlines flattened to a hundredth of a millimetre.

use crate::path::{distance, distance_to_segment};
use crate::{Path, Point};
use std::collections::HashMap;

/// How outlines are flattened, in millimetres.
const FLAT: f64 = 0.01;

/// Parallel strokes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hatch {
    /// Direction of the strokes, radians, counted from x towards y.
    pub angle: f64,
    /// From one stroke to the next, in millimetres.
    pub spacing: f64,
    /// Width of the pen, in millimetres.
    pub pen: f64,
}

/// An area to be filled, and what must stay free in it.
#[derive(Clone, Debug, Default)]
pub struct Area {
    borders: Vec<Edge>,
    /// The rings as points, the area on their right.
    rings: Vec<Vec<Point>>,
    free: Vec<Edge>,
}

/// A segment and how far the pen's middle must stay from it, beside half a pen.
#[derive(Clone, Copy, Debug)]
struct Edge {
    from: Point,
    to: Point,
    radius: f64,
}

impl Area {
    /// The area within closed paths, by the even-odd rule.
    pub fn new(outline: &[Path]) -> Self {
        let rings: Vec<Vec<Point>> = outline.iter().map(|path| path.points(FLAT)).collect();
        let borders = rings.iter().flat_map(|r| edges(r, 0.0)).collect();
        Self { borders, rings, free: Vec::new() }
    }

    /// Keeps lines of a width free.
    pub fn keep_free(&mut self, paths: &[Path], width: f64) {
        for path in paths {
            self.free.extend(edges(&path.points(FLAT), 0.5 * width));
        }
    }

    /// Strokes that fill it.
    pub fn hatched(&self, how: &Hatch) -> Vec<Path> {
        let (sin, cos) = how.angle.sin_cos();
        // Turned so that strokes run along x.
        let turn = |p: Point| [p[0] * cos + p[1] * sin, p[1] * cos - p[0] * sin];
        let back = |p: Point| [p[0] * cos - p[1] * sin, p[0] * sin + p[1] * cos];
        let turned = |e: &Edge| Edge { from: turn(e.from), to: turn(e.to), radius: e.radius };
        let borders: Vec<Edge> = self.borders.iter().map(turned).collect();
        let free: Vec<Edge> = self.free.iter().map(turned).collect();
        let mut lines: HashMap<i64, Line> = HashMap::new();
        for edge in &borders {
            for i in rows(edge, 0.0, how.spacing) {
                lines.entry(i).or_default().cross(edge, i as f64 * how.spacing);
            }
        }
        for edge in borders.iter().chain(&free) {
            let radius = edge.radius + 0.5 * how.pen;
            for i in rows(edge, radius, how.spacing) {
                // A row that no border crosses holds nothing of the area.
                if let Some(line) = lines.get_mut(&i) {
                    line.avoid(edge, radius, i as f64 * how.spacing);
                }
            }
        }
        let mut order: Vec<i64> = lines.keys().copied().collect();
        order.sort_unstable();
        let strokes = order.into_iter().flat_map(|i| {
            let y = i as f64 * how.spacing;
            lines[&i].strokes(0.25 * how.pen).into_iter().map(move |[a, b]| [[a, y], [b, y]])
        });
        strokes.filter_map(|s| Path::through(&s.map(back), false)).collect()
    }

    /// The outline moved inwards by half a pen; what would come nearer to another border is left
    /// out.
    pub fn inset(&self, pen: f64) -> Vec<Path> {
        let radius = 0.5 * pen;
        let near = Near::new(self.borders.iter().chain(&self.free), radius);
        let ring = |ring: &Vec<Point>| inset_ring(ring, radius, &near);
        self.rings.iter().flat_map(ring).collect()
    }
}

fn edges(points: &[Point], radius: f64) -> impl Iterator<Item = Edge> + '_ {
    points.windows(2).map(move |w| Edge { from: w[0], to: w[1], radius })
}

/// Rows of hatching that a turned edge, grown by `radius`, meets.
fn rows(edge: &Edge, radius: f64, spacing: f64) -> std::ops::RangeInclusive<i64> {
    let low = edge.from[1].min(edge.to[1]) - radius;
    let high = edge.from[1].max(edge.to[1]) + radius;
    (low / spacing).ceil() as i64..=(high / spacing).floor() as i64
}

/// One row of hatching.
#[derive(Default)]
struct Line {
    crossings: Vec<f64>,
    avoided: Vec<[f64; 2]>,
}

impl Line {
    /// Notes where an edge crosses the row; an end on the row belongs to the edge below it.
    fn cross(&mut self, edge: &Edge, y: f64) {
        let (a, b) = (edge.from, edge.to);
        if (a[1] < y) != (b[1] < y) {
            self.crossings.push(a[0] + (y - a[1]) / (b[1] - a[1]) * (b[0] - a[0]));
        }
    }

    /// Notes where the row is within `radius` of an edge: between the extremes of its crossings
    /// with the two end discs and the two sides.
    fn avoid(&mut self, edge: &Edge, radius: f64, y: f64) {
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        let mut take = |x: f64| {
            low = low.min(x);
            high = high.max(x);
        };
        for p in [edge.from, edge.to] {
            let half2 = radius * radius - (y - p[1]).powi(2);
            if half2 >= 0.0 {
                take(p[0] - half2.sqrt());
                take(p[0] + half2.sqrt());
            }
        }
        let length = distance(edge.from, edge.to);
        if length > 0.0 {
            let (ux, uy) =
                ((edge.to[0] - edge.from[0]) / length, (edge.to[1] - edge.from[1]) / length);
            for side in [-radius, radius] {
                let from = [edge.from[0] - side * uy, edge.from[1] + side * ux];
                let t = (y - from[1]) / uy;
                if t >= 0.0 && t <= length {
                    take(from[0] + t * ux);
                }
            }
        }
        if low < high {
            self.avoided.push([low, high]);
        }
    }

    /// What is inside and not avoided, in pieces of at least `shortest`.
    fn strokes(&self, shortest: f64) -> Vec<[f64; 2]> {
        let mut crossings = self.crossings.clone();
        crossings.sort_unstable_by(f64::total_cmp);
        let avoided = merged(self.avoided.clone());
        let mut strokes = Vec::new();
        for inside in crossings.chunks_exact(2) {
            let mut from = inside[0];
            let first = avoided.partition_point(|a| a[1] <= from);
            for &[a, b] in avoided[first..].iter().take_while(|a| a[0] < inside[1]) {
                strokes.push([from, a]);
                from = b;
            }
            strokes.push([from, inside[1]]);
        }
        strokes.retain(|[a, b]| b - a >= shortest);
        strokes
    }
}

/// Intervals without overlaps, in order.
fn merged(mut intervals: Vec<[f64; 2]>) -> Vec<[f64; 2]> {
    intervals.sort_unstable_by(|a, b| a[0].total_cmp(&b[0]));
    let mut out: Vec<[f64; 2]> = Vec::new();
    for [a, b] in intervals {
        match out.last_mut().filter(|last| a <= last[1]) {
            Some(last) => last[1] = last[1].max(b),
            None => out.push([a, b]),
        }
    }
    out
}

/// Edges by the cells of a grid that their surroundings touch.
struct Near<'a> {
    cell: f64,
    pen_radius: f64,
    cells: HashMap<(i64, i64), Vec<&'a Edge>>,
}

impl<'a> Near<'a> {
    fn new(edges: impl Iterator<Item = &'a Edge>, pen_radius: f64) -> Self {
        let cell = (8.0 * pen_radius).max(0.5);
        let mut near = Self { cell, pen_radius, cells: HashMap::new() };
        for edge in edges {
            let reach = edge.radius + pen_radius;
            let span = |i: usize| {
                let low = ((edge.from[i].min(edge.to[i]) - reach) / cell).floor() as i64;
                low..=((edge.from[i].max(edge.to[i]) + reach) / cell).floor() as i64
            };
            for y in span(1) {
                for x in span(0) {
                    near.cells.entry((x, y)).or_default().push(edge);
                }
            }
        }
        near
    }

    /// Whether a pen at `p` keeps off every edge.
    fn is_clear(&self, p: Point) -> bool {
        let key = ((p[0] / self.cell).floor() as i64, (p[1] / self.cell).floor() as i64);
        let limit = |e: &Edge| e.radius + self.pen_radius - 1e-3;
        let edges = self.cells.get(&key).into_iter().flatten();
        edges.into_iter().all(|e| distance_to_segment(p, e.from, e.to) >= limit(e))
    }
}

/// A closed ring moved to its right by `radius`, in the runs that stay clear.
fn inset_ring(ring: &[Point], radius: f64, near: &Near<'_>) -> Vec<Path> {
    let moved: Vec<Point> = ring.windows(2).flat_map(|w| shifted(w[0], w[1], radius)).collect();
    let clear: Vec<bool> = moved.iter().map(|p| near.is_clear(*p)).collect();
    if clear.iter().all(|c| *c) {
        return Path::through(&moved, true).into_iter().collect();
    }
    // From a gap on, so that no run is cut where the ring begins.
    let first = clear.iter().position(|c| !c).unwrap_or(0);
    let mut runs = vec![Vec::new()];
    for i in 0..moved.len() {
        let i = (first + i) % moved.len();
        match clear[i] {
            true => runs.last_mut().expect("there is always a run").push(moved[i]),
            false => runs.push(Vec::new()),
        }
    }
    let long =
        |run: &&Vec<Point>| run.windows(2).map(|w| distance(w[0], w[1])).sum::<f64>() > radius;
    runs.iter().filter(long).filter_map(|run| Path::through(run, false)).collect()
}

/// Points on the parallel to the right of a segment, y down, half a radius apart at most.
fn shifted(a: Point, b: Point, radius: f64) -> Vec<Point> {
    let length = distance(a, b);
    if length == 0.0 {
        return Vec::new();
    }
    let (ux, uy) = ((b[0] - a[0]) / length, (b[1] - a[1]) / length);
    let steps = (length / (0.5 * radius)).ceil().clamp(1.0, 1e6) as usize;
    let at = |i: usize| {
        let s = length * i as f64 / steps as f64;
        [a[0] + s * ux - radius * uy, a[1] + s * uy + radius * ux]
    };
    (0..=steps).map(at).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn square(low: f64, high: f64, clockwise: bool) -> Path {
        let mut points = vec![[low, low], [high, low], [high, high], [low, high]];
        if !clockwise {
            points.reverse();
        }
        Path::through(&points, true).unwrap()
    }

    fn frame() -> Area {
        Area::new(&[square(0.0, 20.0, true), square(8.0, 12.0, false)])
    }

    fn off_border(p: Point) -> f64 {
        let outer = p[0].min(p[1]).min(20.0 - p[0]).min(20.0 - p[1]);
        let [dx, dy] = p.map(|x| ((x - 10.0).abs() - 2.0).max(0.0));
        let inner = dx.hypot(dy);
        outer.min(inner)
    }

    #[test]
    fn hatching_fills_the_area_and_keeps_half_a_pen_from_its_borders() {
        for angle in [0.0, 0.3, 0.785, 1.5, 2.5] {
            let how = Hatch { angle, spacing: 0.5, pen: 0.4 };
            let strokes = frame().hatched(&how);
            let ends = strokes.iter().flat_map(|s| [s.start, s.end()]);
            let least = ends.map(off_border).fold(9.0, f64::min);
            assert!((least - 0.2).abs() < 1e-6, "angle {angle}: {least}");
            let inked: f64 = strokes.iter().map(|s| s.length() * 0.5).sum();
            // 19.6 squared less 4.4 squared, about.
            assert!((inked / 364.8 - 1.0).abs() < 0.03, "angle {angle}: {inked}");
        }
    }

    #[test]
    fn lines_are_kept_free() {
        let mut area = Area::new(&[square(0.0, 20.0, true)]);
        let line = Path::through(&[[10.0, -1.0], [10.0, 21.0]], false).unwrap();
        area.keep_free(&[line], 2.0);
        let how = Hatch { angle: 0.0, spacing: 1.0, pen: 0.2 };
        let strokes = area.hatched(&how);
        assert!(strokes.len() >= 36);
        assert!(
            strokes.iter().flat_map(|s| [s.start, s.end()]).all(|p| (p[0] - 10.0).abs() > 1.0999)
        );
    }

    #[test]
    fn outlines_are_inset_by_half_a_pen() {
        let paths = frame().inset(1.0);
        assert!(!paths.is_empty());
        for p in paths.iter().flat_map(|p| p.points(0.01)) {
            assert!((off_border(p) - 0.5).abs() < 0.15, "{p:?}: {}", off_border(p));
        }
        let drawn: f64 = paths.iter().map(Path::length).sum();
        assert!((drawn / (4.0 * 19.0 + 4.0 * 5.0) - 1.0).abs() < 0.06, "{drawn}");
        // Too narrow for the pen: nothing.
        assert!(Area::new(&[square(0.0, 0.8, true)]).inset(1.0).is_empty());
    }
}
