//! Microseconds to find the nearest of k centres in 27 dimensions, with and without a hint, and to
//! make the centres. Points lie near a curved sheet of few dimensions, as nodes' lobes do.

#![allow(clippy::print_stdout)]

use chiaro_basis::Run;
use chiaro_basis::random::unit;
use chiaro_solve::{KMeans, Nearest, Scratch, Start, k_means};
use std::time::Instant;

const DIM: usize = 27;

/// Colour times a smooth function of a direction, and a little noise.
fn points(count: usize, seed: u64) -> Vec<f32> {
    (0..count as u64)
        .flat_map(|i| {
            let u = |k: u64| unit(seed + k, i);
            let (z, a) = (2.0 * u(0) - 1.0, std::f32::consts::TAU * u(1));
            let r = (1.0 - z * z).sqrt();
            let (x, y) = (r * a.cos(), r * a.sin());
            let lobe = [1.0, y, z, x, x * y, y * z, z * z, x * z, x * x - y * y];
            let colour = [u(2) * u(5), u(2) * u(3), u(2) * u(4)];
            let noise = move |c: usize, k: usize| 0.02 * unit(seed + 9 + (c * 9 + k) as u64, i);
            colour.into_iter().enumerate().flat_map(move |(c, l)| {
                lobe.into_iter().enumerate().map(move |(k, s)| l * s + noise(c, k))
            })
        })
        .collect()
}

fn main() {
    let (training, queries) = (points(100_000, 1), points(50_000, 100));
    for count in [100, 1000, 10_000] {
        let start = Instant::now();
        let how = KMeans { count, rounds: 5, seed: 1, start: Start::Spread };
        let Ok(found) = k_means(&training, DIM, how, &Run::default()) else { return };
        let made = start.elapsed().as_secs_f64();
        let index = Nearest::new(&found.centres, DIM);
        let mut scratch = Scratch::default();
        let mut last = None;
        let mut time = |hinted: bool| {
            let start = Instant::now();
            let mut sum = 0.0;
            for q in queries.chunks_exact(DIM) {
                let hint = if hinted { last } else { None };
                let Some(f) = index.find(q, hint, &mut scratch) else { continue };
                (sum, last) = (sum + f.square, Some(f.index));
            }
            std::hint::black_box(sum);
            1e6 * start.elapsed().as_secs_f64() / (queries.len() / DIM) as f64
        };
        let (plain, hinted) = (time(false), time(true));
        println!("k {count:6}: {made:6.2} s made, {plain:.2} us found, {hinted:.2} hinted");
    }
}
