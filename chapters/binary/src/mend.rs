//! The smallest island at little cost: a speck that the weights hold dear grows to the smallest area,
//! or to the next piece of its label, where that costs less than taking it away.
//!
//! 1. Pieces under the smallest area are looked at from the largest to the smallest. Each grows
//!    pixel by pixel, the cheapest first, until its area suffices, if that costs less than to recolour
//!    the piece. (Ways to the next large piece of the label were tried as well: they hardly ever pay.)
//! 2. What is still small takes the colour around it ([`without_islands`]).
//!
//! Guaranteed: no piece of less than the smallest area is left that touches another label. Not
//! guaranteed: the least energy of all labellings without small pieces.

use crate::geometry::EDGES;
use crate::island::without_islands;
use crate::knob::BinaryKnobs;
use crate::round::reach;
use chiaro_basis::Result;
use chiaro_image::Plane;
use chiaro_image::labels::{Components, Piece, UNCOVERED, components};
use std::cmp::Reverse;
use std::collections::{BTreeMap, BinaryHeap};

/// What labels cost, in units of capacity.
#[derive(Clone, Copy)]
pub(crate) struct Costs<'a> {
    /// Which pixels are nodes.
    pub(crate) mask: &'a Plane<bool>,
    /// How many labels there are.
    pub(crate) count: usize,
    /// What each pixel pays for each label.
    pub(crate) prices: &'a [i32],
    /// Bonds to E, SE, S, SW, paid between any two labels.
    pub(crate) neighbour: &'a Plane<[i32; 4]>,
    /// Whether a border costs its bond for each step from one label to the other, as between tones,
    /// or once. Only [`Costs::rounded`] looks at it.
    pub(crate) by_step: bool,
}

impl Costs<'_> {
    /// `labels` with round borders, and then without small pieces.
    pub(crate) fn finished(&self, labels: &Plane<u8>, knobs: &BinaryKnobs) -> Result<Plane<u8>> {
        let round = self.rounded(labels, reach(knobs, labels.height()))?;
        Ok(self.without_islands(&round, knobs.island_area(labels.height())))
    }

    /// `labels` without pieces of fewer than `area` pixels.
    pub(crate) fn without_islands(&self, labels: &Plane<u8>, area: f32) -> Plane<u8> {
        if area <= 1.0 {
            return labels.clone();
        }
        let grown = Growing::new(*self, labels, area).grown();
        without_islands(&grown, self.mask, area)
    }

    /// What it costs to give a piece of one label the one that is beside it most.
    pub(crate) fn removal(&self, labels: &Plane<u8>, pixels: &[(usize, usize)], label: u8) -> i64 {
        let mut border: BTreeMap<u8, i64> = BTreeMap::new();
        let (mut costs, mut all) = (0, 0);
        for p in pixels {
            costs -= self.price(*p, label);
            for (q, bond) in self.around(*p).filter(|(q, _)| labels[*q] != label) {
                *border.entry(labels[q]).or_default() += bond;
                all += bond;
            }
        }
        let Some((other, _)) = border.iter().max_by_key(|(_, bonds)| **bonds) else { return 0 };
        costs += pixels.iter().map(|p| self.price(*p, *other)).sum::<i64>();
        // What is beside it in a third label stays a border.
        let rest: i64 = border.iter().filter(|(l, _)| *l != other).map(|(_, bonds)| bonds).sum();
        costs + rest - all
    }

    /// How often a border between two labels costs its bond.
    pub(crate) fn apart(&self, a: u8, b: u8) -> i32 {
        let steps = i32::from(a.abs_diff(b));
        if self.by_step { steps } else { steps.min(1) }
    }

    /// The energy of labels.
    pub(crate) fn of(&self, labels: &Plane<u8>) -> i64 {
        let (w, h) = self.mask.size();
        let mut energy = 0;
        for p in (0..h).flat_map(|y| (0..w).map(move |x| (x, y))).filter(|p| self.mask[*p]) {
            energy += self.price(p, labels[p]);
            for (e, (dx, dy)) in EDGES.into_iter().enumerate() {
                let q = (p.0.wrapping_add_signed(dx), p.1.wrapping_add_signed(dy));
                if q.0 < w && q.1 < h && self.mask[q] && labels[p] != labels[q] {
                    energy += i64::from(self.neighbour[p][e]);
                }
            }
        }
        energy
    }

    /// What a pixel's labels cost, but for bonds.
    fn price(&self, (x, y): (usize, usize), label: u8) -> i64 {
        let pixel = y * self.mask.width() + x;
        i64::from(self.prices[pixel * self.count + usize::from(label)])
    }

    /// The nodes beside a pixel, with their bonds.
    fn around(&self, (x, y): (usize, usize)) -> impl Iterator<Item = ((usize, usize), i64)> + '_ {
        let ends = EDGES.into_iter().enumerate().flat_map(move |(e, (dx, dy))| {
            let ahead = (x.wrapping_add_signed(dx), y.wrapping_add_signed(dy));
            let behind = (x.wrapping_add_signed(-dx), y.wrapping_add_signed(-dy));
            [(ahead, (x, y), e), (behind, behind, e)]
        });
        let (w, h) = self.mask.size();
        ends.filter(move |(q, ..)| q.0 < w && q.1 < h && self.mask[*q])
            .map(|(q, owner, e)| (q, i64::from(self.neighbour[owner][e])))
    }

    /// What it costs to give one pixel another label.
    fn change(&self, labels: &Plane<u8>, p: (usize, usize), label: u8) -> i64 {
        let own = labels[p];
        let paid = |q: (usize, usize), label: u8| i64::from(labels[q] != label);
        let bonds = self.around(p).map(|(q, bond)| bond * (paid(q, label) - paid(q, own)));
        self.price(p, label) - self.price(p, own) + bonds.sum::<i64>()
    }
}

/// The pixels of piece `id`.
pub(crate) fn pixels_of(piece: &Piece<u8>, ids: &Plane<u32>, id: u32) -> Vec<(usize, usize)> {
    let (first, last) = (piece.first, piece.last);
    let rows = (first.1..=last.1).flat_map(|y| (first.0..=last.0).map(move |x| (x, y)));
    rows.filter(|p| ids[*p] == id).collect()
}

/// How a piece could grow.
struct Growth {
    /// Pixels and the labels that they have had.
    added: Vec<((usize, usize), u8)>,
    /// The pieces that become one, its own first.
    joined: Vec<u32>,
    area: usize,
}

/// Labels whose small pieces grow.
struct Growing<'a> {
    costs: Costs<'a>,
    labels: Plane<u8>,
    least: f32,
    ids: Plane<u32>,
    pieces: Vec<Piece<u8>>,
    /// The piece that each piece has become a part of, or itself.
    part_of: Vec<u32>,
}

impl<'a> Growing<'a> {
    fn new(costs: Costs<'a>, labels: &Plane<u8>, least: f32) -> Self {
        let Components { pieces, ids } = components(labels, costs.mask);
        let part_of = (0..pieces.len() as u32).collect();
        Self { costs, labels: labels.clone(), least, ids, pieces, part_of }
    }

    /// The labels once every small piece has grown that is to grow.
    fn grown(mut self) -> Plane<u8> {
        let small = |id: &u32| {
            let piece = &self.pieces[*id as usize];
            piece.touches_other && (piece.area as f32) < self.least
        };
        let mut order: Vec<u32> = (0..self.pieces.len() as u32).filter(small).collect();
        order.sort_by_key(|&id| (Reverse(self.pieces[id as usize].area), id));
        for id in order {
            let whole = self.whole(id) as usize;
            if (self.pieces[whole].area as f32) < self.least {
                self.grow(id);
            }
        }
        self.labels
    }

    /// The piece that a piece is now a part of.
    fn whole(&self, mut id: u32) -> u32 {
        while self.part_of[id as usize] != id {
            id = self.part_of[id as usize];
        }
        id
    }

    /// The pixels that a piece began with, as far as they are still its own.
    fn pixels(&self, id: u32) -> Vec<(usize, usize)> {
        pixels_of(&self.pieces[id as usize], &self.ids, id)
    }

    /// Lets a piece grow if that is cheaper than its removal.
    fn grow(&mut self, id: u32) {
        let label = self.pieces[id as usize].label;
        let pixels = self.pixels(id);
        let removal = self.costs.removal(&self.labels, &pixels, label);
        if let Some(growth) = self.growth(&pixels, label, removal) {
            growth.added.iter().for_each(|(p, _)| self.labels[*p] = label);
            self.take(&growth);
        }
    }

    /// The piece with the cheapest pixels around it, one after the other, until it is large enough;
    /// `None` where that costs more than `dearest`.
    fn growth(&mut self, pixels: &[(usize, usize)], label: u8, dearest: i64) -> Option<Growth> {
        let start = self.whole(self.ids[*pixels.first()?]);
        let area = self.pieces[start as usize].area;
        let mut growth = Growth { added: Vec::new(), joined: vec![start], area };
        let mut cost = 0;
        let mut next = BinaryHeap::new();
        let mut beside = pixels.to_vec();
        while (growth.area as f32) < self.least {
            for p in std::mem::take(&mut beside) {
                for (q, _) in self.costs.around(p).filter(|(q, _)| self.labels[*q] != label) {
                    next.push(Reverse((self.costs.change(&self.labels, q, label), q.1, q.0)));
                }
            }
            let Some(Reverse((price, y, x))) = next.pop() else { break };
            let p = (x, y);
            if self.labels[p] == label || price != self.costs.change(&self.labels, p, label) {
                continue;
            }
            cost += price;
            if cost > dearest {
                break;
            }
            growth.added.push((p, self.labels[p]));
            self.labels[p] = label;
            growth.area += 1;
            beside.push(p);
            self.join(&mut growth, p, label);
        }
        growth.added.iter().for_each(|(p, former)| self.labels[*p] = *former);
        (growth.area as f32 >= self.least && cost <= dearest).then_some(growth)
    }

    /// Counts in the pieces that a new pixel touches.
    fn join(&self, growth: &mut Growth, p: (usize, usize), label: u8) {
        for (q, _) in self.costs.around(p).filter(|(q, _)| self.labels[*q] == label) {
            let beside = self.whole(self.ids[q]);
            if self.pieces[beside as usize].label == label && !growth.joined.contains(&beside) {
                growth.joined.push(beside);
                growth.area += self.pieces[beside as usize].area;
            }
        }
    }

    /// Makes pixels and pieces one piece.
    fn take(&mut self, growth: &Growth) {
        let whole = growth.joined[0];
        for (p, _) in &growth.added {
            let former = self.ids[*p];
            debug_assert!(former != UNCOVERED, "only nodes are taken");
            let former = self.whole(former) as usize;
            self.pieces[former].area -= 1;
            self.ids[*p] = whole;
        }
        growth.joined.iter().for_each(|id| self.part_of[*id as usize] = whole);
        self.pieces[whole as usize].area = growth.area;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `.` is white, `,` white for little, `#` black; a digit is a black pixel that costs so much to
    /// make white.
    fn mended(rows: &[&str], bond: i32, area: f32) -> Vec<String> {
        let (w, h) = (rows[0].len(), rows.len());
        let at = |x: usize, y: usize| rows[y].as_bytes()[x];
        let labels = Plane::from_fn(w, h, |x, y| u8::from(b".,".contains(&at(x, y))));
        let mask = Plane::filled(w, h, true);
        let terminal = Plane::from_fn(w, h, |x, y| match at(x, y) {
            b'.' => [2, 0],
            b',' => [1, 0],
            b'#' => [0, 2],
            digit => [0, i32::from(digit - b'0')],
        });
        let neighbour = Plane::filled(w, h, [bond, 0, bond, 0]);
        let prices = terminal.pixels().as_flattened();
        let costs = Costs { mask: &mask, count: 2, prices, neighbour: &neighbour, by_step: false };
        let out = costs.without_islands(&labels, area);
        let sign = |x, y| if out[(x, y)] == 1 { '.' } else { '#' };
        (0..h).map(|y| (0..w).map(|x| sign(x, y)).collect()).collect()
    }

    #[test]
    fn a_speck_that_is_held_dear_grows_and_another_goes() {
        let rows = ["........", ".99.....", ".99...1.", "........"];
        let out = mended(&rows, 0, 5.0);
        let black = out.concat().matches('#').count();
        assert_eq!(black, 5, "{out:?}");
        assert_eq!(&out[1][1..3], "##");
        assert_eq!(&out[2][6..7], ".");
        // Four pixels cost 9 each to remove; five more cost 2 each, twenty cost too much.
        assert_eq!(mended(&rows, 0, 9.0).concat().matches('#').count(), 9);
        assert_eq!(mended(&rows, 0, 24.0).concat().matches('#').count(), 0);
    }

    #[test]
    fn growth_ends_at_the_next_piece_of_its_label() {
        let rows = ["......", ".9,###", "...###", "...###"];
        let out = mended(&rows, 0, 8.0);
        assert_eq!(out, ["......", ".#####", "...###", "...###"].map(String::from));
    }

    #[test]
    fn nothing_small_is_left() {
        for count in [2usize, 3] {
            let noise = |x: usize, y: usize| (x * 7919 + y * 104_729 + x * y * 31) % 7 % count;
            let (w, h) = (40, 30);
            let labels = Plane::from_fn(w, h, |x, y| noise(x, y) as u8);
            let mask = Plane::from_fn(w, h, |x, y| (x + y) % 11 != 0);
            let mut prices = Vec::new();
            for own in labels.pixels() {
                prices.extend((0..count).map(|l| 9 * i32::from(l != usize::from(*own))));
            }
            let neighbour = Plane::filled(w, h, [3, 2, 3, 2]);
            let costs = Costs {
                mask: &mask,
                count,
                prices: &prices,
                neighbour: &neighbour,
                by_step: false,
            };
            let out = costs.without_islands(&labels, 6.0);
            let found = components(&out, &mask);
            assert!(found.pieces.iter().all(|p| p.area >= 6 || !p.touches_other));
        }
    }
}
