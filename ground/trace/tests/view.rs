//! Default views of procedural scenes.

use chiaro_scene::{Playback, Poser, demo};
use chiaro_trace::view::{Framing, Setting};
use chiaro_trace::{Ray, Sides, Tracer};
use std::collections::BTreeSet;

/// The default view's setting, and the objects that a coarse picture of it shows.
fn seen(name: &str) -> (Setting, BTreeSet<u32>, usize) {
    let mut scene = demo::scene(name).expect("it is there");
    scene.cameras.clear();
    let frame = Poser::new(&scene).frame(0.0, &Playback::default());
    let tracer = Tracer::new(&scene, &frame);
    let framing = Framing::of(&tracer, std::slice::from_ref(&frame));
    let (pose, setting) = framing.view(4.0 / 3.0, 0.0);
    assert!(pose.position.is_finite() && (pose.forward.length() - 1.0).abs() < 1e-4);
    let rays = (0..48 * 36).filter_map(|i| {
        let (x, y) = ((i % 48) as f32 + 0.5, (i / 48) as f32 + 0.5);
        let (origin, direction) = pose.ray(x, y, 48.0, 36.0);
        tracer.hit(&Ray { origin, direction, t_max: f32::INFINITY }, Sides::AsMaterials)
    });
    let hits: Vec<u32> = rays.map(|h| h.object).collect();
    (setting, hits.iter().copied().collect(), hits.len())
}

#[test]
fn a_room_is_seen_from_inside_with_what_stands_in_it() {
    let (setting, objects, covered) = seen("cornell-box");
    assert_eq!(setting, Setting::Room);
    assert!(covered > 48 * 36 / 2, "{covered}");
    let all = demo::scene("cornell-box").expect("it is there").nodes.len();
    assert!(objects.len() * 2 > all, "{} of {all}", objects.len());
}

#[test]
fn an_object_is_seen_from_outside_and_fills_the_picture() {
    for name in ["head", "torus", "golf-ball"] {
        let (setting, _, covered) = seen(name);
        assert_eq!(setting, Setting::Object, "{name}");
        assert!(covered > 48 * 36 / 8, "{name}: {covered}");
    }
}
