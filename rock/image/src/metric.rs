//! How far two pictures are apart: RMSE, PSNR, changed pixels, the largest difference, and what
//! viewers see of it (FLIP, Yee's perceptually different pixels).
//!
//! Values on both sides that are equal, or both not numbers, differ by 0; a number and a value that
//! is none differ by infinity. All results are the same bits for any number of threads. All
//! functions give [`Error::Input`](chiaro_basis::Error::Input) when the sizes differ.

mod flip;
mod visible;
mod vision;

pub use flip::{flip, flip_map};
pub use visible::{different_map, different_pixels};

use crate::Plane;
use crate::colour::srgb_encode;
use crate::plane::same_size;
use chiaro_basis::{Result, reduce};
use rayon::prelude::*;

/// What a screen shows of linear light, colours multiplied by alpha: red, green and blue over
/// black, clamped to [0, 1] and sRGB-encoded, not rounded. What is not a number shows black.
pub fn displayed(linear: &Plane<[f32; 4]>) -> Plane<[f32; 3]> {
    let shown = |c: f32| if c.is_nan() { 0.0 } else { srgb_encode(c.clamp(0.0, 1.0)) };
    linear.map(|&[r, g, b, _]| [r, g, b].map(shown))
}

/// Root of the mean squared difference over all pixels and channels; 0 for pictures without any.
pub fn rmse<const N: usize>(a: &Plane<[f32; N]>, b: &Plane<[f32; N]>) -> Result<f64> {
    same_size(a.size(), b.size())?;
    let (a, b) = (a.pixels().as_flattened(), b.pixels().as_flattened());
    let squares = reduce::sum(a.len(), |i| f64::from(difference(a[i], b[i])).powi(2));
    Ok((squares / a.len().max(1) as f64).sqrt())
}

/// The peak signal-to-noise ratio in decibels, -20 log10(RMSE) for a peak of 1: of pictures as
/// [`displayed`]. `None` when the pictures are equal and the ratio infinite.
pub fn psnr_db<const N: usize>(a: &Plane<[f32; N]>, b: &Plane<[f32; N]>) -> Result<Option<f64>> {
    let error = rmse(a, b)?;
    Ok((error > 0.0).then(|| -20.0 * error.log10()))
}

/// The RMSE of linear radiance, the mean of red, green and blue, over the covered pixels, divided
/// by its mean in the reference there. `None` when nothing is covered or the reference is black.
pub fn rmse_relative(
    picture: &Plane<[f32; 3]>,
    reference: &Plane<[f32; 3]>,
    mask: &Plane<bool>,
) -> Result<Option<f64>> {
    same_size(picture.size(), reference.size())?;
    same_size(picture.size(), mask.size())?;
    let (picture, reference, mask) = (picture.pixels(), reference.pixels(), mask.pixels());
    let grey = |[r, g, b]: [f32; 3]| (r + g + b) / 3.0;
    let over_covered = |value: &(dyn Fn(usize) -> f64 + Sync)| {
        reduce::sum(mask.len(), |i| if mask[i] { value(i) } else { 0.0 })
    };
    let count = over_covered(&|_| 1.0);
    let mean = over_covered(&|i| f64::from(grey(reference[i]))) / count;
    let squares =
        over_covered(&|i| f64::from(difference(grey(picture[i]), grey(reference[i]))).powi(2));
    Ok((count > 0.0 && mean > 0.0).then(|| (squares / count).sqrt() / mean))
}

/// Pixels of which a channel differs by more than 1 / 510: those that may differ once rounded to
/// bytes, for pictures as [`displayed`].
pub fn changed_pixels<const N: usize>(a: &Plane<[f32; N]>, b: &Plane<[f32; N]>) -> Result<u64> {
    same_size(a.size(), b.size())?;
    let changed = |(a, b): &(&[f32; N], &[f32; N])| largest(a, b) > 1.0 / 510.0;
    Ok(a.pixels().par_iter().zip(b.pixels()).filter(changed).count() as u64)
}

/// The largest difference of any channel of any pixel.
pub fn max_difference<const N: usize>(a: &Plane<[f32; N]>, b: &Plane<[f32; N]>) -> Result<f32> {
    same_size(a.size(), b.size())?;
    let pairs = a.pixels().par_iter().zip(b.pixels());
    // The largest of several numbers does not depend on their order.
    Ok(pairs.map(|(a, b)| largest(a, b)).reduce(|| 0.0, f32::max))
}

fn largest<const N: usize>(a: &[f32; N], b: &[f32; N]) -> f32 {
    a.iter().zip(b).map(|(a, b)| difference(*a, *b)).fold(0.0, f32::max)
}

fn difference(a: f32, b: f32) -> f32 {
    if a == b || (a.is_nan() && b.is_nan()) {
        return 0.0;
    }
    let difference = (a - b).abs();
    if difference.is_nan() { f32::INFINITY } else { difference }
}

#[cfg(test)]
mod tests {
    use super::*;
    use chiaro_basis::random;

    fn noise(seed: u64) -> Plane<[f32; 3]> {
        let at = |i: usize, c: u64| random::unit(seed + c, i as u64);
        Plane::from_fn(150, 90, |x, y| [0, 1, 2].map(|c| at(y * 150 + x, c)))
    }

    #[test]
    fn equal_pictures_have_no_error_and_an_infinite_ratio() {
        let a = noise(1);
        assert_eq!(rmse(&a, &a).unwrap(), 0.0);
        assert_eq!(psnr_db(&a, &a).unwrap(), None);
        assert_eq!((changed_pixels(&a, &a).unwrap(), max_difference(&a, &a).unwrap()), (0, 0.0));
    }

    #[test]
    fn a_constant_offset_has_its_closed_form() {
        let (a, b) = (Plane::filled(40, 30, [0.5f32]), Plane::filled(40, 30, [0.6f32]));
        assert!((rmse(&a, &b).unwrap() - 0.1).abs() < 1e-7);
        assert!((psnr_db(&a, &b).unwrap().unwrap() - 20.0).abs() < 1e-5);
        assert_eq!(changed_pixels(&a, &b).unwrap(), 1200);
        assert!((max_difference(&a, &b).unwrap() - 0.1).abs() < 1e-7);
    }

    #[test]
    fn independent_noise_differs_by_the_root_of_a_sixth() {
        let error = rmse(&noise(10), &noise(20)).unwrap();
        assert!((error - (1.0f64 / 6.0).sqrt()).abs() < 0.01, "{error}");
    }

    #[test]
    fn half_a_byte_is_not_a_change_and_more_is() {
        let a = Plane::filled(3, 1, [0.5f32, 0.5, 0.5]);
        let mut b = a.clone();
        b[(1, 0)][2] += 0.0019;
        assert_eq!(changed_pixels(&a, &b).unwrap(), 0);
        b[(1, 0)][2] += 0.0002;
        assert_eq!(changed_pixels(&a, &b).unwrap(), 1);
    }

    #[test]
    fn relative_error_counts_the_covered_pixels_alone() {
        let reference = Plane::from_pixels(3, 1, vec![[2.0; 3], [2.0; 3], [90.0; 3]]);
        let picture = Plane::from_pixels(3, 1, vec![[3.0; 3], [1.0; 3], [0.0; 3]]);
        let mask = Plane::from_pixels(3, 1, vec![true, true, false]);
        assert_eq!(rmse_relative(&picture, &reference, &mask).unwrap(), Some(0.5));
        let none = mask.map(|_| false);
        assert_eq!(rmse_relative(&picture, &reference, &none).unwrap(), None);
        let black = reference.map(|_| [0.0; 3]);
        assert_eq!(rmse_relative(&picture, &black, &mask).unwrap(), None);
    }

    #[test]
    fn values_that_are_no_numbers_are_far_from_numbers_alone() {
        let odd = Plane::from_pixels(2, 1, vec![[f32::NAN], [f32::INFINITY]]);
        assert_eq!(rmse(&odd, &odd).unwrap(), 0.0);
        let plain = Plane::filled(2, 1, [0.0]);
        assert_eq!(max_difference(&odd, &plain).unwrap(), f32::INFINITY);
        assert_eq!(changed_pixels(&odd, &plain).unwrap(), 2);
        let light = Plane::from_pixels(1, 1, vec![[f32::NAN, f32::INFINITY, -1.0, 1.0]]);
        assert_eq!(displayed(&light).pixels(), [[0.0, 1.0, 0.0]]);
    }

    #[test]
    fn sizes_must_agree_and_threads_do_not_matter() {
        assert!(rmse(&noise(1), &Plane::filled(150, 91, [0.0; 3])).is_err());
        let (a, b) = (noise(1), noise(2));
        let on = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| rmse(&a, &b).unwrap().to_bits())
        };
        assert_eq!(on(1), on(4));
    }
}
