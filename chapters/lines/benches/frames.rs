//! Seconds a frame by stage, and the measures of identity: rows L4, L5 and L7.
//!
//! `cargo bench -p chiaro-lines` runs all; a name runs one: bumpy-torus (40k triangles), head,
//! sphere-field (512k). `--frames N` sets the length of the film.

#![allow(clippy::print_stdout)]

use chiaro_basis::math::{Quat, Vec3};
use chiaro_basis::{Cancel, Observer, Run};
use chiaro_lines::{Film, LinesKnobs, Reel, View, measure};
use chiaro_scene::{Choice, Pose, Poser, Projection, demo};
use std::collections::BTreeMap;
use std::sync::{Arc, Mutex};
use std::time::Instant;

/// What is done once a shot: the surface, its lines that are edges, the last of identity.
const ONCE: &str = "once";

/// Sums the seconds of each stage.
#[derive(Default)]
struct Clock(Mutex<Times>);

#[derive(Default)]
struct Times {
    seconds: BTreeMap<&'static str, f64>,
    running: Vec<(&'static str, Instant)>,
}

impl Observer for Clock {
    fn begin(&self, stage: &'static str, items: u64) {
        // What counts no frames is done once a shot.
        let stage = if items == 0 { ONCE } else { stage };
        let mut state = self.0.lock().expect("nobody panics with the clock");
        state.running.push((stage, Instant::now()));
    }

    fn end(&self, _stage: &'static str) {
        let mut state = self.0.lock().expect("nobody panics with the clock");
        if let Some((stage, start)) = state.running.pop() {
            *state.seconds.entry(stage).or_insert(0.0) += start.elapsed().as_secs_f64();
        }
    }
}

fn main() {
    let words: Vec<String> = std::env::args().skip(1).filter(|a| a != "--bench").collect();
    let after = |word: &str| words.iter().position(|w| w == word).and_then(|i| words.get(i + 1));
    let frames = after("--frames").and_then(|n| n.parse().ok()).unwrap_or(48);
    let all = ["bumpy-torus", "head", "sphere-field"];
    let named: Vec<&str> = all.into_iter().filter(|n| words.iter().any(|w| w == n)).collect();
    for name in if named.is_empty() { &all[..] } else { &named } {
        film(name, if *name == "sphere-field" { frames.min(4) } else { frames });
    }
}

fn film(name: &str, frames: usize) {
    let scene = demo::scene(name).expect("the scene is there");
    let (playback, _) = scene.playback(&Choice::Auto).expect("clips play together");
    let poser = Poser::new(&scene);
    let bounds = poser.frame(0.0, &playback).bounds();
    let at = |i: usize| {
        let frame = poser.frame(i as f64 / 24.0, &playback);
        // Scenes that stand still are turned before the camera.
        let turn = if scene.clips.is_empty() { 1.5f32.to_radians() * i as f32 } else { 0.0 };
        let away = Quat::from_rotation_y(turn) * Vec3::new(1.0, 0.6, 2.0).normalize();
        let from = bounds.centre() + away * 3.6 * bounds.radius();
        let projection = Projection::Perspective { fov_y: 0.6 };
        let pose = Pose::look_at(from, bounds.centre(), Vec3::Y, projection);
        (frame, View::new(pose, (960, 540)))
    };
    let clock = Arc::new(Clock::default());
    let run = Run::new(Cancel::default(), clock.clone());
    let reel = Reel { scene: &scene, count: frames, at: &at };
    let film = Film::of(&reel, &LinesKnobs::default(), &run).expect("nothing stops it");
    let triangles = film.surface.as_ref().map_or(0, |g| g.surface.real_faces);
    println!(
        "{name}: {triangles} triangles, {frames} frames, {} threads",
        rayon::current_num_threads()
    );
    for (stage, seconds) in &clock.0.lock().expect("nobody panics with the clock").seconds {
        match *stage {
            ONCE => println!("  {stage:<8} {:.2} ms", 1e3 * seconds),
            _ => println!("  {stage:<8} {:.2} ms a frame", 1e3 * seconds / frames as f64),
        }
    }
    for (measure, value) in measure(&film).named() {
        println!("  {measure:<24} {value:.4}");
    }
}
