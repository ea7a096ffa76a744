//! Pictures of another size: averages over areas to shrink, nearest or bilinear to enlarge.
//!
//! A new pixel's centre lies over the old picture where its share of the width and height lies;
//! pictures keep their edges, not their corner pixels' centres. Average light, not bytes: decode
//! colours to linear before shrinking.

use crate::Plane;

/// What can be averaged: a number or an array of them.
pub trait Blend: Copy + Send + Sync {
    /// The value that adds nothing.
    const ZERO: Self;

    /// This value plus `weight` times `other`.
    fn plus(self, other: Self, weight: f32) -> Self;
}

impl Blend for f32 {
    const ZERO: Self = 0.0;

    fn plus(self, other: Self, weight: f32) -> Self {
        self + other * weight
    }
}

impl<const N: usize> Blend for [f32; N] {
    const ZERO: Self = [0.0; N];

    fn plus(self, other: Self, weight: f32) -> Self {
        std::array::from_fn(|i| self[i] + other[i] * weight)
    }
}

/// Each new pixel is the mean of the area it covers, parts of pixels counted as parts: for fewer
/// pixels, exact in mean. Panics when the plane has no pixels.
pub fn area_average<T: Blend>(plane: &Plane<T>, width: usize, height: usize) -> Plane<T> {
    let taps = |from: usize, to: usize| (0..to).map(|i| area_taps(i, from, to)).collect();
    weigh(plane, taps(plane.width(), width), taps(plane.height(), height))
}

/// Each new pixel lies between the two by two old ones around it: for more pixels, smooth. Beyond
/// the outermost centres the outermost values hold. Panics when the plane has no pixels.
pub fn bilinear<T: Blend>(plane: &Plane<T>, width: usize, height: usize) -> Plane<T> {
    let taps = |from: usize, to: usize| (0..to).map(|i| linear_taps(i, from, to)).collect();
    weigh(plane, taps(plane.width(), width), taps(plane.height(), height))
}

/// Each new pixel is the old one under its centre: for more pixels, blocky, and for labels and ids
/// that must not mix. Panics when the plane has no pixels.
pub fn nearest<T: Copy + Send + Sync>(plane: &Plane<T>, width: usize, height: usize) -> Plane<T> {
    assert!(!plane.is_empty(), "a picture with pixels");
    let under = |i: usize, from: usize, to: usize| (2 * i + 1) * from / (2 * to);
    Plane::from_fn(width, height, |x, y| {
        plane[(under(x, plane.width(), width), under(y, plane.height(), height))]
    })
}

/// The weights of consecutive pixels from `first` on.
struct Taps {
    first: usize,
    weights: Vec<f32>,
}

/// New pixel `i` of `to` covers old ones from i from / to to (i + 1) from / to.
fn area_taps(i: usize, from: usize, to: usize) -> Taps {
    let edge = |i: usize| i as f64 * from as f64 / to as f64;
    let (begin, end) = (edge(i), edge(i + 1));
    let first = (begin as usize).min(from - 1);
    let last = (end.ceil() as usize).clamp(first + 1, from);
    let share = |p: usize| (end.min(p as f64 + 1.0) - begin.max(p as f64)).max(0.0) / (end - begin);
    Taps { first, weights: (first..last).map(|p| share(p) as f32).collect() }
}

fn linear_taps(i: usize, from: usize, to: usize) -> Taps {
    let centre = (i as f64 + 0.5) * from as f64 / to as f64 - 0.5;
    let centre = centre.clamp(0.0, (from - 1) as f64);
    let part = centre.fract() as f32;
    let weights = if part > 0.0 { vec![1.0 - part, part] } else { vec![1.0] };
    Taps { first: centre as usize, weights }
}

/// Applies the taps of each column, then of each row.
fn weigh<T: Blend>(plane: &Plane<T>, columns: Vec<Taps>, rows: Vec<Taps>) -> Plane<T> {
    assert!(!plane.is_empty(), "a picture with pixels");
    let narrow = Plane::from_fn(columns.len(), plane.height(), |x, y| {
        let Taps { first, weights } = &columns[x];
        let values = &plane.row(y)[*first..];
        weights.iter().zip(values).fold(T::ZERO, |sum, (weight, v)| sum.plus(*v, *weight))
    });
    Plane::from_fn(columns.len(), rows.len(), |x, y| {
        let Taps { first, weights } = &rows[y];
        let terms = weights.iter().enumerate();
        terms.fold(T::ZERO, |sum, (i, weight)| sum.plus(narrow[(x, first + i)], *weight))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ramp(width: usize, height: usize) -> Plane<f32> {
        Plane::from_fn(width, height, |x, y| x as f32 + 100.0 * y as f32)
    }

    fn mean(plane: &Plane<f32>) -> f32 {
        plane.pixels().iter().sum::<f32>() / plane.len() as f32
    }

    #[test]
    fn an_area_average_keeps_the_mean() {
        let plane = ramp(13, 9);
        for (width, height) in [(13, 9), (5, 4), (1, 1), (12, 3)] {
            let small = area_average(&plane, width, height);
            assert_eq!(small.size(), (width, height));
            assert!((mean(&small) - mean(&plane)).abs() < 1e-3, "{width} x {height}");
        }
        assert_eq!(area_average(&plane, 13, 9), plane);
    }

    #[test]
    fn parts_of_pixels_count_as_parts() {
        let plane = Plane::from_pixels(3, 1, vec![0.0, 3.0, 6.0]);
        assert_eq!(area_average(&plane, 2, 1).pixels(), [1.0, 5.0]);
    }

    #[test]
    fn bilinear_goes_through_a_ramp_and_stops_at_its_ends() {
        let plane = Plane::from_pixels(2, 1, vec![0.0, 1.0]);
        assert_eq!(bilinear(&plane, 4, 1).pixels(), [0.0, 0.25, 0.75, 1.0]);
        let colours = plane.map(|&v| [v, 1.0 - v, 0.5]);
        assert_eq!(bilinear(&colours, 4, 2)[(2, 1)], [0.75, 0.25, 0.5]);
        assert_eq!(bilinear(&ramp(7, 5), 7, 5), ramp(7, 5));
    }

    #[test]
    fn nearest_repeats_whole_pixels() {
        let plane = Plane::from_pixels(2, 2, vec!['a', 'b', 'c', 'd']);
        let large = nearest(&plane, 4, 6);
        assert_eq!(large.row(2), ['a', 'a', 'b', 'b']);
        assert_eq!(large.row(3), ['c', 'c', 'd', 'd']);
        assert_eq!(nearest(&large, 2, 2), plane);
    }
}
