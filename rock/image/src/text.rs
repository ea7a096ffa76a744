//! Small text on pictures, for the captions of contact sheets and figures.
//!
//! The letters are bitmaps of our own, so that the same text gives the same pixels everywhere and
//! no font file is looked for. They are for labels, not for reading: ASCII alone, in one size and
//! its whole multiples. Any other character shows as a box.

mod font;

use crate::Plane;
use font::Letter;

/// Pixels between letters, at scale 1.
const GAP: usize = 1;

/// Pixels from one line to the next at scale 1.
pub const LINE_HEIGHT: usize = font::HEIGHT + 2;

/// The pixels that a line of text takes across.
pub fn text_width(text: &str, scale: usize) -> usize {
    let columns: usize = text.chars().map(|c| Letter::of(c).width + GAP).sum();
    columns.saturating_sub(GAP) * scale
}

/// Draws one line of text with its upper left corner at (x, y), each pixel of a letter `scale`
/// pixels wide. What falls outside the picture is not drawn.
pub fn draw_text(
    picture: &mut Plane<[u8; 3]>,
    (x, y): (usize, usize),
    text: &str,
    scale: usize,
    colour: [u8; 3],
) {
    let mut pen = x;
    for letter in text.chars().map(Letter::of) {
        for row in 0..font::HEIGHT {
            for column in (0..letter.width).filter(|column| letter.is_inked(*column, row)) {
                fill(picture, (pen + column * scale, y + row * scale), (scale, scale), colour);
            }
        }
        pen += (letter.width + GAP) * scale;
    }
}

/// Fills a rectangle as far as it lies inside the picture.
pub(crate) fn fill(
    picture: &mut Plane<[u8; 3]>,
    (x, y): (usize, usize),
    (width, height): (usize, usize),
    colour: [u8; 3],
) {
    let (right, bottom) = ((x + width).min(picture.width()), (y + height).min(picture.height()));
    for y in y..bottom {
        for x in x..right {
            picture[(x, y)] = colour;
        }
    }
}

/// Breaks text into lines that are at most `width` pixels wide, at spaces where that is possible
/// and inside words where it is not. Line breaks in the text stay.
pub fn wrap_text(text: &str, width: usize, scale: usize) -> Vec<String> {
    text.lines().flat_map(|line| wrap_line(line, width, scale)).collect()
}

fn wrap_line(text: &str, width: usize, scale: usize) -> Vec<String> {
    let mut lines = vec![String::new()];
    for word in text.split_whitespace().flat_map(|word| pieces(word, width, scale)) {
        let line = lines.last_mut().expect("there is always a line");
        let longer = if line.is_empty() { word.clone() } else { format!("{line} {word}") };
        if line.is_empty() || text_width(&longer, scale) <= width {
            *line = longer;
        } else {
            lines.push(word);
        }
    }
    lines
}

/// A word in pieces that fit, each at least one letter long.
fn pieces(word: &str, width: usize, scale: usize) -> Vec<String> {
    let mut pieces = vec![String::new()];
    for letter in word.chars() {
        let piece = pieces.last_mut().expect("there is always a piece");
        let longer = format!("{piece}{letter}");
        if piece.is_empty() || text_width(&longer, scale) <= width {
            *piece = longer;
        } else {
            pieces.push(letter.into());
        }
    }
    pieces
}

#[cfg(test)]
mod tests {
    use super::*;

    fn drawn(text: &str, scale: usize) -> Plane<[u8; 3]> {
        let mut picture = Plane::filled(text_width(text, scale), LINE_HEIGHT * scale, [255; 3]);
        draw_text(&mut picture, (0, 0), text, scale, [0; 3]);
        picture
    }

    fn ink(picture: &Plane<[u8; 3]>) -> usize {
        picture.pixels().iter().filter(|p| **p == [0; 3]).count()
    }

    #[test]
    fn text_is_as_wide_as_is_said_and_scales() {
        let picture = drawn("Figure 3.1: |g| = 0.5", 1);
        let last = picture.width() - 1;
        assert!((0..picture.height()).any(|y| picture[(0, y)] == [0; 3]));
        assert!((0..picture.height()).any(|y| picture[(last, y)] == [0; 3]));
        let double = drawn("Figure 3.1: |g| = 0.5", 2);
        assert_eq!(double.width(), 2 * picture.width());
        assert_eq!(ink(&double), 4 * ink(&picture));
        assert_eq!(text_width("", 1), 0);
    }

    #[test]
    fn every_letter_has_a_shape_of_its_own() {
        let printable = || (33..127u8).map(|code| drawn(&char::from(code).to_string(), 1));
        for (i, a) in printable().enumerate() {
            assert!(ink(&a) > 0);
            assert!(printable().skip(i + 1).all(|b| a != b), "{}", char::from(33 + i as u8));
        }
        assert_eq!(drawn("é", 1), drawn("\u{7f}", 1));
        assert_eq!(ink(&drawn(" ", 1)), 0);
    }

    #[test]
    fn lines_break_at_spaces_and_words_only_when_they_must() {
        assert_eq!(wrap_text("one two three", 45, 1), ["one two", "three"]);
        assert_eq!(wrap_text("a\nb", 100, 1), ["a", "b"]);
        for (text, width) in [("unbreakable_name_of_a_style", 40), ("WWWW", 1), ("", 30)] {
            let lines = wrap_text(text, width, 1);
            assert_eq!(lines.concat(), text);
            assert!(lines.iter().all(|l| l.chars().count() <= 1 || text_width(l, 1) <= width));
        }
    }

    #[test]
    fn what_falls_outside_is_not_drawn() {
        let mut picture = Plane::filled(4, 4, [255; 3]);
        draw_text(&mut picture, (2, 2), "MMM", 3, [0; 3]);
        assert!(ink(&picture) > 0);
        draw_text(&mut Plane::filled(0, 0, [0; 3]), (9, 9), "x", 1, [0; 3]);
    }
}
