//! The pre-pass: exact maximal flows along rows, columns and both diagonals.
//!
//! A chain of pixels has a maximal flow that two sweeps find, after the min-sum dynamic programme
//! on chains:
//!
//! 1. Forwards, every pixel hands its whole excess, of either sign, to the next one, as far as the
//!    bond between them allows. Opposite excesses meet and cancel; what is left at a pixel is
//!    blocked by a saturated bond.
//! 2. Backwards, what a pixel holds in vain goes back over the bond it came from. No excess then
//!    is larger than it was, nor of another sign.
//!
//! Columns and diagonals are swept row against row, so that the compiler makes vectors of them;
//! rows are swept four at a time. On pictures this routes most of the flow.

use crate::capacity::Capacity;
use crate::parts;
use crate::planes::{PLANES, Planes, Row, split};

/// Rows that are swept at once.
const BUNDLE: usize = 4;

/// Routes what flows along straight lines.
pub(crate) fn route<C: Capacity>(planes: &mut Planes<C>, threads: usize) {
    let width = planes.width;
    if width == 0 {
        return;
    }
    parts::each(planes.bands(threads, BUNDLE), |(_, values)| route_band(values, width));
    for (link, step) in [(2, 0), (1, 1), (3, -1)] {
        route_lines(planes, link, step);
    }
}

fn route_band<C: Capacity>(values: &mut [C], width: usize) {
    let length = width * PLANES;
    let mut bundles = values.chunks_exact_mut(BUNDLE * length);
    for bundle in &mut bundles {
        let mut rows = bundle.chunks_exact_mut(length);
        let next = |()| split(rows.next().expect("a bundle holds its rows"), width);
        route_rows([(); BUNDLE].map(next));
    }
    for row in bundles.into_remainder().chunks_exact_mut(length) {
        route_rows([split(row, width)]);
    }
}

/// Sweeps `K` rows at once to the east and back.
fn route_rows<C: Capacity, const K: usize>(rows: [Row<C>; K]) {
    let width = rows[0].excess.len();
    let mut rows = rows.map(|row| {
        let ([capacity, ..], [flow, ..]) = (row.capacity, row.flow);
        (&mut row.excess[..width], &capacity[..width], &mut flow[..width])
    });
    let mut carry = [C::default(); K];
    for x in 0..width {
        for ((excess, capacity, flow), carry) in rows.iter_mut().zip(&mut carry) {
            let held = excess[x] + *carry;
            *carry = held.clamp(-capacity[x], capacity[x]);
            excess[x] = held - *carry;
            flow[x] = *carry;
        }
    }
    let mut back = [C::default(); K];
    for x in (1..width).rev() {
        for ((excess, _, flow), back) in rows.iter_mut().zip(&mut back) {
            let held = excess[x] + *back;
            *back = returned(held, flow[x - 1]);
            excess[x] = held - *back;
            flow[x - 1] = flow[x - 1] - *back;
        }
    }
    for ((excess, ..), back) in rows.iter_mut().zip(back) {
        excess[0] = excess[0] + back;
    }
}

/// What a pixel that holds `excess` gives back of the `flow` that reached it.
#[inline(always)]
fn returned<C: Capacity>(excess: C, flow: C) -> C {
    excess.clamp(flow.min(C::default()), flow.max(C::default()))
}

/// Sweeps all lines that go down by one row and aside by `step` at once, down and back up.
fn route_lines<C: Capacity>(planes: &mut Planes<C>, link: usize, step: isize) {
    let height = planes.height;
    for y in 1..height {
        let (upper, excess) = pair(planes, y, link, step);
        push_down(upper, excess);
    }
    for y in (1..height).rev() {
        let (upper, excess) = pair(planes, y, link, step);
        give_back(upper, excess);
    }
}

/// The excess, capacity and flow of the pixels of row `y - 1` that have a link, and the excess of
/// the pixels of row `y` it leads to.
#[expect(clippy::type_complexity)]
fn pair<C: Capacity>(
    planes: &mut Planes<C>,
    y: usize,
    link: usize,
    step: isize,
) -> ((&mut [C], &mut [C], &mut [C]), &mut [C]) {
    let (width, length) = (planes.width, planes.width * PLANES);
    let (upper, lower) = planes.values()[(y - 1) * length..][..2 * length].split_at_mut(length);
    let (Row { excess, capacity, flow }, lower) = (split(upper, width), split(lower, width));
    let from = usize::from(step < 0)..width - usize::from(step > 0);
    let to = usize::from(step > 0)..width - usize::from(step < 0);
    let [capacity, flow] = [capacity, flow].map(|links| {
        let mut links = links.into_iter();
        &mut links.nth(link).expect("there are four links")[from.clone()]
    });
    ((&mut excess[from.clone()], capacity, flow), &mut lower.excess[to])
}

fn push_down<C: Capacity>(
    (above, capacity, flow): (&mut [C], &mut [C], &mut [C]),
    below: &mut [C],
) {
    let links = above.iter_mut().zip(below).zip(capacity).zip(flow);
    for (((above, below), capacity), flow) in links {
        *flow = (*above).clamp(-*capacity, *capacity);
        *above = *above - *flow;
        *below = *below + *flow;
    }
}

fn give_back<C: Capacity>((above, _, flow): (&mut [C], &mut [C], &mut [C]), below: &mut [C]) {
    for ((above, below), flow) in above.iter_mut().zip(below).zip(flow) {
        let back = returned(*below, *flow);
        *flow = *flow - back;
        *below = *below - back;
        *above = *above + back;
    }
}
