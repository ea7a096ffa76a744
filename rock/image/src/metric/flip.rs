//! LDR-FLIP (Andersson, Nilsson, Akenine-Möller, Oskarsson, Åström and Fairchild, "FLIP: a difference
//! evaluator for alternating images", 2020): how visible a difference is when a viewer flips
//! between two pictures.
//!
//! 1. Both pictures, sRGB-encoded, go to a linear opponent space and are blurred by what an eye
//!    cannot resolve; then to CIELAB with colours that fade in the dark (Hunt).
//! 2. Colour: the HyAB distance, compressed so that large differences saturate.
//! 3. Features: edges and points of the achromatic channel that are in one picture alone.
//! 4. A pixel's error is colour^(1 - features), in [0, 1].
//!
//! The viewer sees 67 pixels a degree: a screen 0.7 m wide with 3840 pixels, 0.7 m away, as in the
//! paper. Pictures end as if their border pixels went on for ever. Guaranteed:
//! within 1e-5 of the authors' program on the mean, the same bits for any number of threads.

use super::vision::{lab, linear, white, xyz, xyz_to_linear};
use crate::Plane;
use crate::plane::same_size;
use chiaro_basis::{Result, reduce};
use std::f64::consts::PI;

/// Pixels a degree of the viewer's field.
const PIXELS_A_DEGREE: f64 = 0.7 * (3840.0 / 0.7) * PI / 180.0;
/// Exponents, and the knee of the colour error.
const COLOUR_POWER: f32 = 0.7;
const KNEE: [f32; 2] = [0.4, 0.95];
const FEATURE_POWER: f32 = 0.5;
/// Width of the feature detectors, degrees.
const FEATURE_WIDTH: f64 = 0.082;
/// The contrast sensitivities of the three opponent channels: weights and widths of Gaussians.
const SENSITIVITY: [[[f64; 2]; 2]; 3] =
    [[[1.0, 0.0047], [0.0, 1e-5]], [[1.0, 0.0053], [0.0, 1e-5]], [[34.1, 0.04], [13.5, 0.025]]];

/// The mean of [`flip_map`]; 0 for pictures without pixels.
pub fn flip(reference: &Plane<[f32; 3]>, test: &Plane<[f32; 3]>) -> Result<f64> {
    let map = flip_map(reference, test)?;
    let pixels = map.pixels();
    let sum = reduce::sum(pixels.len(), |i| f64::from(pixels[i]));
    Ok(sum / pixels.len().max(1) as f64)
}

/// The error of every pixel, in [0, 1], of two pictures with sRGB-encoded values in [0, 1].
pub fn flip_map(reference: &Plane<[f32; 3]>, test: &Plane<[f32; 3]>) -> Result<Plane<f32>> {
    same_size(reference.size(), test.size())?;
    let [a, b] = [reference, test].map(|p| p.map(|c| opponent(xyz(linear(*c)))));
    let (seen_a, seen_b) = (perceived(&a), perceived(&b));
    let (features_a, features_b) = (Features::of(&a), Features::of(&b));
    let largest = {
        let hue = |c: [f32; 3]| hunt(lab(xyz(c)));
        hyab(hue([0.0, 1.0, 0.0]), hue([0.0, 0.0, 1.0])).powf(COLOUR_POWER)
    };
    let (width, height) = reference.size();
    Ok(Plane::from_fn(width, height, |x, y| {
        let at = (x, y);
        let colour = compressed(hyab(seen_a[at], seen_b[at]), largest);
        let edges = (features_a.edges[at] - features_b.edges[at]).abs();
        let points = (features_a.points[at] - features_b.points[at]).abs();
        let feature = (edges.max(points) * std::f32::consts::FRAC_1_SQRT_2).powf(FEATURE_POWER);
        colour.powf(1.0 - feature.min(1.0))
    }))
}

/// The linear opponent space YCxCz.
fn opponent(xyz: [f32; 3]) -> [f32; 3] {
    let white = white();
    let [x, y, z] = std::array::from_fn(|i| xyz[i] / white[i]);
    [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
}

fn from_opponent([y, cx, cz]: [f32; 3]) -> [f32; 3] {
    let white = white();
    let y = (y + 16.0) / 116.0;
    [(cx / 500.0 + y) * white[0], y * white[1], (y - cz / 200.0) * white[2]]
}

/// What the eye resolves, in Hunt-adjusted CIELAB.
fn perceived(opponent: &Plane<[f32; 3]>) -> Plane<[f32; 3]> {
    let widest = SENSITIVITY.iter().flatten().map(|g| g[1]).fold(0.0, f64::max);
    let radius = (3.0 * (widest / (2.0 * PI * PI)).sqrt() * PIXELS_A_DEGREE).ceil() as usize;
    let blurred: [Plane<f32>; 3] = std::array::from_fn(|c| {
        let plane = opponent.map(|v| v[c]);
        let parts = SENSITIVITY[c].map(|[weight, width]| {
            let taps: Vec<f64> = offsets(radius)
                .map(|i| (-PI * PI * (i / PIXELS_A_DEGREE).powi(2) / width).exp())
                .collect();
            let sum: f64 = taps.iter().sum();
            // A Gaussian's share of the two: its weight and the volume of its taps.
            let volume = weight * (PI / width).sqrt() * sum * sum;
            (volume, taps.iter().map(|t| (t / sum) as f32).collect::<Vec<f32>>())
        });
        let total: f64 = parts.iter().map(|p| p.0).sum();
        let mut sum: Option<Plane<f32>> = None;
        for (volume, taps) in parts.iter().filter(|p| p.0 > 0.0) {
            let share = (volume / total) as f32;
            let blur = convolved(&plane, taps, taps);
            sum = Some(match sum {
                None => blur.map(|v| share * v),
                Some(before) => {
                    let (w, h) = before.size();
                    Plane::from_fn(w, h, |x, y| before[(x, y)] + share * blur[(x, y)])
                }
            });
        }
        sum.unwrap_or(plane)
    });
    let (width, height) = opponent.size();
    Plane::from_fn(width, height, |x, y| {
        let seen = from_opponent(std::array::from_fn(|c| blurred[c][(x, y)]));
        hunt(lab(xyz(xyz_to_linear(seen).map(|c| c.clamp(0.0, 1.0)))))
    })
}

fn hunt([l, a, b]: [f32; 3]) -> [f32; 3] {
    [l, 0.01 * l * a, 0.01 * l * b]
}

fn hyab(p: [f32; 3], q: [f32; 3]) -> f32 {
    (p[0] - q[0]).abs() + (p[1] - q[1]).hypot(p[2] - q[2])
}

/// A colour distance in [0, 1]: 0.4 of the largest become 0.95, the rest shares what is left.
fn compressed(distance: f32, largest: f32) -> f32 {
    let power = distance.powf(COLOUR_POWER);
    let knee = KNEE[0] * largest;
    if power < knee {
        power * KNEE[1] / knee
    } else {
        KNEE[1] + (power - knee) / (largest - knee) * (1.0 - KNEE[1])
    }
}

/// How strong edges and points are.
struct Features {
    edges: Plane<f32>,
    points: Plane<f32>,
}

impl Features {
    fn of(opponent: &Plane<[f32; 3]>) -> Self {
        let grey = opponent.map(|c| (c[0] + 16.0) / 116.0);
        let deviation = 0.5 * FEATURE_WIDTH * PIXELS_A_DEGREE;
        let radius = (3.0 * deviation).ceil() as usize;
        let bell = |i: f64| (-i * i / (2.0 * deviation * deviation)).exp();
        let sum: f64 = offsets(radius).map(bell).sum();
        let smooth: Vec<f32> = offsets(radius).map(|i| (bell(i) / sum) as f32).collect();
        let edge = balanced(offsets(radius).map(|i| -i * bell(i)));
        let point =
            balanced(offsets(radius).map(|i| (i * i / (deviation * deviation) - 1.0) * bell(i)));
        let strength = |taps: &[f32]| {
            let (x, y) = (convolved(&grey, taps, &smooth), convolved(&grey, &smooth, taps));
            let (w, h) = grey.size();
            Plane::from_fn(w, h, |u, v| x[(u, v)].hypot(y[(u, v)]))
        };
        Self { edges: strength(&edge), points: strength(&point) }
    }
}

fn offsets(radius: usize) -> impl Iterator<Item = f64> {
    let radius = radius as i64;
    (-radius..=radius).map(|i| i as f64)
}

/// Taps whose positive ones add to 1, and the negative ones to -1.
fn balanced(taps: impl Iterator<Item = f64>) -> Vec<f32> {
    let taps: Vec<f64> = taps.collect();
    let positive: f64 = taps.iter().filter(|t| **t > 0.0).sum();
    let negative: f64 = -taps.iter().filter(|t| **t < 0.0).sum::<f64>();
    taps.iter().map(|t| (t / if *t > 0.0 { positive } else { negative }) as f32).collect()
}

/// A separable convolution; the border's pixels go on outside.
fn convolved(plane: &Plane<f32>, along_x: &[f32], along_y: &[f32]) -> Plane<f32> {
    let (width, height) = plane.size();
    let radius = along_x.len() / 2;
    let rows = Plane::from_fn(width, height, |x, y| {
        let row = plane.row(y);
        let at = |k: usize| row[(x + k).saturating_sub(radius).min(width - 1)];
        along_x.iter().enumerate().map(|(k, t)| t * at(k)).sum::<f32>()
    });
    let radius = along_y.len() / 2;
    Plane::from_fn(width, height, |x, y| {
        let at = |k: usize| rows[(x, (y + k).saturating_sub(radius).min(height - 1))];
        along_y.iter().enumerate().map(|(k, t)| t * at(k)).sum::<f32>()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A picture with a ramp, stripes and a spot; the other one is changed in each of them.
    fn pair() -> (Plane<[f32; 3]>, Plane<[f32; 3]>) {
        let byte = |v: usize| (v % 256) as f32 / 255.0;
        let a = Plane::from_fn(96, 64, |x, y| {
            [byte(2 * x), byte(3 * y), byte(if x / 4 % 2 == 0 { 40 } else { 200 })]
        });
        let mut b = a.clone();
        for y in 20..30 {
            for x in 30..50 {
                b[(x, y)] = [byte(255 - 2 * x), byte(3 * y), byte(120)];
            }
        }
        for y in 40..64 {
            for x in 0..96 {
                b[(x, y)][1] = byte(3 * y + 8);
            }
        }
        (a, b)
    }

    #[test]
    fn the_mean_is_that_of_the_authors_program() {
        let (a, b) = pair();
        // flip-evaluator 1.7: evaluate(a, b, "LDR"), its mean and two of its pixels.
        let ours = flip(&a, &b).unwrap();
        assert!((ours - 0.114_410_7).abs() < 1e-5, "{ours}");
        let map = flip_map(&a, &b).unwrap();
        assert!((map[(40, 25)] - 0.677_456_9).abs() < 1e-4, "{}", map[(40, 25)]);
        assert!((map[(10, 50)] - 0.225_996_7).abs() < 1e-4, "{}", map[(10, 50)]);
    }

    #[test]
    fn equal_pictures_do_not_flip_and_black_and_white_do() {
        let (a, _) = pair();
        assert_eq!(flip(&a, &a).unwrap(), 0.0);
        let (black, white) = (Plane::filled(20, 20, [0.0; 3]), Plane::filled(20, 20, [1.0; 3]));
        let far = flip(&black, &white).unwrap();
        assert!(far > 0.95 && far <= 1.0, "{far}");
    }
}
