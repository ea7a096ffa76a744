//! Exact minimal cuts on pixel grids, with the canonical labelling.
//!
//! A [`Grid`] states what each pixel pays to end black or white and what each pair of the eight
//! neighbours pays to differ. [`solve`] finds the labelling with the least total cost.
//!
//! ```
//! use chiaro_mincut::{Grid, energy, solve};
//!
//! // Two pixels: the left one wants white by 5, the right one black by 2, and they share a bond of 3.
//! let grid = Grid {
//!     width: 2,
//!     height: 1,
//!     mask: &[true, true],
//!     terminal: &[[5, 0], [0, 2]],
//!     neighbour: &[[3, 0, 0, 0], [0; 4]],
//! };
//! let cut = solve(&grid)?;
//! assert_eq!(cut.labels, [true, true]);
//! assert_eq!((cut.flow, cut.cut), (2, 2));
//! assert_eq!(energy(&grid, &[true, false]), 3);
//! # Ok::<(), chiaro_mincut::GridError>(())
//! ```
//!
//! A [`Lattice`] states more: four or sixteen neighbours, capacities that differ forth and back,
//! frames over time, pixels that must be white or black. A [`Solver`] keeps its solution and
//! follows changes at a cost of what they move:
//!
//! ```
//! # use chiaro_mincut::{Grid, Solver};
//! # let grid = Grid {
//! #     width: 2,
//! #     height: 1,
//! #     mask: &[true, true],
//! #     terminal: &[[5, 0], [0, 2]],
//! #     neighbour: &[[3, 0, 0, 0], [0; 4]],
//! # };
//! let mut solver = Solver::new(&(&grid).into())?;
//! solver.fix(0, Some(false))?;
//! assert_eq!((solver.solve(), solver.labels()), (5, &[false, false][..]));
//! solver.fix(0, None)?;
//! assert_eq!((solver.solve(), solver.labels()), (2, &[true, true][..]));
//! # Ok::<(), chiaro_mincut::GridError>(())
//! ```
//!
//! [`solve_graph`] does the same on any graph; [`read_dimacs`] reads problems that others state, and
//! [`verify`] proves a solution from the problem alone, as [`verify_grid`] does with [`solve_flow`].
//! [`Family`] holds the cuts for every shift of the terminals; [`solve_ordered`] and [`expand`] give
//! pixels one of several labels.
//!
//! Guaranteed: the cut is minimal, `flow == cut`, and among several minimal cuts the result is the
//! canonical one, whose white pixels are exactly those the white terminal still reaches in the
//! residual graph. That set is the same for every maximal flow, so any other exact solver with the
//! same rule returns the same bits, and so does [`solve_on`] on any number of threads. Nothing recurses, and capacities are bounded so that no sum
//! overflows. Not guaranteed: a running time better than polynomial; pictures are fast because
//! their paths are short.

mod around;
mod bands;
mod capacity;
mod certificate;
mod chain;
mod dimacs;
mod family;
mod grid;
mod labels;
mod lattice;
mod level;
mod lost;
mod network;
#[cfg(test)]
mod noise;
mod orphans;
mod parts;
mod planes;
mod prefetch;
mod proof;
mod repair;
mod residual;
mod search;
mod solver;
mod sparse;
mod stencil;
mod strips;

use capacity::Capacity;
use planes::Planes;
use residual::Residual;
use search::Search;

pub use certificate::{Flaw, verify};
pub use dimacs::{DimacsError, MaxFlow, MaxFlowSolution, read_dimacs};
pub use family::Family;
pub use grid::{Grid, GridError, MAX_NEIGHBOUR, MAX_PIXELS, energy};
pub use labels::{
    Distance, Expansion, LabelError, LabelGrid, LabelStack, Labelling, MAX_LABELS, MAX_PRICE,
    expand, expand_stack, solve_ordered,
};
pub use lattice::{LINK_STEPS, Lattice, Links, Neighbours, TimeLink};
pub use proof::{solve_flow, verify_grid, verify_lattice};
pub use solver::Solver;
pub use sparse::{Edge, Graph, GraphCut, GraphError, MAX_EDGES, MAX_FLOW, MAX_NODES, solve_graph};

/// The canonical minimal cut of a [`Grid`].
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Cut {
    /// One label a pixel, row-major: `true` is white; `false` is black or outside the mask.
    pub labels: Vec<bool>,
    /// The maximal flow, the smaller terminal of each pixel included.
    pub flow: i64,
    /// The cost of `labels`, counted anew from the grid; equal to `flow`.
    pub cut: i64,
}

/// Finds the canonical minimal cut of `grid`.
///
/// # Errors
/// A slice of the wrong length, a negative capacity, or a grid beyond [`MAX_PIXELS`] or
/// [`MAX_NEIGHBOUR`].
pub fn solve(grid: &Grid) -> Result<Cut, GridError> {
    solve_on(grid, 1)
}

/// Finds the canonical minimal cut of `grid` on up to `threads` threads: the same bytes for any
/// number of them.
///
/// # Errors
/// See [`solve`].
pub fn solve_on(grid: &Grid, threads: usize) -> Result<Cut, GridError> {
    grid.check_on(threads)?;
    if grid.mask.is_empty() {
        return Ok(Cut { labels: Vec::new(), flow: 0, cut: 0 });
    }
    let cut = |(search, constant)| read::<i16>(grid, search, constant, threads);
    let small = solved(grid, threads).map(cut);
    let large = |(search, constant)| read::<i32>(grid, search, constant, threads);
    Ok(small.or_else(|| solved(grid, threads).map(large)).expect("a checked grid fits 32 bits"))
}

/// The finished search, and what its flow is less than; `None` if a value is too large for `C`.
fn solved<C: Capacity>(grid: &Grid, threads: usize) -> Option<(Search<Residual<C>>, i64)> {
    let mut planes = Planes::<C>::read(grid, threads)?;
    chain::route(&mut planes, threads);
    let constant = planes.direct + planes.supply;
    Some((bands::run(Residual::new(planes), threads)?, constant))
}

/// Reads the cut of a finished search, whose graph is let go before the labels are laid out.
fn read<C: Capacity>(
    grid: &Grid,
    search: Search<Residual<C>>,
    constant: i64,
    threads: usize,
) -> Cut {
    let flow = constant - search.left;
    let rows: Vec<_> = (0..grid.height).map(|y| search.network.row(y)).collect();
    let label = search.into_labels();
    let mut labels = Vec::with_capacity(grid.mask.len());
    for row in rows {
        labels.extend(label[row].iter().map(|label| label.get() > 0));
    }
    let rows = parts::ranges(grid.height, threads, 1);
    let cut = parts::each(rows, |rows| grid::energy_of(grid, &labels, rows)).iter().sum();
    debug_assert_eq!(flow, cut, "a maximal flow equals its cut");
    Cut { labels, flow, cut }
}
