//! [`Masks`]: faces whose textures cut holes into them, such as leaves on cards.
//!
//! Where a material's opacity falls below its cutoff there is no surface: nothing is hidden behind it,
//! and no line of it is seen. Not done: the outline of what is left is a line of the texture, and is
//! not drawn.

use crate::surface::{NONE, Source, Surface};
use chiaro_basis::math::Vec2;
use chiaro_scene::{Alpha, Frame, Mesh, Scene, Texture};
use std::collections::HashMap;

/// The faces of a surface that have holes.
#[derive(Clone, Debug, Default)]
pub struct Masks {
    /// For each real face, which of `cuts`, or [`NONE`]; empty where no face has holes.
    of_face: Vec<u32>,
    cuts: Vec<Cut>,
    textures: Vec<Texture>,
}

/// Texture coordinates and opacity at the corners of a face, in the surface's order.
#[derive(Clone, Copy, Debug)]
struct Cut {
    texture: u32,
    uv: [Vec2; 3],
    alpha: [f32; 3],
    cutoff: f32,
}

impl Masks {
    /// The masks of a frame's surface.
    pub(crate) fn of(scene: &Scene, frame: &Frame, surface: &Surface) -> Self {
        let mut masks = Self::default();
        let mut known = HashMap::new();
        for (f, source) in surface.sources.iter().enumerate() {
            let mesh = frame.shapes[frame.objects[source.object as usize].shape].mesh_in(scene);
            if let Some(cut) = masks.cut(scene, mesh, source, &mut known) {
                masks.of_face.resize(surface.real_faces, NONE);
                masks.of_face[f] = masks.cuts.len() as u32;
                masks.cuts.push(cut);
            }
        }
        masks
    }

    fn cut(
        &mut self,
        scene: &Scene,
        mesh: &Mesh,
        source: &Source,
        known: &mut HashMap<usize, u32>,
    ) -> Option<Cut> {
        let material = &scene.materials[source.material.index()];
        let cutoff = match material.alpha {
            Alpha::Opaque => return None,
            Alpha::Mask(cutoff) => cutoff,
            Alpha::Blend => 0.5,
        };
        let used = material.base_texture?;
        let uvs = mesh.uvs.get(used.uv_set).filter(|uvs| !uvs.is_empty())?;
        let corners = mesh.triangles[source.face as usize];
        let uv = corners.map(|v| uvs.get(v as usize).map_or(Vec2::ZERO, |uv| used.map(*uv)));
        let own = |v: u32| mesh.colours.get(v as usize).map_or(1.0, |c| c.w);
        let alpha = corners.map(|v| material.base_colour[3] * own(v));
        let index = used.texture.index();
        let texture = *known.entry(index).or_insert_with(|| {
            self.textures.push(scene.textures[index].clone());
            self.textures.len() as u32 - 1
        });
        let places = placed(source);
        let mix = |w: [f32; 3]| uv[0] * w[0] + uv[1] * w[1] + uv[2] * w[2];
        let fade = |w: [f32; 3]| (0..3).map(|i| alpha[i] * w[i]).sum();
        Some(Cut { texture, uv: places.map(mix), alpha: places.map(fade), cutoff })
    }

    /// Whether a point of a face, by the weights of its corners, is in a hole.
    pub(crate) fn is_hole(&self, face: u32, weights: [f64; 3]) -> bool {
        let Some(&cut) = self.of_face.get(face as usize).filter(|c| **c != NONE) else {
            return false;
        };
        let cut = &self.cuts[cut as usize];
        let w = weights.map(|w| w as f32);
        let uv = cut.uv[0] * w[0] + cut.uv[1] * w[1] + cut.uv[2] * w[2];
        let own: f32 = (0..3).map(|i| cut.alpha[i] * w[i]).sum();
        own * self.textures[cut.texture as usize].sample(uv, |_| 0.0)[3] < cut.cutoff
    }

    /// Whether a face may have holes.
    pub(crate) fn has(&self, face: u32) -> bool {
        self.of_face.get(face as usize).is_some_and(|c| *c != NONE)
    }
}

/// The corners of a face as weights of the corners of its triangle in the mesh's order.
fn placed(source: &Source) -> [[f32; 3]; 3] {
    let mut corners = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    if source.turned {
        corners.swap(1, 2);
    }
    let levels = (source.part.max(1).ilog2()) / 2;
    for level in (0..levels).rev() {
        let [a, b, c] = corners;
        let middle = |p: [f32; 3], q: [f32; 3]| std::array::from_fn(|i| 0.5 * (p[i] + q[i]));
        let (m, n, o) = (middle(a, b), middle(b, c), middle(c, a));
        corners = match source.part >> (2 * level) & 3 {
            0 => [a, m, o],
            1 => [m, b, n],
            2 => [o, n, c],
            _ => [m, n, o],
        };
    }
    if source.mirrored {
        corners.swap(1, 2);
    }
    corners
}
