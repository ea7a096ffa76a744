//! [`Lens`]: a camera before a picture of one size.

use crate::{Bounds, Pose, Projection};
use chiaro_basis::math::Vec3;
use std::ops::Range;

/// A [`Pose`] before a picture of one size: what is the same for all its pixels is found once.
#[derive(Clone, Copy, Debug)]
pub struct Lens {
    /// The camera.
    pub pose: Pose,
    /// Half the view's height at depth 1, of an orthographic camera at any depth.
    slope: f32,
    width: f32,
    height: f32,
}

impl Lens {
    /// A camera before a picture of `width` x `height` pixels.
    pub fn new(pose: Pose, width: f32, height: f32) -> Self {
        let slope = match pose.projection {
            Projection::Perspective { fov_y } => (0.5 * fov_y).tan(),
            Projection::Orthographic { half_height } => half_height,
        };
        Self { pose, slope, width, height }
    }

    /// [`Pose::ray`].
    pub fn ray(&self, x: f32, y: f32) -> (Vec3, Vec3) {
        let Self { pose, slope, width, height } = *self;
        let (sx, sy) = ((2.0 * x - width) / height, (height - 2.0 * y) / height);
        let across = pose.right * (sx * slope);
        match pose.projection {
            Projection::Perspective { .. } => {
                let d = pose.forward + across + pose.up * (sy * slope);
                (pose.position, d.normalize())
            }
            Projection::Orthographic { .. } => {
                (pose.position + (across + pose.up * (sy * slope)), pose.forward)
            }
        }
    }

    /// [`Pose::pixel_size`].
    pub fn pixel_size(&self, z: f32) -> f32 {
        match self.pose.projection {
            Projection::Perspective { .. } => 2.0 * z * self.slope / self.height,
            Projection::Orthographic { .. } => 2.0 * self.slope / self.height,
        }
    }

    /// The columns and the rows of the picture outside of which no ray through a pixel's centre meets
    /// what is in a box: all where the box reaches behind the eye.
    pub fn window(&self, bounds: &Bounds) -> [Range<usize>; 2] {
        let size = [self.width, self.height];
        let whole = size.map(|pixels| 0..pixels as usize);
        let mut window = [[f32::INFINITY, f32::NEG_INFINITY]; 2];
        for corner in corners(bounds) {
            let Some(at) = self.pose.project(corner, self.width, self.height) else { return whole };
            let margin = self.margin(corner);
            for ([from, to], x) in window.iter_mut().zip(at) {
                if !(x - margin).is_finite() {
                    return whole;
                }
                (*from, *to) = (from.min(x - margin), to.max(x + margin));
            }
        }
        let pixel = |x: f32, most: f32| x.clamp(0.0, most) as usize;
        std::array::from_fn(|axis| {
            let ([from, to], most) = (window[axis], size[axis]);
            pixel(from.floor(), most)..pixel(to.ceil(), most)
        })
    }

    /// How far rounding may move a point in the picture, and more: a pixel and some roundings of the
    /// largest number that took part.
    fn margin(&self, point: Vec3) -> f32 {
        const ROUNDING: f32 = 2e-6;
        let largest = point.abs().max(self.pose.position.abs()).max_element();
        let depth = self.pose.view(point).z;
        1.0 + ROUNDING * (self.height / self.slope + largest / self.pixel_size(depth)).abs()
    }
}

/// The eight corners of a box.
fn corners(&Bounds { min, max }: &Bounds) -> [Vec3; 8] {
    std::array::from_fn(|i| {
        Vec3::from_array(std::array::from_fn(|k| if i >> k & 1 == 0 { min[k] } else { max[k] }))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use chiaro_basis::math::vec3;

    fn lens(projection: Projection) -> Lens {
        Lens::new(Pose::look_at(vec3(1.0, 2.0, 5.0), Vec3::ZERO, Vec3::Y, projection), 64.0, 48.0)
    }

    /// Whether a ray meets a box.
    fn meets(bounds: &Bounds, (origin, direction): (Vec3, Vec3)) -> bool {
        let [a, b] = [bounds.min, bounds.max].map(|at| (at - origin) / direction);
        a.min(b).max_element().max(0.0) <= a.max(b).min_element()
    }

    #[test]
    fn outside_the_window_no_ray_meets_the_box() {
        for projection in
            [Projection::Perspective { fov_y: 0.7 }, Projection::Orthographic { half_height: 2.0 }]
        {
            let lens = lens(projection);
            for at in [Vec3::ZERO, vec3(-1.0, 0.3, 0.2), vec3(0.9, 1.7, 4.5), vec3(2.0, 4.0, 10.0)]
            {
                let bounds =
                    Bounds { min: at - vec3(0.5, 0.3, 0.2), max: at + vec3(0.4, 0.6, 0.3) };
                let [columns, rows] = lens.window(&bounds);
                for (x, y) in (0..48).flat_map(|y| (0..64).map(move |x| (x, y))) {
                    let ray = lens.ray(x as f32 + 0.5, y as f32 + 0.5);
                    let inside = columns.contains(&x) && rows.contains(&y);
                    assert!(inside || !meets(&bounds, ray), "{x} {y} of {columns:?} {rows:?}");
                }
            }
        }
    }

    #[test]
    fn the_window_is_not_much_more_than_the_box() {
        let bounds = Bounds { min: Vec3::splat(-0.4), max: Vec3::splat(0.4) };
        let [columns, rows] = lens(Projection::Orthographic { half_height: 2.0 }).window(&bounds);
        assert!(columns.len() < 24 && rows.len() < 24, "{columns:?} {rows:?}");
        let empty = Bounds::of(std::iter::empty());
        assert_eq!(lens(Projection::Perspective { fov_y: 0.7 }).window(&empty), [0..64, 0..48]);
    }
}
