//! [`Sight`]: how a receiver sees a node, and what of it is splatted.
//!
//! Nodes that share a parent are looked at all at once ([`Chooser::sights`]), one by one elsewhere ([`Chooser::sight`]);
//! both do the same steps in the same order, so that a node is seen alike to the last bit.

use crate::cut::{Chooser, FLAT, Faces, LEAST_AREA, Span, Splat};
use crate::packed::{FAN, Means};
use crate::payload::Sent;
use crate::tree::Node;
use chiaro_basis::math::{Vec3, smoothstep, vec3};

/// How a node is seen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Sight {
    /// Unit vector from the receiver to the node's mean.
    pub direction: Vec3,
    /// Distance, scene units.
    pub distance: f32,
    /// The mean normal.
    pub axis: Vec3,
    /// How far the node counts as flat, from 0 to 1.
    pub flatness: f32,
    /// Of the normal of a flat node and the direction back to the receiver.
    pub cosine: f32,
    /// Whether it lies in the near field.
    pub marks: bool,
}

/// How siblings are seen, side by side.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sights {
    direction: [[f32; FAN]; 3],
    distance: [f32; FAN],
    flatness: [f32; FAN],
    cosine: [f32; FAN],
    /// The near field's radius, scene units.
    near: f32,
    /// Which are not under the tangent plane, in a mask of bits.
    pub above: u32,
    /// Which are flat and show their backs, in a mask of bits.
    pub behind: u32,
}

impl Chooser {
    /// How a node is seen; `None` under the tangent plane.
    pub(crate) fn sight(&self, node: &Node) -> Option<Sight> {
        let (direction, distance) = (node.mean - self.from).normalize_and_length();
        if self.above.is_some_and(|n| direction.dot(n) <= 0.0) {
            return None;
        }
        let length = node.axis.length();
        let flatness = if self.flat { smoothstep(FLAT, length) } else { 0.0 };
        let cosine = -(node.axis / length).dot(direction);
        let marks = distance <= self.near;
        Some(Sight { direction, distance, axis: node.axis, flatness, cosine, marks })
    }

    /// How siblings are seen.
    #[allow(clippy::needless_range_loop, reason = "lanes are vectors of the processor")]
    pub(crate) fn sights(&self, means: &Means) -> Sights {
        let (from, up) = (self.from, self.above.unwrap_or(Vec3::ZERO));
        let least = if self.above.is_some() { 0.0 } else { -1.0 };
        let ([x, y, z], [nx, ny, nz]) = (&means.mean, &means.axis);
        let mut direction = [[0.0f32; FAN]; 3];
        let (mut distance, mut flatness, mut cosine) =
            ([0.0f32; FAN], [0.0f32; FAN], [0.0f32; FAN]);
        let (mut above, mut behind) = ([0u32; FAN], [0u32; FAN]);
        for k in 0..FAN {
            let (dx, dy, dz) = (x[k] - from.x, y[k] - from.y, z[k] - from.z);
            let long = (dx * dx + dy * dy + dz * dz).sqrt();
            let share = if long > 0.0 { 1.0 / long } else { 0.0 };
            let (ux, uy, uz) = (dx * share, dy * share, dz * share);
            let square = nx[k] * nx[k] + ny[k] * ny[k] + nz[k] * nz[k];
            let length = square.sqrt();
            let away = nx[k] * dx + ny[k] * dy + nz[k] * dz >= 0.0;
            cosine[k] = -(nx[k] / length * ux + ny[k] / length * uy + nz[k] / length * uz);
            flatness[k] = smoothstep(FLAT, length);
            (direction[0][k], direction[1][k], direction[2][k]) = (ux, uy, uz);
            distance[k] = long;
            above[k] = u32::from(ux * up.x + uy * up.y + uz * up.z > least) << k;
            behind[k] = u32::from(away & (square >= FLAT[1] * FLAT[1])) << k;
        }
        let mask = |bits: &[u32; FAN]| bits.iter().fold(0, |mask, bit| mask | bit);
        let (above, behind) = (mask(&above), mask(&behind));
        let near = self.near;
        if !self.flat {
            let flatness = [0.0; FAN];
            return Sights { direction, distance, flatness, cosine, near, above, behind: 0 };
        }
        Sights { direction, distance, flatness, cosine, near, above, behind }
    }
}

impl Sights {
    /// How one is seen.
    pub(crate) fn one(&self, k: usize, axis: Vec3) -> Sight {
        Sight {
            direction: vec3(self.direction[0][k], self.direction[1][k], self.direction[2][k]),
            distance: self.distance[k],
            axis,
            flatness: self.flatness[k],
            cosine: self.cosine[k],
            marks: self.distance[k] <= self.near,
        }
    }
}

impl Sight {
    /// What is splatted of a node of an area that sends this in a direction; `face` is what a flat one has
    /// on a side: area and radiance.
    #[inline]
    pub(crate) fn splat(
        &self,
        node_area: f32,
        sent: impl FnOnce(Vec3) -> Sent,
        face: impl FnOnce(usize) -> (f32, [f32; 3]),
    ) -> Option<Splat> {
        let Self { direction, distance, axis, flatness, cosine, marks } = *self;
        let (mut area, mut radiance) = (0.0, [0.0; 3]);
        if flatness < 1.0 {
            let towards = sent(-direction);
            let least = LEAST_AREA * node_area;
            area = towards.area.max(0.0);
            radiance = towards.light.map(|l| l.max(0.0) / towards.area.max(least));
        }
        if flatness > 0.0 {
            let (own, light) = face(usize::from(cosine <= 0.0));
            let mix = |a: f32, b: f32| a + (b - a) * flatness;
            area = mix(area, own * cosine.abs());
            radiance = std::array::from_fn(|c| mix(radiance[c], light[c]));
        }
        let solid_angle = area / (distance * distance);
        let axis = if axis.dot(direction) > 0.0 { -axis } else { axis };
        let span = Span::default();
        let splat = Splat { direction, distance, solid_angle, radiance, axis, marks, span };
        (solid_angle > 0.0).then_some(splat)
    }

    /// The same of a flat node's two sides.
    pub(crate) fn of_faces(
        &self,
        node_area: f32,
        sent: impl FnOnce(Vec3) -> Sent,
        faces: &Faces,
    ) -> Option<Splat> {
        self.splat(node_area, sent, |side| (faces.area[side], faces.radiance[side]))
    }
}
