//! Baselines: how others make two colours of one tone, for pictures side by side (section 3.7).
//!
//! | method | from |
//! |---|---|
//! | [`Method::Threshold`] | our own W - B, cut at zero pixel by pixel |
//! | [`Method::Otsu`] | Otsu 1979: the threshold of greatest variance between the classes |
//! | [`Method::GaussianOtsu`] | the same of the blurred tone |
//! | [`Method::Kittler`] | Kittler and Illingworth 1986: minimum error of two normal classes |
//! | [`Method::Yanowitz`] | Yanowitz and Bruckstein 1989: a surface through the tones at edges |
//! | [`Method::Sauvola`] | Sauvola and Pietikainen 2000: local mean and deviation |
//! | [`Method::ImageCut`] | in the manner of Mould and Grant 2008: a cut whose bonds see the tone alone |
//! | [`Method::Toon`] | in the manner of Vergne et al. 2008: a local threshold, moved by the relief, with lines |
//!
//! All but the last two see nothing of the geometry but where it covers the picture.

use crate::cut::Graph;
use crate::exposure::{Exposure, local_contrast, mixed_tone};
use crate::geometry::EDGES;
use crate::knob::{BinaryKnobs, scaled};
use crate::line::Lines;
use crate::shade::View;
use crate::terminal::terminal;
use chiaro_basis::Result;
use chiaro_image::labels::{UNCOVERED, components};
use chiaro_image::{Plane, filter, statistics};
use std::f32::consts::FRAC_1_SQRT_2;

/// A way to make two colours of one tone.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Method {
    /// The sign of W - B.
    Threshold,
    /// Otsu's threshold.
    Otsu,
    /// Otsu's threshold after a Gaussian.
    GaussianOtsu,
    /// Minimum error thresholding.
    Kittler,
    /// A threshold surface through edges.
    Yanowitz,
    /// Local mean and deviation.
    Sauvola,
    /// A minimal cut of the picture alone.
    ImageCut,
    /// A toon threshold with lines.
    Toon,
}

impl Method {
    /// All of them.
    pub const ALL: [Self; 8] = [
        Self::Threshold,
        Self::Otsu,
        Self::GaussianOtsu,
        Self::Kittler,
        Self::Yanowitz,
        Self::Sauvola,
        Self::ImageCut,
        Self::Toon,
    ];

    /// The name in captions and records.
    pub fn name(self) -> &'static str {
        match self {
            Self::Threshold => "threshold",
            Self::Otsu => "otsu",
            Self::GaussianOtsu => "gaussian-otsu",
            Self::Kittler => "kittler",
            Self::Yanowitz => "yanowitz",
            Self::Sauvola => "sauvola",
            Self::ImageCut => "image-cut",
            Self::Toon => "toon",
        }
    }

    /// The regions that this method makes of a view; white where true.
    pub fn regions(
        self,
        view: &View,
        exposure: &Exposure,
        knobs: &BinaryKnobs,
    ) -> Result<Plane<bool>> {
        let covered = &view.buffer.covered;
        let mixed = mixed_tone(&view.channels, covered, knobs);
        let tone = mixed.map(|t| exposure.stretch(*t));
        let above = |plane: &Plane<f32>, t: f32| plane.map(|v| *v >= t);
        let height = covered.height();
        let white = match self {
            Self::Threshold => above(&terminal(view, exposure, knobs), f32::MIN_POSITIVE),
            Self::Otsu => above(&tone, statistics::otsu(&tone, covered)),
            Self::GaussianOtsu => {
                let soft = filter::gaussian_covered(&tone, covered, scaled(2.9, height));
                above(&soft, statistics::otsu(&soft, covered))
            }
            Self::Kittler => above(&tone, kittler(&tone, covered)),
            Self::Yanowitz => yanowitz(&tone, covered),
            Self::Sauvola => sauvola(&tone, covered, scaled(12.0, height)),
            Self::ImageCut => image_cut(&tone, covered, exposure, knobs)?,
            Self::Toon => toon(&tone, view, exposure),
        };
        Ok(white.zip(covered, |w, c| *w && *c).expect("all have the picture's size"))
    }

    /// The lines that belong to it: haloed contours for the toon threshold, else none.
    pub fn lines(self, view: &View, white: &Plane<bool>, paper_is_white: bool) -> Lines {
        match self {
            Self::Toon => {
                let knobs = BinaryKnobs { line_crease: 181.0, ..BinaryKnobs::default() };
                Lines::find(&view.buffer, white, paper_is_white, &knobs)
            }
            _ => Lines::default(),
        }
    }
}

/// Bins of the histogram of [`kittler`].
const BINS: usize = 256;

/// The threshold in [0, 1] that minimizes Kittler and Illingworth's criterion
/// J = 1 + 2 (P1 log s1 + P2 log s2) - 2 (P1 log P1 + P2 log P2); 0.5 where none is defined.
fn kittler(tone: &Plane<f32>, covered: &Plane<bool>) -> f32 {
    let mut bins = [0f64; BINS];
    for (t, _) in tone.pixels().iter().zip(covered.pixels()).filter(|(_, c)| **c) {
        bins[((t.clamp(0.0, 1.0) * BINS as f32) as usize).min(BINS - 1)] += 1.0;
    }
    let total: f64 = bins.iter().sum();
    let moments = |range: std::ops::Range<usize>| {
        let count: f64 = bins[range.clone()].iter().sum();
        let mean = range.clone().map(|i| i as f64 * bins[i]).sum::<f64>() / count;
        let variance = range.map(|i| (i as f64 - mean).powi(2) * bins[i]).sum::<f64>() / count;
        (count / total, variance)
    };
    let criterion = |t: usize| {
        let ((p1, v1), (p2, v2)) = (moments(0..t), moments(t..BINS));
        // A class of one bin has no width of its own.
        let defined = p1 > 0.001 && p2 > 0.001 && v1 > 0.25 && v2 > 0.25;
        defined.then(|| p1 * v1.ln() + p2 * v2.ln() - 2.0 * (p1 * p1.ln() + p2 * p2.ln()))
    };
    let scored: Vec<(f64, usize)> = (1..BINS).filter_map(|t| Some((criterion(t)?, t))).collect();
    let best = scored.iter().map(|s| s.0).fold(f64::INFINITY, f64::min);
    // In an empty stretch of the histogram all thresholds are alike: their middle.
    let mut alike = scored.iter().filter(|s| s.0 <= best + 1e-9).map(|s| s.1);
    match (alike.next(), alike.next_back()) {
        (Some(first), last) => (first + last.unwrap_or(first)) as f32 / 2.0 / BINS as f32,
        _ => 0.5,
    }
}

/// Yanowitz and Bruckstein: tones at the steepest places are kept, a membrane is stretched between
/// them, and the tone is compared with it. Regions without a steep border are ghosts and take the
/// colour around them.
fn yanowitz(tone: &Plane<f32>, covered: &Plane<bool>) -> Plane<bool> {
    let soft = filter::gaussian_covered(tone, covered, 1.0);
    let slope = slope(&soft, covered);
    let steep = statistics::percentile(&slope, covered, 92.0).unwrap_or(0.0).max(1e-4);
    let pinned = covered.zip(&slope, |c, s| *c && *s >= steep).expect("same size");
    let surface = membrane(&soft, &pinned, covered);
    let white = tone.zip(&surface, |t, s| t >= s).expect("same size");
    without_ghosts(&white, covered, &slope, 0.5 * steep)
}

/// The length of the gradient, in tone a pixel, over covered neighbours.
fn slope(tone: &Plane<f32>, covered: &Plane<bool>) -> Plane<f32> {
    let (w, h) = tone.size();
    Plane::from_fn(w, h, |x, y| {
        let at = |u: isize, v: isize| {
            let (u, v) = (x as isize + u, y as isize + v);
            let inside = covered.at(u, v) == Some(&true);
            if inside { tone[(u as usize, v as usize)] } else { tone[(x, y)] }
        };
        (0.5 * (at(1, 0) - at(-1, 0))).hypot(0.5 * (at(0, 1) - at(0, -1)))
    })
}

/// The smooth surface through the pinned values: Laplace's equation, relaxed from coarse to fine.
fn membrane(value: &Plane<f32>, pinned: &Plane<bool>, covered: &Plane<bool>) -> Plane<f32> {
    let (w, h) = value.size();
    let start = if w.max(h) > 8 {
        let half = (w.div_ceil(2), h.div_ceil(2));
        let cells = |x: usize, y: usize| {
            [(2 * x, 2 * y), (2 * x + 1, 2 * y), (2 * x, 2 * y + 1), (2 * x + 1, 2 * y + 1)]
                .into_iter()
                .filter(|p| p.0 < w && p.1 < h)
        };
        let mean = |x: usize, y: usize| {
            let all: Vec<_> = cells(x, y).collect();
            let pins: Vec<_> = all.iter().copied().filter(|p| pinned[*p]).collect();
            let of = if pins.is_empty() { &all } else { &pins };
            of.iter().map(|p| value[*p]).sum::<f32>() / of.len() as f32
        };
        let coarse = membrane(
            &Plane::from_fn(half.0, half.1, mean),
            &Plane::from_fn(half.0, half.1, |x, y| cells(x, y).any(|p| pinned[p])),
            &Plane::from_fn(half.0, half.1, |x, y| cells(x, y).any(|p| covered[p])),
        );
        Plane::from_fn(w, h, |x, y| coarse[(x / 2, y / 2)])
    } else {
        value.clone()
    };
    let mut surface =
        Plane::from_fn(w, h, |x, y| if pinned[(x, y)] { value[(x, y)] } else { start[(x, y)] });
    for _ in 0..60 {
        surface = Plane::from_fn(w, h, |x, y| {
            if pinned[(x, y)] {
                return surface[(x, y)];
            }
            let at = |dx: isize, dy: isize| {
                let (u, v) = (x as isize + dx, y as isize + dy);
                *surface.at(u, v).unwrap_or(&surface[(x, y)])
            };
            0.25 * (at(1, 0) + at(-1, 0) + at(0, 1) + at(0, -1))
        });
    }
    surface
}

/// Pieces whose border is flatter than `least` on average take the other colour.
fn without_ghosts(
    white: &Plane<bool>,
    covered: &Plane<bool>,
    slope: &Plane<f32>,
    least: f32,
) -> Plane<bool> {
    let found = components(white, covered);
    let mut border = vec![(0.0f64, 0u32); found.pieces.len()];
    let (w, h) = white.size();
    for (x, y) in (0..h).flat_map(|y| (0..w).map(move |x| (x, y))) {
        let id = found.ids[(x, y)];
        let differs = |dx: isize, dy: isize| {
            let (u, v) = (x as isize + dx, y as isize + dy);
            found.ids.at(u, v).is_some_and(|n| *n != id && *n != UNCOVERED)
        };
        if id != UNCOVERED && (differs(1, 0) || differs(-1, 0) || differs(0, 1) || differs(0, -1)) {
            let (sum, count) = &mut border[id as usize];
            *sum += f64::from(slope[(x, y)]);
            *count += 1;
        }
    }
    let ghost = |id: usize| {
        let (sum, count) = border[id];
        found.pieces[id].touches_other && count > 0 && sum / f64::from(count) < f64::from(least)
    };
    let flipped =
        |id: &u32, w: &bool| if *id == UNCOVERED { *w } else { *w != ghost(*id as usize) };
    found.ids.zip(white, flipped).expect("pieces have the picture's size")
}

/// Sauvola's threshold m (1 + k (s / R - 1)) with k = 0.2, R = 0.5, over a Gaussian window.
fn sauvola(tone: &Plane<f32>, covered: &Plane<bool>, sigma: f32) -> Plane<bool> {
    let mean = filter::gaussian_covered(tone, covered, sigma);
    let squares = filter::gaussian_covered(&tone.map(|t| t * t), covered, sigma);
    let limit = mean
        .zip(&squares, |m, s| m * (1.0 + 0.2 * ((s - m * m).max(0.0).sqrt() / 0.5 - 1.0)))
        .expect("same size");
    tone.zip(&limit, |t, l| t >= l).expect("same size")
}

/// A minimal cut whose terminals are the tone's and whose bonds fall with the tone's own steps.
fn image_cut(
    tone: &Plane<f32>,
    covered: &Plane<bool>,
    exposure: &Exposure,
    knobs: &BinaryKnobs,
) -> Result<Plane<bool>> {
    let difference = tone.map(|t| t - exposure.threshold);
    let factors = image_bonds(tone, covered);
    // The tone alone pulls harder than a mix that holds only the share g of it.
    let neighbour = knobs.neighbour / knobs.global.max(0.3);
    let knobs = BinaryKnobs { neighbour, ..knobs.clone() };
    Ok(Graph::new(covered, &difference, &factors, &knobs).solve()?.white)
}

/// Neighbour weights relative to N~ that know the tone alone: they fall with its steps.
pub fn image_bonds(tone: &Plane<f32>, covered: &Plane<bool>) -> Plane<[f32; 4]> {
    /// The step of tone a pixel that a border may follow.
    const STEP: f32 = 0.06;
    let (w, h) = tone.size();
    Plane::from_fn(w, h, |x, y| {
        EDGES.map(|(dx, dy)| {
            let (u, v) = (x as isize + dx, y as isize + dy);
            if !covered[(x, y)] || covered.at(u, v) != Some(&true) {
                return 0.0;
            }
            let length = if dx != 0 && dy != 0 { FRAC_1_SQRT_2 } else { 1.0 };
            let t = (tone[(x, y)] - tone[(u as usize, v as usize)]) * length / STEP;
            (-t * t).exp()
        })
    })
}

/// The tone, sharpened by the relief's own head lamp, against one threshold.
fn toon(tone: &Plane<f32>, view: &View, exposure: &Exposure) -> Plane<bool> {
    let head = chiaro_trace::channel::headlamp(&view.buffer);
    let relief = local_contrast(&head, &view.buffer.covered, 8.0);
    tone.zip(&relief, |t, r| t + 0.6 * r >= exposure.threshold).expect("same size")
}

#[cfg(test)]
mod tests {
    use super::*;
    use chiaro_basis::random::unit;

    /// Two tones with noise, a slope of light across both.
    fn page(tilt: f32) -> (Plane<f32>, Plane<bool>, Plane<bool>) {
        let dark = Plane::from_fn(96, 64, |x, y| (x / 12 + y / 12) % 2 == 0);
        let tone = Plane::from_fn(96, 64, |x, y| {
            let base = if dark[(x, y)] { 0.25 } else { 0.55 };
            let light = tilt * (x as f32 / 96.0 - 0.5);
            base + light + 0.06 * (unit(3, (y * 96 + x) as u64) - 0.5)
        });
        (tone, Plane::filled(96, 64, true), dark)
    }

    fn wrong(white: &Plane<bool>, dark: &Plane<bool>) -> f32 {
        let pairs = white.pixels().iter().zip(dark.pixels());
        pairs.filter(|(w, d)| w == d).count() as f32 / white.len() as f32
    }

    #[test]
    fn minimum_error_finds_the_valley_between_two_tones() {
        let (tone, covered, dark) = page(0.0);
        let t = kittler(&tone, &covered);
        assert!((0.3..0.5).contains(&t), "{t}");
        assert_eq!(wrong(&tone.map(|v| *v >= t), &dark), 0.0);
        assert_eq!(kittler(&Plane::filled(4, 4, 0.3), &Plane::filled(4, 4, true)), 0.5);
    }

    #[test]
    fn local_thresholds_bear_uneven_light_and_a_global_one_does_not() {
        let (tone, covered, dark) = page(0.7);
        let global = tone.map(|v| *v >= statistics::otsu(&tone, &covered));
        assert!(wrong(&global, &dark) > 0.1);
        assert!(wrong(&yanowitz(&tone, &covered), &dark) < 0.06);
        assert!(wrong(&sauvola(&tone, &covered, 12.0), &dark) < 0.1);
    }

    #[test]
    fn a_membrane_between_two_pins_is_straight() {
        let pinned = Plane::from_fn(33, 5, |x, _| x == 0 || x == 32);
        let value = Plane::from_fn(33, 5, |x, _| if x == 32 { 1.0 } else { 0.0 });
        let surface = membrane(&value, &pinned, &Plane::filled(33, 5, true));
        for x in 0..33 {
            assert!((surface[(x, 2)] - x as f32 / 32.0).abs() < 0.15, "{x} {}", surface[(x, 2)]);
        }
    }
}
