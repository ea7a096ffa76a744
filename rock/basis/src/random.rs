//! Randomness without order: a value depends on a seed and an index alone.
//!
//! The mixer is the finalizer of SplitMix64 (Steele, Lea and Flood 2014), whose avalanche is
//! sufficient for dithering, jitter and test scenes. It is not cryptographic.

/// A 64-bit hash of `seed` and `index`.
pub fn hash(seed: u64, index: u64) -> u64 {
    let mut z = seed
        .wrapping_mul(0x9E37_79B9_7F4A_7C15)
        .wrapping_add(index)
        .wrapping_add(0x9E37_79B9_7F4A_7C15);
    z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    z ^ (z >> 31)
}

/// A number in [0, 1) from `seed` and `index`.
pub fn unit(seed: u64, index: u64) -> f32 {
    (hash(seed, index) >> 40) as f32 / (1u64 << 24) as f32
}

/// Point `index` of the R2 sequence, in [0, 1)^2: the two-dimensional additive recurrence on the
/// plastic number (Roberts 2018), low in discrepancy for every prefix.
pub fn r2(index: u64) -> [f32; 2] {
    const A: f64 = 0.754_877_666_246_692_8;
    const B: f64 = 0.569_840_290_998_053_3;
    let i = index as f64;
    [(0.5 + A * i).fract() as f32, (0.5 + B * i).fract() as f32]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn unit_numbers_fill_the_interval_evenly() {
        let n = 4096;
        let mut bins = [0u32; 16];
        for i in 0..n {
            bins[(unit(7, i) * 16.0) as usize] += 1;
        }
        assert!(bins.iter().all(|&b| (200..312).contains(&b)), "{bins:?}");
    }

    #[test]
    fn every_prefix_of_r2_covers_the_square() {
        let mut cells = [false; 64];
        for i in 0..160 {
            let [x, y] = r2(i);
            cells[(y * 8.0) as usize * 8 + (x * 8.0) as usize] = true;
        }
        assert!(cells.iter().all(|&c| c));
    }
}
