//! Measures of a film's lines: the record's counts, rows L4 and L5.

use crate::film::{Film, FilmFrame};
use crate::overlap::overlap;
use crate::parameter::net::is_mere_end;
use crate::parameter::whole;
use crate::partner::Partner;
use crate::stroke::Stroke;
use crate::track::EventKind;
use chiaro_basis::math::DVec2;
use rayon::prelude::*;
use std::borrow::Cow;
use std::collections::BTreeMap;

/// A stroke below this length is short, pixels.
const SHORT: f64 = 10.0;
/// Another stroke must be nearer by this much to take a material point away, pixels.
const NEARER: f64 = 2.0;

/// What a film's lines amount to.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Measures {
    /// Frames.
    pub frames: usize,
    /// Ids.
    pub strokes: usize,
    /// Strokes a frame.
    pub strokes_per_frame: f64,
    /// Frames in which an id is seen, on average.
    pub mean_life_frames: f64,
    /// Births, deaths and saddles of silhouettes; a k-fold saddle counts k - 1 times.
    pub events: [u64; 3],
    /// Share of strokes under 10 pixels.
    pub short_strokes_share: f64,
    /// Share of the visible length whose material point finds its own id one frame later, no other
    /// stroke of its type nearer by 2 px; 1 where nothing has a next frame.
    pub one_to_one: f64,
    /// Share of the visible length that is still seen one frame later: whose partner ([`Film::partners`]) is on
    /// a stroke there. The rest is hidden, or becomes a line of another type.
    pub still_seen: f64,
    /// Of that, the share whose partner has its id.
    pub one_to_one_seen: f64,
    /// Ids that appear or vanish inside the film, a frame pair.
    pub id_changes: f64,
    /// Share of stretches whose visibility votes did not agree.
    pub split_share: f64,
    /// Share of the length that is drawn twice ([`crate::overlap`]).
    pub overlap: f64,
}

/// Measures a film.
pub fn measure(film: &Film) -> Measures {
    let strokes = film.frames.iter().map(|f| f.strokes.len()).sum::<usize>();
    let lines = film.frames.iter().map(|f| drawn_lines(&f.strokes)).sum::<usize>();
    let lives = lives(film);
    let last = film.frames.len().saturating_sub(1);
    let inside = |l: &[usize; 3]| usize::from(l[0] > 0) + usize::from(l[1] < last);
    let short = film.frames.iter().flat_map(|f| &f.strokes).filter(|s| s.total() < SHORT).count();
    let stretches =
        film.frames.iter().fold([0u64; 2], |a, f| [a[0] + f.stretches[0], a[1] + f.stretches[1]]);
    let share = |a: f64, b: f64| if b > 0.0 { a / b } else { 0.0 };
    let [still_seen, one_to_one_seen] = seen_again(film);
    Measures {
        frames: film.frames.len(),
        strokes: lives.len(),
        strokes_per_frame: share(lines as f64, film.frames.len() as f64),
        mean_life_frames: share(lives.values().map(|l| l[2] as f64).sum(), lives.len() as f64),
        events: events(film),
        short_strokes_share: share(short as f64, strokes as f64),
        one_to_one: one_to_one(film),
        still_seen,
        one_to_one_seen,
        id_changes: share(lives.values().map(|l| inside(l) as f64).sum(), last as f64),
        split_share: share(stretches[1] as f64, stretches[0] as f64),
        overlap: doubled(film),
    }
}

/// How many lines a list of strokes is drawn as: parts and pieces of one are one.
fn drawn_lines(strokes: &[Stroke]) -> usize {
    let one = |a: Option<(u32, bool)>, b| a.is_some() && a == b;
    strokes.chunk_by(|a, b| one(a.part, b.part) || one(a.body, b.body)).count()
}

/// Of each id: the first and the last frame in which it is seen, and in how many.
fn lives(film: &Film) -> BTreeMap<u32, [usize; 3]> {
    let mut lives: BTreeMap<u32, [usize; 3]> = BTreeMap::new();
    for (i, frame) in film.frames.iter().enumerate() {
        for s in &frame.strokes {
            let life = lives.entry(s.id).or_insert([i, i, 1]);
            // Its parts in one frame are one.
            life[2] += usize::from(life[1] < i);
            life[1] = i;
        }
    }
    lives
}

impl Measures {
    /// Names and values for records.
    pub fn named(&self) -> Vec<(&'static str, f64)> {
        vec![
            ("frames", self.frames as f64),
            ("strokes", self.strokes as f64),
            ("strokes_per_frame", self.strokes_per_frame),
            ("mean_life_frames", self.mean_life_frames),
            ("births", self.events[0] as f64),
            ("deaths", self.events[1] as f64),
            ("saddles", self.events[2] as f64),
            ("short_strokes_share", self.short_strokes_share),
            ("one_to_one_share", self.one_to_one),
            ("still_seen_share", self.still_seen),
            ("one_to_one_seen_share", self.one_to_one_seen),
            ("id_changes_per_frame", self.id_changes),
            ("split_stretches_share", self.split_share),
            ("overlap_share", self.overlap),
        ]
    }
}

/// Share of the length of lines, as they are drawn, that is drawn twice.
fn doubled(film: &Film) -> f64 {
    let lengths: Vec<[f64; 2]> = film
        .frames
        .par_iter()
        .map(|frame| {
            let lines: Vec<Stroke> =
                whole(&frame.strokes).into_iter().map(Cow::into_owned).collect();
            [overlap(&lines), lines.iter().map(Stroke::total).sum()]
        })
        .collect();
    let [doubled, all] = lengths.iter().fold([0.0; 2], |a, l| [a[0] + l[0], a[1] + l[1]]);
    if all > 0.0 { doubled / all } else { 0.0 }
}

fn events(film: &Film) -> [u64; 3] {
    let mut counts = [0; 3];
    for event in &film.events {
        match event.kind {
            EventKind::Birth => counts[0] += 1,
            EventKind::Death => counts[1] += 1,
            EventKind::Saddle => counts[2] += u64::from(event.arcs.max(2) - 1),
        }
    }
    counts
}

fn one_to_one(film: &Film) -> f64 {
    let pairs = film.frames.par_windows(2).filter(|p| !p[1].begins);
    let sums: Vec<[f64; 2]> = pairs.map(|p| kept_between(&p[0], &p[1])).collect();
    let [found, all] = sums.iter().fold([0.0; 2], |a, s| [a[0] + s[0], a[1] + s[1]]);
    if all > 0.0 { found / all } else { 1.0 }
}

/// The share of length that is seen one frame later, and of that the share that has its id there; 1 where nothing
/// has a next frame.
fn seen_again(film: &Film) -> [f64; 2] {
    let sums: Vec<[f64; 3]> = (0..film.frames.len().saturating_sub(1))
        .into_par_iter()
        .filter(|f| !film.frames[f + 1].begins)
        .map(|f| seen_between(&film.frames[f], &film.frames[f + 1], &film.partners(f)))
        .collect();
    let add = |a: [f64; 3], s: &[f64; 3]| [a[0] + s[0], a[1] + s[1], a[2] + s[2]];
    let [all, seen, kept] = sums.iter().fold([0.0; 3], add);
    let share = |a: f64, b: f64| if b > 0.0 { a / b } else { 1.0 };
    [share(seen, all), share(kept, seen)]
}

/// Length of a frame's strokes whose material point stays in the picture, of that what is seen in the next, and
/// of that what has the same id there.
fn seen_between(here: &FilmFrame, next: &FilmFrame, partners: &[Vec<Option<Partner>>]) -> [f64; 3] {
    let mut sums = [0.0; 3];
    for (stroke, partners) in here.strokes.iter().zip(partners) {
        let weight = stroke.total() / stroke.samples.len() as f64;
        for (_, partner) in stroke.samples.iter().zip(partners).filter(|s| s.0.next_at.is_some()) {
            sums[0] += weight;
            let Some(partner) = partner else { continue };
            let other = &next.strokes[partner.stroke as usize];
            if !is_mere_end(partner, other) {
                sums[1] += weight;
                sums[2] += if other.id == stroke.id { weight } else { 0.0 };
            }
        }
    }
    sums
}

/// Length of a frame's strokes that finds its own id in the next, and that has a next frame at all.
fn kept_between(here: &FilmFrame, next: &FilmFrame) -> [f64; 2] {
    let there: Vec<Boxed<'_>> = next.strokes.iter().map(Boxed::of).collect();
    let mut by_id: BTreeMap<u32, Vec<usize>> = BTreeMap::new();
    there.iter().enumerate().for_each(|(i, b)| by_id.entry(b.stroke.id).or_default().push(i));
    let mut sums = [0.0; 2];
    for stroke in &here.strokes {
        let weight = stroke.total() / stroke.samples.len() as f64;
        let own: Vec<&Boxed<'_>> = by_id
            .get(&stroke.id)
            .into_iter()
            .flatten()
            .map(|i| &there[*i])
            .filter(|b| b.stroke.kind == stroke.kind)
            .collect();
        for at in stroke.samples.iter().filter_map(|s| s.next_at) {
            sums[1] += weight;
            let away = own.iter().fold(f64::INFINITY, |d, b| b.nearer(at, d));
            if away.is_finite() && !is_taken(stroke, at, away - NEARER, &there) {
                sums[0] += weight;
            }
        }
    }
    sums
}

/// Whether another stroke of its type lies within a distance of a material point.
fn is_taken(stroke: &Stroke, at: DVec2, within: f64, there: &[Boxed<'_>]) -> bool {
    within >= 0.0
        && there
            .iter()
            .filter(|b| b.stroke.kind == stroke.kind && b.stroke.id != stroke.id)
            .any(|b| b.away(at) <= within && distance(b.stroke, at) <= within)
}

/// A stroke and the box around it, by which most strokes are known to be too far away.
struct Boxed<'a> {
    stroke: &'a Stroke,
    low: DVec2,
    high: DVec2,
}

impl<'a> Boxed<'a> {
    fn of(stroke: &'a Stroke) -> Self {
        let (mut low, mut high) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
        for s in &stroke.samples {
            (low, high) = (low.min(s.at), high.max(s.at));
        }
        Self { stroke, low, high }
    }

    /// A place's distance from the box.
    fn away(&self, at: DVec2) -> f64 {
        (self.low - at).max(at - self.high).max(DVec2::ZERO).length()
    }

    /// The stroke's distance, if it is less than `least`, which is the answer else.
    fn nearer(&self, at: DVec2, least: f64) -> f64 {
        if self.away(at) < least { distance(self.stroke, at).min(least) } else { least }
    }
}

/// Distance of a picture position from a stroke.
pub fn distance(stroke: &Stroke, at: DVec2) -> f64 {
    let s = &stroke.samples;
    let around = stroke.closed.then(|| (s[s.len() - 1].at, s[0].at));
    let segments = s.windows(2).map(|p| (p[0].at, p[1].at)).chain(around);
    segments.map(|(a, b)| to_segment(at, a, b)).fold(f64::INFINITY, f64::min)
}

fn to_segment(p: DVec2, a: DVec2, b: DVec2) -> f64 {
    let d = b - a;
    let t = ((p - a).dot(d) / d.length_squared()).clamp(0.0, 1.0);
    p.distance(if t.is_finite() { a + d * t } else { a })
}
