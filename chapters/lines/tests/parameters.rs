//! Textures neither slide nor jump nor fold, whatever the film.

mod meshes;

use chiaro_basis::Run;
use chiaro_basis::math::{Vec3, vec3};
use chiaro_lines::parameter::{Diffuser, Parameters, Solved, Weights, drawn, parameterize, whole};
use chiaro_lines::{
    Cuts, Film, Kind, LinesKnobs, Links, Method, Quality, Reel, Texture, View, quality,
};
use chiaro_scene::{Frame, Scene};
use meshes::*;

fn film(scene: &Scene, count: usize, at: &(dyn Fn(usize) -> (Frame, View) + Sync)) -> Film {
    let reel = Reel { scene, count, at };
    Film::of(&reel, &plain(), &Run::default()).expect("nothing stops it")
}

/// Meshes as they are.
fn plain() -> LinesKnobs {
    LinesKnobs::default()
}

fn torus_film(frames: usize, degrees: f32) -> Film {
    let (p, t) = torus(80, 40, 0.1);
    let scene = scene(p, t, false);
    let still = frame(&scene);
    let view = view(vec3(1.0, 3.0, 4.5));
    film(&scene, frames, &|i| (turned(&still, Vec3::Y, degrees * i as f32), view))
}

fn solve(film: &mut Film, knobs: &LinesKnobs) -> (Solved, Quality) {
    let solved = parameterize(film, &[], knobs, &Run::default()).expect("it is solved");
    (solved, quality(film))
}

/// A ball of rings of `n` vertices between two poles.
fn ball(n: u32, rings: u32) -> (Vec<Vec3>, Vec<[u32; 3]>) {
    let mut positions = vec![Vec3::Y];
    for r in 1..rings {
        let polar = std::f32::consts::PI * r as f32 / rings as f32;
        positions.extend((0..n).map(|i| {
            let a = std::f32::consts::TAU * i as f32 / n as f32;
            vec3(polar.sin() * a.cos(), polar.cos(), -polar.sin() * a.sin())
        }));
    }
    positions.push(-Vec3::Y);
    let at = |r: u32, i: u32| 1 + (r - 1) * n + i % n;
    let last = positions.len() as u32 - 1;
    let mut triangles = Vec::new();
    for i in 0..n {
        triangles.push([0, at(1, i), at(1, i + 1)]);
        for r in 1..rings - 1 {
            triangles.push([at(r, i), at(r + 1, i), at(r + 1, i + 1)]);
            triangles.push([at(r, i), at(r + 1, i + 1), at(r, i + 1)]);
        }
        triangles.push([at(rings - 1, i), last, at(rings - 1, i + 1)]);
    }
    (positions, triangles)
}

#[test]
fn a_turning_torus_neither_slides_nor_folds() {
    let mut film = torus_film(16, 1.5);
    let (solved, q) = solve(&mut film, &plain());
    assert!(solved.links > 0 && solved.unknowns > solved.links / 2);
    assert!(q.slide_p95 < 0.5, "{q:?}");
    assert!(q.stretch_p95 < 0.25, "{q:?}");
    assert!(q.jumps < 0.02, "{q:?}");
    assert_eq!(q.folds, 0);
    let mut naive = torus_film(16, 1.5);
    let (_, arc) = solve(&mut naive, &LinesKnobs { method: Method::Arclength, ..plain() });
    assert!(arc.slide_p95 > 4.0 * q.slide_p95, "{arc:?}");
}

/// A rail behind two posts that move along it.
fn fence_film(frames: usize, knobs: &LinesKnobs) -> Film {
    let (cube, faces) = cube();
    let reach = cube.iter().fold(0.0f32, |m, p| m.max(p.x.abs()));
    let boxes = [
        (vec3(0.0, 0.0, 0.0), vec3(4.0, 0.2, 0.2)),
        (vec3(-1.0, 0.0, 1.5), vec3(0.2, 1.0, 0.1)),
        (vec3(0.9, 0.0, 1.5), vec3(0.2, 1.0, 0.1)),
    ];
    let (mut positions, mut triangles) = (Vec::new(), Vec::new());
    for (at, size) in boxes {
        let first = positions.len() as u32;
        positions.extend(cube.iter().map(|p| at + *p / reach * size));
        triangles.extend(faces.iter().map(|t| t.map(|v| first + v)));
    }
    let scene = scene(positions, triangles, true);
    let still = frame(&scene);
    let view = view(vec3(0.3, 1.0, 7.0));
    let at = |i: usize| {
        let along = |p: Vec3| if p.z > 1.0 { p + 0.07 * i as f32 * Vec3::X } else { p };
        (moved(&still, along), view)
    };
    Film::of(&Reel { scene: &scene, count: frames, at: &at }, knobs, &Run::default())
        .expect("nothing stops it")
}

#[test]
fn lines_go_on_behind_what_hides_them() {
    let (_, q) = solve(&mut fence_film(12, &plain()), &plain());
    assert!(q.gap_p95 < 0.5 && q.slide_p95 < 0.1 && q.stretch_p95 < 0.1, "{q:?}");
    let knobs = LinesKnobs { method: Method::Arclength, ..plain() };
    let (_, alone) = solve(&mut fence_film(12, &knobs), &knobs);
    assert!(alone.gap_p95 > 20.0, "{alone:?}");
}

/// A rail of which a plate hides the middle, where it grows longer.
fn growing_film(frames: usize) -> Film {
    let across = [[-0.2, -0.2], [0.2, -0.2], [0.2, 0.2], [-0.2, 0.2]];
    let along = [-4.0, -0.3, 0.3, 4.0];
    let rings = along.into_iter().flat_map(|x| across.map(|p| vec3(x, p[0], p[1])));
    let mut positions: Vec<Vec3> = rings.collect();
    let side = |i: u32, k: u32| {
        let (a, b) = (4 * i + k, 4 * i + (k + 1) % 4);
        [[a, b, b + 4], [a, b + 4, a + 4]]
    };
    let mut triangles: Vec<[u32; 3]> =
        (0..3).flat_map(|i| (0..4).flat_map(move |k| side(i, k))).collect();
    triangles.extend([[0, 2, 1], [0, 3, 2], [12, 13, 14], [12, 14, 15]]);
    triangles.extend([[16, 17, 18], [16, 18, 19]]);
    positions.extend(
        [[-0.6, -1.0], [0.6, -1.0], [0.6, 1.0], [-0.6, 1.0]].map(|p| vec3(p[0], p[1], 1.5)),
    );
    let scene = scene(positions, triangles, true);
    let still = frame(&scene);
    let at = |i: usize| {
        let grown =
            |p: Vec3| if p.z < 1.0 && p.x > 0.0 { p + 0.0425 * i as f32 * Vec3::X } else { p };
        (moved(&still, grown), view(vec3(0.3, 1.0, 7.0)))
    };
    film(&scene, frames, &at)
}

#[test]
fn what_grows_where_it_is_hidden_keeps_together() {
    let (_, q) = solve(&mut growing_film(12), &plain());
    assert!(q.gap_p95 < 14.0 && q.slide_p95 < 0.3 && q.stretch_p95 < 0.1, "{q:?}");
}

/// A ball with a plate before either side, one of which hides ever more of its outline and the other ever less.
fn plates_film(frames: usize) -> Film {
    let (mut positions, mut triangles) = ball(48, 24);
    for x in [-1.12, 1.04] {
        let first = positions.len() as u32;
        let corners = [[-0.3, -1.2], [0.3, -1.2], [0.3, 1.2], [-0.3, 1.2]];
        positions.extend(corners.map(|p| vec3(x + p[0], p[1], 1.5)));
        triangles.extend([[0, 1, 2], [0, 2, 3]].map(|t| t.map(|v| first + v)));
    }
    let scene = scene(positions, triangles, false);
    let still = frame(&scene);
    let view = flat_view(vec3(0.0, 0.0, 7.0));
    let at = |i: usize| {
        let along = |p: Vec3| if p.z > 1.2 { p + 0.02 * i as f32 * Vec3::X } else { p };
        (moved(&still, along), view)
    };
    film(&scene, frames, &at)
}

#[test]
fn what_hides_a_ring_in_two_places_moves_no_seam() {
    let mut film = plates_film(12);
    let (_, q) = solve(&mut film, &plain());
    for frame in &film.frames {
        let outline = frame.gaps.iter().filter(|g| g.kind == Kind::Silhouette);
        assert_eq!(outline.filter(|g| g.around.is_some()).count(), 2);
    }
    assert!(q.gap_p95 < 1.0 && q.slide_p95 < 0.1, "{q:?}");
}

#[test]
fn the_seam_of_a_ring_that_shrinks_is_no_gap() {
    let (mut positions, mut triangles) = ball(48, 24);
    let first = positions.len() as u32;
    let corners = [[-0.3, -1.2], [0.7, -1.2], [0.7, 1.2], [-0.3, 1.2]];
    positions.extend(corners.map(|p| vec3(p[0] - 1.0, p[1], 1.5)));
    triangles.extend([[0, 1, 2], [0, 2, 3]].map(|t| t.map(|v| first + v)));
    let scene = scene(positions, triangles, false);
    let still = frame(&scene);
    let at = |i: usize| {
        let shrunk =
            |p: Vec3| if p.z > 1.2 { p } else { p * vec3(1.0 - 0.03 * i as f32, 1.0, 1.0) };
        (moved(&still, shrunk), flat_view(vec3(0.0, 0.0, 7.0)))
    };
    let (_, q) = solve(&mut film(&scene, 12, &at), &plain());
    assert!(q.gap_p95 < 1.0, "{q:?}");
}

#[test]
fn pieces_of_a_cut_line_are_drawn_as_one() {
    let mut film = torus_film(16, 6.0);
    solve(&mut film, &LinesKnobs { cuts: Cuts::Both, ..plain() });
    let mut joints = 0;
    for frame in &film.frames {
        let lines = drawn(&frame.strokes);
        for pieces in lines.chunk_by(|a, b| a.body.is_some() && a.body == b.body) {
            let around = [&pieces[pieces.len() - 1], &pieces[0]];
            let closes = !around[1].closed && around[1].body.is_some_and(|b| b.1);
            let pairs = pieces.windows(2).map(|p| [&p[0], &p[1]]);
            for [a, b] in pairs.chain(closes.then_some(around)) {
                assert_eq!(a.samples.last(), b.samples.first());
                assert!(a.goes_on[1] && b.goes_on[0]);
                joints += 1;
            }
        }
        for line in &lines {
            assert!(line.u.len() == line.length.len() && line.u.windows(2).all(|u| u[1] > u[0]));
        }
    }
    assert!(joints > 4, "{joints}");
}

#[test]
fn what_is_renamed_is_counted() {
    let mut film = torus_film(8, 1.5);
    let (_, q) = solve(&mut film, &plain());
    assert_eq!(q.untrue_changes, 0.0);
    assert!(q.renamed < 0.002 && q.line_jumps < 0.002, "{q:?}");
    // Half a texture further from the middle on.
    let mut moved = film.clone();
    let strokes = moved.frames[4..].iter_mut().flat_map(|f| &mut f.strokes);
    strokes.flat_map(|s| &mut s.u).for_each(|u| *u += 0.5);
    let q = chiaro_lines::quality(&moved);
    assert!(q.line_jumps > 0.1 && q.line_jumps < 0.2, "{q:?}");
    // From the middle on everything has another name: one pair of frames of seven.
    film.frames[4..].iter_mut().flat_map(|f| &mut f.strokes).for_each(|s| s.id += 1000);
    let q = chiaro_lines::quality(&film);
    assert!(q.renamed > 0.1 && q.renamed < 0.2, "{q:?}");
    assert!(q.line_jumps > 0.1 && q.line_jumps < 0.2, "{q:?}");
    assert!(q.untrue_changes >= 2.0 / 7.0, "{q:?}");
}

#[test]
fn coherence_trades_stretch_for_sliding() {
    let mut film = torus_film(12, 3.0);
    let parameters =
        Parameters::new(&mut film, &[], &plain(), &Run::default()).expect("it is solved");
    let mut at = |coherence: f32| {
        let weights = Weights::of(&LinesKnobs { coherence, ..plain() });
        parameters.write(&mut film, &weights).expect("it is solved");
        quality(&film)
    };
    let (none, half, full) = (at(0.0), at(0.5), at(1.0));
    assert!(none.slide_p95 > half.slide_p95 && half.slide_p95 > full.slide_p95);
    assert!(none.stretch_p95 < half.stretch_p95 && half.stretch_p95 < full.stretch_p95);
    assert!(none.stretch_p95 < 0.04, "{none:?}");
}

#[test]
fn neither_sampling_nor_frame_rate_moves_the_balance() {
    let (p, t) = torus(80, 40, 0.1);
    let scene = scene(p, t, false);
    let still = frame(&scene);
    let view = view(vec3(1.0, 3.0, 4.5));
    let at = |frames: usize, degrees: f32, step: f32, dt: f64| {
        let knobs = LinesKnobs { step, ..plain() };
        let at = |i: usize| (turned(&still, Vec3::Y, degrees * i as f32), view);
        let reel = Reel { scene: &scene, count: frames, at: &at };
        let mut film = Film::of(&reel, &knobs, &Run::default()).expect("nothing stops it");
        let spacing = vec![dt; frames];
        parameterize(&mut film, &spacing, &knobs, &Run::default()).expect("it is solved");
        quality(&film)
    };
    let base = at(9, 2.0, 3.0, 1.0 / 24.0);
    let dense = at(9, 2.0, 1.5, 1.0 / 24.0);
    let fast = at(17, 1.0, 3.0, 1.0 / 48.0);
    assert!((dense.stretch_p95 / base.stretch_p95).log2().abs() < 0.4, "{base:?} {dense:?}");
    assert!((fast.stretch_p95 / base.stretch_p95).log2().abs() < 0.4, "{base:?} {fast:?}");
    // Half the way in half the time.
    assert!((2.0 * fast.slide_p95 / base.slide_p95).log2().abs() < 0.5, "{base:?} {fast:?}");
}

#[test]
fn what_stands_still_keeps_its_texture() {
    for method in [Method::Global, Method::Propagate, Method::Diffuse, Method::Arclength] {
        let mut film = torus_film(4, 0.0);
        let (_, q) = solve(&mut film, &LinesKnobs { method, ..plain() });
        // Diffusion keeps on smoothing what stands still.
        let blurs = method == Method::Diffuse;
        assert!(q.slide_p95 < if blurs { 0.3 } else { 0.05 }, "{method:?}: {q:?}");
        assert!(q.jumps <= if blurs { 0.05 } else { 0.0 }, "{method:?}: {q:?}");
    }
}

#[test]
fn loops_close_with_whole_patterns_and_their_seams_stay() {
    // The outline of a ball is one loop in every frame.
    let (p, t) = ball(48, 24);
    let scene = scene(p, t, false);
    let still = frame(&scene);
    let view = view(vec3(1.0, 3.0, 4.5));
    let mut film = film(&scene, 10, &|i| (turned(&still, Vec3::Z, 2.0 * i as f32), view));
    let (_, q) = solve(&mut film, &plain());
    let loops: Vec<_> = film.frames.iter().flat_map(|f| &f.strokes).filter(|s| s.closed).collect();
    assert!(loops.len() >= 8, "{}", loops.len());
    for s in loops {
        let period = s.u_period.expect("closed strokes have a period");
        assert!((period - period.round()).abs() < 1e-9, "{period}");
        assert_eq!(s.u.len(), s.samples.len() + 1);
        assert!(s.u.windows(2).all(|u| u[1] > u[0]));
    }
    assert!(q.slide_p95 < 1.0, "{q:?}");
}

#[test]
fn loops_that_are_propagated_keep_their_texture() {
    // Half a turn of a ring.
    let mut film = torus_film(24, 7.5);
    let knobs = LinesKnobs { method: Method::Propagate, ..plain() };
    solve(&mut film, &knobs);
    let strokes = || film.frames.iter().flat_map(|f| &f.strokes);
    assert!(strokes().filter(|s| s.closed).count() >= 20);
    for s in strokes().filter(|s| s.closed) {
        let period = s.u_period.expect("closed strokes have a period");
        let stretch = s.total() / (period * s.pixels_per_u);
        assert!((0.7..1.42).contains(&stretch), "{stretch}");
    }
}

#[test]
fn stretched_textures_cover_their_lines() {
    let mut film = torus_film(8, 1.0);
    let knobs = LinesKnobs { texture: Texture::Stretched, w_end: 10.0, ..plain() };
    let (_, q) = solve(&mut film, &knobs);
    assert_eq!(q.folds, 0);
    for s in film.frames.iter().flat_map(|f| &f.strokes).filter(|s| s.total() > 60.0) {
        let (first, last) = (s.u[0], s.u[s.u.len() - 1]);
        assert!(first.abs() < 0.12 && (last - 1.0).abs() < 0.12, "{first} {last}");
        assert!((s.pixels_per_u - s.total()).abs() < 1e-9);
    }
}

#[test]
fn loops_that_grow_fast_go_on() {
    // A ring from above grows to three times its size, by 5.5 % a frame: round its outlines of 600 pixels and more, rigid textures are left
    // behind by dozens of pixels.
    let (p, t) = torus(80, 40, 0.0);
    let scene = scene(p, t, false);
    let still = frame(&scene);
    let pose = flat_view(vec3(0.0, 4.0, 0.1)).pose;
    let at = |i: usize| {
        let size = 0.42 * 1.055f32.powi(i as i32);
        (moved(&still, |p| p * size), View::new(pose, (960, 720)))
    };
    let mut film = film(&scene, 22, &at);
    let (solved, q) = solve(&mut film, &plain());
    assert_eq!((solved.cut, q.folds), (0, 0));
    assert_eq!((q.renamed, q.jumps), (0.0, 0.0));
    assert!(q.slide_p95 < 1.0, "{q:?}");
}

#[test]
fn octaves_follow_a_zoom() {
    let (p, t) = torus(80, 40, 0.1);
    let scene = scene(p, t, false);
    let still = frame(&scene);
    let at = |i: usize| (still.clone(), view(vec3(1.0, 3.0, 4.5) * 0.96f32.powi(i as i32)));
    let measured = |octaves: bool| {
        let mut film = film(&scene, 16, &at);
        let knobs = LinesKnobs { octaves, coherence: 0.9, ..plain() };
        let (_, q) = solve(&mut film, &knobs);
        let last = film.frames[15].strokes[0].pixels_per_u;
        (q, last / f64::from(knobs.pattern_length))
    };
    let ((fixed, one), (grown, more)) = (measured(false), measured(true));
    assert_eq!(one, 1.0);
    assert!(more > 1.4 && more < 2.6, "{more}");
    assert!(grown.slide_p95 < 0.5 * fixed.slide_p95, "{grown:?} {fixed:?}");
    assert!(grown.stretch_p95 < fixed.stretch_p95, "{grown:?} {fixed:?}");
}

#[test]
fn every_way_to_cut_and_link_folds_nothing() {
    let together = [Cuts::Charts, Cuts::Both];
    for cuts in together.into_iter().chain([Cuts::Links, Cuts::Events, Cuts::Unpaired, Cuts::None])
    {
        for links in [Links::Projected, Links::Swept] {
            let mut film = torus_film(10, 6.0);
            let (solved, q) = solve(&mut film, &LinesKnobs { cuts, links, ..plain() });
            assert_eq!(q.folds, 0, "{cuts:?} {links:?}");
            let at_events = [Cuts::Both, Cuts::Events, Cuts::Unpaired].contains(&cuts);
            assert_eq!(solved.saved.is_some(), at_events);
        }
    }
    let counted = |cuts: Cuts| {
        let mut film = torus_film(16, 6.0);
        let (solved, _) = solve(&mut film, &LinesKnobs { cuts, ..plain() });
        solved.saved.expect("cuts at events are counted")
    };
    let (paired, unpaired) = (counted(Cuts::Events), counted(Cuts::Unpaired));
    assert_eq!(paired.events, unpaired.events);
    assert!(paired.cut_places <= unpaired.cut_places, "{paired:?} {unpaired:?}");
}

#[test]
fn a_film_is_cut_at_mergers_where_contradictions_are_left() {
    let of = |degrees: f32, cuts: Cuts| {
        let (p, t) = torus(120, 60, 0.35);
        let scene = scene(p, t, false);
        let still = frame(&scene);
        let view = view(vec3(1.0, 3.0, 4.5));
        let at = |i| (turned(&still, Vec3::Y, degrees * i as f32), view);
        solve(&mut film(&scene, 24, &at), &LinesKnobs { cuts, ..plain() })
    };
    // Slowly nothing contradicts; fast, charts alone leave some that do.
    let (calm, _) = of(0.2, Cuts::Auto);
    assert!(calm.saved.is_none() && calm.cut == 0, "{calm:?}");
    let (charts, torn) = of(9.0, Cuts::Charts);
    let (auto, quality) = of(9.0, Cuts::Auto);
    assert!(charts.saved.is_none() && auto.saved.is_some(), "{charts:?} {auto:?}");
    assert!(auto.cut_length < 0.5 * charts.cut_length, "{auto:?} {charts:?}");
    assert!(quality.jumps < torn.jumps && quality.folds == 0, "{quality:?} {torn:?}");
}

#[test]
fn poor_films_are_parameterized() {
    let flat = sheet(3, 0.0);
    let lone = (vec![Vec3::X, Vec3::Y, Vec3::Z], vec![[0, 1, 2]]);
    let none = (vec![], vec![]);
    for (positions, triangles) in [flat, lone, none] {
        let scene = scene(positions, triangles, false);
        let still = frame(&scene);
        for count in [0, 1, 2] {
            for method in [Method::Global, Method::Propagate, Method::Diffuse, Method::Arclength] {
                for from in [vec3(3.0, 4.0, 5.0), vec3(0.0, 0.0, 1e-6), vec3(0.0, 400.0, 1.0)] {
                    let mut film = film(&scene, count, &|_| (still.clone(), view(from)));
                    let (_, q) = solve(&mut film, &LinesKnobs { method, ..plain() });
                    assert!(q.slide_p95.is_finite());
                }
            }
        }
    }
}

#[test]
fn diffusion_goes_frame_by_frame_without_a_future() {
    let mut film = torus_film(6, 1.0);
    let mut diffuser = Diffuser::default();
    let mut pens: Vec<f64> = Vec::new();
    for frame in &mut film.frames {
        let fresh = |_: &chiaro_lines::Stroke, j: usize| chiaro_lines::parameter::Gesture {
            width: 2.0,
            angle: 0.3,
            pressure: (j % 7) as f64,
        };
        let gestures = diffuser.gestures(&frame.strokes, &frame.view, fresh);
        diffuser.advance(&mut frame.strokes, &frame.view, 20.0);
        diffuser.record(&gestures);
        let all = gestures.iter().flatten();
        pens.extend(all.clone().map(|g| g.width));
        assert!(all.clone().all(|g| (0.0..=6.0).contains(&g.pressure)));
    }
    assert!(pens.iter().all(|w| (w - 2.0).abs() < 1e-9), "a constant stays one");
    let q = quality(&film);
    assert!(q.slide_p95 < 4.0, "{q:?}");
}

#[test]
fn textures_stay_on_loops_whose_ends_meet() {
    // A ball that is looked at from all round: one closed silhouette in every frame.
    let (p, t) = ball(48, 24);
    let scene = scene(p, t, false);
    let still = frame(&scene);
    let at = |i: usize| {
        let a = 0.02 * i as f32;
        (still.clone(), view(vec3(4.0 * a.sin(), 0.5, 4.0 * a.cos())))
    };
    for method in [Method::Global, Method::Diffuse, Method::Propagate] {
        let mut film = film(&scene, 8, &at);
        assert!(film.frames.iter().all(|f| f.strokes.len() == 1 && f.strokes[0].closed));
        let (_, q) = solve(&mut film, &LinesKnobs { method, ..plain() });
        assert!(q.slide_p95.is_finite() && q.stretch_p95.is_finite(), "{method:?} {q:?}");
        if method != Method::Propagate {
            assert!(q.slide_over_2 < 0.05 && q.folds == 0, "{method:?} {q:?}");
            let [first, last] = [0, 7].map(|f| film.frames[f].strokes[0].u_period.unwrap_or(0.0));
            assert!((last - first).abs() < 0.05 * first, "{method:?}: {first} {last}");
        }
    }
}

#[test]
fn threads_change_no_parameter() {
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
        pool.install(|| {
            let mut film = torus_film(8, 4.0);
            solve(&mut film, &plain());
            film.frames.into_iter().map(|f| f.strokes).collect::<Vec<_>>()
        })
    };
    assert_eq!(on(1), on(3));
}

#[test]
fn an_id_has_one_texture_and_loops_close_as_it_repeats() {
    let mut film = torus_film(16, 5.0);
    let (_, q) = solve(&mut film, &LinesKnobs { cuts: Cuts::Links, ..plain() });
    let strokes = || film.frames.iter().flat_map(|f| &f.strokes);
    let mut texture = std::collections::BTreeMap::new();
    for stroke in strokes() {
        let first = texture.entry(stroke.id).or_insert(stroke.texture());
        assert_eq!(*first, stroke.texture(), "an id has one texture");
        assert!(!stroke.closed || stroke.u_period == stroke.repeats, "a loop closes as it repeats");
    }
    assert!(q.texture_jumps < 0.02, "{q:?}");
}

#[test]
fn lines_are_parted_in_name_where_ids_meet() {
    let jumps = |cuts: Cuts| {
        let mut film = torus_film(24, 3.0);
        let (_, q) = solve(&mut film, &LinesKnobs { cuts, ..plain() });
        assert_eq!(q.folds, 0);
        for frame in &film.frames {
            let joined = whole(&frame.strokes);
            let parted = frame.strokes.iter().filter(|s| s.part.is_some());
            assert!(joined.len() <= frame.strokes.len() - parted.count() / 2);
            for s in joined {
                assert!(s.u.windows(2).all(|u| u[0] < u[1]), "u goes on across parts");
                let steps = s.length.windows(2).map(|l| l[1] - l[0]);
                assert!(steps.fold(0.0, f64::max) < 10.0, "parts follow each other");
            }
        }
        (q, film.frames.iter().map(|f| f.strokes.len()).sum::<usize>())
    };
    let ((whole, few), (parted, more)) = (jumps(Cuts::Links), jumps(Cuts::Charts));
    assert!(parted.jumps < 0.004 && parted.jumps <= whole.jumps, "{parted:?} {whole:?}");
    assert!(parted.slide_p95 < 1.2 * whole.slide_p95, "{parted:?} {whole:?}");
    assert!(more <= 2 * few, "{more} {few}");
}
