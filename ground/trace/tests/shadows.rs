//! Half-shadows against their closed form.

#![allow(clippy::unwrap_used)]

use chiaro_basis::Run;
use chiaro_basis::math::{Vec3, vec3};
use chiaro_scene::{
    Frame, Material, MaterialId, Mesh, MeshId, Node, Playback, Pose, Projection, Scene,
};
use chiaro_trace::{GBuffer, Glow, Lights, Surfaces, Tracer, direct_irradiance};

/// A floor, a square lamp of side 1 at height 3 over its middle, and half a plane at height 1 that ends under the
/// lamp's middle.
fn scene() -> Scene {
    let mut mesh = Mesh::default();
    let mut quad = |corners: [Vec3; 4], material| {
        let first = mesh.positions.len() as u32;
        mesh.positions.extend(corners);
        mesh.triangles.extend([[0, 1, 2], [0, 2, 3]].map(|f| f.map(|v: u32| first + v)));
        mesh.materials.extend([MaterialId::new(material); 2]);
    };
    let flat = |x: [f32; 2], y: f32, z: f32| {
        [vec3(x[0], y, z), vec3(x[1], y, z), vec3(x[1], y, -z), vec3(x[0], y, -z)]
    };
    quad(flat([-4.0, 4.0], 0.0, 4.0), 0);
    quad(flat([-4.0, 0.0], 1.0, 4.0), 0);
    let [a, b, c, d] = flat([-0.5, 0.5], 3.0, 0.5);
    quad([d, c, b, a], 1);
    let lamp = Material { emissive: [5.0; 3], double_sided: false, ..Material::default() };
    let node = Node { mesh: Some(MeshId::new(0)), ..Node::default() };
    Scene {
        materials: vec![Material::default(), lamp],
        meshes: vec![mesh],
        nodes: vec![node],
        ..Scene::default()
    }
}

/// A view of the half-shadow, which fills most of it.
fn view() -> Pose {
    let projection = Projection::Perspective { fov_y: 0.35 };
    Pose::look_at(vec3(1.0, 0.7, 0.0), Vec3::ZERO, Vec3::Y, projection)
}

#[test]
fn a_wide_half_shadow_has_no_bands() {
    let scene = scene();
    let frame: Frame = scene.frame(0.0, &Playback::default());
    let tracer = Tracer::new(&scene, &frame);
    let surfaces = Surfaces::new(&scene);
    let lights = Lights { glow: Glow::of(&tracer, &surfaces), ..Lights::default() };
    let run = Run::default();
    let buffer = GBuffer::trace(&tracer, &surfaces, &view(), (160, 160), &run).unwrap();
    let soft = direct_irradiance(&tracer, &buffer, &lights, &run).unwrap().soft;
    // What arrives before the half-shadow, under the whole lamp.
    let open = soft.pixels().iter().map(|e| e[0]).fold(0.0, f32::max);
    let mut within = 0;
    for y in 8..152 {
        for x in 8..152 {
            // The strip of the lamp that is seen past the edge, in a parallel to it.
            let place = 2.0 * buffer.position[(x, y)][0] + 0.5;
            if buffer.position[(x, y)][1] > 1e-3 || !(0.0..1.0).contains(&place) {
                continue;
            }
            within += 1;
            let share = soft[(x, y)][0] / open;
            assert!((share - place).abs() < 0.03, "{x}, {y}: {share} for {place}");
        }
    }
    assert!(within > 10_000, "{within}");
}
