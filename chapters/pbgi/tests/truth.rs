//! Points against paths.

#![allow(clippy::unwrap_used)]

use chiaro_basis::math::{Vec3, vec3};
use chiaro_basis::{Run, random};
use chiaro_image::{Plane, metric};
use chiaro_pbgi::{Division, LightKnobs, Lit, Sharing, indirect, pooled_paths, prepare, sites};
use chiaro_scene::load::{Budget, Door, Up, read_scene};
use chiaro_scene::{Material, MaterialId, Pose, Poser, Projection, Scene, demo};
use chiaro_trace::path::{Aim, PathImage, PathTracer};
use chiaro_trace::{GBuffer, Glow, Lamp, Lights, Surfaces, Tracer, direct_irradiance};

/// Something done in the Cornell box, lit by its lamp.
fn in_the_box<T>(act: impl FnOnce(&Scene, Lit, &Run) -> T) -> T {
    lit_by_itself(&demo::scene("cornell-box").unwrap(), act)
}

/// Something done in a scene, lit by what shines in it.
fn lit_by_itself<T>(scene: &Scene, act: impl FnOnce(&Scene, Lit, &Run) -> T) -> T {
    let (playback, _) = scene.playback(&Default::default()).unwrap();
    let frame = Poser::new(scene).frame(0.0, &playback);
    let tracer = Tracer::new(scene, &frame);
    let surfaces = Surfaces::new(scene);
    let lights = Lights { glow: Glow::of(&tracer, &surfaces), ..Lights::default() };
    act(scene, Lit { tracer: &tracer, surfaces: &surfaces, lights: &lights }, &Run::default())
}

/// What its camera sees.
fn seen(lit: Lit, run: &Run) -> GBuffer {
    let camera = &lit.tracer.frame.cameras[0];
    GBuffer::trace(lit.tracer, lit.surfaces, camera, (48, 48), run).unwrap()
}

/// Indirect radiance by paths, one bounce.
fn truth(lit: Lit, buffer: &GBuffer, run: &Run) -> Plane<[f32; 3]> {
    let Lit { tracer, surfaces, lights } = lit;
    let paths = PathTracer { tracer, surfaces, lights, bounces: 1, glossy: false };
    let mut image = PathImage::new(48, 48);
    paths.add(&mut image, &buffer.pose, 512, Aim::Centre, run).unwrap();
    image.indirect()
}

/// Irradiance by points.
fn by_points(scene: &Scene, lit: Lit, knobs: &LightKnobs, run: &Run) -> Plane<[f32; 3]> {
    let sites = sites(scene, lit.tracer.frame, knobs.surfels as usize);
    let prepared = prepare(lit, &sites, knobs, run).unwrap();
    indirect(&prepared, &seen(lit, run), run).unwrap().irradiance
}

/// The relative error of the radiance of an irradiance.
fn error(irradiance: &Plane<[f32; 3]>, truth: &Plane<[f32; 3]>, buffer: &GBuffer) -> f64 {
    let reflected =
        |e: &[f32; 3], a: &[f32; 3]| std::array::from_fn(|c| a[c] * e[c] / std::f32::consts::PI);
    let own = irradiance.zip(&buffer.base_colour, reflected).unwrap();
    metric::rmse_relative(&own, truth, &buffer.covered).unwrap().unwrap()
}

/// Relative errors of indirect radiance in the Cornell box, of each knobs, one bounce.
fn errors(all: &[LightKnobs]) -> Vec<f64> {
    in_the_box(|scene, lit, run| {
        let buffer = seen(lit, run);
        let truth = truth(lit, &buffer, run);
        all.iter().map(|k| error(&by_points(scene, lit, k, run), &truth, &buffer)).collect()
    })
}

/// A room of side 2 in a PLY file, with what else quads of these corners show in it; the last shines to both sides.
fn room_with(quads: &[[[f32; 3]; 4]]) -> Scene {
    let corners = (0..8).map(|i| [i & 1, i >> 1 & 1, i >> 2].map(|c| 2.0 * c as f32));
    let (vertices, faces) = (8 + 4 * quads.len(), 6 + quads.len());
    let mut file = format!(
        "ply\nformat ascii 1.0\nelement vertex {vertices}\nproperty float x\nproperty float y\nproperty float z\n\
         element face {faces}\nproperty list uchar int vertex_indices\nend_header\n"
    );
    let all = corners.chain(quads.iter().flatten().copied());
    all.for_each(|[x, y, z]| file += &format!("{x} {y} {z}\n"));
    file += "4 0 2 6 4\n4 1 5 7 3\n4 0 4 5 1\n4 2 3 7 6\n4 0 1 3 2\n4 4 6 7 5\n";
    for i in (8..vertices).step_by(4) {
        file += &format!("4 {i} {} {} {}\n", i + 1, i + 2, i + 3);
    }
    let mut door = Door::new("room.ply", &(), Budget::default());
    let mut scene = read_scene("room.ply", file.as_bytes(), Up::Y, &mut door).unwrap();
    scene.materials.iter_mut().for_each(|m| m.double_sided = true);
    let shining = Material { emissive: [5.0; 3], ..scene.materials[0].clone() };
    scene.materials.push(shining);
    let id = MaterialId::new(scene.materials.len() - 1);
    scene.meshes[0].materials.iter_mut().rev().take(2).for_each(|m| *m = id);
    scene
}

/// With a lamp just under the ceiling.
fn room_with_a_panel() -> Scene {
    room_with(&[[[0.6, 0.6], [1.4, 0.6], [1.4, 1.4], [0.6, 1.4]].map(|[x, z]| [x, 1.995, z])])
}

/// With a lamp in a shade that is open above and below.
fn room_with_a_lampshade() -> Scene {
    let around = [[0.85, 0.85], [1.15, 0.85], [1.15, 1.15], [0.85, 1.15]];
    let wall = |k: usize| {
        let ([a, b], [c, d]) = (around[k], around[(k + 1) % 4]);
        [[a, 0.8, b], [c, 0.8, d], [c, 1.2, d], [a, 1.2, b]]
    };
    let lamp = [[0.95, 0.95], [1.05, 0.95], [1.05, 1.05], [0.95, 1.05]].map(|[x, z]| [x, 1.0, z]);
    room_with(&[wall(0), wall(1), wall(2), wall(3), lamp])
}

/// The lit inside of a shade is far brighter than all else, and does not shine through it onto the wall.
#[test]
fn a_lampshade_keeps_the_light_of_its_inside() {
    let scene = room_with_a_lampshade();
    lit_by_itself(&scene, |scene, lit, run| {
        let eye = Projection::Perspective { fov_y: 1.5 };
        let pose = Pose::look_at(vec3(1.0, 1.0, 0.05), vec3(1.0, 1.0, 2.0), Vec3::Y, eye);
        let buffer = GBuffer::trace(lit.tracer, lit.surfaces, &pose, (48, 48), run).unwrap();
        let truth = truth(lit, &buffer, run);
        let sum = |some: &Plane<[f32; 3]>, rows: std::ops::Range<usize>| -> f32 {
            rows.flat_map(|y| (0..14).map(move |x| (x, y))).map(|p| some[p][1]).sum()
        };
        for error_bound in [0.1, 0.0] {
            let knobs =
                LightKnobs { surfels: 60_000, bounces: 1, error_bound, ..LightKnobs::default() };
            let sites = sites(scene, lit.tracer.frame, knobs.surfels as usize);
            let prepared = prepare(lit, &sites, &knobs, run).unwrap();
            let found = indirect(&prepared, &buffer, run).unwrap().irradiance;
            let reflected = |e: &[f32; 3], a: &[f32; 3]| {
                std::array::from_fn(|c| a[c] * e[c] / std::f32::consts::PI)
            };
            let found = found.zip(&buffer.base_colour, reflected).unwrap();
            for rows in [0..10, 20..28, 38..48] {
                let share = sum(&found, rows.clone()) / sum(&truth, rows.clone());
                assert!((share - 1.0).abs() < 0.1, "{error_bound} {rows:?}: {share}");
            }
        }
    })
}

/// What the lamp lights close above it is not seen through it, and the ceiling beside it is as bright as it is.
#[test]
fn a_panel_hides_the_ceiling_that_it_shines_on() {
    let scene = room_with_a_panel();
    lit_by_itself(&scene, |scene, lit, run| {
        let eye = Projection::Perspective { fov_y: 1.4 };
        let pose = Pose::look_at(vec3(1.0, 1.0, 0.05), vec3(1.0, 0.9, 2.0), Vec3::Y, eye);
        let buffer = GBuffer::trace(lit.tracer, lit.surfaces, &pose, (48, 48), run).unwrap();
        let truth = truth(lit, &buffer, run);
        for surfels in [5_000, 60_000] {
            let knobs = LightKnobs { surfels, bounces: 1, ..LightKnobs::default() };
            let sites = sites(scene, lit.tracer.frame, surfels as usize);
            let prepared = prepare(lit, &sites, &knobs, run).unwrap();
            let found = indirect(&prepared, &buffer, run).unwrap().irradiance;
            let apart = error(&found, &truth, &buffer);
            assert!(apart < 0.2, "{surfels}: {apart}");
        }
    })
}

#[test]
fn shared_gathers_agree_with_those_of_every_pixel() {
    in_the_box(|scene, lit, run| {
        let buffer = seen(lit, run);
        let shared = LightKnobs { surfels: 20_000, bounces: 1, ..LightKnobs::default() };
        let alone = LightKnobs { error_bound: 0.0, ..shared.clone() };
        let [shared, alone] = [shared, alone].map(|k| by_points(scene, lit, &k, run));
        let apart = metric::rmse_relative(&shared, &alone, &buffer.covered).unwrap().unwrap();
        let sum =
            |p: &Plane<[f32; 3]>| p.pixels().iter().flatten().map(|e| f64::from(*e)).sum::<f64>();
        let mean = sum(&shared) / sum(&alone);
        assert!(apart < 0.15 && (mean - 1.0).abs() < 0.05, "{apart} {mean}");
    })
}

/// Records against every pixel by itself, and against themselves on other numbers of threads.
#[test]
fn records_with_gradients_agree_with_gathers_of_every_pixel() {
    in_the_box(|scene, lit, run| {
        let buffer = seen(lit, run);
        let truth = truth(lit, &buffer, run);
        let usual = LightKnobs { surfels: 20_000, bounces: 1, ..LightKnobs::default() };
        let records = LightKnobs { sharing: Sharing::Records, ..usual.clone() };
        let alone = LightKnobs { error_bound: 0.0, ..records.clone() };
        let on = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| by_points(scene, lit, &records, run))
        };
        let shared = on(1);
        assert_eq!(shared, on(3));
        let alone = by_points(scene, lit, &alone, run);
        let apart = metric::rmse_relative(&shared, &alone, &buffer.covered).unwrap().unwrap();
        let error = error(&shared, &truth, &buffer);
        assert!(apart < 0.2 && error < 0.18, "{apart} {error}");
    })
}

/// An octree over the same surfels gives the light of the binary tree.
#[test]
fn an_octree_gives_the_light_of_the_binary_tree() {
    in_the_box(|scene, lit, run| {
        let buffer = seen(lit, run);
        let usual = LightKnobs { surfels: 20_000, bounces: 1, ..LightKnobs::default() };
        let octree = LightKnobs { hierarchy: Division::Octree, ..usual.clone() };
        let [binary, octree] = [usual, octree].map(|k| by_points(scene, lit, &k, run));
        let apart = metric::rmse_relative(&octree, &binary, &buffer.covered).unwrap().unwrap();
        assert!(apart > 0.0 && apart < 0.08, "{apart}");
    })
}

#[test]
fn pooled_paths_are_near_the_truth() {
    in_the_box(|_, lit, run| {
        let buffer = seen(lit, run);
        let truth = truth(lit, &buffer, run);
        let [few, many] = [2, 64].map(|rays| {
            let found = pooled_paths(&lit, &buffer, rays, 0, run).unwrap();
            error(&found.irradiance, &truth, &buffer)
        });
        assert!(many < 0.12 && many < few, "{few} {many}");
    })
}

#[test]
fn every_pixel_by_itself_is_near_the_truth_and_discs_alone_are_farther() {
    let usual = LightKnobs {
        surfels: 20_000,
        bounces: 1,
        error_bound: 0.0,
        resolution: 8,
        solid_angle: 1.0,
        ..LightKnobs::default()
    };
    let discs = LightKnobs { near_field: false, ..usual.clone() };
    let lobes = LightKnobs { flat_nodes: false, ..usual.clone() };
    let tiles = LightKnobs { bounces: 1, surfels: 20_000, ..LightKnobs::default() };
    let e = errors(&[usual, discs, lobes, tiles]);
    assert!(e[0] < 0.16, "{e:?}");
    assert!(e[0] < e[1] && e[0] < e[2], "{e:?}");
    assert!(e[3] < 0.21, "{e:?}");
}

#[test]
fn gathers_tell_how_open_the_hemisphere_is() {
    in_the_box(|scene, lit, run| {
        let buffer = seen(lit, run);
        let reach = 0.6 * buffer.radius;
        let rays = chiaro_trace::ambient_occlusion(lit.tracer, &buffer, reach, 8, run).unwrap();
        for error_bound in [0.1, 0.0] {
            let knobs =
                LightKnobs { surfels: 20_000, bounces: 1, error_bound, ..LightKnobs::default() };
            let sites = sites(scene, lit.tracer.frame, 20_000);
            let prepared = prepare(lit, &sites, &knobs, run).unwrap();
            let found = indirect(&prepared, &buffer, run).unwrap();
            let (mut sum, mut count) = (0.0, 0.0);
            for (i, _) in buffer.covered.pixels().iter().enumerate().filter(|(_, c)| **c) {
                sum += (found.openness.pixels()[i] - rays.pixels()[i]).abs();
                count += 1.0;
            }
            assert!(sum / count < 0.1, "{error_bound}: {}", sum / count);
        }
    })
}

#[test]
fn a_frame_has_the_same_bits_again_and_on_any_number_of_threads() {
    in_the_box(|scene, lit, run| {
        let knobs = LightKnobs { surfels: 5000, bounces: 2, ..LightKnobs::default() };
        let sites = sites(scene, lit.tracer.frame, 5000);
        let on = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| {
                let buffer = seen(lit, run);
                let prepared = prepare(lit, &sites, &knobs, run).unwrap();
                indirect(&prepared, &buffer, run).unwrap().irradiance
            })
        };
        let once = on(1);
        assert_eq!(once, on(3));
        assert!(once.pixels().iter().flatten().all(|e| e.is_finite() && *e >= 0.0));
    })
}

/// A floor and a wall as a cloud of points in a PLY file, their normals left out.
fn corner_of_points() -> Scene {
    let count = 12_000u64;
    let mut file = format!(
        "ply\nformat ascii 1.0\nelement vertex {count}\nproperty float x\nproperty float y\n\
         property float z\nend_header\n"
    );
    for i in 0..count {
        let [u, v] = [random::unit(7, i), random::unit(8, i)].map(|t| 2.0 * t);
        let [x, y, z] = if i % 2 == 0 { [u, 0.0, v] } else { [0.0, u, v] };
        file += &format!("{x} {y} {z}\n");
    }
    let mut door = Door::new("corner.ply", &(), Budget::default());
    read_scene("corner.ply", file.as_bytes(), Up::Y, &mut door).unwrap()
}

#[test]
fn a_cloud_of_points_is_lit_like_the_surface_it_was_taken_from() {
    let scene = corner_of_points();
    let (playback, _) = scene.playback(&Default::default()).unwrap();
    let frame = Poser::new(&scene).frame(0.0, &playback);
    let tracer = Tracer::new(&scene, &frame);
    let surfaces = Surfaces::new(&scene);
    let sun = Lamp::sun(vec3(-1.0, -1.0, 0.0));
    let lights = Lights { lamps: vec![sun], ..Lights::default() };
    let lit = Lit { tracer: &tracer, surfaces: &surfaces, lights: &lights };
    let run = Run::default();
    let eye = Projection::Perspective { fov_y: 0.6 };
    let pose = Pose::look_at(vec3(5.0, 4.0, 1.0), vec3(0.5, 0.5, 1.0), Vec3::Y, eye);
    let buffer = GBuffer::trace(&tracer, &surfaces, &pose, (48, 48), &run).unwrap();

    // Both planes meet the sun at 45 degrees, and nothing is in its way.
    let direct = direct_irradiance(&tracer, &buffer, &lights, &run).unwrap();
    let covered = || buffer.covered.pixels().iter().zip(direct.hard.pixels()).filter(|(c, _)| **c);
    let right = covered().filter(|(_, e)| (e[0] - 0.5f32.sqrt()).abs() < 0.08).count();
    assert!(right * 100 >= 95 * covered().count(), "{right} of {}", covered().count());

    let knobs = LightKnobs { surfels: 12_000, bounces: 1, ..LightKnobs::default() };
    let places = sites(&scene, &frame, 12_000);
    let prepared = prepare(lit, &places, &knobs, &run).unwrap();
    let area: f32 = prepared.surfels.all.iter().map(|s| s.area).sum();
    assert!((area / 8.0 - 1.0).abs() < 0.1, "{area}");
    // The light that the floor gets from the wall: the form factor of a point before it, in closed form.
    let found = indirect(&prepared, &buffer, &run).unwrap();
    let (mut own, mut exact) = (0.0, 0.0);
    for (i, p) in buffer.position.pixels().iter().enumerate() {
        let [x, y, z] = *p;
        if buffer.covered.pixels()[i] && y.abs() < 0.02 && x > 0.2 {
            own += found.irradiance.pixels()[i][0];
            exact += 0.6 * 0.5f32.sqrt() * (beside(x, 2.0, z) + beside(x, 2.0, 2.0 - z));
        }
    }
    assert!((own / exact - 1.0).abs() < 0.08, "{own} {exact}");
}

/// The form factor from a point on a floor to an upright rectangle at distance `x`, `h` high, `w`
/// wide, whose lower corner is the nearest point.
fn beside(x: f32, h: f32, w: f32) -> f32 {
    let slant = (x * x + h * h).sqrt();
    ((w / x).atan() - x / slant * (w / slant).atan()) / std::f32::consts::TAU
}

/// Half a pipe, open upwards, under an even sky. Its bottom sees pi sin 45 of the sky, and of that a quarter times the
/// albedo comes back from the walls. A few samples of the sky often miss it: what they leave dark must not die.
#[test]
fn a_half_pipe_under_an_even_sky_reflects_its_closed_form() {
    use std::fmt::Write;
    const FACETS: usize = 48;
    let mut file = String::new();
    for i in 0..=FACETS {
        let angle = std::f32::consts::PI * (1.0 + i as f32 / FACETS as f32);
        let (y, z) = (1.0 + angle.sin(), angle.cos());
        writeln!(file, "v -20 {y} {z}\nv 20 {y} {z}").unwrap();
    }
    // Faces wind so that their fronts are outside.
    for i in 0..FACETS {
        let k = 2 * i + 1;
        writeln!(file, "f {} {} {} {}", k + 2, k + 3, k + 1, k).unwrap();
    }
    let mut door = Door::new("pipe.obj", &(), Budget::default());
    let scene = read_scene("pipe.obj", file.as_bytes(), Up::Y, &mut door).unwrap();
    let (playback, _) = scene.playback(&Default::default()).unwrap();
    let frame = Poser::new(&scene).frame(0.0, &playback);
    let (tracer, surfaces) = (Tracer::new(&scene, &frame), Surfaces::new(&scene));
    let sky = chiaro_trace::Sky::new(Plane::filled(16, 8, [1.0; 3]));
    let lights = Lights { sky: Some(std::sync::Arc::new(sky)), ..Lights::default() };
    let lit = Lit { tracer: &tracer, surfaces: &surfaces, lights: &lights };
    let run = Run::default();
    let lens = Projection::Perspective { fov_y: 0.05 };
    let pose = Pose::look_at(vec3(0.0, 4.0, 0.0), Vec3::ZERO, Vec3::Z, lens);
    let buffer = GBuffer::trace(&tracer, &surfaces, &pose, (8, 8), &run).unwrap();
    let knobs =
        LightKnobs { surfels: 50_000, bounces: 1, error_bound: 0.0, ..LightKnobs::default() };
    let prepared = prepare(lit, &sites(&scene, &frame, 50_000), &knobs, &run).unwrap();
    let found = indirect(&prepared, &buffer, &run).unwrap().irradiance;
    let albedo = f64::from(buffer.base_colour[(4, 4)][0]);
    let mean = found.pixels().iter().map(|e| f64::from(e[0])).sum::<f64>() / 64.0;
    let exact = albedo * std::f64::consts::PI * 0.5f64.sqrt() / 4.0;
    assert!((mean / exact - 1.0).abs() < 0.05, "{mean} {exact}");
}
