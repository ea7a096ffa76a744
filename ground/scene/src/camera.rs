//! [`Camera`] as a file has it, and [`Pose`]: a camera in world space at one time.

use crate::{Lens, NodeId};
use chiaro_basis::math::{DAffine3, DMat3, DVec3, Mat4, Vec3, Vec4};

/// A camera at a node; it looks along the node's -z with y up.
#[derive(Clone, Debug)]
pub struct Camera {
    /// The name in the file, or empty.
    pub name: String,
    /// Where it hangs.
    pub node: NodeId,
    /// How it sees.
    pub projection: Projection,
    /// Width over height, if the file says so.
    pub aspect: Option<f32>,
}

/// How a camera sees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Projection {
    /// With a vertical angle of view in radians.
    Perspective {
        /// The whole vertical angle.
        fov_y: f32,
    },
    /// With half the height of the view in scene units.
    Orthographic {
        /// Half the height.
        half_height: f32,
    },
}

/// A camera in world space at one time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    /// The centre of projection.
    pub position: Vec3,
    /// Unit vector to the right of the picture.
    pub right: Vec3,
    /// Unit vector to its top.
    pub up: Vec3,
    /// Unit vector into the picture.
    pub forward: Vec3,
    /// How it sees.
    pub projection: Projection,
    /// Nothing nearer along `forward` is seen, in scene units.
    pub near: f32,
}

impl Pose {
    /// A pose at `position` that looks at `target`, `up` being roughly the top of the picture.
    pub fn look_at(position: Vec3, target: Vec3, up: Vec3, projection: Projection) -> Self {
        let forward = (target - position).normalize_or(Vec3::NEG_Z);
        let right = forward.cross(up).normalize_or(forward.any_orthonormal_vector());
        Self { position, right, up: right.cross(forward), forward, projection, near: 0.0 }
    }

    /// The pose of a camera whose node has this matrix: it looks along the node's -z with y up.
    /// Scale counts for nothing; axes that a degenerate matrix lost are made up.
    pub fn of_node(world_from_node: &DAffine3, projection: Projection) -> Self {
        let DMat3 { x_axis: x, y_axis: y, z_axis: z, .. } = world_from_node.matrix3;
        let forward = -z.try_normalize().or_else(|| x.cross(y).try_normalize()).unwrap_or(DVec3::Z);
        let across = |v: DVec3| (v - forward * v.dot(forward)).try_normalize();
        let right = across(forward.cross(y)).or_else(|| across(x));
        let right = right.unwrap_or_else(|| forward.any_orthonormal_vector());
        let position = world_from_node.translation.as_vec3();
        Self {
            position: if position.is_finite() { position } else { Vec3::ZERO },
            right: right.as_vec3(),
            up: right.cross(forward).as_vec3(),
            forward: forward.as_vec3(),
            projection,
            near: 0.0,
        }
    }

    /// View coordinates of a world point: x right, y up, z along the view axis (its depth).
    pub fn view(&self, point: Vec3) -> Vec3 {
        let d = point - self.position;
        Vec3::new(d.dot(self.right), d.dot(self.up), d.dot(self.forward))
    }

    /// Where a world point falls in a picture of `width` x `height` pixels, y down, or `None`
    /// behind a perspective camera.
    pub fn project(&self, point: Vec3, width: f32, height: f32) -> Option<[f32; 2]> {
        let v = self.view(point);
        let scale = match self.projection {
            Projection::Perspective { fov_y } => {
                if v.z <= 0.0 {
                    return None;
                }
                height / (2.0 * v.z * (0.5 * fov_y).tan())
            }
            Projection::Orthographic { half_height } => height / (2.0 * half_height),
        };
        Some([0.5 * width + v.x * scale, 0.5 * height - v.y * scale])
    }

    /// Origin and unit direction of the ray through the pixel position (`x`, `y`), pixel centres
    /// at + 0.5, y down.
    pub fn ray(&self, x: f32, y: f32, width: f32, height: f32) -> (Vec3, Vec3) {
        self.lens(width, height).ray(x, y)
    }

    /// The size of a pixel at depth `z`, in scene units.
    pub fn pixel_size(&self, z: f32, height: f32) -> f32 {
        self.lens(height, height).pixel_size(z)
    }

    /// The camera before a picture of `width` x `height` pixels.
    pub fn lens(&self, width: f32, height: f32) -> Lens {
        Lens::new(*self, width, height)
    }

    /// The matrix from world to clip space for a picture of this `aspect` (width over height): x
    /// and y in [-w, w] inside the picture, y up, z the depth along the view axis.
    pub fn clip_from_world(&self, aspect: f32) -> Mat4 {
        let (scale, row_w) = match self.projection {
            Projection::Perspective { fov_y } => (1.0 / (0.5 * fov_y).tan(), self.forward),
            Projection::Orthographic { half_height } => (1.0 / half_height, Vec3::ZERO),
        };
        let row = |axis: Vec3, at: f32| axis.extend(at - axis.dot(self.position));
        let w = if row_w == Vec3::ZERO { Vec4::W } else { row(row_w, 0.0) };
        Mat4::from_cols(
            row(self.right * (scale / aspect), 0.0),
            row(self.up * scale, 0.0),
            row(self.forward, 0.0),
            w,
        )
        .transpose()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use chiaro_basis::math::vec3;

    #[test]
    fn rays_and_projection_are_inverse() {
        for projection in
            [Projection::Perspective { fov_y: 0.7 }, Projection::Orthographic { half_height: 2.0 }]
        {
            let pose = Pose::look_at(vec3(1.0, 2.0, 5.0), vec3(0.1, 0.0, 0.0), Vec3::Y, projection);
            let (origin, direction) = pose.ray(31.5, 7.25, 64.0, 48.0);
            let [x, y] = pose.project(origin + direction * 3.0, 64.0, 48.0).unwrap();
            assert!((x - 31.5).abs() < 1e-3 && (y - 7.25).abs() < 1e-3, "{x} {y}");
        }
    }

    #[test]
    fn the_top_of_the_picture_is_up() {
        let pose = Pose::look_at(
            vec3(0.0, 0.0, 5.0),
            Vec3::ZERO,
            Vec3::Y,
            Projection::Perspective { fov_y: 0.7 },
        );
        let [x, y] = pose.project(vec3(0.1, 0.5, 0.0), 100.0, 100.0).unwrap();
        assert!(x > 50.0 && y < 50.0);
    }

    #[test]
    fn the_clip_matrix_agrees_with_projection() {
        for projection in
            [Projection::Perspective { fov_y: 0.7 }, Projection::Orthographic { half_height: 2.0 }]
        {
            let pose = Pose::look_at(vec3(1.0, 2.0, 5.0), Vec3::ZERO, Vec3::Y, projection);
            let p = vec3(0.3, 0.4, -0.2);
            let clip = pose.clip_from_world(4.0 / 3.0) * p.extend(1.0);
            let [x, y] = pose.project(p, 64.0, 48.0).unwrap();
            assert!(((clip.x / clip.w + 1.0) * 32.0 - x).abs() < 1e-3);
            assert!(((1.0 - clip.y / clip.w) * 24.0 - y).abs() < 1e-3);
        }
    }
}
