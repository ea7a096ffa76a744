//! Surfaces that coincide: what an eye sees where several lie in one plane.
//!
//! Walls that overlap in their plane, decals without thickness and meshes that a file holds twice
//! are crossed at distances that differ by rounding alone, so that the nearest of them changes from
//! pixel to pixel. Of those that lie within rounding of the nearest and share its plane, one that shines
//! is met before one that does not, as a lamp flush with its ceiling is; else the lowest (object, face).
//! Rays that carry light need no such rule, but for those that count the light that they meet: the
//! others start off every one.

use crate::tracer::{Hit, Ray, Search, Sides, Tracer, box_ray};
use crate::triangle::Sheared;
use chiaro_basis::math::Vec3;
use obvhs::ray::RayHit;

/// Planes within this share of the largest coordinate are one: some fifty roundings.
const WITHIN: f32 = 3e-6;
/// Cosine between the normals of faces that share a plane, at least.
const PARALLEL: f32 = 0.9999;
/// The least cosine at which a plane is seen; rounding along the ray grows with its inverse.
const GRAZING: f32 = 0.02;

impl Tracer<'_> {
    /// What an eye sees along a ray: [`met`](Self::met) from the sides that materials have.
    pub fn seen(&self, ray: &Ray) -> Option<Hit> {
        self.met(ray, Sides::AsMaterials)
    }

    /// The nearest surface along a ray; where several coincide one that shines, the lowest (object,
    /// face) of these.
    pub fn met(&self, ray: &Ray, sides: Sides) -> Option<Hit> {
        let size = ray.origin.abs().max_element().max(self.size);
        let mut search = Search { room: WITHIN * size / GRAZING, ..Search::default() };
        self.search(ray, sides, &mut search);
        let nearest = search.nearest?;
        let normal = self.face_normal(&nearest);
        let slack = WITHIN * size / normal.dot(ray.direction).abs().max(GRAZING);
        if search.rival.is_none_or(|t| t > nearest.t + slack) {
            return Some(nearest);
        }
        let start = (nearest.t - slack).max(0.0);
        let window = Ray {
            origin: ray.origin + ray.direction * start,
            direction: ray.direction,
            t_max: nearest.t + slack - start,
        };
        Some(Hit { t: nearest.t, ..self.lowest(&window, sides, normal, nearest) })
    }

    /// The first, by [`rank`](Self::rank), in a plane with this normal along a short ray, if before `than`.
    fn lowest(&self, ray: &Ray, sides: Sides, normal: Vec3, than: Hit) -> Hit {
        let mut lowest = than;
        self.visit(ray, &mut |tracer, placed, local, reach| {
            let group = &tracer.hierarchy.groups[placed.group];
            let sheared = Sheared::new(local.origin, local.direction);
            group.tree.ray_traverse(box_ray(local), &mut RayHit::none(), |_, i| {
                if let Some(crossing) = sheared.cross(&group.triangles[i], local.t_max) {
                    let hit = placed.hit(group.faces[i], crossing);
                    if tracer.rank(&hit) < tracer.rank(&lowest)
                        && tracer.face_normal(&hit).dot(normal).abs() > PARALLEL
                        && tracer.is_there(&hit, local, &group.triangles[i], sides)
                    {
                        lowest = hit;
                    }
                }
                f32::INFINITY
            });
            reach
        });
        lowest
    }

    fn rank(&self, hit: &Hit) -> (bool, u32, u32) {
        (!self.shines(hit), hit.object, hit.face)
    }
}
