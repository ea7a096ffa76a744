//! [`Parts`]: lines of a film parted where two ids meet, as parts of the lines that were solved.
//!
//! Where lines of two ids merge, texture goes on from either into the line that they become, yet that
//! line can have but one of the ids. So it is parted there for as long as it lasts (a cut in name
//! alone): u is that of the whole line, and neither slides nor stretches for the cut.

use super::chart::{self, Place};
use super::cut::{Kept, trusted};
use super::net::{Found, Line, Link, Net};
use super::{ROUNDS, crosses_seam, name, net, split};
use crate::film::Film;
use crate::stroke::{Sample, Stroke};
use std::borrow::Cow;
use std::collections::BTreeMap;

/// Where a stroke lies on a line that was solved.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Origin {
    /// The line.
    pub(crate) line: u32,
    /// Picture length on it at which the stroke begins; closed lines may be passed once round.
    pub(crate) from: f64,
    /// What is added to u: whole turns, so that u goes on from frame to frame where a loop is parted.
    pub(crate) turns: f64,
}

/// The lines that were solved, with what is known of each.
pub(crate) struct Whole<'a> {
    pub(crate) net: &'a Net,
    pub(crate) kept: &'a Kept,
    /// Pixels a unit of u.
    pub(crate) scale: &'a [f64],
    pub(crate) period: &'a [Option<f64>],
    /// The period of the texture that each shows, where links carried one to it.
    pub(crate) carried: &'a [Option<f64>],
}

/// The strokes of a film, as they stand in it, after its lines were parted.
pub(crate) struct Parts {
    pub(crate) origins: Vec<Origin>,
    /// Of each stroke: the first of those whose texture it shows.
    pub(crate) components: Vec<u32>,
}

impl Parts {
    /// Names the strokes of a film, parts them where two ids meet if `sigma` is given, and names them
    /// again. Links are looked for where they may differ from those that were `found`.
    pub(crate) fn of(
        film: &mut Film,
        whole: &Whole<'_>,
        sigma: Option<f64>,
        (swept, mut found): (bool, Found),
    ) -> Self {
        let lines = 0..whole.net.lines.len() as u32;
        let mut origins: Vec<Origin> =
            lines.map(|line| Origin { line, from: 0.0, turns: 0.0 }).collect();
        let mut ids = named(film, whole.net, whole.kept, whole.scale);
        let mut components = chart::components(whole.net, &whole.kept.trust, &ids);
        let Some(sigma) = sigma else { return Self { origins, components } };
        let mut parted: Option<Net> = None;
        for _ in 0..ROUNDS {
            let net = parted.as_ref().unwrap_or(whole.net);
            let places = meetings(net, &ids, sigma);
            let (made, from) = split::split(film, net, &places);
            if made == 0 {
                break;
            }
            origins = from.iter().map(|o| whole.origin(&origins, o)).collect();
            let net = Net::of(film, swept, &mut found);
            let (net, kept, scale) = whole.parted(net, &mut origins, sigma);
            ids = named(film, &net, &kept, &scale);
            components = chart::components(&net, &kept.trust, &ids);
            parted = Some(net);
        }
        Self { origins, components }
    }
}

/// Where lines of different ids merge or part.
fn meetings(net: &Net, ids: &[u32], sigma: f64) -> Vec<Place> {
    chart::events(net, true, sigma, Some(ids)).0
}

/// Gives the film's strokes the ids of charts; answers them in order.
fn named(film: &mut Film, net: &Net, kept: &Kept, scale: &[f64]) -> Vec<u32> {
    name::rename(film, net, kept, scale);
    film.frames.iter().flat_map(net::strokes).map(|stroke| stroke.id).collect()
}

impl Whole<'_> {
    /// A part of a part as a part of the whole.
    fn origin(&self, before: &[Origin], part: &Origin) -> Origin {
        let old = before[part.line as usize];
        let total = self.net.lines[old.line as usize].total();
        let from = old.from + part.from;
        Origin { line: old.line, from: if from > total { from - total } else { from }, turns: 0.0 }
    }

    /// The net of parts, whose links are trusted where u agrees; chooses turns of parts of loops.
    fn parted(&self, mut net: Net, origins: &mut [Origin], sigma: f64) -> (Net, Kept, Vec<f64>) {
        let of = |o: &Origin| o.line as usize;
        let scale: Vec<f64> = origins.iter().map(|o| self.scale[of(o)]).collect();
        let once: Vec<Option<f64>> = origins.iter().map(|o| self.period[of(o)]).collect();
        let closed = |(line, p): (&Line, &Option<f64>)| p.filter(|_| line.closed);
        let period: Vec<Option<f64>> = net.lines.iter().zip(&once).map(closed).collect();
        let Net { lines, links, .. } = &mut net;
        links.retain(|l| !crosses_seam(lines, l, &period));
        let mut u = self.values(&net, origins);
        let carried: Vec<Option<f64>> = origins.iter().map(|o| self.carried[of(o)]).collect();
        turn(&net, &carried, &mut u, origins);
        let residual: Vec<f64> = (net.links.iter())
            .map(|link| {
                let [from, to] = link.lines.map(|l| once[l as usize]);
                let off = off(link, &u, to);
                let turns = to.or(from).map_or(0.0, |p| (off / p).round() * p);
                (off - turns) * scale[link.lines[0] as usize]
            })
            .collect();
        let trust = trusted(&net, &residual, sigma);
        let wraps = Vec::new();
        (net, Kept { trust, wraps, cut: 0, cut_length: 0.0, residual, u }, scale)
    }

    /// u of every sample of parts where textures are nearly rigid.
    fn values(&self, net: &Net, origins: &[Origin]) -> Vec<f64> {
        let mut u = Vec::with_capacity(net.unknowns);
        for (line, origin) in net.lines.iter().zip(origins) {
            let l = origin.line as usize;
            let whole = &self.net.lines[l];
            let own = &self.kept.u[whole.first as usize..(whole.first + whole.count) as usize];
            let own = closed_up(whole, own, self.scale[l], self.period[l]);
            u.extend(values(whole, &own, origin, &line.length[..line.count as usize]));
        }
        u
    }
}

/// What u at a link's sample has more than where it leads, in units of u.
fn off(link: &Link, u: &[f64], period: Option<f64>) -> f64 {
    let place = link.to.map(|k| u[k as usize]);
    let turn = if link.around { period.unwrap_or(0.0) } else { 0.0 };
    u[link.from as usize] - place[0] - (place[1] + turn - place[0]) * link.share
}

/// Adds whole turns of their textures to u of open lines, so that u goes on from frame to frame: heavier bundles of
/// links first. Lines whose textures differ in their period are not turned to each other: a turn of one would be
/// a slide along the other.
fn turn(net: &Net, period: &[Option<f64>], u: &mut [f64], origins: &mut [Origin]) {
    let mut bundles: BTreeMap<[u32; 2], (f64, Vec<f64>)> = BTreeMap::new();
    let is_turned = |link: &&Link| {
        let [a, b] = link.lines.map(|l| l as usize);
        !net.lines[a].closed && !net.lines[b].closed && period[a] == period[b]
    };
    for link in net.links.iter().filter(is_turned) {
        let period = period[link.lines[0] as usize];
        let turns = period.map_or(0.0, |p| (off(link, u, None) / p).round() * p);
        let bundle = bundles.entry(link.lines).or_default();
        bundle.0 += link.weight;
        bundle.1.push(turns);
    }
    let mut bundles: Vec<([u32; 2], f64, f64)> = bundles
        .into_iter()
        .map(|(lines, (weight, mut turns))| {
            turns.sort_unstable_by(f64::total_cmp);
            (lines, weight, turns[turns.len() / 2])
        })
        .collect();
    bundles.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
    let mut trees: Vec<(u32, f64)> = (0..net.lines.len() as u32).map(|l| (l, 0.0)).collect();
    for ([a, b], _, turns) in bundles {
        let [(a, at_a), (b, at_b)] = [a, b].map(|l| root(&mut trees, l));
        // The line that comes later takes over.
        let (low, high, more) = match a < b {
            true => (a, b, at_a + turns - at_b),
            false => (b, a, at_b - turns - at_a),
        };
        if low != high {
            trees[high as usize] = (low, more);
        }
    }
    for (l, line) in net.lines.iter().enumerate().filter(|(_, line)| !line.closed) {
        origins[l].turns = root(&mut trees, l as u32).1;
        let samples = line.first as usize..(line.first + line.count) as usize;
        u[samples].iter_mut().for_each(|u| *u += origins[l].turns);
    }
}

/// The root of a line's tree, and what u of the line gains over the root's.
pub(crate) fn root(trees: &mut [(u32, f64)], line: u32) -> (u32, f64) {
    let (mut at, mut more) = (line, 0.0);
    while trees[at as usize].0 != at {
        more += trees[at as usize].1;
        at = trees[at as usize].0;
    }
    trees[line as usize] = if at == line { (line, 0.0) } else { (at, more) };
    (at, more)
}

/// u of a line's samples; where it is closed, once more of the first.
pub(crate) fn closed_up(line: &Line, own: &[f64], scale: f64, period: Option<f64>) -> Vec<f64> {
    let mut own = own.to_vec();
    if line.closed {
        let closing = line.total() - line.length[line.count as usize - 1];
        let open = own[own.len() - 1] + closing / scale;
        own.push(period.map_or(open, |p| own[0] + p));
    }
    own
}

/// u of a part of a line, whose u is closed up, at some lengths of the part.
pub(crate) fn values(line: &Line, own: &[f64], part: &Origin, lengths: &[f64]) -> Vec<f64> {
    let from = part.from;
    if from == 0.0 && line.length.get(..lengths.len()) == Some(lengths) {
        return own[..lengths.len()].iter().map(|u| u + part.turns).collect();
    }
    let turn = own[own.len() - 1] - own[0];
    let at = |length: &f64| {
        let x = from + length;
        let round = line.closed && x > line.total();
        let x = if round { x - line.total() } else { x };
        let k = line.length.partition_point(|l| *l <= x).clamp(1, own.len() - 1);
        let [a, b] = [line.length[k - 1], line.length[k]];
        let share = if b > a { ((x - a) / (b - a)).clamp(0.0, 1.0) } else { 0.0 };
        let u = own[k - 1] + (own[k] - own[k - 1]) * share;
        u + part.turns + if round { turn } else { 0.0 }
    };
    lengths.iter().map(at).collect()
}

/// The strokes of a list, those joined that are parts of one line in name alone.
pub fn whole(strokes: &[Stroke]) -> Vec<Cow<'_, Stroke>> {
    let same = |a: &Stroke, b: &Stroke| a.part.is_some() && a.part == b.part;
    strokes.chunk_by(same).map(one).collect()
}

/// The lines of a list of strokes as they are drawn: parts in name alone joined, and pieces that a cut parts each
/// on to where the next begins.
pub fn drawn(strokes: &[Stroke]) -> Vec<Cow<'_, Stroke>> {
    let mut lines = whole(strokes);
    let mut start = 0;
    while start < lines.len() {
        let body = lines[start].body;
        let count = lines[start..].iter().take_while(|s| s.body == body).count();
        // What was parted in name alone is one again.
        let is_whole = lines[start].closed;
        if let (Some((_, closed)), false) = (body, is_whole) {
            let pieces = &mut lines[start..start + count];
            let first = pieces[0].samples[0];
            for k in 0..count {
                let goes_on = [closed || k > 0, closed || k + 1 < count];
                let next = pieces.get(k + 1).map_or(first, |next| next.samples[0]);
                let piece = pieces[k].to_mut();
                piece.goes_on = goes_on;
                if goes_on[1] {
                    go_on(piece, next);
                }
            }
            start += count;
        } else {
            start += 1;
        }
    }
    lines
}

/// Lengthens an open stroke to a sample.
fn go_on(stroke: &mut Stroke, to: Sample) {
    let mut u = std::mem::take(&mut stroke.u);
    let before = stroke.total();
    stroke.samples.push(to);
    stroke.measure();
    u.push(u.last().copied().unwrap_or(0.0) + (stroke.total() - before) / stroke.pixels_per_u);
    stroke.set_u(u, stroke.pixels_per_u);
}

/// One line of a list's strokes that are its parts.
fn one(parts: &[Stroke]) -> Cow<'_, Stroke> {
    match parts {
        [stroke] if !stroke.part.is_some_and(|(_, closed)| closed) => Cow::Borrowed(stroke),
        parts => Cow::Owned(joined(parts)),
    }
}

/// One stroke of parts that follow each other, under the first one's id.
fn joined(parts: &[Stroke]) -> Stroke {
    let mut whole = parts[0].clone();
    let mut u = whole.u.clone();
    for part in &parts[1..] {
        // Parts may be apart by whole turns.
        let off = u.last().zip(part.u.first()).map_or(0.0, |(a, b)| a - b);
        let turns = whole.repeats.filter(|p| *p > 0.0).map_or(0.0, |p| (off / p).round() * p);
        whole.samples.extend(&part.samples);
        u.extend(part.u.iter().map(|u| u + turns));
    }
    whole.closed = whole.part.is_some_and(|(_, closed)| closed);
    whole.measure();
    if let (true, [.., before, last]) = (whole.closed, whole.length.as_slice()) {
        let open = u[u.len() - 1] + (last - before) / whole.pixels_per_u;
        u.push(whole.repeats.map_or(open, |p| u[0] + p));
    }
    whole.set_u(u, whole.pixels_per_u);
    whole
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_turned_by_whole_turns_of_their_own_textures() {
        let line = |frame, first| Line {
            frame,
            first,
            count: 10,
            closed: false,
            length: (0..10).map(|k| 3.0 * f64::from(k)).collect(),
        };
        let link = |from: u32| Link {
            from,
            to: [10 + from, 11 + from],
            share: 0.0,
            around: false,
            lines: [0, 1],
            weight: 3.0,
        };
        let links = (0..9).map(link).collect();
        let lines = vec![line(0, 0), line(1, 10)];
        let net = Net { lines, frames: vec![0, 1, 2], links, unknowns: 20 };
        let gained = |periods: [f64; 2]| {
            // One goes on from the other, but for 19 units.
            let mut u: Vec<f64> = (0..20)
                .map(|k| 0.1 * f64::from(k % 10) + if k < 10 { 19.0 } else { 0.0 })
                .collect();
            let mut origins = [0, 1].map(|line| Origin { line, from: 0.0, turns: 0.0 });
            turn(&net, &periods.map(Some), &mut u, &mut origins);
            origins[1].turns - origins[0].turns
        };
        assert_eq!(gained([19.0, 19.0]), 19.0);
        // A turn of one would be a slide along the other, of which the texture begins anew after 21.
        assert_eq!(gained([19.0, 21.0]), 0.0);
    }

    #[test]
    fn parts_of_a_loop_go_on_past_its_seam() {
        let length: Vec<f64> = (0..=10).map(|k| 3.0 * f64::from(k)).collect();
        let line = Line { frame: 0, first: 0, count: 10, closed: true, length };
        let own: Vec<f64> = (0..10).map(|k| 0.3 * f64::from(k)).collect();
        let own = closed_up(&line, &own, 10.0, Some(3.0));
        let origin = |from: f64| Origin { line: 0, from, turns: 0.0 };
        let part = values(&line, &own, &origin(25.5), &[0.0, 3.0, 6.0, 9.0]);
        for (k, u) in part.iter().enumerate() {
            assert!((u - (2.55 + 0.3 * k as f64)).abs() < 1e-12, "{part:?}");
        }
        assert_eq!(values(&line, &own, &origin(0.0), &line.length), own);
    }
}
