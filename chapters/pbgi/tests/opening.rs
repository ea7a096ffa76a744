//! Directional occlusion against closed forms.

#![allow(clippy::unwrap_used)]

use chiaro_basis::Run;
use chiaro_basis::math::{Vec3, vec3};
use chiaro_image::Plane;
use chiaro_pbgi::{Indirect, LightKnobs, Lit, Wanted, indirect_of, prepare, sites};
use chiaro_scene::load::{Budget, Door, Up, read_scene};
use chiaro_scene::{Pose, Poser, Projection};
use chiaro_trace::{GBuffer, Lights, Sky, Surfaces, Tracer};
use std::f32::consts::{FRAC_1_PI, PI};
use std::sync::Arc;

/// What the pixels of a small picture of an OBJ file's faces find.
fn found(
    file: &str,
    (eye, target): (Vec3, Vec3),
    sky: Option<Sky>,
    bound: f32,
) -> (Indirect, GBuffer) {
    let mut door = Door::new("a.obj", &(), Budget::default());
    let scene = read_scene("a.obj", file.as_bytes(), Up::Y, &mut door).unwrap();
    let (playback, _) = scene.playback(&Default::default()).unwrap();
    let frame = Poser::new(&scene).frame(0.0, &playback);
    let (tracer, surfaces) = (Tracer::new(&scene, &frame), Surfaces::new(&scene));
    let lights = Lights { sky: sky.map(Arc::new), ..Lights::default() };
    let lit = Lit { tracer: &tracer, surfaces: &surfaces, lights: &lights };
    let run = Run::default();
    let pose = Pose::look_at(eye, target, Vec3::Z, Projection::Perspective { fov_y: 0.5 });
    let buffer = GBuffer::trace(&tracer, &surfaces, &pose, (32, 32), &run).unwrap();
    let knobs = LightKnobs {
        surfels: 20_000,
        bounces: 1,
        error_bound: bound,
        occlusion: 100.0,
        side_rays: 0,
        ..LightKnobs::default()
    };
    let sites = sites(&scene, &frame, knobs.surfels as usize);
    let prepared = prepare(lit, &sites, &knobs, &run).unwrap();
    let wanted = Wanted { openings: true, ..Wanted::default() };
    (indirect_of(&prepared, &buffer, wanted, &run).unwrap(), buffer)
}

/// The mean of a plane over covered pixels for which something holds.
fn mean(plane: &Plane<[f32; 3]>, buffer: &GBuffer, holds: impl Fn(Vec3) -> bool) -> Vec3 {
    let all = plane.pixels().iter().zip(buffer.position.pixels()).zip(buffer.covered.pixels());
    let some: Vec<Vec3> = all
        .filter(|((_, p), c)| **c && holds(Vec3::from(**p)))
        .map(|((v, _), _)| (*v).into())
        .collect();
    some.iter().sum::<Vec3>() / some.len() as f32
}

const FLOOR: &str = "v -9 0 -9\nv -9 0 9\nv 9 0 9\nv 9 0 -9\nf 1 2 3 4\n";
const WALL: &str = "v 0 0 -300\nv 0 0 300\nv 0 300 300\nv 0 300 -300\nf 5 6 7 8\n";
const LOOK: (Vec3, Vec3) = (vec3(0.6, 1.0, 0.1), vec3(0.2, 0.0, 0.0));

/// A sky of which the half with x > 0 is red, the other green.
fn halves() -> Sky {
    Sky::new(Plane::from_fn(64, 32, |x, _| if x >= 32 { [1.0, 0.0, 0.0] } else { [0.0, 1.0, 0.0] }))
}

#[test]
fn in_the_open_the_bent_normal_is_the_normal_and_a_dome_comes_in_whole() {
    for bound in [0.1, 0.0] {
        let (own, buffer) = found(FLOOR, LOOK, None, bound);
        let openings = own.openings.unwrap();
        let bent = mean(&openings.bent, &buffer, |_| true);
        assert!(bent.distance(Vec3::Y) < 0.02, "{bound} {bent}");
        assert!(mean(&openings.dome, &buffer, |_| true).distance(Vec3::ONE) < 0.02);
        let (own, buffer) = found(FLOOR, LOOK, Some(halves()), bound);
        let dome = mean(&own.openings.unwrap().dome, &buffer, |_| true);
        assert!(dome.distance(vec3(0.5, 0.5, 0.0)) < 0.03, "{dome}");
    }
}

/// At the foot of an endless wall a quarter of space is open. The integral of its directions times cosine
/// has pi / 3 along the normal and 2 / 3 away from the wall.
#[test]
fn at_the_foot_of_a_wall_the_bent_normal_leans_away_from_it() {
    let file = format!("{FLOOR}{WALL}");
    for bound in [0.1, 0.0] {
        let (own, buffer) = found(&file, LOOK, Some(halves()), bound);
        let openings = own.openings.unwrap();
        let floor = |p: Vec3| p.y < 1e-3 && p.x > 0.02;
        let bent = mean(&openings.bent, &buffer, floor);
        let exact = vec3(2.0 / 3.0, PI / 3.0, 0.0).normalize();
        assert!(bent.distance(exact) < 0.06, "{bound} {bent} {exact}");
        // Half of the hemisphere by cosine, all of it red.
        let dome = mean(&openings.dome, &buffer, floor);
        assert!(dome.distance(vec3(0.5, 0.0, 0.0)) < 0.05, "{bound} {dome}");
        let same = own.openness.pixels().iter().zip(openings.dome.pixels());
        assert!(same.clone().filter(|(a, d)| (*a - d[0] - d[1]).abs() < 0.05).count() > 900);
    }
}

#[test]
fn in_a_closed_box_nothing_is_open() {
    let file = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n\
                f 1 2 3 4\nf 5 6 7 8\nf 1 2 6 5\nf 4 3 7 8\nf 1 4 8 5\nf 2 3 7 6\n";
    for bound in [0.1, 0.0] {
        let look = (vec3(0.5, 0.5, 0.5), vec3(0.4, 0.0, 0.4));
        let (own, buffer) = found(file, look, None, bound);
        let openings = own.openings.unwrap();
        let dark = |p: &&[f32; 3]| Vec3::from(**p).length() * FRAC_1_PI < 0.03;
        let open = openings.dome.pixels().iter().filter(dark).count();
        assert!(open * 100 > 97 * buffer.covered.len(), "{bound} {open}");
        let bent = mean(&openings.bent, &buffer, |_| true);
        assert!(bent.length() < 0.3, "{bound} {bent}");
    }
}
