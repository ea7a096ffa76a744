//! [`Poser`]: a scene at a time.
//!
//! 1. Tracks set local transforms and morph weights; parents carry their children ([`State`]).
//! 2. A mesh is morphed, then skinned or placed ([`Geometry`]). Joints alone place a skinned mesh:
//!    its own node's transform does not count (glTF 2.0, section 3.7.3.3).
//! 3. A shape drawn once comes out in world space; one that is drawn several times without
//!    bending stays in the mesh's space and is shared ([`Sheet`]).
//!
//! Guaranteed: the same objects and shapes in the same order at every time; the same bits for any
//! number of threads and whatever was posed before; parts that do not change between two times
//! share their memory; positions and normals of finite input are finite, whatever the matrices.
//! Not guaranteed: normals where a matrix flattens space to a line or a point mean little.

mod geometry;
mod map;
mod sheet;
mod state;

use crate::{Frame, Mesh, Node, NodeId, Object, Playback, Pose, Property, Scene};
use chiaro_basis::math::{Affine3A, DAffine3, Vec3};
pub(crate) use map::normal_matrix;
use rayon::prelude::*;
use sheet::Sheet;
use state::State;
use std::collections::{BTreeMap, BTreeSet};

/// A scene, prepared to be posed at many times.
///
/// ```
/// use chiaro_scene::{Playback, Poser, Scene};
/// let scene = Scene::default();
/// let poser = Poser::new(&scene);
/// assert!(poser.frame(0.5, &Playback::still()).objects.is_empty());
/// ```
pub struct Poser<'a> {
    scene: &'a Scene,
    sheets: Vec<Sheet<'a>>,
    drawn: Vec<Drawn>,
}

/// One copy of one node's mesh.
struct Drawn {
    node: NodeId,
    /// Index into [`Node::instances`]; past its end for a mesh in place.
    copy: usize,
    /// Index of the shape.
    sheet: usize,
}

impl Scene {
    /// The scene at `time` seconds. For many times, keep a [`Poser`].
    pub fn frame(&self, time: f64, playback: &Playback) -> Frame {
        Poser::new(self).frame(time, playback)
    }
}

impl<'a> Poser<'a> {
    /// Prepares a scene.
    pub fn new(scene: &'a Scene) -> Self {
        let bending = nodes_with_animated_weights(scene);
        let mut poser = Self { scene, sheets: Vec::new(), drawn: Vec::new() };
        let mut still = BTreeMap::new();
        for (i, node) in scene.nodes.iter().enumerate() {
            let Some(mesh) = node.mesh else { continue };
            let id = NodeId::new(i);
            let bends = skin_of(scene, node).is_some() || bending.contains(&id);
            let sheet = if bends {
                poser.add_sheet(id)
            } else {
                let key = (mesh, rest_weights(&scene.meshes[mesh.index()], node));
                *still.entry(key).or_insert_with(|| poser.add_sheet(id))
            };
            poser.draw(id, node, sheet);
        }
        poser
    }

    fn add_sheet(&mut self, node: NodeId) -> usize {
        self.sheets.extend(Sheet::of(self.scene, node));
        self.sheets.len() - 1
    }

    fn draw(&mut self, id: NodeId, node: &Node, sheet: usize) {
        // Instances move what the node would draw; what the joints place stays where they say.
        let bent = skin_of(self.scene, node).is_some();
        let copies = if bent { 1 } else { node.instances.len().max(1) };
        self.drawn.extend((0..copies).map(|copy| Drawn { node: id, copy, sheet }));
        self.sheets[sheet].add_users(copies);
    }

    /// The scene at `time` seconds.
    pub fn frame(&self, time: f64, playback: &Playback) -> Frame {
        let state = State::at(self.scene, time, playback);
        let shapes = self.sheets.par_iter().map(|s| s.shape(self.scene, &state, time)).collect();
        let object = |d: &Drawn| {
            let sheet = &self.sheets[d.sheet];
            let place = state.place(self.scene, d.node, d.copy);
            Object {
                node: d.node,
                shape: d.sheet,
                world_from_shape: if sheet.is_shared() {
                    single(&place)
                } else {
                    Affine3A::IDENTITY
                },
                mirrored: sheet.mirrors(self.scene, &state, &place),
            }
        };
        let world = |node: NodeId| &state.world[node.index()];
        let cameras = self.scene.cameras.iter();
        let lights = self.scene.lights.iter();
        Frame {
            time,
            shapes,
            objects: self.drawn.par_iter().with_min_len(1024).map(object).collect(),
            cameras: cameras.map(|c| Pose::of_node(world(c.node), c.projection)).collect(),
            lights: lights.map(|l| (l.clone(), single(world(l.node)))).collect(),
        }
    }
}

/// Nodes whose morph weights some clip moves, whether it plays or not: what is shared must not
/// depend on what plays.
fn nodes_with_animated_weights(scene: &Scene) -> BTreeSet<NodeId> {
    let channels = scene.clips.iter().flat_map(|c| &c.channels);
    channels.filter(|c| c.property == Property::Weights).map(|c| c.node).collect()
}

/// The weights that tell two shapes of one mesh apart, as bits.
fn rest_weights(mesh: &Mesh, node: &Node) -> Vec<u32> {
    node.weights.iter().take(mesh.morphs.len()).map(|w| w.to_bits()).collect()
}

/// The skin that bends a node's mesh, if both are there.
fn skin_of<'a>(scene: &'a Scene, node: &Node) -> Option<&'a crate::Skin> {
    let mesh = &scene.meshes[node.mesh?.index()];
    let skin = &scene.skins[node.skin?.index()];
    (!mesh.influences.joints.is_empty()).then_some(skin)
}

/// In single precision; a matrix that overflows it draws nothing rather than everything.
fn single(m: &DAffine3) -> Affine3A {
    let m = m.as_affine3a();
    let columns = [m.x_axis, m.y_axis, m.z_axis, m.translation];
    let fits = columns.iter().all(|&c| crate::mesh::is_in_reach(c.into()));
    if fits { m } else { Affine3A::from_scale(Vec3::ZERO) }
}
