//! [`Mesh`]: triangles with attributes, as stored.

use crate::MaterialId;
use chiaro_basis::math::{Vec2, Vec3, Vec4};
use std::sync::Arc;

/// One object's triangles. Per-vertex arrays are empty or as long as `positions`.
#[derive(Clone, Debug, Default)]
pub struct Mesh {
    /// The name in the file, or empty.
    pub name: String,
    /// Vertex positions in object space, scene units.
    pub positions: Vec<Vec3>,
    /// Where shading normals come from.
    pub normals: NormalSource,
    /// Tangents; w is the sign of the bitangent. Empty: derived from uv set 0 where needed.
    pub tangents: Vec<Vec4>,
    /// Texture coordinate sets, v down as in glTF.
    pub uvs: Vec<Vec<Vec2>>,
    /// Linear RGBA that multiplies the base colour.
    pub colours: Vec<Vec4>,
    /// Joints and weights of a skinned mesh.
    pub influences: Influences,
    /// Morph targets.
    pub morphs: Vec<Morph>,
    /// Vertex indices, counter-clockwise seen from the front; all in range.
    pub triangles: Vec<[u32; 3]>,
    /// The material of each triangle; as long as `triangles`.
    pub materials: Vec<MaterialId>,
    /// The polygon that each triangle is a part of (quads, n-gons), or empty: each its own.
    pub polygons: Vec<u32>,
    /// Of a cloud of points, whose triangles come four to a disc: how much surface each disc stands
    /// for, over the area of the first of its triangles, which holds its point. Empty for surfaces.
    pub discs: Vec<f32>,
    /// Makes the mesh anew at every time, where even its connectivity changes.
    pub remake: Option<Remake>,
}

/// Where shading normals come from.
#[derive(Clone, Debug)]
pub enum NormalSource {
    /// Unit vectors of the file, one a vertex; morphed and skinned with it.
    Given(Vec<Vec3>),
    /// Angle-weighted means of the deformed faces around the vertices of one group; one group
    /// index a vertex, each below the number of vertices.
    Faces(Vec<u32>),
}

impl Default for NormalSource {
    fn default() -> Self {
        Self::Given(Vec::new())
    }
}

/// Joints and weights: sets of four a vertex, as glTF stores them; weights of a vertex sum to 1.
#[derive(Clone, Debug, Default)]
pub struct Influences {
    /// Indices into [`crate::Skin::joints`], in range.
    pub joints: Vec<Vec<[u16; 4]>>,
    /// The weights that belong to `joints`.
    pub weights: Vec<Vec<[f32; 4]>>,
}

/// Displacements of a morph target; arrays are empty or one a vertex.
#[derive(Clone, Debug, Default)]
pub struct Morph {
    /// Added to positions.
    pub positions: Vec<Vec3>,
    /// Added to normals.
    pub normals: Vec<Vec3>,
    /// Added to the xyz of tangents.
    pub tangents: Vec<Vec3>,
}

/// A mesh as a function of time in seconds.
#[derive(Clone)]
pub struct Remake(pub Arc<dyn Fn(f64) -> Mesh + Send + Sync>);

impl std::fmt::Debug for Remake {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("Remake")
    }
}

impl Mesh {
    /// Triangles of a cloud's disc.
    pub const DISC: usize = crate::cloud::FACES;

    /// Whether it is a cloud of points, each a disc.
    pub fn is_cloud(&self) -> bool {
        !self.discs.is_empty()
    }

    /// Makes the vertices those with the indices in `take`, with all their attributes, normals of
    /// the file included; triangles stay as they are.
    pub(crate) fn pick(&mut self, take: &[u32]) {
        pick(&mut self.positions, take);
        pick(&mut self.tangents, take);
        pick(&mut self.colours, take);
        self.uvs.iter_mut().for_each(|uv| pick(uv, take));
        self.influences.joints.iter_mut().for_each(|j| pick(j, take));
        self.influences.weights.iter_mut().for_each(|w| pick(w, take));
        for morph in &mut self.morphs {
            pick(&mut morph.positions, take);
            pick(&mut morph.normals, take);
            pick(&mut morph.tangents, take);
        }
        if let NormalSource::Given(normals) = &mut self.normals {
            pick(normals, take);
        }
    }
}

fn pick<T: Copy>(values: &mut Vec<T>, take: &[u32]) {
    if !values.is_empty() {
        *values = take.iter().map(|&i| values[i as usize]).collect();
    }
}

/// Whether a position is finite and within 1e12 of the origin along each axis: past that, areas and
/// distances leave the range of single precision.
pub(crate) fn is_in_reach(p: Vec3) -> bool {
    // Asked of each axis, for the greatest of some passes over what is not a number.
    p.abs().cmple(Vec3::splat(1e12)).all()
}
