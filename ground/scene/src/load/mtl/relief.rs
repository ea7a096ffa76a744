//! Bump maps: heights to tangent-space normals.
//!
//! A bump map's height has no unit. Here white stands above black by [`HEIGHT`] of the picture's
//! width, so that a map shows as much whatever its size in pixels; `-bm` scales it.

use crate::Texture;
use chiaro_image::Plane;

/// The height of white over black, as a part of the picture's width.
const HEIGHT: f32 = 0.01;

/// Whether a picture looks like tangent-space normals: blue on the whole, and not grey.
pub(super) fn is_normal_map(texture: &Texture) -> bool {
    let pixels = texture.pixels.pixels();
    let step = pixels.len() / 1000 + 1;
    let samples = pixels.iter().step_by(step);
    let blue = samples.clone().filter(|p| p[2] > 150 && p[2] > p[0].saturating_add(20)).count();
    2 * blue > samples.count()
}

/// Normals, x right and y up, of a picture of heights that repeats: gradients by Sobel's filter,
/// which smooths across so that the steps of 8 bits stay small.
pub(super) fn normals(heights: &Plane<[u8; 4]>) -> Plane<[u8; 4]> {
    let (width, height) = heights.size();
    let grey = heights.map(|p| (f32::from(p[0]) + f32::from(p[1]) + f32::from(p[2])) / 765.0);
    let steep = HEIGHT * width as f32 / 8.0;
    Plane::from_fn(width, height, |x, y| {
        let [left, right] = [(x + width - 1) % width, (x + 1) % width];
        let [above, below] = [(y + height - 1) % height, (y + 1) % height];
        let column = |x: usize| grey[(x, above)] + 2.0 * grey[(x, y)] + grey[(x, below)];
        let row = |y: usize| grey[(left, y)] + 2.0 * grey[(x, y)] + grey[(right, y)];
        let slope = [column(right) - column(left), row(above) - row(below)];
        let n = [-slope[0] * steep, -slope[1] * steep, 1.0];
        let length = (n[0] * n[0] + n[1] * n[1] + 1.0).sqrt();
        let [r, g, b] = n.map(|c| (127.5 * c / length + 127.5).round() as u8);
        [r, g, b, 255]
    })
}

#[cfg(test)]
mod tests {
    use super::super::super::picture;
    use super::*;

    #[test]
    fn slopes_lean_away_from_what_rises() {
        // A ramp of one grey level a pixel to the right, 100 pixels wide.
        let ramp = Plane::from_fn(100, 4, |x, _| [x as u8, x as u8, x as u8, 255]);
        let [r, g, b, _] = normals(&ramp)[(50, 2)];
        let x = -1.0 / 255.0 / (1.0f32 + 1.0 / 255.0 / 255.0).sqrt();
        assert_eq!((r, g, b), ((127.5 * x + 127.5).round() as u8, 128, 255));
        // Rising towards the top of the picture, the normal leans to its bottom: y up.
        let ramp = Plane::from_fn(40, 40, |_, y| {
            [[250 - 6 * y as u8; 3].as_slice(), &[255]].concat().try_into().unwrap()
        });
        assert!(normals(&ramp)[(20, 20)][1] < 127);
    }

    #[test]
    fn normal_maps_are_told_from_heights() {
        let of = |pixel: [u8; 4]| picture::texture("", Plane::from_fn(8, 8, |_, _| pixel));
        assert!(is_normal_map(&of([128, 128, 255, 255])));
        assert!(!is_normal_map(&of([200, 200, 200, 255])));
        assert!(is_normal_map(&picture::texture("", normals(&of([9, 9, 9, 255]).pixels))));
    }
}
