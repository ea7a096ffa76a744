//! [`Runs`]: where a mask has pixels, row by row, so that passes over a picture that is half empty
//! cost half.
//!
//! A row is cut into cells of 32 pixels; those that hold a covered pixel are kept, and neighbours
//! among them make a run. Runs hold every covered pixel, and a few beside them.

use crate::Plane;
use rayon::prelude::*;
use std::ops::Range;

/// Pixels of a row that are kept or passed over together.
const CELL: usize = 32;

/// The parts of each row of a picture that hold covered pixels.
#[derive(Clone, Debug, PartialEq)]
pub struct Runs {
    width: usize,
    /// Whether a cell is kept; a row of them for each row of pixels.
    cells: Plane<bool>,
}

impl Runs {
    /// Those of a mask.
    pub fn of(mask: &Plane<bool>) -> Self {
        let (width, height) = mask.size();
        let columns = width.div_ceil(CELL);
        let mut cells = vec![false; columns * height];
        cells.par_chunks_mut(columns.max(1)).enumerate().for_each(|(y, cells)| {
            for (cell, pixels) in cells.iter_mut().zip(mask.row(y).chunks(CELL)) {
                *cell = pixels.iter().fold(false, |any, covered| any | covered);
            }
        });
        Self { width, cells: Plane::from_pixels(columns, height, cells) }
    }

    /// Those of all pixels.
    pub fn everywhere((width, height): (usize, usize)) -> Self {
        Self { width, cells: Plane::filled(width.div_ceil(CELL), height, true) }
    }

    /// Width and height of the picture.
    pub fn size(&self) -> (usize, usize) {
        (self.width, self.cells.height())
    }

    /// The runs of row `y`, from left to right.
    pub fn row(&self, y: usize) -> impl Iterator<Item = Range<usize>> + '_ {
        let cells = self.cells.row(y);
        let mut next = 0;
        std::iter::from_fn(move || {
            let first = next + cells[next..].iter().position(|kept| *kept)?;
            let length = cells[first..].iter().position(|kept| !kept);
            next = length.map_or(cells.len(), |n| first + n);
            Some(first * CELL..(next * CELL).min(self.width))
        })
    }

    /// Those of all pixels that have a kept one within `across` to the left or right and within
    /// `along` above or below.
    pub fn grown(&self, across: usize, along: usize) -> Self {
        let (columns, height) = self.cells.size();
        let mut wide = Self { width: self.width, cells: Plane::filled(columns, height, false) };
        for y in 0..height {
            for run in self.row(y) {
                wide.keep(y, run.start.saturating_sub(across)..run.end.saturating_add(across));
            }
        }
        let mut cells = Plane::filled(columns, height, false);
        for x in 0..columns {
            // The last kept row at or above each, then the next at or below.
            let mut last = None;
            for y in 0..height {
                last = if wide.cells[(x, y)] { Some(y) } else { last };
                cells[(x, y)] = last.is_some_and(|l| y - l <= along);
            }
            let mut next = None;
            for y in (0..height).rev() {
                next = if wide.cells[(x, y)] { Some(y) } else { next };
                cells[(x, y)] |= next.is_some_and(|n| n - y <= along);
            }
        }
        Self { width: self.width, cells }
    }

    /// Those of a picture of another size, a run of `row` for each of these.
    pub(crate) fn mapped(
        &self,
        (width, height): (usize, usize),
        rows: impl Fn(usize) -> Range<usize>,
        row: impl Fn(Range<usize>) -> Range<usize>,
    ) -> Self {
        let mut other = Self { width, cells: Plane::filled(width.div_ceil(CELL), height, false) };
        for y in 0..self.cells.height() {
            for run in self.row(y) {
                for v in rows(y) {
                    other.keep(v, row(run.clone()));
                }
            }
        }
        other
    }

    fn keep(&mut self, y: usize, run: Range<usize>) {
        let columns = self.cells.width();
        let end = run.end.min(self.width).div_ceil(CELL);
        for x in run.start / CELL..end.min(columns) {
            self.cells[(x, y)] = true;
        }
    }

    /// A plane that holds `nothing` but where `fill(y, run, pixels)` changes the pixels of a run of
    /// row y; rows are filled in parallel.
    pub fn plane<T: Clone + Send>(
        &self,
        nothing: T,
        fill: impl Fn(usize, Range<usize>, &mut [T]) + Sync,
    ) -> Plane<T> {
        let (width, height) = self.size();
        let mut plane = Plane::filled(width, height, nothing);
        self.change(&mut plane, fill);
        plane
    }

    /// Changes the pixels of runs in place, rows in parallel. Panics when the sizes differ.
    pub fn change<T: Send>(
        &self,
        plane: &mut Plane<T>,
        change: impl Fn(usize, Range<usize>, &mut [T]) + Sync,
    ) {
        assert_eq!(plane.size(), self.size(), "runs have the size of their plane");
        let rows = plane.pixels_mut().par_chunks_mut(self.width.max(1)).enumerate();
        rows.for_each(|(y, pixels)| {
            for run in self.row(y) {
                change(y, run.clone(), &mut pixels[run]);
            }
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn dots(width: usize, height: usize, at: &[(usize, usize)]) -> Plane<bool> {
        let mut mask = Plane::filled(width, height, false);
        at.iter().for_each(|p| mask[*p] = true);
        mask
    }

    fn rows(runs: &Runs) -> Vec<Vec<Range<usize>>> {
        (0..runs.size().1).map(|y| runs.row(y).collect()).collect()
    }

    #[test]
    fn runs_hold_what_is_covered() {
        let runs = Runs::of(&dots(100, 3, &[(0, 0), (33, 0), (99, 0), (50, 2)]));
        assert_eq!(rows(&runs), [vec![0..64, 96..100], vec![], std::iter::once(32..64).collect()]);
        let filled = runs.plane(0, |_, run, pixels| {
            assert_eq!(run.len(), pixels.len());
            pixels.fill(1);
        });
        assert_eq!(filled.pixels().iter().sum::<i32>(), 64 + 4 + 32);
        assert_eq!(Runs::everywhere((100, 3)).row(1).next(), Some(0..100));
        assert_eq!(Runs::of(&Plane::filled(0, 0, true)).size(), (0, 0));
    }

    #[test]
    fn grown_runs_hold_all_that_is_near() {
        let at = [(70, 4), (3, 9)];
        let (mask, near) = (dots(90, 12, &at), |a: usize, b: usize, d| a.abs_diff(b) <= d);
        let grown = Runs::of(&mask).grown(7, 3).plane(false, |_, _, pixels| pixels.fill(true));
        for (x, y) in (0..12).flat_map(|y| (0..90).map(move |x| (x, y))) {
            if at.iter().any(|p| near(p.0, x, 7) && near(p.1, y, 3)) {
                assert!(grown[(x, y)], "{x} {y}");
            }
            if at.iter().all(|p| !near(p.1, y, 3)) {
                assert!(!grown[(x, y)], "{x} {y}");
            }
        }
    }
}
