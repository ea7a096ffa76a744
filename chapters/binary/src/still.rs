//! What stands still in a film: where a frame weighs as the one before, its labels are the same.
//!
//! A window sees more of the shot, or less, from one frame to the next, and strengths of links change;
//! so labels could change where nothing in the picture does. What a place looks like decides there:
//! 1. A pixel is *still* if all it pays, for labels and for borders, is what the pixel that it was paid,
//!    within [`ALIKE`], and so around it.
//! 2. Patches of changed labels of which every pixel is still are undone.

use crate::cel::Cel;
use crate::window::widen_line;
use chiaro_image::Plane;
use chiaro_image::labels::components;
use chiaro_trace::UNLINKED;

/// How far apart weights may be that count as the same, as a share of a weight of 1.
const ALIKE: f32 = 0.002;

/// How far around a pixel all must be still, pixels.
const REACH: usize = 2;

/// The pixels of a frame's layer that are still since the frame before.
pub(crate) fn still(cel: &Cel, before: Option<&Cel>, layer: usize) -> Plane<bool> {
    let (w, h) = cel.graph.mask.size();
    let Some(before) = before else { return Plane::filled(w, h, false) };
    let most = ALIKE * cel.graph.scale;
    let alike = |a: &[i32], b: &[i32]| a.iter().zip(b).all(|(a, b)| a.abs_diff(*b) as f32 <= most);
    let count = cel.count(layer);
    let (prices, former) = (cel.prices(layer), before.prices(layer));
    let (bonds, bonds_before) = (cel.graph.neighbour.pixels(), before.graph.neighbour.pixels());
    let is_still = |p: usize| match cel.links.pixels()[p] {
        UNLINKED => !cel.graph.mask.pixels()[p] && !before.graph.mask.pixels()[p],
        to => {
            let to = to as usize;
            alike(&prices[p * count..][..count], &former[to * count..][..count])
                && alike(&bonds[p], &bonds_before[to])
        }
    };
    let mut moves: Vec<bool> = (0..w * h).map(|p| !is_still(p)).collect();
    moves.chunks_mut(w.max(1)).for_each(|row| widen_line(row, 0, 1, w, REACH));
    (0..w).for_each(|x| widen_line(&mut moves, x, w, h, REACH));
    Plane::from_pixels(w, h, moves.into_iter().map(|moves| !moves).collect())
}

/// Labels without changes since the frame before that nothing accounts for.
pub(crate) fn kept_still(
    labels: Plane<u8>,
    before: &Plane<u8>,
    links: &Plane<u32>,
    still: &Plane<bool>,
) -> Plane<u8> {
    let former = |p: usize| match links.pixels()[p] {
        UNLINKED => None,
        to => Some(before.pixels()[to as usize]),
    };
    let (w, h) = labels.size();
    let changed = |p: usize| former(p).is_some_and(|label| label != labels.pixels()[p]);
    let changed = Plane::from_fn(w, h, |x, y| changed(y * w + x));
    if !changed.pixels().contains(&true) {
        return labels;
    }
    let patches = components(&changed.map(|_| 0u8), &changed);
    let mut goes = vec![true; patches.pieces.len()];
    let each = || patches.ids.pixels().iter().enumerate().filter(|(p, _)| changed.pixels()[*p]);
    each().for_each(|(p, id)| goes[*id as usize] &= still.pixels()[p]);
    let mut kept = labels;
    for (p, _) in each().filter(|(_, id)| goes[**id as usize]) {
        kept[(p % w, p / w)] = former(p).unwrap_or(kept.pixels()[p]);
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cut::Graph;
    use crate::knob::BinaryKnobs;

    /// A square of 12 pixels a side that wants to be black, but for a column that wants as told.
    fn square(column: f32) -> Cel {
        let knobs = BinaryKnobs::default();
        let covered = Plane::filled(12, 12, true);
        let difference = Plane::from_fn(12, 12, |x, _| if x == 9 { column } else { -0.3 });
        let graph = Graph::new(&covered, &difference, &Plane::filled(12, 12, [1.0; 4]), &knobs);
        let own = Plane::from_fn(12, 12, |x, y| (y * 12 + x) as u32);
        Cel::new(graph, own).expect("small weights")
    }

    #[test]
    fn what_changes_where_nothing_else_does_is_undone() {
        let (before, cel) = (square(-0.3), square(-0.2));
        let still = still(&cel, Some(&before), 0);
        for x in 0..12 {
            assert_eq!(still[(x, 5)], x < 9 - REACH, "{x}");
        }
        let former = Plane::filled(12, 12, 0u8);
        // A patch where all is still, one that reaches beyond, and one where all moves.
        let patches = [(1..3, 1), (4..8, 5), (9..11, 9)];
        let labels = Plane::from_fn(12, 12, |x, y| {
            u8::from(patches.iter().any(|(columns, row)| columns.contains(&x) && *row == y))
        });
        let kept = kept_still(labels.clone(), &former, &cel.links, &still);
        for y in 0..12 {
            let wanted = if y == 1 { former.row(y) } else { labels.row(y) };
            assert_eq!(kept.row(y), wanted, "row {y}");
        }
    }

    #[test]
    fn nothing_is_still_without_a_frame_before() {
        assert!(!still(&square(0.1), None, 0).pixels().contains(&true));
    }
}
