//! Small meshes as scenes.

#![allow(dead_code, reason = "each test file uses some of them")]

use chiaro_basis::math::{Quat, Vec3, vec3};
use chiaro_lines::{CreaseRule, Detail, Surface, View};
use chiaro_scene::{
    Frame, Material, MaterialId, Mesh, MeshId, Node, NormalSource, Playback, Pose, Projection,
    Scene,
};

/// A scene of one mesh whose normals come from its faces; `hard`: every face has its own.
pub(crate) fn scene(positions: Vec<Vec3>, triangles: Vec<[u32; 3]>, hard: bool) -> Scene {
    let groups = (0..positions.len() as u32).collect();
    let normals = if hard { NormalSource::Given(Vec::new()) } else { NormalSource::Faces(groups) };
    let mesh = Mesh {
        materials: vec![MaterialId::new(0); triangles.len()],
        positions,
        normals,
        triangles,
        ..Mesh::default()
    };
    Scene {
        meshes: vec![mesh],
        materials: vec![Material::default()],
        nodes: vec![Node { mesh: Some(MeshId::new(0)), ..Node::default() }],
        ..Scene::default()
    }
}

/// A scene of one mesh whose triangles share no vertices, as files without normals come: `flat`
/// ones each have a normal of their own, others those of the places where they meet.
pub(crate) fn soup(positions: &[Vec3], triangles: &[[u32; 3]], flat: bool) -> Scene {
    let corners: Vec<u32> = triangles.iter().flatten().copied().collect();
    let apart = corners.iter().map(|v| positions[*v as usize]).collect();
    let count = triangles.len() as u32;
    let mut scene =
        scene(apart, (0..count).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect(), false);
    if !flat {
        scene.meshes[0].normals = NormalSource::Faces(corners);
    }
    scene
}

/// The surface of a coarse shape, with the facets that the file shades.
pub(crate) fn faceted(scene: &Scene, levels: u8) -> Surface {
    let detail = Detail { levels, facets: true };
    Surface::refined(scene, &frame(scene), &SHARP, &[detail])
}

pub(crate) fn frame(scene: &Scene) -> Frame {
    scene.frame(0.0, &Playback::still())
}

/// The frame with its world positions changed.
pub(crate) fn moved(frame: &Frame, to: impl Fn(Vec3) -> Vec3) -> Frame {
    let mut frame = frame.clone();
    for shape in &mut frame.shapes {
        shape.positions = shape.positions.iter().map(|p| to(*p)).collect();
    }
    frame
}

pub(crate) fn turned(frame: &Frame, axis: Vec3, degrees: f32) -> Frame {
    let q = Quat::from_axis_angle(axis.normalize(), degrees.to_radians());
    moved(frame, |p| q * p)
}

pub(crate) const SHARP: CreaseRule = CreaseRule { angle: 0.7, smooth_angle: 1.3 };
pub(crate) const SMOOTH: CreaseRule = CreaseRule { angle: 4.0, smooth_angle: 4.0 };

pub(crate) fn surface(scene: &Scene, rule: &CreaseRule) -> Surface {
    Surface::of(scene, &frame(scene), rule)
}

pub(crate) fn view(from: Vec3) -> View {
    let projection = Projection::Perspective { fov_y: 0.7 };
    View::new(Pose::look_at(from, Vec3::ZERO, vec3(0.1, 1.0, 0.2), projection), (320, 240))
}

pub(crate) fn flat_view(from: Vec3) -> View {
    let projection = Projection::Orthographic { half_height: 2.0 };
    View::new(Pose::look_at(from, Vec3::ZERO, vec3(0.1, 1.0, 0.2), projection), (320, 240))
}

pub(crate) fn cube() -> (Vec<Vec3>, Vec<[u32; 3]>) {
    let corner = |i: u32| {
        let s = |bit: u32| if i >> bit & 1 == 1 { 1.0 } else { -1.0 };
        vec3(s(0), s(1), s(2))
    };
    let quads =
        [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let triangles = quads.iter().flat_map(|q: &[u32; 4]| [[q[0], q[1], q[2]], [q[0], q[2], q[3]]]);
    ((0..8).map(corner).collect(), triangles.collect())
}

/// A torus of `n` by `m` quads in two triangles each, tube radius 0.4 and dented.
pub(crate) fn torus(n: u32, m: u32, dents: f32) -> (Vec<Vec3>, Vec<[u32; 3]>) {
    let tau = std::f32::consts::TAU;
    let point = |i: u32, j: u32| {
        let (u, v) = (tau * i as f32 / n as f32, tau * j as f32 / m as f32);
        let r = 0.4 * (1.0 + dents * (5.0 * u).sin() * (3.0 * v + u).cos());
        vec3((1.0 + r * v.cos()) * u.cos(), r * v.sin(), (1.0 + r * v.cos()) * u.sin())
    };
    let positions = (0..n * m).map(|k| point(k / m, k % m)).collect();
    let id = |i: u32, j: u32| (i % n) * m + j % m;
    let cells = (0..n).flat_map(|i| (0..m).map(move |j| (i, j)));
    let triangles = cells.flat_map(|(i, j)| {
        let [a, b, c, d] = [id(i, j), id(i + 1, j), id(i + 1, j + 1), id(i, j + 1)];
        [[a, c, b], [a, d, c]]
    });
    (positions, triangles.collect())
}

/// A wavy sheet of `n` by `n` quads.
pub(crate) fn sheet(n: u32, wave: f32) -> (Vec<Vec3>, Vec<[u32; 3]>) {
    let side = n + 1;
    let point = |k: u32| {
        let (x, y) = ((k % side) as f32 / n as f32 - 0.5, (k / side) as f32 / n as f32 - 0.5);
        vec3(2.0 * x, wave * (7.0 * x).sin() * (5.0 * y).cos(), 2.0 * y)
    };
    let cells = (0..n).flat_map(|i| (0..n).map(move |j| i * side + j));
    let triangles = cells.flat_map(|a| [[a, a + side, a + side + 1], [a, a + side + 1, a + 1]]);
    ((0..side * side).map(point).collect(), triangles.collect())
}

/// A ball of radius 1 with `n` rings of twice as many quads, in triangles.
pub(crate) fn ball(n: u32) -> (Vec<Vec3>, Vec<[u32; 3]>) {
    let pi = std::f32::consts::PI;
    let mut positions = vec![Vec3::Y, Vec3::NEG_Y];
    for i in 1..n {
        let (height, around) = (i as f32 * pi / n as f32, pi / n as f32);
        let at = |j: u32| {
            let (z, x) = (j as f32 * around).sin_cos();
            vec3(height.sin() * x, height.cos(), height.sin() * z)
        };
        positions.extend((0..2 * n).map(at));
    }
    let at = |i: u32, j: u32| match i {
        0 => 0,
        i if i == n => 1,
        i => 2 + (i - 1) * 2 * n + j % (2 * n),
    };
    let quads = (0..n).flat_map(|i| (0..2 * n).map(move |j| (i, j)));
    let halves = quads.flat_map(|(i, j)| {
        let [a, b, c, d] = [at(i, j), at(i, j + 1), at(i + 1, j), at(i + 1, j + 1)];
        [[a, b, c], [b, d, c]]
    });
    (positions, halves.filter(|t| t[0] != t[1] && t[1] != t[2] && t[2] != t[0]).collect())
}
