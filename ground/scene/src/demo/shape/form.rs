//! [`Form`]: triangles in the making.
//!
//! Every building block returns one, with a unit normal a vertex; scenes move, bend, swell and join
//! them. Closed blocks share their vertices, so that a closed form is a closed manifold as stored,
//! and wind outwards.

use chiaro_basis::math::{Affine3A, Mat3, Vec3, vec3};

/// Triangles with one unit normal a vertex.
#[derive(Clone, Debug, Default)]
pub(crate) struct Form {
    /// Vertex positions.
    pub(crate) positions: Vec<Vec3>,
    /// Unit normals, as many as positions.
    pub(crate) normals: Vec<Vec3>,
    /// Counter-clockwise seen from outside.
    pub(crate) triangles: Vec<[u32; 3]>,
}

impl Form {
    /// A form with angle-weighted normals.
    pub(crate) fn smooth(positions: Vec<Vec3>, triangles: Vec<[u32; 3]>) -> Self {
        let normals = angle_weighted_normals(&positions, &triangles);
        Self { positions, normals, triangles }
    }

    /// Turned inside out if it encloses a negative volume.
    pub(crate) fn outward(mut self) -> Self {
        if self.volume() < 0.0 {
            self.flip();
        }
        self
    }

    /// The enclosed volume, by the divergence theorem; negative when it winds inwards.
    pub(crate) fn volume(&self) -> f64 {
        let corner = |i: u32| self.positions[i as usize].as_dvec3();
        let six: f64 =
            self.triangles.iter().map(|t| corner(t[0]).dot(corner(t[1]).cross(corner(t[2])))).sum();
        six / 6.0
    }

    /// With every triangle turned if most face away from the normals.
    pub(crate) fn facing_its_normals(mut self) -> Self {
        let agreement: f32 = self.triangles.iter().map(|t| self.agreement(t)).sum();
        if agreement < 0.0 {
            self.triangles.iter_mut().for_each(|t| t.swap(1, 2));
        }
        self
    }

    /// Twice a triangle's area, as far as its first normal agrees.
    fn agreement(&self, t: &[u32; 3]) -> f32 {
        let [a, b, c] = t.map(|v| self.positions[v as usize]);
        (b - a).cross(c - a).dot(self.normals[t[0] as usize])
    }

    fn flip(&mut self) {
        self.triangles.iter_mut().for_each(|t| t.swap(1, 2));
        self.normals.iter_mut().for_each(|n| *n = -*n);
    }

    /// Placed by an affine map, mirrors included.
    pub(crate) fn moved(mut self, by: Affine3A) -> Self {
        let normal = Mat3::from(by.matrix3).inverse().transpose();
        self.positions.iter_mut().for_each(|p| *p = by.transform_point3(*p));
        self.normals.iter_mut().for_each(|n| *n = (normal * *n).normalize_or(*n));
        if by.matrix3.determinant() < 0.0 {
            self.triangles.iter_mut().for_each(|t| t.swap(1, 2));
        }
        self
    }

    /// Moved by a vector.
    pub(crate) fn at(self, x: f32, y: f32, z: f32) -> Self {
        self.moved(Affine3A::from_translation(vec3(x, y, z)))
    }

    /// Scaled along the axes.
    pub(crate) fn scaled(self, x: f32, y: f32, z: f32) -> Self {
        self.moved(Affine3A::from_scale(vec3(x, y, z)))
    }

    /// Turned about x, degrees.
    pub(crate) fn turned_x(self, degrees: f32) -> Self {
        self.moved(Affine3A::from_rotation_x(degrees.to_radians()))
    }

    /// Turned about y, degrees.
    pub(crate) fn turned_y(self, degrees: f32) -> Self {
        self.moved(Affine3A::from_rotation_y(degrees.to_radians()))
    }

    /// Turned about z, degrees.
    pub(crate) fn turned_z(self, degrees: f32) -> Self {
        self.moved(Affine3A::from_rotation_z(degrees.to_radians()))
    }

    /// Deformed by a smooth map that keeps orientation; normals follow its Jacobian, so that crisp
    /// bevels stay crisp.
    pub(crate) fn bent(mut self, map: impl Fn(Vec3) -> Vec3) -> Self {
        for (p, n) in self.positions.iter_mut().zip(&mut self.normals) {
            let step = 1e-3 * (1.0 + p.abs().max_element());
            let (a, b) = n.any_orthonormal_pair();
            let slope = |t: Vec3| map(*p + step * t) - map(*p - step * t);
            *n = slope(a).cross(slope(b)).normalize_or(*n);
            *p = map(*p);
        }
        self
    }

    /// Displaced along the normals by `height` (of position and normal), with new normals from the
    /// faces.
    pub(crate) fn swollen(self, height: impl Fn(Vec3, Vec3) -> f32) -> Self {
        let at = self.positions.iter().zip(&self.normals);
        let positions = at.map(|(&p, &n)| p + height(p, n) * n).collect();
        Self::smooth(positions, self.triangles)
    }

    /// Every triangle with its own three vertices and its own normal.
    pub(crate) fn faceted(self) -> Self {
        let mut flat = Self::default();
        for t in &self.triangles {
            let [a, b, c] = t.map(|i| self.positions[i as usize]);
            let first = flat.positions.len() as u32;
            flat.positions.extend([a, b, c]);
            flat.normals.extend([(b - a).cross(c - a).normalize_or(Vec3::Y); 3]);
            flat.triangles.push([first, first + 1, first + 2]);
        }
        flat
    }

    /// The triangles that `keep` chooses, with the vertices they need.
    pub(crate) fn part(&self, keep: impl Fn(&[u32; 3]) -> bool) -> Self {
        let mut part = Self::default();
        let mut known = vec![u32::MAX; self.positions.len()];
        for t in self.triangles.iter().filter(|t| keep(t)) {
            part.triangles.push(t.map(|v| {
                let v = v as usize;
                if known[v] == u32::MAX {
                    known[v] = part.positions.len() as u32;
                    part.positions.push(self.positions[v]);
                    part.normals.push(self.normals[v]);
                }
                known[v]
            }));
        }
        part
    }

    /// Both forms as one; they stay separate pieces.
    pub(crate) fn with(mut self, other: Self) -> Self {
        let first = self.positions.len() as u32;
        self.positions.extend(other.positions);
        self.normals.extend(other.normals);
        self.triangles.extend(other.triangles.iter().map(|t| t.map(|i| i + first)));
        self
    }

    /// All forms as one.
    pub(crate) fn joined(forms: impl IntoIterator<Item = Self>) -> Self {
        forms.into_iter().fold(Self::default(), Self::with)
    }
}

/// Means of face normals, weighted by the faces' angles at the vertex: independent of how a surface
/// is cut into triangles (Thürmer and Wüthrich 1998).
pub(crate) fn angle_weighted_normals(positions: &[Vec3], triangles: &[[u32; 3]]) -> Vec<Vec3> {
    let mut sums = vec![Vec3::ZERO; positions.len()];
    for t in triangles {
        let p = t.map(|i| positions[i as usize]);
        let face = (p[1] - p[0]).cross(p[2] - p[0]).normalize_or_zero();
        for k in 0..3 {
            let (a, b) = (p[(k + 1) % 3] - p[k], p[(k + 2) % 3] - p[k]);
            sums[t[k] as usize] += face * a.cross(b).length().atan2(a.dot(b));
        }
    }
    sums.into_iter().map(|n| n.normalize_or(Vec3::Y)).collect()
}
