//! [`GBuffer`]: what a camera sees, pixel by pixel, before any light.
//!
//! One ray goes through each pixel's centre. A pixel without geometry is not covered; its values
//! are zero and mean nothing. Ids are indices plus one, so that 0 is the background.

use crate::surface::{Surface, Surfaces};
use crate::tracer::{Hit, Ray, Sides, Tracer};
use chiaro_basis::math::Vec3;
use chiaro_basis::{Result, Run};
use chiaro_image::Plane;
use chiaro_scene::{Frame, Pose};
use rayon::prelude::*;

/// What a camera sees. All planes have the picture's size.
#[derive(Clone, Debug)]
pub struct GBuffer {
    /// The camera.
    pub pose: Pose,
    /// Half the diagonal of the scene's box: the object's radius R, in scene units.
    pub radius: f32,
    /// Whether there is geometry.
    pub covered: Plane<bool>,
    /// Where each pixel's ray met the scene; its `object` is `u32::MAX` where it met nothing.
    pub hit: Plane<Hit>,
    /// Depth along the view axis, scene units.
    pub depth: Plane<f32>,
    /// World position.
    pub position: Plane<[f32; 3]>,
    /// Unit shading normal in world space, normal textures included, on the side that is seen.
    pub normal: Plane<[f32; 3]>,
    /// Unit interpolated normal in world space, without normal textures.
    pub smooth_normal: Plane<[f32; 3]>,
    /// Unit normal of the triangle in world space, on the side that is seen.
    pub geometric_normal: Plane<[f32; 3]>,
    /// Object id: index of [`Frame::objects`] plus one.
    pub object: Plane<u32>,
    /// Material id: index of the scene's materials plus one.
    pub material: Plane<u32>,
    /// Linear base colour.
    pub base_colour: Plane<[f32; 3]>,
    /// Perceptual roughness.
    pub roughness: Plane<f32>,
    /// Emitted radiance.
    pub emissive: Plane<[f32; 3]>,
}

/// The hit of a pixel without geometry.
const NOTHING: Hit = Hit { t: f32::INFINITY, object: u32::MAX, face: u32::MAX, b: [0.0; 2] };

impl GBuffer {
    /// Traces one ray through each of `width` x `height` pixels.
    pub fn trace(
        tracer: &Tracer,
        surfaces: &Surfaces,
        pose: &Pose,
        (width, height): (usize, usize),
        run: &Run,
    ) -> Result<Self> {
        let rows: Vec<Vec<(Hit, Option<Surface>)>> = (0..height)
            .into_par_iter()
            .map(|y| {
                run.check()?;
                Ok((0..width)
                    .map(|x| pixel(tracer, surfaces, pose, (x, y), (width, height)))
                    .collect())
            })
            .collect::<Result<_>>()?;
        let seen = Plane::from_pixels(width, height, rows.into_iter().flatten().collect());
        Ok(Self::from_surfaces(pose, tracer.frame, &seen))
    }

    fn from_surfaces(pose: &Pose, frame: &Frame, seen: &Plane<(Hit, Option<Surface>)>) -> Self {
        fn take<T: Send + Default>(
            seen: &Plane<(Hit, Option<Surface>)>,
            f: impl Fn(&Surface) -> T + Sync + Send,
        ) -> Plane<T> {
            seen.map(|(_, s)| s.as_ref().map(&f).unwrap_or_default())
        }
        Self {
            pose: *pose,
            radius: frame.bounds().radius(),
            covered: seen.map(|(_, s)| s.is_some()),
            hit: seen.map(|(h, _)| *h),
            depth: take(seen, |s| pose.view(s.position).z),
            position: take(seen, |s| s.position.to_array()),
            normal: take(seen, |s| s.normal.to_array()),
            smooth_normal: take(seen, |s| s.smooth_normal.to_array()),
            geometric_normal: take(seen, |s| s.geometric_normal.to_array()),
            object: seen.map(|(h, s)| if s.is_some() { h.object + 1 } else { 0 }),
            material: take(seen, |s| s.material.index() as u32 + 1),
            base_colour: take(seen, |s| s.base_colour),
            roughness: take(seen, |s| s.roughness),
            emissive: take(seen, |s| s.emissive),
        }
    }

    /// Width and height in pixels.
    pub fn size(&self) -> (usize, usize) {
        self.covered.size()
    }

    /// Unit vector from a surface point to the eye.
    pub fn to_eye(&self, position: Vec3) -> Vec3 {
        match self.pose.projection {
            chiaro_scene::Projection::Perspective { .. } => {
                (self.pose.position - position).normalize_or(-self.pose.forward)
            }
            chiaro_scene::Projection::Orthographic { .. } => -self.pose.forward,
        }
    }

    /// A plane of `value(x, y)` over covered pixels, 0 elsewhere; rows in parallel.
    pub fn over_covered<T: Send + Default>(
        &self,
        value: impl Fn(usize, usize) -> T + Sync,
    ) -> Plane<T> {
        let (w, h) = self.size();
        Plane::from_fn(w, h, |x, y| if self.covered[(x, y)] { value(x, y) } else { T::default() })
    }
}

/// What the ray through the centre of a pixel meets.
fn pixel(
    tracer: &Tracer,
    surfaces: &Surfaces,
    pose: &Pose,
    (x, y): (usize, usize),
    (width, height): (usize, usize),
) -> (Hit, Option<Surface>) {
    let (w, h) = (width as f32, height as f32);
    let (origin, direction) = pose.ray(x as f32 + 0.5, y as f32 + 0.5, w, h);
    let start = pose.near / direction.dot(pose.forward);
    let ray = Ray { origin: origin + direction * start, direction, t_max: f32::INFINITY };
    let Some(hit) = tracer.hit(&ray, Sides::AsMaterials) else { return (NOTHING, None) };
    let depth = (start + hit.t) * direction.dot(pose.forward);
    let surface = surfaces.at(tracer, &hit, direction, pose.pixel_size(depth, h));
    (hit, Some(surface))
}
