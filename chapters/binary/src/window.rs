//! A window of frames as one graph: each frame's own, joined along the motion.
//!
//! 1. Where each frame's own cut agrees with the frame before all along a material point's way
//!    through the window, and no disagreement is near, the labels stand: the volume to be cut is
//!    the rest. In films that is a small part, around borders that move and regions that flip.
//! 2. What stands, in the window or known around it, becomes part of the prices: a bond to a white
//!    pixel makes all but white dearer by its capacity.
//! 3. The rest is cut exactly, from the start: to begin with the flow of the window before saves a
//!    tenth of a cut where shapes move within the picture and costs as much where all of it moves,
//!    since most of the time goes into taking the capacities up.
//!
//! More than two labels are found by expansions, beginning with the frames' own.
//!
//! Guaranteed: an energy no higher than that of the frames' own cuts, and deterministic labels. Not
//! guaranteed: the least energy of the whole window, where it would take a change farther than
//! `MARGIN` from any disagreement.

use crate::cel::{Cel, all_apart};
use crate::geometry::EDGES;
use crate::hold::Hold;
use crate::knob::scaled;
use chiaro_basis::{Error, Result};
use chiaro_image::Plane;
use chiaro_mincut::{
    Distance, LabelGrid, LabelStack, Lattice, Links, Neighbours, Solver, TimeLink, expand_stack,
};
use chiaro_trace::UNLINKED;

/// How far around a disagreement labels are decided anew, in pixels at 480.
const MARGIN: f32 = 8.0;

/// What is settled around a window.
#[derive(Default)]
pub(crate) struct Known<'a> {
    /// The labels of the frame before the first.
    pub(crate) before: Option<&'a Plane<u8>>,
    /// The frame after the last.
    pub(crate) after: Option<Bond<'a>>,
}

/// Links to a frame whose labels are known, from the one after the window.
#[derive(Clone, Copy)]
pub(crate) struct Bond<'a> {
    /// For each pixel of the frame the pixel that it was, in the one before.
    pub(crate) links: &'a Plane<u32>,
    /// The labels of the frame.
    pub(crate) labels: &'a Plane<u8>,
    /// What the links are worth.
    pub(crate) hold: Hold<'a>,
}

/// The labels of a layer of consecutive frames, cut together; `holds` is what the links of each frame
/// to the one before are worth.
pub(crate) fn cut_window(
    (cels, layer): (&[&Cel], usize),
    holds: &[Hold<'_>],
    known: &Known,
) -> Result<Vec<Plane<u8>>> {
    let volume = Volume::new((cels, layer), holds, known);
    let (width, height) = cels[0].graph.mask.size();
    let labels = volume.solve(width, height)?;
    Ok(labels
        .chunks(width * height)
        .map(|f| Plane::from_pixels(width, height, f.to_vec()))
        .collect())
}

/// Frames one after the other, flat.
struct Volume<'a> {
    cels: &'a [&'a Cel],
    /// Pixels of a frame.
    frame: usize,
    /// What the links of each frame to the one before are worth.
    holds: &'a [Hold<'a>],
    /// How many labels there are.
    count: usize,
    /// Each frame's own labels.
    alone: Vec<u8>,
    /// What is decided anew.
    free: Vec<bool>,
    /// What each pixel pays for each label, with all that stands around.
    prices: Vec<i32>,
}

/// Makes all labels of a pixel but one dearer.
pub(crate) fn pull(prices: &mut [i32], label: u8, capacity: i32) {
    for (l, price) in prices.iter_mut().enumerate() {
        if l != usize::from(label) {
            *price += capacity;
        }
    }
}

impl<'a> Volume<'a> {
    fn new((cels, layer): (&'a [&'a Cel], usize), holds: &'a [Hold<'a>], known: &Known) -> Self {
        let mut volume = Self {
            cels,
            frame: cels[0].graph.mask.len(),
            holds,
            count: cels[0].count(layer),
            alone: cels.iter().flat_map(|c| c.own(layer).0.pixels()).copied().collect(),
            free: Vec::new(),
            prices: cels.iter().flat_map(|c| c.prices(layer)).copied().collect(),
        };
        volume.free = volume.disagreements(known);
        volume.spread_along_links();
        volume.widen(scaled(MARGIN, cels[0].graph.mask.height()).ceil() as usize);
        volume.hold_painted();
        volume.pull_of_known(known);
        volume.pull_of_neighbours();
        volume.pull_of_links();
        volume
    }

    /// The links within the window: a pixel and the one it was, both counted through the volume.
    fn links(&self) -> impl Iterator<Item = (usize, usize)> + '_ {
        self.cels.iter().enumerate().skip(1).flat_map(move |(i, cel)| {
            let (here, before) = (i * self.frame, (i - 1) * self.frame);
            let linked = cel.links.pixels().iter().enumerate().filter(|(_, to)| **to != UNLINKED);
            linked.map(move |(p, to)| (here + p, before + *to as usize))
        })
    }

    /// What the link of a pixel of the volume is worth.
    fn hold(&self, p: usize) -> i32 {
        self.holds[p / self.frame].at(p % self.frame)
    }

    /// Pixels whose own label is not that of the pixel they were, and those pixels.
    fn disagreements(&self, known: &Known) -> Vec<bool> {
        let mut marked = vec![false; self.alone.len()];
        for (p, q) in self.links() {
            if self.alone[p] != self.alone[q] {
                (marked[p], marked[q]) = (true, true);
            }
        }
        if let Some(before) = known.before {
            for (p, to) in self.cels[0].links.pixels().iter().enumerate() {
                marked[p] |= *to != UNLINKED && before.pixels()[*to as usize] != self.alone[p];
            }
        }
        if let Some(Bond { links, labels, .. }) = known.after {
            let last = self.alone.len() - self.frame;
            for (to, label) in links.pixels().iter().zip(labels.pixels()) {
                if *to != UNLINKED && self.alone[last + *to as usize] != *label {
                    marked[last + *to as usize] = true;
                }
            }
        }
        marked
    }

    /// Marks the whole way of every marked material point.
    fn spread_along_links(&mut self) {
        let links: Vec<(usize, usize)> = self.links().collect();
        for (p, q) in &links {
            self.free[*p] |= self.free[*q];
        }
        for (p, q) in links.iter().rev() {
            self.free[*q] |= self.free[*p];
        }
    }

    /// Marks all within `reach` pixels of what is marked, in a square.
    fn widen(&mut self, reach: usize) {
        let (width, height) = self.cels[0].graph.mask.size();
        for frame in self.free.chunks_mut(self.frame.max(1)) {
            for row in frame.chunks_mut(width) {
                widen_line(row, 0, 1, width, reach);
            }
            for x in 0..width {
                widen_line(frame, x, width, height, reach);
            }
        }
    }

    /// What is painted stands: a frame's own cut has its label.
    fn hold_painted(&mut self) {
        for (cel, free) in self.cels.iter().zip(self.free.chunks_mut(self.frame.max(1))) {
            let Some(painted) = &cel.painted else { continue };
            for (free, painted) in free.iter_mut().zip(painted.pixels()) {
                *free &= painted.is_none();
            }
        }
    }

    fn pull_of_known(&mut self, known: &Known) {
        if let Some(before) = known.before {
            for (p, to) in self.cels[0].links.pixels().iter().enumerate() {
                if *to != UNLINKED {
                    self.draw(p, before.pixels()[*to as usize], self.hold(p));
                }
            }
        }
        if let Some(Bond { links, labels, hold }) = known.after {
            let last = self.alone.len() - self.frame;
            for (p, (to, label)) in links.pixels().iter().zip(labels.pixels()).enumerate() {
                if *to != UNLINKED {
                    self.draw(last + *to as usize, *label, hold.at(p));
                }
            }
        }
    }

    /// Draws a pixel to a label.
    fn draw(&mut self, p: usize, label: u8, capacity: i32) {
        pull(&mut self.prices[p * self.count..][..self.count], label, capacity);
    }

    /// A bond between what stands and what is free draws the free one.
    fn bind(&mut self, p: usize, q: usize, capacity: i32) {
        if self.free[p] != self.free[q] {
            let (free, stands) = if self.free[p] { (p, q) } else { (q, p) };
            self.draw(free, self.alone[stands], capacity);
        }
    }

    fn pull_of_neighbours(&mut self) {
        for (i, cel) in self.cels.iter().enumerate() {
            let mask = &cel.graph.mask;
            let (width, height) = mask.size();
            for p in 0..self.frame {
                let (x, y) = (p % width, p / width);
                for (e, (dx, dy)) in EDGES.into_iter().enumerate() {
                    let (u, v) = (x.wrapping_add_signed(dx), y.wrapping_add_signed(dy));
                    if u < width && v < height && mask.pixels()[p] && mask[(u, v)] {
                        let start = i * self.frame;
                        let capacity = cel.graph.neighbour.pixels()[p][e];
                        self.bind(start + p, start + v * width + u, capacity);
                    }
                }
            }
        }
    }

    fn pull_of_links(&mut self) {
        let links: Vec<(usize, usize)> = self.links().collect();
        for (p, q) in links {
            self.bind(p, q, self.hold(p));
        }
    }

    /// The labels of all frames. What is free is cut within the box that holds it in every frame.
    fn solve(self, width: usize, height: usize) -> Result<Vec<u8>> {
        let nodes = self.cels.iter().flat_map(|c| c.graph.mask.pixels());
        let free: Vec<bool> = nodes.zip(&self.free).map(|(m, f)| *m && *f).collect();
        let Some(crop) = Crop::around(&free, width, height) else { return Ok(self.alone) };
        let mask = crop.of(&free);
        let neighbour: Vec<[i32; 4]> =
            self.cels.iter().flat_map(|c| crop.of(c.graph.neighbour.pixels())).collect();
        let mut time: Vec<Option<TimeLink>> = vec![None; mask.len()];
        for (p, q) in self.links().filter(|(p, q)| free[*p] && free[*q]) {
            let to = (crop.place(q) % crop.pixels()) as u32;
            time[crop.place(p)] = Some(TimeLink { to, capacity: [self.hold(p); 2] });
        }
        let found = match self.count {
            2 => self.cut(&crop, &mask, &neighbour, &time)?,
            _ => self.expanded(&crop, &mask, &neighbour, &time)?,
        };
        let mut labels = self.alone;
        for (p, label) in labels.iter_mut().enumerate().filter(|(p, _)| free[*p]) {
            *label = found[crop.place(p)];
        }
        Ok(labels)
    }

    /// Two labels, by one cut.
    fn cut(
        &self,
        crop: &Crop,
        mask: &[bool],
        neighbour: &[[i32; 4]],
        time: &[Option<TimeLink>],
    ) -> Result<Vec<u8>> {
        let terminal = crop.of(self.prices.as_chunks::<2>().0);
        let lattice = Lattice {
            width: crop.size.0,
            height: crop.size.1,
            frames: self.cels.len(),
            mask,
            terminal: &terminal,
            neighbours: Neighbours::Eight(Links::Symmetric(neighbour)),
            time,
            fixed: &[],
        };
        let solver = Solver::new(&lattice)
            .map_err(|e| Error::setting("window", e, "a window that the cut can hold"))?;
        Ok(solver.labels().iter().map(|w| u8::from(*w)).collect())
    }

    /// More labels, by expansions.
    fn expanded(
        &self,
        crop: &Crop,
        mask: &[bool],
        neighbour: &[[i32; 4]],
        time: &[Option<TimeLink>],
    ) -> Result<Vec<u8>> {
        let prices = |frame: usize, p: usize| {
            let at = (frame * self.frame + p) * self.count;
            &self.prices[at..at + self.count]
        };
        let frames = 0..self.cels.len();
        let data: Vec<i32> = frames
            .flat_map(|f| crop.pixels_of_frame().flat_map(move |p| prices(f, p)))
            .copied()
            .collect();
        let apart = all_apart(self.count);
        let grid = LabelGrid {
            width: crop.size.0,
            height: crop.size.1 * self.cels.len(),
            labels: self.count,
            mask,
            data: &data,
            neighbour,
            distance: Distance::Metric(&apart),
        };
        let stack = LabelStack { grid, frames: self.cels.len(), time };
        let found = expand_stack(&stack, &crop.of(&self.alone))
            .map_err(|e| Error::setting("window", e, "a window that the cut can hold"))?;
        Ok(found.labelling.labels)
    }
}

/// A box of pixels, the same in every frame of a volume.
struct Crop {
    /// Width and height of a whole frame.
    frame: (usize, usize),
    /// The upper left pixel.
    first: (usize, usize),
    /// Width and height.
    size: (usize, usize),
}

impl Crop {
    /// The smallest box that holds all marks; `None` without any.
    fn around(marks: &[bool], width: usize, height: usize) -> Option<Self> {
        let (mut first, mut last) = ((width, height), (0, 0));
        for (i, row) in marks.chunks(width).enumerate() {
            let Some(left) = row.iter().position(|m| *m) else { continue };
            let right = row.iter().rposition(|m| *m).unwrap_or(left);
            let y = i % height;
            first = (first.0.min(left), first.1.min(y));
            last = (last.0.max(right), last.1.max(y));
        }
        (first.0 <= last.0).then(|| Self {
            frame: (width, height),
            first,
            size: (last.0 - first.0 + 1, last.1 - first.1 + 1),
        })
    }

    fn pixels(&self) -> usize {
        self.size.0 * self.size.1
    }

    /// The places in a whole frame of its pixels, row by row.
    fn pixels_of_frame(&self) -> impl Iterator<Item = usize> + '_ {
        let row = |y: usize| (y * self.frame.0 + self.first.0..).take(self.size.0);
        (self.first.1..self.first.1 + self.size.1).flat_map(row)
    }

    /// Where a pixel of the volume is in the cropped one.
    fn place(&self, p: usize) -> usize {
        let (width, height) = self.frame;
        let (t, y, x) = (p / (width * height), p / width % height, p % width);
        (t * self.size.1 + y - self.first.1) * self.size.0 + x - self.first.0
    }

    /// The box of some frames.
    fn of<T: Copy>(&self, frames: &[T]) -> Vec<T> {
        let (width, height) = self.frame;
        let rows = self.first.1..self.first.1 + self.size.1;
        let columns = self.first.0..self.first.0 + self.size.0;
        frames
            .chunks(width * height)
            .flat_map(|frame| frame.chunks(width).take(rows.end).skip(rows.start))
            .flat_map(|row| row[columns.clone()].iter().copied())
            .collect()
    }
}

/// Widens the marks of a line of `count` entries, `step` apart from `start` on.
pub(crate) fn widen_line(
    marks: &mut [bool],
    start: usize,
    step: usize,
    count: usize,
    reach: usize,
) {
    let at = |i: usize| start + i * step;
    let was: Vec<bool> = (0..count).map(|i| marks[at(i)]).collect();
    let mut until = 0;
    for i in 0..count {
        if was.get(i + reach) == Some(&true) {
            until = i + 2 * reach + 1;
        }
        if i == 0
            && let Some(first) = was[..reach.min(count)].iter().rposition(|m| *m)
        {
            until = until.max(first + reach + 1);
        }
        marks[at(i)] = i < until;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn marks_widen_by_their_reach_on_both_sides() {
        for reach in [0, 1, 3, 20] {
            let was: Vec<bool> = (0..30).map(|i| [2, 14, 15, 29].contains(&i)).collect();
            let mut marks = was.clone();
            widen_line(&mut marks, 0, 1, 30, reach);
            for (i, mark) in marks.iter().enumerate() {
                let near = was.iter().enumerate().any(|(j, m)| *m && i.abs_diff(j) <= reach);
                assert_eq!(*mark, near, "{i}, reach {reach}");
            }
        }
    }

    #[test]
    fn a_crop_holds_every_mark_and_finds_its_pixels() {
        let (width, height) = (7, 5);
        let marked = [(0, 2, 1), (1, 5, 3)];
        let mut marks = vec![false; 2 * width * height];
        for (t, x, y) in marked {
            marks[(t * height + y) * width + x] = true;
        }
        let crop = Crop::around(&marks, width, height).expect("there are marks");
        assert_eq!((crop.first, crop.size), ((2, 1), (4, 3)));
        let cropped = crop.of(&marks);
        assert_eq!(cropped.iter().filter(|m| **m).count(), 2);
        for (p, _) in marks.iter().enumerate().filter(|(_, m)| **m) {
            assert!(cropped[crop.place(p)]);
        }
        assert!(Crop::around(&[false; 35], width, height).is_none());
    }
}
