//! Textures never run backwards: what a solution folds is mended.
//!
//! First by weights: where some fold, they and those that nearly do become stiffer and the links on them weaker, and
//! the film is solved again. What is left is the nearest line that rises by a share of its length on every
//! segment (pool adjacent violators, weighted by length), exactly.

use super::energy::{Energy, Factors, Weights};
use super::net::{Line, Net};
use chiaro_basis::isotonic;
use chiaro_solve::Singular;

/// The least slope, relative to an even spread.
const LEAST: f64 = 0.2;
/// The slope below which a segment is mended with those that fold.
const SUSPECT: f64 = 0.1;
/// How often weights are mended.
const ROUNDS: usize = 4;

/// Solves, mends, and says how many segments folded at first.
pub(crate) fn solve(
    net: &Net,
    energy: &Energy,
    weights: &Weights,
    (trust, wraps): (&[f64], &[f64]),
) -> Result<(Vec<f64>, usize), Singular> {
    let mut stiff = vec![1.0; energy.stretches.len()];
    let mut trust = trust.to_vec();
    let mut u = energy.solve(weights, &Factors { stiff: &stiff, trust: &trust, wraps })?;
    let mut folded = 0;
    for round in 0..ROUNDS {
        let slopes = energy.slopes(&u);
        if round == 0 {
            folded = slopes.iter().filter(|s| **s <= 0.0).count();
        }
        let is_bad = |i: &usize| slopes[*i] < SUSPECT;
        let which: Vec<bool> =
            (0..energy.parts()).map(|p| energy.segments_of(p).any(|i| slopes[i] <= 0.0)).collect();
        if !which.contains(&true) {
            break;
        }
        let mut weak = vec![false; net.unknowns];
        for i in (0..slopes.len()).filter(is_bad) {
            stiff[i] *= 8.0;
            energy.stretches[i].unknowns.iter().for_each(|k| weak[*k as usize] = true);
        }
        for (link, t) in net.links.iter().zip(&mut trust) {
            if weak[link.from as usize] || link.to.iter().any(|k| weak[*k as usize]) {
                *t *= 0.25;
            }
        }
        let by = Factors { stiff: &stiff, trust: &trust, wraps };
        energy.solve_some(weights, &by, &which, &mut u)?;
    }
    Ok((u, folded))
}

/// Makes u rise along a line by a share of an even spread at least.
pub(crate) fn rising(line: &Line, u: &mut [f64], scale: f64, period: Option<f64>) {
    let own = &mut u[line.first as usize..(line.first + line.count) as usize];
    let even = match period {
        // What is left between the last sample and the first must rise too.
        Some(p) => (p / line.total()).min(1.0 / scale),
        None => 1.0 / scale,
    };
    let floor: Vec<f64> = line.length[..own.len()].iter().map(|l| LEAST * even * l).collect();
    let folds = |u: &[f64]| (1..u.len()).any(|k| u[k] - u[k - 1] < 0.5 * (floor[k] - floor[k - 1]));
    if !folds(own) && period.is_none_or(|p| own[0] + p > own[own.len() - 1]) {
        return;
    }
    let lifted: Vec<f64> = own.iter().zip(&floor).map(|(u, f)| u - f).collect();
    let pooled = isotonic(lifted.iter().map(|u| (*u, 1.0)));
    own.iter_mut().zip(pooled.iter().zip(&floor)).for_each(|(u, (p, f))| *u = p + f);
    if let Some(p) = period {
        squeeze(own, p, line);
    }
}

/// Brings a closed line that goes more than once round back within its period.
fn squeeze(u: &mut [f64], period: f64, line: &Line) {
    let n = u.len();
    let room = period * line.length[n - 1] / line.total();
    let span = u[n - 1] - u[0];
    if span > room && span > 0.0 {
        let (first, shrink) = (u[0], room / span);
        u.iter_mut().for_each(|x| *x = first + (*x - first) * shrink);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn folds_are_mended_and_the_rest_stays() {
        let length: Vec<f64> = (0..6).map(|i| 3.0 * f64::from(i)).collect();
        let line = Line { frame: 0, first: 0, count: 6, closed: false, length };
        let mut u = vec![0.0, 3.0, 6.0, 5.0, 12.0, 15.0];
        rising(&line, &mut u, 1.0, None);
        assert!(u.windows(2).all(|p| p[1] > p[0]), "{u:?}");
        assert_eq!((u[0], u[1], u[5]), (0.0, 3.0, 15.0));
        let fine = u.clone();
        rising(&line, &mut u, 1.0, None);
        assert_eq!(u, fine);
    }
}
