//! Curvature of a posed surface: the second fundamental form at its vertices (Rusinkiewicz 2004).
//!
//! On each face the form is fitted to the change of the vertex normals along its sides; vertices
//! take the mean of their faces, weighted by area, each carried into the vertex's tangent plane. A
//! crease parts its sides, as it parts their normals.

use crate::posed::Posed;
use crate::surface::Surface;
use chiaro_basis::math::{DMat3, DVec3};
use rayon::prelude::*;

/// A symmetric form on a surface's tangent planes, as a matrix that sends normals to zero.
pub(crate) type Form = DMat3;

/// The second fundamental form at each vertex, in 1 / scene units: positive where the surface
/// bends away from its normal, as a sphere seen from outside does.
pub(crate) fn forms(surface: &Surface, posed: &Posed) -> Vec<Form> {
    let mut sums = vec![(DMat3::ZERO, 0.0); posed.positions.len()];
    let faces: Vec<Option<(Form, f64)>> =
        (0..surface.real_faces).into_par_iter().map(|f| face_form(surface, posed, f)).collect();
    for (face, form) in surface.faces.iter().zip(faces) {
        let Some((form, area)) = form else { continue };
        for &v in face {
            let sum = &mut sums[v as usize];
            sum.0 += form * area;
            sum.1 += area;
        }
    }
    let in_plane = |(sum, n): (&(Form, f64), &DVec3)| {
        if sum.1 <= 0.0 {
            return DMat3::ZERO;
        }
        let plane = DMat3::IDENTITY - outer(*n, *n);
        plane * (sum.0 * sum.1.recip()) * plane
    };
    sums.iter().zip(&posed.normals).map(in_plane).collect()
}

pub(crate) fn outer(a: DVec3, b: DVec3) -> DMat3 {
    DMat3::from_cols(a * b.x, a * b.y, a * b.z)
}

/// The form on one face and the face's area: a least-squares fit to dn . u = u^T II u over its sides.
fn face_form(surface: &Surface, posed: &Posed, face: usize) -> Option<(Form, f64)> {
    let corners = surface.faces[face].map(|v| v as usize);
    let [a, b, c] = corners.map(|v| posed.positions[v]);
    let area = 0.5 * (b - a).cross(c - a).length();
    let normal = posed.face_normals[face];
    let u = (b - a).try_normalize()?;
    let v = normal.cross(u);
    let normals = corners.map(|v| posed.normals[v]);
    // Unknowns e, f, g of [[e, f], [f, g]]; two equations a side.
    let (mut left, mut right) = (DMat3::ZERO, DVec3::ZERO);
    for i in 0..3 {
        let j = (i + 1) % 3;
        let side = [a, b, c][j] - [a, b, c][i];
        let turn = normals[j] - normals[i];
        let (x, y) = (side.dot(u), side.dot(v));
        for (row, value) in
            [(DVec3::new(x, y, 0.0), turn.dot(u)), (DVec3::new(0.0, x, y), turn.dot(v))]
        {
            left += outer(row, row);
            right += row * value;
        }
    }
    let det = left.determinant();
    if det.abs() < 1e-18 * left.x_axis.length().powi(3).max(1e-300) {
        return None;
    }
    let [e, f, g] = (left.inverse() * right).to_array();
    let form = outer(u, u) * e + (outer(u, v) + outer(v, u)) * f + outer(v, v) * g;
    form.is_finite().then_some((form, area))
}

/// The gradients of a function on the real faces, given its values at the vertices.
pub(crate) fn gradient(surface: &Surface, posed: &Posed, values: &[f64], face: usize) -> DVec3 {
    let corners = surface.faces[face];
    let [a, b, c] = corners.map(|v| posed.positions[v as usize]);
    let [x, y, z] = corners.map(|v| values[v as usize]);
    let normal = (b - a).cross(c - a);
    let sum = normal.cross(c - b) * x + normal.cross(a - c) * y + normal.cross(b - a) * z;
    let gradient = sum / normal.length_squared();
    if gradient.is_finite() { gradient } else { DVec3::ZERO }
}

/// Principal curvatures, the greater in magnitude first, with their directions.
pub(crate) fn principal(form: &Form, normal: DVec3) -> [(f64, DVec3); 2] {
    let u = normal.any_orthonormal_vector();
    let v = normal.cross(u);
    let (e, f, g) = (u.dot(*form * u), u.dot(*form * v), v.dot(*form * v));
    let (mean, half) = (0.5 * (e + g), 0.5 * (e - g));
    let root = half.hypot(f);
    let angle = 0.5 * f.atan2(half);
    let first = u * angle.cos() + v * angle.sin();
    let pair = [(mean + root, first), (mean - root, normal.cross(first))];
    if pair[0].0.abs() >= pair[1].0.abs() { pair } else { [pair[1], pair[0]] }
}

#[cfg(test)]
mod tests {
    use super::*;
    use chiaro_basis::math::{Vec3, vec3};
    use chiaro_scene::{Material, MaterialId, Mesh, MeshId, Node, NormalSource, Playback, Scene};

    /// A torus of radii 1 and 0.4.
    fn torus(n: u32, m: u32) -> Scene {
        let tau = std::f32::consts::TAU;
        let point = |k: u32| -> Vec3 {
            let (u, v) = (tau * (k / m) as f32 / n as f32, tau * (k % m) as f32 / m as f32);
            let r = 1.0 + 0.4 * v.cos();
            vec3(r * u.cos(), 0.4 * v.sin(), r * u.sin())
        };
        let id = |i: u32, j: u32| (i % n) * m + j % m;
        let cells = (0..n).flat_map(|i| (0..m).map(move |j| (i, j)));
        let triangles: Vec<[u32; 3]> = cells
            .flat_map(|(i, j)| {
                let [a, b, c, d] = [id(i, j), id(i + 1, j), id(i + 1, j + 1), id(i, j + 1)];
                [[a, c, b], [a, d, c]]
            })
            .collect();
        let mesh = Mesh {
            materials: vec![MaterialId::new(0); triangles.len()],
            positions: (0..n * m).map(point).collect(),
            normals: NormalSource::Faces((0..n * m).collect()),
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

    #[test]
    fn a_torus_has_the_curvatures_of_the_books() {
        let scene = torus(160, 80);
        let frame = scene.frame(0.0, &Playback::still());
        let rule = crate::CreaseRule { angle: 4.0, smooth_angle: 4.0 };
        let surface = Surface::of(&scene, &frame, &rule);
        let posed = Posed::new(&surface, &frame, 0);
        let forms = forms(&surface, &posed);
        for (v, form) in forms.iter().enumerate() {
            let p = posed.positions[v];
            let ring = p.x.hypot(p.z);
            let along = (ring - 1.0) / 0.4 / ring;
            let [(a, ta), (b, _)] = principal(form, posed.normals[v]);
            assert!((a - 2.5).abs() < 0.05 && (b - along).abs() < 0.05, "{v}: {a} {b} {along}");
            // The tube's circle bends most: its direction lies in the plane of the axis.
            let round = DVec3::new(-p.z, 0.0, p.x) / ring;
            assert!(ta.dot(round).abs() < 0.05);
        }
    }
}
