//! [`Vertex`]: a point of a surface, ready to receive and to reflect light.
//!
//! Surfaces are Lambertian here, with the base colour for albedo: metals too; what the eye sees of a gloss is
//! [`crate::Gloss`]. Both sides of every face
//! receive and reflect; emission leaves the sides that the material lets shine.

use crate::gbuffer::GBuffer;
use crate::smooth::{Facet, lifted};
use crate::surface::{Surface, Surfaces};
use crate::tracer::{Hit, Ray, Tracer};
use chiaro_basis::math::Vec3;
use std::f32::consts::TAU;

/// A point of a surface, seen from one side.
#[derive(Clone, Copy, Debug)]
pub struct Vertex {
    /// World position.
    pub position: Vec3,
    /// The same moved onto the surface that the vertex normals span, where that lies outside:
    /// shadow rays start there, or coarse meshes show saw-tooth terminators (Hanika 2021).
    pub lifted: Vec3,
    /// Unit normal of the triangle, on the side that is seen.
    pub side: Vec3,
    /// Unit interpolated normal.
    pub smooth: Vec3,
    /// Unit shading normal, normal textures included.
    pub normal: Vec3,
    /// Linear RGB.
    pub albedo: [f32; 3],
    /// Radiance emitted to this side.
    pub emission: [f32; 3],
    /// How far rays start off the surface, scene units.
    pub offset: f32,
}

impl Vertex {
    /// The vertex where a ray along `direction` met `hit`; textures are read over `footprint`
    /// scene units.
    pub fn of(
        tracer: &Tracer,
        surfaces: &Surfaces,
        hit: &Hit,
        direction: Vec3,
        footprint: f32,
    ) -> Self {
        let surface = surfaces.at(tracer, hit, direction, footprint);
        Self::of_surface(tracer, hit, &surface, direction)
    }

    /// The same from a surface that was already read.
    pub fn of_surface(tracer: &Tracer, hit: &Hit, surface: &Surface, direction: Vec3) -> Self {
        let material = &tracer.scene.materials[surface.material.index()];
        let shines = surface.emissive.iter().any(|e| *e > 0.0)
            && (material.double_sided || tracer.meets_front(hit, direction));
        Self {
            position: surface.position,
            lifted: Facet::of_hit(tracer, hit, surface.geometric_normal)
                .lift(hit.b, surface.position),
            side: surface.geometric_normal,
            smooth: surface.smooth_normal,
            normal: surface.normal,
            albedo: albedo(surface.base_colour),
            emission: if shines { surface.emissive } else { [0.0; 3] },
            offset: tracer.offset(),
        }
    }

    /// The vertex at a covered pixel of a buffer.
    pub fn of_pixel(tracer: &Tracer, buffer: &GBuffer, pixel: (usize, usize)) -> Self {
        let position = Vec3::from(buffer.position[pixel]);
        let side = Vec3::from(buffer.geometric_normal[pixel]);
        Self {
            position,
            lifted: lifted(&Facet::of(tracer, buffer, pixel), buffer, pixel),
            side,
            smooth: buffer.smooth_normal[pixel].into(),
            normal: buffer.normal[pixel].into(),
            albedo: albedo(buffer.base_colour[pixel]),
            emission: buffer.emissive[pixel],
            offset: tracer.offset(),
        }
    }

    /// A ray from the surface along `direction`.
    pub fn ray(&self, direction: Vec3, t_max: f32) -> Ray {
        Ray { origin: self.position + self.side * self.offset, direction, t_max }
    }

    /// A ray towards parallel light, or `None` where the surface turns away.
    pub fn ray_along(&self, towards: Vec3, distance: f32) -> Option<Ray> {
        (self.smooth.dot(towards) > 0.0).then(|| Ray {
            origin: self.lifted + self.smooth * self.offset,
            direction: towards,
            t_max: distance * (1.0 - 1e-4),
        })
    }

    /// A ray that ends just before `target`, which lies on a surface; `None` as above.
    pub fn ray_to(&self, target: Vec3) -> Option<Ray> {
        let origin = self.lifted + self.smooth * self.offset;
        let (direction, length) = (target - origin).normalize_and_length();
        let faces = self.smooth.dot(direction) > 0.0;
        faces.then_some(Ray { origin, direction, t_max: length * (1.0 - 1e-3) })
    }

    /// A direction of cosine density about the shading normal for two numbers in [0, 1).
    pub fn cosine_direction(&self, [u, v]: [f32; 2]) -> Vec3 {
        cosine_direction(self.normal, [u, v])
    }
}

/// A base colour as an albedo, in [0, 1].
pub fn albedo(base_colour: [f32; 3]) -> [f32; 3] {
    base_colour.map(|c| if c > 0.0 { c.min(1.0) } else { 0.0 })
}

/// A direction of density cosine / pi about `normal`.
pub fn cosine_direction(normal: Vec3, [u, v]: [f32; 2]) -> Vec3 {
    let (right, up) = normal.any_orthonormal_pair();
    let (r, (sin, cos)) = (u.sqrt(), (TAU * v).sin_cos());
    right * (r * cos) + up * (r * sin) + normal * (1.0 - u).max(0.0).sqrt()
}
