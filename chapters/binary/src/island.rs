//! The smallest island: specks take the colour around them.
//!
//! A piece is an 8-connected set of covered pixels of one label. A small piece that touches the
//! other label is recoloured; of small pieces that touch each other the smaller goes first, so that
//! a speck within a speck does not pull it along. A piece that touches no other label stays.

use chiaro_image::Plane;
use chiaro_image::labels::components;

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
    let next = pieces.ids.zip(white, |id, w| match id {
        Some(id) => *w != flips[*id as usize],
        None => *w,
    });
    Some(next.expect("pieces have the picture's size"))
}
