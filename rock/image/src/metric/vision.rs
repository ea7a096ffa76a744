//! Colour as eyes see it, for the perceptual metrics: sRGB to XYZ to CIELAB.

use crate::colour::srgb_decode;

type Matrix = [[f32; 3]; 3];

/// Linear sRGB to XYZ; the rows' sums are the white point, D65.
const TO_XYZ: Matrix = [
    [0.412_386_56, 0.357_591_49, 0.180_450_49],
    [0.212_636_82, 0.715_182_98, 0.072_180_2],
    [0.019_330_63, 0.119_197_16, 0.950_372_6],
];
const FROM_XYZ: Matrix = [
    [3.241_003_3, -1.537_398_9, -0.498_615_9],
    [-0.969_224_3, 1.875_93, 0.041_554_23],
    [0.055_639_42, -0.204_011_2, 1.057_149],
];

fn times(matrix: &Matrix, v: [f32; 3]) -> [f32; 3] {
    matrix.map(|row| row[0] * v[0] + row[1] * v[1] + row[2] * v[2])
}

/// XYZ of linear white.
pub(super) fn white() -> [f32; 3] {
    TO_XYZ.map(|row| row.iter().sum())
}

/// Linear light of sRGB-encoded values, clamped to [0, 1].
pub(super) fn linear(encoded: [f32; 3]) -> [f32; 3] {
    encoded.map(|c| srgb_decode(c.clamp(0.0, 1.0)))
}

/// XYZ of linear sRGB.
pub(super) fn xyz(linear: [f32; 3]) -> [f32; 3] {
    times(&TO_XYZ, linear)
}

/// Linear sRGB of XYZ.
pub(super) fn xyz_to_linear(xyz: [f32; 3]) -> [f32; 3] {
    times(&FROM_XYZ, xyz)
}

/// CIELAB of XYZ.
pub(super) fn lab(xyz: [f32; 3]) -> [f32; 3] {
    const DELTA: f32 = 6.0 / 29.0;
    let white = white();
    let f = |t: f32| {
        if t > DELTA.powi(3) { t.cbrt() } else { t / (3.0 * DELTA * DELTA) + 4.0 / 29.0 }
    };
    let [x, y, z] = std::array::from_fn(|i| f(xyz[i] / white[i]));
    [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_matrices_are_inverse_and_white_is_white() {
        let back = xyz_to_linear(xyz([0.2, 0.7, 0.4]));
        for (a, b) in back.iter().zip([0.2, 0.7, 0.4]) {
            assert!((a - b).abs() < 1e-4, "{back:?}");
        }
        let [l, a, b] = lab(xyz([1.0; 3]));
        assert!((l - 100.0).abs() < 1e-3 && a.abs() < 1e-3 && b.abs() < 1e-3);
    }
}
