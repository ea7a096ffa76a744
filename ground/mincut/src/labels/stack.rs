//! A stack of frames of labels: grids one below the other, linked through time.

use super::{LabelError, LabelGrid, MAX_PRICE};
use crate::grid::GridError;
use crate::lattice::{TimeLink, check_link};

/// Frames of pixels that take labels; a pixel may be linked to one of the frame before.
#[derive(Clone, Copy, Debug)]
pub struct LabelStack<'a> {
    /// The frames, one below the other: its height is that of a frame times their number. Edges that
    /// lead from one frame into the next are ignored.
    pub grid: LabelGrid<'a>,
    /// The number of frames; it divides the height.
    pub frames: usize,
    /// The link of each pixel to the frame before; empty if there are none. Its capacity is the
    /// price of a unit of distance and the same both ways; that back is not looked at. Links of the
    /// first frame must be `None`; those that touch an unmasked pixel are ignored.
    pub time: &'a [Option<TimeLink>],
}

impl LabelStack<'_> {
    /// The pixels of a frame.
    pub(super) fn frame(&self) -> usize {
        self.grid.mask.len() / self.frames.max(1)
    }

    /// Holds the problem to the bounds that every solver relies on.
    pub(super) fn check(&self) -> Result<(), LabelError> {
        self.grid.check()?;
        let whole = self.frames > 0 && self.grid.height.is_multiple_of(self.frames);
        let (got, expected) = (self.time.len(), self.grid.mask.len());
        if !whole || !(got == 0 || got == expected) {
            return Err(LabelError::Length { slice: "time", got, expected });
        }
        let (frame, farthest) = (self.frame(), self.farthest());
        for (p, link) in self.time.iter().enumerate() {
            let Some(link) = link else { continue };
            let (x, y) = (p % self.grid.width, p / self.grid.width);
            check_link(x, y, link.capacity[0])?;
            if p < frame || link.to as usize >= frame {
                return Err(GridError::NoLink { pixel: p, link: 4 }.into());
            }
            if i64::from(link.capacity[0]).saturating_mul(farthest) > i64::from(MAX_PRICE) {
                let neighbour = link.capacity[0];
                return Err(LabelError::TooFar { neighbour, distance: farthest });
            }
        }
        Ok(())
    }

    fn farthest(&self) -> i64 {
        let count = self.grid.labels;
        let all = (0..count).flat_map(|a| (0..count).map(move |b| (a, b)));
        all.map(|(a, b)| self.grid.distance.between(count, a, b)).max().unwrap_or(0)
    }

    /// The edges within frames between nodes: a pixel, the link, and the pixel it leads to.
    pub(super) fn edges(&self) -> impl Iterator<Item = (usize, usize, usize)> + '_ {
        let frame = self.frame().max(1);
        self.grid.edges().filter(move |(p, _, q)| p / frame == q / frame)
    }

    /// The links through time between nodes: a pixel, the one it was, and their price.
    pub(super) fn time_edges(&self) -> impl Iterator<Item = (usize, usize, i64)> + '_ {
        let frame = self.frame().max(1);
        let linked = self.time.iter().enumerate().filter_map(move |(p, link)| {
            let link = (*link)?;
            let q = (p / frame - 1) * frame + link.to as usize;
            Some((p, q, i64::from(link.capacity[0])))
        });
        linked.filter(|(p, q, _)| self.grid.mask[*p] && self.grid.mask[*q])
    }

    /// What `labels` cost.
    ///
    /// # Panics
    /// When a slice is of the wrong length, or a label is not below the number of labels.
    pub fn energy(&self, labels: &[u8]) -> i64 {
        let grid = &self.grid;
        assert_eq!(labels.len(), grid.mask.len(), "one label a pixel");
        let nodes = (0..labels.len()).filter(|&p| grid.mask[p]);
        let data: i64 = nodes.map(|p| grid.price(p, labels[p].into())).sum();
        let apart = |p: usize, q: usize| {
            grid.distance.between(grid.labels, labels[p].into(), labels[q].into())
        };
        let within = self.edges().map(|(p, e, q)| i64::from(grid.neighbour[p][e]) * apart(p, q));
        let through = self.time_edges().map(|(p, q, weight)| weight * apart(p, q));
        data + within.sum::<i64>() + through.sum::<i64>()
    }
}
