//! Sharp edges, by the angle in a pose or by the normals of the file; and flat triangles.

use super::Topology;
use crate::{Mesh, NormalSource};
use chiaro_basis::math::Vec3;
use rayon::prelude::*;

/// A triangle counts as flat when its height is below this share of its longest side.
pub const FLAT: f32 = 1e-6;

/// For each edge, whether the surface bends there by more than `angle` radians in a pose (one
/// position a vertex of the mesh).
///
/// Borders are no creases; edges where more than two triangles meet always are. Triangles without
/// area have no direction and crease nothing.
pub fn by_angle(topology: &Topology, positions: &[Vec3], angle: f32) -> Vec<bool> {
    let normals = face_normals(topology, positions);
    let limit = angle.cos();
    let creased = |edge: usize| match *topology.sides(edge) {
        [_] => false,
        [a, b] => match (normals[a.face()], normals[b.face()]) {
            (Some(m), Some(n)) => {
                let turned = if topology.is_consistent(edge) { n } else { -n };
                m.dot(turned) < limit
            }
            _ => false,
        },
        _ => true,
    };
    (0..topology.edges.len()).into_par_iter().map(creased).collect()
}

/// For each edge, whether the file keeps it hard: at one of its ends at least, the normals of the
/// triangles on both sides are more than `angle` radians apart, or belong to different groups if
/// they come from faces. It holds for the whole animation. Borders are not hard; edges where more
/// than two triangles meet are.
pub fn by_normals(topology: &Topology, mesh: &Mesh, angle: f32) -> Vec<bool> {
    let limit = angle.cos();
    let apart = |v: u32, w: u32| match &mesh.normals {
        NormalSource::Given(normals) => match (normals.get(v as usize), normals.get(w as usize)) {
            (Some(m), Some(n)) => v != w && m.dot(*n) < limit,
            _ => false,
        },
        NormalSource::Faces(groups) => groups[v as usize] != groups[w as usize],
    };
    let hard = |edge: usize| match *topology.sides(edge) {
        [_] => false,
        [a, b] => {
            let ends = |s: super::Side| {
                let at = |s: super::Side| mesh.triangles[s.face()][s.corner()];
                [at(s), at(s.next())]
            };
            let ([a0, a1], [b0, b1]) = (ends(a), ends(b));
            if topology.start(a) == topology.start(b) {
                apart(a0, b0) || apart(a1, b1)
            } else {
                apart(a0, b1) || apart(a1, b0)
            }
        }
        _ => true,
    };
    (0..topology.edges.len()).into_par_iter().map(hard).collect()
}

/// Triangles without area in a pose, collapsed ones included, rising: those thinner than [`FLAT`].
pub fn flat(topology: &Topology, positions: &[Vec3]) -> Vec<u32> {
    let normals = face_normals(topology, positions);
    (0..normals.len() as u32).filter(|&f| normals[f as usize].is_none()).collect()
}

/// Unit normals of the triangles that have an area.
fn face_normals(topology: &Topology, positions: &[Vec3]) -> Vec<Option<Vec3>> {
    let normal = |t: &[u32; 3]| {
        let [a, b, c] = t.map(|v| positions[topology.weld.first[v as usize] as usize].as_dvec3());
        let (u, v, w) = (b - a, c - b, a - c);
        let longest = u.length_squared().max(v.length_squared()).max(w.length_squared());
        let cross = u.cross(v);
        let thick = cross.length() > f64::from(FLAT) * longest;
        thick.then(|| cross.normalize().as_vec3())
    };
    topology.triangles.par_iter().map(normal).collect()
}
