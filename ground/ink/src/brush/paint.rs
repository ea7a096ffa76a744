//! Strokes to pixels: in tiles, each stroke's coverage first, then its ink over what is there.
//!
//! 1. Every stroke becomes ribbons, every ribbon mitred pieces; pieces are sorted into tiles.
//! 2. In a tile the bands of lines that hide others are laid down: rims of paper, and haloes as the
//!    depths of the nearest bands.
//! 3. Stroke after stroke, the piece of a ribbon inside whose border a pixel lies deepest has it, so that no
//!    joint, bend or crossing of a stroke with itself is darker. Ribbons of one stroke (hairs, passes) are apart:
//!    two that share a pixel cover what either leaves free. What lies behind a halo is left out.
//!
//! A pixel depends on the strokes and their order alone, not on threads.

use super::grain::{Inking, Place};
use super::halo::hides;
use super::knob::{Brush, Mark};
use super::marks::{band, ribbons};
use super::noise::Axis;
use super::ribbon::Ribbon;
use super::spine::Spine;
use super::strip::{Hit, Piece, pieces};
use super::texture::Texture;
use crate::Colour;
use chiaro_basis::math::Vec2;
use chiaro_image::Plane;
use rayon::prelude::*;

/// Pixels on a tile's side.
const TILE: usize = 64;
/// A line is behind a halo if it is deeper by this, in pixels; by twice that it is gone.
pub(super) const BEHIND: f32 = 6.0;

/// A stroke with its brush.
#[derive(Clone, Copy, Debug)]
pub struct Stroke<'a> {
    /// Its middle.
    pub spine: &'a Spine,
    /// What draws it.
    pub brush: &'a Brush,
    /// The picture of the brush, if it has one.
    pub texture: Option<&'a Texture>,
    /// Its colour, sRGB-encoded.
    pub colour: Colour,
    /// Whether it hides what is behind it, and so may have halo and rim.
    pub hides: bool,
    /// Whether what it hides is on its right alone.
    pub right: bool,
}

/// Strokes over a picture, both sRGB-encoded with opacity apart; rims have the colour of `paper`.
pub fn paint(strokes: &[Stroke<'_>], beneath: &Plane<[f32; 4]>, paper: Colour) -> Plane<[f32; 4]> {
    let (w, h) = beneath.size();
    let ready: Vec<Ready<'_>> = strokes.par_iter().map(Ready::of).collect();
    let across = w.div_ceil(TILE);
    let tiles = sorted(&ready, (w, h));
    let done: Vec<Vec<[f32; 4]>> = tiles
        .par_iter()
        .enumerate()
        .map(|(i, found)| {
            let corner = (TILE * (i % across), TILE * (i / across));
            Tile::new(corner, beneath).painted(&ready, found, paper)
        })
        .collect();
    Plane::from_fn(w, h, |x, y| done[y / TILE * across + x / TILE][y % TILE * TILE + x % TILE])
}

/// A stroke, cut up.
struct Ready<'a> {
    stroke: &'a Stroke<'a>,
    strips: Vec<Strip>,
    /// What hides others: its pieces, and how far over the line its halo and its rim reach.
    band: Option<(Vec<Piece>, [f32; 2])>,
}

/// A ribbon, cut up.
pub(super) struct Strip {
    pub(super) pieces: Vec<Piece>,
    pub(super) erases: bool,
    pub(super) axis: Axis,
    length: f32,
    /// u at both ends.
    ends: [f64; 2],
}

impl Strip {
    pub(super) fn of(r: &Ribbon) -> Self {
        let length = r.ribs.windows(2).map(|w| w[0].at.distance(w[1].at)).sum();
        let ends = [r.ribs.first(), r.ribs.last()].map(|r| r.map_or(0.0, |r| r.u));
        Self { pieces: pieces(r), erases: r.erases, axis: r.axis, length, ends }
    }
}

impl<'a> Ready<'a> {
    fn of(stroke: &'a Stroke<'a>) -> Self {
        let strips = ribbons(stroke.brush, stroke.spine).iter().map(Strip::of).collect();
        let reach = [stroke.brush.halo, stroke.brush.rim];
        let wanted = stroke.hides && reach.iter().any(|r| *r > 0.0);
        let band = wanted.then(|| (pieces(&band(stroke.brush, stroke.spine)), reach));
        Self { stroke, strips, band }
    }
}

/// Pieces that touch a tile: stroke, strip, piece.
#[derive(Clone, Debug, Default)]
struct Found {
    ink: Vec<[u32; 3]>,
    bands: Vec<[u32; 2]>,
}

/// The pieces of every tile, in the order of the strokes.
fn sorted(ready: &[Ready<'_>], (w, h): (usize, usize)) -> Vec<Found> {
    let (columns, rows) = (w.div_ceil(TILE), h.div_ceil(TILE));
    let mut tiles = vec![Found::default(); columns * rows];
    let touched = |[low, high]: [Vec2; 2]| {
        let span = |low: f32, high: f32, count: usize| {
            let tile = |v: f32| (v / TILE as f32).floor().clamp(-1.0, count as f32) as isize;
            tile(low).max(0) as usize..(tile(high) + 1).clamp(0, count as isize) as usize
        };
        let (xs, ys) = (span(low.x, high.x, columns), span(low.y, high.y, rows));
        ys.flat_map(move |y| xs.clone().map(move |x| y * columns + x))
    };
    for (s, stroke) in ready.iter().enumerate() {
        for (r, strip) in stroke.strips.iter().enumerate() {
            for (p, piece) in strip.pieces.iter().enumerate() {
                touched(piece.bounds(0.0))
                    .for_each(|t| tiles[t].ink.push([s as u32, r as u32, p as u32]));
            }
        }
        if let Some((pieces, reach)) = &stroke.band {
            for (p, piece) in pieces.iter().enumerate() {
                touched(piece.bounds(reach[0].max(reach[1])))
                    .for_each(|t| tiles[t].bands.push([s as u32, p as u32]));
            }
        }
    }
    tiles
}

/// Depth and coverage of the nearest bands over a pixel. The band of a line itself is one of them, and at the edge of
/// a nearer one's halo must not take its place: the edge would be a staircase.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Fronts([[f32; 2]; 3]);

impl Default for Fronts {
    fn default() -> Self {
        Self([[f32::INFINITY, 0.0]; 3])
    }
}

impl Fronts {
    /// Adds a band; those at one depth are one, and the farthest gives way.
    fn lay(&mut self, depth: f32, cover: f32) {
        if cover <= 0.0 {
            return;
        }
        let Self(fronts) = self;
        if let Some(same) = fronts.iter_mut().find(|f| (f[0] - depth).abs() <= BEHIND) {
            if cover > same[1] || (cover == same[1] && depth < same[0]) {
                *same = [depth, cover];
            }
        } else if let Some(last) = fronts.iter_mut().max_by(|a, b| a[0].total_cmp(&b[0]))
            && depth < last[0]
        {
            *last = [depth, cover];
        }
    }

    /// The share that is hidden of what is at a depth.
    fn hidden(&self, depth: f32) -> f32 {
        let by = |[front, cover]: &[f32; 2]| {
            let t = ((depth - front) / BEHIND - 1.0).clamp(0.0, 1.0);
            cover * t * t * (3.0 - 2.0 * t)
        };
        self.0.iter().map(by).fold(0.0, f32::max)
    }
}

/// A square of the picture under work.
struct Tile {
    corner: (usize, usize),
    pixels: Vec<[f32; 4]>,
    cover: Vec<f32>,
    depth: Vec<f32>,
    /// Coverage and depth by one ribbon and how far inside its border, and where it covers at all.
    own: Vec<[f32; 3]>,
    touched: Vec<usize>,
    /// Where bands hide what is behind them.
    front: Vec<Fronts>,
}

impl Tile {
    fn new(corner: (usize, usize), beneath: &Plane<[f32; 4]>) -> Self {
        let pixel = |i: usize| {
            let (x, y) = (corner.0 + i % TILE, corner.1 + i / TILE);
            beneath.at(x as isize, y as isize).copied().unwrap_or_default()
        };
        Self {
            corner,
            pixels: (0..TILE * TILE).map(pixel).collect(),
            cover: vec![0.0; TILE * TILE],
            depth: vec![0.0; TILE * TILE],
            own: vec![[0.0, 0.0, f32::NEG_INFINITY]; TILE * TILE],
            touched: Vec::new(),
            front: Vec::new(),
        }
    }

    fn painted(mut self, ready: &[Ready<'_>], found: &Found, paper: Colour) -> Vec<[f32; 4]> {
        self.lay_bands(ready, &found.bands, paper);
        for pieces in found.ink.chunk_by(|a, b| a[0] == b[0]) {
            let stroke = &ready[pieces[0][0] as usize];
            self.cover.fill(0.0);
            for pieces in pieces.chunk_by(|a, b| a[1] == b[1]) {
                let strip = &stroke.strips[pieces[0][1] as usize];
                for &[_, _, piece] in pieces {
                    self.cover_by(stroke.stroke, strip, &strip.pieces[piece as usize]);
                }
                self.unite();
            }
            self.ink(stroke.stroke);
        }
        self.pixels
    }

    /// The pixels of the tile between two corners: place in the tile, and middle in the picture.
    fn within(&self, [low, high]: [Vec2; 2]) -> impl Iterator<Item = (usize, Vec2)> + use<> {
        let span = |low: f32, high: f32, corner: usize| {
            let clamp = |v: f32| (v - corner as f32).clamp(0.0, TILE as f32) as usize;
            clamp(low.floor())..clamp(high.ceil())
        };
        let (xs, ys) = (span(low.x, high.x, self.corner.0), span(low.y, high.y, self.corner.1));
        let middle = Vec2::new(self.corner.0 as f32 + 0.5, self.corner.1 as f32 + 0.5);
        ys.flat_map(move |y| {
            let place = move |x| (y * TILE + x, middle + Vec2::new(x as f32, y as f32));
            xs.clone().map(place)
        })
    }

    /// Lays haloes and rims.
    fn lay_bands(&mut self, ready: &[Ready<'_>], bands: &[[u32; 2]], paper: Colour) {
        if bands.is_empty() {
            return;
        }
        self.front = vec![Fronts::default(); TILE * TILE];
        for &[s, p] in bands {
            let stroke = &ready[s as usize];
            let Some((pieces, [halo, rim])) = &stroke.band else { continue };
            let piece = &pieces[p as usize];
            let reach = halo.max(*rim);
            for (i, at) in self.within(piece.bounds(reach)) {
                let Some(hit) = piece.hit(at, reach) else { continue };
                let Stroke { brush, right, .. } = stroke.stroke;
                let side = hides(&hit, *right, brush.mark == Mark::Double);
                let covers = |more: f32| if more > 0.0 { side * hit.cover(more) } else { 0.0 };
                self.front[i].lay(hit.depth, covers(*halo));
                self.cover[i] = self.cover[i].max(covers(*rim));
            }
        }
        for i in 0..self.pixels.len() {
            over(&mut self.pixels[i], paper, self.cover[i]);
        }
    }

    fn cover_by(&mut self, stroke: &Stroke<'_>, strip: &Strip, piece: &Piece) {
        let inking = Inking { brush: stroke.brush, texture: stroke.texture };
        let (even, torn) = (inking.is_even(), stroke.brush.rough > 0.0);
        for (i, at) in self.within(piece.bounds(0.0)) {
            let Some(hit) = piece.hit(at, 0.0) else { continue };
            if strip.erases {
                self.cover[i] = self.cover[i].min(1.0 - hit.cover(0.0));
                continue;
            }
            let tear = if torn { inking.tear(&strip.axis, hit.u, hit.across > 0.0) } else { 0.0 };
            let tear = tear.max(-0.8 * hit.half);
            let (mut cover, inside) = (hit.cover(tear), hit.inside(tear));
            let before = self.own[i][2];
            // The darker of two grains would make every tight turn a blot.
            if cover <= 0.0 || inside <= before {
                continue;
            }
            if !even {
                cover *= inking.over_a_pixel(&strip.axis, &place(&hit, strip));
            }
            if before == f32::NEG_INFINITY {
                self.touched.push(i);
            }
            self.own[i] = [cover, hit.depth, inside];
        }
    }

    /// Adds what a ribbon covers to what the stroke covers: ribbons lie in a pixel as chance has it.
    fn unite(&mut self) {
        for i in self.touched.drain(..) {
            let nothing = [0.0, 0.0, f32::NEG_INFINITY];
            let [cover, depth, _] = std::mem::replace(&mut self.own[i], nothing);
            if cover > self.cover[i] {
                self.depth[i] = depth;
            }
            self.cover[i] += cover * (1.0 - self.cover[i]);
        }
    }

    /// Puts the ink where the stroke covers and no halo is before it.
    fn ink(&mut self, stroke: &Stroke<'_>) {
        for i in 0..self.pixels.len() {
            let mut cover = self.cover[i];
            if cover <= 0.0 {
                continue;
            }
            cover *= 1.0 - self.front.get(i).map_or(0.0, |f| f.hidden(self.depth[i]));
            over(&mut self.pixels[i], stroke.colour, cover * stroke.brush.opacity);
        }
    }
}

pub(super) fn place(hit: &Hit, strip: &Strip) -> Place {
    let [start, end] = strip.ends;
    let share = if end > start { ((hit.u - start) / (end - start)) as f32 } else { 0.0 };
    let length = [share * strip.length, strip.length];
    Place { u: hit.u, length, across: hit.across, half: hit.half }
}

/// A share of a colour over a pixel, mixed as displayed.
fn over(pixel: &mut [f32; 4], colour: Colour, share: f32) {
    let a = share * colour[3];
    if a <= 0.0 {
        return;
    }
    let alpha = a + pixel[3] * (1.0 - a);
    for c in 0..3 {
        pixel[c] = (colour[c] * a + pixel[c] * pixel[3] * (1.0 - a)) / alpha;
    }
    pixel[3] = alpha;
}
