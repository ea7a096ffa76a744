//! How strongly a frame of a film holds on to the one before it: the capacity of each pixel's link.
//!
//! Links add up over areas, as terminals do: they do not grow with the picture.
//!
//! 1. Where much changes by itself, links delay true changes and cost more than they steady; where
//!    little does, stronger ones cost next to nothing. So the capacity goes by the inverse root of the
//!    share that changes, in squares ([`Changes`]) and in the picture, half of each ([`holds`]).
//! 2. What that costs still differs from film to film. From frame to frame of a block links get
//!    stronger or weaker until the cut costs [`USUAL_COST`] more than the frames' own ([`Pace`]).

use crate::cel::Cel;
use crate::cut::Graph;
use crate::knob::{BinaryKnobs, scaled};
use chiaro_image::Plane;
use chiaro_trace::UNLINKED;

/// The share of labels that change by themselves from a frame to the next at which links are worth
/// what `coherence` says, and how much more or less they may be worth.
const USUAL_CHANGE: f32 = 0.028;
const LEAST_STRENGTH: f32 = 0.3;
const MOST_STRENGTH: f32 = 2.0;

/// The side of the squares in which changes are summed, pixels at 480, and in small pictures.
const CHANGE_SIDE: f32 = 16.0;
const LEAST_CHANGE_SIDE: usize = 8;

/// The part of a cut's energy that links may add at the default `coherence`; it goes with it.
const USUAL_COST: f32 = 0.027;
const USUAL_COHERENCE: f32 = 0.3;

/// How much of the way to that cost is made in a frame, as a power, how far at most, and the limits.
const GAIN: f32 = 0.25;
const LONGEST_STEP: f32 = 1.25;
const SLOWEST: f32 = 0.8;
const FASTEST: f32 = 2.0;

/// What the links of a frame are worth.
#[derive(Clone, Copy)]
pub(crate) struct Hold<'a> {
    base: &'a Plane<i32>,
    pace: f32,
}

impl<'a> Hold<'a> {
    pub(crate) fn new(base: &'a Plane<i32>, pace: f32) -> Self {
        Self { base, pace }
    }

    /// The capacity of the link of a pixel.
    pub(crate) fn at(&self, pixel: usize) -> i32 {
        (self.base.pixels()[pixel] as f32 * self.pace).round() as i32
    }
}

/// How much more or less the links of the layers are worth than [`holds`] says.
#[derive(Clone, Debug, Default)]
pub(crate) struct Pace(Vec<f32>);

impl Pace {
    /// That of a key, which depends on no frame before.
    pub(crate) fn of(&self, layer: usize) -> f32 {
        self.0.get(layer).copied().unwrap_or(1.0)
    }

    pub(crate) fn reset(&mut self) {
        self.0.clear();
    }

    /// Takes in what the links of a frame's layer have cost, as a share of the energy of its own cut.
    pub(crate) fn learn(&mut self, layer: usize, cost: f32, knobs: &BinaryKnobs) {
        let wanted = USUAL_COST * knobs.coherence / USUAL_COHERENCE;
        let step = (wanted / cost.max(1e-4)).powf(GAIN).clamp(1.0 / LONGEST_STEP, LONGEST_STEP);
        if self.0.len() <= layer {
            self.0.resize(layer + 1, 1.0);
        }
        self.0[layer] = (self.0[layer] * step).clamp(SLOWEST, FASTEST);
    }
}

/// What a link is worth where as much changes as usual, in units of capacity.
fn usual(graph: &Graph, knobs: &BinaryKnobs) -> f32 {
    knobs.coherence * knobs.neighbour * graph.scale
}

/// Links that are worth as much everywhere.
pub(crate) fn usual_hold(graph: &Graph, knobs: &BinaryKnobs) -> Plane<i32> {
    let (width, height) = graph.mask.size();
    Plane::filled(width, height, usual(graph, knobs).round() as i32)
}

/// The capacities of a frame's links by layer, at a pace of 1.
pub(crate) fn holds(cel: &Cel, before: Option<&Cel>, knobs: &BinaryKnobs) -> Vec<Plane<i32>> {
    let usual = usual(&cel.graph, knobs);
    let (width, height) = cel.graph.mask.size();
    let hold = |layer| {
        let Some(before) = before else { return usual_hold(&cel.graph, knobs) };
        let changes = Changes::of(cel, before, layer);
        let strengths = changes.strengths();
        let side = changes.side as f32;
        Plane::from_fn(width, height, |x, y| {
            let at = [x, y].map(|c| (c as f32 + 0.5) / side - 0.5);
            (usual * between(&strengths, at)).round() as i32
        })
    };
    (0..cel.depth()).map(hold).collect()
}

/// Links by squares: those whose labels change by themselves, and all.
struct Changes {
    /// The side of a square, pixels.
    side: usize,
    squares: Plane<[f32; 2]>,
}

impl Changes {
    /// Where the labels of a frame's own change along its links, but for what comes and goes side by
    /// side: noise at borders is no change.
    fn of(cel: &Cel, before: &Cel, layer: usize) -> Self {
        let (here, there) = (cel.own(layer).0, before.own(layer).0.pixels());
        let (width, height) = here.size();
        let side = (scaled(CHANGE_SIDE, height).ceil() as usize).max(LEAST_CHANGE_SIDE);
        let (across, down) = (width.div_ceil(side), height.div_ceil(side));
        let count = cel.count(layer);
        let mut gained = vec![0i32; across * down * count];
        let (mut flips, mut seen) = (vec![0u32; across * down], vec![0u32; across * down]);
        for (p, to) in cel.links.pixels().iter().enumerate().filter(|(_, to)| **to != UNLINKED) {
            let square = p / width / side * across + p % width / side;
            let (label, former) = (here.pixels()[p], there[*to as usize]);
            gained[square * count + usize::from(label)] += 1;
            gained[square * count + usize::from(former)] -= 1;
            flips[square] += u32::from(label != former);
            seen[square] += 1;
        }
        // By chance, of n flips either way some root of n are left over.
        let changed = |(gained, flips): (&[i32], &u32)| {
            let left: u32 = gained.iter().map(|g| g.unsigned_abs()).sum();
            (0.5 * left as f32 - (*flips as f32).sqrt()).max(0.0)
        };
        let changed = gained.chunks(count).zip(&flips).map(changed);
        let squares = changed.zip(seen).map(|(changed, seen)| [changed, seen as f32]).collect();
        Self { side, squares: Plane::from_pixels(across, down, squares) }
    }

    /// How much more than usual the links in each square are worth.
    fn strengths(&self) -> Plane<f32> {
        let whole = share(self.squares.pixels().iter());
        let (w, h) = self.squares.size();
        Plane::from_fn(w, h, |x, y| {
            let rows = y.saturating_sub(1)..(y + 2).min(h);
            let columns = x.saturating_sub(1)..(x + 2).min(w);
            let around = share(rows.flat_map(|y| &self.squares.row(y)[columns.clone()]));
            let strength = (USUAL_CHANGE / (0.5 * (whole + around)).max(1e-6)).sqrt();
            strength.clamp(LEAST_STRENGTH, MOST_STRENGTH)
        })
    }
}

/// The share of links that change.
fn share<'a>(squares: impl Iterator<Item = &'a [f32; 2]>) -> f32 {
    let [changed, all] = squares.fold([0.0; 2], |sum, s| [sum[0] + s[0], sum[1] + s[1]]);
    changed / all.max(1.0)
}

/// The value of a plane between the centres of its pixels, which lie at whole numbers here.
fn between(plane: &Plane<f32>, [x, y]: [f32; 2]) -> f32 {
    let last = (plane.width() - 1, plane.height() - 1);
    let (x, y) = (x.clamp(0.0, last.0 as f32), y.clamp(0.0, last.1 as f32));
    let (i, j) = (x as usize, y as usize);
    let (u, v) = (x - i as f32, y - j as f32);
    let row = |j: usize| (1.0 - u) * plane[(i, j)] + u * plane[((i + 1).min(last.0), j)];
    (1.0 - v) * row(j) + v * row((j + 1).min(last.1))
}

#[cfg(test)]
mod tests {
    use super::*;
    use chiaro_basis::random;

    /// A square of pixels that are white where `is_white` holds for their places.
    fn square(knobs: &BinaryKnobs, is_white: impl Fn(usize) -> bool + Sync) -> Cel {
        let (w, h) = (64, 64);
        let covered = Plane::filled(w, h, true);
        let white = Plane::from_fn(w, h, |x, y| is_white(y * w + x));
        let difference = white.map(|white| if *white { 0.5 } else { -0.5 });
        let graph = Graph::new(&covered, &difference, &Plane::filled(w, h, [0.0; 4]), knobs);
        Cel::new(graph, Plane::from_fn(w, h, |x, y| (y * w + x) as u32)).expect("small weights")
    }

    #[test]
    fn frames_hold_on_the_less_the_more_changes_there() {
        let knobs = BinaryKnobs::default();
        let first = square(&knobs, |_| false);
        let usual = knobs.coherence * knobs.neighbour * first.graph.scale;
        let strength = |rows: usize, y: usize| {
            let cel = square(&knobs, |p| p < 64 * rows);
            holds(&cel, Some(&first), &knobs)[0][(32, y)] as f32 / usual
        };
        for y in [0, 31, 63] {
            assert!((strength(0, y) - MOST_STRENGTH).abs() < 1e-2);
            assert!((strength(64, y) - LEAST_STRENGTH).abs() < 1e-2);
        }
        // All changes in the first of eight rows of squares, 64 pixels each, of which eight by chance.
        let whole = 56.0 / 64.0 / 8.0;
        let far = (USUAL_CHANGE / (0.5 * whole)).sqrt();
        assert!((strength(8, 63) - far).abs() < 1e-2);
        let near = (USUAL_CHANGE / (0.5 * (whole + 4.0 * whole))).sqrt();
        assert!((strength(8, 0) - near.max(LEAST_STRENGTH)).abs() < 1e-2);
        assert_eq!(holds(&first, None, &knobs)[0][(5, 5)], usual.round() as i32);
    }

    #[test]
    fn noise_is_no_change() {
        let knobs = BinaryKnobs::default();
        let noisy = |seed| square(&knobs, move |p| random::unit(seed, p as u64) < 0.5);
        let changes = Changes::of(&noisy(1), &noisy(2), 0);
        let share = share(changes.squares.pixels().iter());
        assert!(share < 0.02, "{share}");
    }

    #[test]
    fn links_get_stronger_until_they_cost_what_they_may() {
        let knobs = BinaryKnobs::default();
        let mut pace = Pace::default();
        // What they cost goes with the square of what they are worth.
        for _ in 0..40 {
            pace.learn(1, 0.012 * pace.of(1) * pace.of(1), &knobs);
        }
        assert!((pace.of(1) - (USUAL_COST / 0.012).sqrt()).abs() < 1e-3);
        assert_eq!(pace.of(0), 1.0);
        (0..40).for_each(|_| pace.learn(0, 0.0, &knobs));
        assert_eq!(pace.of(0), FASTEST);
        pace.reset();
        assert_eq!(pace.of(0), 1.0);
    }
}
