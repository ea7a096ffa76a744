//! [`Band`]: rows of pixels with their hits, until the blocks of pixels over them are whole and
//! pooled.
//!
//! Rows are added from the top down and let go of once no block needs them, so that memory does not
//! grow with a picture's height.

use crate::cluster::Pixel;
use crate::field::Light;
use crate::indirect::Indirect;
use crate::opening::Dome;
use crate::pool::{self, SIDE, pool};
use crate::receiver::Receiver;
use rayon::prelude::*;
use std::collections::VecDeque;
use std::f32::consts::FRAC_1_PI;

/// A pixel that gathers, with its far light.
pub(crate) type Gathered = (Receiver, Light);

/// Rows of pixels with their hits, from row `from` on.
#[derive(Default)]
pub(crate) struct Band {
    from: usize,
    rows: VecDeque<Vec<Option<Gathered>>>,
}

impl Band {
    /// Adds rows of a width up to row `end`, with the pixels that gather in them.
    pub(crate) fn add(&mut self, width: usize, end: usize, all: impl Iterator<Item = Gathered>) {
        for _ in self.from + self.rows.len()..end {
            self.rows.push_back((0..width).map(|_| None).collect());
        }
        for one in all {
            let (x, y) = one.0.pixel;
            self.rows[y - self.from][x] = Some(one);
        }
    }

    fn at(&self, x: isize, y: isize) -> Option<&Gathered> {
        let row = self.rows.get(usize::try_from(y - self.from as isize).ok()?)?;
        row.get(usize::try_from(x).ok()?)?.as_ref()
    }

    /// Pools the hits around some rows, writes what comes of them, and lets go of rows that are not
    /// needed any more.
    /// A dome lights through what is open, where that is wanted.
    pub(crate) fn settle(
        &mut self,
        rows: std::ops::Range<usize>,
        dome: Option<&Dome>,
        found: &mut Indirect,
    ) {
        let width = found.irradiance.width();
        let (first, columns, blocks) = self.blocks(&rows, width, pool);
        self.open(&rows, dome, found);
        for y in rows.clone() {
            for x in 0..width {
                let Some((_, far)) = self.at(x as isize, y as isize) else { continue };
                let near = mean(&blocks, columns, first, (x, y));
                let light: Light = std::array::from_fn(|c| (far[c] + near[c]).max(0.0));
                found.irradiance[(x, y)] = [light[0], light[1], light[2]];
                found.openness[(x, y)] = (light[3] * FRAC_1_PI).min(1.0);
            }
        }
        let keep = rows.end.saturating_sub(pool::STEP);
        while self.from < keep && !self.rows.is_empty() {
            self.rows.pop_front();
            self.from += 1;
        }
    }

    /// What becomes of every block of receivers over some rows: the first row of blocks, their number in a
    /// row, and all.
    fn blocks<P: Send>(
        &self,
        rows: &std::ops::Range<usize>,
        width: usize,
        of: impl Fn(&[Option<&Receiver>; SIDE * SIDE]) -> P + Sync,
    ) -> (isize, usize, Vec<P>) {
        let step = pool::STEP as isize;
        let columns = width.div_ceil(pool::STEP) + 1;
        let first = rows.start as isize / step - 1;
        let count = (rows.end as isize - 1).div_euclid(step) - first + 1;
        let blocks = (0..count as usize * columns).into_par_iter().map(|i| {
            let (x, y) =
                ((i % columns) as isize * step - step, (first + (i / columns) as isize) * step);
            let side = SIDE as isize;
            of(&std::array::from_fn(|k| {
                self.at(x + k as isize % side, y + k as isize / side).map(|g| &g.0)
            }))
        });
        (first, columns, blocks.collect())
    }

    /// Writes the openings of some rows.
    fn open(&self, rows: &std::ops::Range<usize>, dome: Option<&Dome>, found: &mut Indirect) {
        let (Some(dome), Some(openings)) = (dome, &mut found.openings) else { return };
        let width = openings.bent.width();
        let (first, columns, blocks) = self.blocks(rows, width, |r| pool::open(r, dome));
        for (x, y) in rows.clone().flat_map(|y| (0..width).map(move |x| (x, y))) {
            let Some((receiver, _)) = self.at(x as isize, y as isize) else { continue };
            let near = mean(&blocks, columns, first, (x, y));
            openings.set((x, y), &std::array::from_fn(|c| receiver.opening[c] + near[c]));
        }
    }
}

/// The mean of the blocks over a pixel, by their weights there.
pub(crate) fn mean<const N: usize>(
    blocks: &[[(f32, [f32; N]); SIDE * SIDE]],
    columns: usize,
    first: isize,
    (x, y): Pixel,
) -> [f32; N] {
    let (column, row) = (x / pool::STEP, (y / pool::STEP) as isize - first);
    let mut sum = [0.0; N];
    for (dx, dy) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
        // A block one to the left or above has the pixel in its second half.
        let block = &blocks[(row as usize - dy) * columns + column + 1 - dx];
        let (i, j) = (x % pool::STEP + dx * pool::STEP, y % pool::STEP + dy * pool::STEP);
        let (weight, light) = block[j * SIDE + i];
        (0..N).for_each(|c| sum[c] += weight * light[c]);
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blocks_over_a_pixel_weigh_one_in_all() {
        for x in 0..4 {
            let one = |dx: usize| {
                let block = pool(&[None; 16]);
                block[x % 2 + 2 * dx].0 / 0.25
            };
            assert!((one(0) + one(1) - 1.0).abs() < 1e-6);
        }
    }
}
