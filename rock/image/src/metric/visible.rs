//! Perceptually different pixels (Yee, "A perceptual metric for production testing", 2004).
//!
//! 1. Luminance and CIELAB of both pictures, of a screen of 100 cd/m2 that is seen 45 degrees wide.
//! 2. A pyramid of eight ever smoother copies of the luminance: the contrast of each band, the
//!    luminance to which the eye is adapted.
//! 3. A difference is seen where it exceeds the threshold of that luminance (threshold versus
//!    intensity), raised by the contrast around it (visual masking) and by spatial frequencies to
//!    which eyes are dull (contrast sensitivity); or where the hue differs as much in good light.
//!
//! Where the published program assumes Adobe RGB, this takes sRGB, which pictures here are.

use super::vision::{lab, linear, xyz};
use crate::Plane;
use crate::plane::same_size;
use chiaro_basis::Result;
use rayon::prelude::*;

/// Copies in the pyramid; bands of contrast.
const LEVELS: usize = 8;
const BANDS: usize = LEVELS - 2;
/// Luminance of white, candela per square metre.
const WHITE: f32 = 100.0;
/// Width of the picture in degrees.
const FIELD: f32 = 45.0;
/// Below this luminance eyes see no hue.
const NO_HUE: f32 = 10.0;
/// The spatial frequency to which eyes are keenest, cycles a degree.
const KEENEST: f32 = 3.248;

/// The number of pixels whose difference a viewer would see, of pictures with sRGB-encoded values
/// in [0, 1].
pub fn different_pixels(a: &Plane<[f32; 3]>, b: &Plane<[f32; 3]>) -> Result<u64> {
    let map = different_map(a, b)?;
    Ok(map.pixels().par_iter().filter(|d| **d).count() as u64)
}

/// Which pixels those are.
pub fn different_map(a: &Plane<[f32; 3]>, b: &Plane<[f32; 3]>) -> Result<Plane<bool>> {
    same_size(a.size(), b.size())?;
    let (width, height) = a.size();
    let eye = Eye::of_width(width);
    let [seen_a, seen_b] = [a, b].map(|p| p.map(|c| xyz(linear(*c))));
    let [bands_a, bands_b] = [&seen_a, &seen_b].map(|p| pyramid(p.map(|c| WHITE * c[1])));
    Ok(Plane::from_fn(width, height, |x, y| {
        let at = (x, y);
        let (la, lb) = (bands_a.each_ref().map(|p| p[at]), bands_b.each_ref().map(|p| p[at]));
        let (adapted, factor) = eye.threshold(&la, &lb);
        if (la[0] - lb[0]).abs() > factor * just_seen(adapted) {
            return true;
        }
        let (p, q) = (lab(seen_a[at]), lab(seen_b[at]));
        let hue = (p[1] - q[1]).powi(2) + (p[2] - q[2]).powi(2);
        adapted >= NO_HUE && hue > factor
    }))
}

/// What of the metric depends on the picture's width alone.
struct Eye {
    /// The level whose blur spans one degree.
    adaptation: usize,
    /// Cycles a degree of each band.
    frequency: [f32; BANDS],
    /// How much duller eyes are there than where they are keenest.
    dullness: [f32; BANDS],
}

impl Eye {
    fn of_width(width: usize) -> Self {
        let degrees = 2.0 * (0.5 * FIELD).to_radians().tan().to_degrees();
        let pixels_a_degree = width as f32 / degrees;
        let adaptation =
            (0..LEVELS - 1).find(|i| (1u32 << i) as f32 > pixels_a_degree).unwrap_or(LEVELS - 1);
        let frequency = std::array::from_fn(|i| 0.5 * pixels_a_degree / (1u32 << i) as f32);
        let keenest = sensitivity(KEENEST, WHITE);
        let dullness = frequency.map(|f| keenest / sensitivity(f, WHITE));
        Self { adaptation, frequency, dullness }
    }

    /// The luminance to which the eye is adapted, and by how much its threshold is raised.
    fn threshold(&self, a: &[f32; LEVELS], b: &[f32; LEVELS]) -> (f32, f32) {
        let adapted = (0.5 * (a[self.adaptation] + b[self.adaptation])).max(1e-5);
        let (mut sum, mut raised) = (0.0, 0.0);
        for i in 0..BANDS {
            let band = (a[i] - a[i + 1]).abs().max((b[i] - b[i + 1]).abs());
            let contrast = band / a[i + 2].abs().max(b[i + 2].abs()).max(1e-5);
            let mask = masking(contrast * sensitivity(self.frequency[i], adapted));
            sum += contrast;
            raised += contrast * self.dullness[i] * mask;
        }
        let factor = raised / sum.max(1e-5);
        (adapted, factor.clamp(1.0, 10.0))
    }
}

/// The smallest step of luminance that is seen at a luminance (Ward's fit), candela per square
/// metre.
fn just_seen(luminance: f32) -> f32 {
    let l = luminance.log10();
    let step = if l < -3.94 {
        -2.86
    } else if l < -1.44 {
        (0.405 * l + 1.6).powf(2.18) - 2.86
    } else if l < -0.0184 {
        l - 0.395
    } else if l < 1.9 {
        (0.249 * l + 0.65).powf(2.7) - 0.72
    } else {
        l - 1.255
    };
    10f32.powf(step)
}

/// Contrast sensitivity at cycles a degree and a luminance (Barten 1989).
fn sensitivity(frequency: f32, luminance: f32) -> f32 {
    let a = 440.0 * (1.0 + 0.7 / luminance).powf(-0.2);
    let b = 0.3 * (1.0 + 100.0 / luminance).powf(0.15);
    let bf = b * frequency;
    a * frequency * (-bf).exp() * (1.0 + 0.06 * bf.exp()).sqrt()
}

/// By how much a contrast hides others (Daly 1993).
fn masking(contrast: f32) -> f32 {
    let a = (392.498 * contrast).powf(0.7);
    (1.0 + (0.0153 * a).powi(4)).powf(0.25)
}

/// A plane and ever smoother copies of it.
fn pyramid(plane: Plane<f32>) -> [Plane<f32>; LEVELS] {
    let mut levels = vec![plane];
    for i in 1..LEVELS {
        levels.push(smoothed(&levels[i - 1]));
    }
    levels.try_into().unwrap_or_else(|_| unreachable!("as many levels as there are"))
}

/// A binomial-like average over 5 x 5 pixels; pictures are mirrored at their border.
fn smoothed(plane: &Plane<f32>) -> Plane<f32> {
    const TAPS: [f32; 5] = [0.05, 0.25, 0.4, 0.25, 0.05];
    let (width, height) = plane.size();
    let mirrored = |i: usize, k: usize, n: usize| {
        let j = (i + k) as i64 - 2;
        let n = n as i64;
        let j = if j < 0 {
            -j
        } else if j >= n {
            2 * n - j - 1
        } else {
            j
        };
        j.clamp(0, n - 1) as usize
    };
    let rows = Plane::from_fn(width, height, |x, y| {
        let row = plane.row(y);
        TAPS.iter().enumerate().map(|(k, t)| t * row[mirrored(x, k, width)]).sum::<f32>()
    });
    Plane::from_fn(width, height, |x, y| {
        let at = |k: usize| rows[(x, mirrored(y, k, height))];
        TAPS.iter().enumerate().map(|(k, t)| t * at(k)).sum::<f32>()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grey(f: impl Fn(usize, usize) -> f32 + Sync) -> Plane<[f32; 3]> {
        Plane::from_fn(256, 96, |x, y| [f(x, y); 3])
    }

    #[test]
    fn eyes_see_steps_above_the_threshold_and_none_below() {
        let flat = grey(|_, _| 0.5);
        assert_eq!(different_pixels(&flat, &flat).unwrap(), 0);
        // Half white is 21 cd/m2, where a step of 1.0 is just seen (and 0.7 is not).
        let lighter = |step: f32| grey(move |x, _| if x < 128 { 0.5 } else { 0.5 + step });
        assert_eq!(different_pixels(&flat, &lighter(0.006)).unwrap(), 0);
        let seen = different_pixels(&flat, &lighter(0.03)).unwrap();
        assert!(seen > 110 * 96 && seen <= 128 * 96, "{seen}");
    }

    #[test]
    fn a_busy_ground_hides_what_a_plain_one_shows() {
        let ground = |x: usize, y: usize| if (x / 2 + y / 2).is_multiple_of(2) { 0.3 } else { 0.7 };
        let step = |x: usize| if x < 128 { 0.0 } else { 0.02 };
        let plain = different_pixels(&grey(|_, _| 0.5), &grey(|x, _| 0.5 + step(x))).unwrap();
        let busy = different_pixels(&grey(ground), &grey(|x, y| ground(x, y) + step(x))).unwrap();
        assert!(4 * busy < plain, "{busy} of {plain}");
    }

    #[test]
    fn hues_differ_where_luminance_does_not() {
        let a = Plane::filled(64, 64, [0.6, 0.5, 0.5]);
        let b = Plane::filled(64, 64, [0.5, 0.535, 0.5]);
        assert_eq!(different_pixels(&a, &b).unwrap(), 64 * 64);
    }
}
