//! [`Band`]: rows of pixels with their hits, until the blocks of pixels over them are whole and
//! pooled.
//!
//! Rows are added from the top down and let go of once no block needs them, so that memory does not
//! grow with a picture's height.

use crate::cluster::Pixel;
use crate::field::Light;
use crate::indirect::Indirect;
use crate::pool::{self, Pooled, pool};
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
    pub(crate) fn settle(&mut self, rows: std::ops::Range<usize>, found: &mut Indirect) {
        let width = found.irradiance.width();
        let step = pool::STEP as isize;
        let columns = width.div_ceil(pool::STEP) + 1;
        let first = rows.start as isize / step - 1;
        let count = (rows.end as isize - 1).div_euclid(step) - first + 1;
        let blocks: Vec<Pooled> = (0..count as usize * columns)
            .into_par_iter()
            .map(|i| {
                let (x, y) =
                    ((i % columns) as isize * step - step, (first + (i / columns) as isize) * step);
                let side = pool::SIDE as isize;
                pool(&std::array::from_fn(|k| {
                    self.at(x + k as isize % side, y + k as isize / side).map(|g| &g.0)
                }))
            })
            .collect();
        for y in rows.clone() {
            for x in 0..width {
                let Some((_, far)) = self.at(x as isize, y as isize) else { continue };
                let near = Self::near(&blocks, columns, first, (x, y));
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

    /// The mean of the blocks over a pixel, by their weights there.
    fn near(blocks: &[Pooled], columns: usize, first: isize, (x, y): Pixel) -> Light {
        let (column, row) = (x / pool::STEP, (y / pool::STEP) as isize - first);
        let mut sum = [0.0; 4];
        for (dx, dy) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
            // A block one to the left or above has the pixel in its second half.
            let block = &blocks[(row as usize - dy) * columns + column + 1 - dx];
            let (i, j) = (x % pool::STEP + dx * pool::STEP, y % pool::STEP + dy * pool::STEP);
            let (weight, light) = block[j * pool::SIDE + i];
            (0..4).for_each(|c| sum[c] += weight * light[c]);
        }
        sum
    }
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
