//! Which way triangles wind changes no line of what is seen from both sides.

mod meshes;

use chiaro_basis::Run;
use chiaro_basis::math::{DQuat, DVec3, Vec3, vec3};
use chiaro_lines::{Film, FilmFrame, Kind, LinesKnobs, Reel, View};
use chiaro_scene::{Pose, Projection, Scene, Transform};
use meshes::*;

fn seen(scene: &Scene, view: View) -> FilmFrame {
    let still = frame(scene);
    let reel = Reel { scene, count: 1, at: &|_| (still.clone(), view) };
    let film = Film::of(&reel, &LinesKnobs::default(), &Run::default());
    film.expect("nothing stops it").frames.into_iter().next().expect("there is a frame")
}

fn inwards(triangles: &[[u32; 3]]) -> Vec<[u32; 3]> {
    triangles.iter().map(|&[a, b, c]| [a, c, b]).collect()
}

/// The visible length of a kind of lines, pixels.
fn length(frame: &FilmFrame, kind: Kind) -> f64 {
    let strokes = frame.strokes.iter().filter(|s| s.kind == kind && s.visible);
    let length = |s: &chiaro_lines::Stroke| {
        let open: f64 = s.samples.windows(2).map(|p| p[0].at.distance(p[1].at)).sum();
        let ends = [s.samples[s.samples.len() - 1].at, s.samples[0].at];
        open + if s.closed { ends[0].distance(ends[1]) } else { 0.0 }
    };
    strokes.map(length).sum()
}

fn alike(a: &FilmFrame, b: &FilmFrame, least: f64) {
    for kind in Kind::ALL {
        let [a, b] = [length(a, kind), length(b, kind)];
        assert!((a - b).abs() < 1.0 + 0.01 * a, "{kind:?}: {a} and {b}");
    }
    let silhouettes = length(a, Kind::Silhouette);
    assert!(silhouettes > least, "{silhouettes}");
}

fn room_view() -> View {
    let projection = Projection::Perspective { fov_y: 1.2 };
    let pose = Pose::look_at(vec3(0.3, 1.2, 3.6), vec3(1.6, 1.0, 0.0), Vec3::Y, projection);
    View::new(pose, (320, 240))
}

/// A closed room of two arms, its faces wound outwards.
fn room() -> (Vec<Vec3>, Vec<[u32; 3]>) {
    let plan = [[0.0, 0.0], [4.0, 0.0], [4.0, 1.5], [1.2, 1.5], [1.2, 4.0], [0.0, 4.0]];
    let at = |height: f32| plan.map(|[x, z]| vec3(x, height, z));
    let positions = [at(0.0), at(2.0)].concat();
    let floor = [[0, 1, 2], [0, 2, 3], [0, 3, 5], [3, 4, 5]];
    let ceiling = floor.map(|[a, b, c]: [u32; 3]| [c + 6, b + 6, a + 6]);
    let walls = (0..6).flat_map(|i| {
        let j = (i + 1) % 6;
        [[i, i + 6, j + 6], [i, j + 6, j]]
    });
    (positions, floor.into_iter().chain(ceiling).chain(walls).collect())
}

#[test]
fn solids_that_are_wound_inwards_have_the_same_lines() {
    for (positions, triangles) in [torus(40, 20, 0.2), ball(12), cube()] {
        let hard = positions.len() == 8;
        for view in [view(vec3(2.0, 1.5, 4.0)), flat_view(vec3(2.0, 1.5, 4.0))] {
            let out = seen(&scene(positions.clone(), triangles.clone(), hard), view);
            let within = seen(&scene(positions.clone(), inwards(&triangles), hard), view);
            alike(&out, &within, 100.0);
        }
    }
}

#[test]
fn a_mirrored_node_and_what_is_wound_inwards_stand_together() {
    let (ball, triangles) = ball(12);
    let count = ball.len() as u32;
    let aside = |p: &Vec3| *p * 0.6 + vec3(0.9, 0.3, 0.6);
    let positions: Vec<Vec3> = ball.iter().copied().chain(ball.iter().map(aside)).collect();
    let other = |t: Vec<[u32; 3]>| t.into_iter().map(|t| t.map(|v| v + count));
    let both = |second: Vec<[u32; 3]>| triangles.iter().copied().chain(other(second)).collect();
    let alike_wound = scene(positions.clone(), both(triangles.clone()), false);
    let mixed = scene(positions.clone(), both(inwards(&triangles)), false);
    let mut mirrored = scene(
        positions.iter().map(|p| *p * vec3(-1.0, 1.0, 1.0)).collect(),
        both(inwards(&triangles)),
        false,
    );
    mirrored.nodes[0].transform = Transform::Parts {
        translation: DVec3::ZERO,
        rotation: DQuat::IDENTITY,
        scale: DVec3::new(-1.0, 1.0, 1.0),
    };
    let view = view(vec3(2.0, 1.5, 4.0));
    let first = seen(&alike_wound, view);
    alike(&first, &seen(&mixed, view), 300.0);
    alike(&first, &seen(&mirrored, view), 300.0);
}

#[test]
fn a_room_is_seen_from_inside_however_it_is_wound() {
    let (positions, triangles) = room();
    let out = seen(&scene(positions.clone(), triangles.clone(), true), room_view());
    let within = seen(&scene(positions.clone(), inwards(&triangles), true), room_view());
    // The corner that stands before the other arm.
    alike(&out, &within, 50.0);
    let corner = within.strokes.iter().filter(|s| s.kind == Kind::Silhouette);
    let of_corner = |p: Vec3| (p.x - 1.2).abs() < 1e-3 && (p.z - 1.5).abs() < 1e-3;
    let mut samples = corner.flat_map(|s| &s.samples).map(|s| s.world.as_vec3());
    assert!(samples.all(of_corner));
}

#[test]
fn folds_of_a_sheet_are_seen_from_both_its_sides() {
    let (positions, triangles) = sheet(60, 0.4);
    let view = view(vec3(3.5, 1.0, 1.0));
    let front = seen(&scene(positions.clone(), triangles.clone(), false), view);
    let back = seen(&scene(positions, inwards(&triangles), false), view);
    let [front, back] = [front, back].map(|f| length(&f, Kind::Silhouette));
    assert!(front > 250.0 && (front - back).abs() < 2.0, "{front} {back}");
}

#[test]
fn a_sheet_whose_back_is_not_shown_has_no_lines_from_behind() {
    let (positions, triangles) = sheet(8, 0.0);
    let mut one_sided = scene(positions, triangles, false);
    one_sided.materials[0].double_sided = false;
    let shown = |from: Vec3| length(&seen(&one_sided, view(from)), Kind::Border);
    assert!(shown(vec3(1.0, 3.0, 2.0)) > 300.0);
    assert_eq!(shown(vec3(1.0, -3.0, 2.0)), 0.0);
}
