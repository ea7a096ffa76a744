//! Plateaus: thresholds that would cut through one flat tone.
//!
//! A flat face in perspective has nearly one tone. A threshold inside it draws a border where there
//! is nothing to see. So the threshold is moved off tones that too much of the picture shares, and
//! off those of *patches*, connected pixels without a feature or a visible gradient between them, as
//! little as possible and as far as the share of black stays near the style's band.
//!
//! The steps of palettes keep off patches too, of those alone whose tones differ little from end to end: slow gradients
//! are what tones are for.
//!
//! Not guaranteed: that no patch is parted. Where every threshold parts one, or all that part none
//! leave the band far, the least evil is taken.

use crate::exposure::{Exposure, mixed_tone};
use crate::knob::{BinaryKnobs, REFERENCE_HEIGHT};
use crate::shade::View;
use crate::terminal::terminal;
use chiaro_image::{Plane, filter};

/// Half the width of tones that count as one.
const HALF_WIDTH: f32 = 0.03;
/// The share of a picture that may lie so close to the threshold for nothing.
const FREE: f32 = 0.2;
/// What more costs, in shares of black outside the band.
const PRICE: f32 = 1.5;
/// What the smaller part of each parted patch costs, in the same.
const PARTED: f32 = 2.0;
/// What moving the threshold by 1 costs, in the same.
const MOVE: f32 = 0.3;

/// Places that a step may take, as shares of a shot, and how many of them lie between two steps.
const PLACES: usize = 100;
const GAP: usize = 4;
/// By how much of a palette's even tone a patch may change from end to end.
const LEVEL: f32 = 1.0;

/// The change of tone from one pixel to the next, at 480, that nobody sees.
const FLAT: f32 = 0.003;
/// The smoothing of tones before they are compared, in pixels, against the noise of few rays.
const NOISE: f32 = 1.5;
/// A factor under which a pair of pixels is a feature.
const FEATURE: f32 = 0.5;
/// The share of a picture from which on a patch counts.
const SMALLEST: f32 = 0.005;

/// The exposure with its threshold moved off plateaus; `factors` are the views' neighbour weights.
pub(crate) fn off_plateaus(
    views: &[View],
    factors: &[Plane<[f32; 4]>],
    exposure: Exposure,
    knobs: &BinaryKnobs,
) -> Exposure {
    let g = knobs.global;
    if g <= 0.0 {
        return exposure;
    }
    // A pixel leans to black where g (T - t) + local < 0, so where this is under t.
    let neutral = Exposure { threshold: 0.0, ..exposure };
    let mut tones = Tones::default();
    for (view, factors) in views.iter().zip(factors) {
        let covered = &view.buffer.covered;
        let lean = terminal(view, &neutral, knobs).map(|d| d / g);
        let pairs = lean.pixels().iter().zip(covered.pixels());
        tones.all.extend(pairs.filter(|(_, c)| **c).map(|(d, _)| d));
        let seen = mixed_tone(&view.channels, covered, knobs).map(|t| exposure.stretch(*t));
        tones.patches.extend(patches(&seen, &lean, covered, factors));
    }
    tones.all.sort_unstable_by(f32::total_cmp);
    let threshold = tones.settled(exposure.threshold, [knobs.black_min, knobs.black_max]);
    Exposure { threshold, ..exposure }
}

/// The steps of `tones` tones, W - B: at shares of the shot from dark to light that are near the even ones, but part few patches.
pub(crate) fn steps(
    views: &[View],
    factors: &[Plane<[f32; 4]>],
    exposure: &Exposure,
    knobs: &BinaryKnobs,
    tones: usize,
) -> Vec<f32> {
    let knobs = &knobs.for_tones(tones);
    let mut seen = Tones::default();
    for (view, factors) in views.iter().zip(factors) {
        let covered = &view.buffer.covered;
        let lean = terminal(view, exposure, knobs);
        let pairs = lean.pixels().iter().zip(covered.pixels());
        seen.all.extend(pairs.filter(|(_, c)| **c).map(|(d, _)| d));
        let tone = mixed_tone(&view.channels, covered, knobs).map(|t| exposure.stretch(*t));
        seen.patches.extend(patches(&tone, &lean, covered, factors));
    }
    seen.all.sort_unstable_by(f32::total_cmp);
    let wide = seen.at(1.0) - seen.at(0.0);
    seen.patches.retain(|patch| range(patch) <= LEVEL / tones as f32 * wide);
    seen.stepped(&Exposure::shares(tones, 0.5 * (knobs.black_min + knobs.black_max)))
}

/// The difference of most of some ascending tones.
fn range(tones: &[f32]) -> f32 {
    let last = tones.len() - 1;
    tones[last - last / 20] - tones[last / 20]
}

/// The tones of a shot's views, ascending.
#[derive(Default)]
struct Tones {
    all: Vec<f32>,
    /// Those of each patch.
    patches: Vec<Vec<f32>>,
}

impl Tones {
    /// The best threshold near `start`.
    fn settled(&self, start: f32, [least, most]: [f32; 2]) -> f32 {
        let below = |tones: &[f32], t: f32| tones.partition_point(|x| *x < t);
        let all = self.all.len().max(1) as f32;
        let share = |t: f32| below(&self.all, t) as f32 / all;
        let parted = |t: f32| -> f32 {
            let smaller = |patch: &Vec<f32>| below(patch, t).min(patch.len() - below(patch, t));
            self.patches.iter().map(smaller).sum::<usize>() as f32 / all
        };
        let cost = |t: f32| {
            let black = share(t);
            let outside = (least - black).max(0.0) + (black - most).max(0.0);
            let near = share(t + HALF_WIDTH) - share(t - HALF_WIDTH);
            let plateau = PRICE * (near - FREE).max(0.0) + PARTED * parted(t);
            outside + plateau + MOVE * (t - start).abs()
        };
        let mut best = start;
        for step in 1..=25 {
            for sign in [-1.0, 1.0] {
                let t = start + sign * 0.02 * step as f32;
                if cost(t) < cost(best) {
                    best = t;
                }
            }
        }
        best
    }
}

impl Tones {
    /// The tone that a share of the shot is darker than.
    fn at(&self, share: f32) -> f32 {
        let last = self.all.len().saturating_sub(1);
        self.all.get((share * last as f32).round() as usize).copied().unwrap_or(0.0)
    }

    /// Steps near these shares, in their order, that together part the least for the least way.
    fn stepped(&self, shares: &[f32]) -> Vec<f32> {
        let all = self.all.len().max(1) as f32;
        let below = |tones: &[f32], t: f32| tones.partition_point(|x| *x < t);
        let parted = |t: f32| -> f32 {
            let smaller = |patch: &Vec<f32>| below(patch, t).min(patch.len() - below(patch, t));
            self.patches.iter().map(smaller).sum::<usize>() as f32 / all
        };
        let places: Vec<f32> = (0..=PLACES).map(|i| i as f32 / PLACES as f32).collect();
        let evil: Vec<f32> = places.iter().map(|p| PARTED * parted(self.at(*p))).collect();
        // The least cost of the steps so far with the last at each place or before, and where it then is.
        let mut least = vec![0.0; places.len() + 1];
        let mut chosen: Vec<Vec<usize>> = Vec::new();
        for share in shares {
            let mut best = (f32::INFINITY, 0);
            let mut next = vec![f32::INFINITY; GAP];
            let mut at = vec![0; GAP];
            for (i, place) in places.iter().enumerate() {
                let cost = least[i] + evil[i] + (place - share).abs();
                if cost < best.0 {
                    best = (cost, i);
                }
                next.push(best.0);
                at.push(best.1);
            }
            next.truncate(places.len() + 1);
            least = next;
            chosen.push(at);
        }
        let mut end = PLACES + GAP;
        let mut steps: Vec<f32> = chosen
            .iter()
            .rev()
            .map(|at| {
                let i = at[end];
                end = i;
                self.at(places[i])
            })
            .collect();
        steps.reverse();
        steps
    }
}

/// The `tones` of each patch of a view, ascending: of pixels that look alike from one to the next.
fn patches(
    seen: &Plane<f32>,
    tones: &Plane<f32>,
    covered: &Plane<bool>,
    factors: &Plane<[f32; 4]>,
) -> Vec<Vec<f32>> {
    let (w, h) = seen.size();
    let soft = filter::gaussian_covered(seen, covered, NOISE);
    let flat = FLAT * REFERENCE_HEIGHT / h.max(1) as f32;
    let joined = |p: usize, q: usize, e: usize| {
        let step = soft.pixels()[p] - soft.pixels()[q];
        factors.pixels()[p][e] >= FEATURE && step.abs() < flat
    };
    let count = covered.pixels().iter().filter(|c| **c).count();
    let mut is_new = covered.clone().into_pixels();
    let mut found = Vec::new();
    for seed in 0..w * h {
        let mut patch = Vec::new();
        let mut stack = if is_new[seed] { vec![seed] } else { Vec::new() };
        is_new[seed] = false;
        while let Some(p) = stack.pop() {
            patch.push(tones.pixels()[p]);
            let mut visit = |q: usize, joins: bool| {
                if joins && std::mem::take(&mut is_new[q]) {
                    stack.push(q);
                }
            };
            let (x, y) = (p % w, p / w);
            if x + 1 < w {
                visit(p + 1, joined(p, p + 1, 0));
            }
            if x > 0 {
                visit(p - 1, joined(p - 1, p, 0));
            }
            if y + 1 < h {
                visit(p + w, joined(p, p + w, 2));
            }
            if y > 0 {
                visit(p - w, joined(p - w, p, 2));
            }
        }
        if patch.len() as f32 >= SMALLEST * count as f32 && patch.len() > 1 {
            patch.sort_unstable_by(f32::total_cmp);
            found.push(patch);
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_flat_tone_is_not_cut_in_two() {
        // Three faces of a box: 25 % dark, 70 % of nearly one light tone, 5 % bright.
        let mut all = vec![0.1; 250];
        all.extend((0..700).map(|i| 0.6 + 0.00005 * i as f32));
        all.extend(vec![0.9; 50]);
        let tones = Tones { all, patches: Vec::new() };
        let t = tones.settled(0.61, [0.35, 0.6]);
        let black = tones.all.iter().filter(|x| **x < t).count();
        assert_eq!(black, 250, "{t}");
    }

    #[test]
    fn an_even_spread_of_tones_keeps_its_threshold() {
        let all: Vec<f32> = (0..1000).map(|i| i as f32 / 1000.0).collect();
        assert_eq!(Tones { all, patches: Vec::new() }.settled(0.45, [0.35, 0.6]), 0.45);
    }

    #[test]
    fn steps_keep_off_a_flat_patch_and_in_their_order() {
        let all: Vec<f32> = (0..1000).map(|i| i as f32 / 1000.0).collect();
        let even = Tones { all: all.clone(), patches: Vec::new() };
        let steps = even.stepped(&[0.25, 0.5, 0.75]);
        assert!(
            steps.iter().zip([0.25, 0.5, 0.75]).all(|(a, b)| (a - b).abs() < 0.01),
            "{steps:?}"
        );
        let one = Tones { patches: vec![all[400..700].to_vec()], all };
        let steps = one.stepped(&[0.25, 0.5, 0.6]);
        let is_off = |s: &f32| *s <= 0.405 || *s >= 0.695;
        assert!(steps.iter().all(is_off) && steps.is_sorted(), "{steps:?}");
        assert!(Tones::default().stepped(&[0.3, 0.6]).iter().all(|s| *s == 0.0));
    }

    /// A plate whose tone rises from .7 to .9 across the picture, with a dark box on it.
    fn plate() -> (Plane<f32>, Plane<bool>, Plane<[f32; 4]>) {
        let (w, h) = (200, 100);
        let is_box = |x: usize, y: usize| (120..150).contains(&x) && (40..70).contains(&y);
        let rising = |x: usize| 0.7 + 0.001 * x as f32;
        let tone = Plane::from_fn(w, h, |x, y| if is_box(x, y) { 0.1 } else { rising(x) });
        let factors = Plane::from_fn(w, h, |x, y| {
            let same = |u: usize, v: usize| is_box(x, y) == is_box(u, v);
            [same(x + 1, y), true, same(x, y + 1), true].map(|s| if s { 1.0 } else { 0.1 })
        });
        (tone, Plane::filled(w, h, true), factors)
    }

    #[test]
    fn a_plate_of_weak_gradient_is_one_patch_and_is_not_parted() {
        let (tone, covered, factors) = plate();
        let found = patches(&tone, &tone, &covered, &factors);
        let sizes: Vec<usize> = found.iter().map(Vec::len).collect();
        assert!(sizes.len() == 2 && sizes[0] > 18_000 && sizes[1] > 500, "{sizes:?}");
        let mut all = tone.into_pixels();
        all.sort_unstable_by(f32::total_cmp);
        let t = Tones { all, patches: found }.settled(0.8, [0.35, 0.6]);
        assert!(!(0.705..0.895).contains(&t), "{t}");
    }
}
