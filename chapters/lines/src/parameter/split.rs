//! Cuts strokes of a film at places of its net.

use super::chart::Place;
use super::net::Net;
use crate::film::Film;
use crate::stroke::Stroke;
use std::collections::BTreeMap;

/// Pieces are no shorter than this, pixels.
const SHORTEST: f64 = 3.0;

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
    let mut rest = if stroke.closed { opened(stroke, &mut at) } else { stroke };
    let mut pieces = Vec::new();
    let mut done = 0.0;
    for cut in at {
        let here = cut - done;
        if here < SHORTEST || here > rest.total() - SHORTEST {
            continue;
        }
        let (head, tail) = parted(rest, here);
        done += head.total();
        pieces.push(head);
        rest = tail;
    }
    pieces.push(rest);
    pieces
}

/// A closed stroke opened at the first cut, from which the others are measured then.
fn opened(mut stroke: Stroke, at: &mut Vec<f64>) -> Stroke {
    let Some(first) = at.first().copied() else { return stroke };
    let total = stroke.total();
    let n = stroke.samples.len();
    let k = stroke.length.partition_point(|l| *l <= first).saturating_sub(1).min(n - 1);
    stroke.samples.rotate_left(k);
    let start = stroke.samples[0];
    stroke.samples.push(start);
    stroke.closed = false;
    let moved = stroke.length[k];
    stroke.measure();
    at.remove(0);
    at.iter_mut().for_each(|l| *l = (*l - moved).rem_euclid(total));
    at.sort_unstable_by(f64::total_cmp);
    stroke
}

/// The two parts of an open stroke, with a sample at the cut in both.
fn parted(stroke: Stroke, at: f64) -> (Stroke, Stroke) {
    let n = stroke.samples.len();
    let k = stroke.length.partition_point(|l| *l <= at).clamp(1, n - 1);
    let (a, b) = (stroke.length[k - 1], stroke.length[k]);
    let share = if b > a { (at - a) / (b - a) } else { 0.5 };
    let cut = stroke.samples[k - 1].toward(&stroke.samples[k], share);
    let mut head = stroke.clone();
    head.samples.truncate(k);
    head.samples.push(cut);
    let mut tail = stroke;
    tail.samples.drain(..k);
    tail.samples.insert(0, cut);
    head.measure();
    tail.measure();
    (head, tail)
}
