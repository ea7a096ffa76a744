//! Labels after border smoothing, and where their borders cross between pixels.
//!
//! What is covered is a Gaussian average of the mask over one half; which of the labels a covered
//! pixel has is the greatest of their averages over the covered pixels alone. That is what
//! [`smooth_coverage`](crate::smooth_coverage) shows, for any number of labels.

use chiaro_image::{Plane, filter};

/// The label of what is not covered.
pub const NOTHING: u8 = u8::MAX;

/// Smoothed labels.
pub struct Soft {
    labels: Plane<u8>,
    covered: Plane<f32>,
    /// Shares of the labels 1, 2, ...; what is left is label 0's.
    shares: Vec<Plane<f32>>,
}

impl Soft {
    /// Smooths `labels` (0 to `count` - 1, where `mask` covers) by a Gaussian of `sigma` pixels; 0
    /// keeps them.
    pub fn new(labels: &Plane<u8>, mask: &Plane<bool>, count: u8, sigma: f32) -> Self {
        let (w, h) = labels.size();
        let everywhere = Plane::filled(w, h, true);
        let covered = soften(&mask.map(|m| share(*m)), &everywhere, sigma);
        let shares: Vec<Plane<f32>> = (1..count.max(1))
            .map(|k| soften(&labels.map(|l| share(*l == k)), mask, sigma))
            .collect();
        let labels = Plane::from_fn(w, h, |x, y| {
            if covered[(x, y)] >= 0.5 { greatest(&shares, (x, y)) } else { NOTHING }
        });
        Self { labels, covered, shares }
    }

    /// The smoothed labels; [`NOTHING`] where nothing is covered.
    pub fn labels(&self) -> &Plane<u8> {
        &self.labels
    }

    /// How far from pixel p to its neighbour q the border between their labels is crossed, in
    /// (0, 1).
    pub fn crossing(&self, p: (usize, usize), q: (usize, usize)) -> f64 {
        let (a, b) = (self.labels[p], self.labels[q]);
        let (at_p, at_q) = if a == NOTHING || b == NOTHING {
            (self.covered[p] - 0.5, self.covered[q] - 0.5)
        } else {
            (self.share(a, p) - self.share(b, p), self.share(a, q) - self.share(b, q))
        };
        let t = f64::from(at_p) / f64::from(at_p - at_q);
        if t.is_finite() { t.clamp(0.02, 0.98) } else { 0.5 }
    }

    fn share(&self, label: u8, at: (usize, usize)) -> f32 {
        match label.checked_sub(1) {
            Some(k) => self.shares[k as usize][at],
            None => 1.0 - self.shares.iter().map(|s| s[at]).sum::<f32>(),
        }
    }
}

fn share(is: bool) -> f32 {
    if is { 1.0 } else { 0.0 }
}

fn soften(plane: &Plane<f32>, mask: &Plane<bool>, sigma: f32) -> Plane<f32> {
    if sigma > 0.0 { filter::gaussian_masked(plane, mask, sigma) } else { plane.clone() }
}

/// The label with the greatest share; of equals the highest.
fn greatest(shares: &[Plane<f32>], at: (usize, usize)) -> u8 {
    let mut best = (1.0 - shares.iter().map(|s| s[at]).sum::<f32>(), 0);
    for (k, plane) in shares.iter().enumerate() {
        if plane[at] >= best.0 {
            best = (plane[at], k as u8 + 1);
        }
    }
    best.1
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::smooth_coverage;

    #[test]
    fn two_labels_are_those_that_coverage_shows() {
        let inside = |x: usize, y: usize| (x as f32 - 20.0).hypot(y as f32 - 18.0) < 15.0;
        let mask = Plane::from_fn(40, 36, inside);
        let white = Plane::from_fn(40, 36, |x, y| (x * 7 + y * 3) % 19 < 9 && inside(x, y));
        let soft = Soft::new(&white.map(|w| u8::from(*w)), &mask, 2, 1.1);
        let shown = smooth_coverage(&white, &mask, 1.1);
        let object = smooth_coverage(&mask, &Plane::filled(40, 36, true), 1.1);
        for (i, label) in soft.labels().pixels().iter().enumerate() {
            let covered = object.pixels()[i] >= 0.5;
            let expected = if covered { u8::from(shown.pixels()[i] >= 0.5) } else { NOTHING };
            assert_eq!(*label, expected);
        }
    }

    #[test]
    fn a_straight_border_is_crossed_in_the_middle() {
        let labels = Plane::from_fn(20, 20, |x, _| {
            if x < 5 {
                0
            } else if x < 12 {
                1
            } else {
                2
            }
        });
        let soft = Soft::new(&labels, &Plane::filled(20, 20, true), 3, 1.5);
        assert_eq!(soft.labels(), &labels);
        for x in [4, 11] {
            assert!((soft.crossing((x, 9), (x + 1, 9)) - 0.5).abs() < 0.05);
        }
        let back = soft.crossing((12, 9), (11, 9)) + soft.crossing((11, 9), (12, 9));
        assert!((back - 1.0).abs() < 1e-6);
    }
}
