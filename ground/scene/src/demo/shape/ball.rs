//! Spheres with even triangles.

use super::form::Form;
use chiaro_basis::math::{Vec3, vec3};
use std::collections::BTreeMap;

/// The unit sphere from an icosahedron whose edges are cut in `pieces`: 20 pieces² triangles,
/// 10 pieces² + 2 vertices.
pub(crate) fn ball(pieces: usize) -> Form {
    let (corners, faces) = icosahedron();
    let mut known: BTreeMap<[(usize, u32); 3], u32> = BTreeMap::new();
    let mut positions: Vec<Vec3> = Vec::new();
    let mut triangles = Vec::new();
    for face in faces {
        // A vertex is known by its corners and their weights, the same from every face.
        let mut vertex = |i: usize, j: usize| {
            let mut key = [(pieces - i - j, face[0]), (i, face[1]), (j, face[2])];
            key.iter_mut().filter(|k| k.0 == 0).for_each(|k| k.1 = 0);
            key.sort_unstable();
            *known.entry(key).or_insert_with(|| {
                let sum: Vec3 = key.iter().map(|&(w, c)| corners[c as usize] * w as f32).sum();
                positions.push(sum.normalize());
                positions.len() as u32 - 1
            })
        };
        for (i, j) in (0..pieces).flat_map(|i| (0..pieces - i).map(move |j| (i, j))) {
            triangles.push([vertex(i, j), vertex(i + 1, j), vertex(i, j + 1)]);
            if i + j + 1 < pieces {
                triangles.push([vertex(i + 1, j), vertex(i + 1, j + 1), vertex(i, j + 1)]);
            }
        }
    }
    Form { normals: positions.clone(), positions, triangles }
}

/// Corners on the unit sphere, and faces that wind outwards.
fn icosahedron() -> (Vec<Vec3>, Vec<[u32; 3]>) {
    let golden = 0.5 * (1.0 + 5f32.sqrt());
    let mut corners = Vec::new();
    for (x, y) in [(1.0, golden), (1.0, -golden), (-1.0, golden), (-1.0, -golden)] {
        corners.extend([vec3(0.0, x, y), vec3(x, y, 0.0), vec3(y, 0.0, x)].map(Vec3::normalize));
    }
    let edge = 2.0 / (1.0 + golden * golden).sqrt();
    let near = |i: usize, j: usize| (corners[i].distance(corners[j]) - edge).abs() < 1e-3;
    let mut faces = Vec::new();
    for i in 0..12 {
        for j in (i..12).filter(|&j| near(i, j)) {
            for k in (j..12).filter(|&k| near(j, k) && near(i, k)) {
                let [a, b, c] = [corners[i], corners[j], corners[k]];
                let outwards = a.dot((b - a).cross(c - a)) > 0.0;
                let [i, j, k] = [i as u32, j as u32, k as u32];
                faces.push(if outwards { [i, j, k] } else { [i, k, j] });
            }
        }
    }
    (corners, faces)
}
