//! Animated 3D scenes: meshes, materials, lights, cameras, tracks, loaders and procedural scenes.
//!
//! A [`Scene`] is what a file says, normalized once: whatever the format, past the loaders there
//! are only triangles, nodes, clips and linear colours. A [`Frame`] is the scene frozen at a time,
//! with the same vertex, triangle and object ids at every time.
//!
//! ```text
//! bytes --load--> Scene --playback, time--> Frame
//! ```
//!
//! Space is right-handed with y up, in scene units; time is in seconds; colours are linear RGB.

mod camera;
mod cloud;
pub mod demo;
mod frame;
mod lens;
mod light;
pub mod load;
mod material;
mod mesh;
mod node;
pub mod normals;
mod playback;
mod pose;
mod scene;
pub mod topology;
mod track;

pub use camera::{Camera, Pose, Projection};
pub use frame::{Frame, Object, Shape};
pub use lens::Lens;
pub use light::{Light, LightKind};
pub use material::{Alpha, Filter, Material, Texture, TextureUse, Wrap};
pub use mesh::{Influences, Mesh, Morph, NormalSource, Remake};
pub use node::{Node, Skin, Transform};
pub use playback::{Choice, Playback};
pub use pose::Poser;
pub use scene::{Bounds, MaterialId, MeshId, NodeId, Scene, SkinId, Stored, TextureId};
pub use track::{Channel, Clip, Interpolation, Property, Track};
