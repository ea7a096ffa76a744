//! Order statistics of the covered pixels: percentiles and Otsu's threshold.

use crate::Plane;

/// The `percent`-th percentile (0 to 100) of the covered finite values, linear between ranks: 0 is
/// the least value, 50 the median, 100 the greatest. `None` when nothing finite is covered. Panics
/// when the sizes differ.
pub fn percentile(plane: &Plane<f32>, mask: &Plane<bool>, percent: f32) -> Option<f32> {
    let mut values: Vec<f32> = covered(plane, mask).filter(|v| v.is_finite()).collect();
    let last = values.len().checked_sub(1)?;
    let rank = (f64::from(percent) / 100.0).clamp(0.0, 1.0) * last as f64;
    let (below, part) = (rank as usize, rank.fract());
    let (_, &mut low, above) = values.select_nth_unstable_by(below, f32::total_cmp);
    let high = above.iter().copied().min_by(f32::total_cmp).unwrap_or(low);
    Some((f64::from(low) * (1.0 - part) + f64::from(high) * part) as f32)
}

/// Bins of the histogram behind [`otsu`].
const BINS: usize = 256;

/// Otsu's threshold (1979): the value in [0, 1] that splits the covered values into two classes of
/// greatest variance between them. Values are clamped to [0, 1] and sorted into 256 bins; where
/// several thresholds are equally good, in an empty stretch of the histogram, it is their middle.
/// Without two different values it is 0.5. Panics when the sizes differ.
pub fn otsu(plane: &Plane<f32>, mask: &Plane<bool>) -> f32 {
    let histogram = histogram(plane, mask);
    let between: Vec<f64> = between_class_variances(&histogram);
    let best = between.iter().copied().fold(0.0, f64::max);
    if best <= 0.0 {
        return 0.5;
    }
    let is_best = |v: &f64| *v >= best * (1.0 - 1e-9);
    let first = between.iter().position(is_best).unwrap_or(0);
    let last = between.iter().rposition(is_best).unwrap_or(0);
    ((first + last) as f32 / 2.0 + 1.0) / BINS as f32
}

fn histogram(plane: &Plane<f32>, mask: &Plane<bool>) -> [u64; BINS] {
    let mut bins = [0; BINS];
    for v in covered(plane, mask).filter(|v| !v.is_nan()) {
        bins[((v.clamp(0.0, 1.0) * BINS as f32) as usize).min(BINS - 1)] += 1;
    }
    bins
}

/// For each bin, the variance between what lies up to it and what lies past it.
fn between_class_variances(histogram: &[u64; BINS]) -> Vec<f64> {
    let weighed = |(bin, count): (usize, &u64)| bin as f64 * *count as f64;
    let total: u64 = histogram.iter().sum();
    let moment: f64 = histogram.iter().enumerate().map(weighed).sum();
    let (mut below, mut moment_below) = (0.0, 0.0);
    let variance = |(bin, count): (usize, &u64)| {
        below += *count as f64;
        moment_below += weighed((bin, count));
        let above = total as f64 - below;
        if below == 0.0 || above == 0.0 {
            return 0.0;
        }
        let gap = moment_below / below - (moment - moment_below) / above;
        below * above * gap * gap
    };
    histogram.iter().enumerate().map(variance).collect()
}

fn covered<'a>(plane: &'a Plane<f32>, mask: &'a Plane<bool>) -> impl Iterator<Item = f32> + 'a {
    assert_eq!(plane.size(), mask.size(), "a mask has the size of its plane");
    plane.pixels().iter().zip(mask.pixels()).filter(|(_, covered)| **covered).map(|(v, _)| *v)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn line(values: &[f32]) -> (Plane<f32>, Plane<bool>) {
        let plane = Plane::from_pixels(values.len(), 1, values.to_vec());
        let mask = plane.map(|_| true);
        (plane, mask)
    }

    #[test]
    fn percentiles_interpolate_between_ranks() {
        let (plane, mask) = line(&[4.0, 1.0, 3.0, 2.0, f32::NAN]);
        let at = |p| percentile(&plane, &mask, p).unwrap();
        assert_eq!([at(0.0), at(50.0), at(100.0), at(-7.0)], [1.0, 2.5, 4.0, 1.0]);
        assert!((at(10.0) - 1.3).abs() < 1e-6);
    }

    #[test]
    fn uncovered_values_have_no_rank() {
        let (plane, _) = line(&[1.0, 9.0]);
        assert_eq!(percentile(&plane, &Plane::filled(2, 1, false), 50.0), None);
        let mask = Plane::from_pixels(2, 1, vec![true, false]);
        assert_eq!(percentile(&plane, &mask, 99.0), Some(1.0));
    }

    #[test]
    fn otsu_splits_two_heaps_in_the_middle_of_the_gap() {
        let (plane, mask) = line(&[0.2, 0.21, 0.22, 0.2, 0.8, 0.81]);
        let threshold = otsu(&plane, &mask);
        assert!((threshold - 0.51).abs() < 0.02, "{threshold}");
    }

    #[test]
    fn otsu_of_uneven_heaps_is_not_pulled_to_the_larger_one() {
        let values: Vec<f32> = (0..1000).map(|i| if i < 990 { 0.1 } else { 0.7 }).collect();
        let (plane, mask) = line(&values);
        assert!((0.1..0.7).contains(&otsu(&plane, &mask)));
    }

    #[test]
    fn otsu_of_one_value_is_a_half() {
        let (plane, mask) = line(&[0.3, 0.3]);
        assert_eq!(otsu(&plane, &mask), 0.5);
        assert_eq!(otsu(&plane, &mask.map(|_| false)), 0.5);
    }
}
