//! [`Hierarchy`]: bounding volumes over a frame's triangles.
//!
//! 1. Shapes drawn once are merged, in world space, into one group of triangles; each shape drawn
//!    several times is a group of its own.
//! 2. Over every group stands a compressed eight-wide hierarchy (Ylitie, Karras and Laine 2017),
//!    over the placed groups another one.
//! 3. The hierarchy of another frame shares the groups that have not changed; those that have keep
//!    their shape and get new boxes ([`Hierarchy::refit`]).
//!
//! Boxes are padded by a few units in the last place of the scene's extent, since the box test
//! rounds. Guaranteed, with the tie rule of [`crate::Tracer`]: what rays meet does not depend on
//! the hierarchy's shape, and so not on the frames that were traced before.

use crate::Ray;
use crate::tracer::Hit;
use crate::triangle::Crossing;
use chiaro_basis::math::{Affine3A, Vec3, Vec3A};
use chiaro_scene::{Frame, Scene};
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::reinsertion::ReinsertionOptimizer;
use obvhs::cwbvh::CwBvh;
use obvhs::cwbvh::bvh2_to_cwbvh::bvh2_to_cwbvh;
use obvhs::ploc::{PlocBuilder, PlocSearchDistance, SortPrecision};
use rayon::prelude::*;
use std::sync::Arc;

/// Bounding volumes over a frame's triangles, to be shared between tracers of the same shape.
pub struct Hierarchy {
    pub(crate) groups: Vec<Arc<Group>>,
    pub(crate) placed: Vec<Placed>,
    pub(crate) top: Option<CwBvh>,
}

/// One triangle of a group.
#[derive(Clone, Copy, PartialEq)]
pub(crate) struct Face {
    pub(crate) object: u32,
    pub(crate) face: u32,
}

/// Triangles in one space with their hierarchy, both in the hierarchy's order.
pub(crate) struct Group {
    pub(crate) tree: CwBvh,
    pub(crate) triangles: Vec<[Vec3; 3]>,
    pub(crate) faces: Vec<Face>,
    /// Kept so that the next frame refits instead of building anew.
    boxes: Bvh2,
}

/// A group and where it stands.
pub(crate) struct Placed {
    pub(crate) group: usize,
    /// `None`: the group is in world space.
    group_from_world: Option<Affine3A>,
    /// For groups drawn several times: the object that is drawn here.
    object: Option<u32>,
}

impl Hierarchy {
    /// Builds the hierarchies of a frame.
    pub fn build(scene: &Scene, frame: &Frame) -> Self {
        let lists = group_lists(scene, frame);
        let groups = lists.iter().map(|list| Arc::new(Group::build(list, scene, frame))).collect();
        Self::over(groups, frame)
    }

    /// The hierarchy of another frame of the same scene: a group whose triangles have not moved is
    /// shared, one whose triangles have moved keeps its shape, others are built.
    pub fn refit(&self, scene: &Scene, frame: &Frame) -> Self {
        let lists = group_lists(scene, frame);
        let groups = lists.iter().enumerate().map(|(i, list)| match self.groups.get(i) {
            Some(group) if group.has_faces(list) => group.moved(list, scene, frame),
            _ => Arc::new(Group::build(list, scene, frame)),
        });
        Self::over(groups.collect(), frame)
    }

    fn over(groups: Vec<Arc<Group>>, frame: &Frame) -> Self {
        let placed = place(frame, &groups);
        let boxes: Vec<Aabb> = placed.iter().map(|p| p.bounds(&groups, frame)).collect();
        let top = (placed.len() > 1).then(|| wide(&build(&boxes, false)));
        let placed = match &top {
            Some(tree) => reorder(placed, &tree.primitive_indices),
            None => placed,
        };
        Self { groups, placed, top }
    }
}

impl Placed {
    /// The ray in the group's space. Its direction keeps the world's length, so that distances
    /// are the same in both spaces.
    pub(crate) fn local(&self, ray: &Ray) -> Ray {
        match &self.group_from_world {
            None => *ray,
            Some(m) => Ray {
                origin: m.transform_point3(ray.origin),
                direction: m.transform_vector3(ray.direction),
                t_max: ray.t_max,
            },
        }
    }

    pub(crate) fn hit(&self, face: Face, c: Crossing) -> Hit {
        Hit { t: c.t, object: self.object.unwrap_or(face.object), face: face.face, b: c.b }
    }

    fn bounds(&self, groups: &[Arc<Group>], frame: &Frame) -> Aabb {
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
fn place(frame: &Frame, groups: &[Arc<Group>]) -> Vec<Placed> {
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
            let size = farthest(groups[group].boxes.nodes[0].aabb());
            // A flat or broken matrix draws nothing, nor does one that leads out of reach.
            let far = m.matrix3.to_cols_array().into_iter().map(f32::abs).fold(0.0, f32::max);
            (inverse.is_finite() && far * size < 1e13).then_some(Placed {
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
    fn build(list: &[Face], scene: &Scene, frame: &Frame) -> Self {
        let triangles = triangles(list, scene, frame);
        let boxes = build(&triangle_boxes(&triangles), true);
        Self::from_tree(boxes, list, &triangles)
    }

    /// Whether the group was built over just these faces.
    fn has_faces(&self, list: &[Face]) -> bool {
        let order = &self.tree.primitive_indices;
        self.faces.len() == list.len()
            && order.iter().zip(&self.faces).all(|(&i, face)| list[i as usize] == *face)
    }

    /// The group in another frame.
    fn moved(self: &Arc<Self>, list: &[Face], scene: &Scene, frame: &Frame) -> Arc<Self> {
        let triangles = triangles(list, scene, frame);
        let order = &self.tree.primitive_indices;
        let still = |(&i, old): (&u32, &[Vec3; 3])| triangles[i as usize] == *old;
        if order.par_iter().zip(&self.triangles).all(still) {
            return self.clone();
        }
        let mut boxes = self.boxes.clone();
        boxes.init_primitives_to_nodes_if_uninit();
        for (face, aabb) in triangle_boxes(&triangles).iter().enumerate() {
            let node = boxes.primitives_to_nodes[face] as usize;
            boxes.nodes[node].set_aabb(*aabb);
        }
        boxes.refit_all();
        Arc::new(Self::from_tree(boxes, list, &triangles))
    }

    fn from_tree(boxes: Bvh2, list: &[Face], triangles: &[[Vec3; 3]]) -> Self {
        let tree = wide(&boxes);
        let order = &tree.primitive_indices;
        let triangles = order.par_iter().map(|&i| triangles[i as usize]).collect();
        let faces = order.iter().map(|&i| list[i as usize]).collect();
        Self { tree, triangles, faces, boxes }
    }
}

fn triangles(list: &[Face], scene: &Scene, frame: &Frame) -> Vec<[Vec3; 3]> {
    list.par_iter().map(|f| corners(f, scene, frame)).collect()
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

/// The greatest coordinate of a box, whatever its sign.
fn farthest(b: &Aabb) -> f32 {
    b.min.abs().max(b.max.abs()).max_element()
}
