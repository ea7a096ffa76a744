//! Round borders: labels near their borders cut again with sixteen neighbours.
//!
//! Where nothing guides a border, lengths by eight neighbours, up to 8 % apart from one direction to
//! another, draw it in facets of 45 degrees: a highlight on a sphere becomes an octagon. Sixteen, with
//! the knight's moves, are within 2.8 % of each other.
//!
//! 1. What lies within some pixels of a border that no feature guides is free; the rest stands, and
//!    becomes part of the prices of what is free.
//! 2. The links of the graph are shared out among sixteen by the formula of Cauchy and Crofton
//!    (Boykov and Kolmogorov 2003), so that lengths keep their mean; a knight's move, which passes
//!    between two pixels, is as strong as the stronger of the two ways around.
//! 3. The free pixels are cut exactly; of more than two labels each pair that meets is, in order.
//!
//! Guaranteed: no label farther than the reach from a border changes, and none for two labels if the
//! labels given are the best by sixteen neighbours already. Not guaranteed: the least energy by
//! sixteen neighbours over the whole picture, nor that by eight, which rises a little. Pictures of
//! more than `PART` pixels are cut in parts, side by side, and then again along the seams, so that
//! memory stays under some 130 bytes for each pixel of a part and thread.

use crate::knob::{BinaryKnobs, scaled};
use crate::mend::Costs;
use crate::window::widen_line;
use chiaro_basis::{Error, Result};
use chiaro_image::Plane;
use chiaro_mincut::{LINK_STEPS, Lattice, Links, Neighbours, Solver};
use rayon::prelude::*;
use std::borrow::Cow;
use std::collections::BTreeSet;
use std::f32::consts::SQRT_2;
use std::ops::Range;

/// Pixels that are cut together at most.
const PART: usize = 1 << 19;
/// A bond under this share of the largest is a feature.
const FEATURE: f32 = 0.5;
/// How far from a seam of parts labels are found again, in reaches.
const SEAM: usize = 3;
/// The farthest reach, in pixels: facets of large prints are rounded as far as that goes.
const FARTHEST: f32 = 24.0;

/// Of a link's capacity among eight, what it keeps among sixteen: straight ones and diagonal ones;
/// and the share of a straight one that a knight's move has.
const STRAIGHT: f32 = 0.590_3;
const DIAGONAL: f32 = 0.409_7;
const KNIGHT: f32 = 0.223_6;

/// The two steps of each knight's move, in either order.
const WAYS: [[(isize, isize); 2]; 4] =
    [[(1, 0), (1, 1)], [(0, 1), (1, 1)], [(0, 1), (-1, 1)], [(-1, 0), (-1, 1)]];

type Pixel = (usize, usize);

/// How far from a border labels are found again, in whole pixels; 0: nowhere.
pub(crate) fn reach(knobs: &BinaryKnobs, height: usize) -> usize {
    if knobs.round <= 0.0 {
        return 0;
    }
    scaled(knobs.round, height).clamp(2.0, FARTHEST.max(knobs.round)).round() as usize
}

impl Costs<'_> {
    /// Labels near those given that cost least by sixteen neighbours.
    pub(crate) fn rounded(&self, labels: &Plane<u8>, reach: usize) -> Result<Plane<u8>> {
        self.rounded_in_parts(labels, reach, PART)
    }

    fn rounded_in_parts(&self, labels: &Plane<u8>, reach: usize, most: usize) -> Result<Plane<u8>> {
        let mut labels = labels.clone();
        if reach == 0 {
            return Ok(labels);
        }
        let near = self.near_borders(&labels, reach);
        for pass in parts(labels.size(), most, SEAM * reach) {
            let found: Vec<Result<Vec<(Pixel, u8)>>> =
                pass.into_par_iter().map(|rows| self.part(&labels, &near, &rows)).collect();
            for changes in found {
                changes?.into_iter().for_each(|(p, label)| labels[p] = label);
            }
        }
        Ok(labels)
    }

    /// The labels of the free pixels of some rows, all others as given.
    fn part(
        &self,
        labels: &Plane<u8>,
        near: &Plane<bool>,
        rows: &Range<usize>,
    ) -> Result<Vec<(Pixel, u8)>> {
        let mut labels = Cow::Borrowed(labels);
        let pairs = self.pairs(&labels, rows);
        let mut changes = Vec::new();
        for pair in &pairs {
            let free = |p: Pixel| rows.contains(&p.1) && near[p] && pair.contains(&labels[p]);
            let Some(swap) = Swap::new(*self, &labels, *pair, rows, &free) else { continue };
            let found = swap.solve()?;
            let label = |i: usize| pair[usize::from(found[i])];
            let first = changes.len();
            changes.extend(swap.each().filter(|(_, i)| swap.free[*i]).map(|(p, i)| (p, label(i))));
            // The next pair begins with these.
            if pairs.len() > 1 {
                let labels = labels.to_mut();
                changes[first..].iter().for_each(|(p, label)| labels[*p] = *label);
            }
        }
        Ok(changes)
    }

    /// The nodes within some pixels of a border off features, in a square.
    fn near_borders(&self, labels: &Plane<u8>, reach: usize) -> Plane<bool> {
        let (w, h) = labels.size();
        let largest = self.neighbour.pixels().par_iter().map(|bonds| bonds[0].max(bonds[2])).max();
        let free = FEATURE * largest.unwrap_or(0) as f32;
        let differs = |p: Pixel, q: Pixel, link: usize| {
            let met = q.0 < w && q.1 < h && labels[p] != labels[q] && self.mask[p] && self.mask[q];
            met && self.neighbour[p][link] as f32 >= free
        };
        let border = |x, y| differs((x, y), (x + 1, y), 0) || differs((x, y), (x, y + 1), 2);
        let mut near = Plane::from_fn(w, h, border).into_pixels();
        near.chunks_mut(w.max(1)).for_each(|row| widen_line(row, 0, 1, w, reach));
        (0..w).for_each(|x| widen_line(&mut near, x, w, h, reach));
        near.iter_mut().zip(self.mask.pixels()).for_each(|(near, mask)| *near &= mask);
        Plane::from_pixels(w, h, near)
    }

    /// The pairs of labels that meet in some rows, ascending.
    fn pairs(&self, labels: &Plane<u8>, rows: &Range<usize>) -> Vec<[u8; 2]> {
        if self.count == 2 {
            return vec![[0, 1]];
        }
        let mut met = BTreeSet::new();
        for p in rows.clone().flat_map(|y| (0..labels.width()).map(move |x| (x, y))) {
            for q in [(1, 0), (0, 1)].into_iter().filter_map(|s| self.step(p, s)) {
                let (a, b) = (labels[p], labels[q]);
                if a != b && self.mask[p] {
                    met.insert([a.min(b), a.max(b)]);
                }
            }
        }
        met.into_iter().collect()
    }

    /// The capacity of a pixel's link among sixteen, by [`LINK_STEPS`].
    fn link(&self, p: Pixel, link: usize) -> i32 {
        let share = |capacity: i32, share: f32| nearest(capacity as f32 * share);
        match link {
            0 | 2 => share(self.neighbour[p][link], STRAIGHT),
            1 | 3 => share(self.neighbour[p][link], DIAGONAL),
            knight => nearest(self.passage(p, WAYS[knight - 4]) * KNIGHT),
        }
    }

    /// The capacities of a pixel's links among sixteen, by [`LINK_STEPS`].
    fn links(&self, p: Pixel) -> [i32; 8] {
        self.links_inside(p).unwrap_or_else(|| std::array::from_fn(|link| self.link(p, link)))
    }

    /// The same where all that they depend on are nodes, without looking again for each.
    fn links_inside(&self, (x, y): Pixel) -> Option<[i32; 8]> {
        let (w, h) = self.mask.size();
        if x < 2 || x + 2 >= w || y + 2 >= h {
            return None;
        }
        let rows: [&[bool]; 3] = std::array::from_fn(|j| &self.mask.row(y + j)[x - 2..x + 3]);
        if !rows[0][1..4].iter().chain(rows[1]).chain(&rows[2][1..4]).all(|node| *node) {
            return None;
        }
        let (here, below) = (self.neighbour.row(y), self.neighbour.row(y + 1));
        let [east, south_east, south, south_west] = here[x];
        let straight = |capacity: i32| capacity as f32;
        let diagonal = |capacity: i32| SQRT_2 * capacity as f32;
        let way = |a: f32, b: f32, c: f32, d: f32| nearest(f32::max(a.min(b), c.min(d)) * KNIGHT);
        let share = |capacity: i32, share: f32| nearest(capacity as f32 * share);
        let (se, sw) = (diagonal(south_east), diagonal(south_west));
        let (s, after_s) = (straight(south), below[x]);
        let (after_se, after_sw, after_w) = (below[x + 1], below[x - 1], here[x - 1]);
        Some([
            share(east, STRAIGHT),
            share(south_east, DIAGONAL),
            share(south, STRAIGHT),
            share(south_west, DIAGONAL),
            way(straight(east), diagonal(here[x + 1][1]), se, straight(after_se[0])),
            way(s, diagonal(after_s[1]), se, straight(after_se[2])),
            way(s, diagonal(after_s[3]), sw, straight(after_sw[2])),
            way(straight(after_w[0]), diagonal(after_w[3]), sw, straight(below[x - 2][0])),
        ])
    }

    /// How strong the stronger of the two ways of a knight's move is, as a straight link: a way of a
    /// straight step and a diagonal one is as strong as the weaker.
    fn passage(&self, p: Pixel, [straight, diagonal]: [(isize, isize); 2]) -> f32 {
        let way = |first, second| {
            let middle = self.step(p, first)?;
            Some(self.bond(p, first)?.min(self.bond(middle, second)?))
        };
        let ways = [way(straight, diagonal), way(diagonal, straight)];
        ways.into_iter().flatten().fold(0.0, f32::max)
    }

    /// The node a step from a pixel.
    fn step(&self, (x, y): Pixel, (dx, dy): (isize, isize)) -> Option<Pixel> {
        let q = (x.checked_add_signed(dx)?, y.checked_add_signed(dy)?);
        (q.0 < self.mask.width() && q.1 < self.mask.height() && self.mask[q]).then_some(q)
    }

    /// The capacity of a step between nodes, of a diagonal one as if it were straight.
    fn bond(&self, p: Pixel, step: (isize, isize)) -> Option<f32> {
        let q = self.step(p, step)?;
        Some(match step {
            (1, 0) => self.neighbour[p][0] as f32,
            (1, 1) => SQRT_2 * self.neighbour[p][1] as f32,
            (0, 1) => self.neighbour[p][2] as f32,
            (-1, 1) => SQRT_2 * self.neighbour[p][3] as f32,
            _ => self.neighbour[q][0] as f32,
        })
    }
}

/// The whole number nearest to a positive one, as `round` says, which not every processor has an
/// instruction for.
fn nearest(value: f32) -> i32 {
    let whole = value as i32;
    whole + i32::from(value - whole as f32 >= 0.5)
}

/// Rows that are cut together, pass by pass: all, or parts of a large picture and then what is
/// within some pixels of their seams.
fn parts((w, h): (usize, usize), most: usize, seam: usize) -> Vec<Vec<Range<usize>>> {
    if w * h <= most {
        return vec![std::iter::once(0..h).collect()];
    }
    let rows = (most / w).max(2);
    let seam = seam.min(rows / 2);
    let starts = || (0..h).step_by(rows);
    let pieces = starts().map(|y| y..(y + rows).min(h)).collect();
    let seams = starts().skip(1).map(|y| y - seam..(y + seam).min(h)).collect();
    vec![pieces, seams]
}

/// Two labels to be exchanged among the free pixels of a box.
struct Swap<'a> {
    costs: Costs<'a>,
    pair: [u8; 2],
    /// The upper left pixel of the box, and its size.
    first: Pixel,
    size: (usize, usize),
    /// By pixels of the box.
    free: Vec<bool>,
    terminal: Vec<[i32; 2]>,
    links: Vec<[i32; 8]>,
}

impl<'a> Swap<'a> {
    /// The box of what is free in some rows; `None` if nothing is.
    fn new(
        costs: Costs<'a>,
        labels: &Plane<u8>,
        pair: [u8; 2],
        rows: &Range<usize>,
        free: &dyn Fn(Pixel) -> bool,
    ) -> Option<Self> {
        let w = labels.width();
        let all = rows.clone().flat_map(|y| (0..w).map(move |x| (x, y)));
        let mut corners: Option<(Pixel, Pixel)> = None;
        for p in all.filter(|p| free(*p)) {
            let (low, high) = corners.get_or_insert((p, p));
            (*low, *high) = ((low.0.min(p.0), low.1), (high.0.max(p.0), p.1));
        }
        let (first, last) = corners?;
        let size = (last.0 - first.0 + 1, last.1 - first.1 + 1);
        let count = size.0 * size.1;
        let mut swap = Self {
            costs,
            pair,
            first,
            size,
            free: Vec::new(),
            terminal: vec![[0; 2]; count],
            links: vec![[0; 8]; count],
        };
        swap.free = swap.each().map(|(p, _)| free(p)).collect();
        let pixels: Vec<(Pixel, usize)> = swap.each().filter(|(_, i)| swap.free[*i]).collect();
        for (p, i) in pixels {
            swap.links[i] = costs.links(p);
            swap.terminal[i] = swap.prices(p, swap.links[i], labels);
        }
        Some(swap)
    }

    /// The pixels of the box with their places in it.
    fn each(&self) -> impl Iterator<Item = (Pixel, usize)> + use<> {
        let (first, (w, h)) = (self.first, self.size);
        (0..h).flat_map(move |j| (0..w).map(move |i| ((first.0 + i, first.1 + j), j * w + i)))
    }

    fn is_free(&self, p: Pixel) -> bool {
        let (x, y) = (p.0.wrapping_sub(self.first.0), p.1.wrapping_sub(self.first.1));
        x < self.size.0 && y < self.size.1 && self.free[y * self.size.0 + x]
    }

    /// What a pixel pays for the first label and for the second, with the bonds to what stands.
    fn prices(&self, p: Pixel, links: [i32; 8], labels: &Plane<u8>) -> [i32; 2] {
        let costs = &self.costs;
        let own = (p.1 * labels.width() + p.0) * costs.count;
        let mut prices = self.pair.map(|label| costs.prices[own + usize::from(label)]);
        let mut pull = |q: Option<Pixel>, link: &dyn Fn(Pixel) -> i32| {
            let Some(q) = q.filter(|q| !self.is_free(*q)) else { return };
            for (price, label) in prices.iter_mut().zip(self.pair) {
                *price += link(q) * costs.apart(label, labels[q]);
            }
        };
        for (e, (dx, dy)) in LINK_STEPS.into_iter().enumerate() {
            pull(costs.step(p, (dx, dy)), &|_| links[e]);
            pull(costs.step(p, (-dx, -dy)), &|q| costs.link(q, e));
        }
        let least = prices[0].min(prices[1]);
        prices.map(|price| price - least)
    }

    /// Which pixels of the box take the second label.
    fn solve(&self) -> Result<Vec<bool>> {
        let apart = self.costs.apart(self.pair[0], self.pair[1]);
        let links = match apart {
            1 => Cow::Borrowed(&self.links),
            _ => Cow::Owned(self.links.iter().map(|l| l.map(|c| c * apart)).collect()),
        };
        let lattice = Lattice {
            width: self.size.0,
            height: self.size.1,
            frames: 1,
            mask: &self.free,
            terminal: &self.terminal,
            neighbours: Neighbours::Sixteen(Links::Symmetric(&links)),
            time: &[],
            fixed: &[],
        };
        let solver = Solver::new(&lattice)
            .map_err(|e| Error::setting("round", e, "weights that the cut can add up"))?;
        Ok(solver.labels().to_vec())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn links_are_the_same_found_one_by_one_or_together() {
        let (w, h) = (17, 13);
        let noise = |s: u64, x: usize, y: usize| chiaro_basis::random::unit(s, (y * w + x) as u64);
        let mask = Plane::from_fn(w, h, |x, y| noise(1, x, y) > 0.04);
        let neighbour = Plane::from_fn(w, h, |x, y| {
            std::array::from_fn(|e| (9000.0 * noise(2 + e as u64, x, y)) as i32)
        });
        let prices = vec![0; 2 * w * h];
        let costs =
            Costs { mask: &mask, count: 2, prices: &prices, neighbour: &neighbour, by_step: false };
        let nodes = (0..h).flat_map(|y| (0..w).map(move |x| (x, y))).filter(|p| mask[*p]);
        let mut inside = 0;
        for p in nodes {
            let Some(links) = costs.links_inside(p) else { continue };
            assert_eq!(links, std::array::from_fn(|link| costs.link(p, link)), "{p:?}");
            inside += 1;
        }
        assert!(inside > 20, "{inside}");
    }
    use crate::cut::Graph;

    /// A picture of even bonds, by the wish for white of each pixel.
    fn graph(side: usize, neighbour: f32, wish: impl Fn(usize, usize) -> f32 + Sync) -> Graph {
        let mask = Plane::filled(side, side, true);
        let knobs = BinaryKnobs { neighbour, ..BinaryKnobs::default() };
        let factors = Plane::filled(side, side, [1.0; 4]);
        Graph::new(&mask, &Plane::from_fn(side, side, wish), &factors, &knobs)
    }

    fn round(graph: &Graph, labels: &Plane<u8>, reach: usize, most: usize) -> Plane<u8> {
        let prices = graph.terminal.pixels().as_flattened();
        graph.costs(prices, 2).rounded_in_parts(labels, reach, most).unwrap()
    }

    #[test]
    fn lengths_of_lines_hardly_depend_on_their_angle() {
        let graph = graph(9, 1.0, |_, _| 0.0);
        let prices = graph.terminal.pixels().as_flattened();
        let costs = graph.costs(prices, 2);
        let among = |count: usize, angle: f32| -> f32 {
            let (s, c) = angle.sin_cos();
            let cost = |link: usize| match count {
                4 => graph.neighbour[(4, 4)][link],
                _ => costs.link((4, 4), link),
            };
            let crossed = |link: usize| {
                let (dx, dy) = LINK_STEPS[link];
                cost(link) as f32 * (dx as f32 * c + dy as f32 * s).abs()
            };
            (0..count).map(crossed).sum()
        };
        let spread = |count: usize| {
            let lengths: Vec<f32> =
                (0..360).map(|d| among(count, (d as f32).to_radians())).collect();
            let (low, high) =
                lengths.iter().fold((f32::MAX, 0.0f32), |(l, h), x| (l.min(*x), h.max(*x)));
            (high / low, lengths.iter().sum::<f32>())
        };
        let ((eight, mean8), (sixteen, mean16)) = (spread(4), spread(8));
        assert!((1.08..1.09).contains(&eight) && sixteen < 1.03, "{eight} {sixteen}");
        assert!((mean16 / mean8 - 1.0).abs() < 0.005, "lengths keep their mean: {mean8} {mean16}");
    }

    #[test]
    fn corners_that_nothing_guides_are_round() {
        // A square of weak white with a bound core. Corners are arcs of the radius at which the
        // length of the border is worth the tone: 2.546 bonds a pixel, the mean over all angles.
        let (side, inset, pull) = (128, 8, 0.0055);
        let far = |x: usize| x < inset || x >= side - inset;
        let core = |x: usize, y: usize| (x as f32 - 63.5).hypot(y as f32 - 63.5) < 45.0;
        let wish = |x: usize, y: usize| match (far(x) || far(y), core(x, y)) {
            (true, _) => -4.0,
            (_, true) => 4.0,
            _ => pull,
        };
        let graph = graph(side, 0.06 * 480.0 / side as f32, wish);
        let radius = 2.546 * 0.06 / pull;
        let cut = graph.solve().unwrap().white.map(|w| u8::from(*w));
        let round = round(&graph, &cut, 6, PART);
        let centre = inset as f32 + radius;
        let off = |labels: &Plane<u8>| {
            let distance = |degrees: usize| {
                let (s, c) = (degrees as f32).to_radians().sin_cos();
                let at = |r: f32| ((centre - r * c) as usize, (centre - r * s) as usize);
                let white = (0..900).map(|i| i as f32 * 0.05).take_while(|r| labels[at(*r)] == 1);
                (white.last().unwrap_or(0.0) - radius).abs()
            };
            (4..87).map(distance).sum::<f32>() / 83.0
        };
        let (before, after) = (off(&cut), off(&round));
        assert!(after < 0.7 && after < 0.7 * before, "{before} to {after} px off");
    }

    #[test]
    fn what_is_far_from_a_border_stays_and_parts_agree_with_the_whole() {
        let noise =
            |x: usize, y: usize| ((x * 7919 + y * 104_729 + x * y * 31) % 97) as f32 / 400.0 - 0.12;
        let graph = graph(70, 1.5, |x, y| noise(x / 3, y / 3) + if x < 30 { 0.1 } else { -0.1 });
        let cut = graph.solve().unwrap().white.map(|w| u8::from(*w));
        let whole = round(&graph, &cut, 3, PART);
        let prices = graph.terminal.pixels().as_flattened();
        let near = graph.costs(prices, 2).near_borders(&cut, 3);
        for (i, (a, b)) in cut.pixels().iter().zip(whole.pixels()).enumerate() {
            assert!(a == b || near.pixels()[i]);
        }
        let parted = round(&graph, &cut, 3, 70 * 24);
        let differ = parted.pixels().iter().zip(whole.pixels()).filter(|(a, b)| a != b).count();
        assert!(differ < 20, "{differ}");
        assert_eq!(round(&graph, &cut, 0, PART), cut);
    }

    #[test]
    fn a_palette_is_rounded_as_each_of_its_pairs_is() {
        // On the left black on white, on the right white on black; of three labels they are 0 on 1 and
        // 2 on 1, far from each other.
        let noise = |x: usize, y: usize| ((x / 3 * 7919 + y / 3 * 104_729) % 97) as f32 / 400.0;
        let left = |x: usize, y: usize| if x < 28 { noise(x, y) - 0.1 } else { 4.0 };
        let right = |x: usize, y: usize| if x >= 42 { noise(x, y) - 0.1 } else { -4.0 };
        let graphs = [graph(70, 1.5, left), graph(70, 1.5, right)];
        let cut = |g: &Graph| g.solve().unwrap().white.map(|w| u8::from(*w));
        let both = |labels: [Plane<u8>; 2]| {
            Plane::from_fn(70, 70, |x, y| match x < 35 {
                true => labels[0][(x, y)],
                false => 1 + labels[1][(x, y)],
            })
        };
        let cuts = [cut(&graphs[0]), cut(&graphs[1])];
        let pairs = [0, 1].map(|i| round(&graphs[i], &cuts[i], 3, PART));
        assert!(pairs != cuts, "there is something to round");
        let dear = 1 << 17;
        let mut prices = Vec::new();
        for p in (0..70 * 70).map(|i| (i % 70, i / 70)) {
            let [black, white] = graphs[usize::from(p.0 >= 35)].terminal[p];
            prices.extend(if p.0 < 35 { [black, white, dear] } else { [dear, black, white] });
        }
        let expected = both(pairs);
        for by_step in [false, true] {
            let costs = Costs { by_step, ..graphs[0].costs(&prices, 3) };
            assert_eq!(costs.rounded(&both(cuts.clone()), 3).unwrap(), expected);
        }
    }
}
