//! Shading normals for meshes whose file has none, or not enough of them.
//!
//! Vertices at one place are split into groups along creases, so that each vertex has one normal;
//! a group's normal is the mean of its faces' normals weighted by their angles there (Thürmer and
//! Wüthrich 1998), found anew for every deformation.
//!
//! 1. Vertices with the same position, as at texture seams, count as one place.
//! 2. The faces around a place fall into clusters: neighbours across an edge that is no crease.
//! 3. A vertex whose faces lie in several clusters is split; vertices of a cluster form a group.
//!
//! Guaranteed: unit normals, never NaN, for any input; the same bytes for any number of threads.
//! Not guaranteed: that the faces of a mesh agree on which side is out.

mod cluster;
mod split;

use crate::{Mesh, NormalSource};
use chiaro_basis::math::{DVec3, Vec3};
use rayon::prelude::*;

/// Faces that bend less are smoothed where a file says nothing: 40 degrees, in radians. Scans look
/// smooth, machined edges stay crisp.
pub const CREASE: f32 = 0.698_131_7;

/// Unit normals, one a vertex, of deformed faces: angle-weighted means over the faces at vertices of
/// one group. Faces without area count nothing; a vertex without any other gets +z. `groups` has one
/// index a vertex, each below the number of vertices.
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
fn corner_normals(points: [Vec3; 3]) -> [Vec3; 3] {
    let p = points.map(Vec3::as_dvec3);
    let across = (p[1] - p[0]).cross(p[2] - p[0]);
    let Some(normal) = across.try_normalize() else {
        return [Vec3::ZERO; 3];
    };
    // Twice the area is the same at each corner: the length of the cross product.
    let area = across.length();
    std::array::from_fn(|i| {
        let (a, b) = (p[(i + 1) % 3] - p[i], p[(i + 2) % 3] - p[i]);
        (normal * area.atan2(a.dot(b))).as_vec3()
    })
}

/// The unit normal of a face, or zero when it has no area.
fn face_normal(positions: &[Vec3], triangle: [u32; 3]) -> Vec3 {
    let [a, b, c]: [DVec3; 3] = triangle.map(|v| positions[v as usize].as_dvec3());
    (b - a).cross(c - a).normalize_or_zero().as_vec3()
}

/// Gives a mesh normals from its faces, smooth but for creases sharper than `crease` radians:
/// vertices are split where their faces bend more, and keep their number where they are not.
/// `smoothing`, if not empty, has a group number a triangle and replaces the angle: faces of
/// different groups, and of group 0, are not smoothed. Hands back, for each vertex of the new mesh,
/// the vertex that it was.
pub fn smooth(mesh: &mut Mesh, crease: f32, smoothing: &[u32]) -> Vec<u32> {
    let normals: Vec<Vec3> =
        mesh.triangles.par_iter().map(|t| face_normal(&mesh.positions, *t)).collect();
    let places = places(&mesh.positions);
    let fans = cluster::fans(&mesh.triangles, &places);
    let clusters = cluster::clusters(&fans, &normals, crease.cos(), smoothing);
    let split = split::split(&mut mesh.triangles, &fans, &clusters, mesh.positions.len());
    if split.source.len() > mesh.positions.len() {
        mesh.pick(&split.source);
    }
    mesh.normals = NormalSource::Faces(split.groups);
    split.source
}

/// Makes the normals of a mesh whole that holds those of its file as they are, or none: unit
/// vectors where they are directions, made by [`smooth`] at the [`CREASE`] where they are not (zero,
/// NaN, missing).
pub(crate) fn finish(mesh: &mut Mesh, smoothing: &[u32]) {
    let known: Vec<Option<Vec3>> = match &mesh.normals {
        NormalSource::Given(normals) => normals.iter().map(|n| n.try_normalize()).collect(),
        NormalSource::Faces(_) => return,
    };
    if known.iter().all(Option::is_none) {
        smooth(mesh, CREASE, smoothing);
    } else if let Some(all) = known.iter().copied().collect() {
        mesh.normals = NormalSource::Given(all);
    } else {
        let source = smooth(mesh, CREASE, smoothing);
        let normals = match &mesh.normals {
            NormalSource::Faces(groups) => of_faces(&mesh.positions, &mesh.triangles, groups),
            NormalSource::Given(normals) => normals.clone(),
        };
        let whole = source.iter().zip(normals).map(|(&v, n)| known[v as usize].unwrap_or(n));
        mesh.normals = NormalSource::Given(whole.collect());
    }
}

/// For each vertex the lowest vertex at exactly the same place.
pub(crate) fn places(positions: &[Vec3]) -> Vec<u32> {
    // Sorting, unlike hashing, has no bad case that a file could be made for.
    let mut order: Vec<([u32; 3], u32)> = positions
        .par_iter()
        .enumerate()
        // Adding zero makes the two zeros one.
        .map(|(i, p)| ((*p + Vec3::ZERO).to_array().map(f32::to_bits), i as u32))
        .collect();
    order.par_sort_unstable();
    let mut places = vec![0; positions.len()];
    for run in order.chunk_by(|a, b| a.0 == b.0) {
        run.iter().for_each(|(_, v)| places[*v as usize] = run[0].1);
    }
    places
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::MaterialId;
    use chiaro_basis::math::{Vec2, vec3};

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
        assert_eq!(smooth(&mut sharp, 0.7, &[]), [0, 1, 2, 3, 0, 1]);
        assert_eq!(sharp.positions.len(), 6);
        assert!(normals(&sharp).iter().all(|n| n.distance(Vec3::Y) > 0.4));
    }

    #[test]
    fn smoothing_groups_replace_the_angle() {
        let vertices = |angle: f32, groups: &[u32]| {
            let mut mesh = roof(angle);
            smooth(&mut mesh, 0.7, groups);
            mesh.positions.len()
        };
        assert_eq!(vertices(1.0, &[1, 1]), 4);
        assert_eq!(vertices(0.1, &[1, 2]), 6);
        assert_eq!(vertices(0.1, &[0, 0]), 6);
    }

    #[test]
    fn vertices_at_one_place_share_a_normal_across_seams() {
        let mut mesh = roof(0.5);
        mesh.positions.extend([mesh.positions[0], mesh.positions[1]]);
        mesh.triangles[1] = [5, 4, 3];
        mesh.uvs = vec![(0..6).map(|i| Vec2::splat(i as f32)).collect()];
        smooth(&mut mesh, 0.7, &[]);
        assert_eq!(mesh.uvs[0].len(), 6);
        assert!(normals(&mesh)[..2].iter().all(|n| n.distance(Vec3::Y) < 1e-5));
        assert_eq!(normals(&mesh)[0], normals(&mesh)[4]);
    }

    #[test]
    fn attributes_follow_their_vertices() {
        let mut mesh = roof(1.0);
        mesh.uvs = vec![(0..4).map(|i| Vec2::splat(i as f32)).collect()];
        let source = smooth(&mut mesh, 0.7, &[]);
        let uvs: Vec<u32> = mesh.uvs[0].iter().map(|uv| uv.x as u32).collect();
        assert_eq!(uvs, source);
    }

    #[test]
    fn a_cube_has_three_normals_at_each_corner() {
        let positions = (0..8).map(|i| vec3((i & 1) as f32, (i >> 1 & 1) as f32, (i >> 2) as f32));
        let quads: [[u32; 4]; 6] =
            [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let mut mesh = Mesh {
            positions: positions.collect(),
            triangles: quads
                .iter()
                .flat_map(|q| [[q[0], q[1], q[2]], [q[0], q[2], q[3]]])
                .collect(),
            ..Mesh::default()
        };
        smooth(&mut mesh, CREASE, &[]);
        assert_eq!(mesh.positions.len(), 24);
        for (n, p) in normals(&mesh).iter().zip(&mesh.positions) {
            assert!(n.abs().max_element() > 0.999_99 && n.dot(*p - Vec3::splat(0.5)) > 0.4);
        }
    }

    #[test]
    fn faces_without_area_neither_part_nor_join_others() {
        // A ridge whose edge is doubled, with flat triangles in between.
        for (angle, vertices) in [(0.5, 4), (1.0, 6)] {
            let mut mesh = roof(angle);
            mesh.triangles.extend([[0, 1, 1], [0, 0, 1], [0, 0, 0]]);
            smooth(&mut mesh, 0.7, &[]);
            assert_eq!(mesh.positions.len(), vertices);
        }
    }

    #[test]
    fn nothing_is_nan() {
        let mut mesh = Mesh {
            positions: vec![Vec3::ZERO, Vec3::ONE, Vec3::splat(1e-30), vec3(0.0, 1e30, 0.0)],
            triangles: vec![[0, 0, 1], [0, 1, 2], [0, 1, 3]],
            ..Mesh::default()
        };
        smooth(&mut mesh, CREASE, &[]);
        assert!(normals(&mesh).iter().all(|n| (n.length() - 1.0).abs() < 1e-5));
        smooth(&mut Mesh::default(), CREASE, &[]);
        // A vertex on no face.
        assert_eq!(of_faces(&[Vec3::ONE], &[], &[0]), [Vec3::Z]);
    }

    #[test]
    fn missing_normals_are_filled_in() {
        let mut mesh = roof(0.5);
        mesh.normals = NormalSource::Given(vec![Vec3::X * 2.0, Vec3::NAN, Vec3::ZERO, Vec3::X]);
        finish(&mut mesh, &[]);
        let NormalSource::Given(n) = &mesh.normals else { panic!("some were given") };
        assert_eq!((n[0], n[3]), (Vec3::X, Vec3::X));
        assert!(n[1].distance(Vec3::Y) < 1e-5 && n[2].y > 0.9);
        let mut mesh = roof(0.5);
        mesh.normals = NormalSource::Given(vec![Vec3::NAN; 4]);
        finish(&mut mesh, &[]);
        assert!(matches!(mesh.normals, NormalSource::Faces(_)));
    }

    #[test]
    fn many_faces_around_one_place_stay_fast() {
        // A fan of 200,000 blades, each its own cluster: quadratic work would take minutes.
        let n = 200_000u32;
        let blade = |i: u32| (i as f32).sin_cos();
        let mut positions = vec![Vec3::ZERO];
        for i in 0..n {
            let (s, c) = blade(i);
            positions.extend([vec3(c, s, i as f32), vec3(-s, c, i as f32 + 0.5)]);
        }
        let triangles = (0..n).map(|i| [0, 2 * i + 1, 2 * i + 2]).collect();
        let mut mesh = Mesh { positions, triangles, ..Mesh::default() };
        smooth(&mut mesh, CREASE, &[]);
        assert_eq!(mesh.positions.len(), 3 * n as usize);
    }
}
