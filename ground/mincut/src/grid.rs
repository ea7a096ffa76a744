//! [`Grid`]: the problem as the caller states it, its checks, and the cost of a labelling.
//!
//! The bounds checked here are what keeps every later sum from overflowing.

use std::fmt;

/// The most pixels a grid may have: 2^28. Every cost then fits an `i64`, every index a `u32`.
pub const MAX_PIXELS: usize = 1 << 28;

/// The largest neighbour capacity: 2^27 - 1. The eight of a pixel then sum to less than 2^30.
pub const MAX_NEIGHBOUR: i32 = (1 << 27) - 1;

/// An undirected grid of pixels with eight neighbours each; every slice holds `width * height`
/// values, row-major, x to the right, y down.
#[derive(Clone, Copy, Debug)]
pub struct Grid<'a> {
    /// Pixels in a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Which pixels are nodes; the others have no cost and no edges.
    pub mask: &'a [bool],
    /// `[white, black]`, both 0 or more: `white` is paid when the pixel ends black, `black` when it
    /// ends white.
    pub terminal: &'a [[i32; 2]],
    /// To the east, south-east, south and south-west, from 0 to [`MAX_NEIGHBOUR`]: paid when the
    /// two pixels differ. Ignored where an edge leaves the picture or touches an unmasked pixel.
    pub neighbour: &'a [[i32; 4]],
}

/// Why a [`Grid`] has no cut.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum GridError {
    /// More than [`MAX_PIXELS`] pixels.
    TooManyPixels {
        /// Pixels in a row.
        width: usize,
        /// Rows.
        height: usize,
    },
    /// A slice that does not hold one value a pixel.
    Length {
        /// The name of the slice.
        slice: &'static str,
        /// Its length.
        got: usize,
        /// The number of pixels.
        expected: usize,
    },
    /// A capacity below zero.
    Negative {
        /// Column of the pixel.
        x: usize,
        /// Row of the pixel.
        y: usize,
        /// The capacity.
        got: i32,
    },
    /// A neighbour capacity above [`MAX_NEIGHBOUR`], whose sums could overflow.
    TooLarge {
        /// Column of the pixel.
        x: usize,
        /// Row of the pixel.
        y: usize,
        /// The capacity.
        got: i32,
    },
}

impl fmt::Display for GridError {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match *self {
            Self::TooManyPixels { width, height } => write!(
                f,
                "a grid of {width} x {height} pixels is beyond the limit of {MAX_PIXELS} pixels; cut it in parts"
            ),
            Self::Length { slice, got, expected } => {
                write!(
                    f,
                    "`{slice}` has {got} values where the grid has {expected} pixels; give one a pixel"
                )
            }
            Self::Negative { x, y, got } => {
                write!(f, "a capacity of pixel ({x}, {y}) is {got}; capacities are zero or more")
            }
            Self::TooLarge { x, y, got } => write!(
                f,
                "a neighbour capacity of pixel ({x}, {y}) is {got}, above the limit of {MAX_NEIGHBOUR}; \
                 scale all capacities down"
            ),
        }
    }
}

impl std::error::Error for GridError {}

impl Grid<'_> {
    /// Holds the grid to the bounds that every later step relies on.
    pub(crate) fn check(&self) -> Result<(), GridError> {
        let (width, height) = (self.width, self.height);
        let too_many = GridError::TooManyPixels { width, height };
        let pixels = width.checked_mul(height).filter(|&n| n <= MAX_PIXELS).ok_or(too_many)?;
        let lengths = [
            ("mask", self.mask.len()),
            ("terminal", self.terminal.len()),
            ("neighbour", self.neighbour.len()),
        ];
        match lengths.into_iter().find(|&(_, got)| got != pixels) {
            Some((slice, got)) => Err(GridError::Length { slice, got, expected: pixels }),
            None => self.check_capacities(),
        }
    }

    /// Finds the worst sign and size in one branch-free pass, and the culprit only if there is one.
    fn check_capacities(&self) -> Result<(), GridError> {
        let signs = self.terminal.as_flattened().iter().fold(0, |s, &c| s | c);
        let bits = self.neighbour.as_flattened().iter().fold(0, |s, &c| s | c);
        if signs >= 0 && (0..=MAX_NEIGHBOUR).contains(&bits) {
            return Ok(());
        }
        let at = |i: usize| (i % self.width, i / self.width);
        for (i, (terminal, neighbour)) in self.terminal.iter().zip(self.neighbour).enumerate() {
            let (x, y) = at(i);
            if let Some(&got) = terminal.iter().chain(neighbour).find(|&&c| c < 0) {
                return Err(GridError::Negative { x, y, got });
            }
            if let Some(&got) = neighbour.iter().find(|&&c| c > MAX_NEIGHBOUR) {
                return Err(GridError::TooLarge { x, y, got });
            }
        }
        Ok(())
    }
}

/// The cost of `labels` (`true` is white) on `grid`: the terminals and neighbours they cut.
///
/// # Panics
/// When a slice does not hold one value a pixel.
pub fn energy(grid: &Grid, labels: &[bool]) -> i64 {
    let pixels = grid.width * grid.height;
    assert!(
        [labels.len(), grid.mask.len(), grid.terminal.len(), grid.neighbour.len()] == [pixels; 4],
        "one label, mask, terminal and neighbour value a pixel"
    );
    (0..pixels).filter(|&i| grid.mask[i]).map(|i| pixel_energy(grid, labels, i)).sum()
}

/// What pixel `i` pays: its terminal, and its neighbours to the east, south-east, south, south-west.
fn pixel_energy(grid: &Grid, labels: &[bool], i: usize) -> i64 {
    let (x, y, width) = (i % grid.width, i / grid.width, grid.width);
    let (east, south, west) = (x + 1 < width, y + 1 < grid.height, x > 0);
    let inside = [east, south && east, south, south && west];
    let others = [i + 1, i + width + 1, i + width, i + width - 1];
    let cut = |d: usize| inside[d] && grid.mask[others[d]] && labels[others[d]] != labels[i];
    let bonds = (0..4).filter(|&d| cut(d)).map(|d| i64::from(grid.neighbour[i][d])).sum::<i64>();
    i64::from(grid.terminal[i][usize::from(labels[i])]) + bonds
}
