//! Rays against closed forms and against every triangle.

use chiaro_basis::math::{DQuat, DVec3, Vec3, vec3};
use chiaro_basis::random;
use chiaro_scene::{
    Material, MaterialId, Mesh, MeshId, Node, NormalSource, Playback, Poser, Scene, Transform,
};
use chiaro_trace::{Glow, Lamps, Ray, Sides, Surfaces, Tracer};
use rayon::prelude::*;

/// A sphere of `n` x 2 `n` quads, closed: vertices of the seam and of the poles are shared.
fn sphere(n: usize, bump: f32) -> Mesh {
    let around = 2 * n;
    let mut positions = vec![Vec3::Y];
    for i in 1..n {
        let polar = std::f32::consts::PI * i as f32 / n as f32;
        for j in 0..around {
            let turn = std::f32::consts::TAU * j as f32 / around as f32;
            let r = 1.0 + bump * (7.0 * turn).sin() * (5.0 * polar).sin();
            positions
                .push(vec3(polar.sin() * turn.cos(), polar.cos(), polar.sin() * turn.sin()) * r);
        }
    }
    positions.push(Vec3::NEG_Y);
    let last = positions.len() as u32 - 1;
    let at = |i: usize, j: usize| (1 + (i - 1) * around + j % around) as u32;
    let mut triangles = Vec::new();
    for j in 0..around {
        triangles.push([0, at(1, j + 1), at(1, j)]);
        triangles.push([last, at(n - 1, j), at(n - 1, j + 1)]);
        for i in 1..n - 1 {
            triangles.push([at(i, j), at(i, j + 1), at(i + 1, j)]);
            triangles.push([at(i, j + 1), at(i + 1, j + 1), at(i + 1, j)]);
        }
    }
    Mesh {
        normals: NormalSource::Given(positions.iter().map(|p| p.normalize()).collect()),
        materials: vec![MaterialId::new(0); triangles.len()],
        positions,
        triangles,
        ..Mesh::default()
    }
}

fn scene(mesh: Mesh, places: &[Transform]) -> Scene {
    let node =
        |t: &Transform| Node { transform: *t, mesh: Some(MeshId::new(0)), ..Node::default() };
    Scene {
        meshes: vec![mesh],
        materials: vec![Material::default()],
        nodes: places.iter().map(node).collect(),
        ..Scene::default()
    }
}

fn place(translation: [f64; 3], turn: f64, scale: [f64; 3]) -> Transform {
    Transform::Parts {
        translation: DVec3::from(translation),
        rotation: DQuat::from_rotation_y(turn),
        scale: DVec3::from(scale),
    }
}

fn direction(i: u64) -> Vec3 {
    let (u, v) = (random::unit(1, i), random::unit(2, i));
    let z = 1.0 - 2.0 * u;
    let r = (1.0 - z * z).sqrt();
    let a = std::f32::consts::TAU * v;
    vec3(r * a.cos(), r * a.sin(), z)
}

#[test]
fn a_million_rays_find_no_pinhole_in_closed_meshes() {
    for (bump, offset, scale) in [(0.0, 0.0, 1.0), (0.05, 1000.0, 1.0), (0.05, 3.0, 1e-3)] {
        let s = [scale; 3];
        let scene = scene(sphere(48, bump), &[place([offset, -offset, offset], 0.3, s)]);
        let frame = Poser::new(&scene).frame(0.0, &Playback::still());
        let tracer = Tracer::new(&scene, &frame);
        let origin = Vec3::new(offset as f32, -offset as f32, offset as f32);
        let escaped = (0..350_000u64)
            .into_par_iter()
            .filter(|&i| {
                let ray = Ray { origin, direction: direction(i), t_max: f32::INFINITY };
                tracer.hit(&ray, Sides::Both).is_none() || !tracer.occluded(&ray)
            })
            .count();
        assert_eq!(escaped, 0, "offset {offset}, scale {scale}");
    }
}

#[test]
fn rays_at_vertices_edges_and_along_axes_do_not_slip_through() {
    let scene = scene(sphere(24, 0.0), &[Transform::default()]);
    let frame = Poser::new(&scene).frame(0.0, &Playback::still());
    let tracer = Tracer::new(&scene, &frame);
    let mesh = &scene.meshes[0];
    let mut targets: Vec<Vec3> = mesh.positions.clone();
    for t in &mesh.triangles {
        let p = t.map(|v| mesh.positions[v as usize]);
        targets.extend([0.5 * (p[0] + p[1]), 0.25 * p[1] + 0.75 * p[2]]);
    }
    for axis in [Vec3::X, Vec3::Y, Vec3::Z] {
        // With zeros of either sign.
        targets.extend([axis, -axis, axis * vec3(1.0, 1.0, 1.0) - Vec3::ZERO, -(-axis)]);
    }
    for target in targets {
        let ray = Ray { origin: Vec3::ZERO, direction: target.normalize(), t_max: f32::INFINITY };
        assert!(tracer.hit(&ray, Sides::Both).is_some(), "towards {target}");
    }
}

#[test]
fn what_is_near_is_met_at_any_scale() {
    for scale in [1e-7, 1e-4, 1.0, 1e5] {
        let mut mesh = sphere(24, 0.0);
        mesh.positions.iter_mut().for_each(|p| *p *= scale);
        // Alone, and as one of two places.
        for places in [1, 2] {
            let far = place([5.0 * f64::from(scale), 0.0, 0.0], 0.3, [1.0; 3]);
            let places = &[Transform::default(), far][..places];
            let scene = scene(mesh.clone(), places);
            let frame = Poser::new(&scene).frame(0.0, &Playback::default());
            let tracer = Tracer::new(&scene, &frame);
            for i in 0..500 {
                let towards = direction(i);
                let ray = Ray {
                    origin: towards * (0.98 * scale),
                    direction: towards,
                    t_max: 0.1 * scale,
                };
                let hit = tracer.hit(&ray, Sides::Both).map(|hit| hit.t / scale);
                assert!(hit.is_some_and(|t| t < 0.0201), "{scale} {i} {hit:?}");
                assert!(tracer.occluded(&ray), "{scale} {i}");
            }
        }
    }
}

#[test]
fn hits_are_those_of_every_triangle_tried_in_turn() {
    let places = [
        place([0.0; 3], 0.0, [1.0; 3]),
        place([2.5, 0.3, -0.4], 1.0, [0.7, 1.3, 0.9]),
        place([-2.0, 0.5, 1.0], 2.0, [-0.8, 0.8, 0.8]),
    ];
    let scene = scene(sphere(12, 0.1), &places);
    let frame = Poser::new(&scene).frame(0.0, &Playback::still());
    let tracer = Tracer::new(&scene, &frame);
    for i in 0..3000 {
        let origin = 4.0 * direction(2 * i);
        let target = 2.5 * direction(2 * i + 1);
        let ray = Ray { origin, direction: (target - origin).normalize(), t_max: f32::INFINITY };
        let nearest = frame
            .objects
            .iter()
            .flat_map(|o| {
                let p: Vec<Vec3> = frame.world_positions(o).collect();
                scene.meshes[0]
                    .triangles
                    .iter()
                    .filter_map(move |t| cross(&ray, t.map(|v| p[v as usize])))
            })
            .fold(f32::INFINITY, f32::min);
        let hit = tracer.hit(&ray, Sides::Both).map_or(f32::INFINITY, |h| h.t);
        let same = hit == nearest || (hit - nearest).abs() < 1e-4;
        assert!(same, "ray {i}: {hit} where the nearest is {nearest}");
        assert_eq!(tracer.occluded(&ray), nearest.is_finite());
    }
}

/// Möller and Trumbore's test, in double precision.
fn cross(ray: &Ray, p: [Vec3; 3]) -> Option<f32> {
    let [a, b, c] = p.map(|v| v.as_dvec3());
    let (o, d) = (ray.origin.as_dvec3(), ray.direction.as_dvec3());
    let (e1, e2) = (b - a, c - a);
    let h = d.cross(e2);
    let det = e1.dot(h);
    let s = o - a;
    let u = s.dot(h) / det;
    let q = s.cross(e1);
    let v = d.dot(q) / det;
    let t = e2.dot(q) / det;
    (det != 0.0 && u >= 0.0 && v >= 0.0 && u + v <= 1.0 && t > 0.0).then_some(t as f32)
}

#[test]
fn a_refitted_tracer_answers_like_a_new_one() {
    let scene_a = scene(sphere(16, 0.0), &[Transform::default()]);
    let scene_b = scene(sphere(16, 0.2), &[place([0.2, 0.0, 0.1], 0.5, [1.0; 3])]);
    let (a, b) = (
        Poser::new(&scene_a).frame(0.0, &Playback::still()),
        Poser::new(&scene_b).frame(0.0, &Playback::still()),
    );
    let refitted = Tracer::new(&scene_a, &a).refit(&scene_b, &b);
    let fresh = Tracer::new(&scene_b, &b);
    for i in 0..20_000 {
        let ray = Ray { origin: 3.0 * direction(i), direction: direction(i + 7), t_max: 9.0 };
        assert_eq!(refitted.hit(&ray, Sides::Both), fresh.hit(&ray, Sides::Both));
        assert_eq!(refitted.occluded(&ray), fresh.occluded(&ray));
    }
}

#[test]
fn single_sided_faces_are_seen_from_the_front_alone() {
    for mirror in [1.0, -1.0] {
        let mut scene = scene(sphere(12, 0.0), &[place([0.0; 3], 0.0, [mirror, 1.0, 1.0])]);
        scene.materials[0].double_sided = false;
        let frame = Poser::new(&scene).frame(0.0, &Playback::still());
        let tracer = Tracer::new(&scene, &frame);
        let outside = Ray { origin: vec3(0.1, 0.2, 5.0), direction: Vec3::NEG_Z, t_max: 99.0 };
        let inside = Ray { origin: Vec3::ZERO, ..outside };
        let near = tracer.hit(&outside, Sides::AsMaterials).map(|h| h.t);
        assert!(near.is_some_and(|t| t < 5.0), "mirror {mirror}: {near:?}");
        assert!(tracer.hit(&inside, Sides::AsMaterials).is_none(), "mirror {mirror}");
        assert!(tracer.hit(&inside, Sides::Both).is_some());
    }
}

/// A rectangle of two triangles, tilted, so that its distances round.
fn tilted(x0: f32, x1: f32) -> Mesh {
    let at = |x: f32, y: f32| vec3(x, y, 0.3 * x + 0.7 * y);
    Mesh {
        positions: vec![at(x0, -1.0), at(x1, -1.0), at(x1, 1.0), at(x0, 1.0)],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        materials: vec![MaterialId::new(0); 2],
        ..Mesh::default()
    }
}

/// A tilted sheet, and after it in the same plane a second one that overlaps it.
fn overlapping() -> Scene {
    let mut scene = scene(tilted(-1.0, 0.4), &[place([0.0; 3], 0.0, [1.0; 3])]);
    scene.meshes.push(tilted(-0.37, 1.13));
    scene.nodes.push(Node { mesh: Some(MeshId::new(1)), ..Node::default() });
    scene
}

/// A ray to a point of their plane, and that point.
fn onto(across: f32, along: f32) -> (Ray, Vec3) {
    let aim = vec3(across, along, 0.3 * across + 0.7 * along);
    let origin = vec3(0.2, 0.1, 4.0);
    (Ray { origin, direction: (aim - origin).normalize(), t_max: f32::INFINITY }, aim)
}

#[test]
fn a_lamp_flush_with_a_ceiling_is_seen_and_met() {
    let mut scene = overlapping();
    scene.materials.push(Material { emissive: [1.0; 3], ..scene.materials[0].clone() });
    let lamp = MaterialId::new(scene.materials.len() - 1);
    scene.meshes[1].materials = vec![lamp; 2];
    let frame = Poser::new(&scene).frame(0.0, &Playback::still());
    let tracer = Tracer::new(&scene, &frame);
    for k in 0..2000 {
        let across = 0.74 * random::unit(8, 2 * k) - 0.36;
        let along = 1.8 * random::unit(8, 2 * k + 1) - 0.9;
        let (ray, _) = onto(across, along);
        assert_eq!(tracer.seen(&ray).map(|h| h.object), Some(1), "at {across} {along}");
        assert_eq!(tracer.met(&ray, Sides::Both).map(|h| h.object), Some(1));
    }
}

#[test]
fn of_surfaces_that_coincide_the_first_is_seen_everywhere() {
    let scene = overlapping();
    let frame = Poser::new(&scene).frame(0.0, &Playback::still());
    let tracer = Tracer::new(&scene, &frame);
    let (mut first, mut nearest) = (0, 0);
    for k in 0..4000 {
        let across = 1.5 * random::unit(7, 2 * k) - 0.37;
        let along = 1.8 * random::unit(7, 2 * k + 1) - 0.9;
        let (ray, aim) = onto(across, along);
        let seen = tracer.seen(&ray).expect("it hits");
        if (-0.36..0.39).contains(&across) {
            assert_eq!(seen.object, 0, "at {across} {along}");
            first += 1;
            nearest += usize::from(tracer.hit(&ray, Sides::Both).is_some_and(|h| h.object == 0));
        }
        let [b, c] = seen.b;
        let corners = tracer.corners(seen.object, seen.face);
        let met = corners[0] * (1.0 - b - c) + corners[1] * b + corners[2] * c;
        assert!(met.distance(aim) < 1e-5, "{met} is not {aim}");
    }
    assert!(nearest < first, "rounding alone would have chosen the first too: no test");
}

#[test]
fn far_from_the_origin_rays_leave_the_surface_that_they_start_on() {
    for far in [0.0, 1e3, 1e4, 1e5] {
        let scene = scene(tilted(-1.0, 1.0), &[place([far, far, -far], 0.0, [1.0; 3])]);
        let frame = Poser::new(&scene).frame(0.0, &Playback::still());
        let tracer = Tracer::new(&scene, &frame);
        assert!(tracer.offset() < 0.1);
        let normal = vec3(-0.3, -0.7, 1.0).normalize();
        let middle = DVec3::new(far, far, -far).as_vec3();
        let eye = middle + vec3(0.1, 0.2, 6.0);
        for k in 0..2000 {
            let [x, y] = [1, 2].map(|d| 1.6 * random::unit(d, k) - 0.8);
            let aim = middle + vec3(x, y, 0.3 * x + 0.7 * y);
            let direction = (aim - eye).normalize();
            let ray = Ray { origin: eye, direction, t_max: f32::INFINITY };
            let Some(hit) = tracer.hit(&ray, Sides::Both) else { continue };
            let [b, c] = hit.b;
            let [p, q, r] = tracer.corners(hit.object, hit.face);
            let met = p * (1.0 - b - c) + q * b + r * c;
            let above = normal + 0.9 * normal.any_orthonormal_vector();
            let origin = met + normal * tracer.offset();
            let away = Ray { origin, direction: above.normalize(), t_max: f32::INFINITY };
            assert!(!tracer.occluded(&away), "{far}: {met}");
        }
    }
}

/// A shining ball of radius 1 at the origin, and a small dark one at `dark`.
fn bulb_and(dark: Vec3) -> Scene {
    let mut scene = scene(sphere(16, 0.0), &[place([0.0; 3], 0.0, [1.0; 3])]);
    scene.materials =
        vec![Material { emissive: [1.0; 3], ..Material::default() }, Material::default()];
    let mut other = scene.meshes[0].clone();
    other.materials.fill(MaterialId::new(1));
    scene.meshes.push(other);
    let mesh = Some(MeshId::new(1));
    let transform = place(dark.as_dvec3().to_array(), 0.0, [0.1; 3]);
    scene.nodes.push(Node { transform, mesh, ..Node::default() });
    scene
}

/// Light from the far side of a bulb arrives through it, but not through what stands before it.
#[test]
fn what_shines_does_not_shade_itself() {
    let scene = bulb_and(vec3(2.0, 0.0, 0.0));
    let frame = Poser::new(&scene).frame(0.0, &Playback::default());
    let tracer = Tracer::new(&scene, &frame);
    let glow = Glow::of(&tracer, &Surfaces::new(&scene));
    for lamp in glow.lamps(6) {
        for (from, free) in [(vec3(3.0, 0.0, 0.0), false), (vec3(-3.0, 0.4, 0.2), true)] {
            // To the middle of the bulb, or all of it would be seen past the small one.
            let (direction, length) = (lamp.position * 0.01 - from).normalize_and_length();
            let ray = Ray { origin: from, direction, t_max: length };
            assert_eq!(glow.is_free(&tracer, &ray, &lamp), free, "{from}");
            assert!(!Glow::default().is_free(&tracer, &ray, &lamp));
        }
    }
}

/// A bulb in a black and white picture lights a floor in circles, however it is parted into small lamps.
#[test]
fn a_bulb_lights_a_floor_in_circles() {
    let scene = bulb_and(vec3(0.0, 30.0, 0.0));
    let frame = Poser::new(&scene).frame(0.0, &Playback::default());
    let glow = Glow::of(&Tracer::new(&scene, &frame), &Surfaces::new(&scene));
    let lamps = Lamps::default().with(glow);
    for radius in [8.0, 20.0] {
        let light = |k: u32| {
            let (sin, cos) = (std::f32::consts::TAU * k as f32 / 40.0).sin_cos();
            let place = vec3(radius * cos, -1.5, radius * sin);
            let arrivals = lamps.all().iter().filter_map(|l| l.arrival(place));
            arrivals.map(|a| a.strength * a.towards.y.max(0.0)).sum::<f32>()
        };
        // A ball of radius 1 lights as a point of pi candela does.
        let exact = std::f32::consts::PI * 1.5 / (1.5 * 1.5 + radius * radius).powf(1.5);
        for k in 0..40 {
            assert!((light(k) / exact - 1.0).abs() < 0.1, "{radius}, {k}: {} {exact}", light(k));
        }
    }
}

/// A double-sided bulb beside a wall shines outwards alone; the same as a dome around all that is drawn keeps both
/// sides.
#[test]
fn the_inside_of_a_bulb_does_not_count() {
    let lamp = Material { emissive: [1.0; 3], double_sided: true, ..Material::default() };
    let wall = Mesh {
        positions: vec![vec3(-0.5, -0.5, 0.0), vec3(0.5, -0.5, 0.0), vec3(0.0, 0.5, 0.0)],
        triangles: vec![[0, 1, 2]],
        materials: vec![MaterialId::new(1)],
        ..Mesh::default()
    };
    for (away, insides) in [(3.0, true), (0.2, false)] {
        let mut scene = scene(sphere(12, 0.0), &[place([0.0; 3], 0.0, [1.0; 3])]);
        scene.materials = vec![lamp.clone(), Material::default()];
        scene.meshes.push(wall.clone());
        scene.nodes.push(Node {
            transform: place([0.0, 0.0, -away], 0.0, [1.0; 3]),
            mesh: Some(MeshId::new(1)),
            ..Node::default()
        });
        let frame = Poser::new(&scene).frame(0.0, &Playback::default());
        let glow = Glow::of(&Tracer::new(&scene, &frame), &Surfaces::new(&scene));
        assert_eq!(glow.triangles().len(), scene.meshes[0].triangles.len());
        for t in glow.triangles() {
            assert_eq!(t.two_sided, !insides);
            assert!(!insides || t.normal.dot(t.corners[0]) > 0.0, "{t:?}");
        }
    }
}
