//! Trees larger than memory could hold as they are: surfels are made, lit, coded and forgotten
//! batch by batch (thesis, 6.5.2).
//!
//! 1. A *sparse* set of at most [`SPARSE`] surfels is lit, with all bounces. Its tree teaches the
//!    book (thesis, figure 6.5); it carries the light that was reflected before; near rays ask it.
//! 2. Dense surfels are counted in 2^21 cells along the Hilbert curve, and cut into batches of
//!    whole cells with about [`BATCH`] surfels.
//! 3. Of each batch: its sites are made once more, sorted along the curve, lit directly; to their
//!    light is added what the nearest sparse surfel received by reflection; what faces different ways is
//!    told apart (`facing`); and parts of a tree are coded ([`compact`](crate::compact)).
//!
//! In memory are the coded tree, one batch (some 200 bytes a surfel of it), the cells (16 MB), 24
//! bytes a triangle that has surfels, and what the sparse set takes. A scene with no more surfels than the
//! sparse set uses that itself.

use crate::code::{Book, HEADROOM, Lobes, Recipe, turned};
use crate::compact::{Builder, Compact, Format};
use crate::cover;
use crate::curve::{BITS, Cube};
use crate::facing;
use crate::hierarchy::Hierarchy;
use crate::near::Reflected;
use crate::packed::{Floats, Packed, Record, Sums, records};
use crate::payload::Exact;
use crate::site::Site;
use crate::spread::Spread;
use crate::surfel::{Lit, Surfel, Surfels};
use crate::tree::Node;
use crate::{LightKnobs, Prepared};
use chiaro_basis::math::{Mat3, Vec3};
use chiaro_basis::{Result, Run, random};
use rayon::prelude::*;
use std::f32::consts::FRAC_1_PI;
use std::sync::atomic::{AtomicU32, Ordering};

/// Surfels of the sparse set, at most.
pub const SPARSE: u64 = 100_000;
/// Surfels of a batch, about.
pub const BATCH: u32 = 1 << 19;
/// Bits of a cell's index: the highest of the curve's.
const CELL_BITS: u32 = 21;
/// Nodes of a size from which a book learns, at most.
pub const LESSONS: usize = 8192;

/// The sparse tree's surfels along the curve, as records.
pub fn sorted(surfels: &[Surfel], cube: &Cube) -> Vec<Record> {
    let mut order: Vec<(u64, u32)> =
        surfels.par_iter().enumerate().map(|(i, s)| (cube.index(s.position), i as u32)).collect();
    order.par_sort_unstable();
    parted(order.into_par_iter().map(|(key, i)| (key, surfels[i as usize])).collect())
}

/// Records of surfels along the curve, told apart by where they face.
fn parted(mut keyed: Vec<(u64, Surfel)>) -> Vec<Record> {
    facing::part(&mut keyed);
    let surfels: Vec<Surfel> = keyed.into_par_iter().map(|(_, s)| s).collect();
    records(&surfels)
}

/// A node from which a book learns.
#[derive(Clone, Copy, Debug)]
pub struct Lesson {
    /// The summed area.
    pub area: f32,
    /// The mean normal.
    pub axis: Vec3,
    /// The sums.
    pub sums: Exact,
}

/// The nodes of the tree over `records`, and groups of 1, 2, 4 and 8 records: as large as are the
/// blocks of denser trees. Of a size, every so many where they are more than `most`.
pub fn lessons(records: &[Record], most: usize) -> Vec<Lesson> {
    let mut all = Vec::new();
    let mut take = |lessons: Vec<Lesson>| {
        let step = lessons.len().div_ceil(most).max(1);
        all.extend(lessons.into_iter().step_by(step));
    };
    let lesson =
        |node: &Node, sums: &Exact| Lesson { area: node.area, axis: node.axis, sums: *sums };
    for size in [1, 2, 4, 8] {
        let step = (records.len() / size).div_ceil(most).max(1);
        let group = |group: &[Record]| {
            let sums = Sums::of_records(group);
            lesson(&sums.node, &sums.lobes)
        };
        take(records.chunks(size).step_by(step).map(group).collect());
    }
    let mut nodes = Vec::new();
    Packed::build(records).each_node(|node, lobes| nodes.push(lesson(node, lobes)));
    take(nodes);
    all
}

/// The book that `records` teach.
pub fn book(records: &[Record], recipe: &Recipe, run: &Run) -> Result<Book> {
    taught(&lessons(records, LESSONS), recipe, run)
}

/// The book that lessons teach.
pub fn taught(lessons: &[Lesson], recipe: &Recipe, run: &Run) -> Result<Book> {
    let lobes: Vec<Lobes> = lessons.iter().map(Lesson::lobes).collect();
    Book::train(&lobes, recipe, 1, run)
}

impl Lesson {
    /// The same, turned at random and in random colours: two octaves darker to two brighter each.
    #[must_use]
    pub fn varied(&self, number: u64) -> Self {
        let unit = |k: u64| random::unit(k, number);
        let axis = Vec3::new(unit(31) - 0.5, unit(32) - 0.5, unit(33) - 0.5).normalize_or(Vec3::Y);
        let turn = Mat3::from_axis_angle(axis, std::f32::consts::TAU * unit(34));
        let mut sums = self.sums;
        sums.area = turned(&sums.area, &turn);
        for (c, light) in sums.light.iter_mut().enumerate() {
            let gain = (4.0 * unit(35 + c as u64) - 2.0).exp2();
            *light = turned(light, &turn).map(|l| gain * l);
        }
        Self { area: self.area, axis: turn.transpose() * self.axis, sums }
    }

    /// As a book takes it.
    pub fn lobes(&self) -> Lobes<'_> {
        Lobes::new(&self.sums, self.area, self.axis)
    }
}

/// The tree over records along the curve of a cube, coded with a book, as a whole.
pub fn coded_in_memory(records: &[Record], cube: Cube, book: &Book) -> Result<Packed<Compact>> {
    let light = records.iter().map(|r| brighter(&r.radiance)).fold(0.0, f32::max);
    let area: f64 = records.iter().map(|r| f64::from(r.area)).sum();
    let mut builder = Builder::new(spanning(book.clone(), cube, area, light));
    builder.add(records.to_vec())?;
    builder.done("")
}

/// The cube around everything drawn.
pub fn cube(lit: &Lit, spread: &Spread) -> Cube {
    let corners = |t: usize| {
        let (object, face) = spread.triangle(t);
        lit.tracer.corners(object, face)
    };
    let bounds = (0..spread.triangles()).into_par_iter().map(corners).fold(
        || (Vec3::INFINITY, Vec3::NEG_INFINITY),
        |(low, high), corners| {
            corners.into_iter().fold((low, high), |(l, h), c| (l.min(c), h.max(c)))
        },
    );
    let (low, high) =
        bounds.reduce(|| (Vec3::INFINITY, Vec3::NEG_INFINITY), |a, b| (a.0.min(b.0), a.1.max(b.1)));
    if low.is_finite() { Cube::around(low, high) } else { Cube::around(Vec3::ZERO, Vec3::ONE) }
}

/// How the tree of a spread is stored, with a book.
pub fn format(book: Book, cube: Cube, spread: &Spread, sparse: &Surfels) -> Format {
    let light = sparse.all.iter().map(|s| brighter(&s.radiance)).fold(0.0, f32::max);
    let area: f64 = sparse.all.iter().map(|s| f64::from(s.area)).sum();
    // What is drawn, and what the sparse set, in another frame, stands for.
    spanning(book, cube, area.max(spread.area), light)
}

/// The light of the brighter side, over all colours.
fn brighter(sides: &[[f32; 3]; 2]) -> f32 {
    sides.iter().map(|r| r.iter().sum::<f32>()).fold(0.0, f32::max)
}

/// Codes that span both sides of an area, and the light of the brightest surfel.
fn spanning(book: Book, cube: Cube, area: f64, light: f32) -> Format {
    Format {
        book,
        cube,
        top_area: 2.0 * area.max(f64::from(f32::MIN_POSITIVE)) as f32,
        top_light: if light > 0.0 { HEADROOM * light } else { 1.0 },
    }
}

/// Codes the tree over all surfels of a spread with a builder in whose format it is; `sparse` has been lit.
/// `origin` says in a file what the tree was made from.
pub fn build<T: Hierarchy>(
    sparse: &Prepared<T>,
    spread: &Spread,
    mut builder: Builder,
    origin: &str,
    run: &Run,
) -> Result<Packed<Compact>> {
    let cube = builder.cube();
    each_batch(sparse, spread, cube, run, &mut |records| builder.add(records))?;
    run.stage("tree", 0, || builder.done(origin))
}

/// The same tree as it is before it is coded, the whole of it in memory: the oracle.
pub fn build_exact<T: Hierarchy>(
    sparse: &Prepared<T>,
    spread: &Spread,
    cube: Cube,
    run: &Run,
) -> Result<Packed<Floats>> {
    let mut all = Vec::new();
    each_batch(sparse, spread, cube, run, &mut |records| {
        all.extend(records);
        Ok(())
    })?;
    Ok(run.stage("tree", all.len() as u64, || Packed::build(&all)))
}

/// Hands the records of all surfels to `take`, batch by batch along the curve.
fn each_batch<T: Hierarchy>(
    sparse: &Prepared<T>,
    spread: &Spread,
    cube: Cube,
    run: &Run,
    take: &mut dyn FnMut(Vec<Record>) -> Result<()>,
) -> Result<()> {
    if spread.count <= sparse.surfels.all.len() as u64 {
        return run.stage("tree", spread.count, || take(sorted(&sparse.surfels.all, &cube)));
    }
    let source = Source { lit: &sparse.lit, spread, cube };
    let cells = run.stage("surfels", 0, || source.cells());
    for range in batches(&cells.counts) {
        run.check()?;
        let sites = run.stage("surfels", 0, || source.sites(&cells, range));
        let surfels = lit_sites(sparse, &sites, run)?;
        let keyed = || surfels.par_iter().map(|s| (cube.index(s.position), *s)).collect();
        run.stage("tree", surfels.len() as u64, || take(parted(keyed())))?;
    }
    Ok(())
}

/// Sites with all light that they receive.
fn lit_sites<T: Hierarchy>(sparse: &Prepared<T>, sites: &[Site], run: &Run) -> Result<Vec<Surfel>> {
    let knobs: &LightKnobs = &sparse.knobs;
    let mut surfels = Surfels::light(&sparse.lit, sites, knobs, run)?;
    let Reflected { grid, irradiance, .. } = &sparse.reflected;
    run.stage("direct", 0, || {
        let reflect = |s: &mut Surfel| {
            for side in (0..2).filter(|k| s.alive[*k]) {
                let normal = if side == 0 { s.normal } else { -s.normal };
                let near = grid.nearest(&sparse.surfels, s.position, normal);
                let Some((k, other)) = near else { continue };
                let more = irradiance[k as usize][other];
                (0..3).for_each(|c| s.radiance[side][c] += s.albedo[c] * FRAC_1_PI * more[c]);
            }
        };
        if !irradiance.is_empty() {
            surfels.all.par_iter_mut().for_each(reflect);
        }
        let shown = cover::shown(&sparse.lit, &surfels, (&sparse.surfels, grid));
        cover::show(&mut surfels, &shown);
    });
    Ok(surfels.all)
}

/// What makes sites again and again.
struct Source<'a> {
    lit: &'a Lit<'a>,
    spread: &'a Spread,
    cube: Cube,
}

/// How many sites lie in each cell of the curve.
struct Cells {
    counts: Vec<u32>,
    /// The first and the last cell of each triangle.
    spans: Vec<[u32; 2]>,
}

impl Source<'_> {
    fn key(&self, site: &Site, [a, b, c]: [Vec3; 3]) -> u64 {
        self.cube.index(a + (b - a) * site.b[0] + (c - a) * site.b[1])
    }

    fn corners(&self, triangle: usize) -> [Vec3; 3] {
        let (object, face) = self.spread.triangle(triangle);
        self.lit.tracer.corners(object, face)
    }

    fn cells(&self) -> Cells {
        let counts: Vec<AtomicU32> = (0..1usize << CELL_BITS).map(|_| AtomicU32::new(0)).collect();
        let span = |t: usize| {
            let corners = self.corners(t);
            let mut span = [u32::MAX, 0];
            for (_, site) in self.spread.sites(t) {
                let cell = cell(self.key(&site, corners));
                // Whole numbers: their sum does not depend on the order.
                counts[cell as usize].fetch_add(1, Ordering::Relaxed);
                span = [span[0].min(cell), span[1].max(cell)];
            }
            span
        };
        let spans = (0..self.spread.triangles()).into_par_iter().map(span).collect();
        Cells { counts: counts.into_iter().map(AtomicU32::into_inner).collect(), spans }
    }

    /// The sites of a range of cells, along the curve.
    fn sites(&self, cells: &Cells, range: std::ops::Range<u32>) -> Vec<Site> {
        let within = |t: &usize| {
            let [first, last] = cells.spans[*t];
            first < range.end && last >= range.start
        };
        let mut found: Vec<(u64, u64, Site)> = (0..self.spread.triangles())
            .into_par_iter()
            .filter(within)
            .flat_map_iter(|t| {
                let corners = self.corners(t);
                let range = range.clone();
                self.spread.sites(t).filter_map(move |(number, site)| {
                    let key = self.key(&site, corners);
                    range.contains(&cell(key)).then_some((key, number, site))
                })
            })
            .collect();
        found.par_sort_unstable_by_key(|(key, number, _)| (*key, *number));
        found.into_iter().map(|(_, _, site)| site).collect()
    }
}

fn cell(key: u64) -> u32 {
    (key >> (3 * BITS - CELL_BITS)) as u32
}

/// Ranges of cells with about [`BATCH`] sites each.
fn batches(counts: &[u32]) -> Vec<std::ops::Range<u32>> {
    let mut ranges = Vec::new();
    let (mut start, mut sum) = (0, 0u64);
    for (cell, count) in counts.iter().enumerate() {
        if sum > 0 && sum + u64::from(*count) > u64::from(BATCH) {
            ranges.push(start..cell as u32);
            (start, sum) = (cell as u32, 0);
        }
        sum += u64::from(*count);
    }
    if sum > 0 {
        ranges.push(start..counts.len() as u32);
    }
    ranges
}
