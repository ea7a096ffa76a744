//! [`Scene`]: everything a file says.

use crate::{Camera, Clip, Light, Material, Mesh, Node, Skin, Texture};
use chiaro_basis::math::Vec3;

chiaro_basis::typed_id! {
    /// A mesh of a scene.
    pub struct MeshId;
}
chiaro_basis::typed_id! {
    /// A material of a scene.
    pub struct MaterialId;
}
chiaro_basis::typed_id! {
    /// A texture of a scene.
    pub struct TextureId;
}
chiaro_basis::typed_id! {
    /// A node of a scene.
    pub struct NodeId;
}
chiaro_basis::typed_id! {
    /// A skin of a scene.
    pub struct SkinId;
}

/// Everything a file says, normalized: ids are in range, nodes form a forest in which parents come
/// before their children, every triangle has a material, colours are linear.
#[derive(Clone, Debug, Default)]
pub struct Scene {
    /// Meshes, one for all primitives of a file's mesh.
    pub meshes: Vec<Mesh>,
    /// Materials; the first is the default where a file names none.
    pub materials: Vec<Material>,
    /// Textures.
    pub textures: Vec<Texture>,
    /// Nodes, parents first.
    pub nodes: Vec<Node>,
    /// Skins.
    pub skins: Vec<Skin>,
    /// Cameras.
    pub cameras: Vec<Camera>,
    /// Lights.
    pub lights: Vec<Light>,
    /// Animations.
    pub clips: Vec<Clip>,
    /// Counts as the file stores them.
    pub stored: Stored,
    /// What the user should know: missing images, ignored extensions.
    pub warnings: Vec<String>,
}

/// Counts as the file stores them, before any splitting or joining.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Stored {
    /// Triangles; polygons count as their fans, strips and fans as their triangles, a mesh once
    /// however often it is drawn.
    pub triangles: u64,
    /// Vertices.
    pub vertices: u64,
    /// Pictures.
    pub textures: u64,
    /// Materials.
    pub materials: u64,
    /// Morph targets, summed over meshes.
    pub morph_targets: u64,
    /// Extensions the file says it uses.
    pub extensions_used: Vec<String>,
    /// Files it names that are not there.
    pub missing_files: Vec<String>,
}

/// An axis-aligned box.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// The least corner.
    pub min: Vec3,
    /// The greatest corner.
    pub max: Vec3,
}

impl Bounds {
    /// The box of no point.
    pub const EMPTY: Self = Self { min: Vec3::INFINITY, max: Vec3::NEG_INFINITY };

    /// The box that also holds `p`.
    pub fn with(self, p: Vec3) -> Self {
        Self { min: self.min.min(p), max: self.max.max(p) }
    }

    /// The box of all `points`.
    pub fn of(points: impl IntoIterator<Item = Vec3>) -> Self {
        points.into_iter().fold(Self::EMPTY, Self::with)
    }

    /// Whether it holds no point.
    pub fn is_empty(&self) -> bool {
        !self.min.cmple(self.max).all()
    }

    /// The middle.
    pub fn centre(&self) -> Vec3 {
        0.5 * (self.min + self.max)
    }

    /// Half the diagonal: the object's radius R of binary shading; 0 when empty.
    pub fn radius(&self) -> f32 {
        if self.is_empty() { 0.0 } else { 0.5 * (self.max - self.min).length() }
    }
}
