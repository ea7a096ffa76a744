//! Implicit shapes: signed distances, and how they blend.
//!
//! A field is negative inside and close to a distance outside, growing at most about 1 a unit.
//! Blends are Quilez's polynomial ones: they reach only as far as their radius.

use chiaro_basis::math::{Vec3, vec2};

/// A union whose seam is rounded over `k` units.
pub(crate) fn merge(a: f32, b: f32, k: f32) -> f32 {
    let h = (k - (a - b).abs()).max(0.0) / k;
    a.min(b) - h * h * h * k / 6.0
}

/// `a` without `b`, the edge rounded over `k` units.
pub(crate) fn carve(a: f32, b: f32, k: f32) -> f32 {
    -merge(-a, b, k)
}

/// What is in both, the edge rounded over `k` units.
pub(crate) fn common(a: f32, b: f32, k: f32) -> f32 {
    -merge(-a, -b, k)
}

/// A sphere.
pub(crate) fn sphere(p: Vec3, centre: Vec3, radius: f32) -> f32 {
    p.distance(centre) - radius
}

/// An ellipsoid along the axes: a bound that is exact to first order near the surface.
pub(crate) fn ellipsoid(p: Vec3, centre: Vec3, half: Vec3) -> f32 {
    let q = (p - centre) / half;
    let (near, slope) = (q.length(), (q / half).length());
    if slope < 1e-9 { -half.min_element() } else { near * (near - 1.0) / slope }
}

/// A round cone: the hull of two spheres.
pub(crate) fn limb(p: Vec3, a: Vec3, b: Vec3, ra: f32, rb: f32) -> f32 {
    let axis = b - a;
    let length = axis.length().max(1e-9);
    let along = (p - a).dot(axis) / length;
    let out = ((p - a).length_squared() - along * along).max(0.0).sqrt();
    let lean = (ra - rb) / length;
    let rise = (1.0 - lean * lean).max(0.0).sqrt();
    let k = vec2(out, along).dot(vec2(-lean, rise));
    if k < 0.0 {
        (p - a).length() - ra
    } else if k > rise * length {
        (p - b).length() - rb
    } else {
        vec2(out, along).dot(vec2(rise, lean)) - ra
    }
}

/// Limbs through a row of points (x, y, z, radius), blended over `k`.
pub(crate) fn chain(p: Vec3, joints: &[(Vec3, f32)], k: f32) -> f32 {
    joints
        .windows(2)
        .map(|w| limb(p, w[0].0, w[1].0, w[0].1, w[1].1))
        .reduce(|a, b| merge(a, b, k))
        .unwrap_or(f32::INFINITY)
}

/// A field's value and gradient, from its values at the corners of a small tetrahedron.
pub(crate) fn value_and_gradient(field: impl Fn(Vec3) -> f32, p: Vec3, step: f32) -> (f32, Vec3) {
    const ARMS: [Vec3; 4] = [
        Vec3::new(1.0, -1.0, -1.0),
        Vec3::new(-1.0, -1.0, 1.0),
        Vec3::new(-1.0, 1.0, -1.0),
        Vec3::new(1.0, 1.0, 1.0),
    ];
    let values = ARMS.map(|a| field(p + a * step));
    let slope: Vec3 = ARMS.iter().zip(values).map(|(&a, v)| a * v).sum();
    (values.iter().sum::<f32>() / 4.0, slope / (4.0 * step))
}
