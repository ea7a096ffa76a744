//! [`Stroke`]: a visible run of a path as evenly spaced samples.
//!
//! Samples stand exactly on the path, `step` pixels apart at most, with one on every corner, so that
//! each has its place in space and its material point one frame later.

use crate::join::Line;
use crate::path::{Kind, Path, Place};
use crate::surface::NONE;
use crate::view::View;
use crate::visibility::Run;
use chiaro_basis::math::{DVec2, DVec3};
use chiaro_scene::MaterialId;

/// Half the length over which a turn is measured, pixels.
const REACH: f64 = 4.0;
/// A turn by more than this is a corner, radians.
const CORNER: f64 = 0.6;
/// Samples of two parts of a line that are nearer than this are one, pixels.
const TOUCHING: f64 = 0.05;

/// A sample of a stroke.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// In the picture, pixels, y down.
    pub at: DVec2,
    /// Along the view axis, scene units.
    pub depth: f64,
    /// In world space.
    pub world: DVec3,
    /// The same material point one frame later, in world space.
    pub next_world: Option<DVec3>,
    /// Where that falls in the next picture, if it does.
    pub next_at: Option<DVec2>,
    /// Which chain of its kind it is on, in this frame.
    pub chain: u32,
    /// Where on that chain: index of a crossing or vertex, and the share of the way to the next.
    pub on_chain: f64,
    /// Unit normal of the surface, or zero.
    pub normal: DVec3,
    /// Faces of the surface on which it lies, as its path has them.
    pub faces: [u32; 2],
}

/// What a line belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Owner {
    /// Index into [`chiaro_scene::Frame::objects`].
    pub object: u32,
    /// The material.
    pub material: MaterialId,
}

/// A line that is drawn in one go.
#[derive(Clone, Debug, PartialEq)]
pub struct Stroke {
    /// The same through the film.
    pub id: u32,
    /// What kind of line.
    pub kind: Kind,
    /// Which chain of its kind most of it is a part of, in this frame.
    pub chain: u32,
    /// What most of it belongs to, if anything.
    pub owner: Option<Owner>,
    /// Whether the last sample is joined to the first, which is not repeated.
    pub closed: bool,
    /// Whether it is seen; else it is a hidden part.
    pub visible: bool,
    /// Its samples; silhouettes run with the front side on the left.
    pub samples: Vec<Sample>,
    /// Picture length up to each sample, pixels; for closed strokes one more, the whole.
    pub length: Vec<f64>,
    /// Texture parameter at each sample, rising along them; for closed strokes one more, at the
    /// first sample once round. Picture length until the film is parameterized.
    pub u: Vec<f64>,
    /// Once round in u, for closed strokes.
    pub u_period: Option<f64>,
    /// How many pixels a unit of u should measure in this frame.
    pub pixels_per_u: f64,
    /// The texture that it shows a part of: where lines merge and split and u goes on, so does this.
    /// Before the film is solved as a whole, none: its id stands for it.
    pub component: Option<u32>,
    /// After how much of u the texture begins anew: once round the closed lines of its component,
    /// whether this one is closed or not.
    pub repeats: Option<f64>,
    /// The line of its frame that it is a piece of since lines were cut, and whether that is closed: pieces follow
    /// each other, a pixel apart, and are drawn as one line with a texture for each.
    pub body: Option<(u32, bool)>,
    /// Whether a line that is drawn goes on past its start and past its end as another piece.
    pub goes_on: [bool; 2],
    /// The line that it is a part of in name alone, and whether that is closed: where lines of two ids
    /// merge, what they become is listed part after part.
    pub part: Option<(u32, bool)>,
}

impl Sample {
    /// The sample a share of the way to another one.
    pub fn toward(&self, other: &Self, t: f64) -> Self {
        let both = |p: Option<DVec2>, q: Option<DVec2>| p.zip(q).map(|(p, q)| p.lerp(q, t));
        // Past a chain's last element counting begins anew; on another chain it is another count.
        let goes_on = other.chain == self.chain && other.on_chain >= self.on_chain;
        let ahead = if goes_on { other.on_chain } else { self.on_chain };
        Self {
            at: self.at.lerp(other.at, t),
            depth: self.depth + (other.depth - self.depth) * t,
            world: self.world.lerp(other.world, t),
            next_world: self.next_world.zip(other.next_world).map(|(p, q)| p.lerp(q, t)),
            next_at: both(self.next_at, other.next_at),
            chain: self.chain,
            on_chain: self.on_chain + (ahead - self.on_chain) * t,
            normal: self.normal.lerp(other.normal, t).normalize_or_zero(),
            faces: self.faces,
        }
    }
}

impl Stroke {
    /// What its noise and marks go by: lines that have the same show one texture.
    pub fn texture(&self) -> u32 {
        self.component.unwrap_or(self.id)
    }

    /// After how much of u its texture begins anew: once round where it is closed, and where it is a part
    /// of lines that close, as often as those do.
    pub fn begins_anew(&self) -> Option<f64> {
        self.u_period.or(self.repeats)
    }

    /// A run of a path. `next_view` is the camera one frame later.
    pub fn of(path: &Path, run: Run, step: f64, view: &View, next_view: Option<&View>) -> Self {
        let n = path.segments.len() as f64;
        let closed = path.closed && run.end - run.start >= n;
        let places = places(path, run, step, closed);
        let sample = |place: &Place| sample(path, place.rem_euclid_end(n), view, next_view);
        let samples: Vec<Sample> = places.iter().filter_map(sample).collect();
        Self { chain: path.chain, ..Self::through(path.kind, closed, samples) }
    }

    /// A visible line through samples, of nothing that is known.
    pub fn through(kind: Kind, closed: bool, samples: Vec<Sample>) -> Self {
        let mut stroke = Self {
            id: 0,
            kind,
            chain: 0,
            owner: None,
            closed,
            visible: true,
            samples,
            length: Vec::new(),
            u: Vec::new(),
            u_period: None,
            pixels_per_u: 1.0,
            component: None,
            repeats: None,
            body: None,
            goes_on: [false; 2],
            part: None,
        };
        stroke.measure();
        stroke
    }

    /// A line of several parts: one after the other, with what is longest for its chain.
    pub fn of_line(
        paths: &[Path],
        line: &Line,
        step: f64,
        view: &View,
        next_view: Option<&View>,
    ) -> Self {
        let part = |(p, run): &(usize, Run)| Self::of(&paths[*p], *run, step, view, next_view);
        let mut parts: Vec<Self> = line.parts.iter().map(part).collect();
        if parts.len() == 1 && !line.closed {
            return parts.remove(0);
        }
        let longest = (0..parts.len())
            .max_by(|&a, &b| parts[a].total().total_cmp(&parts[b].total()).then(b.cmp(&a)));
        let mut stroke = Self {
            samples: Vec::new(),
            closed: line.closed,
            ..parts[longest.unwrap_or(0)].clone()
        };
        for part in parts {
            let apart = |s: &Sample| s.at.distance(part.samples[0].at) > TOUCHING;
            while stroke.samples.last().is_some_and(|s| !part.samples.is_empty() && !apart(s)) {
                stroke.samples.pop();
            }
            stroke.samples.extend(part.samples);
        }
        while stroke.closed
            && stroke.samples.len() > 3
            && stroke.samples[0].at.distance(stroke.samples[stroke.samples.len() - 1].at) < TOUCHING
        {
            stroke.samples.pop();
        }
        stroke.closed &= stroke.samples.len() > 2;
        stroke.measure();
        stroke
    }

    /// Measures it again after its samples changed; u is length from then on.
    pub fn measure(&mut self) {
        let s = &self.samples;
        let around = self.closed.then(|| s[s.len() - 1].at.distance(s[0].at));
        let steps = s.windows(2).map(|p| p[0].at.distance(p[1].at)).chain(around);
        let mut total = 0.0;
        self.length = std::iter::once(0.0)
            .chain(steps.map(|d| {
                total += d;
                total
            }))
            .collect();
        self.u = self.length.clone();
        self.u_period = self.closed.then_some(total);
    }

    /// Sets u (one value a sample, for closed strokes one more) in units of so many pixels.
    pub fn set_u(&mut self, u: Vec<f64>, pixels_per_u: f64) {
        assert!(u.len() == self.length.len(), "u has a value for every length");
        self.u_period = self.closed.then(|| u[u.len() - 1] - u[0]);
        self.u = u;
        self.pixels_per_u = pixels_per_u;
    }

    /// Its length in pixels.
    pub fn total(&self) -> f64 {
        self.length.last().copied().unwrap_or(0.0)
    }
}

/// Places on closed paths run past the last point.
trait Wrapped {
    fn rem_euclid_end(self, n: f64) -> f64;
}

impl Wrapped for f64 {
    fn rem_euclid_end(self, n: f64) -> f64 {
        if self > n { self - n } else { self }
    }
}

fn sample(path: &Path, place: Place, view: &View, next_view: Option<&View>) -> Option<Sample> {
    let point = path.point(place);
    let segment = (place.max(0.0) as usize).min(path.segments.len().saturating_sub(1));
    let seen = view.see(point.world)?;
    let next_at = point
        .next
        .zip(next_view)
        .and_then(|(p, v)| v.see(p).filter(|s| v.holds(s.at, 0.0)))
        .map(|s| s.at);
    Some(Sample {
        at: seen.at,
        depth: seen.depth,
        world: point.world,
        next_world: point.next,
        next_at,
        chain: path.chain,
        on_chain: point.on_chain,
        normal: (point.pushed - point.world).normalize_or_zero(),
        faces: path.segments.get(segment).map_or([NONE; 2], |s| s.own),
    })
}

/// Where the samples of a run stand: evenly between corners. The end of a closed run is left out.
fn places(path: &Path, run: Run, step: f64, closed: bool) -> Vec<Place> {
    let length = |p: Place| path.length_around(p);
    let (from, to) = (length(run.start), length(run.end));
    let at = |l: f64| path.place_around(l);
    let mut stops = vec![from];
    stops.extend(corners(path, run).into_iter().map(length));
    stops.push(to);
    let mut places = Vec::new();
    for pair in stops.windows(2).filter(|p| p[1] - p[0] > TOUCHING) {
        let count = ((pair[1] - pair[0]) / step).ceil().max(1.0);
        places.extend(
            (0..count as usize).map(|i| at(pair[0] + (pair[1] - pair[0]) * i as f64 / count)),
        );
    }
    if !closed || places.is_empty() {
        while places.last().is_some_and(|p| to - length(*p) < TOUCHING) && places.len() > 1 {
            places.pop();
        }
        places.push(run.end);
    }
    places
}

/// Points of a run where it turns sharply, rising.
fn corners(path: &Path, run: Run) -> Vec<Place> {
    let n = path.segments.len();
    let at = |k: usize| path.seen[k % n.max(1)].map(|s| s.at);
    let mut found: Vec<(Place, f64, f64)> = Vec::new();
    for k in run.start.floor() as usize + 1..run.end.ceil() as usize {
        let (Some(here), Some(a), Some(b)) = (
            at(k),
            reach(path, k, run.start.floor() as usize, false),
            reach(path, k, run.end.ceil() as usize, true),
        ) else {
            continue;
        };
        let turn = (here - a).angle_to(b - here).abs();
        if turn < CORNER {
            continue;
        }
        let length = if k > n { path.total() + path.length[k - n] } else { path.length[k] };
        match found.last_mut() {
            Some(last) if length - last.2 < REACH => {
                if turn > last.1 {
                    *last = (k as f64, turn, length);
                }
            }
            _ => found.push((k as f64, turn, length)),
        }
    }
    found.into_iter().map(|f| f.0).collect()
}

/// The first point at least [`REACH`] pixels from point `k`, towards `end`, or the last before.
fn reach(path: &Path, k: usize, end: usize, ahead: bool) -> Option<DVec2> {
    let n = path.segments.len();
    let at = |k: usize| path.seen[if k > n { k - n } else { k }].map(|s| s.at);
    let here = at(k)?;
    let mut last = None;
    let mut j = k;
    while j != end {
        j = if ahead { j + 1 } else { j - 1 };
        last = Some(at(j)?);
        if last?.distance(here) >= REACH {
            break;
        }
    }
    last
}
