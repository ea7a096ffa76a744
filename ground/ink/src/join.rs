//! Joining: lines that break off and go on a little farther in the same direction become one.
//!
//! Features near the limit of a pixel are found in some rows and missed in others, which draws
//! dashes. Two free ends are joined when each lies ahead of the other, nearest pairs first. An end
//! at which other lines end too is a junction, and not free.

use crate::Polyline;
use std::collections::BTreeMap;

/// The cosine of how far a gap may turn from the line that it goes on from.
const AHEAD: f32 = 0.82;

/// How far from its end a line's direction is taken, in pixels.
const BACK: f32 = 4.0;

/// A line and the length that speaks for it, in pixels: its own, and that of what it is connected
/// with.
pub(crate) struct Piece {
    pub(crate) line: Polyline,
    pub(crate) length: f32,
}

/// The end of an open line.
#[derive(Clone, Copy)]
struct End {
    piece: usize,
    at_start: bool,
    point: [f32; 2],
    /// Unit vector out of the line.
    outward: [f32; 2],
}

/// Lines with gaps of at most `gap` pixels closed.
pub(crate) fn joined(pieces: Vec<Piece>, gap: f32) -> Vec<Piece> {
    let ends = free_ends(&pieces);
    let pairs = pairs(&ends, gap);
    let mut partner: Vec<Option<usize>> = vec![None; ends.len()];
    for (_, a, b) in pairs {
        let is_ring = ends[a].piece == ends[b].piece;
        if partner[a].is_none() && partner[b].is_none() && !is_ring {
            (partner[a], partner[b]) = (Some(b), Some(a));
        }
    }
    chain(pieces, &ends, &partner)
}

fn free_ends(pieces: &[Piece]) -> Vec<End> {
    let mut ends = Vec::new();
    let mut users: BTreeMap<[u32; 2], usize> = BTreeMap::new();
    for (i, piece) in pieces.iter().enumerate() {
        let p = &piece.line.points;
        if piece.line.closed || p.len() < 2 {
            continue;
        }
        for at_start in [true, false] {
            let inward: Vec<[f32; 2]> = match at_start {
                true => p.clone(),
                false => p.iter().rev().copied().collect(),
            };
            let point = inward[0];
            let away = |q: &&[f32; 2]| (q[0] - point[0]).hypot(q[1] - point[1]) >= BACK;
            let inner = *inward.iter().find(away).unwrap_or(&inward[inward.len() - 1]);
            *users.entry(point.map(f32::to_bits)).or_default() += 1;
            if let Some(outward) = unit(inner, point) {
                ends.push(End { piece: i, at_start, point, outward });
            }
        }
    }
    ends.retain(|e| users[&e.point.map(f32::to_bits)] == 1);
    ends
}

/// Unit vector from `a` to `b`, if they differ.
fn unit(a: [f32; 2], b: [f32; 2]) -> Option<[f32; 2]> {
    let (x, y) = (b[0] - a[0], b[1] - a[1]);
    let length = x.hypot(y);
    (length > 0.0).then(|| [x / length, y / length])
}

/// Pairs of ends that lie ahead of each other: squared distance and indices, nearest first.
fn pairs(ends: &[End], gap: f32) -> Vec<(f32, usize, usize)> {
    let cell = |p: [f32; 2]| p.map(|c| (c / gap.max(1.0)).floor() as i64);
    let mut cells: BTreeMap<[i64; 2], Vec<usize>> = BTreeMap::new();
    for (i, e) in ends.iter().enumerate() {
        cells.entry(cell(e.point)).or_default().push(i);
    }
    let mut pairs = Vec::new();
    for (a, e) in ends.iter().enumerate() {
        let [cx, cy] = cell(e.point);
        let around = (-1..=1).flat_map(|dy| (-1..=1).map(move |dx| [cx + dx, cy + dy]));
        for &b in around.filter_map(|c| cells.get(&c)).flatten().filter(|b| **b > a) {
            let f = &ends[b];
            let Some(way) = unit(e.point, f.point) else { continue };
            let distance = (f.point[0] - e.point[0]).hypot(f.point[1] - e.point[1]);
            let ahead = dot(e.outward, way) > AHEAD && -dot(f.outward, way) > AHEAD;
            if distance <= gap && ahead {
                pairs.push((distance, a, b));
            }
        }
    }
    pairs.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)).then(a.2.cmp(&b.2)));
    pairs
}

fn dot(a: [f32; 2], b: [f32; 2]) -> f32 {
    a[0] * b[0] + a[1] * b[1]
}

/// Walks along partners from every end that has none, then around rings.
fn chain(pieces: Vec<Piece>, ends: &[End], partner: &[Option<usize>]) -> Vec<Piece> {
    let mut end_of: BTreeMap<(usize, bool), usize> = BTreeMap::new();
    for (i, e) in ends.iter().enumerate() {
        end_of.insert((e.piece, e.at_start), i);
    }
    let next = |piece: usize, at_start: bool| {
        let end = end_of.get(&(piece, at_start))?;
        partner[*end].map(|p| (ends[p].piece, ends[p].at_start))
    };
    let mut done = vec![false; pieces.len()];
    let mut lines = Vec::new();
    let starts = (0..pieces.len()).flat_map(|i| [(i, true), (i, false)]);
    let loose: Vec<(usize, bool)> = starts.filter(|&(i, s)| next(i, s).is_none()).collect();
    for (first, enter) in loose.into_iter().chain((0..pieces.len()).map(|i| (i, true))) {
        let mut whole: Option<Piece> = None;
        let mut at = Some((first, enter));
        while let Some((i, at_start)) = at.filter(|(i, _)| !done[*i]) {
            done[i] = true;
            append(&mut whole, &pieces[i], at_start);
            at = next(i, !at_start);
        }
        lines.extend(whole);
    }
    lines
}

/// Adds a piece, from its start or from its end.
fn append(whole: &mut Option<Piece>, piece: &Piece, from_start: bool) {
    let mut points = piece.line.points.clone();
    if !from_start {
        points.reverse();
    }
    match whole {
        None => {
            let line = Polyline { points, closed: piece.line.closed };
            *whole = Some(Piece { line, length: piece.length });
        }
        Some(w) => {
            w.line.points.extend(points);
            w.length += piece.length;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn piece(points: &[[f32; 2]]) -> Piece {
        let line = Polyline { points: points.to_vec(), closed: false };
        Piece { length: points.len() as f32 - 1.0, line }
    }

    #[test]
    fn dashes_on_a_line_become_one_line() {
        let dash = |x: f32| piece(&[[x, 5.0], [x + 2.0, 5.2], [x + 4.0, 5.0]]);
        let mut dashes: Vec<Piece> = (0..5).map(|i| dash(10.0 * i as f32)).collect();
        dashes[2].line.points.reverse();
        let lines = joined(dashes, 8.0);
        assert_eq!(lines.len(), 1);
        assert_eq!(lines[0].length, 10.0);
        let x: Vec<f32> = lines[0].line.points.iter().map(|p| p[0]).collect();
        assert!(x.is_sorted() || x.iter().rev().is_sorted(), "{x:?}");
    }

    #[test]
    fn what_lies_beside_or_far_off_stays_apart() {
        let parallel = vec![piece(&[[0.0, 0.0], [9.0, 0.0]]), piece(&[[0.0, 3.0], [9.0, 3.0]])];
        assert_eq!(joined(parallel, 8.0).len(), 2);
        let far = vec![piece(&[[0.0, 0.0], [9.0, 0.0]]), piece(&[[30.0, 0.0], [39.0, 0.0]])];
        assert_eq!(joined(far, 8.0).len(), 2);
    }

    #[test]
    fn junctions_are_left_alone() {
        let star: Vec<Piece> = [[9.0, 0.0], [-9.0, 0.5], [0.0, 9.0]]
            .iter()
            .map(|&end| piece(&[[0.0, 0.0], end]))
            .chain([piece(&[[12.0, 0.0], [20.0, 0.0]])])
            .collect();
        let lines = joined(star, 8.0);
        assert_eq!(lines.len(), 3, "one arm goes on, three meet");
    }
}
