//! Charts: lines of a film cut so that merges and splits lie on chart borders (section 4.7).
//!
//! A cut is a place on a line in one frame, and where it goes in the frames after it or before it,
//! until it leaves the line. Ways to choose the cuts, which may follow each other:
//!
//! *At contradictions* ([`contradictions`]): where a robust solve finds links that cannot be had with
//! the rest (a ring whose gap wanders asks a stretch to be at both ends of the line at once), the
//! stretch they lead to is followed to the nearest frame, ahead or behind, in which it is joined to
//! the rest of a line. There it is kept apart.
//!
//! *At events* ([`events`]), as in the thesis: forward cuts from mergers and backward cuts from splits
//! are paired where they come within sigma of each other; else they run to the end of the line's life.
//! Either at every event, or only where lines of different ids meet.

use super::net::{Link, Net};
use chiaro_basis::Sets;
use std::collections::{BTreeMap, BTreeSet};

/// A stretch below this length is no part of its own, pixels.
const PART: f64 = 6.0;
/// A cut leaves a line where it comes this near to its end, pixels.
const END: f64 = 4.0;

/// A place on a line: picture length from its start.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Place {
    pub(crate) line: u32,
    pub(crate) at: f64,
    /// Ids before and after it, where the line is to be parted between two of them.
    pub(crate) ids: Option<[u32; 2]>,
}

/// What cuts at events came to.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Saved {
    /// Mergers and splits.
    pub events: [usize; 2],
    /// Mergers that found a split.
    pub paired: usize,
    /// Places at which a line is cut, over all frames.
    pub cut_places: usize,
}

/// Links by line, in order along it.
pub(crate) struct Tracer<'a> {
    net: &'a Net,
    /// For each line, (length on it, link) of the links that leave it, and of those that reach it.
    leaving: Vec<Vec<(f64, u32)>>,
    reaching: Vec<Vec<(f64, u32)>>,
}

/// Neighbouring links from one line to another.
#[derive(Clone, Debug)]
struct Run {
    lines: [u32; 2],
    /// Their interval on either line.
    spans: [[f64; 2]; 2],
    residual: f64,
}

impl<'a> Tracer<'a> {
    pub(crate) fn new(net: &'a Net) -> Self {
        let empty = || vec![Vec::new(); net.lines.len()];
        let (mut leaving, mut reaching): (Vec<Vec<(f64, u32)>>, _) = (empty(), empty());
        for (i, link) in net.links.iter().enumerate() {
            let [from, to] = ends(net, link);
            leaving[link.lines[0] as usize].push((from, i as u32));
            reaching[link.lines[1] as usize].push((to, i as u32));
        }
        let sort =
            |l: &mut Vec<(f64, u32)>| l.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        leaving.iter_mut().for_each(sort);
        reaching.iter_mut().for_each(sort);
        Self { net, leaving, reaching }
    }

    /// Where a place is one frame later, or before.
    fn step(&self, place: Place, ahead: bool) -> Option<Place> {
        let list = if ahead { &self.leaving } else { &self.reaching };
        let list = &list[place.line as usize];
        let k = list.partition_point(|l| l.0 < place.at);
        let near = [k.checked_sub(1), Some(k)].into_iter().flatten().filter_map(|k| list.get(k));
        let best = near.min_by(|a, b| (a.0 - place.at).abs().total_cmp(&(b.0 - place.at).abs()))?;
        let link = &self.net.links[best.1 as usize];
        let [from, to] = ends(self.net, link);
        let (line, at) = if ahead { (link.lines[1], to) } else { (link.lines[0], from) };
        let off = place.at - best.0;
        (off.abs() <= PART).then_some(Place { line, at: at + off, ids: place.ids })
    }

    /// A place and where it goes until it comes to an end of its line.
    fn trace(&self, place: Place, ahead: bool) -> Vec<Place> {
        let mut places = Vec::new();
        let mut next = Some(place);
        while let Some(place) = next.filter(|p| self.is_inside(p)) {
            places.push(place);
            next = self.step(place, ahead);
        }
        places
    }

    fn is_inside(&self, place: &Place) -> bool {
        let line = &self.net.lines[place.line as usize];
        line.closed || (place.at > END && place.at < line.total() - END)
    }

    /// Runs of links that leave a line (or reach it), parted where they change their aim or where
    /// `residual` jumps by more than `jump`.
    fn runs(&self, line: u32, leave: bool, residual: &dyn Fn(u32) -> f64, jump: f64) -> Vec<Run> {
        let list = if leave { &self.leaving } else { &self.reaching };
        let mut runs: Vec<(Run, Vec<f64>)> = Vec::new();
        for &(_, i) in &list[line as usize] {
            let link = &self.net.links[i as usize];
            let [from, to] = ends(self.net, link);
            let r = residual(i);
            match runs.last_mut() {
                Some((run, all))
                    if run.lines == link.lines && (r - all[all.len() - 1]).abs() <= jump =>
                {
                    for (span, x) in run.spans.iter_mut().zip([from, to]) {
                        *span = [span[0].min(x), span[1].max(x)];
                    }
                    all.push(r);
                }
                _ => {
                    let spans = [[from; 2], [to; 2]];
                    runs.push((Run { lines: link.lines, spans, residual: 0.0 }, vec![r]));
                }
            }
        }
        let median = |(mut run, mut all): (Run, Vec<f64>)| {
            all.sort_unstable_by(f64::total_cmp);
            run.residual = all[all.len() / 2];
            run
        };
        let own = usize::from(!leave);
        let long = |r: &Run| r.spans[own][1] - r.spans[own][0] >= PART;
        runs.into_iter().map(median).filter(long).collect()
    }
}

/// Lengths of a link on its two lines.
fn ends(net: &Net, link: &Link) -> [f64; 2] {
    let [a, b] = link.lines.map(|l| &net.lines[l as usize]);
    let k = (link.to[0] - b.first) as usize;
    [
        a.length[(link.from - a.first) as usize],
        b.length[k] + (b.length[k + 1] - b.length[k]) * link.share,
    ]
}

/// Cuts that keep apart what contradicts: `residual` in pixels by link, `sigma` how much is allowed.
pub(crate) fn contradictions(net: &Net, residual: &dyn Fn(u32) -> f64, sigma: f64) -> Vec<Place> {
    let tracer = Tracer::new(net);
    let mut cuts = Vec::new();
    let mut done = BTreeSet::new();
    for line in 0..net.lines.len() as u32 {
        for run in tracer.runs(line, true, residual, sigma) {
            if run.residual.abs() <= sigma || !done.insert(key(&run)) {
                continue;
            }
            let ahead = apart(&tracer, run.lines[1], run.spans[1], true);
            let behind = apart(&tracer, run.lines[0], run.spans[0], false);
            let best = match (ahead, behind) {
                (Some(a), Some(b)) => Some(if b.len() < a.len() { b } else { a }),
                (a, b) => a.or(b),
            };
            cuts.extend(best.unwrap_or_default());
        }
    }
    cuts
}

fn key(run: &Run) -> (u32, u32, u64) {
    (run.lines[0], run.lines[1], run.spans[0][0].to_bits())
}

/// Follows a stretch of a line to where more of a line is beside it, and cuts there.
fn apart(tracer: &Tracer<'_>, line: u32, span: [f64; 2], ahead: bool) -> Option<Vec<Place>> {
    let (mut line, mut span) = (line, span);
    loop {
        let total = tracer.net.lines[line as usize].total();
        let closed = tracer.net.lines[line as usize].closed;
        let inside = [span[0] > 2.0 * PART, span[1] < total - 2.0 * PART];
        let cuts: Vec<Place> = [0, 1]
            .into_iter()
            .filter(|&side| inside[side] || (closed && inside[1 - side]))
            .flat_map(|side| tracer.trace(Place { line, at: span[side], ids: None }, ahead))
            .collect();
        if !cuts.is_empty() {
            return Some(cuts);
        }
        let runs = tracer.runs(line, ahead, &|_| 0.0, f64::INFINITY);
        let own = usize::from(ahead);
        // The longest part leads.
        let length = |r: &Run| r.spans[own][1] - r.spans[own][0];
        let run = runs.iter().max_by(|a, b| length(a).total_cmp(&length(b)))?;
        (line, span) = (run.lines[own], run.spans[own]);
    }
}

/// Cuts at mergers and splits; with `paired`, a merger looks for a split within `sigma` pixels. With
/// `ids` of lines, only where those that merge or part have different ones.
pub(crate) fn events(
    net: &Net,
    paired: bool,
    sigma: f64,
    ids: Option<&[u32]>,
) -> (Vec<Place>, Saved) {
    let tracer = Tracer::new(net);
    let mergers = borders(&tracer, false, ids);
    let splits = borders(&tracer, true, ids);
    let mut saved = Saved { events: [mergers.len(), splits.len()], ..Saved::default() };
    let mut free: BTreeMap<u32, Vec<(f64, usize)>> = BTreeMap::new();
    for (i, s) in splits.iter().enumerate() {
        free.entry(s.line).or_default().push((s.at, i));
    }
    let mut used = vec![false; splits.len()];
    let mut cuts: Vec<Place> = Vec::new();
    let mut by_line: BTreeMap<u32, Vec<f64>> = BTreeMap::new();
    for merger in mergers {
        let path = tracer.trace(merger, true);
        let found = path.iter().enumerate().filter(|_| paired).find_map(|(t, place)| {
            let near = free.get(&place.line)?.iter().filter(|(at, i)| {
                let between = |x: &f64| (x - place.at) * (x - at) < 0.0;
                !used[*i]
                    && (at - place.at).abs() <= sigma
                    && !by_line.get(&place.line).is_some_and(|l| l.iter().any(between))
            });
            near.min_by(|a, b| (a.0 - place.at).abs().total_cmp(&(b.0 - place.at).abs()))
                .map(|split| (t, *split))
        });
        let path = match found {
            Some((t, (at, i))) => {
                used[i] = true;
                saved.paired += 1;
                sheared(&path[..=t], at)
            }
            None => path,
        };
        path.iter().for_each(|p| by_line.entry(p.line).or_default().push(p.at));
        cuts.extend(path);
    }
    for (split, used) in splits.into_iter().zip(used) {
        if !used {
            cuts.extend(tracer.trace(split, false));
        }
    }
    saved.cut_places = cuts.len();
    (cuts, saved)
}

/// Lines that trusted links of some length join, or an id: for each line the first of those it
/// belongs to.
pub(crate) fn components(net: &Net, trust: &[f64], ids: &[u32]) -> Vec<u32> {
    let mut bundles: BTreeMap<[u32; 2], f64> = BTreeMap::new();
    for (link, trust) in net.links.iter().zip(trust) {
        *bundles.entry(link.lines).or_insert(0.0) += trust * link.weight;
    }
    let mut sets = Sets::new(net.lines.len());
    let linked = bundles.into_iter().filter(|(_, weight)| *weight >= PART).map(|(lines, _)| lines);
    let mut first: BTreeMap<u32, u32> = BTreeMap::new();
    let named = (0u32..).zip(ids).map(|(l, id)| [*first.entry(*id).or_insert(l), l]);
    for [a, b] in linked.chain(named) {
        sets.join(a as usize, b as usize);
    }
    (0..sets.len()).map(|l| sets.root(l) as u32).collect()
}

/// A path bent so that it ends at a length of its last line.
fn sheared(path: &[Place], end: f64) -> Vec<Place> {
    let miss = end - path[path.len() - 1].at;
    let last = (path.len() - 1).max(1) as f64;
    let bend = |(t, p): (usize, &Place)| Place { at: p.at + miss * t as f64 / last, ..*p };
    path.iter().enumerate().map(bend).collect()
}

/// Places between stretches that come from different lines, or go to different ones; with `ids`, to
/// lines of different ids.
fn borders(tracer: &Tracer<'_>, leave: bool, ids: Option<&[u32]>) -> Vec<Place> {
    let own = usize::from(!leave);
    let mut places = Vec::new();
    for line in 0..tracer.net.lines.len() as u32 {
        let runs = tracer.runs(line, leave, &|_| 0.0, f64::INFINITY);
        let mut between = |before: &Run, after: &Run, turn: f64| {
            let lines = [before, after].map(|r| r.lines[1 - own]);
            let ids = ids.map(|ids| lines.map(|l| ids[l as usize]));
            if ids.unwrap_or(lines).windows(2).any(|p| p[0] != p[1]) {
                let at = 0.5 * (before.spans[own][1] + after.spans[own][0] + turn);
                places.push(Place { line, at, ids });
            }
        };
        runs.windows(2).for_each(|p| between(&p[0], &p[1], 0.0));
        let whole = &tracer.net.lines[line as usize];
        if let ([first, .., last], true, true) = (runs.as_slice(), whole.closed, ids.is_some()) {
            between(last, first, whole.total());
        }
    }
    places
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::parameter::net::Line;

    /// Two lines of 30 pixels that become one, and a line of a third frame that no link reaches.
    fn merger() -> Net {
        let line = |frame: u32, first: u32, count: u32| Line {
            frame,
            first,
            count,
            closed: false,
            length: (0..count).map(|k| 3.0 * f64::from(k)).collect(),
        };
        let link = |from: u32, line: u32| Link {
            from,
            to: [22 + from, 23 + from],
            share: 0.0,
            around: false,
            lines: [line, 2],
            weight: 3.0,
        };
        let lines = vec![line(0, 0, 11), line(0, 11, 11), line(1, 22, 23), line(2, 45, 11)];
        let links = (0..10).map(|k| link(k, 0)).chain((11..21).map(|k| link(k, 1))).collect();
        Net { lines, frames: vec![0, 2, 3, 4], links, unknowns: 56 }
    }

    #[test]
    fn lines_that_merge_show_one_texture_where_links_are_trusted() {
        let net = merger();
        let all = vec![1.0; net.links.len()];
        assert_eq!(components(&net, &all, &[0, 1, 0, 2]), [0, 0, 0, 3]);
        let first: Vec<f64> = (0..20).map(|i| if i < 10 { 1.0 } else { 0.0 }).collect();
        assert_eq!(components(&net, &first, &[0, 1, 0, 2]), [0, 1, 0, 3]);
        // What came back after it was hidden has its id.
        assert_eq!(components(&net, &first, &[0, 1, 0, 1]), [0, 1, 0, 1]);
    }
}
