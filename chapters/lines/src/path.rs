//! [`Path`]: a line of one frame in space and in the picture, before anything is known of what
//! hides it.

use crate::view::{Seen, View};
use chiaro_basis::math::{DVec2, DVec3};

/// What kind of line.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Kind {
    /// Where the surface turns away from the camera.
    Silhouette,
    /// A sharp edge, seen from its front on both sides.
    Crease,
    /// Where the surface ends.
    Border,
    /// Between two materials.
    Material,
    /// Where two pieces of the surface pass through each other.
    Intersection,
    /// Where a silhouette would appear if the view turned a little.
    Suggestive,
    /// Where the surface is bent outwards most.
    Ridge,
    /// Where the surface is bent inwards most.
    Valley,
    /// Where the surface is bent most as the picture shows it.
    ApparentRidge,
    /// Where the surface turns away from a light.
    Terminator,
}

impl Kind {
    /// All kinds, in the order in which they are drawn.
    pub const ALL: [Self; 10] = [
        Self::Terminator,
        Self::Suggestive,
        Self::ApparentRidge,
        Self::Valley,
        Self::Ridge,
        Self::Material,
        Self::Intersection,
        Self::Crease,
        Self::Border,
        Self::Silhouette,
    ];

    /// Its name in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Silhouette => "silhouette",
            Self::Crease => "crease",
            Self::Border => "border",
            Self::Material => "material",
            Self::Intersection => "intersection",
            Self::Suggestive => "suggestive",
            Self::Ridge => "ridge",
            Self::Valley => "valley",
            Self::ApparentRidge => "apparent-ridge",
            Self::Terminator => "terminator",
        }
    }

    /// Whether it is made of edges of the surface.
    pub fn is_edge(self) -> bool {
        matches!(self, Self::Crease | Self::Border | Self::Material)
    }

    /// Whether it is followed through time by votes in the picture alone.
    pub fn is_voted(self) -> bool {
        self == Self::Intersection
    }

    /// Whether such a line can stand in front of another.
    pub fn occludes(self) -> bool {
        matches!(self, Self::Silhouette | Self::Border)
    }
}

/// A point of a path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    /// In world space.
    pub world: DVec3,
    /// The same material point one frame later, in world space.
    pub next: Option<DVec3>,
    /// From where visibility is asked: pushed out of the surface a little.
    pub pushed: DVec3,
    /// Where on its chain: index of a crossing or vertex, and the share of the way to the next.
    pub on_chain: f64,
}

/// What lies between a point and the next.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Segment {
    /// Faces that do not hide it: its own.
    pub own: [u32; 2],
    /// Never visible, whatever is in front.
    pub buried: bool,
    /// Outside the picture.
    pub outside: bool,
    /// A silhouette runs here too: it is that one that is seen or hidden.
    pub shared: bool,
    /// It is the surface's back that is seen beside it, not its front.
    pub back: bool,
}

impl Segment {
    /// A segment on some faces of which nothing else is known.
    pub fn of(own: [u32; 2]) -> Self {
        Self { own, buried: false, outside: false, shared: false, back: false }
    }
}

/// A line of one frame.
#[derive(Clone, Debug, PartialEq)]
pub struct Path {
    /// Its kind.
    pub kind: Kind,
    /// Which chain of its kind.
    pub chain: u32,
    /// Whether the last point is joined to the first; the first is then repeated at the end.
    pub closed: bool,
    /// Whether it is where a masked face ends: such a line is on the border of a hole, in none.
    pub fringe: bool,
    /// Its points.
    pub points: Vec<Point>,
    /// Where each point is in the picture; `None` behind the camera.
    pub seen: Vec<Option<Seen>>,
    /// What the picture coordinates of each point are divided by: its depth, 1 in orthographic views.
    pub divisors: Vec<f64>,
    /// One less than points.
    pub segments: Vec<Segment>,
    /// Picture length from the first point to each, pixels; segments that are not inside the
    /// picture have none.
    pub length: Vec<f64>,
}

/// A position on a path: index of a segment, and the share of it, as it is in the picture.
pub type Place = f64;

impl Path {
    /// A path through `points` (the first repeated at the end if it is closed); segments are cut at
    /// the picture's edge, `margin` pixels outside of it.
    pub fn new(
        kind: Kind,
        chain: u32,
        closed: bool,
        points: &[Point],
        segments: &[Segment],
        view: &View,
        margin: f64,
    ) -> Self {
        let mut path = Self {
            kind,
            chain,
            closed,
            fringe: false,
            points: Vec::with_capacity(points.len()),
            seen: Vec::with_capacity(points.len()),
            divisors: Vec::with_capacity(points.len()),
            segments: Vec::with_capacity(segments.len()),
            length: Vec::with_capacity(points.len()),
        };
        let Some(first) = points.first() else { return path };
        path.put(*first, view);
        for (pair, segment) in points.windows(2).zip(segments) {
            path.run(pair[0], pair[1], *segment, view, margin);
        }
        path
    }

    fn put(&mut self, point: Point, view: &View) {
        self.seen.push(view.see(point.world));
        self.divisors.push(view.homogeneous(point.world)[2]);
        self.points.push(point);
        self.length.push(self.length.last().copied().unwrap_or(0.0));
    }

    /// Adds the segment from `a`, which is there already, to `b`.
    fn run(&mut self, a: Point, b: Point, segment: Segment, view: &View, margin: f64) {
        let outside = Segment { buried: true, outside: true, ..segment };
        let Some([t0, t1]) = inside(a.world, b.world, view, margin) else {
            self.segments.push(outside);
            self.put(b, view);
            return;
        };
        if t0 > 0.0 {
            self.segments.push(outside);
            self.put(Point::mix(&a, &b, t0), view);
        }
        self.segments.push(segment);
        self.put(if t1 < 1.0 { Point::mix(&a, &b, t1) } else { b }, view);
        let n = self.points.len();
        if let (Some(p), Some(q)) = (self.seen[n - 2], self.seen[n - 1]) {
            self.length[n - 1] += p.at.distance(q.at);
        }
        if t1 < 1.0 {
            self.segments.push(outside);
            self.put(b, view);
        }
    }

    /// Its picture length in pixels.
    pub fn total(&self) -> f64 {
        self.length.last().copied().unwrap_or(0.0)
    }

    /// The diagonal of the part of the picture that it takes, pixels.
    pub fn extent(&self) -> f64 {
        let (mut low, mut high) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
        for (k, _) in self.segments.iter().enumerate().filter(|(_, s)| !s.outside) {
            for seen in self.seen[k..k + 2].iter().flatten() {
                (low, high) = (low.min(seen.at), high.max(seen.at));
            }
        }
        if low.x <= high.x { low.distance(high) } else { 0.0 }
    }

    /// The point at a place.
    pub fn point(&self, place: Place) -> Point {
        let k = (place.max(0.0) as usize).min(self.segments.len().saturating_sub(1));
        match self.points.get(k + 1) {
            Some(next) => Point::mix(&self.points[k], next, self.in_space(k, place - k as f64)),
            None => self.points[k],
        }
    }

    /// The share in space of a segment's share in the picture: far halves look shorter.
    pub(crate) fn in_space(&self, segment: usize, share: f64) -> f64 {
        share_between([self.divisors[segment], self.divisors[segment + 1]], share)
    }

    /// The place a share of the way along a segment in space.
    pub fn place_in_space(&self, segment: usize, share: f64) -> Place {
        let [a, b] = [self.divisors[segment], self.divisors[segment + 1]];
        segment as f64 + share_between([b, a], share)
    }

    /// The picture length up to a place.
    pub fn length_at(&self, place: Place) -> f64 {
        let k = (place.max(0.0) as usize).min(self.segments.len().saturating_sub(1));
        let (a, b) = (self.length[k], self.length[(k + 1).min(self.length.len() - 1)]);
        a + (b - a) * (place - k as f64)
    }

    /// The place at a picture length.
    pub fn place_at(&self, length: f64) -> Place {
        let k =
            self.length.partition_point(|l| *l <= length).clamp(1, self.length.len().max(2) - 1);
        let (a, b) = (self.length[k - 1], self.length[k]);
        let t = if b > a { ((length - a) / (b - a)).clamp(0.0, 1.0) } else { 0.0 };
        (k - 1) as f64 + t
    }

    /// The picture length up to a place that may lie past the last point of a closed path.
    pub fn length_around(&self, place: Place) -> f64 {
        let n = self.segments.len() as f64;
        if place > n { self.total() + self.length_at(place - n) } else { self.length_at(place) }
    }

    /// The place at a length that may be more than the whole of a closed path.
    pub fn place_around(&self, length: f64) -> Place {
        let total = self.total();
        let past = self.closed && length > total;
        if past {
            self.place_at(length - total) + self.segments.len() as f64
        } else {
            self.place_at(length)
        }
    }

    /// The picture length of a run.
    pub fn run_length(&self, run: crate::visibility::Run) -> f64 {
        self.length_around(run.end) - self.length_around(run.start)
    }

    /// Where a place falls in the picture; places may lie past the last point of a closed path.
    pub fn seen_at(&self, place: Place) -> Option<Seen> {
        let n = self.segments.len() as f64;
        let place = if place > n && self.closed { place - n } else { place };
        let k = (place.max(0.0) as usize).min(self.segments.len().checked_sub(1)?);
        let (a, b) = (self.seen[k]?, self.seen[k + 1]?);
        let t = place - k as f64;
        let depth = a.depth + (b.depth - a.depth) * self.in_space(k, t);
        Some(Seen { at: a.at.lerp(b.at, t), depth })
    }
}

impl Point {
    /// The point a share `t` of the way from `a` to `b`.
    pub fn mix(a: &Self, b: &Self, t: f64) -> Self {
        Self {
            world: a.world.lerp(b.world, t),
            next: a.next.zip(b.next).map(|(p, q)| p.lerp(q, t)),
            pushed: a.pushed.lerp(b.pushed, t),
            on_chain: a.on_chain + (b.on_chain - a.on_chain) * t,
        }
    }
}

/// What a share of a segment in one of picture and space is in the other; `a` and `b` belong to its ends.
fn share_between([a, b]: [f64; 2], share: f64) -> f64 {
    if a > 0.0 && b > 0.0 { share * a / (share * a + (1.0 - share) * b) } else { share }
}

/// The part of a segment that falls inside the picture, as shares of it (Liang and Barsky 1984, in
/// homogeneous coordinates).
fn inside(a: DVec3, b: DVec3, view: &View, margin: f64) -> Option<[f64; 2]> {
    let near = f64::from(view.pose.near).max(1e-9) * (1.0 + 1e-6);
    let (w, h) = (view.size.0 as f64 + margin, view.size.1 as f64 + margin);
    let distances = |p: DVec3| {
        let [x, y, s, z] = view.homogeneous(p);
        [z - near, x + margin * s, w * s - x, y + margin * s, h * s - y]
    };
    let (da, db) = (distances(a), distances(b));
    let (mut t0, mut t1) = (0.0f64, 1.0f64);
    for (p, q) in da.into_iter().zip(db) {
        if p < 0.0 && q < 0.0 {
            return None;
        }
        if p < 0.0 {
            t0 = t0.max(p / (p - q));
        } else if q < 0.0 {
            t1 = t1.min(p / (p - q));
        }
    }
    (t0 < t1).then_some([t0, t1])
}

#[cfg(test)]
mod tests {
    use super::*;
    use chiaro_basis::math::vec3;
    use chiaro_scene::{Pose, Projection};

    #[test]
    fn a_place_is_the_same_in_the_picture_and_in_space() {
        let (eye, aim, up) = (vec3(0.0, 1.0, 3.0), vec3(0.0, 0.0, 0.0), vec3(0.0, 1.0, 0.0));
        let point = |world| Point { world, next: None, pushed: world, on_chain: 0.0 };
        // From just before the eye to far away.
        let ends = [point(DVec3::new(-0.4, 0.0, 1.5)), point(DVec3::new(2.0, 0.5, -9.0))];
        let segment = Segment::of([0; 2]);
        for projection in
            [Projection::Perspective { fov_y: 1.2 }, Projection::Orthographic { half_height: 3.0 }]
        {
            let view = View::new(Pose::look_at(eye, aim, up, projection), (640, 480));
            let path = Path::new(Kind::Crease, 0, false, &ends, &[segment], &view, 8.0);
            for k in 0..=20 {
                let place = path.segments.len() as f64 * f64::from(k) / 20.0;
                let seen = path.seen_at(place).expect("it is before the eye");
                let world = path.point(place).world;
                let again = view.see(world).expect("it is before the eye");
                assert!(seen.at.distance(again.at) < 1e-6, "{place}: {seen:?} {again:?}");
                assert!((seen.depth - again.depth).abs() < 1e-9);
                let segment = (place as usize).min(path.segments.len() - 1);
                let share = path.in_space(segment, place - segment as f64);
                assert!((path.place_in_space(segment, share) - place).abs() < 1e-9);
            }
        }
    }
}
