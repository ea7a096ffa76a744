//! The statements of one material, and what they mean.

use super::linear;
use super::map::Map;
use crate::{Alpha, Material};

/// What a library says about a material. Statements come in any order, so that they mean something
/// only together.
#[derive(Clone, Debug, Default)]
pub(super) struct Entry {
    /// Whether colours are linear instead of sRGB-encoded: the library is by Blender.
    pub(super) is_linear: bool,
    diffuse: Option<[f32; 3]>,
    specular: Option<[f32; 3]>,
    emission: Option<[f32; 3]>,
    shininess: Option<f32>,
    roughness: Option<f32>,
    metallic: Option<f32>,
    opacity: Option<f32>,
    transparency: Option<f32>,
    pub(super) colour_map: Option<Map>,
    pub(super) opacity_map: Option<Map>,
    pub(super) glow_map: Option<Map>,
    pub(super) relief_map: Option<Map>,
}

impl Entry {
    /// Takes a statement, its key in lower case; what is broken or unknown is passed over.
    pub(super) fn statement(&mut self, key: &str, rest: &str) {
        match key {
            "kd" => self.diffuse = colour(rest).or(self.diffuse),
            "ks" => self.specular = colour(rest).or(self.specular),
            "ke" => self.emission = colour(rest).or(self.emission),
            "ns" => self.shininess = number(rest).or(self.shininess),
            "pr" => self.roughness = number(rest).or(self.roughness),
            "pm" => self.metallic = number(rest).or(self.metallic),
            "d" => self.opacity = number(rest).or(self.opacity),
            "tr" => self.transparency = number(rest).or(self.transparency),
            "map_kd" => self.colour_map = Map::read(rest),
            "map_d" => self.opacity_map = Map::read(rest),
            "map_ke" => self.glow_map = Map::read(rest),
            "norm" | "map_norm" => {
                self.relief_map = Map::read(rest).map(|map| Map { holds_normals: true, ..map });
            }
            "bump" | "map_bump" if !self.relief_map.as_ref().is_some_and(|m| m.holds_normals) => {
                self.relief_map = Map::read(rest);
            }
            _ => {}
        }
    }

    /// The material, without its name and textures.
    pub(super) fn material(&self) -> Material {
        let opacity = self.opacity();
        let [r, g, b] = self.base_colour();
        Material {
            base_colour: [r, g, b, opacity],
            metallic: self.metallic.unwrap_or(0.0).clamp(0.0, 1.0),
            roughness: self.roughness(),
            // Ks is written by exporters whatever the surface; these are of the same model as glTF's.
            specular: if self.roughness.or(self.metallic).is_some() { 1.0 } else { 0.0 },
            emissive: self.emission.unwrap_or_default().map(|c| c.max(0.0)),
            alpha: if opacity < 1.0 { Alpha::Blend } else { Alpha::Opaque },
            ..Material::default()
        }
    }

    fn base_colour(&self) -> [f32; 3] {
        match self.diffuse {
            // A black that a picture would be multiplied by is a slip of many exporters.
            Some([0.0, 0.0, 0.0]) | None if self.colour_map.is_some() => [1.0; 3],
            Some(colour) if self.is_linear => colour.map(|c| c.clamp(0.0, 1.0)),
            Some(colour) => linear(colour),
            None => [0.6; 3],
        }
    }

    /// `d`, else one minus `Tr`. A material that only `Tr 1` would make invisible is opaque: its
    /// writer took it for `d`.
    fn opacity(&self) -> f32 {
        let opaque = |t: f32| if t >= 1.0 { 1.0 } else { 1.0 - t };
        self.opacity.or(self.transparency.map(opaque)).unwrap_or(1.0).clamp(0.0, 1.0)
    }

    /// `Pr`, else from the shininess. A lobe cos^Ns is about as wide as a microfacet lobe with
    /// alpha^2 = 2 / (Ns + 2) (Walter et al. 2007), and roughness is the root of alpha; Blender
    /// writes Ns = 1000 (1 - roughness)^2.
    fn roughness(&self) -> f32 {
        let matte = self.specular.is_some_and(|c| c.iter().all(|c| *c < 0.01));
        let from_shininess = |n: f32| {
            if self.is_linear {
                1.0 - (n.clamp(0.0, 1000.0) / 1000.0).sqrt()
            } else {
                (2.0 / (n.max(0.0) + 2.0)).powf(0.25)
            }
        };
        let shiny = self.shininess.filter(|_| !matte).map(from_shininess);
        let without = if matte { 1.0 } else { 0.6 };
        self.roughness.or(shiny).unwrap_or(without).clamp(0.0, 1.0)
    }
}

/// Three numbers, or one for a grey.
fn colour(rest: &str) -> Option<[f32; 3]> {
    let mut words =
        rest.split_whitespace().map(|w| w.parse::<f32>().ok().filter(|x| x.is_finite()));
    let red = words.next()??;
    match (words.next(), words.next()) {
        (Some(green), Some(blue)) => Some([red, green?, blue?]),
        _ => Some([red; 3]),
    }
}

/// The last word as a number, for options come before it.
fn number(rest: &str) -> Option<f32> {
    rest.split_whitespace().last()?.parse().ok().filter(|x: &f32| x.is_finite())
}

#[cfg(test)]
mod tests {
    use super::*;
    use chiaro_image::colour::srgb_decode;

    fn material(statements: &[(&str, &str)], is_linear: bool) -> Material {
        let mut entry = Entry { is_linear, ..Entry::default() };
        statements.iter().for_each(|(key, rest)| entry.statement(key, rest));
        entry.material()
    }

    #[test]
    fn colours_are_encoded_but_for_blender() {
        let kd = [("kd", "0.5 0 1")];
        assert_eq!(material(&kd, false).base_colour, [srgb_decode(0.5), 0.0, 1.0, 1.0]);
        assert_eq!(material(&kd, true).base_colour, [0.5, 0.0, 1.0, 1.0]);
        assert_eq!(material(&[("kd", "0.5")], true).base_colour, [0.5, 0.5, 0.5, 1.0]);
        assert_eq!(material(&[("ke", "20 2 -1")], false).emissive, [20.0, 2.0, 0.0]);
        assert_eq!(
            material(&[("kd", "x"), ("kd", "nan 0 0"), ("kd", "")], true).base_colour[0],
            0.6
        );
        let black = [("kd", "0 0 0"), ("map_kd", "a.png")];
        assert_eq!(material(&black, false).base_colour, [1.0; 4]);
    }

    #[test]
    fn opacity_is_said_in_two_ways() {
        let opacity = |statements| material(statements, false).base_colour[3];
        assert_eq!(opacity(&[("tr", "0.25")]), 0.75);
        assert_eq!(opacity(&[("d", "0.75"), ("tr", "0.5")]), 0.75);
        assert_eq!(opacity(&[("tr", "0.5"), ("d", "0.75")]), 0.75);
        assert_eq!(opacity(&[("d", "-halo 0.5")]), 0.5);
        assert_eq!(opacity(&[("tr", "1")]), 1.0);
        assert_eq!(material(&[("d", "0.5")], false).alpha, Alpha::Blend);
    }

    #[test]
    fn shininess_becomes_roughness() {
        let roughness = |statements, blender| material(statements, blender).roughness;
        assert_eq!(roughness(&[("ns", "0")], false), 1.0);
        assert!((roughness(&[("ns", "30")], false) - 0.5).abs() < 1e-6);
        assert!((roughness(&[("ns", "250")], true) - 0.5).abs() < 1e-6);
        assert_eq!(roughness(&[("ns", "900"), ("ks", "0 0 0")], false), 1.0);
        assert_eq!(roughness(&[("pr", "0.2"), ("ns", "5")], false), 0.2);
    }
}
