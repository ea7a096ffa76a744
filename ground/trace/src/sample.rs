//! Well-spread points in [0, 1)^2, for any number of dimensions: Sobol's (0, 2) sequence, shuffled
//! and scrambled anew for each pair of dimensions (Owen scrambling by hashing, after Laine and
//! Karras 2011 and Burley 2020).
//!
//! Guaranteed: the first 2^k points of a pair put one point into each of 2^k equal cells of any
//! shape; a value depends on seed, index and pair alone.

use chiaro_basis::random;

/// The sequence of a pixel, a surfel or whatever else has a seed of its own.
#[derive(Clone, Copy, Debug)]
pub struct Sequence {
    seed: u64,
}

impl Sequence {
    /// The sequence with this seed.
    pub fn new(seed: u64) -> Self {
        Self { seed }
    }

    /// Point `index` in the pair of dimensions `pair`.
    pub fn point(&self, index: u32, pair: u32) -> [f32; 2] {
        let h = random::hash(self.seed, u64::from(pair));
        let (a, b) = (h as u32, (h >> 32) as u32);
        let i = scrambled(index, a ^ b.rotate_left(16));
        [scrambled(i.reverse_bits(), a), scrambled(second(i), b)].map(unit)
    }
}

/// The second of Sobol's dimensions, whose direction numbers are Pascal's triangle modulo 2.
fn second(mut index: u32) -> u32 {
    let (mut value, mut direction) = (0, 1u32 << 31);
    while index != 0 {
        if index & 1 == 1 {
            value ^= direction;
        }
        index >>= 1;
        direction ^= direction >> 1;
    }
    value
}

/// Owen's nested uniform scramble of the binary digits of a fraction.
fn scrambled(fraction: u32, seed: u32) -> u32 {
    let mut x = fraction.reverse_bits();
    x ^= x.wrapping_mul(0x3d20_adea);
    x = x.wrapping_add(seed);
    x = x.wrapping_mul((seed >> 16) | 1);
    x ^= x.wrapping_mul(0x0552_6c56);
    x ^= x.wrapping_mul(0x53a2_2864);
    x.reverse_bits()
}

fn unit(fraction: u32) -> f32 {
    (fraction >> 8) as f32 / (1u32 << 24) as f32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_elementary_cell_holds_one_point() {
        for (seed, pair) in [(1, 0), (1, 1), (99, 7)] {
            let s = Sequence::new(seed);
            for (columns, rows) in [(64, 1), (16, 4), (8, 8), (2, 32), (1, 64)] {
                let mut cells = vec![0; 64];
                for i in 0..64 {
                    let [x, y] = s.point(i, pair);
                    let at = |v: f32, n: usize| (v * n as f32) as usize;
                    cells[at(y, rows) * columns + at(x, columns)] += 1;
                }
                assert!(cells.iter().all(|c| *c == 1), "{columns} x {rows}");
            }
        }
    }

    #[test]
    fn pairs_and_seeds_are_independent() {
        let correlation = |f: &dyn Fn(u32) -> [f32; 2]| -> f32 {
            (0..1024).map(f).map(|[a, b]| (a - 0.5) * (b - 0.5)).sum::<f32>() / 1024.0 * 12.0
        };
        let (s, t) = (Sequence::new(3), Sequence::new(4));
        assert!(correlation(&|i| [s.point(i, 0)[0], s.point(i, 1)[0]]).abs() < 0.1);
        assert!(correlation(&|i| [s.point(i, 0)[0], t.point(i, 0)[0]]).abs() < 0.1);
    }
}
