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

/// The directions whose neighbour holds the direction back to `v`.
#[inline(always)]
pub(crate) fn children(parents: &[u8], v: usize, stride: usize) -> u8 {
    const BACK: u64 = 0x0302_0100_0706_0504;
    equal(parents, v, stride, BACK)
}

/// The directions whose neighbour holds `value`.
#[inline(always)]
pub(crate) fn with(parents: &[u8], v: usize, stride: usize, value: u8) -> u8 {
    equal(parents, v, stride, u64::from_le_bytes([value; 8]))
}

/// The directions whose neighbour holds the byte of that direction in `bytes`.
#[inline(always)]
fn equal(parents: &[u8], v: usize, stride: usize, bytes: u64) -> u8 {
    const LOW: u64 = 0x7f7f_7f7f_7f7f_7f7f;
    let four = |start: usize| {
        u32::from_le_bytes(*parents[start..].first_chunk().expect("the frame surrounds a pixel"))
    };
    let (north, south) = (four(v - stride - 1) & 0xff_ffff, four(v + stride - 1).swap_bytes() >> 8);
    let (east, west) = (u32::from(parents[v + 1]), u32::from(parents[v - 1]));
    let around = u64::from(north | east << 24) | u64::from(south | west << 24) << 32;
    // No byte reaches 128: adding 127 sets the top bit of all but the zeros.
    let differs = (around ^ bytes) + LOW;
    ((!differs >> 7 & 0x0101_0101_0101_0101).wrapping_mul(0x0102_0408_1020_4080) >> 56) as u8
}
