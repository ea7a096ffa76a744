//! [`Rig`]: bones that bend one mesh smoothly.
//!
//! A bone is a round cone hung on a parent. Bones rest unrotated, so that inverse bind matrices are
//! translations. A point follows the bones nearest to it; weights are once continuously
//! differentiable in the point wherever at most four bones reach.

use super::shape::field::limb;
use super::stage::{Stage, moved};
use crate::{Influences, NodeId, Skin, SkinId};
use chiaro_basis::math::{DQuat, DVec3, Mat4, Vec3};

/// A round cone that moves as one.
#[derive(Clone, Debug)]
struct Bone {
    name: String,
    parent: Option<usize>,
    ends: [Vec3; 2],
    radii: [f32; 2],
}

/// Bones of one mesh, parents first.
pub(crate) struct Rig {
    bones: Vec<Bone>,
    /// Over how many units neighbouring bones share their influence.
    blend: f32,
}

/// What a rig has become on a stage.
pub(crate) struct Bones {
    /// The skin.
    pub(crate) skin: SkinId,
    /// The node of each bone, in order.
    pub(crate) nodes: Vec<NodeId>,
}

impl Rig {
    /// No bones yet.
    pub(crate) fn new(blend: f32) -> Self {
        Self { bones: Vec::new(), blend }
    }

    /// A bone from one end to the other, each with its radius, below an earlier one; its index.
    pub(crate) fn bone(
        &mut self,
        name: impl Into<String>,
        parent: Option<usize>,
        [from, to]: [(Vec3, f32); 2],
    ) -> usize {
        let (ends, radii) = ([from.0, to.0], [from.1, to.1]);
        self.bones.push(Bone { name: name.into(), parent, ends, radii });
        self.bones.len() - 1
    }

    /// Bones along a row of points, each below the one before; their indices.
    pub(crate) fn limb(
        &mut self,
        name: &str,
        parent: Option<usize>,
        joints: &[(Vec3, f32)],
    ) -> Vec<usize> {
        let mut chain: Vec<usize> = Vec::new();
        for (k, w) in joints.windows(2).enumerate() {
            let above = chain.last().copied().or(parent);
            chain.push(self.bone(format!("{name} {k}"), above, [w[0], w[1]]));
        }
        chain
    }

    /// Where a bone begins at rest.
    pub(crate) fn origin(&self, bone: usize) -> DVec3 {
        self.bones[bone].ends[0].as_dvec3()
    }

    /// Which bones hold each point, and how strongly.
    pub(crate) fn influences(&self, points: impl IntoIterator<Item = Vec3>) -> Influences {
        let (joints, weights) = points.into_iter().map(|p| self.hold(p)).unzip();
        Influences { joints: vec![joints], weights: vec![weights] }
    }

    fn hold(&self, p: Vec3) -> ([u16; 4], [f32; 4]) {
        let distance = |b: &Bone| limb(p, b.ends[0], b.ends[1], b.radii[0], b.radii[1]);
        let mut near: Vec<(f32, u16)> =
            self.bones.iter().enumerate().map(|(i, b)| (distance(b), i as u16)).collect();
        near.sort_by(|a, b| a.0.total_cmp(&b.0));
        let (mut joints, mut weights) = ([0; 4], [0.0; 4]);
        for (k, &(d, bone)) in near.iter().take(4).enumerate() {
            joints[k] = bone;
            weights[k] = (1.0 - (d - near[0].0) / self.blend).max(0.0).powi(3);
        }
        let sum: f32 = weights.iter().sum();
        (joints, weights.map(|w| w / sum))
    }

    /// The bones as nodes of a stage, the first below `root`.
    pub(crate) fn put(&self, stage: &mut Stage, root: Option<NodeId>) -> Bones {
        let mut nodes: Vec<NodeId> = Vec::with_capacity(self.bones.len());
        for (i, bone) in self.bones.iter().enumerate() {
            let above = bone.parent.map_or(DVec3::ZERO, |p| self.origin(p));
            let at = self.origin(i) - above;
            let parent = bone.parent.map(|p| nodes[p]).or(root);
            nodes.push(stage.joint(&bone.name, parent, moved(at.x, at.y, at.z)));
        }
        let bind = |b: &Bone| Mat4::from_translation(-b.ends[0]);
        let inverse_bind = self.bones.iter().map(bind).collect();
        let skin = stage.skin(Skin { joints: nodes.clone(), inverse_bind });
        Bones { skin, nodes }
    }
}

/// Where the knee of a two-boned limb is that reaches from `hip` to `ankle`, bent towards `pole`;
/// what is out of reach is reached for.
pub(crate) fn knee(hip: DVec3, ankle: DVec3, thigh: f64, shin: f64, pole: DVec3) -> DVec3 {
    let axis = (ankle - hip).normalize_or(DVec3::NEG_Y);
    let reach = hip.distance(ankle).clamp((thigh - shin).abs() + 1e-6, thigh + shin - 1e-6);
    let along = (reach * reach + thigh * thigh - shin * shin) / (2.0 * reach);
    let out = (thigh * thigh - along * along).max(0.0).sqrt();
    let across = (pole - axis * pole.dot(axis)).normalize_or(axis.any_orthonormal_vector());
    hip + axis * along + across * out
}

/// The least rotation from one direction to another.
pub(crate) fn arc(from: DVec3, to: DVec3) -> DQuat {
    DQuat::from_rotation_arc(from.normalize(), to.normalize())
}

#[cfg(test)]
mod tests {
    use super::*;
    use chiaro_basis::math::vec3;

    #[test]
    fn a_knee_keeps_its_bones_lengths() {
        let (hip, ankle) = (DVec3::new(0.2, 1.0, 0.1), DVec3::new(0.9, 0.1, -0.2));
        let at = knee(hip, ankle, 0.8, 0.7, DVec3::Y);
        assert!((at.distance(hip) - 0.8).abs() < 1e-9);
        assert!((at.distance(ankle) - 0.7).abs() < 1e-9);
    }

    #[test]
    fn weights_sum_to_one_and_change_smoothly_over_a_joint() {
        let mut rig = Rig::new(0.3);
        rig.limb("arm", None, &[(Vec3::ZERO, 0.1), (Vec3::X, 0.1), (2.0 * Vec3::X, 0.1)]);
        let row = rig.influences((0..=200).map(|i| vec3(0.01 * i as f32, 0.1, 0.0)));
        let first = |i: usize| {
            let k = row.joints[0][i].iter().position(|&j| j == 0).unwrap_or(0);
            row.weights[0][i][k]
        };
        for i in 0..=200 {
            assert!((row.weights[0][i].iter().sum::<f32>() - 1.0).abs() < 1e-5);
        }
        assert!(first(20) == 1.0 && (first(100) - 0.5).abs() < 0.01 && first(180) < 0.01);
        assert!((1..200).all(|i| (first(i) - first(i + 1)).abs() < 0.06));
    }
}
