//! Links through time: which pixel of the previous picture shows what a pixel shows now.

use crate::gbuffer::GBuffer;
use crate::motion::material_point;
use chiaro_basis::math::Vec3;
use chiaro_image::Plane;
use chiaro_scene::{Frame, Scene};

/// The link of a pixel whose material point was not seen one frame before.
pub const UNLINKED: u32 = u32::MAX;

/// When a pixel of the previous picture counts as showing a material point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Match {
    /// The point is within so many pixels of the tangent plane that was seen there, on the same
    /// object.
    Plane(f32),
    /// The depth that was seen there is within this share of the point's.
    Depth(f32),
}

/// For each pixel the place, row by row, of the pixel of `before` that is nearest to where its
/// material point was one frame earlier; [`UNLINKED`] where there is no geometry, where the point
/// was outside the picture, or where something else was seen in its place.
pub fn links(
    buffer: &GBuffer,
    before: &GBuffer,
    scene: &Scene,
    (frame, previous): (&Frame, &Frame),
    rule: Match,
) -> Plane<u32> {
    let (w, h) = before.size();
    let (wf, hf) = (w as f32, h as f32);
    let (width, height) = buffer.size();
    Plane::from_fn(width, height, |x, y| {
        if !buffer.covered[(x, y)] {
            return UNLINKED;
        }
        let place = || {
            let hit = buffer.hit((x, y));
            let point = material_point(scene, frame, previous, &hit)?;
            let [u, v] = before.pose.project(point, wf, hf)?;
            let inside = u >= 0.0 && v >= 0.0 && u < wf && v < hf;
            let at = inside.then_some((u as usize, v as usize))?;
            let same = before.covered[at] && shows(before, at, point, hit.object, rule);
            same.then_some((at.1 * w + at.0) as u32)
        };
        place().unwrap_or(UNLINKED)
    })
}

/// Whether a covered pixel shows a world-space point of an object.
fn shows(buffer: &GBuffer, at: (usize, usize), point: Vec3, object: u32, rule: Match) -> bool {
    match rule {
        Match::Plane(pixels) => {
            let normal = Vec3::from(buffer.geometric_normal[at]);
            let off = (point - Vec3::from(buffer.position[at])).dot(normal).abs();
            let pixel = buffer.pose.pixel_size(buffer.depth[at], buffer.size().1 as f32);
            buffer.object[at] == object + 1 && off <= pixels * pixel
        }
        Match::Depth(share) => {
            let expected = buffer.pose.view(point).z;
            (buffer.depth[at] - expected).abs() <= share * expected.abs()
        }
    }
}
