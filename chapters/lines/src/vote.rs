//! The simple construction of section 4.5.1: lines of two frames are paired by votes in the picture.
//!
//! It asks nothing of the mesh but its lines in each frame, so it serves meshes that are made anew
//! in every frame. Every sample votes for the nearest stroke of its kind in the other frame.

use crate::path::Kind;
use crate::stroke::{Sample, Stroke};
use crate::view::View;
use std::collections::BTreeMap;

/// A vote reaches this far, in parts of the picture's height.
const REACH: f64 = 0.05;

/// Pairs of strokes of two frames with the length that voted for them, both ways; of those kinds
/// alone that `counts` admits.
pub(crate) fn votes(
    [before, after]: [&Vec<Stroke>; 2],
    counts: impl Fn(Kind) -> bool,
    view: &View,
) -> Vec<(usize, usize, f64)> {
    let reach = REACH * view.size.1 as f64;
    let mut pairs = BTreeMap::new();
    for (a, b, weight) in one_way(before, after, &counts, reach) {
        *pairs.entry((a, b)).or_insert(0.0) += weight;
    }
    for (b, a, weight) in one_way(after, before, &counts, reach) {
        *pairs.entry((a, b)).or_insert(0.0) += weight;
    }
    pairs.into_iter().map(|((a, b), w)| (a, b, w)).collect()
}

fn one_way(
    from: &[Stroke],
    to: &[Stroke],
    counts: &impl Fn(Kind) -> bool,
    reach: f64,
) -> Vec<(usize, usize, f64)> {
    let mut votes = Vec::new();
    for (i, stroke) in from.iter().enumerate().filter(|(_, s)| counts(s.kind)) {
        let weight = stroke.total() / stroke.samples.len() as f64;
        for sample in &stroke.samples {
            if let Some(j) = nearest(sample, stroke, to, reach) {
                votes.push((i, j, weight));
            }
        }
    }
    votes
}

fn nearest(sample: &Sample, of: &Stroke, strokes: &[Stroke], reach: f64) -> Option<usize> {
    let all = strokes.iter().enumerate().filter(|(_, s)| s.kind == of.kind);
    let distances =
        all.flat_map(|(j, s)| s.samples.iter().map(move |p| (p.at.distance(sample.at), j)));
    let best = distances.min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)))?;
    (best.0 < reach).then_some(best.1)
}
