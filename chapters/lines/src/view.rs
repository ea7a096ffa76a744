//! [`View`]: a camera with the size of its picture, in double precision.

use chiaro_basis::math::{DVec2, DVec3, Vec3};
use chiaro_scene::{Pose, Projection};

/// A camera and a picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    /// The camera.
    pub pose: Pose,
    /// Width and height in pixels.
    pub size: (usize, usize),
    eye: DVec3,
    axes: [DVec3; 3],
    /// Pixels for a unit at depth 1, or anywhere if orthographic.
    scale: f64,
    perspective: bool,
}

/// Where a point falls in a picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Seen {
    /// In pixels, y down, pixel centres at + 0.5.
    pub at: DVec2,
    /// Along the view axis, scene units.
    pub depth: f64,
}

impl View {
    /// A camera's view in a picture of `size` pixels.
    pub fn new(pose: Pose, size: (usize, usize)) -> Self {
        let d = |v: Vec3| v.as_dvec3();
        let h = size.1 as f64;
        let (scale, perspective) = match pose.projection {
            Projection::Perspective { fov_y } => (0.5 * h / (0.5 * f64::from(fov_y)).tan(), true),
            Projection::Orthographic { half_height } => (0.5 * h / f64::from(half_height), false),
        };
        let axes = [d(pose.right), d(pose.up), d(pose.forward)];
        Self { pose, size, eye: d(pose.position), axes, scale, perspective }
    }

    /// The vector from a point to the eye; for orthographic cameras against the view direction.
    pub fn to_eye(&self, p: DVec3) -> DVec3 {
        if self.perspective { self.eye - p } else { -self.axes[2] }
    }

    /// Homogeneous picture coordinates: (x w, y w, w) in pixels, and the depth.
    pub fn homogeneous(&self, p: DVec3) -> [f64; 4] {
        let d = p - self.eye;
        let [x, y, z] = [d.dot(self.axes[0]), d.dot(self.axes[1]), d.dot(self.axes[2])];
        let (w, h) = (0.5 * self.size.0 as f64, 0.5 * self.size.1 as f64);
        if self.perspective {
            [w * z + x * self.scale, h * z - y * self.scale, z, z]
        } else {
            [w + x * self.scale, h - y * self.scale, 1.0, z]
        }
    }

    /// Where a point falls, or `None` if it is not in front of the camera.
    pub fn see(&self, p: DVec3) -> Option<Seen> {
        let [x, y, w, depth] = self.homogeneous(p);
        (depth > f64::from(self.pose.near).max(1e-9))
            .then(|| Seen { at: DVec2::new(x / w, y / w), depth })
    }

    /// Whether what is farther is smaller.
    pub fn perspective(&self) -> bool {
        self.perspective
    }

    /// The size of a pixel at a depth, in scene units.
    pub fn pixel(&self, depth: f64) -> f64 {
        if self.perspective { depth / self.scale } else { self.scale.recip() }
    }

    /// Whether a picture position is inside, or outside by less than `margin` pixels.
    pub fn holds(&self, at: DVec2, margin: f64) -> bool {
        let (w, h) = (self.size.0 as f64, self.size.1 as f64);
        at.x >= -margin && at.y >= -margin && at.x <= w + margin && at.y <= h + margin
    }
}
