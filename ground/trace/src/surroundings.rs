//! What a pixel shares its smooth surface with.

use crate::gbuffer::GBuffer;
use chiaro_basis::math::Vec3;

/// The tangent plane of a pixel's surface, and how far the surface may leave it.
pub(crate) struct Surroundings {
    position: Vec3,
    normal: Vec3,
    tolerance: f32,
}

impl Surroundings {
    /// Those of a pixel; the surface may leave its plane by `reach` pixels.
    pub(crate) fn at(buffer: &GBuffer, pixel: (usize, usize), reach: f32) -> Self {
        let height = buffer.size().1 as f32;
        Self {
            position: Vec3::from(buffer.position[pixel]),
            normal: Vec3::from(buffer.smooth_normal[pixel]),
            tolerance: reach * buffer.pose.pixel_size(buffer.depth[pixel], height),
        }
    }

    /// Whether a pixel lies on the same smooth surface.
    pub(crate) fn holds(&self, buffer: &GBuffer, pixel: (usize, usize)) -> bool {
        let off = (Vec3::from(buffer.position[pixel]) - self.position).dot(self.normal).abs();
        off <= self.tolerance && Vec3::from(buffer.smooth_normal[pixel]).dot(self.normal) > 0.8
    }
}
