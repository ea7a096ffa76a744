//! How two pictures differ, in numbers. Sums have a fixed shape, so that results do not depend on
//! threads. Each errs with [`chiaro_basis::Error::Input`] when the sizes differ.

use crate::Plane;
use crate::plane::same_size;
use chiaro_basis::{Result, reduce};

type Rgb = Plane<[f32; 3]>;

/// The root of the mean squared difference over pixels and channels.
pub fn rmse(a: &Rgb, b: &Rgb) -> Result<f64> {
    same_size(a.size(), b.size())?;
    let sum = reduce::sum(a.len(), |i| {
        let (p, q) = (a.pixels()[i], b.pixels()[i]);
        (0..3).map(|c| f64::from(p[c] - q[c]).powi(2)).sum()
    });
    Ok((sum / (3 * a.len().max(1)) as f64).sqrt())
}

/// The peak signal-to-noise ratio of displayed pictures (sRGB-encoded, peak 1) in decibels; `None`
/// when they are equal.
pub fn psnr_db(a: &Rgb, b: &Rgb) -> Result<Option<f64>> {
    let error = rmse(a, b)?;
    Ok((error > 0.0).then(|| -20.0 * error.log10()))
}

/// The RMSE over the mean of the reference `b`; `None` when that mean is not positive.
pub fn rmse_relative(a: &Rgb, b: &Rgb) -> Result<Option<f64>> {
    let error = rmse(a, b)?;
    let sum = reduce::sum(b.len(), |i| b.pixels()[i].iter().map(|&c| f64::from(c)).sum());
    let mean = sum / (3 * b.len().max(1)) as f64;
    Ok((mean > 0.0).then(|| error / mean))
}

/// Pixels of which some channel differs by more than half a step of a byte.
pub fn changed_pixels(a: &Rgb, b: &Rgb) -> Result<usize> {
    let changed = a.zip(b, |p, q| (0..3).any(|c| (p[c] - q[c]).abs() > 1.0 / 510.0))?;
    Ok(changed.pixels().iter().filter(|c| **c).count())
}

/// The greatest difference in any channel of any pixel.
pub fn max_difference(a: &Rgb, b: &Rgb) -> Result<f32> {
    let differences =
        a.zip(b, |p, q| (0..3).map(|c| (p[c] - q[c]).abs()).fold(0.0f32, f32::max))?;
    Ok(differences.pixels().iter().copied().fold(0.0, f32::max))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_step_of_a_byte_everywhere_is_48_decibels() {
        let a = Plane::filled(8, 8, [0.5f32; 3]);
        let b = a.map(|p| p.map(|c| c + 1.0 / 255.0));
        assert!((psnr_db(&a, &b).unwrap().unwrap() - 48.13).abs() < 0.01);
        assert_eq!(psnr_db(&a, &a).unwrap(), None);
        assert_eq!(changed_pixels(&a, &b).unwrap(), 64);
        assert!((max_difference(&a, &b).unwrap() - 1.0 / 255.0).abs() < 1e-6);
    }

    #[test]
    fn pictures_of_different_sizes_are_an_error() {
        let (a, b) = (Plane::filled(2, 2, [0.0; 3]), Plane::filled(2, 3, [0.0; 3]));
        assert!(rmse(&a, &b).is_err());
    }
}
