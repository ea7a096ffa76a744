//! Spherical harmonics up to the third band (thesis, 6.3.1 and 6.1), and the lobe of a disc.
//!
//! The real basis is orthonormal, without the Condon-Shortley sign; index l(l + 1) + m. For a unit
//! vector (x, y, z):
//!
//! ```text
//! Y_0      sqrt(1/4pi)
//! Y_1..3   sqrt(3/4pi) (y, z, x)
//! Y_4..8   sqrt(15/4pi) (xy, yz, (3z^2 - 1)/(2 sqrt 3), xz, (x^2 - y^2)/2)
//! ```
//!
//! The thesis's basis line lacks a normalisation for m = 0 and swaps its angles; (6.2)'s integral
//! of a disc's lobe needs no sampling, it has a closed form.

use chiaro_basis::math::Vec3;

/// Coefficients of a function on the sphere.
pub type Sh = [f32; 9];

/// The nine basis functions in a direction, a unit vector.
pub fn basis(d: Vec3) -> Sh {
    let Vec3 { x, y, z } = d;
    [
        0.282_094_8,
        0.488_602_5 * y,
        0.488_602_5 * z,
        0.488_602_5 * x,
        1.092_548_4 * x * y,
        1.092_548_4 * y * z,
        0.315_391_57 * (3.0 * z * z - 1.0),
        1.092_548_4 * x * z,
        0.546_274_2 * (x * x - y * y),
    ]
}

/// (6.1): the sum of coefficients times basis functions.
pub fn evaluate(coefficients: &Sh, basis: &Sh) -> f32 {
    let mut sum = 0.0;
    for (c, b) in coefficients.iter().zip(basis) {
        sum += c * b;
    }
    sum
}

/// The sums in the direction of a basis and in the opposite one, where the second band changes sign.
pub fn evaluate_both(coefficients: &Sh, basis: &Sh) -> [f32; 2] {
    let term = |i: usize| coefficients[i] * basis[i];
    let odd = term(1) + term(2) + term(3);
    let even = term(0) + term(4) + term(5) + term(6) + term(7) + term(8);
    [even + odd, even - odd]
}

/// (6.2) for the visible area max(0, `area` n.w) of a disc with this normal, in closed form: the
/// zonal coefficients of the clamped cosine, turned to n. It gives 17/16 of the area straight
/// ahead and 1/16 straight behind.
pub fn disc(normal: Vec3, area: f32) -> Sh {
    use std::f32::consts::PI;
    let y = basis(normal);
    let bands = [PI, 2.0 * PI / 3.0, PI / 4.0].map(|a| a * area);
    std::array::from_fn(|i| y[i] * bands[[0, 1, 1, 1, 2, 2, 2, 2, 2][i]])
}

/// The lobe that discs of a mean normal are likely to have together, over their area; of a share `both`
/// both sides count. Bands 0 and 1 are exact where that does not go with the normals; band 2 is that of normals
/// scattered as heat spreads on the sphere, whose band l is l(l + 1) times as damped.
pub fn expected(mean_normal: Vec3, both: f32) -> Sh {
    let length = mean_normal.length().min(1.0);
    let lobe = disc(mean_normal.normalize_or(Vec3::Z), 1.0);
    let (even, odd) = (1.0 + both, 1.0 - both);
    let bands = [even, odd * length, even * length * length * length];
    std::array::from_fn(|i| lobe[i] * bands[[0, 1, 1, 1, 2, 2, 2, 2, 2][i]])
}

/// That lobe along the mean normal, of which the length is told, and against it.
pub fn expected_along(length: f32, both: f32) -> [f32; 2] {
    let length = length.min(1.0);
    let even = (1.0 + both) * (0.25 + 0.3125 * length * length * length);
    let odd = 0.5 * (1.0 - both) * length;
    [even + odd, even - odd]
}

/// The band-limited disc straight ahead and straight behind, over its area.
const AHEAD: f32 = 1.0625;
const BEHIND: f32 = 0.0625;

/// What a stack of discs with one normal sends to the front, from its band-limited sum in that
/// direction (`ahead`) and in the opposite one (`behind`); never negative.
pub fn front_of_flat(ahead: f32, behind: f32) -> f32 {
    ((AHEAD * ahead - BEHIND * behind) / (AHEAD * AHEAD - BEHIND * BEHIND)).max(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use chiaro_basis::random::r2;
    use std::f32::consts::{PI, TAU};

    fn sphere(n: u64) -> impl Iterator<Item = Vec3> {
        (0..n).map(|i| {
            let [u, v] = r2(i);
            let (z, (sin, cos)) = (1.0 - 2.0 * u, (TAU * v).sin_cos());
            let r = (1.0 - z * z).sqrt();
            Vec3::new(r * cos, r * sin, z)
        })
    }

    #[test]
    fn what_a_mean_normal_tells_is_exact_in_two_bands_and_for_one_normal_in_all() {
        let normals: Vec<Vec3> = sphere(7).map(|n| (n + Vec3::X).normalize()).collect();
        let mut sum = [0.0; 9];
        for n in &normals {
            sum.iter_mut().zip(disc(*n, 1.0 / 7.0)).for_each(|(s, d)| *s += d);
        }
        let told = expected(normals.iter().sum::<Vec3>() / 7.0, 0.0);
        assert!((0..4).all(|i| (told[i] - sum[i]).abs() < 1e-5), "{told:?} {sum:?}");
        let (one, own) = (expected(normals[2], 0.0), disc(normals[2], 1.0));
        assert!((0..9).all(|i| (one[i] - own[i]).abs() < 1e-5), "{one:?} {own:?}");
        let (two, back) = (expected(normals[2], 1.0), disc(-normals[2], 1.0));
        assert!((0..9).all(|i| (two[i] - own[i] - back[i]).abs() < 1e-5), "{two:?} {own:?}");
    }

    #[test]
    fn the_basis_is_orthonormal() {
        let n = 40_000;
        let mut gram = [[0.0f64; 9]; 9];
        for d in sphere(n) {
            let y = basis(d);
            for i in 0..9 {
                for j in 0..9 {
                    gram[i][j] += f64::from(y[i] * y[j]) * 4.0 * std::f64::consts::PI / n as f64;
                }
            }
        }
        for (i, row) in gram.iter().enumerate() {
            for (j, g) in row.iter().enumerate() {
                let expected = if i == j { 1.0 } else { 0.0 };
                assert!((g - expected).abs() < 2e-3, "{i} {j}: {g}");
            }
        }
    }

    #[test]
    fn the_disc_s_closed_form_is_its_integral() {
        let normal = Vec3::new(0.3, -0.5, 0.8).normalize();
        let n = 40_000;
        let mut sum = [0.0f32; 9];
        for d in sphere(n) {
            let value = 2.5 * d.dot(normal).max(0.0) * 4.0 * PI / n as f32;
            let y = basis(d);
            (0..9).for_each(|i| sum[i] += value * y[i]);
        }
        let exact = disc(normal, 2.5);
        for i in 0..9 {
            assert!((sum[i] - exact[i]).abs() < 5e-3, "{i}: {} {}", sum[i], exact[i]);
        }
    }

    #[test]
    fn a_flat_stack_is_told_apart_into_front_and_back() {
        let n = Vec3::new(0.6, 0.0, -0.8);
        let (front, back) = (disc(n, 3.0), disc(-n, 0.5));
        let both: Sh = std::array::from_fn(|i| front[i] + back[i]);
        let (ahead, behind) = (evaluate(&both, &basis(n)), evaluate(&both, &basis(-n)));
        let [a, b] = evaluate_both(&both, &basis(n));
        assert!((a - ahead).abs() < 1e-5 && (b - behind).abs() < 1e-5);
        assert!((front_of_flat(ahead, behind) - 3.0).abs() < 1e-4);
        assert!((front_of_flat(behind, ahead) - 0.5).abs() < 1e-4);
    }
}
