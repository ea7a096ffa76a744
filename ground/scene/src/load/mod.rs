//! Readers: untrusted bytes to a [`Scene`].
//!
//! [`read_scene`] picks the reader by the file's first bytes and its ending, turns the scene so that
//! y is up, and refuses what has no geometry. Past it no format matters any more.
//!
//! Guaranteed for any bytes: no panic, no endless work, no file outside the scene's folder, memory
//! of at most some hundred times the bytes read (pictures: within the [`Budget`]).

mod door;
mod gltf;
mod mtl;
mod obj;
mod picture;
mod ply;
mod polygon;
mod prune;
mod stl;
mod text;
mod up;

pub use door::{Budget, Door, Source};
pub use up::Up;

use crate::{Mesh, Scene};
use chiaro_basis::{Error, Result};

/// Reads the scene file called `name` from its bytes; files that it names come through `door`.
///
/// # Errors
/// [`Error::Input`] for what cannot be read, with the place and the remedy; [`Error::Limit`] for
/// what is over the door's budget.
pub fn read_scene(name: &str, bytes: &[u8], up: Up, door: &mut Door) -> Result<Scene> {
    door.spend("bytes", |b| &mut b.bytes, bytes.len() as u64)?;
    if bytes.is_empty() {
        return Err(Error::input(name, "", "is empty; export the scene again"));
    }
    let (mut scene, said) = match Format::of(name, bytes) {
        Ok(Format::Gltf) => (gltf::read(bytes, door)?, Up::Y),
        Ok(Format::Obj) => obj::read(bytes, door)?,
        Ok(Format::Ply) => ply::read(bytes, door)?,
        Ok(Format::Stl) => (stl::read(bytes, door)?, Up::Z),
        Err(why) => return Err(Error::input(name, "", why)),
    };
    if !scene.meshes.iter().any(has_area) {
        let why = "no geometry is left: there are no triangles with an area; export meshes, not \
                   points, lines or curves";
        return Err(Error::input(name, "", why));
    }
    up::raise(&mut scene, if up == Up::Auto { said } else { up });
    Ok(scene)
}

/// Whether some triangle can be seen, now or in another pose.
fn has_area(mesh: &Mesh) -> bool {
    let area = |t: &[u32; 3]| {
        let [a, b, c] = t.map(|v| mesh.positions[v as usize].as_dvec3());
        (b - a).cross(c - a).length_squared()
    };
    let moves = mesh.remake.is_some() || !mesh.morphs.is_empty() && !mesh.triangles.is_empty();
    moves || mesh.triangles.iter().any(|t| area(t) > 0.0)
}

/// What is read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Format {
    Gltf,
    Obj,
    Ply,
    Stl,
}

impl Format {
    /// The format of a file: what its first bytes say, else its ending; or why it is not read.
    fn of(name: &str, bytes: &[u8]) -> std::result::Result<Self, String> {
        let ending = name.rsplit_once('.').map_or(String::new(), |(_, e)| e.to_ascii_lowercase());
        if bytes.starts_with(b"glTF") {
            return Ok(Self::Gltf);
        }
        if bytes.starts_with(b"ply\n") || bytes.starts_with(b"ply\r") {
            return Ok(Self::Ply);
        }
        if let Some(kind) = foreign(bytes) {
            return Err(unreadable(kind));
        }
        match ending.as_str() {
            "gltf" | "glb" => Ok(Self::Gltf),
            "obj" => Ok(Self::Obj),
            "ply" => Ok(Self::Ply),
            "stl" => Ok(Self::Stl),
            _ => Err(unreadable(&ending)),
        }
    }
}

/// The usual ending of a format that is not read but known by its first bytes.
fn foreign(bytes: &[u8]) -> Option<&'static str> {
    let announced: [(&[u8], &str); 6] = [
        (b"BLENDER", "blend"),
        (b"\x28\xB5\x2F\xFD", "blend"),
        (b"Kaydara FBX Binary", "fbx"),
        (b"PXR-USDC", "usdc"),
        (b"#usda", "usda"),
        (b"Ogawa", "abc"),
    ];
    announced.iter().find(|(magic, _)| bytes.starts_with(magic)).map(|(_, ending)| *ending)
}

/// Why files with this ending are not read, and what to do.
fn unreadable(ending: &str) -> String {
    const EXPORT: &str = "File > Export > glTF 2.0 (.glb/.gltf)";
    const READ: &str = ".gltf, .glb, .obj, .ply and .stl are read";
    match ending {
        "blend" => format!(".blend is not read; in Blender use {EXPORT}"),
        "fbx" | "usd" | "usda" | "usdc" | "usdz" | "abc" | "dae" | "3ds" => {
            format!(".{ending} is not read; in Blender use File > Import, then {EXPORT}")
        }
        "" => format!("has no ending that says what it is; {READ}"),
        _ => format!(".{ending} is not read; {READ}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(name: &str, bytes: &[u8]) -> Result<Scene> {
        read_scene(name, bytes, Up::Auto, &mut Door::new(name, &(), Budget::default()))
    }

    const OBJ: &[u8] = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";

    #[test]
    fn files_are_known_by_content_and_by_ending() {
        let ply = b"ply\nformat ascii 1.0\nelement vertex 3\nproperty int x\nproperty int y\n\
            property int z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n\
            0 0 0 1 0 0 0 1 0 3 0 1 2";
        assert!(read("a.OBJ", OBJ).is_ok());
        assert!(read("a.obj", ply).is_ok() && read("noending", ply).is_ok());
    }

    #[test]
    fn what_is_not_read_says_what_to_do() {
        for (name, bytes, why) in [
            ("a.blend", &b"x"[..], "File > Export > glTF 2.0"),
            ("a.glb", b"BLENDER-v300", "File > Export > glTF 2.0"),
            ("A.FBX", b"x", "File > Export > glTF 2.0"),
            ("a.usdz", b"x", "File > Import"),
            ("a.txt", b"x", ".txt is not read; .gltf"),
            ("a", b"x", "no ending"),
            ("a.obj", b"", "empty"),
            ("a.obj", b"v 0 0 0\np 1\n", "no geometry is left"),
            ("a.obj", b"v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\nf 1 1 2\n", "no geometry is left"),
        ] {
            let error = read(name, bytes).unwrap_err().to_string();
            assert!(error.starts_with(name) && error.contains(why), "{error}");
        }
    }

    #[test]
    fn the_user_knows_best_what_is_up() {
        let turned = |up| {
            let mut door = Door::new("a.obj", &(), Budget::default());
            let scene = read_scene("a.obj", OBJ, up, &mut door).unwrap();
            scene.nodes.len()
        };
        assert_eq!([Up::Auto, Up::Y, Up::Z, Up::NegY].map(turned), [1, 1, 2, 2]);
        assert!(Up::parse("x").is_err());
        assert_eq!(Up::parse("-y").unwrap(), Up::NegY);
    }
}
