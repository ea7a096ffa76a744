//! [`Nearest`]: the nearest of many centres, exactly.
//!
//! 1. Centres lie in groups around pivots. A query measures its distance to all pivots first, and
//!    visits the groups from the nearest pivot outwards.
//! 2. A group is left out when its pivot is farther than its radius and the best distance so far:
//!    by the triangle inequality nothing in it can be nearer. Distances are computed with a relative error
//!    under (dimensions + 2) 2^-23, so the test leaves a margin of 1e-5 for up to 80 dimensions.
//! 3. Inside a group, sixteen centres are measured side by side, the coordinates that vary most
//!    first; the rest is left out when all are already too far. Partial sums of squares only
//!    grow, in floating point too, so this needs no margin.
//!
//! Guaranteed: the centre with the least computed distance, and of equal ones the lowest index, as
//! if all were compared in order; the same bits for any number of threads.

use pulp::Arch;

/// Centres measured side by side.
const LANES: usize = 16;
/// Coordinates after which a block may be given up.
const STEP: usize = 9;
/// What rounding may add to a distance, relative.
const MARGIN: f32 = 1e-5;
/// Below this many centres all are compared.
const FEW: usize = 64;

/// Centres side by side, coordinate by coordinate.
type Lanes = [f32; LANES];

/// Centres, ready to be searched.
#[derive(Clone, Debug)]
pub struct Nearest {
    dim: usize,
    count: usize,
    /// Coordinates, those that vary most first.
    order: Vec<usize>,
    groups: Vec<Group>,
    /// Pivots in blocks, coordinate by coordinate.
    pivots: Vec<Lanes>,
    /// Centres in blocks, group by group.
    blocks: Vec<Lanes>,
    /// The index of each lane; `u32::MAX` where there is none.
    names: Vec<[u32; LANES]>,
    /// Where a centre lies: the lanes of the blocks before, plus its lane.
    places: Vec<u32>,
    arch: Arch,
}

/// Centres around a pivot.
#[derive(Clone, Copy, Debug)]
struct Group {
    /// The farthest centre's distance.
    radius: f32,
    first: u32,
    blocks: u32,
}

/// A centre that was found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Found {
    /// Its index.
    pub index: u32,
    /// The squared distance.
    pub square: f32,
}

/// Memory that searches use again and again.
#[derive(Clone, Debug, Default)]
pub struct Scratch {
    query: Vec<f32>,
    pivots: Vec<(f32, u32)>,
}

impl Nearest {
    /// The index of centres, `dim` finite coordinates each, one after the other.
    pub fn new(centres: &[f32], dim: usize) -> Self {
        let count = centres.len() / dim;
        let order = by_spread(centres, dim);
        let turned: Vec<f32> =
            centres.chunks_exact(dim).flat_map(|c| order.iter().map(|i| c[*i])).collect();
        let row = |i: usize| &turned[i * dim..(i + 1) * dim];
        let pivots = pivots(&turned, dim);
        let mut members: Vec<(Vec<u32>, f32)> = vec![(Vec::new(), 0.0); pivots.len() / dim];
        for i in 0..count {
            let distance = |p: &[f32]| square(row(i), p);
            let (mut best, mut least) = (0, f32::INFINITY);
            for (k, p) in pivots.chunks_exact(dim).enumerate() {
                let d = distance(p);
                if d < least {
                    (best, least) = (k, d);
                }
            }
            members[best].0.push(i as u32);
            members[best].1 = members[best].1.max(least.sqrt());
        }
        let mut all = Self {
            dim,
            count,
            order,
            groups: Vec::new(),
            pivots: in_blocks(&pivots.chunks_exact(dim).collect::<Vec<_>>(), dim),
            blocks: Vec::new(),
            names: Vec::new(),
            places: vec![0; count],
            arch: Arch::new(),
        };
        for (group, radius) in members {
            let first = all.names.len() as u32;
            let rows: Vec<&[f32]> = group.iter().map(|i| row(*i as usize)).collect();
            all.blocks.extend(in_blocks(&rows, dim));
            for (block, names) in group.chunks(LANES).enumerate() {
                let mut padded = [u32::MAX; LANES];
                padded[..names.len()].copy_from_slice(names);
                all.names.push(padded);
                for (lane, name) in names.iter().enumerate() {
                    all.places[*name as usize] = ((first as usize + block) * LANES + lane) as u32;
                }
            }
            let blocks = all.names.len() as u32 - first;
            all.groups.push(Group { radius, first, blocks });
        }
        all
    }

    /// Centres.
    pub fn len(&self) -> usize {
        self.count
    }

    /// Whether there is no centre.
    pub fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// The nearest centre of a query of finite coordinates. `hint` is a centre that may be near: a
    /// good one saves time and changes nothing. `None` when there is no centre.
    pub fn find(&self, query: &[f32], hint: Option<u32>, scratch: &mut Scratch) -> Option<Found> {
        if self.count == 0 {
            return None;
        }
        scratch.query.clear();
        scratch.query.extend(self.order.iter().map(|i| query[*i]));
        let search = Search { all: self, hint, scratch };
        Some(self.arch.dispatch(search))
    }
}

/// One search, compiled for the widest vectors that the machine has.
struct Search<'a> {
    all: &'a Nearest,
    hint: Option<u32>,
    scratch: &'a mut Scratch,
}

impl pulp::NullaryFnOnce for Search<'_> {
    type Output = Found;

    #[inline(always)]
    fn call(self) -> Found {
        let Self { all, hint, scratch } = self;
        let mut best = Found { index: u32::MAX, square: f32::INFINITY };
        let query = &scratch.query[..];
        if let Some(hint) = hint {
            let place = all.places[hint as usize] as usize;
            let distances = all.measure(place / LANES, query, f32::INFINITY);
            best = Found { index: hint, square: distances[place % LANES] };
        }
        scratch.pivots.clear();
        for (block, first) in (0..all.groups.len()).step_by(LANES).enumerate() {
            let rows = &all.pivots[block * all.dim..(block + 1) * all.dim];
            let distances = measured(rows, query, f32::INFINITY);
            for (lane, square) in distances.iter().enumerate().take(all.groups.len() - first) {
                let index = (first + lane) as u32;
                let radius = all.groups[index as usize].radius;
                // How near its nearest centre may be.
                let near = square.sqrt() * (1.0 - MARGIN) - radius * (1.0 + MARGIN);
                if near.max(0.0) * near.max(0.0) * (1.0 - 3.0 * MARGIN) <= best.square {
                    scratch.pivots.push((*square, index));
                }
            }
        }
        if scratch.pivots.len() > 1 {
            scratch.pivots.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        }
        for &(square, index) in &scratch.pivots {
            let group = all.groups[index as usize];
            let near = (square.sqrt() * (1.0 - MARGIN) - group.radius * (1.0 + MARGIN)).max(0.0);
            if near * near * (1.0 - 3.0 * MARGIN) > best.square {
                continue;
            }
            for block in group.first..group.first + group.blocks {
                let distances = all.measure(block as usize, query, best.square);
                let names = &all.names[block as usize];
                for lane in 0..LANES {
                    let found = Found { index: names[lane], square: distances[lane] };
                    if found.square < best.square
                        || (found.square == best.square && found.index < best.index)
                    {
                        best = found;
                    }
                }
            }
        }
        best
    }
}

impl Nearest {
    /// Squared distances to the centres of a block; infinite when all exceed `limit`.
    #[inline(always)]
    fn measure(&self, block: usize, query: &[f32], limit: f32) -> Lanes {
        measured(&self.blocks[block * self.dim..(block + 1) * self.dim], query, limit)
    }
}

#[inline(always)]
fn measured(rows: &[Lanes], query: &[f32], limit: f32) -> Lanes {
    let mut sum = [0.0; LANES];
    for (rows, query) in rows.chunks(STEP).zip(query.chunks(STEP)) {
        for (row, q) in rows.iter().zip(query) {
            for lane in 0..LANES {
                let d = row[lane] - q;
                sum[lane] += d * d;
            }
        }
        // Counted rather than asked one by one: that takes one comparison of vectors.
        if sum.iter().map(|s| i32::from(*s <= limit)).sum::<i32>() == 0 {
            return [f32::INFINITY; LANES];
        }
    }
    sum
}

/// The squared distance, coordinates in order.
fn square(a: &[f32], b: &[f32]) -> f32 {
    a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum()
}

/// Rows side by side; lanes without a row are infinitely far.
fn in_blocks(rows: &[&[f32]], dim: usize) -> Vec<Lanes> {
    let lanes = |rows: &[&[f32]], d: usize| {
        std::array::from_fn(|lane| rows.get(lane).map_or(f32::INFINITY, |r| r[d]))
    };
    rows.chunks(LANES).flat_map(|rows| (0..dim).map(|d| lanes(rows, d))).collect()
}

/// Coordinates by falling variance.
fn by_spread(centres: &[f32], dim: usize) -> Vec<usize> {
    let count = (centres.len() / dim).max(1) as f64;
    let spread = |d: usize| {
        let values = || centres.iter().skip(d).step_by(dim).map(|v| f64::from(*v));
        let mean = values().sum::<f64>() / count;
        values().map(|v| (v - mean) * (v - mean)).sum::<f64>()
    };
    let mut order: Vec<(f64, usize)> = (0..dim).map(|d| (spread(d), d)).collect();
    order.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
    order.into_iter().map(|(_, d)| d).collect()
}

/// Pivots that are far from each other, moved once to the mean of what is nearest to them; one for
/// few centres.
fn pivots(centres: &[f32], dim: usize) -> Vec<f32> {
    let count = centres.len() / dim;
    if count <= FEW {
        return centres[..dim * count.min(1)].to_vec();
    }
    let wanted = (1.5 * (count as f64).sqrt()) as usize;
    let row = |i: usize| &centres[i * dim..(i + 1) * dim];
    let mut chosen = row(0).to_vec();
    let mut nearest: Vec<(f32, usize)> = (0..count).map(|i| (square(row(i), row(0)), 0)).collect();
    for k in 1..wanted {
        // Spread evenly over what is there, as far as can be without chance.
        let (far, _) = nearest
            .iter()
            .enumerate()
            .fold((0, -1.0), |best, (i, (d, _))| if *d > best.1 { (i, *d) } else { best });
        let pivot = row(far).to_vec();
        for (i, near) in nearest.iter_mut().enumerate() {
            let d = square(row(i), &pivot);
            if d < near.0 {
                *near = (d, k);
            }
        }
        chosen.extend(pivot);
    }
    let mut sums = vec![0.0f64; chosen.len()];
    let mut counts = vec![0u32; wanted];
    for (i, (_, k)) in nearest.iter().enumerate() {
        counts[*k] += 1;
        row(i).iter().enumerate().for_each(|(d, v)| sums[k * dim + d] += f64::from(*v));
    }
    for (i, sum) in sums.iter().enumerate().filter(|(i, _)| counts[i / dim] > 0) {
        chosen[i] = (sum / f64::from(counts[i / dim])) as f32;
    }
    chosen
}

#[cfg(test)]
mod tests {
    use super::*;
    use chiaro_basis::random::unit;

    /// Points of which many coincide or are equally far from others.
    fn clustered(count: usize, dim: usize, seed: u64) -> Vec<f32> {
        (0..count * dim)
            .map(|i| {
                let (row, d) = (i / dim, i % dim);
                let coarse = unit(seed, ((row % 37) * dim + d) as u64);
                let fine = (8.0 * unit(seed + 1, i as u64)).floor() / 64.0;
                if row % 11 == 0 { (4.0 * coarse).floor() } else { coarse + fine }
            })
            .collect()
    }

    fn slow(centres: &[f32], order: &[usize], query: &[f32]) -> Found {
        let mut best = Found { index: u32::MAX, square: f32::INFINITY };
        for (index, c) in centres.chunks_exact(query.len()).enumerate() {
            let square = order.iter().map(|d| (c[*d] - query[*d]).powi(2)).sum();
            if square < best.square {
                best = Found { index: index as u32, square };
            }
        }
        best
    }

    #[test]
    fn the_nearest_centre_is_that_of_the_slow_search_bit_by_bit() {
        for (count, dim) in [(1, 3), (7, 5), (64, 27), (65, 1), (1000, 27), (3000, 9)] {
            let centres = clustered(count, dim, 3);
            let all = Nearest::new(&centres, dim);
            let mut scratch = Scratch::default();
            for (i, query) in clustered(300, dim, 4).chunks_exact(dim).enumerate() {
                let expected = slow(&centres, &all.order, query);
                let hint = (i % 3 == 0).then_some((i * 7 % count) as u32);
                assert_eq!(all.find(query, hint, &mut scratch), Some(expected), "{count} {i}");
            }
        }
        assert_eq!(Nearest::new(&[], 3).find(&[0.0; 3], None, &mut Scratch::default()), None);
    }

    #[test]
    fn of_equal_centres_the_first_is_found() {
        let centres: Vec<f32> = (0..200).flat_map(|i| [(i % 10) as f32, 0.0]).collect();
        let all = Nearest::new(&centres, 2);
        for hint in [None, Some(193), Some(3)] {
            let found = all.find(&[3.2, 0.5], hint, &mut Scratch::default());
            assert_eq!(found.map(|f| f.index), Some(3));
        }
    }
}
