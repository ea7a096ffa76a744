//! [`Geometry`]: vertices on their way from a mesh to a shape.
//!
//! What does not change is borrowed from the mesh. Vertices are independent of each other, so they
//! are carried in parallel; normals from faces are found after the last bend.

use super::map::Map;
use crate::{Influences, Mesh, MeshId, NormalSource, Shape};
use chiaro_basis::math::{DAffine3, DMat3, DVec3, Vec3, Vec4};
use rayon::prelude::*;
use std::borrow::Cow;
use std::sync::Arc;

/// Fewer vertices than this are not worth a thread.
const CHUNK: usize = 4096;

/// Positions, normals (empty until they are found from faces) and tangents (or none).
pub(super) struct Geometry<'a> {
    positions: Cow<'a, [Vec3]>,
    normals: Cow<'a, [Vec3]>,
    tangents: Cow<'a, [Vec4]>,
}

impl<'a> Geometry<'a> {
    /// A mesh as its morph targets leave it, with normals, in its own space.
    pub(super) fn at_rest(mesh: &'a Mesh, weights: &[f32]) -> Self {
        Self::morphed(mesh, weights).with_normals(mesh, false)
    }

    /// The same vertices, borrowed.
    pub(super) fn borrowed(&self) -> Geometry<'_> {
        Geometry {
            positions: Cow::Borrowed(&self.positions),
            normals: Cow::Borrowed(&self.normals),
            tangents: Cow::Borrowed(&self.tangents),
        }
    }

    /// A mesh with its morph targets added, in its own space; normals only if the file gives them.
    pub(super) fn morphed(mesh: &'a Mesh, weights: &[f32]) -> Self {
        let normals: &[Vec3] = match &mesh.normals {
            NormalSource::Given(normals) if normals.len() == mesh.positions.len() => normals,
            _ => &[],
        };
        let mut morphed = Self {
            positions: Cow::Borrowed(&mesh.positions),
            normals: Cow::Borrowed(normals),
            tangents: Cow::Borrowed(&mesh.tangents),
        };
        for (morph, &w) in mesh.morphs.iter().zip(weights).filter(|(_, w)| **w != 0.0) {
            add(&mut morphed.positions, &morph.positions, |d| *d * w);
            add(&mut morphed.normals, &morph.normals, |d| *d * w);
            add(&mut morphed.tangents, &morph.tangents, |d| (*d * w).extend(0.0));
        }
        morphed
    }

    /// Finds the normals that the mesh leaves to its faces; `mirrored` faces wind backwards.
    pub(super) fn with_normals(mut self, mesh: &Mesh, mirrored: bool) -> Self {
        if !self.normals.is_empty() {
            return self;
        }
        let own: Vec<u32>;
        let groups = match &mesh.normals {
            NormalSource::Faces(groups) => groups,
            NormalSource::Given(_) => {
                own = (0..self.positions.len() as u32).collect();
                &own
            }
        };
        let mut normals = crate::normals::of_faces(&self.positions, &mesh.triangles, groups);
        if mirrored {
            normals.iter_mut().for_each(|n| *n = -*n);
        }
        self.normals = Cow::Owned(normals);
        self
    }

    /// All vertices carried by one map.
    pub(super) fn placed(&self, place: DAffine3) -> Geometry<'static> {
        let map = Map::new(place);
        Geometry {
            positions: carried(&self.positions, |_, p| map.position(p)),
            normals: carried(&self.normals, |_, n| map.normal(n)),
            tangents: carried(&self.tangents, |_, t| map.tangent(t)),
        }
    }

    /// Each vertex carried by its blend of the joints (linear blend skinning).
    pub(super) fn skinned(&self, mesh: &Mesh, joints: &[DAffine3]) -> Geometry<'static> {
        let map = |v: usize| Map::new(blend(&mesh.influences, v, joints));
        Geometry {
            positions: carried(&self.positions, |v, p| map(v).position(p)),
            normals: carried(&self.normals, |v, n| map(v).normal(n)),
            tangents: carried(&self.tangents, |v, t| map(v).tangent(t)),
        }
    }

    /// The shape; normals and tangents come out as unit vectors.
    pub(super) fn shape(self, mesh: MeshId, remade: Option<Arc<Mesh>>) -> Shape {
        let tangent = |t: &Vec4| t.truncate().normalize_or(Vec3::X).extend(t.w);
        Shape {
            mesh,
            remade,
            positions: self.positions.into(),
            normals: self.normals.iter().map(|n| n.normalize_or(Vec3::Z)).collect(),
            tangents: self.tangents.iter().map(tangent).collect(),
        }
    }
}

fn add<T, D>(values: &mut Cow<[T]>, deltas: &[D], weighted: impl Fn(&D) -> T + Sync)
where
    T: Copy + Send + Sync + std::ops::AddAssign,
    D: Sync,
{
    if values.is_empty() || deltas.is_empty() {
        return;
    }
    let values = values.to_mut().par_iter_mut().with_min_len(CHUNK);
    values.zip(deltas).for_each(|(value, d)| *value += weighted(d));
}

fn carried<T: Copy + Send + Sync>(
    values: &[T],
    carry: impl Fn(usize, T) -> T + Sync,
) -> Cow<'static, [T]> {
    let values = values.par_iter().with_min_len(CHUNK).enumerate();
    Cow::Owned(values.map(|(v, &value)| carry(v, value)).collect())
}

/// The weighted mean of a vertex's joints; a vertex that no joint holds stays where it is.
fn blend(influences: &Influences, vertex: usize, joints: &[DAffine3]) -> DAffine3 {
    let (mut matrix, mut translation, mut held) = (DMat3::ZERO, DVec3::ZERO, false);
    for (set, weights) in influences.joints.iter().zip(&influences.weights) {
        for (joint, weight) in set[vertex].iter().zip(weights[vertex]) {
            if weight != 0.0
                && let Some(joint) = joints.get(usize::from(*joint))
            {
                matrix += joint.matrix3 * f64::from(weight);
                translation += joint.translation * f64::from(weight);
                held = true;
            }
        }
    }
    if held { DAffine3::from_mat3_translation(matrix, translation) } else { DAffine3::IDENTITY }
}
