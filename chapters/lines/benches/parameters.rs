//! Sliding, stretch, folds and seconds of every method: rows L1 to L3.
//!
//! `cargo bench -p chiaro-lines --bench parameters` runs all methods on all scenes; names choose scenes
//! (bumpy-torus, peanut, head, and so on; `cactus --frames 240 --global` is a long film of a skinned
//! character of 100k triangles), `--degrees 6` how fast scenes that stand still are turned, `--frames N`
//! the length, `--set key=value` any knob, `--global` leaves the other methods out, `--coherence` a row
//! for each of its values, `--live` the frames a second of the interactive variant (row L8) instead.
//!
//! The thesis's timing, 20 000 vertices over 100 frames in 5 s, is `bumpy-torus --frames 100`: 0.6 s on
//! two cores, links and cuts included.

#![allow(clippy::print_stdout)]
#![allow(unsafe_code, reason = "an allocator that counts can only be written so")]

use chiaro_basis::math::{Quat, Vec3};
use chiaro_basis::{Knobs, Run};
use chiaro_lines::parameter::{Live, Parameters, Weights, parameterize};
use chiaro_lines::{Film, Ground, LinesKnobs, Method, Posed, Reel, View, measure, quality};
use chiaro_scene::{Bounds, Choice, Pose, Poser, Projection, demo};
use std::alloc::{GlobalAlloc, Layout, System};
use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};
use std::time::Instant;

/// Scenes when none is named.
const SCENES: [&str; 10] = [
    "bumpy-torus",
    "torus",
    "peanut",
    "golf-ball",
    "multipod",
    "metaballs",
    "head",
    "desk",
    "bowl",
    "cactus",
];

/// Counts the bytes that live, and the most that ever did.
struct Counting;

static LIVE: AtomicUsize = AtomicUsize::new(0);
static MOST: AtomicUsize = AtomicUsize::new(0);

// SAFETY: everything is handed on to the system's allocator as it is.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        let live = LIVE.fetch_add(layout.size(), Relaxed) + layout.size();
        MOST.fetch_max(live, Relaxed);
        // SAFETY: the layout is the caller's.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, at: *mut u8, layout: Layout) {
        LIVE.fetch_sub(layout.size(), Relaxed);
        // SAFETY: it came from `alloc` with this layout.
        unsafe { System.dealloc(at, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

fn main() {
    let words: Vec<String> = std::env::args().skip(1).filter(|a| a != "--bench").collect();
    let after = |word: &str| words.iter().position(|w| w == word).and_then(|i| words.get(i + 1));
    let number = |word: &str, or: f32| after(word).and_then(|n| n.parse().ok()).unwrap_or(or);
    let named: Vec<&str> =
        words.iter().map(String::as_str).filter(|w| demo::names().contains(w)).collect();
    let mut knobs = LinesKnobs::default();
    for pair in words.windows(2).filter(|p| p[0] == "--set") {
        let (key, value) = pair[1].split_once('=').expect("--set takes key=value");
        knobs.set(key, value).expect("the knob is known");
    }
    let frames = number("--frames", 48.0) as usize;
    let curve = words.iter().any(|w| w == "--coherence");
    if words.iter().any(|w| w == "--live") {
        return named.iter().for_each(|name| live(name, &knobs));
    }
    for name in if named.is_empty() { SCENES.to_vec() } else { named } {
        let found = film(name, frames, number("--degrees", 1.5), &knobs);
        if curve { coherence(&found, &knobs) } else { methods(&found, &knobs) }
    }
}

fn film(name: &str, frames: usize, degrees: f32, knobs: &LinesKnobs) -> Film {
    let scene = demo::scene(name).expect("the scene is there");
    let (playback, _) = scene.playback(&Choice::Auto).expect("clips play together");
    let poser = Poser::new(&scene);
    let bounds = poser.frame(0.0, &playback).bounds();
    let still = scene.clips.is_empty() || degrees != 1.5;
    let at = |i: usize| {
        let frame = poser.frame(if still { 0.0 } else { i as f64 / 24.0 }, &playback);
        let turn = if still { degrees.to_radians() * i as f32 } else { 0.0 };
        let away = Quat::from_rotation_y(turn) * Vec3::new(1.0, 0.6, 2.0).normalize();
        let from = bounds.centre() + away * 3.6 * bounds.radius();
        let projection = Projection::Perspective { fov_y: 0.6 };
        let pose = Pose::look_at(from, bounds.centre(), Vec3::Y, projection);
        (frame, View::new(pose, (960, 540)))
    };
    let reel = Reel { scene: &scene, count: frames, at: &at };
    let before = LIVE.load(Relaxed);
    MOST.store(before, Relaxed);
    let start = Instant::now();
    let film = Film::of(&reel, knobs, &Run::default()).expect("nothing stops it");
    let seconds = start.elapsed().as_secs_f64();
    let triangles = film.surface.as_ref().map_or(0, |g| g.surface.real_faces);
    let most = MOST.load(Relaxed) - before;
    println!(
        "{name}, {frames} frames, {triangles} triangles: lines found in {seconds:.1} s with {:.0} MB, {:.0} MB of them kept",
        most as f64 / 1e6,
        (LIVE.load(Relaxed) - before) as f64 / 1e6,
    );
    film
}

/// Frames a second before a camera that turns, lines and diffusion each.
fn live(name: &str, knobs: &LinesKnobs) {
    let scene = demo::scene(name).expect("the scene is there");
    let (playback, _) = scene.playback(&Choice::Auto).expect("clips play together");
    let frame = Poser::new(&scene).frame(0.0, &playback);
    let bounds = frame.bounds();
    let ground = Ground::of(&scene, &frame, knobs, &[]);
    let posed = Posed::new(&ground.surface, &frame, knobs.smooth_normals);
    for (how, live) in
        [("exact", Live::new(&ground, knobs)), ("depth buffer", Live::quick(&ground, knobs))]
    {
        turn(name, how, live, (&ground, &posed, &bounds));
    }
}

fn turn(
    name: &str,
    how: &str,
    mut live: Live<'_>,
    (ground, posed, bounds): (&Ground, &Posed, &Bounds),
) {
    let (mut all, mut strokes, mut length) = (Vec::new(), 0, 0.0);
    for i in 0..24 {
        let away = Quat::from_rotation_y(0.026 * i as f32) * Vec3::new(1.0, 0.6, 2.0).normalize();
        let from = bounds.centre() + away * 3.6 * bounds.radius();
        let projection = Projection::Perspective { fov_y: 0.6 };
        let pose = Pose::look_at(from, bounds.centre(), Vec3::Y, projection);
        let start = Instant::now();
        let found = live.frame(posed, &View::new(pose, (960, 540)));
        all.push(start.elapsed().as_secs_f64());
        (strokes, length) = (found.len(), found.iter().map(|s| s.total()).sum());
    }
    all.sort_by(f64::total_cmp);
    println!(
        "{name}, {how}: {} triangles, {strokes} strokes of {length:.0} px, {:.1} ms a frame ({:.1} fps), at best {:.1} ms",
        ground.surface.real_faces,
        1e3 * all[12],
        all[12].recip(),
        1e3 * all[0],
    );
}

fn methods(found: &Film, knobs: &LinesKnobs) {
    println!(
        "  {:<10} {:>8} {:>7} {:>7} {:>7} {:>7} {:>6} {:>6} {:>8} {:>7} {:>6} {:>6} {:>6} {:>7} {:>6} {:>6} {:>7} {:>6}",
        "method",
        "slide",
        "over 2",
        "jumps",
        "texture",
        "own",
        "pops",
        "gaps",
        "stretch",
        "folded",
        "folds",
        "mended",
        "cut",
        "strokes",
        "life",
        "1 to 1",
        "ms",
        "MB"
    );
    let methods = [Method::Global, Method::Propagate, Method::Diffuse, Method::Arclength];
    let only = std::env::args().any(|word| word == "--global");
    for method in methods.into_iter().take(if only { 1 } else { 4 }) {
        let mut film = found.clone();
        let before = LIVE.load(Relaxed);
        MOST.store(before, Relaxed);
        let start = Instant::now();
        let knobs = LinesKnobs { method, ..knobs.clone() };
        let solved = parameterize(&mut film, &[], &knobs, &Run::default()).expect("it is solved");
        let seconds = start.elapsed().as_secs_f64();
        let bytes = MOST.load(Relaxed) - before;
        let (q, m) = (quality(&film), measure(&film));
        println!(
            "  {:<10} {:>8.3} {:>6.2}% {:>6.2}% {:>6.2}% {:>6.2}% {:>6.1} {:>6.1} {:>8.3} {:>6.2}% {:>6} {:>6} {:>5.2}% {:>7} {:>6.1} {:>6.4} {:>7.1} {:>6.1}",
            format!("{method:?}"),
            q.slide_p95,
            100.0 * q.slide_over_2,
            100.0 * q.jumps,
            100.0 * q.texture_jumps,
            100.0 * q.line_jumps,
            q.ink_pop_p99,
            q.gap_p95,
            q.stretch_p95,
            100.0 * q.folded,
            q.folds,
            solved.mended,
            100.0 * solved.cut as f64 / solved.links.max(1) as f64,
            m.strokes,
            m.mean_life_frames,
            m.one_to_one,
            1e3 * seconds,
            bytes as f64 / 1e6,
        );
    }
}

/// Slide and stretch together over the control.
fn coherence(found: &Film, knobs: &LinesKnobs) {
    let mut film = found.clone();
    let start = Instant::now();
    let parameters = Parameters::new(&mut film, &[], knobs, &Run::default()).expect("it is solved");
    println!("  links, cuts, pattern: {:.0} ms", 1e3 * start.elapsed().as_secs_f64());
    println!("  coherence    slide   over 2  stretch  folds   ms");
    for step in 0..=10 {
        let coherence = step as f32 / 10.0;
        let weights = Weights::of(&LinesKnobs { coherence, ..knobs.clone() });
        let start = Instant::now();
        parameters.write(&mut film, &weights).expect("it is solved");
        let seconds = start.elapsed().as_secs_f64();
        let q = quality(&film);
        println!(
            "  {coherence:>9.1} {:>8.3} {:>7.2}% {:>8.3} {:>6} {:>4.0}",
            q.slide_p95,
            100.0 * q.slide_over_2,
            q.stretch_p95,
            q.folds,
            1e3 * seconds
        );
    }
}
