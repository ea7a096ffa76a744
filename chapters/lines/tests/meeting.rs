//! Lines where pieces pass through each other, and partners of samples in the next frame.

mod meshes;

use chiaro_basis::Run;
use chiaro_basis::math::{Quat, Vec3, vec3};
use chiaro_lines::parameter::parameterize;
use chiaro_lines::{Film, FilmFrame, Kind, LinesKnobs, Reel, View};
use chiaro_scene::{Pose, Projection, Scene};
use meshes::*;

fn film(
    scene: &Scene,
    count: usize,
    at: &(dyn Fn(usize) -> (chiaro_scene::Frame, View) + Sync),
) -> Film {
    let reel = Reel { scene, count, at };
    Film::of(&reel, &LinesKnobs::default(), &Run::default()).expect("nothing stops it")
}

fn from_above(scene: &Scene) -> FilmFrame {
    let still = frame(scene);
    let projection = Projection::Perspective { fov_y: 0.8 };
    let pose = Pose::look_at(vec3(2.0, 5.0, 3.0), Vec3::ZERO, Vec3::Y, projection);
    let film = film(scene, 1, &|_| (still.clone(), View::new(pose, (640, 480))));
    film.frames.into_iter().next().expect("there is a frame")
}

#[test]
fn a_ring_through_a_sheet_shows_where_it_enters() {
    let (mut positions, mut triangles) = torus(60, 30, 0.0);
    let base = positions.len() as u32;
    let (sheet, faces) = sheet(2, 0.0);
    positions.extend(sheet.iter().map(|p| *p * 3.0));
    triangles.extend(faces.iter().map(|f| f.map(|v| v + base)));
    let frame = from_above(&scene(positions, triangles, false));
    let lines: Vec<_> = frame.strokes.iter().filter(|s| s.kind == Kind::Intersection).collect();
    // The torus lies in the sheet: circles of radius 0.6 and 1.4, seen from above but for what the
    // ring itself hides of them.
    assert!(lines.len() >= 2, "{}", lines.len());
    for s in lines.iter().flat_map(|s| &s.samples) {
        let r = s.world.x.hypot(s.world.z);
        assert!(s.world.y.abs() < 1e-6, "{}", s.world);
        assert!((r - 0.6).abs().min((r - 1.4).abs()) < 4e-3, "{r}");
    }
    // Nothing below the sheet is seen.
    let low = frame.strokes.iter().flat_map(|s| &s.samples).filter(|s| s.world.y < -0.02);
    assert_eq!(low.count(), 0);
}

#[test]
fn where_pieces_meet_lines_run_the_same_way_in_every_frame() {
    // A ring lies in a sheet, tilted a little, and turns: faces that meet are others in every frame.
    let (positions, mut triangles) = torus(60, 30, 0.0);
    let base = positions.len() as u32;
    let (sheet, faces) = sheet(2, 0.0);
    triangles.extend(faces.iter().map(|f| f.map(|v| v + base)));
    let projection = Projection::Perspective { fov_y: 0.8 };
    let pose = Pose::look_at(vec3(2.0, 5.0, 3.0), Vec3::ZERO, Vec3::Y, projection);
    let mut ways = [[0; 2]; 2];
    for i in 0..12 {
        let turn = Quat::from_rotation_y(0.37 * i as f32) * Quat::from_rotation_x(0.02);
        let ring = positions.iter().map(|p| turn * *p);
        let all = ring.chain(sheet.iter().map(|p| *p * 3.0)).collect();
        let scene = scene(all, triangles.clone(), false);
        let still = frame(&scene);
        let film = film(&scene, 1, &|_| (still.clone(), View::new(pose, (640, 480))));
        for s in film.frames[0].strokes.iter().filter(|s| s.kind == Kind::Intersection) {
            for pair in s.samples.windows(2).map(|p| [p[0].world, p[1].world]) {
                let outer = usize::from(pair[0].x.hypot(pair[0].z) > 1.0);
                let turn = pair[0].cross(pair[1]).y;
                ways[outer][usize::from(turn > 0.0)] += 1;
            }
        }
    }
    for way in ways {
        assert!(way[0].min(way[1]) == 0 && way[0].max(way[1]) > 200, "{way:?}");
    }
}

#[test]
fn outlines_of_coarse_balls_that_dip_into_each_other_have_no_gaps() {
    // Their outlines are chords, and where they meet each is within the other.
    let (ball, faces) = ball(5);
    let count = ball.len() as u32;
    let mut loose = Vec::new();
    for i in 0..24 {
        let turn = |by: f32| Quat::from_rotation_x(by) * Quat::from_rotation_y(1.7 * by);
        let (first, second) = (turn(0.31 * i as f32), turn(2.0 - 0.43 * i as f32));
        let aside = first * vec3(0.5, 0.2, 0.1);
        let mut positions: Vec<Vec3> = ball.iter().map(|p| first * *p).collect();
        positions.extend(ball.iter().map(|p| second * *p * 0.8 + aside));
        let other = faces.iter().map(|f| f.map(|v| v + count));
        let frame =
            from_above(&scene(positions, faces.iter().copied().chain(other).collect(), false));
        for (k, stroke) in frame.strokes.iter().enumerate().filter(|(_, s)| !s.closed) {
            for end in [stroke.samples[0], stroke.samples[stroke.samples.len() - 1]] {
                let others = frame.strokes.iter().enumerate().filter(|(j, _)| *j != k);
                let samples = others.flat_map(|(_, s)| &s.samples);
                let nearest = samples.map(|p| p.at.distance(end.at)).fold(f64::MAX, f64::min);
                loose.extend((nearest > 5.0).then_some((i, end.at, nearest)));
            }
        }
    }
    assert!(loose.len() <= 2, "{loose:?}");
}

#[test]
fn what_only_touches_has_no_line() {
    let (mut positions, mut triangles) = cube();
    positions.iter_mut().for_each(|p| *p = *p * 0.5 + vec3(0.0, 0.5, 0.0));
    let (sheet, faces) = sheet(3, 0.0);
    let base = positions.len() as u32;
    positions.extend(sheet.iter().map(|p| *p * 2.0));
    triangles.extend(faces.iter().map(|f| f.map(|v| v + base)));
    let frame = from_above(&scene(positions, triangles, true));
    assert!(frame.strokes.iter().all(|s| s.kind != Kind::Intersection));
}

#[test]
fn partners_are_near_the_material_points_and_keep_ids() {
    let (p, t) = torus(80, 40, 0.1);
    let scene = scene(p, t, false);
    let still = frame(&scene);
    let view = view(vec3(1.0, 3.0, 4.5));
    let film = film(&scene, 5, &|i| (turned(&still, Vec3::Y, 1.5 * i as f32), view));
    let (mut all, mut found, mut same) = (0, 0, 0);
    for (i, pair) in film.frames.windows(2).enumerate() {
        for (stroke, partners) in pair[0].strokes.iter().zip(film.partners(i)) {
            assert_eq!(stroke.samples.len(), partners.len());
            for partner in partners {
                all += 1;
                let Some(p) = partner else { continue };
                found += 1;
                let target = &pair[1].strokes[p.stroke as usize];
                assert!((p.segment as usize) < target.samples.len());
                assert!((0.0..=1.0).contains(&p.share));
                same += usize::from(target.id == stroke.id && p.distance < 3.0);
            }
        }
    }
    assert!(found * 100 > 95 * all, "{found} of {all}");
    assert!(same * 100 > 97 * found, "{same} of {found}");
    let last = film.partners(film.frames.len() - 1);
    assert!(last.iter().flatten().all(Option::is_none));
}

/// Of the samples of a kind whose material point stays in the picture: how many there are, how many have a
/// partner, how many one of their own id within 3 px.
fn partnered(film: &Film, kind: Kind) -> [usize; 3] {
    let mut counts = [0; 3];
    for (i, pair) in film.frames.windows(2).enumerate() {
        let of_kind = pair[0].strokes.iter().zip(film.partners(i));
        for (stroke, partners) in of_kind.filter(|(s, _)| s.kind == kind) {
            for (sample, partner) in stroke.samples.iter().zip(partners) {
                counts[0] += usize::from(sample.next_at.is_some());
                let Some(p) = partner else { continue };
                let target = &pair[1].strokes[p.stroke as usize];
                assert_eq!(target.kind, kind);
                counts[1] += 1;
                counts[2] += usize::from(target.id == stroke.id && p.distance < 3.0);
            }
        }
    }
    counts
}

#[test]
fn every_line_type_has_partners_and_keeps_ids() {
    let (p, t) = torus(80, 40, 0.2);
    let scene = scene(p, t, false);
    let still = frame(&scene);
    let view = view(vec3(1.0, 3.0, 4.5));
    let at = |i: usize| (turned(&still, Vec3::Y, 1.0 * i as f32), view);
    let reel = Reel { scene: &scene, count: 4, at: &at };
    let knobs = LinesKnobs {
        suggestive: true,
        ridge: true,
        valley: true,
        apparent_ridge: true,
        terminator: true,
        suggestive_strength: 1.0,
        ridge_strength: 2.0,
        apparent_strength: 4.0,
        ..LinesKnobs::default()
    };
    let mut film = Film::of(&reel, &knobs, &Run::default()).expect("nothing stops it");
    parameterize(&mut film, &[], &knobs, &Run::default()).expect("it has a solution");
    let kinds = [
        Kind::Silhouette,
        Kind::Suggestive,
        Kind::Ridge,
        Kind::Valley,
        Kind::ApparentRidge,
        Kind::Terminator,
    ];
    for kind in kinds {
        let [all, found, own] = partnered(&film, kind);
        println!("{kind:?}: {all} {found} {own}");
        assert!(all > 60, "{kind:?}: {all}");
        assert!(found * 100 > 90 * all, "{kind:?}: {found} of {all}");
        assert!(own * 100 > 95 * found, "{kind:?}: {own} of {found}");
    }
}

#[test]
fn intersections_have_partners() {
    // A ring that sinks into a sheet.
    let (mut positions, mut triangles) = torus(60, 30, 0.0);
    let base = positions.len() as u32;
    let (sheet, faces) = sheet(2, 0.0);
    positions.extend(sheet.iter().map(|p| *p * 3.0));
    triangles.extend(faces.iter().map(|f| f.map(|v| v + base)));
    let scene = scene(positions, triangles, false);
    let still = frame(&scene);
    let sunk = |i: usize| {
        let mut frame = still.clone();
        for shape in &mut frame.shapes {
            let n = base as usize;
            let moved = |(k, p): (usize, &Vec3)| {
                if k < n { *p - vec3(0.0, 0.15 + 0.02 * i as f32, 0.0) } else { *p }
            };
            shape.positions = shape.positions.iter().enumerate().map(moved).collect();
        }
        frame
    };
    let view = view(vec3(2.0, 5.0, 3.0));
    let film = film(&scene, 4, &|i| (sunk(i), view));
    let [all, found, own] = partnered(&film, Kind::Intersection);
    assert!(all > 50 && found * 100 > 90 * all, "{found} of {all}");
    assert!(own * 100 > 95 * found, "{own} of {found}");
}

#[test]
fn a_mesh_made_anew_has_partners_by_votes() {
    let scene = chiaro_scene::demo::scene("metaballs").expect("it is there");
    let (playback, _) = scene.playback(&chiaro_scene::Choice::Auto).expect("clips play together");
    let poser = chiaro_scene::Poser::new(&scene);
    let view = view(vec3(1.0, 2.0, 8.0));
    let film = film(&scene, 3, &|i| (poser.frame(i as f64 / 24.0, &playback), view));
    let samples = |f: &FilmFrame| f.strokes.iter().map(|s| s.samples.len()).sum::<usize>();
    let found = film.partners(0).iter().flatten().flatten().count();
    assert!(found * 10 > 9 * samples(&film.frames[0]), "{found}");
}

#[test]
fn holes_of_a_masked_sheet_hide_nothing_and_have_no_border() {
    use chiaro_basis::math::vec2;
    use chiaro_scene::{Alpha, Texture, TextureId, TextureUse};
    // A sheet before a cube; the left half of its texture is a hole.
    let (mut positions, mut triangles) = sheet(2, 0.0);
    positions.iter_mut().for_each(|p| *p = *p * 2.0 + vec3(0.0, 2.0, 0.0));
    let uv: Vec<_> = positions.iter().map(|p| vec2(0.25 * p.x + 0.5, 0.5)).collect();
    let (cube, faces) = cube();
    let base = positions.len() as u32;
    positions.extend(cube.iter().map(|p| *p * 0.5));
    triangles.extend(faces.iter().map(|f| f.map(|v| v + base)));
    let mut scene = scene(positions, triangles, true);
    let mut coordinates = uv;
    coordinates.resize(scene.meshes[0].positions.len(), vec2(0.9, 0.5));
    scene.meshes[0].uvs = vec![coordinates];
    let texel = |x: usize, _: usize| [255, 255, 255, if x < 8 { 0 } else { 255 }];
    scene.textures = vec![Texture {
        name: String::new(),
        pixels: std::sync::Arc::new(chiaro_image::Plane::from_fn(16, 1, texel)),
        wrap: [chiaro_scene::Wrap::Clamp; 2],
        filter: chiaro_scene::Filter::Nearest,
    }];
    scene.materials[0].base_texture = Some(TextureUse::plain(TextureId::new(0)));
    scene.materials[0].alpha = Alpha::Mask(0.5);
    let still = frame(&scene);
    let projection = Projection::Perspective { fov_y: 0.8 };
    let pose = Pose::look_at(vec3(0.0, 9.0, 0.1), Vec3::ZERO, Vec3::Z, projection);
    let film = film(&scene, 1, &|_| (still.clone(), View::new(pose, (320, 240))));
    let seen: Vec<_> = film.frames[0].strokes.iter().flat_map(|s| &s.samples).collect();
    let low = |s: &&&chiaro_lines::Sample| s.world.y < 1.0;
    assert!(seen.iter().any(|s| low(&s) && s.world.x < -0.3), "the cube shows through the hole");
    assert!(!seen.iter().any(|s| low(&s) && s.world.x > 0.1), "the rest of it is hidden");
    let high = |s: &&&chiaro_lines::Sample| s.world.y > 1.5;
    assert!(seen.iter().any(|s| high(&s) && s.world.x > 0.5), "the sheet has its border");
    assert!(!seen.iter().any(|s| high(&s) && s.world.x < -0.2), "but not round the hole");
}

#[test]
fn a_piece_that_goes_through_itself_shows_where() {
    // A long sheet rolled up until its ends cross: x, y as a loop with a knot, z across
    // and a little askew, so that no edge meets another.
    let (n, m) = (160, 12);
    let place = |i: usize, j: usize| {
        let t = (i as f32 / n as f32 - 0.5) * 4.2;
        vec3(t * t * t - t, t * t - 1.0, j as f32 / m as f32 - 0.5 + 0.013 * t)
    };
    let positions: Vec<Vec3> = (0..=n).flat_map(|i| (0..=m).map(move |j| place(i, j))).collect();
    let at = |i: usize, j: usize| (i * (m + 1) + j) as u32;
    let quads = (0..n).flat_map(|i| (0..m).map(move |j| (i, j)));
    let triangles: Vec<[u32; 3]> = quads
        .flat_map(|(i, j)| {
            let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            [[a, b, c], [a, c, d]]
        })
        .collect();
    let frame = from_above(&scene(positions, triangles, true));
    let lines: Vec<_> = frame.strokes.iter().filter(|s| s.kind == Kind::Intersection).collect();
    assert!(!lines.is_empty());
    // The curve (t^3 - t, t^2 - 1) meets itself at t = 1 and -1: in the origin.
    for s in lines.iter().flat_map(|s| &s.samples) {
        assert!(s.world.x.hypot(s.world.y) < 0.02, "{}", s.world);
    }
}
