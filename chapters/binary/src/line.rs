//! Pixel lines on top of the regions, with one colour rule.
//!
//! A line runs between two pixels where a depth step, a crease or a change of object is; it is
//! drawn in the other colour where both sides have the same label, and not at all where the border
//! of the regions draws it already. Paper counts as a white side: the outline is drawn where the
//! region is white. A region narrower than the line counts as its other side, so that lines do not
//! thin out or break where a sliver would stand for them; a region that a line would all but fill, or
//! cut a sliver off, gets none. A crease beside a step or another object, nearer than a line is wide,
//! leaves the line to that.

use crate::bridge::{DRAWN, bridge};
use crate::faint::{CREASE, FAINT, FAINT_CREASE, go_on};
use crate::geometry::{angle, depth_step};
use crate::halo::behind;
use crate::knob::{BinaryKnobs, DepthForm, scaled};
use crate::room::{Ground, next};
use chiaro_basis::math::Vec3;
use chiaro_image::{Plane, filter};
use chiaro_ink::{Cracks, Polyline};
use chiaro_trace::GBuffer;
use rayon::prelude::*;
use std::f32::consts::PI;

/// Gaps up to this are closed where a line goes on, and dashes from this on take part; pixels at
/// 480.
const WIDEST_GAP: f32 = 10.0;
const LEAST_DASH: f32 = 3.0;
/// Features this near to a map's lines are those that it draws; pixels at 480.
const MAP_REACH: f32 = 2.0;
/// Lines go on where a depth step is over so much of the least that draws one, and creases where a bend
/// is: at 40 degrees, over 32, so that sides of cylinders of twelve faces are none.
const FAINTEST: f32 = 0.5;
const FAINTEST_BEND: f32 = 0.8;

/// Lines to be drawn.
#[derive(Clone, Debug, Default)]
pub struct Lines {
    /// On white.
    pub black: Vec<Polyline>,
    /// On black.
    pub white: Vec<Polyline>,
    /// Their width in pixels of this picture.
    pub width: f32,
}

impl Lines {
    /// The lines of a labelled picture. `paper_is_white` says whether what is not covered counts
    /// as white.
    pub fn find(
        buffer: &GBuffer,
        white: &Plane<bool>,
        paper_is_white: bool,
        knobs: &BinaryKnobs,
    ) -> Self {
        let features = Features::find(buffer, knobs);
        Self::between(&features, white, &buffer.covered, paper_is_white, knobs)
    }

    /// The lines that features draw between labels.
    pub fn between(
        features: &Features,
        white: &Plane<bool>,
        covered: &Plane<bool>,
        paper_is_white: bool,
        knobs: &BinaryKnobs,
    ) -> Self {
        if !knobs.lines {
            return Self::default();
        }
        let (w, h) = covered.size();
        let shortest = scaled(knobs.line_shortest, h);
        let least = scaled(LEAST_DASH, h).min(shortest);
        let gap = scaled(WIDEST_GAP, h);
        let rounds = (2.0 * scaled(1.0, h)).ceil() as usize;
        let width = scaled(knobs.line_width, h);
        let ground = Ground { white, covered, paper_is_white, width };
        let lines = |side: bool| {
            let mut marks = Plane::from_fn(w, h, |x, y| {
                let mark = |axis| match features.run((x, y), axis) {
                    true => ground.mark((x, y), axis, side),
                    false => 0,
                };
                mark(0) | mark(1) << 1
            });
            bridge(&mut marks);
            let is_drawn = |x: usize, y: usize, axis: usize| marks[(x, y)] & DRAWN << axis != 0;
            Cracks::mark(w, h, is_drawn).joined(least, gap, shortest, rounds)
        };
        Self {
            black: if knobs.line_black { lines(true) } else { Vec::new() },
            white: if knobs.line_white { lines(false) } else { Vec::new() },
            width,
        }
    }
}

/// Where lines may run, whatever the labels: between which pixels there is a depth step, a crease,
/// a change of object, or the outline.
#[derive(Clone, Debug, Default)]
pub struct Features {
    /// Bit 0: between a pixel and its right neighbour; bit 1: and its lower one.
    pub marks: Plane<u8>,
    /// The gaps behind what occludes, if there are any.
    pub halo: Option<Plane<bool>>,
}

impl Features {
    /// The features of a picture; none where the knobs draw no lines.
    pub fn find(buffer: &GBuffer, knobs: &BinaryKnobs) -> Self {
        if !knobs.lines {
            return Self::default();
        }
        let (w, h) = buffer.size();
        let finder = Finder {
            buffer,
            knobs,
            least_cos: least_bend(knobs).to_radians().min(PI).cos() + 1e-3,
            half_height: half_heights(buffer),
        };
        let mut marks = vec![0u8; w * h];
        marks.par_chunks_mut(w.max(1)).enumerate().for_each(|(y, row)| {
            for (x, mark) in row.iter_mut().enumerate() {
                let right = if x + 1 < w { finder.line((x, y), (x + 1, y)) } else { 0 };
                let below = if y + 1 < h { finder.line((x, y), (x, y + 1)) } else { 0 };
                *mark = right | below << 1;
            }
        });
        go_on(&mut marks, w);
        let halo = behind(buffer, &finder, knobs);
        Self { marks: Plane::from_pixels(w, h, marks), halo }
    }

    /// The features that a map, drawn on top, does not draw itself: those beside its lines are out.
    pub fn beside(mut self, map: &Plane<bool>) -> Self {
        let reach = scaled(MAP_REACH, map.height()).max(1.5);
        let away = filter::distance_to(map);
        for (mark, distance) in self.marks.pixels_mut().iter_mut().zip(away.pixels()) {
            if *distance <= reach {
                *mark = 0;
            }
        }
        self
    }

    /// Labels with the gaps white.
    pub fn haloed(&self, white: &Plane<bool>) -> Plane<bool> {
        match &self.halo {
            Some(halo) => white.zip(halo, |w, gap| *w || *gap).expect("one picture, one size"),
            None => white.clone(),
        }
    }

    /// Labels of a palette with the gaps in its `lightest` colour.
    pub fn lightened(&self, labels: &Plane<u8>, lightest: u8) -> Plane<u8> {
        match &self.halo {
            Some(halo) => {
                let paint = |l: &u8, gap: &bool| if *gap { lightest } else { *l };
                labels.zip(halo, paint).expect("one picture, one size")
            }
            None => labels.clone(),
        }
    }

    /// Whether a feature runs between a pixel and the next one along an axis that no gap hides.
    fn run(&self, p: Pixel, axis: usize) -> bool {
        let q = next(p, axis);
        self.marks[p] & (1 << axis) != 0 && !(self.in_halo(p) && self.in_halo(q))
    }

    fn in_halo(&self, p: Pixel) -> bool {
        self.halo.as_ref().is_some_and(|halo| halo[p])
    }
}

pub(crate) struct Finder<'a> {
    buffer: &'a GBuffer,
    knobs: &'a BinaryKnobs,
    /// Normals whose cosine is greater make no crease.
    least_cos: f32,
    /// Half the height of what is seen at a depth of 0, and by how much it grows with depth.
    half_height: [f32; 2],
}

type Pixel = (usize, usize);

/// Half the height of what is seen at a depth of 0, and by how much it grows with depth.
fn half_heights(buffer: &GBuffer) -> [f32; 2] {
    let [near, far] = [0.0, 1.0].map(|z| buffer.pose.pixel_size(z, 2.0));
    [near, far - near]
}

/// The least bend along which a line goes on, degrees.
fn least_bend(knobs: &BinaryKnobs) -> f32 {
    let asked = knobs.line_crease;
    match asked > 180.0 {
        true => asked,
        false => FAINTEST_BEND * asked,
    }
}

impl Finder<'_> {
    /// 1 or [`CREASE`] where a line runs, [`FAINT`] or [`FAINT_CREASE`] where one may go on, else 0.
    fn line(&self, p: Pixel, q: Pixel) -> u8 {
        match (self.buffer.covered[p], self.buffer.covered[q]) {
            (true, true) => self.inner_line(p, q),
            (false, false) => 0,
            _ => u8::from(self.knobs.line_silhouette),
        }
    }

    /// What pairs of pixels without a feature are told by most cheaply comes first.
    fn inner_line(&self, p: Pixel, q: Pixel) -> u8 {
        let k = self.knobs;
        if k.line_objects && self.buffer.object[p] != self.buffer.object[q] {
            return 1;
        }
        let step = self.step(p, q);
        if step > 1.0 {
            return 1;
        }
        let bend = self.crease(p, q).filter(|_| !self.is_beside_edge(p, q));
        match bend {
            Some(bend) if bend >= k.line_crease => CREASE,
            _ if step > 0.0 => FAINT,
            Some(_) => FAINT_CREASE,
            None => 0,
        }
    }

    /// Whether a step, another object or the outline runs along a pair of pixels, nearer than a line
    /// is wide: bevels of a pixel would draw it twice.
    fn is_beside_edge(&self, p: Pixel, q: Pixel) -> bool {
        let b = self.buffer;
        let reach = scaled(self.knobs.line_width, b.size().1).ceil() as isize;
        let to = |at: Pixel, (dx, dy): (isize, isize), k: isize| {
            (at.0 as isize + k * dx, at.1 as isize + k * dy)
        };
        let along = (q.0 as isize - p.0 as isize, q.1 as isize - p.1 as isize);
        let across = (along.1, along.0);
        let beyond = (1..=reach).any(|k| {
            self.is_edge(to(p, along, -k), to(p, along, 1 - k))
                || self.is_edge(to(q, along, k - 1), to(q, along, k))
        });
        let beside = |at: Pixel| {
            let here = to(at, across, 0);
            self.is_edge(here, to(at, across, 1)) || self.is_edge(here, to(at, across, -1))
        };
        beyond || beside(p) || beside(q)
    }

    /// Whether a step, another object or the outline lies between two places.
    fn is_edge(&self, a: (isize, isize), b: (isize, isize)) -> bool {
        let buffer = self.buffer;
        let covered = |(x, y): (isize, isize)| buffer.covered.at(x, y).copied();
        let pixel = |(x, y): (isize, isize)| (x as usize, y as usize);
        match (covered(a), covered(b)) {
            (Some(true), Some(true)) => {
                let (p, q) = (pixel(a), pixel(b));
                let objects = self.knobs.line_objects && buffer.object[p] != buffer.object[q];
                objects || self.is_step(p, q)
            }
            (Some(a), Some(b)) => a != b && self.knobs.line_silhouette,
            _ => false,
        }
    }

    /// The least step that draws a line, in scene units. In a room, R is much more than what is seen:
    /// there it is half the height of that.
    pub(crate) fn limit(&self, p: Pixel) -> f32 {
        let [at_eye, slope] = self.half_height;
        let seen = at_eye + slope * self.buffer.depth[p];
        self.knobs.line_depth * self.buffer.radius.min(seen)
    }

    /// A depth step.
    pub(crate) fn is_step(&self, p: Pixel, q: Pixel) -> bool {
        self.step(p, q) > 1.0
    }

    /// A depth step in parts of the least that draws a line, or 0 where no line would even go on. On what
    /// is nearly edge-on a pixel's own depth range is no step.
    fn step(&self, p: Pixel, q: Pixel) -> f32 {
        let step = depth_step(self.buffer, p, q, DepthForm::Plane);
        let limit = self.limit(p).min(self.limit(q));
        let is_step =
            step > FAINTEST * limit && step > 2.0 * self.depth_range(p).min(self.depth_range(q));
        if is_step { step / limit } else { 0.0 }
    }

    /// A depth step at which one surface hides another, and does not meet it within the two pixels.
    pub(crate) fn hides(&self, p: Pixel, q: Pixel) -> bool {
        if !self.is_step(p, q) {
            return false;
        }
        let step = depth_step(self.buffer, p, q, DepthForm::Plane);
        !self.meet(p, q) || step > 2.0 * self.depth_range(p).max(self.depth_range(q))
    }

    /// Whether each of two pixels lies before the other's plane, as in a corner, or each behind it, as at
    /// an edge. What hides lies before the plane of what it hides, and that behind its own.
    fn meet(&self, p: Pixel, q: Pixel) -> bool {
        let b = self.buffer;
        let [from, to] = [p, q].map(|at| Vec3::from(b.position[at]));
        let [n, m] = [p, q].map(|at| Vec3::from(b.geometric_normal[at]));
        (to - from).dot(n) * (from - to).dot(m) > 0.0
    }

    /// How far a pixel's surface reaches in depth, in scene units.
    fn depth_range(&self, p: Pixel) -> f32 {
        let b = self.buffer;
        let facing = b.to_eye(Vec3::from(b.position[p])).dot(Vec3::from(b.smooth_normal[p]));
        let pixel = b.pose.pixel_size(b.depth[p], b.size().1 as f32);
        pixel / facing.abs().max(1e-3)
    }

    /// The bend in degrees of a crease of the smooth surface, drawn or faint: a bend over one pixel that
    /// its surroundings do not share. Of the two beside a pixel of a face seen edge-on, which is as deep
    /// as a step, the greater one, else the first.
    fn crease(&self, p: Pixel, q: Pixel) -> Option<f32> {
        let n = &self.buffer.smooth_normal;
        if Vec3::from(n[p]).dot(Vec3::from(n[q])) > self.least_cos {
            return None;
        }
        let here = self.bend(p, q);
        if here < least_bend(self.knobs).to_radians() {
            return None;
        }
        let (dx, dy) = (q.0 as isize - p.0 as isize, q.1 as isize - p.1 as isize);
        let beyond = |at: Pixel, steps: isize| -> f32 {
            let pixel = |k: isize| (at.0 as isize + k * dx, at.1 as isize + k * dy);
            let (a, b) = (pixel(steps - steps.signum()), pixel(steps));
            let is_covered = |(x, y)| self.buffer.covered.at(x, y) == Some(&true);
            let index = |(x, y): (isize, isize)| (x as usize, y as usize);
            if is_covered(a) && is_covered(b) { self.bend(index(a), index(b)) } else { 0.0 }
        };
        let is_quiet = |bend: f32| bend < 0.5 * here;
        let is_deep = |at| self.depth_range(at) > self.limit(at);
        let (before, after) = (beyond(p, -1), beyond(q, 1));
        let is_crease = match (is_quiet(before), is_quiet(after)) {
            (true, true) => true,
            (true, false) => after <= here && is_deep(q) && is_quiet(beyond(q, 2)),
            (false, true) => before < here && is_deep(p) && is_quiet(beyond(p, -2)),
            (false, false) => false,
        };
        is_crease.then_some(here.to_degrees())
    }

    fn bend(&self, p: Pixel, q: Pixel) -> f32 {
        angle(Vec3::from(self.buffer.smooth_normal[p]), Vec3::from(self.buffer.smooth_normal[q]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use chiaro_scene::{Pose, Projection};

    /// A white rectangle on paper, black where told: how long its outline is drawn, in pixels.
    fn outline(is_black: impl Fn(usize, usize) -> bool + Sync, knobs: &BinaryKnobs) -> usize {
        let (w, h) = (100, 480);
        let covered = Plane::from_fn(w, h, |x, y| (20..80).contains(&x) && (100..200).contains(&y));
        let white = Plane::from_fn(w, h, |x, y| !is_black(x, y));
        let differs = |x: usize, y: usize, (u, v): Pixel| {
            u < w && v < h && covered[(x, y)] != covered[(u, v)]
        };
        let marks = Plane::from_fn(w, h, |x, y| {
            u8::from(differs(x, y, (x + 1, y))) | u8::from(differs(x, y, (x, y + 1))) << 1
        });
        let features = Features { marks, halo: None };
        let lines = Lines::between(&features, &white, &covered, true, knobs);
        let length = |line: &Polyline| {
            let ends = line.points.iter().zip(line.points.iter().cycle().skip(1));
            let sides = line.points.len() - usize::from(!line.closed);
            ends.take(sides).map(|(a, b)| (a[0] - b[0]).hypot(a[1] - b[1])).sum::<f32>()
        };
        lines.black.iter().map(length).sum::<f32>().round() as usize
    }

    #[test]
    fn outlines_run_on_where_a_region_is_narrower_than_they() {
        let knobs = BinaryKnobs::default();
        let below = |rows: usize| {
            outline(|x: usize, y: usize| (40..60).contains(&x) && y < 100 + rows, &knobs)
        };
        assert_eq!(below(0), 320);
        assert_eq!(below(1), 320);
        assert_eq!(below(8), 300);
    }

    #[test]
    fn wide_outlines_run_on_beside_a_row_of_windows() {
        let knobs = BinaryKnobs { line_width: 5.0, ..BinaryKnobs::default() };
        let window = |x: usize, y: usize| (65..77).contains(&x) && (110..190).contains(&y);
        // Windows of twelve rows, and one of all.
        assert_eq!(outline(|x, y| window(x, y) && y % 20 < 12, &knobs), 320);
        assert_eq!(outline(window, &knobs), 240);
    }

    #[test]
    fn white_lines_are_drawn_where_black_is_left_on_both_sides() {
        // A black band of so many rows with an edge after its second one.
        let drawn = |rows: usize| {
            let (w, h) = (100, 480);
            let white = Plane::from_fn(w, h, |_, y| !(100..100 + rows).contains(&y));
            let marks = Plane::from_fn(w, h, |_, y| u8::from(y == 101) << 1);
            let covered = Plane::filled(w, h, true);
            let features = Features { marks, halo: None };
            let lines = Lines::between(&features, &white, &covered, true, &BinaryKnobs::default());
            (lines.white.len(), lines.black.len())
        };
        assert_eq!(drawn(3), (0, 0));
        assert_eq!(drawn(4), (1, 0));
    }

    #[test]
    fn bevels_of_a_pixel_do_not_draw_an_edge_twice() {
        // A slanted rail before a far wall, its upper face a pixel high in every other column or so.
        let side = 64;
        let edge = |x: usize| 20 + x / 6;
        let rail = |bevel: bool| {
            let projection = Projection::Orthographic { half_height: 0.32 };
            let pose = Pose::look_at(Vec3::Z * 20.0, Vec3::ZERO, Vec3::Y, projection);
            let mut buffer = GBuffer::empty(&pose, 1.0, (side, side));
            for (x, y) in (0..side * side).map(|i| (i % side, i / side)) {
                let z = if y < edge(x) { -5.0 } else { 0.0 };
                let is_top = bevel && y == edge(x) && x % 6 < 3;
                let normal = if is_top { [0.0, 1.0, 0.0] } else { [0.0, 0.0, 1.0] };
                let p = (x, y);
                buffer.covered[p] = true;
                buffer.object[p] = 1;
                buffer.depth[p] = 20.0 - z;
                buffer.position[p] = [0.01 * x as f32, -0.01 * y as f32, z];
                buffer.geometric_normal[p] = normal;
                buffer.smooth_normal[p] = normal;
            }
            Features::find(&buffer, &BinaryKnobs::default()).marks
        };
        let plain = rail(false);
        assert_eq!(plain, rail(true));
        assert!(plain.pixels().iter().any(|m| *m > 0));
    }

    #[test]
    fn steps_in_a_room_are_told_by_what_is_seen_of_it() {
        // A board before a wall, four away, in a hall of fifty: less at its right end.
        let (side, fov_y) = (64usize, 1.0f32);
        let pose =
            Pose::look_at(Vec3::Z * 4.0, Vec3::ZERO, Vec3::Y, Projection::Perspective { fov_y });
        let seen = 4.0 * (0.5 * fov_y).tan();
        let drawn = |thick: f32, end: f32| {
            let mut buffer = GBuffer::empty(&pose, 50.0, (side, side));
            for (x, y) in (0..side * side).map(|i| (i % side, i / side)) {
                let out = thick + (end - thick) * x as f32 / side as f32;
                let z = if y < 30 { 0.0 } else { out };
                let p = (x, y);
                buffer.covered[p] = true;
                buffer.object[p] = 1;
                buffer.depth[p] = 4.0 - z;
                buffer.position[p] = [0.001 * x as f32, -0.001 * y as f32, z];
                buffer.geometric_normal[p] = [0.0, 0.0, 1.0];
                buffer.smooth_normal[p] = [0.0, 0.0, 1.0];
            }
            let knobs = BinaryKnobs { line_depth: 0.1, ..BinaryKnobs::default() };
            let marks = Features::find(&buffer, &knobs).marks;
            (0..side).filter(|x| marks[(*x, 29)] & 2 != 0).count()
        };
        assert_eq!(drawn(0.12 * seen, 0.12 * seen), side);
        assert_eq!(drawn(0.12 * seen, 0.07 * seen), side, "it goes on");
        assert_eq!(drawn(0.09 * seen, 0.07 * seen), 0, "too little to begin with");
    }

    #[test]
    fn a_crease_goes_on_where_it_bends_less() {
        // A roof whose eaves bend by so many degrees at the left and at the right.
        let drawn = |left: f32, right: f32, crease: f32| {
            let side = 64usize;
            let projection = Projection::Orthographic { half_height: 0.32 };
            let pose = Pose::look_at(Vec3::Z * 20.0, Vec3::ZERO, Vec3::Y, projection);
            let mut buffer = GBuffer::empty(&pose, 1.0, (side, side));
            for (x, y) in (0..side * side).map(|i| (i % side, i / side)) {
                let bend = (left + (right - left) * x as f32 / side as f32).to_radians();
                let p = (x, y);
                let normal = if y < 30 { [0.0, bend.sin(), bend.cos()] } else { [0.0, 0.0, 1.0] };
                buffer.covered[p] = true;
                buffer.object[p] = 1;
                buffer.depth[p] = 20.0;
                buffer.position[p] = [0.01 * x as f32, -0.01 * y as f32, 0.0];
                buffer.geometric_normal[p] = normal;
                buffer.smooth_normal[p] = normal;
            }
            let knobs = BinaryKnobs { line_crease: crease, ..BinaryKnobs::default() };
            let marks = Features::find(&buffer, &knobs).marks;
            (0..side).filter(|x| marks[(*x, 29)] & 2 != 0).count()
        };
        assert_eq!(drawn(50.0, 50.0, 40.0), 64);
        assert_eq!(drawn(50.0, 33.0, 40.0), 64, "it goes on");
        assert_eq!(drawn(38.0, 33.0, 40.0), 0, "too little to begin with");
        assert!(drawn(50.0, 25.0, 40.0) < 50, "it ends");
        assert_eq!(drawn(100.0, 95.0, 181.0), 0, "none");
    }

    /// How many columns draw no line along the lower edge of a board, `thick` before a wall and seen a
    /// little from below: of its bottom, of which a pixel is `deep`, `seen` pixels are seen, the more the
    /// nearer the first one is to the edge.
    fn gaps(seen: impl Fn(usize) -> usize, [deep, thick]: [f32; 2]) -> usize {
        let side = 64;
        let projection = Projection::Orthographic { half_height: 0.32 };
        let pose = Pose::look_at(Vec3::new(0.0, -2.0, 20.0), Vec3::ZERO, Vec3::Y, projection);
        let mut buffer = GBuffer::empty(&pose, 1.0, (side, side));
        for (x, y) in (0..side * side).map(|i| (i % side, i / side)) {
            let edge = 20 + x / 12;
            let under = (edge..edge + seen(x)).contains(&y);
            let depth = match y {
                _ if under => deep * ((y - edge) as f32 + 1.2 - 0.36 * seen(x) as f32),
                _ if y < edge => 0.0,
                _ => thick,
            };
            let normal = if under { [0.0, -1.0, 0.0] } else { [0.0, 0.0, 1.0] };
            let height = if under { edge } else { y };
            let p = (x, y);
            buffer.covered[p] = true;
            buffer.object[p] = 1;
            buffer.depth[p] = 20.0 + depth;
            buffer.position[p] = [0.01 * x as f32, -0.01 * height as f32, -depth];
            buffer.geometric_normal[p] = normal;
            buffer.smooth_normal[p] = normal;
        }
        let knobs = BinaryKnobs { halo: 14.0, line_width: 16.0, ..BinaryKnobs::default() };
        let features = Features::find(&buffer, &knobs);
        let is_drawn = |x: usize, y: usize| {
            let hidden = features.in_halo((x, y)) && features.in_halo((x, y + 1));
            features.marks[(x, y)] & 2 != 0 && !hidden
        };
        (0..side).filter(|x| !(15..40).any(|y| is_drawn(*x, y))).count()
    }

    #[test]
    fn edges_of_faces_that_are_seen_edge_on_are_drawn_in_every_column() {
        assert_eq!(gaps(|_| 1, [0.012, 0.012]), 0);
        assert_eq!(gaps(|x| x / 4 % 4, [0.07, 0.2]), 0);
    }
}
