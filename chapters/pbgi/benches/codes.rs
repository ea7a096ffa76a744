//! What codes of lobes cost and lose: bytes a node, signal over error of all nodes' radiance in
//! decibels, the 99th percentile of a node's own relative error, and microseconds to code a node.
//! Books are trained on a sparse tree of 20 000 surfels, measured on a tree of 200 000.
//! `cargo bench -p chiaro-pbgi --bench codes [SCENE...]`

#![allow(clippy::print_stdout)]

mod common;

use chiaro_basis::math::Vec3;
use chiaro_basis::{Result, Run};
use chiaro_pbgi::code::{Gains, Lobes, Pen, Recipe, Words};
use chiaro_pbgi::packed::{Packed, Record};
use chiaro_pbgi::{Exact, LightKnobs, Spread, prepare, sites, stream};
use chiaro_scene::{Scene, demo};
use std::time::Instant;

type Nodes = Vec<(f32, Vec3, Exact)>;

fn main() {
    let named: Vec<String> = std::env::args().skip(1).filter(|a| !a.starts_with('-')).collect();
    let defaults = ["cornell-box", "courtyard", "sphere-field"].map(String::from);
    let scenes = if named.is_empty() { defaults.to_vec() } else { named };
    for name in scenes {
        if let Err(e) = demo::scene(&name).and_then(|scene| measure(&name, &scene)) {
            println!("{name}: {e}");
        }
    }
}

fn measure(name: &str, scene: &Scene) -> Result<()> {
    let run = Run::default();
    let sparse = records(scene, 20_000, &run)?;
    let nodes = nodes(&records(scene, 200_000, &run)?);
    println!("{name}: {} nodes", nodes.len());
    println!("  {:<28} {:>6} {:>7} {:>8} {:>7}", "code", "bytes", "dB", "p99", "us");
    let half = nodes.iter().map(|n| apart(&n.2, &halved(&n.2)));
    line("half floats", 72, errors(&nodes, half), 0.0);
    let mut all = Vec::new();
    for words in [100, 1000, 10_000] {
        all.push((format!("thesis, {words} at random"), random(Recipe::raw(words))));
        all.push((format!("thesis, {words}"), Recipe::raw(words)));
        all.push((format!("over area, {words}"), Recipe::clusters(words)));
    }
    all.push(("residual 4x8, area 3x8".into(), Recipe::residual(Gains::One, false, 4, 3)));
    all.push(("the same, turned".into(), Recipe::residual(Gains::One, true, 4, 3)));
    for (light, area) in [(1, 1), (2, 2), (3, 2), (4, 3)] {
        let recipe = Recipe::residual(Gains::Colours, true, light, area);
        all.push((format!("gains, turned, {light}x8 + {area}x8"), recipe));
    }
    for (light, area) in [(1, 1), (2, 2), (3, 2), (4, 3)] {
        let recipe = Recipe::residual(Gains::Colours, false, light, area);
        all.push((format!("gains, {light}x8 + {area}x8"), recipe));
    }
    for words in [256, 4096] {
        all.push((format!("colour x shape, {words}"), Recipe::shapes(words, words)));
    }
    for stages in [2, 3] {
        let recipe = Recipe::residual(Gains::Shape, true, stages, stages);
        all.push((format!("colour x shape, {stages}x8"), recipe));
    }
    for (label, recipe) in all {
        let start = Instant::now();
        let book = stream::book(&sparse, &recipe, &run)?;
        let learned = start.elapsed().as_secs_f64();
        let start = Instant::now();
        let (mut pen, mut code) = (Pen::default(), Vec::new());
        for (area, axis, sums) in &nodes {
            code.clear();
            book.encode(&Lobes::new(sums, *area, *axis), &mut code, &mut pen);
        }
        let each = 1e6 * start.elapsed().as_secs_f64() / nodes.len() as f64;
        let squares = nodes.iter().map(|(area, axis, sums)| {
            book.error(&Lobes::new(sums, *area, *axis), &mut Pen::default())
        });
        line(&label, recipe.bytes(), errors(&nodes, squares), each);
        println!("{:>60} s to learn", format!("{learned:.2}"));
    }
    Ok(())
}

fn line(label: &str, bytes: usize, [snr, p99]: [f64; 2], us: f64) {
    println!("  {label:<28} {bytes:>6} {snr:>7.1} {:>7.1}% {us:>7.2}", 100.0 * p99);
}

fn random(recipe: Recipe) -> Recipe {
    Recipe { words: Words::Drawn, ..recipe }
}

/// The lit records of a scene, one bounce.
fn records(scene: &Scene, count: usize, run: &Run) -> Result<Vec<Record>> {
    let knobs = LightKnobs { bounces: 1, ..LightKnobs::default() };
    common::lit(scene, |frame, lit| {
        let prepared = prepare(lit, &sites(scene, frame, count), &knobs, run)?;
        let cube = stream::cube(&lit, &Spread::of(scene, frame, count as u64));
        Ok(stream::sorted(&prepared.surfels.all, &cube))
    })
}

fn nodes(records: &[Record]) -> Nodes {
    let mut nodes = Vec::new();
    Packed::build(records).each_node(|node, lobes| nodes.push((node.area, node.axis, *lobes)));
    nodes
}

/// Bits of a half float's mantissa; exponents are as wide as needed.
fn halved(lobes: &Exact) -> Exact {
    let half = |v: f32| f32::from_bits((v.to_bits() + (1 << 12)) & !((1 << 13) - 1));
    Exact { area: lobes.area.map(half), light: lobes.light.map(|l| l.map(half)) }
}

/// Decibels of the light over its error, nodes over their areas; the 99th percentile of a lit
/// node's own error. Of each node the squares of error and light.
fn errors(nodes: &Nodes, squares: impl Iterator<Item = [f64; 2]>) -> [f64; 2] {
    let (mut signal, mut noise, mut own) = (0.0, 0.0, Vec::new());
    for ((area, ..), [wrong, there]) in nodes.iter().zip(squares) {
        let scale = f64::from(*area).powi(2);
        signal += there / scale;
        noise += wrong / scale;
        if there > 0.0 {
            own.push((wrong / there).sqrt());
        }
    }
    own.sort_by(f64::total_cmp);
    let p99 = own.get(own.len() * 99 / 100).copied().unwrap_or(0.0);
    [10.0 * (signal / f64::max(noise, f64::MIN_POSITIVE)).log10(), p99]
}

fn apart(a: &Exact, b: &Exact) -> [f64; 2] {
    let pairs = a.light.as_flattened().iter().zip(b.light.as_flattened());
    pairs.fold([0.0; 2], |[wrong, there], (a, b)| {
        [wrong + f64::from(a - b).powi(2), there + f64::from(*a).powi(2)]
    })
}
