//! [`Near`]: the segments of a frame's strokes in a grid, asked for the nearest one.

use crate::stroke::Stroke;
use crate::view::View;
use chiaro_basis::math::DVec2;

/// Side of a cell, pixels.
const CELL: f64 = 8.0;
/// By which single precision may be off in the picture, pixels.
const SLACK: f32 = 0.01;

/// A segment between two samples of a stroke, or the one that closes it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Segment {
    /// The stroke's index.
    pub(crate) stroke: u32,
    /// Its first sample.
    pub(crate) first: u32,
    /// Whether it is the last of an open stroke.
    pub(crate) last: bool,
    /// Whether the stroke is open.
    pub(crate) open: bool,
    /// Its ends in the picture.
    pub(crate) ends: [DVec2; 2],
    /// Their depths.
    pub(crate) depths: [f64; 2],
}

/// The nearest place.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Hit {
    /// The segment.
    pub(crate) segment: Segment,
    /// Where on it, 0 to 1.
    pub(crate) share: f64,
    /// How far the position lies beyond the stroke's end along the line, pixels.
    pub(crate) beyond: f64,
    /// How far away, pixels.
    pub(crate) distance: f64,
}

/// A disc around a segment, by which most are known to be too far away.
#[derive(Clone, Copy, Default)]
struct Disc {
    segment: u32,
    middle: [f32; 2],
    radius: f32,
}

/// The segments of a frame.
pub(crate) struct Near {
    segments: Vec<Segment>,
    /// The discs of all cells, and where each cell's begin, and the end.
    discs: Vec<Disc>,
    starts: Vec<u32>,
    size: (usize, usize),
}

impl Disc {
    fn of(index: usize, segment: &Segment) -> Self {
        let [a, b] = segment.ends;
        let middle = (0.5 * (a + b)).as_vec2().to_array();
        Self { segment: index as u32, middle, radius: 0.5 * a.distance(b) as f32 + SLACK }
    }

    /// Whether some of it may be within a distance of a position.
    fn meets(&self, at: [f32; 2], distance: f32) -> bool {
        let [x, y] = [at[0] - self.middle[0], at[1] - self.middle[1]];
        let most = distance + self.radius;
        x * x + y * y <= most * most
    }
}

impl Segment {
    /// Its direction.
    pub(crate) fn direction(&self) -> DVec2 {
        (self.ends[1] - self.ends[0]).normalize_or_zero()
    }

    /// The depth at a share of it.
    pub(crate) fn depth(&self, share: f64) -> f64 {
        self.depths[0] + (self.depths[1] - self.depths[0]) * share
    }

    fn hit(&self, at: DVec2) -> Hit {
        let d = self.ends[1] - self.ends[0];
        let t = (at - self.ends[0]).dot(d) / d.length_squared();
        let t = if t.is_finite() { t } else { 0.5 };
        let share = t.clamp(0.0, 1.0);
        let over = (t - share) * d.length();
        let at_end = self.open && ((over < 0.0 && self.first == 0) || (over > 0.0 && self.last));
        let beyond = if at_end { over.abs() } else { 0.0 };
        let distance = at.distance(self.ends[0] + d * share);
        Hit { segment: *self, share, beyond, distance }
    }
}

impl Near {
    /// The segments of some strokes.
    pub(crate) fn of<'a>(strokes: impl Iterator<Item = &'a Stroke>, view: &View) -> Self {
        let cells = |n: usize| (n as f64 / CELL).ceil() as usize + 2;
        let size = (cells(view.size.0), cells(view.size.1));
        let mut near = Self { segments: Vec::new(), discs: Vec::new(), starts: Vec::new(), size };
        strokes.enumerate().for_each(|(i, stroke)| near.add(i as u32, stroke));
        near.sort();
        near
    }

    fn add(&mut self, index: u32, stroke: &Stroke) {
        let s = &stroke.samples;
        let count = if stroke.closed { s.len() } else { s.len().saturating_sub(1) };
        for k in 0..count {
            let (a, b) = (&s[k], &s[(k + 1) % s.len()]);
            self.segments.push(Segment {
                stroke: index,
                first: k as u32,
                last: !stroke.closed && k + 1 == count,
                open: !stroke.closed,
                ends: [a.at, b.at],
                depths: [a.depth, b.depth],
            });
        }
    }

    /// Puts the discs of the segments into the cells that their boxes meet.
    fn sort(&mut self) {
        let boxed = |s: &Segment| {
            let [a, b] = s.ends;
            self.rows(a.min(b), a.max(b)).flat_map(|[first, last]| first..=last)
        };
        let mut starts = vec![0u32; self.size.0 * self.size.1 + 1];
        self.segments.iter().flat_map(boxed).for_each(|cell| starts[cell + 1] += 1);
        (1..starts.len()).for_each(|c| starts[c] += starts[c - 1]);
        let mut discs = vec![Disc::default(); starts[starts.len() - 1] as usize];
        let mut free = starts.clone();
        for (i, segment) in self.segments.iter().enumerate() {
            for cell in boxed(segment) {
                discs[free[cell] as usize] = Disc::of(i, segment);
                free[cell] += 1;
            }
        }
        (self.discs, self.starts) = (discs, starts);
    }

    /// The cells of a box, row by row: the first of a row's, and the last.
    fn rows(&self, low: DVec2, high: DVec2) -> impl Iterator<Item = [usize; 2]> + use<> {
        let (low, high, width) = (self.cell(low), self.cell(high), self.size.0);
        (low.1..=high.1).map(move |y| [y * width + low.0, y * width + high.0])
    }

    /// The cell of a position; what lies outside is in the outermost ones.
    fn cell(&self, at: DVec2) -> (usize, usize) {
        let index = |x: f64, n: usize| ((x / CELL + 1.0).max(0.0) as usize).min(n - 1);
        (index(at.x, self.size.0), index(at.y, self.size.1))
    }

    /// The nearest accepted place within `reach` pixels; `handicap` makes a place seem further by
    /// so much (not less than 0), or refuses it. Ties go to the lower index.
    pub(crate) fn nearest(
        &self,
        at: DVec2,
        reach: f64,
        handicap: impl Fn(&Hit) -> Option<f64>,
    ) -> Option<Hit> {
        let mut best: Option<(f64, u32, Hit)> = None;
        let single = at.as_vec2().to_array();
        for [first, last] in self.rows(at - reach, at + reach) {
            let [from, to] = [first, last + 1].map(|c| self.starts[c] as usize);
            for disc in &self.discs[from..to] {
                // Nothing seems nearer than it is.
                let most = best.as_ref().map_or(reach, |b| b.0.min(reach));
                if !disc.meets(single, most as f32) {
                    continue;
                }
                let i = disc.segment;
                let hit = self.segments[i as usize].hit(at);
                if hit.distance > most {
                    continue;
                }
                let Some(more) = handicap(&hit) else { continue };
                let key = hit.distance + more;
                if best.as_ref().is_none_or(|b| (key, i) < (b.0, b.1)) {
                    best = Some((key, i, hit));
                }
            }
        }
        best.map(|b| b.2)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::path::Kind;
    use crate::stroke::Sample;
    use crate::surface::NONE;
    use chiaro_basis::math::{DVec3, Vec3};
    use chiaro_basis::random;

    #[test]
    fn the_grid_finds_what_looking_at_everything_finds() {
        let projection = chiaro_scene::Projection::Orthographic { half_height: 1.0 };
        let pose = chiaro_scene::Pose::look_at(Vec3::Z, Vec3::ZERO, Vec3::Y, projection);
        let view = View::new(pose, (96, 64));
        // In the picture and around it, short and long.
        let some = |k: u32| f64::from(random::unit(7, u64::from(k)));
        let place = |k: u32| DVec2::new(140.0 * some(2 * k) - 22.0, 110.0 * some(2 * k + 1) - 22.0);
        let sample = |at: DVec2| Sample {
            at,
            depth: 1.0,
            world: DVec3::ZERO,
            next_world: None,
            next_at: None,
            chain: 0,
            on_chain: 0.0,
            normal: DVec3::Z,
            faces: [NONE; 2],
        };
        let line = |l: u32| {
            let step = if l.is_multiple_of(3) { 30.0 } else { 3.0 };
            let samples = (0..6)
                .map(|k| sample(place(7 * l) + step * (place(100 * l + k) - place(50)) / 100.0));
            Stroke::through(Kind::Silhouette, l.is_multiple_of(2), samples.collect())
        };
        let strokes: Vec<Stroke> = (0..60).map(line).collect();
        let near = Near::of(strokes.iter(), &view);
        let handicap = |hit: &Hit| match hit.segment.stroke % 4 {
            0 => None,
            1 => Some(2.0),
            _ => Some(0.0),
        };
        let mut found = 0;
        for at in (0..500).map(|k| place(1000 + k)) {
            let all = near.segments.iter().map(|s| s.hit(at)).filter(|h| h.distance <= 8.0);
            let all = all.filter_map(|h| Some((h.distance + handicap(&h)?, h)));
            let least = all.min_by(|a, b| a.0.total_cmp(&b.0)).map(|a| a.1);
            let key = |h: Hit| (h.segment.stroke, h.segment.first, h.distance);
            assert_eq!(near.nearest(at, 8.0, handicap).map(key), least.map(key), "{at}");
            found += usize::from(least.is_some());
        }
        assert!(found > 100, "{found}");
    }
}
