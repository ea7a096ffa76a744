//! Nanoseconds a pixel for whole cuts of a full-frame textured picture, on one thread and on two:
//! the same forms at every size, so that regions and paths grow with it, and more forms of the same
//! size in pixels, so that what grows is the work of the solver on the same problem.
//!
//! `cargo bench -p chiaro-mincut --bench texture` prints the best of several runs; an argument
//! names one size in megapixels.

#![allow(clippy::print_stdout)]

#[path = "relief/mod.rs"]
mod relief;

use chiaro_mincut::{Grid, solve_on};
use std::time::Instant;

fn main() {
    let only = std::env::args().filter_map(|arg| arg.parse::<f64>().ok()).next();
    for (megapixels, width, height) in
        [(0.26, 512, 512), (1.0, 1024, 1024), (2.0, 2048, 1024), (8.3, 3840, 2160)]
    {
        if only.is_none_or(|size| size == megapixels) {
            report(megapixels, width, height, height, "same forms");
            report(megapixels, width, height, 512, "more forms");
        }
    }
}

/// Times one size.
fn report(megapixels: f64, width: usize, height: usize, rows: usize, forms: &str) {
    let pixels = width * height;
    let (terminal, neighbour) = relief::relief(width, height, rows);
    let mask = vec![true; pixels];
    let grid = Grid { width, height, mask: &mask, terminal: &terminal, neighbour: &neighbour };
    let mut best = [f64::INFINITY; 2];
    let mut cuts = Vec::new();
    for _ in 0..(20_000_000 / pixels).clamp(3, 15) {
        cuts.clear();
        for (threads, best) in (1..).zip(&mut best) {
            let start = Instant::now();
            cuts.push(solve_on(&grid, threads).expect("the picture keeps to the bounds"));
            *best = best.min(start.elapsed().as_secs_f64());
        }
        assert_eq!(cuts[0], cuts[1]);
    }
    let [one, two] = best.map(|seconds| seconds * 1e9 / pixels as f64);
    let flow = cuts[0].flow;
    println!(
        "{megapixels:5} Mpx, {forms}: {one:7.1} ns a pixel, {two:7.1} on two threads   flow {flow}"
    );
}
