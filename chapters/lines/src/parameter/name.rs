//! Names: ids of strokes after they were cut and linked.
//!
//! A line keeps its id along the links that its texture follows: first where two lines are each
//! other's best, then where one is a part of the other, heaviest first; what was one line before it
//! was hidden comes last. Never two lines of one frame unless they are parts of one chain.

use super::net::{Net, strokes};
use crate::film::Film;
use crate::path::Kind;
use crate::track::Groups;
use std::collections::BTreeMap;

/// Links from one line to another.
struct Bundle {
    lines: [u32; 2],
    weight: f64,
    mutual: bool,
}

/// Gives the strokes of a film ids that follow the links that are trusted.
pub(crate) fn rename(film: &mut Film, net: &Net, trust: &[f64]) {
    let (mut frames, mut chains, mut old) = (Vec::new(), Vec::new(), Vec::new());
    for (f, frame) in film.frames.iter().enumerate() {
        for s in strokes(frame) {
            frames.push(f as u32);
            chains.push(s.chain * Kind::ALL.len() as u32 + s.kind as u32);
            old.push(s.id);
        }
    }
    let mut groups = Groups::of(&frames, &chains);
    for bundle in bundles(net, trust) {
        groups.join(bundle.lines[0], bundle.lines[1]);
    }
    let mut seen: BTreeMap<u32, u32> = BTreeMap::new();
    for (line, id) in old.iter().enumerate() {
        if let Some(before) = seen.insert(*id, line as u32) {
            groups.join(before, line as u32);
        }
    }
    let mut names: BTreeMap<u32, u32> = BTreeMap::new();
    let mut line = 0;
    for frame in &mut film.frames {
        for stroke in frame.strokes.iter_mut().chain(&mut frame.hidden) {
            let count = names.len() as u32;
            stroke.id = *names.entry(groups.root(line)).or_insert(count);
            line += 1;
        }
    }
    film.settle_events();
}

/// Bundles of trusted links in the order in which they join: mutual ones first, then by weight.
fn bundles(net: &Net, trust: &[f64]) -> Vec<Bundle> {
    let mut weights: BTreeMap<[u32; 2], f64> = BTreeMap::new();
    for (link, trust) in net.links.iter().zip(trust) {
        *weights.entry(link.lines).or_insert(0.0) += trust * link.weight;
    }
    let mut best: [BTreeMap<u32, (f64, u32)>; 2] = [BTreeMap::new(), BTreeMap::new()];
    for (lines, weight) in &weights {
        for side in [0, 1] {
            let entry = best[side].entry(lines[side]).or_insert((0.0, u32::MAX));
            if *weight > entry.0 {
                *entry = (*weight, lines[1 - side]);
            }
        }
    }
    let is_best = |lines: &[u32; 2], side: usize| best[side][&lines[side]].1 == lines[1 - side];
    let mut bundles: Vec<Bundle> = weights
        .iter()
        .filter(|(_, weight)| **weight > 0.0)
        .map(|(lines, weight)| Bundle {
            lines: *lines,
            weight: *weight,
            mutual: is_best(lines, 0) && is_best(lines, 1),
        })
        .collect();
    bundles.sort_by(|a, b| {
        b.mutual.cmp(&a.mutual).then(b.weight.total_cmp(&a.weight)).then(a.lines.cmp(&b.lines))
    });
    bundles
}
