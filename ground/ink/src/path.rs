//! Paths of straight and curved segments.

/// A point: x to the right, y down; pixels or millimetres as the maker says.
pub type Point = [f64; 2];

/// A piece of a path, from where the last one ended.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Segment {
    /// Straight to a point.
    Line(Point),
    /// A cubic Bézier curve: two control points and its end.
    Cubic(Point, Point, Point),
}

impl Segment {
    /// Where it ends.
    pub fn end(&self) -> Point {
        match *self {
            Self::Line(p) | Self::Cubic(_, _, p) => p,
        }
    }
}

/// One connected stroke, or the outline of an area.
#[derive(Clone, Debug, PartialEq)]
pub struct Path {
    /// Where it begins.
    pub start: Point,
    /// Its pieces in order.
    pub segments: Vec<Segment>,
    /// Whether its end is joined to its start.
    pub closed: bool,
}

impl Path {
    /// A path of straight lines through `points`, or `None` when there are none. The first point is
    /// not repeated at the end of a closed one.
    pub fn through(points: &[Point], closed: bool) -> Option<Self> {
        let (&start, rest) = points.split_first()?;
        Some(Self { start, segments: rest.iter().map(|&p| Segment::Line(p)).collect(), closed })
    }

    /// Where it ends; a closed path ends where it begins.
    pub fn end(&self) -> Point {
        match self.segments.last() {
            Some(last) if !self.closed => last.end(),
            _ => self.start,
        }
    }

    /// The same path drawn from its end.
    pub fn reversed(&self) -> Self {
        let starts = std::iter::once(self.start).chain(self.segments.iter().map(Segment::end));
        let pairs: Vec<(Point, Segment)> = starts.zip(self.segments.iter().copied()).collect();
        let back = |&(from, segment): &(Point, Segment)| match segment {
            Segment::Line(_) => Segment::Line(from),
            Segment::Cubic(a, b, _) => Segment::Cubic(b, a, from),
        };
        Self {
            start: self.segments.last().map_or(self.start, Segment::end),
            segments: pairs.iter().rev().map(back).collect(),
            closed: self.closed,
        }
    }

    /// Every point moved by `place`, which must be affine for curves to stay what they are.
    pub fn map(&self, place: impl Fn(Point) -> Point) -> Self {
        let segment = |s: &Segment| match *s {
            Segment::Line(p) => Segment::Line(place(p)),
            Segment::Cubic(a, b, p) => Segment::Cubic(place(a), place(b), place(p)),
        };
        Self {
            start: place(self.start),
            segments: self.segments.iter().map(segment).collect(),
            closed: self.closed,
        }
    }

    /// Goes on along `other`, by a straight line where it does not begin at this path's end.
    pub fn extend(&mut self, other: &Self) {
        if distance(self.segments.last().map_or(self.start, Segment::end), other.start) > 1e-9 {
            self.segments.push(Segment::Line(other.start));
        }
        self.segments.extend_from_slice(&other.segments);
    }

    /// Points along the path, at most `tolerance` from it between them; those of a closed path end
    /// with its start.
    pub fn points(&self, tolerance: f64) -> Vec<Point> {
        let mut points = vec![self.start];
        let mut from = self.start;
        for segment in &self.segments {
            if let Segment::Cubic(a, b, p) = *segment {
                let steps = cubic_steps([from, a, b, p], tolerance);
                let inner = (1..steps).map(|i| cubic([from, a, b, p], i as f64 / steps as f64));
                points.extend(inner);
            }
            from = segment.end();
            points.push(from);
        }
        if self.closed && distance(from, self.start) > 1e-9 {
            points.push(self.start);
        }
        points
    }

    /// Its length, to about a thousandth of the path's unit a curve.
    pub fn length(&self) -> f64 {
        self.points(1e-3).windows(2).map(|w| distance(w[0], w[1])).sum()
    }
}

/// The distance between two points.
pub(crate) fn distance(a: Point, b: Point) -> f64 {
    (a[0] - b[0]).hypot(a[1] - b[1])
}

/// The distance of a point from a segment.
pub(crate) fn distance_to_segment(p: Point, a: Point, b: Point) -> f64 {
    let (d, v) = ([b[0] - a[0], b[1] - a[1]], [p[0] - a[0], p[1] - a[1]]);
    let length2 = d[0] * d[0] + d[1] * d[1];
    let t =
        if length2 > 0.0 { ((v[0] * d[0] + v[1] * d[1]) / length2).clamp(0.0, 1.0) } else { 0.0 };
    (v[0] - t * d[0]).hypot(v[1] - t * d[1])
}

fn cubic([a, b, c, d]: [Point; 4], t: f64) -> Point {
    let s = 1.0 - t;
    std::array::from_fn(|i| {
        s * s * s * a[i] + 3.0 * s * s * t * b[i] + 3.0 * s * t * t * c[i] + t * t * t * d[i]
    })
}

/// Equal steps of the parameter that keep within `tolerance`: the second difference of the control
/// points bounds the curve's bend (Wang's formula).
fn cubic_steps(p: [Point; 4], tolerance: f64) -> usize {
    let bend = |i: usize| {
        let second = |k: usize| p[i][k] - 2.0 * p[i + 1][k] + p[i + 2][k];
        second(0).hypot(second(1))
    };
    let steps = (0.75 * bend(0).max(bend(1)) / tolerance.max(1e-9)).sqrt().ceil();
    (steps as usize).clamp(1, 1000)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn arc() -> Path {
        let k = 0.552_284_75;
        let curve = Segment::Cubic([1.0, k], [k, 1.0], [0.0, 1.0]);
        Path { start: [1.0, 0.0], segments: vec![curve, Segment::Line([0.0, 3.0])], closed: false }
    }

    #[test]
    fn a_reversed_path_is_the_same_line() {
        let (path, back) = (arc(), arc().reversed());
        assert_eq!((back.start, back.end()), (path.end(), path.start));
        assert_eq!(back.reversed(), path);
        assert!((back.length() - path.length()).abs() < 1e-9);
    }

    #[test]
    fn points_keep_within_tolerance() {
        let points = arc().points(1e-3);
        let off = |p: &Point| (p[0].hypot(p[1]) - 1.0).abs();
        assert!(points[..points.len() - 1].iter().all(|p| off(p) < 1e-3));
        assert!((arc().length() - (0.5 * std::f64::consts::PI + 2.0)).abs() < 2e-3);
    }

    #[test]
    fn a_closed_path_comes_back() {
        let square = Path::through(&[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]], true);
        let square = square.unwrap();
        assert_eq!(square.length(), 4.0);
        assert_eq!(square.end(), square.start);
    }
}
