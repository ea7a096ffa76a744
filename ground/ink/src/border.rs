//! Smooth borders: a label image as antialiased coverage.
//!
//! The labels are averaged with a Gaussian and cut again at one half; how far a pixel's average is
//! from one half, in pixels along its gradient, is its share of ink. The borders of minimal cuts
//! run in facets of 45 degrees where nothing guides them; this rounds them.

use chiaro_image::{Plane, filter};

/// The share of each pixel that is covered by `label`, in [0, 1], after smoothing by a Gaussian of
/// standard deviation `sigma` pixels. Pixels outside `mask` take no part in averages, and get the
/// value of what is nearest.
pub fn smooth_coverage(label: &Plane<bool>, mask: &Plane<bool>, sigma: f32) -> Plane<f32> {
    let hard = label.map(|&l| if l { 1.0 } else { 0.0 });
    if sigma <= 0.0 {
        return hard;
    }
    let soft = filter::gaussian_masked(&hard, mask, sigma);
    let (w, h) = soft.size();
    Plane::from_fn(w, h, |x, y| {
        let value = soft[(x, y)];
        if value <= 0.0 || value >= 1.0 {
            return value;
        }
        let at = |u: isize, v: isize| {
            soft[(
                (x as isize + u).clamp(0, w as isize - 1) as usize,
                (y as isize + v).clamp(0, h as isize - 1) as usize,
            )]
        };
        let slope = (0.5 * (at(1, 0) - at(-1, 0))).hypot(0.5 * (at(0, 1) - at(0, -1)));
        // On a straight border the Gaussian's slope bounds the ramp to one pixel.
        let steepest = 1.0 / (sigma * std::f32::consts::TAU.sqrt());
        ((value - 0.5) / slope.max(0.25 * steepest) + 0.5).clamp(0.0, 1.0)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_straight_border_stays_where_it_is() {
        let mask = Plane::filled(32, 8, true);
        let label = Plane::from_fn(32, 8, |x, _| x >= 16);
        let soft = smooth_coverage(&label, &mask, 1.2);
        assert!(soft[(14, 4)] == 0.0 && soft[(17, 4)] == 1.0);
        assert!(soft[(15, 4)] < 0.1 && soft[(16, 4)] > 0.9);
    }

    #[test]
    fn uncovered_pixels_do_not_pull_a_border() {
        let mask = Plane::from_fn(32, 8, |_, y| y < 4);
        let label = Plane::from_fn(32, 8, |_, y| y < 4);
        let soft = smooth_coverage(&label, &mask, 1.2);
        assert!((0..32).all(|x| soft[(x, 3)] == 1.0));
    }
}
