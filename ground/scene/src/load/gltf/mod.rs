//! glTF 2.0, as JSON and as `.glb`, to a [`Scene`].
//!
//! 1. [`container`]: the bytes are split into a JSON text and binary data.
//! 2. [`json`]: the text becomes a tree of values, read leniently.
//! 3. [`requirements`]: what the file asks for is checked.
//! 4. [`buffers`], [`accessor`]: bytes, and bounds-checked columns of numbers in them.
//! 5. [`tree`]: the nodes are checked and ordered, parents first.
//! 6. [`texture`], [`material`], [`mesh`] (of [`primitive`]s), [`skin`], [`node`], [`camera`],
//!    [`light`], [`animation`]: each list of the document becomes one of the scene.
//!
//! Guaranteed for any bytes: no panic, no recursion, an end in time proportional to what is read and
//! decoded; at most 64 bytes of memory for each byte of the file and its buffers and 256 MiB, 64
//! pixels for each byte and 2^26, 40 bytes for each byte of JSON. What other programs survive is
//! survived with a note where its meaning is clear; else the error names the place.
//!
//! Not read: points and lines, more than one scene, occlusion, extensions that only refine the looks.

mod accessor;
mod animation;
mod buffers;
mod camera;
mod container;
mod context;
mod influences;
mod json;
mod light;
mod material;
mod mesh;
mod node;
mod primitive;
mod requirements;
mod skin;
mod texture;
mod tree;
mod triangles;

use super::Door;
use crate::{Scene, Stored};
use accessor::Accessors;
use buffers::Buffers;
use chiaro_basis::Result;
use context::Context;
use texture::Textures;
use tree::Tree;

/// Reads a glTF file; buffers and images that it names come through `door`.
///
/// # Errors
/// [`chiaro_basis::Error::Input`] with place and remedy for what cannot be read,
/// [`chiaro_basis::Error::Limit`] for what is over the budget or unpacks to far more than the file.
pub(super) fn read(bytes: &[u8], door: &mut Door) -> Result<Scene> {
    let container = container::split(bytes, door)?;
    let root = json::parse(&container.text, door)?;
    let mut cx = Context::new(door);
    cx.has_read(bytes.len());
    let extensions_used = requirements::check(&root, &mut cx)?;
    let buffers = Buffers::read(&root, container.binary, &mut cx)?;
    let accessors = Accessors::new(&root, &buffers);
    let tree = Tree::read(&root, &mut cx)?;
    let mut stored = Stored {
        textures: root.list("textures").len() as u64,
        materials: root.list("materials").len() as u64,
        extensions_used,
        ..Stored::default()
    };
    let mut textures = Textures::new(&root, &accessors, bytes.len() as u64);
    let materials = material::read(&root, &mut textures, &mut cx)?;
    let textures = textures.finish(&mut cx)?;
    let skins = skin::read(&root, &tree, &accessors, &mut cx)?;
    let usage = node::usage(&root, &tree, &skins, &cx)?;
    let meshes = mesh::read(&root, &accessors, &materials, &usage, &mut stored, &mut cx)?;
    let mut nodes = node::read(&root, &tree, &meshes, &skins, &accessors, &mut cx)?;
    if !nodes.iter().any(|n| n.mesh.is_some()) {
        let why = "no geometry is left: its scene draws no triangles; export meshes";
        return Err(cx.door.error("", why));
    }
    let clips = animation::read(&root, &tree, &accessors, &mut nodes, &mut cx)?;
    let cameras = camera::read(&root, &tree, &mut cx);
    let lights = light::read(&root, &tree, &mut cx);
    let (warnings, missing_files) = cx.into_warnings();
    stored.missing_files = missing_files;
    Ok(Scene {
        meshes,
        materials,
        textures,
        nodes,
        skins,
        cameras,
        lights,
        clips,
        stored,
        warnings,
    })
}
