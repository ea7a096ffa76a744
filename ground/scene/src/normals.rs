//! Shading normals for meshes whose file has none.
//!
//! Vertices at one place are split into groups along creases, so that each vertex has one normal;
//! a group's normal is the angle-weighted mean of its faces, found anew for every deformation.

use crate::{Mesh, NormalSource};
use chiaro_basis::math::Vec3;
use rayon::prelude::*;
use std::collections::HashMap;

/// Unit normals, one a vertex, of deformed faces: angle-weighted means over the faces at vertices of
/// one group. Faces without area count nothing; a vertex without any gets +z.
pub fn of_faces(positions: &[Vec3], triangles: &[[u32; 3]], groups: &[u32]) -> Vec<Vec3> {
    let corners: Vec<[Vec3; 3]> =
        triangles.par_iter().map(|t| corner_normals(t.map(|v| positions[v as usize]))).collect();
    let mut sums = vec![Vec3::ZERO; positions.len()];
    for (t, corner) in triangles.iter().zip(&corners) {
        for (v, n) in t.iter().zip(corner) {
            sums[groups[*v as usize] as usize] += *n;
        }
    }
    groups.par_iter().map(|&g| sums[g as usize].normalize_or(Vec3::Z)).collect()
}

/// The face's unit normal times its angle, at each corner.
fn corner_normals(p: [Vec3; 3]) -> [Vec3; 3] {
    let Some(normal) = (p[1] - p[0]).cross(p[2] - p[0]).try_normalize() else {
        return [Vec3::ZERO; 3];
    };
    std::array::from_fn(|i| {
        let (a, b) = (p[(i + 1) % 3] - p[i], p[(i + 2) % 3] - p[i]);
        normal * a.cross(b).length().atan2(a.dot(b))
    })
}

/// Gives a mesh normals from its faces, smooth but for creases sharper than `crease` radians:
/// vertices are split where their faces bend more. `smoothing`, if not empty, has a group number a
/// triangle and replaces the angle: faces of different groups, and of group 0, are not smoothed.
pub fn smooth(mesh: &mut Mesh, crease: f32, smoothing: &[u32]) {
    let places = places(&mesh.positions);
    let normals: Vec<Vec3> = mesh
        .triangles
        .par_iter()
        .map(|t| {
            let [a, b, c] = t.map(|v| mesh.positions[v as usize]);
            (b - a).cross(c - a).normalize_or_zero()
        })
        .collect();
    let fans = fans(&mesh.triangles, &places);
    let limit = crease.cos();
    let joined = |f: usize, g: usize| match smoothing.get(f) {
        Some(&s) => s != 0 && smoothing.get(g) == Some(&s),
        None => normals[f].dot(normals[g]) >= limit || normals[f] == Vec3::ZERO,
    };
    let mut split = Split::default();
    let corners = cluster_corners(mesh, &fans, joined);
    for (face, clusters) in corners.iter().enumerate() {
        for (corner, cluster) in clusters.iter().enumerate() {
            let old = mesh.triangles[face][corner];
            mesh.triangles[face][corner] = split.vertex(old, *cluster);
        }
    }
    split.apply(mesh);
}

/// For each vertex the lowest vertex at the same place.
pub(crate) fn places(positions: &[Vec3]) -> Vec<u32> {
    let mut first: HashMap<[u32; 3], u32> = HashMap::with_capacity(positions.len());
    positions
        .iter()
        .enumerate()
        // Adding zero makes the two zeros one.
        .map(|(i, p)| {
            *first.entry((*p + Vec3::ZERO).to_array().map(f32::to_bits)).or_insert(i as u32)
        })
        .collect()
}

/// The (face, corner) pairs at each place, as offsets into one list.
struct Fans {
    start: Vec<u32>,
    corners: Vec<(u32, u8)>,
}

impl Fans {
    fn at(&self, place: usize) -> &[(u32, u8)] {
        &self.corners[self.start[place] as usize..self.start[place + 1] as usize]
    }
}

fn fans(triangles: &[[u32; 3]], places: &[u32]) -> Fans {
    let mut start = vec![0u32; places.len() + 1];
    for v in triangles.iter().flatten() {
        start[places[*v as usize] as usize + 1] += 1;
    }
    for i in 0..places.len() {
        start[i + 1] += start[i];
    }
    let mut next = start.clone();
    let mut corners = vec![(0, 0); 3 * triangles.len()];
    for (f, t) in triangles.iter().enumerate() {
        for (c, v) in t.iter().enumerate() {
            let place = places[*v as usize] as usize;
            corners[next[place] as usize] = (f as u32, c as u8);
            next[place] += 1;
        }
    }
    Fans { start, corners }
}

/// For each corner of each face the lowest corner number of its smooth cluster at that place: faces
/// that share an edge and are joined are in one cluster.
fn cluster_corners(
    mesh: &Mesh,
    fans: &Fans,
    joined: impl Fn(usize, usize) -> bool + Sync,
) -> Vec<[u32; 3]> {
    let places = places(&mesh.positions);
    let place_of = |f: u32, c: usize| places[mesh.triangles[f as usize][c] as usize];
    let clusters: Vec<Vec<((u32, u8), u32)>> = (0..fans.start.len() - 1)
        .into_par_iter()
        .map(|place| {
            let fan = fans.at(place);
            let mut parent: Vec<usize> = (0..fan.len()).collect();
            // Spokes: the two other places of each face; faces with a common spoke are neighbours.
            let mut spokes: Vec<(u32, usize)> = (0..fan.len())
                .flat_map(|i| {
                    let (f, c) = fan[i];
                    let c = usize::from(c);
                    [(place_of(f, (c + 1) % 3), i), (place_of(f, (c + 2) % 3), i)]
                })
                .collect();
            spokes.sort_unstable();
            for pair in spokes.windows(2) {
                let ((a, i), (b, j)) = (pair[0], pair[1]);
                if a == b && joined(fan[i].0 as usize, fan[j].0 as usize) {
                    unite(&mut parent, i, j);
                }
            }
            (0..fan.len())
                .map(|i| {
                    let (f, c) = fan[root(&mut parent, i)];
                    (fan[i], 3 * f + u32::from(c))
                })
                .collect()
        })
        .collect();
    let mut result = vec![[0u32; 3]; mesh.triangles.len()];
    for ((f, c), cluster) in clusters.into_iter().flatten() {
        result[f as usize][usize::from(c)] = cluster;
    }
    result
}

fn unite(parent: &mut [usize], a: usize, b: usize) {
    let (a, b) = (root(parent, a), root(parent, b));
    parent[a.max(b)] = a.min(b);
}

fn root(parent: &mut [usize], mut i: usize) -> usize {
    while parent[i] != i {
        parent[i] = parent[parent[i]];
        i = parent[i];
    }
    i
}

/// New vertices: one for each (old vertex, cluster) pair, in order of first use.
#[derive(Default)]
struct Split {
    index: HashMap<(u32, u32), u32>,
    old: Vec<u32>,
    clusters: Vec<u32>,
}

impl Split {
    fn vertex(&mut self, old: u32, cluster: u32) -> u32 {
        *self.index.entry((old, cluster)).or_insert_with(|| {
            self.old.push(old);
            self.clusters.push(cluster);
            self.old.len() as u32 - 1
        })
    }

    fn apply(self, mesh: &mut Mesh) {
        let take = &self.old;
        pick(&mut mesh.positions, take);
        pick(&mut mesh.tangents, take);
        pick(&mut mesh.colours, take);
        mesh.uvs.iter_mut().for_each(|uv| pick(uv, take));
        mesh.influences.joints.iter_mut().for_each(|j| pick(j, take));
        mesh.influences.weights.iter_mut().for_each(|w| pick(w, take));
        for morph in &mut mesh.morphs {
            pick(&mut morph.positions, take);
            pick(&mut morph.normals, take);
            pick(&mut morph.tangents, take);
        }
        let mut number: HashMap<u32, u32> = HashMap::new();
        let groups = self
            .clusters
            .iter()
            .enumerate()
            .map(|(i, c)| *number.entry(*c).or_insert(i as u32))
            .collect();
        mesh.normals = NormalSource::Faces(groups);
    }
}

fn pick<T: Clone>(values: &mut Vec<T>, take: &[u32]) {
    if !values.is_empty() {
        *values = take.iter().map(|&i| values[i as usize].clone()).collect();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::MaterialId;
    use chiaro_basis::math::vec3;

    /// A roof of two faces that bend by `angle` at the ridge along z.
    fn roof(angle: f32) -> Mesh {
        let (s, c) = (0.5 * angle).sin_cos();
        Mesh {
            positions: vec![
                vec3(0.0, 0.0, 0.0),
                vec3(0.0, 0.0, 1.0),
                vec3(c, -s, 0.0),
                vec3(-c, -s, 0.0),
            ],
            triangles: vec![[0, 1, 2], [1, 0, 3]],
            materials: vec![MaterialId::new(0); 2],
            ..Mesh::default()
        }
    }

    fn normals(mesh: &Mesh) -> Vec<Vec3> {
        let NormalSource::Faces(groups) = &mesh.normals else { panic!("groups were made") };
        of_faces(&mesh.positions, &mesh.triangles, groups)
    }

    #[test]
    fn a_gentle_ridge_is_smooth_and_a_sharp_one_is_split() {
        let mut gentle = roof(0.5);
        smooth(&mut gentle, 0.7, &[]);
        assert_eq!(gentle.positions.len(), 4);
        assert!(normals(&gentle)[0].distance(Vec3::Y) < 1e-5);
        let mut sharp = roof(1.0);
        smooth(&mut sharp, 0.7, &[]);
        assert_eq!(sharp.positions.len(), 6);
        assert!(normals(&sharp).iter().all(|n| n.distance(Vec3::Y) > 0.4));
    }

    #[test]
    fn smoothing_groups_replace_the_angle() {
        let mut mesh = roof(1.0);
        smooth(&mut mesh, 0.7, &[1, 1]);
        assert_eq!(mesh.positions.len(), 4);
        let mut mesh = roof(0.1);
        smooth(&mut mesh, 0.7, &[1, 2]);
        assert_eq!(mesh.positions.len(), 6);
    }

    #[test]
    fn vertices_at_one_place_share_a_normal_across_seams() {
        let mut mesh = roof(0.5);
        mesh.positions.extend([mesh.positions[0], mesh.positions[1]]);
        mesh.triangles[1] = [5, 4, 3];
        smooth(&mut mesh, 0.7, &[]);
        assert!(normals(&mesh)[0].distance(Vec3::Y) < 1e-5);
    }
}
