//! What a pixel shares its smooth surface with.

use crate::gbuffer::GBuffer;
use chiaro_basis::math::Vec3;

/// The tangent plane of a pixel's surface, and how far the surface may leave it.
pub(crate) struct Surroundings {
    position: Vec3,
    normal: Vec3,
    tolerance: f32,
}

/// How large pixels are by their depth, without asking the camera for each.
#[derive(Clone, Copy)]
pub(crate) struct PixelSize {
    nearest: f32,
    per_depth: f32,
}

impl PixelSize {
    /// That of a picture.
    pub(crate) fn of(buffer: &GBuffer) -> Self {
        let size = |depth| buffer.pose.pixel_size(depth, buffer.size().1 as f32);
        Self { nearest: size(0.0), per_depth: size(1.0) - size(0.0) }
    }
}

impl Surroundings {
    /// Those of a pixel; the surface may leave its plane by `reach` pixels.
    pub(crate) fn at(buffer: &GBuffer, size: PixelSize, pixel: (usize, usize), reach: f32) -> Self {
        Self {
            position: Vec3::from(buffer.position[pixel]),
            normal: Vec3::from(buffer.smooth_normal[pixel]),
            tolerance: reach * (size.nearest + size.per_depth * buffer.depth[pixel]),
        }
    }

    /// Whether a pixel lies on the same smooth surface.
    #[inline]
    pub(crate) fn holds(&self, buffer: &GBuffer, pixel: (usize, usize)) -> bool {
        let off = (Vec3::from(buffer.position[pixel]) - self.position).dot(self.normal).abs();
        off <= self.tolerance && Vec3::from(buffer.smooth_normal[pixel]).dot(self.normal) > 0.8
    }
}
