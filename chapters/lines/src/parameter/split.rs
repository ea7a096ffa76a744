//! Cuts strokes of a film at places of its net; pieces know the line that they are of ([`Stroke::body`]).

use super::chart::Place;
use super::net::Net;
use super::part::Origin;
use crate::film::Film;
use crate::stroke::{Sample, Stroke};
use std::collections::BTreeMap;

/// Pieces are no shorter than this, pixels.
const SHORTEST: f64 = 11.0;
/// What is left out on either side of a cut, so that points beside it stay on their side, pixels.
const TRIM: f64 = 0.5;
/// Samples nearer than this to an end give way to it, pixels.
const SAME: f64 = 0.05;

/// Cuts the film's strokes, which are the lines of `net`; answers how many cuts were made, and for each
/// stroke the line that it is a part of.
pub(crate) fn split(film: &mut Film, net: &Net, places: &[Place]) -> (usize, Vec<Origin>) {
    let mut by_line: BTreeMap<u32, Vec<Place>> = BTreeMap::new();
    for place in places {
        by_line.entry(place.line).or_default().push(*place);
    }
    let mut origins = Vec::with_capacity(net.lines.len());
    for (f, frame) in film.frames.iter_mut().enumerate() {
        let seen = frame.strokes.len();
        let lines = net.of_frame(f);
        for (list, offset) in [(&mut frame.strokes, 0), (&mut frame.hidden, seen)] {
            let whole = std::mem::take(list);
            let bodies = whole.iter().filter_map(|s| s.body).map(|b| b.0 + 1).max().unwrap_or(0);
            for (i, stroke) in whole.into_iter().enumerate() {
                let line = (lines.start + offset + i) as u32;
                match by_line.remove(&line) {
                    Some(at) => {
                        let body = stroke.body.or(Some((bodies + i as u32, stroke.closed)));
                        let closed = stroke.closed;
                        let mut pieces = pieces(stroke, at);
                        if pieces.len() > 1 || pieces[0].1.closed != closed {
                            pieces.iter_mut().for_each(|p| p.1.body = body);
                        }
                        for (from, piece) in pieces {
                            origins.push(Origin { line, from, turns: 0.0 });
                            list.push(piece);
                        }
                    }
                    None => {
                        origins.push(Origin { line, from: 0.0, turns: 0.0 });
                        list.push(stroke);
                    }
                }
            }
        }
    }
    (origins.len() - net.lines.len(), origins)
}

/// A stroke cut at some places, each piece with the length at which it begins; where places say so,
/// the pieces beside them take their ids.
fn pieces(stroke: Stroke, mut at: Vec<Place>) -> Vec<(f64, Stroke)> {
    at.sort_unstable_by(|a, b| a.at.total_cmp(&b.at));
    let (start, mut rest) = if stroke.closed { opened(&stroke, &mut at) } else { (0.0, stroke) };
    let mut pieces = Vec::new();
    let mut done = 0.0;
    for cut in at {
        let here = cut.at - done;
        if here < SHORTEST || here > rest.total() - SHORTEST {
            continue;
        }
        let mut before = part(&rest, 0.0, here - TRIM);
        rest = part(&rest, here + TRIM, rest.total());
        if let Some(ids) = cut.ids {
            [before.id, rest.id] = ids;
        }
        pieces.push((start + done, before));
        done = cut.at + TRIM;
    }
    pieces.push((start + done, rest));
    pieces
}

/// A closed stroke opened at the first cut, from which the others are measured then, and where that is.
fn opened(stroke: &Stroke, at: &mut Vec<Place>) -> (f64, Stroke) {
    let total = stroke.total();
    if at.is_empty() || total < 2.0 * SHORTEST {
        at.clear();
        return (0.0, stroke.clone());
    }
    let cut = at.remove(0);
    let start = (cut.at + TRIM).rem_euclid(total);
    at.iter_mut().for_each(|p| p.at = (p.at - start).rem_euclid(total));
    at.sort_unstable_by(|a, b| a.at.total_cmp(&b.at));
    let end = start - 2.0 * TRIM;
    let mut open = part(stroke, start, total + end.min(0.0));
    if end > SAME {
        open.samples.pop();
        open.samples.extend(part(stroke, 0.0, end).samples);
        open.measure();
    }
    open.id = cut.ids.map_or(open.id, |ids| ids[1]);
    (start, open)
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::path::{Kind, Path, Point, Segment};
    use crate::view::View;
    use crate::visibility::Run;
    use chiaro_basis::math::{DVec3, Vec3};
    use chiaro_scene::{Pose, Projection};

    #[test]
    fn a_loop_opens_wherever_it_is_cut() {
        let projection = Projection::Orthographic { half_height: 50.0 };
        let pose = Pose::look_at(Vec3::Z * 10.0, Vec3::ZERO, Vec3::Y, projection);
        let view = View::new(pose, (100, 100));
        let point = |k: u32| {
            let angle = std::f64::consts::TAU * f64::from(k % 16) / 16.0;
            let world = 20.0 * DVec3::new(angle.cos(), angle.sin(), 0.0);
            Point { world, next: None, pushed: world, on_chain: f64::from(k) }
        };
        let points: Vec<Point> = (0..=16).map(point).collect();
        let plain = Segment::of([0; 2]);
        let path = Path::new(Kind::Silhouette, 0, true, &points, &[plain; 16], &view, 0.0);
        let stroke = Stroke::of(&path, Run { start: 0.0, end: 16.0 }, 3.0, &view, None);
        let total = stroke.total();
        // Also where the loop begins.
        for at in [0.0, TRIM, 0.7, 2.0 * TRIM, 40.0, total - TRIM, total - 0.2] {
            let mut places = vec![Place { line: 0, at, ids: None }];
            let (start, open) = opened(&stroke, &mut places);
            let lost = total - open.total();
            assert!(!open.closed && (0.9..1.2).contains(&lost), "{at}: {lost} px are gone");
            let begin = sample_at(&stroke, start).at;
            assert!(open.samples[0].at.distance(begin) < 1e-9, "{at}");
            assert!(open.length.windows(2).all(|l| l[1] > l[0]), "{at}: no step has no length");
        }
    }
}
