//! The default view: from where to look at a scene that brings no camera.
//!
//! An object is seen from three quarters: azimuth 30, elevation 15 degrees, in a picture 28
//! degrees high that its box fills. A scene is a room when, at some point of a coarse grid inside
//! its box, at least 95 % of evenly spread rays meet the front of a face, and their median length
//! is over 2 % of the diagonal and half a unit (a metre in glTF: helmets and cannons are hollow
//! too), or over 12 % of the diagonal; then the camera stands inside, at 45 % of the room's height,
//! where the median length is greatest, and looks level along the deepest quarter.

use crate::tracer::{Ray, Sides, Tracer};
use chiaro_basis::math::{Quat, Vec3};
use chiaro_scene::{Bounds, Frame, Pose, Projection};
use rayon::prelude::*;

/// What the view was chosen for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Setting {
    /// Something to be looked at from outside.
    Object,
    /// Something to stand in.
    Room,
}

/// Rays from each grid point.
const RAYS: usize = 96;

/// What a default view is made from: the shape over a shot, and whether it is a room.
pub struct Framing {
    /// The box of everything, over the shot.
    pub bounds: Bounds,
    points: Vec<Vec3>,
    room: Option<Stand>,
}

/// A place inside a room.
struct Stand {
    eye: Vec3,
    forward: Vec3,
}

impl Framing {
    /// The framing of a shot: `tracer` holds its first frame, `frames` are a few of all.
    pub fn of(tracer: &Tracer, frames: &[Frame]) -> Self {
        let points: Vec<Vec3> = frames.iter().flat_map(corners).collect();
        let bounds = Bounds::of(frames.iter().flat_map(|f| {
            let b = f.bounds();
            [b.min, b.max]
        }));
        Self { bounds, points, room: stand_in_room(tracer, &tracer.frame.bounds()) }
    }

    /// A good aspect (width over height): the shape's own in the default view, between 3:4 and
    /// 4:3; rooms are 4:3.
    pub fn aspect(&self, orbit: f32) -> f32 {
        if self.room.is_some() {
            return 4.0 / 3.0;
        }
        let pose = three_quarter(self.bounds.centre(), 1.0, orbit);
        let extent = Bounds::of(self.points.iter().map(|p| pose.view(*p)));
        let size = extent.max - extent.min;
        (size.x / size.y.max(f32::MIN_POSITIVE)).clamp(0.75, 4.0 / 3.0)
    }

    /// The default view for a picture of this `aspect`, turned by `orbit` degrees.
    pub fn view(&self, aspect: f32, orbit: f32) -> (Pose, Setting) {
        match &self.room {
            Some(stand) => (stand.view(orbit), Setting::Room),
            None => (object_view(&self.points, &self.bounds, aspect, orbit), Setting::Object),
        }
    }
}

/// World positions of at most some thousands of vertices: enough to frame a shape.
fn corners(frame: &Frame) -> Vec<Vec3> {
    let all: usize = frame.objects.iter().map(|o| frame.shapes[o.shape].positions.len()).sum();
    let step = all / 20_000 + 1;
    frame.objects.iter().flat_map(|o| frame.world_positions(o)).step_by(step).collect()
}

fn three_quarter(target: Vec3, distance: f32, orbit: f32) -> Pose {
    let turn = Quat::from_rotation_y((30.0 + orbit).to_radians())
        * Quat::from_rotation_x(-15f32.to_radians());
    let from = target + turn * Vec3::Z * distance;
    Pose::look_at(from, target, Vec3::Y, Projection::Perspective { fov_y: 28f32.to_radians() })
}

/// The three-quarter view in which the points fill the picture but for a margin.
fn object_view(points: &[Vec3], bounds: &Bounds, aspect: f32, orbit: f32) -> Pose {
    let mut pose = three_quarter(bounds.centre(), 1.0, orbit);
    let Projection::Perspective { fov_y } = pose.projection else { return pose };
    const FILL: f32 = 0.92;
    let tan = [0.5 * fov_y].map(f32::tan)[0] * FILL;
    let (tx, ty) = (tan * aspect, tan);
    // Each side plane of the frustum touches the points: the two distances to them per axis meet
    // in the camera's position, and the farther of the two axes decides.
    let flat: Vec<Vec3> = points.iter().map(|p| pose.view(*p)).collect();
    let most = |f: &dyn Fn(&Vec3) -> f32| flat.iter().map(f).fold(f32::NEG_INFINITY, f32::max);
    let (right, left) = (most(&|v| v.x - tx * v.z), most(&|v| -v.x - tx * v.z));
    let (top, bottom) = (most(&|v| v.y - ty * v.z), most(&|v| -v.y - ty * v.z));
    let back = ((right + left) / (2.0 * tx)).max((top + bottom) / (2.0 * ty));
    let shift = pose.right * (0.5 * (right - left)) + pose.up * (0.5 * (top - bottom));
    pose.position += shift - pose.forward * back;
    if !pose.position.is_finite() {
        pose.position = bounds.centre() - pose.forward;
    }
    pose
}

/// Where to stand, if the scene is a room: of the eyes above or below the passing points, the one
/// that sees farthest. (A point under the roof may be the freest, and its eye inside a column.)
fn stand_in_room(tracer: &Tracer, bounds: &Bounds) -> Option<Stand> {
    let diagonal = 2.0 * bounds.radius();
    let eyes: Vec<Option<(f32, Vec3)>> = grid(bounds)
        .into_par_iter()
        .map(|p| {
            let is_roomy = |m: &f32| *m > 0.12 * diagonal || (*m > 0.02 * diagonal && *m > 0.5);
            median_length(tracer, p).filter(is_roomy)?;
            let eye = eye_over(tracer, p);
            Some((median_length(tracer, eye)?, eye))
        })
        .collect();
    let best = eyes.into_iter().flatten().max_by(|a, b| a.0.total_cmp(&b.0))?;
    Some(Stand::at(tracer, best.1))
}

/// The distance to the nearest surface, 0 where there is none.
fn reach(tracer: &Tracer, origin: Vec3, direction: Vec3) -> f32 {
    let ray = Ray { origin, direction, t_max: f32::INFINITY };
    tracer.hit(&ray, Sides::Both).map_or(0.0, |h| h.t)
}

/// The place above or below `point` at 45 % of the room's height there.
fn eye_over(tracer: &Tracer, point: Vec3) -> Vec3 {
    let floor = point.y - reach(tracer, point, -Vec3::Y);
    let ceiling = point.y + reach(tracer, point, Vec3::Y);
    Vec3::new(point.x, floor + 0.45 * (ceiling - floor), point.z)
}

/// Points of a coarse grid inside the box.
fn grid(bounds: &Bounds) -> Vec<Vec3> {
    const N: usize = 6;
    let at = |i: usize| (i as f32 + 0.5) / N as f32;
    let size = bounds.max - bounds.min;
    (0..N * N * N)
        .map(|i| bounds.min + size * Vec3::new(at(i % N), at(i / N % N), at(i / N / N)))
        .collect()
}

/// The median length of evenly spread rays from a point, if nearly all meet the front of a face.
fn median_length(tracer: &Tracer, origin: Vec3) -> Option<f32> {
    let mut lengths = Vec::with_capacity(RAYS);
    for direction in sphere() {
        let ray = Ray { origin, direction, t_max: f32::INFINITY };
        if let Some(hit) = tracer.hit(&ray, Sides::Both)
            && tracer.meets_front(&hit, direction)
        {
            lengths.push(hit.t);
        }
    }
    if lengths.len() * 100 < RAYS * 95 {
        return None;
    }
    let middle = lengths.len() / 2;
    Some(*lengths.select_nth_unstable_by(middle, f32::total_cmp).1)
}

/// Evenly spread directions: a spherical Fibonacci lattice.
fn sphere() -> impl Iterator<Item = Vec3> {
    (0..RAYS).map(|i| {
        let z = 1.0 - (2 * i + 1) as f32 / RAYS as f32;
        let r = (1.0 - z * z).sqrt();
        let angle = i as f32 * 2.399_963_2;
        Vec3::new(r * angle.cos(), z, r * angle.sin())
    })
}

impl Stand {
    /// At `eye`, facing the deepest quarter.
    fn at(tracer: &Tracer, eye: Vec3) -> Self {
        const STEPS: usize = 72;
        let heading =
            |k: usize| Quat::from_rotation_y(k as f32 * std::f32::consts::TAU / STEPS as f32);
        let depths: Vec<f32> =
            (0..STEPS).map(|k| reach(tracer, eye, heading(k) * -Vec3::Z)).collect();
        // A quarter of the circle, centred on k: the view is about as wide.
        let quarter = |k: usize| -> f32 {
            (0..=STEPS / 4).map(|i| depths[(k + STEPS + i - STEPS / 8) % STEPS]).sum()
        };
        let best = (0..STEPS).max_by(|&a, &b| quarter(a).total_cmp(&quarter(b))).unwrap_or(0);
        Self { eye, forward: heading(best) * -Vec3::Z }
    }

    /// The level view, 75 degrees wide at 4:3.
    fn view(&self, orbit: f32) -> Pose {
        let forward = Quat::from_rotation_y(orbit.to_radians()) * self.forward;
        let fov_y = 2.0 * (0.75 * (37.5f32).to_radians().tan()).atan();
        let projection = Projection::Perspective { fov_y };
        Pose::look_at(self.eye, self.eye + forward, Vec3::Y, projection)
    }
}
