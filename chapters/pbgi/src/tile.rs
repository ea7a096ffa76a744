//! Shared gathers: one cube buffer for the pixels of a tile, and short rays for what differs
//! between them.
//!
//! 1. The pixels of a tile are put into clusters that are close in position (`cluster`); normals
//!    may differ, since the buffer is a full sphere. Where probing rays show that much is near, the
//!    tile is busy: it is done in quarters.
//! 2. Each cluster has a field: a cube buffer with what lies beyond the radius D around its centre
//!    (`field`). Its bright splats are asked for by rays to their surfels (`bright`): from some pixels whether all or none of a
//!    texel's arrives, and from each pixel how much where these differ. Rays tell which other texels no pixel sees (`veil`).
//! 3. A pixel mixes the fields of the four tiles (or quarters) around it by its place between their
//!    centres, so that tiles do not show. Its far irradiance is the sum over texels of radiance
//!    times its own cosine; on a plane it is computed at every fourth pixel and interpolated.
//! 4. Its near field is a few rays of cosine density that end at the spheres of radius D. A hit adds
//!    its radiance less the far radiance of that direction, a miss nothing: the far buffer is a
//!    control variate, and what rays must tell is only the residual (`receiver`). More rays are
//!    cast where those around hit something, and far light is not interpolated where it varies there.
//! 5. Hits are pooled over blocks of pixels by the balance heuristic (`pool`), each as far as a pixel's
//!    own balls hold it. Far light that is taken back is scaled by what the far sums really hold of it.
//!
//! Work goes down the picture in bands of tiles, so that memory does not grow with its height. The
//! same sums tell how much of the hemisphere is open: ambient occlusion comes with the light.

use crate::band::{Band, Gathered};
use crate::cluster::{Pixel, clusters};
use crate::cube::{CubeBuffer, CubeShape};
use crate::cut::Splat;
use crate::field::{Ball, Field, Gathering};
use crate::hierarchy::Hierarchy;
use crate::indirect::{Indirect, Prepared, Wanted};
use crate::opening::Dome;
use crate::pool;
use crate::receiver::{Lattice, Mix, Receiver};
use chiaro_basis::math::Vec3;
use chiaro_basis::{Result, Run};
use chiaro_trace::{GBuffer, Sides, Vertex};
use rayon::prelude::*;
use std::collections::VecDeque;

/// How a kind of tile is done.
#[derive(Clone, Copy, Debug)]
struct Manner {
    /// Pixels along a side of what has a field.
    side: usize,
    /// Texels along a side of the buffer, as a share of the knob.
    resolution: f32,
    /// The threshold, as a multiple of the knob.
    threshold: f32,
    /// D over the cluster's radius, at least.
    reach: f32,
    /// Rays a pixel: of the first pass; in all where that pass hit; where most hit.
    rays: [u32; 3],
}

/// Smooth surroundings.
const CALM: Manner =
    Manner { side: 16, resolution: 1.0, threshold: 1.0, reach: 1.5, rays: [4, 12, 44] };
/// Dense detail.
const BUSY: Manner =
    Manner { side: 8, resolution: 0.8, threshold: 1.5, reach: 2.0, rays: [8, 32, 32] };
/// The place of busy tiles' rays in the lattice, where all are one net: nearly all pixels need all.
const BUSY_LATTICE: usize = 1;
/// Pixels along a tile's side.
const TILE: usize = CALM.side;
/// The least D, in distances at which a surfel's disc looks as large as the square root of so many texels. The
/// threshold may be lower: finer cuts are cheap, near rays are not.
const LEAF_REACH: f32 = 2.5;
const LEAF_TEXELS: f32 = 2.0;
/// One in so many pixels asks what of a field is hidden.
const VEIL_STEP: usize = 7;
/// Pixels of a cluster at which leaves are looked for.
const LEAF_PROBES: usize = 4;
/// The share of hits among probing rays over which a tile is busy, and their number.
const BUSY_HITS: f32 = 0.3;
const PROBES: u32 = 8;
/// The share of hits over which nearly all of the far light is taken back by near rays, and more of
/// them are cast.
const MOST_HIT: f32 = 0.6;
/// The error bound that the numbers of rays are stated for.
const USUAL_BOUND: f32 = 0.1;
/// Rows of tiles done together.
const BAND: usize = 4;
/// Far light is computed at every so many pixels on planes.
const NODE: usize = 4;
/// Where near rays hit, nodes that differ by more than this share are not interpolated.
const LINEAR: f32 = 0.1;
/// And where what arrives of what is bright differs by more than this share of what could.
const ARRIVE_APART: f32 = 0.25;

/// The fields of a tile: of its clusters, or of those of its four quarters.
struct Tile {
    busy: bool,
    fields: [Vec<Field>; 4],
}

/// Buffers that a thread uses again and again.
struct Workspace {
    calm: CubeBuffer,
    busy: CubeBuffer,
    splats: Vec<Splat>,
}

/// Everything that the tiles of a picture share.
struct Picture<'a, 'b, T: Hierarchy> {
    scene: &'a Prepared<'b, T>,
    buffer: &'a GBuffer,
    shapes: [CubeShape; 2],
    lattice: Lattice,
    /// Tiles in a row, and rows.
    columns: usize,
    rows: usize,
    /// What is farther does not occlude, scene units.
    occlusion: f32,
    /// What lights through openings, where they are wanted.
    dome: Option<Dome>,
}

/// Irradiance by reflected light at the covered pixels, and what else is wanted of them.
pub(crate) fn indirect<T: Hierarchy>(
    scene: &Prepared<T>,
    buffer: &GBuffer,
    wanted: Wanted,
    run: &Run,
) -> Result<Indirect> {
    let (width, height) = buffer.size();
    let side = |m: Manner| (scene.knobs.resolution as f32 * m.resolution).round().max(2.0) as usize;
    let bound = scene.knobs.error_bound;
    let shapes = [CALM, BUSY].map(|m| CubeShape::new(side(m)));
    let picture = Picture {
        scene,
        buffer,
        dome: wanted.openings.then(|| Dome::new(scene.lit.lights.sky.as_deref(), &shapes)),
        shapes,
        lattice: Lattice::new(&[&rays(CALM, bound), &[rays(BUSY, bound)[2]]], scene.shift),
        columns: width.div_ceil(TILE),
        rows: height.div_ceil(TILE),
        occlusion: scene.knobs.occlusion * buffer.radius,
    };
    let mut found = Indirect::wanting(wanted, width, height);
    let mut tiles: VecDeque<Vec<Tile>> = VecDeque::new();
    let mut band = Band::default();
    let (mut first, mut built, mut done) = (0, 0, 0);
    for top in (0..picture.rows).step_by(BAND) {
        let end = (top + BAND).min(picture.rows);
        while first + 1 < top {
            tiles.pop_front();
            first += 1;
        }
        let wanted = (end + 1).min(picture.rows);
        for (row, counts) in picture.tiles(built..wanted, run)? {
            tiles.push_back(row);
            found.gathers += counts[0];
            found.visited += counts[1];
        }
        built = wanted;
        let above = Above { first, rows: &tiles };
        picture.receivers(&above, top..end, &mut band, run)?;
        let last = (end * TILE).min(height);
        let until = if last == height { height } else { last - pool::STEP };
        band.settle(done..until, picture.dome.as_ref(), &mut found);
        done = until;
    }
    Ok(found)
}

/// Rows of tiles, from the first that is kept on.
struct Above<'a> {
    first: usize,
    rows: &'a VecDeque<Vec<Tile>>,
}

impl<T: Hierarchy> Picture<'_, '_, T> {
    /// The fields of some rows of tiles; for each row buffers filled and nodes visited.
    fn tiles(&self, rows: std::ops::Range<usize>, run: &Run) -> Result<Vec<(Vec<Tile>, [u64; 2])>> {
        let work = || Workspace {
            calm: CubeBuffer::new(self.shapes[0].clone()),
            busy: CubeBuffer::new(self.shapes[1].clone()),
            splats: Vec::new(),
        };
        let (start, count) = (rows.start, rows.len());
        let all: Vec<(Tile, [u64; 2])> = (0..count * self.columns)
            .into_par_iter()
            .map_init(work, |work, i| {
                run.check()?;
                Ok(self.tile((i % self.columns, start + i / self.columns), work))
            })
            .collect::<Result<_>>()?;
        let mut all = all.into_iter();
        let row = |_| {
            let (tiles, counts): (Vec<_>, Vec<[u64; 2]>) = all.by_ref().take(self.columns).unzip();
            (tiles, counts.iter().fold([0, 0], |s, c| [s[0] + c[0], s[1] + c[1]]))
        };
        Ok((0..count).map(row).collect())
    }

    /// A tile's fields.
    fn tile(&self, (column, row): (usize, usize), work: &mut Workspace) -> (Tile, [u64; 2]) {
        let pixels = self.pixels((column * TILE, row * TILE), TILE);
        let groups = clusters(self.buffer, pixels, TILE);
        let balls: Vec<Ball> = groups.iter().map(|g| self.ball(g, CALM)).collect();
        let mut counts = [0, 0];
        let busy = self.is_busy(&groups, &balls);
        let mut fields: [Vec<Field>; 4] = Default::default();
        if busy {
            for (i, fields) in fields.iter_mut().enumerate() {
                let corner = (column * TILE + i % 2 * BUSY.side, row * TILE + i / 2 * BUSY.side);
                let pixels = self.pixels(corner, BUSY.side);
                for group in clusters(self.buffer, pixels, BUSY.side) {
                    let ball = self.ball(&group, BUSY);
                    fields.push(self.field((ball, corner), BUSY, work, &mut counts));
                }
            }
        } else {
            let corner = (column * TILE, row * TILE);
            let field = |b: &Ball| self.field((*b, corner), CALM, work, &mut counts);
            fields[0] = balls.iter().map(field).collect();
        }
        (Tile { busy, fields }, counts)
    }

    /// Covered pixels of a square.
    fn pixels(&self, (x0, y0): Pixel, side: usize) -> Vec<Pixel> {
        let (width, height) = self.buffer.size();
        (y0..(y0 + side).min(height))
            .flat_map(|y| (x0..(x0 + side).min(width)).map(move |x| (x, y)))
            .filter(|p| self.buffer.covered[*p])
            .collect()
    }

    fn threshold(&self, manner: Manner) -> f32 {
        let shape = &self.shapes[usize::from(manner.side == BUSY.side)];
        self.scene.knobs.solid_angle * manner.threshold * shape.mean_solid_angle()
    }

    /// The ball of a cluster: large enough that no surfel outside looks larger than some texels.
    fn ball(&self, group: &[Pixel], manner: Manner) -> Ball {
        let radius = |p: &Pixel| {
            let normal = Vec3::from(self.buffer.geometric_normal[*p]);
            self.scene.leaf_radius(self.buffer.position[*p].into(), normal)
        };
        let some = group.iter().step_by((group.len() / LEAF_PROBES).max(1));
        let leaf = some.map(radius).fold(0.0, f32::max);
        let usual = self.threshold(manner) / self.scene.knobs.solid_angle * LEAF_TEXELS;
        let least = LEAF_REACH * leaf / usual.sqrt();
        Ball::around(self.buffer, group, manner.reach, least)
    }

    fn field(
        &self,
        (ball, corner): (Ball, Pixel),
        manner: Manner,
        work: &mut Workspace,
        counts: &mut [u64; 2],
    ) -> Field {
        let how = Gathering {
            threshold: self.threshold(manner),
            occlusion: self.occlusion,
            beyond: 100.0 * self.buffer.radius,
        };
        let Workspace { calm, busy, splats } = work;
        let cube = if manner.side == BUSY.side { busy } else { calm };
        let some = self.some_in(&ball, corner, manner);
        let (field, visited) = Field::gather(self.scene, ball, &how, &some, (cube, splats));
        counts[0] += 1;
        counts[1] += visited;
        field
    }

    /// Some of the pixels that mix a field: those in its ball, of its square and around it as far as half of its
    /// side. None where no rays look into the ball: then nothing in it hides anything.
    fn some_in(&self, ball: &Ball, (x, y): Pixel, manner: Manner) -> Vec<Vertex> {
        if !self.scene.knobs.near_field {
            return Vec::new();
        }
        let half = manner.side / 2;
        let pixels = self.pixels((x.saturating_sub(half), y.saturating_sub(half)), 2 * manner.side);
        let near = pixels.iter().filter(|p| ball.holds(self.buffer.position[**p].into()));
        let vertex = |p: &Pixel| Vertex::of_pixel(self.scene.lit.tracer, self.buffer, *p);
        near.step_by(VEIL_STEP).map(vertex).collect()
    }

    /// Whether many rays from a sixteenth of the pixels hit something in their cluster's ball.
    fn is_busy(&self, groups: &[Vec<Pixel>], balls: &[Ball]) -> bool {
        let (mut hits, mut rays) = (0, 0);
        for (group, ball) in groups.iter().zip(balls) {
            for pixel in group.iter().filter(|p| p.0 % 4 == 1 && p.1 % 4 == 2) {
                let at = Vertex::of_pixel(self.scene.lit.tracer, self.buffer, *pixel);
                let origin = at.position + at.side * at.offset;
                for k in 0..PROBES {
                    let place = (pixel.0 / 4, pixel.1 / 4);
                    let direction = at.cosine_direction(self.lattice.point(BUSY_LATTICE, k, place));
                    let ray = at.ray(direction, ball.exit(origin, direction));
                    rays += 1;
                    hits += u32::from(self.scene.lit.tracer.hit(&ray, Sides::Both).is_some());
                }
            }
        }
        hits as f32 > BUSY_HITS * rays as f32
    }

    /// Adds the receivers of some rows of tiles to a band.
    fn receivers(
        &self,
        above: &Above,
        rows: std::ops::Range<usize>,
        band: &mut Band,
        run: &Run,
    ) -> Result<()> {
        let (width, height) = self.buffer.size();
        let (start, count) = (rows.start, rows.len());
        let all: Vec<Vec<Gathered>> = (0..count * self.columns)
            .into_par_iter()
            .map(|i| {
                run.check()?;
                Ok(self.gathered(above, (i % self.columns, start + i / self.columns)))
            })
            .collect::<Result<_>>()?;
        band.add(width, (rows.end * TILE).min(height), all.into_iter().flatten());
        Ok(())
    }

    /// The receivers of a tile, with all their rays cast and their far light.
    fn gathered(&self, above: &Above, (column, row): (usize, usize)) -> Vec<Gathered> {
        let (scene, buffer) = (self.scene, self.buffer);
        let pixels = self.pixels((column * TILE, row * TILE), TILE);
        let busy = above.tile(column, row).busy;
        let (manner, kind) = if busy { (BUSY, BUSY_LATTICE) } else { (CALM, 0) };
        let mut receivers: Vec<Receiver> =
            pixels.iter().map(|p| Receiver::new(scene.lit.tracer, buffer, *p)).collect();
        let mixes: Vec<Mix> =
            receivers.iter().map(|r| self.mix(above, r.pixel, r.at.position)).collect();
        if scene.knobs.near_field {
            let [first, some, all] = rays(manner, scene.knobs.error_bound);
            for (r, mix) in receivers.iter_mut().zip(&mixes) {
                r.cast(scene, mix, (&self.lattice, kind), (first, first), self.occlusion);
            }
            let more = wanting(&receivers, (column * TILE, row * TILE));
            for i in more {
                let (lattice, mix) = ((&self.lattice, kind), &mixes[i]);
                receivers[i].cast(scene, mix, lattice, (some, first), self.occlusion);
                if receivers[i].hits.len() as f32 > MOST_HIT * some as f32 {
                    receivers[i].cast(scene, mix, lattice, (all, first), self.occlusion);
                }
            }
        }
        let irradiance = |mix: &Mix, at: &Vertex, _| mix.irradiance(at);
        let far = self.far(above, &receivers, &mixes, (irradiance, vary_near), PLANE);
        receivers.iter_mut().zip(&far).for_each(|(r, far)| r.far = *far);
        if mixes.iter().flat_map(|mix| &mix.parts).any(|(_, field)| field.has_bright()) {
            let tracer = scene.lit.tracer;
            let of = |mix: &Mix, at: &Vertex, _| mix.bright(tracer, at);
            let bright = self.far(above, &receivers, &mixes, (of, |_, n| arrive_apart(n)), ROUND);
            for ((r, mix), bright) in receivers.iter_mut().zip(&mixes).zip(bright) {
                r.bright = arriving(&bright, mix.open_to_bright(&r.at));
            }
        }
        if let Some(dome) = &self.dome {
            let opening = |mix: &Mix, at: &Vertex, _| mix.opening(at, dome);
            let open = self.far(above, &receivers, &mixes, (opening, vary_near), PLANE);
            receivers.iter_mut().zip(open).for_each(|(r, open)| r.opening = open);
        }
        receivers.into_iter().zip(far).collect()
    }

    /// What receivers have of their far fields: where it is smooth enough from every fourth pixel, elsewhere by themselves.
    fn far<const N: usize>(
        &self,
        above: &Above,
        receivers: &[Receiver],
        mixes: &[Mix],
        (of, differ): (
            impl Fn(&Mix, &Vertex, Pixel) -> [f32; N],
            impl Fn(&Receiver, &[[f32; N]; 4]) -> bool,
        ),
        alike: Alike,
    ) -> Vec<[f32; N]> {
        let mut nodes = Nodes { picture: self, above, of: &of, kept: Vec::new() };
        let both = receivers.iter().zip(mixes);
        both.map(|(r, mix)| {
            nodes.interpolated(r, &differ, alike).unwrap_or_else(|| of(mix, &r.at, r.pixel))
        })
        .collect()
    }

    /// The fields that a pixel mixes, and their shares: those of the four tiles or quarters whose
    /// centres are around it, where their clusters are near enough.
    fn mix<'t>(&'t self, above: &Above<'t>, pixel: Pixel, position: Vec3) -> Mix<'t> {
        let (own_column, own_row) = (pixel.0 / TILE, pixel.1 / TILE);
        let side = if above.tile(own_column, own_row).busy { BUSY.side } else { CALM.side };
        let place = |v: usize| (v as f32 + 0.5) / side as f32 - 0.5;
        let (x, y) = (place(pixel.0), place(pixel.1));
        let mut parts: Vec<(f32, &Field)> = Vec::with_capacity(4);
        for (dx, dy) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
            let (u, v) = (x.floor() as isize + dx, y.floor() as isize + dy);
            let share = (1.0 - (x - u as f32).abs()) * (1.0 - (y - v as f32).abs());
            if share <= 0.0 || u < 0 || v < 0 {
                continue;
            }
            let cell = (u as usize * side, v as usize * side);
            let own = (cell.0 / side, cell.1 / side) == (pixel.0 / side, pixel.1 / side);
            let Some(field) = above.nearest(cell, side, position, self.columns, self.rows) else {
                continue;
            };
            // The share fades out before the pixel leaves the field's ball.
            let room = 1.0 - field.ball.centre.distance(position) / field.ball.radius.max(1e-30);
            let fade = (4.0 * room).clamp(if own { 1e-3 } else { 0.0 }, 1.0);
            if share * fade > 0.0 {
                parts.push((share * fade, field));
            }
        }
        let total: f32 = parts.iter().map(|p| p.0).sum();
        parts.iter_mut().for_each(|p| p.0 /= total);
        let [a, b] = &self.shapes;
        Mix { parts, shapes: [a, b] }
    }
}

impl<'a> Above<'a> {
    fn tile(&self, column: usize, row: usize) -> &'a Tile {
        &self.rows[row - self.first][column]
    }

    /// The field nearest to a position among those of the tile or quarter at a pixel.
    fn nearest(
        &self,
        cell: Pixel,
        side: usize,
        position: Vec3,
        columns: usize,
        rows: usize,
    ) -> Option<&'a Field> {
        let (column, row) = (cell.0 / TILE, cell.1 / TILE);
        if column >= columns || row >= rows {
            return None;
        }
        let tile = self.tile(column, row);
        let quarter = cell.1 % TILE / BUSY.side * 2 + cell.0 % TILE / BUSY.side;
        let some = match (tile.busy, side == BUSY.side) {
            (true, true) => &tile.fields[quarter..=quarter],
            _ => &tile.fields[..],
        };
        let distance = |f: &&Field| f.ball.centre.distance_squared(position);
        some.iter().flatten().min_by(|a, b| distance(a).total_cmp(&distance(b)))
    }
}

/// Rays of the three passes of a manner for an error bound.
fn rays(manner: Manner, bound: f32) -> [u32; 3] {
    let more = (USUAL_BOUND / bound).powi(2).clamp(0.25, 64.0);
    manner.rays.map(|n| (n as f32 * more).ceil() as u32)
}

/// The receivers of a tile that hit something, or have a neighbour that did.
fn wanting(receivers: &[Receiver], corner: Pixel) -> Vec<usize> {
    let mut near = [false; (TILE + 2) * (TILE + 2)];
    for r in receivers.iter().filter(|r| !r.hits.is_empty()) {
        let (x, y) = (r.pixel.0 - corner.0, r.pixel.1 - corner.1);
        for (dx, dy) in (0..9).map(|i| (i % 3, i / 3)) {
            near[(y + dy) * (TILE + 2) + x + dx] = true;
        }
    }
    let is_near = |r: &Receiver| {
        let (x, y) = (r.pixel.0 - corner.0 + 1, r.pixel.1 - corner.1 + 1);
        near[y * (TILE + 2) + x]
    };
    (0..receivers.len()).filter(|&i| is_near(&receivers[i])).collect()
}

/// Whether what nodes have differs much where near rays hit.
fn vary_near<const N: usize>(receiver: &Receiver, nodes: &[[f32; N]; 4]) -> bool {
    !receiver.hits.is_empty() && vary(nodes)
}

/// How much alike nodes must be.
#[derive(Clone, Copy)]
struct Alike {
    /// Between normals, at least.
    cosine: f32,
    /// Above a receiver's plane or below it, in its footprints, at most.
    height: f32,
}

/// On one plane.
const PLANE: Alike = Alike { cosine: 0.9998, height: 1.0 };
/// On one surface.
const ROUND: Alike = Alike { cosine: 0.8, height: 4.0 };

/// What arrives of what could, where so much of another sum does.
fn arriving(other: &[f32; 6], open: [f32; 3]) -> [f32; 3] {
    std::array::from_fn(|c| {
        let share = if other[3 + c] > 0.0 { other[c] / other[3 + c] } else { 0.0 };
        open[c] * share
    })
}

/// Whether what arrives at nodes of what could differs much.
fn arrive_apart(nodes: &[[f32; 6]; 4]) -> bool {
    (0..3).any(|c| spread(nodes, c) > ARRIVE_APART * most(nodes, 3..6))
}

/// Whether what nodes have differs much.
fn vary<const N: usize>(nodes: &[[f32; N]; 4]) -> bool {
    [0..3, 3..N].into_iter().any(|channels| {
        let most = most(nodes, channels.clone());
        channels.into_iter().any(|c| spread(nodes, c) > LINEAR * most)
    })
}

/// The largest magnitude in some channels of nodes.
fn most<const N: usize>(nodes: &[[f32; N]; 4], channels: std::ops::Range<usize>) -> f32 {
    nodes.iter().flat_map(|n| &n[channels.clone()]).fold(0.0, |m, v| v.abs().max(m))
}

/// The largest difference in a channel of nodes.
fn spread<const N: usize>(nodes: &[[f32; N]; 4], channel: usize) -> f32 {
    let all = nodes.map(|n| n[channel]);
    all.into_iter().fold(f32::MIN, f32::max) - all.into_iter().fold(f32::MAX, f32::min)
}

/// What every fourth pixel of a tile has of its far fields, as far as it was asked for.
struct Nodes<'a, 'b, 'c, T: Hierarchy, F, const N: usize> {
    picture: &'a Picture<'b, 'c, T>,
    above: &'a Above<'a>,
    of: &'a F,
    kept: Vec<(Pixel, [f32; N])>,
}

impl<T: Hierarchy, F: Fn(&Mix, &Vertex, Pixel) -> [f32; N], const N: usize>
    Nodes<'_, '_, '_, T, F, N>
{
    /// What a receiver has by the four nodes around it, if all are alike and do not differ much.
    fn interpolated(
        &mut self,
        receiver: &Receiver,
        differ: impl Fn(&Receiver, &[[f32; N]; 4]) -> bool,
        alike: Alike,
    ) -> Option<[f32; N]> {
        let (width, height) = self.picture.buffer.size();
        let (x, y) = receiver.pixel;
        let (x0, y0) = (x / NODE * NODE, y / NODE * NODE);
        let (x1, y1) = ((x0 + NODE).min(width - 1), (y0 + NODE).min(height - 1));
        let corners = [(x0, y0), (x1, y0), (x0, y1), (x1, y1)];
        if !corners.iter().all(|c| self.is_alike(receiver, *c, alike)) {
            return None;
        }
        let share = |v: usize, low: usize, high: usize| match high > low {
            true => (v - low) as f32 / (high - low) as f32,
            false => 0.0,
        };
        let (u, v) = (share(x, x0, x1), share(y, y0, y1));
        let weights = [(1.0 - u) * (1.0 - v), u * (1.0 - v), (1.0 - u) * v, u * v];
        let all = corners.map(|corner| self.at(corner));
        if differ(receiver, &all) {
            return None;
        }
        Some(std::array::from_fn(|c| (0..4).map(|i| weights[i] * all[i][c]).sum()))
    }

    /// Whether a node's pixel lies and faces as the receiver does.
    fn is_alike(&self, receiver: &Receiver, node: Pixel, most: Alike) -> bool {
        let buffer = self.picture.buffer;
        let at = &receiver.at;
        let alike = |n: [f32; 3], own: Vec3| Vec3::from(n).dot(own) > most.cosine;
        buffer.covered[node]
            && alike(buffer.normal[node], at.normal)
            && alike(buffer.geometric_normal[node], at.side)
            && (Vec3::from(buffer.position[node]) - at.position).dot(at.side).abs()
                <= most.height * receiver.footprint
    }

    fn at(&mut self, node: Pixel) -> [f32; N] {
        if let Some((_, far)) = self.kept.iter().find(|(p, _)| *p == node) {
            return *far;
        }
        let picture = self.picture;
        let at = Vertex::of_pixel(picture.scene.lit.tracer, picture.buffer, node);
        let far = (self.of)(&picture.mix(self.above, node, at.position), &at, node);
        self.kept.push((node, far));
        far
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nodes_vary_by_their_light_whatever_is_open() {
        let nodes = |light: [f32; 4]| light.map(|l| [l, 0.1, 0.1, 3.0]);
        assert!(!vary(&nodes([0.1; 4])));
        assert!(!vary(&nodes([0.1, 0.1, 0.095, 0.095])));
        assert!(vary(&nodes([0.1, 0.1, 0.07, 0.07])));
    }
}
