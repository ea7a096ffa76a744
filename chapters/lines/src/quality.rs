//! How well u keeps its promise: sliding, jumps, stretch and folds, rows L1 to L3.
//!
//! Measured from strokes alone, by the place of each sample's material point one frame later, so
//! that every method is judged alike. Sliding and stretch belong together: one is had for the other.

use crate::film::{Film, FilmFrame};
use crate::gap::{Between, between};
use crate::parameter::near::Near;
use crate::parameter::net::{AGREES, DEPTH, REACH, direction, goes_on, is_mere_end, material};
use crate::path::Kind;
use crate::stroke::Stroke;
use rayon::prelude::*;
use std::collections::BTreeMap;

/// Sliding by more than this is seen, pixels.
const SEEN: f64 = 2.0;
/// Sliding by more than this is a jump, pixels.
const JUMP: f64 = 8.0;
/// The frame pair is broken when this share of its lines jumps.
const BROKEN: f64 = 0.2;
/// What counts as going round.
const LEAST_PERIOD: f64 = 1e-6;
/// Pixels by which another stroke must be nearer to take a material point away.
const NEARER: f64 = 2.0;

/// Share of an id's length that other ids must go on with for its end to be untrue.
const HANDED: f64 = 0.5;

/// The pattern by which pops are measured, pixels.
const PATTERN: f64 = 24.0;

/// How well a film is parameterized.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Quality {
    /// 95th percentile of sliding at visible material points, pixels a frame.
    pub slide_p95: f64,
    /// Share of length that slides by more than 2 px.
    pub slide_over_2: f64,
    /// Share of length that slides by more than 8 px or finds another id.
    pub jumps: f64,
    /// Share of length that slides by more than 8 px or finds another texture: where lines merge, split,
    /// open and close, noise and marks go on under another id.
    pub texture_jumps: f64,
    /// Of the length whose line is still seen a frame later, by its partner along the surface that lines sweep
    /// ([`Film::partners`]): the share that slides by more than 8 px there, or has another id though its line neither
    /// joined another nor came off one. The others ask what is nearest, be it another line that passes there.
    pub line_jumps: f64,
    /// Share of frame pairs of which a fifth jumps.
    pub broken_pairs: f64,
    /// 95th percentile of what u misses where a line goes on behind what hides it: beside an even texture
    /// along what is hidden, whole turns of the texture left out, pixels. The seam of a line that closes is no miss.
    pub gap_p95: f64,
    /// 99th percentile over frame pairs of the longest stretch of line that turns from ink to paper or
    /// back along the motion, where half of every 24 pixels of u is ink: what is seen of
    /// jumps and sliding at once, pixels.
    pub ink_pop_p99: f64,
    /// 95th percentile of |log2 (du / ds)| where u rises, in octaves.
    pub stretch_p95: f64,
    /// Share of length on which u does not rise: what the stretch above leaves out.
    pub folded: f64,
    /// Segments on which u does not rise.
    pub folds: usize,
    /// Share of length that goes on under another id.
    pub renamed: f64,
    /// Ids, a frame pair, that begin where most of their line was seen the frame before under other ids,
    /// or end where most of it is seen under others the frame after: births and deaths that are no events.
    /// Where lines of the surface merge one of two ids ends, where one splits one begins: these are events.
    pub untrue_changes: f64,
}

/// A sample whose material point meets a line.
#[derive(Clone, Copy)]
struct Slide {
    pixels: f64,
    keeps_id: bool,
    keeps_texture: bool,
    /// The length that it stands for, pixels.
    length: f64,
}

/// Share of length that jumps, where `keeps` tells what must stay.
fn jumping<'a>(slides: impl Iterator<Item = &'a Slide>, keeps: impl Fn(&Slide) -> bool) -> f64 {
    share(slides.map(|s| (s.length, s.pixels > JUMP || !keeps(s))))
}

/// What is found between two frames.
#[derive(Default)]
struct Pair {
    slides: Vec<Slide>,
    /// Length that goes on along its own line, and whether it jumps.
    own: Vec<(f64, bool)>,
    /// The longest stretch of line that turns from ink to paper or back.
    pop: f64,
    /// For each id before and after, the length that is seen.
    seen: [BTreeMap<u32, f64>; 2],
    /// The length that goes on, by what it goes on as.
    flows: BTreeMap<Flow, f64>,
}

/// What goes on as what: before and after.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Flow {
    ids: [u32; 2],
    /// Strokes, all parts of one that is parted in name being the same.
    strokes: [u32; 2],
    /// Lines of the surface ([`Film::line_of`]).
    lines: [u32; 2],
    /// Whether the line is made of edges, which neither merge nor split.
    is_edge: bool,
}

impl Flow {
    /// Of a stroke of a frame and one of the next, by index.
    fn of(film: &Film, frames: [&FilmFrame; 2], index: [u32; 2]) -> Self {
        let strokes = [0, 1].map(|k| &frames[k].strokes[index[k] as usize]);
        Self {
            ids: strokes.map(|s| s.id),
            strokes: [0, 1].map(|k| whole(strokes[k], index[k])),
            lines: [0, 1].map(|k| film.line_of(frames[k], strokes[k])),
            is_edge: strokes[0].kind.is_edge(),
        }
    }

    /// Whether it joins a line that goes on under its own id, or comes off one, on the surface and not by what
    /// passes before it: an end, or a beginning, that is an event. What is seen of the line that they share may be
    /// several strokes.
    fn is_event(&self, flows: &BTreeMap<Self, f64>, beginning: bool) -> bool {
        let [stroke, line] = if beginning { [0, 1] } else { [1, 0] };
        let other = self.ids[1 - line];
        !self.is_edge
            && flows.keys().any(|f| {
                f.ids == [other; 2]
                    && (f.strokes[stroke] == self.strokes[stroke]
                        || f.lines[stroke] == self.lines[stroke])
                    && f.lines[line] != self.lines[line]
            })
    }
}

/// Measures the seen strokes of a film.
pub fn quality(film: &Film) -> Quality {
    let windows = film.frames.par_windows(2).enumerate().filter(|(_, p)| !p[1].begins);
    let found = windows.map(|(f, p)| {
        let found = pair(film, [&p[0], &p[1]]);
        Pair { own: own_slides(film, f), ..found }
    });
    let pairs: Vec<Pair> = found.collect();
    let is_broken = |p: &&Pair| jumping(p.slides.iter(), |s| s.keeps_id) >= BROKEN;
    let broken = pairs.iter().filter(is_broken).count();
    let all = || pairs.iter().flat_map(|p| &p.slides);
    let strokes = || film.frames.iter().flat_map(|f| &f.strokes);
    let slopes: Vec<(f64, f64)> = strokes().flat_map(slopes).collect();
    let rising = slopes.iter().filter(|s| s.0 > 0.0);
    Quality {
        slide_p95: percentile(all().map(|s| (s.pixels, s.length)).collect(), 0.95),
        slide_over_2: share(all().map(|s| (s.length, s.pixels > SEEN))),
        jumps: jumping(all(), |s| s.keeps_id),
        texture_jumps: jumping(all(), |s| s.keeps_texture),
        line_jumps: share(pairs.iter().flat_map(|p| p.own.iter().copied())),
        gap_p95: percentile(film.frames.iter().flat_map(gaps).map(|g| (g, 1.0)).collect(), 0.95),
        ink_pop_p99: percentile(pairs.iter().map(|p| (p.pop, 1.0)).collect(), 0.99),
        broken_pairs: if pairs.is_empty() { 0.0 } else { broken as f64 / pairs.len() as f64 },
        stretch_p95: percentile(rising.map(|s| (s.0.log2().abs(), s.1)).collect(), 0.95),
        folded: share(slopes.iter().map(|s| (s.1, s.0 <= 0.0))),
        folds: slopes.iter().filter(|s| s.0 <= 0.0).count(),
        renamed: share(all().map(|s| (s.length, !s.keeps_id))),
        untrue_changes: untrue_changes(&pairs) as f64 / pairs.len().max(1) as f64,
    }
}

/// Ids that begin or end between two frames though their line was there before, or is there after, and neither
/// came off another line nor joined one.
fn untrue_changes(pairs: &[Pair]) -> usize {
    let of = |p: &Pair| {
        let changes = |side: usize| {
            let ids = p.seen[side].iter().filter(|(id, _)| !p.seen[1 - side].contains_key(id));
            let untrue = |id: u32| {
                let own = p.flows.iter().filter(|(f, _)| f.ids[side] == id);
                own.filter(|(f, _)| !f.is_event(&p.flows, side == 1)).map(|f| f.1).sum::<f64>()
            };
            ids.filter(|(id, seen)| untrue(**id) > HANDED * **seen).count()
        };
        changes(0) + changes(1)
    };
    pairs.iter().map(of).sum()
}

/// Sliding of every sample whose material point meets a line of its kind.
fn pair(film: &Film, [here, next]: [&FilmFrame; 2]) -> Pair {
    let there: Vec<&Stroke> = next.strokes.iter().collect();
    let near = Near::of(there.iter().copied(), &next.view);
    let mut pair = Pair::default();
    for (strokes, seen) in [&here.strokes, &next.strokes].into_iter().zip(&mut pair.seen) {
        strokes.iter().for_each(|s| *seen.entry(s.id).or_default() += s.total());
    }
    for (i, stroke) in (0..).zip(&here.strokes) {
        let weight = stroke.total() / stroke.samples.len() as f64;
        let mut run = 0.0;
        for j in 0..stroke.samples.len() {
            let Some((at, depth)) = material(stroke, j, next) else { continue };
            let along = direction(stroke, j);
            let deep = DEPTH * next.view.size.1 as f64 * next.view.pixel(depth);
            let hit = near.nearest(at, REACH, |hit| {
                let other = there[hit.segment.stroke as usize];
                // Past a cusp the line comes back over itself the other way, and what passes before
                // a point or behind it is no place for it to be.
                let fits = goes_on(stroke, j, other, hit)
                    && hit.segment.direction().dot(along) > AGREES
                    && (hit.segment.depth(hit.share) - depth).abs() < deep;
                fits.then_some(if other.id == stroke.id { 0.0 } else { NEARER })
            });
            // Beyond a stroke's end there is nothing to slide on.
            let Some(hit) = hit.filter(|h| h.beyond == 0.0) else { continue };
            let other = there[hit.segment.stroke as usize];
            let k = hit.segment.first as usize;
            let du = moved([stroke, other], j, (k, hit.share));
            let flow = Flow::of(film, [here, next], [i, hit.segment.stroke]);
            *pair.flows.entry(flow).or_default() += weight;
            let scale = 0.5 * (stroke.pixels_per_u + other.pixels_per_u);
            pair.slides.push(Slide {
                pixels: scale * du.abs(),
                keeps_id: other.id == stroke.id,
                keeps_texture: other.texture() == stroke.texture(),
                length: weight,
            });
            let ink = |u: f64| (scale * u / PATTERN).rem_euclid(1.0) < 0.5;
            // Whole turns of a loop are no change.
            run = if ink(stroke.u[j]) == ink(stroke.u[j] + du) { 0.0 } else { run + weight };
            pair.pop = pair.pop.max(run);
        }
    }
    pair
}

/// How u at a place of a stroke, a segment and a share of it, differs from u at a sample of the one before; whole
/// turns of the texture of either are no difference.
fn moved([stroke, other]: [&Stroke; 2], j: usize, (k, share): (usize, f64)) -> f64 {
    let du = other.u[k] + (other.u[k + 1] - other.u[k]) * share - stroke.u[j];
    let periods = [stroke, other].into_iter().filter_map(Stroke::begins_anew);
    let rests =
        periods.filter(|p| *p > LEAST_PERIOD).map(|period| du - (du / period).round() * period);
    rests.fold(du, |least, rest| if rest.abs() < least.abs() { rest } else { least })
}

/// The length of a frame whose line is seen in the next, sample by sample, and whether it jumps there.
fn own_slides(film: &Film, f: usize) -> Vec<(f64, bool)> {
    let (here, next) = (&film.frames[f], &film.frames[f + 1]);
    let (mut slides, mut flows) = (Vec::new(), BTreeMap::new());
    for (i, (stroke, partners)) in (0..).zip(here.strokes.iter().zip(film.partners(f))) {
        let weight = stroke.total() / stroke.samples.len() as f64;
        for (j, partner) in partners.into_iter().enumerate() {
            let Some(partner) = partner.filter(|p| p.distance <= REACH) else { continue };
            let other = &next.strokes[partner.stroke as usize];
            let k = partner.segment as usize;
            let way = other.samples[(k + 1) % other.samples.len()].at - other.samples[k].at;
            // Where one side of a thorn is left out the other is no place to be.
            let goes_on = way.normalize_or_zero().dot(direction(stroke, j)) > AGREES;
            if !goes_on || is_mere_end(&partner, other) {
                continue;
            }
            let du = moved([stroke, other], j, (k, partner.share));
            let pixels = 0.5 * (stroke.pixels_per_u + other.pixels_per_u) * du.abs();
            let flow = Flow::of(film, [here, next], [i, partner.stroke]);
            *flows.entry(flow).or_default() += weight;
            slides.push((weight, pixels > JUMP, flow));
        }
    }
    let renamed = |flow: &Flow| {
        flow.ids[0] != flow.ids[1] && ![false, true].iter().any(|b| flow.is_event(&flows, *b))
    };
    slides.iter().map(|(weight, jumps, flow)| (*weight, *jumps || renamed(flow))).collect()
}

/// What u misses at each gap of a frame, pixels. A line that closes has its seam at one of its gaps: that whose miss
/// is nearest to once round, and over half of it.
fn gaps(frame: &FilmFrame) -> Vec<f64> {
    let mut misses = Vec::new();
    let mut seams: BTreeMap<(Kind, u32), (f64, usize)> = BTreeMap::new();
    for Between { strokes, length, around } in between(frame.strokes.iter(), &frame.gaps) {
        let [a, b] = strokes.map(|s| &frame.strokes[s]);
        let off = b.u[0] - a.u[a.u.len() - 1] - length / b.pixels_per_u;
        let period = a.begins_anew().or(b.begins_anew()).filter(|p| *p > LEAST_PERIOD);
        let miss = b.pixels_per_u * (off - period.map_or(0.0, |p| (off / p).round() * p)).abs();
        if let Some(around) = around.filter(|around| miss > 0.5 * around) {
            let own = ((miss - around).abs(), misses.len());
            let seam = seams.entry((a.kind, b.samples[0].chain)).or_insert(own);
            *seam = if own.0 < seam.0 { own } else { *seam };
        }
        misses.push(miss);
    }
    seams.into_values().for_each(|(_, gap)| misses[gap] = 0.0);
    misses
}

/// A number for a stroke of a frame that the parts of one line share.
fn whole(stroke: &Stroke, index: u32) -> u32 {
    stroke.part.map_or(2 * index, |(line, _)| 2 * line + 1)
}

/// L du / ds and ds of each segment.
fn slopes(stroke: &Stroke) -> Vec<(f64, f64)> {
    let pairs = stroke.u.windows(2).zip(stroke.length.windows(2));
    let slope = |(u, l): (&[f64], &[f64])| {
        let ds = (l[1] - l[0]).max(1e-9);
        (stroke.pixels_per_u * (u[1] - u[0]) / ds, ds)
    };
    pairs.map(slope).collect()
}

/// The share of a weight for which something holds.
fn share(items: impl Iterator<Item = (f64, bool)>) -> f64 {
    let (mut some, mut all) = (0.0, 0.0);
    for (weight, holds) in items {
        all += weight;
        some += if holds { weight } else { 0.0 };
    }
    if all > 0.0 { some / all } else { 0.0 }
}

/// The value below which a share of the weight lies.
fn percentile(mut items: Vec<(f64, f64)>, at: f64) -> f64 {
    items.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
    let whole: f64 = items.iter().map(|i| i.1).sum();
    let mut sum = 0.0;
    for (value, weight) in &items {
        sum += weight;
        if sum >= at * whole {
            return *value;
        }
    }
    0.0
}

impl Quality {
    /// Names and values for records.
    pub fn named(&self) -> [(&'static str, f64); 13] {
        [
            ("slide_p95_px", self.slide_p95),
            ("slide_over_2px", self.slide_over_2),
            ("jump_share", self.jumps),
            ("texture_jump_share", self.texture_jumps),
            ("line_jump_share", self.line_jumps),
            ("broken_pairs_share", self.broken_pairs),
            ("gap_p95_px", self.gap_p95),
            ("ink_pop_p99_px", self.ink_pop_p99),
            ("stretch_p95_octaves", self.stretch_p95),
            ("folded_share", self.folded),
            ("folds", self.folds as f64),
            ("renamed_share", self.renamed),
            ("untrue_id_changes_per_frame", self.untrue_changes),
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn merges_and_splits_are_events_and_other_names_are_none() {
        let flow = |ids, strokes, lines| Flow { ids, strokes, lines, is_edge: false };
        let seen = |ids: &[u32]| ids.iter().map(|id| (*id, 30.0)).collect::<BTreeMap<_, _>>();
        let pair = |before: &[u32], after: &[u32], flows: &[Flow]| Pair {
            seen: [seen(before), seen(after)],
            flows: flows.iter().map(|f| (*f, 30.0)).collect(),
            ..Pair::default()
        };
        // Two lines of the surface become one: one of two ids must end.
        let merge = [flow([1, 1], [0, 0], [5, 5]), flow([2, 1], [2, 0], [6, 5])];
        assert_eq!(untrue_changes(&[pair(&[1, 2], &[1], &merge)]), 0);
        // What is seen of that one are two strokes.
        let hidden = [merge[0], Flow { strokes: [2, 1], ..merge[1] }];
        let joined = hidden.map(|f| Flow { lines: [f.lines[0], 5], ..f });
        assert_eq!(untrue_changes(&[pair(&[1, 2], &[1], &joined)]), 0);
        let apart = hidden.map(|f| Flow { lines: [f.lines[0]; 2], ..f });
        assert_eq!(untrue_changes(&[pair(&[1, 2], &[1], &apart)]), 1);
        // One becomes two.
        let split = [flow([1, 1], [0, 0], [5, 5]), flow([1, 2], [0, 2], [5, 6])];
        assert_eq!(untrue_changes(&[pair(&[1], &[1, 2], &split)]), 0);
        // One line of the surface that something passes before, and one that is named anew.
        let parted = split.map(|f| Flow { lines: [5, 5], ..f });
        assert_eq!(untrue_changes(&[pair(&[1], &[1, 2], &parted)]), 1);
        assert_eq!(untrue_changes(&[pair(&[1], &[2], &[flow([1, 2], [0, 0], [5, 5])])]), 2);
        // Edges of the mesh neither merge nor split.
        let edges = merge.map(|f| Flow { is_edge: true, ..f });
        assert_eq!(untrue_changes(&[pair(&[1, 2], &[1], &edges)]), 1);
    }
}
