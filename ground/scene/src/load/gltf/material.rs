//! Materials: metallic-roughness, with what extensions add.
//!
//! Of KHR_materials_specular the factor is read. Specular-glossiness is read as base colour (its diffuse colour) and roughness (one minus
//! glossiness). Where an image is missing, mid-grey stands in for colours; relief, emission and
//! metal that only it knew are left out.

use super::context::{Context, Place};
use super::json::Value;
use super::primitive::UV_SETS;
use super::texture::Textures;
use crate::{Alpha, Material, TextureUse};
use chiaro_basis::Result;

const SPECULAR: &str = "KHR_materials_pbrSpecularGlossiness";

/// The default material and all of the document's.
pub(super) fn read(
    root: &Value,
    textures: &mut Textures,
    cx: &mut Context,
) -> Result<Vec<Material>> {
    let mut materials = vec![Material::default()];
    for (i, item) in root.list("materials").iter().enumerate() {
        let count = root.list("textures").len();
        let mut reader = Reader { textures, place: Place::new("material", i), count, cx };
        let material = reader.material(item)?;
        materials.push(material);
    }
    Ok(materials)
}

/// What reading a slot for a texture found.
enum Slot {
    Unused,
    Used(TextureUse),
    /// There should be a texture, but there is none to see.
    Missing,
}

impl Slot {
    fn used(self) -> Option<TextureUse> {
        if let Self::Used(used) = self { Some(used) } else { None }
    }
}

struct Reader<'m, 't, 'r, 'b, 'c, 'd> {
    textures: &'m mut Textures<'t, 'r, 'b>,
    place: Place,
    count: usize,
    cx: &'m mut Context<'c, 'd>,
}

impl Reader<'_, '_, '_, '_, '_, '_> {
    fn material(&mut self, item: &Value) -> Result<Material> {
        let mut m = Material {
            name: item.name(),
            double_sided: item.flag("doubleSided"),
            unlit: item.extension("KHR_materials_unlit").is_object(),
            alpha: alpha(item),
            metallic: 1.0,
            ..Material::default()
        };
        if item.extension(SPECULAR).is_object() {
            self.specular_glossiness(item.extension(SPECULAR), &mut m)?;
        } else {
            self.metallic_roughness(item.get("pbrMetallicRoughness"), &mut m)?;
        }
        let normal = item.get("normalTexture");
        m.normal_texture = self.slot(normal)?.used();
        let coat = item.extension("KHR_materials_specular");
        m.specular = if m.unlit { 0.0 } else { number(coat, "specularFactor", 1.0, 0.0, 1.0) };
        m.normal_scale = number(normal, "scale", 1.0, -1e6, 1e6);
        self.emission(item, &mut m)?;
        Ok(m)
    }

    fn metallic_roughness(&mut self, item: &Value, m: &mut Material) -> Result<()> {
        m.base_colour = colour(item, "baseColorFactor");
        m.base_texture = self.colour_slot(item.get("baseColorTexture"))?;
        m.metallic = number(item, "metallicFactor", 1.0, 0.0, 1.0);
        m.roughness = number(item, "roughnessFactor", 1.0, 0.0, 1.0);
        match self.slot(item.get("metallicRoughnessTexture"))? {
            Slot::Used(used) => m.metallic_roughness_texture = Some(used),
            // The factor alone would often make all of it metal.
            Slot::Missing => m.metallic = 0.0,
            Slot::Unused => {}
        }
        Ok(())
    }

    fn specular_glossiness(&mut self, item: &Value, m: &mut Material) -> Result<()> {
        m.base_colour = colour(item, "diffuseFactor");
        m.base_texture = self.colour_slot(item.get("diffuseTexture"))?;
        m.metallic = 0.0;
        m.roughness = 1.0 - number(item, "glossinessFactor", 1.0, 0.0, 1.0);
        Ok(())
    }

    fn emission(&mut self, item: &Value, m: &mut Material) -> Result<()> {
        let strength = item.extension("KHR_materials_emissive_strength");
        let strength = number(strength, "emissiveStrength", 1.0, 0.0, 1e9);
        let factor = item.numbers::<3>("emissiveFactor").unwrap_or([0.0; 3]);
        m.emissive = factor.map(|c| (c.clamp(0.0, 1e9) as f32) * strength);
        match self.slot(item.get("emissiveTexture"))? {
            Slot::Used(used) => m.emissive_texture = Some(used),
            Slot::Missing => m.emissive = [0.0; 3],
            Slot::Unused => {}
        }
        Ok(())
    }

    /// A slot for colours: grey stands in where the image is missing.
    fn colour_slot(&mut self, info: &Value) -> Result<Option<TextureUse>> {
        Ok(match self.slot(info)? {
            Slot::Missing => Some(TextureUse::plain(self.textures.grey())),
            slot => slot.used(),
        })
    }

    fn slot(&mut self, info: &Value) -> Result<Slot> {
        if !info.is_object() {
            return Ok(Slot::Unused);
        }
        let texture = match info.get("index").as_index("texture", self.count) {
            Ok(index) => self.textures.get(index, self.cx)?,
            Err(why) => {
                self.cx.note(self.place, why);
                None
            }
        };
        let Some(texture) = texture else { return Ok(Slot::Missing) };
        let transform = info.extension("KHR_texture_transform");
        let own = info.whole("texCoord", 0).unwrap_or(0);
        let mut uv_set = transform.whole("texCoord", own).unwrap_or(own);
        if uv_set >= UV_SETS {
            self.cx.note(
                self.place,
                format!("of texture coordinates the first {UV_SETS} sets are read"),
            );
            uv_set = 0;
        }
        Ok(Slot::Used(TextureUse { texture, uv_set, matrix: matrix(transform) }))
    }
}

fn alpha(item: &Value) -> Alpha {
    match item.text("alphaMode") {
        Some("MASK") => Alpha::Mask(number(item, "alphaCutoff", 0.5, 0.0, 1e6)),
        Some("BLEND") => Alpha::Blend,
        _ => Alpha::Opaque,
    }
}

/// The number `key` in [low, high], or `absent`.
fn number(item: &Value, key: &str, absent: f32, low: f64, high: f64) -> f32 {
    item.number(key).map_or(absent, |n| n.clamp(low, high) as f32)
}

/// Four numbers in [0, 1]; white where there are none.
fn colour(item: &Value, key: &str) -> [f32; 4] {
    item.numbers::<4>(key).map_or([1.0; 4], |c| c.map(|c| c.clamp(0.0, 1.0) as f32))
}

/// Rows of the matrix of KHR_texture_transform: scaled, turned, moved. With v down, turning
/// counter-clockwise takes u to -v.
fn matrix(transform: &Value) -> [[f32; 3]; 2] {
    let two = |key: &str, absent: f64| transform.numbers::<2>(key).unwrap_or([absent; 2]);
    let ([tx, ty], [sx, sy]) = (two("offset", 0.0), two("scale", 1.0));
    let (sin, cos) = transform.number("rotation").unwrap_or(0.0).sin_cos();
    let rows = [[cos * sx, sin * sy, tx], [-sin * sx, cos * sy, ty]];
    rows.map(|row| row.map(|n| n.clamp(-1e30, 1e30) as f32))
}
