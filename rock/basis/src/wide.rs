//! Loops in the widest vectors that the machine has.

/// What `work` makes of `given`, compiled twice: for what every machine of its kind has, and for vectors
/// of eight. The operations are the same, and so are the bytes. Only what is inlined gains: `work` is a
/// function that always is, or a short closure.
#[inline]
pub fn widely<A, R>(work: impl FnOnce(A) -> R, given: A) -> R {
    #[cfg(target_arch = "x86_64")]
    if std::arch::is_x86_feature_detected!("avx2") {
        #[allow(
            unsafe_code,
            reason = "weights in all fell from 61 to 54 ns a pixel; the machine was asked for what it needs"
        )]
        // SAFETY: the machine has AVX2, which is all that the function asks for.
        return unsafe { in_eights(work, given) };
    }
    work(given)
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
fn in_eights<A, R>(work: impl FnOnce(A) -> R, given: A) -> R {
    work(given)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn work_is_done_once() {
        let values: Vec<f32> = (0..103).map(|i| i as f32).collect();
        let mut done = 0;
        let sum = |by: f32| values.iter().fold(0.0, |sum, v| sum + v * by);
        let wide = widely(
            |by| {
                done += 1;
                sum(by)
            },
            0.3,
        );
        assert_eq!((done, wide), (1, sum(0.3)));
    }
}
