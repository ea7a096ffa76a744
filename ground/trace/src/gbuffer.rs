//! [`GBuffer`]: what a camera sees, pixel by pixel, before any light.
//!
//! One ray goes through each pixel's centre. A pixel without geometry is not covered; its values
//! are zero and mean nothing. Ids are indices plus one, so that 0 is the background.

use crate::surface::{Surface, Surfaces};
use crate::tracer::{Hit, Ray, Tracer};
use chiaro_basis::math::Vec3;
use chiaro_basis::{Result, Run};
use chiaro_image::Plane;
use chiaro_scene::{Lens, Pose};
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
    /// Which of its mesh's triangles each pixel shows.
    pub face: Plane<u32>,
    /// Where on the triangle: barycentric coordinates of the second and the third vertex.
    pub barycentric: Plane<[f32; 2]>,
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
    /// Object id: index in the frame's objects plus one.
    pub object: Plane<u32>,
    /// Material id: index of the scene's materials plus one.
    pub material: Plane<u32>,
    /// Linear base colour.
    pub base_colour: Plane<[f32; 3]>,
    /// Perceptual roughness.
    pub roughness: Plane<f32>,
    /// 0 = dielectric, 1 = metal.
    pub metallic: Plane<f32>,
    /// Emitted radiance.
    pub emissive: Plane<[f32; 3]>,
}

impl GBuffer {
    /// Traces one ray through each of `width` x `height` pixels.
    pub fn trace(
        tracer: &Tracer,
        surfaces: &Surfaces,
        pose: &Pose,
        (width, height): (usize, usize),
        run: &Run,
    ) -> Result<Self> {
        let bounds = tracer.frame.bounds();
        let mut buffer = Self::empty(pose, bounds.radius(), (width, height));
        let lens = pose.lens(width as f32, height as f32);
        let [columns, seen] = lens.window(&bounds);
        let rows: Vec<Row> = buffer.rows().collect();
        let rows = rows.into_par_iter().enumerate().filter(|(y, _)| seen.contains(y));
        rows.try_for_each(|(y, mut row)| {
            run.check()?;
            for x in columns.clone() {
                if let Some((hit, surface)) = pixel(tracer, surfaces, &lens, (x, y)) {
                    row.set(x, hit, &surface, pose);
                }
            }
            Ok(())
        })?;
        Ok(buffer)
    }

    /// A buffer in which nothing is covered.
    pub fn empty(pose: &Pose, radius: f32, (w, h): (usize, usize)) -> Self {
        Self {
            pose: *pose,
            radius,
            covered: Plane::filled(w, h, false),
            face: Plane::filled(w, h, 0),
            barycentric: Plane::filled(w, h, [0.0; 2]),
            depth: Plane::filled(w, h, 0.0),
            position: Plane::filled(w, h, [0.0; 3]),
            normal: Plane::filled(w, h, [0.0; 3]),
            smooth_normal: Plane::filled(w, h, [0.0; 3]),
            geometric_normal: Plane::filled(w, h, [0.0; 3]),
            object: Plane::filled(w, h, 0),
            material: Plane::filled(w, h, 0),
            base_colour: Plane::filled(w, h, [0.0; 3]),
            roughness: Plane::filled(w, h, 0.0),
            metallic: Plane::filled(w, h, 0.0),
            emissive: Plane::filled(w, h, [0.0; 3]),
        }
    }

    /// The rows of all planes, each to be filled by itself.
    fn rows(&mut self) -> impl Iterator<Item = Row<'_>> {
        let width = self.covered.width().max(1);
        fn cut<T>(plane: &mut Plane<T>, width: usize) -> std::slice::ChunksMut<'_, T> {
            plane.pixels_mut().chunks_mut(width)
        }
        let covered = cut(&mut self.covered, width);
        let mut face = cut(&mut self.face, width);
        let mut barycentric = cut(&mut self.barycentric, width);
        let mut depth = cut(&mut self.depth, width);
        let mut position = cut(&mut self.position, width);
        let mut normal = cut(&mut self.normal, width);
        let mut smooth_normal = cut(&mut self.smooth_normal, width);
        let mut geometric_normal = cut(&mut self.geometric_normal, width);
        let mut object = cut(&mut self.object, width);
        let mut material = cut(&mut self.material, width);
        let mut base_colour = cut(&mut self.base_colour, width);
        let mut roughness = cut(&mut self.roughness, width);
        let mut metallic = cut(&mut self.metallic, width);
        let mut emissive = cut(&mut self.emissive, width);
        covered.map_while(move |covered| {
            Some(Row {
                covered,
                face: face.next()?,
                barycentric: barycentric.next()?,
                depth: depth.next()?,
                position: position.next()?,
                normal: normal.next()?,
                smooth_normal: smooth_normal.next()?,
                geometric_normal: geometric_normal.next()?,
                object: object.next()?,
                material: material.next()?,
                base_colour: base_colour.next()?,
                roughness: roughness.next()?,
                metallic: metallic.next()?,
                emissive: emissive.next()?,
            })
        })
    }

    /// Lets go of what only light and motion need: the planes of hits, base colours, roughness, metal and
    /// emission are empty afterwards.
    pub fn forget_light(&mut self) {
        self.face = Plane::default();
        self.barycentric = Plane::default();
        self.base_colour = Plane::default();
        self.roughness = Plane::default();
        self.metallic = Plane::default();
        self.emissive = Plane::default();
    }

    /// Width and height in pixels.
    pub fn size(&self) -> (usize, usize) {
        self.covered.size()
    }

    /// Where a covered pixel's ray met the scene, as far as rays from there need it: `t` is the depth
    /// along the view axis.
    pub fn hit(&self, pixel: (usize, usize)) -> Hit {
        let object = self.object[pixel] - 1;
        let (face, b) = (self.face[pixel], self.barycentric[pixel]);
        Hit { t: self.depth[pixel], object, face, b }
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

/// One row of every plane.
struct Row<'a> {
    covered: &'a mut [bool],
    face: &'a mut [u32],
    barycentric: &'a mut [[f32; 2]],
    depth: &'a mut [f32],
    position: &'a mut [[f32; 3]],
    normal: &'a mut [[f32; 3]],
    smooth_normal: &'a mut [[f32; 3]],
    geometric_normal: &'a mut [[f32; 3]],
    object: &'a mut [u32],
    material: &'a mut [u32],
    base_colour: &'a mut [[f32; 3]],
    roughness: &'a mut [f32],
    metallic: &'a mut [f32],
    emissive: &'a mut [[f32; 3]],
}

impl Row<'_> {
    fn set(&mut self, x: usize, hit: Hit, s: &Surface, pose: &Pose) {
        self.covered[x] = true;
        self.face[x] = hit.face;
        self.barycentric[x] = hit.b;
        self.depth[x] = pose.view(s.position).z;
        self.position[x] = s.position.to_array();
        self.normal[x] = s.normal.to_array();
        self.smooth_normal[x] = s.smooth_normal.to_array();
        self.geometric_normal[x] = s.geometric_normal.to_array();
        self.object[x] = hit.object + 1;
        self.material[x] = s.material.index() as u32 + 1;
        self.base_colour[x] = s.base_colour;
        self.roughness[x] = s.roughness;
        // Memory that stays zero costs nothing.
        if s.metallic != 0.0 {
            self.metallic[x] = s.metallic;
        }
        if s.emissive != [0.0; 3] {
            self.emissive[x] = s.emissive;
        }
    }
}

/// What the ray through the centre of a pixel meets.
fn pixel(
    tracer: &Tracer,
    surfaces: &Surfaces,
    lens: &Lens,
    (x, y): (usize, usize),
) -> Option<(Hit, Surface)> {
    let Lens { pose, .. } = lens;
    let (origin, direction) = lens.ray(x as f32 + 0.5, y as f32 + 0.5);
    let start = pose.near / direction.dot(pose.forward);
    let ray = Ray { origin: origin + direction * start, direction, t_max: f32::INFINITY };
    let hit = tracer.seen(&ray)?;
    let depth = (start + hit.t) * direction.dot(pose.forward);
    let surface = surfaces.at(tracer, &hit, direction, lens.pixel_size(depth));
    Some((hit, surface))
}
