//! The lines of one frame for previews: what hides them is read from a depth buffer.
//!
//! A silhouette is compared with the depth a little outside of it, where its own surface is not; an
//! edge with the depths on both sides. So a frame costs one pass over vertices and faces, whatever
//! lies behind what. What it gives up: lines end to within a pixel or two instead of a tenth, parts
//! thinner than a pixel hide nothing, and where pieces pass through each other there is no line.

use crate::depth::Depth;
use crate::extract::{Lines, Moment, Stage, strokes_of};
use crate::join::Line;
use crate::path::{Kind, Path, Place};
use crate::slice::Slice;
use crate::view::View;
use crate::visibility::{Label, Run, Visible, runs};
use crate::zeroset::{ZeroSet, zero_sets};
use chiaro_basis::math::DVec2;
use rayon::prelude::*;
use std::collections::HashSet;

/// Pixels between the places that are looked at.
const SPACING: f64 = 2.0;
/// How far beside a line depths are read, pixels.
const BESIDE: f64 = 1.2;
/// How much nearer the surface beside a line must be to hide it, in sizes of a pixel there.
const SLACK: f64 = 4.0;

impl Lines {
    /// Finds the lines of a frame, visibility by a depth buffer.
    pub fn preview(stage: &Stage<'_>, moment: &Moment<'_>) -> Self {
        let Stage { surface, features, masks, knobs } = *stage;
        let view = moment.view;
        let scenery = stage.scenery(moment);
        let g = moment.posed.facing(view);
        let slice = Slice::of(surface, &g);
        let depth = Depth::of(&scenery, masks);
        let mut paths = features.paths(&scenery, &g);
        paths.extend(scenery.silhouettes(&slice, &g));
        let sets = zero_sets(&scenery, &g, knobs);
        paths.extend(sets.iter().flat_map(|set| scenery.trimmed(set)));
        paths.retain(|p| p.total() > 0.0);
        let (gap, least) = (f64::from(knobs.bridge), f64::from(knobs.shortest));
        let nothing = HashSet::new();
        let seen = |path: &Path| {
            let mut runs = runs(path, labels(path, &depth, view), gap, &nothing);
            runs.retain(|r| path.run_length(*r) >= least);
            runs
        };
        let runs: Vec<Vec<Run>> = paths.par_iter().map(seen).collect();
        let lines = runs.iter().enumerate().flat_map(|(i, r)| r.iter().map(move |r| (i, *r)));
        let lines = lines.map(|(i, run)| Line::single(i, run)).collect();
        let beside = vec![Vec::new(); paths.len()];
        let visible = Visible { lines, runs, beside, ..Visible::default() };
        let further = sets.into_iter().map(ZeroSet::further).collect();
        let (strokes, hidden, gaps, parts) = strokes_of(&paths, &visible, stage, moment);
        let whole = vec![false; paths.len()];
        Self { g, slice, further, paths, whole, visible, strokes, hidden, gaps, parts }
    }
}

/// What is seen of a path, from its first point to its last.
fn labels(path: &Path, depth: &Depth, view: &View) -> Vec<Label> {
    let segments = &path.segments;
    let mut labels = Vec::new();
    let mut start = 0;
    for end in 1..=segments.len() {
        let side = |k: usize| (segments[k].buried, segments[k].back);
        if end < segments.len() && side(end) == side(start) {
            continue;
        }
        let (from, to) = (start as f64, end as f64);
        if segments[start].buried {
            labels.push(Label { start: from, end: to, seen: false });
        } else {
            stretch(path, [from, to], depth, view, &mut labels);
        }
        start = end;
    }
    labels
}

/// Labels of a stretch that may be seen: its places vote, lone ones are overruled.
fn stretch(path: &Path, ends: [Place; 2], depth: &Depth, view: &View, labels: &mut Vec<Label>) {
    let [from, to] = ends.map(|p| path.length_at(p));
    let count = (((to - from) / SPACING).ceil() as usize).max(1);
    let at = |i: f64| path.place_at(from + (to - from) * i / count as f64);
    let votes: Vec<bool> =
        (0..count).map(|i| is_seen(path, at(i as f64 + 0.5), depth, view)).collect();
    let calm = |i: usize| {
        let [before, after] = [votes[i.saturating_sub(1)], votes[(i + 1).min(count - 1)]];
        if before == after { before } else { votes[i] }
    };
    let mut since = ends[0];
    for i in 1..count {
        if calm(i) != calm(i - 1) {
            labels.push(Label { start: since, end: at(i as f64), seen: calm(i - 1) });
            since = at(i as f64);
        }
    }
    labels.push(Label { start: since, end: ends[1], seen: calm(count - 1) });
}

/// Whether nothing nearer is beside a line at a place.
fn is_seen(path: &Path, place: Place, depth: &Depth, view: &View) -> bool {
    let k = (place as usize).min(path.segments.len() - 1);
    let (Some(a), Some(b)) = (path.seen[k], path.seen[k + 1]) else { return false };
    let t = place - k as f64;
    let (at, own) = (a.at.lerp(b.at, t), a.depth + (b.depth - a.depth) * t);
    let right = BESIDE * (b.at - a.at).normalize_or_zero().perp();
    let least = own - SLACK * view.pixel(own);
    let clear = |offset: DVec2| depth.at(at + offset) >= least;
    match path.kind {
        // The front is on the left.
        Kind::Silhouette => clear(right),
        _ => clear(right) || clear(-right),
    }
}
