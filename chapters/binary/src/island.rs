//! The smallest island: specks take the colour around them.
//!
//! A piece is an 8-connected set of covered pixels of one label. A small piece that touches the
//! other label is recoloured; of small pieces that touch each other the smaller goes first, so that
//! a speck within a speck does not pull it along. A piece that touches no other label stays.

use chiaro_image::Plane;
use chiaro_image::labels::{UNCOVERED, components};

/// `white` without pieces of fewer than `area` pixels.
pub fn without_islands(white: &Plane<bool>, mask: &Plane<bool>, area: f32) -> Plane<bool> {
    let mut white = white.clone();
    if area <= 0.0 {
        return white;
    }
    // Every pass merges the smallest of each nest; nests are rarely deep.
    while let Some(next) = merge_smallest(&white, mask, area) {
        white = next;
    }
    white
}

/// One pass; `None` when nothing is small.
fn merge_smallest(white: &Plane<bool>, mask: &Plane<bool>, area: f32) -> Option<Plane<bool>> {
    let pieces = components(white, mask);
    let small = |id: usize| {
        let p = &pieces.pieces[id];
        (p.area as f32) < area && p.touches_other
    };
    if !(0..pieces.pieces.len()).any(small) {
        return None;
    }
    let mut flips: Vec<bool> = (0..pieces.pieces.len()).map(small).collect();
    for (a, b) in pieces.touching() {
        let (pa, pb) = (pieces.pieces[a].area, pieces.pieces[b].area);
        // Of two small neighbours the smaller goes, ties by id.
        if small(a) && small(b) {
            flips[if (pa, a) < (pb, b) { b } else { a }] = false;
        }
    }
    let next = pieces.ids.zip(white, |id, w| match *id {
        UNCOVERED => *w,
        id => *w != flips[id as usize],
    });
    Some(next.expect("pieces have the picture's size"))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cleaned(rows: &[&str], area: f32) -> Vec<String> {
        let (w, h) = (rows[0].len(), rows.len());
        let white = Plane::from_fn(w, h, |x, y| rows[y].as_bytes()[x] == b'.');
        let mask = Plane::from_fn(w, h, |x, y| rows[y].as_bytes()[x] != b' ');
        let out = without_islands(&white, &mask, area);
        let sign = |x, y| {
            if !mask[(x, y)] {
                ' '
            } else if out[(x, y)] {
                '.'
            } else {
                '#'
            }
        };
        (0..h).map(|y| (0..w).map(|x| sign(x, y)).collect()).collect()
    }

    #[test]
    fn specks_take_the_colour_around_them() {
        assert_eq!(cleaned(&["....", ".#..", "...."], 3.0), ["....", "....", "...."]);
        assert_eq!(cleaned(&["....", ".##.", "...."], 2.0), ["....", ".##.", "...."]);
    }

    #[test]
    fn what_touches_no_other_colour_stays() {
        assert_eq!(cleaned(&["# ...", "  ..."], 3.0), ["# ...", "  ..."]);
    }

    #[test]
    fn a_speck_within_a_speck_goes_first() {
        let rows = [".........", "..#####..", "..##.##..", "..#####..", "........."];
        let filled = [".........", "..#####..", "..#####..", "..#####..", "........."];
        assert_eq!(cleaned(&rows, 5.0), filled);
        assert_eq!(cleaned(&rows, 16.0)[2], ".........");
    }
}
