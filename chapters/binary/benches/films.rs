//! Row B7 on any scene: flicker of the film's labels against that of each frame's own, and the time
//! of a frame's cut.
//!
//! `cargo bench -p chiaro-binary --bench films -- SCENE [FRAMES] [knob=value...]` makes short films
//! of a turning camera, of the scene's own animation, and of a light that turns, 360 pixels a side,
//! and labels each with the knobs given, every `knob=value` in a row of its own beside the defaults
//! (several joined by commas go into one row). `turning`, `playing` or `'moving light'` among the
//! arguments makes that film alone.
//!
//! Films are compared with the frames' own pictures, which have round borders and no small islands
//! either; first come the reversals that the tone does not make itself.

#![allow(clippy::print_stdout)]

use chiaro_basis::math::Quat;
use chiaro_basis::{Error, Knobs, Result, Run};
use chiaro_binary::{
    BLOCK, BinaryKnobs, Cel, Channels, Film, Flicker, Lit, Plan, Shown, View, Weights, expose,
    weigh,
};
use chiaro_image::Plane;
use chiaro_scene::load::{Budget, Door, Source, Up, read_scene};
use chiaro_scene::{Choice, Frame, Pose, Poser, Scene, demo};
use chiaro_trace::{GBuffer, Lamp, Lamps, Match, Surfaces, Tracer, UNLINKED, links, view};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;

const SIDE: usize = 360;

struct Folder(PathBuf);

impl Source for Folder {
    fn read(&self, path: &str, _: u64) -> Result<Vec<u8>> {
        std::fs::read(self.0.join(path)).map_err(|e| Error::input(path, "", e.to_string()))
    }
}

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).filter(|a| a != "--bench").collect();
    let name = arguments.first().map_or("demo:head", String::as_str);
    let count = arguments.iter().filter_map(|a| a.parse().ok()).next().unwrap_or(32);
    let rows: Vec<&String> = arguments.iter().filter(|a| a.contains('=')).collect();
    let scene = open(name);
    let motions = ["turning", "playing", "moving light"];
    let is_named = |motion: &str| arguments.iter().any(|a| a == motion);
    let all = !motions.iter().any(|m| is_named(m));
    for motion in motions.into_iter().filter(|m| all || is_named(m)) {
        let takes = Takes::of(&scene, motion, count);
        takes.report(motion, "defaults");
        rows.iter().for_each(|row| takes.report(motion, row));
    }
}

fn open(name: &str) -> Scene {
    if let Some(name) = name.strip_prefix("demo:") {
        return demo::scene(name).expect("a demo scene");
    }
    let path = Path::new(name);
    let bytes = std::fs::read(path).expect("a scene that can be read");
    let folder = Folder(path.parent().unwrap_or(Path::new(".")).to_path_buf());
    let mut door = Door::new(name, &folder, Budget::default());
    read_scene(name, &bytes, Up::Auto, &mut door).expect("a scene")
}

/// A film's frames with their graphs by the default weights, and the links of the measures.
struct Takes(Vec<(Arc<Cel>, Plane<u32>)>);

struct Shared(Arc<Cel>);

impl AsRef<Cel> for Shared {
    fn as_ref(&self) -> &Cel {
        &self.0
    }
}

impl Takes {
    fn of(scene: &Scene, motion: &str, count: usize) -> Self {
        let (knobs, run) = (BinaryKnobs::default(), Run::default());
        let playback = scene.playback(&Choice::Auto).expect("clips").0;
        let poser = Poser::new(scene);
        let surfaces = Surfaces::new(scene);
        let time = |i: usize| {
            if motion == "turning" { 0.0 } else { playback.time(scene, i as u32 + 1, 24.0, true) }
        };
        let frames: Vec<Frame> = (0..count).map(|i| poser.frame(time(i), &playback)).collect();
        let framing = view::Framing::of(&Tracer::new(scene, &frames[0]), &frames[..1]);
        let start = framing.view(1.0, 0.0).0;
        let centre = framing.bounds.centre();
        let pose = |i: usize| {
            let turn = if motion == "turning" { i as f32 / 120.0 } else { 0.0 };
            let turn = Quat::from_rotation_y(turn * std::f32::consts::TAU);
            Pose {
                position: centre + turn * (start.position - centre),
                right: turn * start.right,
                up: turn * start.up,
                forward: turn * start.forward,
                ..start
            }
        };
        let seen = |i: usize| {
            let tracer = Tracer::new(scene, &frames[i]);
            let buffer = GBuffer::trace(&tracer, &surfaces, &pose(i), (SIDE, SIDE), &run);
            let buffer = buffer.expect("no cancel");
            let mut lamp = Lamp::key(&start);
            if motion == "moving light" {
                lamp.direction =
                    Quat::from_rotation_y(i as f32 * 2.5f32.to_radians()) * lamp.direction;
            }
            let lamps = Lamps::of(vec![lamp]);
            let lit = Lit { tracer: &tracer, surfaces: &surfaces, buffer: &buffer, lamps: &lamps };
            let channels = Channels::render(&lit, |c| c.is_used(&knobs), &knobs, true, &run);
            View { channels: channels.expect("no cancel"), buffer }
        };
        let survey: Vec<View> = (0..5).map(|i| seen(i * count / 5)).collect();
        let exposure = expose(&survey, true, &knobs, &run).expect("no cancel");
        let mut before: Option<GBuffer> = None;
        let takes = (0..count).map(|i| {
            let view = seen(i);
            let Weights { graph, .. } = weigh(&view, &exposure, &knobs, &run).expect("no cancel");
            let linked = |rule| match &before {
                Some(b) => links(&view.buffer, b, scene, (&frames[i], &frames[i - 1]), rule),
                None => graph.mask.map(|_| UNLINKED),
            };
            let (close, sight) = (linked(Match::Plane(2.0)), linked(Match::Depth(0.02)));
            before = Some(view.buffer);
            (Arc::new(Cel::new(graph, close).expect("weights are small")), sight)
        });
        Self(takes.collect())
    }

    /// Labels the film by a row of knobs and prints its measures.
    fn report(&self, motion: &str, row: &str) {
        let mut knobs = BinaryKnobs::default();
        for set in row.split(',').filter(|s| s.contains('=')) {
            let (name, value) = set.split_once('=').expect("checked");
            knobs.set(name, value).expect("a knob");
        }
        // The film and the frames' own pictures behind the frames' cuts, and the film behind the pictures.
        let mut sums = [Flicker::default(), Flicker::default(), Flicker::default()];
        let start = Instant::now();
        let labels = self.labelled(&knobs);
        let seconds = start.elapsed().as_secs_f64();
        for (i, ((cel, sight), labels)) in self.0.iter().zip(&labels).enumerate() {
            let (alone, cut) = cel.own(0);
            let own = cel.finished(0, &knobs).expect("weights are small");
            let pairs = [(labels, alone), (&own, alone), (labels, &own)];
            for (sum, (labels, alone)) in sums.iter_mut().zip(pairs) {
                let shown = Shown {
                    labels,
                    covered: &cel.graph.mask,
                    links: sight,
                    alone,
                    tone: &cel.wanted(0),
                    energy: [cel.energy(0, labels), cut],
                };
                sum.add(i, &shown);
            }
        }
        let [film, alone, behind] = &sums;
        let ratio = |of: fn(&Flicker) -> f64| of(film) / of(alone).max(1e-12);
        println!(
            "{motion:<13} {row:<28} reversals x {:.2} ({:.1e} of {:.1e}; with the tone's own, {:.1e} of {:.1e}, x {:.2}), energy over the frames' pictures +{:.2} % (over their cuts +{:.2} %, of it round borders and islands +{:.2} %), lag {:.2} px behind their cuts ({:.2} behind their pictures, which are {:.2} behind the cuts), pops {} of {} px, {:.0} ms a frame",
            ratio(Flicker::flicker_per_pixel),
            film.flicker_per_pixel(),
            alone.flicker_per_pixel(),
            film.tone_reversals_per_pixel(),
            alone.tone_reversals_per_pixel(),
            ratio(Flicker::reversals_per_pixel),
            100.0 * ((1.0 + film.energy_excess()) / (1.0 + alone.energy_excess()) - 1.0),
            100.0 * film.energy_excess(),
            100.0 * alone.energy_excess(),
            film.lag_px(),
            behind.lag_px(),
            alone.lag_px(),
            film.pop_p99(),
            alone.pop_p99(),
            1e3 * seconds / self.0.len() as f64,
        );
    }

    fn labelled(&self, knobs: &BinaryKnobs) -> Vec<Plane<u8>> {
        let plan = Plan { frames: self.0.len(), window: knobs.window as usize };
        let mut film: Film<'_, Shared> = Film::new(plan, knobs);
        let mut out = Vec::new();
        for start in (0..plan.frames).step_by(BLOCK) {
            let mut fetch = |i: usize| Ok(Shared(self.0[i].0.clone()));
            let mut done = |_: usize, _: &Shared, labels: &[Plane<u8>]| {
                out.push(labels[0].clone());
                Ok(())
            };
            film.label(&plan.block(start), &mut fetch, &mut done, &Run::default())
                .expect("nobody cancels");
        }
        out
    }
}
