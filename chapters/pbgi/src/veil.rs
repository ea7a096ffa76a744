//! What rays say about the bright texels of a cluster's buffer that splats alone get wrong.
//!
//! - Behind a wall that is nearer than D the buffer may hold a sunlit street. Near rays take all of it back, but by
//!   chance, and by a sum that is not exactly what they look up. What is taken back in any case need not be there:
//!   any far light is right where every ray ends before it.
//! - A wall farther away is closed, but the splats that stand for it leave gaps, through which the street shines.
//!
//! A texel is judged by rays from the cluster's receivers to places all over it, and only if they all agree. What is
//! bright by itself has left the buffer before (`bright`).

use crate::cube::CubeBuffer;
use crate::field::Ball;
use chiaro_basis::random;
use chiaro_image::colour::luminance;
use chiaro_trace::{Tracer, Vertex};

/// Rays that must all end early, and rays that are tried for each: receivers may face away.
const TESTS: usize = 32;
const TRIES: usize = 3 * TESTS;
/// Texels brighter than so many mean ones are judged.
const BRIGHT: f32 = 2.5;
/// The share of a texel's light that comes from far behind the rest, from which on that is asked for.
const MUCH: f32 = 0.1;
/// Rays end at this share of the way to what they ask for.
const BEFORE: f32 = 0.9;

/// A cluster: its ball, its scene, and some of its receivers.
pub(crate) struct Veil<'a> {
    pub(crate) ball: Ball,
    pub(crate) tracer: &'a Tracer<'a>,
    pub(crate) receivers: &'a [Vertex],
}

impl Veil<'_> {
    /// Takes out of a buffer around the ball's middle what rays say is not seen.
    pub(crate) fn draw(&self, buffer: &mut CubeBuffer) {
        if self.receivers.is_empty() {
            return;
        }
        let light = |b: &CubeBuffer, i: usize| luminance(b.texels()[i].light);
        let count = buffer.texels().len();
        let mean = (0..count).map(|i| light(buffer, i)).sum::<f32>() / count as f32;
        for i in (0..count).filter(|i| light(buffer, *i) > BRIGHT * mean).collect::<Vec<_>>() {
            let t = buffer.texels()[i];
            let back = t.back.distance / t.back.coverage;
            let much = luminance(t.back.light) > MUCH * luminance(t.light);
            if self.hidden(buffer, i, t.mean_distance(), None) {
                buffer.blacken(i);
            } else if much && self.hidden(buffer, i, back, Some(BEFORE * back)) {
                buffer.close(i);
            }
        }
    }

    /// Whether all of some rays from receivers to places of a texel at a distance end before another one from the middle, or
    /// in the ball.
    fn hidden(&self, buffer: &CubeBuffer, i: usize, distance: f32, end: Option<f32>) -> bool {
        let Ball { centre, .. } = self.ball;
        let shape = buffer.shape();
        let place = shape.directions[i] * distance;
        let width = shape.solid_angles[i].sqrt() * distance;
        let (across, up) = shape.directions[i].any_orthonormal_pair();
        let mut tests = 0;
        for k in 0..TRIES {
            let at = &self.receivers[(k + 5 * i) % self.receivers.len()];
            let [u, v] = random::r2((k + TRIES * i) as u64).map(|u| (u - 0.5) * width);
            let towards = centre + place + across * u + up * v - at.position;
            let direction = towards.normalize_or(at.side);
            if direction.dot(at.side).min(direction.dot(at.normal)) <= 0.0 {
                continue;
            }
            let origin = at.position + at.side * at.offset;
            let length = match end {
                Some(end) => Ball { centre, radius: end }.exit(origin, direction),
                None => self.ball.exit(origin, direction),
            };
            if !self.tracer.occluded(&at.ray(direction, length)) {
                return false;
            }
            tests += 1;
            if tests == TESTS {
                break;
            }
        }
        tests > TESTS / 2
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::cube::CubeShape;
    use crate::cut::Splat;
    use chiaro_basis::math::{Vec3, vec3};
    use chiaro_scene::{
        Material, MaterialId, Mesh, MeshId, Node, Playback, Poser, Scene, Transform,
    };

    /// Squares across the x axis, so far to each side, each at a place and facing along the axis or against it.
    pub(crate) fn sheets(half: f32, places: &[(f32, bool)]) -> Scene {
        let mut mesh = Mesh::default();
        for (x, along) in places {
            let first = mesh.positions.len() as u32;
            let corners = [[-half, -half], [half, -half], [half, half], [-half, half]];
            mesh.positions.extend(corners.map(|[y, z]| vec3(*x, y, z)));
            let faces = if *along { [[0, 1, 2], [0, 2, 3]] } else { [[0, 2, 1], [0, 3, 2]] };
            mesh.triangles.extend(faces.map(|f| f.map(|v| first + v)));
        }
        mesh.materials = vec![MaterialId::new(0); mesh.triangles.len()];
        let node = Node { mesh: Some(MeshId::new(0)), ..Node::default() };
        Scene {
            materials: vec![Material::default()],
            meshes: vec![mesh],
            nodes: vec![node],
            ..Scene::default()
        }
    }

    /// A square wall of side 20 across the x axis.
    fn wall(x: f32) -> Scene {
        sheets(10.0, &[(x, true)])
    }

    /// A scene moved up.
    pub(crate) fn shifted(mut scene: Scene, up: f64) -> Scene {
        let transform = Transform::Parts {
            translation: chiaro_basis::math::DVec3::new(0.0, up, 0.0),
            rotation: Default::default(),
            scale: chiaro_basis::math::DVec3::ONE,
        };
        scene.nodes[0].transform = transform;
        scene
    }

    /// The wall moved up.
    fn raised(x: f32, up: f64) -> Scene {
        shifted(wall(x), up)
    }

    /// Light and distance of a texel towards +x and of one towards -x once rays were asked, of a buffer in which both
    /// hold splats of a distance, a share and a radiance. The receivers lie around the origin and face up.
    fn judged(scene: &Scene, splats: &[(f32, f32, f32)]) -> [(f32, f32); 2] {
        let frame = Poser::new(scene).frame(0.0, &Playback::default());
        let tracer = Tracer::new(scene, &frame);
        let shape = CubeShape::new(6);
        let sides = [Vec3::X, Vec3::NEG_X].map(|d| shape.texel(d + vec3(0.0, 0.05, 0.03)));
        let mut buffer = CubeBuffer::new(shape.clone());
        for i in sides {
            for (distance, share, light) in splats {
                let direction = shape.directions[i];
                let splat = Splat {
                    direction,
                    distance: *distance,
                    solid_angle: share * shape.solid_angles[i],
                    radiance: [*light; 3],
                    axis: -direction,
                    ..Splat::default()
                };
                buffer.add(&splat);
            }
        }
        let receiver = |k: u64| {
            let [x, z] = random::r2(k).map(|u| 0.4 * u - 0.2);
            Vertex {
                position: vec3(x, 0.0, z),
                lifted: vec3(x, 0.0, z),
                side: Vec3::Y,
                smooth: Vec3::Y,
                normal: Vec3::Y,
                albedo: [1.0; 3],
                emission: [0.0; 3],
                offset: 1e-4,
            }
        };
        let receivers: Vec<Vertex> = (0..20).map(receiver).collect();
        let ball = Ball { centre: Vec3::ZERO, radius: 2.0 };
        Veil { ball, tracer: &tracer, receivers: &receivers }.draw(&mut buffer);
        let light = |i| (buffer.radiance(i)[0], buffer.texels()[i].mean_distance());
        sides.map(light)
    }

    #[test]
    fn what_a_near_wall_hides_is_black_and_what_none_hides_is_not() {
        let [hidden, free] = judged(&wall(1.0), &[(9.0, 0.9, 5.0)]);
        assert_eq!(hidden.0, 0.0);
        assert!((free.0 / 4.5 - 1.0).abs() < 0.02, "{free:?}");
    }

    #[test]
    fn what_the_edge_of_a_near_wall_hides_keeps_its_light() {
        let [half, free] = judged(&raised(1.0, 10.1), &[(9.0, 0.9, 5.0)]);
        assert!((half.0 / free.0 - 1.0).abs() < 0.02, "{half:?} {free:?}");
    }

    #[test]
    fn nothing_shines_through_the_gaps_of_a_far_wall() {
        let [closed, open] = judged(&wall(5.0), &[(5.0, 0.7, 1.0), (50.0, 0.3, 100.0)]);
        assert!((closed.0 - 1.0).abs() < 1e-3 && (closed.1 - 5.0).abs() < 1e-3, "{closed:?}");
        assert!(open.0 > 25.0, "{open:?}");
    }

    #[test]
    fn a_wall_with_a_slit_hides_nothing_that_is_seen_through_it() {
        let scene = raised(5.0, 10.5);
        let [seen, _] = judged(&scene, &[(5.0, 0.7, 1.0), (50.0, 0.3, 100.0)]);
        assert!(seen.0 > 25.0, "{seen:?}");
    }
}
