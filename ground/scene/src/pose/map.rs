//! [`Map`]: an affine map that carries positions, normals and tangents, each in its own way.

use crate::mesh::is_in_reach;
use chiaro_basis::math::{DAffine3, DMat3, DVec3, Vec3, Vec4};

/// An affine map of space, with what follows from it for directions.
pub(super) struct Map {
    affine: DAffine3,
    /// The inverse transpose, up to a positive factor.
    normals: DMat3,
    mirrors: bool,
}

impl Map {
    pub(super) fn new(affine: DAffine3) -> Self {
        Self { affine, normals: normal_matrix(&affine.matrix3), mirrors: mirrors(&affine) }
    }

    /// A position; the origin where it would be out of reach.
    pub(super) fn position(&self, p: Vec3) -> Vec3 {
        let p = self.affine.transform_point3(p.as_dvec3()).as_vec3();
        if is_in_reach(p) { p } else { Vec3::ZERO }
    }

    /// A unit normal. Where the map leaves no plane, the normal goes along as a direction.
    pub(super) fn normal(&self, n: Vec3) -> Vec3 {
        let n = n.as_dvec3();
        let carried = unit(self.normals * n).or_else(|| unit(self.affine.matrix3 * n));
        carried.or_else(|| unit(n)).unwrap_or(Vec3::Z)
    }

    /// A unit tangent; a mirror turns the bitangent's sign, since normal x tangent turns too.
    pub(super) fn tangent(&self, t: Vec4) -> Vec4 {
        let along = t.truncate().as_dvec3();
        let carried = unit(self.affine.matrix3 * along).or_else(|| unit(along));
        carried.unwrap_or(Vec3::X).extend(if self.mirrors { -t.w } else { t.w })
    }
}

/// Whether a map turns left hands into right hands.
pub(super) fn mirrors(m: &DAffine3) -> bool {
    m.matrix3.determinant() < 0.0
}

fn unit(v: DVec3) -> Option<Vec3> {
    v.try_normalize().map(|v| v.as_vec3())
}

/// The cofactor matrix with the determinant's sign: a positive multiple of the inverse transpose
/// where there is one, and still the normal of the plane where space is flattened to a plane.
pub(crate) fn normal_matrix(m: &DMat3) -> DMat3 {
    let (x, y, z) = (m.x_axis, m.y_axis, m.z_axis);
    let cofactors = DMat3::from_cols(y.cross(z), z.cross(x), x.cross(y));
    if m.determinant() < 0.0 { cofactors * -1.0 } else { cofactors }
}

#[cfg(test)]
mod tests {
    use super::*;
    use chiaro_basis::math::{DQuat, dvec3, vec3};

    fn map(scale: DVec3) -> Map {
        let turn = DQuat::from_axis_angle(dvec3(0.6, 0.0, 0.8), 1.1);
        Map::new(DAffine3::from_scale_rotation_translation(scale, turn, dvec3(3.0, 4.0, 5.0)))
    }

    #[test]
    fn normals_stay_across_the_surface() {
        let (u, v) = (vec3(0.3, -0.4, 0.5), vec3(0.9, 0.2, -0.1));
        let n = u.cross(v).normalize();
        for scale in [dvec3(1.0, 2.0, 7.0), dvec3(-1.0, 0.1, 3.0), dvec3(1e-20, 1e-20, 1e-18)] {
            let m = map(scale);
            let carried = m.normal(n).as_dvec3();
            assert!((carried.length() - 1.0).abs() < 1e-6);
            for edge in [u, v] {
                let edge = (m.affine.matrix3 * edge.as_dvec3()).normalize();
                assert!(carried.dot(edge).abs() < 1e-6, "{scale}");
            }
            assert!(carried.dot(m.affine.matrix3 * n.as_dvec3()) > 0.0, "the same side");
        }
    }

    #[test]
    fn flat_maps_give_the_plane_and_smaller_ones_something_finite() {
        let flat = map(dvec3(1.0, 2.0, 0.0));
        let across = flat.affine.matrix3.x_axis.cross(flat.affine.matrix3.y_axis).normalize();
        assert!(flat.normal(vec3(0.1, 0.2, 0.97)).as_dvec3().dot(across) > 1.0 - 1e-6);
        for scale in [dvec3(1.0, 0.0, 0.0), DVec3::ZERO, DVec3::INFINITY, DVec3::NAN] {
            let m = map(scale);
            assert!((m.normal(Vec3::Y).length() - 1.0).abs() < 1e-6, "{scale}");
            assert!((m.tangent(Vec4::X).truncate().length() - 1.0).abs() < 1e-6, "{scale}");
            assert!(m.position(Vec3::ONE).is_finite(), "{scale}");
        }
    }

    #[test]
    fn a_mirrored_bitangent_is_the_mirror_image_of_the_bitangent() {
        let m = map(dvec3(-1.0, 1.0, 1.0));
        let (n, t) = (Vec3::Z, Vec3::X.extend(-1.0));
        let bitangent = |n: Vec3, t: Vec4| n.cross(t.truncate()) * t.w;
        let want = (m.affine.matrix3 * bitangent(n, t).as_dvec3()).as_vec3();
        assert!(bitangent(m.normal(n), m.tangent(t)).distance(want) < 1e-6);
    }
}
