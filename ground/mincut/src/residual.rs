//! The residual graph: one record a pixel, in a frame of pixels without arcs.
//!
//! The frame spares the search every test for the border. Rows share it: the pixel right of a
//! row's last is the one left of the next row's first.

use crate::around::{STEPS, around, children, lowest, opposite, with, zero};
use crate::capacity::Capacity;
use crate::network::{Network, Side};
use crate::planes::{PLANES, Planes, RECORD, split};
use crate::prefetch::prefetch;
use crate::repair::Mutable;
use std::ops::Range;

/// Where the excess is in a record: from the white terminal if positive, to the black one if negative.
const EXCESS: usize = 8;
/// Where the open arcs are: a set of directions for those that arrive, above it one for those that leave.
const ARCS: usize = 9;

/// The directions to the row above and to the row below.
const NORTHWARD: i32 = 0b0000_0111;
const SOUTHWARD: i32 = 0b0111_0000;

/// The directions of the links: east, south-east, south, south-west.
const LINKS: [u8; 4] = [3, 4, 5, 6];

/// The framed records of a grid: eight residuals, the excess, the incoming arcs.
pub(crate) struct Residual<C> {
    pub(crate) width: usize,
    records: Vec<[C; RECORD]>,
    /// How far each direction is in `records`.
    offset: [isize; 8],
}

/// The number of records of a grid, its frame included.
pub(crate) fn framed(width: usize, height: usize) -> usize {
    (width + 1) * (height + 2) + 2
}

/// How far each direction is among rows `stride` apart.
fn offsets(stride: usize) -> [isize; 8] {
    STEPS.map(|(x, y)| x + y * stride as isize)
}

impl<C: Capacity> Residual<C> {
    /// A grid without any capacity.
    pub(crate) fn empty(width: usize, height: usize) -> Self {
        let stride = width + 1;
        let records = vec![[C::default(); RECORD]; framed(width, height)];
        Self { width, records, offset: offsets(stride) }
    }

    /// Makes records of the planes, in their place.
    pub(crate) fn new(planes: Planes<C>) -> Self {
        let Planes { width, height, mut records, start, .. } = planes;
        let (stride, length) = (width + 1, width * PLANES);
        let mut lines = [vec![C::default(); length], vec![C::default(); length]];
        let mut fields = vec![C::default(); width * RECORD];
        for y in 0..height {
            lines.swap(0, 1);
            lines[1].copy_from_slice(&records.as_flattened()[start + y * length..][..length]);
            read_fields(&mut fields, &mut lines, width);
            let row = &mut records[(y + 1) * stride..][..stride];
            row[0] = [C::default(); RECORD];
            write_records(&mut row[1..], &fields);
        }
        records[(height + 1) * stride..].fill([C::default(); RECORD]);
        Self { width, records, offset: offsets(stride) }
    }

    /// The number of picture rows.
    pub(crate) fn height(&self) -> usize {
        (self.records.len() - 2) / self.stride() - 2
    }

    /// Where row `y` is.
    pub(crate) fn row(&self, y: usize) -> Range<usize> {
        let start = (y + 1) * self.stride() + 1;
        start..start + self.width
    }

    /// The rows `rows` as a grid of their own: no arc leads out of it.
    pub(crate) fn band(&self, rows: Range<usize>) -> Self {
        let mut band = Self::empty(self.width, rows.len());
        band.place_rows(self, rows.clone(), 0);
        for (y, open) in
            [(0, !(NORTHWARD | NORTHWARD << 8)), (rows.len() - 1, !(SOUTHWARD | SOUTHWARD << 8))]
        {
            for v in band.row(y) {
                let arcs = &mut band.records[v][ARCS];
                *arcs = C::of(arcs.get() & open);
            }
        }
        band
    }

    /// Puts the rows of a band in their place, from row `row` on.
    pub(crate) fn place(&mut self, band: &Self, row: usize) {
        self.place_rows(band, 0..band.height(), row);
    }

    fn place_rows(&mut self, from: &Self, rows: Range<usize>, row: usize) {
        let height = rows.len();
        let source = &from.records[from.row(rows.start).start..from.row(rows.end - 1).end];
        let to = self.row(row).start..self.row(row + height - 1).end;
        self.records[to].copy_from_slice(source);
    }

    /// Closes the arcs between the rows `row - 1` and `row`.
    pub(crate) fn close_seam(&mut self, row: usize) {
        for v in self.row(row) {
            for d in [0, 1, 2] {
                self.open(v, d, [false; 2]);
                self.open(self.neighbour(v, d), opposite(d), [false; 2]);
            }
        }
    }

    /// Opens the arcs between the rows `row - 1` and `row` that have something left.
    pub(crate) fn open_seam(&mut self, row: usize) {
        for v in self.row(row) {
            for d in [0, 1, 2] {
                let w = self.neighbour(v, d);
                let forth = self.records[v][d] > C::default();
                let back = self.records[w][opposite(d)] > C::default();
                self.open(v, d, [forth, back]);
                self.open(w, opposite(d), [back, forth]);
            }
        }
    }

    /// Notes whether the arc `d` of `v` leaves and the one back arrives.
    fn open(&mut self, v: usize, d: usize, [leaves, arrives]: [bool; 2]) {
        let arcs = &mut self.records[v][ARCS];
        let bits = i32::from(leaves) << 8 | i32::from(arrives);
        *arcs = C::of(arcs.get() & !(0x101 << d) | bits << d);
    }

    /// What is left on a link of `v`: to the east, south-east, south, south-west.
    pub(crate) fn link(&self, v: usize, link: usize) -> i32 {
        self.records[v][usize::from(LINKS[link])].get()
    }

    /// How far apart rows are.
    #[inline(always)]
    fn stride(&self) -> usize {
        self.width + 1
    }

    /// The neighbour of `v` in direction `d`.
    #[inline(always)]
    fn neighbour(&self, v: usize, d: usize) -> usize {
        v.wrapping_add_signed(self.offset[d & 7])
    }

    /// The directions in which the tree can grow from `v`.
    #[inline(always)]
    fn away<T: Side>(&self, v: usize) -> u8 {
        let arcs = self.records[v][ARCS].get();
        if T::WHITE { (arcs >> 8) as u8 } else { arcs as u8 }
    }

    /// Notes that the arc `d` from `v` to `w` is closed or not and the one back is open.
    fn mark(&mut self, v: usize, d: usize, w: usize, closed: bool) {
        let (back, closed) = (opposite(d), i32::from(closed));
        let from = &mut self.records[v][ARCS];
        *from = C::of((from.get() | 1 << d) & !(closed << 8 << d));
        let to = &mut self.records[w][ARCS];
        *to = C::of((to.get() | 1 << 8 << back) & !(closed << back));
    }
}

impl<C: Capacity> Network for Residual<C> {
    type Arc = u8;
    type Label = C;
    const ROOT: u8 = 8;
    const NONE: u8 = 9;
    const LOST: u8 = 10;

    fn len(&self) -> usize {
        self.records.len()
    }

    #[inline(always)]
    fn excess(&self, v: usize) -> i64 {
        i64::from(self.records[v][EXCESS].get())
    }

    #[inline(always)]
    fn drain(&mut self, v: usize, amount: i64) -> bool {
        let excess = &mut self.records[v][EXCESS];
        let left = excess.get() - excess.get().signum() * amount as i32;
        *excess = C::of(left);
        left == 0
    }

    #[inline(always)]
    fn head(&self, v: usize, d: u8) -> usize {
        self.neighbour(v, usize::from(d))
    }

    #[inline(always)]
    fn back(&self, _: usize, d: u8) -> u8 {
        d ^ 4
    }

    #[inline(always)]
    fn residual(&self, v: usize, d: u8) -> i64 {
        i64::from(self.records[v][usize::from(d & 7)].get())
    }

    #[inline(always)]
    fn push(&mut self, v: usize, d: u8, amount: i64) -> bool {
        let d = usize::from(d & 7);
        let (w, amount) = (self.neighbour(v, d), amount as i32);
        let from = &mut self.records[v][d];
        let left = from.get() - amount;
        *from = C::of(left);
        let to = &mut self.records[w][opposite(d)];
        let before = to.get();
        *to = C::of(before + amount);
        if left == 0 || before == 0 {
            self.mark(v, d, w, left == 0);
        }
        left == 0
    }

    #[inline(always)]
    fn prefetch(&self, label: &[C], v: usize) {
        prefetch(&self.records, v);
        for row in [v - self.stride(), v, v + self.stride()] {
            prefetch(label, row);
        }
    }

    #[inline(always)]
    fn lowest<T: Side>(&self, label: &[C], v: usize) -> Option<(i32, u8)> {
        let distances = around(label, v, self.stride()).map(T::distance);
        lowest(distances, self.away::<T::Other>(v)).map(|(distance, d)| (distance, d as u8))
    }

    #[inline(always)]
    fn contact<T: Side>(&self, label: &[C], v: usize) -> Option<u8> {
        let distances = around(label, v, self.stride()).map(T::Other::distance);
        lowest(distances, self.away::<T>(v)).map(|(_, d)| d as u8)
    }

    #[inline(always)]
    fn each_free<T: Side>(
        &self,
        label: &mut [C],
        v: usize,
        mut take: impl FnMut(&mut [C], usize, u8),
    ) {
        let mut free = self.away::<T>(v) & zero(around(label, v, self.stride()));
        while free != 0 {
            let d = free.trailing_zeros() as usize;
            free &= free - 1;
            take(label, self.neighbour(v, d), opposite(d) as u8);
        }
    }

    #[inline(always)]
    fn each_lost<T: Side>(&self, parent: &[u8], v: usize, mut visit: impl FnMut(usize)) {
        let mut lost = self.away::<T>(v) & with(parent, v, self.stride(), Self::LOST);
        while lost != 0 {
            let d = lost.trailing_zeros() as usize;
            lost &= lost - 1;
            visit(self.neighbour(v, d));
        }
    }

    #[inline(always)]
    fn each_child(&self, parent: &mut [u8], v: usize, mut visit: impl FnMut(&mut [u8], usize)) {
        let mut kin = children(parent, v, self.stride());
        while kin != 0 {
            let d = kin.trailing_zeros() as usize;
            kin &= kin - 1;
            visit(parent, self.neighbour(v, d));
        }
    }
}

impl Residual<i16> {
    /// The same grid in 32 bits.
    pub(crate) fn widened(self) -> Residual<i32> {
        let wide = |record: [i16; RECORD]| record.map(i32::from);
        Residual {
            width: self.width,
            records: self.records.into_iter().map(wide).collect(),
            offset: self.offset,
        }
    }
}

impl Mutable for Residual<i32> {
    const BOUND: i64 = i32::LIMIT as i64;

    fn node(&self, pixel: usize) -> usize {
        self.row(pixel / self.width).start + pixel % self.width
    }

    fn arc(&self, _: usize, link: usize) -> Option<u8> {
        LINKS.get(link).copied()
    }

    fn add_excess(&mut self, v: usize, amount: i64) {
        self.records[v][EXCESS] += amount as i32;
    }

    fn set_residuals(&mut self, v: usize, d: u8, residuals: [i64; 2]) {
        let (w, back) = (self.head(v, d), self.back(v, d));
        for (v, d, residual, arriving) in
            [(v, d, residuals[0], residuals[1]), (w, back, residuals[1], residuals[0])]
        {
            let d = usize::from(d);
            self.records[v][d] = residual as i32;
            self.open(v, d, [residual > 0, arriving > 0]);
        }
    }

    fn each_neighbour(&self, v: usize, visit: impl FnMut(usize)) {
        (0..8).map(|d| self.neighbour(v, d)).for_each(visit);
    }
}

/// Computes the fields of the records of a row, one after the other, from the planes of the row
/// above and its own.
fn read_fields<C: Capacity>(fields: &mut [C], lines: &mut [Vec<C>; 2], width: usize) {
    let [above, here] = lines.each_mut().map(|line| split(line, width));
    let (residuals, rest) = fields.split_at_mut(8 * width);
    let (excess, arcs) = rest.split_at_mut(width);
    excess.copy_from_slice(here.excess);
    arcs.fill(C::default());
    let links = [
        (&above, 1),
        (&above, 2),
        (&above, 3),
        (&here, 0),
        (&here, 1),
        (&here, 2),
        (&here, 3),
        (&here, 0),
    ];
    for (d, (residual, (row, link))) in residuals.chunks_exact_mut(width).zip(links).enumerate() {
        let (capacity, flow) = (&*row.capacity[link], &*row.flow[link]);
        // Links to the north and west belong to the other pixel, and flow comes in over them.
        match d {
            0 | 7 => {
                residual[0] = C::default();
                read_arcs::<C, true>(
                    d,
                    &capacity[..width - 1],
                    flow,
                    &mut residual[1..],
                    &mut arcs[1..],
                );
            }
            1 => read_arcs::<C, true>(d, capacity, flow, residual, arcs),
            2 => {
                residual[width - 1] = C::default();
                read_arcs::<C, true>(d, &capacity[1..], &flow[1..], residual, arcs);
            }
            _ => read_arcs::<C, false>(d, capacity, flow, residual, arcs),
        }
    }
}

#[inline(always)]
fn read_arcs<C: Capacity, const INWARD: bool>(
    d: usize,
    capacity: &[C],
    flow: &[C],
    residual: &mut [C],
    arcs: &mut [C],
) {
    let (arriving, leaving) = (C::of(1 << d), C::of(1 << d << 8));
    for (((&capacity, &flow), residual), arcs) in capacity.iter().zip(flow).zip(residual).zip(arcs)
    {
        let flow = if INWARD { -flow } else { flow };
        let (out, back) = (capacity - flow, capacity + flow);
        *residual = out;
        let arrives = if back > C::default() { arriving } else { C::default() };
        let leaves = if out > C::default() { leaving } else { C::default() };
        *arcs = *arcs + arrives + leaves;
    }
}

/// Writes the records of a row from its fields.
fn write_records<C: Capacity>(records: &mut [[C; RECORD]], fields: &[C]) {
    let width = records.len();
    let fields: [&[C]; RECORD] = std::array::from_fn(|n| &fields[n * width..][..width]);
    for (x, record) in records.iter_mut().enumerate() {
        *record = std::array::from_fn(|n| fields[n][x]);
    }
}
