//! Lines that go on behind what hides them: u is on either side what it would be if nothing did.
//!
//! A gap between two strokes of one line is a row of (4.11), as long as the gap is in the picture. Which of these
//! rows can be had with the links that are trusted is found as with links: lines that those join move as one, each
//! gap says by how much one such group is to be moved beside another, the heaviest say comes first, and gaps that
//! disagree with what came out by more than the sliding limit are left out.

use super::chart::components;
use super::cut::{Kept, medians};
use super::name::{LED, weights};
use super::net::{Net, strokes};
use crate::film::Film;
use crate::gap::{Between, between};
use chiaro_basis::Sets;
use std::collections::{BTreeMap, BTreeSet};

/// Shorter gaps are none, pixels: weights are the reciprocal of their length.
const LEAST: f64 = 3.0;
/// Gaps between two lines are left out where half of them miss more than this share of the sliding limit.
const AGREED: f64 = 0.5;
/// What is hidden may stretch more readily than what is seen: the weight of its row beside those of segments.
const UNSEEN: f64 = 0.25;
/// The weight where that share is missed by lines that nothing else ties: they hardly stretch for it, but without it u
/// of one might be anything beside the other's.
const LOOSE: f64 = 1e-3;

/// What is hidden between the end of one line and the start of another.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Across {
    /// The lines.
    pub(crate) lines: [u32; 2],
    /// The last sample of one and the first of the other.
    pub(crate) unknowns: [u32; 2],
    /// Picture length, pixels.
    pub(crate) length: f64,
    /// What u of the second has more than that for whole turns of the texture.
    pub(crate) turns: f64,
    /// Of its row, beside those of segments.
    pub(crate) weight: f64,
}

/// The gaps of a film.
fn found(film: &Film, net: &Net) -> Vec<Across> {
    let mut all = Vec::new();
    for (f, frame) in film.frames.iter().enumerate() {
        let first = net.of_frame(f).start;
        // Where what is hidden is drawn too it touches what is seen, and links tie the two.
        let gaps = between(strokes(frame), &frame.gaps).into_iter().filter(|g| g.length >= LEAST);
        for Between { strokes, length, .. } in gaps {
            let lines = strokes.map(|s| (first + s) as u32);
            let [a, b] = lines.map(|l| &net.lines[l as usize]);
            let unknowns = [a.first + a.count - 1, b.first];
            all.push(Across { lines, unknowns, length, turns: 0.0, weight: UNSEEN });
        }
    }
    all
}

/// The gaps that can be had with the links that are trusted; moves what those do not join in `kept` so that they
/// are met as well as may be.
pub(crate) fn agreeing(
    film: &Film,
    net: &Net,
    kept: &mut Kept,
    (scale, period): (&[f64], &[Option<f64>]),
    sigma: f64,
) -> Vec<Across> {
    let mut all = found(film, net);
    let own: Vec<u32> = (0..net.lines.len() as u32).collect();
    let group = components(net, &kept.trust, &own);
    let mut turn: Vec<Option<f64>> = vec![None; net.lines.len()];
    for (line, period) in period.iter().enumerate() {
        turn[group[line] as usize] = turn[group[line] as usize].or(*period);
    }
    // What a gap has too much, in units of u; whole turns of its texture are none.
    let off = |u: &[f64], gap: &Across| {
        let [a, b] = gap.unknowns.map(|k| u[k as usize]);
        let [from, to] = gap.lines.map(|l| turn[group[l as usize] as usize]);
        let off = b - a - gap.length / scale[gap.lines[1] as usize];
        let turns = to.or(from).map_or(0.0, |p| (off / p).round() * p);
        (off - turns, turns)
    };
    let says = says(&all, &group, |gap| off(&kept.u, gap).0);
    let (moved, tied) = moves(says, net.lines.len());
    for (line, group) in net.lines.iter().zip(&group) {
        let samples = line.first as usize..(line.first + line.count) as usize;
        kept.u[samples].iter_mut().for_each(|u| *u += moved[*group as usize]);
    }
    let mut misses = Vec::with_capacity(all.len());
    for gap in &mut all {
        let (off, turns) = off(&kept.u, gap);
        gap.turns = turns;
        misses.push(off.abs() * scale[gap.lines[1] as usize]);
    }
    // As with links: what disagrees in most frames is left out in all.
    let ids: Vec<u32> = film.frames.iter().flat_map(strokes).map(|s| s.id).collect();
    let of = |gap: &Across| gap.lines.map(|l| ids[l as usize]);
    let median = medians(all.iter().map(of).zip(misses.iter().copied()));
    let weighed = |(gap, miss): (Across, f64)| {
        let pair = gap.lines.map(|l| group[l as usize]);
        let agrees = median[&of(&gap)] <= AGREED * sigma;
        let alone = || tied.contains(&[pair[0].min(pair[1]), pair[0].max(pair[1])]);
        let weight = if agrees { UNSEEN } else { LOOSE };
        (miss <= sigma && (agrees || alone())).then_some(Across { weight, ..gap })
    };
    let gaps: Vec<Across> = all.into_iter().zip(misses).filter_map(weighed).collect();
    let strays = strays(net, kept, scale, (&group, &held(&gaps, &group), sigma));
    strays.into_iter().for_each(|link| kept.trust[link] = 0.0);
    gaps
}

/// For each group the first of those that gaps which agree hold together.
fn held(gaps: &[Across], group: &[u32]) -> Vec<u32> {
    let mut sets = Sets::new(group.len());
    for gap in gaps.iter().filter(|gap| gap.weight == UNSEEN) {
        let [a, b] = gap.lines.map(|l| group[l as usize] as usize);
        sets.join(a, b);
    }
    (0..group.len()).map(|g| sets.root(g) as u32).collect()
}

/// Links between groups that gaps hold together, too few to have joined them, that contradict the gaps: where a line
/// ends beside another a sample of it may lead there, and be trusted, as nothing else ties the two.
fn strays(
    net: &Net,
    kept: &Kept,
    scale: &[f64],
    (group, held, sigma): (&[u32], &[u32], f64),
) -> Vec<usize> {
    let weights = weights(net, &kept.trust);
    let is_stray = |i: &usize| {
        let link = &net.links[*i];
        let [a, b] = link.lines.map(|l| group[l as usize]);
        if a == b || held[a as usize] != held[b as usize] || kept.trust[*i] == 0.0 {
            return false;
        }
        let [from, to] = link.to.map(|k| kept.u[k as usize]);
        let off = kept.u[link.from as usize] - from - (to - from) * link.share - kept.wraps[*i];
        let shorter = link.lines.iter().map(|l| net.lines[*l as usize].total());
        let few = weights[&link.lines][0] < LED * shorter.fold(f64::INFINITY, f64::min);
        few && off.abs() * scale[link.lines[0] as usize] > sigma
    };
    (0..net.links.len()).filter(is_stray).collect()
}

/// By how much the second of two groups is to be moved back beside the first, heaviest first.
fn says(all: &[Across], group: &[u32], off: impl Fn(&Across) -> f64) -> Vec<([u32; 2], f64)> {
    let mut between: BTreeMap<[u32; 2], Vec<(f64, f64)>> = BTreeMap::new();
    for gap in all {
        let [a, b] = gap.lines.map(|l| group[l as usize]);
        let (key, sign) = if a < b { ([a, b], 1.0) } else { ([b, a], -1.0) };
        if a != b {
            between.entry(key).or_default().push((sign * off(gap), gap.length.recip()));
        }
    }
    let median = |mut say: Vec<(f64, f64)>| {
        say.sort_by(|a, b| a.0.total_cmp(&b.0));
        let all: f64 = say.iter().map(|s| s.1).sum();
        let mut sum = 0.0;
        let middle = say.iter().find(|s| {
            sum += s.1;
            sum >= 0.5 * all
        });
        (middle.map_or(0.0, |s| s.0), all)
    };
    let mut says: Vec<([u32; 2], f64, f64)> = between
        .into_iter()
        .map(|(key, say)| {
            let (off, weight) = median(say);
            (key, off, weight)
        })
        .collect();
    says.sort_by(|a, b| b.2.total_cmp(&a.2).then(a.0.cmp(&b.0)));
    says.into_iter().map(|(key, off, _)| (key, off)).collect()
}

/// What u of each group gains, and the groups of which each is moved beside the other, the lesser first.
fn moves(says: Vec<([u32; 2], f64)>, count: usize) -> (Vec<f64>, BTreeSet<[u32; 2]>) {
    let mut trees: Vec<(u32, f64)> = (0..count as u32).map(|g| (g, 0.0)).collect();
    let mut tied = BTreeSet::new();
    for (pair, off) in says {
        let [(a, at_a), (b, at_b)] = pair.map(|g| super::part::root(&mut trees, g));
        let (low, high, more) = match a < b {
            true => (a, b, at_a - off - at_b),
            false => (b, a, at_b + off - at_a),
        };
        if low != high {
            trees[high as usize] = (low, more);
            tied.insert(pair);
        }
    }
    ((0..count as u32).map(|g| super::part::root(&mut trees, g).1).collect(), tied)
}

#[cfg(test)]
mod tests {
    use super::super::net::{Line, Link};
    use super::*;

    #[test]
    fn a_stray_link_is_left_out_where_a_gap_contradicts_it() {
        // Two lines in two frames; the end of the first leads to the start of the second too.
        let line = |frame, first, count: u32| Line {
            frame,
            first,
            count,
            closed: false,
            length: (0..count).map(|k| 3.0 * f64::from(k)).collect(),
        };
        let link = |from: u32, to: u32, lines| Link {
            from,
            to: [to, to + 1],
            share: 0.0,
            around: false,
            lines,
            weight: 3.0,
        };
        let against = |count: u32, moved: f64| {
            let n = 21 + count;
            let lines =
                vec![line(0, 0, 21), line(0, 21, count), line(1, n, 21), line(1, n + 21, count)];
            let first = (0..20).map(|k| link(k, n + k, [0, 2]));
            let second = (0..count - 1).map(|k| link(21 + k, n + 21 + k, [1, 3]));
            let stray = link(20, n + 21, [0, 3]);
            let links: Vec<Link> = first.chain(second).chain([stray]).collect();
            let net = Net { lines, frames: vec![0, 2, 4], links, unknowns: 2 * n as usize };
            let of_frame = (0..21).chain(20..20 + count).map(f64::from);
            let mut u: Vec<f64> = of_frame.clone().chain(of_frame).map(|k| 0.3 * k).collect();
            let trust = vec![1.0; net.links.len()];
            let group = components(&net, &trust, &[0, 1, 2, 3]);
            for (line, _) in net.lines.iter().zip(&group).filter(|(_, g)| **g == 1) {
                let samples = line.first as usize..(line.first + line.count) as usize;
                u[samples].iter_mut().for_each(|u| *u += moved);
            }
            let wraps = vec![0.0; net.links.len()];
            let residual = Vec::new();
            let kept = Kept { trust, wraps, cut: 0, cut_length: 0.0, residual, u };
            let scale = vec![10.0; 4];
            let gap = |weight| Across {
                lines: [0, 1],
                unknowns: [20, 21],
                length: 30.0,
                turns: 0.0,
                weight,
            };
            let strays_by =
                |weight| strays(&net, &kept, &scale, (&group, &held(&[gap(weight)], &group), 8.0));
            // A gap that disagrees holds nothing.
            assert!(strays_by(LOOSE).is_empty());
            strays_by(UNSEEN)
        };
        assert_eq!(against(21, 30.0), [40]);
        assert!(against(21, 0.5).is_empty());
        // Of a line of four samples it is a third.
        assert!(against(4, 30.0).is_empty());
    }
}
