//! Neighbour weights (section 3.5.2): where a border may run cheaply.
//!
//! N = N~ (floor + (1 - floor) N0 N1 Nid) for each pair of neighbours, with
//! - N0 (3.6): exp(-(step / d)^2), the step off the tangent planes in parts of R;
//! - N1 (3.9): exp(-((kappa - mean kappa) / k)^2), kappa (3.7) the angle between the two normals
//!   in radians a pixel, its mean (3.8) over a Gaussian window around their midpoint;
//! - Nid: a factor where object or material change.
//!
//! Departures from the print: (3.8) is normalised; its angles are divided by their distances, so
//! that a featureless sphere has no features; the normal of a midpoint is the normalised mean of
//! the two. The fast form of (3.8) uses one Gaussian n of the normals: |m - n| / c is the mean
//! curvature exactly on a sphere and half the crease angle over c on a crease, where the window
//! sum gives a little more.

use crate::cut::rounded;
use crate::knob::{BinaryKnobs, CurvatureForm, DepthForm, scaled};
use crate::rows;
use chiaro_basis::math::Vec3;
use chiaro_image::{Plane, filter};
use chiaro_trace::GBuffer;
use std::f32::consts::{FRAC_1_SQRT_2, PI};

/// The four neighbours that a pixel shares an edge with, as the cut stores them: E, SE, S, SW.
pub const EDGES: [(isize, isize); 4] = [(1, 0), (1, 1), (0, 1), (-1, 1)];

/// Weights to E, SE, S and SW relative to N~, in [0, 1]; 0 where an edge leaves the picture or
/// touches an uncovered pixel. Diagonal edges are not yet shortened.
pub fn neighbour_factors(buffer: &GBuffer, knobs: &BinaryKnobs) -> Plane<[f32; 4]> {
    if is_fast(knobs) {
        let window = window(buffer, knobs);
        return rows::factors(buffer, (&means(buffer, window), window), knobs);
    }
    edge_by_edge(&Field::new(buffer, knobs))
}

/// [`neighbour_factors`] times `units`, rounded to integers.
pub(crate) fn capacities(
    buffer: &GBuffer,
    units: [f32; 4],
    knobs: &BinaryKnobs,
) -> Plane<[i32; 4]> {
    if is_fast(knobs) {
        let window = window(buffer, knobs);
        return rows::capacities(buffer, (&means(buffer, window), window), units, knobs);
    }
    edge_by_edge(&Field::new(buffer, knobs)).map(|f| rounded(*f, units))
}

/// Whether (3.8) has its fast form.
fn is_fast(knobs: &BinaryKnobs) -> bool {
    knobs.curvature_form == CurvatureForm::Fast && knobs.use_geometry
}

/// c in pixels of a picture.
fn window(buffer: &GBuffer, knobs: &BinaryKnobs) -> f32 {
    // A narrower window holds no neighbours.
    scaled(knobs.curvature_radius, buffer.size().1).max(1.5)
}

/// The means of the normals over such a window.
fn means(buffer: &GBuffer, window: f32) -> filter::Means {
    filter::Means::of(&buffer.normal, &buffer.covered, window * FRAC_1_SQRT_2)
}

/// The weights one edge at a time: the plain form, in which the fast one is tested.
fn edge_by_edge(field: &Field<'_>) -> Plane<[f32; 4]> {
    let (buffer, knobs) = (field.buffer, field.knobs);
    buffer.over_covered(|x, y| {
        std::array::from_fn(|e| match neighbour(buffer, (x, y), EDGES[e]) {
            Some(q) if knobs.use_geometry => field.factor((x, y), q),
            Some(_) => 1.0,
            None => 0.0,
        })
    })
}

fn neighbour(
    buffer: &GBuffer,
    (x, y): (usize, usize),
    (dx, dy): (isize, isize),
) -> Option<(usize, usize)> {
    let (u, v) = (x as isize + dx, y as isize + dy);
    (buffer.covered.at(u, v) == Some(&true)).then_some((u as usize, v as usize))
}

/// What the factors are computed from.
struct Field<'a> {
    buffer: &'a GBuffer,
    knobs: &'a BinaryKnobs,
    /// Gaussian means of the normals, for the fast form.
    mean_normal: Option<Plane<[f32; 3]>>,
    /// c in pixels of this picture.
    window: f32,
}

type Pixel = (usize, usize);

impl<'a> Field<'a> {
    fn new(buffer: &'a GBuffer, knobs: &'a BinaryKnobs) -> Self {
        let window = window(buffer, knobs);
        let mean_normal = is_fast(knobs).then(|| {
            filter::gaussian_covered3(&buffer.normal, &buffer.covered, window * FRAC_1_SQRT_2)
        });
        Self { buffer, knobs, mean_normal, window }
    }

    fn factor(&self, p: Pixel, q: Pixel) -> f32 {
        let k = self.knobs;
        let product = self.depth_factor(p, q) * self.curvature_factor(p, q) * self.id_factor(p, q);
        k.floor + (1.0 - k.floor) * product
    }

    /// N0 (3.6).
    fn depth_factor(&self, p: Pixel, q: Pixel) -> f32 {
        let step = depth_step(self.buffer, p, q, self.knobs.depth_form)
            / self.buffer.radius.max(f32::MIN_POSITIVE);
        let t = step / self.knobs.depth_falloff;
        (-t * t).exp()
    }

    /// N1 (3.9).
    fn curvature_factor(&self, p: Pixel, q: Pixel) -> f32 {
        let (n, m) = (self.normal(p), self.normal(q));
        let pixels = if p.0 == q.0 || p.1 == q.1 { 1.0 } else { std::f32::consts::SQRT_2 };
        let angle = angle(n, m);
        let t = match self.knobs.curvature_form {
            CurvatureForm::Fast => angle / pixels - self.fast_mean(p, q, n + m),
            CurvatureForm::Exact => angle / pixels - self.window_mean(p, q, true),
            CurvatureForm::Raw => angle - self.window_mean(p, q, false),
        } / self.knobs.curvature_falloff;
        (-t * t).exp()
    }

    fn id_factor(&self, p: Pixel, q: Pixel) -> f32 {
        let b = self.buffer;
        if b.object[p] != b.object[q] {
            self.knobs.object_edge
        } else if b.material[p] != b.material[q] {
            self.knobs.material_edge
        } else {
            1.0
        }
    }

    fn normal(&self, p: Pixel) -> Vec3 {
        Vec3::from(self.buffer.normal[p])
    }

    /// The mean curvature around the midpoint from Gaussian means of the normals.
    fn fast_mean(&self, p: Pixel, q: Pixel, sum: Vec3) -> f32 {
        let Some(mean) = &self.mean_normal else { return 0.0 };
        let Some(middle) = sum.try_normalize() else { return PI / self.window };
        let around = 0.5 * (Vec3::from(mean[p]) + Vec3::from(mean[q]));
        (2.0 - 2.0 * middle.dot(around)).max(0.0).sqrt() / self.window
    }

    /// (3.8), normalised, over the window that holds 99.9 % of the weight.
    fn window_mean(&self, p: Pixel, q: Pixel, divided: bool) -> f32 {
        let (cx, cy) = (0.5 * (p.0 + q.0) as f32, 0.5 * (p.1 + q.1) as f32);
        let middle = (self.normal(p) + self.normal(q)).try_normalize();
        let reach = (2.63 * self.window).ceil() as isize;
        let (mut sum, mut weights) = (0.0, 0.0);
        for v in cy as isize - reach..=cy.ceil() as isize + reach {
            for u in cx as isize - reach..=cx.ceil() as isize + reach {
                if self.buffer.covered.at(u, v) != Some(&true) {
                    continue;
                }
                let (dx, dy) = (u as f32 - cx, v as f32 - cy);
                let r2 = dx * dx + dy * dy;
                if r2 == 0.0 {
                    continue;
                }
                let weight = (-r2 / (self.window * self.window)).exp();
                let bend = middle.map_or(PI, |m| angle(m, self.normal((u as usize, v as usize))));
                sum += weight * if divided { bend / r2.sqrt() } else { bend };
                weights += weight;
            }
        }
        if weights > 0.0 { sum / weights } else { 0.0 }
    }
}

/// The geodesic distance on the sphere (3.7), radians; precise for small angles, never NaN.
pub fn angle(a: Vec3, b: Vec3) -> f32 {
    2.0 * (0.5 * (a - b).length()).min(1.0).asin()
}

/// The depth step between two pixels in scene units: off the two tangent planes, or raw.
pub fn depth_step(buffer: &GBuffer, p: Pixel, q: Pixel, form: DepthForm) -> f32 {
    let (a, b) = (Vec3::from(buffer.position[p]), Vec3::from(buffer.position[q]));
    let d = b - a;
    match form {
        DepthForm::Plane => {
            let (n, m) = (buffer.geometric_normal[p], buffer.geometric_normal[q]);
            d.dot(Vec3::from(n)).abs().max(d.dot(Vec3::from(m)).abs())
        }
        DepthForm::Raw => {
            let eye = buffer.pose.position;
            ((a - eye).length() - (b - eye).length()).abs()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use chiaro_basis::random::unit;
    use chiaro_scene::{Pose, Projection};

    /// Unrelated positions, normals and ids, a tenth of the pixels uncovered.
    fn noise(width: usize, height: usize) -> GBuffer {
        let number = |s: u64, x: usize, y: usize| unit(s, (y * width + x) as u64);
        let vector = |s: u64| {
            Plane::from_fn(width, height, |x, y| {
                let v = Vec3::from(std::array::from_fn(|i| number(s + i as u64, x, y) - 0.5));
                v.normalize_or(Vec3::Z).to_array()
            })
        };
        let ids = |s: u64| Plane::from_fn(width, height, |x, y| (3.0 * number(s, x, y)) as u32);
        let projection = Projection::Orthographic { half_height: 1.0 };
        GBuffer {
            pose: Pose::look_at(Vec3::splat(4.0), Vec3::ZERO, Vec3::Y, projection),
            radius: 30.0,
            covered: Plane::from_fn(width, height, |x, y| number(9, x, y) > 0.1),
            face: Plane::filled(width, height, 0),
            barycentric: Plane::filled(width, height, [0.0; 2]),
            depth: Plane::filled(width, height, 1.0),
            position: vector(20),
            normal: vector(30),
            smooth_normal: vector(30),
            geometric_normal: vector(40),
            object: ids(50),
            material: ids(60),
            base_colour: Plane::filled(width, height, [0.5; 3]),
            roughness: Plane::filled(width, height, 1.0),
            metallic: Plane::filled(width, height, 0.0),
            emissive: Plane::filled(width, height, [0.0; 3]),
        }
    }

    #[test]
    fn rows_agree_with_single_edges_on_any_picture() {
        for (width, height) in [(1, 1), (1, 40), (37, 1), (41, 35)] {
            for depth_form in [DepthForm::Plane, DepthForm::Raw] {
                let buffer = noise(width, height);
                let knobs =
                    BinaryKnobs { depth_form, curvature_falloff: 0.8, ..BinaryKnobs::default() };
                let fast = neighbour_factors(&buffer, &knobs);
                let plain = edge_by_edge(&Field::new(&buffer, &knobs));
                let pairs = fast.pixels().as_flattened().iter().zip(plain.pixels().as_flattened());
                for (a, b) in pairs {
                    assert!((a - b).abs() < 1e-3, "{a} {b} at {width} x {height}");
                }
            }
        }
    }
}
