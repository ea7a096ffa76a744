//! Milliseconds from a change to the new exact cut, beside a fresh solution of the same problem.
//!
//! On a picture of 1920 x 1080: strokes of 200 x 31 pixels against the present label, and their
//! undoing. On half of that: a brightness slider that shifts every terminal.

#![allow(clippy::print_stdout)]

#[path = "relief/mod.rs"]
mod relief;

use chiaro_mincut::{Grid, Solver, solve};
use std::time::Instant;

/// Strokes over the width of the picture.
const STROKES: usize = 8;

fn main() {
    strokes(1920, 1080);
    slider(960, 540);
}

fn milliseconds(since: Instant) -> f64 {
    since.elapsed().as_secs_f64() * 1e3
}

/// Times strokes and their undoing.
fn strokes(width: usize, height: usize) {
    let (terminal, neighbour) = relief::relief(width, height, height);
    let mask = vec![true; width * height];
    let grid = Grid { width, height, mask: &mask, terminal: &terminal, neighbour: &neighbour };
    let start = Instant::now();
    let mut solver = Solver::new(&(&grid).into()).expect("the picture keeps to the bounds");
    println!("{width} x {height}: solved in {:.1} ms", milliseconds(start));
    for stroke in 0..STROKES {
        let (x, y) = (stroke * (width - 200) / STROKES, (stroke * 211 + 97) % (height - 31));
        let label = !solver.labels()[(y + 15) * width + x + 100];
        let mut paint = |label| {
            let start = Instant::now();
            for pixel in (y..y + 31).flat_map(|y| y * width + x..y * width + x + 200) {
                solver.fix(pixel, label).expect("the stroke lies in the picture");
            }
            solver.solve();
            milliseconds(start)
        };
        println!("stroke {:.2} ms, undone {:.2} ms", paint(Some(label)), paint(None));
    }
}

/// Times steps of a brightness slider.
fn slider(width: usize, height: usize) {
    let (mut terminal, neighbour) = relief::relief(width, height, height);
    let mask = vec![true; width * height];
    let grid = Grid { width, height, mask: &mask, terminal: &terminal, neighbour: &neighbour };
    let mut solver = Solver::new(&(&grid).into()).expect("the picture keeps to the bounds");
    for shift in [40, 40, 400, -400, 1000] {
        for pair in &mut terminal {
            let difference = pair[0] - pair[1] + shift;
            *pair = [difference.max(0), (-difference).max(0)];
        }
        let start = Instant::now();
        for (pixel, &pair) in terminal.iter().enumerate() {
            solver.set_terminal(pixel, pair).expect("the picture keeps to the bounds");
        }
        let flow = solver.solve();
        let warm = milliseconds(start);
        let start = Instant::now();
        let grid = Grid { width, height, mask: &mask, terminal: &terminal, neighbour: &neighbour };
        let fresh = solve(&grid).expect("the picture keeps to the bounds");
        assert_eq!((flow, solver.labels()), (fresh.flow, &fresh.labels[..]));
        println!(
            "{width} x {height}: shift {shift} {warm:.1} ms, fresh {:.1} ms",
            milliseconds(start)
        );
    }
}
