//! Wavefront OBJ: polygons with texture coordinates, normals, colours, materials, smoothing groups.
//!
//! 1. [`file`]: statements to lists of positions, corners and faces ([`lines`] joins what `\`
//!    continues).
//! 2. [`part`]: which faces are one object: each `o`; in files without any, each `g`, unless groups
//!    share vertices, for a body's limbs are one body.
//! 3. [`build`]: an object's faces, cut into triangles, with one vertex for each corner that differs.
//!
//! Faces whose corners are not there or not finite are left out with a warning that names the first
//! line. Where a face has no normals, it is smoothed by the smoothing groups of its object, or
//! across edges that bend less than [`CREASE`](crate::normals::CREASE) where it has none. Vertex
//! colours are sRGB-encoded. Not read: points, lines, curves and surfaces.
//!
//! Guaranteed: at most about 200 bytes are held for each byte of the file.

mod build;
mod file;
mod lines;
mod part;

pub(super) use lines::{Lines, without_comment};

use super::{Door, Up, picture};
use crate::{MeshId, Node, Scene};
use build::Builder;
use chiaro_basis::Result;
use file::File;

/// Reads an OBJ file and the material libraries that it names, and says which way is up in it.
pub(super) fn read(bytes: &[u8], door: &mut Door) -> Result<(Scene, Up)> {
    let mut file = File::read(bytes, door)?;
    let faces = file.settle();
    let up = file.up.unwrap_or(Up::Y);
    let mut scene = std::mem::take(&mut file.library).finish();
    scene.materials.insert(0, picture::plain());
    scene.stored.triangles = file.triangles;
    scene.stored.vertices = file.positions.len() as u64;
    scene.warnings.extend(file.warnings(&door.name));
    let mut builder = Builder::new(&file);
    for part in part::parts(&file, faces, &door.name) {
        door.spend("nodes", |b| &mut b.nodes, 1)?;
        let mesh = builder.mesh(part);
        let name = mesh.name.clone();
        let mesh_id = MeshId::new(scene.meshes.len());
        scene.nodes.push(Node { name, mesh: Some(mesh_id), ..Node::default() });
        scene.meshes.push(mesh);
    }
    Ok((scene, up))
}
