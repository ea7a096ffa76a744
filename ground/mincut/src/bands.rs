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
use crate::level::Level;
use crate::network::{Black, Side, White};
use crate::residual::Residual;
use crate::search::{GAP, Search};
use std::ops::Range;

/// The fewest rows of a band: less, and the seams cost more than a thread gains.
const MIN_ROWS: usize = 32;

/// Solves `grid` on `threads` threads; `None` when a distance is too large for a label.
pub(crate) fn run<C: Capacity>(grid: Residual<C>, threads: usize) -> Option<Search<Residual<C>>> {
    let bands = threads.min(grid.height() / MIN_ROWS);
    if bands < 2 {
        let mut search = Search::new(grid);
        search.run()?;
        return Some(search);
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
    let mut search = Search::new(grid.band(rows));
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
        search.network.open_seam(row);
        for v in search.network.row(row - 1).chain(search.network.row(row)) {
            search.trees[White::INDEX].again.push(v as u32);
            search.trees[Black::INDEX].again.push(v as u32);
        }
    }
    search
}

/// Puts a band in its place, from row `row` on.
fn place<C: Capacity>(search: &mut Search<Residual<C>>, band: Search<Residual<C>>, row: usize) {
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
    for (tree, part) in search.trees.iter_mut().zip(band.trees) {
        // What waits lies at most one gap above the grown levels.
        tree.grown = tree.grown.max(part.grown + GAP);
        let waiting = part.active.into_iter().flat_map(Level::blocks).chain([part.again]);
        tree.again.extend(waiting.flatten().map(|v| v + shift as u32));
        if part.seeded {
            // Only black roots can be left: a band is done when its white tree is.
            let roots = (0..band.label.len()).filter(|&v| band.label[v].get() == -1);
            tree.again.extend(roots.map(|v| (v + shift) as u32));
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
