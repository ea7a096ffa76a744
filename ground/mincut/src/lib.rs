//! Exact minimal cuts on pixel grids, with the canonical labelling.
//!
//! ```
//! use chiaro_mincut::{Grid, solve};
//! // Two pixels: one pulled to white, one a little to black, tied together.
//! let grid = Grid {
//!     width: 2,
//!     height: 1,
//!     mask: &[true, true],
//!     terminal: &[[5, 0], [0, 2]],
//!     neighbour: &[[3, 0, 0, 0], [0; 4]],
//! };
//! let cut = solve(&grid).unwrap();
//! assert_eq!(cut.labels, [true, true]);
//! assert_eq!((cut.flow, cut.cut), (2, 2));
//! ```

mod grid;
mod tree;

pub use grid::{Cut, Grid, GridError, energy};

/// The minimal cut of a grid.
///
/// Of all minimal cuts it is the one with the fewest white pixels: white is what the white terminal
/// reaches in the residual graph, and that set is the same for every maximal flow.
///
/// # Errors
/// [`GridError`] when lengths do not agree, a capacity is negative, or a pixel's capacities add up
/// to more than `i32::MAX`.
pub fn solve(grid: &Grid) -> Result<Cut, GridError> {
    grid.check()?;
    let mut search = tree::Search::new(grid);
    search.run();
    let labels = search.reachable_from_white();
    let cut = energy(grid, &labels);
    Ok(Cut { labels, flow: search.flow, cut })
}
