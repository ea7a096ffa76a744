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
/// Triangles of an object from which on only some are asked, and how many.
const MANY: usize = 16_384;
const ASKED: usize = 2048;
/// Where they start, of a triangle's size above it.
const ABOVE: f32 = 1e-3;

/// Makes double-sided triangles with an inside single-sided.
pub(super) fn leave_insides_out(triangles: &mut [GlowTriangle], tracer: &Tracer) {
    if !triangles.iter().any(|t| t.two_sided) || are_around_all(triangles, tracer) {
        return;
    }
    let known = &*triangles;
    let sides: Vec<[bool; 2]> = known
        .chunk_by(|a, b| a.object == b.object)
        .flat_map(|some| of_object(known, tracer, some))
        .collect();
    for (t, [front, _]) in triangles.iter_mut().zip(sides).filter(|(_, s)| s[0] != s[1]) {
        t.two_sided = false;
        t.normal = if front { -t.normal } else { t.normal };
    }
}

/// Which sides of an object's triangles are insides. Where it has very many and some tell all the same, so do the others.
fn of_object(known: &[GlowTriangle], tracer: &Tracer, some: &[GlowTriangle]) -> Vec<[bool; 2]> {
    let sides = |(i, t): (usize, &GlowTriangle)| match t.two_sided {
        true => [t.normal, -t.normal].map(|n| is_inside(known, tracer, t, n, i as u64)),
        false => [false; 2],
    };
    if some.len() > MANY {
        let step = some.len() / ASKED;
        let asked: Vec<[bool; 2]> = some.par_iter().enumerate().step_by(step).map(sides).collect();
        if asked.iter().all(|s| *s == asked[0]) && some.iter().all(|t| t.two_sided) {
            return vec![asked[0]; some.len()];
        }
    }
    some.par_iter().enumerate().map(sides).collect()
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::glow::Glow;
    use crate::surface::Surfaces;
    use chiaro_basis::math::{DVec3, vec3};
    use chiaro_scene::{Material, MaterialId, Mesh, MeshId, Node, Playback, Scene, Transform};
    use std::f32::consts::{PI, TAU};

    /// A ball of so many double-sided triangles around, and a small one beside it that does not shine.
    fn ball(rings: u32) -> Scene {
        let round = rings + 1;
        let place = |i: u32, k: u32| {
            let (a, b) = (PI * i as f32 / rings as f32, TAU * k as f32 / rings as f32);
            vec3(a.sin() * b.cos(), a.cos(), a.sin() * b.sin())
        };
        let all = || (0..round).flat_map(|i| (0..round).map(move |k| (i, k)));
        let quads = (0..rings).flat_map(|i| (0..rings).map(move |k| round * i + k));
        let triangles: Vec<[u32; 3]> = quads
            .flat_map(|q| [[q, q + 1, q + round], [q + 1, q + round + 1, q + round]])
            .collect();
        let mesh = |material: usize| Mesh {
            positions: all().map(|(i, k)| place(i, k)).collect(),
            materials: vec![MaterialId::new(material); triangles.len()],
            triangles: triangles.clone(),
            ..Mesh::default()
        };
        let lamp = Material { emissive: [1.0; 3], double_sided: true, ..Material::default() };
        let aside = Transform::Parts {
            translation: DVec3::new(5.0, 0.0, 0.0),
            rotation: Default::default(),
            scale: DVec3::splat(0.1),
        };
        let node = |k: usize| Node { mesh: Some(MeshId::new(k)), ..Node::default() };
        Scene {
            materials: vec![lamp, Material::default()],
            meshes: vec![mesh(0), mesh(1)],
            nodes: vec![node(0), Node { transform: aside, ..node(1) }],
            ..Scene::default()
        }
    }

    #[test]
    fn insides_of_balls_do_not_shine_however_many_triangles_they_have() {
        for rings in [12, 100] {
            let scene = ball(rings);
            assert!(rings < 100 || scene.meshes[0].triangles.len() > MANY);
            let frame = scene.frame(0.0, &Playback::default());
            let tracer = Tracer::new(&scene, &frame);
            let glow = Glow::of(&tracer, &Surfaces::new(&scene));
            assert!(glow.triangles().len() > 200);
            // But for slivers at the poles.
            for t in glow.triangles().iter().filter(|t| t.area > 1e-6) {
                assert!(!t.two_sided && t.normal.dot(t.corners[0] + t.corners[1]) > 0.0);
            }
        }
    }
}
