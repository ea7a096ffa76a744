//! The residual graph: one record a pixel, in a frame of edgeless pixels.
//!
//! The frame spares the search every test for the border: its records have no capacity and no
//! excess. Rows share it: the pixel right of a row's last is the one left of the next row's first.

use crate::around::{STEPS, opposite};
use crate::grid::Grid;

/// What is left of a pixel's capacities.
#[derive(Clone, Copy, Default)]
pub(crate) struct Record {
    /// To each of the eight neighbours.
    pub(crate) residual: [i32; 8],
    /// From the white terminal if positive, to the black terminal if negative.
    pub(crate) excess: i32,
}

/// The framed records of a grid.
pub(crate) struct Residual {
    pub(crate) width: usize,
    pub(crate) height: usize,
    pub(crate) records: Vec<Record>,
    /// How far each direction is in `records`.
    pub(crate) offset: [isize; 8],
}

impl Residual {
    /// Reads the capacities of `grid`.
    pub(crate) fn new(grid: &Grid) -> Self {
        let stride = grid.width + 1;
        let offset = STEPS.map(|(x, y)| x + y * stride as isize);
        let records = vec![Record::default(); stride * (grid.height + 2) + 1];
        let mut graph = Self { width: grid.width, height: grid.height, records, offset };
        for y in 0..grid.height {
            for x in 0..grid.width {
                graph.read(grid, x, y);
            }
        }
        graph
    }

    /// Where pixel (x, y) is in `records`.
    pub(crate) fn index(&self, x: usize, y: usize) -> usize {
        (y + 1) * (self.width + 1) + x + 1
    }

    /// The neighbour of `v` in direction `d`.
    pub(crate) fn neighbour(&self, v: usize, d: usize) -> usize {
        v.wrapping_add_signed(self.offset[d])
    }

    /// Moves `amount` from `v` to its neighbour in direction `d`.
    pub(crate) fn push(&mut self, v: usize, d: usize, amount: i32) {
        let w = self.neighbour(v, d);
        self.records[v].residual[d] -= amount;
        self.records[w].residual[opposite(d)] += amount;
    }

    fn read(&mut self, grid: &Grid, x: usize, y: usize) {
        let i = y * grid.width + x;
        if !grid.mask[i] {
            return;
        }
        let v = self.index(x, y);
        self.records[v].excess = grid.terminal[i][0] - grid.terminal[i][1];
        for (d, capacity) in (3..7).zip(grid.neighbour[i]) {
            let (x, y) = (x.wrapping_add_signed(STEPS[d].0), y.wrapping_add_signed(STEPS[d].1));
            if x < grid.width && y < grid.height && grid.mask[y * grid.width + x] {
                let w = self.neighbour(v, d);
                self.records[v].residual[d] = capacity;
                self.records[w].residual[opposite(d)] = capacity;
            }
        }
    }
}
