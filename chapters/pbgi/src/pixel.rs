//! Every receiver by itself: the reference mode of the gather.
//!
//! The receiver's cube buffer takes near rays first, one for each quarter of a texel above the
//! tangent plane in which leaves were dropped, as long as the distance within which that was done;
//! then the sorted splats of its own cut, the bright ones black. Its irradiance is the sum over texels of radiance times cosine,
//! and what rays to the surfels of bright splats find.

use crate::bright::{self, Arrives, Bright};
use crate::cube::{CubeBuffer, CubeShape};
use crate::cut::{Chooser, Splat};
use crate::hierarchy::Hierarchy;
use crate::indirect::Prepared;
use crate::near;
use crate::opening::{Dome, Opening};
use chiaro_basis::math::Vec3;
use chiaro_trace::{Sequence, Sides, Vertex};
use std::f32::consts::FRAC_1_PI;

/// Buffers that a thread uses again and again.
pub struct Workspace {
    buffer: CubeBuffer,
    splats: Vec<Splat>,
    /// Texels in which something is near.
    near: Vec<bool>,
    quarters: CubeQuarters,
}

impl Workspace {
    /// For buffers of `side` x `side` texels a face.
    pub fn new(side: usize) -> Self {
        Self {
            buffer: CubeBuffer::new(CubeShape::new(side)),
            splats: Vec::new(),
            near: vec![false; 6 * side * side],
            quarters: CubeQuarters::new(side),
        }
    }

    /// The buffer as the last gather left it.
    pub fn buffer(&self) -> &CubeBuffer {
        &self.buffer
    }
}

/// What a receiver gathers.
#[derive(Clone, Copy, Debug, Default)]
pub struct Gathered {
    /// Irradiance by reflected light, linear RGB.
    pub irradiance: [f32; 3],
    /// The open share of the hemisphere, by cosine.
    pub openness: f32,
    /// Nodes visited.
    pub visited: u64,
}

/// Gathers at a receiver; what is farther than `occlusion` scene units does not occlude. `seed`
/// tells receivers apart.
pub fn gather<T: Hierarchy>(
    scene: &Prepared<T>,
    at: &Vertex,
    occlusion: f32,
    work: &mut Workspace,
    seed: u64,
) -> Gathered {
    let Workspace { buffer, splats, near: texels, quarters } = work;
    buffer.clear();
    splats.clear();
    let threshold = scene.knobs.solid_angle * buffer.shape().mean_solid_angle();
    // The distance within which a leaf looks larger than the threshold.
    let reach = scene.leaf_radius(at.position, at.side) / (threshold / std::f32::consts::PI).sqrt();
    let near = if scene.knobs.near_field { reach } else { 0.0 };
    let from = at.position + at.side * at.offset;
    let chooser = Chooser {
        from,
        threshold,
        near,
        mark: 0.0,
        above: Some(at.side),
        flat: scene.knobs.flat_nodes,
    };
    let visited = scene.tree.cut(&chooser, splats);
    if scene.knobs.near_field {
        buffer.touched(splats.iter().filter(|s| s.marks), texels);
        splats.retain(|s| !s.marks);
        near_rays(scene, at, buffer, (quarters, texels), near, seed);
    }
    let bright = bright(scene, at, buffer.shape(), splats);
    buffer.add_sorted(splats);
    let mut gathered = sum(buffer, at.normal, occlusion);
    (0..3).for_each(|c| gathered.irradiance[c] += bright[c]);
    Gathered { visited, ..gathered }
}

/// Makes bright splats black, and finds what arrives of them, where rays look at all.
fn bright<T: Hierarchy>(
    scene: &Prepared<T>,
    at: &Vertex,
    shape: &CubeShape,
    splats: &mut [Splat],
) -> [f32; 3] {
    if !scene.knobs.near_field {
        return [0.0; 3];
    }
    let groups = bright::take(&scene.tree, at.position, shape, splats);
    let groups: Vec<_> = groups.into_iter().map(|g| (g, Arrives::Some)).collect();
    let here = [Vec3::ZERO, at.normal, at.side];
    let found = Bright::of(&groups, 1.0).irradiance(&here, (at, scene.lit.tracer), 1.0);
    std::array::from_fn(|c| found[c])
}

/// The sums over texels of radiance and of openness times the clamped cosine.
fn sum(buffer: &CubeBuffer, normal: Vec3, occlusion: f32) -> Gathered {
    let mut sum = Gathered { openness: 1.0, ..Gathered::default() };
    let shape = buffer.shape();
    for (i, omega) in shape.solid_angles.iter().enumerate() {
        if buffer.texels()[i].coverage <= 0.0 {
            continue;
        }
        let weight = buffer.towards(i).dot(normal).max(0.0) * omega;
        if weight > 0.0 {
            let radiance = buffer.radiance(i);
            (0..3).for_each(|c| sum.irradiance[c] += radiance[c] * weight);
            if buffer.texels()[i].mean_distance() < occlusion {
                sum.openness -= weight * FRAC_1_PI * buffer.coverage(i);
            }
        }
    }
    sum.openness = sum.openness.max(0.0);
    sum
}

/// The opening of a receiver whose buffer was just gathered, under a dome.
pub(crate) fn opening(
    work: &Workspace,
    normal: Vec3,
    side: Vec3,
    occlusion: f32,
    dome: &Dome,
) -> Opening {
    let shape = work.buffer.shape();
    let radiance = dome.of_side(shape.side());
    let mut sum = [0.0; 6];
    for (i, (d, omega)) in shape.directions.iter().zip(&shape.solid_angles).enumerate() {
        if d.dot(side) <= 0.0 {
            continue;
        }
        let near = work.buffer.texels()[i].mean_distance() < occlusion;
        let open = if near { 1.0 - work.buffer.coverage(i) } else { 1.0 };
        let weight = d.dot(normal).max(0.0) * omega * open.max(0.0);
        (0..3).for_each(|c| sum[c] += weight * d[c]);
        (0..3).for_each(|c| sum[3 + c] += weight * radiance[i][c]);
    }
    sum
}

/// Fills quarters of texels with what is near.
fn near_rays<T: Hierarchy>(
    scene: &Prepared<T>,
    at: &Vertex,
    buffer: &mut CubeBuffer,
    (quarters, near): (&CubeQuarters, &[bool]),
    reach: f32,
    seed: u64,
) {
    let sequence = Sequence::new(seed);
    for (index, &(texel, direction, place)) in quarters.directions.iter().enumerate() {
        if !near[texel] {
            continue;
        }
        if direction.dot(at.side) <= 0.0 || direction.dot(at.normal) <= 0.0 {
            continue;
        }
        let ray = at.ray(direction, reach);
        if let Some(hit) = scene.lit.tracer.hit(&ray, Sides::Both) {
            let met = near::shade(
                &scene.lit,
                &scene.surfels,
                &scene.reflected,
                &hit,
                direction,
                &sequence,
                index as u32,
            );
            buffer.fill(texel, met.radiance, hit.t, (0.25, place));
        }
    }
}

/// The quarters of a cube's texels: texel, direction and place in it of each.
struct CubeQuarters {
    directions: Vec<(usize, Vec3, [f32; 2])>,
}

impl CubeQuarters {
    fn new(n: usize) -> Self {
        let quarter = |i: usize| {
            let (face, rest) = (i / (4 * n * n), i % (4 * n * n));
            let (x, y) = (rest % (2 * n), rest / (2 * n));
            let at = |k: usize| (k as f32 + 0.5) / n as f32 - 1.0;
            let texel = (face * n + y / 2) * n + x / 2;
            let place = [x, y].map(|k| 0.5 * (k % 2) as f32 - 0.25);
            (texel, crate::cube::on_face(face, at(x), at(y)).normalize(), place)
        };
        Self { directions: (0..6 * 4 * n * n).map(quarter).collect() }
    }
}
