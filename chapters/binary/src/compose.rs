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
    /// `sigma` pixels. Says of each pixel what its line is: 0 none, 1 ink, 2 paper.
    pub fn draw_map(&mut self, lines: &Plane<bool>, sigma: f32) -> Plane<u8> {
        let is_white = |white: &f32, opacity: &f32| white * opacity + 1.0 - opacity >= 0.5;
        let colour = self.white.zip(&self.opacity, |w, o| 1 + u8::from(!is_white(w, o)));
        let colour = colour.expect("both have the picture's size");
        let everywhere = lines.map(|_| true);
        let drawn = chiaro_ink::smooth_coverage(lines, &everywhere, sigma);
        let pixels = self.white.pixels_mut().iter_mut().zip(self.opacity.pixels_mut());
        for ((white, opacity), line) in pixels.zip(drawn.pixels()) {
            let other = if is_white(white, opacity) { 0.0 } else { 1.0 };
            *white += line * (other - *white);
            *opacity = opacity.max(*line);
        }
        lines.zip(&colour, |l, c| if *l { *c } else { 0 }).expect("a map has the picture's size")
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

/// The same picture in one bit a pixel over white or black paper. Pixels are a line's whose centres
/// it covers; lines thinner than a pixel are drawn a pixel wide.
pub fn one_bit(marks: &Marks, lines: &Lines, paper_is_white: bool) -> Plane<bool> {
    let paper = if paper_is_white { 1.0 } else { 0.0 };
    let mut bits = marks
        .white
        .zip(&marks.opacity, |w, o| w * o + paper * (1.0 - o) >= 0.5)
        .expect("both have the picture's size");
    if lines.width < 1.0 {
        for (list, colour) in [(&lines.white, true), (&lines.black, false)] {
            let drawn = draw(list, bits.size(), 1.0);
            let pixels = bits.pixels_mut().iter_mut().zip(drawn.pixels());
            pixels.filter(|(_, d)| **d >= 0.5).for_each(|(bit, _)| *bit = colour);
        }
    }
    bits
}

#[cfg(test)]
mod tests {
    use super::*;
    use chiaro_ink::Polyline;

    #[test]
    fn lines_in_one_bit_are_as_wide_as_they_say() {
        let covered = Plane::filled(40, 21, true);
        let region = covered.map(|_| 1.0);
        for (width, rows) in [(0.3, 1), (1.0, 1), (3.0, 3), (5.0, 5)] {
            let black = vec![Polyline { points: vec![[-9.0, 10.5], [50.0, 10.5]], closed: false }];
            let lines = Lines { black, white: Vec::new(), width };
            let marks = compose(&region, &covered, &lines, &BinaryKnobs::default());
            let bits = one_bit(&marks, &lines, true);
            assert_eq!((0..21).filter(|y| !bits[(20, *y)]).count(), rows, "{width}");
        }
    }
}
