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

/// Smooths the borders of the regions and draws the lines over them.
pub fn compose(
    white: &Plane<bool>,
    covered: &Plane<bool>,
    lines: &Lines,
    knobs: &BinaryKnobs,
) -> Marks {
    let size = covered.size();
    let sigma = scaled(knobs.smooth, size.1);
    let everywhere = Plane::filled(size.0, size.1, true);
    let region = smooth_coverage(white, covered, sigma);
    let object = smooth_coverage(covered, &everywhere, sigma);
    let black_lines = draw(&lines.black, size, lines.width);
    let white_lines = draw(&lines.white, size, lines.width);
    let inked = Plane::from_fn(size.0, size.1, |x, y| {
        let at = (x, y);
        let with_white = region[at] + (1.0 - region[at]) * white_lines[at];
        let value = with_white * (1.0 - black_lines[at]);
        let opacity = object[at].max(black_lines[at]);
        [value, opacity]
    });
    Marks { white: inked.map(|p| p[0]), opacity: inked.map(|p| p[1]) }
}

/// The same picture in one bit a pixel over white or black paper.
pub fn one_bit(marks: &Marks, paper_is_white: bool) -> Plane<bool> {
    let paper = if paper_is_white { 1.0 } else { 0.0 };
    marks
        .white
        .zip(&marks.opacity, |w, o| w * o + paper * (1.0 - o) >= 0.5)
        .expect("both have the picture's size")
}
