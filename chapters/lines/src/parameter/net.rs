//! [`Net`]: the unknowns of a film, its lines as they stand in it, and the links between frames.
//!
//! One unknown a sample. A link joins a sample to the place where its material point is one frame
//! later (4.7): moved with its face, projected by the next frame's camera, to the nearest segment
//! there that runs the same way at about the same depth.

use super::near::{Hit, Near};
use crate::film::{Film, FilmFrame};
use crate::partner::Partner;
use crate::stroke::Stroke;
use chiaro_basis::math::DVec2;
use rayon::prelude::*;
use std::collections::BTreeMap;

/// A material point finds its line within this distance, pixels.
pub(crate) const REACH: f64 = 8.0;
/// Cosine of the largest angle between a line and where it goes.
pub(crate) const AGREES: f64 = 0.5;
/// Parts of the picture's height by which a contour may leave its material point in depth.
pub(crate) const DEPTH: f64 = 0.04;
/// Pixels that another id seems further away.
const OTHER_ID: f64 = 2.0;
/// A stroke's end meets another's within this distance, pixels.
const END_MEETS_END: f64 = 1.0;

/// A stroke of the film.
#[derive(Clone, Debug)]
pub(crate) struct Line {
    /// Its frame.
    pub(crate) frame: u32,
    /// Its first unknown.
    pub(crate) first: u32,
    /// How many samples.
    pub(crate) count: u32,
    /// Whether the last sample is joined to the first.
    pub(crate) closed: bool,
    /// Picture length up to each sample; of closed lines once more around.
    pub(crate) length: Vec<f64>,
}

/// A sample and the place of its material point one frame later.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Link {
    /// The sample's unknown.
    pub(crate) from: u32,
    /// The two samples around the place.
    pub(crate) to: [u32; 2],
    /// Share of the second.
    pub(crate) share: f64,
    /// Whether the second is the first of its line, once round.
    pub(crate) around: bool,
    /// The lines.
    pub(crate) lines: [u32; 2],
    /// Picture length that the sample stands for.
    pub(crate) weight: f64,
}

/// Lines and links of a film.
pub(crate) struct Net {
    pub(crate) lines: Vec<Line>,
    /// Where each frame's lines begin, and the end.
    pub(crate) frames: Vec<u32>,
    pub(crate) links: Vec<Link>,
    pub(crate) unknowns: usize,
}

/// The strokes of a frame, seen ones first.
pub(crate) fn strokes(frame: &FilmFrame) -> impl Iterator<Item = &Stroke> {
    frame.strokes.iter().chain(&frame.hidden)
}

impl Line {
    /// Picture length.
    pub(crate) fn total(&self) -> f64 {
        self.length.last().copied().unwrap_or(0.0)
    }

    /// Unknowns of each segment with its length; the closing one last.
    pub(crate) fn segments(&self) -> impl Iterator<Item = ([u32; 2], f64)> + '_ {
        let next = |k: usize| if k as u32 == self.count { 0 } else { k as u32 };
        self.length.windows(2).enumerate().map(move |(k, l)| {
            ([self.first + k as u32, self.first + next(k + 1)], (l[1] - l[0]).max(1e-3))
        })
    }
}

/// Links as they were found, so that frames which nothing happened to are not searched again.
#[derive(Default)]
pub(crate) struct Found {
    lines: Vec<Line>,
    frames: Vec<u32>,
    /// Of each line.
    ids: Vec<u32>,
    /// Of each frame with the next.
    links: Vec<Vec<Link>>,
}

impl Net {
    /// The lines of a film and their links; `swept` ones follow S where it is known. What was `found` of
    /// the film before some of its strokes were cut or named otherwise holds for frames that it did not touch.
    pub(crate) fn of(film: &Film, swept: bool, found: &mut Found) -> Self {
        let mut net = Self { lines: Vec::new(), frames: vec![0], links: Vec::new(), unknowns: 0 };
        let mut ids = Vec::new();
        for (f, frame) in film.frames.iter().enumerate() {
            for s in strokes(frame) {
                let count = s.samples.len() as u32;
                net.lines.push(Line {
                    frame: f as u32,
                    first: net.unknowns as u32,
                    count,
                    closed: s.closed,
                    length: s.length.clone(),
                });
                ids.push(s.id);
                net.unknowns += count as usize;
            }
            net.frames.push(net.lines.len() as u32);
        }
        let pairs = 0..film.frames.len().saturating_sub(1);
        let same = found.same(&net, &ids);
        let links = pairs.into_par_iter().map(|f| {
            let again = found.again(&net, &same, f);
            match found.holds(&net, &same, f) && found.holds(&net, &same, f + 1) {
                true => again.into_values().collect(),
                false => net.between((film, f), swept, &again),
            }
        });
        let links: Vec<Vec<Link>> = links.collect();
        net.links = links.concat();
        *found = Found { lines: net.lines.clone(), frames: net.frames.clone(), ids, links };
        net
    }

    /// The lines of a frame.
    pub(crate) fn of_frame(&self, frame: usize) -> std::ops::Range<usize> {
        self.frames[frame] as usize..self.frames[frame + 1] as usize
    }

    /// The links of a frame with the next; those that hold `again`, by their samples, are not looked for.
    fn between(
        &self,
        (film, f): (&Film, usize),
        swept: bool,
        again: &BTreeMap<u32, Link>,
    ) -> Vec<Link> {
        let (here, next) = (&film.frames[f], &film.frames[f + 1]);
        if next.begins {
            return Vec::new();
        }
        let along = if swept { film.partners(f) } else { Vec::new() };
        let there: Vec<&Stroke> = strokes(next).collect();
        let near = Near::of(there.iter().copied(), &next.view);
        let mut links = Vec::new();
        for (i, (line, stroke)) in self.of_frame(f).zip(strokes(here)).enumerate() {
            for j in 0..stroke.samples.len() {
                if let Some(link) = again.get(&(self.lines[line].first + j as u32)) {
                    links.push(*link);
                    continue;
                }
                let swept = along.get(i).and_then(|a| a[j]).filter(|p| meets(p, &there));
                let found = match swept {
                    Some(p) => Some((p.stroke, p.segment, p.share)),
                    None => landing(stroke, j, next, &there, &near)
                        .map(|h| (h.segment.stroke, h.segment.first, h.share)),
                };
                if let Some(place) = found {
                    links.push(self.link(line, j as u32, self.of_frame(f + 1).start, place));
                }
            }
        }
        links
    }

    fn link(&self, line: usize, j: u32, there: usize, place: (u32, u32, f64)) -> Link {
        let (stroke, first, share) = place;
        let to = there + stroke as usize;
        let (own, other) = (&self.lines[line], &self.lines[to]);
        let around = first + 1 == other.count;
        let second = if around { 0 } else { first + 1 };
        Link {
            from: own.first + j,
            to: [other.first + first, other.first + second],
            share,
            around,
            lines: [line as u32, to as u32],
            weight: weight(own, j as usize),
        }
    }
}

impl Found {
    /// For each line of before what it is now, if it is as it was and ids are the same as far as they were.
    fn same(&self, net: &Net, ids: &[u32]) -> Vec<Option<u32>> {
        let mut same = vec![None; self.lines.len()];
        for f in 0..self.frames.len().saturating_sub(1).min(net.frames.len() - 1) {
            let old = self.frames[f] as usize..self.frames[f + 1] as usize;
            let mut new = net.of_frame(f);
            for old in old {
                // Cut lines stand where the whole one did: the next that is like this one is this one.
                let a = &self.lines[old];
                let like =
                    |b: &Line| a.count == b.count && a.closed == b.closed && a.length == b.length;
                let mut ahead = new.clone();
                if let Some(found) = ahead.find(|b| like(&net.lines[*b])) {
                    same[old] = Some(found as u32);
                    new = ahead;
                }
            }
        }
        let (mut there, mut back) = (BTreeMap::new(), BTreeMap::new());
        let pairs =
            || same.iter().enumerate().filter_map(|(old, new)| Some((old, (*new)? as usize)));
        let named = pairs().all(|(old, new)| {
            let (was, is) = (self.ids[old], ids[new]);
            *there.entry(was).or_insert(is) == is && *back.entry(is).or_insert(was) == was
        });
        if named { same } else { vec![None; self.lines.len()] }
    }

    /// Whether all lines of a frame are as they were.
    fn holds(&self, net: &Net, same: &[Option<u32>], f: usize) -> bool {
        self.frames.get(f + 1).is_some_and(|end| {
            let old = self.frames[f] as usize..*end as usize;
            old.len() == net.of_frame(f).len() && same[old].iter().all(Option::is_some)
        })
    }

    /// Links of a frame with the next, between lines that are as they were, by the samples they are of.
    fn again(&self, net: &Net, same: &[Option<u32>], f: usize) -> BTreeMap<u32, Link> {
        let moved = |link: &Link| {
            let [a, b] = link.lines.map(|l| same[l as usize]);
            let lines = [a?, b?];
            let first = |lines: &[Line], line: u32| lines[line as usize].first;
            let at = |i: usize, unknown: u32| {
                unknown - first(&self.lines, link.lines[i]) + first(&net.lines, lines[i])
            };
            let from = at(0, link.from);
            Some((from, Link { from, to: link.to.map(|k| at(1, k)), lines, ..*link }))
        };
        self.links.get(f).into_iter().flatten().filter_map(moved).collect()
    }
}

/// Whether a partner along S is near enough, and no mere end of its line.
fn meets(partner: &Partner, there: &[&Stroke]) -> bool {
    partner.distance <= REACH && !is_mere_end(partner, there[partner.stroke as usize])
}

/// Whether a partner is only the last of a line that ends before what the sample becomes.
pub(crate) fn is_mere_end(partner: &Partner, stroke: &Stroke) -> bool {
    let last = partner.segment as usize + 2 == stroke.samples.len();
    let at_end = (partner.share <= 0.0 && partner.segment == 0) || (partner.share >= 1.0 && last);
    at_end && !stroke.closed && partner.distance > END_MEETS_END
}

/// Half the length of the segments beside a sample.
fn weight(line: &Line, j: usize) -> f64 {
    let l = &line.length;
    let n = l.len() - 1;
    let after = if j < n { l[j + 1] - l[j] } else { 0.0 };
    let before = match (j, line.closed) {
        (0, true) => l[n] - l[n - 1],
        (0, false) => 0.0,
        _ => l[j] - l[j - 1],
    };
    (0.5 * (before + after)).max(1e-3)
}

/// Where a sample's material point is in the next picture, and how deep.
pub(crate) fn material(stroke: &Stroke, j: usize, next: &FilmFrame) -> Option<(DVec2, f64)> {
    let sample = &stroke.samples[j];
    match (sample.next_at, sample.next_world) {
        (Some(at), Some(world)) => Some((at, next.view.see(world)?.depth)),
        // Where nothing follows the surface, the picture must do.
        _ if next.interval.forward.is_empty() && sample.next_world.is_none() => {
            next.view.holds(sample.at, 0.0).then_some((sample.at, sample.depth))
        }
        _ => None,
    }
}

/// The direction of a stroke at a sample, one frame later if that is known.
pub(crate) fn direction(stroke: &Stroke, j: usize) -> DVec2 {
    let s = &stroke.samples;
    let n = s.len();
    let (a, b) = match stroke.closed {
        true => ((j + n - 1) % n, (j + 1) % n),
        false => (j.saturating_sub(1), (j + 1).min(n - 1)),
    };
    let moved = s[a].next_at.zip(s[b].next_at).map(|(p, q)| (q - p).normalize_or_zero());
    moved.filter(|d| *d != DVec2::ZERO).unwrap_or((s[b].at - s[a].at).normalize_or_zero())
}

/// Whether a sample may go on at a place of the next frame: on a line of its kind, and if that is of edges of
/// the mesh, on the same edges, whatever else runs beside them.
pub(crate) fn goes_on(stroke: &Stroke, j: usize, other: &Stroke, hit: &Hit) -> bool {
    let first = hit.segment.first as usize;
    let ends = [first, (first + 1) % other.samples.len()];
    let own = stroke.samples[j].chain;
    other.kind == stroke.kind
        && (!stroke.kind.is_edge() || ends.iter().any(|k| other.samples[*k].chain == own))
}

/// The place where a sample's material point meets a line of the next frame.
pub(crate) fn landing(
    stroke: &Stroke,
    j: usize,
    next: &FilmFrame,
    there: &[&Stroke],
    near: &Near,
) -> Option<Hit> {
    let (at, depth) = material(stroke, j, next)?;
    let along = direction(stroke, j);
    let reach = DEPTH * next.view.size.1 as f64 * next.view.pixel(depth);
    let is_end = |hit: &Hit| {
        let first = hit.segment.first == 0 && hit.share < 0.5;
        j == if first { 0 } else { stroke.samples.len() - 1 } && hit.beyond < END_MEETS_END
    };
    near.nearest(at, REACH, |hit| {
        let other = there[hit.segment.stroke as usize];
        let fits = goes_on(stroke, j, other, hit)
            && hit.segment.direction().dot(along) > AGREES
            && (hit.segment.depth(hit.share) - depth).abs() < reach;
        fits.then_some(if other.id == stroke.id { 0.0 } else { OTHER_ID })
    })
    .filter(|hit| hit.beyond == 0.0 || (!stroke.closed && is_end(hit)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::path::Kind;
    use crate::stroke::Sample;
    use crate::surface::NONE;
    use crate::view::View;
    use chiaro_basis::math::{DVec3, Vec3};

    /// A level line of edges.
    fn level(chain: u32, y: f64) -> Stroke {
        let sample = |k: u32| Sample {
            at: DVec2::new(3.0 * f64::from(k), y),
            depth: 1.0,
            world: DVec3::ZERO,
            next_world: None,
            next_at: None,
            chain,
            on_chain: f64::from(k),
            normal: DVec3::Z,
            faces: [NONE; 2],
        };
        Stroke { chain, ..Stroke::through(Kind::Crease, false, (0..10).map(sample).collect()) }
    }

    #[test]
    fn edges_go_on_as_themselves_whatever_is_nearer() {
        let projection = chiaro_scene::Projection::Orthographic { half_height: 1.0 };
        let pose = chiaro_scene::Pose::look_at(Vec3::Z, Vec3::ZERO, Vec3::Y, projection);
        let view = View::new(pose, (64, 64));
        let there = [level(7, 11.0), level(3, 12.0)];
        let near = Near::of(there.iter(), &view);
        let own = level(3, 10.0);
        let hit = near.nearest(own.samples[4].at, REACH, |hit| {
            goes_on(&own, 4, &there[hit.segment.stroke as usize], hit).then_some(0.0)
        });
        assert_eq!(hit.map(|h| h.segment.stroke), Some(1));
        // Outlines are told by place alone: their chains are others in every frame.
        let outline = |s: &Stroke| Stroke { kind: Kind::Silhouette, ..s.clone() };
        let (own, there) = (outline(&own), there.each_ref().map(outline));
        let hit = near.nearest(own.samples[4].at, REACH, |hit| {
            goes_on(&own, 4, &there[hit.segment.stroke as usize], hit).then_some(0.0)
        });
        assert_eq!(hit.map(|h| h.segment.stroke), Some(0));
    }
}
