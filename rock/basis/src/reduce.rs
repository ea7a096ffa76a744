//! Parallel sums of fixed shape: the same bits for any number of threads.
//!
//! Floating-point addition does not associate, so a sum is cut into chunks of a fixed length, each
//! chunk is summed in order, and the chunk sums are added in order.

use rayon::prelude::*;

const CHUNK: usize = 4096;

/// The sum of `value(i)` for `i` in `0..count`, in a fixed order of additions.
pub fn sum(count: usize, value: impl Fn(usize) -> f64 + Sync) -> f64 {
    let chunks: Vec<f64> = (0..count.div_ceil(CHUNK))
        .into_par_iter()
        .map(|c| (c * CHUNK..((c + 1) * CHUNK).min(count)).map(&value).sum())
        .collect();
    chunks.into_iter().sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sums_do_not_depend_on_threads() {
        let value = |i: usize| 1.0 / (1.0 + i as f64).powf(1.3);
        let on = |threads: usize| {
            let pool =
                rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
            pool.install(|| sum(100_000, value)).to_bits()
        };
        assert_eq!(on(1), on(2));
        assert_eq!(on(1), on(5));
    }
}
