//! The problem and its solution.

use std::fmt;

/// An undirected grid problem with eight neighbours. Slices hold `width * height` entries, row by
/// row.
#[derive(Clone, Copy, Debug)]
pub struct Grid<'a> {
    /// Pixels in a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Which pixels are nodes.
    pub mask: &'a [bool],
    /// Capacities to the white and to the black terminal, not negative: the first is paid when the
    /// pixel ends black, the second when it ends white.
    pub terminal: &'a [[i32; 2]],
    /// Capacities to the neighbours E, SE, S and SW, not negative, paid when the two differ; ignored
    /// where an edge leaves the picture or touches a pixel that is no node.
    pub neighbour: &'a [[i32; 4]],
}

/// A minimal cut.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Cut {
    /// White where true; black, or no node, elsewhere.
    pub labels: Vec<bool>,
    /// The maximal flow, with the smaller terminal capacity of every pixel.
    pub flow: i64,
    /// The capacity of the cut, added up again from the labels; equal to the flow.
    pub cut: i64,
}

/// Why a grid is no problem to solve.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum GridError {
    /// A slice is too short or too long.
    Length {
        /// Which slice.
        slice: &'static str,
        /// Its length.
        got: usize,
        /// `width * height`.
        expected: usize,
    },
    /// A capacity is negative.
    Negative {
        /// The pixel's index.
        pixel: usize,
    },
    /// The capacities at a pixel add up to more than `i32::MAX`.
    Overflow {
        /// The pixel's index.
        pixel: usize,
    },
}

impl fmt::Display for GridError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Length { slice, got, expected } => {
                write!(f, "{slice} has {got} entries where width x height is {expected}")
            }
            Self::Negative { pixel } => write!(f, "pixel {pixel} has a negative capacity"),
            Self::Overflow { pixel } => {
                write!(f, "the capacities at pixel {pixel} add up to more than {}", i32::MAX)
            }
        }
    }
}

impl std::error::Error for GridError {}

/// Offsets to the neighbours E, SE, S, SW.
const FORWARD: [(isize, isize); 4] = [(1, 0), (1, 1), (0, 1), (-1, 1)];

impl Grid<'_> {
    pub(crate) fn check(&self) -> Result<(), GridError> {
        let expected = self.width * self.height;
        let lengths = [
            ("mask", self.mask.len()),
            ("terminal", self.terminal.len()),
            ("neighbour", self.neighbour.len()),
        ];
        for (slice, got) in lengths {
            if got != expected {
                return Err(GridError::Length { slice, got, expected });
            }
        }
        let mut sums = vec![0i64; expected];
        for pixel in (0..expected).filter(|&p| self.mask[p]) {
            let [white, black] = self.terminal[pixel];
            if white < 0 || black < 0 || self.neighbour[pixel].iter().any(|&c| c < 0) {
                return Err(GridError::Negative { pixel });
            }
            sums[pixel] += i64::from(white) + i64::from(black);
            for (other, capacity) in self.edges(pixel) {
                sums[pixel] += i64::from(capacity);
                sums[other] += i64::from(capacity);
            }
        }
        match sums.iter().position(|&s| s > i64::from(i32::MAX)) {
            Some(pixel) => Err(GridError::Overflow { pixel }),
            None => Ok(()),
        }
    }

    /// The edges from a node to nodes E, SE, S and SW of it, with their capacities.
    pub(crate) fn edges(&self, pixel: usize) -> impl Iterator<Item = (usize, i32)> + '_ {
        (0..4).filter_map(move |e| Some((self.neighbour_of(pixel, e)?, self.neighbour[pixel][e])))
    }

    /// The node in direction `e` (E, SE, S, SW), if there is one.
    pub(crate) fn neighbour_of(&self, pixel: usize, e: usize) -> Option<usize> {
        let (dx, dy) = FORWARD[e];
        let x = (pixel % self.width).checked_add_signed(dx).filter(|&x| x < self.width)?;
        let y = (pixel / self.width).checked_add_signed(dy).filter(|&y| y < self.height)?;
        let other = y * self.width + x;
        self.mask[other].then_some(other)
    }
}

/// What a labelling costs. Panics when `labels` is shorter than the grid.
pub fn energy(grid: &Grid, labels: &[bool]) -> i64 {
    let mut sum = 0;
    for pixel in (0..grid.mask.len()).filter(|&p| grid.mask[p]) {
        let [white, black] = grid.terminal[pixel];
        sum += i64::from(if labels[pixel] { black } else { white });
        for (other, capacity) in grid.edges(pixel) {
            if labels[other] != labels[pixel] {
                sum += i64::from(capacity);
            }
        }
    }
    sum
}
