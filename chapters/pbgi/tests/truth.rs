//! Points against paths.

#![allow(clippy::unwrap_used)]

use chiaro_basis::Run;
use chiaro_image::metric;
use chiaro_pbgi::{LightKnobs, Lit, indirect, prepare, sites};
use chiaro_scene::{Poser, Scene, demo};
use chiaro_trace::path::{Aim, PathImage, PathTracer};
use chiaro_trace::{GBuffer, Glow, Lights, Surfaces, Tracer};

/// Something done in the Cornell box, lit by its lamp.
fn in_the_box<T>(act: impl FnOnce(&Scene, Lit, &Run) -> T) -> T {
    let scene = demo::scene("cornell-box").unwrap();
    let (playback, _) = scene.playback(&Default::default()).unwrap();
    let frame = Poser::new(&scene).frame(0.0, &playback);
    let tracer = Tracer::new(&scene, &frame);
    let surfaces = Surfaces::new(&scene);
    let lights = Lights { glow: Glow::of(&tracer, &surfaces), ..Lights::default() };
    act(&scene, Lit { tracer: &tracer, surfaces: &surfaces, lights: &lights }, &Run::default())
}

/// What its camera sees.
fn seen(lit: Lit, run: &Run) -> GBuffer {
    let camera = &lit.tracer.frame.cameras[0];
    GBuffer::trace(lit.tracer, lit.surfaces, camera, (48, 48), run).unwrap()
}

/// Relative errors of indirect radiance in the Cornell box, of each knobs, one bounce.
fn errors(all: &[LightKnobs]) -> Vec<f64> {
    in_the_box(|scene, lit, run| {
        let buffer = seen(lit, run);
        let Lit { tracer, surfaces, lights } = lit;
        let paths = PathTracer { tracer, surfaces, lights, bounces: 1 };
        let mut image = PathImage::new(48, 48);
        paths.add(&mut image, &buffer.pose, 512, Aim::Centre, run).unwrap();
        let truth = image.indirect();
        all.iter()
            .map(|knobs| {
                let sites = sites(scene, lit.tracer.frame, knobs.surfels as usize);
                let prepared = prepare(lit, &sites, knobs, run).unwrap();
                let found = indirect(&prepared, &buffer, run).unwrap();
                let reflected = |e: &[f32; 3], a: &[f32; 3]| {
                    std::array::from_fn(|c| a[c] * e[c] / std::f32::consts::PI)
                };
                let own = found.irradiance.zip(&buffer.base_colour, reflected).unwrap();
                metric::rmse_relative(&own, &truth, &buffer.covered).unwrap().unwrap()
            })
            .collect()
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
