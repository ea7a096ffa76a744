//! From weights to labels: fixed-point capacities, the minimal cut, and its measures.

use crate::geometry::{capacities, neighbour_factors};
use crate::knob::{BinaryKnobs, REFERENCE_HEIGHT};
use crate::mend::Costs;
use crate::round::reach;
use chiaro_basis::{Error, Result};
use chiaro_image::{Plane, Runs};
use chiaro_mincut::Grid;
use chiaro_trace::GBuffer;
use std::borrow::Cow;
use std::f32::consts::FRAC_1_SQRT_2;

/// The graph of a picture in integers.
#[derive(Clone, Debug)]
pub struct Graph {
    /// Which pixels are nodes.
    pub mask: Plane<bool>,
    /// Capacities to white and to black; at each pixel the smaller one is 0.
    pub terminal: Plane<[i32; 2]>,
    /// Capacities to E, SE, S, SW.
    pub neighbour: Plane<[i32; 4]>,
    /// Units of capacity in a weight of 1.
    pub scale: f32,
}

/// A cut of a [`Graph`].
#[derive(Clone, Debug)]
pub struct Labels {
    /// White where true; black, or nothing, elsewhere.
    pub white: Plane<bool>,
    /// The maximal flow, in units of capacity.
    pub flow: i64,
    /// The cut's capacity; equal to the flow.
    pub cut: i64,
}

/// Capacities stay in 14 bits for weights up to 1, and the solver has its fast form for those.
const UNITS: f32 = 8192.0;
const LARGEST: f32 = 16_000.0;

/// Units in N~ with which capacities tell features from other pairs.
const LEAST_UNITS: f32 = 256.0;

impl Graph {
    /// Rounds weights to units: N~ of the knobs times `factors` between neighbours, and
    /// `difference` (W - B) at the terminals. The scale depends on knobs and height alone, so that
    /// the frames of a shot agree.
    pub fn new(
        mask: &Plane<bool>,
        difference: &Plane<f32>,
        factors: &Plane<[f32; 4]>,
        knobs: &BinaryKnobs,
    ) -> Self {
        let (units, scale) = units(mask.height(), knobs);
        let neighbour = Runs::of(mask).plane([0; 4], |y, run, neighbour| {
            for (neighbour, f) in neighbour.iter_mut().zip(&factors.row(y)[run]) {
                *neighbour = rounded(*f, units);
            }
        });
        let terminal = terminals(mask, difference, scale);
        Self { mask: mask.clone(), terminal, neighbour, scale }
    }

    /// The graph of what is seen, [`Graph::new`] with [`neighbour_factors`](crate::neighbour_factors)
    /// in one go, and its feature pairs. Whoever owns what is seen may let it go before
    /// `difference`, from which terminals are made, is asked for.
    pub fn of<'a>(
        buffer: Cow<'_, GBuffer>,
        difference: impl FnOnce() -> Cow<'a, Plane<f32>>,
        knobs: &BinaryKnobs,
    ) -> (Self, FeaturePairs) {
        let (units, scale) = units(buffer.covered.height(), knobs);
        let (neighbour, pairs) = if units[0] < LEAST_UNITS {
            let factors = neighbour_factors(&buffer, knobs);
            (factors.map(|f| rounded(*f, units)), FeaturePairs::of(&factors))
        } else {
            let neighbour = capacities(&buffer, units, knobs);
            let pairs = FeaturePairs::among(&neighbour, |c| c as f32);
            (neighbour, pairs)
        };
        let mask = match buffer {
            Cow::Owned(buffer) => buffer.covered,
            Cow::Borrowed(buffer) => buffer.covered.clone(),
        };
        let terminal = terminals(&mask, &difference(), scale);
        (Self { mask, terminal, neighbour, scale }, pairs)
    }

    /// Sets what pulls each pixel, W - B.
    pub(crate) fn set_difference(&mut self, difference: &Plane<f32>) {
        self.terminal = terminals(&self.mask, difference, self.scale);
    }

    /// The minimal cut.
    pub fn solve(&self) -> Result<Labels> {
        let (width, height) = self.mask.size();
        let cut = chiaro_mincut::solve_on(&self.grid(), rayon::current_num_threads())
            .map_err(|e| Error::setting("neighbour", e, "weights that the cut can add up"))?;
        let white = Plane::from_pixels(width, height, cut.labels);
        Ok(Labels { white, flow: cut.flow, cut: cut.cut })
    }

    /// The energy of any labelling.
    pub fn energy(&self, white: &Plane<bool>) -> i64 {
        chiaro_mincut::energy(&self.grid(), white.pixels())
    }

    /// Labels without pieces of fewer than `area` pixels that touch another label, at little cost:
    /// a small piece grows, or takes the colour around it.
    pub fn without_islands(&self, white: &Plane<bool>, area: f32) -> Plane<bool> {
        let labels = white.map(|w| u8::from(*w));
        self.costs(self.terminal.pixels().as_flattened(), 2)
            .without_islands(&labels, area)
            .map(|l| *l == 1)
    }

    /// Labels near those given that cost least by sixteen neighbours: what nothing guides is round
    /// instead of faceted. Only what lies within `round` of the knobs from a border changes.
    pub fn rounded(&self, white: &Plane<bool>, knobs: &BinaryKnobs) -> Result<Plane<bool>> {
        let labels = white.map(|w| u8::from(*w));
        let costs = self.costs(self.terminal.pixels().as_flattened(), 2);
        Ok(costs.rounded(&labels, reach(knobs, white.height()))?.map(|l| *l == 1))
    }

    /// What labels cost that have these prices, with the bonds of the graph.
    pub(crate) fn costs<'a>(&'a self, prices: &'a [i32], count: usize) -> Costs<'a> {
        Costs { mask: &self.mask, count, prices, neighbour: &self.neighbour, by_step: false }
    }

    fn grid(&self) -> Grid<'_> {
        let (width, height) = self.mask.size();
        Grid {
            width,
            height,
            mask: self.mask.pixels(),
            terminal: self.terminal.pixels(),
            neighbour: self.neighbour.pixels(),
        }
    }
}

/// Units of capacity in N~ to E, SE, S and SW, and in a weight of 1.
fn units(height: usize, knobs: &BinaryKnobs) -> ([f32; 4], f32) {
    let strength = knobs.neighbour * height as f32 / REFERENCE_HEIGHT;
    let scale = UNITS.min(LARGEST / strength.max(1e-6));
    let diagonal = if knobs.diagonal { FRAC_1_SQRT_2 } else { 1.0 };
    ([1.0, diagonal, 1.0, diagonal].map(|d| d * strength * scale), scale)
}

/// Capacities to white and to black of covered pixels.
fn terminals(mask: &Plane<bool>, difference: &Plane<f32>, scale: f32) -> Plane<[i32; 2]> {
    Runs::of(mask).plane([0; 2], |y, run, terminal| {
        let row = difference.row(y)[run.clone()].iter().zip(&mask.row(y)[run]);
        for (terminal, (d, m)) in terminal.iter_mut().zip(row) {
            // Beyond 4 a pixel is as good as bound.
            let units = nearest(d.clamp(-4.0, 4.0) * scale);
            *terminal = if *m { [units.max(0), (-units).max(0)] } else { [0, 0] };
        }
    })
}

/// Capacities of a pixel's neighbour weights.
#[inline(always)]
pub(crate) fn rounded(factors: [f32; 4], units: [f32; 4]) -> [i32; 4] {
    std::array::from_fn(|e| nearest(factors[e] * units[e]))
}

/// The nearest integer, halves away from zero, in a form that loops over pixels vectorize.
#[inline(always)]
fn nearest(x: f32) -> i32 {
    (x + 0.5f32.copysign(x)) as i32
}

/// How much of the border runs on features.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct Border {
    /// Horizontal and vertical pairs of different label.
    pub pairs: u64,
    /// Share of feature pairs among those.
    pub on_features: f64,
    /// Share of feature pairs among all pairs.
    pub by_chance: f64,
}

/// Which horizontal and vertical pairs are features: their factor is under half of the largest.
#[derive(Clone, Debug)]
pub struct FeaturePairs(Plane<u8>);

impl FeaturePairs {
    /// The feature pairs of a picture's neighbour weights.
    pub fn of(factors: &Plane<[f32; 4]>) -> Self {
        Self::among(factors, |f| f)
    }

    /// Those among weights to E, SE, S and SW in any unit.
    fn among<T: Copy + Sync>(weights: &Plane<[T; 4]>, number: impl Fn(T) -> f32 + Sync) -> Self {
        let pair = |w: &[T; 4]| [number(w[0]), number(w[2])];
        let largest = weights.pixels().iter().flat_map(pair).fold(0.0, f32::max);
        Self(weights.map(|w| {
            let [across, down] = pair(w).map(|f| u8::from(f < 0.5 * largest));
            across | down << 1
        }))
    }
}

impl Border {
    /// Counts horizontal and vertical pairs.
    pub fn measure(white: &Plane<bool>, mask: &Plane<bool>, features: &FeaturePairs) -> Self {
        let (w, h) = mask.size();
        let (mut all, mut on_features, mut border, mut both) = (0u64, 0u64, 0u64, 0u64);
        for y in 0..h {
            for x in 0..w {
                for (bit, q) in [(1, (x + 1, y)), (2, (x, y + 1))] {
                    if q.0 >= w || q.1 >= h || !mask[(x, y)] || !mask[q] {
                        continue;
                    }
                    let feature = features.0[(x, y)] & bit != 0;
                    let differs = white[(x, y)] != white[q];
                    all += 1;
                    on_features += u64::from(feature);
                    border += u64::from(differs);
                    both += u64::from(feature && differs);
                }
            }
        }
        let share = |a: u64, b: u64| if b == 0 { 0.0 } else { a as f64 / b as f64 };
        Self { pairs: border, on_features: share(both, border), by_chance: share(on_features, all) }
    }

    /// The share on features beyond chance: (s - c) / (1 - c).
    pub fn beyond_chance(&self) -> f64 {
        (self.on_features - self.by_chance) / (1.0 - self.by_chance).max(1e-9)
    }
}
