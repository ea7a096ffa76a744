//! The pieces of a label image: connected pixels of equal label.
//!
//! Pieces are 8-connected: pixels that touch at a corner belong together, whatever their label, so
//! two pieces may cross at a corner. Found by flooding from each pixel not yet reached, in reading
//! order, with a stack of its own; the time is linear in the pixels.

use crate::Plane;
use std::collections::BTreeSet;

/// The number, in [`Components::ids`], of pixels that are not covered.
pub const UNCOVERED: u32 = u32::MAX;

/// All pieces of a label image.
#[derive(Clone, Debug, PartialEq)]
pub struct Components<T> {
    /// The pieces, in the reading order of their first pixels.
    pub pieces: Vec<Piece<T>>,
    /// For each pixel its piece's place in `pieces`, or [`UNCOVERED`].
    pub ids: Plane<u32>,
}

/// Connected pixels of one label.
#[derive(Clone, Debug, PartialEq)]
pub struct Piece<T> {
    /// What all its pixels are labelled.
    pub label: T,
    /// Its pixels.
    pub area: usize,
    /// The least x and y that occur.
    pub first: (usize, usize),
    /// The greatest x and y that occur.
    pub last: (usize, usize),
    /// Whether a pixel of another label touches it, at a side or a corner. A piece that touches
    /// none is not an island: it is all there is of its object.
    pub touches_other: bool,
}

impl<T> Components<T> {
    /// The places in `pieces` of pieces that touch at a side or a corner, the lower first, each pair
    /// once, sorted.
    pub fn touching(&self) -> Vec<(usize, usize)> {
        let size = self.ids.size();
        let mut pairs = BTreeSet::new();
        for (y, x) in (0..size.1).flat_map(|y| (0..size.0).map(move |x| (y, x))) {
            let id = self.ids[(x, y)];
            let near = neighbours((x, y), size).map(|at| self.ids[at]);
            // Seen from the higher one alone; UNCOVERED is the highest.
            pairs.extend(
                near.filter(|&n| n < id && id != UNCOVERED).map(|n| (n as usize, id as usize)),
            );
        }
        pairs.into_iter().collect()
    }
}

/// The pieces of equal label among the covered pixels. Panics when the sizes differ or when there
/// are 2^32 - 1 pixels or more.
pub fn components<T: Copy + PartialEq>(labels: &Plane<T>, mask: &Plane<bool>) -> Components<T> {
    assert_eq!(labels.size(), mask.size(), "a mask has the size of its plane");
    assert!(labels.len() < UNCOVERED as usize, "every pixel can have a number");
    let (width, height) = labels.size();
    let mut ids = Plane::filled(width, height, UNCOVERED);
    let mut pieces = Vec::new();
    let mut stack = Vec::new();
    for y in 0..height {
        for x in 0..width {
            if mask[(x, y)] && ids[(x, y)] == UNCOVERED {
                let id = pieces.len() as u32;
                pieces.push(flood(labels, mask, (x, y), id, &mut ids, &mut stack));
            }
        }
    }
    Components { pieces, ids }
}

/// Numbers the piece that contains `start`.
fn flood<T: Copy + PartialEq>(
    labels: &Plane<T>,
    mask: &Plane<bool>,
    start: (usize, usize),
    id: u32,
    ids: &mut Plane<u32>,
    stack: &mut Vec<(usize, usize)>,
) -> Piece<T> {
    let label = labels[start];
    let mut piece = Piece { label, area: 0, first: start, last: start, touches_other: false };
    ids[start] = id;
    stack.push(start);
    while let Some(at) = stack.pop() {
        piece.grow(at);
        for near in neighbours(at, labels.size()).filter(|near| mask[*near]) {
            if labels[near] != label {
                piece.touches_other = true;
            } else if ids[near] == UNCOVERED {
                ids[near] = id;
                stack.push(near);
            }
        }
    }
    piece
}

impl<T> Piece<T> {
    fn grow(&mut self, (x, y): (usize, usize)) {
        self.area += 1;
        self.first = (self.first.0.min(x), self.first.1.min(y));
        self.last = (self.last.0.max(x), self.last.1.max(y));
    }
}

/// The up to eight pixels around one, and the pixel itself.
fn neighbours(
    (x, y): (usize, usize),
    (width, height): (usize, usize),
) -> impl Iterator<Item = (usize, usize)> {
    let columns = x.saturating_sub(1)..(x + 2).min(width);
    let rows = y.saturating_sub(1)..(y + 2).min(height);
    rows.flat_map(move |y| columns.clone().map(move |x| (x, y)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use chiaro_basis::random;

    /// Labels drawn as text; a space is not covered.
    fn drawn(rows: &[&str]) -> (Plane<char>, Plane<bool>) {
        let text: Vec<char> = rows.iter().flat_map(|row| row.chars()).collect();
        let labels = Plane::from_pixels(rows[0].len(), rows.len(), text);
        let mask = labels.map(|c| *c != ' ');
        (labels, mask)
    }

    #[test]
    fn corners_connect_and_labels_separate() {
        let (labels, mask) = drawn(&["a.a.", ".a..", "....", "..bb"]);
        let found = components(&labels, &mask);
        let seen: Vec<(char, usize)> = found.pieces.iter().map(|p| (p.label, p.area)).collect();
        assert_eq!(seen, [('a', 3), ('.', 11), ('b', 2)]);
        assert_eq!((found.pieces[0].first, found.pieces[0].last), ((0, 0), (2, 1)));
        assert_eq!((found.pieces[2].first, found.pieces[2].last), ((2, 3), (3, 3)));
        assert!(found.pieces.iter().all(|piece| piece.touches_other));
        assert_eq!(found.touching(), [(0, 1), (1, 2)]);
        assert_eq!(found.ids[(1, 1)], 0);
        assert_eq!(found.ids[(3, 3)], 2);
    }

    #[test]
    fn a_lone_object_touches_no_other_colour() {
        let (labels, mask) = drawn(&["aa  .", "aa  .", "    .", ".   a"]);
        let found = components(&labels, &mask);
        let touching: Vec<bool> = found.pieces.iter().map(|p| p.touches_other).collect();
        assert_eq!(touching, [false, true, false, true]);
        assert_eq!(found.touching(), [(1, 3)]);
        assert_eq!(found.ids[(2, 0)], UNCOVERED);
    }

    #[test]
    fn every_covered_pixel_is_in_the_piece_of_its_label() {
        let labels = Plane::from_fn(61, 47, |x, y| random::hash(5, (y * 61 + x) as u64) % 3);
        let mask = Plane::from_fn(61, 47, |x, y| random::unit(6, (y * 61 + x) as u64) < 0.8);
        let found = components(&labels, &mask);
        let mut areas = vec![0; found.pieces.len()];
        for (i, id) in found.ids.pixels().iter().enumerate() {
            assert_eq!(*id == UNCOVERED, !mask.pixels()[i]);
            if *id != UNCOVERED {
                assert_eq!(found.pieces[*id as usize].label, labels.pixels()[i]);
                areas[*id as usize] += 1;
            }
        }
        assert!(found.pieces.iter().zip(areas).all(|(piece, area)| piece.area == area));
    }

    #[test]
    fn a_long_snake_needs_no_recursion() {
        let snake = |x: usize, y: usize| {
            y.is_multiple_of(2) || (x == 0 && y % 4 == 1) || (x == 1999 && y % 4 == 3)
        };
        let labels = Plane::from_fn(2000, 1001, snake);
        let found = components(&labels, &labels.map(|_| true));
        let snakes = found.pieces.iter().filter(|piece| piece.label).count();
        assert_eq!((snakes, found.pieces.len()), (1, 501));
        assert!(components(&Plane::<u8>::default(), &Plane::default()).pieces.is_empty());
    }
}
