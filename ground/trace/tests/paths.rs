//! The reference against closed forms.

#![allow(clippy::unwrap_used)]

use chiaro_basis::Run;
use chiaro_image::Plane;
use chiaro_scene::{Frame, Poser, Scene, demo};
use chiaro_trace::path::{Aim, PathImage, PathTracer};
use chiaro_trace::{Glow, Lights, Sky, Surfaces, Tracer};
use std::sync::Arc;

fn frame(scene: &Scene) -> Frame {
    let (playback, _) = scene.playback(&Default::default()).unwrap();
    Poser::new(scene).frame(0.0, &playback)
}

/// A furnace: a white body under a sky of one colour has that colour everywhere.
#[test]
fn a_white_body_under_a_uniform_sky_cannot_be_seen() {
    let mut scene = demo::scene("cornell-box").unwrap();
    for m in &mut scene.materials {
        (m.base_colour, m.emissive) = ([1.0; 4], [0.0; 3]);
    }
    let frame = frame(&scene);
    let tracer = Tracer::new(&scene, &frame);
    let surfaces = Surfaces::new(&scene);
    let sky = Sky::new(Plane::filled(16, 8, [2.0, 1.0, 0.5]));
    let lights = Lights { sky: Some(Arc::new(sky)), ..Lights::default() };
    let paths = PathTracer {
        tracer: &tracer,
        surfaces: &surfaces,
        lights: &lights,
        bounces: 200,
        glossy: false,
    };
    let mut image = PathImage::new(12, 12);
    paths.add(&mut image, &frame.cameras[0], 64, Aim::Spread, &Run::default()).unwrap();
    let (d, i, b) = (image.direct(), image.indirect(), image.beyond());
    for c in 0..3 {
        let sum: f32 = [&d, &i, &b].iter().flat_map(|p| p.pixels()).map(|p| p[c]).sum();
        let mean = sum / 144.0;
        assert!((mean / [2.0, 1.0, 0.5][c] - 1.0).abs() < 0.03, "{c}: {mean}");
    }
}

/// Light samples and rays that meet the lamp by chance are two estimates of the same; weighed by the
/// balance heuristic they agree with light samples alone.
#[test]
fn direct_light_by_both_strategies_is_that_by_lamps() {
    let scene = demo::scene("cornell-box").unwrap();
    let frame = frame(&scene);
    let tracer = Tracer::new(&scene, &frame);
    let surfaces = Surfaces::new(&scene);
    let lights = Lights { glow: Glow::of(&tracer, &surfaces), ..Lights::default() };
    let run = Run::default();
    let buffer =
        chiaro_trace::GBuffer::trace(&tracer, &surfaces, &frame.cameras[0], (24, 24), &run)
            .unwrap();
    let fixed = chiaro_trace::direct_irradiance(&tracer, &buffer, &lights, &run).unwrap().whole();
    let paths = PathTracer {
        tracer: &tracer,
        surfaces: &surfaces,
        lights: &lights,
        bounces: 0,
        glossy: false,
    };
    let mut image = PathImage::new(24, 24);
    paths.add(&mut image, &buffer.pose, 256, Aim::Centre, &run).unwrap();
    let direct = image.direct();
    let (mut own, mut truth) = (0.0, 0.0);
    for y in 0..24 {
        for x in 0..24 {
            if buffer.emissive[(x, y)] == [0.0; 3] {
                own += buffer.base_colour[(x, y)][1] * fixed[(x, y)][1] / std::f32::consts::PI;
                truth += direct[(x, y)][1];
            }
        }
    }
    assert!((own / truth - 1.0).abs() < 0.04, "{own} {truth}");
}

#[test]
fn paths_have_the_same_bits_for_any_number_of_threads() {
    let scene = demo::scene("cornell-box").unwrap();
    let frame = frame(&scene);
    let tracer = Tracer::new(&scene, &frame);
    let surfaces = Surfaces::new(&scene);
    let lights = Lights { glow: Glow::of(&tracer, &surfaces), ..Lights::default() };
    let paths = PathTracer {
        tracer: &tracer,
        surfaces: &surfaces,
        lights: &lights,
        bounces: 2,
        glossy: false,
    };
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let mut image = PathImage::new(16, 16);
        let run = Run::default();
        pool.install(|| paths.add(&mut image, &frame.cameras[0], 4, Aim::Spread, &run)).unwrap();
        image.indirect()
    };
    assert_eq!(on(1), on(3));
}
