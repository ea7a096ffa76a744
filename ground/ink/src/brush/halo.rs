//! [`Halos`]: haloes as geometry: ribbons parted where a nearer line interrupts them, for outlines and
//! pens. In pixels `paint` fades what is behind; here it ends where that has lost half of its ink.

use super::knob::Mark;
use super::marks::band;
use super::paint::{BEHIND, Stroke};
use super::ribbon::{Rib, Ribbon};
use super::strip::{Hit, Piece, pieces};
use chiaro_basis::math::Vec2;
use std::collections::BTreeMap;

/// Side of a cell, pixels.
const CELL: f32 = 16.0;
/// How often the place where a ribbon goes behind a halo is halved.
const HALVINGS: usize = 6;
/// What is left of a ribbon between two gaps is at least this long, pixels.
const SHORTEST: f32 = 0.5;

/// The haloes of a picture's strokes.
#[derive(Clone, Debug, Default)]
pub struct Halos {
    bands: Vec<Band>,
    cells: BTreeMap<[i32; 2], Vec<u32>>,
}

#[derive(Clone, Copy, Debug)]
struct Band {
    piece: Piece,
    halo: f32,
    /// Whether it is on the right alone.
    right: bool,
    /// Whether it is a double line.
    double: bool,
}

/// The share of a place at which a line hides what is behind it: on both sides or on its right alone, and between
/// the two lines of a double one everywhere.
pub(super) fn hides(hit: &Hit, right: bool, double: bool) -> f32 {
    let side = if right { (hit.across + 0.5).clamp(0.0, 1.0) } else { 1.0 };
    if double { side.max(hit.cover(0.0)) } else { side }
}

impl Halos {
    /// The haloes of strokes that hide others.
    pub fn of<'a>(strokes: impl Iterator<Item = Stroke<'a>>) -> Self {
        let mut halos = Self::default();
        for stroke in strokes.filter(|s| s.hides && s.brush.halo > 0.0) {
            let halo = stroke.brush.halo;
            for piece in pieces(&band(stroke.brush, stroke.spine)) {
                let double = stroke.brush.mark == Mark::Double;
                halos.add(Band { piece, halo, right: stroke.right, double });
            }
        }
        halos
    }

    fn add(&mut self, band: Band) {
        let [low, high] = band.piece.bounds(band.halo).map(cell);
        for y in low[1]..=high[1] {
            for x in low[0]..=high[0] {
                self.cells.entry([x, y]).or_default().push(self.bands.len() as u32);
            }
        }
        self.bands.push(band);
    }

    /// What is left of ribbons.
    pub fn part(&self, ribbons: Vec<Ribbon>) -> Vec<Ribbon> {
        if self.bands.is_empty() {
            return ribbons;
        }
        ribbons.into_iter().flat_map(|r| self.left(r)).collect()
    }

    fn left(&self, ribbon: Ribbon) -> Vec<Ribbon> {
        let mut ribs = ribbon.ribs.clone();
        let mut behind: Vec<bool> = ribs.iter().map(|r| self.is_behind(r.at, r.depth)).collect();
        let Some(gone) = behind.iter().position(|b| *b) else { return vec![ribbon] };
        if ribbon.closed && ribs.len() > 1 {
            // It is opened where nothing is left.
            ribs.pop();
            behind.pop();
            let gone = gone.min(ribs.len() - 1);
            ribs.rotate_left(gone);
            behind.rotate_left(gone);
            ribs.push(ribs[0]);
            behind.push(behind[0]);
        }
        let last = ribs.len() - 1;
        let runs = behind.chunk_by(|a, b| a == b).scan(0, |start, run| {
            *start += run.len();
            Some((*start - run.len(), *start - 1, run[0]))
        });
        let part = |(from, to, _): (usize, usize, bool)| {
            let before = (from > 0).then(|| self.border(ribs[from], ribs[from - 1]));
            let after = (to < last).then(|| self.border(ribs[to], ribs[to + 1]));
            let round = [from == 0 && ribbon.round[0], to == last && ribbon.round[1]];
            let ribs = before.into_iter().chain(ribs[from..=to].iter().copied()).chain(after);
            Ribbon { ribs: apart(ribs), closed: false, round, ..ribbon }
        };
        runs.filter(|run| !run.2).map(part).filter(is_seen).collect()
    }

    /// The last place that is left from one that is to one that is not.
    fn border(&self, mut left: Rib, mut gone: Rib) -> Rib {
        for _ in 0..HALVINGS {
            let middle = between(left, gone);
            if self.is_behind(middle.at, middle.depth) { gone = middle } else { left = middle }
        }
        left
    }

    /// Whether a place of a line has lost half of its ink.
    pub(super) fn is_behind(&self, at: Vec2, depth: f32) -> bool {
        let near = self.cells.get(&cell(at));
        near.into_iter().flatten().any(|i| {
            let band = &self.bands[*i as usize];
            let Some(hit) = band.piece.hit(at, band.halo) else { return false };
            let side = hides(&hit, band.right, band.double);
            side.min(hit.cover(band.halo)) > 0.5 && depth - hit.depth > 1.5 * BEHIND
        })
    }
}

fn cell(at: Vec2) -> [i32; 2] {
    (at / CELL).floor().as_ivec2().to_array()
}

fn between(a: Rib, b: Rib) -> Rib {
    Rib {
        at: 0.5 * (a.at + b.at),
        half: 0.5 * (a.half + b.half),
        u: 0.5 * (a.u + b.u),
        depth: 0.5 * (a.depth + b.depth),
    }
}

/// Ribs without those that stand where the one before does.
fn apart(ribs: impl Iterator<Item = Rib>) -> Vec<Rib> {
    let mut kept: Vec<Rib> = ribs.collect();
    kept.dedup_by(|b, a| a.at.distance_squared(b.at) < 1e-4);
    kept
}

/// Whether a part is long enough, or the dot that it was.
fn is_seen(part: &Ribbon) -> bool {
    let length: f32 = part.ribs.windows(2).map(|w| w[0].at.distance(w[1].at)).sum();
    length >= SHORTEST || part.round == [true; 2]
}

#[cfg(test)]
mod tests {
    use super::super::{Axis, Brush, Knot, Mark, Spine, ribbons};
    use super::*;

    fn spine(from: Vec2, to: Vec2, depth: f32) -> Spine {
        let knot = |i: usize| {
            let t = i as f32 / 40.0;
            Knot { at: from.lerp(to, t), u: f64::from(100.0 * t), depth }
        };
        Spine::new((0..=40).map(knot).collect(), false, Axis { seed: 1, period: None })
    }

    fn halos(brush: &Brush, spine: &Spine) -> Halos {
        let (texture, colour) = (None, [0.0, 0.0, 0.0, 1.0]);
        let stroke = Stroke { spine, brush, texture, colour, hides: true, right: false };
        Halos::of(std::iter::once(stroke))
    }

    #[test]
    fn far_lines_end_before_near_ones() {
        let near = spine(Vec2::new(50.0, 0.0), Vec2::new(50.0, 100.0), 10.0);
        let far = spine(Vec2::new(0.0, 50.0), Vec2::new(100.0, 50.0), 200.0);
        for mark in [Mark::Line, Mark::Double] {
            let brush = Brush { mark, halo: 4.0, width: 2.0, gap: 3.0, ..Brush::default() };
            let halos = halos(&brush, &near);
            let all = ribbons(&brush, &far);
            let left = halos.part(all.clone());
            assert_eq!(left.len(), 2 * all.len());
            // Half of what the mark covers, and the halo.
            let reach = if mark == Mark::Double { 6.5 } else { 5.0 };
            for pair in left.chunks(2) {
                let ends = [pair[0].ribs.last().unwrap().at.x, pair[1].ribs[0].at.x];
                let off = [ends[0] - 50.0 + reach, ends[1] - 50.0 - reach];
                assert!(off.iter().all(|o| o.abs() < 0.1), "{ends:?}");
                assert_eq!([pair[0].round, pair[1].round], [[true, false], [false, true]]);
            }
            assert_eq!(halos.part(ribbons(&brush, &near)), ribbons(&brush, &near));
        }
    }

    #[test]
    fn nothing_shows_between_the_two_lines_of_an_outline() {
        let near = spine(Vec2::new(50.0, 0.0), Vec2::new(50.0, 100.0), 10.0);
        let far = spine(Vec2::new(0.0, 50.0), Vec2::new(100.0, 50.0), 200.0);
        let brush =
            Brush { mark: Mark::Double, halo: 4.0, width: 2.0, gap: 14.0, ..Brush::default() };
        let (texture, colour) = (None, [0.0, 0.0, 0.0, 1.0]);
        let outline =
            Stroke { spine: &near, brush: &brush, texture, colour, hides: true, right: true };
        let halos = Halos::of(std::iter::once(outline));
        let mut ends: Vec<f32> = halos
            .part(ribbons(&Brush { mark: Mark::Line, ..brush }, &far))
            .iter()
            .flat_map(|r| [r.ribs[0].at.x, r.ribs[r.ribs.len() - 1].at.x])
            .collect();
        ends.sort_by(f32::total_cmp);
        // The line and half of the gap on one side, the halo as well on the other.
        let found = [50.0 - ends[1], ends[2] - 50.0];
        let (low, high) = (found[0].min(found[1]), found[0].max(found[1]));
        assert!((low - 8.0).abs() < 0.1 && (high - 12.0).abs() < 0.1, "{ends:?}");
    }

    #[test]
    fn a_ring_opens_behind_a_bar() {
        let brush = Brush { halo: 3.0, width: 2.0, ..Brush::default() };
        let bar = spine(Vec2::new(0.0, 50.0), Vec2::new(100.0, 50.0), 10.0);
        let knot = |i: usize| {
            let a = std::f32::consts::TAU * i as f32 / 90.0;
            Knot { at: 50.0 + 30.0 * Vec2::from_angle(a), u: 2.0 * i as f64, depth: 90.0 }
        };
        let axis = Axis { seed: 2, period: Some(180.0) };
        let ring = Spine::new((0..=90).map(knot).collect(), true, axis);
        let left = halos(&brush, &bar).part(ribbons(&brush, &ring));
        assert_eq!(left.len(), 2);
        assert!(
            left.iter().all(|r| !r.closed && r.ribs.iter().all(|r| (r.at.y - 50.0).abs() > 3.9))
        );
    }
}
