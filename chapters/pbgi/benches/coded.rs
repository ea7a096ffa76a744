//! What a coded tree costs to gather from: processor milliseconds of the whole gather and of its walks
//! alone, of the binary tree in floats, the packed tree in floats, and the packed tree coded.
//!
//! `cargo bench -p chiaro-pbgi --bench coded [SCENE...]`, on one thread, one bounce; trees take turns,
//! least of several.

#![allow(clippy::print_stdout)]

mod common;

use chiaro_basis::{Result, Run};
use chiaro_pbgi::code::Recipe;
use chiaro_pbgi::cut::Chooser;
use chiaro_pbgi::packed::{Packed, Record};
use chiaro_pbgi::{Hierarchy, LightKnobs, Lit, Prepared, Spread, indirect, prepare, sites, stream};
use chiaro_scene::{Frame, Scene, demo};
use chiaro_trace::view::Framing;
use chiaro_trace::{GBuffer, Tracer, Vertex};
use std::time::Instant;

const SURFELS: usize = 100_000;
/// Records that the book is learned from.
const SPARSE: usize = 20_000;
const SIZE: (usize, usize) = (240, 180);
const RUNS: usize = 9;
/// Every so many pixels one walks the trees.
const APART: usize = 101;

type Trees<'a> = [(&'static str, &'a dyn Hierarchy); 3];

fn main() {
    let named: Vec<String> = std::env::args().skip(1).filter(|a| !a.starts_with('-')).collect();
    let scenes = if named.is_empty() {
        ["cornell-box", "courtyard"].map(String::from).to_vec()
    } else {
        named
    };
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a thread");
    for name in scenes {
        let measured = demo::scene(&name).and_then(|scene| pool.install(|| measure(&name, &scene)));
        if let Err(e) = measured {
            println!("{name}: {e}");
        }
    }
}

fn measure(name: &str, scene: &Scene) -> Result<()> {
    common::lit(scene, |frame, lit| measure_lit(name, scene, frame, lit))
}

fn measure_lit(name: &str, scene: &Scene, frame: &Frame, lit: Lit) -> Result<()> {
    let run = Run::default();
    let Lit { tracer, surfaces, .. } = lit;
    let knobs = LightKnobs { surfels: SURFELS as u32, bounces: 1, ..LightKnobs::default() };
    let cube = stream::cube(&lit, &Spread::of(scene, frame, SURFELS as u64));
    let of = |count| prepare(lit, &sites(scene, frame, count), &knobs, &run);
    let sorted = |p: &Prepared| -> Vec<Record> { stream::sorted(&p.surfels.all, &cube) };
    let book = stream::book(&sorted(&of(SPARSE)?), &Recipe::default(), &run)?;
    let prepared = of(SURFELS)?;
    let records = sorted(&prepared);
    let (packed, coded) =
        (Packed::build(&records), stream::coded_in_memory(&records, cube, &book)?);
    let (pose, _) = Framing::of(tracer, std::slice::from_ref(frame)).view(1.0, 0.0);
    let pose = frame.cameras.first().unwrap_or(&pose);
    let buffer = GBuffer::trace(tracer, surfaces, pose, SIZE, &run)?;
    let (mut prepared, binary) = prepared.with_tree(Shared(&packed));
    let trees: Trees = [("binary", &binary), ("packed", &packed), ("coded", &coded)];
    walks(name, &buffer, tracer, &knobs, trees);
    let mut least = [f64::INFINITY; 3];
    for _ in 0..RUNS {
        for ((_, tree), least) in trees.iter().zip(&mut least) {
            prepared.tree = Shared(*tree);
            let start = now();
            indirect(&prepared, &buffer, &run)?;
            *least = least.min(now() - start);
        }
    }
    say(name, "gather", trees, least);
    Ok(())
}

/// A tree that others hold too.
struct Shared<'a>(&'a dyn Hierarchy);

impl Hierarchy for Shared<'_> {
    fn cut(&self, chooser: &Chooser, splats: &mut Vec<chiaro_pbgi::cut::Splat>) -> u64 {
        self.0.cut(chooser, splats)
    }

    fn some(
        &self,
        span: chiaro_pbgi::cut::Span,
        most: usize,
        surfels: &mut Vec<chiaro_pbgi::Surfel>,
    ) {
        self.0.some(span, most, surfels);
    }

    fn leaf_radius(&self) -> f32 {
        self.0.leaf_radius()
    }

    fn is_empty(&self) -> bool {
        self.0.is_empty()
    }
}

/// Walks of some pixels, each the least of its runs.
fn walks(name: &str, buffer: &GBuffer, tracer: &Tracer, knobs: &LightKnobs, trees: Trees) {
    let texels = 6.0 * f64::from(knobs.resolution).powi(2);
    let threshold = (f64::from(knobs.solid_angle) * 4.0 * std::f64::consts::PI / texels) as f32;
    let (mut sums, mut splats) = ([0.0; 3], Vec::new());
    for at in (0..SIZE.0 * SIZE.1).step_by(APART).map(|i| (i % SIZE.0, i / SIZE.0)) {
        if !buffer.covered[at] {
            continue;
        }
        let vertex = Vertex::of_pixel(tracer, buffer, at);
        let near = 8.0 * trees[0].1.leaf_radius();
        let from = vertex.position;
        let chooser = Chooser { from, threshold, near, mark: near, above: None, flat: true };
        let mut least = [f64::INFINITY; 3];
        for _ in 0..RUNS {
            for ((_, tree), least) in trees.iter().zip(&mut least) {
                splats.clear();
                let start = Instant::now();
                tree.cut(&chooser, &mut splats);
                *least = least.min(start.elapsed().as_secs_f64());
            }
        }
        (0..3).for_each(|k| sums[k] += least[k]);
    }
    say(name, "walks", trees, sums);
}

fn say(name: &str, what: &str, trees: Trees, seconds: [f64; 3]) {
    print!("{name:<14} {what:<7}");
    for ((tree, _), s) in trees.iter().zip(seconds) {
        print!(" {tree} {:>8.1} ms", 1e3 * s);
    }
    println!("  coded over binary {:.2}", seconds[2] / seconds[0]);
}

/// Seconds that this thread has had of a processor, so that others' work does not count; else of the clock.
fn now() -> f64 {
    let told = std::fs::read_to_string("/proc/thread-self/schedstat").ok();
    let first = told.as_deref().and_then(|s| s.split(' ').next()?.parse::<f64>().ok());
    let clock = || {
        let since = std::time::SystemTime::now().duration_since(std::time::UNIX_EPOCH);
        since.map_or(0.0, |d| d.as_secs_f64())
    };
    first.map_or_else(clock, |ns| 1e-9 * ns)
}
