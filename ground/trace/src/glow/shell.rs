//! Which sides of shining triangles nothing can see: the insides of bulbs and tubes.
//!
//! Exporters make materials double-sided by default. What looks at a bulb sees its outside alone; its inside would
//! count as much in closed form. A side is taken for an inside when all rays from it end on the same object's shining
//! triangles, unless all else that is drawn lies within these, as under a dome.

use super::{GlowTriangle, listed};
use crate::sample::Sequence;
use crate::tracer::{Ray, Sides, Tracer};
use crate::vertex::cosine_direction;
use chiaro_basis::math::Vec3;
use chiaro_scene::Bounds;
use rayon::prelude::*;

/// Rays from each side of a triangle.
const RAYS: u32 = 8;
/// Where they start, of a triangle's size above it.
const ABOVE: f32 = 1e-3;

/// Makes double-sided triangles with an inside single-sided.
pub(super) fn leave_insides_out(triangles: &mut [GlowTriangle], tracer: &Tracer) {
    if !triangles.iter().any(|t| t.two_sided) || are_around_all(triangles, tracer) {
        return;
    }
    let known = &*triangles;
    let sides: Vec<[bool; 2]> = known
        .par_iter()
        .enumerate()
        .map(|(i, t)| match t.two_sided {
            true => [t.normal, -t.normal].map(|n| is_inside(known, tracer, t, n, i as u64)),
            false => [false; 2],
        })
        .collect();
    for (t, [front, _]) in triangles.iter_mut().zip(sides).filter(|(_, s)| s[0] != s[1]) {
        t.two_sided = false;
        t.normal = if front { -t.normal } else { t.normal };
    }
}

/// Whether all that does not shine lies within the bounds of what does.
fn are_around_all(triangles: &[GlowTriangle], tracer: &Tracer) -> bool {
    let own = Bounds::of(triangles.iter().flat_map(|t| t.corners));
    let holds = |p: Vec3| p.cmpge(own.min).all() && p.cmple(own.max).all();
    tracer.frame.objects.iter().zip(0..).all(|(object, index)| {
        let mesh = tracer.frame.shapes[object.shape].mesh_in(tracer.scene);
        mesh.materials.iter().zip(0..).all(|(material, face)| {
            let shines = tracer.scene.materials[material.index()].shines();
            shines || tracer.corners(index, face).into_iter().all(holds)
        })
    })
}

/// Whether all rays from a side end on shining triangles of the same object.
fn is_inside(
    triangles: &[GlowTriangle],
    tracer: &Tracer,
    t: &GlowTriangle,
    normal: Vec3,
    seed: u64,
) -> bool {
    let middle = (t.corners[0] + t.corners[1] + t.corners[2]) / 3.0;
    let origin = middle + normal * (ABOVE * t.area.sqrt());
    let sequence = Sequence::new(seed);
    (0..RAYS).all(|k| {
        let direction = cosine_direction(normal, sequence.point(k, 0));
        let hit = tracer.hit(&Ray { origin, direction, t_max: f32::INFINITY }, Sides::Both);
        hit.is_some_and(|h| h.object == t.object && listed(triangles, &h).is_some())
    })
}
