//! Records: few receivers that look in all directions by rays, and pixels between them.
//!
//! 1. The picture is cut into squares of 16 pixels; in each, one pixel becomes a record (`gradient`).
//! 2. A square is quartered where its record differs from what the records before it, with their gradients,
//!    foretell, by more than a bound; where the record's own gradient cannot be trusted to its corners; and
//!    where some of its pixels see no record on a surface like their own. So on, down to single pixels.
//! 3. A pixel is the mean of what the records around it foretell, weighed by nearness in the picture,
//!    likeness of normals, and how near they are to its plane. How far records reach shrinks
//!    smoothly towards where they are dense.
//!
//! Surfels tell what far hits send; no tree is needed. Best on smooth interiors and for
//! quick looks; foliage makes nearly every pixel a record. Guaranteed: the same bits for any number of
//! threads, since each round of squares uses only the records of rounds before.

use crate::cluster::Pixel;
use crate::field::Light;
use crate::gradient::{Cells, Hemisphere, IrradianceRecord};
use crate::hierarchy::Hierarchy;
use crate::indirect::{Indirect, Prepared};
use chiaro_basis::math::Vec3;
use chiaro_basis::{Result, Run};
use chiaro_image::Plane;
use chiaro_trace::{GBuffer, Vertex};
use rayon::prelude::*;
use std::f32::consts::FRAC_1_PI;

/// Pixels along the largest squares.
const COARSEST: usize = 16;
/// How far a record reaches, in sides of its square; and the most, in pixels.
const REACH: f32 = 2.0;
const FARTHEST: f32 = REACH * COARSEST as f32;
/// How fast the reach grows away from dense records, pixels a pixel.
const GROWTH: f32 = 0.5;
/// Normals are alike over this cosine.
const ALIKE: f32 = 0.8;
/// How far off a pixel's plane a record may be, as a share of its distance.
const OFF_PLANE: f32 = 0.2;
/// Pixels along the squares in which records are looked up.
const BIN: usize = 8;
/// Rays of a record, and the share of the picture's mean by which it may differ from what was foretold, for an error bound of 0.1.
const RAYS: f32 = 256.0;
const TOLERANCE: f32 = 2.0;
const USUAL_BOUND: f32 = 0.1;
/// The share of that difference over which a record's doubt at the edge of its square quarters it.
const DOUBTED: f32 = 0.25;
/// The weight under which records within reach say too little.
const LEAST_WEIGHT: f32 = 1e-3;

/// A square of pixels.
#[derive(Clone, Copy)]
struct Square {
    corner: Pixel,
    side: usize,
}

/// A record, its pixel, and the side of its square.
struct Entry {
    pixel: Pixel,
    side: usize,
    record: IrradianceRecord,
}

/// Where a pixel asks.
struct Asker {
    pixel: Pixel,
    position: Vec3,
    normal: Vec3,
    side: Vec3,
    footprint: f32,
}

/// What records foretell, and what they weigh.
#[derive(Clone, Copy, Default)]
struct Foretold {
    sum: Light,
    weight: f32,
}

/// All records so far, by place.
struct Net<'a> {
    buffer: &'a GBuffer,
    entries: Vec<Entry>,
    columns: usize,
    bins: Vec<Vec<u32>>,
}

/// Rays of a record for an error bound.
fn rays(bound: f32) -> u32 {
    (RAYS * (USUAL_BOUND / bound).powi(2)).clamp(0.25 * RAYS, 64.0 * RAYS) as u32
}

/// Irradiance by reflected light at the covered pixels.
pub(crate) fn indirect<T: Hierarchy>(
    scene: &Prepared<T>,
    buffer: &GBuffer,
    run: &Run,
) -> Result<Indirect> {
    let bound = scene.knobs.error_bound;
    let hemisphere = Hemisphere::new(rays(bound), scene.shift);
    let occlusion = scene.knobs.occlusion * buffer.radius;
    let mut net = Net::new(buffer);
    let mut squares = first_squares(buffer);
    let mut mean = None;
    while !squares.is_empty() {
        let records: Vec<IrradianceRecord> = squares
            .par_iter()
            .map_init(Cells::default, |cells, (square, pixel)| {
                run.check()?;
                let at = Vertex::of_pixel(scene.lit.tracer, buffer, *pixel);
                Ok(hemisphere.look(scene, &at, occlusion, (square.pattern(), cells)))
            })
            .collect::<Result<_>>()?;
        let most = TOLERANCE * bound * *mean.get_or_insert_with(|| mean_of(&records));
        // The first records are foretold by each other, all others by those before them.
        let first = net.entries.is_empty();
        if first {
            net.add(&squares, &records);
        }
        let differs: Vec<bool> = (0..squares.len())
            .into_par_iter()
            .map(|i| net.differs(squares[i], &records[i], first.then_some(i as u32), most))
            .collect();
        if !first {
            net.add(&squares, &records);
        }
        let next: Vec<Vec<(Square, Pixel)>> =
            squares.par_iter().zip(differs).map(|((s, _), d)| net.quarters(s, d)).collect();
        squares = next.into_iter().flatten().collect();
    }
    net.picture(run)
}

/// The largest squares that show anything, with their pixels.
fn first_squares(buffer: &GBuffer) -> Vec<(Square, Pixel)> {
    let (width, height) = buffer.size();
    let (columns, rows) = (width.div_ceil(COARSEST), height.div_ceil(COARSEST));
    let one = |i: usize| {
        let corner = (i % columns * COARSEST, i / columns * COARSEST);
        let square = Square { corner, side: COARSEST };
        Some((square, square.middle((width, height), |p| buffer.covered[p])?))
    };
    (0..columns * rows).filter_map(one).collect()
}

/// The mean light of records.
fn mean_of(records: &[IrradianceRecord]) -> f32 {
    records.iter().map(|r| grey(&r.light)).sum::<f32>() / records.len().max(1) as f32
}

fn grey([r, g, b, _]: &Light) -> f32 {
    (r + g + b) / 3.0
}

impl Square {
    /// The pixel nearest to its middle of which something holds.
    fn middle(
        &self,
        (width, height): (usize, usize),
        holds: impl Fn(Pixel) -> bool,
    ) -> Option<Pixel> {
        let middle = |v: usize| 2 * v + self.side;
        let (mx, my) = (middle(self.corner.0), middle(self.corner.1));
        let apart =
            |(x, y): &Pixel| (2 * x + 1).abs_diff(mx).pow(2) + (2 * y + 1).abs_diff(my).pow(2);
        self.pixels(width, height).filter(|p| holds(*p)).min_by_key(apart)
    }

    /// Its place among 4 x 4 squares.
    fn pattern(&self) -> usize {
        let bit = |v: usize, i: usize| ((v / self.side) >> i) & 1;
        let (x, y) = self.corner;
        (bit(x, 0) ^ bit(y, 0))
            | (bit(y, 0) << 1)
            | ((bit(x, 1) ^ bit(y, 1)) << 2)
            | (bit(y, 1) << 3)
    }

    fn pixels(&self, width: usize, height: usize) -> impl Iterator<Item = Pixel> + use<> {
        let ((x0, y0), side) = (self.corner, self.side);
        (y0..(y0 + side).min(height))
            .flat_map(move |y| (x0..(x0 + side).min(width)).map(move |x| (x, y)))
    }
}

impl Foretold {
    fn light(&self) -> Option<Light> {
        (self.weight > 0.0).then(|| self.sum.map(|s| s / self.weight))
    }
}

impl<'a> Net<'a> {
    fn new(buffer: &'a GBuffer) -> Self {
        let (width, height) = buffer.size();
        let columns = width.div_ceil(BIN);
        let bins = vec![Vec::new(); columns * height.div_ceil(BIN)];
        Self { buffer, entries: Vec::new(), columns, bins }
    }

    fn add(&mut self, squares: &[(Square, Pixel)], records: &[IrradianceRecord]) {
        for ((square, pixel), record) in squares.iter().zip(records) {
            let bin = pixel.1 / BIN * self.columns + pixel.0 / BIN;
            self.bins[bin].push(self.entries.len() as u32);
            self.entries.push(Entry { pixel: *pixel, side: square.side, record: *record });
        }
    }

    fn asker(&self, pixel: Pixel) -> Asker {
        let buffer = self.buffer;
        Asker {
            pixel,
            position: buffer.position[pixel].into(),
            normal: buffer.normal[pixel].into(),
            side: buffer.geometric_normal[pixel].into(),
            footprint: buffer.pose.pixel_size(buffer.depth[pixel], buffer.size().1 as f32),
        }
    }

    /// Records within so many pixels, with their distances.
    fn around(&self, pixel: Pixel, reach: f32) -> impl Iterator<Item = (u32, f32)> {
        let whole = reach as usize;
        let rows = self.bins.len() / self.columns.max(1);
        let span = |v: usize, count: usize| {
            v.saturating_sub(whole) / BIN..=((v + whole) / BIN).min(count - 1)
        };
        let across = span(pixel.0, self.columns);
        span(pixel.1, rows)
            .flat_map(move |row| across.clone().map(move |column| (row, column)))
            .flat_map(move |(row, column)| &self.bins[row * self.columns + column])
            .filter_map(move |&i| {
                let (x, y) = self.entries[i as usize].pixel;
                let square = x.abs_diff(pixel.0).pow(2) + y.abs_diff(pixel.1).pow(2);
                let distance = (square as f32).sqrt();
                (distance < reach).then_some((i, distance))
            })
    }

    /// What the records within reach foretell; `but` is left out.
    fn foretold(&self, asker: &Asker, reach: f32, but: Option<u32>) -> Foretold {
        let near = self.within(asker, reach, but);
        if near.weight > LEAST_WEIGHT || reach >= FARTHEST {
            return near;
        }
        let far = self.within(asker, FARTHEST, but);
        Foretold {
            sum: std::array::from_fn(|c| near.sum[c] + LEAST_WEIGHT * far.sum[c]),
            weight: near.weight + LEAST_WEIGHT * far.weight,
        }
    }

    fn within(&self, asker: &Asker, reach: f32, but: Option<u32>) -> Foretold {
        let mut found = Foretold::default();
        for (i, distance) in self.around(asker.pixel, reach).filter(|(i, _)| Some(*i) != but) {
            let record = &self.entries[i as usize].record;
            let weight = likeness(asker, record) * (1.0 - (distance / reach).powi(2)).powi(2);
            if weight > 0.0 {
                let light = record.at(asker.position, asker.normal);
                (0..4).for_each(|c| found.sum[c] += weight * light[c]);
                found.weight += weight;
            }
        }
        found
    }

    /// Whether a record differs from what those before it foretell by more than `most`, or its gradient
    /// cannot be trusted to the edge of its square. `own` is its place where it is among them.
    fn differs(
        &self,
        (square, pixel): (Square, Pixel),
        record: &IrradianceRecord,
        own: Option<u32>,
        most: f32,
    ) -> bool {
        let reach = (2.0 * REACH * square.side as f32).min(FARTHEST);
        let asker = self.asker(pixel);
        let half = 0.5 * square.side as f32 * asker.footprint;
        let foretold = self.foretold(&asker, reach, own).light();
        record.doubt(half) > DOUBTED * most
            || foretold.is_some_and(|f| (grey(&f) - grey(&record.light)).abs() > most)
    }

    /// Whether a pixel sees any record on a surface like its own.
    fn is_served(&self, pixel: Pixel) -> bool {
        let asker = self.asker(pixel);
        self.around(pixel, FARTHEST)
            .any(|(i, _)| likeness(&asker, &self.entries[i as usize].record) > 0.0)
    }

    /// The quarters of a square that need records, with their pixels: all where it differs, and those with pixels that
    /// see no record.
    fn quarters(&self, square: &Square, differs: bool) -> Vec<(Square, Pixel)> {
        let side = square.side / 2;
        if side == 0 {
            return Vec::new();
        }
        let size = self.buffer.size();
        let quarter = |i: usize| {
            let corner = (square.corner.0 + i % 2 * side, square.corner.1 + i / 2 * side);
            let quarter = Square { corner, side };
            let covered = |p: Pixel| self.buffer.covered[p];
            let left = quarter.middle(size, |p| covered(p) && !self.is_served(p));
            let any = || quarter.middle(size, covered).filter(|_| differs);
            Some((quarter, left.or_else(any)?))
        };
        (0..4).filter_map(quarter).collect()
    }

    /// How far records reach at each pixel.
    fn reach(&self) -> Plane<f32> {
        let (width, height) = self.buffer.size();
        let mut reach = Plane::filled(width, height, FARTHEST);
        for e in &self.entries {
            reach[e.pixel] = reach[e.pixel].min(REACH * e.side as f32);
        }
        let slant = GROWTH * std::f32::consts::SQRT_2;
        let mut sweep = |x: usize, y: usize, steps: [(isize, isize, f32); 4]| {
            let own = reach[(x, y)];
            let least = steps
                .iter()
                .filter_map(|(dx, dy, cost)| {
                    reach.at(x as isize + dx, y as isize + dy).map(|r| r + cost)
                })
                .fold(own, f32::min);
            reach[(x, y)] = least;
        };
        let steps = [(-1, 0, GROWTH), (0, -1, GROWTH), (-1, -1, slant), (1, -1, slant)];
        let back = steps.map(|(x, y, cost)| (-x, -y, cost));
        (0..height).for_each(|y| (0..width).for_each(|x| sweep(x, y, steps)));
        (0..height).rev().for_each(|y| (0..width).rev().for_each(|x| sweep(x, y, back)));
        reach
    }

    fn picture(&self, run: &Run) -> Result<Indirect> {
        let (width, height) = self.buffer.size();
        let reach = self.reach();
        let light = Plane::from_fn(width, height, |x, y| {
            if run.check().is_err() || !self.buffer.covered[(x, y)] {
                return [0.0, 0.0, 0.0, std::f32::consts::PI];
            }
            let found = self.foretold(&self.asker((x, y)), reach[(x, y)], None);
            found.light().unwrap_or_default()
        });
        run.check()?;
        Ok(Indirect {
            irradiance: light.map(|l| [l[0], l[1], l[2]].map(|v| v.max(0.0))),
            openness: light.map(|l| (l[3] * FRAC_1_PI).clamp(0.0, 1.0)),
            gathers: self.entries.len() as u64,
            ..Indirect::none(width, height)
        })
    }
}

/// How much alike the surfaces of a pixel and of a record are; 0 where they are not.
fn likeness(asker: &Asker, record: &IrradianceRecord) -> f32 {
    let turn = (asker.normal.dot(record.normal) - ALIKE) / (1.0 - ALIKE);
    let offset = asker.position - record.position;
    let length = offset.length();
    let off = (0.5 * offset.dot(asker.side + record.side)).abs();
    let plane = 1.0 - off / (OFF_PLANE * length + asker.footprint);
    if turn <= 0.0 || plane <= 0.0 {
        return 0.0;
    }
    let apart = length / record.clearance.max(asker.footprint);
    turn * plane / (1.0 + apart * apart)
}
