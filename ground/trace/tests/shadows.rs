//! Half-shadows against their closed form.

#![allow(clippy::unwrap_used)]

use chiaro_basis::Run;
use chiaro_basis::math::{Vec2, Vec3, vec3};
use chiaro_image::Plane;
use chiaro_scene::{
    Filter, Frame, Material, MaterialId, Mesh, MeshId, Node, Playback, Pose, Projection, Scene,
    Texture, TextureId, TextureUse, Wrap,
};
use chiaro_trace::{GBuffer, Glow, Lights, Surfaces, Tracer, direct_irradiance};
use std::sync::Arc;

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

/// The same without what hides the lamp, which is a screen: blue beside +x, and twice as bright in red beside -x.
fn with_screen() -> Scene {
    let mut scene = scene();
    let mesh = &mut scene.meshes[0];
    mesh.triangles.drain(2..4);
    mesh.materials.drain(2..4);
    mesh.uvs = vec![mesh.positions.iter().map(|p| Vec2::new(p.x + 0.5, 0.5)).collect()];
    let texel = |x: usize, _| if x < 8 { [255, 0, 0, 255] } else { [0, 0, 188, 255] };
    let pixels = Arc::new(Plane::from_fn(16, 4, texel));
    let wrap = [Wrap::Clamp; 2];
    scene.textures = vec![Texture { name: "screen".into(), pixels, wrap, filter: Filter::Nearest }];
    scene.materials[1].emissive_texture = Some(TextureUse::plain(TextureId::new(0)));
    scene
}

/// A view of the half-shadow, which fills most of it.
fn view() -> Pose {
    let projection = Projection::Perspective { fov_y: 0.35 };
    Pose::look_at(vec3(1.0, 0.7, 0.0), Vec3::ZERO, Vec3::Y, projection)
}

/// Irradiance by what shines at the pixels of a view, and the buffer.
fn soft(scene: &Scene, view: &Pose) -> (Plane<[f32; 3]>, GBuffer) {
    let frame: Frame = scene.frame(0.0, &Playback::default());
    let tracer = Tracer::new(scene, &frame);
    let surfaces = Surfaces::new(scene);
    let lights = Lights { glow: Glow::of(&tracer, &surfaces), ..Lights::default() };
    let run = Run::default();
    let buffer = GBuffer::trace(&tracer, &surfaces, view, (160, 160), &run).unwrap();
    (direct_irradiance(&tracer, &buffer, &lights, &run).unwrap().soft, buffer)
}

#[test]
fn a_screen_has_its_colours_where_it_shows_them() {
    // Two halves of the lamp, each in closed form by points all over it.
    let (soft, buffer) = soft(&with_screen(), &view());
    let half = |place: Vec3, side: f32| -> f32 {
        let point = |i: u32| {
            let at = |k: u32| (k as f32 + 0.5) / 32.0;
            vec3(0.5 * side * at(i % 32), 3.0, at(i / 32) - 0.5)
        };
        let given = |p: Vec3| {
            let to = p - place;
            to.y * to.y / to.length_squared().powi(2)
        };
        5.0 * 0.5 / 1024.0 * (0..1024).map(|i| given(point(i))).sum::<f32>()
    };
    for (x, y) in [(80, 80), (20, 80), (140, 80), (80, 140), (80, 20)] {
        let place = Vec3::from(buffer.position[(x, y)]);
        let [red, green, blue] = soft[(x, y)];
        let (of_red, of_blue) = (half(place, -1.0), 0.503 * half(place, 1.0));
        assert!((red / of_red - 1.0).abs() < 0.01, "{place}: {red} {of_red}");
        assert!((blue / of_blue - 1.0).abs() < 0.01, "{place}: {blue} {of_blue}");
        assert!(green.abs() < 1e-6);
    }
}

#[test]
fn what_lies_in_the_plane_of_a_screen_is_dark() {
    let mut scene = with_screen();
    // The floor is raised into the screen's plane.
    scene.meshes[0].positions.iter_mut().filter(|p| p.y == 0.0).for_each(|p| p.y = 3.0);
    let projection = Projection::Perspective { fov_y: 0.35 };
    let view = Pose::look_at(vec3(4.0, 4.0, 0.0), vec3(2.0, 3.0, 0.0), Vec3::Y, projection);
    let (soft, _) = soft(&scene, &view);
    assert!(soft.pixels().iter().all(|e| *e == [0.0; 3]));
}

#[test]
fn a_wide_half_shadow_has_no_bands() {
    let (soft, buffer) = soft(&scene(), &view());
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
