//! Several labels: a grid whose pixels take one of `k` labels, at a price, and whose neighbours pay
//! for the distance between theirs.
//!
//! | distance | data | solver | result |
//! |---|---|---|---|
//! | [`Distance::Tones`] | convex over the tones | nested cuts, `log2 k` of them ([`solve_ordered`]) | exact |
//! | [`Distance::Tones`], [`Distance::Convex`] | any | one cut of a layered graph ([`solve_ordered`]) | exact |
//! | [`Distance::Tones`], [`Distance::Metric`] | any | cuts in turn, one label each ([`expand`]) | within a factor of the best |

mod expansion;
mod layered;
mod nested;
mod ordered;
mod stack;

pub use expansion::{Expansion, expand, expand_stack};
pub use ordered::solve_ordered;
pub use stack::LabelStack;

use crate::grid::{Grid, GridError};
use crate::sparse::GraphError;
use std::fmt;

/// The most labels: they are stored in bytes.
pub const MAX_LABELS: usize = 256;
/// The largest price of a label, and the largest distance times neighbour capacity: 2^25.
pub const MAX_PRICE: i32 = 1 << 25;

/// A grid of pixels that take labels `0..labels`.
#[derive(Clone, Copy, Debug)]
pub struct LabelGrid<'a> {
    /// Pixels in a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// The number of labels, from 1 to [`MAX_LABELS`].
    pub labels: usize,
    /// Which pixels are nodes; the others have no price and no edges.
    pub mask: &'a [bool],
    /// What each pixel pays for each label, `labels` values a pixel, from 0 to [`MAX_PRICE`].
    pub data: &'a [i32],
    /// To the east, south-east, south and south-west: the price of a unit of distance between the
    /// labels of the two pixels. Ignored where an edge leaves the picture or touches an unmasked
    /// pixel.
    pub neighbour: &'a [[i32; 4]],
    /// How far labels are apart.
    pub distance: Distance<'a>,
}

/// How far two labels are apart.
#[derive(Clone, Copy, Debug)]
pub enum Distance<'a> {
    /// `|t_l - t_m|`, the total variation of ascending tones `t`, one a label.
    Tones(&'a [i32]),
    /// `g(|l - m|)` for a convex `g`, as `g(0) = 0, g(1), ..`, one value a label.
    Convex(&'a [i32]),
    /// Any metric: `labels` rows of `labels` values.
    Metric(&'a [i32]),
}

/// Labels of pixels and what they cost.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Labelling {
    /// One label a pixel, 0 outside the mask.
    pub labels: Vec<u8>,
    /// The sum of all prices and distances paid.
    pub energy: i64,
}

/// Why a [`LabelGrid`] has no labelling.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum LabelError {
    /// The pixels or neighbours are no grid.
    Grid(GridError),
    /// The layered graph is too large.
    Graph(GraphError),
    /// No label, or more than [`MAX_LABELS`].
    Labels(usize),
    /// A slice of the wrong length.
    Length {
        /// The name of the slice.
        slice: &'static str,
        /// Its length.
        got: usize,
        /// The length it should have.
        expected: usize,
    },
    /// A price outside 0 to [`MAX_PRICE`].
    Price(i32),
    /// A neighbour capacity whose product with the largest distance is beyond [`MAX_PRICE`].
    TooFar {
        /// The neighbour capacity.
        neighbour: i32,
        /// The largest distance.
        distance: i64,
    },
    /// The distance is not what the solver needs.
    Distance(&'static str),
}

impl fmt::Display for LabelError {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Self::Grid(error) => error.fmt(f),
            Self::Graph(error) => error.fmt(f),
            Self::Labels(got) => write!(f, "{got} labels; there are 1 to {MAX_LABELS}"),
            Self::Length { slice, got, expected } => {
                write!(f, "`{slice}` has {got} values where {expected} are expected")
            }
            Self::Price(got) => {
                write!(f, "a price is {got}; prices are from 0 to {MAX_PRICE}")
            }
            Self::TooFar { neighbour, distance } => write!(
                f,
                "a neighbour capacity of {neighbour} times a distance of {distance} is beyond {MAX_PRICE}; \
                 scale all capacities down"
            ),
            Self::Distance(why) => f.write_str(why),
        }
    }
}

impl std::error::Error for LabelError {}

impl From<GridError> for LabelError {
    fn from(error: GridError) -> Self {
        Self::Grid(error)
    }
}

impl From<GraphError> for LabelError {
    fn from(error: GraphError) -> Self {
        Self::Graph(error)
    }
}

impl Distance<'_> {
    /// The distance between two of `labels` labels.
    pub(crate) fn between(&self, labels: usize, a: usize, b: usize) -> i64 {
        match self {
            Self::Tones(tones) => (i64::from(tones[a]) - i64::from(tones[b])).abs(),
            Self::Convex(values) => i64::from(values[a.abs_diff(b)]),
            Self::Metric(values) => i64::from(values[a * labels + b]),
        }
    }

    fn check(&self, labels: usize) -> Result<(), LabelError> {
        let (slice, got, expected) = match self {
            Self::Tones(tones) => ("tones", tones.len(), labels),
            Self::Convex(values) => ("convex", values.len(), labels),
            Self::Metric(values) => ("metric", values.len(), labels * labels),
        };
        if got != expected {
            return Err(LabelError::Length { slice, got, expected });
        }
        let holds = match self {
            Self::Tones(tones) => tones.is_sorted_by(|a, b| a < b),
            Self::Convex(g) => g[0] == 0 && slopes(g).is_sorted() && slopes(g).all(|s| s >= 0),
            Self::Metric(_) => self.is_metric(labels),
        };
        let why = match self {
            Self::Tones(_) => "the tones do not ascend; sort them",
            Self::Convex(_) => "the distances are not convex from 0 on; give differences that grow",
            Self::Metric(_) => {
                "the distances are no metric; make them symmetric, positive, and no detour shorter"
            }
        };
        if holds { Ok(()) } else { Err(LabelError::Distance(why)) }
    }

    fn is_metric(&self, labels: usize) -> bool {
        let d = |a, b| self.between(labels, a, b);
        (0..labels).all(|a| {
            (0..labels).all(|b| {
                let detour = (0..labels).map(|c| d(a, c) + d(c, b)).min().unwrap_or(0);
                d(a, b) == d(b, a) && (d(a, b) > 0) == (a != b) && d(a, b) <= detour
            })
        })
    }
}

fn slopes(values: &[i32]) -> impl Iterator<Item = i64> + '_ {
    values.windows(2).map(|w| i64::from(w[1]) - i64::from(w[0]))
}

impl<'a> LabelGrid<'a> {
    /// The price of `label` at a pixel.
    pub(crate) fn price(&self, pixel: usize, label: usize) -> i64 {
        i64::from(self.data[pixel * self.labels + label])
    }

    /// The neighbours as a grid, with terminals that nobody looks at.
    pub(crate) fn grid(&self, terminal: &'a [[i32; 2]]) -> Grid<'a> {
        let Self { width, height, mask, neighbour, .. } = *self;
        Grid { width, height, mask, terminal, neighbour }
    }

    /// Holds the problem to the bounds that every solver relies on.
    pub(crate) fn check(&self) -> Result<(), LabelError> {
        if !(1..=MAX_LABELS).contains(&self.labels) {
            return Err(LabelError::Labels(self.labels));
        }
        self.grid(&vec![[0; 2]; self.mask.len()]).check()?;
        let expected = self.mask.len() * self.labels;
        if self.data.len() != expected {
            let got = self.data.len();
            return Err(LabelError::Length { slice: "data", got, expected });
        }
        if let Some(&got) = self.data.iter().find(|&&c| !(0..=MAX_PRICE).contains(&c)) {
            return Err(LabelError::Price(got));
        }
        self.distance.check(self.labels)?;
        let all = (0..self.labels).flat_map(|a| (0..self.labels).map(move |b| (a, b)));
        let farthest =
            all.map(|(a, b)| self.distance.between(self.labels, a, b)).max().unwrap_or(0);
        let strongest = self.neighbour.as_flattened().iter().copied().max().unwrap_or(0);
        if i64::from(strongest).saturating_mul(farthest) > i64::from(MAX_PRICE) {
            return Err(LabelError::TooFar { neighbour: strongest, distance: farthest });
        }
        Ok(())
    }

    /// The edges between nodes: a pixel, the link, and the pixel it leads to.
    pub(crate) fn edges(&self) -> impl Iterator<Item = (usize, usize, usize)> + '_ {
        let (width, height) = (self.width, self.height);
        let steps = [(1, 0), (1, 1), (0, 1), (-1, 1)];
        (0..self.mask.len()).filter(|&p| self.mask[p]).flat_map(move |p| {
            steps.into_iter().enumerate().filter_map(move |(link, (dx, dy))| {
                let (x, y) = ((p % width).checked_add_signed(dx)?, p / width + dy);
                let q = y * width + x;
                let inside = x < width && y < height && self.mask[q];
                inside.then_some((p, link, q))
            })
        })
    }

    /// What `labels` cost.
    ///
    /// # Panics
    /// When a slice is of the wrong length, or a label is not below `self.labels`.
    pub fn energy(&self, labels: &[u8]) -> i64 {
        assert_eq!(labels.len(), self.mask.len(), "one label a pixel");
        let nodes = (0..labels.len()).filter(|&p| self.mask[p]);
        let data: i64 = nodes.map(|p| self.price(p, labels[p].into())).sum();
        let between = |a: u8, b: u8| self.distance.between(self.labels, a.into(), b.into());
        let edges = self
            .edges()
            .map(|(p, link, q)| i64::from(self.neighbour[p][link]) * between(labels[p], labels[q]));
        data + edges.sum::<i64>()
    }
}
