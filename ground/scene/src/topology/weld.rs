//! [`Weld`]: which vertices of a mesh are one.
//!
//! Vertices begin as one class for each position and are parted by whatever could move them
//! differently: joint by joint, morph target by morph target. Positions are compared exactly (the
//! two zeros are one), so that two poses of one film never weld differently.

use crate::{Influences, Mesh};
use chiaro_basis::math::Vec3;
use std::collections::HashMap;
use std::hash::Hash;

/// Which vertices of a mesh are one.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Weld {
    /// The welded vertex of each vertex of the mesh; numbered in order of first appearance.
    pub welded: Vec<u32>,
    /// The first vertex of the mesh in each welded vertex, rising.
    pub first: Vec<u32>,
}

impl Weld {
    /// Welds vertices of equal position, joints with weights, and displacements in every morph
    /// target: they stay together whatever plays.
    pub fn of(mesh: &Mesh) -> Self {
        let mut classes = Classes::of(mesh.positions.len());
        classes.part(|v| bits(mesh.positions[v]));
        if !mesh.influences.joints.is_empty() {
            classes.part(|v| held_by(&mesh.influences, v));
        }
        for morph in mesh.morphs.iter().filter(|m| !m.positions.is_empty()) {
            classes.part(|v| bits(morph.positions[v]));
        }
        classes.weld()
    }

    /// Welds vertices that have equal positions in every one of `poses`; poses of another length
    /// than the mesh's are passed over.
    pub fn over(mesh: &Mesh, poses: &[&[Vec3]]) -> Self {
        let mut classes = Classes::of(mesh.positions.len());
        for pose in poses.iter().filter(|p| p.len() == mesh.positions.len()) {
            classes.part(|v| bits(pose[v]));
        }
        classes.weld()
    }

    /// One value for each welded vertex, from one for each vertex of the mesh.
    pub fn gather<T: Copy>(&self, values: &[T]) -> Vec<T> {
        self.first.iter().map(|&v| values[v as usize]).collect()
    }
}

/// A partition of the vertices, refined step by step.
struct Classes {
    class: Vec<u32>,
    parted: bool,
}

impl Classes {
    fn of(vertices: usize) -> Self {
        Self { class: vec![0; vertices], parted: false }
    }

    /// Parts vertices with different keys; classes are numbered in order of first appearance.
    fn part<K: Hash + Eq>(&mut self, key: impl Fn(usize) -> K) {
        let mut seen: HashMap<(u32, K), u32> = HashMap::with_capacity(self.class.len());
        for (v, class) in self.class.iter_mut().enumerate() {
            let next = seen.len() as u32;
            *class = *seen.entry((*class, key(v))).or_insert(next);
        }
        self.parted = true;
    }

    fn weld(self) -> Weld {
        if !self.parted {
            let each: Vec<u32> = (0..self.class.len() as u32).collect();
            return Weld { welded: each.clone(), first: each };
        }
        let mut first: Vec<u32> = Vec::new();
        for (v, &class) in self.class.iter().enumerate() {
            if class as usize == first.len() {
                first.push(v as u32);
            }
        }
        Weld { welded: self.class, first }
    }
}

/// The bits of a vector, the two zeros made one.
fn bits(p: Vec3) -> [u32; 3] {
    (p + Vec3::ZERO).to_array().map(f32::to_bits)
}

/// A vertex's joints with their weights, in the order of joints, without those that do not count.
fn held_by(influences: &Influences, vertex: usize) -> Vec<(u16, u32)> {
    let sets = influences.joints.iter().zip(&influences.weights);
    let pairs = sets.flat_map(|(j, w)| j[vertex].into_iter().zip(w[vertex]));
    let mut held: Vec<(u16, f32)> = pairs.filter(|(_, w)| *w != 0.0).collect();
    held.sort_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)));
    held.dedup_by(|later, kept| {
        let same = later.0 == kept.0;
        if same {
            kept.1 += later.1;
        }
        same
    });
    held.into_iter().map(|(joint, weight)| (joint, weight.to_bits())).collect()
}
