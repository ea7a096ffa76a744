//! Readers: untrusted bytes to a [`Scene`].
//!
//! [`read_scene`] picks the reader by the file's first bytes and its ending, turns the scene so that
//! y is up, and refuses what has no geometry.

mod door;
mod gltf;
mod mtl;
mod obj;
mod picture;
mod polygon;

pub use door::{Budget, Door, Source};

use crate::{Node, NodeId, Scene, Transform};
use chiaro_basis::math::{DQuat, DVec3};
use chiaro_basis::{Error, Result};
use std::f64::consts::{FRAC_PI_2, PI};

/// Which way is up in a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Up {
    /// What the file says, else y; STL z.
    #[default]
    Auto,
    /// y.
    Y,
    /// z, as in CAD and most scanners.
    Z,
    /// -y, as in pictures.
    NegY,
}

impl Up {
    /// Reads `y`, `z`, `-y` or `auto`.
    pub fn parse(text: &str) -> Result<Self> {
        match text {
            "auto" => Ok(Self::Auto),
            "y" => Ok(Self::Y),
            "z" => Ok(Self::Z),
            "-y" => Ok(Self::NegY),
            _ => Err(Error::setting("--up", text, "y, z, -y or auto")),
        }
    }
}

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
    let (mut scene, said) = match ending(name).as_str() {
        "gltf" | "glb" => (gltf::read(bytes, door)?, Up::Y),
        "obj" => (obj::read(bytes, door)?, Up::Y),
        other => return Err(Error::input(name, "", unreadable(other))),
    };
    if scene.meshes.iter().all(|m| m.triangles.is_empty() && m.remake.is_none()) {
        let why = "no geometry is left: there are no triangles with an area; export meshes";
        return Err(Error::input(name, "", why));
    }
    raise(&mut scene, if up == Up::Auto { said } else { up });
    Ok(scene)
}

fn ending(name: &str) -> String {
    name.rsplit_once('.').map_or_else(String::new, |(_, e)| e.to_ascii_lowercase())
}

/// Why files with this ending are not read, and what to do.
fn unreadable(ending: &str) -> String {
    let from = match ending {
        "blend" => "in Blender use File > Export > glTF 2.0 (.glb/.gltf)".to_owned(),
        "fbx" | "usd" | "usda" | "usdc" | "usdz" | "abc" | "dae" | "3ds" => format!(
            ".{ending} is not read; in Blender import it, then File > Export > glTF 2.0 (.glb/.gltf)"
        ),
        "" => {
            "has no ending that says what it is; .gltf, .glb, .obj, .ply and .stl are read".into()
        }
        _ => format!(".{ending} is not read; .gltf, .glb, .obj, .ply and .stl are"),
    };
    if ending == "blend" { format!(".blend is not read; {from}") } else { from }
}

/// Turns the scene below a new root, so that y is up.
fn raise(scene: &mut Scene, up: Up) {
    let rotation = match up {
        Up::Auto | Up::Y => return,
        Up::Z => DQuat::from_rotation_x(-FRAC_PI_2),
        Up::NegY => DQuat::from_rotation_x(PI),
    };
    let transform = Transform::Parts { translation: DVec3::ZERO, rotation, scale: DVec3::ONE };
    let shifted = |id: NodeId| NodeId::new(id.index() + 1);
    for node in &mut scene.nodes {
        node.parent = Some(node.parent.map_or(NodeId::new(0), shifted));
    }
    scene.nodes.insert(0, Node { name: "up".into(), transform, ..Node::default() });
    scene.cameras.iter_mut().for_each(|c| c.node = shifted(c.node));
    scene.lights.iter_mut().for_each(|l| l.node = shifted(l.node));
    scene.skins.iter_mut().flat_map(|s| &mut s.joints).for_each(|j| *j = shifted(*j));
    let channels = scene.clips.iter_mut().flat_map(|c| &mut c.channels);
    channels.for_each(|c| c.node = shifted(c.node));
}
