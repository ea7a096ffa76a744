//! Surfels a second of the tree's build, and milliseconds a gather, of the binary tree and of the octree: a
//! million surfels, 8 x 8 x 6 texels, nodes opened down to one texel.
//!
//! `cargo bench -p chiaro-pbgi --bench gather`, on one thread; least of several runs.

#![allow(clippy::print_stdout)]

use chiaro_basis::Run;
use chiaro_pbgi::pixel::{Workspace, gather};
use chiaro_pbgi::{Division, LightKnobs, Lit, Tree, prepare, sites};
use chiaro_scene::{Choice, Poser, demo};
use chiaro_trace::{GBuffer, Glow, Lamp, Lights, Surfaces, Tracer, Vertex};
use std::time::Instant;

const SURFELS: usize = 1_000_000;
const RUNS: usize = 3;

fn main() {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a thread");
    println!("{:<16} {:<28} {:>10}", "scene", "what", "figure");
    for name in ["cornell-box", "sphere-field"] {
        pool.install(|| measure(name));
    }
}

fn measure(name: &str) {
    let scene = demo::scene(name).expect("the scene is there");
    let (playback, _) = scene.playback(&Choice::Auto).expect("nothing clashes");
    let frame = Poser::new(&scene).frame(0.0, &playback);
    let tracer = Tracer::new(&scene, &frame);
    let surfaces = Surfaces::new(&scene);
    let glow = Glow::of(&tracer, &surfaces);
    let lights = Lights { lamps: Lamp::of_frame(&frame), glow, sky: None };
    let lit = Lit { tracer: &tracer, surfaces: &surfaces, lights: &lights };
    let run = Run::default();
    let knobs = LightKnobs {
        surfels: SURFELS as u32,
        bounces: 1,
        resolution: 8,
        solid_angle: 1.0,
        error_bound: 0.0,
        ..LightKnobs::default()
    };
    let prepared =
        prepare(lit, &sites(&scene, &frame, SURFELS), &knobs, &run).expect("nobody cancels");
    let say = |what: &str, figure: f64| println!("{name:<16} {what:<28} {figure:>10.3}");
    let (pose, _) =
        chiaro_trace::view::Framing::of(&tracer, std::slice::from_ref(&frame)).view(1.0, 0.0);
    let pose = frame.cameras.first().unwrap_or(&pose);
    let buffer = GBuffer::trace(&tracer, &surfaces, pose, (24, 24), &run).expect("nobody cancels");
    let receivers: Vec<Vertex> = (0..24 * 24)
        .map(|i| (i % 24, i / 24))
        .filter(|p| buffer.covered[*p])
        .map(|p| Vertex::of_pixel(&tracer, &buffer, p))
        .collect();
    let mut prepared = prepared;
    for (name, division) in [("spheres", Division::Spheres), ("octree", Division::Octree)] {
        let say = |what: &str, figure: f64| say(&format!("{name}: {what}"), figure);
        let build = least(|| Tree::build_by(division, &prepared.surfels.all).nodes.len());
        say("M surfels/s", 1e-6 * prepared.surfels.all.len() as f64 / build);
        let tree = Tree::build_by(division, &prepared.surfels.all);
        say("nodes", tree.nodes.len() as f64);
        prepared = prepared.with_tree(tree).0;
        for near_field in [true, false] {
            prepared.knobs.near_field = near_field;
            let mut work = Workspace::new(8);
            let mut visited = 0;
            let seconds = least(|| {
                let one =
                    |(i, at)| gather(&prepared, at, f32::INFINITY, &mut work, i as u64).visited;
                visited = receivers.iter().enumerate().map(one).sum();
            });
            let count = receivers.len() as f64;
            say(
                if near_field { "gather, ms" } else { "of discs alone, ms" },
                1e3 * seconds / count,
            );
            say("nodes visited", visited as f64 / count);
        }
    }
}

/// The least seconds of some runs.
fn least<T>(mut work: impl FnMut() -> T) -> f64 {
    let one = |_| {
        let start = Instant::now();
        std::hint::black_box(work());
        start.elapsed().as_secs_f64()
    };
    (0..RUNS).map(one).fold(f64::INFINITY, f64::min)
}
