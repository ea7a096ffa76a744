//! Cuts strokes of a film at places of its net.

use super::chart::Place;
use super::net::Net;
use crate::film::Film;
use crate::stroke::{Sample, Stroke};
use std::collections::BTreeMap;

/// Pieces are no shorter than this, pixels.
const SHORTEST: f64 = 11.0;
/// What is left out on either side of a cut, so that points beside it stay on their side, pixels.
const TRIM: f64 = 0.5;
/// Samples nearer than this to an end give way to it, pixels.
const SAME: f64 = 0.05;

/// Cuts the film's strokes; answers how many cuts were made. Lines of `net` are its strokes.
pub(crate) fn split(film: &mut Film, net: &Net, places: &[Place]) -> usize {
    let mut by_line: BTreeMap<u32, Vec<f64>> = BTreeMap::new();
    for place in places {
        by_line.entry(place.line).or_default().push(place.at);
    }
    let mut made = 0;
    for (f, frame) in film.frames.iter_mut().enumerate() {
        let seen = frame.strokes.len();
        let lines = net.of_frame(f);
        for (list, offset) in [(&mut frame.strokes, 0), (&mut frame.hidden, seen)] {
            let whole = std::mem::take(list);
            for (i, stroke) in whole.into_iter().enumerate() {
                let line = (lines.start + offset + i) as u32;
                match by_line.remove(&line) {
                    Some(at) => {
                        let pieces = pieces(stroke, at);
                        made += pieces.len() - 1;
                        list.extend(pieces);
                    }
                    None => list.push(stroke),
                }
            }
        }
    }
    made
}

/// A stroke cut at some lengths.
fn pieces(stroke: Stroke, mut at: Vec<f64>) -> Vec<Stroke> {
    at.sort_unstable_by(f64::total_cmp);
    let mut rest = if stroke.closed { opened(&stroke, &mut at) } else { stroke };
    let mut pieces = Vec::new();
    let mut done = 0.0;
    for cut in at {
        let here = cut - done;
        if here < SHORTEST || here > rest.total() - SHORTEST {
            continue;
        }
        pieces.push(part(&rest, 0.0, here - TRIM));
        rest = part(&rest, here + TRIM, rest.total());
        done = cut + TRIM;
    }
    pieces.push(rest);
    pieces
}

/// A closed stroke opened at the first cut, from which the others are measured then.
fn opened(stroke: &Stroke, at: &mut Vec<f64>) -> Stroke {
    let total = stroke.total();
    if at.is_empty() || total < 2.0 * SHORTEST {
        at.clear();
        return stroke.clone();
    }
    let start = at.remove(0) + TRIM;
    at.iter_mut().for_each(|l| *l = (*l - start).rem_euclid(total));
    at.sort_unstable_by(f64::total_cmp);
    let first = part(stroke, start, total);
    let mut open = part(stroke, 0.0, start - 2.0 * TRIM);
    open.samples.splice(0..0, first.samples[..first.samples.len() - 1].iter().copied());
    open.measure();
    open
}

/// The part of a stroke between two lengths, open.
fn part(stroke: &Stroke, from: f64, to: f64) -> Stroke {
    let inside = |l: &f64| *l > from + SAME && *l < to - SAME;
    let n = stroke.samples.len();
    let within = (0..n).filter(|&k| inside(&stroke.length[k])).map(|k| stroke.samples[k]);
    let ends = [from, to].map(|l| sample_at(stroke, l));
    let mut part = stroke.clone();
    part.samples = std::iter::once(ends[0]).chain(within).chain([ends[1]]).collect();
    part.closed = false;
    part.measure();
    part
}

/// The sample at a length.
fn sample_at(stroke: &Stroke, at: f64) -> Sample {
    let (s, l) = (&stroke.samples, &stroke.length);
    let k = l.partition_point(|x| *x <= at).clamp(1, l.len() - 1);
    let span = l[k] - l[k - 1];
    let share = if span > 0.0 { ((at - l[k - 1]) / span).clamp(0.0, 1.0) } else { 0.0 };
    s[k - 1].toward(&s[k % s.len()], share)
}
