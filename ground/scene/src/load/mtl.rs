//! OBJ's material libraries.
//!
//! 1. [`entry`]: the statements of one material, and what they mean as a [`Material`].
//! 2. [`map`]: map statements with their options.
//! 3. [`relief`]: heights to normals, for bump maps that hold heights.
//!
//! The format does not say how colours are encoded. Here they are sRGB-encoded, as the programs that
//! show them take them, but linear in files by Blender, which writes them so. Emission is linear
//! radiance. Pictures that are missing leave a warning and middle grey.

mod entry;
mod map;
mod relief;

use super::obj::{Lines, without_comment};
use super::text::text;
use super::{Door, picture};
use crate::{Alpha, Material, MaterialId, Scene, Texture, TextureId, TextureUse, Wrap};
use chiaro_basis::{Error, Result};
use chiaro_image::Plane;
use chiaro_image::colour::srgb_decode;
use entry::Entry;
use map::Map;
use std::collections::{HashMap, HashSet};

/// The materials of all libraries so far, by name.
#[derive(Default)]
pub(super) struct Library {
    /// Holds materials (without the default, which comes before them), textures, what is missing.
    scene: Scene,
    names: HashMap<String, usize>,
    /// Whether each material is in some library.
    defined: Vec<bool>,
    /// Libraries that were asked for.
    asked: HashSet<String>,
    /// Whether one of them was not there.
    lacks_library: bool,
    /// Pictures by folder and name; none for those that are missing.
    pictures: HashMap<String, Option<Texture>>,
    /// Textures made of them, by what they are made of.
    textures: HashMap<String, TextureId>,
}

/// What a texture is made of a picture for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Role {
    /// Colours; without the picture, middle grey.
    Colour,
    /// Emission; nothing without the picture.
    Glow,
    /// Normals, or heights that become normals; nothing without the picture.
    Relief,
}

/// A colour as displayed, sRGB-encoded, as linear light.
pub(super) fn linear(c: [f32; 3]) -> [f32; 3] {
    c.map(|c| srgb_decode(if c.is_finite() { c.clamp(0.0, 1.0) } else { 0.0 }))
}

impl Library {
    /// The material of that name; one not known yet is made, so that parts stay apart.
    pub(super) fn find(&mut self, name: &str) -> MaterialId {
        let next = self.names.len();
        let index = *self.names.entry(name.to_owned()).or_insert(next);
        if index == next {
            self.scene.materials.push(Material { name: name.into(), ..picture::plain() });
            self.defined.push(false);
        }
        // The default comes before them.
        MaterialId::new(index + 1)
    }

    /// Loads the libraries of a `mtllib` statement: one name with spaces, or several names.
    pub(super) fn load(&mut self, names: &str, door: &mut Door) -> Result<()> {
        if !self.asked.insert(names.to_owned()) {
            return Ok(());
        }
        if let Some(bytes) = optional(picture::open_named(names, "", door))? {
            return self.read(&bytes, names, door);
        }
        for name in split_names(names) {
            match picture::open_named(&name, "", door) {
                Ok(bytes) => self.read(&bytes, &name, door)?,
                Err(error @ Error::Input { .. }) => {
                    self.lacks_library = true;
                    let instead = "grey stands in for its materials";
                    picture::is_missing(&mut self.scene, &name, &error, instead);
                }
                Err(error) => return Err(error),
            }
        }
        Ok(())
    }

    fn read(&mut self, bytes: &[u8], path: &str, door: &mut Door) -> Result<()> {
        let path = path.replace('\\', "/");
        let folder =
            path.rsplit_once('/').map_or(String::new(), |(folder, _)| format!("{folder}/"));
        let mut entry = Entry::default();
        let mut current = None;
        let mut is_linear = false;
        for (_, line) in Lines::new(bytes) {
            is_linear |= line.starts_with(b"# Blender");
            let line = without_comment(&line);
            let key = line.split(u8::is_ascii_whitespace).next().unwrap_or_default();
            let rest = text(&line[key.len()..]);
            if key.eq_ignore_ascii_case(b"newmtl") {
                self.define(current, std::mem::take(&mut entry), &folder, door)?;
                current = Some(self.find(&rest));
                entry.is_linear = is_linear;
            } else {
                entry.statement(&text(key).to_ascii_lowercase(), &rest);
            }
        }
        self.define(current, entry, &folder, door)
    }

    /// Gives a material its meaning.
    fn define(
        &mut self,
        id: Option<MaterialId>,
        entry: Entry,
        folder: &str,
        door: &mut Door,
    ) -> Result<()> {
        let Some(index) = id.map(|id| id.index() - 1) else { return Ok(()) };
        let mut material = entry.material();
        material.name = std::mem::take(&mut self.scene.materials[index].name);
        if let Some(map) = &entry.colour_map {
            let mask = entry.opacity_map.as_ref();
            material.base_texture = self.texture(map, mask, Role::Colour, folder, door)?;
            if mask.is_some() {
                material.alpha = Alpha::Mask(0.5);
            }
        }
        if let Some(map) = &entry.glow_map {
            material.emissive_texture = self.texture(map, None, Role::Glow, folder, door)?;
            if material.emissive_texture.is_some() && material.emissive == [0.0; 3] {
                material.emissive = [1.0; 3];
            }
        }
        if let Some(map) = &entry.relief_map {
            material.normal_texture = self.texture(map, None, Role::Relief, folder, door)?;
            material.normal_scale = map.strength;
        }
        self.scene.materials[index] = material;
        self.defined[index] = true;
        Ok(())
    }

    /// The texture of a map, made once for each way to use the picture.
    fn texture(
        &mut self,
        map: &Map,
        mask: Option<&Map>,
        role: Role,
        folder: &str,
        door: &mut Door,
    ) -> Result<Option<TextureUse>> {
        let mask_name = mask.map_or("", |m| m.name.as_str());
        let key = format!("{folder}\0{}\0{mask_name}\0{}\0{role:?}", map.name, map.clamped);
        let texture = match self.textures.get(&key) {
            Some(texture) => Some(*texture),
            None => self.make(map, mask, role, folder, door)?.map(|texture| {
                self.scene.textures.push(texture);
                let id = TextureId::new(self.scene.textures.len() - 1);
                self.textures.insert(key, id);
                id
            }),
        };
        Ok(texture.map(|texture| TextureUse { matrix: map.matrix(), ..TextureUse::plain(texture) }))
    }

    fn make(
        &mut self,
        map: &Map,
        mask: Option<&Map>,
        role: Role,
        folder: &str,
        door: &mut Door,
    ) -> Result<Option<Texture>> {
        let picture = self.picture(&map.name, folder, role, door)?;
        let mut texture = match (picture, role) {
            (Some(picture), _) => picture,
            (None, Role::Colour) => picture::stand_in(&map.name),
            (None, _) => return Ok(None),
        };
        if role == Role::Relief && !map.holds_normals && !relief::is_normal_map(&texture) {
            door.spend("pixels", |b| &mut b.pixels, texture.pixels.len() as u64)?;
            texture.pixels = relief::normals(&texture.pixels).into();
        }
        if let Some(mask) = mask.filter(|m| m.name != map.name)
            && let Some(mask) = self.picture(&mask.name, folder, Role::Glow, door)?
        {
            door.spend("pixels", |b| &mut b.pixels, texture.pixels.len() as u64)?;
            texture.pixels = masked(&texture, &mask).into();
        }
        if map.clamped {
            texture.wrap = [Wrap::Clamp; 2];
        }
        Ok(Some(texture))
    }

    /// A picture, decoded once; none, noted once, when it is missing.
    fn picture(
        &mut self,
        name: &str,
        folder: &str,
        role: Role,
        door: &mut Door,
    ) -> Result<Option<Texture>> {
        let key = format!("{folder}\0{name}");
        if let Some(known) = self.pictures.get(&key) {
            return Ok(known.clone());
        }
        self.scene.stored.textures += 1;
        let bytes = picture::open_named(name, folder, door);
        let picture = match bytes.and_then(|bytes| picture::decode(name, &bytes, door)) {
            Ok(picture) => Some(picture),
            Err(error @ Error::Input { .. }) => {
                let instead = match role {
                    Role::Colour => "middle grey stands in",
                    _ => "the material goes without",
                };
                picture::is_missing(&mut self.scene, name, &error, instead);
                None
            }
            Err(error) => return Err(error),
        };
        self.pictures.insert(key, picture.clone());
        Ok(picture)
    }

    /// A scene with these materials, without the default, and nothing else.
    pub(super) fn finish(mut self) -> Scene {
        self.scene.stored.materials = self.scene.materials.len() as u64;
        let unknown = self.scene.materials.iter().zip(&self.defined).filter(|(_, known)| !**known);
        let names: Vec<&str> = unknown.map(|(m, _)| m.name.as_str()).collect();
        if let Some(first) = names.first().filter(|_| !self.lacks_library) {
            self.scene.warnings.push(format!(
                "{} materials are in no material library, {first:?} among them; grey stands in",
                names.len()
            ));
        }
        self.scene
    }
}

/// The names of a `mtllib` statement: each ends in `.mtl` or at white space that no `\` guards.
fn split_names(names: &str) -> Vec<String> {
    let mut found = Vec::new();
    let mut current = String::new();
    let lower = names.to_ascii_lowercase();
    let has_endings = lower.split(".mtl").count() > 1;
    let mut chars = names.chars().peekable();
    while let Some(c) = chars.next() {
        let ends = !has_endings || current.to_ascii_lowercase().ends_with(".mtl");
        if c == '\\' && chars.peek() == Some(&' ') {
            current.extend(chars.next());
        } else if c.is_whitespace() && (ends || current.is_empty()) {
            found.extend(Some(std::mem::take(&mut current)).filter(|name| !name.is_empty()));
        } else {
            current.push(c);
        }
    }
    found.extend(Some(current).filter(|name| !name.is_empty()));
    found
}

/// Nothing instead of a file that is missing.
fn optional(read: Result<Vec<u8>>) -> Result<Option<Vec<u8>>> {
    match read {
        Ok(bytes) => Ok(Some(bytes)),
        Err(Error::Input { .. }) => Ok(None),
        Err(error) => Err(error),
    }
}

/// The colours of a texture with the opacity of a mask: its alpha if it has any, else how light it
/// is.
fn masked(texture: &Texture, mask: &Texture) -> Plane<[u8; 4]> {
    let has_alpha = mask.pixels.pixels().iter().any(|p| p[3] < 255);
    let (width, height) = texture.pixels.size();
    let from = mask.pixels.size();
    let nearest = |i: usize, to: usize, from: usize| (2 * i + 1) * from / (2 * to);
    Plane::from_fn(width, height, |x, y| {
        let [r, g, b, a] = mask.pixels[(nearest(x, width, from.0), nearest(y, height, from.1))];
        let grey = ((u16::from(r) + u16::from(g) + u16::from(b)) / 3) as u8;
        let [r, g, b, _] = texture.pixels[(x, y)];
        [r, g, b, if has_alpha { a } else { grey }]
    })
}
