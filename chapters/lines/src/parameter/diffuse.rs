//! [`Diffuser`]: parameters carried from frame to frame without tracking (section 4.9).
//!
//! ```text
//! d      = w_s |screen|^2 + w_w |world|^2 + w_n (1 - n . n')      between two samples
//! w_d    = exp(-d)
//! y_j    = sum w_d u_k / sum w_d        sigma_j^2 = sum w_d (u_k - y_j)^2 / sum w_d
//! E      = w_diff sum (y - u)^2 + sum w_sigma (w_s (du - ds)^2 + w_w (du - r dw)^2),
//! w_sigma = exp(-sigma^2 / s^2)
//! ```
//!
//! y is the weighted mean, as the variance formula of the thesis says; world lengths dw are scaled by
//! the line's ratio r of picture to world length, so that both terms pull one u towards pixels;
//! each sample speaks for itself at the asker's place (u_k plus the way along its line), else a line's
//! end would pull. Neighbours come from a grid. Hidden parts are held together more firmly, so
//! that jumps heal where nobody looks.
//!
//! It needs no future: a frame's strokes and camera are enough. Where strokes know their material
//! points one frame later, these are used; else samples stay where they are in the world. Not
//! guaranteed: that u rises; after events it may fold, as figure 4.15 of the thesis shows.

use super::Solved;
use super::fit::Fit;
use crate::film::Film;
use crate::knob::LinesKnobs;
use crate::stroke::Stroke;
use crate::view::View;
use chiaro_basis::math::{DVec2, DVec3};
use rayon::prelude::*;

/// Standard deviation of the diffusion in the picture, and in the world seen as pixels.
const SPREAD: f64 = 3.0;
/// How much a right angle between normals counts.
const NORMAL: f64 = 2.0;
/// Samples further away than this many spreads do not matter.
const FAR: f64 = 3.0;
/// The s of w_sigma, pixels.
const VARIANCE: f64 = 10.0;
/// Weights of the diffused value for a pixel of line, and of picture and world lengths.
const DIFFUSED: f64 = 0.1;
const SCREEN: f64 = 0.6;
const WORLD: f64 = 0.4;
/// How much more firmly hidden parts are held together.
const HIDDEN: f64 = 10.0;
/// The least weight of a length term, so that every sample is held by its neighbours.
const LEAST: f64 = 1e-4;

/// Parameters of a pen, at one sample of a stroke.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Gesture {
    /// Width, in pixels: of low frequency, diffused widely.
    pub width: f64,
    /// The pen's angle in radians: of low frequency, diffused widely.
    pub angle: f64,
    /// Pressure: of high frequency, diffused closely.
    pub pressure: f64,
}

/// A sample of the frame before.
#[derive(Clone, Copy)]
struct Vertex {
    at: DVec2,
    world: DVec3,
    normal: DVec3,
    /// Along its line in the picture.
    along: DVec2,
    /// In pixels.
    u: f64,
    /// Once round its line in pixels, if it was closed.
    period: Option<f64>,
    gesture: Gesture,
}

/// What one frame hands to the next.
#[derive(Default)]
pub struct Diffuser {
    vertices: Vec<Vertex>,
    cells: Vec<Vec<u32>>,
    size: (usize, usize),
}

/// What the frame before says about a sample.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Diffused {
    /// Weighted mean of u, in pixels.
    pub mean: f64,
    /// Weighted variance, in square pixels.
    pub variance: f64,
    /// Sum of the weights: none was near where it is 0.
    pub weight: f64,
    /// Once round in pixels, where the line was closed: the mean holds up to whole turns.
    pub period: Option<f64>,
}

impl Diffused {
    /// w_sigma: how much an even spread counts here.
    pub fn trust(&self) -> f64 {
        (-self.variance / (VARIANCE * VARIANCE)).exp()
    }
}

const CELL: f64 = 12.0;

impl Diffuser {
    /// Gives the strokes of the next frame their u, in units of `pixels_per_u`, and keeps what the
    /// frame after that needs. Answers what was diffused to each sample of each stroke.
    pub fn advance(
        &mut self,
        strokes: &mut [Stroke],
        view: &View,
        pixels_per_u: f64,
    ) -> Vec<Vec<Diffused>> {
        self.place(view);
        let diffused: Vec<Vec<Diffused>> =
            strokes.par_iter().map(|s| self.diffuse(s, view)).collect();
        for (stroke, diffused) in strokes.iter_mut().zip(&diffused) {
            let u = reconstruct(stroke, diffused);
            stroke.set_u(u.into_iter().map(|u| u / pixels_per_u).collect(), pixels_per_u);
        }
        self.vertices = strokes.iter().flat_map(vertices).collect();
        diffused
    }

    /// Carries a pen's parameters to the strokes of the next frame; call it before
    /// [`Self::advance`], and [`Self::record`] after it. Width and angle are diffused three times
    /// as far as pressure. Where nothing is near, `fresh` says what the pen does.
    pub fn gestures(
        &mut self,
        strokes: &[Stroke],
        view: &View,
        fresh: impl Fn(&Stroke, usize) -> Gesture,
    ) -> Vec<Vec<Gesture>> {
        self.place(view);
        let carried = |stroke: &Stroke| {
            (0..stroke.samples.len())
                .map(|j| self.gesture(stroke, j, view).unwrap_or_else(|| fresh(stroke, j)))
                .collect()
        };
        strokes.iter().map(carried).collect()
    }

    /// Where the samples that speak for a sample of the next frame are, and how much each counts.
    pub fn weights(&mut self, stroke: &Stroke, j: usize, view: &View) -> Vec<(DVec2, f64)> {
        self.place(view);
        let asker = Asker::of(stroke, j, view);
        let mut weights = Vec::new();
        self.around(asker.at, FAR * SPREAD, |v| weights.push((v.at, asker.weight(v, SPREAD))));
        weights
    }

    /// Keeps the pen's parameters of the strokes that were advanced last.
    pub fn record(&mut self, gestures: &[Vec<Gesture>]) {
        let all = gestures.iter().flatten();
        self.vertices.iter_mut().zip(all).for_each(|(v, g)| v.gesture = *g);
    }

    /// Puts the vertices of the frame before into cells of the picture, where they are now.
    fn place(&mut self, view: &View) {
        let cells = |n: usize| (n as f64 / CELL).ceil() as usize + 2;
        self.size = (cells(view.size.0), cells(view.size.1));
        self.cells.iter_mut().for_each(Vec::clear);
        self.cells.resize(self.size.0 * self.size.1, Vec::new());
        for (i, v) in self.vertices.iter_mut().enumerate() {
            if let Some(seen) = view.see(v.world) {
                v.at = seen.at;
                let (x, y) = cell(v.at, self.size);
                self.cells[y * self.size.0 + x].push(i as u32);
            }
        }
    }

    /// Calls `tell` with each vertex within `reach` pixels of a position.
    fn around(&self, at: DVec2, reach: f64, mut tell: impl FnMut(&Vertex)) {
        let (low, high) = (cell(at - reach, self.size), cell(at + reach, self.size));
        for y in low.1..=high.1 {
            for x in low.0..=high.0 {
                for &i in &self.cells[y * self.size.0 + x] {
                    let v = &self.vertices[i as usize];
                    if v.at.distance_squared(at) <= reach * reach {
                        tell(v);
                    }
                }
            }
        }
    }

    fn diffuse(&self, stroke: &Stroke, view: &View) -> Vec<Diffused> {
        (0..stroke.samples.len()).map(|j| self.mean(stroke, j, view)).collect()
    }

    fn mean(&self, stroke: &Stroke, j: usize, view: &View) -> Diffused {
        let asker = Asker::of(stroke, j, view);
        let (mut sum, mut first, mut second) = (0.0, 0.0, 0.0);
        let (mut origin, mut period) = (None, None);
        self.around(asker.at, FAR * SPREAD, |v| {
            let w = asker.weight(v, SPREAD);
            let here = v.u + v.along.dot(asker.at - v.at);
            // Sums of squares keep their digits near the first value.
            let u = nearest_turn(here - *origin.get_or_insert(here), v.period);
            period = period.or(v.period);
            sum += w;
            first += w * u;
            second += w * u * u;
        });
        if sum < 1e-6 {
            return Diffused::default();
        }
        let mean = first / sum;
        let variance = (second / sum - mean * mean).max(0.0);
        Diffused { mean: mean + origin.unwrap_or(0.0), variance, weight: sum, period }
    }

    fn gesture(&self, stroke: &Stroke, j: usize, view: &View) -> Option<Gesture> {
        let asker = Asker::of(stroke, j, view);
        let wide = 3.0 * SPREAD;
        let (mut near, mut far) = (0.0, 0.0);
        let mut sum = Gesture::default();
        self.around(asker.at, FAR * wide, |v| {
            let (close, w) = (asker.weight(v, SPREAD), asker.weight(v, wide));
            near += close;
            far += w;
            sum.pressure += close * v.gesture.pressure;
            sum.width += w * v.gesture.width;
            sum.angle += w * v.gesture.angle;
        });
        (near > 1e-6).then(|| Gesture {
            width: sum.width / far,
            angle: sum.angle / far,
            pressure: sum.pressure / near,
        })
    }
}

/// A sample that asks its surroundings.
struct Asker {
    at: DVec2,
    world: DVec3,
    normal: DVec3,
    along: DVec2,
    /// World size of a pixel.
    pixel: f64,
}

impl Asker {
    fn of(stroke: &Stroke, j: usize, view: &View) -> Self {
        let s = &stroke.samples[j];
        let pixel = view.pixel(s.depth).max(f64::MIN_POSITIVE);
        Self { at: s.at, world: s.world, normal: s.normal, along: along(stroke, j), pixel }
    }

    /// w_d.
    fn weight(&self, v: &Vertex, spread: f64) -> f64 {
        let screen = self.at.distance_squared(v.at) / (spread * spread);
        // A contour leaves its material points in depth faster than in the picture.
        let world = self.world.distance_squared(v.world)
            / (16.0 * spread * spread * self.pixel * self.pixel);
        let bend =
            NORMAL * (1.0 - self.normal.dot(v.normal)) + NORMAL * (1.0 - self.along.dot(v.along));
        (-0.5 * (screen + world) - bend).exp()
    }
}

fn cell(at: DVec2, size: (usize, usize)) -> (usize, usize) {
    let index = |x: f64, n: usize| ((x / CELL + 1.0).max(0.0) as usize).min(n - 1);
    (index(at.x, size.0), index(at.y, size.1))
}

fn along(stroke: &Stroke, j: usize) -> DVec2 {
    let s = &stroke.samples;
    let (a, b) = (j.saturating_sub(1), (j + 1).min(s.len() - 1));
    (s[b].at - s[a].at).normalize_or_zero()
}

fn vertices(stroke: &Stroke) -> impl Iterator<Item = Vertex> + '_ {
    stroke.samples.iter().enumerate().map(|(j, s)| Vertex {
        at: s.at,
        world: s.next_world.unwrap_or(s.world),
        normal: s.normal,
        along: along(stroke, j),
        u: stroke.u[j] * stroke.pixels_per_u,
        period: stroke.u_period.map(|p| p * stroke.pixels_per_u).filter(|p| *p > 0.0),
        gesture: Gesture::default(),
    })
}

/// u of a line in pixels, from what was diffused to it.
fn reconstruct(stroke: &Stroke, diffused: &[Diffused]) -> Vec<f64> {
    let n = stroke.length.len();
    let mut fit = Fit::new(n);
    let world = |k: usize| {
        let s = &stroke.samples;
        s[k].world.distance(s[(k + 1) % s.len()].world)
    };
    let whole: f64 = (0..n - 1).map(world).sum();
    let ratio = if whole > 0.0 { stroke.total() / whole } else { 0.0 };
    let firm = if stroke.visible { 1.0 } else { HIDDEN };
    let trust = |k: usize| diffused[k % diffused.len()].trust();
    for k in 0..n - 1 {
        let ds = (stroke.length[k + 1] - stroke.length[k]).max(1e-3);
        let w = firm * trust(k).min(trust(k + 1)).max(LEAST) / ds;
        fit.step(k, ds, SCREEN * w);
        fit.step(k, ratio * world(k), WORLD * w);
    }
    let pixels = stroke.total() / n as f64;
    for (k, mean, weight) in unwound(stroke, diffused) {
        fit.value(k, 0.0, mean, DIFFUSED * pixels * weight.min(1.0));
    }
    fit.value(0, 0.0, 0.0, 1e-9);
    fit.solve()
}

/// What is left of a difference after whole turns.
fn nearest_turn(u: f64, period: Option<f64>) -> f64 {
    period.map_or(u, |p| u - (u / p).round() * p)
}

/// Sample, mean and weight of what was diffused, each mean on the turn that goes on from the one
/// before; of a loop that stays one, its first sample again once round.
fn unwound(stroke: &Stroke, diffused: &[Diffused]) -> Vec<(usize, f64, f64)> {
    let mut unwound: Vec<(usize, f64, f64)> = Vec::new();
    let mut last: Option<(f64, f64)> = None;
    for (k, d) in diffused.iter().enumerate().filter(|(_, d)| d.weight > 0.0) {
        let length = stroke.length[k];
        let mean = last.map_or(d.mean, |(mean, at)| {
            let expected = mean + length - at;
            expected + nearest_turn(d.mean - expected, d.period)
        });
        last = Some((mean, length));
        unwound.push((k, mean, d.weight));
    }
    if let (true, Some((0, mean, weight))) = (stroke.closed, unwound.first().copied()) {
        let round = diffused[0].period.map(|p| (stroke.length.len() - 1, mean + p, weight));
        unwound.extend(round);
    }
    unwound
}

/// Parameterizes a film, one frame after the other.
pub(crate) fn film(film: &mut Film, knobs: &LinesKnobs) -> Solved {
    let scale = f64::from(knobs.pattern_length);
    let mut diffuser = Diffuser::default();
    let mut unknowns = 0;
    for frame in &mut film.frames {
        if frame.begins {
            diffuser = Diffuser::default();
        }
        let seen = frame.strokes.len();
        let mut all = std::mem::take(&mut frame.strokes);
        all.append(&mut frame.hidden);
        diffuser.advance(&mut all, &frame.view, scale);
        unknowns += all.iter().map(|s| s.samples.len()).sum::<usize>();
        frame.hidden = all.split_off(seen);
        frame.strokes = all;
    }
    Solved { unknowns, ..Solved::default() }
}
