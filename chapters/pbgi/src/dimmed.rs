//! [`dimmed`]: vectors of light again, at other gains.
//!
//! A word without a gain stands for one brightness alone. Where light comes from few nodes, a sparse
//! tree shows each of them once, and those of a denser tree, partly in shadow or next to it, find no
//! word: clusters are therefore learned from copies too, the more of a vector the longer it is,
//! each as bright as the vector times a number drawn between none and [`BRIGHTEST`].

use chiaro_basis::random::{hash, unit};

/// Of a copy's brightness to the original's, at most.
const BRIGHTEST: f32 = 1.1;

/// `count` copies of vectors of `dim` numbers, drawn in proportion to their lengths.
pub(crate) fn dimmed(points: &[f32], dim: usize, count: usize, seed: u64) -> Vec<f32> {
    let length = |p: &[f32]| p.iter().map(|v| v * v).sum::<f32>().sqrt();
    let ends: Vec<f64> = points
        .chunks_exact(dim)
        .scan(0.0, |sum, p| {
            *sum += f64::from(length(p));
            Some(*sum)
        })
        .collect();
    let Some(total) = ends.last().copied().filter(|t| *t > 0.0) else { return Vec::new() };
    let (place, gain) = (hash(seed, 1), hash(seed, 2));
    let copy = |i: u64| {
        let at = total * f64::from(unit(place, i));
        let chosen = ends.partition_point(|end| *end <= at).min(ends.len() - 1);
        let gain = BRIGHTEST * unit(gain, i);
        points[chosen * dim..(chosen + 1) * dim].iter().map(move |v| gain * v)
    };
    (0..count as u64).flat_map(copy).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn copies_are_shorter_and_of_long_vectors_more_often() {
        let points = [0.0, 0.0, 3.0, 4.0, 0.0, -15.0];
        let copies = dimmed(&points, 2, 4000, 5);
        assert_eq!(copies.len(), 8000);
        let (mut of_short, mut of_long) = (0, 0);
        for copy in copies.chunks_exact(2) {
            match *copy {
                [0.0, y] => {
                    assert!((-16.5..=0.0).contains(&y));
                    of_long += 1;
                }
                [x, y] => {
                    assert!((x * 4.0 - y * 3.0).abs() < 1e-5 && (0.0..=3.3).contains(&x));
                    of_short += 1;
                }
                _ => {}
            }
        }
        assert!((f64::from(of_long) / f64::from(of_short) - 3.0).abs() < 0.4, "{of_long}");
        assert!(dimmed(&[0.0; 6], 2, 10, 5).is_empty() && dimmed(&[], 2, 10, 5).is_empty());
    }
}
