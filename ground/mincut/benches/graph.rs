//! Time and memory of whole cuts on the graphs of real pictures, on one thread.
//!
//! `chiaro binary SCENE -o OUT --dump-graph DIR` writes such a graph; `cargo bench -p chiaro-mincut
//! --bench graph -- DIR...` prints a line for each: pixels, nanoseconds a pixel (the best of several
//! runs, from capacities to labels), peak bytes a pixel beyond the input, flow, whether labels are
//! those of the dump. `compare.py` beside this file sets other solvers beside it. The word `family`
//! among the folders adds the time of all cuts over 4096 shifts, in cuts.

#![allow(clippy::print_stdout)]
#![allow(unsafe_code, reason = "an allocator that counts can only be written so")]

use chiaro_mincut::{Family, Grid, solve};
use std::alloc::{GlobalAlloc, Layout, System};
use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Instant;

/// The system's allocator, counting.
struct Counting;

static LIVE: AtomicUsize = AtomicUsize::new(0);
static PEAK: AtomicUsize = AtomicUsize::new(0);

// Safety: every call is handed on as it came.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        let live = LIVE.fetch_add(layout.size(), Ordering::Relaxed) + layout.size();
        PEAK.fetch_max(live, Ordering::Relaxed);
        unsafe { System.alloc(layout) }
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        let live = LIVE.fetch_add(layout.size(), Ordering::Relaxed) + layout.size();
        PEAK.fetch_max(live, Ordering::Relaxed);
        unsafe { System.alloc_zeroed(layout) }
    }

    unsafe fn dealloc(&self, memory: *mut u8, layout: Layout) {
        LIVE.fetch_sub(layout.size(), Ordering::Relaxed);
        unsafe { System.dealloc(memory, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

fn main() {
    let words: Vec<String> = std::env::args().skip(1).filter(|a| !a.starts_with('-')).collect();
    for folder in words.iter().filter(|w| *w != "family") {
        report(Path::new(folder), words.iter().any(|w| w == "family"));
    }
}

/// Times one graph.
fn report(folder: &Path, family: bool) {
    let (terminal, shape) = read(&folder.join("terminal.npy"), 4);
    let (neighbour, _) = read(&folder.join("neighbour.npy"), 4);
    let (mask, _) = read(&folder.join("mask.npy"), 1);
    let (labels, _) = read(&folder.join("labels.npy"), 1);
    let mask: Vec<bool> = mask.iter().map(|&m| m != 0).collect();
    let grid = Grid {
        width: shape[1],
        height: shape[0],
        mask: &mask,
        terminal: terminal.as_chunks().0,
        neighbour: neighbour.as_chunks().0,
    };
    let pixels = mask.len();
    let before = LIVE.load(Ordering::Relaxed);
    PEAK.store(before, Ordering::Relaxed);
    let mut best = f64::INFINITY;
    let mut cut = None;
    for _ in 0..(8_000_000 / pixels.max(1)).clamp(3, 15) {
        drop(cut.take());
        let start = Instant::now();
        cut = Some(solve(&grid).expect("a dumped graph keeps to the bounds"));
        best = best.min(start.elapsed().as_secs_f64());
    }
    let cut = cut.expect("it ran");
    let peak = PEAK.load(Ordering::Relaxed) - before;
    let same = cut.labels.iter().zip(&labels).all(|(&a, &b)| a == (b != 0));
    println!(
        "{} pixels {pixels} ns {:.1} bytes {:.1} flow {} labels {}",
        folder.display(),
        best * 1e9 / pixels as f64,
        peak as f64 / pixels as f64,
        cut.flow,
        if same { "same" } else { "other" }
    );
    if family {
        let start = Instant::now();
        let family = Family::new(&grid, -2048..=2047).expect("a dumped graph keeps to the bounds");
        let seconds = start.elapsed().as_secs_f64();
        assert_eq!(family.labels(0), cut.labels, "the member without a shift");
        println!("  4096 shifts {seconds:.3} s, as {:.1} cuts", seconds / best);
    }
}

/// The integers of an NPY file, `bytes` each, and its shape.
fn read(path: &Path, bytes: usize) -> (Vec<i32>, Vec<usize>) {
    let file = std::fs::read(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    let length = usize::from(u16::from_le_bytes([file[8], file[9]])) + 10;
    let header = String::from_utf8_lossy(&file[10..length]).into_owned();
    let shape = header.split(['(', ')']).nth(1).expect("an NPY file has a shape");
    let shape = shape.split(',').filter_map(|n| n.trim().parse().ok()).collect();
    let value = |b: &[u8]| b.iter().rev().fold(0, |v, &b| v << 8 | i32::from(b));
    (file[length..].chunks_exact(bytes).map(value).collect(), shape)
}
