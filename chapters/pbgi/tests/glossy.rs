//! Glossy receivers, by points and by paths, against closed forms.

#![allow(clippy::unwrap_used)]

use chiaro_basis::Run;
use chiaro_basis::math::{Vec3, vec3};
use chiaro_image::Plane;
use chiaro_pbgi::{LightKnobs, Lit, Wanted, indirect_of, prepare, sites};
use chiaro_scene::load::{Budget, Door, Up, read_scene};
use chiaro_scene::{LightKind, Material, Pose, Poser, Projection};
use chiaro_trace::path::{Aim, PathImage, PathTracer};
use chiaro_trace::{GBuffer, Glow, Lamp, Lights, Sky, Surfaces, Tracer};
use std::f32::consts::PI;
use std::sync::Arc;

const SIZE: (usize, usize) = (24, 24);
/// A floor, and a lamp over it that faces it.
const FLOOR: &str = "v -9 0 -9\nv -9 0 9\nv 9 0 9\nv 9 0 -9\nusemtl a\nf 1 2 3 4\n";
const LAMP: &str = "v -1 2 -9\nv 1 2 -9\nv 1 2 9\nv -1 2 9\nusemtl b\nf 5 6 7 8\n";

fn metal(roughness: f32) -> Material {
    Material { metallic: 1.0, roughness, ..Material::default() }
}

/// What the pixels of a small picture reflect specularly, by points and by paths, on which threads; the
/// first material of the file is replaced, the second shines.
fn found(
    file: &str,
    material: Material,
    light: impl Fn() -> Lights,
    threads: usize,
) -> ([Plane<[f32; 3]>; 2], GBuffer) {
    let mut door = Door::new("a.obj", &(), Budget::default());
    let mut scene = read_scene("a.obj", file.as_bytes(), Up::Y, &mut door).unwrap();
    let faces = scene.meshes[0].materials.clone();
    scene.materials[faces[0].index()] = material;
    if let Some(lamp) = faces.get(2) {
        scene.materials[lamp.index()].emissive = [5.0, 3.0, 1.0];
    }
    let (playback, _) = scene.playback(&Default::default()).unwrap();
    let frame = Poser::new(&scene).frame(0.0, &playback);
    let (tracer, surfaces) = (Tracer::new(&scene, &frame), Surfaces::new(&scene));
    let lights = Lights { glow: Glow::of(&tracer, &surfaces), ..light() };
    let lit = Lit { tracer: &tracer, surfaces: &surfaces, lights: &lights };
    let run = Run::default();
    let eye = Projection::Perspective { fov_y: 0.8 };
    let pose = Pose::look_at(vec3(0.0, 1.5, 3.0), Vec3::ZERO, Vec3::Y, eye);
    let buffer = GBuffer::trace(&tracer, &surfaces, &pose, SIZE, &run).unwrap();
    let knobs = LightKnobs { surfels: 500, bounces: 0, glossy: true, ..LightKnobs::default() };
    let sites = sites(&scene, &frame, 500);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    let points = pool.install(|| {
        let prepared = prepare(lit, &sites, &knobs, &run).unwrap();
        let wanted = Wanted { specular: true, ..Wanted::default() };
        indirect_of(&prepared, &buffer, wanted, &run).unwrap().specular.unwrap()
    });
    let paths = PathTracer {
        tracer: &tracer,
        surfaces: &surfaces,
        lights: &lights,
        bounces: 0,
        glossy: true,
    };
    let mut image = PathImage::new(SIZE.0, SIZE.1);
    paths.add(&mut image, &buffer.pose, 64, Aim::Centre, &run).unwrap();
    ([points, image.specular()], buffer)
}

/// Checks every pixel of the floor against what it should be, within an error; `None` where that is not known.
fn agree(
    (planes, buffer): ([Plane<[f32; 3]>; 2], GBuffer),
    exact: impl Fn(Vec3, Vec3) -> Option<[f32; 3]>,
    (tolerance, floor): (f32, f32),
) {
    let mut count = 0;
    for (method, plane) in planes.iter().enumerate() {
        for (i, own) in plane.pixels().iter().enumerate() {
            let p = Vec3::from(buffer.position.pixels()[i]);
            if !buffer.covered.pixels()[i] || p.y > 0.1 {
                continue;
            }
            let to_eye = (buffer.pose.position - p).normalize();
            let Some(truth) = exact(p, to_eye) else { continue };
            for c in 0..3 {
                let apart = (own[c] - truth[c]).abs();
                let most = truth[c].max(floor);
                assert!(apart <= tolerance * most, "{method} {p}: {own:?} {truth:?}");
            }
            count += 1;
        }
    }
    assert!(count > 100, "{count}");
}

fn mirrored(to_eye: Vec3) -> Vec3 {
    vec3(-to_eye.x, to_eye.y, -to_eye.z)
}

#[test]
fn a_mirror_shows_the_lamp_where_geometry_says() {
    let file = format!("{FLOOR}{LAMP}");
    let lamp = |p: Vec3, to_eye: Vec3| {
        let d = mirrored(to_eye);
        let x = p.x + d.x * 2.0 / d.y;
        // Its edges, a pixel wide, are left out.
        let far = p.z + d.z * 2.0 / d.y < -8.5;
        let beside = (x.abs() - 1.0).abs() < 0.15;
        (!beside && !far).then_some(if x.abs() < 1.0 { [5.0, 3.0, 1.0] } else { [0.0; 3] })
    };
    // The least rough lobe still sends some 0.3 % of its light past an edge 0.05 radians away.
    agree(found(&file, metal(0.0), Lights::default, 2), lamp, (0.1, 0.3));
}

#[test]
fn a_mirror_shows_the_sky_on_its_side() {
    let halves = || {
        let side = |x: usize| if x >= 32 { [1.0, 0.5, 0.0] } else { [0.0, 0.5, 1.0] };
        let sky = Sky::new(Plane::from_fn(64, 32, |x, _| side(x)));
        Lights { sky: Some(Arc::new(sky)), ..Lights::default() }
    };
    let side = |_: Vec3, to_eye: Vec3| {
        let d = mirrored(to_eye);
        let known = d.x.abs() > 0.15;
        known.then_some(if d.x > 0.0 { [1.0, 0.5, 0.0] } else { [0.0, 0.5, 1.0] })
    };
    agree(found(FLOOR, metal(0.0), halves, 2), side, (0.05, 0.05));
}

/// Head-on formulas of the model, written out once more.
#[test]
fn a_rough_metal_under_a_point_light_is_the_model_s_closed_form() {
    let place = vec3(0.5, 2.0, -1.0);
    let lamp =
        Lamp { position: place, kind: LightKind::Point, strength: 10.0, ..Lamp::sun(Vec3::NEG_Y) };
    let light = || Lights { lamps: vec![lamp], ..Lights::default() };
    for roughness in [0.3f32, 0.7] {
        let model = |p: Vec3, v: Vec3| {
            let l = (place - p).normalize();
            let h = (l + v).normalize();
            let a2 = roughness.powi(4);
            let d = a2 / (PI * (h.y * h.y * (a2 - 1.0) + 1.0).powi(2));
            let root = |c: f32| (c * c * (1.0 - a2) + a2).sqrt();
            let shadowed = 0.5 / (l.y * root(v.y) + v.y * root(l.y));
            let e = d * shadowed * l.y * 10.0 / (place - p).length_squared();
            (e > 0.01).then_some([e; 3])
        };
        agree(found(FLOOR, metal(roughness), light, 2), model, (0.02, 0.05));
    }
}

#[test]
fn even_light_is_reflected_as_much_as_a_lobe_reflects_and_threads_do_not_matter() {
    let even = || {
        let sky = Sky::new(Plane::filled(32, 16, [1.0, 0.5, 2.0]));
        Lights { sky: Some(Arc::new(sky)), ..Lights::default() }
    };
    for roughness in [0.2, 0.5, 0.9] {
        let one = found(FLOOR, metal(roughness), even, 1);
        assert_eq!(one.0[0], found(FLOOR, metal(roughness), even, 3).0[0]);
        let whole = |_: Vec3, to_eye: Vec3| {
            let lobe = chiaro_trace::Gloss {
                normal: Vec3::Y,
                to_eye,
                alpha: roughness * roughness,
                f0: [1.0; 3],
                f90: 1.0,
                diffuse: [0.0; 3],
            };
            let e = lobe.reflectance()[0];
            Some([e, 0.5 * e, 2.0 * e])
        };
        agree(one, whole, (0.06, 0.05));
    }
}
