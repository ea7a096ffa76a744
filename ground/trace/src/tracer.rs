//! [`Tracer`]: rays into a frame.
//!
//! 1. Shapes drawn once are merged, in world space, into one group of triangles; each shape drawn
//!    several times is a group of its own.
//! 2. Over every group stands a compressed eight-wide bounding-volume hierarchy (Ylitie, Karras and
//!    Laine 2017), over the placed groups another one.
//! 3. A ray walks the upper hierarchy, is taken into the space of each group that it meets, and
//!    walks that group's; triangles are crossed watertight.
//!
//! Boxes are padded by a few units in the last place of the scene's extent, since the box test
//! rounds. Of two crossings at the same distance the lower (object, face) wins, so that results do
//! not depend on the hierarchy.

use crate::triangle::{Crossing, Sheared};
use chiaro_basis::math::{Affine3A, Vec3, Vec3A};
use chiaro_scene::{Alpha, Frame, Mesh, Object, Scene};
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::reinsertion::ReinsertionOptimizer;
use obvhs::cwbvh::CwBvh;
use obvhs::cwbvh::bvh2_to_cwbvh::bvh2_to_cwbvh;
use obvhs::ploc::{PlocBuilder, PlocSearchDistance, SortPrecision};
use obvhs::ray::{Ray as BoxRay, RayHit};
use rayon::prelude::*;

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

/// One triangle of a group.
#[derive(Clone, Copy, PartialEq)]
struct Face {
    object: u32,
    face: u32,
}

/// Triangles in one space with their hierarchy, both in the hierarchy's order.
struct Group {
    tree: CwBvh,
    triangles: Vec<[Vec3; 3]>,
    faces: Vec<Face>,
    /// Kept so that the next frame refits instead of building anew.
    boxes: Bvh2,
}

/// A group and where it stands.
struct Placed {
    group: usize,
    /// `None`: the group is in world space.
    group_from_world: Option<Affine3A>,
    /// For groups drawn several times: the object that is drawn here.
    object: Option<u32>,
}

/// A frame, ready for rays.
pub struct Tracer<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// Its state at one time.
    pub frame: &'a Frame,
    groups: Vec<Group>,
    placed: Vec<Placed>,
    top: Option<CwBvh>,
    surfaces: Vec<SurfaceKind>,
}

/// What a ray must know of a material.
#[derive(Clone, Copy)]
struct SurfaceKind {
    double_sided: bool,
    cutoff: Option<f32>,
}

impl<'a> Tracer<'a> {
    /// Builds the hierarchies of a frame.
    pub fn new(scene: &'a Scene, frame: &'a Frame) -> Self {
        let lists = group_lists(scene, frame);
        let groups = lists.into_iter().map(|list| Group::build(list, scene, frame)).collect();
        Self::assemble(scene, frame, groups)
    }

    /// The tracer of another frame of the same scene: the hierarchies keep their shape and are
    /// refitted, unless connectivity has changed.
    pub fn refit<'b>(self, scene: &'b Scene, frame: &'b Frame) -> Tracer<'b> {
        let lists = group_lists(scene, frame);
        let old = self.groups.into_iter().map(Some).chain(std::iter::repeat_with(|| None));
        let groups = lists
            .into_iter()
            .zip(old)
            .map(|(list, old)| match old {
                Some(group) if group.same_faces(&list) => group.refit(scene, frame),
                _ => Group::build(list, scene, frame),
            })
            .collect();
        Tracer::assemble(scene, frame, groups)
    }

    fn assemble(scene: &'a Scene, frame: &'a Frame, groups: Vec<Group>) -> Self {
        let placed = place(frame, &groups);
        let boxes: Vec<Aabb> = placed.iter().map(|p| p.bounds(&groups, frame)).collect();
        let top = (placed.len() > 1).then(|| wide(&build(&boxes, false)));
        let placed = match &top {
            Some(tree) => reorder(placed, &tree.primitive_indices),
            None => placed,
        };
        let surfaces = scene.materials.iter().map(SurfaceKind::of).collect();
        Self { scene, frame, groups, placed, top, surfaces }
    }

    /// The nearest surface along a ray.
    pub fn hit(&self, ray: &Ray, sides: Sides) -> Option<Hit> {
        let mut best = None;
        self.visit(ray, &mut |tracer, placed, local, reach| {
            tracer.nearest_in(placed, local, reach, sides, &mut best)
        });
        best
    }

    /// Whether anything stands in the ray's way, from either side.
    pub fn occluded(&self, ray: &Ray) -> bool {
        match &self.top {
            None => self.placed.first().is_some_and(|p| self.blocked_in(p, ray)),
            Some(top) => !top.ray_traverse_miss(box_ray(ray), |_, i| {
                if self.blocked_in(&self.placed[i], ray) { 0.0 } else { f32::INFINITY }
            }),
        }
    }

    /// Calls `each` for every placed group that the ray may meet; it answers the new reach.
    fn visit(&self, ray: &Ray, each: &mut dyn FnMut(&Self, &Placed, &Ray, f32) -> f32) {
        let mut call = |p: &Placed, reach: f32| each(self, p, &p.local(ray), reach);
        match &self.top {
            None => {
                if let Some(p) = self.placed.first() {
                    call(p, ray.t_max);
                }
            }
            Some(top) => {
                let mut nothing = RayHit::none();
                top.ray_traverse(box_ray(ray), &mut nothing, |r, i| call(&self.placed[i], r.tmax));
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
        best: &mut Option<Hit>,
    ) -> f32 {
        let group = &self.groups[placed.group];
        let sheared = Sheared::new(local.origin, local.direction);
        let mut nothing = RayHit::none();
        let mut box_ray = box_ray(local);
        box_ray.tmax = reach;
        group.tree.ray_traverse(box_ray, &mut nothing, |r, i| {
            let Some(c) = sheared.cross(&group.triangles[i], r.tmax) else { return f32::INFINITY };
            let hit = placed.hit(group.faces[i], c);
            if best.is_some_and(|b| !nearer(&hit, &b))
                || !self.is_there(&hit, local, &group.triangles[i], sides)
            {
                return f32::INFINITY;
            }
            *best = Some(hit);
            c.t
        });
        best.map_or(reach, |b| b.t)
    }

    fn blocked_in(&self, placed: &Placed, ray: &Ray) -> bool {
        let group = &self.groups[placed.group];
        let local = placed.local(ray);
        let sheared = Sheared::new(local.origin, local.direction);
        !group.tree.ray_traverse_miss(box_ray(&local), |r, i| {
            match sheared.cross(&group.triangles[i], r.tmax) {
                Some(c) if self.is_opaque(&placed.hit(group.faces[i], c)) => 0.0,
                _ => f32::INFINITY,
            }
        })
    }

    /// Whether the face is there for this ray: on the right side, and not cut away by opacity.
    fn is_there(&self, hit: &Hit, local: &Ray, triangle: &[Vec3; 3], sides: Sides) -> bool {
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
        Self { double_sided: material.double_sided, cutoff }
    }
}

/// Nearer, or as near with the lower id.
fn nearer(a: &Hit, b: &Hit) -> bool {
    (a.t, a.object, a.face) < (b.t, b.object, b.face)
}

fn box_ray(ray: &Ray) -> BoxRay {
    // The box test takes the sign of an inverse for that of the direction: no zero may be negative.
    let direction = Vec3A::from(ray.direction) + Vec3A::ZERO;
    BoxRay::new(Vec3A::from(ray.origin), direction, 0.0, ray.t_max)
}

impl Placed {
    /// The ray in the group's space. Its direction keeps the world's length, so that distances
    /// are the same in both spaces.
    fn local(&self, ray: &Ray) -> Ray {
        match &self.group_from_world {
            None => *ray,
            Some(m) => Ray {
                origin: m.transform_point3(ray.origin),
                direction: m.transform_vector3(ray.direction),
                t_max: ray.t_max,
            },
        }
    }

    fn hit(&self, face: Face, c: Crossing) -> Hit {
        Hit { t: c.t, object: self.object.unwrap_or(face.object), face: face.face, b: c.b }
    }

    fn bounds(&self, groups: &[Group], frame: &Frame) -> Aabb {
        let local = *groups[self.group].boxes.nodes[0].aabb();
        let Some(object) = self.object else { return local };
        let m = frame.objects[object as usize].world_from_shape;
        let corner = |i: usize| {
            let pick = |k: usize| if i >> k & 1 == 0 { local.min[k] } else { local.max[k] };
            m.transform_point3a(Vec3A::new(pick(0), pick(1), pick(2)))
        };
        let corners: Vec<Vec3A> = (0..8).map(corner).collect();
        padded(Aabb::from_points(&corners), 0.0)
    }
}

/// The faces of each group: the first holds every shape drawn once.
fn group_lists(scene: &Scene, frame: &Frame) -> Vec<Vec<Face>> {
    let mut uses = vec![0usize; frame.shapes.len()];
    for o in &frame.objects {
        uses[o.shape] += 1;
    }
    let mut lists = vec![Vec::new()];
    let mut done = vec![false; frame.shapes.len()];
    for (index, o) in frame.objects.iter().enumerate() {
        if std::mem::replace(&mut done[o.shape], true) {
            continue;
        }
        let count = frame.shapes[o.shape].mesh_in(scene).triangles.len();
        let faces = (0..count).map(|f| Face { object: index as u32, face: f as u32 });
        if uses[o.shape] == 1 && o.world_from_shape == Affine3A::IDENTITY {
            lists[0].extend(faces);
        } else {
            lists.push(faces.collect());
        }
    }
    lists.retain(|l| !l.is_empty());
    lists
}

/// Where each group stands: the world's once, the others once an object.
fn place(frame: &Frame, groups: &[Group]) -> Vec<Placed> {
    let mut placed = Vec::new();
    for (group, g) in groups.iter().enumerate() {
        let first = frame.objects[g.faces[0].object as usize].shape;
        let users: Vec<usize> =
            (0..frame.objects.len()).filter(|&i| frame.objects[i].shape == first).collect();
        if users.len() == 1 && frame.objects[users[0]].world_from_shape == Affine3A::IDENTITY {
            placed.push(Placed { group, group_from_world: None, object: None });
            continue;
        }
        placed.extend(users.into_iter().filter_map(|i| {
            let m = frame.objects[i].world_from_shape;
            let inverse = m.inverse();
            // A flat or broken matrix draws nothing.
            inverse.is_finite().then_some(Placed {
                group,
                group_from_world: Some(inverse),
                object: Some(i as u32),
            })
        }));
    }
    placed
}

fn reorder(placed: Vec<Placed>, order: &[u32]) -> Vec<Placed> {
    let mut slots: Vec<Option<Placed>> = placed.into_iter().map(Some).collect();
    order.iter().map(|&i| slots[i as usize].take().expect("each is placed once")).collect()
}

impl Group {
    fn build(list: Vec<Face>, scene: &Scene, frame: &Frame) -> Self {
        let triangles: Vec<[Vec3; 3]> = list.par_iter().map(|f| corners(f, scene, frame)).collect();
        let boxes = build(&triangle_boxes(&triangles), true);
        Self::from_tree(boxes, &list, &triangles)
    }

    /// Whether the group was built over just these faces.
    fn same_faces(&self, list: &[Face]) -> bool {
        self.faces.len() == list.len() && self.unsorted() == list
    }

    /// The faces in the order in which they were listed.
    fn unsorted(&self) -> Vec<Face> {
        let mut list = self.faces.clone();
        for (&original, face) in self.tree.primitive_indices.iter().zip(&self.faces) {
            list[original as usize] = *face;
        }
        list
    }

    fn refit(mut self, scene: &Scene, frame: &Frame) -> Self {
        let list = self.unsorted();
        let triangles: Vec<[Vec3; 3]> = list.par_iter().map(|f| corners(f, scene, frame)).collect();
        let boxes = triangle_boxes(&triangles);
        self.boxes.init_primitives_to_nodes_if_uninit();
        for (face, aabb) in boxes.iter().enumerate() {
            let node = self.boxes.primitives_to_nodes[face] as usize;
            self.boxes.nodes[node].set_aabb(*aabb);
        }
        self.boxes.refit_all();
        Self::from_tree(self.boxes, &list, &triangles)
    }

    fn from_tree(boxes: Bvh2, list: &[Face], triangles: &[[Vec3; 3]]) -> Self {
        let tree = wide(&boxes);
        let order = &tree.primitive_indices;
        let triangles = order.iter().map(|&i| triangles[i as usize]).collect();
        let faces = order.iter().map(|&i| list[i as usize]).collect();
        Self { tree, triangles, faces, boxes }
    }
}

fn corners(f: &Face, scene: &Scene, frame: &Frame) -> [Vec3; 3] {
    let shape = &frame.shapes[frame.objects[f.object as usize].shape];
    shape.mesh_in(scene).triangles[f.face as usize].map(|v| shape.positions[v as usize])
}

fn triangle_boxes(triangles: &[[Vec3; 3]]) -> Vec<Aabb> {
    let extent = triangles
        .par_iter()
        .map(|t| t.iter().fold(0.0f32, |m, p| m.max(p.abs().max_element())))
        .reduce(|| 0.0, f32::max);
    let pad = 4.0 * f32::EPSILON * extent;
    triangles.par_iter().map(|t| padded(Aabb::from_points(&t.map(Vec3A::from)), pad)).collect()
}

fn padded(b: Aabb, pad: f32) -> Aabb {
    let size = b.min.abs().max(b.max.abs()) * (4.0 * f32::EPSILON) + Vec3A::splat(pad);
    Aabb { min: b.min - size, max: b.max + size }
}

/// A binary hierarchy by locally-ordered clustering (Meister and Bittner 2018); `fine` improves it
/// by reinsertion.
fn build(boxes: &[Aabb], fine: bool) -> Bvh2 {
    let indices = (0..boxes.len() as u32).collect();
    let mut tree = PlocBuilder::with_capacity(boxes.len()).build(
        PlocSearchDistance::VeryLow,
        boxes,
        indices,
        SortPrecision::U64,
        0,
    );
    if fine && boxes.len() > 1 {
        ReinsertionOptimizer::default().run(&mut tree, 0.02, None);
    }
    tree
}

fn wide(tree: &Bvh2) -> CwBvh {
    bvh2_to_cwbvh(tree, 3, true, false)
}
