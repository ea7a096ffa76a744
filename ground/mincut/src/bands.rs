//! A grid solved in horizontal bands at once, then joined.
//!
//! 1. Every band is a grid of its own: the arcs over its seams are closed. Threads solve the bands
//!    with the search as always.
//! 2. Rows are put together: residuals, labels and parents stay as they are, for a label states a
//!    distance within its tree whatever surrounds it. Levels are counted on from the band that
//!    grew farthest.
//! 3. The arcs over the seams open. The nodes beside them grow again, and so do the black nodes
//!    that their band had left to grow; the search runs on from there.
//!
//! The flow found depends on the bands, the canonical cut does not.

use crate::capacity::Capacity;
use crate::network::{Black, White};
use crate::residual::Residual;
use crate::search::{GAP, Search};
use crate::strips;
use std::ops::Range;

/// The pixels of a strip: what the search needs of so many stays in the caches.
const STRIP: usize = 1 << 19;
/// The levels that grow within strips.
const LEVELS: i32 = 64;
/// The fewest rows of a band: less, and the seams cost more than a thread gains.
const MIN_ROWS: usize = 32;

/// Solves `grid` on `threads` threads; `None` when a distance is too large for a label.
pub(crate) fn run<C: Capacity>(grid: Residual<C>, threads: usize) -> Option<Search<Residual<C>>> {
    let bands = threads.min(grid.height() / MIN_ROWS);
    if bands < 2 {
        return solve(grid);
    }
    let rows = |band: usize| band * grid.height() / bands..(band + 1) * grid.height() / bands;
    let solved = std::thread::scope(|scope| {
        let grid = &grid;
        let solve = |band| move || solve_band(grid, rows(band));
        let others: Vec<_> = (1..bands).map(|band| scope.spawn(solve(band))).collect();
        let first = solve(0)();
        let others = others.into_iter().map(|thread| thread.join().ok().flatten());
        std::iter::once(first).chain(others).collect::<Option<Vec<_>>>()
    })?;
    let seams: Vec<usize> = (1..bands).map(|band| rows(band).start).collect();
    let mut search = join(grid, solved, &seams);
    search.run()?;
    Some(search)
}

fn solve_band<C: Capacity>(grid: &Residual<C>, rows: Range<usize>) -> Option<Search<Residual<C>>> {
    solve(grid.band(rows))
}

fn solve<C: Capacity>(grid: Residual<C>) -> Option<Search<Residual<C>>> {
    let mut search = Search::new(grid);
    strips::begin(&mut search, STRIP, LEVELS)?;
    search.run()?;
    Some(search)
}

/// One search of all bands, which begin at row 0 and at the seams.
fn join<C: Capacity>(
    grid: Residual<C>,
    bands: Vec<Search<Residual<C>>>,
    seams: &[usize],
) -> Search<Residual<C>> {
    let mut search = Search::unrooted(grid);
    for (band, &row) in bands.into_iter().zip([0].iter().chain(seams)) {
        place(&mut search, band, row);
    }
    for &row in seams {
        search.open_seam(row);
    }
    search
}

/// Puts a band in its place, from row `row` on.
fn place<C: Capacity>(search: &mut Search<Residual<C>>, mut band: Search<Residual<C>>, row: usize) {
    let network = &band.network;
    let shift = search.network.row(row).start - network.row(0).start;
    for y in 0..network.height() {
        let from = network.row(y);
        let to = from.start + shift..from.end + shift;
        search.label[to.clone()].copy_from_slice(&band.label[from.clone()]);
        search.parent[to].copy_from_slice(&band.parent[from]);
    }
    search.network.place(network, row);
    search.left += band.left;
    let waiting = [band.take_waiting::<White>(), band.take_waiting::<Black>()];
    for ((tree, part), waiting) in search.trees.iter_mut().zip(&band.trees).zip(waiting) {
        // What waits lies at most one gap above the grown levels.
        tree.grown = tree.grown.max(part.grown + GAP);
        tree.again.extend(waiting.into_iter().map(|v| v + shift as u32));
    }
}

impl<C: Capacity> Search<Residual<C>> {
    /// Opens the arcs between the rows `row - 1` and `row`, whose nodes are to grow again.
    pub(crate) fn open_seam(&mut self, row: usize) {
        self.network.open_seam(row);
        for tree in &mut self.trees {
            let nodes = self.network.row(row - 1).chain(self.network.row(row));
            tree.again.extend(nodes.map(|v| v as u32));
        }
    }
}

impl Search<Residual<i16>> {
    /// The same search in 32 bits.
    pub(crate) fn widened(self) -> Search<Residual<i32>> {
        Search {
            network: self.network.widened(),
            label: self.label.into_iter().map(i32::from).collect(),
            parent: self.parent,
            trees: self.trees,
            left: self.left,
            patience: self.patience,
        }
    }
}
