//! [`Grid`]: the problem as the caller states it, its checks, and the cost of a labelling.
//!
//! The bounds checked here are what keeps every later sum from overflowing.

use crate::parts;
use std::fmt;
use std::ops::Range;

/// The most pixels a grid may have: 2^27. Every cost then fits an `i64`, every index a `u32`.
pub const MAX_PIXELS: usize = 1 << 27;

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
    /// A link in time from the first frame, or to a pixel that its previous frame does not have.
    TimeLink {
        /// Column of the pixel.
        x: usize,
        /// Row of the pixel, counted on over the frames.
        y: usize,
        /// Where the link leads.
        to: u32,
    },
    /// No such node: outside the lattice or its mask.
    NoPixel {
        /// The index given.
        got: usize,
        /// The number of pixels.
        pixels: usize,
    },
    /// No such link: it leaves the frame or touches an unmasked pixel, or there is none.
    NoLink {
        /// The pixel.
        pixel: usize,
        /// The index of the link.
        link: usize,
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
            Self::TimeLink { x, y, to } => write!(
                f,
                "the link in time of pixel ({x}, {y}) leads to pixel {to}, which no previous frame has; \
                 leave it out"
            ),
            Self::NoPixel { got, pixels } => write!(
                f,
                "pixel {got} is no node of the {pixels} pixels; give one that the mask includes"
            ),
            Self::NoLink { pixel, link } => write!(
                f,
                "pixel {pixel} has no link {link} to another node; change one that it has"
            ),
        }
    }
}

impl std::error::Error for GridError {}

impl Grid<'_> {
    /// Holds the grid to the bounds that every later step relies on.
    pub(crate) fn check(&self) -> Result<(), GridError> {
        self.check_on(1)
    }

    /// The same on up to `threads` threads.
    pub(crate) fn check_on(&self, threads: usize) -> Result<(), GridError> {
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
            None => self.check_capacities(threads),
        }
    }

    /// Finds the worst sign and size in one branch-free pass, and the culprit only if there is one.
    fn check_capacities(&self, threads: usize) -> Result<(), GridError> {
        let is_sound = |pixels: Range<usize>| {
            let terminal = self.terminal[pixels.clone()].as_flattened();
            let signs = terminal.iter().fold(0, |s, &c| s | c);
            let bits = self.neighbour[pixels].as_flattened().iter().fold(0, |s, &c| s | c);
            signs >= 0 && (0..=MAX_NEIGHBOUR).contains(&bits)
        };
        if parts::each(parts::ranges(self.mask.len(), threads, 1), is_sound).iter().all(|&s| s) {
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
    energy_of(grid, labels, 0..grid.height)
}

/// What some rows pay, with their links to the row below.
pub(crate) fn energy_of(grid: &Grid, labels: &[bool], rows: Range<usize>) -> i64 {
    let mut kinds = [vec![0; grid.width + 2], vec![0; grid.width + 2]];
    read_kinds(grid, labels, rows.start, &mut kinds[1]);
    let row = |y| {
        kinds.swap(0, 1);
        read_kinds(grid, labels, y + 1, &mut kinds[1]);
        row_energy(grid, y, &kinds[0], &kinds[1])
    };
    rows.map(row).sum()
}

/// Marks row `y` with 1 for black, 2 for white, 0 for no node, framed by one pixel; a row below
/// the picture has no node.
fn read_kinds(grid: &Grid, labels: &[bool], y: usize, kinds: &mut [i32]) {
    let start = y * grid.width;
    let kinds = &mut kinds[1..=grid.width];
    match grid.mask.get(start..start + grid.width) {
        Some(mask) => {
            for ((kind, &node), &white) in kinds.iter_mut().zip(mask).zip(&labels[start..]) {
                *kind = if node { 1 + i32::from(white) } else { 0 };
            }
        }
        None => kinds.fill(0),
    }
}

/// What row `y` pays: its terminals, and its neighbours to the east and in the row below.
fn row_energy(grid: &Grid, y: usize, here: &[i32], below: &[i32]) -> i64 {
    let pixels = y * grid.width..(y + 1) * grid.width;
    let (terminal, neighbour) = (&grid.terminal[pixels.clone()], &grid.neighbour[pixels]);
    let (here, below) = (&here[..terminal.len() + 2], &below[..terminal.len() + 2]);
    let paid = |cost: i32, pays: bool| i64::from(if pays { cost } else { 0 });
    let mut sum = 0;
    for (x, (&[white, black], bonds)) in terminal.iter().zip(neighbour).enumerate() {
        let kind = here[x + 1];
        let differs = [here[x + 2], below[x + 2], below[x + 1], below[x]].map(|k| kind ^ k == 3);
        sum += paid(white, kind == 1) + paid(black, kind == 2);
        sum += (0..4).map(|d| paid(bonds[d], differs[d])).sum::<i64>();
    }
    sum
}
