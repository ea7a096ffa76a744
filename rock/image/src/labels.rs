//! The pieces of a label image: connected pixels of equal label.
//!
//! Pieces are 8-connected, pixels that touch at a corner belong together, whatever their label, so
//! that two pieces may cross at a corner; or 4-connected, by sides alone. Found row by row: runs of equal label are joined with the runs
//! they touch in the row above (union by the earliest run), so that the time is all but linear in
//! the pixels and nothing recurses.

use crate::Plane;

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
    /// Whether a pixel of another label touches it, at a side or, if corners connect, at a corner. A piece that touches
    /// none is not an island: it is all there is of its object.
    pub touches_other: bool,
}

impl<T> Components<T> {
    /// The places in `pieces` of pieces that touch at a side or a corner, the lower first, each pair
    /// once, sorted.
    pub fn touching(&self) -> Vec<(usize, usize)> {
        let height = self.ids.height();
        let mut pairs = Vec::new();
        let mut note = |a: u32, b: u32| {
            if a != b && a != UNCOVERED && b != UNCOVERED {
                let pair = (a.min(b) as usize, a.max(b) as usize);
                if pairs.last() != Some(&pair) {
                    pairs.push(pair);
                }
            }
        };
        for y in 0..height {
            let row = self.ids.row(y);
            row.windows(2).for_each(|p| note(p[0], p[1]));
            if y + 1 < height {
                let below = self.ids.row(y + 1);
                row.iter().zip(below).for_each(|(a, b)| note(*a, *b));
                row.iter().zip(below.iter().skip(1)).for_each(|(a, b)| note(*a, *b));
                row.iter().skip(1).zip(below).for_each(|(a, b)| note(*a, *b));
            }
        }
        pairs.sort_unstable();
        pairs.dedup();
        pairs
    }
}

/// The pieces of equal label among the covered pixels. Panics when the sizes differ or when there
/// are 2^32 - 1 pixels or more.
pub fn components<T: Copy + PartialEq>(labels: &Plane<T>, mask: &Plane<bool>) -> Components<T> {
    connected(labels, mask, 1)
}

/// [`components`] of pixels that are connected by their sides.
pub fn components_by_sides<T: Copy + PartialEq>(
    labels: &Plane<T>,
    mask: &Plane<bool>,
) -> Components<T> {
    connected(labels, mask, 0)
}

fn connected<T: Copy + PartialEq>(
    labels: &Plane<T>,
    mask: &Plane<bool>,
    reach: usize,
) -> Components<T> {
    assert_eq!(labels.size(), mask.size(), "a mask has the size of its plane");
    assert!(labels.len() < UNCOVERED as usize, "every pixel can have a number");
    let mut runs = Runs { runs: Vec::new(), last_row: 0, reach };
    for y in 0..labels.height() {
        runs.add_row(y, labels.row(y), mask.row(y));
    }
    runs.pieces(labels.size())
}

/// Pixels of one label side by side.
struct Run<T> {
    label: T,
    y: usize,
    start: usize,
    /// One past the last.
    end: usize,
    /// An earlier run of the same piece, or itself.
    parent: usize,
    touches_other: bool,
}

/// The runs of a picture, in reading order.
struct Runs<T> {
    runs: Vec<Run<T>>,
    /// Where the last row's runs begin.
    last_row: usize,
    /// How far beyond a run's ends the runs of the row above touch it: 1 with corners, else 0.
    reach: usize,
}

impl<T: Copy + PartialEq> Runs<T> {
    fn add_row(&mut self, y: usize, labels: &[T], mask: &[bool]) {
        let (above, here) = (self.last_row, self.runs.len());
        let mut x = 0;
        while x < labels.len() {
            if !mask[x] {
                x += 1;
                continue;
            }
            let (start, label) = (x, labels[x]);
            while x < labels.len() && mask[x] && labels[x] == label {
                x += 1;
            }
            let parent = self.runs.len();
            self.runs.push(Run { label, y, start, end: x, parent, touches_other: false });
        }
        self.last_row = here;
        self.join(above, here);
    }

    /// Joins the runs from `here` on with each other and with those from `above` on.
    fn join(&mut self, above: usize, here: usize) {
        let mut first = above;
        for i in here..self.runs.len() {
            let (start, end) = (self.runs[i].start, self.runs[i].end);
            if i > here && self.runs[i - 1].end == start {
                self.meet(i - 1, i);
            }
            while first < here && self.runs[first].end + self.reach <= start {
                first += 1;
            }
            let mut j = first;
            while j < here && self.runs[j].start < end + self.reach {
                self.meet(j, i);
                j += 1;
            }
        }
    }

    /// Two runs touch: they are of one piece, or each other's other colour.
    fn meet(&mut self, a: usize, b: usize) {
        if self.runs[a].label == self.runs[b].label {
            let (a, b) = (self.root(a), self.root(b));
            self.runs[a.max(b)].parent = a.min(b);
        } else {
            self.runs[a].touches_other = true;
            self.runs[b].touches_other = true;
        }
    }

    fn root(&mut self, mut run: usize) -> usize {
        while self.runs[run].parent != run {
            let up = self.runs[self.runs[run].parent].parent;
            self.runs[run].parent = up;
            run = up;
        }
        run
    }

    /// Numbers the pieces; a piece's earliest run is its root.
    fn pieces(mut self, (width, height): (usize, usize)) -> Components<T> {
        let mut ids = Plane::filled(width, height, UNCOVERED);
        let mut pieces: Vec<Piece<T>> = Vec::new();
        let mut numbers = vec![0u32; self.runs.len()];
        for i in 0..self.runs.len() {
            let root = self.root(i);
            let run = &self.runs[i];
            let at = (run.start, run.y);
            if root == i {
                numbers[i] = pieces.len() as u32;
                let piece =
                    Piece { label: run.label, area: 0, first: at, last: at, touches_other: false };
                pieces.push(piece);
            }
            let id = numbers[root];
            pieces[id as usize].grow(run);
            ids.pixels_mut()[run.y * width + run.start..run.y * width + run.end].fill(id);
        }
        Components { pieces, ids }
    }
}

impl<T> Piece<T> {
    fn grow(&mut self, run: &Run<T>) {
        self.area += run.end - run.start;
        self.first = (self.first.0.min(run.start), self.first.1.min(run.y));
        self.last = (self.last.0.max(run.end - 1), self.last.1.max(run.y));
        self.touches_other |= run.touches_other;
    }
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
    fn by_sides_corners_separate() {
        let (labels, mask) = drawn(&["a.a.", ".a..", ". bb"]);
        let found = components_by_sides(&labels, &mask);
        let seen: Vec<(char, usize)> = found.pieces.iter().map(|p| (p.label, p.area)).collect();
        assert_eq!(seen, [('a', 1), ('.', 1), ('a', 1), ('.', 3), ('.', 2), ('a', 1), ('b', 2)]);
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
