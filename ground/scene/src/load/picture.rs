//! Pictures that scenes name, decoded within the budget, and what stands in for missing ones.

use super::Door;
use crate::{Filter, Material, Scene, Texture, TextureId, TextureUse, Wrap};
use chiaro_basis::{Error, Result};
use chiaro_image::Plane;
use chiaro_image::codec::{Limits, read_picture};
use std::sync::Arc;

/// The picture in some bytes. [`Error::Limit`] over the budget, [`Error::Input`] when they hold no
/// picture that is read.
pub(super) fn decode(name: &str, bytes: &[u8], door: &mut Door) -> Result<Texture> {
    let limits = Limits { pixels: door.left.pixels, ..Limits::default() };
    let pixels = read_picture(bytes, name, &limits)?;
    door.spend("pixels", |b| &mut b.pixels, pixels.len() as u64)?;
    Ok(texture(name, pixels))
}

/// A texture that repeats and is filtered.
pub(super) fn texture(name: &str, pixels: Plane<[u8; 4]>) -> Texture {
    let name = name.to_owned();
    Texture { name, pixels: Arc::new(pixels), wrap: [Wrap::Repeat; 2], filter: Filter::Linear }
}

/// What stands in for a picture: one texel of middle grey, half the light of white.
pub(super) fn stand_in(name: &str) -> Texture {
    texture(name, Plane::filled(1, 1, [188, 188, 188, 255]))
}

/// The file called `name` in a format without URIs, beside the scene. Names may have backslashes
/// and lead to folders of another machine: it is looked for in `folder` (where the file that names
/// it is, with a slash at its end), then in the scene's folder, then there by its bare name.
pub(super) fn open_named(name: &str, folder: &str, door: &mut Door) -> Result<Vec<u8>> {
    // These names are no URIs: their percent signs are their own.
    let name = name.trim().replace('\\', "/").replace('%', "%25");
    let bare = name.rsplit('/').next().unwrap_or_default();
    let mut tried: Vec<String> = Vec::new();
    let mut first = None;
    for path in [format!("{folder}{name}"), name.clone(), bare.to_owned()] {
        if tried.contains(&path) {
            continue;
        }
        match door.open(&path) {
            Err(error @ Error::Input { .. }) => first.get_or_insert(error),
            other => return other,
        };
        tried.push(path);
    }
    Err(first.expect("at least one path is tried"))
}

/// Notes in the scene that a file is missing or cannot be read, and what is done instead.
pub(super) fn is_missing(scene: &mut Scene, name: &str, error: &Error, instead: &str) {
    scene.stored.missing_files.push(name.to_owned());
    scene.warnings.push(format!("{error}; {instead}"));
}

/// What covers a mesh whose file has no materials: grey, or the colours of its vertices, or the
/// picture that its file names.
pub(super) fn cover(
    scene: &mut Scene,
    coloured: bool,
    picture: Option<&str>,
    door: &mut Door,
) -> Result<()> {
    let mut material = plain();
    if coloured || picture.is_some() {
        material.base_colour = [1.0; 4];
    }
    if let Some(name) = picture {
        let bytes = open_named(name, "", door);
        let texture = match bytes.and_then(|bytes| decode(name, &bytes, door)) {
            Err(error @ Error::Input { .. }) => {
                is_missing(scene, name, &error, "middle grey stands in");
                stand_in(name)
            }
            other => other?,
        };
        scene.stored.textures += 1;
        scene.textures.push(texture);
        material.base_texture = Some(TextureUse::plain(TextureId::new(0)));
    }
    scene.materials.push(material);
    Ok(())
}

/// The material of what has none: a grey that shows form well.
pub(super) fn plain() -> Material {
    Material { base_colour: [0.6, 0.6, 0.6, 1.0], roughness: 0.6, ..Material::default() }
}

#[cfg(test)]
mod tests {
    use super::super::{Budget, Source};
    use super::*;

    struct Shelf;

    impl Source for Shelf {
        fn read(&self, path: &str, _: u64) -> Result<Vec<u8>> {
            let there = ["a.png", "maps/b.png", "50% grey.png"].contains(&path);
            there.then(|| path.into()).ok_or_else(|| Error::input(path, "", "not found"))
        }
    }

    #[test]
    fn files_are_found_by_names_of_other_machines() {
        let find = |name: &str| {
            let mut door = Door::new("x.obj", &Shelf, Budget::default());
            open_named(name, "maps/", &mut door).map(|bytes| String::from_utf8(bytes).unwrap())
        };
        assert_eq!(find("b.png").unwrap(), "maps/b.png");
        assert_eq!(find("..\\a.png").unwrap(), "a.png");
        assert_eq!(find("C:\\Users\\me\\a.png ").unwrap(), "a.png");
        assert_eq!(find("50% grey.png").unwrap(), "50% grey.png");
        assert!(find("c.png").is_err() && find("").is_err());
    }
}
