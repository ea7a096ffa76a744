//! Mip pyramids: each texture with its halves, quarters and so on, for reading at any footprint.
//!
//! Levels are box averages of decoded values (linear light for colours), so that a normal map's
//! coarse levels hold mean normals.

use chiaro_basis::math::Vec2;
use chiaro_image::{Plane, colour};
use chiaro_scene::{Filter, Scene, Texture, TextureId};
use std::sync::Arc;

/// The pyramids of a scene's textures.
pub(crate) struct Mips {
    pyramids: Vec<Option<Pyramid>>,
}

struct Pyramid {
    /// Level 0 is the texture itself; all levels are encoded alike.
    levels: Vec<Texture>,
    colour: bool,
    decode: Arc<[f32; 256]>,
}

impl Mips {
    /// Pyramids of the textures that some material reads.
    pub(crate) fn of(scene: &Scene) -> Self {
        let mut is_colour: Vec<Option<bool>> = vec![None; scene.textures.len()];
        for m in &scene.materials {
            for used in [&m.metallic_roughness_texture, &m.normal_texture].into_iter().flatten() {
                is_colour[used.texture.index()].get_or_insert(false);
            }
            for used in [&m.base_texture, &m.emissive_texture].into_iter().flatten() {
                is_colour[used.texture.index()] = Some(true);
            }
        }
        let pyramids = is_colour
            .into_iter()
            .zip(&scene.textures)
            .map(|(colour, texture)| colour.map(|c| Pyramid::new(texture, c)))
            .collect();
        Self { pyramids }
    }

    /// RGBA, decoded, at `uv` and at `level` (log2 of texels a pixel), linear between levels.
    pub(crate) fn sample(&self, texture: TextureId, uv: Vec2, level: f32) -> [f32; 4] {
        match &self.pyramids[texture.index()] {
            Some(p) => p.sample(uv, level),
            None => [1.0; 4],
        }
    }
}

impl Pyramid {
    fn new(texture: &Texture, colour: bool) -> Self {
        let decode = Arc::new(std::array::from_fn(|i| {
            let c = i as f32 / 255.0;
            if colour { colour::srgb_decode(c) } else { c }
        }));
        let mut pyramid = Self { levels: vec![texture.clone()], colour, decode };
        while let Some(next) = pyramid.halved() {
            pyramid.levels.push(next);
        }
        pyramid
    }

    fn halved(&self) -> Option<Texture> {
        let fine = self.levels.last()?;
        let (w, h) = fine.pixels.size();
        if w <= 1 && h <= 1 {
            return None;
        }
        let (cw, ch) = (w.div_ceil(2), h.div_ceil(2));
        let pixels = Plane::from_fn(cw, ch, |x, y| {
            let xs = [2 * x, (2 * x + 1).min(w - 1)];
            let ys = [2 * y, (2 * y + 1).min(h - 1)];
            self.mean(ys.map(|y| xs.map(|x| fine.pixels[(x, y)])))
        });
        Some(Texture { pixels: Arc::new(pixels), filter: Filter::Linear, ..fine.clone() })
    }

    fn mean(&self, texels: [[[u8; 4]; 2]; 2]) -> [u8; 4] {
        let [a, b, c, d] = [texels[0][0], texels[0][1], texels[1][0], texels[1][1]];
        std::array::from_fn(|i| {
            let value = |t: [u8; 4]| match i {
                3 => f32::from(t[3]) / 255.0,
                _ => self.decode[usize::from(t[i])],
            };
            let mean = 0.25 * (value(a) + value(b) + value(c) + value(d));
            let encode = self.colour && i < 3;
            colour::to_byte(if encode { colour::srgb_encode(mean) } else { mean })
        })
    }

    fn sample(&self, uv: Vec2, level: f32) -> [f32; 4] {
        let read = |i: usize| self.levels[i].sample(uv, |b| self.decode[usize::from(b)]);
        let top = self.levels.len() - 1;
        if level.is_nan() || level <= 0.0 {
            return read(0);
        }
        let fine = (level as usize).min(top);
        let t = level.min(top as f32) - fine as f32;
        let (a, b) = (read(fine), read((fine + 1).min(top)));
        std::array::from_fn(|i| a[i] + (b[i] - a[i]) * t)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use chiaro_basis::math::vec2;
    use chiaro_scene::Wrap;

    #[test]
    fn a_far_checker_is_grey_in_linear_light() {
        let pixels = Plane::from_fn(64, 64, |x, y| [[0, 0, 0, 255], [255; 4]][(x + y) % 2]);
        let texture = Texture {
            name: String::new(),
            pixels: pixels.into(),
            wrap: [Wrap::Repeat; 2],
            filter: Filter::Linear,
        };
        let p = Pyramid::new(&texture, true);
        assert!((p.sample(vec2(0.3, 0.7), 3.5)[0] - 0.5).abs() < 0.01);
        assert_eq!(p.sample(vec2(0.5 / 64.0, 0.5 / 64.0), -2.0)[0], 0.0);
    }
}
