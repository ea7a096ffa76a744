//! Ambient occlusion: the cosine-weighted share of the hemisphere that is open.
//!
//! 1. A set of cosine-weighted directions, low in discrepancy, is dealt to the 16 pixels of a 4 x 4
//!    tile, so that each pixel casts few rays and no two pixels of a tile cast the same.
//! 2. The raw values are averaged over the 4 x 4 window around each pixel, which holds every share
//!    of the deal once; neighbours off the pixel's plane or turned away are left out.
//!
//! Guaranteed: deterministic, and free of noise on smooth surfaces, since every window holds the
//! whole set. Not guaranteed: on surfaces a few pixels wide, fewer directions are left.

use crate::gbuffer::GBuffer;
use crate::tracer::{Ray, Tracer};
use chiaro_basis::math::Vec3;
use chiaro_basis::{Result, Run, random};
use chiaro_image::Plane;

/// Pixels along a tile's side.
const TILE: usize = 4;

/// Openness in [0, 1] within `radius` scene units; `rays` are cast a pixel, 16 times as many count.
pub fn ambient_occlusion(
    tracer: &Tracer,
    buffer: &GBuffer,
    radius: f32,
    rays: usize,
    run: &Run,
) -> Result<Plane<f32>> {
    let deal = deal(rays);
    let raw = buffer.over_covered(|x, y| {
        if run.check().is_err() {
            return 0.0;
        }
        openness(tracer, buffer, (x, y), &deal[tile_index(x, y)], radius)
    });
    run.check()?;
    Ok(filtered(buffer, &raw))
}

fn tile_index(x: usize, y: usize) -> usize {
    (y % TILE) * TILE + x % TILE
}

/// Directions around +z for each pixel of a tile. Consecutive points of the sequence go to
/// different pixels, so that each pixel's share is spread as well as the whole.
fn deal(rays: usize) -> Vec<Vec<Vec3>> {
    // Each pixel takes every 16th point, starting at a place that is far from its neighbours'.
    const ORDER: [usize; TILE * TILE] = [0, 8, 2, 10, 12, 4, 14, 6, 3, 11, 1, 9, 15, 7, 13, 5];
    ORDER
        .iter()
        .map(|&start| (0..rays).map(|i| cosine_direction(start + i * TILE * TILE)).collect())
        .collect()
}

/// Point `index` of a low-discrepancy, cosine-weighted set on the hemisphere around +z.
fn cosine_direction(index: usize) -> Vec3 {
    let [u, v] = random::r2(index as u64);
    let (r, angle) = (u.sqrt(), std::f32::consts::TAU * v);
    Vec3::new(r * angle.cos(), r * angle.sin(), (1.0 - u).sqrt())
}

fn openness(
    tracer: &Tracer,
    buffer: &GBuffer,
    pixel: (usize, usize),
    directions: &[Vec3],
    radius: f32,
) -> f32 {
    let normal = Vec3::from(buffer.normal[pixel]);
    let side = Vec3::from(buffer.geometric_normal[pixel]);
    let origin = Vec3::from(buffer.position[pixel]) + side * (1e-4 * buffer.radius);
    let (right, up) = normal.any_orthonormal_pair();
    let open = |d: &&Vec3| {
        let direction = right * d.x + up * d.y + normal * d.z;
        // Below the triangle there is nothing to see but the triangle.
        direction.dot(side) <= 0.0 || !tracer.occluded(&Ray { origin, direction, t_max: radius })
    };
    directions.iter().filter(open).count() as f32 / directions.len() as f32
}

/// The mean over the 4 x 4 window, of those pixels that lie on the same smooth surface.
fn filtered(buffer: &GBuffer, raw: &Plane<f32>) -> Plane<f32> {
    let (_, height) = buffer.size();
    buffer.over_covered(|x, y| {
        let normal = Vec3::from(buffer.normal[(x, y)]);
        let position = Vec3::from(buffer.position[(x, y)]);
        let tolerance = 4.0 * buffer.pose.pixel_size(buffer.depth[(x, y)], height as f32);
        let (mut sum, mut count) = (0.0, 0.0);
        for dy in -2..2isize {
            for dx in -2..2isize {
                let (u, v) = (x as isize + dx, y as isize + dy);
                if buffer.covered.at(u, v) != Some(&true) {
                    continue;
                }
                let at = (u as usize, v as usize);
                let off_plane = (Vec3::from(buffer.position[at]) - position).dot(normal).abs();
                let bend = Vec3::from(buffer.normal[at]).dot(normal);
                if off_plane <= tolerance && bend > 0.8 {
                    sum += raw[at];
                    count += 1.0;
                }
            }
        }
        if count > 0.0 { sum / count } else { raw[(x, y)] }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_tile_holds_the_whole_cosine_weighted_set() {
        let all: Vec<Vec3> = deal(16).into_iter().flatten().collect();
        let mean = all.iter().sum::<Vec3>() / all.len() as f32;
        assert!((mean - Vec3::new(0.0, 0.0, 2.0 / 3.0)).length() < 0.01, "{mean}");
        assert!(all.iter().all(|d| (d.length() - 1.0).abs() < 1e-5 && d.z >= 0.0));
    }
}
