//! [`Patch`]: a bright texel of a field that something in the ball hides from some receivers.
//!
//! A few near rays of cosine density take its light back by chance, which is seen where it is much. So it is left out of
//! what they take back, and a ray to it tells each receiver whether it has it.

use super::Ball;
use chiaro_basis::math::Vec3;
use chiaro_basis::random;
use chiaro_trace::{Tracer, Vertex};

#[derive(Clone, Copy, Debug)]
pub(super) struct Patch {
    /// Which texel.
    pub(super) texel: usize,
    /// World position.
    pub(super) place: Vec3,
    /// Scene units.
    pub(super) width: f32,
    /// Radiance times solid angle.
    pub(super) light: [f32; 3],
}

impl Patch {
    /// Whether a ray from a receiver to the place in it that a number chooses leaves the ball.
    pub(super) fn is_free(&self, ball: &Ball, tracer: &Tracer, at: &Vertex, number: usize) -> bool {
        let middle = self.place - at.position;
        let (across, up) = middle.normalize_or(at.side).any_orthonormal_pair();
        let [u, v] = random::r2(number as u64).map(|u| (u - 0.5) * self.width);
        let direction = (middle + across * u + up * v).normalize_or(at.side);
        let origin = at.position + at.side * at.offset;
        direction.dot(at.side) > 0.0
            && !tracer.occluded(&at.ray(direction, ball.exit(origin, direction)))
    }
}
