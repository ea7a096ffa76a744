//! [`State`]: where every node is at a time, and how much of each morph target it shows.

use super::skin_of;
use crate::{Channel, Node, NodeId, Playback, Property, Scene, Transform};
use chiaro_basis::math::{DAffine3, DMat4, DQuat, DVec3};

/// The animated state of all nodes.
pub(super) struct State {
    /// From each node's space to the world.
    pub(super) world: Vec<DAffine3>,
    /// Morph weights of each node.
    pub(super) weights: Vec<Vec<f32>>,
}

impl State {
    pub(super) fn at(scene: &Scene, time: f64, playback: &Playback) -> Self {
        let mut local: Vec<Transform> = scene.nodes.iter().map(|n| n.transform).collect();
        let mut weights: Vec<Vec<f32>> = scene.nodes.iter().map(|n| n.weights.clone()).collect();
        let clips = playback.clips.iter().filter_map(|&c| scene.clips.get(c));
        for channel in clips.flat_map(|c| &c.channels) {
            let node = channel.node.index();
            match channel.property {
                Property::Weights => weigh(&mut weights[node], channel, time),
                _ => local[node] = moved(local[node], channel, time),
            }
        }
        Self { world: worlds(&scene.nodes, &local), weights }
    }

    /// From the space of a mesh to the world, for one copy of a node's mesh.
    pub(super) fn place(&self, scene: &Scene, node: NodeId, copy: usize) -> DAffine3 {
        let world = self.world[node.index()];
        let instance = scene.nodes[node.index()].instances.get(copy);
        instance.map_or(world, |i| world * i.matrix())
    }

    /// From the space of a skinned mesh to the world, for each joint of its skin.
    pub(super) fn joints(&self, scene: &Scene, node: NodeId) -> Vec<DAffine3> {
        let Some(skin) = skin_of(scene, &scene.nodes[node.index()]) else { return Vec::new() };
        let bind = |i: usize| skin.inverse_bind.get(i).map_or(DMat4::IDENTITY, |m| m.as_dmat4());
        let world = |joint: &NodeId| self.world[joint.index()];
        let joints = skin.joints.iter().enumerate();
        joints.map(|(i, joint)| world(joint) * DAffine3::from_mat4(bind(i))).collect()
    }
}

/// Parents first, as scenes keep them; no recursion.
fn worlds(nodes: &[Node], local: &[Transform]) -> Vec<DAffine3> {
    let mut world: Vec<DAffine3> = Vec::with_capacity(nodes.len());
    for (node, transform) in nodes.iter().zip(local) {
        let parent = node.parent.and_then(|p| world.get(p.index()));
        let matrix = transform.matrix();
        world.push(parent.map_or(matrix, |p| *p * matrix));
    }
    world
}

fn weigh(weights: &mut Vec<f32>, channel: &Channel, time: f64) {
    weights.resize(channel.track.width.max(weights.len()), 0.0);
    let mut values: Vec<f64> = weights.iter().map(|&w| w.into()).collect();
    channel.track.sample(time, channel.property, &mut values);
    weights.iter_mut().zip(values).for_each(|(w, v)| *w = v as f32);
}

fn moved(transform: Transform, channel: &Channel, time: f64) -> Transform {
    let (mut translation, mut rotation, mut scale) = parts(transform);
    let sample = |out: &mut [f64]| channel.track.sample(time, channel.property, out);
    match channel.property {
        Property::Translation => sample(translation.as_mut()),
        Property::Rotation => {
            let mut q = rotation.to_array();
            sample(&mut q);
            rotation = DQuat::from_array(q);
        }
        Property::Scale => sample(scale.as_mut()),
        Property::Weights => {}
    }
    Transform::Parts { translation, rotation, scale }
}

/// The parts of a transform; of a matrix that shears, or has none, what comes closest.
fn parts(transform: Transform) -> (DVec3, DQuat, DVec3) {
    match transform {
        Transform::Parts { translation, rotation, scale } => (translation, rotation, scale),
        Transform::Matrix(m) => {
            let (scale, rotation, translation) = m.to_scale_rotation_translation();
            if scale.is_finite() && rotation.is_normalized() {
                (translation, rotation, scale)
            } else {
                (m.translation, DQuat::IDENTITY, DVec3::ONE)
            }
        }
    }
}
