//! Light of surfaces that shine against closed forms.

#![allow(clippy::unwrap_used)]

use chiaro_basis::math::Vec3;
use chiaro_basis::random::{r2, unit};
use chiaro_scene::{Poser, demo};
use chiaro_trace::{Glow, GlowTriangle, LightNumbers, Lights, Surfaces, Tracer, Vertex};

/// Irradiance over radiance at a point whose normal has a triangle in front of it (Lambert's formula).
fn lambert(triangle: &GlowTriangle, point: Vec3, normal: Vec3) -> f32 {
    let [a, b, c] = triangle.corners.map(|p| (p - point).normalize());
    let edge = |p: Vec3, q: Vec3| p.angle_between(q) * p.cross(q).normalize().dot(normal);
    (0.5 * (edge(a, b) + edge(b, c) + edge(c, a))).abs()
}

/// A lamp gives what its closed form says from a fifth of its extent on: near ones are seen by few samples that
/// each count for far more than the whole could give.
#[test]
fn lamps_give_their_closed_form_near_by_too() {
    let scene = demo::scene("cornell-box").unwrap();
    let (playback, _) = scene.playback(&Default::default()).unwrap();
    let frame = Poser::new(&scene).frame(0.0, &playback);
    let tracer = Tracer::new(&scene, &frame);
    let surfaces = Surfaces::new(&scene);
    let lights = Lights { glow: Glow::of(&tracer, &surfaces), ..Lights::default() };
    let triangles = lights.glow.triangles().to_vec();
    let corners = || triangles.iter().flat_map(|t| t.corners);
    let middle = corners().sum::<Vec3>() / corners().count() as f32;
    let extent = triangles.iter().map(|t| t.area).sum::<f32>().sqrt();
    let outward = triangles[0].normal;
    for distance in [0.02, 0.05, 0.2, 0.4, 1.0, 1.5] {
        let position = middle + distance * extent * outward;
        let normal = -outward;
        let at = Vertex {
            position,
            lifted: position,
            side: normal,
            smooth: normal,
            normal,
            albedo: [1.0; 3],
            emission: [0.0; 3],
            offset: tracer.offset(),
        };
        let count = 1 << 15;
        let mean = |one_ray: bool| {
            let sum: f64 = (0..count)
                .map(|i| {
                    let ([u, v], sky) = (r2(i), [unit(1, i), 0.0]);
                    let numbers =
                        LightNumbers { glow: [unit(2, i), u, v], sky, choice: unit(3, i) };
                    let e = match one_ray {
                        true => lights.irradiance_by_one_ray(&tracer, &surfaces, &at, &numbers),
                        false => lights.irradiance(&tracer, &surfaces, &at, &numbers, false),
                    };
                    f64::from(e[1])
                })
                .sum();
            (sum / count as f64) as f32
        };
        let exact: f32 =
            triangles.iter().map(|t| t.radiance[1] * lambert(t, position, normal)).sum();
        for found in [mean(false), mean(true)] {
            assert!((found / exact - 1.0).abs() < 0.03, "{distance}: {found} {exact}");
        }
    }
}
