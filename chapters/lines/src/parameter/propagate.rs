//! The baseline of frame-to-frame propagation, in the manner of Kalnins et al. (2003).
//!
//! Every sample votes, at the place where its material point is one frame later, for its stroke and
//! its u. A line goes on with the stroke that most of its length votes for; where a stretch of it
//! votes for another one that disagrees, the line is split. u of each piece is fitted to its votes, by
//! the same energies as the global solution, with no future in it; a line that closes goes on with as much u around.

use super::fit::Fit;
use super::near::Near;
use super::net::{landing, strokes};
use super::{Solved, Weights};
use crate::film::{Film, FilmFrame};
use crate::knob::LinesKnobs;
use crate::stroke::Stroke;
use std::collections::{BTreeMap, BTreeSet};
use std::f64::consts::TAU;

/// A stretch that votes for another stroke is split off from this length on, pixels.
const SPLIT: f64 = 15.0;
/// A line that closes begins anew beyond this stretch, octaves.
const STRETCH: f64 = 0.5;

/// A sample's word on where its stroke goes on.
#[derive(Clone, Copy)]
struct Vote {
    id: u32,
    /// Sample of the line before the place, and the share of the way to the next.
    at: (usize, f64),
    /// Picture length there.
    length: f64,
    /// u in pixels.
    u: f64,
    /// Once round in u, where its stroke closes, pixels.
    turn: Option<f64>,
    weight: f64,
}

/// Parameterizes a film, one frame after the other.
pub(crate) fn film(film: &mut Film, knobs: &LinesKnobs) -> Solved {
    let scale = f64::from(knobs.pattern_length);
    let mut fresh = film.frames.iter().flat_map(strokes).map(|s| s.id + 1).max().unwrap_or(0);
    let mut solved = Solved::default();
    for f in 0..film.frames.len() {
        let (before, rest) = film.frames.split_at_mut(f);
        let here = &mut rest[0];
        let last = before.last().filter(|_| !here.begins);
        let votes = last.map_or_else(Vec::new, |b| votes(b, here));
        solved.links += votes.iter().map(Vec::len).sum::<usize>();
        let mut votes = votes.into_iter();
        let mut taken = BTreeSet::new();
        for list in [&mut here.strokes, &mut here.hidden] {
            let whole = std::mem::take(list);
            for stroke in whole {
                let own = votes.next().unwrap_or_default();
                for (mut piece, own) in pieces(stroke, own, f64::from(knobs.sliding_limit)) {
                    fit(&mut piece, &own, scale, &Weights::of(knobs));
                    solved.unknowns += piece.samples.len();
                    piece.id = name(&piece, &own, &mut taken, &mut fresh, last.is_some());
                    list.push(piece);
                }
            }
        }
    }
    solved
}

/// Votes on each stroke of a frame, by place along it.
fn votes(before: &FilmFrame, here: &FilmFrame) -> Vec<Vec<Vote>> {
    let there: Vec<&Stroke> = strokes(here).collect();
    let near = Near::of(there.iter().copied(), &here.view);
    let mut votes = vec![Vec::new(); there.len()];
    for stroke in strokes(before) {
        for j in 0..stroke.samples.len() {
            let Some(hit) = landing(stroke, j, here, &there, &near) else { continue };
            let index = hit.segment.stroke as usize;
            let (k, l) = (hit.segment.first as usize, &there[index].length);
            votes[index].push(Vote {
                id: stroke.id,
                at: (k, hit.share),
                length: l[k] + (l[k + 1] - l[k]) * hit.share,
                u: stroke.u[j] * stroke.pixels_per_u,
                turn: stroke.u_period.map(|turn| turn * stroke.pixels_per_u),
                weight: stroke.total() / stroke.samples.len() as f64,
            });
        }
    }
    votes.iter_mut().for_each(|v| v.sort_by(|a, b| a.length.total_cmp(&b.length)));
    votes
}

/// The id that most of the length votes for.
fn winner(votes: &[Vote]) -> Option<u32> {
    let mut sums = BTreeMap::new();
    votes.iter().for_each(|v| *sums.entry(v.id).or_insert(0.0) += v.weight);
    sums.into_iter().max_by(|a, b| a.1.total_cmp(&b.1).then(b.0.cmp(&a.0))).map(|s| s.0)
}

/// Splits a stroke where its votes change their mind for long.
fn pieces(stroke: Stroke, votes: Vec<Vote>, sigma: f64) -> Vec<(Stroke, Vec<Vote>)> {
    let runs = runs(&votes, sigma);
    if runs.len() < 2 || stroke.closed {
        return vec![(stroke, votes)];
    }
    let length = stroke.length.clone();
    let mut pieces = Vec::new();
    let (mut rest, mut votes, mut first) = (stroke, votes, 0);
    for pair in runs.windows(2) {
        // Between the last vote of one run and the first of the next.
        let cut = 0.5 * (pair[0].to + pair[1].from);
        let k = length.partition_point(|l| *l <= cut).saturating_sub(first);
        if k < 1 || k + 1 >= rest.samples.len() {
            continue;
        }
        let mut head = rest.clone();
        head.samples.truncate(k + 1);
        rest.samples.drain(..k);
        head.measure();
        rest.measure();
        let (own, mut others): (Vec<Vote>, Vec<Vote>) = votes.into_iter().partition(|v| v.at.0 < k);
        others.iter_mut().for_each(|v| v.at.0 -= k);
        votes = others;
        first += k;
        pieces.push((head, own));
    }
    pieces.push((rest, votes));
    pieces
}

/// Neighbouring votes for one stroke.
struct Run {
    from: f64,
    to: f64,
    id: u32,
    /// u where the line begins, as the first of them says.
    offset: f64,
}

/// Long runs of votes that disagree with those before them.
fn runs(votes: &[Vote], sigma: f64) -> Vec<Run> {
    let mut runs: Vec<Run> = Vec::new();
    for v in votes {
        match runs.last_mut() {
            Some(run) if run.id == v.id => run.to = v.length,
            _ => runs.push(Run { from: v.length, to: v.length, id: v.id, offset: v.u - v.length }),
        }
    }
    let mut kept: Vec<Run> = Vec::new();
    for run in runs.into_iter().filter(|r| r.to - r.from >= SPLIT) {
        match kept.last_mut() {
            Some(last) if last.id == run.id || (last.offset - run.offset).abs() <= sigma => {
                last.to = run.to;
            }
            _ => kept.push(run),
        }
    }
    kept
}

/// Fits u to the votes of the winning stroke.
fn fit(stroke: &mut Stroke, votes: &[Vote], scale: f64, weights: &Weights) {
    let id = winner(votes);
    let mut votes: Vec<Vote> = votes.iter().copied().filter(|v| Some(v.id) == id).collect();
    let total = stroke.total();
    let turn = turn(&votes, total, scale);
    if stroke.closed {
        unwind(&mut votes, total, turn);
    }
    let mut fit = Fit::new(stroke.length.len());
    for (k, l) in stroke.length.windows(2).enumerate() {
        let ds = (l[1] - l[0]).max(1e-3);
        fit.step(k, ds, weights.distortion / ds);
    }
    for v in &votes {
        fit.value(v.at.0, v.at.1, v.u, weights.projection * v.weight);
    }
    fit.value(0, 0.0, 0.0, 1e-9);
    let mut u = fit.solve();
    if stroke.closed && total > 0.0 {
        let around = u[u.len() - 1] - u[0];
        let rest = if fits(around, total) { 0.0 } else { turn - around };
        u.iter_mut().zip(&stroke.length).for_each(|(u, l)| *u += rest * l / total);
    }
    stroke.set_u(u.into_iter().map(|u| u / scale).collect(), scale);
}

/// Once round in u of a line that closes: what most votes have, unless that is too far from its length, else whole
/// patterns.
fn turn(votes: &[Vote], total: f64, scale: f64) -> f64 {
    let mut sums: BTreeMap<u64, f64> = BTreeMap::new();
    for v in votes {
        let turn = v.turn.filter(|turn| fits(*turn, total));
        turn.into_iter().for_each(|turn| *sums.entry(turn.to_bits()).or_insert(0.0) += v.weight);
    }
    let most = sums.into_iter().max_by(|a, b| a.1.total_cmp(&b.1));
    most.map_or((total / scale).round().max(1.0) * scale, |s| f64::from_bits(s.0))
}

/// Whether so many pixels of u stretch no more than they may along a line that closes.
fn fits(u: f64, total: f64) -> bool {
    u > 0.0 && (u / total).log2().abs() <= STRETCH
}

/// Moves the votes on a line that closes by whole turns, to where u rises by one `turn` along it: else those before
/// and after the seam contradict each other, and are met by a loop of hardly any u.
fn unwind(votes: &mut [Vote], total: f64, turn: f64) {
    let of = |v: &Vote| v.turn.unwrap_or(turn).max(f64::MIN_POSITIVE);
    let rest = |v: &Vote| v.u - turn * v.length / total.max(f64::MIN_POSITIVE);
    let (mut sine, mut cosine) = (0.0, 0.0);
    for v in votes.iter() {
        let (s, c) = (TAU * rest(v) / of(v)).sin_cos();
        sine += v.weight * s;
        cosine += v.weight * c;
    }
    let mean = f64::atan2(sine, cosine) / TAU;
    for v in votes {
        v.u -= (rest(v) / of(v) - mean).round() * of(v);
    }
}

/// The id of the stroke that goes on, unless another line of the frame has it.
fn name(
    stroke: &Stroke,
    votes: &[Vote],
    taken: &mut BTreeSet<u32>,
    fresh: &mut u32,
    goes_on: bool,
) -> u32 {
    let wanted = if goes_on { winner(votes) } else { Some(stroke.id) };
    match wanted.filter(|id| taken.insert(*id)) {
        Some(id) => id,
        None => {
            *fresh += 1;
            taken.insert(*fresh - 1);
            *fresh - 1
        }
    }
}
