//! [`Film::partners`]: the correspondence of section 4.6.2, from each sample of a frame to a point of
//! a segment of the next frame.
//!
//! 1. Along S a sample's crossings become crossings of one chain of the next slice: this is the
//!    region that its line swept, and tells the chain and whereabouts on it.
//! 2. Of the segments there, the one nearest in the picture to where the sample's material point has
//!    moved holds the partner: two samples with weights 1 - b and b, as (4.7) wants.
//!
//! Edge lines stay on their edges. Terminators and suggestive contours have their own S, the crossings of
//! ridges, valleys and apparent ridges become those nearest to where they have moved ([`Further`]).
//! Where pieces pass through each other, and on meshes made anew, the nearest segment of the next
//! frame holds the partner: there of lines of the kind, here of the stroke's id, from where the sample is.

use crate::film::{Film, FilmFrame};
use crate::further::Further;
use crate::path::Kind;
use crate::slice::Slice;
use crate::stroke::{Sample, Stroke};
use crate::surface::NONE;
use chiaro_basis::math::DVec2;
use std::collections::HashMap;

/// Crossings beside those that S gives among which the nearest is sought.
const AROUND: f64 = 6.0;
/// Where nothing tells whereabouts, the nearest segment may be so far away, pixels.
const REACH: f64 = 12.0;

/// A point of a segment of a stroke of the next frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Partner {
    /// Index of the stroke in its frame.
    pub stroke: u32,
    /// Index of the sample before the point.
    pub segment: u32,
    /// b: 0 at that sample, 1 at the next (the first one after the last of a closed stroke).
    pub share: f64,
    /// Distance in the picture from where the material point has moved, pixels.
    pub distance: f64,
}

impl Film {
    /// For each stroke of a frame and each of its samples, the partner in the next frame; `None`
    /// where there is no next frame, where the material point leaves the picture, and where what the
    /// sample becomes is hidden.
    pub fn partners(&self, frame: usize) -> Vec<Vec<Option<Partner>>> {
        let here = &self.frames[frame];
        let next = self.frames.get(frame + 1).filter(|n| !n.begins);
        let Some(next) = next else {
            return here.strokes.iter().map(|s| vec![None; s.samples.len()]).collect();
        };
        let remade = self.surface.is_none();
        let pair = Pair { here, next, targets: Targets::of(next), remade };
        let of = |s: &Stroke| s.samples.iter().map(|p| pair.partner(s, p)).collect();
        here.strokes.iter().map(of).collect()
    }
}

/// The strokes of a frame by kind and chain.
struct Targets(HashMap<(Kind, u32), Vec<u32>>);

impl Targets {
    fn of(frame: &FilmFrame) -> Self {
        let mut map: HashMap<(Kind, u32), Vec<u32>> = HashMap::new();
        for (i, s) in frame.strokes.iter().enumerate() {
            let mut chains: Vec<u32> = s.samples.iter().map(|p| p.chain).collect();
            chains.sort_unstable();
            chains.dedup();
            for chain in chains {
                map.entry((s.kind, chain)).or_default().push(i as u32);
            }
        }
        Self(map)
    }
}

/// Where on which chain of the next frame to look: a middle, a reach, and the chain's crossings if
/// it is closed.
struct Window {
    chain: u32,
    middle: f64,
    reach: f64,
    around: Option<f64>,
}

/// A frame and the next one, with the strokes of that.
struct Pair<'a> {
    here: &'a FilmFrame,
    next: &'a FilmFrame,
    targets: Targets,
    /// Whether meshes are made anew: then nothing tells where a sample moves.
    remade: bool,
}

impl Pair<'_> {
    fn partner(&self, stroke: &Stroke, sample: &Sample) -> Option<Partner> {
        let (at, window) = match self.remade {
            true => (sample.at, None),
            false if stroke.kind.is_voted() => (sample.next_at?, None),
            false => (sample.next_at?, Some(self.window(stroke, sample)?)),
        };
        match window {
            Some(window) => {
                let strokes = self.targets.0.get(&(stroke.kind, window.chain))?;
                let holds = |s: &Sample| s.chain == window.chain && window.holds(s.on_chain);
                self.nearest(at, strokes.iter().copied(), holds)
            }
            None => {
                let strokes = (0..)
                    .zip(&self.next.strokes)
                    .filter(|(_, s)| s.kind == stroke.kind && (!self.remade || s.id == stroke.id));
                let near = |p: Partner| p.distance <= REACH;
                self.nearest(at, strokes.map(|s| s.0), |_| true).filter(|p| near(*p))
            }
        }
    }

    /// Whereabouts on which chain of the next frame a sample is then.
    fn window(&self, stroke: &Stroke, sample: &Sample) -> Option<Window> {
        let (here, next) = (self.here, self.next);
        let of = |f: &&Further| f.kind == stroke.kind;
        let (slices, forward) = match stroke.kind {
            Kind::Silhouette => ([&here.slice, &next.slice], &here.interval.forward),
            kind if kind.is_edge() => {
                let (chain, middle) = (sample.chain, sample.on_chain);
                return Some(Window { chain, middle, reach: 1.0, around: None });
            }
            _ => {
                let [a, b] = [here, next].map(|f| f.further.iter().find(of));
                ([&a?.slice, &b?.slice], &a?.forward)
            }
        };
        along_s(slices, forward, sample.chain, sample.on_chain)
    }

    /// The nearest place on segments of strokes of which an end is held.
    fn nearest(
        &self,
        at: DVec2,
        strokes: impl Iterator<Item = u32>,
        holds: impl Fn(&Sample) -> bool,
    ) -> Option<Partner> {
        let mut best: Option<Partner> = None;
        for index in strokes {
            let stroke = &self.next.strokes[index as usize];
            let mut is_held = stroke.samples.first().is_some_and(&holds);
            for (k, a, b) in segments(stroke) {
                let was_held = std::mem::replace(&mut is_held, holds(b));
                if !was_held && !is_held {
                    continue;
                }
                let (share, distance) = nearest(at, a.at, b.at);
                if best.is_none_or(|b| distance < b.distance) {
                    best = Some(Partner { stroke: index, segment: k, share, distance });
                }
            }
        }
        best
    }
}

impl Window {
    fn holds(&self, place: f64) -> bool {
        let d = (place - self.middle).abs();
        self.around.map_or(d, |n| d.min((n - d).abs())) <= self.reach
    }
}

/// Where the crossings beside a place on a chain are one frame later.
fn along_s([here, next]: [&Slice; 2], forward: &[u32], chain: u32, place: f64) -> Option<Window> {
    let chain = here.chains[chain as usize];
    let n = chain.count as usize;
    let k = (place.max(0.0) as usize).min(n - 1);
    let after = if k + 1 < n || !chain.closed { (k + 1).min(n - 1) } else { 0 };
    let forward = |k: usize| forward.get(chain.start as usize + k).copied();
    let known = |k: usize| forward(k).filter(|j| *j != NONE);
    let (a, b) = match (known(k), known(after)) {
        (Some(a), Some(b)) => (a, b),
        (Some(a), None) | (None, Some(a)) => (a, a),
        (None, None) => return None,
    };
    let index = next.chains.partition_point(|c| c.start <= a).checked_sub(1)?;
    let c = &next.chains[index];
    let local = |j: u32| f64::from(j) - f64::from(c.start);
    let (a, b) = (local(a), local(b));
    let around = c.closed.then_some(f64::from(c.count));
    // The second may be on another chain, or across the first point of this one.
    let gap = if b >= 0.0 && b < f64::from(c.count) { (b - a).abs() } else { 0.0 };
    let wraps = around.is_some_and(|n| gap > 0.5 * n);
    let (middle, gap) = if wraps { (a, 1.0) } else { (a + 0.5 * (b - a), gap) };
    let middle = if b >= 0.0 && b < f64::from(c.count) { middle } else { a };
    Some(Window { chain: index as u32, middle, reach: 0.5 * gap + AROUND, around })
}

/// The segments of a stroke: index of the first sample, and both.
fn segments(stroke: &Stroke) -> impl Iterator<Item = (u32, &Sample, &Sample)> {
    let s = &stroke.samples;
    let around = stroke.closed.then(|| (s.len() as u32 - 1, &s[s.len() - 1], &s[0]));
    s.windows(2).zip(0..).map(|(p, k)| (k, &p[0], &p[1])).chain(around)
}

/// The nearest point of a segment, as a share of it, and its distance.
fn nearest(p: DVec2, a: DVec2, b: DVec2) -> (f64, f64) {
    let d = b - a;
    let t = ((p - a).dot(d) / d.length_squared()).clamp(0.0, 1.0);
    let t = if t.is_finite() { t } else { 0.0 };
    (t, p.distance(a + d * t))
}
