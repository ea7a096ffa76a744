//! [`Poser`]: scenes at a time.
//!
//! 1. Tracks give the animated transforms and morph weights; parents give their children's world.
//! 2. A mesh is morphed, then skinned; a skinned mesh ignores its own node's place (glTF 2.0,
//!    section 3.7.3.3).
//! 3. A shape drawn once is put into world space; rigid shapes drawn several times share one.
//!
//! Guaranteed: the same ids at every time, no recursion, no NaN where the input has none.

use crate::mesh::{Mesh, NormalSource};
use crate::{
    Camera, Frame, MeshId, Node, NodeId, Object, Playback, Pose, Projection, Property, Scene,
    Shape, Skin, Transform,
};
use chiaro_basis::math::{Affine3A, DAffine3, DQuat, DVec3, Mat3, Mat4, Vec3, Vec4};
use rayon::prelude::*;
use std::sync::Arc;

/// A scene, prepared to be posed at many times.
pub struct Poser<'a> {
    scene: &'a Scene,
    /// Shapes at rest in mesh space, for meshes that are drawn rigidly several times.
    shared: Vec<Option<Shape>>,
    /// The objects: node, and which copy of its mesh.
    drawn: Vec<(NodeId, usize)>,
}

/// Animated state of all nodes.
struct State {
    world: Vec<DAffine3>,
    weights: Vec<Vec<f32>>,
}

impl<'a> Poser<'a> {
    /// Prepares a scene.
    pub fn new(scene: &'a Scene) -> Self {
        let drawn: Vec<(NodeId, usize)> = scene
            .nodes
            .iter()
            .enumerate()
            .filter(|(_, node)| node.mesh.is_some())
            .flat_map(|(i, node)| {
                (0..node.instances.len().max(1)).map(move |copy| (NodeId::new(i), copy))
            })
            .collect();
        let mut uses = vec![0usize; scene.meshes.len()];
        for (node, _) in &drawn {
            let node = &scene.nodes[node.index()];
            if let Some(mesh) = node.mesh.filter(|m| is_rigid(scene, node, *m)) {
                uses[mesh.index()] += 1;
            }
        }
        let shared = uses
            .iter()
            .enumerate()
            .map(|(i, &n)| (n > 1).then(|| at_rest(&scene.meshes[i], MeshId::new(i))))
            .collect();
        Self { scene, shared, drawn }
    }

    /// The scene at `time` seconds.
    pub fn frame(&self, time: f64, playback: &Playback) -> Frame {
        let state = self.state(time, playback);
        let mut shapes: Vec<Shape> = Vec::new();
        let mut shared_at: Vec<Option<usize>> = vec![None; self.scene.meshes.len()];
        let mut objects = Vec::with_capacity(self.drawn.len());
        for &(node_id, copy) in &self.drawn {
            let node = &self.scene.nodes[node_id.index()];
            let Some(mesh) = node.mesh else { continue };
            let place = self.place(node_id, copy, &state);
            let rigid = is_rigid(self.scene, node, mesh);
            let mirrored = place.matrix3.determinant() < 0.0 && node.skin.is_none();
            let (shape, world_from_shape) = match (&self.shared[mesh.index()], rigid) {
                (Some(rest), true) => {
                    let at = *shared_at[mesh.index()].get_or_insert_with(|| {
                        shapes.push(rest.clone());
                        shapes.len() - 1
                    });
                    (at, affine(&place))
                }
                _ => {
                    shapes.push(self.deformed(node_id, mesh, &place, &state, time));
                    (shapes.len() - 1, Affine3A::IDENTITY)
                }
            };
            objects.push(Object { node: node_id, shape, world_from_shape, mirrored });
        }
        let lights = self.scene.lights.iter();
        let world = |n: NodeId| affine(&state.world[n.index()]);
        Frame {
            time,
            shapes,
            objects,
            cameras: self.scene.cameras.iter().map(|c| camera_pose(c, &state)).collect(),
            lights: lights.map(|l| (l.clone(), world(l.node))).collect(),
        }
    }

    fn state(&self, time: f64, playback: &Playback) -> State {
        let mut local: Vec<Transform> = self.scene.nodes.iter().map(|n| n.transform).collect();
        let mut weights: Vec<Vec<f32>> =
            self.scene.nodes.iter().map(|n| n.weights.clone()).collect();
        for clip in &playback.clips {
            for channel in &self.scene.clips[*clip].channels {
                let rotation = channel.property == Property::Rotation;
                let value = channel.track.sample(time, rotation);
                let node = channel.node.index();
                match channel.property {
                    Property::Weights => weights[node] = value,
                    property => animate(&mut local[node], property, &value),
                }
            }
        }
        let mut world: Vec<DAffine3> = Vec::with_capacity(local.len());
        for (node, transform) in self.scene.nodes.iter().zip(&local) {
            let parent = node.parent.map_or(DAffine3::IDENTITY, |p| world[p.index()]);
            world.push(parent * transform.matrix());
        }
        State { world, weights }
    }

    fn place(&self, node: NodeId, copy: usize, state: &State) -> DAffine3 {
        let world = state.world[node.index()];
        match self.scene.nodes[node.index()].instances.get(copy) {
            Some(instance) => world * instance.matrix(),
            None => world,
        }
    }

    /// The mesh of a node in world space.
    fn deformed(
        &self,
        node_id: NodeId,
        mesh_id: MeshId,
        place: &DAffine3,
        state: &State,
        time: f64,
    ) -> Shape {
        let node = &self.scene.nodes[node_id.index()];
        let stored = &self.scene.meshes[mesh_id.index()];
        let remade = stored.remake.as_ref().map(|r| Arc::new((r.0)(time)));
        let mesh = remade.as_deref().unwrap_or(stored);
        let mut geometry = Geometry::morphed(mesh, &state.weights[node_id.index()]);
        match node.skin.map(|s| &self.scene.skins[s.index()]) {
            Some(skin) if !mesh.influences.joints.is_empty() => {
                geometry.skin(mesh, &joint_matrices(skin, state));
            }
            _ => geometry.transform(&affine(place)),
        }
        geometry.shape(
            mesh,
            mesh_id,
            remade.clone(),
            place.matrix3.determinant() < 0.0 && node.skin.is_none(),
        )
    }
}

/// Whether a node's mesh keeps its shape for ever.
fn is_rigid(scene: &Scene, node: &Node, mesh: MeshId) -> bool {
    let mesh = &scene.meshes[mesh.index()];
    node.skin.is_none() && mesh.morphs.is_empty() && mesh.remake.is_none()
}

fn at_rest(mesh: &Mesh, id: MeshId) -> Shape {
    Geometry::morphed(mesh, &[]).shape(mesh, id, None, false)
}

fn affine(m: &DAffine3) -> Affine3A {
    let m = m.as_affine3a();
    // A matrix that overflows single precision draws nothing rather than everything.
    if m.is_finite() { m } else { Affine3A::from_scale(Vec3::ZERO) }
}

fn animate(transform: &mut Transform, property: Property, value: &[f32]) {
    let Transform::Parts { translation, rotation, scale } = transform else { return };
    let three = || DVec3::new(value[0].into(), value[1].into(), value[2].into());
    match property {
        Property::Translation => *translation = three(),
        Property::Scale => *scale = three(),
        Property::Rotation => {
            let q = DQuat::from_xyzw(
                value[0].into(),
                value[1].into(),
                value[2].into(),
                value[3].into(),
            );
            *rotation = if q.length_squared() > 0.0 { q.normalize() } else { DQuat::IDENTITY };
        }
        Property::Weights => {}
    }
}

fn camera_pose(camera: &Camera, state: &State) -> Pose {
    let m = state.world[camera.node.index()];
    let position = m.translation.as_vec3();
    let forward = (-m.matrix3.z_axis).as_vec3().normalize_or(Vec3::NEG_Z);
    let up = m.matrix3.y_axis.as_vec3().normalize_or(Vec3::Y);
    // An orthographic camera's view scales with its node in no program: scale is ignored.
    let projection: Projection = camera.projection;
    Pose::look_at(position, position + forward, up, projection)
}

fn joint_matrices(skin: &Skin, state: &State) -> Vec<Mat4> {
    let joints = skin.joints.iter().zip(&skin.inverse_bind);
    joints
        .map(|(joint, bind)| {
            let world = state.world[joint.index()];
            (chiaro_basis::math::DMat4::from(world) * bind.as_dmat4()).as_mat4()
        })
        .collect()
}

/// Vertices on their way to a shape.
struct Geometry {
    positions: Vec<Vec3>,
    normals: Vec<Vec3>,
    tangents: Vec<Vec4>,
}

impl Geometry {
    /// The mesh with its morph targets added.
    fn morphed(mesh: &Mesh, weights: &[f32]) -> Self {
        let normals = match &mesh.normals {
            NormalSource::Given(normals) => normals.clone(),
            NormalSource::Faces(_) => Vec::new(),
        };
        let mut g =
            Self { positions: mesh.positions.clone(), normals, tangents: mesh.tangents.clone() };
        for (morph, &w) in mesh.morphs.iter().zip(weights).filter(|(_, w)| **w != 0.0) {
            add(&mut g.positions, &morph.positions, w);
            add(&mut g.normals, &morph.normals, w);
            for (t, d) in g.tangents.iter_mut().zip(&morph.tangents) {
                *t += (*d * w).extend(0.0);
            }
        }
        g
    }

    fn transform(&mut self, m: &Affine3A) {
        if *m == Affine3A::IDENTITY {
            return;
        }
        let for_normals = normal_matrix(&Mat3::from(m.matrix3));
        self.positions.par_iter_mut().for_each(|p| *p = m.transform_point3(*p));
        self.normals.par_iter_mut().for_each(|n| *n = for_normals * *n);
        self.tangents
            .par_iter_mut()
            .for_each(|t| *t = m.transform_vector3(t.truncate()).extend(t.w));
    }

    fn skin(&mut self, mesh: &Mesh, joints: &[Mat4]) {
        let matrix = |vertex: usize| -> Mat4 {
            let mut sum = Mat4::ZERO;
            for (set, weights) in mesh.influences.joints.iter().zip(&mesh.influences.weights) {
                for (joint, weight) in set[vertex].iter().zip(weights[vertex]) {
                    if weight != 0.0 {
                        sum += joints[usize::from(*joint)] * weight;
                    }
                }
            }
            if sum == Mat4::ZERO { Mat4::IDENTITY } else { sum }
        };
        let matrices: Vec<Mat4> = (0..self.positions.len()).into_par_iter().map(matrix).collect();
        for (p, m) in self.positions.iter_mut().zip(&matrices) {
            *p = m.transform_point3(*p);
        }
        for (n, m) in self.normals.iter_mut().zip(&matrices) {
            *n = normal_matrix(&Mat3::from_mat4(*m)) * *n;
        }
        for (t, m) in self.tangents.iter_mut().zip(&matrices) {
            *t = m.transform_vector3(t.truncate()).extend(t.w);
        }
    }

    fn shape(
        mut self,
        mesh: &Mesh,
        id: MeshId,
        remade: Option<Arc<Mesh>>,
        mirrored: bool,
    ) -> Shape {
        if let NormalSource::Faces(groups) = &mesh.normals {
            self.normals = crate::normals::of_faces(&self.positions, &mesh.triangles, groups);
            if mirrored {
                self.normals.iter_mut().for_each(|n| *n = -*n);
            }
        }
        self.normals.resize(self.positions.len(), Vec3::Z);
        let unit = |n: &Vec3| n.normalize_or(Vec3::Z);
        let tangent = |t: &Vec4| t.truncate().normalize_or(Vec3::X).extend(t.w);
        Shape {
            mesh: id,
            remade,
            normals: self.normals.iter().map(unit).collect(),
            tangents: self.tangents.iter().map(tangent).collect(),
            positions: self.positions.into(),
        }
    }
}

fn add(values: &mut [Vec3], deltas: &[Vec3], weight: f32) {
    for (v, d) in values.iter_mut().zip(deltas) {
        *v += *d * weight;
    }
}

/// The cofactor matrix: the inverse transpose up to a positive factor, also where there is none.
fn normal_matrix(m: &Mat3) -> Mat3 {
    let (x, y, z) = (m.x_axis, m.y_axis, m.z_axis);
    let cofactor = Mat3::from_cols(y.cross(z), z.cross(x), x.cross(y));
    if m.determinant() < 0.0 { cofactor * -1.0 } else { cofactor }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Channel, Clip, Influences, Interpolation, MaterialId, Morph, Track};
    use chiaro_basis::math::vec3;
    use std::f64::consts::FRAC_PI_2;

    fn triangle() -> Mesh {
        Mesh {
            positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y],
            normals: NormalSource::Given(vec![Vec3::Z; 3]),
            triangles: vec![[0, 1, 2]],
            materials: vec![MaterialId::new(0)],
            ..Mesh::default()
        }
    }

    fn turn_y() -> Transform {
        Transform::Parts {
            translation: DVec3::new(1.0, 0.0, 0.0),
            rotation: DQuat::from_rotation_y(FRAC_PI_2),
            scale: DVec3::ONE,
        }
    }

    fn node(parent: Option<usize>, transform: Transform, mesh: Option<usize>) -> Node {
        Node {
            parent: parent.map(NodeId::new),
            transform,
            mesh: mesh.map(MeshId::new),
            ..Node::default()
        }
    }

    fn near(a: Vec3, b: Vec3) -> bool {
        a.distance(b) < 1e-6
    }

    #[test]
    fn a_turned_parent_moves_its_children() {
        let scene = Scene {
            meshes: vec![triangle()],
            nodes: vec![node(None, turn_y(), None), node(Some(0), turn_y(), Some(0))],
            ..Scene::default()
        };
        let frame = Poser::new(&scene).frame(0.0, &Playback::still());
        let p = &frame.shapes[0].positions;
        assert!(near(p[0], vec3(1.0, 0.0, -1.0)), "{}", p[0]);
        assert!(near(p[1], vec3(0.0, 0.0, -1.0)), "{}", p[1]);
        assert!(near(frame.shapes[0].normals[0], Vec3::NEG_Z));
    }

    #[test]
    fn meshes_drawn_twice_share_a_shape() {
        let scene = Scene {
            meshes: vec![triangle()],
            nodes: vec![node(None, turn_y(), Some(0)), node(None, Transform::default(), Some(0))],
            ..Scene::default()
        };
        let frame = Poser::new(&scene).frame(0.0, &Playback::still());
        assert_eq!((frame.shapes.len(), frame.objects.len()), (1, 2));
        let p: Vec<Vec3> = frame.world_positions(&frame.objects[0]).collect();
        assert!(near(p[1], vec3(1.0, 0.0, -1.0)), "{}", p[1]);
    }

    #[test]
    fn morphs_come_before_skins() {
        let mut mesh = triangle();
        mesh.morphs = vec![Morph { positions: vec![Vec3::X; 3], ..Morph::default() }];
        mesh.influences = Influences {
            joints: vec![vec![[0, 1, 0, 0]; 3]],
            weights: vec![vec![[0.5, 0.5, 0.0, 0.0]; 3]],
        };
        let mut shown = node(None, turn_y(), Some(0));
        shown.skin = Some(crate::SkinId::new(0));
        shown.weights = vec![2.0];
        let lift = Transform::Parts {
            translation: DVec3::new(0.0, 4.0, 0.0),
            rotation: DQuat::IDENTITY,
            scale: DVec3::ONE,
        };
        let joints = vec![NodeId::new(1), NodeId::new(2)];
        let scene = Scene {
            meshes: vec![mesh],
            nodes: vec![shown, node(None, Transform::default(), None), node(None, lift, None)],
            skins: vec![Skin { joints, inverse_bind: vec![Mat4::IDENTITY; 2] }],
            ..Scene::default()
        };
        let frame = Poser::new(&scene).frame(0.0, &Playback::still());
        // Half of the lift; the skinned node's own turn does not count.
        assert!(near(frame.shapes[0].positions[0], vec3(2.0, 2.0, 0.0)));
    }

    #[test]
    fn mirrored_nodes_keep_their_normals_outside() {
        let mirror = Transform::Parts {
            translation: DVec3::ZERO,
            rotation: DQuat::IDENTITY,
            scale: DVec3::new(-1.0, 1.0, 1.0),
        };
        for normals in [NormalSource::Given(vec![Vec3::Z; 3]), NormalSource::Faces(vec![0, 1, 2])] {
            let mesh = Mesh { normals, ..triangle() };
            let scene = Scene {
                meshes: vec![mesh],
                nodes: vec![node(None, mirror, Some(0))],
                ..Scene::default()
            };
            let frame = Poser::new(&scene).frame(0.0, &Playback::still());
            assert!(frame.objects[0].mirrored);
            assert!(near(frame.shapes[0].normals[0], Vec3::Z));
        }
    }

    #[test]
    fn cameras_and_clips_move_together() {
        let track = Track {
            times: vec![0.0, 1.0],
            values: vec![0.0, 0.0, 0.0, 0.0, 2.0, 0.0],
            width: 3,
            interpolation: Interpolation::Linear,
        };
        let channel = Channel { node: NodeId::new(0), property: Property::Translation, track };
        let scene = Scene {
            nodes: vec![node(None, Transform::default(), None)],
            cameras: vec![Camera {
                name: String::new(),
                node: NodeId::new(0),
                projection: Projection::Perspective { fov_y: 1.0 },
                aspect: None,
            }],
            clips: vec![Clip { name: String::new(), channels: vec![channel] }],
            ..Scene::default()
        };
        let frame = Poser::new(&scene).frame(0.5, &Playback { clips: vec![0] });
        assert!(near(frame.cameras[0].position, Vec3::Y));
        assert!(near(frame.cameras[0].forward, Vec3::NEG_Z));
    }
}
