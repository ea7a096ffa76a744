//! Flat faces: one tone, one weight, whatever stands beside it.
//!
//! A flat face in perspective has nearly one tone, and its local average (3.3) still changes towards
//! faces that are darker or lighter: A' (3.4) then parts it in two where there is nothing to see. So
//! W - B is averaged over the pixels of a flat face that have nearly one tone, as far as that stands
//! out among the face's tones. Shadows and hollows do not mix with what is lit, and slow gradients,
//! where what is dark for its place is to be seen, stay as they are, but for one thing: on one face
//! what is lighter does not pull more to black. Where the mean weight falls as tones rise, beside
//! something light, it is raised or lowered to the nearest means that do not (isotonic regression).

use crate::knob::scaled;
use chiaro_basis::math::smoothstep;
use chiaro_basis::{Sets, isotonic};
use chiaro_image::Plane;
use chiaro_trace::GBuffer;
use rayon::prelude::*;
use std::ops::Range;

/// Differences between normals of one plane, and how far it may be missed, in parts of R.
const SAME: f32 = 1e-3;
const SAME_PLANE: f32 = 2e-4;
/// By how much a shading normal may leave its plane and be wholly flat, and be flat at all.
const FLAT: f32 = 0.01;
const ROUND: f32 = 0.05;
/// The share of a face that must be flat, and of what stands around a tone that must be near it, for a
/// pixel to be evened at all, and to be so wholly.
const LEAST_SHARE: f32 = 0.6;
const FULL_SHARE: f32 = 0.9;
/// Tones that count as one, wholly and at all, and those among which they must stand out.
const ONE: [f32; 2] = [0.06, 0.15];
const AROUND: [f32; 2] = [0.16, 0.26];
/// Tones are told apart in as many steps.
const BINS: usize = 32;
/// The shortest piece of a row and the smallest face that count, pixels and square pixels at 480.
const SHORTEST: f32 = 3.0;
const SMALLEST: f32 = 30.0;
/// Bands of rows that are summed by themselves.
const BANDS: usize = 8;

/// The most pixels from one sample to the next.
const MOST: usize = 6;

/// The flat faces of a picture, in parts of rows of samples; a sample stands for a square of pixels,
/// of which few tones of another face do no harm.
pub(crate) struct Flats {
    rows: Vec<Vec<Part>>,
    /// The side of that square.
    side: usize,
    /// How much each face is evened, in [0, 1].
    shares: Vec<f32>,
}

/// Samples of a row that lie on one face.
struct Part {
    samples: Range<usize>,
    /// The sum of their flatness.
    flat: f32,
    face: usize,
}

/// The samples of a face by tone: the sums of their weights, and how many they are.
type Bins = [[f32; 2]; BINS];

/// What becomes of a weight at a tone: a share of it that stays, and what is added.
type Evened = [[f32; 2]; BINS];

impl Flats {
    /// Those of a picture.
    pub(crate) fn of(buffer: &GBuffer) -> Self {
        let height = buffer.size().1;
        let side = (scaled(1.5, height) as usize).clamp(1, MOST);
        let size = scaled(1.0, height) / side as f32;
        let plan = Plan { buffer, side, shortest: (SHORTEST * size).max(2.0) as usize };
        let down = height.div_ceil(side);
        let mut rows: Vec<Vec<Part>> = (0..down).into_par_iter().map(|y| plan.row(y)).collect();
        let mut sets = Sets::default();
        rows.iter_mut().flatten().for_each(|part| part.face = sets.add());
        for (y, pair) in rows.windows(2).enumerate() {
            let (upper, lower) = (plan.samples(y), plan.samples(y + 1));
            let mut below = pair[1].as_slice();
            for part in &pair[0] {
                let passed =
                    below.iter().take_while(|b| b.samples.end <= part.samples.start).count();
                below = &below[passed..];
                for other in below.iter().take_while(|b| b.samples.start < part.samples.end) {
                    let from = part.samples.start.max(other.samples.start);
                    let to = part.samples.end.min(other.samples.end);
                    let goes_on = |x| upper.is_one_plane(x, &lower, x);
                    let is_apart = sets.root(part.face) != sets.root(other.face);
                    if is_apart && (from..to).any(goes_on) {
                        sets.join(part.face, other.face);
                    }
                }
            }
        }
        let shares = numbered(&mut rows, &mut sets, SMALLEST * size * size);
        Self { rows, side, shares }
    }

    /// The side of the square that a sample stands for, in pixels.
    pub(crate) fn side(&self) -> usize {
        self.side
    }

    /// How many rows of samples there are.
    pub(crate) fn len(&self) -> usize {
        self.rows.len()
    }

    /// Which samples of a row lie on which face, from left to right.
    pub(crate) fn parts(&self, y: usize) -> impl Iterator<Item = (Range<usize>, usize)> {
        self.rows[y].iter().map(|part| (part.samples.clone(), part.face))
    }

    /// Averages weights over the pixels of each face that have nearly one tone, in [0, 1].
    pub(crate) fn even(&self, weights: &mut Plane<f32>, tone: &Plane<f32>) {
        let kernel = kernel();
        let bins = self.bins(weights, tone);
        let faces = bins.par_iter().zip(&self.shares);
        let faces: Vec<Evened> = faces.map(|(bins, share)| evened(bins, *share, &kernel)).collect();
        let width = weights.width().max(1);
        let rows = weights.pixels_mut().par_chunks_mut(width).enumerate();
        rows.for_each(|(y, weights)| {
            for part in &self.rows[y / self.side] {
                let face = &faces[part.face];
                let pixels =
                    part.samples.start * self.side..(part.samples.end * self.side).min(width);
                let tones = &tone.row(y)[pixels.clone()];
                for (weight, tone) in weights[pixels].iter_mut().zip(tones) {
                    let [kept, added] = looked_up(face, *tone);
                    *weight = kept * *weight + added;
                }
            }
        });
    }

    /// The samples of each face by tone.
    fn bins(&self, weights: &Plane<f32>, tone: &Plane<f32>) -> Vec<Bins> {
        let height = self.rows.len();
        let band = |band: usize| {
            let mut bins = vec![[[0.0; 2]; BINS]; self.shares.len()];
            for y in band * height / BANDS..(band + 1) * height / BANDS {
                for part in &self.rows[y] {
                    let bins = &mut bins[part.face];
                    for x in part.samples.clone() {
                        let p = (x * self.side, y * self.side);
                        let step = (tone[p] * (BINS - 1) as f32 + 0.5) as usize;
                        let bin = &mut bins[step.min(BINS - 1)];
                        *bin = [bin[0] + weights[p], bin[1] + 1.0];
                    }
                }
            }
            bins
        };
        let bands: Vec<Vec<Bins>> = (0..BANDS).into_par_iter().map(band).collect();
        let mut bands = bands.into_iter();
        let mut all = bands.next().unwrap_or_default();
        for band in bands {
            let pairs = all.as_flattened_mut().iter_mut().zip(band.as_flattened());
            pairs.for_each(|(sum, part)| *sum = [sum[0] + part[0], sum[1] + part[1]]);
        }
        all
    }
}

/// Gives the faces that count numbers, and drops the others; how flat each is.
fn numbered(rows: &mut [Vec<Part>], sets: &mut Sets, smallest: f32) -> Vec<f32> {
    let mut sums = vec![[0.0f32; 2]; sets.len()];
    for part in rows.iter_mut().flatten() {
        part.face = sets.root(part.face);
        let sum = &mut sums[part.face];
        *sum = [sum[0] + part.flat, sum[1] + part.samples.len() as f32];
    }
    let mut shares = Vec::new();
    let numbers: Vec<Option<usize>> = sums
        .iter()
        .map(|[flat, all]| {
            let share = share(flat / all);
            (*all >= smallest && share > 0.0).then(|| {
                shares.push(share);
                shares.len() - 1
            })
        })
        .collect();
    for parts in rows {
        parts.retain_mut(|part| {
            let number = numbers[part.face];
            part.face = number.unwrap_or(0);
            number.is_some()
        });
    }
    shares
}

/// How much tones a number of steps apart count together: as one, and as those around it.
fn kernel() -> [[f32; 2]; BINS] {
    std::array::from_fn(|apart| {
        let apart = apart as f32 / (BINS - 1) as f32;
        [ONE, AROUND].map(|[near, far]| smoothstep([far, near], apart))
    })
}

/// Adds what means need not to fall as tones rise, then goes to means over tones that count as one, as
/// far as those stand out.
fn evened(sums: &Bins, whole: f32, kernel: &[[f32; 2]; BINS]) -> Evened {
    let full: Vec<usize> = (0..BINS).filter(|i| sums[*i][1] > 0.0).collect();
    let means = full.iter().map(|i| (f64::from(sums[*i][0] / sums[*i][1]), f64::from(sums[*i][1])));
    let (mut risen, mut added) = (*sums, [0.0; BINS]);
    for (&i, mean) in full.iter().zip(isotonic(means)) {
        let [sum, count] = sums[i];
        risen[i][0] = mean as f32 * count;
        // A tone lies between two steps, one of which may be empty.
        for near in i.saturating_sub(1)..(i + 2).min(BINS) {
            if near == i || sums[near][1] == 0.0 {
                added[near] = mean as f32 - sum / count;
            }
        }
    }
    let mut evened = [[1.0, 0.0]; BINS];
    for (i, bin) in evened.iter_mut().enumerate() {
        // Between steps that are empty nothing is looked up.
        if sums[i.saturating_sub(1)..(i + 2).min(BINS)].iter().all(|sum| sum[1] == 0.0) {
            continue;
        }
        let (mut weight, mut one, mut around) = (0.0, 0.0, 0.0);
        for &j in &full {
            let ([near, wide], [sum, count]) = (kernel[i.abs_diff(j)], risen[j]);
            weight += near * sum;
            one += near * count;
            around += wide * count;
        }
        let (mean, taken) = (weight / one.max(1e-6), share(one / around.max(1e-6)));
        *bin = [1.0 - whole * taken, whole * (added[i] + taken * (mean - added[i]))];
    }
    evened
}

/// What becomes of a weight at a tone, between its two steps.
#[inline(always)]
fn looked_up(bins: &Evened, tone: f32) -> [f32; 2] {
    let at = tone * (BINS - 1) as f32;
    let i = (at as usize).min(BINS - 2);
    let (a, b) = (bins[i], bins[i + 1]);
    let t = at - i as f32;
    [0, 1].map(|k| a[k] + t * (b[k] - a[k]))
}

/// How much is made of a share of pixels.
fn share(of: f32) -> f32 {
    smoothstep([LEAST_SHARE, FULL_SHARE], of)
}

/// How rows are parted.
struct Plan<'a> {
    buffer: &'a GBuffer,
    /// Pixels from one sample to the next.
    side: usize,
    /// The fewest samples of a part.
    shortest: usize,
}

impl Plan<'_> {
    fn samples(&self, y: usize) -> Row<'_> {
        Row::of(self.buffer, y * self.side, self.side)
    }

    fn row(&self, y: usize) -> Vec<Part> {
        let here = self.samples(y);
        let (shading, covered) = (
            self.buffer.normal.row(y * self.side).iter().step_by(self.side),
            self.buffer.covered.row(y * self.side).iter().step_by(self.side),
        );
        let mut parts: Vec<Part> = Vec::new();
        let mut part = Part { samples: 0..0, flat: 0.0, face: 0 };
        for (x, (n, covered)) in shading.zip(covered).enumerate() {
            if !covered {
                continue;
            }
            let goes_on = x > 0 && part.samples.end == x && here.is_one_plane(x - 1, &here, x);
            if !goes_on {
                if part.samples.len() >= self.shortest {
                    parts.push(part);
                }
                part = Part { samples: x..x, flat: 0.0, face: 0 };
            }
            part.samples.end = x + 1;
            let flat = (ROUND - apart(*n, here.normal[x * self.side])) / (ROUND - FLAT);
            part.flat += flat.clamp(0.0, 1.0);
        }
        if part.samples.len() >= self.shortest {
            parts.push(part);
        }
        parts
    }
}

/// What a row of samples shows.
struct Row<'a> {
    side: usize,
    normal: &'a [[f32; 3]],
    position: &'a [[f32; 3]],
    object: &'a [u32],
    material: &'a [u32],
    /// How far a plane may be missed.
    miss: f32,
}

impl<'a> Row<'a> {
    fn of(buffer: &'a GBuffer, y: usize, side: usize) -> Self {
        Self {
            side,
            normal: buffer.geometric_normal.row(y),
            position: buffer.position.row(y),
            object: buffer.object.row(y),
            material: buffer.material.row(y),
            miss: SAME_PLANE * buffer.radius,
        }
    }

    /// Whether two covered samples, of this row and of another, show one plane of one thing.
    #[inline(always)]
    fn is_one_plane(&self, x: usize, other: &Self, u: usize) -> bool {
        let (x, u) = (x * self.side, u * self.side);
        let (n, m) = (self.normal[x], other.normal[u]);
        let (a, b) = (self.position[x], other.position[u]);
        let step = (b[0] - a[0]) * n[0] + (b[1] - a[1]) * n[1] + (b[2] - a[2]) * n[2];
        (apart(n, m) < SAME)
            & (step.abs() <= self.miss)
            & (self.object[x] == other.object[u])
            & (self.material[x] == other.material[u])
    }
}

/// The greatest difference of two vectors' components.
#[inline(always)]
fn apart(a: [f32; 3], b: [f32; 3]) -> f32 {
    (a[0] - b[0]).abs().max((a[1] - b[1]).abs()).max((a[2] - b[2]).abs())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::appearance::{Channel, Channels};
    use crate::{BinaryKnobs, Exposure, View, terminal};
    use chiaro_basis::math::Vec3;
    use chiaro_scene::{Pose, Projection};

    /// A floor before a wall, seen from above, both flat, with this tone.
    fn corner(tone: impl Fn(usize, usize) -> f32 + Sync) -> View {
        let (w, h) = (120, 80);
        let projection = Projection::Orthographic { half_height: 40.0 };
        let pose = Pose::look_at(Vec3::new(0.0, 50.0, 50.0), Vec3::ZERO, Vec3::Y, projection);
        let mut buffer = GBuffer::empty(&pose, 50.0, (w, h));
        buffer.covered = Plane::filled(w, h, true);
        buffer.object = Plane::filled(w, h, 1);
        buffer.material = Plane::filled(w, h, 1);
        buffer.position = Plane::from_fn(w, h, |x, y| {
            let up = 40.0 - y as f32;
            [x as f32, up.max(0.0), (-up).max(0.0)]
        });
        buffer.normal =
            Plane::from_fn(w, h, |_, y| if y < 40 { [0., 0., 1.] } else { [0., 1., 0.] });
        buffer.geometric_normal = buffer.normal.clone();
        let channels = Channels::single(Channel::Half, Plane::from_fn(w, h, tone));
        View { buffer, channels }
    }

    fn weights(view: &View) -> Plane<f32> {
        terminal(view, &Exposure::default(), &BinaryKnobs::default())
    }

    #[test]
    fn a_flat_face_beside_a_dark_one_is_of_one_weight() {
        let plain = |_, y: usize| if y < 40 { 0.2 } else { 0.5 };
        let floor = weights(&corner(plain));
        let floor = &floor.pixels()[40 * 120..];
        assert!(floor.iter().all(|d| (d - floor[0]).abs() < 1e-5));
        // The same tones on round things keep the edge that local contrast gives them.
        let mut round = corner(plain);
        round.buffer.normal = Plane::filled(120, 80, [0.6, 0.8, 0.0]);
        let round = weights(&round);
        assert!(round[(60, 40)] > round[(60, 78)] + 0.1);
    }

    #[test]
    fn a_soft_shadow_on_a_flat_face_is_of_one_weight() {
        // A quarter of all tones darker than what is lit.
        let tone = |x: usize, y: usize| match (x < 60, y < 40) {
            (_, true) => 0.55,
            (true, _) => 0.3 + 0.0004 * x as f32,
            _ => 0.57,
        };
        let found = weights(&corner(tone));
        let shadow: Vec<f32> = (0..60).map(|x| found[(x, 60)]).collect();
        let least = shadow.iter().copied().fold(f32::MAX, f32::min);
        let most = shadow.iter().copied().fold(f32::MIN, f32::max);
        assert!(most - least < 0.05, "{least} to {most}");
    }

    #[test]
    fn shadows_and_slow_gradients_on_a_flat_face_stay() {
        let is_shadow = |x: usize, y: usize| (30..50).contains(&x) && (50..70).contains(&y);
        let shadowed = weights(&corner(|x, y| if is_shadow(x, y) { 0.3 } else { 0.8 }));
        assert!(shadowed[(40, 60)] < -0.1 && shadowed[(90, 60)] > 0.1);
        let rising = weights(&corner(|x, _| x as f32 / 120.0));
        assert!(rising[(110, 60)] > rising[(10, 60)] + 0.25);
    }

    #[test]
    fn lighter_strips_beside_light_things_are_no_darker() {
        // A floor that gets lighter towards a white wall, whose light makes its edge look dark.
        let tone = |_, y: usize| if y < 40 { 1.0 } else { 0.8 - 0.006 * (y - 40) as f32 };
        let mut view = corner(tone);
        let dip = |view: &View| {
            let weights = weights(view);
            (42..60).map(|y| weights[(60, y)]).fold(f32::MIN, f32::max) - weights[(60, 41)]
        };
        let flat = dip(&view);
        view.buffer.normal = Plane::filled(120, 80, [0.6, 0.8, 0.0]);
        let round = dip(&view);
        assert!(round > 0.05 && flat < 0.5 * round, "{round} {flat}");
    }

    #[test]
    fn steps_between_parallel_planes_part_faces() {
        let mut view = corner(|_, y| if y < 60 { 0.4 } else { 0.4 + 0.015 });
        let whole = weights(&view);
        assert!((whole[(5, 45)] - whole[(5, 75)]).abs() < 1e-5);
        for y in 60..80 {
            for x in 0..120 {
                view.buffer.position[(x, y)][1] = -3.0;
            }
        }
        let stairs = weights(&view);
        assert!(stairs[(5, 75)] > stairs[(5, 45)] + 0.005);
    }
}
