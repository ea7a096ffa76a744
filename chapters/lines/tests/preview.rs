//! What the depth buffer says of visibility is what rays say, but for a pixel or two at ends.

mod meshes;

use chiaro_basis::math::{DVec2, Vec3, vec3};
use chiaro_lines::{Ground, Lines, LinesKnobs, Moment, Posed, Stage, Stroke, View, distance};
use chiaro_scene::{Playback, Pose, Projection, Scene, demo};
use meshes::*;

fn both(scene: &Scene, view: &View) -> [Vec<Stroke>; 2] {
    let frame = scene.frame(0.0, &Playback::still());
    let knobs = LinesKnobs { intersection: false, ..LinesKnobs::default() };
    let ground = Ground::of(scene, &frame, &knobs, &[]);
    let posed = Posed::new(&ground.surface, &frame, 0);
    let stage = Stage {
        surface: &ground.surface,
        features: &ground.features,
        masks: &ground.masks,
        knobs: &knobs,
    };
    let moment = Moment { posed: &posed, view, next: None };
    [Lines::find(&stage, &moment).strokes, Lines::preview(&stage, &moment).strokes]
}

/// The share of some strokes' length that is near others.
fn share_near(of: &[Stroke], others: &[Stroke]) -> f64 {
    let near = |at: DVec2| others.iter().any(|s| distance(s, at) < 1.5);
    let samples = || of.iter().flat_map(|s| &s.samples);
    samples().filter(|s| near(s.at)).count() as f64 / samples().count().max(1) as f64
}

#[test]
fn the_depth_buffer_agrees_with_rays() {
    for name in ["bumpy-torus", "peanut", "multipod", "desk"] {
        let scene = demo::scene(name).expect("the scene is there");
        let bounds = scene.frame(0.0, &Playback::still()).bounds();
        let away = vec3(1.0, 0.6, 2.0).normalize();
        let from = bounds.centre() + away * 3.6 * bounds.radius();
        let lens = Projection::Perspective { fov_y: 0.6 };
        let view = View::new(Pose::look_at(from, bounds.centre(), Vec3::Y, lens), (640, 480));
        let [exact, quick] = both(&scene, &view);
        let shares = [share_near(&exact, &quick), share_near(&quick, &exact)];
        // Edges that lie a pixel deep in what they stand on are seen: no harm.
        assert!(shares[0] > 0.98 && shares[1] > 0.75, "{name}: {shares:?}");
    }
}

#[test]
fn a_wall_that_reaches_behind_the_camera_hides() {
    // A sphere behind a wall on which the camera nearly stands.
    let (mut p, mut t) = torus(40, 20, 0.0);
    let wall = p.len() as u32;
    p.extend([vec3(-50.0, -2.0, 40.0), vec3(50.0, -2.0, 40.0), vec3(0.0, 3.0, -40.0)]);
    t.push([wall, wall + 1, wall + 2]);
    let lens = Projection::Perspective { fov_y: 0.8 };
    let pose = Pose::look_at(vec3(0.0, 8.0, 10.0), vec3(0.0, 0.0, 0.0), Vec3::Y, lens);
    let [exact, quick] = both(&scene(p, t, true), &View::new(pose, (320, 240)));
    let shares = [share_near(&exact, &quick), share_near(&quick, &exact)];
    assert!(shares.iter().all(|s| *s > 0.95), "{shares:?}");
}
