//! [`Tracer`]: rays into a frame.
//!
//! A ray walks the upper hierarchy, is taken into the space of each group that it meets, and walks
//! that group's ([`Hierarchy`]); triangles are crossed watertight.
//!
//! Of two crossings at the same distance the lower (object, face) wins, and boxes are tried a
//! little past the nearest crossing, so that results do not depend on the hierarchy.

use crate::hierarchy::{Hierarchy, Placed};
use crate::triangle::Sheared;
use chiaro_basis::math::{Affine3A, Vec3, Vec3A};
use chiaro_scene::{Alpha, Frame, Mesh, Object, Scene};
use obvhs::ray::{Ray as BoxRay, RayHit};
use std::sync::Arc;

/// A ray in world space. The direction is a unit vector; `t_max` is in scene units.
#[derive(Clone, Copy, Debug)]
pub struct Ray {
    /// Where it starts.
    pub origin: Vec3,
    /// Where it goes, a unit vector.
    pub direction: Vec3,
    /// How far it goes.
    pub t_max: f32,
}

/// Where a ray met a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Distance from the ray's origin, scene units.
    pub t: f32,
    /// Index into [`Frame::objects`].
    pub object: u32,
    /// Index into the mesh's triangles.
    pub face: u32,
    /// Barycentric coordinates of the second and the third vertex.
    pub b: [f32; 2],
}

/// Which sides of single-sided materials a ray sees.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sides {
    /// Single-sided faces are seen from their front alone: what a camera sees.
    AsMaterials,
    /// Every face is seen from both sides: what stops light.
    Both,
}

/// A frame, ready for rays.
pub struct Tracer<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// Its state at one time.
    pub frame: &'a Frame,
    pub(crate) hierarchy: Arc<Hierarchy>,
    surfaces: Vec<SurfaceKind>,
    offset: f32,
    /// The largest coordinate of the frame, scene units.
    pub(crate) size: f32,
}

/// What a ray must know of a material.
#[derive(Clone, Copy)]
struct SurfaceKind {
    double_sided: bool,
    shines: bool,
    cutoff: Option<f32>,
}

impl<'a> Tracer<'a> {
    /// Builds the hierarchies of a frame.
    pub fn new(scene: &'a Scene, frame: &'a Frame) -> Self {
        Self::with(scene, frame, Arc::new(Hierarchy::build(scene, frame)))
    }

    /// Rays into a frame over which the hierarchy stands already.
    pub fn with(scene: &'a Scene, frame: &'a Frame, hierarchy: Arc<Hierarchy>) -> Self {
        let surfaces = scene.materials.iter().map(SurfaceKind::of).collect();
        let bounds = frame.bounds();
        let size = bounds.min.abs().max(bounds.max.abs()).max_element();
        let offset =
            (1e-4 * bounds.radius()).max(disc_offset(scene, frame)).max(FAR_ROUNDING * size);
        Self { scene, frame, hierarchy, surfaces, offset, size }
    }

    /// The tracer of another frame of the same scene: what has not moved is shared, the rest keeps
    /// the shape of its hierarchy and is refitted, unless connectivity has changed.
    pub fn refit<'b>(&self, scene: &'b Scene, frame: &'b Frame) -> Tracer<'b> {
        Tracer::with(scene, frame, Arc::new(self.hierarchy.refit(scene, frame)))
    }

    /// The hierarchy, to be used again for a frame of the same shape.
    pub fn hierarchy(&self) -> &Arc<Hierarchy> {
        &self.hierarchy
    }

    /// How far off a surface rays start, scene units: a ten-thousandth of the scene's radius, more
    /// where points are drawn as discs, and where coordinates far from the origin are coarser.
    pub fn offset(&self) -> f32 {
        self.offset
    }

    /// The nearest surface along a ray.
    pub fn hit(&self, ray: &Ray, sides: Sides) -> Option<Hit> {
        let mut search = Search::default();
        self.search(ray, sides, &mut search);
        search.nearest
    }

    pub(crate) fn search(&self, ray: &Ray, sides: Sides, search: &mut Search) {
        self.visit(ray, &mut |tracer, placed, local, reach| {
            tracer.nearest_in(placed, local, reach, sides, search)
        });
    }

    /// Whether anything stands in the ray's way, from either side.
    pub fn occluded(&self, ray: &Ray) -> bool {
        match &self.hierarchy.top {
            None => self.hierarchy.placed.first().is_some_and(|p| self.blocked_in(p, ray)),
            Some(top) => !top.ray_traverse_miss(box_ray(ray), |_, i| {
                if self.blocked_in(&self.hierarchy.placed[i], ray) { 0.0 } else { f32::INFINITY }
            }),
        }
    }

    /// Calls `each` for every placed group that the ray may meet; it answers the new reach.
    pub(crate) fn visit(&self, ray: &Ray, each: &mut dyn FnMut(&Self, &Placed, &Ray, f32) -> f32) {
        let mut call = |p: &Placed, reach: f32| each(self, p, &p.local(ray), reach);
        match &self.hierarchy.top {
            None => {
                if let Some(p) = self.hierarchy.placed.first() {
                    call(p, past(ray.t_max));
                }
            }
            Some(top) => {
                let mut nothing = RayHit::none();
                top.ray_traverse(box_ray(ray), &mut nothing, |r, i| {
                    call(&self.hierarchy.placed[i], r.tmax) + BEHIND
                });
            }
        }
    }

    /// The nearest crossing in one group; answers the reach that is left, in world units.
    fn nearest_in(
        &self,
        placed: &Placed,
        local: &Ray,
        reach: f32,
        sides: Sides,
        search: &mut Search,
    ) -> f32 {
        let group = &self.hierarchy.groups[placed.group];
        let sheared = Sheared::new(local.origin, local.direction);
        let mut nothing = RayHit::none();
        let mut box_ray = box_ray(local);
        box_ray.tmax = reach + BEHIND;
        group.tree.ray_traverse(box_ray, &mut nothing, |r, i| {
            let reach = r.tmax.min(local.t_max);
            let Some(c) = sheared.cross(&group.triangles[i], reach) else { return f32::INFINITY };
            let hit = placed.hit(group.faces[i], c);
            if !self.is_there(&hit, local, &group.triangles[i], sides) {
                return f32::INFINITY;
            }
            search.meet(hit) + BEHIND
        });
        search.reach().min(reach)
    }

    fn blocked_in(&self, placed: &Placed, ray: &Ray) -> bool {
        let group = &self.hierarchy.groups[placed.group];
        let local = placed.local(ray);
        let sheared = Sheared::new(local.origin, local.direction);
        !group.tree.ray_traverse_miss(box_ray(&local), |_, i| {
            match sheared.cross(&group.triangles[i], local.t_max) {
                Some(c) if self.is_opaque(&placed.hit(group.faces[i], c)) => 0.0,
                _ => f32::INFINITY,
            }
        })
    }

    /// Whether the face is there for this ray: on the right side, and not cut away by opacity.
    pub(crate) fn is_there(
        &self,
        hit: &Hit,
        local: &Ray,
        triangle: &[Vec3; 3],
        sides: Sides,
    ) -> bool {
        if sides == Sides::AsMaterials && !self.surface(hit).double_sided {
            let [a, b, c] = *triangle;
            let outward = (b - a).cross(c - a);
            let back = outward.dot(local.direction) > 0.0;
            let mirrored = self.frame.objects[hit.object as usize].mirrored;
            // Shapes in their own space are mirrored by their matrix only afterwards.
            let flips = mirrored && self.in_world_space(hit.object);
            if back != flips {
                return false;
            }
        }
        self.is_opaque(hit)
    }

    /// Whether a ray along `direction` (world space) met the front of the face it hit.
    pub fn meets_front(&self, hit: &Hit, direction: Vec3) -> bool {
        self.face_normal(hit).dot(direction) <= 0.0
    }

    /// Unit normal in world space of the face that was hit, on its front.
    pub fn face_normal(&self, hit: &Hit) -> Vec3 {
        let [a, b, c] = self.corners(hit.object, hit.face);
        let normal = (b - a).cross(c - a).normalize_or_zero();
        if self.object(hit).mirrored { -normal } else { normal }
    }

    /// The corners of a face of an object in world space.
    pub fn corners(&self, object: u32, face: u32) -> [Vec3; 3] {
        let object = &self.frame.objects[object as usize];
        let shape = &self.frame.shapes[object.shape];
        let m = &object.world_from_shape;
        shape.mesh_in(self.scene).triangles[face as usize]
            .map(|v| m.transform_point3(shape.positions[v as usize]))
    }

    fn in_world_space(&self, object: u32) -> bool {
        self.frame.objects[object as usize].world_from_shape == Affine3A::IDENTITY
    }

    fn surface(&self, hit: &Hit) -> SurfaceKind {
        let material = self.mesh(hit).materials[hit.face as usize];
        self.surfaces[material.index()]
    }

    pub(crate) fn shines(&self, hit: &Hit) -> bool {
        self.surface(hit).shines
    }

    fn is_opaque(&self, hit: &Hit) -> bool {
        let Some(cutoff) = self.surface(hit).cutoff else { return true };
        let mesh = self.mesh(hit);
        let material = &self.scene.materials[mesh.materials[hit.face as usize].index()];
        let mut alpha = material.base_colour[3] * corner_alpha(mesh, hit);
        if let Some(used) = material.base_texture
            && let Some(uv) = crate::surface::uv_at(mesh, used.uv_set, hit)
        {
            let texture = &self.scene.textures[used.texture.index()];
            alpha *= texture.sample(used.map(uv), |_| 0.0)[3];
        }
        alpha >= cutoff
    }

    /// The object that was hit.
    pub fn object(&self, hit: &Hit) -> &'a Object {
        &self.frame.objects[hit.object as usize]
    }

    /// The mesh that was hit.
    pub fn mesh(&self, hit: &Hit) -> &'a Mesh {
        self.frame.shapes[self.object(hit).shape].mesh_in(self.scene)
    }
}

/// Rays leave a cloud's discs by some of their radius, since those of neighbours overlap; 0 where
/// there are none.
fn disc_offset(scene: &Scene, frame: &Frame) -> f32 {
    const LOOKS: usize = 1000;
    const OFF: f32 = 0.25;
    let of = |object: &Object| {
        let shape = &frame.shapes[object.shape];
        let mesh = shape.mesh_in(scene);
        let step = mesh.discs.len().div_ceil(LOOKS).max(1);
        let m = object.world_from_shape;
        let edges: Vec<f32> = (0..mesh.discs.len())
            .step_by(step)
            .map(|disc| {
                let [a, b, _] = mesh.triangles[Mesh::DISC * disc];
                let [a, b] = [a, b].map(|v| m.transform_point3(shape.positions[v as usize]));
                (a - b).length()
            })
            .collect();
        OFF * edges.iter().sum::<f32>() / edges.len().max(1) as f32
    };
    frame.objects.iter().map(of).fold(0.0, f32::max)
}

fn corner_alpha(mesh: &Mesh, hit: &Hit) -> f32 {
    if mesh.colours.is_empty() {
        return 1.0;
    }
    let t = mesh.triangles[hit.face as usize].map(|v| mesh.colours[v as usize].w);
    let [b, c] = hit.b;
    t[0] * (1.0 - b - c) + t[1] * b + t[2] * c
}

impl SurfaceKind {
    fn of(material: &chiaro_scene::Material) -> Self {
        let cutoff = match material.alpha {
            Alpha::Opaque => None,
            Alpha::Mask(cutoff) => Some(cutoff),
            Alpha::Blend => Some(0.5),
        };
        Self { double_sided: material.double_sided, shines: material.shines(), cutoff }
    }
}

/// Of the largest coordinate: some roundings of it.
const FAR_ROUNDING: f32 = 5e-7;
/// How far behind a ray's start box tests begin, in multiples of its direction.
const BEHIND: f32 = 2e-4;

/// The nearest crossing so far.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Search {
    pub(crate) nearest: Option<Hit>,
    /// The least distance at which another crossing was met.
    pub(crate) rival: Option<f32>,
    /// How far past the nearest crossing the search goes on, scene units.
    pub(crate) room: f32,
}

impl Search {
    /// Takes a crossing in; answers the reach that is left.
    fn meet(&mut self, hit: Hit) -> f32 {
        let farther = match &mut self.nearest {
            None => {
                self.nearest = Some(hit);
                return self.reach();
            }
            Some(nearest) if nearer(&hit, nearest) => std::mem::replace(nearest, hit),
            Some(_) => hit,
        };
        self.rival = Some(self.rival.map_or(farther.t, |t| t.min(farther.t)));
        self.reach()
    }

    fn reach(&self) -> f32 {
        self.nearest.map_or(f32::INFINITY, |hit| past(hit.t) + self.room)
    }
}

/// Nearer, or as near with the lower id.
fn nearer(a: &Hit, b: &Hit) -> bool {
    (a.t, a.object, a.face) < (b.t, b.object, b.face)
}

/// A little past a distance: what is as far must not be missed because its box rounds to farther.
fn past(t: f32) -> f32 {
    t * (1.0 + 16.0 * f32::EPSILON)
}

/// The ray for box tests. They skip boxes that end less than 1e-4 from the ray's start, however
/// small the scene is: so it starts farther behind, and its distances are larger by [`BEHIND`].
pub(crate) fn box_ray(ray: &Ray) -> BoxRay {
    // The box test takes the sign of an inverse for that of the direction: no zero may be negative.
    let direction = Vec3A::from(ray.direction) + Vec3A::ZERO;
    let origin = Vec3A::from(ray.origin) - direction * BEHIND;
    BoxRay::new(origin, direction, 0.0, past(ray.t_max) + BEHIND)
}
