//! Neighbour weights a row at a time: the fast form of [`neighbour_factors`], for pictures.
//!
//! What each edge costs is what `geometry.rs` says, written as loops over slices that become vector
//! instructions:
//!
//! 1. Runs of covered pixels of a row are dealt to one slice a component, padded by a pixel at either
//!    end.
//! 2. One loop an edge direction yields N from differences of slices. N0 and N1 share one
//!    exponential; the angle and the normal of the midpoint share n + m.
//!
//! 3. The loop is compiled twice, for what every machine of its kind has and for the wide vectors of
//!    most; the operations are the same, and so are the bytes.
//!
//! Guaranteed: within 1e-3 of the edge-by-edge form, and the same bytes for any number of threads.
//!
//! [`neighbour_factors`]: crate::neighbour_factors

use crate::cut::rounded;
use crate::geometry::EDGES;
use crate::knob::{BinaryKnobs, DepthForm};
use chiaro_basis::math::Vec3;
use chiaro_image::filter::Means;
use chiaro_image::{Plane, Runs};
use chiaro_trace::GBuffer;
use rayon::prelude::*;
use std::f32::consts::{FRAC_1_SQRT_2, LN_2, PI};
use std::ops::Range;

/// Rows that one task works through.
const BLOCK: usize = 16;

/// Pixels whose four edges are weighed before the next ones, so that two rows stay in the cache.
const STRIP: usize = 256;

/// Weights to E, SE, S and SW relative to N~, with the mean curvature of (3.8) from Gaussian means
/// of the normals over a window of `window` pixels.
pub(crate) fn factors(
    buffer: &GBuffer,
    (means, window): (&Means, f32),
    knobs: &BinaryKnobs,
) -> Plane<[f32; 4]> {
    weighed((buffer, means, window), knobs, [0.0; 4], |factors| factors)
}

/// [`factors`] times `units`, rounded: with no plane between them, since to write one and to read it
/// again takes a tenth of the time.
pub(crate) fn capacities(
    buffer: &GBuffer,
    (means, window): (&Means, f32),
    units: [f32; 4],
    knobs: &BinaryKnobs,
) -> Plane<[i32; 4]> {
    weighed((buffer, means, window), knobs, [0; 4], |f| rounded(f, units))
}

/// What `finish` makes of the factors of each pixel, and `nothing` beside the runs of covered pixels.
fn weighed<T: Copy + Send>(
    (buffer, means, window): (&GBuffer, &Means, f32),
    knobs: &BinaryKnobs,
    nothing: T,
    finish: impl Fn([f32; 4]) -> T + Sync,
) -> Plane<T> {
    let (width, height) = buffer.size();
    let source = Source { buffer, means, raw: knobs.depth_form == DepthForm::Raw };
    let scales: [Scales; 4] = std::array::from_fn(|e| Scales::new(buffer.radius, window, e, knobs));
    let runs = Runs::of(&buffer.covered);
    let mut out = vec![nothing; width * height];
    out.par_chunks_mut(width.max(1) * BLOCK).enumerate().for_each(|(block, rows)| {
        let first = block * BLOCK;
        let (mut here, mut below) = (Row::new(width), Row::new(width));
        here.load(&source, &runs, first);
        for (y, row) in (first..).zip(rows.chunks_mut(width)) {
            below.load(&source, &runs, y + 1);
            for run in runs.row(y) {
                for start in run.clone().step_by(STRIP) {
                    let strip = start..(start + STRIP).min(run.end);
                    weigh_strip((&here, &below), &scales, start, &mut row[strip], &finish);
                }
            }
            std::mem::swap(&mut here, &mut below);
        }
    });
    Plane::from_pixels(width, height, out)
}

/// The four weights of each pixel of a strip of at most [`STRIP`], from its row and the next.
fn weigh_strip<T>(
    (here, below): (&Row, &Row),
    scales: &[Scales; 4],
    start: usize,
    strip: &mut [T],
    finish: impl Fn([f32; 4]) -> T,
) {
    let mut edges = [[0.0; STRIP]; 4];
    for (e, edge) in edges.iter_mut().enumerate() {
        let other = if EDGES[e].1 == 0 { here } else { below };
        let q = (start + 1).wrapping_add_signed(EDGES[e].0);
        weigh_widely((here, start + 1), (other, q), &scales[e], &mut edge[..strip.len()]);
    }
    let [a, b, c, d] = &edges;
    for ((((out, a), b), c), d) in strip.iter_mut().zip(a).zip(b).zip(c).zip(d) {
        *out = finish([*a, *b, *c, *d]);
    }
}

struct Source<'a> {
    buffer: &'a GBuffer,
    means: &'a Means,
    raw: bool,
}

/// A row dealt to one vector a component; entry x + 1 is pixel x.
struct Row {
    normal: [Vec<f32>; 3],
    mean: [Vec<f32>; 3],
    /// Of the tangent plane; for raw depth, (1, 0, 0).
    plane: [Vec<f32>; 3],
    /// World position; for raw depth, (distance to the eye, 0, 0).
    position: [Vec<f32>; 3],
    /// 1 where there is geometry, else 0.
    cover: Vec<f32>,
    object: Vec<u32>,
    material: Vec<u32>,
    /// Where means are summed.
    line: Vec<[f32; 4]>,
}

impl Row {
    fn new(width: usize) -> Self {
        let three = || std::array::from_fn(|_| vec![0.0; width + 2]);
        Self {
            normal: three(),
            mean: three(),
            plane: three(),
            position: three(),
            cover: vec![0.0; width + 2],
            object: vec![0; width + 2],
            material: vec![0; width + 2],
            line: Vec::new(),
        }
    }

    /// The runs of row `y`, or nothing below the picture. What is beside them stays as it was, but
    /// uncovered.
    fn load(&mut self, source: &Source, runs: &Runs, y: usize) {
        let b = source.buffer;
        self.cover.fill(0.0);
        if y >= b.size().1 {
            return;
        }
        for run in runs.row(y) {
            let to = run.start + 1..run.end + 1;
            deal(b.normal.row(y), &mut self.normal, &run);
            let mean = self.mean.each_mut().map(|part| &mut part[to.clone()]);
            source.means.row(y, run.clone(), &mut self.line, mean);
            if source.raw {
                let eye = b.pose.position;
                for x in run.clone() {
                    self.position[0][x + 1] = (Vec3::from(b.position[(x, y)]) - eye).length();
                }
                self.plane[0][to.clone()].fill(1.0);
            } else {
                deal(b.position.row(y), &mut self.position, &run);
                deal(b.geometric_normal.row(y), &mut self.plane, &run);
            }
            let cover = self.cover[to.clone()].iter_mut().zip(&b.covered.row(y)[run.clone()]);
            cover.for_each(|(cover, c)| *cover = f32::from(u8::from(*c)));
            self.object[to.clone()].copy_from_slice(&b.object.row(y)[run.clone()]);
            self.material[to].copy_from_slice(&b.material.row(y)[run]);
        }
    }
}

/// Deals a run of a row to one vector a component, a place to the right.
fn deal(row: &[[f32; 3]], [a, b, c]: &mut [Vec<f32>; 3], run: &Range<usize>) {
    let to = run.start + 1..run.end + 1;
    let (a, b, c) = (&mut a[to.clone()], &mut b[to.clone()], &mut c[to]);
    for (((v, a), b), c) in row[run.clone()].iter().zip(a).zip(b).zip(c) {
        [*a, *b, *c] = *v;
    }
}

/// What an edge's differences are divided by, and what they leave.
struct Scales {
    /// One over d R.
    depth: f32,
    /// One over k and over the pixels between the two.
    angle: f32,
    /// One over k and over the window.
    mean: f32,
    /// The mean curvature where the midpoint has no normal, over k.
    opposite: f32,
    floor: f32,
    object: f32,
    material: f32,
}

impl Scales {
    fn new(radius: f32, window: f32, edge: usize, knobs: &BinaryKnobs) -> Self {
        let k = knobs.curvature_falloff;
        let diagonal = EDGES[edge].0 != 0 && EDGES[edge].1 != 0;
        Self {
            depth: 1.0 / (radius.max(f32::MIN_POSITIVE) * knobs.depth_falloff),
            angle: if diagonal { FRAC_1_SQRT_2 } else { 1.0 } / k,
            mean: 1.0 / (window * k),
            opposite: PI / (window * k),
            floor: knobs.floor,
            object: knobs.object_edge,
            material: knobs.material_edge,
        }
    }
}

/// [`weigh`] in the widest vectors that the machine has. Not by `widely`: inside a closure it is known no longer that its
/// slices do not overlap, and it takes three times as long.
fn weigh_widely(p: (&Row, usize), q: (&Row, usize), scales: &Scales, out: &mut [f32]) {
    #[cfg(target_arch = "x86_64")]
    if std::arch::is_x86_feature_detected!("avx2") {
        #[allow(
            unsafe_code,
            reason = "weights in all fell from 63 to 56 ns a pixel; the machine was asked for what it needs"
        )]
        // SAFETY: the machine has AVX2, which is all that the function asks for.
        return unsafe { weigh_in_eights(p, q, scales, out) };
    }
    weigh(p, q, scales, out);
}

/// [`weigh`], compiled for vectors of eight.
#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
fn weigh_in_eights(p: (&Row, usize), q: (&Row, usize), scales: &Scales, out: &mut [f32]) {
    weigh(p, q, scales, out);
}

/// N of the edges between the entries of two rows, from a place in each on.
#[inline(always)]
fn weigh((p, start): (&Row, usize), (q, shift): (&Row, usize), scales: &Scales, out: &mut [f32]) {
    let n = out.len();
    let s = scales;
    fn cut(rows: &[Vec<f32>; 3], start: usize, n: usize) -> [&[f32]; 3] {
        [&rows[0][start..start + n], &rows[1][start..start + n], &rows[2][start..start + n]]
    }
    let ([nx, ny, nz], [mx, my, mz]) = (cut(&p.normal, start, n), cut(&q.normal, shift, n));
    let ([ax, ay, az], [bx, by, bz]) = (cut(&p.mean, start, n), cut(&q.mean, shift, n));
    let ([gx, gy, gz], [hx, hy, hz]) = (cut(&p.plane, start, n), cut(&q.plane, shift, n));
    let ([px, py, pz], [qx, qy, qz]) = (cut(&p.position, start, n), cut(&q.position, shift, n));
    let (pc, qc) = (&p.cover[start..start + n], &q.cover[shift..shift + n]);
    let (po, qo) = (&p.object[start..start + n], &q.object[shift..shift + n]);
    let (pm, qm) = (&p.material[start..start + n], &q.material[shift..shift + n]);
    for i in 0..n {
        let (dx, dy, dz) = (qx[i] - px[i], qy[i] - py[i], qz[i] - pz[i]);
        let off_p = (dx * gx[i] + dy * gy[i] + dz * gz[i]).abs();
        let off_q = (dx * hx[i] + dy * hy[i] + dz * hz[i]).abs();
        let depth = greater(off_p, off_q) * s.depth;

        let (ux, uy, uz) = (nx[i] - mx[i], ny[i] - my[i], nz[i] - mz[i]);
        let (vx, vy, vz) = (nx[i] + mx[i], ny[i] + my[i], nz[i] + mz[i]);
        let apart = (ux * ux + uy * uy + uz * uz).sqrt();
        let sum = (vx * vx + vy * vy + vz * vz).sqrt();
        // tan(angle / 4) is in [0, 1] for unit normals.
        let angle = 4.0 * arctangent(apart / (2.0 + sum));

        let around = vx * (ax[i] + bx[i]) + vy * (ay[i] + by[i]) + vz * (az[i] + bz[i]);
        let spread = greater(2.0 - around / greater(sum, 1e-6), 0.0).sqrt();
        let mean = if sum > 1e-6 { spread * s.mean } else { s.opposite };
        let bend = angle * s.angle - mean;

        let same = if pm[i] == qm[i] { 1.0 } else { s.material };
        let id = if po[i] == qo[i] { same } else { s.object };
        let product = id * exp_minus(depth * depth + bend * bend);
        out[i] = pc[i] * qc[i] * (s.floor + (1.0 - s.floor) * product);
    }
}

fn greater(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

/// atan(t) for t in [0, 1], to 3e-5 of its value: an odd polynomial.
fn arctangent(t: f32) -> f32 {
    let t2 = t * t;
    let tail = 0.193_543_46 + t2 * (-0.116_432_87 + t2 * (0.052_653_32 - t2 * 0.011_721_2));
    t * (0.999_977_26 + t2 * (-0.332_623_47 + t2 * tail))
}

/// exp(-s) for s >= 0, to 1e-5 of its value: two to the rounded power by its bits, the rest by a
/// polynomial.
fn exp_minus(s: f32) -> f32 {
    // Adding it rounds a number to an integer in the low bits.
    const ROUND: f32 = 12_582_912.0;
    let power = greater(s * -std::f32::consts::LOG2_E, -120.0);
    let rounded = power + ROUND;
    let rest = power - (rounded - ROUND);
    let tail = 0.055_504_11 + rest * (0.009_618_129 + rest * 0.001_333_355_8);
    let fraction = 1.0 + rest * (LN_2 + rest * (0.240_226_5 + rest * tail));
    let whole = f32::from_bits((rounded.to_bits() << 23).wrapping_add(127 << 23));
    whole * fraction
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn wide_vectors_give_the_same_bytes() {
        let n = 101;
        let noise = |seed: u64| -> Vec<f32> {
            (0..n + 2).map(|i| 2.0 * chiaro_basis::random::unit(seed, i as u64) - 1.0).collect()
        };
        let row = |s: u64| Row {
            normal: [noise(s), noise(s + 1), noise(s + 2)],
            mean: [noise(s + 3), noise(s + 4), noise(s + 5)],
            plane: [noise(s + 6), noise(s + 7), noise(s + 8)],
            position: [noise(s + 9), noise(s + 10), noise(s + 11)],
            cover: noise(s + 12).iter().map(|v| f32::from(u8::from(*v > -0.8))).collect(),
            object: noise(s + 13).iter().map(|v| u32::from(*v > 0.0)).collect(),
            material: noise(s + 14).iter().map(|v| u32::from(*v > 0.0)).collect(),
            line: Vec::new(),
        };
        let (p, q) = (row(1), row(50));
        for edge in 0..4 {
            let scales = Scales::new(3.0, 5.0, edge, &BinaryKnobs::default());
            let (mut wide, mut plain) = (vec![0.0; n], vec![0.0; n]);
            weigh_widely((&p, 1), (&q, 2), &scales, &mut wide);
            weigh((&p, 1), (&q, 2), &scales, &mut plain);
            assert_eq!(wide, plain);
        }
    }

    #[test]
    fn the_polynomials_are_close() {
        for i in 0..=4000 {
            let s = i as f32 * 0.02;
            let exact = (-s).exp();
            assert!((exp_minus(s) - exact).abs() <= 1e-5 * exact, "{s}");
            let t = i as f32 / 4000.0;
            assert!((arctangent(t) - t.atan()).abs() <= 3e-5 * t, "{t}");
        }
        assert!(exp_minus(f32::INFINITY) < 1e-35);
    }
}
