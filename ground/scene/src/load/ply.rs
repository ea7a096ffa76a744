//! Stanford PLY: ascii and binary, polygons and strips, normals, colours, texture coordinates.
//!
//! Properties may come in any order and of any type; unknown ones are passed over. Whole-number
//! colours are sRGB-encoded, fractions linear. Texture coordinates come with the vertices or with
//! the faces' corners, and a `comment TextureFile` names the picture, as MeshLab writes it. Where
//! normals are missing, faces are smoothed across edges that bend less than
//! [`CREASE`](crate::normals::CREASE). A comment that says which axis is up is believed. A file without
//! faces is a cloud of points, drawn as discs.
//!
//! Guaranteed: the header's counts are checked against the file's size before memory is asked for;
//! at most about 100 bytes are held for each byte of the file.

mod faces;
mod header;
mod values;
mod vertices;

use super::text::stem;
use super::{Door, Up, picture, prune};
use crate::cloud::{Points, discs};
use crate::{MaterialId, Mesh, MeshId, Node, NormalSource, Scene, normals};
use chiaro_basis::Result;
use chiaro_basis::math::Vec2;
use faces::Faces;
use header::Header;
use std::collections::HashMap;
use values::Values;
use vertices::Vertices;

/// Reads a PLY file, and says which way is up in it.
pub(super) fn read(bytes: &[u8], door: &mut Door) -> Result<(Scene, Up)> {
    let header = Header::read(bytes).map_err(|(line, why)| {
        let place = if line > 0 { format!("line {line}") } else { String::new() };
        door.error(place, format!("{why}; export the file again"))
    })?;
    let (vertices, faces) = tables(&header, &bytes[header.bytes..], door)?;
    let up = header.comments.iter().find_map(|c| Up::said(c)).unwrap_or(Up::Y);
    if faces.stored == 0 && faces.triangles.is_empty() {
        return Ok((cloud(vertices, door)?, up));
    }
    if vertices.positions.is_empty() || faces.triangles.is_empty() {
        return Err(door.error("", "there are no triangles; export the mesh again"));
    }
    Ok((scene(&header, vertices, faces, door)?, up))
}

/// The rows that count.
fn tables(header: &Header, rows: &[u8], door: &mut Door) -> Result<(Vertices, Faces)> {
    let mut values = Values::new(rows, header.encoding);
    let (mut vertices, mut faces) = (Vertices::default(), Faces::default());
    // Rows without a column take no bytes, however many there are said to be.
    for element in header.elements.iter().filter(|e| !e.properties.is_empty()) {
        let name = element.name.as_str();
        let read = match name {
            "vertex" => {
                let has = |name| element.properties.iter().any(|p| p.name == name);
                if !(has("x") && has("y") && has("z")) {
                    return Err(
                        door.error("header", "vertices have no x, y and z; export it again")
                    );
                }
                door.spend("vertices", |b| &mut b.vertices, element.rows)?;
                Vertices::read(element, &mut values).map(|read| vertices = read)
            }
            "face" => faces.polygons(element, &mut values, &vertices.positions),
            "tristrips" => faces.strips(element, &mut values, vertices.positions.len()),
            _ => (1..=element.rows)
                .try_for_each(|row| element.row(&mut values, |_, _| {}).ok_or(row)),
        };
        read.map_err(|row| {
            let place = format!("{name} {row} of {}", element.rows);
            door.error(
                place,
                "the row is not whole: the file is cut off or broken; export it again",
            )
        })?;
    }
    door.spend("triangles", |b| &mut b.triangles, faces.stored)?;
    Ok((vertices, faces))
}

fn scene(header: &Header, vertices: Vertices, faces: Faces, door: &mut Door) -> Result<Scene> {
    let mut scene = Scene::default();
    scene.stored.vertices = vertices.positions.len() as u64;
    scene.stored.triangles = faces.stored;
    let what = "faces have no three corners that are there, and are left out";
    scene.warnings.extend(faces.skipped.warn(&door.name, what, "row"));
    let mut mesh = mesh(vertices, faces);
    mesh.name = stem(&door.name).into();
    scene.warnings.extend(prune::warning(prune::prune(&mut mesh), &door.name));
    normals::finish(&mut mesh, &[]);
    let picture = header.comments.iter().find_map(|c| c.strip_prefix("TextureFile "));
    let picture = picture.filter(|_| !mesh.uvs.is_empty());
    picture::cover(&mut scene, !mesh.colours.is_empty(), picture, door)?;
    let name = mesh.name.clone();
    scene.nodes.push(Node { name, mesh: Some(MeshId::new(0)), ..Node::default() });
    scene.meshes.push(mesh);
    Ok(scene)
}

/// The discs of a file that has points alone.
fn cloud(vertices: Vertices, door: &mut Door) -> Result<Scene> {
    let count = vertices.positions.len() as u64;
    door.spend("triangles", |b| &mut b.triangles, Mesh::DISC as u64 * count)?;
    let Vertices { positions, normals, colours, .. } = vertices;
    let (mut mesh, estimated) = discs(Points { positions, normals, colours });
    if mesh.triangles.is_empty() {
        let why = "there are no triangles, and fewer than three points; export it again";
        return Err(door.error("", why));
    }
    let mut scene = Scene::default();
    scene.stored.vertices = count;
    let own = if estimated { "; their normals are estimated" } else { "" };
    scene.warnings.push(format!(
        "{}: {} points without triangles: each is drawn as a disc of the surface around it{own}",
        door.name,
        mesh.discs.len()
    ));
    mesh.name = stem(&door.name).into();
    picture::cover(&mut scene, !mesh.colours.is_empty(), None, door)?;
    // Estimated normals do not know which side is out.
    scene.materials.iter_mut().for_each(|m| m.double_sided = estimated);
    let name = mesh.name.clone();
    scene.nodes.push(Node { name, mesh: Some(MeshId::new(0)), ..Node::default() });
    scene.meshes.push(mesh);
    Ok(scene)
}

/// The mesh with everything the file says, its normals as they are.
fn mesh(vertices: Vertices, faces: Faces) -> Mesh {
    let triangles = faces.triangles.len();
    let mut mesh = Mesh {
        positions: vertices.positions,
        normals: NormalSource::Given(vertices.normals),
        colours: vertices.colours,
        materials: vec![MaterialId::new(0); triangles],
        triangles: faces.triangles,
        ..Mesh::default()
    };
    if (faces.faces as usize) < triangles {
        mesh.polygons = faces.polygons;
    }
    if !faces.uvs.is_empty() {
        part_corners(&mut mesh, &faces.uvs);
    } else if !vertices.uvs.is_empty() {
        mesh.uvs = vec![vertices.uvs];
    }
    mesh
}

/// Splits vertices whose corners have different texture coordinates.
fn part_corners(mesh: &mut Mesh, uvs: &[[Vec2; 3]]) {
    let mut vertices: HashMap<(u32, [u32; 2]), u32> = HashMap::new();
    let (mut source, mut coordinates) = (Vec::new(), Vec::new());
    for (triangle, uvs) in mesh.triangles.iter_mut().zip(uvs) {
        for (v, uv) in triangle.iter_mut().zip(uvs) {
            *v = *vertices.entry((*v, uv.to_array().map(f32::to_bits))).or_insert_with(|| {
                source.push(*v);
                coordinates.push(*uv);
                source.len() as u32 - 1
            });
        }
    }
    mesh.pick(&source);
    mesh.uvs = vec![coordinates];
}

#[cfg(test)]
mod tests {
    use super::super::Budget;
    use super::*;
    use chiaro_basis::math::{Vec3, vec2};

    fn read_bytes(bytes: &[u8]) -> Result<(Scene, Up)> {
        read(bytes, &mut Door::new("a/quad.ply", &(), Budget::default()))
    }

    const QUAD: &str = "ply\nformat ascii 1.0\ncomment made by hand, z up\nelement vertex 5\n\
        property uchar red\nproperty uchar green\nproperty uchar blue\nproperty double z\n\
        property float y\nproperty int x\nproperty list uchar float weights\n\
        element edge 1\nproperty int a\nelement face 3\nproperty uchar flags\n\
        property list uchar int vertex_indices\nend_header\n\
        255 0 0 0 0 0 0\n255 0 0 0 0 1 2 0.5 0.5\n255 0 0 0 1 1 0\n255 0 0 0 1 0 0\n\
        0 0 0 nan 5 5 0\n7\n1 4 0 1 2 3\n1 3 0 1 9\n1 3 0 1 4";

    #[test]
    fn text_with_properties_in_any_order() {
        let (scene, up) = read_bytes(QUAD.as_bytes()).unwrap();
        let mesh = &scene.meshes[0];
        assert_eq!(mesh.positions, [Vec3::ZERO, Vec3::X, Vec3::new(1.0, 1.0, 0.0), Vec3::Y]);
        assert_eq!((mesh.triangles.len(), mesh.polygons.as_slice()), (2, &[0, 0][..]));
        assert_eq!(mesh.colours[0].to_array(), [1.0, 0.0, 0.0, 1.0]);
        assert_eq!((scene.stored.vertices, scene.stored.triangles), (5, 4));
        assert_eq!((up, scene.warnings.len(), mesh.name.as_str()), (Up::Z, 2, "quad"));
    }

    /// A triangle in binary, with the given byte order.
    fn binary(big: bool) -> Vec<u8> {
        let order = if big { "big" } else { "little" };
        let mut bytes = format!(
            "ply\r\nformat binary_{order}_endian 1.0\r\nelement vertex 3\r\nproperty float x\r\n\
             property float y\r\nproperty float z\r\nproperty float nx\r\nproperty float ny\r\n\
             property float nz\r\nelement tristrips 1\r\nproperty list int int vertex_indices\r\n\
             end_header\r\n"
        )
        .into_bytes();
        for p in [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0f32]] {
            for x in p.into_iter().chain([0.0, 0.0, 2.0]) {
                bytes.extend(if big { x.to_be_bytes() } else { x.to_le_bytes() });
            }
        }
        for i in [7, 0, 1, 2, -1, 0, 2, 1i32] {
            bytes.extend(if big { i.to_be_bytes() } else { i.to_le_bytes() });
        }
        bytes
    }

    #[test]
    fn both_byte_orders_and_strips() {
        for big in [false, true] {
            let (scene, up) = read_bytes(&binary(big)).unwrap();
            let mesh = &scene.meshes[0];
            assert_eq!(mesh.triangles, [[0, 1, 2], [0, 2, 1]]);
            assert_eq!(mesh.positions, [Vec3::ZERO, Vec3::X, Vec3::Y]);
            assert!(matches!(&mesh.normals, NormalSource::Given(n) if n[..] == [Vec3::Z; 3]));
            assert_eq!(up, Up::Y);
        }
    }

    #[test]
    fn texture_coordinates_of_corners_part_vertices() {
        let file = "ply\nformat ascii 1.0\ncomment TextureFile gone.png\nelement vertex 4\n\
            property float x\nproperty float y\nproperty float z\nelement face 2\n\
            property list uchar int vertex_indices\nproperty list uchar float texcoord\n\
            end_header\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n3 0 1 2 6 0 0 1 0 1 1\n3 0 2 3 6 0 0 .5 1 0 1\n";
        let (scene, _) = read_bytes(file.as_bytes()).unwrap();
        let mesh = &scene.meshes[0];
        assert_eq!(mesh.positions.len(), 5);
        assert_eq!(mesh.uvs[0][0], vec2(0.0, 1.0));
        assert_eq!(scene.stored.missing_files, ["gone.png"]);
        assert!(scene.materials[0].base_texture.is_some());
    }

    #[test]
    fn headers_that_lie_are_refused_before_memory_is_asked_for() {
        let lies = [
            ("element vertex 400000000\nproperty float x\n", "do not fit"),
            ("element vertex 18446744073709551615\nproperty float x\n", "do not fit"),
            ("element nothing 18446744073709551615\n", "fewer than three points"),
            ("element vertex -1\n", "element"),
            ("property float x\n", "before any"),
            ("element vertex 1\nproperty list float x\n", "no property"),
            ("element vertex 0\nproperty float x\n", "no x, y and z"),
            ("property", "property"),
            ("what", "belongs"),
        ];
        for (lie, why) in lies {
            let file = format!("ply\nformat ascii 1.0\n{lie}\nend_header\n");
            let error = read_bytes(file.as_bytes()).unwrap_err().to_string();
            assert!(error.contains(why), "{lie}: {error}");
        }
        assert!(read_bytes(b"ply").is_err());
    }

    #[test]
    fn a_file_cut_off_anywhere_is_an_error() {
        let bytes = binary(false);
        assert!((3..bytes.len()).all(|n| read_bytes(&bytes[..n]).is_err()));
    }
}
