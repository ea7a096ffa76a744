//! Shared gathers: one cube buffer for the pixels of a tile, and short rays for what differs
//! between them.
//!
//! 1. The pixels of a tile are put into clusters that are close in position; normals may differ,
//!    since the buffer is a full sphere.
//! 2. One cut is made at a cluster's centre, with only what lies beyond the radius D around it.
//! 3. A pixel's far irradiance is the sum over texels of radiance times the pixel's own cosine,
//!    towards where the texel's surface stands seen from the pixel.
//! 4. Its near field is a few rays of cosine density that end at the sphere of radius D. A hit adds
//!    its radiance less the far radiance of that direction, a miss nothing: the far buffer is a
//!    control variate, and what rays must tell is only the residual.
//! 5. A pixel mixes the buffers of the four tiles around it, far and near parts alike, by its place
//!    between their centres: tiles do not show. One set of rays serves all four.
//! 6. Hits are pooled: a pixel also uses those of its neighbours, weighed by the balance heuristic
//!    over all pixels that could have found them. Where a 3 x 3 window shares a plane, its mean is
//!    taken at the end.
//!
//! Tiles where many rays hit are done again in smaller tiles with more rays.

use crate::cube::{CubeBuffer, CubeShape};
use crate::cut::{Chooser, Splat};
use crate::hierarchy::Hierarchy;
use crate::indirect::{Indirect, Prepared};
use crate::near;
use chiaro_basis::math::Vec3;
use chiaro_basis::{Result, Run, random};
use chiaro_image::Plane;
use chiaro_scene::Bounds;
use chiaro_trace::{GBuffer, Sequence, Sides, Vertex};
use rayon::prelude::*;
use std::f32::consts::PI;

/// How a kind of tile is done.
#[derive(Clone, Copy, Debug)]
struct Manner {
    /// Pixels along a side.
    tile: usize,
    /// Texels along a side of the buffer, as a share of the knob.
    resolution: f32,
    /// The threshold, as a multiple of the knob.
    threshold: f32,
    /// D over the cluster's radius.
    reach: f32,
    /// Rays a pixel: of the first pass, and more where that pass hit.
    rays: [u32; 2],
}

/// Smooth surroundings.
const CALM: Manner =
    Manner { tile: 16, resolution: 1.0, threshold: 1.0, reach: 1.5, rays: [8, 24] };
/// Dense detail.
const BUSY: Manner =
    Manner { tile: 8, resolution: 2.0 / 3.0, threshold: 1.5, reach: 2.0, rays: [40, 0] };
/// The share of hits among the first rays over which a tile is busy.
const BUSY_HITS: f32 = 0.3;
/// The error bound that the numbers of rays are stated for.
const USUAL_BOUND: f32 = 0.1;
/// Neighbours within so many footprints share hits.
const POOL: f32 = 3.0;

/// A pixel of a cluster.
struct Receiver {
    pixel: (usize, usize),
    at: Vertex,
    footprint: f32,
    far: [f32; 3],
    rays: u32,
    hits: Vec<Residual>,
}

/// What a near ray found beyond what the far buffer says.
#[derive(Clone, Copy)]
struct Residual {
    position: Vec3,
    light: [f32; 3],
}

/// A pixel's irradiance; `calm` pixels may be filtered.
struct Outcome {
    pixel: (usize, usize),
    irradiance: [f32; 3],
    calm: bool,
}

/// Buffers that a thread uses again and again.
struct Workspace {
    calm: CubeBuffer,
    busy: CubeBuffer,
    splats: Vec<Splat>,
}

/// A cluster of a tile and what surrounds it.
struct Cluster {
    pixels: Vec<(usize, usize)>,
    field: Field,
}

/// Everything that the tiles of a picture share.
struct Picture<'a, 'b, T: Hierarchy> {
    scene: &'a Prepared<'b, T>,
    buffer: &'a GBuffer,
    shape: CubeShape,
    /// Tiles in a row.
    columns: usize,
    /// The clusters of each tile.
    tiles: Vec<Vec<Cluster>>,
}

/// Irradiance by reflected light at the covered pixels.
pub(crate) fn indirect<T: Hierarchy>(
    scene: &Prepared<T>,
    buffer: &GBuffer,
    run: &Run,
) -> Result<Indirect> {
    let (width, height) = buffer.size();
    let side = |m: Manner| (scene.knobs.resolution as f32 * m.resolution).round().max(2.0) as usize;
    let work = || Workspace {
        calm: CubeBuffer::new(CubeShape::new(side(CALM))),
        busy: CubeBuffer::new(CubeShape::new(side(BUSY))),
        splats: Vec::new(),
    };
    let (columns, rows) = (width.div_ceil(CALM.tile), height.div_ceil(CALM.tile));
    let fields: Vec<(Vec<Cluster>, [u64; 2])> = (0..columns * rows)
        .into_par_iter()
        .map_init(work, |work, index| {
            run.check()?;
            Ok(fields(scene, buffer, (index % columns, index / columns), work))
        })
        .collect::<Result<_>>()?;
    let mut counts = fields.iter().fold([0, 0], |s, f| [s[0] + f.1[0], s[1] + f.1[1]]);
    let tiles = fields.into_iter().map(|f| f.0).collect();
    let picture = Picture { scene, buffer, shape: CubeShape::new(side(CALM)), columns, tiles };
    let done: Vec<(Vec<Outcome>, [u64; 2])> = (0..columns * rows)
        .into_par_iter()
        .map_init(work, |work, index| {
            run.check()?;
            Ok(picture.tile(index, work))
        })
        .collect::<Result<_>>()?;
    let mut irradiance = Plane::filled(width, height, [0.0; 3]);
    let mut calm = Plane::filled(width, height, false);
    for (outcomes, [g, v]) in done {
        counts = [counts[0] + g, counts[1] + v];
        for o in outcomes {
            irradiance[o.pixel] = o.irradiance;
            calm[o.pixel] = o.calm;
        }
    }
    let irradiance = filtered(buffer, &irradiance, &calm);
    Ok(Indirect { irradiance, gathers: counts[0], visited: counts[1] })
}

/// The clusters of a tile with their buffers.
fn fields<T: Hierarchy>(
    scene: &Prepared<T>,
    buffer: &GBuffer,
    (column, row): (usize, usize),
    work: &mut Workspace,
) -> (Vec<Cluster>, [u64; 2]) {
    let (width, height) = buffer.size();
    let (x0, y0) = (column * CALM.tile, row * CALM.tile);
    let pixels: Vec<(usize, usize)> = (y0..(y0 + CALM.tile).min(height))
        .flat_map(|y| (x0..(x0 + CALM.tile).min(width)).map(move |x| (x, y)))
        .filter(|p| buffer.covered[*p])
        .collect();
    let mut counts = [0, 0];
    let done = clusters(buffer, pixels, CALM.tile)
        .into_iter()
        .map(|pixels| {
            let Workspace { calm, splats, .. } = work;
            let field = Field::gather(scene, buffer, &pixels, CALM, calm, splats, &mut counts);
            Cluster { pixels, field }
        })
        .collect();
    (done, counts)
}

impl<T: Hierarchy> Picture<'_, '_, T> {
    /// One tile: its clusters, the busy ones in quarters.
    fn tile(&self, index: usize, work: &mut Workspace) -> (Vec<Outcome>, [u64; 2]) {
        let mut outcomes = Vec::new();
        let mut counts = [0, 0];
        for cluster in &self.tiles[index] {
            if self.calm(cluster, &mut outcomes) {
                continue;
            }
            let half =
                |p: &(usize, usize)| (p.0 % CALM.tile / BUSY.tile, p.1 % CALM.tile / BUSY.tile);
            for quarter in [(0, 0), (1, 0), (0, 1), (1, 1)] {
                let some = cluster.pixels.iter().copied().filter(|p| half(p) == quarter).collect();
                for part in clusters(self.buffer, some, BUSY.tile) {
                    self.busy(&part, work, &mut outcomes, &mut counts);
                }
            }
        }
        (outcomes, counts)
    }

    /// The fields that a pixel of a cluster mixes, and their shares: those of the four tiles whose
    /// centres are around it, where their clusters are near enough.
    fn mix<'c>(&'c self, cluster: &'c Cluster, receiver: &Receiver) -> Vec<(f32, &'c Field)> {
        let tile = CALM.tile as f32;
        let at = |v: usize| (v as f32 + 0.5) / tile - 0.5;
        let (x, y) = (at(receiver.pixel.0), at(receiver.pixel.1));
        let rows = self.tiles.len() / self.columns;
        let own = (receiver.pixel.0 / CALM.tile, receiver.pixel.1 / CALM.tile);
        let mut fields = Vec::with_capacity(4);
        for (dx, dy) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
            let (u, v) = (x.floor() as isize + dx, y.floor() as isize + dy);
            let share = (1.0 - (x - u as f32).abs()) * (1.0 - (y - v as f32).abs());
            if share <= 0.0 || u < 0 || v < 0 || u as usize >= self.columns || v as usize >= rows {
                continue;
            }
            let (u, v) = (u as usize, v as usize);
            if (u, v) == own {
                fields.push((share.max(1e-3), &cluster.field));
                continue;
            }
            let position = receiver.at.position;
            let distance = |c: &&Cluster| c.field.centre.distance(position);
            let near = self.tiles[v * self.columns + u]
                .iter()
                .min_by(|a, b| distance(a).total_cmp(&distance(b)));
            // The share fades out before the pixel leaves the field's sphere.
            let Some(near) = near else { continue };
            let room = 1.0 - distance(&near) / near.field.reach.max(f32::MIN_POSITIVE);
            let share = share * (4.0 * room).clamp(0.0, 1.0);
            if share > 0.0 {
                fields.push((share, &near.field));
            }
        }
        let total: f32 = fields.iter().map(|f| f.0).sum();
        fields.iter_mut().for_each(|f| f.0 /= total);
        fields
    }

    /// Does a cluster in the calm manner; false, with nothing done, when that does not suit it.
    fn calm(&self, cluster: &Cluster, outcomes: &mut Vec<Outcome>) -> bool {
        let knobs = &self.scene.knobs;
        let mut receivers: Vec<Receiver> =
            cluster.pixels.iter().map(|p| Receiver::new(self.scene, self.buffer, *p)).collect();
        let mixes: Vec<Vec<(f32, &Field)>> =
            receivers.iter().map(|r| self.mix(cluster, r)).collect();
        let [first, second] = rays(CALM, knobs.error_bound);
        if knobs.near_field {
            for (r, mix) in receivers.iter_mut().zip(&mixes) {
                near(self.scene, self.buffer, &self.shape, mix, r, 0..first);
            }
            let hits: usize = receivers.iter().map(|r| r.hits.len()).sum();
            if hits as f32 > BUSY_HITS * (first as usize * receivers.len()) as f32 {
                return false;
            }
            for i in wanting(&receivers) {
                let r = &mut receivers[i];
                near(self.scene, self.buffer, &self.shape, &mixes[i], r, first..first + second);
            }
        }
        for (r, mix) in receivers.iter_mut().zip(&mixes) {
            r.far = far(mix, &r.at);
        }
        finish(&receivers, true, outcomes);
        true
    }

    /// Does a small cluster in the busy manner.
    fn busy(
        &self,
        pixels: &[(usize, usize)],
        work: &mut Workspace,
        outcomes: &mut Vec<Outcome>,
        counts: &mut [u64; 2],
    ) {
        let (scene, buffer) = (self.scene, self.buffer);
        let Workspace { busy, splats, .. } = work;
        let field = Field::gather(scene, buffer, pixels, BUSY, busy, splats, counts);
        let mix = [(1.0, &field)];
        let [first, _] = rays(BUSY, scene.knobs.error_bound);
        let mut receivers: Vec<Receiver> =
            pixels.iter().map(|p| Receiver::new(scene, buffer, *p)).collect();
        for r in &mut receivers {
            near(scene, buffer, busy.shape(), &mix, r, 0..first);
            r.far = far(&mix, &r.at);
        }
        finish(&receivers, false, outcomes);
    }
}

/// Rays of the two passes of a manner for an error bound.
fn rays(manner: Manner, bound: f32) -> [u32; 2] {
    let more = (USUAL_BOUND / bound).powi(2).clamp(0.25, 64.0);
    manner.rays.map(|n| (n as f32 * more).ceil() as u32)
}

/// Adds the near parts of receivers to their far ones.
fn finish(receivers: &[Receiver], calm: bool, outcomes: &mut Vec<Outcome>) {
    for r in receivers {
        let near = pooled(r, receivers);
        let irradiance = std::array::from_fn(|c| (r.far[c] + near[c]).max(0.0));
        outcomes.push(Outcome { pixel: r.pixel, irradiance, calm });
    }
}

/// Pixels in groups that are close in position: a group much wider than its tile is cut at its
/// widest gap.
fn clusters(
    buffer: &GBuffer,
    pixels: Vec<(usize, usize)>,
    tile: usize,
) -> Vec<Vec<(usize, usize)>> {
    let (_, height) = buffer.size();
    let mut done = Vec::new();
    let mut open = vec![pixels];
    while let Some(group) = open.pop().filter(|g| !g.is_empty()) {
        let place = |p: &(usize, usize)| Vec3::from(buffer.position[*p]);
        let bounds = Bounds::of(group.iter().map(place));
        let depth = group.iter().map(|p| buffer.depth[*p]).fold(f32::INFINITY, f32::min);
        let size = tile as f32 * buffer.pose.pixel_size(depth, height as f32);
        if bounds.radius() <= 1.5 * size || group.len() < 2 {
            done.push(group);
            continue;
        }
        let axis = (bounds.max - bounds.min).max_position();
        let mut sorted = group;
        sorted.sort_by(|a, b| place(a)[axis].total_cmp(&place(b)[axis]).then(a.cmp(b)));
        let gap = |i: &usize| place(&sorted[*i])[axis] - place(&sorted[*i - 1])[axis];
        let at = (1..sorted.len()).max_by(|a, b| gap(a).total_cmp(&gap(b))).unwrap_or(1);
        // Slanted surfaces have no gap: they are halved, and only when they are very long.
        let at = match gap(&at) > 0.25 * (bounds.max - bounds.min)[axis] {
            true => at,
            false if bounds.radius() > 4.0 * size => sorted.len() / 2,
            false => {
                done.push(sorted);
                continue;
            }
        };
        let rest = sorted.split_off(at);
        open.push(rest);
        open.push(sorted);
    }
    done.iter_mut().for_each(|group| group.sort_by_key(|&(x, y)| (y, x)));
    done
}

/// The receivers that hit something, or have a neighbour that did.
fn wanting(receivers: &[Receiver]) -> Vec<usize> {
    let hit: Vec<(usize, usize)> =
        receivers.iter().filter(|r| !r.hits.is_empty()).map(|r| r.pixel).collect();
    let near =
        |p: (usize, usize)| hit.iter().any(|h| h.0.abs_diff(p.0) <= 1 && h.1.abs_diff(p.1) <= 1);
    (0..receivers.len()).filter(|&i| near(receivers[i].pixel)).collect()
}

/// What lies beyond the near field of a cluster.
struct Field {
    centre: Vec3,
    /// D.
    reach: f32,
    /// Radiance of each texel.
    radiance: Vec<[f32; 3]>,
    /// Mean distance of what is in each texel.
    distance: Vec<f32>,
    /// The texels that hold light, in packs.
    lit: Vec<Pack>,
}

/// Texels side by side, so that the compiler can use vectors.
const LANES: usize = 8;

/// Places and radiance times solid angle of a few texels; unused lanes are black.
#[derive(Clone, Copy, Default)]
struct Pack {
    x: [f32; LANES],
    y: [f32; LANES],
    z: [f32; LANES],
    r: [f32; LANES],
    g: [f32; LANES],
    b: [f32; LANES],
}

impl Field {
    fn gather<T: Hierarchy>(
        scene: &Prepared<T>,
        buffer: &GBuffer,
        pixels: &[(usize, usize)],
        manner: Manner,
        far: &mut CubeBuffer,
        splats: &mut Vec<Splat>,
        counts: &mut [u64; 2],
    ) -> Self {
        let bounds = Bounds::of(pixels.iter().map(|p| Vec3::from(buffer.position[*p])));
        let centre = bounds.centre();
        let radius = pixels
            .iter()
            .map(|p| Vec3::from(buffer.position[*p]).distance(centre))
            .fold(0.0, f32::max);
        let knobs = &scene.knobs;
        let threshold = knobs.solid_angle * manner.threshold * far.shape().mean_solid_angle();
        let leaf = scene.tree.leaf_radius() / (threshold / PI).sqrt();
        let reach = if knobs.near_field { leaf.max(manner.reach * radius) } else { 0.0 };
        let chooser =
            Chooser { from: centre, threshold, near: reach, above: None, flat: knobs.flat_nodes };
        far.clear();
        splats.clear();
        counts[0] += 1;
        counts[1] += scene.tree.cut(&chooser, splats);
        far.add_sorted(splats);
        Self::of_buffer(far, centre, reach)
    }

    fn of_buffer(far: &CubeBuffer, centre: Vec3, reach: f32) -> Self {
        let shape = far.shape();
        let count = far.texels().len();
        let radiance: Vec<[f32; 3]> = (0..count).map(|i| far.radiance(i)).collect();
        let distance: Vec<f32> = far.texels().iter().map(|t| t.mean_distance()).collect();
        let lit: Vec<usize> = (0..count).filter(|i| radiance[*i] != [0.0; 3]).collect();
        let pack = |texels: &[usize]| {
            let mut pack = Pack::default();
            for (lane, &i) in texels.iter().enumerate() {
                let place = centre + shape.directions[i] * distance[i];
                [pack.x[lane], pack.y[lane], pack.z[lane]] = place.to_array();
                let light = radiance[i].map(|l| l * shape.solid_angles[i]);
                [pack.r[lane], pack.g[lane], pack.b[lane]] = light;
            }
            pack
        };
        let lit = lit.chunks(LANES).map(pack).collect();
        Self { centre, reach, radiance, distance, lit }
    }

    /// Irradiance of a receiver by the far field.
    fn irradiance(&self, at: &Vertex) -> [f32; 3] {
        let (p, n, s) = (at.position, at.normal, at.side);
        let mut sum = Pack::default();
        for t in &self.lit {
            for k in 0..LANES {
                let (x, y, z) = (t.x[k] - p.x, t.y[k] - p.y, t.z[k] - p.z);
                let above = x * s.x + y * s.y + z * s.z > 0.0;
                let cosine = (x * n.x + y * n.y + z * n.z).max(0.0)
                    / (x * x + y * y + z * z).sqrt().max(f32::MIN_POSITIVE);
                let cosine = if above { cosine } else { 0.0 };
                sum.r[k] += cosine * t.r[k];
                sum.g[k] += cosine * t.g[k];
                sum.b[k] += cosine * t.b[k];
            }
        }
        [sum.r, sum.g, sum.b].map(|lanes| lanes.iter().sum())
    }

    /// Far radiance along a ray: of the texel in which the ray, as long as things are far there,
    /// ends.
    fn radiance(&self, shape: &CubeShape, origin: Vec3, direction: Vec3) -> [f32; 3] {
        let first = shape.texel(direction);
        let distance = self.distance[first];
        if !distance.is_finite() {
            return self.radiance[first];
        }
        self.radiance[shape.texel(origin + direction * distance - self.centre)]
    }

    /// How far a ray goes inside the sphere; nothing when it starts outside.
    fn exit(&self, origin: Vec3, direction: Vec3) -> f32 {
        let offset = origin - self.centre;
        let inside = self.reach * self.reach - offset.length_squared();
        if inside <= 0.0 {
            return 0.0;
        }
        let along = offset.dot(direction);
        (along * along + inside).sqrt() - along
    }
}

/// Far irradiance of a receiver, mixed from several fields.
fn far(mix: &[(f32, &Field)], at: &Vertex) -> [f32; 3] {
    let mut sum = [0.0; 3];
    for (share, field) in mix {
        let e = field.irradiance(at);
        (0..3).for_each(|c| sum[c] += share * e[c]);
    }
    sum
}

/// Casts a receiver's near rays; a hit counts for every field whose sphere holds it.
fn near<T: Hierarchy>(
    scene: &Prepared<T>,
    buffer: &GBuffer,
    shape: &CubeShape,
    mix: &[(f32, &Field)],
    receiver: &mut Receiver,
    rays: std::ops::Range<u32>,
) {
    let at = receiver.at;
    let (x, y) = receiver.pixel;
    let sequence = Sequence::new((y * buffer.size().0 + x) as u64);
    let origin = at.position + at.side * at.offset;
    for k in rays {
        receiver.rays += 1;
        let direction = at.cosine_direction(lattice(k, (x, y), scene.shift));
        if direction.dot(at.side) <= 0.0 {
            continue;
        }
        let longest = mix.iter().map(|(_, f)| f.exit(origin, direction)).fold(0.0, f32::max);
        let ray = at.ray(direction, longest);
        let Some(hit) = scene.lit.tracer.hit(&ray, Sides::Both) else { continue };
        let (lit, surfels) = (&scene.lit, &scene.surfels);
        let met = near::shade(lit, surfels, &scene.reflected, &hit, direction, &sequence, k);
        let mut light = [0.0; 3];
        for (share, field) in mix.iter().filter(|(_, f)| hit.t <= f.exit(origin, direction)) {
            let far = field.radiance(shape, origin, direction);
            (0..3).for_each(|c| light[c] += share * (met.radiance[c] - far[c]));
        }
        receiver.hits.push(Residual { position: met.position, light });
    }
}

/// Point `k` of a pixel's lattice: one additive recurrence for all, shifted inside its cells by the
/// pixel's place in a 4 x 4 pattern. `shift` moves the whole pattern.
fn lattice(k: u32, (x, y): (usize, usize), shift: u32) -> [f32; 2] {
    const ORDER: [usize; 16] = [0, 8, 2, 10, 12, 4, 14, 6, 3, 11, 1, 9, 15, 7, 13, 5];
    const CELL: f32 = 0.18;
    let place = ORDER[(y % 4) * 4 + x % 4];
    let [u, v] = random::r2(u64::from(k) + 977 * u64::from(shift));
    let (dx, dy) = ((place % 4) as f32 + 0.5, (place / 4) as f32 + 0.5);
    [(u + CELL * 0.25 * dx).fract(), (v + CELL * 0.25 * dy).fract()]
}

impl Receiver {
    fn new<T: Hierarchy>(scene: &Prepared<T>, buffer: &GBuffer, pixel: (usize, usize)) -> Self {
        let at = Vertex::of_pixel(scene.lit.tracer, buffer, pixel);
        let footprint = buffer.pose.pixel_size(buffer.depth[pixel], buffer.size().1 as f32);
        Self { pixel, at, footprint, far: [0.0; 3], rays: 0, hits: Vec::new() }
    }

    /// The geometry term of cosine density: cosine over square distance.
    fn term(&self, position: Vec3) -> f32 {
        let offset = position - self.at.position;
        let square = offset.length_squared().max(1e-20);
        offset.dot(self.at.normal).max(0.0) / (square * square.sqrt())
    }
}

/// Near irradiance from the hits of a receiver and its neighbours: each counts as its own geometry
/// term over the sum of the terms with which all of them look for it.
fn pooled(receiver: &Receiver, all: &[Receiver]) -> [f32; 3] {
    let reach = POOL * receiver.footprint;
    let (x, y) = receiver.pixel;
    let neighbours: Vec<&Receiver> = all
        .iter()
        .filter(|m| {
            m.pixel.0.abs_diff(x) <= 1
                && m.pixel.1.abs_diff(y) <= 1
                && m.at.position.distance(receiver.at.position) <= reach
        })
        .collect();
    let mut sum = [0.0; 3];
    for hit in neighbours.iter().flat_map(|m| &m.hits) {
        let own = receiver.term(hit.position);
        if own <= 0.0 {
            continue;
        }
        let found: f32 = neighbours.iter().map(|m| m.rays as f32 * m.term(hit.position)).sum();
        let weight = PI * own / found;
        (0..3).for_each(|c| sum[c] += weight * hit.light[c]);
    }
    sum
}

/// The mean over 3 x 3 pixels where all are calm and share a plane.
fn filtered(buffer: &GBuffer, irradiance: &Plane<[f32; 3]>, calm: &Plane<bool>) -> Plane<[f32; 3]> {
    let (_, height) = buffer.size();
    buffer.over_covered(|x, y| {
        let normal = Vec3::from(buffer.normal[(x, y)]);
        let position = Vec3::from(buffer.position[(x, y)]);
        let tolerance = buffer.pose.pixel_size(buffer.depth[(x, y)], height as f32);
        let mut sum = [0.0; 3];
        for dy in -1..2isize {
            for dx in -1..2isize {
                let (u, v) = (x as isize + dx, y as isize + dy);
                let at = (u.max(0) as usize, v.max(0) as usize);
                let shares = calm.at(u, v) == Some(&true)
                    && buffer.covered[at]
                    && (Vec3::from(buffer.position[at]) - position).dot(normal).abs() <= tolerance
                    && Vec3::from(buffer.normal[at]).dot(normal) > 0.98;
                if !shares {
                    return irradiance[(x, y)];
                }
                (0..3).for_each(|c| sum[c] += irradiance[at][c]);
            }
        }
        sum.map(|s| s / 9.0)
    })
}
