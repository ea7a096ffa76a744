//! What every scene promises.

use super::*;
use crate::{Mesh, NormalSource, Transform};
use chiaro_basis::math::Vec3;
use std::collections::BTreeMap;
use std::sync::OnceLock;

/// Every scene, made once for all tests.
fn all() -> &'static [(&'static str, Scene)] {
    static ALL: OnceLock<Vec<(&str, Scene)>> = OnceLock::new();
    ALL.get_or_init(|| names().iter().map(|n| (*n, scene(n).unwrap())).collect())
}

/// The vertices of a mesh, those at one place as one.
fn welded(mesh: &Mesh) -> Vec<[u32; 3]> {
    let mut known = BTreeMap::new();
    let place = |p: &Vec3| p.to_array().map(f32::to_bits);
    let ids: Vec<u32> = mesh
        .positions
        .iter()
        .map(|p| {
            let next = known.len() as u32;
            *known.entry(place(p)).or_insert(next)
        })
        .collect();
    mesh.triangles.iter().map(|t| t.map(|v| ids[v as usize])).collect()
}

/// Vertices minus edges plus faces of a closed manifold, or what keeps it from being one.
fn euler(triangles: &[[u32; 3]]) -> std::result::Result<i64, String> {
    let mut next: BTreeMap<u32, Vec<(u32, u32)>> = BTreeMap::new();
    let mut edges = BTreeMap::new();
    for &[a, b, c] in triangles {
        for (u, v, w) in [(a, b, c), (b, c, a), (c, a, b)] {
            next.entry(u).or_default().push((v, w));
            if edges.insert((u, v), ()).is_some() {
                return Err(format!("edge {u} {v} twice in one direction"));
            }
        }
    }
    if let Some((u, v)) = edges.keys().find(|(u, v)| !edges.contains_key(&(*v, *u))) {
        return Err(format!("edge {u} {v} has one side"));
    }
    for (vertex, fan) in &next {
        let turn: BTreeMap<u32, u32> = fan.iter().copied().collect();
        let (start, mut at, mut steps) = (fan[0].0, fan[0].0, 0);
        loop {
            at = turn[&at];
            steps += 1;
            if at == start || steps > fan.len() {
                break;
            }
        }
        if steps != fan.len() {
            return Err(format!("vertex {vertex} has two fans"));
        }
    }
    Ok(next.len() as i64 - edges.len() as i64 / 2 + triangles.len() as i64)
}

fn normals(mesh: &Mesh) -> &[Vec3] {
    match &mesh.normals {
        NormalSource::Given(normals) => normals,
        NormalSource::Faces(_) => panic!("demo meshes bring their normals"),
    }
}

/// The mesh, or what it is at time 0.
fn made(mesh: &Mesh) -> Mesh {
    mesh.remake.as_ref().map_or_else(|| mesh.clone(), |r| (r.0)(0.0))
}

fn each_mesh(mut check: impl FnMut(&str, &Mesh, &Scene)) {
    for (name, scene) in all() {
        for mesh in &scene.meshes {
            check(&format!("{name}/{}", mesh.name), &made(mesh), scene);
        }
    }
}

#[test]
fn meshes_are_whole() {
    each_mesh(|name, mesh, scene| {
        let n = mesh.positions.len();
        assert_eq!(normals(mesh).len(), n, "{name}");
        assert_eq!(mesh.materials.len(), mesh.triangles.len(), "{name}");
        assert!(mesh.materials.iter().all(|m| m.index() < scene.materials.len()), "{name}");
        assert!(mesh.positions.iter().all(|p| p.is_finite()), "{name}");
        let mut used = vec![false; n];
        mesh.triangles.as_flattened().iter().for_each(|&v| used[v as usize] = true);
        assert!(used.iter().all(|&u| u), "{name}: unused vertices");
    });
}

#[test]
fn normals_are_unit_and_on_the_side_of_their_faces() {
    let mut faults = Vec::new();
    each_mesh(|name, mesh, _| {
        let normals = normals(mesh);
        assert!(normals.iter().all(|n| n.is_normalized()), "{name}");
        let mut wrong = 0;
        for t in &mesh.triangles {
            let [a, b, c] = t.map(|v| mesh.positions[v as usize]);
            let face = (b - a).cross(c - a);
            wrong += t.iter().filter(|&&v| face.dot(normals[v as usize]) < 0.0).count();
        }
        let share = wrong as f64 / (3 * mesh.triangles.len()) as f64;
        // The tips of locks are a triangle wide, the rims of leaves no wider.
        let most = if name.starts_with("courtyard/") { 0.01 } else { 0.005 };
        if share >= most {
            faults.push(format!("{name}: {wrong} corners, {share}"));
        }
    });
    assert!(faults.is_empty(), "{faults:#?}");
}

#[test]
fn solids_are_closed_manifolds_that_wind_outwards() {
    let open = ["rocks/rocks", "plane", "wall", "floor", "ceiling", "luminaire"];
    let mut faults = Vec::new();
    each_mesh(|name, mesh, _| {
        if open.iter().any(|o| name.ends_with(o)) {
            return;
        }
        let chi = match euler(&welded(mesh)) {
            Ok(chi) => chi,
            Err(why) => return faults.push(format!("{name}: {why}")),
        };
        let expected = match name {
            "torus/torus" | "bumpy-torus/bumpy-torus" => Some(0),
            "peanut/peanut" | "golf-ball/golf-ball" => Some(2),
            _ if name.starts_with("sphere-field") => Some(2),
            _ => None,
        };
        if expected.is_some_and(|e| e != chi) {
            faults.push(format!("{name}: {chi}"));
        }
        let corner = |v: u32| mesh.positions[v as usize].as_dvec3();
        let volume = |t: &[u32; 3]| corner(t[0]).dot(corner(t[1]).cross(corner(t[2])));
        if mesh.triangles.iter().map(volume).sum::<f64>() <= 0.0 {
            faults.push(format!("{name} is inside out"));
        }
    });
    assert!(faults.is_empty(), "{faults:#?}");
}

#[test]
fn no_triangle_is_degenerate() {
    let mut faults = Vec::new();
    each_mesh(|name, mesh, _| {
        let flat = |t: &&[u32; 3]| {
            let [a, b, c] = t.map(|v| mesh.positions[v as usize].as_dvec3());
            let longest = (b - a).length().max((c - b).length()).max((a - c).length());
            (b - a).cross(c - a).length() <= 1e-6 * longest * longest
        };
        let count = mesh.triangles.iter().filter(flat).count();
        if count > 0 {
            faults.push(format!("{name}: {count} of {}", mesh.triangles.len()));
        }
    });
    assert!(faults.is_empty(), "{faults:#?}");
}

/// Where everything is at a time.
fn places(scene: &Scene, time: f64) -> Vec<Vec3> {
    let playback = scene.playback(&crate::Choice::default()).unwrap().0;
    let frame = scene.frame(time, &playback);
    frame.objects.iter().flat_map(|o| frame.world_positions(o).step_by(7)).collect()
}

#[test]
fn films_end_as_they_begin_and_move_between() {
    // These end turned by a symmetry of theirs, which their own tests check.
    let symmetric = ["torus", "bumpy-torus", "peanut", "golf-ball"];
    for (name, scene) in all() {
        let moves = !scene.clips.is_empty() || scene.meshes.iter().any(|m| m.remake.is_some());
        if !moves || symmetric.contains(name) {
            continue;
        }
        let [start, middle, end] = [0.0, 0.7, motion::SECONDS].map(|t| places(scene, t));
        assert!(start.len() == end.len(), "{name}");
        let far = start.iter().zip(&end).map(|(a, b)| a.distance(*b)).fold(0.0, f32::max);
        assert!(far < 1e-4, "{name}: {far}");
        assert!(start != middle, "{name} stands still");
    }
}

#[test]
fn nodes_refer_to_what_is_there_and_parents_come_first() {
    for (name, scene) in all() {
        for (i, node) in scene.nodes.iter().enumerate() {
            assert!(node.parent.is_none_or(|p| p.index() < i), "{name}");
            assert!(node.mesh.is_none_or(|m| m.index() < scene.meshes.len()), "{name}");
            assert!(node.skin.is_none_or(|s| s.index() < scene.skins.len()), "{name}");
        }
        let cameras = scene.cameras.iter().map(|c| c.node);
        let lights = scene.lights.iter().map(|l| l.node);
        let moved = scene.clips.iter().flat_map(|c| &c.channels).map(|c| c.node);
        assert!(cameras.chain(lights).chain(moved).all(|n| n.index() < scene.nodes.len()));
    }
}

/// Triangles as drawn, copies counted.
fn drawn(scene: &Scene) -> usize {
    let of = |n: &crate::Node| {
        let mesh = n.mesh.map_or(0, |m| made(&scene.meshes[m.index()]).triangles.len());
        mesh * n.instances.len().max(1)
    };
    scene.nodes.iter().map(of).sum()
}

#[test]
fn triangle_counts_are_as_promised() {
    for (name, scene) in all() {
        let count = drawn(scene);
        let range = match *name {
            "sphere-field" | "sphere-field-smooth" => 512_000..=512_010,
            "cornell-box" => 1_000..=10_000,
            "courtyard" => 600_000..=1_200_000,
            _ => 20_000..=200_000,
        };
        assert!(range.contains(&count), "{name}: {count}");
    }
}

/// Every number of a scene's geometry and motion.
fn bits(scene: &Scene) -> Vec<u32> {
    let mut bits = Vec::new();
    let mut put = |x: &[f32]| bits.extend(x.iter().map(|x| x.to_bits()));
    for mesh in scene.meshes.iter().map(made) {
        put(bytemuck::cast_slice(&mesh.positions));
        put(bytemuck::cast_slice(normals(&mesh)));
        put(bytemuck::cast_slice(&mesh.triangles));
    }
    for channel in scene.clips.iter().flat_map(|c| &c.channels) {
        put(&channel.track.values);
    }
    let all = scene.nodes.iter().flat_map(|n| std::iter::once(&n.transform).chain(&n.instances));
    for matrix in all.map(Transform::matrix) {
        put(&matrix.to_cols_array().map(|x| x as f32));
    }
    bits
}

#[test]
fn the_same_bytes_come_from_any_number_of_threads() {
    let three = rayon::ThreadPoolBuilder::new().num_threads(3).build().unwrap();
    for (name, first) in all() {
        let again = three.install(|| scene(name).unwrap());
        assert!(bits(first) == bits(&again), "{name}");
    }
}

#[test]
fn motion_lasts_two_seconds_at_24_frames_a_second() {
    for (name, scene) in all() {
        for clip in &scene.clips {
            for channel in &clip.channels {
                let track = &channel.track;
                assert_eq!(track.times.len() * track.width, track.values.len(), "{name}");
                assert_eq!(track.times[1], 1.0 / 24.0, "{name}");
                assert_eq!(track.times.last(), Some(&2.0), "{name}");
            }
        }
    }
}

#[test]
fn unknown_names_and_sizes_say_what_would_do() {
    let message = |name: &str| scene(name).unwrap_err().to_string();
    assert!(message("bumpy-tours").contains("did you mean bumpy-torus?"));
    assert!(message("qqqqqqqq").contains("golf-ball"));
    assert!(message("torus:3").contains("takes no size"));
    assert!(message("rocks:0").contains("rocks:1 to rocks:16"));
    assert!(message("rocks:two").contains("rocks:1 to rocks:16"));
    assert!(drawn(&scene("rocks:2").unwrap()) < drawn(&scene("rocks").unwrap()));
}
