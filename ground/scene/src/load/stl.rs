//! STL: loose triangles, in text or in binary, z up.
//!
//! Corners at exactly the same place become one vertex, and faces are smoothed across edges that
//! bend less than [`CREASE`](crate::normals::CREASE); the file's own normals, one a face, say no
//! more than the corners do. In text each `solid` is a mesh.
//!
//! Guaranteed: at most about 100 bytes are held for each byte of the file. Colours in the spare
//! bytes of binary files are not read: there are two contradicting conventions.

use super::text::{Tally, number, stem, text};
use super::{Door, picture, prune};
use crate::{MaterialId, Mesh, MeshId, Node, Scene, normals};
use chiaro_basis::Result;
use chiaro_basis::math::Vec3;

/// Bytes before the triangles of a binary file: 80 of anything, and their number.
const HEADER: usize = 84;
/// Bytes of a triangle: its normal, its corners, two spare bytes.
const TRIANGLE: usize = 50;

/// Corners three by three.
struct Solid {
    name: String,
    corners: Vec<Vec3>,
}

/// Reads an STL file.
pub(super) fn read(bytes: &[u8], door: &mut Door) -> Result<Scene> {
    let mut broken = Tally::default();
    let solids = match binary_count(bytes) {
        Some(count) => vec![binary(bytes, count, stem(&door.name))],
        None if is_text(bytes) => ascii(bytes, &mut broken),
        None => return Err(door.error("", cut_off(bytes))),
    };
    let mut scene = Scene::default();
    scene.warnings.extend(broken.warn(
        &door.name,
        "facets have no three corners, and are left out",
        "line",
    ));
    let mut gone = 0;
    for solid in solids {
        let triangles = solid.corners.len() as u64 / 3;
        door.spend("triangles", |b| &mut b.triangles, triangles)?;
        door.spend("vertices", |b| &mut b.vertices, 3 * triangles)?;
        door.spend("nodes", |b| &mut b.nodes, 1)?;
        scene.stored.triangles += triangles;
        scene.stored.vertices += 3 * triangles;
        let mut mesh = welded(solid);
        gone += prune::prune(&mut mesh);
        if mesh.triangles.is_empty() {
            continue;
        }
        normals::finish(&mut mesh, &[]);
        let node = Node {
            name: mesh.name.clone(),
            mesh: Some(MeshId::new(scene.meshes.len())),
            ..Node::default()
        };
        scene.nodes.push(node);
        scene.meshes.push(mesh);
    }
    scene.warnings.extend(prune::warning(gone, &door.name));
    picture::cover(&mut scene, false, None, door)?;
    Ok(scene)
}

/// The number of triangles, if the file is as long as a binary file with that many must be. Many
/// binary files begin with "solid" like text, so the length decides.
fn binary_count(bytes: &[u8]) -> Option<usize> {
    let count = said_count(bytes)?;
    let whole = count.checked_mul(TRIANGLE)?.checked_add(HEADER)?;
    // Some writers pad the end; text that happens to be longer than it says is still text.
    let fits = bytes.len() == whole || bytes.len() > whole && count > 0 && !is_text(bytes);
    fits.then_some(count)
}

fn said_count(bytes: &[u8]) -> Option<usize> {
    let count = bytes.get(HEADER - 4..HEADER)?.try_into().ok()?;
    usize::try_from(u32::from_le_bytes(count)).ok()
}

fn is_text(bytes: &[u8]) -> bool {
    let start = &bytes[..bytes.len().min(1024)];
    let lower = start.trim_ascii_start().to_ascii_lowercase();
    // Exporters put binary headers of that word too, but with a zero byte or without facets.
    lower.starts_with(b"solid")
        && !lower.contains(&0)
        && (lower.windows(5).any(|w| w == b"facet") || lower.windows(8).any(|w| w == b"endsolid"))
}

fn cut_off(bytes: &[u8]) -> String {
    match said_count(bytes) {
        Some(count) => format!(
            "is neither text nor whole: its header says {count} triangles, but there are bytes for \
             {}; the file is cut off, export it again",
            (bytes.len() - HEADER) / TRIANGLE
        ),
        None => "is no STL file: it has no solid and no header; export it again".into(),
    }
}

fn binary(bytes: &[u8], count: usize, name: &str) -> Solid {
    let triangles = bytes[HEADER..].chunks_exact(TRIANGLE).take(count);
    let float = |b: &[u8]| f32::from_le_bytes([b[0], b[1], b[2], b[3]]);
    let corner = |b: &[u8]| Vec3::new(float(b), float(&b[4..]), float(&b[8..]));
    let corners = triangles.flat_map(|t| t[12..48].chunks_exact(12)).map(corner).collect();
    Solid { name: name.into(), corners }
}

/// The solids of a text file. Only `solid`, `vertex` and `endfacet` matter; a facet with more than
/// three corners is a fan.
fn ascii(bytes: &[u8], broken: &mut Tally) -> Vec<Solid> {
    let mut solids: Vec<Solid> = Vec::new();
    let mut facet: Vec<Vec3> = Vec::new();
    for (i, line) in bytes.split(|b| *b == b'\n' || *b == b'\r').enumerate() {
        let line = line.trim_ascii();
        let key = line.split(u8::is_ascii_whitespace).next().unwrap_or_default();
        let rest = &line[key.len()..];
        match key.to_ascii_lowercase().as_slice() {
            b"solid" => solids.push(Solid { name: text(rest), corners: Vec::new() }),
            b"vertex" => facet.push(Vec3::from(numbers(rest))),
            b"endfacet" => {
                if facet.len() < 3 {
                    broken.note(i as u64 + 1);
                } else if let Some(solid) = solids.last_mut() {
                    let fans = (2..facet.len()).flat_map(|i| [facet[0], facet[i - 1], facet[i]]);
                    solid.corners.extend(fans);
                }
                facet.clear();
            }
            _ => {}
        }
    }
    solids
}

fn numbers(rest: &[u8]) -> [f32; 3] {
    let mut words = super::text::words(rest);
    std::array::from_fn(|_| words.next().map_or(f32::NAN, number))
}

/// A mesh in which corners at one place are one vertex.
fn welded(solid: Solid) -> Mesh {
    let places = normals::places(&solid.corners);
    let triangles: Vec<[u32; 3]> = places.chunks_exact(3).map(|t| [t[0], t[1], t[2]]).collect();
    Mesh {
        name: solid.name,
        materials: vec![MaterialId::new(0); triangles.len()],
        positions: solid.corners,
        triangles,
        ..Mesh::default()
    }
}

#[cfg(test)]
mod tests {
    use super::super::Budget;
    use super::*;

    const TEXT: &str = "solid a part\r\n facet normal 0 0 1\r\n outer loop\r\n vertex 0 0 0\r\n \
        VERTEX 1 0 0\r\n vertex 0 1 0\r\n endloop\r\n endfacet\r\nendsolid\r\nsolid b\nfacet \
        normal 0 0 0\nouter loop\nvertex 0 0 1\nvertex 1 0 1\nvertex 1 1 1\nvertex 0 1 1\nendloop\n\
        endfacet\nfacet\nvertex 1 2 3\nendfacet\nendsolid b";

    fn read_bytes(bytes: &[u8]) -> Result<Scene> {
        read(bytes, &mut Door::new("dir/part.stl", &(), Budget::default()))
    }

    fn binary_file(head: &[u8], triangles: &[[f32; 9]]) -> Vec<u8> {
        let mut bytes = head.to_vec();
        bytes.resize(80, b' ');
        bytes.extend((triangles.len() as u32).to_le_bytes());
        for t in triangles {
            bytes.extend([0; 12]);
            t.iter().for_each(|x| bytes.extend(x.to_le_bytes()));
            bytes.extend([0; 2]);
        }
        bytes
    }

    const TWO: [[f32; 9]; 2] = [
        [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0],
        [1.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 1.0, 0.0],
    ];

    #[test]
    fn text_has_a_mesh_for_each_solid() {
        let scene = read_bytes(TEXT.as_bytes()).unwrap();
        let names: Vec<&str> = scene.meshes.iter().map(|m| m.name.as_str()).collect();
        assert_eq!(names, ["a part", "b"]);
        assert_eq!(scene.meshes[1].triangles, [[0, 1, 2], [0, 2, 3]]);
        assert_eq!((scene.stored.triangles, scene.stored.vertices), (3, 9));
        assert!(scene.warnings[0].contains("1 facets"), "{:?}", scene.warnings);
    }

    #[test]
    fn binary_files_may_begin_like_text() {
        for head in [&b"solid facet endsolid"[..], b"COLOR=", b"solid x\0"] {
            let bytes = binary_file(head, &TWO);
            let scene = read_bytes(&bytes).unwrap();
            assert_eq!(scene.meshes[0].positions.len(), 4);
            assert_eq!(scene.nodes[0].name, "part");
        }
        let mut padded = binary_file(b"x", &TWO);
        padded.push(0);
        assert_eq!(read_bytes(&padded).unwrap().stored.triangles, 2);
    }

    #[test]
    fn what_is_cut_off_is_said() {
        let bytes = binary_file(b"solid", &TWO);
        let error = read_bytes(&bytes[..bytes.len() - 1]).unwrap_err().to_string();
        assert!(error.contains("2 triangles") && error.contains("for 1"), "{error}");
        assert!(read_bytes(b"solid").is_err());
    }
}
