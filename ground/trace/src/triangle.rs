//! Watertight ray-triangle intersection after Woop, Benthin and Wald ("Watertight Ray/Triangle
//! Intersection", JCGT 2013).
//!
//! The ray is sheared onto the axis in which it runs fastest; a triangle is hit when the origin
//! lies on one side of its three projected edges. Two triangles that share an edge evaluate that
//! edge with the same numbers, so no ray slips between them; where an edge function is exactly
//! zero in single precision it is evaluated again in double. Guaranteed: no pinholes along shared
//! edges. Not guaranteed: that exactly one of the two is reported.

use chiaro_basis::math::{Vec3, Vec3A};

/// A ray prepared for many triangles.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sheared {
    origin: Vec3A,
    /// The columns of a matrix that takes the axis in which the ray runs fastest to z, and the ray's
    /// direction to (0, 0, 1). All entries but the shears are 0 or 1, so that it rounds as if axes
    /// were swapped by hand.
    columns: [Vec3A; 3],
}

/// Distance along the ray (in units of its direction) and the barycentric coordinates of the
/// second and the third vertex.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Crossing {
    pub(crate) t: f32,
    pub(crate) b: [f32; 2],
}

impl Sheared {
    /// Prepares the ray from `origin` along `direction` (not zero).
    pub(crate) fn new(origin: Vec3, direction: Vec3) -> Self {
        let kz = direction.abs().max_position();
        let (mut kx, mut ky) = ((kz + 1) % 3, (kz + 2) % 3);
        if direction[kz] < 0.0 {
            std::mem::swap(&mut kx, &mut ky);
        }
        let z = direction[kz];
        let mut columns = [Vec3A::ZERO; 3];
        columns[kx].x = 1.0;
        columns[ky].y = 1.0;
        columns[kz] = Vec3A::new(-direction[kx] / z, -direction[ky] / z, 1.0 / z);
        Self { origin: origin.into(), columns }
    }

    /// Where the ray meets the triangle in front of its origin and not past `t_max`, from
    /// either side.
    #[inline]
    pub(crate) fn cross(&self, triangle: &[Vec3; 3], t_max: f32) -> Option<Crossing> {
        let [a, b, c] = triangle.map(|p| self.project(p));
        let mut e = [c.x * b.y - c.y * b.x, a.x * c.y - a.y * c.x, b.x * a.y - b.y * a.x];
        if e.contains(&0.0) {
            e = [edge(c, b), edge(a, c), edge(b, a)];
        }
        let [u, v, w] = e;
        if (u < 0.0 || v < 0.0 || w < 0.0) && (u > 0.0 || v > 0.0 || w > 0.0) {
            return None;
        }
        let det = u + v + w;
        if det == 0.0 {
            return None;
        }
        let t = (u * a.z + v * b.z + w * c.z) / det;
        (t > 0.0 && t <= t_max).then(|| Crossing { t, b: [v / det, w / det] })
    }

    #[inline]
    fn project(&self, p: Vec3) -> Vec3A {
        let d = Vec3A::from(p) - self.origin;
        let [x, y, z] = self.columns;
        x * d.x + y * d.y + z * d.z
    }
}

#[cold]
fn edge(a: Vec3A, b: Vec3A) -> f32 {
    let exact = f64::from(a.x) * f64::from(b.y) - f64::from(a.y) * f64::from(b.x);
    // A tiny difference must keep its sign when it is rounded.
    let rounded = exact as f32;
    if rounded == 0.0 && exact != 0.0 { f32::MIN_POSITIVE.copysign(exact as f32) } else { rounded }
}

#[cfg(test)]
mod tests {
    use super::*;
    use chiaro_basis::math::vec3;

    const T: [Vec3; 3] = [vec3(0.0, 0.0, 0.0), vec3(1.0, 0.0, 0.0), vec3(0.0, 1.0, 0.0)];

    #[test]
    fn crossings_have_distance_and_barycentrics() {
        let ray = Sheared::new(vec3(0.25, 0.5, 3.0), vec3(0.0, 0.0, -2.0));
        let c = ray.cross(&T, f32::INFINITY).expect("it hits");
        assert_eq!(c, Crossing { t: 1.5, b: [0.25, 0.5] });
        assert!(ray.cross(&T, 1.0).is_none());
        assert!(Sheared::new(vec3(0.25, 0.5, -3.0), -Vec3::Z).cross(&T, 9.0).is_none());
    }

    #[test]
    fn a_triangle_without_area_is_never_hit() {
        let ray = Sheared::new(vec3(0.5, 0.0, 3.0), -Vec3::Z);
        assert!(ray.cross(&[T[0], T[1], T[1]], 9.0).is_none());
        assert!(ray.cross(&[T[0], T[0], T[0]], 9.0).is_none());
    }
}
