//! [`Material`]: the metallic-roughness model, and the textures it reads.

use crate::TextureId;
use chiaro_basis::math::{Vec2, vec2};
use chiaro_image::Plane;

/// What a surface is made of. Colours are linear RGB.
#[derive(Clone, Debug)]
pub struct Material {
    /// The name in the file, or empty.
    pub name: String,
    /// Base colour and opacity.
    pub base_colour: [f32; 4],
    /// Multiplies the base colour (sRGB texels).
    pub base_texture: Option<TextureUse>,
    /// 0 = dielectric, 1 = metal.
    pub metallic: f32,
    /// Perceptual roughness in [0, 1]; the distribution's alpha is its square.
    pub roughness: f32,
    /// How much a dielectric coat reflects: 1 is glTF's, 4 % head-on; 0 is none, as in formats that
    /// say nothing of it.
    pub specular: f32,
    /// Multiplies roughness by green and metallic by blue (linear texels).
    pub metallic_roughness_texture: Option<TextureUse>,
    /// Tangent-space normals, 2c - 1, y up (linear texels).
    pub normal_texture: Option<TextureUse>,
    /// Scales x and y of the normal texture.
    pub normal_scale: f32,
    /// Emitted radiance, its strength included.
    pub emissive: [f32; 3],
    /// Multiplies the emission (sRGB texels).
    pub emissive_texture: Option<TextureUse>,
    /// How opacity is used.
    pub alpha: Alpha,
    /// Whether the back is drawn, with the normal turned.
    pub double_sided: bool,
    /// Whether the base colour is shown as it is, without light.
    pub unlit: bool,
}

impl Default for Material {
    fn default() -> Self {
        Self {
            name: String::new(),
            base_colour: [1.0; 4],
            base_texture: None,
            metallic: 0.0,
            roughness: 1.0,
            specular: 0.0,
            metallic_roughness_texture: None,
            normal_texture: None,
            normal_scale: 1.0,
            emissive: [0.0; 3],
            emissive_texture: None,
            alpha: Alpha::Opaque,
            double_sided: true,
            unlit: false,
        }
    }
}

impl Material {
    /// Whether it emits light at all.
    pub fn shines(&self) -> bool {
        self.emissive.iter().any(|e| *e > 0.0)
    }
}

/// How opacity is used.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Alpha {
    /// Ignored.
    Opaque,
    /// Below the cutoff there is no surface.
    Mask(f32),
    /// Below one half there is no surface: ink has no half-tones.
    Blend,
}

/// A texture as a material reads it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TextureUse {
    /// Which texture.
    pub texture: TextureId,
    /// Which set of coordinates of the mesh.
    pub uv_set: usize,
    /// Rows of the 2 x 3 matrix that maps (u, v, 1) to texture space.
    pub matrix: [[f32; 3]; 2],
}

impl TextureUse {
    /// The texture, read with uv set 0 as it is.
    pub fn plain(texture: TextureId) -> Self {
        Self { texture, uv_set: 0, matrix: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]] }
    }

    /// Texture coordinates for the mesh's `uv`.
    pub fn map(&self, uv: Vec2) -> Vec2 {
        let [a, b] = self.matrix;
        vec2(a[0] * uv.x + a[1] * uv.y + a[2], b[0] * uv.x + b[1] * uv.y + b[2])
    }
}

/// How coordinates outside [0, 1) are read.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Wrap {
    /// The picture repeats.
    #[default]
    Repeat,
    /// The picture repeats, every other time mirrored.
    Mirror,
    /// The border goes on.
    Clamp,
}

/// How texels are read between their centres.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Filter {
    /// Bilinear.
    #[default]
    Linear,
    /// The nearest texel.
    Nearest,
}

/// A picture with its wrap modes; v = 0 is the top row.
#[derive(Clone, Debug)]
pub struct Texture {
    /// The name or URI of the picture.
    pub name: String,
    /// RGBA as stored: whoever reads it knows whether it is sRGB.
    pub pixels: std::sync::Arc<Plane<[u8; 4]>>,
    /// In u and v.
    pub wrap: [Wrap; 2],
    /// Between texels.
    pub filter: Filter,
}

impl Texture {
    /// The texel value at `uv`, in [0, 1] as stored; `decode` is applied to RGB of each texel
    /// before filtering.
    pub fn sample(&self, uv: Vec2, decode: impl Fn(u8) -> f32) -> [f32; 4] {
        let (w, h) = self.pixels.size();
        let at = |x: i64, y: i64| {
            let p = self.pixels[(self.wrap[0].index(x, w), self.wrap[1].index(y, h))];
            [decode(p[0]), decode(p[1]), decode(p[2]), f32::from(p[3]) / 255.0]
        };
        let (x, y) = (place(uv.x, w), place(uv.y, h));
        if self.filter == Filter::Nearest {
            return at(x.floor() as i64, y.floor() as i64);
        }
        let (x, y) = (x - 0.5, y - 0.5);
        let (fx, fy) = ((x - x.floor()) as f32, (y - y.floor()) as f32);
        let (x, y) = (x.floor() as i64, y.floor() as i64);
        let mix =
            |a: [f32; 4], b: [f32; 4], t: f32| std::array::from_fn(|i| a[i] + (b[i] - a[i]) * t);
        mix(mix(at(x, y), at(x + 1, y), fx), mix(at(x, y + 1), at(x + 1, y + 1), fx), fy)
    }
}

/// A coordinate in texels; what is not finite, or absurdly far out, reads the first texel.
fn place(u: f32, size: usize) -> f64 {
    let x = f64::from(u) * size as f64;
    if x.abs() < 1e15 { x } else { 0.0 }
}

impl Wrap {
    fn index(self, i: i64, size: usize) -> usize {
        let n = size as i64;
        let k = match self {
            Self::Repeat => i.rem_euclid(n),
            Self::Clamp => i.clamp(0, n - 1),
            Self::Mirror => {
                let m = i.rem_euclid(2 * n);
                if m < n { m } else { 2 * n - 1 - m }
            }
        };
        k as usize
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn checker(wrap: Wrap, filter: Filter) -> Texture {
        let pixels = Plane::from_fn(2, 2, |x, y| if (x + y) % 2 == 0 { [255; 4] } else { [0; 4] });
        Texture { name: String::new(), pixels: pixels.into(), wrap: [wrap; 2], filter }
    }

    fn red(texture: &Texture, u: f32, v: f32) -> f32 {
        texture.sample(vec2(u, v), |b| f32::from(b) / 255.0)[0]
    }

    #[test]
    fn texel_centres_read_their_texel_and_the_middle_their_mean() {
        let t = checker(Wrap::Repeat, Filter::Linear);
        assert_eq!(red(&t, 0.25, 0.25), 1.0);
        assert_eq!(red(&t, 0.75, 0.25), 0.0);
        assert_eq!(red(&t, 0.5, 0.5), 0.5);
    }

    #[test]
    fn wraps_continue_as_they_say() {
        assert_eq!(red(&checker(Wrap::Repeat, Filter::Nearest), 1.25, 0.25), 1.0);
        assert_eq!(red(&checker(Wrap::Mirror, Filter::Nearest), 1.25, 0.25), 0.0);
        assert_eq!(red(&checker(Wrap::Clamp, Filter::Nearest), 9.0, 0.25), 0.0);
        assert_eq!(red(&checker(Wrap::Repeat, Filter::Nearest), f32::NAN, 0.25), 1.0);
    }
}
