//! Connected pieces of a label image.
//!
//! A piece is a set of covered pixels of one label, connected through their eight neighbours. Ids
//! count in reading order of each piece's first pixel. One pass joins runs of equal pixels by
//! union-find; time is linear, memory one id a pixel.

use crate::Plane;

/// The pieces of a label image.
#[derive(Clone, Debug)]
pub struct Components {
    /// The piece of each covered pixel.
    pub ids: Plane<Option<u32>>,
    /// The pieces by id.
    pub pieces: Vec<Piece>,
}

/// One piece.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Piece {
    /// Its pixels.
    pub area: usize,
    /// Its first pixel in reading order.
    pub first: (usize, usize),
    /// Least x and y, and greatest x and y, both included.
    pub bounds: [(usize, usize); 2],
    /// Whether a covered pixel of another label is among its pixels' eight neighbours: a piece that
    /// touches no other label is no island.
    pub touches_other: bool,
}

/// The pieces of equal `labels` among covered pixels. Panics when the sizes differ.
pub fn components<T: PartialEq>(labels: &Plane<T>, mask: &Plane<bool>) -> Components {
    assert_eq!(labels.size(), mask.size(), "labels and mask are of one picture");
    let roots = join(labels, mask);
    let (w, h) = labels.size();
    let mut ids = Plane::filled(w, h, None);
    let mut pieces: Vec<Piece> = Vec::new();
    let mut id_of_root = vec![u32::MAX; w * h];
    for y in 0..h {
        for x in 0..w {
            if !mask[(x, y)] {
                continue;
            }
            let id = &mut id_of_root[roots[y * w + x] as usize];
            if *id == u32::MAX {
                *id = pieces.len() as u32;
                let bounds = [(x, y); 2];
                pieces.push(Piece { area: 0, first: (x, y), bounds, touches_other: false });
            }
            pieces[*id as usize].take(x, y);
            ids[(x, y)] = Some(*id);
        }
    }
    let mut components = Components { ids, pieces };
    for (a, b) in components.touching() {
        components.pieces[a].touches_other = true;
        components.pieces[b].touches_other = true;
    }
    components
}

impl Piece {
    fn take(&mut self, x: usize, y: usize) {
        let [low, high] = &mut self.bounds;
        *low = (low.0.min(x), low.1.min(y));
        *high = (high.0.max(x), high.1.max(y));
        self.area += 1;
    }
}

/// Neighbours after a pixel in reading order.
const AFTER: [(isize, isize); 4] = [(1, 0), (-1, 1), (0, 1), (1, 1)];

impl Components {
    /// Pairs of pieces that touch, the lower id first, each once, sorted.
    pub fn touching(&self) -> Vec<(usize, usize)> {
        let (w, h) = self.ids.size();
        let mut pairs = Vec::new();
        for y in 0..h {
            for x in 0..w {
                let Some(a) = self.ids[(x, y)] else { continue };
                for (dx, dy) in AFTER {
                    if let Some(Some(b)) = self.ids.at(x as isize + dx, y as isize + dy)
                        && a != *b
                        && pairs.last() != Some(&(a.min(*b) as usize, a.max(*b) as usize))
                    {
                        pairs.push((a.min(*b) as usize, a.max(*b) as usize));
                    }
                }
            }
        }
        pairs.sort_unstable();
        pairs.dedup();
        pairs
    }
}

/// For each pixel the root of its piece in a union-find forest.
fn join<T: PartialEq>(labels: &Plane<T>, mask: &Plane<bool>) -> Vec<u32> {
    let (w, h) = labels.size();
    let mut parent: Vec<u32> = (0..(w * h) as u32).collect();
    for y in 0..h {
        for x in 0..w {
            if !mask[(x, y)] {
                continue;
            }
            for (dx, dy) in AFTER {
                let (u, v) = (x as isize + dx, y as isize + dy);
                if mask.at(u, v) == Some(&true) && labels.at(u, v) == Some(&labels[(x, y)]) {
                    unite(&mut parent, (y * w + x) as u32, (v as usize * w + u as usize) as u32);
                }
            }
        }
    }
    (0..(w * h) as u32).map(|i| root(&mut parent, i)).collect()
}

fn unite(parent: &mut [u32], a: u32, b: u32) {
    let (a, b) = (root(parent, a), root(parent, b));
    parent[a.max(b) as usize] = a.min(b);
}

fn root(parent: &mut [u32], mut i: u32) -> u32 {
    while parent[i as usize] != i {
        parent[i as usize] = parent[parent[i as usize] as usize];
        i = parent[i as usize];
    }
    i
}

#[cfg(test)]
mod tests {
    use super::*;

    fn picture(rows: &[&str]) -> (Plane<u8>, Plane<bool>) {
        let (w, h) = (rows[0].len(), rows.len());
        let labels = Plane::from_fn(w, h, |x, y| rows[y].as_bytes()[x]);
        let mask = labels.map(|&c| c != b' ');
        (labels, mask)
    }

    #[test]
    fn pieces_connect_through_corners() {
        let (labels, mask) = picture(&["#..", ".#.", "..#"]);
        let c = components(&labels, &mask);
        assert_eq!(c.pieces.iter().map(|p| p.area).collect::<Vec<_>>(), [3, 6]);
        assert_eq!(c.touching(), [(0, 1)]);
    }

    #[test]
    fn a_piece_alone_touches_nothing() {
        let (labels, mask) = picture(&["## ..", "## #.", "     "]);
        let c = components(&labels, &mask);
        assert_eq!(c.pieces.len(), 3);
        assert!(!c.pieces[0].touches_other);
        assert!(c.pieces[1].touches_other && c.pieces[2].touches_other);
        assert_eq!(c.pieces[1].bounds, [(3, 0), (4, 1)]);
    }
}
