//! The residual graph: one record a pixel, in a frame of pixels without arcs.
//!
//! The frame spares the search every test for the border. Rows share it: the pixel right of a
//! row's last is the one left of the next row's first.

use crate::around::{STEPS, opposite};
use crate::capacity::Capacity;
use crate::planes::{PLANES, Planes, RECORD, split};

/// Where the excess is in a record: from the white terminal if positive, to the black one if negative.
const EXCESS: usize = 8;
/// Where the open arcs are: a set of directions for those that arrive, above it one for those that leave.
const ARCS: usize = 9;

/// The framed records of a grid: eight residuals, the excess, the incoming arcs.
pub(crate) struct Residual<C> {
    pub(crate) width: usize,
    pub(crate) height: usize,
    records: Vec<[C; RECORD]>,
    /// How far each direction is in `records`.
    offset: [isize; 8],
}

impl<C: Capacity> Residual<C> {
    /// Makes records of the planes, in their place.
    pub(crate) fn new(planes: Planes<C>) -> Self {
        let Planes { width, height, mut records, start, .. } = planes;
        let (stride, length) = (width + 1, width * PLANES);
        let offset = STEPS.map(|(x, y)| x + y * stride as isize);
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
        Self { width, height, records, offset }
    }

    /// The number of framed pixels.
    pub(crate) fn len(&self) -> usize {
        self.records.len()
    }

    /// How far apart rows are.
    #[inline(always)]
    pub(crate) fn stride(&self) -> usize {
        self.width + 1
    }

    /// Where row `y` begins.
    pub(crate) fn row(&self, y: usize) -> usize {
        (y + 1) * self.stride() + 1
    }

    /// The neighbour of `v` in direction `d`.
    #[inline(always)]
    pub(crate) fn neighbour(&self, v: usize, d: usize) -> usize {
        v.wrapping_add_signed(self.offset[d & 7])
    }

    #[inline(always)]
    pub(crate) fn excess(&self, v: usize) -> i32 {
        self.records[v][EXCESS].get()
    }

    /// Takes `amount` of the excess of `v`; whether nothing is left.
    #[inline(always)]
    pub(crate) fn drain(&mut self, v: usize, amount: i32) -> bool {
        let excess = &mut self.records[v][EXCESS];
        let left = excess.get() - excess.get().signum() * amount;
        *excess = C::of(left);
        left == 0
    }

    /// What can flow from `v` in direction `d`.
    #[inline(always)]
    pub(crate) fn capacity(&self, v: usize, d: usize) -> i32 {
        self.records[v][d & 7].get()
    }

    /// The directions in which `v` has an open arc.
    #[inline(always)]
    pub(crate) fn outgoing(&self, v: usize) -> u8 {
        (self.records[v][ARCS].get() >> 8) as u8
    }

    /// The directions from which `v` has an open arc.
    #[inline(always)]
    pub(crate) fn incoming(&self, v: usize) -> u8 {
        self.records[v][ARCS].get() as u8
    }

    /// Moves `amount` from `v` to its neighbour in direction `d`; whether that closes the arc.
    #[inline(always)]
    pub(crate) fn push(&mut self, v: usize, d: usize, amount: i32) -> bool {
        let (w, back) = (self.neighbour(v, d), opposite(d & 7));
        let from = &mut self.records[v][d & 7];
        let left = from.get() - amount;
        *from = C::of(left);
        let to = &mut self.records[w][back];
        let before = to.get();
        *to = C::of(before + amount);
        if left == 0 || before == 0 {
            self.mark(v, d & 7, w, left == 0);
        }
        left == 0
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
