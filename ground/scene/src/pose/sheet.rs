//! [`Sheet`]: how one shape comes about, and what of it is kept between frames.

use super::geometry::Geometry;
use super::map::mirrors;
use super::skin_of;
use super::state::State;
use crate::{Mesh, MeshId, NodeId, Scene, Shape};
use chiaro_basis::math::DAffine3;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

/// One shape of every frame.
pub(super) struct Sheet<'a> {
    mesh_id: MeshId,
    mesh: &'a Mesh,
    /// Whose transform, joints and morph weights count.
    node: NodeId,
    bends: Bends,
    /// How many objects show it.
    users: usize,
    /// A rigid mesh with its normals, in its own space.
    rest: OnceLock<Geometry<'a>>,
    /// The last shape, and the bits of everything that it was made from.
    last: Mutex<Option<(Vec<u64>, Shape)>>,
}

/// What changes a mesh over time.
#[derive(Clone, Copy, PartialEq)]
enum Bends {
    /// Nothing: it is at most carried around.
    Never,
    /// Morph weights.
    Morphs,
    /// Joints, after morph weights.
    Joints,
    /// It is made anew.
    Remade,
}

impl<'a> Sheet<'a> {
    /// The sheet of a node's mesh, if it has one.
    pub(super) fn of(scene: &'a Scene, node_id: NodeId) -> Option<Self> {
        let node = &scene.nodes[node_id.index()];
        let mesh_id = node.mesh?;
        let mesh = &scene.meshes[mesh_id.index()];
        let bends = if mesh.remake.is_some() {
            Bends::Remade
        } else if skin_of(scene, node).is_some() {
            Bends::Joints
        } else if mesh.morphs.is_empty() {
            Bends::Never
        } else {
            Bends::Morphs
        };
        let (rest, last) = (OnceLock::new(), Mutex::new(None));
        Some(Self { mesh_id, mesh, node: node_id, bends, users: 0, rest, last })
    }

    pub(super) fn add_users(&mut self, count: usize) {
        self.users += count;
    }

    /// Whether the shape stays in the mesh's space, for each object to place.
    pub(super) fn is_shared(&self) -> bool {
        self.users > 1
    }

    /// Whether an object at `place` shows the shape mirrored.
    pub(super) fn mirrors(&self, scene: &Scene, state: &State, place: &DAffine3) -> bool {
        match self.bends {
            Bends::Joints => mostly_mirror(&state.joints(scene, self.node)),
            _ => mirrors(place),
        }
    }

    /// The shape at a time.
    pub(super) fn shape(&self, scene: &Scene, state: &State, time: f64) -> Shape {
        let matrices = self.matrices(scene, state);
        let weights = &state.weights[self.node.index()];
        let weights = &weights[..weights.len().min(self.mesh.morphs.len())];
        let key = self.key(&matrices, weights, time);
        let last = || self.last.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((made_from, shape)) = &*last()
            && *made_from == key
        {
            return shape.clone();
        }
        let shape = self.make(&matrices, weights, time);
        *last() = Some((key, shape.clone()));
        shape
    }

    /// The joints of a skinned mesh, the place of one drawn once, nothing for a shared one.
    fn matrices(&self, scene: &Scene, state: &State) -> Vec<DAffine3> {
        match self.bends {
            Bends::Joints => state.joints(scene, self.node),
            _ if self.is_shared() => Vec::new(),
            _ => vec![state.place(scene, self.node, 0)],
        }
    }

    fn key(&self, matrices: &[DAffine3], weights: &[f32], time: f64) -> Vec<u64> {
        let numbers = matrices.iter().flat_map(|m| m.to_cols_array());
        let weights = weights.iter().map(|&w| f64::from(w));
        let time = (self.bends == Bends::Remade).then_some(time);
        numbers.chain(weights).chain(time).map(f64::to_bits).collect()
    }

    fn make(&self, matrices: &[DAffine3], weights: &[f32], time: f64) -> Shape {
        let remade = self.mesh.remake.as_ref().map(|remake| Arc::new((remake.0)(time)));
        let mesh = remade.as_deref().unwrap_or(self.mesh);
        let placed = |rest: &Geometry| matrices.first().map(|m| rest.placed(*m));
        let geometry = match self.bends {
            Bends::Never => {
                let rest = self.rest.get_or_init(|| Geometry::at_rest(self.mesh, &[]));
                placed(rest).unwrap_or_else(|| rest.borrowed())
            }
            Bends::Morphs | Bends::Remade => {
                let rest = Geometry::at_rest(mesh, weights);
                placed(&rest).unwrap_or(rest)
            }
            Bends::Joints => Geometry::morphed(mesh, weights)
                .skinned(mesh, matrices)
                .with_normals(mesh, mostly_mirror(matrices)),
        };
        geometry.shape(self.mesh_id, remade.clone())
    }
}

/// Whether a skin as a whole is a mirror image: most of its joints are.
fn mostly_mirror(joints: &[DAffine3]) -> bool {
    2 * joints.iter().filter(|j| mirrors(j)).count() > joints.len()
}
