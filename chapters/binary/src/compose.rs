//! Regions and lines as one picture.

use crate::knob::{BinaryKnobs, scaled};
use crate::line::Lines;
use chiaro_image::Plane;
use chiaro_ink::{draw, smooth_coverage};

/// A picture in two shares a pixel: how white it is where there is something, and how much of the
/// pixel there is. Both in [0, 1], antialiased.
#[derive(Clone, Debug)]
pub struct Marks {
    /// 0 = ink, 1 = paper.
    pub white: Plane<f32>,
    /// 0 = background, 1 = object or line.
    pub opacity: Plane<f32>,
}

impl Marks {
    /// Draws a map of lines on top, in ink on white and in paper's colour on black, smoothed by
    /// `sigma` pixels.
    pub fn draw_map(&mut self, lines: &Plane<bool>, sigma: f32) {
        let everywhere = lines.map(|_| true);
        let drawn = chiaro_ink::smooth_coverage(lines, &everywhere, sigma);
        let pixels = self.white.pixels_mut().iter_mut().zip(self.opacity.pixels_mut());
        for ((white, opacity), line) in pixels.zip(drawn.pixels()) {
            let other = if *white * *opacity + 1.0 - *opacity >= 0.5 { 0.0 } else { 1.0 };
            *white += line * (other - *white);
            *opacity = opacity.max(*line);
        }
    }
}

/// Draws lines over regions, of which `region` says how white each pixel is.
pub fn compose(
    region: &Plane<f32>,
    covered: &Plane<bool>,
    lines: &Lines,
    knobs: &BinaryKnobs,
) -> Marks {
    let size = covered.size();
    let sigma = scaled(knobs.smooth, size.1);
    let everywhere = Plane::filled(size.0, size.1, true);
    let (object, (black_lines, white_lines)) = rayon::join(
        || smooth_coverage(covered, &everywhere, sigma),
        || {
            rayon::join(
                || draw(&lines.black, size, lines.width),
                || draw(&lines.white, size, lines.width),
            )
        },
    );
    let over = |a: &Plane<f32>, b: &Plane<f32>, f: fn(&f32, &f32) -> f32| {
        a.zip(b, f).expect("all have the picture's size")
    };
    let with_white = over(region, &white_lines, |r, w| r + (1.0 - r) * w);
    Marks {
        white: over(&with_white, &black_lines, |w, b| w * (1.0 - b)),
        opacity: over(&object, &black_lines, |o, b| o.max(*b)),
    }
}

/// The same picture in one bit a pixel over white or black paper.
pub fn one_bit(marks: &Marks, paper_is_white: bool) -> Plane<bool> {
    let paper = if paper_is_white { 1.0 } else { 0.0 };
    marks
        .white
        .zip(&marks.opacity, |w, o| w * o + paper * (1.0 - o) >= 0.5)
        .expect("both have the picture's size")
}
