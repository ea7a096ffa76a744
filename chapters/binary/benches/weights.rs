//! Nanoseconds a pixel for the weights of binary shading by part, on one thread.
//!
//! The picture is a relief of rocks at 1 Mpx in the default style. `cargo bench -p chiaro-binary` prints
//! the best of several runs; `-- 2` takes two threads, `-- courtyard desk` other demo scenes.
//! Nanoseconds are those of a covered pixel.

#![allow(clippy::print_stdout)]

use chiaro_basis::Run;
use chiaro_binary::{
    BinaryKnobs, Channel, Channels, Features, Graph, Lit, View, compose, expose, mixed_tone,
    neighbour_factors, outline, shade, terminal,
};
use chiaro_image::filter;
use chiaro_scene::demo;
use chiaro_trace::{GBuffer, Lamp, Lamps, Surfaces, Tracer, view};
use std::borrow::Cow;
use std::hint::black_box;
use std::time::Instant;

const SIDE: usize = 1024;

fn main() {
    let threads = std::env::args().filter_map(|a| a.parse().ok()).next().unwrap_or(1);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
    let is_name = |a: &String| !a.starts_with('-') && a.parse::<usize>().is_err();
    let mut names: Vec<String> = std::env::args().skip(1).filter(is_name).collect();
    if names.is_empty() {
        names.push("rocks".into());
    }
    for name in names {
        let view = seen(&name);
        let share =
            100 * view.buffer.covered.pixels().iter().filter(|c| **c).count() / (SIDE * SIDE);
        println!("{name}, {SIDE} x {SIDE} pixels, {share} % covered, threads: {threads}");
        pool.install(|| report(&view));
    }
}

/// Times each part.
fn report(view: &View) {
    let (knobs, run) = (BinaryKnobs::default(), Run::default());
    let covered = &view.buffer.covered;
    let views = std::slice::from_ref(view);
    let exposure = expose(views, true, &knobs, &run).expect("nobody cancels");
    let difference = terminal(view, &exposure, &knobs);
    let factors = neighbour_factors(&view.buffer, &knobs);
    let graph = Graph::new(covered, &difference, &factors, &knobs);
    let labels = graph.solve().expect("weights are small");
    let steps = shade(view, &exposure, &knobs, true, &run).expect("nobody cancels");

    let pixels = covered.pixels().iter().filter(|c| **c).count();
    time("tone", pixels, || mixed_tone(&view.channels, covered, &knobs));
    let all =
        time("terminal weights, flat faces included", pixels, || terminal(view, &exposure, &knobs));
    time("mean normals", pixels, || {
        filter::gaussian_covered3(
            &view.buffer.normal,
            covered,
            3.0 * SIDE as f32 / 480.0 / 2f32.sqrt(),
        )
    });
    time("neighbour weights, means included", pixels, || neighbour_factors(&view.buffer, &knobs));
    time("capacities", pixels, || Graph::new(covered, &difference, &factors, &knobs));
    let graphs = time("graph, means to capacities, in one", pixels, || {
        Graph::of(Cow::Borrowed(&view.buffer), || Cow::Borrowed(&difference), &knobs)
    });
    println!("{:<36} {:7.1} ns", "weights in all", all + graphs);
    time("cut", pixels, || graph.solve());
    time("round", pixels, || graph.rounded(&labels.white, &knobs).expect("weights are small"));
    time("islands", pixels, || graph.without_islands(&labels.white, 30.0));
    time("lines", pixels, || {
        let features = Features::find(&view.buffer, &knobs);
        outline(&features, &steps.white, covered, true, &knobs)
    });
    time("draw", pixels, || compose(&steps.region, covered, &steps.lines, &knobs));
}

/// The best of several runs, in nanoseconds a pixel.
fn time<T>(part: &str, pixels: usize, work: impl Fn() -> T) -> f64 {
    let mut best = f64::INFINITY;
    for _ in 0..7 {
        let start = Instant::now();
        black_box(work());
        best = best.min(start.elapsed().as_secs_f64());
    }
    let ns = best * 1e9 / pixels.max(1) as f64;
    println!("{part:<36} {ns:7.1} ns");
    ns
}

fn seen(name: &str) -> View {
    let run = Run::default();
    let scene = demo::scene(name).expect("a demo scene");
    let playback = scene.playback(&chiaro_scene::Choice::Auto).expect("it has clips or none").0;
    let frame = chiaro_scene::Poser::new(&scene).frame(0.0, &playback);
    let tracer = Tracer::new(&scene, &frame);
    let surfaces = Surfaces::new(&scene);
    let framing = view::Framing::of(&tracer, std::slice::from_ref(&frame));
    let (pose, _) = framing.view(1.0, 0.0);
    let buffer = GBuffer::trace(&tracer, &surfaces, &pose, (SIDE, SIDE), &run).expect("no cancel");
    let lamps = Lamps::of(vec![Lamp::key(&pose)]);
    let lit = Lit { tracer: &tracer, surfaces: &surfaces, buffer: &buffer, lamps: &lamps };
    let knobs = BinaryKnobs::default();
    let wanted = |c: Channel| c.is_used(&knobs);
    let channels = Channels::render(&lit, wanted, &knobs, true, &run).expect("no cancel");
    View { buffer, channels }
}
