//! Watertight ray-triangle intersection after Woop, Benthin and Wald ("Watertight Ray/Triangle
//! Intersection", JCGT 2013).
//!
//! The ray is sheared onto the axis in which it runs fastest; a triangle is hit when the origin
//! lies on one side of its three projected edges. Two triangles that share an edge evaluate that
//! edge with the same numbers, so no ray slips between them; where an edge function is exactly
//! zero in single precision it is evaluated again in double. Guaranteed: no pinholes along shared
//! edges. Not guaranteed: that exactly one of the two is reported.

use chiaro_basis::math::Vec3;

/// A ray prepared for many triangles.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sheared {
    origin: Vec3,
    axes: [usize; 3],
    shear: Vec3,
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
        let shear = Vec3::new(direction[kx] / z, direction[ky] / z, 1.0 / z);
        Self { origin, axes: [kx, ky, kz], shear }
    }

    /// Where the ray meets the triangle in front of its origin and not past `t_max`, from
    /// either side.
    pub(crate) fn cross(&self, triangle: &[Vec3; 3], t_max: f32) -> Option<Crossing> {
        let [a, b, c] = triangle.map(|p| self.project(p));
        let mut e = [c.0 * b.1 - c.1 * b.0, a.0 * c.1 - a.1 * c.0, b.0 * a.1 - b.1 * a.0];
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
        let t = (u * a.2 + v * b.2 + w * c.2) / det;
        (t > 0.0 && t <= t_max).then(|| Crossing { t, b: [v / det, w / det] })
    }

    fn project(&self, p: Vec3) -> (f32, f32, f32) {
        let d = p - self.origin;
        let [kx, ky, kz] = self.axes;
        (d[kx] - self.shear.x * d[kz], d[ky] - self.shear.y * d[kz], self.shear.z * d[kz])
    }
}

fn edge(a: (f32, f32, f32), b: (f32, f32, f32)) -> f32 {
    let exact = f64::from(a.0) * f64::from(b.1) - f64::from(a.1) * f64::from(b.0);
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
