//! Nested cuts: the levels of ordered labels, found by divide and conquer.
//!
//! When the pull to white grows from member to member, the canonical cuts are nested. Each pixel has
//! an interval that holds the first member in which it is white; a cut at the interval's middle
//! halves it. Pixels with the same interval form a sub-problem, and towards all others they are
//! bound: who has a lower interval is white by then, who has a higher one is still black. So the
//! sub-problems of a round touch nowhere, and one cut of the grid solves them all.

use crate::grid::{Grid, GridError};
use crate::solve;

/// More than what all neighbours of a pixel can pay: as good as bound.
const BOUND: i64 = 1 << 30;

/// A family of cuts, its members counted from 0, on the grid's mask.
pub(super) struct Nested<'a, P, B> {
    /// The neighbours; the terminals are not looked at.
    pub(super) grid: &'a Grid<'a>,
    /// What draws a pixel to white in a member. It must not fall from one member to the next.
    pub(super) pull: P,
    /// What neighbour capacities are multiplied by in a member. Pulls are compared to it.
    pub(super) bond: B,
}

impl<P: Fn(usize, u32) -> i64, B: Fn(u32) -> i32> Nested<'_, P, B> {
    /// Of each pixel the first member in which it is white, `members` if none.
    pub(super) fn solve(&self, members: u32) -> Result<Vec<u32>, GridError> {
        let pixels = self.grid.mask.len();
        let mut intervals = vec![[0, members]; pixels];
        let mut terminal = vec![[0; 2]; pixels];
        let mut neighbour = vec![[0; 4]; pixels];
        let mut open = self.grid.mask.to_vec();
        loop {
            for (open, [low, high]) in open.iter_mut().zip(&intervals) {
                *open &= low < high;
            }
            if !open.contains(&true) {
                return Ok(intervals.iter().map(|&[low, _]| low).collect());
            }
            self.part(&open, &intervals, &mut terminal, &mut neighbour);
            let (width, height) = (self.grid.width, self.grid.height);
            let grid =
                Grid { width, height, mask: &open, terminal: &terminal, neighbour: &neighbour };
            let cut = solve(&grid)?;
            for (pixel, interval) in intervals.iter_mut().enumerate().filter(|(p, _)| open[*p]) {
                let middle = middle(*interval);
                *interval = if cut.labels[pixel] {
                    [interval[0], middle]
                } else {
                    [middle + 1, interval[1]]
                };
            }
        }
    }

    /// States the cut at the middle of each interval; neighbours of other intervals are bound.
    fn part(
        &self,
        open: &[bool],
        intervals: &[[u32; 2]],
        terminal: &mut [[i32; 2]],
        neighbour: &mut [[i32; 4]],
    ) {
        let (width, height) = (self.grid.width, self.grid.height);
        let mut pulls = vec![0i64; 2 * width];
        for y in 0..height {
            // The row below gathers what this one binds; its own pull is added when it comes up.
            pulls.copy_within(width.., 0);
            pulls[width..].fill(0);
            for x in 0..width {
                let pixel = y * width + x;
                let ends = [(x + 1, y), (x + 1, y + 1), (x, y + 1), (x.wrapping_sub(1), y + 1)];
                for (link, (u, v)) in ends.into_iter().enumerate() {
                    neighbour[pixel][link] = 0;
                    if u >= width || v >= height {
                        continue;
                    }
                    let end = v * width + u;
                    if !(self.grid.mask[pixel] && self.grid.mask[end]) {
                        continue;
                    }
                    let capacity = self.grid.neighbour[pixel][link];
                    let (here, there) = (intervals[pixel], intervals[end]);
                    if here == there {
                        if open[pixel] {
                            neighbour[pixel][link] = capacity * (self.bond)(middle(here));
                        }
                        continue;
                    }
                    // The lower interval is white when the higher one is cut.
                    let sign = if here[0] < there[0] { 1 } else { -1 };
                    let paid = |p: usize| {
                        let bond = if open[p] { (self.bond)(middle(intervals[p])) } else { 0 };
                        i64::from(capacity) * i64::from(bond)
                    };
                    pulls[x] -= sign * paid(pixel);
                    pulls[u + width * (v - y)] += sign * paid(end);
                }
                if open[pixel] {
                    let pull = pulls[x] + (self.pull)(pixel, middle(intervals[pixel]));
                    let pull = pull.clamp(-BOUND, BOUND) as i32;
                    terminal[pixel] = [pull.max(0), (-pull).max(0)];
                }
            }
        }
    }
}

/// The member at which an interval is halved.
fn middle([low, high]: [u32; 2]) -> u32 {
    low + (high - low) / 2
}
