//! The smooth surface that a facet's vertex normals span (Hanika, "Hacking the shadow terminator",
//! 2021): where rays that test for light should start, so that facets do not show.

use crate::gbuffer::GBuffer;
use crate::tracer::{Hit, Tracer};
use chiaro_basis::math::Vec3;

/// A facet with its vertex normals in world space, on the side that is seen.
pub(crate) struct Facet {
    corners: [Vec3; 3],
    normals: [Vec3; 3],
    side: Vec3,
}

impl Facet {
    /// The facet in a covered pixel.
    pub(crate) fn of(tracer: &Tracer, buffer: &GBuffer, pixel: (usize, usize)) -> Self {
        Self::of_hit(tracer, &buffer.hit(pixel), buffer.geometric_normal[pixel].into())
    }

    /// The facet that was hit, seen from `side`.
    pub(crate) fn of_hit(tracer: &Tracer, hit: &Hit, side: Vec3) -> Self {
        let object = tracer.object(hit);
        let shape = &tracer.frame.shapes[object.shape];
        let vertices = tracer.mesh(hit).triangles[hit.face as usize].map(|v| v as usize);
        let for_normals = object.normal_from_shape();
        let m = &object.world_from_shape;
        Self {
            corners: vertices.map(|v| m.transform_point3(shape.positions[v])),
            normals: vertices.map(|v| {
                let n = (for_normals * shape.normals[v]).normalize_or(side);
                if n.dot(side) < 0.0 { -n } else { n }
            }),
            side,
        }
    }

    /// A point of the facet moved onto the smooth surface: the barycentric mean of its projections
    /// onto the planes at the three vertices, where those lie outside.
    pub(crate) fn lift(&self, [b, c]: [f32; 2], point: Vec3) -> Vec3 {
        let mut offset = Vec3::ZERO;
        for (i, weight) in [1.0 - b - c, b, c].into_iter().enumerate() {
            let n = self.normals[i];
            offset -= n * (weight * (point - self.corners[i]).dot(n).min(0.0));
        }
        point + offset
    }

    /// The sine of the angle at which neighbours of the facet may rise above its plane: twice the
    /// greatest angle between it and a vertex normal, 0.4 at most. 0 when flat.
    pub(crate) fn deviation(&self) -> f32 {
        let cos = self.normals.iter().map(|n| n.dot(self.side)).fold(1.0, f32::min);
        let sin = (1.0 - cos * cos).max(0.0).sqrt();
        // Rounding alone bends flat facets by a thousandth.
        if sin < 2e-3 { 0.0 } else { (2.0 * sin * cos).min(0.4) }
    }
}

/// A pixel's point moved onto the smooth surface.
pub(crate) fn lifted(facet: &Facet, buffer: &GBuffer, pixel: (usize, usize)) -> Vec3 {
    facet.lift(buffer.barycentric[pixel], buffer.position[pixel].into())
}
