//! Rays a second and nanoseconds a pixel of a geometry buffer, least of several runs.
//!
//! `cargo bench -p chiaro-trace` runs all scenes; a name runs one: head, sphere-field (512k
//! triangles), courtyard (instances). `RAYON_NUM_THREADS=1` gives figures of one core.

#![allow(clippy::print_stdout)]

use chiaro_basis::math::{Vec3, vec3};
use chiaro_basis::{Run, random};
use chiaro_image::Plane;
use chiaro_scene::{Choice, Frame, Pose, Poser, Scene, demo};
use chiaro_trace::view::Framing;
use chiaro_trace::{GBuffer, Ray, Sides, Surfaces, Tracer};
use std::time::Instant;

const SIZE: (usize, usize) = (960, 540);
const RUNS: usize = 5;

fn main() {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let all = ["head", "sphere-field", "courtyard"];
    let named: Vec<&str> = all.into_iter().filter(|n| words.iter().any(|w| w == n)).collect();
    println!("{:<14} {:<24} {:>12}", "scene", "what", "figure");
    for name in if named.is_empty() { &all[..] } else { &named } {
        let scene = demo::scene(name).expect("the scene is there");
        let (playback, _) = scene.playback(&Choice::Auto).expect("clips play together");
        let frame = Poser::new(&scene).frame(0.0, &playback);
        measure(name, &scene, &frame);
    }
}

fn measure(name: &str, scene: &Scene, frame: &Frame) {
    let say = |what: &str, figure: String| println!("{name:<14} {what:<24} {figure:>12}");
    let (seconds, tracer) = least(|| Tracer::new(scene, frame));
    say("hierarchy, ms", format!("{:.1}", 1e3 * seconds));
    let aspect = SIZE.0 as f32 / SIZE.1 as f32;
    let (pose, _) = Framing::of(&tracer, std::slice::from_ref(frame)).view(aspect, 0.0);
    let pixels = (SIZE.0 * SIZE.1) as f64;

    let primary = camera_rays(&pose);
    let (seconds, _) = least(|| primary.map(|ray| tracer.hit(ray, Sides::AsMaterials).is_some()));
    say("camera, Mrays/s", format!("{:.2}", 1e-6 * pixels / seconds));

    let surfaces = Surfaces::new(scene);
    let run = Run::default();
    let (seconds, buffer) =
        least(|| GBuffer::trace(&tracer, &surfaces, &pose, SIZE, &run).expect("nobody cancels"));
    say("geometry buffer, ns/px", format!("{:.0}", 1e9 * seconds / pixels));

    let covered = buffer.covered.pixels().iter().filter(|c| **c).count() as f64;
    let shadow = rays_from(&buffer, &tracer, |_, _| vec3(-0.55, 0.65, 0.52).normalize());
    let (seconds, _) = least(|| shadow.map(|ray| tracer.occluded(ray)));
    say("shadow, Mrays/s", format!("{:.2}", 1e-6 * covered / seconds));
    let spread = rays_from(&buffer, &tracer, over_hemisphere);
    let (seconds, _) = least(|| spread.map(|ray| tracer.occluded(ray)));
    say("occlusion, Mrays/s", format!("{:.2}", 1e-6 * covered / seconds));
}

/// The least seconds of some runs, and the last value.
fn least<T>(work: impl Fn() -> T) -> (f64, T) {
    let mut best = f64::INFINITY;
    let mut value = None;
    for _ in 0..RUNS {
        let start = Instant::now();
        value = Some(work());
        best = best.min(start.elapsed().as_secs_f64());
    }
    (best, value.expect("there is a run"))
}

fn camera_rays(pose: &Pose) -> Plane<Ray> {
    let (w, h) = (SIZE.0 as f32, SIZE.1 as f32);
    Plane::from_fn(SIZE.0, SIZE.1, |x, y| {
        let (origin, direction) = pose.ray(x as f32 + 0.5, y as f32 + 0.5, w, h);
        Ray { origin, direction, t_max: f32::INFINITY }
    })
}

/// One ray from each covered pixel; from the others a ray of no length.
fn rays_from(
    buffer: &GBuffer,
    tracer: &Tracer,
    towards: impl Fn(u64, Vec3) -> Vec3 + Sync,
) -> Plane<Ray> {
    let width = SIZE.0;
    Plane::from_fn(SIZE.0, SIZE.1, |x, y| {
        let normal = Vec3::from(buffer.geometric_normal[(x, y)]);
        let origin = Vec3::from(buffer.position[(x, y)]) + normal * tracer.offset();
        let t_max = if buffer.covered[(x, y)] { f32::INFINITY } else { 0.0 };
        Ray { origin, direction: towards((y * width + x) as u64, normal), t_max }
    })
}

/// A direction of its own for each pixel, over the side that is seen: the least coherent rays.
fn over_hemisphere(pixel: u64, normal: Vec3) -> Vec3 {
    let z = 1.0 - 2.0 * random::unit(1, pixel);
    let (s, c) = (std::f32::consts::TAU * random::unit(2, pixel)).sin_cos();
    let r = (1.0 - z * z).sqrt();
    let d = vec3(r * c, r * s, z);
    if d.dot(normal) < 0.0 { -d } else { d }
}
