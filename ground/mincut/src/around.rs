//! The eight directions of a framed grid.
//!
//! Clockwise from the north-west, so that the opposite of direction `d` is `d ^ 4`.

/// Where `d` points, as steps in x and y.
pub(crate) const STEPS: [(isize, isize); 8] =
    [(-1, -1), (0, -1), (1, -1), (1, 0), (1, 1), (0, 1), (-1, 1), (-1, 0)];

/// The direction from a neighbour back.
pub(crate) fn opposite(direction: usize) -> usize {
    direction ^ 4
}
