//! Cut, then solve: links that contradict each other are found by a stiff robust solve and dropped.
//!
//! 1. A guess: line by line through time, arc length moved to the median of what its links say.
//! 2. With textures nearly rigid, links are trusted by 1 / (1 + (r / s)^2)^2 of their residual r, s
//!    falling from 200 to 8 pixels. Where merges and loops ask for two values of one place, the
//!    lesser side gives way.
//!    Where lines grow, as in zooms, rigid textures fall behind by more the longer they are: that much of the
//!    slope of r along a line is no contradiction, and left out.
//! 3. Runs of links from one line to another, parted where the residual leaps by more than the sliding limit
//!    sigma, are cut if their median exceeds sigma, and single links over three times that: of a line that
//!    is asked to be at two places one half may be had.
//!
//! What is left agrees, so that plain least squares at any weight has no reason to fold.
//!
//! Parts of the film that nothing joins go their own ways: a scale at which all of a part's links would be
//! trusted is left out, and a part whose links agreed keeps its parameters when others are cut.

use super::energy::{Energy, Factors, Weights};
use super::failed;
use super::grow::Growth;
use super::net::Net;
use chiaro_basis::{Result, Run};
use std::collections::BTreeMap;

/// Scales of the robust weights, pixels.
pub(crate) const ANNEAL: [f64; 4] = [200.0, 50.0, 12.0, 8.0];
/// The same where most contradictions are cut already.
pub(crate) const AGAIN: [f64; 3] = [100.0, 25.0, 8.0];
/// w_proj of the stiff solve.
const STIFF: f64 = 1e-3;
/// Residuals below this share of a scale leave links trusted, by 0.89 at least.
const TRUSTED: f64 = 0.25;
/// Single links go beyond this many sliding limits.
const SINGLE: f64 = 3.0;

/// Links that stay, and how often each goes round.
pub(crate) struct Kept {
    /// 1 for links that stay, 0 for those that were cut.
    pub(crate) trust: Vec<f64>,
    /// What is added to each link's right side, in units of u.
    pub(crate) wraps: Vec<f64>,
    /// How many were cut.
    pub(crate) cut: usize,
    /// Their length in pixels.
    pub(crate) cut_length: f64,
    /// What each link's two ends disagree by, in pixels, where textures are nearly rigid.
    pub(crate) residual: Vec<f64>,
    /// Parameters where textures are nearly rigid.
    pub(crate) u: Vec<f64>,
}

/// How links are judged.
pub(crate) struct Robust<'a> {
    pub(crate) weights: Weights,
    /// Scales of the robust weights, falling.
    pub(crate) anneal: &'a [f64],
    /// How far links may disagree, pixels.
    pub(crate) sigma: f64,
    pub(crate) run: &'a Run,
}

impl Robust<'_> {
    /// Finds the links that agree. `period` is that of each closed line without a seam; `before`, what
    /// was found before lines were cut.
    pub(crate) fn agreeing(
        &self,
        net: &Net,
        energy: &Energy,
        scale: &[f64],
        period: &[Option<f64>],
        before: Option<(&Energy, &Kept)>,
    ) -> Result<Kept> {
        let stiff = vec![1.0; energy.stretches.len()];
        let weights = Weights { projection: STIFF, ..self.weights };
        let mut u = guess(net, scale, period);
        let done = before
            .map(|(e, kept)| energy.unchanged(e, (&kept.u, &kept.residual), self.sigma, &mut u));
        let done = done.unwrap_or_else(|| vec![false; energy.parts()]);
        let mut wraps = wraps(net, energy, period, &u);
        let growth = Growth::of(net);
        let left = |u: &[f64], wraps: &[f64]| -> Vec<f64> {
            growth.left_out((0..net.links.len()).map(|i| energy.residual(i, u, wraps[i])).collect())
        };
        let mut residual = left(&u, &wraps);
        // Scales below this change a part.
        let mut reach: Vec<f64> =
            done.iter().map(|done| if *done { 0.0 } else { f64::INFINITY }).collect();
        for &s in self.anneal {
            self.run.check()?;
            let which: Vec<bool> = reach.iter().map(|reach| s < *reach).collect();
            if !which.contains(&true) {
                continue;
            }
            let trust: Vec<f64> =
                residual.iter().map(|r| (1.0 + (r / s).powi(2)).powi(-2)).collect();
            let by = Factors { stiff: &stiff, trust: &trust, wraps: &wraps };
            energy.solve_some(&weights, &by, &which, &mut u).map_err(failed)?;
            let turned = self::wraps(net, energy, period, &u);
            let now = left(&u, &turned);
            for (part, reach) in reach.iter_mut().enumerate().filter(|(p, _)| which[*p]) {
                let most = energy.links_of(part).map(|i| now[i].abs()).fold(0.0, f64::max);
                *reach = match energy.links_of(part).any(|i| turned[i] != wraps[i]) {
                    true => f64::INFINITY,
                    false => most / TRUSTED,
                };
            }
            (wraps, residual) = (turned, now);
        }
        let trust = trusted(net, &residual, self.sigma);
        let cut = || net.links.iter().zip(&trust).filter(|(_, t)| **t == 0.0);
        let (count, cut_length) = (cut().count(), cut().map(|(l, _)| l.weight).sum());
        Ok(Kept { trust, wraps, cut: count, cut_length, residual, u })
    }
}

/// 1 for links that agree by their residuals in pixels, 0 for those that do not.
pub(crate) fn trusted(net: &Net, residual: &[f64], sigma: f64) -> Vec<f64> {
    let mut runs = Vec::with_capacity(residual.len());
    let mut run = [0; 2];
    for (i, (link, r)) in net.links.iter().zip(residual).enumerate() {
        let goes_on =
            i > 0 && net.links[i - 1].lines == link.lines && (residual[i - 1] - r).abs() <= sigma;
        run = if goes_on { run } else { [i as u32, 0] };
        runs.push(run);
    }
    let median = medians(runs.iter().copied().zip(residual.iter().map(|r| r.abs())));
    let agrees = |(run, r): (&[u32; 2], &f64)| r.abs() <= SINGLE * sigma && median[run] <= sigma;
    runs.iter().zip(residual).map(|l| if agrees(l) { 1.0 } else { 0.0 }).collect()
}

/// The median of each bundle's numbers, by what it joins.
pub(crate) fn medians(all: impl Iterator<Item = ([u32; 2], f64)>) -> BTreeMap<[u32; 2], f64> {
    let mut bundles: BTreeMap<[u32; 2], Vec<f64>> = BTreeMap::new();
    all.for_each(|(ends, number)| bundles.entry(ends).or_default().push(number));
    let middle = |(ends, mut numbers): ([u32; 2], Vec<f64>)| {
        numbers.sort_unstable_by(f64::total_cmp);
        (ends, numbers[numbers.len() / 2])
    };
    bundles.into_iter().map(middle).collect()
}

/// How often each link goes round the closed line at one of its ends.
pub(crate) fn wraps(net: &Net, energy: &Energy, period: &[Option<f64>], u: &[f64]) -> Vec<f64> {
    net.links
        .iter()
        .enumerate()
        .map(|(i, link)| {
            let [from, to] = link.lines.map(|l| period[l as usize]);
            let Some(p) = to.or(from) else { return 0.0 };
            let seam = link.wrap(0.0, to);
            let turns = ((energy.difference(i, u) - seam) / p).round();
            seam + turns * p
        })
        .collect()
}

/// Arc length along every line, moved to what the median of its links from the frame before says.
pub(crate) fn guess(net: &Net, scale: &[f64], period: &[Option<f64>]) -> Vec<f64> {
    let mut incoming: Vec<Vec<u32>> = vec![Vec::new(); net.lines.len()];
    for (i, link) in net.links.iter().enumerate() {
        incoming[link.lines[1] as usize].push(i as u32);
    }
    let mut u = vec![0.0; net.unknowns];
    for (l, line) in net.lines.iter().enumerate() {
        let own = match period[l] {
            Some(p) if line.total() > 0.0 => p / line.total(),
            _ => 1.0 / scale[l],
        };
        let mut offsets: Vec<f64> = incoming[l]
            .iter()
            .map(|&i| {
                let link = &net.links[i as usize];
                let k = (link.to[0] - line.first) as usize;
                let s = line.length[k] + (line.length[k + 1] - line.length[k]) * link.share;
                let offset = u[link.from as usize] - s * own;
                // Whole turns are no offset.
                period[l].map_or(offset, |p| offset - (offset / p).round() * p)
            })
            .collect();
        offsets.sort_unstable_by(f64::total_cmp);
        let offset = offsets.get(offsets.len() / 2).copied().unwrap_or(0.0);
        for k in 0..line.count as usize {
            u[line.first as usize + k] = offset + own * line.length[k];
        }
    }
    u
}

/// Nothing is cut.
pub(crate) fn all(net: &Net, energy: &Energy, scale: &[f64], period: &[Option<f64>]) -> Kept {
    let u = guess(net, scale, period);
    let wraps = wraps(net, energy, period, &u);
    let trust = vec![1.0; net.links.len()];
    let residual = vec![0.0; net.links.len()];
    Kept { trust, wraps, cut: 0, cut_length: 0.0, residual, u }
}

#[cfg(test)]
mod tests {
    use super::super::net::Link;
    use super::*;

    #[test]
    fn of_a_line_that_is_asked_to_be_at_two_places_one_half_is_trusted() {
        let link = |from: u32| Link {
            from,
            to: [20 + from, 21 + from],
            share: 0.0,
            around: false,
            lines: [0, 1],
            weight: 3.0,
        };
        let links: Vec<Link> = (0..9).map(link).collect();
        let net = Net { lines: Vec::new(), frames: Vec::new(), links, unknowns: 30 };
        let halves: Vec<f64> = (0..9).map(|k| if k < 6 { 12.0 } else { -2.0 }).collect();
        assert_eq!(trusted(&net, &halves, 8.0), [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0]);
        // What stretches by and by is one run.
        let slope: Vec<f64> = (0..9).map(|k| 3.0 * f64::from(k) - 12.0).collect();
        assert_eq!(trusted(&net, &slope, 8.0), [1.0; 9]);
    }
}
