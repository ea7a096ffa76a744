//! How long brushes take: `cargo bench -p chiaro-ink --bench brush`.
//!
//! 300 strokes of 10 to 400 pixels, a sample every 3 pixels, in a picture of 1024 x 768; the least
//! of five runs, on one thread and on all.

#![allow(clippy::print_stdout)]

use chiaro_basis::math::Vec2;
use chiaro_basis::{Knobs, random};
use chiaro_image::Plane;
use chiaro_ink::brush::{Axis, Brush, Knot, Spine, Stroke, paint};
use std::time::Instant;

const SIZE: (usize, usize) = (1024, 768);

fn main() {
    let spines: Vec<Spine> = (0..300).map(spine).collect();
    let length: f32 = spines.iter().map(Spine::length).sum();
    println!("300 strokes, {length:.0} px");
    for (name, sets) in [
        ("pen", &[("width", "2.4"), ("pressure", "0.4"), ("taper", "26")][..]),
        ("brush", &[("width", "9"), ("grain", "bristle"), ("rough", "0.7"), ("taper", "90")]),
        ("charcoal", &[("width", "9.5"), ("grain", "charcoal"), ("rough", "1.1")]),
        ("thorns", &[("mark", "thorns"), ("spacing", "17")]),
        ("fur", &[("mark", "fur"), ("spacing", "1.7"), ("size", "10")]),
        ("halo", &[("width", "4"), ("halo", "3"), ("rim", "2")]),
    ] {
        let mut brush = Brush::default();
        sets.iter().for_each(|(k, v)| brush.set(k, v).expect("a knob of brushes"));
        println!(
            "{name:<10} {:>7.1} ms on one thread, {:>7.1} on all",
            one(&spines, &brush),
            best(&spines, &brush)
        );
    }
}

fn one(spines: &[Spine], brush: &Brush) -> f64 {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a thread");
    pool.install(|| best(spines, brush))
}

fn best(spines: &[Spine], brush: &Brush) -> f64 {
    let beneath = Plane::filled(SIZE.0, SIZE.1, [1.0; 4]);
    let (texture, colour, hides, right) = (None, [0.0, 0.0, 0.0, 1.0], true, true);
    let strokes: Vec<Stroke<'_>> =
        spines.iter().map(|spine| Stroke { spine, brush, texture, colour, hides, right }).collect();
    let run = |_| {
        let start = Instant::now();
        std::hint::black_box(paint(&strokes, &beneath, [1.0; 4]));
        start.elapsed().as_secs_f64() * 1e3
    };
    (0..5).map(run).fold(f64::INFINITY, f64::min)
}

/// A stroke that wanders.
fn spine(i: u64) -> Spine {
    let share = |k: u64| random::unit(i, k);
    let mut at = Vec2::new(share(0) * SIZE.0 as f32, share(1) * SIZE.1 as f32);
    let mut heading = share(2) * std::f32::consts::TAU;
    let knot = |k: u64| {
        heading += 0.3 * (share(5 + k) - 0.5);
        at += 3.0 * Vec2::from_angle(heading);
        Knot { at, u: 3.0 * k as f64, depth: i as f32 }
    };
    let count = 4 + (130.0 * share(3).powi(2)) as u64;
    Spine::new((0..count).map(knot).collect(), false, Axis { seed: i, period: None })
}
