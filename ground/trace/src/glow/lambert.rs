//! Irradiance from what shines where nothing stands between, in closed form.
//!
//! A polygon of one radiance gives half the sum, over its edges, of the angle that an edge is seen under
//! times how far the plane through edge and place leans to the normal (Lambert 1760), after what lies
//! under the horizon is cut off.

use super::{Glow, GlowTriangle};
use chiaro_basis::math::{DVec3, Vec3};

impl Glow {
    /// Irradiance of a place that faces `normal`, linear RGB; `None` where triangles are very many or textured.
    pub(crate) fn open_irradiance(&self, from: Vec3, normal: Vec3) -> Option<[f32; 3]> {
        self.open.as_ref().map(|open| open.irradiance(from, normal))
    }
}

impl GlowTriangle {
    /// Irradiance over its radiance.
    pub(super) fn form(&self, from: Vec3, normal: Vec3) -> f32 {
        if !self.is_above(from) {
            return 0.0;
        }
        let normal = normal.as_dvec3();
        let corners = self.corners.map(|p| p.as_dvec3() - from.as_dvec3());
        let heights = corners.map(|p| p.dot(normal));
        // A triangle cut by a plane has four corners at most.
        let (mut kept, mut count) = ([DVec3::ZERO; 4], 0);
        for i in 0..3 {
            let j = (i + 1) % 3;
            let (a, b) = (heights[i], heights[j]);
            if a >= 0.0 {
                kept[count] = corners[i];
                count += 1;
            }
            if (a >= 0.0) != (b >= 0.0) {
                kept[count] = corners[i] + (corners[j] - corners[i]) * (a / (a - b));
                count += 1;
            }
        }
        let edge = |i: usize| {
            let (p, q) = (kept[i], kept[(i + 1) % count]);
            let across = p.cross(q);
            across.length().atan2(p.dot(q)) * across.normalize_or_zero().dot(normal)
        };
        (0.5 * (0..count).map(edge).sum::<f64>().abs()) as f32
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use chiaro_basis::{math::vec3, random};

    #[test]
    fn it_is_what_points_by_solid_angle_give() {
        let corners = [vec3(-1.0, 0.7, -0.5), vec3(1.2, 0.9, 0.1), vec3(0.2, -0.4, 1.5)];
        let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
        let triangle = GlowTriangle {
            corners,
            normal: normal.normalize(),
            area: 0.5 * normal.length(),
            radiance: [1.0, 2.0, 0.0],
            two_sided: true,
            textured: false,
            object: 0,
            face: 0,
        };
        let glow = Glow::from_triangles(vec![triangle]);
        for k in 0..40 {
            let v = |d| Vec3::from([d, d + 1, d + 2].map(|d| random::unit(d, k) - 0.5));
            let (from, normal) = (3.0 * v(1), v(4).normalize());
            let count = 2000;
            let sum: f32 = (0..count)
                .filter_map(|i| {
                    let [a, b] = random::r2(i);
                    let point = glow.point_seen(from, normal, [0.5, a, b])?;
                    let (towards, distance) = (point.position - from).normalize_and_length();
                    let outward = towards.dot(triangle.normal).abs();
                    let e = towards.dot(normal).max(0.0) * outward / (distance * distance);
                    Some(e / point.density / count as f32)
                })
                .sum();
            let exact = glow.open_irradiance(from, normal).unwrap();
            assert!((exact[0] - sum).abs() < 0.01 * (0.1 + sum), "{k}: {exact:?} {sum}");
            assert!((exact[1] - 2.0 * exact[0]).abs() < 1e-5 && exact[2] == 0.0);
        }
    }
}
