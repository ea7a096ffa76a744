//! [`Lattice`]: the general grid problem as the caller states it, its checks, and the cost of a
//! labelling.
//!
//! Four, eight or sixteen neighbours; capacities that are the same both ways or not; a stack of
//! frames, each pixel linked to at most one of the previous frame; pixels that must be white or
//! black. A [`Grid`] is the lattice of one frame with eight neighbours, alike both ways.

use crate::grid::{Grid, GridError, MAX_NEIGHBOUR, MAX_PIXELS};

/// The steps of the links, in order: the first two make four neighbours, the first four eight, all
/// sixteen. East, south-east, south, south-west, then the knight's moves clockwise from the east.
pub const LINK_STEPS: [(isize, isize); 8] =
    [(1, 0), (1, 1), (0, 1), (-1, 1), (2, 1), (1, 2), (-1, 2), (-2, 1)];

/// The steps of the two links of four neighbours: east, south.
const FOUR_STEPS: [(isize, isize); 2] = [(1, 0), (0, 1)];

/// The capacities of `L` links of each pixel.
#[derive(Clone, Copy, Debug)]
pub enum Links<'a, const L: usize> {
    /// Paid when the two pixels differ.
    Symmetric(&'a [[i32; L]]),
    /// `[forth, back]`: `forth` is paid when this pixel is white and the one the link leads to
    /// black, `back` when it is the other way round.
    Directed(&'a [[[i32; 2]; L]]),
}

impl<const L: usize> Links<'_, L> {
    fn len(&self) -> usize {
        match self {
            Self::Symmetric(links) => links.len(),
            Self::Directed(links) => links.len(),
        }
    }

    #[inline]
    fn at(&self, pixel: usize, link: usize) -> [i32; 2] {
        match self {
            Self::Symmetric(links) => [links[pixel][link]; 2],
            Self::Directed(links) => links[pixel][link],
        }
    }
}

/// Which pixels of a frame are neighbours, and their capacities from 0 to [`MAX_NEIGHBOUR`].
///
/// Ignored where a link leaves the frame or touches an unmasked pixel.
#[derive(Clone, Copy, Debug)]
pub enum Neighbours<'a> {
    /// Links to the east and south.
    Four(Links<'a, 2>),
    /// Links to the east, south-east, south and south-west.
    Eight(Links<'a, 4>),
    /// The links of [`LINK_STEPS`].
    Sixteen(Links<'a, 8>),
}

impl Neighbours<'_> {
    /// The steps of its links, as x and y.
    pub fn steps(&self) -> &'static [(isize, isize)] {
        match self {
            Self::Four(_) => &FOUR_STEPS,
            Self::Eight(_) => &LINK_STEPS[..4],
            Self::Sixteen(_) => &LINK_STEPS,
        }
    }

    fn len(&self) -> usize {
        match self {
            Self::Four(links) => links.len(),
            Self::Eight(links) => links.len(),
            Self::Sixteen(links) => links.len(),
        }
    }

    /// The capacities `[forth, back]` of a link.
    #[inline]
    pub(crate) fn at(&self, pixel: usize, link: usize) -> [i32; 2] {
        match self {
            Self::Four(links) => links.at(pixel, link),
            Self::Eight(links) => links.at(pixel, link),
            Self::Sixteen(links) => links.at(pixel, link),
        }
    }
}

/// From a pixel to one of the previous frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TimeLink {
    /// The pixel of the previous frame, `y * width + x`.
    pub to: u32,
    /// `[forth, back]`, from 0 to [`MAX_NEIGHBOUR`]: `forth` is paid when this pixel is white and
    /// the previous one black, `back` when it is the other way round.
    pub capacity: [i32; 2],
}

/// A stack of frames of pixels; every slice holds `width * height * frames` values, frame by frame,
/// row-major, x to the right, y down, unless it may be empty.
#[derive(Clone, Copy, Debug)]
pub struct Lattice<'a> {
    /// Pixels in a row.
    pub width: usize,
    /// Rows of a frame.
    pub height: usize,
    /// Frames.
    pub frames: usize,
    /// Which pixels are nodes; the others have no cost and no links.
    pub mask: &'a [bool],
    /// `[white, black]`, both 0 or more: `white` is paid when the pixel ends black, `black` when it
    /// ends white.
    pub terminal: &'a [[i32; 2]],
    /// The links within a frame.
    pub neighbours: Neighbours<'a>,
    /// The link of each pixel to the previous frame; empty if there are none. Several may lead to
    /// one pixel. Those of the first frame must be `None`; those that touch an unmasked pixel are
    /// ignored.
    pub time: &'a [Option<TimeLink>],
    /// The label a pixel must have, whatever it costs; empty if all are free.
    pub fixed: &'a [Option<bool>],
}

impl<'a> From<&Grid<'a>> for Lattice<'a> {
    fn from(grid: &Grid<'a>) -> Self {
        Self {
            width: grid.width,
            height: grid.height,
            frames: 1,
            mask: grid.mask,
            terminal: grid.terminal,
            neighbours: Neighbours::Eight(Links::Symmetric(grid.neighbour)),
            time: &[],
            fixed: &[],
        }
    }
}

impl Lattice<'_> {
    /// The number of pixels.
    pub fn pixels(&self) -> usize {
        self.width * self.height * self.frames
    }

    /// The pixel to which link `link` of `pixel` leads, if both are nodes. The link after the last
    /// neighbour's is the one in time.
    pub(crate) fn end(&self, pixel: usize, link: usize) -> Option<usize> {
        let Some(&step) = self.neighbours.steps().get(link) else {
            return self.time_end(pixel);
        };
        let end = neighbour(self.width, self.height, pixel, step)?;
        (self.mask[pixel] && self.mask[end]).then_some(end)
    }

    /// The links of a pixel that have a capacity and lead to a node.
    pub(crate) fn each_link(&self, pixel: usize, mut visit: impl FnMut(usize, [i32; 2])) {
        let (row, x) = (pixel / self.width, pixel % self.width);
        let y = row % self.height;
        for (link, &(dx, dy)) in self.neighbours.steps().iter().enumerate() {
            let (u, v) = (x.wrapping_add_signed(dx), y.wrapping_add_signed(dy));
            if u < self.width && v < self.height {
                let end = pixel.wrapping_add_signed(dy * self.width as isize + dx);
                let capacity = self.neighbours.at(pixel, link);
                if capacity != [0; 2] && self.mask[pixel] && self.mask[end] {
                    visit(link, capacity);
                }
            }
        }
        if self.time_end(pixel).is_some() {
            let link = self.neighbours.steps().len();
            visit(link, self.capacity(pixel, link));
        }
    }

    fn time_end(&self, pixel: usize) -> Option<usize> {
        let link = (*self.time.get(pixel)?)?;
        let frame = self.width * self.height;
        let end = (pixel / frame - 1) * frame + link.to as usize;
        (self.mask[pixel] && self.mask[end]).then_some(end)
    }

    /// The capacities `[forth, back]` of a link; the one after the last neighbour's is in time.
    pub(crate) fn capacity(&self, pixel: usize, link: usize) -> [i32; 2] {
        if link < self.neighbours.steps().len() {
            return self.neighbours.at(pixel, link);
        }
        self.time.get(pixel).copied().flatten().map_or([0; 2], |link| link.capacity)
    }

    /// Links of a pixel, the one in time included if there is any.
    pub(crate) fn links(&self) -> usize {
        self.neighbours.steps().len() + usize::from(!self.time.is_empty())
    }

    /// Holds the lattice to the bounds that every later step relies on.
    ///
    /// # Errors
    /// A slice of the wrong length, a negative or too large capacity, a link that leaves its frame,
    /// or more than [`MAX_PIXELS`] pixels.
    pub fn check(&self) -> Result<(), GridError> {
        let (width, height) = (self.width, self.height.saturating_mul(self.frames));
        let too_many = GridError::TooManyPixels { width, height };
        let pixels = width.checked_mul(height).filter(|&n| n <= MAX_PIXELS).ok_or(too_many)?;
        let lengths = [
            ("mask", self.mask.len()),
            ("terminal", self.terminal.len()),
            ("neighbours", self.neighbours.len()),
            ("time", if self.time.is_empty() { pixels } else { self.time.len() }),
            ("fixed", if self.fixed.is_empty() { pixels } else { self.fixed.len() }),
        ];
        if let Some((slice, got)) = lengths.into_iter().find(|&(_, got)| got != pixels) {
            return Err(GridError::Length { slice, got, expected: pixels });
        }
        (0..pixels).try_for_each(|pixel| self.check_pixel(pixel))
    }

    fn check_pixel(&self, pixel: usize) -> Result<(), GridError> {
        let place = || (pixel % self.width, pixel / self.width);
        if let Some(&got) = self.terminal[pixel].iter().find(|&&c| c < 0) {
            let (x, y) = place();
            return Err(GridError::Negative { x, y, got });
        }
        for link in 0..self.links() {
            let capacity = self.capacity(pixel, link);
            if capacity.iter().any(|c| !(0..=MAX_NEIGHBOUR).contains(c)) {
                let (x, y) = place();
                capacity.into_iter().try_for_each(|c| check_link(x, y, c))?;
            }
        }
        match self.time.get(pixel).copied().flatten() {
            Some(link)
                if place().1 < self.height || link.to as usize >= self.width * self.height =>
            {
                let (x, y) = place();
                Err(GridError::TimeLink { x, y, to: link.to })
            }
            _ => Ok(()),
        }
    }

    /// The cost of `labels` (`true` is white): the terminals and links they cut. What is fixed
    /// costs nothing by itself.
    ///
    /// # Panics
    /// When the lattice does not pass [`Lattice::check`], or there is not one label a pixel.
    pub fn energy(&self, labels: &[bool]) -> i64 {
        assert_eq!(labels.len(), self.pixels(), "one label a pixel");
        let nodes = (0..labels.len()).filter(|&pixel| self.mask[pixel]);
        nodes.map(|pixel| self.pixel_energy(labels, pixel)).sum()
    }

    fn pixel_energy(&self, labels: &[bool], pixel: usize) -> i64 {
        let white = labels[pixel];
        let link = |link| match self.end(pixel, link) {
            Some(end) if labels[end] != white => {
                i64::from(self.capacity(pixel, link)[usize::from(!white)])
            }
            _ => 0,
        };
        let links = (0..self.links()).map(link).sum::<i64>();
        i64::from(self.terminal[pixel][usize::from(white)]) + links
    }
}

/// The pixel one step from `pixel` in a stack of frames, if the frame holds it.
pub(crate) fn neighbour(
    width: usize,
    height: usize,
    pixel: usize,
    (dx, dy): (isize, isize),
) -> Option<usize> {
    let (row, x) = (pixel / width, (pixel % width).checked_add_signed(dx)?);
    let y = (row % height).checked_add_signed(dy)?;
    (x < width && y < height).then(|| (row - row % height + y) * width + x)
}

/// Holds the capacity of a link of pixel (x, y) to its bounds.
pub(crate) fn check_link(x: usize, y: usize, got: i32) -> Result<(), GridError> {
    match got {
        0..=MAX_NEIGHBOUR => Ok(()),
        ..0 => Err(GridError::Negative { x, y, got }),
        _ => Err(GridError::TooLarge { x, y, got }),
    }
}
