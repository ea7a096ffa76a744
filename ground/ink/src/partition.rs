//! A label image as regions whose borders are shared curves.
//!
//! 1. A crack is the unit segment between two pixels of different label, the frame of the picture
//!    among them. Where two labels meet crosswise, the rarer one near by is joined across the corner,
//!    so that thin slanted regions stay whole. Other corners of pixels where other than two cracks
//!    meet, and the four corners of the frame, are nodes.
//! 2. Cracks between nodes, or once round, make chains. A chain's points lie where its cracks'
//!    pixel pairs cross from one label to the other; a node's point is the mean of those around it.
//!    Between corners of pixels the points stay in cells of their own, so that no two chains cross.
//! 3. Every chain is fitted once ([`fit`](crate::fit())). The two regions beside it use the very
//!    same curves, one of them backwards: borders never gap nor overlap.
//! 4. Walking round each region (connected by sides, and by corners where joined) gives its rings: the
//!    outline and the holes.

use crate::fit::{Fit, fit};
use crate::{Path, Point};
use chiaro_basis::Sets;
use chiaro_image::Plane;
use chiaro_image::labels::{Components, Piece, components_by_sides};
use std::collections::HashMap;

/// Regions and the borders that they share.
#[derive(Clone, Debug)]
pub struct Partition {
    /// Each border once.
    borders: Vec<Path>,
    /// The labels to the right and to the left of each border; `None` outside the picture.
    sides: Vec<[Option<u8>; 2]>,
    /// The regions, in the reading order of their first pixels.
    pub regions: Vec<Region>,
}

/// Connected pixels of one label.
#[derive(Clone, Debug, PartialEq)]
pub struct Region {
    /// Its label.
    pub label: u8,
    /// Its pixels.
    pub area: usize,
    /// Its outline and its holes: borders by number, in order, and whether they run backwards.
    rings: Vec<Vec<(usize, bool)>>,
}

impl Partition {
    /// Traces the borders of `labels`. `crossing(p, q)` says how far from the centre of pixel p to
    /// that of its neighbour q the label changes, in (0, 1).
    pub fn trace(labels: &Plane<u8>, crossing: impl Fn(Pixel, Pixel) -> f64, how: &Fit) -> Self {
        let cracks = Cracks { labels };
        let chains = Chains::walk(&cracks);
        let nodes = NodePoints { cracks: &cracks, crossing: &crossing };
        let borders = chains.list.iter().map(|c| nodes.path(c, how)).collect();
        let sides = chains.list.iter().map(|c| cracks.beside(c)).collect();
        let pieces = components_by_sides(labels, &labels.map(|_| true));
        let (numbers, mut regions) = joined_pieces(&pieces, &cracks);
        for ring in chains.rings(&cracks) {
            regions[numbers[pieces.ids[ring.inside] as usize]].rings.push(ring.borders);
        }
        Self { borders, sides, regions }
    }

    /// The outline and the holes of a region, closed, the region on their right.
    pub fn outline(&self, region: &Region) -> Vec<Path> {
        region.rings.iter().map(|ring| self.ring(ring)).collect()
    }

    fn ring(&self, ring: &[(usize, bool)]) -> Path {
        let border = |&(i, back): &(usize, bool)| match back {
            true => self.borders[i].reversed(),
            false => self.borders[i].clone(),
        };
        let mut path = border(&ring[0]);
        ring[1..].iter().for_each(|b| path.extend(&border(b)));
        path.closed = true;
        path
    }

    /// The borders between two labels, each once, with the labels to the right and to the left;
    /// those along the picture's frame are not among them.
    pub fn shared(&self) -> impl Iterator<Item = (&Path, [u8; 2])> {
        let both = |(path, sides): (_, &[Option<u8>; 2])| Some((path, [sides[0]?, sides[1]?]));
        self.borders.iter().zip(&self.sides).filter_map(both)
    }
}

type Pixel = (usize, usize);
/// A corner of pixels: x in 0..=width, y in 0..=height.
type Corner = (usize, usize);

/// Directions in clockwise order, y down: east, south, west, north.
const STEPS: [(isize, isize); 4] = [(1, 0), (0, 1), (-1, 0), (0, -1)];

/// The number of the region that each piece belongs to, and the regions without their rings.
fn joined_pieces(pieces: &Components<u8>, cracks: &Cracks) -> (Vec<usize>, Vec<Region>) {
    let mut sets = Sets::new(pieces.pieces.len());
    let (w, h) = cracks.labels.size();
    for (x, y) in (1..h).flat_map(|y| (1..w).map(move |x| (x, y))) {
        let Some(label) = cracks.joined((x, y)) else { continue };
        let is = cracks.labels[(x, y)] == label;
        let ends = if is { [(x, y), (x - 1, y - 1)] } else { [(x - 1, y), (x, y - 1)] };
        let [a, b] = ends.map(|p| pieces.ids[p] as usize);
        sets.join(a, b);
    }
    let mut regions: Vec<Region> = Vec::new();
    let mut numbers = vec![0; sets.len()];
    for (i, Piece { label, area, .. }) in pieces.pieces.iter().enumerate() {
        let first = sets.root(i);
        if first == i {
            numbers[i] = regions.len();
            regions.push(Region { label: *label, area: 0, rings: Vec::new() });
        }
        numbers[i] = numbers[first];
        regions[numbers[i]].area += area;
    }
    (numbers, regions)
}

struct Cracks<'a> {
    labels: &'a Plane<u8>,
}

/// How far from a corner the rarer label is looked for, in pixels.
const NEAR: usize = 3;

impl Cracks<'_> {
    /// The pixels to the right and to the left of the crack that leaves `corner` in a direction.
    fn sides(&self, (x, y): Corner, direction: usize) -> [Option<Pixel>; 2] {
        let inside = |u: usize, v: usize| {
            let (w, h) = self.labels.size();
            // One less than 0 wraps to a number that is not inside.
            (u < w && v < h).then_some((u, v))
        };
        let (left, up) = (x.wrapping_sub(1), y.wrapping_sub(1));
        match direction {
            0 => [inside(x, y), inside(x, up)],
            1 => [inside(left, y), inside(x, y)],
            2 => [inside(left, up), inside(left, y)],
            _ => [inside(x, up), inside(left, up)],
        }
    }

    /// Whether a crack leaves `corner` in this direction.
    fn is_crack(&self, corner: Corner, direction: usize) -> bool {
        let [right, left] = self.sides(corner, direction).map(|p| p.map(|p| self.labels[p]));
        right != left
    }

    fn degree(&self, corner: Corner) -> usize {
        (0..4).filter(|d| self.is_crack(corner, *d)).count()
    }

    fn is_node(&self, corner: Corner) -> bool {
        let (w, h) = self.labels.size();
        let frame_corner = (corner.0 == 0 || corner.0 == w) && (corner.1 == 0 || corner.1 == h);
        let passed = matches!(self.degree(corner), 0 | 2) || self.joined(corner).is_some();
        frame_corner || !passed
    }

    /// Where two labels meet crosswise, the one that is joined across the corner: the rarer one near
    /// by, of equals the lower.
    fn joined(&self, (x, y): Corner) -> Option<u8> {
        let (w, h) = self.labels.size();
        if x == 0 || y == 0 || x == w || y == h {
            return None;
        }
        let [a, b] = [(x - 1, y - 1), (x, y - 1)].map(|p| self.labels[p]);
        if a == b || self.labels[(x, y)] != a || self.labels[(x - 1, y)] != b {
            return None;
        }
        let mut counts = [0, 0];
        for v in y.saturating_sub(NEAR)..(y + NEAR).min(h) {
            for label in &self.labels.row(v)[x.saturating_sub(NEAR)..(x + NEAR).min(w)] {
                counts[0] += usize::from(*label == a);
                counts[1] += usize::from(*label == b);
            }
        }
        [(counts[0], a), (counts[1], b)].into_iter().min().map(|(_, label)| label)
    }

    /// The labels to the right and to the left of a chain.
    fn beside(&self, chain: &Chain) -> [Option<u8>; 2] {
        let sides = self.sides(chain.start, usize::from(chain.directions[0]));
        sides.map(|p| p.map(|p| self.labels[p]))
    }

    fn next(&self, (x, y): Corner, direction: usize) -> Corner {
        let (dx, dy) = STEPS[direction];
        (x.wrapping_add_signed(dx), y.wrapping_add_signed(dy))
    }

    /// Where the walk round the pixel on the right goes on after arriving at `corner`: the sharpest
    /// turn to the right that is a crack; to the left where the pixel is joined across the corner.
    fn onward(&self, corner: Corner, direction: usize) -> usize {
        let mut turns = [direction + 1, direction, direction + 3].map(|d| d % 4);
        let from = self.next(corner, (direction + 2) % 4);
        let right = || self.sides(from, direction)[0].map(|p| self.labels[p]);
        if self.joined(corner).is_some_and(|label| right() == Some(label)) {
            turns.reverse();
        }
        turns.into_iter().find(|d| self.is_crack(corner, *d)).unwrap_or((direction + 2) % 4)
    }
}

/// A run of cracks: where it starts, and the direction of each.
struct Chain {
    start: Corner,
    directions: Vec<u8>,
    closed: bool,
}

struct Chains {
    list: Vec<Chain>,
    /// The chain that leaves a node in a direction, and whether backwards.
    leaving: HashMap<(Corner, usize), (usize, bool)>,
}

/// A ring of borders and a pixel on its right.
struct Ring {
    borders: Vec<(usize, bool)>,
    inside: Pixel,
}

impl Chains {
    fn walk(cracks: &Cracks) -> Self {
        let (w, h) = cracks.labels.size();
        let mut chains = Self { list: Vec::new(), leaving: HashMap::new() };
        // Cracks already walked, to the east and to the south of each corner.
        let mut done = Plane::filled(w + 1, h + 1, [false; 2]);
        for only_nodes in [true, false] {
            for y in 0..=h {
                for x in 0..=w {
                    if !only_nodes || cracks.is_node((x, y)) {
                        for d in 0..4 {
                            chains.follow(cracks, (x, y), d, &mut done);
                        }
                    }
                }
            }
        }
        chains
    }

    /// Follows the crack from `start` to the next node, or once round.
    fn follow(&mut self, cracks: &Cracks, start: Corner, d: usize, done: &mut Plane<[bool; 2]>) {
        if !cracks.is_crack(start, d) || *mark(done, cracks, start, d) {
            return;
        }
        let (mut at, mut direction) = (start, d);
        let mut directions = Vec::new();
        loop {
            *mark(done, cracks, at, direction) = true;
            directions.push(direction as u8);
            at = cracks.next(at, direction);
            if cracks.is_node(at) {
                break;
            }
            let onward = cracks.onward(at, direction);
            // A corner that is joined across is passed twice.
            if (at, onward) == (start, d) {
                break;
            }
            direction = onward;
        }
        let closed = !cracks.is_node(start);
        if !closed {
            self.leaving.insert((start, d), (self.list.len(), false));
            self.leaving.insert((at, (direction + 2) % 4), (self.list.len(), true));
        }
        self.list.push(Chain { start, directions, closed });
    }

    /// All rings that have a pixel of the picture on their right.
    fn rings(&self, cracks: &Cracks) -> Vec<Ring> {
        let mut walked = vec![[false; 2]; self.list.len()];
        let mut rings = Vec::new();
        for (i, chain) in self.list.iter().enumerate() {
            for back in [false, true] {
                let [right, left] = cracks.sides(chain.start, usize::from(chain.directions[0]));
                let Some(inside) = (if back { left } else { right }) else { continue };
                if !walked[i][usize::from(back)] {
                    rings.push(Ring { borders: self.ring(cracks, (i, back), &mut walked), inside });
                }
            }
        }
        rings
    }

    fn ring(
        &self,
        cracks: &Cracks,
        first: (usize, bool),
        walked: &mut [[bool; 2]],
    ) -> Vec<(usize, bool)> {
        let mut ring = Vec::new();
        let mut border = first;
        loop {
            walked[border.0][usize::from(border.1)] = true;
            ring.push(border);
            if self.list[border.0].closed {
                return ring;
            }
            let (node, direction) = self.arrival(cracks, border);
            border = self.leaving[&(node, cracks.onward(node, direction))];
            if border == first {
                return ring;
            }
        }
    }

    /// The node at which a chain ends, and in which direction it gets there.
    fn arrival(&self, cracks: &Cracks, (i, back): (usize, bool)) -> (Corner, usize) {
        let chain = &self.list[i];
        if back {
            return (chain.start, (usize::from(chain.directions[0]) + 2) % 4);
        }
        let last = usize::from(chain.directions[chain.directions.len() - 1]);
        let end =
            chain.directions.iter().fold(chain.start, |at, d| cracks.next(at, usize::from(*d)));
        (end, last)
    }
}

/// Whether the crack in a direction was walked, kept at its western or northern corner.
fn mark<'a>(
    done: &'a mut Plane<[bool; 2]>,
    cracks: &Cracks,
    corner: Corner,
    direction: usize,
) -> &'a mut bool {
    let from = if direction < 2 { corner } else { cracks.next(corner, direction) };
    &mut done[from][direction % 2]
}

/// Points of chains and nodes.
struct NodePoints<'a, F> {
    cracks: &'a Cracks<'a>,
    crossing: &'a F,
}

impl<F: Fn(Pixel, Pixel) -> f64> NodePoints<'_, F> {
    fn path(&self, chain: &Chain, how: &Fit) -> Path {
        let mut at = chain.start;
        let mut points = Vec::with_capacity(chain.directions.len() + 2);
        if !chain.closed {
            points.push(self.node(at));
        }
        for &d in &chain.directions {
            points.push(self.crack(at, usize::from(d)));
            at = self.cracks.next(at, usize::from(d));
        }
        if !chain.closed {
            points.push(self.node(at));
        }
        let straight = self.is_frame(chain);
        let path = if straight {
            Path::through(&[points[0], points[points.len() - 1]], false)
        } else {
            fit(&points, chain.closed, how)
        };
        path.expect("a chain has points")
    }

    fn is_frame(&self, chain: &Chain) -> bool {
        let sides = self.cracks.sides(chain.start, usize::from(chain.directions[0]));
        !chain.closed && sides.contains(&None)
    }

    /// Where the label changes across a crack; on the frame, the crack's middle.
    fn crack(&self, corner: Corner, direction: usize) -> Point {
        let centre = |(x, y): Pixel| [x as f64 + 0.5, y as f64 + 0.5];
        match self.cracks.sides(corner, direction) {
            [Some(p), Some(q)] => {
                let (a, b, t) = (centre(p), centre(q), (self.crossing)(p, q));
                std::array::from_fn(|i| a[i] + t * (b[i] - a[i]))
            }
            _ => {
                let next = self.cracks.next(corner, direction);
                [0.5 * (corner.0 + next.0) as f64, 0.5 * (corner.1 + next.1) as f64]
            }
        }
    }

    /// The mean of the crossings around a node; on the frame it stays on the frame, and in its
    /// corners it stays.
    fn node(&self, corner: Corner) -> Point {
        let (w, h) = self.cracks.labels.size();
        let fixed = [corner.0 == 0 || corner.0 == w, corner.1 == 0 || corner.1 == h];
        let inner = (0..4).filter(|&d| {
            self.cracks.is_crack(corner, d) && !self.cracks.sides(corner, d).contains(&None)
        });
        let points: Vec<Point> = inner.map(|d| self.crack(corner, d)).collect();
        let exact = [corner.0 as f64, corner.1 as f64];
        std::array::from_fn(|i| {
            if fixed[i] || points.is_empty() {
                return exact[i];
            }
            points.iter().map(|p| p[i]).sum::<f64>() / points.len() as f64
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const EXACT: Fit = Fit { tolerance: 1e-6, corner: 9.0, blur: 1.0, rounds: 0 };

    fn drawn(rows: &[&str]) -> Plane<u8> {
        Plane::from_fn(rows[0].len(), rows.len(), |x, y| rows[y].as_bytes()[x])
    }

    fn area(path: &Path) -> f64 {
        let p = path.points(1e-3);
        0.5 * p.windows(2).map(|w| w[0][0] * w[1][1] - w[1][0] * w[0][1]).sum::<f64>()
    }

    #[test]
    fn every_region_is_one_outline_with_its_holes() {
        let labels =
            drawn(&["........", ".####...", ".#..#.b.", ".#..#.b.", ".####...", "........"]);
        let partition = Partition::trace(&labels, |_, _| 0.5, &EXACT);
        let rings: Vec<usize> = partition.regions.iter().map(|r| r.rings.len()).collect();
        assert_eq!(rings, [3, 2, 1, 1]);
        assert_eq!(partition.regions[1].area, 12);
        let signed: Vec<bool> =
            partition.outline(&partition.regions[1]).iter().map(|p| area(p) > 0.0).collect();
        assert_eq!(signed, [true, false]);
    }

    #[test]
    fn the_regions_of_noise_cover_the_picture_exactly_once() {
        for (w, h) in [(1, 1), (1, 40), (37, 23)] {
            let noise =
                |x: usize, y: usize| (chiaro_basis::random::hash(3, (y * w + x) as u64) % 3) as u8;
            let labels = Plane::from_fn(w, h, noise);
            let partition = Partition::trace(&labels, |_, _| 0.5, &EXACT);
            let areas = partition.regions.iter().flat_map(|r| partition.outline(r));
            let sum: f64 = areas.map(|p| area(&p)).sum();
            assert!((sum - (w * h) as f64).abs() < 1e-6 * sum.max(1.0), "{w} x {h}: {sum}");
        }
    }

    #[test]
    fn thin_slanted_regions_stay_whole() {
        let line = |x: usize, y: usize, slope: usize| y == 3 + slope * x / 2;
        for slope in [1, 2] {
            for label in [0, 1] {
                let labels =
                    Plane::from_fn(24, 30, |x, y| if line(x, y, slope) { label } else { 2 });
                let partition = Partition::trace(&labels, |_, _| 0.5, &EXACT);
                assert_eq!(partition.regions.len(), 3, "slope {slope}");
                let ring =
                    partition.regions.iter().find(|r| r.label == label).map(|r| r.rings.len());
                assert_eq!(ring, Some(1));
            }
        }
        // A ring of eight pixels that touch by corners alone is one region around a hole.
        let ring = drawn(&["......", "..##..", ".#..#.", ".#..#.", "..##..", "......"]);
        let partition = Partition::trace(&ring, |_, _| 0.5, &EXACT);
        let rings: Vec<usize> = partition.regions.iter().map(|r| r.rings.len()).collect();
        assert_eq!(rings, [2, 2, 1]);
        assert_eq!(partition.regions[1].area, 8);
    }

    #[test]
    fn neighbours_share_the_same_curve() {
        let labels = Plane::from_fn(30, 30, |x, y| u8::from((x * x + y * y) > 400));
        let how = Fit { tolerance: 0.1, corner: 0.7, blur: 1.0, rounds: 0 };
        let partition = Partition::trace(&labels, |_, _| 0.5, &how);
        let [a, b] = [0, 1].map(|i| partition.outline(&partition.regions[i]).remove(0));
        let curves =
            |p: &Path| p.segments.iter().filter(|s| matches!(s, crate::Segment::Cubic(..))).count();
        assert!(curves(&a) > 0 && curves(&a) == curves(&b));
        assert!((area(&a) + area(&b) - 900.0).abs() < 1e-6);
    }
}
