//! Seams of closed lines: where they begin and end, the same through the film.
//!
//! A loop's first sample is moved to where the seam of the frame before went: its material point, on
//! the nearest segment. The first seam of a loop lies at its sharpest turn. So a seam never drifts
//! along its line, and what repeats a whole number of times between seam and seam never jumps.

use super::near::Near;
use super::net::{landing, strokes};
use crate::film::{Film, FilmFrame};
use crate::stroke::Stroke;
use std::collections::BTreeMap;

/// Samples nearer than this share of a segment to the seam become the seam.
const AT_SAMPLE: f64 = 0.05;

/// Carries the seams of closed lines through a film; samples move along with them.
pub(crate) fn carry(film: &mut Film) {
    for f in 0..film.frames.len() {
        let (before, rest) = film.frames.split_at_mut(f);
        let here = &mut rest[0];
        let landed = match before.last() {
            Some(before) if !here.begins => landings(before, here),
            _ => BTreeMap::new(),
        };
        let all = here.strokes.iter_mut().chain(&mut here.hidden).enumerate();
        for (i, stroke) in all.filter(|(_, s)| s.closed && s.samples.len() > 2) {
            let (k, share) = landed.get(&i).copied().unwrap_or_else(|| (sharpest(stroke), 0.0));
            begin_at(stroke, k, share);
        }
    }
}

/// For closed strokes of a frame: where the first sample of a stroke before went.
fn landings(before: &FilmFrame, here: &FilmFrame) -> BTreeMap<usize, (usize, f64)> {
    let there: Vec<&Stroke> = strokes(here).collect();
    let mut found = BTreeMap::new();
    if there.iter().all(|s| !s.closed) {
        return found;
    }
    let near = Near::of(there.iter().copied(), &here.view);
    for stroke in strokes(before).filter(|s| !s.samples.is_empty()) {
        if let Some(hit) = landing(stroke, 0, here, &there, &near) {
            let place = (hit.segment.first as usize, hit.share);
            let index = hit.segment.stroke as usize;
            // A loop leads before a stretch of one.
            if stroke.closed || !found.contains_key(&index) {
                found.insert(index, place);
            }
        }
    }
    found
}

/// The sample at which a closed stroke turns most.
fn sharpest(stroke: &Stroke) -> usize {
    let s = &stroke.samples;
    let n = s.len();
    let turn = |i: usize| {
        let (a, b) = (s[i].at - s[(i + n - 1) % n].at, s[(i + 1) % n].at - s[i].at);
        // Tenths of radians: smooth loops begin at their first sample.
        (10.0 * a.angle_to(b).abs()) as u32
    };
    (0..n).max_by_key(|&i| (turn(i), std::cmp::Reverse(i))).unwrap_or(0)
}

/// Makes a closed stroke begin at a share of the segment after sample `k`.
fn begin_at(stroke: &mut Stroke, k: usize, share: f64) {
    let s = &mut stroke.samples;
    let n = s.len();
    let next = (k + 1) % n;
    if share > AT_SAMPLE && share < 1.0 - AT_SAMPLE {
        let seam = s[k].toward(&s[next], share);
        s.rotate_left(next);
        s.insert(0, seam);
    } else {
        s.rotate_left(if share < 0.5 { k } else { next });
    }
    stroke.measure();
}
