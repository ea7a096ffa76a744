//! Points on what shines for a place that sees it, by solid angle.
//!
//! Points drawn by area ([`Glow::point`]) seldom are those that a place beside a panel has most of its light from. Here
//! few triangles are chosen by what they may give ([`super::bundle`]), one of them by its radiance times its solid
//! angle, and a direction uniformly within it (Arvo 1995). Where only few shine none gives more than what shines
//! could in all.

use super::bundle::FEW;
use super::{Glow, GlowPoint, GlowTriangle};
use chiaro_basis::math::{DVec3, Vec3};
use chiaro_image::colour::luminance;

/// Of the largest coordinate: places no farther from a triangle's plane lie in it, but for rounding.
const FLUSH: f32 = 1e-6;
/// Solid angles under which the points of a triangle are all as far, steradians.
const SMALL: f32 = 1e-4;

impl Glow {
    /// A point for three numbers in [0, 1), seen from a place on a surface with a normal; the first number
    /// chooses the triangle. `None` where nothing is seen.
    pub(crate) fn point_seen(
        &self,
        from: Vec3,
        normal: Vec3,
        [choice, u, v]: [f32; 3],
    ) -> Option<GlowPoint> {
        let (few, share, choice) = self.bundles.choose(from, normal, choice)?;
        let mut sums = [0.0; FEW];
        let sum = self.seen_of(few, from, normal, &mut sums);
        let index = few[sums.iter().take(few.len()).position(|s| choice * sum < *s)?] as usize;
        let t = &self.triangles[index];
        let solid_angle = t.solid_angle(from, normal);
        let chosen = share * luminance(t.radiance) * solid_angle / sum;
        if solid_angle < SMALL {
            let b = barycentric([u, v]);
            return Some(t.at(index, b, chosen / t.area));
        }
        let direction = t.direction(from, [u, v]);
        let distance = (t.corners[0] - from).dot(t.normal) / direction.dot(t.normal);
        if !(distance > 0.0 && distance.is_finite()) {
            return None;
        }
        let b = t.barycentric(from + direction * distance);
        let density = chosen / solid_angle * direction.dot(t.normal).abs() / (distance * distance);
        (density > 0.0 && density.is_finite()).then(|| t.at(index, b, density))
    }

    /// The density, per area, with which [`Glow::point_seen`] finds a point in a direction at a distance, on a
    /// triangle.
    pub(crate) fn density_seen(
        &self,
        triangle: usize,
        (from, normal): (Vec3, Vec3),
        (direction, distance): (Vec3, f32),
    ) -> f32 {
        let (few, share) = self.bundles.chance(from, normal, triangle);
        let sum = self.seen_of(few, from, normal, &mut [0.0; FEW]);
        let t = &self.triangles[triangle];
        let solid_angle = t.solid_angle(from, normal);
        if !(share > 0.0 && solid_angle > 0.0) {
            return 0.0;
        }
        let per_angle = share * luminance(t.radiance) / sum;
        match solid_angle < SMALL {
            true => per_angle * solid_angle / t.area,
            false => per_angle * direction.dot(t.normal).abs() / (distance * distance),
        }
    }

    /// What some triangles are seen to give, radiance times solid angle; and in `sums` up to each.
    fn seen_of(&self, few: &[u32], from: Vec3, normal: Vec3, sums: &mut [f32; FEW]) -> f32 {
        let mut sum = 0.0;
        for (at, i) in sums.iter_mut().zip(few) {
            let t = &self.triangles[*i as usize];
            sum += luminance(t.radiance) * t.solid_angle(from, normal);
            *at = sum;
        }
        sum
    }
}

/// Uniform over a triangle (Heitz 2019: folding the square keeps neighbours together).
pub(super) fn barycentric([u, v]: [f32; 2]) -> [f32; 2] {
    if u < v { [0.5 * u, v - 0.5 * u] } else { [u - 0.5 * v, 0.5 * v] }
}

impl GlowTriangle {
    /// Its point of barycentric coordinates.
    pub(super) fn at(&self, triangle: usize, b: [f32; 2], density: f32) -> GlowPoint {
        let [p, q, r] = self.corners;
        let position = p + (q - p) * b[0] + (r - p) * b[1];
        GlowPoint { position, triangle, b, density }
    }

    /// The coordinates of a point in its plane; those of the nearest point inside, but for rounding.
    fn barycentric(&self, point: Vec3) -> [f32; 2] {
        let [p, q, r] = self.corners;
        let share = |a: Vec3, b: Vec3| a.cross(b).dot(self.normal) / (2.0 * self.area);
        let side = (q - p).cross(r - p).dot(self.normal).signum();
        let second = (side * share(point - p, r - p)).clamp(0.0, 1.0);
        let third = (side * share(q - p, point - p)).clamp(0.0, 1.0 - second);
        [second, third]
    }

    /// Whether a place lies on a side that shines, and not in its plane.
    pub(super) fn is_above(&self, from: Vec3) -> bool {
        let above = (from - self.corners[0]).dot(self.normal);
        let above = if self.two_sided { above.abs() } else { above };
        above > FLUSH * self.corners[0].abs().max(from.abs()).max_element()
    }

    /// Of the side that shines, from a place on a surface; 0 when all of it lies under that surface, or the
    /// place in its plane (Van Oosterom and Strackee 1983).
    fn solid_angle(&self, from: Vec3, normal: Vec3) -> f32 {
        let [a, b, c] = self.corners.map(|p| p - from);
        if !self.is_above(from) || [a, b, c].iter().all(|p| p.dot(normal) <= 0.0) {
            return 0.0;
        }
        let (x, y, z) = (a.length(), b.length(), c.length());
        let across = a.dot(b.cross(c)).abs();
        let along = x * y * z + a.dot(b) * z + b.dot(c) * x + c.dot(a) * y;
        let angle = 2.0 * across.atan2(along);
        if angle.is_finite() { angle } else { 0.0 }
    }

    /// A direction to it from a place, uniform by solid angle.
    fn direction(&self, from: Vec3, [u, v]: [f32; 2]) -> Vec3 {
        let [a, b, c] = self.corners.map(|p| (p - from).as_dvec3().normalize_or_zero());
        let [ab, bc, ca] = [a.cross(b), b.cross(c), c.cross(a)].map(DVec3::normalize_or_zero);
        let angle = |p: DVec3, q: DVec3| (-p.dot(q)).clamp(-1.0, 1.0).acos();
        let (alpha, beta, gamma) = (angle(ca, ab), angle(ab, bc), angle(bc, ca));
        // The corner c moves along its side until the triangle has this share of its area.
        let (sin, cos) =
            (f64::from(u) * (alpha + beta + gamma - std::f64::consts::PI) - alpha).sin_cos();
        let (sin_alpha, cos_alpha) = alpha.sin_cos();
        let (p, q) = (cos - cos_alpha, sin + sin_alpha * a.dot(b));
        let place = ((q * cos - p * sin) * cos_alpha - q) / ((q * sin + p * cos) * sin_alpha);
        let moved = arc(a, c, place.clamp(-1.0, 1.0));
        let place = 1.0 - f64::from(v) * (1.0 - moved.dot(b));
        arc(b, moved, place).as_vec3().normalize_or(-self.normal)
    }
}

/// On the arc from a unit vector towards another, at a cosine from the first.
fn arc(a: DVec3, b: DVec3, cosine: f64) -> DVec3 {
    a * cosine + (b - a * a.dot(b)).normalize_or_zero() * (1.0 - cosine * cosine).max(0.0).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use chiaro_basis::{math::vec3, random};

    /// A square of side 2 in the plane y = `h` around the y axis, shining down.
    fn panel(h: f32) -> Glow {
        let [a, b, c, d] = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]]
            .map(|[x, z]: [f32; 2]| vec3(x, h, z));
        let triangle = |corners: [Vec3; 3], light: f32, face: u32| GlowTriangle {
            corners,
            normal: Vec3::NEG_Y,
            area: 2.0,
            radiance: [light; 3],
            two_sided: false,
            textured: false,
            object: 0,
            face,
        };
        Glow::from_triangles(vec![triangle([a, b, c], 1.0, 0), triangle([a, c, d], 3.0, 1)])
    }

    /// Irradiance over pi of a place facing `normal`, and the most that one point gives.
    fn irradiance(glow: &Glow, from: Vec3, normal: Vec3) -> (f32, f32) {
        let count = 4096;
        let (mut sum, mut most) = (0.0, 0.0f32);
        for i in 0..count {
            let [u, v] = random::r2(i);
            let choice = (i as f32 + 0.5) / count as f32;
            let choice = (choice * 61.0).fract();
            let Some(point) = glow.point_seen(from, normal, [choice, u, v]) else { continue };
            let (towards, distance) = (point.position - from).normalize_and_length();
            let t = &glow.triangles()[point.triangle];
            let outward = -towards.dot(t.normal);
            let outward = if t.two_sided { outward.abs() } else { outward };
            let factor = towards.dot(normal).max(0.0) * outward / (distance * distance);
            let e = t.radiance[0] * factor / point.density;
            sum += e / count as f32;
            most = most.max(e);
        }
        (sum / std::f32::consts::PI, most)
    }

    /// The share of a square's light that a place under its middle sees, facing it, in closed form.
    fn form_factor(h: f32) -> f32 {
        let x = 1.0 / h;
        let root = (1.0 + x * x).sqrt();
        4.0 * x / (std::f32::consts::PI * root) * (x / root).atan()
    }

    #[test]
    fn beside_a_panel_it_gives_what_it_does() {
        for h in [1e-3, 0.02, 0.3, 2.0, 300.0] {
            let glow = panel(h);
            let (e, most) = irradiance(&glow, Vec3::ZERO, Vec3::Y);
            // Half of it shines three times as brightly.
            assert!((e / (2.0 * form_factor(h)) - 1.0).abs() < 0.01, "{h}: {e} {}", form_factor(h));
            assert!(most <= 2.0 * std::f32::consts::TAU * 2.0, "{h}: {most}");
        }
    }

    /// Panels of squares beside each other and above, more than are told apart, of two kinds.
    fn panels() -> Glow {
        let square = |x: f32, h: f32, z: f32, face: u32| {
            let moved = move |c: Vec3| 0.3 * c + vec3(x, h, z);
            panel(0.0).triangles.into_iter().map(move |t| GlowTriangle {
                corners: t.corners.map(moved),
                area: 0.09 * t.area,
                two_sided: h > 1.0,
                face: face + t.face,
                ..t
            })
        };
        let place = |i: u32| {
            let [x, z] = [i % 7, i / 7].map(|k| 2.0 * k as f32 - 6.0);
            (x, if i.is_multiple_of(3) { 2.0 } else { 0.05 }, z)
        };
        let all = (0..49).flat_map(|i| {
            let (x, h, z) = place(i);
            square(x, h, z, 2 * i)
        });
        Glow::from_triangles(all.collect())
    }

    #[test]
    fn of_many_triangles_it_gives_what_they_do() {
        let glow = panels();
        assert!(!glow.bundles.is_one());
        for (from, normal) in [
            (Vec3::ZERO, Vec3::Y),
            (vec3(4.1, 0.0, -2.2), Vec3::Y),
            (vec3(1.0, 1.0, 0.3), Vec3::X),
            (vec3(0.3, 2.1, 6.2), Vec3::NEG_Y),
            (vec3(-30.0, -15.0, 0.0), Vec3::X),
        ] {
            let exact = glow.open_irradiance(from, normal).unwrap()[0];
            let (e, most) = irradiance(&glow, from, normal);
            let e = std::f32::consts::PI * e;
            assert!((e / exact - 1.0).abs() < 0.02, "{from} {normal}: {e} {exact}");
            assert!(most < 12.0 * exact, "{from} {normal}: {most} {exact}");
        }
    }

    #[test]
    fn its_density_is_known_of_any_point() {
        let glow = panels();
        let (from, normal) = (vec3(0.3, -0.4, 0.2), vec3(0.1, 1.0, 0.0).normalize());
        for i in 0..500 {
            let numbers = [1, 2, 3].map(|k| random::unit(k, i));
            let Some(point) = glow.point_seen(from, normal, numbers) else { continue };
            let to = (point.position - from).normalize_and_length();
            let density = glow.density_seen(point.triangle, (from, normal), to);
            assert!((density / point.density - 1.0).abs() < 1e-3, "{density} {}", point.density);
        }
    }

    #[test]
    fn a_place_in_its_plane_sees_nothing_of_it() {
        let two_sided = Glow::from_triangles(
            panel(5.4).triangles.iter().map(|t| GlowTriangle { two_sided: true, ..*t }).collect(),
        );
        for glow in [panel(5.4), two_sided] {
            for i in 0..1000 {
                let [x, z] = [1, 2].map(|k| 3.0 * random::unit(k, i) - 1.5);
                let y = 5.4 + 1e-6 * (random::unit(3, i) - 0.5);
                for normal in [Vec3::Y, Vec3::NEG_Y, Vec3::X] {
                    let numbers = [4, 5, 6].map(|k| random::unit(k, i));
                    assert!(glow.point_seen(vec3(x, y, z), normal, numbers).is_none());
                }
            }
        }
    }

    #[test]
    fn a_place_on_its_edge_sees_half_of_what_it_would_inside_it() {
        // On an edge's middle, close by, the panel fills half of the hemisphere with the light of the triangle there, 1.
        let (e, _) = irradiance(&panel(1e-3), vec3(0.0, 0.0, -1.0), Vec3::Y);
        assert!((e - 0.5).abs() < 0.01, "{e}");
        let (e, _) = irradiance(&panel(1e-3), Vec3::ZERO, Vec3::NEG_Y);
        assert_eq!(e, 0.0);
        let (e, _) = irradiance(&panel(-1.0), Vec3::ZERO, Vec3::NEG_Y);
        assert_eq!(e, 0.0);
    }
}
