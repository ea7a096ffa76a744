/// The values that never fall and are nearest to those given, by least squares with these weights:
/// isotonic regression by pools of adjacent violators (Ayer et al. 1955). Weights are positive.
pub fn isotonic(values: impl IntoIterator<Item = (f64, f64)>) -> Vec<f64> {
    // The value of a pool, its weight, and how many it holds.
    let mut pools: Vec<(f64, f64, usize)> = Vec::new();
    for (value, weight) in values {
        let mut pool = (value, weight, 1);
        while let Some(last) = pools.pop_if(|last| last.0 > pool.0) {
            let weight = last.1 + pool.1;
            pool = ((last.0 * last.1 + pool.0 * pool.1) / weight, weight, last.2 + pool.2);
        }
        pools.push(pool);
    }
    pools.into_iter().flat_map(|(value, _, count)| std::iter::repeat_n(value, count)).collect()
}

#[cfg(test)]
mod tests {
    use super::isotonic;

    #[test]
    fn pools_are_the_nearest_rising_values() {
        let alike = |values: &[f64]| isotonic(values.iter().map(|v| (*v, 1.0)));
        assert_eq!(alike(&[1.0, 2.0, 3.0]), [1.0, 2.0, 3.0]);
        assert_eq!(alike(&[3.0, 1.0, 2.0]), [2.0, 2.0, 2.0]);
        assert_eq!(alike(&[0.0, 4.0, 2.0, 5.0]), [0.0, 3.0, 3.0, 5.0]);
        assert_eq!(isotonic([(4.0, 3.0), (0.0, 1.0), (5.0, 1.0)]), [3.0, 3.0, 5.0]);
    }
}
