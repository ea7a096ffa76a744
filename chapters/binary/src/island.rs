//! The smallest island: specks take the colour around them.
//!
//! A piece is an 8-connected set of covered pixels of one label. A small piece that touches the
//! other label is recoloured; of small pieces that touch each other the smaller goes first, so that
//! a speck within a speck does not pull it along. A piece that touches no other label stays.

use chiaro_image::Plane;
use chiaro_image::labels::{Components, UNCOVERED, components};
use std::collections::BTreeMap;

/// `labels` of any number without pieces of fewer than `area` pixels: each takes the label with
/// which it shares the longest border, the smallest first.
pub fn without_islands(labels: &Plane<u8>, mask: &Plane<bool>, area: f32) -> Plane<u8> {
    let mut labels = labels.clone();
    if area <= 0.0 {
        return labels;
    }
    loop {
        let found = components(&labels, mask);
        let small = |id: usize| {
            let p = &found.pieces[id];
            (p.area as f32) < area && p.touches_other
        };
        if !(0..found.pieces.len()).any(small) {
            return labels;
        }
        labels = recoloured(&labels, &found, mask, &small);
    }
}

/// Labels whose pieces for which `goes` holds take what surrounds them most; of two that touch the
/// smaller.
pub(crate) fn recoloured(
    labels: &Plane<u8>,
    found: &Components<u8>,
    mask: &Plane<bool>,
    goes: &dyn Fn(usize) -> bool,
) -> Plane<u8> {
    let takes = longest_borders(found, mask, goes);
    let label = |id: &u32, l: &u8| match *id {
        UNCOVERED => *l,
        id => takes[id as usize].unwrap_or(*l),
    };
    found.ids.zip(labels, label).expect("pieces have the picture's size")
}

/// For each small piece that is not beside a smaller one the label that surrounds it most.
fn longest_borders(
    found: &Components<u8>,
    mask: &Plane<bool>,
    small: &dyn Fn(usize) -> bool,
) -> Vec<Option<u8>> {
    let count = found.pieces.len();
    let mut borders: Vec<BTreeMap<u8, u32>> = vec![BTreeMap::new(); count];
    let mut waits = vec![false; count];
    let (w, h) = mask.size();
    let mut meet = |a: u32, b: u32| {
        if a == b || a == UNCOVERED || b == UNCOVERED {
            return;
        }
        for (p, q) in [(a as usize, b as usize), (b as usize, a as usize)] {
            if small(p) {
                *borders[p].entry(found.pieces[q].label).or_default() += 1;
                waits[p] |= small(q) && (found.pieces[q].area, q) < (found.pieces[p].area, p);
            }
        }
    };
    for y in 0..h {
        for x in 0..w {
            let id = found.ids[(x, y)];
            let near = [(x + 1, y), (x, y + 1), (x + 1, y + 1), (x.wrapping_sub(1), y + 1)];
            for q in near.into_iter().filter(|q| q.0 < w && q.1 < h) {
                meet(id, found.ids[q]);
            }
        }
    }
    let most = |b: &BTreeMap<u8, u32>| b.iter().max_by_key(|(_, n)| **n).map(|(l, _)| *l);
    (0..count).map(|id| if small(id) && !waits[id] { most(&borders[id]) } else { None }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cleaned(rows: &[&str], area: f32) -> Vec<String> {
        let (w, h) = (rows[0].len(), rows.len());
        let white = Plane::from_fn(w, h, |x, y| u8::from(rows[y].as_bytes()[x] == b'.'));
        let mask = Plane::from_fn(w, h, |x, y| rows[y].as_bytes()[x] != b' ');
        let out = without_islands(&white, &mask, area);
        let sign = |x, y| {
            if !mask[(x, y)] {
                ' '
            } else if out[(x, y)] == 1 {
                '.'
            } else {
                '#'
            }
        };
        (0..h).map(|y| (0..w).map(|x| sign(x, y)).collect()).collect()
    }

    #[test]
    fn specks_of_many_colours_take_what_surrounds_them_most() {
        let rows = ["0000000", "0011200", "0011200", "0000000", "2222222", "2222222"];
        let labels = Plane::from_fn(7, 6, |x, y| rows[y].as_bytes()[x] - b'0');
        let mask = labels.map(|_| true);
        let out = without_islands(&labels, &mask, 3.0);
        assert_eq!((out[(4, 1)], out[(3, 1)], out[(3, 5)]), (0, 1, 2));
        let out = without_islands(&labels, &mask, 10.0);
        assert_eq!((out[(4, 1)], out[(3, 1)], out[(3, 5)]), (0, 0, 2));
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
