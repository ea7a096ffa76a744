//! Regions and lines as one picture.

use crate::knob::{BinaryKnobs, scaled};
use crate::line::Lines;
use chiaro_image::{Plane, filter};
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
    /// Draws the lines of a map on top, smoothed by `sigma` pixels. Of `map` each pixel is 0, or 1 for
    /// ink and 2 for paper (see [`map_colours`]). Gives the share of each pixel that ink and paper cover.
    pub fn draw_map(&mut self, map: &Plane<u8>, sigma: f32) -> [Plane<f32>; 2] {
        let everywhere = map.map(|_| true);
        let cover = |colour: u8| smooth_coverage(&map.map(|m| *m == colour), &everywhere, sigma);
        let (ink, paper) = rayon::join(|| cover(1), || cover(2));
        let pixels = self.white.pixels_mut().iter_mut().zip(self.opacity.pixels_mut());
        for ((white, opacity), (i, p)) in pixels.zip(ink.pixels().iter().zip(paper.pixels())) {
            *white = (*white * (1.0 - i)).max(*p);
            *opacity = opacity.max(*i).max(*p);
        }
        [ink, paper]
    }
}

/// The colours of a map's lines over regions that are `light` or not: 0 none, 1 ink, 2 paper. Lines
/// are paper inside black; along its border, within their own width, they are ink, or that border
/// would be drawn twice.
pub fn map_colours(lines: &Plane<bool>, light: &Plane<bool>) -> Plane<u8> {
    let depth = filter::distance_to(light);
    let width = mean_width(lines);
    Plane::from_fn(lines.width(), lines.height(), |x, y| match lines[(x, y)] {
        true if depth[(x, y)] > width + 0.5 => 2,
        drawn => u8::from(drawn),
    })
}

/// The mean width of lines in pixels: twice their area over their border.
fn mean_width(lines: &Plane<bool>) -> f32 {
    let (w, h) = lines.size();
    let (mut area, mut border) = (0usize, 0usize);
    for y in 0..h {
        for x in 0..w {
            let here = lines[(x, y)];
            area += usize::from(here);
            border += usize::from(x + 1 < w && lines[(x + 1, y)] != here);
            border += usize::from(y + 1 < h && lines[(x, y + 1)] != here);
        }
    }
    2.0 * area as f32 / border.max(1) as f32
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
    fn lines_of_a_map_are_paper_inside_black_and_ink_along_it() {
        let light = Plane::from_fn(40, 30, |x, _| x < 20);
        let down = |left: usize| Plane::from_fn(40, 30, move |x, _| (left..left + 3).contains(&x));
        let colours = |left: usize| map_colours(&down(left), &light).row(15).to_vec();
        for (left, colour) in [(5, 1), (18, 1), (19, 1), (20, 1), (30, 2)] {
            let expected = (0..40).map(|x| if (left..left + 3).contains(&x) { colour } else { 0 });
            assert_eq!(colours(left), expected.collect::<Vec<u8>>(), "{left}");
        }
    }

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
