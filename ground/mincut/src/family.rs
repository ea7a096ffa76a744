//! [`Family`]: all minimal cuts over a shift of the terminals, solved at once.
//!
//! When every pixel's pull to white grows together, white regions only grow: the canonical cuts are
//! nested (Gallo, Grigoriadis and Tarjan 1989). A pixel then has a *breakpoint*, the least shift at
//! which it is white, and the plane of breakpoints holds every cut.
//!
//! They are found by divide and conquer. Each pixel has an interval that holds its breakpoint; a
//! cut at the interval's middle halves it. Pixels with the same interval form a sub-problem, and
//! towards all others they are bound: who has a lower interval is white by then, who has a higher
//! one is still black. So the sub-problems of a round touch nowhere, and one search over the grid
//! solves them all.
//!
//! The flow is kept from round to round. Where a cut parts two pixels the link is saturated; it will
//! not be asked again and is taken out, and the flow over it stays with its ends as if they were
//! terminals, which is just what binding them means. Inside a sub-problem only the shift changes, by
//! half as much in each round.

use crate::capacity::Capacity;
use crate::grid::{Grid, GridError};
use crate::network::Network;
use crate::repair::Mutable;
use crate::residual::Residual;
use crate::search::Search;
use crate::solved;
use std::ops::RangeInclusive;

/// The canonical minimal cuts of a grid for every shift in a range.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Family {
    shifts: [i32; 2],
    breakpoints: Vec<i32>,
}

impl Family {
    /// Solves `grid` with every whole number of `shifts` added to `white - black` of each pixel. The
    /// range ends before `i32::MAX`.
    ///
    /// # Errors
    /// As [`solve`](crate::solve).
    pub fn new(grid: &Grid, shifts: RangeInclusive<i32>) -> Result<Self, GridError> {
        grid.check()?;
        let shifts = [*shifts.start(), (*shifts.end()).min(i32::MAX - 1)];
        let members = (i64::from(shifts[1]) - i64::from(shifts[0]) + 1).max(0);
        let found = first_white(grid, shifts[0].into(), members as u32);
        let breakpoint = |(&member, &node): (&u32, &bool)| {
            let shift = i64::from(shifts[0]) + i64::from(member);
            if node && shift <= i64::from(shifts[1]) { shift as i32 } else { i32::MAX }
        };
        let breakpoints = found.iter().zip(grid.mask).map(breakpoint).collect();
        Ok(Self { shifts, breakpoints })
    }

    /// Of each pixel the least shift at which it is white, the first of the range if it always is;
    /// `i32::MAX` if it never is, and outside the mask.
    pub fn breakpoints(&self) -> &[i32] {
        &self.breakpoints
    }

    /// The labels of the canonical cut at a shift, `true` for white.
    ///
    /// # Panics
    /// When the shift is not one of the range.
    pub fn labels(&self, shift: i32) -> Vec<bool> {
        assert!(
            (self.shifts[0]..=self.shifts[1]).contains(&shift),
            "a shift of the family's range"
        );
        self.breakpoints.iter().map(|&b| b <= shift && b != i32::MAX).collect()
    }
}

/// Of each pixel the first member in which it is white, `members` if none: the one whose shift is
/// `first` counts as 0.
fn first_white(grid: &Grid, first: i64, members: u32) -> Vec<u32> {
    let mut intervals = vec![[0, members]; grid.mask.len()];
    if intervals.is_empty() || members == 0 {
        return vec![0; intervals.len()];
    }
    let bound = i64::from(i32::LIMIT);
    let pull = |pixel: usize, member: u32| {
        let [white, black] = grid.terminal[pixel].map(i64::from);
        (white - black + first + i64::from(member)).clamp(-bound, bound)
    };
    let start = (0..intervals.len()).map(|p| pull(p, middle([0, members])) as i32);
    let terminal: Vec<[i32; 2]> = start.map(|p| [p.max(0), (-p).max(0)]).collect();
    let start = Grid { terminal: &terminal, ..*grid };
    let (mut search, _) = solved::<i32>(&start, 1).expect("a checked grid fits 32 bits");
    loop {
        part(grid, &mut search, &intervals);
        if !halve(grid, &mut search, &mut intervals, &pull) {
            return intervals.iter().map(|&[low, _]| low).collect();
        }
        search.restart();
        search.run().expect("a path is shorter than the range of 32 bits");
    }
}

/// Takes out the links that the cut of a sub-problem parts.
fn part(grid: &Grid, search: &mut Search<Residual<i32>>, intervals: &[[u32; 2]]) {
    let (width, height) = (grid.width, grid.height);
    for pixel in (0..intervals.len()).filter(|&p| is_open(grid, intervals, p)) {
        let (x, y) = (pixel % width, pixel / width);
        let v = search.network.node(pixel);
        let ends = [(x + 1, y), (x + 1, y + 1), (x, y + 1), (x.wrapping_sub(1), y + 1)];
        for (link, (u, row)) in ends.into_iter().enumerate() {
            if u >= width || row >= height {
                continue;
            }
            let end = row * width + u;
            let w = search.network.node(end);
            let parts = grid.mask[end]
                && intervals[end] == intervals[pixel]
                && search.is_white(v) != search.is_white(w);
            if let (true, Some(arc)) = (parts, search.network.arc(v, link)) {
                search.network.set_residuals(v, arc, [0; 2]);
            }
        }
    }
}

/// Halves the intervals by the labels and shifts each pixel to its new middle; whether any interval
/// is still open.
fn halve(
    grid: &Grid,
    search: &mut Search<Residual<i32>>,
    intervals: &mut [[u32; 2]],
    pull: &impl Fn(usize, u32) -> i64,
) -> bool {
    let mut any = false;
    for pixel in 0..intervals.len() {
        if !is_open(grid, intervals, pixel) {
            continue;
        }
        let v = search.network.node(pixel);
        let [low, high] = intervals[pixel];
        let before = middle([low, high]);
        let now = if search.is_white(v) { [low, before] } else { [before + 1, high] };
        intervals[pixel] = now;
        let change = if now[0] < now[1] {
            any = true;
            pull(pixel, middle(now)) - pull(pixel, before)
        } else {
            // Done: nothing flows to it or from it.
            -search.network.excess(v)
        };
        search.network.add_excess(v, change);
    }
    any
}

/// Whether a pixel is a node whose breakpoint is not known yet.
fn is_open(grid: &Grid, intervals: &[[u32; 2]], pixel: usize) -> bool {
    grid.mask[pixel] && intervals[pixel][0] < intervals[pixel][1]
}

/// The member at which an interval is halved.
fn middle([low, high]: [u32; 2]) -> u32 {
    low + (high - low) / 2
}
