//! [`Masks`]: faces whose textures cut holes into them, such as leaves on cards.
//!
//! Where a material's opacity falls below its cutoff there is no surface: nothing is hidden behind it,
//! and no line of it is seen. Where what is left ends there is a line ([`crate::Fringe`]).

use crate::surface::{NONE, Source, Surface};
use chiaro_basis::math::Vec2;
use chiaro_scene::{Alpha, Frame, Mesh, Scene, Texture};
use std::collections::HashMap;

/// Most looks at a texture along a side of a cell.
const LOOKS: f64 = 4.0;

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

    /// By how much the opacity is above its cutoff, averaged over a cell around a point of a face with
    /// holes; `n` cells are along each edge.
    pub(crate) fn excess(&self, face: u32, weights: [f32; 3], n: u32) -> f32 {
        let cut = &self.cuts[self.of_face[face as usize] as usize];
        let texture = &self.textures[cut.texture as usize];
        let looks = (self.texels(face) / f64::from(n)).ceil().clamp(1.0, LOOKS) as u32;
        let offset = |k: u32| ((k as f32 + 0.5) / looks as f32 - 0.5) / n as f32;
        let look = |(i, j): (u32, u32)| {
            let (a, b) = (offset(i), offset(j));
            let w = [weights[0] - a - b, weights[1] + a, weights[2] + b];
            let uv = cut.uv[0] * w[0] + cut.uv[1] * w[1] + cut.uv[2] * w[2];
            let own: f32 = (0..3).map(|i| cut.alpha[i] * w[i]).sum();
            own * texture.sample(uv, |_| 0.0)[3]
        };
        let all = (0..looks).flat_map(|i| (0..looks).map(move |j| (i, j)));
        all.map(look).sum::<f32>() / (looks * looks) as f32 - cut.cutoff
    }

    /// Texels along the longest edge of a face with holes.
    pub(crate) fn texels(&self, face: u32) -> f64 {
        let cut = &self.cuts[self.of_face[face as usize] as usize];
        let (w, h) = self.textures[cut.texture as usize].pixels.size();
        let size = Vec2::new(w as f32, h as f32);
        let side = |i: usize, j: usize| f64::from(((cut.uv[i] - cut.uv[j]) * size).length());
        side(0, 1).max(side(1, 2)).max(side(2, 0))
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
