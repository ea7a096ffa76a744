//! Shadows on flat faces in styles of local contrast: one label, not a rim.
//!
//! Local contrast (3.3) speaks along a shadow's edge alone; far inside, a pixel is as light as what
//! stands around it, and where the global tone has little to say a shadow would be a strip along its
//! own edge. Tones that step on a flat face part it into patches, and what is undecided inside a patch
//! goes with its edge: with the mean of its weights, each counted as often as it is strong, as far as
//! the patch is lighter or darker than those beside it.

use crate::flat::Flats;
use crate::knob::scaled;
use chiaro_basis::Sets;
use chiaro_basis::math::smoothstep;
use chiaro_image::Plane;
use std::ops::Range;

/// The shares of global tone between which this sets in.
const GLOBAL: [f32; 2] = [0.3, 0.15];
/// Steps of tone from one sample to the next that part patches.
const STEP: f32 = 0.06;
/// The smallest patch that counts, square pixels at 480.
const SMALLEST: f32 = 100.0;

/// Lets the edges of patches of flat faces decide what is undecided inside; `global` is the share of
/// global tone in the weights.
pub(crate) fn decide(flats: &Flats, weights: &mut Plane<f32>, tone: &Plane<f32>, global: f32) {
    let share = smoothstep(GLOBAL, global);
    if share == 0.0 {
        return;
    }
    let patches = Patches::of(flats, tone);
    let pulls = patches.pulls(weights, tone);
    let (width, side) = (weights.width(), flats.side());
    for y in 0..weights.height() {
        let row = &mut weights.pixels_mut()[y * width..(y + 1) * width];
        for span in &patches.rows[y / side] {
            let pull = share * pulls[span.patch];
            if pull != 0.0 {
                let pixels = span.samples.start * side..(span.samples.end * side).min(width);
                row[pixels].iter_mut().for_each(|w| *w = pulled(*w, pull));
            }
        }
    }
}

/// A weight with what its patch pulls it by: all of that where it says nothing, none where it is as
/// strong itself, to whichever side.
fn pulled(weight: f32, pull: f32) -> f32 {
    weight + pull * (1.0 - (weight / pull).abs()).max(0.0)
}

/// Samples of a row that lie in one patch.
struct Span {
    samples: Range<usize>,
    face: usize,
    patch: usize,
}

/// The patches of flat faces, by rows of samples.
struct Patches {
    rows: Vec<Vec<Span>>,
    side: usize,
    count: usize,
    smallest: f32,
}

/// What is added up over a patch.
#[derive(Clone, Copy, Default)]
struct Sum {
    samples: f64,
    /// The sizes of weights, and their squares with the weights' signs.
    sizes: f64,
    squares: f64,
    /// Neighbours across steps, and by how much the patch is lighter than they are.
    beside: f64,
    lighter: f64,
}

impl Patches {
    fn of(flats: &Flats, tone: &Plane<f32>) -> Self {
        let side = flats.side();
        let at = |x: usize, y: usize| tone[(x * side, y * side)];
        let mut sets = Sets::default();
        let mut rows: Vec<Vec<Span>> = Vec::new();
        for y in 0..flats.len() {
            let mut spans: Vec<Span> = Vec::new();
            for (samples, face) in flats.parts(y) {
                let mut start = samples.start;
                for x in samples.clone() {
                    let ends = x + 1 == samples.end || (at(x + 1, y) - at(x, y)).abs() > STEP;
                    if ends {
                        spans.push(Span { samples: start..x + 1, face, patch: sets.add() });
                        start = x + 1;
                    }
                }
            }
            if let Some(above) = rows.last() {
                let joins = |x: usize| (at(x, y) - at(x, y - 1)).abs() <= STEP;
                meetings(above, &spans, |upper, lower, mut shared| {
                    if shared.any(joins) {
                        sets.join(upper, lower);
                    }
                });
            }
            rows.push(spans);
        }
        rows.iter_mut().flatten().for_each(|span| span.patch = sets.root(span.patch));
        let size = scaled(1.0, tone.height()) / side as f32;
        Self { rows, side, count: sets.len(), smallest: SMALLEST * size * size }
    }

    /// Where to each patch's edge pulls its inside.
    fn pulls(&self, weights: &Plane<f32>, tone: &Plane<f32>) -> Vec<f32> {
        let mut sums = vec![Sum::default(); self.count];
        for (y, spans) in self.rows.iter().enumerate() {
            let y = y * self.side;
            let tones = |x: usize| f64::from(tone[(x * self.side, y)]);
            for span in spans {
                let sum = &mut sums[span.patch];
                sum.samples += span.samples.len() as f64;
                for x in span.samples.clone() {
                    let weight = f64::from(weights[(x * self.side, y)]);
                    sum.sizes += weight.abs();
                    sum.squares += weight * weight.abs();
                }
            }
            for pair in spans.windows(2) {
                let [a, b] = [&pair[0], &pair[1]];
                if a.samples.end == b.samples.start && a.face == b.face {
                    let step = tones(b.samples.start) - tones(a.samples.end - 1);
                    across(&mut sums, [a.patch, b.patch], [1.0, step]);
                }
            }
        }
        for (y, pair) in self.rows.windows(2).enumerate() {
            let step = |x: usize| {
                let [above, below] = [y, y + 1].map(|y| tone[(x * self.side, y * self.side)]);
                f64::from(below - above)
            };
            meetings(&pair[0], &pair[1], |upper, lower, shared| {
                if upper != lower {
                    let length = shared.len() as f64;
                    across(&mut sums, [upper, lower], [length, shared.map(step).sum()]);
                }
            });
        }
        sums.iter().map(|sum| sum.pull(self.smallest)).collect()
    }
}

/// Adds that one patch lies beside another, so long, with the sum of steps from one to the other.
fn across(sums: &mut [Sum], [a, b]: [usize; 2], [length, step]: [f64; 2]) {
    for (patch, lighter) in [(a, -step), (b, step)] {
        sums[patch].beside += length;
        sums[patch].lighter += lighter;
    }
}

/// Where spans of a row lie over spans of the next one, on the same face.
fn meetings(above: &[Span], below: &[Span], mut each: impl FnMut(usize, usize, Range<usize>)) {
    let mut rest = below;
    for upper in above {
        let passed = rest.iter().take_while(|b| b.samples.end <= upper.samples.start).count();
        rest = &rest[passed..];
        for lower in rest.iter().take_while(|b| b.samples.start < upper.samples.end) {
            if lower.face == upper.face {
                let start = upper.samples.start.max(lower.samples.start);
                each(upper.patch, lower.patch, start..upper.samples.end.min(lower.samples.end));
            }
        }
    }
}

impl Sum {
    fn pull(&self, smallest: f32) -> f32 {
        if self.samples < f64::from(smallest) || self.sizes == 0.0 || self.beside == 0.0 {
            return 0.0;
        }
        let mean = self.squares / self.sizes;
        if mean * self.lighter <= 0.0 {
            return 0.0;
        }
        let edge = (self.beside / self.samples.sqrt()).min(1.0);
        (edge * mean) as f32
    }
}

#[cfg(test)]
mod tests {
    use crate::appearance::{Channel, Channels};
    use crate::{BinaryKnobs, Exposure, View, terminal};
    use chiaro_basis::math::Vec3;
    use chiaro_image::Plane;
    use chiaro_scene::{Pose, Projection};
    use chiaro_trace::GBuffer;

    /// A floor from above with this tone.
    fn floor(tone: impl Fn(usize, usize) -> f32 + Sync) -> View {
        let (w, h) = (120, 80);
        let projection = Projection::Orthographic { half_height: 40.0 };
        let pose = Pose::look_at(Vec3::new(0.0, 50.0, 0.0), Vec3::ZERO, Vec3::NEG_Z, projection);
        let mut buffer = GBuffer::empty(&pose, 50.0, (w, h));
        buffer.covered = Plane::filled(w, h, true);
        buffer.position = Plane::from_fn(w, h, |x, y| [x as f32, 0.0, y as f32]);
        buffer.normal = Plane::filled(w, h, [0.0, 1.0, 0.0]);
        buffer.geometric_normal = buffer.normal.clone();
        let channels = Channels::single(Channel::Half, Plane::from_fn(w, h, tone));
        View { buffer, channels }
    }

    #[test]
    fn a_shadow_in_local_contrast_is_dark_to_its_middle() {
        let is_shadow = |x: usize, y: usize| (30..90).contains(&x) && (20..60).contains(&y);
        // Both sides of the shadow's edge are over the threshold, and the floor gets darker.
        let tone = |x: usize, y: usize| {
            let slow = 0.002 * y as f32;
            if is_shadow(x, y) { 0.55 + slow } else { 0.8 + slow }
        };
        let view = floor(tone);
        let at = |global: f32| {
            let knobs = BinaryKnobs { global, local_radius: 6.0 * 6.0, ..BinaryKnobs::default() };
            let weights = terminal(&view, &Exposure::default(), &knobs);
            [weights[(60, 40)], weights[(34, 40)], weights[(10, 40)]]
        };
        let [inside, edge, lit] = at(0.1);
        assert!(edge < 0.0 && inside < 0.0 && lit > 0.0, "{edge} {inside} {lit}");
        let [inside, _, _] = at(0.35);
        assert!(inside > 0.0, "where the global tone counts it decides: {inside}");
    }
}
