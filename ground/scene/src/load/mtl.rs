//! OBJ's material libraries.
//!
//! Colours are taken as displayed (sRGB-encoded), as the programs that write them show them.
//! Shininess becomes roughness by sqrt(2 / (Ns + 2)), the width of the lobe.

use super::Door;
use super::picture;
use crate::{Alpha, Material, MaterialId, Scene, Stored, Texture, TextureId, TextureUse};
use chiaro_basis::Result;
use chiaro_image::colour::srgb_decode;

/// The materials of all libraries so far; the first is the default.
pub(super) struct Library {
    materials: Vec<Material>,
    textures: Vec<Texture>,
    missing: Vec<String>,
    warnings: Vec<String>,
}

/// An sRGB-encoded colour as linear light.
pub(super) fn linear(c: [f32; 3]) -> [f32; 3] {
    c.map(|c| srgb_decode(if c.is_finite() { c.clamp(0.0, 1.0) } else { 0.0 }))
}

impl Library {
    pub(super) fn new() -> Self {
        let grey =
            Material { base_colour: [0.6, 0.6, 0.6, 1.0], roughness: 0.6, ..Material::default() };
        Self {
            materials: vec![grey],
            textures: Vec::new(),
            missing: Vec::new(),
            warnings: Vec::new(),
        }
    }

    /// The material of that name; one not known yet is made, so that parts stay apart.
    pub(super) fn find(&mut self, name: &str) -> MaterialId {
        let known = self.materials.iter().skip(1).position(|m| m.name == name);
        MaterialId::new(known.map_or_else(
            || {
                self.materials.push(Material { name: name.into(), ..self.materials[0].clone() });
                self.materials.len() - 1
            },
            |i| i + 1,
        ))
    }

    /// Loads the libraries of a `mtllib` line: one name with spaces, or several names.
    pub(super) fn load(&mut self, names: &str, door: &mut Door) -> Result<()> {
        match door.open(names) {
            Ok(bytes) => return self.read(&bytes, door),
            Err(e @ chiaro_basis::Error::Limit { .. }) => return Err(e),
            Err(_) => {}
        }
        for name in names.split_whitespace() {
            match door.open(name) {
                Ok(bytes) => self.read(&bytes, door)?,
                Err(e @ chiaro_basis::Error::Limit { .. }) => return Err(e),
                Err(_) => self.is_missing(name, "grey stands in for its materials"),
            }
        }
        Ok(())
    }

    fn is_missing(&mut self, name: &str, instead: &str) {
        if !self.missing.iter().any(|m| m == name) {
            self.missing.push(name.into());
            self.warnings.push(format!("{name}: not found beside the scene; {instead}"));
        }
    }

    fn read(&mut self, bytes: &[u8], door: &mut Door) -> Result<()> {
        let text = String::from_utf8_lossy(bytes);
        let mut current = 0;
        for line in text.lines() {
            let line = line.split('#').next().unwrap_or_default().trim();
            let (key, rest) = line.split_once(char::is_whitespace).unwrap_or((line, ""));
            let rest = rest.trim();
            if key.eq_ignore_ascii_case("newmtl") {
                current = self.find(rest).index();
                let name = self.materials[current].name.clone();
                self.materials[current] = Material { name, roughness: 0.6, ..Material::default() };
            } else if current > 0 {
                self.property(current, &key.to_ascii_lowercase(), rest, door)?;
            }
        }
        Ok(())
    }

    fn property(&mut self, i: usize, key: &str, rest: &str, door: &mut Door) -> Result<()> {
        let mut n = [f32::NAN; 3];
        for (slot, word) in n.iter_mut().zip(rest.split_whitespace()) {
            *slot = word.parse().unwrap_or(f32::NAN);
        }
        // One number is a grey.
        let rgb = if n[1].is_nan() { [n[0]; 3] } else { n };
        let used = match key {
            "map_kd" | "map_ke" | "map_bump" | "bump" | "norm" => self.texture(rest, door)?,
            _ => None,
        };
        let m = &mut self.materials[i];
        match key {
            "kd" if n[0].is_finite() => {
                let [r, g, b] = linear(rgb);
                m.base_colour = [r, g, b, m.base_colour[3]];
            }
            "ke" if n[0].is_finite() => m.emissive = rgb.map(|c| c.max(0.0)),
            "ns" if n[0] >= 0.0 => m.roughness = (2.0 / (n[0] + 2.0)).powf(0.25).clamp(0.05, 1.0),
            "pr" if n[0].is_finite() => m.roughness = n[0].clamp(0.0, 1.0),
            "pm" if n[0].is_finite() => m.metallic = n[0].clamp(0.0, 1.0),
            "d" if n[0].is_finite() => set_opacity(m, n[0]),
            "tr" if n[0].is_finite() => set_opacity(m, 1.0 - n[0]),
            "map_kd" => {
                m.base_texture = used.map(TextureUse::plain);
                // A black Kd beside a map is an exporter's slip in many files.
                if used.is_some() && m.base_colour[..3] == [0.0; 3] {
                    m.base_colour = [1.0, 1.0, 1.0, m.base_colour[3]];
                }
            }
            "map_ke" => m.emissive_texture = used.map(TextureUse::plain),
            "norm" => m.normal_texture = used.map(TextureUse::plain),
            // A height map bends no normals here; a normal map under this key is blue.
            "map_bump" | "bump" => {
                let is_normal_map =
                    |t: TextureId| picture::is_normal_map(&self.textures[t.index()]);
                m.normal_texture = used.filter(|t| is_normal_map(*t)).map(TextureUse::plain);
            }
            _ => {}
        }
        Ok(())
    }

    /// The texture of a map line, options skipped; `None` with a warning when it is missing.
    fn texture(&mut self, line: &str, door: &mut Door) -> Result<Option<TextureId>> {
        let name = file_name(line).replace('\\', "/");
        if let Some(i) = self.textures.iter().position(|t| t.name == name) {
            return Ok(Some(TextureId::new(i)));
        }
        match picture::open(&name, door)? {
            Some(texture) => {
                self.textures.push(texture);
                Ok(Some(TextureId::new(self.textures.len() - 1)))
            }
            None => {
                self.is_missing(&name, "the plain colour stands in");
                Ok(None)
            }
        }
    }

    /// A scene with these materials and nothing else.
    pub(super) fn scene(&mut self) -> Scene {
        let stored = Stored {
            materials: self.materials.len() as u64 - 1,
            textures: self.textures.len() as u64,
            missing_files: std::mem::take(&mut self.missing),
            ..Stored::default()
        };
        Scene {
            materials: std::mem::take(&mut self.materials),
            textures: std::mem::take(&mut self.textures),
            warnings: std::mem::take(&mut self.warnings),
            stored,
            ..Scene::default()
        }
    }
}

fn set_opacity(m: &mut Material, opacity: f32) {
    m.base_colour[3] = opacity.clamp(0.0, 1.0);
    if opacity < 1.0 {
        m.alpha = Alpha::Blend;
    }
}

/// The file of a map line: what follows the options, each of which takes as many words as it has.
fn file_name(line: &str) -> String {
    let mut words = line.split_whitespace().peekable();
    while let Some(option) = words.peek().filter(|w| w.starts_with('-')) {
        let most = match *option {
            "-o" | "-s" | "-t" => 3,
            "-mm" => 2,
            _ => 1,
        };
        let is_number_list = most > 1;
        words.next();
        for _ in 0..most {
            let number = words.peek().is_some_and(|w| w.parse::<f32>().is_ok());
            if is_number_list && !number {
                break;
            }
            words.next();
        }
    }
    words.collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn map_lines_end_in_a_file_name() {
        assert_eq!(file_name("-o 0 0 -s 2 2 2 -bm 0.3 wood floor.png"), "wood floor.png");
        assert_eq!(file_name("-clamp on a.png"), "a.png");
        assert_eq!(file_name("a.png"), "a.png");
    }
}
