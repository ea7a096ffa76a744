//! Which sides of shining triangles nothing can see: the insides of bulbs and tubes.
//!
//! Exporters make materials double-sided by default. What looks at a bulb sees its outside alone; its inside would
//! count as much in closed form. A side is taken for an inside when all rays from it end on the same object's shining
//! triangles, unless all else that is drawn lies within these, as under a dome.

use super::{Glow, GlowTriangle};
use crate::sample::Sequence;
use crate::tracer::{Ray, Sides, Tracer};
use crate::vertex::cosine_direction;
use chiaro_basis::math::Vec3;
use chiaro_scene::Bounds;

/// Rays from each side of a triangle.
const RAYS: u32 = 8;
/// Where they start, of a triangle's size above it.
const ABOVE: f32 = 1e-3;

impl Glow {
    /// Makes double-sided triangles with an inside single-sided.
    pub(super) fn without_insides(mut self, tracer: &Tracer) -> Self {
        if !self.triangles.iter().any(|t| t.two_sided) || self.is_around_all(tracer) {
            return self;
        }
        let sides: Vec<[bool; 2]> = self
            .triangles
            .iter()
            .enumerate()
            .map(|(i, t)| match t.two_sided {
                true => [t.normal, -t.normal].map(|n| self.is_inside(tracer, t, n, i as u64)),
                false => [false; 2],
            })
            .collect();
        for (t, [front, back]) in self.triangles.iter_mut().zip(sides).filter(|(_, s)| s[0] != s[1])
        {
            t.two_sided = front == back;
            t.normal = if front { -t.normal } else { t.normal };
        }
        Self::from_triangles(self.triangles)
    }

    /// Whether all that does not shine lies within the bounds of what does.
    fn is_around_all(&self, tracer: &Tracer) -> bool {
        let own = Bounds::of(self.triangles.iter().flat_map(|t| t.corners));
        let mut others = Vec::new();
        for (index, object) in tracer.frame.objects.iter().enumerate() {
            let mesh = tracer.frame.shapes[object.shape].mesh_in(tracer.scene);
            for (face, material) in mesh.materials.iter().enumerate() {
                if !tracer.scene.materials[material.index()].shines() {
                    others.extend(tracer.corners(index as u32, face as u32));
                }
            }
        }
        others.iter().all(|p| p.cmpge(own.min).all() && p.cmple(own.max).all())
    }

    /// Whether all rays from a side end on shining triangles of the same object.
    fn is_inside(&self, tracer: &Tracer, t: &GlowTriangle, normal: Vec3, seed: u64) -> bool {
        let middle = (t.corners[0] + t.corners[1] + t.corners[2]) / 3.0;
        let origin = middle + normal * (ABOVE * t.area.sqrt());
        let sequence = Sequence::new(seed);
        (0..RAYS).all(|k| {
            let direction = cosine_direction(normal, sequence.point(k, 0));
            let hit = tracer.hit(&Ray { origin, direction, t_max: f32::INFINITY }, Sides::Both);
            hit.is_some_and(|h| h.object == t.object && self.find(&h).is_some())
        })
    }
}
