//! [`k_means`]: few centres that stand for many points (thesis, 6.3.3).
//!
//! 1. Seeds by greedy k-means++ (Arthur and Vassilvitskii 2007): of a few points, drawn with a
//!    probability that grows with the squared distance to the seeds there are, the one that lowers
//!    the error most. For many seeds in two levels: few groups
//!    first, then seeds within each, as many as its share of the error.
//! 2. Rounds of Lloyd (1982): every point goes to its nearest centre, every centre to the mean of
//!    its points. Centres without points start again from the points that are farthest from theirs.
//!
//! It ends when no point changes its centre, or after a number of rounds. Guaranteed: the same bits
//! for any number of threads; equal points count as often as they come. Not guaranteed: the best centres; no
//! method that ends in time gives those.

use crate::nearest::{Nearest, Scratch};
use chiaro_basis::random::{hash, unit};
use chiaro_basis::{Result, Run};
use rayon::prelude::*;

/// More seeds than this are chosen in two levels.
const ONE_LEVEL: usize = 48;

/// Points among which each seed is chosen.
const CANDIDATES: u64 = 3;

/// How centres are sought.
#[derive(Clone, Copy, Debug)]
pub struct KMeans {
    /// Centres wanted; fewer come when there are fewer different points.
    pub count: usize,
    /// Rounds of Lloyd, at most.
    pub rounds: usize,
    /// Of the seeds' choice.
    pub seed: u64,
    /// How the first centres are chosen.
    pub start: Start,
}

/// How the first centres are chosen.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Start {
    /// By greedy k-means++.
    #[default]
    Spread,
    /// Points at random, each at most once.
    Random,
}

/// Centres, and how well they stand for the points.
#[derive(Clone, Debug, Default)]
pub struct Clusters {
    /// One after the other.
    pub centres: Vec<f32>,
    /// The mean squared distance of a point to its centre, before the last move of the centres.
    pub error: f64,
    /// Rounds taken.
    pub rounds: usize,
}

/// Centres of finite points with `dim` coordinates each, one after the other.
pub fn k_means(points: &[f32], dim: usize, how: KMeans, run: &Run) -> Result<Clusters> {
    let all: Vec<u32> = (0..(points.len() / dim) as u32).collect();
    let centres = match how.start {
        Start::Spread => seeds(points, dim, &all, how),
        Start::Random => at_random(points, dim, how),
    };
    let mut clusters = Clusters { centres, ..Clusters::default() };
    let mut nearest: Vec<u32> = Vec::new();
    for _ in 0..how.rounds {
        run.check()?;
        let index = Nearest::new(&clusters.centres, dim);
        let hints = &nearest;
        let found: Vec<(u32, f32)> = points
            .par_chunks_exact(dim)
            .enumerate()
            .map_init(Scratch::default, |scratch, (i, p)| {
                index
                    .find(p, hints.get(i).copied(), scratch)
                    .map_or((0, 0.0), |f| (f.index, f.square))
            })
            .collect();
        let settled = nearest.len() == found.len()
            && nearest.iter().zip(&found).all(|(before, (now, _))| before == now);
        nearest = found.iter().map(|f| f.0).collect();
        clusters.rounds += 1;
        clusters.error = chiaro_basis::reduce::sum(found.len(), |i| f64::from(found[i].1))
            / found.len().max(1) as f64;
        if settled {
            break;
        }
        moved(&mut clusters.centres, points, dim, &found);
    }
    Ok(clusters)
}

/// Moves every centre to the mean of its points, those without points to points that are far from
/// theirs.
fn moved(centres: &mut [f32], points: &[f32], dim: usize, found: &[(u32, f32)]) {
    let count = centres.len() / dim;
    let mut starts = vec![0u32; count + 1];
    found.iter().for_each(|(c, _)| starts[*c as usize + 1] += 1);
    (0..count).for_each(|c| starts[c + 1] += starts[c]);
    let mut fill = starts.clone();
    let mut members = vec![0u32; found.len()];
    for (i, (c, _)) in found.iter().enumerate() {
        members[fill[*c as usize] as usize] = i as u32;
        fill[*c as usize] += 1;
    }
    centres.par_chunks_exact_mut(dim).enumerate().for_each(|(c, centre)| {
        let members = &members[starts[c] as usize..starts[c + 1] as usize];
        if members.is_empty() {
            return;
        }
        let mut sum = vec![0.0f64; dim];
        for i in members {
            let point = &points[*i as usize * dim..(*i as usize + 1) * dim];
            sum.iter_mut().zip(point).for_each(|(s, p)| *s += f64::from(*p));
        }
        let weight = 1.0 / members.len() as f64;
        centre.iter_mut().zip(&sum).for_each(|(c, s)| *c = (s * weight) as f32);
    });
    let empty: Vec<usize> = (0..count).filter(|c| starts[*c] == starts[*c + 1]).collect();
    if empty.is_empty() {
        return;
    }
    let mut far: Vec<(f32, u32)> =
        found.iter().enumerate().filter(|(_, f)| f.1 > 0.0).map(|(i, f)| (f.1, i as u32)).collect();
    far.par_sort_unstable_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
    for (c, (_, i)) in empty.into_iter().zip(far) {
        let i = i as usize;
        centres[c * dim..(c + 1) * dim].copy_from_slice(&points[i * dim..(i + 1) * dim]);
    }
}

/// Some of the points, each at most once.
fn at_random(points: &[f32], dim: usize, how: KMeans) -> Vec<f32> {
    let mut order: Vec<(u64, usize)> =
        (0..points.len() / dim).map(|i| (hash(how.seed, i as u64), i)).collect();
    order.sort_unstable();
    let chosen = order.iter().take(how.count);
    chosen.flat_map(|(_, i)| &points[i * dim..(i + 1) * dim]).copied().collect()
}

/// The first centres, drawn from some of the points.
fn seeds(points: &[f32], dim: usize, some: &[u32], how: KMeans) -> Vec<f32> {
    let row = |i: u32| &points[i as usize * dim..(i as usize + 1) * dim];
    let copied = |chosen: &[u32]| chosen.iter().flat_map(|i| row(*i).to_vec()).collect::<Vec<_>>();
    if how.count <= ONE_LEVEL {
        return copied(&drawn(points, dim, some, how.count, how.seed).0);
    }
    let groups = (how.count as f64).sqrt() as usize;
    let (pivots, nearest) = drawn(points, dim, some, groups, how.seed);
    let mut members: Vec<(Vec<u32>, f64)> = vec![(Vec::new(), 0.0); pivots.len()];
    for (i, (square, group)) in some.iter().zip(&nearest) {
        members[*group as usize].0.push(*i);
        members[*group as usize].1 += f64::from(*square);
    }
    let total: f64 = members.iter().map(|m| m.1).sum();
    let mut left = how.count as f64;
    let mut rest = total;
    let mut parts = Vec::new();
    for (k, (group, error)) in members.iter().enumerate() {
        // The remaining seeds are shared by the remaining error, so that they add up.
        let later = (members.len() - k - 1) as f64;
        let share = if rest > 0.0 { (left * error / rest).round() } else { 1.0 };
        let count = share.clamp(1.0, (left - later).max(1.0)).min(group.len() as f64);
        left -= count;
        rest -= error;
        parts.push((group, count as usize, hash(how.seed, k as u64 + 1)));
    }
    let chosen: Vec<Vec<u32>> = parts
        .into_par_iter()
        .map(|(group, count, seed)| drawn(points, dim, group, count, seed).0)
        .collect();
    copied(&chosen.concat())
}

/// Up to `count` points of `some` by k-means++; of each of `some` the squared distance to the
/// nearest of them, and which that is.
fn drawn(
    points: &[f32],
    dim: usize,
    some: &[u32],
    count: usize,
    seed: u64,
) -> (Vec<u32>, Vec<(f32, u32)>) {
    let row = |i: u32| &points[i as usize * dim..(i as usize + 1) * dim];
    let square =
        |a: &[f32], b: &[f32]| a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum::<f32>();
    let mut nearest = vec![(f32::INFINITY, 0); some.len()];
    let mut chosen: Vec<u32> = Vec::new();
    while chosen.len() < count.min(some.len()) {
        let candidates: Vec<usize> = match chosen.len() as u64 {
            0 => vec![hash(seed, 0) as usize % some.len()],
            n => (0..CANDIDATES)
                .filter_map(|c| by_weight(&nearest, unit(seed, CANDIDATES * n + c)))
                .collect(),
        };
        // What the error would be with each.
        let error = |candidate: usize| {
            let new = row(some[candidate]);
            let left = |i: usize| f64::from(square(row(some[i]), new).min(nearest[i].0));
            chiaro_basis::reduce::sum(some.len(), left)
        };
        let best = candidates.iter().map(|c| (error(*c), *c));
        let Some((_, next)) = best.min_by(|a, b| a.0.total_cmp(&b.0)) else { break };
        let (name, new) = (chosen.len() as u32, row(some[next]));
        nearest.par_iter_mut().with_min_len(1024).zip(some).for_each(|(near, i)| {
            let d = square(row(*i), new);
            if d < near.0 {
                *near = (d, name);
            }
        });
        chosen.push(some[next]);
    }
    (chosen, nearest)
}

/// An index drawn with a probability proportional to its weight; `None` when all are 0.
fn by_weight(weights: &[(f32, u32)], at: f32) -> Option<usize> {
    const CHUNK: usize = 1024;
    let sums: Vec<f64> =
        weights.par_chunks(CHUNK).map(|chunk| chunk.iter().map(|w| f64::from(w.0)).sum()).collect();
    let total: f64 = sums.iter().sum();
    let mut left = total * f64::from(at);
    let chunk = sums.iter().position(|s| {
        let here = left < *s;
        left -= if here { 0.0 } else { *s };
        here
    });
    let first = chunk.or(sums.iter().rposition(|s| *s > 0.0))? * CHUNK;
    let chunk = &weights[first..(first + CHUNK).min(weights.len())];
    let found = chunk.iter().position(|w| {
        let here = left < f64::from(w.0);
        left -= if here { 0.0 } else { f64::from(w.0) };
        here
    });
    found.or(chunk.iter().rposition(|w| w.0 > 0.0)).map(|i| first + i)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Points around corners of a grid.
    fn blobs(count: usize, blobs: usize) -> Vec<f32> {
        (0..count)
            .flat_map(|i| {
                let b = i % blobs;
                let near = |k: u64| 0.1 * (unit(k, i as u64) - 0.5);
                [(b % 10) as f32 + near(1), (b / 10) as f32 + near(2), near(3)]
            })
            .collect()
    }

    #[test]
    fn clusters_that_are_apart_are_found() {
        for blobs_there in [9, 100] {
            let points = blobs(4000, blobs_there);
            let how = KMeans { count: blobs_there, rounds: 30, seed: 7, start: Start::Spread };
            let found = k_means(&points, 3, how, &Run::default()).unwrap();
            assert_eq!(found.centres.len(), 3 * blobs_there);
            // Within a blob the mean square is 3 x 0.1^2 / 12; of many a few share a centre.
            let missed = if blobs_there > 50 { 0.1 } else { 0.0 };
            assert!(found.error < 0.0025 * 1.3 + missed, "{}", found.error);
        }
    }

    #[test]
    fn fewer_different_points_give_fewer_centres_without_error() {
        let points: Vec<f32> = (0..300).map(|i| (i % 5) as f32).collect();
        for count in [20, 200] {
            let how = KMeans { count, rounds: 5, seed: 1, start: Start::Spread };
            let found = k_means(&points, 1, how, &Run::default()).unwrap();
            assert!(found.centres.len() >= 5 && found.error == 0.0, "{found:?}");
        }
        let none = k_means(
            &[],
            3,
            KMeans { count: 4, rounds: 5, seed: 1, start: Start::Spread },
            &Run::default(),
        );
        assert!(none.unwrap().centres.is_empty());
    }

    #[test]
    fn centres_without_points_start_again_where_the_error_is() {
        let points = [0.0f32, 0.1, 5.0, 9.0];
        let mut centres = [0.0f32, 100.0];
        let found: Vec<(u32, f32)> = points.iter().map(|p| (0, p * p)).collect();
        moved(&mut centres, &points, 1, &found);
        assert_eq!(centres, [3.525, 9.0]);
    }

    #[test]
    fn the_centres_have_the_same_bits_for_any_number_of_threads() {
        let points = blobs(3000, 50);
        let on = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            let how = KMeans { count: 120, rounds: 6, seed: 3, start: Start::Spread };
            pool.install(|| k_means(&points, 3, how, &Run::default()).unwrap().centres)
        };
        assert_eq!(on(1), on(4));
    }
}
