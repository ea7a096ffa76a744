//! [`Node`]: the hierarchy that places things, and [`Skin`]s that bend meshes by it.

use crate::{MeshId, NodeId, SkinId};
use chiaro_basis::math::{DAffine3, DMat4, DQuat, DVec3, Mat4};

/// A place in the hierarchy.
#[derive(Clone, Debug, Default)]
pub struct Node {
    /// The name in the file, or empty.
    pub name: String,
    /// The node it moves with.
    pub parent: Option<NodeId>,
    /// From the node's space to its parent's.
    pub transform: Transform,
    /// The mesh it shows.
    pub mesh: Option<MeshId>,
    /// The skin that bends the mesh.
    pub skin: Option<SkinId>,
    /// Rest weights of the mesh's morph targets.
    pub weights: Vec<f32>,
    /// Copies of the mesh, each with its own transform below the node's; empty: one, in place.
    pub instances: Vec<Transform>,
}

/// A local transform.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Transform {
    /// Scaled, then rotated, then moved: what animation can change.
    Parts {
        /// Moved by.
        translation: DVec3,
        /// Rotated by, a unit quaternion.
        rotation: DQuat,
        /// Scaled by; may be negative or zero.
        scale: DVec3,
    },
    /// Any affine matrix.
    Matrix(DAffine3),
}

impl Default for Transform {
    fn default() -> Self {
        Self::Parts { translation: DVec3::ZERO, rotation: DQuat::IDENTITY, scale: DVec3::ONE }
    }
}

impl Transform {
    /// As a matrix.
    pub fn matrix(&self) -> DAffine3 {
        match *self {
            Self::Parts { translation, rotation, scale } => {
                DAffine3::from_scale_rotation_translation(scale, rotation, translation)
            }
            Self::Matrix(m) => m,
        }
    }

    /// From a column-major 4 x 4 matrix whose last row is (0, 0, 0, 1).
    pub fn from_columns(columns: [f64; 16]) -> Self {
        Self::Matrix(DAffine3::from_mat4(DMat4::from_cols_array(&columns)))
    }
}

/// Joints and their inverse bind matrices.
#[derive(Clone, Debug, Default)]
pub struct Skin {
    /// The nodes that move the vertices.
    pub joints: Vec<NodeId>,
    /// From mesh space to each joint's space at rest; as many as joints.
    pub inverse_bind: Vec<Mat4>,
}
