//! The eight neighbours of a pixel, looked at all at once and without branches.
//!
//! Directions run clockwise from the north-west, so that the opposite of `d` is `d ^ 4`. Sets of
//! directions are bit masks.

use crate::capacity::Capacity;

/// Where `d` points, as steps in x and y.
pub(crate) const STEPS: [(isize, isize); 8] =
    [(-1, -1), (0, -1), (1, -1), (1, 0), (1, 1), (0, 1), (-1, 1), (-1, 0)];

/// The direction from a neighbour back.
#[inline(always)]
pub(crate) const fn opposite(direction: usize) -> usize {
    direction ^ 4
}

/// The values around `v` in a plane with rows `stride` apart.
#[inline(always)]
pub(crate) fn around<C: Capacity>(plane: &[C], v: usize, stride: usize) -> [i32; 8] {
    let row =
        |start: usize| plane[start..].first_chunk::<3>().expect("the frame surrounds a pixel");
    let (north, middle, south) = (row(v - stride - 1), row(v - 1), row(v + stride - 1));
    let [a, b, c] = north.map(C::get);
    let [h, _, d] = middle.map(C::get);
    let [g, f, e] = south.map(C::get);
    [a, b, c, d, e, f, g, h]
}

/// The least value above zero among `directions`, and where it is.
#[inline(always)]
pub(crate) fn lowest(values: [i32; 8], directions: u8) -> Option<(i32, usize)> {
    // A key holds a value less one above its direction; what does not count has the top bit set.
    let key = |d: usize| {
        let unlisted = u64::from(!directions) << (63 - d) & 1 << 63;
        ((i64::from(values[d]) - 1) << 3 | d as i64) as u64 | unlisted
    };
    let low = |a: u64, b: u64| a.min(b);
    let least = low(
        low(low(key(0), key(1)), low(key(2), key(3))),
        low(low(key(4), key(5)), low(key(6), key(7))),
    );
    (least >> 63 == 0).then_some(((least >> 3) as i32 + 1, (least & 7) as usize))
}

/// Where the values are zero.
#[inline(always)]
pub(crate) fn zero(values: [i32; 8]) -> u8 {
    (0..8).fold(0, |set, d| set | u8::from(values[d] == 0) << d)
}

/// Where the values are above `low` and at most `high`.
#[inline(always)]
pub(crate) fn between(values: [i32; 8], low: i32, high: i32) -> u8 {
    (0..8).fold(0, |set, d| set | u8::from(values[d] > low && values[d] <= high) << d)
}
