//! Films: ids last, what is hidden is hidden, and poor input gives a result.

mod meshes;

use chiaro_basis::math::{Quat, Vec3, vec3};
use chiaro_basis::{Run, random};
use chiaro_lines::{Film, Kind, LinesKnobs, Reel, View, measure};
use chiaro_scene::{Frame, Pose, Projection, Scene};
use meshes::*;

fn film(scene: &Scene, count: usize, at: &(dyn Fn(usize) -> (Frame, View) + Sync)) -> Film {
    let reel = Reel { scene, count, at };
    Film::of(&reel, &LinesKnobs::default(), &Run::default()).expect("nothing stops it")
}

/// A mesh that turns about y before a fixed camera.
fn turning(scene: &Scene, count: usize, degrees: f32) -> Film {
    let still = frame(scene);
    let view = view(vec3(1.0, 3.0, 4.5));
    film(scene, count, &|i| (turned(&still, Vec3::Y, degrees * i as f32), view))
}

#[test]
fn a_turning_torus_keeps_its_ids() {
    let (p, t) = torus(80, 40, 0.1);
    let film = turning(&scene(p, t, false), 12, 2.0);
    let m = measure(&film);
    assert!(m.one_to_one > 0.98, "{m:?}");
    assert!(m.strokes_per_frame < 20.0, "{m:?}");
    assert!(m.mean_life_frames <= 12.0, "parts of a line in one frame are one: {m:?}");
    for frame in &film.frames {
        for (i, a) in frame.strokes.iter().enumerate() {
            let same = frame.strokes[..i].iter().filter(|b| b.id == a.id);
            for b in same {
                assert_eq!((a.kind, a.chain), (b.kind, b.chain), "an id is one line's");
            }
        }
        assert!(frame.slice.chains.iter().all(|c| c.closed), "a closed mesh has closed chains");
    }
}

#[test]
fn a_cube_shows_nine_edges() {
    let (p, t) = cube();
    let scene = scene(p, t, true);
    let still = frame(&scene);
    let film = film(&scene, 1, &|_| (still.clone(), view(vec3(2.0, 3.0, 4.5))));
    let length = |kind: Kind| -> f64 {
        let strokes = film.frames[0].strokes.iter().filter(|s| s.kind == kind);
        let sides = |s: &chiaro_lines::Stroke| -> f64 {
            let points: Vec<_> = s.samples.iter().map(|p| p.world).collect();
            let around = s.closed.then(|| points[points.len() - 1].distance(points[0]));
            points.windows(2).map(|p| p[0].distance(p[1])).sum::<f64>() + around.unwrap_or(0.0)
        };
        strokes.map(sides).sum()
    };
    assert!((length(Kind::Silhouette) - 12.0).abs() < 0.05, "{}", length(Kind::Silhouette));
    assert!((length(Kind::Crease) - 6.0).abs() < 0.05, "{}", length(Kind::Crease));
}

#[test]
fn materials_that_meet_at_a_facets_edge_have_a_border() {
    // A roof that bends too little for a crease.
    let positions = [(-2.0, 0.0), (0.0, 0.5), (2.0, 0.0)]
        .into_iter()
        .flat_map(|(x, y)| [vec3(x, y, -1.0), vec3(x, y, 1.0)])
        .collect::<Vec<Vec3>>();
    let triangles = [[0, 1, 3], [0, 3, 2], [2, 3, 5], [2, 5, 4]];
    let mut scene = soup(&positions, &triangles, true);
    scene.materials.push(chiaro_scene::Material::default());
    scene.meshes[0].materials[2..].fill(chiaro_scene::MaterialId::new(1));
    let still = frame(&scene);
    let length = |from: Vec3, kind: Kind| -> f64 {
        let film = film(&scene, 1, &|_| (still.clone(), view(from)));
        let kinds = film.frames[0].strokes.iter().filter(|s| s.kind == kind);
        let ends =
            |s: &chiaro_lines::Stroke| [s.samples[0].world, s.samples[s.samples.len() - 1].world];
        kinds.map(ends).map(|[a, b]| a.distance(b)).sum()
    };
    let above = vec3(0.5, 4.0, 2.0);
    assert!((length(above, Kind::Material) - 2.0).abs() < 0.05);
    assert_eq!(length(above, Kind::Silhouette), 0.0);
    // Seen from the side the ridge is the outline, and drawn once.
    let beside = vec3(5.0, 0.7, 0.3);
    assert!((length(beside, Kind::Silhouette) - 2.0).abs() < 0.05);
    assert_eq!(length(beside, Kind::Material), 0.0);
}

#[test]
fn what_is_behind_is_hidden() {
    // A small cube behind a large sheet, and one before it.
    let (mut positions, mut triangles) = sheet(2, 0.0);
    positions.iter_mut().for_each(|p| *p *= 3.0);
    for (scale, y) in [(0.2, -1.0), (0.3, 1.0)] {
        let (cube, faces) = cube();
        let base = positions.len() as u32;
        positions.extend(cube.iter().map(|p| *p * scale + vec3(0.0, y, 0.0)));
        triangles.extend(faces.iter().map(|f| f.map(|v| v + base)));
    }
    let scene = scene(positions, triangles, true);
    let still = frame(&scene);
    let projection = Projection::Perspective { fov_y: 0.8 };
    let pose = Pose::look_at(vec3(0.0, 9.0, 0.1), Vec3::ZERO, Vec3::Z, projection);
    let film = film(&scene, 1, &|_| (still.clone(), View::new(pose, (320, 240))));
    let heights = film.frames[0].strokes.iter().flat_map(|s| &s.samples).map(|s| s.world.y);
    let heights: Vec<f64> = heights.collect();
    assert!(heights.iter().all(|y| *y > -0.5), "the lower cube is hidden");
    assert!(heights.iter().any(|y| *y > 0.5), "the upper cube is seen");
}

#[test]
fn poor_meshes_give_a_result() {
    let flat = sheet(3, 0.0);
    let lone = (vec![Vec3::X, Vec3::Y, Vec3::Z], vec![[0, 1, 2]]);
    let point = (vec![Vec3::ONE; 3], vec![[0, 1, 2]]);
    let none = (vec![], vec![]);
    for (positions, triangles) in [flat, lone, point, none] {
        let scene = scene(positions, triangles, false);
        let still = frame(&scene);
        for from in [vec3(3.0, 4.0, 5.0), vec3(0.0, 0.0, 0.0), vec3(0.0, 0.0, 1e-6)] {
            for count in [0, 1, 3] {
                let film = film(&scene, count, &|_| (still.clone(), view(from)));
                assert_eq!(film.frames.len(), count);
            }
        }
    }
}

#[test]
fn cameras_inside_and_before_everything_give_a_result() {
    let (p, t) = torus(24, 16, 0.2);
    let scene = scene(p, t, false);
    let still = frame(&scene);
    for (from, to) in
        [(vec3(1.0, 0.0, 0.0), vec3(2.0, 0.5, 0.3)), (vec3(9.0, 0.0, 0.0), vec3(20.0, 0.0, 0.0))]
    {
        let projection = Projection::Perspective { fov_y: 1.0 };
        let view = View::new(Pose::look_at(from, to, Vec3::Y, projection), (160, 120));
        let film = film(&scene, 2, &|_| (still.clone(), view));
        let inside = |s: &chiaro_lines::Sample| view.holds(s.at, 3.0) && s.depth > 0.0;
        assert!(film.frames[0].strokes.iter().flat_map(|s| &s.samples).all(inside));
        if to.x > 10.0 {
            assert!(film.frames[0].strokes.is_empty(), "everything is behind the camera");
        }
    }
}

#[test]
fn a_cut_of_the_camera_begins_anew() {
    let (p, t) = torus(40, 20, 0.1);
    let scene = scene(p, t, false);
    let still = frame(&scene);
    let film = film(&scene, 6, &|i| {
        let from = if i < 3 { vec3(0.1 * i as f32, 3.0, 4.0) } else { vec3(-4.0, 1.0, -2.0) };
        (still.clone(), view(from))
    });
    let begins: Vec<bool> = film.frames.iter().map(|f| f.begins).collect();
    assert_eq!(begins, [true, false, false, true, false, false]);
    let ids = |i: usize| film.frames[i].strokes.iter().map(|s| s.id).collect::<Vec<u32>>();
    assert!(ids(2).iter().all(|id| !ids(3).contains(id)), "nothing goes through a cut");
}

#[test]
fn a_blob_made_anew_keeps_its_ids() {
    // The vertices are shuffled in every frame: no mesh topology is left to follow.
    let (p, t) = torus(40, 20, 0.1);
    let still = frame(&scene(p.clone(), t.clone(), false));
    let shuffled = |i: usize| {
        let mut order: Vec<u32> = (0..p.len() as u32).collect();
        order.sort_by_key(|v| random::hash(i as u64, u64::from(*v)));
        let mut place = vec![0; p.len()];
        order.iter().enumerate().for_each(|(new, old)| place[*old as usize] = new as u32);
        let turn = Quat::from_rotation_y(0.03 * i as f32);
        let positions = order.iter().map(|v| turn * p[*v as usize]).collect();
        scene(positions, t.iter().map(|f| f.map(|v| place[v as usize])).collect(), false)
    };
    let all: Vec<Scene> = (0..6).map(shuffled).collect();
    let view = view(vec3(1.0, 3.0, 4.5));
    let film = film(&all[0], 6, &|i| {
        let mut frame = frame(&all[i]);
        frame.shapes[0].remade = Some(std::sync::Arc::new(all[i].meshes[0].clone()));
        assert_eq!(frame.objects.len(), still.objects.len());
        (frame, view)
    });
    let ids = |i: usize| film.frames[i].strokes.iter().map(|s| s.id).collect::<Vec<u32>>();
    let kept = ids(5).iter().filter(|id| ids(0).contains(id)).count();
    assert!(kept * 3 >= 2 * ids(5).len(), "{:?} {:?}", ids(0), ids(5));
}

#[test]
fn further_line_types_lie_where_they_should() {
    let (p, t) = torus(120, 60, 0.12);
    let scene = scene(p, t, false);
    let still = frame(&scene);
    let view = view(vec3(1.0, 3.0, 4.5));
    let knobs = LinesKnobs {
        suggestive: true,
        terminator: true,
        ridge: true,
        valley: true,
        apparent_ridge: true,
        ridge_strength: 2.0,
        ..LinesKnobs::default()
    };
    let at = |_: usize| (still.clone(), view);
    let reel = Reel { scene: &scene, count: 2, at: &at };
    let film = Film::of(&reel, &knobs, &Run::default()).expect("nothing stops it");
    for kind in [Kind::Suggestive, Kind::Terminator, Kind::Ridge] {
        let of = |i: usize| film.frames[i].strokes.iter().filter(move |s| s.kind == kind);
        assert!(of(0).count() > 0, "{kind:?}");
        let ids = |i: usize| of(i).map(|s| s.id).collect::<Vec<u32>>();
        assert_eq!(ids(0), ids(1), "{kind:?}: what stands still keeps its ids");
    }
}

#[test]
fn hidden_lines_make_whole_loops() {
    let (p, t) = torus(80, 40, 0.1);
    let scene = scene(p, t, false);
    let still = frame(&scene);
    let view = view(vec3(1.0, 3.0, 4.5));
    let knobs = LinesKnobs {
        hidden: chiaro_lines::Hidden::Dashed,
        shortest: 0.0,
        bridge: 0.0,
        ..LinesKnobs::default()
    };
    let at = |_: usize| (still.clone(), view);
    let reel = Reel { scene: &scene, count: 1, at: &at };
    let film = Film::of(&reel, &knobs, &Run::default()).expect("nothing stops it");
    let frame = &film.frames[0];
    let drawn: f64 = frame.strokes.iter().chain(&frame.hidden).map(|s| s.total()).sum();
    let positions =
        chiaro_lines::positions(&film.surface.as_ref().expect("it is fixed").surface, &still);
    let surface = &film.surface.as_ref().expect("it is fixed").surface;
    let whole: f64 = frame
        .slice
        .chains
        .iter()
        .map(|chain| {
            let at = |c: &chiaro_lines::Crossing| {
                let [a, b] = surface.ends(c.edge).map(|v| positions[v as usize]);
                view.see(a.lerp(b, c.at)).expect("it is in front").at
            };
            let points: Vec<_> = chain.of(&frame.slice).iter().map(at).collect();
            (0..points.len())
                .map(|i| points[i].distance(points[(i + 1) % points.len()]))
                .sum::<f64>()
        })
        .sum();
    assert!((drawn - whole).abs() < 0.03 * whole, "{drawn} of {whole}");
}

#[test]
fn threads_change_nothing() {
    let (p, t) = torus(40, 20, 0.1);
    let scene = scene(p, t, false);
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let film = turning(&scene, 7, 3.0);
            film.frames.into_iter().map(|f| (f.strokes, f.labels, f.interval)).collect::<Vec<_>>()
        })
    };
    assert_eq!(on(1), on(3));
}

#[test]
fn what_is_a_few_pixels_large_keeps_an_outline() {
    for (positions, triangles) in [ball(8), cube()] {
        let hard = positions.len() == 8;
        let small = positions.iter().map(|p| *p * 0.03).collect();
        let film = turning(&scene(small, triangles, hard), 2, 5.0);
        for strokes in film.frames.iter().map(|f| &f.strokes) {
            let outline = strokes.iter().filter(|s| s.kind == Kind::Silhouette);
            let total: f64 = outline.map(chiaro_lines::Stroke::total).sum();
            assert!((6.0..24.0).contains(&total), "{total}");
        }
    }
}
