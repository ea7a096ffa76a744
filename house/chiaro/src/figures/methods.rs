//! All ways to parameterize lines, measured alike: a table, and slide over stretch as curves.

use super::chapter4::{BLACK, Colour, RED};
use super::chart::{Axis, Chart, Scale, Series};
use crate::lines::camera;
use crate::project::{Options, Project};
use chiaro_basis::math::{Quat, Vec3};
use chiaro_basis::{Result, Run};
use chiaro_image::Plane;
use chiaro_image::sheet::Sheet;
use chiaro_lines::parameter::{Parameters, Solved, Weights, parameterize};
use chiaro_lines::{Cuts, Film, LinesKnobs, Method, Quality, Reel, View, measure, quality};
use chiaro_scene::Pose;
use serde_json::{Map, Value};
use std::time::Instant;

/// Scenes when none is named.
pub(super) const SCENES: [&str; 7] = [
    "demo:bumpy-torus",
    "demo:peanut",
    "demo:multipod",
    "demo:head",
    "demo:desk",
    "demo:bowl",
    "demo:cactus",
];

const SIZE: (usize, usize) = (960, 540);
const FRAMES: u32 = 48;
const DEGREES: f32 = 1.5;
const PLOT: (usize, usize) = (640, 480);
/// The least slide that is shown, pixels, and the greatest stretch, octaves.
const LEAST: f64 = 0.05;
const WIDEST: f64 = 0.6;
const BLUE: Colour = [0.1, 0.3, 0.8];
const GREEN: Colour = [0.1, 0.55, 0.2];
/// Ways to cut, beside the default's red.
const CUTS: [Colour; 4] =
    [[0.95, 0.55, 0.1], [0.6, 0.2, 0.6], [0.55, 0.35, 0.15], [0.95, 0.45, 0.7]];

/// A row of the table.
struct Row {
    name: &'static str,
    colour: Colour,
    solved: Solved,
    quality: Quality,
    film: Film,
    seconds: f64,
}

/// Draws a plot a scene, and answers the rows of the table.
pub(super) fn methods(sheet: &mut Sheet, scenes: &[String], run: &Run) -> Result<Vec<Value>> {
    let mut values = Vec::new();
    for scene in scenes {
        run.check()?;
        let start = Instant::now();
        let found = found(scene, run)?;
        let found_seconds = start.elapsed().as_secs_f64();
        let spacing = vec![1.0 / 24.0; found.frames.len()];
        let mut rows = Vec::new();
        for (name, colour, method, cuts) in [
            ("global", RED, Method::Global, Cuts::Auto),
            ("global, cut at both", CUTS[0], Method::Global, Cuts::Both),
            ("global, links cut", CUTS[1], Method::Global, Cuts::Links),
            ("global, cut at events", CUTS[2], Method::Global, Cuts::Events),
            ("the same, unpaired", CUTS[3], Method::Global, Cuts::Unpaired),
            ("propagation", BLUE, Method::Propagate, Cuts::Charts),
            ("diffusion", GREEN, Method::Diffuse, Cuts::Charts),
            ("arc length", BLACK, Method::Arclength, Cuts::Charts),
        ] {
            let knobs = LinesKnobs { method, cuts, ..LinesKnobs::default() };
            let mut film = found.clone();
            let start = Instant::now();
            let solved = parameterize(&mut film, &spacing, &knobs, run)?;
            let seconds = start.elapsed().as_secs_f64();
            rows.push(Row { name, colour, solved, quality: quality(&film), film, seconds });
        }
        let (curve, again) = curve(&found, &spacing, run)?;
        sheet.add(plot(&rows, &curve), caption(scene, &rows, again));
        values.extend(rows.iter().map(|row| value(scene, row, found_seconds)));
        values.extend(curve.iter().map(|(c, q)| point(scene, *c, q)));
    }
    Ok(values)
}

/// A scene's tracked lines; about scenes that stand still the camera turns, 1.5 degrees a frame.
fn found(scene: &str, run: &Run) -> Result<Film> {
    let frames = Some((1..=FRAMES).collect());
    let options = Options { size: Some(SIZE), frames, ..Options::default() };
    let project = Project::open(scene, options, run)?;
    let camera = camera(&project, run)?;
    let poser = project.poser();
    let still = project.scene.clips.is_empty();
    let at = |i: usize| {
        let number = i as u32 + 1;
        let frame = poser.frame(project.time(number), &project.playback);
        let pose = camera.pose(&frame, number);
        let turn = if still { DEGREES.to_radians() * i as f32 } else { 0.0 };
        let centre = frame.bounds().centre();
        (frame, View::new(about(pose, centre, turn), camera.size))
    };
    let reel = Reel { scene: &project.scene, count: FRAMES as usize, at: &at };
    Film::of(&reel, &LinesKnobs::default(), run)
}

fn about(pose: Pose, centre: Vec3, angle: f32) -> Pose {
    let q = Quat::from_rotation_y(angle);
    Pose {
        position: centre + q * (pose.position - centre),
        right: q * pose.right,
        up: q * pose.up,
        forward: q * pose.forward,
        ..pose
    }
}

/// Quality over the control, and the seconds that one more position of it takes.
fn curve(found: &Film, spacing: &[f64], run: &Run) -> Result<(Vec<(f32, Quality)>, f64)> {
    let mut film = found.clone();
    let parameters = Parameters::new(&mut film, spacing, &LinesKnobs::default(), run)?;
    let mut points = Vec::new();
    let mut least = f64::INFINITY;
    for step in 0..=10 {
        let coherence = step as f32 / 10.0;
        let weights = Weights::of(&LinesKnobs { coherence, ..LinesKnobs::default() });
        let start = Instant::now();
        parameters.write(&mut film, &weights)?;
        least = least.min(start.elapsed().as_secs_f64());
        points.push((coherence, quality(&film)));
    }
    Ok((points, least))
}

/// Stretch and slide, as the plot shows them.
fn place(q: &Quality) -> [f64; 2] {
    // A pattern that runs backwards on more than a hundredth of its lines has no stretch to speak of.
    let stretch = if q.folded > 0.01 { WIDEST } else { q.stretch_p95.min(WIDEST) };
    [stretch, q.slide_p95.max(LEAST)]
}

/// Slide upwards (logarithmic), stretch to the right.
fn plot(rows: &[Row], curve: &[(f32, Quality)]) -> Plane<[u8; 3]> {
    let points = curve.iter().map(|(_, q)| place(q)).collect();
    let name = "global, coherence from 0 to 1".into();
    let control = Series { name, colour: RED, points, joined: true };
    let of_row = |row: &Row| {
        let (name, points) = (row.name.to_owned(), vec![place(&row.quality)]);
        Series { name, colour: row.colour, points, joined: false }
    };
    let series = std::iter::once(control).chain(rows.iter().map(of_row)).collect();
    let x = Axis { name: "stretch, 95th percentile, octaves", scale: Scale::Linear };
    let y = Axis { name: "slide, 95th percentile, pixels", scale: Scale::Log };
    Chart { x, y, series }.draw(PLOT)
}

fn caption(scene: &str, rows: &[Row], again: f64) -> String {
    let name = scene.rsplit(['/', ':']).next().unwrap_or(scene);
    let one = |row: &Row| format!("{} {:.2} px", row.name, row.quality.slide_p95);
    let main = rows.iter().filter(|r| !r.name.contains("cut") && !r.name.contains("same"));
    let all: Vec<String> = main.map(one).collect();
    format!("{name}: {}; control {:.0} ms", all.join(", "), 1e3 * again)
}

fn value(scene: &str, row: &Row, found_seconds: f64) -> Value {
    let mut map = Map::new();
    map.insert("scene".into(), scene.into());
    map.insert("method".into(), row.name.into());
    for (name, number) in row.quality.named() {
        map.insert(name.into(), number.into());
    }
    let m = measure(&row.film);
    map.insert("strokes".into(), m.strokes.into());
    map.insert("strokes_per_frame".into(), m.strokes_per_frame.into());
    map.insert("mean_life_frames".into(), m.mean_life_frames.into());
    map.insert("one_to_one_share".into(), m.one_to_one.into());
    map.insert("unknowns".into(), row.solved.unknowns.into());
    map.insert("links".into(), row.solved.links.into());
    map.insert("cut_links".into(), row.solved.cut.into());
    map.insert("charts".into(), row.solved.charts.into());
    if let Some(saved) = row.solved.saved {
        map.insert("mergers_and_splits".into(), saved.events.iter().sum::<usize>().into());
        map.insert("paired".into(), saved.paired.into());
        map.insert("cut_places".into(), saved.cut_places.into());
    }
    // Load, visibility and tracking, once for all methods; then what the method takes.
    map.insert("find_seconds".into(), found_seconds.into());
    map.insert("solve_seconds".into(), row.seconds.into());
    Value::Object(map)
}

fn point(scene: &str, coherence: f32, q: &Quality) -> Value {
    let mut map = Map::new();
    map.insert("scene".into(), scene.into());
    map.insert("coherence".into(), f64::from(coherence).into());
    for (name, number) in q.named() {
        map.insert(name.into(), number.into());
    }
    Value::Object(map)
}
