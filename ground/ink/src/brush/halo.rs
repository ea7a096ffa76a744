//! [`Halos`]: haloes as geometry: ribbons parted where a nearer line interrupts them, for outlines and
//! pens. In pixels `paint` fades what is behind; here it ends where that has lost half of its ink.

use super::marks::band;
use super::paint::{BEHIND, Stroke};
use super::ribbon::{Rib, Ribbon};
use super::strip::{Piece, pieces};
use chiaro_basis::math::Vec2;
use std::collections::BTreeMap;

/// Side of a cell, pixels.
const CELL: f32 = 32.0;
/// How often the place where a ribbon goes behind a halo is halved.
const HALVINGS: usize = 5;

/// The haloes of a picture's strokes.
#[derive(Clone, Debug, Default)]
pub struct Halos {
    pieces: Vec<Band>,
    cells: BTreeMap<[i32; 2], Vec<u32>>,
}

#[derive(Clone, Copy, Debug)]
struct Band {
    piece: Piece,
    halo: f32,
    /// Whether it is on the right alone.
    right: bool,
}

impl Halos {
    /// The haloes of strokes that hide others.
    pub fn of<'a>(strokes: impl Iterator<Item = Stroke<'a>>) -> Self {
        let mut halos = Self::default();
        for stroke in strokes.filter(|s| s.hides && s.brush.halo > 0.0) {
            let halo = stroke.brush.halo;
            for piece in pieces(&band(stroke.brush, stroke.spine)) {
                halos.add(Band { piece, halo, right: stroke.right });
            }
        }
        halos
    }

    fn add(&mut self, band: Band) {
        let [low, high] = band.piece.bounds(band.halo).map(cell);
        for y in low[1]..=high[1] {
            for x in low[0]..=high[0] {
                self.cells.entry([x, y]).or_default().push(self.pieces.len() as u32);
            }
        }
        self.pieces.push(band);
    }

    /// What is left of ribbons. What erases stays whole: it takes from what is left.
    pub fn part(&self, ribbons: Vec<Ribbon>) -> Vec<Ribbon> {
        if self.pieces.is_empty() {
            return ribbons;
        }
        ribbons.into_iter().flat_map(|r| if r.erases { vec![r] } else { self.left(r) }).collect()
    }

    fn left(&self, ribbon: Ribbon) -> Vec<Ribbon> {
        let behind: Vec<bool> = ribbon.ribs.iter().map(|r| self.is_behind(r)).collect();
        if behind.iter().all(|b| !b) {
            return vec![ribbon];
        }
        let (mut ribs, mut behind) = (ribbon.ribs.clone(), behind);
        if let (true, Some(start)) = (ribbon.closed, behind.iter().position(|b| *b)) {
            // It is opened where nothing is left.
            ribs.pop();
            behind.pop();
            let start = start.min(ribs.len() - 1);
            ribs.rotate_left(start);
            behind.rotate_left(start);
        }
        let mut left: Vec<Vec<Rib>> = Vec::new();
        for (k, rib) in ribs.iter().enumerate() {
            let before = k.checked_sub(1).map(|b| (behind[b], ribs[b]));
            match (before, behind[k]) {
                (Some((false, last)), true) => {
                    left.last_mut().expect("it began").push(self.border(last, *rib));
                }
                (Some((true, last)), false) => left.push(vec![self.border(*rib, last), *rib]),
                (None, false) => left.push(vec![*rib]),
                (Some((false, _)), false) => left.last_mut().expect("it began").push(*rib),
                (_, true) => {}
            }
        }
        let part = |ribs| Ribbon { ribs, closed: false, round: false, ..ribbon };
        left.into_iter().filter(|ribs| ribs.len() > 1).map(part).collect()
    }

    /// The last place that is left from one that is to one that is not.
    fn border(&self, mut left: Rib, mut gone: Rib) -> Rib {
        for _ in 0..HALVINGS {
            let middle = between(left, gone);
            if self.is_behind(&middle) { gone = middle } else { left = middle }
        }
        left
    }

    fn is_behind(&self, rib: &Rib) -> bool {
        let near = self.cells.get(&cell(rib.at));
        near.into_iter().flatten().any(|i| {
            let band = &self.pieces[*i as usize];
            let Some(hit) = band.piece.hit(rib.at, band.halo) else { return false };
            let side = if band.right { hit.across + 0.5 } else { 1.0 };
            side.min(hit.cover(band.halo)) > 0.5 && rib.depth - hit.depth > 1.5 * BEHIND
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

#[cfg(test)]
mod tests {
    use super::super::{Axis, Brush, Knot, Spine, ribbons};
    use super::*;

    #[test]
    fn far_lines_end_before_near_ones() {
        let brush = Brush { halo: 4.0, width: 2.0, taper: 0.0, ..Brush::default() };
        let spine = |from: Vec2, to: Vec2, depth: f32| {
            let knot = |i: usize| {
                let t = i as f32 / 40.0;
                Knot { at: from.lerp(to, t), u: f64::from(100.0 * t), depth }
            };
            Spine::new((0..=40).map(knot).collect(), false, Axis { seed: 1, period: None })
        };
        let near = spine(Vec2::new(50.0, 0.0), Vec2::new(50.0, 100.0), 10.0);
        let far = spine(Vec2::new(0.0, 50.0), Vec2::new(100.0, 50.0), 200.0);
        let stroke = Stroke {
            spine: &near,
            brush: &brush,
            texture: None,
            colour: [0.0, 0.0, 0.0, 1.0],
            hides: true,
            right: false,
        };
        let halos = Halos::of(std::iter::once(stroke));
        let left = halos.part(ribbons(&brush, &far));
        assert_eq!(left.len(), 2);
        let ends = [left[0].ribs.last().unwrap().at.x, left[1].ribs[0].at.x];
        // Half the line's width, the halo, and what the brush varies it by.
        assert!((ends[0] - 45.0).abs() < 1.2 && (ends[1] - 55.0).abs() < 1.2, "{ends:?}");
        assert_eq!(halos.part(ribbons(&brush, &near)), ribbons(&brush, &near));
    }
}
