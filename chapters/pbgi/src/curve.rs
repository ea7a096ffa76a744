//! The Hilbert curve through a cube: places that are near along it are near in space.
//!
//! Coordinates become the index by Skilling's method ("Programming the Hilbert curve", 2004), bits
//! of the three interleaved, the highest first. A prefix of an index names a smaller cube.

use chiaro_basis::math::Vec3;

/// Bits of a coordinate.
pub const BITS: u32 = 16;

/// A cube that holds everything.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Cube {
    /// Its lowest corner.
    pub low: Vec3,
    /// Its side.
    pub side: f32,
}

impl Cube {
    /// The smallest cube at the lowest corner of a box.
    pub fn around(low: Vec3, high: Vec3) -> Self {
        let side = (high - low).max_element();
        Self { low, side: if side.is_finite() { side.max(f32::MIN_POSITIVE) } else { 1.0 } }
    }

    /// The index along the curve of the cell that holds a point.
    pub fn index(&self, point: Vec3) -> u64 {
        let last = ((1u32 << BITS) - 1) as f32;
        let scaled = (point - self.low) * (last / self.side);
        hilbert(scaled.to_array().map(|c| c.clamp(0.0, last) as u32))
    }
}

/// Where the highest bit changes in which keys differ, of things sorted by them; the middle where keys are equal.
pub(crate) fn half<T>(sorted: &[T], key: impl Fn(&T) -> u64) -> usize {
    let (first, last) = (key(&sorted[0]), key(&sorted[sorted.len() - 1]));
    match (first ^ last).checked_ilog2() {
        Some(bit) => sorted.partition_point(|t| key(t) >> bit == first >> bit),
        None => sorted.len() / 2,
    }
}

/// The index of a cell along the curve.
fn hilbert(mut x: [u32; 3]) -> u64 {
    let highest = 1 << (BITS - 1);
    let mut bit: u32 = highest;
    while bit > 1 {
        let below = bit - 1;
        for i in 0..3 {
            if x[i] & bit != 0 {
                x[0] ^= below;
            } else {
                let swap = (x[0] ^ x[i]) & below;
                x[0] ^= swap;
                x[i] ^= swap;
            }
        }
        bit >>= 1;
    }
    x[1] ^= x[0];
    x[2] ^= x[1];
    let mut turn = 0;
    bit = highest;
    while bit > 1 {
        if x[2] & bit != 0 {
            turn ^= bit - 1;
        }
        bit >>= 1;
    }
    let [a, b, c] = x.map(|v| spread(v ^ turn));
    a << 2 | b << 1 | c
}

/// Bits with two gaps after each.
fn spread(coordinate: u32) -> u64 {
    let mut x = u64::from(coordinate);
    x = (x | x << 32) & 0x001f_0000_0000_ffff;
    x = (x | x << 16) & 0x001f_0000_ff00_00ff;
    x = (x | x << 8) & 0x100f_00f0_0f00_f00f;
    x = (x | x << 4) & 0x10c3_0c30_c30c_30c3;
    (x | x << 2) & 0x1249_2492_4924_9249
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_that_follow_each_other_touch() {
        let side = 1 << BITS;
        let n = 16;
        let scale = side / n;
        let mut cells: Vec<(u64, [u32; 3])> = (0..n * n * n)
            .map(|i| {
                let cell = [i % n, i / n % n, i / (n * n)];
                (hilbert(cell.map(|c| c * scale)) / u64::from(scale).pow(3), cell)
            })
            .collect();
        cells.sort_unstable();
        assert!(cells.iter().enumerate().all(|(i, c)| c.0 == i as u64));
        for pair in cells.windows(2) {
            let steps: u32 = (0..3).map(|k| pair[0].1[k].abs_diff(pair[1].1[k])).sum();
            assert_eq!(steps, 1);
        }
    }
}
