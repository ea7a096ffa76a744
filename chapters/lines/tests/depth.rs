//! Visibility against a depth buffer: the same meshes rasterized at four times the resolution, by other
//! code.
//!
//! A sample is surely hidden where every pixel around it holds something nearer, and surely seen where none
//! does and some hold something much farther: a silhouette has a step in depth.

mod meshes;

use chiaro_basis::Run;
use chiaro_basis::math::{DVec2, Vec3, vec3};
use chiaro_lines::{Film, Hidden, Kind, LinesKnobs, Reel, View};
use meshes::*;

/// Pixels of the buffer to one of the picture.
const FINE: f64 = 4.0;
/// Radius around a sample, pixels of the buffer.
const AROUND: i64 = 6;
/// Difference in depth that counts, scene units.
const STEP: f64 = 0.03;

/// The nearest depth at every pixel.
struct Buffer {
    size: [i64; 2],
    depth: Vec<f64>,
}

impl Buffer {
    fn of(positions: &[Vec3], triangles: &[[u32; 3]], view: &View) -> Self {
        let size = [view.size.0, view.size.1].map(|n| (n as f64 * FINE) as i64);
        let mut buffer = Self { size, depth: vec![f64::INFINITY; (size[0] * size[1]) as usize] };
        let seen = |v: &u32| {
            let s = view.see(positions[*v as usize].as_dvec3()).expect("all is in front");
            (s.at * FINE, s.depth)
        };
        for t in triangles {
            let [a, b, c] = [seen(&t[0]), seen(&t[1]), seen(&t[2])];
            buffer.fill([a, b, c]);
        }
        buffer
    }

    fn fill(&mut self, [a, b, c]: [(DVec2, f64); 3]) {
        let area = (b.0 - a.0).perp_dot(c.0 - a.0);
        let low = a.0.min(b.0).min(c.0).floor();
        let high = a.0.max(b.0).max(c.0).ceil();
        for y in (low.y as i64).max(0)..(high.y as i64).min(self.size[1]) {
            for x in (low.x as i64).max(0)..(high.x as i64).min(self.size[0]) {
                let p = DVec2::new(x as f64 + 0.5, y as f64 + 0.5);
                let weight = |q: DVec2, r: DVec2| (q - p).perp_dot(r - p) / area;
                let w = [weight(b.0, c.0), weight(c.0, a.0), weight(a.0, b.0)];
                if w.iter().all(|w| *w >= 0.0) {
                    let z = 1.0 / (w[0] / a.1 + w[1] / b.1 + w[2] / c.1);
                    let here = &mut self.depth[(y * self.size[0] + x) as usize];
                    *here = here.min(z);
                }
            }
        }
    }

    /// Whether a place at some depth is surely hidden, and whether it is surely seen.
    fn verdict(&self, at: DVec2, depth: f64) -> [bool; 2] {
        let (x, y) = ((at.x * FINE) as i64, (at.y * FINE) as i64);
        let (mut nearer, mut farther, mut all) = (0, 0, 0);
        for (dx, dy) in (-AROUND..=AROUND).flat_map(|y| (-AROUND..=AROUND).map(move |x| (x, y))) {
            let (x, y) = (x + dx, y + dy);
            if dx * dx + dy * dy <= AROUND * AROUND
                && (0..self.size[0]).contains(&x)
                && (0..self.size[1]).contains(&y)
            {
                let z = self.depth[(y * self.size[0] + x) as usize];
                all += 1;
                nearer += i32::from(z < depth - STEP);
                farther += i32::from(z > depth + 4.0 * STEP);
            }
        }
        [nearer == all, nearer == 0 && farther > 0]
    }
}

/// Shares of the visible length that are wrongly hidden and wrongly shown.
fn errors(positions: Vec<Vec3>, triangles: Vec<[u32; 3]>, from: Vec3) -> [f64; 2] {
    let view = view(from);
    let buffer = Buffer::of(&positions, &triangles, &view);
    let scene = scene(positions, triangles, false);
    let still = frame(&scene);
    let knobs = LinesKnobs { hidden: Hidden::Dashed, subdivide: 0, ..LinesKnobs::default() };
    let at = |_| (still.clone(), view);
    let reel = Reel { scene: &scene, count: 1, at: &at };
    let film = Film::of(&reel, &knobs, &Run::default()).expect("nothing stops it");
    let (mut visible, mut errors) = (0.0, [0.0; 2]);
    let strokes = film.frames[0].strokes.iter().chain(&film.frames[0].hidden);
    for stroke in strokes.filter(|s| s.kind == Kind::Silhouette) {
        let weight = stroke.total() / stroke.samples.len() as f64;
        for s in &stroke.samples {
            let [hidden, seen] = buffer.verdict(s.at, s.depth);
            visible += if stroke.visible { weight } else { 0.0 };
            errors[0] += if !stroke.visible && seen { weight } else { 0.0 };
            errors[1] += if stroke.visible && hidden { weight } else { 0.0 };
        }
    }
    assert!(visible > 300.0, "{visible}");
    errors.map(|e| e / visible)
}

#[test]
fn a_depth_buffer_agrees_on_what_is_seen() {
    for (i, from) in
        [vec3(1.0, 3.0, 4.5), vec3(0.5, 1.2, 4.0), vec3(4.0, 0.8, -1.0)].iter().enumerate()
    {
        for dents in [0.0, 0.2] {
            let (p, t) = torus(120, 60, dents);
            let [hidden, shown] = errors(p, t, *from);
            assert!(hidden < 5e-3 && shown < 5e-3, "{i} {dents}: {hidden} {shown}");
        }
    }
}

#[test]
fn a_ring_that_goes_through_another_ends_where_it_goes_under() {
    // Two pieces, and no silhouette where one line goes into the other piece.
    let (mut p, mut t) = torus(120, 60, 0.0);
    let base = p.len() as u32;
    let (q, u) = torus(120, 60, 0.0);
    p.extend(q.iter().map(|v| vec3(v.y, v.x, v.z) + vec3(0.6, 0.5, 0.1)));
    t.extend(u.iter().map(|f| [f[0] + base, f[2] + base, f[1] + base]));
    let [hidden, shown] = errors(p, t, vec3(2.0, 3.0, 4.0));
    assert!(hidden < 5e-3 && shown < 5e-3, "{hidden} {shown}");
}

#[test]
fn an_outline_runs_on_from_loop_to_loop() {
    // A ball with noise: its outline is made of many loops.
    let (n, m) = (120u32, 60u32);
    let tau = std::f32::consts::TAU;
    let place = |k: u32| {
        let (i, j) = (k % n, k / n);
        let (u, v) = (tau * i as f32 / n as f32, 0.5 * tau * (j as f32 + 0.5) / m as f32);
        let noise = 1.0 + 0.01 * ((17 * i) as f32).sin() * ((23 * j) as f32).cos();
        1.2 * noise * vec3(u.cos() * v.sin(), v.cos(), u.sin() * v.sin())
    };
    let positions: Vec<Vec3> = (0..n * m).map(place).collect();
    let at = |i: u32, j: u32| j * n + i % n;
    let cells = (0..m - 1).flat_map(|j| (0..n).map(move |i| (i, j)));
    let triangles = cells.flat_map(|(i, j)| {
        let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
        [[a, b, c], [a, c, d]]
    });
    let scene = scene(positions, triangles.collect(), false);
    let still = frame(&scene);
    let strokes = |bridge: f32| {
        let knobs = LinesKnobs { bridge, subdivide: 0, crease: false, ..LinesKnobs::default() };
        let at = |_| (still.clone(), view(vec3(1.0, 1.0, 4.5)));
        let reel = Reel { scene: &scene, count: 1, at: &at };
        let film = Film::of(&reel, &knobs, &Run::default()).expect("nothing stops it");
        let strokes = &film.frames[0].strokes;
        let longest = strokes.iter().map(|s| s.total()).fold(0.0, f64::max);
        (strokes.len(), longest)
    };
    let (apart, joined) = (strokes(0.0), strokes(4.0));
    assert!(joined.1 > 1.5 * apart.1, "{apart:?} {joined:?}");
}

#[test]
fn a_line_that_leaves_the_picture_is_not_joined_to_where_it_comes_back() {
    let (positions, triangles) = torus(80, 40, 0.0);
    let scene = scene(positions, triangles, false);
    let still = frame(&scene);
    let mut leave = 0;
    for from in [vec3(0.4, 0.9, 1.3), vec3(1.2, 0.8, 1.1), vec3(0.2, 2.0, 0.8)] {
        let at = |_| (still.clone(), view(from));
        let reel = Reel { scene: &scene, count: 1, at: &at };
        let film = Film::of(&reel, &LinesKnobs::default(), &Run::default()).expect("it ends");
        for stroke in &film.frames[0].strokes {
            leave += usize::from(!stroke.closed);
            for pair in stroke.samples.windows(2) {
                let gap = pair[0].at.distance(pair[1].at);
                assert!(gap < 12.0, "{from} {} {}", pair[0].at, pair[1].at);
            }
        }
    }
    assert!(leave > 3, "{leave}");
}

#[test]
fn what_a_wall_hides_does_not_show_at_the_edge_of_the_picture() {
    // A torus about the eye's axis, wider than the picture, and before it a wall wider still.
    let (mut positions, mut triangles) = torus(80, 40, 0.2);
    let from = vec3(0.0, 2.2, 0.0);
    let bare = positions.len() as u32;
    let wall = [(-9.0, -9.0), (9.0, -9.0), (9.0, 9.0), (-9.0, 9.0)];
    positions.extend(wall.map(|(x, z)| vec3(x, 1.5, z)));
    for [a, b, c] in [[0, 1, 2], [0, 2, 3]] {
        triangles.extend([[a, b, c], [c, b, a]].map(|t| t.map(|v| v + bare)));
    }
    let strokes = |positions: &[Vec3], triangles: &[[u32; 3]]| {
        let scene = scene(positions.to_vec(), triangles.to_vec(), false);
        let still = frame(&scene);
        let at = |_| (still.clone(), view(from));
        let reel = Reel { scene: &scene, count: 1, at: &at };
        let film = Film::of(&reel, &LinesKnobs::default(), &Run::default()).expect("it ends");
        film.frames[0].strokes.clone()
    };
    let open = triangles.len() - 4;
    let crosses = |s: &chiaro_lines::Stroke| s.samples.iter().any(|p| p.at.min_element() < 0.0);
    assert!(strokes(&positions[..bare as usize], &triangles[..open]).iter().any(crosses));
    assert_eq!(strokes(&positions, &triangles), []);
}

#[test]
fn what_stands_on_a_floor_is_drawn_where_it_stands() {
    // A coarse ball, flat where it stands: its outline there is hardly above the floor.
    let (n, m) = (32u32, 8u32);
    let tau = std::f32::consts::TAU;
    let place = |k: u32| {
        let (i, j) = ((k % n) as f32 / n as f32, ((k / n) as f32 + 0.5) / m as f32);
        let (u, v) = (tau * i, 0.5 * tau * j);
        0.5 * vec3(u.cos() * v.sin(), v.cos(), u.sin() * v.sin())
    };
    let mut positions: Vec<Vec3> = (0..n * m).map(place).collect();
    let low = positions.iter().map(|p| p.y).fold(0.0, f32::min);
    let at = |i: u32, j: u32| j * n + i % n;
    let cells = (0..m - 1).flat_map(|j| (0..n).map(move |i| (i, j)));
    let mut triangles: Vec<[u32; 3]> = cells
        .flat_map(|(i, j)| {
            let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            [[a, b, c], [a, c, d]]
        })
        .collect();
    let (bare, ball) = (positions.len() as u32, triangles.len());
    let corners = [(-3.0, -3.0), (3.0, -3.0), (3.0, 3.0), (-3.0, 3.0)];
    positions.extend(corners.map(|(x, z)| vec3(x, low, z)));
    triangles.extend([[0, 2, 1], [0, 3, 2]].map(|t: [u32; 3]| t.map(|v| v + bare)));
    let low_part = |triangles: &[[u32; 3]]| {
        let scene = scene(positions.clone(), triangles.to_vec(), false);
        let still = frame(&scene);
        let at = |_| (still.clone(), view(vec3(0.2, 0.2, 3.0)));
        let knobs =
            LinesKnobs { border: false, crease: false, subdivide: 0, ..LinesKnobs::default() };
        let reel = Reel { scene: &scene, count: 1, at: &at };
        let film = Film::of(&reel, &knobs, &Run::default()).expect("it ends");
        let part = |s: &chiaro_lines::Stroke| {
            let low = s.samples.iter().filter(|p| p.world.y < -0.4).count();
            s.total() * low as f64 / s.samples.len() as f64
        };
        film.frames[0].strokes.iter().map(part).sum::<f64>()
    };
    let (standing, lone) = (low_part(&triangles), low_part(&triangles[..ball]));
    assert!(lone > 45.0 && standing > 0.9 * lone, "{standing} {lone}");
}

#[test]
fn a_rod_thinner_than_a_pen_is_drawn_once() {
    let rod = |across: f32| {
        let (mut positions, triangles) = cube();
        positions.iter_mut().for_each(|p| *p *= vec3(1.0, across, across));
        let scene = scene(positions, triangles, true);
        let still = frame(&scene);
        let at = |_| (still.clone(), view(vec3(0.0, 1.0, 5.0)));
        let reel = Reel { scene: &scene, count: 1, at: &at };
        let film = Film::of(&reel, &LinesKnobs::default(), &Run::default()).expect("it ends");
        film.frames[0].strokes.iter().map(|s| s.total()).sum::<f64>()
    };
    let (thin, thick) = (rod(0.001), rod(0.1));
    assert!(thin > 100.0 && thin < 0.5 * thick, "{thin} {thick}");
}
