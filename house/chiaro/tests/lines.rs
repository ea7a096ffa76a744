//! The lines of every animated file of the data, where it is there: silhouettes of closed meshes are
//! closed, chains of others end on borders, S has its Euler characteristic, and slices that S reaches
//! are those that the frames show. No line of them, nor of scenes in code, is drawn twice.

use chiaro::{Options, Project};
use chiaro_basis::Run;
use chiaro_basis::math::{Quat, Vec3, vec3};
use chiaro_lines::{
    CreaseRule, Crossing, Detail, Film, LinesKnobs, Posed, Reel, Slice, Stroke, Surface, View,
    overlap, track,
};
use chiaro_scene::{Pose, Projection};
use std::path::{Path, PathBuf};

/// Scene files below a folder, in order.
fn files(folder: &Path, found: &mut Vec<PathBuf>) {
    let Ok(entries) = std::fs::read_dir(folder) else { return };
    let mut paths: Vec<PathBuf> = entries.flatten().map(|e| e.path()).collect();
    paths.sort();
    for path in paths {
        if path.is_dir() {
            files(&path, found);
        } else if path.extension().is_some_and(|e| e == "gltf" || e == "glb") {
            found.push(path);
        }
    }
}

#[test]
fn silhouettes_of_real_animations_are_closed_and_s_is_a_surface() {
    let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data/anim");
    let mut found = Vec::new();
    files(&data, &mut found);
    if found.is_empty() {
        return println!("skipped: ../shared/data/anim is absent");
    }
    for file in found {
        for degrees in [0.0, 4.0] {
            follow(&file, degrees);
        }
    }
}

/// Follows a second of a file, the camera turning around it by so many degrees a frame.
fn follow(file: &Path, degrees: f32) {
    let name = file.display();
    let run = Run::default();
    let project = Project::open(&file.to_string_lossy(), Options::default(), &run)
        .expect("the data's files open");
    let poser = project.poser();
    let frame = |i: u32| poser.frame(f64::from(i) / 24.0, &project.playback);
    let rule = CreaseRule { angle: 0.7, smooth_angle: 1.3 };
    // Every other shape refined and with its facets, so that all kinds are followed.
    let detail = |i: usize| Detail { levels: (i % 2) as u8, facets: i % 4 < 2 };
    let details: Vec<Detail> = (0..frame(0).shapes.len()).map(detail).collect();
    let surface = Surface::refined(&project.scene, &frame(0), &rule, &details);
    let bounds = frame(0).bounds();
    let mut before: Option<(Vec<f64>, Slice)> = None;
    let mut kinetic: Option<track::Kinetic<'_>> = None;
    for i in 0..24 {
        let turn = Quat::from_rotation_y(degrees.to_radians() * i as f32);
        let away = turn * vec3(1.0, 0.4, 1.7) * 2.0 * bounds.radius();
        let projection = Projection::Perspective { fov_y: 0.6 };
        let pose = Pose::look_at(bounds.centre() + away, bounds.centre(), Vec3::Y, projection);
        let posed = Posed::new(&surface, &frame(i), 0);
        let g = posed.facing(&View::new(pose, (320, 240)));
        let slice = Slice::of(&surface, &g);
        for chain in &slice.chains {
            let c: &[Crossing] = chain.of(&slice);
            let ends = [c[0], c[c.len() - 1]];
            let on_border = ends.iter().all(|e| surface.is_border(e.edge));
            assert!(chain.closed || on_border, "{name}, frame {i}: a chain ends in the surface");
        }
        if let (Some((old, old_slice)), Some(k)) = (&before, &mut kinetic) {
            let interval = k.step(old, &g, [old_slice, &slice], track::Order::Time);
            let sides: Vec<bool> = g.iter().map(|v| *v >= 0.0).collect();
            assert!(k.sides() == sides, "{name}, frame {i}: S leads to another slice");
            let closed = surface.mate.iter().all(|m| *m != chiaro_lines::surface::NONE);
            if closed {
                let sum: i64 = interval.events.iter().map(characteristic).sum();
                assert_eq!(interval.euler, sum, "{name}, frame {i}");
            }
        } else {
            kinetic = Some(track::Kinetic::new(&surface, &g, &slice, 0));
        }
        before = Some((g, slice));
    }
}

/// What an event of a closed surface adds to the Euler characteristic of S.
fn characteristic(event: &track::Event) -> i64 {
    match event.kind {
        track::EventKind::Saddle => 1 - i64::from(event.arcs),
        _ => 1,
    }
}

/// The share of a scene's lines that is drawn twice.
fn doubled(name: &str) -> f64 {
    let run = Run::default();
    let project = Project::open(name, Options::default(), &run).expect("it opens");
    let poser = project.poser();
    let frame = poser.frame(0.0, &project.playback);
    let bounds = frame.bounds();
    let away = vec3(1.0, 0.6, 2.0).normalize() * 3.6 * bounds.radius();
    let projection = Projection::Perspective { fov_y: 0.6 };
    let pose = Pose::look_at(bounds.centre() + away, bounds.centre(), Vec3::Y, projection);
    let at = |_: usize| (frame.clone(), View::new(pose, (640, 480)));
    let reel = Reel { scene: &project.scene, count: 1, at: &at };
    let film = Film::of(&reel, &LinesKnobs::default(), &run).expect("nothing stops it");
    let strokes = &film.frames[0].strokes;
    overlap(strokes) / strokes.iter().map(Stroke::total).sum::<f64>().max(1.0)
}

#[test]
fn no_line_is_drawn_twice() {
    let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data/anim");
    let mut found = Vec::new();
    files(&data, &mut found);
    if found.is_empty() {
        println!("skipped for files: ../shared/data/anim is absent");
    }
    let files = found.iter().map(|f| f.to_string_lossy().into_owned());
    let demos = ["bowl", "cactus", "cornell-box", "bumpy-torus"].map(|n| format!("demo:{n}"));
    for name in demos.into_iter().chain(files) {
        let share = doubled(&name);
        println!("{name}: {share:.5}");
        // Two of the Knight's outlines touch for six pixels: 0.0025 of his lines.
        assert!(share < 0.003, "{name}: {share}");
    }
}
